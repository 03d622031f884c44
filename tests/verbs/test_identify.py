"""Models fitted to measured responses: against linear least squares and the truth, and said not to fit where they do not."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from collections.abc import Callable
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from jnds import jnds, same_rows
from refusals import refusal
from scipy import stats
from scipy.stats import f as f_distribution
from scipy.stats import norm
from sympy import Rational, pi

import haptisym as hs
from haptisym.model.catalogue import Hand
from haptisym.model.jnd import read_threshold
from haptisym.model.parameters import Rule
from haptisym.model.quantities import Dimension, MotionKind
from haptisym.model.scenefile import read_scenes
from haptisym.verbs.identify.entry import (
    Estimate,
    band_value,
    environment_table,
    estimates,
    even,
    exactly,
    opened,
    rounded,
    scene_text,
    threshold_value,
    verdict,
)
from haptisym.verbs.identify.fitting import Free, Noise, WantedResponse, fit, noise_of, usable, wanted

Called = Callable[..., tuple[int, str, str]]


OMEGA = np.linspace(1, 40, 50)


RAYLEIGH = np.sqrt(-2 * np.log(0.05))


"""The radius of a disc of 95 %, in standard errors of a part."""


def noisy(scene: str | hs.Scene, noise: float, seed: int, omega: np.ndarray = OMEGA) -> hs.Measurement:
    """The exact response with errors of that share of it, and discs that say so."""
    rng = np.random.default_rng(seed)
    exact = hs.sampled(scene, omega)
    sigma = noise * np.abs(exact.H)
    H = exact.H + sigma * (rng.normal(size=len(exact)) + 1j * rng.normal(size=len(exact)))
    return hs.measured(exact.omega, H, radius=sigma * RAYLEIGH, name="bench.csv")


@cache
def paper() -> hs.Identification:
    return hs.identify(noisy("fu2019", 0.01, 5), "mass-spring-damper", ["second-order-lowpass"])


@pytest.mark.slow
def test_a_linear_model_is_that_of_linear_least_squares() -> None:
    felt = noisy("fu2019", 0.02, 3)
    found = hs.identify(felt, "mass-spring-damper")
    s, sigma = 1j * felt.omega, felt.radius / RAYLEIGH
    A = np.stack([s**2, s, np.ones_like(s)], axis=1) / sigma[:, None]
    rows, right = np.vstack([A.real, A.imag]), felt.H / sigma
    values = np.linalg.lstsq(rows, np.concatenate([right.real, right.imag]))[0]
    assert [x.value for x in found.estimates] == pytest.approx(values.tolist(), rel=1e-7)
    errors = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert [x.error for x in found.estimates] == pytest.approx(errors.tolist(), rel=1e-6)
    square = np.square(np.abs((felt.H - s**2 * values[0] - s * values[1] - values[2]) / sigma)).sum()
    assert found.verdict.square == pytest.approx(square, rel=1e-7)
    assert found.verdict.fits is False


@pytest.mark.slow
@pytest.mark.few("own1-mass-spring-damper:k-effects1", "own2-zener-effects2")
@pytest.mark.parametrize(
    ("own", "environment", "effects"),
    [
        (hs.load_scene("fu2019"), "mass-spring-damper", ["second-order-lowpass"]),
        (hs.load_scene("delayed-spring"), "mass-spring-damper:k", ["delay"]),
        (hs.Scene(hs.environments.zener(250, 400, 8)), "zener", []),
        (
            hs.Scene(hs.environments.spring_pot(120, "0.3"), (hs.effects.shunt(m="-0.2 kg"),)),
            "spring-pot:k_alpha,alpha",
            ["shunt:m"],
        ),
        (hs.Scene(hs.environments.two_mass(1, 2, 80, 0.5, 1, 60)), "two-mass", []),
    ],
)
def test_the_parameters_of_a_scene_come_back_from_its_exact_response(
    own: hs.Scene, environment: str, effects: list[str]
) -> None:
    low, high = (float(x) for x in own.band)
    found = hs.identify(hs.sampled(own, np.linspace(low + 0.01 * high, high, 40)), environment, effects)
    for x in found.estimates:
        assert x.value == pytest.approx(float(own.knobs[x.parameter.name].value), rel=1e-4, abs=1e-4), x.parameter.path


@pytest.mark.slow
def test_the_box_of_the_scene_file_holds_the_truth_and_tolerances_takes_it() -> None:
    found = paper()
    assert found.verdict.fits
    scene = hs.parse_scene(found.text)
    assert float(scene.level) == 0.95
    truth = {"m": 1.8, "b": 15, "k": 100, "omega_n": 80, "zeta": 0.5}
    for key, value in truth.items():
        low, high = scene.knobs[key].interval  # type: ignore[misc]
        assert float(low) < value < float(high)
    enclosures = hs.tolerances(scene, samples=0, limit=20).enclosures
    for crossing in hs.evaluate("fu2019").crossings:
        [own] = [x for x in enclosures if x.part is crossing.part]
        assert float(own.low) < float(crossing.omega) < float(own.high)


@pytest.mark.slow
def test_a_model_that_misses_something_does_not_fit_and_gets_no_ranges() -> None:
    found = hs.identify(noisy("fu2019", 0.01, 5), "mass-spring-damper", ["delay"])
    assert found.verdict.fits is False
    assert "rejected: the model does not fit" in " ".join(str(found).split())
    assert found.scene.ranges() == {}
    assert "does NOT fit" in found.text.splitlines()[0]
    assert json.loads(found.to_json())["fits"] is False


def test_small_errors_of_a_model_are_seen_in_the_order_of_the_residuals() -> None:
    omega = np.linspace(1, 40, 400)
    felt = noisy("fu2019", 0.01, 5, omega)
    felt = hs.measured(felt.omega, felt.H * (1 + 0.008 * np.sin(omega / 3)), radius=felt.radius)
    found = hs.identify(felt, degrees=(2, 2))
    assert found.verdict.fits is False
    assert found.verdict.neighbours_chance is not None
    assert found.verdict.neighbours_chance < 0.001


def check_coverage(draws: int, seed: int, averages: int) -> None:
    """Of a spring and a damper, from coherence: the ends hold the truth as often as they say, and the test refutes as seldom."""
    rng = np.random.default_rng(seed)
    omega = np.linspace(1, 30, 30)
    truth = 290 + 2j * omega
    asked = wanted(None, [], (1, 0), None)
    held, box, refuted = [], [], []
    for _ in range(draws):
        x, v = (rng.normal(size=(averages, 30)) + 1j * rng.normal(size=(averages, 30)) for _ in range(2))
        force = truth * x + 0.1 * np.abs(truth) * v
        sxx, sff = (np.square(np.abs(z)).sum(axis=0) for z in (x, force))
        sxf = (np.conj(x) * force).sum(axis=0)
        found = fit(asked, hs.measured(omega, sxf / sxx, coherence=np.abs(sxf) ** 2 / sxx / sff, averages=averages))
        ends = estimates(found)
        held += [e.low <= value <= e.high for e, value in zip(ends, (290, 2), strict=True)]
        box.append(all(e.least <= value <= e.most for e, value in zip(ends, (290, 2), strict=True)))
        refuted.append(verdict(found).fits is False)
    for seen, expected in ((held, 0.95), (box, 0.95), (refuted, 0.05)):
        assert abs(np.mean(seen) - expected) < 4 * np.sqrt(0.05 * 0.95 / draws) + 0.01


@pytest.mark.slow
@pytest.mark.parametrize("averages", [6, 50])
def test_intervals_hold_the_truth_and_true_models_are_refuted_as_often_as_they_say(averages: int) -> None:
    check_coverage(200, 11, averages)


def test_residuals_are_carried_to_chi_square_by_the_quantiles_of_f() -> None:
    noise, sizes = Noise(np.ones(4), 18.0), np.array([0.1, 1.0, 2.0, 5.0])
    tail = f_distribution.sf(sizes**2 / 2, 2, 18)
    assert noise.squares(sizes.astype(complex)) == pytest.approx(-2 * np.log(tail), rel=1e-12)


@pytest.mark.slow
def test_without_discs_the_model_is_untested_and_errors_are_those_of_the_residuals() -> None:
    felt = noisy("fu2019", 0.01, 5)
    found = hs.identify(hs.measured(felt.omega, felt.H), "mass-spring-damper", ["second-order-lowpass"])
    assert found.verdict.fits is None
    assert "not tested" in str(found)
    assert [x.error for x in found.estimates] == pytest.approx([x.error for x in paper().estimates], rel=0.3)
    assert "was not tested" in found.text


@pytest.mark.slow
def test_a_parameter_that_the_lines_do_not_tell_is_named_and_has_no_range() -> None:
    felt = noisy(hs.Scene(hs.environments.kelvin_voigt(290, 2), (hs.effects.first_order_lag(1000),)), 0.02, 5)
    found = hs.identify(felt, "kelvin-voigt", ["first-order-lag"])
    assert [x.parameter.name for x in found.estimates if not x.told] == ["omega_c"]
    assert "do not identify ω_c" in " ".join(str(found).split())
    assert found.scene.ranges() == {}


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(2))
def test_two_delays_in_a_row_are_never_told_apart(seed: int) -> None:
    """Whichever of the two the search left at nothing: they add up, and nothing else of them is in the response."""
    late = hs.Scene(hs.environments.mass_spring_damper(2, 12, 150), (hs.effects.delay("20 ms"),))
    with pytest.raises(
        hs.SceneError, match=r"do not identify effects\.delay\.tau and effects\.delay-2\.tau separately"
    ):
        hs.identify(noisy(late, 0.01, seed), "mass-spring-damper", ["delay", "delay"])


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_a_delay_that_the_lines_speak_against_is_none_at_all() -> None:
    """Lines that lead: a phase that no delay has. SciPy's own divisions by zero on the way stay in there."""
    H = 150 * np.exp(0.01j * OMEGA)
    found = hs.identify(hs.measured(OMEGA, H, radius=0.005 * np.abs(H)), "kelvin-voigt", ["delay"])
    delay = found.estimates[-1]
    assert (delay.parameter.name, delay.value, delay.least) == ("tau", 0, 0)
    assert "exp(" not in str(found)
    assert 'tau = "0 ms"' in found.text
    assert found.verdict.chance == 0
    assert "a probability below 1e-300 if the model" in " ".join(str(found).split())
    correlation, freedom = found.verdict.neighbours, len(OMEGA) - 1
    assert found.verdict.neighbours_chance == pytest.approx(norm.sf(correlation * np.sqrt(2 * freedom)), rel=1e-9)


