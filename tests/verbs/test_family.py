"""One display and several environments: what holds for all, and which one binds, by plain complex arithmetic."""

from __future__ import annotations

import json
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from schemas import faults
from scipy.optimize import brentq
from sympy import Rational, lambdify

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.budget import forget, in_time, timed_by
from haptisym.verbs.family.entry import WorstCase

LAG, FLOATING = effects.first_order_lag(40), effects.shunt(m="0.05")
ROWS: dict[str, dict[str, Any]] = {
    "first from the low end": {"environments": {"soft": (100, 2), "hard": (900, 1)}, "effects": (LAG, FLOATING), "jnd": 0.1},
    "not from the low end": {"environments": {"a": (100, 4), "b": (90, 9)}, "effects": (effects.shunt(k=15),), "jnd": 0.1},
    "a region": {
        "environments": {"soft": (100, 2), "hard": (900, 1), "thick": (50, 6)}, "effects": (LAG, FLOATING),
        "jnd": {"shape": "ellipse", "real": 0.2, "imag": 0.1},
    },
    "twins": {"environments": {"a": (100, 2), "twin": (200, 4)}, "effects": (effects.second_order_lowpass(30, 1),), "jnd": {"real": 0.2, "imag": 0.3}},
    "twins behind a delay": {"environments": {"a": (100, 2), "twin": (200, 4)}, "effects": (effects.delay("20 ms"),), "jnd": 0.1},
    "the whole band": {"environments": {"a": (100, 2), "b": (200, 5)}, "effects": (effects.first_order_lag(4000),), "jnd": 0.1},
    "distorted from 0 on": {"environments": {"soft": (30, 1), "hard": (900, 1)}, "effects": (effects.compliance(k=900),), "jnd": 0.1},
    "an end for each": {"environments": {"damper": (1, 20), "spring": (100, 1)}, "effects": (effects.shunt(k=5, m=Rational(1, 10)),), "jnd": 0.1},
}  # fmt: skip


@cache
def family(name: str) -> hs.SceneFamily:
    row = ROWS[name]
    made = {
        key: hs.Scene(environments.kelvin_voigt(k, b), row["effects"], (0, 60), row["jnd"])
        for key, (k, b) in row["environments"].items()
    }
    return hs.SceneFamily(made, name)


@cache
def found(name: str) -> hs.FamilyEvaluation:
    return hs.evaluate_all(family(name), digits=20, regions=name == "a region")


@cache
def matrices(name: str) -> list[list[Any]]:
    return [[lambdify(hs.s, x, "numpy") for x in effect.matrix] for effect in ROWS[name]["effects"]]


def excess(name: str, key: str, w: Any) -> dict[str, Any]:
    """Of each judgement by how much it is exceeded, relative to its limit."""
    k, b = ROWS[name]["environments"][key]
    s = 1j * np.asarray(w, dtype=float)
    H = k + b * s
    felt = H
    for matrix in matrices(name):
        A, B, C, D = (entry(s) for entry in matrix)
        felt = (A * felt + B) / (C * felt + D)
    change, c = (felt - H) / np.abs(H), family(name).threshold
    real, imag = np.abs(change.real) / float(c.real), np.abs(change.imag) / float(c.imag)
    return {"joint": np.hypot(real, imag) - 1} if name == "a region" else {"real": real - 1, "imag": imag - 1}


def exceeding(name: str, w: float) -> set[tuple[str, str]]:
    return {(key, part) for key in ROWS[name]["environments"] for part, x in excess(name, key, w).items() if x > 0}


