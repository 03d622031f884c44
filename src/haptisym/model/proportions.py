"""A threshold at another criterion: at which proportion of right answers it was taken, by a cumulative Gaussian.

A change of size x is told with the probability Phi(x/sigma), so that the change told with probability p is z(p) sigma, z the
inverse of Phi: thresholds at two proportions are to each other as their z. The quotient is transcendental; it is rounded to a
decimal number of DIGITS digits, each proven, so that everything that follows is exact for that number.
"""

from __future__ import annotations

from dataclasses import dataclass

import flint
from flint import arb
from sympy import Expr, Rational

from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.model.quantities import Dimension, Number, decimal, number

DIGITS = 30


@dataclass(frozen=True, repr=False)
class Quotient(RealNumber):
    """z(q)/z(p): the threshold at the proportion q, for one of 1 at p.

    >>> Quotient(Rational(3, 4), Rational(21, 25)).digits(17)
    '1.4743854638571648'
    """

    start: Expr
    end: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 16):
            one, other = (2 * expression_ball(x) - arb(1) for x in (self.start, self.end))
            return other.erfinv() / one.erfinv()


@dataclass(frozen=True)
class Conversion:
    """From one proportion of right answers to another: times ``factor``, which is ``exact`` rounded to DIGITS digits."""

    start: Expr
    end: Expr

    @property
    def exact(self) -> RealNumber:
        """The factor of a threshold, as a number that can be enclosed."""
        return Quotient(self.start, self.end)

    @property
    def factor(self) -> Rational:
        """The factor of a threshold, as the decimal that is said; 1 where nothing is converted."""
        return decimal(self.exact.digits(DIGITS)) if self.start != self.end else Rational(1)

    def row(self) -> dict[str, object]:
        """As documents have it."""
        shown = {"factor": self.exact.digits(DIGITS), "enclosure": list(self.exact.enclosure(DIGITS))}
        return {"from": float(self.start), "to": float(self.end), **shown}


def read_proportion(key: str, given: Number) -> Expr:
    """A proportion of right answers, above one half and below 1; SceneError for any other."""
    try:
        value = number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within(key) from None
    if not value.is_Rational or not Rational(1, 2) < value < 1:
        raise SceneError(f'{key}: "{given}" must be rational, above 0.5, where answers are guesses, and below 1')
    return value
