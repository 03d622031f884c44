"""What accuracy costs, as a page of text: a sentence, a table for each question, and what was measured on what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isinf
from textwrap import fill

from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.measurement import Omission, Row
from haptisym.verbs.cost.summary import duration, wrong

WIDTH = 96
TASKS = {
    "evaluate": "The ratios r_r and r_i: time for one frequency",
    "crossings": "The crossings on the band: time for all of them",
    "delay": "The crossings with approximated delays, against the exact ones",
    "effects": "The crossings with an effect left out, against all effects",
    "simulation": "H_perc recovered from a simulation in time, against the closed form",
}
"""What each task asks."""


def page(found: Cost) -> str:
    """The whole page."""
    tables = [_table(task, found.task(task), found.condition.get(task)) for task in TASKS if found.task(task)]
    said = f"{found.scene.title or 'Untitled scene'}: what accuracy costs"
    heading = "\n".join(fill(line, WIDTH) for line in (said, *found.asides()))
    return "\n\n".join([heading, fill(found.summary, WIDTH), *tables, _notes(found.left_out, found.machine)]) + "\n"


def _table(task: str, rows: Sequence[Row], condition: float | None) -> str:
    width = max(len(row.method) for row in rows)
    title = TASKS[task] + ("" if condition is None else f" (condition number {_size(condition)})")
    head = f"  {'method':<{width}}  {'right digits':>12}  {'time':>9}  proven"
    lines = [
        f"  {row.method:<{width}}  {shown_digits(row):>12}  {duration(row.seconds):>9}  "
        f"{'yes' if row.proven else 'no':<6}  {wrong(row)}".rstrip()
        for row in rows
    ]
    return "\n".join([title, "", head, *lines])


def shown_digits(row: Row) -> str:
    """Right digits as they are told: those of nothing, where a count is wrong, say nothing."""
    return f"{row.digits:.1f}" if row.digits < 20 else f"{row.digits:.0f}"


def _size(condition: float) -> str:
    return "infinite: a touch" if isinf(condition) else f"{condition:.2g}"


def _notes(left_out: Sequence[Omission], machine: Mapping[str, str]) -> str:
    proof = (
        "Right digits are those of the worst number, held against a certified reference of higher precision. Times are medians "
        "of repeats in turns; the equations are given to all. Ratios of times travel between machines, times do not."
    )
    omitted = [f"Left out: {x.method} ({x.reason})." for x in left_out]
    measured = "Measured on " + ", ".join(f"{name} {value}" for name, value in machine.items()) + "."
    return "\n".join(fill(text, WIDTH) for text in (proof, *omitted, measured))
