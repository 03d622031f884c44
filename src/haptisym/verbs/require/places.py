"""Where on a band a condition can bind, for all values of a parameter in a cell: the edges and single maxima."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import TypeAlias

import flint
from flint import arb
from sympy import Expr

from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.subdivision import Waiting
from haptisym.kernel.wavesums import CompiledWaves
from haptisym.kernel.zeros import rounded_up, tightened
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.strips import Shape, value_from_zero

_MOST_BOXES, _FINEST = 200, 20
_SAMPLES = 24
_NOTHING = arb(0, "inf")


class CellVerdict(Enum):
    """What is known of a cell of values: the condition is kept all over the band, or broken somewhere, for all of them."""

    KEPT = "kept"
    BROKEN = "broken"
    OPEN = "open"


@dataclass(frozen=True)
class CriticalPlace:
    """Where alone a condition can bind: at an end of the band, or at the one maximum between two frequencies."""

    kind: Kind
    low: Ball
    high: Ball
    omega: Expr | None = None


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
    def _reach(self) -> Ball:
        assert self.ends is not None
        low, high = self.ends
        return low.union(high) - ((low + high) / 2).mid()

    def value(self, x: Ball) -> Ball:
        """The values at a ball of frequencies, for all values of the parameter."""
        value = self.whole.value(x)
        if value > 0 or value < 0 or self.middle is None or self.change is None:
            return value
        return _both(value, self.middle.value(x) + self.change.value(x) * self._reach)

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Value, slope and half curvature over a ball of frequencies."""
        if self.whole.exponents and not box > 0:
            return value_from_zero(self.whole, box.upper()), _NOTHING, _NOTHING
        if self.shape.order_at_zero and not box > 0:
            return self._over_zero(box), _NOTHING, _NOTHING
        value, slope, bend = self.whole.over(box)
        if not value < 0 and self.middle is not None and self.change is not None:
            value = _both(value, self.middle.over(box)[0] + self.change.over(box)[0] * self._reach)
        return value, slope, bend

    def _over_zero(self, box: Ball) -> Ball:
        """The values over a power of omega that is a factor: f(x)/x^k is a k-th Taylor coefficient in between."""
        k = self.shape.order_at_zero
        value = self.whole.taylor(box, k)
        if value < 0 or self.middle is None or self.change is None:
            return value
        return _both(value, self.middle.taylor(box, k) + self.change.taylor(box, k) * self._reach)

    def broken_in_the_middle(self, x: Ball) -> bool:
        """Whether the condition is broken at a frequency for the middle of the cell; without bound, for all of it."""
        return bool((self.middle or self.whole).value(x) > 0)

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        """The signs at a place for both ends of the cell, if it changes one way only in between; None if that is not sure."""
        if self.ends is None or self.change is None:
            return None
        at = expression_ball(place.omega) if place.omega is not None else place.low.union(place.high)
        steep = self.change.value(at) if place.omega is not None else self.change.over(at)[0]
        if not (steep > 0 or steep < 0):
            return None
        found = [self._sign(place, end) for end in self.ends]
        return None if 0 in found else (found[0], found[1])

    def _sign(self, place: CriticalPlace, value: Ball) -> int:
        if place.omega is not None:
            ball = self.shape.over(value).value(expression_ball(place.omega))
        else:
            x = maximum(self.shape, value, (place.low, place.high), flint.ctx.prec)
            ball = self.shape.over(value).over(x)[0]
        return 1 if ball > 0 else -1 if ball < 0 else 0

    def crossing(self, place: CriticalPlace) -> Edge | Summit:
        """The value of the parameter at which the condition binds at a place."""
        assert self.ends is not None
        if place.omega is not None:
            return Edge(self.shape, place.omega, *self.ends)
        return Summit(self.shape, (place.low, place.high), *self.ends)


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
                return [f.over(t).value(at) for f in (self.shape, change)[:count]]

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


