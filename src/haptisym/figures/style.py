"""What figures share: one column of a journal, thin lines, labels that do not meet, legends above the axes, files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator, ScalarFormatter
from matplotlib.transforms import ScaledTranslation

from haptisym.evaluation import Evaluation
from haptisym.exact.roots import Interval
from haptisym.jnd import Part
from haptisym.numeric.values import Array
from haptisym.quantities import Motion

from .kinds import UNDATED, checked
from .sampling import ends_of

WIDTH = 3.4
"""Inches: one column of a journal."""
TEXT, SMALL = 8.0, 7.0
"""Points: labels of axes; ticks, legends and notes."""
INK, BLUE, RED, GREY, SHADE = "#222222", "#1f4e9e", "#c03028", "#7a7a7a", "#e6e6e6"
SOLID: Any = "-"
DASHED: Any = (0, (4, 1.6))
DOTTED: Any = (0, (1, 2))
LEADER = {"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "shrinkA": 0, "shrinkB": 0}
CURVES = ((BLUE, SOLID, r"H_\mathrm{env}"), (RED, DASHED, r"H_\mathrm{perc}"))
FREQUENCY = r"$\omega$ (rad/s)"
FULL_NAMES = {Part.REAL: "real", Part.IMAG: "imaginary"}
MOST_LABELS, MOST_NUMBERS = 4, 8


def dress(ax: Axes) -> None:
    """Thin lines, no box, few and plain numbers."""
    ax.tick_params(labelsize=SMALL, width=0.5, length=2.5, color=GREY)
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(linewidth=0.5, color=GREY)
    for axis in (ax.xaxis, ax.yaxis):
        plain = ScalarFormatter(useOffset=False)
        plain.set_scientific(False)
        axis.set_major_formatter(plain)
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))


def name_dynamics(axis: Axis, name: str, evaluation: Evaluation) -> None:
    """The label of an axis of force per position, in thousands or millions of its unit where numbers are large."""
    most = np.abs(axis.get_view_interval()).max()
    factor, prefix = next(((f, p) for f, p in ((1e6, "M"), (1e3, "k")) if most >= 100 * f), (1.0, ""))
    unit = "N·m/rad" if evaluation.scene.motion is Motion.ROTATION else "N/m"
    axis.set_label_text(f"${name}$ ({prefix}{unit})", fontsize=TEXT)
    if prefix:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:g}".replace("-", "−")))


def shade(ax: Axes, intervals: Iterable[Interval]) -> None:
    for low, high in map(ends_of, intervals):
        if low == high:
            ax.axvline(low, color=SHADE, linewidth=1, zorder=0)
        else:
            ax.axvspan(low, high, facecolor=SHADE, linewidth=0, zorder=0)


def label_above(ax: Axes, labels: Iterable[tuple[float, str]]) -> None:
    """Texts side by side on top of the axes, each tied to its frequency."""
    ordered = sorted(labels)
    places = _spread([_share(ax, x) for x, _ in ordered], [text_width(ax, text) for _, text in ordered])
    for (x, text), place in zip(ordered, places, strict=True):
        ax.axvline(x, color=GREY, linewidth=0.5, linestyle=DOTTED, zorder=1)
        ax.annotate(
            text, xy=(_share(ax, x), 1), xytext=(place, 1.05), xycoords="axes fraction", textcoords="axes fraction",
            ha="center", va="bottom", fontsize=SMALL, arrowprops=LEADER,
        )  # fmt: skip


def _spread(centres: Sequence[float], widths: Sequence[float]) -> Array:
    """Places near the wanted ones, in the same order, at which labels of these widths stand side by side within 0 to 1.

    >>> _spread([0.1, 0.5, 0.52], [0.1, 0.1, 0.1]).round(2).tolist()
    [0.1, 0.46, 0.56]
    """
    offsets = np.cumsum(widths) - np.asarray(widths) / 2
    free = np.asarray(centres) - offsets
    free = (np.maximum.accumulate(free) + np.minimum.accumulate(free[::-1])[::-1]) / 2
    return np.clip(free, 0, max(0.0, 1 - sum(widths))) + offsets


def _share(ax: Axes, x: float) -> float:
    """Where a frequency is on the axes, from 0 to 1."""
    low, high = ax.get_xlim()
    return (x - low) / (high - low)


def text_width(ax: Axes, text: str) -> float:
    """About the width of a small text with a margin, as a fraction of the axes."""
    return (0.54 * max(map(len, text.split("\n"))) + 0.7) * em(ax)


def em(ax: Axes) -> float:
    """The size of a small text, as a fraction of the width of the axes."""
    return SMALL * ax.figure.dpi / (72 * ax.bbox.width)


def legend(ax: Axes, handles: Sequence[Line2D | Patch], *, lines: int = 0) -> None:
    """The legend above the axes, where no curve is, and above that many lines of other text."""
    raised = ScaledTranslation(0, (0.5 + 1.9 * lines) * SMALL / 72, ax.figure.dpi_scale_trans)
    ax.legend(
        handles=handles, ncols=_columns(ax, handles), loc="lower left", bbox_to_anchor=(0, 1),
        bbox_transform=ax.transAxes + raised, borderaxespad=0, borderpad=0, fontsize=SMALL, frameon=False,
        handlelength=2.2, handletextpad=0.5, columnspacing=1.2, labelspacing=0.3,
    )  # fmt: skip


def _columns(ax: Axes, handles: Sequence[Line2D | Patch]) -> int:
    """The most columns of a legend that together are no wider than the axes."""
    widths = [text_width(ax, _as_seen(str(handle.get_label()))) + 3.2 * em(ax) for handle in handles]
    for columns in range(len(handles), 1, -1):
        if sum(max(column) for column in np.array_split(widths, columns)) - 1.2 * em(ax) <= 1.05:
            return columns
    return 1


def _as_seen(label: str) -> str:
    """A label without the marks of its mathematics."""
    return re.sub(r"\\[a-z]+|[\\${}_,]", "", label)


def curve_handles(before: str, after: str) -> list[Line2D]:
    return [handle(color, style, f"${before}{name}{after}$") for color, style, name in CURVES]


def handle(color: str, style: Any, label: str, width: float = 1.1, **marker: Any) -> Line2D:
    return Line2D([], [], color=color, linestyle=style, linewidth=width, label=label, **marker)


def entry(label: str) -> Line2D:
    """A legend entry of words alone."""
    return handle(INK, "none", label)


def save(stem: Path, figure: Figure, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """The figure as SVG, PDF and PNG, or as some of them."""
    return [save_as(figure, stem.with_name(f"{stem.name}{kind}")) for kind in kinds]


def save_as(figure: Figure, path: str | Path) -> Path:
    """The figure in one file, as its ending says, the same file for the same figure; SceneError for any other ending."""
    target = checked(path)
    with mpl.rc_context({"svg.hashsalt": "haptisym", "pdf.fonttype": 42}):
        figure.savefig(target, metadata=dict(UNDATED[target.suffix.lower()]), dpi=400)
    return target


def one_column(height: float, draw: Callable[[Axes], None]) -> Figure:
    """A drawing of that height, in inches, without its legend; one with equal scales takes the height that it needs."""
    figure = Figure(figsize=(WIDTH, height), layout="compressed")
    ax = figure.add_subplot()
    draw(ax)
    figure.draw_without_rendering()
    if ax.get_aspect() == 1:
        height = min(0.7 + 2.8 * ax.get_data_ratio(), 3.6)
    figure.set_figheight(height + _legend_height(ax))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once, so that all files look the same
    return figure


def _legend_height(ax: Axes) -> float:
    legend = ax.get_legend()
    return legend.get_window_extent().height / ax.figure.dpi if legend else 0.0


def plate(color: str) -> dict[str, Any]:
    """What keeps a text readable on a curve."""
    return {"facecolor": color, "edgecolor": "none", "pad": 0.6}


def write_note(ax: Axes, text: str) -> None:
    ax.text(0.5, 0.97, text, transform=ax.transAxes, ha="center", va="top", fontsize=SMALL, bbox=plate(SHADE))
