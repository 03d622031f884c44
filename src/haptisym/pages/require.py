"""A requirement as a page of text: the answer in a sentence, what binds at each end, what is certain."""

from __future__ import annotations

from math import ceil
from textwrap import fill

from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver
from haptisym.model.jnd import Part
from haptisym.pages.lines import WIDTH, both, listed, short, table
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Binding, Kind, Span
from haptisym.verbs.require.required import Requirement
from haptisym.writing.mathtext import plain


def page(r: Requirement) -> str:
    """The whole page."""
    parts = [_heading(r), _question(r), _answer(r), _nearest(r), _ends(r), _formula(r), _certain(r)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(r: Requirement) -> str:
    return "\n".join(fill(line, WIDTH) for line in (r.scene.title or "Untitled scene", *r.asides()))


def _question(r: Requirement) -> str:
    low, high = (both(x) for x in _band(r))
    kept = {None: "|G - 1| <= c", Part.REAL: "r_r <= c_real", Part.IMAG: "r_i <= c_imag"}
    rows = [
        ("free", f"{r.free.path} ({r.free.symbol.name}), {_unit(r.free.unit)}"),
        ("asked", _asked(r)),
        ("band", f"{low} to {high}"),
        ("condition", f"{' and '.join(kept[part] for part in r.keys)} on the whole band"),
    ]
    return "\n".join(f"  {key:<11} {text}" for key, text in rows)


def _unit(unit: str) -> str:
    return "a plain number" if unit == "1" else f"in {unit}"


def _band(r: Requirement) -> list[RealNumber]:
    return [ExactNumber(x) for x in r.scene.band]


def _asked(r: Requirement) -> str:
    low, high = r.domain.low, r.domain.high
    if low is None:
        return "all values" if high is None else f"values up to {float(high):.6g}"
    if high is None:
        return f"all values {'>=' if r.domain.holds_low else '>'} {float(low):.6g}"
    return f"values from {float(low):.6g} to {float(high):.6g}"


def _answer(r: Requirement) -> str:
    who = "with any environment whatever" if r.keys == (None,) else "on the whole band"
    if not r.feasible:
        known = "No value that was asked about makes" if r.certified else "No value is proven to make"
        return fill(f"{known} the display transparent {who}.", WIDTH)
    known = f"The display is transparent {who}"
    return fill(f"{known} exactly for {sets(r)}." if r.certified else f"{known}, proven, for {sets(r)}.", WIDTH)


def _nearest(r: Requirement) -> str:
    """Where no value will do: the nearest one found, what binds there, and what was proven about all others."""
    x = r.nearest
    if x is None:
        return ""
    unit = "" if r.free.unit == "1" else f" {r.free.unit}"
    said = (
        f"Nearest of those that were tried is {r.free.symbol.name} = {float(x.value):.6g}{unit}: {_part(x.binding)} reaches "
        f"{100 * float(x.ratio):.4g} % there ({_where(x.binding)}), {x.times:.4g} times its threshold."
    )
    least = (
        f"Proven: no value that was asked about keeps all ratios below {x.at_least:.4g} times their thresholds."
        if x.at_least > 1
        else "How near other values come was not proven."
    )
    return fill(f"{said} {least}", WIDTH)


def sets(r: Requirement) -> str:
    """The values, as in a sentence: "omega_n >= 122.36 rad/s"; "no value" for none."""
    if not r.feasible:
        return "no value"
    return listed([_span(x, r.free.symbol.name, r.free.unit) for x in r.feasible], "or")


def _span(x: Span, name: str, unit: str) -> str:
    unit = "" if unit == "1" else f" {unit}"
    low, high = x.low.value, x.high.value
    if low is None and high is None:
        return f"every value of {name}"
    if x.low is x.high or (low is not None and low is high):
        return f"{name} = {short(low)}{unit} alone" if low is not None else name
    left = "" if low is None else f"{short(low)} {'<=' if x.low.closed else '<'} "
    right = "" if high is None else f" {'<=' if x.high.closed else '<'} {short(high)}"
    if low is not None and high is None:
        return f"{name} {'>=' if x.low.closed else '>'} {short(low)}{unit}"
    return f"{left}{name}{right}{unit}"


def _ends(r: Requirement) -> str:
    rows = [(end.value.digits(r.digits), _part(b), _where(b)) for end in r.ends for b in end.bindings if end.value]
    if not rows:
        return "  Nothing binds at an end." if r.feasible else ""
    return table((f"{r.free.symbol.name} ({r.free.unit})", "binds", "where"), rows)


def _part(b: Binding) -> str:
    return "|G - 1|" if b.part is None else "r_r (real)" if b.part is Part.REAL else "r_i (imag)"


def _where(b: Binding) -> str:
    place = "" if b.omega is None else f", {both(b.omega)}"
    return {Kind.EDGE: "the band's high end", Kind.START: "the band's low end", Kind.TOUCH: "a touch inside the band"}[
        b.kind
    ] + place


def _formula(r: Requirement) -> str:
    name = r.free.symbol.name
    forms = [f"{name} = {plain(form)}" for form in r.forms if form is not None]
    if not forms:
        return ""
    rows = [fill(form, WIDTH, initial_indent="  ", subsequent_indent=" " * 8) for form in forms]
    return "\n".join(["Closed form, from the condition at the end of the band:", *rows])


def _certain(r: Requirement) -> str:
    if r.undecided:
        where = listed([f"{_limit(a)} to {_limit(b)}" for a, b in r.undecided], "and")
        why = "" if r.limit is None else f" within the limit of {r.limit:g} s"
        said = f"UNDECIDED: for the values from {where} neither was proven{why}. About all others everything is."
        return fill(said, WIDTH)
    if not r.feasible:
        return "Certain: none that will do was missed; that is proven, not sampled."
    if any(isinstance(end.value, Sliver) for span in r.feasible for end in (span.low, span.high)):
        return fill(
            "Certain: each end lies within the enclosure that is given; of some no more digits are known.", WIDTH
        )
    return fill(
        "Certain: these are all such values, none is missed and none invented; every digit is proven, not sampled.",
        WIDTH,
    )


def _limit(x: RealNumber | None) -> str:
    return "infinity" if x is None else f"{float(x):.6g}"


# A map of two parameters.


def map_page(m: DesignMap) -> str:
    """The page of a map: how many slices hold values that do, some of them, what is certain."""
    a, b = m.free
    some = [x for x in m.slices if x.requirement.feasible]
    where = f"{len(some)} of them hold values of {b.symbol.name} that make the display transparent on its whole band"
    kinds = sorted({y.kind.value for x in some for e in x.requirement.ends for y in e.bindings})
    lines = [
        m.scene.title or "Untitled scene",
        *m.asides(),
        f"{len(m.slices)} exact slices along {a.symbol.name}: {where}.",
        f"The boundary is a {listed(kinds)} curve." if kinds else "",
    ]
    certain = (
        "Certain: every value of a slice is proven. Between slices the figure draws straight lines, which prove nothing; "
        "--slices N gives more of them."
    )
    last = certain if m.certified else "UNDECIDED in some slices: see --json."
    head = "\n".join(fill(line, WIDTH) for line in lines if line)
    return "\n\n".join((head, _slices(m), fill(last, WIDTH))) + "\n"


_MOST_ROWS = 10  # of slices that are listed; the document has them all


def _slices(m: DesignMap) -> str:
    """Some of the slices, the first and the last one among them."""
    a = m.free[0]
    step = ceil((len(m.slices) - 1) / _MOST_ROWS)
    shown = [*m.slices[:-1:step], m.slices[-1]]
    unit = "" if a.unit == "1" else f" ({a.unit})"
    rows = [(f"{float(x.at):.6g}", sets(x.requirement)) for x in shown]
    return table((f"{a.symbol.name}{unit}", "transparent for"), rows)
