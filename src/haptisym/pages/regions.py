"""Other JND models on a page: what square, disc and diamond of the same half widths say, beside the scene's own region."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.spread import Compared
from haptisym.pages.crossings import event
from haptisym.pages.words import exactly, limits, short
from haptisym.verbs.family.regions import FamilyCompared
from haptisym.writing.document import Block, Column, Paragraph, Phrase, Table

REGIONS = (
    "The distortion relative to the environment over the band, and the regions within which it is not noticed; a dot where it "
    "first meets the border of each. A region that depends on the frequency is drawn as it is there, or else at the high end."
)
_KINDS = {"disc": "disc"}
"""Of a region that is more than its shape says."""


def regions(e: Evaluation) -> Iterator[Block]:
    """A sentence that says how far the models are apart, and a row for each."""
    yield Paragraph(spread(e.regions))
    columns = (
        Column("region"), Column("what it is", full=True), Column("bandwidth (rad/s)", number=True),
        Column("first crossing (rad/s)", number=True), Column("what happens there"),
    )  # fmt: skip
    yield Table(columns, tuple(_row(e, x) for x in e.regions), "Bandwidth and first crossing by region, proven.")


def _row(e: Evaluation, x: Compared) -> tuple[Phrase, ...]:
    width: Phrase = (
        "none" if x.bandwidth is None else "whole band" if _is_whole(e, x) else exactly(x.bandwidth, e.digits)
    )
    first: Phrase = "none" if x.crossing is None else exactly(x.crossing.omega, e.digits)
    return (
        x.name,
        limits(x.threshold),
        width,
        first,
        "" if x.crossing is None else event(x.crossing, _KINDS.get(x.name)),
    )


def _is_whole(e: Evaluation, x: Compared) -> bool:
    return x.bandwidth is not None and float(x.bandwidth) == float(e.chart.points[-1].omega)


def spread(found: Sequence[Compared | FamilyCompared], what: str = "bandwidth") -> Phrase:
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
