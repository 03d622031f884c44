"""The pages of requirements.

The pages of requirements: the answer in a sentence, what binds at each end, what is certain; and of a map of two.

The designer's questions in a report: which values of each parameter would keep the display transparent on its band.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from math import floor, log10

from sympy import Expr

from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, outward
from haptisym.model.quantities import unit_text
from haptisym.model.scene import THRESHOLD, Knob, clocks
from haptisym.pages.late import proof
from haptisym.pages.words import both, certainty, exactly, page_about, rounded, rule, short, symbol
from haptisym.verbs.require.feasible import Binding, Domain, End, Kind, Span
from haptisym.verbs.require.freeparameter import searched
from haptisym.verbs.require.required import Requirement, is_quick, require
from haptisym.writing.document import (
    Block,
    Column,
    Document,
    Equations,
    Facts,
    Figure,
    Line,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    listed,
)
from haptisym.writing.layout import layout, named
from haptisym.writing.layout import rounded as in_digits

_PLACES = {
    Kind.EDGE: "the band's high end", Kind.START: "the band's low end", Kind.TOUCH: "a touch inside the band",
    Kind.AXIS: "roots on the imaginary axis", Kind.FAR: "far out",
}  # fmt: skip
_OF_ALL = {Kind.START: "at low frequencies", Kind.TOUCH: "a touch", Kind.FAR: "at high frequencies", Kind.AXIS: "poles"}
"""Where every passive hand binds, which is not about the band."""


def page(r: Requirement) -> Document:
    """The page of one parameter."""
    kept = listed(dict.fromkeys(x.kept for x in r.criteria))
    worst = "The worst case over the band against the parameter, with the threshold; grey: " if _judged(r) else "Grey: "
    caption = (worst, kept, "; hatched: undecided." if r.undecided else ".")
    blocks = (
        Facts(tuple(_question(r))), Paragraph(_answer(r)), *_nearest(r), *_ends(r), *_formulas(r),
        Figure("requirement", caption, r.figure), Paragraph(_certain(r)), proof(r, r.scene),
    )  # fmt: skip
    return page_about(r.scene, blocks, "Which values will do", r.asides())


def _question(r: Requirement) -> Iterator[tuple[str, Phrase]]:
    low, high = (both(ExactNumber(x)) for x in r.scene.band)
    unit = "a plain number" if r.free.unit == "1" else f"in {unit_text(r.free.unit)}"
    yield "free", (r.free.path, " (", named(r.free.symbol.name), f"), {unit}")
    yield "range searched", _searched(r)
    yield "band", (low, " to ", high)
    yield "condition", _condition(r)


def _condition(r: Requirement) -> Phrase:
    judged = _judged(r)
    others = [x.rule for x in r.criteria if x not in judged]
    first = (listed(map(rule, judged)), " on the whole band") if judged else ""
    return first, "; " if judged and others else "", "; ".join(others)


def _judged(r: Requirement) -> list[Criterion]:
    """What is asked of each frequency of the band."""
    return [x for x in r.criteria if x.name not in ("stable", "passive")]


def _searched(r: Requirement) -> str:
    """From where to where values are searched, with 0 where the model allows it."""
    low, high = searched(r.free, r.domain)
    zero = "0, " if r.domain.low == 0 and r.domain.holds_low else ""
    return f"{zero}{_engineering(low)} to {_engineering(high)}{unit_of(r.free)}"


def _engineering(x: Expr) -> str:
    """Digits with a power of ten that is a multiple of 3, where there must be one: ``80e-6``."""
    value = float(x)
    power = 0 if value == 0 or 1e-3 <= abs(value) < 1e5 else 3 * floor(log10(abs(value)) / 3 + 1e-12)
    return f"{value / 10**power:.6g}" + (f"e{power}" if power else "")


def _answer(r: Requirement) -> Phrase:
    kept = listed(dict.fromkeys(x.kept for x in r.criteria))
    if not r.feasible:
        known = "No value that was asked about makes" if r.certified else "No value is proven to make"
        return f"{known} the display ", kept, "."
    return "The display is ", kept, " exactly for " if r.certified else ", proven, for ", sets(r), "."


def sets(r: Requirement) -> Phrase:
    """The values, as in a sentence: ``omega_n ≥ 122.36 rad/s``; ``no value`` for none.

    An end behind which nothing is proven is rounded inward.
    """
    doubtful = {x for pair in r.undecided for x in pair if x is not None}
    return listed((_span(x, r.free, doubtful) for x in r.feasible), "or") if r.feasible else "no value"


def _span(x: Span, free: Knob, doubtful: Collection[RealNumber]) -> Phrase:
    name, unit = named(free.symbol.name), unit_of(free)
    low, high = x.low.value, x.high.value
    if low is None and high is None:
        return "every value of ", name
    if low is not None and low is high:
        return name, " = ", short(low), unit, " alone"

    def end(y: RealNumber) -> Number:
        return _directed(y, 5, up=y is low) if y in doubtful else short(y)

    if low is not None and high is None:
        return name, " ≥ " if x.low.closed else " > ", end(low), unit
    left = () if low is None else (end(low), _below(x.low))
    right = () if high is None else (_below(x.high), end(high))
    return left, name, right, unit


def _directed(x: RealNumber, digits: int, *, up: bool) -> Number:
    """So many digits of a number that is not less, or not larger."""
    low, high = (float(y) for y in outward(*x.bounds(64), digits))
    return Number(f"{high if up else low:.{digits}g}", float(x))


def _below(end: End) -> str:
    return " ≤ " if end.closed else " < "


def unit_of(free: Knob) -> str:
    """Its unit behind a number; nothing for a plain one."""
    return "" if free.unit == "1" else f" {unit_text(free.unit)}"


def _by_itself(r: Requirement) -> Phrase:
    kept = listed(dict.fromkeys(x.kept for x in r.criteria))
    return kept, " for ", sets(r), ", while some others are undecided" if r.undecided else ""


def _nearest(r: Requirement) -> Iterator[Block]:
    """Where no value will do: the nearest one found, what binds there, and what was proven about all others."""
    if r.alone:
        yield Paragraph(("By itself: ", listed(map(_by_itself, r.alone)), "."))
    x = next((y.nearest for y in r.alone if y.nearest), r.nearest)
    if x is None:
        return
    least = (
        f"Proven: no value that was asked about keeps all ratios below {x.at_least:.4g} times their thresholds."
        if x.at_least > 1
        else "How near other values come was not proven."
    )
    yield Paragraph((
        "Nearest of those that were tried is ", named(r.free.symbol.name), " = ", rounded(float(x.value), 6),
        unit_of(r.free), ": ", _part(x.binding), f" reaches {100 * float(x.ratio):.4g}\xa0% there (", _where(x.binding, r),
        f"), {x.times:.4g} times its threshold. {least}",
    ))  # fmt: skip


def _ends(r: Requirement) -> Iterator[Block]:
    rows = dict.fromkeys(
        (exactly(x.value, r.digits), _part(b), _where(b, r)) for x in r.ends for b in x.bindings if x.value
    )
    if rows:
        columns = Column(heading(r.free), number=True), Column("binds"), Column("where")
        yield Table(columns, tuple(rows), "What binds at each end, proven.")
    elif r.feasible and all(_is_asked(x, y) for span in r.feasible for x, y in _beside(span, r.domain)):
        yield Paragraph("Nothing binds at an end.")


def _beside(x: Span, of: Domain) -> tuple[tuple[End, Expr | None], ...]:
    """Both ends with those of what was asked about."""
    return (x.low, of.low), (x.high, of.high)


def _is_asked(x: End, asked: Expr | None) -> bool:
    """Whether values end there because no others were asked about."""
    return x.value is None if asked is None else x.value is not None and float(x.value) == float(asked)


def heading(free: Knob) -> Phrase:
    """A parameter and its unit, over a column."""
    return named(free.symbol.name), "" if free.unit == "1" else f" ({unit_text(free.unit)})"


def _part(b: Binding) -> Phrase:
    if b.criterion.name in ("stable", "passive"):
        return b.criterion.words
    return symbol(b.criterion.symbol), f" ({b.criterion.name})" if b.part else ""


def _where(b: Binding, r: Requirement) -> Phrase:
    place = _OF_ALL[b.kind] if b.criterion.name == "passive" else _PLACES[b.kind]
    if b.kind is Kind.AXIS and b.criterion.name == "stable" and clocks(r.scene):
        place = "roots on the unit circle"
    return place, "" if b.omega is None else (", ", both(b.omega))


def _formulas(r: Requirement) -> Iterator[Block]:
    forms = tuple(Line(named(r.free.symbol.name), form) for form in r.forms if form is not None)
    if forms:
        yield Section("Closed form, from the condition at the end of the band:", (Equations(forms),))


def _is_all(r: Requirement) -> bool:
    """Whether all that was asked about is undecided."""
    [(low, high), *others] = r.undecided
    ends = [None if x is None else float(x) for x in (low, high, r.domain.low, r.domain.high)]
    return not others and ends[:2] == ends[2:]


def _certain(r: Requirement) -> Phrase:
    if r.undecided:
        where = listed(("from ", _limit(a, up=False), " to ", _limit(b, up=True)) for a, b in r.undecided)
        why = "" if r.limit is None else f" within the limit of {r.limit:g} s"
        why += f": {r.reason}" if r.reason else ""
        return (
            Strong("UNDECIDED"), ": for the values ", where, f" neither was proven{why}.",
            "" if _is_all(r) else " About all others everything is.",
        )  # fmt: skip
    if not r.feasible:
        return certainty(
            r.scene, "Certain: of the range searched none that will do was missed; that is proven, not sampled."
        )
    if any(isinstance(end.value, Sliver) for span in r.feasible for end in (span.low, span.high)):
        narrow = "Certain: each end lies within the enclosure that is given; of some no more digits are known."
        return certainty(r.scene, narrow)
    return certainty(
        r.scene,
        "Certain: of the range searched these are all such values, none is missed and none invented; every digit is proven.",
    )


def _limit(x: RealNumber | None, *, up: bool) -> Phrase:
    if x is None:
        return "infinity" if up else "minus infinity"
    return _directed(x, 6, up=up)


_MOST_PARAMETERS = 8  # for more, ``haptisym require`` has the time


def design(e: Evaluation) -> Iterator[Block]:
    """A row for each parameter: the exact set of values, and what binds at its ends; all others keep the scene's values."""
    found = requirements(e)
    if not found:
        return
    yield Paragraph((
        "All values of one parameter for which neither ratio exceeds its threshold anywhere on the band, the others ",
        "being as they are in the scene: proven, from a millionth to a million times each value.",
    ))  # fmt: skip
    if e.scene.untied():
        yield Paragraph(e.scene.untied_note())
    columns = tuple(map(Column, ("parameter", "in the scene", "transparent for", "what binds")))
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
    return layout(r.free.symbol), (layout(value), _unit(r.free)), sets(r), _binding(r)


def _unit(free: Knob) -> str:
    return "" if free.unit == "1" else f" {free.unit.replace('*', '·')}"


def _binding(r: Requirement) -> Phrase:
    found = [
        (symbol(b.criterion.symbol), "" if b.omega is None else (" at ", both(b.omega)))
        for end in r.ends
        for b in end.bindings
    ]
    return listed(found) if found else "–"
