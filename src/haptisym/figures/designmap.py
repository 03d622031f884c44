"""Figures of design maps: the transparent region in two parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.mapplane import Join, MapPlane, draw_bands, draw_kept, draw_left, neighbours
from haptisym.figures.require import look_of
from haptisym.figures.style import Look, legend, write_note
from haptisym.judge.criteria import Criterion
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Binding, Kind

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
    ['imaginary part, band-edge']
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
            "markerfacecoloralt": "white", "label": f"{criterion.words}, {kind.value}{suffix}",
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
