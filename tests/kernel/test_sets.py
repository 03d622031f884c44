"""Sets of values for which a verdict holds: against lines whose verdicts are drawn, and dense samples of them."""

from __future__ import annotations

import pickle
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count, pairwise
from math import inf, pi
from random import Random
from typing import Any

import mpmath
import pytest
import sympy
from sympy import Integer, Rational

import haptisym as hs
from haptisym.kernel.budget import limited, timed_by
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber, Negative, RealNumber, SquareRoot
from haptisym.kernel.sets import (
    NOT_NEEDED,
    STOPPED,
    Bisected,
    Cell,
    CriticalValue,
    CriticalValues,
    Domain,
    Open,
    Question,
    SingleValue,
    Stretch,
    Verdict,
    combined,
    solve,
)

NUMBERS: dict[float, RealNumber] = {n / 2: ExactNumber(Rational(n, 2)) for n in range(-12, 13)}
NUMBERS |= {n**0.5: SquareRoot(ExactNumber(Integer(n))) for n in (2, 3, 5, 7, 11, 13, 19, 23, 29)}
NUMBERS |= {-(n**0.5): Negative(NUMBERS[n**0.5]) for n in (2, 3, 5, 7, 11, 13, 19, 23, 29)}
NUMBERS |= {pi: ExactNumber(sympy.pi)}
"""Fractions, roots and pi by their sizes, -6 to 6."""
FRACTIONS = [x for x in NUMBERS if (2 * x).is_integer()]
TOLD = {Verdict.HOLDS: True, Verdict.FAILS: False, Verdict.UNDECIDED: None}


def said(found: hs.ValueSet, x: float) -> bool | None:
    """What a set says of a number, by its pieces; exactly one of them has it."""
    [own] = [p for p in found.pieces if is_in(p, x)]
    return TOLD[own.verdict]


def is_in(piece: Any, x: float) -> bool:
    low = -inf if piece.low is None else float(piece.low)
    high = inf if piece.high is None else float(piece.high)
    return low < x < high or (x == low and piece.closed[0]) or (x == high and piece.closed[1])


def exact(x: float | None) -> Rational | None:
    return None if x is None else Rational(x)


@dataclass
class Line:
    """Verdicts on all numbers: one at each mark, and one between each two; None: it stays open."""

    at: dict[float, bool | None]
    between: list[bool | None]
    asked: list[float] = field(default_factory=list)

    @classmethod
    def drawn(cls, pick: Random, *, some_open: bool = True) -> Line:
        kinds = [True, True, False, None] if some_open else [True, False]
        marks = sorted(pick.sample([*NUMBERS], 8))
        at = {x: pick.choice(kinds if x in FRACTIONS else [True, False]) for x in marks}
        return cls(at, [pick.choice(kinds) for _ in range(9)])

    @property
    def marks(self) -> list[float]:
        return [*self.at]

    def of(self, x: float) -> bool | None:
        return self.at[x] if x in self.at else self.between[bisect_left(self.marks, x)]

    def verdict(self, value: Rational) -> bool | None:
        self.asked.append(float(value))
        if self.of(float(value)) is None and value < 0:
            raise UndecidedError("it is dark below 0")
        return self.of(float(value))

    def told(self, x: CriticalValue) -> bool | None:
        return self.of(float(x.value))

    def changes(self) -> CriticalValues:
        return CriticalValues([CriticalValue(NUMBERS[x], (f"at {x:.3f}",)) for x in self.marks])

    def question(self, *open_: Open, **more: Any) -> Question:
        known = {"changes": lambda: [CriticalValues(self.changes().values, open_)], "at": self.told, "lone": self.told}
        return Question(self.verdict, **(known | more))

    def probes(self, *more: float) -> list[float]:
        """The marks and others, and values between each two of them and beyond."""
        listed = sorted({*self.marks, *more})
        middles = [(a + b) / 2 for a, b in pairwise(listed)]
        return sorted([listed[0] - 1, *listed, *middles, listed[-1] + 1])


def drawn_domain(pick: Random) -> Domain:
    low, high = (x if pick.random() < 0.6 else None for x in sorted(pick.sample(FRACTIONS, 2)))
    return Domain(exact(low), exact(high), pick.random() < 0.5, pick.random() < 0.5)


