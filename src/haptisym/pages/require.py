"""The pages of requirements: which values of a parameter satisfy what is required, and what limits
them.

The set of all values is a union of intervals whose ends are exact. The same for each parameter is a
section of a report. Of a map of two parameters: its exact slices, what is proven between them, and
what is estimated there. Begin with ``page`` and ``page_map``.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from sympy import Expr

from haptisym.judge.bindings import IN_HANDS, STABLE, Binding, Kind
from haptisym.judge.bounds import ANY_ENVIRONMENT
from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, Way, in_unit
from haptisym.kernel.sets import STOPPED, SingleValue
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension
from haptisym.model.scene import THRESHOLD, Knob, clocks
from haptisym.model.valueranges import searched
from haptisym.pages import words as w
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.nearest import Nearest
from haptisym.verbs.require.required import TRANSPARENT, Requirement, in_words, is_quick, require
from haptisym.writing import document as doc
from haptisym.writing.document import Block, Document, Phrase, Strong, listed
from haptisym.writing.layout import layout, named
from haptisym.writing.plain import said

# One parameter.


_PLACES = {
    Kind.EDGE: "the high end of the band",
    Kind.START: "the low end of the band",
    Kind.TOUCH: "a tangency inside the band",
    Kind.AXIS: "poles on the imaginary axis",
    Kind.FAR: "high frequency",
}
_OF_ALL = {
    Kind.START: "low frequency",
    Kind.TOUCH: "a tangency",
    Kind.FAR: "high frequency",
    Kind.AXIS: "poles",
}
"""Where passivity limits, which is not about the band."""
_MOST_LIMITS = 2  # that the answer has; more are a table


def page(r: Requirement) -> Document:
    """Return the page of one parameter."""
    # Stability and passivity have no ratio along the band, so the figure has no curve.
    judged = any(x.name not in (*IN_HANDS, "passive") for x in r.criteria)
    worst = (
        "The worst case over the band against the parameter, with the threshold; grey: "
        if judged
        else "Grey: "
    )
    caption = (worst, required(r.criteria), "; hatched: undecided." if r.undecided else ".")
    blocks = (*_nearest(r), *_ends(r), *_formulas(r), doc.Figure("requirement", caption, r.figure))
    return w.page_about(
        r.scene,
        _answer(r),
        blocks,
        _proven(r),
        "Which values satisfy it",
        r.asides(),
        () if r.feasible or r.undecided else tuple(_further(r)),
    )


def _further(r: Requirement) -> Iterator[str]:
    """Yield the command of a map of two parameters, where no value of one is enough: a delay or
    another time first, which no filter makes up for."""
    others = [
        x
        for x in r.scene.parameters
        if x.place.startswith("effects.") and x.path != r.free.path and not r.free.parts
    ]
    # sorted is stable: among times, and among all others, the order of the scene.
    others.sort(key=lambda x: x.dimension is not Dimension.TIME)
    judged = [x.name for x in r.criteria if x.name not in (*IN_HANDS, "passive")]
    options = [f"--that {goal}" for goal in r.that if r.that != ("transparent",)]
    if ANY_ENVIRONMENT.name in judged:
        options.append("--any-environment")
    elif judged in ([part.value] for part in Part):
        options.append(f"--part {judged[0]}")
    for x in others[:1]:
        free = f"--free {r.free.name} --free {x.name} --range LO HI --range LO HI"
        yield " ".join(["haptisym require SCENE", free, *options])


def required(criteria: tuple[Criterion, ...]) -> str:
    """What is required, as an adjective: ``transparent and stable in light-touch``."""
    return said(listed(dict.fromkeys(x.kept for x in criteria)))


def _answer(r: Requirement) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield what is required with its values, what limits these, and the range searched."""
    now = (
        (" (is ", w.value_of(r.free, ExactNumber(r.free.value), Way.NEAREST), ")")
        if r.free.value.is_number
        else ()
    )
    what = required(r.criteria)
    known: Phrase = "for no value in the range" if r.certified else "for no value that is proven"
    if r.feasible:
        known = "" if r.certified else "at least ", "for ", sets(r)
    yield what[0].upper() + what[1:], (known, now)
    # Few limits stand in the answer; many have a table of their own.
    limits = list(dict.fromkeys(x for end in r.ends for x in _bindings(end, r)))
    if limits and not _rows(r):
        yield "Limited by", listed(limits)
    yield "Range searched", _range(r)


