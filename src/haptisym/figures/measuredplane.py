"""Measured lines in the complex plane, each with its disc: both responses, and their changes with a region of the JND."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.lines import codes_of, draw_discs, left_out, thinned
from haptisym.figures.style import dots, draw_origin, dress_changes, dress_plane, handle, keep_scales, legend, limit
from haptisym.model.jnd import Part
from haptisym.model.measured import Measurement
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.verbs.measured.regions import joint_distance

_PARTS = ((1, pen.RED, "exceeds in a part"), (0, pen.GREY, "unresolved"), (-1, pen.BLUE, "below in both parts"))
_JOINT = ((1, pen.RED, "outside"), (0, pen.GREY, "unresolved"), (-1, pen.BLUE, "inside"))


def draw_measured_nyquist(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """H_env and the measured H_perc in the complex plane, a disc around each line, in the colour of what it tells.

    Returns the curve (or dots) of the environment and the dots of what is felt.
    """
    drawn = thinned(len(e))
    draw_origin(ax)
    lines = _environment(ax, e, drawn)
    real, imag = (codes_of(e, part) for part in Part)
    codes = np.where((real == 1) | (imag == 1), 1, np.where((real == -1) & (imag == -1), -1, 0))[drawn]
    felt, radius = e.lines.perceived[drawn], e.lines.perc_radius[drawn]
    for code, colour, label in _PARTS:
        if (own := codes == code).any():
            draw_discs(ax, felt[own], radius[own], colour)
            lines += ax.plot(felt[own].real, felt[own].imag, color=colour, zorder=4, label=label, **dots(2.4))
    _frame(ax, np.concatenate([e.lines.environment[drawn], felt]), radius)
    dress_plane(ax, e.scene)
    legend(ax, [*lines, *left_out(len(drawn), len(e))])
    return lines


def _environment(ax: Axes, e: MeasuredEvaluation, drawn: Any) -> list[Line2D]:
    """A curve of the model, or dots with discs where the environment is measured too."""
    x, label = e.lines, r"$H_\mathrm{env}$"
    if isinstance(e.scene.environment, Measurement):
        draw_discs(ax, x.environment[drawn], x.env_radius[drawn], pen.INK)
        env = x.environment[drawn]
        return ax.plot(env.real, env.imag, color=pen.INK, zorder=3, label=label, **dots(3, "x"))
    omega = np.union1d(np.linspace(x.omega[0], x.omega[-1], 801), x.omega[drawn])
    values = e.scene.frame.distortion().compile(of=["environment_real", "environment_imag"])(omega)
    made = ax.plot(
        values.environment_real, values.environment_imag, color=pen.INK, linewidth=1.1, zorder=2, label=label
    )
    env = x.environment[drawn]
    ax.plot(env.real, env.imag, color=pen.INK, zorder=3, **dots(4, "|"))
    return made


def _frame(ax: Axes, points: Any, radius: Any) -> None:
    """Limits that hold the points and most of their discs; equal scales where that leaves a drawing."""
    known = radius[np.isfinite(radius)]
    reach = float(np.quantile(known, 0.9)) if len(known) else 0.0
    sides = [(float(x.min()) - reach, float(x.max()) + reach) for x in (points.real, points.imag)]
    margin = 0.05 * max(high - low for low, high in sides) or 1.0
    limit(ax, *((low - margin, high + margin) for low, high in sides))
    keep_scales(ax)


def draw_measured_plane(ax: Axes, e: MeasuredEvaluation) -> list[Line2D]:
    """dH/|H_env| of each line with its disc, and the region, where that is the same at all. Returns the dots."""
    assert e.joint is not None
    drawn = thinned(len(e))
    at, codes = e.lines.change[drawn], e.joint.verdict[drawn]
    radius = np.zeros(len(at)) if e.lines.radius is None else e.lines.radius[drawn]
    reach = max(0.2, 1.15 * float(np.quantile(np.abs(at[np.isfinite(at)]), 0.9)))
    limit(ax, (-reach, reach), (-reach, reach))
    made: list[Line2D] = []
    for code, colour, label in _JOINT:
        if (own := (codes == code) & np.isfinite(at)).any():
            draw_discs(ax, at[own], radius[own], colour)
            made += ax.plot(at[own].real, at[own].imag, color=colour, label=label, **dots(2.4))
    entries = [*made]
    if e.scene.threshold.is_constant:
        side = np.linspace(-reach, reach, 401)
        x, y = np.meshgrid(side, side)
        distance = joint_distance(e.scene.threshold, np.ones(x.size), x.ravel(), y.ravel())
        assert distance is not None
        ax.contour(x, y, distance.reshape(x.shape), levels=[0], colors=pen.INK, linewidths=0.9)
        entries.append(handle(pen.INK, "-", str(e.scene.threshold.region.shape.value), 0.9))
    dress_changes(ax)
    ax.set_aspect("equal")
    legend(ax, entries)
    return made
