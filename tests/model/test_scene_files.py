"""Scenes: what a file means and what is none, names of what may be varied, parameters in two places, and what is said beside an answer."""

from __future__ import annotations

import inspect
import os
import pickle
import re
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from benches import bench
from hypothesis import given
from hypothesis import strategies as st
from refusals import refusal
from scipy.io import savemat
from sympy import Expr, Integer, Rational, Symbol, diff, pi, sqrt

import haptisym as hs
from haptisym import effects, environments
from haptisym.kernel.errors import HaptisymError
from haptisym.model.catalogue import Hand
from haptisym.model.jnd import Threshold
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.quantities import MotionKind
from haptisym.model.scene import Knob, Scene, caveats, clocks, sampled_loop, with_names
from haptisym.model.scenefile import MOST_EFFECTS, SceneFamily, chosen, named, open_scenes, parse_scenes
from haptisym.verbs.sweep.axes import axes, spaced

Call = Callable[..., tuple[int, str, str]]
LAG = effects.first_order_lag(20)
ENV = '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n'
TWO = '[[environments]]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n[[environments]]\nname = "wall"\nmodel = "maxwell"\nk = 1\nb = 2\n'
FELT = f'{ENV}[perceived]\nfile = "bench.csv"\n'


# --- files -----------------------------------------------------------------------------------------------------------


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


def env(text: str) -> str:
    return f"[environment]\n{text}\n"


def more(text: str) -> str:
    return f"{ENV}{text}\n"


def effect(text: str) -> str:
    return f"{ENV}[[effects]]\n{text}\n"


DELAY, MSD = 'model = "delay"', 'model = "mass-spring-damper"\n'
NO_SCENES: list[tuple[str, str]] = [
    # what is no TOML, and which keys there are
    ("this is not TOML", "TOML"), ('title = "x', "TOML"), ("[environment]\nmodel='maxwell'\nmodel='maxwell'", "TOML"), ("a = " + "[" * 20_000, "nested"),
    (env(f"{MSD}k = {'9' * 10_000}"), "TOML"), ("k = 100 N/m", "goes in quotes"), ("k = N", "goes in quotes"), ("omega,real,imag\n1,2,3", "table of lines"), ("# x\n\na;b\n", "table of lines"),
    ("a\tb\n", "table of lines"), ("a, b = 3", "not valid TOML"), ("[effects]\n[effects]", r"\[\[effects\]\]"), ("", r"\[environment\] is missing"), ("environment = 3", '"3" must be a table'),
    ("[[environment]]\nk = 1", r"write \[environment\] for one"), (f"title = 3\n{ENV}", "title: "), (f"source = []\n{ENV}", "source: "), (f'titel = "x"\n{ENV}', 'did you mean "title"'),
    (more("[evaluation]\nbandd = [0, 1]"), 'unknown key "bandd"'), (f"evaluation = 2\n{ENV}", "must be a table"), (ENV.replace('model = "kelvin-voigt"\n', ""), "model is missing"),
    (ENV.replace("kelvin-voigt", "kelvin-void"), 'did you mean "kelvin-voigt"'), (ENV.replace('"kelvin-voigt"', "3"), 'unknown model "3"'), (more("q = 1"), "valid are k, b"),
    (ENV.replace("b = 2\n", ""), "kelvin-voigt needs b"), (f"effects = 3\n{ENV}", r"\[\[effects\]\]"), (more("[effects]\nx = 1"), r"\[\[effects\]\]"), (f"effects = [3]\n{ENV}", r"effects\[1\]"),
    (effect(f'{DELAY}\nname = ""\ntau = 1'), "give a name"), (effect(f"{DELAY}\nname = 3\ntau = 1"), "give a name"), (effect(DELAY), "delay needs tau"), (effect('model = "dely"'), 'did you mean "delay"'),
    (effect('model = "latency"'), 'did you mean "delay"'), (effect('model = "mass"'), 'did you mean "shunt"'), (effect('model = "ZOH"'), 'did you mean "zero-order-hold"'),
    *((effect(f'model = "{word}"'), f'did you mean "{model}"') for words, model in (
        ("quantizer quantisation quantization", "encoder"), ("hysteresis play slack", "backlash"), ("deadband dead_band", "dead-zone"), ("saturated force-limit", "saturation"),
        ("gearbox lever", "two-port"), ("motor", "first-order-lag"), ("cable", "compliance"), ("PID", "series"), ("display", "admittance-display")) for word in words.split()),
    (ENV.replace("kelvin-voigt", "PID"), 'did you mean "expression"'),
    (ENV.replace("kelvin-voigt", "spring"), 'did you mean "mass-spring-damper"'), (effect(f'{DELAY}\ntau = "1 kHz"'), "its period is 1/1000 s"),
    (effect('model = "first-order-lag"\nomega_c = "4 ms"'), "as a time constant it belongs to 250 rad/s"),
    (effect('model = "first-order-lag"\nomega_c = "1/(4 ms)"'), 'write its value with a unit, as "250 rad/s"'),
    (effect('model = "sampled-loop"\nT = "1 ms"\nmethod = "tustin"\ndelay = "2 ms"'), "2 ms are 2 samples of T = 1 ms"), (more('K = 1'), 'did you mean "k"'),
    (effect('model = "series"\nG = "1"\nparameters = 3'), "must be a table"), (ENV + '[[effects]]\nmodel = "shunt"\nk = 1\n' * (MOST_EFFECTS + 1), "at most 100, not 101"),
    ("environments = []", r"\[\[environments\]\]"), ("environments = 3", r"\[\[environments\]\]"), (TWO + "[environment]\nk = 1", "give either"), (TWO + "[rendered]\nk = 1", "give either"),
    ("environments = [3]", r"environments\[1\]"), (TWO.replace('"wall"', '""'), r"environments\[2\]: name"), (TWO.replace("k = 1\n", "k = 0\n"), r'environments\[2\] "wall": maxwell needs k > 0'),
    (TWO + 'rendered = { model = "maxwell", k = "environment.q", b = 7 }', "no parameter of the environment"), (more('[rendered]\nmodel = "maxwell"\nk = 1'), "rendered: maxwell needs b"),
    (more("[hand]\nm = -1"), "hand: m: "), (more("[hand]\nq = -1"), "valid are m, b, k, source"), (more("[hand]\nsource = 1"), "must be a string"), (f"hand = 3\n{ENV}", "must be a table"),
    (f"hands = 3\n{ENV}", r"\[\[hands\]\]"), (more('[[hands]]\nname = ""'), r"hands\[1\]: name"), (FELT, "this scene is measured"), (env('file = "x"'), "this scene is measured"),
    # values
    (env(f"{MSD}m='3 stones'"), "stones"), (env(f"{MSD}m='3 N'"), '"3 N" is not a mass.*kg'), (env(f"{MSD}k='3 Hz'"), "is not a stiffness.*N/m"), (env(f"{MSD}m='3 kg'\nk='3 N*m/rad'"), "rotational"),
    (env(f"{MSD}m='3 kg^9^9^9'"), "9"), (env(f"{MSD}m='kg'"), "number"), (env(f"{MSD}m=[1, 2, 3, 4]"), "is not a range"), (env(f"{MSD}m=true"), "m: true"), (env(f"{MSD}m=2019-01-01"), "2019-01-01"),
    (env(f"{MSD}m='-3 kg'"), "needs m >= 0"), (env(f"{MSD}m=nan"), "NaN"), (env(f"{MSD}m=inf"), "Infinity"), (env(f"{MSD}m='1e999999999 kg'"), "300"), (env(f"{MSD}m='1/0 kg'"), "zero"),
    (env(MSD), "m, b, k"), (effect('model="two-port"\nA="1"\nB="0"\nC="0"\nD="0"'), "infinite"), (effect('model="shunt"\nm=1\nZ="s"'), "Z"),
    (more("[evaluation]\nband = [3, 3]"), "above"), (more("[evaluation]\nband = ['15 rad/s', 0]"), "above"), (more("[evaluation]\nband = ['6.29', '1 Hz']"), "above"),
    (more("[evaluation]\nband = [-1, 3]"), ">= 0"), (more("[evaluation]\nband = [1]"), "two frequencies"), (more("[evaluation]\nband = 3"), "give two frequencies"), (more("[evaluation]\nband = [0, 1, 2]"), "two"),
    (more("[evaluation]\nband = ['0 s', '3 s']"), "rad/s"), (more('[evaluation]\nband = [0, "1e300 THz"]'), "1e300"), (more("[evaluation]\njnd = 0"), "> 0"),
    (env("model='expression'\nH='__import__(1)'"), "__import__"), (env("model='expression'\nH='s'\nparameters={ s = 3 }"), "no name for a parameter"), (env("model='expression'\nH='s'\nparameters=3"), "3"),
    (env("model='expression'"), "H"), (".".join("a" * 20_000) + " = 1", "more than 20 parts"), ("title = '''" + ". 'a" * 9_000, "TOML"),
    # references to the environment's parameters
    *((f'{ENV}[rendered]\nmodel = "kelvin-voigt"\nb = 2\nk = {line}\n', told) for line, told in (
        ('"environment.kk"', 'did you mean "environment.k"'), ('"enviroment.k"', 'did you mean "environment.k"'), ('"rendered.b"', "valid are environment.k, environment.b"),
        ('"effects.device.k"', "no parameter of the environment"), ('"environment.b"', r"is not a stiffness.*N\*m/rad"), ('"environment.k +- 5 %"', "write a reference alone"),
        ('"0.5*environment.k"', "write a reference alone"), ('"environment."', "write a reference alone"), ('["environment.k", "600 N/m"]', "finite number"))),
    (env('model = "kelvin-voigt"\nk = "environment.b"\nb = 3'), "only .rendered. can refer"), (effect('model = "shunt"\nk = "environment.k"'), "only .rendered. can refer"),
    (env(f"{MSD}k = 0\nb = 1") + '[rendered]\nmodel = "maxwell"\nb = 1\nk = "environment.k"', "must be > 0"),
    (env(f"{MSD}k = ['0 N/m', '2 N/m']\nb = 1") + '[rendered]\nmodel = "maxwell"\nb = 1\nk = "environment.k"', "must be > 0"),
    (env("model = 'expression'\nH = '3 + s'") + '[rendered]\nmodel = "kelvin-voigt"\nk = "environment.q"\nb = 1', "it has none"),
    (env("model = 'expression'\nH = 'q'\nparameters = { q = '3 N*m/rad' }") + '[rendered]\nmodel = "kelvin-voigt"\nk = "environment.q"\nb = "2 N*s/m"', "rotational"),
    (env("model = 'expression'\nH = 'q + s'\nparameters = { q = '3 kg' }") + '[rendered]\nmodel = "kelvin-voigt"\nk = "environment.q"\nb = 2', "is not a stiffness"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), NO_SCENES, ids=range(len(NO_SCENES)))
