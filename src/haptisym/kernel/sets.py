"""For which values of a number does a verdict hold? Sets of values, and the one way to find them.

A *verdict* on one exact number is yes, no, or undecided. A ``ValueSet`` says for all values of a range which verdict they
have. It is a line of *points*, each a single value, and of *stretches*, each all values strictly between two neighbouring
points; both have a verdict, and a reason where it is undecided.

**Guaranteed** of a ValueSet at any moment, also of one that a limit cut short: every value that was searched lies in a
point or a stretch; the verdict of each is proven for all values in it, or it is undecided. Nothing is claimed of values
that were not searched. Union and intersection keep that: what one set leaves open is open unless another one settles it.

**How it is found** (``solve``). A ``Question`` is a verdict at one number, and what is known beyond that:

1. *Critical values* (``changes``): numbers at which alone the verdict may change, all of them but in stretches that are
   named as open. Between two neighbours one verdict then settles all values, however far apart they are.
2. *Cells* (``cells``): stretches that are settled as wholes, by bounds that hold for all values in them.
3. *One end* (``end``): in a narrow cell between values that hold and values that fail, the one value at which that
   changes, where it is proven that there is just one.
4. The present value, 0 and the ends of the range are asked by themselves.

What none of these settles is undecided, and stays so in the answer. A limit of time is an exception that ``solve``
catches once: what is not settled by then is undecided for that reason.

>>> from haptisym.kernel.reals import SquareRoot
>>> root = Change(SquareRoot(ExactNumber(Integer(2))))
>>> large = Question(lambda q: q * q >= 2, changes=lambda: [Changes([root])])
>>> found = solve(large, Domain(Integer(0), Integer(3)))
>>> found
<ValueSet 1.41421 to 3.00000>
>>> Integer(1) in found, Integer(2) in found
(False, True)
>>> [(x.verdict.value, x.closed) for x in found.pieces]
[('fails', (True, False)), ('holds', (True, True))]
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

import flint
from sympy import Expr, Integer, Rational

from haptisym.kernel.budget import spared, tick
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, bounds, dyadic, rational_between
from haptisym.kernel.roots import ascending, is_told, ordered

STOPPED = "stopped at the limit"
"""Why something is undecided where the time was over."""


class Verdict(StrEnum):
    """What is known of values: the verdict is yes for all of them, no for all of them, or not known."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


_VERDICTS = {True: Verdict.HOLDS, False: Verdict.FAILS, None: Verdict.UNDECIDED}


@dataclass(frozen=True)
class Domain:
    """The values that are asked about: an interval, None where it has no end, and whether its ends belong to it."""

    low: Expr | None
    high: Expr | None
    holds_low: bool = True
    holds_high: bool = True

    @property
    def ends(self) -> tuple[RealNumber | None, RealNumber | None]:
        """Both as numbers."""
        low, high = (None if x is None else ExactNumber(x) for x in (self.low, self.high))
        return low, high

    def holds(self, value: RealNumber) -> bool:
        """Whether a value is asked about."""
        low, high = (None if x is None else ordered(x, value) for x in self.ends)
        above = low is None or low > 0 or (low == 0 and self.holds_low)
        return above and (high is None or high < 0 or (high == 0 and self.holds_high))


@dataclass(frozen=True)
class Point:
    """One value by itself. ``holds`` : the verdict on it; None: undecided, for a ``reason``.

    ``bindings`` : what limits there, where the verdict changes; what they are is the business of whoever asks.
    """

    value: RealNumber
    holds: bool | None = None
    bindings: tuple[Any, ...] = ()
    reason: str = ""


@dataclass(frozen=True)
class Stretch:
    """All values strictly between two neighbouring points, or beyond the last one. ``holds`` : as of a ``Point``."""

    holds: bool | None
    reason: str = ""


