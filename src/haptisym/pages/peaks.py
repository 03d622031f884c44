"""The page of peaks: where each ratio is largest inside the band, and how large."""

from __future__ import annotations

from collections.abc import Iterator

from haptisym.judge.peaks import Peak, Peaks
from haptisym.pages.evaluation import joint
from haptisym.pages.words import both, cell, near, noted, page_about, proof, symbol, undecided
from haptisym.writing.document import FREQUENCY, Block, Column, Document, Paragraph, Phrase, Section, Table, listed


def page(found: Peaks) -> Document:
    """The whole page."""
    return page_about(found.scene, (), (_listed(found),), _proven(found), "Peaks of the ratios", found.asides())


def _listed(found: Peaks) -> Block:
    if not found:
        return Paragraph("No ratio has a local maximum inside the band.")
    columns = Column("ratio"), Column(FREQUENCY, number=True, hertz=True), Column("value", number=True)
    table = Table(columns, tuple(map(_row, found)), "All local maxima of the ratios inside the band.")
    return Section("Where a ratio is larger than on either side", (table, *noted(_remarks(found))))


def _row(x: Peak) -> tuple[Phrase, ...]:
    what = (symbol(x.criterion.symbol), " over its limit" if x.in_limits and x.part else "")
    return what, cell(x.omega), near(x.ratio)


def _remarks(found: Peaks) -> Iterator[Phrase]:
    region = joint(x.criterion for x in found)
    if region:
        yield "The value is how many times the ", region.kind, " must be enlarged to hold the distortion."
    for x in found:
        if x.jump:
            yield "At ", both(x.omega), " the limit changes: the ratio comes arbitrarily near to the value, and drops."


def _proven(found: Peaks) -> Iterator[Phrase]:
    if found.undecided:
        yield undecided(
            ("whether a slope changes its sign at ", listed(map(both, found.undecided)), ", at the precision limit")
        )
        yield "Proven: all others."
    else:
        yield proof(found.scene, "all local maxima inside the band, and all digits printed")
