"""One display and several environments: what holds for all, and which one binds."""

from __future__ import annotations

import json
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments

TISSUES = {"fat": (120, "1.5"), "muscle": (290, "2"), "tumour": (900, "4")}


def palpated(name: str, omega: mpmath.mpf, mp: mpmath.ctx_mp.MPContext) -> tuple[mpmath.mpf, mpmath.mpf]:
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


def test_the_binding_environment_is_the_one_that_the_physics_says_to_forty_digits() -> None:
    mp = mpmath.mp.clone()
    mp.dps = 60
    found = hs.evaluate_all(hs.load_scenes("palpation-device"), digits=40)
    [bound] = found.binding
    low, high = (mp.mpf(x) for x in bound.omega.enclosure(40))
    assert high - low < mp.mpf("1e-38")
    assert (bound.environment, bound.part) == ("fat", hs.Part.REAL)
    assert palpated("fat", low, mp)[0] < mp.mpf("0.1") < palpated("fat", high, mp)[0]
    for name in found.family:
        if name != "fat":
            assert max(palpated(name, high, mp)) < mp.mpf("0.1")


def test_the_common_transparent_set_is_the_intersection_seen_on_a_grid() -> None:
    mp = mpmath.fp
    found = hs.evaluate_all(hs.load_scenes("palpation-device"))
    for omega in np.linspace(0.05, 57.7, 400):
        ratios = [palpated(name, omega, mp) for name in found.family]
        expected = all(real <= 0.1 and imag <= 0.15 for real, imag in ratios)
        assert expected == any(float(x.low.omega) <= omega <= float(x.high.omega) for x in found.transparent)


@pytest.mark.slow
@given(st.lists(st.tuples(st.integers(20, 900), st.integers(1, 40)), min_size=2, max_size=4))
def test_the_common_bandwidth_is_the_smallest_of_all(rows: list[tuple[int, int]]) -> None:
    display = (effects.second_order_lowpass(60, Rational(1, 2)), effects.shunt(m=Rational(1, 20)))
    scenes = {
        f"{i}": hs.Scene(environments.mass_spring_damper(Rational(9, 5), b, k), display)
        for i, (k, b) in enumerate(rows)
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes))
    own = {name: hs.evaluate(scene).bandwidth for name, scene in scenes.items()}
    assert found.bandwidth is not None
    assert float(found.bandwidth) == min(float(x) for x in own.values() if x is not None)
    for x in found.binding[:1]:
        assert float(own[x.environment]) == float(found.bandwidth)  # type: ignore[arg-type]


def test_environments_of_the_same_phase_bind_together_behind_a_filter() -> None:
    """Behind a series effect only the phase of an environment counts: ten times as much of everything changes nothing."""
    lag = (effects.first_order_lag(20),)
    scenes = {
        name: hs.Scene(environments.kelvin_voigt(k, Rational(k, 50)), lag)
        for name, k in (("soft", 100), ("hard", 1000))
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes))
    assert [(x.environment, x.part) for x in found.binding] == [("soft", hs.Part.IMAG), ("hard", hs.Part.IMAG)]
    assert found.binding[0].omega == found.binding[1].omega


def test_they_bind_together_behind_a_delay_as_well() -> None:
    delay = (effects.delay("20 ms"),)
    twins = {
        name: hs.Scene(environments.kelvin_voigt(k, Rational(k, 50)), delay) for name, k in (("a", 100), ("twin", 200))
    }
    found = hs.evaluate_all(hs.SceneFamily(twins))
    assert {x.environment for x in found.binding} == {"a", "twin"}


def test_a_fractional_and_a_rational_tissue_share_one_chart() -> None:
    found = hs.evaluate_all(hs.load_scenes("organ-tissue", ["organ-tissue", "zener-tissue"]))
    own = {name: hs.evaluate(found.family[name]) for name in found.family}
    assert float(found.bandwidth) == min(float(x.bandwidth) for x in own.values())  # type: ignore[arg-type]
    assert found.certified


def test_where_even_the_low_end_is_distorted_the_culprit_is_named() -> None:
    scenes = {
        name: hs.Scene(environments.kelvin_voigt(k, 1), (effects.compliance(k=900),))
        for name, k in (("soft", 30), ("hard", 900))
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes))
    assert found.transparent == ()
    assert found.bandwidth is None
    assert [(float(x.omega), x.environment) for x in found.binding] == [(0.0, "hard")]
    assert "Nowhere on the band" in str(found)


def test_both_ends_of_a_common_band_have_their_own_environment() -> None:
    """A shunt spring hides before a stiff environment at every frequency, before a damper only at high ones."""
    shunt = (effects.shunt(k=5, m=Rational(1, 10)),)
    scenes = {
        "damper": hs.Scene(environments.kelvin_voigt(1, 20), shunt, (0, 40)),
        "spring": hs.Scene(environments.kelvin_voigt(100, 1), shunt, (0, 40)),
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes))
    ends = [(x.environment, x.part) for x in found.binding if float(x.omega) > 0]
    assert ends == [("damper", hs.Part.REAL), ("spring", hs.Part.REAL)]
    # |5| = 0.1 |1 + 20 j w| at w = sqrt(2500 - 1)/20, as far as the mass is nothing beside it: bracketed
    low = float(found.transparent[0].low.omega)
    assert abs(5 - 0.1 * low**2) == pytest.approx(0.1 * np.hypot(1, 20 * low), rel=1e-12)


