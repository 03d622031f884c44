"""``plot`` of every answer: on axes of the caller, several scenes on the same ones, told apart by all eyes and in print."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from drawn import at_curves, axes, places, told
from eyes import EYES, difference, lightness
from matplotlib.colors import to_hex

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.files import drawings_of
from haptisym.figures.layers import Panel, Polyline, draw
from haptisym.kernel.errors import NothingToDrawError
from haptisym.verbs.cost.hardcosts import HardCosts, HardRow
from haptisym.verbs.jnd.tables import Answers, LevelAnswers
from haptisym.writing.schemas import schema_names

PAPER = hs.load_scene("fu2019")
SLOW = PAPER.with_values({"omega_n": 50})
SPRING = hs.Scene(hs.environments.mass_spring_damper(k="100 N/m +- 10 %"), (hs.effects.first_order_lag(40),))
ANSWERS: dict[str, Callable[[hs.Scene], Any]] = {
    "evaluation": lambda s: hs.evaluate(s, discriminate=True),
    "derivation": hs.derive,
    "effects": hs.relevance,
    "requirement": lambda s: hs.require(s, "zeta"),
    "designmap": lambda s: hs.design_map(s, ["zeta", "omega_n"], [("0.4", "0.6"), (50, 300)], slices=3),
    "design": lambda s: hs.design(s, {"zeta": (0.3, 1)}),
    "stability": lambda s: hs.stability(s, ["postural-arm"]),
    "sensitivity": hs.sensitivity,
    "comparison": lambda s: hs.compare(s, values={"zeta": "0.4"}),
    "metrics": hs.metrics,
    "controlloading": hs.control_loading,
    "peaks": hs.peaks,
    "published": lambda _: hs.published(),
    "evaluations": lambda s: hs.evaluate_all(hs.load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]), regions=True),
    "measured": lambda s: hs.evaluate(hs.MeasuredScene(s.environment, measured(s))),
    "identification": lambda s: hs.identify(measured(s), "mass-spring-damper", ["second-order-lowpass"]),
    "zwidth": lambda s: hs.fit_zwidth("wheel-with-encoder", [(0.4, 0), (0.5, 5e-5), (0.6, 1e-4)], ["effects.wheel.b"]),
    "tolerances": lambda s: hs.tolerances(
        hs.load_scene("fu2019-tolerances").with_values({"zeta": s.knobs["zeta"].value}), samples=2, hand="light-touch"
    ),
    "simulation": lambda s: hs.check(s, count=3),
    "release": lambda s: hs.release(s, "1 cm", "postural-arm"),
    "cost": lambda s: hs.cost(s, quick=True),
    "hardcosts": lambda _: HardCosts(
        (HardRow("evaluate", "proof", 15, 1.0, proven=True, family="f", case="s", condition=1, ours=True, verdict="right"),),
        {},
    ),
    "jnd": lambda _: hs.jnd(Answers("answers", tuple(LevelAnswers(4.4 + 0.3 * i, 3 + 5 * i, 40) for i in range(6)))),
}  # fmt: skip
NOTHING = {
    ("comparison", "real"),
    ("comparison", "imag"),
    ("evaluation", "bandwidths"),
    ("measured", "plane"),
    ("metrics", "verdicts"),
    ("hardcosts", "cases"),
}
"""What a scene without a range has not; and what is told apart by its place."""


def measured(scene: hs.Scene) -> hs.Measurement:
    exact = hs.sampled(scene, np.linspace(1, 15, 15))
    return hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 15)


@cache
def evaluated(omega_n: int = 80) -> hs.Evaluation:
    return hs.evaluate(PAPER.with_values({"omega_n": omega_n}))


def test_every_kind_of_answer_can_be_drawn() -> None:
    assert set(ANSWERS) - {"hardcosts"} == set(schema_names()) - {"answers", "scenes", "schemas", "sweep"}


@pytest.mark.dear("derivation", "published", "requirement")
@pytest.mark.few("published", "hardcosts", "derivation", "requirement")
@pytest.mark.parametrize("name", ANSWERS)
def test_two_scenes_are_drawn_on_one_axes_of_the_caller(name: str) -> None:
    one, other = ANSWERS[name](PAPER), ANSWERS[name](SLOW)
    kinds = drawings_of(one).kinds
    for kind in kinds:
        if (name, kind) in {("evaluation", "bandwidths"), ("measured", "plane")}:
            continue
        ax = axes()
        assert one.plot(ax, kind=kind, label="first") is ax
        low, high = sorted(ax.get_xlim())
        before = len(ax.get_children())
        assert other.plot(ax, kind=kind, label="second") is ax
        assert len(ax.get_children()) > before
        assert sorted(ax.get_xlim())[0] <= low < high <= sorted(ax.get_xlim())[1]  # the first stays in sight
        ax.figure.draw_without_rendering()
        if (name, kind) not in NOTHING:
            for label in ("first", "second"):  # at a curve, or where there is none in the legend
                said = [*told(ax), *(x.get_text() for x in ax.texts)]
                assert not told(ax) or any(x.endswith(label) for x in said), (kind, label)
            assert len(told(ax)) == len(set(told(ax)))
    with pytest.raises(NothingToDrawError, match=rf"these are {next(iter(kinds))}"):
        one.plot(axes(), kind="what")


@pytest.mark.dear("ratios-ratio")
@pytest.mark.parametrize(
    ("kind", "label"),
    [
        ("", "ratio"), ("ratios", "ratio"), ("nyquist", r"$\mathrm{Im}\,H$ (N/m)"),
        ("projections-real", r"$|\mathrm{Re}\,H|$ (N/m)"), ("projections-imag", r"$|\mathrm{Im}\,H|$ (N/m)"),
    ],
)  # fmt: skip
def test_a_kind_of_an_evaluation_has_the_axis_that_its_name_says(kind: str, label: str) -> None:
    assert label in evaluated().plot(axes(), kind=kind).get_ylabel()


@pytest.mark.slow
def test_parts_of_effects_and_of_families_are_those_of_their_names() -> None:
    effects, family = hs.relevance(SPRING.with_values({"k": 100})), hs.evaluate_all(hs.SceneFamily({"one": PAPER}))
    for kind, symbol in (("real", r"r_\mathrm{r}"), ("imag", r"r_\mathrm{i}"), ("", r"r_\mathrm{r}")):
        assert effects.plot(axes(), kind=kind).get_ylabel() == f"change of ${symbol}$"
        assert family.plot(axes(), kind=kind).get_ylabel() == f"${symbol}$"


@pytest.mark.slow
def test_a_map_of_something_else_than_transparency_is_drawn_by_wishes_unless_asked_otherwise() -> None:
    plane = ["k", "tau"], [(20, 1000), ("0.001", "0.05")]
    found = hs.design_map("delayed-spring", *plane, slices=3, that=["stable"], hand="light-touch")
    assert any(x.endswith("poles on the axis") for x in told(found.plot(axes(), kind="slices")))
    assert told(found.plot(axes())) == told(found.plot(axes(), kind="wishes"))


def test_style_goes_to_the_curves_and_their_entries_and_color_to_the_scene() -> None:
    ax = evaluated().plot(axes(), color="#8f5a9e", linewidth=3, alpha=0.5)
    curves = [x for x in ax.lines if str(x.get_label()).startswith("$r_")]
    assert {(x.get_linewidth(), x.get_alpha(), x.get_color()) for x in curves[:2]} == {(3, 0.5, "#8f5a9e")}
    assert sum(x.get_linewidth() == 3 for x in ax.get_legend().legend_handles) == 2
    with pytest.raises(AttributeError, match="nonsense"):
        evaluated().plot(axes(), nonsense=1)


@pytest.mark.slow
def test_further_scenes_without_a_label_are_numbered_and_have_the_next_colour() -> None:
    ax, p = axes(), ANSWERS["jnd"](PAPER)
    for kind in ("ratios", "ratios", "ratios"):
        evaluated().plot(ax, kind=kind)
    assert len(told(ax)) == len(set(told(ax)))
    assert told(ax) == told(evaluated().plot(axes(), kind="ratios"))  # no entry is of one scene alone
    assert sorted(x.get_text() for x in ax.texts if "(" in x.get_text()) == ["(2)", "(2)", "(3)", "(3)"]
    own = [to_hex(x.get_color()) for x in ax.lines if str(x.get_label()).startswith("$r_") and len(x.get_xdata()) > 100]
    assert own[2:] == [pen.SCENES[1]] * 2 + [pen.SCENES[2]] * 2
    other = p.plot(p.plot(axes(), label="one"), label="two", color="#009900")
    assert {*at_curves(other)} == {"one", "two"}
    assert "#009900" in {to_hex(x.get_color()) for x in other.lines}


@pytest.mark.slow
def test_curves_of_a_further_family_bear_the_names_of_both_and_leave_the_legend_as_it_is() -> None:
    effects = (hs.effects.first_order_lag(20), hs.effects.shunt(m="0.1"))
    spring = hs.environments.mass_spring_damper(k=100, b=3)
    families = [
        hs.evaluate_all(
            hs.SceneFamily({
                "soft": hs.Scene(spring, effects, (0, 15), "0.1"),
                "wall": hs.Scene(hs.environments.mass_spring_damper(k=k), effects, (0, 15), "0.1"),
            })
        )
        for k in (1000, 5000)
    ]  # fmt: skip
    for labels, own in (
        (("", ""), ["soft", "soft (2)", "(2)"]),
        (("one", "two"), ["soft, one", "soft, two", "one", "two"]),
    ):
        ax = axes()
        for found, label in zip(families, labels, strict=True):
            found.plot(ax, kind="imag", label=label)
        assert told(ax) == ["largest", "others", "threshold", "all transparent"]
        assert {*at_curves(ax)} == set(own)
        colors = {x.get_text(): to_hex(x.get_color()) for x in ax.texts}
        assert [colors[own[0]], colors[own[1]]] == [pen.BLUE, pen.SCENES[1]]


def test_a_name_stands_nearer_to_its_own_curve_than_to_any_other() -> None:
    """Two curves that end in one point had both names there."""
    ax, x = axes(), np.linspace(0, 1, 200)
    draw(ax, Panel([Polyline(x, x**2, name="square"), Polyline(x, x**6, name="sixth")]))
    ax.figure.draw_without_rendering()
    lines = {"square": x**2, "sixth": x**6}
    assert {*at_curves(ax)} == {*lines}
    for text in ax.texts:
        box = text.get_window_extent()
        apart = {}
        for name, y in lines.items():
            a, b = ax.transData.transform(np.column_stack([x, y])).T
            apart[name] = np.hypot(
                np.maximum(0, np.maximum(box.x0 - a, a - box.x1)), np.maximum(0, np.maximum(box.y0 - b, b - box.y1))
            ).min()
        assert min(apart, key=apart.__getitem__) == text.get_text()
        assert min(apart.values()) > 0  # and no curve goes through it


def test_what_the_caller_drew_stays_and_a_drawing_that_fails_leaves_the_legend_as_it_was() -> None:
    ax = axes()
    note, [line] = ax.text(2, 2, "mine"), ax.plot([0, 1], [0, 1])
    evaluated().plot(ax)
    evaluated().plot(ax)
    before = told(ax)
    with pytest.raises(NothingToDrawError, match="regions=True"):
        evaluated().plot(ax, kind="regions")
    assert told(ax) == before
    assert (note in ax.texts, line in ax.lines, places(line)[0].tolist()) == (True, True, [0, 1])


def test_what_cannot_be_drawn_is_said_with_what_can() -> None:
    with pytest.raises(hs.HaptisymError, match='did you mean "nyquist"'):
        evaluated().plot(axes(), kind="nyquis")
    with pytest.raises(NothingToDrawError, match=r"evaluate_all\(scenes, regions=True"):
        hs.evaluate_all(hs.SceneFamily({"one": PAPER})).plot(axes(), kind="regions")


@pytest.mark.slow
def test_a_kind_that_an_answer_has_nothing_for_says_so() -> None:
    wheel = hs.simulate("steering-wheel", hs.chirp("0.1 rad", "1 rad/s", "10 rad/s", "5 s"))
    with pytest.raises(NothingToDrawError, match="no ratio is recovered"):
        wheel.plot(axes(), kind="recovered-real")


# Colours.


def test_eyes_without_some_cones_confuse_what_they_are_known_to() -> None:
    for eye in EYES:
        assert difference("#ffffff", "#808080", eye) > 40
        assert difference("#777777", "#777777", eye) == 0
    red, green = "#c05030", "#708000"
    assert difference(red, green, "usual") > 3 * difference(red, green, "no middle cones")
    assert difference("#00a0a0", "#5090c0", "usual") > difference("#00a0a0", "#5090c0", "no short cones")


@pytest.mark.parametrize("eye", EYES)
def test_colours_of_scenes_and_curves_are_told_apart_by_every_eye(eye: str) -> None:
    pairs = [*combinations(pen.SCENES, 2), (pen.CURVES[0][0], pen.CURVES[1][0])]
    assert min(difference(one, other, eye) for one, other in pairs) > 20


def test_scenes_are_told_apart_in_print_and_curves_by_their_strokes() -> None:
    assert min(abs(lightness(x) - lightness(y)) for x, y in combinations(pen.SCENES, 2)) > 10
    assert pen.CURVES[0][1] != pen.CURVES[1][1]
