"""Where real functions of omega vanish on a band, and which signs they have in between: all zeros
and poles, proven.

The result is a ``Chart``: all zeros and poles of all functions on a band in order, and the sign of
every function before, at and after each. Every question about a band (crossings, percepts,
activity, stability) is read off a chart. What is decided by several signs at once is a ``Lattice``,
the largest of the smallest of functions, and is read off the same chart.

Functions are taken apart into irreducible factors, and each factor finds its own zeros. These are
put in order by enclosures as tight as it takes: zeros of different irreducible polynomials always
differ, so that this ends; whether zeros of other functions differ may stay undecided. Begin reading
at ``chart``.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import pairwise, product
from math import prod
from typing import Any, NamedTuple, TypeAlias, TypeVar

import flint
from flint import arb
from sympy import Expr, Rational

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.factoring import Known, Product, factored_function, is_even_or_odd
from haptisym.kernel.factors import AnalyticFactor, PolynomialFactor
from haptisym.kernel.objects import Viewed
from haptisym.kernel.reals import (
    MOST_BITS,
    ORDER_BITS,
    SURE_BITS,
    Ball,
    ExactNumber,
    RealNumber,
    at_rising_precision,
    expression_ball,
    in_sympy,
    is_in_pi,
    ordered,
)
from haptisym.kernel.rings import PolynomialRing, omega
from haptisym.kernel.zeros import Factor, Undecided, Zero, sign_of

T = TypeVar("T")


def is_told(x: RealNumber) -> bool:
    """Whether a number is enclosed in a finite ball at the precisions that ``ordered`` uses."""
    return any(x.ball(bits).is_finite() for bits in ORDER_BITS)


def ascending(items: Iterable[T], number: Callable[[T], RealNumber]) -> list[T]:
    """Things sorted by their numbers, ascending; those with equal numbers keep their order."""

    def before(x: T, y: T) -> int:
        return -ordered(number(x), number(y))

    return sorted(items, key=cmp_to_key(before))


def each_once(items: Iterable[T], number: Callable[[T], RealNumber]) -> list[T]:
    """Things sorted by their numbers, ascending; of those with equal numbers only the first."""
    row = ascending(items, number)
    return [x for i, x in enumerate(row) if not i or ordered(number(row[i - 1]), number(x))]


def in_order(numbers: Sequence[RealNumber]) -> list[RealNumber]:
    """Different numbers in ascending order, by enclosures as tight as it takes; UndecidedError
    where two cannot be shown to differ."""
    tick()
    # Only numbers whose balls overlap with a neighbour's are refined, each once.
    balls, tight = [x.rough() for x in numbers], set[int]()
    while True:
        order = sorted(range(len(numbers)), key=lambda i: balls[i].mid())
        close = {i for a, b in pairwise(order) if not balls[a] < balls[b] for i in (a, b)} - tight
        if not close:
            break
        tight |= close
        for i in close:
            balls[i] = numbers[i].ball(64)
    if all(balls[a] < balls[b] for a, b in pairwise(order)):
        return [numbers[i] for i in order]
    return _told_apart(numbers)


def _told_apart(numbers: Sequence[RealNumber]) -> list[RealNumber]:
    """``in_order`` for numbers of which some are nearly equal: all are refined together."""
    close: list[Ball] = []

    def told_apart(bits: int) -> list[RealNumber] | None:
        enclosed = sorted(((x.ball(bits), x) for x in numbers), key=lambda pair: pair[0].mid())
        close[:] = [a for (a, _), (b, _) in pairwise(enclosed) if not a < b]
        return None if close else [number for _, number in enclosed]

    # Zeros of different irreducible polynomials differ, and with enough bits show it. Zeros of
    # analytic functions may coincide: then no number of bits would be enough.
    analytic = (isinstance(x, Zero) and not isinstance(x.factor, PolynomialFactor) for x in numbers)
    may_coincide = any(analytic) or any(isinstance(x, Undecided) for x in numbers)
    most = MOST_BITS if may_coincide else SURE_BITS
    in_sequence = at_rising_precision(told_apart, 128, most)
    if in_sequence is None:
        raise UndecidedError(
            f"whether two frequencies near {float(close[0].mid()):.17g} rad/s are the same"
        )
    return in_sequence


class LatticePiece(NamedTuple):
    """The name on a chart of one function of a lattice: the lattice's name, the term, and the place
    in the term."""

    name: Hashable
    term: int
    place: int


@dataclass(frozen=True)
class Lattice:
    """max over ``terms`` of the min over each: positive exactly where all functions of one term
    are."""

    terms: tuple[tuple[RealFunction, ...], ...]

    @classmethod
    def largest(cls, functions: Iterable[RealFunction]) -> Lattice:
        """Positive where any of the functions is."""
        return cls(tuple((f,) for f in functions))

    def pieces(self, name: Hashable) -> dict[LatticePiece, RealFunction]:
        """The functions of the lattice by their names on a chart."""
        return {
            LatticePiece(name, i, j): f
            for i, term in enumerate(self.terms)
            for j, f in enumerate(term)
        }

    def sign(self, name: Hashable, of: Callable[[LatticePiece], int]) -> int:
        """The sign of the lattice, from those of its functions: max and min keep signs."""
        return max(
            min(of(LatticePiece(name, i, j)) for j in range(len(term)))
            for i, term in enumerate(self.terms)
        )


Signed: TypeAlias = RealFunction | Lattice
"""A real function whose sign a chart tells."""


class Met(NamedTuple):
    """A lattice at a point of a chart: its order, its signs just below and just above, and whether
    its sign at the point is undecided."""

    order: int
    before: int
    after: int
    undecided: bool


def met(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    sides: tuple[Mapping[Hashable, int], Mapping[Hashable, int]],
    doubtful: frozenset[Hashable],
) -> Met:
    """A lattice at a point, from the orders and the signs of its functions there.

    ``sides`` : the signs just below and just above. ``doubtful`` : the functions of which it is not
    known whether they vanish at the point.
    """
    before, after = (lattice.sign(name, side.__getitem__) for side in sides)
    low, high = (_at(lattice, name, orders, side, {}) for side in sides)
    # A doubtful function may have any sign right at the point. Only where these give the lattice
    # different signs is the lattice undecided.
    unknown = [x for x in lattice.pieces(name) if x in doubtful]
    possible = set[int]()
    if unknown:
        possible = {_at(lattice, name, orders, sides[1], guess) for guess in _guesses(unknown)}
    # A pole of the lattice, not only of a function: odd or even as its sign changes or not. A zero
    # counts where the lattice is positive beside it, or negative on both sides, and touches 0.
    if _INFINITE in (abs(low), abs(high)):
        order = -1 if before != after else -2
    elif low == 0 and (before > 0 or after > 0 or (before, after) == (-1, -1)):
        order = _order(lattice, name, orders, sides, odd=before != after)
    else:
        order = 0
    return Met(order, before, after, len(possible) > 1)


# The size of the sign of a pole: larger than that of any finite value, so that it wins max and min.
_INFINITE = 2


def _guesses(unknown: list[LatticePiece]) -> Iterator[dict[LatticePiece, int]]:
    """All combinations of signs that functions of unknown sign may have."""
    return (
        dict(zip(unknown, guess, strict=True)) for guess in product((-1, 0, 1), repeat=len(unknown))
    )


def _at(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    side: Mapping[Hashable, int],
    guess: Mapping[LatticePiece, int],
) -> int:
    """The sign of a lattice right at a point, as a limit from one side; twice that where it is
    infinite."""

    def sign(piece: LatticePiece) -> int:
        order = orders.get(piece, 0)
        if piece in guess:
            return guess[piece]
        if order > 0:
            return 0
        return side[piece] * (_INFINITE if order < 0 else 1)

    return lattice.sign(name, sign)


def _order(
    lattice: Lattice,
    name: Hashable,
    orders: Mapping[Hashable, int],
    sides: tuple[Mapping[Hashable, int], Mapping[Hashable, int]],
    *,
    odd: bool,
) -> int:
    """The least order of a function that makes the lattice vanish, raised by one where needed so
    that it is odd exactly where the sign changes.

    Seen from the side above the point, or from that below it where, because another function jumps
    over a pole, none is found above.
    """

    def seen(side: Mapping[Hashable, int]) -> Iterator[int]:
        # A term is 0 at the point if one of its functions is and no other one is negative.
        for i, term in enumerate(lattice.terms):
            names = [LatticePiece(name, i, j) for j in range(len(term))]
            if all(orders.get(x, 0) > 0 or side[x] >= 0 for x in names):
                yield from (orders[x] for x in names if orders.get(x, 0) > 0)

    least = next(min(orders_seen) for side in sides[::-1] if (orders_seen := [*seen(side)]))
    return least if least % 2 == odd else least + 1


Key: TypeAlias = Hashable
"""The name of a function of a chart."""
Signs: TypeAlias = Mapping[Key, int]


@dataclass(frozen=True)
class Point(Viewed):
    """A frequency ``omega``, rad/s, where a function vanishes or has a pole, or an end of the band.

    ``orders`` : order of each function there: positive at a zero, negative at a pole, absent at
    neither.
    ``before``, ``after`` : the sign of each function just below and just above, -1, 0 or 1; 0 where
    it vanishes everywhere.
    ``undecided`` : the functions of which it is not known whether they vanish here, twice nearby,
    or not at all. Proven:
    between neighbouring points no function changes its sign. ``float(point)`` is omega, rounded.
    """

    omega: RealNumber
    orders: Mapping[Key, int]
    before: Signs
    after: Signs
    undecided: frozenset[Key] = frozenset()

    def __repr__(self) -> str:
        return f"<Point at {self.omega!r} rad/s>"

    def __float__(self) -> float:
        return float(self.omega)

    def _sympy_(self) -> Expr:
        return in_sympy(self.omega)

    @property
    def at(self) -> Signs:
        """The sign of each function right here: 0 at a zero; at a pole, the sign on both sides or
        0."""
        signs = dict(self.after)
        for name, sign in self.before.items():
            if self.orders.get(name, 0) > 0 or sign != signs[name]:
                signs[name] = 0
        return signs


@dataclass(frozen=True)
class Interval(Viewed):
    """A piece of the band from ``low`` to ``high``, both ``Point``, rad/s; a single frequency if
    both are the same.

    The sign of each function that was asked about is constant between its ends.
    """

    low: Point
    high: Point

    def __repr__(self) -> str:
        return f"<Interval from {self.low.omega!r} to {self.high.omega!r} rad/s>"


@dataclass(frozen=True)
class Chart:
    """All zeros and poles of some functions on a band, in order, with the signs of all functions
    around each.

    The first and the last point are the ends of the band. Between neighbouring points no function
    vanishes.
    """

    points: tuple[Point, ...]

    def __repr__(self) -> str:
        return f"<Chart of {len(self.points[0].after)} functions, {len(self.points)} points>"

    def where(self, test: Callable[[Signs], bool]) -> tuple[Interval, ...]:
        """The set of frequencies whose signs pass the test, as intervals in order, as few as
        possible."""
        # ``start`` is the low end of the interval that reaches up to here, None where none does. A
        # point and the open interval above it are tested in turn.
        intervals: list[Interval] = []
        start: Point | None = None
        for point, following in zip(self.points, [*self.points[1:], None], strict=True):
            if not test(point.at):
                start = None
            elif start is None:
                start = point
                intervals.append(Interval(point, point))
            if following is not None and test(point.after):
                if start is None:
                    start = point
                    intervals.append(Interval(point, following))
                else:
                    intervals[-1] = Interval(intervals[-1].low, following)
            else:
                start = None
        return tuple(intervals)

    def reach(self, intervals: Sequence[Interval]) -> RealNumber | None:
        """Where the first of some intervals ends, which begins at the low end of the band: of those
        on which nothing is noticed the bandwidth. None where none begins there."""
        is_first = bool(intervals) and intervals[0].low is self.points[0]
        return intervals[0].high.omega if is_first else None

    def sign_changes(self, name: Key) -> tuple[Point, ...]:
        """The points at which a function changes its sign: odd zeros and odd poles."""
        return tuple(point for point in self.points if point.before[name] * point.after[name] < 0)

    @property
    def undecided(self) -> tuple[Point, ...]:
        """The points at which something stayed undecided."""
        return tuple(point for point in self.points if point.undecided)


def chart(functions: Mapping[Any, Signed], low: Expr, high: Expr) -> Chart:
    """The chart of real functions of omega on the band from ``low`` to ``high`` (0 <= low < high,
    rational in pi).

    Guaranteed: every zero and every pole on the closed band is a point; no other frequency is; all
    orders and signs are exact. A function that is zero everywhere has sign 0 everywhere. Functions
    with delays or powers of omega are entire functions, so that tangencies, and nothing else, may
    stay undecided; their points say so. UndecidedError where even the order of two points, or what
    happens at an end of the band, stays open.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from sympy import Integer
    >>> f = RealFunction(Ring().axis.convert((omega**2 - 2) ** 2 * (omega**2 - 9)))
    >>> for point in chart({"f": f}, Integer(0), Integer(9)).points:
    ...     print(point.omega.digits(5), point.before["f"], point.orders.get("f", 0), point.after["f"])
    0 -1 0 -1
    1.4142 -1 2 -1
    3.0000 -1 1 1
    9.0000 1 0 1
    """
    lattices = {name: f for name, f in functions.items() if isinstance(f, Lattice)}
    single = {name: f for name, f in functions.items() if not isinstance(f, Lattice)}
    for name, lattice in lattices.items():
        single |= lattice.pieces(name)
    points = _charted(single, low, high)
    return (
        Chart(tuple(_joined(functions, lattices, point) for point in points))
        if lattices
        else Chart(points)
    )


def _joined(names: Iterable[Key], lattices: Mapping[Key, Lattice], point: Point) -> Point:
    """A point in the names of functions and lattices, in place of the functions that lattices are
    made of."""
    sides = point.before, point.after
    lattices_met = {
        name: met(x, name, point.orders, sides, point.undecided) for name, x in lattices.items()
    }
    listed = list(names)
    orders = {
        x: lattices_met[x].order if x in lattices_met else point.orders.get(x, 0) for x in listed
    }
    doubtful = {
        name for name, x in lattices_met.items() if x.undecided
    } | point.undecided.intersection(listed)
    before = {x: lattices_met[x].before if x in lattices_met else point.before[x] for x in listed}
    after = {x: lattices_met[x].after if x in lattices_met else point.after[x] for x in listed}
    return Point(
        point.omega, {x: n for x, n in orders.items() if n}, before, after, frozenset(doubtful)
    )


def _charted(functions: Mapping[Key, RealFunction], low: Expr, high: Expr) -> tuple[Point, ...]:
    """The points of a chart of single functions, without lattices."""
    for f in functions.values():
        if root := f.axis.root_in(f.function.numerator, f.function.denominator):
            raise SceneError(
                f"{root}: zeros are found of functions with rational numbers: give it as a decimal"
            )
    # Factors in omega^2 are only allowed if all functions have them: else one frequency could be a
    # zero of two different factors, which are taken to differ.
    even = all(is_even_or_odd(function) for function in functions.values())
    products = _products(functions, in_square=even)
    factors = {factor for product in products.values() for factor in product.exponents}
    _refuse_endless(factors, low, high)
    # A factor that shows one sign all over the band at a quick look has no zero to search for.
    steady = {f: sign for f in factors if (sign := f.steady_sign(low, high))}
    places = _places(factors - steady.keys(), low, high)
    signs = _first_signs(products, places, steady)
    points: list[Point] = []
    for place in places:
        orders = {name: n for name, product in products.items() if (n := _order_at(product, place))}
        other_side = _turned(signs, products, orders, place)
        if points:
            before, after = signs, other_side
        else:  # the signs just below the low end follow from those just above it
            before, after = other_side, signs
        points.append(Point(place.omega, orders, before, after, _undecided(products, place)))
        signs = after
    return tuple(points)


_MOST_TURNS = 10**5
"""How often a delay's phase may turn on a band: each turn may bring some crossings, and nobody
reads a million of them."""


def _refuse_endless(factors: Iterable[Factor], low: Expr, high: Expr) -> None:
    """SceneError where a delay turns so often on the band that its crossings cannot be listed."""
    rates = {
        rate
        for f in factors
        if isinstance(f, AnalyticFactor)
        for rate, constant in f.rates
        if not constant
    }
    for rate in rates:
        with flint.ctx.workprec(64):
            turns = abs(
                expression_ball(rate)
                * (expression_ball(high) - expression_ball(low))
                / (2 * arb.pi())
            )
            if turns > _MOST_TURNS:
                seconds, times = (
                    f"{float(x.mid()):.3g}" for x in (abs(expression_ball(rate)), turns)
                )
                turned = f"{seconds} s turns its phase {times} times on the band"
                raise SceneError(
                    f"a delay of {turned}, more than {_MOST_TURNS} times: give a shorter "
                    f"delay or band"
                )


def _products(functions: Mapping[Key, RealFunction], *, in_square: bool) -> dict[Key, Product]:
    """The functions taken apart into factors, short ones first, whose factors occur in the
    denominators of others and are tried there."""
    known, products = Known(), dict[Key, Product]()

    def length(name: Key) -> int:
        return len(functions[name].function.denominator)

    for name in sorted(functions, key=length):
        products[name] = factored_function(functions[name], known, in_square=in_square)
    return {name: products[name] for name in functions}


def _turned(
    signs: Signs, products: Mapping[Key, Product], orders: Mapping[Key, int], place: _Place
) -> dict[Key, int]:
    """The signs of the functions on the other side of a place: those change that have an odd order
    there, but for even functions at omega = 0, which are mirrored."""
    odd = [
        name
        for name, n in orders.items()
        if n % 2 and not (place.is_zero and _is_even(products[name]))
    ]
    return {**signs, **{name: -signs[name] for name in odd}}


def _is_even(product: Product) -> bool:
    """Whether a function counts as even although its order at 0 is odd: one with powers omega^alpha
    is not defined below 0, and keeps its sign."""
    return not product.power.is_Integer or any(
        isinstance(f, AnalyticFactor) and f.orders for f in product.exponents
    )


def _undecided(products: Mapping[Key, Product], place: _Place) -> frozenset[Key]:
    """The functions that have a factor of which it is undecided whether it vanishes at a place."""
    if not place.undecided:
        return frozenset()
    return frozenset(
        name for name, p in products.items() if not place.undecided.isdisjoint(p.exponents)
    )


def _order_at(product: Product, place: _Place) -> int:
    """The order of a function at a place: positive at a zero, negative at a pole."""
    order = sum(
        product.exponents[factor] * n
        for factor, n in place.orders.items()
        if factor in product.exponents
    )
    return _whole(product.power + order) if place.is_zero else int(order)


def _whole(order: Expr) -> int:
    """An order as a whole number; a fractional one, of omega^alpha at 0, rounded away from 0."""
    if order.is_Integer:
        return int(order)
    sign = sign_of_number(order)
    return sign * (int(abs(float(order))) + 1)


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
    # Whether a function vanishes at an end is decided exactly; zeros inside are enclosed.
    ends = [ExactNumber(low), ExactNumber(high)]
    at_ends = [{f: n for f in factors if (n := f.order_at(end.value))} for end in ends]
    # A polynomial factor that vanishes at an end, rational in pi, is linear: that is its one zero.
    done: set[Factor] = {f for at_end in at_ends for f in at_end if isinstance(f, PolynomialFactor)}
    zeros: dict[RealNumber, dict[Factor, int]] = {}
    for f in factors - done:
        tick()
        for number in f.zeros(low, high):
            zeros.setdefault(number, {})[f] = f.multiplicity(number)
    # Factors may give zeros outside of the band as well.
    ascending_places = in_order([*ends, *zeros])
    first, last = (ascending_places.index(end) for end in ends)
    inside = ascending_places[first + 1 : last]
    middle = [
        _Place(x, zeros[x], undecided=frozenset(zeros[x] if isinstance(x, Undecided) else ()))
        for x in inside
    ]
    return [_Place(ends[0], at_ends[0], is_zero=low == 0), *middle, _Place(ends[1], at_ends[1])]


def _first_signs(
    products: Mapping[Key, Product], places: list[_Place], steady: Mapping[Factor, int]
) -> dict[Key, int]:
    """The sign of each function between the first two places."""
    first, second = places[0].omega, places[1].omega
    ends = first.rough().upper(), second.rough().lower()

    def between(bits: int) -> Ball:
        # Any number in between will do: an exact one where rough balls leave room for it.
        if ends[0] < ends[1]:
            return ((ends[0] + ends[1]) / 2).mid()
        return (first.ball(bits) + second.ball(bits)) / 2

    signs = dict(steady)
    for factor in {f for p in products.values() for f in p.exponents} - steady.keys():
        # A sign known at the high end, which costs nothing, counted back over all zeros in between.
        end = places[-1].omega
        known = factor.shown_sign(end.value) if isinstance(end, ExactNumber) else 0
        changes = sum(place.orders.get(factor, 0) for place in places[1:-1])
        signs[factor] = known * (-1) ** changes or factor.sign_at(between)
    return {
        name: p.sign
        * prod(signs[factor] for factor, exponent in p.exponents.items() if exponent % 2)
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
    if is_in_pi(value):
        with flint.ctx.workprec(128):
            quick = sign_of(expression_ball(value))
        if quick:
            return quick
    # Exact zeros never show in balls: pi is transcendental, so that conversion to a quotient of
    # polynomials in pi decides.
    if PolynomialRing(omega).convert(value).is_zero:
        return 0
    # A number that is not zero shows it below this many bits.
    if sign := at_rising_precision(
        lambda _: sign_of(expression_ball(value)) or None, most=SURE_BITS
    ):
        return sign
    raise UndecidedError(f"the sign of {value}")
