"""Measured responses: discs as statistics has them, verdicts that hold for every point of a disc, between lines too, and files of all kinds."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import control
import mpmath
import numpy as np
import pytest
from benches import SCENE, bench
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import f as f_distribution
from sympy import Rational

import haptisym as hs
from haptisym.kernel.rings import omega as OMEGA  # noqa: N812
from haptisym.model.jnd import Part, read_threshold
from haptisym.model.measured import SlopeBound, averages_for, coherence_for, disc_radius
from haptisym.verbs.measured.entry import MOST_AVERAGES, MOST_COHERENCE, spread
from haptisym.verbs.measured.judging import OPEN, joint_distance, lines_of, matched, part_distance, signs, values_of

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


STICK = hs.Scene(
    hs.environments.mass_spring_damper("1.9 kg", "28 N*s/m", "950 N/m"),
    [hs.effects.delay("6 ms"), hs.effects.second_order_lowpass("25 Hz", "0.7")],
    ("0.2 Hz", "40 Hz"),
)


@pytest.mark.parametrize(("scene", "part"), [(FU, "real"), (STICK, "imaginary")])
@pytest.mark.parametrize("radius", [0, 0.01])
def test_the_bandwidth_of_points_encloses_the_proven_one_and_what_is_felt_first_is_the_same(
    scene: hs.Scene, part: str, radius: float
) -> None:
    proven = hs.evaluate(scene)
    width = float(proven.bandwidth)
    exact = hs.sampled(scene, np.geomspace(0.2, 2, 40) * width)
    sizes = radius * np.abs([complex(scene.environment.H.subs(hs.s, 1j * w)) for w in exact.omega])
    slope = float(np.abs(np.diff(exact.H) / np.diff(exact.omega)).max()) * 1.2
    first = min(proven.felt, key=lambda x: float(x.band.low.omega)).words
    high_ends = []
    for stated in (None, f"{slope} N*s/m"):
        felt = hs.measured(exact.omega, exact.H, radius=sizes, slope=stated)
        e = hs.evaluate(hs.MeasuredScene(scene.environment, felt, scene.band, title="The stick"))
        low, high = e.reach
        assert low < width < high
        assert f"limited by the {part} part Felt as {first} at" in " ".join(str(e).split())
        high_ends.append(high)
    # Between two points the slope may show that something exceeds.
    assert high_ends[1] <= high_ends[0]


def test_the_bandwidth_of_points_that_are_unresolved_is_open_at_one_end_or_both() -> None:
    spring = hs.environments.mass_spring_damper(k=100)
    below, open_, exceeds = 100, 110, 130
    for H, reach, words in (
        (
            [below, open_, exceeds],
            (1, 3),
            "between 1 rad/s (0.1592 Hz) and 3 rad/s (0.4775 Hz), limited by the real part",
        ),
        ([open_, exceeds, below], (None, 2), "less than 2 rad/s (0.3183 Hz)"),
        ([below, open_, below], (1, None), "at least 1 rad/s (0.1592 Hz)"),
        ([open_, below, below], (None, None), "unresolved"),
        ([below, below, below], (3, None), "the whole band, up to 3 rad/s (0.4775 Hz)"),
    ):
        e = hs.evaluate(hs.MeasuredScene(spring, hs.measured([1, 2, 3], H, radius=[2, 2, 2])))
        assert e.reach == reach
        assert f"Bandwidth {words}" in " ".join(str(e).split())


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
    assert "noticed (active)" in " ".join(str(e).split())


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


@pytest.mark.slow
def test_discs_cover_the_truth_as_often_as_they_say() -> None:
    check_coverage(2000, 100, 7)


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
        ("", {}, ["bench.csv", "no lines of numbers"]),
        ("omega,frequency_hz,real,imag\n2,2,93,30\n", {}, ["two columns of frequencies"]),
        ("omega,real,phase_deg\n2,93,30\n", {}, ["real, imag or magnitude, phase_deg"]),
        ("omega,real\n2,93\n", {}, ["real, imag or magnitude, phase_deg"]),
        (PLAIN + "9,-,1\n", {}, ['line 4: real: "-" is not a number']),
        (PLAIN + "9,x,1\n", {}, ['line 4: real: "x" is not a number']),
        ("omega,real,imag\n-1,1,1\n", {}, ["line 2: omega: -1", "0 or above"]),
        ("omega,real,imag\nHz,N/m,N/m\n2,93,30\n", {}, ['not "Hz"', "call the column frequency_hz"]),
        ("omega,real,imag\nrad/s,N,N\n2,93,30\n", {}, ["real", "not a stiffness", "N/m, N/mm, N*m/rad"]),
        ("omega,real,imag\nrad/s,N*s/m,N*s/m\n2,93,30\n", {}, ["not a stiffness", 'add quantity = "impedance"']),
        ("omega,real,imag\nrad/s,dB,dB\n2,93,30\n", {}, ["real", '"dB"', "only a magnitude"]),
        ("omega,magnitude,phase_deg\nrad/s,N/m,rad\n2,93,30\n", {}, ["phase_deg: the unit must be deg"]),
        ("omega,real,imag\nrad/s,N*m/rad,N*m/rad\n2,93,30\n", {}, ["translation and rotation"]),
        ("omega,real,imag,coherence\n2,93,30,1.2\n", {"averages": 10}, ["line 2: coherence: 1.2", "0 to 1"]),
        ("omega,real,imag,coherence\n2,93,30,0.9\n", {"averages": 1}, ["averages: 1", "at least 2"]),
        ("omega,real,imag,coherence\n2,93,30,0.9\n", {"averages": 9, "confidence": 95}, ["confidence: 95", "0 and 1"]),
        ("omega,real,imag,radius\n2,93,30,-1\n", {}, ["line 2: radius: -1"]),
        (PLAIN, {"averages": 9}, ["averages needs the column coherence"]),
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
    ("scene", "words"),
    [
        (SCENE + '[[effects]]\nmodel = "delay"\ntau = "1 ms"\n', "effects: a measured scene has"),
        (SCENE + '[rendered]\nmodel = "maxwell"\n', "rendered: a measured scene has"),
        ('[perceived]\nfile = "bench.csv"\n', "[environment] is missing"),
        ('[environment]\nfile = "bench.csv"\n', "[perceived] is missing"),
        (
            SCENE + '[evaluation]\nband = ["20 rad/s", "30 rad/s"]\n',
            "bench.csv has no frequency point from 20 to 30 rad/s",
        ),
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
    assert "verdicts at these points alone, none between them" in " ".join(out.split())
    assert "ertain:" not in out
    assert "unresolved" in latex.read_text(encoding="utf-8")
    assert "<svg" in report.read_text(encoding="utf-8")
    assert {x.name for x in tmp_path.glob("*.png")} == {"ratios.png", "nyquist.png"}


def test_in_python_other_questions_say_what_they_need() -> None:
    scene = hs.MeasuredScene(FU.environment, hs.measured([1.0], [1.0]))
    for question in (hs.require, hs.stability, hs.metrics, hs.sensitivity, hs.tolerances, hs.derive, hs.evaluate_all):
        with pytest.raises(hs.SceneError, match="only evaluate, compare and identify take it"):
            question(*((scene, "omega_n") if question is hs.require else (scene,)))
    assert len(hs.compare(scene, scene)) == 2


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
        (([1j], [1]), {}, "omega: must be real"),
        (("x.csv", [1]), {}, "leave out H"),
        (([1], [1]), {"coherence": [2], "averages": 5}, "coherence: 2"),
    ],
)
def test_bad_arrays_are_refused(arguments: tuple[object, ...], keys: dict[str, object], words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.measured(*arguments, **keys)  # type: ignore[arg-type]
    assert words in str(error.value)


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
    assert np.array_equal(hs.measured(felt.to_csv(tmp_path / "out.csv")).discs, felt.discs)
    stated: dict[str, Any] = {"confidence": 0.9, "slope": "20 ms"}
    for own in ({"coherence": [0.9, 0.5], "averages": 9.5}, {"radius": [0.1, 1 / 3]}):
        felt = hs.measured([1.0, 2.0], [0.1 + 1j, 1 / 3], **own, **stated)
        again = hs.measured(felt.to_csv(tmp_path / "out.csv"))
        assert (again.averages, again.confidence, again.slope) == (felt.averages, 0.9, felt.slope)
        assert np.array_equal(again.discs, felt.discs)
        assert hs.measured(tmp_path / "out.csv", confidence=0.5, slope="1 ms").confidence == 0.5
    plain = hs.measured(hs.measured([1.0], [2.0]).to_csv(tmp_path / "out.csv"))
    assert (plain.discs, plain.confidence, plain.slope) == (None, 0.95, None)
    assert (tmp_path / "out.csv").read_text(encoding="utf-8").startswith("omega")
    (tmp_path / "out.csv").write_text("# averages = 16 (Hann)\nomega,real,imag\n1,2,3\n", encoding="utf-8")
    assert hs.measured(tmp_path / "out.csv").averages is None  # a remark of another program


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


def test_frequencies_at_which_the_response_is_infinite_are_left_out() -> None:
    rotor = hs.Scene(hs.environments.expression("1/s + s"), (hs.effects.first_order_lag(5),), (0, 10))
    assert hs.sampled(rotor, points=11).omega.tolist() == list(range(1, 11))


SPRING = hs.environments.mass_spring_damper(k=100)


REAL, IMAG = hs.Part.REAL, hs.Part.IMAG


def judged(
    perceived: Any, environment: Any = SPRING, jnd: Any = 0.1, omega: Any = None, **certainty: Any
) -> hs.MeasuredEvaluation:
    at = np.arange(1.0, len(perceived) + 1) if omega is None else omega
    return hs.evaluate(hs.MeasuredScene(environment, hs.measured(at, perceived, **certainty), threshold=jnd))


# Lines.


def test_lines_are_compared_with_those_of_the_environment_at_the_same_frequency_to_a_billionth() -> None:
    own = hs.measured([1, 2, 3, 3 + 1e-6, 5], [10, 20, 30, 31, 50])
    felt = hs.measured([0.5, 1 + 0.9e-9, 2 * (1 - 0.9e-9), 3 + 1e-6, 4, 5 * (1 + 1.1e-9)], [1, 2, 3, 4, 5, 6])
    one, other = matched(hs.MeasuredScene(own, felt))
    assert other is not None
    assert (one.H.tolist(), other.H.tolist()) == ([2, 3, 4], [10, 20, 31])
    e = hs.evaluate(hs.MeasuredScene(own, felt))
    assert (len(e), e.left_out) == (3, 3)
    with pytest.raises(hs.SceneError, match="arm and hand have no frequency in common"):
        hs.evaluate(hs.MeasuredScene(hs.measured([1], [1], name="arm"), hs.measured([2], [1], name="hand")))
    with pytest.raises(hs.SceneError, match="H_env is infinite at 0 rad/s"):
        judged([1, 2], hs.environments.expression("1 + 1/s"), omega=[0, 1])


def test_the_disc_of_a_change_holds_every_quotient_of_what_both_discs_hold() -> None:
    rng = np.random.default_rng(3)
    env, perc = (rng.normal(size=40) + 1j * rng.normal(size=40) for _ in range(2))
    r_env, r_perc = (np.abs(env) * rng.uniform(0, x, 40) for x in (0.6, 0.5))
    omega = np.arange(1.0, 41)
    x = lines_of(hs.MeasuredScene(hs.measured(omega, env, radius=r_env), hs.measured(omega, perc, radius=r_perc)))
    size, share = np.abs(env), r_env / np.abs(env)
    assert x.change == pytest.approx((perc - env) / size, rel=1e-14)
    assert x.radius == pytest.approx(
        ((r_env + r_perc) / size + np.abs(perc - env) / size * share) / (1 - share), rel=1e-12
    )
    edge = np.exp(2j * np.pi * np.arange(60) / 60)
    a, b = (env + r_env * edge[:, None])[:, None], (perc + r_perc * edge[:, None])[None]
    assert (np.abs((b - a) / np.abs(a) - x.change) <= x.radius * (1 + 1e-12)).all()
    bare = lines_of(hs.MeasuredScene(SPRING, hs.measured([1, 2], [90, 100])))
    assert (bare.radius, bare.perc_radius.tolist(), bare.env_radius.tolist()) == (None, [0, 0], [0, 0])
    one = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[10]), hs.measured([1], [10])))
    assert one.radius is not None
    assert one.radius.tolist() == [np.inf]


def test_signs_are_told_where_a_disc_leaves_no_other() -> None:
    env = np.array([100, 100, 100, -50, 100, 100, 2, 100.0])
    perc = np.array([120, 100, 80, -49, -30, 90, -3, 0.0])
    radius = np.array([5, 0, 5, 2, 29, 10, 4, 0.0])
    omega = np.arange(1.0, 9)
    for part, turn in ((REAL, 1), (IMAG, 1j)):
        x = lines_of(hs.MeasuredScene(hs.measured(omega, turn * env), hs.measured(omega, turn * perc, radius=radius)))
        found = signs(x, part)
        assert found.environment.tolist() == [1, 1, 1, -1, 1, 1, 1, 1]
        assert found.perceived.tolist() == [1, 1, 1, -1, -1, 1, OPEN, 0]
        assert found.compared.tolist() == [1, 0, -1, OPEN, -1, OPEN, OPEN, -1]
        assert found.known.tolist() == [True, True, True, False, True, False, False, True]
        labels = [tuple(y.value for y in found.label(part, i)) for i in (0, 1, 2)]
        what = "stiffness" if part is REAL else "damping"
        assert labels == [(what, "higher"), (what, "equal"), (what, "lower")]
    both = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[1]), hs.measured([1], [13], radius=[1.9])))
    assert signs(both, REAL).compared.tolist() == [1]
    wider = lines_of(hs.MeasuredScene(hs.measured([1], [10], radius=[1.2]), hs.measured([1], [13], radius=[1.9])))
    assert signs(wider, REAL).compared.tolist() == [OPEN]


def test_a_line_exceeds_is_below_or_open_as_its_disc_lies() -> None:
    """Of a spring of 100 N/m and a JND of 10 %; the border belongs to what is not noticed."""
    cases = [
        (111, 0.5, 1),
        (111, 1, 0),
        (109, 1, -1),
        (109, 1.01, 0),
        (110, 0, -1),
        (110.001, 0, 1),
        (89, 0.9, 1),
        (100, 10, -1),
        (100, np.inf, 0),
    ]
    e = judged([x for x, _, _ in cases], radius=[r for _, r, _ in cases])
    assert e.verdict[REAL].tolist() == [code for _, _, code in cases]
    assert e.distance[REAL] == pytest.approx([abs(x - 100) / 100 - 0.1 for x, _, _ in cases], abs=1e-15)
    assert [row.real.value for row in e.rows] == [
        {1: "exceeds", -1: "below", 0: "unresolved"}[code] for _, _, code in cases
    ]
    zero = judged(
        [5 + 1j, 5 + 1j, 0.5],
        hs.environments.mass_spring_damper(m=1),
        omega=[0, 1e-200, 2e-200],
        radius=[2, 2, 2],
        jnd={"real": 0.1, "imag": 0.1, "floor": 3.5},
    )
    assert (zero.verdict[REAL].tolist()[0], zero.verdict[IMAG].tolist()[0]) == (0, -1)
    for floor, code in ((2.9, 1), (3, 0), (7, -1), (6.9, 0)):
        one = judged(
            [5],
            hs.environments.mass_spring_damper(m=1),
            omega=[0],
            radius=[2],
            jnd={"real": 0.1, "imag": 0.1, "floor": floor},
        )
        assert one.verdict[REAL].tolist() == [code]


SHAPES = [
    0.1, {"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.3}, {"shape": "ellipse", "real": 0.2, "imag": 0.3, "tilt": 0.5}, {"shape": "diamond", "real": 0.2, "imag": 0.3},
    {"shape": "polygon", "corners": [[0.3, 0], [0, 0.2], [-0.2, -0.2]]}, {"real": 0.1, "imag": 0.2, "floor": "9 N/m"},
]  # fmt: skip


@pytest.mark.parametrize("jnd", SHAPES)
def test_rows_percepts_and_documents_are_the_same_answer(jnd: Any) -> None:
    rng = np.random.default_rng(5)
    perceived = 100 * (1 + 0.5 * rng.normal(size=60) + 0.5j * rng.normal(size=60))
    e = judged(
        perceived,
        hs.environments.kelvin_voigt(100, 2),
        jnd,
        omega=np.linspace(1, 20, 60),
        radius=rng.uniform(0, 12, 60),
    )
    change = (perceived - (100 + 2j * e.lines.omega)) / np.abs(100 + 2j * e.lines.omega)
    for i, row in enumerate(e.rows):
        assert (row.omega, row.ratio_real, row.ratio_imag) == pytest.approx(
            (e.lines.omega[i], abs(change[i].real), abs(change[i].imag)), rel=1e-12
        )
        assert (row.joint is None) == (e.joint is None)
    parsed = json.loads(e.to_json())
    assert parsed == json.loads(json.dumps(e.to_dict()))
    assert parsed["lines"] == 60
    told = {(p.part, p.omega): p for p in e.percepts}
    limits = read_threshold(jnd)
    for part in (REAL, IMAG, None):
        for i in np.flatnonzero(e.named(part)):
            p = told.pop((part, float(e.lines.omega[i])))
            if part is None:
                far, near = e.order(i)
                assert p.other is not None
                assert (p.property, p.change) == e.signs[near].label(near, i)
                assert p.other == e.signs[far].label(far, i)
            else:
                assert (p.property, p.change, p.other) == (*e.signs[part].label(part, i), None)
    assert told == {}
    if e.joint is None:
        assert not e.noticed(None).any()
    else:
        for i in np.flatnonzero(e.noticed(None)):
            assert (e.joint.verdict[i], e.verdict[REAL][i], e.verdict[IMAG][i]) == (1, -1, -1)
    if jnd == SHAPES[3]:
        nearer = np.abs(change.real) / float(limits.real) > np.abs(change.imag) / float(limits.imag)
        assert e.real_nearer.tolist() == nearer.tolist()


@given(st.lists(st.integers(2, 40), min_size=1, max_size=9), st.integers(0, 99))
def test_what_resolves_half_and_all_of_the_open_lines_is_the_least_that_does(percents: list[int], seed: int) -> None:
    """Of a spring of 100 N/m: each line lies so many per mille beside its threshold, with discs that are too large."""
    margins = np.array(percents) / 1000
    rng = np.random.default_rng(seed)
    perceived = 100 * (1.1 + margins * rng.choice([-1, 1], len(margins)))
    n, g2 = 9, np.full(len(margins), 0.5)
    e = judged(perceived, coherence=g2, averages=n)
    assert e.needed is not None
    assert e.needed.lines == len(margins)
    order = np.sort(margins)[::-1]
    half = order[(len(order) - 1) // 2]
    assert (e.needed.radius.half, e.needed.radius.all) == pytest.approx((half, order[-1]), rel=1e-9)
    relative = margins * 100 / perceived
    for share, values in (
        (e.needed.coherence, coherence_for(relative, n)),
        (e.needed.averages, averages_for(relative, g2)),
    ):
        assert share is not None
        ranked = np.sort(values)
        assert (share.half, share.all) == pytest.approx((ranked[(len(ranked) - 1) // 2], ranked[-1]), rel=1e-6)
    told = e.to_dict()["needed"]
    assert told == {
        "lines": len(margins),
        **{key: getattr(e.needed, key).row() for key in ("radius", "coherence", "averages")},
    }


def test_what_nobody_measures_is_not_asked_for_and_what_is_told_needs_nothing() -> None:
    near = judged([110 + 1e-5, 115], coherence=[0.5, 0.5], averages=9)
    assert near.needed is not None
    assert near.needed.coherence is not None
    assert near.needed.averages is not None
    assert (near.needed.coherence.all, near.needed.averages.all) == (None, None)
    assert near.needed.coherence.half is not None
    assert MOST_COHERENCE == 1 - 1e-6
    assert MOST_AVERAGES == 1e6
    assert judged([100, 150], radius=[1, 1]).needed is None
    plain = judged([111], radius=[5]).needed
    assert plain is not None
    assert (plain.coherence, plain.averages) == (None, None)
    both = judged([111], hs.measured([1], [100], radius=[3]), coherence=[0.9], averages=9).needed
    assert both is not None
    assert both.coherence is None
    own = judged([111], hs.measured([1], [100]), coherence=[0.5], averages=9).needed
    assert own is not None
    assert own.coherence is not None
    two = judged([111 + 9j], radius=[5], jnd={"real": 0.1, "imag": 0.1}).needed
    assert two is not None
    assert two.radius.all == pytest.approx(0.01, rel=1e-9)  # of the part that is nearer


@pytest.mark.slow
def test_a_limit_that_grows_with_the_frequency_is_met_where_it_is_as_large_as_the_change() -> None:
    """Nothing moves but the limit, 0.1 + omega/100: a change by x is noticed below 100 x - 10, and what is told ends next to that."""
    for x, error in ((0.203, 0.0), (0.131, 0.02)):
        H = [100 * (1 + x)] * 2
        felt = hs.measured([1, 21], H, radius=[100 * error] * 2, slope="1e-9 N*s/m")
        jnd = {"real": "0.1 + omega/100", "imag": "0.1"}
        between = hs.evaluate(hs.MeasuredScene(SPRING, felt, threshold=read_threshold(jnd))).between
        assert between is not None
        told = between.told[REAL]
        ends = {c: [*zip(told.low[told.code == c], told.high[told.code == c], strict=True)] for c in (1, -1)}
        [(first, above)], [(below, last)] = ends[1], ends[-1]
        assert (first, last) == (1, 21)
        assert 100 * (x - error) - 10.5 < above <= 100 * (x - error) - 10 + 1e-6
        assert 100 * (x + error) - 10 - 1e-6 <= below < 100 * (x + error) - 9.5


def test_of_a_display_that_gives_energy_away_stiffness_has_a_name_and_damping_has_none() -> None:
    """Both parts change by more than a tenth; where the imaginary part that is felt is negative, it is no damping."""
    for imag, named in ((5, {REAL}), (-20, {REAL}), (40, {REAL, IMAG})):
        e = judged([160 + imag * 1j], hs.measured([1], [100 + 10j]), radius=[0.1])
        assert {part for part in hs.Part if e.named(part).any()} == named | ({IMAG} if imag == 40 else set())


@pytest.mark.slow
def test_the_document_tells_bounds_what_contradicts_them_and_how_large_discs_grow() -> None:
    felt = hs.measured([1, 2, 3], [100, 100, 180], radius=[1, 2, 1], slope="10 N*s/m")
    scene = hs.MeasuredScene(SPRING, felt, threshold=0.1)
    told = hs.evaluate(scene).to_dict()["between"]
    assert told["slope"] == {"perceived": {"bound": 10.0, "unit": "N*s/m", "relative": False}}
    assert told["contradicted"] == [[2.0, 3.0]]
    assert told["grown"] == pytest.approx(0.06, rel=1e-9)  # of 1 + 5 and 2 + 5 the smaller, over 100
    assert [x["verdict"] for x in told["real"]][-1] == "unresolved"
    assert told["real"][-1]["band"][1] == 3
    own = hs.measured([1, 2], [100, 101], slope="20 ms")
    both = hs.MeasuredScene(own, hs.measured([1, 2], [100, 101], slope="1 s"))
    bounds = hs.evaluate(both).to_dict()["between"]["slope"]
    assert bounds == {
        "perceived": {"bound": 1.0, "unit": "s", "relative": True},
        "environment": {"bound": 0.02, "unit": "s", "relative": True},
    }
    assert (
        hs.evaluate(hs.MeasuredScene(SPRING, hs.measured([1], [100], slope="1 s"))).to_dict()["between"]["grown"] == 0
    )
    with pytest.raises(hs.SceneError, match="environment: slope is missing"):
        hs.MeasuredScene(hs.measured([1, 2], [100, 101]), felt)
    with pytest.raises(hs.SceneError, match="perceived: slope is missing"):
        hs.MeasuredScene(own, hs.measured([1, 2], [100, 101]))


def test_a_measured_scene_is_made_of_what_was_measured_in_one_motion(tmp_path: Path) -> None:
    line = hs.measured(hs.measured([1, 2], [100, 101]).to_csv(tmp_path / "line.csv"))
    for keys, told in (({"environment": 3}, "environment: int is not an environment or a measured response"), ({"perceived": SPRING}, "perceived: Environment is not a measured response"),
                       ({"environment": hs.environments.mass_spring_damper(k=hs.symbols("k"))}, "is a symbol; give a number"),
                       ({"perceived": hs.measured([1], [1], slope="1 N*m*s/rad"), "environment": hs.environments.mass_spring_damper(k="1 N/m")}, "translation and rotation cannot be mixed")):  # fmt: skip
        with pytest.raises(hs.SceneError, match=told):
            hs.MeasuredScene(**({"environment": SPRING, "perceived": line} | keys))
    scene = hs.MeasuredScene(line, line, title="Mine")
    assert (scene.files, scene.motion, len(scene.slopes)) == ((line.path, line.path), None, 0)
    assert repr(scene) == '<MeasuredScene "Mine": line.csv, felt as measured at 2 lines>'
    assert hs.MeasuredScene(hs.environments.mass_spring_damper(k="1 N*m/rad"), line).motion is not None
    assert hs.MeasuredScene(SPRING, line, ("1 rad/s", 1.5)).band[0] == 1  # type: ignore[index]
    assert scene.aside_keys() == {}
    assert scene.asides() == []


HEXAGON = [[0.1, 0.01], [0.05, 0.09], [-0.05, 0.12], [-0.1, 0], [-0.05, -0.09], [0.05, -0.07]]


REGIONS: dict[str, Any] = {
    "disc": {"shape": "ellipse", "real": 0.1, "imag": 0.1},
    "ellipse": {"shape": "ellipse", "real": 0.2, "imag": 0.06, "tilt": 0.8},
    "narrow": {"shape": "ellipse", "real": 0.05, "imag": 0.15, "tilt": -0.3},
    "diamond": {"shape": "diamond", "real": 0.1, "imag": 0.16},
    "polygon": {"shape": "polygon", "corners": HEXAGON},
    "ways": {"real": {"higher": 0.08, "lower": 0.14}, "imag": {"higher": 0.2, "lower": 0.05}},
    "floor": {"real": 0.1, "imag": 0.1, "floor": "9 N/m"},
    "formula": {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": 0.1, "tilt": "0.05*omega"},
}


JOINT = {"disc", "ellipse", "narrow", "diamond", "polygon", "formula"}


@pytest.mark.parametrize("seed", range(4))
def test_the_way_to_where_a_change_of_one_part_is_noticed_is_that_to_the_ends_of_what_is_not(seed: int) -> None:
    """By the definition in fractions: what grows in magnitude has one limit and what shrinks another; ends are where that changes."""
    draw = random.Random(seed)
    step = Fraction(1, 1000)
    for _ in range(25):
        up, down = (Fraction(draw.randint(1, 12), 4) for _ in range(2))
        e = Fraction(draw.choice([-1, 1]) * draw.randint(1, 20), 8)

        def is_noticed(x: Fraction) -> bool:
            larger, same = abs(e + x) > abs(e), abs(e + x) == abs(e)  # noqa: B023
            return abs(x) > (max(up, down) if same else up if larger else down)  # noqa: B023

        places = {sign * x for x in (up, down, 2 * abs(e)) for sign in (1, -1)}
        ends = [x for x in places if len({is_noticed(y) for y in (x - step, x, x + step)}) == 2]
        c = read_threshold({"real": {"higher": str(up), "lower": str(down)}, "imag": 1})
        changes, ones = [Fraction(draw.randint(-60, 60), 16) for _ in range(12)], np.ones(12)
        found = part_distance(c, hs.Part.REAL, ones, np.array(changes, float), float(e) * ones, (ones, ones))
        for x, distance in zip(changes, found, strict=True):
            way = min(abs(x - end) for end in ends)
            assert distance == (way if is_noticed(x) else -way)


def noticed(name: str, omega: float, env: np.ndarray, perc: np.ndarray) -> dict[str, np.ndarray]:
    """Which changes are noticed, straight from the definitions of DESIGN: by key ``joint``, or by part."""
    c, size = REGIONS[name], np.abs(env)
    x, y = (perc - env).real / size, (perc - env).imag / size
    if name == "polygon":
        corners = np.array(HEXAGON)
        steps = np.roll(corners, -1, axis=0) - corners
        return {
            "joint": np.any(
                [dx * (y - py) - dy * (x - px) < 0 for (px, py), (dx, dy) in zip(corners, steps, strict=True)], axis=0
            )
        }
    if name == "diamond":
        return {"joint": np.abs(x) / 0.1 + np.abs(y) / 0.16 > 1}
    if name == "formula":
        a, b, t = 0.08 + 0.004 * omega, 0.1, 0.05 * omega
        return {"joint": (x / a) ** 2 - 2 * t * (x / a) * (y / b) + (y / b) ** 2 > 1 - t**2}
    if name in JOINT:
        a, b, t = c["real"], c["imag"], c.get("tilt", 0)
        return {"joint": (x / a) ** 2 - 2 * t * (x / a) * (y / b) + (y / b) ** 2 > 1 - t**2}
    if name == "floor":
        return {part: np.abs(d) * size > np.maximum(9, 0.1 * size) for part, d in (("real", x), ("imag", y))}
    found = {}
    for part, d in (("real", x), ("imag", y)):
        after, before = (np.abs(h.real if part == "real" else h.imag) for h in (perc, env))
        found[part] = np.abs(d) > np.where(after > before, c[part]["higher"], c[part]["lower"])
    return found


EDGE = np.exp(2j * np.pi * np.arange(48) / 48)


DISC = np.concatenate([[0], *(share * EDGE for share in (0.25, 0.5, 0.75, 1 - 1e-9))])


@pytest.mark.slow
@example(seed=109, name="diamond", measured_too=False)
@given(st.integers(0, 10_000), st.sampled_from(sorted(REGIONS)), st.booleans())
def test_a_verdict_of_a_region_holds_for_every_truth_within_the_discs(seed: int, name: str, measured_too: bool) -> None:  # noqa: FBT001
    rng = np.random.default_rng(seed)
    omega = np.linspace(1, 15, 8)
    env = rng.normal(size=8) * 100 + 1j * rng.normal(size=8) * 50
    env[0] = 3 + 100j  # a real part so small that -2 e lies within the limits
    perc = env + 0.3 * np.abs(env) * rng.uniform(size=8) * (rng.normal(size=8) + 1j * rng.normal(size=8))
    r_env, r_perc = (np.abs(env) * rng.uniform(0, 0.12, 8) for _ in range(2))
    own = hs.measured(omega, env, radius=r_env * measured_too)
    e = hs.evaluate(
        hs.MeasuredScene(own, hs.measured(omega, perc, radius=r_perc), threshold=read_threshold(REGIONS[name]))
    )
    for i, row in enumerate(e.rows):
        a = (env[i] + r_env[i] * measured_too * DISC)[:, None]
        b = (perc[i] + r_perc[i] * DISC)[None, :]
        for key, seen in noticed(name, omega[i], *np.broadcast_arrays(a, b)).items():
            verdict = getattr(row, key).value
            assert verdict != "exceeds" or seen.all()
            assert verdict != "below" or not seen.any()
            if not measured_too:  # and says no less than it could, but for what the points of the disc do not see
                assert (
                    verdict != "unresolved"
                    or (seen.any() and not seen.all())
                    or _close(name, omega[i], a[0, 0], perc[i], r_perc[i], key)
                )
        assert (row.joint is None) == (name not in JOINT)


def _close(name: str, omega: float, env: complex, perc: complex, radius: float, key: str) -> bool:
    """Whether many points inside the disc are told differently, or a slightly larger or a slightly smaller disc otherwise."""
    edge = np.exp(2j * np.pi * np.arange(2000) / 2000)
    rings = [noticed(name, omega, np.full(2000, env), perc + radius * share * edge)[key] for share in (0.98, 1.02)]
    differ = (
        rings[0].any() and not rings[0].all()
    )  # as where a corner of the region comes in between two points of the disc
    return bool(differ or rings[0].all() != rings[1].all() or rings[0].any() != rings[1].any())


@pytest.mark.dear("polygon")
@pytest.mark.parametrize("name", sorted(set(REGIONS) - {"formula"}))
def test_exact_lines_are_judged_by_a_region_as_the_proven_crossings_say(name: str) -> None:
    omega = np.linspace(0.1, 15, 150)
    exact = hs.sampled("fu2019", omega)
    scene = hs.Scene(FU.environment, FU.effects, (0, 15), read_threshold(REGIONS[name]))
    proven = hs.evaluate(scene)
    felt = hs.measured(omega, exact.H, radius=1e-9 * np.abs(exact.H))
    e = hs.evaluate(hs.MeasuredScene(scene.environment, felt, threshold=read_threshold(REGIONS[name])))
    transparent = np.any(
        [(omega >= float(b.low.omega)) & (omega <= float(b.high.omega)) for b in proven.transparent], axis=0
    )
    if name in JOINT:
        assert e.joint is not None
        assert ((e.joint.verdict == -1) == transparent).all()
        assert ((e.joint.verdict == 1) == ~transparent).all()
    else:
        assert (np.all([e.verdict[part] == -1 for part in hs.Part], axis=0) == transparent).all()
    for p in e.percepts:
        [own] = [
            x
            for x in proven.percepts
            if x.part is p.part and float(x.band.low.omega) <= p.omega <= float(x.band.high.omega)
        ]
        assert (p.property, p.change, p.other) == (own.property, own.change, own.other)


@pytest.mark.slow
@given(st.integers(0, 10_000), st.sampled_from(sorted(REGIONS)))
def test_what_is_told_between_lines_holds_for_all_that_swept_discs_have_in_common(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    omega, slope = np.sort(rng.uniform(1, 15, 3)), rng.uniform(0, 60)
    env, start = 1j * omega * 15 + 100 - 1.8 * omega**2, rng.normal(size=2)
    perc = env + 0.2 * np.abs(env) * (start[0] + 1j * start[1]) + 5 * (rng.normal(size=3) + 1j * rng.normal(size=3))
    radius = np.abs(env) * rng.uniform(0, 0.05, 3)
    felt = hs.measured(omega, perc, radius=radius, slope=f"{slope:.17g} N*s/m")
    e = hs.evaluate(hs.MeasuredScene(FU.environment, felt, threshold=read_threshold(REGIONS[name])))
    for key, own in ((part.value if part else "joint", x) for part, x in e.between.told.items()):  # type: ignore[union-attr]
        if name in JOINT and key != "joint":
            continue
        for low, high, code in zip(own.low, own.high, own.code, strict=True):
            for w in rng.uniform(low, high, 1):
                i = min(int(np.searchsorted(omega, w, side="right")) - 1, 1)
                left, right = radius[i] + slope * (w - omega[i]), radius[i + 1] + slope * (omega[i + 1] - w)
                points = perc[i] + left * DISC
                points = points[np.abs(points - perc[i + 1]) <= right]
                seen = noticed(name, w, np.full(len(points), 15j * w + 100 - 1.8 * w**2), points)[key]
                assert code != 1 or seen.all()
                assert code != -1 or not seen.any()


@pytest.mark.slow
def test_where_neither_part_is_noticed_alone_both_are_named(tmp_path: Path, call: Callable[..., Any]) -> None:
    (tmp_path / "bench.csv").write_text("omega,real,imag,radius\n2,100.6,37,0.1\n3,92,45,30\n", encoding="utf-8")
    (tmp_path / "bench.toml").write_text(
        '[environment]\nmodel = "mass-spring-damper"\nm = "1.8 kg"\nb = "15 N*s/m"\nk = "100 N/m"\n'
        '[perceived]\nfile = "bench.csv"\n[evaluation]\njnd = { shape = "diamond", real = 0.1, imag = 0.1 }\n',
        encoding="utf-8",
    )
    status, out, _ = call("evaluate", str(tmp_path / "bench.toml"), "--json", "--figures", str(tmp_path))
    document = json.loads(out)
    assert (status, [x["joint"] for x in document["rows"]]) == (0, ["exceeds", "unresolved"])
    assert [(x["part"], x["property"], x["change"]) for x in document["percepts"]] == [
        ("joint", ["damping", "stiffness"], ["higher", "higher"])
    ]
    assert document == hs.evaluate(tmp_path / "bench.toml").to_dict()
    assert {x.name for x in tmp_path.glob("*.png")} == {"ratios.png", "nyquist.png", "plane.png"}
    text = " ".join(call("evaluate", str(tmp_path / "bench.toml"))[1].split())
    assert "The change lies outside the diamond at 1 of 2 points" in text
    assert "Felt as higher damping and higher stiffness at 2 rad/s" in text


def test_where_the_environment_is_zero_the_floor_is_what_is_noticed() -> None:
    spring_and_mass = hs.environments.mass_spring_damper(m=1, k=100)
    felt = hs.measured([10.0], [5 + 12j], radius=[2.0])
    e = hs.evaluate(hs.MeasuredScene(spring_and_mass, felt, threshold=read_threshold(REGIONS["floor"])))
    assert [(x.real.value, x.imag.value) for x in e.rows] == [("below", "exceeds")]


# The distance from an ellipse, with sixty digits.


def from_ellipse(a: float, b: float, tilt: float, x: float, y: float) -> mpmath.mpf:
    """By the foot of the perpendicular in the principal axes, on them in closed form; negative inside."""
    a, b, tilt, x, y = map(mpmath.mpf, (a, b, tilt, x, y))
    mixed, apart = tilt * a * b, (a * a - b * b) / 2
    turned, size = mpmath.atan2(mixed, apart) / 2, mpmath.hypot(mixed, apart)
    long, short = mpmath.sqrt((a * a + b * b) / 2 + size), mpmath.sqrt((a * a + b * b) / 2 - size)
    u, v = abs(x * mpmath.cos(turned) + y * mpmath.sin(turned)), abs(y * mpmath.cos(turned) - x * mpmath.sin(turned))
    if v < mpmath.mpf(10) ** -50:
        known = [abs(u - long)] + [short * mpmath.sqrt(1 - u * u / (2 * size))] * (u * long < 2 * size)
        found = min(known)
    else:
        low, high = short * v, mpmath.hypot(long * u, short * v)
        for _ in range(250):
            t = (low + high) / 2
            low, high = (t, high) if (long * u / (t + 2 * size)) ** 2 + (short * v / t) ** 2 > 1 else (low, t)
        found = mpmath.hypot(u - long**2 * u / (t + 2 * size), v - short**2 * v / t)
    return -found if (u / long) ** 2 + (v / short) ** 2 <= 1 else found


@pytest.mark.slow
def test_the_distance_from_an_ellipse_has_its_digits_on_and_beside_its_axes_too() -> None:
    chance = random.Random(3)
    for _ in range(150):
        a, b = (10 ** chance.uniform(-3, 1) for _ in range(2))
        tilt = chance.choice([0, 0, chance.uniform(-0.999, 0.999), 1 - 10 ** chance.uniform(-8, -1)])
        x, y = (10 ** chance.uniform(-4, 1) * chance.choice([-1, 0, 1, 1, 1e-9]) for _ in range(2))
        c = read_threshold({"shape": "ellipse", "real": repr(a), "imag": repr(b), "tilt": repr(tilt)})
        away = joint_distance(c, np.ones(1), np.array([x]), np.array([y]))
        assert away is not None
        with mpmath.workdps(60):
            assert abs(float(away[0]) - from_ellipse(a, b, tilt, x, y)) < 2e-14 * (1 + abs(complex(x, y)))


@pytest.mark.parametrize(("radius", "verdict"), [(0.099595, "below"), (0.099603, "unresolved")])
def test_a_change_along_an_axis_of_an_ellipse_is_told_up_to_its_depth(radius: float, verdict: str) -> None:
    """0.01 along the long axis of an ellipse of 0.15 by 0.1: sqrt(0.00992) = 0.0995992 deep."""
    felt = hs.measured([2.0], [101.0], radius=[100 * radius])
    jnd = read_threshold({"shape": "ellipse", "real": "0.15", "imag": "0.1"})
    spring = hs.environments.mass_spring_damper(k=100)
    [row] = hs.evaluate(hs.MeasuredScene(spring, felt, threshold=jnd)).rows
    assert row.joint is not None
    assert row.joint.value == verdict


def test_a_formula_is_known_to_its_last_digits_where_its_terms_cancel() -> None:
    """(omega - 15)^8 written out has terms of 10^11, of which floats keep 10^-5: as much as a change is off its threshold here."""
    formula = (Rational(1, 10) + (OMEGA - 15) ** 8 / (OMEGA + 1)).expand()
    at = np.concatenate([np.linspace(14, 16, 41), [0.0, 15.0, 300.0]])
    exact = [Fraction(1, 10) + (Fraction(x) - 15) ** 8 / (Fraction(x) + 1) for x in at.tolist()]
    assert values_of(formula, at).tolist() == pytest.approx(list(map(float, exact)), rel=1e-13, abs=0)
    omega, env = np.array([14.95, 15.0, 15.05]), np.full(3, 100 + 0j)
    c = read_threshold({"real": "0.1 + (omega - 15)^8", "imag": 0.1})
    for change, verdict in ((0.100001, "exceeds"), (0.099999, "below")):
        felt = hs.measured(omega, env * (1 + change), radius=np.full(3, 1e-9))
        rows = hs.evaluate(hs.MeasuredScene(hs.measured(omega, env), felt, threshold=c)).rows
        assert [row.real.value for row in rows] == [verdict] * 3


def environment(omega: Any) -> Any:
    s = 1j * np.asarray(omega)
    return 1.8 * s**2 + 15 * s + 100


def evaluated(omega: Any, H: Any, slope: str, radius: Any = None, **keys: Any) -> hs.MeasuredEvaluation:
    felt = hs.measured(omega, H, radius=np.zeros(len(omega)) if radius is None else radius, slope=slope)
    return hs.evaluate(hs.MeasuredScene(FU.environment, felt, **keys))


def steepest() -> float:
    """Of the paper's display on 0 to 15 rad/s: of its closed form, by its own derivative, with what a grid can miss."""
    s = 1j * np.linspace(0, 15, 20_001)
    top, low = np.polynomial.Polynomial([100, 15, 1.8]), np.polynomial.Polynomial([6400, 80, 1])
    slope = 6400 * (top.deriv()(s) * low(s) - top(s) * low.deriv()(s)) / low(s) ** 2
    return float(np.abs(slope).max() * 1.001)


