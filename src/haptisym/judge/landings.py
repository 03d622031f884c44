"""Where the bandwidth lands behind a peak that it jumps over, and which of two numbers is the larger."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import flint
from flint import arb
from sympy import Expr, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, RealNumber

_SURE = 400
"""Bits up to which two numbers are told apart before they are taken for one."""


@dataclass(frozen=True, repr=False)
class Landing(RealNumber):
    """The bandwidth for the height of a peak, or of the band's low end: enclosed by those for rational heights beside it."""

    height: RealNumber

    @abstractmethod
    def at(self, height: Expr) -> RealNumber | None:
        """The bandwidth for a rational height."""

    @abstractmethod
    def behind(self, height: Rational) -> RealNumber | None:
        """That for one that is hardly too little, if the peak itself did not count."""

    def ball(self, bits: int) -> Ball:
        low, high = (Rational(x.numerator, x.denominator) for x in self.height.bounds(bits))
        upper = self.at(high)
        lower = upper if low == high else self.behind(low)
        with flint.ctx.workprec(bits):
            if lower is None or upper is None:
                return arb("nan")
            return lower.ball(bits).union(upper.ball(bits))


def settled(x: RealNumber) -> RealNumber:
    """A number whose enclosures become narrow; UndecidedError where they do not."""
    if at_rising_precision(lambda bits: x.ball(bits).rel_accuracy_bits() > 50 or None, 64, _SURE) is None:
        raise UndecidedError("whether two peaks of the ratios are equally high")
    return x


def above(a: RealNumber, b: RealNumber, most: int = _SURE) -> bool:
    """Whether a > b; UndecidedError where they are not told apart with ``most`` bits, unless both are known exactly."""

    if a is b or a == b:
        return False

    def sign(bits: int) -> bool | None:
        with flint.ctx.workprec(bits):
            left, right = a.ball(bits), b.ball(bits)
            if left.is_exact() and right.is_exact() and left == right:
                return False
            return True if left > right else False if left < right else None

    found = at_rising_precision(sign, 64, max(most, _SURE))
    if found is None:
        raise UndecidedError("which of two numbers is the larger")
    return found
