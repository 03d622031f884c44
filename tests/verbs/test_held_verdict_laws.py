"""What is said of a display that is held, or whose motion is imposed: tables of all that its roots and parts may be."""

from __future__ import annotations

import random
from itertools import product
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import I, Integer, Rational, exp
from sympy.abc import q

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rootcount import RootChain, Roots
from haptisym.kernel.symbols import s
from haptisym.verbs.stability import held
from haptisym.verbs.stability.held import Held, Imposed

HAND = hs.Hand("any", 1, 2, 3)
OMEGA = ExactNumber(Integer(3))


def test_a_display_is_stable_in_a_hand_without_roots_on_the_right_or_on_the_axis() -> None:
    for number, on_axis in ((0, ()), (1, ()), (2, (OMEGA,)), (None, ())):
        chain = RootChain.RIGHT if number is None else None
        row = Held(HAND, Roots(number, number, on_axis, chain))
        assert (row.stable, row.unstable, row.on_axis) == (number == 0, number, on_axis)
        assert row._line() == f"any: {'stable' if number == 0 else 'not stable'}"
    row = Held(HAND, None, "why")
    assert (row.stable, row.unstable, row.on_axis, row._line()) == (None, None, (), "any: undecided")


def test_roots_are_asked_for_at_rest_where_the_hand_damps_and_all_parts_only_take_energy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[bool] = []

    def roots_in_hand(perceived: Any, hand: Any, *, at_rest: bool) -> Roots:
        assert (perceived, hand.name) == ("perceived", "any")
        asked.append(at_rest)
        return Roots(0, 0)

    monkeypatch.setattr(held, "roots_in_hand", roots_in_hand)
    monkeypatch.setattr(held, "clocked_roots", lambda *_: Roots(5, 5))
    chain = SimpleNamespace(at=lambda _: "display")
    own: Any = SimpleNamespace(chain=chain, parameters=(), distortion=lambda: SimpleNamespace(perc="perceived"))
    for clock, damping, rests in product((False, True), (0, Rational(1, 10**9), 7), (False, True)):
        monkeypatch.setattr(held, "clocks", lambda _, clock=clock: ("one",) * clock)
        monkeypatch.setattr(held, "rests", lambda *_, rests=rests: rests)
        found = held.unstable_roots(own, hs.Hand("any", 1, damping, 3))
        assert found.number == (5 if clock else 0)
        assert clock or asked[-1] is (damping > 0 and rests)
    assert len(asked) == 6

    def fails(*_: Any) -> Roots:
        raise UndecidedError("why")

    monkeypatch.setattr(held, "unstable_roots", fails)
    assert held.held(own, HAND) == Held(HAND, None, "why")


def test_poles_of_a_force_are_counted_unless_it_is_known_to_be_stable_by_more_than_its_environment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    perceived = SimpleNamespace(denominator="below", numerator="above")
    own: Any = SimpleNamespace(distortion=lambda: SimpleNamespace(perc=perceived))
    cases: Any = product((True, False, None), (False, True), (False, True), (0, 2, None, "open"))
    for stable, lags, alone, number in cases:

        def zeros_of(top: Any, bottom: Any, ring: Any, number: Any = number) -> Roots:
            assert (top, bottom) == ("below", "above")
            if number == "open":
                raise UndecidedError("why")
            return Roots(number, number, chain=RootChain.NEAR if number is None else None)

        monkeypatch.setattr(held, "force_is_stable", lambda *_, stable=stable: stable)
        monkeypatch.setattr(held, "ring_of", lambda _, lags=lags: SimpleNamespace(lags=(1,) * lags))
        monkeypatch.setattr(held, "environment_alone", lambda _, alone=alone: alone)
        monkeypatch.setattr(held, "zeros_of", zeros_of)
        found = held.imposed(own)
        chain = RootChain.NEAR if number is None else None
        if stable is None:
            assert found == Imposed(stable=None, unstable=None)
        elif stable and not (lags and alone):
            assert found == Imposed(stable=True, unstable=0)
        elif number == "open":
            assert found == Imposed(stable, 0 if stable else None)
        else:
            assert found == Imposed(stable, 0 if stable else number, chain)


@pytest.mark.parametrize("seed", range(3))
def test_the_characteristic_function_is_the_numerator_of_display_and_hand(seed: int) -> None:
    draw = random.Random(seed)
    ring = Ring.of([s, exp(-s)])
    for _ in range(5):
        N = sum((draw.randint(-5, 5) * s**n for n in range(3)), Integer(0)) + draw.randint(1, 4) * exp(-s)
        D = s + draw.randint(1, 5)
        Z = draw.randint(1, 3) * s**2 + Rational(draw.randint(1, 5), 3) * s + draw.randint(0, 3)
        perceived, hand = ring.convert(N) / ring.convert(D), ring.convert(Z)
        found = held.characteristic(perceived, hand)
        ratio = ring.expression(found) / ring.expression(perceived.denominator) / ring.expression(hand.denominator)
        for at in (Rational(1, 2), Rational(3), Rational(-7, 3)):
            assert abs(float((ratio - N / D - Z).subs(s, at))) < 1e-9


def test_a_function_with_j_among_its_numbers_has_no_roots_in_s() -> None:
    for expression, fails in ((s**2 + I * s + 3, True), (s**2 + q * s + 3, False), (s + exp(-s), False)):
        ring = Ring.of([expression])
        top = ring.convert(expression).numerator
        if fails:
            with pytest.raises(UndecidedError, match="describing function"):
                held.need_roots(top, ring)
            with pytest.raises(UndecidedError, match="describing function"):
                held.zeros_of(top, ring.convert(s).numerator, ring)
        else:
            held.need_roots(top, ring)
    ring = Ring.of([I * s + 1])
    held.need_roots(ring.convert(s + 2).numerator, ring)  # of one that could have, but has none


@pytest.mark.parametrize("late", [False, True])
def test_what_top_and_bottom_share_at_0_is_taken_off_and_a_chain_is_left_as_it_is(*, late: bool) -> None:
    """s^a (s^2 + 4) (s - 1) over s^b: a root at 0 of order a - b, if that is positive."""
    ring = Ring.of([s, exp(-s)])
    for a, b in product(range(4), repeat=2):
        top = (s**a * (s**2 + 4) * (s - 1) * ((s + 3 + exp(-s)) if late else 1)).expand()
        found = held.zeros_of(ring.convert(top).numerator, ring.convert(s**b).numerator, ring)
        left = max(a - b, 0)
        assert (found.number, found.right) == (3 + left, 1)
        assert [float(x) for x in found.on_axis] == [0.0] * bool(left) + [2.0]
    chain = held.zeros_of(ring.convert(s * (s + 2 * s * exp(-s)) + s).numerator, ring.convert(s).numerator, ring)
    assert (chain.number, chain.chain) == (None, RootChain.RIGHT)
    resting = held.zeros_of(ring.convert(s**3 + s**2).numerator, ring.convert(s).numerator, ring, rests=True)
    assert (resting.number, resting.right, [float(x) for x in resting.on_axis]) == (1, 0, [0.0])
