"""What a distortion answers by itself: crossings, changeovers, leading terms, bandwidth, as SymPy has them."""

from __future__ import annotations

from collections.abc import Mapping
from math import factorial
from typing import Any, NamedTuple, Protocol

from sympy import Add, Expr, Float, Integer, Poly, Symbol, exp, nan, oo, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, quoted
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction, Response, on_axis
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.solutions import Solution, solve
from haptisym.kernel.symbols import c as symbol_c
from haptisym.kernel.symbols import omega, s
from haptisym.model.given import given_band
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, decimal, number

SQUARE = Symbol("W", positive=True)
"""omega^2, the unknown of a threshold polynomial."""
_TERMS = 8  # of the series of a delay

Frequencies = tuple[Solution, ...] | tuple[RealNumber, ...]
"""Formulas, each with the conditions under which it is in force; or, where all are numbers, certified frequencies."""


class Responses(Protocol):
    """What a ``Distortion`` holds of what is asked here."""

    @property
    def free_symbols(self) -> frozenset[Symbol]:
        """The parameters that are still symbols."""

    @property
    def squared_ratios(self) -> dict[Part, RealFunction]:
        """r_r^2 and r_i^2."""

    @property
    def env_response(self) -> Response:
        """H_env on s = j omega."""

    @property
    def perc_response(self) -> Response:
        """H_perc on s = j omega."""

    @property
    def difference(self) -> RationalFunction:
        """dH."""


class Changeovers(NamedTuple):
    """Where Re H_env and Re H_perc change their sign, all of them."""

    environment: Frequencies
    perceived: Frequencies


class Asymptote(NamedTuple):
    """The leading terms of dH(s), of Re dH and of Im dH in omega."""

    distortion: Expr
    real: Expr
    imag: Expr


class LowFrequency(NamedTuple):
    """What a slow hand feels: H_perc(s) = stiffness + damping s + mass s^2 + terms of higher order."""

    stiffness: Expr
    damping: Expr
    mass: Expr


def part_named(given: Any) -> Part:
    """A part, or its name. SceneError for any other."""
    if given in [x.value for x in Part]:
        return Part(given)
    if not isinstance(given, Part):
        raise SceneError(f"part: {quoted(given)} is neither real nor imag")
    return given


def threshold(given: Any) -> Expr:
    """A fraction > 0 as a number or symbols. SceneError for any other."""
    if isinstance(given, str):
        raise SceneError(f"c: {quoted(given)} must be a number or a symbol, as 0.1 or Rational(1, 10)")
    value = decimal(str(float(given))) if isinstance(given, int | float | Float) else given
    if not isinstance(value, Expr) or value.is_positive is False or value is nan:
        raise SceneError(f"c: {quoted(given)} must be a fraction > 0")
    return value


def excess(d: Responses, part: Part, c: Expr) -> RealFunction:
    """r^2 - c^2 of a part."""
    f = d.squared_ratios[part].function
    square = f.ring.convert(c**2)
    top = f.numerator * square.denominator - square.numerator * f.denominator
    return RealFunction(f.ring.function(top, f.denominator * square.denominator).reduced())


def crossings(d: Responses, part: Part, c: Expr, band: tuple[Any, Any] | None) -> Frequencies:
    """As of ``Distortion.crossings``."""
    if not c.free_symbols:
        return _zeros(d, excess(d, part, c), band, odd=False)
    return tuple(_renamed(x, {symbol_c: c}) for x in solve(excess(d, part, symbol_c)))


def changeovers(d: Responses) -> Changeovers:
    """As of ``Distortion.changeovers``."""
    return Changeovers(*(_zeros(d, x.real, None, odd=True) for x in (d.env_response, d.perc_response)))


def _zeros(d: Responses, f: RealFunction, band: tuple[Any, Any] | None, *, odd: bool) -> Frequencies:
    if d.free_symbols:
        return tuple(x for x in solve(f) if x.order % 2 or not odd)
    low, high = _ends(band) if band else (Integer(0), _far(f))
    points = chart({0: f}, low, high).points
    return tuple(
        p.omega for p in points if (n := p.orders.get(0, 0)) > 0 and (n % 2 or not odd) and (not odd or float(p.omega))
    )


def _ends(band: tuple[Any, Any]) -> tuple[Expr, Expr]:
    low, high = (number(x, Dimension.FREQUENCY).value for x in given_band(band))
    if not 0 <= low < high:
        raise SceneError(f"band: {band} must be a low end >= 0 and a higher one")
    return low, high


