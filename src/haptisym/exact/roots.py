"""Where real functions vanish and which signs they have in between: proven, none missed, none invented.

The result is a ``Chart``: all zeros and poles of all functions on a band in order, and the sign of every function
before, at and after each. Every question about a band (crossings, percepts, activity, stability) is read off a chart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import prod
from typing import Any, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.errors import UndecidedError
from haptisym.symbols import omega

from .factors import MOST_BITS, AnalyticFactor, Factor, PolynomialFactor, Term, Undecided, Zero, polynomial_factors
from .levels import Level
from .reals import Ball, ExactNumber, RealNumber, expression_ball
from .response import Axis, RealFunction
from .rings import Polynomial, PolynomialRing, RationalFunction

Key: TypeAlias = Hashable
"""What a function of a chart is called."""
Signs: TypeAlias = Mapping[Key, int]


@dataclass(frozen=True)
class Point:
    """A frequency where a function vanishes or has a pole, or an end of the band.

    ``orders``: order of each function there (positive for a zero, negative for a pole; absent if neither).
    ``before``, ``after``: the sign of each function just below and just above. ``undecided``: the functions of which it
    is not known whether they vanish here, twice nearby, or not at all.
    """

    omega: RealNumber
    orders: Mapping[Key, int]
    before: Signs
    after: Signs
    undecided: frozenset[Key] = frozenset()

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
    """All zeros and poles of some functions on a band, in order, with the signs of all functions around each.

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

    def sign_changes(self, name: Key) -> tuple[Point, ...]:
        """The points at which a function changes its sign: odd zeros and odd poles."""
        return tuple(point for point in self.points if point.before[name] * point.after[name] < 0)

    @property
    def undecided(self) -> tuple[Point, ...]:
        """The points at which something stayed undecided."""
        return tuple(point for point in self.points if point.undecided)


@dataclass(frozen=True)
class _Product:
    """A function as sign and powers: ``sign * omega^power * product of factor^exponent``."""

    sign: int
    power: Expr
    exponents: Mapping[Factor, int]


def chart(functions: Mapping[Any, RealFunction | Level], low: Expr, high: Expr) -> Chart:
    """The chart of real functions of omega on the band from ``low`` to ``high`` (0 <= low < high, rational in pi).

    Guaranteed: every zero and every pole on the closed band is a point; no other frequency is; all orders and signs are
    exact. A function that is zero everywhere has sign 0 everywhere. Functions with delays or powers of omega are entire
    functions, so that tangencies, and nothing else, may stay undecided; their points say so. UndecidedError where even
    the order of two points, or what happens at an end of the band, stays open.

    >>> from haptisym.exact.response import Ring
    >>> from sympy import Integer
    >>> f = RealFunction(Ring().axis.convert((omega**2 - 2) ** 2 * (omega**2 - 9)))
    >>> for point in chart({"f": f}, Integer(0), Integer(9)).points:
    ...     print(point.omega.digits(5), point.before["f"], point.orders.get("f", 0), point.after["f"])
    0 -1 0 -1
    1.4142 -1 2 -1
    3.0000 -1 1 1
    9.0000 1 0 1
    """
    known: list[tuple[Polynomial, _Factored]] = []
    products = {name: _product(function, known) for name, function in functions.items()}
    factors = {factor for product in products.values() for factor in product.exponents}
    steady = {f: sign for f in factors if (sign := f.steady_sign(low, high))}
    places = _places(factors - steady.keys(), low, high)
    signs = _first_signs(products, places, steady)
    points: list[Point] = []
    for place in places:
        orders = {name: n for name, product in products.items() if (n := _order(product, place))}
        other_side = _turned(signs, products, orders, place)
        if points:
            before, after = signs, other_side
        else:  # the signs just below the low end follow from those just above it
            before, after = other_side, signs
        points.append(Point(place.omega, orders, before, after, _undecided(products, place)))
        signs = after
    return Chart(tuple(points))


def _turned(signs: Signs, products: Mapping[Key, _Product], orders: Mapping[Key, int], place: _Place) -> dict[Key, int]:
    """The signs of the functions on the other side of a place; below omega = 0 functions are mirrored."""
    odd = [name for name, n in orders.items() if n % 2 and not (place.is_zero and _is_even(products[name]))]
    return {**signs, **{name: -signs[name] for name in odd}}


def _is_even(product: _Product) -> bool:
    """Whether a function counts as even though its order at 0 is odd: powers omega^alpha have no other side."""
    return not product.power.is_Integer or any(isinstance(f, AnalyticFactor) and f.orders for f in product.exponents)


def _undecided(products: Mapping[Key, _Product], place: _Place) -> frozenset[Key]:
    if not place.undecided:
        return frozenset()
    return frozenset(name for name, p in products.items() if not place.undecided.isdisjoint(p.exponents))


def _order(product: _Product, place: _Place) -> int:
    order = sum(product.exponents.get(factor, 0) * n for factor, n in place.orders.items())
    return _whole(product.power + order) if place.is_zero else int(order)


