"""The region of one frequency, by laws: tips, sides, bars and frames written out in complex numbers."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.effects import first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.square import draw_jnd_square
from haptisym.model.regions import Region, Shape

ENV, PERC = r"$H_\mathrm{env}$", r"$H_\mathrm{perc}$"
DISC = hs.Threshold("0.1", "0.1", region=Region(Shape.ELLIPSE))
MASS = hs.Scene(mass_spring_damper(m=1, k=100, b=4), (shunt(m="0.5"),), (0, 30), hs.Threshold.of("0.1", "0.3"))
"""100 - ω² + 4 jω, and half a kilogram more."""


def axes() -> Axes:
    return Figure(figsize=(5, 5)).add_subplot()


@cache
def evaluated(scene: hs.Scene) -> hs.Evaluation:
    return hs.evaluate(scene)


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def points(line: Line2D) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)]  # type: ignore[arg-type]


def bars(ax: Axes) -> list[list[tuple[float, float]]]:
    return [points(x) for x in ax.lines if x.get_linewidth() == 3]


def test_the_square_and_its_bars_reach_from_the_tip_as_far_as_each_threshold_lets() -> None:
    """At 8 rad/s the tip is 36 + 32 j, of the size √2320."""
    ax = axes()
    region, *_ = draw_jnd_square(ax, evaluated(MASS), 8)
    size = np.sqrt(36**2 + 32**2)
    assert isinstance(region, Rectangle)
    assert region in ax.patches
    assert (region.get_x(), region.get_y()) == (pytest.approx(36 - 0.1 * size), pytest.approx(32 - 0.3 * size))
    assert (region.get_width(), region.get_height()) == (pytest.approx(0.2 * size), pytest.approx(0.6 * size))
    across, up = bars(ax)
    assert np.array(across) == pytest.approx(np.array([(36 - 0.1 * size, 0), (36 + 0.1 * size, 0)]))
    assert np.array(up) == pytest.approx(np.array([(0, 32 - 0.3 * size), (0, 32 + 0.3 * size)]))
    looks = {(to_hex(x.get_color()), x.get_alpha(), x.get_solid_capstyle()) for x in ax.lines if x.get_linewidth() == 3}
    assert looks == {(pen.GREY, 0.5, "butt")}
    assert (to_hex(region.get_facecolor()), to_hex(region.get_edgecolor())) == (pen.SHADE, pen.GREY)
    assert (region.get_linewidth(), region.get_label()) == (0.6, "not noticed")


def test_arrows_go_from_the_origin_to_both_tips_and_dotted_lines_from_the_tips_to_both_axes() -> None:
    ax = axes()
    _, *arrows = draw_jnd_square(ax, evaluated(MASS), 8)
    tips = [(36.0, 32.0), (4.0, 32.0)]
    dotted = [points(x) for x in ax.lines if len(x.get_xdata()) == 3]
    looks = ((pen.BLUE, "-"), (pen.RED, "--"))
    for arrow, (x, y), way, (color, style) in zip(arrows, tips, dotted, looks, strict=True):
        assert isinstance(arrow, Annotation)
        assert arrow.xy == (pytest.approx(x), pytest.approx(y))
        assert arrow.xyann == (0, 0)
        assert (to_hex(arrow.arrow_patch.get_edgecolor()), arrow.arrow_patch.get_linewidth()) == (color, 1.2)
        assert (arrow.arrow_patch.get_linestyle() == "-") == (style == "-")
        assert np.array(way) == pytest.approx(np.array([(x, 0), (x, y), (0, y)]))
    heads = [x for x in ax.texts if isinstance(x, Annotation) and x not in arrows]
    for head, (x, y), (color, _) in zip(heads, tips, looks, strict=True):
        assert head.xy == (pytest.approx(x), pytest.approx(y))
        assert head.xyann == (pytest.approx(0.95 * x), pytest.approx(0.95 * y))
        assert to_hex(head.arrow_patch.get_facecolor()) == color
    assert {to_hex(x.get_color()) for x in ax.lines if len(x.get_xdata()) == 3} == {pen.BLUE, pen.RED}


def test_the_frame_holds_the_origin_both_tips_and_the_square_at_equal_scales() -> None:
    """From 0 to 36 + 0.1 √2320, and from 0 to 32 + 0.3 √2320, with 7 % more to each side."""
    ax = axes()
    draw_jnd_square(ax, evaluated(MASS), 8)
    size = np.sqrt(36**2 + 32**2)
    for (low, high), most in ((ax.get_xlim(), 36 + 0.1 * size), (ax.get_ylim(), 32 + 0.3 * size)):
        assert (low, high) == (pytest.approx(-0.07 * most), pytest.approx(1.07 * most))
    assert ax.get_aspect() == 1


def test_a_frame_is_never_flatter_than_three_fifths() -> None:
    """Of a spring of 100 N/m alone, 1 N/m more: the square is from 90 to 110 and from -10 to 10."""
    ax = axes()
    spring = hs.Scene(mass_spring_damper(k=100), (shunt(k=1),), (0, 15), "0.1")
    draw_jnd_square(ax, evaluated(spring), 5)
    assert ax.get_xlim() == (pytest.approx(55 - 0.57 * 110), pytest.approx(55 + 0.57 * 110))
    assert ax.get_ylim() == (pytest.approx(-0.57 * 66), pytest.approx(0.57 * 66))


def test_a_frame_to_the_left_of_the_origin_is_as_wide_as_one_to_its_right() -> None:
    """At 20 rad/s the tips are -300 + 80 j and -500 + 80 j, and the square is from 80 - 93.1 to 80 + 93.1 high."""
    ax = axes()
    draw_jnd_square(ax, evaluated(MASS), 20)
    assert ax.get_xlim() == (pytest.approx(-250 - 0.57 * 500), pytest.approx(-250 + 0.57 * 500))
    assert ax.get_ylim() == (pytest.approx(80 - 0.57 * 300), pytest.approx(80 + 0.57 * 300))


def test_where_nothing_is_felt_there_is_a_spot_at_the_origin_and_a_frame() -> None:
    """A damper at 0 rad/s."""
    ax = axes()
    damper = evaluated(hs.Scene(mass_spring_damper(b=2), (first_order_lag(20),), (0, 15), "0.1"))
    region, *tips = draw_jnd_square(ax, damper, 0)
    assert isinstance(region, Rectangle)
    assert (region.get_width(), region.get_height()) == (0, 0)
    for spot, color in zip(tips, (pen.BLUE, pen.RED), strict=True):
        assert isinstance(spot, Line2D)
        assert points(spot) == [(0, 0)]
        assert (spot.get_marker(), to_hex(spot.get_color())) == ("o", color)
    assert not [x for x in ax.texts if isinstance(x, Annotation)]
    assert (ax.get_xlim(), ax.get_ylim()) == ((-0.57, 0.57), (-0.57, 0.57))


def test_the_legend_tells_curves_region_projections_and_bars() -> None:
    ax = axes()
    draw_jnd_square(ax, evaluated(MASS), 8)
    assert told(ax) == [ENV, PERC, "not noticed", "projections", "not noticed in one part"]
    dotted, bar = ax.get_legend().legend_handles[3:]
    assert (to_hex(dotted.get_color()), dotted.get_linewidth()) == (pen.INK, 0.6)
    assert dotted.get_linestyle() == ":" or dotted.is_dashed()
    assert (to_hex(bar.get_color()), bar.get_linewidth(), bar.get_alpha()) == (pen.GREY, 3, 0.5)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\mathrm{Re}\,H$ (N/m)", r"$\mathrm{Im}\,H$ (N/m)")


def test_the_title_stands_above_the_legend() -> None:
    ax = axes()
    draw_jnd_square(ax, evaluated(MASS), 8)
    ax.figure.draw_without_rendering()
    legend, title = ax.get_legend().get_window_extent(), ax.title.get_window_extent()
    assert legend.y1 - 1 <= title.y0 <= legend.y1 + 14 * ax.figure.dpi / 72


def test_a_tip_on_an_axis_has_an_arrow_too() -> None:
    """A spring of 100 N/m and 10 N/m more, just a tenth, so that it is not noticed."""
    ax = axes()
    spring = hs.Scene(mass_spring_damper(k=100), (shunt(k=10),), (0, 15), "0.1")
    _, *arrows = draw_jnd_square(ax, evaluated(spring), 5)
    assert [x.xy for x in arrows if isinstance(x, Annotation)] == [(100, 0), (110, 0)]
    assert ax.get_title().endswith(": not noticed")


# Words


@pytest.mark.parametrize(
    ("omega", "said"),
    [
        (2, "not noticed"),
        (9, "noticed in the real part"),
        (0, "not noticed"),
        (30, "noticed in the real part"),
    ],
)
def test_the_title_tells_what_of_the_change_is_noticed(omega: float, said: str) -> None:
    """The change is -ω²/2, against a tenth of the size."""
    ax = axes()
    draw_jnd_square(ax, evaluated(MASS), omega)
    assert ax.get_title() == rf"$\omega$ = {omega} rad/s: {said}"
    env = 100 - omega**2 + 4j * omega
    assert (omega**2 / 2 > 0.1 * abs(env)) == (said != "not noticed")


def test_the_imaginary_part_alone_is_said_to_be_noticed_where_it_is() -> None:
    """100 + 3 jω behind 1/(1 + jω/20): from 2.0117 rad/s on, and the real part from 12.03 on."""
    lagged = evaluated(hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag(20),), (0, 30), "0.1"))
    for omega in (5, 20):
        ax = axes()
        draw_jnd_square(ax, lagged, omega)
        change = (100 + 3j * omega) * (1 / (1 + 1j * omega / 20) - 1)
        out = [abs(x) > 0.1 * abs(100 + 3j * omega) for x in (change.real, change.imag)]
        assert out == ([False, True] if omega == 5 else [True, True])
        said = "the imaginary part" if omega == 5 else "both parts"
        assert ax.get_title() == rf"$\omega$ = {omega} rad/s: noticed in {said}"


def test_a_disc_is_drawn_as_one_and_told_by_its_name() -> None:
    """At 5 rad/s about 100 + 15 j, with a tenth of its size."""
    lagged = evaluated(hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag(20),), (0, 30), DISC))
    ax = axes()
    region, *_ = draw_jnd_square(ax, lagged, 5)
    assert isinstance(region, Polygon)
    tip, reach = 100 + 15j, 0.1 * abs(100 + 15j)
    border: Any = region.get_xy()
    assert np.abs(border @ [1, 1j] - tip) == pytest.approx(np.full(len(border), reach))
    assert ax.get_title().endswith(": outside the ellipse")
    across, up = bars(ax)
    assert [x for x, _ in across] == pytest.approx([100 - reach, 100 + reach])
    assert [y for _, y in up] == pytest.approx([15 - reach, 15 + reach])
    ax = axes()
    draw_jnd_square(ax, lagged, 1)
    assert ax.get_title().endswith(": not noticed")


def test_limits_for_each_way_have_a_patch_and_a_bar_for_each_stretch_and_one_entry() -> None:
    """At 9 rad/s the tip is 19 + 36 j: as strong on the other side of 0 it is a change of 38, within 1.2 times its size."""
    ax, jnd = axes(), {"real": {"higher": "1.2", "lower": "0.1"}, "imag": "0.1"}
    region, *_ = draw_jnd_square(ax, evaluated(hs.Scene(mass_spring_damper(1, 4, 100), (), (0, 30), jnd)), 9)
    size = np.hypot(19, 36)
    stretches = [(19 - 1.2 * size, -19), (19 - 0.1 * size, 19 + 1.2 * size)]
    sides = [(x.get_x(), x.get_x() + x.get_width()) for x in ax.patches if isinstance(x, Rectangle)]
    assert np.array(sides) == pytest.approx(np.array(stretches))
    drawn = bars(ax)
    assert np.array([[x for x, _ in bar] for bar in drawn[:2]]) == pytest.approx(np.array(stretches))
    assert [y for _, y in drawn[2]] == pytest.approx([36 - 0.1 * size, 36 + 0.1 * size])
    assert [x.get_label() for x in ax.patches] == ["not noticed", "_nolegend_"]
    assert region is ax.patches[0]
    assert ax.get_xlim()[0] < 19 - 1.2 * size
    assert ax.get_xlim()[1] > 19 + 1.2 * size


def test_a_frequency_in_hertz_is_told_in_hertz() -> None:
    ax = axes()
    wheel = evaluated(hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag("5 Hz"),), ("0 Hz", "4 Hz"), "0.1"))
    draw_jnd_square(ax, wheel, 2 * np.pi * 1.5)
    assert ax.get_title().startswith("1.5 Hz: ")
    ax = axes()
    draw_jnd_square(ax, wheel, 1)
    assert ax.get_title().startswith("0.1592 Hz: ")


def test_outside_of_the_band_there_is_nothing_to_draw() -> None:
    beyond = evaluated(hs.Scene(mass_spring_damper(k=100), (), (3, 15), "0.1"))
    for omega in (2.9, 15.1):
        with pytest.raises(hs.SceneError, match=f"{omega} rad/s is not on the band, 3 to 15"):
            draw_jnd_square(axes(), beyond, omega)
    for omega in (3, 15):
        draw_jnd_square(axes(), beyond, omega)


# A further scene


def test_a_further_scene_is_an_outline_in_its_colour_whose_verdict_is_in_the_legend() -> None:
    ax = axes()
    first, *_ = draw_jnd_square(ax, evaluated(MASS), 2, label="near")
    title, strips, wide = ax.get_title(), bars(ax), ax.get_xlim()
    other = hs.Scene(mass_spring_damper(k=300, b=3), (first_order_lag(20),), (0, 30), "0.1")
    second, *arrows = draw_jnd_square(ax, evaluated(other), 5, label="stiff")
    assert (ax.get_title(), bars(ax)) == (title, strips)
    assert isinstance(first, Rectangle)
    assert isinstance(second, Rectangle)
    assert second.get_facecolor()[3] == 0
    assert to_hex(second.get_edgecolor()) == pen.SCENES[1]
    assert second.get_center() == pytest.approx((300, 15))
    assert told(ax) == [
        f"{ENV}, near", f"{PERC}, near", "not noticed", "projections", "not noticed in one part",
        f"{ENV}, stiff", f"{PERC}, stiff: noticed in the imaginary part", "not noticed, stiff",
    ]  # fmt: skip
    assert {to_hex(x.arrow_patch.get_edgecolor()) for x in arrows} == {pen.SCENES[1]}  # type: ignore[attr-defined]
    left, right = ax.get_xlim()
    assert left <= wide[0]
    assert right > 300 + 0.1 * abs(300 + 15j)
    assert sum(points(x) == [(0, 0), (1, 0)] for x in ax.lines) == 1
