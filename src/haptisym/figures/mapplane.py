"""The plane of a map: its axes, its slices, what lies between them as interpolated, estimated or proven, and what is open."""

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
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.require import HATCH, label_of, limits_of, parameter_scale
from haptisym.figures.scales import Scale
from haptisym.figures.style import dress, limit, rectangles
from haptisym.programs.taylormodels import Array
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.feasible import Span
from haptisym.verbs.require.plane import common
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
        what = f"{name}: left open" if len(plane.found.that) > 1 or plane.found.thresholds else "left open"
        made += [Patch(facecolor=color, label=f"{what}, holds the boundary")] if drawn else []
    return made
