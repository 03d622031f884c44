"""Several environments behind one display: who binds and where, by plain complex arithmetic; and the document says the same."""

from __future__ import annotations

from functools import cache
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import lambdify

import haptisym as hs
from haptisym import effects, environments
from haptisym.verbs.family.entry import FamilyEvaluation
from haptisym.verbs.family.regions import FamilyCompared
from haptisym.verbs.family.worst import WorstCase

LAG = effects.first_order_lag(40)
ROWS: dict[str, dict[str, Any]] = {
    "first from the low end": {"environments": {"soft": (100, 2), "hard": (900, 1)}, "effects": (LAG, effects.shunt(m="0.05")), "jnd": 0.1},
    "not from the low end": {"environments": {"a": (100, 4), "b": (90, 9)}, "effects": (effects.shunt(k=15),), "jnd": 0.1},
    "a region": {
        "environments": {"soft": (100, 2), "hard": (900, 1), "thick": (50, 6)}, "effects": (LAG, effects.shunt(m="0.05")),
        "jnd": {"shape": "ellipse", "real": 0.2, "imag": 0.1},
    },
    "twins": {"environments": {"a": (100, 2), "twin": (200, 4)}, "effects": (effects.second_order_lowpass(30, 1),), "jnd": {"real": 0.2, "imag": 0.3}},
    "the whole band": {"environments": {"a": (100, 2), "b": (200, 5)}, "effects": (effects.first_order_lag(4000),), "jnd": 0.1},
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
def found(name: str) -> FamilyEvaluation:
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
    change = (felt - H) / np.abs(H)
    c = family(name).threshold
    real, imag = np.abs(change.real) / float(c.real), np.abs(change.imag) / float(c.imag)
    return {"joint": np.hypot(real, imag) - 1} if name == "a region" else {"real": real - 1, "imag": imag - 1}


def exceeding(name: str, w: float) -> set[tuple[str, str]]:
    return {(key, part) for key in ROWS[name]["environments"] for part, x in excess(name, key, w).items() if x > 0}


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
    assert (None if e.bandwidth is None else float(e.bandwidth)) == (
        float(e.transparent[0].high.omega) if starts else None
    )
    expected = [] if starts else [(0.0, *x) for x in sorted(exceeding(name, 1e-9))]
    for x in e.transparent:
        low, high = float(x.low.omega), float(x.high.omega)
        expected += [] if low == 0 else [(low, *y) for y in sorted(exceeding(name, low * (1 - 1e-7)))]
        expected += [] if high == 60 else [(high, *y) for y in sorted(exceeding(name, high * (1 + 1e-7)))]
    told = [(float(x.omega), x.environment, x.criterion.name) for x in e.binding]
    assert sorted(told) == sorted(dict.fromkeys(expected))
    assert [x[0] for x in told] == sorted(x[0] for x in told)
    assert e.certified


@pytest.mark.parametrize("name", ROWS)
def test_the_document_of_a_family_is_its_answer(name: str) -> None:
    e = found(name)
    told = e.to_dict()
    assert told["band"] == [0, 60]
    assert told["threshold"] == family(name).threshold.row()
    assert [x["name"] for x in told["environments"]] == list(ROWS[name]["environments"])
    for x, scene in zip(told["environments"], family(name).scenes.values(), strict=True):
        own = hs.evaluate(scene, digits=20, regions=name == "a region").to_dict()
        assert {key: x[key] for key in own if key != "title"} == {key: y for key, y in own.items() if key != "title"}
    assert told["transparent"] == [[float(x.low.omega), float(x.high.omega)] for x in e.transparent]
    assert told["bandwidth"] == (None if e.bandwidth is None else float(e.bandwidth))
    assert told["binding"] == [
        {"at": float(x.omega), "digits": x.omega.digits(20), "enclosure": list(x.omega.enclosure(20)), "environment": x.environment, "part": x.criterion.name}
        for x in e.binding
    ]  # fmt: skip
    width = "no common bandwidth" if e.bandwidth is None else f"common bandwidth {e.bandwidth.digits(5)} rad/s"
    assert repr(e) == f'<FamilyEvaluation "{name}": {len(e.answers)} environments, {width}>'
    assert ("regions" in told) == (name == "a region")
    assert repr(e.worst) == f"<WorstCase common bandwidth {e.bandwidth.digits(5) if e.bandwidth else 'none'}>"


def test_each_region_has_the_common_bandwidth_of_all_and_who_binds_first() -> None:
    e = found("a region")
    assert [x.name for x in e.regions] == ["square", "disc", "diamond", "the scene's own"]
    for x, row in zip(e.regions, e.to_dict()["regions"], strict=True):
        alone = WorstCase.of(e.family, x.threshold)
        assert (x.bandwidth and float(x.bandwidth)) == (alone.bandwidth and float(alone.bandwidth))
        first = [y for y in alone.binding if float(y.omega) == float(alone.binding[0].omega)]
        assert [(y.environment, y.criterion.name) for y in x.first] == [
            (y.environment, y.criterion.name) for y in first
        ]
        assert list(x.answers) == list(e.answers)
        for who, own in x.answers.items():
            [same] = [y for y in e.answers[who].regions if y.name == x.name]
            assert own is same
        assert row == {
            "region": x.name, "threshold": x.threshold.row(), "bandwidth": float(x.bandwidth) if x.bandwidth else None,
            "binding": row["binding"], "certified": True,
        }  # fmt: skip
        assert [(y["environment"], y["part"], y["digits"]) for y in row["binding"]] == [
            (y.environment, y.criterion.name, y.omega.digits(20)) for y in x.first
        ]
        assert x.bandwidth is not None
        assert repr(x) == f"<FamilyCompared {x.name}: common bandwidth {x.bandwidth.digits(5)}>"
    assert e.regions[-1].worst is e.worst
    assert not found("twins").regions


def test_whose_ratio_is_the_threshold_itself_never_binds() -> None:
    """20/100 is 0.2 everywhere; 20/|200 - w^2| is more from 10 to the root of 300, ends not counted."""
    felt = {
        "even": environments.mass_spring_damper(k=100),
        "heavy": environments.mass_spring_damper(m=1, k=200),
    }
    for band, ends in (((0, 20), [10, 300**0.5]), ((12, 15), [12]), ((0, 9), []), ((12, 20), [12, 300**0.5])):
        made = {name: hs.Scene(x, (effects.shunt(k=20),), band, "0.2") for name, x in felt.items()}
        e = hs.evaluate_all(hs.SceneFamily(made, "at the threshold"))
        assert [float(x.omega) for x in e.binding] == pytest.approx(ends)
        assert {x.environment for x in e.binding} <= {"heavy"}


def test_a_family_is_certified_where_all_of_it_is() -> None:
    for here, there, compared, worst in product((True, False), repeat=4):
        answers: Any = {"a": SimpleNamespace(certified=here), "b": SimpleNamespace(certified=there)}
        case: Any = SimpleNamespace(chart=SimpleNamespace(undecided=() if worst else ("open",)))
        regions: Any = (SimpleNamespace(certified=True), SimpleNamespace(certified=compared))
        made = FamilyEvaluation(family("twins"), answers, case, regions=regions)
        assert made.certified is (here and there and compared and worst)
        assert FamilyCompared("disc", family("twins").threshold, case, answers).certified is (here and there and worst)


def test_one_scene_and_a_name_are_families_of_one() -> None:
    one = family("twins").scenes["a"]
    told = hs.evaluate_all(one)
    assert list(told.answers) == ["environment"]
    assert told.digits == 15
    assert repr(hs.evaluate_all("fu2019", digits=3)).startswith("<FamilyEvaluation")
    with pytest.raises(hs.SceneError, match="symbol"):
        hs.evaluate_all(hs.Scene(environments.kelvin_voigt(hs.symbols("k"), 1)))
