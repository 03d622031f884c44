"""For which values q of a parameter does a verdict hold? Sets of values, and the one way to find
them.

A *verdict* is a function of one exact number q: yes, no, or undecided. In code these are True,
False and None, and a text gives the reason of None, where one is known. A ``ValueSet`` gives the
verdict on all values of a range. With the *points* p_1 < ... < p_n, each a single value, it has n +
1 *stretches*, each all values strictly between two neighbouring points, below p_1 or above p_n;
points and stretches both have a verdict. A *piece* is a run of neighbouring points and stretches
with one verdict.

Values are ``RealNumber`` objects, which balls enclose to any precision. ``ordered(x, y)`` compares
two: 1 where y is the larger, -1 where x is, and 0 where hundreds of bits do not distinguish them;
these count as one value.

**Guaranteed** of a ValueSet at any moment, also of one that a limit cut short: every value that was
searched lies in a point or a stretch; the verdict of each is proven for all values in it, or it is
undecided. Nothing is claimed of values that were not searched. A point that is known by an
enclosure alone (a ``Sliver``) stands for its neighbours' change of verdict somewhere in there: of a
single value inside of it nothing is claimed. Union and intersection keep that: what one set leaves
open is open unless another one settles it.

**How it is found** (``solve``). A ``Question`` is a verdict at one number, and what is known beyond
that:

1. *Critical values* (``changes``): the only numbers at which the verdict may change, all of them
   but in ranges that are named as open. Between two neighbours the verdict is constant, so that
   asking it for one number settles all values, however far apart the neighbours are.
2. *Cells* (``cells``): closed intervals that are settled as wholes, by bounds that hold for all
   values in them. They fill the stretches that critical values leave open.
3. *One end* (``end``): in a cell left open between values that hold and values that fail, the one
   value at which that changes, where it is proven that there is just one.
4. The present value, 0 and the ends of the range are asked by themselves.

What none of these settles is undecided, and stays so in the answer. A limit of time is an exception
that ``solve`` catches once: what is not settled by then is undecided for that reason.

Begin reading at ``ValueSet`` for the answer, at ``Question`` and ``solve`` for how it is found.
``Bisected`` is an end that is closed in on by asking.

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
    Sliver,
    bounds,
    dyadic,
    ordered,
    rational,
    rational_between,
)
from haptisym.kernel.roots import ascending, is_told

# Reasons of undecided verdicts.
STOPPED = "stopped at the limit"
"""The time was over."""
UNSEARCHED = "not searched"
"""The values are no part of what was searched."""
NOT_NEEDED = "beyond the nearest ends"
"""Only the values near to the present one were asked for (``solve``, ``near``)."""
_UNASKED_REASONS = UNSEARCHED, NOT_NEEDED  # nobody wanted to know: not reported as undecided
_UNENCLOSED = "where a verdict changes is not known closely enough"
_UNKNOWN_ALONE = "whether it holds at this one value is not known"

# ``Bisected`` asks on both sides of a guess, at 2^-4 of the width of the enclosure at first: near
# enough to shrink it, and wide enough for a rough guess.
_FIRST_SHARPNESS = 4


class Verdict(StrEnum):
    """What is known of all values of a piece: the verdict is yes for all of them, no for all of
    them, or not known."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


_VERDICTS = {True: Verdict.HOLDS, False: Verdict.FAILS, None: Verdict.UNDECIDED}


def _is_up_to(high: RealNumber | None, low: RealNumber | None) -> bool:
    """Return whether ``high <= low``: all values up to ``high`` then lie below those from ``low``
    on. False where one of the two is None, without end."""
    return high is not None and low is not None and ordered(high, low) >= 0


