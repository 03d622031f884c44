"""Simulations, by laws: equations of motion against the closed form at complex frequencies, steps against exact solutions."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from refusals import refusal
from scipy import special
from sympy import Add, Expr, I, Mul, Pow, Rational, cosh, exp, pi, sinh

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.symbols import s
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS
from haptisym.verbs.simulate.command import motion, run
from haptisym.verbs.simulate.entry import _fractional_error, band_frequencies
from haptisym.verbs.simulate.events import Breaks, common_measure, first_event, guards
from haptisym.verbs.simulate.fractional import rates_and_weights
from haptisym.verbs.simulate.frictions import join_frictions
from haptisym.verbs.simulate.lockin import lock
from haptisym.verbs.simulate.network import MOTION, Network, SignalSum, Step, Switch, name_of
from haptisym.verbs.simulate.propagate import NODES, Propagator, Record, at_end, finer
from haptisym.verbs.simulate.recordings import Recording
from haptisym.verbs.simulate.rest import at_rest
from haptisym.verbs.simulate.results import Estimate, Simulations
from haptisym.verbs.simulate.run import build

SPRING = environments.mass_spring_damper(k=100)


# Equations of motion: with e^(st) for every signal they are linear equations, and the force over the motion is H_perc(s)


def solved(scene: hs.Scene, at: Any, span: tuple[float, float] = (1.0, 9.0)) -> tuple[Network, dict[str, Any], str]:
    """Every signal over the hand's motion at a complex frequency, from the equations that the blocks add up; the hand's force."""
    net = Network(span)
    port = build(net, scene)[-1]
    net.equal(port.X, SignalSum.of(MOTION))
    rows = [x.terms for x in net.equations]
    for hold in net.holds:  # what holds let through of a wave, but for its images
        T = mpmath.mpf(hold.period)
        held = (1 - mpmath.exp(-at * T)) / (at * T)
        rows.append({(hold.target, 0, 0): -1, (hold.source, 0, 0): held})
    rows += [  # 0.05 m of a sine against a square wave
        {(friction.target, 0, 0): -1, (friction.driver, 0, 0): 4 * friction.limit / (mpmath.pi * 0.05 * at.imag)}
        for friction in net.frictions
    ]
    names = list(dict.fromkeys(name for row in rows for name, _, _ in row if name != MOTION))
    place = {name: i for i, name in enumerate(names)}
    assert len(rows) == len(names)
    left, right = mpmath.zeros(len(names)), mpmath.zeros(len(names), 1)
    for i, row in enumerate(rows):
        for (name, order, lag), value in row.items():
            factor = real(value) * at**order * mpmath.exp(-at * real(lag))
            if name == MOTION:
                right[i] -= factor
            else:
                left[i, place[name]] += factor
    if len(names) > 60:  # the bank of a power of s: floats will do, each equation in its own units
        A, b = (np.array(x.tolist(), dtype=complex) for x in (left, right))
        units = np.abs(A).max(axis=1, keepdims=True)
        found = [complex(x) for x in np.linalg.solve(A / units, b / units)[:, 0]]
    else:
        found = list(mpmath.lu_solve(left, right))
    return net, dict(zip(names, found, strict=True)), name_of(port.F)


def quotient(scene: hs.Scene, at: Any) -> Any:
    """F/X at the hand."""
    _, signals, force = solved(scene, at)
    return signals[force]


def real(x: Any) -> Any:
    return (
        x
        if isinstance(x, mpmath.mpf | mpmath.mpc)
        else mpmath.mpf(int(x.p)) / int(x.q)
        if hasattr(x, "p")
        else mpmath.mpf(x)
    )


def closed(scene: hs.Scene, at: Any) -> Any:
    """H_perc(s), from one chain matrix after the other; with a clock in the loop from its formula."""
    if scene.effects and scene.effects[0].renders:
        return value(scene.distortion().perceived.xreplace({p.symbol: p.value for p in scene.parameters}), at)
    found = value(scene.environment.H, at)
    for effect in scene.effects:
        a, b, c, d = (value(x, at) for x in effect.matrix)
        found = (a * found + b) / (c * found + d)
    return found


def value(form: Expr, at: Any) -> Any:
    """A formula of s alone, at a complex number."""
    if form == s:
        return at
    if form.is_Rational:
        return mpmath.mpf(int(form.p)) / int(form.q)
    parts = [value(x, at) for x in form.args]
    if form in (pi, I):
        return +mpmath.pi if form == pi else mpmath.mpc(0, 1)
    if form.func in (Add, Mul):
        return mpmath.fsum(parts) if form.func is Add else mpmath.fprod(parts)
    return {Pow: mpmath.power, exp: mpmath.exp, cosh: mpmath.cosh, sinh: mpmath.sinh}[form.func](*parts)


DRAWN = random.Random(20)


def size(low: float = 0.2, high: float = 3.0) -> str:
    return f"{DRAWN.uniform(low, high):.3f}"


FELT: dict[str, Any] = {
    "mass-spring-damper": lambda: environments.mass_spring_damper(size(), size(1, 20), size(50, 300)),
    "kelvin-voigt": lambda: environments.kelvin_voigt(size(50, 300), size(1, 20)),
    "maxwell": lambda: environments.maxwell(size(50, 300), size(1, 20)),
    "zener": lambda: environments.zener(size(50, 300), size(50, 300), size(1, 20)),
    "prony": lambda: environments.prony(size(50, 300), [size(50, 300), size(50, 300)], [size(1, 20), size(20, 50)]),
    "spring-pot": lambda: environments.spring_pot(
        size(50, 90), DRAWN.choice(["0.3", "0.75"]), DRAWN.choice(["0", "50"])
    ),
    "two-mass": lambda: environments.two_mass(size(), size(1, 9), size(50, 300), size(), size(1, 9), size(50, 300)),
    "expression": lambda: environments.expression(
        "k*(s + 3)/(s + 20) + b*s + s^2*w/9", parameters={"k": size(50, 90), "b": size(1, 5), "w": "2 Hz"}
    ),
}
BETWEEN: dict[str, Any] = {
    "first-order-lag": lambda: effects.first_order_lag(size(20, 90)),
    "second-order-lowpass": lambda: effects.second_order_lowpass(size(20, 90), size(0.3, 2)),
    "delay": lambda: effects.delay(f"{size(3, 30)} ms"),
    "pade-delay": lambda: effects.pade_delay(f"{size(3, 30)} ms", DRAWN.randint(1, 3)),
    "zero-order-hold": lambda: effects.zero_order_hold(f"{size(3, 30)} ms"),
    "series": lambda: effects.series((1 + s / 50) * exp(-s / 20) / (1 + s / 5 + s**2 / 90) + s / (s + 3)),
    "shunt": lambda: DRAWN.choice([
        effects.shunt(m=size(), b=size(), k=size()), effects.shunt(m=size()), effects.shunt(Z="2*s + 300*s/(s + 5)"), effects.shunt(b=size()),
    ]),
    "compliance": lambda: DRAWN.choice([effects.compliance(size(500, 900), size(1, 9)), effects.compliance(size(500, 900)), effects.compliance(b=size(9, 20))]),
    "coulomb-friction": lambda: effects.coulomb_friction(f"{size()} N", "5 cm"),
    "admittance-display": lambda: effects.admittance_display("400/(s^2 + 30*s + 400)"),
    "wave-variables": lambda: effects.wave_variables(size(5, 20), f"{size(3, 30)} ms"),
    "position-force-teleoperator": lambda: effects.position_force_teleoperator(**devices(), **late()),
    "position-position-teleoperator": lambda: effects.position_position_teleoperator(**devices(), **master(), **late()),
    "four-channel-teleoperator": lambda: effects.four_channel_teleoperator(**devices(), **master(), **late()),
    "two-port": lambda: effects.two_port("0.8", "2*s", "0.001/(1 + s/9)", Rational(3, 2) - exp(-s / 8)),
}  # fmt: skip


def late() -> dict[str, str]:
    return DRAWN.choice([{}, {"tau": f"{size(3, 30)} ms"}])


def devices() -> dict[str, str]:
    return {"Mm": size(), "Ms": size(), "Bs": size(50, 90), "Ks": size(300, 900)}


def master() -> dict[str, str]:
    return {"Bm": size(9, 30), "Km": size(100, 200)}


@pytest.mark.parametrize("model", [*FELT, *BETWEEN])
def test_the_equations_of_motion_of_a_model_have_its_closed_form_for_their_quotient(model: str) -> None:
    """Alone, and between others; on the axis, where friction has a describing function and a power of s its bank, and beside it."""
    for n in range(2):
        if model in FELT:
            scene = hs.Scene(FELT[model](), (BETWEEN["compliance"](), BETWEEN["first-order-lag"]())[: 2 * n])
        else:
            chain = [BETWEEN[model]()]
            chain += [make() for make in DRAWN.sample([BETWEEN[x] for x in BETWEEN if x != model], 2 * n)]
            DRAWN.shuffle(chain)
            scene = hs.Scene(FELT[DRAWN.choice(["mass-spring-damper", "zener", "two-mass"])](), tuple(chain))
        bare = not any(x.model == "coulomb-friction" for x in scene.effects)
        with mpmath.workdps(40):
            at = mpmath.mpc(
                DRAWN.uniform(-0.5, 0.5) if n % 2 and bare and model != "spring-pot" else 0, DRAWN.uniform(1, 9)
            )
            own, known = quotient(scene, at), closed(scene, at)
            assert abs(own / known - 1) < (1e-9 if model == "spring-pot" else 1e-14), scene


def test_of_several_powers_of_s_the_worst_bank_counts_in_the_error() -> None:
    """Beyond its span a bank is worse; three times as far off as the exact power counts, relatively, at the worst frequency."""
    omegas, worst = np.array([2.0, 40.0, 700.0]), {}
    for alpha in (0.2, 0.5, 0.9):
        rates, weights, spring, damper = rates_and_weights(alpha, (1.0, 9.0))
        with mpmath.workdps(30):
            found = [
                spring + damper * s + mpmath.fsum(c * s / (s + r) for c, r in zip(weights, rates, strict=True))
                for s in (1j * mpmath.mpf(w) for w in omegas)
            ]
            worst[alpha] = max(
                float(abs(x / (1j * mpmath.mpf(w)) ** alpha - 1)) for x, w in zip(found, omegas, strict=True)
            )
    assert len({*worst.values()}) == 3
    for alphas in itertools.permutations(worst, 2):
        net = Network((1.0, 9.0), fractional=[(x, 1.0, 9.0) for x in alphas])
        assert _fractional_error(net, omegas) == pytest.approx(3 * max(worst[x] for x in alphas), rel=1e-6)
    assert _fractional_error(Network((1.0, 9.0)), omegas) == 0


def test_powers_of_s_in_one_formula_share_their_bank() -> None:
    felt = environments.expression(
        50 * s ** Rational(3, 10) + 20 * s ** Rational(3, 5) + 9 * exp(-s / 3) * s ** Rational(3, 10)
    )
    at = mpmath.mpc(0, 4)
    assert abs(quotient(hs.Scene(felt), at) / closed(hs.Scene(felt), at) - 1) < 1e-9


def test_every_model_of_the_catalogue_is_among_these() -> None:
    assert {*FELT, *BETWEEN, "sampled-loop"} == {*ENVIRONMENTS, *EFFECTS}


@pytest.mark.parametrize(("method", "samples"), [("backward-difference", 2), ("tustin", 1), ("forward-difference", 0)])
def test_a_sampled_controller_computes_its_difference_equation(method: str, samples: int) -> None:
    for felt in (
        environments.kelvin_voigt(200, 5),
        environments.expression("w*(s + 3)/(s + 20)", parameters={"w": "2 Hz"}),
        FELT["zener"](),
    ):
        if method == "forward-difference" and felt.model != "expression":
            continue  # it makes of b s what needs the future
        loop = effects.sampled_loop("30 ms", method, samples)
        scene = hs.Scene(felt, (loop, effects.shunt(m="0.2"), effects.delay("4 ms")))
        with mpmath.workdps(40):
            at = mpmath.mpc(-1, 3)
            assert abs(quotient(scene, at) / closed(scene, at) - 1) < 1e-14


# At rest


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
    """Every signal is what the equations say at s = 1e-30; and the run begins there, and stays."""
    felt, between, stiffness = RESTING[name]
    scene = hs.Scene(felt, between)
    with mpmath.workdps(120):
        net, signals, force = solved(scene, mpmath.mpc(mpmath.mpf(10) ** -30))
        known = {signal: float(x.real) for signal, x in signals.items()}
    found = at_rest(net, 0.5)
    assert set(found) == {*known, MOTION}
    assert found[MOTION] == 0.5
    for signal, ratio in known.items():
        assert found[signal] == pytest.approx(0.5 * ratio, rel=1e-9, abs=1e-9), signal
    assert known[force] == pytest.approx(stiffness, rel=1e-9, abs=1e-9)
    run = hs.simulate(scene, Recording(np.linspace(0, 0.3, 31), np.full(31, 0.002)))
    assert run.force == pytest.approx(0.002 * stiffness, rel=1e-9, abs=1e-12)
    assert run.displacement == pytest.approx(0.002, rel=1e-12)


def test_at_rest_steps_count_as_exact_friction_gives_no_force_and_a_limit_is_not_yet_met() -> None:
    friction = hs.Scene(
        environments.mass_spring_damper("0.5", 1, 20),
        (effects.coulomb_friction("1 N", "5 cm"), effects.compliance(200, 1)),
    )
    for scene, extras, force in (
        (hs.Scene(SPRING), [hs.EncoderQuantisation("3 mm")], 50.0),
        (hs.Scene(SPRING), [hs.ForceSaturation("3 N")], 50.0),
        (friction, [], 0.5 * 200 * 20 / 220),
    ):
        net = Network((1.0, 9.0))
        port = build(net, scene, extras)[-1]
        net.equal(port.X, SignalSum.of(MOTION))
        join_frictions(net)
        assert at_rest(net, 0.5)[name_of(port.F)] == pytest.approx(force, rel=1e-12)
    damper = Network((1.0, 9.0))
    x = SignalSum.of("x")
    damper.equal(x.d(), SignalSum.of(MOTION))
    with pytest.raises(hs.SceneError, match="where the scene does not come to rest"):
        at_rest(damper, 0.5)
    with pytest.raises(hs.SceneError, match="do not determine the motion"):
        at_rest(Network((1.0, 9.0), [x - x.d() - SignalSum.of("y")]), 0.5)
    with pytest.raises(hs.SceneError, match="no state of rest"):
        at_rest(Network((1.0, 9.0), [x - SignalSum.of("y"), x - SignalSum.of("y")]), 0.5)


# Friction, clocks and delays in time


def jenkins(x: Any, k: float, limit: float) -> Any:
    """A spring in a row with dry friction: the force after each small step, by return mapping."""
    force, found = 0.0, [0.0]
    for step in np.diff(x).tolist():
        force = min(max(force + k * step, -limit), limit)
        found.append(force)
    return np.array(found)


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


@pytest.mark.parametrize("lags", [("17", "4"), ("17.3",)])  # in one grid with the clock, and beside it
def test_a_held_force_that_comes_late_goes_through_a_lag_from_step_to_step_of_the_clock(lags: tuple[str, ...]) -> None:
    """Between steps the lag falls towards what is held, by exp(-40 t) of the difference."""
    between = (effects.zero_order_hold("50 ms"), *(effects.delay(f"{x} ms", name=f"line {x}") for x in lags))
    scene = hs.Scene(environments.kelvin_voigt(200, 5), (*between, effects.first_order_lag(40)))
    run = hs.simulate(scene, hs.sine("1 cm", 10), duration=1.5)
    x, v = run.motion.derivatives(0.05 * np.arange(31), 1)
    held, force, late = 200 * x + 5 * v, [0.0], sum(map(float, lags)) / 1000
    for u in held:
        force.append(u + (force[-1] - u) * np.exp(-40 * 0.05))
    n = np.floor((run.time - late) / 0.05 + 1e-12).astype(int)
    known = held[n] + (np.array(force)[n] - held[n]) * np.exp(-40 * (run.time - late - 0.05 * n))
    assert run.force == pytest.approx(np.where(n < 0, 0, known), abs=1e-9)


def end_of(run: hs.Simulation) -> float:
    """Of its last step, from the first and the last node of that."""
    first, last = run.time[-len(NODES)], run.time[-1]
    return float(first + (last - first) * (1 - NODES[0]) / (NODES[-1] - NODES[0]))


def test_a_run_ends_to_the_point_but_under_sines_alone_where_its_last_step_is_whole() -> None:
    """Steps of a sine are 0.9/omega; a recording, a chirp and a clock end when they are said to."""
    plain, clocked = hs.Scene(SPRING), hs.Scene(SPRING, (effects.zero_order_hold("30 ms"),))
    hand = Recording(np.linspace(0, 0.31, 32), 0.002 * np.linspace(0, 1, 32) ** 6)
    assert end_of(hs.simulate(plain, hand)) == pytest.approx(0.31, rel=1e-12)
    assert end_of(hs.simulate(plain, hand, duration=0.2234)) == pytest.approx(0.2234, rel=1e-12)
    assert end_of(hs.simulate(plain, hs.chirp("1 cm", 5, 9, 2.345))) == pytest.approx(2.345, rel=1e-12)
    assert end_of(hs.simulate(clocked, hs.sine("1 cm", 5), duration=1.2345)) == pytest.approx(1.2345, rel=1e-12)
    ended = end_of(hs.simulate(plain, hs.sine("1 cm", 5), duration=1.2345)) / 0.18
    assert ended == pytest.approx(7, rel=1e-12)  # 6.86 steps


def test_what_never_fades_is_waited_for_three_periods_and_no_more() -> None:
    """The staircase of an encoder has the same images in every window: one period fades in, five are two windows, and so on."""
    run = hs.simulate(hs.Scene(SPRING), hs.sine("1 cm", 5), extras=[hs.EncoderQuantisation("4 mm")])
    assert end_of(run) / (2 * np.pi / 5) < 1 + 5 + 3 + 1.5


def test_a_recording_can_be_differentiated_four_times_also_inside_of_a_fraction() -> None:
    hand = Recording(np.linspace(0, 0.3, 31), 0.002 * np.linspace(0, 1, 31) ** 6)
    for power, refused in ((2, False), (4, False), (5, True), (6, True)):
        scene = hs.Scene(environments.expression(f"100 + s^{power}/(s + 9)"))
        said = refusal(hs.simulate, scene, hand)
        assert said == (
            f"recording: the scene needs derivative {power} of the motion; a recording has 4" if refused else ""
        )


def test_at_most_three_elements_may_switch() -> None:
    rubbing = tuple(
        x
        for n in range(4)
        for x in (effects.coulomb_friction("1 N", "5 cm", name=f"r{n}"), effects.compliance(100 + n, name=f"c{n}"))
    )
    with pytest.raises(hs.SceneError, match="4 elements with friction or saturation: at most 3"):
        hs.simulate(hs.Scene(SPRING, rubbing), hs.sine("1 cm", 5))


# Steps


def test_steps_are_exact_for_inputs_that_are_polynomials() -> None:
    """z' = M z + N w, w of degree 7: what a polynomial makes is one, and the rest goes on by a matrix exponential."""
    rng = np.random.default_rng(4)
    for _ in range(4):
        n, degree = int(rng.integers(1, 4)), 7
        M, N = rng.normal(0, 1, (n, n)) - 4 * np.eye(n), rng.normal(0, 2, (n, 3))
        N[:, 2] = 0  # an input that moves nothing
        c = rng.normal(0, 1, (degree + 1, 3))
        c[1:, 1] = 0  # a steady one
        a = np.zeros((degree + 2, n))
        for k in range(degree, -1, -1):  # (k + 1) a_{k+1} = M a_k + N c_k
            a[k] = np.linalg.solve(M, (k + 1) * a[k + 1] - N @ c[k])
        start, h, steps = rng.normal(0, 1, n), 0.3, 3

        def exact(t: float, a: Any = a, M: Any = M, start: Any = start) -> Any:
            with mpmath.workdps(30):
                free = mpmath.expm(mpmath.matrix(M.tolist()) * float(t)) * mpmath.matrix((start - a[0]).tolist())
            return np.array([float(x) for x in free]) + sum(x * t**k for k, x in enumerate(a))

        times = h * (np.arange(steps)[:, None] + NODES)
        w = sum(x * times[..., None] ** k for k, x in enumerate(c))
        inside, after = Propagator(M, N, (1,)).march(start, w, h)
        assert after == pytest.approx(exact(steps * h), rel=1e-10, abs=1e-10)
        for i, k in ((0, 0), (1, 4), (2, 9)):
            assert inside[i, k] == pytest.approx(exact(times[i, k]), rel=1e-10, abs=1e-10)


