"""When: the ratios r_r and r_i over the band (the paper's Fig. 5)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.judged import columns, is_share, limit_of, name_of
from haptisym.figures.sampling import band_of, broken, evenly, in_window, refined, sampled, top_of
from haptisym.figures.style import (
    MOST_LABELS,
    Look,
    Scale,
    dots,
    dress,
    entries,
    entry,
    label_above,
    legend,
    limit,
    mark_bands,
    number,
    scale_of,
)
from haptisym.judge.crossings import Criterion
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.peaks import Peaks
from haptisym.programs.values import Array
from haptisym.verbs.evaluate.entry import evaluate

if TYPE_CHECKING:
    from haptisym.verbs.derive.derivation import Derivation


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
    first = name_of(evaluation.criteria[0])
    look, scale = Look.on(ax, first, color, label), scale_of(ax, evaluation.scene.band, hertz=hertz)
    criteria, f = evaluation.criteria, evaluation.distortion.compile()
    limits = [limit_of(x) for x in criteria]

    def judged(omega: Array) -> Array:
        return columns(criteria, f(omega), omega)

    grid = sampled(evaluation)
    top = max(top_of(judged(grid), judged(evenly(evaluation)), max(limits)), 2 * max(limits))
    omega = refined(lambda w: in_window(judged(w), 0, top), grid)
    ratios = broken(judged(omega), omega, evaluation.unbounded)
    spans = mark_bands(ax, evaluation.transparent, look, scale, "transparent")
    thresholds = _draw_thresholds(ax, limits, shares=any(map(is_share, criteria)))
    lines: list[Line2D] = []
    for values, x, stroke in zip(ratios.T, criteria, pen.STROKES, strict=False):
        label = f"{name_of(x)}{look.suffix}"
        lines += ax.plot(scale.of(omega), values, color=look.color, linewidth=1.1, linestyle=stroke, label=label)
    limit(ax, _span(evaluation, scale), (0, top), number=look.number)
    dress(ax, scale.label, _judged(criteria))
    marks = _mark_crossings(ax, evaluation, look, scale)
    label_above(ax, _frequency_labels(evaluation, scale, omega, ratios.max(axis=1), top), look.color)
    shown = spans[:1] or [entry(f"nowhere transparent{look.suffix}")]
    legend(ax, [*lines, *thresholds, *shown, *marks, *_counted(evaluation, look)], lines=1)
    return lines


def draw_formulas(ax: Axes, found: Derivation, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The ratios that the formulas give with the scene's values. Returns the lines."""
    return draw_ratios(ax, evaluate(found.scene), color=color, label=label)


def draw_peaks(ax: Axes, found: Peaks, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The ratios over the band, and a triangle at each of their local maxima. Returns the lines of the ratios."""
    look, scale = Look.on(ax, "peaks", color, label), scale_of(ax, found.scene.band)
    lines = draw_ratios(ax, evaluate(found.scene), color=color, label=label)
    at = [(scale.of(float(x.omega)), float(x.ratio)) for x in found]
    if at:
        x, y = zip(*at, strict=True)
        legend(ax, ax.plot(x, y, "v", color=look.color, markersize=4, zorder=5, label=f"peaks{look.suffix}"), lines=1)
    return lines


def _span(evaluation: Evaluation, scale: Scale) -> tuple[float, float]:
    low, high = band_of(evaluation)
    return scale.of(low), scale.of(high)


def _judged(criteria: Sequence[Criterion]) -> str:
    """What the axis says of ratios and of multiples of limits."""
    shares = [is_share(x) for x in criteria]
    fraction, multiple = r"ratio to $|H_\mathrm{env}|$", "multiple of the limit"
    return multiple if all(shares) else f"{fraction}, or {multiple}" if any(shares) else fraction


def _draw_thresholds(ax: Axes, limits: Sequence[float], *, shares: bool) -> list[Line2D]:
    """The thresholds that are not drawn yet; entries of them all."""
    names = (r"c_\mathrm{r}", r"c_\mathrm{i}") if len(set(limits)) > 1 else ("c",)
    made = []
    for name, c, style in zip(names, limits, (pen.SOLID, pen.DASHED), strict=False):
        label = "limit" if shares and c == 1 else f"${name} = {c:.3g}$"
        if label not in entries(ax):
            made.append(ax.axhline(c, color=pen.GREY, linewidth=0.6, linestyle=style, label=label))
    return made


def _mark_crossings(ax: Axes, evaluation: Evaluation, look: Look, scale: Scale) -> list[Line2D]:
    """A dot where the first ratio, a ring where the other meets its threshold."""
    made: list[Line2D] = []
    for x, face in zip(evaluation.criteria, (look.color, "white"), strict=False):
        omega = [scale.of(float(crossing.omega)) for crossing in evaluation.crossings if crossing.criterion == x]
        if not omega:  # an unclipped line without points would upset the layout
            continue
        made += ax.plot(
            omega, [limit_of(x)] * len(omega), color=look.color, zorder=4, clip_on=False,
            label=f"{name_of(x)} crosses{look.suffix}", **dots(3.6, markerfacecolor=face, markeredgewidth=0.8),
        )  # fmt: skip
    return made


def _frequency_labels(
    evaluation: Evaluation, scale: Scale, omega: Array, highest: Array, top: float
) -> list[tuple[float, str]]:
    """What stands above the axes: crossing frequencies while they are few, and the two highest peaks that are cut."""
    crossings = [(scale.of(float(c.omega)), scale.digits(c.omega, 4)) for c in evaluation.crossings]
    values, at = np.where(np.isnan(highest), np.inf, highest), scale.of(omega)
    peaks = [
        (float(at[i]), f"{_height(values[i])} at {number(at[i], 4 if at[i] < 1e4 else 6)}")
        for i in _peaks(values, top)[:2]
    ]
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
