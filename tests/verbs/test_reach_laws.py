"""How far out roots may meet the axis, and one root on the right for all values: against samples of the terms themselves."""

from __future__ import annotations

import cmath
import random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.symbols import s
from haptisym.verbs.stability.reach import _least_on_circle, lag_of, reach_of
from haptisym.verbs.stability.rightroot import RightRoots

SEEDS = range(30)


def loop(table: dict[int, dict[tuple[int, ...], list[int]]], lags: tuple[Any, ...]) -> Any:
    own = {
        Rational(p): {turns: [Integer(c) for c in row] for turns, row in group.items()} for p, group in table.items()
    }
    return SimpleNamespace(table=own, leading=own[max(own)], ring=SimpleNamespace(lags=lags), turns=())


def sizes(table: dict[int, dict[tuple[int, ...], list[int]]], q: float, w: float) -> dict[tuple[int, ...], complex]:
    """What stands before each product of delays at j w."""
    found: dict[tuple[int, ...], complex] = {}
    for p, group in table.items():
        for turns, row in group.items():
            found[turns] = found.get(turns, 0) + sum(c * q**i for i, c in enumerate(row)) * (1j * w) ** p
    return found


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_beyond_its_reach_one_delayed_product_is_outweighed_for_all_values(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(4):
        degree = draw.randint(1, 3)
        table: dict[int, dict[tuple[int, ...], list[int]]] = {}
        for p in range(degree + 1):
            table[p] = {(0,): [draw.randint(-9, 9), draw.randint(-3, 3)]}
            if p < degree:
                table[p][2,] = [draw.randint(-9, 9), draw.randint(-3, 3)]
        table[degree] = {(0,): [draw.choice([-7, 5]), draw.choice([0, 1])], (2,): [draw.randint(-2, 2), 0]}
        own = loop(table, (Rational(1, 4),))
        assert lag_of((2,), own) == Rational(1, 2)
        low, high = 1.0, 1.0 + draw.choice([0.01, 0.5])
        found = reach_of(own).radius(arb(low).union(arb(high)), 10_000, inverse=False)
        assert found is not None
        for q in (low, (low + high) / 2, high):
            for w in float(found) * np.array([1, 1.01, 1.3, 2, 5, 30]):
                each = sizes(table, q, w)
                assert abs(each[0,]) > abs(each[2,])
        far = reach_of(own).radius(arb(0).union(arb(0.01)), 10_000, inverse=True)
        if far is not None:
            for u in (0.01, 0.003, 1e-6):
                for w in float(far) * np.array([1, 1.01, 2, 30]):
                    each = sizes(table, 1 / u, w)
                    assert abs(each[0,]) > abs(each[2,])


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", SEEDS)
def test_beyond_its_reach_the_highest_power_outweighs_all_others_whatever_the_phases(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        degree = draw.randint(1, 3)
        table: dict[int, dict[tuple[int, ...], list[int]]] = {
            p: {(0, 0): [draw.randint(-9, 9), 1], (1, 0): [draw.randint(-9, 9), 0], (0, 1): [0, draw.randint(-3, 3)]}
            for p in range(degree)
        }
        table[degree] = {(0, 0): [draw.choice([-7, 6]), 0], (1, 0): [2, 0], (0, 1): [draw.choice([-1, 2]), 0]}
        found = reach_of(loop(table, (Rational(1, 3), Rational(1, 2)))).radius(
            arb(1).union(arb(1.2)), 100_000, inverse=False
        )
        assert found is not None
        for q in (1.0, 1.2):
            for w in float(found) * np.array([1, 1.5, 20]):
                for _ in range(30):
                    z = [cmath.exp(2j * cmath.pi * draw.random()) for _ in range(2)]
                    each = {
                        p: {turns: sum(c * q**i for i, c in enumerate(row)) for turns, row in group.items()}
                        for p, group in table.items()
                    }
                    lead = abs(sum(c * z[0] ** a * z[1] ** b for (a, b), c in each[degree].items())) * w**degree
                    assert lead > sum(abs(c) * w**p for p, group in each.items() if p < degree for c in group.values())


@pytest.mark.parametrize("seed", range(6))
def test_of_two_delays_the_least_of_the_highest_power_is_what_is_left_where_all_that_is_late_opposes(seed: int) -> None:
    """Of c_0 + c_1 z_1 + c_2 z_2 + ..., |z_i| = 1, all c anywhere in balls: |c_0| - |c_1| - |c_2|; nothing is told where that is not positive."""
    draw = random.Random(seed)
    own = reach_of(loop({1: {(0, 0): [1], (1, 0): [1], (0, 1): [1]}, 0: {(0, 0): [1]}}, (Integer(1), Rational(1, 3))))
    for _ in range(40):
        turns = [(0, 0), *draw.sample([(1, 0), (0, 1), (1, 1), (2, 0), (0, 3)], draw.randint(0, 3))]
        middles = [draw.randint(-40, 40) * (5 if not any(x) else 1) for x in turns]
        radii = [draw.choice([0, 1, 3]) for _ in turns]
        least, *late = (abs(x) + (r if any(n) else -r) for x, r, n in zip(middles, radii, turns, strict=True))
        found = own._floor({n: arb(x, r) for n, x, r in zip(turns, middles, radii, strict=True)})
        true = max(least, 0) - sum(late)
        assert (found is not None) is (true > 0)
        assert found is None or true - 1e-6 <= float(found) <= true  # radii have 30 bits


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_least_on_the_circle_is_below_all_samples_and_hardly_less(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(5):
        c = {n: draw.randint(-9, 9) for n in range(draw.randint(1, 4))}
        true = min(abs(sum(x * cmath.exp(2j * cmath.pi * k * n / 4000) for n, x in c.items())) for k in range(4000))
        found = _least_on_circle({n: arb(x) for n, x in c.items()})
        slack = sum(n * abs(x) for n, x in c.items()) * np.pi / 32
        assert found is None or 0 < float(found) <= true
        assert found is not None or true <= 2 * slack
        assert found is None or float(found) >= true - 2 * slack


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(8))
def test_a_root_on_the_right_is_proven_for_intervals_of_unstable_values_and_for_no_other(seed: int) -> None:
    draw = random.Random(seed)
    table: dict[int, dict[tuple[int, ...], list[int]]] = {
        2: {(0,): [1]}, 1: {(0,): [draw.randint(-1, 2), draw.choice([0, 1])]}, 0: {(0,): [draw.randint(1, 9)], (1,): [draw.randint(-6, 6), draw.randint(-2, 2)]},
    }  # fmt: skip
    own = loop(table, (Rational(1, 2),))
    low, high = draw.choice([(1, 2), (2, 3), (Rational(1), Rational(11, 10))])

    def characteristic(q: Expr) -> Expr:
        return sum(
            (
                sum(c * q**i for i, c in enumerate(row)) * s**p * exp(-s * turns[0] / 2)
                for p, group in table.items()
                for turns, row in group.items()
            ),
            Integer(0),
        )

    def right(q: Expr) -> int:
        x = characteristic(q)
        ring = Ring.of([x, exp(-s / 2)])
        return count_roots(ring.convert(x).numerator, ring).right or 0

    inside = [right(Rational(low) + (Rational(high) - low) * n / 4) for n in range(5)]
    found = RightRoots(own).everywhere(ExactNumber(Rational(low)), ExactNumber(Rational(high)), 2)
    assert not found or min(inside) > 0
    assert not RightRoots(own).everywhere(None, ExactNumber(Rational(high)))  # 0 is among them
    for side in (1, -1):
        end = ExactNumber(side * Rational(low))
        ends = (end, None) if side > 0 else (None, end)
        if RightRoots(own).everywhere(*ends):
            assert all(right(end.value * n) > 0 for n in (1, Rational(3, 2), 3, 20, 1000, 10**6))


def test_the_root_of_a_limit_is_on_the_right_for_all_values_without_end() -> None:
    """s^2 + 1 + q (s - 2): as q grows a root goes to 2; of q < 0 as well, and the other one goes to infinity."""
    own = loop({2: {(0,): [1]}, 1: {(0,): [0, 1]}, 0: {(0,): [1, -2]}}, (Rational(1, 2),))
    assert RightRoots(own).everywhere(ExactNumber(Integer(10)), None)
    assert RightRoots(own).everywhere(None, ExactNumber(Integer(-10)))
    other = loop({2: {(0,): [1]}, 1: {(0,): [0, 1]}, 0: {(0,): [1, 2]}}, (Rational(1, 2),))
    assert not RightRoots(other).everywhere(ExactNumber(Integer(10)), None)


def test_of_values_on_both_sides_of_0_each_has_its_root_on_the_right() -> None:
    """s^2 + (q - 2) s + 5: two roots on the right as long as q < 2, which no step over all values at once shows."""
    own = loop({2: {(0,): [1]}, 1: {(0,): [-2, 1]}, 0: {(0,): [5]}}, (Rational(1, 2),))
    for low, high, told in ((-1, 1, True), (-2, 1, True), (0, 1, True), (-1, 0, True), (-1, 3, False), (0, 3, False), (1, 3, False)):  # fmt: skip
        assert RightRoots(own).everywhere(ExactNumber(Integer(low)), ExactNumber(Integer(high))) == told, (low, high)
    assert not RightRoots(own).everywhere(ExactNumber(Integer(-4)), ExactNumber(Integer(1)), 0)


@pytest.mark.parametrize(("turning", "c"), [(64, 1), (64, 6), (640, 80)])
def test_with_one_delayed_product_the_reach_is_the_frequency_at_which_both_are_of_one_size(
    turning: int, c: int
) -> None:
    """|2 j w + q|^2 = |j w + c|^2 where 3 w^2 = c^2 - q^2: the reach is at most a step of a quarter beyond that."""
    own = loop({1: {(0,): [2, 0], (1,): [1, 0]}, 0: {(0,): [0, 1], (1,): [c, 0]}}, (Rational(1),))
    for q in (0, c / 3, c * 0.8):
        there = ((c**2 - q**2) / 3) ** 0.5
        found = reach_of(own).radius(arb(q), turning, inverse=False)
        assert found is not None
        assert 0.999 * there <= float(found) <= 1.26 * there
    assert c < 6 or reach_of(own).radius(arb(0), c // 3, inverse=False) is None
    late = loop({2: {(1,): [3]}, 1: {(0,): [c], (1,): [1]}, 0: {(0,): [c]}}, (Rational(1),))  # no highest power in time
    found = reach_of(late).radius(arb(0), turning, inverse=False)
    assert found is not None
    for w in float(found) * np.array([1, 1.5, 10]):
        assert abs(3 * (1j * w) ** 2 + 1j * w) > abs(c * 1j * w + c)
