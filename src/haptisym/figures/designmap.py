"""Figures of design maps: the transparent region in two parameters."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures.between import Join, draw_bands, draw_kept, draw_left
from haptisym.figures.require import HATCH, label_of, limits_of, look_of, parameter_scale
from haptisym.figures.scales import Scale
from haptisym.figures.style import GREY, SHADE, TEXT, Look, dress, legend, limit, write_note
from haptisym.judge.criteria import Criterion
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Binding, Kind, Span
from haptisym.verbs.require.slices import Slice

_FILL = {Kind.EDGE: "full", Kind.START: "none", Kind.TOUCH: "bottom"}


def draw_map(ax: Axes, found: DesignMap, *, color: str | None = None, label: str = "") -> list[Artist]:
    """The transparent region: each exact slice as an upright stroke with marks where it ends, by what binds there.

    Where more than the slices is proven, the ground is, and a band in which the boundary lies; lines that join slices are
    interpolation. Elsewhere the ground is too, and the legend says so; a band about lines is as wide as they may be off, as
    estimated, and what lies between slices that differ in kind is hatched, as is what slices leave undecided. Ticks on the
    lower axis: where the slices are.
    ``color``, ``label`` : of the scene; of a further one on the same axes no ground is drawn. Returns the strokes and the marks.

    >>> from matplotlib.figure import Figure
    >>> from haptisym import design_map, load_scene
    >>> found = design_map(load_scene("fu2019"), ["omega_n", "zeta"], [(60, 200), (0.1, 1)], slices=5)
    >>> strokes, *marks = draw_map(Figure().add_subplot(), found)
    >>> [mark.get_label() for mark in marks]
    ['imaginary part, band-edge']
    """
    look, scales = Look.on(ax, "exact slices", color, label), scales_of(found)
    (a, b), (low, high) = window_of(found)
    strokes = _draw_slices(ax, found, look, scales)
    ground = [] if look.number else _draw_ground(ax, found, scales)
    marks = draw_boundary(ax, found, color=None if look.plain else look.color, suffix=look.suffix)
    bands = [] if look.number else _draw_bands(ax, found, scales)
    open_ones = _draw_undecided(ax, found, scales, look)
    limit(ax, (scales[0].of(a), scales[0].of(b)), (scales[1].of(low), scales[1].of(high)), number=look.number)
    dress(ax)
    ax.set_xlabel(label_of(found.free[0], scales[0]), fontsize=TEXT)
    ax.set_ylabel(label_of(found.free[1], scales[1]), fontsize=TEXT)
    some = [strokes] if strokes.get_segments() else []
    legend(ax, [*some, *ground, *(x for _, x in marks), *bands, *open_ones, *_tick_entry(look)])
    if not any(x.requirement.feasible for x in found.slices):
        word = "transparent nowhere" if found.certified else "nowhere proven transparent"
        write_note(ax, f"{word}: on none of {len(found.slices)} exact slices{look.suffix}")
    return [strokes, *(x for x, _ in marks)]


_STROKES = "transparent on the slice"


def scales_of(found: DesignMap) -> tuple[Scale, Scale]:
    """The units of both parameters' axes."""
    one, other = (parameter_scale(x, (*pair, x.value)) for x, pair in zip(found.free, found.ranges, strict=True))
    return one, other


def _draw_slices(ax: Axes, found: DesignMap, look: Look, scales: tuple[Scale, Scale]) -> LineCollection:
    """An upright stroke along each interval of each slice, and a tick on the axis for each slice."""
    _, window = window_of(found)
    color = GREY if look.plain else look.color
    rows = [(scales[0].of(float(x.at)), x.requirement) for x in found.slices]
    lines = [[(x, scales[1].of(y)) for y in limits_of(span, *window)] for x, r in rows for span in r.feasible]
    label = f"{_STROKES}{look.suffix}" if lines else ""
    strokes = LineCollection(lines, colors=color, linewidths=0.7, zorder=1, label=label)
    ax.add_collection(strokes)
    ax.plot([x for x, _ in rows], [0] * len(rows), transform=ax.get_xaxis_transform(), clip_on=False, **_tick(color))
    return strokes


def _tick(color: str) -> dict[str, Any]:
    return {"color": color, "linestyle": "none", "marker": 3, "markersize": 2.5}


def _tick_entry(look: Look) -> list[Artist]:
    color = GREY if look.plain else look.color
    return [Line2D([], [], label=f"exact slices{look.suffix}", **{**_tick(color), "marker": "|", "markersize": 5})]


