"""The page of a map of two parameters: its exact slices, what is proven between them, and what is estimated there."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from haptisym.kernel.reals import Way, in_unit
from haptisym.pages.require import heading, kept, required, sets
from haptisym.pages.words import at_most, near, noted, page_about, proof, undecided, value_of
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.required import STABLE, Requirement
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Facts,
    Figure,
    Paragraph,
    Phrase,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import named

_MOST_ROWS = 10  # of slices that are listed; the document of JSON has them all


def page(m: DesignMap) -> Document:
    """The page of a map: where values satisfy what is required, some of its slices, what is proven."""
    shown = "Values that satisfy what is required, along exact slices, with what limits them at their ends."
    table = _slices(m)
    left = len(m.slices) - len(table.rows)
    more = [f"Printed: {len(table.rows)} of {len(m.slices)} slices; --json has all."] if left else []
    blocks = (
        table,
        *noted(more),
        *_stiffest(m),
        *_contours(m),
        *_classical(m),
        Figure("map", shown, m.figure),
        *_between(m),
    )
    return page_about(
        m.scene, _answer(m), blocks, (*_slices_proven(m), *_proven(m)), "Which values satisfy it", m.asides()
    )


def _answer(m: DesignMap) -> Iterator[tuple[Phrase, Phrase]]:
    a, b = m.free
    some = [x for x in m.slices if x.requirement.feasible]
    what = required(m.criteria)
    on: Phrase = (f"on {len(some)} of {len(m.slices)} slices along ", named(a.symbol.name))
    if some:
        ends = [value_of(a, float(x.at), Way.NEAREST) for x in (some[0], some[-1])]
        on = (on, ", from ", ends[0], " to ", ends[1], "; for ", named(b.symbol.name), " see the table and --figure")
    yield what[0].upper() + what[1:], on
    kinds = sorted({_KINDS.get(y.kind, y.kind.value) for x in some for e in x.requirement.ends for y in e.bindings})
    if kinds:
        yield "Limited at", listed(kinds)


_KINDS = {
    Kind.EDGE: "the high end of the band", Kind.START: "the low end of the band", Kind.TOUCH: "tangencies inside the band",
    Kind.AXIS: "poles on the boundary of stability", Kind.FAR: "high frequency",
}  # fmt: skip


def _slices_proven(m: DesignMap) -> Iterator[Phrase]:
    if m.certified:
        yield proof(m.scene, "every value of a slice")
        return
    open_ = [r for x in m.slices for r in x.sets if r.undecided]
    late = " (stopped at the time limit)" if any(r.limit is not None for r in open_) else ""
    why = "".join(f"; {x}" for x in dict.fromkeys(r.reason for r in open_) if x)
    yield undecided(f"parts of {len(open_)} slices{late}{why}; --json has them")


def _between(m: DesignMap) -> Iterator[Block]:
    """What is estimated between slices."""
    if m.deviation is None:
        return
    share: Phrase = (" (", at_most(100 * m.deviation / m.height), "\xa0% of the range)")
    apart = sum(1 for x in m.gaps if x.deviation is None)
    others = f"; not between {apart} pair{'' if apart == 1 else 's'} of slices that differ in kind" if apart else ""
    more = " --slices N gives more." if m.is_coarse or m.within is None else ""
    most = value_of(m.free[1], m.deviation, Way.UP)
    yield Paragraph(
        (
            "Estimated (from the curvature): straight lines between slices are off by at most ",
            most,
            share,
            others,
            ".",
            more,
        )
    )


def _proven(m: DesignMap) -> Iterator[Phrase]:
    """Of what is transparent, or stable, what is proven between the slices too."""
    for x in m.proofs:
        what = listed(kept(y) for y in m.criteria if y.name == x.of) if x.of == STABLE else x.of
        threshold = "" if x.jnd is None else f" with a JND of {float(100 * x.jnd):.6g}\xa0%"
        most = m.bound(x)
        share: Phrase = (at_most(100 * x.rectangles.share_left), "\xa0% of the map")
        near: Phrase = ""
        if most:
            part: Phrase = (" (", at_most(100 * most / m.height), "\xa0% of the range)")
            near = "; where lines join slices, within ", value_of(m.free[1], most, Way.UP), part, " of them"
        yield (
            "Proven between slices: what is ",
            what,
            threshold,
            ", and what is not, but for ",
            share,
            ", along the boundary",
            near,
            ".",
        )


def _stiffest(m: DesignMap) -> Iterator[Block]:
    """Of a map along a wall's damping, the stiffest wall."""
    if m.stiffest is None:
        return
    at, top = m.stiffest
    b, k = m.free
    yield Paragraph((
        "Stiffest wall of these slices that is ", listed(kept(x) for x in m.criteria if x.name == "stable"), ": ",
        named(k.symbol.name), " < ", value_of(k, top, Way.DOWN), ", at ", named(b.symbol.name), " = ",
        value_of(b, float(at.at), Way.NEAREST), ".",
    ))  # fmt: skip


def _contours(m: DesignMap) -> Iterator[Block]:
    """On how many slices something is transparent with each of the other thresholds."""
    for i, jnd in enumerate(m.thresholds):
        found = [x.contours[i] for x in m.slices]
        held = sum(1 for r in found if r.feasible)
        left = "" if all(r.certified for r in found) else "; others are undecided"
        yield Paragraph(f"With a JND of {float(100 * jnd):.6g}\xa0%: transparent values on {held} slices{left}.")


def _classical(m: DesignMap) -> Iterator[Block]:
    """The classical bounds that the figure has beside what is exact, and what each takes for granted."""
    if m.lines:
        yield Paragraph("Classical bounds in the figure, computed, not proven:")
        yield Facts(tuple((x.name, f"{x.rule} ({x.assumes})") for x in m.lines))


def _of_slice(r: Requirement) -> Phrase:
    return Strong("undecided") if r.undecided and not r.feasible else sets(r)


def _slices(m: DesignMap) -> Table:
    """Some of the slices, the first and the last one among them."""
    step = ceil((len(m.slices) - 1) / _MOST_ROWS)
    some = [*m.slices[:-1:step], m.slices[-1]]
    rows = [(float(x.at), _of_slice(x.requirement)) for x in some]
    columns = (
        Column(heading(m.free[0]), number=True),
        Column("satisfied for" if len(m.that) > 1 else f"{m.that[0]} for"),
    )
    caption = ("Some of the slices" if len(some) < len(m.slices) else "The slices") + ", proven."
    shown = m.free[0].shown_unit(m.free[0].motion).size
    return Table(columns, tuple((near(in_unit(at, shown)), found) for at, found in rows), caption)
