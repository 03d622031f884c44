"""How far a number may go before the display shakes: the nearest values at which the number of roots that shake changes.

Those are roots in Re s >= 0 but for what drifts, as nothing holds the handle in place; counted once, and from there on by those
that come and go. Where one equation in omega does not tell all values with roots on the axis, they are searched over frequency
and value: in windows about a value that grow, cells are left out where C(j omega; q) is nowhere 0, proven in Taylor models, and
in the others Newton's step in balls proves that there is just one pair. What is neither is a gap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, cached_property
from typing import TypeAlias

from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.judge.bindings import STABLE, STEADY, stable_in
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.arrays import np
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, Way, in_unit, printed
from haptisym.kernel.rootcount import RootChain
from haptisym.kernel.roots import each_once, is_told, ordered
from haptisym.kernel.sets import Verdict, solve
from haptisym.kernel.where import Array, halves
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Knob, Scene, clocks, unclocked
from haptisym.model.valueranges import domain
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.taylormodels import Model
from haptisym.verbs.stability.held import drifts, held, moved, need_roots
from haptisym.verbs.stability.loops import (
    ALLOWED,
    BesideChains,
    Characteristic,
    Curve,
    Gap,
    Loop,
    Meeting,
    Meetings,
    Pair,
    Switches,
    clear_of_chains,
    curve_of,
    from_infinity,
    minus,
)
from haptisym.verbs.stability.sampled import clocked_question

_WINDOWS = 7
_SMALLEST = Rational(1, 1024)  # as what a value of 0 counts for the first window
_MOST_CELLS, _DEEPEST = 80_000, 60  # of one strip of values, and how often one is cut
_THINNEST = 64  # part of the first window, for which a bound on the frequency must be known
_NEAR, _STRAIGHT, _WIDER = (
    1.6,
    0.05,
    3.0,
)  # in halves of a cell: how far a pair is off, C bends, and the proof's box goes
_ROUNDING = 1e-14  # in shares
_BITS = 96

_LEFT = "where roots meet the imaginary axis: the search was not fine enough"
_FAR = "where roots meet the imaginary axis: no bound on their frequencies is known"
_BEYOND = "no limit found within it"


def searched(loop: Loop, value: Expr, reason: str) -> Iterator[Meetings]:
    """All of them in windows about a value, but for those in gaps. UndecidedError, for a ``reason``, where they have no bound."""
    need_roots(loop.top, loop.ring)
    form, start = Characteristic(loop), Rational(f"{float(value):.3g}")
    found = [Meeting(x, ExactNumber(Integer(0))) for x in form.at_0()]
    gaps: list[Gap] = []
    ends = [_end(loop, start, side, 0) for side in (-1, 1)]
    if _Cells(form, *(start + (x - start) / _THINNEST for x in ends)).axis.reach is None:
        raise UndecidedError(reason)
    strips = [(ends[0], ends[1])]
    for j in range(1, _WINDOWS + 1):
        for strip in strips:
            cells = _Cells(form, *strip)
            gaps += [_gap(*strip, _FAR)] if cells.axis.reach is None else _joined(cells.settle())
            found += cells.found
        yield Meetings(tuple(found), ends[0], ends[1], tuple(gaps))
        strips = []
        for i, side in enumerate((-1, 1)):
            further = _end(loop, start, side, j)
            if j < _WINDOWS and further != ends[i] and not any(_ends(gap)[i] == ends[i] for gap in gaps):
                strips.append((further, ends[i]) if side < 0 else (ends[i], further))
                ends[i] = further
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    gaps += [] if ends[0] == loop.low else [Gap(low, ExactNumber(ends[0]), _BEYOND)]
    gaps += [] if ends[1] == loop.high else [Gap(ExactNumber(ends[1]), high, _BEYOND)]
    yield Meetings(tuple(found), loop.low, loop.high, tuple(gaps))


def _end(loop: Loop, start: Rational, side: int, j: int) -> Rational:
    """Of the j-th window, on one side: four times as far as the one before it, or as near to what is allowed."""
    last = loop.low if side < 0 else loop.high
    if last is None:
        return start + side * (abs(start) * Rational(4) ** (j - 1) or _SMALLEST * Rational(64) ** j)
    return last if j + 1 >= _WINDOWS else last + (start - last) * Rational(3, 4) / 4**j


def _gap(low: Expr, high: Expr, reason: str) -> Gap:
    return Gap(ExactNumber(low), ExactNumber(high), reason)


def _ends(gap: Gap) -> tuple[Expr, Expr]:
    """Of one that is bounded by exact numbers, as all of these are."""
    assert isinstance(gap.low, ExactNumber)
    assert isinstance(gap.high, ExactNumber)
    return gap.low.value, gap.high.value


def _joined(gaps: list[Gap]) -> list[Gap]:
    """Those that touch as one."""
    found: list[Gap] = []
    for gap in sorted(gaps, key=_ends):
        low, high = _ends(gap)
        if found and low <= (last := _ends(found[-1]))[1]:
            found[-1] = _gap(last[0], max(last[1], high), found[-1].reason)
        else:
            found.append(gap)
    return found


class _Cells:
    """Cells of frequency and value, as shares of what is looked at (cells, 2, 2)."""

    def __init__(self, form: Characteristic, low: Rational, high: Rational) -> None:
        self.form, self.low, self.high = form, low, high
        loop = form.loop
        polynomial = loop.top / loop.ring.variable**form.shared
        self.axis = OnAxis(loop.ring, polynomial, {loop.symbol: (low, high)})
        self.found: list[Meeting] = []
        self._known = np.zeros((2, 0, 2))
        """Middle and size of each box that holds one pair."""

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        """Where shares begin, and what one is."""
        return np.array([0.0, float(self.low)]), np.array([self.axis.reach, float(self.high - self.low)])

    @cached_property
    def _lost(self) -> Array:
        """More than any rounding of these."""
        start, size = self._scale
        return _ROUNDING * (abs(start) + size)

    def settle(self) -> list[Gap]:
        """Find all pairs; values in cells that are left are in gaps."""
        columns = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
        start = np.zeros((len(columns) - 1, 2, 2))
        start[:, 0, 0], start[:, 0, 1], start[:, 1, 1] = columns[:-1], columns[1:], 1.0
        looked, waiting = 0, Waiting([start], most=_DEEPEST, what="times that cells of frequency and value are cut")
        for part in waiting:
            looked += len(part)
            if looked > _MOST_CELLS:
                break
            with np.errstate(all="ignore"):
                parts = self.axis.parts(part)
            clear, rates = self.axis.bounded(part, parts)
            self._prove(part, self._likely(parts, ~clear))
            open_ones = ~clear
            open_ones[~clear] = ~self._is_settled(part[~clear])
            if open_ones.any():
                waiting.add(halves(part[open_ones], np.argmax(rates[open_ones], -1)))
        width = self.high - self.low
        left = {tuple(map(Fraction, cell[1])) for cells in waiting.rest for cell in cells}
        return [_gap(self.low + width * Rational(a), self.low + width * Rational(b), _LEFT) for a, b in left]

    def _box(self, cells: Array) -> tuple[Array, Array]:
        """Middles of cells in rad/s and as values, and halves of them with what was lost by rounding."""
        start, size = self._scale
        half = size * (cells[:, :, 1] - cells[:, :, 0]) / 2
        return start + size * cells.mean(-1), half + self._lost

    def _is_settled(self, cells: Array) -> Array:
        """Whether a cell lies in a box with a known pair, or beside omega = 0 and holds none."""
        middle, half = self._box(cells)
        found = np.zeros(len(cells), bool)
        for center, size in self._known.swapaxes(0, 1):
            found |= _inside(middle, half, center, size)
        for i in np.flatnonzero(~found & (cells[:, 0, 0] == 0)):
            found[i] = self.form.is_clear_at_0(*_balls(middle[i], half[i]))
        return found

    def _prove(self, cells: Array, likely: Iterable[tuple[int, Array]]) -> None:
        """Try Newton's step about where a cell may hold a pair."""
        middle, half = self._box(cells)
        for i, t in likely:
            if _inside(middle[i], half[i], *self._known).any():
                continue
            box = middle[i] + t * half[i], _WIDER * half[i]
            pair = self.form.only(*_balls(*box))
            if pair is not None and (value := self._value(pair)) is not None:
                place = np.array([float(x.mid()) for x in pair.at(_BITS)])
                if not _inside(place, self._lost, *self._known).any():
                    self.found.append(Meeting(value, pair.frequency))
                self._known = np.concatenate([self._known, np.array(box)[:, None]], 1)

    def _value(self, pair: Pair) -> RealNumber | None:
        """Of the open number; where it looks like 0 only if it is proven to be."""
        omega, q = pair.at(_BITS)
        if not q.contains(0):
            return pair.value
        with suppress(UndecidedError):
            if any(omega.contains(x.ball(2 * _BITS)) for x in self.form.loop.at(Integer(0)).on_axis):
                return ExactNumber(Integer(0))
        return None

    @staticmethod
    def _likely(parts: tuple[Model, Model], among: Array) -> Iterator[tuple[int, Array]]:
        """Cells in which C is nearly straight, with the place, in halves of one from its middle, where C would then be 0."""
        slopes = np.stack([x.c1[:, 0] for x in parts], 1)
        values = np.stack([x.c0[:, 0] for x in parts], 1)
        bends = np.stack([abs(x.c2[:, 0]).sum((-1, -2)) + x.r[:, 0] for x in parts], 1)
        with np.errstate(all="ignore"):
            (a, b), (c, d) = slopes[:, 0].T, slopes[:, 1].T
            inverse = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], 1) / (a * d - b * c)[:, None, None]
            t = -np.einsum("nij,nj->ni", inverse, values)
            bent = np.einsum("nij,nj->ni", abs(inverse), bends)
        for i in np.flatnonzero(among & (abs(t) < _NEAR).all(-1) & (bent < _STRAIGHT).all(-1)):
            yield int(i), t[i]


