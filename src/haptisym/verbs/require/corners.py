"""Where two functions that must not both be positive bind together: one rises over the zero of the other, which falls."""

from __future__ import annotations

from dataclasses import dataclass

import flint

from haptisym.kernel.reals import Ball, RealNumber
from haptisym.kernel.zeros import rounded_up, tightened
from haptisym.verbs.require.places import CriticalPlace, Strip
from haptisym.verbs.require.strips import Shape


@dataclass(frozen=True, repr=False)
class Corner(RealNumber):
    """The value of the parameter in a cell at which the zero of ``rising`` between two frequencies is one of ``falling``."""

    rising: Shape
    falling: Shape
    between: tuple[Ball, Ball]
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(bits):

            def jet(t: Ball, count: int) -> list[Ball]:
                at = zero(self.rising, t, self.between, bits)
                return [self.falling.over(t).over(at)[0], _steepness(self.rising, self.falling, t, at)][:count]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class ZeroAt(RealNumber):
    """The frequency of a ``Corner``."""

    corner: Corner

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(2 * bits):
            return zero(self.corner.rising, self.corner.ball(2 * bits), self.corner.between, 2 * bits)


def zero(shape: Shape, t: Ball, between: tuple[Ball, Ball], bits: int) -> Ball:
    """Where a function vanishes between two frequencies, for a ball of values of the parameter."""
    strip = shape.over(t)
    return tightened(*between, bits, lambda x, count: strip.series(x, 0, count))


def _steepness(rising: Shape, falling: Shape, t: Ball, at: Ball) -> Ball:
    """How fast the value of ``falling`` at the zero of ``rising`` changes with the parameter."""
    changes = [0 if x.change is None else x.change.over(t).over(at)[0] for x in (rising, falling)]
    slopes = [x.over(t).over(at)[1] for x in (rising, falling)]
    return changes[1] - slopes[1] * changes[0] / slopes[0]


def corner_signs(rising: Strip, falling: Strip, place: CriticalPlace) -> tuple[int, int] | None:
    """1 where both are positive somewhere between the frequencies, -1 where nowhere, for both ends of a cell.

    None unless both vanish there for all values of the cell, and what decides changes one way only.
    """
    a, b = place.low, place.high
    shows = rising.value(a) < 0 < rising.value(b) and falling.value(b) < 0 < falling.value(a)
    if rising.ends is None or not shows:
        return None
    low, high = rising.ends
    steep = _steepness(rising.shape, falling.shape, low.union(high), a.union(b))
    if not (steep > 0 or steep < 0):
        return None
    found = []
    for t in (low, high):
        value = falling.shape.over(t).over(zero(rising.shape, t, (a, b), flint.ctx.prec))[0]
        found.append(1 if value > 0 else -1 if value < 0 else 0)
    return None if 0 in found else (found[0], found[1])
