"""What accuracy costs, as a page of text: a sentence, a table for each question, and what was measured on what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isinf
from textwrap import fill

from haptisym.model.scene import Scene
from haptisym.verbs.cost.measurement import Omission, Row

WIDTH = 96
TASKS = {
    "evaluate": "The ratios r_r and r_i: time for one frequency",
    "crossings": "The crossings on the band: time for all of them",
    "delay": "The crossings with approximated delays, against the exact ones",
    "effects": "The crossings with an effect left out, against all effects",
    "simulation": "H_perc recovered from a simulation in time, against the closed form",
}
"""What each task asks."""


def page(
    scene: Scene,
    rows: Sequence[Row],
    left_out: Sequence[Omission],
    condition: Mapping[str, float],
    machine: Mapping[str, str],
) -> str:
    """The whole page."""
    tables = [
        _table(task, [row for row in rows if row.task == task], condition.get(task))
        for task in TASKS
        if any(row.task == task for row in rows)
    ]
    said = f"{scene.title or 'Untitled scene'}: what accuracy costs"
    heading = "\n".join(fill(line, WIDTH) for line in (said, *scene.asides()))
    return "\n\n".join([heading, fill(summary(rows), WIDTH), *tables, _notes(left_out, machine)]) + "\n"


def summary(rows: Sequence[Row]) -> str:
    """What a digit costs, in a sentence."""
    proven = sorted((x for x in rows if x.task == "crossings" and x.proven), key=lambda x: x.digits)
    if len(proven) < 2:
        return _best(rows)
    first, last = proven[0], proven[-1]
    each = (last.seconds - first.seconds) / (last.digits - first.digits)
    grids = [x for x in rows if x.task == "crossings" and x.method.startswith("grid") and x.method[-1].isdigit()]
    finest = max(grids, key=lambda x: x.seconds, default=None)
    price = f"{duration(each)} a digit" if each > 0 else "no time that shows"
    return (
        f"Here all crossings, proven, to {first.digits:.0f} digits take {duration(first.seconds)}; more digits cost {price}: "
        f"{last.digits:.0f} of them take {duration(last.seconds)}" + (f"; {_grid(finest)}" if finest else "") + "."
    )


def _grid(row: Row) -> str:
    if not row.complete:
        return f"a {row.method} points takes {duration(row.seconds)} and {wrong(row)}"
    return f"a {row.method} points takes {duration(row.seconds)} for {row.digits:.1f} digits, and proves nothing"


def _best(rows: Sequence[Row]) -> str:
    best = max((x for x in rows if x.complete), key=lambda x: x.digits, default=None)
    if best is None:
        return "Here no method found all crossings and no others."
    low = min((x for x in rows if x.complete), key=lambda x: x.seconds)
    return (
        f"Here {best.digits:.1f} digits take {duration(best.seconds)} ({best.method}), and the fastest way gives "
        f"{low.digits:.1f} digits in {duration(low.seconds)} ({low.method})."
    )


def wrong(row: Row) -> str:
    """What is wrong with a count of crossings; "" where nothing is."""
    parts = [f"{word} {n}" for word, n in (("misses", row.missed), ("invents", row.invented)) if n]
    return " and ".join(parts)


def duration(seconds: float) -> str:
    """A time with three digits and a readable unit.

    >>> duration(0.00123456), duration(3.2e-7)
    ('1.23 ms', '320 ns')
    """
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= unit:
            return f"{float(f'{seconds / unit:.3g}'):g} {name}"
    return f"{float(f'{seconds / 1e-9:.3g}'):g} ns"


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
