"""The pages of requirements: the answer in a sentence, what binds at each end, what is certain; and of a map of two."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver
from haptisym.model.knobs import Knob
from haptisym.model.quantities import unit_text
from haptisym.pages.words import both, exactly, lead, rounded_up, rule, short, symbol, title
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Binding, End, Kind, Span
from haptisym.verbs.require.required import Requirement
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
)  # fmt: skip
from haptisym.writing.names import named

_PLACES = {
    Kind.EDGE: "the band's high end", Kind.START: "the band's low end", Kind.TOUCH: "a touch inside the band",
    Kind.AXIS: "roots on the imaginary axis", Kind.FAR: "far out",
}  # fmt: skip
_OF_ALL = {Kind.START: "at low frequencies", Kind.TOUCH: "a touch", Kind.FAR: "at high frequencies", Kind.AXIS: "poles"}
"""Where every passive hand binds, which is not about the band."""


def page(r: Requirement) -> Document:
    """The page of one parameter."""
    caption = (
        "The worst case over the band against the parameter, with the threshold; grey: transparent on the whole band."
    )
    blocks = (
        Facts(tuple(_question(r))), Paragraph(_answer(r)), *_nearest(r), *_ends(r), *_formulas(r),
        Figure("requirement", caption, r.figure), Paragraph(_certain(r)),
    )  # fmt: skip
    return Document(title(r.scene), lead(r.scene, r.asides()), blocks, "Which values will do")


def _question(r: Requirement) -> Iterator[tuple[str, Phrase]]:
    low, high = (both(ExactNumber(x)) for x in r.scene.band)
    unit = "a plain number" if r.free.unit == "1" else f"in {unit_text(r.free.unit)}"
    yield "free", (r.free.path, " (", named(r.free.symbol.name), f"), {unit}")
    yield "asked", _asked(r)
    yield "band", (low, " to ", high)
    yield "condition", _condition(r)


def _condition(r: Requirement) -> Phrase:
    judged = [x for x in r.criteria if x.name not in ("stable", "passive")]
    others = [x.rule for x in r.criteria if x not in judged]
    first = (listed(map(rule, judged)), " on the whole band") if judged else ""
    return first, "; " if judged and others else "", "; ".join(others)


def _asked(r: Requirement) -> str:
    low, high = r.domain.low, r.domain.high
    if low is None:
        return "all values" if high is None else f"values up to {float(high):.6g}"
    if high is None:
        return f"all values {'≥' if r.domain.holds_low else '>'} {float(low):.6g}"
    return f"values from {float(low):.6g} to {float(high):.6g}"


def _answer(r: Requirement) -> Phrase:
    kept = listed(dict.fromkeys(x.kept for x in r.criteria))
    if not r.feasible:
        known = "No value that was asked about makes" if r.certified else "No value is proven to make"
        return f"{known} the display ", kept, "."
    return "The display is ", kept, " exactly for " if r.certified else ", proven, for ", sets(r), "."


def sets(r: Requirement) -> Phrase:
    """The values, as in a sentence: ``omega_n ≥ 122.36 rad/s``; ``no value`` for none."""
    return listed((_span(x, r.free) for x in r.feasible), "or") if r.feasible else "no value"


def _span(x: Span, free: Knob) -> Phrase:
    name, unit = named(free.symbol.name), _unit(free)
    low, high = x.low.value, x.high.value
    if low is None and high is None:
        return "every value of ", name
    if low is not None and low is high:
        return name, " = ", short(low), unit, " alone"
    if low is not None and high is None:
        return name, " ≥ " if x.low.closed else " > ", short(low), unit
    left = () if low is None else (short(low), _below(x.low))
    right = () if high is None else (_below(x.high), short(high))
    return left, name, right, unit


def _below(end: End) -> str:
    return " ≤ " if end.closed else " < "


def _unit(free: Knob) -> str:
    return "" if free.unit == "1" else f" {unit_text(free.unit)}"


def _nearest(r: Requirement) -> Iterator[Block]:
    """Where no value will do: the nearest one found, what binds there, and what was proven about all others."""
    x = r.nearest
    if x is None:
        return
    least = (
        f"Proven: no value that was asked about keeps all ratios below {x.at_least:.4g} times their thresholds."
        if x.at_least > 1
        else "How near other values come was not proven."
    )
    yield Paragraph((
        "Nearest of those that were tried is ", named(r.free.symbol.name), " = ", Number(f"{float(x.value):.6g}", float(x.value)),
        _unit(r.free), ": ", _part(x.binding), f" reaches {100 * float(x.ratio):.4g}\xa0% there (", _where(x.binding),
        f"), {x.times:.4g} times its threshold. {least}",
    ))  # fmt: skip


def _ends(r: Requirement) -> Iterator[Block]:
    rows = [(exactly(x.value, r.digits), _part(b), _where(b)) for x in r.ends for b in x.bindings if x.value]
    if rows:
        columns = Column(_heading(r.free), number=True), Column("binds"), Column("where")
        yield Table(columns, tuple(rows), "What binds at each end, proven.")
    elif r.feasible:
        yield Paragraph("Nothing binds at an end.")


def _heading(free: Knob) -> Phrase:
    return named(free.symbol.name), "" if free.unit == "1" else f" ({unit_text(free.unit)})"


def _part(b: Binding) -> Phrase:
    if b.criterion.name in ("stable", "passive"):
        return b.criterion.words
    return symbol(b.criterion.symbol), f" ({b.criterion.name})" if b.part else ""


def _where(b: Binding) -> Phrase:
    place = _OF_ALL[b.kind] if b.criterion.name == "passive" else _PLACES[b.kind]
    return place, "" if b.omega is None else (", ", both(b.omega))


def _formulas(r: Requirement) -> Iterator[Block]:
    forms = tuple(Line(named(r.free.symbol.name), form) for form in r.forms if form is not None)
    if forms:
        yield Section("Closed form, from the condition at the end of the band:", (Equations(forms),))


def _certain(r: Requirement) -> Phrase:
    if r.undecided:
        where = listed(f"{_limit(a)} to {_limit(b)}" for a, b in r.undecided)
        why = "" if r.limit is None else f" within the limit of {r.limit:g} s"
        return (
            Strong("UNDECIDED"),
            ": for the values from ",
            where,
            f" neither was proven{why}. About all others everything is.",
        )
    if not r.feasible:
        return "Certain: none that will do was missed; that is proven, not sampled."
    if any(isinstance(end.value, Sliver) for span in r.feasible for end in (span.low, span.high)):
        return "Certain: each end lies within the enclosure that is given; of some no more digits are known."
    return "Certain: these are all such values, none is missed and none invented; every digit is proven, not sampled."


def _limit(x: RealNumber | None) -> str:
    return "infinity" if x is None else f"{float(x):.6g}"


# A map of two parameters.

_WORDS = {"transparent": "transparent", "stable": "stable", "passive": "fit for every passive hand"}
_MOST_ROWS = 10  # of slices that are listed; the document of JSON has them all


def map_page(m: DesignMap) -> Document:
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
        "Certain: every value of a slice is proven."
        if m.certified
        else (Strong("UNDECIDED"), " in some slices", _in_time(m), ": see --json.")
    )
    last = certain, " ", _between(m)
    shown = "Values that will do, along exact slices, with what binds at their ends."
    figure = Figure("map", shown, m.figure)
    beside = *_stiffest(m), *_contours(m), *_classical(m)
    blocks = Facts(tuple(_wished(m))), Paragraph(said), _slices(m), *beside, figure, Paragraph(last)
    return Document(title(m.scene), lead(m.scene, m.asides()), blocks, "Which values will do")


def _in_time(m: DesignMap) -> str:
    """Whether it is for lack of time that something was left open."""
    return ", for which there was no time left" if any(r.limit is not None for x in m.slices for r in x.sets) else ""


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
        off = (
            " by ",
            most,
            _unit(m.free[1]),
            share,
            " at the most, as estimated from how its boundary bends at the slices",
        )
    apart = sum(1 for x in m.gaps if x.deviation is None)
    pairs = "one pair" if apart == 1 else f"{apart} pairs"
    others = f" Between {pairs} of slices, which differ in kind or are undecided, nothing is said." if apart else ""
    more = " --slices N gives more of them." if m.is_coarse or m.within is None else ""
    return "Between slices the figure draws straight lines, off", off, "; that is not proven.", others, more


def _stiffest(m: DesignMap) -> Iterator[Block]:
    """Of a map along a wall's damping, the stiffest wall."""
    if m.stiffest is None:
        return
    at, top = m.stiffest
    (b, k), damping = m.free, float(at.at)
    yield Paragraph((
        "The stiffest wall of these slices that is ", listed(x.kept for x in m.criteria if x.name == "stable"), " stays below ",
        named(k.symbol.name), " = ", short(top), _unit(k), ", at ", named(b.symbol.name), " = ",
        Number(f"{damping:.6g}", damping), _unit(b), ".",
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
        Column(_heading(m.free[0]), number=True),
        Column("will do" if len(m.that) > 1 else f"{_WORDS[m.that[0]]} for"),
    )
    return Table(columns, tuple((Number(f"{at:.6g}", at), found) for at, found in rows), "Some of the slices, proven.")
