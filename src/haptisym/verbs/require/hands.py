"""For which values of one parameter a display is stable in a hand, and for which it is passive.

*In a hand*: exact counts of unstable roots between the values at which roots reach the imaginary axis, or the unit circle.

*Every passive hand*, of a rational display: exact verdicts between critical values. With delays or powers of s by cells, each
proven: a cell of values is not passive where Im H_perc < 0 at one frequency for all of them, and passive where Im H_perc > 0 at
all frequencies, no pole comes to the axis and no highest power is lost in it, and one exact verdict in it is yes. Where the sign
turns first at frequency 0, it turns at a root of a polynomial: an exact end. What none of these shows is left open.

*Every passive hand, of a sampled loop*: Colgate and Schenkel's condition. The damping that a device has left over is rational in
tan(theta/2) and the parameter. It can become 0 at some angle, or the controller's poles can reach the unit circle, at roots of
resultants and discriminants alone, and the stiffness at rest at roots of its numerator; between these one verdict tells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import count, islice, pairwise
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational, exp, pi

from haptisym.judge.bindings import IN_HANDS, STEADY, Binding, Kind, stable_in
from haptisym.judge.colgate import SampledPassivity, loop_of, sampled_passivity
from haptisym.judge.crossings import PASSIVE, Criterion
from haptisym.judge.passivity import environment_alone, passivity
from haptisym.kernel.budget import Waiting, spared, tick
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials, s
from haptisym.kernel.roots import ordered
from haptisym.kernel.sets import Domain, Point, ValueSet, solve
from haptisym.model.catalogue import Hand, how_to_give
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import Rule, values
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.model.valueranges import searched
from haptisym.programs.onaxis import OnAxis
from haptisym.verbs.require.feasible import End, Question, Solved, Span, Turn
from haptisym.verbs.require.floatcells import Energy, span
from haptisym.verbs.require.freeparameter import (
    ExactSign,
    allowed,
    conditions,
    critical,
    irreducible,
    is_between,
    keeps_sign,
    missing,
    pieces,
    real_roots,
    zeros_of,
)
from haptisym.verbs.stability.critical import Tally, meetings
from haptisym.verbs.stability.entry import chosen
from haptisym.verbs.stability.held import drifts, moved
from haptisym.verbs.stability.loops import Gap, Loop, Meetings, Tendency
from haptisym.verbs.stability.ranges import count_at
from haptisym.verbs.stability.sampled import clocked_question

_MOST_WINDOWS = 8
"""Of values about the scene's own, each about four times as wide as the one before it."""
_BITS = 256


def with_hands(scene: Scene, given: str | Hand | None) -> Scene:
    """The scene in the hand that is asked about; its own if none is."""
    found = scene if given is None else scene.with_hands(chosen(scene, given))
    if not found.hands:
        raise SceneError(f"a display is stable in a hand, and none is given: {how_to_give()}")
    return found


