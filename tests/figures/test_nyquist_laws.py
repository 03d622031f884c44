"""The curves in the complex plane, by laws: straight lines and circles whose points, lengths and ends are known by hand."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

import haptisym as hs
from haptisym.effects import first_order_lag, second_order_lowpass, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import pen
from haptisym.figures.nyquist import _window, draw_nyquist

ENV, PERC, RISING = r"$H_\mathrm{env}$", r"$H_\mathrm{perc}$", "rising frequency"


def axes() -> Axes:
    return Figure(figsize=(4, 4)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def spots(ax: Axes) -> list[Line2D]:
    return [x for x in ax.lines if x.get_linestyle() == "None"]


def place(spot: Line2D) -> complex:
    return complex(float(np.ravel(spot.get_xdata())[0]), float(np.ravel(spot.get_ydata())[0]))


def heads(ax: Axes) -> list[Annotation]:
    return [x for x in ax.texts if isinstance(x, Annotation)]


@cache
def identity(high: float = 20, low: float = 0, *, hertz: bool = False) -> hs.Evaluation:
    """100 + 3 jω on both curves: upright lines along which the frequency is Im H/3."""
    band = (f"{low} Hz", f"{high} Hz") if hertz else (low, high)
    return hs.evaluate(hs.Scene(mass_spring_damper(k=100, b=3), (), band))


def frequencies(ax: Axes) -> list[float]:
    return [place(x).imag / 3 for x in spots(ax)[::2]]


# Marks


@pytest.mark.parametrize(
    ("low", "high", "marked"),
    [(0, 47, [16, 31, 47]), (2, 9.96, [4.7, 7.3, 9.9]), (0, 0.3, [0.1, 0.2, 0.3]), (1000, 5000, [2300, 3700, 5000])],
)
def test_marks_are_thirds_of_the_band_as_numbers_of_two_digits_and_none_beyond_it(
    low: float, high: float, marked: list[float]
) -> None:
    ax = axes()
    draw_nyquist(ax, identity(high, low))
    assert frequencies(ax) == pytest.approx(marked)
    assert told(ax)[3:] == [f"{x:g} rad/s" for x in marked]


def test_marks_of_a_band_in_hertz_are_short_numbers_in_hertz() -> None:
    ax = axes()
    draw_nyquist(ax, identity(7, 1, hertz=True))
    assert np.divide(frequencies(ax), 2 * np.pi) == pytest.approx([3, 5, 7])
    assert told(ax)[3:] == ["3 Hz", "5 Hz", "7 Hz"]


def test_a_band_too_narrow_for_three_short_numbers_bears_no_mark_twice_and_none_below_it() -> None:
    ax = axes()
    draw_nyquist(ax, identity(20, 19.9))
    marked = frequencies(ax)
    assert marked == sorted(set(marked))
    assert min(marked) >= 19.9
    assert max(marked) <= 20 + 1e-9
    assert len(told(ax)) == len(set(told(ax)))


def test_where_a_curve_leaves_the_axes_marks_are_thirds_of_what_is_seen_of_both() -> None:
    """H_env = 100 - ω² + 5 jω, and H_perc is 100 + 500 jω/(100 - ω²), through infinity at 10 rad/s."""
    ax, e = axes(), hs.evaluate(hs.Scene(mass_spring_damper(1, 5, 100), (second_order_lowpass(10, 0),)))
    draw_nyquist(ax, e)
    omega = np.linspace(0, 15, 30_001)[:-1]
    omega = omega[omega != 10]
    env = 100 - omega**2 + 5j * omega
    perc = 100 + 500j * omega / (100 - omega**2)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    seen = np.all([(left <= x.real) & (x.real <= right) & (bottom <= x.imag) & (x.imag <= top) for x in (env, perc)], 0)
    assert 0.3 < seen.mean() < 0.95
    inside = omega[seen]
    expected = [round(float(np.quantile(inside, share))) for share in (1 / 3, 2 / 3, 1)]
    marks = [float(x.split()[0]) for x in told(ax)[3:]]
    assert marks == expected
    for spot, at in zip(spots(ax)[1::2], marks, strict=True):
        assert place(spot) == pytest.approx(100 + 500j * at / (100 - at**2))
        assert bottom <= place(spot).imag <= top
    for x in heads(ax):  # no arrow where nothing is seen
        assert left <= x.xy[0] <= right
        assert bottom <= x.xy[1] <= top


def test_each_frequency_has_a_shape_of_its_own_filled_on_the_environment_alone() -> None:
    ax = axes()
    draw_nyquist(ax, identity(), (3, 8, 19))
    shapes = [x.get_marker() for x in spots(ax)]
    assert shapes == ["o", "o", "s", "s", "D", "D"]
    colours = [(to_hex(x.get_color()), to_hex(x.get_markerfacecolor())) for x in spots(ax)]
    assert colours == [(pen.BLUE, pen.BLUE), (pen.RED, "#ffffff")] * 3
    entries = dict(zip(told(ax), ax.get_legend().legend_handles, strict=True))
    assert list(entries) == [ENV, PERC, RISING, "3 rad/s", "8 rad/s", "19 rad/s"]
    assert [entries[f"{x} rad/s"].get_marker() for x in (3, 8, 19)] == ["o", "s", "D"]
    assert {entries[f"{x} rad/s"].get_markerfacecolor() for x in (3, 8, 19)} == {"none"}
    arrow = entries[RISING]
    assert (arrow.get_marker(), arrow.get_linestyle(), to_hex(arrow.get_color())) == (">", "None", pen.INK)
    assert all(x.get_zorder() > y.get_zorder() for x in spots(ax) for y in ax.lines if len(y.get_xdata()) > 100)


def test_more_frequencies_than_shapes_are_all_marked() -> None:
    ax = axes()
    draw_nyquist(ax, identity(), range(1, 13))
    assert frequencies(ax) == pytest.approx(range(1, 13))
    assert len({x.get_marker() for x in spots(ax)}) == 10


# A further scene


@cache
def lagged() -> hs.Evaluation:
    """H_perc is (100 + 3 jω)/(1 + jω/20)."""
    return hs.evaluate(hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag(20),), (0, 40)))


def test_a_further_scene_has_its_colour_its_entries_no_marks_and_leaves_the_first_in_sight() -> None:
    ax = axes()
    first = draw_nyquist(ax, identity())
    limits, count, origin = (*ax.get_xlim(), *ax.get_ylim()), len(spots(ax)), len(ax.lines)
    second = draw_nyquist(ax, lagged())
    assert [to_hex(x.get_color()) for x in (*first, *second)] == [pen.BLUE, pen.RED, pen.SCENES[1], pen.SCENES[1]]
    assert [x.get_linestyle() for x in second] == ["-", "--"]
    assert {x.get_linewidth() for x in (*first, *second)} == {1.1}
    assert [x.get_label() for x in (*first, *second)] == [ENV, PERC, f"{ENV} (2)", f"{PERC} (2)"]
    assert (len(spots(ax)), len(ax.lines)) == (count, origin + 2)
    left, right, bottom, top = (*ax.get_xlim(), *ax.get_ylim())
    assert left < limits[0]
    assert right == pytest.approx(max(limits[1], 100 + 0.06 * 40), rel=0.1)
    assert bottom <= limits[2]
    assert top >= 120
    assert told(ax)[-2:] == [f"{ENV} (2)", f"{PERC} (2)"]


def test_the_axes_through_zero_are_drawn_once() -> None:
    ax = axes()
    draw_nyquist(ax, identity())
    draw_nyquist(ax, lagged())
    ends = [(list(x.get_xdata()), list(x.get_ydata())) for x in ax.lines if len(x.get_xdata()) == 2]
    assert ends == [([0, 1], [0, 0]), ([0, 0], [0, 1])]


def test_a_frequency_marked_for_two_scenes_has_one_shape_and_one_entry_and_another_a_new_one() -> None:
    ax = axes()
    draw_nyquist(ax, identity(), (5, 12), label="ideal")
    draw_nyquist(ax, lagged(), (12, 30), label="slow")
    shape = {x: x.get_marker() for x in spots(ax)}
    env = [(round(place(x).imag / 3, 9), shape[x]) for x in spots(ax)[::2]]
    assert env == [(5, "o"), (12, "s"), (12, "s"), (30, env[3][1])]
    assert env[3][1] not in ("o", "s")
    assert told(ax).count("12 rad/s") == 1
    assert told(ax)[:2] == [f"{ENV}, ideal", f"{PERC}, ideal"]
    perc = spots(ax)[-1]
    assert place(perc) == pytest.approx((100 + 90j) / (1 + 1.5j))
    assert to_hex(perc.get_color()) == pen.SCENES[1]


def test_a_colour_that_is_given_is_that_of_both_curves_their_marks_and_their_arrows() -> None:
    ax = axes()
    draw_nyquist(ax, identity(), color="#009900", label="mine")
    drawn = [x for x in ax.lines if len(x.get_xdata()) > 2 or x in spots(ax)]
    assert {to_hex(x.get_color()) for x in drawn} == {"#009900"}
    assert {to_hex(x.arrow_patch.get_facecolor()) for x in heads(ax)} == {"#009900"}


# Arrows


def test_arrows_stand_in_the_two_longest_pieces_between_marks_and_not_at_one_place_on_two_curves() -> None:
    """Of 0 to 20 the marks 4 and 12 leave 4, 8 and 8; at 42 % of a piece on H_env, at 58 % on H_perc."""
    ax = axes()
    draw_nyquist(ax, identity(), (4, 12))
    at = [x.xy[1] / 3 for x in heads(ax)]
    step = 20 / 800
    expected = [4 + 0.42 * 8, 12 + 0.42 * 8, 4 + 0.58 * 8, 12 + 0.58 * 8]
    assert sorted(at[:2]) == pytest.approx(sorted(expected[:2]), abs=step)
    assert sorted(at[2:]) == pytest.approx(sorted(expected[2:]), abs=step)
    for x in heads(ax):
        assert x.xy[0] == x.xyann[0] == pytest.approx(100)
        assert 0 < x.xy[1] - x.xyann[1] < 0.03 * 60  # its tail is just before it on the curve


def test_pieces_shorter_than_a_tenth_of_the_axes_bear_no_arrow_and_the_legend_tells_of_none() -> None:
    """20 pieces of 1 rad/s are a twentieth of the line each; of 10 pieces with one of 3 only that one is long enough."""
    ax = axes()
    draw_nyquist(ax, identity(), range(1, 20))
    assert heads(ax) == []
    assert RISING not in told(ax)
    ax = axes()
    draw_nyquist(ax, identity(), (*range(1, 10), *range(12, 20)))
    assert [9 < x.xy[1] / 3 < 12 for x in heads(ax)] == [True, True]
    assert told(ax)[2] == RISING


def test_the_head_of_an_arrow_is_a_filled_wedge_whose_tip_is_on_the_curve() -> None:
    ax = axes()
    draw_nyquist(ax, identity(), (10,))
    ax.figure.draw_without_rendering()
    for x, color in zip(heads(ax), [pen.BLUE, pen.BLUE, pen.RED, pen.RED], strict=True):
        assert to_hex(x.arrow_patch.get_facecolor()) == color
        assert x.get_text() == ""
        paths, filled = x.arrow_patch._get_path_in_displaycoord()
        [head] = [path for path, is_filled in zip(paths, filled, strict=True) if is_filled]
        points = head.vertices[head.codes != head.CLOSEPOLY]
        tip = ax.transData.transform(x.xy)
        assert np.hypot(*(points - tip).T).min() < 0.5
        assert points[:, 1].max() <= tip[1] + 0.5
        wide, long = np.ptp(points, axis=0) * 72 / ax.figure.dpi
        assert (wide, long) == (pytest.approx(5.4, rel=0.1), pytest.approx(6.5, rel=0.1))


# Limits


def margins(ax: Axes, points: Any) -> tuple[float, ...]:
    """How far points stay from the edges, as shares of their extent: left, right, bottom, top."""
    found: list[float] = []
    for (low, high), x in ((ax.get_xlim(), points.real), (ax.get_ylim(), points.imag)):
        size = np.ptp(x) or 1.0
        found += [(x.min() - low) / size, (high - x.max()) / size]
    return tuple(found)


def test_the_axes_hold_both_curves_with_the_same_margin_on_every_side() -> None:
    """A mass on a spring under a damper: 100 - ω² + 10 jω, and with a shunt 100 - 2 ω² + 10 jω."""
    ax, omega = axes(), np.linspace(0, 10, 1001)
    draw_nyquist(ax, hs.evaluate(hs.Scene(mass_spring_damper(1, 10, 100), (shunt(m=1),), (0, 10))))
    both = np.concatenate([100 - omega**2 + 10j * omega, 100 - 2 * omega**2 + 10j * omega])
    assert margins(ax, both) == pytest.approx([0.06] * 4)
    assert ax.get_aspect() == 1


@pytest.mark.parametrize(
    ("springs", "x", "y"),
    [((100, 20), (98.8, 121.2), (-1.12, 1.12)), ((100, 0), (94.4, 105.6), (-5.6, 5.6))],
    ids=["two spots", "one spot"],
)
def test_a_curve_without_an_extent_still_has_axes_with_some(springs: Any, x: Any, y: Any) -> None:
    """Springs of 100 and 120 N/m: a tenth of the larger extent, or of the only number."""
    k, more = springs
    ax = axes()
    draw_nyquist(ax, hs.evaluate(hs.Scene(mass_spring_damper(k=k), (shunt(k=more),) if more else ())))
    assert (ax.get_xlim(), ax.get_ylim()) == (pytest.approx(x), pytest.approx(y))


def test_an_excursion_is_cut_at_the_extent_of_the_middle_nine_tenths_beyond_them() -> None:
    """H_perc is 100 + 500 jω/(100 - ω²): both ways to infinity upright, nowhere else."""
    ax, omega = axes(), np.linspace(0, 15, 801)
    draw_nyquist(ax, hs.evaluate(hs.Scene(mass_spring_damper(1, 5, 100), (second_order_lowpass(10, 0),))))
    with np.errstate(divide="ignore"):
        im = 500 * omega / (100 - omega**2)
    common = np.concatenate([5 * omega, im[np.isfinite(im)]])
    first, last = np.quantile(common, (0.05, 0.95))
    low, high = first - (last - first), last + (last - first)
    assert ax.get_ylim() == pytest.approx((low - 0.06 * (high - low), high + 0.06 * (high - low)), rel=0.02)
    assert ax.get_xlim() == pytest.approx((-125 - 0.06 * 225, 100 + 0.06 * 225), abs=0.5)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\mathrm{Re}\,H$ (N/m)", r"$\mathrm{Im}\,H$ (N/m)")


@pytest.mark.parametrize(("peak", "top"), [(4.5, 4.5), (4.6, 0.95 + 0.9), (-3.5, 1), (-3.6, 1)])
def test_an_excursion_is_far_beyond_four_extents_of_the_middle_nine_tenths(peak: float, top: float) -> None:
    """Of upright lines from 0 to 1 these go from 0.05 to 0.95: up to 4.55, and down to -3.55."""
    upright = np.linspace(0, 1, 1001)
    line = np.stack([0 * upright, upright] * 2, axis=1)
    low, high = _window(np.concatenate([line, [[0, peak, 0, 1]]]), line)
    bottom = {-3.5: -3.5, -3.6: 0.05 - 0.9}.get(peak, 0)
    size = top - bottom
    assert (low[1], high[1]) == (pytest.approx(bottom - 0.06 * size), pytest.approx(top + 0.06 * size))


def test_points_that_are_not_finite_do_not_count_and_nothing_at_all_has_axes_too() -> None:
    upright = np.linspace(0, 1, 1001)
    line = np.stack([0 * upright, upright] * 2, axis=1)
    gaps = np.array([[np.nan, 3, 0, np.inf], [np.inf, -3, np.nan, 2]])
    for found, alone in zip(_window(np.concatenate([gaps, line]), line), _window(line, line), strict=True):
        assert found == pytest.approx(alone)
    low, high = _window(0 * line, 0 * line)
    assert (low < 0).all()
    assert (high > 0).all()
