"""The plane of a hand of tolerances: what is tinted, against sets of values counted one by one."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from sympy import Rational

import haptisym as hs
from haptisym.figures.heldbox import draw_held
from haptisym.figures.pen import UNSTABLE
from haptisym.figures.stability import draw_boxes, draw_points
from haptisym.verbs.stability.held import unstable_roots
from haptisym.verbs.stability.plane import Plane
from haptisym.writing.document import figures_of

SPRING = hs.load_scene("delayed-spring")
LATE = SPRING.with_values({"k": "100 N/m +- 20 %"})


def drawn(scene: hs.Scene, hand: hs.Hand) -> Axes:
    ax: Axes = Figure().add_subplot()
    draw_held(ax, hs.tolerances(scene, samples=0, hand=hand))
    return ax


def ground(ax: Axes, k: float, b: float) -> str:
    """The color under a hand."""
    [found] = {
        to_hex(x.get_facecolor()[0]) for x in ax.collections if any(p.contains_point((k, b)) for p in x.get_paths())
    }
    return str(found)


@pytest.mark.slow
def test_grounds_are_what_is_counted_at_single_values_of_hand_and_display() -> None:
    hand = hs.Hand("mine", m="0.554 kg", b=["6 N*s/m", "7 N*s/m"], k="135 N/m")
    ax = drawn(LATE, hand)
    seen = set()
    for b in ("1", "2.2", "3.5", "4.9", "8"):
        color = ground(ax, 50, float(b))
        seen.add(color)
        counts = [
            unstable_roots(
                LATE.with_values({"k": k, "tau": tau}), hs.Hand("x", m="0.554 kg", b=Rational(b), k=50)
            ).number
            for k in (80, 120)
            for tau in (Rational("0.0324"), Rational("0.0396"))
        ]
        if color == "#ffffff":
            assert counts == [0] * 4
        elif color == UNSTABLE:
            assert all(counts)
    assert len(seen) == 3
    assert "for a hand of 0.554 kg" in ax.get_xlabel()


def test_a_hand_alone_leaves_a_line_between_both_grounds() -> None:
    """Critical for a mass of 0.5 kg, k = 0: 3.4635997 N s/m."""
    ax = drawn(SPRING, hs.Hand("mine", m="0.5 kg", b=["4 N*s/m", "7 N*s/m"]))
    assert (ground(ax, 0, 3.3), ground(ax, 0, 3.6)) == (UNSTABLE, "#ffffff")


@pytest.mark.slow
def test_with_a_clock_grounds_are_those_of_the_sampled_loop() -> None:
    """T = 1 ms, a device of 0.04 kg and 0.8 N s/m, no mass of the hand: about 2 (0.8 + b_h)/T."""
    wall = hs.Scene(
        hs.environments.mass_spring_damper(k=["2300 N/m", "2400 N/m"]),
        (hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(m="40 g", b="0.8 N*s/m")),
    )
    ax = drawn(wall, hs.hands["firm-grip"])
    assert (ground(ax, 10, 0.05), ground(ax, 10, 2)) == (UNSTABLE, "#ffffff")


def test_without_a_hand_there_is_no_plane() -> None:
    lagged = hs.Scene(hs.environments.mass_spring_damper(k="100 N/m +- 10 %"), (hs.effects.first_order_lag(40),))
    with pytest.raises(hs.HaptisymError, match="no hand was asked about"):
        hs.tolerances(lagged, samples=0).plot(Figure().add_subplot(), kind="hands")


@pytest.mark.parametrize(("name", "line"), [("delayed-spring", True), ("sampled-wall", False)])
def test_the_caption_speaks_of_a_line_where_there_is_one(name: str, *, line: bool) -> None:
    found = hs.tolerances(name, samples=0, hand=hs.Hand("mine", m="45 g", b=["3 N*s/m", "3.1 N*s/m"], k=100))
    [figure] = [x for x in figures_of(found.document().blocks) if x.name == "hands"]
    assert ("Line: " in str(figure.caption)) is line


@pytest.mark.parametrize("ranges", [{"k": ["80 N/m", "200 N/m"]}, {"b": ["2 N*s/m", "7 N*s/m"]}])
def test_the_name_of_a_hand_is_not_crossed_by_its_own_box(ranges: dict[str, list[str]]) -> None:
    """A range of one number alone makes the box a line through its hand."""
    hand = hs.Hand("mine", **{"m": "0.5 kg", "b": "5 N*s/m", "k": "135 N/m", **ranges})
    ax: Axes = Figure(figsize=(4, 3)).add_subplot()
    ax.set(xlim=(0, 300), ylim=(0, 10))
    draw_boxes(ax, [hand])
    draw_points(ax, [hand], [], Plane(0.5, np.empty(0), np.empty(0), None, (0, 300, 0, 10)))
    [name], [box] = ax.texts, ax.patches
    assert not name.get_window_extent().overlaps(box.get_window_extent())
