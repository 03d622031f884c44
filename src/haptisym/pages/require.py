"""The pages of requirements: which values satisfy what is required, what limits them; of a report those of each parameter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, Way
from haptisym.model.jnd import Part
from haptisym.model.quantities import Unit
from haptisym.model.scene import THRESHOLD, Knob, clocks
from haptisym.pages.late import proof as certificate
from haptisym.pages.words import PART_NAMES, at_least, both, near, page_about, proof, symbol, undecided, value_of
from haptisym.verbs.require.feasible import Binding, End, Kind, Span
from haptisym.verbs.require.freeparameter import searched
from haptisym.verbs.require.required import Requirement, is_quick, require
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Equations,
    Figure,
    Line,
    Paragraph,
    Phrase,
    Real,
    Section,
    Table,
    listed,
)
from haptisym.writing.layout import layout, named
from haptisym.writing.layout import rounded as in_digits
from haptisym.writing.plain import said

_PLACES = {
    Kind.EDGE: "the high end of the band", Kind.START: "the low end of the band", Kind.TOUCH: "a tangency inside the band",
    Kind.AXIS: "poles on the imaginary axis", Kind.FAR: "high frequency",
}  # fmt: skip
_OF_ALL = {Kind.START: "low frequency", Kind.TOUCH: "a tangency", Kind.FAR: "high frequency", Kind.AXIS: "poles"}
"""Where passivity limits, which is not about the band."""
_MOST_LIMITS = 2  # that the answer has; more are a table


def page(r: Requirement) -> Document:
    """The page of one parameter."""
    judged = any(x.name not in ("stable", "passive") for x in r.criteria)
    worst = "The worst case over the band against the parameter, with the threshold; grey: " if judged else "Grey: "
    caption = (worst, required(r.criteria), "; hatched: undecided." if r.undecided else ".")
    blocks = (
        *_nearest(r), *_ends(r), *_formulas(r), Figure("requirement", caption, r.figure), certificate(r, r.scene),
    )  # fmt: skip
    return page_about(r.scene, _answer(r), blocks, _proven(r), "Which values satisfy it", r.asides())


def required(criteria: tuple[Criterion, ...]) -> str:
    """What is required, as an adjective: ``transparent and stable in light-touch``."""
    return said(listed(dict.fromkeys(map(kept, criteria))))


def kept(x: Criterion) -> str:
    """What a display is that satisfies a criterion."""
    return "passive" if x.name == "passive" else x.kept.replace(" on the whole band", "")


def _answer(r: Requirement) -> Iterator[tuple[Phrase, Phrase]]:
    now = (" (is ", value_of(r.free, ExactNumber(r.free.value), Way.NEAREST), ")") if r.free.value.is_number else ()
    what = required(r.criteria)
    known: Phrase = (
        ("for ", sets(r))
        if r.feasible
        else "for no value in the range"
        if r.certified
        else "for no value that is proven"
    )
    yield what[0].upper() + what[1:], (known, now)
    limits = list(dict.fromkeys(x for end in r.ends if end.value for x in _bindings(end, r)))
    if limits:
        yield "Limited by", listed(limits) if len(limits) <= _MOST_LIMITS else "see the table"
    yield "Range searched", _range(r)


def _range(r: Requirement) -> Phrase:
    """From where to where values are searched, with 0 where the model allows it."""
    low, high = searched(r.free, r.domain)
    zero = "0, " if r.domain.low == 0 and r.domain.holds_low else ""
    return zero, _bare(value_of(r.free, low, Way.NEAREST)), " to ", value_of(r.free, high, Way.NEAREST)


def _bare(x: Real) -> Real:
    """A number without the name of its unit, which follows."""
    return replace(x, unit=Unit("", x.unit.size))


def _bindings(end: End, r: Requirement) -> Iterator[Phrase]:
    for b in end.bindings:
        yield _part(b), ", ", _where(b, r)


def sets(r: Requirement) -> Phrase:
    """The values, as in a sentence: ``omega_n ≥ 122.4 rad/s``; ``no value`` for none. Ends are rounded inward."""
    return listed((_span(x, r.free) for x in r.feasible), "or") if r.feasible else "no value"


def _span(x: Span, free: Knob) -> Phrase:
    name = named(free.symbol.name)
    low, high = x.low.value, x.high.value
    if low is None and high is None:
        return "every value of ", name
    if low is not None and low is high:
        return name, " = ", value_of(free, low, Way.NEAREST), " alone"
    least = None if low is None else value_of(free, low, Way.UP)
    most = None if high is None else value_of(free, high, Way.DOWN)
    if least is not None and most is None:
        return name, " ≥ " if x.low.closed else " > ", least
    left = () if least is None else (_bare(least), _below(x.low))
    return left, name, _below(x.high), most or ""


def _below(end: End) -> str:
    return " ≤ " if end.closed else " < "


def _nearest(r: Requirement) -> Iterator[Block]:
    """Where no value satisfies it: the nearest one found, what limits it, and what was proven about all others."""
    if r.alone:
        alone = (
            (required(x.criteria), " for ", sets(x), ", some others undecided" if x.undecided else "") for x in r.alone
        )
        yield Paragraph(("Each by itself: ", listed(alone), "."))
    x = next((y.nearest for y in r.alone if y.nearest), r.nearest)
    if x is None:
        return
    least: Phrase = "How near other values come is not proven."
    if x.at_least > 1:
        least = (
            "Proven: no value in the range keeps all ratios below ",
            at_least(x.at_least),
            " times their thresholds.",
        )
    yield Paragraph((
        "Nearest of those tried: ", named(r.free.symbol.name), " = ", value_of(r.free, float(x.value), Way.NEAREST), ", where ",
        _part(x.binding), " reaches ", near(100 * float(x.ratio)), "\xa0% at ", _where(x.binding, r), ", ", near(x.times),
        " times its threshold. ", least,
    ))  # fmt: skip


def _ends(r: Requirement) -> Iterator[Block]:
    """What limits at each end, where that is more than the answer has room for."""
    rows = dict.fromkeys(
        (value_of(r.free, x.value, Way.NEAREST), _part(b), _where(b, r)) for x in r.ends for b in x.bindings if x.value
    )
    if len(rows) > _MOST_LIMITS:
        columns = Column(named(r.free.symbol.name), number=True), Column("limited by"), Column("at")
        yield Table(columns, tuple(rows), "What limits the values at each end, proven.")


def heading(free: Knob) -> Phrase:
    """A parameter and its unit, over a column."""
    unit = free.shown_unit(free.motion).text
    return named(free.symbol.name), f" ({unit})" if unit else ""


def _part(b: Binding) -> Phrase:
    if b.criterion.name == "passive":
        return "passivity"
    if b.criterion.name == "stable":
        return "stability" if " in " not in b.criterion.kept else f"stability{b.criterion.kept.removeprefix('stable')}"
    return f"the {PART_NAMES[b.part]} part" if isinstance(b.part, Part) else symbol(b.criterion.symbol)


def _where(b: Binding, r: Requirement) -> Phrase:
    place = _OF_ALL[b.kind] if b.criterion.name == "passive" else _PLACES[b.kind]
    if b.kind is Kind.AXIS and b.criterion.name == "stable" and clocks(r.scene):
        place = "poles on the unit circle"
    joined = " at " if b.kind is Kind.AXIS else ", "
    return place, "" if b.omega is None else (joined, both(b.omega))


def _formulas(r: Requirement) -> Iterator[Block]:
    forms = tuple(Line(named(r.free.symbol.name), form) for form in r.forms if form is not None)
    if forms:
        yield Section("Closed form, from the condition at the end of the band", (Equations(forms),))


def _is_all(r: Requirement) -> bool:
    """Whether all that was asked about is undecided."""
    [(low, high), *others] = r.undecided
    ends = [None if x is None else float(x) for x in (low, high, r.domain.low, r.domain.high)]
    return not others and ends[:2] == ends[2:]


def _proven(r: Requirement) -> Iterator[Phrase]:
    what = required(r.criteria)
    if r.undecided:
        where = listed((_limit(r.free, a, Way.DOWN), " to ", _limit(r.free, b, Way.UP)) for a, b in r.undecided)
        why = f"; stopped after {r.limit:g} s" if r.limit is not None else ""
        yield undecided((named(r.free.symbol.name), " from ", where, why, f": {r.reason}" if r.reason else ""))
        if not _is_all(r):
            yield "Proven: all other values in the range."
        return
    exact = any(isinstance(end.value, Sliver) for span in r.feasible for end in (span.low, span.high))
    bounds = "; each end lies within the enclosure in --json" if exact else ""
    if r.feasible:
        yield proof(r.scene, (what, " for every value in this set and for no other in the range", bounds))
    else:
        yield proof(r.scene, ("no value in the range is ", what))


def _limit(free: Knob, x: RealNumber | None, way: Way) -> Phrase:
    if x is None:
        return "infinity" if way is Way.UP else "minus infinity"
    return value_of(free, x, way)


_MOST_PARAMETERS = 8  # for more, ``haptisym require`` has the time


def design(e: Evaluation) -> Iterator[Block]:
    """A row for each parameter: the exact set of values, and what binds at its ends; all others keep the scene's values."""
    found = requirements(e)
    if not found:
        return
    yield Paragraph(
        "All values of one parameter for which neither ratio exceeds its threshold on the band, the others as in the scene."
    )
    if e.scene.untied():
        yield Paragraph(e.scene.untied_note())
    columns = tuple(map(Column, ("parameter", "in the scene", "transparent for", "limited by")))
    how = "proven" if e.scene.level is None else "of the fitted model"
    yield Table(
        columns, tuple(map(_row, found)), f"Values for which the display is transparent on its whole band, {how}."
    )


def requirements(e: Evaluation) -> list[Requirement]:
    """For each parameter and for the threshold, where that takes no more than moments; none for other scenes."""
    if len(e.scene.parameters) > _MOST_PARAMETERS or not is_quick(e.scene):
        return []
    return [require(e.scene, path) for path in (*(x.path for x in e.scene.parameters), THRESHOLD)]


def _row(r: Requirement) -> tuple[Phrase, ...]:
    value = r.free.value if r.free.value.free_symbols else in_digits(r.free.value)  # a limit may be a formula in omega
    shown: Phrase = (
        layout(value) if r.free.value.free_symbols else value_of(r.free, ExactNumber(r.free.value), Way.NEAREST)
    )
    return layout(r.free.symbol), shown, sets(r), _binding(r)


def _binding(r: Requirement) -> Phrase:
    found = [
        (symbol(b.criterion.symbol), "" if b.omega is None else (" at ", both(b.omega)))
        for end in r.ends
        for b in end.bindings
    ]
    return listed(found) if found else "–"