def has(domain: Domain, x: float) -> bool:
    low = -inf if domain.low is None else float(domain.low)
    high = inf if domain.high is None else float(domain.high)
    return low < x < high or (x == low and domain.holds_low) or (x == high and domain.holds_high)


def ends(domain: Domain) -> list[float]:
    return [float(x) for x in (domain.low, domain.high) if x is not None]


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(20))
def test_a_set_is_told_by_one_verdict_between_each_two_values_at_which_it_may_change(seed: int) -> None:
    """On lines of fractions, roots and pi, of domains with and without ends, with a gap that a second look makes smaller."""
    pick = Random(seed)
    line, domain = Line.drawn(pick), drawn_domain(pick)
    a, b, c, d = sorted(pick.sample([*NUMBERS], 4))
    known = line.changes().values
    wide, narrow = (Open(NUMBERS[x], NUMBERS[y], "in the gap") for x, y in ((a, d), (b, c)))
    found = solve(
        line.question(changes=lambda: iter([CriticalValues(known, [wide]), CriticalValues(known, [narrow])])), domain
    )
    for x in (y for y in line.probes(a, b, c, d, *ends(domain)) if has(domain, y)):
        is_open = b < x < c and x not in {0.0, *ends(domain)} and not (x in line.marks and x in FRACTIONS)
        own = said(found, x)
        if is_open or x in (b, c):
            assert own is line.of(x) or own is None
            assert own is None or x in line.asked or x in (b, c)
        elif x in line.marks and x not in FRACTIONS:
            near = [line.of(x - 1e-6), line.of(x + 1e-6)]
            assert own is (line.of(x) if None not in near or True in near else None)
        else:
            assert own is line.of(x)
    for x in ends(domain):
        assert has(domain, x) or said(found, x) is False
    for end in found.ends:
        assert end.bindings == (f"at {float(end.value):.3f}",)
        piece = found.about(end.value)  # nothing binds where it is the range that ends
        assert float(end.value) not in ends(domain) or piece.is_single or piece.verdict is Verdict.FAILS
    assert all(x.reason for x in found.undecided if float(x.high or 0) < 0)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_what_is_told_when_the_time_is_over_is_true_and_all_else_is_open_for_that_reason(seed: int) -> None:
    pick = Random(seed)
    line, domain = Line.drawn(pick, some_open=False), drawn_domain(pick)

    def cells(low: RealNumber | None, high: RealNumber | None) -> Iterator[Cell]:
        inner = [x for x in (Fraction(-5), Fraction(-7, 3), Fraction(1, 3), Fraction(13, 3)) if within(low, x, high)]
        places = [low, *(ExactNumber(Rational(x.numerator, x.denominator)) for x in inner), high]
        for start, end in pairwise(places):
            yield Cell(start, end, None)

    def looks() -> Iterator[CriticalValues]:
        known = line.changes().values
        for reach in (2, 4, 6, 8):
            around = ExactNumber(Integer(-reach)), ExactNumber(Integer(reach))
            yield CriticalValues(known, [Open(None, around[0]), Open(around[1], None)])
        yield CriticalValues(known)

    question = line.question(own=Rational(1, 3), changes=looks, cells=cells, alone=(Integer(5),))
    whole = solve(question, domain)
    assert whole.undecided == ()
    places = [x for x in line.probes(*ends(domain)) if has(domain, x)]
    settled = 0
    for ticks in range(1, 60):
        with timed_by(count().__next__), limited(ticks) as budget:
            found = solve(question, domain)
        own = {x: said(found, x) for x in places}
        assert all(told in (None, line.of(x)) for x, told in own.items())
        assert {x.reason for x in found.undecided} <= {STOPPED}
        assert budget.reached is bool(found.undecided)
        if has(domain, 1 / 3) and ticks > 1:
            assert own.get(1 / 3, line.of(1 / 3)) is line.of(1 / 3)
            assert said(found, float(Fraction(1, 3))) is line.of(1 / 3)
        settled = max(settled, sum(x is not None for x in own.values()))
        if not budget.reached:
            assert found == whole
            break
    assert settled == len(places)


def within(low: RealNumber | None, x: Fraction, high: RealNumber | None) -> bool:
    return (low is None or float(low) < x) and (high is None or x < float(high))


