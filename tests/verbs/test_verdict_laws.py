"""Sets of values told by single verdicts, and what several sets have in common, held against lines of which all is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby, pairwise
from math import inf
from random import Random
from typing import Any

import pytest
from flint import arb
from sympy import Expr, Integer, Rational, pi

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber, Negative, RealNumber, SquareRoot
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.verdicts import Question, Turn, all_open, together
from haptisym.verbs.stability.curves import Gap

REAL, IMAG = noticed(hs.Threshold())
BINDINGS = [Binding(x, None, kind) for x in (REAL, IMAG) for kind in (Kind.EDGE, Kind.TOUCH, Kind.FAR)]


class Nowhere(RealNumber):
    """A number of which nothing is known."""

    def ball(self, bits: int) -> Any:
        return arb("nan")


def _numbers() -> dict[float, Callable[[], RealNumber]]:
    """Fractions, roots and pi by their sizes, -6 to 6; each call makes another of the same size."""
    found: dict[float, Callable[[], RealNumber]] = {}
    for n in range(-12, 13):
        found[n / 2] = lambda n=n: ExactNumber(Rational(n, 2))
    for n in (2, 3, 5, 7, 11, 13, 19, 23, 29):
        found[n**0.5] = lambda n=n: SquareRoot(ExactNumber(Integer(n)))
        found[-(n**0.5)] = lambda n=n: Negative(SquareRoot(ExactNumber(Integer(n))))
    found[float(pi)] = lambda: ExactNumber(pi)
    return found


NUMBERS = _numbers()


def _size(x: RealNumber | None) -> float | None:
    return None if x is None else float(x)


def _rational(x: float) -> Rational | None:
    return Rational(x) if (2 * x).is_integer() else None


@dataclass
class Line:
    """A question by what it is at each of its places and between them; ``None`` : it stays open, for a reason or none."""

    pick: Random

    def __post_init__(self) -> None:
        pick = self.pick
        rational = [x for x in NUMBERS if _rational(x) is not None]
        low, high = sorted(pick.sample(rational, 2))
        self.low, self.high = (x if pick.random() < 0.7 else None for x in (low, high))
        self.holds = pick.random() < 0.5, pick.random() < 0.5
        self.turns = [(x, tuple(pick.sample(BINDINGS, pick.choice([0, 1, 1, 2])))) for x in pick.sample([*NUMBERS], 7)]
        self.turns += [(x, tuple(pick.sample(BINDINGS, 1))) for x, _ in pick.sample(self.turns, 2)]
        self.gone = pick.sample([*NUMBERS], pick.choice([0, 0, 1, 2]))
        a, b = sorted(pick.sample(rational, 2))
        self.beyond = pick.choice([(None, None), (None, None), (a, None), (None, b), (a, b)])
        ends = sorted(pick.sample([*NUMBERS], 2))
        cut = [x if pick.random() < 0.8 else None for x in ends]
        self.gaps = [(*cut, pick.choice(["", "they are many"]))] if pick.random() < 0.4 else []
        self.closed = pick.random() < 0.5
        self.spared = {x for x in NUMBERS if pick.random() < 0.5}
        self.absent = {x for x in NUMBERS if pick.random() < 0.2}
        self.own = pick.choice([None, Rational(pick.randint(-50, 50), 9)])
        inner = {x for x, _ in self.turns} | {*self.gone, *self.beyond, self.low, self.high}
        inner |= {x for gap in self.gaps for x in gap[:2]}
        self.places = sorted(x for x in inner - {None} if self._is_asked(x))
        self.ends = [*([None] if self.low is None else []), *self.places, *([None] if self.high is None else [])]
        self.cells = [pick.choice([True, True, False, None, "no bound"]) for _ in pairwise(self.ends)]
        self.at = {x: pick.choice([True, True, False, None, "no digits"]) for x in self.places}
        self.failing = {i for i in range(len(self.cells)) if pick.random() < 0.3}
        self.failing_at = {x for x in self.places if pick.random() < 0.3}
        self.asked: list[Expr] = []

    def _is_asked(self, x: float) -> bool:
        return (self.low is None or self.low <= x) and (self.high is None or x <= self.high)

    def _cell_of(self, x: float) -> int:
        return next(
            i
            for i, (a, b) in enumerate(pairwise(self.ends))
            if (-inf if a is None else a) < x < (inf if b is None else b)
        )

    def verdict(self, value: Expr) -> bool | None:
        self.asked.append(value)
        x = float(value)
        told = self.at[x] if x in self.at else self.cells[self._cell_of(x)]
        if isinstance(told, str):
            raise UndecidedError(told)
        if told is None and self.pick.random() < 0.5:
            raise LimitError("the time is over")
        return told

    def fails(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        a, b = _size(low), _size(high)
        if a == b and a is not None:
            return a in self.failing_at
        return [*pairwise(self.ends)].index((a, b)) in self.failing

    def question(self) -> Question:
        pick = self.pick
        turns = [Turn(NUMBERS[x](), own) for x, own in self.turns] + [Turn(Nowhere(), ())]
        pick.shuffle(turns)
        ends = [None if x is None else Rational(x) for x in (self.low, self.high, *self.beyond)]
        gaps = [Gap(*(None if x is None else NUMBERS[x]() for x in (a, b)), why) for a, b, why in self.gaps]
        return Question(
            turns, self.verdict, Domain(*ends[:2], *self.holds), closed=self.closed, beyond=(ends[2], ends[3]),
            spares=lambda turn: float(turn.value) in self.spared, exists=lambda x: float(x) not in self.absent,
            gone=[NUMBERS[x]() for x in self.gone], gaps=gaps, fails=self.fails, own=self.own,
        )  # fmt: skip

    # What is to come out

    def _cell(self, i: int) -> tuple[bool | None, str]:
        a, b = self.ends[i], self.ends[i + 1]
        below, above = -inf if a is None else a, inf if b is None else b
        first, last = self.beyond
        if (first is not None and above <= first) or (last is not None and below >= last):
            told: bool | str | None = "further out was not looked at"
        elif any((x is None or x <= below) and (y is None or above <= y) for x, y, _ in self.gaps):
            told = self.gaps[0][2] or "critical values come as near to one as one likes"
        else:
            told = self.cells[i]
        if isinstance(told, bool):
            return told, ""
        return (False, "") if i in self.failing else (None, told or "")

    def _here(self, x: float, near: list[bool | None]) -> tuple[bool | None, str]:
        if x in self.gone or (x == self.low and not self.holds[0]) or (x == self.high and not self.holds[1]):
            return False, ""
        if _rational(x) is not None:
            told = self.at[x]
            if x in self.absent:
                return False, ""
            if isinstance(told, bool):
                return told, ""
            return (False, "") if x in self.failing_at else (None, told or "")
        if True not in near:
            return (None if None in near else False), ""
        return self.closed or not self.binding(x) or x in self.spared, ""

    def binding(self, x: float) -> set[Binding]:
        return {b for y, own in self.turns if y == x for b in own}

    def line(self) -> tuple[list[tuple[float | None, bool | None]], set[str]]:
        """Places and what lies between them in turn, with what is known of each; and why that is open."""
        cells = [self._cell(i) for i in range(len(self.cells))]
        found, why = list[tuple[float | None, bool | None]](), {x for _, x in cells}
        for i, x in enumerate(self.ends):
            near = [told for told, _ in cells[max(i - 1, 0) : i + 1]]
            here, reason = (False, "") if x is None else self._here(x, near)
            found.append((x, here))
            why.add(reason)
            found += [(inf, cells[i][0])] if i < len(cells) else []
        return found, why - {""}


def _runs(line: list[tuple[float | None, bool | None]], wanted: bool | None) -> list[tuple[Any, bool, Any, bool]]:  # noqa: FBT001
    """From where to where something is told, and whether the ends are in it."""
    found = []
    open_ends = [told if x is not None else "unbounded" for x, told in line]
    for told, group in groupby(range(len(line)), key=lambda i: open_ends[i]):
        own = list(group)
        if told is wanted:
            first, last = own[0], own[-1]
            a, b = (first if first % 2 == 0 else first - 1), (last if last % 2 == 0 else last + 1)
            found.append((line[a][0], first % 2 == 0, line[b][0], last % 2 == 0))
    return found


@pytest.mark.parametrize("seed", range(32))
def test_a_set_is_told_by_one_verdict_between_each_two_values_at_which_it_may_change(seed: int) -> None:
    """On lines of fractions, roots and pi, with gaps, values without a scene, and verdicts that stay open."""
    given = Line(Random(seed))
    question = given.question()
    found = question.solve()
    line, why = given.line()
    told = [(_size(x.low.value), x.low.closed, _size(x.high.value), x.high.closed) for x in found.feasible]
    assert told == _runs(line, wanted=True)
    assert [tuple(map(_size, x)) for x in found.undecided] == [(a, b) for a, _, b, _ in _runs(line, wanted=None)]
    said = found.reason.split("; ") if found.reason else []
    assert (sorted(said), len(said)) == (sorted(why), len(why))
    for span in found.feasible:
        assert (span.low is span.high) is (
            span.low.value is not None and _size(span.low.value) == _size(span.high.value)
        )
        for end in (span.low, span.high):
            x = _size(end.value)
            here = set() if x is None or x in (given.low, given.high) else given.binding(x)
            assert (set(end.bindings), len(end.bindings)) == (here, len(here))
    assert all(given._is_asked(float(x)) for x in given.asked)
    own = given.own
    if own is not None and given._is_asked(float(own)) and float(own) not in given.places:
        cell = given._cell_of(float(own))
        others = [x for x in given.asked if float(x) not in given.at and given._cell_of(float(x)) == cell]
        assert others in ([], [own])


# --- what several sets have in common ---------------------------------------------------------------------------------


def _drawn(pick: Random) -> tuple[Solved, Callable[[Fraction | float], bool | None]]:
    """A set of spans and of what is open between 0 and 9, and what it says of a number."""
    marks = sorted(pick.sample(range(1, 18), 6))
    rows = [
        (Fraction(a, 2), pick.random() < 0.5, Fraction(b, 2), pick.random() < 0.5)
        for a, b in zip(marks[::2], marks[1::2], strict=True)
    ]
    if pick.random() < 0.3:
        rows[1] = (rows[1][0], True, rows[1][0], True)
    kinds = [pick.choice([True, True, None]) for _ in rows]
    unbounded = pick.random() < 0.3, pick.random() < 0.3

    def end(x: Fraction, closed: bool, *, off: bool) -> End:  # noqa: FBT001
        return (
            End(None)
            if off
            else End(ExactNumber(Rational(x.numerator, x.denominator)), closed, tuple(pick.sample(BINDINGS, 1)))
        )

    spans, left, truth = list[Span](), list[tuple[Any, Any]](), list[Any]()
    for i, ((a, c, b, d), kind) in enumerate(zip(rows, kinds, strict=True)):
        off = unbounded[0] and not i, unbounded[1] and i == len(rows) - 1
        low, high = end(a, c, off=off[0]), end(b, d, off=off[1])
        low, high = (low, low) if a == b else (low, high)
        spans += [Span(low, high)] if kind else []
        left += [] if kind else [(low.value, high.value)]
        truth.append((-inf if off[0] else a, c or not kind, inf if off[1] else b, d or not kind, kind))

    def told(x: Fraction | float) -> bool | None:
        return next(
            (kind for a, c, b, d, kind in truth if (a < x or (a == x and c)) and (x < b or (x == b and d))), False
        )

    return Solved(tuple(spans), tuple(left), pick.choice(["", "one", "other"])), told


@pytest.mark.parametrize("seed", range(12))
def test_what_several_sets_have_in_common_is_in_each_and_open_where_one_is_and_none_denies(seed: int) -> None:
    pick = Random(seed)
    drawn = [_drawn(pick) for _ in range(pick.choice([2, 2, 3]))]
    low, high = pick.choice([(None, None), (Integer(0), None), (None, Integer(9)), (Integer(1), Integer(8))])
    both = together(Domain(low, high), [x for x, _ in drawn])
    places = [Fraction(n, 4) for n in range(-2, 42)]
    for x in (x for x in places if (low is None or x >= low) and (high is None or x <= high)):
        answers = [told(x) for _, told in drawn]
        expected = False if False in answers else None if None in answers else True
        at = Rational(x.numerator, x.denominator)
        inside = any(
            (s.low.value is None or s.low.value.value < at or (s.low.value.value == at and s.low.closed))
            and (s.high.value is None or at < s.high.value.value or (s.high.value.value == at and s.high.closed))
            for s in both.feasible
        )
        open_ = any((a is None or a.value <= at) and (b is None or at <= b.value) for a, b in both.undecided)
        assert inside is (expected is True)
        assert expected is not None or open_
        assert not open_ or expected is None or any(at in (y.value for y in pair if y) for pair in both.undecided)
    reasons = [x.reason for x, _ in drawn if x.reason]
    assert both.reason == "; ".join(dict.fromkeys(reasons))
    known = {
        (e.value.value, b) for x, _ in drawn for s in x.feasible for e in (s.low, s.high) if e.value for b in e.bindings
    }
    for s in both.feasible:
        for e in (s.low, s.high):
            if e.value and e.value.value not in (low, high):
                assert set(e.bindings) == {b for x, b in known if x == e.value.value}
    assert together(Domain(low, high), [drawn[0][0]]) is drawn[0][0]


def test_of_a_domain_all_values_are_open_from_end_to_end() -> None:
    found = all_open(Domain(Integer(1), None), "nobody knows")
    assert (found.feasible, found.undecided, found.reason) == ((), ((ExactNumber(Integer(1)), None),), "nobody knows")
    assert all_open(Domain(None, Rational(7, 2))).undecided == ((None, ExactNumber(Rational(7, 2))),)
