"""Measured responses: discs as statistics has them, verdicts that hold for every point of a disc, and files of all kinds."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import control
import numpy as np
import pytest
from benches import SCENE, bench
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import f as f_distribution

import haptisym as hs
from haptisym.model.measured import averages_for, coherence_for, disc_radius
from haptisym.model.measuredscene import MeasuredScene
from haptisym.verbs.measured.rowtext import numerals

Called = Callable[..., tuple[int, str, str]]

FU = hs.load_scene("fu2019")
PLAIN = "omega,real,imag\n2,93,30\n8,-30,120\n"


def response(omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """H_env and H_perc of the paper's example, in complex numbers."""
    s = 1j * omega
    env = 1.8 * s**2 + 15 * s + 100
    return env, env * 6400 / (s**2 + 80 * s + 6400)


def verdicts(e: hs.MeasuredEvaluation) -> list[tuple[str, str]]:
    return [(x.real.value, x.imag.value) for x in e.rows]


# Discs.


@pytest.mark.parametrize(
    ("coherence", "averages", "percent"), [(0.95, 10, 14.41766), (0.99, 10, 6.316171), (0.95, 20, 9.480726)]
)
def test_the_radius_is_bendat_and_piersols(coherence: float, averages: int, percent: float) -> None:
    n = 2 * averages
    quantile = f_distribution.ppf(0.95, 2, n - 2)
    assert disc_radius(coherence, averages) == pytest.approx(
        np.sqrt(2 / (n - 2) * quantile * (1 - coherence) / coherence), rel=1e-12
    )
    assert 100 * disc_radius(coherence, averages) == pytest.approx(percent, rel=5e-7)


@pytest.mark.parametrize(
    ("averages", "needed"),
    [
        (10, (0.9753056, 0.9937099, 0.9989882)),
        (20, (0.9446841, 0.9855725, 0.9976633)),
        (100, (0.7544349, 0.9247496, 0.9871475)),
    ],
)
def test_the_coherence_that_a_jnd_needs(averages: int, needed: tuple[float, ...]) -> None:
    assert coherence_for([0.1, 0.05, 0.02], averages) == pytest.approx(needed, abs=6e-8)


@given(st.floats(0.01, 0.5), st.floats(0.3, 0.999), st.floats(0.5, 0.999))
def test_the_averages_that_a_jnd_needs_are_enough_and_one_less_is_not(
    radius: float, g2: float, confidence: float
) -> None:
    most = int(averages_for(radius, g2, confidence))
    assert disc_radius(g2, most, confidence) <= radius * (1 + 1e-9)
    assert most == 2 or disc_radius(g2, most - 1, confidence) > radius * (1 - 1e-9)


def test_without_coherence_the_disc_is_the_whole_plane() -> None:
    felt = hs.measured([1.0, 2.0], [0.0, 300.0], coherence=[0.0, 0.0], averages=10)
    e = hs.evaluate(hs.MeasuredScene(FU.environment, felt))
    assert verdicts(e) == [("unresolved", "unresolved")] * 2
    assert [row["radius"] for row in e.to_dict()["rows"]] == [None, None]
    assert json.loads(e.to_json()) == e.to_dict()


# Verdicts.


def test_exact_lines_are_judged_as_the_proven_crossings_say() -> None:
    omega = np.linspace(0.1, 15, 300)
    env, perc = response(omega)
    e = hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured(omega, perc, radius=1e-9 * np.abs(env))))
    proven = hs.evaluate(FU)
    real, imag = (float(c.omega) for c in proven.crossings)
    expected = [("exceeds" if w > real else "below", "exceeds" if w > imag else "below") for w in omega]
    assert verdicts(e) == expected
    for percept in e.percepts:
        [own] = [p for p in proven.percepts if p.part is percept.part]
        assert float(own.band.low.omega) < percept.omega <= float(own.band.high.omega)
        assert (percept.property, percept.change) == (own.property, own.change)
    assert len(e.percepts) == sum(word == "exceeds" for row in expected for word in row)
    assert not e.certified


