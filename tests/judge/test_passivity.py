"""Whether every passive hand may hold a display: against scans far beyond the band, sums of known parts, and Colgate and Schenkel's condition."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Expr, Integer, Rational, exp, lambdify, pi, sqrt
from windings import winding

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.colgate import SampledPassivity, sampled_passivity
from haptisym.judge.passivity import (
    Beyond,
    has_advance,
    has_no_pole_right,
    is_positive_real_by_signs,
    passivity,
    poles_allow,
)
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import Ring, on_axis
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import RootChain
from haptisym.verbs.stability.held import held

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


@pytest.mark.dear("position-force-teleoperation", "sampled-wall")
@pytest.mark.few(3)
@pytest.mark.parametrize("name", ACTIVE_ABOVE_THE_BAND)
def test_activity_just_above_the_band_is_found(name: str) -> None:
    scene = hs.load_scene(name)
    found = passivity(scene)
    first = float(found.active[0].low.omega)
    assert first == pytest.approx(ACTIVE_ABOVE_THE_BAND[name], rel=2e-3)
    assert first > float(scene.band[1])
    assert found.holds is False
    assert hs.evaluate(scene).outside_model == ()
    assert "not passive" in " ".join(hs.metrics(scene)["passivity"].verdict.split())


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


GRID = np.concatenate([np.logspace(-4, 7, 20_000), np.linspace(0.01, 400, 20_000)])


def display(draw: random.Random) -> hs.Scene:
    def some(low: int = 1, high: int = 50) -> Rational:
        return Rational(draw.randint(low, high), draw.choice([1, 2, 5]))

    environment = draw.choice(
        [
            environments.kelvin_voigt(some(), some()),
            environments.zener(some(), some(), some()),
            environments.mass_spring_damper(some(), some(), some()),
        ]
    )
    listed = [
        effects.first_order_lag(some(5, 90)), effects.second_order_lowpass(some(5, 90), Rational(draw.randint(1, 9), 5)), effects.shunt(m=some(), b=some(), k=some()),
        effects.shunt(b=-some()), effects.compliance(k=some(), b=some()), effects.series("1 + 1/(s + 7)"),
    ]  # fmt: skip
    return hs.Scene(environment, tuple(draw.sample(listed, draw.randint(1, 2))))


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(24))
def test_what_is_said_of_a_display_is_what_samples_of_its_energy_show(seed: int) -> None:
    own = display(random.Random(seed))
    found = passivity(own)
    with np.errstate(all="ignore"):
        imag = np.imag(lambdify(s, own.distortion().perc.expression())(1j * GRID))
    inside = float(found.high) >= GRID
    told = np.zeros(GRID.shape, bool)
    edge = np.zeros(GRID.shape, bool)
    for x in found.active:
        low, high = float(x.low.omega), float(x.high.omega)
        told |= (low < GRID) & (high > GRID)
        edge |= (abs(GRID - low) < 1e-3 * (1 + low)) | (abs(GRID - high) < 1e-3 * (1 + high))
    sure = inside & ~edge & (abs(imag) > 1e-9 * GRID)
    assert (told == (imag < 0))[sure].all()
    far = imag[float(found.high) * 1.001 < GRID]
    assert {Beyond.NEVER: (far >= 0).all(), Beyond.ALWAYS: (far < 0).all()}[found.beyond]
    assert found.is_active == bool((imag < -1e-9 * GRID).any())
    rate = -imag / GRID
    needed = found.damping
    if needed is None:
        assert found.is_unbounded or rate[GRID > 1e5].max() >= rate.max() * 0.99
    else:
        assert not found.is_unbounded
        assert abs(float(needed.value) - max(rate.max(), 0)) < 1e-3 * (1 + float(needed.value))
        if needed.omega is not None and float(needed.value) > 0:
            at = float(needed.omega) or 1e-6
            value = -np.imag(complex(lambdify(s, own.distortion().perc.expression())(1j * at))) / at
            assert abs(value - float(needed.value)) < 1e-6 * (1 + abs(value))
    most = found.most_given
    assert most is not None
    assert abs(float(most.value) - (-imag[inside]).max()) < 1e-2 * (1 + abs(float(most.value)))
    assert found.holds is not True or (imag > -1e-9 * GRID).all()


@pytest.mark.dear("organ-tissue-1.46113193-86.7188", "position-force-teleoperation-24.23-99.88")
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


def test_a_late_display_with_a_pole_after_the_first_turn_has_no_damping_that_makes_up_for_it() -> None:
    """H = 40000 exp(-s)/(s^2 + 400): -Im H/omega = 40000 sin omega/(omega (400 - omega^2)) has no bound at 20 rad/s."""
    resonant = hs.interop.environment(([40000], [1, 0, 400]))
    assert passivity(hs.Scene(resonant, (effects.delay("1 s"),), (0, 15))).damping is None


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
    found = asymptotic_sign(on_axis(ring.convert(H)).raw_imag)
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


LATE_SPRING = hs.environments.mass_spring_damper(k=5000)
"""Behind 50 ms and a light device: its damping outweighs the spring above half a million rad/s, after thousands of turns."""


def light(b: float) -> hs.Scene:
    """The device stands beside the hand, the delay behind it."""
    return hs.Scene(LATE_SPRING, (hs.effects.delay("50 ms"), hs.effects.shunt(m="0.01", b=Rational(str(b)))))


def test_where_a_sign_settles_only_after_thousands_of_turns_the_first_two_are_told_and_that_it_was_not_looked_further() -> (
    None
):
    p = passivity(light(0.01))
    assert (p.beyond, p.holds, p.active_from) == (Beyond.LATE, False, None)
    omega = np.linspace(1e-3, float(p.high), 20_001)
    inside = np.any([(float(x.low.omega) < omega) & (omega < float(x.high.omega)) for x in p.active], axis=0)
    assert (inside == (imaginary(light(0.01), omega) < 0)).mean() > 0.999  # but at the ends
    row = hs.stability(light(0.01)).to_dict()["every_passive_hand"]
    assert row["not_looked_at_beyond"] == pytest.approx(8 * np.pi / 0.1)
    assert float(p.damping.value) == pytest.approx(5000 * 0.05 - 0.01)


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


def test_what_was_not_looked_at_may_be_active_and_need_damping() -> None:
    """H = exp(-s/20) + Z: Im Z/omega = 1e-5 + 0.1/(1 + omega^2/1e4) hides the spring's activity up to some 1,000 rad/s, and no further."""
    hidden = effects.shunt(Z="0.00001*s + 0.1*s/(1 + 0.01*s)")
    scene = hs.Scene(hs.environments.mass_spring_damper(k=1), (effects.delay("50 ms"), hidden), (0, 100))
    p = passivity(scene)
    assert (p.beyond, p.active, p.holds) == (Beyond.LATE, (), None)
    with mpmath.workdps(30):
        omega = 65 * mpmath.pi / mpmath.mpf("0.1")  # sin(omega/20) = 1
        z = 1j * omega
        H = mpmath.exp(-z / 20) + z / mpmath.mpf(10) ** 5 + z / 10 / (1 + z / 100)
        assert -mpmath.im(H) / omega > 2e-4
    assert p.damping is None
    assert not p.is_nowhere_active
    row = hs.stability(scene).to_dict()["every_passive_hand"]
    assert (row["damping"], row["digits"]) == (None, None)


