"""Design charts of sweeps: first crossings and bandwidth over one parameter, or a map of the
bandwidth over two.

The data of a sweep are an xarray Dataset in SI; axes are in the scene's units where the scene is at
hand. A curve is broken where it jumps because crossings come or go: nothing was computed in
between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from sympy import Symbol

from haptisym.figures import pen
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import (
    DrawnAxis,
    Layer,
    Limit,
    Mark,
    On,
    Panel,
    Polyline,
    Words,
    dots,
    frequency,
    handle,
    number,
    small,
)
from haptisym.figures.measured import unit_of
from haptisym.figures.requirement import boundary
from haptisym.kernel.errors import SceneError
from haptisym.model.quantities import Unit
from haptisym.model.scene import Scene
from haptisym.programs.values import Array
from haptisym.verbs.require.designmap import DesignMap, design_map
from haptisym.verbs.require.required import is_quick
from haptisym.verbs.sweep.axes import HELD, UNKNOWN
from haptisym.verbs.sweep.entry import Swept
from haptisym.writing.latex import formula

if TYPE_CHECKING:
    import xarray as xr

_MOST_PIXELS = 1200  # along an axis; a chart in print shows no more
_LEVELS, _SLICES = 7, 31
# From dark to light without a turn, so that the order of the values is seen in grey print, too.
_MAP = LinearSegmentedColormap.from_list("bandwidth", ["#5b7fa6", "#a9c0d6", "#f4f7fa"])
_CURVES = {
    "real": (pen.BLUE, pen.SOLID, "real part crosses"),
    "imag": (pen.RED, pen.DASHED, "imaginary part crosses"),
    "joint": (pen.BLUE, pen.SOLID, "leaves the JND region"),
}
"""For each criterion, in the order of the charts: colour, stroke and name."""
_HATCHES = ("////", "\\\\\\\\", "||||", "----")


# The data as charts take them.


def _dimensions(data: xr.Dataset, count: int) -> list[str]:
    """The parameters of a sweep over so many; SceneError for any other."""
    names = [str(name) for name in data.bandwidth.dims]
    if len(names) != count or min(data.bandwidth.shape) < 2:
        raise SceneError(
            f"a chart shows one or two parameters with at least two values each, not "
            f"{dict(data.bandwidth.sizes)}: "
            "choose with Dataset.sel, or sweep fewer"
        )
    return names


def _thinned(data: xr.Dataset, names: tuple[str, str]) -> xr.Dataset:
    """What a map shows, no finer than it is seen."""
    # Rounded upwards, so that never more than the bound remain.
    steps = {name: slice(None, None, -(-data.sizes[name] // _MOST_PIXELS)) for name in names}
    wanted = ["bandwidth", *(f"crossings_{name}" for name in _judged_in(data)), *_held_in(data)]
    return data[wanted].isel(steps).load()


def _axis(data: xr.Dataset, path: str, scene: Scene | None) -> DrawnAxis:
    """The axis of a parameter; its element is named only where another one has the same symbol."""
    keys = {str(other): _symbol(str(other)) for other in data.bandwidth.dims}
    shared = list(keys.values()).count(keys[path]) > 1 or path.startswith("rendered.")
    element = (
        "_" + "_".join(path.split(".")[:-1]).removeprefix("effects_").replace("-", "_")
        if shared
        else ""
    )
    x, units = data[path].values, str(data[path].attrs.get("units", ""))
    # Without a scene the data know rad/s alone: Hz is chosen where the ends are short numbers in
    # it.
    unit = (
        unit_of(np.array([x.min(), x.max()]))
        if units == "rad/s"
        else Unit("" if units == "1" else units)
    )
    if scene is not None and path in {one for x in scene.knobs for one in x.paths}:
        knob = scene.knobs[path]
        unit = knob.shown_unit(knob.motion)
    label = f"${formula(Symbol(keys[path] + element))}$"
    return DrawnAxis(label, unit, (float(x.min()), float(x.max())), None, log=is_logarithmic(x))


def _symbol(path: str) -> str:
    """Return the symbol of a parameter from its path; thresholds are c with their part."""
    _, _, key = path.rpartition(".")
    return key if not path.startswith("evaluation.") else "c" if key == "jnd" else f"c_{key}"


def is_logarithmic(x: Array) -> bool:
    """Whether values are spaced by equal ratios rather than evenly."""
    if len(x) < 3 or x.min() <= 0:
        return False
    # Equal but for the rounding of the values: 1e-6 is far above that and far below a spacing that
    # somebody chose.
    even, ratio = np.diff(x), np.diff(np.log(x))
    return bool(np.ptp(ratio) < 1e-6 * abs(ratio).max() and np.ptp(even) > 1e-6 * abs(even).max())


def _held_in(data: xr.Dataset) -> list[str]:
    """Return the names of a sweep's variables that are about a hand."""
    return [str(name) for name in data.data_vars if str(name).startswith(HELD)]


