"""How: H_env and H_perc in the complex plane (the paper's Fig. 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.sampling import band_of, broken, evenly, in_window, poles_of, refined, sampled
from haptisym.figures.style import (
    Look,
    Scale,
    band_scale,
    curve_handles,
    curves,
    dots,
    draw_origin,
    dress_plane,
    entries,
    handle,
    keep_scales,
    legend,
    limit,
    number,
)
from haptisym.judge.evaluation import Evaluation
from haptisym.programs.values import Array, Values


def draw_nyquist(
    ax: Axes,
    evaluation: Evaluation,
    marks: Sequence[float] | None = None,
    *,
    color: str | None = None,
    label: str = "",
) -> list[Line2D]:
    """H_env and H_perc in the complex plane over the band (the paper's Fig. 6), with arrows towards higher frequencies.

    ``marks``: frequencies, rad/s, marked alike on both curves; about a third, two thirds and the end of the band if not
    given, and none for a further scene on the same axes. Where a dynamics is infinite, or far from where it is on most of the
    band, its curve leaves the axes.
    ``color``, ``label`` : of the scene: both curves are drawn in the one, their entries in the legend end with the other.
    Returns the curves of H_env and H_perc.

    >>> from haptisym import evaluate, load_scene
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> scene = load_scene("fu2019")
    >>> for omega_n in (80, 40):
    ...     lines = draw_nyquist(ax, evaluate(scene.with_values({"omega_n": omega_n})), label=f"{omega_n} rad/s")
    >>> [line.get_linestyle() for line in lines]
    ['-', '--']
    """
    look = Look.on(ax, "$H_\\mathrm{env}$", color, label)
    f, grid = evaluation.distortion.compile(), sampled(evaluation)
    low, high = _window(responses(f, grid), responses(f, evenly(evaluation)))
    omega = refined(lambda w: in_window(responses(f, w), np.tile(low, 2), np.tile(high, 2)), grid)
    values = broken(responses(f, omega), omega, poles_of(evaluation))
    if not look.number:
        draw_origin(ax)
    chosen = marks if marks is not None else () if look.number else _default_marks(evaluation, f, (low, high))
    marked, lines = np.asarray(chosen, dtype=float), list[Line2D]()
    for points, (colour, style, _), share in zip(_points(values), curves(look), (0.42, 0.58), strict=True):
        lines += ax.plot(*points.T, color=colour, linestyle=style, linewidth=1.1)
        length = _visible_length((points - low) / (high - low))
        for tail, head in _directions(length, np.interp(marked, omega, length), share):
            arrow(ax, points[tail], points[head], colour)
    limit(ax, (low[0], high[0]), (low[1], high[1]), number=look.number)
    keep_scales(ax)
    dress_plane(ax, evaluation.scene)
    handles = curve_handles(look)
    for line, one in zip(lines, handles, strict=True):
        line.set_label(str(one.get_label()))
    directions = [handle(pen.INK, "none", "rising frequency", marker=">", markersize=4.2)] if ax.texts else []
    marking = _mark_frequencies(ax, f, marked, look, band_scale(evaluation.scene.band))
    legend(ax, [*handles, *directions, *marking])
    return lines


def responses(f: Callable[..., Values], omega: Array) -> Array:
    """Re and Im of H_env, then of H_perc, in four columns."""
    values = f(omega)
    return np.stack(
        [values.environment_real, values.environment_imag, values.perceived_real, values.perceived_imag], axis=1
    )


def _points(responses: Array) -> tuple[Array, Array]:
    """H_env and H_perc as points of the plane."""
    return responses[:, :2], responses[:, 2:]


def _window(everywhere: Array, evenly: Array) -> tuple[Array, Array]:
    """The lower left and upper right corner that hold both curves, but for excursions far from most of the band."""
    reached, common = (points[np.isfinite(points).all(axis=1)] for points in map(stacked, (everywhere, evenly)))
    first, last = np.quantile(common, (0.05, 0.95), axis=0)
    least, most, span = reached.min(axis=0), reached.max(axis=0), last - first
    far = 4 * span.max()
    low, high = np.where(least < first - far, first - span, least), np.where(most > last + far, last + span, most)
    size = np.maximum(high - low, 0.1 * (np.max(high - low) or np.abs(low).max() or 1.0))
    middle = (low + high) / 2
    return middle - 0.56 * size, middle + 0.56 * size


def stacked(responses: Array) -> Array:
    """The points of both curves, those of H_env first."""
    return np.concatenate(_points(responses))


def _visible_length(points: Array) -> Array:
    """The length of a curve, given in fractions of the axes, from its start to each sample, as far as it is on them."""
    visible: Any = (np.abs(points - 0.5) <= 0.5).all(axis=1)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(np.where(visible[1:] & visible[:-1], steps, 0.0))])


def _directions(length: Array, marked: Array, share: float) -> list[tuple[int, int]]:
    """Tail and head samples of arrows in the two longest pieces of a curve between its marks; none on mere spots."""
    edges = np.unique([0.0, *marked, length[-1]])
    longest = np.argsort(np.diff(edges))[-2:]
    heads = [edges[i] + share * (edges[i + 1] - edges[i]) for i in longest if edges[i + 1] - edges[i] > 0.1]
    return [(int(np.searchsorted(length, head - 0.01)) - 1, int(np.searchsorted(length, head))) for head in heads]


HEAD = 6.5
"""Points: the length of an arrow's head."""


def arrow(ax: Axes, tail: Array, head: Array, color: str) -> None:
    """An arrowhead on a curve."""
    head_style = f"-|>, head_length={HEAD / 10}, head_width=0.27"
    style = {"arrowstyle": head_style, "color": color, "linewidth": 0, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=style)


def _default_marks(evaluation: Evaluation, f: Callable[..., Values], window: tuple[Array, Array]) -> tuple[float, ...]:
    """About a third, two thirds and the end of the frequencies at which both curves are on the axes, as short numbers."""
    factor = band_scale(evaluation.scene.band).factor
    low, high = (x / factor for x in band_of(evaluation))
    omega = evenly(evaluation)
    places = in_window(responses(f, omega), np.tile(window[0], 2), np.tile(window[1], 2))
    inside = omega[(np.abs(places - 0.5) <= 0.5).all(axis=1)]
    step = 10.0 ** (np.floor(np.log10(high - low)) - 1)
    inside = inside / factor
    chosen = inside[[round(share * (len(inside) - 1)) for share in (1 / 3, 2 / 3, 1)]]
    rounded = np.minimum(np.round(chosen / step), np.floor(inside[-1] / step + 1e-9)) * step
    return tuple(dict.fromkeys(max(low, float(f"{x:.12g}")) * factor for x in rounded))


def _mark_frequencies(ax: Axes, f: Callable[..., Values], marks: Array, look: Look, scale: Scale) -> list[Line2D]:
    """The same marker on both curves at each frequency, filled on H_env, and what the legend says of it."""
    handles, told = [], entries(ax)
    free = [
        marker
        for marker in "osDv^*phPX"
        if marker not in {str(x.get_marker()) for x in told.values() if isinstance(x, Line2D)}
    ]
    for omega, marker in zip(marks, free * len(marks), strict=False):
        label = f"{number(scale.of(omega))} {scale.unit}"
        shape = told[label].get_marker() if label in told else marker
        style = dots(4.2, str(shape), markeredgewidth=0.9)
        colours = [colour for colour, _, _ in curves(look)]
        for [point], colour, face in zip(
            _points(responses(f, np.array([omega]))), colours, (colours[0], "white"), strict=True
        ):
            ax.plot(*point, color=colour, markerfacecolor=face, zorder=4, **style)
        handles.append(Line2D([], [], color=pen.INK, markerfacecolor="none", label=label, **style))
    return handles
