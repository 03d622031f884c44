"""Scene files: what a table means, key by key, and one sentence with the place for whatever is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import haptisym as hs
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.scenefile import chosen, open_scenes, parse_scenes
from haptisym.model.scenetables import MOST_EFFECTS

ENV = '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'
TWO = '[[environments]]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n[[environments]]\nname = "wall"\nmodel = "maxwell"\nk = 1\nb = 2\n'
FELT = f'{ENV}[perceived]\nfile = "bench.csv"\n'


def told(text: str, place: Path | None = None) -> str:
    """What is said against a scene; empty where nothing is."""
    try:
        if place is None:
            parse_scenes(text, "my.toml")
        else:
            (place / "my.toml").write_text(text, encoding="utf-8")
            open_scenes(place / "my.toml")
    except hs.SceneError as error:
        return str(error)
    return ""


def test_a_scene_has_its_defaults_where_nothing_is_said() -> None:
    own = hs.parse_scene(ENV)
    assert (own.title, own.source, own.effects, own.band, own.threshold, own.rendered, own.hands) == (
        "",
        "",
        (),
        (0, 15),
        hs.Threshold(),
        None,
        (),
    )
    assert own.text == ENV
    more = hs.parse_scene(
        f'title = "Mine"\nsource = "me"\n{ENV}[rendered]\nmodel = "kelvin-voigt"\nk = 90\nb = 3\n[[effects]]\nmodel = "delay"\ntau = "1 ms"\n'
        '[[effects]]\nmodel = "delay"\nname = "late"\ntau = "2 ms"\n[evaluation]\nband = [1, "2 Hz"]\njnd = 0.2\n[hand]\nm = 1\n'
    )
    assert (more.title, more.source, [x.name for x in more.effects], float(more.band[0])) == (
        "Mine",
        "me",
        ["delay", "late"],
        1,
    )
    assert (more.rendered.H, more.threshold.real * 5, [x.name for x in more.hands]) == (
        hs.environments.kelvin_voigt(90, 3).H,
        1,
        ["hand"],
    )  # type: ignore[union-attr]
    several = hs.parse_scene(f'{ENV}[[hands]]\nname = "a"\nm = 1\n[[hands]]\nname = "b"\nk = 2\nsource = "me"\n')
    assert [(x.name, x.source) for x in several.hands] == [("a", ""), ("b", "me")]
    family = parse_scenes(TWO + 'rendered = { model = "maxwell", k = "environment.k", b = 7 }\n')
    assert list(family) == ["kelvin-voigt", "wall"]
    assert family["wall"].rendered is not None
    assert family["wall"].rendered.H == hs.environments.maxwell(1, 7).H
    assert chosen(family, "x", "wall").title == "Untitled scene: wall"
    assert list(parse_scenes(TWO.replace('name = "wall"\n', ""))) == ["kelvin-voigt", "maxwell"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("title = 3\n" + ENV, 'title: "3" must be a string'), ("source = []\n" + ENV, "source: "), ('titel = "x"\n' + ENV, 'unknown key "titel": did you mean "title"?'),
        ("", "[environment] is missing: a scene needs something that should be felt"), ("environment = 3", 'environment: "3" must be a table of keys and values'),
        ("[[environment]]\nk = 1", "one is written [environment]; several are written [[environments]], with an s"), (ENV + "[evaluation]\nbandd = [0, 1]", 'evaluation: unknown key "bandd"'),
        ("evaluation = 2\n" + ENV, 'evaluation: "2" must be a table'), (ENV + "[evaluation]\nband = [1]", "must be a list of two frequencies"), (ENV + "[evaluation]\nband = 3", "must be a list"),
        (ENV + "[evaluation]\nband = [0, 1, 2]", "must be a list of two"), (ENV + '[evaluation]\nband = [0, "1 kg"]', 'evaluation: band: "1 kg" is not a frequency'),
        (ENV + "[evaluation]\njnd = 0", 'evaluation: jnd: real: "0" must be > 0'), (ENV.replace('model = "kelvin-voigt"\n', ""), "environment: model is missing: valid are mass-spring-damper"),
        (ENV.replace("kelvin-voigt", "kelvin-void"), 'environment: unknown model "kelvin-void": did you mean "kelvin-voigt"?'), (ENV.replace('"kelvin-voigt"', "3"), 'unknown model "3"'),
        (ENV + "q = 1", 'environment: unknown parameter "q": valid are k, b'), (ENV.replace("b = 2\n", ""), "environment: parameter b is missing: required are k, b"),
        ("effects = 3\n" + ENV, "effects: must be written [[effects]], once for each effect"), (ENV + "[effects]\nx = 1", "effects: must be written [[effects]]"),
        ("effects = [3]\n" + ENV, 'effects[1]: "3" must be a table'), (ENV + '[[effects]]\nmodel = "delay"\nname = ""\ntau = 1', 'effects[1]: name: "" must be a string that is not empty'),
        (ENV + '[[effects]]\nmodel = "delay"\nname = 3\ntau = 1', 'effects[1]: name: "3" must be a string'), (ENV + '[[effects]]\nmodel = "delay"\n', 'effects[1] "delay": parameter tau is missing'),
        (ENV + '[[effects]]\nmodel = "delay"\nname = "late"\n', 'effects[1] "late": parameter tau is missing'), (ENV + '[[effects]]\nmodel = "dely"', 'effects[1]: unknown model "dely": did you mean "delay"?'),
        (ENV + '[[effects]]\nmodel = "series"\nG = "1"\nparameters = 3', 'effects[1] "series": parameters: "3" must be a table'),
        (ENV + '[[effects]]\nmodel = "shunt"\nk = 1\n' * MOST_EFFECTS, ""), (ENV + '[[effects]]\nmodel = "shunt"\nk = 1\n' * (MOST_EFFECTS + 1), "a scene may have at most 100 effects, this one has 101"),
        ("environments = []", "environments: must be written [[environments]], once for each environment"), ("environments = 3", "environments: must be written [[environments]]"),
        (TWO + "[environment]\nk = 1", "environment: give either [environment] or [[environments]], each with its own environment"),
        (TWO + "[rendered]\nk = 1", "rendered: give either [rendered] or [[environments]], each with its own rendered"), ("environments = [3]", 'environments[1]: "3" must be a table'),
        (TWO.replace('"wall"', '""'), 'environments[2]: name: "" must be a string'), (TWO.replace('"wall"', "7"), 'environments[2]: name: "7" must be'),
        (TWO.replace("maxwell", "maxwel"), 'environments[2] "wall": unknown model "maxwel"'), (TWO.replace("k = 1\n", "k = 0\n"), 'environments[2] "wall": k: "0" must be > 0'),
        (TWO + 'rendered = { model = "maxwell", k = "environment.q", b = 7 }', 'environments[2] "wall": rendered: k: "environment.q" is no parameter of the environment'),
        (ENV + '[rendered]\nmodel = "maxwell"\nk = 1\n', "rendered: parameter b is missing"), (ENV + "[hand]\nm = -1", "hand: m: ") ,
        (ENV + "[hand]\nq = -1", 'hand: unknown key "q": valid are m, b, k, source'), (ENV + "[hand]\nsource = 1", 'hand: source: "1" must be a string'),
        ("hand = 3\n" + ENV, 'hand: "3" must be a table'), ("hands = 3\n" + ENV, "hands: must be written [[hands]], once for each hand"), (ENV + '[[hands]]\nname = ""\n', "hands[1]: name: each of several"),
        (ENV + '[hand]\nname = "mine"\nm = 1\n', ""), ("x = 1 2", "; a value with a unit goes in quotes, as in k = \"100 N/m\""), ("k = 100 N/m", "goes in quotes"), ("k = N", "goes in quotes"),
        ("[effects]\n[effects]", "each effect begins with [[effects]]"), ("omega,real,imag\n1,2,3", "a table of lines and no scene"), ("# x\n\na;b\n", "a table of lines and no scene"), ("a\tb\n", "a table of lines"),
        ("a, b = 3", "not valid TOML"), ("{a, b", "not valid TOML"), (FELT, "this scene is measured, line by line, and evaluate alone judges it"), ('[environment]\nfile = "x"', "this scene is measured"),
    ],
)  # fmt: skip
def test_what_is_no_scene_is_told_with_its_place(text: str, said: str) -> None:
    found = told(text)
    assert said in found
    assert bool(said) == bool(found)
    assert not found or found.startswith("my.toml: ")
    if "a, b = 3" in text or "{a, b" in text:
        assert "a table of lines" not in found


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (FELT, ""), (FELT + "slope = '1 ms'\n", ""), (FELT + "confidence = 0.5\n", ""), (FELT + "confidence = '50 %'\n", ""), (FELT.replace("[environment]", "[rendered]\nk = 1\n[environment]"), "rendered: does not go with"),
        ('effects = []\n' + FELT, "effects: does not go with what is measured"), ("hand = 1\n" + FELT, "hand: does not go"), ("hands = []\n" + FELT, "hands: does not go"), ("environments = []\n" + FELT, "environments: does not go"),
        ("titel = 1\n" + FELT, 'unknown key "titel"'), ('[perceived]\nfile = "bench.csv"', "[environment] is missing: what is felt is compared"), ('[environment]\nfile = "bench.csv"', "[perceived] is missing"),
        ("perceived = 3\n" + ENV, 'perceived: "3" must be a table'), (FELT.replace('"bench.csv"', "3"), "perceived: file: give the name of a CSV file"), (FELT.replace('"bench.csv"', '""'), "file: give the name"),
        (FELT.replace('"bench.csv"', '"a\\u0000b"'), "file: give the name"), (FELT.replace("bench.csv", "none.csv"), "perceived: none.csv: there is no such file"), (FELT + "averages = 'x'\n", "perceived: averages: "),
        (FELT + "overlap = 0.5\n", "estimator is missing"), (FELT + "estimator = 'H1'\noverlap = 'x'\n", "perceived: overlap: "), (FELT + "estimator = 'H1'\n", 'unknown column "omega"'), (FELT + "slope = 3\n", "perceived: slope: "),
        (FELT + "confidence = 2\n", "confidence: 2.0 must"), (FELT + "[evaluation]\nband = [3, 4]\n", ""), (FELT + "[evaluation]\nbond = [3, 4]\n", 'evaluation: unknown key "bond"'), (FELT + "[evaluation]\njnd = 0\n", "jnd: real"),
        (FELT.replace('model = "kelvin-voigt"\nk = 100\nb = 2', 'file = "bench.csv"'), ""), (FELT.replace('model = "kelvin-voigt"\nk = 100\nb = 2', 'file = "x.csv"'), "environment: x.csv: there is no such file"),
    ],
)  # fmt: skip
def test_what_is_no_measured_scene_is_told_with_its_place(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "bench.csv").write_text("omega,real,imag\n1,2,3\n2,3,4\n", encoding="utf-8")
    found = told(text, tmp_path)
    assert said in found
    assert bool(said) == bool(found)
    if not found:
        opened, name = open_scenes(tmp_path / "my.toml")
        assert (type(opened), name) == (MeasuredScene, "my.toml")
        band: Any = opened.band  # type: ignore[union-attr]
        assert (band is None) == ("band" not in text)
