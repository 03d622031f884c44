"""Narrow enclosures of a function over an interval, in balls: by Bernstein coefficients of a
polynomial, or by interpolation on a circle.

Evaluated in ball arithmetic, a formula widens with each number that occurs twice in it (the
dependency problem). Two forms stay as narrow as the function is smooth. Both are proven enclosures
at any working precision, and not finite where the function cannot be bounded.

*Bernstein.* A polynomial of degree n on [-r, r] lies between its least and its greatest coefficient
in the basis of Bernstein's polynomials. A ``FunctionPiece`` is a function between two frequencies
as such a polynomial: by Taylor's theorem its last coefficient is one over the whole piece.

*Circles.* A function f that is analytic for |q - m| <= R, and there differs by at most M from some
number, has Taylor coefficients of at most M/R^k (Cauchy). The polynomial of degree < N that has its
values at N points all around |q - m| = r is off by at most 2 M (r/R)^N/(1 - r/R) for |q - m| <= r,
as t^k and t^(k mod N) have the same values there. So M may be found in one wide ball, in which
everything is multiplied: the power of r/R makes it small.

A *ball* is an interval of any precision, middle and radius (``arb`` of FLINT; complex: ``acb``).
Begin with ``FunctionPiece`` for the first form and with ``over_circle`` for the second.
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


# The ranges over -1 <= x <= 1 of odd and of even powers of x.
_EITHER = arb(0, 1)
_EVEN = arb(0.5, 0.5)

# Points on the circle, and R/r: what the polynomial is off by is (1/6)^10 < 2e-8 of the width of
# the wide ball, for six evaluations, as half of the points are conjugate to the others.
_POINTS = 10
_WIDER = 6
_UNKNOWN = arb("nan")


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


def over_circle(
    functions: Callable[[acb], Sequence[acb]], middle: Ball, radius: Ball
) -> list[LinearEnclosure]:
    """Enclose functions over real q, |q - middle| <= radius, by lines in x = (q - middle)/radius.

    The functions must be real for real q. Where one is not analytic within six times the radius,
    its balls over the wide disc, and so the enclosure, are not finite.

    >>> [square] = over_circle(lambda q: [q * q - q], arb(1), arb("0.25"))  # from 3/4 - 3/16 to 5/4 + 5/16 by balls
    >>> round(float(square.ball.lower()), 4), round(float(square.ball.upper()), 4)
    (-0.25, 0.3125)
    """
    wide = radius * _WIDER
    around = functions(acb(arb(middle, wide), arb(0, wide)))
    bits = flint.ctx.prec
    upper_half = _turns(_POINTS, bits)[: _POINTS // 2 + 1]
    values = [functions(middle + radius * w) for w in upper_half]
    coefficients = _interpolation(_POINTS, bits) * acb_mat(values)
    enclosures = []
    for j, wide_ball in enumerate(around):
        row = [coefficients[k, j].real for k in range(_POINTS)]
        enclosures.append(_line(acb(wide_ball), row))
    return enclosures


def _line(around: acb, row: Sequence[Ball]) -> LinearEnclosure:
    """The enclosure of one function, from the coefficients in x of its interpolating polynomial and
    from a ball around all of its values in the wide disc."""
    # The bound of the module's docstring: 2 M (r/R)^n/(1 - r/R), with M the radius of the wide
    # ball.
    wide = 2 * around.rad().upper()
    share = arb(1) / _WIDER
    off = wide * share**_POINTS * _WIDER / (_WIDER - 1)
    # The line keeps the linear term; all higher ones widen the place where it stands.
    at = row[0]
    for k, c in enumerate(row[2:]):
        at = at + c * (_EITHER if k % 2 else _EVEN)
    rate = arb(0)
    for k, c in enumerate(row[1:], 1):
        rate = rate + k * c * (_EITHER if k > 1 else 1)
    # Of f = sum a_m x^m the polynomial has a_m + a_(m + n) + ... in place of a_m, m < n, and by
    # Cauchy |a_m| <= M/R^m in units of r: slopes are off by 2 sum_(m >= n) m M/R^m < (n + 1) off.
    rate = rate + (_POINTS + 1) * off * _EITHER
    return LinearEnclosure(at + off * _EITHER, row[1], rate)


@lru_cache(maxsize=8)
def _turns(n: int, bits: int) -> list[acb]:
    """The n-th roots of 1, all around the circle."""
    with flint.ctx.workprec(bits):
        angles = [acb(0, 2 * k) / n * arb.pi() for k in range(n)]
        return [angle.exp() for angle in angles]


@lru_cache(maxsize=8)
def _interpolation(n: int, bits: int) -> acb_mat:
    """The matrix from values on the upper half of the circle to coefficients of the interpolating
    polynomial, which are the real parts of the product.

    The values on the lower half are conjugate to them, since the function is real for real q.
    """
    turns = _turns(n, bits)
    half = n // 2
    # A discrete Fourier transform; the points at 1 and -1 are their own conjugates and count once.
    with flint.ctx.workprec(bits):
        weights = [(1 if j in (0, half) else 2) / arb(n) for j in range(half + 1)]
        numbered = list(enumerate(weights))
        return acb_mat([[x * turns[-j * k % n] for j, x in numbered] for k in range(n)])