@pytest.mark.dear("a region", "first from the low end", "twins behind a delay")
@pytest.mark.parametrize("name", ROWS)
def test_the_common_set_ends_where_the_first_environment_exceeds_and_that_one_is_named(name: str) -> None:
    e = found(name)
    ends = [float(end.omega) for x in e.transparent for end in (x.low, x.high)]
    grid = np.linspace(0.01, 59.99, 700)
    over = np.any([x > 0 for key in ROWS[name]["environments"] for x in excess(name, key, grid).values()], axis=0)
    for w, is_over in zip(grid.tolist(), over.tolist(), strict=True):
        if np.abs(np.subtract(w, ends)).min(initial=9) > 1e-3:
            assert is_over != any(float(x.low.omega) <= w <= float(x.high.omega) for x in e.transparent)
    starts = bool(e.transparent) and float(e.transparent[0].low.omega) == 0
    width = float(e.transparent[0].high.omega) if starts else None
    assert (None if e.bandwidth is None else float(e.bandwidth)) == width
    expected = [] if starts else [(0.0, *x) for x in sorted(exceeding(name, 1e-9))]
    for x in e.transparent:
        low, high = float(x.low.omega), float(x.high.omega)
        expected += [] if low == 0 else [(low, *y) for y in sorted(exceeding(name, low * (1 - 1e-7)))]
        expected += [] if high == 60 else [(high, *y) for y in sorted(exceeding(name, high * (1 + 1e-7)))]
    told = [(float(x.omega), x.environment, x.criterion.name) for x in e.binding]
    assert sorted(told) == sorted(dict.fromkeys(expected))
    assert [x[0] for x in told] == sorted(x[0] for x in told)
    assert e.certified
    assert bool(expected) or width == 60


@pytest.mark.dear("a region")
@pytest.mark.parametrize("name", ROWS)
def test_the_document_of_a_family_is_its_answer(name: str) -> None:
    e = found(name)
    told = e.to_dict()
    assert (told["band"], told["threshold"]) == ([0, 60], family(name).threshold.row())
    assert [x["name"] for x in told["environments"]] == list(ROWS[name]["environments"])
    for x, scene in zip(told["environments"], family(name).scenes.values(), strict=True):
        own = hs.evaluate(scene, digits=20, regions=name == "a region").to_dict()
        assert {key: x[key] for key in own if key != "title"} == {key: y for key, y in own.items() if key != "title"}
    assert told["transparent"] == [[float(x.low.omega), float(x.high.omega)] for x in e.transparent]
    assert told["bandwidth"] == (None if e.bandwidth is None else float(e.bandwidth))
    assert [(x["at"], x["digits"], x["environment"], x["part"]) for x in told["binding"]] == [
        (float(x.omega), x.omega.digits(20), x.environment, x.criterion.name) for x in e.binding
    ]
    assert ("regions" in told) == (name == "a region")
    assert ("none common to all environments" in " ".join(str(e).split())) is (e.bandwidth is None)


def test_whose_ratio_is_the_threshold_itself_never_binds() -> None:
    """20/100 is 0.2 everywhere; 20/|200 - w^2| is more from 10 to the root of 300, ends not counted."""
    felt = {"even": environments.mass_spring_damper(k=100), "heavy": environments.mass_spring_damper(m=1, k=200)}
    for band, ends in (((0, 20), [10, 300**0.5]), ((12, 15), [12]), ((0, 9), []), ((12, 20), [12, 300**0.5])):
        made = {name: hs.Scene(x, (effects.shunt(k=20),), band, "0.2") for name, x in felt.items()}
        e = hs.evaluate_all(hs.SceneFamily(made, "at the threshold"))
        assert [float(x.omega) for x in e.binding] == pytest.approx(ends)
        assert {x.environment for x in e.binding} <= {"heavy"}


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(20, 900), st.integers(1, 40)), min_size=2, max_size=4))
def test_the_common_bandwidth_is_the_smallest_of_all(rows: list[tuple[int, int]]) -> None:
    display = (effects.second_order_lowpass(60, Rational(1, 2)), effects.shunt(m=Rational(1, 20)))
    scenes = {
        f"{i}": hs.Scene(environments.mass_spring_damper(Rational(9, 5), b, k), display)
        for i, (k, b) in enumerate(rows)
    }
    e = hs.evaluate_all(hs.SceneFamily(scenes))
    own = {name: hs.evaluate(scene).bandwidth for name, scene in scenes.items()}
    assert e.bandwidth is not None
    assert float(e.bandwidth) == min(float(x) for x in own.values() if x is not None)
    for x in e.binding[:1]:
        assert float(own[x.environment]) == float(e.bandwidth)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_fractional_and_a_rational_tissue_share_one_chart() -> None:
    e = hs.evaluate_all(hs.load_scenes("organ-tissue", ["organ-tissue", "zener-tissue"]))
    own = {name: hs.evaluate(e.family[name]) for name in e.family}
    assert float(e.bandwidth) == min(float(x.bandwidth) for x in own.values())  # type: ignore[arg-type]
    assert e.certified


