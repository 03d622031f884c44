"""Where on a band a condition can bind, for all values of a parameter in a cell: edges, single maxima, and corners.

A condition of several functions, which must not all be positive, is kept where one of them is negative; where all others are
positive, the one that is left decides. A corner is where two decide, of which one rises and the other falls.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TypeAlias

from flint import arb
from sympy import Expr

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.subdivision import Waiting
from haptisym.verbs.require.corners import Corner, corner_signs
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.places import CellVerdict, CriticalPlace, Edge, Strip, Summit
from haptisym.verbs.require.strips import Shape

_MOST_BOXES, _FINEST = 200, 20
_SAMPLES, _NEAR_END = 24, 1 << 10
_STEPS = 3
"""Of Newton's from a frequency at which a condition is broken to the maximum beside it."""


@dataclass(frozen=True, eq=False)
class Strips:
    """A condition for all values of the parameter in a cell: functions that must not all be positive, in balls."""

    strips: tuple[Strip, ...]

    @classmethod
    def of(cls, shapes: Sequence[Shape], low: Ball, high: Ball) -> Strips:
        """The cell between two dyadic numbers."""
        return cls(tuple(Strip.of(x, low, high) for x in shapes))

    @classmethod
    def beyond(cls, shapes: Sequence[Shape], inverse: Ball) -> Strips:
        """Values without bound, by their inverses."""
        return cls(tuple(Strip.beyond(x, inverse) for x in shapes))

    def value(self, x: Ball) -> Ball:
        """The values of the least function at a ball of frequencies, for all values of the parameter."""
        return reduce(arb.min, (strip.value(x) for strip in self.strips))

    def broken_in_the_middle(self, x: Ball) -> bool:
        """Whether the condition is broken at a frequency for the middle of the cell; without bound, for all of it."""
        return all(strip.broken_in_the_middle(x) for strip in self.strips)

    def risen(self, suspects: Sequence[Ball], low: Ball, high: Ball) -> Iterator[Ball]:
        """Frequencies between two, nearer a maximum of the condition for the middle of the cell: Newton's steps from a suspect.

        Where the condition is broken by little it is at the maximum that all of the cell shows it. Not of several functions.
        """
        [strip, *others] = self.strips
        compiled = strip.middle or strip.whole
        at = max(suspects, key=lambda x: float(compiled.value(x).mid()))
        for _ in range(0 if others else _STEPS):
            slope, bend = compiled.series(at, 1, 3)
            if not bend < 0:
                return
            at = (at - slope / (2 * bend)).mid()
            if not (low < at < high):
                return
            yield at

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        """The signs at a place for both ends of the cell, if it changes one way only in between; None if that is not sure."""
        one = self.strips[place.piece]
        return one.signs(place) if place.other is None else corner_signs(one, self.strips[place.other], place)

    def crossing(self, place: CriticalPlace) -> Edge | Summit | Corner:
        """The value of the parameter at which the condition binds at a place."""
        one = self.strips[place.piece]
        if place.other is None:
            return one.crossing(place)
        assert one.ends is not None
        return Corner(one.shape, self.strips[place.other].shape, (place.low, place.high), *one.ends)


@dataclass(frozen=True)
class _Box:
    """A piece of the band on which a condition did not show to be kept, with the signs of slope and curvature there.

    ``pieces`` : the functions that did not show to be positive; one, or two for a corner, whose ``slopes`` are given.
    """

    low: Ball
    high: Ball
    slope: int
    bend: int
    pieces: tuple[int, ...] = (0,)
    slopes: tuple[int, ...] = ()


_Found: TypeAlias = "CellVerdict | list[CriticalPlace]"


def places(condition: Strips, band: tuple[Expr, Expr]) -> _Found:
    """All places where a condition can bind, for all values of a cell; or BROKEN; or OPEN where that is not clear."""
    low, high = expression_ball(band[0]).lower(), expression_ball(band[1]).upper()
    near_ends = (low + (high - low) / _NEAR_END).mid(), expression_ball(band[1]).lower()
    if any(condition.value(x) > 0 for x in near_ends):
        return CellVerdict.BROKEN
    samples = [(low + (high - low) * i / _SAMPLES).mid() for i in range(1, _SAMPLES)]
    suspects = [x for x in samples if condition.broken_in_the_middle(x)]
    if suspects:  # the cell is broken there, or near there, or it must be cut
        broken = any(condition.value(x) > 0 for x in (*suspects, *condition.risen(suspects, low, high)))
        return CellVerdict.BROKEN if broken else CellVerdict.OPEN
    boxes = _unclear(condition, low, high)
    if isinstance(boxes, CellVerdict):
        return boxes
    found: list[CriticalPlace] = []
    for cluster in _clusters(boxes):
        place = _decided(condition, cluster, low, high, band)
        if place is CellVerdict.OPEN:
            return CellVerdict.OPEN
        if isinstance(place, CriticalPlace):
            found.append(place)
    return found