def test_a_scene_file_with_environments_that_share_a_name_numbers_them() -> None:
    one = '[[environments]]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'
    assert list(hs.parse_scenes(one * 2)) == ["kelvin-voigt", "kelvin-voigt-2"]


def test_what_is_rendered_belongs_to_its_environment() -> None:
    text = (
        '[[environments]]\nname = "a"\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'
        'rendered = { model = "kelvin-voigt", k = 90, b = 2 }\n'
        '[[environments]]\nname = "b"\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'
    )
    family = hs.parse_scenes(text)
    assert family["a"].distortion().distortion == -10
    assert family["b"].rendered is None


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
    for word in ["my.toml", *words]:
        assert word in str(error.value)


def test_one_scene_is_not_made_of_several_environments_without_a_choice() -> None:
    with pytest.raises(hs.SceneError, match=r"4 environments .*liver.*--environment NAME.*load_scenes"):
        hs.load_scene("palpation-device")
    assert hs.load_scene("palpation-device", "liver").environment.model == "zener"
    with pytest.raises(hs.SceneError, match='no environment "kidney".*"liver"'):
        hs.load_scene("palpation-device", "kidney")


def test_scenes_of_different_displays_are_no_family() -> None:
    with pytest.raises(hs.SceneError, match='"sidestick" has other effects'):
        hs.SceneFamily({"paper": hs.load_scene("fu2019"), "sidestick": hs.load_scene("sidestick")})


def test_the_document_holds_each_evaluation_and_the_worst_case(call) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call("evaluate", "palpation-device", "--json")
    document = json.loads(out)
    assert (status, err, document["schema"]) == (0, "", "haptisym.evaluations/1")
    for row in document["environments"]:
        alone = hs.evaluate(hs.load_scene("palpation-device", row["name"])).to_dict()
        assert row == {"name": row["name"], **alone, "title": "Palpation device (Touch) on four tissues"}
    [bound] = document["binding"]
    assert (bound["at"], bound["environment"], bound["part"]) == (document["bandwidth"], "fat", "real")
    assert document["transparent"] == [[0.0, document["bandwidth"]]]
    assert document["certified"]


def test_environments_come_from_other_files(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    own = tmp_path / "wall.toml"
    own.write_text('[environment]\nmodel = "kelvin-voigt"\nk = "2 kN/m"\nb = 3\n', encoding="utf-8")
    status, out, _ = call(
        "evaluate", "fu2019", "--environments", str(own), "helicopter-cyclic", "palpation-device", "--json"
    )
    document = json.loads(out)
    assert status == 0
    assert [row["name"] for row in document["environments"]] == [
        "wall",
        "helicopter-cyclic",
        *hs.load_scenes("palpation-device"),
    ]
    assert document["title"] == hs.load_scene("fu2019").title


def test_one_environment_of_several_is_evaluated_as_ever(call) -> None:  # type: ignore[no-untyped-def]
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
        (("evaluate", "fu2019", "sidestick"), ["sidestick"]),
        (("evaluate", "fu2019", "--environments", "nowhere"), ["nowhere"]),
        (("evaluate", "desktop-device-soft-tissue", "--environments", "sidestick"), ["sidestick", "rotation"]),
    ],
)
def test_what_cannot_be_done_is_said(call, arguments: tuple[str, ...], words: list[str]) -> None:  # type: ignore[no-untyped-def]
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    for word in words:
        assert word in err
    assert "Traceback" not in err