# Where a condition can bind


@dataclass(frozen=True)
class _Box:
    """A piece of the band on which a condition did not show to be kept, with the signs of slope and curvature there."""

    low: Ball
    high: Ball
    slope: int
    bend: int


_Found: TypeAlias = "CellVerdict | list[CriticalPlace]"


def places(strip: Strip, band: tuple[Expr, Expr]) -> _Found:
    """All places where a condition can bind, for all values of a cell; or BROKEN; or OPEN where that is not clear."""
    low, high = expression_ball(band[0]).lower(), expression_ball(band[1]).upper()
    samples = [(low + (high - low) * i / _SAMPLES).mid() for i in range(1, _SAMPLES)]
    suspects = [x for x in samples if strip.broken_in_the_middle(x)]
    if suspects:  # the cell is broken there, or it must be cut
        return CellVerdict.BROKEN if any(strip.value(x) > 0 for x in suspects) else CellVerdict.OPEN
    boxes = _unclear(strip, low, high)
    if isinstance(boxes, CellVerdict):
        return boxes
    found: list[CriticalPlace] = []
    for cluster in _clusters(boxes):
        place = _place(strip, cluster, low, high, band)
        if place is CellVerdict.OPEN:
            return CellVerdict.OPEN
        if isinstance(place, CriticalPlace):
            found.append(place)
    return found


def _unclear(strip: Strip, low: Ball, high: Ball) -> CellVerdict | list[_Box]:
    """The pieces of the band on which the condition does not show to be kept, in order."""
    found: list[_Box] = []
    waiting = Waiting([(low, high)])
    for a, b in waiting:
        box = a.union(b)
        value, slope, bend = strip.over(box)
        if value < 0:
            continue
        middle = ((a + b) / 2).mid()
        if strip.value(middle) > 0:
            return CellVerdict.BROKEN
        if strip.broken_in_the_middle(middle) or waiting.examined > _MOST_BOXES:
            return CellVerdict.OPEN
        if (b - a) * _FINEST < high - low and (_sign(slope) or _sign(bend) < 0):
            found.append(_Box(a, b, _sign(slope), _sign(bend)))
        else:
            waiting.add((a, middle), (middle, b))
    return found


def _sign(ball: Ball) -> int:
    return 1 if ball > 0 else -1 if ball < 0 else 0


def _clusters(boxes: list[_Box]) -> list[list[_Box]]:
    """Pieces that follow each other without a gap."""
    found: list[list[_Box]] = []
    for box in boxes:
        if found and found[-1][-1].high == box.low:
            found[-1].append(box)
        else:
            found.append([box])
    return found


def _place(
    strip: Strip, cluster: list[_Box], low: Ball, high: Ball, band: tuple[Expr, Expr]
) -> CriticalPlace | CellVerdict:
    """Where alone in a piece the condition can bind; KEPT if it is largest where it is known to be kept."""
    a, b = cluster[0].low, cluster[-1].high
    bent = all(box.bend < 0 for box in cluster)
    even = (
        bool(a == 0) and not strip.whole.exponents and not strip.shape.order_at_zero
    )  # a function of omega^2: its slope is 0 at 0
    rises = all(box.slope > 0 for box in cluster) or (bent and _slope(strip, b) > 0)
    falls = all(box.slope < 0 for box in cluster) or (bent and (even or _slope(strip, a) < 0))
    if rises:
        return CriticalPlace(Kind.EDGE, a, b, band[1]) if b == high else CellVerdict.KEPT
    if falls:
        return CriticalPlace(Kind.START, a, b, band[0]) if a == low else CellVerdict.KEPT
    if bent and _slope(strip, a) > 0 and _slope(strip, b) < 0:
        return CriticalPlace(Kind.TOUCH, a, b)
    return CellVerdict.OPEN


def _slope(strip: Strip, x: Ball) -> int:
    return _sign(strip.whole.taylor(x, 1))