def test_a_record_gives_polynomials_back_wherever_it_is_read() -> None:
    def f(t: Any) -> Any:
        return np.stack([1 + t - 0.3 * t**9, 2 * t**4], axis=-1)

    record = Record(2)
    record.before = np.array([5.0, -6.0])
    assert record.at(np.array([0.3, 2.0]), [1, 0]).tolist() == [[-6, 5], [-6, 5]]
    for start, h, steps in ((0.25, 0.1, 1500), (150.25, 0.5, 1)):  # more than are made room for at first
        times = start + h * (np.arange(steps)[:, None] + NODES)
        record.append(start, h, f(times / 100))
    t = np.array([0.25, 0.26, 0.35, 77.0, 150.2, 150.3, 150.75])
    assert record.count == 1501
    assert record.at(t, [0, 1]) == pytest.approx(f(t / 100), rel=1e-9)
    assert record.at(np.array([0.24999, 151.0]), [1])[:, 0] == pytest.approx([-6, f(np.array(1.5075))[1]])
    assert (record.instants[-1] == 150.25 + 0.5 * NODES).all()
    whole = (record.quadrature[..., None] * record.values[: record.count]).sum(axis=(0, 1))
    exact = (
        [100 * (x + x**2 / 2 - 0.03 * x**10) for x in (1.5075, 0.0025)],
        [100 * 0.4 * x**5 for x in (1.5075, 0.0025)],
    )
    assert whole == pytest.approx([a - b for a, b in exact], rel=1e-12)
    places = np.array([0.0, 0.5, 1.0])
    assert finer(record.values[:2, :, 0].ravel(), places) == pytest.approx(
        f((0.25 + 0.1 * np.array([0, 0.5, 1, 1, 1.5, 2])) / 100)[:, 0]
    )
    assert at_end(record.values[3]) == pytest.approx(f(np.array(0.0065)))