# --- the shipped family ----------------------------------------------------------------------------------------------

TISSUES = {"fat": (120, "1.5"), "muscle": (290, "2"), "tumour": (900, "4")}


def palpated(name: str, omega: Any, mp: Any) -> tuple[Any, Any]:
    """r_r and r_i of a shipped tissue, from the physics: an amplifier's lag, then the device's mass and damping."""
    s = mp.mpc(0, omega)
    if name == "liver":
        H = 180 + mp.mpf(250) * 8 * s / (250 + 8 * s)
    else:
        k, b = TISSUES[name]
        H = k + mp.mpf(b) * s
    cut = 200 * mp.pi
    dH = H * cut / (s + cut) + mp.mpf("0.045") * s**2 + mp.mpf("0.3") * s - H
    return abs(dH.real) / abs(H), abs(dH.imag) / abs(H)


@cache
def palpation(*, regions: bool = False) -> hs.FamilyEvaluation:
    return hs.evaluate_all(hs.load_scenes("palpation-device"), digits=40, regions=regions)


def test_the_binding_environment_is_the_one_that_the_physics_says_to_forty_digits() -> None:
    mp, e = mpmath.mp.clone(), palpation()
    mp.dps = 60
    [bound] = e.binding
    low, high = (mp.mpf(x) for x in bound.omega.enclosure(40))
    assert high - low < mp.mpf("1e-38")
    assert (bound.environment, bound.part) == ("fat", hs.Part.REAL)
    assert palpated("fat", low, mp)[0] < mp.mpf("0.1") < palpated("fat", high, mp)[0]
    assert all(max(palpated(name, high, mp)) < mp.mpf("0.1") for name in e.family if name != "fat")


def test_the_common_transparent_set_is_the_intersection_seen_on_a_grid() -> None:
    e = palpation()
    for omega in np.linspace(0.05, 57.7, 400):
        ratios = [palpated(name, omega, mpmath.fp) for name in e.family]
        expected = all(real <= 0.1 and imag <= 0.15 for real, imag in ratios)
        assert expected == any(float(x.low.omega) <= omega <= float(x.high.omega) for x in e.transparent)


@pytest.mark.slow
def test_every_region_has_the_common_bandwidth_that_plain_arithmetic_gives(call: Any, tmp_path: Path) -> None:
    """How many times disc and diamond of 10 % (real) and 15 % (imaginary) must be enlarged, in floats."""
    e = palpation(regions=True)
    grid = np.linspace(0.01, 57.7, 4000)
    ratios = {name: np.array([palpated(name, w, mpmath.fp) for w in grid]) / (0.1, 0.15) for name in e.family}
    for x, order in zip(e.regions[1:3], (2, 1), strict=True):
        sizes = {name: np.linalg.norm(row, order, axis=1) for name, row in ratios.items()}
        first = {name: grid[size > 1][0] for name, size in sizes.items() if (size > 1).any()}
        assert float(x.bandwidth) == pytest.approx(min(first.values()), abs=grid[1] - grid[0])  # type: ignore[arg-type]
        assert [y.environment for y in x.first] == [min(first, key=lambda name, own=first: own[name])]
        for name, own in first.items():
            assert float(x.answers[name].bandwidth) == pytest.approx(own, abs=grid[1] - grid[0])  # type: ignore[arg-type]
    assert "all together 16.90 16.86 16.07 " in " ".join(str(e).split())
    status, out, _ = call("evaluate", "palpation-device", "--regions", "--figures", str(tmp_path))
    assert (status, "The common bandwidth is from 16.06 to 16.91 rad/s" in out) == (0, True)
    assert {x.name for x in tmp_path.iterdir()} >= {"regions.svg", "worst-case.svg"}