def _range(r: Requirement) -> Phrase:
    """Return from where to where values are searched, rounded inward; 0 is examined by itself where
    it belongs to the domain and the search begins next to it."""
    low, high = searched(r.free, r.domain)
    ends = w.reach_of(r.free, low, Way.UP), w.reach_of(r.free, high, Way.DOWN)
    zero = "0, and " if r.domain.low == 0 and r.domain.holds_low else ""
    return zero, w.bare(ends[0]) if ends[0].unit == ends[1].unit else ends[0], " to ", ends[1]


def _bindings(end: SingleValue, r: Requirement) -> Iterator[Phrase]:
    """Yield what limits at an end: the part or the condition, and where."""
    for b in end.bindings:
        yield _part(b), ", " if b.kind is Kind.AXIS else " at ", _where(b, r)


def sets(r: Requirement) -> Phrase:
    """The values, as in a sentence: ``omega_n ≥ 122.4 rad/s``; ``no value`` for none. Ends are
    rounded inward."""
    return w.values_of(r.values, r.free)


def _nearest(r: Requirement) -> Iterator[Block]:
    """Yield, where no value satisfies what is required, the nearest one found and what limits
    it."""
    if r.alone:
        others = ", some others undecided"
        alone = (
            (required(x.criteria), " for ", sets(x), others if x.undecided else "") for x in r.alone
        )
        yield doc.Paragraph(("Each by itself: ", listed(alone), "."))
    x = _near(r)
    if x is None:
        return
    # Without a proven bound for all values, a better one may have been missed.
    least = "" if x.at_least > 1 else " How near other values come is not proven."
    value, reached = w.value_of(r.free, float(x.value), Way.NEAREST), w.near(100 * float(x.ratio))
    yield doc.Paragraph(
        w.phrased(
            (
                "Nearest of those tried: {} = {}, where {} reaches {}\xa0% at {}, {} times its "
                "threshold.{}"
            ),
            named(r.free.symbol.name),
            value,
            _part(x.binding),
            reached,
            _where(x.binding, r),
            w.near(x.times),
            least,
        )
    )


def _near(r: Requirement) -> Nearest | None:
    """Return the nearest value of the first condition that no value satisfies, or that of all."""
    return next((y.nearest for y in r.alone if y.nearest), r.nearest)


def _rows(r: Requirement) -> list[tuple[Phrase, ...]]:
    """Return what limits at each end, if that is more than the answer has room for; else
    nothing."""
    ends = ((x.value, b) for x in r.ends for b in x.bindings)
    rows = dict.fromkeys(
        (w.value_of(r.free, x, Way.NEAREST), _part(b), _where(b, r)) for x, b in ends
    )
    return [*rows] if len(rows) > _MOST_LIMITS else []


def _ends(r: Requirement) -> Iterator[Block]:
    """Yield the table of what limits at each end, if that is more than the answer has room for."""
    if rows := _rows(r):
        yield w.table(
            rows,
            "What limits the values at each end, proven.",
            w.number(named(r.free.symbol.name), lambda x: x[0]),
            w.Field("limited by", lambda x: x[1]),
            w.Field("at", lambda x: x[2]),
        )


def heading(free: Knob) -> Phrase:
    """A parameter and its unit, over a column."""
    unit = free.shown_unit(free.motion).text
    return named(free.symbol.name), f" ({unit})" if unit else ""


def _part(b: Binding) -> Phrase:
    """Return what limits, in words: passivity, stability, or a part of the distortion."""
    if b.criterion.name == "passive":
        return "passivity"
    if b.criterion.name in IN_HANDS:
        return f"stability{b.criterion.kept.removeprefix(b.criterion.name)}"
    return (
        f"the {w.PART_NAMES[b.part]} part"
        if isinstance(b.part, Part)
        else w.symbol(b.criterion.symbol)
    )