# The lock-in


def test_a_lock_in_finds_each_sine_beside_what_it_does_not_look_for() -> None:
    motion = hs.multisine("1 cm", [2, 3])
    period = 2 * np.pi / 2
    record = Record(1)
    times = 0.05 * period * (np.arange(200)[:, None] + NODES)
    phasors = {2: 3 - 2j, 3: -1 + 0.5j}

    def locked(extra: Any, length: float = 4, windows: int = 2, **more: Any) -> Any:
        y = sum((p * np.exp(1j * w * times)).imag for w, p in phasors.items()) + extra
        record.count = 0
        record.append(0.0, 0.05 * period, y[..., None])
        return lock(record, record.values[: record.count, :, 0], motion, length * period, windows, **more)

    known = [phasors[2], phasors[3]]
    clean = locked(7.0)
    assert clean.values == pytest.approx(known, abs=1e-9)
    assert (clean.drift < 1e-9).all()
    assert locked(np.sin(20 * times)).values == pytest.approx(known, abs=1e-4)
    bent = 0.3 * times**2 - times
    assert (
        np.abs(locked(bent, drift=True).values - known).max() < 1e-7 < 1e-4 < np.abs(locked(bent).values - known).max()
    )
    fading = np.exp(-0.1 * times) * np.sin(2 * times)
    moving = locked(fading)
    assert moving.drift[0] == pytest.approx(abs(moving.values[0] - known[0]) * (np.exp(0.1 * period) - 1), rel=0.02)
    assert moving.relative_drift == pytest.approx(moving.drift.max() / np.abs(moving.values).max())
    assert (locked(fading, windows=1).drift == 0).all()
    # ten periods, of which the first fades in: for nine there is one window and no room for two, for more there is none
    assert (locked(fading, length=9).drift == 0).all()
    assert (locked(fading, length=7).drift > 0).any()
    with pytest.raises(hs.SceneError, match=r"duration: 31\.4159 s are too short to recover H_perc; at least 32\.67"):
        locked(0, length=9.4)


