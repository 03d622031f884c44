"""How many roots a characteristic function has in the closed right half plane: the argument principle, counted on a chart.

D(s) is a polynomial in s, delays exp(-s tau) and powers s^alpha. As omega goes from 0 to a reach R beyond which one power of s
prevails, the turns of D(j omega) are read off the signs of its real and imaginary part; what is left of the contour is known
from that power alone. Of A + B exp(-s tau) it is known from A, a polynomial, from where on |A| > |B|. Roots on the axis are
passed on their left, so that they count.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from math import ceil

import flint
from flint import acb, arb
from sympy import Expr, I, Integer, Rational, pi

from haptisym.kernel.contour import BITS, factor_at, parts_of, times, turned, value_at, whole
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, degree_in
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.kernel.squares import late_turns, positive_from
from haptisym.kernel.symbols import s
from haptisym.kernel.terms import Terms, at_least, beginning_at_0, size, terms_of
from haptisym.kernel.torus import is_mirrored, least_on_torus

_MOST_TURNING = 2000  # radians that the delays turn up to the reach: thousands of zeros take minutes
_DEEPEST = 20  # times that a way is halved
_FINEST = 64  # times that a bound is halved before it is given up


class RootChain(Enum):
    """Where infinitely many roots of large modulus lie, if they do not all lie clear of the axis on its left."""

    NEAR = "as near to the imaginary axis as one likes"
    RIGHT = "to the right of the imaginary axis"


@dataclass(frozen=True)
class Roots:
    """The roots in Re s >= 0, each as often as it counts; None where a ``chain`` makes them infinitely many or hides them.

    ``right`` : those with Re s > 0. ``on_axis``: the frequencies of the others, rad/s, ascending.
    """

    number: int | None
    right: int | None
    on_axis: tuple[RealNumber, ...] = ()
    chain: RootChain | None = None


def count_roots(polynomial: Polynomial, ring: Ring, *, rests: bool = False) -> Roots:
    """The roots of a polynomial of a ring in Re s >= 0, certified. UndecidedError where that stays open.

    ``rests`` : whether it is known that there is none but one at 0, unless a chain comes as near to the axis as one likes.

    Guaranteed: for polynomials, and with delays where the highest power of s outweighs its own delayed terms (else the chain of
    roots that these make is recognised: exactly for one unit delay, and for independent ones that multiply it once each).
    Not decided: more than some hundred turns, delays whose chain is none of these, and functions with j among their numbers.

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
    if (line := _root_of_line(terms)) is not None:
        return line
    degree = max(terms)
    floor = RootChain.NEAR if rests and is_mirrored(terms[degree]) else floor_of(terms[degree], ring)
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
    left_of_it = whole(lacking)  # the contour passes roots on the axis on their left, but that at 0 on its right
    at_0 = [curve.points[0].omega] if order else []
    right = left_of_it - 2 * sum(map(times, passed))
    return Roots(left_of_it + at_least(order), right, (*at_0, *(p.omega for p in passed)))


def _root_of_line(terms: Terms) -> Roots | None:
    """The root of a s + b, if there is one; None of anything else."""
    if not terms.keys() <= {0, 1} or any(any(turns) for group in terms.values() for turns in group):
        return None
    b, a = (sum(terms.get(Integer(n), {}).values(), Integer(0)) for n in (0, 1))
    if not a or not b:
        return Roots(int(bool(a)), 0, (ExactNumber(Integer(0)),) if a else ())
    right = int(sign_of_number(a) != sign_of_number(b))
    return Roots(right, right)


