"""How many roots has a characteristic function D(s) in the closed right half plane Re s >= 0?

D(s) = sum of s^p L_p(s) over powers p >= 0, which may be fractions, with coefficients L_p(s) = sum
of c exp(-s lag). All numbers are exact. Each lag is a sum of *unit delays*, those of the ring; a
term is known by how often each is in it. L = L_n, of the highest power n, is the *leading
coefficient*.

**The argument principle.** Let phi be the angle of D in quarter turns, followed along a path: from
a small real number e > 0 on a small quarter circle to the imaginary axis, up the axis to j R, and
back to a large real number X beyond all roots. Roots on the axis are passed on their left, so that
they count; 0 is passed on its right. D is real for real s, so that path and mirror image enclose
all roots in the half plane, and N roots in there give phi(X) - phi(e) = -2 N. On the way from j R
to X D turns back by a known number of quarter turns, *settled*. Hence

    N = (phi(e) + settled - phi(j R))/2.

phi(e) is 0 or 2, by the sign of D; phi(j R) is read off the exact signs of the real and imaginary
part of D(j omega) on a chart (``turned``). The *reach* R is one of two:

- For |s| >= R, Re s >= 0 the power s^n prevails. The way back is a quarter circle, and settled is n
  and the turn of L.
- D = A + B exp(-s tau) with polynomials A and B, and |A| > |B| on the axis from j R on. The way
  back goes further up the axis, and then round a circle, and D turns with A.

If L has delays (neutral type) D has a *chain* of infinitely many roots that tend to the zeros of L.
They must lie clear of the axis on its left, |L| >= floor > 0 for Re s >= 0, or there is no count
(``floor_of``).

**Guaranteed**: the count is exact, or there is an UndecidedError. Whether all poles of rational
dynamics lie in the open left half plane is decided by Routh's array (``is_stable``). Begin reading
at ``count_roots``.
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
from flint import acb, arb, arb_poly
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

Exponents: TypeAlias = tuple[int, ...]
"""How often each unit delay is in a product of them, in the order of ``ring.lags``; (0, ...) is the
undelayed term."""
Coefficient: TypeAlias = Mapping[Exponents, Expr]
"""L_p, the coefficient of a power of s: its numbers c by the exponents of exp(-s lag)."""
Terms: TypeAlias = dict[Rational, dict[Exponents, Expr]]
"""The coefficients L_p of a characteristic function by the power p of s."""
Row: TypeAlias = list[Expr]
"""The coefficients, ascending, of a polynomial in one free parameter; a single one where there is
no parameter."""

# Bits of working precision of balls: far more than it takes to tell whole numbers of turns.
BITS = 128
# The most bits of working precision for Routh's array: the next way, a count, is slower.
_ROUTH_BITS = 512
# Terms of the expansion at s = 0 that are tried until one does not vanish.
_MOST_TERMS = 64
# Radians by which a delay may turn up to the reach: thousands of zeros on a chart take minutes.
_MOST_TURNING = 2000
# Into so many arcs the unit circle is cut to bound |L| on it: few at first, then many.
_ARCS = 1 << 8, 1 << 13
# Frequencies that are tried as the one beyond which |A| > |B|: from about 1e-6 to 1e18 rad/s.
_FIRST, _MOST_DOUBLINGS = Rational(1, 1 << 20), 80
# The first exponent n of the radii 2^n that are tried for the reach: about 1e-6 rad/s.
_LOWEST_POWER_OF_2 = -20
# The quadrant by the signs of real and imaginary part, as the quarter turn at which it begins.
_QUADRANT = {(1, 1): 0, (-1, 1): 1, (-1, -1): 2, (1, -1): 3}


def count_roots(polynomial: Polynomial, ring: Ring, *, rests: bool = False) -> Roots:
    """Return the roots of a polynomial of a ring in Re s >= 0, proven; UndecidedError where that
    stays open.

    ``rests`` : whether it is known beforehand, as of a passive system, that there is no such root
    but at 0, unless a chain of roots comes as near to the axis as one likes.

    Decided: polynomials, and functions with delays where in the leading coefficient the undelayed
    term outweighs the delayed ones, or one unit delay alone occurs.
    Not decided: delays that turn by more than some thousand radians up to the reach, other chains
    of roots, and functions with j among their numbers.

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
    leading = terms[degree]
    floor = RootChain.NEAR if rests and is_mirrored(leading) else floor_of(leading, ring)
    if isinstance(floor, RootChain):
        return Roots(None, None, chain=floor)
    if rests:
        order = beginning_at_0(terms, ring)[0]
        return Roots(at_least(order), 0, (ExactNumber(Integer(0)),) if order else ())
    reach, undelayed = _reach(polynomial, terms, floor, ring)
    parts = parts_of(polynomial, ring)
    every_part = [*parts]
    if undelayed is not None:
        every_part += parts_of(undelayed, ring)
    if any(part.is_zero for part in every_part):
        # As of s^2 + 1, which is real on the axis, so that no quadrant shows where it is. A further
        # root at -1 turns it off both axes and does not count.
        return count_roots(polynomial * (ring.variable + 1), ring)
    order, sign = beginning_at_0(terms, ring)
    start = 0 if sign > 0 else 2
    curve, angle = turned(parts, terms, order + start, reach, ring)
    # N = (phi(e) + settled - phi(j R))/2, with phi(e) = ``start`` (see the module's docstring).
    with flint.ctx.workprec(BITS):
        if undelayed is None:
            settled = expression_ball(degree) + _own_turn(leading, reach, ring)
        else:
            settled = _turn_of_own(undelayed, terms, reach, ring)
        lacking = (start + settled - angle) / 2
    passed = [p for p in curve.points[1:] if times(p)]
    # The contour passes roots on the axis on their left, but that at 0 on its right: those on the
    # axis count twice (at +-j omega), and those at 0 are added.
    left_of_it = whole(lacking)
    at_0 = [curve.points[0].omega] if order else []
    right = left_of_it - 2 * sum(map(times, passed))
    return Roots(left_of_it + at_least(order), right, (*at_0, *(p.omega for p in passed)))


