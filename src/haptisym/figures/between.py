"""What is known of a map between its slices: what is proven there, and how far lines may be off, as estimated."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch

from haptisym.figures.scales import Scale
from haptisym.figures.style import SHADE
from haptisym.programs.taylormodels import Array
from haptisym.verbs.require.designmap import DesignMap
from haptisym.verbs.require.plane import common

Join = tuple[tuple[float, float], tuple[float, float]]
"""A line between two slices: where they are, and the end of an interval on either."""
_VISIBLE = 2.5e-3
"""Of the height: what is less is hidden by the line itself."""
_COLOR = "#f2c14e"
_LEFT = {"transparent": _COLOR, "stable": "#f0b3a6"}


def draw_bands(ax: Axes, found: DesignMap, joins: Iterable[Join], scales: tuple[Scale, Scale]) -> list[Artist]:
    """A band about each line, as wide as it may be off, as estimated; what a legend tells."""
    widths = {(x.low, x.high): x.deviation or 0.0 for x in found.gaps}
    drawn = False
    for at, ends in joins:
        width = widths.get(at, 0.0)
        if width > _VISIBLE * found.height:
            x, y = scales[0].of(np.array(at)), np.array(ends)
            low, high = scales[1].of(y - width), scales[1].of(y + width)
            ax.fill_between(x, low, high, color=_COLOR, linewidth=0, alpha=0.6, zorder=1)
            drawn = True
    return [Patch(facecolor=_COLOR, alpha=0.6, label="boundary between slices, estimated")] if drawn else []


def draw_kept(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    """A light ground on the rectangles in which a map of what is transparent is proven to be so."""
    [proof] = found.proofs
    _draw(ax, proof.rectangles.kept, scales, (SHADE, 0))
    return [Patch(facecolor=SHADE, label="transparent, proven")] if len(proof.rectangles.kept) else []


def draw_common(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale], label: str) -> list[Artist]:
    """The same on what is proven to have all that is asked."""
    cells = common([x.rectangles for x in found.proofs if x.jnd is None])
    if not len(cells):
        return []
    _draw(ax, cells, scales, (SHADE, 0))
    return [Patch(facecolor=SHADE, label=label)]


def draw_left(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    """The rectangles in which neither is proven: boundaries of what is transparent, and of what is stable, lie in these.

    Where a second pair of roots crosses the axis neither side is stable: such rectangles are left open without a boundary.
    """
    made: list[Artist] = []
    for name, color in _LEFT.items():
        drawn = [x.rectangles.left for x in found.proofs if x.of == name and len(x.rectangles.left)]
        for cells in drawn:
            _draw(ax, cells, scales, (color, 0.5))
        what = f"{name}: left open" if len(found.that) > 1 or found.thresholds else "left open"
        made += [Patch(facecolor=color, label=f"{what}, holds the boundary")] if drawn else []
    return made


def _draw(ax: Axes, cells: Array, scales: tuple[Scale, Scale], look: tuple[str, float]) -> None:
    (a, b), (c, d) = (scale.of(cells[:, i].T) for i, scale in enumerate(scales))
    corners = np.stack([np.stack(x, -1) for x in ((a, c), (b, c), (b, d), (a, d))], 1)
    ax.add_collection(
        PolyCollection(list(corners), facecolors=look[0], linewidths=0, antialiased=False, zorder=look[1])
    )
