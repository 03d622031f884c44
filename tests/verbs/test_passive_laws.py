"""For which values every passive hand may hold rational and sampled displays: closed forms, placed zeros, kinds of ends."""

from __future__ import annotations

from math import sqrt
from random import Random
from typing import Any

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, Symbol

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import s
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.freeparameter import domain
from haptisym.verbs.require.passive import _all, _is_of_passive_parts, turns_of_poles

Q = Symbol("q", real=True)


def ends(r: Any) -> Any:
    return [tuple(None if e.value is None else float(e.value) for e in (x.low, x.high)) for x in r.feasible]


def kinds(r: Any) -> list[set[str]]:
    return [{b.kind.value for b in end.bindings} for end in r.ends]


# --- rational displays ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2))
def test_behind_a_lag_a_damper_must_make_up_for_the_spring_at_rest_or_for_the_mass_far_out(seed: int) -> None:
    """(k + c s + m s^2)/(1 + s/w) + b s: b >= (k w - c w^2 - m w omega^2)/(omega^2 + w^2), so k/w - c and -m w."""
    pick = Random(seed)
    k, c, m, w = (Rational(pick.randint(*x), 4) for x in ((1, 400), (0, 8), (-8, 8), (20, 200)))
    felt = hs.environments.expression("k + c*s + m*s^2", parameters={"k": k, "c": c, "m": m})
    scene = hs.Scene(felt, (hs.effects.first_order_lag(w), hs.effects.shunt(b=1)))
    r = hs.require(scene, "effects.shunt.b", that="passive")
    at_rest, far = k / w - c, -m * w
    assert ends(r) == [(float(max(at_rest, far)), None)]
    assert r.certified
    assert r.feasible[0].low.closed
    assert at_rest != far
    assert ("start" in kinds(r)[0]) is bool(at_rest > far)
    assert ("far-out" in kinds(r)[0]) is bool(far > at_rest)


@pytest.mark.parametrize("seed", range(2))
def test_a_set_of_which_several_frequencies_bind_is_told_with_all_of_its_ends(seed: int) -> None:
    """s (s^4 - q s^2 + c)/(s + 1)^4 beside b s, by Im H/omega = (...)/(1 + x)^4 + b, x = omega^2: from dense x in floats."""
    pick = Random(seed)
    c, b = Rational(pick.randint(2, 30)), Rational(pick.randint(1, 6), 8)
    felt = hs.environments.expression(f"s*(s^4 - q*s^2 + {c})/(s + 1)^4", parameters={"q": 1})
    r = hs.require(hs.Scene(felt, (hs.effects.shunt(b=b),)), "q", (-40, 40), that="passive")
    omega = np.concatenate([[1e-6], np.geomspace(1e-3, 1e4, 4000)])
    z = 1j * omega

    def least(q: float) -> float:
        return float(np.min((z * (z**4 - q * z**2 + float(c)) / (z + 1) ** 4).imag / omega + float(b)))

    for q in np.linspace(-39.7, 39.7, 41):
        inside = any(low <= q <= high for low, high in ends(r) if low is not None and high is not None)
        if abs(least(q)) > 1e-3:
            assert inside is (least(q) > 0)
    for low, high in ends(r):
        for x in (low, high):
            assert x is not None
            assert abs(x) == 40 or abs(least(x)) < 1e-4
    assert r.certified


@pytest.mark.parametrize("seed", range(2))
def test_between_rest_and_far_out_a_damper_may_neither_be_too_small_nor_too_large(seed: int) -> None:
    """(a s^2 + q s + k)/(s^2 + p s + r): Im H has the sign of omega^2 (a p - q) + q r - p k, so p k/r <= q <= a p."""
    pick = Random(seed)
    a, p, r = (Rational(pick.randint(1, 9), 2) for _ in range(3))
    k = a * r * Rational(pick.randint(1, 7), 8)
    felt = hs.environments.expression(
        "(a*s^2 + q*s + k)/(s^2 + p*s + r)", parameters={"a": a, "q": a * p, "k": k, "p": p, "r": r}
    )
    found = hs.require(hs.Scene(felt), "q", (-100, 100), that="passive")
    assert ends(found) == [(float(p * k / r), float(a * p))]
    assert [sorted(x & {"start", "far-out"}) for x in kinds(found)] == [["start"], ["far-out"]]
    assert all(x.closed for span in found.feasible for x in (span.low, span.high))


