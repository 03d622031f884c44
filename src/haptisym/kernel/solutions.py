"""Zeros of a real function of omega as formulas, where there are readable ones, and how they move with a parameter.

Each irreducible factor is solved on its own. One that holds omega only by its square (or only by omega^alpha, or only by
the angle omega tau of one delay) and is of degree one or two in it is inverted in square roots, powers, asin or acos. All
others stay what they are: the polynomial is the answer.

A zero omega of F(omega, p) = 0 moves with a parameter by d omega/dp = -(dF/dp)/(dF/d omega).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq
from sympy import (
    Add,
    Expr,
    Integer,
    Pow,
    Rational,
    S,
    Symbol,
    acos,
    asin,
    atan,
    cos,
    count_ops,
    factor,
    factor_terms,
    pi,
    sqrt,
)

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, monomials, omega


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


def solve(function: RealFunction, *, readable: bool = False) -> tuple[Solution, ...]:
    """All positive zeros of a real function, as formulas where there are readable ones; ``readable`` : these alone, sooner.

    >>> from sympy import symbols
    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import omega
    >>> m, k = symbols("m k", positive=True)
    >>> f = RealFunction(Ring([m, k]).axis.convert(k - m * omega**2))
    >>> [solution.omega for solution in solve(f)]
    [sqrt(k)/sqrt(m)]
    """
    axis = function.axis
    factors = axis.factors(function.function.numerator)[1]
    solved = (x for f, order in factors for x in _solved(f, order, axis, readable=readable))
    return (*solved, *_half_turns(function))


def _half_turns(function: RealFunction) -> list[Solution]:
    """The zeros at omega tau = pi, 3 pi, ... of a function that has more half-angle tangents below the line than above."""
    axis, found = function.axis, []
    above, below = (p.degrees()[axis.size :] for p in (function.function.numerator, function.function.denominator))
    for angle, up, down in zip(axis.angles, above, below, strict=False):
        if not angle.constant and down > up:
            equation = cos(angle.value / 2)
            found.append(Solution(pi / angle.rate, equation, 2 * pi / angle.rate, int(down - up)))
    return found


def _solved(polynomial: Polynomial, order: int, axis: Axis, *, readable: bool) -> list[Solution]:
    degrees = [int(n) for n in polynomial.degrees()]
    turning = [i for i, angle in enumerate(axis.angles) if not angle.constant and degrees[axis.size + i]]
    powers = [i for i in range(len(axis.orders)) if degrees[axis.size + len(axis.angles) + i]]
    own = bool(degrees[0])
    if polynomial == axis.variable or not (own or turning or powers):
        return []
    if own + len(turning) + len(powers) > 1:
        found = None
    elif turning:
        found = _angles(polynomial, axis, turning[0])
    elif powers:
        index = axis.size + len(axis.angles) + powers[0]
        found = _each(lambda x: (x ** (1 / axis.orders[powers[0]]), S.Zero), _roots(_row(polynomial, axis, index)))
        if any(angle.constant and n for angle, n in zip(axis.angles, degrees[axis.size :], strict=False)):
            found = None  # the sign of the root depends on the constant angle, which stays a name here
    else:
        found = _frequencies(polynomial, axis)
    if found is None and readable:
        return []
    equation = _equation(polynomial, axis)
    return [Solution(x, equation, period, order) for x, period in ([(None, S.Zero)] if found is None else found)]


_Found: TypeAlias = "list[tuple[Expr, Expr]] | None"
"""Zeros with their periods; None where the degree is too high to invert."""


def _each(change: Callable[[Expr], tuple[Expr, Expr]], roots: list[Expr] | None) -> _Found:
    return None if roots is None else [change(x) for x in roots]


def _frequencies(polynomial: Polynomial, axis: Axis) -> _Found:
    """Zeros of a polynomial in omega alone."""
    if polynomial.degrees()[0] > 4:  # neither it nor one in omega^2 has a readable formula
        return None
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
        found = [acos(((1 - t2) / (1 + t2)).cancel()) for t2 in squares]
        return [(x / rate, period) for angle in found for x in (angle, 2 * pi - angle)]
    if len(row) == 3 and row[0] == row[2]:
        sine = asin(-2 * row[0] / row[1])
        first = sine + 2 * pi if sine.could_extract_minus_sign() else sine
        return [(first / rate, period), ((pi - sine) / rate, period)]
    # the first positive angle whose half has this tangent; between -pi and pi where the sign of t is open
    return _each(
        lambda t: ((2 * atan(t) + (2 * pi if t.is_nonpositive else 0)) / rate, period), _roots(row, positive=False)
    )


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


FunctionTerms: TypeAlias = tuple[tuple[Expr, Polynomial], ...]
"""A sum of polynomials of a ring, each times an expression: what a derivative of a polynomial in functions is."""


@dataclass(frozen=True)
class Equation:
    """F = 0 for a frequency; F is a polynomial in omega, the parameters and functions of them (cos(omega tau), omega^alpha).

    >>> from haptisym.kernel.rings import symbols
    >>> m, k = symbols("m k")
    >>> ring = PolynomialRing(omega, [m, k])
    >>> Equation(ring, ring.convert(k - m * omega**2).numerator).slope(k).expression()
    1/(2*m*omega)
    """

    ring: PolynomialRing
    F: Polynomial

    def ball(self, known: Mapping[Expr, Ball]) -> Ball:
        """A ball around F where the symbols have these values, at the current working precision."""
        return self.ring.ball(self.F, _meanings(self.ring, known))

    def partial(self, x: Symbol) -> FunctionTerms:
        """dF/dx: a derivative of each variable of the ring that depends on x times dF by that variable; () where it is 0."""
        chain = [(meaning.diff(x), self.F.derivative(i)) for i, meaning in enumerate(self.ring.meanings)]
        return tuple((factor, p) for factor, p in chain if factor != 0 and not p.is_zero())

    def slope(self, parameter: Symbol) -> ImplicitSlope:
        """d omega/d parameter."""
        return ImplicitSlope(self.ring, self.partial(parameter), self.partial(omega))


@dataclass(frozen=True)
class ImplicitSlope:
    """``-above/below``, which is d omega/d parameter at every zero at which ``below``, dF/d omega, is not 0."""

    ring: PolynomialRing
    above: FunctionTerms
    below: FunctionTerms

    def expression(self) -> Expr:
        """The closed form."""
        above, below = (Add(*(f * self.ring.expression(p) for f, p in terms)) for terms in (self.above, self.below))
        return -above / below

    def vanishes(self, known: Mapping[Symbol, Expr]) -> bool:
        """Whether ``above`` is 0 at every frequency for these values of parameters. (False: not seen to be.)"""
        return all(f.xreplace(known) == 0 or self._at(p, known).is_zero() for f, p in self.above)

    def _at(self, polynomial: Polynomial, known: Mapping[Symbol, Expr]) -> Polynomial:
        places = {self.ring.meanings.index(x): v for x, v in known.items() if isinstance(v, Rational)}
        return polynomial.subs({i: fmpq(int(v.p), int(v.q)) for i, v in places.items()})

    def balls(self, known: Mapping[Expr, Ball]) -> tuple[Ball, Ball]:
        """Balls around ``above`` and ``below`` where the symbols have these values, at the current working precision."""
        values = _meanings(self.ring, known)
        return self._ball(self.above, values, known), self._ball(self.below, values, known)

    def _ball(self, terms: FunctionTerms, values: Mapping[Expr, Ball], known: Mapping[Expr, Ball]) -> Ball:
        parts = (expression_ball(f, known) * self.ring.ball(p, values) for f, p in terms)
        return sum(parts, expression_ball(Integer(0)))


def _meanings(ring: PolynomialRing, known: Mapping[Expr, Ball]) -> dict[Expr, Ball]:
    """What the variables of a ring are worth, as far as the symbols in them are known."""
    return {x: expression_ball(x, known) for x in ring.meanings if all(y in known for y in x.free_symbols)}
