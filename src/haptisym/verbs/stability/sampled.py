"""For which values of a number a display with a clock is stable in a hand.

From the value that the number has, outward on both sides in stretches that grow, all values are
found that put a root on the unit circle: in between one exact count tells. How far that goes is
bounded, and the answer says how far; down to 0 where all values on the way are clear at once.
Upward it has no end where what damps, or is mass or stiffness beside that, puts no root on the
circle, as that damps as Colgate and Schenkel's condition asks.
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
from haptisym.kernel.reals import ExactNumber
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
from haptisym.verbs.stability.held import drifts, moved
from haptisym.verbs.stability.late import Lateness
from haptisym.verbs.stability.opened import Opened, Passage, Span, joined

_MOST, _MOST_NEAR = 500, 80  # stretches that are looked at on a side
MOST_SAMPLES = 64  # late, of a loop whose roots are counted
_CLOCK = 32  # times as quick a clock may be for its nearest limit
# Of a value the first of them, then each is twice as long; and the share of a value that is next on
# the way down to 0.
# Neither ends where a number that was thought out is: a limit there would be at the end of two
# stretches, and told by none.
_FIRST, _DOWN = Fraction(33, 511), Fraction(33, 67)
_NOT_SEARCHED = "that far it was not searched"
_NOT_FINE = "whether roots come to the unit circle: the search was not fine enough"


def clocked_question(
    scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion, *, near: bool = False
) -> Question:
    """For which values of a number of the hand or of the display that is stable, or steady: as
    ``criterion`` says.

    ``near`` : only as far from its own value as ``solve`` then asks.
    """

    def rests(value: Rational, *, own: bool) -> bool | None:
        """Of roots on the circle, at some values of their ``own`` alone: there they may cancel;
        others may only drift."""
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
        return is_held(scene, hand, free, _exact(value))

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
    """For ``solve``; ``search`` is begun as late as something is asked."""

    def changes() -> Iterator[CriticalValues]:
        for found, open_ in search().known():
            yield CriticalValues(
                [CriticalValue(x.value, (Binding(criterion, x.omega, Kind.AXIS),)) for x in found],
                open_,
            )

    return Question(lambda value: search().holds(value), own, changes, at=lambda _: False)


Frontier: TypeAlias = tuple[Fraction, str] | None
"""Up to where something is known, and why it is not beyond; None where it is."""


class Rests(Protocol):
    """Whether a value that puts roots on the circle will do; ``own`` : some of them are there at
    that value alone."""

    def __call__(self, value: Rational, *, own: bool) -> bool | None:
        """None: undecided."""


def _never(value: Rational, *, own: bool) -> bool | None:
    """Of a loop in which nothing cancels and nothing drifts: a root on the circle stays there."""
    return False


def _exact(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


@dataclass
class OutwardSearch:
    """A number of a loop, and how far its values are looked at.

    ``reach`` : from where to where. ``enough`` : whether all values from one on are known to do.
    ``near`` : as of ``solve``.
    ``found``, ``left`` : values with a root on the circle beside z = 1, and stretches that are not
    told.
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

    @cached_property
    def _late(self) -> Lateness | None:
        """Of a delay of all that moves."""
        return Lateness.of(self.loop, self.own, self._ends()[1]) if self.loop.is_late else None

    def holds(self, value: Rational) -> bool | None:
        """Whether it is stable with a value."""
        if self._late and (found := self._late.holds(value)) is not None:
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
        """What is known of the values with a root on the circle, again and again, and where more of
        them may be."""
        if self.loop.is_fixed:
            yield [], []
            return
        if self._late:
            yield from self._of_a_delay(self._late)
            return
        low, high = self._ends()
        start = min(max(_fraction(self.own, 1), low), high)
        sides = {-1: self._side(-1, start, low), 1: self._side(1, start, high)}
        beyond: dict[int, Frontier] = dict.fromkeys(sides, (start, STOPPED))
        while sides:
            for side, frontier in [*sides.items()]:
                try:
                    beyond[side] = next(frontier)
                except StopIteration:
                    del sides[side]
                    continue
                yield [*self.loop.at_rest, *self.found], self._open(beyond)

    def _of_a_delay(self, late: Lateness) -> Iterator[tuple[list[Passage], list[Open]]]:
        """By the curves along which a root is on the circle."""
        _, high = self._ends()
        for known in late.known(high):
            self.left = late.left
            yield late.found, self._open({1: (known, STOPPED)})
        last = late.frontier
        is_whole = last is None or (last >= high and self.asked.high is not None)
        yield (
            late.found,
            self._open(
                {1: None if is_whole or last is None else (min(last, high), self._not_searched)}
            ),
        )

    def _open(self, beyond: Mapping[int, Frontier]) -> list[Open]:
        """The values about which nothing is known: those beyond what was looked at, and where that
        was not fine enough."""
        open_ = [
            Open(ExactNumber(_exact(low)), ExactNumber(_exact(high)), _NOT_FINE)
            for low, high in self.left
        ]
        for side, last in beyond.items():
            if last is not None:
                end = ExactNumber(_exact(last[0]))
                open_.append(Open(None, end, last[1]) if side < 0 else Open(end, None, last[1]))
        return open_

    def _ends(self) -> tuple[Fraction, Fraction]:
        """From where to where is looked: down to 0 where that is an end."""
        low, high = self.reach
        low = self.asked.low if self.asked.low is not None and not self.asked.low else low
        return _fraction(low, -1), _fraction(high, 1)

    def _side(self, side: int, at: Fraction, end: Fraction) -> Iterator[Frontier]:
        """Up to where all is known on one side, again and again."""
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
            loop, last = self.loop.piece(at, Fraction(0) if at * end < 0 else end)
            if last != end or loop.most((at, end)) != 0:
                ahead = Fraction(float(at * _DOWN if is_down else at + side * step))
                last = min(ahead, last) if side > 0 else max(ahead, last)
            looked = loop.passages((at, last), left)
            self.found += looked.found
            self.left = joined([*self.left, *looked.left])
            at, step, left = looked.end, 2 * step, left - looked.number
            yield at, STOPPED
            verdicts += [self._told(at)] if self.near else []
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
        """Why nothing is known beyond what was looked at: nobody asked, where only what is near was
        asked for."""
        return UNSEARCHED if self.near else _NOT_SEARCHED

    def _told(self, value: Fraction) -> bool | None:
        with suppress(UndecidedError):
            return self.holds(_exact(value))
        return None


def _is_enough(verdicts: Sequence[bool | None]) -> bool:
    """Whether it is known where what holds ends, or where it begins and ends, from a value on to
    one side."""
    changes = sum(a != b for a, b in pairwise(verdicts))
    return None in verdicts[1:] or changes > (not verdicts[:1] or not verdicts[0])


def _fraction(x: Expr, side: int) -> Fraction:
    """A number, or one next to it, on that side of it, where it is not rational."""
    if isinstance(x, Rational):
        return Fraction(int(x.p), int(x.q))
    return ExactNumber(x).bounds(64)[side > 0]


def is_held(scene: Scene, hand: Hand, free: Knob, value: Rational) -> bool:
    """Whether from a value of a number on the hand holds the display by what it damps, whatever its
    mass, proven."""
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