@given(st.integers(0, 10_000), st.booleans())
def test_a_verdict_and_a_percept_hold_for_every_truth_within_the_discs(seed: int, env_is_measured: bool) -> None:  # noqa: FBT001
    rng = np.random.default_rng(seed)
    omega = np.linspace(1, 15, 8)
    env = rng.normal(size=8) * 100 + 1j * rng.normal(size=8) * 50
    perc = env + 60 * rng.uniform(size=8) * (rng.normal(size=8) + 1j * rng.normal(size=8))
    r_env = np.abs(env) * rng.uniform(0, 0.3, 8) * env_is_measured
    r_perc = np.abs(env) * rng.uniform(0, 0.3, 8)
    own = hs.measured(omega, env, radius=r_env)
    e = hs.evaluate(hs.MeasuredScene(own, hs.measured(omega, perc, radius=r_perc)))
    edge = np.exp(2j * np.pi * np.arange(24) / 24)
    for i, row in enumerate(e.rows):
        a = (env[i] + r_env[i] * edge)[:, None]
        b = (perc[i] + r_perc[i] * edge)[None, :]
        x = (b - a) / np.abs(a)
        for part, ratio in (("real", np.abs(x.real)), ("imag", np.abs(x.imag))):
            verdict = getattr(row, part).value
            assert verdict != "exceeds" or (ratio > 0.1).all()
            assert verdict != "below" or (ratio <= 0.1).all()
        for p in (p for p in e.percepts if p.omega == row.omega):
            pick = np.real if p.part is hs.Part.REAL else np.imag
            before, after = np.broadcast_arrays(pick(a), pick(b))
            assert (np.sign(np.abs(after) - np.abs(before)) == {"higher": 1, "lower": -1}[p.change.value]).all()
            if p.property is hs.Property.STIFFNESS:
                assert (after > 0).all()
                assert (before > 0).all()
            if p.property is hs.Property.STIFFNESS_TO_MASS:
                assert (before > 0).all()
                assert (after < 0).all()


def test_where_the_environment_is_zero_any_change_beyond_the_disc_exceeds() -> None:
    spring_and_mass = hs.environments.mass_spring_damper(m=1, k=100)
    felt = hs.measured([10.0], [5 + 1j], radius=[2.0])
    e = hs.evaluate(hs.MeasuredScene(spring_and_mass, felt))
    assert verdicts(e) == [("exceeds", "unresolved")]
    assert e.to_dict()["rows"][0]["ratio_real"] is None
    assert e.percepts[0].property is hs.Property.STIFFNESS


def test_active_damping_has_no_name() -> None:
    e = hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured([5.0], [55 - 60j], radius=[1.0])))
    assert verdicts(e) == [("below", "exceeds")]
    assert e.percepts == ()
    assert json.loads(e.to_json()) == e.to_dict()
    assert "noticed, not named" in str(e)


