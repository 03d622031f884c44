"""Values at which roots come from infinity: what stands with the highest power of s, and zeros on the unit circle."""

from __future__ import annotations

import random
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Symbol, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.symbols import s
from haptisym.verbs.stability import farout
from haptisym.verbs.stability.farout import _is_product, _need_same_zeros, _sum, from_infinity, is_neutral
from haptisym.verbs.stability.loops import Loop

q = Symbol("q", positive=True)
LAGS = (Integer(1), pi, pi**2 / 3)


def loop_of(expression: Expr, low: Expr | None = Integer(0)) -> Loop:  # noqa: B008  exact and constant
    ring = Ring.of([expression])
    top = ring.convert(expression).numerator
    return Loop(ring, top, top.context().constant(1), q, low)


def row(draw: random.Random, most: int) -> list[int]:
    return [draw.randint(-5, 5) for _ in range(most)]


def formula(c: list[int]) -> Expr:
    return sum((x * q**i for i, x in enumerate(c)), Integer(0))


def told(loop: Loop) -> list[float]:
    found = from_infinity(loop)
    assert all(x.omega is None for x in found)
    return sorted({round(float(x.value), 9) for x in found if float(x.value) >= 0})


@pytest.mark.parametrize("seed", range(4))
def test_of_delays_that_nothing_joins_all_values_are_told_at_which_one_term_is_as_large_as_all_others(
    seed: int,
) -> None:
    """|c_0| = |c_1| + |c_2| + ..., at dense values; each that is told is one of some signs."""
    draw = random.Random(seed)
    for _ in range(3):
        count = draw.choice([1, 2, 3])
        rows = [row(draw, draw.choice([1, 2, 2, 3])) for _ in range(count + 1)]
        if not any(any(c[1:]) for c in rows) or not any(map(any, rows[1:])) or not any(rows[0]):
            continue
        L = formula(rows[0]) + sum(
            (formula(c) * exp(-s * lag) for c, lag in zip(rows[1:], LAGS, strict=False)), Integer(0)
        )
        own = loop_of(s**3 * L + s + 2)
        assert is_neutral(own)
        found = told(own)

        def sizes(x: Any, rows: Any = rows) -> Any:
            return [sum(c * x**i for i, c in enumerate(r)) for r in rows]

        x = np.linspace(0.0013, 12, 40_001)
        c = sizes(x)
        margin = abs(c[0]) - sum(map(abs, c[1:]))
        for i in np.flatnonzero(margin[1:] * margin[:-1] < 0):
            assert any(x[i] - 1e-9 <= y <= x[i + 1] + 1e-9 for y in found), (rows, x[i])
        for y in found:
            own_one, *late = sizes(y)
            assert min(
                abs(own_one + sum(k * z for k, z in zip(signs, late, strict=True)))
                for signs in product((1, -1), repeat=len(late))
            ) < 1e-5 * (1 + y**2)


@pytest.mark.parametrize("seed", range(4))
def test_of_multiples_of_one_delay_values_are_told_that_put_a_zero_on_the_unit_circle(seed: int) -> None:
    """L(z; q), z = exp(-s/2): its zeros by NumPy, on the circle at each value that is told, and nowhere where none is told."""
    draw = random.Random(seed)
    rows = [row(draw, 2), row(draw, 1), row(draw, draw.choice([1, 2]))]
    if not any(rows[0]) or not any(rows[2]) or not any(rows[1]):
        rows = [[1, 2], [3], [-1, 1]]
    L = sum((formula(c) * exp(-s * n / 2) for n, c in enumerate(rows)), Integer(0))
    try:
        found = told(loop_of(s**2 * L + 3))
    except UndecidedError:
        return

    def zeros(x: float) -> Any:
        return abs(np.roots([sum(c * x**i for i, c in enumerate(r)) for r in rows[::-1]]))

    near = [y for y in found if abs(sum(c * y**i for i, c in enumerate(rows[2]))) > 1e-9]
    for y in near:
        assert len(zeros(y)) < 2 or min(abs(zeros(y) - 1), default=0) < 1e-4 or y == 0
    before = None
    for x in np.linspace(0.0017, 9, 1500):
        here = int((zeros(x) < 1).sum())
        if before is not None and before[1] != here:
            assert any(before[0] - 1e-9 <= y <= x + 1e-9 for y in found), (rows, x)
        before = x, here