def stretches(e: hs.MeasuredEvaluation, part: hs.Part | None) -> list[tuple[float, float, int]]:
    assert e.between is not None
    own = e.between.told[part]
    return list(zip(own.low.tolist(), own.high.tolist(), own.code.tolist(), strict=True))


def proven_crossing(part: hs.Part) -> float:
    [crossing] = [c for c in hs.evaluate(FU).crossings if c.part is part]
    return float(crossing.omega)


@pytest.mark.slow
def test_what_is_told_of_an_exact_scene_is_what_its_proven_crossings_say() -> None:
    omega = np.linspace(0.5, 15, 1000)
    e = evaluated(omega, hs.sampled("fu2019", omega).H, f"{steepest():.17g} N*s/m")
    assert e.between is not None
    assert e.between.contradicted == ()
    for part in hs.Part:
        cross, told = proven_crossing(part), stretches(e, part)
        assert (told[0][0], told[-1][1]) == (0.5, 15)
        assert [low for low, _, _ in told[1:]] == [high for _, high, _ in told[:-1]]
        for low, high, code in told:
            assert code != 1 or low >= cross
            assert code != -1 or high <= cross
        open_length = sum(high - low for low, high, code in told if code == 0)
        assert open_length < 1.2
        assert all(abs(low - cross) < 0.8 and abs(high - cross) < 0.8 for low, high, code in told if code == 0)


