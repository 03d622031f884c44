"""When: the ratios r_r and r_i over the band (the paper's Fig. 5)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures.sampling import band_of, broken, evenly, in_window, limits_of, refined, sampled, top_of
from haptisym.figures.scales import Scale, scale_of
from haptisym.figures.style import (
    DASHED,
    GREY,
    MOST_LABELS,
    SOLID,
    TEXT,
    Look,
    bars,
    dress,
    entries,
    entry,
    label_above,
    legend,
    limit,
    name_frequency,
    number,
    shade,
)
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part
from haptisym.programs.values import Array, Values

_NAMES = {Part.REAL: r"$r_\mathrm{r}$", Part.IMAG: r"$r_\mathrm{i}$"}


def draw_ratios(
    ax: Axes, evaluation: Evaluation, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Line2D]:
    """r_r and r_i over the band with their thresholds, crossings and the transparent bands in grey (the paper's Fig. 5).

    The axis is cut where a ratio is unbounded or has a narrow high peak; how high that is, and where, stands above it.

    ``color``, ``label`` : of the scene, in the drawing and behind its entries in the legend. On axes that hold a scene already,
    the next one gets the next colour and its number if they are not given, and bars at the top instead of grey bands.
    ``hertz`` : whether frequencies are in Hz; as the axes have them, or else as the scene writes its band, if not given.
    Returns the lines of r_r and r_i.

    >>> from haptisym import evaluate, load_scene
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> for name in ("fu2019", "undamped-resonance"):
    ...     lines = draw_ratios(ax, evaluate(load_scene(name)), label=name)
    >>> len(lines), ax.get_xlabel(), ax.get_xlim() == (0, 40)
    (2, '$\\\\omega$ (rad/s)', True)
    """
    look, scale = Look.on(ax, _NAMES[Part.REAL], color, label), scale_of(ax, evaluation.scene.band, hertz=hertz)
    f, limits = evaluation.distortion.compile(), limits_of(evaluation)
    grid = sampled(evaluation)
    top = max(top_of(_ratios(f, grid), _ratios(f, evenly(evaluation)), max(limits)), 2 * max(limits))
    omega = refined(lambda w: in_window(_ratios(f, w), 0, top), grid)
    ratios = broken(_ratios(f, omega), omega, evaluation.unbounded)
    where = f"transparent{look.suffix}"
    found = evaluation.transparent
    spans = bars(ax, found, look, scale, where) if look.number else shade(ax, found, scale, where)
    thresholds = _draw_thresholds(ax, limits)
    lines = [
        line
        for values, part in zip(ratios.T, Part, strict=True)
        for line in _draw_curve(ax, scale.of(omega), values, look, part)
    ]
    limit(ax, _span(evaluation, scale), (0, top), number=look.number)
    dress(ax)
    name_frequency(ax, scale)
    ax.set_ylabel(r"ratio to $|H_\mathrm{env}|$", fontsize=TEXT)
    dots = _mark_crossings(ax, evaluation, look, scale)
    label_above(ax, _frequency_labels(evaluation, scale, omega, ratios.max(axis=1), top), look.color)
    shown = spans[:1] or [entry(f"nowhere transparent{look.suffix}")]
    legend(ax, [*lines, *thresholds, *shown, *dots, *_counted(evaluation, look)], lines=1)
    return lines


def _span(evaluation: Evaluation, scale: Scale) -> tuple[float, float]:
    low, high = band_of(evaluation)
    return scale.of(low), scale.of(high)


def _draw_curve(ax: Axes, at: Array, values: Array, look: Look, part: Part) -> list[Line2D]:
    style = SOLID if part is Part.REAL else DASHED
    return ax.plot(at, values, color=look.color, linewidth=1.1, linestyle=style, label=f"{_NAMES[part]}{look.suffix}")


def _draw_thresholds(ax: Axes, limits: Sequence[float]) -> list[Line2D]:
    """The thresholds that are not drawn yet; entries of them all."""
    names = (r"c_\mathrm{r}", r"c_\mathrm{i}") if len(set(limits)) > 1 else ("c",)
    made = []
    for name, c, style in zip(names, limits, (SOLID, DASHED), strict=False):
        label = f"${name} = {c:.3g}$"
        if label not in entries(ax):
            made.append(ax.axhline(c, color=GREY, linewidth=0.6, linestyle=style, label=label))
    return made


def _ratios(f: Callable[..., Values], omega: Array) -> Array:
    values = f(omega)
    return np.stack([values.ratio_real, values.ratio_imag], axis=1)


def _mark_crossings(ax: Axes, evaluation: Evaluation, look: Look, scale: Scale) -> list[Line2D]:
    """A dot where r_r, a ring where r_i meets its threshold."""
    made: list[Line2D] = []
    for part, c, face in zip(Part, limits_of(evaluation), (look.color, "white"), strict=True):
        omega = [scale.of(float(crossing.omega)) for crossing in evaluation.crossings if crossing.part is part]
        if not omega:  # an unclipped line without points would upset the layout
            continue
        made += ax.plot(
            omega, [c] * len(omega), linestyle="none", marker="o", markersize=3.6, color=look.color,
            markerfacecolor=face, markeredgewidth=0.8, zorder=4, clip_on=False, label=f"{_NAMES[part]} crosses{look.suffix}",
        )  # fmt: skip
    return made


def _frequency_labels(
    evaluation: Evaluation, scale: Scale, omega: Array, highest: Array, top: float
) -> list[tuple[float, str]]:
    """What stands above the axes: crossing frequencies while they are few, and the two highest peaks that are cut."""
    crossings = [(scale.of(float(c.omega)), scale.digits(c.omega, 4)) for c in evaluation.crossings]
    values, at = np.where(np.isnan(highest), np.inf, highest), scale.of(omega)
    peaks = [(float(at[i]), f"{_height(values[i])} at {at[i]:.4g}") for i in _peaks(values, top)[:2]]
    return (crossings if len(crossings) <= MOST_LABELS else []) + peaks


def _peaks(values: Array, top: float) -> list[int]:
    """Of each run of samples above the top the highest, the highest of all first."""
    runs = [list(run) for above, run in groupby(range(len(values)), key=lambda i: bool(values[i] > top)) if above]
    return sorted((max(run, key=lambda i: values[i]) for run in runs), key=lambda i: -values[i])


def _height(value: float) -> str:
    return "∞" if np.isinf(value) else number(value, 2 if value < 100 else 3)


def _counted(evaluation: Evaluation, look: Look) -> list[Line2D]:
    count = len(evaluation.crossings)
    return [entry(f"{count} crossings{look.suffix}")] if count > MOST_LABELS else []
