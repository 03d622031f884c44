"""Design charts of sweeps: first crossings and bandwidth over one parameter, or a map over two.

The data of a sweep as charts take them: names and units of axes, and where the bandwidth jumps between sets.

Design charts: first crossings and bandwidth over one parameter, or a map of the bandwidth over two.

Each ``draw_`` function draws on the axes that it is given, so that other curves (exact boundaries, a design) can be laid over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from haptisym.figures import pen
from haptisym.figures.designmap import draw_boundary
from haptisym.figures.sheet import one_column
from haptisym.figures.style import (
    RADIANS,
    Look,
    Scale,
    dots,
    dress,
    entries,
    floats_scale,
    handle,
    labelled_scale,
    legend,
    limit,
    name_parameter,
    number,
)
from haptisym.kernel.errors import SceneError
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.require.designmap import DesignMap, design_map
from haptisym.verbs.require.required import is_quick
from haptisym.verbs.sweep.axes import HELD, UNKNOWN
from haptisym.verbs.sweep.entry import Swept

if TYPE_CHECKING:
    import xarray as xr


_MOST_PIXELS = 1200  # along an axis; a chart in print shows no more


def dimensions(data: xr.Dataset, count: int) -> list[str]:
    """The parameters of a sweep over so many; SceneError for any other."""
    found = [str(name) for name in data.bandwidth.dims]
    if len(found) != count or min(data.bandwidth.shape) < 2:
        raise SceneError(
            f"a chart shows one or two parameters with at least two values each, not {dict(data.bandwidth.sizes)}: "
            "choose with Dataset.sel, or sweep fewer"
        )
    return found


def thinned_data(data: xr.Dataset, names: tuple[str, str]) -> xr.Dataset:
    """What a map shows, no finer than it is seen."""
    steps = {name: slice(None, None, -(-data.sizes[name] // _MOST_PIXELS)) for name in names}
    wanted = ["bandwidth", *(f"crossings_{name}" for name in judged_in(data)), *held_in(data)]
    return data[wanted].isel(steps).load()


def axis_name(data: xr.Dataset, path: str, scale: Scale) -> str:
    """Symbol and unit of a parameter, whose element is named only where another one has the same symbol."""
    keys = {str(other): _symbol(str(other)) for other in data.bandwidth.dims}
    shared = list(keys.values()).count(keys[path]) > 1 or path.startswith("rendered.")
    element = "_" + "_".join(path.split(".")[:-1]).removeprefix("effects_").replace("-", "_") if shared else ""
    unit = str(data[path].attrs.get("units", ""))
    return name_parameter(keys[path] + element, unit if scale.factor == 1 else scale.unit)


def _symbol(path: str) -> str:
    _, _, key = path.rpartition(".")
    return key if not path.startswith("evaluation.") else "c" if key == "jnd" else f"c_{key}"


def axis_scale(data: xr.Dataset, path: str) -> Scale:
    """Hz where the frequencies of an axis begin and end with short numbers in Hz."""
    is_frequency = data[path].attrs.get("units") == "rad/s"
    return floats_scale([data[path].values.min(), data[path].values.max()]) if is_frequency else RADIANS


def is_logarithmic(x: Array) -> bool:
    """Whether values are spaced by equal ratios rather than evenly."""
    if len(x) < 3 or x.min() <= 0:
        return False
    even, ratio = np.diff(x), np.diff(np.log(x))
    return bool(np.ptp(ratio) < 1e-6 * abs(ratio).max() and np.ptp(even) > 1e-6 * abs(even).max())


def held_in(data: xr.Dataset) -> list[str]:
    """The variables of a sweep that tell of a hand."""
    return [str(name) for name in data.data_vars if str(name).startswith(HELD)]


def jumps_of(y: Array, counts: Any, band: float) -> Any:
    """The places before which a curve is broken; ``counts`` : of the crossings of the parts that it depends on, in rows.

    Where a pair of crossings of a part comes or goes, and the curve moves more there than beside: the lowest one may be among
    them. A crossing alone comes in over an end of the band, so that the curve goes on; there, as elsewhere, it is only broken
    where it moves far more than on both sides.
    """
    steps = np.pad(np.abs(np.diff(y)), 1, constant_values=np.nan)
    least, most = (np.nan_to_num(pick(steps[:-2], steps[2:])) for pick in (np.fmin, np.fmax))
    pairs = (np.abs(np.diff(counts, axis=1)) > 1).any(axis=0)
    smooth = np.where(pairs, np.maximum(1.5 * least, 0.004 * band), np.maximum(6 * most, 0.05 * band))
    return (steps[1:-1] > smooth).nonzero()[0] + 1


JUDGED = ("real", "imag", "joint")
"""The names of the criteria of which a sweep may tell, in the order of its charts."""


def judged_in(data: xr.Dataset) -> list[str]:
    """The names of the criteria of which a sweep tells."""
    return [name for name in JUDGED if f"crossings_{name}" in data]


def crossing_counts(data: xr.Dataset) -> Any:
    """How many crossings there are, of each criterion."""
    return np.stack([data[f"crossings_{name}"].values for name in judged_in(data)]).astype(np.int64)


def jump_edges(data: xr.Dataset, x: Array, y: Array, z: Array, band: float) -> list[list[tuple[float, float]]]:
    """The edges between neighbouring sets across which the bandwidth jumps, as pieces of lines."""
    counts = crossing_counts(data)
    across, up = edges(x), edges(y)
    found = []
    for i, row in enumerate(z):
        found += [[(across[j], up[i]), (across[j], up[i + 1])] for j in jumps_of(row, counts[:, i], band)]
    for j, column in enumerate(z.T):
        found += [[(across[j], up[i]), (across[j + 1], up[i])] for i in jumps_of(column, counts[:, :, j], band)]
    return found


def edges(x: Array) -> Array:
    """The ends of the cells whose middles are given."""
    middles = (x[1:] + x[:-1]) / 2
    found: Array = np.concatenate([[x[0]], middles, [x[-1]]])
    return found


_LEVELS, _SLICES = 7, 31
_MAP = LinearSegmentedColormap.from_list("bandwidth", ["#5b7fa6", "#a9c0d6", "#f4f7fa"])  # monotone in grey, too
_CURVES = {
    "real": (pen.BLUE, pen.SOLID, "real part crosses"),
    "imag": (pen.RED, pen.DASHED, "imaginary part crosses"),
    "joint": (pen.BLUE, pen.SOLID, "leaves the JND region"),
}


def draw_curves(ax: Axes, data: xr.Dataset, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """First crossings of what is judged and the bandwidth over the one parameter of a sweep.

    A curve is broken, with a dot at each end, where it jumps because crossings come or go: nothing was computed in between.
    Hatched: the sets that are not stable in a hand.
    ``color``, ``label`` : of the sweep, in the drawing and in the legend. Returns the lines: bandwidth, then each criterion.

    >>> from haptisym import load_scene, sweep
    >>> from matplotlib.figure import Figure
    >>> found = sweep(load_scene("fu2019"), {"effects.filter.omega_n": [40.0, 60.0, 80.0]})
    >>> [line.get_label() for line in draw_curves(Figure().add_subplot(), found)]
    ['bandwidth', 'real part crosses', 'imaginary part crosses']
    """
    [path] = dimensions(data, 1)
    data = data.load()
    look = Look.on(ax, "bandwidth", color, label)
    along, upwards = axis_scale(data, path), _frequency_scale(ax, data)
    x = along.of(data[path].values)
    low, high = (upwards.of(float(end)) for end in data.attrs["band"])
    counts = crossing_counts(data)
    style: dict[str, Any] = {"color": look.ink(pen.GREY), "linewidth": 3.2, "alpha": 0.5}
    rows = [("bandwidth", "bandwidth", {**style, "solid_capstyle": "butt"})]
    for criterion in judged_in(data):
        own, stroke, name = _CURVES[criterion]
        shown = look.ink(own)
        rows.append((f"first_crossing_{criterion}", name, {"color": shown, "linestyle": stroke, "linewidth": 1.1}))
    lines, breaks = list[Line2D](), list[Line2D]()
    for variable, name, style in rows:
        y = upwards.of(data[variable].values)
        parts = [i for i, x in enumerate(judged_in(data)) if variable in ("bandwidth", f"first_crossing_{x}")]
        jumps = jumps_of(y, counts[parts], high - low)
        broken = np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)
        lines += ax.plot(*broken, label=f"{name}{look.suffix}", **style)
        breaks += _draw_ends(ax, x, y, jumps, str(style["color"]))
    told = "end of the band" in entries(ax)
    end = [] if told else [ax.axhline(high, color=pen.GREY, linewidth=0.4, zorder=0, label="end of the band")]
    limit(ax, (x.min(), x.max()), (low, high * 1.04), number=look.number)
    dress(ax)
    _scale(ax, "x", x)
    ax.set_xlabel(axis_name(data, path, along), fontsize=pen.TEXT)
    ax.set_ylabel(upwards.label, fontsize=pen.TEXT)
    jump = [handle(pen.INK, "none", "crossings come or go", marker="o", markersize=2.4)] if breaks else []
    legend(ax, [*lines[1:], lines[0], *end, *jump, *_draw_held_curves(ax, data, x)])
    return lines


def _draw_ends(ax: Axes, x: Array, y: Array, jumps: Any, color: str) -> list[Line2D]:
    """A dot on each side of each break."""
    ends = np.union1d(jumps - 1, jumps).astype(int)
    return ax.plot(x[ends], y[ends], color=color, zorder=4, **dots(2.4)) if len(ends) else []


def draw_map(ax: Axes, data: xr.Dataset, exact: DesignMap | None = None) -> list[Artist]:
    """The bandwidth over the two parameters of a sweep, the first upwards: contour lines on a quiet map.

    Hatched where the display is not transparent at the band's low end, or not stable in a hand; no shade is darker than the ink
    of the lines. A thick grey line, which contour lines do not cross, is where the bandwidth jumps from one set to the next.
    ``exact`` : the same plane by exact slices, whose boundary of the transparent region is drawn: points that are proven, and
    straight lines between them. Returns the map and its contour lines.

    >>> from haptisym import load_scene, sweep
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> found = sweep(load_scene("fu2019"), {"effects.filter.omega_n": [40.0, 60.0, 80.0], "environment.m": [1.0, 2.0]})
    >>> shown = draw_map(ax, found)
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('$m$ (kg)', '$\\\\omega_n$ (rad/s)')
    """
    upwards, along = dimensions(data, 2)
    data = thinned_data(data, (upwards, along)).sortby([upwards, along])
    scales, unit = (axis_scale(data, along), axis_scale(data, upwards)), floats_scale(data.attrs["band"])
    x, y = scales[0].of(data[along].values), scales[1].of(data[upwards].values)
    z, (low, high) = unit.of(data.bandwidth.values), (unit.of(float(end)) for end in data.attrs["band"])
    _scale_axes(ax, x, y)
    shown: list[Artist] = [ax.pcolormesh(x, y, z, cmap=_MAP, vmin=low, vmax=high, shading="nearest", rasterized=True)]
    jumps = jump_edges(data, x, y, z, high - low)
    _draw_contours(ax, x, y, z, high, shown)
    if jumps:
        ax.add_collection(LineCollection(jumps, colors=pen.GREY, linewidths=1.8, alpha=0.8, capstyle="projecting"))
    ax.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    ax.set_xlabel(axis_name(data, along, scales[0]), fontsize=pen.TEXT)
    ax.set_ylabel(axis_name(data, upwards, scales[1]), fontsize=pen.TEXT)
    boundary = [x for _, x in draw_boundary(ax, exact, width=1.1)] if exact else []
    jump = [handle(pen.GREY, pen.SOLID, "bandwidth jumps", 1.8, alpha=0.8)] if jumps else []
    lines = [handle(pen.INK, pen.SOLID, f"bandwidth ({unit.unit})", 0.7)]
    held = _draw_held_map(ax, data, x, y)
    legend(ax, [*lines, *jump, *_plateaus(ax, (x, y, z), high, unit), *held, *boundary])
    return shown


def _draw_contours(ax: Axes, x: Array, y: Array, z: Array, high: float, shown: list[Artist]) -> None:
    levels = _round_levels(z, high)
    if len(levels):
        lines = ax.contour(x, y, z, levels=levels, colors=pen.INK, linewidths=0.7)
        ax.clabel(lines, fontsize=pen.SMALL, fmt=number, inline_spacing=3)
        shown.append(lines)


def _plateaus(ax: Axes, map_: tuple[Array, Array, Array], high: float, unit: Scale) -> list[Any]:
    """What contour lines do not tell: nowhere transparent, and transparent up to the end of the band."""
    x, y, z = map_
    handles = []
    whole = f"whole band, {number(high, 4)} {unit.unit}"
    for where, hatch, label in ((np.isnan(z), "xxxx", "not at the low end"), (z >= high, "....", whole)):
        if where.any() and not where.all():
            _hatched(ax, x, y, where, hatch, pen.GREY)
        if where.any():
            handles.append(Patch(facecolor="white", edgecolor=pen.GREY, hatch=hatch, linewidth=0.4, label=label))
    return handles


def _hatched(ax: Axes, x: Array, y: Array, where: Any, hatch: str, color: str) -> None:
    found = ax.contourf(x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch])
    found.set(edgecolor=color, linewidth=0.0)


def draw_swept(ax: Axes, found: Swept) -> list[Artist]:
    """The chart of a sweep over one parameter, or over two. Returns what it is made of."""
    one = len(found.data.bandwidth.dims) == 1
    return list(draw_curves(ax, found.data)) if one else draw_map(ax, found.data)


def swept_figure(found: Swept) -> Figure:
    """The chart of a sweep; where that takes moments, with the exact boundary of the transparent region on a map."""
    return sweep_figure(found.data, found.scene)


def sweep_figure(data: xr.Dataset, scene: Scene | None = None) -> Figure:
    """The chart of a sweep over one or two parameters, one column (3.4 in) wide."""
    if len(data.bandwidth.dims) == 1:
        return one_column(2.2, lambda ax: draw_curves(ax, data))
    exact = _exact(data, scene) if scene is not None and is_quick(scene) else None
    return one_column(2.8, lambda ax: draw_map(ax, data, exact))


def _exact(data: xr.Dataset, scene: Scene) -> DesignMap:
    upwards, along = dimensions(data, 2)
    ranges = [tuple(float(x) for x in (data[path].min(), data[path].max())) for path in (along, upwards)]
    return design_map(scene, (along, upwards), [(low, high) for low, high in ranges], slices=_SLICES)


def _frequency_scale(ax: Axes, data: xr.Dataset) -> Scale:
    return labelled_scale(ax.get_ylabel()) or floats_scale(data.attrs["band"])


def _scale(ax: Axes, which: str, values: Array) -> None:
    if not is_logarithmic(values):
        return
    getattr(ax, f"set_{which}scale")("log")
    axis = getattr(ax, f"{which}axis")
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_minor_locator(NullLocator())
    plain = FuncFormatter(lambda value, _: number(value))
    axis.set_major_formatter(plain)


def _scale_axes(ax: Axes, x: Array, y: Array) -> None:
    dress(ax)
    _scale(ax, "x", x)
    _scale(ax, "y", y)


def _round_levels(z: Array, high: float) -> Array:
    """A few round values between the least and the largest bandwidth, those of the whole band left out."""
    inside = z[np.isfinite(z) & (z < high)]
    if not len(inside) or inside.min() == inside.max():
        return np.zeros(0)
    levels: Array = np.asarray(MaxNLocator(_LEVELS, steps=[1, 2, 2.5, 5, 10]).tick_values(inside.min(), inside.max()))
    kept: Array = levels[(levels > inside.min()) & (levels < min(inside.max(), 0.999 * high))]
    return kept


_HATCHES = ("////", "\\\\\\\\", "||||", "----")


def _draw_held_curves(ax: Axes, data: xr.Dataset, x: Array) -> list[Patch]:
    """Upright strips about the sets that are not stable in a hand, halfway to their neighbours; entries for a legend."""
    borders = np.repeat(edges(x), 2)[1:-1]

    def strip(where: Any, style: dict[str, Any]) -> None:
        own = np.repeat(where, 2)
        ax.fill_between(borders, 0, 1, where=own, transform=ax.get_xaxis_transform(), zorder=0, **style)

    return _each(data, strip)


def _draw_held_map(ax: Axes, data: xr.Dataset, x: Array, y: Array) -> list[Patch]:
    """The same over two parameters."""

    return _each(data, lambda where, style: _hatched(ax, x, y, where, style["hatch"], style["edgecolor"]))


def _each(data: xr.Dataset, draw: Any) -> list[Patch]:
    handles = []
    for name, hatch in zip(held_in(data), _HATCHES, strict=False):
        counts, hand = data[name].values, str(data[name].attrs["hand"])
        for where, said, color in (
            (counts > 0, "not stable", pen.RED),
            (counts == UNKNOWN, "stability not decided", pen.GREY),
        ):
            style: dict[str, Any] = {"facecolor": "none", "edgecolor": color, "linewidth": 0.0, "hatch": hatch}
            if np.any(where):
                draw(where, style)
                handles.append(Patch(label=f"{said} in {hand}", **{**style, "linewidth": 0.4}))
    return handles