@pytest.mark.parametrize("seed", range(12))
def test_near_to_a_value_no_more_is_asked_than_where_it_ends_and_what_holds_next(seed: int) -> None:
    pick = Random(seed)
    line, domain = Line.drawn(pick, some_open=False), drawn_domain(pick)
    own = pick.choice([x / 2 + 0.25 for x in range(-12, 12) if has(domain, x / 2 + 0.25)])
    question, number = line.question(own=Rational(own)), ExactNumber(Rational(own))
    whole = solve(question, domain)
    before = len(line.asked)
    near = solve(question, domain, near=True)
    assert len(line.asked) - before <= before
    home, known = whole.about(number), near.about(number)
    assert (known.low, known.high, known.closed, known.verdict) == (home.low, home.high, home.closed, home.verdict)
    for x in (y for y in line.probes(own, *ends(domain)) if has(domain, y)):
        assert said(near, x) in (None, line.of(x))
    if home.verdict is Verdict.FAILS:
        at = whole.pieces.index(home)
        for piece in whole.pieces[max(at - 1, 0) : at + 2]:
            if not piece.is_single:
                inner = [x for x in line.probes() if is_in(piece, x)]
                assert all(said(near, x) is line.of(x) for x in inner)
    assert {x.reason for x in near.pieces if x.verdict is Verdict.UNDECIDED} <= {NOT_NEEDED}
    assert near.undecided == ()


def thirds(low: RealNumber | None, high: RealNumber | None) -> Iterator[Cell]:
    """Cells of a third, -3 to 3, as they are known of q^2 < 2 by the squares of their ends."""
    for n in range(-9, 9):
        a, b = Fraction(n, 3), Fraction(n + 1, 3)
        most, least = max(a * a, b * b), 0 if a < 0 < b else min(a * a, b * b)
        holds = True if most < 2 else False if least >= 2 else None
        yield Cell(*(ExactNumber(Rational(x.numerator, x.denominator)) for x in (a, b)), holds)


def bisected(low: RealNumber, high: RealNumber, low_holds: bool) -> SingleValue:  # noqa: FBT001 - as the solver calls it
    return SingleValue(Bisected(is_below, *(x.bounds(64)[0] for x in (low, high)), low_holds), bindings=("root",))


def is_below(q: Rational) -> bool:
    return bool(q * q < 2)


def test_the_one_end_in_a_cell_is_told_to_any_digits() -> None:
    question = Question(is_below, cells=thirds, end=bisected)
    found = solve(question, Domain(Integer(-3), Integer(3)))
    with mpmath.workdps(60):
        root = mpmath.nstr(mpmath.sqrt(2), 50)
    [piece] = found.feasible
    assert (piece.low.digits(50), piece.high.digits(50)) == (f"-{root}", root)  # type: ignore[union-attr]
    assert (found.undecided, [x.bindings for x in found.ends]) == ((), [("root",)] * 2)
    copy = pickle.loads(pickle.dumps(found))
    assert (copy.pieces == found.pieces, copy.said, hash(copy) == hash(found)) == (True, "-1.41421 to 1.41421", True)
    assert copy.feasible[0].high.digits(50) == root


def test_cells_alone_leave_those_that_are_not_settled_open_and_settle_their_ends() -> None:
    found = solve(Question(is_below, cells=thirds), Domain(Integer(-3), Integer(3)))
    assert [(float(x.low or 0) * 3, float(x.high or 0) * 3) for x in found.undecided] == [(-5, -4), (4, 5)]
    assert all(x.closed == (False, False) for x in found.undecided)
    assert [x.closed for x in found.pieces if x.verdict is not Verdict.UNDECIDED] == [(True, True)] * 3


def test_a_critical_value_at_the_end_of_a_cell_is_told_by_the_cell() -> None:
    """Though the question says that critical values fail, as it knows no better: what a cell tells is proven of its ends, too."""
    root = NUMBERS[2**0.5]
    question = Question(
        lambda q: bool(q * q <= 2),
        changes=lambda: [CriticalValues([CriticalValue(root, ("root",))], [Open(None, root)])],
        at=lambda _: False,
        cells=lambda low, high: [Cell(low, high, holds=True)],
    )
    found = solve(question, Domain(Integer(0), Integer(2)))
    assert (found.said, found.feasible[0].closed) == ("0 to 1.41421", (True, True))