def _turn_of_own(own: Polynomial, terms: Terms, reach: Expr, ring: Ring) -> Ball:
    """The angle of A + B exp(-s tau) at j R, in quarters, that it would have from there on with no root on the right.

    That of A, by twice its roots there more, and the angle from A on, less than a quarter turn: |A| > |B| there.
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
    """A number > 0 that |L| is nowhere less than where all |exp(-s tau)| <= 1; or where the chain of its zeros lies."""
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
    if all(sum(turns) == 1 for turns in delayed) and _are_independent([ring.lags[i] for i in used]):
        return RootChain.RIGHT if sign_of_number(margin) else RootChain.NEAR  # the phases oppose as nearly as one likes
    return _floor_of_several(group)


def _are_independent(lags: Sequence[Expr]) -> bool:
    """Whether no sum of whole multiples of the delays is 0: they are rational multiples of different powers of pi."""
    rests = [lag.as_coeff_Mul()[1] for lag in lags]
    powers = all(rest == 1 or (rest.as_base_exp()[0] == pi and rest.as_base_exp()[1].is_Integer) for rest in rests)
    return powers and len(set(rests)) == len(rests)


def _floor_of_several(group: Mapping[tuple[int, ...], Expr]) -> Expr | RootChain:
    """With unit delays that are taken as independent: as where all are one, if L is not 0 on the axis whatever they are."""
    least = least_on_torus(group)
    if least is None:
        raise UndecidedError("the chain of roots of a neutral function with several delays")
    alike: dict[tuple[int, ...], Expr] = {}
    for turns, c in group.items():
        alike[(sum(turns),)] = alike.get((sum(turns),), Integer(0)) + c
    return least if not isinstance(_floor_of_one(alike, 0), RootChain) else RootChain.RIGHT


def _floor_of_one(group: Mapping[tuple[int, ...], Expr], place: int) -> Expr | RootChain:
    """With one unit delay z = (1 - w)/(1 + w): |z| <= 1 where Re w >= 0, and z = -1 where w is infinite."""
    ring = Ring()
    n = max(turns[place] for turns in group)
    powers = [sum((c for turns, c in group.items() if turns[place] == i), Integer(0)) for i in range(n + 1)]
    turned = sum((c * (1 - s) ** i * (1 + s) ** (n - i) for i, c in enumerate(powers)), Integer(0))
    w = ring.convert(turned.expand()).numerator
    inside = count_roots(w, ring)
    if inside.number or int(w.degrees()[0]) < n:
        return RootChain.RIGHT if inside.right else RootChain.NEAR
    real, imag = parts_of(w, ring)
    square = real.function * real.function + imag.function * imag.function
    circle = ring.axis.convert((1 + _omega(ring) ** 2) ** n)
    bound = Rational(1)
    for _ in range(_FINEST):
        excess = square - ring.axis.convert(bound**2) * circle
        if _is_positive(excess.numerator, ring, 2 * n):
            return bound
        bound /= 2
    raise UndecidedError("how near the chain of a neutral function comes to the axis")


def _omega(ring: Ring) -> Expr:
    return ring.axis.meanings[0]


def _is_positive(even: Polynomial, ring: Ring, degree: int) -> bool:
    """Whether a polynomial in omega is positive on [0, infinity], as is its coefficient of that degree, the highest it has."""
    axis = ring.axis
    reverse = {}
    for exponents, value in monomials(even):
        reverse[(degree - int(exponents[0]), *exponents[1:])] = value
    sides = {"near": even, "far": axis.context.from_dict(reverse)}
    table = chart({name: RealFunction(axis.function(p)) for name, p in sides.items()}, Integer(0), Integer(1))
    return all(sign > 0 for point in table.points for sign in point.at.values())


# The contour


def _reach(polynomial: Polynomial, terms: Terms, floor: Expr, ring: Ring) -> tuple[Expr, Polynomial | None]:
    """R such that for |s| >= R, Re s >= 0 all lower powers are at most half the highest, L at its least, and None.

    Or a much smaller R from which on |A| > |B| on the axis, of A + B exp(-s tau), and A: it turns with A then, and never about 0.
    """
    degree = max(terms)
    weights = {p: 2 * sum(map(size, group.values()), Integer(0)) for p, group in terms.items() if p < degree}
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
    turns = ceil(float(radius * own[0]) / 6.28)  # whole ones of the one delay in L, which is real there
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
        lower = [(expression_ball(p - degree), expression_ball(weight)) for p, weight in weights.items()]
        n = -20
        while not least > sum((weight * arb(2) ** (n * p) for p, weight in lower), arb(0)):
            n += 1
    return Rational(2) ** n


def _own_turn(group: Mapping[tuple[int, ...], Expr], reach: Expr, ring: Ring) -> Ball:
    """The angle of L at j R, in quarters, beyond that of its undelayed term: 0 where one delay has made whole turns.

    L has no zero where all |z| <= 1: its angle is that which it turns by on the way from 0 to z, along rho z.
    """
    if len(_delays_of(group, ring)) <= 1:
        return arb(0)
    with flint.ctx.workprec(BITS):
        terms = [(factor_at({turns: c}, reach, ring), sum(turns)) for turns, c in group.items()]
        return _turn_along(terms, arb(0), arb(1), _DEEPEST) * 2 / arb.pi()


def _turn_along(terms: Sequence[tuple[acb, int]], low: Ball, high: Ball, depth: int) -> Ball:
    """The angle by which a polynomial with these coefficients and powers turns: on pieces on which it stays in a half plane."""
    between, start, end = (sum((c * x**n for c, n in terms), acb(0)) for x in (low.union(high), low, high))
    if not (between.real.contains(0) and between.imag.contains(0)):
        return (end / start).arg()
    if not depth:
        raise UndecidedError("how far the highest power of s turns with its delays")
    middle = (low + high) / 2
    return _turn_along(terms, low, middle, depth - 1) + _turn_along(terms, middle, high, depth - 1)