def _whole(order: Expr) -> int:
    """An order as a whole number; a fractional one, of omega^alpha at 0, rounded away from 0."""
    if order.is_Integer:
        return int(order)
    sign = sign_of_number(order)
    return sign * (int(abs(float(order))) + 1)


# From functions to factors


_Factored: TypeAlias = tuple[int, Expr, list[tuple[Factor, int]]]


def _product(function: RealFunction | Level, known: list[tuple[Polynomial, _Factored]]) -> _Product:
    """The function taken apart; ``known`` gathers polynomials that are, as denominators are mostly alike."""
    if isinstance(function, Level):
        below = _product(RealFunction(function.function.axis.one / _denominator(function.function)), known)
        return replace(below, exponents={**below.exponents, function.factor: 1})
    top, bottom = function.function.numerator, function.function.denominator
    if top.is_zero():
        return _Product(0, Integer(0), {})
    sign, power, exponents = 1, Integer(0), Counter[Factor]()
    for polynomial, direction in ((top, 1), (bottom, -1)):
        found = next((taken for other, taken in known if other == polynomial), None)
        if found is None:
            found = _factored(polynomial, function.axis)
            known.append((polynomial, found))
        own_sign, own_power, factors = found
        sign, power = sign * own_sign, power + direction * own_power
        for factor, exponent in factors:
            exponents[factor] += direction * exponent
    return _Product(sign, power, {factor: n for factor, n in exponents.items() if n})


def _denominator(function: RealFunction) -> RationalFunction:
    return function.axis.function(function.function.denominator)


def _factored(polynomial: Polynomial, axis: Axis) -> _Factored:
    """Sign, power of omega and irreducible factors; half-angle tangents made homogeneous in cosine and sine."""
    plain = axis.univariate(polynomial)
    if plain is not None and not axis.functions:
        own_sign, lowest, simple = polynomial_factors(plain)
        return own_sign, Integer(lowest), [*simple]
    # where sines meet odd powers of omega not all functions are even: then none is factored in omega^2, so that one
    # frequency is never the zero of two different factors
    number, factors = axis.factors(polynomial, in_square=not axis.functions)
    sign, power = (1 if number > 0 else -1), Integer(0)
    found: list[tuple[Factor, int]] = []
    for factor, exponent in factors:
        exponents = _power_of_omega(factor, axis)
        if exponents is not None:
            power += exponent * exponents
            continue
        made = _factor(factor, axis)
        if made is None:
            continue
        if not _changes(factor, axis):
            sign *= made.sign_at(lambda _: arb(1)) ** exponent
        else:
            found.append((made, exponent))
    cosines = [(_cosine(axis, i), -n) for i, n in enumerate(_turning(polynomial, axis)) if n]
    return sign, power, [*found, *cosines]


def _power_of_omega(factor: Polynomial, axis: Axis) -> Expr | None:
    """The exponent of a factor that is omega or omega^alpha itself; None for any other factor."""
    if factor == axis.variable:
        return Integer(1)
    for order, generator in zip(axis.orders, axis.context.gens()[axis.size + len(axis.angles) :], strict=True):
        if factor == generator:
            return order
    return None


def _changes(factor: Polynomial, axis: Axis) -> bool:
    """Whether a factor changes with omega: by omega itself, by an angle of a delay or by a power omega^alpha."""
    degrees = [int(n) for n in factor.degrees()]
    return bool(degrees[0]) or any(_turning(factor, axis)) or any(degrees[axis.size + len(axis.angles) :])


def _turning(polynomial: Polynomial, axis: Axis) -> list[int]:
    """The degree in the half-angle tangent of each angle, 0 for the constant ones."""
    degrees = [int(n) for n in polynomial.degrees()[axis.size :]]
    return [0 if angle.constant else n for angle, n in zip(axis.angles, degrees, strict=False)]


def _factor(factor: Polynomial, axis: Axis) -> Factor | None:
    """An irreducible polynomial of the axis as a factor; None for 1 + tan^2, which becomes cos^2 + sin^2 = 1."""
    degrees = [int(n) for n in factor.degrees()]
    if not any(degrees[axis.size :]):
        return _polynomial_factor(factor)
    if any(factor == g**2 + 1 for g in axis.context.gens()[axis.size : axis.size + len(axis.angles)]):
        return None
    return _analytic_factor(factor, axis)


def _polynomial_factor(factor: Polynomial) -> PolynomialFactor:
    rows = _rows([((int(e[0]), int(e[1])), int(c.p)) for e, c in factor.to_dict().items()])
    even = not any(any(row) for row in rows[1::2])
    return PolynomialFactor(rows[::2] if even else rows, 2 if even else 1)


