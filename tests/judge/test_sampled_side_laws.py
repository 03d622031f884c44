"""The damping that a sampled loop needs, of right-hand sides that are known by hand in t = tan(theta/2): bounded, and not."""

from __future__ import annotations

from math import atan, pi

import pytest
from sympy import Expr, Integer, Rational

import haptisym as hs
from haptisym.judge.colgate import SampledPassivity, sampled_passivity
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as t

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
