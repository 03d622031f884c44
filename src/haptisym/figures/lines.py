"""Measured lines as figures have them: not too many, with their discs, over frequencies in a unit and on a scale that fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from sympy import Expr

from haptisym.figures import pen
from haptisym.figures.scales import Scale, band_scale, floats_scale, wanted_scale
from haptisym.figures.style import entry, handle
from haptisym.model.jnd import Part
from haptisym.verbs.measured.entry import MeasuredEvaluation

_MOST_LINES = 800
"""Drawn; of more, every so many."""


def thinned(count: int) -> Any:
    """Which of so many lines are drawn."""
    return np.arange(0, count, -(-count // _MOST_LINES))


def codes_of(e: MeasuredEvaluation, part: Part) -> Any:
    """What is told of a part, or of both where the region judges them together."""
    return e.joint.verdict if e.joint else e.verdict[part]


def left_out(drawn: int, count: int) -> list[Line2D]:
    """What the legend says where not all lines are drawn."""
    return [entry(f"{drawn} of {count} lines are drawn")] if drawn < count else []


def scale_of_lines(omega: Any, band: Sequence[Expr] | None = None, *, hertz: bool | None = None) -> Scale:
    """The unit of their frequencies: what was asked for, else that of the band, else the one in which they are short."""
    return wanted_scale(hertz=hertz) or (band_scale(band) if band else floats_scale(omega[:50]))


def spread_out(ax: Axes, at: Any) -> None:
    """A logarithmic axis where the lines span decades."""
    if at[0] > 0 and at[-1] > 30 * at[0]:
        ax.set_xscale("log")
        ax.tick_params(which="minor", width=0.4, length=1.5, color=pen.GREY)


def draw_discs(ax: Axes, centres: Any, radii: Any, color: str) -> None:
    """A disc about each point of the plane whose radius is known."""
    seen = np.isfinite(radii) & (radii > 0)
    circles = [Circle((c.real, c.imag), r) for c, r in zip(centres[seen], radii[seen], strict=True)]
    ax.add_collection(PatchCollection(circles, facecolor=color, edgecolor=color, alpha=0.22, linewidth=0.5, zorder=1))


def disc_handle(confidence: float) -> Line2D:
    """What the legend says of the bars that stand for discs."""
    return handle(pen.GREY, "none", f"{100 * confidence:.4g} % disc", 0.7, marker="|", markersize=6)