def _judged_in(data: xr.Dataset) -> list[str]:
    """The names of the criteria of which a sweep tells."""
    return [name for name in _CURVES if f"crossings_{name}" in data]


def _counts(data: xr.Dataset) -> Any:
    """How many crossings there are, of each criterion."""
    return np.stack([data[f"crossings_{name}"].values for name in _judged_in(data)]).astype(
        np.int64
    )


def _jumps(y: Array, counts: Any, band: float) -> Any:
    """The places before which a curve is broken; ``counts`` : of the crossings of the parts that it
    depends on, in rows.

    Where a pair of crossings of a part comes or goes, and the curve moves more there than beside:
    the lowest one may be among them. A crossing alone comes in over an end of the band, so that the
    curve goes on; there, as elsewhere, it is only broken where it moves far more than on both
    sides.
    """
    # The first and the last step have a neighbour on one side alone: fmin and fmax pass over NaN.
    steps = np.pad(np.abs(np.diff(y)), 1, constant_values=np.nan)
    before, after = steps[:-2], steps[2:]
    least, most = (np.nan_to_num(pick(before, after)) for pick in (np.fmin, np.fmax))
    pairs = (np.abs(np.diff(counts, axis=1)) > 1).any(axis=0)
    # How far a curve may move without a jump: little where crossings give a reason to suspect one,
    # much where nothing does. A steep but smooth curve is steep on one side of the step, too.
    suspected = np.maximum(1.5 * least, 0.004 * band)
    unsuspected = np.maximum(6 * most, 0.05 * band)
    smooth = np.where(pairs, suspected, unsuspected)
    return (steps[1:-1] > smooth).nonzero()[0] + 1


def _edges(x: Array) -> Array:
    """Return the ends of the cells whose middles are given; the first and the last cell end at
    their middles."""
    found: Array = np.concatenate([[x[0]], (x[1:] + x[:-1]) / 2, [x[-1]]])
    return found


def _unit(data: xr.Dataset, scene: Scene | None) -> Unit:
    """Return the unit in which frequencies are drawn."""
    return unit_of(np.array(data.attrs["band"])) if scene is None else scene.frequency


# One parameter.


def curves(data: xr.Dataset, scene: Scene | None = None) -> Panel:
    """First crossings of what is judged and the bandwidth over the one parameter of a sweep.

    A curve has a dot at each end where it is broken. Hatched: the sets that are not stable in a
    hand.

    >>> from haptisym import load_scene, sweep
    >>> found = sweep(load_scene("fu2019"), {"effects.filter.omega_n": [40.0, 60.0, 80.0]})
    >>> [layer.name for layer in curves(found).layers if isinstance(layer, Polyline)]
    ['real part crosses', 'imaginary part crosses', 'bandwidth']
    """
    [path] = _dimensions(data, 1)
    data = data.load()
    x, (low, high), counts = data[path].values, data.attrs["band"], _counts(data)
    rows: list[tuple[Any, ...]] = [
        (f"first_crossing_{name}", [i], *_CURVES[name], 1.1, {})
        for i, name in enumerate(_judged_in(data))
    ]
    wide = {"alpha": 0.5, "solid_capstyle": "butt", "zorder": 1.5}
    rows.append(("bandwidth", list(range(len(rows))), pen.GREY, pen.SOLID, "bandwidth", 3.2, wide))
    lines, marks = list[Layer](), list[Layer]()
    for variable, parts, color, stroke, name, width, look in rows:
        y = data[variable].values
        if name != "bandwidth" and np.isnan(y).all():
            continue
        jumps = _jumps(y, counts[parts], high - low)
        lines.append(
            Polyline(
                # A NaN before the set at which the curve begins anew breaks the line.
                np.insert(x, jumps, np.nan),
                np.insert(y, jumps, np.nan),
                color,
                stroke,
                width,
                name=name,
                look=look,
            )
        )
        # A single set that has a value is no line: it has a dot alone.
        there = np.isfinite(np.concatenate([[np.nan], y, [np.nan]]))
        alone = np.flatnonzero(there[1:-1] & ~there[:-2] & ~there[2:])
        ends = np.union1d(np.union1d(jumps - 1, jumps), alone).astype(int)
        whole = {"clip_on": False}
        marks += [Mark(x[ends], y[ends], color, size=2.4, look=whole)] if len(ends) else []
    entry = [Words(label="crossings come or go", look=dots(2.4))] if marks else []
    end = Limit(high, width=0.4, label="end of the band", shared=True, look={"zorder": 0})
    strips = [_Held(x, None, *row[1:], label=row[0]) for row in _held(data)]
    upright = frequency(_unit(data, scene), (low, high + 0.04 * (high - low)))
    return Panel(
        [*lines, *marks, end, *entry, *strips], _axis(data, path, scene), upright, height=2.2
    )


