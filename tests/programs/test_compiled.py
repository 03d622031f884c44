"""Compiled functions: what each level of accuracy promises, against the chain matrices in ball arithmetic at 1000 bits."""

from __future__ import annotations

import random
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from importlib.util import find_spec
from math import factorial
from typing import Any

import mpmath
import numpy as np
import pytest
from chainballs import BITS, error_in_ulps, truth
from flint import fmpq
from marks import QUICK_SCENES, UNDAMPED, often, required
from sympy import Symbol, exp, pi

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
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.rings import omega as axis_omega
from haptisym.kernel.rings import s
from haptisym.model.catalogue import EFFECTS
from haptisym.model.distortion import Distortion
from haptisym.programs import floats as sinc_in_floats
from haptisym.programs.balls import PointValue
from haptisym.programs.certified import Certified
from haptisym.programs.floats import BLOCK, Floats, nearest, ufuncs
from haptisym.programs.program import Operation, Program, Writer
from haptisym.programs.values import Values

NUMBA = "Numba, of the extra fast,"

RATIOS = ("ratio_real", "ratio_imag")
LEVELS = ("fast", "double-double", "certified")

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


@pytest.mark.dear("filter and device mass-2000", "filter-2000", "two filters and a lag-2000")
@pytest.mark.parametrize("count", [2_000, pytest.param(8_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", FAMILIES)
def test_certified_values_are_within_one_unit_of_the_last_place(family: str, count: int) -> None:
    of = RATIOS if family == "filter" else (*RATIOS, "real", "relative_imag", "perceived_real")
    assert errors(FAMILIES[family], "certified", int(count * SHARES[family]), count, of).max() <= 1.0


@pytest.mark.dear("True-fu2019")
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


@pytest.mark.few("encoder", "backlash")
@pytest.mark.parametrize("model", ["encoder", "backlash", "dead-zone", "saturation"])
def test_a_describing_function_is_compiled_with_its_sizes_as_arguments(model: str) -> None:
    """Below the size, where nothing passes, at it, and above: of arrays, in every arithmetic, and by ``lambdify``."""
    q, a = hs.symbols("q a")
    size = next(x for x in EFFECTS[model].slots if x != "amplitude")
    d = hs.distort(MSD, EFFECTS[model].build(**{size: q, "amplitude": a}), delay(tau))
    omega = np.repeat([0.3, 40.0], 7)
    given = {"m": 0.5, "b": 2.0, "k": 300.0, "tau": 3e-3, "a": 1.5}
    values = {x: np.full(14, y) for x, y in given.items()}
    values["q"] = np.tile([0.05, 0.4, 1.0, 1.5, 2.1, 3.0, 4.0], 2)
    found = {level: d.compile(level)(omega, **values)._asdict() for level in ("fast", "double-double", "certified")}
    assert against_truth(d, omega, values, found["certified"]).max() <= 1.0
    for name in ("real", "imag", "relative_real"):
        exact = found["certified"][name]
        size_of = np.abs(exact) + 300.0 if name in ("real", "imag") else 1.0
        for level in ("fast", "double-double"):
            assert (np.abs(found[level][name] - exact) <= 1e-13 * size_of).all()
        plainly = [d.lambdify(name)(w, **given, q=x) for w, x in zip(omega, values["q"], strict=True)]
        assert plainly == pytest.approx(exact, abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["encoder", "backlash"])
def test_numba_computes_a_describing_function_as_numpy_does(model: str) -> None:
    required(NUMBA, find_spec("numba"))
    q, a = hs.symbols("q a")
    size = next(x for x in EFFECTS[model].slots if x != "amplitude")
    d = hs.distort(MSD, EFFECTS[model].build(**{size: q, "amplitude": a}))
    omega, both = np.geomspace(0.1, 100, 5), [d.compile(engine=x) for x in ("numpy", "numba")]
    for x in (0.05, 1.0, 2.1, 3.0, 4.0):
        plain, machine = (f(omega, m=0.5, b=2.0, k=300.0, a=1.5, q=x) for f in both)
        assert machine.real == pytest.approx(plain.real, rel=1e-13, abs=1e-10)
        assert machine.imag == pytest.approx(plain.imag, rel=1e-13, abs=1e-10)


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_a_power_with_an_exponent_beyond_0_to_1_is_not_lost_on_its_way(accuracy: str) -> None:
    """Im H_env = c omega^alpha sin(pi alpha/2): of each of these the power alone is no double."""
    alpha, c, k = hs.symbols("alpha c k")
    f = hs.distort(spring_pot(c, alpha, k=k), first_order_lag(20)).compile(accuracy, of=("environment_imag",))
    for size, exponent, omega in ((1e200, 5.0, 1e-80), (1e200, -5.0, 1e80), (1e-200, 5.0, 1e80), (1e-200, -5.0, 1e-80)):
        with mpmath.workdps(30):
            wanted = mpmath.mpf(size) * mpmath.mpf(omega) ** exponent * mpmath.sin(mpmath.pi * exponent / 2)
        found = f([omega, omega], c=size, alpha=exponent, k=3.0).environment_imag
        assert found == pytest.approx(float(wanted), rel=1e-13)


def test_double_doubles_stay_below_one_unit_where_the_chain_is_rational() -> None:
    for family in ("filter", "two filters and a lag", "filter and device mass"):
        assert errors(FAMILIES[family], "double-double", 60, 7).max() <= 1.0


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


@pytest.mark.dear("roots of s", "shunts between lags", "three in a row")
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


@pytest.mark.parametrize("engine", often(["numpy", "numba"], "numpy".__eq__))
def test_a_sample_and_hold_keeps_its_digits_far_below_its_sampling_rate(engine: str) -> None:
    """Where r_r is (omega T)^2/6: the difference sin(x)/x - 1 would lose all its digits."""
    if engine == "numba":
        required(NUMBA, find_spec("numba"))
    spring, hold = mass_spring_damper(k=100), zero_order_hold("1 ms")
    chains = ((hold,), (hold, zero_order_hold("2 ms", name="second")), (hold, delay("0.3 ms")), None)
    for effects in chains if engine == "numpy" else chains[:1]:
        d = (hs.Scene(spring, effects) if effects else hs.load_scene("sampled-wall")).distortion()
        omega = np.geomspace(1e-12, 300, 60)
        found = d.compile(of=RATIOS, engine=engine)(omega)._asdict()
        assert against_truth(d, omega, {}, found).max() <= 16.0


@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "organ-tissue", UNDAMPED])
def test_certified_values_hold_at_frequencies_of_any_size(name: str) -> None:
    d = hs.load_scene(name).distortion()
    omega = np.array([5e-324, 1e-308, 1e-150, 1e-9, 1e9, 1e18, 3.7e18, 1e19, 1e25, 1e60, 1e120])
    of = (*RATIOS, "real", "imag", "perceived_real", "relative_imag")
    found = d.compile("certified", of)(omega)._asdict()
    assert against_truth(d, omega, {}, found, bits=6000).max() <= 1.0


# Limits, poles, range


LIMITS: list[tuple[hs.Environment, hs.Effect, float, dict[str, float]]] = [
    (mass_spring_damper(m=2, b=3), series("2"), 0.0, {"ratio_imag": 1.0, "ratio_real": 0.0}),
    (mass_spring_damper(m=1, k=4), first_order_lag(2), 2.0, {"ratio_real": 0.5, "ratio_imag": 0.5}),
    (mass_spring_damper(m=1, b=1), delay("0.5 s"), 0.0, {"ratio_real": 0.0}),
    (mass_spring_damper(m=1), shunt(k=1), 0.0, {"ratio_real": np.inf}),
    (mass_spring_damper(b=3), first_order_lag(2), 0.0, {"ratio_real": 0, "ratio_imag": 0, "relative_real": 0, "relative_imag": 0}),
    (mass_spring_damper(m=3), series("3/2"), 0.0, {"ratio_real": 0.5, "ratio_imag": 0.0, "relative_real": 0.5}),
    (expression("1/(s*(s+1))"), first_order_lag(2), 0.0, {"environment_real": -1.0, "environment_imag": -np.inf}),
    (expression("1/s^2"), first_order_lag(2), 0.0, {"environment_real": -np.inf}),
    (expression("2*s^0.5"), first_order_lag(3), 0.0, {"ratio_real": 0.0, "ratio_imag": 0.0}),
]  # fmt: skip


@pytest.mark.parametrize("accuracy", LEVELS)
@pytest.mark.parametrize("case", range(len(LIMITS)))
def test_limits_at_rest_and_at_a_cancelled_resonance_are_values(case: int, accuracy: str) -> None:
    environment, effect, omega, expected = LIMITS[case]
    found = hs.distort(environment, effect).compile(accuracy, tuple(expected))([omega, 1.5])
    assert {name: x[0] for name, x in found._asdict().items()} == expected
    assert np.isfinite(np.array(found)[:, 1]).all()


def test_a_limit_that_only_the_given_parameters_make_is_found() -> None:
    f = hs.distort(MSD, first_order_lag(omega_c)).compile("certified", ["ratio_real"])
    assert f(2.0, m=1.0, b=0.0, k=4.0, omega_c=2.0).ratio_real == 0.5
    assert f([0.0], m=1.0, b=0.0, k=0.0, omega_c=2.0).ratio_real.tolist() == [0.0]


@pytest.mark.parametrize("accuracy", LEVELS)
def test_poles_are_infinite_and_frequencies_that_are_none_give_none(accuracy: str) -> None:
    f = hs.distort(mass_spring_damper(m=1, k=4), shunt(k=1)).compile(accuracy, ["ratio_real", "environment_real"])
    found = f([2.0, np.nan, np.inf])
    assert found.ratio_real[0] == np.inf
    assert np.isnan(found.ratio_real[1:]).all()
    assert found.environment_real[0] == 0.0


@pytest.mark.parametrize("accuracy", LEVELS)
def test_at_negative_frequencies_dynamics_are_conjugate(accuracy: str) -> None:
    d = hs.distort(expression("2*s^0.5 + s"), first_order_lag(3), delay("0.3 s"))
    for f in (d.compile(accuracy), hs.load_scene("organ-tissue").distortion().compile(accuracy)):
        below, above = f(-2.0)._asdict(), f(2.0)._asdict()
        for name, x in above.items():
            mirrored = -x if name.endswith("imag") and not name.startswith("ratio") else x
            assert below[name] == pytest.approx(mirrored, rel=1e-12)
            assert x != 0
    with pytest.raises(hs.SceneError, match="must be >= 0"):
        d.compile(accuracy).digits(-2.0, 5)


@pytest.mark.dear("fast")
@pytest.mark.parametrize("accuracy", LEVELS)
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


@pytest.mark.parametrize("accuracy", LEVELS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_among_the_arguments_gives_none_there_and_nowhere_else(accuracy: str, bad: float) -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(20)).compile(accuracy)
    for omega, stiffness in (
        ([1.0, bad, 3.0], 5.0),
        ([1.0, 2.0, 3.0], [5.0, bad, 5.0]),
        ([1.0, bad, 3.0], [5.0, bad, 5.0]),
    ):
        found = np.array(f(omega, k=stiffness))
        assert np.isnan(found[:, 1]).all()
        assert np.isfinite(found[:, [0, 2]]).all()
    constant = hs.distort(mass_spring_damper(k=5), first_order_lag(20)).compile(accuracy, ["environment_real"])
    found = constant([1.0, bad]).environment_real
    assert found[0] == 5
    assert np.isnan(found[1])


@pytest.mark.parametrize("times", [1, 12])  # few points, and many
def test_what_is_no_number_among_the_arguments_has_no_digits(times: int) -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(20)).compile(of=("environment_real", "real", "ratio_imag"))
    for omega, stiffness in (([1.0, np.inf, 3.0], [5.0] * 3), ([1.0, 2.0, 3.0], [5.0, np.nan, 5.0])):
        texts = f.digits(omega * times, 3, k=stiffness * times)
        assert {x[1] for x in texts[:3]} == {"nan"}
        assert (texts.environment_real[0], texts.environment_real[2]) == ("5.00", "5.00")


