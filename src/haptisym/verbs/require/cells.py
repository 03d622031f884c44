"""For which values of one parameter a condition holds all over a band, for scenes with delays and powers: by balls.

The values are cut into cells. A cell is *broken* if at one frequency the condition is broken for all its values, *kept* if
it holds for all its values on all of the band, both shown in ball arithmetic. Around an end of the set neither can be; there
the condition is shown to be decided by one place alone, the band's edge or one maximum over frequency, and to change along
the parameter one way only: then there is one end, a zero of a real function, known to any number of digits. What shows
neither way is cut in two, down to cells that are 1e-13 of their values wide.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import inf, nextafter, sqrt

import flint
from flint import arb
from sympy import Expr, Symbol, pi

from haptisym.judge.crossings import Criterion
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber, RealNumber, dyadic
from haptisym.kernel.roots import Interval, chart
from haptisym.verbs.require.feasible import Binding, Kind
from haptisym.verbs.require.floatcells import Told
from haptisym.verbs.require.freeparameter import Conditions, pieces
from haptisym.verbs.require.limits import Limit, long, short
from haptisym.verbs.require.places import (
    CellVerdict,
    Corner,
    CriticalPlace,
    Edge,
    MaximumAt,
    Shape,
    Strips,
    Summit,
    ZeroAt,
    places,
)

BITS = 128
_NARROW = 1e-13
"""Of a cell that is cut no further, relative to its values."""
_COARSE = Fraction(1, 32)
"""Relative width up to which cells are cut widest first; narrower ones in order."""
_MOST_CELLS = 800
_TAILS, _STEP = 5, 8
"""How many values without bound are tried, and how many times one is the one before it."""
_NEARER = {1 << 10: 16, 1 << 20: 16, 1 << 36: 256}
"""How much nearer its limit than a usual size a parameter is taken first, and later; and parts of the band."""
_VERDICTS = {True: CellVerdict.KEPT, False: CellVerdict.BROKEN}


@dataclass(frozen=True)
class Leaf:
    """Values of the parameter between two numbers, None without bound, and what is known of them.

    ``value``: of a leaf in which the set ends, where; ``verdict`` is then that of the values below it, ``above`` that above.
    """

    low: Fraction | None
    high: Fraction | None
    verdict: CellVerdict
    above: CellVerdict | None = None
    value: RealNumber | None = None
    binding: Binding | None = None


@dataclass(frozen=True)
class ValueSearch:
    """Conditions in omega and one parameter, on a band; ``scale``: a usual size of the parameter."""

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]
    scale: Fraction
    quick: Callable[[float, float], Sequence[Told]] = lambda low, high: (Told(low, high, None),)
    _limits: dict[tuple[int, bool], Limit | None] = field(default_factory=dict, init=False, repr=False)

    def leaves(self, low: Fraction | None, high: Fraction | None) -> list[Leaf]:
        """The values from ``low`` to ``high``, cut into leaves in order."""
        found: list[Leaf] = []
        start, end = low, high
        if low is None:
            below = self._tail(-1, -self.scale if high is None else min(-self.scale, 2 * high))
            start = below.high
            found.append(below)
        if high is None:
            above = self._tail(1, self.scale if low is None else max(self.scale, 2 * low))
            end = above.low
        assert start is not None
        assert end is not None
        found += self._told(self.quick(float(start), float(end)))
        return [*found, above] if high is None else found

    def _cut(self, low: Fraction, high: Fraction) -> list[Leaf]:
        """The leaves between two numbers, in order; wide cells are cut first, so that no easy one stays open for a hard one."""
        found = list[Leaf]()
        waiting = Waiting([(low, high)], self._rank, most=_MOST_CELLS, what="values in cells")
        with suppress(LimitError):  # what waits stays open
            for a, b in waiting:
                leaf = self._judged(a, b)
                if leaf.verdict is not CellVerdict.OPEN or self._width(a, b) < _NARROW:
                    found.append(leaf)
                else:
                    waiting.add((a, _middle(a, b)), (_middle(a, b), b))
        found += [Leaf(a, b, CellVerdict.OPEN) for a, b in waiting.rest]
        return sorted(found, key=lambda leaf: leaf.low or 0)

    def _told(self, told: Sequence[Told]) -> Iterator[Leaf]:
        """What floats tell as leaves; what they leave open by the limit at 0, and by cells."""
        for x in told:
            a, b = Fraction(x.low), Fraction(x.high)
            if x.kept is not None:
                yield Leaf(a, b, _VERDICTS[x.kept])
            elif a < 0 < b:
                yield from self._told([Told(x.low, 0.0, None), Told(0.0, x.high, None)])
            elif a != 0 != b:
                yield from self._cut(a, b)
            else:
                yield from self._next_to_zero(a, b)

    def _next_to_zero(self, low: Fraction, high: Fraction) -> Iterator[Leaf]:
        sign = 1 if high else -1
        verdict, reach = self._limit(sign, abs(high or low), inverse=False)
        if verdict is CellVerdict.OPEN:
            yield from self._cut(low, high)
        elif sign > 0:
            yield Leaf(low, reach, verdict)
            yield from self._told(self.quick(float(reach), float(high)))
        else:
            yield from self._told(self.quick(float(low), float(-reach)))
            yield Leaf(-reach, high, verdict)

    def _limit(self, sign: int, reach: Fraction, *, inverse: bool) -> tuple[CellVerdict, Fraction]:
        """What is known of t, or of 1/t, next to 0 on one side, up to that number, which is much less than ``reach``."""
        near = self._near_limit(sign, inverse=inverse)
        with suppress(LimitError), flint.ctx.workprec(BITS):
            for n, parts in _NEARER.items():
                if near is not None:
                    verdict, far = near.verdict(reach / n, parts)
                else:
                    verdict, far = CellVerdict.OPEN if inverse or sign < 0 else self._short(reach / n), reach / n
                if verdict is not CellVerdict.OPEN:
                    return verdict, far
        return CellVerdict.OPEN, reach

    def _short(self, reach: Fraction) -> CellVerdict:
        return short(self._single, self.free, self.band, reach) if self._single else CellVerdict.OPEN

    def _near_limit(self, sign: int, *, inverse: bool) -> Limit | None:
        if (sign, inverse) not in self._limits:
            own = self._single
            found = Limit.of(own, self.free, self.band, inverse=inverse, sign=sign) if own else None
            self._limits[sign, inverse] = found
        return self._limits[sign, inverse]

    @cached_property
    def _single(self) -> list[RealFunction]:
        """The conditions, where each is one function; none where not."""
        own = [pieces(x) for x in self.conditions.values()]
        return [x[0] for x in own] if all(len(x) == 1 for x in own) else []

    def _rank(self, cell: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
        return -max(self._width(*cell), _COARSE), cell[0]

    def _width(self, low: Fraction, high: Fraction) -> Fraction:
        """The width of a cell, relative to its values."""
        return (high - low) / max(-low, high, self.scale / 1000)

    def _judged(self, low: Fraction, high: Fraction) -> Leaf:
        """What balls tell of the values between two numbers."""
        with flint.ctx.workprec(BITS):
            a, b = dyadic(low), dyadic(high)
            strips = {x: Strips.of(shapes, a, b) for x, shapes in self._shapes.items()}
            return self._leaf(low, high, strips)

    @cached_property
    def _shapes(self) -> dict[Criterion, tuple[Shape, ...]]:
        return {x: tuple(Shape.of(f, self.free) for f in pieces(own)) for x, own in self.conditions.items()}

    def _leaf(self, low: Fraction, high: Fraction, strips: dict[Criterion, Strips]) -> Leaf:
        crossing: list[tuple[Criterion, CriticalPlace, int]] = []
        is_open = False  # of one criterion; another may be broken for all values
        for criterion, strip in strips.items():
            found = places(strip, self.band)
            if found is CellVerdict.BROKEN:
                return Leaf(low, high, CellVerdict.BROKEN)
            is_open |= isinstance(found, CellVerdict)
            for place in () if isinstance(found, CellVerdict) else found:
                signs = strip.signs(place)
                if signs == (1, 1):
                    return Leaf(low, high, CellVerdict.BROKEN)
                if signs is None:
                    is_open = True
                elif signs != (-1, -1):
                    crossing.append((criterion, place, signs[0]))
        if is_open or len(crossing) > 1:
            return Leaf(low, high, CellVerdict.OPEN)
        if not crossing:
            return Leaf(low, high, CellVerdict.KEPT)
        [(criterion, place, before)] = crossing
        value = strips[criterion].crossing(place)
        verdicts = (CellVerdict.BROKEN, CellVerdict.KEPT) if before > 0 else (CellVerdict.KEPT, CellVerdict.BROKEN)
        return Leaf(low, high, *verdicts, value, _binding(criterion, place, value))

    # Values without bound

    def _tail(self, sign: int, start: Fraction) -> Leaf:
        """The values beyond a number, the first of its multiples for which they show to be alike."""
        bound, verdict = start, CellVerdict.OPEN
        try:
            turned = self._tail_by_phase(sign)
            if turned is not None:
                return turned
            verdict, reach = self._limit(sign, 1 / abs(start), inverse=True)
            if verdict is not CellVerdict.OPEN:
                bound = _not_below(1 / reach)
                return Leaf(bound, None, verdict) if sign > 0 else Leaf(None, -bound, verdict)
            for _ in range(_TAILS if self._near_limit(sign, inverse=True) is None else 1):
                verdict = self._beyond(sign, bound)
                if verdict is not CellVerdict.OPEN:
                    break
                bound *= _STEP
        except LimitError:
            verdict = CellVerdict.OPEN
        return Leaf(bound, None, verdict) if sign > 0 else Leaf(None, bound, verdict)

    def _beyond(self, sign: int, bound: Fraction) -> CellVerdict:
        with flint.ctx.workprec(BITS):
            inverse = arb(0).union(sign / abs(dyadic(bound)))
            verdicts = set()
            for shapes in self._shapes.values():
                found = places(Strips.beyond(shapes, inverse), self.band)
                if found is CellVerdict.BROKEN:
                    return CellVerdict.BROKEN
                verdicts.add(
                    found if isinstance(found, CellVerdict) else CellVerdict.OPEN if found else CellVerdict.KEPT
                )
            return CellVerdict.OPEN if CellVerdict.OPEN in verdicts else CellVerdict.KEPT

    def _tail_by_phase(self, sign: int) -> Leaf | None:
        """Of a parameter that only turns a phase: a long delay has any phase somewhere in any piece of the band."""
        if sign < 0:
            return None
        for condition in self.conditions.values():
            bound = _bound_by_phase(pieces(condition), self.free, self.band)
            if bound is not None:
                return Leaf(bound, None, CellVerdict.BROKEN)
        with flint.ctx.workprec(BITS):
            far = long(self._single, self.free, self.band) if self._single else None
        return None if far is None else Leaf(far, None, CellVerdict.BROKEN)


def _bound_by_phase(own: Sequence[RealFunction], free: Symbol, band: tuple[Expr, Expr]) -> Fraction | None:
    """From where on a delay breaks a condition: at one phase it is broken on a piece of the band, which holds all phases."""
    axis, tops = own[0].axis, [piece.function.numerator for piece in own]
    turning = [i for i, angle in enumerate(axis.angles) if angle.rate.has(free)]
    if len(turning) != 1 or any(top.degrees()[axis.meanings.index(free)] for top in tops):
        return None
    index, rate = axis.size + turning[0], axis.angles[turning[0]].rate.diff(free)
    if axis.angles[turning[0]].constant:
        return None
    found: list[Interval] = []
    for tangent in (1, -1, 3, -3):
        table = chart(
            {i: RealFunction(axis.function(top.subs({f"x{index}": tangent}))) for i, top in enumerate(tops)}, *band
        )
        found += table.where(lambda signs: min(signs.values()) > 0)
    lengths = [float(x.high.omega) - float(x.low.omega) for x in found]
    if not lengths or not max(lengths) > 0:
        return None
    # a hundredth off the length makes up for the rounding of floats
    return Fraction(2 * float(pi) / (float(rate) * max(lengths) * 0.99))


def _binding(criterion: Criterion, place: CriticalPlace, value: Edge | Summit | Corner) -> Binding:
    if place.kind is Kind.TOUCH:
        assert not isinstance(value, Edge)
        return Binding(criterion, ZeroAt(value) if isinstance(value, Corner) else MaximumAt(value), place.kind)
    assert isinstance(value, Edge)
    return Binding(criterion, ExactNumber(value.place), place.kind)


def _not_below(x: Fraction) -> Fraction:
    """A double that is not smaller."""
    found = Fraction(float(x))
    return found if found >= x else Fraction(nextafter(float(x), inf))


def _middle(low: Fraction, high: Fraction) -> Fraction:
    """A dyadic number inside, between numbers of one sign nearer their geometric mean; never a simple one."""
    a, b = float(low), float(high)
    if a >= 0 and (a == 0 or b / a > 4):
        cut = sqrt(a * b) if a > 0 else b / 16
    elif b <= 0 and (b == 0 or a / b > 4):
        cut = -sqrt(a * b) if b < 0 else a / 16
    else:
        cut = a + (b - a) * 0.4970703125
    return Fraction(cut) if a < cut < b else (low + high) / 2
