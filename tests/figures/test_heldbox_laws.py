"""The plane of a hand, by laws: rectangles given in shares of the plane lie where its numbers are, and what is asked is what is drawn."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from sympy import Rational

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.heldbox import draw_held, hands_figure
from haptisym.kernel.errors import NothingToDrawError, UndecidedError
from haptisym.verbs.tolerances.heldplane import HeldPlane

SPRING, WALL, WHEEL = "delayed-spring", "sampled-wall", "steering-wheel"
NONE = np.empty((0, 2, 2))
HALVES = HeldPlane(
    stable=np.array([[[0.5, 1.0], [0.0, 1.0]]]), unstable=np.array([[[0.0, 0.25], [0.0, 1.0]]]),
    left=np.array([[[0.25, 0.5], [0.0, 0.5]], [[0.25, 0.5], [0.5, 1.0]]]),
)  # fmt: skip
"""In shares of both ranges: from the half on stable, the first quarter not, two cells between."""
MINE = hs.Hand("mine", m="0.5 kg", b=["4 N*s/m", "7 N*s/m"], k="2000 N/m")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is asked of the proof, which is answered as above."""
    found: list[Any] = []

    def held_plane(scene: Any, hands: Any, plane: Any, others: Any, *, finest: float, most: int) -> HeldPlane:
        found.append(SimpleNamespace(scene=scene, hands=hands, plane=plane, others=others, finest=finest, most=most))
        return HALVES

    monkeypatch.setattr("haptisym.figures.heldbox.held_plane", held_plane)
    return found


def held(scene: hs.Scene | str, *hands: hs.Hand) -> Any:
    own = hs.load_scene(scene) if isinstance(scene, str) else scene
    return SimpleNamespace(held=[SimpleNamespace(hand=x) for x in hands], box=SimpleNamespace(scene=own))


def drawn(scene: hs.Scene | str, *hands: hs.Hand) -> tuple[Axes, list[Any]]:
    ax = Figure(figsize=(5, 4)).add_subplot()
    return ax, draw_held(ax, held(scene, *hands))


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def grounds(ax: Axes) -> list[tuple[str, list[list[float]]]]:
    """Colours and the rectangles that have them: left, bottom, right, top."""
    return [
        (to_hex(x.get_facecolor()[0]), [list(map(float, p.get_extents().extents)) for p in x.get_paths()])  # type: ignore[index]
        for x in ax.collections
    ]


def test_grounds_lie_where_their_shares_of_the_plane_are(asked: list[Any]) -> None:
    """The largest stiffness is 2000 N/m, of the own hand: the axes go from -1/20 of it to a quarter beyond."""
    ax, _ = drawn(SPRING, MINE)
    low, high = -100, 2500
    assert ax.get_xlim() == (pytest.approx(low), pytest.approx(high))
    least, most = ax.get_ylim()
    first, second, third = grounds(ax)
    assert [x[0] for x in (first, second, third)] == ["#ffffff", pen.UNSTABLE, pen.SHADE]
    quarter, half, middle = low + (high - low) / 4, low + (high - low) / 2, (least + most) / 2
    assert first[1] == [pytest.approx([half, least, high, most])]
    assert second[1] == [pytest.approx([low, least, quarter, most])]
    assert third[1] == [
        pytest.approx([quarter, least, half, middle]),
        pytest.approx([quarter, middle, half, most]),
    ]
    free = asked[0].plane
    assert [tuple(map(float, x)) for x in free.values()] == [(low, high), (pytest.approx(least), pytest.approx(most))]
    assert list(free) == [MINE.k.symbol, MINE.b.symbol]


def test_the_window_has_room_for_the_upper_ends_of_all_hands_also_of_published_ones(asked: list[Any]) -> None:
    damped = hs.Hand("damped", m="0.5 kg", b=["4 N*s/m", "700 N*s/m"], k=["1 N/m", "2 N/m"])
    ax, _ = drawn(SPRING, damped)
    assert ax.get_ylim() == (pytest.approx(-0.05 * 700), pytest.approx(1.25 * 700))
    stiffest = max(float(x.k.value) for x in hs.hands.values())
    assert ax.get_xlim() == (pytest.approx(-0.05 * stiffest), pytest.approx(1.25 * stiffest))
    assert len(asked) == 1


