"""Charts of requirements, maps, sweeps, tolerances, hands, motions and judgements, held against closed forms and the answers' own numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from drawn import axes, curves, filled, hatched, marked, places, points, spans, told, words
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle
from sympy import Rational

import haptisym as hs
from haptisym.effects import delay, first_order_lag, shunt
from haptisym.environments import mass_spring_damper
from haptisym.figures import effects as effect_charts
from haptisym.figures import jnd as jnd_charts
from haptisym.figures import measured as measured_charts
from haptisym.figures import pen
from haptisym.figures import requirement as requirement_charts
from haptisym.figures import simulate as simulation_charts
from haptisym.figures import stability as stability_charts
from haptisym.figures import sweep as sweep_charts
from haptisym.figures.cost import cost_figure, draw_cost, hard_costs_figure
from haptisym.figures.layers import draw
from haptisym.figures.sweep import is_logarithmic
from haptisym.kernel.errors import NothingToDrawError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.sets import SingleValue, Stretch
from haptisym.verbs.cost.entry import Cost, CostMeasurement
from haptisym.verbs.cost.hardcosts import HardCosts, HardRow
from haptisym.verbs.jnd.tables import Answers, LevelAnswers
from haptisym.verbs.sweep.axes import UNKNOWN

DAMPED = hs.Scene(mass_spring_damper(k=100), (shunt(b=2),), (0, 15), "0.1")
"""r_r is 0 and r_i is b ω/k: transparent for 15 b <= k/10."""
HEAVY = hs.Hand("heavy", m="600 kg", b="5 kN*s/m", k="20 kN/m")

# Requirements.


def test_a_requirement_is_drawn_with_its_worst_case_its_set_and_its_proven_ends() -> None:
    ax = axes()
    real, imag = draw(ax, requirement_charts.requirement(hs.require(DAMPED, "effects.shunt.b")))
    b, worst = places(imag)
    assert worst == pytest.approx(np.abs(b) * 15 / 100 / 0.1)
    assert places(real)[1] == pytest.approx(0)
    assert spans(ax.patches) == [pytest.approx((-2 / 3, 2 / 3))]
    assert [points(x) for x in marked(ax, "o")] == [[pytest.approx((-2 / 3, 1)), pytest.approx((2 / 3, 1))]]
    assert told(ax) == ["real part", "imaginary part", "threshold", "transparent", "ends, proven"]


@pytest.mark.slow
def test_the_worst_case_of_a_requirement_is_that_of_both_ratios_at_each_value() -> None:
    """Behind a delay of tau they are 1 - cos(tau w) and sin(tau w)."""
    late, ax = hs.Scene(mass_spring_damper(k=100), (delay("20 ms"),), (0, 15), "0.1"), axes()
    real, imag = draw(ax, requirement_charts.requirement(hs.require(late, "tau", (0, "0.1"))))
    ms, worst = places(imag)
    tau = ms / 1000
    omega = np.linspace(0, 15, 4001)[:, None]
    assert worst == pytest.approx(np.abs(np.sin(omega * tau)).max(axis=0) / 0.1, rel=1e-3)
    assert places(real)[1] == pytest.approx((1 - np.cos(omega * tau)).max(axis=0) / 0.1, rel=1e-3)
    assert len(curves(ax)) == 2
    assert "(ms)" in ax.get_xlabel()


def test_what_is_undecided_of_a_requirement_is_hatched_and_open_intervals_end_with_the_axis() -> None:
    found = hs.require(DAMPED, "effects.shunt.b")
    one, two = (ExactNumber(Rational(n)) for n in (1, 2))
    known = Stretch(holds=True)
    low_part = hs.ValueSet((SingleValue(two, holds=True),), (Stretch(None), known))
    two_parts = hs.ValueSet((SingleValue(one), SingleValue(two, holds=False)), (known, Stretch(None), Stretch(None)))
    for own, undecided in ((low_part, [(None, 2)]), (two_parts, [(1, 2), (2, None)])):
        ax = axes()
        draw(ax, requirement_charts.requirement(replace(found, values=own)))
        low, high = ax.get_xlim()
        ends = [(low if a is None else a, high if b is None else b) for a, b in undecided]
        assert spans(x for x in ax.patches if x.get_hatch()) == [pytest.approx(x) for x in ends]
        assert told(ax).count("undecided") == 1


@pytest.mark.slow
def test_a_number_of_a_hand_is_drawn_though_it_has_no_course_along_the_band() -> None:
    ax = axes()
    draw(ax, requirement_charts.requirement(hs.require("satellite-contact", "hand.m", that=["stable"], hand=HEAVY)))
    assert not curves(ax)
    assert [places(x)[0].tolist() for x in marked(ax, "o")] == [[500]]


# Maps.


@cache
def designed(low: float = 1, high: float = 3) -> hs.DesignMap:
    return hs.design_map(DAMPED, ["effects.shunt.b", "environment.k"], [(low, high), (100, 500)], slices=3)


@pytest.mark.slow
def test_a_map_has_strokes_marks_and_grounds_where_the_set_and_its_boundary_are() -> None:
    """k = 150 b: what is grey lies above it, what is left open holds it."""
    ax = axes()
    strokes, *marks = draw(ax, requirement_charts.slices(designed()))
    ways = [[tuple(map(float, p)) for p in x] for x in strokes.get_segments()]  # type: ignore[attr-defined]
    assert ways == [[(b, 150 * b), (b, 500)] for b in (1, 2, 3)]
    assert [points(x) for x in marks] == [[(b, 150 * b) for b in (1, 2, 3)]]
    assert "imaginary part, at the band's edge" in told(ax)
    kept, open_ = (np.array(filled(ax, x)) for x in (pen.SHADE, "#f2c14e"))
    assert (kept[:, 1] >= 150 * kept[:, 2] - 1e-9).all()
    assert ((open_[:, 1] <= 150 * open_[:, 2]) & (open_[:, 3] >= 150 * open_[:, 0])).all()
    for b in np.linspace(1, 3, 40)[1:-1] + 1e-4:
        for k in (150 * b + 40, 500 - 1e-3):
            within = [x for x in (*kept, *open_) if x[0] <= b <= x[2] and x[1] <= k <= x[3]]
            assert k >= 500 or within
    assert {"transparent on the slice", "transparent, proven", "undecided, holds the boundary", "exact slices"} <= set(
        told(ax)
    )
    assert (*ax.get_xlim(), *ax.get_ylim()) == (1, 3, 100, 500)


@pytest.mark.slow
def test_a_map_that_is_cut_to_its_set_has_nothing_beside_its_axes_and_its_legend_whole() -> None:
    """Ticks of slices far beyond the cut left no room for the axes."""
    found = hs.design_map("fu2019", ["zeta", "omega_n"], [("0.05", 2), (60, 200)], slices=9)
    figure = requirement_charts.DESIGN_MAP.figure(found)
    figure.canvas.draw()
    [ax], page = figure.axes, figure.bbox
    assert ax.get_xlim()[1] < 1.5
    assert ax.get_window_extent().width > 0.7 * page.width
    for x in (*ax.lines, ax.get_legend()):
        box = x.get_window_extent()
        assert -1 <= box.x0 <= box.x1 <= page.x1 + 1


def test_what_one_part_allows_is_never_called_transparent_alone() -> None:
    """It was, though the imaginary part is noticed."""
    slow = hs.Scene(mass_spring_damper(k=100), (first_order_lag(40),), (0, 15), "0.1")
    found = hs.require(slow, "omega_c", (20, 1000), part=hs.Part.REAL)
    plane = hs.design_map(slow, ["omega_c", "environment.k"], [(20, 1000), (50, 500)], slices=3, part=hs.Part.REAL)
    low = next(x for x in found.feasible).low
    assert hs.evaluate(slow.with_values({"omega_c": low.digits(20)})).bandwidth != 15
    page = [str(found), str(plane), hs.latex(found), hs.latex(plane)]
    for panel in (
        requirement_charts.requirement(found),
        requirement_charts.slices(plane),
        requirement_charts.wishes(plane),
    ):
        ax = axes()
        draw(ax, panel)
        page += [*told(ax), *words(ax)]
    said = [x for text in page for x in " ".join(text.split()).lower().split("transparent")[1:]]
    assert len(said) > 8
    assert all(x.startswith(" in the real part") for x in said)
    assert found.to_dict()["condition"] == plane.to_dict()["condition"] == ["real"]
    diamond = {"shape": "diamond", "real": 1, "imag": 1}
    joint = hs.Scene(mass_spring_damper(k=100), (first_order_lag(40),), (0, 15), diamond)
    with pytest.raises(hs.SceneError, match="judges both parts at once"):
        hs.require(joint, "omega_c", part=hs.Part.REAL)


def test_a_map_without_any_value_says_so() -> None:
    ax = axes()
    draw(ax, requirement_charts.slices(designed(10, 30)))
    assert "transparent nowhere: on none of 3 exact slices" in words(ax)
    assert told(ax) == ["exact slices"]


@pytest.mark.slow
def test_a_map_of_several_things_shows_each_set() -> None:
    ax = axes()
    found = hs.design_map(
        DAMPED, ["effects.shunt.b", "environment.k"], [(1, 3), (100, 500)], slices=3, that=["transparent", "passive"]
    )
    draw(ax, requirement_charts.wishes(found))
    assert [points(x) for x in ax.lines] == [
        [(1, 150), (2, 300)], [(2, 300), (3, 450)], [(1, 150), (2, 300), (3, 450)],
    ]  # fmt: skip
    assert {"all that is asked, interpolated", "transparent", "passive: ends on no slice"} <= set(told(ax))


@pytest.mark.slow
def test_between_slices_of_different_kind_a_map_is_hatched_and_shows_no_boundary() -> None:
    """It drew one halfway, at 550 kg, where it is at 500 kg."""
    ranges, free = [(400, 800), (0, 6000)], ["hand.m", "hand.b"]
    ax = axes()
    draw(
        ax,
        requirement_charts.wishes(
            hs.design_map("satellite-contact", free, ranges, that=["stable"], hand=HEAVY, slices=5)
        ),
    )
    assert not [x for x in ax.lines if len(x.get_xdata())]
    assert {"undecided", "stable: ends on no slice"} <= set(told(ax))
    [(left, _, right, _)] = hatched(ax)
    assert (left, right) == (500, 600)


# Sweeps.

NATURAL, MASS = "effects.filter.omega_n", "environment.m"


def swept(x: Any, **unstable: Any) -> xr.Dataset:
    """Crossings of the real part come and go in pairs before the 4th value; elsewhere everything moves evenly."""
    n = len(x)
    real, imag = np.linspace(2, 4, n), np.linspace(12, 11, n)
    real[4:] += 5
    rows: dict[str, Any] = {
        "bandwidth": np.minimum(real, imag), "first_crossing_real": real, "first_crossing_imag": imag,
        "crossings_real": np.where(np.arange(n) < 4, 1, 3), "crossings_imag": np.ones(n, int),
    }  # fmt: skip
    made = xr.Dataset({k: ((NATURAL,), v) for k, v in rows.items()}, {NATURAL: x}, {"band": [0.0, 20.0]})
    made[NATURAL].attrs["units"] = "rad/s"
    for name, values in unstable.items():
        made[f"unstable_{name}"] = ((NATURAL,), values, {"hand": name})
    return made


@pytest.mark.slow
def test_curves_of_a_sweep_go_through_its_table_and_break_where_crossings_come_or_go() -> None:
    x = np.linspace(10, 100, 10)
    some, open_ = np.zeros(10, int), np.zeros(10, int)
    some[:3], open_[7] = 2, UNKNOWN
    data, ax = swept(x, one=some, other=open_), axes()
    names = ["first_crossing_real", "first_crossing_imag", "bandwidth"]
    for line, name, gaps in zip(draw(ax, sweep_charts.curves(data)), names, ([4], [], [4]), strict=True):
        own = points(line)
        assert [i for i, p in enumerate(own) if np.isnan(p[0])] == gaps
        assert [p for p in own if not np.isnan(p[0])] == list(zip(x, data[name].values, strict=True))
    assert [points(y) for y in marked(ax, "o")] == [
        [(x[i], float(data[n].values[i])) for i in (3, 4)] for n in names[::2]
    ]
    assert (ax.get_xlim(), ax.get_xlabel(), ax.get_ylabel()) == ((10, 100), r"$\omega_n$ (rad/s)", r"$\omega$ (rad/s)")
    assert {"end of the band", "crossings come or go", "unstable in one", "stability undecided in other"} <= set(
        told(ax)
    )
    assert [(a, b) for a, _, b, _ in hatched(ax)] == [(10, 35), (75, 85)]  # halfway to the neighbours


def test_values_by_equal_ratios_have_a_logarithmic_axis_and_no_others() -> None:
    ratios = np.geomspace(0.5, 200, 7)
    assert all(is_logarithmic(x) for x in (ratios, ratios[::-1], np.array([1.0, 2, 4])))
    others = (np.linspace(1, 9, 7), ratios[:2], -ratios, np.concatenate([[0.0], ratios]), np.array([1.0, 2, 5]))
    assert not any(is_logarithmic(y) for y in others)


@pytest.mark.slow
def test_a_map_of_a_sweep_shows_its_table_its_jumps_and_what_contours_do_not_tell() -> None:
    x, y = np.linspace(10, 100, 10), np.array([1.0, 2.0, 3.0])
    z = np.linspace(2, 6, 10)[None, :] + 0.5 * y[:, None]
    z[:, 5:] += 6
    z[0, 0], z[2, 9] = np.nan, 20.0
    counts = np.where(np.arange(10) < 5, 1, 3)[None, :] * np.ones((3, 1), int)
    counts[2, 9] = 2
    rows = {"bandwidth": z, "crossings_real": counts}
    data = xr.Dataset({k: ((MASS, NATURAL), v) for k, v in rows.items()}, {MASS: y, NATURAL: x}, {"band": [0.0, 20.0]})
    data["unstable_mine"] = ((MASS, NATURAL), np.where(z > 13, 2, 0), {"hand": "mine"})
    data[NATURAL].attrs["units"], data[MASS].attrs["units"] = "rad/s", "kg"
    ax = axes()
    mesh, lines = draw(
        ax, sweep_charts.plane(data.isel({NATURAL: slice(None, None, -1)}))
    )  # whatever the order of the table is
    assert isinstance(mesh, QuadMesh)
    shown = np.ma.filled(mesh.get_array().astype(float), np.nan).reshape(z.shape)
    assert np.array_equal(shown, z, equal_nan=True)
    inside = z[np.isfinite(z) & (z < 20)]
    assert inside.min() < lines.levels.min() < lines.levels.max() < inside.max()  # type: ignore[attr-defined]
    [jumps] = [c for c in ax.collections if isinstance(c, LineCollection)]
    edges = [[tuple(map(float, p)) for p in s] for s in jumps.get_segments()]
    upright = [e for e in edges if e[0][0] == e[1][0] == 55]
    assert upright == [[(55, a), (55, b)] for a, b in ((1, 1.5), (1.5, 2.5), (2.5, 3))]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega_n$ (rad/s)", "$m$ (kg)")
    assert told(ax) == [
        "bandwidth (rad/s)", "bandwidth jumps", "not at the low end", "whole band, 20 rad/s", "unstable in mine",
    ]  # fmt: skip


# Tolerances.

REAL, IMAG = 1 / 3, 5 - np.sqrt(24)
"""Behind 1/(1 + jω/a) r_r is ω²/(a² + ω²) and r_i is aω/(a² + ω²): they meet 1/10 at a/3 and at a (5 - √24)."""


@cache
def found(
    cutoff: str = "40 rad/s +- 10 %", band: Any = (0, 20), *, disc: bool = False, samples: int = 4
) -> hs.Tolerances:
    jnd: Any = {"shape": "ellipse", "real": "0.1", "imag": "0.1"} if disc else "0.1"
    scene = hs.Scene(mass_spring_damper(k=100), (first_order_lag(cutoff),), band, jnd)
    return hs.tolerances(scene, samples=samples)


def rows_of(bars: Any) -> list[tuple[float, float, float]]:
    return [(*own, x.get_y() + x.get_height() / 2) for own, x in zip(spans(bars), bars, strict=True)]


@pytest.mark.dear("False")
@pytest.mark.parametrize("hertz", [False, True])
def test_bars_hold_the_crossings_of_all_values_dots_those_drawn_and_strokes_the_nominal_ones(*, hertz: bool) -> None:
    ax, turn = axes(), 2 * np.pi if hertz else 1
    own_found = found(band=("0 Hz", f"{20 / turn:.17g} Hz")) if hertz else found()
    bars = draw(ax, stability_charts.enclosures(own_found))
    cutoffs = np.array([float(next(iter(x.values.values()))) for x in own_found.samples])
    strokes = [x for x in ax.collections if isinstance(x, LineCollection)]
    for row, (own, at) in enumerate(zip(rows_of(bars), (REAL, IMAG), strict=True)):
        assert own == pytest.approx((36 * at / turn, 44 * at / turn, row), rel=1e-6, abs=1e-9)
        x, y = places(marked(ax, ".")[row])
        assert x == pytest.approx(cutoffs * at / turn, rel=1e-9)
        assert (np.abs(y - row) < 0.35).all()
        assert np.array(strokes[row].get_segments())[0, :, 0] == pytest.approx([40 * at / turn] * 2)
    assert [x.get_text() for x in ax.get_yticklabels()] == [
        r"$r_\mathrm{r} = c_\mathrm{r}$",
        r"$r_\mathrm{i} = c_\mathrm{i}$",
    ]
    assert told(ax) == ["for all values", "drawn at random", "nominal values"]
    assert ax.get_xlabel() == ("frequency (Hz)" if hertz else r"$\omega$ (rad/s)")


@pytest.mark.slow
def test_what_is_met_for_some_values_alone_has_a_bar_to_the_end_of_the_band_and_no_stroke() -> None:
    ax = axes()
    [own] = rows_of(draw(ax, stability_charts.enclosures(found("92 rad/s +- 10 %", (0, 9), samples=0))))
    assert own == pytest.approx((82.8 * IMAG, 9, 1), rel=1e-6)
    assert told(ax) == ["for all values"]
    for made in (stability_charts.enclosures, stability_charts.tolerances):
        with pytest.raises(NothingToDrawError, match="nothing is met on the band"):
            made(found("400 rad/s +- 10 %", samples=2))


@pytest.mark.slow
def test_what_a_further_scene_meets_stands_in_the_row_of_that_or_in_one_of_its_own() -> None:
    """``|jω/(a + jω)|`` is a tenth at a/√99."""
    ax = axes()
    draw(ax, stability_charts.enclosures(found()))
    [own] = rows_of(draw(ax, stability_charts.enclosures(found(disc=True, samples=1))))
    assert own == pytest.approx((36 / 99**0.5, 44 / 99**0.5, 2), rel=1e-6)
    assert [x.get_text() for x in ax.get_yticklabels()][2:] == ["ellipse"]
    assert [row for *_, row in rows_of(draw(ax, stability_charts.enclosures(found())))] == pytest.approx([0, 1])


# Hands.

MINE = hs.Hand("mine", m="0.5 kg", b=["7 N*s/m", "9 N*s/m"], k="60 N/m")


@pytest.mark.slow
def test_grounds_of_a_held_display_are_what_is_counted_at_single_values_of_hand_and_display() -> None:
    """A spring of 100 N/m with a damper of -6 to -4 N s/m: stable above the one, unstable below the other, for k > -100."""
    ax = axes()
    scene = hs.Scene(mass_spring_damper(k=100), (shunt(b=["-6", "-4"]),), (0, 15), "0.1")
    draw(ax, stability_charts.held(hs.tolerances(scene, samples=0, hand=MINE)))
    white, tinted, open_ = (np.array(filled(ax, x)) for x in ("#ffffff", pen.UNSTABLE, pen.OPEN))
    assert (white[:, 1] >= 6 - 1e-9).all()
    assert (tinted[:, 3] <= 4 + 1e-9).all()
    assert (
        (open_[:, 3] > 4 - 0.25) & (open_[:, 1] < 6 + 0.25) | (open_[:, 0] < 0)
    ).all()  # there it depends; k_h < 0 is at the edge
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    for b, area in ((8, white), (2, tinted)):
        assert any(x0 <= 100 <= x1 and y0 <= b <= y1 for x0, y0, x1, y1 in area)
    assert left < 0 < 400 < right
    assert bottom < 0 < 9 < top
    assert told(ax)[:3] == ["stable for all values", "for none", "it depends, or undecided"]
    assert "mass 0.5 kg" in ax.get_xlabel()


def test_without_a_hand_there_is_no_plane() -> None:
    with pytest.raises(hs.HaptisymError, match="no hand was asked about"):
        found().plot(axes(), kind="hands")


@pytest.mark.slow
def test_the_plane_of_a_hand_has_its_boundary_where_roots_lie_on_the_axis() -> None:
    """With -5 N s/m and 100 - 150 N/m at its side a mass is stable for b > 5 and k > 50; to the left a root is at 0."""
    ax, other = axes(), hs.Hand("other", m="2 kg", b="8 N*s/m", k=["70 N/m", "90 N/m"])
    scene = hs.Scene(mass_spring_damper(k=100), (shunt(b=-5, k=-150),), (0, 15), "0.1")
    draw(
        ax,
        stability_charts.hand_plane(hs.stability(scene, [hs.Hand("mine", m="0.5 kg", b="8 N*s/m", k="60 N/m"), other])),
    )
    [boundary] = [x for x in ax.lines if to_hex(x.get_color()) == pen.BLUE]
    assert places(boundary)[1] == pytest.approx(5)
    assert places(boundary)[0].min() == pytest.approx(50, abs=1e-3)
    [at_0] = [x for x in ax.lines if to_hex(x.get_color()) == pen.RED]
    assert places(at_0)[0].tolist() == [50, 50]
    marks = {
        points(x)[0]: to_hex(x.get_markerfacecolor()) if x.get_markerfacecolor() != "none" else ""
        for x in marked(ax, "o")
    }
    assert (marks[60, 8], marks[80, 8]) == (pen.INK, "")  # of this mass, of another
    assert [(x.get_xy(), x.get_width(), x.get_height()) for x in ax.patches if isinstance(x, Rectangle)] == [
        ((70, 8), 20, 0)
    ]
    regions = {"0": (True, True), "2": (True, False), "1": (False, None)}
    for text in ax.texts:
        if text.get_text() in regions:
            right, above = regions[text.get_text()]
            k, b = text.xy  # type: ignore[attr-defined]
            assert (k > 50, above is None or b > 5) == (right, above is None or above)
    assert {"0", "1", "2", "mine", "other"} <= {x.get_text() for x in ax.texts}
    assert ax.get_xlabel() == r"hand's stiffness $k_\mathrm{h}$, mass 0.5 kg (N/m)"
    assert ax.get_ylabel() == r"hand's damping $b_\mathrm{h}$ (N·s/m)"


@pytest.mark.slow
def test_behind_a_delay_the_boundary_is_that_of_the_loop() -> None:
    """Held by a hand of 0.5 kg a spring of 100 N/m 36 ms late: m w^2 - k_h = 100 cos(0.036 w), b_h w = 100 sin(0.036 w)."""
    ax = axes()
    draw(
        ax,
        stability_charts.hand_plane(
            hs.stability("delayed-spring", [hs.Hand("mine", m="0.5 kg", b="4 N*s/m", k="60 N/m")])
        ),
    )
    [boundary] = [x for x in ax.lines if to_hex(x.get_color()) == pen.BLUE]
    (k, b), (low, high), (least, most) = places(boundary), ax.get_xlim(), ax.get_ylim()
    inside = (k > low) & (k < high) & (b > least) & (b < most)
    assert inside.sum() > 20
    w = np.linspace(1e-3, 90, 100_001)
    known = np.stack([0.5 * w**2 - 100 * np.cos(0.036 * w), 100 * np.sin(0.036 * w) / w], axis=1)
    scale = np.array([high - low, most - least])
    for place in np.stack([k, b], axis=1)[inside][::10]:
        assert np.hypot(*((known - place) / scale).T).min() < 2e-3


# Motions.


def env(omega: Any) -> Any:
    return 100 + 3j * np.asarray(omega)


def perc(omega: Any) -> Any:
    return env(omega) / (1 + 1j * np.asarray(omega) / 20)


@cache
def run() -> hs.Simulation:
    lagged = hs.Scene(mass_spring_damper(k=100, b=3), (first_order_lag(20),), (0, 15), "0.1")
    return hs.simulate(lagged, hs.sine("5 cm", "10 rad/s"))


@pytest.mark.slow
def test_a_loop_is_the_ellipse_of_either_dynamics_and_time_is_in_seconds() -> None:
    """x = 0.05 sin(10 t), in mm; f = Im(H 0.05 exp(10 j t)), so (f - Re H x)/Im H is the motion a quarter of a turn on."""
    ax = axes()
    for line, H in zip(draw(ax, simulation_charts.loop(run())), (env(10), perc(10)), strict=True):
        x, force = places(line)
        assert np.abs(x).max() == pytest.approx(50, rel=1e-3)
        assert np.hypot(x / 1e3, (force - H.real * x / 1e3) / H.imag) == pytest.approx(0.05, rel=2e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("displacement (mm)", "force (N)")
    assert told(ax) == ["environment alone", "at the hand"]
    time = axes()
    t, f = places(draw(time, simulation_charts.in_time(run()))[0])
    assert f == pytest.approx((0.05 * perc(10) * np.exp(10j * t)).imag, abs=2e-3 * np.abs(f).max())
    assert (time.get_xlabel(), time.get_ylabel()) == ("time (s)", "force (N)")
    assert [x.get_ylabel() for x in time.child_axes] == ["motion (mm)"]


@pytest.mark.dear("Part.IMAG-imag")
@pytest.mark.parametrize(("part", "of"), [(hs.Part.REAL, np.real), (hs.Part.IMAG, np.imag)])
def test_what_is_recovered_are_rings_on_the_closed_form(part: hs.Part, of: Any) -> None:
    ax = axes()
    curve, rings = draw(ax, simulation_charts.recovered(run(), part))
    omega, values = places(curve)
    assert values == pytest.approx(of(perc(omega)))
    assert points(rings) == [(10.0, pytest.approx(of(perc(10)), rel=1e-3))]
    assert "(N/m)" in ax.get_ylabel()


@pytest.mark.slow
def test_a_hand_that_is_let_go_moves_within_its_envelope_in_millimetres() -> None:
    """1 kg on 100 N/m with 2 N s/m: e^-t, at √99 rad/s."""
    ax = axes()
    released = hs.release(hs.Scene(mass_spring_damper(k=100)), "1 cm", hs.Hand("own", m="1 kg", b="2 N*s/m"))
    motion, envelope, *_ = draw(ax, simulation_charts.release(released))
    t, x = places(motion)
    assert x == pytest.approx(1e3 * np.interp(t, released.time, released.hand_motion), abs=0.05)
    assert x[0] == pytest.approx(10)
    at, reach = places(envelope)
    assert np.log(reach / reach[0]) == pytest.approx(-(at - at[0]))
    late = t > t[-1] / 3
    assert (np.abs(x[late]) <= np.interp(t[late], at, reach) * (1 + 1e-9)).all()
    ups = t[1:][(x[:-1] < 0) & (x[1:] >= 0)]
    assert np.diff(ups)[1:] == pytest.approx(2 * np.pi / np.sqrt(99), rel=0.02)
    assert (ax.get_ylabel(), ax.get_xlabel()) == ("motion (mm)", "time (s)")


# Identified models, sensitivities.


@pytest.mark.slow
def test_an_identified_model_is_drawn_through_its_lines_with_residuals_in_their_errors() -> None:
    w, error = np.array([1.0, 2, 5, 9, 31]), np.array([3 + 1j, -2j, 5, 1 - 1j, -4.0])
    H = 100 - 2 * w**2 + 15j * w + error
    a = hs.identify(hs.measured(w, H, radius=[20.0] * 5), "mass-spring-damper")
    m, b, k = (float(x.value) for x in a.estimates)
    (line, dots), ax = draw(axes(), measured_charts.magnitude(a)), axes()
    model = lambda x: k - m * x**2 + 1j * b * x  # noqa: E731
    assert places(line)[1] == pytest.approx(np.abs(model(places(line)[0])), rel=1e-9)
    assert places(dots)[1] == pytest.approx(np.abs(H))
    line, dots = draw(ax, measured_charts.phase(a))
    assert np.exp(1j * np.radians(places(line)[1])) == pytest.approx(np.exp(1j * np.angle(model(places(line)[0]))))
    assert np.exp(1j * np.radians(places(dots)[1])) == pytest.approx(H / np.abs(H))
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega$ (rad/s)", "phase (deg)")
    real, imag = draw(ax, measured_charts.residuals(a))
    assert places(real)[1] + 1j * places(imag)[1] == pytest.approx(a.fit.residuals)


@pytest.mark.slow
def test_bars_of_elasticities_are_as_long_as_they_are_and_named_with_their_values() -> None:
    found = hs.sensitivity(hs.Scene(hs.environments.kelvin_voigt(100, 3), (first_order_lag(20),), (0, 15), "0.1"))
    ax, first = axes(), found.crossings[0]
    bars = draw(ax, effect_charts.elasticities(found, 0))
    known = {x.name: float(x.elasticity) for x in first.parameters if x.elasticity is not None and float(x.elasticity)}
    values = sorted(known.values(), key=abs, reverse=True)
    assert [x.get_width() for x in bars] == pytest.approx(values)
    assert [float(x.get_text().replace("−", "-")) for x in ax.texts] == pytest.approx(values, rel=5e-3)
    assert f"{first.omega.digits(4)} rad/s" in ax.get_title(loc="left")
    listed = [*found.crossings, *found.changeovers_environment, *found.changeovers_perceived]
    titles = [x.get_title(loc="left") for x in found.figure().axes]
    assert all(f"{x.omega.digits(4)} rad/s" in title for x, title in zip(listed, titles, strict=True))


# What accuracy costs.

CROSSINGS = tuple(
    CostMeasurement("crossings", method, digits, seconds, proven, missed)
    for method, digits, seconds, proven, missed in (
        ("grid of 10^2", 4.8, 5.5e-4, False, 0), ("grid of 10^5", 10.8, 5e-2, False, 0), ("lost", 9.0, 1e-3, False, 2),
        ("nothing right", 0.5, 2e-3, False, 0), ("certified, 15 digits", 15, 2.4e-2, True, 0),
    )
)  # fmt: skip


def test_marks_stand_at_time_and_digits_and_what_is_wrong_on_the_strip() -> None:
    ax = axes(4, 3)
    draw_cost(ax, CROSSINGS)
    at = [points(x)[0] for x in marked(ax, "o")]
    assert at == [(x.seconds, x.digits if x.digits > 1 and not x.missed else at[2][1]) for x in CROSSINGS]
    assert at[2][1] < 1
    assert [to_hex(x.get_markerfacecolor()) == pen.INK for x in marked(ax, "o")] == [x.proven for x in CROSSINGS]
    assert ax.get_title(loc="left") == "Finding all crossings"
    assert ax.xaxis.get_major_formatter()(2e-6, 0) == "2 µs"


@pytest.mark.slow
def test_a_figure_of_costs_has_a_panel_for_each_question() -> None:
    others = (
        CostMeasurement("evaluate", "fast", 14, 1e-7, proven=False),
        CostMeasurement("effects", "without it", 1, 1e-2, proven=False),
    )
    figure = cost_figure(Cost(hs.Scene(mass_spring_damper(k=100), title="A spring"), (*CROSSINGS, *others), (), {}, {}))
    titles = [x.get_title(loc="left") for x in figure.axes]
    assert [x for x in titles if x] == [
        "Evaluating the ratios at one frequency", "Finding all crossings", "Leaving an effect out",
    ]  # fmt: skip
    assert "lost: misses 2" in [x.get_text() for x in figure.axes[titles.index("Finding all crossings")].texts]


def test_a_table_of_hard_cases_counts_right_answers_and_tells_the_worst() -> None:
    def row(family: str, case: str, digits: float, verdict: str, *, ours: bool = False, missed: int = 0) -> HardRow:
        own = {
            "family": family,
            "case": case,
            "condition": 1.0,
            "ours": ours,
            "verdict": verdict,
            "invented": missed // 2,
        }
        return HardRow("evaluate", "proof" if ours else "grid", digits, 1.0, proven=ours, missed=missed, **own)

    rows = (
        row("identities", "one", 16, "right", ours=True), row("identities", "one", 15.2, "right"),
        row("identities", "two", 6.2, "loses 9 digits"), row("low frequencies", "one", 0, "cannot: no"),
        row("low frequencies", "one", 16, "right", ours=True),
    )  # fmt: skip
    [ax] = hard_costs_figure(HardCosts(rows, {})).axes
    assert [x.get_text() for x in ax.texts if x.get_text()] == [
        "Values of the ratios", "proof", "grid", "identities", "1 of 1", "16 digits", "1 of 2", "loses 9 digits",
        "low frequencies", "1 of 1", "16 digits", "cannot",
    ]  # fmt: skip
    assert {x.get_text() for x in ax.texts if x.get_fontweight() == "bold"} == {"Values of the ratios", "proof"}


# Judgements.


@pytest.mark.slow
def test_a_measured_jnd_is_drawn_with_its_shares_its_curve_and_where_it_is_taken() -> None:
    rows = tuple(LevelAnswers(4.4 + 0.3 * i, k, 40 - 5 * (i % 2)) for i, k in enumerate((3, 9, 14, 20, 25, 30)))
    p, ax = hs.jnd(Answers("answers", rows)), axes()
    curve, *dots = draw(ax, jnd_charts.answers(p))
    assert [points(x)[0] for x in dots] == [(x.level, x.share) for x in rows]
    assert places(curve)[1] == pytest.approx(p.fit.curve(places(curve)[0]))
    at = p.middle.value + p.jnd.value
    share = float(p.fit.curve(np.array([at]))[0])
    ends = [points(x) for x in ax.lines if to_hex(x.get_color()) == pen.RED]
    assert ends[0][1] == pytest.approx((at, share))
    assert ends[1] == [pytest.approx((p.middle.value + x, share)) for x in (p.jnd.low, p.jnd.high)]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("level", "share of “more”")
    assert f"JND at {100 * p.asked.proportion:.4g} %" in told(ax)


def test_published_thresholds_are_bars_from_their_least_to_their_largest() -> None:
    ax, rows = axes(), [x for x in hs.published() if not x.apart]
    bars = draw(ax, jnd_charts.published(hs.published()))
    assert [places(x)[0].tolist() for x in bars] == [
        [pytest.approx(100 * float(y)) for y in (x.low, x.high)] for x in rows
    ]
    assert [x.get_text() for x in ax.get_yticklabels()] == [x.name for x in rows]
    assert ax.get_xlabel() == "just-noticeable difference (%)"
