"""For which values of one parameter a display is stable in a hand, or with any passive operator.

Exact counts of unstable roots, between the values at which roots reach the imaginary axis, or the unit circle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from itertools import islice
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Rational, exp, pi

from haptisym.judge.bindings import IN_HANDS, STEADY, Binding, Kind, stable_in
from haptisym.judge.crossings import PASSIVE, Criterion
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball
from haptisym.kernel.rings import s
from haptisym.kernel.roots import ordered
from haptisym.kernel.sets import Domain, ValueSet
from haptisym.model.catalogue import Hand, how_to_give
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.model.valueranges import searched
from haptisym.verbs.require.feasible import Question, Solved, Turn, as_set
from haptisym.verbs.require.freeparameter import allowed, missing
from haptisym.verbs.require.passive import solve_passive, solve_sampled
from haptisym.verbs.stability.critical import Tally, meetings, moved
from haptisym.verbs.stability.entry import chosen
from haptisym.verbs.stability.held import drifts
from haptisym.verbs.stability.loops import Gap, Loop, Meetings, Tendency
from haptisym.verbs.stability.sampled import clocked_roots, passages_in

_MOST_WINDOWS = 8
"""Of values about the scene's own, each about four times as wide as the one before it."""
_BITS = 256


def with_hands(scene: Scene, given: str | Hand | None) -> Scene:
    """The scene in the hand that is asked about; its own if none is."""
    found = scene if given is None else scene.with_hands(chosen(scene, given))
    if not found.hands:
        raise SceneError(f"a display is stable in a hand, and none is given: {how_to_give()}")
    return found