def test_each_region_has_the_common_bandwidth_of_all_and_who_binds_first() -> None:
    e = found("a region")
    assert [x.name for x in e.regions] == ["square", "disc", "diamond", "the scene's own"]
    for x, row in zip(e.regions, e.to_dict()["regions"], strict=True):
        alone = WorstCase.of(e.family, x.threshold)
        assert x.bandwidth is not None
        assert (float(x.bandwidth), row["region"], row["bandwidth"]) == (
            float(alone.bandwidth),
            x.name,
            float(x.bandwidth),
        )  # type: ignore[arg-type]
        assert row["threshold"] == x.threshold.row()
        first = [(y.environment, y.criterion.name, y.omega.digits(20)) for y in alone.binding if float(y.omega) == float(x.bandwidth)]  # fmt: skip
        assert [(y.environment, y.criterion.name, y.omega.digits(20)) for y in x.first] == first
        assert [(y["environment"], y["part"], y["digits"]) for y in row["binding"]] == first
        for who, own in x.answers.items():
            [same] = [y for y in e.answers[who].regions if y.name == x.name]
            assert own is same
    assert e.regions[-1].bandwidth is e.bandwidth
    assert not found("twins").regions


def test_a_proportion_converts_the_threshold_of_all_environments() -> None:
    """10 % at 75 % right is 14.74 % at 84 %: what a scene with that number says."""
    told = {"real": 0.1, "imag": 0.1, "proportion": 0.75}
    scenes = {
        name: hs.Scene(environments.kelvin_voigt(k, b), (effects.first_order_lag(20),), (0, 15), told)
        for name, k, b in (("soft", 100, 2), ("hard", 1000, 3))
    }
    e = hs.evaluate_all(hs.SceneFamily(scenes), proportion=0.84)
    own = [hs.evaluate(scene, proportion=0.84).bandwidth.digits(20) for scene in scenes.values()]  # type: ignore[union-attr]
    assert e.to_dict()["threshold"]["conversion"]["factor"].startswith("1.47438546385716")
    assert e.bandwidth.digits(20) == min(own, key=float)  # type: ignore[union-attr]
    with pytest.raises(hs.SceneError, match="has none of its own"):
        hs.evaluate_all(hs.load_scenes("palpation-device"), proportion=0.84)


# --- files, and what is refused --------------------------------------------------------------------------------------

SOFT = '[[environments]]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'


def test_environments_of_a_file_are_numbered_and_have_their_own_rendering() -> None:
    assert list(hs.parse_scenes(SOFT * 2)) == ["kelvin-voigt", "kelvin-voigt-2"]
    read = hs.parse_scenes(
        f'{SOFT}name = "a"\nrendered = {{ model = "kelvin-voigt", k = 90, b = 2 }}\n{SOFT}name = "b"'
    )
    assert read["a"].distortion().distortion == -10
    assert read["b"].rendered is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("environments = 3", ["environments", "[[environments]]"]),
        ("environments = []", ["environments", "[[environments]]"]),
        ("environments = [3]", ["environments[1]", "3", "table"]),
        ('[[environments]]\nmodel="maxwell"\nk=1\nb=1\n[environment]\nmodel="maxwell"', ["environment", "either"]),
        ('[[environments]]\nmodel="maxwell"\nk=1\nb=1\n[rendered]\nmodel="maxwell"', ["rendered", "either"]),
        ('[[environments]]\nname=3\nmodel="maxwell"\nk=1\nb=1', ["environments[1]", "name", "3"]),
        ('[[environments]]\nname="liver"\nmodel="maxwel"\nk=1\nb=1', ["liver", "maxwel", "maxwell"]),
        ('[[environments]]\nname="liver"\nmodel="maxwell"\nk=-1\nb=1', ["liver", "k", "-1"]),
        ('[[environments]]\nname="liver"\nk=1\nb=1', ["liver", "model", "missing"]),
    ],
)
def test_a_wrong_family_is_an_error_that_names_the_place(text: str, words: list[str]) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scenes(text, "my.toml")
    assert all(word in str(error.value) for word in ["my.toml", *words])


def test_one_scene_is_one_environment_and_scenes_of_different_displays_are_no_family() -> None:
    assert list(hs.evaluate_all(family("twins").scenes["a"]).answers) == ["environment"]
    assert hs.load_scene("palpation-device", "liver").environment.model == "zener"
    for wrong, words in (
        (lambda: hs.load_scene("palpation-device"), r"4 environments .*liver.*--environment NAME.*load_scenes"),
        (lambda: hs.load_scene("palpation-device", "kidney"), 'unknown environment "kidney".*"liver"'),
        (lambda: hs.evaluate_all(hs.Scene(environments.kelvin_voigt(hs.symbols("k"), 1))), "symbol"),
        (
            lambda: hs.SceneFamily({"paper": hs.load_scene("fu2019"), "sidestick": hs.load_scene("sidestick")}),
            '"sidestick" has other effects',
        ),
    ):
        with pytest.raises(hs.SceneError, match=words):
            wrong()


