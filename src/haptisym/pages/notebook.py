"""What values look like in notebooks and papers: formulas as LaTeX, tables and sentences as
HTML.

The classes themselves know neither LaTeX nor HTML: ``Viewed`` finds what is here when a value is
shown. Two tables, from class to function, say what each class looks like; a subclass looks like the
nearest of its bases that is in the table.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import singledispatch
from html import escape
from typing import Any

from sympy import Basic, Expr, ImmutableMatrix

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Crossing, Judged
from haptisym.judge.peaks import Peak
from haptisym.judge.percepts import Percept, felt
from haptisym.kernel.reals import ExactNumber, RealNumber, Way, printed
from haptisym.kernel.rings import s
from haptisym.kernel.roots import Interval, Point
from haptisym.kernel.solutions import Solution
from haptisym.model.asymptotes import Asymptote, LowFrequency
from haptisym.model.catalogue import Effect, Environment
from haptisym.model.distortion import Changeovers, CrossingSolutions, Distortion
from haptisym.model.jnd import Threshold
from haptisym.model.parameters import Parameter
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import Scene
from haptisym.pages import scene as scene_page
from haptisym.pages.derive import explained, step_lines
from haptisym.pages.evaluation import VERBS, event, sense
from haptisym.pages.scene import ClosedForms
from haptisym.pages.words import PART_NAMES, both, ends, near, region
from haptisym.programs.steps import Steps
from haptisym.verbs.derive.derivation import Derivation
from haptisym.writing.boxes import Box, MatrixBox, Relation
from haptisym.writing.document import DIGITS, Equations, Line
from haptisym.writing.html import display, element, fragment, phrase
from haptisym.writing.latex import align, formula, is_long, tables, tex
from haptisym.writing.layout import function, layout, named, rounded
from haptisym.writing.plain import said


@singledispatch
def latex(value: Any, *, digits: int = DIGITS) -> str:
    r"""LaTeX of a SymPy expression, of a Distortion (its formulas, an ``align*``), of an answer
    (its tables), or of several formulas or numbers (an ``align*`` with a line for each).

    Formulas stand in descending powers of s or omega, ascending where that avoids a leading minus;
    nothing in them is rounded.
    ``digits`` : of the numbers of tables.
    Raises TypeError for anything else.

    >>> from sympy import Rational
    >>> from haptisym.kernel.rings import omega, s, symbols
    >>> m, b, k, omega_n, zeta = symbols("m b k omega_n zeta")
    >>> latex(Rational(9, 5) * s**2 + b * s + k), latex(k - m * omega**2)
    ('1.8 s^{2} + b s + k', 'k - m \\omega^{2}')
    >>> latex(omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2))
    '\\frac{\\omega_n^{2}}{s^{2} + 2 \\zeta \\omega_n s + \\omega_n^{2}}'
    """
    shown = as_latex(value)
    if shown is None:
        raise TypeError(
            f"no LaTeX for {type(value).__name__}: give an expression, a Distortion or an answer"
        )
    return shown.removeprefix(r"$\displaystyle ").strip("$").replace("aligned", "align*")


@latex.register
def _(value: Basic, *, digits: int = DIGITS) -> str:
    return formula(value)


@latex.register
def _(value: Distortion, *, digits: int = DIGITS) -> str:
    return align(_explained(ClosedForms(value.with_one_delay).all()))


@latex.register
def _(value: Answer, *, digits: int = DIGITS) -> str:
    return tables(value.document(), digits)


@latex.register
def _(value: Derivation, *, digits: int = DIGITS) -> str:
    # Of a distortion in symbols there is no table of values.
    return tables(value.document(), digits) or latex(value.distortion)


# Notebooks.


_PER_SECOND = r"\,\mathrm{rad/s}"


def as_latex(x: Any) -> str | None:
    """LaTeX of a formula or a number; None for anything else.

    >>> from haptisym.model.jnd import Threshold
    >>> Threshold.of("0.1")._repr_latex_()
    '$\\\\displaystyle c = 0.1$'
    """
    return _shown(_LATEX, x)


def as_html(x: Any) -> str | None:
    """HTML of a table, a sentence or a page; None for anything else."""
    return _shown(_HTML, x)


def _shown(views: Mapping[type, Callable[[Any], str]], x: Any) -> str | None:
    # In the order of resolution: the view of the nearest base.
    """Return a value as the table of views has it; None where no base of its class is there."""
    kind = next((kind for kind in type(x).__mro__ if kind in views), None)
    return None if kind is None else views[kind](x)


# LaTeX, for what is a formula or a number.


def _displayed(*parts: str) -> str:
    """Return LaTeX as a formula of its own line."""
    return rf"$\displaystyle {''.join(parts)}$"


def _environment(x: Environment) -> str:
    """Return H(s) of an environment, and the values of its parameters."""
    equation = tex(Relation((function("H", layout(s)), layout(x.dynamics)), ("=",)))
    return _displayed(equation, _given(x.parameters))


def _effect(x: Effect) -> str:
    """Return an effect as the matrix that takes force and motion of the environment to those of the
    hand."""
    a, b, c, d = x.dynamics
    chain = tex(layout(ImmutableMatrix([[a, b], [c, d]])))
    hand, environment = (tex(MatrixBox(((named(f"F_{y}"),), (named(f"X_{y}"),)))) for y in "he")
    return _displayed(f"{hand} = {chain} {environment}", _given(x.parameters))


def _solution(x: Solution) -> str:
    """Return the formula of a solution with its period and its conditions; or the equation."""
    if x.omega is None:
        return _displayed(formula(x.equation), " = 0")
    turns = rf" + {formula(x.period)} n" if x.period else ""
    return _displayed(
        rf"{formula(x.parameter)} = {formula(x.omega)}",
        turns,
        *(rf",\quad {formula(y)} > 0" for y in x.conditions),
    )


def _solutions(x: Changeovers | CrossingSolutions) -> str:
    """Return all formulas or numbers, a line each, with what they are of."""
    lines = [
        rf"&\text{{{name}:}} & & {latex(y)}"
        for name, found in zip(x._fields, x, strict=True)
        for y in found
    ]
    return _aligned(lines or [r"&\text{none}"])


def _listed(x: Sequence[Any]) -> str:
    """Return several formulas or numbers, a line each."""
    lines = [latex(y) for y in x]
    for y, line in zip(x, lines, strict=True):
        if r"\begin{align" in line or r"\begin{t" in line:
            raise TypeError(f"no LaTeX for several of {type(y).__name__}: write each by itself")
    return _aligned([f"&{line}" for line in lines] or [r"&\text{none}"])


def _parts(x: Asymptote | LowFrequency) -> str:
    """Return a few expressions, a line each, with what they are."""
    return _aligned(
        rf"&\text{{{name}:}} & & {formula(y)}" for name, y in zip(x._fields, x, strict=True)
    )


def _aligned(lines: Iterable[str]) -> str:
    """Return lines of LaTeX as one formula."""
    separated = " \\\\\n  ".join(lines)
    return f"$$\\begin{{aligned}}\n  {separated}\n\\end{{aligned}}$$"


def _steps(x: Steps) -> str:
    """Return the steps and what they result in, a line each."""
    return f"$${align(_explained([*step_lines(x)])).replace('align*', 'aligned')}$$"


def _given(parameters: Iterable[Parameter]) -> str:
    """Return the values of those parameters that have one."""
    return "".join(
        rf",\quad {_value(named(p.symbol.name), p.value)}{_unit(p)}"
        for p in parameters
        if p.value != p.symbol
    )


def _unit(p: Parameter) -> str:
    """Return the unit of a parameter in upright letters; nothing for a number."""
    unit = p.unit_in(p.motion or MotionKind.TRANSLATION).replace("*", r"\,")
    return rf"\,\mathrm{{{unit}}}" if unit not in ("", "1") else ""


def _value(name: Box, value: Expr) -> str:
    """``name = value``, and a decimal where the value is no rational number."""
    if value.is_Rational or value.free_symbols:
        return tex(Relation((name, layout(value)), ("=",)))
    decimal = layout(value.evalf(6) if value.is_algebraic else rounded(value))
    return tex(Relation((name, layout(value), decimal), ("=", "≈")))


def _distortion(x: Distortion) -> str:
    """Return the readable formulas of a distortion, aligned."""
    return f"$${align(_rows(x)).replace('align*', 'aligned')}$$"


def _rows(x: Distortion) -> list[Line]:
    """Dynamics, distortion and ratios, as far as they can be read."""
    forms = ClosedForms(x.with_one_delay)
    rows = [*forms.dynamics(), *forms.difference(), *forms.ratios()]
    return _explained([row for row in rows if row.optional or not is_long(row.value)])


def _explained(rows: Iterable[Line]) -> list[Line]:
    """Return equations with the definitions of the first harmonics in them."""
    [found] = explained([Equations(tuple(rows))])
    return [*found.lines]


def _threshold(x: Threshold) -> str:
    """Return the limits of a JND; a region in words."""
    if not x.is_plain:
        return _displayed(rf"\text{{{said(region(x))}}}")
    if x.real == x.imag:
        return _displayed(_value(named("c"), x.real))
    return _displayed(_value(named("c_real"), x.real), r",\quad ", _value(named("c_imag"), x.imag))


def _number(x: RealNumber) -> str:
    # A number without a closed form is printed by its proven digits.
    """Return a number: exact where it has a closed form, with a decimal beside a root."""
    if not isinstance(x, ExactNumber):
        return _displayed(_decimal(x.digits()))
    if x.value.is_Rational:
        return _displayed(tex(layout(x.value)))
    return _displayed(tex(Relation((layout(x.value), layout(rounded(x.value, 15))), ("≈",))))


def _decimal(digits: str) -> str:
    """Return digits with an exponent as a power of ten."""
    mantissa, _, exponent = digits.partition("E")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


def _short(x: RealNumber) -> str:
    """Return a number in the digits of a page."""
    mantissa, _, exponent = printed(x, DIGITS, Way.NEAREST).partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


def _crossing(x: Crossing) -> str:
    # A limit that is no number, or a region: an equation could not say what is met, so it is a
    # sentence.
    """Return a crossing as an equation: the ratio is its threshold, and omega."""
    if x.criterion.region or x.criterion.threshold.free_symbols:
        return _displayed(
            rf"\text{{{said(event(x))} at}}\ \omega = {_decimal(x.omega.digits())}{_PER_SECOND}"
        )
    threshold = tex(named(f"c_{x.criterion.name}"))
    return _displayed(
        rf"{_ratio(x)} = {threshold},\quad \omega = {_decimal(x.omega.digits())}{_PER_SECOND}"
    )


def _peak(x: Peak) -> str:
    """Return a local maximum: the ratio's value, and omega."""
    return _displayed(
        rf"{_ratio(x)} = {_short(x.ratio)},\quad \omega = {_short(x.omega)}{_PER_SECOND}"
    )


