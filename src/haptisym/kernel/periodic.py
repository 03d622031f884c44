"""Irreducible functions of one half angle alone, as delays bring them: their zeros are arctangents, exact and all alike."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor

import flint
from flint import arb, fmpq
from sympy import Expr, Integer, pi

from haptisym.kernel.analytic import AnalyticFactor
from haptisym.kernel.budget import tick
from haptisym.kernel.polynomials import polynomial_factors
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball


@dataclass(frozen=True, repr=False)
class Arctangent(RealNumber):
    """The angle between -pi/2 and pi/2 whose tangent is a number, or its opposite."""

    tangent: RealNumber
    sign: int

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.sign * self.tangent.ball(bits).atan()


@dataclass(frozen=True, repr=False)
class Turned(RealNumber):
    """The frequency at which a half angle, rate omega/2, is a number of half turns beyond another angle."""

    angle: RealNumber
    turns: int
    rate: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return 2 * (self.angle.ball(bits) + self.turns * arb.pi()) / expression_ball(self.rate)


class PeriodicFactor(AnalyticFactor):
    """An irreducible homogeneous polynomial in sine and cosine of one half angle, with rational coefficients.

    Its zeros are simple, and repeat with half a turn: none of them needs a search.
    """

    @property
    def turning(self) -> int:
        """Which angle it is that turns."""
        return next(i for i, degree in enumerate(self.degrees) if degree)

    @cached_property
    def angles(self) -> tuple[RealNumber, ...]:
        """All half angles in (-pi/2, pi/2] at which it vanishes."""
        powers = {term.turns[self.turning]: term.coefficients[0][0] for term in self.terms}
        row = [fmpq(powers.get(n, 0)) for n in range(max(powers) + 1)]
        if len(row) == 1:  # the cosine itself
            return (ExactNumber(pi / 2),)
        found: list[RealNumber] = [ExactNumber(Integer(0))] if not row[0] else []
        for sign in (1, -1):
            mirrored = [c * sign**n for n, c in enumerate(row)]
            for factor, _ in polynomial_factors(mirrored)[2]:
                found += [Arctangent(root, sign) for root in factor.positive_roots()]
        return tuple(found)

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        rate = self.rates[self.turning][0]
        with flint.ctx.workprec(128):
            ends = [expression_ball(low), expression_ball(high)]
            halves = [float((expression_ball(rate) * end / (2 * arb.pi())).mid()) for end in ends]
            turns = range(floor(halves[0] - 0.5 - _SLACK), floor(halves[1] + 0.5 + _SLACK) + 1)
            near = [(x, _ticked(x).ball(128)) for x in (Turned(angle, n, rate) for n in turns for angle in self.angles)]
            known = [end for end, place in zip(ends, (low, high), strict=True) if self.order_at(place)]
            # the zero at an end is counted there
            return [
                x
                for x, ball in near
                if not (ball < ends[0] or ball > ends[1] or any(ball.overlaps(end) for end in known))
            ]


def _ticked(x: Turned) -> Turned:
    tick()
    return x


_SLACK = 1e-6  # half turns: more than floats err, so that none is left out