@pytest.mark.parametrize("key", ["coherence", "averages", "radius"])
def test_what_is_said_to_resolve_the_open_lines_resolves_them(key: str) -> None:
    omega = np.linspace(6, 14, 7)
    _, perc = response(omega)
    perc = perc * np.exp(0.01j)
    g2, averages = np.full(7, 0.97), 12

    def judged(**certainty: object) -> hs.MeasuredEvaluation:
        return hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured(omega, perc, **certainty)))  # type: ignore[arg-type]

    needed = judged(coherence=g2, averages=averages).needed
    assert needed
    for share, left in (("all", 0), ("half", needed.lines // 2)):
        enough = getattr(getattr(needed, key), share)
        more = 1e-6 * (1 - enough) if key == "coherence" else 0
        certainty = {
            "coherence": {"coherence": np.full(7, enough + more), "averages": averages},
            "averages": {"coherence": g2, "averages": enough},
            "radius": {"radius": (1 - 1e-6) * enough * np.abs(response(omega)[0])},
        }[key]
        after = judged(**certainty)
        assert (after.needed.lines if after.needed else 0) <= left


def estimated(draws: int, averages: int, noise: float, seed: int) -> tuple[np.ndarray, ...]:
    """H1 and coherence of bench runs of the paper's display: Gaussian motion, noise in the force as large as that share."""
    rng = np.random.default_rng(seed)
    omega = np.array([3.0, 7.0, 8.5, 11.0, 13.0])
    _, perc = response(omega)
    shape = (2, averages, draws, len(omega))
    x, v = (rng.normal(size=shape)[0] + 1j * rng.normal(size=shape)[0] for _ in range(2))
    force = perc * x + noise * np.abs(perc) * v
    sxx, sff = (np.square(np.abs(z)).sum(axis=0) for z in (x, force))
    sxf = (np.conj(x) * force).sum(axis=0)
    return omega, sxf / sxx, np.square(np.abs(sxf)) / (sxx * sff)


def check_coverage(draws: int, judged: int, seed: int) -> None:
    averages = 16
    omega, H, g2 = estimated(draws, averages, 0.15, seed)
    env, perc = response(omega)
    covered = np.abs(H - perc) <= np.abs(H) * disc_radius(g2, averages)
    assert abs(covered.mean() - 0.95) < 4 * np.sqrt(0.95 * 0.05 / covered.size)
    change = (perc - env) / np.abs(env)
    wrong = np.zeros(len(omega))
    for i in range(judged):
        felt = hs.measured(omega, H[i], coherence=g2[i], averages=averages)
        e = hs.evaluate(hs.MeasuredScene(FU.environment, felt))
        for part, true in zip(hs.Part, (np.abs(change.real), np.abs(change.imag)), strict=True):
            wrong += ((e.verdict[part] == 1) & (true <= 0.1)) | ((e.verdict[part] == -1) & (true > 0.1))
    assert (wrong <= 0.05 * judged + 4 * np.sqrt(0.05 * 0.95 * judged)).all()


def test_discs_cover_the_truth_as_often_as_they_say() -> None:
    check_coverage(2000, 100, 7)


@pytest.mark.slow
def test_discs_cover_the_truth_as_often_as_they_say_in_ten_thousand_draws() -> None:
    check_coverage(10_000, 2000, 11)


# Files.

VARIANTS = {
    "comma": PLAIN,
    "semicolon": PLAIN.replace(",", ";"),
    "tab": PLAIN.replace(",", "\t"),
    "unit row": PLAIN.replace("imag\n", "imag\nrad/s,N/m,N/m\n"),
    "other units": "omega,real,imag\nrad/s,N/mm,kN/m\n2,0.093,0.03\n8,-0.03,0.12\n",
    "units in the header": PLAIN.replace("real,imag", "real [N/m],imag (N/m)"),
    "spaces and capitals": PLAIN.replace("omega,real", " Omega , Real"),
    "order": "imag,omega,real\n30,2,93\n120,8,-30\n",
    "Hz": f"frequency_hz,real,imag\n{1 / np.pi:.17g},93,30\n{4 / np.pi:.17g},-30,120\n",
    "kHz": f"frequency_hz,real,imag\nkHz,,\n{1e-3 / np.pi:.17g},93,30\n{4e-3 / np.pi:.17g},-30,120\n",
    "comments and empty lines": "# a bench\n\n" + PLAIN.replace("\n8", "\n# pause\n\n8"),
    "Windows": "\ufeff" + PLAIN.replace("\n", "\r\n"),
    "quotes": '"omega","real","imag"\n"2","93","30"\n"8","-30","120"\n',
    "polar": "omega,magnitude,phase_deg\n"
    + "".join(f"{w},{abs(h):.17g},{np.angle(h, deg=True):.17g}\n" for w, h in ((2, 93 + 30j), (8, -30 + 120j))),
}


@pytest.mark.parametrize("table", VARIANTS.values(), ids=VARIANTS)
def test_a_response_is_the_same_however_it_is_written(tmp_path: Path, table: str) -> None:
    felt = hs.evaluate(bench(tmp_path, table)).scene.perceived
    assert felt.omega == pytest.approx([2, 8], rel=1e-15)
    assert pytest.approx([93 + 30j, -30 + 120j], rel=1e-14) == felt.H


@pytest.mark.parametrize(
    ("table", "keys", "words"),
    [
        ("", {}, ["bench.csv", "no column of frequencies"]),
        ("omega,real,imag\n", {}, ["no lines of numbers"]),
        ("2,93,30\n", {}, ["line 1 holds numbers", "name the columns"]),
        ("omega,real,imag,coherance\n2,93,30,1\n", {}, ['unknown column "coherance"', 'did you mean "coherence"?']),
        ("omega,omega,real,imag\n2,2,93,30\n", {}, ["column omega is there twice"]),
        ("omega,frequency_hz,real,imag\n2,2,93,30\n", {}, ["two columns of frequencies"]),
        ("omega,real,phase_deg\n2,93,30\n", {}, ["real, imag or magnitude, phase_deg"]),
        ("omega,real\n2,93\n", {}, ["real, imag or magnitude, phase_deg"]),
        ("omega;real;imag\n2;93,5;30\n", {}, ["line 2", 'real: "93,5"', "point, as in 93.5"]),
        ("omega,real,imag\n2,0,93,5,30,0\n", {}, ["line 2 has 6 cells", "decimal commas"]),
        ("omega;real;imag\n2,5;93;30\n", {}, ["line 2", 'omega: "2,5"', "2.5"]),
        (PLAIN + "9,1\n", {}, ["line 4 has 2 cells"]),
        (PLAIN + "9,,1\n", {}, ["line 4: real: the cell is empty"]),
        (PLAIN + "9,x,1\n", {}, ['line 4: real: "x" is not a number']),
        (PLAIN + "\n9,nan,1\n", {}, ["line 5: H", "finite"]),
        (PLAIN + "inf,1,1\n", {}, ["line 4: omega: inf", "finite frequency"]),
        (PLAIN + "7,1,1\n", {}, ["line 4", "7 rad/s comes after 8", "sort the lines"]),
        (PLAIN + "8,1,1\n", {}, ["line 4", "8 rad/s is there twice"]),
        ("omega,real,imag\n-1,1,1\n", {}, ["line 2: omega: -1", "0 or above"]),
        ("omega,real,imag\nHz,N/m,N/m\n2,93,30\n", {}, ['the unit is "Hz"', "call the column frequency_hz"]),
        ("omega,real,imag\nrad/s,N,N\n2,93,30\n", {}, ["real", "not a stiffness", "expected N/m or N*m/rad"]),
        ("omega,real,imag\nrad/s,N*s/m,N*s/m\n2,93,30\n", {}, ["force per velocity", "multiply by j omega"]),
        ("omega,magnitude,phase_deg\nrad/s,dB,deg\n2,93,30\n", {}, ["magnitude", '"dB"', "10^(dB/20)"]),
        ("omega,magnitude,phase_deg\nrad/s,N/m,rad\n2,93,30\n", {}, ['phase_deg: the unit is "rad"', "must be deg"]),
        ("omega,real,imag\nrad/s,N*m/rad,N/m\n2,93,30\n", {}, ["translation and rotation"]),
        ("omega,real,imag\nrad/s,N*m/rad,N*m/rad\n2,93,30\n", {}, ["translation and rotation"]),
        ("omega,magnitude,phase_deg\n2,-93,30\n", {}, ["line 2: magnitude: -93"]),
        ("omega,real,imag,coherence\n2,93,30,1.2\n", {"averages": 10}, ["line 2: coherence: 1.2", "0 to 1"]),
        ("omega,real,imag,coherence\n2,93,30,0.9\n", {}, ["averages is missing"]),
        ("omega,real,imag,coherence\n2,93,30,0.9\n", {"averages": 1}, ["averages: 1", "from 2 on"]),
        ("omega,real,imag,coherence\n2,93,30,0.9\n", {"averages": 9, "confidence": 95}, ["confidence: 95", "0 and 1"]),
        ("omega,real,imag,coherence,radius\n2,93,30,0.9,1\n", {"averages": 9}, ["leave out one of them"]),
        ("omega,real,imag,radius\n2,93,30,-1\n", {}, ["line 2: radius: -1"]),
        (PLAIN, {"averages": 9}, ["averages is given, but no coherence"]),
        (PLAIN, {"avrages": 9}, ["perceived", 'unknown key "avrages"', 'did you mean "averages"?']),
    ],
)
def test_a_bad_table_is_refused_in_one_sentence(
    tmp_path: Path, call: Called, table: str, keys: dict[str, float], words: list[str]
) -> None:
    status, out, err = call("evaluate", str(bench(tmp_path, table, **keys)))
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert all(word in err for word in ["bench.toml", *words]), err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (".", "this is a folder"),
        ("bench.cvs", 'no such file; did you mean "bench.csv"?'),
        ("sub/x.csv", "no folder"),
        ("/dev/null", "no regular file"),
        ("", "give the name of a CSV file"),
        ("bench.bin", "not text in UTF-8"),
        ("latin.csv", "not text in UTF-8"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_sentence(tmp_path: Path, call: Called, name: str, words: str) -> None:
    (tmp_path / "bench.bin").write_bytes(b"PK\x03\x04 a workbook")
    (tmp_path / "latin.csv").write_bytes("omega,real,imag\nrad/s,N/m,\u00b0\n".encode("latin-1"))
    status, _, err = call("evaluate", str(bench(tmp_path, PLAIN, SCENE.replace("bench.csv", name))))
    assert status == 2
    assert err.count("\n") == 1
    assert words in err


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (SCENE + '[[effects]]\nmodel = "delay"\ntau = "1 ms"\n', "effects: does not go with what is measured"),
        (SCENE + '[rendered]\nmodel = "maxwell"\n', "rendered: does not go with what is measured"),
        ('[perceived]\nfile = "bench.csv"\n', "[environment] is missing"),
        ('[environment]\nfile = "bench.csv"\n', "[perceived] is missing"),
        (SCENE + '[evaluation]\nband = ["20 rad/s", "30 rad/s"]\n', "no line of bench.csv lies from 20 to 30 rad/s"),
        (SCENE + "[evaluation]\njnd = -1\n", "must be > 0"),
        (
            '[environment]\nmodel = "mass-spring-damper"\nm = "1 kg*m^2"\n[perceived]\nfile = "bench.csv"',
            "cannot be mixed",
        ),
    ],
)
def test_a_scene_that_cannot_be_is_refused_in_one_sentence(
    tmp_path: Path, call: Called, scene: str, words: str
) -> None:
    table = "omega,real,imag\nrad/s,N/m,N/m\n2,93,30\n"
    status, _, err = call("evaluate", str(bench(tmp_path, table, scene)))
    assert status == 2
    assert err.count("\n") == 1
    assert words in err


@pytest.mark.slow
def test_a_threshold_may_be_a_formula_in_omega(tmp_path: Path) -> None:
    omega = np.linspace(0.1, 15, 200)
    env, perc = response(omega)
    felt = hs.measured(omega, perc, radius=1e-9 * np.abs(env))
    e = hs.evaluate(hs.MeasuredScene(FU.environment, felt, threshold="0.08 + 0.004*omega"))
    assert [x.real.value for x in e.rows] == ["below"] * 200  # of the real part there is no crossing
    assert [x.imag.value == "exceeds" for x in e.rows] == [w > 13.845284093670381 for w in omega]
    e.save_figure(tmp_path / "ratios.svg")


def test_one_line_is_judged_alone(tmp_path: Path) -> None:
    e = hs.evaluate(bench(tmp_path, "omega,real,imag,radius\n8,-30,120,2\n"))
    assert verdicts(e) == [("exceeds", "below")]


def test_lines_off_the_band_are_left_out_and_told(tmp_path: Path) -> None:
    e = hs.evaluate(bench(tmp_path, PLAIN, SCENE + '[evaluation]\nband = ["1 rad/s", "3 rad/s"]\n'))
    assert (len(e), e.left_out) == (1, 1)
    assert "1 line, off the band" in str(e)


def test_an_environment_that_is_measured_too_is_compared_line_by_line(tmp_path: Path) -> None:
    (tmp_path / "tissue.csv").write_text(
        "frequency_hz,real,imag,radius\n1,100,10,1\n2,100,20,1\n4,90,30,1\n", encoding="utf-8"
    )
    table = "frequency_hz,real,imag,radius\n1,101,10,1\n2,150,20,1\n3,90,30,1\n"
    scene = '[environment]\nfile = "tissue.csv"\n[perceived]\nfile = "bench.csv"\n'
    e = hs.evaluate(bench(tmp_path, table, scene))
    assert verdicts(e) == [("below", "below"), ("exceeds", "below")]
    assert e.left_out == 1
    assert "tissue.csv" in str(e)
    with pytest.raises(hs.SceneError, match="no frequency in common"):
        hs.evaluate(bench(tmp_path, "omega,real,imag\n2,1,1\n", scene))


# Out, and beside.


@pytest.mark.slow
def test_the_command_line_says_the_same_in_every_form(tmp_path: Path, call: Called) -> None:
    omega = np.linspace(1, 15, 60)
    _, perc = response(omega)
    rows = "".join(f"{w:.6g},{h.real:.6g},{h.imag:.6g},0.995\n" for w, h in zip(omega, perc, strict=True))
    scene = bench(tmp_path, "omega,real,imag,coherence\n" + rows, averages=20)
    status, out, _ = call("evaluate", str(scene), "--json")
    found = json.loads(out)
    assert (status, found["schema"], found["certified"], len(found["rows"])) == (0, "haptisym.measured/1", False, 60)
    assert set(found["rows"][0]) == {"omega", "ratio_real", "ratio_imag", "radius", "real", "imag"}
    assert found == hs.evaluate(scene).to_dict()
    latex, report = tmp_path / "page.tex", tmp_path / "page.html"
    status, out, _ = call(
        "evaluate", str(scene), "--latex", str(latex), "--report", str(report), "--figures", str(tmp_path)
    )
    assert status == 0
    assert "nothing is said between the lines" in " ".join(out.split())
    assert "ertain:" not in out
    assert "unresolved" in latex.read_text(encoding="utf-8")
    assert "<svg" in report.read_text(encoding="utf-8")
    assert {x.name for x in tmp_path.glob("*.png")} == {"ratios.png", "nyquist.png"}


@pytest.mark.parametrize("verb", ["derive", "effects", "stability", "sensitivity", "tolerances", "metrics", "cost"])
def test_other_verbs_say_what_they_need(tmp_path: Path, call: Called, verb: str) -> None:
    status, _, err = call(verb, str(bench(tmp_path, PLAIN)))
    assert status == 2
    assert "every other question needs formulas" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    "words", [["--digits", "20"], ["--tolerance", "0.1"], ["--environment", "x"], ["--certificate", "x.json"]]
)
def test_options_about_formulas_are_refused(tmp_path: Path, call: Called, words: list[str]) -> None:
    status, _, err = call("evaluate", str(bench(tmp_path, PLAIN)), *words)
    assert status == 2
    assert f"{words[0]} is about scenes of formulas" in err


