"""Compiled functions: what each level of accuracy promises, against the chain matrices in ball arithmetic at 1000 bits."""

from __future__ import annotations

import doctest
import itertools
import random
import sys
from collections import Counter
from collections.abc import Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from chainballs import BITS, error_in_ulps, truth
from flint import fmpq
from marks import QUICK_SCENES, often, required
from sympy import Expr, Rational, Symbol, exp, pi, sinc

import haptisym as hs
from haptisym.effects import (
    compliance,
    coulomb_friction,
    delay,
    first_order_lag,
    position_force_teleoperator,
    second_order_lowpass,
    series,
    shunt,
    two_port,
    wave_variables,
    zero_order_hold,
)
from haptisym.environments import expression, kelvin_voigt, mass_spring_damper, spring_pot, zener
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega as axis_omega
from haptisym.kernel.symbols import s
from haptisym.model.distortion import Distortion
from haptisym.programs import floats, machine, stable
from haptisym.programs import sinc as sinc_in_floats
from haptisym.programs.certified import Certified, ProgramValue
from haptisym.programs.doubled import Doubled
from haptisym.programs.floats import Floats
from haptisym.programs.pointvalues import PointValue
from haptisym.programs.program import Operation, Program, Writer
from haptisym.programs.values import Values, _decimal

NUMBA = "Numba, of the extra fast,"
RATIOS = ("ratio_real", "ratio_imag")
m, b, k, omega_n, zeta = hs.symbols("m b k omega_n zeta")
omega_2, zeta_2, omega_c, m_d, k_c, tau = hs.symbols("omega_2 zeta_2 omega_c m_d k_c tau")
MSD = mass_spring_damper(m, b, k)
FILTER = second_order_lowpass(omega_n, zeta)

FAMILIES: dict[str, Distortion] = {
    "filter": hs.distort(MSD, FILTER),
    "two filters and a lag": hs.distort(MSD, FILTER, second_order_lowpass(omega_2, zeta_2), first_order_lag(omega_c)),
    "filter and device mass": hs.distort(MSD, FILTER, shunt(m=m_d)),
    "lag and compliance": hs.distort(kelvin_voigt(k, b), first_order_lag(omega_c), compliance(k=k_c)),
    "delay": hs.distort(MSD, delay(tau)),
}
SHARES = {
    "filter": 0.5,
    "two filters and a lag": 0.2,
    "filter and device mass": 0.15,
    "lag and compliance": 0.1,
    "delay": 0.05,
}


def drawn(distortion: Distortion, count: int, seed: int) -> tuple[Any, dict[str, Any]]:
    """Frequencies and parameters over 18 decades, dampings over 5; a third of the frequencies close to a resonance."""
    rng = np.random.default_rng(seed)
    names = sorted(x.name for x in distortion.free_symbols)
    low, high = {"z": (-4, 1), "t": (-9, 0)}, 9
    values = {n: 10 ** rng.uniform(*(low.get(n[0], (-9, high))), count) for n in names}
    omega = 10 ** rng.uniform(-9, 9, count)
    near = np.sqrt(values["k"] / values.get("m", values["b"]))
    close = rng.random(count) < 1 / 3
    omega[close] = np.clip(near * (1 + 10 ** rng.uniform(-15, -1, count)), 1e-9, 1e9)[close]
    return omega, values


def errors(distortion: Distortion, accuracy: str, count: int, seed: int, of: Sequence[str] = Values._fields) -> Any:
    omega, values = drawn(distortion, count, seed)
    found = distortion.compile(accuracy, of)(omega, **values)
    return against_truth(distortion, omega, values, {name: getattr(found, name) for name in of})


def against_truth(
    distortion: Distortion, omega: Any, values: dict[str, Any], found: dict[str, Any], bits: int = BITS
) -> Any:
    rows = []
    for i, w in enumerate(omega):
        true = truth(distortion.chain, float(w), {name: float(x[i]) for name, x in values.items()}, bits)
        rows.append([error_in_ulps(float(x[i]), true[name], bits) for name, x in found.items()])
    return np.array(rows)