@dataclass(frozen=True, repr=False)
class Piece(Shown):
    """A run of neighbouring values with one verdict, as long as it is.

    ``first``, ``last`` : the points at its ends, None where it has no end; a single value if both are the same.
    ``closed`` : whether these belong to it. ``reason`` : of undecided values.
    """

    first: Point | None
    last: Point | None
    closed: tuple[bool, bool]
    verdict: Verdict
    reason: str = ""

    @property
    def low(self) -> RealNumber | None:
        """The low end, None where there is none."""
        return None if self.first is None else self.first.value

    @property
    def high(self) -> RealNumber | None:
        """The high end, None where there is none."""
        return None if self.last is None else self.last.value

    @property
    def ends(self) -> tuple[Point, ...]:
        """The points at its ends, each once."""
        return tuple(dict.fromkeys(x for x in (self.first, self.last) if x is not None))

    @property
    def is_single(self) -> bool:
        """Whether it is one value."""
        return self.first is not None and self.first == self.last

    def _line(self) -> str:
        return spanned(self)


def spanned(piece: Piece) -> str:
    """``from 122.356 on``, ``0 to 3.5``, ``7``, ``any``."""
    low, high = (None if x is None else x.digits(6) for x in (piece.low, piece.high))
    if low is None or high is None:
        return "any" if low == high else f"up to {high}" if low is None else f"from {low} on"
    return low if piece.is_single else f"{low} to {high}"


@dataclass(frozen=True, repr=False)
class ValueSet(Shown):
    """For which values of a number a verdict holds: an ordered cover of what was searched.

    ``points`` : in ascending order; ``stretches`` : one more, of the values below the first point, between each two, and
    above the last one; None where nothing is asked about beyond that point. ``searched`` : beyond which values nothing is
    claimed.

    Guaranteed: as the module says, for each piece on its own.
    """

    points: tuple[Point, ...]
    stretches: tuple[Stretch | None, ...]
    searched: Domain = field(default=Domain(None, None), compare=False)

    @classmethod
    def all_of(cls, domain: Domain, *, holds: bool | None, reason: str = "") -> ValueSet:
        """All values of a domain with one verdict; ends that do not belong to it fail."""
        ends = zip(domain.ends, (domain.holds_low, domain.holds_high), strict=True)
        points = tuple(
            Point(x, holds if belongs else False, reason=reason if belongs else "") for x, belongs in ends if x
        )
        inside = Stretch(holds, reason)
        outer = (None if x is not None else inside for x in (domain.low, domain.high))
        low, high = outer
        stretches = (low, inside, high) if len(points) == 2 else (low, high) if points else (inside,)
        return cls(points, stretches, domain)

    def _line(self) -> str:
        return " or ".join(map(spanned, self.feasible)) or "none"

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """All that was asked about, in order, as few pieces as possible."""
        found: list[Piece] = []
        for stretch, point in zip(self.stretches, (*self.points, None), strict=True):
            before = found[-1].last if found else None
            if stretch is not None:
                _append(found, Piece(before, point, (False, False), _VERDICTS[stretch.holds], stretch.reason))
            if point is not None:
                _append(found, Piece(point, point, (True, True), _VERDICTS[point.holds], point.reason))
        return tuple(found)

    @property
    def feasible(self) -> tuple[Piece, ...]:
        """The pieces that hold."""
        return tuple(x for x in self.pieces if x.verdict is Verdict.HOLDS)

    @property
    def undecided(self) -> tuple[Piece, ...]:
        """The pieces of which nothing is proven, as far as they were searched."""
        low, high = self.searched.ends
        return tuple(
            x
            for x in self.pieces
            if x.verdict is Verdict.UNDECIDED
            and not (low is not None and x.high is not None and ordered(x.high, low) >= 0)
            and not (high is not None and x.low is not None and ordered(high, x.low) >= 0)
        )

    @property
    def reason(self) -> str:
        """Why something is undecided, each reason once."""
        return "; ".join(dict.fromkeys(x.reason for x in self.undecided if x.reason))

    @property
    def ends(self) -> tuple[Point, ...]:
        """The points at which what holds ends and something binds, in order."""
        listed = (end for piece in self.feasible for end in piece.ends)
        return tuple(x for x in listed if x.bindings)

    def about(self, value: RealNumber) -> Piece:
        """The piece in which a value lies. UndecidedError where the value is not among those that were asked about."""
        for piece in self.pieces:
            below = -1 if piece.low is None else ordered(value, piece.low)
            above = -1 if piece.high is None else ordered(piece.high, value)
            inside = below < 0 or (below == 0 and piece.closed[0])
            if inside and (above < 0 or (above == 0 and piece.closed[1])):
                return piece
        raise UndecidedError(f"the value {value!r}: it is not among those that were searched")

    def __contains__(self, value: object) -> bool:
        """Whether the verdict on a value is yes. UndecidedError where that is not known, or was not searched."""
        number = value if isinstance(value, RealNumber) else ExactNumber(Rational(str(value)))
        found = self.about(number) if self.searched.holds(number) else None
        if found is None or found.verdict is Verdict.UNDECIDED:
            why = "it was not searched" if found is None else found.reason or "nothing is proven there"
            raise UndecidedError(f"the value {number!r}: {why}")
        return found.verdict is Verdict.HOLDS

    def __and__(self, other: ValueSet) -> ValueSet:
        """The values for which both hold."""
        return combined([self, other], _all)

    def __or__(self, other: ValueSet) -> ValueSet:
        """The values for which one of them holds."""
        return combined([self, other], _any)

    def without(self, values: Sequence[RealNumber]) -> ValueSet:
        """The same with the verdict no at some values, at which there is nothing to ask about."""
        if not values:
            return self
        return self & ValueSet(
            tuple(Point(x, holds=False) for x in ascending(values, lambda x: x)),
            tuple(Stretch(holds=True) for _ in range(len(values) + 1)),
            self.searched,
        )

    def below(self, value: RealNumber | None) -> Stretch | None:
        """What is known of the values just below one; with None, of those beyond the last point."""
        if value is None:
            return self.stretches[-1]
        return self.stretches[self._place(value)]

    def at(self, value: RealNumber) -> Point | Stretch | None:
        """What is known of one value: its point, or the stretch in which it lies."""
        i = self._place(value)
        is_point = i < len(self.points) and not ordered(self.points[i].value, value)
        return self.points[i] if is_point else self.stretches[i]

    def _place(self, value: RealNumber) -> int:
        """How many points lie below a value."""
        return bisect_left(self.points, 0, key=lambda x: -ordered(x.value, value))