@dataclass(frozen=True)
class Domain:
    """An interval of values: its ends, exact numbers, None where it has no end, and whether the
    ends belong to it."""

    low: Expr | None
    high: Expr | None
    holds_low: bool = True
    holds_high: bool = True

    @property
    def ends(self) -> tuple[ExactNumber | None, ExactNumber | None]:
        """The low and the high end as numbers; None where there is none."""
        low = None if self.low is None else ExactNumber(self.low)
        high = None if self.high is None else ExactNumber(self.high)
        return low, high

    def holds(self, value: RealNumber) -> bool:
        """Whether a value belongs to the domain."""
        low, high = self.ends
        to_low = 1 if low is None else ordered(low, value)
        to_high = 1 if high is None else ordered(value, high)
        is_above = to_low > 0 or (to_low == 0 and self.holds_low)
        return is_above and (to_high > 0 or (to_high == 0 and self.holds_high))

    def misses(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether no value strictly between two others (None: without end) belongs to the
        domain."""
        first, last = self.ends
        return _is_up_to(high, first) or _is_up_to(last, low)

    @staticmethod
    def common(domains: Sequence[Domain]) -> Domain:
        """The intersection of some domains: from the highest low end to the lowest high one. Such
        an end belongs to it if it belongs to all of them."""
        lows: list[ExactNumber] = []
        highs: list[ExactNumber] = []
        for x in domains:
            low, high = x.ends
            if low is not None:
                lows.append(low)
            if high is not None:
                highs.append(high)
        common = Domain(None, None)
        if lows:
            last = ascending(lows, lambda x: x)[-1]
            is_in_all = all(x.holds(last) for x in domains)
            common = replace(common, low=last.value, holds_low=is_in_all)
        if highs:
            first = ascending(highs, lambda x: x)[0]
            is_in_all = all(x.holds(first) for x in domains)
            common = replace(common, high=first.value, holds_high=is_in_all)
        return common


@dataclass(frozen=True)
class SingleValue:
    """A point: one value by itself. ``holds`` : the verdict on it; None: undecided, for a
    ``reason``.

    ``bindings`` : the conditions that limit there, where the verdict changes, as the ``Question``
    gave them; this module only passes them on.
    """

    value: RealNumber
    holds: bool | None = None
    bindings: tuple[Any, ...] = ()
    reason: str = ""


@dataclass(frozen=True)
class Stretch:
    """All values strictly between two neighbouring points, or beyond the first or the last one.
    ``holds`` : the verdict on all of them; None: undecided, for a ``reason``."""

    holds: bool | None
    reason: str = ""


@dataclass(frozen=True, repr=False)
class Piece(Shown):
    """A run of neighbouring values with one verdict, as long as possible.

    ``first``, ``last`` : the points at its low and its high end, None where it has no end; a single
    value if both are the same.
    ``closed`` : whether these two belong to it. ``reason`` : why it is undecided, where it is.
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
        """The points at its ends, in order, each once."""
        points = (x for x in (self.first, self.last) if x is not None)
        return tuple(dict.fromkeys(points))

    @property
    def is_single(self) -> bool:
        """Whether it is one value."""
        return self.first is not None and self.first == self.last

    def is_open_beyond(self, end: RealNumber | None, side: int) -> bool:
        """Whether the piece is undecided and is all that lies beyond ``end`` on one ``side`` (1:
        above, -1: below), without an end of its own there. False where ``end`` is None."""
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
    """The values of a piece in words, to six digits: ``from 122.356 on``, ``0 to 3.5``, ``7``,
    ``any``."""
    low, high = (None if x is None else x.digits(6) for x in (piece.low, piece.high))
    if low is None or high is None:
        return "any" if low == high else f"up to {high}" if low is None else f"from {low} on"
    return low if piece.is_single else f"{low} to {high}"


@dataclass(frozen=True, repr=False)
class ValueSet(Shown):
    """For which values of a parameter a verdict holds: an ordered cover of what was searched.

    ``pieces`` : runs of values that hold, fail or are undecided, in order; ``feasible`` and
    ``undecided`` : those of one kind. ``value in values`` is true, false, or an UndecidedError with
    the reason; ``&`` and ``|`` are the values for which both of two sets hold, or one
    of them does; ``about`` is the piece in which a value lies.

    ``points`` : single values, in ascending order. ``stretches`` : one more than points, the i-th
    of the values between the points i - 1 and i; None, first or last, where the domain ends at that
    point and nothing is asked beyond it.
    ``searched`` : the domain beyond which nothing is claimed.

    Proven of each piece on its own, also where a limit cut the work short: its verdict is
    proven for all its values that were searched.

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
        """Return a set in which all values of a domain have one verdict; ends that do not belong to
        the domain fail."""
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
        """All that was asked about, in order, in as few pieces as possible.

        Undecided values beyond the domain searched are no piece: its neighbour then has no end on
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
            neighbour = pieces[-2]
            closed_low, _ = neighbour.closed
            pieces[-2:] = [replace(neighbour, last=None, closed=(closed_low, False))]
        if len(pieces) > 1 and pieces[0].is_open_beyond(low, -1):
            neighbour = pieces[1]
            _, closed_high = neighbour.closed
            pieces[:2] = [replace(neighbour, first=None, closed=(False, closed_high))]
        return tuple(pieces)

    @property
    def feasible(self) -> tuple[Piece, ...]:
        """The pieces that hold."""
        return tuple(x for x in self.pieces if x.verdict is Verdict.HOLDS)

    def is_alone(self, piece: Piece) -> bool:
        """Whether a piece is a single value, and the verdict on both its neighbours is known."""
        neighbours = (x for x in self.pieces if x is not piece and piece.first in (x.first, x.last))
        return piece.is_single and all(x.verdict is not Verdict.UNDECIDED for x in neighbours)

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
        """Return whether a value of the piece was searched; the ends of the domain searched count,
        too."""
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
        """The points, in order, at which a piece that holds ends because some condition limits it;
        not those at which only the domain ends."""
        every = (end for piece in self.feasible for end in piece.ends)
        return tuple(x for x in every if x.bindings)

    def end(self, value: RealNumber, side: int) -> SingleValue | None:
        """The end, above (side 1) or below (side -1), of the piece in which a value lies, if a
        condition is the limit there; None where there is no such end, or none that is known."""
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
        # -1, 0 or 1 where the value lies inside of an end, at it, or beyond it.
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
        known = self.at(number)
        # A piece may have been extended beyond the range searched (see ``pieces``); a point
        # outside, such as the present value, was asked by itself.
        if not self.searched.holds(number) and not isinstance(known, SingleValue):
            raise UndecidedError(f"the value {number!r}: it was not searched")
        # The verdict changes somewhere in a Sliver: on which side of that a value in it lies is not
        # known.
        place = known.value if isinstance(known, SingleValue) else None
        if isinstance(place, Sliver) and place is not number:
            raise UndecidedError(f"the value {number!r}: the verdict changes too near to it")
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
        between = (Stretch(holds=True),) * (len(gone) + 1)
        return self & ValueSet(tuple(gone), between)

    def below(self, value: RealNumber | None) -> Stretch | None:
        """Return the stretch of the values just below one, or, with None, of those above the last
        point; None where nothing is asked there."""
        return self.stretches[-1 if value is None else _position(self.points, value)[0]]

    def at(self, value: RealNumber) -> SingleValue | Stretch | None:
        """Return what is known of one value: its point, or the stretch in which it lies, None where
        nothing is asked there."""
        i, is_point = _position(self.points, value)
        return self.points[i] if is_point else self.stretches[i]


def _as_number(value: object) -> RealNumber:
    """Return a user's number, SymPy's or one whose text is a decimal, as an exact one."""
    if isinstance(value, RealNumber):
        return value
    return ExactNumber(value if isinstance(value, Expr) else Rational(str(value)))


def _position(points: Sequence[SingleValue], value: RealNumber) -> tuple[int, bool]:
    """Return how many points lie below a value, which is also the index of the stretch that ends at
    or above it, and whether the next point is that value."""
    i = bisect_left(points, 0, key=lambda x: -ordered(x.value, value))
    return i, i < len(points) and not ordered(points[i].value, value)


def _each_once(points: Iterable[SingleValue]) -> list[SingleValue]:
    """Return points in ascending order, those at one value merged: with all bindings, and with the
    exact number where one of them has it."""
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
    """Return stretches with None in place of those beyond the ends of a domain."""
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
    """Return all reasons in one text, each once, between semicolons."""
    every = (x for reason in reasons for x in reason.split("; "))
    return "; ".join(dict.fromkeys(x for x in every if x))


# Several sets together

Rule = Callable[[Sequence[bool | None]], bool | None]
"""A function that makes one verdict of those of several sets."""


# Logic of three values: one False settles "all", one True settles "any", whatever is undecided.
def _all(verdicts: Sequence[bool | None]) -> bool | None:
    return False if False in verdicts else None if None in verdicts else True


def _any(verdicts: Sequence[bool | None]) -> bool | None:
    return True if True in verdicts else None if None in verdicts else False


def combined(sets: Sequence[ValueSet], rule: Rule = _all) -> ValueSet:
    """Combine sets of values of one parameter, over the values that all of them ask about: by
    default to the values for which all hold.

    No verdict is asked. It works also where the time is over, as it only puts known points in
    order.
    """
    if len(sets) == 1:
        return sets[0]
    # Between two neighbours of all points of all sets each set has one verdict: it is enough to
    # combine the verdicts at every point, just below it, and above the last one.
    with spared():
        points, stretches = list[SingleValue](), list[Stretch | None]()
        for point in _each_once(x for one in sets for x in one.points):
            value = point.value
            combined_at = _together([x.at(value) for x in sets], rule)
            if combined_at is not None:
                point = replace(point, holds=combined_at.holds, reason=combined_at.reason)
                points.append(point)
                stretches.append(_together([x.below(value) for x in sets], rule))
        stretches.append(_together([x.below(None) for x in sets], rule))
        searched = Domain.common([x.searched for x in sets])
    return ValueSet(tuple(points), tuple(stretches), searched)


def _together(of_sets: Sequence[SingleValue | Stretch | None], rule: Rule) -> Stretch | None:
    """Return the combined verdict on values, from their points or stretches in several sets; None
    where one of the sets does not ask about them."""
    known = [x for x in of_sets if x is not None]
    if len(known) < len(of_sets):
        return None
    holds = rule([x.holds for x in known])
    if holds is not None:
        return Stretch(holds, "")
    return Stretch(holds, _joined(x.reason for x in known if x.holds is None))


# Questions


@dataclass(frozen=True)
class CriticalValue:
    """A value at which a verdict may change, and the conditions that bind there."""

    value: RealNumber
    bindings: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Open:
    """An interval between two values (None: without end) in which critical values may have been
    missed, for a ``reason``."""

    low: RealNumber | None
    high: RealNumber | None
    reason: str = ""

    def covers(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether all values between two others (None: without end) lie in the interval."""
        begins = self.low is None or _is_up_to(self.low, low)
        return begins and (self.high is None or _is_up_to(high, self.high))


@dataclass(frozen=True)
class CriticalValues:
    """All values at which a verdict may change, but for those in intervals that are ``open``."""

    values: Sequence[CriticalValue] = ()
    open: Sequence[Open] = ()


@dataclass(frozen=True)
class Cell:
    """A closed interval of values (None: without end), and the verdict that is proven for all of
    them; None where none is, for a ``reason``. A cell that fails need not do so at an end that is a
    critical value, where a condition may hold with equality."""

    low: RealNumber | None
    high: RealNumber | None
    holds: bool | None
    reason: str = ""


def _nothing_known() -> Iterable[CriticalValues]:
    """Return that critical values may be anywhere."""
    return [CriticalValues(open=[Open(None, None)])]


@dataclass(frozen=True)
class Question:
    """A verdict on values of a parameter, and what is known of it beyond single values.

    ``verdict`` : gives the verdict on a rational number, exactly; None, or an UndecidedError with
    the reason, where it is undecided.
    ``own`` : the parameter's present value. It is asked first, and what lies near to it before what
    is far.
    ``changes`` : yields critical values, each time with fewer intervals left open; the last ones
    count, and replace all that were given before.
    ``at`` : gives the verdict at an irrational critical value next to values that hold; None means
    that it holds like them, as it does without ``at``, which is right for closed conditions alone,
    that hold at limits of values that hold.
    ``lone`` : gives the verdict at an irrational critical value between values that fail; None
    means not known. Without ``lone`` such a value fails like its neighbours, which is right for
    strict conditions alone. So a question of closed conditions gives ``lone``, one of strict
    conditions ``at``, unless it has no such critical values.
    ``cells`` : covers the interval between two values (None: without end) by cells, in order.
    ``end`` : called as end(low, high, low_holds) where the values next to one of the two hold, the
    lower ones if ``low_holds``, and those next to the other fail. It gives the one value between at
    which that changes; None where it is not proven that there is just one.
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
    """Return the values of a domain for which the verdict is yes, and those for which it is no,
    where that is found in time; the rest is undecided.

    ``searched`` : the domain outside of which nothing is claimed; by default the whole domain.
    ``near`` : ask only for what lies near to the question's own value: if it holds, up to the first
    end on each side; if it fails, up to the end of the next values that hold. All else is
    ``NOT_NEEDED``.
    """
    work = _Solving(question, domain, searched or domain, near=near)
    # The one place where a limit of time ends a search: what is settled by then is proven, and
    # reading it off must not be cut short again.
    with suppress(LimitError):
        work.run()
    with spared():
        return work.settled()


_TO_ASK = Stretch(None, STOPPED)
"""A stretch all of whose values have one verdict that was not asked for yet. If the time ends first
it is what it says, undecided for that reason. It is compared by identity, as other stretches may
equal it."""


class _Solving:
    """A set that is being found: points and stretches, laid out as in ``ValueSet``, of which more
    and more are settled.

    At any moment what is known of each is proven, so that work that is broken off leaves a set as
    well. ``asked`` : the verdicts on single rational numbers so far.
    """

    def __init__(self, question: Question, domain: Domain, searched: Domain, *, near: bool) -> None:
        self.question, self.domain, self.searched, self.near = question, domain, searched, near
        self.asked: dict[Rational, SingleValue] = {}
        self.points = list[SingleValue]()
        self.stretches = list[Stretch | None]()
        self._cut(CriticalValues(open=[Open(None, None, STOPPED)]))

    def settled(self) -> ValueSet:
        """Return the set as it is settled by now, with the verdicts on single values inside of
        undecided stretches; nothing more is asked."""
        for value, point in self.asked.items():
            if point.holds is not None and self._is_left_open(value):
                i, _ = _position(self.points, point.value)
                self.points.insert(i, point)
                self.stretches.insert(i, self.stretches[i])
        self._settle_points(ask=False)
        return ValueSet(tuple(self.points), tuple(self.stretches), self.searched)

    def run(self) -> None:
        """Settle what can be settled. LimitError where the time is over."""
        present = self.question.own
        if isinstance(present, Rational) and self.domain.holds(ExactNumber(present)):
            self._ask(present)
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
        """Return one value with its verdict, or why that is not known. LimitError where the time is
        over."""
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
        """Return whether a value lies strictly inside of a stretch of the domain that is
        undecided."""
        i, is_point = _position(self.points, ExactNumber(value))
        return not is_point and _is_open(self.stretches[i])

    def _ends(self, i: int) -> tuple[RealNumber | None, RealNumber | None]:
        """Return the two ends of the i-th stretch; None where it has none."""
        low = self.points[i - 1].value if i else None
        return low, self.points[i].value if i < len(self.points) else None

    # Critical values

    def _use_changes(self) -> None:
        """Cut the domain at critical values, until all is decided or no finer ones come."""
        try:
            for changes in self.question.changes():
                self._cut(changes)
                if self._ask_between():
                    break
        except UndecidedError as error:
            open_ = Stretch(None, _reason(error))
            self.stretches = [open_ if _is_open(x) else x for x in self.stretches]

    def _cut(self, changes: CriticalValues) -> None:
        """Cut the whole domain anew, at critical values and at the ends of intervals that are open;
        the verdicts asked so far settle the stretches that they lie in."""
        critical = [SingleValue(x.value, bindings=x.bindings) for x in changes.values]
        edges = [end for x in changes.open for end in (x.low, x.high) if end is not None]
        cuts = [*critical, *map(SingleValue, edges)]
        # A number that no ball encloses cannot be put in order. It may lie anywhere, so that no
        # stretch is free of critical values then.
        enclosed = [x for x in cuts if is_told(x.value)]
        open_ = changes.open
        if len(enclosed) < len(cuts):
            open_ = [*changes.open, Open(None, None, _UNENCLOSED)]
        whole = replace(self.domain, holds_low=True, holds_high=True)
        ends = [SingleValue(x) for x in self.domain.ends if x is not None]
        inside = [x for x in enclosed if whole.holds(x.value)]
        points = _each_once([*ends, *inside])
        values = [None, *(x.value for x in points), None]
        stretches = [self._unasked(low, high, open_) for low, high in pairwise(values)]
        self.points, self.stretches = points, [*_bounded(self.domain, stretches)]

    def _unasked(
        self, low: RealNumber | None, high: RealNumber | None, open_: Sequence[Open]
    ) -> Stretch:
        """Return the stretch between two neighbouring points with what is known of it before any of
        its values is asked: open, settled by a verdict asked earlier, or ``_TO_ASK``."""
        around = next((x for x in open_ if x.covers(low, high)), None)
        if around is not None:
            return Stretch(None, around.reason)
        # No critical value lies in between: one verdict, asked earlier, settles all of them.
        for x in self.asked.values():
            is_inside = not _is_up_to(x.value, low) and not _is_up_to(high, x.value)
            if x.holds is not None and is_inside:
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
        upward = range(home + 1, len(self.stretches))
        downward = range(home - 1, -1, -1)
        for indices in (upward, downward):
            # The verdicts from the own value on to this side: a near set ends where they are
            # enough.
            verdicts = [home_stretch.holds]
            for i in indices:
                if self.near and _is_enough(verdicts):
                    # The point between this stretch and the one before it on the way.
                    self._leave_out(i, i - 1 if indices is upward else i)
                elif self.stretches[i] is not None:
                    holds = self._asked(i).holds
                    verdicts.append(holds)
                    is_done &= holds is not None or self.searched.misses(*self._ends(i))
        return is_done

    def _home(self) -> int:
        """Return the index of the stretch in which the question's own value lies, or that ends
        there; of the first one where the question has no own value."""
        present, i = self.question.own, 0
        if present is not None and present.is_number:
            i, _ = _position(self.points, ExactNumber(present))
        # At an end of the domain the stretch on one side is None, as nothing is asked there.
        nearest = (i, i + 1, i - 1)
        within = (j for j in nearest if j < len(self.stretches))
        return next(j for j in within if self.stretches[j] is not None)

    def _asked(self, i: int) -> Stretch:
        """Return the i-th stretch with its verdict, which is asked for at one of its values where
        that settles all."""
        if self.stretches[i] is _TO_ASK:
            # A rational number, since verdicts are exact for these; the own value if it lies there.
            sample = self._ask(rational_between(*self._ends(i), self.question.own))
            self.stretches[i] = Stretch(sample.holds, sample.reason)
        stretch = self.stretches[i]
        assert stretch is not None
        return stretch

    def _leave_out(self, stretch: int, point: int) -> None:
        """Mark a stretch as not needed, and with it a point, unless that is the question's own
        value."""
        left_out = self.stretches[stretch]
        if left_out is not None and left_out.reason != UNSEARCHED:
            self.stretches[stretch] = Stretch(None, NOT_NEEDED)
        if _rational(self.points[point]) != self.question.own:
            self.points[point] = replace(self.points[point], reason=NOT_NEEDED)

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
        """Put cells in place of the i-th stretch; where the time is over, those that are found by
        then."""
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
        """Put cells in place of the i-th stretch, neighbours of one verdict merged.

        Cells are closed: the point between two has the verdict of the one that is settled.
        """
        merged = list[Cell]()
        for x in cells:
            last = merged[-1] if merged else None
            if last is not None and last.holds is x.holds:
                reason = _joined([last.reason, x.reason])
                merged[-1] = replace(last, high=x.high, reason=reason)
            else:
                merged.append(x)
        # The points at both ends belong to the outer cells as well; rational ones are asked later,
        # and so are critical values next to cells that fail.
        for j, x in ((i - 1, merged[0]), (i, merged[-1])):
            if 0 <= j < len(self.points) and _rational(self.points[j]) is None:
                point = self.points[j]
                if x.holds or (x.holds is False and not point.bindings):
                    self.points[j] = replace(point, holds=x.holds)
        # Two cells that are settled share an end only if one verdict is proven for it.
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
            if self.question.end is None or not _is_open(between):
                continue
            if before is None or after is None or low is None or high is None:
                continue
            if {before.holds, after.holds} != {True, False}:
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
                holds, reason = self._verdict_at(i, ask=ask)
                self.points[i] = replace(x, holds=holds, reason=reason)
            # At the end of the range, next to values that hold, it is the range that ends there,
            # and no condition.
            around = self.stretches[i : i + 2]
            is_range_end = None in around and Stretch(holds=True) in around
            if is_range_end and self.points[i].holds:
                self.points[i] = replace(self.points[i], bindings=())

    def _verdict_at(self, i: int, *, ask: bool) -> tuple[bool | None, str]:
        """Return the verdict on the i-th point and, where that is None, the reason.

        At a rational value the question's verdict counts; elsewhere what the neighbours and the
        question's ``at`` and ``lone`` give. ``ask`` : whether these may be called.
        """
        point = self.points[i]
        neighbours = [x for x in self.stretches[i : i + 2] if x is not None]
        value = _rational(point)
        if value is not None:
            answer = self._ask(value) if ask else self.asked.get(value)
            return (None, STOPPED) if answer is None else (answer.holds, answer.reason)
        verdicts = [x.holds for x in neighbours]
        is_beside = True in verdicts  # next to values that hold
        # There, and with a known binding, ``at`` decides whatever the other side is.
        if None in verdicts and not (is_beside and point.bindings):
            return None, next(x.reason for x in neighbours if x.holds is None) or STOPPED
        rule = self.question.at if is_beside else self.question.lone
        # Without a binding nothing changes at the point: it has the verdict of its neighbours.
        if rule is None or (is_beside and not point.bindings):
            return is_beside, ""
        if not ask:
            return None, STOPPED
        try:
            verdict = rule(CriticalValue(point.value, point.bindings))
        except UndecidedError as error:
            return None, _reason(error)
        if verdict is None and is_beside:
            return True, ""
        return verdict, _UNKNOWN_ALONE if verdict is None else ""


def _is_open(x: Stretch | None) -> bool:
    """Return whether a stretch is undecided, belongs to the domain and is needed."""
    return x is not None and x.holds is None and x.reason != NOT_NEEDED


def _rational(x: SingleValue) -> Rational | None:
    """Return the value of a point as a rational number; None where it is not given as one."""
    if isinstance(x.value, ExactNumber) and isinstance(x.value.value, Rational):
        return x.value.value
    return None


def _is_enough(verdicts: Sequence[bool | None]) -> bool:
    """Return whether the verdicts of the stretches from the own value on to one side are enough for
    a near set: up to where they stop holding, or, where the first fails, up to where they hold next
    and stop again. An undecided one ends it: which end is nearest is not known beyond it.
    """
    if None in verdicts:
        return True
    changes = sum(a != b for a, b in pairwise(verdicts))
    return changes >= (1 if verdicts[0] else 2)


def _reason(error: UndecidedError) -> str:
    """Return the reason of an undecided verdict; LimitError where the time for all of the work is
    over."""
    # A LimitError may come of a share of the time, which is a reason like others; if it is the
    # whole time that is over, this tick raises it again.
    if isinstance(error, LimitError):
        tick()
    return str(error)


# An end that is closed in on


@dataclass(frozen=True, repr=False)
class Bisected(RealNumber):
    """The one value between two at which a verdict changes, enclosed by asking the verdict.

    ``verdict`` : of a rational number, exact; None, or an UndecidedError, where it is undecided.
    ``low``, ``high`` : between which the value lies. ``low_holds`` : whether the lower values hold.
    ``excess`` : by how much a number that fails does so, at the working precision; 0 at the value.
    Where that, or its square root, is about linear, its zero shows where to ask next (the secant
    method).

    Guaranteed of each ball, if the verdict changes just once between ``low`` and ``high``: the
    verdicts at its ends differ, so that the value lies in it.
    """

    verdict: Callable[[Rational], bool | None]
    low: Fraction
    high: Fraction
    low_holds: bool
    excess: Callable[[Rational], Ball] | None = None
    # What later calls begin with: the "enclosure" so far, and the "last" two values that fail, the
    # one "before" farther away, each with its excess.
    _known: dict[str, Any] = field(default_factory=dict, compare=False)

    @property
    def known(self) -> tuple[Fraction, Fraction]:
        """The enclosure so far: the two nearest values between which the value is known to lie."""
        low, high = self._known.get("enclosure", (self.low, self.high))
        return low, high

    def between(self, bits: int) -> tuple[Fraction, Fraction]:
        """Return two values between which the value lies, to about that many bits of relative
        accuracy; farther apart where a verdict is undecided."""
        low, high = self.known
        # ``sharpness`` : the bits by which a good guess narrows the enclosure.
        # ``is_root`` : whether the guess takes the square root of the excess to be linear.
        sharpness, is_root = _FIRST_SHARPNESS, False
        # At the value 0 no relative accuracy would ever be reached: there this width is enough.
        least_width = (self.high - self.low) / 4**bits
        with flint.ctx.workprec(2 * bits + 64):
            while high - low > max(least_width, max(-low, high) / 2**bits):
                tick()
                # Around a guess two values are asked, a small part of the width to either side; if
                # both are right, the width shrinks by that part, which doubles its bits each time
                # (the convergence of the secant method). Without a guess it is bisected.
                width = high - low
                offset, guess = width / 2**sharpness, self._guess(is_root=is_root)
                tried = [(low + high) / 2]
                if guess is not None:
                    tried = [guess - offset, guess + offset]
                for x in tried:
                    asked = Fraction(*_short(x - offset / 2, x + offset / 2))
                    # The very value that is looked for may be undecided: then one beside the middle
                    # is asked.
                    aside = (33 * low + 31 * high) / 64
                    # Rounding may move a value out of the enclosure, where nothing is known.
                    if low < asked < high and not (self._ask(asked) or self._ask(aside)):
                        return self.known
                    low, high = self.known
                # Up to a factor of 4 by as much as a good guess would.
                if guess is not None and (high - low) * 2 ** (sharpness - 2) < width:
                    sharpness *= 2
                else:
                    # A guess that was not good: the other form of the excess is tried next. Without
                    # a guess the form stays.
                    sharpness, is_root = _FIRST_SHARPNESS, is_root is (guess is None)
        return low, high

    def _ask(self, value: Fraction) -> bool:
        """Narrow the enclosure by the verdict on one value; return False where that is
        undecided."""
        low, high = self.known
        try:
            holds = self.verdict(rational(value))
        except UndecidedError:
            holds = None
        if holds is not None:
            self._known["enclosure"] = (value, high) if holds == self.low_holds else (low, value)
        return holds is not None

    @property
    def beyond(self) -> Fraction:
        """The nearest value that is known to fail."""
        # The high end (index 1) where the lower values hold, else the low one (index 0).
        return self.known[self.low_holds]

    def _guess(self, *, is_root: bool) -> Fraction | None:
        """Return where the value lies if the excess, or its square root (``is_root``), is linear
        beyond it: the zero of the secant through the last two values that fail. None where there
        are no two, or it leaves the enclosure."""
        if self.excess is None:
            return None
        last = self._known.get("last")
        if last is None or last[0] != self.beyond:
            self._known["before"] = last
            last = self.beyond, self.excess(rational(self.beyond))
            self._known["last"] = last
        before = self._known.get("before")
        if before is None:
            return None
        (x, f), (y, g) = last, before
        x, y = dyadic(x), dyadic(y)
        if is_root:
            f, g = f.sqrt(), g.sqrt()
        zero = (x - (y - x) * f / (g - f)).mid()
        if not zero.is_finite():
            return None
        guess = bounds(zero)[0]
        return guess if self.known[0] < guess < self.known[1] else None

    def rough(self) -> Ball:
        low, high = self.known
        return dyadic(low).union(dyadic(high))

    def ball(self, bits: int) -> Ball:
        low, high = self.between(bits)
        with flint.ctx.workprec(bits + 32):
            return dyadic(low).union(dyadic(high))


def _short(low: Fraction, high: Fraction) -> tuple[int, int]:
    """Return a dyadic number near the middle between two others, with few bits, so that verdicts on
    it are cheap, as numerator and denominator."""
    middle, tolerance = (low + high) / 2, (high - low) / 8
    # Binary places of which the last one is at most about the tolerance.
    bits = tolerance.numerator.bit_length() - tolerance.denominator.bit_length()
    places = max(0, 1 - bits)
    return round(middle * 2**places), 2**places