def margins(w: float, lines: list[tuple[float, complex, float]], slope: float, part: hs.Part) -> list[float]:
    """Of both neighbouring discs at a frequency, and of the smallest around both: by how much each tells. Plain geometry."""
    (w1, c1, r1), (w2, c2, r2) = lines
    r1, r2 = r1 + slope * (w - w1), r2 + slope * (w2 - w)
    discs = [(c1, r1), (c2, r2)]
    d = abs(c2 - c1)
    cosine = (r1**2 + d**2 - r2**2) / (
        2 * r1 * d
    )  # of the angle at c1 between the other centre and a corner of the lens
    if 0 < cosine * r1 < d:
        discs.append((c1 + (c2 - c1) / d * r1 * cosine, r1 * np.sqrt(max(1 - cosine**2, 0))))
    env = complex(environment(w))
    return [abs(abs((c - env).real if part is hs.Part.REAL else (c - env).imag) - 0.1 * abs(env)) - r for c, r in discs]


@pytest.mark.slow
def test_stretches_end_where_no_swept_disc_tells_any_more() -> None:
    omega, slope = np.linspace(1, 15, 40), 75.0
    H, radius = hs.sampled("fu2019", omega).H, np.full(40, 0.4)
    e = evaluated(omega, H, f"{slope} N*s/m", radius)
    lines = list(zip(omega.tolist(), H.tolist(), radius.tolist(), strict=True))
    seen = 0
    for part in hs.Part:
        for low, high, code in stretches(e, part):
            assert high - low > 1e-9 or code == 0
            for end, inwards in ((low, 1), (high, -1)):
                gap = int(np.searchsorted(omega, end, side="right")) - 1
                if code == 0 or np.abs(omega - end).min() < 1e-6:
                    continue
                inside, outside = (
                    margins(end + step * inwards, lines[gap : gap + 2], slope, part) for step in (1e-7, -1e-7)
                )
                assert max(inside) > 0 > max(outside)
                seen += 1
    assert seen > 80


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_two_lines_contradict_a_slope_where_no_way_between_them_keeps_to_it(seed: int) -> None:
    """A relative slope lets a response grow and shrink like an exponential: where two ways meet soonest is found by trying."""
    rng = np.random.default_rng(seed)
    for _ in range(4):
        omega = np.sort(rng.uniform(1, 15, 2))
        apart = omega[1] - omega[0]
        steep, sizes = rng.uniform(0.1, 1.2) / apart, rng.uniform(40, 160, 2)
        radius = rng.uniform(0, 5, 2) * rng.integers(0, 2)
        ways = np.linspace(0, apart, 10_001)
        reach = sum(
            r + (a + r) * np.expm1(steep * way) for a, r, way in zip(sizes, radius, (ways, ways[::-1]), strict=True)
        ).min()
        low, high = abs(sizes[0] - sizes[1]), sizes.sum()
        for far in (reach * 0.999, reach * 1.001):
            if not low < far < high:
                continue
            turn = np.arccos((sizes @ sizes - far**2) / (2 * sizes.prod()))
            e = evaluated(omega, sizes * np.exp([0, 1j * turn]), f"{steep:.17g} s", radius)
            assert e.between is not None
            assert bool(e.between.contradicted) == (far > reach)
    # lines of one phase: the larger one shrinks or the smaller one grows, exp(2/10 2) = 1.49 times
    for ratio in (1.49, 1.492):
        e = evaluated(np.array([3.0, 5.0]), np.array([50.0, 50 * ratio]), "0.2 s")
        assert e.between is not None
        assert bool(e.between.contradicted) == (ratio > np.exp(0.4))