@pytest.mark.slow
def test_what_should_be_felt_is_known_of_a_measured_scene_and_kept(tmp_path: Path) -> None:
    noisy("fu2019", 0.01, 5).to_csv(tmp_path / "device.csv")
    path = tmp_path / "bench.toml"
    path.write_text(
        '[environment]\nmodel = "mass-spring-damper"\nm = "1.8 kg"\nb = "15 N*s/m"\nk = "100 N/m"\n'
        '[perceived]\nfile = "device.csv"\n[evaluation]\nband = ["1 rad/s", "30 rad/s"]\n'
        'jnd = { shape = "ellipse", real = 0.1, imag = 0.12, tilt = 0.5 }\n',
        encoding="utf-8",
    )
    for found in (hs.identify(path, effects=["second-order-lowpass"]), hs.identify(path, degrees=(0, 2))):
        assert found.verdict.fits
        assert found.scene.environment.H == hs.load_scene("fu2019").environment.H
        assert found.scene.threshold.row() == {"real": "1/10", "imag": "3/25", "shape": "ellipse", "tilt": "1/2"}
        assert float(found.scene.band[1]) < 30
    with pytest.raises(hs.SceneError, match="environment: the scene gives it"):
        hs.identify(path, "mass-spring-damper")


@pytest.mark.dear("words2-do not identify")
@pytest.mark.few(10)
@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "name a model to fit, as --environment mass-spring-damper, or give degrees"),
        (["--environment", "kelvin-voigt:k=1 kg,b"], "not a stiffness"),
        (["--environment", "kelvin-voigt", "--effect", "delay", "--effect", "delay"], "do not identify"),
        (["--degrees", "1", "0", "--band", "50 rad/s", "60 rad/s"], "bench.csv has no frequency point"),
        (
            ["--degrees", "1", "0", "--band", "30 rad/s", "3 rad/s"],
            "the high end, 3 rad/s, must be above the low end, 30 rad/s",
        ),
        (["--degrees", "1", "0", "--band", "1 kg", "60 rad/s"], "band"),
        (
            ["--degrees", "5", "5", "--band", "1 rad/s", "3 rad/s"],
            "11 parameters need at least 6 frequency points, not 3",
        ),
        (["--degrees", "1", "0", "--averages", "9"], "averages needs the column coherence"),
        (["--degrees", "1", "0", "--scene", "{folder}/bench.csv"], "would be overwritten"),
        (["--degrees", "1", "0", "--scene", "{folder}/none/x.toml"], "no folder"),
    ],
)
def test_what_cannot_be_fitted_is_refused_in_one_sentence(
    tmp_path: Path, call: Called, words: list[str], told: str
) -> None:
    noisy("fu2019", 0.01, 5).to_csv(tmp_path / "bench.csv")
    status, out, err = call("identify", str(tmp_path / "bench.csv"), *(x.format(folder=tmp_path) for x in words))
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert told in err


