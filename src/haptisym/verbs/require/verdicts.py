"""The values of one parameter with which conditions hold: verdicts between critical values, and counts in a hand.

The values of one parameter for which a verdict is yes: one exact verdict between each two values at which it may change.

For which values of one parameter a display is stable in a hand: exact counts of unstable roots between critical values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import islice, pairwise
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Rational, exp, pi

from haptisym.judge.crossings import Criterion
from haptisym.kernel.alike import ascending, is_told, ordered
from haptisym.kernel.budget import spared, tick
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball, rational_between
from haptisym.kernel.symbols import s
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand, how_to_give
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.require.criticalvalues import allowed, missing
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, runs
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.stability.clocked import clocked_roots, passages_in
from haptisym.verbs.stability.critical import Tally, meetings
from haptisym.verbs.stability.entry import chosen
from haptisym.verbs.stability.loops import Gap, Loop, Meetings, Tendency

_BEYOND = "further out was not looked at"


@dataclass(frozen=True)
class Turn:
    """A value at which a verdict may change, and what binds there."""

    value: RealNumber
    bindings: tuple[Binding, ...]


@dataclass(frozen=True)
class Question:
    """A verdict on the values of a domain: ``turns`` all values inside at which it may change, ``verdict`` that of a number.

    ``closed`` : whether a turn beside a value that will do will do itself; ``spares`` : whether one of them does, if not.
    ``exists`` : whether the scene does at a turn or an end, where formulas may divide by 0; ``gone`` : all values at which it
    does not.
    ``beyond`` : from where on turns are not known, None where they all are; ``gaps`` : between which values they are not.
    ``fails`` : whether all values between two are known to have the verdict no.
    ``own`` : the value that the scene has, which is asked about for all that no turn parts from it.
    """

    turns: Sequence[Turn]
    verdict: Callable[[Expr], bool | None]
    domain: Domain
    closed: bool
    beyond: tuple[Expr | None, Expr | None] = (None, None)
    spares: Callable[[Turn], bool] = lambda _: False
    exists: Callable[[Expr], bool] = lambda _: True
    gone: Sequence[RealNumber] = ()
    gaps: Sequence[Gap] = ()
    fails: Callable[[RealNumber | None, RealNumber | None], bool] = lambda _low, _high: False
    own: Expr | None = None
    reasons: list[str] = field(default_factory=list, init=False, compare=False)
    """Why verdicts stayed open, as they were asked for."""

    def solve(self) -> Solved:
        """All values for which the verdict is yes, and those about which it stays open."""
        places = self._places()
        cells = [self._cell(a, b) for a, b in pairwise(places)]
        at = [self._at(i, places, cells) for i in range(len(places))]

        def end(i: int, *, closed: bool) -> End:
            found, beside = places[i], cells[max(i - 1, 0) : i + 1]
            if found is None:
                return End(None, closed)
            is_alone = bool(beside) and all(
                x is False for x in beside
            )  # then it binds, be it an end of the domain or not
            return End(found.value, closed, found.bindings if is_alone or not self._is_edge(found.value) else ())

        found = runs([x is True for x in at], [x is True for x in cells])
        spans = []
        for i, j, a, b in found:
            low = end(i, closed=a)
            spans.append(Span(low, low if i == j else end(j, closed=b)))
        left = runs([x is None and places[i] is not None for i, x in enumerate(at)], [x is None for x in cells])
        values = [None if x is None else x.value for x in places]
        return Solved(tuple(spans), tuple((values[i], values[j]) for i, j, _, _ in left), _listed(self.reasons))

    def _places(self) -> list[Turn | None]:
        """The turns in the domain, in order, with its ends; None without bound."""
        low, high = self.domain.low, self.domain.high
        ends = [Turn(ExactNumber(x), ()) for x in (low, high, *self.beyond) if x is not None and self._holds(x)]
        edges = [x for gap in self.gaps for x in (gap.low, gap.high) if x is not None]
        turns = [*self.turns, *(Turn(x, ()) for x in (*self.gone, *edges))]
        inside = [x for x in turns if is_told(x.value) and self._within(x.value)]
        found: list[Turn] = []
        for x in ascending([*ends, *inside], lambda x: x.value):
            if found and not ordered(found[-1].value, x.value):
                found[-1] = replace(found[-1], bindings=tuple(dict.fromkeys([*found[-1].bindings, *x.bindings])))
            else:
                found.append(x)
        return [*([None] if low is None else []), *found, *([None] if high is None else [])]

    def _holds(self, x: Expr) -> bool:
        return self._within(ExactNumber(x))

    def _within(self, x: RealNumber) -> bool:
        low, high = self.domain.low, self.domain.high
        above = low is None or ordered(ExactNumber(low), x) >= 0
        return above and (high is None or ordered(x, ExactNumber(high)) >= 0)

    def _cell(self, a: Turn | None, b: Turn | None) -> bool | None:
        low, high = (None if x is None else x.value for x in (a, b))
        if self._is_beyond(high):
            return self._failed(low, high, _BEYOND)
        if (gap := next((x for x in self.gaps if x.holds(low, high)), None)) is not None:
            return self._failed(low, high, gap.reason or "critical values come as near to one as one likes")
        return self._told(rational_between(low, high, self.own), low, high)

    def _is_beyond(self, high: RealNumber | None) -> bool:
        """Whether turns are not known in a cell up to there."""
        first, last = self.beyond
        below = first is not None and high is not None and ordered(high, ExactNumber(first)) >= 0
        return below or (last is not None and (high is None or ordered(ExactNumber(last), high) > 0))

    def _told(self, value: Expr, low: RealNumber | None, high: RealNumber | None) -> bool | None:
        """The verdict on a value, and so on all between two."""
        known = len(self.reasons)
        told = self._asked(value)
        if told is None and self._failed(low, high, "") is False:
            del self.reasons[known:]
            return False
        return told

    def _failed(self, low: RealNumber | None, high: RealNumber | None, reason: str) -> bool | None:
        """Whether no value of a cell will do, in another way than by a verdict on one."""
        if self.fails(low, high):
            return False
        self.reasons.append(reason)
        return None

    def _asked(self, value: Expr) -> bool | None:
        try:
            tick()
            return self.verdict(value)
        except LimitError:
            return None
        except UndecidedError as error:
            self.reasons.append(str(error))
            return None

    def _at(self, i: int, places: Sequence[Turn | None], cells: Sequence[bool | None]) -> bool | None:
        """At one of the places: as exact numbers tell; else as its neighbours do."""
        here = places[i]
        if here is None or not self._belongs(here.value) or any(not ordered(here.value, x) for x in self.gone):
            return False
        if isinstance(here.value, ExactNumber) and isinstance(here.value.value, Rational):
            return self.exists(here.value.value) and self._told(here.value.value, here.value, here.value)
        near = cells[max(i - 1, 0) : i + 1]
        if True not in near:
            return None if None in near else False
        return self.closed or not here.bindings or self.spares(here)

    def _is_edge(self, x: RealNumber) -> bool:
        return any(end is not None and not ordered(x, ExactNumber(end)) for end in (self.domain.low, self.domain.high))

    def _belongs(self, x: RealNumber) -> bool:
        domain = self.domain
        low = domain.low is not None and not ordered(x, ExactNumber(domain.low))
        high = domain.high is not None and not ordered(x, ExactNumber(domain.high))
        return not (low and not domain.holds_low) and not (high and not domain.holds_high)


def _listed(reasons: Iterable[str]) -> str:
    """Each reason once."""
    return "; ".join(dict.fromkeys(x for x in reasons if x))


def all_open(domain: Domain, reason: str = "") -> Solved:
    """Nothing is known of any value."""
    low, high = (None if x is None else ExactNumber(x) for x in (domain.low, domain.high))
    return Solved((), ((low, high),), reason)


def together(domain: Domain, found: Sequence[Solved]) -> Solved:
    """The values that are in every one of some sets; undecided what is in none of them for certain out, and in some open.

    Known ends are put in order, which is done even where the time is over.
    """
    if len(found) == 1:
        return found[0]
    turns = [Turn(end.value, end.bindings) for x in found for end in _ends(x) if end.value is not None]
    turns += [Turn(y, ()) for x in found for pair in x.undecided for y in pair if y is not None]

    def verdict(value: RealNumber) -> bool | None:
        answers = [_answer(x, value) for x in found]
        return False if False in answers else None if None in answers else True

    question = _Sets(turns, lambda x: verdict(ExactNumber(x)), domain, closed=True, of=verdict)
    with spared():
        return replace(question.solve(), reason=_listed(x.reason for x in found))


@dataclass(frozen=True)
class _Sets(Question):
    """A question about numbers of any kind."""

    of: Callable[[RealNumber], bool | None] = lambda _: None

    def _asked(self, value: Expr) -> bool | None:
        return self.verdict(value)  # known already: no time is asked for

    def _at(self, i: int, places: Sequence[Turn | None], cells: Sequence[bool | None]) -> bool | None:
        here = places[i]
        return False if here is None else self.of(here.value)


def _ends(x: Solved) -> Iterable[End]:
    return (end for span in x.feasible for end in (span.low, span.high))


def _answer(x: Solved, value: RealNumber) -> bool | None:
    """Whether a value is in a set; None where that is open."""
    for span in x.feasible:
        low, high = span.low, span.high
        above = 1 if low.value is None else ordered(low.value, value)
        below = 1 if high.value is None else ordered(value, high.value)
        if (above > 0 or (above == 0 and low.closed)) and (below > 0 or (below == 0 and high.closed)):
            return True
    for start, end in x.undecided:
        if (start is None or ordered(start, value) >= 0) and (end is None or ordered(value, end) >= 0):
            return None
    return False


_MOST_WINDOWS = 8
"""Of values about the scene's own, each about four times as wide as the one before it."""
_BITS = 256


