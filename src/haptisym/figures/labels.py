"""What is marked along an axis of frequencies: bands, and labels above it, each tied to its place, that do not meet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation

from haptisym.figures import pen
from haptisym.figures.sampling import ends_of
from haptisym.figures.scales import RADIANS, Scale
from haptisym.figures.style import Look, text_width
from haptisym.kernel.roots import Interval
from haptisym.programs.values import Array

_ABOVE = "_above"
"""The mark of labels above the axes, by which those of a scene drawn before are found."""


def mark_bands(ax: Axes, intervals: Iterable[Interval], look: Look, scale: Scale, label: str) -> Sequence[Artist]:
    """Some bands of a scene: a grey ground, or bars at the top for a further one; the first bears the label."""
    label = f"{label}{look.suffix}"
    return bars(ax, intervals, look, scale, label) if look.number else shade(ax, intervals, scale, label)


def shade(ax: Axes, intervals: Iterable[Interval], scale: Scale = RADIANS, label: str = "") -> list[Patch]:
    """Grey bands at some frequencies; the first one bears the label."""
    made: list[Patch] = []
    for low, high in (scale.of(np.array(ends_of(x))) for x in intervals):
        if low == high:
            ax.axvline(low, color=pen.SHADE, linewidth=1, zorder=0)
        else:
            made.append(ax.axvspan(low, high, facecolor=pen.SHADE, linewidth=0, zorder=0))
    if made and label:
        made[0].set_label(label)
    return made


def bars(ax: Axes, intervals: Iterable[Interval], look: Look, scale: Scale, label: str) -> list[Line2D]:
    """The bands of a further scene as bars of its colour at the top of the axes, each scene below the one before."""
    made: list[Line2D] = []
    for ends in (scale.of(np.array(ends_of(x))) for x in intervals):
        place = [0.985 - 0.03 * look.number] * 2
        made += ax.plot(
            ends, place, color=look.color, transform=ax.get_xaxis_transform(), zorder=1, linewidth=2.5, alpha=0.6,
            solid_capstyle="butt",
        )  # fmt: skip
    if made:
        made[0].set_label(label)
    return made


def label_above(ax: Axes, labels: Iterable[tuple[float, str]], color: str = pen.INK) -> None:
    """Texts side by side on top of the axes, each tied to its place; those that are there already move for new ones.

    Where they have no room beside each other, only those that were there first stay.
    """
    before = [x for x in ax.texts if isinstance(x, Annotation) and x.get_label() == _ABOVE]
    rows = [(float(x.xy[0]), x.get_text(), str(x.get_color())) for x in before]
    new = [(x, text, color) for x, text in labels]
    if rows and sum(text_width(ax, text) for _, text, _ in [*rows, *new]) > 1:
        new = []
    for old in before:
        old.remove()
    for x, _, ink in new:
        ax.axvline(x, color=pen.GREY if ink == pen.INK else ink, linewidth=0.5, linestyle=pen.DOTTED, zorder=1)
    ordered = sorted([*rows, *new])
    places = spread([share_of(ax, x) for x, _, _ in ordered], [text_width(ax, text) for _, text, _ in ordered])
    for (x, text, ink), place in zip(ordered, places, strict=True):
        ax.annotate(
            text, xy=(x, 1), xytext=(place, 1.05), xycoords=ax.get_xaxis_transform(), textcoords="axes fraction",
            ha="center", va="bottom", fontsize=pen.SMALL, color=ink, arrowprops=pen.LEADER, label=_ABOVE,
        )  # fmt: skip


def spread(centres: Sequence[float], widths: Sequence[float]) -> Array:
    """Places near the wanted ones, in the same order, at which labels of these widths stand side by side within 0 to 1.

    >>> spread([0.1, 0.5, 0.52], [0.1, 0.1, 0.1]).round(2).tolist()
    [0.1, 0.46, 0.56]
    """
    offsets = np.cumsum(widths) - np.asarray(widths) / 2
    free = np.asarray(centres) - offsets
    free = (np.maximum.accumulate(free) + np.minimum.accumulate(free[::-1])[::-1]) / 2
    return np.clip(free, 0, max(0.0, 1 - sum(widths))) + offsets


def share_of(ax: Axes, x: float) -> float:
    """Where a frequency is on the axes, from 0 to 1."""
    low, high = ax.get_xlim()
    return (x - low) / (high - low)