def test_a_passive_display_needs_no_damping_and_dissipates_unless_it_has_no_losses_at_one_frequency() -> None:
    lossy, lossless = (hs.environments.mass_spring_damper(m=1, b=b, k=10) for b in (2, 0))
    # Z = (s^2 + 1)/(s^2 + s + 1) has Re Z = (1 - omega^2)^2/((1 - omega^2)^2 + omega^2) >= 0, and 0 at omega = 1.
    notch = hs.interop.environment(([1, 0, 1, 0], [1, 1, 1]))
    omega = np.linspace(0.01, 20, 2001)
    for felt, dissipates in ((lossy, True), (lossless, False), (notch, False)):
        scene = hs.Scene(felt)
        p = passivity(scene)
        assert (p.holds, p.is_nowhere_active, p.dissipates) == (True, True, dissipates)
        assert imaginary(scene, omega).min() >= -1e-12
        assert float(p.damping.value) == 0


@pytest.mark.parametrize(("scene", "power"), [("a delayed mass", 1), ("behind a spring", 0)])
def test_a_supremum_is_called_unbounded_where_it_grows_along_a_sequence_of_frequencies(scene: str, power: int) -> None:
    """-Im H/omega of a delayed mass is -m omega sin(omega tau); of one in series with a spring it is bounded by 2 k/omega."""
    late = (effects.delay("20 ms"), *([effects.compliance(k=300)] if power == 0 else []))
    displayed = hs.Scene(hs.environments.mass_spring_damper(m=2), late)
    p = passivity(displayed)
    assert p.is_active
    omega = (2 * np.pi * np.arange(100, 10_000, 900)[:, None] + np.linspace(0, 2 * np.pi, 400)) / 0.02
    rows = -imaginary(displayed, omega.ravel()).reshape(omega.shape) / omega
    largest = rows.max(axis=1)
    assert p.is_unbounded == (power == 1)
    if power:
        assert (np.diff(largest) > 0).all()
        assert largest[-1] / largest[0] == pytest.approx(omega[-1, 0] / omega[0, 0], rel=0.02)


