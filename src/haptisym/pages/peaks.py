"""The page of peaks: where each ratio is largest inside the band, and how large."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.peaks import Peak, Peaks
from haptisym.pages.evaluation import joint
from haptisym.pages.words import OMEGA, certainty, exactly, hertz, noted, page_about, symbol
from haptisym.writing.document import Block, Column, Document, Number, Paragraph, Phrase, Section, Strong, Table, listed

_DIGITS = 15


def page(found: Peaks) -> Document:
    """The whole page."""
    blocks = (_listed(found), Paragraph(_certain(found)))
    return page_about(found.scene, blocks, "Peaks of the ratios", found.asides())


def _listed(found: Peaks) -> Block:
    if not found:
        return Paragraph("No ratio has a local maximum inside the band.")
    numbers = (OMEGA, " (rad/s)"), "Hz", "value"
    columns = Column("ratio"), *(Column(x, number=True) for x in numbers)
    table = Table(columns, tuple(map(_row, found)), "All local maxima of the ratios inside the band.")
    return Section("Where a ratio is larger than on either side", (table, *noted(_remarks(found))))


def _row(x: Peak) -> tuple[Phrase, ...]:
    what = (symbol(x.criterion.symbol), " over its limit" if x.in_limits and x.part else "")
    return what, exactly(x.omega, _DIGITS), hertz(x.omega), exactly(x.ratio, 6)


def _remarks(found: Peaks) -> Iterator[Phrase]:
    region = joint(x.criterion for x in found)
    if region:
        yield "The value is how many times the ", region.kind, " must be enlarged to hold the distortion."
    for x in found:
        if x.jump:
            drops = " rad/s the limit changes: the ratio comes as near to the value as one likes, and drops."
            yield "At ", exactly(x.omega, 6), drops


def _certain(found: Peaks) -> Phrase:
    if found.undecided:
        where = listed(Number(x.digits(6), float(x)) for x in found.undecided)
        open_ = " at the precision limit: whether a slope changes its sign at "
        return Strong("UNDECIDED"), open_, where, " rad/s. All others are proven."
    return certainty(
        found.scene,
        "Certain: these are all of them inside the band, none is missed and none invented; every digit is proven.",
    )
