"""The page of the hard cases: a section for each family, a line in it for each method."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf
from statistics import median

from haptisym.pages.cost import measured_on
from haptisym.verbs.cost.hardcases import FAMILIES
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.cost.measurement import HardRow
from haptisym.verbs.cost.summary import duration, worst_verdict
from haptisym.writing.document import Block, Column, Document, Figure, Number, Paragraph, Phrase, Section, Table

_TOLD = (
    "Right: to the digits that the method's numbers hold but for one, and no crossing missed or invented. Digits are "
    "those of the worst case, times medians over the cases. The condition number says how much an answer changes, "
    "relatively, with the frequency or the threshold; what a method loses beyond its logarithm is the method's own loss."
)


def page(found: HardCosts) -> Document:
    """The whole page."""
    groups = {name: [row for row in found.rows if row.family == name] for name in FAMILIES}
    families = (_family(name, rows) for name, rows in groups.items() if rows)
    shown = "How many questions of each family each method answers right; the darker the fewer. Filled marks: proven."
    figure = Figure("hard-cases", shown, found.figure, wide=True)
    blocks = Paragraph(found.summary), *families, figure, Paragraph(_TOLD), Paragraph(measured_on(found.machine))
    return Document("The hard cases", (), blocks)


def _family(family: str, rows: Sequence[HardRow]) -> Block:
    cases = dict.fromkeys(row.case for row in rows)
    hardest = max(row.condition for row in rows)
    condition = "infinity" if isinf(hardest) else f"{hardest:.2g}"
    asks = "values of r_r and r_i" if rows[0].task == "evaluate" else "crossings"
    counted = f"{len(cases)} question{'s' * (len(cases) > 1)} about {asks}, condition number up to {condition}"
    columns = (
        Column("method"), Column("right"), Column("digits", number=True), Column("time"), Column("proven"), Column(""),
    )  # fmt: skip
    methods = dict.fromkeys(row.method for row in rows)
    table = Table(columns, tuple(_row([x for x in rows if x.method == method]) for method in methods), f"{family}.")
    return Section(f"{family}: {FAMILIES[family]}", (Paragraph(f"{counted}."), table))


def _row(rows: Sequence[HardRow]) -> tuple[Phrase, ...]:
    answered = [row for row in rows if row.answered]
    if not answered:
        return rows[0].method, "", "", "", "", rows[0].verdict
    right = sum(row.verdict == "right" for row in answered)
    worst = min(row.digits for row in answered)
    proven = "yes" if all(row.proven for row in answered) else "no"
    time = duration(median(row.seconds for row in answered))
    return (
        rows[0].method,
        f"{right}/{len(answered)}",
        Number(f"{worst:.1f}", worst),
        time,
        proven,
        worst_verdict(answered),
    )
