"""For which values of a number is a display stable in a hand, or steady: the one question of
requirements, limits and margins.

*Stable*: no root of H_perc + m s^2 + b s + k lies in Re s >= 0. *Steady*: none but those at s = 0
that are there as nothing holds the handle in place. Roots are counted exactly at one value between
each two at which some meet the imaginary axis, and from there on by those that come and go. All
values are searched that are asked about; a *near* set only as far as the ends of what holds about
the present value, or of what holds next to it where that fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational, exp, pi

from haptisym.judge.bindings import STEADY, Binding, Kind
from haptisym.judge.crossings import Criterion
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, Way, expression_ball, in_unit, printed
from haptisym.kernel.rings import s
from haptisym.kernel.roots import ordered
from haptisym.kernel.sets import (
    STOPPED,
    Cell,
    CriticalValue,
    CriticalValues,
    Domain,
    Open,
    Piece,
    Question,
    ValueSet,
    Verdict,
    solve,
)
from haptisym.model.catalogue import Hand
from haptisym.model.existence import allowed, missing
from haptisym.model.scene import Knob, Scene, clocks, unclocked
from haptisym.model.valueranges import searched
from haptisym.verbs.stability.critical import meetings
from haptisym.verbs.stability.held import drifts, moved, unstable_roots
from haptisym.verbs.stability.loops import Loop, Meeting, Tendency
from haptisym.verbs.stability.sampled import clocked_question

_BITS = 256
_FIRST = 7  # windows about a value that are looked at anyway, be they larger than what is searched


def stable_values(
    scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion, *, near: bool = False
) -> ValueSet:
    """All values of those asked about with which a display is stable in a hand, or steady, as the
    criterion says.

    ``near`` : only as far as to know where that ends next to the present value, or begins and ends
    where it fails there.

    >>> from haptisym.judge.bindings import stable_in
    >>> from haptisym.model.catalogue import hands
    >>> from haptisym.model.scenefile import load_scene
    >>> late, arm = load_scene("delayed-spring"), hands["postural-arm"]
    >>> stable_values(late, arm, late.knobs["tau"], Domain(Integer(0), Integer(1)), stable_in(arm), near=True)
    <ValueSet 0 to 0.102549>
    """
    try:
        return _found(scene, hand, free, asked, criterion, near=near)
    except LimitError:
        return ValueSet.all_of(asked, holds=None, reason=STOPPED)
    except UndecidedError as error:
        return ValueSet.all_of(asked, holds=None, reason=str(error))


def _found(
    scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion, *, near: bool
) -> ValueSet:
    """The same. UndecidedError where nothing is known."""
    if free.parts:  # a threshold moves no root
        return ValueSet.all_of(asked, holds=_holds_at(scene, hand, criterion))
    bare = unclocked(moved(scene, hand, free, free.symbol)[0])
    if clocks(scene) and not clocks(bare):
        scene = unclocked(scene)
        if not free.is_of_hand and free.path not in {
            x.path for x in scene.knobs
        }:  # it acts on nothing
            return ValueSet.all_of(asked, holds=_holds_at(scene, hand, criterion))
    in_air = criterion.name == STEADY or scene.closed.env.is_zero
    ends = [x for x in (asked.low, asked.high) if isinstance(x, Rational)]
    gone = missing(scene, free, in_air=in_air)
    gone += [ExactNumber(x) for x in ends if not allowed(scene, free, x, in_air=in_air)]
    reach = Domain(*searched(free, asked))
    if clocks(bare):
        question = clocked_question(scene, hand, free, asked, criterion, near=near)
    else:
        loop = Loop.of(scene, hand, free)
        gone += [ExactNumber(x) for x in ends if not loop.exists(x)]
        question = _Asked(scene, hand, free, asked, criterion, loop, near, in_air).question
    first, last = (x is not None and not any(not ordered(x, y) for y in gone) for x in asked.ends)
    asked = replace(
        asked, holds_low=asked.holds_low and first, holds_high=asked.holds_high and last
    )
    return solve(question, asked, reach, near=near).without([x for x in gone if asked.holds(x)])


def open_beside(knob: Knob, found: ValueSet) -> list[str]:
    """Why it is not known, of values next to those about the present one, whether they are like it:
    on each side."""
    pieces = dict.fromkeys(x for x, is_open in _unknown(knob, found) if x is not None and is_open)
    return [_why(knob, found, x) for x in pieces]


def looked_at(knob: Knob, found: ValueSet) -> tuple[RealNumber | None, RealNumber | None]:
    """Between which values a number was looked at, where that has an end: None where it has none,
    or is open anyway."""
    (below, is_open), (above, is_open_above) = _unknown(knob, found)
    low = None if below is None or is_open else below.high
    return low, None if above is None or is_open_above else above.low


def _unknown(knob: Knob, found: ValueSet) -> list[tuple[Piece | None, bool]]:
    """Of which values below, and above, nothing is known; and whether that leaves open what is so
    about the present value.

    Where it fails there, and holds beside that, the rest is a matter of how far was looked.
    """
    own = ExactNumber(knob.value)
    home = found.about(own)
    is_told = home.verdict is Verdict.FAILS and bool(found.feasible)
    beside = [found.unknown(own, side) for side in (-1, 1)]
    near = [
        x for x in beside if x is not None and (x == home or not {*home.ends}.isdisjoint(x.ends))
    ]
    return [(x, not is_told and x in near and x in found.undecided) for x in beside]


def _why(knob: Knob, found: ValueSet, x: Piece) -> str:
    """The reason, and between which values that is."""
    unit = knob.shown_unit(knob.motion)
    low, high = (
        "" if end is None else f"{printed(in_unit(end, unit.size), 4, way)} {unit.text}".rstrip()
        for end, way in ((x.low, Way.DOWN), (x.high, Way.UP))
    )
    if sum(not y.is_single for y in found.pieces) == 1 or not (low or high):  # that is all there is
        return x.reason
    where = (
        f", from {low} to {high}"
        if low and high
        else f", above {low}"
        if low
        else f", below {high}"
    )
    return f"{x.reason}{where}"


def _holds_at(scene: Scene, hand: Hand, criterion: Criterion) -> bool | None:
    """Whether a display is stable in a hand, or steady."""
    number = unstable_roots(scene, hand).number
    if not number or criterion.name != STEADY:
        return number == 0
    still = drifts(scene, hand)
    return None if still is None else number == still


@dataclass(frozen=True)
class _Asked:
    """What is asked of a display without a clock."""

    scene: Scene
    hand: Hand
    free: Knob
    asked: Domain
    criterion: Criterion
    loop: Loop
    near: bool
    in_air: bool

    @property
    def question(self) -> Question:
        """Between the values that put roots on the axis one count tells all."""
        loop = self.loop
        tally, one_way = Tally(loop, drifts=self._drifts), Tendency(loop)

        def changes() -> Iterator[CriticalValues]:
            held_back: CriticalValues | None = None
            try:
                for n, found in enumerate(meetings(loop, self.free.value, self.asked)):
                    tally.window = held_back = found
                    if self.near or n >= _FIRST or not found.open:
                        yield self._named(found)
                        held_back = None
            except UndecidedError:
                if held_back is not None:
                    yield self._named(held_back)
                raise
            if held_back is not None:
                yield self._named(held_back)

        def verdict(value: Rational) -> bool:
            return (
                loop.exists(value) and self._is_there(value, tally.window) and tally.at(value) == 0
            )

        def cells(low: RealNumber | None, high: RealNumber | None) -> Iterable[Cell]:
            return [Cell(low, high, holds=False)] if one_way.everywhere(low, high) else []

        return Question(verdict, self.free.value, changes, lambda x: _is_clear(loop, x), cells)

    def _is_there(self, value: Rational, window: CriticalValues | None) -> bool:
        """Whether the scene is there at a value that may be critical: formulas may divide by 0."""
        places = () if window is None else (x.value for x in window.values)
        critical = {x.value for x in places if isinstance(x, ExactNumber)} | {Integer(0)}
        return value not in critical or allowed(self.scene, self.free, value, in_air=self.in_air)

    def _drifts(self, value: Expr) -> int | None:
        return (
            drifts(*moved(self.scene, self.hand, self.free, value))
            if self.criterion.name == STEADY
            else 0
        )

    def _named(self, found: CriticalValues) -> CriticalValues:
        """With what binds at each value."""
        return replace(
            found, values=[CriticalValue(x.value, (self._binding(x),)) for x in found.values]
        )

    def _binding(self, x: CriticalValue) -> Binding:
        omega = x.omega if isinstance(x, Meeting) else None
        return Binding(self.criterion, omega, Kind.FAR if omega is None else Kind.AXIS)


@dataclass
class Tally:
    """How many roots a loop has in Re s >= 0, at one value of its open number after the other.

    ``window`` : the values that put roots on the axis, as far as they are known. ``known`` : the
    numbers that were counted, by value. ``drifts`` : of a value, how many roots at 0 are not
    counted, as they only drift.
    """

    loop: Loop
    window: CriticalValues | None = None
    known: dict[Expr, int] = field(default_factory=dict)
    drifts: Callable[[Expr], int | None] = lambda _: 0

    def at(self, value: Rational) -> int | None:
        """The number of roots; None if they are infinitely many, or come as near to the axis as one
        likes."""
        found = self._from_another(value)
        if found is not None:
            return found
        roots = self.loop.at(value)
        number = roots.number
        if number and roots.on_axis and not ordered(roots.on_axis[0], ExactNumber(Integer(0))):
            still = self.drifts(value)
            if still is None:
                raise UndecidedError("how many roots at rest only drift")
            number -= still
        if number is not None and roots.chain is None:
            self.known[value] = number
        return number

    def _from_another(self, value: Expr) -> int | None:
        """From the nearest value that was counted, where all that moves over the axis on the way
        there is known."""
        if value in self.known or not self.known or self.window is None:
            return self.known.get(value)
        nearest = min(self.known, key=lambda x: abs(x - value))
        low, high = (ExactNumber(x) for x in sorted((nearest, value)))
        if any(_meets(part, low, high) for part in self.window.open):
            return None
        between = [
            x
            for x in self.window.values
            if ordered(low, x.value) >= 0 and ordered(x.value, high) >= 0
        ]
        senses = [x.sense for x in between if isinstance(x, Meeting) and x.sense is not None]
        if len(senses) < len(between) or any(
            not ordered(x.value, end) for x in between for end in (low, high)
        ):
            return None
        return self.known[nearest] + (1 if value > nearest else -1) * 2 * sum(senses)


def _meets(part: Open, low: RealNumber, high: RealNumber) -> bool:
    """Whether there is what is open between two values."""
    before = part.high is not None and ordered(part.high, low) >= 0
    return not before and not (part.low is not None and ordered(high, part.low) >= 0)


def _is_clear(loop: Loop, x: CriticalValue) -> bool:
    """Whether no root lies on the axis at a value after all: as where all but the hand's damping
    vanish at omega = 0."""
    places = [b.omega for b in x.bindings]
    return not loop.turns and all(
        y is not None and not _on_axis(loop, x.value, y).contains(0) for y in places
    )


def _on_axis(loop: Loop, value: RealNumber, omega: RealNumber) -> Any:
    """A ball around the characteristic function at a frequency."""
    with flint.ctx.workprec(_BITS):
        at = acb(0, omega.ball(_BITS))
        known: dict[Expr, Any] = {s: at, pi: acb(arb.pi()), loop.symbol: acb(value.ball(_BITS))}
        known |= {exp(-s * lag): (-at * expression_ball(lag)).exp() for lag in loop.ring.lags}
        known |= {s**order: at ** acb(expression_ball(order)) for order in loop.ring.orders}
        return acb(loop.ring.ball(loop.top, known))