class Random:
    """A response with a bound on its slope that is known by hand, lines of it with errors within their discs, and an environment."""

    def __init__(self, seed: int, *, relative: bool) -> None:
        rng = np.random.default_rng(seed)
        self.relative = relative
        self.omega = np.sort(rng.uniform(0.5, 15, rng.integers(2, 60)))
        self.at = np.concatenate([self.omega, rng.uniform(self.omega[0], self.omega[-1], 400)])
        self.gains, self.delays = rng.uniform(-40, 40, 4), rng.uniform(0, 0.5, 4)
        self.corners, self.size = rng.uniform(3, 60, 4) * rng.choice([1, -1], 4), rng.uniform(20, 200)
        true = self.truth(self.omega)
        self.radius = rng.uniform(0, 0.03, len(true)) * np.abs(true)
        self.H = true + self.radius * np.sqrt(rng.uniform(size=len(true))) * np.exp(
            2j * np.pi * rng.uniform(size=len(true))
        )

    def truth(self, omega: Any) -> Any:
        s = 1j * np.asarray(omega)[:, None]
        if self.relative:
            return self.size * np.exp(-s[:, 0] * self.delays[0]) * (1 + s / self.corners).prod(1) / (1 + s / 30)[:, 0]
        return 80 + (self.gains * np.exp(-s * self.delays)).sum(1)

    @property
    def slope(self) -> str:
        """|d exp(-j w t)/dw| = t; and of each root p of H, |d ln(1 + j w/p)/dw| = 1/|p + j w| <= 1/|p|."""
        if self.relative:
            return f"{self.delays[0] + (1 / np.abs(self.corners)).sum() + 1 / 30:.17g} s"
        return f"{float((np.abs(self.gains) * self.delays).sum()):.17g} N*s/m"