def of_hands(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> list[Callable[[], ValueSet]]:
    """What finds the values for each hand of the scene that is asked about, and for every passive one."""
    both = [(hand, stable_in(hand, what)) for hand in scene.hands for what in IN_HANDS]
    held = [(hand, x) for hand, x in both if x in criteria]
    found: list[Callable[[], ValueSet]] = [partial(_stable, scene, hand, free, asked, x) for hand, x in held]
    if any(x.name == PASSIVE.name for x in criteria):
        found.append(partial(solve_sampled if clocks(scene) else solve_passive, scene, free, asked))
    return found


def _stable(scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion) -> ValueSet:
    return as_set(solve_stable(scene, hand, free, asked, criterion), asked)


def solve_stable(scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion) -> Solved:
    """All values with which no root of H_perc + m s^2 + b s + k lies in Re s >= 0; of "steady" but for what drifts at s = 0.

    UndecidedError where none is known.
    """

    def drifting(value: Expr) -> int | None:
        return drifts(*moved(scene, hand, free, value)) if criterion.name == STEADY else 0

    if clocks(scene):
        return _with_a_clock(scene, hand, free, asked, criterion, drifting)
    loop = Loop.of(scene, hand, free)
    window = window_of(loop, free, asked)
    one_way, tally = Tendency(loop), Tally(loop, window, drifts=drifting)
    in_air = _in_air(scene, criterion)
    turns = [
        Turn(x.value, (Binding(criterion, x.omega, Kind.AXIS if x.omega is not None else Kind.FAR),))
        for x in window.found
    ]

    def verdict(value: Expr) -> bool | None:
        return loop.exists(Rational(value)) and tally.at(value)[0] == 0

    return Question(
        turns, verdict, asked, closed=False, beyond=(window.above, window.below), spares=lambda x: _is_clear(loop, x),
        exists=lambda x: allowed(scene, free, x, in_air=in_air), gone=missing(scene, free, in_air=in_air), gaps=window.gaps,
        fails=one_way.everywhere, own=free.value,
    ).solve()  # fmt: skip


def _with_a_clock(
    scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion, drifting: Callable[[Expr], int | None]
) -> Solved:
    """By counts between the values at which roots of the sampled loop reach the unit circle."""
    loop, found = passages_in(scene, hand, free, searched(free, asked))
    turns = [Turn(x.value, (Binding(criterion, x.omega, Kind.AXIS),)) for x in found.found]
    beyond = (_rational(found.low), _rational(found.high))
    alone = {x.value.value for x in found.found if isinstance(x.value, ExactNumber)} | {asked.low, asked.high}

    def verdict(value: Expr) -> bool | None:
        count, on = loop.count(Rational(value))
        is_outside = count > on + loop.always
        still = drifting(value) if count else 0
        if still is None and not is_outside:
            return None
        return count == still or (value in alone and not is_outside and _is_stable_at(scene, hand, free, value))

    return Question(
        turns,
        verdict,
        asked,
        closed=False,
        beyond=beyond,
        gone=missing(scene, free, in_air=_in_air(scene, criterion)),
        own=free.value,
    ).solve()


def _in_air(scene: Scene, criterion: Criterion) -> bool:
    """Whether free air is among the values: where steadiness is asked, or the scene is in it."""
    return criterion.name == STEADY or scene.closed.env.is_zero


def _is_stable_at(scene: Scene, hand: Hand, free: Knob, value: Expr) -> bool:
    """Whether it is at one value, where a root on the circle may cancel: a filter whose corner is 0 leaves nothing that stays."""
    try:
        if free.is_of_hand:
            hand = hand.with_values({free.symbol.name: value})
        else:
            scene = free.put(scene, value)
        return clocked_roots(scene, hand).number == 0
    except SceneError:
        return False


def _rational(x: Fraction | None) -> Rational | None:
    return None if x is None else Rational(x.numerator, x.denominator)


def _is_clear(loop: Loop, turn: Turn) -> bool:
    """Whether no root lies on the axis at a value after all: as where all but the hand's damping vanish at omega = 0."""
    places = [b.omega for b in turn.bindings]
    return loop.turns is False and all(x is not None and not _on_axis(loop, turn.value, x).contains(0) for x in places)


def _on_axis(loop: Loop, value: RealNumber, omega: RealNumber) -> Any:
    """A ball around the characteristic function at a frequency."""
    with flint.ctx.workprec(_BITS):
        at = acb(0, omega.ball(_BITS))
        known: dict[Expr, Any] = {s: at, pi: acb(arb.pi()), loop.symbol: acb(value.ball(_BITS))}
        known |= {exp(-s * lag): (-at * expression_ball(lag)).exp() for lag in loop.ring.lags}
        known |= {s**order: at ** acb(expression_ball(order)) for order in loop.ring.orders}
        return acb(loop.ring.ball(loop.top, known))


def window_of(loop: Loop, free: Knob, asked: Domain) -> Meetings:
    """The values with roots on the axis, as far as the domain goes where that is known."""
    last: Meetings | None = None
    most = (
        _MOST_WINDOWS if asked.low is None or asked.high is None else None
    )  # a range that is asked about is all searched
    try:
        for found in islice(meetings(loop, free.value), most):
            last = found if last is None else _wider(last, found)
            if any(_meets(gap, asked) for gap in last.gaps):
                continue
            low = last.above is None or (asked.low is not None and bool(last.above <= asked.low))
            high = last.below is None or (asked.high is not None and bool(last.below >= asked.high))
            if low and high:
                break
    except UndecidedError as error:
        if last is None:
            raise
        return _cut(last, str(error))
    if last is None:
        raise UndecidedError("where roots meet the imaginary axis")
    return last


def _cut(window: Meetings, reason: str) -> Meetings:
    """What is beyond a window is left open for a reason."""
    below = [] if window.above is None else [Gap(None, ExactNumber(window.above), reason)]
    beyond = [] if window.below is None else [Gap(ExactNumber(window.below), None, reason)]
    return Meetings(window.found, gaps=(*window.gaps, *below, *beyond))


def _meets(gap: Gap, asked: Domain) -> bool:
    """Whether a gap holds values that are asked about."""
    low, high = (None if x is None else ExactNumber(x) for x in (asked.low, asked.high))
    below = low is not None and gap.high is not None and ordered(gap.high, low) >= 0
    return not below and not (high is not None and gap.low is not None and ordered(high, gap.low) >= 0)


def _wider(one: Meetings, other: Meetings) -> Meetings:
    """Two windows that both hold the scene's own value, as one."""
    above = None if one.above is None or other.above is None else min(one.above, other.above)
    below = None if one.below is None or other.below is None else max(one.below, other.below)
    if (above, below) == (other.above, other.below):  # all of the first is in the second
        return other
    new = [x for x in other.found if not any(x.is_like(y) for y in one.found)]
    return Meetings((*one.found, *new), above, below, other.gaps)
