"""How far a number may go before the display shakes: the nearest values at which the number of unstable roots changes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import flint
from sympy import Expr, Integer, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, rational_between
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.shown import Shown
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.parameters import Rule
from haptisym.model.scene import Scene
from haptisym.verbs.stability.boundary import Meeting, Meetings, from_infinity, meetings
from haptisym.verbs.stability.clockcritical import passages
from haptisym.verbs.stability.loops import Loop

_BITS = 600  # at which values that are still alike count as one

Count: TypeAlias = tuple[int | None, RootChain | None]


@dataclass(frozen=True, repr=False)
class Critical(Shown):
    """A value of a number at which the count of roots in Re s >= 0 changes: ``below`` and ``above`` it, None if infinite.

    ``omega`` : the frequency at which roots then lie on the axis, rad/s; None where they come from infinity. Beside a chain
    of infinitely many the count is that of one value only: as a chain leaves, more and more of its roots may stay behind.
    """

    path: str
    value: RealNumber
    omega: RealNumber | None
    below: int | None
    above: int | None

    def _line(self) -> str:
        return f"{self.path} = {self.value.digits(6)}"

    @property
    def chain_side(self) -> str | None:
        """``above`` or ``below``, where infinitely many roots lie on the right on that side."""
        return "above" if self.above is None else "below" if self.below is None else None

    @property
    def stable_side(self) -> str | None:
        """``above``, ``below``, or None where it is stable on neither side, or a chain leaves that open."""
        if self.chain_side:
            return None
        return "above" if self.above == 0 else "below" if self.below == 0 else None


@dataclass(frozen=True)
class Nearest:
    """The nearest values below and above at which the count changes, as far as they are there; ``reason`` : what stayed open.

    ``low``, ``high`` : the values that were looked at, if not all were; up to a value that was found all are.
    """

    path: str
    found: tuple[Critical, ...] = ()
    reason: str = ""
    low: Fraction | None = None
    high: Fraction | None = None


def critical(scene: Scene, hand: Hand, free: Knob) -> Nearest:
    """How far a number of the hand or of the display may go, either way, before the count of unstable roots changes."""
    try:
        if clocks(scene):
            found = passages(scene, hand, free)
            rows = tuple(Critical(free.path, x.value, x.omega, x.below, x.above) for x in found.found)
            return Nearest(free.path, rows, low=found.low, high=found.high)
        return Nearest(free.path, _Walk(Loop.of(scene, hand, free), free).found())
    except UndecidedError as error:
        return Nearest(free.path, reason=str(error))


_ENDS: dict[Rule, tuple[Expr | None, Expr | None, bool]] = {
    Rule.POSITIVE: (Integer(0), None, False),
    Rule.NONNEGATIVE: (Integer(0), None, True),
    Rule.ANY: (None, None, True),
    Rule.FRACTION: (Integer(0), Integer(1), False),
}
"""The values that a rule allows, and whether its ends belong to them."""


@dataclass(frozen=True)
class _Line:
    """Different meetings in order, between two ends; None where nothing bounds them.

    ``is_whole`` : whether nothing is allowed beyond the low end, and beyond the high one.
    """

    places: list[Meeting]
    low: RealNumber | None
    high: RealNumber | None
    is_whole: tuple[bool, bool]

    def cell(self, i: int) -> tuple[RealNumber | None, RealNumber | None]:
        """Before the i-th meeting."""
        low = self.places[i - 1].value if i else self.low
        return low, self.places[i].value if i < len(self.places) else self.high


class _Walk:
    """From a value on, meeting after meeting, until the count changes."""

    def __init__(self, loop: Loop, free: Knob) -> None:
        self.loop, self.free, self.start = loop, free, ExactNumber(free.value)
        self.low, self.high, self.closed = _ENDS[free.rule]
        self.counts: dict[Expr, Count] = {}

    def found(self) -> tuple[Critical, ...]:
        """The nearest below and the nearest above, as far as they are there."""
        sides: dict[int, Critical | None] = {}
        for line in map(self._line, self._windows()):
            if (here := self._here(line)) is not None:
                return (here,)
            sides |= {side: x[0] for side in (-1, 1) if side not in sides and (x := self._side(line, side))}
            if len(sides) == 2:
                return tuple(x for x in (sides[-1], sides[1]) if x is not None)
        raise UndecidedError("where roots meet the imaginary axis at ever higher frequencies")

    def _windows(self) -> Iterator[Meetings]:
        value = self.free.value
        if isinstance(value, Rational) and self._at(value)[1]:  # a chain is there until a chain is lost
            yield Meetings(from_infinity(self.loop))
        else:
            yield from meetings(self.loop, value)

    def _line(self, window: Meetings) -> _Line:
        known = [x for x in window.found if x.value.ball(_BITS).is_finite()]
        known.sort(key=lambda x: x.value.ball(_BITS).mid())
        apart = [x for i, x in enumerate(known) if i == 0 or _order(known[i - 1].value, x.value)]
        low, low_is_whole = _nearer(window.above, self.low, -1)
        high, high_is_whole = _nearer(window.below, self.high, 1)
        within = [
            x for x in apart
            if (low is None or _order(low, x.value) >= 0) and (high is None or _order(x.value, high) >= 0)
        ]  # fmt: skip
        return _Line(within, low, high, (low_is_whole, high_is_whole))

    def _here(self, line: _Line) -> Critical | None:
        """Where the very value puts roots on the axis, and the count is another one on either side."""
        for i, x in enumerate(line.places):
            if not _order(x.value, self.start):
                below, above = self._count(line, i), self._count(line, i + 1)
                return None if below is None or above is None or below == above else self._critical(x, below, above)
        return None

    def _side(self, line: _Line, side: int) -> tuple[Critical | None] | None:
        """The nearest on one side; (None,) where there is none, None where it lies beyond the window."""
        ahead = [i for i, x in enumerate(line.places) if _order(self.start, x.value) == side]
        home: Count | None = None
        for i in ahead if side > 0 else ahead[::-1]:
            near, beyond = (self._count(line, i + (n if side > 0 else 1 - n)) for n in (0, 1))
            home = home or near
            if None not in (home, beyond) and beyond != home:
                below, above = (home, beyond) if side > 0 else (beyond, home)
                return (self._critical(line.places[i], below, above),)
        return (None,) if line.is_whole[side > 0] else None

    def _count(self, line: _Line, i: int) -> Count | None:
        """Before the i-th meeting; at an end of what is allowed, where a meeting is there; None where nothing is allowed."""
        low, high = line.cell(i)
        if low is None or high is None or _order(low, high):
            return self._at(rational_between(low, high))
        end = self.high if i else self.low
        with suppress(UndecidedError):  # what is asked about need not end there
            return self._at(end) if self.closed and end is not None else None
        return None

    def _at(self, value: Expr) -> Count:
        if value not in self.counts:
            found = self.loop.at(Rational(value))
            self.counts[value] = found.number, found.chain
        return self.counts[value]

    def _critical(self, x: Meeting, below: Count | None, above: Count | None) -> Critical:
        assert below is not None
        assert above is not None
        return Critical(self.free.path, x.value, x.omega, below[0], above[0])


def _nearer(window: Expr | None, allowed: Expr | None, side: int) -> tuple[RealNumber | None, bool]:
    """Of the ends of a window and of what is allowed the nearer one, and whether it is the latter."""
    if window is None or allowed is None:
        end = window if allowed is None else allowed
        return None if end is None else ExactNumber(end), window is None
    is_whole = _order(ExactNumber(allowed), ExactNumber(window)) * side >= 0
    return ExactNumber(allowed if is_whole else window), is_whole


def _order(x: RealNumber, y: RealNumber) -> int:
    """1 where y is beyond x, -1 where it is before it, 0 where they are alike as far as bits go."""
    with flint.ctx.workprec(_BITS):
        change = y.ball(_BITS) - x.ball(_BITS)
        return int(change > 0) - int(change < 0)
