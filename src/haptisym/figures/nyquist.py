"""How: H_env and H_perc in the complex plane (the paper's Fig. 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.evaluation import Evaluation
from haptisym.numeric.values import Array, Values

from .sampling import band_of, broken, evenly, in_window, poles_of, refined, sampled
from .style import BLUE, CURVES, GREY, INK, curve_handles, dress, legend, name_dynamics


def draw_nyquist(ax: Axes, evaluation: Evaluation, marks: Sequence[float] | None = None) -> None:
    """H_env and H_perc in the complex plane over the band (the paper's Fig. 6), with arrows towards higher frequencies.

    ``marks``: frequencies, rad/s, marked alike on both curves; about a third, two thirds and the end of the band if not
    given. Where a dynamics is infinite, or far from where it is on most of the band, its curve leaves the axes.
    """
    f, grid = evaluation.distortion.compile(), sampled(evaluation)
    low, high = _window(responses(f, grid), responses(f, evenly(evaluation)))
    omega = refined(lambda w: in_window(responses(f, w), np.tile(low, 2), np.tile(high, 2)), grid)
    values = broken(responses(f, omega), omega, poles_of(evaluation))
    ax.axhline(0, color=GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=GREY, linewidth=0.4, zorder=0)
    marked = np.asarray(_default_marks(evaluation, f, (low, high)) if marks is None else marks, dtype=float)
    for points, (color, style, _), share in zip(_points(values), CURVES, (0.42, 0.58), strict=True):
        ax.plot(*points.T, color=color, linestyle=style, linewidth=1.1)
        length = _visible_length((points - low) / (high - low))
        for tail, head in _directions(length, np.interp(marked, omega, length), share):
            arrow(ax, points[tail], points[head], color)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    width, height = high - low
    if 0.25 < width / height < 4:
        ax.set_aspect("equal", adjustable="box")
    dress(ax)
    name_dynamics(ax.xaxis, r"\mathrm{Re}\,H", evaluation)
    name_dynamics(ax.yaxis, r"\mathrm{Im}\,H", evaluation)
    legend(ax, [*curve_handles("", ""), *_mark_frequencies(ax, f, marked)])


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


def arrow(ax: Axes, tail: Array, head: Array, color: str) -> None:
    head_style = "-|>, head_length=0.65, head_width=0.27"
    style = {"arrowstyle": head_style, "color": color, "linewidth": 0, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(head[0], head[1]), xytext=(tail[0], tail[1]), arrowprops=style)


def _default_marks(evaluation: Evaluation, f: Callable[..., Values], window: tuple[Array, Array]) -> tuple[float, ...]:
    """About a third, two thirds and the end of the frequencies at which both curves are on the axes, as short numbers."""
    low, high = band_of(evaluation)
    omega = evenly(evaluation)
    places = in_window(responses(f, omega), np.tile(window[0], 2), np.tile(window[1], 2))
    inside = omega[(np.abs(places - 0.5) <= 0.5).all(axis=1)]
    step = 10.0 ** (np.floor(np.log10(high - low)) - 1)
    chosen = inside[[round(share * (len(inside) - 1)) for share in (1 / 3, 2 / 3, 1)]]
    rounded = np.minimum(np.round(chosen / step), np.floor(inside[-1] / step + 1e-9)) * step
    return tuple(dict.fromkeys(max(low, float(f"{x:.12g}")) for x in rounded))


def _mark_frequencies(ax: Axes, f: Callable[..., Values], marks: Array) -> list[Line2D]:
    """The same marker on both curves at each frequency, and what the legend says of it."""
    handles = []
    for omega, marker in zip(marks, "osDv^*" * len(marks), strict=False):
        look: dict[str, Any] = {"marker": marker, "markersize": 4.2, "markeredgewidth": 0.9, "linestyle": "none"}
        for [point], (color, _, _), face in zip(
            _points(responses(f, np.array([omega]))), CURVES, (BLUE, "white"), strict=True
        ):
            ax.plot(*point, color=color, markerfacecolor=face, zorder=4, **look)
        handles.append(Line2D([], [], color=INK, markerfacecolor="none", label=f"{omega:g} rad/s", **look))
    return handles
