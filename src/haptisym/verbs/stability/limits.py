"""For which values of one parameter is a display stable in a hand, or steady: the one question of
requirements, limits and margins.

The loop of a display, felt as H_perc(s), and a hand, m s^2 + b s + k, has the roots of H_perc + m
s^2 + b s + k. *Stable*: none lies in Re s >= 0. *Steady*: none but those at s = 0 that are there as
nothing holds the handle in place (a *drift*).

Roots move continuously with the parameter q, so that their number in Re s >= 0 can change only at a
*critical value*, at which one lies on the imaginary axis or comes from infinity (``critical``).
Hence:

1. Between two neighbouring critical values the verdict is the same for all q. The roots are counted
   exactly at one of them (``Loop.roots_at``), and from there on by the pairs that cross the axis
   (``Tally``).
2. Where critical values are not all known, an interval may still be proven to have no stable value,
   as some root stays on the right throughout (``RootTendency``).

All values are searched that are asked about; a *near* set only as far as the ends of what holds
about the present value, or of what holds next to it where that fails. What is not proven is
undecided, with a reason. Begin with ``stable_values``; loops with a clock are in ``sampled``.
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
from haptisym.kernel.reals import (
    ExactNumber,
    RealNumber,
    Way,
    expression_ball,
    in_unit,
    ordered,
    printed,
)
from haptisym.kernel.rings import s
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
from haptisym.verbs.stability.critical import critical_values
from haptisym.verbs.stability.held import drifts, moved, unstable_roots
from haptisym.verbs.stability.loops import CriticalRoot, Loop
from haptisym.verbs.stability.roottendency import RootTendency
from haptisym.verbs.stability.sampled import clocked_question

# Working precision, bits, with which C(j omega; q) is shown not to be 0 at a critical value.
_BITS = 256
# Windows about a value that are looked at without telling of them, as the next one replaces each.
_FIRST = 7


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
    """The values that are stable, or steady. UndecidedError where nothing is known."""
    if free.parts:  # a threshold moves no root
        return ValueSet.all_of(asked, holds=_holds_at(scene, hand, criterion))
    bare = unclocked(moved(scene, hand, free, free.symbol)[0])
    if clocks(scene) and not clocks(bare):
        scene = unclocked(scene)
        # The clock held no force and is gone, and with it the parameters that acted on it alone.
        if not free.is_of_hand and free.path not in {x.path for x in scene.knobs}:
            return ValueSet.all_of(asked, holds=_holds_at(scene, hand, criterion))
    # Of a display with nothing to feel the loop need exist, but not the distortion, a ratio to the
    # environment.
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
    # An end at which there is no display does not belong to what holds, be it asked about or not.
    first, last = (x is not None and all(ordered(x, value) for value in gone) for x in asked.ends)
    asked = replace(
        asked, holds_low=asked.holds_low and first, holds_high=asked.holds_high and last
    )
    return solve(question, asked, reach, near=near).without([x for x in gone if asked.holds(x)])


def open_beside(knob: Knob, found: ValueSet) -> list[str]:
    """The reasons why the values next to those about the present one are undecided, at most one for
    each side; none where they are decided."""
    pieces = dict.fromkeys(x for x, is_open in _unknown(knob, found) if x is not None and is_open)
    return [_why(knob, found, x) for x in pieces]


def looked_at(knob: Knob, found: ValueSet) -> tuple[RealNumber | None, RealNumber | None]:
    """Between which values a number was looked at, where that has an end: None where it has none,
    or is open anyway."""
    (below, is_open), (above, is_open_above) = _unknown(knob, found)
    low = None if below is None or is_open else below.high
    return low, None if above is None or is_open_above else above.low


def _unknown(knob: Knob, found: ValueSet) -> list[tuple[Piece | None, bool]]:
    """The first undecided piece below and above the present value (None: none), and whether it
    leaves the answer about that value open.

    Where it fails there, and holds beside that, the rest is a matter of how far was looked.
    """
    present = ExactNumber(knob.value)
    home = found.about(present)
    is_answered = home.verdict is Verdict.FAILS and bool(found.feasible)
    unknown: list[tuple[Piece | None, bool]] = []
    for side in (-1, 1):
        x = found.unknown(present, side)
        # It is that about the present value itself, or has an end in common with it.
        is_near = x is not None and (x == home or not {*home.ends}.isdisjoint(x.ends))
        unknown.append((x, not is_answered and is_near and x in found.undecided))
    return unknown


def _why(knob: Knob, found: ValueSet, x: Piece) -> str:
    """The reason of an undecided piece, with the values between which it lies."""
    unit = knob.shown_unit(knob.motion)

    def end(value: RealNumber | None, way: Way) -> str:
        if value is None:
            return ""
        return f"{printed(in_unit(value, unit.size), 4, way)} {unit.text}".rstrip()

    low, high = end(x.low, Way.DOWN), end(x.high, Way.UP)
    intervals = [y for y in found.pieces if not y.is_single]
    if len(intervals) == 1 or not (low or high):  # that is all there is
        return x.reason
    if low and high:
        return f"{x.reason}, from {low} to {high}"
    return f"{x.reason}, above {low}" if low else f"{x.reason}, below {high}"


def _holds_at(scene: Scene, hand: Hand, criterion: Criterion) -> bool | None:
    """Whether a display is stable in a hand, or steady; None where the roots at rest stay open."""
    number = unstable_roots(scene, hand).number
    if not number or criterion.name != STEADY:
        return number == 0
    still = drifts(scene, hand)
    return None if still is None else number == still


@dataclass(frozen=True)
class _Asked:
    """One question about a display without a clock, for ``solve``.

    ``near`` : as of ``stable_values``. ``in_air`` : whether a value may leave no force at all.
    """

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
        """The question: critical values, a verdict between each two of them, and intervals without
        any stable value."""
        loop = self.loop
        tally, one_way = Tally(loop, drifts=self._drifts), RootTendency(loop)

        def changes() -> Iterator[CriticalValues]:
            # Each window replaces the one before it: the first ones are held back, unless they are
            # complete, or an end next to the present value is all that is asked for.
            held_back: CriticalValues | None = None
            try:
                for n, found in enumerate(critical_values(loop, self.free.value, self.asked)):
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
            is_there = loop.exists(value) and self._is_there(value, tally.window)
            return is_there and tally.at(value) == 0

        def cells(low: RealNumber | None, high: RealNumber | None) -> Iterable[Cell]:
            if one_way.is_unstable_throughout(low, high):
                return [Cell(low, high, holds=False)]
            return []

        return Question(verdict, self.free.value, changes, lambda x: _is_clear(loop, x), cells)

    def _is_there(self, value: Rational, window: CriticalValues | None) -> bool:
        """Whether the scene exists at a value: looked at where that is critical or 0, as a formula
        may be divided by 0 there."""
        places = () if window is None else (x.value for x in window.values)
        critical = {x.value for x in places if isinstance(x, ExactNumber)} | {Integer(0)}
        return value not in critical or allowed(self.scene, self.free, value, in_air=self.in_air)

    def _drifts(self, value: Expr) -> int | None:
        """How many roots at 0 are drifts at a value, for a steady display; None where that is not
        known. Of a stable one none may be there."""
        if self.criterion.name != STEADY:
            return 0
        return drifts(*moved(self.scene, self.hand, self.free, value))

    def _named(self, found: CriticalValues) -> CriticalValues:
        """The critical values, each with what binds there: a root on the axis at a frequency, or at
        infinity."""
        named = [CriticalValue(x.value, (self._binding(x),)) for x in found.values]
        return replace(found, values=named)

    def _binding(self, x: CriticalValue) -> Binding:
        omega = x.omega if isinstance(x, CriticalRoot) else None
        return Binding(self.criterion, omega, Kind.FAR if omega is None else Kind.AXIS)


@dataclass
class Tally:
    """The number of roots of a loop in Re s >= 0, at one value of its parameter after the other.

    ``window`` : the critical values that are known by now. ``known`` : the numbers that were
    counted, by value. ``drifts`` : of a value, how many roots at 0 are not counted, as they are
    there because nothing holds the handle in place.
    """

    loop: Loop
    window: CriticalValues | None = None
    known: dict[Expr, int] = field(default_factory=dict)
    drifts: Callable[[Expr], int | None] = lambda _: 0

    def at(self, value: Rational) -> int | None:
        """The number of roots; None if they are infinitely many, or come as near to the axis as one
        likes."""
        by_crossings = self._from_another(value)
        if by_crossings is not None:
            return by_crossings
        roots = self.loop.roots_at(value)
        number = roots.number
        # Frequencies ascend: only if the first one is 0 is there a root at rest.
        if number and roots.on_axis and not ordered(roots.on_axis[0], ExactNumber(Integer(0))):
            still = self.drifts(value)
            if still is None:
                raise UndecidedError("how many roots at rest only drift")
            number -= still
        if number is not None and roots.chain is None:
            self.known[value] = number
        return number

    def _from_another(self, value: Expr) -> int | None:
        """The number by that at the nearest value that was counted; None where not all that crosses
        the axis on the way there is known."""
        if value in self.known or not self.known or self.window is None:
            return self.known.get(value)
        nearest = min(self.known, key=lambda x: abs(x - value))
        low, high = (ExactNumber(x) for x in sorted((nearest, value)))
        if any(_meets(part, low, high) for part in self.window.open):
            return None
        crossings = 0
        for x in self.window.values:
            to_low, to_high = ordered(low, x.value), ordered(x.value, high)
            if to_low < 0 or to_high < 0:
                continue  # not between the two
            # At an end that is critical itself some roots lie on the axis: no sum of crossings
            # tells how many.
            if not to_low or not to_high:
                return None
            if not isinstance(x, CriticalRoot) or x.sense is None:
                return None
            crossings += x.sense
        # Each crossing above omega = 0 has its mirror image below: two roots for one sense.
        direction = 1 if value > nearest else -1
        return self.known[nearest] + direction * 2 * crossings


def _meets(part: Open, low: RealNumber, high: RealNumber) -> bool:
    """Whether an open interval reaches between two values."""
    before = part.high is not None and ordered(part.high, low) >= 0
    return not before and not (part.low is not None and ordered(high, part.low) >= 0)


def _is_clear(loop: Loop, x: CriticalValue) -> bool:
    """Whether no root lies on the axis at a critical value after all, as where all but the hand's
    damping vanish at omega = 0. False proves nothing."""
    frequencies = [binding.omega for binding in x.bindings]
    if loop.has_q_in_exponent or None in frequencies:
        return False
    return not any(_on_axis(loop, x.value, y).contains(0) for y in frequencies if y is not None)


def _on_axis(loop: Loop, value: RealNumber, omega: RealNumber) -> Any:
    """A ball around C(j omega; q), the numerator of the loop, at a value and a frequency."""
    with flint.ctx.workprec(_BITS):
        at = acb(0, omega.ball(_BITS))
        q = acb(value.ball(_BITS))
        known: dict[Expr, Any] = {s: at, pi: acb(arb.pi()), loop.symbol: q}
        for lag in loop.ring.lags:
            known[exp(-s * lag)] = (-at * expression_ball(lag)).exp()
        for order in loop.ring.orders:
            known[s**order] = at ** acb(expression_ball(order))
        return acb(loop.ring.ball(loop.numerator, known))
