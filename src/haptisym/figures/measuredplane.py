"""The changes of measured lines in the plane that a region of the JND is a part of, each with its disc."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from haptisym.figures.style import BLUE, GREY, INK, RED, TEXT, dress, handle, legend, limit
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.regions import joint_distance

_LOOKS = ((1, RED, "outside"), (0, GREY, "unresolved"), (-1, BLUE, "inside"))
_MOST_LINES = 800
"""Drawn; of more, every so many."""


def draw_measured_plane(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """dH/|H_env| of each line with its disc, and the region, where that is the same at all. Returns the dots."""
    assert e.joint is not None
    drawn = np.arange(0, len(e), -(-len(e) // _MOST_LINES))
    at, codes = e.lines.change[drawn], e.joint.verdict[drawn]
    radius = np.zeros(len(at)) if e.lines.radius is None else e.lines.radius[drawn]
    reach = max(0.2, 1.15 * float(np.quantile(np.abs(at[np.isfinite(at)]), 0.9)))
    limit(ax, (-reach, reach), (-reach, reach))
    made: list[Line2D] = []
    for code, colour, label in _LOOKS:
        if (own := (codes == code) & np.isfinite(at)).any():
            discs = [Circle((z.real, z.imag), r) for z, r in zip(at[own], radius[own], strict=True) if 0 < r < np.inf]
            ax.add_collection(PatchCollection(discs, facecolor=colour, edgecolor=colour, alpha=0.22, linewidth=0.5))
            made += ax.plot(
                at[own].real, at[own].imag, linestyle="none", marker="o", markersize=2.4, color=colour, label=label
            )
    entries = [*made]
    if e.scene.threshold.is_constant:
        side = np.linspace(-reach, reach, 401)
        x, y = np.meshgrid(side, side)
        distance = joint_distance(e.scene.threshold, np.ones(x.size), x.ravel(), y.ravel())
        assert distance is not None
        ax.contour(x, y, distance.reshape(x.shape), levels=[0], colors=INK, linewidths=0.9)
        entries.append(handle(INK, "-", str(e.scene.threshold.region.shape.value), 0.9))
    dress(ax)
    ax.set_aspect("equal")
    ax.set_xlabel(r"$\mathrm{Re}\,\Delta H/|H_\mathrm{env}|$", fontsize=TEXT)
    ax.set_ylabel(r"$\mathrm{Im}\,\Delta H/|H_\mathrm{env}|$", fontsize=TEXT)
    legend(ax, entries)
    return made
