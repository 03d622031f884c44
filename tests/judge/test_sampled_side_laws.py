"""The damping that a sampled loop needs, of right-hand sides that are known by hand in t = tan(theta/2): bounded, and not."""

from __future__ import annotations

import random
from math import atan, pi

import flint
import pytest
from flint import arb
from sympy import Expr, Integer, Rational
from sympy import pi as pi_

import haptisym as hs
from haptisym.judge.colgate import SampledPassivity, sampled_passivity
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as t
from haptisym.model.hand import Hand
from haptisym.verbs.stability.clocked import loop_of as clock_loop
from haptisym.verbs.stability.held import held

SIDES: dict[Expr, tuple[int, float] | None] = {
    4 * t**2 / (1 + t**2) ** 2: (1, pi / 2),
    1 / (1 + t**2): (1, 0),
    t**2 / (1 + t**2): (1, pi),
    16 * t**2 / (1 + 4 * t**2) ** 2: (1, 2 * atan(0.5)),
    16 * t**2 / (4 + t**2) ** 2: (1, 2 * atan(2)),
    1 - 1 / t**2: (1, pi),
    1 - t**2: (1, 0),
    1 - (t**2 - 9) ** 2 / t**2: (1, 2 * atan(3)),
    1 - (9 * t**2 - 1) ** 2 / t**2: (1, 2 * atan(1 / 3)),
    t**2: None,
    1 / t**2: None,
    t**2 - 1 / t**2: None,
    1 / t**2 - t**2: None,
    1 / (t**2 - 4) - 2: None,
    1 / (4 * t**2 - 1): None,
}
"""Each with its largest value, and theta there; None where it has none."""


NONE = Integer(0)


def real(x: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(x.together()).reduced())


def loop(side: Expr, damping: Expr = NONE, *, is_settled: bool = True) -> SampledPassivity:
    return SampledPassivity(Rational(1, 100), damping, (real(side), real(side.subs(t, 1 / t))), is_settled)


@pytest.mark.parametrize("side", SIDES, ids=str)
def test_a_device_needs_more_damping_than_the_largest_right_hand_side_and_a_hand_makes_up_for_what_it_lacks(
    side: Expr,
) -> None:
    most, found = SIDES[side], loop(side).needed
    if most is None:
        assert found is None
        assert loop(side, Integer(9)).passive is False
        assert loop(side, Integer(9), is_settled=False).passive is False
        assert loop(side, Integer(9)).hand_needed is None
        assert loop(side).row(5)["damping_needed"] is None
        return
    assert found is not None
    assert found.omega is not None
    assert float(found.value) == most[0]
    assert float(found.omega) == pytest.approx(most[1], rel=1e-15)
    for damping, holds, more in ((Rational(1, 4), False, 0.75), (Rational(101, 100), True, 0.0)):
        own = loop(side, damping)
        assert own.passive is holds
        assert own.hand_needed is not None
        assert float(own.hand_needed) == more
        assert own.row(5)["passive"] is holds
        open_ = loop(side, damping, is_settled=False)
        assert (open_.passive, open_.hand_needed) == (None, None)
    row = loop(side).row(5)
    assert (row["damping_needed"], row["digits"]) == (1.0, "1.0000")
    assert row["theta"] == pytest.approx(most[1], rel=1e-15)


def test_just_the_damping_that_is_needed_is_not_enough_at_any_angle() -> None:
    for side, most in SIDES.items():
        if most:
            assert loop(side, Integer(1)).passive is False
            assert float(loop(side, Integer(1)).hand_needed or -1) == 0


# What lies between clock and hand