# --- the command -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_document_and_the_page_hold_each_evaluation_and_the_worst_case(call: Any) -> None:
    status, out, err = call("evaluate", "palpation-device", "--json")
    document = json.loads(out)
    assert (status, err, document["schema"]) == (0, "", "haptisym.evaluations/1")
    for row in document["environments"]:
        alone = hs.evaluate(hs.load_scene("palpation-device", row["name"])).to_dict()
        assert row == {"name": row["name"], **alone, "title": "Palpation device (Touch) on four tissues (illustrative)"}
    [bound] = document["binding"]
    assert (bound["at"], bound["environment"], bound["part"]) == (document["bandwidth"], "fat", "real")
    assert document["transparent"] == [[0.0, document["bandwidth"]]]
    _, out, _ = call("evaluate", "palpation-device")
    for words in (*TISSUES, "liver", "common to all environments, limited by fat"):
        assert words in " ".join(out.split())


@pytest.mark.slow
def test_environments_come_from_other_files_and_one_of_several_is_evaluated_as_ever(call: Any, tmp_path: Path) -> None:
    own = tmp_path / "wall.toml"
    own.write_text('[environment]\nmodel = "kelvin-voigt"\nk = "2 kN/m"\nb = 3\n', encoding="utf-8")
    words = ("evaluate", "fu2019", "--environments", str(own), "helicopter-cyclic", "palpation-device", "--json")
    status, out, _ = call(*words)
    names = [row["name"] for row in json.loads(out)["environments"]]
    assert (status, names) == (0, ["wall", "helicopter-cyclic", *hs.load_scenes("palpation-device")])
    _, out, _ = call("evaluate", "palpation-device", "--environment", "muscle")
    assert out == str(hs.evaluate(hs.load_scene("palpation-device", "muscle")))
    status, out, _ = call("derive", "palpation-device", "--environment", "muscle", "--of", "H_env")
    assert (status, "b s + k" in out) == (0, True)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("derive", "palpation-device"), ["4 environments", "--environment"]),
        (("simulate", "palpation-device"), ["4 environments", "--environment"]),
        (("evaluate", "palpation-device", "--environment", "bone"), ["bone", "muscle"]),
        (("evaluate", "palpation-device", "--proportion", "0.84"), ["proportion", "has none of its own"]),
        (("evaluate", "fu2019", "sidestick"), ["sidestick"]),
        (("evaluate", "fu2019", "--environments", "nowhere"), ["nowhere"]),
        (("evaluate", "desktop-device-soft-tissue", "--environments", "sidestick"), ["sidestick", "rotation"]),
    ],
)
def test_what_cannot_be_done_is_said(call: Any, arguments: tuple[str, ...], words: list[str]) -> None:
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert all(word in err for word in words)
    assert "Traceback" not in err


@pytest.mark.slow
def test_the_shipped_families_are_listed_beside_the_scenes(call: Any) -> None:
    rows = {row["name"]: row["environments"] for row in json.loads(call("scenes", "--json")[1])["scenes"]}
    assert (rows["palpation-device"], rows["fu2019"]) == (4, 1)
    assert not set(hs.family_names()) & set(hs.scene_names())


# Other questions about each environment


LAGGING = """
[[environments]]
name = "soft"
model = "kelvin-voigt"
k = 100
b = 4
[[environments]]
name = "hard"
model = "kelvin-voigt"
k = 900
b = 1
[[effects]]
model = "first-order-lag"
omega_c = "200 rad/s"
[evaluation]
band = [0, 20]
"""