# Shape, fields, choices


def test_the_fields_asked_for_are_what_comes_back_in_that_order() -> None:
    d = hs.load_scene("fu2019").distortion()
    found = d.compile(of=("ratio_imag", "real"))([1.0, 2.0])
    assert found._fields == ("ratio_imag", "real")
    whole = d.compile()([1.0, 2.0])
    assert isinstance(whole, Values)
    assert (found.ratio_imag == whole.ratio_imag).all()
    assert d.compile(of="imag")(1.0)._fields == ("imag",)


@pytest.mark.parametrize("accuracy", LEVELS)
def test_the_shape_is_kept_also_of_constants(accuracy: str) -> None:
    for effect in (first_order_lag(20), series("2")):
        f = hs.distort(kelvin_voigt(100, 2), effect).compile(accuracy)
        for shape in ((), (3,), (2, 3), (0,), (2, 0)):
            assert {x.shape for x in f(np.ones(shape))} == {shape}


def test_parameters_of_effects_that_cancel_each_other_are_not_asked_for() -> None:
    d = hs.distort(mass_spring_damper(k=k), two_port("1 + m_d*s", "0", "0", "1 + m_d*s", parameters={"m_d": m_d}))
    f = d.compile()
    assert f.parameters == ("k",)
    assert f([1.0, 2.0], k=3.0).ratio_real.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"accuracy": "exactly"}, "fast, double-double, certified"), ({"of": ["ratio"]}, "ratio.*real, imag, ratio_real"),
        ({"of": ["real", "real"]}, "each once"), ({"of": []}, "choose among"), ({"engine": "gpu"}, "'gpu'.*numpy, numba"),
    ],
)  # fmt: skip
def test_a_wrong_choice_lists_the_right_ones(choice: dict[str, Any], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.load_scene("fu2019").distortion().compile(**choice)


@pytest.mark.parametrize(
    ("omega", "values", "message"),
    [
        (["fast"], {"k": 1.0, "omega_c": 1.0}, "omega.*real numbers"),
        ([2j], {"k": 1.0, "omega_c": 1.0}, "omega: give real frequencies"), (1.0, {"k": 2j, "omega_c": 1.0}, "k: give real numbers in SI"),
        ([1.0, 2.0], {"k": [1.0, 2.0, 3.0], "omega_c": 1.0}, r"broadcast: omega \(2,\), k \(3,\)"),
        (1.0, {}, "k, omega_c"), (1.0, {"k": 1.0}, "k, omega_c"), (1.0, {"k": 1.0, "omega_c": 1.0, "m": 1.0}, "k, omega_c"),
    ],
)  # fmt: skip
def test_a_wrong_argument_is_named(omega: Any, values: dict[str, Any], message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()(omega, **values)


def test_compiled_functions_take_whole_numbers_larger_than_numpy_s() -> None:
    f = hs.distort(mass_spring_damper(m=10**25, b=10**24, k=10**25), first_order_lag(10**21)).compile()
    values = f(np.array([1.0, 2.0]))
    assert values.environment_real.tolist() == pytest.approx([0.0, -3e25], rel=1e-14)
    assert values.relative_imag.tolist() == pytest.approx([-1e-21, -2e-21], rel=1e-14)
    assert values.real.dtype == np.float64


def test_compiled_functions_broadcast_their_parameters() -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()
    values = f(np.array([1.0, 2.0, 3.0]), k=np.array([[10.0], [20.0]]), omega_c=2.0)
    assert values.real.shape == (2, 3)
    assert np.allclose(values.real, [[-2.0, -5.0, -10 * 9 / 13], [-4.0, -10.0, -20 * 9 / 13]], rtol=1e-14)


# Digits


@pytest.mark.dear("40-400")
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


def _rounded(ball: Any, count: int) -> Decimal:
    mantissa, exponent = ball.mid().man_exp()
    exact = int(mantissa) * Fraction(2) ** int(exponent)
    return Context(prec=count, rounding=ROUND_HALF_EVEN).divide(Decimal(exact.numerator), Decimal(exact.denominator))


@pytest.mark.parametrize(
    ("environment", "effect", "omega", "count", "expected"),
    [
        (mass_spring_damper(m=1, k=4), shunt(k=1), 2.0, 12, {"ratio_real": "inf", "environment_real": "0", "real": "1.00000000000", "imag": "0"}),
        (mass_spring_damper(m=1, k=4), first_order_lag(2), 2.0, 3, {"ratio_real": "0.500"}),  # 0/0 but in lowest terms
        (mass_spring_damper(k=1), series("5/4"), 1.0, 2, {"perceived_real": "1.2"}),  # 1.25: to the even digit
        (mass_spring_damper(m=1, b=2, k=4), first_order_lag(2), 0.0, 4, {"environment_real": "4.000", "environment_imag": "0", "ratio_real": "0"}),
        (mass_spring_damper(m=2, b=3), series("2"), 0.0, 4, {"ratio_imag": "1.000", "ratio_real": "0"}),
    ],
)  # fmt: skip
def test_digits_of_special_values(
    environment: hs.Environment, effect: hs.Effect, omega: float, count: int, expected: dict[str, str]
) -> None:
    f = hs.distort(environment, effect).compile()
    found, row = f.digits(omega, count), f.digits([[omega]], count)
    for name, text in expected.items():
        assert (getattr(found, name), getattr(row, name).tolist()) == (text, [[text]])
    with pytest.raises(hs.SceneError, match="at least 1"):
        f.digits(omega, 0)


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


@pytest.mark.parametrize(("n", "gain"), [(1, 100), (2, 100), (3, -3), (4, -3), (6, 100)])
def test_at_0_a_delay_without_its_first_terms_is_the_next_term_of_its_series(n: int, gain: int) -> None:
    """g (exp(-s/50) less its Taylor polynomial of n terms)/s^n is g (-1/50)^n/n! at 0; over one more s it is infinite there."""
    tau = Fraction(1, 50)
    terms = [gain * (-tau) ** i / factorial(i) for i in range(n + 2)]
    known = " + ".join(f"({-x})*s^{i}" for i, x in enumerate(terms[:n]))
    for power in (n, n + 1):
        late = hs.Scene(
            mass_spring_damper(k=1),
            (series(str(gain)), hs.effects.delay("20 ms"), shunt(Z=known), series(f"1/s^{power}")),
        )
        response = late.distortion().perc_response
        real, imag = (PointValue(f, fmpq(0)) for f in (response.real, response.imag))
        assert float(real) == pytest.approx(float(terms[power]), rel=1e-15)
        # c_n/(j omega) is -j c_n/omega: infinite with the sign of -c_n
        assert float(imag) == (0 if power == n else -float("inf") * (1 if terms[n] > 0 else -1))
        assert late.distortion().compile()(0.0).perceived_real == pytest.approx(float(terms[power]), rel=1e-14)


# Programs in floats


IN, OTHER, THIRD = Symbol("x"), Symbol("y"), Symbol("z")

UNARY, BINARY = ("neg", "abs", "sqrt", "cos", "sin", "sinc", "sincm1"), ("add", "sub", "mul", "div", "power")


def any_program(seed: int) -> Program:
    """Up to thirty steps, some results the same step, an input or a constant; whatever may share a buffer."""
    pick = random.Random(seed)
    steps = [*(Operation("input", (n,)) for n in range(3)), *(Operation("constant", (), x) for x in (fmpq(3, 7), pi))]
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
                value = inputs[step.arguments[0]] if step.name == "input" else nearest(step.value)
                known.append(np.broadcast_to(np.asarray(value, dtype=float), (size,)).copy())
            else:
                known.append(ufuncs()[step.name](*(known[x] for x in step.arguments)))
    return {name: known[x] for name, x in program.results.items()}


@pytest.mark.few(12)
@pytest.mark.parametrize("seed", range(60))
def test_blocks_and_shared_buffers_give_what_the_steps_give_one_by_one(seed: int) -> None:
    program, rng, size = any_program(seed), np.random.default_rng(seed), (1, 7, BLOCK, BLOCK + 1)[seed % 4]
    inputs = [x if rng.random() < 0.6 else float(rng.normal()) for x in rng.normal(size=(3, size)) * 3]
    out = [np.full(size, -7.0) for _ in program.results]
    Floats(program).run(inputs, size, out)
    expected = step_by_step(program, inputs, size)
    for row, name in zip(out, program.results, strict=True):
        # a library may take a single sine another way than those of an array: within a unit or two of the last place
        assert np.allclose(row, expected[name], rtol=1e-10, atol=1e-12, equal_nan=True)


def test_single_numbers_give_what_arrays_give_also_where_python_refuses_them() -> None:
    for seed in range(30):
        program, rng = any_program(seed), np.random.default_rng(seed)
        for inputs in ([float(x) for x in rng.normal(size=3) * 3], [0.0, -1.0, 0.0]):
            one, row = [np.empty(1) for _ in program.results], [np.empty(2) for _ in program.results]
            Floats(program).run(inputs, 1, one)
            Floats(program).run([np.full(2, x) for x in inputs], 2, row)
            assert np.allclose([x[0] for x in one], [x[0] for x in row], rtol=1e-10, atol=1e-12, equal_nan=True)


def test_threads_that_call_one_function_do_not_share_its_buffers() -> None:
    f = hs.load_scene("delayed-spring").distortion().compile(of=RATIOS)
    grids = [np.geomspace(0.1, 10 + n, size) for n, size in enumerate([500, BLOCK, 500, BLOCK + 7] * 3)]
    alone = [np.array(f(w)) for w in grids]
    with ThreadPoolExecutor(6) as threads:
        together = [*threads.map(f, grids * 20)]
    assert all((np.array(x) == y).all() for x, y in zip(together, alone * 20, strict=True))


def test_what_a_function_returns_stays_as_it_is_when_it_is_called_again() -> None:
    f = hs.load_scene("fu2019").distortion().compile(of=RATIOS)
    first = f(np.linspace(1, 9, 40))
    kept = np.array(first)
    assert (np.array(f(np.linspace(1, 9, 40)[::-1]))[:, ::-1] == kept).all()
    assert (np.array(first) == kept).all()


def test_sin_x_over_x_and_that_less_one_keep_their_digits_for_arguments_of_either_sign_and_any_size() -> None:
    x = np.concatenate([np.geomspace(1e-150, 1e3, 120), np.linspace(1.9, 2.1, 21), [2.0, np.nextafter(2, 3)]])
    for at in (x, -x):
        with mpmath.workdps(400):
            whole = [mpmath.sinc(mpmath.mpf(a)) for a in at.tolist()]
        for f, true in ((sinc_in_floats.sincm1, [y - 1 for y in whole]), (sinc_in_floats.sinc, whole)):
            into = np.empty_like(at)
            for found in (f(at), f(at, into), into, np.array([f(a) for a in at.tolist()])):
                assert all(abs(mpmath.mpf(y) - t) <= 5e-15 * abs(t) for y, t in zip(found.tolist(), true, strict=True))
    with np.errstate(invalid="ignore"):
        assert sinc_in_floats.sincm1(np.array([0.0, -0.0])).tolist() == [0.0, 0.0]
        assert sinc_in_floats.sinc(np.array([0.0])).tolist() == [1.0]


@pytest.mark.parametrize("n", range(4))
def test_the_slopes_of_sin_x_over_x_are_integrals_of_a_cosine(n: int) -> None:
    """The n-th is the integral of u^n cos(x u + n pi/2) over u from 0 to 1; from 3/2 on another formula is used."""
    x = np.array([0.0, 0.3, np.nextafter(1.5, 0), 1.5, 9.0])
    x = np.concatenate([x, -x])
    found = sinc_in_floats.sinc_and_slopes(x)[n].tolist()
    with mpmath.workdps(30):
        for a, slope in zip(x.tolist(), found, strict=True):
            true = mpmath.quad(lambda u, a=a: u**n * mpmath.cos(a * u + n * mpmath.pi / 2), [0, 1])
            assert abs(mpmath.mpf(slope) - true) < 4e-15


def test_a_constant_beyond_doubles_is_infinite_and_others_are_the_nearest() -> None:
    assert nearest(fmpq(10) ** 400) == np.inf
    assert nearest(-(fmpq(10) ** 400)) == -np.inf
    assert nearest(fmpq(1, 3)) == 1 / 3
    assert nearest(fmpq(10) ** 400 / (3 * fmpq(10) ** 400)) == 1 / 3
    assert nearest(pi) == np.pi
    assert type(nearest(fmpq(2))) is np.float64


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


def test_what_double_doubles_lose_is_proven_by_more_bits() -> None:
    """(1 + x) - 1: balls of 128 bits show nothing of 1e-60; points are mixed with easy ones. No closed form is there to be asked."""
    write = Writer((IN, OTHER))
    total = write.sub(write.add(write.input(IN), write.constant(1)), write.constant(1))
    product = write.mul(total, write.input(OTHER))
    proof = Certified(
        write.program({"total": total, "product": product, "third": write.constant(fmpq(1, 3))}), lambda _: {}
    )
    assert proof.at((1e-60, 3.0), ["product", "total"]) == {"total": 1e-60, "product": 1e-60 * 3.0}
    x = np.array([0.5, 1e-60, 1e-20, 7.0, 1e-250])
    for second in (np.full(5, 3.0), 3.0):
        values, _ = proof.run([x, second], 5)
        assert values["total"].tolist() == x.tolist()
        assert values["product"].tolist() == (x * 3.0).tolist()
        assert values["third"].tolist() == [1 / 3] * 5
    shown = proof.number((1e-60, 1.0), "total").digits(20)
    assert Decimal(shown) == Context(prec=20).create_decimal_from_float(1e-60)


# Machine code


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring"])
def test_machine_code_gives_the_same_doubles(name: str) -> None:
    required(NUMBA, find_spec("numba"))
    d = hs.load_scene(name).distortion()
    omega = np.concatenate([[0.0], np.geomspace(1e-9, 1e9, 1001)])
    for of in (("ratio_real",), (*RATIOS, "perceived_real")):
        ours, theirs = (np.array([*d.compile(of=of, engine=x)(omega)]) for x in ("numpy", "numba"))
        if name == "fu2019":
            assert (ours == theirs).all()
        else:  # sines and powers of two libraries: 8 units of the largest term
            assert np.abs(ours - theirs).max() <= 2**-50 * (1 + np.abs(ours)).max()


@pytest.mark.slow
def test_machine_code_leaves_arrays_of_parameters_to_numpy() -> None:
    required(NUMBA, find_spec("numba"))
    omega, values = drawn(FAMILIES["filter"], 20, 5)
    ours, theirs = (FAMILIES["filter"].compile(engine=x)(omega, **values) for x in ("numpy", "numba"))
    assert (np.array(ours) == np.array(theirs)).all()


@pytest.mark.parametrize("accuracy", ["fast", "double-double", "certified"])
def test_a_pole_of_a_display_with_pi_in_it_is_infinite_and_leaves_its_neighbours(accuracy: str) -> None:
    """Friction, 4 F/(pi A), beside H_env = 16 - omega^2: r_i is infinite at 4 rad/s."""
    scene = hs.Scene(hs.environments.mass_spring_damper(m=1, k=16), (hs.effects.coulomb_friction("1 N", "5 cm"),))
    found = scene.distortion().compile(accuracy=accuracy)([1.0, 4.0, 5.0]).ratio_imag
    assert found[1] == np.inf
    assert found[[0, 2]] == pytest.approx([80 / np.pi / 15, 80 / np.pi / 9], rel=1e-14)
