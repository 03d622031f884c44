"""A real function of frequency for all values of a parameter in a cell, and the values at which it binds there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from math import factorial

import flint
from flint import arb
from sympy import Expr

from haptisym.kernel.bernstein import range_of
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.waves import CompiledWaves
from haptisym.kernel.zeros import rounded_up, tightened
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.strips import Shape

_MOST_ROWS = 4  # of a Taylor series in the parameter: conditions are squares of what is mostly linear in it
_NARROWED = 6  # times that the frequencies around a maximum are cut from both sides
NOTHING = arb(0, "inf")


class CellVerdict(Enum):
    """What is known of a cell of values: the condition is kept all over the band, or broken somewhere, for all of them."""

    KEPT = "kept"
    BROKEN = "broken"
    OPEN = "open"


@dataclass(frozen=True)
class CriticalPlace:
    """Where alone a condition can bind: at an end of the band, or at the one maximum or corner between two frequencies."""

    kind: Kind
    low: Ball
    high: Ball
    omega: Expr | None = None
    piece: int = 0
    other: int | None = None
    """Of the functions of a condition the one that is decisive; for a corner the rising one, and the falling one."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A condition for all values of the parameter in a cell, in balls; ``ends``: None for values without bound."""

    shape: Shape
    whole: CompiledWaves
    ends: tuple[Ball, Ball] | None = None

    @classmethod
    def of(cls, shape: Shape, low: Ball, high: Ball) -> Strip:
        """The cell between two dyadic numbers."""
        return cls(shape, shape.over(low.union(high)), (low, high))

    @classmethod
    def beyond(cls, shape: Shape, inverse: Ball) -> Strip:
        """Values without bound, by their inverses."""
        return cls(shape, shape.beyond(inverse))

    @cached_property
    def middle(self) -> CompiledWaves | None:
        """The condition for the middle of the cell; None for values without bound."""
        return self.shape.over(((self.ends[0] + self.ends[1]) / 2).mid()) if self.ends else None

    @cached_property
    def change(self) -> CompiledWaves | None:
        """The derivative in the parameter, for the whole cell; None where there is none."""
        return self.shape.change.over(self.ends[0].union(self.ends[1])) if self.ends and self.shape.change else None

    @cached_property
    def _rows(self) -> tuple[CompiledWaves, ...]:
        """Taylor's coefficients in the parameter about the middle of the cell, times n!; the last one for all of the cell."""
        if self.middle is None or self.ends is None:
            return ()
        low, high = self.ends
        found, shape = [self.middle], self.shape.change
        while shape is not None and shape.change is not None and len(found) < _MOST_ROWS:
            found.append(shape.over(((low + high) / 2).mid()))
            shape = shape.change
        return (*found, shape.over(low.union(high))) if shape is not None else ()

    @cached_property
    def _reach(self) -> list[Ball]:
        """The powers of half the width of the cell, over n!."""
        assert self.ends is not None
        low, high = self.ends
        reach = (low.union(high) - ((low + high) / 2).mid()).abs_upper()
        return [reach**n / factorial(n) for n in range(len(self._rows))]

    def _together(self, row: Sequence[Ball]) -> Ball:
        """The values for all of the cell, from those of the coefficients."""
        return range_of(row, self._reach)

    def value(self, x: Ball) -> Ball:
        """The values at a ball of frequencies, for all values of the parameter."""
        value = self.whole.value(x)
        if value > 0 or value < 0 or not self._rows:
            return value
        return _both(value, self._together([f.value(x) for f in self._rows]))

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Value, slope and half curvature over a ball of frequencies."""
        if self.whole.exponents and not box > 0:
            return self.shape.from_zero(self.whole, box.upper()), NOTHING, NOTHING
        if self.shape.order_at_zero and not box > 0:
            return self._over_zero(box)
        value, slope, bend = self.whole.over(box)
        if value < 0 or not self._rows:
            return value, slope, bend
        rows = zip(*(f.over(box) for f in self._rows), strict=True)
        value, slope, bend = (_both(x, self._together(y)) for x, y in zip((value, slope, bend), rows, strict=True))
        return value, slope, bend

    def _over_zero(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Of f(x)/x^k, k a power of omega that is a factor: a k-th Taylor coefficient in between, and its slope the next one.

        The slope of an even function is 2 x times half a curvature in between: that has its sign, and stands for it.
        """
        k = int(self.shape.order_at_zero)
        value = self.coefficient(box, k)
        if value < 0 or self.coefficient(arb(0), k) < 0:  # of a piece that shows to be kept when it is cut
            return value, NOTHING, NOTHING
        return value, self.coefficient(box, k + (2 if self.shape.is_even else 1)), NOTHING

    def coefficient(self, box: Ball, n: int) -> Ball:
        """Taylor's in omega, over a ball of frequencies, for all values of the parameter."""
        value = self.whole.taylor(box, n)
        if value < 0 or value > 0 or not self._rows:
            return value
        return _both(value, self._together([f.taylor(box, n) for f in self._rows]))

    def broken_in_the_middle(self, x: Ball) -> bool:
        """Whether the condition is broken at a frequency for the middle of the cell; without bound, for all of it."""
        return bool((self.middle or self.whole).value(x) > 0)

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        """The signs at a place for both ends of the cell, if it changes one way only in between; None if that is not sure."""
        if self.ends is None:
            return None
        at_edge = place.omega is not None
        near = expression_ball(place.omega) if at_edge else self._around_maximum(place)
        sign = _sign(self.shape.seen_at(self.whole, near) if at_edge else self.over(near)[0])
        if not sign and self.shape.is_fixed:
            sign = self._sign(place, self.ends[0])
        if sign:
            return sign, sign
        if self.change is None:
            return None
        if not _sign(self.shape.seen_at(self.change, near) if at_edge else self.change.over(near)[0]):
            return None
        found = [self._sign(place, end) for end in self.ends]
        return None if 0 in found else (found[0], found[1])

    def _around_maximum(self, place: CriticalPlace) -> Ball:
        """Frequencies among which the maximum at a place is, for all values of the parameter: there the slope falls through 0."""
        low, high = place.low, place.high
        for share in (4, 2, 4 / 3) * _NARROWED:
            x = (low + (high - low) / share).mid()
            slope = self.whole.taylor(x, 1)
            low, high = (x, high) if slope > 0 else (low, x) if slope < 0 else (low, high)
        return low.union(high)

    def _sign(self, place: CriticalPlace, value: Ball) -> int:
        if place.omega is not None:
            ball = self.shape.seen_at(self.shape.over(value), expression_ball(place.omega))
        else:
            x = maximum(self.shape, value, (place.low, place.high), flint.ctx.prec)
            ball = self.shape.over(value).over(x)[0]
        return _sign(ball)

    def crossing(self, place: CriticalPlace) -> Edge | Summit:
        """The value of the parameter at which the condition binds at a place."""
        assert self.ends is not None
        if place.omega is not None:
            return Edge(self.shape, place.omega, *self.ends)
        return Summit(self.shape, (place.low, place.high), *self.ends)


