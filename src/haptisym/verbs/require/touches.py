"""Where a function of frequency and of one parameter has an extremum or a zero, for a value known to any precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb
from sympy import Expr, Symbol

from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import PolynomialRing, RationalFunction
from haptisym.kernel.roots import Interval
from haptisym.kernel.symbols import omega
from haptisym.kernel.zeros import rounded_up, tightened


@dataclass(frozen=True)
class Surface:
    """The slope and the curvature in omega of a function of omega and one parameter, in balls."""

    slope: RationalFunction
    bend: RationalFunction
    free: Symbol

    @classmethod
    def of(cls, function: RealFunction, free: Symbol) -> Surface:
        """Of a function: its first and second derivative to omega."""
        slope = function.derivative()
        return cls(slope.function, slope.derivative().function, free)

    def ball(self, function: RationalFunction, place: Ball, value: Ball) -> Ball:
        """A ball around the values at balls of frequencies and of the parameter, at the current working precision."""
        known: dict[Expr, Any] = {omega: place, self.free: value}
        ring: PolynomialRing = function.ring
        values = {g: expression_ball(g, known) for g in ring.meanings if not g.is_Symbol or g in known}
        return ring.ball(function.numerator, values) / ring.ball(function.denominator, values)


@dataclass(frozen=True, repr=False)
class Touch(RealNumber):
    """The one extremum of a function of omega between two frequencies, where the parameter has a given value."""

    surface: Surface
    value: RealNumber
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(bits):
            at, surface = self.value.ball(bits), self.surface
            return tightened(
                self.low,
                self.high,
                bits,
                lambda x, count: [surface.ball(f, x, at) for f in (surface.slope, surface.bend)[:count]],
            )


def touch(surface: Surface, value: RealNumber, low: RealNumber, high: RealNumber, beyond: int = 0) -> Touch | None:
    """The extremum between two frequencies, proven to be there and to be the only one; None where that does not show.

    With ``beyond`` bits it is sought 2^-beyond rad/s outside as well.
    """
    with flint.ctx.workprec(256):
        outside = arb(2) ** -beyond if beyond else arb(0)
        start, end, at = low.ball(256).lower() - outside, high.ball(256).upper() + outside, value.ball(256)
        bend = surface.ball(surface.bend, start.union(end), at)
        left, right = (surface.ball(surface.slope, x, at) for x in (start, end))
        certain = (bend < 0 and left > 0 and right < 0) or (bend > 0 and left < 0 and right > 0)
    return Touch(surface, value, start, end) if certain else None


@dataclass(frozen=True)
class Surfaces:
    """One of the functions of a condition: where it has an extremum, and where a zero."""

    extremum: Surface
    zero: Surface

    @classmethod
    def of(cls, piece: RealFunction, free: Symbol) -> Surfaces:
        """Of what stands above the line."""
        ring = piece.axis
        top = RealFunction(ring.function(piece.function.numerator))
        return cls(Surface.of(top, free), Surface(top.function, top.derivative().function, free))


def isolated_touch(surfaces: Sequence[Surfaces], value: RealNumber, near: Interval, beyond: int) -> Touch | None:
    """What an interval shrinks to on which a condition is broken at a value nearby: proven, or None where that does not show.

    Where one function vanishes at both ends that is its extremum; where two do, the zero of one at which the other has its.
    """
    places = range(len(surfaces))
    low, high = ({i for i in places if point.orders.get(i, 0) > 0} for point in (near.low, near.high))
    ends = near.low.omega, near.high.omega
    for i in sorted(low & high):
        return touch(surfaces[i].extremum, value, *ends, beyond)
    found = (touch(surfaces[i].zero, value, *ends, beyond or _AROUND) for i in sorted(low | high))
    return next((x for x in found if x), None)


_AROUND = 12
"""Bits of what is looked at outside of an interval for the zero that two functions share, which may lie beyond its ends."""
