"""Walks of a loop with a clock, step by step: against roots that are put at values, and tables of what may come of each step."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from math import acos
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Poly, Rational, Symbol, pi

import haptisym as hs
from haptisym.kernel.budget import left, limited
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.pulse import Plant, SampledLoop
from haptisym.kernel.reals import ExactNumber
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import clockcritical, clockrange
from haptisym.verbs.stability.clockcritical import Opened, opened, start_of
from haptisym.verbs.stability.clocked import loop_of
from haptisym.verbs.stability.clockrange import Passages, in_half_the_time
from haptisym.verbs.stability.clockvalues import Passage

k = Symbol("k", real=True)
w = Symbol("w")
T = Rational(1, 4)


def opened_with(C: Expr) -> Opened:
    """1/s behind a hold of 1/4 s is w/(4 (1 - w)), w = 1/z: with the controller 4 ((C - 1)/w + 1) the loop is C, if C(0) = 1."""
    row = Poly((((C - 1) / w + 1) / T).expand(), w).all_coeffs()[::-1]
    return Opened(
        SampledLoop(Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),)), T, (*row,), (Integer(1),)), k
    )


def drawn(draw: random.Random) -> tuple[Expr, list[Rational], Rational]:
    """(1 - a k w) (1 + b k w) (1 - p w + c k^2 w^2): at 1/a, 1/b and c^-1/2 roots reach 1, -1 and a pair of angle arccos(p/2)."""
    values = [Rational(x, 8) for x in draw.sample(range(9, 40), 3)]
    p = Rational(draw.randint(-7, 7), 8)
    C = (1 - k / values[0] * w) * (1 + k / values[1] * w) * (1 - p * w + (k / values[2]) ** 2 * w**2)
    return C, values, p


@pytest.mark.parametrize("seed", range(3))
def test_the_nearest_passages_are_where_roots_were_put_on_the_circle(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw = random.Random(seed)
    C, values, p = drawn(draw)
    stays = draw.choice([0, 1])
    loop = opened_with(C * (1 - w) ** stays)
    start = draw.choice([Rational(1), sorted(values)[0] + Rational(1, 20), sorted(values)[1] + Rational(1, 20)])
    monkeypatch.setattr(clockrange, "opened", lambda *_: loop)
    monkeypatch.setattr(clockrange, "is_held", lambda *_: False)
    free: Any = SimpleNamespace(value=start, rule=Rule.POSITIVE)
    found = clockrange.passages(Any, Any, free)  # type: ignore[arg-type]
    assert (loop.always, loop.is_fixed) == (stays, False)
    angles = [0.0, np.pi, acos(float(p) / 2)]
    expected = []
    for side in (-1, 1):
        ahead = sorted((abs(x - start), i) for i, x in enumerate(values) if (x - start) * side > 0)
        if ahead:
            i = ahead[0][1]
            below = stays + sum((1 + (n == 2)) for n, x in enumerate(values) if x < values[i])
            expected.append((float(values[i]), angles[i] / float(T), below, below + 1 + (i == 2)))
    told = [(float(x.value), float(x.omega), x.below, x.above) for x in found.found]
    assert told == [pytest.approx(x, rel=1e-12, abs=1e-12) for x in expected]
    assert found.low is None or found.low < Fraction(int(start.p), int(start.q))
    assert found.high is None or Fraction(int(start.p), int(start.q)) < found.high


@pytest.mark.parametrize("seed", range(3))
def test_an_opened_loop_has_the_coefficients_counts_and_tests_of_the_polynomial_it_was_made_of(seed: int) -> None:
    draw = random.Random(seed)
    C, values, p = drawn(draw)
    for stays in (0, 1, 2):
        whole = (C * (1 - w) ** stays).expand()
        loop = opened_with(whole)
        assert loop.always == stays
        for value in (Rational(1), values[0], values[1], values[2], Rational(7)):
            true = Poly(C.subs(k, value), w).all_coeffs()[::-1]
            with flint.ctx.workprec(128):
                q = arb(int(value.p)) / int(value.q)
                row = loop.row(q)
                assert [float(x) for x in row] == pytest.approx([float(x) * (-1) ** stays for x in true], abs=1e-12)
                zero = [bool(x.contains(0)) for x in loop.tests(q)]
            on = [value == values[0], value == values[1], value == values[2]]
            sizes = [(1 + (n == 2)) * bool(value >= x) for n, x in enumerate(values)]
            assert loop.count(value) == (sum(sizes) + stays, on[0] + on[1] + 2 * on[2])
            assert zero[:2] == on[:2]
            assert zero[2] or not on[2]
            with flint.ctx.workprec(300):
                angle = loop.angle(arb(int(value.p)) / int(value.q), 90) if on[2] else None
            assert angle is None or float(angle) == pytest.approx(acos(float(p) / 2), abs=1e-12)
            if angle is not None and stays:
                assert angle.rad() < arb(2) ** -80


def test_an_angle_is_that_of_the_one_pair_on_the_circle_and_none_where_there_are_two_or_none() -> None:
    """At k = 1 of pairs with cos = 1/4, -1/2, and roots at 1, -1, 1/2, and a pair of |z|^2 = 1/2 or 2."""
    one, other = 1 - w / 2 + k * w**2, 1 + w + k * w**2
    inner, outer = 1 - w / 3 + k * w**2 / 2, 1 - w / 3 + 2 * k * w**2
    for more in (Integer(1), 1 - w / 2, 1 - k * w, 1 + k * w, (1 - k * w) * (1 + k * w), inner, outer):
        for row, cos in ((one, 0.25), (other, -0.5)):
            with flint.ctx.workprec(200):
                found = opened_with((row * more).expand()).angle(arb(1), 100)
            assert float(found) == pytest.approx(acos(cos), abs=1e-14)
            assert found.rad() < arb(2) ** -90
        with flint.ctx.workprec(200):
            assert not opened_with((one * other * more).expand()).angle(arb(1), 100).is_finite()
            assert not opened_with((more * (1 - w / 7)).expand()).angle(arb(1), 100).is_finite()


@pytest.mark.parametrize("place", range(6))
def test_a_loop_is_fixed_where_the_number_is_in_none_of_its_parts(place: int) -> None:
    one = Integer(1)
    parts: list[Any] = [one, one, one, one, one]
    if place < 5:
        parts[place] = k
    period, above, below, bottom, top = parts
    for lag in (Integer(0), k):
        plant = Plant((Integer(2), bottom, one), ((Integer(0), (top, one)), (one / 3, (one,)), (lag, (one,))))
        own = Opened(SampledLoop(plant, period, (one, above), (one, below)), k)
        assert own.is_fixed is (place == 5 and lag == 0)


def test_where_balls_fail_a_loop_is_not_clear(monkeypatch: pytest.MonkeyPatch) -> None:
    own = opened_with(1 - k * w)
    assert own.is_clear(arb(0.5))
    assert not own.is_clear(arb(1))
    for error in (UndecidedError("why"), ZeroDivisionError()):

        def fails(*_: Any, error: Exception = error) -> bool:
            raise error

        monkeypatch.setattr(clockcritical, "is_clear", fails)
        assert own.is_clear(arb(0.5)) is False


def test_each_number_of_a_hand_and_of_a_display_is_opened_alone() -> None:
    sampled, shunt = hs.effects.sampled_loop("1 ms", "backward-difference", 1), hs.effects.shunt(m="0.04", b="0.8")
    scene = hs.Scene(hs.environments.kelvin_voigt("90 N/m", 2), (sampled, shunt)).with_hands(
        hs.Hand("any", "0.1 kg", 3, 5)
    )
    [hand] = scene.hands
    seen = set()
    for knob in scene.knobs:
        if knob.parts or not (knob.is_of_hand or knob.symbol in {p.symbol for p in scene.parameters}):
            continue
        own, value = opened(scene, hand, knob), knob.value * Rational(4, 3)
        moved = scene.with_values({knob.path: value})
        mine, theirs = own.at(value).balls(), loop_of(moved, moved.hands[0]).balls()
        assert own.symbol == knob.symbol
        assert len(mine) == len(theirs)
        assert all((x * theirs[0]).overlaps(y * mine[0]) for x, y in zip(mine, theirs, strict=True))
        before = loop_of(scene, hand).balls()
        assert own.is_fixed or not all((x * before[0]).overlaps(y * mine[0]) for x, y in zip(mine, before, strict=True))
        seen.add(knob.path)
    assert len(seen) >= 7


def test_one_starts_at_a_rational_number_beside_another_one_with_no_root_on_the_circle_in_between() -> None:
    clear: Any = arb(1)
    far: Any = arb("inf")
    asked: list[Any] = []

    def loop(*tests: Any) -> Any:
        def told(q: Any) -> Any:
            asked.append(q)
            return tests

        return SimpleNamespace(tests=told)

    assert start_of(loop(), Rational(2, 7)) == Rational(2, 7)
    assert not asked
    for row in ((clear, -clear, clear), (arb(-2), arb(3, 1), clear)):
        assert start_of(loop(*row), pi) == Rational(float(pi))
        assert asked[-1].contains(arb(float(pi)))
        assert asked[-1].overlaps(arb.pi())
    for place, wrong in product(range(3), (arb(0), arb(1, 2), far, arb("nan"))):
        wrong_one = [clear, -clear, clear]
        wrong_one[place] = wrong
        with pytest.raises(UndecidedError, match="no rational one"):
            start_of(loop(*wrong_one), pi)


def test_each_side_gets_half_of_the_time_that_is_left() -> None:
    walk: Any = SimpleNamespace(towards=lambda side: (left(), side))
    assert in_half_the_time(walk, -1) == (None, -1)  # type: ignore[comparison-overlap]
    with limited(100_000):
        seconds, side = in_half_the_time(walk, 1)
    assert side == 1
    assert isinstance(seconds, float)
    assert 49_000 < seconds <= 50_000


def test_passages_are_those_of_both_sides_unless_the_number_cannot_be_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    here: Any = SimpleNamespace(is_fixed=False, count=lambda _: (3, 0))
    monkeypatch.setattr(clockrange, "opened", lambda *_: here)
    monkeypatch.setattr(clockrange, "is_held", lambda *_: False)
    monkeypatch.setattr(clockrange, "inverted", lambda *_: None)
    one, other = (Passage(ExactNumber(Integer(x)), ExactNumber(Integer(0)), 3, 4) for x in (1, 5))
    told: dict[int, Any] = {}
    walks: list[Any] = []

    def half(walk: Any, side: int) -> Any:
        walks.append(walk)
        return told[side]

    monkeypatch.setattr(clockrange, "in_half_the_time", half)

    def ask(rule: Rule = Rule.POSITIVE) -> Passages:
        return clockrange.passages(Any, Any, SimpleNamespace(value=Rational(7, 2), rule=rule))  # type: ignore[arg-type]

    for below, above in product((one, None), (other, None)):
        told = {-1: (below, Fraction(1)), 1: (above, Fraction(5))}
        assert ask() == Passages(tuple(x for x in (below, above) if x), Fraction(1), Fraction(5))
        assert (walks[-1].start, walks[-1].home, walks[-1].rule) == (Fraction(7, 2), 3, Rule.POSITIVE)
    for rule in (Rule.NONNEGATIVE, Rule.ANY):
        assert ask(rule).low == 1
    with pytest.raises(UndecidedError, match="an order in a loop"):
        ask(Rule.FRACTION)
    told = {-1: (None, Fraction(7, 2)), 1: (None, Fraction(7, 2))}
    with pytest.raises(UndecidedError, match="next to whose value") as error:
        ask()
    assert not isinstance(error.value, LimitError)
    with limited(1e-9), pytest.raises(LimitError):
        ask()
    here.count = lambda _: (3, 1)
    with pytest.raises(UndecidedError, match="on the unit circle now"):
        ask()
    here.is_fixed = True
    assert ask() == Passages(())
