"""How far a function turns along the imaginary axis: counted on a chart of the zeros of its real and imaginary part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import flint
from flint import acb, arb
from sympy import Expr, Integer

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import Chart, Point, chart
from haptisym.kernel.terms import Terms

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


def turned(parts: Sequence[RealFunction], terms: Terms, start: Expr, reach: Expr, ring: Ring) -> tuple[Chart, Ball]:
    """The chart up to j R, and the angle there in quarters, counted on from the direction ``start`` just above 0."""
    curve = chart(dict(zip(("real", "imag"), parts, strict=True)), Integer(0), reach)
    return curve, _lifted(_last_quadrant(curve, start), terms, reach, ring)


_QUADRANT = {(1, 1): 0, (-1, 1): 1, (-1, -1): 2, (1, -1): 3}


def _last_quadrant(curve: Chart, start: Expr) -> int:
    """Quarter turns, counted on from the direction ``start`` of D just above omega = 0, at which the last quadrant begins."""
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
    """The whole turn of D up to j R, in quarters: its angle there, which lies in the quadrant that begins at ``quarter``."""
    with flint.ctx.workprec(BITS):
        value = value_at(terms, reach, ring)
        middle = acb(0, -1) ** (quarter % 4) * acb(1, -1)  # turns the quadrant's middle onto the positive real axis
        return quarter + arb(1) / 2 + (value * middle).arg() * 2 / arb.pi()


def value_at(terms: Terms, reach: Expr, ring: Ring) -> acb:
    """The value at j R."""
    at = expression_ball(reach)
    return sum((_power(at, p) * factor_at(group, reach, ring) for p, group in terms.items()), acb(0))


def _power(omega: Ball, exponent: Expr) -> acb:
    """(j omega)^p, omega > 0."""
    p = expression_ball(exponent)
    return acb(0, p * arb.pi() / 2).exp() * omega**p


def factor_at(group: Mapping[tuple[int, ...], Expr], reach: Expr, ring: Ring) -> acb:
    """The value at j R of what a power of s is multiplied by."""
    angles = [expression_ball(lag) * expression_ball(reach) for lag in ring.lags]
    total = acb(0)
    for turns, c in group.items():
        total += expression_ball(c) * acb(0, -sum((n * x for n, x in zip(turns, angles, strict=True)), arb(0))).exp()
    return total


def whole(lacking: Ball) -> int:
    """The whole number that is less than 1/2 away, as this is known to be but for 1/6."""
    found = round(float(lacking))
    if not abs(lacking - found) < arb(1) / 3:
        raise UndecidedError("a turn of a characteristic function")
    return found