def _far(f: RealFunction) -> Expr:
    """A frequency beyond which a function has no zero."""
    if f.function.is_zero:
        return Integer(1)
    if any(not angle.constant for angle in f.axis.angles):
        raise SceneError(
            "with a delay there may be crossings at ever higher frequencies: give a band, as band=(0, 100)"
        )
    found = far(f.function)
    if found.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise SceneError("as far as all crossings lie is not known: give a band, as band=(0, 100)")
    return max(found.radius, Integer(1))


def _renamed(x: Solution, names: Mapping[Symbol, Expr]) -> Solution:
    return Solution(x.omega and x.omega.xreplace(names), x.equation.xreplace(names), x.period.xreplace(names), x.order)


def threshold_polynomial(d: Responses, part: Part, c: Expr) -> Poly | Expr:
    """As of ``Distortion.threshold_polynomial``."""
    f = excess(d, part, symbol_c if c.free_symbols else c)
    found = f.function.expression().as_numer_denom()[0].expand().xreplace({symbol_c: c})
    is_polynomial = found.is_polynomial(omega) and all(n % 2 == 0 for (n,) in Poly(found, omega).monoms())
    return Poly(found.subs(omega, sqrt(SQUARE)), SQUARE) if is_polynomial else found


def bandwidth(d: Responses, c: Expr, band: tuple[Any, Any] | None) -> RealNumber | Expr:
    """As of ``Distortion.bandwidth``."""
    if c.free_symbols or d.free_symbols:
        free = ", ".join(sorted(map(str, c.free_symbols | d.free_symbols)))
        raise SceneError(f"a bandwidth is a number: give {free} values; crossings(part, c) has the formulas")
    functions = {part: excess(d, part, c) for part in Part}
    low, high = _ends(band) if band else (Integer(0), max(map(_far, functions.values())))
    table = chart(functions, low, high)
    kept = table.where(lambda signs: all(x <= 0 for x in signs.values()))
    if not kept or kept[0].low is not table.points[0]:
        return Integer(0)
    return oo if kept[0].high is table.points[-1] and not band else kept[0].high.omega


def asymptote(d: Responses, at: Any) -> Asymptote:
    """As of ``Distortion.asymptote``."""
    if at not in (0, oo):
        raise SceneError(f"at: {quoted(at)} is neither 0 nor oo")
    dynamics = d.difference.expression()
    if at == oo and any(x.has(s) for x in dynamics.atoms(exp)):
        raise SceneError("at = oo: a delay turns for ever, so that there is no leading term")
    near, exact = _near_0(dynamics), on_axis(d.difference)
    ring = Ring.of([near])
    response = on_axis(ring.convert(near).reduced())
    parts = [
        Integer(0) if whole.is_zero else RealFunction(x.function.reduced()).function.expression()
        for x, whole in ((response.real, exact.raw_real), (response.imag, exact.raw_imag))
    ]
    return Asymptote(_leading(near, s, at), *(_leading(x, omega, at) for x in parts))


def low_frequency(perceived: RationalFunction) -> LowFrequency:
    """As of ``Distortion.low_frequency``."""
    above, below = (Poly(x, s).all_coeffs()[::-1] for x in _near_0(perceived.expression()).together().as_numer_denom())
    while above[0] == below[0] == 0:
        above, below = above[1:], below[1:]
    if below[0] == 0:
        raise SceneError("H_perc is infinite at rest: it has no stiffness, damping and mass there")
    found: list[Expr] = []
    for n, x in enumerate([*above, *[Integer(0)] * 3][:3]):
        left = x - sum((found[i] * below[n - i] for i in range(n) if n - i < len(below)), Integer(0))
        found.append((left / below[0]).factor())
    return LowFrequency(*found)


def _near_0(dynamics: Expr) -> Expr:
    """With delays as sums of powers of s, which hold near 0."""
    late = [x for x in dynamics.atoms(exp) if x.has(s)]
    near = dynamics.xreplace({x: Add(*(x.args[0] ** n / factorial(n) for n in range(_TERMS))) for x in late})
    if not near.is_rational_function(s):
        raise SceneError("there is no leading term of a display that is not rational in s but for delays")
    return near


def _leading(f: Expr, variable: Symbol, at: Any) -> Expr:
    above, below = (Poly(x, variable) for x in f.together().as_numer_denom())
    if above.is_zero:
        return Integer(0)
    chosen = [(p.LM() if at == oo else p.EM()).exponents[0] for p in (above, below)]
    if at == 0 and chosen[0] - chosen[1] >= _TERMS - 1:
        raise SceneError(f"the leading term is beyond order {_TERMS - 2}, as far as a delay was taken apart")
    ratio = above.coeff_monomial(variable ** chosen[0]) / below.coeff_monomial(variable ** chosen[1])
    return ratio.factor() * variable ** (chosen[0] - chosen[1])