def wall(*device: hs.Effect) -> SampledPassivity:
    """It needs K T/2 + B = 0.79 N s/m of a device."""
    felt = hs.environments.kelvin_voigt(1500, "0.04")
    found = sampled_passivity(hs.Scene(felt, (hs.effects.sampled_loop("1 ms", "backward-difference"), *device)))
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("device", "damping"),
    [
        ((), 0),
        ((hs.effects.shunt(m="0.04", b="0.8"),), Rational(4, 5)),
        ((hs.effects.shunt(b="0.5", name="x"), hs.effects.shunt(b="0.5", k=1, name="y"), hs.effects.shunt(m=1, name="z")), 1),
        ((hs.effects.shunt(b="-0.5", name="x"), hs.effects.shunt(b="0.5", name="y")), 0),
        ((hs.effects.shunt(m=-1, name="x"), hs.effects.shunt(m=1, b=1, name="y")), 1),
        ((hs.effects.shunt(Z="3*s"),), 3),
        ((hs.effects.shunt(Z="b*s^2", parameters={"b": 5}),), 0),
        ((hs.effects.shunt(Z="k*s + b", parameters={"k": 5, "b": 1}),), 5),
        ((hs.effects.shunt(Z="q*s + m*(s + 1)^2", parameters={"q": 5, "m": 1}),), 7),
    ],
)  # fmt: skip
def test_the_damping_of_a_device_is_the_coefficient_of_s_of_all_that_lies_beside_it_whatever_its_numbers_are_called(
    device: tuple[hs.Effect, ...], damping: Rational
) -> None:
    found = wall(*device)
    assert found.needed is not None
    assert float(found.needed.value) == 0.79
    assert found.damping == damping
    assert found.passive is bool(damping > Rational(79, 100))


@pytest.mark.parametrize(
    "part",
    [
        hs.effects.compliance(k=1000, b=1), hs.effects.series("2"), hs.effects.delay("1 ms"), hs.effects.shunt(m=-1), hs.effects.shunt(k=-1),
        hs.effects.shunt(Z="s^3"), hs.effects.shunt(Z="1/(s + 1)"), hs.effects.shunt(Z="s - k", parameters={"k": 2}), hs.effects.first_order_lag(50),
    ],
    ids=repr,
)  # fmt: skip
def test_of_anything_else_between_clock_and_hand_nothing_is_said(part: hs.Effect) -> None:
    good = hs.effects.shunt(m="0.5", b=9, k="0.5", name="good")
    for listed in ((part,), (part, good), (good, part)):
        found = wall(*listed)
        assert (found.sides, found.needed, found.passive, found.hand_needed) == (None,) * 4
        assert found.reason == "something other than mass, spring and damper lies between clock and hand"
    assert wall(good).passive is True


# At rest, and damping that is taken away


def drawn(draw: random.Random) -> tuple[hs.Scene, Rational]:
    """A wall of any sign behind a clock, and its stiffness at rest with that of the device."""
    k, own = Rational(draw.randint(-40, 60), 4), Rational(draw.choice([0, 0, 1, 4]))
    formula = draw.choice(["k + b*s", "k + b*s*90/(s + 90)", "k*50/(s + 50) + b*s"])
    felt = hs.environments.expression(formula, parameters={"k": k, "b": draw.choice(["0.1", "0.4", "-0.2"])})
    device = hs.effects.shunt(m="0.05", b=draw.choice(["0.3", "0.6", "2", "-0.1"]), k=own)
    clock = hs.effects.sampled_loop(draw.choice(["1 ms", "8 ms"]), "backward-difference", draw.choice([0, 1]))
    return hs.Scene(felt, (clock, device)), k + own


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(40))
def test_every_passive_hand_holds_a_wall_on_a_clock_only_if_it_pushes_none_away(seed: int) -> None:
    draw = random.Random(seed)
    scene, at_rest = drawn(draw)
    found = sampled_passivity(scene)
    assert found is not None
    assert found.needed is not None
    assert found.at_rest == at_rest
    assert found.pushes is bool(at_rest < 0)
    damped = max(float(found.needed.value), 0.0)
    assert found.passive is (
        float(found.damping) > float(found.needed.value) and min(float(at_rest), float(found.damping)) >= 0
    )
    assert ("stiffness_at_rest" in found.row(5)) is found.pushes
    if found.pushes:
        assert found.hand_needed is None
        soft = Hand("soft", m="0.1", b=50, k=-at_rest / 2)
        assert held(scene, soft).unstable != 0
        return
    assert found.hand_needed is not None
    assert float(found.hand_needed) == pytest.approx(max(damped - float(found.damping), 0), abs=1e-12)
    for _ in range(3):
        b = Rational(float(found.hand_needed) + draw.choice([1e-6, 0.1, 3]))
        hand = Hand("own", m=draw.choice([0, 1, "0.03"]), b=b, k=draw.choice([1, 30, "1e5"]))
        assert held(scene, hand).unstable == 0
        assert found.is_held_by(b, hand.k.value)


