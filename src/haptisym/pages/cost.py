"""The page of what accuracy costs: a sentence, a table for each question, and what was measured on what."""

from __future__ import annotations

from collections.abc import Mapping
from math import isinf

from haptisym.model.jnd import Part
from haptisym.pages.words import RATIOS, lead, title
from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.measurement import Measurement
from haptisym.verbs.cost.summary import duration, not_reached, share_wrong, wrong
from haptisym.writing.document import Block, Column, Document, Figure, Notes, Number, Paragraph, Phrase, Section, Table
from haptisym.writing.names import named

_RATIOS = "The ratios ", RATIOS[Part.REAL], " and ", RATIOS[Part.IMAG]
TASKS: dict[str, Phrase] = {
    "evaluate": (_RATIOS, ": time for one frequency"),
    "crossings": "The crossings on the band: time for all of them",
    "delay": "The crossings with approximated delays, against the exact ones",
    "effects": "The crossings with an effect left out, against all effects",
    "sweep": "A sweep over sets of parameters: time for a set",
    "simulation": (named("H_perc"), " recovered from a simulation in time, against the closed form"),
}
"""What each task asks."""


def page(found: Cost) -> Document:
    """The whole page."""
    tables = (_table(found, task) for task in TASKS if found.task(task))
    proof = (
        "Right digits are those of the worst number, held against a certified reference of higher precision. Times are medians "
        "of repeats in turns; the equations are given to all. Ratios of times travel between machines, times do not."
    )
    omitted = (f"Left out: {x.method} ({x.reason})." for x in found.left_out)
    late = (f"{x.method}: {not_reached(x)}." for x in found.rows if x.left_open)
    notes = Notes((proof, *late, *omitted, measured_on(found.machine)))
    shown = "Right digits against time for each question; filled marks are proven."
    blocks = Paragraph(found.summary), *tables, Figure("cost", shown, found.figure, wide=True), notes
    return Document(f"{title(found.scene)}: what accuracy costs", lead(found.scene, found.asides()), blocks)


def measured_on(machine: Mapping[str, str]) -> str:
    """On what it was measured."""
    return "Measured on " + ", ".join(f"{name} {value}" for name, value in machine.items()) + "."


def _table(found: Cost, task: str) -> Block:
    size = found.condition.get(task)
    condition = "" if size is None else f" (condition number {'infinite: a touch' if isinf(size) else f'{size:.2g}'})"
    last = Column("sets with a wrong count" if task == "sweep" else "")
    columns = Column("method"), Column("right digits", number=True), Column("time"), Column("proven"), last
    return Section((TASKS[task], condition), (Table(columns, tuple(map(_row, found.task(task))), (TASKS[task], ".")),))


def _row(row: Measurement) -> tuple[Phrase, ...]:
    digits = Number(f"{row.digits:.{int(row.digits < 20)}f}", row.digits)
    return row.method, digits, duration(row.seconds), "yes" if row.proven else "no", share_wrong(row) or wrong(row)