def check_told(seed: int, *, relative: bool) -> float:
    """That all that is told of random lines is true. Returns on which share of the frequencies something is told."""
    bench = Random(seed, relative=relative)
    e = evaluated(bench.omega, bench.H, bench.slope, bench.radius)
    assert e.between is not None
    assert e.between.contradicted == ()
    env, true = environment(bench.at), bench.truth(bench.at)
    told = 0
    for part in hs.Part:
        change = (true - env).real if part is hs.Part.REAL else (true - env).imag
        exceeds = np.abs(change) > 0.1 * np.abs(env)
        for low, high, code in stretches(e, part):
            inside = (bench.at >= low) & (bench.at <= high)
            assert code == 0 or (exceeds[inside] == (code == 1)).all()
            told += int(inside.sum()) * (code != 0)
    return told / (2 * len(bench.at))


@pytest.mark.slow
@given(st.integers(0, 10**6), st.booleans())
def test_what_is_told_between_random_lines_is_true(seed: int, relative: bool) -> None:  # noqa: FBT001
    check_told(seed, relative=relative)


@pytest.mark.slow
def test_something_is_told() -> None:
    assert np.mean([check_told(seed, relative=bool(seed % 2)) for seed in range(6)]) > 0.25


def test_without_a_bound_nothing_is_told_between_the_lines() -> None:
    e = hs.evaluate(hs.MeasuredScene(FU.environment, hs.measured([2.0, 8.0], [93 + 30j, -30 + 120j])))
    assert e.between is None
    assert "between" not in e.to_dict()
    assert "verdicts at these points alone, none between them" in " ".join(str(e).split())


