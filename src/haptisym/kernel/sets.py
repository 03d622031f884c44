"""For which values of a parameter does a verdict hold? Sets of values, and the one way to find
them.

A *verdict* on one exact number is yes, no, or undecided. A ``ValueSet`` says for all values of a
range which verdict they have. It is a line of *points*, each a single value, and of *stretches*,
each all values strictly between two neighbouring points; both have a verdict, and a reason where it
is undecided.

**Guaranteed** of a ValueSet at any moment, also of one that a limit cut short: every value that was
searched lies in a point or a stretch; the verdict of each is proven for all values in it, or it is
undecided. Nothing is claimed of values that were not searched. Union and intersection keep that:
what one set leaves open is open unless another one settles it.

**How it is found** (``solve``). A ``Question`` is a verdict at one number, and what is known beyond
that:

1. *Critical values* (``changes``): numbers at which alone the verdict may change, all of them but
   in stretches that are named as open. Between two neighbours one verdict then settles all values,
   however far apart they are.
2. *Cells* (``cells``): stretches that are settled as wholes, by bounds that hold for all values in
   them.
3. *One end* (``end``): in a narrow cell between values that hold and values that fail, the one
   value at which that changes, where it is proven that there is just one.
4. The present value, 0 and the ends of the range are asked by themselves.

What none of these settles is undecided, and stays so in the answer. A limit of time is an exception
that ``solve`` catches once: what is not settled by then is undecided for that reason.

>>> from haptisym.kernel.reals import SquareRoot
>>> root = CriticalValue(SquareRoot(ExactNumber(Integer(2))))
>>> large = Question(lambda q: q * q >= 2, changes=lambda: [CriticalValues([root])])
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
from collections.abc import Callable, Iterable, Sequence
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
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    RealNumber,
    bounds,
    dyadic,
    rational,
    rational_between,
)
from haptisym.kernel.roots import ascending, is_told, ordered

STOPPED = "stopped at the limit"
"""Why something is undecided where the time was over."""
UNSEARCHED = "not searched"
"""Why nothing is known of values that nobody looked at: they are no part of what was searched."""
NOT_NEEDED = "beyond the nearest ends"
"""The same of a set of which only what lies near to the present value was asked for."""
_UNASKED_REASONS = UNSEARCHED, NOT_NEEDED
_UNTOLD = "where a verdict changes is not known closely enough"
_ALONE = "whether it holds at this one value is not known"


class Verdict(StrEnum):
    """What is known of values: the verdict is yes for all of them, no for all of them, or not
    known."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


_VERDICTS = {True: Verdict.HOLDS, False: Verdict.FAILS, None: Verdict.UNDECIDED}


def _is_up_to(high: RealNumber | None, low: RealNumber | None) -> bool:
    """Whether values that end at ``high`` lie below those that begin at ``low``; False where one of
    the two is None, that is, has no end there."""
    # ``ordered(x, y)`` is 1 where y is the larger number: here ``high <= low``.
    return high is not None and low is not None and ordered(high, low) >= 0


