"""What a simulation in time gives, against closed forms, against quadratures, and against what physics says beforehand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Annotated, Any

import numpy as np
import pytest
import threadpoolctl
from flint import fmpq, fmpq_mat
from marks import often
from scipy.interpolate import CubicSpline
from strategies import BETWEEN, FELT, Seeded, case
from strategies import scene as told_scene
from sympy import I, Integer, exp, log, tanh

import haptisym as hs
from haptisym import effects, environments
from haptisym.cli import main
from haptisym.kernel.symbols import s
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, effect, environment
from haptisym.model.parameters import Slot
from haptisym.model.quantities import Dimension
from haptisym.model.slots import Stiffness
from haptisym.verbs.simulate.descriptor import StateSpace, state_space
from haptisym.verbs.simulate.fractional import bank_error, rates_and_weights
from haptisym.verbs.simulate.network import SignalSum
from haptisym.verbs.simulate.recordings import Recording
from haptisym.verbs.simulate.threads import one_thread

MSD = environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
SOFT = environments.kelvin_voigt(200, 5)
TELEOPERATOR = {"Mm": "0.5 kg", "Ms": "2 kg", "Bs": "64 N*s/m", "Ks": "400 N/m", "tau": "20 ms"}
MASTER = {"Bm": "16 N*s/m", "Km": "100 N/m"}
CATALOGUE: dict[str, hs.Scene] = {
    "mass-spring-damper": hs.Scene(MSD),
    "kelvin-voigt": hs.Scene(SOFT),
    "maxwell": hs.Scene(environments.maxwell(100, 5)),
    "zener": hs.Scene(environments.zener(200, 300, 6)),
    "prony": hs.Scene(environments.prony(100, [300, 50], [6, 20])),
    "spring-pot": hs.Scene(environments.spring_pot(80, "0.3", 50)),
    "two-mass": hs.Scene(environments.two_mass("0.5", 4, 200, "0.3", 1, 120)),
    "expression": hs.Scene(environments.expression("k*(s + 3)/(s + 20) + b*s", parameters={"k": 100, "b": 2})),
    "first-order-lag": hs.Scene(MSD, (effects.first_order_lag(30),)),
    "second-order-lowpass": hs.Scene(MSD, (effects.second_order_lowpass(40, "0.4"),)),
    "delay": hs.Scene(MSD, (effects.delay("37 ms"),)),
    "pade-delay": hs.Scene(MSD, (effects.pade_delay("37 ms", 3),)),
    "zero-order-hold": hs.Scene(SOFT, (effects.zero_order_hold("30 ms"),)),
    "sampled-loop": hs.Scene(SOFT, (effects.sampled_loop("30 ms", "tustin", 1),)),
    "series": hs.Scene(MSD, (effects.series("(1 + s/50)/(1 + s/5)"),)),
    "shunt": hs.Scene(MSD, (effects.shunt(m="-0.4", b=2),)),
    "compliance": hs.Scene(MSD, (effects.compliance(500, 3),)),
    "coulomb-friction": hs.Scene(MSD, (effects.coulomb_friction("0.5 N", "5 cm"), effects.first_order_lag(30))),
    "admittance-display": hs.Scene(MSD, (effects.admittance_display("400/(s^2 + 30*s + 400)"),)),
    "wave-variables": hs.Scene(MSD, (effects.wave_variables(10, "20 ms"),)),
    "position-force-teleoperator": hs.Scene(SOFT, (effects.position_force_teleoperator(**TELEOPERATOR),)),
    "position-position-teleoperator": hs.Scene(SOFT, (effects.position_position_teleoperator(**TELEOPERATOR, **MASTER),)),
    "four-channel-teleoperator": hs.Scene(SOFT, (effects.four_channel_teleoperator(**TELEOPERATOR, **MASTER),)),
    "two-port": hs.Scene(MSD, (effects.two_port("0.8", "2*s", "0.001/(1 + s/9)", "1"),)),
}  # fmt: skip
"""A scene for each model."""

LOOPS = {
    "a lag behind a cable": (effects.first_order_lag(30), effects.compliance(500, 3)),
    "a delay inside a loop": (effects.second_order_lowpass(60, 1), effects.delay("10 ms"), effects.compliance(2000, 40)),
    "a delay before the filter in a loop": (effects.delay("10 ms"), effects.second_order_lowpass(60, 1), effects.compliance(2000, 40)),
    "two links in a row": (effects.wave_variables(10, "20 ms"), effects.compliance(900, 5), effects.wave_variables(30, "7 ms")),
    "four channels without delay": (effects.four_channel_teleoperator(1, 2, 30, 2, 40, 50),),
    "a delayed force through two derivatives": (effects.delay("20 ms"), effects.series("(1 + s/30)^2/(1 + s/100)^3")),
    "friction through a delay": (effects.coulomb_friction("0.5 N", "5 cm"), effects.delay("37 ms")),
    "a shunt as a formula": (effects.shunt(Z="2*s + 300*s/(s + 5)"),),
    "half a derivative": (effects.series("1/(1 + 0.2*s^0.5)"),),
    "an admittance display before a torsion bar": (effects.compliance(3000, 60), effects.admittance_display("900/(s^2 + 40*s + 900)")),
}  # fmt: skip


def relative(x: hs.simulation.Estimate) -> float:  # type: ignore[name-defined]
    return float(x.difference / abs(x.closed))


def agree(runs: tuple[hs.Simulation, ...], tolerance: float) -> None:
    """The simulation is as close to the closed form as it says itself, and as close as it should."""
    rows = [x for run in runs for x in run.estimates]
    largest = max(abs(x.closed) for x in rows)
    assert rows
    for x in rows:
        assert x.approximate == ""
        assert x.difference <= x.error, x
        assert x.error <= tolerance * largest, x


def test_the_catalogue_has_a_scene_for_every_model() -> None:
    assert set(CATALOGUE) == {*ENVIRONMENTS, *EFFECTS}


@pytest.mark.few(
    "kelvin-voigt",
    "maxwell",
    "first-order-lag",
    "delay",
    "zero-order-hold",
    "wave-variables",
    "position-force-teleoperator",
)
@pytest.mark.parametrize("model", CATALOGUE)
def test_simulation_and_closed_form_agree_for_every_model(model: str) -> None:
    agree(hs.check(CATALOGUE[model], count=3), 1e-7)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", often(LOOPS, lambda name: name not in ("two links in a row", "half a derivative")))
def test_simulation_and_closed_form_agree_where_the_environment_is_in_a_loop(name: str) -> None:
    agree(hs.check(hs.Scene(MSD, LOOPS[name]), count=3), 1e-7)


QUICK = {"fu2019", "delayed-spring", "sidestick", "undamped-resonance", "zener-tissue"}


@pytest.mark.parametrize("name", often(sorted(set(hs.scene_names()) - {"organ-tissue"}), QUICK.__contains__))
def test_simulation_and_closed_form_agree_for_every_shipped_scene(name: str) -> None:
    agree(hs.check(hs.load_scene(name), count=3), 1e-6)


@pytest.mark.slow
def test_a_spring_pot_through_lag_and_delay_agrees_to_a_millionth() -> None:
    agree(hs.check(hs.load_scene("organ-tissue"), count=2), 1e-6)


@pytest.mark.slow
def test_stable_random_scenes_agree_within_their_own_error_estimate() -> None:
    pick, seen, refused = Seeded(7), 0, list[str]()
    while seen < 20:
        scene = told_scene(case(pick, order=5, felt=FELT, between=BETWEEN))
        low = float(scene.band[1]) / 2
        try:
            run = hs.simulate(scene, hs.multisine("1 cm", [low / 2, low]))
        except hs.SceneError as error:
            refused.append(str(error))
            continue
        seen += 1
        agree((run,), 1e-6)
    assert all("not stable" in x or "inner motion" in x or "steps" in x for x in refused), refused


@pytest.mark.parametrize("cut", ["sign", "factor", "swap"])
def test_a_wrong_closed_form_would_be_noticed(cut: str) -> None:
    other = {"sign": -15, "factor": 30, "swap": 18}[cut]
    wrong = hs.Scene(
        environments.expression(f"1.8*s^2 + ({other})*s + 100"), (effects.second_order_lowpass(80, "0.5"),)
    )
    [x] = hs.simulate(hs.load_scene("fu2019"), hs.sine("5 cm", 5)).estimates
    closed = wrong.distortion().compile()(5.0)
    assert abs(x.simulated - complex(closed.perceived_real, closed.perceived_imag)) > 1e3 * x.error


# Physics that is known without any of this


def test_the_force_of_a_lag_on_a_spring_is_the_known_steady_wave() -> None:
    run = hs.simulate(
        hs.Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(20),)), hs.sine("1 cm", 20)
    )
    late = run.time > run.motion.fade + 2  # a quarter turn between resistance and reactance: 1/sqrt(2), 45 degrees late
    wave = np.sin(20 * run.time - np.pi / 4) / np.sqrt(2)
    assert run.force[late] == pytest.approx(wave[late], abs=1e-10)


def test_a_delay_line_repeats_the_force_exactly() -> None:
    plain = hs.simulate(hs.Scene(SOFT), hs.sine("1 cm", 10), duration=8)
    late = hs.simulate(hs.Scene(SOFT, (effects.delay("0.1 s"),)), hs.sine("1 cm", 10), duration=8)
    rest = late.time > 0.2
    was = CubicSpline(plain.time, plain.force)(late.time[rest] - 0.1)
    assert late.force[rest] == pytest.approx(was, abs=1e-4)  # of 2 N: a cubic between nodes
    assert late.force[late.time < 0.1] == pytest.approx(0, abs=1e-15)


def test_a_held_force_is_a_staircase_that_changes_only_on_the_clock() -> None:
    run = hs.simulate(hs.Scene(SOFT, (effects.zero_order_hold("50 ms"),)), hs.sine("1 cm", 10), duration=2)
    level = np.floor(run.time / 0.05).astype(int)
    for n in range(2, 39):
        held = run.force[level == n]
        assert np.ptp(held) == 0.0
        t = n * 0.05
        if t > run.motion.fade:
            assert held[0] == pytest.approx(2 * np.sin(10 * t) + 0.5 * np.cos(10 * t), abs=1e-9)


def test_friction_on_a_prescribed_motion_switches_where_the_velocity_changes_sign() -> None:
    run = hs.simulate(CATALOGUE["coulomb-friction"], hs.sine("5 cm", 4), duration=6)
    alone = hs.simulate(hs.Scene(MSD, (effects.first_order_lag(30),)), hs.sine("5 cm", 4), duration=6)
    shared = hs.simulate(hs.Scene(SOFT, (effects.coulomb_friction("0.5 N", "5 cm"),)), hs.sine("5 cm", 4), duration=6)
    bare = 200 * 0.05 * np.sin(4 * shared.time) + 5 * 0.2 * np.cos(4 * shared.time)
    late = shared.time > shared.motion.fade
    assert shared.force[late] - bare[late] == pytest.approx(0.5 * np.sign(np.cos(4 * shared.time[late])), abs=1e-9)
    assert np.abs(run.force).max() > np.abs(alone.force).max()


def spring_friction_loop(x: np.ndarray, k: float, limit: float) -> np.ndarray:
    """A spring in a row with dry friction (Jenkins' element): the force after each small step, by return mapping."""
    force = np.zeros_like(x)
    for i in range(1, len(x)):
        force[i] = np.clip(force[i - 1] + k * (x[i] - x[i - 1]), -limit, limit)
    return force


@pytest.mark.slow
def test_friction_behind_a_spring_sticks_and_slips_as_jenkins_element() -> None:
    tiny = environments.mass_spring_damper(k="1e-6")
    scene = hs.Scene(tiny, (effects.coulomb_friction("1 N", "5 cm"), effects.compliance(100)))
    run = hs.simulate(scene, hs.sine("5 cm", 2), duration=12)
    grid = np.linspace(0, run.time[-1], 200_001)
    known = spring_friction_loop(run.motion.derivatives(grid, 0)[0], 100, 1.0)
    assert run.force == pytest.approx(np.interp(run.time, grid, known), abs=2e-4)
    assert (np.abs(run.force) > 1 - 1e-6).any()
    assert (np.abs(run.force) < 0.9).any()


def test_a_stuck_mass_does_not_move_and_then_slips() -> None:
    scene = hs.Scene(
        environments.mass_spring_damper(m="0.5", b=1, k=20),
        (effects.coulomb_friction("1 N", "5 cm"), effects.compliance(200, 1)),
    )
    run = hs.simulate(scene, hs.sine("2 cm", 3), duration=14)
    speed = np.gradient(run.environment_displacement, run.time)
    late = run.time > run.motion.fade
    still = np.abs(speed[late]) < 1e-9
    assert 0.05 < still.mean() < 0.95
    friction = (run.force - run.environment_force)[late]
    assert np.abs(friction[still]).max() <= 1 + 1e-9  # what friction holds while it sticks
    moving = np.abs(speed[late]) > 1e-3
    assert friction[moving] == pytest.approx(np.sign(speed[late][moving]), abs=1e-9)
    # the mass obeys Newton: spring, damper and inertia of the environment are its force
    x, t = run.environment_displacement, run.time
    assert run.environment_force[late][still] == pytest.approx(20 * x[late][still], abs=1e-6)
    assert t.size > 500


def test_the_describing_functions_error_is_shown_where_the_friction_moves_otherwise_than_the_hand() -> None:
    scene = hs.Scene(MSD, (effects.coulomb_friction("0.5 N", "5 cm"), effects.compliance(300, 5)))
    [x] = hs.simulate(scene, hs.sine("5 cm", 5)).estimates
    assert "does not move as the hand" in x.approximate
    assert x.agrees is None
    assert 1e-4 < relative(x) < 0.2


@pytest.mark.slow
def test_a_describing_function_for_another_amplitude_is_said_to_be_so() -> None:
    [x] = hs.simulate(CATALOGUE["coulomb-friction"], hs.sine("2 cm", 4)).estimates
    assert "amplitude of 0.05" in x.approximate
    # the true one is j 4 F/(pi A) with the amplitude of the hand, behind the same lag
    more = 4 * 0.5 / np.pi * (1 / 0.02 - 1 / 0.05) / abs(1 + 4j / 30)
    assert x.difference == pytest.approx(more, rel=1e-7)


def test_a_hold_in_a_loop_is_compared_but_not_called_an_error() -> None:
    scene = hs.Scene(SOFT, (effects.zero_order_hold("20 ms"), effects.compliance(900, 30)))
    [x] = hs.simulate(scene, hs.sine("1 cm", 8)).estimates
    assert "base band" in x.approximate
    assert 0 < relative(x) < 0.1


# Quantisation and saturation


def test_a_saturated_spring_gives_the_describing_function_of_saturation() -> None:
    scene, A, limit = hs.Scene(environments.mass_spring_damper(k=100)), 0.05, 2.0
    [x] = hs.simulate(scene, hs.sine(A, 5), extras=[hs.ForceSaturation(f"{limit} N")]).estimates
    d = limit / 100 / A
    gain = 100 * 2 / np.pi * (np.arcsin(d) + d * np.sqrt(1 - d * d))
    assert x.simulated == pytest.approx(gain, rel=1e-9)


def test_a_quantised_spring_gives_the_describing_function_of_a_staircase() -> None:
    scene, A, q = hs.Scene(environments.mass_spring_damper(k=100)), 0.05, 0.02
    [x] = hs.simulate(scene, hs.sine(A, 5), extras=[hs.EncoderQuantisation("2 cm")]).estimates
    steps = np.array([q / 2, 3 * q / 2])
    gain = 100 * 4 * q / (np.pi * A) * np.sqrt(1 - (steps / A) ** 2).sum()
    assert x.simulated == pytest.approx(gain, rel=1e-9)


def test_a_quantised_motion_that_is_differentiated_is_refused() -> None:
    with pytest.raises(hs.SceneError, match=r"encoder-quantisation: .* jumps, and the scene differentiates it"):
        hs.simulate(hs.load_scene("fu2019"), hs.sine("5 cm", 5), extras=[hs.EncoderQuantisation("1 mm")])


# Error estimates, motions


@pytest.mark.slow
def test_error_estimates_are_neither_too_small_nor_useless() -> None:
    random = Random(3)
    for _ in range(15):
        wn, zeta, omega = random.uniform(20, 200), random.uniform(0.05, 1.5), random.uniform(1, 40)
        scene = hs.Scene(MSD, (effects.second_order_lowpass(round(wn, 3), round(zeta, 3)),))
        [x] = hs.simulate(scene, hs.sine("5 cm", round(omega, 3))).estimates
        assert x.difference <= x.error <= 1e-7 * abs(x.closed)


def test_a_run_cut_short_says_how_much_of_the_transient_is_left() -> None:
    slow = hs.Scene(environments.maxwell(100, 200), (effects.first_order_lag(30),))  # 2 s to relax
    [x] = hs.simulate(slow, hs.sine("5 cm", 30), duration=1.3).estimates
    assert 1e-8 < x.difference <= x.error


def test_a_multisine_recovers_each_frequency_at_once() -> None:
    run = hs.simulate(hs.load_scene("fu2019"), hs.multisine("5 cm", [2, 4, 10, 14]))
    assert [x.omega for x in run.estimates] == [2, 4, 10, 14]
    agree((run,), 1e-8)


def test_derivatives_of_the_motions_are_those_of_finite_differences() -> None:
    t = np.linspace(0.05, 5, 400)
    for motion in (hs.sine(1, 3), hs.multisine(1, [2, 3, 7]), hs.chirp(1, 1, 9, 6)):
        for k in range(10):
            high = motion.derivatives(t + 1e-5, k)[k]
            low = motion.derivatives(t - 1e-5, k)[k]
            exact = motion.derivatives(t, k + 1)[k + 1]
            assert (high - low) / 2e-5 == pytest.approx(exact, abs=1e-5 * np.abs(exact).max())


def test_a_chirp_through_a_fast_filter_is_force_times_motion() -> None:
    run = hs.simulate(hs.Scene(environments.mass_spring_damper(k=100)), hs.chirp("1 cm", 2, 20, 10))
    assert run.estimates == ()
    assert run.force == pytest.approx(100 * run.displacement, abs=1e-12)


def recorded(path: Path, header: str, count: int = 400) -> Path:
    t = np.arange(count) * 0.01
    rows = [f"{a:.6f},{10 * np.sin(5 * a):.12f}" for a in t]
    path.write_text("\n".join([*([header] if header else []), *rows]), encoding="utf-8")
    return path


def test_a_recorded_sine_in_millimetres_gives_the_force_of_that_sine(tmp_path: Path) -> None:
    run = hs.simulate(hs.Scene(MSD), hs.recording(recorded(tmp_path / "hand.csv", "t [s], x [mm]")))
    inside = (run.time > 0.2) & (run.time < 3.7)
    wave = 0.01 * ((100 - 1.8 * 25) * np.sin(5 * run.time) + 15 * 5 * np.cos(5 * run.time))
    assert run.force[inside] == pytest.approx(wave[inside], abs=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1\n1,nan\n2,3\n3,4\n4,5\n5,6\n", r'line 2: "nan" is not a finite number'),
        ("0,1\n1,2\n2,\n3,4\n4,5\n5,6\n", r"line 3: needs a time and a displacement"),
        ("0,1\n1,2\n2,3\n6,4\n7,5\n8,6\n9,1\n", r"line 4: a gap of 4 s between samples that are 1 s apart"),
        ("0,1\n1,2\n1,3\n3,4\n4,5\n5,6\n", r"line 3: time does not increase"),
        ("0,1\n1,2\n", r"2 samples; a recorded motion needs at least 6"),
        ("t [s],x [N]\n0,1\n1,2\n2,3\n3,4\n4,5\n5,6\n", r'line 1: "1 N" is not a displacement'),
        ("t [s],x [mm\n0,1\n1,2\n2,3\n3,4\n4,5\n5,6\n", r"line 1: .* write the unit in brackets"),
        ("", r"the file is empty"),
    ],
)
def test_a_bad_recording_is_refused_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(hs.SceneError, match=message):
        hs.recording(path)