def test_what_a_hand_holds_needs_both_damping_and_stiffness() -> None:
    def found(k: object, b: object) -> SampledPassivity:
        wall = hs.environments.expression("k", parameters={"k": k})
        scene = hs.Scene(wall, (hs.effects.sampled_loop("4 ms", "backward-difference"), hs.effects.shunt(m=1, b=b)))
        told = sampled_passivity(scene)
        assert told is not None
        return told

    stiff = found(500, "0.25")  # K T/2 = 1
    assert [stiff.is_held_by(Rational(x, 100), Integer(0)) for x in (74, 75, 76, 400)] == [False, False, True, True]
    away = found(-5, "0.25")  # it asks for -0.01
    assert [away.is_held_by(Integer(0), Integer(x)) for x in (0, 4, 5, 6)] == [False, False, False, True]
    assert away.asks_nothing
    assert not stiff.asks_nothing
    weak = found(-5, Rational(-1, 200))
    assert [weak.is_held_by(Rational(x, 1000), Integer(6)) for x in (0, 4, 5, 6)] == [False, False, False, True]
    assert loop(1 / (1 + t**2)).is_held_by(Integer(2), Integer(1))
    assert not loop(1 / (1 + t**2), is_settled=False).is_held_by(Integer(2), Integer(1))
    assert not loop(t**2).is_held_by(Integer(2), Integer(1))
    assert not SampledPassivity(Rational(1, 100)).is_held_by(Integer(2), Integer(1))


def test_without_any_damping_a_motion_may_go_on_between_the_samples() -> None:
    """A mass of 1 on 25 pi^2 swings with 5 pi = pi/T: it may be 0 at each sample, and the controller, which damps else, is blind."""
    unseen = 25 * pi_**2
    wall = hs.environments.expression("k", parameters={"k": -5})
    effects = hs.effects.sampled_loop("0.2 s", "backward-difference"), hs.effects.shunt(m=1)
    scene = hs.Scene(wall, effects)
    found = sampled_passivity(scene)
    assert found is not None
    assert found.asks_nothing
    assert not found.is_held_by(Integer(0), unseen - 1)
    assert found.is_held_by(Rational(1, 10**6), unseen - 1)
    with flint.ctx.workprec(200):
        loop_there = clock_loop(scene, Hand("own", k=unseen)).balls()
        at_minus_one = sum((x * (-1) ** n for n, x in enumerate(loop_there)), arb(0))
    assert at_minus_one.contains(0)
    assert at_minus_one.rad() < 1e-40


def test_the_stiffness_of_a_wall_and_of_its_device_that_every_passive_hand_may_hold() -> None:
    wall = hs.environments.expression("k + b*s", parameters={"k": "-2", "b": "0.1"})
    device = hs.effects.shunt(m="0.05", b="0.5", k=3)
    scene = hs.Scene(wall, (hs.effects.sampled_loop("1 ms", "backward-difference"), device))
    for path, low, high in (
        ("environment.k", -3, 800),  # k T/2 + 0.1 = 0.5
        ("effects.shunt.k", 2, None),
        ("effects.shunt.b", Rational(99, 1000), None),
    ):
        found = hs.require(scene, path, that="passive")
        assert found.certified is (path != "effects.shunt.k")  # of a device of negative stiffness nothing is said
        [span] = found.feasible
        assert (span.low.value.digits(9), span.low.closed) == (
            ExactNumber(Rational(low)).digits(9),
            path != "effects.shunt.b",
        )
        assert (None if span.high.value is None else float(span.high.value)) == high
