"""Steps of a walk along a number of a loop with a clock: tables of what may come of each, and of what lies at the end, at 0."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb
from sympy import Integer, Rational, Symbol

from haptisym.kernel.budget import limited
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import clockcritical
from haptisym.verbs.stability.clockcritical import Passage, Walk
from haptisym.verbs.stability.clockvalues import CriticalValue, Swing

k = Symbol("k", real=True)

# A step past values where balls do not tell


OUTCOMES = ("on", "changed", "none", "open")


@pytest.mark.parametrize("side", [-1, 1])
def test_past_values_that_balls_leave_open_ever_more_of_them_are_taken_until_something_is_known(
    side: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three times as many cells each: a root stays there, the count changes, or none is there for all of the values."""
    one, step = Fraction(5, 2), Fraction(side, 1000)
    for outcomes in product(OUTCOMES, repeat=3):
        ends = [one + n * step for n in clockcritical._STEPS]
        at = dict(zip(ends, outcomes, strict=True))
        between: list[Any] = []

        def count(x: Any, at: dict[Fraction, str] = at) -> tuple[int, int]:
            kind = at[Fraction(int(x.p), int(x.q))]
            return (3 + (kind == "changed"), int(kind == "on"))

        def has_none(_: Any, low: Fraction, high: Fraction, depth: int, at: dict[Fraction, str] = at) -> bool:
            assert low < high
            assert one in (low, high)
            assert depth > 0
            return at[high if side > 0 else low] == "none"

        monkeypatch.setattr(Walk, "_has_none", has_none)
        monkeypatch.setattr(Walk, "_between", lambda *x, between=between: (between.append(x[1:]), "passage")[1])
        walk = Walk(SimpleNamespace(count=count), one, 3, Rule.ANY)  # type: ignore[arg-type]
        first = next((n for n, x in enumerate(outcomes) if x != "open"), None)
        if first is None or outcomes[first] == "on":
            with pytest.raises(UndecidedError, match="go back" if first is None else "stays on the unit circle"):
                walk._over(one, step)
            continue
        found, known = walk._over(one, step)
        assert known == ends[first]
        assert (found == "passage") == (outcomes[first] == "changed")  # type: ignore[comparison-overlap]
        assert between == ([(one, known, 4)] if outcomes[first] == "changed" else [])


@pytest.mark.parametrize("depth", range(4))
@pytest.mark.parametrize("narrow", range(5))
def test_a_stretch_holds_none_where_pieces_as_narrow_as_may_be_are_clear(depth: int, narrow: int) -> None:
    """Balls are told as clear if they are no wider than 1/2^narrow and hold no bad value."""
    asked: list[Any] = []
    for bad in (None, Fraction(1, 3), Fraction(2, 3), Fraction(1), Fraction(4, 3)):

        def is_clear(q: Any, bad: Fraction | None = bad) -> bool:
            asked.append(q)
            return q.rad() <= 2.0**-narrow / 2 * 1.01 and not (bad and q.contains(arb(bad.numerator) / bad.denominator))

        asked.clear()
        walk = Walk(SimpleNamespace(is_clear=is_clear), Fraction(0), 0, Rule.ANY)  # type: ignore[arg-type]
        found = walk._has_none(Fraction(0), Fraction(1), depth)
        assert found is (narrow <= depth and bad in (None, Fraction(4, 3)))
        if found:
            covered = [q for q in tuple(asked) if is_clear(q, bad)]
            assert all(any(q.contains(n / 64) for q in covered) for n in range(65))
    with limited(1e-9), pytest.raises(LimitError):
        walk._has_none(Fraction(0), Fraction(1), depth)


@pytest.mark.parametrize("side", [-1, 1])
def test_between_two_values_a_change_is_that_of_the_one_test_whose_sign_differs(side: int) -> None:
    low, high = Fraction(3), Fraction(4)
    for kinds in product((-1, 0, 1), repeat=3):
        changed = [i for i, x in enumerate(kinds) if x < 0]

        def tests(q: Any, kinds: Any = kinds) -> tuple[Any, ...]:
            upper = q > 3.5
            return tuple(arb(5) if not upper else arb(5 * x) for x in kinds)

        walk = Walk(SimpleNamespace(tests=tests), low, 7, Rule.ANY)  # type: ignore[arg-type]
        one, other = (low, high) if side > 0 else (high, low)
        if len(changed) != 1:
            with pytest.raises(UndecidedError, match="together"):
                walk._between(one, other, 9)
            continue
        found = walk._between(one, other, 9)
        assert isinstance(found.value, CriticalValue)
        assert (found.value.test, found.value.low, found.value.high) == (changed[0], low, high)
        assert found.omega == Swing(found.value)
        assert (found.below, found.above) == ((7, 9) if side > 0 else (9, 7))


