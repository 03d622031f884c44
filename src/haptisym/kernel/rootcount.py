"""How many roots a characteristic function has in the closed right half plane: the argument
principle, counted on a chart.

D(s) is a polynomial in s, delays exp(-s tau) and powers s^alpha. As omega goes from 0 to a reach R
beyond which one power of s prevails, the turns of D(j omega) are read off the signs of its real and
imaginary part; what is left of the contour is known from that power alone. Of A + B exp(-s tau) it
is known from A, a polynomial, from where on |A| > |B|. Roots on the axis are passed on their left,
so that they count. Whether all poles lie in the open left half plane is asked of rational dynamics
by Routh's array.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from heapq import merge
from itertools import groupby, pairwise, product
from math import ceil
from typing import TypeAlias

import flint
from flint import acb, arb
from sympy import Expr, I, Integer, Rational, factorial, pi

from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    RealNumber,
    at_rising_precision,
    expression_ball,
)
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in, monomials, s
from haptisym.kernel.roots import Chart, Point, chart, sign_of_number

_MOST_TERMS = 64  # of the expansion at s = 0 that are tried

Terms: TypeAlias = dict[Rational, dict[tuple[int, ...], Expr]]
"""By the power of s, and by how often each unit delay is in them."""


def terms_of(polynomial: Polynomial, ring: Ring) -> Terms:
    """A polynomial by its powers of s, each with a number for every product of unit delays; none of
    them 0."""
    found: Terms = {}
    lags = len(ring.lags)
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        turns, powers = tuple(own[ring.size : ring.size + lags]), own[ring.size + lags :]
        power = sum(
            (n * order for n, order in zip(powers, ring.orders, strict=False)), Integer(own[0])
        )
        group = found.setdefault(power, {})
        number = Rational(int(value.p), int(value.q))
        group[turns] = group.get(turns, Integer(0)) + (number * pi ** own[1] if own[1] else number)
    exact = {
        p: {turns: c for turns, c in group.items() if sign_of_number(c)}
        for p, group in found.items()
    }
    return {p: group for p, group in exact.items() if group}


def size(number: Expr) -> Expr:
    """The absolute value of an exact number."""
    return number * sign_of_number(number)


def order_at_0(polynomial: Polynomial, ring: Ring) -> Rational:
    """The order of a zero at s = 0, where 1 - exp(-s tau) has one too, and s^alpha one of order
    alpha."""
    if not ring.functions:  # powers of s with numbers before them, none of which is 0
        return Integer(min(int(exponents[0]) for exponents in polynomial.monoms()))
    return beginning_at_0(terms_of(polynomial, ring), ring)[0]


def at_least(order: Rational) -> int:
    """How often a zero of that order counts: a fractional one, of s^alpha, as the next whole
    number."""
    return -int(-order.p // order.q)


def beginning_at_0(terms: Terms, ring: Ring) -> tuple[Rational, int]:
    """Exponent and sign of the first term of the expansion at s = 0."""
    rising = merge(*(map(p.__add__, map(Integer, range(_MOST_TERMS))) for p in terms))
    for exponent, _ in groupby(rising):
        meeting = ((group, exponent - p) for p, group in terms.items() if exponent >= p)
        total = sum(
            (_coefficient(group, int(k), ring) for group, k in meeting if k.is_Integer), Integer(0)
        )
        if sign := sign_of_number(total):
            return exponent, sign
    raise UndecidedError("the order of a characteristic function at s = 0")


def _coefficient(group: Mapping[tuple[int, ...], Expr], k: int, ring: Ring) -> Expr:
    """Of s^k in the sum of c exp(-s lag)."""
    if not k:
        return sum(group.values(), Integer(0))
    lags = {
        turns: sum((n * x for n, x in zip(turns, ring.lags, strict=True)), Integer(0))
        for turns in group
    }
    return sum(
        (c * (-lags[turns]) ** k for turns, c in group.items()), Integer(0)
    ).expand() / factorial(k)


BITS = 128


def parts_of(polynomial: Polynomial, ring: Ring) -> tuple[RealFunction, RealFunction]:
    """D(j omega) times a factor > 0: exact real and imaginary part."""
    axis = ring.axis
    (a, b), (c, d) = axis.parts([polynomial, polynomial.context().constant(1)])
    modulus = c * c + d * d
    return (
        RealFunction(axis.function(a * c + b * d, modulus).reduced()),
        RealFunction(axis.function(b * c - a * d, modulus).reduced()),
    )


def times(point: Point) -> int:
    """How often D vanishes at a point: real and imaginary part at once."""
    return max(min(point.orders.get(name, 0) for name in ("real", "imag")), 0)


def turned(
    parts: Sequence[RealFunction], terms: Terms, start: Expr, reach: Expr, ring: Ring
) -> tuple[Chart, Ball]:
    """The chart up to j R, and the angle there in quarters, counted on from the direction ``start``
    just above 0."""
    curve = chart(dict(zip(("real", "imag"), parts, strict=True)), Integer(0), reach)
    return curve, _lifted(_last_quadrant(curve, start), terms, reach, ring)


_QUADRANT = {(1, 1): 0, (-1, 1): 1, (-1, -1): 2, (1, -1): 3}


def _last_quadrant(curve: Chart, start: Expr) -> int:
    """Quarter turns, counted on from the direction ``start`` of D just above omega = 0, at which
    the last quadrant begins."""
    if curve.undecided:
        raise UndecidedError("whether a characteristic function vanishes on the imaginary axis")
    quadrants = [_QUADRANT[p.after["real"], p.after["imag"]] for p in curve.points[:-1]]
    now = next(n for n in (int(start // 1), int(-(-start // 1)) - 1) if n % 4 == quadrants[0])
    for point, (before, after) in zip(curve.points[1:], pairwise(quadrants), strict=False):
        passed = -2 * times(point)
        step = (after - before - passed) % 4
        if step == 2:
            raise UndecidedError("a turn of a characteristic function")
        now += passed + {0: 0, 1: 1, 3: -1}[step]
    return now


def _lifted(quarter: int, terms: Terms, reach: Expr, ring: Ring) -> Ball:
    """The whole turn of D up to j R, in quarters: its angle there, which lies in the quadrant that
    begins at ``quarter``."""
    with flint.ctx.workprec(BITS):
        value = value_at(terms, reach, ring)
        middle = acb(0, -1) ** (quarter % 4) * acb(
            1, -1
        )  # turns the quadrant's middle onto the positive real axis
        return quarter + arb(1) / 2 + (value * middle).arg() * 2 / arb.pi()


def value_at(terms: Terms, reach: Expr, ring: Ring) -> acb:
    """The value at j R."""
    at = expression_ball(reach)
    return sum(
        (_power(at, p) * factor_at(group, reach, ring) for p, group in terms.items()), acb(0)
    )


def _power(omega: Ball, exponent: Expr) -> acb:
    """(j omega)^p, omega > 0."""
    p = expression_ball(exponent)
    return acb(0, p * arb.pi() / 2).exp() * omega**p


def factor_at(group: Mapping[tuple[int, ...], Expr], reach: Expr, ring: Ring) -> acb:
    """The value at j R of what a power of s is multiplied by."""
    angles = [expression_ball(lag) * expression_ball(reach) for lag in ring.lags]
    total = acb(0)
    for turns, c in group.items():
        total += (
            expression_ball(c)
            * acb(0, -sum((n * x for n, x in zip(turns, angles, strict=True)), arb(0))).exp()
        )
    return total


def whole(lacking: Ball) -> int:
    """The whole number that is less than 1/2 away, as this is known to be but for 1/6."""
    found = round(float(lacking))
    if not abs(lacking - found) < arb(1) / 3:
        raise UndecidedError("a turn of a characteristic function")
    return found


Row: TypeAlias = list[Expr]
"""The coefficients of a polynomial in one number that is open, ascending; one alone where none
is."""

_BITS = 128
_FIRST, _MOST_DOUBLINGS = Rational(1, 1 << 20), 80


def late_turns(turns: set[tuple[int, ...]], powers: Sequence[Rational]) -> tuple[int, ...] | None:
    """The one product of unit delays that comes late; None where there are more or none, or powers
    of s are broken."""
    late = [x for x in turns if any(x)]
    return late[0] if len(late) == 1 and all(p.is_Integer for p in powers) else None


def squares(
    table: Mapping[Rational, Mapping[tuple[int, ...], Row]], late: tuple[int, ...]
) -> list[Row]:
    """By falling powers of omega^2, from a table by the power of s and by how often each unit delay
    is in it."""
    none = (0,) * len(late)
    degree = int(max(table))
    longest = max(len(row) for group in table.values() for row in group.values())
    rows = [[Integer(0)] * (2 * longest - 1) for _ in range(degree + 1)]
    for p, r in product(table, repeat=2):
        if (p - r) % 2:
            continue
        row, sign = rows[degree - int(p + r) // 2], (-1) ** (int(abs(p - r)) // 2)
        for turns, side in ((none, sign), (late, -sign)):
            for i, x in enumerate(table[p].get(turns, ())):
                for k, y in enumerate(table[r].get(turns, ())):
                    row[i + k] += side * x * y
    return [[c.expand() for c in row] for row in rows]


def positive_from(terms: Terms, late: tuple[int, ...]) -> Rational | None:
    """A frequency beyond which |A|^2 - |B|^2 > 0; None where none is found. |A| must not be the
    less at infinity."""
    table = {p: {turns: [c] for turns, c in group.items()} for p, group in terms.items()}
    with flint.ctx.workprec(_BITS):
        first, *others = (expression_ball(row[0]).lower() for row in squares(table, late))
        weights = [first.max(arb(0)), *others[:1], *(x.min(arb(0)) for x in others[1:])]
        at = _FIRST
        for _ in range(_MOST_DOUBLINGS):
            ball = arb(int(at.p)) / int(at.q)
            if sum((x * ball ** (2 - 2 * i) for i, x in enumerate(weights)), arb(0)) > 0:
                return at
            at *= 2
    return None


def is_mirrored(group: Mapping[tuple[int, ...], Expr]) -> bool:
    """Whether L(1/z) is L(z) or -L(z) but for powers of z: with each zero in s, -s is one too,
    however long the delays are.

    >>> from sympy import Integer
    >>> of = [{(0, 0): 3, (1, 0): 1, (0, 1): 1, (1, 1): 3}, {(0, 0): 3, (1, 0): 1, (0, 1): 2, (1, 1): 3}, {(0, 0): 3}]
    >>> [is_mirrored({turns: Integer(c) for turns, c in group.items()}) for group in of]
    [True, False, False]
    """
    most = [max(column) for column in zip(*group, strict=True)]
    other = {
        turns: group.get(tuple(n - k for n, k in zip(most, turns, strict=True)), 0)
        for turns in group
    }
    return len(group) > 1 and any(
        all(c == side * other[turns] for turns, c in group.items()) for side in (1, -1)
    )


_MOST_BITS = 512  # of Routh's array
_MOST_TURNING = (
    2000  # radians that the delays turn up to the reach: thousands of zeros take minutes
)
_ARCS = 1 << 8, 1 << 13  # of the unit circle


class RootChain(Enum):
    """Where infinitely many roots of large modulus lie, if they do not all lie clear of the axis on
    its left."""

    NEAR = "as near to the imaginary axis as one likes"
    RIGHT = "to the right of the imaginary axis"


@dataclass(frozen=True)
class Roots:
    """The roots in Re s >= 0, each as often as it counts; None where a ``chain`` makes them
    infinitely many or hides them.

    ``right`` : those with Re s > 0. ``on_axis``: the frequencies of the others, rad/s, ascending.
    """

    number: int | None
    right: int | None
    on_axis: tuple[RealNumber, ...] = ()
    chain: RootChain | None = None


def count_roots(polynomial: Polynomial, ring: Ring, *, rests: bool = False) -> Roots:
    """The roots of a polynomial of a ring in Re s >= 0, certified. UndecidedError where that stays
    open.

    ``rests`` : whether it is known that there is none but one at 0, unless a chain comes as near to
    the axis as one likes.

    Guaranteed: for polynomials, and with delays where the highest power of s outweighs its own
    delayed terms (else the chain of roots that these make is recognised exactly for one unit
    delay).
    Not decided: more than some hundred turns, delays whose chain is none of these, and functions
    with j among their numbers.

    >>> from sympy import exp
    >>> def roots(expression):
    ...     ring = Ring.of([expression])
    ...     return count_roots(ring.convert(expression).numerator, ring).number
    >>> roots(s**2 - s + 1), roots((s**2 + 1) ** 2 * (s + 1)), roots(s + exp(-s)), roots(s + 2 * exp(-s))
    (2, 4, 0, 2)
    >>> ring = Ring.of([exp(-s)])
    >>> count_roots(ring.convert(s + 1 + 2 * s * exp(-s)).numerator, ring).chain.value         # neutral: Re s goes to log 2
    'to the right of the imaginary axis'
    """
    if I in ring.generators and degree_in([polynomial], len(ring.meanings) - 1):
        raise UndecidedError("the roots of a function with j among its numbers")
    polynomial = _without_shared_delays(polynomial, ring)
    terms = terms_of(polynomial, ring)
    degree = max(terms)
    floor = (
        RootChain.NEAR if rests and is_mirrored(terms[degree]) else floor_of(terms[degree], ring)
    )
    if isinstance(floor, RootChain):
        return Roots(None, None, chain=floor)
    if rests:
        order = beginning_at_0(terms, ring)[0]
        return Roots(at_least(order), 0, (ExactNumber(Integer(0)),) if order else ())
    reach, own = _reach(polynomial, terms, floor, ring)
    parts = parts_of(polynomial, ring)
    if any(part.is_zero for part in (*parts, *(() if own is None else parts_of(own, ring)))):
        return count_roots(
            polynomial * (ring.variable + 1), ring
        )  # as of s^2 + 1: another root on the left turns it off both axes
    order, sign = beginning_at_0(terms, ring)
    start = 0 if sign > 0 else 2
    curve, angle = turned(parts, terms, order + start, reach, ring)
    with flint.ctx.workprec(BITS):
        settled = (
            expression_ball(degree) + _own_turn(terms[degree], reach, ring)
            if own is None
            else _turn_of_own(own, terms, reach, ring)
        )
        lacking = (start + settled - angle) / 2
    passed = [p for p in curve.points[1:] if times(p)]
    left_of_it = whole(
        lacking
    )  # the contour passes roots on the axis on their left, but that at 0 on its right
    at_0 = [curve.points[0].omega] if order else []
    right = left_of_it - 2 * sum(map(times, passed))
    return Roots(left_of_it + at_least(order), right, (*at_0, *(p.omega for p in passed)))


def _turn_of_own(own: Polynomial, terms: Terms, reach: Expr, ring: Ring) -> Ball:
    """The angle of A + B exp(-s tau) at j R, in quarters, that it would have from there on with no
    root on the right.

    That of A, by twice its roots there more, and the angle from A on, less than a quarter turn: |A|
    > |B| there.
    """
    alone = terms_of(own, ring)
    order, sign = beginning_at_0(alone, ring)
    start = 0 if sign > 0 else 2
    number = count_roots(own, ring).number
    assert number is not None
    angle = turned(parts_of(own, ring), alone, order + start, reach, ring)[1]
    beyond = (value_at(terms, reach, ring) / value_at(alone, reach, ring)).arg() * 2 / arb.pi()
    return 2 * (number - at_least(order)) - start + angle + beyond


def _without_shared_delays(polynomial: Polynomial, ring: Ring) -> Polynomial:
    """Without the delays that all terms share, which are nowhere 0."""
    for i in range(ring.size, ring.size + len(ring.lags)):
        shared = min(int(exponents[i]) for exponents in polynomial.monoms())
        if shared:
            polynomial = polynomial / ring.context.gens()[i] ** shared
    return polynomial


# What the highest power of s is multiplied by, L(exp(-s tau_1), ...)


def floor_of(group: Mapping[tuple[int, ...], Expr], ring: Ring) -> Expr | RootChain:
    """A number > 0 that |L| is nowhere less than where all |exp(-s tau)| <= 1; or where the chain
    of its zeros lies."""
    own = next((c for turns, c in group.items() if not any(turns)), Integer(0))
    delayed = {turns: c for turns, c in group.items() if any(turns)}
    margin = size(own) - sum(map(size, delayed.values()), Integer(0))
    if sign_of_number(own) == 0:
        return RootChain.RIGHT
    if sign_of_number(margin) > 0:
        return margin
    used = {i for turns in delayed for i, n in enumerate(turns) if n}
    if len(used) == 1:
        return _floor_of_one(group, used.pop())
    raise UndecidedError("the chain of roots of a neutral function with several delays")


def _floor_of_one(group: Mapping[tuple[int, ...], Expr], place: int) -> Expr | RootChain:
    """With one unit delay z = (1 - w)/(1 + w): |z| <= 1 where Re w >= 0, and z = -1 where w is
    infinite."""
    ring = Ring()
    n = max(turns[place] for turns in group)
    powers = [
        sum((c for turns, c in group.items() if turns[place] == i), Integer(0))
        for i in range(n + 1)
    ]
    turned = sum((c * (1 - s) ** i * (1 + s) ** (n - i) for i, c in enumerate(powers)), Integer(0))
    w = ring.convert(turned.expand()).numerator
    inside = count_roots(w, ring)
    if inside.number or int(w.degrees()[0]) < n:
        return RootChain.RIGHT if inside.right else RootChain.NEAR
    with flint.ctx.workprec(BITS):
        row = [expression_ball(c) for c in powers]
        for arcs in _ARCS:
            turns = (arb(i) / arcs + arb(0, 0.5 / arcs) for i in range(arcs))
            on_arcs = (
                abs(
                    sum((c * acb(0, 2 * arb.pi() * x * k).exp() for k, c in enumerate(row)), acb(0))
                )
                for x in turns
            )
            least = float(min(x.lower() for x in on_arcs))
            if least > 0:
                return Rational(least) * Rational(999, 1000)
    raise UndecidedError("how near the chain of a neutral function comes to the axis")


# The contour


def _reach(
    polynomial: Polynomial, terms: Terms, floor: Expr, ring: Ring
) -> tuple[Expr, Polynomial | None]:
    """R such that for |s| >= R, Re s >= 0 all lower powers are at most half the highest, L at its
    least, and None.

    Or a much smaller R from which on |A| > |B| on the axis, of A + B exp(-s tau), and A: it turns
    with A then, and never about 0.
    """
    degree = max(terms)
    weights = {
        p: 2 * sum(map(size, group.values()), Integer(0))
        for p, group in terms.items()
        if p < degree
    }
    radius = prevailing(degree, floor, weights)
    late = late_turns({x for group in terms.values() for x in group}, [*terms])
    nearer = None if late is None else positive_from(terms, late)
    if nearer is not None and 2 * nearer < radius:
        _need_few_turns(nearer, terms, ring)
        return nearer, _undelayed(polynomial, ring)
    _need_few_turns(radius, terms, ring)
    [*own] = _delays_of(terms[degree], ring)
    if len(own) != 1:
        return radius, None
    turns = ceil(
        float(radius * own[0]) / 6.28
    )  # whole ones of the one delay in L, which is real there
    return 2 * pi * turns / own[0], None


def _need_few_turns(radius: Rational, terms: Terms, ring: Ring) -> None:
    late = {i for group in terms.values() for turns in group for i, n in enumerate(turns) if n}
    if any(sign_of_number(radius * ring.lags[i] - _MOST_TURNING) > 0 for i in late):
        raise UndecidedError("the roots of a function that its delays turn thousands of times")


def _undelayed(polynomial: Polynomial, ring: Ring) -> Polynomial:
    """The terms that no delay is in."""
    lags = range(ring.size, ring.size + len(ring.lags))
    kept = {x: c for x, c in polynomial.to_dict().items() if not any(int(x[i]) for i in lags)}
    return polynomial.context().from_dict(kept)


def _delays_of(group: Mapping[tuple[int, ...], Expr], ring: Ring) -> list[Expr]:
    return [lag for i, lag in enumerate(ring.lags) if any(turns[i] for turns in group)]


def prevailing(degree: Rational, floor: Expr, weights: Mapping[Rational, Expr]) -> Rational:
    """A radius from which on floor radius^degree exceeds the weighted lower powers."""
    with flint.ctx.workprec(BITS):
        least = expression_ball(floor)
        lower = [
            (expression_ball(p - degree), expression_ball(weight)) for p, weight in weights.items()
        ]
        n = -20
        while not least > sum((weight * arb(2) ** (n * p) for p, weight in lower), arb(0)):
            n += 1
    return Rational(2) ** n


def _own_turn(group: Mapping[tuple[int, ...], Expr], reach: Expr, ring: Ring) -> Ball:
    """The angle of L at j R, in quarters, beyond that of its undelayed term: 0 where one delay has
    made whole turns.

    Of several that term outweighs all others.
    """
    if len(_delays_of(group, ring)) <= 1:
        return arb(0)
    own = next(c for turns, c in group.items() if not any(turns))
    with flint.ctx.workprec(BITS):
        return (factor_at(group, reach, ring) / expression_ball(own)).arg() * 2 / arb.pi()


def is_stable(dynamics: RationalFunction) -> bool | None:
    """Whether all finite poles of a dynamics in lowest terms lie in the open left half plane; None
    where not decided.

    Rational dynamics: Routh's array in balls. With delays and powers of s, and where that does not
    tell: by ``count_roots`` of the denominator, and None where that stays open, or a chain of poles
    comes as near to the axis as one likes.

    >>> from haptisym.kernel.rings import s
    >>> from sympy import exp
    >>> def of(expression): return is_stable(Ring.of([expression]).convert(expression).reduced())
    >>> of(1 / (s**3 + 2 * s**2 + 3 * s + 4)), of(1 / (s**2 + 1))
    (True, False)
    >>> of(1 / (s + exp(-s))), of(1 / (s + 2 * exp(-s)))        # s + a exp(-s) is stable for 0 < a < pi/2
    (True, False)
    """
    ring = dynamics.ring
    assert isinstance(ring, Ring)
    try:
        order = order_at_0(dynamics.denominator, ring)
        if order and order > order_at_0(dynamics.numerator, ring):
            return False  # a pole at 0
        if not any(
            degree_in([dynamics.denominator], i) for i in range(ring.size, len(ring.meanings))
        ):
            row = ring.coefficients(dynamics.denominator / ring.variable ** int(order))
            right = at_rising_precision(
                lambda _: routh([expression_ball(c) for c in row]), 128, _MOST_BITS
            )
            if right is not None:
                return right == 0
        found = count_roots(dynamics.denominator, ring)
    except UndecidedError:
        return None
    if found.number is None:
        return False if found.chain is RootChain.RIGHT else None
    return bool(found.number == ceil(order))


def routh(c: Sequence[Ball]) -> int | None:
    """How many roots a polynomial with ascending coefficients has in Re s > 0, none being on the
    axis: Routh's array.

    None where balls do not tell, as where two roots add up to 0.
    """
    above, own, signs = list(c[::-2]), list(c[-2::-2]), [c[-1]]
    while own and not signs[-1].contains(0):
        signs.append(own[0])
        ratio = above[0] / own[0]
        above, own = (
            own,
            [x - ratio * y for x, y in zip(above[1:], [*own[1:], arb(0)], strict=False)],
        )
    if any(x.contains(0) or not x.is_finite() for x in signs):
        return None
    return sum(bool(x * y < 0) for x, y in pairwise(signs))