def test_discs_that_cannot_be_weights_are_refused() -> None:
    for certainty, told in (
        ({"coherence": [0.9, 1, 0.9], "averages": 9}, "has radius 0"),
        ({"coherence": [0, 0, 0], "averages": 9}, "has a bounded uncertainty disc"),
    ):
        with pytest.raises(hs.SceneError, match=told):
            hs.identify(hs.measured([1, 2, 3], [1, 1j, 2], **certainty), "kelvin-voigt")  # type: ignore[arg-type]
    for other, told in ((3, "is no measured response"), ("fu2019.toml", 'no such file: did you mean "fu2019"')):
        with pytest.raises(hs.SceneError, match=told):
            hs.identify(other, "kelvin-voigt")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["fu2019"], "its simulated bench run is fu2019-bench"),
        (["zener-tissue"], "simulated bench runs are delayed-spring-bench, fu2019-bench, fu2019-clipped-bench"),
        (["fu2019-bench"], "name the effects to fit, as --effect delay, or --degrees 1 2; effects are first-order-lag"),
        (["fu2019-bench", "--effect", "delay:tau=1 ms"], "leave out the value of at least one"),
        (["fu2019-bench", "--model"], "Environments are mass-spring-damper"),
        (["fu2019-bench", "--model", "zener"], "effects are first-order-lag"),
        (["fu2019-bench", "--environment"], "--environment needs a model: valid are mass-spring-damper"),
        (["fu2019-bench", "--effect", "--json"], "--effect needs a model: valid are first-order-lag"),
    ],
)
def test_what_is_meant_is_named(call: Called, words: list[str], told: str) -> None:
    status, out, err = call("identify", *words)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert told in err


@pytest.mark.slow
def test_a_record_in_time_is_named_as_what_it_is(call: Called) -> None:
    record = str(Path(hs.__file__).parent / "benches" / "fu2019-bench.csv")
    status, out, err = call("identify", record, "--environment", "mass-spring-damper")
    assert (status, out, err.count("\n")) == (2, "", 1)
    way = re.findall(r'--estimator \S+|--segment "[^"]+"', err)
    assert len(way) == 2
    assert "records in time" in err
    status, out, err = call("identify", record, "--environment", "mass-spring-damper", *shlex.split(" ".join(way)))
    assert status == 0
    assert "Parameters" in out


@pytest.mark.slow
def test_the_command_line_says_the_same_in_every_form(tmp_path: Path, call: Called) -> None:
    noisy("fu2019", 0.01, 5).to_csv(tmp_path / "bench.csv")
    words = (
        "identify",
        str(tmp_path / "bench.csv"),
        "--environment",
        "mass-spring-damper",
        "--effect",
        "second-order-lowpass",
    )
    scene, files = tmp_path / "found.toml", {x: tmp_path / f"page.{x}" for x in ("tex", "html", "svg")}
    status, out, _ = call(
        *words, "--json", "--scene", str(scene), "--latex", str(files["tex"]), "--report", str(files["html"]),
        "--figure", str(files["svg"]),
    )  # fmt: skip
    found = json.loads(out)
    assert (status, found["schema"], found["certified"], found["fits"]) == (0, "haptisym.identification/1", False, True)
    assert scene.read_text(encoding="utf-8") == found["scene"]
    assert [x["path"] for x in found["parameters"]][-1] == "effects.second-order-lowpass.zeta"
    assert "Estimated (95" in files["tex"].read_text(encoding="utf-8")
    assert "<svg" in files["html"].read_text(encoding="utf-8")
    assert call("evaluate", str(scene), "--json")[0] == 0


W = np.linspace(1, 20, 24)
S = 1j * W


# What is wanted.


@pytest.mark.parametrize(
    ("environment", "effects", "paths"),
    [
        ("kelvin-voigt", [], "k b"), ("mass-spring-damper", [], "m b k"), ("mass-spring-damper:k", [], "k"), ("mass-spring-damper:k,m", [], "k m"),
        ("kelvin-voigt:b=2", [], "k"), ("zener:b1", [], "b1 k0 k1"), ("prony:k=2,b=2", [], "k[1] k[2] b[1] b[2] k0"), ("spring-pot", [], "k_alpha alpha k"),
        ("kelvin-voigt", ["delay", "delay"], "k b delay.tau delay-2.tau"), ("kelvin-voigt:k", ["shunt"], "k b shunt.m shunt.b shunt.k"),
        ("kelvin-voigt", ["shunt:m,b=2"], "k b shunt.m"), ("kelvin-voigt", ["second-order-lowpass:zeta=0.5"], "k b second-order-lowpass.omega_n"),
        ("kelvin-voigt", ["pade-delay:order=3"], "k b pade-delay.tau"), ("kelvin-voigt", ["sampled-loop:method=tustin"], "k b sampled-loop.T"),
        (" kelvin-voigt : k , b = 2 ", [" delay "], "k delay.tau"), ("maxwell", ["compliance"], "k b compliance.k compliance.b"),
    ],
)  # fmt: skip
def test_a_model_has_the_parameters_that_are_named_and_those_that_it_needs(
    environment: str, effects: list[str], paths: str
) -> None:
    found = wanted(environment, effects, None, None)
    assert [x.path.removeprefix("environment.").removeprefix("effects.") for x in found.free] == paths.split()
    assert len({x.symbol for x in found.free}) == len(found.free)
    assert [x.name for x in found.free] == [p.rpartition(".")[2] for p in paths.split()]
    own, others = found.elements(lambda x: 0.5 if x.rule is Rule.FRACTION else 3.0)
    assert own.model == environment.partition(":")[0].strip()
    assert [x.model for x in others] == [x.partition(":")[0].strip() for x in effects]


@pytest.mark.parametrize(
    ("environment", "effects", "degrees", "told"),
    [
        ("kelvin", [], None, 'environment: unknown model "kelvin": did you mean "kelvin-voigt"?'), ("kelvin-voigt", ["dely"], None, 'effect: unknown model "dely"'),
        ("expression", [], None, "expression: a formula has no parameters to fit"), ("kelvin-voigt", ["series"], None, "series: a formula"),
        ("kelvin-voigt:q", [], None, 'kelvin-voigt: unknown parameter "q": valid are k, b'), ("kelvin-voigt:", [], None, 'unknown parameter ""'),
        ("kelvin-voigt:k,k", [], None, "kelvin-voigt: k is there twice"), ("prony:k=0,b=1", [], None, "k: give the number of entries, as k=2"), ("prony:k=100,b=1", [], None, "give the number of entries"),
        ("kelvin-voigt", ["pade-delay"], None, "order: cannot be fitted: give it, as order=1"),
        ("kelvin-voigt", ["sampled-loop"], None, ""), ("kelvin-voigt:k=1,b=2", [], None, "no parameter is free: leave out the value"),
        (None, [], None, "name a model to fit, as environment = "), ("kelvin-voigt", [], (1, 1), "degrees: a fraction replaces the model"),
        (None, [], (13, 0), "degrees: 13 and 0 must be whole numbers from 0 to 12"), (None, [], (0, -1), "degrees: 0 and -1 must"), (None, [], (True, 1), "must be whole"),
        (None, [], (12, 3), ""), (None, [], (12, 4), "17 parameters are free: at most 16"), (None, ["delay"], (12, 3), "17 parameters"), (None, ["delay"], (1, 1), ""),
        (None, ["shunt"], (1, 1), "degrees: a fraction is fitted with a delay only"), ("kelvin-voigt", ["shunt:Z"], None, 'unknown parameter "Z": valid are m, b, k'),
    ],
)  # fmt: skip
def test_what_cannot_be_wanted_is_told(environment: str | None, effects: list[str], degrees: Any, told: str) -> None:
    said = refusal(wanted, environment, effects, degrees, None)
    assert told in said
    assert bool(told) == bool(said)


