"""What is known of a map between its slices: how far the lines that join them may be off, as estimated."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from haptisym.figures.scales import Scale
from haptisym.verbs.require.designmap import DesignMap

Join = tuple[tuple[float, float], tuple[float, float]]
"""A line between two slices: where they are, and the end of an interval on either."""
_VISIBLE = 2.5e-3
"""Of the height: what is less is hidden by the line itself."""
_COLOR = "#f2c14e"


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