def test_with_a_clock_the_plane_begins_at_nothing_and_has_no_line(asked: list[Any]) -> None:
    ax, made = drawn(WALL, MINE)
    assert (ax.get_xlim()[0], ax.get_ylim()[0]) == (0, 0)
    assert ax.get_xlim()[1] == pytest.approx(2500)
    assert not any(str(x.get_label()).startswith("nominal boundary") for x in made)
    assert not [x for x in ax.lines if len(x.get_xdata()) > 1]
    assert len(asked) == 1


def test_a_turning_display_shows_no_published_hands_and_a_window_without_numbers_has_some(asked: list[Any]) -> None:
    turning = hs.Hand("turning", m="0.01 kg*m^2", b=0, k=0)
    ax, _ = drawn(WHEEL, turning)
    assert ax.get_xlim() == (pytest.approx(-5), pytest.approx(125))
    assert ax.get_ylim() == (pytest.approx(-0.05), pytest.approx(1.25))
    assert [x.get_text() for x in ax.texts if x.get_text()] == ["turning"]
    assert "N·m/rad" in ax.get_xlabel()
    assert "0.01 kg·m²" in ax.get_xlabel()
    assert asked[0].hands == [turning]


def test_legend_and_grounds_go_together_and_what_there_is_none_of_is_not_told(
    asked: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    ax, made = drawn(SPRING, MINE)
    assert told(ax) == [
        "stable for all values", "for none", "it depends, or not shown", "nominal boundary", "of this mass", "of another",
    ]  # fmt: skip
    patches = [x for x in made if isinstance(x, Patch)]
    assert [to_hex(x.get_facecolor()) for x in patches] == ["#ffffff", pen.UNSTABLE, pen.SHADE]
    assert all(to_hex(x.get_edgecolor()) == "#000000" for x in patches)  # white is seen on white
    monkeypatch.setattr("haptisym.figures.heldbox.held_plane", lambda *_, **__: HeldPlane(NONE, HALVES.unstable, NONE))
    ax, _ = drawn(SPRING, MINE)
    assert told(ax)[:2] == ["for none", "nominal boundary"]
    assert [x[0] for x in grounds(ax)] == [pen.UNSTABLE]
    assert len(asked) == 1


def test_the_nominal_boundary_is_where_a_hand_is_on_the_verge(asked: list[Any]) -> None:
    """A root at jω: 0.5 (jω)² + b jω + k + 100 e^(-36 ms jω) is 0, for the mass of the first hand."""
    ax, _ = drawn(SPRING, MINE)
    [line] = [x for x in ax.lines if len(x.get_xdata()) > 100]
    k, b = (np.asarray(x, float) for x in line.get_data())
    seen = (k > 0) & (k < 2500) & (b > ax.get_ylim()[0]) & (b < ax.get_ylim()[1])
    assert seen.any()
    spring, late = 100.0, 0.036
    omega = np.linspace(0.01, 80, 8001)
    verge_k, verge_b = 0.5 * omega**2 - spring * np.cos(late * omega), spring * np.sin(late * omega) / omega
    for x, y in zip(k[seen][::50], b[seen][::50], strict=True):
        assert np.hypot((verge_k - x) / 2500, (verge_b - y) / 10).min() < 1e-3
    assert len(asked) == 1


def test_the_label_tells_the_mass_or_its_range(asked: list[Any]) -> None:
    ax, _ = drawn(SPRING, MINE)
    assert "for a hand of 0.5 kg" in ax.get_xlabel()
    ax, _ = drawn(SPRING, hs.Hand("light", m=["0.2 kg", "0.3 kg"], b=4, k=10))
    assert "for a hand of 0.2 to 0.3 kg" in ax.get_xlabel()
    assert len(asked) == 2


def test_values_in_ranges_and_a_mass_in_one_are_what_is_held_against_all_of_and_the_more_the_coarser(
    asked: list[Any],
) -> None:
    light = hs.Hand("light", m=["0.2 kg", "0.3 kg"], b=4, k=10)
    plain = hs.load_scene(SPRING).with_values({"k": 100, "tau": "0.036"})
    loose = plain.with_values({"k": "100 N/m +- 20 %"})
    both = loose.with_values({"tau": "36 ms +- 5 %"})
    for scene, hand, count in (
        (plain, MINE, 0),
        (loose, MINE, 1),
        (plain, light, 1),
        (loose, light, 2),
        (both, light, 3),
    ):
        drawn(scene, hand)
        ends = sorted(tuple(map(float, x)) for x in asked[-1].others.values())
        expected = [(0.0342, 0.0378)] * (scene is both) + [(0.2, 0.3)] * (hand is light)
        expected += [(80.0, 120.0)] * (scene is not plain)
        assert np.array(ends) == pytest.approx(np.array(expected))
        assert len(ends) == count
        assert asked[-1].finest == {0: 1 / 256, 1: 1 / 128}.get(count, 1 / 64)
        assert asked[-1].most == 100_000
        assert asked[-1].hands == [hand]
    assert light.m.symbol in asked[-1].others
    assert asked[-1].others[light.m.symbol] == (Rational(1, 5), Rational(3, 10))


def test_a_range_of_the_threshold_is_none_of_the_display(asked: list[Any]) -> None:
    uncertain = hs.load_scene(SPRING).with_values({"c": ["0.08", "0.12"]})
    assert uncertain.ranges()
    drawn(uncertain, MINE)
    assert (asked[0].others, asked[0].finest) == ({}, 1 / 256)


def test_of_several_hands_the_plane_is_of_the_first_and_each_has_its_mark(asked: list[Any]) -> None:
    other = hs.Hand("other", m="0.7 kg", b=3, k=900)
    ax, _ = drawn(SPRING, MINE, other)
    assert asked[0].hands == [MINE]
    assert "of 0.5 kg" in ax.get_xlabel()
    places = {tuple(float(v[0]) for v in x.get_data()): x for x in ax.lines if len(x.get_xdata()) == 1}
    assert to_hex(places[2000, 5.5].get_markerfacecolor()) == pen.INK
    assert places[900, 3].get_markerfacecolor() == "none"
    [box] = [x for x in ax.patches if x.get_height() > 2]  # type: ignore[attr-defined]
    assert (box.get_y(), box.get_height()) == (4, 3)  # type: ignore[attr-defined]


def test_a_published_hand_that_is_asked_about_is_shown_once(asked: list[Any]) -> None:
    name = "postural-arm"
    ax, _ = drawn(SPRING, hs.hands[name])
    own = hs.hands[name]
    at = (float(own.k.value), float(own.b.value))
    assert sum(tuple(float(v[0]) for v in x.get_data()) == at for x in ax.lines if len(x.get_xdata()) == 1) == 1
    assert [x.get_text() for x in ax.texts].count(name) == 1
    assert len(asked) == 1


def test_without_a_hand_or_knowledge_there_is_nothing_to_draw(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(NothingToDrawError, match="no hand was asked about"):
        drawn(SPRING)

    def unknown(*_: Any, **__: Any) -> HeldPlane:
        raise UndecidedError("whether roots come from infinity")

    monkeypatch.setattr("haptisym.figures.heldbox.held_plane", unknown)
    with pytest.raises(NothingToDrawError, match="of hands held nothing is known: whether roots come"):
        drawn(SPRING, MINE)


def test_the_sheet_is_the_plane_alone_below_its_legend(asked: list[Any]) -> None:
    figure = hands_figure(held(SPRING, MINE))
    [ax] = figure.axes
    legend = ax.get_legend().get_window_extent().height / figure.dpi
    assert figure.get_figheight() == pytest.approx(2.6 + legend)
    assert told(ax)[0] == "stable for all values"
    assert len(asked) == 1
