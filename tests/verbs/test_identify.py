"""Models fitted to measured responses: against linear least squares, against the truth, and said not to fit where they do not."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, norm
from scipy.stats import f as f_distribution

import haptisym as hs
from haptisym.verbs.identify.fitting import Noise, fit
from haptisym.verbs.identify.judging import estimates, verdict
from haptisym.verbs.identify.wanted import wanted

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


@pytest.mark.few(2)
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
    truth = {"m": 1.8, "b": 15, "k": 100, "omega_n": 80, "zeta": 0.5}
    for key, value in truth.items():
        low, high = scene.knobs[key].interval  # type: ignore[misc]
        assert float(low) < value < float(high)
    enclosures = hs.tolerances(scene, samples=0, limit=20).enclosures
    for crossing in hs.evaluate("fu2019").crossings:
        [own] = [x for x in enclosures if x.part is crossing.part]
        assert float(own.low) < float(crossing.omega) < float(own.high)


def test_a_model_that_misses_something_does_not_fit_and_gets_no_ranges() -> None:
    found = hs.identify(noisy("fu2019", 0.01, 5), "mass-spring-damper", ["delay"])
    assert found.verdict.fits is False
    assert "does NOT fit" in " ".join(str(found).split())
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
@pytest.mark.parametrize("averages", [6, 10, 50])
def test_intervals_hold_the_truth_and_true_models_are_refuted_as_often_as_they_say(averages: int) -> None:
    check_coverage(400, 11, averages)


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "said"), [(0.02, (0.944, 0.964)), (0.2, (0.91, 0.94))])
def test_boxes_of_a_model_that_bends_hold_the_truth_as_the_docs_say(noise: float, said: tuple[float, float]) -> None:
    """No fewer of 400 than 99 % of all runs would have if each held it with the least share that is said, no more with the largest."""
    asked = wanted("mass-spring-damper:m=1.8,b=15,k=100", ["second-order-lowpass"], None, None)
    omega, truth = np.geomspace(1, 60, 30), np.array([80, 0.5])
    draws, held = 400, 0
    for seed in range(draws):
        ends = estimates(fit(asked, noisy("fu2019", noise, seed, omega), [truth]))
        held += all(e.least <= value <= e.most for e, value in zip(ends, truth, strict=True))
    least, most = (binom.ppf(q, draws, share) for q, share in zip((0.01, 0.99), said, strict=True))
    assert least <= held < most


@pytest.mark.slow
def test_errors_above_a_tenth_are_said_to_make_the_box_less_certain() -> None:
    for noise, told in ((0.01, False), (0.2, True)):
        found = hs.identify(noisy("fu2019", noise, 5), "mass-spring-damper:m=1.8,b=15,k=100", ["second-order-lowpass"])
        assert any(x.error > 0.1 * x.value for x in found.estimates) is told
        assert ("some percent less" in " ".join(str(found).split())) is told


def test_residuals_are_carried_to_chi_square_by_the_quantiles_of_f() -> None:
    noise, sizes = Noise(np.ones(4), 18.0), np.array([0.1, 1.0, 2.0, 5.0])
    tail = f_distribution.sf(sizes**2 / 2, 2, 18)
    assert noise.squares(sizes.astype(complex)) == pytest.approx(-2 * np.log(tail), rel=1e-12)


@pytest.mark.slow
def test_without_discs_the_model_is_untested_and_errors_are_those_of_the_residuals() -> None:
    felt = noisy("fu2019", 0.01, 5)
    found = hs.identify(hs.measured(felt.omega, felt.H), "mass-spring-damper", ["second-order-lowpass"])
    assert found.verdict.fits is None
    assert "UNTESTED" in str(found)
    assert [x.error for x in found.estimates] == pytest.approx([x.error for x in paper().estimates], rel=0.3)
    assert "was not tested" in found.text


@pytest.mark.slow
def test_a_parameter_that_the_lines_do_not_tell_is_named_and_has_no_range() -> None:
    felt = noisy(hs.Scene(hs.environments.kelvin_voigt(290, 2), (hs.effects.first_order_lag(1000),)), 0.02, 5)
    found = hs.identify(felt, "kelvin-voigt", ["first-order-lag"])
    assert [x.parameter.name for x in found.estimates if not x.told] == ["omega_c"]
    assert "do not tell ω_c" in str(found).replace("omega_c", "ω_c")
    assert found.scene.ranges() == {}


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(4))
def test_two_delays_in_a_row_are_never_told_apart(seed: int) -> None:
    """Whichever of the two the search left at nothing: they add up, and nothing else of them is in the response."""
    late = hs.Scene(hs.environments.mass_spring_damper(2, 12, 150), (hs.effects.delay("20 ms"),))
    with pytest.raises(hs.SceneError, match=r"do not tell effects\.delay\.tau and effects\.delay-2\.tau apart"):
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
    assert 'tau = "0.0 s"' in found.text
    assert found.verdict.chance == 0
    assert "a chance below 1e-300 if the model" in " ".join(str(found).split())
    correlation, freedom = found.verdict.neighbours, len(OMEGA) - 1
    assert found.verdict.neighbours_chance == pytest.approx(norm.sf(correlation * np.sqrt(2 * freedom)), rel=1e-9)


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
    with pytest.raises(hs.SceneError, match="what should be felt is given"):
        hs.identify(path, "mass-spring-damper")


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["prony", "spring-pot", "expression"])
def test_environments_of_every_kind_are_written_as_they_were(name: str) -> None:
    own: Any = {
        "prony": lambda: hs.environments.prony("200 N/m", ["300 N/m", "1/3 N/m"], ["6 N*s/m", "2 N*s/m"]),
        "spring-pot": lambda: hs.environments.spring_pot(100, "0.25", k="20 N/m +- 5 %"),
        "expression": lambda: hs.environments.expression("k + w*s/(s + w)", parameters={"k": "90 N/m", "w": 3}),
    }[name]()
    exact = hs.sampled(hs.Scene(own, (hs.effects.delay("5 ms"),)), np.linspace(1, 15, 9))
    found = hs.identify(hs.MeasuredScene(own, exact, threshold="0.08 + 0.004*omega"), effects=["delay"])
    assert found.scene.environment.H == own.H
    assert {x.interval for x in found.scene.environment.parameters} == {x.interval for x in own.parameters}
    assert found.estimates[0].value == pytest.approx(0.005, rel=1e-6)


@pytest.mark.few(10)
@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "say which model is wanted, or give degrees"),
        (["--environment", "mas-spring-damper"], 'did you mean "mass-spring-damper"?'),
        (["--environment", "expression"], "a formula has no parameters"),
        (["--environment", "kelvin-voigt:q"], 'unknown parameter "q"'),
        (["--environment", "kelvin-voigt:k,k"], "k is there twice"),
        (["--environment", "kelvin-voigt:k=1 kg,b"], "not a stiffness"),
        (["--environment", "kelvin-voigt:k=100,b=2"], "nothing is free"),
        (["--environment", "prony"], "say how many, as in k=2"),
        (["--environment", "kelvin-voigt", "--effect", "dely"], 'did you mean "delay"?'),
        (["--environment", "kelvin-voigt", "--effect", "pade-delay"], "give it, as in order=1"),
        (["--environment", "kelvin-voigt", "--effect", "delay", "--effect", "delay"], "do not tell"),
        (["--environment", "kelvin-voigt", "--degrees", "1", "1"], "in place of a model"),
        (["--degrees", "1", "99"], "whole numbers from 0 to 12"),
        (["--degrees", "1", "1", "--effect", "first-order-lag"], "goes with a delay alone"),
        (["--degrees", "12", "5"], "at most 16"),
        (["--degrees", "1", "0", "--band", "50 rad/s", "60 rad/s"], "no line of bench.csv"),
        (
            ["--degrees", "1", "0", "--band", "30 rad/s", "3 rad/s"],
            "the high end, 3 rad/s, must be above the low end, 30 rad/s",
        ),
        (["--degrees", "1", "0", "--band", "1 kg", "60 rad/s"], "band"),
        (["--degrees", "5", "5", "--band", "1 rad/s", "3 rad/s"], "cannot tell 11 parameters"),
        (["--degrees", "1", "0", "--averages", "9"], "averages is given, but no coherence"),
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
        ({"radius": [1, 0, 1]}, "has no radius"),
        ({"coherence": [0.9, 1, 0.9], "averages": 9}, "has no radius"),
        ({"coherence": [0.9, 0.8, 0.9], "averages": 3}, "at least 4"),
        ({"coherence": [0, 0, 0], "averages": 9}, "tells anything"),
    ):
        with pytest.raises(hs.SceneError, match=told):
            hs.identify(hs.measured([1, 2, 3], [1, 1j, 2], **certainty), "kelvin-voigt")  # type: ignore[arg-type]
    for given, told in ((3, "is no measured response"), ("fu2019.toml", "neither a scene file")):
        with pytest.raises(hs.SceneError, match=told):
            hs.identify(given, "kelvin-voigt")  # type: ignore[arg-type]


def test_what_is_printed_has_the_digits_that_the_errors_support_and_the_scene_file_all() -> None:
    found = hs.identify("fu2019-bench", effects=["second-order-lowpass"])
    text = str(found)
    [formula] = [line for line in text.splitlines() if "H_perc" in line]
    assert max(len(x.replace(".", "").strip("0")) for x in re.findall(r"\d[\d.]*", formula.split("=")[-1])) <= 4
    for x in found.estimates:
        letter = {"omega_n": "ω_n", "zeta": "ζ"}[x.parameter.name]
        [row] = [line.split() for line in text.splitlines() if line.split()[:1] == [letter]]
        value, error, low, _, high = row[1:6]
        assert abs(float(value) - x.value) <= 0.05 * x.error
        assert len(error.replace(".", "").strip("0")) <= 2
        assert x.low - 0.1 * x.error <= float(low) <= x.low
        assert x.high <= float(high) <= x.high + 0.1 * x.error
        assert repr(x.value) in found.text


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["fu2019"], "its simulated bench run is fu2019-bench"),
        (["zener-tissue"], "simulated bench runs are delayed-spring-bench, fu2019-bench, fu2019-clipped-bench"),
        (
            ["fu2019-bench"],
            "say what stands behind it, as --effect delay or --degrees 1 2; effects are first-order-lag",
        ),
        (["fu2019-bench", "--effect", "delay:tau=1 ms"], "every parameter is given a value; leave one of them out"),
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


def test_a_record_in_time_is_named_as_what_it_is(call: Called) -> None:
    record = str(Path(hs.__file__).parent / "benches" / "fu2019-bench.csv")
    status, out, err = call("identify", record, "--environment", "mass-spring-damper")
    assert (status, out, err.count("\n")) == (2, "", 1)
    way = re.search(r'as (--estimator \S+ --segment "[^"]+")', err)
    assert way is not None
    assert "a record in time" in err
    status, out, err = call("identify", record, "--environment", "mass-spring-damper", *shlex.split(way[1]))
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
    assert "Estimated, not proven" in files["tex"].read_text(encoding="utf-8")
    assert "<svg" in files["html"].read_text(encoding="utf-8")
    assert call("evaluate", str(scene), "--json")[0] == 0
