"""The figure of the measures: |Gamma|, relative distortion and the JND ratios over the band, with the bands of each verdict."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures.sampling import ends_of, sampled
from haptisym.figures.style import (
    BLUE,
    DASHED,
    FREQUENCY,
    GREY,
    INK,
    RED,
    SMALL,
    SOLID,
    TEXT,
    WIDTH,
    _legend_height,
    dress,
    handle,
    legend,
    save_as,
)
from haptisym.jnd import Part
from haptisym.numeric.values import Array

from .measured import Bands
from .metric import MetricRows


def save_metrics_figure(m: MetricRows, path: str | Path) -> Path:
    """The figure in a file; its ending says as what. SceneError for an ending other than .svg, .pdf and .png."""
    return save_as(metrics_figure(m), path)


def metrics_figure(m: MetricRows) -> Figure:
    """Curves above; below, for each measure, a bar where it is content."""
    height = 3.4
    figure = Figure(figsize=(WIDTH, height), layout="compressed")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1.1))
    draw_measures(upper, m)
    draw_verdicts(lower, m)
    upper.tick_params(labelbottom=False)
    figure.draw_without_rendering()
    figure.set_figheight(height + _legend_height(upper))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return figure


def draw_measures(ax: Axes, m: MetricRows) -> None:
    """| |Gamma| - 1 |, |dH/H_env|, r_r and r_i over the band, with the thresholds: all are fractions of |H_env|."""
    e = m.evaluation
    omega = sampled(e)
    v = e.distortion.compile()(omega)
    env, perc = (
        np.hypot(*x) for x in _pairs(v.environment_real, v.environment_imag, v.perceived_real, v.perceived_imag)
    )
    relative = np.hypot(v.ratio_real, v.ratio_imag)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(perc / env - 1)
    limits = [float(e.scene.threshold[part]) for part in Part]
    curves = (
        (relative, RED, SOLID, r"$|\Delta H/H_\mathrm{env}|$"),
        (size, BLUE, DASHED, r"$||\Gamma| - 1|$"),
        (v.ratio_real, INK, SOLID, r"$r_\mathrm{r}$"),
        (v.ratio_imag, INK, DASHED, r"$r_\mathrm{i}$"),
    )
    for values, color, style, _ in curves:
        ax.plot(omega, values, color=color, linestyle=style, linewidth=1.1)
    for c in sorted(set(limits)):
        ax.axhline(c, color=GREY, linewidth=0.6)
    finite = relative[np.isfinite(relative)]
    top = max(1.06 * float(finite.max()) if finite.size else 0.0, 1.6 * max(limits))
    ax.set(xlim=(omega[0], omega[-1]), ylim=(0, min(top, 8 * max(limits))))
    dress(ax)
    ax.set_ylabel(r"fraction of $|H_\mathrm{env}|$", fontsize=TEXT)
    legend(ax, [handle(color, style, label) for _, color, style, label in curves])


def _pairs(a: Array, b: Array, c: Array, d: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    return (a, b), (c, d)


def draw_verdicts(ax: Axes, m: MetricRows) -> None:
    """A bar for each measure where it is content, the JND's at the top."""
    rows = verdict_bands(m)
    for i, (_, bands) in enumerate(reversed(rows)):
        for low, high in map(ends_of, bands):
            ax.plot([low, high], [i, i], color=INK if i == len(rows) - 1 else GREY, linewidth=5, solid_capstyle="butt")
            if low == high:
                ax.plot([low], [i], color=GREY, marker="|", markersize=6, clip_on=False)
    dress(ax)
    ax.set_yticks(range(len(rows)), [name for name, _ in reversed(rows)], fontsize=SMALL)
    ax.set_ylim(-0.6, len(rows) - 0.4)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel(FREQUENCY, fontsize=TEXT)


def verdict_bands(m: MetricRows) -> list[tuple[str, Bands]]:
    """Where each verdict is a good one, as far as it depends on the frequency."""
    own = m.measured
    rows = [("JND", m.evaluation.transparent), ("|dH/H| ≤ c", own.within), ("within 3 dB", own.inside)]
    stable = own.absolutely_stable
    return [*rows, ("passive", own.passive), *([("abs. stable", stable)] if stable is not None else [])]
