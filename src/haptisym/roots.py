"""Where real functions vanish and which signs they have in between: proven, none missed, none invented.

A function is taken apart into irreducible factors. Different factors have no root in common and each has only simple
ones, so that certified root isolation and refinement always come to an end, and multiplicities are exact. The result is
a ``Chart``: all roots of all functions on an interval in order, and the sign of every function before, at and after each.
Every question about a band (crossings, percepts, activity) is then read off the chart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeAlias

import flint
from flint import acb_poly, arb, arb_poly, fmpz_poly
from sympy import Expr

from .errors import UndecidedError
from .reals import Ball, ExactNumber, RealNumber, expression_ball
from .response import Polynomial, RealFunction, Ring

Key: TypeAlias = Hashable
"""What a function of a chart is called."""
Signs: TypeAlias = Mapping[Key, int]
_MOST_BITS = 1 << 20


@dataclass(frozen=True)
class Factor:
    """An irreducible polynomial in W = omega^2: its coefficients, ascending, are polynomials in pi over the integers."""

    coefficients: tuple[tuple[int, ...], ...]

    @property
    def degree(self) -> int:
        return len(self.coefficients) - 1

    @property
    def is_rational(self) -> bool:
        return all(len(c) == 1 for c in self.coefficients)

    def polynomial(self) -> arb_poly:
        """The polynomial in W with balls for coefficients, at the current working precision."""
        return arb_poly([fmpz_poly(list(c))(arb.pi()) for c in self.coefficients])

    def roots(self, bits: int) -> tuple[Ball, ...]:
        """Balls around all positive roots in W, ascending, computed with at least that many bits."""
        while bits < _MOST_BITS:
            with flint.ctx.workprec(bits):
                found = self._isolated_roots(bits)
            if found is not None:
                return found
            bits *= 2
        raise UndecidedError("the roots of a polynomial were not told apart at the precision limit")

    def _isolated_roots(self, bits: int) -> tuple[Ball, ...] | None:
        if self.degree == 1:
            low, high = (fmpz_poly(list(c))(arb.pi()) for c in self.coefficients)
            return _positive([-low / high])
        if self.is_rational:
            every = fmpz_poly([c[0] for c in self.coefficients]).complex_roots()
            return _positive([root.real for root, _ in every if root.imag.is_zero()])
        try:
            isolated = _real_ones(acb_poly(self.polynomial()).roots(maxprec=4 * bits))
        except ValueError:
            return None
        return _positive([_newton(self.polynomial(), ball) for ball in isolated])

    def sign_at(self, omega: Callable[[int], Ball]) -> int:
        """Its sign at a frequency that is not a root, given as a function from bits to a ball."""
        bits = 64
        while bits < _MOST_BITS:
            with flint.ctx.workprec(bits):
                value = self.polynomial()(omega(bits) ** 2)
                if value > 0 or value < 0:
                    return 1 if value > 0 else -1
            bits *= 2
        raise UndecidedError("the sign of a polynomial was not decided at the precision limit")

    def vanishes_at(self, omega: Expr) -> bool:
        """Whether a number rational in pi is a root: exact. Only a linear factor can have such a root."""
        if self.degree > 1:
            return False
        ring = Ring()
        low, high = (sum((n * ring.pi**i for i, n in enumerate(c)), ring.constant(0)) for c in self.coefficients)
        square = ring.convert(omega) ** 2
        return bool((low * square.denominator + high * square.numerator).is_zero())


def _real_ones(isolated: Iterable[Ball]) -> list[Ball]:
    """Of isolated roots of a real polynomial, the real ones: those whose mirror image meets no other root."""
    roots = list(isolated)
    alone = [
        z
        for i, z in enumerate(roots)
        if not any(_meet(z.conjugate(), other) for j, other in enumerate(roots) if j != i)
    ]
    return [z.real for z in alone if z.imag.contains(0)]


def _newton(polynomial: arb_poly, ball: Ball) -> Ball:
    """The enclosure of a simple root, made as tight as the working precision allows by interval Newton steps."""
    slope = polynomial.derivative()
    while True:
        middle = ball.mid()
        if slope(ball).contains(0):
            return ball
        step = middle - polynomial(middle) / slope(ball)
        if not step.rad() < ball.rad() / 2:
            return ball
        ball = step.intersection(ball)


def _meet(z: Ball, other: Ball) -> bool:
    return bool(z.real.overlaps(other.real) and z.imag.overlaps(other.imag))


def _positive(roots: Iterable[Ball]) -> tuple[Ball, ...] | None:
    """The positive ones in order; None if two of them, or one and zero, cannot be told apart at this precision."""
    ordered = sorted(roots, key=lambda ball: ball.mid())
    if any(ball.contains(0) for ball in ordered) or any(a.overlaps(b) for a, b in pairwise(ordered)):
        return None
    return tuple(ball for ball in ordered if ball > 0)


_factor_roots = lru_cache(maxsize=1024)(Factor.roots)


def _rounded(bits: int) -> int:
    """The next power of two, at least 128: so that questions of about the same precision share one isolation."""
    return max(128, 1 << (bits - 1).bit_length())


@dataclass(frozen=True)
class Root(RealNumber):
    """The frequency at which a factor vanishes: the square root of its ``index``-th positive root in W."""

    factor: Factor
    index: int

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return _factor_roots(self.factor, _rounded(bits))[self.index].sqrt()


@dataclass(frozen=True)
class Point:
    """A frequency where a function vanishes or has a pole, or an end of the band.

    ``orders``: order of each function there (positive for a zero, negative for a pole; absent if neither).
    ``before``, ``after``: the sign of each function just below and just above.
    """

    omega: RealNumber
    orders: Mapping[Key, int]
    before: Signs
    after: Signs

    @property
    def at(self) -> Signs:
        """The sign of each function right here: 0 at a zero; at a pole, the sign on both sides or 0."""
        return {name: self._sign(name) for name in self.after}

    def _sign(self, name: Key) -> int:
        order = self.orders.get(name, 0)
        return 0 if order > 0 or self.before[name] != self.after[name] else self.after[name]


@dataclass(frozen=True)
class Interval:
    """A piece of the band, between two points; a single frequency if both are the same."""

    low: Point
    high: Point


@dataclass(frozen=True)
class Chart:
    """All roots and poles of some functions on a band, in order, with the signs of all functions around each.

    The first and the last point are the ends of the band. Between neighbouring points no function vanishes.
    """

    points: tuple[Point, ...]

    def where(self, test: Callable[[Signs], bool]) -> tuple[Interval, ...]:
        """The set of frequencies whose signs pass the test, as intervals in order, as few as possible."""
        found: list[Interval] = []
        start: Point | None = None
        for point, following in zip(self.points, [*self.points[1:], None], strict=True):
            if not test(point.at):
                start = None
            elif start is None:
                start = point
                found.append(Interval(point, point))
            if following is not None and test(point.after):
                if start is None:
                    start = point
                    found.append(Interval(point, following))
                else:
                    found[-1] = Interval(found[-1].low, following)
            else:
                start = None
        return tuple(found)

    def zeros(self, name: Key) -> tuple[Point, ...]:
        """The points where a function vanishes."""
        return tuple(point for point in self.points if point.orders.get(name, 0) > 0)

    def sign_changes(self, name: Key) -> tuple[Point, ...]:
        """The points, ends of the band left out at 0, where a function changes its sign: odd zeros and odd poles."""
        return tuple(point for point in self.points if point.before[name] * point.after[name] < 0)


@dataclass(frozen=True)
class _Product:
    """A function as sign and powers: ``sign * omega^power * product of factor^exponent``."""

    sign: int
    power: int
    exponents: Mapping[Factor, int]


def chart(functions: Mapping[Any, RealFunction], low: Expr, high: Expr) -> Chart:
    """The chart of real functions of omega on the band from ``low`` to ``high`` (0 <= low < high, rational in pi).

    Guaranteed: every zero and every pole on the closed band is a point; no other frequency is; all orders and signs are
    exact. A function that is zero everywhere has sign 0 everywhere.

    >>> from sympy import Integer
    >>> from .symbols import omega
    >>> ring = Ring()
    >>> f = RealFunction(ring.convert((omega**2 - 2) ** 2 * (omega**2 - 9)))
    >>> for point in chart({"f": f}, Integer(0), Integer(9)).points:
    ...     print(point.omega.digits(5), point.before["f"], point.orders.get("f", 0), point.after["f"])
    0 -1 0 -1
    1.4142 -1 2 -1
    3.0000 -1 1 1
    9.0000 1 0 1
    """
    products = {name: _product(function) for name, function in functions.items()}
    factors = {factor for product in products.values() for factor in product.exponents}
    places = _places(factors, low, high)
    signs = _first_signs(factors, places)
    points = []
    for place in places:
        here = dict.fromkeys(place.factors, 1)
        orders = {name: _order(product, here, place) for name, product in products.items()}
        # the signs just below the low end follow from those just above it
        before = dict(signs) if place is not places[0] else {f: -x if f in here else x for f, x in signs.items()}
        after = {f: -x if f in here else x for f, x in before.items()}
        points.append(
            Point(
                place.omega,
                {name: order for name, order in orders.items() if order},
                {n: _sign(p, before) * (-1) ** (p.power if place.is_zero else 0) for n, p in products.items()},
                {n: _sign(p, after) for n, p in products.items()},
            )
        )
        signs = after
    return Chart(tuple(points))


def _product(function: RealFunction) -> _Product:
    top, bottom = function.function.numerator, function.function.denominator
    if top.is_zero():
        return _Product(0, 0, {})
    sign, power, exponents = 1, 0, Counter[Factor]()
    for polynomial, direction in ((top, 1), (bottom, -1)):
        own_sign, own_power, factors = _factored(polynomial)
        sign, power = sign * own_sign, power + direction * own_power
        for factor, exponent in factors:
            exponents[factor] += direction * exponent
    return _Product(sign, power, {factor: n for factor, n in exponents.items() if n})


def _factored(polynomial: Polynomial) -> tuple[int, int, list[tuple[Factor, int]]]:
    """Sign, power of omega and irreducible factors in W of an even or odd polynomial in omega."""
    power = min(int(exponents[0]) for exponents in polynomial.monoms())
    context = polynomial.context()
    in_square = {((int(e[0]) - power) // 2, *e[1:]): c for e, c in polynomial.to_dict().items()}
    unit, factors = context.from_dict(in_square).factor()
    sign = 1 if unit > 0 else -1
    found = []
    for factor, exponent in factors:
        if factor.degrees()[0] > 0:
            found.append((_factor(factor), int(exponent)))
        else:
            constant = _factor(factor)
            sign *= constant.sign_at(lambda _: arb(0)) ** int(exponent)
    return sign, power, found


def _factor(irreducible: Polynomial) -> Factor:
    coefficients: list[list[int]] = [[] for _ in range(int(irreducible.degrees()[0]) + 1)]
    for (power, of_pi, *_), value in irreducible.to_dict().items():
        row = coefficients[int(power)]
        row.extend([0] * (int(of_pi) + 1 - len(row)))
        row[int(of_pi)] = int(value.p)
    return Factor(tuple(tuple(row) or (0,) for row in coefficients))


@dataclass(frozen=True)
class _Place:
    """A frequency of the chart, with the factors that vanish there."""

    omega: RealNumber
    factors: tuple[Factor, ...]
    is_zero: bool = False


def _places(factors: set[Factor], low: Expr, high: Expr) -> list[_Place]:
    """Both ends of the band and all roots of all factors between them, in order."""
    ends = [ExactNumber(low), ExactNumber(high)]
    at_ends = [tuple(f for f in factors if end.value != 0 and f.vanishes_at(end.value)) for end in ends]
    on_ends = {f for found in at_ends for f in found}  # these are linear: their one root is the end
    roots = [Root(f, i) for f in factors if f not in on_ends for i in range(len(_factor_roots(f, _rounded(64))))]
    ordered = _in_order([*ends, *roots])
    inside = ordered[ordered.index(ends[0]) + 1 : ordered.index(ends[1])]
    middle = [_Place(root, (root.factor,)) for root in inside if isinstance(root, Root)]
    return [_Place(ends[0], at_ends[0], is_zero=low == 0), *middle, _Place(ends[1], at_ends[1])]


def _in_order(numbers: list[RealNumber]) -> list[RealNumber]:
    """Different numbers in ascending order, told apart by enclosures as tight as it takes."""
    bits = 64
    while bits < _MOST_BITS:
        with flint.ctx.workprec(bits):
            enclosed = sorted(((x.ball(bits), x) for x in numbers), key=lambda pair: pair[0].mid())
            if all(a < b for (a, _), (b, _) in pairwise(enclosed)):
                return [number for _, number in enclosed]
        bits *= 2
    raise UndecidedError("two frequencies were not told apart at the precision limit")


def _first_signs(factors: set[Factor], places: list[_Place]) -> dict[Factor, int]:
    """The sign of each factor between the first two places."""
    first, second = places[0].omega, places[1].omega

    def between(bits: int) -> Ball:
        return (first.ball(bits) + second.ball(bits)) / 2

    return {factor: factor.sign_at(between) for factor in factors}


def _order(product: _Product, here: Mapping[Factor, int], place: _Place) -> int:
    return sum(product.exponents.get(factor, 0) for factor in here) + (product.power if place.is_zero else 0)


def _sign(product: _Product, signs: Mapping[Factor, int]) -> int:
    sign = product.sign
    for factor, exponent in product.exponents.items():
        if exponent % 2:
            sign *= signs[factor]
    return sign


def sign_of_number(value: Expr) -> int:
    """The sign of an exact number, rational in pi: exact.

    >>> from sympy import Integer, pi
    >>> sign_of_number(pi - Integer(3)), sign_of_number(Integer(0))
    (1, 0)
    """
    if Ring().convert(value).is_zero:
        return 0
    bits = 64
    while bits < _MOST_BITS:
        with flint.ctx.workprec(bits):
            ball = expression_ball(value)
            if ball > 0 or ball < 0:
                return 1 if ball > 0 else -1
        bits *= 2
    raise UndecidedError(f"the sign of {value} was not decided at the precision limit")