@pytest.mark.few("0-0")
@pytest.mark.parametrize(("above", "below"), [(0, 0), (1, 2), (3, 1)])
def test_a_fraction_is_a_polynomial_over_one_that_begins_with_1(above: int, below: int) -> None:
    found = wanted(None, ["delay"], (above, below), None)
    values = {x.name: i + 2.0 for i, x in enumerate(found.free)}
    own, _ = found.elements(lambda x: values[x.name])
    top = sum(values[f"a{i}"] * S**i for i in range(above + 1))
    bottom = 1 + sum(values[f"d{i}"] * S**i for i in range(1, below + 1))
    assert found.words == "expression, delay"
    assert pytest.approx(top / bottom, rel=1e-12) == hs.sampled(hs.Scene(own, (), (0, 20)), W).H
    curve = WantedResponse(found, W)
    at = np.array([values[x.name] for x in found.free])
    assert pytest.approx(top / bottom * np.exp(-S * values["tau"]), rel=1e-12) == curve.at(at)
    both = curve(np.array([at, 2 * at]))
    assert (both.shape, np.allclose(both[0], curve.at(at)), np.allclose(both[1], curve.at(2 * at))) == (
        (2, 24),
        True,
        True,
    )
    slopes = curve.slopes(at, 1e-5 * at)
    for i in range(len(at)):
        step = np.where(np.arange(len(at)) == i, 1e-4 * at, 0)
        assert (
            pytest.approx(
                (curve.at(at + step) - curve.at(at - step)) / (2 * step.max()),
                rel=1e-4,
                abs=1e-4 * np.abs(slopes[:, i]).max(),
            )
            == slopes[:, i]
        )
    known = hs.environments.kelvin_voigt(100, 2)
    behind = wanted(None, [], (above, below), (known, environment_table(known)))
    assert [x.path for x in behind.free] == [f"effects.fraction.{x}" for x in values if x != "tau"]
    assert behind.elements(lambda x: values[x.name])[0] is known


# Weights, residuals and curvature.


def lines_of(kind: str, model_error: float = 0.0, seed: int = 1) -> hs.Measurement:
    rng = np.random.default_rng(seed)
    truth = 290 + 6 * S
    errors = 0.03 * np.abs(truth) * (rng.normal(size=24) + 1j * rng.normal(size=24))
    H = truth * (1 + model_error * np.sin(W / 3)) + errors
    certainty: dict[str, Any] = {
        "coherence": {"coherence": np.linspace(0.97, 0.99, 24), "averages": 12, "confidence": 0.9},
        "radius": {"radius": 0.03 * np.sqrt(-2 * np.log(0.05)) * np.abs(truth)}, "none": {},
    }[kind]  # fmt: skip
    return hs.measured(W, H, name="bench.csv", **certainty)


@cache
def identified(kind: str, model_error: float = 0.0) -> hs.Identification:
    """Fitted from one start: it is a linear model."""
    felt = lines_of(kind, model_error)
    found = fit(wanted("kelvin-voigt", [], None, None), felt, [np.array([250.0, 5.0])])
    return hs.Identification(felt, hs.Threshold(), "kelvin-voigt, as measured", found, estimates(found), verdict(found))


def sigma_of(m: hs.Measurement) -> tuple[Any, float | None]:
    """Of each part of a line, by the quantile of its disc: chi-squared, or F where the disc is estimated."""
    if m.coherence is not None:
        freedom = 2 * m.averages - 2  # type: ignore[operator]
        return m.discs / np.sqrt(2 * stats.f(2, freedom).ppf(m.confidence)), freedom
    if m.radius is not None:
        return m.radius / np.sqrt(stats.chi2(2).ppf(m.confidence)), np.inf
    return np.abs(m.H), None


@pytest.mark.parametrize("kind", ["coherence", "radius", "none"])
def test_weights_are_standard_errors_of_the_discs_and_intervals_those_of_linear_least_squares(kind: str) -> None:
    m = lines_of(kind)
    sigma, freedom = sigma_of(m)
    noise = noise_of(m)
    assert noise.sigma == pytest.approx(sigma, rel=1e-9)
    assert noise.freedom == freedom
    found = identified(kind)
    rows = (
        np.vstack([(x / sigma).reshape(-1, 1) for x in (np.ones(24), np.zeros(24))]),
        np.vstack([(x / sigma).reshape(-1, 1) for x in (np.zeros(24), W)]),
    )
    A, y = np.hstack(rows), np.concatenate([m.H.real / sigma, m.H.imag / sigma])
    values, *_ = np.linalg.lstsq(A, y)
    assert [x.value for x in found.estimates] == pytest.approx(values.tolist(), rel=1e-6)
    rest = y - A @ values
    widening = freedom / (freedom - 4) if freedom and np.isfinite(freedom) else 1.0
    covariance = np.linalg.inv(A.T @ A) * widening * ((rest @ rest) / 46 if kind == "none" else 1)
    assert found.fit.covariance == pytest.approx(covariance, rel=1e-4, abs=1e-12)
    assert found.fit.freedom == 46
    square = np.abs(rest[:24] + 1j * rest[24:]) ** 2
    if freedom and np.isfinite(freedom):
        square = stats.chi2(2).isf(stats.f(2, freedom).sf(square / 2))
    if kind == "none":
        assert (found.verdict.square, found.verdict.chance) == (None, None)
    else:
        assert found.verdict.square == pytest.approx(square.sum(), rel=1e-6)
        assert found.verdict.chance == pytest.approx(stats.chi2(46).sf(square.sum()), rel=1e-5)
    shown = (rest[:24] + 1j * rest[24:]) / np.abs(rest[:24] + 1j * rest[24:]) * np.sqrt(square)
    assert pytest.approx(shown, rel=1e-4, abs=1e-6) == even(found.fit)
    together = float((shown[1:] * np.conj(shown[:-1])).real.mean() / np.square(np.abs(shown)).mean())
    assert found.verdict.neighbours == pytest.approx(together, abs=1e-4)
    assert found.verdict.neighbours_chance == pytest.approx(stats.norm.sf(together * np.sqrt(2 * 23)), rel=1e-2)
    spare = 1 - m.confidence
    law = stats.t(46) if kind == "none" else stats.norm()
    for x, value, error in zip(found.estimates, values, np.sqrt(np.diag(covariance)), strict=True):
        assert x.error == pytest.approx(error, rel=1e-4)
        for ends, share in (((x.low, x.high), spare / 2), ((x.least, x.most), spare / 4)):
            reach = law.isf(share) * error
            assert ends == pytest.approx((value - reach, value + reach), rel=1e-4, abs=1e-3 * reach)
            assert ends[0] <= value <= ends[1]
    assert found.fit.residuals == pytest.approx(rest[:24] + 1j * rest[24:], abs=1e-5)
    d = found.to_dict()
    errors = np.sqrt(np.diag(covariance))
    assert np.array(d["correlation"]) == pytest.approx(covariance / np.outer(errors, errors), abs=1e-4)
    assert (d["measurement"], d["lines"], d["left_out"], d["model"], d["certified"]) == (
        "bench.csv",
        24,
        0,
        "kelvin-voigt",
        False,
    )
    assert d["parameters"] == [
        {"path": x.parameter.path, "value": x.value, "error": x.error, "interval": [x.low, x.high], "box": [x.least, x.most], "unit": unit, "told": x.told}
        for x, unit in zip(found.estimates, ("N/m", "N*s/m"), strict=True)
    ]  # fmt: skip
    told = found.verdict
    assert (d["fits"], d["chi_square"], d["degrees_of_freedom"], d["probability"]) == (
        told.fits,
        told.square,
        46,
        told.chance,
    )
    assert (d["neighbours"], d["neighbours_probability"], d["scene"]) == (
        told.neighbours,
        told.neighbours_chance,
        found.text,
    )
    assert (d["starts"], d["agreeing"], d["confidence"]) == (1, 1, m.confidence)
    assert d["rows"][3] == {"omega": W[3], "model": [found.fit.model[3].real, found.fit.model[3].imag],
                            "residual": [found.fit.residuals[3].real, found.fit.residuals[3].imag]}  # fmt: skip
    assert [x["omega"] for x in d["rows"]] == W.tolist()