def test_a_condition_that_is_touched_inside_the_band_binds_there() -> None:
    """s (s^2 + q s + 4) (s + 1) over (s + 1)^3: Im H/omega vanishes twice at one frequency where it begins to be negative."""
    felt = hs.environments.expression("s*(s^2 + 4)*(s + 2)/(s + 1)^3 + q*s", parameters={"q": 1})
    r = hs.require(hs.Scene(felt), "q", that="passive")
    omega = np.geomspace(1e-3, 1e3, 200_001)
    z = 1j * omega
    least = -np.min((z * (z**2 + 4) * (z + 2) / (z + 1) ** 3).imag / omega)
    [(low, high)] = ends(r)
    assert high is None
    assert low == pytest.approx(least, rel=1e-6)
    assert "tangency" in kinds(r)[0]


MENU: list[tuple[Expr, str, dict[Kind, set[int]]]] = [
    (s + Q - 1, "below", {Kind.START: {1}, Kind.AXIS: {1}}),
    (s + Q - 2, "above", {Kind.START: {2}}),
    (s**2 + (Q - 3) * s + 4, "below", {Kind.AXIS: {3}}),
    (s**2 + (Q - 4) * s + 4, "above", {}),
    ((Q - 5) * s + 1, "below", {Kind.FAR: {5}}),
    ((Q - 6) * s + 1, "above", {Kind.FAR: {6}}),
    ((Q + 7) * s**2 + s + 3, "above", {Kind.FAR: {-7}}),
    (s**3 + s**2 + (Q + 8) * s + 2, "below", {Kind.AXIS: {-6}}),  # -8 + 2: (q + 8) = 2
    (s + 9, "below", {}),
    (Q - 10, "above", {Kind.FAR: {10}, Kind.START: {10}}),
]


@pytest.mark.parametrize("seed", range(6))
def test_poles_and_zeros_turn_where_they_were_placed_to_reach_0_the_axis_or_infinity(seed: int) -> None:
    pick = Random(seed)
    rows = pick.sample(MENU, 4)
    above, below = Integer(1), Integer(1)
    expected = dict[Kind, set[int]]()
    for form, side, turns in rows:
        above, below = (above * form, below) if side == "above" else (above, below * form)
        for kind, values in turns.items():
            expected[kind] = expected.get(kind, set()) | values
    ring = Ring.of([above.expand(), below.expand(), Q, s])
    function = (ring.convert(above.expand()) / ring.convert(below.expand())).reduced()
    free: Any = type("Free", (), {"symbol": Q})
    found = dict[Kind, set[float]]()
    for turn in turns_of_poles(function, free):
        [binding] = turn.bindings
        assert binding.omega is None
        found.setdefault(binding.kind, set()).add(float(turn.value))
    assert found == {kind: set(map(float, values)) for kind, values in expected.items()}
    other: Any = type("Free", (), {"symbol": Symbol("elsewhere")})
    assert [*turns_of_poles(function, other)] == []


# --- of passive parts -------------------------------------------------------------------------------------------------

LINE, DEVICE = hs.effects.wave_variables(10, "20 ms"), hs.effects.shunt(m="0.1 kg", b=1)
LIVELY = hs.environments.expression("g*s^2/(s + 1) + k", parameters={"g": 1, "k": 1})  # of a g > 0 it gives energy away


@pytest.mark.parametrize(
    ("felt", "effects", "free", "asked", "told"),
    [
        (hs.environments.kelvin_voigt(100, 1), (LINE, DEVICE), "environment.k", None, True),
        (hs.environments.kelvin_voigt(100, 1), (LINE, DEVICE), "environment.b", (1, 2), True),
        (hs.environments.kelvin_voigt(100, 1), (LINE, DEVICE), "effects.shunt.b", (1, 2), False),  # it may be negative
        (hs.environments.expression("k + s", parameters={"k": 1}), (LINE,), "environment.k", (1, 2), False),
        (hs.environments.kelvin_voigt(100, 1), (hs.effects.delay("1 ms"), DEVICE), "environment.k", None, False),
        (hs.environments.kelvin_voigt(100, 1), (LINE, DEVICE), "effects.wave-variables.tau", None, True),
        (
            hs.environments.expression("20 - s", parameters={}),
            (LINE, DEVICE),
            "effects.wave-variables.tau",
            None,
            False,
        ),
    ],
)
def test_parts_that_all_take_energy_whatever_the_number_is_are_seen_to_be(
    felt: Any, effects: Any, free: str, asked: Any, *, told: bool
) -> None:
    scene = hs.Scene(felt, effects)
    knob = scene.knobs[free]
    assert _is_of_passive_parts(scene, knob, domain(knob, asked)) is told


