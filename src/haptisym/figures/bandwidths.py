"""How the bandwidth grows with the threshold, over the range of that: a curve with its jumps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from haptisym.figures import pen
from haptisym.figures.judged import columns, limit_of
from haptisym.figures.sampling import sampled
from haptisym.figures.style import Scale, dress, entries, handle, legend, number, scale_of
from haptisym.judge.bandwidths import Bandwidths
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import NothingToDrawError
from haptisym.programs.values import Array


def has_bandwidths(e: Evaluation) -> bool:
    """Whether one number with a range, a threshold or a scale, gives a range of bandwidths."""
    return e.bandwidths is not None and e.bandwidths.is_one_curve


def draw_bandwidths(
    ax: Axes, e: Evaluation, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Line2D]:
    """The bandwidth over the threshold: dots at the proven ends; at a jump a dot for what is reached, a ring for what is not.

    ``color``, ``label``, ``hertz`` : as of ``haptisym.figures.ratios.draw_ratios``. Returns the curve. NothingToDrawError where
    the threshold has no range, or several that move apart.

    >>> from haptisym import evaluate, load_scene
    >>> from matplotlib.figure import Figure
    >>> lines = draw_bandwidths(Figure().add_subplot(), evaluate(load_scene("fu2019").with_values({"c": "0.1 +- 20 %"})))
    >>> [float(round(y[0], 3)) for y in (lines[0].get_ydata(), lines[0].get_ydata()[::-1])]
    [6.534, 12.993]
    """
    if not has_bandwidths(e):
        raise NothingToDrawError("the JND has no one number with a range that gives a range of bandwidths")
    assert e.bandwidths
    own, suffix = color or pen.INK, f", {label}" if label else ""
    scale = scale_of(ax, e.scene.band, hertz=hertz)
    moving = _moving(e)
    low, high = moving.ends
    c, omega = _curve(e, e.bandwidths, moving)
    [line] = ax.plot(c, scale.of(omega), color=own, linewidth=1.1, label=f"bandwidth{suffix}")
    told = [line, *_jumps(ax, e.bandwidths, own, scale, moving.unit)]
    if e.bandwidth is not None:
        place = [moving.nominal], [scale.of(float(e.bandwidth))]
        ax.plot(*place, "s", color=own, markersize=4.5, markerfacecolor="white", zorder=4)
        told.append(handle(own, "none", f"nominal{suffix}", marker="s", markersize=4.5, markerfacecolor="white"))
    ends = [float(x) for x in (e.bandwidths.least, e.bandwidths.most) if x is not None]
    ax.plot([max(low, c[0]), high], scale.of(np.array(ends)), "o", color=own, markersize=3.6, zorder=3)
    ax.set_xlim(low - 0.03 * (high - low), high + 0.03 * (high - low))
    ax.set_ylim(bottom=0)
    dress(ax)
    ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: number(x)))
    ax.set_xlabel(moving.label, fontsize=pen.TEXT)
    ax.set_ylabel(f"bandwidth ({scale.unit})", fontsize=pen.TEXT)
    legend(ax, [*entries(ax).values(), *told])
    return [line]


class _Moving(NamedTuple):
    """What has a range, as it is drawn: a threshold in per cent, or a scale."""

    ends: tuple[float, float]
    nominal: float
    unit: float
    label: str


def _moving(e: Evaluation) -> _Moving:
    t = e.scene.threshold
    if "scale" in t.ranges:
        low, high = map(float, t.ranges["scale"])
        return _Moving((low, high), float(t.region.size), 1.0, "scale of the JND")
    low, high = (float(100 * x) for x in t.ranges["real"])
    return _Moving((low, high), float(100 * t.real), 100.0, "threshold $c$ (%)")


def _curve(e: Evaluation, found: Bandwidths, moving: _Moving) -> tuple[Array, Array]:
    """What moves, and bandwidth: where the larger ratio is higher than ever before; broken at the jumps."""
    omega = np.unique(np.concatenate([sampled(e), [float(x) for j in found.jumps for x in (j.low, j.high)]]))
    (low, high), nominal, unit, _ = moving
    limits = [limit_of(x) for x in e.criteria]
    ratio = nominal * (columns(e.criteria, e.distortion.compile()(omega), omega) / limits).max(axis=1)
    least, most = float(found.least or 0), float(found.most or 0)
    first = unit * float(next(iter(found.blocked.values()))) if found.blocked else low
    between = (omega > least) & (omega < most) & (ratio >= np.maximum.accumulate(np.nan_to_num(ratio)))
    inside = between & (ratio > first) & (ratio < high)
    for jump in found.jumps:
        inside &= (omega < float(jump.low)) | (omega > float(jump.high))  # its ends have rows of their own
    rows = [(first, 0, least), *((c, 0, w) for c, w in zip(ratio[inside], omega[inside], strict=True)), (high, 3, most)]
    for jump in found.jumps:
        at = unit * float(jump.threshold or 0)
        rows += [(at, 0, float(jump.low)), (at, 1, np.nan), (at, 2, float(jump.high))]
    ordered = sorted(rows, key=lambda row: row[:2])
    return np.array([c for c, _, _ in ordered]), np.array([w for _, _, w in ordered])


def _jumps(ax: Axes, found: Bandwidths, color: str, scale: Scale, unit: float) -> list[Line2D]:
    for jump in found.jumps:
        at = unit * float(jump.threshold or 0)
        low, high = (scale.of(float(x)) for x in (jump.low, jump.high))
        ax.plot([at, at], [low, high], color=pen.GREY, linewidth=0.6, linestyle=pen.DOTTED, zorder=1)
        ax.plot([at], [low], "o", color=color, markersize=3.6, markerfacecolor="white", zorder=3)
        ax.plot([at], [high], "o", color=color, markersize=3.6, zorder=3)
    return [handle(pen.GREY, pen.DOTTED, "jump at a peak of the ratio", width=0.6)] if found.jumps else []