# The end of what was looked at


def test_a_change_at_0_is_told_where_one_root_comes_to_1_there_and_no_other_is_near() -> None:
    at = Fraction(1, 1000)
    numbers = product(
        (-1, 1), (Rule.ANY, Rule.POSITIVE, Rule.NONNEGATIVE), (Fraction(0), Fraction(1)), (None, 5, 6), (0, 1)
    )
    for side, rule, start, count, always in numbers:
        for one, clear in (
            (k * (k + 2), True),
            (k * (k - Rational(1, 2000)), False),
            (k + 2, False),
            (k * (2 + k) ** 2, True),
        ):
            for tests in ((arb(1), arb(1)), (arb(0), arb(1)), (arb(1), arb(0)), (arb(-1), arb("inf"))):

                def counted(_: Any, count: int | None = count) -> tuple[int, int]:
                    if count is None:
                        raise UndecidedError("why")
                    return count, 1

                loop = SimpleNamespace(
                    count=counted, at_one=one, symbol=k, always=always, tests=lambda _, tests=tests: (arb(0), *tests)
                )
                found = Walk(loop, start, 5, rule)._at_0(at, side)  # type: ignore[arg-type]
                is_told = side < 0 and rule is Rule.NONNEGATIVE and start == 1 and count == 6 and not always
                if is_told and clear and all(x.is_finite() and not x.contains(0) for x in tests):
                    assert found == Passage(ExactNumber(Integer(0)), ExactNumber(Integer(0)), 6, 5)
                else:
                    assert found is None, (side, rule, start, count, one, tests)


def test_down_to_0_a_number_is_clear_only_if_it_may_not_be_less_and_balls_say_so() -> None:
    for side, start, rule, clear in product(
        (-1, 1), (-1, 0, 1), (Rule.ANY, Rule.POSITIVE, Rule.NONNEGATIVE), (False, True)
    ):
        asked: list[Any] = []
        loop: Any = SimpleNamespace(is_clear=lambda q, asked=asked, clear=clear: (asked.append(q), clear)[1])
        found = Walk(loop, Fraction(start), 0, rule)._is_clear_down_to_0(Fraction(1, 8), side)
        assert found is ((side, start) == (-1, 1) and rule is not Rule.ANY and clear)
        assert all(q.contains(0) and q.contains(0.125) and not q.contains(0.13) for q in asked)


@pytest.mark.parametrize("start", [Fraction(-3), Fraction(0), Fraction(5, 7)])
@pytest.mark.parametrize("side", [-1, 1])
def test_where_balls_tell_nothing_any_more_cells_are_cut_to_what_counts_as_finest(
    start: Fraction, side: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scale = abs(start) or Fraction(1)
    wall = start + side * scale * Fraction(3, 2)
    asked: list[tuple[Fraction, Fraction]] = []
    ahead: list[tuple[Fraction, Fraction]] = []

    def is_clear(_: Any, one: Fraction, other: Fraction) -> bool:
        ahead.append((one, other))
        assert (other - one) * side > 0
        return (wall - other) * side > 0

    def over(_: Any, one: Fraction, step: Fraction) -> Any:
        asked.append((one, step))
        raise UndecidedError("why")

    monkeypatch.setattr(Walk, "_is_clear", is_clear)
    monkeypatch.setattr(Walk, "_over", over)
    found, known = Walk(SimpleNamespace(), start, 0, Rule.ANY).towards(side)  # type: ignore[arg-type]
    [(at, step)] = asked
    assert (found, known) == (None, at)
    finest = clockcritical._FINEST * max(abs(at), scale * clockcritical._FINEST)
    assert finest / 2 < step * side <= finest
    assert 0 < (wall - at) * side <= 2 * abs(step)
    passed = [(a, b) for a, b in ahead if (wall - b) * side > 0]
    assert passed[0][0] == start
    assert all(x[1] == y[0] for x, y in pairwise(passed))
    assert passed[-1][1] == at
    assert len(ahead) < 200
