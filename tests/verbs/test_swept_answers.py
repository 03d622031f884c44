"""What a sweep says in short: of data that are known, counted and ranged a second time in plain Python."""

from __future__ import annotations

import random
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptisym as hs
from haptisym.kernel.roots import Chart
from haptisym.verbs.sweep.exactly import exact_answers
from haptisym.verbs.sweep.swept import Swept
from haptisym.verbs.sweep.told import Told

HANDS = [hs.Hand(name, 1, 5, 40) for name in ("one", "no. two", "no two", "three!")]
SCENE = hs.load_scene("fu2019").with_hands(*HANDS)
AXES = {"effects.filter.omega_n": [40.0, 120.0, 80.0], "environment.m": [0.5, 2.0], "evaluation.jnd": [0.1, 0.2]}
NAMES = {"unstable_one": "one", "unstable_no_two_2": "no. two", "unstable_no_two_3": "no two", "unstable_three": "three!"}  # fmt: skip


@pytest.fixture(scope="module")
def data() -> Any:
    return hs.sweep(SCENE, AXES)


def drawn(data: Any, seed: int) -> tuple[Any, random.Random]:
    """The same with other values, of which many, or none, or all are absent."""
    draw, found, told = random.Random(seed), data.copy(deep=True), Told.of(SCENE)
    for name in told.floats:
        absent = draw.choice([0.0, 0.5, 1.0])
        row = [float("nan") if draw.random() < absent else draw.uniform(0, 15) for _ in range(12)]
        found[name][:] = np.array(row).reshape(3, 2, 2)
    for name, some in [
        *((x, [-1, 0, 1, 2, 5][draw.randint(0, 2) :]) for x in told.counts),
        *((x, draw.choice([[0], [0, 1, 4, 32767, -1], [2, 32767], [-1]])) for x in told.hands),
        ("method", draw.choice([[0], [0, 1], [1, 2], [0, 1, 2]])),
    ]:
        found[name][:] = np.array([draw.choice(some) for _ in range(12)]).reshape(3, 2, 2)
    return found, draw


def values(data: Any, name: str) -> list[Any]:
    return list(data[name].values.ravel().tolist())


@pytest.mark.parametrize("seed", range(8))
def test_a_document_of_a_sweep_counts_its_sets(seed: int, data: Any) -> None:
    own, draw = drawn(data, seed)
    out = draw.choice([None, Path("a.zarr")])
    answer, told = Swept(SCENE, own, out), Told.of(SCENE)
    found, method = answer.to_dict(), values(own, "method")
    assert answer._line().endswith(": 12 sets")
    assert (found["sets"], found["out"]) == (12, None if out is None else "a.zarr")
    assert found["band"] == [float(x) for x in SCENE.band]
    assert found["vary"] == [
        {"path": "effects.filter.omega_n", "unit": "rad/s", "low": 40.0, "high": 120.0, "values": 3},
        {"path": "environment.m", "unit": "kg", "low": 0.5, "high": 2.0, "values": 2},
        {"path": "evaluation.jnd", "unit": "1", "low": 0.1, "high": 0.2, "values": 2},
    ]
    assert [found[x] for x in ("certified_in_floats", "exact", "open")] == [method.count(n) for n in range(3)]
    assert answer.certified == (2 not in method)
    for name in told.floats:
        there = [x for x in values(own, name) if not isnan(x)]
        assert found["ranges"][name] == ([min(there), max(there)] if there else None)
    for name in told.counts:
        row = values(own, name)
        assert found["counts"][name] == {str(n): row.count(n) for n in sorted(set(row)) if n >= 0}
    assert [x["variable"] for x in found["held"]] == list(NAMES)
    for x in found["held"]:
        row = values(own, x["variable"])
        assert x["hand"] == NAMES[x["variable"]]
        assert x["unstable"] == {str(n): row.count(n) for n in sorted(set(row)) if n not in (-1, 32767)}
        assert [x[key] for key in ("stable", "infinite", "undecided")] == [row.count(n) for n in (0, 32767, -1)]
    places = [(i, j, k) for i in range(3) for j in range(2) for k in range(2) if own.method.values[i, j, k] == 2]
    at = [{path: AXES[path][n] for path, n in zip(AXES, place, strict=True)} for place in places[:5]]
    assert found.get("open_at", []) == at
    assert ("open_at" in found) == bool(at)