@pytest.mark.slow
def test_lines_that_contradict_the_bound_are_said_to_and_nothing_is_told_there() -> None:
    e = evaluated([2, 4, 6], [93 + 30j, 93 + 31j, 300 + 30j], "20 N*s/m")
    assert e.between is not None
    assert e.between.contradicted == ((4.0, 6.0),)
    assert all(code == 0 or high <= 4 for _, high, code in stretches(e, hs.Part.REAL))
    assert e.to_dict()["between"]["contradicted"] == [[4.0, 6.0]]
    assert "Contradiction: in 1 gap" in " ".join(str(e).split())


def test_a_line_whose_disc_is_the_whole_plane_is_passed_over() -> None:
    omega, H = np.array([2.0, 2.1, 2.2]), np.array([93 + 30j, 500, 93 + 30j])
    e = evaluated(omega, H, "20 N*s/m", [0.1, np.inf, 0.1])
    assert [code for _, _, code in stretches(e, hs.Part.REAL)] == [-1]
    assert e.rows[1].real.value == "unresolved"


def test_an_environment_that_is_measured_too_needs_a_bound_of_its_own() -> None:
    omega = np.linspace(1, 5, 30)
    felt = hs.measured(omega, 1.3 * environment(omega), slope="40 N*s/m", radius=np.full(30, 0.1))
    own = hs.measured(omega, environment(omega), slope="30 N*s/m", radius=np.full(30, 0.1))
    e = hs.evaluate(hs.MeasuredScene(own, felt))
    assert {code for low, _, code in stretches(e, hs.Part.REAL) if low < 3} >= {1}
    assert set(e.to_dict()["between"]["slope"]) == {"perceived", "environment"}
    at = np.linspace(1, 5, 999)
    for part in hs.Part:
        change = 0.3 * environment(at) / np.abs(environment(at))
        exceeds = np.abs(change.real if part is hs.Part.REAL else change.imag) > 0.1
        for low, high, code in stretches(e, part):
            assert code == 0 or (exceeds[(at >= low) & (at <= high)] == (code == 1)).all()
    for one, other, word in (
        (own, hs.measured(omega, felt.H), "perceived"),
        (hs.measured(omega, own.H), felt, "environment"),
    ):
        with pytest.raises(hs.SceneError, match=f"{word}: slope is missing"):
            hs.MeasuredScene(one, other)


