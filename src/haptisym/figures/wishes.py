"""One map of several things asked: where nothing is noticed, what is stable in a hand, both, and the classical lines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures.between import Join, draw_bands, draw_common, draw_left
from haptisym.figures.designmap import PlaneBox, left_open, scales_of, window_of
from haptisym.figures.require import HATCH, label_of, limits_of
from haptisym.figures.scales import Scale
from haptisym.figures.style import BLUE, DASHED, DOTTED, GREY, INK, RED, SHADE, TEXT, dress, entry, legend, limit
from haptisym.programs.values import Array
from haptisym.verbs.require.classical import Line
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.required import Requirement

_COLORS = {"transparent": BLUE, "stable": RED, "passive": "#d0701f"}
_NAMES = {"transparent": "transparent", "stable": "stable", "passive": "every passive hand"}
_STROKES: Sequence[Any] = (DASHED, DOTTED, (0, (6, 1.5, 1, 1.5)))
_GRID = 160
Rows = Sequence[tuple[float, Requirement]]
"""The slices of one set, and where they are."""


def draw_wishes(ax: Axes, found: DesignMap) -> list[Artist]:
    """What was asked, each set along its exact slices in its own colour, and what they have in common on a grey ground.

    What joins the slices is interpolation. Of what is transparent, and mostly of what is stable, a band in which its boundary
    lies is proven; of other sets one about the lines is as wide as they may be off, as estimated, and what lies between slices
    that differ in kind is hatched, as is what slices leave undecided. The ground is proven where all that is asked is, and
    interpolation elsewhere. Classical bounds are thin lines with their names. Returns what the legend tells.
    """
    scales, ((a, b), (low, high)) = scales_of(found), window_of(found)
    shown, joins, boxes = _ground(ax, found, scales), list[Join](), list(left_open(found))
    for name, look, rows in _sets(found):
        shown += _outlined(ax, rows, scales, (low, high), look)
        if not _is_proven(found, name):
            joins += _joins(rows, (low, high))
            boxes += _unlike(rows, (low, high))
    shown += [
        *draw_left(ax, found, scales),
        *draw_bands(ax, found, joins, scales),
        _strokes(ax, found, scales, (low, high)),
        *_hatched(ax, boxes, scales),
    ]
    for line, stroke in zip(found.lines, _STROKES, strict=False):
        shown += _classical(ax, found, line, stroke, scales)
    limit(ax, (scales[0].of(a), scales[0].of(b)), (scales[1].of(low), scales[1].of(high)))
    dress(ax)
    ax.set_xlabel(label_of(found.free[0], scales[0]), fontsize=TEXT)
    ax.set_ylabel(label_of(found.free[1], scales[1]), fontsize=TEXT)
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


def _neighbours(
    rows: Rows, window: tuple[float, float]
) -> Iterator[tuple[tuple[float, float], tuple[float, float], tuple[float, float]]]:
    """Between slices with as many intervals: where they are, and both ends of the intervals that belong together."""
    for (x, one), (y, other) in pairwise(rows):
        if len(one.feasible) == len(other.feasible):
            for left, right in zip(one.feasible, other.feasible, strict=True):
                (a, b), (c, d) = limits_of(left, *window), limits_of(right, *window)
                yield (x, y), (a, c), (b, d)


def _unlike(rows: Rows, window: tuple[float, float]) -> Iterator[PlaneBox]:
    """The intervals of neighbouring slices that have not as many, with nothing open on either: where they end is not known."""
    for (x, one), (y, other) in pairwise(rows):
        if len(one.feasible) != len(other.feasible) and not (one.undecided or other.undecided):
            for span in one.feasible + other.feasible:
                yield (x, y), limits_of(span, *window)


def _joins(rows: Rows, window: tuple[float, float]) -> Iterator[Join]:
    """The lines that join the ends of neighbouring slices, but for those along the ends of the range."""
    for at, *pairs in _neighbours(rows, window):
        yield from ((at, pair) for pair in pairs if not all(y in window for y in pair))


def _ground(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    """Proven, where all that is asked is; else interpolated between slices."""
    if all(_is_proven(found, name) for name in found.that):
        return draw_common(ax, found, scales, f"{_whole(found)}, proven")
    _, window = window_of(found)
    for at, below, above in _neighbours([(float(x.at), x.requirement) for x in found.slices], window):
        x, bottom, top = scales[0].of(np.array(at)), scales[1].of(np.array(below)), scales[1].of(np.array(above))
        ax.fill_between(x, bottom, top, color=SHADE, linewidth=0, antialiased=False, zorder=0)
    return [Patch(facecolor=SHADE, label=f"{_whole(found)}, interpolated")]


def _whole(found: DesignMap) -> str:
    return "all that is asked" if len(found.that) > 1 else "this set"


def _strokes(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale], window: tuple[float, float]) -> Artist:
    rows = [(scales[0].of(float(x.at)), x.requirement) for x in found.slices]
    lines = [[(x, scales[1].of(y)) for y in limits_of(span, *window)] for x, r in rows for span in r.feasible]
    strokes = LineCollection(lines, colors=GREY, linewidths=0.6, zorder=1, label=f"{_whole(found)}, exact slices")
    ax.add_collection(strokes)
    return strokes


def _outlined(
    ax: Axes,
    rows: Rows,
    scales: tuple[Scale, Scale],
    window: tuple[float, float],
    look: tuple[str, str],
) -> list[Artist]:
    """The ends of one set, in its colour and by its name: lines that interpolate, and a dot where each slice has proven one."""
    (color, name), dots, joins = look, list[tuple[Any, Any]](), list(_joins(rows, window))
    for at, pair in joins:
        ax.plot(scales[0].of(np.array(at)), scales[1].of(np.array(pair)), color=color, linewidth=0.9, zorder=2)
    for x, r in rows:
        dots += [(scales[0].of(x), scales[1].of(float(e.value))) for e in r.ends if e.value is not None]
    if dots:
        ax.plot(*zip(*dots, strict=True), color=color, linestyle="none", marker="o", markersize=1.8, zorder=3)
    if not (dots or joins):
        return [entry(f"{name}: ends on no slice")]
    return [Line2D([], [], color=color, linewidth=0.9, marker="o", markersize=2.2, label=name)]


def _paler(i: int, count: int) -> str:
    """The colour of what is transparent, paler for each further threshold."""
    r, g, b = (x + (1 - x) * (0.25 + 0.4 * (i + 1) / count) for x in to_rgb(_COLORS["transparent"]))
    return to_hex((r, g, b))


def _hatched(ax: Axes, boxes: Iterable[PlaneBox], scales: tuple[Scale, Scale]) -> list[Artist]:
    """What slices leave open, and what lies between slices that differ in kind."""
    boxes = list(boxes)
    for (a, b), (c, d) in boxes:
        x, y = scales[0].of(np.array([a, b])), scales[1].of(np.array([c, d]))
        ax.fill_between(x, [y[0]] * 2, [y[1]] * 2, zorder=1, **HATCH)
    return [Patch(label="undecided", **HATCH)] if boxes else []


def _classical(ax: Axes, found: DesignMap, line: Line, stroke: Any, scales: tuple[Scale, Scale]) -> list[Artist]:
    """Where a classical bound is met, by its sign on a grid: drawn, not proven."""
    if line.where:
        return _at_an_edge(ax, found, line, scales)
    (a, b), (low, high) = window_of(found)
    x, y = np.linspace(a, b, _GRID), np.linspace(low, high, _GRID)
    one, other = (free.path for free in found.free)
    with np.errstate(all="ignore"):
        excess: Array = np.array([[_finite(line, {one: u, other: v}) for u in x] for v in y])
    if not (np.nanmin(excess) < 0 < np.nanmax(excess)):
        return []
    ax.contour(
        scales[0].of(x), scales[1].of(y), excess, [0.0], colors=INK, linestyles=[stroke], linewidths=0.9, zorder=2
    )
    return [Line2D([], [], color=INK, linestyle=stroke, linewidth=0.9, label=line.name)]


def _at_an_edge(ax: Axes, found: DesignMap, line: Line, scales: tuple[Scale, Scale]) -> list[Artist]:
    """A bound that is defined at one value of one parameter alone: a mark where it is met there, if the map reaches there."""
    [(path, value)] = line.where
    paths, windows = [free.path for free in found.free], window_of(found)
    i = paths.index(path)
    (low, high), (start, end) = windows[i], windows[1 - i]
    excess = [line.excess({path: value, paths[1 - i]: y}) for y in (start, end)]
    if not (low <= value <= high and excess[0] < 0 < excess[1]):
        return []
    met = start - excess[0]  # the excess is the stiffness less a number
    point = (value, met) if i == 0 else (met, value)
    look: dict[str, Any] = {"color": INK, "linestyle": "none", "marker": "D", "markersize": 4, "fillstyle": "none"}
    label = f"{line.name} (b = {value:g})"
    ax.plot(*(scale.of(np.array([x])) for scale, x in zip(scales, point, strict=True)), clip_on=False, zorder=4, **look)
    return [Line2D([], [], label=label, **look)]


def _finite(line: Line, at: dict[str, float]) -> float:
    try:
        return float(line.excess(at))
    except ZeroDivisionError:
        return float("nan")
