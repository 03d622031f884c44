"""Rule 6: over a slab of values a factor is a sum, with positive weights, of slices, which are functions of omega alone."""

from collections.abc import Iterable
from fractions import Fraction
from functools import lru_cache
from typing import Any

from haptisym_check.delayterms import WaveFactor
from haptisym_check.polynomials import Factor, Point, moved, sliced
from haptisym_check.reading import number
from haptisym_check.values import need


def point(x: Any, infinity: int) -> Point:
    """A value as numerator and denominator; infinity is 1/0 or -1/0."""
    return (infinity, 0) if x is None else number(x).as_integer_ratio()


def is_less(x: Point, y: Point) -> bool:
    """Whether x < y."""
    return x[0] * y[1] < y[0] * x[1]


class Slice(WaveFactor):
    """A factor with waves that has other coefficients."""

    def __init__(self, x: WaveFactor, coefficients: Iterable[int]) -> None:
        self.delays, self.orders, self.waves, numbers = x.delays, x.orders, x.waves, iter(coefficients)
        self.terms = [(turns, [[next(numbers)] for _ in p]) for turns, p in x.terms]
        self.all = self.numbers(self.terms)


def rows_of(x: Factor) -> list[list[int]]:
    """All its coefficients."""
    return [row for _, p in x.terms for row in p]


def cost(x: Factor) -> tuple[int, int]:
    """Of the signs of its slices, as the limits have it: for each bit of a point, and with waves for each point."""
    n, width = len(rows_of(x)), max(map(len, rows_of(x)))
    return (2 * n * width**2, x.cost * width) if isinstance(x, WaveFactor) else (2 * (n * width) ** 2 + 2000, 0)


class Slices:
    """Those of a factor between two values."""

    def __init__(self, x: Factor, low: Point, high: Point) -> None:
        bits = sum(n.bit_length() for n in low + high)
        need(bits * max(map(len, rows_of(x))) < 10**5, "the ends of a slab are too long")
        self.step, self.rows = x.step, sliced(rows_of(x), low, high)
        self.waves = [Slice(x, row) if any(row) else None for row in self.rows] if isinstance(x, WaveFactor) else []

    @lru_cache(maxsize=500)  # noqa: B019 - several functions have the same factors
    def signs(self, a: Fraction, b: Fraction) -> list[set[int]]:
        """Those that each slice may have from a to b; none where it is zero everywhere."""
        if self.waves:
            return [{*(x.signs(a, b)[1] if a < b else [x.sign(a)])} if x else set() for x in self.waves]
        low, high = ((x**self.step).as_integer_ratio() for x in (a, b))
        return [{(x > 0) - (x < 0) for x in moved(row, low, high)} - {0} for row in self.rows]

    def side(self, a: Fraction, b: Fraction, closed: tuple[bool, bool]) -> int:
        """The sign from a to b, for all values between those two; ``closed``: for which of these it must have it as well."""
        every = self.signs(a, b)
        found = set[int]().union(*every)
        need(len(found) == 1, "a sign is not proven")
        need((every[0] or not closed[0]) and (every[-1] or not closed[1]), "a factor may be zero")
        return found.pop()
