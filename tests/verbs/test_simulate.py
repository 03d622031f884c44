"""What a simulation in time gives, against closed forms and against what physics says beforehand."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from random import Random
from typing import Annotated, Any

import numpy as np
import pytest
import threadpoolctl
from marks import often
from scipy import special
from scipy.interpolate import CubicSpline
from strategies import BETWEEN, CATALOGUE, FELT, MSD, SOFT, Seeded, case
from strategies import scene as told_scene
from sympy import I, atan, exp, log

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.budget import timed_by
from haptisym.kernel.errors import LimitError
from haptisym.kernel.rings import s
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, effect, environment
from haptisym.model.motions import Recording
from haptisym.model.parameters import Slot, Stiffness
from haptisym.model.quantities import Dimension
from haptisym.verbs.simulate.entry import RecoveredResponse, Simulations, band_frequencies, motion, run
from haptisym.verbs.simulate.network import rates_and_weights

SPRING = environments.mass_spring_damper(k=100)
LOOPS = {
    "a lag behind a cable": (effects.first_order_lag(30), effects.compliance(500, 3)),
    "a delay inside a loop": (effects.second_order_lowpass(60, 1), effects.delay("10 ms"), effects.compliance(2000, 40)),
    "a delay before the filter in a loop": (effects.delay("10 ms"), effects.second_order_lowpass(60, 1), effects.compliance(2000, 40)),
    "two links in a row": (effects.wave_variables(10, "20 ms"), effects.compliance(900, 5), effects.wave_variables(10, "10 ms")),
    "arms that are damped, and scales": (
        effects.position_force_teleoperator("0.5 kg", "2 kg", 64, 400, "20 ms", "1 N*s/m", "3 N*s/m", 2, "0.3"),
        effects.position_position_teleoperator("0.5 kg", 16, 900, "2 kg", 64, 900, "20 ms", "1 N*s/m", "3 N*s/m"),
    ),
    "four channels with scales": (effects.four_channel_teleoperator("0.5 kg", 16, 100, "2 kg", 64, 400, "20 ms", 1, 3, "0.5", "0.2"),),
    "four channels without delay": (effects.four_channel_teleoperator(1, 2, 30, 2, 40, 50),),
    "a delayed force through two derivatives": (effects.delay("20 ms"), effects.series("(1 + s/30)^2/(1 + s/100)^3")),
    "friction through a delay": (effects.coulomb_friction("0.5 N", "5 cm"), effects.delay("37 ms")),
    "a shunt as a formula": (effects.shunt(Z="2*s + 300*s/(s + 5)"),),
    "half a derivative": (effects.series("1/(1 + 0.2*s^0.5)"),),
    "an admittance display before a torsion bar": (effects.compliance(3000, 60), effects.admittance_display("900/(s^2 + 40*s + 900)")),
}  # fmt: skip

DEAR = {
    "spring-pot",
    "half a derivative",
    "two links in a row",
    "coulomb-friction",
    "a delay before the filter in a loop",
}


def agree(runs: tuple[hs.Simulation, ...], tolerance: float) -> None:
    """The simulation is as close to the closed form as it says itself, and as close as it should."""
    rows = [x for run in runs for x in run.estimates]
    largest = max(abs(x.closed) for x in rows)
    for x in rows:
        assert x.approximate == ""
        assert x.difference <= x.error, x
        assert x.error <= tolerance * largest, x


def test_the_catalogue_has_a_scene_for_every_model() -> None:
    assert set(CATALOGUE) == {*ENVIRONMENTS, *EFFECTS}


@pytest.mark.dear(
    "a delay inside a loop",
    "a delayed force through two derivatives",
    "delay",
    "encoder",
    "four-channel-teleoperator",
    "friction through a delay",
    "pade-delay",
    "position-force-teleoperator",
    "position-position-teleoperator",
    "sampled-loop",
    "wave-variables",
    "zero-order-hold",
)
@pytest.mark.parametrize("name", often([*CATALOGUE, *LOOPS], lambda name: name not in DEAR))
def test_a_sine_comes_out_of_every_model_and_of_loops_as_the_closed_form_says(name: str) -> None:
    scene = CATALOGUE[name] if name in CATALOGUE else hs.Scene(MSD, LOOPS[name])
    agree((hs.simulate(scene, hs.sine("5 cm", 20)),), 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CATALOGUE, *LOOPS])
def test_simulation_and_closed_form_agree_along_the_band_for_every_model(name: str) -> None:
    scene = CATALOGUE[name] if name in CATALOGUE else hs.Scene(MSD, LOOPS[name])
    agree(hs.check(scene, count=3), 1e-7)


@pytest.mark.dear("sidestick")
@pytest.mark.parametrize("name", often(sorted(hs.scene_names()), {"fu2019", "sidestick"}.__contains__))
def test_simulation_and_closed_form_agree_for_every_shipped_scene(name: str) -> None:
    runs = hs.check(hs.load_scene(name), count=3)
    if name != "wheel-with-encoder":
        agree(runs, 1e-6)
        return
    # The steps jump between samples: a few tenths of a percent from one sine's first harmonic.
    for x in (x for checked in runs for x in checked.estimates):
        assert "samples what jumps" in x.approximate
        assert x.difference < 0.02 * abs(x.closed)


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


@pytest.mark.parametrize(
    ("Z", "names"), [("m*s", {"m": 2}), ("b*s^2 + k", {"b": "1/2", "k": 3}), ("k*s/(1 + s/b)", {"k": 2, "b": 9})]
)
def test_the_numbers_of_a_shunt_s_formula_are_what_the_formula_says_whatever_they_are_called(
    Z: str, names: dict[str, object]
) -> None:
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 2), (hs.effects.shunt(Z=Z, parameters=names),))
    [own] = hs.check(scene, count=2)
    assert own.agrees


# Physics that is known without any of this


def test_the_force_of_a_lag_on_a_spring_is_the_known_steady_wave() -> None:
    run = hs.simulate(
        hs.Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(20),)), hs.sine("1 cm", 20)
    )
    late = run.time > run.motion.fade + 2  # a quarter turn between resistance and reactance: 1/sqrt(2), 45 degrees late
    wave = np.sin(20 * run.time - np.pi / 4) / np.sqrt(2)
    assert run.force[late] == pytest.approx(wave[late], abs=1e-10)


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("lags", [("17", "4"), ("17.3",)])  # in one grid with the clock, and beside it
def test_a_held_force_that_comes_late_goes_through_a_lag_from_step_to_step_of_the_clock(lags: tuple[str, ...]) -> None:
    """Between steps the lag falls towards what is held, by exp(-40 t) of the difference."""
    between = (effects.zero_order_hold("50 ms"), *(effects.delay(f"{x} ms", name=f"line {x}") for x in lags))
    scene = hs.Scene(environments.kelvin_voigt(200, 5), (*between, effects.first_order_lag(40)))
    run = hs.simulate(scene, hs.sine("1 cm", 10), duration=0.7)
    x, v = run.motion.derivatives(0.05 * np.arange(31), 1)
    held, force, late = 200 * x + 5 * v, [0.0], sum(map(float, lags)) / 1000
    for u in held:
        force.append(u + (force[-1] - u) * np.exp(-40 * 0.05))
    n = np.floor((run.time - late) / 0.05 + 1e-12).astype(int)
    known = held[n] + (np.array(force)[n] - held[n]) * np.exp(-40 * (run.time - late - 0.05 * n))
    assert run.force == pytest.approx(np.where(n < 0, 0, known), abs=1e-9)


def test_what_friction_adds_comes_out_of_a_delay_line_that_much_later() -> None:
    scene = hs.Scene(
        environments.kelvin_voigt(200, 5), (effects.coulomb_friction("0.5 N", "5 cm"), effects.delay("37 ms"))
    )
    run = hs.simulate(scene, hs.sine("5 cm", 20), duration=1)
    t = run.time - 0.037
    late = t > run.motion.fade
    bare = 10 * np.sin(20 * t) + 5 * np.cos(20 * t)
    clear = np.abs(np.cos(20 * t)) > 1e-9
    assert run.force[late & clear] == pytest.approx((bare + 0.5 * np.sign(np.cos(20 * t)))[late & clear], abs=1e-9)
    assert (run.force[run.time < 0.037] == 0).all()


@pytest.mark.slow
def test_friction_on_a_prescribed_motion_switches_where_the_velocity_changes_sign() -> None:
    run = hs.simulate(CATALOGUE["coulomb-friction"], hs.sine("5 cm", 4), duration=6)
    alone = hs.simulate(hs.Scene(MSD, (effects.first_order_lag(30),)), hs.sine("5 cm", 4), duration=6)
    shared = hs.simulate(hs.Scene(SOFT, (effects.coulomb_friction("0.5 N", "5 cm"),)), hs.sine("5 cm", 4), duration=6)
    bare = 200 * 0.05 * np.sin(4 * shared.time) + 5 * 0.2 * np.cos(4 * shared.time)
    late = shared.time > shared.motion.fade
    assert shared.force[late] - bare[late] == pytest.approx(0.5 * np.sign(np.cos(4 * shared.time[late])), abs=1e-9)
    assert np.abs(run.force).max() > np.abs(alone.force).max()


def jenkins(x: Any, k: float, limit: float) -> Any:
    """A spring in a row with dry friction: the force after each small step, by return mapping."""
    force, found = 0.0, [0.0]
    for step in np.diff(x).tolist():
        force = min(max(force + k * step, -limit), limit)
        found.append(force)
    return np.array(found)


@pytest.mark.dear("between0")
@pytest.mark.parametrize("between", [(), (effects.compliance(300),)])
def test_friction_behind_a_spring_sticks_first_and_then_slips_and_sticks(between: tuple[hs.Effect, ...]) -> None:
    """Two springs in a row are one; what friction drags has no mass, so that its force can slip no other way."""
    scene = hs.Scene(
        environments.mass_spring_damper(k="1e-6"),
        (effects.coulomb_friction("1 N", "5 cm"), effects.compliance(100), *between),
    )
    run = hs.simulate(scene, hs.sine("5 cm", 20), duration=1.1)
    grid = np.linspace(0, run.time[-1], 40_001)
    known = jenkins(run.motion.derivatives(grid, 0)[0], 75 if between else 100, 1.0)
    assert run.force == pytest.approx(np.interp(run.time, grid, known), abs=2e-3)
    assert np.abs(run.force).max() == pytest.approx(1, abs=1e-6)
    assert (np.abs(run.force) < 0.9).any()


@pytest.mark.slow
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


@pytest.mark.parametrize("between", [(), (effects.two_port("0.5", "0", "0", "2"),)])
def test_frictions_on_one_part_behind_a_spring_are_refused(between: tuple[hs.Effect, ...]) -> None:
    near, far = (effects.coulomb_friction("0.4 N", "5 cm", name=name) for name in ("near", "far"))
    scene = hs.Scene(
        environments.mass_spring_damper(m="0.5", b=1, k=20), (near, *between, far, effects.compliance(200, 1))
    )
    with pytest.raises(hs.SceneError, match="near and far act on the same part"):
        hs.simulate(scene, hs.sine("2 cm", 3), duration=1)


# Quantisation and saturation


def test_a_saturated_spring_gives_the_describing_function_of_saturation() -> None:
    scene, A, limit = hs.Scene(environments.mass_spring_damper(k=100)), 0.05, 2.0
    [x] = hs.simulate(scene, hs.sine(A, 5), extras=[hs.ForceSaturation(f"{limit} N")]).estimates
    d = limit / 100 / A
    gain = 100 * 2 / np.pi * (np.arcsin(d) + d * np.sqrt(1 - d * d))
    assert x.simulated == pytest.approx(gain, rel=1e-9)


def test_a_recording_gives_the_error_of_the_force_that_encoder_and_limit_make() -> None:
    """A sampled spring without delay: from sample to sample the force is 800 q(x), q of the recording's own samples."""
    t = np.arange(501) * 1e-3
    x = 0.02 * np.sin(2 * np.pi * 2 * t) * np.sin(np.pi * t)
    loop = hs.effects.sampled_loop("1 ms", "backward-difference", 0)
    scene = hs.Scene(hs.environments.mass_spring_damper(k=800), (loop,), ("0 Hz", "20 Hz"))
    extras = [hs.EncoderQuantisation("0.3 mm"), hs.ForceSaturation("9 N")]
    run = hs.simulate(scene, Recording(t, x), extras=extras)
    ideal, encoded = 800 * x[:-1], 800 * 3e-4 * np.round(x[:-1] / 3e-4)
    limited, both = np.clip(ideal, -9, 9), np.clip(encoded, -9, 9)
    assert run.error is not None
    off = both - ideal
    assert (run.error.largest, run.error.rms) == pytest.approx((np.abs(off).max(), np.sqrt((off**2).mean())), rel=1e-8)
    off = both - limited
    found = run.error.quantised_largest, run.error.quantised_rms
    assert found == pytest.approx((np.abs(off).max(), np.sqrt((off**2).mean())), rel=1e-8)
    assert run.error.at_limit == pytest.approx((np.abs(both) == 9).mean(), rel=1e-9)
    assert run.to_dict()["error"]["quantisation"] == dict(zip(("largest", "rms"), found, strict=True))
    alone = hs.simulate(scene, Recording(t, x), extras=extras[:1]).error
    assert alone is not None
    assert (alone.at_limit, alone.largest) == (0, alone.quantised_largest)
    assert hs.simulate(scene, Recording(t, x)).error is None