def test_values_that_do_for_all_environments_are_those_of_the_hardest_one(tmp_path: Path, call: Any) -> None:
    """The ratios of a lag are |Re (G - 1) H|/|H| and |Im (G - 1) H|/|H|, here on a fine grid of the band."""
    path = tmp_path / "two.toml"
    path.write_text(LAGGING)
    w = np.linspace(0, 20, 4001)

    def most(cutoff: float, k: float, b: float) -> float:
        H = k + 1j * b * w
        off = (cutoff / (1j * w + cutoff) - 1) * H
        return float(max(np.abs(off.real / np.abs(H)).max(), np.abs(off.imag / np.abs(H)).max()) - 0.1)

    least = {name: brentq(most, 20, 1000, (k, b)) for name, k, b in (("soft", 100, 4), ("hard", 900, 1))}
    status, out, _ = call("require", str(path), "--free", "omega_c", "--json")
    found = json.loads(out)
    assert status == 0
    [[low, high]] = found["common"]["feasible"]
    assert (low, high) == (pytest.approx(max(least.values()), rel=1e-6), None)
    hardest = max(least, key=lambda x: least[x])
    assert {x["environment"] for x in found["common"]["binding"]} == {hardest}
    assert [x["feasible"][0][0] for x in found["environments"]] == pytest.approx(
        [least["soft"], least["hard"]], rel=1e-6
    )
    in_python = hs.answer_each(path, lambda scene: hs.require(scene, "omega_c"))
    assert in_python.to_dict() == found
    assert f"Limited by            {hardest} (imag)" in str(in_python)


def test_an_environment_that_stays_undecided_leaves_the_answers_of_the_others(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(LAGGING)
    family = hs.load_scenes(path)

    def asked(scene: hs.Scene) -> Any:
        if scene is family["hard"]:
            raise hs.UndecidedError("stopped at the limit of 3 s")
        return hs.require(scene, "omega_c")

    found = hs.answer_each(family, asked)
    assert (list(found.answers), found.left) == (["soft"], {"hard": "stopped at the limit of 3 s"})
    assert (found.certified, found.settled, found.common) == (False, False, None)
    assert faults(found.to_dict()) == []
    assert "Undecided: hard: stopped at the limit of 3 s." in str(found)
    with pytest.raises(hs.UndecidedError, match="3 s"):
        hs.answer_each(family["hard"], lambda _: asked(family["hard"]))


@pytest.mark.slow
def test_where_what_is_common_is_not_decided_in_time_each_environment_has_its_answer(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(LAGGING)
    whole, seen = hs.evaluate_all(path), set[tuple[int, bool]]()
    for ticks in range(50, 1000, 50):
        forget()
        with timed_by(count().__next__):
            found = in_time(lambda n=ticks: hs.evaluate_all(path, limit=n), "", {})  # type: ignore[misc]
        if found is None:
            continue
        seen.add((len(found.answers), found.settled))
        assert faults(found.to_dict()) == []
        for name, one in found.answers.items():
            assert [float(x.omega) for x in one.crossings] == [float(x.omega) for x in whole.answers[name].crossings]
        if not found.settled:
            assert "stopped at the limit of" in str(found)
    assert seen >= {(2, False), (2, True)}


@pytest.mark.few("words1", "words3")
@pytest.mark.parametrize(
    "words",
    [("stability", "--hand", "light-touch"), ("sensitivity",), ("metrics",), ("tolerances", "--samples", "0"), ("require", "--free", "environment.k")],
)  # fmt: skip
def test_each_environment_is_asked_about_by_itself(tmp_path: Path, call: Any, words: tuple[str, ...]) -> None:
    path = tmp_path / "two.toml"
    path.write_text(LAGGING.replace('"200 rad/s"', '"200 rad/s +- 5 %"' if words[0] == "tolerances" else '"200 rad/s"'))
    status, out, err = call(words[0], str(path), *words[1:], "--json")
    assert status == 0, err
    found = json.loads(out)
    assert found["schema"] == "haptisym.answers/1"
    for row in found["environments"]:
        _, alone, _ = call(words[0], str(path), *words[1:], "--environment", row["name"], "--json")
        assert {**json.loads(alone), "title": ""} == {**{k: x for k, x in row.items() if k != "name"}, "title": ""}


def test_each_environment_is_drawn_by_itself(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(LAGGING)
    many = hs.answer_each(path, lambda scene: hs.evaluate(scene))
    assert [ax.get_title() for ax in many.figure().axes] == [*many.answers]
    with pytest.raises(hs.SceneError, match="plot one of"):
        many.plot()
