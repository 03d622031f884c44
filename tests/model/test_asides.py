"""Answers for nominal values say so, and so do those about one of two parameters that have one name: in every output."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pdflatex import set_document
from reports import undrawn

import haptisym as hs

Call = Callable[..., tuple[int, str, str]]

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
NOTE = (
    "k, omega_c vary by 5 %; b varies by 20 %; c varies by 10 %: this is the nominal scene; see `haptisym tolerances`."
)


@pytest.fixture
def scenes(tmp_path: Path) -> tuple[str, str]:
    """The files of a scene with ranges and of the same without."""
    for name, text in (("ranges", RANGES), ("plain", PLAIN)):
        (tmp_path / f"{name}.toml").write_text(text)
    return str(tmp_path / "ranges.toml"), str(tmp_path / "plain.toml")


def flat(text: str) -> str:
    """A page in one line, without the signs of comments."""
    return " ".join(text.replace("\n# ", " ").replace("\n * ", " ").split())


VERBS: dict[str, tuple[str, ...]] = {
    "evaluate": (),
    "effects": (),
    "sensitivity": (),
    "metrics": (),
    "stability": ("--hand", "postural-arm"),
    "derive": ("--numeric",),
    "cost": ("--quick",),
    "simulate": ("--amplitude", "1 mm", "--omega", "3 rad/s"),
}


@pytest.mark.few("evaluate", "effects", "stability")
@pytest.mark.parametrize("verb", VERBS)
def test_verbs_that_take_the_nominal_values_say_so(verb: str, call: Call, scenes: tuple[str, str]) -> None:
    for file, note, ranges in zip(scenes, (NOTE, None), (EVERY, None), strict=True):
        status, out, _ = call(verb, file, *VERBS[verb])
        assert status == 0
        assert ("nominal" in out) == bool(note)
        assert note is None or flat(out).count(note) == 1
        _, out, _ = call(verb, file, *VERBS[verb], "--json")
        assert json.loads(out).get("nominal") == ranges


FREE: list[tuple[tuple[str, ...], set[str], str]] = [
    (("environment.k",), {"environment.k"}, "b varies by 20 %; omega_c varies by 5 %; c varies by 10 %"),
    (("omega_c",), {"effects.lag.omega_c"}, "k varies by 5 %; b varies by 20 %; c varies by 10 %"),
    (("evaluation.jnd",), {"evaluation.jnd"}, "k, omega_c vary by 5 %; b varies by 20 %"),
    (("k", "c"), {"environment.k", "evaluation.jnd"}, "b varies by 20 %; omega_c varies by 5 %"),
]


@pytest.mark.few(2)
@pytest.mark.parametrize(("free", "besides", "listed"), FREE)
def test_a_requirement_says_what_is_nominal_but_for_what_it_is_about(
    free: tuple[str, ...], besides: set[str], listed: str, call: Call, scenes: tuple[str, str]
) -> None:
    ranges = [] if len(free) == 1 else ["--range", "50", "200", "--range", "0.05", "0.5", "--slices", "3"]
    asked = ["require", scenes[0], *(word for path in free for word in ("--free", path)), *ranges]
    _, out, _ = call(*asked)
    assert f"{listed}: these are the nominal values; see `haptisym tolerances`." in flat(out)
    _, out, _ = call(*asked, "--json")
    assert json.loads(out)["nominal"] == {path: x for path, x in EVERY.items() if path not in besides}
    _, out, _ = call("require", scenes[1], "--free", "k")
    assert "nominal" not in out


def test_one_threshold_that_is_free_leaves_the_other_nominal() -> None:
    scene = hs.parse_scene(RANGES)
    found = hs.require(scene, "evaluation.jnd.real").to_dict()
    assert set(found["nominal"]) == {*EVERY, "evaluation.jnd.imag"} - {"evaluation.jnd"}
    assert "c_imag varies by 10 %" in flat(str(hs.require(scene, "evaluation.jnd.real")))


def test_the_threshold_of_both_is_both() -> None:
    two = PLAIN.replace('jnd = "0.1"', 'jnd = { real = "0.1 +- 10 %", imag = "0.2 +- 5 %" }')
    scene = hs.parse_scene(two)
    both = {"evaluation.jnd.real": [0.09, 0.11], "evaluation.jnd.imag": [0.19, 0.21]}
    assert hs.evaluate(scene).to_dict()["nominal"] == both
    assert "nominal" not in hs.require(scene, "evaluation.jnd").to_dict()
    assert set(hs.require(scene, "evaluation.jnd.imag").to_dict()["nominal"]) == {"evaluation.jnd.real"}


def test_nothing_is_nominal_where_all_that_varies_is_asked_about() -> None:
    scene = hs.parse_scene(PLAIN.replace('"100 N/m"', '"100 N/m +- 5 %"'))
    found = hs.require(scene, "k")
    assert "nominal" not in str(found)
    assert "nominal" not in found.to_dict()


@pytest.mark.slow
def test_a_sweep_says_what_is_nominal_but_for_its_axes(call: Call, scenes: tuple[str, str], tmp_path: Path) -> None:
    asked = ("sweep", scenes[0], "--vary", "environment.k=50:100:2")
    _, out, _ = call(*asked)
    assert "b varies by 20 %; omega_c varies by 5 %; c varies by 10 %: these are the nominal values" in flat(out)
    store = str(tmp_path / "found.zarr")
    for more in ((), ("--out", store), ("--out", store)):  # in memory, written, and read again
        _, out, _ = call(*asked, *more, "--json")
        assert json.loads(out)["nominal"] == {path: x for path, x in EVERY.items() if path != "environment.k"}
    _, out, _ = call("sweep", scenes[1], "--vary", "environment.k=50:100:2")
    assert "nominal" not in out


def test_pages_and_latex_of_an_evaluation_say_what_is_nominal() -> None:
    assert (
        undrawn(hs.evaluate(hs.parse_scene(RANGES))).count(
            "this is the nominal scene; see <code>haptisym tolerances</code>."
        )
        == 1
    )
    for text, count in ((RANGES, 1), (PLAIN, 0)):
        e = hs.evaluate(hs.parse_scene(text))
        assert e._repr_html_().count("<code>haptisym tolerances</code>") == count  # type: ignore[attr-defined]
        for latex in (set_document(e), hs.latex(e)):
            assert latex.count(r"k, omega\_c vary by 5 \%;") == count
            assert latex.count(r"scene; see \texttt{haptisym tolerances}") == count


@pytest.mark.few(1)
@pytest.mark.parametrize("language", ["text", "latex", "mathml"])
def test_formulas_in_symbols_hold_for_all_values(language: str, call: Call, scenes: tuple[str, str]) -> None:
    _, out, _ = call("derive", scenes[0], "--to", language)
    assert "this is the nominal scene" in flat(out)
    assert "Formulas in their symbols hold for all values." in flat(out)
    _, out, _ = call("derive", scenes[0], "--numeric", "--to", language)
    assert "this is the nominal scene" in flat(out)
    assert "hold for all values" not in flat(out)
    _, out, _ = call("derive", scenes[1], "--to", language)
    assert "nominal" not in out


def test_measures_in_latex_say_what_is_nominal(call: Call, scenes: tuple[str, str]) -> None:
    assert "this is the nominal scene" in call("metrics", scenes[0], "--to", "latex")[1]
    assert "nominal" not in call("metrics", scenes[1], "--to", "latex")[1]


def test_code_says_which_of_its_numbers_are_nominal() -> None:
    scene = hs.parse_scene(RANGES)
    assert "nominal" not in hs.scene_code(scene, hs.Language.C)  # every parameter is an argument
    text = flat(hs.scene_code(scene, hs.Language.NUMPY, parameters=["k"]))
    assert "b varies by 20 %; omega_c varies by 5 %: these are the nominal values" in text


def test_several_environments_say_of_which_the_nominal_values_are_taken() -> None:
    text = """
    [[environments]]
    name = "soft"
    model = "kelvin-voigt"
    k = "100 N/m +- 5 %"
    b = 2
    [[environments]]
    name = "hard"
    model = "kelvin-voigt"
    k = 900
    b = 2
    """
    found = hs.evaluate_all(hs.parse_scenes(text))
    assert "soft: k varies by 5 %: this is the nominal scene" in str(found)
    assert "hard: " not in str(found)
    assert found.to_dict()["nominal"] == {"soft": {"environment.k": [95.0, 105.0]}}
    assert "nominal" not in hs.evaluate_all("palpation-device").to_dict()


def test_what_is_nominal_of_all_environments_is_said_once() -> None:
    late = (hs.effects.delay("4 ms +- 25 %"),)
    spring, pot = hs.environments.mass_spring_damper(k="100 N/m"), hs.environments.mass_spring_damper(k="90 N/m +- 5 %")
    alike = hs.SceneFamily({"a": hs.Scene(spring, late), "b": hs.Scene(spring, late)})
    assert alike.asides() == ["tau varies by 25 %: this is the nominal scene; see `haptisym tolerances`."]
    apart = hs.SceneFamily(
        {"a": hs.Scene(spring, late), "b": hs.Scene(pot, late), "c": hs.Scene(spring, late)}
    ).asides()
    assert [x.partition(": ")[0] for x in apart] == ["a, c", "b"]


def test_what_was_left_out_was_nominal_too() -> None:
    more = RANGES + '\n[[effects]]\nname = "cable"\nmodel = "first-order-lag"\nomega_c = "9 Mrad/s +- 10 %"\n'
    found = hs.evaluate(hs.parse_scene(more), tolerance=0.001)
    assert [effect.name for effect in found.scene.effects] == ["lag"]
    assert found.to_dict()["nominal"].keys() == {*EVERY, "effects.cable.omega_c"}
    assert "omega_c_cable, c vary by 10 %" in flat(str(found))


# Two parameters of one name

TWICE = """
[environment]
model = "kelvin-voigt"
k = 500
b = "3 N*s/m +- 1 %"