def test_variables_have_the_unit_and_kind_of_what_they_mean(data: Any) -> None:
    told = Told.of(SCENE)
    assert set(data.data_vars) == {*told.floats, *told.counts, *NAMES, "method"}
    assert dict(told.hands) == NAMES
    for name, x in data.data_vars.items():
        kind = "float64" if name in told.floats else "int8" if name == "method" else "int16"
        per_second = name in told.floats and name != "transparent"
        assert (x.dtype.name, x.attrs["units"]) == (kind, "rad/s" if per_second else "1")
        assert x.dims == tuple(AXES)
    assert told.floats == (
        "first_crossing_real", "first_crossing_imag", "bandwidth", "transparent", "changeover_environment", "changeover_perceived",
    )  # fmt: skip
    assert told.counts == ("crossings_real", "crossings_imag", "changeovers_environment", "changeovers_perceived")
    none = told.no_answer()
    assert {name: none[name] for name in (*told.counts, "method")} == {**dict.fromkeys(told.counts, -1), "method": 2}
    assert all(isnan(none[name]) for name in told.floats)
    assert set(none) == {*told.counts, *told.floats, "method"}
    said = {name: x.attrs["long_name"] for name, x in data.data_vars.items()}
    assert said["first_crossing_imag"] == "lowest frequency of the band at which r_i meets its threshold; NaN if none"
    assert said["crossings_real"] == "number of frequencies of the band at which r_r meets its threshold"
    assert said["changeover_environment"] == "lowest frequency of the band at which Re H_env changes sign; NaN if none"
    assert said["changeovers_perceived"] == "number of sign changes of Re H_perc on the band"
    assert said["transparent"] == "fraction of the band on which neither ratio exceeds its threshold"
    assert said["method"] == "0: certified by floats with an error bound; 1: exact; 2: not answered, or not in all"
    joint = hs.Scene(SCENE.environment, SCENE.effects, SCENE.band, {"shape": "ellipse", "real": 0.1, "imag": 0.1})
    own = Told.of(joint)
    assert (own.counts[0], own.floats[0], own.hands) == ("crossings_joint", "first_crossing_joint", {})
    assert own._meanings()["transparent"] == "fraction of the band on which dH/|H_env| lies in the JND region"


def test_what_a_data_set_says_of_itself_is_that_of_its_scene(data: Any) -> None:
    assert data.attrs["schema"] == "haptisym.sweep/1"
    assert (data.attrs["title"], data.attrs["source"]) == (SCENE.title, SCENE.source)
    assert data.attrs["band"] == [0.0, 15.0]
    assert data.attrs["threshold"] == [str(SCENE.threshold.real), str(SCENE.threshold.imag)]
    assert data.attrs["relative_accuracy"] == 1e-10
    assert "where floats with an error bound prove" in data.attrs["floats"]
    assert "sines" not in data.attrs["floats"]
    late = hs.load_scene("delayed-spring")
    tissue = hs.Scene(hs.environments.spring_pot(80, "0.5"), (hs.effects.first_order_lag(40),), (1, 2))
    kinds = {
        "sines": hs.sweep(late, {"environment.k": [1.0]}),
        "every set is answered exactly": hs.sweep(tissue, {"environment.alpha": [0.5]}),
    }
    for words, other in kinds.items():
        assert words in other.attrs["floats"], words
    assert len({x.attrs["fingerprint"] for x in (data, *kinds.values())}) == 3


def test_a_set_of_which_exact_arithmetic_leaves_something_open_is_not_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = hs.load_scene("fu2019")
    knob = scene.knobs["environment.m"]
    assert exact_answers(scene, [knob], [2.0])["method"] == 1
    monkeypatch.setattr(Chart, "undecided", property(lambda _: ((0.0, 1.0),)))
    assert exact_answers(scene, [knob], [2.0])["method"] == 2
