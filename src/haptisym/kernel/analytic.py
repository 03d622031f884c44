"""Irreducible functions of omega that delays and fractional powers bring, and their certified zeros.

Irreducible functions of omega that delays and fractional powers bring, and their certified zeros.

Irreducible functions of one half angle alone, as delays bring them: their zeros are arctangents, exact and all alike.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import floor
from typing import Any

import flint
from flint import arb, fmpq
from sympy import Expr, Integer, pi

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.polynomials import polynomial_factors
from haptisym.kernel.reals import MOST_BITS, Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.waves import (
    NEARER,
    Wave,
    WaveSum,
    beginning,
    by_powers,
    clear_of_zero,
    exact_waves,
    order_at_0,
    taylor_coefficients,
)
from haptisym.kernel.zeros import SeriesFactor, around, clear_of, is_clear, isolated, sign_of


class AnalyticFactor(WaveSum, SeriesFactor):
    """An irreducible function that holds sines, cosines or powers of omega."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        with flint.ctx.workprec(128):
            ends = around(low, high)
            box = arb.union(*ends)
            if not self.orders:
                return 0 if low == 0 and self.begins_with_zero else sign_of(self.value(box))
            if low == 0 and not any(not any(term.powers) for term in self.terms):
                return 0  # at omega = 0
            seen = set[int]()
            for place in (((ends[0] + ends[1]) / 2).mid(), box, *ends):
                signs = set(map(sign_of, self.parts(place)))
                if place is box and len(signs) == 1 and 0 not in signs:
                    return signs.pop()
                seen |= signs
                if {1, -1} <= seen:
                    return 0  # there is none all over
            return _common(self.ranges(box).values())

    @property
    def farthest(self) -> float | None:
        return NEARER if self.orders else None

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        with flint.ctx.workprec(128):
            ends = around(low, high)
            first = (ends[1] - ends[0]) / (NEARER if self.orders else 16)
        return isolated(self, self._edge(low, first, above=True), self._edge(high, first, above=False))

    def _edge(self, place: Expr, first: Ball, *, above: bool) -> Ball:
        """A dyadic number where a search may start or stop, with no zero between it and the place but at the place itself."""
        if place == 0 and self.orders:
            return clear_of_zero(self, first)
        order = self.order_at(place)
        if order or place == 0:  # even functions have slope 0 at 0: keep away from it
            return clear_of(self, place, order, first, above=above)
        with flint.ctx.workprec(128):
            ball = expression_ball(place)
            return ball.lower() if above else ball.upper()

    def order_at(self, place: Expr) -> Any:
        return _order_at(self, place)

    def shown_sign(self, place: Expr) -> int:
        return _shown_sign(self, place)


def _common(balls: Iterable[Ball]) -> int:
    """The sign that all have; 0 where they have none."""
    signs = {sign_of(x) for x in balls}
    return signs.pop() if len(signs) == 1 else 0


@lru_cache(maxsize=1024)
def _shown_sign(factor: AnalyticFactor, place: Expr) -> int:
    with flint.ctx.workprec(128):
        return sign_of(factor.value(expression_ball(place)))


@lru_cache(maxsize=1024)
def _order_at(factor: AnalyticFactor, place: Expr) -> Any:
    if place == 0 and factor.orders:
        return beginning(factor).exponent
    if place == 0 and not any(constant for _, constant in factor.rates):
        if not factor.begins_with_zero:
            return 0
        if (order := order_at_0(factor)) is not None:
            return order
    if _shown_sign(factor, place):
        return 0
    if factor.orders:
        return _order_with_powers(factor, place)
    exact = exact_waves(factor, place)
    if exact is None:
        factor.sign_at(lambda bits: expression_ball(place))
        return 0
    return _exact_order(factor, place, exact)


def _order_with_powers(factor: AnalyticFactor, place: Expr) -> int:
    """Away from 0: all Taylor coefficients vanish that vanish in every part; the next one must not."""
    parts = by_powers(factor).values()
    least = min(AnalyticFactor(p.terms, p.rates, p.degrees, ()).order_at(place) for p in parts)
    with flint.ctx.workprec(MOST_BITS):
        if is_clear(factor.taylor(expression_ball(place), least)):
            return int(least)
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


def _exact_order(factor: AnalyticFactor, place: Expr, waves: list[Wave]) -> int:
    """The order of the zero at a place where the waves are known exactly: the first derivative that is not zero there."""
    for order, found in zip(range(_HIGHEST_ORDER), taylor_coefficients(factor, place, waves), strict=False):
        if not found.is_zero:
            return order
    raise UndecidedError(f"the order of a zero at omega = {place} rad/s")


_HIGHEST_ORDER = 200


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