def test_encoder_and_limit_act_at_each_tick_of_a_late_wall_as_sample_by_sample() -> None:
    """A sample late, as long as rounding of times adds up: 400 q + 0.4 (q - q before)/T, cut off, by NumPy."""
    t = np.arange(1400) * 1e-3
    x = 0.02 * np.sin(2 * np.pi * 1.3 * t) + 0.004 * np.sin(2 * np.pi * 5.1 * t + 0.3)
    run = hs.simulate(
        "virtual-wall", Recording(t, x), extras=[hs.EncoderQuantisation("20 um"), hs.ForceSaturation("8.01 N")]
    )

    def wanted(x: Any) -> Any:
        late = np.concatenate([[x[0], x[0]], x])[:-1]
        return 400 * late[1:] + 400 * np.diff(late)

    q = 2e-5 * np.round(x[:-1] / 2e-5)
    force = np.clip(wanted(q), -8.01, 8.01)
    off = force - wanted(x[:-1])
    assert run.error is not None
    assert run.error.at_limit == pytest.approx((np.abs(force) == 8.01).mean(), rel=1e-8)
    assert (run.error.largest, run.error.rms) == pytest.approx((np.abs(off).max(), np.sqrt((off**2).mean())), rel=1e-6)


def test_whole_samples_of_delay_are_one_step_each_whether_the_controller_or_a_line_keeps_them() -> None:
    """A filtered velocity, s = (1 - 1/z)/T, three samples late, as a recursion of the encoder's samples."""
    t = np.arange(400) * 1e-3
    x = 0.02 * np.sin(2 * np.pi * 3 * t)
    wall = hs.environments.expression("500 + 2*s*50/(s + 50)")
    q, filtered, force = 1e-4 * np.round(x / 1e-4), 0.0, [0.0, 0.0, 0.0]
    for now, last in zip(q, [q[0], *q[:-1]], strict=True):
        filtered = (filtered + 100 * (now - last)) / 1.05
        force.append(500 * now + filtered)
    for late, behind in ((3, ()), (1, (hs.effects.delay("2 ms"),))):
        loop = hs.effects.sampled_loop("1 ms", "backward-difference", late)
        scene = hs.Scene(wall, (loop, *behind), ("0 Hz", "20 Hz"))
        run = hs.simulate(scene, Recording(t, x), extras=[hs.EncoderQuantisation("0.1 mm")])
        steps = run.force.reshape(-1, 10)
        assert len(steps) == 399
        assert steps == pytest.approx(np.repeat(force[:399], 10).reshape(-1, 10), abs=1e-9)