def _ratio(x: Judged) -> str:
    """Return the symbol of the ratio that a criterion judges."""
    return tex(named(x.criterion.symbol))


def _point(x: Point) -> str:
    """Return a frequency of a chart."""
    return _displayed(rf"\omega = {_decimal(x.omega.digits())}{_PER_SECOND}")


def _interval(x: Interval) -> str:
    """Return an interval of frequencies."""
    return _displayed(
        rf"\left[ {_short(x.low.omega)},\, {_short(x.high.omega)} \right]{_PER_SECOND}"
    )


_LATEX: Mapping[type, Callable[[Any], str]] = {
    Environment: _environment,
    Effect: _effect,
    Distortion: _distortion,
    Derivation: lambda x: _distortion(x.distortion),
    Steps: _steps,
    Changeovers: _solutions,
    CrossingSolutions: _solutions,
    Asymptote: _parts,
    LowFrequency: _parts,
    tuple: _listed,
    list: _listed,
    Threshold: _threshold,
    RealNumber: _number,
    Solution: _solution,
    Crossing: _crossing,
    Peak: _peak,
    Point: _point,
    Interval: _interval,
}


# HTML, for what is a table or a sentence.


def _answer_html(x: Answer) -> str:
    """Return the page of an answer, or its text where that is all it has."""
    page = x.document()
    return (
        f'<pre class="haptisym">{escape(page)}</pre>' if isinstance(page, str) else fragment(page)
    )


