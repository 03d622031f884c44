"""Hands in figures: their names meet neither each other, nor the dashed line, nor the edge of the axes; and what they are asked for."""

from __future__ import annotations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.figures.require import draw_requirement
from haptisym.figures.stability import stability_figure
from haptisym.figures.wishes import draw_wishes

HEAVY = hs.Hand("heavy", m="600 kg", b="5 kN*s/m", k="20 kN/m")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fu2019", "delayed-spring"])
def test_names_of_hands_stand_free(name: str) -> None:
    """At fu2019 device-operator lay on the line of the root at 0; behind a delay two names left the axes or met the number."""
    found = hs.stability(name, "postural-arm")
    figure = stability_figure(found)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    [ax] = figure.axes
    boxes = [x.get_window_extent(canvas.get_renderer()) for x in ax.texts if isinstance(x, Annotation)]
    assert len(boxes) >= 6
    at_0 = float(ax.transData.transform((-100.0, 0.0))[0])  # both environments have 100 N/m
    edge = ax.get_window_extent()
    for i, box in enumerate(boxes):
        assert edge.x0 < box.x0
        assert box.x1 < edge.x1
        assert edge.y0 <= box.y0 + 0.25 * box.height
        if box.height < 12 * figure.dpi / 72 and box.width > 3 * box.height:  # a name, no number
            assert not box.x0 < at_0 < box.x1
        assert not any(
            box.overlaps(other) and box.intersection(box, other).height > 0.3 * box.height for other in boxes[:i]
        )


@pytest.mark.slow
def test_hands_whose_marks_cover_each_other_have_one_name() -> None:
    """Beside a hand of 20 kN/m all published ones lie in one mark; their names lay on each other."""
    figure = stability_figure(hs.stability("satellite-contact", HEAVY))
    [ax] = figure.axes
    names = [x.get_text() for x in ax.texts if isinstance(x, Annotation) and not x.get_text().isdigit()]
    assert sorted(names) == [f"{len(hs.hands)} published hands", "heavy"]


def test_a_number_of_a_hand_is_drawn_though_it_has_no_course_along_the_band() -> None:
    """A figure of it ended in an error about the parameters of the ratios."""
    ax = Figure().add_subplot()
    assert draw_requirement(ax, hs.require("satellite-contact", "hand.m", that=["stable"], hand=HEAVY)) == []
    [dots] = [x for x in ax.lines if x.get_marker() == "o"]
    assert list(dots.get_xdata()) == [500]


def test_between_slices_of_different_kind_a_map_is_hatched_and_shows_no_boundary() -> None:
    """It drew one halfway, at 550 kg, where it is at 500 kg."""
    ranges = [(400, 800), (0, 6000)]
    free = ["hand.m", "hand.b"]
    found = hs.design_map("satellite-contact", free, ranges, that=["stable"], hand=HEAVY, slices=5)
    ax = Figure().add_subplot()
    told = [str(x.get_label()) for x in draw_wishes(ax, found)]
    assert not [x for x in ax.lines if len(x.get_xdata())]
    assert {"undecided", "stable: ends on no slice"} <= set(told)
    [hatched] = [x.get_paths()[0].get_extents() for x in ax.collections if x.get_hatch()]
    assert (hatched.x0, hatched.x1) == (500, 600)
