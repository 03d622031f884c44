"""The page of a map of two parameters: its exact slices, what is proven between them, and what is estimated there."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from haptisym.pages.require import heading, sets, unit_of
from haptisym.pages.words import certainty, page_about, rounded, rounded_up, rule, short
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.required import STABLE, Requirement
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Number,
    Paragraph,
    Phrase,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named

_WORDS = {"transparent": "transparent", "stable": "stable", "passive": "fit for every passive hand"}
_MOST_ROWS = 10  # of slices that are listed; the document of JSON has them all


def page(m: DesignMap) -> Document:
    """The page of a map: how many slices hold values that will do, some of them, what is certain."""
    a, b = m.free
    some = [x for x in m.slices if x.requirement.feasible]
    kinds = sorted({y.kind.value for x in some for e in x.requirement.ends for y in e.bindings})
    said = (
        f"{len(m.slices)} exact slices along ", named(a.symbol.name), f": {len(some)} of them hold values of ",
        named(b.symbol.name), " that make the display ", listed(dict.fromkeys(x.kept for x in m.criteria)), ".",
        (" What binds at the boundary: ", listed(kinds), ".") if kinds else "",
    )  # fmt: skip
    certain: Phrase = (
        certainty(m.scene, "Certain: every value of a slice is proven.")
        if m.certified
        else (Strong("UNDECIDED"), " in some slices", _why(m), ": see --json.")
    )
    last = certain, " ", _between(m)
    shown = "Values that will do, along exact slices, with what binds at their ends."
    figure = Figure("map", shown, m.figure)
    table = _slices(m)
    left = len(m.slices) - len(table.rows)
    more: Phrase = f" Listed here: {len(table.rows)} of the slices; the others are in --json." if left else ""
    beside = *_stiffest(m), *_contours(m), *_classical(m)
    blocks = Facts(tuple(_wished(m))), Paragraph((*said, more)), table, *beside, figure, Paragraph(last), *_proven(m)
    return page_about(m.scene, blocks, "Which values will do", m.asides())


def _why(m: DesignMap) -> str:
    """For lack of time, or for which other reasons, something was left open."""
    sets = [r for x in m.slices for r in x.sets if r.undecided]
    late = ", for which there was no time left" if any(r.limit is not None for r in sets) else ""
    return late + "".join(f" ({x})" for x in dict.fromkeys(r.reason for r in sets) if x)


def _wished(m: DesignMap) -> Iterator[tuple[str, Phrase]]:
    judged = [x for x in m.criteria if x.name not in ("stable", "passive")]
    others = [x.rule for x in m.criteria if x not in judged]
    first = (listed(map(rule, judged)), " on the whole band") if judged else ""
    yield "condition", (first, "; " if judged and others else "", "; ".join(others))


def _between(m: DesignMap) -> Phrase:
    """What is said between slices: an estimate, and where not even that."""
    off: Phrase = ""
    if m.deviation is not None:
        share = f" ({100 * m.deviation / m.height:.2g}\xa0% of the range)"
        most = Number(rounded_up(m.deviation), m.deviation)
        how = " at the most, as estimated from how its boundary bends at the slices"
        off = " by ", most, unit_of(m.free[1]), share, how
    apart = sum(1 for x in m.gaps if x.deviation is None)
    pairs = "one pair" if apart == 1 else f"{apart} pairs"
    others = f" Between {pairs} of slices, which differ in kind or are undecided, nothing is said." if apart else ""
    more = " --slices N gives more of them." if m.is_coarse or m.within is None else ""
    return "Between slices the figure draws straight lines, off", off, "; that is not proven.", others, more


def _proven(m: DesignMap) -> Iterator[Block]:
    """Of what is transparent, or stable, what is proven between the slices too."""
    for x in m.proofs:
        what = listed(y.kept for y in m.criteria if y.name == x.of) if x.of == STABLE else x.of
        threshold = "" if x.jnd is None else f" with a threshold of {float(100 * x.jnd):.6g}\xa0%"
        most = m.bound(x)
        near: Phrase = ""
        if most:
            part = f" ({rounded_up(100 * most / m.height)}\xa0% of the range)"
            far = Number(rounded_up(most), most), unit_of(m.free[1]), part
            near = " Where lines join slices, its boundary lies within ", far, " of them, or of an end of the range."
        share = rounded_up(100 * x.rectangles.share_left)
        left = f"{share}\xa0% of the area of the map, which is left open and holds its boundary."
        said = "Proven for all values of both, between slices too: what is ", what, threshold
        yield Paragraph((*said, ", and what is not, but for ", left, near))


def _stiffest(m: DesignMap) -> Iterator[Block]:
    """Of a map along a wall's damping, the stiffest wall."""
    if m.stiffest is None:
        return
    at, top = m.stiffest
    b, k = m.free
    yield Paragraph((
        "The stiffest wall of these slices that is ", listed(x.kept for x in m.criteria if x.name == "stable"), " stays below ",
        named(k.symbol.name), " = ", short(top), unit_of(k), ", at ", named(b.symbol.name), " = ",
        rounded(float(at.at), 6), unit_of(b), ".",
    ))  # fmt: skip


def _contours(m: DesignMap) -> Iterator[Block]:
    """On how many slices something is transparent with each of the other thresholds."""
    for i, jnd in enumerate(m.thresholds):
        own = [x.contours[i] for x in m.slices]
        held = sum(1 for r in own if r.feasible)
        left = "" if all(r.certified for r in own) else ", others being undecided"
        words = f" of {float(100 * jnd):.6g}\xa0% {held} of them hold values that are not noticed{left}."
        yield Paragraph(("With a threshold", words))


def _classical(m: DesignMap) -> Iterator[Block]:
    """The classical bounds that the figure has beside what is exact, and what each takes for granted."""
    if m.lines:
        yield Paragraph("Beside the exact sets the figure has classical bounds, which are drawn and not proven:")
        yield Facts(tuple((x.name, f"{x.rule} ({x.assumes})") for x in m.lines))


def _of_slice(r: Requirement) -> Phrase:
    return Strong("UNDECIDED") if r.undecided and not r.feasible else sets(r)


def _slices(m: DesignMap) -> Table:
    """Some of the slices, the first and the last one among them."""
    step = ceil((len(m.slices) - 1) / _MOST_ROWS)
    some = [*m.slices[:-1:step], m.slices[-1]]
    rows = [(float(x.at), _of_slice(x.requirement)) for x in some]
    columns = (
        Column(heading(m.free[0]), number=True),
        Column("will do" if len(m.that) > 1 else f"{_WORDS[m.that[0]]} for"),
    )
    caption = ("Some of the slices" if len(some) < len(m.slices) else "The slices") + ", proven."
    return Table(columns, tuple((rounded(at, 6), found) for at, found in rows), caption)