def _where(b: Binding, r: Requirement) -> Phrase:
    """Return at which place of the band, or of the axis, a condition limits."""
    place = _OF_ALL[b.kind] if b.criterion.name == "passive" else _PLACES[b.kind]
    # Poles of a sampled loop are those in z, whose boundary is the unit circle.
    if b.kind is Kind.AXIS and b.criterion.name in IN_HANDS and clocks(r.scene):
        place = "poles on the unit circle"
    joined = " at " if b.kind is Kind.AXIS else ", "
    return place, "" if b.omega is None or (
        b.criterion.name == "passive" and not float(b.omega)
    ) else (joined, w.both(b.omega))


def _formulas(r: Requirement) -> Iterator[Block]:
    """Yield the closed forms of the ends, where these follow from a condition at the band's end."""
    forms = tuple(doc.Line(named(r.free.symbol.name), form) for form in r.forms if form is not None)
    if forms:
        yield doc.Section(
            "Closed form, from the condition at the end of the band", (doc.Equations(forms),)
        )


def _is_all(r: Requirement) -> bool:
    """Return whether the whole range that was asked about is undecided."""
    [whole, *others] = r.undecided
    ends = [None if x is None else float(x) for x in (whole.low, whole.high, *r.domain.ends)]
    return not others and ends[:2] == ends[2:]


def _proven(r: Requirement) -> Iterator[Phrase]:
    """Yield what is proven about the values, and what is undecided."""
    what = required(r.criteria)
    if r.undecided:
        first, last = searched(r.free, r.domain)
        # Undecided intervals are rounded outwards: what is printed holds all of them.
        where = listed(
            (w.bare(_limit(r, x.low, first, Way.DOWN)), " to ", _limit(r, x.high, last, Way.UP))
            for x in r.undecided
        )
        why = (
            r.reason
            if r.limit is None
            else r.reason.replace(STOPPED, f"{STOPPED} of {r.limit:g} s")
        )
        yield w.undecided((named(r.free.symbol.name), " from ", where, f": {why}" if why else ""))
        if not _is_all(r):
            yield w.proof(r.scene, "all other values in the range")
        return
    # An end that is a Sliver is known by an enclosure, not as a closed number.
    exact = any(isinstance(end.value, Sliver) for piece in r.feasible for end in piece.ends)
    bounds = doc.Brief("; each end lies within the enclosure in --json") if exact else ""
    if r.feasible:
        yield w.proof(
            r.scene, (what, " for every value in this set and for no other in the range", bounds)
        )
    else:
        x = _near(r)
        least = w.phrased(_LEAST, w.at_least(x.at_least)) if x and x.at_least > 1 else ""
        yield w.proof(r.scene, ("no value in the range is ", what, least))


_LEAST = ", and none keeps all ratios below {} times their thresholds"


def _limit(r: Requirement, x: RealNumber | None, end: Expr, way: Way) -> doc.Real:
    """Return the end of an interval, or that of the range searched where it has none."""
    return w.value_of(r.free, end if x is None else x, way)


_MOST_PARAMETERS = 8
"""Parameters up to which a report has a row for each: for more it would take too long."""


def design(e: Evaluation) -> Iterator[Block]:
    """A row for each parameter: the exact set of values, and what binds at its ends; all others
    keep the scene's values."""
    rows = requirements(e)
    if not rows:
        return
    yield doc.Paragraph(
        "All values of one parameter for which neither ratio exceeds its threshold on the "
        "band, the others as in the scene."
    )
    if e.scene.untied():
        yield doc.Paragraph(e.scene.untied_note())
    how = "proven" if e.scene.level is None else "of the fitted model"
    yield w.table(
        rows,
        f"Values for which the display is transparent on its whole band, {how}.",
        w.Field("parameter", lambda r: layout(r.free.symbol)),
        w.Field("in the scene", _in_scene),
        w.Field("transparent for", sets),
        w.Field("limited by", _binding),
    )


def requirements(e: Evaluation) -> list[Requirement]:
    """Return the requirement on each parameter and on the threshold where that takes moments;
    nothing for other scenes."""
    if len(e.scene.parameters) > _MOST_PARAMETERS or not is_quick(e.scene):
        return []
    varied = (x for x in e.scene.parameters if x.symbol not in e.scene.chain.harmonic_symbols)
    return [require(e.scene, path) for path in (*(x.path for x in varied), THRESHOLD)]