def test_lines_without_discs_weigh_as_their_sizes_and_those_of_nothing_as_the_middle_one() -> None:
    for sizes, sigma in (
        ([0, 0, 0], [1, 1, 1]),
        ([3, 0, 5], [3, 3, 5]),
        ([0, 0, 7], [1, 1, 7]),
        ([2, 1, 9, 0], [2, 1, 9, 1.5]),
    ):
        noise = noise_of(hs.measured(range(1, len(sizes) + 1), [1j * x for x in sizes]))
        assert (noise.sigma.tolist(), noise.freedom) == (sigma, None)


def test_all_parameters_that_lines_do_not_tell_apart_are_named() -> None:
    w = np.linspace(1, 20, 24)
    m = hs.measured(w, 100 + 3j * w, radius=np.full(24, 0.1))
    for key, value in (("k", 50.0), ("b", 1.5)):
        start = np.array([100 - value if key == "k" else 100, 3 - value if key == "b" else 3, value])
        said = refusal(fit, wanted("kelvin-voigt", [f"shunt:{key}"], None, None), m, [start])
        assert said.startswith(f"The data do not identify environment.{key} and effects.shunt.{key} separately")


def test_what_the_scene_file_says_follows_from_whether_the_model_holds() -> None:
    told = {
        (
            "radius",
            0.0,
        ): "# Ranges: together they hold the true values with a confidence of about 95 %, if the model is right\n# and the errors are as the discs say.",
        ("none", 0.0): "if the model is right,\n# which was not tested: no discs of the lines are known.",
        (
            "radius",
            0.15,
        ): "# This model does NOT fit what was measured: its parameters are those nearest to it, and have no ranges.",
    }
    for (kind, error), words in told.items():
        found = identified(kind, error)
        assert words in found.text
        ranges = found.scene.ranges()
        assert bool(ranges) == (error == 0)
        for x in found.estimates if ranges else ():
            low, high = ranges[x.parameter.path].interval  # type: ignore[misc]
            assert float(ranges[x.parameter.path].value) == x.written
            wider = 0.11 * (x.most - x.least)  # rounded outward in a digit worth a tenth of it
            assert x.least - wider < float(low) <= x.least < x.most <= float(high) < x.most + wider
            assert abs(x.written - x.value) < x.error / 100
        assert found.scene.title == "kelvin-voigt, as measured"
        assert found.scene.source == "fitted to bench.csv by haptisym identify"
        assert [float(x) for x in found.scene.band] == [1, 20]
    assert identified("coherence").confidence_words == "about 90 %"
    assert repr(identified("radius")).endswith(": 2 parameters, fits>")
    assert repr(identified("radius", 0.15)).endswith(": 2 parameters, does NOT fit>")
    assert repr(identified("none")).endswith(": 2 parameters, untested>")


def estimate(rule: Rule, value: float, least: float, most: float) -> Estimate:
    return Estimate(Free("x.y", hs.symbols("y"), Dimension.MASS, rule), value, 1.0, least, most, least, most)


def test_a_parameter_is_told_where_its_range_means_something() -> None:
    assert estimate(Rule.POSITIVE, 1, 0.5, 2).told
    assert not estimate(Rule.POSITIVE, 1, 0.5, 2.001).told
    assert [estimate(Rule.POSITIVE, 3, 2, most).told for most in (6, 6.001)] == [True, False]
    assert [estimate(Rule.POSITIVE, 0.1, 0.01, most).told for most in (0.2, 0.201)] == [True, False]
    assert estimate(Rule.FRACTION, 0.5, 0.06, 0.95).told
    assert not estimate(Rule.FRACTION, 0.5, 0.04, 0.95).told
    assert estimate(Rule.NONNEGATIVE, 1, 0, 90).told


def test_intervals_keep_the_rules_of_their_parameters() -> None:
    """On the logarithm of what is positive, on the odds of a fraction, and not below 0 of what may be nothing."""
    asked = wanted("spring-pot:k_alpha,alpha", ["shunt:m", "second-order-lowpass"], None, None)
    own = hs.Scene(
        hs.environments.spring_pot(100, "0.3"),
        (hs.effects.shunt(m="-0.2 kg"), hs.effects.second_order_lowpass(15, "0.05")),
    )
    exact = hs.sampled(own, W)
    m = hs.measured(W, exact.H, radius=0.3 * np.abs(exact.H))
    found = fit(asked, m, [np.array([100.0, 0.3, -0.2, 15.0, 0.05])])
    seen = set()
    for x in estimates(found):
        value, error = x.value, x.error
        seen.add(x.parameter.rule)
        for (low, high), share in (((x.low, x.high), 0.025), ((x.least, x.most), 0.005)):
            reach = stats.norm.isf(share) * error
            if x.parameter.rule is Rule.POSITIVE:
                ends = value * np.exp(-reach / value), value * np.exp(reach / value)
            elif x.parameter.rule is Rule.FRACTION:
                odds = np.log(value / (1 - value)) + np.array([-1, 1]) * reach / (value * (1 - value))
                ends = tuple(1 / (1 + np.exp(-odds)))
            else:
                ends = max(value - reach, 0.0) if x.parameter.rule is Rule.NONNEGATIVE else value - reach, value + reach
            assert (low, high) == pytest.approx(ends, rel=2e-5, abs=1e-12)
    assert seen == {Rule.POSITIVE, Rule.FRACTION, Rule.NONNEGATIVE, Rule.ANY}