def test_some_hundred_turns_are_looked_at_one_by_one() -> None:
    scene = light(1)
    p = passivity(scene)
    assert p.beyond is Beyond.NEVER
    assert len(p.active) == pytest.approx(5000 * 0.05 / (2 * np.pi), abs=1)


# --- poles -----------------------------------------------------------------------------------------------------------


ALLOWED: tuple[Expr, ...] = (
    Integer(0) * s, Integer(5) + 0 * s, 3 * s, 2 * s**2, s**2 + s + 1, s**2 / (s**2 + 4) * 3, 3 * s / (s + 2), s**2 + 5 * s**2 / (s**2 + 9),
    2 * s**2 / (s**2 + 4) + s**2 / (s**2 + 9) + 7, s**2 * (s**2 + 4) / ((s**2 + 1) * (s**2 + 9)) * 2, s * sqrt(s), sqrt(s) * 3, pi * s**2 + 1,
    s**2 * 2 + s * exp(-s), 3 + exp(-s), s**2 / (s**2 + pi**2),
)  # fmt: skip

FORBIDDEN: dict[str, tuple[Expr, ...]] = {
    "to the right": (s / (s - 1), s**2 / (s - 1) / (s + 1), s / (s**2 - s + 4), 1 / (s - 3) + 1, s / ((s - 1) * (s + 1) ** 2)),
    "at 0, of F": (1 / s + 0 * s, 1 / s**2, -1 / s, 1 / (s * (s + 1)), (s + 1) / (s**2 * (s + 3))),
    "at 0, of F/s, with a residue below 0": (-1 + 0 * s, s - 2, (s - 1) / (s + 1), -2 + exp(-s), 3 * s**2 - Rational(1, 10**9)),
    "twice on the axis": (s**2 / (s**2 + 4) ** 2, s**3 / (s**2 + 1) ** 2, s**2 * (1 + s) / (s**2 + 9) ** 2),
    "on the axis, with a residue below 0": (-(s**2) / (s**2 + Rational(1, 4)), 3 - s**2 / (s**2 + 5), 2 * s**2 / (s**2 + 1) - s**2 / (s**2 + 30),-(s**2) / (s**2 + 4), 9 + 2 * s**2 / (s**2 + 4) - s**2 / (s**2 + 9), 1 + s**2 - 2 * s**2 / (s**2 + 1)),
    "on the axis, with a residue that is not real": (s / (s**2 + 4), -s / (s**2 + 4), s + s**2 / (s**2 + 4) + s / (s**2 + 4)),
    "far out": (s**3, -(s**2), s**4, 1 - s**2 / 1000, s**2 * sqrt(s), 5 + 3 * s**3 / (s + 1) - 4 * s**2, s**4 / (s + 1)),
}  # fmt: skip


def allowed(x: Expr) -> bool | None:
    x = x.together()
    return poles_allow(Ring.of([x]).convert(x).reduced())


def test_simple_poles_with_positive_residues_are_allowed_and_no_others() -> None:
    """Springs, dampers, masses, and resonators r s^2/(s^2 + a^2): the residues of F/s are r/2 there."""
    assert [x for x in ALLOWED if allowed(x) is not True] == []
    assert [x for group in FORBIDDEN.values() for x in group if allowed(x) is not False] == []
    delayed = {
        1 / (s + exp(-s)): True,
        1 / (s + 2 * exp(-s)): False,
        Integer(1) / s + s: True,
    }  # a pair on the right, as 2 > pi/2
    assert [allowed(s * x) for x in delayed] == list(delayed.values())


def test_a_display_that_answers_before_it_is_moved_is_not_passive_though_its_force_takes_energy_at_all_frequencies() -> (
    None
):
    """H_perc = 100 exp(s/100) + 6 s: Im H_perc >= 6 omega - 100 sin(omega/100) > 0, but a passive hand has a root far to the right."""
    early = environments.mass_spring_damper(k=100), (effects.admittance_display(P="1", tau="10 ms"), effects.shunt(b=6))
    found = passivity(hs.Scene(early[0], early[1], (0, 30)))
    assert found.is_nowhere_active
    assert (found.holds, found.poles_allow) == (False, False)

    def coupled(s: mpmath.mpc) -> mpmath.mpc:
        return s**2 / 2 + 6 * s + 100 + 100 * mpmath.exp(s / 100) + 6 * s

    assert mpmath.findroot(coupled, mpmath.mpc(1200, 5600)).real > 100