@pytest.mark.parametrize("count", [2_000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", FAMILIES)
def test_certified_values_are_within_one_unit_of_the_last_place(family: str, count: int) -> None:
    of = RATIOS if family == "filter" else (*RATIOS, "real", "relative_imag", "perceived_real")
    found = errors(FAMILIES[family], "certified", int(count * SHARES[family]), count, of)
    assert found.max() <= 1.0


@pytest.mark.parametrize("name", often(hs.scene_names(), QUICK_SCENES.__contains__))
@pytest.mark.parametrize("symbolic", [False, True])
def test_every_shipped_scene_is_certified(name: str, symbolic: bool) -> None:  # noqa: FBT001
    scene = hs.load_scene(name)
    d = scene.symbolic_distortion() if symbolic else scene.distortion()
    given = {p.symbol.name: float(p.value) for p in scene.parameters} if symbolic else {}
    values = {x.name: np.full(12, given[x.name]) for x in d.free_symbols}
    omega = np.geomspace(1e-4, 1e4, 12)
    found = d.compile("certified")(omega, **values)._asdict()
    assert against_truth(d, omega, values, found).max() <= 1.0


def test_double_doubles_stay_below_one_unit_where_the_chain_is_rational() -> None:
    for family in ("filter", "two filters and a lag", "filter and device mass"):
        assert errors(FAMILIES[family], "double-double", 150, 7).max() <= 1.0


def test_floats_of_the_structured_form_keep_their_digits_and_those_of_the_difference_do_not() -> None:
    d = FAMILIES["filter"]
    omega, values = drawn(d, 400, 3)
    fast = d.compile("fast", RATIOS)(omega, **values)
    naive = naive_ratios(omega, **values)
    ours, theirs = (against_truth(d, omega, values, x) for x in (fast._asdict(), naive))
    # what is left is the light resonance, where k - m omega^2 cancels in any float
    assert np.median(ours) < 2
    assert np.mean(ours <= 16) > 0.8
    assert np.mean(theirs <= 16) < 0.7
    assert np.quantile(theirs, 0.9) > 1e10


def test_the_difference_of_the_dynamics_breaks_the_bound_that_certified_values_keep() -> None:
    d = hs.load_scene("fu2019").distortion()
    omega = np.geomspace(1e-7, 1e-3, 50)
    given = {"m": 1.8, "b": 15.0, "k": 100.0, "omega_n": 80.0, "zeta": 0.5}
    assert against_truth(d, omega, {}, d.compile("certified", RATIOS)(omega)._asdict()).max() <= 1.0
    assert against_truth(d, omega, {}, d.compile("fast", RATIOS)(omega)._asdict()).max() <= 8.0
    assert against_truth(d, omega, {}, naive_ratios(omega, **given)).max() > 1e12


def test_a_program_of_the_naive_form_loses_its_digits_in_floats_and_is_still_proven(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bounds do not trust the form: what cancels is left to balls, point by point."""
    written = stable.Author.results

    def naively(author: Any, H: Any, felt: Any, fraction: Any, relative: Any) -> Any:
        return written(author, H, felt, (author.minus(felt, H), author.write.constant(1)), None)

    monkeypatch.setattr(stable.Author, "results", naively)
    chain = hs.load_scene("fu2019").chain  # fresh: no program of it has been written yet
    values = {p.symbol: p.value for p in hs.load_scene("fu2019").parameters}
    d = Distortion.of(chain.at(values))
    omega = np.geomspace(1e-12, 1e-3, 60)
    assert against_truth(d, omega, {}, d.compile("fast", RATIOS)(omega)._asdict()).max() > 1e12
    proven = d.compile("certified", RATIOS)
    assert against_truth(d, omega, {}, proven(omega)._asdict()).max() <= 1.0
    assert proven.certified.run([omega], omega.size)[1] > 10


def naive_ratios(omega: Any, *, m: Any, b: Any, k: Any, omega_n: Any, zeta: Any) -> dict[str, Any]:
    """As one would write it: H G - H in complex floats."""
    s = 1j * omega
    H = m * s**2 + b * s + k
    d = H * (omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)) - H
    return {"ratio_real": abs(d.real) / abs(H), "ratio_imag": abs(d.imag) / abs(H)}


def test_a_cascade_is_accurate_far_below_and_far_above_its_poles() -> None:
    d = hs.distort(mass_spring_damper(1.8, 15, 100), *[second_order_lowpass(80, 0.5)] * 6)
    omega = np.array([1e-8, 1e-5, 1e-2, 1e4, 1e7, 1e9])
    assert against_truth(d, omega, {}, d.compile("fast")(omega)._asdict()).max() < 400


# --- limits, poles, range --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_limits_at_rest_and_at_a_cancelled_resonance_are_values(accuracy: str) -> None:
    free = hs.distort(mass_spring_damper(m=2, b=3), series("2")).compile(accuracy)
    assert free(0.0).ratio_imag == 1.0
    assert free([0.0]).ratio_real.tolist() == [0.0]
    lossless = hs.distort(mass_spring_damper(m=1, k=4), first_order_lag(2)).compile(accuracy, RATIOS)
    assert lossless(2.0).ratio_real == 0.5
    assert lossless(2.0).ratio_imag == 0.5
    late = hs.distort(mass_spring_damper(m=1, b=1), delay("0.5 s")).compile(accuracy, RATIOS)
    assert late([0.0, 1.0]).ratio_real[0] == 0.0


def test_a_limit_that_only_the_given_parameters_make_is_found() -> None:
    f = hs.distort(MSD, first_order_lag(omega_c)).compile("certified", ["ratio_real"])
    assert f(2.0, m=1.0, b=0.0, k=4.0, omega_c=2.0).ratio_real == 0.5
    assert f([0.0], m=1.0, b=0.0, k=0.0, omega_c=2.0).ratio_real.tolist() == [0.0]


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_poles_are_infinite_and_frequencies_that_are_none_give_none(accuracy: str) -> None:
    f = hs.distort(mass_spring_damper(m=1, k=4), shunt(k=1)).compile(accuracy, ["ratio_real", "environment_real"])
    found = f([2.0, np.nan, np.inf])
    assert found.ratio_real[0] == np.inf
    assert np.isnan(found.ratio_real[1:]).all()
    assert found.environment_real[0] == 0.0


def test_a_fractional_environment_has_its_limit_at_rest() -> None:
    f = hs.distort(expression("k_a*s^0.5", parameters={"k_a": 2}), delay("1 s"), first_order_lag(3)).compile(of=RATIOS)
    assert f([0.0]).ratio_real.tolist() == [0.0]
    assert f([0.0]).ratio_imag.tolist() == [0.0]


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_at_negative_frequencies_dynamics_are_conjugate(accuracy: str) -> None:
    f = hs.distort(expression("2*s^0.5 + s", parameters={}), first_order_lag(3)).compile(accuracy)
    below, above = f(-2.0), f(2.0)
    assert (below.real, below.imag, below.ratio_imag) == (above.real, -above.imag, above.ratio_imag)
    with pytest.raises(hs.SceneError, match="must be >= 0"):
        f.digits(-2.0, 5)


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_no_representable_result_is_lost_to_overflow_or_underflow(accuracy: str) -> None:
    d = hs.distort(mass_spring_damper(1.8, 15, 100), *[second_order_lowpass("8e7 rad/s", 0.5)] * 10)
    omega = np.array([1e-300, 1e-150, 1e-9, 1e8, 1e20, 1e150])
    found = d.compile(accuracy, (*RATIOS, "relative_real", "perceived_real"))(omega)
    assert np.isfinite(found).all()
    worst = against_truth(d, omega, {}, found._asdict(), bits=9000).max()
    assert worst <= (1.0 if accuracy != "fast" else 400)


def test_results_beyond_the_range_of_doubles_are_infinite_or_zero() -> None:
    f = hs.distort(mass_spring_damper(m=1, k=1), first_order_lag(1)).compile(
        "certified", ["environment_real", "relative_real"]
    )
    assert f(1e200).environment_real == -np.inf
    assert f(1e-200).relative_real == 0.0


# --- shape, fields, choices ------------------------------------------------------------------------------------------


def test_the_fields_asked_for_are_what_comes_back_in_that_order() -> None:
    d = hs.load_scene("fu2019").distortion()
    found = d.compile(of=("ratio_imag", "real"))([1.0, 2.0])
    assert found._fields == ("ratio_imag", "real")
    whole = d.compile()([1.0, 2.0])
    assert isinstance(whole, Values)
    assert (found.ratio_imag == whole.ratio_imag).all()
    assert d.compile(of="imag")(1.0)._fields == ("imag",)


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 3), (0,), (2, 0), (1, 1)])
def test_the_shape_is_kept(accuracy: str, shape: tuple[int, ...]) -> None:
    found = hs.distort(kelvin_voigt(100, 2), first_order_lag(20)).compile(accuracy)(np.ones(shape))
    assert {x.shape for x in found} == {shape}


def test_parameters_broadcast_with_frequencies() -> None:
    f = FAMILIES["filter"].compile("certified", ["imag"])
    given = {"m": 1.8, "b": 15.0, "k": np.array([[100.0], [200.0]]), "omega_n": 80.0, "zeta": 0.5}
    found = f([1.0, 2.0, 3.0], **given).imag
    assert found.shape == (2, 3)
    assert found[1, 2] == f(3.0, **{**given, "k": 200.0}).imag


def test_parameters_of_effects_that_cancel_each_other_are_not_asked_for() -> None:
    d = hs.distort(mass_spring_damper(k=k), two_port("1 + m_d*s", "0", "0", "1 + m_d*s", parameters={"m_d": m_d}))
    f = d.compile()
    assert f.parameters == ("k",)
    assert f([1.0, 2.0], k=3.0).ratio_real.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"accuracy": "exactly"}, "'exactly' is none of fast, double-double, certified"),
        ({"of": ["ratio"]}, "ratio must be some of real, imag, ratio_real"),
        ({"of": ["real", "real"]}, "each once"),
        ({"of": []}, "nothing must be some of"),
        ({"engine": "gpu"}, "'gpu' is none of numpy, numba"),
    ],
)
def test_a_wrong_choice_lists_the_right_ones(choice: dict[str, Any], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.load_scene("fu2019").distortion().compile(**choice)


def test_arguments_that_are_no_numbers_or_do_not_fit_are_named() -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(20)).compile()
    with pytest.raises(hs.SceneError, match=r"omega: \['fast'\] must be real numbers"):
        f(["fast"], k=1.0)
    with pytest.raises(hs.SceneError, match=r"do not broadcast: omega \(2,\), k \(3,\)"):
        f([1.0, 2.0], k=[1.0, 2.0, 3.0])


def test_a_level_is_a_member_or_its_name() -> None:
    d = hs.load_scene("fu2019").distortion()
    assert d.compile(hs.Accuracy.CERTIFIED).accuracy is d.compile("certified").accuracy is hs.Accuracy.CERTIFIED


# --- digits ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [5, 17, 25, 60, 400])
@pytest.mark.parametrize("points", [3, 40])
def test_digits_are_those_of_the_truth_correctly_rounded(count: int, points: int) -> None:
    d = FAMILIES["filter"]
    omega, values = drawn(d, points, count)
    found = d.compile(of=RATIOS).digits(omega, count, **values)
    for i, w in enumerate(omega):
        true = truth(d.chain, float(w), {name: float(x[i]) for name, x in values.items()}, bits=4000)
        for name in RATIOS:
            assert Decimal(getattr(found, name)[i]) == _rounded(true[name], count), (name, w)
    assert found.seconds > 0
    expected = "double-double" if points == 40 and count <= 25 else "ball arithmetic"
    assert expected in found.method


def _rounded(ball: Any, count: int) -> Decimal:
    mantissa, exponent = ball.mid().man_exp()
    exact = int(mantissa) * Fraction(2) ** int(exponent)
    return Context(prec=count, rounding=ROUND_HALF_EVEN).divide(Decimal(exact.numerator), Decimal(exact.denominator))


def test_digits_of_special_values_and_of_single_numbers() -> None:
    f = hs.distort(mass_spring_damper(m=1, k=4), shunt(k=1)).compile()
    found = f.digits(2.0, 12)
    assert (found.ratio_real, found.environment_real, found.real, found.imag) == ("inf", "0", "1.00000000000", "0")
    half = hs.distort(mass_spring_damper(m=1, k=4), first_order_lag(2)).compile(of=RATIOS).digits([[2.0]], 3)
    assert half.ratio_real.tolist() == [["0.500"]]
    tie = hs.distort(mass_spring_damper(k=1), series("5/4")).compile(of="perceived_real").digits(1.0, 2)
    assert tie.perceived_real == "1.2"  # 1.25: to the even digit
    with pytest.raises(hs.SceneError, match="whole number, at least 1"):
        f.digits(1.0, 0)


@pytest.mark.parametrize("engine", often(["numpy", "numba"], "numpy".__eq__))
def test_a_sample_and_hold_keeps_its_digits_far_below_its_sampling_rate(engine: str) -> None:
    """Where r_r is (omega T)^2/6: the difference sin(x)/x - 1 would lose all its digits."""
    if engine == "numba":
        required(NUMBA, find_spec("numba"))
    spring, hold = mass_spring_damper(k=100), zero_order_hold("1 ms")
    for effects in ((hold,), (hold, zero_order_hold("2 ms", name="second")), (hold, delay("0.3 ms")), None):
        d = (hs.Scene(spring, effects) if effects else hs.load_scene("sampled-wall")).distortion()
        omega = np.geomspace(1e-12, 300, 60)
        found = d.compile(of=RATIOS, engine=engine)(omega)._asdict()
        assert against_truth(d, omega, {}, found).max() <= 16.0


# --- blocks and buffers ----------------------------------------------------------------------------------------------

IN, OTHER, THIRD = Symbol("x"), Symbol("y"), Symbol("z")
UNARY, BINARY = ("neg", "abs", "sqrt", "cos", "sin", "sinc", "sincm1"), ("add", "sub", "mul", "div", "power")


def any_program(seed: int) -> Program:
    """Up to thirty steps, some results the same step, an input or a constant; whatever may share a buffer."""
    pick = random.Random(seed)
    steps = [Operation("input", (n,)) for n in range(3)] + [
        Operation("constant", (), fmpq(3, 7)),
        Operation("constant", (), pi),
    ]
    for _ in range(pick.randint(1, 30)):
        recent = range(max(0, len(steps) - pick.choice((3, 30))), len(steps))
        name = pick.choice(UNARY + BINARY)
        steps.append(Operation(name, tuple(pick.choice(recent) for _ in range(1 if name in UNARY else 2))))
    results = {f"r{n}": pick.randrange(len(steps)) for n in range(pick.randint(1, 6))}
    return Program((IN, OTHER, THIRD), tuple(steps), {**results, "last": len(steps) - 1})


def step_by_step(program: Program, inputs: Sequence[Any], size: int) -> dict[str, Any]:
    known: list[Any] = []
    with np.errstate(all="ignore"):
        for step in program.operations:
            if step.name in ("input", "constant"):
                value = inputs[step.arguments[0]] if step.name == "input" else floats.nearest(step.value)
                known.append(np.broadcast_to(np.asarray(value, dtype=float), (size,)).copy())
            else:
                known.append(floats.UFUNCS[step.name](*(known[x] for x in step.arguments)))
    return {name: known[x] for name, x in program.results.items()}


@pytest.mark.parametrize("seed", range(120))
def test_blocks_and_shared_buffers_give_what_the_steps_give_one_by_one(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(floats, "BLOCK", 4)
    program, rng, size = any_program(seed), np.random.default_rng(seed), seed % 11
    inputs = [x if rng.random() < 0.6 else float(rng.normal()) for x in rng.normal(size=(3, size)) * 3]
    out = [np.full(size, -7.0) for _ in program.results]
    Floats(program).run(inputs, size, out)
    expected = step_by_step(program, inputs, size)
    for row, name in zip(out, program.results, strict=True):
        assert (np.isnan(row) == np.isnan(expected[name])).all()
        # a library may take a single sine another way than those of an array: within a unit or two of the last place
        assert np.allclose(row, expected[name], rtol=1e-10, atol=1e-12, equal_nan=True)


def test_a_program_is_run_in_blocks_and_needs_few_buffers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(floats, "BLOCK", 4)
    seen: list[int] = []

    def counted(x: Any, y: Any, out: Any) -> Any:
        seen.append(len(out))
        return np.add(x, y, out)

    monkeypatch.setitem(floats.UFUNCS, "add", counted)
    write = Writer((IN, OTHER))
    x, y = write.input(IN), write.input(OTHER)
    total = x
    for _ in range(20):
        total = write.mul(write.add(total, y), x)
    program = write.program({"y": total})
    out = np.empty((1, 10))
    Floats(program).run([np.ones(10), np.ones(10)], 10, out)
    assert seen == [4] * 20 + [4] * 20 + [2] * 20
    assert (out == 21).all()
    plan = floats._plan(program, frozenset(), tuple(program.results.values()))
    assert plan.buffers <= 2
    assert len(plan.steps) == 40
    wave = write.input(IN)
    for _ in range(9):  # sinc reads its argument again after it has begun to write: never into the same buffer
        wave = write.expression(sinc(IN)) if wave == write.input(IN) else write._step("sinc", wave)
    program = write.program({"y": wave})
    plan = floats._plan(program, frozenset(), tuple(program.results.values()))
    assert plan.buffers == 2
    assert all(place != known for (_, _, _, place), (_, _, _, known) in pairwise(plan.steps))


def test_sin_x_over_x_less_one_keeps_its_digits_for_arguments_of_either_sign_and_any_size() -> None:
    x = np.concatenate([np.geomspace(1e-150, 1e3, 300), np.linspace(1.9, 2.1, 21), [2.0, np.nextafter(2, 3)]])
    for at in (x, -x):
        into = np.empty_like(at)
        for found in (
            sinc_in_floats.sincm1(at),
            sinc_in_floats.sincm1(at, into),
            np.array([sinc_in_floats.sincm1(a) for a in at.tolist()]),
        ):
            with mpmath.workdps(400):
                true = [mpmath.sinc(mpmath.mpf(a)) - 1 for a in at.tolist()]
                away = [abs(mpmath.mpf(f) / t - 1) for f, t in zip(found.tolist(), true, strict=True)]
            assert max(away) < 1e-15
        assert (into == sinc_in_floats.sincm1(at)).all()
    with np.errstate(invalid="ignore"):
        assert sinc_in_floats.sincm1(np.array([0.0, -0.0])).tolist() == [0.0, 0.0]
    for at in (x, -x):
        into = np.empty_like(at)
        assert np.allclose(sinc_in_floats.sinc(at), np.sin(at) / at, rtol=1e-15, atol=0)
        assert (sinc_in_floats.sinc(at, into) == into).all()
        assert (into == sinc_in_floats.sinc(at)).all()
    with np.errstate(invalid="ignore"):
        assert sinc_in_floats.sinc(np.array([0.0])).tolist() == [1.0]


@pytest.mark.slow
@pytest.mark.parametrize("n", range(4))
def test_the_slopes_of_sin_x_over_x_are_those_of_its_series_on_both_sides_of_where_it_is_used(n: int) -> None:
    """The n-th is the integral of u^n cos(x u + n pi/2) over u from 0 to 1."""
    x = np.concatenate([np.geomspace(1e-9, 1.4999, 40), [0.0, np.nextafter(1.5, 0), 1.5], np.linspace(1.6, 30, 40)])
    for at in [*x.tolist(), *(-x).tolist()]:
        with mpmath.workdps(60):
            true = mpmath.quad(lambda u, a=at: u**n * mpmath.cos(a * u + n * mpmath.pi / 2), [0, 1])
            assert abs(mpmath.mpf(float(sinc_in_floats.sinc_and_slopes(np.array([at]))[n][0])) - true) < 4e-15


def test_a_constant_beyond_doubles_is_infinite_and_others_are_the_nearest() -> None:
    assert floats.nearest(fmpq(10) ** 400) == np.inf
    assert floats.nearest(-(fmpq(10) ** 400)) == -np.inf
    assert floats.nearest(fmpq(1, 3)) == 1 / 3
    assert floats.nearest(fmpq(10) ** 400 / (3 * fmpq(10) ** 400)) == 1 / 3
    assert floats.nearest(pi) == np.pi
    assert type(floats.nearest(fmpq(2))) is np.float64


def test_what_is_watched_tells_of_overflow_and_of_lost_digits() -> None:
    write = Writer((IN,))
    x = write.input(IN)
    program, out = write.program({"y": write.mul(x, x)}), np.empty((1, 2))
    for at in (1e200, 1e-160):
        Floats(program).run([np.array([1.0, at])], 2, out)
        with pytest.raises(FloatingPointError):
            Floats(program).run([np.array([1.0, at])], 2, out, watched=True)
    Floats(write.program({"y": write.div(write.constant(1), x)})).run([np.array([1.0, 0.0])], 2, out, watched=True)
    assert out.tolist() == [[1.0, np.inf]]


# --- what is proven --------------------------------------------------------------------------------------------------


def certified_of(program: Program) -> Certified:
    def never(_: Any) -> Any:
        raise AssertionError("no closed form is needed")

    return Certified(program, never)


def test_a_double_is_proven_within_one_unit_exactly_where_the_bounds_say_so() -> None:
    """|lo| + error against the distance to the double before, the smaller one at a power of two, of either sign."""
    write = Writer((IN,))
    program = write.program({"y": write.mul(write.input(IN), write.input(IN)), "c": write.constant(fmpq(1, 3))})
    proof = certified_of(program)
    rng = np.random.default_rng(5)
    hi = np.concatenate(
        [
            np.ldexp(rng.uniform(1, 2, 150), rng.integers(-1000, 1000, 150)),
            2.0 ** rng.integers(-900, 900, 50),
            [0.0] * 4,
        ]
    )
    hi *= rng.choice([-1, 1], hi.size)
    unit = np.abs(hi) - np.nextafter(np.abs(hi), 0)
    lo = unit * rng.choice([-1, -0.5, -0.25, 0, 0.25, 0.5, 1, -2, 2], hi.size)
    with np.errstate(invalid="ignore"):
        error = unit * rng.choice([0, 0.25, 0.5, 0.75, 1, 3, np.inf, np.nan], hi.size)
    error[-2:] = [0.0, 5e-324]
    lo[-4:] = [0.0, 5e-324, 0.0, 0.0]
    found = proof._proven("y", Doubled(hi, lo, error))
    for h, x, e, sure in zip(hi, lo, error, found, strict=True):
        size = Fraction(abs(float(h)))
        expected = np.isfinite(e) and Fraction(abs(float(x))) + Fraction(float(e)) <= size - Fraction(
            float(np.nextafter(float(size), 0))
        )
        assert sure == (expected if h else (np.isfinite(e) and abs(x) + e <= -np.nextafter(0.0, 0))), (h, x, e)
    assert proof._proven("c", Doubled(hi, lo, error)).all()
    assert 0.2 < found.mean() < 0.8


def test_more_bits_are_taken_before_a_closed_form_is_asked_for() -> None:
    """(1 + x) - 1 in balls of 128 bits shows nothing of 1e-60, and in 512 all of it; points are mixed with easy ones."""
    write = Writer((IN, OTHER))
    total = write.sub(write.add(write.input(IN), write.constant(1)), write.constant(1))
    product = write.mul(total, write.input(OTHER))
    proof = certified_of(write.program({"total": total, "product": product, "third": write.constant(fmpq(1, 3))}))
    assert proof.at((1e-60, 3.0), ["product", "total"]) == {"total": 1e-60, "product": 1e-60 * 3.0}
    assert proof.at((1e-250, 2.0), ["total"]) == {"total": 1e-250}
    x = np.array([0.5, 1e-60, 1e-20, 7.0, 1e-250])
    values, balls = proof.run([x, np.full(5, 3.0)], 5)
    assert values["total"].tolist() == x.tolist()
    assert values["product"].tolist() == (x * 3.0).tolist()
    assert values["third"].tolist() == [1 / 3] * 5
    assert balls == 3
    single, again = proof.run([x, 3.0], 5)
    assert single["product"].tolist() == values["product"].tolist()
    assert again == 3
    number = proof.number((0.5, 3.0), "total")
    assert isinstance(number, ProgramValue)
    assert number.digits(5) == "0.50000"
    shown = proof.number((1e-60, 1.0), "total").digits(20)
    assert Decimal(shown) == Context(prec=20).create_decimal_from_float(1e-60)


def test_numbers_of_programs_are_asked_of_their_closed_forms_only_where_balls_show_nothing() -> None:
    f = hs.distort(mass_spring_damper(m=1, b=b, k=4), first_order_lag(2)).compile(of=[*RATIOS, "environment_imag"])
    assert isinstance(f.certified.number((3.0, 0.5), "ratio_real"), ProgramValue)
    cancelled = f.certified.number((2.0, 0.0), "ratio_real")  # 0/0 in the program, 1/2 in lowest terms
    assert isinstance(cancelled, PointValue)
    assert cancelled.digits(3) == "0.500"
    assert f.certified.number((3.0, 0.0), "environment_imag") == 0.0
    pole = hs.distort(mass_spring_damper(m=1, k=4), shunt(k=1)).compile(of=RATIOS).certified
    assert pole.number((2.0,), "ratio_real") == np.inf
    with pytest.raises(hs.SceneError, match=r"omega = -3\.0 rad/s must be >= 0"):
        f.certified.number((-3.0, 0.5), "ratio_real")


@pytest.mark.few("certified")
@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_what_is_no_number_among_the_arguments_gives_none_there_and_nowhere_else(accuracy: str) -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(20)).compile(accuracy)
    for bad in (np.nan, np.inf, -np.inf):
        for omega, stiffness in (
            ([1.0, bad, 3.0], 5.0),
            ([1.0, 2.0, 3.0], [5.0, bad, 5.0]),
            ([1.0, bad, 3.0], [5.0, bad, 5.0]),
        ):
            found = np.array(f(omega, k=stiffness))
            assert np.isnan(found[:, 1]).all()
            assert np.isfinite(found[:, [0, 2]]).all()
            if bad != -np.inf:  # which is a negative frequency
                many = np.tile(omega, 20), np.tile(stiffness, 20) if np.ndim(stiffness) else stiffness
                for at, stiff in ((omega, stiffness), many):
                    texts = f.digits(at, 3, k=stiff)
                    assert {texts.environment_real[1], texts.real[1], texts.ratio_imag[1]} == {"nan"}
                    assert (texts.environment_real[0], texts.environment_real[2]) == ("5.00", "5.00")


def test_values_at_negative_frequencies_turn_the_sign_of_imaginary_parts_alone() -> None:
    d = hs.distort(mass_spring_damper(m=2, b=3, k=5), first_order_lag(4), delay("0.3 s"))
    above = d.compile("certified").certified.at((1.5,), Values._fields)
    below = d.compile("certified").certified.at((-1.5,), Values._fields)
    for name in Values._fields:
        assert below[name] == (-above[name] if name.endswith("imag") and not name.startswith("ratio") else above[name])
        assert above[name] != 0
    at_rest = d.compile("certified").certified.at((0.0,), ["perceived_imag", "perceived_real"])
    assert (at_rest["perceived_imag"], at_rest["perceived_real"]) == (0.0, 5.0)
    assert not np.signbit(at_rest["perceived_imag"])


@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "organ-tissue", "undamped-resonance"])
def test_certified_values_hold_at_frequencies_of_any_size(name: str) -> None:
    d = hs.load_scene(name).distortion()
    omega = np.array([5e-324, 1e-308, 1e-150, 1e-9, 1e9, 1e18, 3.7e18, 1e19, 1e25, 1e60, 1e120])
    of = (*RATIOS, "real", "imag", "perceived_real", "relative_imag")
    found = d.compile("certified", of)(omega)._asdict()
    assert against_truth(d, omega, {}, found, bits=6000).max() <= 1.0


# --- what the structured form is made of -----------------------------------------------------------------------------


def steps_of(environment: hs.Environment, *chain: hs.Effect, of: Sequence[str] = RATIOS) -> Counter[str]:
    program = hs.distort(environment, *chain).compile(of=of).program
    return Counter(step.name for step in program.operations)


def test_programs_are_as_short_as_their_mathematics() -> None:
    """No root where H_env lies on an axis, one division for a filter, one polynomial for each effect."""
    lag = first_order_lag(20)
    assert "sqrt" not in steps_of(mass_spring_damper(k=100), lag)
    assert "sqrt" not in steps_of(mass_spring_damper(m=1), lag)
    assert "sqrt" not in steps_of(mass_spring_damper(b=3), lag)
    assert steps_of(mass_spring_damper(m=1, b=2, k=100), lag)["sqrt"] == 1
    assert steps_of(mass_spring_damper(m=1, b=2, k=100), lag)["div"] == 1
    assert steps_of(mass_spring_damper(m=1, b=2, k=100), of=("environment_real", "environment_imag"))["div"] == 0
    assert steps_of(mass_spring_damper(m=1, b=2, k=100), shunt(m=1), of=("real", "imag", "perceived_real"))["div"] == 0
    assert sum(steps_of(mass_spring_damper(m=1, b=2, k=100), lag).values()) <= 30
    two = steps_of(mass_spring_damper(m=1, b=2, k=100), lag, second_order_lowpass(80, "0.5"))
    assert sum(two.values()) <= 70


CHAINS: dict[str, tuple[hs.Environment, tuple[hs.Effect, ...], hs.Environment | None]] = {
    "repeated factors": (mass_spring_damper(1, 2, 90), (two_port("(s+1)^2*(s+2)", "s*(s+3)^2", "(s+4)^3/1000", "(s+1)^2*(s+5)*(s+6)"),), None),
    "no A": (mass_spring_damper(1, 2, 90), (two_port("0", "s + 3", "(s+4)/1000", "s + 5"),), None),
    "no D": (mass_spring_damper(1, 2, 90), (two_port("s + 3", "-4", "(s+4)/1000", "0"),), None),
    "gain beside": (mass_spring_damper(1, 2, 90), (two_port("2*s + 3", "s^2 + 1", "0", "s + 3"),), None),
    "shunts between lags": (kelvin_voigt(90, 2), (first_order_lag(20), shunt(m=1), first_order_lag(30), shunt(b=2), delay("1 ms")), None),
    "three in a row": (mass_spring_damper(1, 2, 90), (first_order_lag(20), second_order_lowpass(50, "0.3"), series("(s+5)/(s+9)")), None),
    "compliances": (mass_spring_damper(1, 2, 90), (compliance(k=700), first_order_lag(20), compliance(k=900, b=2)), None),
    "integrators": (expression("1/(s*(s+1)) + 3/s + 2"), (first_order_lag(2),), None),
    "damper": (mass_spring_damper(b=3), (first_order_lag(2), shunt(k=4), delay("0.2 s")), None),
    "mass": (mass_spring_damper(m=3), (second_order_lowpass(2, "0.4"),), None),
    "rendered": (mass_spring_damper(1, 2, 90), (first_order_lag(20), shunt(m=1)), kelvin_voigt(80, 3)),
    "rendered alone": (mass_spring_damper(1, 2, 90), (), zener(80, 40, 3)),
    "nothing": (mass_spring_damper(1, 2, 90), (), None),
    "roots of s": (spring_pot(30, "1/2", k=4), (first_order_lag(20), delay("10 ms")), None),
    "waves": (mass_spring_damper(1, 2, 90), (wave_variables(5, "10 ms"),), None),
    "holds": (kelvin_voigt(90, 2), (zero_order_hold("2 ms"), zero_order_hold("5 ms", name="other"), first_order_lag(9)), None),
    "friction": (mass_spring_damper(1, 2, 90), (coulomb_friction(force=2, amplitude="0.05"), first_order_lag(20)), None),
    "link": (mass_spring_damper(1, 2, 90), (position_force_teleoperator("0.5", "0.4", 8, 900, "3 ms"),), None),
}  # fmt: skip


@pytest.mark.few(4)
@pytest.mark.parametrize("name", CHAINS)
def test_every_shape_of_a_chain_has_all_its_values_whatever_computes_them(name: str) -> None:
    environment, chain, rendered = CHAINS[name]
    d = hs.distort(environment, *chain, **({"rendered": rendered} if rendered else {}))
    omega = np.array([1e-3, 0.1, 0.9, 3.3, 9.4, 22.0, 140.0])
    for accuracy, limit in (("fast", 3e4), ("double-double", 1.0), ("certified", 1.0)):
        found = d.compile(accuracy)(omega)._asdict()
        errors_ = against_truth(d, omega, {}, {n: np.where(x == 0, 0.0, x) for n, x in found.items()})
        exact_zeros = np.array([[x[i] == 0 for x in found.values()] for i in range(omega.size)])
        worst = np.where(exact_zeros, 0.0, errors_).max()
        assert worst <= limit, accuracy
        if accuracy == "certified":
            assert (errors_[exact_zeros] == 0).all()


def test_floats_alone_have_no_0_over_0_where_a_part_has_a_limit() -> None:
    """Re of 1/(s (s + 1)) at rest is -1, and 1/s^2 is all real."""
    for text, at_rest in (("1/(s*(s+1))", -1.0), ("1/s^2", -np.inf), ("(s+2)/(s+1)", 2.0)):
        program = hs.distort(expression(text), first_order_lag(2)).compile(of="environment_real").program
        out = np.empty((1, 1))
        Floats(program).run([np.array([0.0])], 1, out)
        assert out[0, 0] == at_rest


def test_digits_at_rest_are_those_of_the_limits() -> None:
    f = hs.distort(mass_spring_damper(m=1, b=2, k=4), first_order_lag(2)).compile()
    found = f.digits(0.0, 4)
    assert (found.environment_real, found.environment_imag, found.ratio_real, found.real) == ("4.000", "0", "0", "0")
    free = hs.distort(mass_spring_damper(m=2, b=3), series("2")).compile().digits([0.0], 4)
    assert (free.ratio_imag.tolist(), free.ratio_real.tolist()) == (["1.000"], ["0"])


@pytest.mark.parametrize("accuracy", ["fast", "certified"])
def test_at_rest_all_values_are_their_limits(accuracy: str) -> None:
    found = hs.distort(expression("1/(s*(s+1))"), first_order_lag(2)).compile(accuracy)(0.0)
    assert (found.environment_real, found.environment_imag) == (-1.0, -np.inf)
    damper = hs.distort(mass_spring_damper(b=3), first_order_lag(2)).compile(accuracy)(0.0)
    assert (damper.ratio_real, damper.ratio_imag, damper.relative_real, damper.relative_imag) == (0, 0, 0, 0)
    mass = hs.distort(mass_spring_damper(m=3), series("3/2")).compile(accuracy)(0.0)
    assert (mass.ratio_real, mass.ratio_imag, mass.relative_real) == (0.5, 0.0, 0.5)


def test_a_hold_is_taken_out_of_a_function_wherever_it_stands() -> None:
    """Also where its time is over the number of a parameter."""
    rate = Symbol("r", positive=True)
    ring = Ring.of([exp(-s / 10), exp(-s * pi / 7), exp(-3 * s / (2 * rate)), s ** Rational(1, 2)])
    response = on_axis(ring.convert((1 - exp(-s / 10)) / s))
    for f in (response.real, response.imag):  # sin(a)/a and 1 - cos(a): nothing is taken off them
        assert stable.without_sinc_less_one(f) is None
    axis, held = ring.axis, 0
    for angle, t in zip(axis.angles, axis.context.gens()[axis.size :], strict=False):
        if angle.constant:
            continue
        less_one = axis.function(2 * t, 1 + t**2) / axis.convert(angle.value) - axis.one
        other = axis.convert(3 * hs.omega**2 + 5)
        found, rest = stable.without_sinc_less_one(RealFunction((less_one * other).reduced()))
        assert found == angle.value
        assert (rest.function - other).is_zero
        held += 1
    assert held == 3
    assert stable.without_sinc_less_one(RealFunction(ring.axis.zero)) is None
    assert stable.without_sinc_less_one(RealFunction(ring.axis.one)) is None


# --- machine code ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", often(["fu2019", "delayed-spring", "organ-tissue"], lambda name: name == "fu2019"))
def test_machine_code_gives_the_same_doubles(name: str) -> None:
    required(NUMBA, find_spec("numba"))
    d = hs.load_scene(name).distortion()
    omega = np.concatenate([[0.0], np.geomspace(1e-9, 1e9, 1001)])
    ours, theirs = d.compile(of=RATIOS)(omega), d.compile(of=RATIOS, engine="numba")(omega)
    for x, y in zip(ours, theirs, strict=True):
        if name == "fu2019":
            assert (x == y).all()
        else:  # sines and powers of two libraries: 8 units of the largest term
            assert np.abs(x - y).max() <= 2**-50 * (1 + np.abs(x)).max()


@pytest.mark.slow
def test_machine_code_leaves_arrays_of_parameters_to_numpy() -> None:
    required(NUMBA, find_spec("numba"))
    omega, values = drawn(FAMILIES["filter"], 20, 5)
    ours, theirs = (FAMILIES["filter"].compile(engine=x)(omega, **values) for x in ("numpy", "numba"))
    assert (np.array(ours) == np.array(theirs)).all()


@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "a hold on a spring-pot"])
def test_what_is_given_to_the_compiler_of_machine_code_says_what_the_program_does(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Run as it is, without being compiled: each step in its order, one result in a pass or two."""
    monkeypatch.setattr(machine, "find_spec", lambda _: True)
    monkeypatch.setitem(sys.modules, "numba", SimpleNamespace(njit=lambda f, **_: f))  # type: ignore[misc]
    cleared = (machine._step, machine._loops)
    for x in cleared:
        x.cache_clear()
    held = hs.Scene(spring_pot(20, "0.3", k=100), (zero_order_hold("10 ms"),))
    d = (held if " " in name else hs.load_scene(name)).distortion()
    omega = np.concatenate([[0.0], np.geomspace(1e-6, 1e6, 41)])
    for of in (("ratio_real",), ("ratio_real", "ratio_imag", "perceived_real")):
        ours, theirs = (np.array([*d.compile(of=of, engine=x)(omega)]) for x in ("numpy", "numba"))
        assert ours.shape == theirs.shape
        if name == "fu2019":
            assert (ours == theirs).all()
        else:  # sines and powers of two libraries: 8 units of the largest term
            assert np.abs(ours - theirs).max() <= 2**-50 * (1 + np.abs(ours)).max()
    for x in cleared:
        x.cache_clear()


def test_machine_code_runs_where_the_frequency_alone_is_an_array(monkeypatch: pytest.MonkeyPatch) -> None:
    """(x + a)/b, each number one or many: what is not left to NumPy is run as it is, without being compiled."""
    monkeypatch.setattr(machine, "find_spec", lambda _: True)
    monkeypatch.setitem(sys.modules, "numba", SimpleNamespace(njit=lambda f, **_: f))  # type: ignore[misc]
    left: list[Program] = []
    monkeypatch.setattr(machine, "Floats", lambda program: left.append(program) or floats.Floats(program))  # type: ignore[func-returns-value]
    cleared = (machine._step, machine._loops)
    for x in cleared:
        x.cache_clear()
    w = Writer(("x", "a", "b"))
    names = w.add(w.input("x"), w.input("a")), w.input("b")
    program = w.program({"quotient": w.div(*names), "sum": names[0]})
    many = np.array([1.0, 2.0, 4.0])
    for inputs in itertools.product(*[(3.0, many)] * 3):
        left.clear()
        out = np.empty((2, 3))
        machine.Machine(program).run(inputs, 3, out)
        x, a, b = (np.broadcast_to(given, 3) for given in inputs)
        assert (out == [(x + a) / b, x + a]).all()
        assert [*map(np.ndim, inputs)] == [1, 0, 0] or left == [program]
        assert [*map(np.ndim, inputs)] != [1, 0, 0] or not left
    for x in cleared:
        x.cache_clear()


def test_without_numba_its_engine_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "find_spec", lambda name: None)
    with pytest.raises(hs.SceneError, match=r'pip install "haptisym\[fast\]"'):
        hs.load_scene("fu2019").distortion().compile(engine="numba")


def test_a_spring_with_a_maxwell_branch_and_the_rendering_of_another_are_certified() -> None:
    d = hs.distort(zener(100, 50, 3), FILTER.with_values({"omega_n": 80, "zeta": "0.5"}), rendered=kelvin_voigt(100, 2))
    omega = np.geomspace(1e-6, 1e6, 15)
    assert against_truth(d, omega, {}, d.compile("certified")(omega)._asdict()).max() <= 1.0


def test_the_examples_of_the_page_run() -> None:
    page = Path(__file__).parents[2] / "docs" / "functions.md"
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted >= 8
    assert result.failed == 0


def test_digits_are_given_only_where_both_ends_of_what_is_known_have_them() -> None:
    """1.2449 +- 0.0002 is 1.24 or 1.25 to three digits, and 1.2449 +- 0.00005 is 1.24."""
    assert _decimal((1.2449, 0.0, 2e-4), 3) is None
    assert _decimal((1.2451, 0.0, 2e-4), 3) is None
    assert _decimal((1.2449, 0.0, 5e-5), 3) == "1.24"


@pytest.mark.parametrize(
    ("f", "kept"),
    [
        (1 / (s + k), True), (s / (s + k), True), (1 / (s**2 + s + k), True), ((s + 1) / (s**2 + k * s + 2), True),
        (1 / s, False), (1 / (s * (s + k)), False), (1 / (s**2 + k), False), (s / 2, False), (s + k * s**2 / 3, False), ((s + 2) / (s**2 + 9 * k) / (s + k), False),
    ],
    ids=str,
)  # fmt: skip
def test_both_parts_stand_over_the_square_of_the_denominator_where_neither_has_a_factor_of_it(
    f: Expr, *, kept: bool
) -> None:
    author = stable.Author(Writer((axis_omega, k)))
    pair, below = author.fraction(Ring.of([f]).convert(f).reduced(), "")
    assert author.write.number(below) == (None if kept else 1)
    program, out = (
        author.write.program(dict(zip(("real", "imag"), author.over(pair, below), strict=True))),
        np.empty((2, 4)),
    )
    w = np.array([0.25, 1.0, 3.0, 40.0])
    Floats(program).run([w, 0.5], 4, out)
    true = [complex(f.subs({s: 1j * x, k: 0.5})) for x in w.tolist()]
    assert np.allclose(out[0] + 1j * out[1], true, rtol=1e-12, atol=0)


def test_a_polynomial_is_written_as_the_product_of_its_factors_and_one_that_is_none_as_it_stands() -> None:
    w, ring = Writer((axis_omega, k)), PolynomialRing(axis_omega, [k])
    alone, first, second = (
        ring.convert(x).numerator for x in (3 * axis_omega * k + 6, axis_omega + k, axis_omega**2 + 2)
    )
    sums = [w.polynomial(ring, x) for x in (first, second)]
    assert w.product(ring, alone) == w.polynomial(ring, alone)
    assert w.product(ring, first * first * 5) == w.mul(w.constant(5), w.power(sums[0], 2))
    assert w.product(ring, first * second) in (w.mul(*sums), w.mul(*sums[::-1]))
    assert w.product(ring, first - first) == w.constant(0)


def test_zeros_ones_opposites_and_numbers_are_folded_where_they_stand() -> None:
    """Each step is the same number as the one that it is folded into."""
    w = Writer(("x", "y"))
    x, y = w.input("x"), w.input("y")
    zero, one, less = w.constant(0), w.constant(1), w.constant(-1)
    a, b = w.constant(fmpq(3, 2)), w.constant(fmpq(-5))
    for found, expected in (
        (w.add(x, zero), x), (w.add(zero, x), x), (w.sub(x, zero), x), (w.sub(zero, x), w.neg(x)), (w.sub(x, x), zero),
        (w.add(x, w.neg(y)), w.sub(x, y)), (w.add(w.neg(y), x), w.sub(x, y)), (w.sub(x, w.neg(y)), w.add(x, y)),
        (w.neg(w.neg(x)), x), (w.neg(w.sub(x, y)), w.sub(y, x)), (w.mul(x, zero), zero), (w.mul(zero, x), zero),
        (w.mul(x, one), x), (w.mul(one, x), x), (w.mul(x, less), w.neg(x)), (w.mul(less, x), w.neg(x)),
        (w.mul(w.neg(x), y), w.neg(w.mul(x, y))), (w.mul(x, w.neg(y)), w.neg(w.mul(x, y))), (w.mul(w.neg(x), w.neg(y)), w.mul(x, y)),
        (w.div(x, one), x), (w.div(zero, x), zero), (w.div(w.neg(x), y), w.neg(w.div(x, y))), (w.div(x, w.neg(y)), w.neg(w.div(x, y))),
        (w.add(a, b), w.constant(fmpq(-7, 2))), (w.sub(a, b), w.constant(fmpq(13, 2))), (w.mul(a, b), w.constant(fmpq(-15, 2))),
        (w.div(a, b), w.constant(fmpq(-3, 10))), (w.neg(a), w.constant(fmpq(-3, 2))), (w.abs(b), w.constant(5)),
        (w.abs(w.neg(x)), w.abs(x)), (w.power(x, 0), one), (w.power(x, 1), x), (w.power(x, 2), w.mul(x, x)),
        (w.power(x, 5), w.mul(w.mul(w.mul(x, x), w.mul(x, x)), x)), (w.power(a, 2), w.constant(fmpq(9, 4))),
    ):  # fmt: skip
        assert found == expected
    assert w.operations[w.div(x, zero)].name == "div"
    assert [w.operations[z].name for z in (w.add(x, y), w.sub(x, y), w.mul(x, y), w.div(x, y))] == [
        "add",
        "sub",
        "mul",
        "div",
    ]


def test_a_value_with_pi_or_waves_at_an_exact_frequency_is_that_of_digits_and_at_0_the_limit() -> None:
    axis, w = Ring.of([exp(-s / 2)]).axis, axis_omega
    late = on_axis(Ring.of([exp(-s / 2)]).convert(1 - exp(-s / 2))).imag  # sin(w/2)
    over = late / RealFunction(axis.convert(w))
    with mpmath.workdps(30):
        for f, value in ((RealFunction(Ring().axis.convert((pi + w) / (2 + w**2))), lambda x: (mpmath.pi + x) / (2 + x**2)),
                         (over, lambda x: mpmath.sin(x / 2) / x if x else mpmath.mpf(1) / 2)):  # fmt: skip
            for x in (0, 1, 3, 250):
                assert float(PointValue(f, fmpq(x))) == float(value(mpmath.mpf(x)))
                if value(mpmath.mpf(x)) > 0:
                    assert float(PointValue(f, fmpq(x), rooted=True)) == float(mpmath.sqrt(value(mpmath.mpf(x))))