def _in_scene(r: Requirement) -> Phrase:
    # A limit of the JND may be a formula in omega.
    """Return the value that a parameter has in the scene."""
    if r.free.value.free_symbols:
        return layout(r.free.value)
    return w.value_of(r.free, ExactNumber(r.free.value), Way.NEAREST)


def _binding(r: Requirement) -> Phrase:
    """Return what limits at the ends of a set of values, and where."""
    limits = [(w.symbol(b.criterion.symbol), b.omega) for end in r.ends for b in end.bindings]
    return (
        listed((x, "" if omega is None else (" at ", w.both(omega))) for x, omega in limits)
        if limits
        else "–"
    )


# Two parameters.


_MOST_ROWS = 10  # of slices that are listed; the document of JSON has them all


def page_map(m: DesignMap) -> Document:
    """The page of a map: where values satisfy what is required, some of its slices, what is
    proven."""
    shown = (
        "Values that satisfy what is required, along exact slices, with what limits them at "
        "their ends."
    )
    rows = _slices(m)
    omitted = len(m.slices) - len(rows.rows)
    printed = f"Printed: {len(rows.rows)} of {len(m.slices)} slices"
    more = [(printed, doc.Brief("; --json has all"), ".")] if omitted else []
    drawn = doc.Figure("map", shown, m.figure)
    blocks = rows, *w.noted(more), *_stiffest(m), *_contours(m), *_classical(m), drawn, *_between(m)
    return w.page_about(
        m.scene,
        _answer_map(m),
        blocks,
        (*_slices_proven(m), *_proven_map(m)),
        "Which values satisfy it",
        m.asides(),
    )


def _answer_map(m: DesignMap) -> Iterator[tuple[Phrase, Phrase]]:
    """Yield on how many slices values satisfy what is required, and what limits them."""
    a, b = m.free
    some = [x for x in m.slices if x.requirement.feasible]
    what = required(m.criteria)
    on: Phrase = (f"on {len(some)} of {len(m.slices)} slices along ", named(a.symbol.name))
    if some:
        low, high = (w.value_of(a, float(x.at), Way.NEAREST) for x in (some[0], some[-1]))
        see = "; for ", named(b.symbol.name), " see the table", doc.Brief(" and --figure")
        on = w.phrased("{}, from {} to {}{}", on, w.bare(low), high, see)
    yield what[0].upper() + what[1:], on
    kinds = sorted(
        {
            _KINDS.get(y.kind, y.kind.value)
            for x in some
            for e in x.requirement.ends
            for y in e.bindings
        }
    )
    if kinds:
        yield "Limited at", listed(kinds)


_KINDS = {
    Kind.EDGE: "the high end of the band",
    Kind.START: "the low end of the band",
    Kind.TOUCH: "tangencies inside the band",
    Kind.AXIS: "poles on the boundary of stability",
    Kind.FAR: "high frequency",
}


def _slices_proven(m: DesignMap) -> Iterator[Phrase]:
    """Yield whether every slice is decided."""
    if m.certified:
        yield w.proof(m.scene, "every value of a slice")
        return
    open_ = [r for x in m.slices for r in x.sets if r.undecided]
    late = " (stopped at the time limit)" if any(r.limit is not None for r in open_) else ""
    why = "".join(f"; {x}" for x in dict.fromkeys(r.reason for r in open_) if x)
    have = doc.Brief("; --json has them")
    yield w.undecided((f"parts of {len(open_)} slices{late}{why}", have))


def _between(m: DesignMap) -> Iterator[Block]:
    """Yield what is estimated between slices."""
    if not m.deviation:
        return
    # The estimate comes from the curvature of the ends from slice to slice: it is no bound.
    share: Phrase = (" (", w.at_most(100 * m.deviation / m.height), "\xa0% of the range)")
    apart = sum(1 for x in m.gaps if x.deviation is None)
    others = (
        f"; not between {apart} pair{'' if apart == 1 else 's'} of slices that differ in kind"
        if apart
        else ""
    )
    few = m.is_coarse or m.within is None
    more = doc.Brief(" --slices N gives more.") if few else ""
    most = w.value_of(m.free[1], m.deviation, Way.UP)
    words = (
        "Estimated (from the curvature): straight lines between slices are off by at most {}{}{}.{}"
    )
    yield doc.Paragraph(w.phrased(words, most, share, others, more))


