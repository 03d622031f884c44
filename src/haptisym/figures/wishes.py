"""One map of several things asked: where nothing is noticed, what is stable in a hand, both, and the classical lines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.designmap import draw_map
from haptisym.figures.mapplane import Join, MapPlane, Rows, draw_bands, draw_common, draw_left, neighbours
from haptisym.figures.sheet import one_column
from haptisym.figures.style import dots, entry, legend
from haptisym.programs.values import Array
from haptisym.verbs.require.classical import Line
from haptisym.verbs.require.designmap import DesignMap

_COLORS = {"transparent": pen.BLUE, "stable": pen.RED, "passive": "#d0701f"}
_NAMES = {"transparent": "transparent", "stable": "stable", "passive": "every passive hand"}
_STROKES: Sequence[Any] = (pen.DASHED, pen.DOTTED, (0, (6, 1.5, 1, 1.5)))
_GRID = 160


def map_figure(found: DesignMap) -> Figure:
    """A map of two parameters; of several things or thresholds asked, each set for itself and what they have in common."""
    if found.that != ("transparent",) or found.thresholds:
        return one_column(2.8, lambda ax: draw_wishes(ax, found))
    return one_column(2.6, lambda ax: draw_map(ax, found))


def draw_wishes(ax: Axes, found: DesignMap) -> list[Artist]:
    """What was asked, each set along its exact slices in its own colour, and what they have in common on a grey ground.

    What joins the slices is interpolation. Of what is transparent, and mostly of what is stable, a band in which its boundary
    lies is proven; of other sets one about the lines is as wide as they may be off, as estimated, and what lies between slices
    that differ in kind is hatched, as is what slices leave undecided. The ground is proven where all that is asked is, and
    interpolation elsewhere. Classical bounds are thin lines with their names. Returns what the legend tells.
    """
    plane = MapPlane(found)
    shown, joins, boxes = _ground(ax, plane), list[Join](), list(plane.left_open())
    for name, look, rows in _sets(found):
        shown += _outlined(ax, plane, rows, look)
        if not _is_proven(found, name):
            joins += _joins(plane, rows)
            boxes += plane.unlike(rows, decided=True)
    strokes = plane.strokes(ax, pen.GREY, 0.6, f"{_whole(found)}, exact slices")
    shown += [*draw_left(ax, plane), *draw_bands(ax, plane, joins), strokes, *plane.hatch(ax, boxes)]
    for line, stroke in zip(found.lines, _STROKES, strict=False):
        shown += _classical(ax, plane, line, stroke)
    plane.frame(ax)
    legend(ax, shown)
    return shown


def _sets(found: DesignMap) -> Iterator[tuple[str, tuple[str, str], Rows]]:
    """Each set that is outlined: what it is asked for, its colour and name, and its slices."""
    for i, name in enumerate(found.that):
        rows = [(float(x.at), (x.apart or (x.requirement,))[i]) for x in found.slices]
        yield name, (_COLORS[name], _NAMES[name]), rows
    for i, jnd in enumerate(found.thresholds):
        look = _paler(i, len(found.thresholds)), f"{_NAMES['transparent']}, c = {float(100 * jnd):.6g} %"
        yield "transparent", look, [(float(x.at), x.contours[i]) for x in found.slices]


def _is_proven(found: DesignMap, name: str) -> bool:
    """Whether more than slices of a set is proven."""
    return any(x.of == name for x in found.proofs)


def _joins(plane: MapPlane, rows: Rows) -> Iterator[Join]:
    """The lines that join the ends of neighbouring slices, but for those along the ends of the range."""
    for at, left, right in neighbours(rows):
        pairs = zip(plane.ends(left), plane.ends(right), strict=True)
        yield from ((at, pair) for pair in pairs if not all(y in plane.window[1] for y in pair))


def _ground(ax: Axes, plane: MapPlane) -> list[Artist]:
    """Proven, where all that is asked is; else interpolated between slices."""
    whole = _whole(plane.found)
    if all(_is_proven(plane.found, name) for name in plane.found.that):
        return draw_common(ax, plane, f"{whole}, proven")
    plane.ground(ax)
    return [Patch(facecolor=pen.SHADE, label=f"{whole}, interpolated")]


def _whole(found: DesignMap) -> str:
    return "all that is asked" if len(found.that) > 1 else "this set"


def _outlined(ax: Axes, plane: MapPlane, rows: Rows, look: tuple[str, str]) -> list[Artist]:
    """The ends of one set, in its colour and by its name: lines that interpolate, and a dot where each slice has proven one."""
    (color, name), joins = look, list(_joins(plane, rows))
    for at, pair in joins:
        ax.plot(plane.x(at), plane.y(pair), color=color, linewidth=0.9, zorder=2)
    ends = [(x, float(e.value)) for x, r in rows for e in r.ends if e.value is not None]
    if ends:
        x, y = zip(*ends, strict=True)
        ax.plot(plane.x(x), plane.y(y), color=color, zorder=3, **dots(1.8))
    if not (ends or joins):
        return [entry(f"{name}: ends on no slice")]
    return [Line2D([], [], color=color, linewidth=0.9, marker="o", markersize=2.2, label=name)]


def _paler(i: int, count: int) -> str:
    """The colour of what is transparent, paler for each further threshold."""
    r, g, b = (x + (1 - x) * (0.25 + 0.4 * (i + 1) / count) for x in to_rgb(_COLORS["transparent"]))
    return to_hex((r, g, b))


def _classical(ax: Axes, plane: MapPlane, line: Line, stroke: Any) -> list[Artist]:
    """Where a classical bound is met, by its sign on a grid: drawn, not proven."""
    if line.where:
        return _at_an_edge(ax, plane, line)
    x, y = (np.linspace(*ends, _GRID) for ends in plane.window)
    one, other = (free.path for free in plane.found.free)
    with np.errstate(all="ignore"):
        excess: Array = np.array([[_finite(line, {one: u, other: v}) for u in x] for v in y])
    if not (np.nanmin(excess) < 0 < np.nanmax(excess)):
        return []
    ax.contour(plane.x(x), plane.y(y), excess, [0.0], colors=pen.INK, linestyles=[stroke], linewidths=0.9, zorder=2)
    return [Line2D([], [], color=pen.INK, linestyle=stroke, linewidth=0.9, label=line.name)]


def _at_an_edge(ax: Axes, plane: MapPlane, line: Line) -> list[Artist]:
    """A bound that is defined at one value of one parameter alone: a mark where it is met there, if the map reaches there."""
    [(path, value)] = line.where
    paths, windows = [free.path for free in plane.found.free], plane.window
    i = paths.index(path)
    (low, high), (start, end) = windows[i], windows[1 - i]
    excess = [line.excess({path: value, paths[1 - i]: y}) for y in (start, end)]
    if not (low <= value <= high and excess[0] < 0 < excess[1]):
        return []
    met = start - excess[0]  # the excess is the stiffness less a number
    x, y = (value, met) if i == 0 else (met, value)
    look = dots(4, "D", color=pen.INK, fillstyle="none")
    label = f"{line.name} (b = {value:g})"
    ax.plot(plane.x([x]), plane.y([y]), clip_on=False, zorder=4, **look)
    return [Line2D([], [], label=label, **look)]


def _finite(line: Line, at: dict[str, float]) -> float:
    try:
        return float(line.excess(at))
    except ZeroDivisionError:
        return float("nan")