def _append(pieces: list[Piece], piece: Piece) -> None:
    """Put a piece to those before it; as one with the last of them if that has the same verdict for the same reason."""
    last = pieces[-1] if pieces else None
    if last is None or (last.verdict, last.reason) != (piece.verdict, piece.reason):
        pieces.append(piece)
    else:
        pieces[-1] = replace(last, last=piece.last, closed=(last.closed[0], piece.closed[1]))


Rule = Callable[[Sequence[bool | None]], bool | None]


def _all(verdicts: Sequence[bool | None]) -> bool | None:
    return False if False in verdicts else None if None in verdicts else True


def _any(verdicts: Sequence[bool | None]) -> bool | None:
    return True if True in verdicts else None if None in verdicts else False


def combined(sets: Sequence[ValueSet], rule: Rule = _all) -> ValueSet:
    """Sets of values of one number as one: by default the values for which all of them hold.

    It asks no verdicts, and puts known ends in order even where the time is over.
    """
    if len(sets) == 1:
        return sets[0]
    with spared():
        values: list[RealNumber] = []
        for x in ascending((p.value for own in sets for p in own.points), lambda x: x):
            if not values or ordered(values[-1], x):
                values.append(x)
        cells = [_between(sets, rule, x) for x in (*values, None)]
        points = tuple(_here(sets, rule, x) for x in values)
    searched = next((x.searched for x in sets), Domain(None, None))
    return ValueSet(points, tuple(cells), searched)


def _between(sets: Sequence[ValueSet], rule: Rule, high: RealNumber | None) -> Stretch | None:
    """What is known of the values just below one, by a rule; None where a set does not ask about them."""
    found = [own for x in sets if (own := x.below(high)) is not None]
    if len(found) < len(sets):
        return None
    holds = rule([x.holds for x in found])
    return Stretch(holds, _reasons(found) if holds is None else "")


