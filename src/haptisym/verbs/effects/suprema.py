"""The largest value of a function on an interval, between two proven bounds: by branch and bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Protocol, Self, TypeAlias, TypeVar

from haptisym.kernel.subdivision import Waiting

Bounds: TypeAlias = tuple[float, float]

WIDTH = 2e-7
"""Of the enclosure of a supremum, relative to it."""
_NOTHING = 1e-12  # a supremum below it is known well enough
_MOST_CELLS = 1 << 15


class Divisible(Protocol):
    """A part of the domain that can be halved."""

    def halves(self) -> tuple[Self, Self]:
        """Its two parts, which together are all of it."""


C = TypeVar("C", bound=Divisible)


@dataclass(frozen=True, slots=True)
class Supremum:
    """A proven enclosure of the least upper bound of a function >= 0; both ends are infinite if it is unbounded."""

    least: float
    most: float

    @property
    def is_finite(self) -> bool:
        """Whether an upper bound was found."""
        return self.most < inf


def supremum(whole: C, bounds: Callable[[C], Bounds], limit: float | None = None) -> Supremum:
    """The supremum of a function over ``whole``.

    ``bounds`` : of a cell, a value that the function reaches on it and one that it does not exceed there (both infinite only if
    it is proven to be unbounded). The cell with the highest bound is halved until the enclosure is narrow, or, with a ``limit``,
    until it is proven on which side of it the supremum lies (equal counts as below).

    >>> @dataclass(frozen=True)
    ... class Span:
    ...     low: float
    ...     high: float
    ...     def halves(self):
    ...         middle = (self.low + self.high) / 2
    ...         return Span(self.low, middle), Span(middle, self.high)
    >>> found = supremum(Span(0, 3), lambda x: (max(x.low * (2 - x.low), 0), max(x.high * (2 - x.low), 0)))
    >>> found.least <= 1 <= found.most < 1.00001
    True
    """
    least, most = bounds(whole)
    waiting = Waiting([(most, whole)], lambda x: -x[0], most=_MOST_CELLS)
    for most, cell in waiting:
        if least >= most or _is_enough(least, most, limit):
            break
        halves = [(*bounds(half), half) for half in cell.halves()]
        least = max(least, *(reached for reached, _, _ in halves))
        waiting.add(*((bound, half) for _, bound, half in halves))
    return Supremum(least, max([least, *(most for most, _ in waiting.rest)]))


def _is_enough(least: float, most: float, limit: float | None) -> bool:
    if limit is not None and (most <= limit or least > limit):
        return True
    return most - least <= max(WIDTH * least, _NOTHING)