@pytest.mark.slow
@pytest.mark.parametrize(
    "jnd", ["0.08 + 0.004*omega", {"shape": "ellipse", "real": "0.08 + 0.004*omega", "imag": 0.1, "tilt": "0.05*omega"}]
)
def test_limits_that_depend_on_the_frequency_are_followed_between_lines(jnd: Any) -> None:
    omega = np.linspace(0.5, 15, 400)
    threshold = read_threshold(jnd)
    e = evaluated(omega, hs.sampled("fu2019", omega).H, f"{steepest():.17g} N*s/m", threshold=threshold)
    proven = hs.evaluate(hs.Scene(FU.environment, FU.effects, (0, 15), threshold))
    bands = [(float(b.low.omega), float(b.high.omega)) for b in proven.transparent]
    key = None if isinstance(jnd, dict) else hs.Part.IMAG
    told = stretches(e, key)
    assert sum(high - low for low, high, code in told if code) > 8
    for low, high, code in told:
        if code == -1 and key is None:
            assert any(a <= low and high <= b for a, b in bands)
        if code == 1:
            assert all(high <= a or low >= b for a, b in bands)


# As a user sees it.


def steep(folder: Path, slope: str, unit: str = "N/m") -> Path:
    omega = np.linspace(1, 15, 57)
    H = hs.sampled("fu2019", omega).H
    rows = "".join(f"{w!r},{h.real!r},{h.imag!r},1\n" for w, h in zip(omega.tolist(), H.tolist(), strict=True))
    return bench(folder, f"omega,real,imag,radius\nrad/s,{unit},{unit},{unit}\n{rows}", slope=slope)