# Events


def test_break_points_are_sums_of_up_to_four_delays_after_a_jump_in_their_order() -> None:
    for lags, jumps in (((0.25,), (0.0,)), ((0.25, 1.0), (0.5, 3.0)), ((), (1.0,))):
        breaks = Breaks(lags)
        for t in jumps:
            breaks.after(t)
        sums = {
            t + sum(x) for t in jumps for n in range(1, 5) for x in itertools.combinations_with_replacement(lags, n)
        }
        found, t = [], -1.0
        while coming := breaks.next(t):
            [t] = coming
            found.append(t)
        assert found == sorted(sums)
        assert breaks.next(t) == []


def test_a_common_measure_is_the_longest_time_that_divides_both() -> None:
    for a, b, c in (
        ("1/2", "1/3", "1/6"),
        ("3/4", "9/8", "3/8"),
        ("2", "6", "2"),
        ("7/10", "7/10", "7/10"),
        ("4/9", "2/15", "2/45"),
    ):
        assert common_measure(Fraction(a), Fraction(b)) == Fraction(c)


def test_the_first_event_is_where_a_guard_falls_below_zero_and_which() -> None:
    """Signals are straight lines and parabolas, whose zeros are known."""
    motion = hs.sine("1 cm", 5)
    friction = Switch("f", SignalSum({}), "v", 2.0, 0.0, "friction")
    limit = Switch("g", SignalSum({}), "w", 3.0, 3.0, "limit")
    step = Step("x", "y", 0.5, "encoder")
    names = ["f", "v", "g", "w", "x"]
    calm = {"f": 0.0, "v": 1.0, "g": 0.0, "w": 9.0, "x": 1.0}
    net = Network((1.0, 1.0), switches=[friction, limit], steps=[step])
    times = np.arange(4)[:, None] + NODES

    def event(modes: tuple[int, int], **moving: Any) -> tuple[float, str, str] | None:
        values = np.stack([np.broadcast_to(moving.get(x, calm[x]) + 0.0 * times, times.shape) for x in names], axis=-1)
        found = first_event(guards(net, modes, {"y": 1.0}), values, lambda name, _: names.index(name), motion)
        return found and (found[0] + found[1], found[2].element.name, found[2].reading[0])

    assert event((0, 0)) is None
    assert event((1, 1)) is None
    at = pytest.approx
    assert event((0, 0), f=times) == (at(2.0), "friction", "f")  # stuck: until the force is beyond 2
    assert event((0, 0), f=-0.8 * times) == (at(2.5), "friction", "f")
    assert event((1, 0), v=1.7 - times) == (at(1.7), "friction", "v")  # slipping: until the velocity is back at 0
    assert event((-1, 0), v=times**2 - 1.21) == (at(1.1), "friction", "v")
    assert event((1, 0), v=-1 - times) == (0.0, "friction", "v")
    assert event((0, 0), g=3.5 * times - 1) == (at(4 / 3.5), "limit", "g")  # until the force is beyond 3
    assert event((0, 1), w=4 - times) == (at(1.0), "limit", "w")  # cut off: until what is wanted is below 3 again
    assert event((0, -1), w=times - 5.5) == (at(2.5), "limit", "w")
    assert event((0, 0), x=1 + times / 8) == (at(2.0), "encoder", "x")  # until it is half a step off
    assert event((0, 0), x=1 - times / 5) == (at(1.25), "encoder", "x")
    assert event((0, 0), x=1 - times / 5, f=1.9 * times) == (at(2 / 1.9), "friction", "f")
    assert event((0, 0), x=1 - times / 5, f=1.5 * times) == (at(1.25), "encoder", "x")