def _inside(middle: Array, half: Array, center: Array, size: Array) -> Array:
    """Whether cells lie in a box."""
    return (abs(middle - center) + half <= size).all(-1)


def _balls(middle: Array, half: Array) -> tuple[Ball, Ball]:
    omega, q = (arb(float(m), float(h)) for m, h in zip(middle, half, strict=True))
    return omega, q


_WINDOWS_CRITICAL = 12
_MOST_TURNING_CRITICAL = 400  # radians that a delay turns up to where roots are looked for
_LOWS = (Rational(15, 16), Rational(1, 2))
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


def meetings(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """Where an open number puts roots on the axis: all, or in windows that grow. UndecidedError where that is open.

    By one equation in omega as far as that goes, and from there on by a search over both.
    """
    if not loop.moves:
        yield Meetings(())
        return
    is_whole = True
    try:
        for window in _eliminated(loop, value):
            yield window
            is_whole = not window.gaps
    except LimitError:
        raise
    except UndecidedError as error:
        if not is_whole:
            raise
        yield from searched(loop, value, str(error))


def _eliminated(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """By one equation in omega."""
    if loop.rests and not loop.ring.lags:  # nor does a root come from infinity, or a chain
        yield _at_0(loop, ())
        return
    far_out = from_infinity(loop)
    if loop.turns:
        yield _of_a_delay(loop, value, far_out)
        return
    home, others = None, tuple[Gap, ...]()
    if any(any(turns) for turns in loop.leading):
        ends = (ExactNumber(x) for x in (loop.low, loop.high) if x is not None)
        far_out += tuple(Meeting(x, None) for x in ends)  # at an end alone what is delayed may be lost
        clear = tuple(Gap(a, b) for a, b in clear_of_chains(loop, far_out))
        home, is_own = _home(clear, value)
        others = tuple(x for x in clear if x is not home)
        if not is_own:
            yield Meetings(far_out, gaps=clear)
            if home is None or BesideChains.of(loop) is None:
                return
    if loop.rests:
        yield _at_0(loop, far_out)
        return
    far_out = _at_0(loop, far_out).found
    curve = curve_of(loop)
    if curve is None:
        yield Meetings(far_out)
        return
    if curve.condition.is_zero:  # one value alone puts roots there, everywhere
        alone = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield Meetings((*far_out, Meeting(alone, None)))
        return
    settled = asymptotic_sign(curve.condition)
    if settled.sense in _SETTLED:
        yield Meetings((*far_out, *curve.meetings(_near(settled.radius, loop))))
        return
    if home is not None and home.low is not None and (beside := BesideChains.of(loop)) is not None:
        for near in beside.meetings(curve, home.low, home.high):
            yield Meetings((*far_out, *near.found), gaps=(*others, *near.gaps))
        return
    yield from _windows(loop, curve, value, far_out)


def _home(clear: tuple[Gap, ...], value: Expr) -> tuple[Gap | None, bool]:
    """Of the intervals that no chain of roots reaches the one about a value, and True; else the first bounded one."""
    here = ExactNumber(value)
    own = next((x for x in clear if x.holds(here, here)), None)
    return own or next((x for x in clear if x.low is not None), None), own is not None


def _of_a_delay(loop: Loop, value: Expr, far_out: tuple[Meeting, ...]) -> Meetings:
    """Or of an order of s."""
    if _has_chain(loop, value):  # whatever the delay, as long as there is one
        return Meetings((*far_out, Meeting(ExactNumber(Integer(0)), None)))
    if loop.rests:
        return _at_0(loop, far_out)
    found, last = Switches.of(loop).up_to(value)
    return Meetings((*_at_0(loop, far_out).found, *found), below=last)


def _at_0(loop: Loop, far_out: tuple[Meeting, ...]) -> Meetings:
    """With the values that put a root at 0."""
    return Meetings((*far_out, *(Meeting(x, ExactNumber(Integer(0))) for x in Characteristic(loop).at_0())))


def _near(radius: Expr, loop: Loop) -> Expr:
    """How far to look; UndecidedError where delays turn too often on the way."""
    if any(float(radius * lag) > _MOST_TURNING_CRITICAL for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _windows(loop: Loop, curve: Curve, value: Expr, far_out: tuple[Meeting, ...]) -> Iterator[Meetings]:
    """Where frequencies never end: as far as values lie in a window, about the value that is asked about."""
    done = False
    for j in range(_WINDOWS_CRITICAL):
        high, low = (
            abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2),
            value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0),
        )
        for end, sense in ((high, Sense.POSITIVE), (low, Sense.NEGATIVE)):
            ahead = asymptotic_sign(minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                found = (*far_out, *curve.meetings(_near(ahead.radius, loop)))
                done = True
                yield Meetings(found, -high, high) if end is high else Meetings(found, low)
    if not done:
        raise UndecidedError("where roots meet the imaginary axis at ever higher frequencies")


# A delay that is open


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether infinitely many roots lie on the right, or come to the axis, at a delay > 0: at all of them, or at none."""
    with suppress(UndecidedError):
        return loop.at(Rational(value) if value.is_Rational and value else Integer(1)).chain is not None
    return False


@dataclass
class Tally:
    """Of a loop and its open number; ``window`` : where that is known to put roots on the axis. None: nowhere.

    ``known`` : the numbers that were counted, by value. ``drifts`` : of a value, how many
    roots at 0 are not counted, as they only drift.
    """

    loop: Loop
    window: Meetings | None = None
    known: dict[Expr, int] = field(default_factory=dict)
    drifts: Callable[[Expr], int | None] = lambda _: 0

    def at(self, value: Expr) -> tuple[int | None, RootChain | None]:
        """The number of roots, None if they are infinitely many, or as near to the axis as one likes; and their chain."""
        if (found := self._from_another(value)) is not None:
            return found, None
        roots = self.loop.at(Rational(value))
        number = roots.number
        if number and roots.on_axis and not ordered(roots.on_axis[0], ExactNumber(Integer(0))):
            number -= _decided(self.drifts(value))
        if number is not None and roots.chain is None:
            self.known[value] = number
        return number, roots.chain

    def _from_another(self, value: Expr) -> int | None:
        """From the nearest value that was counted, where all that moves over the axis on the way there is known."""
        if value in self.known or not self.known or self.window is None or not self._is_inside(value, self.window):
            return self.known.get(value)
        nearest = min(self.known, key=lambda x: abs(x - value))
        low, high = (ExactNumber(x) for x in sorted((nearest, value)))
        if not self._is_inside(nearest, self.window) or any(_meets(gap, low, high) for gap in self.window.gaps):
            return None
        between = [x for x in self.window.found if ordered(low, x.value) >= 0 and ordered(x.value, high) >= 0]
        senses = [x.sense for x in between if x.sense is not None]
        if len(senses) < len(between) or any(not ordered(x.value, end) for x in between for end in (low, high)):
            return None
        return self.known[nearest] + (1 if value > nearest else -1) * 2 * sum(senses)

    @staticmethod
    def _is_inside(value: Expr, window: Meetings) -> bool:
        """Whether all that puts roots on the axis is known about there."""
        above, below = window.above, window.below
        return (above is None or value > above) and (below is None or value < below)


def _decided(drifts: int | None) -> int:
    if drifts is None:
        raise UndecidedError("how many roots at rest only drift")
    return drifts


def _meets(gap: Gap, low: ExactNumber, high: ExactNumber) -> bool:
    before = gap.high is not None and ordered(gap.high, low) >= 0
    return not before and not (gap.low is not None and ordered(high, gap.low) >= 0)


Count: TypeAlias = tuple[int | None, RootChain | None]


@dataclass(frozen=True, repr=False)
class Critical(Shown):
    """A value of a number at which the count of unstable roots changes: ``below`` and ``above`` it, None if infinite.

    ``omega`` : the frequency at which roots then lie on the axis, rad/s; None where they come from infinity.
    ``is_crowded`` : whether the count is that of one value only, as more and more roots of a chain that leaves may stay behind.
    ``itself`` : the side, -1 or 1, of which the count is that of the value itself, as nothing is allowed there, or as another
    limit tells of that side; 0 where each count is that of a side.
    """

    path: str
    value: RealNumber
    omega: RealNumber | None
    below: int | None
    above: int | None
    is_crowded: bool = False
    itself: int = 0

    def _line(self) -> str:
        return f"{self.path} = {self.value.digits(6)}"

    @property
    def chain_side(self) -> str | None:
        """``above`` or ``below``, where infinitely many roots lie on the right on that side."""
        return "above" if self.above is None else "below" if self.below is None else None

    @property
    def stable_side(self) -> str | None:
        """``above``, ``below``, or None where it is stable on neither side, or a chain leaves that open."""
        if self.is_crowded:
            return None
        return (
            "above"
            if self.above == 0 and self.itself < 1
            else "below"
            if self.below == 0 and self.itself > -1
            else None
        )

    @property
    def is_alone(self) -> bool:
        """Whether it is stable at the value itself, and beside it not."""
        return self.itself != 0 and (self.above if self.itself > 0 else self.below) == 0


Window: TypeAlias = tuple[Critical | None, Critical | None]


@dataclass(frozen=True)
class Nearest:
    """The nearest values below and above at which the count changes, as far as they are there; ``reason`` : what stayed open.

    Where it is unstable now, the other end of what is stable beyond one of them is there as well, if it was found.
    ``low``, ``high`` : between which values was looked, None where that has no end; up to a value that was found all are.
    """

    path: str
    found: tuple[Critical, ...] = ()
    reason: str = ""
    low: Fraction | None = None
    high: Fraction | None = None

    @property
    def windows(self) -> Iterator[Window]:
        """The values beside the limits for which it is stable: intervals with their ends, None where none was found.

        Of a single value both ends are the same.
        """
        low: Critical | None = None
        for x in self.found:
            if x.is_alone:
                yield x, x
            elif x.stable_side == "below":
                yield low, x
            low = x if x.stable_side == "above" else None
        if low is not None:
            yield low, None


def critical(scene: Scene, hand: Hand, free: Knob, *, brief: bool = False) -> Nearest:
    """How far a number of the hand or of the display may go, either way, before the count of unstable roots changes.

    Roots that only drift are not counted if there are some at the value that the number has. ``brief`` : with a clock, as far as
    few cells go.
    """
    drifting = cache(lambda: drifts(scene, hand))

    def is_there(value: Expr) -> bool:  # with nothing to feel there is no scene, unless that is what is asked about
        with suppress(SceneError):
            display, _ = moved(scene, hand, free, value)
            return scene.closed.env.is_zero or bool(drifting()) or not display.closed.env.is_zero
        return False

    try:
        bare = unclocked(moved(scene, hand, free, free.symbol)[0])
        if not clocks(bare) and clocks(scene):
            scene = unclocked(scene)
            if not (free.is_of_hand or free.path in {x.path for x in scene.knobs}):
                return Nearest(free.path)
        if clocks(bare):
            return _by_a_clock(scene, hand, free)
        tally = Tally(Loop.of(scene, hand, free), drifts=lambda x: drifting() and drifts(*moved(scene, hand, free, x)))
        return _Walk(tally, free, is_there).nearest()
    except UndecidedError as error:
        return Nearest(free.path, reason=str(error))


def _by_a_clock(scene: Scene, hand: Hand, free: Knob) -> Nearest:
    """The ends of what is stable, or drifts, next to the value that a number has."""
    here, asked = held(scene, hand), domain(free, None)
    what = STEADY if here.shakes is False and here.drifts else STABLE
    found = solve(clocked_question(scene, hand, free, asked, stable_in(hand, what), near=True), asked, near=True)
    if found.about(ExactNumber(free.value)).verdict is Verdict.UNDECIDED:
        raise UndecidedError(found.about(ExactNumber(free.value)).reason)
    limits = list[Critical]()
    for piece in found.feasible:
        for end, counts in ((piece.first, (1, 0)), (piece.last, (0, 1))):
            if end is not None and end.bindings:
                itself = -1 if piece.is_single or (asked.low is not None and end == found.points[0]) else 0
                limits.append(Critical(free.path, end.value, end.bindings[0].omega, *counts, itself=itself))
    own = ExactNumber(free.value)
    below = [x.high for x in found.undecided if x.high is not None and ordered(x.high, own) > 0]
    above = [x.low for x in found.undecided if x.low is not None and ordered(own, x.low) > 0]
    return Nearest(
        free.path,
        tuple(limits),
        low=_known(below[-1], -1) if below else None,
        high=_known(above[0], 1) if above else None,
    )


@dataclass(frozen=True)
class _Ahead:
    """What was ``found`` on one side, the nearest first, and for which ``reason`` it is not known whether there is anything.

    ``last`` : up to where what holds beyond all of it is known; None where that has no end.
    """

    found: Sequence[Critical] = ()
    reason: str = ""
    last: Fraction | None = None


def _known(x: RealNumber | None, side: int) -> Fraction | None:
    """A fraction next to a number, none beyond it."""
    return None if x is None else x.bounds(_BITS)[side < 0]


@dataclass(frozen=True)
class _Line:
    """Different meetings in order, between two ends; None where nothing bounds them.

    ``is_whole`` : whether nothing is allowed beyond the low end, and beyond the high one. ``gaps`` : in which others may lie.
    """

    places: list[Meeting]
    low: RealNumber | None
    high: RealNumber | None
    is_whole: tuple[bool, bool]
    gaps: tuple[Gap, ...]

    def cell(self, i: int) -> tuple[RealNumber | None, RealNumber | None]:
        """Before the i-th meeting."""
        low = self.places[i - 1].value if i else self.low
        return low, self.places[i].value if i < len(self.places) else self.high

    def gap(self, i: int) -> Gap | None:
        """The one in which the cell before the i-th meeting lies, whole as they are."""
        low, high = self.cell(i)
        return next((x for x in self.gaps if x.holds(low, high)), None)


class _Walk:
    """From a value on, meeting after meeting, until the count changes."""

    def __init__(self, tally: Tally, free: Knob, is_there: Callable[[Expr], bool]) -> None:
        self.tally, self.loop, self.free, self.is_there = tally, tally.loop, free, is_there
        self.start = ExactNumber(free.value)
        self.low, self.high, self.closed = ALLOWED[free.rule]

    def nearest(self) -> Nearest:
        """Below and above, as far as they are there: what was found stays so where the rest cannot be told."""
        here: list[Critical] = []
        sides: dict[int, _Ahead] = {}
        left = [_ENDLESS]
        try:
            for line in map(self._line, meetings(self.loop, self.free.value)):
                if not here and (here := self._here(line)):  # beside a limit only what is stable there ends somewhere
                    sides |= {side: _Ahead() for side in (-1, 1) if not any(_opens(x, side) for x in here)}
                left = list(self._look(line, sides))
                if len(sides) == 2 and all(x.last is None for x in sides.values()):
                    break
        except UndecidedError as error:
            left = [str(error)]
        below, above = (sides.get(side, _Ahead()) for side in (-1, 1))
        rows = (*reversed(below.found), *here, *above.found)
        return Nearest(self.free.path, rows, "; ".join(dict.fromkeys(left)), below.last, above.last)

    def _look(self, line: _Line, sides: dict[int, _Ahead]) -> Iterator[str]:
        """Put down what lies on either side; of a side that stays open the reason."""
        for side in (x for x in (-1, 1) if x not in sides or sides[x].last is not None):
            found = self._side(line, side)
            if not found.reason:  # a wider window may hold a gap that another one had not
                sides[side] = max(found, sides.get(side, found), key=lambda x: len(x.found))
            elif side not in sides:
                yield found.reason

    def _crowded(self, gap: Gap, side: int) -> str:
        """Why the nearest value was not found: where it may lie, or how far was searched."""
        unit = self.free.shown_unit(self.free.motion)
        low, high = (
            "" if x is None else f"{printed(in_unit(x, unit.size), 4, way)} {unit.text}".rstrip()
            for x, way in ((gap.low, Way.DOWN), (gap.high, Way.UP))
        )
        if gap.reason == _BEYOND:
            return f"searched {f'up to {low}' if side > 0 else f'down to {high}'}, {_BEYOND}"
        where = (
            f", from {low} to {high}"
            if low and high
            else f", above {low}"
            if low
            else f", below {high}"
            if high
            else ""
        )
        return f"{gap.reason or _ENDLESS}{where}"

    def _line(self, window: Meetings) -> _Line:
        self.tally.window = window
        ends = [Meeting(x, None) for gap in window.gaps for x in (gap.low, gap.high) if x is not None]
        apart = each_once((x for x in (*window.found, *ends) if is_told(x.value)), lambda x: x.value)
        low, low_is_whole = _nearer(window.above, self.low, -1)
        high, high_is_whole = _nearer(window.below, self.high, 1)
        within = [
            x for x in apart
            if (low is None or ordered(low, x.value) >= 0) and (high is None or ordered(x.value, high) >= 0)
        ]  # fmt: skip
        return _Line(within, low, high, (low_is_whole, high_is_whole), window.gaps)

    def _here(self, line: _Line) -> list[Critical]:
        """What changes at the very value, where it puts roots on the axis."""
        for i, x in enumerate(line.places):
            if not ordered(x.value, self.start):
                below, above = (
                    self._beyond(line, k, side) if line.gap(k) else self._count(line, k)
                    for side, k in ((-1, i), (1, i + 1))
                )
                if (line.gap(i) or line.gap(i + 1)) and not any(y and y[1] for y in (below, above)):
                    return []
                return self._limits(line, i, below, above)
        return []

    def _side(self, line: _Line, side: int) -> _Ahead:
        """The nearest change on one side; where it is stable from there on, the next one, too."""
        ahead = [i for i, x in enumerate(line.places) if ordered(self.start, x.value) == side]
        found, home = list[Critical](), None
        for i in ahead if side > 0 else ahead[::-1]:
            near, beyond = (i, i + 1) if side > 0 else (i + 1, i)
            if gap := line.gap(near):
                return self._left(line, side, found, gap)
            try:
                home = home or self._count(line, near)
                if home and not home[1] and line.gap(beyond):
                    continue
                other = self._beyond(line, beyond, side) if line.gap(beyond) else self._count(line, beyond)
            except UndecidedError:
                if not found:
                    raise
                return _Ahead(found, last=_known(line.places[i].value, side))
            changes = self._limits(line, i, *((home, other) if side > 0 else (other, home)))
            found += changes[:1] if side > 0 else changes[-1:]
            if changes and not _opens(found[-1], side):
                return _Ahead(found)
            home = other
        return self._left(line, side, found, line.gap(len(line.places) if side > 0 else 0))

    def _left(self, line: _Line, side: int, found: list[Critical], gap: Gap | None) -> _Ahead:
        """What was found on one side, after which there is a gap, the end of a window, or nothing that is allowed."""
        if gap is None and line.is_whole[side > 0]:
            return _Ahead(found)
        if not found:
            return _Ahead(found, self._crowded(gap, side) if gap else _ENDLESS)
        low, high = (gap.low, gap.high) if gap else (line.high, line.low)
        return _Ahead(found, last=_known(low if side > 0 else high, side))

    def _beyond(self, line: _Line, i: int, side: int) -> Count | None:
        """The first that can be told from a gap on, as more and more values there put roots on the axis."""
        ahead = range(i, len(line.places) + 1) if side > 0 else range(i, -1, -1)
        for x in (x for x in ahead if not line.gap(x)):
            with suppress(UndecidedError):
                return self._count(line, x)
        return self._count(line, i)

    def _count(self, line: _Line, i: int) -> Count | None:
        """Before the i-th meeting; None where that is an end of what is allowed, or of a window."""
        low, high = line.cell(i)
        if low is None or high is None or ordered(low, high):
            return self.tally.at(self.loop.between(low, high, self.free.value))
        return None

    def _limits(self, line: _Line, i: int, below: Count | None, above: Count | None) -> list[Critical]:
        """What changes at the i-th meeting, between the counts of both sides; two limits where only the value itself differs."""
        is_plain = below and above and below != above and 0 in (below[0], above[0])
        at = None if is_plain else self._at(line.places[i])
        rows: list[tuple[Count | None, Count | None, int]] = [(below, above, 0)]
        if below is None or above is None:
            side = -1 if below is None else 1
            is_end = self.closed and line.is_whole[side > 0]  # what is beyond the end of a window is not known
            rows = [(below or at, above or at, side)] if is_end else []
        elif below == above and below[0] == 0:
            rows = [(below, at, 1), (at, above, -1)]
        elif at and at[0] == 0:
            rows = [(below, at, 1)]
        return [self._critical(line, i, x, y, own) for x, y, own in rows if x and y and x != y]

    def _at(self, x: Meeting) -> Count | None:
        """At a value itself; None where that is not known."""
        if not (isinstance(x.value, ExactNumber) and isinstance(x.value.value, Rational)):
            return (2, None) if x.omega is not None and ordered(ExactNumber(Integer(0)), x.omega) > 0 else None
        with suppress(UndecidedError):  # what is asked about need not end there
            is_allowed = self.free.rule.allows(x.value.value) and self.is_there(x.value.value)
            return self.tally.at(x.value.value) if is_allowed else None
        return None

    def _critical(self, line: _Line, i: int, below: Count, above: Count, itself: int) -> Critical:
        x, chain = line.places[i], None in (below[0], above[0])
        crowded = self.loop.turns or any(y[0] is not None and line.gap(k) for k, y in ((i, below), (i + 1, above)))
        return Critical(self.free.path, x.value, x.omega, below[0], above[0], chain and crowded, itself)


def _opens(x: Critical, side: int) -> bool:
    """Whether it is stable on one side of a limit."""
    return x.stable_side == ("above" if side > 0 else "below")


_ENDLESS = "where roots meet the imaginary axis at ever higher frequencies"


def _nearer(window: Expr | None, allowed: Expr | None, side: int) -> tuple[RealNumber | None, bool]:
    """Of the ends of a window and of what is allowed the nearer one, and whether it is the latter."""
    if window is None or allowed is None:
        end = window if allowed is None else allowed
        return None if end is None else ExactNumber(end), window is None
    is_whole = ordered(ExactNumber(allowed), ExactNumber(window)) * side >= 0
    return ExactNumber(allowed if is_whole else window), is_whole