@given(st.floats(-1e6, 1e6, allow_subnormal=False))
def test_ends_are_rounded_outward_to_six_digits(x: float) -> None:
    low, high = (Decimal(repr(rounded(x, way))) for way in ("ROUND_FLOOR", "ROUND_CEILING"))
    assert low <= Decimal(x) <= high
    assert all(len(y.normalize().as_tuple().digits) <= 6 for y in (low, high))
    assert high - low <= abs(Decimal(x)) * Decimal("1e-5")


def test_lines_without_a_phase_or_a_disc_are_not_fitted() -> None:
    felt = hs.measured([0, 1, 2, 3], [1, 2, 3, 4], radius=[1, np.inf, 1, 0.5])
    assert usable(felt).omega.tolist() == [2, 3]
    assert usable(hs.measured([0, 1, 2], [1, 2, 3], coherence=[0.5, 0, 0.5], averages=9)).omega.tolist() == [2]
    assert usable(hs.measured([0, 1], [1, 2])).omega.tolist() == [1]
    assert "no frequency point above 0 rad/s has" in refusal(usable, hs.measured([0], [1]))
    for averages, told in ((3.9, "averages: 3.9 are too few: at least 4 are needed"), (4, "")):
        assert refusal(noise_of, hs.measured([1, 2], [1, 2], coherence=[0.9, 0.8], averages=averages)) == told
    assert "the disc at 2 rad/s has radius 0" in refusal(noise_of, hs.measured([1, 2], [1, 2], radius=[1, 0]))
    assert noise_of(hs.measured([1, 2, 3], [0, 2, 4])).sigma.tolist() == [2, 2, 4]
    asked = wanted("kelvin-voigt", [], None, None)
    assert "2 parameters need at least 2 frequency points, not 1" in refusal(fit, asked, hs.measured([1], [1 + 1j]))
    assert Noise(np.ones(1), 5.0).widening == 5
    assert Noise(np.ones(1), np.inf).widening == Noise(np.ones(1), None).widening == 1


# Scene files.

TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)


VALUES = st.recursive(
    TEXTS | st.integers(-9, 9),
    lambda x: st.lists(x, max_size=3) | st.dictionaries(st.sampled_from("abc"), x, max_size=3),
    max_leaves=4,
)


@given(
    TEXTS,
    TEXTS,
    st.lists(
        st.tuples(st.sampled_from(["one", "two"]), st.dictionaries(st.sampled_from("pqr"), VALUES, max_size=3)),
        max_size=2,
        unique_by=lambda x: x[0],
    ),
)
def test_a_scene_file_reads_back_as_it_was_written(
    title: str, source: str, tables: list[tuple[str, dict[str, Any]]]
) -> None:
    text = scene_text(title, source, ["first", "second"], [(f"[{name}]", table) for name, table in tables])
    assert text.startswith("# first\n# second\n")
    assert tomllib.loads(text) == {"title": title, **({"source": source} if source else {}), **dict(tables)}


ENVIRONMENTS = [
    hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m +- 5 %", ["90 N/m", "100 N/m", "120 N/m"]), hs.environments.kelvin_voigt("2 N*m/rad", 3),
    hs.environments.zener(1, "2/3", 5), hs.environments.prony("200 N/m", ["300 N/m", "1/3 N/m"], ["6 N*s/m", "2 N*s/m"]), hs.environments.spring_pot(100, "0.25", k="20 N/m"),
    hs.environments.two_mass(1, 2, 3, 4, 5, 6), hs.environments.expression("k + w*s/(s + w)", parameters={"k": "90 N/m", "w": [3, 5]}), hs.environments.maxwell(1, 2),
]  # fmt: skip


@pytest.mark.parametrize("own", ENVIRONMENTS, ids=[x.model for x in ENVIRONMENTS])
def test_an_environment_is_written_as_it_is(own: hs.Environment) -> None:
    again = read_scenes(scene_text("", "", [], [("[environment]", environment_table(own))])).only().environment
    assert again.H == own.H
    assert [(p.key, p.value, p.interval, p.motion) for p in again.parameters] == [
        (p.key, p.value, p.interval, p.motion) for p in own.parameters
    ]


@pytest.mark.slow
@example({"real": {"higher": "1/10", "lower": "1/5"}, "imag": "0.1 + omega", "floor": "3"})
@example({"shape": "ellipse", "real": "1/10", "imag": "1/5", "tilt": "-1/2"})
@example({"shape": "polygon", "corners": [["1", "0"], ["0", "1 + omega"], ["-1", "-1"]]})
@given(jnds())
def test_a_jnd_is_written_as_it_is(table: dict[str, Any]) -> None:
    own = read_threshold(table)
    again = read_threshold(threshold_value(own))
    assert same_rows(again.row(), own.row())


def test_ranges_sources_and_proportions_of_a_jnd_are_written_and_what_has_no_number_is_refused() -> None:
    for given_ in ({"real": [0.1, 0.2], "imag": "0.2 +- 10 %", "proportion": 0.75}, {"like": "weight"}, {"real": {"higher": 0.1, "lower": 0.3}, "imag": 1, "floor": 2},
                   {"shape": "polygon", "corners": [[1, 0], [0, 1], [-1, -1]], "proportion": "0.8"}, {"shape": "ellipse", "real": 1, "imag": 2, "tilt": 0.5}):  # fmt: skip
        own = read_threshold(given_)
        again = read_threshold(threshold_value(own))
        assert (again, again.source, again.proportion, again.ranges) == (own, own.source, own.proportion, own.ranges)
    assert "cannot be written in a scene file: give a rational number" in refusal(
        threshold_value, hs.Threshold.of(pi / 30)
    )


def test_a_number_is_written_exactly_and_in_hertz_where_pi_is_in_it() -> None:

    assert exactly(30 * pi, Dimension.FREQUENCY, "rad/s") == "15 Hz"
    assert exactly(Rational(7, 3), Dimension.FREQUENCY, "rad/s") == "7/3 rad/s"
    assert exactly(Rational(7, 3), Dimension.MASS, "kg") == "7/3 kg"
    assert exactly(pi / 3, Dimension.MASS, "") == repr(float(pi / 3))
    assert band_value(0.1, 1 / 3) == ["0.1 rad/s", "0.3334 rad/s"]
    assert band_value(2 * np.pi / 3, 7, in_hertz=True) == ["0.3333 Hz", "1.115 Hz"]
    assert band_value(2 * np.pi / 5, 40 * np.pi) == ["0.2 Hz", "20 Hz"]


