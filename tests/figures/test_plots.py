"""``plot`` of every answer: on axes of the caller, several scenes on the same ones, told apart by all eyes and in print."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from eyes import EYES, difference, lightness
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import haptisym as hs
from haptisym.figures.pen import SCENES
from haptisym.figures.plots import KINDS
from haptisym.figures.style import CURVES
from haptisym.kernel.errors import NothingToDrawError
from haptisym.writing.schemas import schema_names

PAPER = hs.load_scene("fu2019")
SLOW = PAPER.with_values({"omega_n": 50})
ANSWERS: dict[str, Callable[[hs.Scene], Any]] = {
    "evaluation": lambda s: hs.evaluate(s, regions=True),
    "derivation": hs.derive,
    "effects": hs.relevance,
    "requirement": lambda s: hs.require(s, "zeta"),
    "designmap": lambda s: hs.design_map(s, ["zeta", "omega_n"], [("0.4", "0.6"), (50, 300)], slices=3),
    "stability": lambda s: hs.stability(s, ["postural-arm"]),
    "sensitivity": hs.sensitivity,
    "metrics": hs.metrics,
    "peaks": hs.peaks,
    "published": lambda _: hs.published(),
    "evaluations": lambda s: hs.evaluate_all(hs.load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]), regions=True),
    "measured": lambda s: hs.evaluate(hs.MeasuredScene(s.environment, measured(s))),
    "identification": lambda s: hs.identify(measured(s), "mass-spring-damper", ["second-order-lowpass"]),
    "tolerances": lambda s: hs.tolerances(hs.load_scene("fu2019-tolerances").with_values({"zeta": s.knobs["zeta"].value}), samples=2, hand="light-touch"),
    "simulation": lambda s: hs.check(s, count=3),
    "release": lambda s: hs.release(s, "1 cm", "postural-arm"),
    "cost": lambda s: hs.cost(s, quick=True),
}  # fmt: skip
NOTHING = {("evaluation", "bandwidths"), ("metrics", "verdicts")}
"""What a scene without a range has not; and bars that are told apart by their place."""


def measured(scene: hs.Scene) -> hs.Measurement:
    exact = hs.sampled(scene, np.linspace(1, 15, 15))
    return hs.measured(exact.omega, exact.H * 1.02, radius=[4.0] * 15)


def axes() -> Axes:
    return Figure(layout="constrained").add_subplot()


def test_every_kind_of_answer_can_be_drawn() -> None:
    without = {"scenes", "schemas"}
    assert set(KINDS) - {"hardcosts"} == set(schema_names()) - without
    assert set(ANSWERS) == set(KINDS) - {"hardcosts", "jnd", "sweep"}


@pytest.mark.few("measured", "published")
@pytest.mark.parametrize("name", ANSWERS)
def test_two_scenes_are_drawn_on_one_axes_of_the_caller(name: str) -> None:
    one, other = ANSWERS[name](PAPER), ANSWERS[name](SLOW)
    for kind in KINDS[name]:
        if (name, kind) in NOTHING:
            continue
        ax = axes()
        assert one.plot(ax, kind=kind, label="first") is ax
        before = len(ax.get_children())
        assert other.plot(ax, kind=kind, label="second") is ax
        assert len(ax.get_children()) > before
        ax.figure.draw_without_rendering()
        told = [x.get_text() for x in ax.get_legend().get_texts()] if ax.get_legend() else []
        assert not told or any(x.endswith("first") for x in told), kind
        assert len(told) == len(set(told))


def test_style_goes_to_the_curves_and_their_entries_and_color_to_the_scene() -> None:
    ax = hs.evaluate(PAPER).plot(axes(), color="#8f5a9e", linewidth=3, alpha=0.5)
    curves = [x for x in ax.lines if str(x.get_label()).startswith("$r_")]
    assert {(x.get_linewidth(), x.get_alpha(), x.get_color()) for x in curves[:2]} == {(3, 0.5, "#8f5a9e")}
    handles = [x for x in ax.get_legend().legend_handles if x.get_linewidth() == 3]
    assert len(handles) == 2
    with pytest.raises(AttributeError, match="nonsense"):
        hs.evaluate(PAPER).plot(axes(), nonsense=1)


def test_what_cannot_be_drawn_is_said_with_what_can() -> None:
    with pytest.raises(hs.HaptisymError, match='did you mean "nyquist"'):
        hs.evaluate(PAPER).plot(axes(), kind="nyquis")
    with pytest.raises(hs.HaptisymError, match="regions=True"):
        hs.evaluate(PAPER).plot(axes(), kind="regions")


@pytest.mark.slow
def test_a_kind_that_an_answer_has_nothing_for_says_so() -> None:
    never = hs.tolerances(
        hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, "5").with_values({"zeta": "0.5 +- 5 %"}), samples=2
    )
    with pytest.raises(NothingToDrawError, match="nothing is met on the band"):
        never.plot(axes())
    wheel = hs.simulate("steering-wheel", hs.chirp("0.1 rad", "1 rad/s", "10 rad/s", "5 s"))
    with pytest.raises(NothingToDrawError, match="no ratio is recovered"):
        wheel.plot(axes(), kind="recovered-real")


@pytest.mark.slow
def test_a_map_of_what_is_stable_can_be_drawn_like_one_of_what_is_transparent() -> None:
    plane = ["k", "tau"], [(20, 1000), ("0.001", "0.05")]
    found = hs.design_map("delayed-spring", *plane, slices=3, that=["stable"], hand="light-touch")
    told = [x.get_text() for x in found.plot(axes(), kind="map").get_legend().get_texts()]
    assert any(x.endswith(", axis") for x in told)


def test_the_first_scene_stays_in_sight() -> None:
    ax = hs.evaluate("virtual-wall").plot(axes())
    reach = ax.get_xlim()
    assert hs.evaluate(PAPER).plot(ax).get_xlim() == reach


@pytest.mark.slow
def test_new_axes_are_those_of_pyplot_and_nothing_else_changes() -> None:
    script = """