def _sign(x: Ball) -> int:
    return 1 if x > 0 else -1 if x < 0 else 0


def _both(a: Ball, b: Ball) -> Ball:
    """What two enclosures of one number leave."""
    if not (a.is_finite() and b.is_finite()):
        return a if a.is_finite() else b
    return a.intersection(b)


@dataclass(frozen=True, repr=False)
class Edge(RealNumber):
    """The value of the parameter in a cell at which a condition binds at a given frequency: the one zero there."""

    shape: Shape
    place: Expr
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits, change = rounded_up(bits), self.shape.change
        assert change is not None
        with flint.ctx.workprec(bits):
            at = expression_ball(self.place)

            def jet(t: Ball, count: int) -> list[Ball]:
                return [self.shape.seen_at(f.over(t), at) for f in (self.shape, change)[:count]]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class Summit(RealNumber):
    """The value of the parameter in a cell at which the one maximum of a condition between two frequencies is 0."""

    shape: Shape
    between: tuple[Ball, Ball]
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits, change = rounded_up(bits), self.shape.change
        assert change is not None
        with flint.ctx.workprec(bits):

            def jet(t: Ball, count: int) -> list[Ball]:
                at = maximum(self.shape, t, self.between, bits)
                return [f.over(t).over(at)[0] for f in (self.shape, change)[:count]]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class MaximumAt(RealNumber):
    """The frequency of the maximum that a ``Summit`` is about."""

    summit: Summit

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(2 * bits):
            return maximum(self.summit.shape, self.summit.ball(2 * bits), self.summit.between, 2 * bits)


def maximum(shape: Shape, t: Ball, between: tuple[Ball, Ball], bits: int) -> Ball:
    """Where the slope in omega vanishes between two frequencies, for a ball of values of the parameter."""
    strip = shape.over(t)
    return tightened(*between, bits, lambda x, count: [n * c for n, c in enumerate(strip.series(x, 1, count + 1), 1)])
