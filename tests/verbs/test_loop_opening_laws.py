"""Loops with one number left open, and with a clock, against the same at each value, in complex numbers and counts."""

from __future__ import annotations

import random
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, exp, lambdify

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.symbols import s
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import loops
from haptisym.verbs.stability.clocked import clock_of, impedance, loop_of, plant_of
from haptisym.verbs.stability.held import held
from haptisym.verbs.stability.loops import Loop

E, F = hs.environments, hs.effects
WALL = hs.Hand("any", m="0.4 kg", b=3, k=20)
SCENES = {
    "late": hs.Scene(E.kelvin_voigt(120, 2), (F.delay("30 ms"), F.shunt(m="0.1 kg", b=1))),
    "filtered": hs.Scene(E.mass_spring_damper(m="0.2 kg", b=1, k=90), (F.first_order_lag(30), F.compliance(k=900))),
}


def knobs_of(scene: hs.Scene) -> list[Any]:
    return [
        x for x in scene.knobs if not x.parts and (x.is_of_hand or x.symbol in {p.symbol for p in scene.parameters})
    ]


@pytest.mark.parametrize("name", SCENES)
def test_with_one_number_open_the_roots_at_each_value_are_those_of_the_display_with_that_value(name: str) -> None:
    scene = SCENES[name].with_hands(WALL)
    for free in knobs_of(scene):
        own = Loop.of(scene, scene.hands[0], free)
        allowed = {Rule.POSITIVE: (0, None), Rule.NONNEGATIVE: (0, None), Rule.ANY: (None, None), Rule.FRACTION: (0, 1)}
        assert ((own.low, own.high), own.symbol) == (allowed[free.rule], free.symbol)
        assert own.turns is (free.symbol.name == "tau")
        for factor in (Rational(1, 3), Rational(9)):
            value = free.value * factor
            moved = scene.with_values({free.path: value})
            mine, theirs = own.at(value), held(moved, moved.hands[0]).roots
            assert theirs is not None
            assert (mine.number, mine.right, mine.chain) == (theirs.number, theirs.right, theirs.chain), (
                free.path,
                value,
            )
            assert own.exists(value)


def test_with_one_number_open_the_function_is_that_of_display_and_hand() -> None:
    """(120 + 2 s) exp(-tau s) + (0.4 + 0.1) s^2 + (3 + 1) s + 20, one after the other of them open."""
    scene = SCENES["late"].with_hands(WALL)
    numbers = {"k": 120.0, "b": 2.0, "tau": 0.03, "m_shunt": 0.1, "m_h": 0.4, "b_h": 3.0, "k_h": 20.0}
    seen = set()
    for free in knobs_of(scene):
        own = Loop.of(scene, scene.hands[0], free)
        f = lambdify((s, free.symbol), own.ring.expression(own.top) / own.ring.expression(own.bottom))
        for factor in (0.4, 2.0):
            known = dict(numbers)
            key = {"m": "m_shunt"}.get(free.name, free.name)
            if key not in known:  # the damper of the shunt
                known["b_shunt"] = 1.0
                key = "b_shunt"
            else:
                known["b_shunt"] = 1.0
            known[key] *= factor
            seen.add(key)
            z = 0.7 + 3j
            true = (known["k"] + known["b"] * z) * np.exp(-z * known["tau"]) + known["k_h"]
            true += (known["m_h"] + known["m_shunt"]) * z * z + (known["b_h"] + known["b_shunt"]) * z
            assert complex(f(z, known[key])) == pytest.approx(complex(true), rel=1e-9)
    assert seen == {*numbers, "b_shunt"}


def test_a_loop_is_at_rest_where_the_number_has_a_least_value_the_hand_damps_and_all_parts_are_passive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = SCENES["filtered"].with_hands(WALL)
    for rests, damping in product((False, True), (0, 3)):
        monkeypatch.setattr(loops, "rests", lambda *_, rests=rests: rests)
        own = scene.with_hands(hs.Hand("any", m="0.4 kg", b=damping, k=20))
        for free in knobs_of(own):
            damps = damping > 0 or free.symbol.name == "b_h"
            found = Loop.of(own, own.hands[0], free)
            assert found.rests is (found.low is not None and damps and rests), free.path


def test_at_a_number_that_is_divided_by_there_is_no_dynamics() -> None:
    q = SCENES["late"].parameters[0].symbol
    ring = Ring.of([q, s])
    for bottom, zeros in ((q * s + 1, ()), (q - 2, (2,)), (q * (q - 3) * s, (0, 3)), (Integer(1) + 0 * q, ())):
        own = Loop(ring, ring.convert(s + q).numerator, ring.convert(bottom).numerator, q)
        assert [n for n in range(5) if not own.exists(Rational(n))] == [*zeros]
    other = Ring.of([s])
    assert Loop(other, other.constant(1), other.constant(1), q).exists(Rational(0))
    fixed = Loop(other, other.convert(s + 3).numerator, other.constant(1), q)
    assert fixed.powers == [fixed.top]
    assert fixed.at(Rational(7)).number == 0
    late = Ring.of([exp(-s * q)])
    assert Loop(late, late.constant(1), late.constant(1), q).exists(Rational(0))


# With a clock


SIZES = {"shunt": ((1, 9), (1, 9), (1, 3)), "compliance": ((100, 900), (1, 4))}