def of_hands(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> list[Callable[[], Solved]]:
    """What finds the values for each hand of the scene that is asked about, and for every passive one."""
    both = [(hand, stable_in(hand, what)) for hand in scene.hands for what in IN_HANDS]
    held = [(hand, x) for hand, x in both if x in criteria]
    found: list[Callable[[], Solved]] = [partial(solve_stable, scene, hand, free, asked, x) for hand, x in held]
    if any(x.name == PASSIVE.name for x in criteria):
        found.append(partial(solve_sampled if clocks(scene) else solve_passive, scene, free, asked))
    return found


def solve_stable(scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion) -> Solved:
    """All values with which no root of H_perc + m s^2 + b s + k lies in Re s >= 0; of "steady" but for what drifts at s = 0.

    UndecidedError where none is known.
    """

    def drifting(value: Expr) -> int | None:
        return drifts(*moved(scene, hand, free, value)) if criterion.name == STEADY else 0

    if clocks(scene):
        return _with_a_clock(scene, hand, free, asked, criterion)
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


def _with_a_clock(scene: Scene, hand: Hand, free: Knob, asked: Domain, criterion: Criterion) -> Solved:
    """By counts between the values at which roots of the sampled loop reach the unit circle."""
    found = solve(clocked_question(scene, hand, free, asked, criterion), asked, Domain(*searched(free, asked)))
    return as_solved(found.without(missing(scene, free, in_air=_in_air(scene, criterion))))


def as_solved(found: ValueSet) -> Solved:
    """A set of values as its pieces."""

    def end(x: Point | None, *, closed: bool) -> End:
        return End(None if x is None else x.value, closed, () if x is None else x.bindings)

    spans = tuple(Span(end(x.first, closed=x.closed[0]), end(x.last, closed=x.closed[1])) for x in found.feasible)
    return Solved(spans, tuple((x.low, x.high) for x in found.undecided), found.reason)


def _in_air(scene: Scene, criterion: Criterion) -> bool:
    """Whether free air is among the values: where steadiness is asked, or the scene is in it."""
    return criterion.name == STEADY or scene.closed.env.is_zero


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


_FAR = 1000  # times the value that a parameter has, where the range has no end
_FURTHER = Rational(1, 64)  # of a range, beyond an end at which signs may change
_FINEST, _LEAST = Rational(1, 1 << 11), Rational(1, 1 << 24)  # of the values, and of the range
_MOST = 200
_ROUNDING_BITS = 64


@dataclass(frozen=True)
class _Cell:
    """Values, and whether all are passive; None: not shown, and if it ``is_last`` no part of it will be.

    ``turn`` : where they turn at a root of G(0, q). ``alone`` : ends that are to be asked about by themselves.
    """

    low: Rational
    high: Rational
    verdict: bool | None
    turn: RealNumber | None = None
    alone: tuple[Rational, ...] = ()
    is_last: bool = False


def solve_by_cells(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values for which a display is passive, where cells prove it."""
    search = _Search(scene, free)
    start, end = _window(free, asked, search.openings)
    if not any(search.is_told(x) for x in (_near(free.value), start + (end - start) / 3, end)):
        raise UndecidedError(_TOO_NEAR)
    cells = list(search.cells(start, end))
    alone = {x: search.holds_at(x) for x in _alone(search, cells)}
    turns = [*_turns(search, cells), *(Turn(ExactNumber(end), ()) for end in alone)]

    def verdict(value: Expr) -> bool | None:
        if value in alone:
            return alone[value]
        if search.is_active(value):
            return False
        if not start <= value <= end:
            return further[value > end]
        own = [x for x in cells if x.low <= value <= x.high]
        if any(x.turn for x in own):
            return True  # but where it begins active, which was asked already
        told = {x.verdict for x in own}
        return True if True in told else False if False in told else None

    first, last = (not search.is_active(x) if y.turn else y.verdict for x, y in ((start, cells[0]), (end, cells[-1])))
    below = asked.low is None and search.beyond(start, -1, here=first)
    above = asked.high is None and search.beyond(end, 1, here=last)
    further = {False: below, True: above}
    beyond = (start if below is None else None, end if above is None else None)
    question = Question(
        turns, verdict, asked, closed=True, beyond=beyond, exists=lambda x: allowed(scene, free, x), gone=search.gone
    )
    with spared():  # what is told is put in order even where the time is over
        found = question.solve()
    return Solved(found.feasible, found.undecided, found.reason or (_LEFT if found.undecided else ""))


def _turns(search: _Search, cells: Sequence[_Cell]) -> Iterator[Turn]:
    """Where verdicts may change: at the ends of cells that are left, and where the sign just above frequency 0 does."""
    for value in (*(x.turn for x in cells if x.turn), *search.openings):
        yield Turn(value, (Binding(PASSIVE, ExactNumber(Integer(0)), Kind.START),))
    for mark, kind in search.marks.items():
        yield Turn(
            ExactNumber(mark), (Binding(PASSIVE, ExactNumber(Integer(0)) if kind is Kind.START else None, kind),)
        )
    for x in cells:
        if x.verdict is None and not x.turn:
            yield from (Turn(ExactNumber(end), ()) for end in (x.low, x.high))


def _alone(search: _Search, cells: Sequence[_Cell]) -> set[Rational]:
    """The values that are asked about by themselves."""
    here = {x.value for x in search.openings if isinstance(x, ExactNumber) and x.value.is_Rational}
    return {end for x in cells for end in x.alone} | here - {
        x.turn.value for x in cells if isinstance(x.turn, ExactNumber)
    }


_TOO_NEAR = "passivity: Im H_perc comes too near to 0 somewhere for cells to decide"
_LEFT = "passivity: the sign of Im H_perc is not proven there"


def _window(free: Knob, asked: Domain, openings: Sequence[RealNumber]) -> tuple[Rational, Rational]:
    """As far as cells go: beyond ends that are not rational by hardly more than a rounding, and beyond ends that are openings."""
    own = abs(_near(free.value)) or Rational(1)
    low = -_FAR * own if asked.low is None else _enclosed(asked.low)[0]
    high = _FAR * own if asked.high is None else _enclosed(asked.high)[1]
    turning, more = {x.value for x in openings if isinstance(x, ExactNumber)}, (high - low) * _FURTHER
    ends = (x + y if x in turning and free.rule.allows(x + y) else x for x, y in ((low, -more), (high, more)))
    return next(ends), next(ends)


def _enclosed(value: Expr) -> tuple[Rational, Rational]:
    """Rational numbers between which one lies."""
    if value.is_Rational:
        return value, value
    low, high = ExactNumber(value).bounds(_ROUNDING_BITS)
    return Rational(low.numerator, low.denominator), Rational(high.numerator, high.denominator)


def _near(value: Expr) -> Rational:
    return _enclosed(value)[0]


class _Search:
    """One parameter of one scene."""

    def __init__(self, scene: Scene, free: Knob) -> None:
        self.scene, self.free = scene, free
        display = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        self.H: RationalFunction = Distortion.of(display).perc
        assert isinstance(self.H.ring, Ring)
        self.ring, self.energy = self.H.ring, Energy.of(self.H, free.symbol)
        self.gone = missing(scene, free)

    def cells(self, start: Rational, end: Rational) -> Iterator[_Cell]:
        """Cells that fill a range, in order."""
        places = sorted({start, end, *(x for x in self.marks if start < x < end)})
        waiting, in_time = Waiting(pairwise(places), most=_MOST, what="cells of values"), True
        try:
            for low, high in waiting:
                found = self._told_if_it_can_be(low, high)
                is_small = high - low <= max(_FINEST * max(-low, high), _LEAST * (end - start))
                if found.verdict is not None or found.turn or found.is_last or is_small:
                    yield found
                else:
                    waiting.add((low, (low + high) / 2), ((low + high) / 2, high))
        except LimitError:
            in_time = False
        for low, high in sorted(waiting.rest):  # far out a wide cell may be told as it is
            yield self._told_if_it_can_be(low, high) if in_time else _Cell(low, high, None)

    def _told_if_it_can_be(self, low: Rational, high: Rational) -> _Cell:
        try:
            return self._told(low, high)
        except UndecidedError:
            return _Cell(low, high, None)

    def is_told(self, value: Rational) -> bool:
        """Whether a sign is shown for one value, be it which it may."""
        q = float(value), float(value)
        return self.energy.active_at(q) is not None or self.energy.clear(q)

    def beyond(self, end: Rational, side: int, *, here: bool | None) -> bool | None:
        """Of all values from an end on, where the last cell is told; None where it is not known."""
        if any(x.between(*((None, end) if side < 0 else (end, None))) == -1 for x in self._ends):
            return False
        found = self.energy.beyond(span(end, end)[side < 0], side)
        return found if found == here else None

    def _told(self, low: Rational, high: Rational) -> _Cell:
        if any(x.between(low, high) == -1 for x in self._ends):
            return _Cell(low, high, verdict=False, alone=tuple(x for x in (low, high) if not self.is_active(x)))
        q = span(low, high)
        if self.energy.active_at(q) is not None:
            return _Cell(low, high, verdict=False)
        if not self.energy.clear(q):
            return _Cell(low, high, None, self._turn(low, high))
        if not self._has_steady_poles(low, high):
            return _Cell(low, high, None)
        if not self._has_no_pole_right((low + high) / 2):
            return _Cell(low, high, None, is_last=True)  # of poles on the right some may be hidden at single values
        if not self._is_steady(low, high):
            return _Cell(low, high, None)
        holds = self._holds(low, high)
        return _Cell(low, high, holds, alone=(low, high) if holds is False else ())

    @cached_property
    def _opening(self) -> ExactSign | None:
        """The sign of Im H_perc just above frequency 0, where it is that of a polynomial."""
        try:
            form = self.energy.at_0
        except UndecidedError:
            return None
        return ExactSign(form, self.free.symbol) if form.is_polynomial(self.free.symbol) else None

    @cached_property
    def _ends(self) -> list[ExactSign]:
        """What must not be negative: Im H_perc just above 0 rad/s and far out, where it turns, too, and H_perc for large s."""
        far = self.energy.far
        return [x for x in (self._opening, far and far[1], self.energy.turning, self.energy.far_right) if x]

    @cached_property
    def openings(self) -> tuple[RealNumber, ...]:
        """The values at which that just above frequency 0 may change."""
        return self._opening.zeros if self._opening else ()

    def is_active(self, value: Expr) -> bool:
        """Whether one of these is negative, proven."""
        return any(x.at(value) < 0 for x in self._ends)

    def _turn(self, low: Rational, high: Rational) -> RealNumber | None:
        """The one value at which Im H_perc ceases to be negative just above frequency 0, and so everywhere; None: not shown."""
        sign, q = self._opening, span(low, high)
        inside = {x.digits(30): x for x in self.openings if is_between(low, x, high)}
        if sign is None or len(inside) != 1:
            return None
        ends = [sign.at(x) for x in (low, high)]
        if ends[0] * ends[1] >= 0:
            return None
        [turn] = inside.values()
        risen = self.energy.rises(q)
        if risen is None or not self.energy.clear(q, risen) or not self._has_steady_poles(low, high):
            return None
        if not self._is_steady(low, high):
            return None
        passive = low if ends[0] > 0 else high
        return turn if self._holds(passive, Rational(float(turn))) else None

    def holds_at(self, value: Rational) -> bool | None:
        """Of one value; None also where the time is over, and where there is no scene."""
        try:
            tick()
            return passivity(self.free.put(self.scene, value)).holds
        except (LimitError, SceneError, UndecidedError):
            return None

    def _holds(self, low: Rational, high: Rational) -> bool | None:
        """Of a value between two, at which the scene exists."""
        shares = (low + (high - low) / n for n in count(2))
        value = next(x for x in shares if not any(isinstance(y, ExactNumber) and y.value == x for y in self.gone))
        return passivity(self.free.put(self.scene, value)).holds

    def _has_no_pole_right(self, value: Rational) -> bool:
        return count_at(self.ring, self.H.denominator, {self.free.symbol: value}) == 0

    def _has_steady_poles(self, low: Rational, high: Rational) -> bool:
        """Whether no pole comes to the axis, nor from infinity, for all values."""
        below = OnAxis(self.ring, self.H.denominator, {self.free.symbol: (low, high)})
        return below.reach is not None and not len(below.left())

    def _is_steady(self, low: Rational, high: Rational) -> bool:
        """Whether H_perc(0) keeps its sign and no highest power of its numerator is lost, but at an end, for all values."""
        if self._at_0 != 0 and not keeps_sign(self._at_0, self.free.symbol, low, high):
            return False
        top = self.energy.top
        steady = top is not None and keeps_sign(top, self.free.symbol, low, high)
        return steady or OnAxis(self.ring, self.H.numerator, {self.free.symbol: (low, high)}).reach is not None

    @cached_property
    def _at_0(self) -> Expr:
        """What has the sign of H_perc(0) where no pole is there, to a factor that is nowhere 0."""
        first = self.ring.size + len(self.ring.lags)
        powers = dict.fromkeys(range(first, first + len(self.ring.orders)), 0)
        return self.ring.expression(self.ring.at_0(self.H.numerator).subs(powers))

    @cached_property
    def marks(self) -> dict[Rational, Kind]:
        """Fractions at which that, the highest power of the numerator, or a sign far out may change: cells end there."""
        found: dict[Rational, Kind] = {}
        far = [x.form for x in self._ends if x is not self._opening]
        for form, kind in (*((x, Kind.FAR) for x in (self.energy.top, *far)), (self._at_0, Kind.START)):
            if form is not None and form.has(self.free.symbol) and form.is_polynomial(self.free.symbol):
                zeros = (x for x in zeros_of(form, self.free.symbol) if isinstance(x, ExactNumber))
                found |= {x.value: kind for x in zeros if x.value.is_Rational}
        return found


def solve_passive(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values for which a continuous-time display is passive; with delays, those that subdivision proves."""
    perceived = Distortion.of(scene.chain.at(values(x for x in scene.parameters if x.path != free.path))).perc
    turns = list[Turn]()
    if free.symbol in perceived.expression().free_symbols:
        [condition] = pieces(conditions(scene, [free], [PASSIVE])[PASSIVE])
        if condition.axis.functions:
            if _is_of_passive_parts(scene, free, asked):
                return _all(scene, free, asked)
            return solve_by_cells(scene, free, asked)
        turns = [*_of_signs(condition, free), *turns_of_poles(perceived, free)]

    def verdict(value: Expr) -> bool | None:
        return passivity(free.put(scene, value)).holds

    return Question(
        turns, verdict, asked, closed=True, exists=lambda x: allowed(scene, free, x), gone=missing(scene, free)
    ).solve()


def _is_of_passive_parts(scene: Scene, free: Knob, asked: Domain) -> bool:
    """Whether the environment alone is passive for all values, and all effects take energy with each of them."""
    alone = environment_alone(scene)
    if alone is None or free.rule is Rule.ANY:  # a shunt's may be negative, and a formula may do anything with a number
        return False
    knob = next((x for x in alone.knobs if x.path == free.path), None)
    if knob is None:
        return passivity(alone).holds is True
    found = solve_passive(alone, knob, asked)
    return found == _all(alone, knob, asked)


def _all(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values with which there is a scene."""
    return Question(
        [], lambda _: True, asked, closed=True, exists=lambda x: allowed(scene, free, x), gone=missing(scene, free)
    ).solve()


def _of_signs(condition: RealFunction, free: Knob) -> Iterator[Turn]:
    """Where Im H_perc begins or ceases to be negative somewhere on (0, infinity)."""
    if free.symbol not in condition.axis.meanings:
        return
    index = condition.axis.meanings.index(free.symbol)
    found = [
        (x[1], p) for x, p in critical(PASSIVE, [condition], (Integer(0), Integer(1))) if x and x[1] is not Kind.EDGE
    ]
    found += [(Kind.FAR, _leading(f)) for f, _ in irreducible(condition.function.numerator)]
    for kind, polynomial in found:
        omega = None
        for factor, _ in polynomial.factor()[1]:
            for value in real_roots(factor, index, negative=True):
                yield Turn(value, (Binding(PASSIVE, omega, kind),))


def _end(polynomial: Polynomial, power: int) -> Polynomial:
    """The coefficient of one power of the ring's variable."""
    terms = {(0, *e[1:]): value for e, value in monomials(polynomial) if int(e[0]) == power}
    return polynomial.context().from_dict(terms)


def _leading(polynomial: Polynomial) -> Polynomial:
    return _end(polynomial, int(polynomial.degrees()[0]))


def turns_of_poles(function: RationalFunction, free: Knob) -> Iterator[Turn]:
    """Where poles of a function cross the axis, or poles or zeros come from infinity or to 0."""
    ring = function.ring
    assert isinstance(ring, Ring)
    if free.symbol not in ring.meanings:
        return
    index, found = ring.meanings.index(free.symbol), list[tuple[Kind, Polynomial]]()
    for polynomial in (function.numerator, function.denominator):
        for f, _ in polynomial.factor()[1]:
            found += [(Kind.FAR, _leading(f)), (Kind.START, _end(f, min(int(e[0]) for e in f.monoms())))]
    for f, _ in function.denominator.factor()[1]:
        [(real, imag)] = ring.axis.parts([f])
        common = real.gcd(imag)
        if real and imag and f.degrees()[0]:
            found.append((Kind.AXIS, (real / common).resultant(imag / common, 0)))
    for kind, polynomial in found:
        for factor, _ in polynomial.factor()[1] if polynomial else ():
            for value in real_roots(factor, index, negative=True):
                yield Turn(value, (Binding(PASSIVE, None, kind),))


_PIECES, _MOST_PIECES = 16, 2000


def solve_sampled(scene: Scene, free: Knob, asked: Domain) -> Solved:
    """All values for which it is passive. UndecidedError where the condition does not apply."""
    if free.is_of_hand or free.parts:
        return Question([], lambda _: sampled_verdict(scene), asked, closed=True).solve()
    loop = loop_of(scene.with_values({free.path: free.symbol}))
    if isinstance(loop, SampledPassivity):
        raise UndecidedError(f"passivity: {loop.reason}")
    ring = Ring.of([loop.T, loop.C, loop.damping])
    if ring.functions:
        raise UndecidedError("passivity, with a free delay in a sampled loop")
    margins = [RealFunction((f.axis.convert(loop.damping) - f.function).reduced()) for f in loop.sides(ring)]
    turns = [*_of_margins(margins, free), *turns_of_poles(ring.convert(loop.C).reduced(), free)]
    at_rest = loop.at_rest(ring)[1]
    if at_rest.has(free.symbol):
        turns += [Turn(x, (Binding(PASSIVE, None, Kind.START),)) for x in zeros_of(at_rest, free.symbol)]
    for held in (loop.mass, loop.stiffness, loop.damping):  # of a device they may be negative
        turns += [Turn(x, ()) for x in zeros_of(held, free.symbol)] if held.has(free.symbol) else []

    def verdict(value: Expr) -> bool | None:
        return sampled_verdict(free.put(scene, value))

    return Question(
        turns, verdict, asked, closed=False, spares=lambda x: _is_positive(margins, free, x.value),
        exists=lambda x: allowed(scene, free, x), gone=missing(scene, free),
    ).solve()  # fmt: skip


def sampled_verdict(scene: Scene) -> bool | None:
    """Of a scene with numbers. UndecidedError with the reason where the condition does not apply."""
    found = sampled_passivity(scene)
    assert found is not None
    if found.passive is None:
        raise UndecidedError(f"passivity: {found.reason}")
    return found.passive


def _of_margins(margins: Sequence[RealFunction], free: Knob) -> Iterator[Turn]:
    """Where the damping that is left over becomes 0 at some angle, or begins to have a pole there."""
    for margin, start in zip(margins, (Kind.START, Kind.FAR), strict=True):
        if free.symbol not in margin.axis.meanings:
            continue
        index = margin.axis.meanings.index(free.symbol)
        for reason, polynomial in critical(PASSIVE, [margin], (Integer(0), Integer(1))):
            kind = start if reason and reason[1] is Kind.START else Kind.TOUCH
            for factor, _ in polynomial.factor()[1] if polynomial else ():
                for value in real_roots(factor, index, negative=True):
                    yield Turn(value, (Binding(PASSIVE, None, kind),))


def _is_positive(margins: Sequence[RealFunction], free: Knob, value: RealNumber) -> bool:
    """Whether damping is left over at all angles, proven, at a value that is known by balls."""
    with flint.ctx.workprec(_BITS):
        known = {free.symbol: value.ball(_BITS), pi: arb.pi()}
        pieces = [(f, arb(k) / _PIECES, arb(k + 1) / _PIECES) for f in margins for k in range(_PIECES)]
        waiting = Waiting(pieces, most=_MOST_PIECES)
        for f, low, high in waiting:
            at = known | {f.axis.meanings[0]: low.union(high)}
            above, below = (f.axis.ball(x, at) for x in (f.function.numerator, f.function.denominator))
            if not above * below > 0:
                middle = (low + high) / 2
                waiting.add((f, low, middle), (f, middle, high))
        return not waiting.rest