def _held(data: xr.Dataset) -> list[tuple[str, Any, str, str]]:
    """Of each hand where the display is unstable, and where that is undecided: words, where, hatch
    and colour."""
    rows = []
    for name, hatch in zip(_held_in(data), _HATCHES, strict=False):
        counts = data[name].values
        hand = str(data[name].attrs["hand"])
        rows.append((f"unstable in {hand}", counts > 0, hatch, pen.RED))
        rows.append((f"stability undecided in {hand}", counts == UNKNOWN, hatch, pen.GREY))
    return [row for row in rows if np.any(row[1])]


@dataclass(frozen=True)
class _Held(Layer):
    """A hatch about some sets: upright strips halfway to their neighbours, or over two
    parameters."""

    x: Array
    y: Array | None
    where: Any
    hatch: str
    color: str

    def draw(self, on: On) -> list[Artist]:
        if self.y is not None:
            _hatched(on, (self.x, self.y), self.where, self.hatch, self.color)
            return [self._patch()]
        # Each strip needs both of its borders with the same value: inner borders occur twice.
        borders, held = np.repeat(_edges(self.x), 2)[1:-1], np.repeat(self.where, 2)
        style: dict[str, Any] = {
            "facecolor": "none",
            "edgecolor": self.color,
            "linewidth": 0.0,
            "hatch": self.hatch,
            "zorder": 0,
        }
        on.ax.fill_between(
            on.x.of(borders), 0, 1, where=held, transform=on.ax.get_xaxis_transform(), **style
        )
        return [self._patch()]

    def _patch(self) -> Patch:
        return Patch(facecolor="white", edgecolor=self.color, hatch=self.hatch, linewidth=0.4)


def _hatched(on: On, axes: tuple[Array, Array], where: Any, hatch: str, color: str) -> None:
    """Hatch the sets of a map for which something holds."""
    x, y = on.x.of(axes[0]), on.y.of(axes[1])
    found = on.ax.contourf(
        x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch]
    )
    found.set(edgecolor=color, linewidth=0.0)


# Two parameters.


def plane(data: xr.Dataset, exact: DesignMap | None = None, scene: Scene | None = None) -> Panel:
    """The bandwidth over the two parameters of a sweep, the first upwards: contour lines on a quiet
    map.

    Hatched where the display is not transparent at the band's low end, or not stable in a hand; no
    shade is darker than the ink of the lines. A thick grey line, which contour lines do not cross,
    is where the bandwidth jumps from one set to the next.
    ``exact`` : the same plane by exact slices, whose boundary of the transparent region is drawn:
    points that are proven, and straight lines between them.

    >>> from haptisym import load_scene, sweep
    >>> sets = {"effects.filter.omega_n": [40.0, 60.0, 80.0], "environment.m": [1.0, 2.0]}
    >>> found = sweep(load_scene("fu2019"), sets)
    >>> plane(found).x.text, plane(found).y.text
    ('$m$ (kg)', '$\\\\omega_n$ (rad/s)')
    """
    upwards, along = _dimensions(data, 2)
    # pcolormesh and contours need both axes in ascending order.
    data = _thinned(data, (upwards, along)).sortby([upwards, along])
    x, y, z, (low, high) = (
        data[along].values,
        data[upwards].values,
        data.bandwidth.values,
        data.attrs["band"],
    )
    unit = _unit(data, scene)
    layers: list[Layer] = [
        _Field(x, y, z, (low, high), unit, label=f"bandwidth ({unit.text})", styled=True)
    ]
    jumps = _jump_edges(data, x, y, z, high - low)
    layers += [_Jumps(jumps, label="bandwidth jumps")] if jumps else []
    whole = f"whole band, {frequency(unit).short(high)}"
    for where, hatch, label in (
        (np.isnan(z), "xxxx", "not at the low end"),
        (z >= high, "....", whole),
    ):
        layers += [_Plateau(x, y, where, hatch, label=label)] if where.any() else []
    layers += [_Held(x, y, *row[1:], label=row[0]) for row in _held(data)]
    layers += boundary(exact, 1.1) if exact else []
    return Panel(layers, _axis(data, along, scene), _axis(data, upwards, scene), height=2.8)


def _jump_edges(
    data: xr.Dataset, x: Array, y: Array, z: Array, band: float
) -> list[list[tuple[float, float]]]:
    """The edges between neighbouring sets across which the bandwidth jumps, as pieces of lines."""
    counts, across, up, edges = _counts(data), _edges(x), _edges(y), []
    for i, row in enumerate(z):
        edges += [
            [(across[j], up[i]), (across[j], up[i + 1])] for j in _jumps(row, counts[:, i], band)
        ]
    for j, column in enumerate(z.T):
        edges += [
            [(across[j], up[i]), (across[j + 1], up[i])]
            for i in _jumps(column, counts[:, :, j], band)
        ]
    return edges