[rendered]
model = "expression"
H = "k + b*s*w/(s + w)"
parameters = { k = 500, b = "environment.b", w = "50 Hz" }

[evaluation]
band = ["0 rad/s", "120 rad/s"]
"""
DOUBLE = (
    "environment.k and rendered.k are two parameters: where one varies the other keeps its value. If they are one, write "
    'k = "environment.k" in [rendered].'
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


@pytest.mark.few(2)
@pytest.mark.parametrize("what", ASKED)
def test_what_varies_one_of_two_parameters_of_a_name_says_so(what: str) -> None:
    ask, told = ASKED[what]
    found = ask(hs.parse_scene(TWICE))
    assert (DOUBLE in flat(str(found))) == told
    assert found.to_dict().get("untied") == (PAIR if told else None)
    tied = (
        ask(hs.parse_scene(TWICE.replace("{ k = 500", '{ k = "environment.k"'))) if "rendered.k" not in what else None
    )
    assert tied is None or ("untied" not in tied.to_dict() and "two parameters" not in str(tied))


def test_tolerances_of_one_of_two_parameters_say_so() -> None:
    scene = hs.parse_scene(TWICE.replace('k = 500\nb = "3 N*s/m +- 1 %"', 'k = "500 N/m +- 1 %"\nb = 3'))
    found = hs.tolerances(scene, samples=0)
    assert DOUBLE in flat(str(found))
    assert found.to_dict()["untied"] == PAIR


def test_a_sweep_of_one_of_two_parameters_says_so(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "twice.toml"
    file.write_text(TWICE)
    for path, told in (("environment.k", True), ("rendered.k", True), ("rendered.w", False)):
        _, out, _ = call("sweep", str(file), "--vary", f"{path}=400:500:2")
        assert (DOUBLE in flat(out)) == told
        _, out, _ = call("sweep", str(file), "--vary", f"{path}=400:500:2", "--json")
        assert json.loads(out).get("untied") == (PAIR if told else None)


def test_several_doubles_are_told_in_one_sentence() -> None:
    scene = hs.parse_scene(TWICE.replace('"environment.b"', "3"))
    assert scene.untied_note() == (
        "environment.k and rendered.k, environment.b and rendered.b are two parameters each: where one varies the other keeps "
        'its value. If they are one, write k = "environment.k", b = "environment.b" in [rendered].'
    )
    assert not hs.load_scene("fu2019").untied_note()