def test_what_is_no_scene_is_told_with_its_place(text: str, told: str) -> None:
    said = refusal(parse_scenes, text, "my.toml")
    assert said.startswith("my.toml: ")
    assert re.search(told, said)
    assert len(said) < 1000


NO_MEASURED = [
    (FELT, ""), (FELT + "slope = '1 ms'\n", ""), (FELT + "confidence = '50 %'\n", ""), (FELT + "[evaluation]\nband = [3, 4]\n", ""), ("effects = []\n" + FELT, "effects: a measured scene has"),
    (FELT.replace('model = "kelvin-voigt"\nk = 100\nb = 2', 'file = "bench.csv"'), ""), (FELT.replace("[environment]", "[rendered]\nk = 1\n[environment]"), "rendered: a measured scene has"),
    ("hand = 1\n" + FELT, "hand: a measured"), ("hands = []\n" + FELT, "hands: a measured"), ("environments = []\n" + FELT, "environments: a measured"), ("titel = 1\n" + FELT, 'unknown key "titel"'),
    ('[perceived]\nfile = "bench.csv"', "is missing"), ('[environment]\nfile = "bench.csv"', "is missing"), ("perceived = 3\n" + ENV, "must be a table"), (FELT.replace('"bench.csv"', "3"), "file: give"),
    (FELT.replace('"bench.csv"', '"a\\u0000b"'), "file: give"), (FELT.replace("bench.csv", "none.csv"), "no such file"), (FELT + "averages = 'x'\n", "averages: "), (FELT + "overlap = 0.5\n", "estimator is missing"),
    (FELT + "estimator = 'H1'\n", 'no column t'), (FELT + "slope = 3\n", "slope: "), (FELT + "confidence = 2\n", "confidence: "), (FELT + "[evaluation]\njnd = 0\n", "jnd: real"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), NO_MEASURED, ids=range(len(NO_MEASURED)))
def test_what_is_no_measured_scene_is_told(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "bench.csv").write_text("omega,real,imag\n1,2,3\n2,3,4\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    said = refusal(open_scenes, tmp_path / "my.toml")
    assert told in said
    assert bool(told) == bool(said)
    if not told:
        opened, _ = open_scenes(tmp_path / "my.toml")
        assert isinstance(opened, MeasuredScene)
        assert (opened.band is None) == ("band" not in text)
        assert "--no-files" in refusal(open_scenes, tmp_path / "my.toml", files=False)


def test_a_wrong_file_ends_the_command_with_one_message_and_nothing_of_it_is_executed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: Call
) -> None:
    monkeypatch.chdir(tmp_path)
    for text in (
        env(f"{MSD}m = \"3 __import__('os').system('touch owned')\""),
        env("model = 'expression'\nH = \"__import__('os').system('touch owned')\""),
    ):
        (tmp_path / "broken.toml").write_text(text, encoding="utf-8")
        status, out, err = call("evaluate", "broken.toml", "--json")
        assert (status, out) == (2, "")
        assert re.match(r"error: .*broken\.toml.*environment", err)
        assert "Traceback" not in err
        assert [x.name for x in tmp_path.iterdir()] == ["broken.toml"]


def test_a_file_is_read_with_a_mark_of_byte_order_from_a_pipe_and_up_to_a_million_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "mine.toml"
    path.write_text(ENV, encoding="utf-8-sig")
    assert hs.load_scene(path) == hs.parse_scene(ENV) == hs.parse_scene("\ufeff" + ENV)
    path.write_text(ENV + "#" * (1_000_000 - len(ENV)), encoding="utf-8")
    assert hs.load_scene(path).environment.model == "kelvin-voigt"
    path.write_text(ENV + "#" * (1_000_001 - len(ENV)), encoding="utf-8")
    assert "at most 1000000 bytes" in refusal(hs.load_scene, path)
    path.write_text(ENV, encoding="utf-16")
    assert "UTF-16: save it as UTF-8" in refusal(hs.load_scene, path)
    path.write_bytes(b"\x89PNG\xff\xfe\x00")
    assert "not a text file" in refusal(hs.load_scene, path)
    said = refusal(hs.parse_scene, 'environment = { model = "mass-spring-damper", m = "1 kg", b = 1, k = "950 Nm" }')
    assert "Nm is read as N*m/rad: along a line write N/m" in said
    for name, said in (("mine", 'did you mean "mine.toml"'), ("mine.tml", 'did you mean "mine.toml"'), ("fu2018", 'did you mean "fu2019"'), ("fu2091", 'did you mean "fu2019"'),
                       ("zzz", "fu2019"), ("mine.csv", 'mine.csv: no such file: did you mean "mine.toml"?'),
                       (".", "fu2019"), ("\0", "fu2019"), ("\n", "this is the text of a scene")):  # fmt: skip
        assert said in refusal(hs.load_scene, name)
    for name in ("zzz.csv", "no/such/file.toml"):
        assert refusal(hs.load_scene, name) == f"{name}: no such file"


def test_a_pipe_with_a_wrong_scene_and_a_device_without_end_are_named(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_text("k = 1", encoding="utf-8"))
    writer.start()
    with pytest.raises(hs.SceneError, match=rf'{pipe}: unknown key "k"'):
        hs.load_scene(pipe)
    writer.join()
    with pytest.raises(hs.SceneError, match="/dev/zero: a scene has at most 1000000 bytes"):
        hs.load_scene("/dev/zero")


# --- scenes, by their names and in Python ----------------------------------------------------------------------------

CALLS: dict[str, Callable[[Any], str]] = {
    "control_loading": lambda x: hs.control_loading(x).to_json(),
    "check": lambda x: str([run.estimates for run in hs.check(x, count=2)]),
    "cost": lambda x: hs.cost(x, quick=True).scene.title,
    "derive": lambda x: str(hs.derive(x, ["m"])["H_perc"]),
    "design_map": lambda x: hs.design_map(x, ["zeta", "omega_n"], [(0.4, 0.6), (50, 500)], slices=2).to_json(),
    "evaluate": lambda x: hs.evaluate(x).to_json(),
    "metrics": lambda x: hs.metrics(x).to_json(),
    "peaks": lambda x: str([p.omega.digits(9) for p in hs.peaks(x)]),
    "relevance": lambda x: str(hs.relevance(x).pruned),
    "release": lambda x: hs.release(x, "1 cm", "postural-arm").to_json(),
    "require": lambda x: hs.require(x, "omega_n").to_json(),
    "sampled": lambda x: str(hs.sampled(x, [1, 5]).H),
    "scene_code": lambda x: hs.scene_code(x, hs.Language.C),
    "sensitivity": lambda x: hs.sensitivity(x).to_json(),
    "simulate": lambda x: str(hs.simulate(x, hs.sine("5 cm", 10)).estimates),
    "stability": lambda x: hs.stability(x, "postural-arm").to_json(),
    "sweep": lambda x: str(hs.sweep(x, {"effects.filter.omega_n": [40.0]}).bandwidth.values),
    "tolerances": lambda x: str(hs.tolerances(x, samples=0, limit=5).box.sides),
}

TIMED = {"cost"}  # minutes of measuring


