"""Between the lines of a measured evaluation: as far as the discs reach that the bound on the slope sweeps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from haptisym.figures.scales import Scale
from haptisym.figures.style import GREY
from haptisym.model.jnd import Part
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.swept import Cells, Swept

_MOST_POINTS = 6000


def draw_swept(ax: Axes, e: MeasuredEvaluation, scale: Scale, colours: Mapping[Part, Any]) -> list[Artist]:
    """The ratios that swept discs leave possible, as a band for each part. Returns the entry of the legend."""
    swept = Swept(e.scene, e.lines)
    gaps = np.flatnonzero(~swept.contradicted)
    steps = min(25, _MOST_POINTS // max(1, len(gaps)))
    if not len(gaps) or steps < 3:
        return []
    share = np.append(np.linspace(0, 1, steps), 1.0)
    low, high = swept.omega[gaps, None], swept.omega[gaps + 1, None]
    omega = (low + (high - low) * share).ravel()
    found = list(swept.lines(Cells(np.repeat(gaps, len(share)), omega, omega)))
    drawn = np.tile(np.append(np.ones(steps, bool), False), len(gaps))  # a break after each gap
    for part in Part:
        with np.errstate(invalid="ignore"):
            ratios = [np.abs(x.change.real if part is Part.REAL else x.change.imag) for x in found]
            least = np.max([np.maximum(r - x.radius, 0) for r, x in zip(ratios, found, strict=True)], axis=0)
            most = np.min([r + x.radius for r, x in zip(ratios, found, strict=True)], axis=0)
        known = drawn & np.isfinite(least) & np.isfinite(most)
        ax.fill_between(
            scale.of(omega),
            least,
            np.maximum(least, most),
            where=known,
            color=colours[part],
            alpha=0.16,
            linewidth=0,
            zorder=1,
        )
    return [Patch(facecolor=GREY, alpha=0.3, linewidth=0, label="swept discs")]