# Motions


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
        ({"kind": str(path), "amplitude": "1 cm"}, "has its own amplitude"), ({"kind": str(path), "omega": "3"}, "has its own amplitude"),
        ({"kind": "wiggle"}, '"wiggle" is none of'), ({"lowpass": "9 Hz"}, "smooths a recorded motion"),
    ):  # fmt: skip
        with pytest.raises(hs.SceneError, match=said):
            motion(scene, options)
    for key in ("omega", "duration", "quantise", "saturate", "lowpass", "kind"):
        with pytest.raises(hs.SceneError, match=f"leave out --{'motion' if key == 'kind' else key}$"):
            run(scene, True, {key: "chirp" if key == "kind" else "1"})  # noqa: FBT003
    [one] = run(scene, False, {"quantise": "3 mm", "saturate": "4 N", "duration": "0.01 s", "amplitude": "1 cm"})  # noqa: FBT003
    assert one.extras == (hs.EncoderQuantisation("3 mm"), hs.ForceSaturation("4 N"))
    [one] = run(scene, False, {"duration": "0.01 s"})  # noqa: FBT003
    assert (one.extras, one.time[-1] < 0.3) == ((), True)
    [checked] = run(scene, True, {"kind": "sine", "amplitude": "2 cm"})  # noqa: FBT003
    assert (len(checked.estimates), checked.motion.amplitude) == (10, pytest.approx(0.02))


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


