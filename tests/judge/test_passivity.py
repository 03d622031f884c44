"""Whether every passive hand may hold a display, at all frequencies: against scans far beyond the band, and made two-ports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Integer, Rational, exp

import haptisym as hs
from haptisym.judge.passivity import Beyond, passivity
from haptisym.judge.positivereal import poles_allow
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.far import Far, Sense, far
from haptisym.kernel.response import on_axis
from haptisym.kernel.symbols import s

ACTIVE_ABOVE_THE_BAND = {
    "zener-tissue": 92.70739,
    "sampled-wall": 304.9,
    "helicopter-cyclic": 292.7,
    "position-force-teleoperation": 49.73,
    "four-channel-teleoperation": 318,
}
"""Scenes with Im H_perc >= 0 on their whole band that are active just above it: from which frequency on, rad/s."""
SCENES = [x for x in hs.scene_names() if x != "control-stick-in-detail"]


def imaginary(scene: hs.Scene, omega: np.ndarray) -> np.ndarray:
    """Im H_perc, in floating point."""
    return np.asarray(scene.distortion().compile()(omega).perceived_imag)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ACTIVE_ABOVE_THE_BAND)
def test_activity_just_above_the_band_is_found_and_said(name: str) -> None:
    scene = hs.load_scene(name)
    found = passivity(scene)
    first = float(found.active[0].low.omega)
    assert first == pytest.approx(ACTIVE_ABOVE_THE_BAND[name], rel=2e-3)
    assert first > float(scene.band[1])
    assert found.holds is False
    assert hs.evaluate(scene).outside_model == ()
    assert "Not with every passive hand" in str(hs.evaluate(scene))
    verdict = " ".join(hs.metrics(scene)["passivity"].verdict.split())
    assert verdict.startswith("Im H_perc >= 0 on the whole band, but < 0 above it")
    assert verdict.endswith("every passive hand: does not hold")


@pytest.mark.few(5)
@pytest.mark.parametrize("name", SCENES)
def test_signs_are_those_of_a_scan_beyond_the_band(name: str) -> None:
    scene = hs.load_scene(name)
    found = passivity(scene)
    high = float(found.high)
    omega = np.linspace(0, high, 4001)[1:-1]
    active = np.zeros(omega.size, dtype=bool)
    for x in found.active:
        active |= (omega > float(x.low.omega)) & (omega < float(x.high.omega))
    values = imaginary(scene, omega)
    clear = np.abs(values) > 1e-9 * np.abs(values).max()
    assert np.array_equal(active[clear], (values < 0)[clear])
    further = imaginary(scene, np.geomspace(high, 20 * high, 4001)[1:])
    if found.beyond is Beyond.NEVER:
        assert further.min() >= -1e-9 * np.abs(further).max()
    elif found.beyond is Beyond.ALWAYS:
        assert further.max() < 0
    elif found.beyond is Beyond.AGAIN:
        assert further.min() < 0 < further.max()


def test_displays_that_every_passive_hand_may_hold_are_said_to_be() -> None:
    for name in ("fu2019", "steering-wheel", "sidestick", "two-mass-resonance", "desktop-device-soft-tissue"):
        assert passivity(hs.load_scene(name)).holds is True, name
        assert "Every passive hand may hold it" in str(hs.evaluate(name))


@pytest.mark.parametrize(
    ("name", "damping", "omega"),
    [
        ("delayed-spring", 3.6, 0),
        ("admittance-display", 2105.14199, 228.69),
        ("organ-tissue", 1.46113193, 86.7188),
        ("zener-tissue", 0.83793847, 237.111),
        ("helicopter-cyclic", 11.7449, 536.8),
        ("position-force-teleoperation", 24.230, 99.88),
    ],
)
def test_the_damping_that_makes_up_for_it_is_the_largest_of_a_scan(name: str, damping: float, omega: float) -> None:
    scene = hs.load_scene(name)
    found = passivity(scene).damping
    assert found is not None
    assert found.omega is not None
    assert float(found.value) == pytest.approx(damping, rel=1e-4)
    assert float(found.omega) == pytest.approx(omega, rel=1e-4)
    scan = np.geomspace(1e-2, 2e4, 200_001)
    assert (-imaginary(scene, scan) / scan).max() == pytest.approx(float(found.value), rel=1e-6)


def test_what_grows_faster_than_frequency_has_no_damping_that_makes_up_for_it() -> None:
    for name in ("satellite-contact", "four-channel-teleoperation"):
        found = passivity(hs.load_scene(name))
        assert found.damping is None
        assert found.is_unbounded


@pytest.mark.slow
@pytest.mark.parametrize("name", ["organ-tissue", "zener-tissue", "helicopter-cyclic"])
@pytest.mark.parametrize("times", ["1/1000", "1/7", "100"])
def test_a_display_of_a_multiple_of_the_forces_needs_that_multiple_of_the_damping(name: str, times: str) -> None:
    """Whatever the unit in which it is a small or a large number."""
    scene = hs.load_scene(name)
    gain = hs.effects.series(times, name="gain")
    one, other = (passivity(hs.Scene(scene.environment, x)).damping for x in (scene.effects, (*scene.effects, gain)))
    assert one is not None
    assert other is not None
    assert float(other.value) == pytest.approx(float(one.value) * float(Rational(times)), rel=1e-12)


@pytest.mark.parametrize("b", [3, 50])
def test_damping_that_is_needed_far_out_alone_is_the_limit_there_and_no_frequency_is_named(b: int) -> None:
    """-Im H/omega = b - k c/(k^2 + c^2 omega^2) k goes up to b."""
    found = passivity(hs.Scene(hs.environments.maxwell(100, 2), (hs.effects.shunt(b=-b),))).damping
    assert found is not None
    assert (float(found.value), found.omega) == (b, None)


def test_a_delayed_damper_needs_its_own_damping() -> None:
    found = passivity(hs.Scene(hs.environments.mass_spring_damper(b=5), (hs.effects.delay("20 ms"),)))
    assert found.damping is not None
    assert float(found.damping.value) == 5.0


def test_energy_per_cycle_is_the_work_of_a_simulated_cycle() -> None:
    """A spring late by tau gives pi k A^2 sin(omega tau) per cycle: 2.9545 mJ at 400 N/m, 2 mm, 2 Hz and 50 ms."""
    scene = hs.Scene(hs.environments.mass_spring_damper(k=400), (hs.effects.delay("50 ms"),))
    w, amplitude = 4 * np.pi, 2e-3
    given_away = -np.pi * amplitude**2 * imaginary(scene, np.array([w]))[0]
    assert given_away == pytest.approx(2.954530928784731e-3)
    t = np.linspace(0, 2 * np.pi / w, 100_001)
    force = 400 * amplitude * np.sin(w * (t - 0.05))
    assert -np.trapezoid(force * amplitude * w * np.cos(w * t), t) == pytest.approx(given_away, rel=1e-6)
    most = passivity(scene).most_given
    assert most is not None
    assert float(most.value) == pytest.approx(400)


POLE_RIGHT = hs.effects.shunt(Z="10*s*s/(s - 2)")
"""Z/s = 10 s/(s - 2): Re = 10 omega^2/(omega^2 + 4) >= 0 at every frequency, and a pole at s = 2."""
MINUS_MASS = hs.effects.shunt(m="-1 kg")
MINUS_SPRING = hs.effects.shunt(Z="-30")
DOUBLE_POLE = hs.effects.shunt(Z="-5/s")


@pytest.mark.parametrize("element", [POLE_RIGHT, MINUS_MASS, MINUS_SPRING, DOUBLE_POLE])
def test_two_ports_that_keep_all_conditions_on_the_axis_are_not_absolutely_stable_for_their_poles(
    element: hs.Effect,
) -> None:
    scene = hs.Scene(hs.environments.mass_spring_damper(k=20, b=4, m="0.5 kg"), (element,))
    m = hs.metrics(scene)
    whole = m.measured.unconditional
    assert (whole.axis, whole.poles, whole.holds) == (True, False, False)
    assert m["absolute stability"].verdict.endswith("poles break those on the poles")
    assert passivity(hs.Scene(hs.environments.mass_spring_damper(b=1), (element,))).holds is False


def test_a_damped_device_is_absolutely_stable() -> None:
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 2), (hs.effects.shunt(m="0.2 kg", b="0.5 N*s/m"),))
    m = hs.metrics(scene)
    assert m.measured.unconditional.holds is True
    assert m["absolute stability"].verdict == (
        "absolutely stable: with every passive hand and every passive environment"
    )


def test_conditions_that_fail_above_the_band_alone_are_not_absolute_stability() -> None:
    element = hs.effects.shunt(Z="s + s^3/100")
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 2), (element,), (0, 5))
    m = hs.metrics(scene)  # the environment's damper is behind it: Im B/D = omega - omega^3/100
    assert m.measured.unconditional.axis is False
    assert m["absolute stability"].verdict.endswith("hold on the whole band, but fail above it")


@given(
    k=st.fractions(0, 500, max_denominator=20),
    b=st.fractions(0, 10, max_denominator=20),
    m=st.fractions(0, 2, max_denominator=20),
    own=st.fractions(0, 10, max_denominator=20),
    tau=st.fractions(Rational(1, 1000), Rational(1, 10), max_denominator=1000),
)
def test_signs_beyond_the_radius_are_those_of_values(
    k: Rational, b: Rational, m: Rational, own: Rational, tau: Rational
) -> None:
    """A late object beside a damper: Im = omega (own + b cos) - (k - m omega^2) sin, by NumPy, far out."""
    k, b, m, own, tau = (Rational(x.numerator, x.denominator) for x in (k, b, m, own, tau))
    H = (m * s**2 + b * s + k) * exp(-s * tau) + own * s
    ring = Ring.of([H])
    found = far(on_axis(ring.convert(H)).raw_imag)
    start = float(found.radius)
    omega = np.linspace(start, start + 40 * np.pi / float(tau), 2001)[1:] + (
        1e5 / float(tau) if found.sense is Sense.BOTH else 0
    )
    angle = omega * float(tau)
    values = omega * (float(own) + float(b) * np.cos(angle)) - (float(k) - float(m) * omega**2) * np.sin(angle)
    slack = 1e-9 * np.abs(values).max()
    if found.sense is Sense.POSITIVE:
        assert values.min() >= -slack
    elif found.sense is Sense.BOTH:
        assert values.min() < 0 < values.max()
    else:
        assert found.sense is Sense.UNKNOWN
        assert own == b or not any((k, b, m, own))


def test_poles_of_delayed_dynamics_are_judged() -> None:
    def of(Z: object) -> bool | None:
        F = s * Z  # type: ignore[operator]
        return poles_allow(Ring.of([F]).convert(F).reduced())

    assert of(1 / (s + exp(-s))) is True
    assert of(1 / (s + 2 * exp(-s))) is False  # a pair on the right, as 2 > pi/2
    assert of(Integer(1) / s + s) is True


LATE_SPRING = hs.environments.mass_spring_damper(k=5000)
"""Behind 50 ms and a light device: its damping outweighs the spring above half a million rad/s, after thousands of turns."""


def light(b: float) -> hs.Scene:
    """The device stands beside the hand, the delay behind it."""
    return hs.Scene(LATE_SPRING, (hs.effects.delay("50 ms"), hs.effects.shunt(m="0.01", b=Rational(str(b)))))


def test_where_a_sign_settles_only_after_thousands_of_turns_the_first_two_are_told_and_that_it_was_not_looked_further() -> (
    None
):
    found = hs.stability(light(0.01))
    p = found.every_passive_hand.passivity
    assert p is not None
    assert (p.beyond, p.holds, p.active_from) == (Beyond.LATE, False, None)
    assert len(p.chart.points) < 10
    omega = np.linspace(1e-3, float(p.high), 20_001)
    inside = np.any([(float(x.low.omega) < omega) & (omega < float(x.high.omega)) for x in p.active], axis=0)
    settled = imaginary(light(0.01), omega) < 0
    assert (inside == settled).mean() > 0.999  # but at the ends
    row = found.to_dict()["every_passive_hand"]
    assert row["not_looked_at_beyond"] == pytest.approx(8 * np.pi / 0.1)
    assert "active_again_beyond" not in row
    assert float(p.damping.value) == pytest.approx(5000 * 0.05 - 0.01)
    assert "it was not looked at" in " ".join(str(found).split())
    assert "signs where they were looked at decided" in " ".join(str(found).split())
    assert "it was not looked at" in " ".join(str(hs.evaluate(light(0.01))).split())


def test_a_sign_that_settles_late_below_0_is_told_from_there_on() -> None:
    scene = light(-0.01)
    p = passivity(scene)
    assert p.active_from is not None
    assert (p.beyond, p.holds, p.is_active) == (Beyond.LATE, False, True)
    settled = float(p.active_from)
    assert 5e5 <= settled < 1e8
    assert (imaginary(scene, np.linspace(settled, 10 * settled, 100_001)) < 0).all()
    assert p.row()["active"][-1] == [settled, None]
    assert settled == 2**19
    assert "everywhere above 524290 rad/s (from 251.33 rad/s to there it was not looked at)" in " ".join(
        str(hs.stability(scene)).split()
    )


def test_some_hundred_turns_are_looked_at_one_by_one() -> None:
    scene = light(1)
    p = passivity(scene)
    assert p.beyond is Beyond.NEVER
    assert len(p.active) == pytest.approx(5000 * 0.05 / (2 * np.pi), abs=1)


@pytest.mark.parametrize("beyond", Beyond)
def test_a_display_stays_active_where_its_sign_far_out_is_negative_or_comes_back_and_late_from_where_it_settles(
    beyond: Beyond,
) -> None:
    """Of a spring and damper, which are active nowhere: with what is said of frequencies beyond the chart in their place."""
    plain = passivity(hs.Scene(hs.environments.kelvin_voigt(100, 1)))
    assert (plain.active, plain.is_active, plain.beyond, plain.holds) == ((), False, Beyond.NEVER, True)
    for sense in Sense:
        found = replace(plain, beyond=beyond, settled=Far(sense, Integer(70)))
        late = beyond is Beyond.LATE and sense is Sense.NEGATIVE
        stays = late or beyond in (Beyond.ALWAYS, Beyond.AGAIN)
        assert (found.stays_active, found.is_active) == (stays, stays)
        assert found.active_from == (70 if late else None)
        assert not stays or found.holds is False
        if beyond is not Beyond.ALWAYS:  # which is active up to the end of the chart
            assert found.row()["active"] == ([[70.0, None]] if late else [])
            assert found.row()["beyond"] == beyond.value