def test_no_page_is_written_over_the_measurement(tmp_path: Path, call: Called) -> None:
    scene = bench(tmp_path, PLAIN)
    status, _, err = call("evaluate", str(scene), "--latex", str(tmp_path / "bench.csv"))
    assert (status, "would be overwritten" in err) == (2, True)
    assert (tmp_path / "bench.csv").read_text(encoding="utf-8") == PLAIN


def test_in_python_other_questions_say_what_they_need() -> None:
    scene = hs.MeasuredScene(FU.environment, hs.measured([1.0], [1.0]))
    for question in (hs.require, hs.stability, hs.metrics, hs.sensitivity, hs.tolerances, hs.derive, hs.evaluate_all):
        with pytest.raises(hs.SceneError, match="needs formulas"):
            question(*((scene, "omega_n") if question is hs.require else (scene,)))


def test_control_and_scipy_hand_over_their_responses() -> None:
    omega = np.array([1.0, 5.0, 9.0])
    _, perc = response(omega)
    assert (perc == hs.measured(control.frd(perc, omega)).H).all()
    with pytest.raises(hs.SceneError, match="2 inputs and 1 outputs"):
        hs.measured(control.frd(np.ones((1, 2, 3)), omega))
    with pytest.raises(hs.SceneError, match="is no measured response"):
        hs.measured(control.tf([1], [1, 1]))


