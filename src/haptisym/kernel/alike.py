"""Real numbers compared as far as bits tell them apart: those that are alike so far count as one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cmp_to_key
from typing import TypeVar

import flint

from haptisym.kernel.reals import RealNumber

T = TypeVar("T")

ALIKE_BITS = 600
"""With how many."""
_BITS = (128, ALIKE_BITS)  # most numbers are apart at first sight


def ordered(x: RealNumber, y: RealNumber) -> int:
    """1 where y is beyond x, -1 where it is before it, 0 where they are alike as far as bits go."""
    if x is y:
        return 0
    for bits in _BITS:
        with flint.ctx.workprec(bits):
            change = y.ball(bits) - x.ball(bits)
            if not change.contains(0):
                return int(change > 0) - int(change < 0)
    return 0


def is_told(x: RealNumber) -> bool:
    """Whether balls tell about where a number is."""
    return any(x.ball(bits).is_finite() for bits in _BITS)


def ascending(items: Iterable[T], number: Callable[[T], RealNumber]) -> list[T]:
    """Things by their numbers, ascending; those that are alike as they were."""

    def before(x: T, y: T) -> int:
        return -ordered(number(x), number(y))

    return sorted(items, key=cmp_to_key(before))


def each_once(items: Iterable[T], number: Callable[[T], RealNumber]) -> list[T]:
    """The same with the first of those that are alike alone."""
    found = ascending(items, number)
    return [x for i, x in enumerate(found) if not i or ordered(number(found[i - 1]), number(x))]
