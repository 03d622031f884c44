"""Exact sets of values of conditions whose largest value over the band is a known polynomial, and what binds at their ends."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby, pairwise
from math import inf, sqrt
from random import Random
from typing import Any

import pytest
from plainshapes import function_of, q, rational
from sympy import Expr, Integer, Rational, pi

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber, Negative, SquareRoot
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require import criticalvalues
from haptisym.verbs.require.breaking import approached
from haptisym.verbs.require.criticalvalues import Problem, _distinct
from haptisym.verbs.require.feasible import Binding, Kind, Solved
from haptisym.verbs.require.freeparameter import Domain

REAL, IMAG = noticed(hs.Threshold())
BAND = Integer(1), Integer(3)
Root = tuple[Any, int]
"""A square of the number, with a sign: of both signs where that is no square; and how often the root is there."""


@dataclass(frozen=True)
class Known:
    """k (q - u)^n ... / d^2 -+ c ((w - m)^2 - g): its largest value over 1 to 3 rad/s is the first term, at one frequency."""

    lead: int
    roots: tuple[tuple[float, Expr, int], ...]
    poles: tuple[tuple[float, Expr], ...]
    m: Fraction
    c: Fraction

    @classmethod
    def drawn(cls, pick: Random) -> Known:
        rows: list[tuple[list[float], Expr]] = [([x / 2], q - Rational(x, 2)) for x in range(-7, 8, 2)]
        rows += [([sqrt(n), -sqrt(n)], q**2 - n) for n in (2, 3, 5, 7)] + [([2 ** (1 / 3)], q**3 - 2)]
        chosen = pick.sample(rows, pick.choice([1, 2, 3]))
        roots = [(x, f, n) for own, f in chosen for n in [pick.choice([1, 1, 2])] for x in own]
        left = [x for x in rows if x not in chosen]
        poles = [(x, f) for own, f in pick.sample(left, pick.choice([0, 0, 1])) for x in own]
        m, c = Fraction(pick.choice([-1, 1, 3, 4, 5, 8]), 2), Fraction(pick.choice([1, -1, 2]), 3)
        return cls(pick.choice([1, -1]), tuple(roots), tuple(poles), m, c)

    @property
    def place(self) -> tuple[Fraction, Kind]:
        """Where -c (w - m)^2 is largest."""
        at = (
            min(max(self.m, Fraction(1)), Fraction(3))
            if self.c > 0
            else max((Fraction(1), Fraction(3)), key=lambda x: abs(x - self.m))
        )
        return at, Kind.START if at == 1 else Kind.EDGE if at == 3 else Kind.TOUCH

    @property
    def formula(self) -> Expr:
        first: Expr = Integer(self.lead)
        for f, n in {f: n for _, f, n in self.roots}.items():
            first *= f**n
        at, _ = self.place
        below: Expr = Integer(1)
        for f in {f for _, f in self.poles}:
            below *= f**2
        return (first - rational(self.c) * ((w - rational(self.m)) ** 2 - rational((at - self.m) ** 2))) / below

    def sign(self, x: float) -> int:
        """Of the largest value; 2 at a pole."""
        if x in [p for p, _ in self.poles]:
            return 2
        found = self.lead
        for root, f, n in self.roots:
            if f.has(q**3):
                found *= (1 if x > root else -1 if x < root else 0) ** n
            else:
                found *= (0 if x == root else 1 if x > root else -1) ** n
        return found


def _told(solved: Solved) -> list[tuple[Any, ...]]:
    ends = [(None if x.value is None else float(x.value), x.closed) for y in solved.feasible for x in (y.low, y.high)]
    return [(*a, *b) for a, b in zip(ends[::2], ends[1::2], strict=True)]


def _spans(line: list[tuple[float | None, bool]]) -> list[tuple[Any, ...]]:
    """Of points and what lies between them in turn: from where to where it holds, and whether the ends do."""
    found = []
    for holds, group in groupby(range(len(line)), key=lambda i: line[i][1]):
        if holds:
            own = list(group)
            a, b = own[0] - own[0] % 2, own[-1] + own[-1] % 2
            found.append((line[a][0], own[0] % 2 == 0, line[b][0], own[-1] % 2 == 0))
    return found


class Asked:
    """Some conditions on a domain without some of its values, and what is true of it."""

    def __init__(self, pick: Random) -> None:
        self.known = {x: Known.drawn(pick) for x in (REAL, IMAG)[: pick.choice([1, 2, 2])]}
        low, high = pick.choice(
            [
                (None, None),
                (Rational(-3), None),
                (None, Rational(9, 2)),
                (Rational(-7, 2), Rational(5, 2)),
                (Rational(0), None),
            ]
        )
        self.domain = Domain(low, high, pick.random() < 0.5, pick.random() < 0.5)
        self.absent = pick.sample([-3.5, -0.5, 0.5, 2.5, -3.0], 2)
        own = {criterion: function_of(x.formula) for criterion, x in self.known.items()}
        self.problem = Problem(own, q, BAND, self.domain, lambda x: float(x) not in self.absent)
        ends = [None if x is None else float(x) for x in (low, high)]
        marks: set[Any] = {
            x for k in self.known.values() for x in [*(r for r, *_ in k.roots), *(p for p, _ in k.poles)]
        } | {*ends} - {None}
        inside: list[Any] = sorted(
            x for x in marks if (ends[0] is None or x >= ends[0]) and (ends[1] is None or x <= ends[1])
        )
        self.places: list[float | None] = [*([None] if low is None else []), *inside, *([None] if high is None else [])]

    def at(self, x: float | None) -> bool:
        if (
            x is None
            or (x == self.low and not self.domain.holds_low)
            or (x == self.high and not self.domain.holds_high)
        ):
            return False
        if (2 * x).is_integer() and x in self.absent:
            return False
        return all(k.sign(x) <= 0 for k in self.known.values())

    @property
    def low(self) -> float | None:
        return None if self.domain.low is None else float(self.domain.low)

    @property
    def high(self) -> float | None:
        return None if self.domain.high is None else float(self.domain.high)

    def between(self, a: float | None, b: float | None) -> bool:
        low, high = -20.0 if a is None else a, 20.0 if b is None else b
        return all(k.sign((low + high) / 2) <= 0 for k in self.known.values())

    def line(self) -> list[tuple[float | None, bool]]:
        found: list[tuple[float | None, bool]] = []
        for a, b in pairwise(self.places):
            found += [(a, self.at(a)), (inf, self.between(a, b))]
        return [*found, (self.places[-1], self.at(self.places[-1]))]


@pytest.mark.parametrize("seed", range(16))
def test_the_values_that_keep_all_conditions_are_known_with_what_binds_at_each_end(seed: int) -> None:
    asked = Asked(Random(seed))
    found = asked.problem.solve()
    assert found.undecided == ()
    true = _spans(asked.line())
    assert len(found.feasible) == len(true)
    for row, known in zip(_told(found), true, strict=True):
        assert (row[1], row[3]) == (known[1], known[3])
        assert [None if x is None else pytest.approx(x, rel=1e-14) for x in (known[0], known[2])] == [row[0], row[2]]
    for span in found.feasible:
        assert (span.low is span.high) is (span.low.value is not None and span.low.value == span.high.value)
        for end in (x for x in (span.low, span.high) if x.value is not None):
            at = float(end.value)  # type: ignore[arg-type]
            x = min((abs(y - at), y) for y in asked.places if y is not None)[1]
            binding = {c: k.place for c, k in asked.known.items() if x in [r for r, *_ in k.roots]}
            told = {b.criterion: b.kind for b in end.bindings}
            broken = {c for c in binding if max(asked.known[c].sign(x - 1e-6), asked.known[c].sign(x + 1e-6)) > 0}
            assert len(told) == len(end.bindings)
            assert broken <= {*told} <= {*binding}  # what touches 0 and is kept on both sides is told or not
            assert all(binding[c][1] is kind for c, kind in told.items())
            for b in end.bindings:
                assert b.omega is not None
                assert float(b.omega) == pytest.approx(float(binding[b.criterion][0]), rel=1e-12)


def test_what_binds_where_one_value_alone_will_do_is_told_once() -> None:
    """1/10 + (q^2 - 2)^2 - (w^2 - 4)^2/1000, at most 1/10: at both roots of 2, where it touches at 2 rad/s."""
    gain = hs.effects.series("1 + (q^2 - 2)^2 + 1/10 - c*(s^4 + 8*s^2 + 16)", parameters={"q": "1/10", "c": "1/1000"})
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), (0, 3), hs.Threshold("0.1", "0.1"))
    found = hs.require(scene, "q", (-9, 9))
    assert [float(x.value) for x in found.ends if x.value] == pytest.approx([-sqrt(2), sqrt(2)], rel=1e-15)
    rows = found.to_dict()["binding"]
    assert [(x["at"], x["omega"], x["kind"]) for x in rows] == [
        (pytest.approx(x), 2.0, "tangency") for x in (-sqrt(2), sqrt(2))
    ]


@pytest.mark.parametrize("seed", range(8))
def test_where_the_time_is_over_for_some_values_these_are_open_and_all_else_is_told(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pick = Random(seed)
    asked, asked_about = Asked(pick), list[tuple[Any, Any]]()
    over, said, own = {i for i in range(60) if pick.random() < 0.4}, list[float](), Problem._cell

    def tick(done: float, total: float, what: str) -> None:
        said.append(done)
        assert (total, what) == (1, "values between critical ones")
        if len(said) - 1 in over:
            raise LimitError("the time is over")

    def cell(problem: Problem, low: Any, high: Any, done: float) -> Any:
        asked_about.append((None if low is None else float(low), None if high is None else float(high)))
        return own(problem, low, high, done)

    monkeypatch.setattr(criticalvalues, "tick", tick)
    monkeypatch.setattr(Problem, "_cell", cell)
    found = asked.problem.solve()
    assert said == pytest.approx([i / (len(said) + 1) for i in range(len(said))])
    assert all(a[1] == b[0] for a, b in pairwise(asked_about))
    open_ = [tuple(None if x is None else float(x) for x in pair) for pair in found.undecided]

    def inside(x: float, pair: Any) -> bool:
        return (pair[0] is None or pair[0] < x) and (pair[1] is None or x < pair[1])

    for i, (a, b) in enumerate(asked_about):
        middle = (-20.0 if a is None else a) * 0.49 + (20.0 if b is None else b) * 0.51
        assert (i in over) is any(inside(middle, x) for x in open_)
        told = any(inside(middle, (x, y)) for x, _, y, _ in _told(found))
        assert told is (i not in over and all(k.sign(middle) <= 0 for k in asked.known.values()))
    beside = {x for i, pair in enumerate(asked_about) if i in over for x in pair}
    for end in (x for span in found.feasible for x in (span.low, span.high)):
        assert not end.bindings or float(end.value) not in beside  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("formula", "is_large"),
    [
        (w**20 - q, True), (w**18 - q, False), (w**16 + w - q, True), (w**15 + w - q, False), ((w**20 - q) / (w**2 + q**2), True),
        ((w**20 - q) / (q**2 + 1), False), ((w**20 - q) / (w**2 + 1), True), ((w**20 - q) / q**2, False), (0 * q, False),
    ],
)  # fmt: skip
def test_a_condition_is_large_from_the_order_of_a_device_of_four_on_where_a_scene_exists_for_all_values(
    formula: Expr, *, is_large: bool
) -> None:
    for others in ({}, {IMAG: function_of(w - q)}):
        problem = Problem({REAL: function_of(formula), **others}, q, BAND, Domain(None, None), lambda _: True)
        assert problem.is_large is is_large


@pytest.mark.parametrize(
    "value",
    [
        SquareRoot(ExactNumber(Integer(2))),
        Negative(SquareRoot(ExactNumber(Integer(5)))),
        ExactNumber(pi),
        ExactNumber(Rational(1, 3)),
    ],
)
def test_a_value_is_approached_from_a_sample_by_bits(value: Any) -> None:
    for sample in (Rational(-7), Rational(9, 2)):
        for bits in (8, 32, 128):
            at = approached(value, sample, bits)
            low, high = value.bounds(400)
            here = Fraction(int(at.p), int(at.q))
            start = Fraction(int(sample.p), int(sample.q))
            assert start < here <= high if start < low else low <= here < start
            share = (here - low) / (start - low)
            assert abs(share * 2**bits - 1) < Fraction(1, 1 << 30)


def test_of_bindings_at_one_frequency_one_stays_for_each_name() -> None:
    one, two, root = ExactNumber(Integer(1)), ExactNumber(Integer(2)), SquareRoot(ExactNumber(Integer(4)))
    rows = [(REAL, one), (REAL, two), (IMAG, two), (REAL, root), (IMAG, None), (IMAG, None), (REAL, one)]
    found = _distinct([Binding(c, x, Kind.TOUCH) for c, x in rows])
    assert [(b.criterion.name, b.omega) for b in found] == [
        ("real", one),
        ("real", two),
        ("imag", two),
        ("imag", None),
        ("imag", None),
    ]
