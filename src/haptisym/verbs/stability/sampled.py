"""For which values of one parameter is a display with a clock stable in a hand.

The number of roots in |z| >= 1 changes only at critical values, which put a root on the unit circle
(``opened``; ``criticaldelays`` for a delay), or at which roots jump over it (``Opened.jumps_at``):
between two of them one exact count tells. They are found from the present value outward, on both
sides in intervals that grow. How far that goes is bounded, and the answer says how far. It reaches
down to 0 where all values on the way are clear at once, and has no upper end where Colgate and
Schenkel's condition is met with the hand's damping: then more damping, or any mass or stiffness,
puts no root on the circle. Begin with ``clocked_question``, which ``limits`` asks; the search is
``OutwardSearch``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise
from typing import Protocol, TypeAlias

from sympy import Expr, Rational, Symbol

from haptisym.judge.bindings import STEADY, Binding, Kind
from haptisym.judge.colgate import sampled_passivity
from haptisym.judge.crossings import Criterion
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, rational
from haptisym.kernel.sets import (
    STOPPED,
    UNSEARCHED,
    CriticalValue,
    CriticalValues,
    Domain,
    Open,
    Question,
)
from haptisym.model.catalogue import Hand, device
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene
from haptisym.model.valueranges import searched
from haptisym.verbs.stability.clockedloop import clock_of, clocked_roots, loop_of
from haptisym.verbs.stability.criticaldelays import CriticalDelays
from haptisym.verbs.stability.held import drifts, moved
from haptisym.verbs.stability.opened import Opened, Passage, Span, joined

# Intervals that are looked at on a side; the fewer where only the nearest end is asked for.
_MOST, _MOST_NEAR = 500, 80
# Whole samples of delay of a loop whose roots are counted: each adds one to the degree.
MOST_SAMPLES = 64
# How many times quicker a clock is looked at for its nearest limit.
_CLOCK = 32
# The length of the first interval, relative to its value, each next one being twice as long; and
# the ratio of a value to the one before it on the way down to 0. No simple ratios, so that no
# interval ends at a simple number: a limit there would be at the end of two, settled in neither.
_FIRST, _DOWN = Fraction(33, 511), Fraction(33, 67)
_NOT_SEARCHED = "that far it was not searched"
_NOT_FINE = "whether roots come to the unit circle: the search was not fine enough"


def clocked_question(
    scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion, *, near: bool = False
) -> Question:
    """The question for which values of a parameter of hand or display it is stable, or steady, as
    ``criterion`` says.

    ``near`` : only up to the nearest ends, as of ``solve``.
    """

    def rests(value: Rational, *, own: bool) -> bool | None:
        """Whether a value with roots on the circle will do: as they cancel, or only drift.

        ``own`` : some roots are on the circle at that value alone, not at all values.
        """
        try:
            there = moved(scene, hand, free, value)
            found = clocked_roots(*there)
        except SceneError:
            return False
        if found.right or not found.number:
            return False if found.right else own or None
        still = drifts(*there) if criterion.name == STEADY else 0
        return None if still is None else still == found.number

    def enough(value: Fraction) -> bool:
        return is_held(scene, hand, free, rational(value))

    @cache
    def search() -> OutwardSearch:
        if free.rule not in (Rule.POSITIVE, Rule.NONNEGATIVE, Rule.ANY):
            raise UndecidedError("an order in a sampled loop")
        loop = Opened(loop_of(*moved(scene, hand, free, free.symbol)), free.symbol)
        return OutwardSearch(
            loop, free.value, asked, searched(free, asked), rests, enough, near=near
        )

    return question_of(search, free.value, criterion)


def question_of(search: Callable[[], OutwardSearch], own: Expr, criterion: Criterion) -> Question:
    """The question for ``solve``; ``search`` is made only when something is asked."""

    def changes() -> Iterator[CriticalValues]:
        for found, open_ in search().known():
            values = [
                CriticalValue(x.value, (Binding(criterion, x.omega, Kind.AXIS),)) for x in found
            ]
            jump = (Binding(criterion, None, Kind.FAR),)
            yield CriticalValues(
                [*values, *(CriticalValue(x, jump) for x in search().jumps)], open_
            )

    return Question(lambda value: search().holds(value), own, changes, at=lambda _: False)


Frontier: TypeAlias = tuple[Fraction, str] | None
"""Up to which value something is known, and why not beyond; None where it is known beyond too."""


class Rests(Protocol):
    """Whether a value that puts roots on the circle will do; ``own`` : some of them are there at
    that value alone."""

    def __call__(self, value: Rational, *, own: bool) -> bool | None:
        """None: undecided."""


def _never(value: Rational, *, own: bool) -> bool | None:
    """The verdict where nothing cancels and nothing drifts: a root on the circle is one."""
    return False


@dataclass
class OutwardSearch:
    """The search for critical values of one parameter of a loop, outward from its ``own`` value.

    ``asked`` : the values asked about; ``reach`` : from where to where they are looked at.
    ``rests`` : the verdict on a value with roots on the circle. ``enough`` : whether all values
    from one on are known to do. ``near`` : as of ``solve``. ``found`` : values with a root on the
    circle, but at z = 1; ``left`` : intervals that stay open. ``jumps`` : values at which roots
    may jump (``Opened.jumps_at``).
    """

    loop: Opened
    own: Expr
    asked: Domain
    reach: tuple[Expr, Expr]
    rests: Rests = _never
    enough: Callable[[Fraction], bool] = lambda _: False
    near: bool = False
    found: list[Passage] = field(default_factory=list)
    left: list[Span] = field(default_factory=list)
    jumps: list[RealNumber] = field(default_factory=list)

    @cached_property
    def _late(self) -> CriticalDelays | None:
        """The search by curves, where the parameter is a delay of all that moves; else None."""
        if not self.loop.is_late:
            return None
        # A rational delay, which the scene's own is not if it is a multiple of pi.
        reference_delay = rational(_fraction(self.own, 1))
        return CriticalDelays.of(self.loop, reference_delay, self._ends()[1])

    def holds(self, value: Rational) -> bool | None:
        """Whether the loop is stable at a value, by an exact count; None where that stays open."""
        if self._late and (found := self._late.is_stable_at(value)) is not None:
            return found
        if not value and self.loop.swing:
            return False
        if self.loop.samples(value) > MOST_SAMPLES:
            raise UndecidedError(f"a loop that is more than {MOST_SAMPLES} samples late")
        try:
            outside, at_1 = self.loop.at(value).unstable()
        except UndecidedError:
            return self.rests(value, own=True)
        return (
            self.rests(value, own=at_1 > self.loop.always) if at_1 and not outside else not outside
        )

    def known(self) -> Iterator[tuple[list[Passage], list[Open]]]:
        """The critical values that are known, and where more of them may be; each yield replaces
        the one before."""
        if self.loop.is_fixed:
            yield [], []
            return
        if self._late:
            yield from self._of_a_delay(self._late)
            return
        low, high = self._ends()
        start = min(max(_fraction(self.own, 1), low), high)
        self.jumps += self.loop.jumps_at(start)
        sides = {-1: self._side(-1, start, low), 1: self._side(1, start, high)}
        # Both sides in turn, so that when time runs out the nearest values on either are known.
        beyond: dict[int, Frontier] = dict.fromkeys(sides, (start, STOPPED))
        while sides:
            for side, frontier in [*sides.items()]:
                try:
                    beyond[side] = next(frontier)
                except StopIteration:
                    del sides[side]
                    continue
                yield [*self.loop.at_rest, *self.found], self._open(beyond)

    def _of_a_delay(self, late: CriticalDelays) -> Iterator[tuple[list[Passage], list[Open]]]:
        """What ``known`` yields for a delay, by the curves along which a root is on the circle."""
        _, high = self._ends()
        for known in late.advance_to(high):
            self.left = late.undecided
            yield late.passages, self._open({1: (known, STOPPED)})
        last = late.frontier
        is_whole = last is None or (last >= high and self.asked.high is not None)
        yield (
            late.passages,
            self._open(
                {1: None if is_whole or last is None else (min(last, high), self._not_searched)}
            ),
        )

    def _open(self, beyond: Mapping[int, Frontier]) -> list[Open]:
        """The values about which nothing is known: those beyond what was looked at, and where that
        was not fine enough."""
        open_ = [
            Open(ExactNumber(rational(low)), ExactNumber(rational(high)), _NOT_FINE)
            for low, high in self.left
        ]
        for side, last in beyond.items():
            if last is not None:
                end = ExactNumber(rational(last[0]))
                open_.append(Open(None, end, last[1]) if side < 0 else Open(end, None, last[1]))
        return open_

    def _ends(self) -> tuple[Fraction, Fraction]:
        """The range of values that is looked at; down to 0 where what is asked about ends there."""
        low, high = self.reach
        low = self.asked.low if self.asked.low is not None and not self.asked.low else low
        return _fraction(low, -1), _fraction(high, 1)

    def _side(self, side: int, at: Fraction, end: Fraction) -> Iterator[Frontier]:
        """Up to where all is known on one side, after each interval; None at last where it is known
        to the end."""
        left, step = _MOST_NEAR if self.near else _MOST, (abs(at) or abs(end) / 10**6) * _FIRST
        least = (
            at / _CLOCK
            if self.near and self.loop.is_of_clock
            else _fraction(abs(self.reach[0]), -1)
        )
        is_down = side < 0 == end  # by about halves, as far as a least one
        verdicts = [self._told(at)] if self.near else []
        if side > 0 and self.enough(at):
            yield None
            return
        while at != end and left > 0 and not (is_down and at < least) and not _is_enough(verdicts):
            # An interval that would pass 0 ends there, and the next one begins there.
            loop, last = self.loop.piece(at, Fraction(0) if at * end < 0 else end)
            # The rest is clear at once, or else cut off after one step.
            if last != end or loop.most((at, end)) != 0:
                ahead = Fraction(float(at * _DOWN if is_down else at + side * step))
                last = min(ahead, last) if side > 0 else max(ahead, last)
            looked = loop.passages((at, last), left)
            self.found += looked.found
            self.left = joined([*self.left, *looked.left])
            at, step, left = looked.end, 2 * step, left - looked.number
            jumps = self.loop.jumps_at(at)
            self.jumps += jumps
            yield at, STOPPED
            # Beyond a jump the next interval tells.
            verdicts += [self._told(at)] if self.near and not jumps else []
        is_asked = (self.asked.low, self.asked.high)[side > 0] is not None
        if (
            (at == end and is_asked)
            or (side > 0 and self.enough(at))
            or (is_down and not self.near and at < least)
        ):
            yield None  # what holds for the least value that is searched holds next to 0
        else:
            yield at, self._not_searched if left > 0 or self.near else _NOT_FINE

    @property
    def _not_searched(self) -> str:
        """The reason why nothing is known beyond what was looked at."""
        return UNSEARCHED if self.near else _NOT_SEARCHED

    def _told(self, value: Fraction) -> bool | None:
        with suppress(UndecidedError):
            return self.holds(rational(value))
        return None


def _is_enough(verdicts: Sequence[bool | None]) -> bool:
    """Whether verdicts from the present value outward show all that a near set asks for: where what
    holds ends, and where it fails at first, also where it begins.

    True as well where one verdict stays open, as nothing beyond it is near.
    """
    changes = sum(a != b for a, b in pairwise(verdicts))
    return None in verdicts[1:] or changes > (not verdicts[:1] or not verdicts[0])


def _fraction(x: Expr, side: int) -> Fraction:
    """A number as a fraction; if it is not rational, one close to it on the side given."""
    if isinstance(x, Rational):
        return Fraction(int(x.p), int(x.q))
    return ExactNumber(x).bounds(64)[side > 0]


def is_held(scene: Scene, hand: Hand, free: Knob, value: Rational) -> bool:
    """Whether a display is proven stable for all values of a parameter from one on, by Colgate and
    Schenkel's condition with the hand's damping, whatever its mass."""
    symbol = free.symbol
    if any(p.symbol == symbol for p in hand.parameters):
        hand = hand.with_values({symbol.name: value})
    elif _only_adds(scene.with_values({free.path: symbol}), symbol):
        scene = scene.with_values({free.path: value})
    else:
        return False
    found = sampled_passivity(scene)
    try:
        return found is not None and found.is_held_by(hand.b.value, hand.k.value)
    except UndecidedError:
        return False


def _only_adds(scene: Scene, symbol: Symbol) -> bool:
    """Whether a symbol adds mass, damping or stiffness behind the clock, and is nowhere else."""
    place, clock = clock_of(scene)
    felt = scene.rendering.H
    before = [x for effect in scene.effects[:place] for x in effect.matrix]
    if any(
        x.has(symbol) for x in (felt, *before, *clock.matrix, *(p.value for p in clock.parameters))
    ):
        return False
    devices = [
        device(x) for x in scene.effects[place + 1 :] if any(y.has(symbol) for y in x.matrix)
    ]
    slopes = [x.diff(symbol) for own in devices if own for x in own]
    return None not in devices and all(x.is_number and x >= 0 for x in slopes)