def _rows(terms: Iterable[tuple[tuple[int, int], int]]) -> tuple[tuple[int, ...], ...]:
    """Coefficients of ascending powers of omega, each as the coefficients of ascending powers of pi."""
    listed = list(terms)
    rows: list[list[int]] = [[0] for _ in range(max(power for (power, _), _ in listed) + 1)]
    for (power, of_pi), value in listed:
        rows[power].extend([0] * (of_pi + 1 - len(rows[power])))
        rows[power][of_pi] = value
    return tuple(tuple(row) for row in rows)


def _analytic_factor(factor: Polynomial, axis: Axis) -> AnalyticFactor:
    angles = len(axis.angles)
    groups: dict[tuple[int, ...], list[tuple[tuple[int, int], int]]] = {}
    for exponents, value in factor.to_dict().items():
        own = [int(n) for n in exponents]
        groups.setdefault(tuple(own[axis.size :]), []).append(((own[0], own[1]), int(value.p)))
    terms = tuple(Term(waves[:angles], waves[angles:], _rows(found)) for waves, found in sorted(groups.items()))
    degrees = tuple(int(n) for n in factor.degrees()[axis.size : axis.size + angles])
    return AnalyticFactor(terms, tuple((angle.rate, angle.constant) for angle in axis.angles), degrees, axis.orders)


def _cosine(axis: Axis, index: int) -> AnalyticFactor:
    """The cosine of a half angle, which homogeneous forms of different degrees leave behind."""
    degrees = tuple(int(i == index) for i in range(len(axis.angles)))
    term = Term((0,) * len(axis.angles), (0,) * len(axis.orders), ((1,),))
    return AnalyticFactor((term,), tuple((angle.rate, angle.constant) for angle in axis.angles), degrees, axis.orders)


# The places of a chart


@dataclass(frozen=True)
class _Place:
    """A frequency of the chart, with the order of each factor that vanishes there."""

    omega: RealNumber
    orders: Mapping[Factor, Any]
    is_zero: bool = False
    undecided: frozenset[Factor] = frozenset()


def _places(factors: set[Factor], low: Expr, high: Expr) -> list[_Place]:
    """Both ends of the band and all zeros of all factors between them, in order."""
    ends = [ExactNumber(low), ExactNumber(high)]
    at_ends = [{f: n for f in factors if (n := f.order_at(end.value))} for end in ends]
    # a polynomial factor that vanishes at an end is linear, and that is its one zero
    done: set[Factor] = {f for found in at_ends for f in found if isinstance(f, PolynomialFactor)}
    zeros: dict[RealNumber, dict[Factor, int]] = {}
    for f in factors - done:
        for number in f.zeros(low, high):
            zeros.setdefault(number, {})[f] = f.multiplicity(number)
    ordered = in_order([*ends, *zeros])
    inside = ordered[ordered.index(ends[0]) + 1 : ordered.index(ends[1])]
    middle = [_Place(x, zeros[x], undecided=frozenset(zeros[x] if isinstance(x, Undecided) else ())) for x in inside]
    return [_Place(ends[0], at_ends[0], is_zero=low == 0), *middle, _Place(ends[1], at_ends[1])]


def in_order(numbers: list[RealNumber]) -> list[RealNumber]:
    """Different numbers in ascending order, told apart by enclosures as tight as it takes."""
    bits = 64
    while bits <= MOST_BITS * (1 if any(isinstance(x, Zero | Undecided) for x in numbers) else 128):
        with flint.ctx.workprec(bits):
            enclosed = sorted(((x.ball(bits), x) for x in numbers), key=lambda pair: pair[0].mid())
            close = [a for (a, _), (b, _) in pairwise(enclosed) if not a < b]
            if not close:
                return [number for _, number in enclosed]
        bits *= 2
    raise UndecidedError(f"whether two frequencies near {float(close[0].mid()):.17g} rad/s are the same")


def _first_signs(
    products: Mapping[Key, _Product], places: list[_Place], steady: Mapping[Factor, int]
) -> dict[Key, int]:
    """The sign of each function between the first two places."""
    first, second = places[0].omega, places[1].omega

    def between(bits: int) -> Ball:
        return (first.ball(bits) + second.ball(bits)) / 2

    signs = dict(steady)
    for factor in {f for p in products.values() for f in p.exponents} - steady.keys():
        signs[factor] = factor.sign_at(between)
    return {
        name: p.sign * prod(signs[factor] for factor, exponent in p.exponents.items() if exponent % 2)
        for name, p in products.items()
    }


def sign_of_number(value: Expr) -> int:
    """The sign of an exact number, rational in pi: exact.

    >>> from sympy import Integer, pi
    >>> sign_of_number(pi - Integer(3)), sign_of_number(Integer(0))
    (1, 0)
    """
    if isinstance(value, Rational):
        return int(value.p > 0) - int(value.p < 0)
    if PolynomialRing(omega).convert(value).is_zero:
        return 0
    bits = 64
    while bits < 1 << 20:  # a number that is not zero shows it before
        with flint.ctx.workprec(bits):
            ball = expression_ball(value)
            if ball > 0 or ball < 0:
                return 1 if ball > 0 else -1
        bits *= 2
    raise UndecidedError(f"the sign of {value}")
