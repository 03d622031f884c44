"""The frequencies that a distortion has: crossings of a threshold, changeovers, and the bandwidth.

**Problem.** A *crossing* is a frequency omega > 0 at which a ratio r (r_r or r_i) equals a
threshold c > 0, a *changeover* one at which Re H changes its sign, and the *bandwidth* the upper
end of the frequencies from 0 on at which no ratio exceeds c. Where are all of them: as formulas in
the parameters, and as numbers?

**Functions.** A ratio is given as its square r^2, a quotient of polynomials in omega (with delays
and powers also in tan(omega tau/2) and omega^alpha): a ratio itself has the square root of
|H_env|^2, of which zeros are not those of polynomials. As r >= 0, r exceeds c > 0 exactly where the
``excess`` r^2 - c^2 is positive, and crosses it where that vanishes.

**Formulas** (``crossings``, ``lowest_formula``) are ``kernel.solutions.Solution``. They hold for
all positive values of the parameters at which each of their *conditions*, an expression, is > 0;
where one is 0 a formula may hold or not.

**Numbers** (``zeros``, ``sign_changes``, ``bandwidth``) are proven, of functions without free
parameters: all there are, each with any number of digits. They are read off a chart
(``kernel.roots``), which has all zeros on a closed band. Without a band it is taken up to a
frequency above which there is none; with a delay none is known, as its phase turns at all
frequencies. Where a function is 0 at all frequencies it has no zeros and no changes of sign.

Begin with ``excess``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any

from sympy import Expr, Integer, Mul, Poly, Rational, Symbol, factor_terms, oo, sqrt

from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, quoted, within
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import Chart, Point, chart, sign_of_number
from haptisym.kernel.solutions import Solution, solve
from haptisym.model.catalogue import given_band
from haptisym.model.chain import unused
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, number, quantity


def threshold(given: Any, named: Mapping[str, str]) -> Expr:
    """Read a threshold c: a number > 0, or an expression in symbols of its own.

    Of an expression it is not asked whether it is > 0 for all values of its symbols, as eps - 1 is
    for some alone: SceneError only where the assumptions on them make it 0 or negative. ``named`` :
    the names that its symbols must not have, and what they mean.
    """
    with within("c"):
        value = quantity(given, Dimension.RATIO).value
    if (value.is_number and sign_of_number(value) <= 0) or value.is_positive is False:
        raise SceneError(f"c: {quoted(given)}: give a fraction > 0")
    for x in sorted(value.free_symbols, key=str):
        if x.name in named:
            raise SceneError(
                f'c: {x} is {named[x.name]}: give the threshold another symbol, as Symbol("eps")'
            )
    return value


def excess(squared_ratio: RealFunction, c: Expr) -> RealFunction:
    """r^2 - c^2 in lowest terms: positive exactly where a ratio r exceeds a threshold, for c >
    0."""
    f = squared_ratio.function
    square = f.ring.convert(c**2)
    numerator = f.numerator * square.denominator - square.numerator * f.denominator
    denominator = f.denominator * square.denominator
    return RealFunction(f.ring.function(numerator, denominator).reduced())


def free_parameters(*functions: RealFunction) -> set[Symbol]:
    """The parameters on which some functions depend."""
    return {x for f in functions for x in f.expression().free_symbols} - {omega}


# Formulas


def crossings(
    squared_ratio: RealFunction,
    c: Expr,
    threshold_symbol: Symbol,
    solver: Callable[[RealFunction], tuple[Solution, ...]] = solve,
) -> tuple[Solution, ...]:
    """The frequencies at which a ratio equals a threshold, as formulas with the conditions under
    which they are in force; c > 0 is one, where c has symbols of which that is not known.

    ``threshold_symbol`` : the one that the ring of the function has for a threshold.
    ``solver`` : what solves r^2 - c^2 = 0, given its left-hand side.
    """
    if not c.free_symbols:
        return solver(excess(squared_ratio, c))
    solutions = solver(excess(squared_ratio, threshold_symbol))
    # r^2 = c^2 is r = c for c > 0 alone: that is one more condition, which ``replaced`` leaves out
    # where it is known to hold.
    in_c = []
    for x in solutions:
        conditional = replace(x, conditions=(*x.conditions, threshold_symbol))
        with_c = conditional.replaced({threshold_symbol: c})
        if with_c is not None:
            in_c.append(with_c)
    return tuple(in_c)


_OMEGA_SQUARED = Symbol("W", positive=True)
"""omega^2, the unknown of a threshold polynomial."""


def threshold_polynomial(
    squared_ratio: RealFunction, c: Expr, threshold_symbol: Symbol
) -> Poly | Expr:
    """The polynomial in W = omega^2 (W_ where W is a parameter) that vanishes where a ratio equals
    a threshold, for values of symbols for which c > 0; with delays or fractional powers an
    expression in omega.

    ``threshold_symbol`` : the one that the ring of the function has for a threshold.
    """
    f = excess(squared_ratio, threshold_symbol if c.free_symbols else c)
    numerator = f.expression().as_numer_denom()[0]
    polynomial = numerator.expand().xreplace({threshold_symbol: c})
    if not polynomial.is_polynomial(omega):
        return polynomial
    if any(n % 2 for (n,) in Poly(polynomial, omega).monoms()):
        return polynomial
    square = unused(_OMEGA_SQUARED, polynomial.free_symbols)
    return Poly(polynomial.subs(omega, sqrt(square)), square)


_SAME_FREQUENCY = 1e-9
"""Frequencies, as doubles, that differ relatively by less are not distinguished: far above their
rounding, far below what a formula means to a reader."""


def lowest_formula(
    solutions: Sequence[Solution], values: Mapping[Symbol, Expr] | None = None
) -> Expr | None:
    """The formula of the lowest frequency among ``solutions``: for these ``values`` of all
    parameters, or without them for all values at which it is in force.

    None : which one is lowest is not decided, or none is in force.

    >>> from haptisym.kernel.rings import symbols
    >>> k, m = symbols("k m")
    >>> both = [Solution(x, k, conditions=(y,)) for x, y in ((sqrt(k - m), k - m), (sqrt(m - k), m - k))]
    >>> lowest_formula(both), lowest_formula(both, {k: Integer(5), m: Integer(1)})
    (None, sqrt(k - m))
    """
    # An equation without a formula may have a lower zero than all formulas.
    if any(x.omega is None for x in solutions):
        return None
    if values is None:
        for x in solutions:
            if all(x is other or _is_lower(x, other) for other in solutions):
                return x.omega
        return None
    by_frequency = []
    for x in solutions:
        # None: with these values a condition fails.
        if with_values := x.replaced(values):
            frequency = with_values.omega
            assert frequency is not None
            # At 0, where a condition is 0, there need not be a zero.
            if with_values.conditions or not frequency.is_positive:
                return None
            by_frequency.append((float(frequency), x.omega))
    if not by_frequency:
        return None
    by_frequency.sort(key=itemgetter(0))
    lowest, formula = by_frequency[0]
    # Two zeros that meet as doubles may be one that is touched, where no sign changes.
    if len(by_frequency) > 1 and by_frequency[1][0] - lowest <= _SAME_FREQUENCY * lowest:
        return None
    return formula


def _is_lower(one: Solution, other: Solution) -> bool:
    """Whether ``one`` is proven to be in force wherever ``other`` is, and not above it there; False
    proves nothing."""
    assert one.omega is not None
    assert other.omega is not None
    if not set(one.conditions) <= set(other.conditions):
        return False
    if (one.omega - other.omega).is_negative:
        return True
    # Both are positive where they are in force: they are in the order of their squares. Of the two
    # roots of a quadratic in omega^2 the squares differ by sqrt(discriminant)/a. If all other
    # factors are positive the root is real with their product, and then it is not negative. Of two
    # roots that is not so: sqrt(u) sqrt(v) is real and negative where u and v both are negative.
    gap = factor_terms((other.omega**2 - one.omega**2).expand())
    unsigned = [x for x in Mul.make_args(gap) if not x.is_positive]
    return all(x.is_Pow and x.exp == Rational(1, 2) for x in unsigned) and len(unsigned) <= 1


# Numbers


_WIDENED = 4
"""How many bands, each eight times as wide as the one before, are searched for the end of a
bandwidth behind a delay. At the end of the first the longest delay tau has turned by one radian,
omega tau = 1; at that of the last by 8^3 radians, some eighty turns."""


def bandwidth(
    squared_ratios: Mapping[Part, RealFunction], c: Expr, band: tuple[Any, Any] | None
) -> RealNumber | Expr:
    """The upper end, rad/s, of the interval from 0 or from the low end of the band on which no ratio
    exceeds c: that of the band where none does on it. 0 where a ratio exceeds c at that low end, oo
    where, without a band, there is no upper end.

    SceneError where a parameter has no value, and, without a band, where no ratio exceeds c within
    some eighty turns of a delay.
    """
    free = free_parameters(*squared_ratios.values()) | c.free_symbols
    if free:
        named = ", ".join(sorted(map(str, free)))
        raise SceneError(
            f"a bandwidth needs values for {named}; crossings(part, c) has the formulas"
        )
    functions = {part: excess(f, c) for part, f in squared_ratios.items()}
    turning = [x.rate for f in functions.values() for x in f.axis.angles if not x.constant]
    if band:
        bands = [_band_ends(band)]
    elif turning:
        # Behind a delay the highest crossing is not known, but the first one is mostly within its
        # first turns. The bands begin there, as the time of a chart grows with the zeros on it.
        one_radian = 1 / max(map(abs, turning), key=float)
        bands = [(Integer(0), one_radian * 8**n) for n in range(_WIDENED)]
    else:
        bands = [(Integer(0), max(map(_above_all_zeros, functions.values())))]
    for low, high in bands:
        table = chart(functions, low, high)
        unnoticed = table.where(lambda signs: all(x <= 0 for x in signs.values()))
        # The end of the first interval, None unless that begins at the low end: an interval further
        # up, behind frequencies at which a ratio exceeds c, is no bandwidth.
        end = table.reach(unnoticed)
        if end is None:
            return Integer(0)
        if band or table.where(lambda signs: any(x > 0 for x in signs.values())):
            return end
    if turning:
        raise SceneError(
            f"no ratio exceeds c up to {float(high):.5g} rad/s, and with a delay none is known to "
            f"be the last: give a band, as band=(0, {float(10 * high):.5g})"
        )
    # No ratio exceeds c up to the high end, which was taken from ``_above_all_zeros``: from there
    # on each excess has one sign, that at the end.
    return oo


def zeros(f: RealFunction, band: tuple[Any, Any] | None) -> tuple[RealNumber, ...]:
    """All positive zeros of a function without free parameters, each once: on a closed band, rad/s,
    if one is given. None of the function 0.

    SceneError without a band where there may be infinitely many, as with a delay.
    """
    points = (p for p in _chart(f, band).points if p.orders.get(0, 0) > 0)
    return _positive(points)


def sign_changes(f: RealFunction) -> tuple[RealNumber, ...]:
    """All positive frequencies at which a function without free parameters changes its sign: zeros
    and poles of odd order. SceneError where there may be infinitely many, as with a delay."""
    # N D has the sign of N/D and no poles: a zero at which it changes its sign is a zero of N or a
    # pole, both of odd order.
    same_sign = RealFunction(f.axis.function(f.function.numerator * f.function.denominator))
    return _positive(_chart(same_sign, None).sign_changes(0))


def _positive(points: Iterable[Point]) -> tuple[RealNumber, ...]:
    """The frequencies of points but 0, which on a chart is an end, an exact number."""
    is_zero = ExactNumber(Integer(0))
    return tuple(p.omega for p in points if p.omega != is_zero)


def _chart(f: RealFunction, band: tuple[Any, Any] | None) -> Chart:
    """The chart of a function, under the key 0, on a band, or on all frequencies at which it has
    zeros."""
    low, high = _band_ends(band) if band else (Integer(0), _above_all_zeros(f))
    return chart({0: f}, low, high)


def _band_ends(band: tuple[Any, Any]) -> tuple[Expr, Expr]:
    """The two ends of a band, rad/s, exact; SceneError unless 0 <= low < high."""
    low, high = (number(x, Dimension.FREQUENCY).value for x in given_band(band))
    if not 0 <= low < high:
        raise SceneError(f"band: {band}: give a low end >= 0 and a higher one, as (0, 15)")
    return low, high


_GIVE_A_BAND = "give a band, as band=(0, 100); changeovers on a band are those of hs.evaluate"


def _above_all_zeros(f: RealFunction) -> Expr:
    """A frequency > 0, rad/s, from which on a function keeps its sign and is not 0; SceneError
    where none is known, as with a delay. For the function 0 it is 1."""
    if f.function.is_zero:
        return Integer(1)
    # A delay turns the phase for ever: r^2 - c^2 can change its sign at arbitrarily high omega.
    if any(not angle.constant for angle in f.axis.angles):
        raise SceneError(f"with a delay there may be infinitely many crossings: {_GIVE_A_BAND}")
    # Without delays the highest power of the numerator exceeds all others together for omega >=
    # ``radius``: the function is not 0 there.
    at_infinity = asymptotic_sign(f.function)
    if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise SceneError(f"the highest crossing is not known: {_GIVE_A_BAND}")
    return max(at_infinity.radius, Integer(1))