@pytest.mark.parametrize("seed", range(3))
def test_a_product_is_one_where_all_rows_are_multiples_of_one_and_its_values_are_the_zeros_of_that(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        first = [draw.randint(1, 4), draw.randint(-4, 4), draw.choice([0, 1])]
        factors = [draw.choice([-2, 1, 3]) for _ in range(2)]
        leading: dict[tuple[int, ...], Any] = {(0,): [*map(Integer, first)]}
        leading |= {(n + 1,): [Integer(f * c) for c in first] for n, f in enumerate(factors)}
        assert _is_product(leading)
        i, n = draw.randrange(3), draw.randint(0, 2)
        leading[n,] = [c + (k == i) for k, c in enumerate(leading[n,])]
        rows = [[int(c) for c in r] for r in leading.values()]
        assert _is_product(leading) is bool(np.linalg.matrix_rank(rows) == 1)
    L = (q - 2) * (q - 5) * (3 + exp(-s) + exp(-2 * s))
    assert told(loop_of((s**2 * L + s).expand())) == [2, 5]
    assert told(loop_of(s**2 * (3 + exp(-s)) + q * s)) == []
    assert told(loop_of(s**2 * (q - 3) + q * s)) == [3]


def test_rows_of_several_lengths_are_added_power_by_power() -> None:
    assert _sum([[Integer(1)], [Integer(2), Integer(3)], [Integer(4), Integer(5), Integer(6)]]) == [7, 8, 6]
    assert _sum([[Integer(1), Integer(2)], [Integer(-1)]]) == [0, 2]


@pytest.mark.parametrize("group", range(2))
def test_an_open_delay_that_meets_others_is_left_open_unless_they_keep_clear_of_0_whatever_their_phases(
    group: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What all terms share is left out first, and what is asked about is the number before each of the others."""
    asked: list[Any] = []
    plain, late = Integer(1), q * 2
    for rests, mirrored, clear, lags in product(
        (False, True), (False, True), (False, True), ((plain, late), (late, plain), (plain, pi))
    ):

        def least(own: Any, clear: bool = clear) -> Any:  # noqa: FBT001
            asked.append(own)
            return 1 if clear else None

        monkeypatch.setattr(farout, "least_on_torus", least)
        monkeypatch.setattr(farout, "is_mirrored", lambda _, m=mirrored: m)
        loop: Any = SimpleNamespace(symbol=q, rests=rests, ring=SimpleNamespace(lags=lags))
        leading: Any = {(2, 1): [Integer(3)], (3, 1): [Integer(4)], (2, 2): [Integer(5)]}
        own = {(0, 0): 3, (1, 0): 4, (0, 1): 5}
        if group:  # of one unit alone once what is shared is left out
            leading, own = {(2, 1): [Integer(3)], (4, 1): [Integer(4)]}, {}
        is_open = (
            not group and q in lags[0].free_symbols | lags[1].free_symbols and not (rests and mirrored) and not clear
        )
        asked.clear()
        if is_open:
            with pytest.raises(UndecidedError, match="no multiples of one"):
                _need_same_zeros(leading, loop)
        else:
            _need_same_zeros(leading, loop)
        assert all(x == own for x in asked)
    assert group or asked == [] or asked == [own]


@pytest.mark.parametrize(
    ("expression", "low", "reason"),
    [
        (s**2 * (3 + q**2 + exp(-s)) + 1, None, "a number that may be negative"),
        (
            s**2 * (3 + q * sum((exp(-s * pi**n / 3**n) for n in range(6)), Integer(0))) + 1,
            Integer(0),
            "many delays meet",
        ),
    ],
)
def test_what_is_not_told_of_infinity_is_left_open(expression: Expr, low: Expr | None, reason: str) -> None:
    with pytest.raises(UndecidedError, match=reason):
        from_infinity(loop_of(expression.expand(), low))


@pytest.mark.parametrize(("one", "other"), [([0, 1], [2]), ([1, 2], [5, 1]), ([3], [-1, 4])])
def test_where_all_that_stands_with_the_highest_power_is_late_the_larger_part_of_it_counts(
    one: list[int], other: list[int]
) -> None:
    """c_1(q) exp(-s) + c_2(q) exp(-s pi): of one size where c_1 = c_2 or c_1 = -c_2."""
    own = loop_of(s**3 * (formula(one) * exp(-s) + formula(other) * exp(-s * pi)) + s + 2)
    longest = [np.poly1d(c[::-1]) for c in (one, other)]
    true = {float(x) for sign in (1, -1) for x in (longest[0] + sign * longest[1]).roots if x >= 0}
    assert told(own) == pytest.approx(sorted(true))


def test_a_number_that_may_be_negative_is_told_where_it_stands_alone_in_each_term() -> None:
    found = from_infinity(loop_of(s**2 * (3 + q * 2 + exp(-s)) + 1, None))
    assert sorted({float(x.value) for x in found}) == [-2, -1]
    five = s**2 * (9 + q + sum((exp(-s * pi**n / 3**n) for n in range(5)), Integer(0))) + 1
    assert sorted({float(x.value) for x in from_infinity(loop_of(five.expand(), None))}) == [
        float(x) for x in range(-14, -3, 2)
    ]