@pytest.mark.parametrize(
    ("arguments", "keys", "words"),
    [
        (([1, 2], [1]), {}, "H has 1 values, and omega 2"),
        (([], []), {}, "no lines"),
        (([1j], [1]), {}, "omega: must be real"),
        (([[1]], [[1]]), {}, "one row"),
        (("x.csv", [1]), {}, "leave out H"),
        (([1], ["a"]), {}, "array of numbers"),
        (([2, 1], [1, 1]), {}, "line 2: the frequency 1 rad/s comes after 2"),
        (([1], [np.nan]), {}, "line 1: H"),
        (([1], [1]), {"coherence": [2], "averages": 5}, "coherence: 2"),
        (([1], [1]), {"coherence": [1]}, "averages is missing"),
    ],
)
def test_bad_arrays_are_refused(arguments: tuple[object, ...], keys: dict[str, object], words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.measured(*arguments, **keys)  # type: ignore[arg-type]
    assert words in str(error.value)


def test_an_environment_with_symbols_is_refused() -> None:
    m = hs.symbols("m")
    with pytest.raises(hs.SceneError, match="m"):
        hs.MeasuredScene(hs.environments.mass_spring_damper(m=m, k=1), hs.measured([1.0], [1.0]))


def test_lines_without_discs_are_judged_as_they_stand_and_told() -> None:
    e = hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured([8.0], [-30 + 120j])))
    assert e.to_dict()["rows"][0]["radius"] is None
    assert "judged as if it were exact" in " ".join(str(e).split())