def test_the_page_has_a_row_for_each_and_the_worst_case(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("evaluate", "palpation-device")
    for words in ("fat", "muscle", "liver", "tumour", "the common bandwidth", "fat (real part, r_r) binds"):
        assert words in out
    assert max(map(len, out.splitlines())) <= 96


@pytest.mark.slow
def test_the_figure_marks_who_binds(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    status, _, _ = call("evaluate", "palpation-device", "--figures", str(tmp_path))
    assert status == 0
    assert sorted(x.name for x in tmp_path.iterdir()) == ["worst-case.pdf", "worst-case.png", "worst-case.svg"]
    from haptisym.figures.family import family_figure

    figure = family_figure(hs.evaluate_all(hs.load_scenes("palpation-device")))
    upper, lower = figure.axes
    [legend] = [x.get_legend() for x in figure.axes if x.get_legend()]
    assert "fat binds" in [text.get_text() for text in legend.get_texts()]
    dots = [line for line in upper.lines if line.get_marker() == "o"]
    assert [float(line.get_xdata()[0]) for line in dots] == [pytest.approx(16.905, abs=1e-3)]
    assert not [line for line in lower.lines if line.get_marker() == "o"]


def test_the_shipped_families_are_listed_beside_the_scenes(call) -> None:  # type: ignore[no-untyped-def]
    _, out, _ = call("scenes", "--json")
    rows = {row["name"]: row["environments"] for row in json.loads(out)["scenes"]}
    assert rows["palpation-device"] == 4
    assert rows["fu2019"] == 1
    assert not set(hs.family_names()) & set(hs.scene_names())


# --- other JND models ------------------------------------------------------------------------------------------------


def pressed(name: str, omega: float) -> tuple[float, float]:
    """How many times disc and diamond of 10 % (real) and 15 % (imaginary) must be enlarged, in floats."""
    real, imag = palpated(name, omega, mpmath.fp)
    return float(np.hypot(real / 0.1, imag / 0.15)), float(real / 0.1 + imag / 0.15)


@pytest.mark.slow
def test_every_region_has_the_common_bandwidth_that_plain_arithmetic_gives() -> None:
    found = hs.evaluate_all(hs.load_scenes("palpation-device"), regions=True)
    assert [x.name for x in found.regions] == ["square", "disc", "diamond", "the scene's own"]
    grid = np.linspace(0.01, 57.7, 4000)
    for which, x in enumerate(found.regions[1:3]):
        sizes = {name: np.array([pressed(name, w)[which] for w in grid]) for name in found.family}
        first = {name: grid[size > 1][0] for name, size in sizes.items() if (size > 1).any()}
        assert float(x.bandwidth) == pytest.approx(min(first.values()), abs=grid[1] - grid[0])  # type: ignore[arg-type]
        assert [y.environment for y in x.first] == [min(first, key=lambda name: first[name])]
        for name, own in first.items():
            assert float(x.answers[name].bandwidth) == pytest.approx(own, abs=grid[1] - grid[0])  # type: ignore[arg-type]
    assert found.regions[3].bandwidth is found.bandwidth
    rows = found.to_dict()["regions"]
    assert [x["binding"][0]["part"] for x in rows] == ["real", "joint", "joint", "real"]
    assert all(row["regions"] == hs.evaluate(scene, regions=True).to_dict()["regions"]
               for row, scene in zip(found.to_dict()["environments"], found.family.scenes.values(), strict=True))  # fmt: skip
    assert "all           16.905   16.862   16.068    16.905" in str(found)


def test_a_proportion_converts_the_threshold_of_all_environments() -> None:
    """10 % at 75 % right is 14.74 % at 84 %: what a scene with that number says."""
    told = {"real": 0.1, "imag": 0.1, "proportion": 0.75}
    lag = (effects.first_order_lag(20),)
    scenes = {
        name: hs.Scene(environments.kelvin_voigt(k, b), lag, (0, 15), told)
        for name, k, b in (("soft", 100, 2), ("hard", 1000, 3))
    }
    found = hs.evaluate_all(hs.SceneFamily(scenes), proportion=0.84)
    own = {name: hs.evaluate(scene, proportion=0.84) for name, scene in scenes.items()}
    assert found.to_dict()["threshold"]["conversion"]["factor"].startswith("1.47438546385716")
    assert found.bandwidth.digits(20) == min((x.bandwidth.digits(20) for x in own.values()), key=float)  # type: ignore[union-attr]
    with pytest.raises(hs.SceneError, match="does not tell its own"):
        hs.evaluate_all(hs.load_scenes("palpation-device"), proportion=0.84)


@pytest.mark.slow
def test_the_command_compares_regions_of_all_environments(call, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    status, out, _ = call("evaluate", "palpation-device", "--regions", "--figures", str(tmp_path))
    assert (status, "By these regions the common bandwidth lies between" in out) == (0, True)
    assert (tmp_path / "regions.svg").exists()
    status, _, err = call("evaluate", "palpation-device", "--proportion", "0.84")
    assert (status, "jnd: proportion: the JND does not tell its own" in err) == (2, True)


@pytest.mark.slow
def test_the_figure_has_a_mark_for_each_bandwidth_and_says_where_there_is_none() -> None:
    from haptisym.figures.regions import family_regions_figure

    found = hs.evaluate_all(hs.load_scenes("palpation-device"), regions=True)
    [ax] = family_regions_figure(found).axes
    marks = [x for x in ax.lines if x.get_marker() in ("s", "o", "D", "x")]
    for line, x in zip(marks, found.regions, strict=True):
        expected = [*(x.answers[name].bandwidth for name in found.family), x.bandwidth]
        assert list(line.get_xdata()) == [float(w) for w in expected]  # type: ignore[arg-type]
    blocked = {
        name: hs.Scene(environments.kelvin_voigt(k, 1), (effects.compliance(k=900),))
        for name, k in (("soft", 30), ("hard", 900))
    }
    [ax] = family_regions_figure(hs.evaluate_all(hs.SceneFamily(blocked), regions=True)).axes
    assert [x.get_text() for x in ax.texts] == ["no bandwidth", "no bandwidth"]
