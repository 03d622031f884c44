"""Compiled functions: what each level of accuracy promises, against the chain matrices in ball arithmetic at 1000 bits."""

from __future__ import annotations

import doctest
from collections.abc import Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chainballs import BITS, error_in_ulps, truth
from marks import QUICK_SCENES, often

import haptisym as hs
from haptisym.distortion import Distortion
from haptisym.effects import (
    compliance,
    delay,
    first_order_lag,
    second_order_lowpass,
    series,
    shunt,
    two_port,
    zero_order_hold,
)
from haptisym.environments import expression, kelvin_voigt, mass_spring_damper, zener
from haptisym.numeric import machine, stable
from haptisym.numeric.values import Values

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
    written = stable._Author.results

    def naively(author: Any, H: Any, felt: Any, fraction: Any, relative: Any) -> Any:
        return written(author, H, felt, (author.minus(felt, H), author.write.constant(1)), None)

    monkeypatch.setattr(stable._Author, "results", naively)
    chain = hs.load_scene("fu2019").chain  # fresh: no program of it has been written yet
    values = {p.symbol: p.value for p in hs.load_scene("fu2019").parameters}
    d = chain.at(values).distortion()
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


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_a_sample_and_hold_keeps_its_digits_far_below_its_sampling_rate(engine: str) -> None:
    """Where r_r is (omega T)^2/6: the difference sin(x)/x - 1 would lose all its digits."""
    spring, hold = mass_spring_damper(k=100), zero_order_hold("1 ms")
    for effects in ((hold,), (hold, zero_order_hold("2 ms", name="second")), (hold, delay("0.3 ms")), None):
        d = (hs.Scene(spring, effects) if effects else hs.load_scene("sampled-wall")).distortion()
        omega = np.geomspace(1e-12, 300, 60)
        found = d.compile(of=RATIOS, engine=engine)(omega)._asdict()
        assert against_truth(d, omega, {}, found).max() <= 16.0


# --- machine code ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", often(["fu2019", "delayed-spring", "organ-tissue"], lambda name: name == "fu2019"))
def test_machine_code_gives_the_same_doubles(name: str) -> None:
    d = hs.load_scene(name).distortion()
    omega = np.concatenate([[0.0], np.geomspace(1e-9, 1e9, 1001)])
    ours, theirs = d.compile(of=RATIOS)(omega), d.compile(of=RATIOS, engine="numba")(omega)
    for x, y in zip(ours, theirs, strict=True):
        if name == "fu2019":
            assert (x == y).all()
        else:  # sines and powers of two libraries: 8 units of the largest term
            assert np.abs(x - y).max() <= 2**-50 * (1 + np.abs(x)).max()


def test_machine_code_leaves_arrays_of_parameters_to_numpy() -> None:
    omega, values = drawn(FAMILIES["filter"], 20, 5)
    ours, theirs = (FAMILIES["filter"].compile(engine=x)(omega, **values) for x in ("numpy", "numba"))
    assert (np.array(ours) == np.array(theirs)).all()


def test_without_numba_its_engine_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "find_spec", lambda name: None)
    with pytest.raises(hs.SceneError, match=r'pip install "haptisym\[fast\]"'):
        hs.load_scene("fu2019").distortion().compile(engine="numba")


def test_a_spring_with_a_maxwell_branch_and_the_rendering_of_another_are_certified() -> None:
    d = hs.distort(zener(100, 50, 3), FILTER.with_values({"omega_n": 80, "zeta": "0.5"}), rendered=kelvin_voigt(100, 2))
    omega = np.geomspace(1e-6, 1e6, 15)
    assert against_truth(d, omega, {}, d.compile("certified")(omega)._asdict()).max() <= 1.0


def test_the_examples_of_the_page_run() -> None:
    page = Path(__file__).parent.parent / "docs" / "functions.md"
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted >= 8
    assert result.failed == 0
