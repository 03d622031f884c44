"""When: the ratios r_r and r_i over the band (the paper's Fig. 5)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from haptisym.evaluation import Evaluation
from haptisym.jnd import Part
from haptisym.numeric.values import Array, Values

from .sampling import band_of, broken, evenly, in_window, limits_of, refined, sampled, top_of
from .style import (
    DASHED,
    FREQUENCY,
    GREY,
    INK,
    MOST_LABELS,
    SHADE,
    SOLID,
    TEXT,
    dress,
    entry,
    handle,
    label_above,
    legend,
    shade,
)


def draw_ratios(ax: Axes, evaluation: Evaluation) -> None:
    """r_r and r_i over the band with their thresholds, crossings and the transparent bands in grey (the paper's Fig. 5).

    The axis is cut where a ratio is unbounded or has a narrow high peak; how high that is, and where, stands above it.
    """
    f, limits = evaluation.distortion.compile(), limits_of(evaluation)
    grid = sampled(evaluation)
    top = max(top_of(_ratios(f, grid), _ratios(f, evenly(evaluation)), max(limits)), 2 * max(limits))
    omega = refined(lambda w: in_window(_ratios(f, w), 0, top), grid)
    ratios = broken(_ratios(f, omega), omega, evaluation.unbounded)
    shade(ax, evaluation.transparent)
    for values, c, style in zip(ratios.T, limits, (SOLID, DASHED), strict=True):
        ax.axhline(c, color=GREY, linewidth=0.6, linestyle=style if len(set(limits)) > 1 else SOLID)
        ax.plot(omega, values, color=INK, linewidth=1.1, linestyle=style)
    ax.set(xlim=band_of(evaluation), ylim=(0, top))
    dress(ax)
    ax.set_xlabel(FREQUENCY, fontsize=TEXT)
    ax.set_ylabel(r"ratio to $|H_\mathrm{env}|$", fontsize=TEXT)
    _mark_crossings(ax, evaluation)
    label_above(ax, _frequency_labels(evaluation, omega, ratios.max(axis=1), top))
    legend(ax, _ratio_handles(evaluation), lines=1)


def _ratios(f: Callable[..., Values], omega: Array) -> Array:
    values = f(omega)
    return np.stack([values.ratio_real, values.ratio_imag], axis=1)


def _mark_crossings(ax: Axes, evaluation: Evaluation) -> None:
    """A dot where r_r, a ring where r_i meets its threshold."""
    for part, c, face in zip(Part, limits_of(evaluation), (INK, "white"), strict=True):
        omega = [float(crossing.omega) for crossing in evaluation.crossings if crossing.part is part]
        if not omega:  # an unclipped line without points would upset the layout
            continue
        ax.plot(
            omega, [c] * len(omega), linestyle="none", marker="o", markersize=3.6, color=INK,
            markerfacecolor=face, markeredgewidth=0.8, zorder=4, clip_on=False,
        )  # fmt: skip


def _frequency_labels(evaluation: Evaluation, omega: Array, highest: Array, top: float) -> list[tuple[float, str]]:
    """What stands above the axes: crossing frequencies while they are few, and the two highest peaks that are cut."""
    crossings = [(float(c.omega), c.omega.digits(4)) for c in evaluation.crossings]
    values = np.where(np.isnan(highest), np.inf, highest)
    peaks = [(float(omega[i]), f"{_height(values[i])} at {omega[i]:.4g}") for i in _peaks(values, top)[:2]]
    return (crossings if len(crossings) <= MOST_LABELS else []) + peaks


def _peaks(values: Array, top: float) -> list[int]:
    """Of each run of samples above the top the highest, the highest of all first."""
    runs = [list(run) for above, run in groupby(range(len(values)), key=lambda i: bool(values[i] > top)) if above]
    return sorted((max(run, key=lambda i: values[i]) for run in runs), key=lambda i: -values[i])


def _height(value: float) -> str:
    return "∞" if np.isinf(value) else f"{float(f'{value:.2g}'):g}"


def _ratio_handles(evaluation: Evaluation) -> list[Any]:
    limits = limits_of(evaluation)
    names = (r"c_\mathrm{r}", r"c_\mathrm{i}") if len(set(limits)) > 1 else ("c",)
    thresholds = [
        handle(GREY, style, f"${name} = {c:.3g}$", 0.6)
        for name, c, style in zip(names, limits, (SOLID, DASHED), strict=False)
    ]
    shade = Patch(facecolor=SHADE, label="transparent") if evaluation.transparent else entry("nowhere transparent")
    count = len(evaluation.crossings)
    counted = [entry(f"{count} crossings")] if count > MOST_LABELS else []
    return [handle(INK, SOLID, r"$r_\mathrm{r}$"), handle(INK, DASHED, r"$r_\mathrm{i}$"), *thresholds, shade, *counted]