@pytest.mark.parametrize("name", ["fu2019", "delayed-spring", "steering-wheel", "sampled-wall"])
def test_a_sampled_scene_comes_back_from_its_file_and_from_control(tmp_path: Path, name: str) -> None:
    scene = hs.load_scene(name)
    exact = hs.sampled(scene, points=30)
    again = hs.measured(exact.to_csv(tmp_path / "out.csv"))
    assert (again.omega == exact.omega).all()
    assert np.array_equal(again.H, exact.H)
    assert again.motion is scene.motion
    back = hs.measured(hs.interop.to_frd(exact))
    assert np.array_equal(back.H, exact.H)


def test_a_file_keeps_what_is_known_of_the_certainty(tmp_path: Path) -> None:
    felt = hs.measured([1.0, 2.0], [0.1 + 1j, 1 / 3 - 2e-17j], coherence=[0.9, 1 / 7], averages=9)
    again = hs.measured(felt.to_csv(tmp_path / "out.csv"), averages=9)
    assert np.array_equal(again.discs, felt.discs)


def test_the_response_is_exact_and_is_judged_as_the_scene_is(tmp_path: Path, call: Called) -> None:
    out = tmp_path / "bench.csv"
    status, _, err = call("evaluate", "fu2019", "--response", str(out), "--points", "61")
    assert (status, "response written to" in err) == (0, True)
    e = hs.evaluate(bench(tmp_path, out.read_text(encoding="utf-8")))
    assert len(e) == 61
    assert np.abs(e.lines.perceived - response(e.lines.omega)[1]).max() < 1e-12
    real, imag = (float(c.omega) for c in hs.evaluate(FU).crossings)
    assert [(x.real.value == "exceeds", x.imag.value == "exceeds") for x in e.rows] == [
        (x.omega > real, x.omega > imag) for x in e.rows
    ]