def _unclear(condition: Strips, low: Ball, high: Ball) -> CellVerdict | list[_Box]:
    """The pieces of the band on which the condition does not show to be kept, in order."""
    found: list[_Box] = []
    waiting = Waiting([(low, high)])
    for a, b in waiting:
        box = _box(condition, a, b)
        if box is None:
            continue
        middle = ((a + b) / 2).mid()
        if condition.value(middle) > 0:
            return CellVerdict.BROKEN
        if condition.broken_in_the_middle(middle):
            broken = any(condition.value(x) > 0 for x in condition.risen([middle], a, b))
            return CellVerdict.BROKEN if broken else CellVerdict.OPEN
        if waiting.examined > _MOST_BOXES:
            return CellVerdict.OPEN
        if (b - a) * _FINEST < high - low and (box.slope or box.bend < 0 or box.slopes):
            found.append(box)
        else:
            waiting.add((a, middle), (middle, b))
    return found


def _box(condition: Strips, a: Ball, b: Ball) -> _Box | None:
    """What is known of a condition on a piece of the band; None where it is kept."""
    box, open_ = a.union(b), dict[int, tuple[int, int]]()
    for i, strip in enumerate(condition.strips):
        value, slope, bend = strip.over(box)
        if value < 0:
            return None
        if not (value > 0 and len(condition.strips) > 1):
            open_[i] = _sign(slope), _sign(bend)
    if len(open_) == 1:
        [(i, (slope, bend))] = open_.items()
        return _Box(a, b, slope, bend, (i,))
    slopes = tuple(slope for slope, _ in open_.values())
    return _Box(a, b, 0, 0, tuple(open_), slopes if sorted(slopes) == [-1, 1] else ())


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


def _decided(
    condition: Strips, cluster: list[_Box], low: Ball, high: Ball, band: tuple[Expr, Expr]
) -> CriticalPlace | CellVerdict:
    """Where alone in a piece the condition can bind: by one of its functions, or by two at a corner."""
    deciding = sorted({i for box in cluster for i in box.pieces})
    if len(deciding) == 1:
        place = _place(condition.strips[deciding[0]], cluster, low, high, band)
        return replace(place, piece=deciding[0]) if isinstance(place, CriticalPlace) else place
    a, b = cluster[0].low, cluster[-1].high
    if len(deciding) > 2 or a == low or b == high:
        return CellVerdict.OPEN
    slopes = [_sign(condition.strips[i].over(a.union(b))[1]) for i in deciding]
    if sorted(slopes) != [-1, 1]:
        return CellVerdict.OPEN
    rising, falling = deciding if slopes[0] > 0 else deciding[::-1]
    return CriticalPlace(Kind.TOUCH, a, b, piece=rising, other=falling)


def _place(
    strip: Strip, cluster: list[_Box], low: Ball, high: Ball, band: tuple[Expr, Expr]
) -> CriticalPlace | CellVerdict:
    """Where alone in a piece the condition can bind; KEPT if it is largest where it is known to be kept."""
    a, b = cluster[0].low, cluster[-1].high
    bent = all(box.bend < 0 for box in cluster)
    rises = all(box.slope > 0 or (box.bend < 0 and _slope(strip, box.high) > 0) for box in reversed(cluster))
    falls = all(
        box.slope < 0 or (box.bend < 0 and (_is_level(strip, box.low) or _slope(strip, box.low) < 0)) for box in cluster
    )
    if rises:
        return CriticalPlace(Kind.EDGE, a, b, band[1]) if b == high else CellVerdict.KEPT
    if falls:
        return CriticalPlace(Kind.START, a, b, band[0]) if a == low else CellVerdict.KEPT
    if bent and _slope(strip, a) > 0 and _slope(strip, b) < 0:
        return CriticalPlace(Kind.TOUCH, a, b)
    return CellVerdict.OPEN


def _is_level(strip: Strip, x: Ball) -> bool:
    """Whether the slope is 0 there as that of a function of omega^2 is at 0: a fall begins there too."""
    return bool(x == 0) and strip.shape.is_even


def _slope(strip: Strip, x: Ball) -> int:
    return _sign(strip.coefficient(x, 1))