def test_all_values_are_those_that_were_asked_about_at_which_there_is_a_scene() -> None:
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 1), (LINE, hs.effects.first_order_lag(40)))
    for free, asked, closed in (
        ("environment.k", (1, 2), True),
        ("omega_c", None, False),
        ("environment.b", None, True),
    ):
        knob = scene.knobs[free]
        own = domain(knob, asked)
        [span] = _all(scene, knob, own).feasible
        assert (span.low.value and float(span.low.value), span.low.closed) == (float(own.low or 0), closed)
        assert (span.high.value and float(span.high.value)) == (own.high and float(own.high))
        assert _all(scene, knob, own).undecided == ()


# --- sampled loops ----------------------------------------------------------------------------------------------------


def wall(k: Any, b: Any, device: Any, delay: int = 0) -> hs.Scene:
    loop = hs.effects.sampled_loop("1 ms", "backward-difference", delay=delay)
    return hs.Scene(
        hs.environments.expression("k + b*s", parameters={"k": k, "b": b}), (loop, hs.effects.shunt(m="40 g", b=device))
    )


@pytest.mark.parametrize("b", ["0.4", "-0.3"])
def test_the_least_damping_of_a_device_is_that_of_the_worst_angle_which_binds_at_rest_or_at_half_the_rate(
    b: str,
) -> None:
    """K T/2 + B at half the rate, K T/2 - B at rest."""
    r = hs.require(wall(500, b, 3), "effects.shunt.b", that="passive")
    assert ends(r) == [(pytest.approx(0.25 + abs(float(b)), rel=1e-15), None)]
    assert not r.feasible[0].low.closed
    [found] = kinds(r)
    assert ("far-out" in found) >= (b == "0.4")
    assert ("start" in found) >= (b == "-0.3")
    assert len(found & {"far-out", "start"}) == 1
    wide = hs.require(wall(500, b, 1), "environment.b", (-5, 5), that="passive")
    assert ends(wide) == [(pytest.approx(-0.75, rel=1e-14), pytest.approx(0.75, rel=1e-14))]
    assert [sorted(x & {"start", "far-out"}) for x in kinds(wide)] == [["start"], ["far-out"]]


@pytest.mark.parametrize("seed", range(2))
def test_with_late_samples_the_set_of_stiffnesses_is_that_of_a_scan_over_all_angles(seed: int) -> None:
    """b > T/(2 (1 - cos x)) Re((1 - e^-jx) (K + B (1 - e^-jx)/T) e^-jnx), x up to pi."""
    pick = Random(seed)
    b, device, late = pick.choice([0.1, 0.3]), pick.choice([0.6, 1.5]), pick.choice([1, 2])
    r = hs.require(wall(500, str(b), str(device), late), "environment.k", (0, 10_000), that="passive")
    x = np.linspace(1e-4, np.pi, 20_001)
    step = 1 - np.exp(-1j * x)

    def room(k: float) -> float:
        own = step * (k + b * step / 1e-3) * np.exp(-1j * late * x)
        return float(device - np.max(own.real * 1e-3 / 2 / (1 - np.cos(x))))

    [(low, high)] = ends(r)
    assert low == 0
    assert high is not None
    assert room(0.99 * high) > 0 > room(1.01 * high)
    assert abs(room(high)) < 1e-6 * sqrt(device)


def test_what_the_display_does_not_depend_on_leaves_one_verdict_for_all() -> None:
    held = wall(500, "0.4", 1).with_hands(hs.Hand("mine", 1, 1, 1))
    for free in ("hand.b", "evaluation.jnd"):
        r = hs.require(held, free, that="passive")
        assert (ends(r), r.certified) == ([(0, None)], True)
    worse = wall(5000, "0.4", 1).with_hands(hs.Hand("mine", 1, 1, 1))
    assert ends(hs.require(worse, "hand.b", that="passive")) == []
