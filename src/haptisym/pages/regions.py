"""Other JND models on a page: what square, disc and diamond of the same half widths say, beside the scene's own region.

Of one environment, and of several: what each model says of every one of them, and of all together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.spread import Compared
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart
from haptisym.pages.crossings import event
from haptisym.pages.late import drawing
from haptisym.pages.words import exactly, limits, short
from haptisym.writing.document import Block, Column, Paragraph, Phrase, Section, Table, listed

if TYPE_CHECKING:
    from haptisym.verbs.family.entry import FamilyEvaluation
    from haptisym.verbs.family.regions import FamilyCompared

_SURVIVES = "Does it survive another JND model?"
_PLANE = (
    "The distortion relative to the environment over the band, and the regions within which it is not noticed; a dot where it "
    "first meets the border of each. A region that depends on the frequency is drawn as it is there, or else at the high end."
)
_WIDTHS = "Bandwidth of each environment, and of all together, by JND region; none: no transparent band starts at the low end."
_KINDS = {"disc": "disc"}
"""Of a region that is more than its shape says."""


def regions(e: Evaluation) -> Iterator[Block]:
    """A sentence that says how far the models are apart, a row for each, and a drawing; nothing where that was not asked."""
    if not e.regions:
        return
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth (rad/s)", number=True),
        Column("first crossing (rad/s)", number=True), Column("what happens there"),
    )  # fmt: skip
    table = Table(columns, tuple(_row(e, x) for x in e.regions), "Bandwidth and first crossing by region, proven.")
    figure = drawing("regions", _PLANE, "files:draw_figure", e, "regions")
    yield Section(_SURVIVES, (Paragraph(_spread(e.regions)), table, figure), "regions")


def _row(e: Evaluation, x: Compared) -> tuple[Phrase, ...]:
    crossing = x.crossing
    first: tuple[Phrase, Phrase] = ("none", "")
    if crossing is not None:
        first = exactly(crossing.omega, e.digits), event(crossing, _KINDS.get(x.name))
    return x.name, limits(x.threshold), _width(e.chart, x.bandwidth, e.digits), *first


def family_regions(w: FamilyEvaluation) -> Iterator[Block]:
    """How far the models are apart in the worst case, a row for each, and a row for each environment."""
    if not w.regions:
        return
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth (rad/s)", number=True), Column("who binds"),
    )  # fmt: skip
    worst = Table(columns, tuple(_worst(w, x) for x in w.regions), "Common bandwidth by region, and who binds, proven.")
    by_name = Column("environment"), *(Column(x.name, number=True) for x in w.regions)
    rows = [(name, *(_width(w.chart, x.answers[name].bandwidth) for x in w.regions)) for name in w.family]
    rows.append(("all", *(_width(w.chart, x.bandwidth) for x in w.regions)))
    each = Table(by_name, tuple(rows), "Bandwidth of each environment by region (rad/s), proven.")
    figure = drawing("regions", _WIDTHS, "regions:family_regions_figure", w)
    yield Section(_SURVIVES, (Paragraph(_spread(w.regions, "common bandwidth")), worst, each, figure), "regions")


def _worst(w: FamilyEvaluation, x: FamilyCompared) -> tuple[Phrase, ...]:
    who = listed(f"{y.environment} ({y.criterion.name})" for y in x.first)
    return x.name, limits(x.threshold), _width(w.chart, x.bandwidth, w.digits), who


def _width(chart: Chart, x: RealNumber | None, digits: int = 0) -> Phrase:
    """A bandwidth as a cell has it; ``digits`` : so many, or a few."""
    if x is None:
        return "none"
    if float(x) == float(chart.points[-1].omega):
        return "whole band"
    return exactly(x, digits) if digits else short(x)


def _spread(found: Sequence[Compared | FamilyCompared], what: str = "bandwidth") -> Phrase:
    """How far apart the bandwidths are; ``what`` : as they are called."""
    widths = [x.bandwidth for x in found if x.bandwidth is not None]
    if not widths:
        return f"No region gives a {what}: that survives another JND model."
    least, most = min(widths, key=float), max(widths, key=float)
    between = short(least), " and ", short(most), " rad/s"
    if len(widths) < len(found):
        return f"Whether there is a {what} depends on the JND model; where there is, it lies between ", *between, "."
    if float(least) == float(most):
        return f"All regions give the same {what}, ", short(most), " rad/s."
    times = f": the largest is {float(most) / float(least):.3g} times the smallest." if float(least) else "."
    return f"By these regions the {what} lies between ", *between, times