# What a run hands over


def fabricated(
    scene: hs.Scene, *estimates: Estimate, name: str = "sine", scale: float = 1.0, notes: tuple[str, ...] = ()
) -> hs.Simulation:
    t = np.array([0.0, 0.5, 1.0])
    made = replace(hs.sine("2 cm", 5), name=name)
    return hs.Simulation(
        scene, made, t, 0.1 * t, scale * (t - 0.25), 0.2 * t, 3 * t, estimates, ("kelvin-voigt",), (), notes
    )


def test_runs_of_one_scene_are_one_document() -> None:
    scene = hs.Scene(environments.kelvin_voigt(200, 5))
    good, bad = Estimate(5.0, 3 + 4j, 3 + 4j, 0.0), Estimate(6.0, 1 + 1j, 1 + 2j, 0.5)
    open_ = Estimate(7.0, 1 + 1j, 1 + 2j, 0.5, "nobody knows")
    assert [(x.difference, x.agrees) for x in (good, bad, open_)] == [(0, True), (1, False), (1, None)]
    assert replace(bad, error=1.0).agrees is True
    one, two = fabricated(scene, good, open_), fabricated(scene, bad, scale=-2.0)
    assert (one.agrees, two.agrees, fabricated(scene, open_).agrees, fabricated(scene).agrees) == (
        True,
        False,
        None,
        None,
    )
    both = Simulations([one, two])
    document = both.to_dict()
    assert document["motion"] == {"kind": "sine", "amplitude": 0.02, "omega": [5.0, 5.0]}
    assert (document["time"], document["samples"], document["built"]) == ([0.0, 1.0], 6, ["kelvin-voigt"])
    assert document["force"] == {"least": -1.5, "most": 0.75}
    assert document["agrees"] is False
    assert [x["omega"] for x in document["estimates"]] == [5.0, 7.0, 6.0]
    assert document["estimates"][1] == {
        "omega": 7.0, "simulated": {"real": 1.0, "imag": 1.0}, "closed": {"real": 1.0, "imag": 2.0}, "difference": 1.0,
        "error": 0.5, "agrees": None, "approximate": "nobody knows",
    }  # fmt: skip
    assert "approximate" not in document["estimates"][0]
    assert "notes" not in document
    assert fabricated(scene, notes=("mind this",)).to_dict()["notes"] == ["mind this"]
    assert fabricated(scene, open_).to_dict()["agrees"] is None
    assert (repr(both), repr(one)) == (
        '<Simulations "Untitled scene": 2 runs>',
        '<Simulation "Untitled scene": sine, 2 frequencies>',
    )
    assert (both.certified, one.certified, both.runs, one.runs, both.scene) == (False, False, (one, two), (one,), scene)
    assert one.to_csv().splitlines() == [
        "time [s],displacement [m],force [N],environment displacement [m],environment force [N]",
        "0.0,0.0,-0.25,0.0,0.0", "0.5,0.05,0.25,0.1,1.5", "1.0,0.1,0.75,0.2,3.0",
    ]  # fmt: skip
    assert one.to_csv().endswith("3.0\n")


