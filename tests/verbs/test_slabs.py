"""Slabs of values with cells of the band, of which a certificate of a requirement is made: held against exact values at points."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

import mpmath
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from haptisym.verbs.evaluate.products import Factor
from haptisym.verbs.evaluate.waves import WaveFactor
from haptisym.verbs.require.slabs import Ends, Problem, Slab, ascending
from haptisym.verbs.require.slicing import cost, moved, sliced, width

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


@pytest.mark.parametrize("scale", [Fraction(1), Fraction(1, 10**9), Fraction(10) ** 12])
@given(VALUES, VALUES, st.booleans(), st.booleans())
@example(a=Fraction(1), b=Fraction(10), low=True, high=True)
@example(a=Fraction(1, 999), b=Fraction(1, 99), low=True, high=True)
def test_the_halves_of_a_slab_meet_inside_and_lose_no_value(scale: Any, a: Any, b: Any, low: Any, high: Any) -> None:
    if a is not None and b is not None and a >= b:
        return
    a, b = (None if x is None else x * scale for x in (a, b))
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


@pytest.mark.few(1)
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


def wave_value(factor: WaveFactor, x: Any, q: Any) -> Any:
    """The sum of terms at a frequency and a value, in 50 digits."""
    with mpmath.workdps(50):
        x, total = mpmath.mpf(x.numerator) / x.denominator, mpmath.mpf(0)
        for turns, rows in factor.terms:
            value = mpmath.fsum(n * x**i * q**k for i, row in enumerate(rows) for k, n in enumerate(row))
            for k, most, tau in zip(turns, factor.waves, factor.delays, strict=False):
                half = x * tau.numerator / tau.denominator / 2
                value *= mpmath.sin(half) ** k * mpmath.cos(half) ** (most - k)
            for alpha, (a, b) in zip(factor.orders, [turns[len(factor.waves) :]], strict=False):
                power = mpmath.mpc(0, x) ** (mpmath.mpf(alpha.numerator) / alpha.denominator)
                value *= power.real**a * power.imag**b
            total += value
    return total


@pytest.mark.parametrize("seed", range(4))
def test_the_side_of_a_factor_with_waves_is_that_of_all_its_values_in_a_slab_and_a_cell(seed: int) -> None:
    """A side that is told holds at each value and frequency; that of what is far from 0 is told, but at an end where it vanishes."""
    pick, told = random.Random(seed), 0
    for _ in range(8):
        low = Fraction(pick.randint(-4, 4), 2)
        high = low + Fraction(pick.randint(1, 6), 4)
        orders = pick.choice([(), (), (Fraction(1, 3),)])
        turns = [(k, *((a, 1 - a) if orders else ())) for k in (0, 1) for a in ((0, 1) if orders else (0,))]
        rows = {t: [[pick.randint(-2, 2) for _ in range(2)] for _ in range(2)] for t in turns}
        lead = pick.choice([-1, 1])
        rows[turns[0]][0][0] += lead * 40
        factor = WaveFactor(tuple((t, tuple(map(tuple, r))) for t, r in rows.items()), (1,), (Fraction(1, 4),), orders)
        own = sliced(factor, low.as_integer_ratio(), high.as_integer_ratio())
        a = Fraction(pick.randint(1, 8), 8)
        b = a + pick.choice([Fraction(0), Fraction(1, 4)])
        found = own.side(a, b, (True, True))
        assert found == own.side(a, b, None) == own.side(a, b, (False, True))
        for n in range(5):
            for k in range(5):
                value = wave_value(factor, a + (b - a) * n / 4, low + (high - low) * Fraction(k, 4))
                assert found is None or value * found > 0
        told += found is not None
    assert told > 4
    # (q - 1) times a cosine: nothing is lost at the end where it vanishes, if that does not belong to the slab
    vanishing = WaveFactor((((0,), ((-1, 1),)),), (1,), (Fraction(1, 4),))
    slab = sliced(vanishing, (1, 1), (2, 1))
    cell = Fraction(1, 2), Fraction(1)
    assert [slab.side(*cell, x) for x in (None, (False, True), (True, False), (True, True))] == [1, 1, None, None]
    below = sliced(vanishing, (0, 1), (1, 1))
    assert [below.side(*cell, x) for x in (None, (False, True), (True, False), (True, True))] == [-1, None, -1, None]
    for x in (
        sliced(vanishing, (0, 1), (2, 1)),
        sliced(WaveFactor((((0,), ((0, 0),)),), (1,), (Fraction(1, 4),)), (0, 1), (1, 1)),
    ):
        assert x.side(*cell, None) is None


@pytest.mark.parametrize("seed", range(6))
def test_the_side_of_a_polynomial_is_that_of_all_its_values_in_a_slab_and_a_cell(seed: int) -> None:
    pick = random.Random(seed)
    for _ in range(20):
        step = pick.choice([1, 2])
        rows = [[pick.randint(-2, 3) for _ in range(pick.randint(1, 3))] for _ in range(pick.randint(1, 3))]
        rows[0][0] += pick.choice([-9, 9, 0])
        low = Fraction(pick.randint(-4, 4), 2)
        high = low + Fraction(pick.randint(1, 6), 4)
        a = Fraction(pick.randint(0, 8), 8)
        b = a + pick.choice([Fraction(0), Fraction(1, 4), Fraction(1)])
        own = sliced(Factor(tuple(map(tuple, rows)), step), low.as_integer_ratio(), high.as_integer_ratio())
        values = {
            (q, x): sum(at(row, q) * x ** (step * i) for i, row in enumerate(rows))
            for q in (low, (low + high) / 2, high)
            for x in (a, (a + b) / 2, b)
        }
        for held in (None, (True, True), (True, False)):
            side = own.side(a, b, held)
            assert side is None or all(x * side >= 0 for x in values.values())
            assert side is None or any(x * side > 0 for x in values.values())
            if side and held:  # a value at an end that belongs is 0 at no frequency of all, but may be at some
                ends = [low] * held[0] + [high] * held[1]
                assert all(any(values[q, x] for x in (a, (a + b) / 2, b)) for q in ends)


def test_the_cost_of_signs_of_slices_is_what_the_format_says() -> None:
    """2 (count width)^2 + 2000 for each bit of a point; with waves 2 count width^2, and for each point that of a sign times width."""
    plain = Factor(((1, 2, 3), (4,)), 1)
    assert (width(plain), cost(plain)) == (3, (2 * 6**2 + 2000, 0))
    late = WaveFactor((((0,), ((1, 2), (3,))), ((1,), ((1, 1, 1),))), (1,), (Fraction(1, 4),))
    assert (width(late), cost(late)) == (3, (2 * 3 * 9, late.cost * 3))