@pytest.mark.parametrize(("lone", "told"), [(None, False), (lambda _: None, None), (lambda _: True, True)])
def test_a_value_alone_between_values_that_fail_is_asked_for_where_it_may_hold(lone: Any, told: Any) -> None:
    """-(q^2 - 2)^2 >= 0 holds at the roots of 2 alone, where no fraction lies."""
    question = Question(
        lambda q: bool((q * q - 2) ** 2 <= 0),
        changes=lambda: [CriticalValues([CriticalValue(NUMBERS[2**0.5], ("root",))])],
        lone=lone,
    )
    found = solve(question, Domain(Integer(0), Integer(5)))
    assert said(found, 2**0.5) is told
    assert (said(found, 1), said(found, 2)) == (False, False)
    if told:
        assert found.feasible[0].is_single


@pytest.mark.parametrize(("beside", "alone"), [(None, 0), (False, 1)])
def test_a_value_alone_at_the_end_of_what_is_open_is_told_by_itself(beside: Any, alone: int) -> None:
    found = solve(
        Question(lambda q: q == 1 or beside, changes=lambda: [CriticalValues()]), Domain(Integer(1), Integer(5))
    )
    assert (said(found, 1), said(found, 3), len(found.feasible)) == (True, beside, 1)


def fails(*_: object) -> Any:
    raise UndecidedError("nobody knows")


@pytest.mark.parametrize("name", ["verdict", "changes", "cells", "end", "at", "lone"])
def test_what_is_not_known_is_open_for_its_reason(name: str) -> None:
    root = CriticalValue(NUMBERS[2**0.5], ("root",))
    known: dict[str, Any] = {"verdict": is_below, "changes": lambda: [CriticalValues([root])], "at": lambda _: False}
    if name in ("cells", "end"):
        known = {"verdict": is_below, "cells": thirds}
    if name == "lone":
        known["verdict"] = lambda _: False
    found = solve(Question(**(known | {name: fails})), Domain(Integer(-3), Integer(3)))
    assert {x.reason for x in found.undecided} == {"nobody knows"}
    assert "nobody knows" in found.reason
    places = {"cells": [], "verdict": [], "changes": [0.0, -3.0, 3.0], "at": [1, 2], "lone": [1, 2], "end": [1, 2]}
    assert all(said(found, x) is (x * x < 2 and name != "lone") for x in places[name])
    with pytest.raises(UndecidedError, match=r"1\.4142.*nobody knows"):
        NUMBERS[2**0.5] in found  # noqa: B015


def test_a_value_is_in_a_set_or_not_or_that_is_an_error_that_says_why() -> None:
    question = Question(
        is_below, changes=lambda: [CriticalValues([CriticalValue(NUMBERS[2**0.5]), CriticalValue(NUMBERS[-(2**0.5)])])]
    )
    found = solve(question, Domain(Integer(-2), Integer(2), holds_high=False), Domain(Integer(-2), Rational(3, 2)))
    inside = (1, 1.4142, Fraction(7, 5), Rational(7, 5), "1.41", sympy.sqrt(2) - Rational(1, 100), NUMBERS[0.5], -1)
    assert [x in found for x in inside] == [True] * len(inside)
    assert [x in found for x in (1.4143, "-1.5", -2, 2)] == [False] * 4
    for x, why in ((1.75, "not searched"), (3, "not among"), (-2.5, "not among")):
        with pytest.raises(UndecidedError, match=why):
            x in found  # noqa: B015
    assert found.about(NUMBERS[0.5]) == found.feasible[0]
    assert (found.end(NUMBERS[0.5], 1), found.unknown(NUMBERS[0.5], 1)) == (None, None)  # nothing binds, all is known


def some(pick: Random) -> hs.ValueSet:
    """A set of drawn points and stretches, of a drawn domain."""
    domain = drawn_domain(pick)
    whole = hs.ValueSet.all_of(domain, holds=None)
    inner = [x for x in sorted(pick.sample([*NUMBERS], 5)) if has(domain, x) and x not in ends(domain)]
    listed = {float(x.value): x.holds for x in whole.points} | {x: pick.choice([True, False, None]) for x in inner}
    points = [SingleValue(NUMBERS[x], listed[x], (f"at {x:.3f}",) if x in inner else ()) for x in sorted(listed)]
    stretches = [Stretch(pick.choice([True, False, None])) for _ in range(len(points) + 1)]
    edges = [x is None for x in (domain.low, domain.high)]
    return hs.ValueSet(
        tuple(points),
        (stretches[0] if edges[0] else None, *stretches[1:-1], stretches[-1] if edges[1] else None)
        if points
        else tuple(stretches),
        domain,
    )


