"""Real numbers in ascending order, told apart by enclosures as tight as it takes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.polynomials import PolynomialFactor
from haptisym.kernel.precision import MOST_BITS, SURE_BITS, at_rising_precision
from haptisym.kernel.reals import Ball, RealNumber
from haptisym.kernel.zeros import Undecided, Zero


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
