"""What is rendered may have the environment's own parameters: one parameter in two places, whatever is asked."""

from __future__ import annotations

import pickle
import re
from dataclasses import replace
from pathlib import Path

import pytest
from pdflatex import set_document
from reports import undrawn
from sympy import Expr, Rational, Symbol, diff, pi, sqrt

import haptisym as hs
from haptisym import effects, environments

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
# dH = b s w/(s + w) - b s, so Re dH = b w^2 w_f/(w^2 + w_f^2): k is in H_env alone
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


def test_a_requirement_moves_both() -> None:
    # the least k at which r_r = c at the high end W: (b W^2 w/(W^2 + w^2))^2/c^2 - b^2 W^2
    W = Rational(120)
    least = sqrt((b * W**2 * w / (W**2 + w**2)) ** 2 / c**2 - (b * W) ** 2)
    [span] = hs.require(wall(), "environment.k").feasible
    assert span.low.value is not None
    assert span.low.value.digits(15) == str(least.evalf(15))
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


def test_a_sweep_moves_both() -> None:
    found = hs.sweep(wall(), {"environment.k": [400.0, 600.0]}).first_crossing_real
    assert found.values.tolist() == pytest.approx([crossing(400), crossing(600)], rel=1e-9)


def test_a_map_moves_both() -> None:
    found = hs.design_map(wall(), ["rendered.w", "environment.k"], [("40 Hz", "60 Hz"), (100, 9000)], slices=2)
    W = Rational(120)
    for x in found.slices:
        least = sqrt((b * W**2 * x.at / (W**2 + x.at**2)) ** 2 / c**2 - (b * W) ** 2)
        assert x.requirement.feasible[0].low.value.digits(12) == str(least.evalf(12))  # type: ignore[union-attr]


@pytest.mark.parametrize("key", ["k", "b"])
def test_what_refers_to_another_is_that_other(key: str) -> None:
    path, other = f"rendered.{key}", f"environment.{key}"
    assert hs.require(wall(), path, (1, 900)).to_json() == hs.require(wall(), other, (1, 900)).to_json()
    assert hs.sweep(wall(), {path: [1.0]}).identical(hs.sweep(wall(), {other: [1.0]}))
    assert wall().with_values({path: 7}) == wall().with_values({other: 7})
    with pytest.raises(hs.SceneError, match=f"{other} is given twice"):
        wall().with_values({path: 7, other: 7})


@pytest.mark.slow
def test_code_report_and_latex_list_it_once() -> None:
    e = hs.evaluate(wall())
    assert [x.symbol.name for x in hs.derive(wall()).scene.parameters] == ["k", "b", "w"]
    assert "omega, double k, double b, double w, " in hs.scene_code(wall(), hs.Language.C)
    shown = re.sub("<script.*?</script>", "", undrawn(e), flags=re.DOTALL)
    assert shown.count("environment, rendered") == 2
    assert re.findall(r'title="(\w+ of \w+)"', shown) == ["k of environment", "b of environment", "w of rendered"]
    text = set_document(e)
    assert text.count("environment, rendered") == 2
    assert "k_{rendered}" not in text


def test_shipped_scenes_tie_what_they_repeat() -> None:
    for name in hs.scene_names():
        assert not hs.load_scene(name).untied(), name
    for name in hs.family_names():
        assert not any(scene.untied() for scene in hs.load_scenes(name).scenes.values())
    assert set(ties(hs.load_scene("sampled-wall"))) == {"rendered.k", "rendered.b"}
    assert set(ties(hs.load_scene("steering-wheel"))) == {"rendered.m", "rendered.b", "rendered.k"}


def test_a_range_comes_along() -> None:
    low, high = wall().rendered.parameters[0].interval  # type: ignore[union-attr, misc]
    assert (low, high) == (475, 525)


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


def test_a_scene_goes_there_and_back() -> None:
    scene = wall()
    assert pickle.loads(pickle.dumps(replace(scene))) == replace(scene) == scene
    assert hs.evaluate(replace(scene)).to_json() == hs.evaluate(scene).to_json()


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