def told(found: hs.ValueSet, x: float) -> bool | None:
    """What points and stretches say of a number. LookupError beyond them."""
    values = [float(p.value) for p in found.points]
    own = found.points[values.index(x)] if x in values else found.stretches[bisect_left(values, x)]
    if own is None:
        raise LookupError
    return own.holds


def all_of(told: Iterable[bool | None]) -> bool | None:
    listed = [*told]
    return False if False in listed else None if None in listed else True


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(20))
def test_what_several_sets_have_in_common_is_in_each_and_what_one_of_them_has_is_in_one(seed: int) -> None:
    pick = Random(seed)
    sets = [some(pick) for _ in range(pick.choice([2, 2, 3]))]
    both, either = combined(sets), combined(sets, lambda own: _not(all_of(_not(x) for x in own)))
    for x in sorted({*NUMBERS, *(n / 8 for n in range(-60, 60))}):
        try:
            known = [told(own, x) for own in sets]
        except LookupError:
            assert not any(is_in(p, x) for p in both.pieces)
            continue
        assert said(both, x) is all_of(known)
        assert said(either, x) is _not(all_of(_not(y) for y in known))
    if len(sets) == 2:
        assert (sets[0] & sets[1], sets[0] | sets[1]) == (both, either)
    known_ends = {b for own in sets for p in own.points for b in p.bindings}
    assert all(b in known_ends for p in both.ends for b in p.bindings)
    assert both == combined([both, both])
    values = pick.sample([*NUMBERS], 3)
    less = both.without([NUMBERS[x] for x in values])
    for x in NUMBERS:
        if any(is_in(p, x) for p in both.pieces):
            assert said(less, x) is (False if x in values else said(both, x))


def _not(x: Any) -> bool | None:
    return None if x is None else not x


def test_what_is_claimed_of_several_sets_is_what_was_searched_of_all() -> None:
    wide, narrow = (hs.ValueSet.all_of(Domain(Integer(0), None), holds=True) for _ in range(2))
    wide, narrow = (
        hs.ValueSet(own.points, own.stretches, Domain(Integer(0), Integer(high)))
        for own, high in ((wide, 10), (narrow, 5))
    )
    for found in (wide & narrow, wide | narrow, narrow & wide, wide.without([NUMBERS[1.0]]) & narrow):
        assert 4 in found
        with pytest.raises(UndecidedError, match="not searched"):
            6 in found  # noqa: B015


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(4))
def test_a_value_that_is_closed_in_on_is_where_the_verdict_changes(seed: int) -> None:
    """Cube roots of fractions of both signs, and 0, to 50 digits, by numbers whose verdict is a comparison."""
    pick = Random(seed)
    cube = Fraction(pick.randint(-99, 99), pick.randint(1, 99)) if seed else Fraction(0)
    rising = pick.random() < 0.5
    found = Bisected(
        lambda q: bool(q**3 > Rational(cube.numerator, cube.denominator)) is rising, Fraction(-101), Fraction(307, 3),
        low_holds=not rising,
    )  # fmt: skip
    low, high = found.between(170)
    assert low**3 <= cube <= high**3
    assert high - low <= Fraction(1, 2**160)
    if cube:
        with mpmath.workdps(60):
            root = mpmath.cbrt(abs(mpmath.mpf(cube.numerator) / cube.denominator)) * (1 if cube > 0 else -1)
            assert found.digits(50) == mpmath.nstr(root, 50, strip_zeros=False)


def test_what_stays_open_where_a_verdict_changes_is_no_more_than_what_was_open() -> None:
    found = Bisected(
        lambda q: None if abs(q - 1) < Rational(1, 1000) else bool(q < 1), Fraction(0), Fraction(3), low_holds=True
    )
    low, high = found.between(60)
    assert 0 < 1 - low < Fraction(1, 100) > high - 1 > 0
    with pytest.raises(UndecidedError):
        found.digits(5)