def test_a_quantised_spring_gives_the_describing_function_of_a_staircase() -> None:
    scene, A, q = hs.Scene(environments.mass_spring_damper(k=100)), 0.05, 0.02
    [x] = hs.simulate(scene, hs.sine(A, 5), extras=[hs.EncoderQuantisation("2 cm")]).estimates
    steps = np.array([q / 2, 3 * q / 2])
    gain = 100 * 4 * q / (np.pi * A) * np.sqrt(1 - (steps / A) ** 2).sum()
    assert x.simulated == pytest.approx(gain, rel=1e-9)


@pytest.mark.slow
def test_a_limited_force_behind_an_encoder_is_the_staircase_cut_off() -> None:
    extras = [hs.EncoderQuantisation("5 mm"), hs.ForceSaturation("3 N")]
    run = hs.simulate(hs.Scene(environments.mass_spring_damper(k=100)), hs.sine("5 cm", 5), duration=4, extras=extras)
    stairs = 0.5 * np.round(run.displacement / 0.005)
    inside = np.abs(np.mod(run.displacement / 0.005, 1) - 0.5) > 1e-6
    assert run.force[inside] == pytest.approx(np.clip(stairs, -3, 3)[inside], abs=1e-9)


@pytest.mark.slow
def test_a_noisy_recording_through_an_encoder_is_the_staircase_next_to_it() -> None:
    t, noise = np.arange(0, 0.1, 0.001), np.random.default_rng(5).normal(0, 5e-5, 100)
    spring = hs.Scene(environments.mass_spring_damper(k=100), (effects.first_order_lag(500),))
    run = hs.simulate(spring, Recording(t, 0.001 + noise), extras=[hs.EncoderQuantisation("0.1 mm")])
    steps = run.environment_force / 100 / 1e-4
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.abs(run.environment_force / 100 - run.displacement).max() <= 0.5e-4 * (1 + 1e-6)
    assert len(np.unique(np.round(steps))) > 2


