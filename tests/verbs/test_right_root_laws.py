"""One root on the right for all values of an interval: its values, its steps and its proofs, on roots that were put there."""

from __future__ import annotations

import random
from itertools import product
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from sympy import Integer, Rational

from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.stability.rightroot import RightRoots, _newton, _Values

LAG = Rational(1, 5)


def exact(x: Any) -> ExactNumber:
    return ExactNumber(Rational(x))


def loop(table: dict[Any, dict[int, list[int]]]) -> Any:
    own = {Rational(p): {(n,): [Integer(c) for c in row] for n, row in group.items()} for p, group in table.items()}
    return SimpleNamespace(table=own, ring=SimpleNamespace(lags=(LAG,)), turns=False)


def polynomial(*rows: list[int]) -> Any:
    """Of s, ascending, each coefficient ascending in the open number."""
    return loop({n: {0: row} for n, row in enumerate(rows)})


def test_values_between_two_ends_are_in_a_ball_and_inverses_of_those_without_an_end_that_keep_0_out() -> None:
    ends = (None, -3, -1, 0, 2, 5)
    for low, high in product(ends, ends):
        if low is not None and high is not None and low >= high:
            continue
        found = _Values.of(*(None if x is None else exact(x) for x in (low, high)))
        if low is not None and high is not None:
            assert found is not None
            assert all(found.ball.contains(x) for x in (low, (low + high) / 2, high))
            assert not any(found.ball.contains(x) for x in (low - 0.01, high + 0.01))
            continue
        end = low if low is not None else high
        if end is None or (end <= 0 if low is not None else end >= 0):
            assert found is None
            continue
        assert found is not None
        assert all(found.ball.contains(x) for x in (arb(1) / end, arb(1) / (2 * end), 0))
        assert not any(found.ball.contains(x) for x in (arb(1.01) / end, arb(-0.01) / end))


def test_the_middle_is_as_many_times_the_lesser_as_it_goes_into_the_larger_or_some_times_further_out() -> None:
    for low, high, middle in (
        (1, 4, 2),
        (2, 18, 6),
        (-9, -1, -3),
        (-1, 4, 1.5),
        (0, 4, 2),
        (-6, 0, -3),
        (3, None, 48),
        (None, -2, -32),
    ):
        found = _Values.of(*(None if x is None else exact(x) for x in (low, high)))
        assert found is not None
        assert float(found.middle) == pytest.approx(middle)
    close = _Values.of(exact(1), exact(1 + Rational(1, 2**52)))
    assert close is not None
    assert 1 <= close.middle <= 1 + Rational(1, 2**52)


@pytest.mark.parametrize("seed", range(3))
def test_a_row_is_a_polynomial_in_the_number_or_without_an_end_in_its_inverse(seed: int) -> None:
    draw = random.Random(seed)
    for low, high in ((1, 2), (-3, 4), (2, None), (None, -2)):
        own = _Values.of(*(None if x is None else exact(x) for x in (low, high)))
        assert own is not None
        row = [draw.randint(-9, 9) for _ in range(draw.randint(1, 4))]
        at = draw.randint(-4, 4)
        ascending = row if low is not None and high is not None else row[::-1]
        assert own.of_row([arb(c) for c in row], arb(at)) == sum(c * at**i for i, c in enumerate(ascending))