def held_force(z: complex, effects: tuple[Any, ...], Z: complex) -> complex:
    """Force per position of what moves, seen through shunts and compliances from the hand on."""
    for kind, numbers in reversed(effects):
        own = sum(c * z**n for n, c in enumerate(numbers))
        Z = Z + own if kind == "shunt" else 1 / (1 / own + 1 / Z)
    return Z


@pytest.mark.parametrize("seed", range(4))
def test_between_clock_and_hand_lies_what_moves_and_before_a_hold_the_display_itself(seed: int) -> None:
    draw = random.Random(seed)
    parts: list[Any] = []
    for _ in range(draw.randint(1, 3)):
        kind = draw.choice(["shunt", "compliance"])
        parts.append((kind, [draw.randint(*x) for x in SIZES[kind]]))
    behind = [F.shunt(k=n[0], b=n[1], m=n[2]) if kind == "shunt" else F.compliance(k=n[0], b=n[1]) for kind, n in parts]
    k, b = draw.randint(50, 900), draw.randint(1, 9)
    hand = hs.Hand("any", m=2, b=3, k=draw.randint(1, 50))
    wall = E.kelvin_voigt(k, b)
    z, w = 1.3 + 4j, 0.6 - 0.3j
    Z = held_force(z, (*parts,), 2 * z**2 + 3 * z + float(hand.k.value))

    def value(plant: Any) -> complex:
        top = sum(
            sum(complex(c) * z**n for n, c in enumerate(row)) * np.exp(-z * float(lag)) for lag, row in plant.terms
        )
        return complex(top / sum(complex(c) * z**n for n, c in enumerate(plant.denominator)))

    delay = draw.randint(0, 2)
    found = loop_of(
        hs.Scene(wall, (F.sampled_loop("2 ms", "backward-difference", delay), F.delay("3 ms"), *behind)), hand
    )
    assert value(found.plant) == pytest.approx(complex(np.exp(-z * 0.003) / Z), rel=1e-9)
    assert (found.T, found.plant.terms[0][0]) == (Rational(1, 500), Rational(3, 1000))
    ratio = sum(complex(c) * w**n for n, c in enumerate(found.above)) / sum(
        complex(c) * w**n for n, c in enumerate(found.below)
    )
    assert ratio == pytest.approx((k + b * (1 - w) * 500) * w**delay, rel=1e-12)
    before = hs.Scene(
        E.mass_spring_damper(k=k), (F.first_order_lag(40), F.compliance(k=700), F.zero_order_hold("5 ms"), *behind)
    )
    found = loop_of(before, hand)
    felt = 1 / ((z + 40) / (k * 40) + 1 / 700)
    assert value(found.plant) == pytest.approx(complex(felt / Z), rel=1e-9)
    assert (found.T, found.above, found.below) == (Rational(1, 200), (1,), (1,))


def test_the_clock_of_a_display_is_the_one_effect_that_has_one() -> None:
    hold, shunt = F.zero_order_hold("1 ms"), F.shunt(m="0.1 kg")
    for n in range(3):
        effects = [shunt, F.compliance(k=50), F.first_order_lag(50)]
        effects.insert(n, hold)
        place, clock = clock_of(hs.Scene(E.mass_spring_damper(k=9), tuple(effects)))
        assert (place, clock.model) == (n, "zero-order-hold")
    with pytest.raises(UndecidedError, match="two clocks"):
        clock_of(hs.Scene(E.mass_spring_damper(k=9), (hold, shunt, F.zero_order_hold("2 ms"))))


def test_a_force_that_does_not_reach_the_hand_or_moves_nothing_has_no_loop() -> None:
    ring = Ring.of([s])

    def effect(*entries: Expr) -> Any:
        return SimpleNamespace(matrix=tuple(Integer(0) + x for x in entries))

    hand = ring.convert(s**2 + 3)
    assert impedance(ring, (), hand) == hand
    one, other = effect(1, s, 0, 1), effect(2, 0, 1, 1)  # (Z + s), then Z/(Z + 2)
    found = impedance(ring, (one, other), hand)
    Z = (s**2 + 3) / (s**2 + 5)
    told = ring.expression(found.numerator) / ring.expression(found.denominator)
    assert (told - Z - s).together().as_numer_denom()[0].expand() == 0
    with pytest.raises(UndecidedError, match="does not reach the hand"):
        impedance(ring, (effect(-3 - s**2, 0, 1, 1),), hand)
    with pytest.raises(UndecidedError, match="nothing that has mass"):
        impedance(ring, (), ring.zero)


def test_a_power_of_s_that_cancels_is_in_no_ones_way() -> None:
    """Of a ring that has it, but a dynamics that has not."""
    G = (2 * s + 3) / (s**2 + 5 * s + 7)
    for ring in (Ring.of([G]), Ring.of([G, s ** Rational(1, 2)]), Ring.of([G, exp(-s), s ** Rational(1, 3)])):
        found = plant_of(ring.convert(G).reduced(), ring)
        [(lag, row)] = found.terms
        scale = found.denominator[-1]
        assert lag == 0
        assert [x / scale for x in found.denominator] == [7, 5, 1]
        assert [x / scale for x in row] == [3, 2]
    jump = Ring.of([s])
    with pytest.raises(UndecidedError, match="by an impulse"):
        plant_of(jump.convert(s**2 / (s + 1)).reduced(), jump)
