"""Sets of values of one parameter: what is asked about, what was found, and a verdict for each value between others.

An end says what binds there: which condition, and where on the band. A verdict that can change at known values alone is asked for
once between each two of them, and at each that is a rational number; where it stays open, or where the values at which it changes
are not known, values are undecided, with a reason. What several sets have in common is such a question too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

from sympy import Expr, Rational

from haptisym.judge.bindings import Binding
from haptisym.kernel.budget import spared, tick
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import ExactNumber, RealNumber, rational_between
from haptisym.kernel.roots import ascending, is_told, ordered
from haptisym.kernel.sets import Domain, Point, Stretch, ValueSet

if TYPE_CHECKING:  # only what is asked of a hand has gaps
    from haptisym.kernel.sets import Open as Gap


@dataclass(frozen=True)
class End:
    """An end of an interval of values; ``bindings``: what binds there, empty where the range that was asked about ends."""

    value: RealNumber | None
    closed: bool = False
    bindings: tuple[Binding, ...] = ()


@dataclass(frozen=True, repr=False)
class Span(Shown):
    """An interval of values of the parameter: a single value if both ends are the same."""

    low: End
    high: End

    def _line(self) -> str:
        return spanned(self)


@dataclass(frozen=True)
class Solved:
    """The values for which conditions hold, and those about which nothing was proven, in time or for a ``reason``."""

    feasible: tuple[Span, ...]
    undecided: tuple[tuple[RealNumber | None, RealNumber | None], ...] = ()
    reason: str = ""


def bound_ends(spans: Iterable[Span]) -> tuple[End, ...]:
    """The ends at which a condition binds, in order."""
    listed = (end for span in spans for end in dict.fromkeys((span.low, span.high)))
    return tuple(end for end in listed if end.bindings)


def spanned(span: Span) -> str:
    """``from 122.356 on``, ``0 to 3.5``, ``7``, ``any``."""
    low, high = (None if x.value is None else x.value.digits(6) for x in (span.low, span.high))
    if low is None or high is None:
        return "any" if low == high else f"up to {high}" if low is None else f"from {low} on"
    return low if span.low.value == span.high.value else f"{low} to {high}"


def runs(at: Sequence[bool], between: Sequence[bool]) -> list[tuple[int, int, bool, bool]]:
    """The longest runs of a set along a line of points, given whether it holds each point and each gap between two.

    Each run: the numbers of its first and last point, and whether these belong to it.

    >>> runs([False, True, False, True], [True, True, False])
    [(0, 2, False, False), (3, 3, True, True)]
    """
    line = [x for pair in zip(at, [*between, False], strict=True) for x in pair][:-1]
    found = []
    for inside, group in groupby(range(len(line)), key=lambda i: line[i]):
        places = list(group)
        if inside:
            first, last = places[0], places[-1]
            found.append((first // 2, (last + 1) // 2, first % 2 == 0, last % 2 == 0))
    return found


_BEYOND = "values further out are not tested"


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
        for i, x in enumerate(at):
            near = cells[max(i - 1, 0) : i + 1]
            if x and True not in near and None in near:  # alone it is the end of what is open
                at[i] = None

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
        if (gap := next((x for x in self.gaps if x.covers(low, high)), None)) is not None:
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


def within(found: Solved, searched: tuple[Expr, Expr], domain: Domain) -> Solved:
    """The same but for what is open of values beyond those that are searched, where a domain has no end."""
    low, high = map(ExactNumber, searched)
    left = tuple(
        (a, b)
        for a, b in found.undecided
        if not (domain.low is None and b is not None and ordered(b, low) >= 0)
        and not (domain.high is None and a is not None and ordered(high, a) >= 0)
    )
    return replace(found, undecided=left, reason=found.reason if left else "")


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


def as_set(found: Solved, asked: Domain) -> ValueSet:
    """The same as a set of values."""
    if isinstance(found, ValueSet):
        return found
    with spared():
        return _as_set(found, asked)


def _as_set(found: Solved, asked: Domain) -> ValueSet:
    ends = [Point(y.value, None, y.bindings) for x in found.feasible for y in (x.low, x.high) if y.value is not None]
    open_ = [Point(y) for x in found.undecided for y in x if y is not None]
    edges = [Point(x) for x in asked.ends if x is not None]
    places = list[Point]()
    for x in ascending([*ends, *open_, *edges], lambda x: x.value):
        if places and not ordered(places[-1].value, x.value):
            if x.bindings and not places[-1].bindings:
                places[-1] = x
        else:
            places.append(x)
    points = list[Point]()
    for x in places:
        verdict = asked.holds(x.value) and _answer(found, x.value)
        points.append(Point(x.value, verdict, x.bindings, found.reason if verdict is None else ""))
    low, high = asked.ends
    edges_ = [None, *[x.value for x in places], None]
    cells = list[Stretch | None]()
    for a, b in pairwise(edges_):
        if (a is None and low is not None) or (b is None and high is not None):
            cells.append(None)
        else:
            holds = _answer(found, ExactNumber(rational_between(a, b)))
            cells.append(Stretch(holds, found.reason if holds is None else ""))
    return ValueSet(tuple(points), tuple(cells), asked)


def without(spans: Sequence[Span], gone: Sequence[RealNumber]) -> tuple[Span, ...]:
    """Intervals of values without some."""
    found = tuple(spans)
    for x in gone:
        found = tuple(y for span in found for y in _cut(span, x))
    return found


def _cut(span: Span, x: RealNumber) -> Iterator[Span]:
    low, high = span.low, span.high
    after = 1 if low.value is None else ordered(low.value, x)
    before = 1 if high.value is None else ordered(x, high.value)
    if after > 0 and before > 0:
        yield from (Span(low, End(x)), Span(End(x), high))
    elif after < 0 or before < 0:
        yield span
    elif after or before:  # x is one of two ends
        yield Span(replace(low, closed=low.closed and after > 0), replace(high, closed=high.closed and before > 0))