def _proven_map(m: DesignMap) -> Iterator[Phrase]:
    """Yield what is proven between the slices about what is transparent, or stable."""
    for x in m.proofs:
        what: Phrase = in_words(x.of, m.criteria)
        if x.of == STABLE:
            what = listed(y.kept for y in m.criteria if y.name == x.of)
        threshold = "" if x.jnd is None else f" with a JND of {float(100 * x.jnd):.6g}\xa0%"
        # How far from the lines between slices a boundary can be follows from the rectangles that
        # are left.
        most = m.bound(x)
        share: Phrase = (w.at_most(100 * x.rectangles.share_left), "\xa0% of the map")
        near: Phrase = ""
        if most:
            part: Phrase = (" (", w.at_most(100 * most / m.height), "\xa0% of the range)")
            near = (
                "; where lines join slices, within ",
                w.value_of(m.free[1], most, Way.UP),
                part,
                " of them",
            )
        words = "Proven between slices: what is {}{}, and what is not{}."
        left: Phrase = (
            (", but for ", share, ", along the boundary", near) if x.rectangles.share_left else ""
        )
        yield w.phrased(words, what, threshold, left)


def _stiffest(m: DesignMap) -> Iterator[Block]:
    """Yield the stiffest stable wall of a map along a wall's damping."""
    if m.stiffest is None:
        return
    at, top = m.stiffest
    b, k = m.free
    stable = listed(x.kept for x in m.criteria if x.name == "stable")
    # Rounded down: a wall as stiff as is printed is still stable.
    value, damping = w.value_of(k, top, Way.DOWN), w.value_of(b, float(at.at), Way.NEAREST)
    words = "Stiffest wall of these slices that is {}: {} < {}, at {} = {}."
    yield doc.Paragraph(
        w.phrased(words, stable, named(k.symbol.name), value, named(b.symbol.name), damping)
    )


def _contours(m: DesignMap) -> Iterator[Block]:
    """Yield on how many slices the display is transparent for some values with each other
    threshold."""
    for i, jnd in enumerate(m.thresholds):
        contours = [x.contours[i] for x in m.slices]
        held = sum(1 for r in contours if r.feasible)
        left = "" if all(r.certified for r in contours) else "; others are undecided"
        yield doc.Paragraph(
            f"With a JND of {float(100 * jnd):.6g}\xa0%: values that are "
            f"{in_words(TRANSPARENT, m.criteria)} on {held} slices{left}."
        )


def _classical(m: DesignMap) -> Iterator[Block]:
    """Yield the classical bounds that the figure shows beside the exact sets, and what each
    assumes."""
    if m.lines:
        yield doc.Paragraph("Classical bounds in the figure, computed, not proven:")
        yield doc.Facts(tuple((x.name, f"{x.rule} ({x.assumes})") for x in m.lines))


def _of_slice(r: Requirement) -> Phrase:
    """Return the values of one slice."""
    return Strong("undecided") if r.undecided and not r.feasible else sets(r)


def _slices(m: DesignMap) -> doc.Table:
    """Return the table of some slices, the first and the last among them."""
    # At most ten evenly spaced slices and the last one, so that both ends of the map are there.
    step = ceil((len(m.slices) - 1) / _MOST_ROWS)
    some = [*m.slices[:-1:step], m.slices[-1]]
    which = "Some of the slices" if len(some) < len(m.slices) else "The slices"
    along = m.free[0]
    size = along.shown_unit(along.motion).size
    what = "satisfied" if len(m.that) > 1 else in_words(m.that[0], m.criteria)
    return w.table(
        some,
        f"{which}, proven.",
        w.number(heading(along), lambda x: w.near(in_unit(float(x.at), size))),
        w.Field(f"{what} for", lambda x: _of_slice(x.requirement)),
    )
