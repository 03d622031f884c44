"""Wherever a scene is asked for, its name or its path will do; anything else is an error that says what to call."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import haptisym as hs

PUBLIC = {name: getattr(hs, name) for name in sorted({*hs.__all__, *hs._ON_DEMAND})}
ASKING = [name for name, x in PUBLIC.items() if inspect.isfunction(x) and "scene" in inspect.signature(x).parameters]
READING = ["load_scene", "load_scenes"]

CALLS: dict[str, Callable[[Any], str]] = {
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
    "simulation_cost": lambda x: hs.simulation_cost(x, quick=True).scene.title,
    "sweep_cost": lambda x: hs.sweep_cost(x, quick=True).scene.title,
    "stability": lambda x: hs.stability(x, "postural-arm").to_json(),
    "sweep": lambda x: str(hs.sweep(x, {"effects.filter.omega_n": [40.0]}).bandwidth.values),
    "tolerances": lambda x: str(hs.tolerances(x, samples=0, limit=5).box.sides),
}
TIMED = ["cost", "simulation_cost", "sweep_cost"]  # minutes of measuring: which scene is measured is seen without that


@pytest.mark.parametrize("name", [x for x in ASKING if x not in READING])
def test_what_takes_a_scene_says_that_a_name_or_a_path_will_do(name: str) -> None:
    annotation = inspect.signature(PUBLIC[name]).parameters["scene"].annotation
    assert annotation.replace("MeasuredScene | ", "") == "Scene | str | Path"
    assert name in CALLS


@pytest.mark.few("evaluate", "derive", "require", "stability")
@pytest.mark.parametrize("name", [x for x in CALLS if x not in TIMED])
def test_a_name_or_a_path_is_as_good_as_the_scene(name: str, tmp_path: Path) -> None:
    shipped = "fu2019-tolerances" if name == "tolerances" else "fu2019"
    text = (Path(hs.__file__).parent / "scenes" / f"{shipped}.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    expected = CALLS[name](hs.load_scene(shipped))
    assert CALLS[name](shipped) == expected
    assert CALLS[name](path) == expected
    assert CALLS[name](str(path)) == expected


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "a distortion": (lambda: hs.load_scene("fu2019").distortion(), r"Scene\(environment, effects, band, threshold\)"),
    "an environment": (
        lambda: hs.environments.kelvin_voigt(1, 2),
        r"Environment is not a scene: make one with Scene\(",
    ),
    "an effect": (lambda: hs.effects.delay(1), r"Effect is not a scene: make one with Scene\("),
    "a family": (lambda: hs.load_scenes("palpation-device"), r'scenes\["fat"\].*evaluate_all\(scenes\)'),
    "an evaluation": (lambda: hs.evaluate("fu2019"), "Evaluation is not a scene: its attribute scene is one"),
    "a text": (lambda: "[environment]\nk = 1\n", r"parse_scene\(text\)"),
    "a number": (lambda: 3, "int is not a scene: give a Scene, the name"),
    "nothing": (lambda: None, "NoneType is not a scene: give a Scene, the name"),
    "a name that there is not": (lambda: "fu2020", 'neither a scene file .* did you mean "fu2019"'),
    "the name of a family": (lambda: "palpation-device", "has 4 environments .* --environment NAME"),
}


@pytest.mark.few(30)
@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_scene_is_refused_with_what_to_call(name: str, what: str) -> None:
    made, message = WRONG[what]
    with pytest.raises(hs.SceneError, match=message):
        CALLS[name](made())


def test_a_scene_is_not_loaded_twice() -> None:
    with pytest.raises(hs.SceneError, match="a scene already"):
        hs.load_scene(hs.load_scene("fu2019"))  # type: ignore[arg-type]


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
