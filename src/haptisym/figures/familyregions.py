"""Does it survive another JND model, for several environments: the bandwidth of each by every region."""

from __future__ import annotations

from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures.scales import band_scale
from haptisym.figures.sheet import one_column
from haptisym.figures.style import BLUE, GREY, INK, RED, SMALL, TEXT, dress, legend
from haptisym.verbs.family.entry import FamilyEvaluation

_BROAD = 16
"""Letters of a name in a line of it: more leave the axes no room."""
_LOOKS = ((GREY, "s"), (BLUE, "o"), (RED, "D"), ("#d0701f", "x"))


def draw_family_regions(ax: Axes, evaluation: FamilyEvaluation) -> list[Line2D]:
    """A row for each environment and one for all together; a mark for the bandwidth that each region gives.

    A region that gives no bandwidth has no mark in that row. Returns the marks of each region.
    """
    names = [*evaluation.family, "all together"]
    scale = band_scale(evaluation.family.first.band)
    low, high = (scale.of(float(evaluation.chart.points[i].omega)) for i in (0, -1))
    rows, marks = np.arange(len(names)), list[Line2D]()
    for i, (x, (color, marker)) in enumerate(zip(evaluation.regions, _LOOKS, strict=False)):
        widths = [*(x.answers[name].bandwidth for name in evaluation.family), x.bandwidth]
        at = [np.nan if w is None else float(scale.of(float(w))) for w in widths]
        marks += ax.plot(
            at, rows + 0.2 * (i - 1.5), color=color, linestyle="", marker=marker, markersize=3.4, label=x.name
        )
        marks[-1].set(zorder=3, clip_on=False)
    empty = np.isnan(np.array([x.get_xdata() for x in marks], dtype=float)).all(axis=0)
    for row in rows[empty]:
        ax.text(low + 0.01 * (high - low), row, "no bandwidth", fontsize=SMALL, color=INK, va="center")
    ax.axhline(len(names) - 1.5, color=GREY, linewidth=0.5)
    ax.set(xlim=(low, high), ylim=(len(names) - 0.5, -0.5))
    dress(ax)
    ax.set_yticks(range(len(names)), [fill(x, _BROAD, max_lines=3, placeholder="…") for x in names])
    ax.set_xlabel(f"bandwidth ({scale.unit})", fontsize=TEXT)
    legend(ax, marks)
    return marks


def family_regions_figure(evaluation: FamilyEvaluation) -> Figure:
    """The figure, as high as its rows need."""

    def draw(ax: Axes) -> None:
        draw_family_regions(ax, evaluation)
        figure = ax.get_figure(root=True)
        assert figure is not None
        engine = figure.get_layout_engine()
        assert engine is not None
        engine.execute(figure)
        legend(ax, [])  # in as many columns as the names leave room for

    return one_column(0.6 + 0.36 * (len(evaluation.family) + 1), draw)