@pytest.mark.dear("require", "stability")
@pytest.mark.few("evaluate", "derive", "require", "stability")
@pytest.mark.parametrize("name", [x for x in CALLS if x not in TIMED])
def test_a_name_or_a_path_is_as_good_as_the_scene(name: str, tmp_path: Path) -> None:
    shipped = "fu2019-tolerances" if name == "tolerances" else "fu2019"
    text = (Path(hs.__file__).parent / "scenes" / f"{shipped}.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    expected = CALLS[name](hs.load_scene(shipped))
    assert CALLS[name](shipped) == CALLS[name](path) == CALLS[name](str(path)) == expected


NO_SCENE: dict[str, tuple[Callable[[], object], str]] = {
    "a distortion": (lambda: hs.load_scene("fu2019").distortion(), r"Scene\(|leave it out"), "an environment": (lambda: environments.kelvin_voigt(1, 2), r"make one with Scene\("),
    "a family": (lambda: hs.load_scenes("palpation-device"), r"evaluate_all\("), "an evaluation": (lambda: hs.evaluate("fu2019"), "its attribute scene"), "a text": (lambda: ENV, r"parse_scene\("),
    "a number": (lambda: 3, "int is not a scene"), "nothing": (lambda: None, "NoneType is not a scene"), "a wrong name": (lambda: "fu2020", 'did you mean "fu2019"'),
    "the name of a family": (lambda: "palpation-device", "--environment NAME"),
}  # fmt: skip


@pytest.mark.dear("the name of a family")
@pytest.mark.parametrize("what", NO_SCENE)
def test_what_is_no_scene_is_refused_by_every_verb_with_what_to_call(what: str) -> None:
    made, message = NO_SCENE[what]
    wrong = made()
    for ask in CALLS.values():
        with pytest.raises(hs.SceneError, match=message):
            ask(wrong)


def test_every_verb_that_takes_a_scene_takes_a_name_or_a_path() -> None:
    public = {name: getattr(hs, name) for name in dir(hs)}
    asking = {
        name for name, x in public.items() if inspect.isfunction(x) and "scene" in inspect.signature(x).parameters
    }
    # design takes families, too, fit_zwidth sampled walls alone, and explore draws in a notebook
    assert asking - {"load_scene", "load_scenes", "design", "fit_zwidth", "explore"} == set(CALLS)


@pytest.mark.slow
def test_several_environments_are_evaluated_by_name_path_or_one_scene(tmp_path: Path) -> None:
    expected = hs.evaluate_all(hs.load_scenes("palpation-device")).to_json()
    path = tmp_path / "mine.toml"
    path.write_text((Path(hs.__file__).parent / "families" / "palpation-device.toml").read_text(encoding="utf-8"))
    assert hs.evaluate_all("palpation-device").to_json() == expected
    assert hs.evaluate_all(path).to_json() == expected
    one = hs.evaluate_all(hs.load_scene("fu2019"))
    assert one.to_json() == hs.evaluate_all("fu2019").to_json()
    with pytest.raises(hs.SceneError, match="int is not a scene"):
        hs.evaluate_all(3)  # type: ignore[arg-type]


SPRING = hs.environments.mass_spring_damper(k="100 N/m")

WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "one effect": (lambda: hs.Scene(SPRING, LAG), "effects: "),  # type: ignore[arg-type]
    "a name for effects": (lambda: hs.Scene(SPRING, "delay"), 'effects: "delay"'),  # type: ignore[arg-type]
    "a name among effects": (lambda: hs.Scene(SPRING, ("delay",)), 'effects: "delay"'),  # type: ignore[arg-type]
    "an environment among effects": (lambda: hs.Scene(SPRING, (SPRING,)), "give effects of haptisym.effects"),  # type: ignore[arg-type]
    "an effect to feel": (lambda: hs.Scene(LAG), "give one of haptisym.environments"),  # type: ignore[arg-type]
    "an effect to render": (lambda: hs.Scene(SPRING, rendered=LAG), "rendered: "),  # type: ignore[arg-type]
    "a band of one end": (lambda: hs.Scene(SPRING, (LAG,), 15), 'band: "15"'),  # type: ignore[arg-type]
    "one hand": (lambda: hs.Scene(SPRING, hands=hs.Hand("h", m=1)), "hands: "),  # type: ignore[arg-type]
    "effects in a list": (lambda: hs.distort(SPRING, [LAG]), "effects: "),  # type: ignore[arg-type]
    "a scene's name to distort": (lambda: hs.distort("fu2019"), 'environment: "fu2019"'),  # type: ignore[arg-type]
    "no digits": (lambda: hs.evaluate("fu2019").crossings[0].omega.digits(0), "digits: 0 must be a whole number"),
    "half a digit": (lambda: hs.evaluate("fu2019").crossings[0].omega.digits(2.5), "digits: 2.5"),  # type: ignore[arg-type]
    "a range of one end": (lambda: hs.require("fu2019", "zeta", 5), "the range has two ends"),  # type: ignore[arg-type]
    "one range for two": (lambda: hs.design_map("fu2019", ["omega_n", "zeta"], [(60, 200)]), "one for each of the two"),
    "a list to vary": (lambda: hs.sweep("fu2019", ["zeta"]), "vary: "),  # type: ignore[arg-type]
    "a number for a hand": (lambda: hs.stability("fu2019", 5), 'hand: "5"'),  # type: ignore[arg-type]
    "a number to be free": (lambda: hs.stability("fu2019", "light-touch", free=3), 'free: "3"'),  # type: ignore[arg-type]
    "a number to keep": (lambda: hs.derive("fu2019", keep=-1), 'keep: "-1"'),  # type: ignore[arg-type]
    "a language that is none": (lambda: hs.scene_code("fu2019", "python"), "is none of numpy, c, octave"),
    "one frequency": (lambda: hs.multisine("5 cm", 5), 'omegas: "5"'),  # type: ignore[arg-type]
    "names for scenes": (lambda: hs.SceneFamily({"a": "fu2019"}), 'environments: a: "fu2019"'),  # type: ignore[dict-item]
    "a list of scenes": (lambda: hs.SceneFamily(["fu2019"]), "environments: "),  # type: ignore[arg-type]
    "a path for a text": (lambda: hs.parse_scene(Path("x.toml")), "load_scene reads a file"),  # type: ignore[arg-type]
    "bytes for a text": (lambda: hs.parse_scene(b"title = 1"), "load_scene reads a file"),  # type: ignore[arg-type]
    "a list of answers": (lambda: hs.jnd([(1, 2, 3)]), "data: "),  # type: ignore[arg-type]
    "no recording": (lambda: hs.recording(None), 'recording: "None"'),  # type: ignore[arg-type]
    "a list of symbols": (lambda: hs.symbols(["m", "b"]), "give names in one string"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("give", "told"), WRONG.values(), ids=WRONG)
def test_what_is_of_another_type_is_refused_in_one_sentence(give: Callable[[], object], told: str) -> None:
    with pytest.raises(HaptisymError) as raised:
        give()
    assert told in str(raised.value)
    assert "\n" not in str(raised.value)


COUNTS: list[tuple[str, int, Callable[[Any], object]]] = [
    ("digits", 1, lambda n: hs.evaluate("fu2019", digits=n)),
    ("digits", 1, lambda n: hs.evaluate("fu2019").crossings[0].omega.digits(n)),
    ("digits", 1, lambda n: hs.require("fu2019", "omega_n", digits=n)),
    ("digits", 1, lambda n: hs.stability("fu2019", digits=n)),
    ("samples", 0, lambda n: hs.tolerances("fu2019-tolerances", samples=n)),
    ("block", 1, lambda n: hs.sweep("fu2019", {"zeta": [0.4, 0.5]}, block=n)),
]


@pytest.mark.parametrize(("name", "least", "ask"), COUNTS)
def test_a_count_is_a_whole_number_and_nothing_else_is(name: str, least: int, ask: Callable[[Any], object]) -> None:
    for wrong in (least - 1, True, 2.0, "3", None, [2]):
        with pytest.raises(hs.SceneError, match=rf"{name}: .* must be a whole number.* at least {least}"):
            ask(wrong)


@pytest.mark.parametrize("one", [1, np.int16(1), Integer(1)], ids=repr)
def test_a_whole_number_may_be_of_any_kind(one: Any) -> None:
    assert [c["digits"] for c in hs.evaluate("fu2019", one).to_dict()["crossings"]] == ["8", "10"]


@given(st.lists(st.sampled_from(["a", "a-2", "a-3", "b"]), min_size=1, max_size=6))
def test_effects_of_one_name_are_numbered_past_the_names_that_there_are(names: list[str]) -> None:
    found = [x.name for x in with_names([hs.effects.delay(1, name=name) for name in names])]
    taken, expected = set(names), list[str]()
    for name in names:
        own = name
        if own in expected:
            i = 2
            while f"{name}-{i}" in taken:
                i += 1
            own = f"{name}-{i}"
            taken.add(own)
        expected.append(own)
    assert found == expected
    assert len(set(found)) == len(found)


def test_a_hand_is_its_mass_damping_and_stiffness_and_nothing_below_zero() -> None:
    hand = Hand("mine", "0.5 kg", ["5 N*s/m", "7 N*s/m"], 30)
    assert [(p.key, p.value) for p in hand.parameters] == [("m", Rational(1, 2)), ("b", 6), ("k", 30)]
    assert (hand.has_ranges, hand.motion) == (True, MotionKind.TRANSLATION)
    assert (Hand("light").Z, Hand("light").has_ranges, Hand("light").motion) == (0, False, None)
    moved = hand.with_values({"b_h": 9, "k_h": 0})
    assert [(p.value, p.interval) for p in moved.parameters] == [(Rational(1, 2), None), (9, None), (0, None)]
    for keys in ({"m": -1}, {"b": "1 kg"}, {"m": "1 kg", "b": "1 N*m*s/rad"}, {"name": ""}, {"name": 3}):
        assert refusal(Hand, **({"name": "x"} | keys))
    assert 'did you mean "postural-arm"' in refusal(hs.hands.__getitem__, "postural_arm")
    assert '"mine" is there twice' in refusal(Scene, environments.kelvin_voigt(1, 2), hands=(hand, hand))


def soft(k: Any = 100, *between: hs.Effect, **keys: Any) -> Scene:
    return Scene(environments.kelvin_voigt(k, 2), between or (LAG,), **keys)


def test_a_family_has_one_to_a_hundred_scenes_of_one_display() -> None:
    one, lag, pade = soft(), effects.first_order_lag, effects.pade_delay
    assert len(named(("x", one) for _ in range(100))) == 100
    assert "1 to 100, not 101" in refusal(named, [("x", one)] * 101)
    assert "1 to 100, not 0" in refusal(SceneFamily, {})
    assert list(named([("x", one), ("x", one), ("x-2", one), ("y", one)])) == ["x", "x-2", "x-2-2", "y"]
    for other in (
        soft(100, lag(21)),
        soft(100, lag(20, name="b")),
        soft(band=(0, 16)),
        soft(threshold=0.2),
        soft(100, LAG, LAG),
    ):
        assert '"b" has other effects, another band or another JND' in refusal(SceneFamily, {"a": one, "b": other})
    assert '"b" has other' in refusal(SceneFamily, {"a": soft(1, pade(0, 1)), "b": soft(2, pade(0, 2))})
    family = SceneFamily({"a": one, "b": soft(200)}, "Two")
    assert 'these are "a", "b"' in refusal(family.__getitem__, "c")
    assert "--environment NAME" in refusal(family.only)
    assert (SceneFamily({"a": one}).only(), family.band, family.threshold, family.first) == (
        one,
        (0, 15),
        Threshold(),
        one,
    )


@pytest.mark.parametrize(
    ("band", "told"),
    [
        ((0, 1), ""),
        (("6.28", "1 Hz"), ""),
        ((1,), "a low and a high end"),
        (3, "two ends"),
        (("-1 Hz", 1), ">= 0"),
        (("2 Hz", "1 Hz"), "above"),
    ],
)
def test_a_band_in_python_has_two_ends_that_rise(band: Any, told: str) -> None:
    said = refusal(soft, band=band)
    assert told in said
    assert bool(told) == bool(said)


def test_a_value_that_divides_a_formula_by_zero_is_told_with_it() -> None:
    link = effects.two_port(A="1", B="0", C="1/q", D="1", parameters={"q": 0})
    assert "1/q is divided by zero with q = 0" in refusal(
        hs.evaluate, Scene(environments.kelvin_voigt(100, 2), (link,))
    )


# --- names of what may be varied -------------------------------------------------------------------------------------

SCENES = {name: hs.load_scene(name) for name in hs.scene_names()} | {
    f"{name}:{key}": scene for name in hs.family_names() for key, scene in hs.load_scenes(name).scenes.items()
}

PAPER = SCENES["fu2019"]


def names(knob: Knob, scene: hs.Scene) -> set[str]:
    """All names that mean one number of a scene, from the words of the documentation: path, symbol, end of a path."""
    ends = {path.partition(".")[2] for path in knob.paths} | {path.rpartition(".")[2] for path in knob.paths}
    others = [path for x in scene.knobs if x != knob for path in (*x.paths, f".{x.name}")]
    return {*knob.paths, knob.name} | {end for end in ends if not any(x.endswith(f".{end}") for x in others)}


def own(knob: Knob) -> Any:
    return knob.interval or knob.value


@pytest.mark.dear("control-stick-in-detail")
@pytest.mark.few("fu2019", "steering-wheel", "sampled-wall", "palpation-device:fat", "control-stick-in-detail")
@pytest.mark.parametrize("name", SCENES)
def test_each_name_means_one_number_its_own_value_changes_nothing_and_verbs_take_it(name: str) -> None:
    scene = SCENES[name]
    assert len({x.path for x in scene.knobs}) == len(scene.knobs)
    alike = scene.knobs.limits[hs.Part.REAL] is scene.knobs.limits[hs.Part.IMAG]
    for knob in scene.knobs:
        for called in names(knob, scene):
            assert scene.knobs[called] == knob
            for asked in (lambda n: hs.require(scene, n, (2, 1)), lambda n: hs.sweep(scene, {n: []})):
                assert re.match(rf"{knob.path.replace('[', '.').replace(']', '.')}[: ]", refusal(asked, called))
            kept = hs.derive(scene, [called])
            assert (kept.kept, kept.kept_thresholds) == (() if knob.parts else (knob.symbol,), knob.parts)
            if knob.value > 0 and knob.rule.name != "FRACTION":
                assert [x.path for x in axes(scene, {called: [0.5, 2.0]})] == [knob.path]
        if len(knob.parts) < 2 or alike:
            again = knob.put(scene, own(knob))
            assert again == scene
            assert again.motion is scene.motion
    together = {x.path: own(x) for x in (*scene.parameters, *set(scene.knobs.limits.values()))}
    assert scene.with_values(together) == scene


@pytest.mark.slow
def test_code_and_slopes_take_every_name() -> None:
    for knob in PAPER.parameters:
        texts = {hs.scene_code(PAPER, hs.Language.C, parameters=[name]) for name in names(knob, PAPER)}
        assert len(texts) == 1
        found = hs.sensitivity(PAPER).crossings[0]
        assert {found[name].path for name in names(knob, PAPER)} == {knob.path}
    with pytest.raises(hs.SceneError, match="evaluation.jnd is a threshold, of which code holds nothing"):
        hs.scene_code(PAPER, hs.Language.C, parameters=["c"])


TAKERS: dict[str, Callable[[hs.Scene, str], Any]] = {
    "with_values": lambda scene, name: scene.with_values({name: 1}),
    "require": lambda scene, name: hs.require(scene, name, (2, 1)),
    "design_map": lambda scene, name: hs.design_map(scene, [name, "c"], [(1, 2), (1, 2)]),
    "sweep": lambda scene, name: hs.sweep(scene, {name: []}),
    "sweep on the command line": lambda scene, name: spaced(f"{name}=1:2:2", scene),
    "derive": lambda scene, name: hs.derive(scene, [name]),
    "derive of one name": lambda scene, name: hs.derive(scene, name),
    "code": lambda scene, name: hs.scene_code(scene, hs.Language.C, parameters=[name]),
    "sensitivity": lambda scene, name: hs.sensitivity(scene).crossings[0][name],
}


@pytest.mark.dear("effects.filter.omega_c-effects.filter.omega_n-sensitivity")
@pytest.mark.parametrize("taker", TAKERS.values(), ids=TAKERS)
@pytest.mark.parametrize(
    ("name", "nearest"),
    [("omega", "omega_n"), ("effects.filter.omega_c", "effects.filter.omega_n"), ("", ""), ("qqq", "")],
)
def test_a_wrong_name_is_told_with_the_valid_ones(taker: Callable[..., Any], name: str, nearest: str) -> None:
    with pytest.raises(hs.SceneError) as told:
        taker(PAPER, name)
    assert f'unknown parameter "{name}"' in str(told.value)
    assert ("did you mean" in str(told.value)) == bool(nearest)
    assert not nearest or f'did you mean "{nearest}"' in str(told.value)
    assert "effects.filter.zeta" in str(told.value)


def test_a_setting_is_no_parameter_and_the_error_says_what_may_be_varied_instead() -> None:
    for name, said in (("delay", "vary its tau"), ("loop.method", "write another one into the scene")):
        with pytest.raises(hs.SceneError, match=rf"effects\.[\w-]+\.{name.split('.')[-1]} cannot be varied.*{said}"):
            hs.require(Scene(SOFT, (effects.sampled_loop("1/50 s", "tustin", name="loop"),)), name)


def test_a_name_that_means_several_numbers_asks_for_the_path_and_none_is_given_twice() -> None:
    twice = Scene(environments.kelvin_voigt(100, 2), (effects.shunt(k=1), effects.shunt(k=2, name="second")))
    assert twice.knobs["k"].path == "environment.k"  # symbols come first
    lags = Scene(environments.kelvin_voigt(100, 2), (LAG, effects.first_order_lag(30, name="b2")))
    assert "effects.first-order-lag.omega_c or effects.b2.omega_c" in refusal(hs.require, lags, "omega_c")
    damped = Scene(environments.expression("c + s", parameters={"c": 5}))
    assert "environment.c or evaluation.jnd" in refusal(damped.with_values, {"c": 1})
    assert damped.with_values({"environment.c": 7}).threshold == damped.threshold
    for given_ in (["m", "environment.m"], ["c", "evaluation.jnd"]):
        for ask in (
            lambda x: PAPER.with_values(dict.fromkeys(x, 1)),
            lambda x: hs.sweep(PAPER, {name: [1.0] for name in x}),
            lambda x: hs.design_map(PAPER, x, [(1, 2), (1, 2)]),
        ):
            assert "is given twice" in refusal(ask, given_)
    assert "sets both thresholds" in refusal(PAPER.with_values, {"evaluation.jnd": 1, "evaluation.jnd.imag": 1})


@pytest.mark.parametrize(
    "ask",
    [
        hs.evaluate, hs.sensitivity, hs.metrics, hs.relevance, hs.tolerances, hs.cost, hs.peaks, hs.check,
        lambda x: hs.require(x, "m"), lambda x: hs.design_map(x, ["m", "b"], [(1, 2), (1, 2)]),
        lambda x: hs.sweep(x, {"m": [1.0]}), lambda x: hs.simulate(x, hs.sine("5 cm", 5)),
    ],
)  # fmt: skip
def test_a_symbol_where_a_number_is_needed_is_told(ask: Callable[[hs.Scene], Any]) -> None:
    with pytest.raises(hs.SceneError) as told:
        ask(PAPER.with_values({"k": Symbol("q", positive=True)}))
    assert "environment.k = q is a symbol; give a number" in str(told.value)


@pytest.mark.parametrize(
    ("name", "given_", "told"),
    [
        ("omega_n", 0, "must be > 0"), ("m", "-1 kg", "must be >= 0"), ("m", "1 +- 200 %", "must be >= 0"), ("c", 0, "must be > 0"), ("c_imag", "1 kg", "is not a ratio"),
        ("jnd", Symbol("q"), "must be a number"), ("m", "1 N/m", "is not a mass"), ("m", "1 kg*m^2", "is rotational"),
    ],
)  # fmt: skip
def test_a_value_keeps_the_rule_of_its_place(name: str, given_: Any, told: str) -> None:
    said = (
        refusal(PAPER.knobs[name].number, given_)
        if told == "is rotational"
        else refusal(PAPER.with_values, {name: given_})
    )
    assert said.startswith(PAPER.knobs[name].path)
    assert told in said


def test_a_value_is_put_where_it_belongs() -> None:
    for knob in PAPER.knobs:
        moved = knob.put(PAPER, Rational(1, 7))
        others = [x for x in PAPER.knobs if x.path != knob.path and not (x.parts and knob.parts)]
        assert all(moved.knobs[x.path] == x for x in others)
        assert moved.knobs[knob.path].value == Rational(1, 7)
    half = PAPER.with_values({"evaluation.jnd.imag": "0.2 +- 10 %"})
    assert (half.threshold.real, half.threshold.imag_interval) == (Rational(1, 10), (Rational(9, 50), Rational(11, 50)))
    assert half.with_values({"c_real": "0.3"}).threshold.imag_interval == half.threshold.imag_interval
    assert half.with_values({"c_imag": "0.3"}).threshold.imag_interval is None
    assert PAPER.with_values({"c": pi / 30}).threshold[hs.Part.IMAG] == pi / 30


def test_a_bare_number_is_one_in_the_unit_that_was_there() -> None:
    wheel = SCENES["steering-wheel"]
    assert wheel.motion is not None
    bare = wheel.with_values({x.path: x.value for x in wheel.parameters})
    assert bare.motion is wheel.motion
    assert [x.unit for x in bare.knobs] == [x.unit for x in wheel.knobs]
    soft = hs.Scene(environments.expression("q + s", parameters={"q": "3 N/m"}))
    assert soft.with_values({"q": 5}).parameters[0].exponents == soft.parameters[0].exponents
    assert soft.with_values({"q": "5 kg"}).parameters[0].exponents != soft.parameters[0].exponents


def test_a_threshold_of_one_part_may_stay_a_symbol_alone() -> None:
    found = hs.derive(PAPER, ["c_real"])
    c = hs.symbols("c")
    assert (found.threshold(hs.Part.REAL), found.threshold(hs.Part.IMAG)) == (c, Rational(1, 10))


DAMPER_C = """
[environment]
model = "expression"
H = "m*s^2 + c*s + k"
parameters = { m = "1.8 kg", c = "15 N*s/m", k = "100 N/m" }

[rendered]
model = "expression"
H = "m*s^2 + d*s + k"
parameters = { m = "environment.m", d = "environment.c", k = "environment.k" }

[[effects]]
name = "filter"
model = "second-order-lowpass"
omega_n = "80 rad/s"
zeta = 0.5

[[effects]]
name = "link"
model = "shunt"
Z = "c*s^2"
parameters = { c = "0 kg" }
"""


def test_a_damper_that_is_called_c_is_no_threshold() -> None:
    """The threshold's symbol is c; every formula with a c of the scene's own was refused: two symbols of one name."""
    scene, b = hs.parse_scene(DAMPER_C), hs.derive(PAPER)
    assert [str(knob.symbol) for knob in scene.knobs.parameters] == ["m", "c_env", "k", "omega_n", "zeta", "c_link"]
    derived = hs.derive(scene)
    same = {Symbol("c_link", real=True): Integer(0)} | {
        Symbol(mine, real=True): Symbol(theirs, positive=True)
        for mine, theirs in (("m", "m"), ("c_env", "b"), ("k", "k"))
    }
    for name in ("Re dH", "Im dH"):
        assert (derived[name].xreplace(same) - b[name]).simplify() == 0
    moved, of_paper = (hs.sensitivity(x).crossings[0] for x in (scene, PAPER))
    for mine, theirs in (("environment.c", "environment.b"), ("evaluation.jnd", "evaluation.jnd")):
        assert moved[mine].derivative.digits(20) == of_paper[theirs].derivative.digits(20)
    with pytest.raises(hs.SceneError, match="write environment.c or effects.link.c or evaluation.jnd"):
        scene.knobs["c"]


@pytest.mark.dear("assumed0")
@pytest.mark.parametrize("assumed", [{}, {"positive": True}])
def test_a_symbol_that_is_called_c_may_stand_for_any_number_of_a_distortion(assumed: dict[str, bool]) -> None:
    """With m, c, k = symbols("m c k") what was computed had no numbers: c was taken for a threshold, which a distortion has not."""
    m, k, tau = (Symbol(name, **assumed) for name in ("m", "k", "tau"))

    def distortion(damping: Symbol) -> hs.Distortion:
        return hs.distort(environments.mass_spring_damper(m, damping, k), effects.delay(tau))

    c, b = Symbol("c", **assumed), Symbol("b", **assumed)
    given = {"m": 1.5, "k": 100.0, "tau": 0.01}
    named, plain = distortion(c).compile()([3.0], c=2.0, **given), distortion(b).compile()([3.0], b=2.0, **given)
    assert (named.real, named.imag) == (plain.real, plain.imag)
    assert "c" in hs.distortion_code(distortion(c), "numpy").split("def distortion(")[1].split(")")[0].split(", ")


def test_elements_of_a_scene_and_its_hands_have_names_and_what_is_of_a_hand_is_not_felt() -> None:
    more = replace(PAPER, effects=(*PAPER.effects, effects.shunt(m=1, name="hand")))
    assert more.knobs["hand.m"].path == "effects.hand.m"
    assert more.knobs["m_hand"].value == Integer(1)
    held = Scene(environments.kelvin_voigt(100, 3), (LAG, effects.shunt(k=1)), hands=(hs.hands["light-touch"],))
    assert "does not change what is felt" in refusal(held.knobs["hand.m"].felt)
    assert held.knobs["hand.m"] is held.knobs["hands.light-touch.m"]
    assert [x.path for x in held.with_values({"evaluation.jnd.real": 0.2}).knobs.limits.values()] == [
        "evaluation.jnd.real",
        "evaluation.jnd.imag",
    ]
    assert Scene(environments.expression("q*s", parameters={"q": 1})).knobs["q"].unit == "SI"
    rotating = Scene(environments.kelvin_voigt("1 N*m/rad", 2))
    assert "the scene rotational" in refusal(rotating.knobs["b"].number, "1 N*s/m")
    assert rotating.knobs["b"].number("1 N*m*s/rad") == 1


def test_symbols_of_a_scene_are_told_apart_by_what_they_are_of() -> None:
    lags = (effects.first_order_lag(20, name="a-b"), effects.first_order_lag(30, name="c"), effects.shunt(k=3))
    own = Scene(environments.kelvin_voigt(100, 3), lags, rendered=environments.kelvin_voigt(90, 3))
    names = [p.symbol.name for p in own.parameters]
    assert len(set(names)) == len(names)
    assert names[:4] == ["k", "b", "k_rendered", "b_rendered"]
    assert {"omega_c_a_b", "omega_c_c", "k_shunt"} <= set(names)
    damped = Scene(environments.expression("c*s + 5", parameters={"c": 3}))
    assert [p.symbol.name for p in damped.parameters] == ["c_env"]
    assert own.knobs["rendered.k"].path == "rendered.k"


# --- one parameter in two places -------------------------------------------------------------------------------------

WALL = """
[environment]
model = "kelvin-voigt"
k = "500 N/m +- 5 %"
b = "3 N*s/m"

[rendered]
model = "expression"
H = "k + b*s*w/(s + w)"
parameters = { k = "environment.k", b = "environment.b", w = "50 Hz" }

[evaluation]
band = ["0 rad/s", "120 rad/s"]
"""

k, b, w, omega, c = Symbol("k", positive=True), Rational(3), 100 * pi, Symbol("omega", positive=True), Rational(1, 10)

EXCESS = (b * omega**2 * w / (omega**2 + w**2)) ** 2 - c**2 * (k**2 + (b * omega) ** 2)


def wall() -> hs.Scene:
    return hs.parse_scene(WALL)


def ties(scene: hs.Scene) -> dict[str, str]:
    """From the path of what refers to a parameter to that parameter's own."""
    return {other: x.path for x in scene.knobs for other in x.also}


def crossing(stiffness: int | Expr) -> float:
    """The frequency at which r_r of that wall meets its threshold, from the quadratic in omega^2 by hand."""
    x = Symbol("x", positive=True)
    quartic = (b * x * w) ** 2 - c**2 * (stiffness**2 + b**2 * x) * (x + w**2) ** 2
    roots = [float(r) for r in quartic.as_poly(x).nroots() if abs(complex(r).imag) < 1e-9 and complex(r).real > 0]
    return float(sqrt(min(roots)))


def test_one_symbol_stands_in_both_dynamics() -> None:
    scene = wall()
    assert scene.rendered is not None
    assert [p.symbol.name for p in scene.parameters] == ["k", "b", "w"]
    assert {x.name for x in scene.environment.dynamics.free_symbols} == {"s", "k", "b"}
    assert {x.name for x in scene.rendered.dynamics.free_symbols} == {"s", "k", "b", "w"}
    assert ties(scene) == {"rendered.k": "environment.k", "rendered.b": "environment.b"}
    d = scene.symbolic_distortion()
    assert not {x.name for x in d.real.free_symbols} & {"k"}  # it cancels from dH


def test_values_move_together() -> None:
    moved = wall().with_values({"k": 600, "b": "4 N*s/m"})
    assert moved.rendered is not None
    assert 600 + 4 * hs.s * w / (hs.s + w) == moved.rendered.H
    assert moved.with_band(0, 10).rendered == moved.rendered
    assert ties(moved) == ties(wall())


@pytest.mark.slow
def test_a_requirement_moves_both() -> None:
    # the least k at which r_r = c at the high end W: (b W^2 w/(W^2 + w^2))^2/c^2 - b^2 W^2
    W = Rational(120)
    least = sqrt((b * W**2 * w / (W**2 + w**2)) ** 2 / c**2 - (b * W) ** 2)
    [span] = hs.require(wall(), "environment.k").feasible
    assert span.low is not None
    assert span.low.digits(15) == str(least.evalf(15))
    assert hs.require(wall(), "k").to_json() == hs.require(wall(), "environment.k").to_json()


def test_a_sensitivity_is_that_of_both() -> None:
    scene = wall()
    [at] = [x.omega for x in hs.evaluate(scene).crossings]
    [found] = hs.sensitivity(scene).crossings
    slope = -(diff(EXCESS, k) / diff(EXCESS, omega)).subs({k: 500, omega: float(at)})
    assert [p.path for p in found.parameters] == ["environment.k", "environment.b", "rendered.w", "evaluation.jnd"]
    assert float(found["k"].derivative) == pytest.approx(float(slope), rel=1e-12)


def test_a_tolerance_is_that_of_both() -> None:
    found = hs.tolerances(wall(), samples=0)
    assert [side.name for side in found.box.sides] == ["k"]
    [x] = found.enclosures
    assert (float(x.low), float(x.high)) == pytest.approx((crossing(475), crossing(525)), rel=1e-12)
    assert x.count == 1


@pytest.mark.slow
def test_a_sweep_moves_both() -> None:
    found = hs.sweep(wall(), {"environment.k": [400.0, 600.0]}).first_crossing_real
    assert found.values.tolist() == pytest.approx([crossing(400), crossing(600)], rel=1e-9)


@pytest.mark.slow
def test_a_map_moves_both() -> None:
    found = hs.design_map(wall(), ["rendered.w", "environment.k"], [("40 Hz", "60 Hz"), (100, 9000)], slices=2)
    W = Rational(120)
    for x in found.slices:
        least = sqrt((b * W**2 * x.at / (W**2 + x.at**2)) ** 2 / c**2 - (b * W) ** 2)
        assert x.requirement.feasible[0].low.digits(12) == str(least.evalf(12))  # type: ignore[union-attr]


@pytest.mark.slow
@pytest.mark.parametrize("key", ["k", "b"])
def test_what_refers_to_another_is_that_other(key: str) -> None:
    path, other = f"rendered.{key}", f"environment.{key}"
    assert hs.require(wall(), path, (1, 900)).to_json() == hs.require(wall(), other, (1, 900)).to_json()
    assert hs.sweep(wall(), {path: [1.0]}).identical(hs.sweep(wall(), {other: [1.0]}))
    assert wall().with_values({path: 7}) == wall().with_values({other: 7})
    with pytest.raises(hs.SceneError, match=f"{other} is given twice"):
        wall().with_values({path: 7, other: 7})


def test_shipped_scenes_tie_what_they_repeat() -> None:
    for name in hs.scene_names():
        assert not hs.load_scene(name).untied(), name
    for name in hs.family_names():
        assert not any(scene.untied() for scene in hs.load_scenes(name).scenes.values())
    assert set(ties(hs.load_scene("sampled-wall"))) == {"rendered.k", "rendered.b"}
    assert set(ties(hs.load_scene("steering-wheel"))) == {"rendered.m", "rendered.b", "rendered.k"}


def test_names_may_cross() -> None:
    scene = hs.Scene(
        environments.kelvin_voigt(500, 3),
        (effects.shunt(k=7),),
        rendered=environments.expression("k*s + b", parameters={"k": "environment.b", "b": "environment.k"}),
    )
    assert scene.rendered is not None
    assert scene.rendered.H == scene.environment.H
    assert scene.rendered.dynamics == scene.environment.dynamics
    assert [p.symbol.name for p in scene.parameters] == ["k", "b", "k_shunt"]


@pytest.mark.parametrize("own", ["kelvin-voigt", "expression"])  # whose b is positive, and whose b is any number
def test_a_name_of_its_own_stays_apart_from_the_environment_s(own: str) -> None:
    felt = (
        environments.kelvin_voigt(500, 3)
        if own == "kelvin-voigt"
        else environments.expression("b*s", parameters={"b": 3})
    )
    given = {"k": "environment.b", "b": 4, "b_rendered": 5}
    rendered = environments.expression("k*s + b + b_rendered/s", parameters=given)
    scene = replace(hs.Scene(felt, rendered=rendered), title="again")
    assert scene.rendered is not None
    assert 3 * hs.s + 4 + 5 / hs.s == scene.rendered.H
    assert len({p.symbol.name for p in scene.parameters}) == len(scene.parameters) == len(felt.parameters) + 2


def test_the_stricter_rule_holds_for_both() -> None:
    # a spring of the environment may be 0, one in series with a damper may not
    scene = hs.Scene(
        environments.mass_spring_damper(m=1, k=5), rendered=environments.maxwell("environment.k", 1000), band=(0, 1)
    )
    assert [p.rule.name for p in scene.parameters] == ["NONNEGATIVE", "POSITIVE", "POSITIVE"]
    with pytest.raises(hs.SceneError, match='k: "0" must be > 0'):
        scene.with_values({"k": 0})
    assert not hs.require(scene, "environment.k").domain.holds_low


def test_another_environment_is_another_value() -> None:
    scene = wall()
    moved = replace(scene, environment=environments.kelvin_voigt(9, 2))
    assert moved.rendered is not None
    assert 9 + 2 * hs.s * w / (hs.s + w) == moved.rendered.H
    with pytest.raises(hs.SceneError, match=r'rendered: k: "environment.k" is no parameter .*environment.k0'):
        replace(scene, environment=environments.zener(9, 2, 1))


def test_a_symbol_of_the_user_s_comes_along() -> None:
    stiff = Symbol("stiff", positive=True)
    rendered = environments.kelvin_voigt("environment.k", 4)
    assert hs.distort(environments.kelvin_voigt(stiff, 3), rendered=rendered).perceived == 4 * hs.s + stiff
    assert hs.distort(environments.kelvin_voigt(stiff, 3), rendered=rendered).distortion == hs.s


FAMILY = """
[[environments]]
name = "soft"
model = "kelvin-voigt"
k = 100
b = 2
rendered = { model = "kelvin-voigt", k = "environment.k", b = 1 }

[[environments]]
name = "hard"
model = "zener"
k0 = 700
k1 = 10
b1 = 2
rendered = { model = "kelvin-voigt", k = "environment.k0", b = 1 }
"""


def test_each_of_several_environments_has_its_own_values(tmp_path: Path) -> None:
    family = hs.parse_scenes(FAMILY)
    assert [x.rendered.H for x in family.scenes.values()] == [hs.s + 100, hs.s + 700]  # type: ignore[union-attr]
    path = tmp_path / "family.toml"
    path.write_text(FAMILY)
    others = hs.load_scenes("sampled-wall", [path])  # the environments, and what is rendered for them, of a file
    assert [x.rendered.H for x in others.scenes.values()] == [hs.s + 100, hs.s + 700]  # type: ignore[union-attr]
    assert all(ties(x) for x in others.scenes.values())
    with pytest.raises(hs.SceneError, match=r'environments\[2\] "hard": rendered: k: "environment.k" is no parameter'):
        hs.parse_scenes(FAMILY.replace("environment.k0", "environment.k"))


def test_a_copy_of_a_scene_and_a_range_of_it_keep_the_tie() -> None:
    scene = wall()
    assert pickle.loads(pickle.dumps(replace(scene))) == replace(scene) == scene
    assert hs.evaluate(replace(scene)).to_json() == hs.evaluate(scene).to_json()
    assert scene.rendered.parameters[0].interval == (475, 525)  # type: ignore[union-attr]


def test_what_environment_and_rendered_have_by_one_name_is_told_as_two() -> None:
    own = Scene(environments.kelvin_voigt(100, 3), (LAG,), rendered=environments.mass_spring_damper(k=90, b=2, m=1))
    assert own.untied() == (("environment.k", "rendered.k"), ("environment.b", "rendered.b"))
    assert own.untied(["rendered.b"]) == (("environment.b", "rendered.b"),)
    assert own.untied(["effects.first-order-lag.omega_c"]) == ()
    assert own.untied_note([]) == ""
    for note, pairs in ((own.untied_note(["environment.k"]), ["k"]), (own.untied_note(), ["k", "b"])):
        assert all(f"environment.{x} and rendered.{x}" in note and f'{x} = "environment.{x}"' in note for x in pairs)


TWICE = WALL.replace('k = "500 N/m +- 5 %"\nb = "3 N*s/m"', 'k = 500\nb = "3 N*s/m +- 1 %"').replace(
    '{ k = "environment.k"', "{ k = 500"
)
PAIR = [["environment.k", "rendered.k"]]

ASKED: dict[str, tuple[Callable[[hs.Scene], Any], bool]] = {
    "require environment.k": (lambda x: hs.require(x, "environment.k"), True),
    "require rendered.k": (lambda x: hs.require(x, "rendered.k"), True),
    "require environment.b": (lambda x: hs.require(x, "environment.b"), False),
    "map with k": (lambda x: hs.design_map(x, ["rendered.w", "k"], [(300, 400), (100, 900)], slices=2), True),
    "map without k": (lambda x: hs.design_map(x, ["rendered.w", "b"], [(300, 400), (1, 9)], slices=2), False),
    "sensitivity": (hs.sensitivity, True),
    "tolerances of b": (lambda x: hs.tolerances(x, samples=0), False),
}


@pytest.mark.few("sensitivity", "tolerances of b")
@pytest.mark.parametrize("what", ASKED)
def test_what_varies_one_of_two_parameters_of_a_name_says_so(what: str) -> None:
    ask, told = ASKED[what]
    found = ask(hs.parse_scene(TWICE))
    assert found.to_dict().get("untied") == (PAIR if told else None)
    assert ("are two parameters" in str(found)) == told


# --- what is said beside an answer -----------------------------------------------------------------------------------

RANGES = """
[environment]
model = "kelvin-voigt"
k = "100 N/m +- 5 %"
b = ["4.8 N*s/m", "7.2 N*s/m"]

[[effects]]
name = "lag"
model = "first-order-lag"
omega_c = "20 rad/s +- 1 rad/s"

[evaluation]
band = ["0 rad/s", "15 rad/s"]
jnd = "0.1 +- 10 %"
"""

PLAIN = (
    RANGES.replace(" +- 5 %", "")
    .replace('["4.8 N*s/m", "7.2 N*s/m"]', "6")
    .replace(" +- 1 rad/s", "")
    .replace(" +- 10 %", "")
)

EVERY = {
    "environment.k": [95.0, 105.0],
    "environment.b": [4.8, 7.2],
    "effects.lag.omega_c": [19.0, 21.0],
    "evaluation.jnd": [0.09, 0.11],
}

VERBS: dict[str, Callable[[Scene], Any]] = {
    "evaluate": hs.evaluate, "relevance": hs.relevance, "sensitivity": hs.sensitivity, "metrics": hs.metrics, "stability": lambda x: hs.stability(x, "postural-arm"),
    "sweep": lambda x: hs.sweep(x, {"environment.k": [50.0]}).attrs,
}  # fmt: skip


@pytest.mark.dear("sensitivity", "stability")
@pytest.mark.few("evaluate", "sensitivity", "stability")
@pytest.mark.parametrize("verb", [x for x in VERBS if x != "sweep"])
def test_verbs_that_take_the_nominal_values_say_so(verb: str) -> None:
    for text, ranges in ((RANGES, EVERY), (PLAIN, None)):
        found = VERBS[verb](hs.parse_scene(text))
        assert found.to_dict().get("nominal") == ranges
        assert (" ".join(str(found).split()).count("this is the nominal scene") == 1) == bool(ranges)


FREE: list[tuple[tuple[str, ...], set[str]]] = [
    (("environment.k",), {"environment.k"}), (("omega_c",), {"effects.lag.omega_c"}), (("evaluation.jnd",), {"evaluation.jnd"}), (("k", "c"), {"environment.k", "evaluation.jnd"}),
]  # fmt: skip


@pytest.mark.dear("free0-besides0", "free2-besides2")
@pytest.mark.few(3)
@pytest.mark.parametrize(("free", "besides"), FREE)
def test_a_requirement_says_what_is_nominal_but_for_what_it_is_about(free: tuple[str, ...], besides: set[str]) -> None:
    scene = hs.parse_scene(RANGES)
    found = (
        hs.require(scene, *free) if len(free) == 1 else hs.design_map(scene, free, [(50, 200), (0.05, 0.5)], slices=3)
    )
    assert found.to_dict()["nominal"] == {path: x for path, x in EVERY.items() if path not in besides}


def test_one_threshold_that_is_free_leaves_the_other_nominal() -> None:
    found = hs.require(hs.parse_scene(RANGES), "evaluation.jnd.real").to_dict()
    assert set(found["nominal"]) == {*EVERY, "evaluation.jnd.imag"} - {"evaluation.jnd"}
    two = hs.parse_scene(PLAIN.replace('jnd = "0.1"', 'jnd = { real = "0.1 +- 10 %", imag = "0.2 +- 5 %" }'))
    assert hs.evaluate(two).to_dict()["nominal"] == {
        "evaluation.jnd.real": [0.09, 0.11],
        "evaluation.jnd.imag": [0.19, 0.21],
    }
    assert "nominal" not in hs.require(two, "evaluation.jnd").to_dict()
    assert set(hs.require(two, "evaluation.jnd.imag").to_dict()["nominal"]) == {"evaluation.jnd.real"}


def test_what_was_left_out_was_nominal_too() -> None:
    more = RANGES + '\n[[effects]]\nname = "cable"\nmodel = "first-order-lag"\nomega_c = "9 Mrad/s +- 10 %"\n'
    found = hs.evaluate(hs.parse_scene(more), tolerance=0.001)
    assert [effect.name for effect in found.scene.effects] == ["lag"]
    assert found.to_dict()["nominal"].keys() == {*EVERY, "effects.cable.omega_c"}


def test_what_is_nominal_is_said_of_the_scenes_of_a_family_in_which_it_varies() -> None:
    def asides(*scenes: Scene) -> list[str]:
        return [x.partition(" var")[0] for x in SceneFamily({f"e{i}": x for i, x in enumerate(scenes)}).asides()]

    assert asides(soft(), soft(200)) == []
    assert asides(soft([90, 110]), soft()) == ["e0: k"]
    assert asides(soft([90, 110]), soft([90, 110]), soft(3)) == ["e0, e1: k"]
    assert asides(soft([90, 110]), soft([90, 110])) == ["k"]
    lag = effects.first_order_lag([10, 30])
    assert asides(soft(1, lag), soft(2, lag)) == ["omega_c"]
    keys = SceneFamily({"a": soft([90, 110]), "b": soft(100)}).aside_keys()
    assert keys == {"nominal": {"a": {"environment.k": [90.0, 110.0]}}}
    assert SceneFamily({"a": soft()}).aside_keys() == {}


def test_what_is_nominal_is_said_in_a_sentence_for_each_width() -> None:
    def note(jnd: Any, *besides: str, **keys: Any) -> str:
        values = {"k": "100 N/m +- 5 %", "b": "3 N*s/m +- 5 %"} | keys
        return Scene(
            environments.kelvin_voigt(**values), (effects.first_order_lag([10, 30]),), (0, 15), jnd
        ).nominal_but(besides)

    assert (
        note(0.1) == "k, b vary by 5 %; omega_c varies by 50 %: this is the nominal scene; see `haptisym tolerances`."
    )
    assert (
        note(0.1, "k")
        == "b varies by 5 %; omega_c varies by 50 %: these are the nominal values; see `haptisym tolerances`."
    )
    assert (
        note([0.1, 0.3], k=1, b=[0, 2])
        == "b varies from 0 to 2 N·s/m; omega_c, c vary by 50 %: this is the nominal scene; see `haptisym tolerances`."
    )
    assert (
        note([0.1, 0.3], "evaluation.jnd", k=1, b=2)
        == "omega_c varies by 50 %: these are the nominal values; see `haptisym tolerances`."
    )
    own = {"real": {"higher": 0.1, "lower": [0.1, 0.2]}, "imag": 0.1}
    assert note(own, k=1, b=2) == (
        "omega_c varies by 50 %; real.lower of the JND varies from 0.1 to 0.2: this is the nominal scene; `haptisym evaluate` prints which bandwidths the JND gives."
    )
    assert note(0.1, "effects.first-order-lag.omega_c", k=1, b=2) == ""
    two = Scene(environments.kelvin_voigt(1, 2), (), (0, 15), {"real": [0.1, 0.2], "imag": 0.1})
    assert list(two.ranges()) == ["evaluation.jnd.real"]
    assert two.ranges(["evaluation.jnd.real"]) == {}
    assert list(Scene(environments.kelvin_voigt(1, 2), (), (0, 15), [0.1, 0.2]).ranges(["evaluation.jnd.real"])) == [
        "evaluation.jnd.imag"
    ]


HOLD = effects.zero_order_hold("1/50 s", name="sampler")
SOFT = environments.kelvin_voigt(200, 2)


@pytest.mark.parametrize(
    ("between", "band", "jnd", "starts"),
    [
        ((), (0, 15), "99.9 %", []), ((), (0, 15), 1, ["The threshold of the real and the imaginary part is 100 %"]),
        ((), (0, 15), {"real": 0.5, "imag": 12}, ["The threshold of the imaginary part is 1200 %"]), ((), (0, 15), {"shape": "polygon", "corners": [[2, 0], [0, 2], [-2, -2]]}, []),
        ((HOLD,), (0, 150), 0.1, ["sampled (sampler)"]), ((HOLD,), (0, "25 Hz"), 0.1, ["sampled (sampler)"]),
        ((HOLD,), (0, "25.01 Hz"), 0.1, ["The band exceeds 25 Hz, the Nyquist frequency of sampler", "sampled (sampler)"]),
        ((HOLD, LAG), (0, 15), 0.1, ["sampled (sampler)"]),
        ((HOLD, LAG, effects.compliance(k=9)), (0, 15), 0.1, ["sampler holds a force that compliance returns", "sampled (sampler)"]),
        ((effects.compliance(k=9), HOLD), (0, 15), 0.1, ["sampled (sampler)"]),
        ((HOLD, effects.zero_order_hold("1 ms", name="b")), (0, 15), 0.1, ["sampler holds a force that b returns", "sampled (sampler, b)"]),
        ((effects.sampled_loop("1/50 s", "tustin", name="loop"),), (0, 158), 2, ["The threshold of the real and the imaginary part is 200 %", "The band exceeds", "sampled (loop)"]),
    ],
)  # fmt: skip
def test_what_a_scene_stands_for_beyond_its_formulas_is_said_from_its_limit_on(
    between: Any, band: Any, jnd: Any, starts: list[str]
) -> None:
    own = Scene(SOFT, between, band, jnd)
    told = caveats(own)
    assert len(told) == len(starts)
    assert all(any(x.startswith(start) for x in told) for start in starts)
    assert clocks(own) == tuple(
        e.parameters[0].value for e in between if e.model in ("zero-order-hold", "sampled-loop")
    )


@pytest.mark.parametrize(
    ("between", "loop"),
    [
        ((HOLD,), False),
        ((effects.compliance(k=5000), HOLD), False),  # it yields on the environment's side of the clock
        ((HOLD, effects.shunt(m="0.1 kg"), effects.first_order_lag(200)), False),
        ((HOLD, effects.compliance(k=5000)), True),
        ((HOLD, effects.first_order_lag(200), effects.compliance(k=5000)), True),
        ((HOLD, effects.zero_order_hold("3 ms", name="second")), True),
    ],
)
def test_a_hold_is_in_a_loop_where_what_it_holds_comes_back_to_a_clock(
    between: tuple[hs.Effect, ...],
    loop: bool,  # noqa: FBT001
) -> None:
    found = hs.evaluate(Scene(SOFT, between))
    assert (sampled_loop(found.scene) is not None) == loop
    assert any("returns to a sampler" in x for x in found.caveats) == loop
    assert (found.stable is None) == loop


def test_a_sampled_loop_that_diverges_is_not_called_stable() -> None:
    """The closed form's poles are all in the left half plane; the simulation, which samples, grows without bound."""
    inertia = environments.mass_spring_damper("0.5 kg", "10 N*s/m", "300 N/m")
    behind = effects.first_order_lag(200), effects.compliance(k=500, b=2)
    sampled = hs.Scene(inertia, (effects.zero_order_hold("4 ms"), *behind))
    assert hs.evaluate(sampled).stable is None
    with pytest.raises(hs.HaptisymError, match="grows without bound .* not stable"):
        hs.simulate(sampled, hs.sine("1 mm", "3 rad/s"))


STIFF = hs.Scene(
    environments.mass_spring_damper(k="50 kN/m"),
    (effects.zero_order_hold("1 ms", name="clock"), effects.shunt(m="45 g", name="device")),
    ("0 Hz", "100 Hz"),
)
"""A stiff wall behind a clock and a light device."""


def growth_in_a_hand() -> float:
    """By how much the sampled loop of that wall grows each millisecond in a hand of 0.1 kg, 2 N s/m and 50 N/m.

    Between samples the moving mass, 0.145 kg, obeys M x'' + b x' + k x = -F with the force F = 50 kN/m x held: the exact
    solution of that over one period is a matrix, and the loop grows by its largest eigenvalue.
    """
    M, b, k, wall, T = (mpmath.mpf(x) for x in ("0.145", "2", "50", "50000", "0.001"))
    free = mpmath.matrix([[0, 1, 0], [-k / M, -b / M, -1 / M], [0, 0, 0]])  # position, speed, force held
    step = mpmath.expm(free * T) * mpmath.matrix([[1, 0, 0], [0, 1, 0], [wall, 0, 0]])
    eigenvalues, _ = mpmath.eig(step)
    return float(max(abs(x) for x in eigenvalues))


@pytest.mark.slow
def test_a_wall_that_grows_in_a_hand_is_called_stable_under_imposed_motion_only() -> None:
    assert growth_in_a_hand() == pytest.approx(1.076, abs=5e-4)
    found = hs.evaluate(STIFF)
    assert found.stable is True
    assert "for prescribed motion; a hand closes the loop" in " ".join(found.caveats)
    (held,) = hs.stability(STIFF, Hand("this one", "0.1 kg", "2 N*s/m", "50 N/m")).held
    assert held.stable is False


ROWS = [(0.5, 798.0817, -0.04336184), (1, 792.3286, -0.0768005), (12, 659.1, 5.25), (20, 820.5, 81.0)]


def verdicts(path: Path) -> list[tuple[str, str]]:
    return [(x.real.value, x.imag.value) for x in hs.evaluate(path).rows]


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_a_comma_that_does_not_separate_cells_stands_before_decimals(tmp_path: Path, delimiter: str) -> None:
    header = ["frequency_hz", "magnitude", "phase_deg"]
    tables = {
        "point": "\n".join([",".join(header), *(",".join(map(str, x)) for x in ROWS)]),
        "comma": "\n".join([delimiter.join(header), *(delimiter.join(map(str, x)).replace(".", ",") for x in ROWS)]),
    }
    found = {}
    for name, table in tables.items():
        (folder := tmp_path / name).mkdir()
        found[name] = hs.measured(bench(folder, table).parent / "bench.csv")
    assert (found["comma"].omega == found["point"].omega).all()
    assert (found["comma"].H == found["point"].H).all()


def test_a_radius_without_a_unit_has_that_of_h_beside_it(tmp_path: Path) -> None:
    """0.04 N/mm are 40 N/m: of |100 - 1.8 w^2 + 15 j w| at 2, 5 and 8 rad/s 0.41, 0.43 and 0.33."""
    rows = "2,0.0931,0.0294,0.04\n5,0.0551,0.0702,0.04\n8,-0.0209,0.1195,0.04\n"
    for header in ("omega,real [N/mm],imag [N/mm],radius\n", "omega,real,imag,radius\nrad/s,N/mm,N/mm,\n"):
        found = hs.evaluate(bench(tmp_path, header + rows))
        assert [round(x.radius, 2) for x in found.rows] == [0.41, 0.43, 0.33]
        assert {(x.real.value, x.imag.value) for x in found.rows} == {("unresolved", "unresolved")}


def test_a_column_without_a_unit_beside_one_that_has_one_is_asked_about(tmp_path: Path) -> None:
    with pytest.raises(hs.SceneError, match=r"imag has no unit, and real has N/mm: write imag \[N/mm\]"):
        hs.evaluate(bench(tmp_path, "omega,real [N/mm],imag\n2,0.09,0.03\n"))


def test_a_response_that_is_there_twice_is_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "both.mat"
    savemat(path, {"omega": [1.0, 2.0], "H": [1 + 1j, 2 + 1j], "real": [1.0, 2.0], "imag": [1.0, 1.0]})
    with pytest.raises(hs.SceneError, match="the response is there twice"):
        hs.measured(path)


def test_a_coherence_that_rounding_put_above_1_is_1() -> None:
    found = hs.measured([1, 2], [1 + 1j, 2 + 1j], coherence=[1 + 2**-52, 0.9], averages=10)
    assert found.coherence.tolist() == [1, 0.9]
    with pytest.raises(hs.SceneError, match="coherence: 1.01 must lie from 0 to 1"):
        hs.measured([1, 2], [1 + 1j, 2 + 1j], coherence=[1.01, 0.9], averages=10)


@pytest.mark.parametrize("sign", ["+-", "±", "+/-"])
def test_per_cent_of_per_cent_is_asked_about_with_both_readings(sign: str) -> None:
    text = '[environment]\nmodel = "kelvin-voigt"\nk = 100\nb = 2\n[evaluation]\nband = [0, 15]\n'
    with pytest.raises(hs.SceneError) as told:
        hs.parse_scene(text + f'jnd = "8 % {sign} 4 %"\n')
    assert '["4 %", "8 %", "12 %"]' in str(told.value)
    assert '["7.68 %", "8 %", "8.32 %"]' in str(told.value)
    scene = hs.parse_scene(text + 'jnd = ["4 %", "8 %", "12 %"]\n')
    assert [float(x) for x in scene.knobs["evaluation.jnd"].interval] == [0.04, 0.12]


def test_a_negative_stiffness_is_refused_with_the_way_out_and_answered_on_it() -> None:
    scene = """
[environment]
model = "{}"
[[effects]]
model = "first-order-lag"
omega_c = "500 Hz"
[evaluation]
band = ["0 Hz", "100 Hz"]
"""
    with pytest.raises(hs.SceneError, match="needs k >= 0 .*-100000 N/m.*expression.*shunt"):
        hs.parse_scene(scene.format('mass-spring-damper"\nm = "2 kg"\nk = "-100000 N/m'))
    way = 'expression"\nH = "m*s^2 + k"\nparameters = { m = "2 kg", k = "-100000 N/m" }\ntitle = "'
    found = hs.evaluate(hs.parse_scene(scene.format(way).replace('title = ""\n', "")))
    assert [(x.part.value, x.omega.digits(15)) for x in found.crossings] == [("imag", "317.365306006597")]


def test_lines_at_the_ends_of_a_band_are_in(tmp_path: Path) -> None:
    omega = 2 * np.pi * np.array([1.0, 5.0, 10.0])
    table = "omega,real,imag\n" + "".join(f"{w!r},{100.0},{5.0}\n" for w in omega.tolist())
    path = bench(tmp_path, table)
    path.write_text(path.read_text() + '\n[evaluation]\nband = ["1 Hz", "10 Hz"]\n', encoding="utf-8")
    assert len(verdicts(path)) == 3


def test_what_was_meant_is_named_where_another_was_written() -> None:
    with pytest.raises(hs.SceneError, match='did you mean "kHz"'):
        hs.effects.first_order_lag("1 khz")
    with pytest.raises(hs.SceneError, match='needs b .*model = "mass-spring-damper" with k only'):
        hs.environments.kelvin_voigt(k=100)
    spring = hs.environments.mass_spring_damper(k=Symbol("k"))
    function = hs.distort(spring, hs.effects.first_order_lag(20)).compile()
    with pytest.raises(hs.SceneError, match="omega: give real frequencies"):
        function([1 + 2j], k=1)
    with pytest.raises(hs.SceneError, match="k: give real numbers"):
        function([1], k=1j)


SCENE = """
title = "soft tissue"
[environment]
model = "kelvin-voigt"
k = "200 N/m"
b = "4 N*s/m"
[device]
{}
"""


def test_a_scene_with_a_device_is_the_scene_with_its_mass_damping_and_friction_written_out() -> None:
    by_name = hs.parse_scene(SCENE.format('like = "one-axis"\namplitude = "5 cm"'))
    effects = (
        hs.effects.shunt(m="0.032 kg", b="3.62 N*s/m", name="device"),
        hs.effects.coulomb_friction("0.024 N", "5 cm", name="device-friction"),
    )
    assert by_name.effects == hs.Scene(by_name.environment, effects).effects
    assert hs.parse_scene(SCENE.format('like = "one-axis"')).effects[0].name == "device"


def test_what_a_scene_writes_goes_before_what_was_read() -> None:
    scene = hs.parse_scene(SCENE.format('like = "touch"\nm = "45 g"'))
    assert [x.value for x in scene.effects[0].parameters if x.key == "m"] == [hs.parse_scene(
        SCENE.format('like = "one-axis"\nm = "0.045 kg"')
    ).effects[0].parameters[0].value]  # fmt: skip


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('like = "tuch"', 'unknown device "tuch": did you mean "touch"'),
        ('like = "touch"', 'touch: neither mass nor damping was read: give them, as m = "45 g"'),
        ('like = "phri-master"\namplitude = "1 cm"', "its friction was not read: give it"),
        ('m = "1 kg"', "like is missing: give the name of a device"),
        ('like = "one-axis"\nmass = "1 kg"', 'unknown key "mass"'),
        ('like = "one-axis"\nm = "3 N"', 'm: "3 N" is not a mass'),
        ("like = 3", 'unknown device "3"'),
    ],
)
def test_what_a_device_may_not_be_is_refused_with_the_way_out(table: str, words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(SCENE.format(table))
    assert words in str(error.value)


def test_every_number_has_a_source_and_says_how_far_that_was_read() -> None:
    assert len(hs.devices) >= 15
    for device in hs.devices.values():
        assert device
        for number in device.values():
            assert number.value > 0
            assert len(number.source) > 20
            assert number.read
            assert "recalled" not in number.source + number.read


def test_a_number_that_was_not_read_is_not_there() -> None:
    assert "m" not in hs.devices["touch"]
    with pytest.raises(hs.SceneError, match="its m was not read; known are force, stiffness, damping"):
        hs.devices["touch"]["m"]


@pytest.mark.parametrize("name", [*hs.scene_names(), *hs.family_names()])
def test_a_shipped_scene_whose_numbers_are_illustrative_says_so_in_its_title(name: str) -> None:
    scenes = hs.load_scenes(name)
    is_so = "illustrative" in scenes.source or "recalled" in scenes.source
    assert is_so is scenes.title.endswith("(illustrative)")


def test_at_most_five_shipped_scenes_are_illustrative() -> None:
    titles = [hs.load_scenes(x).title for x in (*hs.scene_names(), *hs.family_names())]
    assert sum(x.endswith("(illustrative)") for x in titles) <= 5


def test_a_page_with_a_describing_function_says_what_that_leaves_out() -> None:
    assert "backlash: by the describing function" in " ".join(str(hs.evaluate("geared-arm")).split())
    assert "describing function" not in str(hs.evaluate("fu2019"))


def test_a_verdict_on_an_element_that_is_not_linear_is_one_on_its_linear_model() -> None:
    """A force that is cut off can give energy: no proof about its first harmonic makes the display passive."""
    cut = hs.effects.saturation("5 N", "8 N")
    hand = hs.Hand("own", m="0.5 kg", b="5 N*s/m", k="100 N/m")
    scene = hs.Scene(hs.environments.mass_spring_damper(1, 10, 100), [cut], hands=[hand])
    held = hs.stability(scene, limit=20)
    for page in (hs.evaluate(scene), held, hs.compare(scene, "fu2019")):
        assert "of the linear model at this amplitude" in " ".join(str(page).split())
    assert held.to_dict()["caveats"] == list(hs.evaluate(scene).caveats)
    assert "linear model" not in str(hs.evaluate("stick-with-friction"))


def test_the_sizes_of_a_describing_function_can_be_set_but_not_varied() -> None:
    scene = hs.load_scene("geared-arm")
    assert "gap: a number of a describing function" in refusal(hs.require, scene, "gap", that=["transparent"])
    assert "gap: a number of a describing function" in refusal(hs.sweep, scene, {"effects.backlash.gap": [0.1, 0.2]})
    hand = hs.Hand("own", m="1 kg*m^2", b="1 N*m*s/rad")
    assert "gap: a size in a describing function" in refusal(hs.stability, scene, hand, free=["gap"])
    wider = scene.with_values({"gap": "60 deg"})
    assert hs.evaluate(wider).scene.effects[0].matrix[0] != scene.effects[0].matrix[0]
    shown = {x.knob.key for x in hs.sensitivity("wheel-with-encoder").crossings[0].parameters}
    assert {"k", "b", "T", "m"} <= shown
    assert {"q", "amplitude"}.isdisjoint(shown)
