"""Slabs of values with cells of the band, of which a certificate of a requirement is made: held against exact values at points."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.require.slabs import Ends, Problem, Slab, ascending
from haptisym.verbs.require.slicing import moved

NUMBERS = st.lists(st.integers(-9, 9), min_size=1, max_size=5)
PAIRS = st.tuples(st.integers(-6, 6), st.integers(1, 6))
VALUES = st.sampled_from([None, *map(Fraction, range(4))])


def at(coefficients: list[int], x: Fraction) -> Fraction:
    return sum((c * x**i for i, c in enumerate(coefficients)), Fraction(0))


@given(NUMBERS, PAIRS, st.one_of(PAIRS, st.just((1, 0))), st.fractions(0, 9, max_denominator=9))
def test_a_moved_polynomial_is_itself_elsewhere(p: list[int], low: Any, high: Any, u: Fraction) -> None:
    """(a + b u)/(c + d u) goes from a/c to b/d as u goes from 0 on; d = 0 is without bound."""
    (a, c), (b, d) = low, high
    place = (a + b * u) / (c + d * u)
    assert at(moved(p, low, high), u) == at(p, place) * (c + d * u) ** (len(p) - 1)


@given(st.lists(st.tuples(VALUES, VALUES, st.booleans()), max_size=3))
def test_intervals_ascend_where_none_begins_before_another_ends_and_neighbours_differ(rows: list[Any]) -> None:
    known = [None not in (a[1], b[0]) for a, b in pairwise(rows)]
    before = [ok and a[1] <= b[0] for ok, (a, b) in zip(known, pairwise(rows), strict=True)]
    changes = [a[2] is not b[2] for a, b in pairwise(rows)]
    assert ascending(rows) is (all(before) and all(changes))


@given(VALUES, VALUES, st.booleans(), st.booleans())
def test_the_halves_of_a_slab_meet_inside_and_lose_no_value(a: Any, b: Any, low: Any, high: Any) -> None:
    if a is not None and b is not None and a >= b:
        return
    one, other = Ends(a, b, low, high).halves()
    assert (one.low, one.holds_low, other.high, other.holds_high) == (a, low, b, high)
    assert one.high == other.low is not None
    assert one.holds_high
    assert other.holds_low
    assert a is None or a < one.high  # type: ignore[operator]
    assert b is None or one.high < b  # type: ignore[operator]


def excess(problem: Problem, x: Fraction, q: Fraction) -> Fraction | None:
    """A product of factors at a frequency and a value; None at a pole."""
    told = problem.functions["r.real"]
    values = [at([at(row, q) for row in f.rows], x**f.step) for f in problem.factors]  # type: ignore[arg-type,misc]
    if any(values[i] == 0 and n < 0 for i, n in told["powers"]):
        return None
    return Fraction(told["number"]) * prod(values[i] ** n for i, n in told["powers"])


def drawn(pick: random.Random) -> tuple[Problem, Ends]:
    """Factors over omega >= 0 and q, mostly of one sign where they are looked at, between two values or without bound."""
    first = Fraction(pick.randint(-8, 8), 4)
    low, high = pick.choice([(first, first + Fraction(pick.randint(1, 8), 4)), (None, first), (first, None)])
    factors = []
    for _ in range(pick.randint(1, 3)):
        rows = [[pick.randint(-3, 3) for _ in range(pick.randint(1, 3))] for _ in range(pick.randint(1, 3))]
        rows[0][0] += pick.choice([-12, 0, 12, 12])
        factors.append(Factor(rows, pick.choice([1, 2])))
    powers = [[i, pick.choice([-2, -1, 1, 2])] for i in range(len(factors))]
    number = str(Fraction(pick.choice([-1, -1, 1]) * pick.randint(1, 9), 7))
    start, end = sorted(Fraction(x, 8) for x in pick.sample(range(17), 2))
    problem = Problem(
        factors, {"r.real": {"number": number, "powers": powers}}, (start, start, end, end), [(start + end) / 2]
    )
    return problem, Ends(low, high, pick.random() < 0.5, pick.random() < 0.5)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(8))
def test_what_slabs_say_holds_at_each_of_their_values_and_frequencies(seed: int) -> None:
    """Where an excess is told positive or not, it is, ends that belong to the slab included; and much is told."""
    pick, told = random.Random(seed), {"fails": 0, "holds": 0}
    for _ in range(20):
        problem, ends = drawn(pick)
        slab = Slab(problem, ends, ends.slices(problem.factors))
        width = 40 if ends.low is None or ends.high is None else ends.high - ends.low
        first = ends.high - width if ends.low is None else ends.low  # type: ignore[operator]
        held = (0 if ends.holds_low else 1), (9 if ends.holds_high else 8)
        values = [first + width * Fraction(n, 8) for n in range(*held)]
        start, *_, end = problem.band
        for n in range(9):
            x = start + (end - start) * Fraction(n, 8)
            if slab.fails("r.real", x):
                told["fails"] += 1
                assert all((excess(problem, x, q) or 0) > 0 for q in values)
        if points := slab.cells():
            told["holds"] += 1
            assert points == sorted(points)
            assert (points[0], points[-1]) == (start, end)
            for n in range(17):
                x = start + (end - start) * Fraction(n, 16)
                assert all((found := excess(problem, x, q)) is None or found <= 0 for q in values)
    assert told["fails"] > 8  # so that something was tried
    assert told["holds"] > 0
