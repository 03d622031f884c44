"""The figure of a map of two parameters: of one thing asked, or of several."""

from __future__ import annotations

from matplotlib.figure import Figure

from haptisym.figures.designmap import draw_map
from haptisym.figures.sheet import one_column
from haptisym.figures.wishes import draw_wishes
from haptisym.verbs.require.designmap import DesignMap


def map_figure(found: DesignMap) -> Figure:
    """A map of two parameters; of several things or thresholds asked, each set for itself and what they have in common."""
    if found.that != ("transparent",) or found.thresholds:
        return one_column(2.8, lambda ax: draw_wishes(ax, found))
    return one_column(2.6, lambda ax: draw_map(ax, found))
