"""Where one open number puts roots of a neutral loop on the imaginary axis: between values at which chains of roots come to it.

Between two such values there is a chain on the right for all values, or for none. Where there is none no root comes from
infinity, and those on the axis lie below a frequency that is one for all values of an interval. Beside a value at which a chain
comes to the axis it may grow without bound: then there are as many critical values as one likes, and what is nearest to it
stays open.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import flint
from flint import arb
from sympy import Integer, Rational

from haptisym.kernel.alike import each_once, ordered
from haptisym.kernel.reals import ExactNumber, RealNumber, rational_between
from haptisym.verbs.stability.curves import Curve, Gap, Meeting, Meetings
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.reach import Reach, reach_of

_TURNINGS = (40, 120)  # radians that delays turn up to where roots are looked for
_DEEPEST = 40
_BALL = 192


@dataclass(frozen=True)
class _Cell:
    """Values between two; None where nothing bounds them."""

    low: RealNumber | None
    high: RealNumber | None

    @property
    def middle(self) -> Rational:
        """A number inside, twice as far out where there is no bound."""
        if self.low is None and self.high is None:
            return Integer(0)
        if self.low is None or self.high is None:
            inner = self.low or self.high
            assert inner is not None
            far = Rational(2 * abs(int(float(inner))) + 1)
            return far if self.high is None else -far
        a, b = float(self.low), float(self.high)
        middle = Rational((a + b) / 2)
        inside = ordered(self.low, ExactNumber(middle)) > 0 and ordered(ExactNumber(middle), self.high) > 0
        return middle if inside else rational_between(self.low, self.high)

    @property
    def halves(self) -> tuple[_Cell, _Cell]:
        """Before its middle, and beyond."""
        middle = ExactNumber(self.middle)
        return _Cell(self.low, middle), _Cell(middle, self.high)

    def radius(self, reach: Reach, turning: int) -> Rational | None:
        """Beyond which no value in it, nor its ends, puts roots on the axis."""
        low, high = (None if x is None else x.ball(_BALL) for x in (self.low, self.high))
        with flint.ctx.workprec(_BALL):
            if low is not None and high is not None:
                return reach.radius(low.union(high), turning, inverse=False)
            inner = low if high is None else high
            if inner is None or (not inner > 0 if high is None else not inner < 0):
                return None
            return reach.radius((1 / inner).union(arb(0)), turning, inverse=True)

    def is_hopeless(self, reach: Reach, turning: int) -> bool:
        """Whether nothing is known of either end, nor of its middle."""
        places = (self.low, ExactNumber(self.middle), self.high)
        ends = [(arb(0), True) if x is None else (x.ball(_BALL), False) for x in places]
        return all(reach.radius(q, turning, inverse=inverse) is None for q, inverse in ends)


def neutral_meetings(loop: Loop, curve: Curve, far_out: Sequence[Meeting]) -> Iterator[Meetings]:
    """All, but for those in gaps, which become smaller."""
    reach = reach_of(loop)
    clear = cells(loop, far_out)
    for turning in _TURNINGS:
        pieces = [piece for cell in clear for piece in _pieces(cell, reach, turning, _DEEPEST)]
        known = [radius for _, radius in pieces if radius is not None]
        found = curve.meetings(max(known)) if known else ()
        gaps = tuple(_joined([cell for cell, radius in pieces if radius is None]))
        yield Meetings((*far_out, *found), gaps=gaps)
        if not gaps:
            return


def cells(loop: Loop, far_out: Sequence[Meeting]) -> list[_Cell]:
    """Without chains on the right or at the axis, between the values at which these come, as far as a number may go."""
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    inside = [
        x.value for x in far_out
        if (low is None or ordered(low, x.value) > 0) and (high is None or ordered(x.value, high) > 0)
    ]  # fmt: skip
    found = (_Cell(a, b) for a, b in pairwise([low, *each_once(inside, lambda x: x), high]))
    return [x for x in found if loop.at(rational_between(x.low, x.high)).chain is None]


def _pieces(cell: _Cell, reach: Reach, turning: int, depth: int) -> Iterator[tuple[_Cell, Rational | None]]:
    """A cell in pieces, each with its radius; None where none is known."""
    radius = cell.radius(reach, turning)
    if radius is not None or not depth or cell.is_hopeless(reach, turning):
        yield cell, radius
        return
    for half in cell.halves:
        yield from _pieces(half, reach, turning, depth - 1)


def _joined(cells: Sequence[_Cell]) -> Iterator[Gap]:
    """Cells that touch as one."""
    start: RealNumber | None = None
    for i, cell in enumerate(cells):
        if i == 0 or cells[i - 1].high is not cell.low or cell.low is None:
            start = cell.low
        if i + 1 == len(cells) or cells[i + 1].low is not cell.high or cell.high is None:
            yield Gap(start, cell.high)