@dataclass(frozen=True)
class Domain:
    """The values that are asked about: an interval, None where it has no end, and whether its ends
    belong to it."""

    low: Expr | None
    high: Expr | None
    holds_low: bool = True
    holds_high: bool = True

    @property
    def ends(self) -> tuple[ExactNumber | None, ExactNumber | None]:
        """The low and the high end as numbers; None where there is none."""
        low, high = (None if x is None else ExactNumber(x) for x in (self.low, self.high))
        return low, high

    def holds(self, value: RealNumber) -> bool:
        """Whether a value belongs to the domain."""
        low, high = (None if x is None else ordered(x, value) for x in self.ends)
        above = low is None or low > 0 or (low == 0 and self.holds_low)
        return above and (high is None or high < 0 or (high == 0 and self.holds_high))

    def misses(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether no value strictly between two others belongs to the domain."""
        first, last = self.ends
        return _is_up_to(high, first) or _is_up_to(last, low)

    @staticmethod
    def common(domains: Sequence[Domain]) -> Domain:
        """The intersection of some domains."""
        lows, highs = ([x for own in domains if (x := own.ends[i]) is not None] for i in (0, 1))
        low = ascending(lows, lambda x: x)[-1] if lows else None
        high = ascending(highs, lambda x: x)[0] if highs else None
        belongs = (x is None or all(own.holds(x) for own in domains) for x in (low, high))
        return Domain(low and low.value, high and high.value, *belongs)


@dataclass(frozen=True)
class SingleValue:
    """One value by itself. ``holds`` : the verdict on it; None: undecided, for a ``reason``.

    ``bindings`` : the conditions that limit there, where the verdict changes, as the ``Question``
    gave them; this module only passes them on.
    """

    value: RealNumber
    holds: bool | None = None
    bindings: tuple[Any, ...] = ()
    reason: str = ""


@dataclass(frozen=True)
class Stretch:
    """All values strictly between two neighbouring points, or beyond the last one. ``holds`` : as
    of a ``SingleValue``."""

    holds: bool | None
    reason: str = ""


@dataclass(frozen=True, repr=False)
class Piece(Shown):
    """A run of neighbouring values with one verdict, as long as possible.

    ``first``, ``last`` : the points at its ends, None where it has no end; a single value if both
    are the same.
    ``closed`` : whether these belong to it. ``reason`` : of undecided values.
    """

    first: SingleValue | None
    last: SingleValue | None
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
    def ends(self) -> tuple[SingleValue, ...]:
        """The points at its ends, each once."""
        return tuple(dict.fromkeys(x for x in (self.first, self.last) if x is not None))

    @property
    def is_single(self) -> bool:
        """Whether it is one value."""
        return self.first is not None and self.first == self.last

    def is_open_beyond(self, end: RealNumber | None, side: int) -> bool:
        """Whether the piece is undecided and is all that lies beyond ``end`` on that side (1:
        above, -1: below), without an end of its own there."""
        inner, outer = (self.low, self.high)[::side]
        if (
            self.verdict is not Verdict.UNDECIDED
            or outer is not None
            or inner is None
            or end is None
        ):
            return False
        return ordered(end, inner) * side >= 0

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

    ``pieces`` : runs of values that hold, fail or are undecided, in order; ``feasible`` and
    ``undecided`` : those of one kind. ``value in found`` is true, false, or an UndecidedError that
    says why it is not known; ``&`` and ``|`` are the values for which two sets hold, or one of them
    does; ``about`` is the piece in which a value lies.

    ``points`` : single values, in ascending order; ``stretches`` : one more, of the values below
    the first point, between each two, and above the last one; None where nothing is asked about.
    ``searched`` : beyond which values nothing is claimed.

    Guaranteed of each piece on its own, also where a limit cut the work short: its verdict is
    proven for all its values.

    >>> import haptisym as hs
    >>> low, high = (hs.require("fu2019", path).values for path in ("omega_n", "zeta"))
    >>> low, [(x.verdict.value, x.closed) for x in low.pieces], 150 in low
    (<ValueSet from 122.356 on>, [('fails', (True, False)), ('holds', (True, False))], True)
    >>> high.ends[0].value.digits(12), high.ends[0].bindings[0].kind.value
    ('0.264345145449', 'band-edge')
    """

    points: tuple[SingleValue, ...]
    stretches: tuple[Stretch | None, ...]
    searched: Domain = field(default=Domain(None, None), compare=False)

    @classmethod
    def all_of(cls, domain: Domain, *, holds: bool | None, reason: str = "") -> ValueSet:
        """A set in which all values of a domain have one verdict; ends that do not belong to the
        domain fail."""
        points = tuple(
            SingleValue(x, holds, reason=reason) if domain.holds(x) else SingleValue(x, holds=False)
            for x in domain.ends
            if x is not None
        )
        stretches = [Stretch(holds, reason)] * (len(points) + 1)
        return cls(points, _bounded(domain, stretches), domain)

    @property
    def said(self) -> str:
        """What holds, in a line: ``from 122.356 on``, ``0 to 3.5 or 7``; ``none``."""
        return " or ".join(map(spanned, self.feasible)) or "none"

    def _line(self) -> str:
        return self.said

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """All that was asked about, in order, as few pieces as possible.

        What is open beyond what was searched is no piece: the last one that is then has no end on
        that side.
        """
        pieces: list[Piece] = []
        # Stretches and points alternate: a stretch, its upper point, the next stretch, and so on.
        for stretch, point in zip(self.stretches, (*self.points, None), strict=True):
            before = pieces[-1].last if pieces else None
            if stretch is not None:
                verdict = _VERDICTS[stretch.holds]
                _append(pieces, Piece(before, point, (False, False), verdict, stretch.reason))
            if point is not None:
                verdict = _VERDICTS[point.holds]
                _append(pieces, Piece(point, point, (True, True), verdict, point.reason))
        # Beyond the range searched nothing is claimed: the last searched piece has no end there,
        # rather than an end that nobody has found.
        low, high = self.searched.ends
        if len(pieces) > 1 and pieces[-1].is_open_beyond(high, 1):
            pieces[-2:] = [replace(pieces[-2], last=None, closed=(pieces[-2].closed[0], False))]
        if len(pieces) > 1 and pieces[0].is_open_beyond(low, -1):
            pieces[:2] = [replace(pieces[1], first=None, closed=(False, pieces[1].closed[1]))]
        return tuple(pieces)

    @property
    def feasible(self) -> tuple[Piece, ...]:
        """The pieces that hold."""
        return tuple(x for x in self.pieces if x.verdict is Verdict.HOLDS)

    def is_alone(self, piece: Piece) -> bool:
        """Whether a piece is a single value, and the verdict on both its neighbours is known."""
        beside = (x for x in self.pieces if x is not piece and {x.first, x.last} & {piece.first})
        return piece.is_single and all(x.verdict is not Verdict.UNDECIDED for x in beside)

    @property
    def undecided(self) -> tuple[Piece, ...]:
        """The searched pieces on which nothing is proven."""
        return tuple(
            x
            for x in self.pieces
            if x.verdict is Verdict.UNDECIDED
            and x.reason not in _UNASKED_REASONS
            and self._is_searched(x)
        )

    def _is_searched(self, x: Piece) -> bool:
        """Whether a value of the piece was searched; the ends of the range searched count, too."""
        closed = replace(self.searched, holds_low=True, holds_high=True)
        if x.is_single and x.first:
            return closed.holds(x.first.value)
        return not closed.misses(x.low, x.high)

    @property
    def reason(self) -> str:
        """Why something is undecided, each reason once; empty where nothing is."""
        return _joined(x.reason for x in self.undecided)

    @property
    def ends(self) -> tuple[SingleValue, ...]:
        """The points, in order, at which a piece that holds ends because some condition binds; not
        those at which only the range ends."""
        listed = (end for piece in self.feasible for end in piece.ends)
        return tuple(x for x in listed if x.bindings)

    def end(self, value: RealNumber, side: int) -> SingleValue | None:
        """The end, above (side 1) or below (side -1), of the piece in which a value lies, if a
        condition binds there; None where there is no such end, or none that is known."""
        piece = self.about(value)
        end = piece.last if side > 0 else piece.first
        return end if end in self.ends else None

    def unknown(self, value: RealNumber, side: int) -> Piece | None:
        """The first undecided piece from a value on towards a side (1: above, -1: below); None
        where all is decided, or no more was needed."""
        ahead = self.pieces if side > 0 else self.pieces[::-1]
        onward = ahead[ahead.index(self.about(value)) :]
        first = next((x for x in onward if x.verdict is Verdict.UNDECIDED), None)
        return None if first is None or first.reason == NOT_NEEDED else first

    def about(self, value: RealNumber) -> Piece:
        """The piece in which a value lies. UndecidedError where the value is not among those that
        were asked about."""
        # ``ordered(x, y)`` is 1 where y is the larger: both are negative strictly inside the piece.
        for piece in self.pieces:
            below = -1 if piece.low is None else ordered(value, piece.low)
            above = -1 if piece.high is None else ordered(piece.high, value)
            inside = below < 0 or (below == 0 and piece.closed[0])
            if inside and (above < 0 or (above == 0 and piece.closed[1])):
                return piece
        raise UndecidedError(f"the value {value!r}: it is not among those that were asked about")

    def __contains__(self, value: object) -> bool:
        """Whether the verdict on a value is yes. UndecidedError where that is not known, or was not
        searched."""
        number = _as_number(value)
        piece = self.about(number)
        if piece.verdict is Verdict.UNDECIDED:
            raise UndecidedError(
                f"the value {number!r}: {piece.reason or 'nothing is proven there'}"
            )
        # A piece may have been extended beyond the range searched (see ``pieces``); a point
        # outside, such as the present value, was asked by itself.
        if not self.searched.holds(number) and not isinstance(self.at(number), SingleValue):
            raise UndecidedError(f"the value {number!r}: it was not searched")
        return piece.verdict is Verdict.HOLDS

    def __and__(self, other: ValueSet) -> ValueSet:
        """The values for which both hold."""
        return combined([self, other], _all)

    def __or__(self, other: ValueSet) -> ValueSet:
        """The values for which one of them holds."""
        return combined([self, other], _any)

    def without(self, values: Sequence[RealNumber]) -> ValueSet:
        """The set with the verdict no at some values, for which the question has no meaning."""
        gone = _each_once(SingleValue(x, holds=False) for x in values)
        return self & ValueSet(tuple(gone), (Stretch(holds=True),) * (len(gone) + 1))

    def below(self, value: RealNumber | None) -> Stretch | None:
        """What is known of the values just below one; with None, of those beyond the last point."""
        return self.stretches[-1 if value is None else _place(self.points, value)[0]]

    def at(self, value: RealNumber) -> SingleValue | Stretch | None:
        """What is known of one value: its point, or the stretch in which it lies."""
        i, is_point = _place(self.points, value)
        return self.points[i] if is_point else self.stretches[i]


def _as_number(value: object) -> RealNumber:
    if isinstance(value, RealNumber):
        return value
    return ExactNumber(value if isinstance(value, Expr) else Rational(str(value)))


def _place(points: Sequence[SingleValue], value: RealNumber) -> tuple[int, bool]:
    """How many points lie below a value, and whether the next point is that value."""
    # ``ordered`` is 0 for numbers that 600 bits do not distinguish: they count as one value.
    i = bisect_left(points, 0, key=lambda x: -ordered(x.value, value))
    return i, i < len(points) and not ordered(points[i].value, value)


def _each_once(points: Iterable[SingleValue]) -> list[SingleValue]:
    """Points in ascending order, those at one value merged: with all bindings, and with the exact
    number where one of them has it."""
    merged = list[SingleValue]()
    for x in ascending(points, lambda x: x.value):
        if merged and not ordered(merged[-1].value, x.value):
            last = merged[-1]
            value = x.value if isinstance(x.value, ExactNumber) else last.value
            merged[-1] = replace(
                last, value=value, bindings=tuple(dict.fromkeys((*last.bindings, *x.bindings)))
            )
        else:
            merged.append(x)
    return merged


def _bounded(domain: Domain, stretches: Sequence[Stretch]) -> tuple[Stretch | None, ...]:
    """The stretches with None in place of those beyond the ends of a domain."""
    bounded = list[Stretch | None](stretches)
    if domain.low is not None:
        bounded[0] = None
    if domain.high is not None:
        bounded[-1] = None
    return tuple(bounded)


def _append(pieces: list[Piece], piece: Piece) -> None:
    """Append a piece, or merge it with the last one if both have the same verdict."""
    last = pieces[-1] if pieces else None
    # Undecided values that were searched, and those that were not, stay apart: only the former
    # are reported as undecided.
    is_asked = [x is not None and x.reason not in _UNASKED_REASONS for x in (last, piece)]
    if last is None or last.verdict is not piece.verdict or is_asked[0] is not is_asked[1]:
        pieces.append(piece)
        return
    if is_asked[1]:
        reason = _joined([last.reason, piece.reason])
    else:
        reason = UNSEARCHED if UNSEARCHED in (last.reason, piece.reason) else NOT_NEEDED
    pieces[-1] = replace(
        last, last=piece.last, closed=(last.closed[0], piece.closed[1]), reason=reason
    )


def _joined(reasons: Iterable[str]) -> str:
    """All reasons in one text, each once."""
    every = (x for reason in reasons for x in reason.split("; "))
    return "; ".join(dict.fromkeys(x for x in every if x))


Rule = Callable[[Sequence[bool | None]], bool | None]


# Logic of three values: one False settles "all", one True settles "any", whatever is undecided.
def _all(verdicts: Sequence[bool | None]) -> bool | None:
    return False if False in verdicts else None if None in verdicts else True


def _any(verdicts: Sequence[bool | None]) -> bool | None:
    return True if True in verdicts else None if None in verdicts else False


def combined(sets: Sequence[ValueSet], rule: Rule = _all) -> ValueSet:
    """Combine sets of values of one parameter, over the values that all of them ask about: by
    default the values for which all hold.

    No verdict is asked. Works even where the time is over, as it only puts known points in order.
    """
    if len(sets) == 1:
        return sets[0]
    # Between two neighbours of all points of all sets each set has one verdict: it is enough to
    # combine the verdicts at every point, just below it, and above the last one.
    with spared():
        points, stretches = list[SingleValue](), list[Stretch | None]()
        for x in _each_once(p for own in sets for p in own.points):
            here = _together([own.at(x.value) for own in sets], rule)
            if here is not None:
                points.append(replace(x, holds=here.holds, reason=here.reason))
                stretches.append(_together([own.below(x.value) for own in sets], rule))
        stretches.append(_together([own.below(None) for own in sets], rule))
        searched = Domain.common([own.searched for own in sets])
    return ValueSet(tuple(points), tuple(stretches), searched)


def _together(found: Sequence[SingleValue | Stretch | None], rule: Rule) -> Stretch | None:
    """The combined verdict on values, from their verdicts in several sets; None where one of these
    does not ask about them."""
    known = [x for x in found if x is not None]
    if len(known) < len(found):
        return None
    holds = rule([x.holds for x in known])
    if holds is not None:
        return Stretch(holds, "")
    return Stretch(holds, _joined(x.reason for x in known if x.holds is None))


@dataclass(frozen=True)
class CriticalValue:
    """A value at which a verdict may change, and the conditions that bind there."""

    value: RealNumber
    bindings: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Open:
    """A range between two values (None: without end) in which critical values may have been missed,
    for a ``reason``."""

    low: RealNumber | None
    high: RealNumber | None
    reason: str = ""

    def covers(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether all values between two others lie in the range."""
        above = self.low is None or (low is not None and ordered(self.low, low) >= 0)
        return above and (self.high is None or (high is not None and ordered(high, self.high) >= 0))


@dataclass(frozen=True)
class CriticalValues:
    """All values at which a verdict may change, but for those in stretches that are ``open``."""

    values: Sequence[CriticalValue] = ()
    open: Sequence[Open] = ()


@dataclass(frozen=True)
class Cell:
    """A closed interval of values, and the verdict that is proven for all of them; None where none
    is."""

    low: RealNumber | None
    high: RealNumber | None
    holds: bool | None
    reason: str = ""


def _nothing_known() -> Iterable[CriticalValues]:
    """No value is known at which a verdict may change."""
    return [CriticalValues(open=[Open(None, None)])]


@dataclass(frozen=True)
class Question:
    """A verdict on values of a parameter, and what is known of it beyond single values.

    ``verdict`` : gives the verdict on a rational number, exactly; None, or an UndecidedError with
    the reason, where it is undecided.
    ``own`` : the parameter's present value. It is asked first, and what lies near to it before what
    is far.
    ``changes`` : yields critical values, each time with fewer ranges left open; the last ones
    count, and replace all that were given before.
    ``at`` : gives the verdict at an irrational critical value next to values that hold; None means
    that it holds like them.
    ``lone`` : gives the verdict at an irrational critical value between values that fail; None
    means unknown. Without ``lone`` such a value fails like its neighbours, which is right for
    strict conditions.
    ``cells`` : covers the range between two values by cells, in order.
    ``end`` : given a range between values that hold on one side and fail on the other, and whether
    the lower ones hold, gives the one value at which that changes; None where it is not proven that
    there is just one.
    ``alone`` : further values that are asked by themselves.

    An UndecidedError in any of them leaves open what it was asked for, for that reason.
    """

    verdict: Callable[[Rational], bool | None]
    own: Expr | None = None
    changes: Callable[[], Iterable[CriticalValues]] = _nothing_known
    at: Callable[[CriticalValue], bool | None] | None = None
    cells: Callable[[RealNumber | None, RealNumber | None], Iterable[Cell]] | None = None
    end: Callable[[RealNumber, RealNumber, bool], SingleValue | None] | None = None
    alone: Sequence[Expr] = ()
    lone: Callable[[CriticalValue], bool | None] | None = None


def solve(
    question: Question, domain: Domain, searched: Domain | None = None, *, near: bool = False
) -> ValueSet:
    """The values of a domain for which the verdict is yes, as far as that is found in time.

    ``searched`` : outside of which nothing is claimed; the domain if not given.
    ``near`` : only as far from the question's own value as it takes to know between which values
    its verdict holds, and where it fails, between which it holds next; the rest is undecided.
    """
    work = _Solving(question, domain, searched or domain, near=near)
    # The one place where a limit of time ends a search: what is settled by then is proven, and
    # reading it off must not be cut short again.
    with suppress(LimitError):
        work.run()
    with spared():
        return work.found()


_TO_ASK = Stretch(None, STOPPED)
"""A stretch all of whose values have one verdict that was not asked for yet. It equals an undecided
one, and is distinguished from it by identity."""


class _Solving:
    """A set that is being found: points and stretches, of which more and more are settled.

    At any moment what is known of each is proven, so that work that is broken off leaves a set as
    well.
    """

    def __init__(self, question: Question, domain: Domain, searched: Domain, *, near: bool) -> None:
        self.question, self.domain, self.searched, self.near = question, domain, searched, near
        self.asked: dict[Rational, SingleValue] = {}
        self.points = list[SingleValue]()
        self.stretches = list[Stretch | None]()
        self._cut(CriticalValues(open=[Open(None, None, STOPPED)]))

    def found(self) -> ValueSet:
        """The set as far as it is settled, with the verdicts on single values inside of undecided
        stretches; nothing more is asked."""
        for value, point in self.asked.items():
            if point.holds is not None and self._is_left_open(value):
                i, _ = _place(self.points, point.value)
                self.points.insert(i, point)
                self.stretches.insert(i, self.stretches[i])
        self._settle_points(ask=False)
        return ValueSet(tuple(self.points), tuple(self.stretches), self.searched)

    def run(self) -> None:
        """Settle what can be settled. LimitError where the time is over."""
        own = self.question.own
        if isinstance(own, Rational) and self.domain.holds(ExactNumber(own)):
            self._ask(own)
        # From what settles whole ranges to what settles one value: each step works only on what the
        # steps before it left open. Points come last, as their neighbours often tell their verdict.
        self._use_changes()
        self._use_cells()
        self._use_ends()
        self._settle_points(ask=True)
        for value in (Integer(0), *self.question.alone):
            if isinstance(value, Rational) and self._is_left_open(value):
                self._ask(value)

    def _ask(self, value: Rational) -> SingleValue:
        """The verdict on one value, or why it is not known. LimitError where the time is over."""
        if value not in self.asked:
            tick()
            holds, reason = None, ""
            try:
                holds = self.question.verdict(value)
            except UndecidedError as error:
                reason = _reason(error)
            self.asked[value] = SingleValue(ExactNumber(value), holds, reason=reason)
        return self.asked[value]

    def _is_left_open(self, value: Rational) -> bool:
        """Whether a value lies strictly inside of a stretch of the domain that is undecided."""
        i, is_point = _place(self.points, ExactNumber(value))
        return not is_point and _is_open(self.stretches[i])

    def _ends(self, i: int) -> tuple[RealNumber | None, RealNumber | None]:
        """The two ends of the i-th stretch; None where it has none."""
        low = self.points[i - 1].value if i else None
        return low, self.points[i].value if i < len(self.points) else None

    # Critical values

    def _use_changes(self) -> None:
        """Cut the domain at critical values, as long as finer ones come and something is open."""
        try:
            for changes in self.question.changes():
                self._cut(changes)
                if self._ask_between():
                    break
        except UndecidedError as error:
            open_ = Stretch(None, _reason(error))
            self.stretches = [open_ if _is_open(x) else x for x in self.stretches]

    def _cut(self, changes: CriticalValues) -> None:
        """Cut the whole domain anew, at critical values and at the ends of ranges that are open;
        the verdicts asked so far settle the stretches that they lie in."""
        edges = [x for own in changes.open for x in (own.low, own.high) if x is not None]
        listed = [
            *(SingleValue(x.value, bindings=x.bindings) for x in changes.values),
            *map(SingleValue, edges),
        ]
        # A number that no ball encloses cannot be put in order. It may lie anywhere, so that no
        # stretch is free of critical values then.
        enclosed = [x for x in listed if is_told(x.value)]
        open_ = changes.open
        if len(enclosed) < len(listed):
            open_ = [*changes.open, Open(None, None, _UNTOLD)]
        whole = replace(self.domain, holds_low=True, holds_high=True)
        ends = (SingleValue(x) for x in self.domain.ends if x is not None)
        points = _each_once([*ends, *(x for x in enclosed if whole.holds(x.value))])
        places = [None, *(x.value for x in points), None]
        stretches = [self._known(low, high, open_) for low, high in pairwise(places)]
        self.points, self.stretches = points, [*_bounded(self.domain, stretches)]

    def _known(
        self, low: RealNumber | None, high: RealNumber | None, open_: Sequence[Open]
    ) -> Stretch:
        """What is known of the values between two neighbouring points, before any is asked."""
        around = next((x for x in open_ if x.covers(low, high)), None)
        if around is not None:
            return Stretch(None, around.reason)
        # No critical value lies in between: one verdict, asked earlier, settles all of them.
        for x in self.asked.values():
            if x.holds is not None and not _is_up_to(x.value, low) and not _is_up_to(high, x.value):
                return Stretch(x.holds)
        return _TO_ASK

    def _ask_between(self) -> bool:
        """Ask a value of each stretch that is not open, those near to the question's own value
        first; of a near set no more than it takes.

        Return whether all of what is searched is decided.
        """
        home = self._home()
        home_stretch = self._asked(home)
        is_done = home_stretch.holds is not None
        # From the own value upward, then downward: on each side a near set ends where it is enough.
        for ahead in (range(home + 1, len(self.stretches)), range(home - 1, -1, -1)):
            verdicts = [home_stretch.holds]
            for i in ahead:
                if self.near and _is_enough(verdicts):
                    self._leave_out(i, i - (ahead.step > 0))
                elif self.stretches[i] is not None:
                    verdicts.append(self._asked(i).holds)
                    is_done &= verdicts[-1] is not None or self.searched.misses(*self._ends(i))
        return is_done

    def _home(self) -> int:
        """The stretch in which the question's own value lies, or that ends there; the first one
        where the question has no own value."""
        own, i = self.question.own, 0
        if own is not None and own.is_number:
            i, _ = _place(self.points, ExactNumber(own))
        # At an end of the domain the stretch on one side is None, as nothing is asked there.
        beside = (i, i + 1, i - 1)
        return next(j for j in beside if j < len(self.stretches) and self.stretches[j] is not None)

    def _asked(self, i: int) -> Stretch:
        """A stretch with its verdict, which is asked for at one of its values where that settles
        all."""
        if self.stretches[i] is _TO_ASK:
            # A rational number, since verdicts are exact for these; the own value if it lies there.
            sample = self._ask(rational_between(*self._ends(i), self.question.own))
            self.stretches[i] = Stretch(sample.holds, sample.reason)
        stretch = self.stretches[i]
        assert stretch is not None
        return stretch

    def _leave_out(self, i: int, before: int) -> None:
        """Mark a stretch as not needed, and with it the point before it, unless that is the
        question's own value."""
        stretch = self.stretches[i]
        if stretch is not None and stretch.reason != UNSEARCHED:
            self.stretches[i] = Stretch(None, NOT_NEEDED)
        if _rational(self.points[before]) != self.question.own:
            self.points[before] = replace(self.points[before], reason=NOT_NEEDED)

    # Cells

    def _use_cells(self) -> None:
        """Fill open stretches by cells."""
        # From the last one down: a stretch that is replaced by several shifts only those above it.
        for i in reversed(range(len(self.stretches))):
            if self.question.cells is not None and _is_open(self.stretches[i]):
                self._fill(i, self.question.cells)

    def _fill(
        self, i: int, cells_of: Callable[[RealNumber | None, RealNumber | None], Iterable[Cell]]
    ) -> None:
        """Put cells in place of a stretch; where the time is over, those that are found by then."""
        cells, (low, high) = list[Cell](), self._ends(i)
        try:
            for x in cells_of(low, high):
                cells.append(x)
        except UndecidedError as error:
            # What is missing is a cell too, before ``_reason`` may raise: ``finally`` then has a
            # complete cover of the stretch to put in place.
            start = cells[-1].high if cells else low
            cells.append(Cell(start, high, None, STOPPED))
            cells[-1] = replace(cells[-1], reason=_reason(error))
        finally:
            if cells:
                self._splice(i, cells)

    def _splice(self, i: int, cells: Sequence[Cell]) -> None:
        """Put cells in place of a stretch, neighbours of one verdict merged.

        Cells are closed: the point between two has the verdict of the one that is settled.
        """
        merged = list[Cell]()
        for x in cells:
            if merged and merged[-1].holds is x.holds:
                merged[-1] = replace(
                    merged[-1], high=x.high, reason=_joined([merged[-1].reason, x.reason])
                )
            else:
                merged.append(x)
        # The points at both ends belong to the outer cells as well; rational ones are asked later.
        for j, x in ((i - 1, merged[0]), (i, merged[-1])):
            if 0 <= j < len(self.points) and _rational(self.points[j]) is None:
                self.points[j] = replace(self.points[j], holds=x.holds)
        inner = [
            SingleValue(a.high, b.holds if a.holds is None else a.holds)
            for a, b in pairwise(merged)
            if a.high is not None
        ]
        self.points[i:i] = inner
        self.stretches[i : i + 1] = [Stretch(x.holds, x.reason) for x in merged]

    def _use_ends(self) -> None:
        """Find the one end in each open stretch between values that hold and values that fail."""
        for i in reversed(range(1, len(self.stretches) - 1)):
            before, between, after = self.stretches[i - 1 : i + 2]
            low, high = self._ends(i)
            if (
                self.question.end is None
                or not _is_open(between)
                or before is None
                or after is None
            ):
                continue
            if low is None or high is None or {before.holds, after.holds} != {True, False}:
                continue
            tick()
            try:
                point = self.question.end(low, high, before.holds is True)
            except UndecidedError as error:
                self.stretches[i] = Stretch(None, _reason(error))
                continue
            if point is not None:
                self.points.insert(i, point)
                self.stretches[i : i + 1] = [Stretch(before.holds), Stretch(after.holds)]

    # Single values

    def _settle_points(self, *, ask: bool) -> None:
        """Settle the verdicts on points: from their neighbours and verdicts known, and with ``ask``
        also by asking."""
        for i, x in enumerate(self.points):
            # An end that does not belong to the domain: nothing is asked there, so nothing binds.
            if not self.domain.holds(x.value):
                self.points[i] = SingleValue(x.value, holds=False)
            elif x.holds is None and not x.reason:
                holds, reason = self._told(i, ask=ask)
                self.points[i] = replace(x, holds=holds, reason=reason)
            # At the end of the range, next to values that hold, it is the range that ends there,
            # and no condition.
            around = self.stretches[i : i + 2]
            is_range_end = None in around and Stretch(holds=True) in around
            if is_range_end and self.points[i].holds:
                self.points[i] = replace(self.points[i], bindings=())

    def _told(self, i: int, *, ask: bool) -> tuple[bool | None, str]:
        """The verdict on a point and, where that is None, the reason.

        At a rational value the question's verdict counts; elsewhere what its neighbours and its
        ``at`` and ``lone`` give.
        """
        point, near = self.points[i], [x for x in self.stretches[i : i + 2] if x is not None]
        value, verdicts = _rational(point), [x.holds for x in near]
        if value is not None:
            answer = self._ask(value) if ask else self.asked.get(value)
            return (None, STOPPED) if answer is None else (answer.holds, answer.reason)
        is_beside = True in verdicts
        # Beside values that hold, and with a known binding, ``at`` decides whatever the other side
        # is.
        if None in verdicts and not (is_beside and point.bindings):
            return None, next(x.reason for x in near if x.holds is None) or STOPPED
        tell = self.question.at if is_beside else self.question.lone
        # Without a binding nothing changes at the point: it has the verdict of its neighbours.
        if tell is None or (is_beside and not point.bindings):
            return is_beside, ""
        if not ask:
            return None, STOPPED
        try:
            verdict = tell(CriticalValue(point.value, point.bindings))
        except UndecidedError as error:
            return None, _reason(error)
        return (
            (True, "")
            if verdict is None and is_beside
            else (verdict, _ALONE if verdict is None else "")
        )


def _is_open(x: Stretch | None) -> bool:
    """Whether a stretch is undecided, belongs to the domain and is needed."""
    return x is not None and x.holds is None and x.reason != NOT_NEEDED


def _rational(x: SingleValue) -> Rational | None:
    """The value of a point as a rational number; None where it is not given as one."""
    if isinstance(x.value, ExactNumber) and isinstance(x.value.value, Rational):
        return x.value.value
    return None


def _is_enough(verdicts: Sequence[bool | None]) -> bool:
    """Whether the verdicts of the stretches from the own value on to one side are enough for a near
    set: up to where it stops holding, or, where it fails, up to where it holds next and stops
    again.
    """
    if None in verdicts:
        return True
    changes = sum(a != b for a, b in pairwise(verdicts))
    return changes >= (1 if verdicts[0] else 2)


def _reason(error: UndecidedError) -> str:
    """The reason of an undecided verdict; LimitError where the time for all of the work is over."""
    # A LimitError may come of a share of the time, which is a reason like others; if it is the
    # whole time that is over, this tick raises it again.
    if isinstance(error, LimitError):
        tick()
    return str(error)


@dataclass(frozen=True, repr=False)
class Bisected(RealNumber):
    """The one value between two at which a verdict changes, enclosed by asking the verdict.

    ``verdict`` : of a rational number, exact. ``low_holds`` : whether the lower values hold.
    ``excess`` : by how much a number fails, if it does, at the working precision. Where that, or
    its square root, is about linear, its zero shows where to ask next (the secant method).
    Guaranteed of each ball: the verdicts at its ends differ, so that the value lies in it.
    """

    verdict: Callable[[Rational], bool | None]
    low: Fraction
    high: Fraction
    low_holds: bool
    excess: Callable[[Rational], Ball] | None = None
    _known: dict[str, Any] = field(default_factory=dict, compare=False)

    @property
    def known(self) -> tuple[Fraction, Fraction]:
        """The two nearest values, so far, between which it is known to lie."""
        low, high = self._known.get("", (self.low, self.high))
        return low, high

    def between(self, bits: int) -> tuple[Fraction, Fraction]:
        """Two values between which it lies, to about that many bits of relative accuracy; farther
        apart where a verdict is undecided."""
        low, high = self.known
        sharp, is_root = 4, False
        # At the value 0 no relative accuracy would ever be reached: there this width is enough.
        least = (self.high - self.low) / 4**bits
        with flint.ctx.workprec(2 * bits + 64):
            while high - low > max(least, max(abs(low), abs(high)) / 2**bits):
                tick()
                # Around a guess two values are asked, a small part of the width to either side; if
                # both are right, the width shrinks by that part, which doubles its bits each time
                # (the convergence of the secant method). Without a guess it is bisected.
                width, near = high - low, self._guess(is_root=is_root)
                off = width / 2**sharp
                for x in [(low + high) / 2] if near is None else [near - off, near + off]:
                    asked = Fraction(*_short(x - off / 2, x + off / 2))
                    # The very value that is looked for may be undecided: then one beside the middle
                    # is asked.
                    aside = (33 * low + 31 * high) / 64
                    if low < x < high and not (self._ask(asked) or self._ask(aside)):
                        return self.known
                    low, high = self.known
                is_near = near is not None and (high - low) * 2 ** (sharp - 2) < width
                sharp, is_root = (2 * sharp, is_root) if is_near else (4, is_root is (near is None))
        return low, high

    def _ask(self, value: Fraction) -> bool:
        """Narrow the enclosure by the verdict on one value; False where that is undecided."""
        low, high = self.known
        try:
            holds = self.verdict(rational(value))
        except UndecidedError:
            holds = None
        if holds is not None:
            self._known[""] = (value, high) if holds == self.low_holds else (low, value)
        return holds is not None

    @property
    def beyond(self) -> Fraction:
        """The nearest value that is known to fail."""
        # The high end (index 1) where the lower values hold, else the low one (index 0).
        return self.known[self.low_holds]

    def _guess(self, *, is_root: bool) -> Fraction | None:
        """Where the value lies if the excess, or its root, is linear beyond it: the secant through
        the last two values that fail. None where there are no two, or it leaves the enclosure."""
        if self.excess is None:
            return None
        last = self._known.get("last")
        if last is None or last[0] != self.beyond:
            self._known["before"], last = last, (self.beyond, self.excess(rational(self.beyond)))
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


def _short(low: Fraction, high: Fraction) -> tuple[int, int]:
    """A dyadic number near the middle between two others with as few bits as possible, as numerator
    and denominator."""
    middle, width = (low + high) / 2, (high - low) / 8
    places = max(0, -(width.numerator.bit_length() - width.denominator.bit_length()) + 1)
    return round(middle * 2**places), 2**places
