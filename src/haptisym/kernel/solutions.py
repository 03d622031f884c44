"""Zeros of a real function of omega as formulas, where there are readable ones: factor, look at the degree, invert.

Each irreducible factor is solved on its own. One that holds omega only by its square (or only by omega^alpha, or only by
the angle omega tau of one delay) and is of degree one or two in it is inverted in square roots, powers, asin or acos. All
others stay what they are: the polynomial is the answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from sympy import Expr, Integer, Pow, S, acos, asin, atan, cos, count_ops, factor, factor_terms, pi, sqrt

from haptisym.kernel.axis import Axis
from haptisym.kernel.monomials import monomials
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.kernel.shown import Shown


@dataclass(frozen=True, repr=False)
class Solution(Shown):
    """A zero of a real function as a formula in its parameters.

    ``omega``: the frequency, rad/s, in force where it is real and positive; None for a factor with no readable
    inverse, whose zeros are those of ``equation``. ``period``: adding any multiple of it gives the further zeros of a
    delay's angle; 0 for a single zero. ``order``: of the zero.
    """

    omega: Expr | None
    equation: Expr
    period: Expr = S.Zero
    order: int = 1

    def _line(self) -> str:
        return f"omega = {self.omega}" if self.omega is not None else f"of {self.equation} = 0"

    @property
    def conditions(self) -> tuple[Expr, ...]:
        """What must not be negative for the formula to be a frequency: empty where that is sure.

        >>> from sympy import symbols
        >>> c, tau = symbols("c tau", positive=True)
        >>> Solution(asin(c) / tau, c).conditions
        (1 - c,)
        """
        if self.omega is None:
            return ()
        inside = [x.base for x in self.omega.atoms(Pow) if x.exp.is_Rational and not x.exp.is_Integer]
        inside += [1 + sign * x.args[0] for x in self.omega.atoms(asin, acos) for sign in (1, -1)]
        own = [] if inside else [self.omega]  # where roots and angles are real, so is the frequency, and positive
        found = (x for x in dict.fromkeys([*inside, *own]) if not x.is_nonnegative)
        return tuple(sorted(found, key=lambda x: (count_ops(x), str(x))))


def solve(function: RealFunction) -> tuple[Solution, ...]:
    """All positive zeros of a real function, as formulas where there are readable ones.

    >>> from sympy import symbols
    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.symbols import omega
    >>> m, k = symbols("m k", positive=True)
    >>> f = RealFunction(Ring([m, k]).axis.convert(k - m * omega**2))
    >>> [solution.omega for solution in solve(f)]
    [sqrt(k)/sqrt(m)]
    """
    axis = function.axis
    factors = axis.factors(function.function.numerator)[1]
    return (*(x for f, order in factors for x in _solved(f, order, axis)), *_half_turns(function))


def _half_turns(function: RealFunction) -> list[Solution]:
    """The zeros at omega tau = pi, 3 pi, ... of a function that has more half-angle tangents below the line than above."""
    axis, found = function.axis, []
    above, below = (p.degrees()[axis.size :] for p in (function.function.numerator, function.function.denominator))
    for angle, up, down in zip(axis.angles, above, below, strict=False):
        if not angle.constant and down > up:
            equation = cos(angle.value / 2)
            found.append(Solution(pi / angle.rate, equation, 2 * pi / angle.rate, int(down - up)))
    return found


def _solved(polynomial: Polynomial, order: int, axis: Axis) -> list[Solution]:
    degrees = [int(n) for n in polynomial.degrees()]
    turning = [i for i, angle in enumerate(axis.angles) if not angle.constant and degrees[axis.size + i]]
    powers = [i for i in range(len(axis.orders)) if degrees[axis.size + len(axis.angles) + i]]
    own = bool(degrees[0])
    equation = _equation(polynomial, axis)
    if polynomial == axis.variable or not (own or turning or powers):
        return []
    if own + len(turning) + len(powers) > 1:
        return [Solution(None, equation, order=order)]
    if turning:
        found = _angles(polynomial, axis, turning[0])
    elif powers:
        index = axis.size + len(axis.angles) + powers[0]
        found = _each(lambda x: (x ** (1 / axis.orders[powers[0]]), S.Zero), _roots(_row(polynomial, axis, index)))
        if any(angle.constant and n for angle, n in zip(axis.angles, degrees[axis.size :], strict=False)):
            found = None  # the sign of the root depends on the constant angle, which stays a name here
    else:
        found = _frequencies(polynomial, axis)
    if found is None:
        return [Solution(None, equation, order=order)]
    return [Solution(x, equation, period, order) for x, period in found]


_Found: TypeAlias = "list[tuple[Expr, Expr]] | None"
"""Zeros with their periods; None where the degree is too high to invert."""


def _each(change: Callable[[Expr], tuple[Expr, Expr]], roots: list[Expr] | None) -> _Found:
    return None if roots is None else [change(x) for x in roots]


def _frequencies(polynomial: Polynomial, axis: Axis) -> _Found:
    """Zeros of a polynomial in omega alone."""
    row = _row(polynomial, axis, 0)
    if not any(row[1::2]):
        return _each(lambda x: (sqrt(x), S.Zero), _roots(row[::2]))
    return _each(lambda x: (x, S.Zero), _roots(row))


def _angles(polynomial: Polynomial, axis: Axis, index: int) -> _Found:
    """Zeros of a polynomial in t = tan(omega tau/2) alone: cos = (1 - t^2)/(1 + t^2), sin = 2 t/(1 + t^2)."""
    rate = axis.angles[index].rate
    row = _row(polynomial, axis, axis.size + index)
    period = 2 * pi / rate
    if not any(row[1::2]):
        squares = _roots(row[::2])
        if squares is None:
            return None
        return [(angle / rate, period) for t2 in squares for angle in _both_ways(acos(((1 - t2) / (1 + t2)).cancel()))]
    if len(row) == 3 and row[0] == row[2]:
        sine = asin(-2 * row[0] / row[1])
        first = sine + 2 * pi if sine.could_extract_minus_sign() else sine
        return [(first / rate, period), ((pi - sine) / rate, period)]
    return _each(lambda t: (_turn(t) / rate, period), _roots(row, positive=False))


def _turn(t: Expr) -> Expr:
    """The first positive angle whose half has this tangent; between -pi and pi where the sign of t is open."""
    return 2 * atan(t) + (2 * pi if t.is_nonpositive else 0)


def _both_ways(angle: Expr) -> tuple[Expr, Expr]:
    return angle, 2 * pi - angle


def _row(polynomial: Polynomial, axis: Axis, index: int) -> list[Expr]:
    """Coefficients in one variable, ascending; constant angles as cosines and sines."""
    if index and any(angle.constant for angle in axis.angles):
        return _plain_row(polynomial, axis, index)
    written = axis.trigonometric(axis.function(polynomial)) if index == 0 and axis.angles else axis.function(polynomial)
    return written.ring.coefficients(written.numerator) if index == 0 else _plain_row(polynomial, axis, index)


def _plain_row(polynomial: Polynomial, ring: PolynomialRing, index: int) -> list[Expr]:
    gathered: dict[int, dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(polynomial):
        own = list(map(int, exponents))
        power, own[index] = own[index], 0
        gathered.setdefault(power, {})[tuple(own)] = value
    expressions = {n: ring.expression(ring.context.from_dict(terms)) for n, terms in gathered.items()}
    return [expressions.get(n, Integer(0)) for n in range(max(expressions) + 1)]


def _roots(row: list[Expr], *, positive: bool = True) -> list[Expr] | None:
    """The roots of a polynomial of degree 1 or 2, unless told otherwise those that may be positive; None for a higher degree."""
    if len(row) == 2:
        root = _quotient(-row[0], row[1])
        return [root] if not positive or root.is_positive is not False else []
    if len(row) != 3:
        return None
    c, b, a = row
    if a.could_extract_minus_sign():
        a, b, c = -a, -b, -c
    whole = b**2 - 4 * a * c
    discriminant = split if (split := factor(whole)).is_Mul else whole
    if discriminant.is_negative:
        return []
    found = [_quotient(-b + sign * sqrt(discriminant), 2 * a) for sign in (-1, 1)]
    return [x for x in found if not positive or x.is_positive is not False]


def _quotient(above: Expr, below: Expr) -> Expr:
    """A quotient with common factors gone, and with a minus below only where there is none above."""
    above, below = (split if (split := factor(x)).is_Mul else x for x in (above, below))
    if above.could_extract_minus_sign():
        return -above / (-below)
    return factor_terms(above / below)


def _equation(polynomial: Polynomial, axis: Axis) -> Expr:
    """The factor as a person would write it: divided by what makes tangents of half angles cosines and sines."""
    below = axis.constant(1)
    for i, t in enumerate(axis.context.gens()[axis.size : axis.size + len(axis.angles)], axis.size):
        below *= (t**2 + 1) ** ((int(polynomial.degrees()[i]) + 1) // 2)
    return RealFunction(axis.function(polynomial, below)).factored()
