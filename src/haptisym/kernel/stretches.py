"""A function on a stretch of omega as a polynomial in Bernstein's basis, with balls for coefficients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import pairwise
from math import comb
from typing import TypeAlias

import flint
from flint import arb, arb_mat, fmpq

from haptisym.kernel.bernstein import coefficients
from haptisym.kernel.reals import Ball

Series: TypeAlias = Callable[[Ball, int, int], Sequence[Ball]]
"""Balls around the Taylor coefficients of a function, of orders from one to before another, about every point of a ball."""

_ORDER = 8  # of the polynomial
_CUT = fmpq(127, 256)  # of a piece, where it is cut: a little off the middle, where zeros like to be


@dataclass(frozen=True, eq=False, slots=True)
class Stretch:
    """A function between ``low`` and ``high``: at each x in there it, and its slopes, are those of one of the polynomials.

    Taylor's theorem: the last coefficient is one of those over the whole piece; which one may change with x. ``column``: the
    coefficients between the exact numbers ``ends``, which enclose low and high.
    """

    low: Ball
    high: Ball
    ends: tuple[Ball, Ball]
    column: arb_mat

    @classmethod
    def of(cls, series: Series, low: Ball, high: Ball) -> Stretch:
        """A function with those Taylor coefficients between two exact numbers, at the current working precision."""
        with flint.ctx.workprec(flint.ctx.prec - 60):  # so that the ends of its parts are exact numbers too
            middle = ((low + high) / 2).mid()
        with flint.ctx.workprec(30):
            reach = (high - middle).max(middle - low).upper()
        ends = middle - reach, middle + reach
        row = [*series(middle, 0, _ORDER), *series(ends[0].union(ends[1]), _ORDER, _ORDER + 1)]
        return cls(low, high, ends, coefficients(row, reach))

    def sign(self, order: int = 0) -> int:
        """The sign all over the piece, or that of the slope or the curvature; 0 where it does not show."""
        row = self.column.entries()
        for _ in range(order):
            row = [b - a for a, b in pairwise(row)]
        if row[0] > 0:
            return int(all(x > 0 for x in row))
        return -int(all(x < 0 for x in row))

    def sign_at(self, end: int, order: int = 0) -> int:
        """That at one of the ends, 0 for the low one and -1 for the high one; 0 where it does not show."""
        row = self.column.entries()
        for _ in range(order):
            row = [b - a for a, b in pairwise(row)]
        found, beyond = row[end], abs(self.ends[end] - (self.low, self.high)[end])
        if not beyond.is_zero() and len(row) > 1:  # by the mean value theorem
            steepest = reduce(arb.max, (abs(b - a).upper() for a, b in pairwise(row))) * (len(row) - 1)
            found = found + steepest * beyond / (self.ends[1] - self.ends[0]) * _EITHER
        return int(found > 0) - int(found < 0)

    @property
    def is_sharp(self) -> bool:
        """Whether its parts may tell more: whether the balls are small beside what the function does."""
        row = self.column.entries()
        middles = [x.mid() for x in row]
        return bool(max(x.rad() for x in row) * _BLUR < max(middles) - min(middles))

    def cut(self) -> tuple[Stretch, Stretch] | None:
        """Its two parts, the function not zero where they meet; None where that does not show."""
        low, high = self.ends
        place = low + (high - low) * arb(_CUT)
        left, right = _cuts(_ORDER)
        first = left * self.column
        end = first[_ORDER, 0]
        if not (end > 0 or end < 0) or not place.is_exact() or not self.low < place < self.high:
            return None
        return Stretch(self.low, place, (low, place), first), Stretch(
            place, self.high, (place, high), right * self.column
        )


_BLUR = 8
_EITHER = arb(0, 1)


@lru_cache(maxsize=8)
def _cuts(degree: int) -> tuple[arb_mat, arb_mat]:
    """From the coefficients on a piece to those on what is below and above its cut: de Casteljau's corners, exact."""
    with flint.ctx.workprec(8 * degree + 64):
        left = [[_weight(j, i) if i <= j else arb(0) for i in range(degree + 1)] for j in range(degree + 1)]
        right = [
            [_weight(degree - j, i - j) if i >= j else arb(0) for i in range(degree + 1)] for j in range(degree + 1)
        ]
        return arb_mat(left), arb_mat(right)


def _weight(degree: int, i: int) -> Ball:
    """The Bernstein polynomial at the cut, a dyadic number."""
    return arb(comb(degree, i) * _CUT**i * (1 - _CUT) ** (degree - i))
