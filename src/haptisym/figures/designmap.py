"""Figures of design maps: the plane, its slices, and what is asked together.

The plane of a map: its axes, its slices, what lies between them as interpolated, estimated or proven, and what is open.

Figures of design maps: the transparent region in two parameters.

One map of several things asked: where nothing is noticed, what is stable in a hand, both, and the classical lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.require import HATCH, label_of, limits_of, look_of, parameter_scale
from haptisym.figures.sheet import one_column
from haptisym.figures.style import Look, Scale, dots, dress, entry, legend, limit, rectangles, write_note
from haptisym.judge.crossings import Criterion
from haptisym.programs.values import Array
from haptisym.verbs.require.classical import Line
from haptisym.verbs.require.designmap import DesignMap, common
from haptisym.verbs.require.feasible import Binding, Kind, Span
from haptisym.verbs.require.required import Requirement

Rows = Sequence[tuple[float, Requirement]]
"""The slices of one set, and where they are."""
Join = tuple[tuple[float, float], tuple[float, float]]
"""A line between two slices: where they are, and the end of an interval on either."""
PlaneBox = tuple[tuple[float, float], tuple[float, float]]
_VISIBLE = 2.5e-3
"""Of the height: what is less is hidden by the line itself."""
_COLOR = "#f2c14e"
_LEFT = {"transparent": _COLOR, "stable": "#f0b3a6"}


@dataclass(frozen=True)
class MapPlane:
    """The plane of the two parameters of a map, in the units of its axes."""

    found: DesignMap

    @cached_property
    def scales(self) -> tuple[Scale, Scale]:
        """The units of both parameters' axes."""
        pairs = zip(self.found.free, self.found.ranges, strict=True)
        one, other = (parameter_scale(x, (*pair, x.value)) for x, pair in pairs)
        return one, other

    @cached_property
    def window(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """From where to where both axes go."""
        (a, b), (low, high) = ((float(x) for x in pair) for pair in self.found.ranges)
        return (a, b), (low, high)

    @cached_property
    def rows(self) -> Rows:
        """The slices of what is asked."""
        return [(float(x.at), x.requirement) for x in self.found.slices]

    def x(self, values: Any) -> Any:
        """Places along the lower axis."""
        return self.scales[0].of(np.array(values))

    def y(self, values: Any) -> Any:
        """Places along the upright axis."""
        return self.scales[1].of(np.array(values))

    def ends(self, span: Span) -> tuple[float, float]:
        """From where to where an interval of a slice goes."""
        return limits_of(span, *self.window[1])

    def frame(self, ax: Axes, number: int = 0) -> None:
        """Limits and labels; ``number`` : of the maps that were drawn before."""
        scales, (x, y) = self.scales, self.window
        limit(ax, tuple(map(scales[0].of, x)), tuple(map(scales[1].of, y)), number=number)
        dress(ax, *(label_of(free, scale) for free, scale in zip(self.found.free, scales, strict=True)))

    def strokes(self, ax: Axes, color: str, width: float, label: str) -> LineCollection:
        """An upright stroke along each interval of each slice."""
        lines = [
            list(zip(self.x([at] * 2), self.y(self.ends(span)), strict=True))
            for at, r in self.rows
            for span in r.feasible
        ]
        made = LineCollection(lines, colors=color, linewidths=width, zorder=1, label=label)
        ax.add_collection(made)
        return made

    def ground(self, ax: Axes) -> bool:
        """A light ground between slices with as many intervals, which proves nothing; whether there is any."""
        pieces = list(neighbours(self.rows))
        for at, left, right in pieces:
            bottom, top = zip(self.ends(left), self.ends(right), strict=True)
            style: dict[str, Any] = {"color": pen.SHADE, "linewidth": 0, "antialiased": False, "zorder": 0}
            ax.fill_between(self.x(at), self.y(bottom), self.y(top), **style)
        return bool(pieces)

    def hatch(self, ax: Axes, boxes: Iterable[PlaneBox], suffix: str = "") -> list[Artist]:
        """What is undecided; what a legend tells of it."""
        found = list(boxes)
        for at, (low, high) in found:
            ax.fill_between(self.x(at), *self.y([[low] * 2, [high] * 2]), zorder=1, **HATCH)
        return [Patch(label=f"undecided{suffix}", **HATCH)] if found else []

    def rectangles(self, ax: Axes, cells: Array, color: str, zorder: float) -> None:
        """Cells of the plane in one colour."""
        rectangles(ax, self.x(cells[:, 0].T), self.y(cells[:, 1].T), color, zorder)

    def left_open(self) -> Iterator[PlaneBox]:
        """What slices leave open, halfway to their neighbours."""
        low, high = self.window[1]
        at = [x for x, _ in self.rows]
        middles = [at[0], *((a + b) / 2 for a, b in pairwise(at)), at[-1]] if at else []
        for (_, r), around in zip(self.rows, pairwise(middles), strict=True):
            for start, end in r.undecided:
                yield around, (low if start is None else float(start), high if end is None else float(end))

    def unlike(self, rows: Rows, *, decided: bool = False) -> Iterator[PlaneBox]:
        """The intervals of neighbouring slices that have not as many; ``decided`` : only if nothing is open on either."""
        for (x, one), (y, other) in pairwise(rows):
            if not (are_alike(one, other) or (decided and (one.undecided or other.undecided))):
                yield from (((x, y), self.ends(span)) for span in one.feasible + other.feasible)


def are_alike(one: Requirement, other: Requirement) -> bool:
    """Whether two slices have as many intervals."""
    return len(one.feasible) == len(other.feasible)


def neighbours(rows: Rows) -> Iterator[tuple[tuple[float, float], Span, Span]]:
    """Between slices with as many intervals: where they are, and the intervals that belong together."""
    for (x, one), (y, other) in pairwise(rows):
        if are_alike(one, other):
            yield from (((x, y), *pair) for pair in zip(one.feasible, other.feasible, strict=True))


def draw_bands(ax: Axes, plane: MapPlane, joins: Iterable[Join]) -> list[Artist]:
    """A band about each line, as wide as it may be off, as estimated; what a legend tells."""
    widths = {(x.low, x.high): x.deviation or 0.0 for x in plane.found.gaps}
    drawn = False
    for at, ends in joins:
        width = widths.get(at, 0.0)
        if width > _VISIBLE * plane.found.height:
            y = np.array(ends)
            ax.fill_between(
                plane.x(at), *plane.y([y - width, y + width]), color=_COLOR, linewidth=0, alpha=0.6, zorder=1
            )
            drawn = True
    return [Patch(facecolor=_COLOR, alpha=0.6, label="boundary between slices, estimated")] if drawn else []


def draw_kept(ax: Axes, plane: MapPlane) -> list[Artist]:
    """A light ground on the rectangles in which a map of what is transparent is proven to be so."""
    [proof] = plane.found.proofs
    plane.rectangles(ax, proof.rectangles.kept, pen.SHADE, 0)
    return [Patch(facecolor=pen.SHADE, label="transparent, proven")] if len(proof.rectangles.kept) else []


def draw_common(ax: Axes, plane: MapPlane, label: str) -> list[Artist]:
    """The same on what is proven to have all that is asked."""
    cells = common([x.rectangles for x in plane.found.proofs if x.jnd is None])
    if not len(cells):
        return []
    plane.rectangles(ax, cells, pen.SHADE, 0)
    return [Patch(facecolor=pen.SHADE, label=label)]


def draw_left(ax: Axes, plane: MapPlane) -> list[Artist]:
    """The rectangles in which neither is proven: boundaries of what is transparent, and of what is stable, lie in these.

    Where a second pair of roots crosses the axis neither side is stable: such rectangles are left open without a boundary.
    """
    made: list[Artist] = []
    for name, color in _LEFT.items():
        drawn = [x.rectangles.left for x in plane.found.proofs if x.of == name and len(x.rectangles.left)]
        for cells in drawn:
            plane.rectangles(ax, cells, color, 0.5)
        what = f"{name}: undecided" if len(plane.found.that) > 1 or plane.found.thresholds else "undecided"
        made += [Patch(facecolor=color, label=f"{what}, holds the boundary")] if drawn else []
    return made


_AT = {
    Kind.EDGE: "at the band's edge", Kind.START: "at the band's low end", Kind.TOUCH: "tangency", Kind.AXIS: "poles on the axis",
    Kind.FAR: "at high frequency",
}  # fmt: skip
_FILL = {Kind.EDGE: "full", Kind.START: "none", Kind.TOUCH: "bottom", Kind.AXIS: "full", Kind.FAR: "none"}


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
    ["imaginary part, at the band's edge"]
    """
    look, plane = Look.on(ax, "exact slices", color, label), MapPlane(found)
    somewhere = any(r.feasible for _, r in plane.rows)
    named = f"transparent on the slice{look.suffix}" if somewhere else ""
    strokes = plane.strokes(ax, look.ink(pen.GREY), 0.7, named)
    ticks = [0] * len(plane.rows)
    ax.plot(
        plane.x([x for x, _ in plane.rows]), ticks, transform=ax.get_xaxis_transform(), clip_on=False, **_tick(look)
    )
    ground = [] if look.number else _draw_ground(ax, plane)
    marks = draw_boundary(ax, found, color=None if look.plain else look.color, suffix=look.suffix)
    bands = [] if look.number else _draw_bands(ax, plane)
    between = () if found.proofs else plane.unlike(plane.rows)
    open_ones = plane.hatch(ax, (*plane.left_open(), *between), look.suffix)
    plane.frame(ax, look.number)
    some = [strokes] if somewhere else []
    legend(ax, [*some, *ground, *(x for _, x in marks), *bands, *open_ones, *_tick_entry(look)])
    if not somewhere:
        word = "transparent nowhere" if found.certified else "nowhere proven transparent"
        write_note(ax, f"{word}: on none of {len(found.slices)} exact slices{look.suffix}")
    return [strokes, *(x for x, _ in marks)]


def _tick(look: Look) -> dict[str, Any]:
    return {"color": look.ink(pen.GREY), "linestyle": "none", "marker": 3, "markersize": 2.5}


def _tick_entry(look: Look) -> list[Artist]:
    return [Line2D([], [], label=f"exact slices{look.suffix}", **{**_tick(look), "marker": "|", "markersize": 5})]


def _draw_ground(ax: Axes, plane: MapPlane) -> list[Artist]:
    """A light ground: what is proven, or else what lies between slices of one kind."""
    if plane.found.proofs:
        return draw_kept(ax, plane)
    return [Patch(facecolor=pen.SHADE, label="between slices: interpolated")] if plane.ground(ax) else []


def _draw_bands(ax: Axes, plane: MapPlane) -> list[Artist]:
    return draw_left(ax, plane) if plane.found.proofs else draw_bands(ax, plane, [join for join, _ in _joins(plane)])


def draw_boundary(
    ax: Axes, found: DesignMap, *, color: str | None = None, suffix: str = "", width: float = 0.6
) -> list[tuple[Line2D, Line2D]]:
    """The ends of all slices, marked by what binds there, joined by lines that interpolate; marks, and entries for a legend.

    ``suffix`` : what the entries end with; ``width`` : of the lines, points.
    """
    plane = MapPlane(found)
    drawn = []
    for (at, ends), binding in _joins(plane):
        look = look_of(binding.criterion)
        style: dict[str, Any] = {"color": color or look.color, "linestyle": look.stroke}
        ax.plot(plane.x(at), plane.y(ends), linewidth=width, zorder=2, **style)
    for (criterion, kind), places in _ends(found).items():
        x, y = zip(*places, strict=True)
        look = look_of(criterion)
        shown = color or look.color
        mark: dict[str, Any] = {
            "marker": look.marker, "markersize": 2.8, "markeredgewidth": 0.6, "fillstyle": _FILL[kind],
            "markerfacecoloralt": "white", "label": f"{criterion.words}, {_AT[kind]}{suffix}",
        }  # fmt: skip
        [marks] = ax.plot(plane.x(x), plane.y(y), color=shown, linestyle="none", zorder=3, **mark)
        drawn.append((marks, Line2D([], [], color=shown, linestyle=look.stroke, linewidth=width, **mark)))
    return drawn


def _joins(plane: MapPlane) -> Iterator[tuple[Join, Binding]]:
    """The lines that join the ends of neighbouring slices, and what binds along each."""
    for at, left, right in neighbours(plane.rows):
        pairs = zip(plane.ends(left), plane.ends(right), strict=True)
        for pair, one, other in zip(pairs, (left.low, left.high), (right.low, right.high), strict=True):
            binding = _of(one.bindings, other.bindings)
            if binding is not None:
                yield (at, pair), binding


def _ends(found: DesignMap) -> dict[tuple[Criterion, Kind], list[tuple[float, float]]]:
    """The exact ends of all slices, by the first condition that binds there."""
    places: dict[tuple[Criterion, Kind], list[tuple[float, float]]] = {}
    for x in found.slices:
        for end in x.requirement.ends:
            if end.bindings and end.value is not None:
                key = (end.bindings[0].criterion, end.bindings[0].kind)
                places.setdefault(key, []).append((float(x.at), float(end.value)))
    return places


def _of(left: tuple[Binding, ...], right: tuple[Binding, ...]) -> Binding | None:
    """What binds between two slices: what binds at one of them; nothing where the range itself ends at both."""
    found = [*left, *right] if left and right else []
    return found[0] if found else None


_COLORS = {"transparent": pen.BLUE, "stable": pen.RED, "passive": "#d0701f"}
_NAMES = {"transparent": "transparent", "stable": "stable", "passive": "passive"}
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
            joins += _joins_in_wishes(plane, rows)
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


def _joins_in_wishes(plane: MapPlane, rows: Rows) -> Iterator[Join]:
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
    (color, name), joins = look, list(_joins_in_wishes(plane, rows))
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