@pytest.mark.dear("-5")
@pytest.mark.parametrize("b", [5, -5])
def test_a_band_of_very_many_turns_that_reaches_where_the_sign_settles_leaves_nothing_open(b: int) -> None:
    """(6 + s) exp(-2000 s) + b s on 3 rad/s, 955 turns: Im H_perc has the sign of b from about 1.23 rad/s on."""
    found = passivity(hs.Scene(environments.kelvin_voigt(k=6, b=1), (effects.delay(2000), effects.shunt(b=b)), (0, 3)))
    assert found.beyond is (Beyond.NEVER if b > 0 else Beyond.ALWAYS)
    [*_, (low, high)] = found.row()["active"]
    omega = np.linspace(1.1, 3, 400_001)
    active = (6 + 1j * omega) * np.exp(-2000j * omega) + b * 1j * omega
    last = omega[active.imag < 0].max() if b > 0 else omega[active.imag > 0].max()
    assert last == pytest.approx(high if b > 0 else low, abs=1e-5)
    assert (high is None) is (b < 0)


def test_poles_to_the_right_are_told_from_those_on_the_axis() -> None:
    for x, clear in (
        (1 / (s**2 + 4), True), (1 / s**3, True), (1 / (s + 1), True), (s**5, True), (1 / (s**2 - s + 4), False), (1 / (s - 1), False),
        (1 / (s**2 + 4) / (s - 3), False), (1 / (2 + exp(-s)), True), (1 / (1 + s + exp(-s) / 2), True),
    ):  # fmt: skip
        assert has_no_pole_right(Ring.of([x]).convert(x.together()).reduced()) is clear, x


POLE_RIGHT = hs.effects.shunt(Z="10*s*s/(s - 2)")
"""Z/s = 10 s/(s - 2): Re = 10 omega^2/(omega^2 + 4) >= 0 at every frequency, and a pole at s = 2."""

MINUS_MASS = hs.effects.shunt(m="-1 kg")

MINUS_SPRING = hs.effects.shunt(Z="-30")

DOUBLE_POLE = hs.effects.shunt(Z="-5/s")


@pytest.mark.parametrize("element", [POLE_RIGHT, MINUS_MASS, MINUS_SPRING, DOUBLE_POLE])
def test_two_ports_that_keep_all_conditions_on_the_axis_are_not_absolutely_stable_for_their_poles(
    element: hs.Effect,
) -> None:
    scene = hs.Scene(environments.mass_spring_damper(k=20, b=4, m="0.5 kg"), (element,))
    whole = hs.metrics(scene).measured.unconditional
    assert (whole.axis, whole.poles, whole.holds) == (True, False, False)
    assert passivity(hs.Scene(environments.mass_spring_damper(b=1), (element,))).holds is False


def test_a_damped_device_is_absolutely_stable_and_one_that_is_active_above_the_band_is_not() -> None:
    damped, above = (
        effects.shunt(m="0.2 kg", b="0.5 N*s/m"),
        effects.shunt(Z="s + s^3/100"),
    )  # Im B/D = omega - omega^3/100
    for element, axis in ((damped, True), (above, False)):
        whole = hs.metrics(hs.Scene(environments.kelvin_voigt(100, 2), (element,), (0, 5))).measured.unconditional
        assert (whole.axis, whole.holds) == (axis, axis)


# --- parts that only take energy -------------------------------------------------------------------------------------


TAKES: dict[Expr, bool] = {
    Integer(3) + 0 * s: True, s**2: True, 2 * s**2 + 3 * s + 5: True, s / 2 + 3: True, s**2 + s / (s + 1): True, s / (s + 1): True, sqrt(s): True,
    (s + 1) / (s + 2): True, (s**2 + 2 * s + 1) / (s**2 + s + 1) * s: True, s - 1: False, 1 - s: False, -s - 1: False, s**3: False,
    s**4: False, s**4 + s: False, (s + 2) / (s + 1): False, 1 / s: False, 1 / (s**2 + 1): False, (s + 1) / (s - 2): False, 2 * s + s * exp(-s): False,
    1 / (1 + sqrt(s)): False, s / (s**3 + s**2 + s + 1): False,
}  # fmt: skip


