"""An evaluation as a page of text that reads like section 3 of the paper: the questions, the answers, what is certain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Context
from io import StringIO
from math import inf, pi
from textwrap import fill

from sympy import Expr, Symbol

from haptisym.judge.answers import Answers
from haptisym.judge.crossings import Crossing
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Interval, Point
from haptisym.kernel.symbols import omega, s
from haptisym.model.jnd import Part
from haptisym.model.quantities import Motion
from haptisym.writing.equations import equation
from haptisym.writing.formula import readable
from haptisym.writing.mathtext import text

WIDTH = 96
NOT_HELD = "Whether the display is stable in a hand was not looked at."
"""Said beside every word about imposed motion, which is easily taken for more."""
_DIGITS = 5  # of frequencies in sentences; the table of crossings shows all that were asked for


def report(e: Answers) -> str:
    """The whole page."""
    parts = [
        _heading(e),
        _pruned(e),
        _dynamics(e),
        _step_1(e),
        _step_2(e),
        caveats_text(e.caveats),
        _certain(e),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _heading(e: Answers) -> str:
    lines = [e.scene.title or "Untitled scene", e.scene.source, *e.given.asides()]
    return "\n".join(fill(line, WIDTH) for line in lines if line)


def _pruned(e: Answers) -> str:
    """What was left out of the scene, and what that changes at most."""
    r = e.relevance
    if r is None or not r.dropped:
        return ""
    bounds = (
        f"r_r by at most {rounded_up(r.bound[Part.REAL].most)} and r_i by at most {rounded_up(r.bound[Part.IMAG].most)}"
    )
    spans = listed(f"{_rounded(x.bounds)} ({x.part.value})" for x in r.crossings)
    crossings = f"Its crossings lie in {spans} rad/s" if spans else "It has no crossings on the band"
    return fill(
        f"Without {listed(x.name for x in r.dropped)}: leaving them out changes {bounds} anywhere on the band, proven "
        f"(tolerance {float(r.tolerance):g}). What follows is exact for the scene without them. The full scene differs by no "
        f"more than that. {crossings}.",
        WIDTH,
    )


def rounded_up(value: float) -> str:
    """Three digits, rounded up, so that a bound stays one."""
    if value == inf:
        return "unbounded"
    return f"{Context(prec=3, rounding=ROUND_CEILING).create_decimal_from_float(value):.3g}"


def _rounded(ends: tuple[float, float]) -> str:
    return f"[{ends[0]:.6g}, {ends[1]:.6g}]"


def _dynamics(e: Answers) -> str:
    unit = "N m/rad" if e.scene.motion is Motion.ROTATION else "N/m"
    c = e.scene.threshold
    limits = percent(c.real) if c.real == c.imag else f"{percent(c.real)} (real) and {percent(c.imag)} (imaginary)"
    low, high = (e.chart.points[i].omega for i in (0, -1))
    d = e.distortion
    rendered = d.env.ring.convert(e.scene.rendered.H) if e.scene.rendered else None
    rows = [
        ("environment", f"{_equation('H_env', d.env, s)}  {unit}"),
        *([("rendered", f"{_equation('H_rendered', rendered, s)}  {unit}")] if rendered else []),
        ("effects", ", ".join(_effect(x.name, x.model) for x in e.scene.effects) or "none"),
        ("perceived", f"{_equation('H_perc', d.perc, s)}  {unit}"),
        ("distortion", _equation("Re dH", d.difference_response.real.written, omega)),
        ("", _equation("Im dH", d.difference_response.imag.written, omega)),
        ("band", f"{both(low)} to {both(high)}"),
        ("threshold", f"{limits} of |H_env|"),
    ]
    return "\n".join(fill(text, WIDTH, initial_indent=f"  {key:<13}", subsequent_indent=" " * 19) for key, text in rows)


def _equation(name: str, function: RationalFunction, variable: Symbol) -> str:
    form, is_rounded = readable(function, variable)
    return text(equation(name, form, relation="≈" if is_rounded else "=")).replace("omega", "ω")


def _effect(name: str, model: str) -> str:
    return name if name == model else f"{name} ({model})"


def _step_1(e: Answers) -> str:
    question = "Step 1. When does the hand begin to notice?"
    parts = [_indented(_transparency(e)), _crossings(e), *map(_indented, _any_environment(e))]
    return "\n\n".join([question, *parts])


def _any_environment(e: Answers) -> list[str]:
    found = e.any_environment
    if found is None or not e.scene.effects:
        return []
    below, above, end = found.transparent_below, found.opaque_above, e.chart.points[-1].omega
    if below is end:
        return ["These effects in series stay unnoticed with any environment whatever on this band."]
    upto = (
        "Already at the low end of the band these effects in series are noticed with some environment"
        if below is None
        else f"With any environment whatever, up to {short(below)} rad/s these effects in series stay unnoticed"
    )
    return [f"{upto}{'' if above is None else f'; with every one they are noticed above {short(above)} rad/s'}."]


def _transparency(e: Answers) -> str:
    if not e.transparent:
        return "At every frequency of the band: the display is transparent nowhere."
    pieces = listed(span(x) for x in e.transparent)
    if len(e.transparent) == 1 and e.bandwidth is not None and e.transparent[0].high is e.chart.points[-1]:
        return "Never on this band: the display is perceptually transparent on the whole of it."
    if e.bandwidth is None:
        return f"From the low end of the band on. The display is perceptually transparent only {pieces}."
    if len(e.transparent) == 1:
        return f"At {both(e.bandwidth)}. Below that the display is perceptually transparent: this is its bandwidth."
    return f"At {both(e.bandwidth)}, its bandwidth. The display is perceptually transparent {pieces}."


def span(x: Interval) -> str:
    if x.low is x.high:
        return f"at {both(x.low.omega)} alone"
    return f"from {short(x.low.omega)} to {short(x.high.omega)} rad/s"


_VERB = {"exceeds": "rises above", "returns": "falls below", "touches": "touches"}


def _crossings(e: Answers) -> str:
    if not e.crossings:
        return f"  No ratio meets its threshold on the band{', as far as that was decided' if e.undecided else ''}."
    headings = ("part", "ω (rad/s)", "Hz", "what happens", "distortion")
    rows = [(c.part.value, c.omega.digits(e.digits), _hertz(c.omega), _event(e, c), _sense(c)) for c in e.crossings]
    return table(headings, rows)


def _event(e: Answers, c: Crossing) -> str:
    ratio = "r_r" if c.part is Part.REAL else "r_i"
    times = f" ({c.multiplicity}-fold)" if c.multiplicity > 1 else ""
    return f"{ratio} {_VERB[c.kind.value]} {percent(e.scene.threshold[c.part])}{times}"


def _sense(c: Crossing) -> str:
    return f"{'Re' if c.part is Part.REAL else 'Im'} dH {'> 0' if c.sign > 0 else '< 0'}"


def _step_2(e: Answers) -> str:
    lines = ["Step 2. How is it felt?", ""]
    if e.felt:
        rows = [(f"{short(x.band.low.omega)} to {short(x.band.high.omega)}", x.part.value, x.words) for x in e.felt]
        lines += [table(("band (rad/s)", "part", "felt as"), rows), ""]
    else:
        lines += ["  Nothing is noticed on the band: neither ratio exceeds its threshold.", ""]
    notes = [*_changeover_note(e), *_activity_note(e), *_unbounded_note(e), _stability_note(e)]
    return "\n".join([*lines, *(_indented(note) for note in notes)])


def _changeover_note(e: Answers) -> Iterable[str]:
    env, perc = (_places(x) for x in (e.changeovers_environment, e.changeovers_perceived))
    if env or perc:
        nowhere = "no frequency"
        yield f"Spring and inertia change over at {env or nowhere} in the environment, at {perc or nowhere} as felt."


def _activity_note(e: Answers) -> Iterable[str]:
    if e.outside_model:
        where = listed(span(x) for x in e.outside_model)
        noticed = "so that no property is named for what is noticed there" if e.unnamed else "but not noticed there"
        yield f"The imaginary part is outside the paper's model {where}, {noticed}: the display is active (Im H_perc < 0)."


def _unbounded_note(e: Answers) -> Iterable[str]:
    if e.unbounded:
        yield f"A ratio is unbounded at {_places(e.unbounded)}: nothing to compare with there (H_env = 0, or dH infinite)."


def _stability_note(e: Answers) -> str:
    if e.stable is None:
        return f"Whether the force under imposed motion is stable was not decided. {NOT_HELD}"
    if e.stable:
        return f"The force under imposed motion is stable: all poles of H_perc have Re s < 0. {NOT_HELD}"
    return "The force under imposed motion is NOT stable: a pole of H_perc has Re s >= 0."


def caveats_text(caveats: Iterable[str]) -> str:
    """What the answers do not say, a paragraph each."""
    return "\n".join(fill(f"But: {caveat}", WIDTH) for caveat in caveats)


def _certain(e: Answers) -> str:
    if e.undecided:
        where = listed(f"{short(point.omega)} rad/s ({part.value})" for part, point in e.undecided)
        return fill(
            f"UNDECIDED at the precision limit: whether a ratio touches its threshold, crosses it twice or stays clear of it "
            f"near {where}. Everything else is proven.",
            WIDTH,
        )
    return fill(
        "Certain: these are all crossings on the band, none is missed and none invented; every digit, sign and interval "
        "is proven by exact polynomials and ball arithmetic, not sampled.",
        WIDTH,
    )


def _places(points: Iterable[Point]) -> str:
    found = [short(p.omega) for p in points]
    return f"{listed(found)} rad/s" if found else ""


def listed(items: Iterable[str], word: str = "and") -> str:
    """Items in a sentence: "one, two and three"."""
    *first, last = [*items] or [""]
    return f"{', '.join(first)} {word} {last}" if first else last


def both(x: RealNumber) -> str:
    """A frequency in rad/s and Hz."""
    return f"{short(x)} rad/s ({_hertz(x)} Hz)"


def short(x: RealNumber) -> str:
    """A number with the digits that a sentence takes."""
    return _trimmed(x.digits(_DIGITS))


def _hertz(x: RealNumber) -> str:
    return f"{float(x) / (2 * pi):.5g}"


def _trimmed(digits: str) -> str:
    return digits.rstrip("0").rstrip(".") if "." in digits and "E" not in digits else digits


def percent(c: Expr) -> str:
    return f"{float(100 * c):.6g} %"


def _indented(text: str) -> str:
    return fill(text, WIDTH, initial_indent="  ", subsequent_indent="  ")


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table as lines of text."""
    from rich import box  # Rich is loaded only where a page of text is wanted
    from rich.console import Console
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in headings:
        made.add_column(heading, overflow="fold")
    for row in rows:
        made.add_row(*row)
    console = Console(file=StringIO(), width=WIDTH - 2, color_system=None, legacy_windows=False)
    with console.capture() as captured:
        console.print(made)
    return "\n".join(f"  {line}".rstrip() for line in captured.get().rstrip("\n").splitlines())