def test_a_play_leaves_the_environment_where_it_was_until_a_flank_touches_it() -> None:
    scene = hs.Scene(SPRING, (effects.backlash("4 mm", "1 cm"),))
    run = hs.simulate(scene, hs.sine("1 cm", 5), duration=6)
    between = run.displacement - run.environment_displacement
    assert np.abs(between).max() == pytest.approx(2e-3, rel=1e-9)
    place = np.clip(run.displacement[0], -2e-3, 2e-3) - run.displacement[0]
    for x, y in zip(run.displacement, run.environment_displacement, strict=True):
        place = min(max(place, x - 2e-3), x + 2e-3)
        assert y == pytest.approx(place, abs=1e-5)


@pytest.mark.parametrize(
    "one", [effects.dead_zone("1 mm", "0.5 mm"), effects.backlash("1 mm", "0.5 mm"), effects.encoder("1 mm", "0.5 mm")]
)
def test_nothing_passes_where_the_amplitude_is_too_small(one: hs.Effect) -> None:
    run = hs.simulate(hs.Scene(SPRING, (one,)), hs.sine("0.5 mm", 5))
    [x] = run.estimates
    assert (x.closed, x.simulated, x.agrees) == (0, 0, True)
    assert np.abs(run.force).max() == 0


def test_what_jumps_or_hits_is_not_differentiated() -> None:
    for one in (effects.encoder("1 mm", "5 cm"), effects.backlash("1 mm", "5 cm")):
        scene = hs.Scene(MSD, (one,))
        with pytest.raises(hs.SceneError, match=f"{one.name}: its output jumps"):
            hs.simulate(scene, hs.sine("5 cm", 20))


# What is said of the closed form, and of errors


@pytest.mark.dear("between5-made5-base band", "between6-made6-")
@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("between", "made", "said"),
    [
        ((effects.coulomb_friction("1 N", "5 cm"),), ("5 cm", [5]), ""),
        ((effects.coulomb_friction("1 N", "5 cm"),), ("5 cm", [5, 10]), "one sine"),
        ((effects.coulomb_friction("1 N", "5 cm"),), ("2 cm", [5]), "amplitude of 0.05"),
        ((effects.coulomb_friction("1 N", "5 cm"), effects.compliance(900)), ("5 cm", [5]), "does not move as the hand does"),
        ((effects.compliance(900), effects.coulomb_friction("1 N", "5 cm")), ("5 cm", [5]), ""),
        ((effects.coulomb_friction("1 N", "5 cm"), effects.zero_order_hold("30 ms")), ("5 cm", [5]), "base band"),
        ((effects.zero_order_hold("30 ms"), effects.coulomb_friction("1 N", "5 cm")), ("5 cm", [5]), ""),
        ((effects.zero_order_hold("30 ms"), effects.shunt(m=1), effects.compliance(900, 30)), ("5 cm", [5]), "base band"),
        ((effects.backlash("1 cm", "5 cm"),), ("2 cm", [5]), "amplitude of 0.05, the hand moves by 0.02"),
        ((effects.dead_zone("1 cm", "5 cm"), effects.compliance(900)), ("5 cm", [5]), "does not move as the hand does"),
        ((effects.dead_zone("1 cm", "5 cm"), effects.coulomb_friction("1 N", "5 cm")), ("5 cm", [5]), ""),
        ((effects.saturation("2 N", "1 N"),), ("5 cm", [5]), "amplitude of 1, the force has 10.07"),
        ((effects.delay("10 ms"), effects.saturation("2 N", "9 N")), ("5 cm", [5]), "limits what is filtered before"),
        ((effects.sampled_loop("30 ms", "tustin"), effects.encoder("1 cm", "5 cm")), ("5 cm", [5]), "base band"),
    ],
)  # fmt: skip
def test_where_the_closed_form_approximates_the_reason_is_told(
    between: tuple[hs.Effect, ...], made: tuple[str, list[int]], said: str
) -> None:
    scene = hs.Scene(environments.kelvin_voigt(200, 5), between)
    for x in hs.simulate(scene, hs.multisine(*made), duration=6).estimates:
        assert said in x.approximate
        assert (x.approximate == "", x.agrees) == ((True, True) if not said else (False, None))


