"""The figure of a release: the motion after the hand lets go, and the envelope that the closed form gives it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.sheet import one_column, save_all
from haptisym.figures.style import Look, dress, legend, limit, shown_length
from haptisym.programs.values import Array
from haptisym.verbs.simulate.propagate import finer
from haptisym.verbs.simulate.released import Release

_PERIODS = 12
_FOLDS = 5.0  # powers of e that are shown


def release_figure(r: Release) -> Figure:
    """One column, with its legend."""
    return one_column(2.0, lambda ax: draw_release(ax, r))


def save_release_figures(r: Release, directory: str | Path) -> list[Path]:
    """The figure as files."""
    return save_all({"release": release_figure(r)}, directory)


def draw_release(ax: Axes, r: Release, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The motion over time, with the envelope of the closed form's rightmost root where that is what was simulated.

    ``color``, ``label`` : of the run; of a further one on the same axes the motion alone is drawn. Returns the lines.

    >>> from haptisym import Hand, release
    >>> found = release("delayed-spring", "1 cm", Hand("own", m="0.5 kg", b="3.6 N*s/m"))
    >>> [line.get_label() for line in draw_release(Figure().add_subplot(), found)]
    ['motion', 'envelope of the closed form']
    """
    look = Look.on(ax, "motion", color, label)
    end = _shown(r)
    places = np.linspace(0, 1, 12)
    time, x = finer(r.time, places), finer(r.hand_motion, places)
    inside = time <= end
    factor, unit = shown_length(r.displacement, r.unit)
    motion = ax.plot(
        time[inside], x[inside] * factor, color=look.color, linewidth=1.0, label=f"motion{look.suffix}", zorder=3
    )
    lines = motion
    if not look.number:
        ax.axhline(0, color=pen.GREY, linewidth=0.4, zorder=0)
        lines = [*motion, *_envelope(ax, r, time[inside], x[inside], factor)]
    most = 1.08 * factor * float(np.abs(x[inside]).max())
    limit(ax, (0, end), (-most, most), number=look.number)
    dress(ax, "time (s)", f"motion ({unit})")
    legend(ax, lines)
    return lines


def _shown(r: Release) -> float:
    """How much of the run is drawn: some periods, or some powers of e."""
    end = float(r.time[-1])
    if r.fitted is None:
        return end
    periods = _PERIODS * 2 * np.pi / max(r.fitted.omega, 1e-9)
    return float(min(end, periods, _FOLDS / max(abs(r.fitted.rate), 1e-9)))


def _envelope(ax: Axes, r: Release, time: Array, x: Array, factor: float) -> list[Line2D]:
    """A exp(rate t) and its opposite, as high as the motion is in the middle of what is drawn."""
    if r.closed is None or r.approximate or r.is_envelope:
        return []
    late = time > time[-1] / 3
    shape = np.exp(r.closed.rate * time)
    height = float(np.max(np.abs(x[late]) / shape[late])) * factor
    style: dict[str, Any] = {"color": pen.RED, "linestyle": pen.DASHED, "linewidth": 0.9}
    upper = ax.plot(time, height * shape, label="envelope of the closed form", **style)
    if r.closed.omega:
        ax.plot(time, -height * shape, **style)
    return upper