@pytest.mark.parametrize("seed", range(4))
def test_steps_of_newton_end_at_a_zero_or_nowhere(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(12):
        terms = [(float(n), draw.choice([0.0, 0.2, 0.4]), draw.choice([-3.0, -1.0, 1.0, 2.0, 0.0])) for n in range(4)]
        terms.append((2.5, 0.1, 1.0))
        found = _newton(terms, complex(draw.uniform(0.1, 3), draw.uniform(-3, 3)))
        if found is not None and found:
            parts = [c * found**p * np.exp(-found * lag) for p, lag, c in terms]
            slope = sum(x * (p / found - lag) for x, (p, lag, _) in zip(parts, terms, strict=True))
            assert abs(sum(parts)) < 1e-6 * (abs(slope * found) + 1e-9)
    true = _newton([(2.0, 0.0, 1.0), (1.0, 0.0, -4.0), (0.0, 0.0, 13.0)], 3 + 2j)  # (s - 2)^2 + 9
    assert true == pytest.approx(2 + 3j, rel=1e-12)
    assert _newton([(0.0, 0.5, 1.0), (0.0, 0.0, -3.0)], 1 + 1j) == pytest.approx(-2 * np.log(3) + 0j, abs=1e-9)
    assert _newton([(0.0, 0.0, 5.0)], 1 + 1j) is None  # no slope
    assert _newton([(0.0, 900.0, 1.0), (1.0, 0.0, 1e-9)], -50 + 1j) is None  # beyond all floats


def test_a_box_into_which_newtons_step_goes_has_a_root_on_the_right_for_all_values() -> None:
    """(s - q)(s - 8): for q from 1.9 to 2.1 a root near 2, and one at 8."""
    own = RightRoots(polynomial([0, 8], [-8, -1], [1, 0]))
    values = _Values.of(exact(Rational(19, 10)), exact(Rational(21, 10)))
    assert values is not None
    with flint.ctx.workprec(192):
        for place, size, told in (
            (2, 0.5, True),
            (8, 0.5, True),
            (2, 0.05, False),
            (5, 0.5, False),
            (5, 4, False),
            (2.1, 1, True),
            (3, 0.5, False),
        ):
            assert own._stays(complex(place, 0), size, values) is told, (place, size)
        assert own._stays(2 + 0.1j, 0.5, values) is True
    left = RightRoots(polynomial([0, 8], [8, 1], [1, 0]))  # (s + q)(s + 8)
    with flint.ctx.workprec(192):
        assert left._stays(-2 + 0j, 0.5, values) is False
        wide = RightRoots(polynomial([-1, 1], [1, 0]))  # s = 1 - q
        near = _Values.of(exact(Rational(1, 2)), exact(Rational(3, 5)))
        assert near is not None
        assert wide._stays(0.45 + 0j, 0.4, near) is True
        assert wide._stays(0.45 + 0j, 0.5, near) is False  # the box goes beyond the axis


@pytest.mark.parametrize("seed", range(2))
def test_an_interval_is_told_where_one_root_stays_on_the_right_for_all_of_its_values(seed: int) -> None:
    """(s - a)(s + 1) + q s + b q: roots by NumPy, all over the interval and far beyond."""
    draw, told = random.Random(seed), set()
    for _ in range(4):
        a, b = draw.choice([-4, -2, 1, 3]), draw.choice([-2, -1, 1, 3])
        own = RightRoots(polynomial([-a, b], [1 - a, 1], [1, 0]))

        def right(q: float, a: int = a, b: int = b) -> bool:
            return bool((np.roots([1, 1 - a + q, b * q - a]).real > 1e-12).any())

        for low, high in ((1, 2), (-3, -2), (6, None), (None, -6)):
            found = own.everywhere(None if low is None else exact(low), None if high is None else exact(high), 1)
            ends = [float(x) for x in (low, high) if x is not None]
            at = np.linspace(ends[0], ends[1], 9) if len(ends) == 2 else ends[0] * np.geomspace(1, 1e4, 9)
            assert not found or all(map(right, at))
            told.add(found)
    assert told
    own.loop.turns = True
    assert own.everywhere(exact(1), exact(2)) is False


def test_a_root_that_stays_or_moves_with_the_number_is_told_and_where_all_are_on_the_left_none_is() -> None:
    """(s - 1)(s - 2 q) of which one stays, and (s - q)(s - 3 q), of which both move; (s + q)(s + 1)."""
    for low, high in ((1, 2), (3, 4)):
        ends = exact(low), exact(high)
        assert RightRoots(polynomial([0, 2], [-1, -2], [1, 0])).everywhere(*ends)
        assert RightRoots(polynomial([0, 0, 3], [0, -4, 0], [1, 0, 0])).everywhere(*ends)
        assert not RightRoots(polynomial([0, 1], [1, 1], [1, 0])).everywhere(*ends, depth=1)


def test_where_no_box_holds_for_all_values_at_once_they_are_parted_as_often_as_is_allowed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Values are told at once if they are no wider than a fourth of 8, and do not begin at one that never is."""
    for depth, never, told in (
        (0, None, False),
        (1, None, False),
        (2, None, True),
        (3, None, True),
        (5, 2, False),
        (5, 6, False),
    ):
        asked: list[tuple[float, float]] = []

        def at_once(_: Any, values: Any, never: int | None = never, asked: Any = asked) -> bool:
            low, high = float(values.low), float(values.high)
            asked.append((low, high))
            return high - low <= 2.0 and not (never is not None and low <= never <= high)

        monkeypatch.setattr(RightRoots, "_at_once", at_once)
        own = RightRoots(polynomial([1, 1], [1, 0]))
        monkeypatch.setattr(_Values, "middle", property(lambda x: Rational(float(x.low) + float(x.high)) / 2))
        assert own.everywhere(exact(0), exact(8), depth) is told
        if told:
            assert sorted(x for x in asked if x[1] - x[0] <= 2) == [(0, 2), (2, 4), (4, 6), (6, 8)]
        assert min(b - a for a, b in asked) >= 8 / 2**depth


def test_guesses_are_zeros_on_the_right_and_the_farthest_of_them_are_tried() -> None:
    """s (s - 1) ((s - 3)^2 + 4), all of them on the right."""
    row = np.poly([0, 1, 3 + 2j, 3 - 2j]).real[::-1]
    own = RightRoots(loop({n: {0: [round(c)]} for n, c in enumerate(row) if round(c)}))
    values = _Values.of(exact(1), exact(2))
    assert values is not None
    found = {complex(round(z.real, 9), round(z.imag, 9)) for z in own._guesses(values)}
    assert found <= {1 + 0j, 3 + 2j}
    assert 3 + 2j in found
    assert own.everywhere(exact(1), exact(2)) is True


def test_of_many_zeros_those_farthest_to_the_right_are_tried_in_boxes_of_three_sizes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: list[tuple[complex, float]] = []
    own = RightRoots(polynomial([1, 1], [1, 0]))
    monkeypatch.setattr(RightRoots, "_guesses", lambda *_: [complex(n % 10 + 1, 1) for n in range(25)])
    monkeypatch.setattr(RightRoots, "_stays", lambda _, s, size, __: tried.append((s, size)))
    assert own._at_once(SimpleNamespace()) is False  # type: ignore[arg-type]
    assert tried == [(complex(n, 1), n / part) for n in (10, 9, 8, 7, 6, 5) for part in (2, 8, 32)]
