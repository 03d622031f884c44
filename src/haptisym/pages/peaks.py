"""The page of peaks: where each ratio is largest inside the band, and how large."""

from __future__ import annotations

from haptisym.judge.peaks import Peak, Peaks
from haptisym.pages.words import OMEGA, exactly, hertz, lead, symbol, title
from haptisym.writing.document import Block, Column, Document, Number, Paragraph, Phrase, Section, Strong, Table, listed

_DIGITS = 15


def page(found: Peaks) -> Document:
    """The whole page."""
    blocks = (_listed(found), Paragraph(_certain(found)))
    return Document(title(found.scene), lead(found.scene, found.asides()), blocks, "Peaks of the ratios")


def _listed(found: Peaks) -> Block:
    if not found:
        return Paragraph("No ratio has a local maximum inside the band.")
    columns = (
        Column("ratio"),
        Column((OMEGA, " (rad/s)"), number=True),
        Column("Hz", number=True),
        Column("value", number=True),
    )
    table = Table(columns, tuple(map(_row, found)), "All local maxima of the ratios inside the band.")
    return Section("Where a ratio is larger than on either side", (table,))


def _row(x: Peak) -> tuple[Phrase, ...]:
    return symbol(x.criterion.symbol), exactly(x.omega, _DIGITS), hertz(x.omega), exactly(x.ratio, 6)


def _certain(found: Peaks) -> Phrase:
    if found.undecided:
        where = listed(Number(x.digits(6), float(x)) for x in found.undecided)
        return (
            Strong("UNDECIDED"),
            " at the precision limit: whether a slope changes its sign at ",
            where,
            " rad/s. All others are proven.",
        )
    return "Certain: these are all of them inside the band, none is missed and none invented; every digit is proven."
