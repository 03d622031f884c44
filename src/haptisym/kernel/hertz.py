"""Frequencies in Hz."""

from __future__ import annotations

from dataclasses import dataclass

import flint

from haptisym.kernel.reals import Ball, RealNumber


@dataclass(frozen=True, slots=True, repr=False)
class Hertz(RealNumber):
    """A frequency in Hz, as certain as the one in rad/s.

    >>> from sympy import pi
    >>> from haptisym.kernel.reals import ExactNumber
    >>> Hertz(ExactNumber(3 * pi)).digits(3)
    '1.50'
    """

    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.omega.ball(bits) / (2 * flint.arb.pi())
