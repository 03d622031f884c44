"""For which values of one parameter a condition holds all over a band, for scenes with delays and powers: by balls.

The values are cut into cells. A cell is *broken* if at one frequency the condition is broken for all its values, *kept* if
it holds for all its values on all of the band, both shown in ball arithmetic. Around an end of the set neither can be; there
the condition is shown to be decided by one place alone, the band's edge or one maximum over frequency, and to change along
the parameter one way only: then there is one end, a zero of a real function, known to any number of digits. What shows
neither way is cut in two, down to cells that are 1e-13 of their values wide.

A delay that is long for the band needs no such cells: whatever its length, it turns the wave to any phase somewhere in every
piece of the band that is long enough. Where the condition is broken at one phase, all over such a piece, it is broken for all
of these values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import groupby, pairwise
from math import sqrt

import flint
from flint import arb
from sympy import Expr, Symbol

from haptisym.judge.crossings import Criterion
from haptisym.kernel.budget import Waiting
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, dyadic, expression_ball
from haptisym.verbs.require.feasible import Binding, Kind
from haptisym.verbs.require.floatcells import Told
from haptisym.verbs.require.freeparameter import Conditions, pieces
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
_STEP, _PIECES, _TANGENTS = 2, 16, (0, 1, -1, 3, -3)
"""How many times a long delay is the one before it; pieces of the band; tangents of half of its phase."""
_VERDICTS = {True: CellVerdict.KEPT, False: CellVerdict.BROKEN}


@dataclass(frozen=True)
class Leaf:
    """Values of the parameter between two numbers, and what is known of them.

    ``value``: of a leaf in which the set ends, where; ``verdict`` is then that of the values below it, ``above`` that above.
    """

    low: Fraction
    high: Fraction
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

    def leaves(self, low: Fraction, high: Fraction) -> list[Leaf]:
        """The values from ``low`` to ``high``, doubles, cut into leaves in order."""
        end = self._turning(low, high) if low > 0 else high
        found = [*self._told(self.quick(float(low), float(end)))]
        return found if end == high else [*found, Leaf(end, high, CellVerdict.BROKEN)]

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
        return sorted(found, key=lambda leaf: leaf.low)

    def _told(self, told: Sequence[Told]) -> Iterator[Leaf]:
        """What floats tell as leaves; what they leave open by cells."""
        for x in told:
            a, b = Fraction(x.low), Fraction(x.high)
            if x.kept is None:
                yield from self._cut(a, b)
            else:
                yield Leaf(a, b, _VERDICTS[x.kept])

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

    def _turning(self, low: Fraction, high: Fraction) -> Fraction:
        """From where on the parameter is a delay that breaks a condition by its phase, if anywhere; else the high end."""
        with suppress(LimitError), flint.ctx.workprec(BITS):
            while low * _STEP < high and any(self._breaks_at_any_phase(high / _STEP, high, x) for x in self._phases):
                high = Fraction(float(high / _STEP))
        return high

    @cached_property
    def _phases(self) -> list[tuple[Ball, Shape]]:
        """Conditions at some phases of the one delay that the parameter is, and how fast that turns along it."""
        found = []
        for f in (x for own in map(pieces, self.conditions.values()) if len(own) == 1 for x in own):
            axis = f.axis
            turning = [i for i, a in enumerate(axis.angles) if a.rate.has(self.free) and not a.constant]
            if len(turning) != 1 or any(x.has(self.free) for x in axis.orders):
                continue
            rate = axis.angles[turning[0]].rate.diff(self.free)
            shape = Shape.of(f, self.free)
            for tangent in _TANGENTS:
                top = shape.polynomial.subs({f"x{axis.size + turning[0]}": tangent})
                degrees = tuple(0 if i == turning[0] else n for i, n in enumerate(shape.degrees))
                if not top.is_zero():
                    found.append((expression_ball(rate), Shape(top, axis, self.free, degrees)))
        return found

    def _breaks_at_any_phase(self, low: Fraction, high: Fraction, phase: tuple[Ball, Shape]) -> bool:
        """Whether a condition is broken at a phase for all values between two, on a piece of the band that holds all phases."""
        rate, shape = phase
        compiled = shape.over(dyadic(low).union(dyadic(high)))
        start, end = (expression_ball(x) for x in self.band)
        edges = [start + (end - start) * i / _PIECES for i in range(_PIECES + 1)]
        broken = [compiled.over(a.union(b))[0] > 0 for a, b in pairwise(edges)]
        longest = max(len(list(run)) if is_broken else 0 for is_broken, run in groupby(broken))
        return bool(rate * dyadic(low) * (end - start) * longest > 2 * arb.pi() * _PIECES)


def _binding(criterion: Criterion, place: CriticalPlace, value: Edge | Summit | Corner) -> Binding:
    if place.kind is Kind.TOUCH:
        assert not isinstance(value, Edge)
        return Binding(criterion, ZeroAt(value) if isinstance(value, Corner) else MaximumAt(value), place.kind)
    assert isinstance(value, Edge)
    return Binding(criterion, ExactNumber(value.place), place.kind)


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