def test_what_takes_energy_by_signs_alone_is_told_and_of_all_else_nothing() -> None:
    """Im H >= 0, no pole in Re s >= 0 nor at 0, and no faster than s^2: False where one of these fails or signs do not show it."""
    for x, takes in TAKES.items():
        assert is_positive_real_by_signs(x.together()) is takes, x


LINK = hs.effects.wave_variables(10, "20 ms", name="link")

SECOND = hs.effects.wave_variables(10, "20 ms", name="second")

DEVICE = hs.effects.shunt(m=1, b=1, name="device")

TORSION = hs.effects.compliance(k=5000)

OBJECT = hs.environments.mass_spring_damper("0.5 kg", "4 N*s/m", "300 N/m")

HOLD = hs.effects.zero_order_hold("1 ms")


@pytest.mark.dear("chain1", "chain2")
@pytest.mark.parametrize("chain", [(LINK,), (LINK, DEVICE), (LINK, DEVICE, SECOND), (LINK, TORSION)])
def test_what_is_made_of_passive_parts_suits_every_passive_hand(chain: tuple[hs.Effect, ...]) -> None:
    scene = hs.Scene(OBJECT, chain)
    found = passivity(scene)
    assert found.holds is True
    assert hs.evaluate(scene).stable is True
    s = 1j * np.geomspace(1e-2, 1e4, 20_001)  # the chain multiplied out in floats
    F, X = 0.5 * s**2 + 4 * s + 300, np.ones_like(s)
    for effect in chain:
        if effect.model == "wave-variables":
            c, t = np.cosh(s * 0.02), np.sinh(s * 0.02)
            F, X = c * F + 10 * s * t * X, t / (10 * s) * F + c * X
        elif effect.model == "shunt":
            F = F + (s**2 + s) * X
        else:
            X = X + F / 5000
    assert (np.imag(F / X) > -1e-6 * np.abs(F / X)).all()


def test_an_active_part_proves_nothing_by_parts() -> None:
    for felt, chain in (
        (OBJECT, (LINK, effects.shunt(m=-2))),
        (OBJECT, (effects.delay("1 ms"),)),
        (environments.expression("-s"), (DEVICE,)),
    ):
        assert not passivity(hs.Scene(felt, chain)).has_passive_parts


@pytest.mark.parametrize("own", [{"k": 100}, {"m": 2}, {"m": "1/2", "k": 40}])
@pytest.mark.parametrize("behind", [(), (TORSION,)])
def test_a_lossless_display_is_not_stable_as_its_poles_lie_on_the_axis(
    own: dict[str, Any], behind: tuple[hs.Effect, ...]
) -> None:
    """A spring behind a line without losses rings for ever; where, it is seen by the sign of a real function."""
    scene = hs.Scene(hs.environments.mass_spring_damper(**own), (LINK, *behind))
    assert passivity(scene).holds is True
    omega = np.linspace(1e-3, 60 * np.pi, 100_001)
    F, X = (lambda m=0, k=0: float(Rational(k)) - float(Rational(m)) * omega**2)(**own), np.ones_like(omega)
    c, t = np.cos(0.02 * omega), np.sin(0.02 * omega)
    F, X = c * F - 10 * omega * t * X, t / (10 * omega) * F + c * X
    X = X + F / 5000 if behind else X
    found = hs.stability(scene)
    assert ((X[1:] * X[:-1] < 0) & (np.abs(F[1:]) > 0)).any()
    assert (found.imposed.stable, found.imposed.unstable, found.certified) == (False, None, True)


@pytest.mark.parametrize("k", [0, 20])
@pytest.mark.parametrize("alpha", ["1/2", "0.3", "2/3"])
def test_a_spring_pot_behind_a_line_is_stable_as_it_damps_at_every_frequency(alpha: str, k: int) -> None:
    scene = hs.Scene(hs.environments.spring_pot(80, alpha, k=k), (LINK,))
    found = hs.stability(scene).imposed
    assert (found.stable, found.chain) == (True, RootChain.NEAR)
    order = float(Rational(alpha))

    def poles(s: Any, lib: Any = np) -> Any:
        return 10 * s * lib.cosh(0.02 * s) + (k + 80 * s**order) * lib.sinh(0.02 * s)

    assert winding(lambda s: poles(s + 1e-6) / (s + 1e-6), 1000.0) == 0
    for n in range(8):  # of the chain, near the zeros of cosh
        near = mpmath.findroot(lambda s: poles(s, mpmath), mpmath.mpc(-1, (n + 0.5) * np.pi / 0.02))
        assert near.real < 0


