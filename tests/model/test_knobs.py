"""Names of what may be varied: each verb knows the same ones, and says the same of those that are none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, sqrt

import haptisym as hs
from haptisym import effects, environments
from haptisym.model.knobs import Knob
from haptisym.verbs.sweep.axes import axes, spaced

SCENES = {name: hs.load_scene(name) for name in hs.scene_names()} | {
    f"{name}:{key}": scene for name in hs.family_names() for key, scene in hs.load_scenes(name).scenes.items()
}
PAPER = SCENES["fu2019"]

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


def names(knob: Knob, scene: hs.Scene) -> set[str]:
    """All names that mean one number of a scene, from the words of the documentation: path, symbol, end of a path."""
    ends = {path.partition(".")[2] for path in knob.paths} | {path.rpartition(".")[2] for path in knob.paths}
    others = [path for x in scene.knobs if x != knob for path in (*x.paths, f".{x.name}")]
    return {*knob.paths, knob.name} | {end for end in ends if not any(x.endswith(f".{end}") for x in others)}


def own(knob: Knob) -> Any:
    return knob.interval or knob.value


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_each_name_means_one_number_and_its_own_value_changes_nothing(scene: hs.Scene) -> None:
    assert len({x.path for x in scene.knobs}) == len(scene.knobs)
    assert [x.path for x in scene.knobs][-3:] == ["evaluation.jnd", "evaluation.jnd.real", "evaluation.jnd.imag"]
    alike = scene.knobs.limits[hs.Part.REAL] is scene.knobs.limits[hs.Part.IMAG]
    for knob in scene.knobs:
        for name in names(knob, scene):
            assert scene.knobs[name] == knob
        if len(knob.parts) < 2 or alike:
            again = knob.put(scene, own(knob))
            assert again == scene
            assert again.motion is scene.motion
    together = {x.path: own(x) for x in (*scene.parameters, *set(scene.knobs.limits.values()))}
    assert scene.with_values(together) == scene


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_verbs_take_every_name(scene: hs.Scene) -> None:
    for knob in scene.knobs:
        for name in names(knob, scene):
            for asked in (lambda n: hs.require(scene, n, (2, 1)), lambda n: hs.sweep(scene, {n: []})):
                with pytest.raises(hs.SceneError, match=rf"^{knob.path.replace('[', '.').replace(']', '.')}[: ]"):
                    asked(name)
            kept = hs.derive(scene, [name])
            assert (kept.kept, kept.kept_thresholds) == (() if knob.parts else (knob.symbol,), knob.parts)
            if knob.value > 0 and knob.rule.name != "FRACTION":
                assert [x.path for x in axes(scene, {name: [0.5, 2.0]})] == [knob.path]


def test_code_and_slopes_take_every_name() -> None:
    for knob in PAPER.parameters:
        texts = {hs.scene_code(PAPER, hs.Language.C, parameters=[name]) for name in names(knob, PAPER)}
        assert len(texts) == 1
        found = hs.sensitivity(PAPER).crossings[0]
        assert {found[name].path for name in names(knob, PAPER)} == {knob.path}
    with pytest.raises(hs.SceneError, match="evaluation.jnd is a threshold, of which code holds nothing"):
        hs.scene_code(PAPER, hs.Language.C, parameters=["c"])


@pytest.mark.parametrize("taker", TAKERS.values(), ids=TAKERS)
@pytest.mark.parametrize(
    ("name", "nearest"),
    [("omega", "omega_n"), ("effects.filter.omega_c", "effects.filter.omega_n"), ("", ""), ("qqq", "")],
)
def test_a_wrong_name_is_told_in_one_sentence(taker: Callable[..., Any], name: str, nearest: str) -> None:
    valid = ", ".join(x.path for x in PAPER.knobs)
    hint = f'did you mean "{nearest}"? ' if nearest else ""
    if taker is TAKERS["sensitivity"]:  # it has one threshold
        valid = valid.partition(", evaluation.jnd.real")[0]
    with pytest.raises(hs.SceneError) as told:
        taker(PAPER, name)
    assert str(told.value) == f'the scene has no parameter "{name}": {hint}valid are {valid}'


def test_a_name_that_means_several_numbers_asks_for_the_path() -> None:
    twice = hs.Scene(environments.kelvin_voigt(100, 2), (effects.shunt(k=1), effects.shunt(k=2, name="second")))
    assert twice.knobs["k"].path == "environment.k"  # symbols come first
    lags = hs.Scene(
        environments.kelvin_voigt(100, 2), (effects.first_order_lag(20), effects.first_order_lag(30, name="b2"))
    )
    with pytest.raises(hs.SceneError) as told:
        hs.require(lags, "omega_c")
    assert str(told.value) == ('"omega_c" may be effects.first-order-lag.omega_c or effects.b2.omega_c: give the path')
    named = hs.Scene(environments.expression("c + s", parameters={"c": 5}))
    with pytest.raises(hs.SceneError, match='"c" may be environment.c or evaluation.jnd: give the path'):
        named.with_values({"c": 1})
    assert named.with_values({"environment.c": 7}).threshold == named.threshold


def test_one_number_is_not_given_twice() -> None:
    for given in (["m", "environment.m"], ["c", "evaluation.jnd"]):
        message = f"{PAPER.knobs[given[1]].path} is given twice"
        for ask in (
            lambda x: PAPER.with_values(dict.fromkeys(x, 1)),
            lambda x: hs.sweep(PAPER, {name: [1.0] for name in x}),
            lambda x: hs.design_map(PAPER, x, [(1, 2), (1, 2)]),
        ):
            with pytest.raises(hs.SceneError, match=message):
                ask(given)
    with pytest.raises(hs.SceneError, match="evaluation.jnd is both thresholds"):
        PAPER.with_values({"evaluation.jnd": 1, "evaluation.jnd.imag": 1})


@pytest.mark.parametrize(
    "ask",
    [
        hs.evaluate, hs.sensitivity, hs.metrics, hs.relevance, hs.tolerances, hs.cost, hs.peaks, hs.check,
        lambda x: hs.require(x, "m"), lambda x: hs.design_map(x, ["m", "b"], [(1, 2), (1, 2)]),
        lambda x: hs.sweep(x, {"m": [1.0]}), lambda x: hs.simulate(x, hs.sine("5 cm", 5)),
    ],
)  # fmt: skip
def test_a_symbol_where_a_number_is_needed_is_told_in_one_sentence(ask: Callable[[hs.Scene], Any]) -> None:
    with pytest.raises(hs.SceneError) as told:
        ask(PAPER.with_values({"k": Symbol("q", positive=True)}))
    assert str(told.value) == (
        "environment.k = q is a symbol where a number is needed: put one in, as by "
        'with_values({"environment.k": ...}); derive and distort answer in symbols'
    )


@pytest.mark.parametrize(
    "ask",
    [
        lambda given: hs.require(PAPER, "m", (given, 5)),
        lambda given: PAPER.knobs["m"].number(given),
        lambda given: hs.design_map(PAPER, ["m", "b"], [(1, given), (1, 2)]),
    ],
)
def test_what_is_no_number_of_that_kind_is_told(ask: Callable[[Any], Any]) -> None:
    for given, words in (
        (Symbol("q"), '"q" must be a number'),
        ("1 N/m", '"1 N/m" is not a mass: expected kg or kg*m^2'),
        ("1 kg*m^2", '"1 kg*m^2" is rotational, but the scene is translational'),
    ):
        with pytest.raises(hs.SceneError) as told:
            ask(given)
        assert str(told.value) == f"environment.m: {words}"


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("omega_n", 0, 'effects.filter.omega_n: "0" must be > 0'),
        ("m", "-1 kg", 'environment.m: "-1 kg" must be >= 0'),
        ("m", "1 +- 200 %", 'environment.m: "1 +- 200 %" must be >= 0'),
        ("c", 0, 'evaluation.jnd: "0" must be > 0'),
        ("c_imag", "1 kg", 'evaluation.jnd.imag: "1 kg" is not a ratio: expected a plain number'),
        ("jnd", Symbol("q"), 'evaluation.jnd: "q" must be a number'),
    ],
)
def test_a_value_keeps_the_rule_of_its_place(name: str, given: Any, words: str) -> None:
    with pytest.raises(hs.SceneError) as told:
        PAPER.with_values({name: given})
    assert str(told.value) == words


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
    assert PAPER.with_values({"c": sqrt(2) / 10}).threshold[hs.Part.IMAG] == sqrt(2) / 10


def test_a_bare_number_is_one_in_the_unit_that_was_there() -> None:
    wheel = SCENES["steering-wheel"]
    assert wheel.motion is not None
    bare = wheel.with_values({x.path: x.value for x in wheel.parameters})
    assert bare.motion is wheel.motion
    assert [x.unit for x in bare.knobs] == [x.unit for x in wheel.knobs]
    soft = hs.Scene(environments.expression("q + s", parameters={"q": "3 N/m"}))
    assert soft.with_values({"q": 5}).parameters[0].exponents == soft.parameters[0].exponents
    assert soft.with_values({"q": "5 kg"}).parameters[0].exponents != soft.parameters[0].exponents


def test_a_formula_s_slope_is_by_any_name() -> None:
    from haptisym.pages.sections import asked

    for thresholds in (None, ["omega_n", "c"], ["filter.omega_n", "evaluation.jnd.real"]):
        found = hs.derive(PAPER, thresholds)
        texts = [str(asked(found, [f"d omega_r/d {name}"])) for name in ("omega_n", "effects.filter.omega_n")]
        assert texts[0] == texts[1]
        assert asked(found, ["d omega_r/d c"])
    with pytest.raises(hs.SceneError, match='"c" does not stay a symbol: omega_n'):
        asked(hs.derive(PAPER, ["omega_n", "c_imag"]), ["d omega_r/d c"])


def test_a_threshold_of_one_part_may_stay_a_symbol_alone() -> None:
    found = hs.derive(PAPER, ["c_real"])
    c = hs.symbols("c")
    assert (found.threshold(hs.Part.REAL), found.threshold(hs.Part.IMAG)) == (c, Rational(1, 10))


def test_elements_that_a_scene_gains_have_names_too() -> None:
    more = replace(PAPER, effects=(*PAPER.effects, effects.shunt(m=1, name="hand")))
    assert more.knobs["hand.m"].path == "effects.hand.m"
    assert more.knobs["m_hand"].value == Integer(1)


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
    with pytest.raises(hs.SceneError, match="may be environment.c or effects.link.c or evaluation.jnd"):
        scene.knobs["c"]


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