@pytest.mark.slow
def test_a_bound_may_be_stated_per_hertz_and_as_a_share(tmp_path: Path) -> None:
    per_hertz = hs.evaluate(steep(tmp_path, '"408.4070449666731 N/m/Hz"')).to_dict()["between"]
    assert per_hertz["slope"]["perceived"]["bound"] == pytest.approx(65, rel=1e-12)
    share = hs.evaluate(steep(tmp_path, '"600 ms"'))
    assert share.to_dict()["between"]["slope"]["perceived"] == {"bound": 0.6, "unit": "s", "relative": True}
    assert "0.6 s times |H|" in str(share)


@pytest.mark.parametrize(
    ("slope", "words"),
    [
        ("65", 'slope: "65" has no unit: give |dH/domega| with its unit'),
        ('"65"', "has no unit"),
        ('"65 N/m"', "is no bound of a slope"),
        ('"-65 N*s/m"', "must be >= 0"),
        ('"65 N*m*s/rad"', "translation and rotation cannot be mixed"),
        ("true", "has no unit"),
        ("[1]", "has no unit"),
    ],
)
def test_a_bound_that_is_none_is_refused_in_one_sentence(
    tmp_path: Path, call: Callable[..., Any], slope: str, words: str
) -> None:
    status, out, err = call("evaluate", str(steep(tmp_path, slope)))
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert words in err
    assert "slope" in err


MP = mpmath.mp.clone()


MP.dps = 100


MOVING = [
    {"shape": "ellipse", "real": "0.08 + omega/250", "imag": 0.1, "tilt": "omega/20"},
    {"shape": "ellipse", "real": 2, "imag": "0.01*omega", "tilt": "1 - omega^2/10000000"},
    {"shape": "ellipse", "real": "1/(1 + omega)", "imag": "1/(1 + omega)"},
    {"shape": "diamond", "real": "0.1 + omega/1000", "imag": "3/(2 + omega^2)"},
    {"shape": "polygon", "corners": [[0.1, 0], ["0.02 + omega/1000", 0.1], [-0.1, 0.05], [0, "-0.1 - omega^2/2000"]]},
    {"real": {"higher": "0.08 + omega/99", "lower": "0.12 + omega^2/400"}, "imag": "0.08 + 0.004*omega"},
]


@pytest.mark.parametrize("jnd", MOVING, ids=lambda x: x.get("shape", "sides"))
def test_no_border_moves_farther_in_a_cell_than_is_said(jnd: dict[str, Any]) -> None:
    """The distance of random changes, of both parts and of each, at places all over random cells and in their middles."""
    c, draw = read_threshold(jnd), np.random.default_rng(5)
    low = draw.uniform(0.1, 14, 400)
    high = low * (1 + 10 ** draw.uniform(-9, -0.7, 400))
    middle, x, y = (low + high) / 2, *(10 ** draw.uniform(-3, 1, 400) * draw.choice([-1, 1], 400) for _ in range(2))
    env, size = draw.uniform(-1, 1, 400), (np.ones(400), np.ones(400))
    most = spread(c, low, high, np.ones(400)) + 1e-13 * (1 + np.abs(x) + np.abs(y))
    for share in (0, 0.1, 0.4, 0.8, 1):
        at = low + share * (high - low)
        for part in Part:
            here, there = (part_distance(c, part, w, x, env, size) for w in (middle, at))
            assert (np.abs(here - there) <= most).all()
        both = [joint_distance(c, w, x, y) for w in (middle, at)]
        if both[0] is not None:
            assert (np.abs(both[0] - both[1]) <= most).all()
    assert (most[high - low < 1e-6 * low] < 1e-4).all()


@pytest.mark.parametrize("relative", [False, True])
def test_grown_discs_are_no_smaller_than_the_bound_says(relative: bool) -> None:  # noqa: FBT001
    chance = random.Random(12)
    for _ in range(500):
        size, radius, apart = (10 ** chance.uniform(-8, 8) for _ in range(3))
        bound = 10 ** chance.uniform(-8, 8) if not relative else 10 ** chance.uniform(-12, 2.5) / apart
        found = MP.mpf(
            float(SlopeBound(bound, relative, "").grown(np.float64(size), np.float64(radius), np.float64(apart)))
        )
        size, radius, way = MP.mpf(size), MP.mpf(radius), MP.mpf(bound) * MP.mpf(apart)
        assert found >= radius + (size + radius) * MP.expm1(way) if relative else found >= radius + way