def test_what_damps_nowhere_or_gives_energy_back_is_not_called_stable_by_its_parts() -> None:
    assert hs.stability(hs.Scene(environments.expression("100"), (LINK,))).imposed.stable is False
    gives = hs.Scene(environments.spring_pot(80, "1/2"), (LINK, effects.delay("20 ms")))
    assert hs.stability(gives).imposed.stable is not True


def test_a_link_may_turn_a_resonance_without_damping_round_to_the_hand() -> None:
    """At 0.5 Hz the environment has a force without motion, and the link of 1 s, half a period, leaves it one: H_perc has a pole there."""
    values = {"b": "1 N*s/m", "k": "1 N/m", "w": "0.5 Hz"}
    resonance = environments.expression("b*s + k*s^2/(s^2 + w^2)", parameters=values)
    scene = hs.Scene(resonance, (effects.wave_variables(2, "1 s"),), ("0 Hz", "0.3 Hz"))

    def perceived(z: Any) -> Any:
        H, sinh, cosh = z + z**2 / (z**2 + mpmath.pi**2), mpmath.sinh(z), mpmath.cosh(z)
        return (cosh * H + 2 * z * sinh) / (sinh / (2 * z) * H + cosh)

    near = [abs(perceived(1j * mpmath.pi + d)) * d for d in (1e-3, 1e-4)]
    assert near == [pytest.approx(1.2568, rel=2e-3)] * 2
    assert hs.evaluate(scene).stable is not True
    assert hs.stability(scene).imposed.stable is not True


def test_the_shipped_wave_variable_link_is_decided() -> None:
    found = hs.stability("wave-variable-link", "light-touch")
    assert (found.imposed.stable, found.imposed.unstable, found.every_passive_hand.holds) == (True, 0, True)
    assert found.certified
    assert found.held[0].stable is False


@pytest.mark.few(1)
@pytest.mark.parametrize("order", ["0.23", "0.5", "1/3"])
def test_spring_pots_of_any_order_are_judged(order: str) -> None:
    """k s^alpha takes energy at every frequency; behind a filter of second order it gives some back."""
    pot: Any = hs.environments.spring_pot(100, order)
    found = hs.stability(hs.Scene(pot, (hs.effects.second_order_lowpass(80, 0.5),)))
    assert found.imposed.stable is True
    assert found.every_passive_hand.holds is False
    assert passivity(hs.Scene(pot, (hs.effects.shunt(m=1, b=1),))).holds is True


# --- clocks: Colgate and Schenkel's condition ------------------------------------------------------------------------


@pytest.mark.parametrize("late", [0, 1, 2])
def test_a_clock_that_samples_the_force_of_a_spring_is_colgate_and_schenkel(late: int) -> None:
    """b > K (T/2 + d T): 100 N/m and 1 ms, d samples late."""
    delay = (hs.effects.delay(f"{late} ms"),) if late else ()
    needed = Rational(100) * (Rational(1, 2) + late) / 1000
    for share, holds in ((Rational(101, 100), True), (Rational(99, 100), False)):
        device = hs.effects.shunt(m="0.04 kg", b=needed * share)
        found = passivity(hs.Scene(hs.environments.mass_spring_damper(k=100), (HOLD, *delay, device)))
        assert found.holds is holds
        assert found.sampled is not None
        assert float(found.sampled.needed.value) == pytest.approx(float(needed))  # type: ignore[union-attr]


def test_a_clock_that_gives_energy_to_imposed_motion_does_not_suit_every_passive_hand() -> None:
    """A heavy hand whose spring resonates where Im H_perc < 0 is passive, and shakes."""
    found = hs.stability("sampled-wall")
    assert (found.every_passive_hand.holds, found.certified) == (False, True)
    assert held(hs.load_scene("sampled-wall"), hs.Hand("heavy", m=5, k=5 * 1144**2)).stable is False