class RootChain(Enum):
    """Where a chain of infinitely many roots lies, if it does not lie clear of the axis on its
    left."""

    NEAR = "as near to the imaginary axis as one likes"
    RIGHT = "to the right of the imaginary axis"


@dataclass(frozen=True)
class Roots:
    """The roots in Re s >= 0.

    ``number`` : how many there are, with their multiplicities. ``right`` : how many of them have Re
    s > 0. Both are None where there is a ``chain``, of which infinitely many may be among them.
    ``on_axis``: the frequencies >= 0 of those on the axis, rad/s, ascending, each once.
    ``chain`` : None where no chain of roots comes near to the axis or lies right of it.
    """

    number: int | None
    right: int | None
    on_axis: tuple[RealNumber, ...] = ()
    chain: RootChain | None = None


def _turn_of_own(own: Polynomial, terms: Terms, reach: Expr, ring: Ring) -> Ball:
    """Return ``settled`` for D = A + B exp(-s tau), A = ``own``, where |A| > |B| on the axis from j
    R on.

    For A alone it is N = (phi(e) + settled - phi(j R))/2 solved for settled, with N counted as of a
    polynomial. The angle from A to D at j R is added, which is less than a quarter turn.
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
    """Return the polynomial without the delays that all of its terms share: exp(-s tau) is nowhere
    0."""
    for i in range(ring.size, ring.size + len(ring.lags)):
        shared = min(int(exponents[i]) for exponents in polynomial.monoms())
        if shared:
            polynomial = polynomial / ring.context.gens()[i] ** shared
    return polynomial


# The reach


def _reach(
    polynomial: Polynomial, terms: Terms, floor: Expr, ring: Ring
) -> tuple[Expr, Polynomial | None]:
    """The reach R, and A where the turn beyond R is that of A.

    Either R is such that for |s| >= R, Re s >= 0 all lower powers together are at most half of the
    highest one with |L| at its lower bound, and the second value is None. Or, for A + B exp(-s
    tau), R is a much smaller frequency from which on |A| > |B| on the axis: there D turns with A.
    """
    degree = max(terms)
    # Doubled: |D/(s^n L) - 1| <= 1/2 leaves the angle of D within arcsin(1/2), 1/6 of a half turn,
    # of that of s^n L, and the count within 1/6 of a whole number, as ``whole`` needs it.
    weights = dict[Rational, Expr]()
    for p, coefficient in terms.items():
        if p < degree:
            weights[p] = 2 * sum(map(size, coefficient.values()), Integer(0))
    radius = prevailing(degree, floor, weights)
    delay = single_delay({x for coefficient in terms.values() for x in coefficient}, [*terms])
    nearer = None if delay is None else positive_from(terms, delay)
    if nearer is not None and 2 * nearer < radius:
        _need_few_turns(nearer, terms, ring)
        return nearer, _undelayed(polynomial, ring)
    _need_few_turns(radius, terms, ring)
    [*leading_delays] = _delays_of(terms[degree], ring)
    if len(leading_delays) != 1:
        return radius, None
    # Up to a whole number of turns of the one delay in L, where L is real again and has not turned
    # on balance. 6.28 is less than 2 pi: the reach is no less than the radius.
    turns = ceil(float(radius * leading_delays[0]) / 6.28)
    return 2 * pi * turns / leading_delays[0], None


def prevailing(degree: Rational, floor: Expr, weights: Mapping[Rational, Expr]) -> Rational:
    """Return a radius from which on floor radius^degree exceeds the sum of weight radius^p over all
    lower powers p. ``floor`` > 0; ``weights`` : by power."""
    # A power of 2, so that it is exact and short; once lower powers are exceeded, they stay so.
    with flint.ctx.workprec(BITS):
        least = expression_ball(floor)
        lower = []
        for p, weight in weights.items():
            lower.append((expression_ball(p - degree), expression_ball(weight)))

        def prevails(n: int) -> bool:
            others = (weight * arb(2) ** (n * p) for p, weight in lower)
            return bool(least > sum(others, arb(0)))

        n = _LOWEST_POWER_OF_2
        while not prevails(n):
            n += 1
    return Rational(2) ** n


def _need_few_turns(radius: Rational, terms: Terms, ring: Ring) -> None:
    """Raise UndecidedError where a delay turns too often up to the radius for a chart."""
    occurring = set[Expr]()
    for coefficient in terms.values():
        occurring.update(_delays_of(coefficient, ring))
    if any(sign_of_number(radius * lag - _MOST_TURNING) > 0 for lag in occurring):
        raise UndecidedError("the roots of a function that its delays turn thousands of times")


def _undelayed(polynomial: Polynomial, ring: Ring) -> Polynomial:
    """Return A of A + B exp(-s tau): the terms without delays."""
    lags = range(ring.size, ring.size + len(ring.lags))
    kept = {x: c for x, c in polynomial.to_dict().items() if not any(int(x[i]) for i in lags)}
    return polynomial.context().from_dict(kept)


def _delays_of(coefficient: Coefficient, ring: Ring) -> list[Expr]:
    """Return the unit delays, s, that occur in the coefficient of a power of s."""
    return [lag for i, lag in enumerate(ring.lags) if any(x[i] for x in coefficient)]


def _own_turn(leading: Coefficient, reach: Expr, ring: Ring) -> Ball:
    """Return the angle of L at j R, in quarter turns, less that of its undelayed term: 0 where the
    one delay in it has made whole turns (``_reach``).

    Of several delays the undelayed term outweighs all others, so that the angle is less than a
    quarter turn.
    """
    if len(_delays_of(leading, ring)) <= 1:
        return arb(0)
    undelayed = leading[(0,) * len(ring.lags)]
    with flint.ctx.workprec(BITS):
        ratio = coefficient_at(leading, reach, ring) / expression_ball(undelayed)
        return ratio.arg() * 2 / arb.pi()


def single_delay(exponents: set[Exponents], powers: Sequence[Rational]) -> Exponents | None:
    """Return the exponents of the one product of unit delays, exp(-s tau), that occurs in D = A + B
    exp(-s tau) with polynomials A and B; None where D has not that form, as none or several occur,
    or a power of s is fractional. ``exponents`` : those of all terms; ``powers`` : of s."""
    delayed = [x for x in exponents if any(x)]
    if len(delayed) != 1 or not all(p.is_Integer for p in powers):
        return None
    return delayed[0]


def positive_from(terms: Terms, delay: Exponents) -> Rational | None:
    """Return a frequency from which on |A|^2 - |B|^2 > 0 on the axis; None where none is found. |A|
    must not be the smaller one at infinity."""
    table: dict[Rational, dict[Exponents, Row]] = {}
    for p, coefficient in terms.items():
        table[p] = {exponents: [c] for exponents, c in coefficient.items()}
    with flint.ctx.workprec(BITS):
        bound = positive_bound([expression_ball(row[0]) for row in squares(table, delay)])
        omega = _FIRST
        for _ in range(_MOST_DOUBLINGS):
            if bound(expression_ball(omega) ** -2) > 0:
                return omega
            omega *= 2
    return None


def positive_bound(row: Sequence[Ball]) -> arb_poly:
    """Return a lower bound of P/omega^(2N), a polynomial in x = 1/omega^2, that is positive at all
    frequencies above one at which it is.

    P = w_0 omega^(2N) + w_1 omega^(2N - 2) + ..., with its coefficients in the balls of ``row``,
    must not be negative at infinity, so that w_0 >= 0. Then P/omega^(2N) >= w_0 + w_1 x + w_2 x^2 +
    ... with their lower bounds for all w, also where w_2 and all further ones are replaced by 0 if
    they are positive. Divided by x that is w_0/x + w_1 + w_2 x + ..., which falls as x grows,
    whatever w_1 is.
    """
    first, *others = (x.lower() for x in row)
    later = [x.min(arb(0)) for x in others[1:]]
    return arb_poly([first.max(arb(0)), *others[:1], *later])


def squares(table: Mapping[Rational, Mapping[Exponents, Row]], delay: Exponents) -> list[Row]:
    """Return the coefficients of |A|^2 - |B|^2 at s = j omega, by falling powers of omega^2, for
    D = A + B exp(-s tau). ``table`` : as ``Terms``, each coefficient a polynomial in a free
    parameter; ``delay`` : the exponents of exp(-s tau)."""
    undelayed = (0,) * len(delay)
    degree = int(max(table))
    longest = max(len(row) for rows in table.values() for row in rows.values())
    rows = [[Integer(0)] * (2 * longest - 1) for _ in range(degree + 1)]
    # The products a_p a_r j^p (-j)^r omega^(p + r): those of odd p - r cancel in pairs.
    for p, r in product(table, repeat=2):
        if (p - r) % 2:
            continue
        row = rows[degree - int(p + r) // 2]
        sign = (-1) ** (int(abs(p - r)) // 2)
        for exponents, side in ((undelayed, sign), (delay, -sign)):
            for i, x in enumerate(table[p].get(exponents, ())):
                for k, y in enumerate(table[r].get(exponents, ())):
                    row[i + k] += side * x * y
    return [[c.expand() for c in row] for row in rows]


# The angle along the axis


def turned(
    parts: Sequence[RealFunction], terms: Terms, start: Expr, reach: Expr, ring: Ring
) -> tuple[Chart, Ball]:
    """Return the chart of the ``parts`` of D from 0 to R = ``reach``, and phi(j R): the angle of D
    in quarter turns, followed from ``start``, its angle just above omega = 0."""
    curve = chart(dict(zip(("real", "imag"), parts, strict=True)), Integer(0), reach)
    return curve, _lifted(_last_quadrant(curve, start), terms, reach, ring)


def _last_quadrant(curve: Chart, start: Expr) -> int:
    """Return the quarter turn at which the last quadrant of D on a chart begins, followed from
    ``start``, the angle of D just above omega = 0."""
    # An undecided point may be a zero of D, past which the number of turns is not known.
    if curve.undecided:
        raise UndecidedError("whether a characteristic function vanishes on the imaginary axis")
    quadrants = [_QUADRANT[p.after["real"], p.after["imag"]] for p in curve.points[:-1]]
    # D starts within its first quadrant or on an edge of it, so that one of two is the first.
    floor, ceiling = int(start // 1), int(-(-start // 1))
    now = next(n for n in (floor, ceiling - 1) if n % 4 == quadrants[0])
    for point, (before, after) in zip(curve.points[1:], pairwise(quadrants), strict=False):
        # A root on the axis that is passed on its left turns D back by half a turn. What is left is
        # a quarter turn or none, as one part changes its sign at a time; two quarters could be
        # either way round.
        passed = -2 * times(point)
        step = (after - before - passed) % 4
        if step == 2:
            raise UndecidedError("a turn of a characteristic function")
        now += passed + {0: 0, 1: 1, 3: -1}[step]
    return now


def _lifted(quarter: int, terms: Terms, reach: Expr, ring: Ring) -> Ball:
    """Return the angle of D at j R in quarter turns, given that it lies in the quadrant that begins
    at ``quarter``."""
    with flint.ctx.workprec(BITS):
        value = value_at(terms, reach, ring)
        # Turns the quadrant's middle onto the positive real axis, as far as can be from the cut of
        # the argument.
        middle = acb(0, -1) ** (quarter % 4) * acb(1, -1)
        return quarter + arb(1) / 2 + (value * middle).arg() * 2 / arb.pi()


def whole(lacking: Ball) -> int:
    """Return the whole number that a count is, from a ball whose true value differs from it by at
    most 1/6; UndecidedError where the ball is too wide to tell."""
    # 1/3 leaves the ball a radius of 1/6 on top of the deviation, and still tells one number from
    # the next.
    nearest = round(float(lacking))
    if not abs(lacking - nearest) < arb(1) / 3:
        raise UndecidedError("a turn of a characteristic function")
    return nearest


def parts_of(polynomial: Polynomial, ring: Ring) -> tuple[RealFunction, RealFunction]:
    """Return the exact real and imaginary part of D(j omega), both times one factor > 0."""
    axis = ring.axis
    one = polynomial.context().constant(1)
    # ``parts`` multiplies D and 1 by one factor, so that D is (a + j b)/(c + j d).
    (a, b), (c, d) = axis.parts([polynomial, one])
    modulus = c * c + d * d
    above_real = a * c + b * d
    above_imag = b * c - a * d
    real = RealFunction(axis.function(above_real, modulus).reduced())
    imag = RealFunction(axis.function(above_imag, modulus).reduced())
    return real, imag


def times(point: Point) -> int:
    """Return the order of the zero of D at a point of a chart of its two parts, "real" and "imag":
    the smaller of their orders; 0 where D is not 0."""
    return max(min(point.orders.get(name, 0) for name in ("real", "imag")), 0)


def value_at(terms: Terms, reach: Expr, ring: Ring) -> acb:
    """Return a ball around the value of D at j R."""
    omega, total = expression_ball(reach), acb(0)
    for p, coefficient in terms.items():
        total += _power(omega, p) * coefficient_at(coefficient, reach, ring)
    return total


def coefficient_at(coefficient: Coefficient, reach: Expr, ring: Ring) -> acb:
    """Return a ball around the value at j R of the coefficient L_p of a power of s."""
    angles = [expression_ball(lag) * expression_ball(reach) for lag in ring.lags]
    total = acb(0)
    for exponents, c in coefficient.items():
        angle = sum((n * x for n, x in zip(exponents, angles, strict=True)), arb(0))
        total += expression_ball(c) * acb(0, -angle).exp()
    return total


def _power(omega: Ball, exponent: Expr) -> acb:
    """Return (j omega)^p for omega > 0: exp(j p pi/2) omega^p."""
    p = expression_ball(exponent)
    return acb(0, p * arb.pi() / 2).exp() * omega**p


# The terms, and the beginning of the expansion at s = 0


def terms_of(polynomial: Polynomial, ring: Ring) -> Terms:
    """Return the coefficients of a polynomial of the ring, which must have no parameters; none of
    them is 0.

    Exponents of the ring are of s, of pi, then of the unit delays, then of the powers s^order.
    """
    table: Terms = {}
    lags = len(ring.lags)
    for exponents, value in monomials(polynomial):
        degrees = [int(n) for n in exponents]
        of_delays = tuple(degrees[ring.size : ring.size + lags])
        of_orders = degrees[ring.size + lags :]
        # s^n times powers s^alpha are one power of s; terms that differ as monomials may meet in
        # it.
        fractional = (n * order for n, order in zip(of_orders, ring.orders, strict=False))
        power = sum(fractional, Integer(degrees[0]))
        number = Rational(int(value.p), int(value.q))
        if degrees[1]:
            number *= pi ** degrees[1]
        coefficient = table.setdefault(power, {})
        coefficient[of_delays] = coefficient.get(of_delays, Integer(0)) + number
    without_zeros: Terms = {}
    for p, coefficient in table.items():
        numbers = {x: c for x, c in coefficient.items() if sign_of_number(c)}
        if numbers:
            without_zeros[p] = numbers
    return without_zeros


def size(number: Expr) -> Expr:
    """Return the absolute value of an exact number."""
    return number * sign_of_number(number)


def order_at_0(polynomial: Polynomial, ring: Ring) -> Rational:
    """Return the order of the zero of D at s = 0, exact: 1 - exp(-s tau) has one of order 1,
    s^alpha one of order alpha. 0 where D(0) is not 0."""
    if not ring.functions:  # powers of s with numbers before them, none of which is 0
        return Integer(min(int(exponents[0]) for exponents in polynomial.monoms()))
    return beginning_at_0(terms_of(polynomial, ring), ring)[0]


def at_least(order: Rational) -> int:
    """Return the number of roots that a zero of an order counts as: a fractional order counts as
    the next larger whole number."""
    return -int(-order.p // order.q)


def beginning_at_0(terms: Terms, ring: Ring) -> tuple[Rational, int]:
    """Return exponent and sign of the first term of the expansion of D at s = 0 that does not
    vanish; UndecidedError where too many do."""
    # A term of power p has, with its delays expanded, the exponents p, p + 1, p + 2, ...
    rising = merge(*(map(p.__add__, map(Integer, range(_MOST_TERMS))) for p in terms))
    for exponent, _ in groupby(rising):
        total = Integer(0)
        for p, coefficient in terms.items():
            k = exponent - p
            if k >= 0 and k.is_Integer:
                total += _taylor(coefficient, int(k), ring)
        if sign := sign_of_number(total):
            return exponent, sign
    raise UndecidedError("the order of a characteristic function at s = 0")


def _taylor(coefficient: Coefficient, k: int, ring: Ring) -> Expr:
    """Return the coefficient of s^k, sum of c (-lag)^k/k!, in the expansion of the sum of c exp(-s
    lag) at s = 0."""
    if not k:
        return sum(coefficient.values(), Integer(0))
    total = Integer(0)
    for exponents, c in coefficient.items():
        lag = sum((n * x for n, x in zip(exponents, ring.lags, strict=True)), Integer(0))
        total += c * (-lag) ** k
    return total.expand() / factorial(k)


# The leading coefficient L, a polynomial in the unit delays exp(-s tau_i). Where it has delays (the
# neutral type), its zeros are the limits of a chain of infinitely many roots of D.


def floor_of(leading: Coefficient, ring: Ring) -> Expr | RootChain:
    """Return a lower bound > 0 of |L| for all s with Re s >= 0; or, where there is none, where the
    chain of roots lies. UndecidedError for several delays that outweigh the undelayed term."""
    undelayed = leading.get((0,) * len(ring.lags), Integer(0))
    delayed = {exponents: c for exponents, c in leading.items() if any(exponents)}
    # A highest power with delays alone (the advanced type): roots run off to the right.
    if sign_of_number(undelayed) == 0:
        return RootChain.RIGHT
    # |z| <= 1 for all delays z, as Re s >= 0.
    margin = size(undelayed) - sum(map(size, delayed.values()), Integer(0))
    if sign_of_number(margin) > 0:
        return margin
    used = {i for exponents in delayed for i, n in enumerate(exponents) if n}
    if len(used) == 1:
        return _floor_of_one(leading, used.pop())
    raise UndecidedError("the chain of roots of a neutral function with several delays")


def _floor_of_one(leading: Coefficient, place: int) -> Expr | RootChain:
    """Return what ``floor_of`` does for an L with one unit delay z = exp(-s tau), the one with the
    index ``place``: a polynomial in z, and |z| <= 1 where Re s >= 0.

    With z = (1 - w)/(1 + w) the disc |z| <= 1 is the half plane Re w >= 0, in which zeros are
    counted; z = -1 is w = infinity, and shows as a lower degree in w.
    """
    n = max(exponents[place] for exponents in leading)
    by_power = [Integer(0)] * (n + 1)
    for exponents, c in leading.items():
        by_power[exponents[place]] += c
    # The variable of this ring, s, is w.
    ring, in_w = Ring(), Integer(0)
    for i, c in enumerate(by_power):
        in_w += c * (1 - s) ** i * (1 + s) ** (n - i)
    polynomial = ring.convert(in_w.expand()).numerator
    inside = count_roots(polynomial, ring)
    if inside.number or int(polynomial.degrees()[0]) < n:
        return RootChain.RIGHT if inside.right else RootChain.NEAR
    # No zero in the disc: by the minimum principle |L| is least on the circle, which is covered by
    # balls of short arcs.
    with flint.ctx.workprec(BITS):
        row = [expression_ball(c) for c in by_power]

        def value_on(arc: Ball) -> acb:
            waves = (acb(0, 2 * arb.pi() * arc * k).exp() for k in range(len(row)))
            return sum((c * x for c, x in zip(row, waves, strict=True)), acb(0))

        for arcs in _ARCS:
            # Arcs as shares of a turn.
            shares = (arb(i) / arcs + arb(0, 0.5 / arcs) for i in range(arcs))
            least = float(min(abs(value_on(x)).lower() for x in shares))
            if least > 0:
                # A float is rounded by much less than a thousandth.
                return Rational(least) * Rational(999, 1000)
    raise UndecidedError("how near the chain of a neutral function comes to the axis")


def is_mirrored(leading: Coefficient) -> bool:
    """Whether L(1/z) is L(z) or -L(z) up to powers of z, for L as a polynomial in the unit delays z
    = exp(-s tau): then with each zero s of L, -s is one too, however long the delays are, and a
    chain of roots cannot lie on the left alone.

    >>> from sympy import Integer
    >>> of = [{(0, 0): 3, (1, 0): 1, (0, 1): 1, (1, 1): 3}, {(0, 0): 3, (1, 0): 1, (0, 1): 2, (1, 1): 3}, {(0, 0): 3}]
    >>> [is_mirrored({turns: Integer(c) for turns, c in group.items()}) for group in of]
    [True, False, False]
    """
    if len(leading) <= 1:
        return False
    # Times z^degrees, L(1/z) has the same numbers c in the opposite order.
    degrees = [max(column) for column in zip(*leading, strict=True)]
    pairs = []
    for exponents, c in leading.items():
        opposite = tuple(n - k for n, k in zip(degrees, exponents, strict=True))
        pairs.append((c, leading.get(opposite, 0)))
    return all(c == other for c, other in pairs) or all(c == -other for c, other in pairs)


# Stability of a dynamics


def is_stable(dynamics: RationalFunction) -> bool | None:
    """Whether all finite poles of a dynamics in lowest terms lie in the open left half plane; None
    where that is not decided.

    For rational dynamics by Routh's array in balls. With delays and powers of s, and where the
    array does not decide, by ``count_roots`` of the denominator; None where that stays open, or a
    chain of poles comes as near to the axis as one likes.

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
        beyond_s = range(ring.size, len(ring.meanings))
        if not any(degree_in([dynamics.denominator], i) for i in beyond_s):
            # A zero at 0 that the numerator shares is no pole.
            row = ring.coefficients(dynamics.denominator / ring.variable ** int(order))

            def count(_: int) -> int | None:
                return routh([expression_ball(c) for c in row])

            right = at_rising_precision(count, BITS, _ROUTH_BITS)
            if right is not None:
                return right == 0
        roots = count_roots(dynamics.denominator, ring)
    except UndecidedError:
        return None
    if roots.number is None:
        return False if roots.chain is RootChain.RIGHT else None
    return bool(roots.number == ceil(order))


def routh(c: Sequence[Ball]) -> int | None:
    """Return how many roots a polynomial with ascending coefficients has in Re s > 0: the changes
    of sign in the first column of Routh's array.

    A number proves that no root is on the axis. None where a ball in that column contains 0, as
    where two roots add up to 0.
    """
    # Two rows of the array at a time; ``column`` is the first one, which each new row extends.
    above, row = list(c[::-2]), list(c[-2::-2])
    column = [c[-1]]
    while row and not column[-1].contains(0):
        column.append(row[0])
        ratio = above[0] / row[0]
        # A row may be shorter by one than that above it: it goes on with 0.
        pairs = zip(above[1:], [*row[1:], arb(0)], strict=False)
        above, row = row, [x - ratio * y for x, y in pairs]
    if any(x.contains(0) or not x.is_finite() for x in column):
        return None
    return sum(bool(x * y < 0) for x, y in pairwise(column))
