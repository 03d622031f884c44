"""The page of published thresholds: what they are, and where they come from."""

from __future__ import annotations

from haptisym.model.published import Published
from haptisym.verbs.jnd.published import PublishedThresholds
from haptisym.writing.document import Code, Column, Document, Notes, Paragraph, Phrase, Section, Table


def page(found: PublishedThresholds) -> Document:
    """The whole page."""
    columns = Column("name"), Column("JND"), Column("criterion"), Column("of what")
    rows = tuple((Code(x.name), x.written.replace(" %", "\xa0%"), _criterion(x), x.quantity) for x in found)
    named = next(x.name for x in found if x.criterion)
    lead = "By its name in a scene: ", Code(f'jnd = {{ like = "{named}" }}'), "; a range gives a range of bandwidths."
    blocks = (
        Table(
            columns, rows, "Published thresholds, and the share of answers at which each was taken where that is known."
        ),
        Section("Sources, and how far they were read", (Notes(tuple(map(_source, found))),)),
        Paragraph(_DIFFER),
    )
    return Document("Published thresholds", (lead,), blocks, "Just-noticeable differences")


_DIFFER = "They differ by what was felt, by whom, by movement and criterion. None of them was measured on your display."


def _criterion(x: Published) -> str:
    return "" if x.criterion is None else f"{float(100 * x.criterion):g}\xa0%"


def _source(x: Published) -> Phrase:
    doi = f", doi:{x.doi}" if x.doi else ""
    apart = f". Not for a scene: {x.apart}" if x.apart else ""
    return Code(x.name), f": {x.source}{doi} [{x.read}]; {x.reference}{apart}."