@pytest.mark.slow
def test_error_estimates_are_neither_too_small_nor_useless() -> None:
    random = Random(3)
    for _ in range(15):
        wn, zeta, omega = random.uniform(20, 200), random.uniform(0.05, 1.5), random.uniform(1, 40)
        scene = hs.Scene(MSD, (effects.second_order_lowpass(round(wn, 3), round(zeta, 3)),))
        [x] = hs.simulate(scene, hs.sine("5 cm", round(omega, 3))).estimates
        assert x.difference <= x.error <= 1e-7 * abs(x.closed)


@pytest.mark.dear("4-1.3")
@pytest.mark.parametrize("duration", [1.3, 1.6, 2.2, 3])
@pytest.mark.parametrize("tau", [0.5, 2, 4])
def test_however_short_a_run_the_rest_of_the_transient_is_in_its_error(duration: float, tau: float) -> None:
    slow = hs.Scene(environments.maxwell(100, 100 * tau), (effects.first_order_lag(30),))
    [x] = hs.simulate(slow, hs.sine("5 cm", 30), duration=duration).estimates
    assert x.difference <= x.error <= max(1e4 * x.difference, 1e-7 * abs(x.closed))


@pytest.mark.parametrize("b", [0.05, 0.1])
def test_what_a_wave_still_brings_that_hardly_fades_is_in_the_error(b: float) -> None:
    """In a line of 20 ms and b = 10 a damper takes 2 b/(10 + b) of each wave: a run ends long before there is none left."""
    scene = hs.Scene(environments.mass_spring_damper(b=b), (effects.wave_variables(10, "20 ms"),))
    [x] = hs.simulate(scene, hs.sine("1 cm", 40)).estimates
    c, t = np.cosh(40j * 0.02), np.sinh(40j * 0.02)
    steady = 40j * (b * c + 10 * t) / (c + b / 10 * t)
    off = abs(x.simulated - steady)
    assert 1e-8 * abs(steady) < off <= x.error <= 40 * off


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_a_bank_of_relaxations_is_the_power_along_its_band(alpha: float) -> None:
    omegas = np.geomspace(1, 50, 40)
    rates, weights, spring, damper = rates_and_weights(alpha, (1, 50))
    value = [
        spring + damper * 1j * w + sum(g * 1j * w / (1j * w + r) for r, g in zip(rates, weights, strict=True))
        for w in omegas
    ]
    assert np.abs(np.array(value) / (1j * omegas) ** alpha - 1).max() < 1.5e-10


def test_an_estimate_agrees_within_its_error_and_is_left_open_where_the_closed_form_approximates() -> None:
    rows = (
        RecoveredResponse(5.0, 3 + 4j, 3 + 4j, 0.0),
        RecoveredResponse(6.0, 1 + 1j, 1 + 2j, 0.5),
        RecoveredResponse(6.0, 1 + 1j, 1 + 2j, 1.0),
        RecoveredResponse(7.0, 1 + 1j, 1 + 2j, 0.5, "nobody knows"),
    )
    assert [(x.difference, x.agrees) for x in rows] == [(0, True), (1, False), (1, True), (1, None)]
    scene = hs.Scene(SOFT)
    t = np.array([0.0, 0.5, 1.0])
    runs = [
        hs.Simulation(
            scene, hs.sine("2 cm", 5), t, 0.1 * t, k * (t - 0.25), 0.2 * t, 3 * t, own, ("kelvin-voigt",), (), ()
        )
        for k, own in ((1, rows[:1] + rows[3:]), (-2, rows[1:2]))
    ]
    assert [run.agrees for run in runs] == [True, False]
    document = Simulations(runs).to_dict()
    assert (document["time"], document["samples"], document["agrees"]) == ([0.0, 1.0], 6, False)
    assert document["force"] == {"least": -1.5, "most": 0.75}
    assert [(x["omega"], x["agrees"]) for x in document["estimates"]] == [(5, True), (7, None), (6, False)]
    assert runs[0].to_csv().splitlines()[1:] == [
        "0.0,0.0,-0.25,0.0,0.0",
        "0.5,0.05,0.25,0.1,1.5",
        "1.0,0.1,0.75,0.2,3.0",
    ]


# Motions


def test_derivatives_of_the_motions_are_those_of_finite_differences() -> None:
    t = np.linspace(0.05, 5, 150)
    for made in (hs.sine(1, 3), hs.multisine(1, [2, 3, 7]), hs.chirp(1, 1, 9, 6)):
        for k in range(10):
            high = made.derivatives(t + 1e-5, k)[k]
            low = made.derivatives(t - 1e-5, k)[k]
            exact = made.derivatives(t, k + 1)[k + 1]
            assert (high - low) / 2e-5 == pytest.approx(exact, abs=1e-5 * np.abs(exact).max())


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


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_several_sines_share_the_amplitude_with_schroeders_phases(count: int) -> None:
    omegas = [2 * n for n in range(count, 0, -1)]
    motion = hs.multisine("3 cm", omegas)
    t = motion.fade + np.linspace(0, 9, 200)
    known = sum(0.03 / count * np.sin(w * t - np.pi * n * (n + 1) / count) for n, w in enumerate(omegas))
    assert motion.derivatives(t, 0)[0] == pytest.approx(known, abs=1e-12)
    assert motion.fade == pytest.approx(np.pi)
    assert (motion.span, motion.name, motion.amplitude) == (
        (2, 2 * count),
        "sine" if count == 1 else "multisine",
        pytest.approx(0.03),
    )
    assert (motion.duration, motion.smoothness) == (None, 1000)
    assert all(
        motion.phasor(w) == pytest.approx(0.03 / count * np.exp(-1j * np.pi * n * (n + 1) / count))
        for n, w in enumerate(omegas)
    )


