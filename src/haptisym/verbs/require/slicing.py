"""Factors over a slab of values: sums, with positive weights, of functions of omega alone, whose signs show theirs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.waves import Rows, WaveFactor

Pair: TypeAlias = tuple[int, int]
Held: TypeAlias = tuple[bool, bool] | None
"""Whether each end of the slab belongs to it, where a factor must not be zero for a value; None where it may."""


def moved(p: Sequence[int], low: Pair, high: Pair) -> list[int]:
    """The coefficients of p((a + b u)/(c + d u)) (c + d u)^n, low = a/c and high = b/d."""

    def stretched(q: Sequence[int], a: int, b: int) -> list[int]:
        return [a * x + b * y for x, y in zip([*q, 0], [0, *q], strict=True)]

    found, power = [p[-1]], [1]
    for c in p[-2::-1]:
        power = stretched(power, low[1], high[1])
        found = [x + c * y for x, y in zip(stretched(found, low[0], high[0]), power, strict=True)]
    return found


@dataclass(frozen=True)
class Slices:
    """The slices of a polynomial in omega^step, the first at the low end of the slab."""

    rows: Sequence[Sequence[int]]
    step: int

    def side(self, a: Fraction, b: Fraction, held: Held) -> int | None:
        """The sign from a to b for all values; None where it is not shown."""
        rows = [moved(q, (a**self.step).as_integer_ratio(), (b**self.step).as_integer_ratio()) for q in self.rows]
        signs = {(x > 0) - (x < 0) for row in rows for x in row} - {0}
        borders = [row for row, own in zip((rows[0], rows[-1]), held or (), strict=False) if own]
        return signs.pop() if len(signs) == 1 and all(map(any, borders)) else None


class WaveSlices:
    """The slices of a factor with waves; None for one that is zero everywhere."""

    def __init__(self, slices: Sequence[WaveFactor | None]) -> None:
        self.slices = slices
        self._known = lru_cache(maxsize=None)(self._found)
        self._asked = [x for x in slices if x]

    def side(self, a: Fraction, b: Fraction, held: Held) -> int | None:
        """The sign from a to b for all values; None where it is not shown."""
        borders = [x for x, own in zip((self.slices[0], self.slices[-1]), held or (), strict=False) if own]
        return self._known(a, b) if all(borders) else None

    def _found(self, a: Fraction, b: Fraction) -> int | None:
        """The sign that all slices have; the one that failed is asked first in the next cell."""
        found = 0
        for i, x in enumerate(self._asked):
            own = {*(x.moved(a, b) or (0,))} if a < b else {x.sign_at(a)}
            if own not in ([{found}] if found else [{1}, {-1}]):
                self._asked.insert(0, self._asked.pop(i))
                return None
            [found] = own
        return found or None


def cost(factor: Factor | WaveFactor) -> tuple[int, int]:
    """Of the signs of its slices, as the limits of the format have it: for each bit of a point, and with waves for each point."""
    count, most = len(_rows(factor)), width(factor)
    if isinstance(factor, Factor):
        return 2 * (count * most) ** 2 + 2000, 0
    return 2 * count * most**2, factor.cost * most


def width(factor: Factor | WaveFactor) -> int:
    """How many slices it has."""
    return max(map(len, _rows(factor)))


def _rows(factor: Factor | WaveFactor) -> Rows:
    return factor.rows if isinstance(factor, Factor) else tuple(row for _, rows in factor.terms for row in rows)


def sliced(factor: Factor | WaveFactor, low: Pair, high: Pair) -> Slices | WaveSlices:
    """A factor between two values; 1/0 and -1/0 where there is no bound."""
    if isinstance(factor, Factor):
        return Slices(_slices(factor.rows, low, high), factor.step)
    every = _slices(_rows(factor), low, high)
    return WaveSlices([_refilled(factor, found) for found in every])


def _slices(rows: Sequence[Sequence[int]], low: Pair, high: Pair) -> list[list[int]]:
    width = max(map(len, rows))
    every = [moved([*row, *[0] * (width - len(row))], low, high) for row in rows]
    return [list(x) for x in zip(*every, strict=True)]


def _refilled(factor: WaveFactor, coefficients: Sequence[int]) -> WaveFactor | None:
    """The factor with these coefficients; None where all are zero."""
    terms, place = list[tuple[tuple[int, ...], Rows]](), 0
    for turns, rows in factor.terms:
        own = coefficients[place : (place := place + len(rows))]
        if any(own):
            terms.append((turns, tuple((n,) for n in own)))
    return WaveFactor(tuple(terms), factor.waves, factor.delays, factor.orders) if terms else None
