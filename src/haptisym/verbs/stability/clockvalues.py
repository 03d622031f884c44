"""Values at which a root of a loop with a clock reaches the unit circle, and how fast it goes round there: to any digits."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

import flint
from flint import arb

from haptisym.kernel.reals import Ball, RealNumber


class Loop(Protocol):
    """A loop with a clock, in which one number is open."""

    def tests(self, value: Ball) -> tuple[Ball, ...]:
        """Three functions of the number, of which one vanishes where a root is on the unit circle."""
        ...

    def angle(self, value: Ball, bits: int) -> Ball:
        """At which angle a pair is there."""
        ...

    def period(self, value: Ball) -> Ball:
        """Of the clock, s."""
        ...


@dataclass(frozen=True, repr=False)
class CriticalValue(RealNumber):
    """The zero of one of the three tests between two values at which its signs differ."""

    loop: Loop
    test: int
    low: Fraction
    high: Fraction

    def ball(self, bits: int) -> Ball:
        return _bisected(self, bits)

    def value(self, x: Ball) -> Ball:
        """The test at a point."""
        return self.loop.tests(x)[self.test]


@lru_cache(maxsize=256)
def _bisected(zero: CriticalValue, bits: int) -> Ball:
    """A ball around it of about that relative accuracy: by regula falsi, until signs on both sides of a point confirm it."""
    with flint.ctx.workprec(2 * bits + 64):
        low, high = _exactly(zero.low), _exactly(zero.high)
        f, g = (zero.value(x).mid() for x in (low, high))
        width = abs(high) * arb(2) ** -bits
        while (high - low) > 2 * width:
            x = ((low * g - high * f) / (g - f)).mid()
            for place in ((x - width).mid(), (x + width).mid()):
                if not low < place < high:
                    continue
                y = zero.value(place)
                if y.contains(0):
                    return low.union(high)
                if (y > 0) == (f > 0):
                    low, f = place, y.mid()
                else:
                    high, g = place, y.mid()
            middle = ((low + high) / 2).mid()
            y = zero.value(middle)
            if y.contains(0):
                return low.union(high)
            if (y > 0) == (f > 0):
                low, f = middle, y.mid()
            else:
                high, g = middle, y.mid()
        return low.union(high)


@dataclass(frozen=True, repr=False)
class Swing(RealNumber):
    """The frequency at which roots reach the unit circle, rad/s."""

    value: CriticalValue

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(4 * bits + 128):
            q = self.value.ball(2 * bits + 64)
            if self.value.test == 0:
                return arb(0)
            theta = arb.pi() if self.value.test == 1 else self.value.loop.angle(q, bits)
            return theta / self.value.loop.period(q)


@dataclass(frozen=True, repr=False)
class Inverse(RealNumber):
    """1/x, or -1/x, of a number x > 0.

    >>> from sympy import Integer
    >>> from haptisym.kernel.reals import ExactNumber
    >>> Inverse(ExactNumber(Integer(3)), -1).digits(5)
    '-0.33333'
    """

    number: RealNumber
    sign: int

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 16):
            return self.sign / self.number.ball(bits + 8)


@dataclass(frozen=True)
class Passage:
    """A ``value`` at which the number of roots with |z| >= 1 changes, from ``below`` to ``above``; ``omega`` : theirs, rad/s."""

    value: RealNumber
    omega: RealNumber
    below: int
    above: int

    def inverse(self, side: int) -> Passage:
        """Of 1/value, or (side -1) of -1/value."""
        ends = (self.above, self.below) if side > 0 else (self.below, self.above)
        return Passage(Inverse(self.value, side), self.omega, *ends)


def _exactly(x: Fraction) -> Ball:
    return arb(x.numerator) / arb(x.denominator)
