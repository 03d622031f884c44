"""Design charts: first crossings and bandwidth over one parameter, or a map of the bandwidth over two.

Each ``draw_`` function draws on the axes that it is given, so that other curves (exact boundaries, a design) can be laid over.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from haptisym.errors import SceneError
from haptisym.figures.style import BLUE, GREY, INK, RED, SMALL, TEXT, dress, handle, legend, one_column, save_as
from haptisym.numeric.values import Array
from haptisym.quantities import unit_text
from haptisym.requirement.designmap import DesignMap, design_map
from haptisym.requirement.figures import draw_boundary
from haptisym.requirement.question import is_quick
from haptisym.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

_SOLID, _DASHED = "-", (0, (4, 1.6))
_MOST_PIXELS = 1200  # along an axis; a chart in print shows no more
_LEVELS, _SLICES = 7, 31
_MAP = LinearSegmentedColormap.from_list("bandwidth", ["#5b7fa6", "#a9c0d6", "#f4f7fa"])  # monotone in grey, too


def draw_curves(ax: Axes, data: xr.Dataset) -> None:
    """First crossings of both parts and the bandwidth over the one parameter of a sweep."""
    [path] = _dimensions(data, 1)
    x, data = data[path].values, data.load()
    high = float(data.attrs["band"][1])
    ax.axhline(high, color=GREY, linewidth=0.4, zorder=0)
    ax.plot(x, data.bandwidth.values, color=GREY, linewidth=3.2, alpha=0.5, solid_capstyle="butt")
    for part, color, style in (("real", BLUE, _SOLID), ("imag", RED, _DASHED)):
        crossing = _broken(x, data[f"first_crossing_{part}"].values, data[f"crossings_{part}"].values, high)
        ax.plot(*crossing, color=color, linewidth=1.1, linestyle=style)
    ax.set(xlim=(x.min(), x.max()), ylim=(float(data.attrs["band"][0]), high * 1.04))
    dress(ax)
    _scale(ax, "x", x)
    ax.set_xlabel(_name(data, path), fontsize=TEXT)
    ax.set_ylabel(r"$\omega$ (rad/s)", fontsize=TEXT)
    handles = [
        handle(BLUE, _SOLID, "real part crosses"),
        handle(RED, _DASHED, "imaginary part crosses"),
        handle(GREY, _SOLID, "bandwidth", 3.2, alpha=0.5),
    ]
    legend(ax, handles)


def _broken(x: Array, crossing: Array, counts: Any, high: float) -> tuple[Array, Array]:
    """The curve without a stroke where it jumps because a pair of crossings comes or goes."""
    jumps = ((np.diff(counts) != 0) & (np.abs(np.diff(crossing)) > 0.02 * high)).nonzero()[0] + 1
    return np.insert(x, jumps, np.nan), np.insert(crossing, jumps, np.nan)


def draw_map(ax: Axes, data: xr.Dataset, exact: DesignMap | None = None) -> None:
    """The bandwidth over the two parameters of a sweep, the first upwards: contour lines in rad/s on a quiet map.

    Hatched where the display is not transparent at the band's low end; no shade is darker than the ink of the lines.
    ``exact`` : the same plane by exact slices, whose boundary of the transparent region is drawn.
    """
    upwards, along = _dimensions(data, 2)
    data = _thinned(data, (upwards, along)).sortby([upwards, along])
    x, y, z = data[along].values, data[upwards].values, data.bandwidth.values
    high = float(data.attrs["band"][1])
    _scale_axes(ax, x, y)
    ax.pcolormesh(x, y, z, cmap=_MAP, vmin=float(data.attrs["band"][0]), vmax=high, shading="nearest", rasterized=True)
    levels = _round_levels(z, high)
    if len(levels):
        lines = ax.contour(x, y, z, levels=levels, colors=INK, linewidths=0.7)
        ax.clabel(lines, fontsize=SMALL, fmt="%g", inline_spacing=3)
    ax.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    ax.set_xlabel(_name(data, along), fontsize=TEXT)
    ax.set_ylabel(_name(data, upwards), fontsize=TEXT)
    boundary = draw_boundary(exact, ax, 1.6) if exact else []
    legend(ax, [handle(INK, _SOLID, "bandwidth (rad/s)", 0.7), *_plateaus(ax, x, y, z, high), *boundary])


def _plateaus(ax: Axes, x: Array, y: Array, z: Array, high: float) -> list[Any]:
    """What contour lines do not tell: nowhere transparent, and transparent up to the end of the band."""
    handles = []
    for where, hatch, label in ((np.isnan(z), "xxxx", "none"), (z >= high, "....", f"whole band, {high:.4g}")):
        if where.any() and not where.all():
            _hatched(ax, x, y, where, hatch)
        if where.any():
            handles.append(Patch(facecolor="white", edgecolor=GREY, hatch=hatch, linewidth=0.4, label=label))
    return handles


def _hatched(ax: Axes, x: Array, y: Array, where: Any, hatch: str) -> None:
    found = ax.contourf(x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[hatch])
    found.set(edgecolor=GREY, linewidth=0.0)


def save_sweep_figure(data: xr.Dataset, file: str | Path, scene: Scene | None = None) -> Path:
    """The chart of a sweep over one or two parameters, as the file's ending says (.svg, .pdf, .png).

    ``scene`` : what was swept; where that takes moments, the exact boundary of the transparent region is drawn on a map.
    """
    return save_as(sweep_figure(data, scene), file)


def sweep_figure(data: xr.Dataset, scene: Scene | None = None) -> Figure:
    """The chart of a sweep over one or two parameters, one column (3.4 in) wide."""
    if len(data.bandwidth.dims) == 1:
        return one_column(2.2, lambda ax: draw_curves(ax, data))
    exact = _exact(data, scene) if scene is not None and is_quick(scene) else None
    return one_column(2.8, lambda ax: draw_map(ax, data, exact))


def _exact(data: xr.Dataset, scene: Scene) -> DesignMap:
    upwards, along = _dimensions(data, 2)
    ranges = [tuple(float(x) for x in (data[path].min(), data[path].max())) for path in (along, upwards)]
    return design_map(scene, (along, upwards), [(low, high) for low, high in ranges], slices=_SLICES)


def _dimensions(data: xr.Dataset, count: int) -> list[str]:
    found = [str(name) for name in data.bandwidth.dims]
    if len(found) != count or min(data.bandwidth.shape) < 2:
        raise SceneError(
            f"a chart shows one or two parameters with at least two values each, not {dict(data.bandwidth.sizes)}: "
            "choose with Dataset.sel, or sweep fewer"
        )
    return found


def _thinned(data: xr.Dataset, names: tuple[str, str]) -> xr.Dataset:
    steps = {name: slice(None, None, -(-data.sizes[name] // _MOST_PIXELS)) for name in names}
    return data[["bandwidth"]].isel(steps).load()


def _name(data: xr.Dataset, path: str) -> str:
    unit = data[path].attrs.get("units", "")
    return f"{path} ({unit_text(unit)})" if unit not in ("", "1") else path


def _is_logarithmic(x: Array) -> bool:
    """Whether values are spaced by equal ratios rather than evenly."""
    if len(x) < 3 or x.min() <= 0:
        return False
    even, ratio = np.diff(x), np.diff(np.log(x))
    return bool(np.ptp(ratio) < 1e-6 * abs(ratio).max() and np.ptp(even) > 1e-6 * abs(even).max())


def _scale(ax: Axes, which: str, values: Array) -> None:
    if not _is_logarithmic(values):
        return
    getattr(ax, f"set_{which}scale")("log")
    axis = getattr(ax, f"{which}axis")
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_minor_locator(NullLocator())
    plain = FuncFormatter(lambda value, _: f"{value:g}")
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