def _here(sets: Sequence[ValueSet], rule: Rule, value: RealNumber) -> Point:
    """What is known of one value, by a rule."""
    found = [x.at(value) or Stretch(holds=False) for x in sets]
    holds = rule([x.holds for x in found])
    bindings = (b for x in found if isinstance(x, Point) for b in x.bindings)
    return Point(value, holds, tuple(dict.fromkeys(bindings)), _reasons(found) if holds is None else "")


def _reasons(found: Iterable[Point | Stretch]) -> str:
    return "; ".join(dict.fromkeys(x.reason for x in found if x.holds is None and x.reason))


@dataclass(frozen=True)
class Change:
    """A value at which a verdict may change, and what binds there."""

    value: RealNumber
    bindings: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Open:
    """Values between two (None: without end) among which others may change a verdict, for a ``reason``."""

    low: RealNumber | None
    high: RealNumber | None
    reason: str = ""

    def covers(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether all values between two others are among them."""
        above = self.low is None or (low is not None and ordered(self.low, low) >= 0)
        return above and (self.high is None or (high is not None and ordered(high, self.high) >= 0))


@dataclass(frozen=True)
class Changes:
    """All values at which a verdict may change, but for those in stretches that are ``open``."""

    values: Sequence[Change] = ()
    open: Sequence[Open] = ()


@dataclass(frozen=True)
class Cell:
    """Values between two, both of them among these, and the verdict that is proven for all of them; None: none is."""

    low: RealNumber | None
    high: RealNumber | None
    holds: bool | None
    reason: str = ""


def _nothing_known() -> Iterable[Changes]:
    return [Changes(open=[Open(None, None)])]


@dataclass(frozen=True)
class Question:
    """A verdict on values of a number, and what is known of it beyond single values.

    ``verdict`` : of a rational number, exact; None, or an UndecidedError with the reason: undecided. ``own`` : the value
    that the number has now: what lies near to it is asked first.
    ``changes`` : gives critical values, again and again with fewer that are open; those that are given last count.
    UndecidedError: the rest stays open for that reason.
    ``at`` : the verdict at a critical value that is not rational and lies beside values that hold; None: like them.
    ``cells`` : covers the values between two, in order. ``end`` : of a cell between values of which one side holds and the other
    fails, and whether the lower one holds, the one value at which that changes; None where that is not proven to be one.
    ``alone`` : further values that are asked by themselves.
    """

    verdict: Callable[[Rational], bool | None]
    own: Expr | None = None
    changes: Callable[[], Iterable[Changes]] = _nothing_known
    at: Callable[[Change], bool | None] | None = None
    cells: Callable[[RealNumber | None, RealNumber | None], Iterable[Cell]] | None = None
    end: Callable[[RealNumber, RealNumber, bool], Point | None] | None = None
    alone: Sequence[Expr] = ()


def solve(question: Question, domain: Domain, searched: Domain | None = None, *, near: bool = False) -> ValueSet:
    """The values of a domain for which the verdict is yes, as far as that is found in time.

    ``searched`` : outside of which nothing is claimed; the domain if not given.
    ``near`` : only as far from the question's own value as it takes to know between which values its verdict holds, and
    where it fails, between which it holds next; the rest is undecided.
    """
    work = _Solving(question, domain, near=near)
    with suppress(LimitError):
        work.run()
    with spared():
        work.settle_points()
    return replace(work.found, searched=searched or domain)


class _Solving:
    """A set that is being found: points and stretches, of which more and more are settled."""

    def __init__(self, question: Question, domain: Domain, *, near: bool) -> None:
        self.question, self.domain, self.near = question, domain, near
        self.own = None if question.own is None or not question.own.is_number else ExactNumber(question.own)
        self.asked: dict[Rational, Point] = {}
        whole = ValueSet.all_of(domain, holds=None, reason=STOPPED)
        self.points: list[Point] = [replace(x, holds=None, reason="") for x in whole.points]
        self.stretches: list[Stretch | None] = [*whole.stretches]

    @property
    def found(self) -> ValueSet:
        """The set as it stands."""
        return ValueSet(tuple(self.points), tuple(self.stretches), self.domain)

    def run(self) -> None:
        """Settle what can be settled. LimitError where the time is over."""
        self._use_changes()
        self._use_cells()
        self._use_ends()
        self.settle_points(ask=True)
        self._ask_alone()

    # Critical values

    def _use_changes(self) -> None:
        try:
            for changes in self.question.changes():
                self._place(changes)
                if self._ask_between(changes.open):
                    break
        except LimitError:
            raise
        except UndecidedError as error:
            self.stretches = [
                replace(x, reason=str(error)) if x is not None and x.holds is None else x for x in self.stretches
            ]

    def _place(self, changes: Changes) -> None:
        """Cut the domain at critical values, and at the ends of what is open, anew."""
        edges = [Change(x) for own in changes.open for x in (own.low, own.high) if x is not None]
        inside = [x for x in (*changes.values, *edges) if is_told(x.value) and self._is_inside(x.value)]
        ends = [Change(x) for x in self.domain.ends if x is not None]
        self.points = []
        for x in ascending([*ends, *inside], lambda x: x.value):
            if self.points and not ordered(self.points[-1].value, x.value):
                last = self.points[-1]
                self.points[-1] = replace(last, bindings=tuple(dict.fromkeys((*last.bindings, *x.bindings))))
            else:
                self.points.append(Point(x.value, bindings=x.bindings))
        unknown = Stretch(None, STOPPED)
        self.stretches = [
            None if self.domain.low is not None else unknown,
            *[unknown] * (len(self.points) - 1),
            *([] if not self.points else [None if self.domain.high is not None else unknown]),
        ]

    def _is_inside(self, value: RealNumber) -> bool:
        """Whether a value lies in the domain, or at an end of it."""
        return replace(self.domain, holds_low=True, holds_high=True).holds(value)

    def _ends(self, i: int) -> tuple[RealNumber | None, RealNumber | None]:
        """Between which values the i-th stretch lies."""
        low = self.points[i - 1].value if i else None
        return low, self.points[i].value if i < len(self.points) else None

    def _ask_between(self, open_: Sequence[Open]) -> bool:
        """Ask a value of each stretch that is not open, the nearest first; whether nothing is left to be found."""
        home = self._home()
        is_done = True
        for side in (0, 1, -1):
            verdicts: list[bool | None] = [] if not side else self._known_at(home)
            for i in self._on_side(home, side):
                self.stretches[i] = self._of_stretch(i, open_)
                verdicts.append(self.stretches[i].holds)
                if self.near and _is_enough(verdicts):
                    break
            is_done = is_done and None not in verdicts
        return is_done

    def _known_at(self, i: int) -> list[bool | None]:
        stretch = self.stretches[i]
        return [] if stretch is None else [stretch.holds]

    def _home(self) -> int:
        """The stretch in which the question's own value lies, or which ends there; the first one where it has none."""
        if self.own is None:
            return next(i for i, x in enumerate(self.stretches) if x is not None)
        values = [x.value for x in self.points]
        i = bisect_left(values, 0, key=lambda x: -ordered(x, self.own))
        if self.stretches[i] is not None:
            return i
        return i + 1 if i + 1 < len(self.stretches) else i - 1

    def _on_side(self, home: int, side: int) -> Iterator[int]:
        """The stretches on a side of the home, from there on; of no side the home itself."""
        every = range(home + 1, len(self.stretches)) if side > 0 else range(home - 1, -1, -1)
        yield from (i for i in ([home] if not side else every) if self.stretches[i] is not None)

    def _of_stretch(self, i: int, open_: Sequence[Open]) -> Stretch:
        low, high = self._ends(i)
        around = next((x for x in open_ if x.covers(low, high)), None)
        if around is not None:
            return Stretch(None, around.reason)
        for value, point in self.asked.items():
            if self._is_strictly_between(low, ExactNumber(value), high):
                return Stretch(point.holds, point.reason)
        found = self._ask(rational_between(low, high, self.question.own))
        return Stretch(found.holds, found.reason)

    @staticmethod
    def _is_strictly_between(low: RealNumber | None, x: RealNumber, high: RealNumber | None) -> bool:
        return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)

    def _ask(self, value: Rational) -> Point:
        """The verdict on one value. LimitError where the time is over before it."""
        if value not in self.asked:
            tick()
            self.asked[value] = _answered(self.question, value)
        return self.asked[value]

    # Cells

    def _use_cells(self) -> None:
        """Fill what is open by cells."""
        if self.question.cells is None:
            return
        for i in reversed(range(len(self.stretches))):
            stretch = self.stretches[i]
            if stretch is not None and stretch.holds is None:
                low, high = self._ends(i)
                cells = list(self.question.cells(low, high))
                if cells:
                    self._splice(i, cells)

    def _splice(self, i: int, cells: Sequence[Cell]) -> None:
        """Put cells in place of a stretch. What is between two of them is told by the one that is settled, as both hold it."""
        inner = [
            Point(a.high, b.holds if a.holds is None else a.holds) for a, b in pairwise(cells) if a.high is not None
        ]
        self.points[i:i] = inner
        self.stretches[i : i + 1] = [Stretch(x.holds, x.reason) for x in cells]

    def _use_ends(self) -> None:
        """Find the one end in what is open between values that hold and values that fail."""
        if self.question.end is None:
            return
        for i in reversed(range(1, len(self.stretches) - 1)):
            before, own, after = self.stretches[i - 1 : i + 2]
            if own is None or own.holds is not None or before is None or after is None:
                continue
            low, high = self._ends(i)
            if low is None or high is None or {before.holds, after.holds} != {True, False}:
                continue
            tick()
            point = self.question.end(low, high, before.holds is True)
            if point is not None:
                self.points[i:i] = [point]
                self.stretches[i : i + 1] = [Stretch(before.holds), Stretch(after.holds)]

    # Single values

    def settle_points(self, *, ask: bool = False) -> None:
        """Tell the verdict of points, as far as that needs no more than their neighbours; or by asking it."""
        for i, point in enumerate(self.points):
            if point.holds is None and (ask or point.value not in self._ends_of_domain):
                self.points[i] = self._settled(i, ask=ask)

    @cached_property
    def _ends_of_domain(self) -> tuple[RealNumber | None, ...]:
        return self.domain.ends

    def _settled(self, i: int, *, ask: bool) -> Point:
        """A point with its verdict: its own where it is rational, else as its neighbours and the question tell."""
        point, near = self.points[i], [x.holds for x in self.stretches[i : i + 2] if x is not None]
        if not self.domain.holds(point.value):
            return replace(point, holds=False)
        if isinstance(point.value, ExactNumber) and isinstance(point.value.value, Rational):
            if not ask:
                return replace(point, reason=STOPPED)
            found = self._ask(point.value.value)
            return replace(point, holds=found.holds, reason=found.reason)
        if True not in near:
            is_open = None in near
            return replace(point, holds=None if is_open else False, reason=self._reason_near(i) if is_open else "")
        told = self.question.at(Change(point.value, point.bindings)) if self.question.at and point.bindings else True
        return replace(point, holds=True if told is None else told)

    def _reason_near(self, i: int) -> str:
        return next((x.reason for x in self.stretches[i : i + 2] if x is not None and x.holds is None), "")

    def _ask_alone(self) -> None:
        """Ask the present value, 0, and others that lie in what is open."""
        own = [] if self.question.own is None else [self.question.own]
        for value in dict.fromkeys([*own, Integer(0), *self.question.alone]):
            number = ExactNumber(value)
            if not isinstance(value, Rational) or not self.domain.holds(number):
                continue
            i = bisect_left(self.points, 0, key=lambda x: -ordered(x.value, number))
            is_point = i < len(self.points) and not ordered(self.points[i].value, number)
            stretch = self.stretches[i]
            if not is_point and stretch is not None and stretch.holds is None:
                found = self._ask(value)
                if found.holds is not None:
                    self.points[i:i] = [found]
                    self.stretches[i:i] = [stretch]