# What is given.


@pytest.mark.slow
def test_a_measured_scene_gives_what_should_be_felt_its_band_its_jnd_and_its_title() -> None:
    own = hs.environments.kelvin_voigt("290 N/m", 6)
    scene = hs.MeasuredScene(own, lines_of("radius"), (2, 15), 0.2, title="On the bench")
    found = hs.identify(scene, effects="shunt:b")
    assert (found.title, found.threshold.real, found.motion) == (
        "On the bench",
        read_threshold(0.2).real,
        MotionKind.TRANSLATION,
    )
    assert (found.fit.lines.omega.min() >= 2, found.fit.lines.omega.max() <= 15) == (True, True)
    assert found.scene.environment.H == own.H
    assert found.wanted.words == "kelvin-voigt, shunt"
    both = hs.MeasuredScene(lines_of("radius"), lines_of("radius"))
    for call, told in (
        ((scene, "maxwell"), "environment: the scene gives it: leave it out"), ((scene,), "no parameter is free: name the effects to fit"),
        ((both, "maxwell"), "environment and perceived are both measured"), ((Hand("x"), "maxwell"), "Hand is no measured response"),
        (("fu2019", "maxwell"), "its simulated bench run is fu2019-bench"), (("palpation-device", "maxwell"), "this shipped scene has formulas"),
    ):  # fmt: skip
        assert told in refusal(hs.identify, *call)
    assert "averages: is for a file of frequency points" in refusal(hs.identify, scene, effects=["delay"], averages=9)
    assert "confidence: is for a file of frequency points" in refusal(
        hs.identify, lines_of("none"), "maxwell", confidence=0.9
    )


def test_a_file_is_opened_as_what_it_holds(tmp_path: Path) -> None:
    lines, formulas, measured = (tmp_path / x for x in ("lines.csv", "formulas.toml", "bench.toml"))
    hs.measured([1, 2], [3, 4]).to_csv(lines)
    formulas.write_text('environment = { model = "kelvin-voigt", k = 1, b = 2 }', encoding="utf-8")
    measured.write_text(formulas.read_text(encoding="utf-8") + '\n[perceived]\nfile = "lines.csv"\n', encoding="utf-8")
    assert isinstance(opened(lines), hs.Measurement)
    assert isinstance(opened(str(measured)), hs.MeasuredScene)
    assert opened(lines, confidence=0.5).confidence == 0.5  # type: ignore[union-attr]
    given_ = opened(lines)
    assert opened(given_) is given_
    for path, keys, said in ((formulas, {}, "formulas.toml: this scene has formulas, no measured response"), (measured, {"averages": 9}, "averages: is for a file of frequency points"),
                             (given_, {"confidence": 0.9}, "confidence: is for"), (lines, {"averages": 9}, "averages needs the column coherence"),
                             (tmp_path / "none.csv", {}, "there is no such file")):  # fmt: skip
        assert said in refusal(opened, path, **keys)


# --- other answers -----------------------------------------------------------------------------------------------------


def found_with(scene: hs.Scene, environment: str, effects: list[str]) -> hs.Identification:
    return hs.identify(noisy(scene, 0.02, 3), environment, effects)


def test_a_maxwell_element_behind_a_lag_has_two_answers_and_both_are_named() -> None:
    """Its own corner k/b and that of the lag may change places: b stays, k becomes b omega_c, and omega_c k/b."""
    scene = hs.Scene(hs.environments.maxwell(300, 6), (hs.effects.first_order_lag(12),), (1, 40))
    found = found_with(scene, "maxwell", ["first-order-lag"])
    [other] = found.fit.others or ()
    k, b, w = found.fit.values
    assert other == pytest.approx([b * w, b, k / b], rel=1e-5)
    assert WantedResponse(found.wanted, OMEGA).at(other) == pytest.approx(found.fit.model, rel=1e-6)
    assert sorted([k, other[0]]) == pytest.approx([72, 300], rel=0.05)
    assert found.ambiguous == ("environment.k", "effects.first-order-lag.omega_c")
    assert "The same response" in str(found)
    assert "# The same response: environment.k" in found.text
    assert "unless the true values are those of another answer" in found.text
    written = tomllib.loads(found.text)["environment"]["b"][1]  # three digits of 0.02 noise, not sixteen
    assert float(written.split()[0]) == pytest.approx(b, abs=found.estimates[1].error / 100)
    assert len(written.split()[0]) < 8
    [row] = found.to_dict()["others"]
    assert row["environment.k"] == other[0]


@pytest.mark.few("two lags", "three corners", "lag and hold")
@pytest.mark.parametrize(
    ("environment", "effects", "count"),
    [
        (hs.environments.mass_spring_damper(1.8, 15, 100), [("second-order-lowpass", hs.effects.second_order_lowpass(80, "0.5"))], 0),
        (hs.environments.zener(300, 200, 5), [("first-order-lag", hs.effects.first_order_lag(20))], 0),
        (hs.environments.kelvin_voigt(300, 2), 2 * [("first-order-lag", None)], 1),
        (hs.environments.maxwell(300, 6), 2 * [("first-order-lag", None)], 5),  # three corners in any order
        # its period stands in a delay, which keeps its value, and in a coefficient
        (hs.environments.kelvin_voigt(300, 6), [("zero-order-hold", hs.effects.zero_order_hold("20 ms"))], 0),
        (hs.environments.maxwell(300, 6), [("first-order-lag", None), ("zero-order-hold", hs.effects.zero_order_hold("20 ms"))], 1),
    ],
    ids=["paper", "zener", "two lags", "three corners", "hold", "lag and hold"],
)  # fmt: skip
def test_as_many_answers_are_named_as_there_are_orders_of_what_changes_places(
    environment: hs.Environment, effects: list[Any], count: int
) -> None:
    chain = [x or hs.effects.first_order_lag(corner) for (_, x), corner in zip(effects, (12, 90), strict=False)]
    found = found_with(hs.Scene(environment, chain, (1, 40)), environment.model, [name for name, _ in effects])
    assert found.fit.others is not None
    assert len(found.fit.others) == count
    for other in found.fit.others:
        assert WantedResponse(found.wanted, OMEGA).at(other) == pytest.approx(found.fit.model, rel=1e-5)


def test_of_delays_that_evenly_spaced_lines_cannot_tell_apart_the_shortest_is_kept() -> None:
    """Lines at 1, 2, ... rad/s: a delay that is 2 pi s longer is the same to all of them."""
    scene = hs.Scene(hs.environments.kelvin_voigt(300, 9), (hs.effects.delay("50 ms"),), (1, 40))
    asked = wanted("kelvin-voigt", ["delay"], None, None)
    late = np.array([300, 9, 0.05 + 2 * np.pi])
    found = fit(asked, noisy(scene, 0.02, 3, np.arange(1, 41.0)), [late])
    assert found.values[2] == pytest.approx(0.05, rel=0.02)
    assert found.period == pytest.approx(2 * np.pi)


