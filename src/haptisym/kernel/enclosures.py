"""Narrow enclosures of a function over an interval, in balls: by Bernstein coefficients of a
polynomial, or by interpolation.

Evaluated in ball arithmetic, a formula widens with each number that occurs twice in it (the
dependency problem). Two forms stay as narrow as the function is smooth. Both are proven enclosures
at any working precision, and not finite where the function cannot be bounded.

*Bernstein.* A polynomial of degree n on [-r, r] lies between its least and its greatest coefficient
in the basis of Bernstein's polynomials. A ``FunctionPiece`` is a function between two frequencies
as such a polynomial: by Taylor's theorem its last coefficient is one over the whole piece.

*Ellipses.* A function of x that is analytic in the ellipse with foci -1 and 1 and the sum rho of
semi-axes, and there differs by at most M from some number, is a sum of a_k T_k with Chebyshev's
polynomials T_k and |a_k| <= 2 M/rho^k for k > 0 (Bernstein; Trefethen, Approximation Theory and
Approximation Practice, theorem 8.1). At the N zeros of T_N each T_k with k >= N has the values of
+-T_j, j < N, or is 0. So the polynomial of degree < N with the values of the function there is off
by at most 2 |a_N| + 2 |a_N+1| + ... <= 4 M rho^-N rho/(rho - 1) on [-1, 1], as |T_k| <= 1, and its
slope by at most the same sum with k^2 |a_k|, as |T_k'| <= k^2. So M may be found in one wide ball,
in which everything is multiplied: the power of rho makes it small.

A *ball* is an interval of any precision, middle and radius (``arb`` of FLINT; complex: ``acb``).
Begin with ``FunctionPiece`` for the first form and with ``over_ellipse`` for the second.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import pairwise
from math import comb
from typing import NamedTuple, TypeAlias

import flint
from flint import acb, arb, arb_mat, fmpq

from haptisym.kernel.reals import Ball


def range_of(row: Sequence[Ball], reach: Sequence[Ball]) -> Ball:
    """A ball around the values of c_0 + c_1 h + ... for all h from -r to r, given the powers 1, r,
    r^2, ... of r.

    >>> balls = [arb(c) for c in (3, 0, 1)]
    >>> range_of(balls, [arb(1), arb(2), arb(4)])     # 3 + h^2 for -2 <= h <= 2: by Bernstein not below -1
    [+/- 7.01]
    """
    scaled = [c * power for c, power in zip(row, reach, strict=False)]
    # Bernstein polynomials are >= 0 and add up to 1: the values are means of the coefficients.
    return reduce(arb.union, _converted(scaled).entries())


def bernstein_coefficients(row: Sequence[Ball], reach: Ball) -> arb_mat:
    """The Bernstein coefficients of c_0 + c_1 h + ... between h = -r and h = r, in a column.

    >>> bernstein_coefficients([arb(3), arb(0), arb(1)], arb(2)).entries()
    [7.00000000000000, -1.00000000000000, 7.00000000000000]
    """
    scaled = [row[0]]
    power = arb(1)
    for c in row[1:]:
        power = power * reach
        scaled.append(c * power)
    return _converted(scaled)


def _converted(row: Sequence[Ball]) -> arb_mat:
    """The Bernstein coefficients on [-1, 1] of a polynomial with these coefficients, ascending."""
    degree = len(row) - 1
    return _conversion(degree, flint.ctx.prec) * arb_mat(degree + 1, 1, row)


@lru_cache(maxsize=64)
def _conversion(degree: int, bits: int) -> arb_mat:
    """From the coefficients of 1, u, u^2, ... to those of the Bernstein polynomials on [-1, 1]."""
    size = degree + 1
    with flint.ctx.workprec(bits):
        rows = [[arb(_weight(degree, j, k)) for k in range(size)] for j in range(size)]
        return arb_mat(rows)


def _weight(degree: int, j: int, k: int) -> fmpq:
    """The part of u^k = (t - (1 - t))^k (t + (1 - t))^(degree - k), t = (1 + u)/2, in the j-th
    Bernstein polynomial."""
    ways = 0
    # i factors t come of the first power, j - i of the second.
    for i in range(min(j, k) + 1):
        sign = (-1) ** (k - i)
        ways += sign * comb(k, i) * comb(degree - k, j - i)
    return fmpq(ways, comb(degree, j))


Series: TypeAlias = Callable[[Ball, int, int], Sequence[Ball]]
"""series(x, start, stop) gives balls around the Taylor coefficients of a function about every point
of the ball x, of orders start to stop - 1."""

# Degree of a piece's polynomial: its remainder falls as the eighth power of the length of the
# piece.
_ORDER = 8


@dataclass(frozen=True, eq=False, slots=True)
class FunctionPiece:
    """A function between ``low`` and ``high``, enclosed in a family of polynomials.

    By Taylor's theorem value and slopes at each x are those of a polynomial whose last coefficient
    is the function's Taylor coefficient at some place in the piece, which depends on x; its ball
    covers all of them. ``row``: the Bernstein coefficients of the family between the exact numbers
    ``ends``, which enclose low and high.
    """

    low: Ball
    high: Ball
    ends: tuple[Ball, Ball]
    row: Sequence[Ball]

    @classmethod
    def of(cls, series: Series, low: Ball, high: Ball) -> FunctionPiece:
        """A function with those Taylor coefficients between two exact numbers, at the current
        working precision."""
        # Middle and reach have so few bits that their sum and difference are exact at the working
        # precision: the ends are numbers without radius, and pieces leave no gap between them.
        with flint.ctx.workprec(flint.ctx.prec - 60):
            middle = ((low + high) / 2).mid()
        with flint.ctx.workprec(30):
            reach = (high - middle).max(middle - low).upper()
        start, end = middle - reach, middle + reach
        at_middle = series(middle, 0, _ORDER)
        over_piece = series(start.union(end), _ORDER, _ORDER + 1)
        row = bernstein_coefficients([*at_middle, *over_piece], reach)
        return cls(low, high, (start, end), row.entries())

    def sign(self, order: int = 0) -> int:
        """The sign all over the piece of the function (order 0), its slope (1) or curvature (2): 1,
        -1, or 0 where the enclosure does not show one."""
        row = self._differences(order)
        if all(x > 0 for x in row):
            return 1
        if all(x < 0 for x in row):
            return -1
        return 0

    def _differences(self, order: int) -> Sequence[Ball]:
        """The Bernstein coefficients of a derivative, up to a factor > 0: repeated differences."""
        row = self.row
        for _ in range(order):
            row = [b - a for a, b in pairwise(row)]
        return row

    def sign_at(self, end: int, order: int = 0) -> int:
        """The sign of the function or of a derivative at ``low`` (end 0) or ``high`` (end -1); 0
        where it does not show."""
        row = self._differences(order)
        # The first and the last Bernstein coefficient are values at ``ends``. From there to low or
        # high, a little further in, the value changes by at most the steepest slope times the way
        # (mean value theorem); the slope is the degree times a difference over the length.
        value = row[end]
        inner = (self.low, self.high)[end]
        beyond = self.ends[end] - inner
        degree = len(row) - 1
        if not beyond.is_zero() and degree:
            differences = [abs(b - a).upper() for a, b in pairwise(row)]
            steepest = reduce(arb.max, differences) * degree
            start, stop = self.ends
            value = value + steepest * beyond / (stop - start) * _EITHER
        return int(value > 0) - int(value < 0)


# The range -1 <= x <= 1: times a bound, all numbers that are no larger.
_EITHER = arb(0, 1)
_UNKNOWN = arb("nan")

# Points, and the larger semi-axis of the ellipse, which lies in a disc of that radius: what the
# polynomial is off by is about 4 rho^-8 < 1e-8 of the width of the wide ball.
_POINTS = 8
_WIDER = 6
_RHO = arb("11.91")
"""Less than the sum 6 + sqrt(35) of the semi-axes."""


class LinearEnclosure(NamedTuple):
    """A function over -1 <= x <= 1, enclosed by a line: f(x) = a + slope x, with a anywhere in the
    ball ``at``, which may differ from x to x, and with one slope for all x.

    ``rate`` : a ball around all values of df/dx; not a number where that is unknown.
    """

    at: Ball
    slope: Ball
    rate: Ball = _UNKNOWN

    @property
    def ball(self) -> Ball:
        """A ball around all values of the function."""
        return self.at + self.slope * _EITHER


def over_ellipse(
    functions: Callable[[Ball], Sequence[Ball]], middle: Ball, radius: Ball
) -> list[LinearEnclosure]:
    """Enclose functions over real q, |q - middle| <= radius, by lines in x = (q - middle)/radius.

    The functions must be real for real q. Where one is not analytic within six times the radius, no
    enclosure is finite.

    >>> [square] = over_ellipse(lambda q: [q * q - q], arb(1), arb("0.25"))  # from 3/4 - 3/16 to 5/4 + 5/16 by balls
    >>> round(float(square.ball.lower()), 4), round(float(square.ball.upper()), 4)
    (-0.25, 0.3125)
    """
    wide = radius * _WIDER
    around = functions(acb(arb(middle, wide), arb(0, wide)))
    sizes = [acb(x).rad().upper() for x in around]
    if not all(x.is_finite() for x in sizes):
        return [LinearEnclosure(_UNKNOWN, _UNKNOWN)] * len(sizes)
    bits = flint.ctx.prec
    values = [functions(middle + radius * x) for x in _places(bits)]
    rows = (_interpolation(bits) * arb_mat(values)).transpose().tolist()
    return [_line(size, row) for size, row in zip(sizes, rows, strict=True)]


def _line(size: Ball, row: Sequence[Ball]) -> LinearEnclosure:
    """The enclosure of one function, from a bound of its distance from some number on the ellipse,
    and from the Chebyshev coefficients of its interpolating polynomial."""
    # The bounds of the module's docstring. From k = 8 on a square k^2 is less than 4/3 of the one
    # before it, so that k^2 rho^-k falls at least as the powers of 4/(3 rho) do.
    off = 4 * size * _RHO**-_POINTS
    rest = off * _RHO / (_RHO - 1)
    slopes = off * _POINTS**2 * 3 * _RHO / (3 * _RHO - 4)
    # The line keeps the linear term; all higher ones widen the place where it stands.
    for k, c in enumerate(row[2:], 2):
        rest = rest + abs(c)
        slopes = slopes + k * k * abs(c)
    return LinearEnclosure(row[0] + rest * _EITHER, row[1], row[1] + slopes * _EITHER)


@lru_cache(maxsize=8)
def _places(bits: int) -> list[Ball]:
    """Chebyshev's points, the zeros of T_n, in descending order."""
    with flint.ctx.workprec(bits):
        return [(arb.pi() * (2 * i + 1) / (2 * _POINTS)).cos() for i in range(_POINTS)]


@lru_cache(maxsize=8)
def _interpolation(bits: int) -> arb_mat:
    """The matrix from values at Chebyshev's points to the coefficients of T_0, T_1, ... in the
    interpolating polynomial."""
    with flint.ctx.workprec(bits):
        rows = []
        for k in range(_POINTS):
            weight = arb(2 if k else 1) / _POINTS
            angles = [arb.pi() * (k * (2 * i + 1)) / (2 * _POINTS) for i in range(_POINTS)]
            rows.append([weight * angle.cos() for angle in angles])
        return arb_mat(rows)