def _is_enough(verdicts: Sequence[bool | None]) -> bool:
    """Whether it is known, from a value on to one side, where its verdict ends, and where it fails, what holds next."""
    if None in verdicts:
        return True
    changes = sum(a != b for a, b in pairwise(verdicts))
    return changes >= (1 if verdicts[0] else 2)


def _answered(question: Question, value: Rational) -> Point:
    """The verdict of a question on one value, or why it is not known."""
    number = ExactNumber(value)
    try:
        return Point(number, question.verdict(value))
    except LimitError:
        tick()
        return Point(number, reason=STOPPED)
    except UndecidedError as error:
        return Point(number, reason=str(error))


@dataclass(frozen=True, repr=False)
class Bisected(RealNumber):
    """The one value between two at which a verdict changes, closed in on by asking it: ``low_holds`` : of the lower one.

    ``verdict`` : of a rational number, exact. ``excess`` : how far a number fails, if it does, at the working precision: where
    that, or its root, is about linear, its zero tells where to ask.
    Guaranteed of each ball: the verdict of its ends differs.
    """

    verdict: Callable[[Rational], bool | None]
    low: Fraction
    high: Fraction
    low_holds: bool
    excess: Callable[[Rational], Ball] | None = None
    _known: dict[str, Any] = field(default_factory=dict, compare=False)

    @property
    def known(self) -> tuple[Fraction, Fraction]:
        """Two values between which it lies, as far as that is known."""
        low, high = self._known.get("", (self.low, self.high))
        return low, high

    def between(self, bits: int) -> tuple[Fraction, Fraction]:
        """Two values between which it lies, of about that relative accuracy."""
        low, high = self.known
        sharp, is_root = 4, False
        with flint.ctx.workprec(2 * bits + 64):
            while (high - low) * 2**bits > max(abs(low), abs(high)):
                tick()
                width, near = high - low, self._guess(is_root=is_root)
                off = width / 2**sharp
                for x in [(low + high) / 2] if near is None else [near - off, near + off]:
                    if low < x < high and not self._ask(Fraction(*_short(x - off / 2, x + off / 2))):
                        return self.known
                    low, high = self.known
                is_near = near is not None and (high - low) * 2 ** (sharp - 2) < width
                sharp, is_root = (2 * sharp, is_root) if is_near else (4, is_root is (near is None))
        return low, high

    def _ask(self, value: Fraction) -> bool:
        """Narrow it down by the verdict on one value; whether there is one."""
        low, high = self.known
        try:
            holds = self.verdict(_rational(value))
        except UndecidedError:
            holds = None
        if holds is not None:
            self._known[""] = (value, high) if holds == self.low_holds else (low, value)
        return holds is not None

    @property
    def beyond(self) -> Fraction:
        """The nearest value that is known to fail."""
        return self.known[self.low_holds]

    def _guess(self, *, is_root: bool) -> Fraction | None:
        """Where it lies if the excess, or its root, is linear beyond it, by the last two values that fail; None if not known."""
        if self.excess is None:
            return None
        last = self._known.get("last")
        if last is None or last[0] != self.beyond:
            self._known["before"], last = last, (self.beyond, self.excess(_rational(self.beyond)))
            self._known["last"] = last
        before = self._known.get("before")
        if before is None:
            return None
        (x, f), (y, g) = ((dyadic(a), b.sqrt() if is_root else b) for a, b in (last, before))
        at = (x - (y - x) * f / (g - f)).mid()
        near = bounds(at)[0] if at.is_finite() else self.low
        return near if self.known[0] < near < self.known[1] else None

    def rough(self) -> Ball:
        low, high = self.known
        return dyadic(low).union(dyadic(high))

    def ball(self, bits: int) -> Ball:
        low, high = self.between(bits)
        with flint.ctx.workprec(bits + 32):
            return dyadic(low).union(dyadic(high))


def _rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def _short(low: Fraction, high: Fraction) -> tuple[int, int]:
    """About the middle between two numbers, a dyadic one with as few bits as do, as numerator and denominator."""
    middle, width = (low + high) / 2, (high - low) / 8
    places = max(0, -(width.numerator.bit_length() - width.denominator.bit_length()) + 1)
    return round(middle * 2**places), 2**places