def test_ranges_from_records_are_said_to_be_too_narrow() -> None:
    rng = np.random.default_rng(5)
    x = rng.normal(size=20_000)
    found = hs.identify(
        hs.estimated(x, 3 * x + rng.normal(size=20_000), 200, segment="2 s").on_band(5, 60), "mass-spring-damper:k"
    )
    assert "too narrow" in " ".join(str(found).split())
    assert "at most 95 %" in found.text


def test_what_a_model_gives_to_the_last_digit_is_not_said_not_to_fit() -> None:
    """What is left are roundings, which go together from line to line: they tell nothing of the model."""
    exact = hs.sampled("fu2019", [0.5 * n for n in range(1, 40)])
    told = hs.identify(exact, "mass-spring-damper", ["second-order-lowpass"]).verdict
    assert (told.fits, told.neighbours) == (None, None)
    assert hs.identify(exact, "mass-spring-damper", ["first-order-lag"]).verdict.fits is False


FACTS = {
    "0:15": (99.8347809537, 16.8292036316, 1.60570315029),
    "velocity:1:15": (99.9639491593, 15.5758572891, 1.60745594847),
    "displacement:0:7.978916790174708": (99.9895907186, 14.6074571324, 1.61090746247),
}


@pytest.mark.parametrize("given", FACTS)
def test_the_papers_example(given):
    found = hs.evaluate("fu2019", movement=given).movement
    assert found
    assert [found.perceived[x] for x in "kbm"] == pytest.approx(FACTS[given], rel=1e-11)
    assert [found.environment[x] for x in "kbm"] == pytest.approx((100, 15, 1.8), rel=1e-14)
    assert found.change["m"] == pytest.approx(FACTS[given][2] / 1.8 - 1)


SCENES = {
    "a spring-pot": ("organ-tissue", lambda s: (80 * s ** mpmath.mpf("0.2") + 120) * 50 * mpmath.pi / (s + 50 * mpmath.pi) * mpmath.exp(-s / 500)),
    "a delay": ("delayed-spring", None),
    "a hold": ("virtual-wall", None),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("given", ["0.5:15", "velocity:2:9"])
def test_against_quadrature(name, given):
    scene, felt = SCENES[name]
    scene = hs.load_scene(scene)
    low, high = map(float, given.split(":")[-2:])
    power = -2 if given.startswith("velocity") else 0
    mpmath.mp.dps = 20
    if felt is None:
        f = scene.distortion().compile("certified", of=["real", "imag", "environment_real", "environment_imag"])

        def H(w):
            at = f([float(w)])
            return complex(at.environment_real[0] + at.real[0], at.environment_imag[0] + at.imag[0])

        nodes, weights = np.polynomial.legendre.leggauss(40)
        w = (high + low) / 2 + (high - low) / 2 * nodes
        weights = weights * (high - low) / 2 * w**power
        values = np.array([H(x) for x in w])
        rows = [(weights * w**n).sum() for n in (0, 2, 4)]
        re = [(weights * w**n * values.real).sum() for n in (0, 2)]
        im = (weights * w * values.imag).sum()
    else:

        def integral(g):
            return float(mpmath.quad(lambda x: x**power * g(x), np.linspace(low, high, 5)))

        rows = [integral(lambda x, n=n: x**n) for n in (0, 2, 4)]
        re = [integral(lambda x, n=n: x**n * felt(mpmath.mpc(0, x)).real) for n in (0, 2)]
        im = integral(lambda x: x * felt(mpmath.mpc(0, x)).imag)
    k, minus_m = np.linalg.solve([rows[:2], rows[1:]], re)
    found = hs.evaluate(scene, movement=given).movement
    assert found
    assert [found.perceived[x] for x in "kbm"] == pytest.approx([k, im / rows[1], -minus_m], rel=1e-8)


def test_a_recording_is_fitted_by_its_lines(tmp_path):
    """Two sines: what is reported lies where the fit to two lines with the squares of their amplitudes does."""
    t = np.arange(0, 40 * np.pi, 0.01)
    x = 0.01 * np.sin(5 * t) + 0.005 * np.sin(9 * t)
    path = tmp_path / "hand.csv"
    path.write_text("t [s],x [m]\n" + "\n".join(f"{a:.6f},{b:.9f}" for a, b in zip(t, x, strict=True)))
    found = hs.evaluate("fu2019", movement=str(path)).movement
    assert found
    w, S = np.array([5.0, 9.0]), np.array([1e-4, 25e-6])
    s = 1j * w
    H = (1.8 * s**2 + 15 * s + 100) * 6400 / (s**2 + 80 * s + 6400)
    m = -(H.real[1] - H.real[0]) / (w[1] ** 2 - w[0] ** 2)
    expected = (H.real[0] + m * 25, (S * w * H.imag).sum() / (S * w**2).sum(), m)
    assert [found.perceived[x] for x in "kbm"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    "given", ["5", "15:0", "velocity:0:3", "nope.csv", "a:b", "1 kg:2 kg", "acceleration:1:2", "-1:3"]
)
def test_what_is_no_movement(given):
    with pytest.raises((hs.SceneError, OSError)):
        hs.evaluate("fu2019", movement=given)


def test_a_scene_is_written_in_the_units_of_the_file_with_the_digits_that_are_known(tmp_path: Path) -> None:
    """A lag of 9 Hz and a delay of 4 ms with 0.5 % noise: the joint ranges hold both, in Hz and ms, with few digits."""
    hertz = np.linspace(0.2, 4, 30)
    s, rng = 2j * np.pi * hertz, np.random.default_rng(1)
    noise = rng.normal(size=30) + 1j * rng.normal(size=30)
    H = 100 * np.exp(-0.004 * s) / (1 + s / (18 * np.pi)) * (1 + 0.005 * noise)
    rows = "".join(f"{f!r},{h.real!r},{h.imag!r}\n" for f, h in zip(hertz.tolist(), H.tolist(), strict=True))
    (tmp_path / "a.csv").write_text("Frequency (Hz),Real (N/m),Imag (N/m)\n" + rows, encoding="utf-8")
    found = hs.identify(tmp_path / "a.csv", "mass-spring-damper:k", ["first-order-lag", "delay"])
    table = tomllib.loads(found.text)
    assert table["evaluation"]["band"] == ["0.2 Hz", "4 Hz"]
    for written, unit, true in ((table["effects"][0]["omega_c"], "Hz", 9), (table["effects"][1]["tau"], "ms", 4)):
        assert {x.split()[1] for x in written} == {unit}
        low, _, high = (float(x.split()[0]) for x in written)
        assert low < true < high
        assert max(len(written[0]), len(written[2])) <= len("8.888 Hz")
    assert float(found.scene.knobs["tau"].interval[0]) <= 0.004  # type: ignore[index]