def test_what_a_filter_made_in_continuous_time_before_a_clock_stays_open() -> None:
    device = effects.shunt(m="0.04 kg", b="8 N*s/m")
    assert hs.stability(hs.Scene(environments.kelvin_voigt(400, 2), (HOLD, device))).every_passive_hand.holds is None


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(24))
def test_the_damping_that_a_sampled_loop_needs_is_the_largest_right_hand_side(seed: int) -> None:
    draw = random.Random(seed)
    k, b = Rational(draw.randint(1, 40), 2), Rational(draw.randint(1, 40), 9)
    T, late = Rational(1, draw.choice([5, 20, 100])), draw.randint(0, 2)
    method = draw.choice(["backward-difference", "tustin"])
    device = Rational(draw.randint(1, 200), 10)
    own = hs.Scene(
        environments.kelvin_voigt(k, b), (effects.sampled_loop(T, method, late), effects.shunt(m=1, b=device))
    )
    found = sampled_passivity(own)
    assert found is not None
    theta = np.linspace(1e-4, np.pi, 200_001)
    z = np.exp(1j * theta)
    rate = (z - 1) / (float(T) * z) if method == "backward-difference" else 2 / float(T) * (z - 1) / (z + 1 + 1e-18)
    side = float(T) / 2 * np.real((1 - 1 / z) * (float(k) + float(b) * rate) * z**-late) / (1 - np.cos(theta))
    assert found.is_settled == (method == "backward-difference")
    if method == "tustin":
        assert found.passive in (None, False)
        assert "unit circle" in found.row(5)["reason"]
        return
    assert found.needed is not None
    assert found.needed.omega is not None
    top = side.max()
    assert abs(float(found.needed.value) - top) < 1e-5 * (1 + abs(top))
    at = float(found.needed.omega)
    assert abs(np.interp(at, theta, side) - top) < 1e-5 * (1 + abs(top))
    assert found.passive == bool(float(device) > top)
    assert found.hand_needed is not None
    assert abs(float(found.hand_needed) - max(top - float(device), 0)) < 1e-5 * (1 + abs(top))
    told = found.row(5)
    assert (told["T"], told["passive"], "reason" in told) == (float(T), found.passive, False)
    assert told["damping_needed"] == float(found.needed.value)


def test_what_gives_energy_to_imposed_motion_forbids_some_hand_unless_images_of_the_samples_come_back_to_the_clock() -> (
    None
):
    """Tustin's rule for a damper has a pole at z = -1, though the right-hand side is K T/2 - B = 0.71 N s/m at all angles."""
    felt, clock = hs.environments.kelvin_voigt(1500, "0.04"), hs.effects.sampled_loop("1 ms", "tustin")
    for b, active in (("0.1", True), ("9", False)):
        device = hs.effects.shunt(m="0.04", b=b)
        found = passivity(hs.Scene(felt, (clock, device)))
        assert found.sampled is not None
        assert found.sampled.needed is not None
        assert (float(found.sampled.needed.value), found.sampled.passive) == (0.71, None)
        assert found.is_active is active
        assert found.holds is (False if active else None)
        yielding = passivity(hs.Scene(felt, (clock, device, hs.effects.compliance(k=10**6, b=1))))
        assert (yielding.is_active, yielding.holds) == (active, None)


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
        effects.compliance(k=1000, b=1), effects.series("2"), effects.delay("1 ms"), effects.shunt(m=-1), effects.shunt(k=-1), effects.shunt(Z="s^3"),
        effects.shunt(Z="1/(s + 1)"), effects.shunt(Z="s - k", parameters={"k": 2}), effects.first_order_lag(50),
    ],
    ids=repr,
)  # fmt: skip
def test_of_anything_else_between_clock_and_hand_nothing_is_said(part: hs.Effect) -> None:
    good = effects.shunt(m="0.5", b=9, k="0.5", name="good")
    for listed in ((part,), (part, good), (good, part)):
        found = wall(*listed)
        assert (found.sides, found.needed, found.passive, found.hand_needed) == (None,) * 4
        assert "other than mass, spring and damper" in found.reason
    assert wall(good).passive is True


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
        soft = hs.Hand("soft", m="0.1", b=50, k=-at_rest / 2)
        assert held(scene, soft).unstable != 0
        return
    assert found.hand_needed is not None
    assert float(found.hand_needed) == pytest.approx(max(damped - float(found.damping), 0), abs=1e-12)
    for _ in range(3):
        b = Rational(float(found.hand_needed) + draw.choice([1e-6, 0.1, 3]))
        hand = hs.Hand("own", m=draw.choice([0, 1, "0.03"]), b=b, k=draw.choice([1, 30, "1e5"]))
        assert held(scene, hand).unstable == 0
        assert found.is_held_by(b, hand.k.value)


def on_clock(k: object, b: object, own: object = 0) -> hs.Scene:
    """A wall on a clock of 4 ms, which asks for k T/2 at every angle, behind a device of 1 kg."""
    felt = environments.expression("k", parameters={"k": k})
    return hs.Scene(felt, (effects.sampled_loop("4 ms", "backward-difference"), effects.shunt(m=1, b=b, k=own)))