def _draw_bands(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    if found.proofs:
        return draw_left(ax, found, scales)
    return draw_bands(ax, found, [join for join, _ in _joins(found)], scales)


def _draw_ground(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    """A light ground: what is proven, or else what lies between slices of one kind, which proves nothing."""
    if found.proofs:
        return draw_kept(ax, found, scales)
    _, window = window_of(found)
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (limits_of(span, *window) for span in (left, right))
        x, bottom, top = (
            scale.of(np.array(pair))
            for scale, pair in zip((scales[0], *[scales[1]] * 2), (at, (y0, z0), (y1, z1)), strict=True)
        )
        ax.fill_between(x, bottom, top, color=SHADE, linewidth=0, antialiased=False, zorder=0)
    return [Patch(facecolor=SHADE, label="between slices: interpolated")] if any(True for _ in _pieces(found)) else []


def draw_boundary(
    ax: Axes, found: DesignMap, *, color: str | None = None, suffix: str = "", width: float = 0.6
) -> list[tuple[Line2D, Line2D]]:
    """The ends of all slices, marked by what binds there, joined by lines that interpolate; marks, and entries for a legend.

    ``suffix`` : what the entries end with; ``width`` : of the lines, points.
    """
    scales = scales_of(found)
    drawn = []
    for (at, ends), binding in _joins(found):
        look = look_of(binding.criterion)
        style: dict[str, Any] = {"color": color or look.color, "linestyle": look.stroke}
        ax.plot(scales[0].of(np.array(at)), scales[1].of(np.array(ends)), linewidth=width, zorder=2, **style)
    for (criterion, kind), places in _ends(found).items():
        points = [(scales[0].of(x), scales[1].of(y)) for x, y in places]
        look = look_of(criterion)
        shown = color or look.color
        mark: dict[str, Any] = {
            "marker": look.marker, "markersize": 2.8, "markeredgewidth": 0.6, "fillstyle": _FILL[kind],
            "markerfacecoloralt": "white", "label": f"{criterion.words}, {kind.value}{suffix}",
        }  # fmt: skip
        [marks] = ax.plot(*zip(*points, strict=True), color=shown, linestyle="none", zorder=3, **mark)
        drawn.append((marks, Line2D([], [], color=shown, linestyle=look.stroke, linewidth=width, **mark)))
    return drawn


def _joins(found: DesignMap) -> Iterator[tuple[Join, Binding]]:
    """The lines that join the ends of neighbouring slices, and what binds along each."""
    _, window = window_of(found)
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (limits_of(span, *window) for span in (left, right))
        for y, z, one, other in ((y0, z0, left.low, right.low), (y1, z1, left.high, right.high)):
            binding = _of(one.bindings, other.bindings)
            if binding is not None:
                yield (at, (y, z)), binding


def _ends(found: DesignMap) -> dict[tuple[Criterion, Kind], list[tuple[float, float]]]:
    """The exact ends of all slices, by the first condition that binds there."""
    places: dict[tuple[Criterion, Kind], list[tuple[float, float]]] = {}
    for x in found.slices:
        for end in x.requirement.ends:
            if end.bindings and end.value is not None:
                key = (end.bindings[0].criterion, end.bindings[0].kind)
                places.setdefault(key, []).append((float(x.at), float(end.value)))
    return places


def _draw_undecided(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale], look: Look) -> list[Artist]:
    """Hatched: what a slice leaves open, halfway to its neighbours, and what lies between slices that differ in kind."""
    boxes = [*left_open(found), *([] if found.proofs else _between(found))]
    for (a, b), (c, d) in boxes:
        x, y = scales[0].of(np.array([a, b])), scales[1].of(np.array([c, d]))
        ax.fill_between(x, [y[0]] * 2, [y[1]] * 2, zorder=1, **HATCH)
    return [Patch(label=f"undecided{look.suffix}", **HATCH)] if boxes else []


PlaneBox = tuple[tuple[float, float], tuple[float, float]]


def left_open(found: DesignMap) -> Iterator[PlaneBox]:
    """What slices leave open, halfway to their neighbours."""
    _, (low, high) = window_of(found)
    at = [float(x.at) for x in found.slices]
    middles = [at[0], *((a + b) / 2 for a, b in pairwise(at)), at[-1]] if at else []
    for x, around in zip(found.slices, pairwise(middles), strict=True):
        for start, end in x.requirement.undecided:
            yield around, (low if start is None else float(start), high if end is None else float(end))


def _between(found: DesignMap) -> Iterator[PlaneBox]:
    """The intervals of two neighbouring slices that have not as many."""
    _, window = window_of(found)
    for one, other in pairwise(found.slices):
        spans = one.requirement.feasible + other.requirement.feasible
        if not _alike(one, other):
            for span in spans:
                yield (float(one.at), float(other.at)), limits_of(span, *window)


def _alike(one: Slice, other: Slice) -> bool:
    return len(one.requirement.feasible) == len(other.requirement.feasible)


def window_of(found: DesignMap) -> tuple[tuple[float, float], tuple[float, float]]:
    """From where to where both axes go."""
    (a, b), (low, high) = ((float(x) for x in pair) for pair in found.ranges)
    return (a, b), (low, high)


def _pieces(found: DesignMap) -> Iterator[tuple[tuple[float, float], Span, Span]]:
    """Between neighbouring slices with as many intervals: where they are, and the intervals that belong together."""
    for one, other in pairwise(found.slices):
        if _alike(one, other):
            spans = zip(one.requirement.feasible, other.requirement.feasible, strict=True)
            yield from (((float(one.at), float(other.at)), *pair) for pair in spans)


def _of(left: tuple[Binding, ...], right: tuple[Binding, ...]) -> Binding | None:
    """What binds between two slices: what binds at one of them; nothing where the range itself ends at both."""
    found = [*left, *right] if left and right else []
    return found[0] if found else None