@pytest.mark.parametrize("omega", [[2, 1], [-1], [np.nan], [], "x", [[1]], [1j]])
def test_frequencies_that_cannot_be_are_refused(omega: object) -> None:
    with pytest.raises(hs.SceneError):
        hs.sampled(FU, omega)  # type: ignore[arg-type]


def test_frequencies_at_which_the_response_is_infinite_are_left_out() -> None:
    rotor = hs.Scene(hs.environments.expression("1/s + s"), (hs.effects.first_order_lag(5),), (0, 10))
    assert hs.sampled(rotor, points=11).omega.tolist() == list(range(1, 11))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["fu2019", "--points", "9"], "needs --response"),
        (["palpation-device", "--response", "{out}"], "takes one environment"),
        (["fu2019", "--response", "{out}", "--latex", "{out}"], "would both be written"),
    ],
)
def test_options_of_the_response_that_do_not_fit_are_refused(
    tmp_path: Path, call: Called, words: list[str], told: str
) -> None:
    status, _, err = call("evaluate", *(x.format(out=tmp_path / "out.csv") for x in words))
    assert (status, told in err) == (2, True)


def test_numbers_of_long_documents_read_back_as_the_same_floats() -> None:
    rng, tens = np.random.default_rng(3), 10.0 ** np.arange(-10, 20)
    x = np.concatenate(
        [
            10.0 ** rng.uniform(-8, 18, 20_000),
            np.round(10.0 ** rng.uniform(-5, 3, 5000), 4),
            *(tens, np.nextafter(tens, 0), np.nextafter(tens, np.inf)),
            [0, 5e-324, 1.7e308, 2.0**53, 0.1],
        ]
    )
    for few in (True, False):
        shown = [bytes(row).decode() for row in numerals(x, few=few)]
        assert np.array_equal([json.loads(text) for text in shown], x)


