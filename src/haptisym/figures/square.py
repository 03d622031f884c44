"""Noticed or not: the JND square at one frequency (the paper's Figs. 2 and 3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle

from haptisym.crossings import Curve
from haptisym.errors import SceneError
from haptisym.evaluation import Evaluation
from haptisym.jnd import Part
from haptisym.numeric.values import Array

from .nyquist import arrow, responses, stacked
from .sampling import band_of, limits_of
from .style import CURVES, DOTTED, FULL_NAMES, GREY, SHADE, SMALL, TEXT, curve_handles, dress, legend, name_dynamics


def draw_jnd_square(ax: Axes, evaluation: Evaluation, omega: float) -> None:
    """H_env and H_perc at one frequency of the band, rad/s, with the region of changes that are not noticed (Fig. 2).

    The region is c_real ``|H_env|`` wide and c_imag ``|H_env|`` high to each side of the tip of H_env; its projections are
    bars on the axes. Raises SceneError outside the band and where H_env or H_perc is infinite.
    """
    noticed = [part for part in Part if _sign_at(evaluation, omega, (Curve.EXCESS, part)) > 0]
    tips = stacked(responses(evaluation.distortion.compile(), np.array([omega])))
    if not np.isfinite(tips).all():
        raise SceneError(f"omega: the dynamics are infinite at {omega:g} rad/s")
    reach = np.array(limits_of(evaluation)) * np.hypot(*tips[0])
    _draw_region(ax, tips[0], reach)
    for tip, (color, style, _) in zip(tips, CURVES, strict=True):
        _draw_vector(ax, tip, color, style)
    _frame(ax, np.array([[0, 0], *tips, tips[0] - reach, tips[0] + reach]))
    dress(ax)
    name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", evaluation)
    name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", evaluation)
    region = Patch(facecolor=SHADE, edgecolor=GREY, linewidth=0.6, label="not noticed")
    legend(ax, [*curve_handles("", ""), region])
    ax.set_title(rf"$\omega$ = {omega:.4g} rad/s: {_verdict(noticed)}", fontsize=TEXT, pad=2.2 * SMALL)


def _verdict(noticed: Sequence[Part]) -> str:
    if not noticed:
        return "not noticed"
    return f"noticed in {'both parts' if len(noticed) == 2 else f'the {FULL_NAMES[noticed[0]]} part'}"


def _sign_at(evaluation: Evaluation, omega: float, key: tuple[Curve, Part]) -> int:
    """The proven sign of a function of the chart at a frequency."""
    points = evaluation.chart.points
    below = [point for point in points if float(point.omega) <= omega]
    if not below or omega > float(points[-1].omega):
        raise SceneError(
            f"omega: {omega:g} rad/s is not on the band, {' to '.join(f'{x:g}' for x in band_of(evaluation))}"
        )
    return below[-1].at[key] if float(below[-1].omega) == omega else below[-1].after[key]


def _draw_region(ax: Axes, tip: Array, reach: Array) -> None:
    """The region of changes that are not noticed, and its projections on the axes."""
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    corner, size = tip - reach, 2 * reach
    ax.add_patch(Rectangle((corner[0], corner[1]), *size, facecolor=SHADE, edgecolor=GREY, linewidth=0.6, zorder=1))
    bar: dict[str, Any] = {"color": GREY, "alpha": 0.5, "linewidth": 3, "solid_capstyle": "butt", "zorder": 1}
    ax.plot([corner[0], corner[0] + size[0]], [0, 0], **bar)
    ax.plot([0, 0], [corner[1], corner[1] + size[1]], **bar)


def _draw_vector(ax: Axes, tip: Array, color: str, style: Any) -> None:
    """An arrow from the origin, and the projections of its tip on both axes."""
    ax.plot([tip[0], tip[0], 0], [0, tip[1], tip[1]], color=color, linewidth=0.6, linestyle=DOTTED, zorder=2)
    ax.plot([0, tip[0]], [0, tip[1]], color=color, linewidth=1.2, linestyle=style, zorder=3)
    if tip.any():
        arrow(ax, 0.95 * tip, tip, color)
    else:
        ax.plot([0], [0], color=color, marker="o", markersize=3.6, zorder=3)


def _frame(ax: Axes, points: Array) -> None:
    """Limits that hold the points with a margin, at equal scales, neither very wide nor very high."""
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.57 * np.maximum(high - low, 0.6 * np.max(high - low) or 1.0)
    low, high = (low + high) / 2 - half, (low + high) / 2 + half
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set_aspect("equal", adjustable="box")
