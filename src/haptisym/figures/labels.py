"""Labels above the axes, each tied to its place, that do not meet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation

from haptisym.figures.style import DOTTED, GREY, INK, LEADER, SMALL, text_width
from haptisym.programs.values import Array

_ABOVE = "_above"
"""The mark of labels above the axes, by which those of a scene drawn before are found."""


def label_above(ax: Axes, labels: Iterable[tuple[float, str]], color: str = INK) -> None:
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
    for x, _, shade in new:
        ax.axvline(x, color=GREY if shade == INK else shade, linewidth=0.5, linestyle=DOTTED, zorder=1)
    ordered = sorted([*rows, *new])
    places = _spread([_share(ax, x) for x, _, _ in ordered], [text_width(ax, text) for _, text, _ in ordered])
    for (x, text, shade), place in zip(ordered, places, strict=True):
        ax.annotate(
            text, xy=(x, 1), xytext=(place, 1.05), xycoords=ax.get_xaxis_transform(), textcoords="axes fraction",
            ha="center", va="bottom", fontsize=SMALL, color=shade, arrowprops=LEADER, label=_ABOVE,
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
