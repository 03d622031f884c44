"""Real numbers compared and ordered, told apart by enclosures as tight as it takes.

Real numbers compared as far as bits tell them apart: those that are alike so far count as one.

Real numbers in ascending order, told apart by enclosures as tight as it takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cmp_to_key
from itertools import pairwise
from typing import TypeVar

import flint

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.polynomials import PolynomialFactor
from haptisym.kernel.reals import MOST_BITS, SURE_BITS, Ball, RealNumber, at_rising_precision
from haptisym.kernel.zeros import Undecided, Zero

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


def in_order(numbers: Sequence[RealNumber]) -> list[RealNumber]:
    """Different numbers in ascending order, told apart by enclosures as tight as it takes."""
    tick()
    balls, tight = [x.rough() for x in numbers], set[int]()
    while True:
        order = sorted(range(len(numbers)), key=lambda i: balls[i].mid())
        close = {i for a, b in pairwise(order) if not balls[a] < balls[b] for i in (a, b)} - tight
        if not close:
            break
        tight |= close
        for i in close:
            balls[i] = numbers[i].ball(64)
    if all(balls[a] < balls[b] for a, b in pairwise(order)):
        return [numbers[i] for i in order]
    return _told_apart(numbers)


def _told_apart(numbers: Sequence[RealNumber]) -> list[RealNumber]:
    """The same of numbers that are nearly alike."""
    close: list[Ball] = []

    def told_apart(bits: int) -> list[RealNumber] | None:
        enclosed = sorted(((x.ball(bits), x) for x in numbers), key=lambda pair: pair[0].mid())
        close[:] = [a for (a, _), (b, _) in pairwise(enclosed) if not a < b]
        return None if close else [number for _, number in enclosed]

    most = MOST_BITS if any(isinstance(x, Undecided) or _may_coincide(x) for x in numbers) else SURE_BITS
    found = at_rising_precision(told_apart, 128, most)
    if found is None:
        raise UndecidedError(f"whether two frequencies near {float(close[0].mid()):.17g} rad/s are the same")
    return found


def _may_coincide(x: RealNumber) -> bool:
    """Whether it is a zero of a function that is no polynomial: zeros of different irreducible polynomials differ."""
    return isinstance(x, Zero) and not isinstance(x.factor, PolynomialFactor)