@pytest.mark.parametrize(
    ("between", "made", "said"),
    [
        ((effects.coulomb_friction("1 N", "5 cm"),), ("5 cm", [5]), ""),
        ((effects.coulomb_friction("1 N", "5 cm"),), ("5 cm", [5, 10]), "coulomb-friction: a describing function holds for one sine, not for several"),
        ((effects.coulomb_friction("1 N", "5 cm"),), ("2 cm", [5]), "coulomb-friction: its describing function is for an amplitude of 0.05, the hand moves by 0.02"),
        ((effects.coulomb_friction("1 N", "5 cm"), effects.compliance(900)), ("5 cm", [5]), "coulomb-friction does not move as the hand does: its describing function is an approximation"),
        ((effects.compliance(900), effects.coulomb_friction("1 N", "5 cm")), ("5 cm", [5]), ""),
        ((effects.coulomb_friction("1 N", "5 cm"), effects.zero_order_hold("30 ms")), ("5 cm", [5]), "zero-order-hold samples what jumps or comes back to it: its images count, the closed form has the base band"),
        ((effects.zero_order_hold("30 ms"), effects.coulomb_friction("1 N", "5 cm")), ("5 cm", [5]), ""),
        ((effects.zero_order_hold("30 ms"), effects.shunt(m=1), effects.compliance(900, 30)), ("5 cm", [5]), "zero-order-hold samples what jumps or comes back to it: its images count, the closed form has the base band"),
    ],
)  # fmt: skip
def test_where_the_closed_form_approximates_the_reason_is_told(
    between: tuple[hs.Effect, ...], made: tuple[str, list[int]], said: str
) -> None:
    scene = hs.Scene(environments.kelvin_voigt(200, 5), between)
    estimates = hs.simulate(scene, hs.multisine(*made), duration=9).estimates
    assert {x.approximate for x in estimates} == {said}
    assert all(x.agrees is (None if said else True) for x in estimates)


