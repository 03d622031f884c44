"""The hard cases as a page of text: a block for each family, a line in it for each method."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf
from statistics import median
from textwrap import fill

from haptisym.pages.cost import WIDTH
from haptisym.verbs.cost.hardcases import FAMILIES
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.cost.measurement import HardRow
from haptisym.verbs.cost.summary import duration, worst_verdict


def page(found: HardCosts) -> str:
    """The whole page."""
    rows = found.rows
    families = [name for name in FAMILIES if any(row.family == name for row in rows)]
    blocks = [_block(name, [row for row in rows if row.family == name]) for name in families]
    measured = "Measured on " + ", ".join(f"{name} {value}" for name, value in found.machine.items()) + "."
    told = (
        "Right: to the digits that the method's numbers hold but for one, and no crossing missed or invented. Digits are "
        "those of the worst case, times medians over the cases. The condition number says how much an answer changes, "
        "relatively, with the frequency or the threshold; what a method loses beyond its logarithm is the method's own loss."
    )
    return (
        "\n\n".join(["The hard cases", fill(found.summary, WIDTH), *blocks, fill(told, WIDTH), fill(measured, WIDTH)])
        + "\n"
    )


def _block(family: str, rows: Sequence[HardRow]) -> str:
    cases = dict.fromkeys(row.case for row in rows)
    hardest = max(row.condition for row in rows)
    condition = "infinite" if isinf(hardest) else f"{hardest:.2g}"
    asks = "values of r_r and r_i" if rows[0].task == "evaluate" else "crossings"
    title = fill(f"{family}: {FAMILIES[family]}", WIDTH)
    counted = f"{len(cases)} question{'s' * (len(cases) > 1)} about {asks}, condition number up to {condition}"
    methods = list(dict.fromkeys(row.method for row in rows))
    lines = [_line([row for row in rows if row.method == method]) for method in methods]
    head = f"  {'method':<24}  {'right':>7}  {'digits':>6}  {'time':>8}  proven"
    return "\n".join([title, counted, "", head, *lines])


def _line(rows: Sequence[HardRow]) -> str:
    name = f"  {rows[0].method:<24}  "
    answered = [row for row in rows if row.answered]
    if not answered:
        return f"{name}{rows[0].verdict}"
    right = sum(row.verdict == "right" for row in answered)
    worst = min(row.digits for row in answered)
    proven = "yes" if all(row.proven for row in answered) else "no"
    time = duration(median(row.seconds for row in answered))
    told = f"{name}{f'{right}/{len(answered)}':>7}  {worst:>6.1f}  {time:>8}  {proven:<6}"
    return f"{told}  {worst_verdict(answered)}".rstrip()