@pytest.mark.parametrize(
    ("unit", "fits"), [("3 N/m", True), ("3 N*m/rad", True), ("3", True), ("3 N*s/m", False), ("3 kg", False)]
)
def test_a_value_of_a_formula_fits_by_its_unit_if_it_has_one(unit: str, fits: bool) -> None:  # noqa: FBT001
    scene = f'''
    [environment]
    model = "expression"
    H = "q + s"
    parameters = {{ q = "{unit}" }}
    [rendered]
    model = "kelvin-voigt"
    k = "environment.q"
    b = 2
    '''
    if fits:
        felt = hs.parse_scene(scene).rendered
        assert felt is not None
        assert 2 * hs.s + 3 == felt.H
        return
    with pytest.raises(hs.SceneError, match=r'k: "environment.q" is not a stiffness: expected N/m or N\*m/rad'):
        hs.parse_scene(scene)


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


WRONG = {
    'k = "environment.kk"': r'rendered: k: "environment.kk" is no .*did you mean "environment.k"\? valid are environment.k, envi',
    'k = "enviroment.k"': 'did you mean "environment.k"',
    'k = "rendered.b"': '"rendered.b" is no parameter of the environment: valid are environment.k, environment.b',
    'k = "effects.device.k"': '"effects.device.k" is no parameter of the environment',
    'k = "environment.b"': r'k: "environment.b" is not a stiffness: expected N/m or N\*m/rad',
    'k = "environment.k +- 5 %"': "a reference stands alone",
    'k = "0.5*environment.k"': "a reference stands alone",
    'k = "environment."': "a reference stands alone",
    'k = ["environment.k", "600 N/m"]': "does not start with a finite number",
}


@pytest.mark.parametrize("line", WRONG)
def test_a_reference_that_is_none_is_an_error_that_lists_the_valid_ones(line: str) -> None:
    text = f'[environment]\nmodel = "kelvin-voigt"\nk = 5\nb = 3\n[rendered]\nmodel = "kelvin-voigt"\nb = 2\n{line}\n'
    with pytest.raises(hs.SceneError, match=WRONG[line]):
        hs.parse_scene(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[environment]\nmodel = "kelvin-voigt"\nk = "environment.b"\nb = 3', "environment: k: .*only what is rendered"),
        ('[environment]\nmodel = "maxwell"\nk = 1\nb = 3\n[[effects]]\nmodel = "shunt"\nk = "environment.k"',
         r'effects\[1\] "shunt": k: .*only what is rendered'),
        (('[environment]\nmodel = "mass-spring-damper"\nk = 1\n[rendered]\nmodel = "kelvin-voigt"\nk = 1\n'
         'b = "environment.b"'), '"environment.b" is no parameter of the environment: did you mean "environment.k"'),
        (('[environment]\nmodel = "expression"\nH = "3 + s"\n[rendered]\nmodel = "kelvin-voigt"\nk = "environment.q"\n'
         "b = 1"), '"environment.q" is no parameter of the environment: it has none'),
        (('[environment]\nmodel = "mass-spring-damper"\nk = ["0 N/m", "2 N/m"]\nb = 1\n[rendered]\nmodel = "maxwell"\n'
         'b = 1\nk = "environment.k"'), 'rendered: k: "environment.k" must be > 0'),
        (('[environment]\nmodel = "mass-spring-damper"\nk = 0\nb = 1\n[rendered]\nmodel = "maxwell"\nb = 1\n'
         'k = "environment.k"'), 'rendered: k: "environment.k" must be > 0'),
        (('[environment]\nmodel = "expression"\nH = "q"\nparameters = { q = "3 N*m/rad" }\n[rendered]\n'
         'model = "kelvin-voigt"\nk = "environment.q"\nb = "2 N*s/m"'), "rendered.k is rotational but rendered.b is trans"),
    ],
)  # fmt: skip
def test_references_keep_the_rules_of_their_place(text: str, message: str) -> None:
    with pytest.raises(hs.SceneError, match=message):
        hs.parse_scene(text)