def test_a_recording_cannot_be_differentiated_more_often_than_its_spline(tmp_path: Path) -> None:
    scene = hs.Scene(MSD, (effects.admittance_display("1/(1 + s/50)^3"),))
    with pytest.raises(hs.SceneError, match=r"needs derivative 5 of the motion; a recording has 4"):
        hs.simulate(scene, hs.recording(recorded(tmp_path / "hand.csv", "")))


@pytest.mark.parametrize(
    ("scene", "motion", "message"),
    [
        (hs.Scene(environments.expression("1/(s - 2)")), ("5 cm", 5), r"not stable \(pole at 2 1/s\)"),
        (hs.Scene(MSD, (effects.second_order_lowpass(10, 0),)), ("5 cm", 5), r"not stable \(pole at -?0 ± 10j 1/s\)"),
        (hs.Scene(SOFT, (effects.delay("0.2 s"), effects.first_order_lag(50), effects.compliance(100))), ("5 cm", 5), r"not stable \(pole at 4\.5.*no steady motion"),
        (hs.Scene(MSD, (effects.series("1/(s - 2)"), effects.series("(s - 2)/(s + 5)"))), ("5 cm", 5), r"an inner motion that grows \(pole at 2 1/s\), though H_perc does not show it"),
        (hs.Scene(SOFT, (effects.zero_order_hold("0.1 s"),)), ("5 cm", 40), r"zero-order-hold: 40 rad/s is not below the Nyquist frequency of its clock, 31.4"),
        (hs.Scene(MSD), ("3 deg", 5), r"motion: its unit is rotational, but the scene is translational"),
        (hs.Scene(environments.mass_spring_damper(m=hs.symbols("m"))), ("5 cm", 5), r"m = m is a symbol"),
        (hs.Scene(SOFT, (effects.zero_order_hold("1 ms"), effects.series("1 + s/50"))), ("5 cm", 5), r"zero-order-hold: .* jumps, and the scene differentiates it"),
        (hs.Scene(MSD, (effects.two_port("1", "0", "0", "0"),)), ("5 cm", 5), r"not determined|infinite"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_refused_by_name(scene: hs.Scene, motion: tuple[str, int], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.simulate(scene, hs.sine(*motion))


@pytest.mark.parametrize("bad", [("0 cm", 5), ("-1 cm", 5), ("5 N", 5), ("5 cm", 0), ("5 cm", "nan"), ("5 cm", "3 m")])
def test_a_bad_motion_is_refused(bad: tuple[str, object]) -> None:
    with pytest.raises(hs.SceneError, match=r"amplitude|frequency"):
        hs.sine(*bad)


# What is not in the scene


def test_only_the_blocks_that_a_scene_names_are_built() -> None:
    run = hs.simulate(hs.load_scene("fu2019"), hs.sine("5 cm", 5))
    assert run.built == ("mass-spring-damper", "second-order-lowpass")
    for model in set(EFFECTS) - {"second-order-lowpass"}:
        assert model not in str(run)
        assert model not in run.to_json()
    for word in ("quantis", "saturat", "friction", "hold"):
        assert word not in str(run).lower()


@pytest.mark.slow
def test_what_the_scene_does_not_need_is_not_imported() -> None:
    probe = (
        "import sys, haptisym as hs\n"
        "assert 'scipy.linalg' not in sys.modules\n"
        "hs.simulate(hs.load_scene('fu2019'), hs.sine('5 cm', 5), duration=2)\n"
        "assert 'haptisym.verbs.simulate.fractional' not in sys.modules and 'matplotlib' not in sys.modules\n"
        "assert 'haptisym.verbs.simulate.recordings' not in sys.modules\n"
        "hs.simulate(hs.Scene(hs.environments.spring_pot(80, '0.3')), hs.sine('5 cm', 5), duration=2)\n"
        "assert 'haptisym.verbs.simulate.fractional' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", probe], check=True)


# The command


def call(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *arguments: str) -> tuple[int, str, str]:
    monkeypatch.setattr("sys.argv", ["haptisym", "simulate", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    return int(stop.value.code or 0), out, err


def test_the_document_of_a_check(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    status, out, err = call(capsys, monkeypatch, "zener-tissue", "--check", "--json")
    document = json.loads(out)
    assert (status, err, document["schema"], document["agrees"]) == (0, "", "haptisym.simulation/1", True)
    assert set(document) == {"schema", "title", "motion", "time", "samples", "built", "force", "estimates", "agrees"}
    assert len(document["estimates"]) == 10
    for row in document["estimates"]:
        assert set(row) == {"omega", "simulated", "closed", "difference", "error", "agrees"}
        assert row["simulated"]["real"] == pytest.approx(row["closed"]["real"], rel=1e-6)


def test_the_page_says_what_was_simulated_and_that_it_agrees(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, _ = call(capsys, monkeypatch, "fu2019", "--omega", "10 rad/s", "--amplitude", "2 cm")
    assert status == 0
    assert "sine, up to 0.02 m" in out
    assert "agree within the estimated error" in out


@pytest.mark.slow
def test_all_figures_are_written(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    status, _, err = call(capsys, monkeypatch, "stick-with-friction", "--figures", str(tmp_path))
    assert (status, err) == (0, f"12 figures written to {tmp_path}\n")
    assert {p.name for p in tmp_path.iterdir()} == {
        f"{name}.{kind}"
        for name in ("simulated-time", "simulated-loop", "recovered-real", "recovered-imag")
        for kind in ("svg", "pdf", "png")
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("fu2019", "--motion", "wiggle"), "none of sine, multisine, chirp"),
        (("fu2019", "--check", "--omega", "3"), "leave out --omega"),
        (("fu2019", "--saturate", "3 kg"), "not a force"),
        (("fu2019", "--amplitude", "5 s"), "not a displacement"),
        (("fu2019", "--motion", "missing.csv"), "no such file"),
    ],
)
def test_a_wrong_command_line_is_one_sentence(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, err = call(capsys, monkeypatch, *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert message in err


def test_a_band_that_begins_above_zero_is_covered() -> None:
    scene = hs.load_scene("fu2019").with_band(Integer(6), Integer(15))
    [run] = hs.check(scene, count=5)
    assert min(x.omega for x in run.estimates) >= 6
    assert max(x.omega for x in run.estimates) == 15


# Threads of the linear algebra


def threads() -> list[int]:
    return [x["num_threads"] for x in threadpoolctl.threadpool_info() if x["user_api"] == "blas"]


def test_linear_algebra_has_one_thread_while_it_simulates_and_the_users_number_after() -> None:
    limits = threadpoolctl.threadpool_limits
    seen: list[int] = []
    with limits(2, user_api="blas"):
        before = threads()
        hs.simulate(hs.Scene(MSD), hs.sine("1 cm", 5), duration=1, progress=lambda *_: seen.extend(threads()))
        with pytest.raises(hs.SceneError):
            hs.simulate(hs.Scene(environments.expression("1/(s - 2)")), hs.sine("1 cm", 5))
        assert (set(seen), threads()) == ({1}, before)


@pytest.mark.slow
def test_a_blas_that_comes_with_scipy_has_one_thread_from_the_first_simulation_on() -> None:
    probe = (
        "import haptisym as hs, threadpoolctl\n"
        "seen = set()\n"
        "def watch(*_):\n"
        "    seen.update((x['filepath'], x['num_threads']) for x in threadpoolctl.threadpool_info() if x['user_api'] == 'blas')\n"
        "scene = hs.Scene(hs.environments.maxwell(100, 5), (hs.effects.delay('10 ms'),))\n"
        "hs.simulate(scene, hs.sine('5 cm', 5), duration=1, progress=watch)\n"
        "assert {n for _, n in seen} == {1}, seen\n"
    )
    subprocess.run([sys.executable, "-c", probe], check=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "2"})


def test_simulations_that_overlap_in_any_order_give_the_users_number_of_threads_back() -> None:
    limits = threadpoolctl.threadpool_limits
    with limits(2, user_api="blas"):
        before = threads()
        first, second = one_thread(), one_thread()
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert set(threads()) == {1}
        second.__exit__(None, None, None)
        assert threads() == before


def test_without_threadpoolctl_the_numbers_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = hs.Scene(MSD, (effects.delay("37 ms"), effects.first_order_lag(30)))
    one = hs.simulate(scene, hs.sine("1 cm", 5), duration=1)
    monkeypatch.setitem(sys.modules, "threadpoolctl", None)
    other = hs.simulate(scene, hs.sine("1 cm", 5), duration=1)
    assert other.force == pytest.approx(one.force, rel=1e-12, abs=1e-14)


# Recordings that begin somewhere, and noisy ones


def wave(t: np.ndarray) -> np.ndarray:
    """2 mm, and from 0.5 s on a growing sine about it."""
    late = np.maximum(t - 0.5, 0)
    return 0.002 + 0.01 * late**6 / (0.1 + late**6) * np.sin(9 * late)


def fade(t: np.ndarray) -> np.ndarray:
    x = np.clip(t, 0, 1)
    return x**6 * (462 - 1980 * x + 3465 * x**2 - 3080 * x**3 + 1386 * x**4 - 252 * x**5)


REST = {
    "a lag": (MSD, (effects.first_order_lag(9),)),
    "a mass on a cable": (environments.two_mass("0.5", 4, 200, "0.3", 3, 120), (effects.compliance(300, 5),)),
    "a delay in a loop": (SOFT, (effects.delay("50 ms"), effects.first_order_lag(40), effects.compliance(2000, 40))),
    "wave variables": (SOFT, (effects.wave_variables(25, "20 ms"),)),
    "a clock": (SOFT, (effects.first_order_lag(40), effects.zero_order_hold("50 ms"), effects.first_order_lag(40))),
    "a teleoperator": (SOFT, (effects.four_channel_teleoperator(**TELEOPERATOR, **MASTER),)),
    "a torn-off end": (environments.maxwell(100, 20), (effects.first_order_lag(30),)),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", REST)
def test_a_recording_that_begins_at_2_mm_goes_on_as_one_that_has_long_rested_there(name: str) -> None:
    scene = hs.Scene(*REST[name])
    t, lead = np.arange(0, 1.5001, 0.01), 15.0
    long = np.arange(0, lead + 1.5001, 0.01)
    whole = np.where(long < lead, 0.002 * fade(long / 2), wave(np.maximum(long - lead, 0)))
    started = hs.simulate(scene, Recording(t, wave(t)))
    rested = hs.simulate(scene, Recording(long, whole))
    late = rested.time > lead
    before = np.interp(started.time + lead, rested.time[late], rested.force[late])
    inside = (started.time > 0.01) & (started.time < 1.4)
    if name != "a clock":
        assert started.force[inside] == pytest.approx(before[inside], abs=2e-3 * np.abs(started.force).max())
    still = started.time < 0.4
    assert started.force[still] == pytest.approx(started.force[0], abs=1e-6 * np.abs(started.force).max())
    assert started.force[0] == pytest.approx(before[5], abs=1e-4 * np.abs(started.force).max())


def test_an_encoder_knows_from_the_first_moment_where_the_hand_is() -> None:
    t = np.arange(0, 1.001, 0.01)
    spring = hs.Scene(environments.mass_spring_damper(k=100))
    run = hs.simulate(spring, Recording(t, wave(t)), extras=[hs.EncoderQuantisation("0.1 mm")])
    steps = run.environment_force / 100 / 1e-4
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.abs(run.force / 100 - run.displacement).max() <= 0.5e-4 * (1 + 1e-6)
    assert run.force[0] == pytest.approx(0.2)


def test_a_noisy_recording_through_an_encoder_is_the_staircase_next_to_it() -> None:
    t, noise = np.arange(0, 0.3, 0.001), np.random.default_rng(5).normal(0, 5e-5, 300)
    spring = hs.Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(500),))
    run = hs.simulate(spring, Recording(t, 0.001 + noise), extras=[hs.EncoderQuantisation("0.1 mm")])
    steps = run.environment_force / 100 / 1e-4
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.abs(run.environment_force / 100 - run.displacement).max() <= 0.5e-4 * (1 + 1e-6)
    assert len(np.unique(np.round(steps))) > 2


def test_a_simulation_that_switches_too_often_stops_and_says_what_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptisym.verbs.simulate.engine._MOST_EVENTS", 20)
    spring = hs.Scene(environments.mass_spring_damper(k=100))
    with pytest.raises(hs.SceneError, match=r"encoder-quantisation: more than 20 switches before 0\.\d+ s.*--lowpass"):
        hs.simulate(spring, hs.sine("1 cm", 5), extras=[hs.EncoderQuantisation("0.1 mm")])


# Recordings smoothed


def sampled(path: Path, omega: float, dt: float = 0.01, count: int = 1000) -> Path:
    rows = [f"{i * dt:.6f},{np.sin(omega * i * dt):.12f}" for i in range(count)]
    path.write_text("\n".join(["t [s],x [mm]", *rows]), encoding="utf-8")
    return path


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("share", [0.5, 1, 1.5])
def test_a_low_pass_takes_3_db_at_its_cutoff_and_no_time(order: int, share: float, tmp_path: Path) -> None:
    cutoff, dt = 40.0, 0.01
    smooth = hs.recording(sampled(tmp_path / "hand.csv", share * cutoff), lowpass="40 rad/s", order=order)
    bent = (
        np.tan(share * cutoff * dt / 2) / np.tan(cutoff * dt / 2)
    ) ** order  # a bilinear transform bends frequencies
    gain = 1 / (1 + (np.sqrt(2) - 1) * bent)
    t = np.arange(3, 7, 0.0037)
    assert smooth.derivatives(t, 0)[0] == pytest.approx(1e-3 * gain * np.sin(share * cutoff * t), abs=3e-7)
    if share == 1:
        assert gain == pytest.approx(np.sqrt(0.5))


@pytest.mark.parametrize(
    ("cutoff", "order", "message"),
    [
        ("60 Hz", 4, r"must lie between .* and its Nyquist frequency, 314\.2 rad/s"),
        ("0.05 Hz", 4, r"must lie between one period in the whole recording, 0\.6289 rad/s"),
        ("10 Hz", 3, r"order of the low-pass: 3 is none of 2, 4, 6, 8"),
        ("0 Hz", 4, r"lowpass: .* must be > 0"),
        ("3 m", 4, r"lowpass: .*frequency"),
    ],
)
def test_a_low_pass_that_cannot_be_is_refused(cutoff: str, order: int, message: str, tmp_path: Path) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.recording(sampled(tmp_path / "hand.csv", 5), lowpass=cutoff, order=order)


def test_what_a_mass_makes_of_noise_is_said_in_newtons_and_what_smooths_it(tmp_path: Path) -> None:
    mass = hs.Scene(environments.mass_spring_damper(m=2, k=10), (), (0, 5))
    path = sampled(tmp_path / "hand.csv", 3)
    [note] = hs.simulate(mass, hs.recording(path), duration=0.1).notes
    newton = 1e-6 * (2 * (np.pi / 0.01) ** 2 - 10)
    assert f"1 µm at 50 Hz, its Nyquist frequency, is {newton:.3g} N at the hand" in note
    assert "--lowpass FREQUENCY" in note
    [note] = hs.simulate(mass, hs.recording(path, lowpass="5 Hz"), duration=0.1).notes
    assert f"1 µm at 5 Hz, the cutoff of its low-pass, is {1e-6 * (2 * (10 * np.pi) ** 2 - 10):.3g} N" in note
    assert (
        hs.simulate(mass, hs.recording(path, lowpass="1 Hz"), duration=0.1).notes == ()
    )  # 69 N/m, beside 40 on the band
    assert hs.simulate(mass, hs.sine("1 cm", 300), duration=0.01).notes == ()


def test_the_command_smooths_a_recording_and_writes_the_force_in_time(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    hand, force = sampled(tmp_path / "hand.csv", 5, count=200), tmp_path / "force.csv"
    options = ("--motion", str(hand), "--lowpass", "8 Hz", "--lowpass-order", "2", "--force", str(force), "--json")
    status, out, err = call(capsys, monkeypatch, "fu2019", *options)
    document, lines = json.loads(out), force.read_text(encoding="utf-8").splitlines()
    assert (status, err) == (0, f"force written to {force}\n")
    assert document["motion"]["lowpass"] == {"cutoff": pytest.approx(16 * np.pi), "order": 2, "phase": "zero"}
    assert document["motion"]["kind"] == "hand.csv, low-passed at 8 Hz (order 2, zero phase)"
    assert lines[0] == "time [s],displacement [m],force [N],environment displacement [m],environment force [N]"
    assert len(lines) == 1 + document["samples"]
    rows = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert (np.diff(rows[:, 0]) > 0).all()
    assert rows[:, 2].max() == document["force"]["most"]
    x = rows[:, 1]
    environment = 1.8 * np.gradient(np.gradient(x, rows[:, 0]), rows[:, 0]) + 15 * np.gradient(x, rows[:, 0]) + 100 * x
    assert rows[50:-50, 4] == pytest.approx(environment[50:-50], abs=0.02 * np.abs(environment).max())


def test_a_rotating_run_is_written_in_its_own_units() -> None:
    wheel = hs.simulate(hs.load_scene("steering-wheel"), hs.sine("3 deg", 5), duration=0.2).to_csv()
    heads = "time [s],displacement [rad],force [N m],environment displacement [rad],environment force [N m]"
    assert wheel.splitlines()[0] == heads


def test_the_force_never_takes_the_place_of_what_is_read(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    hand, scene = sampled(tmp_path / "hand.csv", 5), tmp_path / "scene.toml"
    scene.write_text('[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 5\n[evaluation]\nband = [0, 15]\njnd = 0.1\n')
    before = hand.read_bytes(), scene.read_bytes()
    for target in (hand, tmp_path / "." / scene.name):
        arguments = (str(scene), "--motion", str(hand), "--force", str(target))
        status, out, err = call(capsys, monkeypatch, *arguments)
        assert (status, out) == (2, "")
        assert "is read by this very call" in err
    assert (hand.read_bytes(), scene.read_bytes()) == before


# A user's own models


@pytest.fixture
def own_models() -> Iterator[None]:
    """Models of a user, one of them under the name of one of ours."""
    before = dict(EFFECTS), dict(ENVIRONMENTS)
    yield
    for catalogue, kept in zip((EFFECTS, ENVIRONMENTS), before, strict=True):
        catalogue.clear()
        catalogue.update(kept)


Rate = Annotated[Any, Slot(Dimension.FREQUENCY)]
Time = Annotated[Any, Slot(Dimension.TIME)]


@pytest.mark.usefixtures("own_models")
def test_a_users_own_effect_is_simulated_from_its_chain_matrix() -> None:
    @effect("lead-lag")
    def lead_lag(low: Rate, high: Rate) -> Any:
        return (1 + s / low) / (1 + s / high), 0, 0, 1

    @effect("soft-link")
    def soft_link(rate: Rate, k: Stiffness) -> Any:
        return 1, k * s / (s + rate), 1 / (k * (1 + s / rate)), 1

    @effect("late-lag")
    def late_lag(rate: Rate, late: Time) -> Any:
        return exp(-s * late) / (1 + s / rate), 0, 0, 1

    @effect("delay")  # under the name of one of ours, but it is a lag
    def delay(tau: Time) -> Any:
        return 1 / (1 + s * tau), 0, 0, 1

    for own in (lead_lag(20, 40), soft_link(20, 400), late_lag(30, "0.1 s"), delay("0.1 s")):
        agree((hs.simulate(hs.Scene(MSD, (own,)), hs.sine("1 cm", 5)),), 1e-7)


@pytest.mark.usefixtures("own_models")
def test_a_users_own_environment_is_simulated_from_its_formula() -> None:
    @environment("own-tissue")
    def own_tissue(k: Stiffness, tau: Time) -> Any:
        return k * (1 + s * tau) / (2 + s * tau)

    agree((hs.simulate(hs.Scene(own_tissue(100, "0.2 s")), hs.sine("1 cm", 5)),), 1e-7)


@pytest.mark.usefixtures("own_models")
def test_a_users_own_model_that_has_no_equation_in_time_is_refused_by_name() -> None:
    @effect("own-log")
    def own_log(rate: Rate) -> Any:
        return log(1 + s / rate), 0, 0, 1

    @effect("own-advance")
    def own_advance(early: Time) -> Any:
        return exp(s * early), 0, 0, 1

    @effect("own-friction")
    def own_friction(k: Stiffness) -> Any:
        return 1, I * k, 0, 1

    @environment("own-rubber")
    def own_rubber(k: Stiffness, tau: Time) -> Any:
        return k * tanh(s * tau)

    for scene, message in (
        (hs.Scene(MSD, (own_log(3),)), r"own-log: log\(s/3 \+ 1\) is not made of"),
        (
            hs.Scene(MSD, (own_advance(3),)),
            r"of own-advance only the chain matrix is known: .* must not need the future",
        ),
        (hs.Scene(MSD, (own_friction(3),)), r"own-friction: I has no meaning in time"),
        (hs.Scene(own_rubber(3, 1)), r"own-rubber: tanh\(s\) is not made of"),
    ):
        with pytest.raises(hs.SceneError, match=message):
            hs.simulate(scene, hs.sine("1 cm", 5))


@pytest.mark.parametrize(
    ("motion", "message"),
    [("hand.csv", r"'hand.csv' is no motion: make one with recording\(\"hand.csv\"\)"), ("sine", r"make one with sine\(\"5 cm\""), (None, r"None is no motion"), (0.1, "no motion")],
)  # fmt: skip
def test_what_is_no_motion_is_refused_with_what_makes_one(motion: object, message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.simulate("fu2019", motion)


@pytest.mark.parametrize("extras", [hs.EncoderQuantisation("1 mm"), ["0.1 mm"], "0.1 mm"])
def test_extras_are_a_list_of_extras(extras: object) -> None:
    with pytest.raises(hs.SceneError, match=r"extras: .* is no list of EncoderQuantisation and ForceSaturation"):
        hs.simulate("fu2019", hs.sine("1 cm", 5), extras=extras)


# Several frictions, levers, sweeps, files: what each says about the world


def test_frictions_on_one_part_are_one_friction_of_their_sum() -> None:
    env, behind = environments.mass_spring_damper(m="0.5", b=1, k=20), effects.compliance(200, 1)
    parts = [effects.coulomb_friction(f"{n} N", "5 cm", name=f"rubbing-{n}") for n in ("0.4", "0", "0.35", "0.25")]
    several = hs.simulate(hs.Scene(env, (*parts, behind)), hs.sine("2 cm", 3), duration=5)
    one = hs.simulate(hs.Scene(env, (effects.coulomb_friction("1 N", "5 cm"), behind)), hs.sine("2 cm", 3), duration=5)
    assert several.time == pytest.approx(one.time)
    assert several.force == pytest.approx(one.force, abs=1e-9)


def test_frictions_on_the_hands_own_motion_are_exact_with_a_mass_between_them() -> None:
    first, second = effects.coulomb_friction("0.4 N", "5 cm"), effects.coulomb_friction("0.6 N", "5 cm", name="second")
    agree((hs.simulate(hs.Scene(SOFT, (first, effects.shunt(m=1), second)), hs.sine("5 cm", 3)),), 1e-7)


def moved(center: float, before: float, reach: float) -> float:
    """Where a part ends that friction drags: where it was, or as far from its balance as friction holds."""
    return before if abs(center - before) <= reach else center - np.copysign(reach, center - before)


def two_parts(hand: np.ndarray) -> np.ndarray:
    """200 N/m, 1 N of friction, 100 N/m, 0.5 N of friction: each small step ends where energy and friction's work are least."""
    force, y, z = np.zeros_like(hand), 0.0, 0.0
    for i, h in enumerate(map(float, hand)):
        was_y, was_z = y, z
        for _ in range(25):  # one part after the other, until neither moves
            y = moved((200 * h + 100 * z) / 300, was_y, 1 / 300)
            z = moved(y, was_z, 0.5 / 100)
        force[i] = 200 * (h - y)
    return force


@pytest.mark.slow
def test_frictions_on_two_parts_stick_and_slip_each_on_its_own() -> None:
    tiny = environments.mass_spring_damper(k="1e-6")
    inner = effects.coulomb_friction("0.5 N", "5 cm", name="inner"), effects.compliance(100, name="a")
    outer = effects.coulomb_friction("1 N", "5 cm", name="outer"), effects.compliance(200, name="b")
    run = hs.simulate(hs.Scene(tiny, (*inner, *outer)), hs.sine("5 cm", 2), duration=7)
    grid = np.linspace(0, run.time[-1], 6001)
    known = two_parts(run.motion.derivatives(grid, 0)[0])
    assert run.force == pytest.approx(np.interp(run.time, grid, known), abs=2e-3)
    assert np.abs(run.force).max() == pytest.approx(1.5, abs=1e-6)


def test_friction_behind_a_lever_moves_otherwise_than_the_hand() -> None:
    lever = effects.two_port("0.5", "0", "0", "2")  # the far end moves twice as far, with half the force
    scene = hs.Scene(SOFT, (effects.coulomb_friction("0.5 N", "5 cm"), lever))
    [x] = hs.simulate(scene, hs.sine("5 cm", 4)).estimates
    assert "does not move as the hand does" in x.approximate
    true = (200 + 20j) / 4 + 4j * 0.5 / np.pi / 0.05 / 2  # half the force of a friction, over the hand's motion
    assert x.simulated == pytest.approx(true, rel=1e-7)


def test_a_chirp_is_the_known_wave_once_it_has_faded_in() -> None:
    motion = hs.chirp("2 cm", "1 Hz", "5 Hz", "8 s")
    t = np.linspace(1, 8, 300)
    phase = 2 * np.pi * (t + 4 * t * t / 16)
    assert motion.derivatives(t, 0)[0] == pytest.approx(0.02 * np.sin(phase), abs=1e-12)
    early = motion.derivatives(np.array([0.5]), 0)[
        0
    ]  # half faded in, when half a period of the lowest frequency is over
    assert early == pytest.approx(0.01 * np.sin(2 * np.pi * (0.5 + 4 * 0.25 / 16)))
    assert motion.span == pytest.approx((2 * np.pi, 10 * np.pi))
    assert (motion.duration, motion.name) == (8.0, "chirp")
    short = hs.chirp("2 cm", "1 Hz", "5 Hz", "2 s")  # fades in over a quarter of its time
    assert short.derivatives(np.array([0.5]), 0)[0] == pytest.approx(0.02 * np.sin(2 * np.pi * (0.5 + 4 * 0.25 / 4)))


@pytest.mark.parametrize("bad", [("1 cm", 5, 5, 3), ("1 cm", 5, 4, 3), ("1 cm", 5, 9, "3 m"), ("1 cm", 5, 9, 0)])
def test_a_chirp_that_cannot_be_is_refused(bad: tuple[Any, ...]) -> None:
    with pytest.raises(hs.SceneError, match=r"must end above where it begins|duration"):
        hs.chirp(*bad)


@pytest.mark.parametrize("bad", [[], [3, 3], [3, "3 rad/s"]])
def test_a_multisine_needs_each_frequency_once(bad: list[Any]) -> None:
    with pytest.raises(hs.SceneError, match="each only once"):
        hs.multisine("1 cm", bad)


def test_a_recording_is_read_in_its_own_units_with_blank_lines_after_it(tmp_path: Path) -> None:
    path = tmp_path / "hand.csv"
    rows = [f"{5000 + 20 * i + (10 if i == 3 else 0)},{i}" for i in range(6)]  # a spacing 1.5 times the usual is no gap
    path.write_text("\n".join(["\ufefft [ms], angle [deg]", *rows, "", " , ", ""]), encoding="utf-8")
    made = hs.recording(path)
    assert made.times == pytest.approx([0, 0.02, 0.04, 0.07, 0.08, 0.1])
    assert made.values == pytest.approx(np.radians(range(6)))
    assert (made.name, made.kind.value, made.duration) == ("hand.csv", "rotational", pytest.approx(0.1))
    assert made.amplitude == pytest.approx(np.radians(5))
    assert made.span == pytest.approx((20 * np.pi, np.pi / 0.03))
    assert made.derivatives(np.array([-1.0, 0.0, 0.1, 9.0]), 1) == pytest.approx(
        np.array([np.radians([0, 0, 5, 5]), [0, *made.derivatives(np.array([0.0, 0.1, 0.1]), 1)[1]]])
    )


@pytest.mark.parametrize("header", ["t [s],x [m]\n", ""])
@pytest.mark.parametrize(
    ("rows", "line", "message"),
    [
        ("0,0\n1,1\n2,0\n3,x\n4,0\n5,0\n", 4, '"x" is not a finite number'),
        ("0,0\n1,1\n2,0\n3,inf\n4,0\n5,0\n", 4, '"inf" is not a finite number'),
        ("0,0\n1,1\n2,0\n2,1\n4,0\n5,0\n", 4, "time does not increase"),
        ("0,0\n1,1\n2,0\n3.51,1\n4.5,0\n5.5,0\n", 4, "a gap of 1.51 s"),
        ("0,0\n1,1\n2,0\n3\n4,0\n5,0\n", 4, "needs a time and a displacement"),
        ("0,0\n1,1\n2,0,7\n3,0\n4,0\n5,0\n", 3, "needs a time and a displacement"),
    ],
)
def test_what_is_wrong_in_a_recording_is_told_by_its_line(
    header: str, rows: str, line: int, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(header + rows, encoding="utf-8")
    with pytest.raises(hs.SceneError) as stop:
        hs.recording(path)
    assert f"line {line + bool(header)}: {message}" in str(stop.value)


def test_a_duration_is_a_time() -> None:
    run = hs.simulate(hs.Scene(SOFT), hs.sine("1 cm", 5), duration="1200 ms")
    assert 1.2 - 0.2 < run.time[-1] <= 1.2 + 0.2  # a step is not cut short
    for bad in ("3 m", 0, "-1 s"):
        with pytest.raises(hs.SceneError, match="duration"):
            hs.simulate(hs.Scene(SOFT), hs.sine("1 cm", 5), duration=bad)


@pytest.mark.parametrize("duration", [1.3, 1.6, 2.2, 3])
@pytest.mark.parametrize("tau", [0.5, 2, 4])
def test_however_short_a_run_the_rest_of_the_transient_is_in_its_error(duration: float, tau: float) -> None:
    slow = hs.Scene(environments.maxwell(100, 100 * tau), (effects.first_order_lag(30),))
    [x] = hs.simulate(slow, hs.sine("5 cm", 30), duration=duration).estimates
    assert x.difference <= x.error <= max(1e4 * x.difference, 1e-7 * abs(x.closed))


def test_frictions_on_both_ends_of_a_lever_stick_and_slip_as_one() -> None:
    """0.4 N where the part moves, and 0.3 N where the lever moves twice as far: 1 N where the part moves."""
    env, behind = environments.mass_spring_damper(m="0.5", b=1, k=20), effects.compliance(200, 1)
    for way in ("2", "-2"):
        lever = effects.two_port(f"1/({way})", "0", "0", way)
        ends = (effects.coulomb_friction("0.4 N", "5 cm"), lever, effects.coulomb_friction("0.3 N", "5 cm", name="far"))
        both = hs.simulate(hs.Scene(env, (*ends, behind)), hs.sine("2 cm", 3), duration=5)
        near = hs.simulate(
            hs.Scene(env, (effects.coulomb_friction("1 N", "5 cm"), lever, behind)), hs.sine("2 cm", 3), duration=5
        )
        assert both.force == pytest.approx(np.interp(both.time, near.time, near.force), abs=1e-6)


def test_a_limited_force_behind_an_encoder_is_the_staircase_cut_off() -> None:
    extras = [hs.EncoderQuantisation("5 mm"), hs.ForceSaturation("3 N")]
    run = hs.simulate(hs.Scene(environments.mass_spring_damper(k=100)), hs.sine("5 cm", 5), duration=4, extras=extras)
    stairs = 0.5 * np.round(run.displacement / 0.005)
    inside = np.abs(np.mod(run.displacement / 0.005, 1) - 0.5) > 1e-6
    assert run.force[inside] == pytest.approx(np.clip(stairs, -3, 3)[inside], abs=1e-9)


@pytest.mark.slow
def test_the_error_of_a_fractional_element_is_part_of_the_estimate() -> None:
    [x] = hs.simulate(CATALOGUE["spring-pot"], hs.sine("1 cm", 5)).estimates
    bank = bank_error(0.3, (5, 5), np.array([5.0]))
    assert 1e-13 < bank < 2e-10
    assert x.error >= 3 * bank * abs(x.simulated)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_a_bank_of_relaxations_is_the_power_along_its_band(alpha: float) -> None:
    omegas = np.geomspace(1, 50, 40)
    rates, weights, spring, damper = rates_and_weights(alpha, (1, 50))
    value = [
        spring + damper * 1j * w + sum(g * 1j * w / (1j * w + r) for r, g in zip(rates, weights, strict=True))
        for w in omegas
    ]
    assert np.abs(np.array(value) / (1j * omegas) ** alpha - 1).max() < 1.5e-10


# From equations to states, exactly


def transfer(system: StateSpace, name: str, order: int, at: fmpq) -> list[fmpq]:
    """A signal's answer to each input times e^(st), s a number: exact."""
    size, width = system.size, len(system.inputs)
    drive = sum((n * at**k for k, n in enumerate(system.N)), fmpq_mat(size, width))
    eye = fmpq_mat(size, size, [fmpq(int(i == k)) for i in range(size) for k in range(size)])
    z = (at * eye - system.M).solve(drive)
    row = system.signal(name, order)
    moved = row.state * z
    return [moved[0, i] + sum((c[0, i] * at**k for k, c in enumerate(row.inputs)), fmpq(0)) for i in range(width)]


def polynomial(coefficients: list[int], at: fmpq) -> fmpq:
    return sum((c * at**k for k, c in enumerate(coefficients)), fmpq(0))


@pytest.mark.parametrize("driver", ["motion", "held"])
def test_states_answer_as_their_equations_do_and_only_the_motion_drives_by_derivatives(driver: str) -> None:
    """y'' + ... of an input's derivatives up to the third, through an algebraic signal: answers are quotients of polynomials."""
    random = Random(driver)
    for _ in range(40):
        below = [random.randint(1, 9) for _ in range(random.randint(1, 4))]
        above = [random.randint(-9, 9) or 1 for _ in range(random.randint(1, 4))]
        gain = random.randint(1, 5)
        x, y, f, hand = (SignalSum.of(n) for n in ("x", "y", "f", "motion"))
        source = hand if driver == "motion" else SignalSum.of("held")
        equations = [y.through(*below) - source.through(*above), f - gain * y.d() - hand, x - y - 2 * f]
        system = state_space(equations, ("held",))
        place = [i.name for i in system.inputs].index(driver)
        for at in (fmpq(1, 3), fmpq(-7, 2), fmpq(5)):
            if polynomial(below, at) == 0:
                continue
            direct = int(driver == "motion")
            y_true = polynomial(above, at) / polynomial(below, at)
            f_true = gain * at * y_true + direct
            for name, true in (("y", y_true), ("f", f_true), ("x", y_true + 2 * f_true)):
                for order in (0, 1, 2):
                    assert transfer(system, name, order, at)[place] == at**order * true
            # the way back: the chosen variables less what was moved are the states
            shift = sum((r * at**k for k, r in enumerate(system.shifts)), fmpq_mat(system.size, len(system.inputs)))
            eye = fmpq_mat(
                system.size, system.size, [fmpq(int(i == k)) for i in range(system.size) for k in range(system.size)]
            )
            drive = sum((n * at**k for k, n in enumerate(system.N)), 0 * shift)
            states = (at * eye - system.M).solve(drive)
            names = list(system.columns)
            for i, column in enumerate(system.chosen):
                chosen = transfer(system, *names[column], at)[place]
                assert states[i, place] == chosen - shift[i, place]
        for channel in system.inputs:
            if channel.name != "motion":
                assert set(system.drives(channel)) <= {0}