def test_a_fade_in_is_the_polynomial_step_with_seven_derivatives_that_vanish_at_its_ends() -> None:
    """x^8 times a binomial sum, or the integral of x^7 (1 - x)^7 over its whole; at rest before, and 1 after."""
    motion = hs.sine(1, 2)
    x = np.linspace(-0.2, 1.2, 141)
    t = np.pi * x
    step = special.betainc(8, 8, np.clip(x, 0, 1))
    density = np.clip(x * (1 - x), 0, 1) ** 7 / special.beta(8, 8) / np.pi
    wave, slope = np.sin(2 * t), 2 * np.cos(2 * t)
    found = motion.derivatives(t, 1)
    assert found[0] == pytest.approx(step * wave, abs=1e-12)
    assert found[1] == pytest.approx(step * slope + density * wave, abs=1e-11)


def test_frequencies_along_a_band_are_multiples_of_one_evenly_spread() -> None:
    for low, high, n in ((0, 15, 10), (6, 15, 5), (14, 15, 3), (3, 15, 1), (0, 9, 2)):
        found = band_frequencies(hs.Scene(SPRING, (), (low, high)), n)
        base = high / (2 * n)
        steps = [x / base for x in found]
        assert steps == pytest.approx([round(x) for x in steps], abs=1e-9)
        assert found == sorted(set(found))
        first = next(k for k in range(1, 2 * n + 1) if k * base >= low)
        assert len(found) == min(n, 2 * n + 1 - first)
        assert found[0] == pytest.approx(first * base)
        assert n == 1 or found[-1] == pytest.approx(high)
        assert len(steps) == 1 or np.ptp(np.diff(steps)) <= 1 + 1e-9


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


def sampled(path: Path, omega: float, dt: float = 0.01, count: int = 1000) -> Path:
    rows = [f"{i * dt:.6f},{np.sin(omega * i * dt):.12f}" for i in range(count)]
    path.write_text("\n".join(["t [s],x [mm]", *rows]), encoding="utf-8")
    return path


@pytest.mark.few(3)
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


def test_a_run_lasts_as_long_as_its_motion_or_as_is_asked() -> None:
    clocked = hs.Scene(SPRING, (effects.zero_order_hold("30 ms"),))
    hand = Recording(np.linspace(0, 0.31, 32), 0.002 * np.linspace(0, 1, 32) ** 6)
    for made, duration, end in (
        (hs.simulate(hs.Scene(SPRING), hand), None, 0.31), (hs.simulate(hs.Scene(SPRING), hand, duration=0.2234), 0.2234, 0.2234),
        (hs.simulate(hs.Scene(SPRING), hs.chirp("1 cm", 5, 9, 2.345)), None, 2.345), (hs.simulate(clocked, hs.sine("1 cm", 5), duration="1234 ms"), 1.234, 1.234),
    ):  # fmt: skip
        assert end - 0.005 < made.time[-1] < end, duration
    for bad in ("3 m", 0, "-1 s"):
        with pytest.raises(hs.SceneError, match="duration"):
            hs.simulate(hs.Scene(SPRING), hs.sine("1 cm", 5), duration=bad)


RESTING = {
    "a lag": (environments.mass_spring_damper("1.8", 15, 100), (effects.first_order_lag(9),), 100.0),
    "a mass on a cable": (environments.two_mass("0.5", 4, 200, "0.3", 3, 120), (effects.compliance(300, 5),), 120.0),
    "a delay in a loop": (environments.kelvin_voigt(200, 5), (effects.delay("50 ms"), effects.first_order_lag(40), effects.compliance(2000, 40)), 200 / 1.1),
    "wave variables": (environments.kelvin_voigt(200, 5), (effects.wave_variables(25, "20 ms"),), 200 * 1250 / 1450),
    "a clock": (environments.kelvin_voigt(200, 5), (effects.first_order_lag(40), effects.zero_order_hold("50 ms"), effects.first_order_lag(40)), 200.0),
    "a torn-off end": (environments.maxwell(100, 20), (effects.first_order_lag(30),), 0.0),
    "a sampled wall": (environments.kelvin_voigt(200, 5), (effects.sampled_loop("10 ms", "tustin", 1),), 200.0),
}  # fmt: skip


@pytest.mark.parametrize("name", RESTING)
def test_a_recording_that_stays_where_it_begins_has_the_force_of_long_rest(name: str) -> None:
    felt, between, stiffness = RESTING[name]
    run = hs.simulate(hs.Scene(felt, between), Recording(np.linspace(0, 0.3, 31), np.full(31, 0.002)))
    assert run.force == pytest.approx(0.002 * stiffness, rel=1e-9, abs=1e-12)
    assert run.displacement == pytest.approx(0.002, rel=1e-12)


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


@pytest.mark.slow
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
        return k * atan(s * tau)

    for scene, message in (
        (hs.Scene(MSD, (own_log(3),)), r"own-log: log\(s/3 \+ 1\) is not made of"),
        (
            hs.Scene(MSD, (own_advance(3),)),
            r"of own-advance only the chain matrix is known: .* must not need the future",
        ),
        (hs.Scene(MSD, (own_friction(3),)), r"own-friction: I cannot be simulated in time"),
        (hs.Scene(own_rubber(3, 1)), r"own-rubber: atan\(s\) is not made of"),
    ):
        with pytest.raises(hs.SceneError, match=message):
            hs.simulate(scene, hs.sine("1 cm", 5))


