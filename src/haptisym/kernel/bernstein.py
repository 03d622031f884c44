"""Polynomials with balls for coefficients in Bernstein's basis, and functions on stretches of omega as such.

The range of a polynomial with balls for coefficients, between its least and its greatest Bernstein coefficient.

A function on a stretch of omega as a polynomial in Bernstein's basis, with balls for coefficients.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import accumulate, pairwise, repeat
from math import comb
from operator import add, mul
from typing import TypeAlias

import flint
from flint import arb, arb_mat, fmpq

from haptisym.kernel.reals import Ball


def range_of(row: Sequence[Ball], reach: Sequence[Ball]) -> Ball:
    """A ball around the values of c_0 + c_1 h + ... for all h from -r to r, given the powers 1, r, r^2, ... of r.

    >>> balls = [arb(c) for c in (3, 0, 1)]
    >>> range_of(balls, [arb(1), arb(2), arb(4)])     # 3 + h^2 for -2 <= h <= 2: by Bernstein not below -1
    [+/- 7.01]
    """
    return reduce(arb.union, _converted([c * power for c, power in zip(row, reach, strict=False)]).entries())


def coefficients(row: Sequence[Ball], reach: Ball) -> arb_mat:
    """The Bernstein coefficients of c_0 + c_1 h + ... between h = -r and h = r, in a column.

    >>> coefficients([arb(3), arb(0), arb(1)], arb(2)).entries()
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
        return arb_mat([[arb(_weight(degree, j, k)) for k in range(degree + 1)] for j in range(degree + 1)])


def _weight(degree: int, j: int, k: int) -> fmpq:
    """The part of u^k = (t - (1 - t))^k (t + (1 - t))^(degree - k), t = (1 + u)/2, in the j-th Bernstein polynomial."""
    ways = sum((-1) ** (k - i) * comb(k, i) * comb(degree - k, j - i) for i in range(min(j, k) + 1))
    return fmpq(ways, comb(degree, j))


Series: TypeAlias = Callable[[Ball, int, int], Sequence[Ball]]
"""Balls around the Taylor coefficients of a function, of orders from one to before another, about every point of a ball."""

_ORDER = 8  # of the polynomial
_CUT = fmpq(127, 256)  # of a piece, where it is cut: a little off the middle, where zeros like to be