def test_what_a_hand_holds_needs_both_damping_and_stiffness() -> None:
    def held_by(k: object, b: object, hands: list[tuple[Any, Any]]) -> list[bool]:
        found = sampled_passivity(on_clock(k, b))
        assert found is not None
        assert found.asks_nothing is (float(Rational(str(k))) < 0)
        return [found.is_held_by(Rational(x), Integer(y)) for x, y in hands]

    assert held_by(500, "0.25", [("0.74", 0), ("0.75", 0), ("0.76", 0), (4, 0)]) == [
        False,
        False,
        True,
        True,
    ]  # K T/2 = 1
    assert held_by(-5, "0.25", [(0, 0), (0, 4), (0, 5), (0, 6)]) == [False, False, False, True]
    assert held_by(-5, "-0.005", [(0, 6), ("0.004", 6), ("0.005", 6), ("0.006", 6)]) == [False, False, False, True]


@pytest.mark.dear("-1")
@pytest.mark.parametrize("b", [-1, Rational(-1, 200)])
def test_a_hand_makes_up_for_the_negative_damping_of_a_device_where_the_clock_asks_for_none(b: Rational) -> None:
    """A wall of -5 N/m asks for -0.01 N s/m: what damps together must only be above 0, so the hand more than -b."""
    scene = on_clock(-5, b, own=6)
    found = hs.stability(scene)
    assert found.every_passive_hand.holds is False
    assert found.to_dict()["every_passive_hand"]["damping"] == -float(b)
    for more, stable in (("0.99", False), ("1.01", True)):
        hand = hs.Hand("own", m=0, b=-b * Rational(more), k=3)
        assert found.every_passive_hand.sampled.is_held_by(hand.b.value, hand.k.value) is stable
    assert held(scene, hs.Hand("own", m=1, b=-b * Rational("1.01"), k=3)).stable is True


def test_without_any_damping_a_motion_may_go_on_between_the_samples() -> None:
    """A mass of 1 on 25 pi^2 swings with 5 pi = pi/T: it may be 0 at each sample, and the controller, which damps else, is blind."""
    felt = environments.expression("k", parameters={"k": -5})
    scene = hs.Scene(felt, (effects.sampled_loop("0.2 s", "backward-difference"), effects.shunt(m=1)))
    found = sampled_passivity(scene)
    assert found is not None
    assert not found.is_held_by(Integer(0), 25 * pi**2 - 1)
    assert found.is_held_by(Rational(1, 10**6), 25 * pi**2 - 1)


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
        assert (span.low.digits(9), span.closed[0]) == (ExactNumber(Rational(low)).digits(9), path != "effects.shunt.b")
        assert (None if span.high is None else float(span.high)) == high


@pytest.mark.parametrize("delays", [(1, 2, 1), (2, 1, 1)])
def test_an_advance_shorter_than_floats_tell_is_one(delays: tuple[int, int, int]) -> None:
    """(exp(-a s) + s exp(-b s))/((s + 1) exp(-c s)): the shorter of a and b is less than c, by 10^-20 s."""
    a, b, c = (1 + Rational(n, 10**20) for n in (delays[0] - 1, delays[1] - 1, 0))
    own = (exp(-(a + 0) * s) + s * exp(-b * s)) / ((s + 1) * exp(-(c + Rational(1, 2 * 10**20)) * s))
    assert has_advance(Ring.of([own]).convert(own).reduced())


def test_powers_of_s_that_cancel_after_all_do_not_deny_passivity() -> None:
    """s^1.5 s^1.5 + s - s^3 is a damper, though s^1.5 s^1.5 and s^3 are other products of variables."""
    damper = hs.Scene(environments.expression("s^1.5"), (effects.series("s^1.5"), effects.shunt(Z="s - s^3")))
    assert passivity(damper).poles_allow is not False
    assert passivity(damper).holds is not False
    steep = hs.Scene(environments.expression("s^1.5"), (effects.series("s^1.5"), effects.shunt(Z="s - 2*s^3")))
    assert passivity(steep).poles_allow is False


def test_metrics_say_that_an_advance_prevents_passivity_where_no_pole_does() -> None:
    """0.5 s + 100 through 7 ms of advance, beside a damper of 4 N s/m."""
    early = effects.admittance_display(P="1", tau="20 ms")
    own = hs.Scene(environments.kelvin_voigt(100, Rational(1, 2)), (early, effects.delay("13 ms"), effects.shunt(b=4)))
    assert (
        hs.metrics(own)["passivity"].verdict == "Im H_perc >= 0 at all frequencies, but an advance prevents passivity"
    )