import matplotlib
matplotlib.use("agg")
import haptisym as hs
before = dict(matplotlib.rcParams)
ax = hs.evaluate("fu2019").plot()
from matplotlib import pyplot
assert pyplot.gcf() is ax.figure and pyplot.get_fignums() == [1]
assert dict(matplotlib.rcParams) == before
"""
    subprocess.run([sys.executable, "-W", "error", "-c", script], check=True)


def test_eyes_without_some_cones_confuse_what_they_are_known_to() -> None:
    for eye in EYES:
        assert difference("#ffffff", "#808080", eye) > 40
        assert difference("#777777", "#777777", eye) == 0
    red, green = "#c05030", "#708000"
    assert difference(red, green, "usual") > 3 * difference(red, green, "no middle cones")
    assert difference("#00a0a0", "#5090c0", "usual") > difference("#00a0a0", "#5090c0", "no short cones")


@pytest.mark.parametrize("eye", EYES)
def test_colours_of_scenes_and_curves_are_told_apart_by_every_eye(eye: str) -> None:
    pairs = [*combinations(SCENES, 2), (CURVES[0][0], CURVES[1][0])]
    assert min(difference(one, other, eye) for one, other in pairs) > 20


def test_scenes_are_told_apart_in_print_and_curves_by_their_strokes() -> None:
    assert min(abs(lightness(x) - lightness(y)) for x, y in combinations(SCENES, 2)) > 10
    assert CURVES[0][1] != CURVES[1][1]
    ax = axes()
    for omega_n in (80, 60, 50, 40):
        hs.evaluate(PAPER.with_values({"omega_n": omega_n})).plot(ax, label=f"{omega_n}")
    lines = [x for x in ax.lines if str(x.get_label()).startswith("$r_") and x.get_linestyle() != "None"]
    looks = [(str(x.get_linestyle()), lightness(str(x.get_color()))) for x in lines]
    assert len(looks) == 8
    assert all(a[0] != b[0] or abs(a[1] - b[1]) > 10 for a, b in combinations(looks, 2))