@dataclass(frozen=True, eq=False, slots=True)
class Stretch:
    """A function between ``low`` and ``high``: at each x in there it, and its slopes, are those of one of the polynomials.

    Taylor's theorem: the last coefficient is one of those over the whole piece; which one may change with x. ``column``: the
    coefficients between the exact numbers ``ends``, which enclose low and high; ``row``: the same in a list.
    """

    low: Ball
    high: Ball
    ends: tuple[Ball, Ball]
    column: arb_mat
    row: Sequence[Ball]

    @classmethod
    def of(cls, series: Series, low: Ball, high: Ball) -> Stretch:
        """A function with those Taylor coefficients between two exact numbers, at the current working precision."""
        with flint.ctx.workprec(flint.ctx.prec - 60):  # so that the ends of its parts are exact numbers too
            middle = ((low + high) / 2).mid()
        with flint.ctx.workprec(30):
            reach = (high - middle).max(middle - low).upper()
        ends = middle - reach, middle + reach
        row = [*series(middle, 0, _ORDER), *series(ends[0].union(ends[1]), _ORDER, _ORDER + 1)]
        return cls._with(low, high, ends, coefficients(row, reach))

    @classmethod
    def _with(cls, low: Ball, high: Ball, ends: tuple[Ball, Ball], column: arb_mat) -> Stretch:
        return cls(low, high, ends, column, column.entries())

    def sign(self, order: int = 0) -> int:
        """The sign all over the piece, or that of the slope or the curvature; 0 where it does not show."""
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
        """That at one of the ends, 0 for the low one and -1 for the high one; 0 where it does not show."""
        row = self._differences(order)
        found, beyond = row[end], self.ends[end] - (self.low, self.high)[end]
        if not beyond.is_zero() and len(row) > 1:  # by the mean value theorem
            steepest = reduce(arb.max, (abs(b - a).upper() for a, b in pairwise(row))) * (len(row) - 1)
            found = found + steepest * beyond / (self.ends[1] - self.ends[0]) * _EITHER
        return int(found > 0) - int(found < 0)

    def nearer(self) -> tuple[Ball, Ball]:
        """Two exact numbers around the one zero of a monotone piece, near it where the balls are small; neither is a zero.

        The zero is m - f(m)/f'(xi) for every m between the ends, by the mean value theorem; floats find an m near it.
        """
        first, last = self.ends
        slopes = (x.abs_lower() for x in self._differences(1))  # no ball around all of them: it may hold 0
        least = reduce(arb.min, slopes) * (len(self.row) - 1) / (last - first)
        t = _crossed([float(x.mid()) for x in self.row])
        with flint.ctx.workprec(60):
            place = (first + (last - first) * t).mid()
        share = (place - first) / (last - first)
        weights = map(mul, _powers(share), reversed(_powers(1 - share)))
        value = reduce(add, (x * w * n for x, w, n in zip(self.row, weights, _CHOICES, strict=True)))
        reach = abs(value / least).upper() * 2 + (last - first) * _LEAST
        with flint.ctx.workprec(60):
            low, high = (place - reach).lower(), (place + reach).upper()
        if not (low.is_finite() and high.is_finite()):
            return self.low, self.high  # beyond floats
        return self.low.max(low), self.high.min(high)

    @property
    def is_sharp(self) -> bool:
        """Whether its parts may tell more: whether the balls are small beside what the function does."""
        middles = [x.mid() for x in self.row]
        return bool(max(x.rad() for x in self.row) * _BLUR < max(middles) - min(middles))

    def cut(self) -> tuple[Stretch, Stretch] | None:
        """Its two parts, the function not zero where they meet; None where that does not show."""
        low, high = self.ends
        place = low + (high - low) * arb(_CUT)
        left, right = _cuts(_ORDER)
        first = left * self.column
        end = first[_ORDER, 0]
        if not (end > 0 or end < 0) or not place.is_exact() or not self.low < place < self.high:
            return None
        below = Stretch._with(self.low, place, (low, place), first)
        return below, Stretch._with(place, self.high, (place, high), right * self.column)


def _crossed(row: list[float]) -> float:
    """About where between 0 and 1 a monotone polynomial with those Bernstein coefficients is 0: by false position."""
    a, b = (0.0, row[0]), (1.0, row[-1])
    t = 0.5
    for _ in range(_STEPS):
        t = (a[0] * b[1] - b[0] * a[1]) / (b[1] - a[1]) if b[1] != a[1] else 0.5
        values = row
        while len(values) > 1:
            values = [x + t * (y - x) for x, y in pairwise(values)]
        if values[0] * a[1] > 0:
            a, b = (t, values[0]), (b[0], b[1] / 2)  # the Illinois way
        else:
            a, b = (a[0], a[1] / 2), (t, values[0])
    return min(max(t, 1 / 1024), 1 - 1 / 1024)


def _powers(x: Ball) -> list[Ball]:
    return list(accumulate(repeat(x, _ORDER), mul, initial=arb(1)))


_STEPS, _LEAST = 6, arb(2) ** -40
_CHOICES = [comb(_ORDER, n) for n in range(_ORDER + 1)]
_BLUR = 8
_EITHER = arb(0, 1)


@lru_cache(maxsize=8)
def _cuts(degree: int) -> tuple[arb_mat, arb_mat]:
    """From the coefficients on a piece to those on what is below and above its cut: de Casteljau's corners, exact."""
    with flint.ctx.workprec(8 * degree + 64):
        left = [
            [_weight_in_stretches(j, i) if i <= j else arb(0) for i in range(degree + 1)] for j in range(degree + 1)
        ]
        right = [
            [_weight_in_stretches(degree - j, i - j) if i >= j else arb(0) for i in range(degree + 1)]
            for j in range(degree + 1)
        ]
        return arb_mat(left), arb_mat(right)


def _weight_in_stretches(degree: int, i: int) -> Ball:
    """The Bernstein polynomial at the cut, a dyadic number."""
    return arb(comb(degree, i) * _CUT**i * (1 - _CUT) ** (degree - i))
