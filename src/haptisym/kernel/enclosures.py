"""Enclosures over an interval: Bernstein coefficients of polynomials, interpolation on circles of
anything, in balls.

A ball grows with each number that occurs twice in a formula; two forms stay as narrow as the
function is smooth.

*Bernstein.* A polynomial of degree n on [-r, r] lies between its least and its greatest coefficient
in the basis of Bernstein's polynomials. A ``FunctionPiece`` is a function between two frequencies as such
a polynomial: by Taylor's theorem its last coefficient is one over the whole piece.

*Circles.* A function f that is analytic for |q - m| <= R, and there differs by at most M from some
number, has Taylor coefficients of at most M/R^k (Cauchy). The polynomial of degree < N that has its
values at N points all around |q - m| = r is off by at most 2 M (r/R)^N/(1 - r/R) for |q - m| <= r,
as t^k and t^(k mod N) have the same values there. So M may be found in one wide ball, in which
everything is multiplied: the power of r/R makes it small.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import pairwise
from math import comb
from typing import NamedTuple, TypeAlias

import flint
from flint import acb, acb_mat, arb, arb_mat, fmpq

from haptisym.kernel.reals import Ball


def range_of(row: Sequence[Ball], reach: Sequence[Ball]) -> Ball:
    """A ball around the values of c_0 + c_1 h + ... for all h from -r to r, given the powers 1, r,
    r^2, ... of r.

    >>> balls = [arb(c) for c in (3, 0, 1)]
    >>> range_of(balls, [arb(1), arb(2), arb(4)])     # 3 + h^2 for -2 <= h <= 2: by Bernstein not below -1
    [+/- 7.01]
    """
    return reduce(
        arb.union, _converted([c * power for c, power in zip(row, reach, strict=False)]).entries()
    )


def bernstein_coefficients(row: Sequence[Ball], reach: Ball) -> arb_mat:
    """The Bernstein coefficients of c_0 + c_1 h + ... between h = -r and h = r, in a column.

    >>> bernstein_coefficients([arb(3), arb(0), arb(1)], arb(2)).entries()
    [7.00000000000000, -1.00000000000000, 7.00000000000000]
    """
    scaled, power = [row[0]], arb(1)
    for c in row[1:]:
        power = power * reach
        scaled.append(c * power)
    return _converted(scaled)


def _converted(row: Sequence[Ball]) -> arb_mat:
    degree = len(row) - 1
    return _conversion(degree, flint.ctx.prec) * arb_mat(degree + 1, 1, row)


@lru_cache(maxsize=64)
def _conversion(degree: int, bits: int) -> arb_mat:
    """From the coefficients of 1, u, u^2, ... to those of the Bernstein polynomials on [-1, 1]."""
    with flint.ctx.workprec(bits):
        return arb_mat(
            [[arb(_weight(degree, j, k)) for k in range(degree + 1)] for j in range(degree + 1)]
        )


def _weight(degree: int, j: int, k: int) -> fmpq:
    """The part of u^k = (t - (1 - t))^k (t + (1 - t))^(degree - k), t = (1 + u)/2, in the j-th
    Bernstein polynomial."""
    ways = sum((-1) ** (k - i) * comb(k, i) * comb(degree - k, j - i) for i in range(min(j, k) + 1))
    return fmpq(ways, comb(degree, j))


Series: TypeAlias = Callable[[Ball, int, int], Sequence[Ball]]
"""Balls around the Taylor coefficients of a function, of orders from one to before another, about
every point of a ball."""

_ORDER = 8  # of the polynomial


@dataclass(frozen=True, eq=False, slots=True)
class FunctionPiece:
    """A function between ``low`` and ``high``: at each x in there it, and its slopes, are those of
    one of the polynomials.

    Taylor's theorem: the last coefficient is one of those over the whole piece; which one may
    change with x. ``row``: the coefficients between the exact numbers ``ends``, which enclose low
    and high.
    """

    low: Ball
    high: Ball
    ends: tuple[Ball, Ball]
    row: Sequence[Ball]

    @classmethod
    def of(cls, series: Series, low: Ball, high: Ball) -> FunctionPiece:
        """A function with those Taylor coefficients between two exact numbers, at the current
        working precision."""
        with flint.ctx.workprec(
            flint.ctx.prec - 60
        ):  # so that the ends of its parts are exact numbers too
            middle = ((low + high) / 2).mid()
        with flint.ctx.workprec(30):
            reach = (high - middle).max(middle - low).upper()
        ends = middle - reach, middle + reach
        row = [*series(middle, 0, _ORDER), *series(ends[0].union(ends[1]), _ORDER, _ORDER + 1)]
        return cls(low, high, ends, bernstein_coefficients(row, reach).entries())

    def sign(self, order: int = 0) -> int:
        """The sign all over the piece, or that of the slope or the curvature; 0 where it does not
        show."""
        row = self._differences(order)
        if row[0] > 0:
            return int(all(x > 0 for x in row))
        return -int(row[0] < 0 and all(x < 0 for x in row))

    def _differences(self, order: int) -> Sequence[Ball]:
        """The coefficients of the slope, the curvature, ... up to numbers > 0."""
        row = self.row
        for _ in range(order):
            row = [b - a for a, b in pairwise(row)]
        return row

    def sign_at(self, end: int, order: int = 0) -> int:
        """That at one of the ends, 0 for the low one and -1 for the high one; 0 where it does not
        show."""
        row = self._differences(order)
        found, beyond = row[end], self.ends[end] - (self.low, self.high)[end]
        if not beyond.is_zero() and len(row) > 1:  # by the mean value theorem
            steepest = reduce(arb.max, (abs(b - a).upper() for a, b in pairwise(row))) * (
                len(row) - 1
            )
            found = found + steepest * beyond / (self.ends[1] - self.ends[0]) * _EITHER
        return int(found > 0) - int(found < 0)


_EITHER = arb(0, 1)


_POINTS, _WIDER = 10, 6  # on the circle, and R/r
_UNKNOWN = arb("nan")


class LinearEnclosure(NamedTuple):
    """All over a piece a function is at + slope x, -1 <= x <= 1: of ``at`` anything, of the slope
    one number all over it.

    ``rate`` : all values of its derivative in x, where that is known.
    """

    at: Ball
    slope: Ball
    rate: Ball = _UNKNOWN

    @property
    def ball(self) -> Ball:
        """All of its values."""
        return self.at + self.slope * _EITHER


def over_circle(
    functions: Callable[[acb], Sequence[acb]], middle: Ball, radius: Ball
) -> list[LinearEnclosure]:
    """The values for real q, |q - middle| <= radius, of functions that are real there and analytic
    up to six times as far.

    Balls that are not finite where they are not.

    >>> [square] = over_circle(lambda q: [q * q - q], arb(1), arb("0.25"))  # from 3/4 - 3/16 to 5/4 + 5/16 by balls
    >>> round(float(square.ball.lower()), 4), round(float(square.ball.upper()), 4)
    (-0.25, 0.3125)
    """
    wide = radius * _WIDER
    around = functions(acb(arb(middle, wide), arb(0, wide)))
    half = [
        functions(middle + radius * w) for w in _turns(_POINTS, flint.ctx.prec)[: _POINTS // 2 + 1]
    ]
    rows = _interpolation(_POINTS, flint.ctx.prec) * acb_mat(half)
    return [
        _line(acb(own), [rows[k, j].real for k in range(_POINTS)]) for j, own in enumerate(around)
    ]


def _line(around: acb, row: Sequence[Ball]) -> LinearEnclosure:
    """By the coefficients of the polynomial, and what the function is all around it."""
    off = 2 * around.rad().upper() * (arb(1) / _WIDER) ** _POINTS * _WIDER / (_WIDER - 1)
    bent = sum((x * (_EITHER if k % 2 else arb(0.5, 0.5)) for k, x in enumerate(row[2:])), row[0])
    rate = sum((k * x * (_EITHER if k > 1 else 1) for k, x in enumerate(row[1:], 1)), arb(0))
    # of f = sum a_m x^m, |a_m| <= M/R^m, m < n has a_m + a_(m + n) + ...: off by 2 sum_(m >= n) m
    # M/R^m < (n + 1) off
    return LinearEnclosure(bent + off * _EITHER, row[1], rate + (_POINTS + 1) * off * _EITHER)


@lru_cache(maxsize=8)
def _turns(n: int, bits: int) -> list[acb]:
    """The n-th roots of 1, all around the circle."""
    with flint.ctx.workprec(bits):
        return [(acb(0, 2 * k) / n * arb.pi()).exp() for k in range(n)]


@lru_cache(maxsize=8)
def _interpolation(n: int, bits: int) -> acb_mat:
    """From values on half of the circle, those on the other half being conjugate, to coefficients,
    their real parts."""
    turns, half = _turns(n, bits), n // 2
    with flint.ctx.workprec(bits):
        weights = [(1 if j in (0, half) else 2) / arb(n) for j in range(half + 1)]
        return acb_mat([[x * turns[-j * k % n] for j, x in enumerate(weights)] for k in range(n)])
