"""Charts of sweeps, maps and identified models, by laws: tables and slices made by hand, whose every place in the figure is known."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

import haptisym as hs
from haptisym.figures import pen
from haptisym.figures.designmap import draw_map as draw_slices
from haptisym.figures.identify import draw_magnitude, draw_phase, draw_residuals
from haptisym.figures.sweep import draw_curves, draw_map
from haptisym.figures.sweepdata import is_logarithmic
from haptisym.figures.wishes import draw_wishes
from haptisym.judge.criteria import noticed
from haptisym.model.quantities import Dimension
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.plane import Rectangles
from haptisym.verbs.sweep.told import UNKNOWN

NATURAL, MASS = "effects.filter.omega_n", "environment.m"
SPRING = hs.environments.mass_spring_damper(k=100)


def axes() -> Axes:
    return Figure(figsize=(6, 4)).add_subplot()


def told(ax: Axes) -> list[str]:
    return [x.get_text() for x in ax.get_legend().get_texts()]


def points(line: Line2D) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)]


# Sweeps


def curves_of(x: Any, **more: Any) -> xr.Dataset:
    """Crossings of the real part come and go in pairs before the 4th value; elsewhere everything moves evenly."""
    n = len(x)
    real, imag = np.linspace(2, 4, n), np.linspace(12, 11, n)
    real[4:] += 5
    counts = np.where(np.arange(n) < 4, 1, 3)
    rows: dict[str, Any] = {
        "bandwidth": np.minimum(real, imag),
        "first_crossing_real": real,
        "first_crossing_imag": imag,
        "crossings_real": counts,
        "crossings_imag": np.ones(n, int),
    }
    made = xr.Dataset({k: ((NATURAL,), v) for k, v in rows.items()}, {NATURAL: x}, {"band": [0.0, 20.0]})
    made[NATURAL].attrs["units"] = "rad/s"
    for name, values in more.items():
        made[f"unstable_{name}"] = ((NATURAL,), values)
        made[f"unstable_{name}"].attrs["hand"] = name
    return made


def test_curves_of_a_sweep_go_through_its_table_and_break_where_crossings_come_or_go() -> None:
    x = np.linspace(10, 100, 10)
    some, open_ = np.zeros(10, int), np.zeros(10, int)
    some[:3], open_[7] = 2, UNKNOWN
    data, ax = curves_of(x, one=some, other=open_), axes()
    lines = draw_curves(ax, data)
    variables = ["bandwidth", "first_crossing_real", "first_crossing_imag"]
    for line, name, broken in zip(lines, variables, (True, True, False), strict=True):
        shown = list(zip(x, data[name].values, strict=True))
        own = points(line)
        gaps = [i for i, p in enumerate(own) if np.isnan(p[0])]
        assert gaps == ([4] if broken else [])
        assert [p for p in own if not np.isnan(p[0])] == shown
    looks = [(to_hex(x.get_color()), x.get_linewidth(), x.get_alpha(), x.get_linestyle()) for x in lines]
    assert looks == [(pen.GREY, 3.2, 0.5, "-"), (pen.BLUE, 1.1, None, "-"), (pen.RED, 1.1, None, "--")]
    dots = [y for y in ax.lines if y.get_marker() == "o"]
    assert [points(y) for y in dots] == [[(x[i], float(data[n].values[i])) for i in (3, 4)] for n in variables[:2]]
    assert [to_hex(y.get_color()) for y in dots] == [pen.GREY, pen.BLUE]
    [end] = [y for y in ax.lines if y.get_label() == "end of the band"]
    assert list(end.get_ydata()) == [20, 20]
    assert (ax.get_xlim(), ax.get_ylim()) == ((10, 100), (0, pytest.approx(20.8)))
    assert (ax.get_xscale(), ax.get_xlabel()) == ("linear", r"$\omega_n$ (rad/s)")
    assert ax.get_ylabel() == r"$\omega$ (rad/s)"
    words = ["real part crosses", "imaginary part crosses", "bandwidth", "end of the band", "crossings come or go"]
    assert told(ax) == [*words, "not stable in one", "stability not decided in other"]
    strips = [y for y in ax.collections if y.get_hatch()]
    assert [(y.get_hatch(), to_hex(y.get_edgecolor()[0])) for y in strips] == [
        ("////", pen.RED),
        ("\\\\\\\\", pen.GREY),
    ]
    reached = [(float(v[:, 0].min()), float(v[:, 0].max())) for y in strips for v in [y.get_paths()[0].vertices]]
    assert reached == [(10, 35), (75, 85)]  # halfway to the neighbours
    further = draw_curves(ax, curves_of(np.linspace(50, 200, 10)))
    assert [y.get_label() for y in further] == [f"{w} (2)" for w in (words[2], *words[:2])]
    assert {to_hex(y.get_color()) for y in further} == {pen.SCENES[1]}
    assert ax.get_xlim() == (10, 200)
    assert [y.get_label() for y in ax.lines].count("end of the band") == 1


def test_values_by_equal_ratios_have_a_logarithmic_axis_and_no_others() -> None:
    ratios = np.geomspace(0.5, 200, 7)
    for x in (ratios, ratios[::-1], np.array([1.0, 2, 4])):
        assert is_logarithmic(x)
    for y in (np.linspace(1, 9, 7), ratios[:2], -ratios, np.concatenate([[0.0], ratios]), np.array([1.0, 2, 5])):
        assert not is_logarithmic(y)
    ax = axes()
    draw_curves(ax, curves_of(np.geomspace(10, 1000, 10)))
    assert ax.get_xscale() == "log"
    assert ax.xaxis.get_major_formatter()(1e-7, 0) == "10⁻⁷"
    ticks = [round(float(x), 6) for x in ax.xaxis.get_major_locator().tick_values(10, 99)]
    assert [x for x in ticks if 10 <= x < 100] == [10, 20, 50]


def test_a_map_of_a_sweep_shows_its_table_its_jumps_and_what_contours_do_not_tell() -> None:
    x, y = np.linspace(10, 100, 10), np.array([1.0, 2.0, 3.0])
    z = np.linspace(2, 6, 10)[None, :] + 0.5 * y[:, None]
    z[:, 5:] += 6
    z[0, 0], z[2, 9] = np.nan, 20.0
    counts = np.where(np.arange(10) < 5, 1, 3)[None, :] * np.ones((3, 1), int)
    counts[2, 9] = 2
    rows = {"bandwidth": z, "crossings_real": counts, "unstable_mine": np.where(z > 13, 2, 0)}
    data = xr.Dataset({k: ((MASS, NATURAL), v) for k, v in rows.items()}, {MASS: y, NATURAL: x}, {"band": [0.0, 20.0]})
    data[NATURAL].attrs["units"], data[MASS].attrs["units"] = "rad/s", "kg"
    data["unstable_mine"].attrs["hand"] = "mine"
    ax = axes()
    mesh, lines = draw_map(ax, data.isel({NATURAL: slice(None, None, -1)}))  # whatever the order of the table is
    assert isinstance(mesh, QuadMesh)
    shown = np.ma.filled(mesh.get_array().astype(float), np.nan).reshape(z.shape)
    assert np.array_equal(shown, z, equal_nan=True)
    assert mesh.get_clim() == (0, 20)
    assert [to_hex(mesh.cmap(v)) for v in (0.0, 1.0)] == ["#5b7fa6", "#f4f7fa"]  # the darker, the less
    assert (*ax.get_xlim(), *ax.get_ylim()) == (10, 100, 1, 3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\omega_n$ (rad/s)", "$m$ (kg)")
    inside = z[np.isfinite(z) & (z < 20)]
    levels = lines.levels  # type: ignore[attr-defined]
    assert 3 <= len(levels) <= 7
    assert inside.min() < levels.min() < levels.max() < inside.max()
    assert len(set(np.diff(levels).round(9))) == 1
    [jumps] = [c for c in ax.collections if isinstance(c, LineCollection)]
    edges = [[(float(a), float(b)) for a, b in s] for s in jumps.get_segments()]
    assert [e for e in edges if e[0][0] == e[1][0] == 55] == [
        [(55, a), (55, b)] for a, b in ((1, 1.5), (1.5, 2.5), (2.5, 3))
    ]
    assert to_hex(jumps.get_color()[0]) == pen.GREY
    assert told(ax) == [
        "bandwidth (rad/s)", "bandwidth jumps", "not at the low end", "whole band, 20 rad/s", "not stable in mine",
    ]  # fmt: skip
    hatches = [h.get_hatch() for h in ax.get_legend().legend_handles if isinstance(h, Patch)]
    assert hatches == ["xxxx", "....", "////"]
    even = axes()
    flat = data.assign(bandwidth=data.bandwidth * 0 + 7)
    assert len(draw_map(even, flat.isel({NATURAL: slice(1, 5)}))) == 1  # no contour where nothing changes


# Maps by slices


def span(low: float | None, high: float | None) -> SimpleNamespace:
    return SimpleNamespace(low=end(low), high=end(high))


def end(value: float | None, *bindings: Any) -> SimpleNamespace:
    return SimpleNamespace(value=value, bindings=bindings)


REAL, IMAG = noticed(hs.Scene(SPRING, (), (0, 15), "0.1").threshold)
EDGE, TOUCH = (SimpleNamespace(criterion=c, kind=k) for c, k in ((REAL, Kind.EDGE), (IMAG, Kind.TOUCH)))


def answer(*pairs: tuple[float | None, float | None], undecided: Any = ()) -> SimpleNamespace:
    """A slice: its intervals, above and below which the real part binds at the end of the band, the imaginary one touches."""
    spans = [
        SimpleNamespace(
            low=end(a, EDGE) if a is not None else end(None), high=end(b, TOUCH) if b is not None else end(None)
        )
        for a, b in pairs
    ]
    ends = [x for s in spans for x in (s.low, s.high) if x.value is not None]
    return SimpleNamespace(feasible=tuple(spans), ends=tuple(ends), undecided=tuple(undecided))


def knob(path: str, unit: str, dimension: Dimension) -> SimpleNamespace:
    return SimpleNamespace(path=path, name=path.split(".")[-1], unit=unit, dimension=dimension, value=None)


def sliced(requirements: dict[float, Any], **more: Any) -> Any:
    own: dict[str, Any] = {
        "free": (knob("hand.b", "N*s/m", Dimension.DAMPING), knob("environment.k", "N/m", Dimension.STIFFNESS)),
        "ranges": ((0, 10), (-20, 100)), "height": 120.0, "that": ("transparent",), "thresholds": (), "proofs": (),
        "gaps": (), "lines": (), "certified": True,
    }  # fmt: skip
    slices = tuple(SimpleNamespace(at=x, requirement=r, apart=(), contours=()) for x, r in requirements.items())
    return SimpleNamespace(**{**own, "slices": slices, **more})


SLICES = {0.0: answer((10, 50)), 4.0: answer((20, 60), undecided=[(80, None)]), 10.0: answer((None, 30), (40, None))}
"""From 4 to 10 slices differ in kind."""


def fills(ax: Axes, color: str) -> list[tuple[float, ...]]:
    found = [c for c in ax.collections if len(c.get_facecolor()) and to_hex(c.get_facecolor()[0]) == color]
    return sorted(tuple(map(float, c.get_paths()[0].get_extents().extents)) for c in found)


def hatched(ax: Axes) -> list[tuple[float, ...]]:
    return sorted(tuple(map(float, c.get_paths()[0].get_extents().extents)) for c in ax.collections if c.get_hatch())


def test_a_map_by_slices_has_strokes_marks_grounds_and_hatches_where_they_are() -> None:
    gaps = (SimpleNamespace(low=0.0, high=4.0, deviation=3.0), SimpleNamespace(low=4.0, high=10.0, deviation=None))
    found, ax = sliced(SLICES, gaps=gaps), axes()
    strokes, *marks = draw_slices(ax, found)
    ways = [[(float(a), float(b)) for a, b in s] for s in strokes.get_segments()]  # type: ignore[attr-defined]
    assert ways == [[(0, 10), (0, 50)], [(4, 20), (4, 60)], [(10, -20), (10, 30)], [(10, 40), (10, 100)]]
    where = {m.get_label(): points(m) for m in marks if isinstance(m, Line2D)}
    assert where == {
        f"real part, {Kind.EDGE.value}": [(0, 10), (4, 20), (10, 40)],
        f"imaginary part, {Kind.TOUCH.value}": [(0, 50), (4, 60), (10, 30)],
    }
    looks = [(to_hex(m.get_color()), m.get_marker(), m.get_fillstyle()) for m in marks if isinstance(m, Line2D)]
    assert looks == [(pen.BLUE, "o", "full"), (pen.RED, "s", "bottom")]
    joins = [points(x) for x in ax.lines if len(x.get_xdata()) == 2 and x.get_marker() == "None"]
    assert joins == [[(0, 10), (4, 20)], [(0, 50), (4, 60)]]
    assert fills(ax, pen.SHADE) == [(0, 10, 4, 60)]
    assert fills(ax, "#f2c14e") == [(0, 7, 4, 23), (0, 47, 4, 63)]  # as far off as 3
    assert hatched(ax) == [(2, 80, 7, 100), (4, -20, 10, 30), (4, 20, 10, 60), (4, 40, 10, 100)]
    [ticks] = [x for x in ax.lines if x.get_marker() == 3]
    assert points(ticks) == [(0, 0), (4, 0), (10, 0)]
    assert (*ax.get_xlim(), *ax.get_ylim()) == (0, 10, -20, 100)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$b$ (N·s/m)", "$k$ (N/m)")
    assert told(ax) == [
        "transparent on the slice", "between slices: interpolated", *where, "boundary between slices, estimated",
        "undecided", "exact slices",
    ]  # fmt: skip
    patches = len(ax.collections)
    again = draw_slices(ax, sliced({0.0: answer((5, 6)), 12.0: answer((5, 8))}, ranges=((0, 12), (0, 50))))
    assert {to_hex(m.get_color()) for m in again[1:] if isinstance(m, Line2D)} == {pen.SCENES[1]}
    assert all(m.get_label().endswith(" (2)") for m in again[1:])
    assert len(ax.collections) == patches + 1  # strokes, no ground
    assert (*ax.get_xlim(), *ax.get_ylim()) == (0, 12, -20, 100)
    for certified, said in ((True, "transparent nowhere"), (False, "nowhere proven transparent")):
        bare = axes()
        draw_slices(bare, sliced({0.0: answer(), 4.0: answer()}, certified=certified))
        assert [x.get_text() for x in bare.texts] == [f"{said}: on none of 2 exact slices"]
        assert told(bare) == ["exact slices"]


def test_a_map_of_what_is_proven_has_its_rectangles_and_no_guesses() -> None:
    kept, left = np.array([[[0, 4], [20, 40]], [[4, 8], [30, 50]]]), np.array([[[0, 4], [40, 45]]])
    whole = np.array([[[0, 10], [-20, 100]]])
    proof = SimpleNamespace(of="transparent", jnd=None, rectangles=Rectangles(kept, whole, left))
    ax = axes()
    draw_slices(ax, sliced(SLICES, proofs=(proof,)))
    [ground] = [c for c in ax.collections if len(c.get_facecolor()) and to_hex(c.get_facecolor()[0]) == pen.SHADE]
    assert [tuple(p.get_extents().extents) for p in ground.get_paths()] == [(0, 20, 4, 40), (4, 30, 8, 50)]
    assert fills(ax, "#f2c14e") == [(0, 40, 4, 45)]
    assert hatched(ax) == [(2, 80, 7, 100)]
    assert told(ax)[:2] == ["transparent on the slice", "transparent, proven"]
    assert "left open, holds the boundary" in told(ax)
    both = axes()
    draw_wishes(both, sliced(SLICES, proofs=(proof,), thresholds=()))
    assert told(both) == [
        "this set, proven", "transparent", "left open, holds the boundary", "this set, exact slices", "undecided",
    ]  # fmt: skip
    [ground] = [c for c in both.collections if len(c.get_facecolor()) and to_hex(c.get_facecolor()[0]) == pen.SHADE]
    sizes = [p.get_extents().size for p in ground.get_paths()]
    assert sum(a * b for a, b in sizes) == pytest.approx(160, rel=0.1)


def classical(name: str, excess: Callable[[Any], float], *where: tuple[str, float]) -> SimpleNamespace:
    return SimpleNamespace(name=name, excess=excess, where=where)


def test_a_map_of_several_things_shows_each_set_and_classical_bounds_where_they_are_met() -> None:
    """K less 5 b is 0 along k = 5 b; a bound at b = 4 alone, 70 N/m, is a diamond there."""
    k = "environment.k"
    bounds = (
        classical("slope", lambda at: at[k] - 5 * at["hand.b"]),
        classical("spot", lambda at: at[k] - 70, ("hand.b", 4.0)),
        classical("far", lambda at: at[k] - 700),
        classical("beside", lambda at: at[k] - 70, ("hand.b", 11.0)),
        classical("above", lambda at: at[k] - 700, ("hand.b", 4.0)),
        classical("divided", lambda at: at[k] - 1 / at["hand.b"]),
    )
    found = sliced(SLICES, that=("transparent", "stable"), lines=bounds[:3])
    for x in found.slices:
        x.apart = (x.requirement, answer((x.at, 90)))
    ax = axes()
    draw_wishes(ax, found)
    assert told(ax) == [
        "all that is asked, interpolated", "transparent", "stable", "all that is asked, exact slices", "undecided",
        "slope", "spot (b = 4)",
    ]  # fmt: skip
    sets = {c: [points(x) for x in ax.lines if to_hex(x.get_color()) == c] for c in (pen.BLUE, pen.RED)}
    assert sets[pen.BLUE] == [
        [(0, 10), (4, 20)],
        [(0, 50), (4, 60)],
        [(0, 10), (0, 50), (4, 20), (4, 60), (10, 30), (10, 40)],
    ]
    assert sets[pen.RED][:2] == [[(0, 0), (4, 4)], [(0, 90), (4, 90)]]
    assert hatched(ax) == [(2, 80, 7, 100)]  # an open slice says it itself
    [spot] = [x for x in ax.lines if x.get_marker() == "D"]
    assert points(spot) == [(4, 70)]
    contours = [p.vertices for c in ax.collections for p in c.get_paths() if len(p.vertices) > 100]
    [slope] = [v for v in contours if np.allclose(v[:, 1], 5 * v[:, 0], atol=1e-9)]
    assert np.ptp(slope[:, 0]) == pytest.approx(10, abs=0.1)
    other = axes()
    draw_wishes(other, sliced(SLICES, lines=bounds[3:]))
    assert told(other)[-1:] == ["divided"]
    turned = axes()
    where = classical("lower", lambda at: at["hand.b"] - 3, (k, 50.0))
    draw_wishes(turned, sliced(SLICES, lines=(where,)))
    [mark] = [x for x in turned.lines if x.get_marker() == "D"]
    assert points(mark) == [(3, 50)]


# Identified models


class Lines(SimpleNamespace):
    def __len__(self) -> int:
        return len(self.omega)


def identified(omega: Any, m: float, b: float, k: float, discs: float | None, error: Any) -> Any:
    model = k - m * omega**2 + 1j * b * omega
    reach = None if discs is None else np.full(len(omega), discs)
    fit = SimpleNamespace(
        lines=Lines(omega=omega, H=model + error, discs=reach, confidence=0.95), model=model, values=(m, b, k), residuals=error
    )  # fmt: skip
    return SimpleNamespace(fit=fit, wanted=None, motion=None)


def test_magnitude_phase_and_residuals_are_those_of_the_model_and_of_its_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    def curve(_wanted: Any, omega: Any) -> Any:
        return SimpleNamespace(at=lambda v: v[2] - v[0] * omega**2 + 1j * v[1] * omega)

    monkeypatch.setattr("haptisym.figures.identify.Curve", curve)
    for omega, discs in ((np.array([1.0, 2, 5, 9, 31]), 20.0), (np.array([1.0, 2, 5, 9, 29]), None)):
        error = np.array([3 + 1j, -2j, 5, 1 - 1j, -4.0])
        found = identified(omega, 2.0, 15.0, 100.0, discs, error)
        H, scale = found.fit.lines.H, "log" if omega[-1] > 30 else "linear"
        for draw in (draw_magnitude, draw_phase):
            ax = axes()
            line, dots = draw(ax, found)
            at = np.asarray(line.get_xdata())
            exact = 100 - 2 * at**2 + 15j * at
            assert (at[0], at[-1], 790 < len(at) < 806) == (1, omega[-1], True)
            assert set(omega) <= set(at)
            assert (ax.get_xscale(), ax.get_xlabel()) == (scale, r"$\omega$ (rad/s)")
            assert (to_hex(line.get_color()), to_hex(dots.get_color())) == (pen.RED, pen.BLUE)
            assert list(dots.get_xdata()) == list(omega)
            [bars] = ax.collections
            ends = np.array([s[:, 1] for s in bars.get_segments()])  # type: ignore[attr-defined]
            if draw is draw_magnitude:
                assert line.get_ydata() == pytest.approx(np.abs(exact))
                assert dots.get_ydata() == pytest.approx(np.abs(H))
                r = discs or 0.0
                assert ends == pytest.approx(np.stack([np.maximum(np.abs(H) - r, 1e-3 * np.abs(H)), np.abs(H) + r], 1))
                assert ax.get_yscale() == "log"
                assert told(ax) == ["model", "measured", *(["95 % disc"] if discs else [])]
                assert ax.get_ylabel() == "$|H|$ (N/m)"
            else:
                assert line.get_ydata() == pytest.approx(np.degrees(np.unwrap(np.angle(exact))))
                own = np.degrees(np.unwrap(np.angle(H)))
                assert dots.get_ydata() == pytest.approx(own)
                half = np.degrees(np.arcsin(np.minimum((discs or 0.0) / np.abs(H), 1)))
                assert ends == pytest.approx(np.stack([own - half, own + half], 1))
                assert ax.get_ylabel() == "phase (deg)"
        ax = axes()
        real, imag = draw_residuals(ax, found)
        unit = 1.0 if discs else np.sqrt((np.abs(error) ** 2).mean() / 2)
        assert (real.get_ydata(), imag.get_ydata()) == (
            pytest.approx(error.real / unit),
            pytest.approx(error.imag / unit),
        )
        levels = [(float(x.get_ydata()[0]), x.get_linestyle()) for x in ax.lines if len(x.get_xdata()) == 2]
        assert levels == [(-2, "--"), (0, "-"), (2, "--")]
        top = max(3.0, 1.1 * 5 / unit)
        assert ax.get_ylim() == (pytest.approx(-top), pytest.approx(top))
        assert [x.get_markerfacecolor() for x in (real, imag)] == [pen.INK, "white"]
        assert told(ax) == [r"$\mathrm{Re}$", r"$\mathrm{Im}$"]
    flat = axes()
    draw_magnitude(flat, identified(np.array([1.0, 2, 3]), 0.0, 1.0, 100.0, None, np.zeros(3)))
    assert flat.get_yscale() == "linear"
    calm = axes()
    draw_residuals(calm, identified(np.array([1.0, 2, 3]), 0.0, 1.0, 100.0, None, np.zeros(3)))
    assert calm.get_ylim() == (-3, 3)