def test_documents_of_few_and_of_many_lines_are_those_of_the_rows() -> None:
    omega = np.linspace(0.5, 14, 1500)
    _, perc = response(omega)
    for some in (slice(0, 3), slice(None)):
        felt = hs.measured(omega[some], perc[some], coherence=np.where(omega[some] > 7, 0.0, 0.99), averages=10)
        e = hs.evaluate(MeasuredScene(hs.environments.mass_spring_damper("9/5", 15, 100), felt))
        text = e.to_json()
        assert json.loads(text) == e.to_dict()
        assert (
            len({len(line) for line in text.splitlines() if line.startswith('    {"omega": ') and "real" in line}) <= 4
        )


def a_million_lines(folder: Path) -> Path:
    """A scene with a response of 35 MB."""
    omega = np.linspace(0.001, 1000, 1_000_000)
    _, perc = response(omega)
    with (folder / "bench.csv").open("w", encoding="utf-8") as file:
        file.write("omega,real,imag,coherence\n")
        np.savetxt(file, np.column_stack([omega, perc.real, perc.imag, np.full(len(omega), 0.99)]), "%.9g", ",")
    (folder / "bench.toml").write_text(SCENE + "averages = 10\n", encoding="utf-8")
    return folder / "bench.toml"


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
def test_a_million_lines_fit_in_half_a_gigabyte(tmp_path: Path) -> None:
    probe = (
        "import sys, haptisym as hs\n"
        "e = hs.evaluate(sys.argv[1])\n"
        "assert len(e) == 1000000 and str(e) and sum(map(len, e.json_parts())) > 10**8\n"
        "print(*[x.split()[1] for x in open('/proc/self/status') if x.startswith('VmHWM')])\n"  # its own, not its parent's
    )
    done = subprocess.run(
        [sys.executable, "-c", probe, str(a_million_lines(tmp_path))],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert int(done.stdout) < 500_000  # KiB