@dataclass(frozen=True)
class _Field(Layer):
    """A map of a frequency, and its contour lines."""

    x: Array
    y: Array
    z: Array
    band: tuple[float, float]
    unit: Unit

    def draw(self, on: On) -> list[Artist]:
        x, y, size = on.x.of(self.x), on.y.of(self.y), float(self.unit.size)
        z, (low, high) = self.z / size, (end / size for end in self.band)
        # Pixels in files of vectors: a shape for each of up to a million cells would be a huge
        # file.
        style: dict[str, Any] = {
            "cmap": _MAP,
            "vmin": low,
            "vmax": high,
            "shading": "nearest",
            "rasterized": True,
        }
        made: list[Artist] = [on.ax.pcolormesh(x, y, z, **style)]
        levels = _round_levels(z, high)
        if len(levels):
            lines = on.ax.contour(x, y, z, levels=levels, colors=pen.INK, linewidths=0.7)
            on.ax.clabel(lines, fontsize=small(on.ax), fmt=number, inline_spacing=3)
            made.append(lines)
        return made

    def keys(self, _on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, handle(pen.INK, pen.SOLID, "", 0.7))]


def _round_levels(z: Array, high: float) -> Array:
    """A few round values between the least and the largest bandwidth, those of the whole band left
    out."""
    inside = z[np.isfinite(z) & (z < high)]
    if not len(inside) or inside.min() == inside.max():
        return np.zeros(0)
    levels: Array = np.asarray(
        MaxNLocator(_LEVELS, steps=[1, 2, 2.5, 5, 10]).tick_values(inside.min(), inside.max())
    )
    # A level at the rim of the plateau of the whole band would wander along it: it has a hatch
    # instead.
    kept: Array = levels[(levels > inside.min()) & (levels < min(inside.max(), 0.999 * high))]
    return kept


@dataclass(frozen=True)
class _Jumps(Layer):
    """Edges across which a map jumps."""

    edges: Sequence[Sequence[tuple[float, float]]]

    def draw(self, on: On) -> list[Artist]:
        lines = [
            np.column_stack([on.x.of([a for a, _ in edge]), on.y.of([b for _, b in edge])])
            for edge in self.edges
        ]
        made = LineCollection(
            lines, colors=pen.GREY, linewidths=1.8, alpha=0.8, capstyle="projecting"
        )
        return [on.ax.add_collection(made)]

    def keys(self, _on: On, _made: list[Artist]) -> list[tuple[str, Artist]]:
        return [(self.label, handle(pen.GREY, pen.SOLID, "", 1.8, alpha=0.8))]


@dataclass(frozen=True)
class _Plateau(Layer):
    """What contour lines do not tell, hatched unless it is everywhere."""

    x: Array
    y: Array
    where: Any
    hatch: str

    def draw(self, on: On) -> list[Artist]:
        if not self.where.all():
            _hatched(on, (self.x, self.y), self.where, self.hatch, pen.GREY)
        return [Patch(facecolor="white", edgecolor=pen.GREY, hatch=self.hatch, linewidth=0.4)]


# The chart of a sweep.


def chart(found: Swept) -> Panel:
    """The chart of a sweep over one parameter, or over two."""
    return (
        curves(found.data, found.scene)
        if len(found.data.bandwidth.dims) == 1
        else plane(found.data, None, found.scene)
    )


def swept(found: Swept, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """The chart of a sweep; where that takes moments, with the exact boundary of the transparent
    region on a map."""
    return sweep_figure(found.data, found.scene, style)


def sweep_figure(
    data: xr.Dataset, scene: Scene | None = None, style: pen.FigureStyle = pen.SCREEN
) -> Figure:
    """The chart of a sweep over one or two parameters, one column (3.4 in) wide."""
    if len(data.bandwidth.dims) == 1:
        return sheet(curves(data, scene), style=style)
    exact = _exact(data, scene) if scene is not None and is_quick(scene) else None
    return sheet(plane(data, exact, scene), style=style)


def _exact(data: xr.Dataset, scene: Scene) -> DesignMap:
    """Return the plane of a sweep by exact slices, over the ranges that were swept."""
    upwards, along = _dimensions(data, 2)
    ranges = [
        tuple(float(x) for x in (data[path].min(), data[path].max())) for path in (along, upwards)
    ]
    return design_map(
        scene, (along, upwards), [(low, high) for low, high in ranges], slices=_SLICES
    )


SWEEP = Drawings[Swept]({"chart": chart}, {"sweep": swept})