def test_quantised_or_cut_off_the_closed_form_is_another_thing() -> None:
    [x] = hs.simulate(hs.Scene(SPRING), hs.sine("5 cm", 5), extras=[hs.ForceSaturation("50 N")], duration=9).estimates
    assert (x.approximate, x.agrees) == ("the closed form knows no quantisation and no saturation", None)
    for extra, said in (
        (hs.EncoderQuantisation("1 deg"), "resolution of the encoder: its unit is rotational"),
        (hs.ForceSaturation("1 N*m"), "limit of the force: its unit is rotational"),
    ):
        with pytest.raises(hs.SceneError, match=said):
            hs.simulate(hs.Scene(environments.kelvin_voigt("200 N/m", 5)), hs.sine(1, 5), extras=[extra])


@pytest.mark.parametrize(
    ("Z", "names"), [("m*s", {"m": 2}), ("b*s^2 + k", {"b": "1/2", "k": 3}), ("k*s/(1 + s/b)", {"k": 2, "b": 9})]
)
def test_the_numbers_of_a_shunt_s_formula_are_what_the_formula_says_whatever_they_are_called(
    Z: str, names: dict[str, object]
) -> None:
    scene = hs.Scene(hs.environments.kelvin_voigt(100, 2), (hs.effects.shunt(Z=Z, parameters=names),))
    [own] = hs.check(scene, count=2)
    assert own.agrees