def _crossing_html(x: Crossing) -> str:
    """``r_r exceeds its threshold at 7.979 rad/s (1.270 Hz) (Re dH > 0)``."""
    if x.criterion.joint:
        return str(phrase((event(x), " at ", both(x.omega))))
    where = both(x.omega), " (", sense(x), ")"
    return str(phrase((named(x.criterion.symbol), f" {VERBS[x.kind]} its threshold at ", where)))


def _peak_html(x: Peak) -> str:
    """Return a local maximum in a sentence."""
    return str(
        phrase(
            (
                named(x.criterion.symbol),
                " has a local maximum of ",
                near(x.ratio),
                " at ",
                both(x.omega),
            )
        )
    )


def _percept_html(x: Percept) -> str:
    """``lower mass (real part), from 7.9789 to 15 rad/s``."""
    which = f"{PART_NAMES[x.part]} part" if x.part else "both parts together"
    return str(phrase((f"{felt(x)} ({which}), from ", ends(x.band), " rad/s")))


_HTML: Mapping[type, Callable[[Any], str]] = {
    Answer: _answer_html,
    Scene: lambda x: fragment(scene_page.page(x)),
    Crossing: _crossing_html,
    Peak: _peak_html,
    Distortion: lambda x: str(element("div", display(_rows(x)), given={"class": "haptisym"})),
    Percept: _percept_html,
}