def stable_in(hand: Hand) -> Criterion:
    """The display is stable in this hand: a criterion without a function of frequency."""
    name = f"stable in {hand.name}"
    return Criterion("stable", name, "H_perc + Z_hand", name, _none, kept=name)


def _none(_: object) -> Any:
    raise SceneError("whether a display is stable in a hand is no condition at one frequency")


def with_hands(scene: Scene, given: str | Hand | None) -> Scene:
    """The scene in the hand that is asked about; its own if none is."""
    found = scene if given is None else scene.with_hands(chosen(scene, given))
    if not found.hands:
        raise SceneError(f"whether a display is stable is asked of it in a hand: {how_to_give()}")
    return found


def solve_stable(scene: Scene, hand: Hand, free: Knob, asked: Domain) -> Solved:
    """All values with which no root of H_perc + m s^2 + b s + k lies in Re s >= 0. UndecidedError where none is known."""
    if clocks(scene):
        return _with_a_clock(scene, hand, free, asked)
    loop = Loop.of(scene, hand, free)
    window = window_of(loop, free, asked)
    one_way, tally = Tendency(loop), Tally(loop, window)
    criterion = stable_in(hand)
    turns = [
        Turn(x.value, (Binding(criterion, x.omega, Kind.AXIS if x.omega is not None else Kind.FAR),))
        for x in window.found
    ]

    def verdict(value: Expr) -> bool | None:
        return loop.exists(Rational(value)) and tally.at(value)[0] == 0

    return Question(
        turns, verdict, asked, closed=False, beyond=(window.above, window.below), spares=lambda x: _is_clear(loop, x),
        exists=lambda x: allowed(scene, free, x), gone=missing(scene, free), gaps=window.gaps,
        fails=one_way.everywhere, own=free.value,
    ).solve()  # fmt: skip


def _with_a_clock(scene: Scene, hand: Hand, free: Knob, asked: Domain) -> Solved:
    """By counts between the values at which roots of the sampled loop reach the unit circle."""
    loop, found = passages_in(scene, hand, free, (asked.low, asked.high))
    criterion = stable_in(hand)
    turns = [Turn(x.value, (Binding(criterion, x.omega, Kind.AXIS),)) for x in found.found]
    beyond = (_rational(found.low), _rational(found.high))
    alone = {x.value.value for x in found.found if isinstance(x.value, ExactNumber)} | {asked.low, asked.high}

    def verdict(value: Expr) -> bool | None:
        count, on = loop.count(Rational(value))
        is_outside = count > on + loop.always
        return count == 0 or (value in alone and not is_outside and _is_stable_at(scene, hand, free, value))

    return Question(
        turns, verdict, asked, closed=False, beyond=beyond, gone=missing(scene, free), own=free.value
    ).solve()


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
    try:
        for found in islice(meetings(loop, free.value), _MOST_WINDOWS):
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