# What is refused


@pytest.mark.parametrize(
    ("scene", "motion", "message"),
    [
        (hs.Scene(environments.expression("1/(s - 2)")), ("5 cm", 5), r"unstable \(pole at 2 1/s\)"),
        (hs.Scene(MSD, (effects.second_order_lowpass(10, 0),)), ("5 cm", 5), r"unstable \(pole at -?0 ± 10j 1/s\)"),
        (hs.Scene(SOFT, (effects.delay("0.2 s"), effects.first_order_lag(50), effects.compliance(100))), ("5 cm", 5), r"unstable \(pole at 4\.5.*no steady motion"),
        (hs.Scene(MSD, (effects.series("1/(s - 2)"), effects.series("(s - 2)/(s + 5)"))), ("5 cm", 5), r"an unstable internal motion \(pole at 2 1/s\)"),
        (hs.Scene(SOFT, (effects.zero_order_hold("0.1 s"),)), ("5 cm", 40), r"zero-order-hold: 40 rad/s is not below its Nyquist frequency, 31.4"),
        (hs.Scene(MSD), ("3 deg", 5), r"motion: its unit is rotational, the scene translational"),
        (hs.Scene(environments.mass_spring_damper(m=hs.symbols("m"))), ("5 cm", 5), r"m = m is a symbol"),
        (hs.Scene(SOFT, (effects.zero_order_hold("1 ms"), effects.series("1 + s/50"))), ("5 cm", 5), r"zero-order-hold: .* jumps, and the scene differentiates it"),
        (hs.Scene(MSD, (effects.two_port("1", "0", "0", "0"),)), ("5 cm", 5), r"do not determine|infinite"),
    ],
)  # fmt: skip
def test_what_cannot_be_simulated_is_refused_by_name(scene: hs.Scene, motion: tuple[str, int], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.simulate(scene, hs.sine(*motion))


GOOD = "0,0\n1,1\n2,0\n3,1\n4,0\n5,0\n"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (GOOD.replace("3,1", "3,x"), 4, '"x" is not a number'), (GOOD.replace("3,1", "3,inf"), 4, "not a finite number"),
        (GOOD.replace("3,1", "2,1"), 4, "time does not increase"), (GOOD.replace("3,1", "3.51,1"), 4, "a gap of 1.51 s"),
        (GOOD.replace("3,1", "3"), None, "line 4 has 1 cells"), (GOOD.replace("2,0", "2,0,7"), None, "line 3 has 3 cells"),
        ("a,b,x\n" + GOOD.replace(",", ",1,"), None, "in columns t and x: there are a, b, x"),
        ("t [s],x [m]\n" + GOOD.replace("3,1", "3,x"), 5, '"x" is not a number'), ("t [s],x [N]\n" + GOOD, None, "is not a displacement"),
        ("t [s],x [mm\n" + GOOD, None, "write the unit in brackets"), ("0,1\n1,2\n", None, "at least 6"), ("", None, "there are no lines of numbers"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_recording_is_told_by_its_line(
    text: str, line: int | None, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(hs.SceneError) as stop:
        hs.recording(path)
    assert message in str(stop.value)
    assert line is None or f"line {line}: " in str(stop.value)


def test_linear_algebra_has_one_thread_while_it_simulates_and_the_users_number_after() -> None:
    limits = threadpoolctl.threadpool_limits
    seen: list[int] = []
    with limits(2, user_api="blas"):
        before = threads()
        hs.simulate(hs.Scene(MSD), hs.sine("1 cm", 5), duration=1, progress=lambda *_: seen.extend(threads()))
        with pytest.raises(hs.SceneError):
            hs.simulate(hs.Scene(environments.expression("1/(s - 2)")), hs.sine("1 cm", 5))
        assert (set(seen), threads()) == ({1}, before)


def threads() -> list[int]:
    return [x["num_threads"] for x in threadpoolctl.threadpool_info() if x["user_api"] == "blas"]


def test_the_command_smooths_a_recording_and_writes_the_force_in_time(tmp_path: Path, call: Any) -> None:
    hand, force = sampled(tmp_path / "hand.csv", 5, count=200), tmp_path / "force.csv"
    options = ("--motion", str(hand), "--lowpass", "8 Hz", "--lowpass-order", "2", "--force", str(force), "--json")
    status, out, err = call("simulate", "fu2019", *options)
    document, lines = json.loads(out), force.read_text(encoding="utf-8").splitlines()
    assert (status, err) == (0, f"force written to {force}\n")
    assert document["motion"]["lowpass"] == {"cutoff": pytest.approx(16 * np.pi), "order": 2, "phase": "zero"}
    assert lines[0] == "time [s],displacement [m],force [N],environment displacement [m],environment force [N]"
    assert len(lines) == 1 + document["samples"]
    rows = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert rows[:, 2].max() == document["force"]["most"]
    t, x = rows[:, 0], rows[:, 1]
    known = 1.8 * np.gradient(np.gradient(x, t), t) + 15 * np.gradient(x, t) + 100 * x
    assert rows[50:-50, 4] == pytest.approx(known[50:-50], abs=0.02 * np.abs(known).max())
    before = hand.read_bytes()
    status, out, err = call("simulate", "fu2019", "--motion", str(hand), "--force", str(hand))
    assert (status, out, hand.read_bytes() == before) == (2, "", True)
    assert "is read by this very call" in err


def test_the_command_compares_ten_frequencies_with_the_closed_form(call: Any) -> None:
    status, out, _ = call("simulate", "fu2019", "--check", "--json")
    document = json.loads(out)
    assert (status, document["agrees"], len(document["estimates"])) == (0, True, 10)
    for row in document["estimates"]:
        assert row["simulated"]["real"] == pytest.approx(row["closed"]["real"], rel=1e-6)
        assert row["difference"] <= row["error"]


def test_bounds_of_what_a_display_is_asked_for(tmp_path: Path) -> None:
    """What the options leave out follows from the scene, whose band ends at 12 rad/s."""
    scene = hs.Scene(SPRING, (), (0, 12))
    rubbing = hs.Scene(environments.kelvin_voigt(200, 5), (effects.coulomb_friction("1 N", "3 cm"),), (0, 12))
    plain = motion(scene, {})
    assert (plain.name, plain.omegas, plain.amplitude) == ("sine", (4.0,), 0.05)
    assert motion(rubbing, {}).amplitude == 0.03
    given = motion(scene, {"omega": "1 Hz", "amplitude": "2 cm"})
    assert (given.omegas, given.amplitude) == ((pytest.approx(2 * np.pi),), 0.02)
    many = motion(scene, {"kind": "multisine"})
    assert many.omegas == pytest.approx([0.6 * n for n in (1, 3, 5, 7, 9, 12, 14, 16, 18, 20)])
    assert motion(scene, {"kind": "multisine", "omega": "6"}).omegas == pytest.approx([x / 2 for x in many.omegas])
    sweep = motion(scene, {"kind": "chirp"})
    assert (sweep.span, sweep.duration) == ((0.6, 12), pytest.approx(200 * np.pi / 12))
    sweep = motion(scene, {"kind": "chirp", "omega": "20", "duration": "3 s"})
    assert (sweep.span, sweep.duration) == ((1, 20), 3)
    path = tmp_path / "hand.CSV"
    path.write_text("\n".join(f"{n / 100},{n % 7}" for n in range(100)), encoding="utf-8")
    assert motion(scene, {"kind": str(path)}).lowpass is None
    smooth = motion(scene, {"kind": str(path), "lowpass": "9 Hz"}).lowpass
    assert (smooth.cutoff, smooth.order) == (pytest.approx(18 * np.pi), 4)
    assert motion(scene, {"kind": str(path), "lowpass": "9 Hz", "lowpass_order": "6"}).lowpass.order == 6
    for options, said in (
        ({"kind": str(path), "amplitude": "1 cm"}, "leave out --amplitude"), ({"kind": "wiggle"}, "unknown motion"), ({"kind": "missing.csv"}, "no such file"),
        ({"lowpass": "9 Hz"}, "smooths a recorded motion"), ({"amplitude": "5 s"}, "not a displacement"),
    ):  # fmt: skip
        with pytest.raises(hs.SceneError, match=said):
            motion(scene, options)
    for key in ("omega", "duration", "quantise", "saturate", "lowpass"):
        with pytest.raises(hs.SceneError, match=f"leave out --{key}$"):
            run(scene, True, {key: "1"})  # noqa: FBT003
    [one] = run(scene, False, {"quantise": "3 mm", "saturate": "4 N", "duration": "0.01 s", "amplitude": "1 cm"})  # noqa: FBT003
    assert one.extras == (hs.EncoderQuantisation("3 mm"), hs.ForceSaturation("4 N"))


@pytest.mark.parametrize("between", [(), (effects.delay("37 ms"),)], ids=["at the hand", "late"])
def test_a_hand_at_rest_feels_no_friction_and_one_that_sets_out_the_right_way_at_once(
    tmp_path: Path, between: tuple[hs.Effect, ...]
) -> None:
    """Rest at 1 cm, a movement to -1 cm from 0.5 to 1 s, rest, and forth again from 2 s on."""
    t = np.arange(0, 3, 1e-3)

    def moved(start: float, length: float) -> Any:
        u = np.clip((t - start) / length, 0, 1)
        return 10 * u**3 - 15 * u**4 + 6 * u**5

    x = 0.01 - 0.02 * moved(0.5, 0.5) + 0.03 * moved(2, 1)
    path = tmp_path / "hand.csv"
    path.write_text("t [s],x [m]\n" + "\n".join(f"{a:.4f},{b!r}" for a, b in zip(t.tolist(), x.tolist(), strict=True)))
    scene = hs.Scene(environments.mass_spring_damper(k=100), (effects.coulomb_friction("1.5 N", "5 cm"), *between))
    run = hs.simulate(scene, hs.recording(path))
    friction = run.force - 100 * (run.environment_displacement if not between else np.interp(run.time - 0.037, t, x))
    at, late = run.time - (0.037 if between else 0), 2e-3
    for low, high, expected in ((0, 0.5, 0), (0.5, 1, -1.5), (1, 2, 0), (2, 2.9, 1.5)):
        inside = (at > low + late) & (at < high - late)
        assert friction[inside] == pytest.approx(np.full(inside.sum(), expected), abs=1e-4)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: hs.simulate("fu2019", hs.sine("5 cm", 10), limit=2),
        lambda: hs.check("fu2019", limit=9),
        lambda: hs.release("delayed-spring", "1 cm", "light-touch", limit=9),
        lambda: hs.identify(
            hs.sampled("fu2019", range(1, 20)), "mass-spring-damper", ["second-order-lowpass"], limit=3
        ),
    ],
    ids=["simulate", "check", "release", "identify"],
)
def test_what_takes_longer_than_its_limit_ends_in_time(ask: Any) -> None:
    with timed_by(count().__next__), pytest.raises(LimitError, match="the limit of"):  # a reading is a second
        ask()
