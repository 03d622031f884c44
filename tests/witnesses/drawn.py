"""What a reader sees of a chart, from the artists on its axes: places of lines, grounds, hatches, words, and texts that collide."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text


def axes(wide: float = 5, high: float = 4) -> Axes:
    return Figure(figsize=(wide, high)).add_subplot()


def told(ax: Axes) -> list[str]:
    """The entries of the legend."""
    return [x.get_text() for x in ax.get_legend().get_texts()] if ax.get_legend() else []


def at_curves(ax: Axes) -> dict[str, tuple[float, float]]:
    """The names that stand at curves, and the points of these beside which they do."""
    return {x.get_text(): x.xy for x in ax.texts if isinstance(x, Annotation) and ".name." in str(x.get_gid())}


def places(line: Any) -> tuple[np.ndarray, np.ndarray]:
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def points(line: Any) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in zip(*places(line), strict=True)]


def shown(line: Any) -> tuple[np.ndarray, np.ndarray]:
    """The places at which a line is: without its gaps."""
    x, y = places(line)
    return x[np.isfinite(y)], y[np.isfinite(y)]


def curves(ax: Axes) -> list[Line2D]:
    """The sampled lines, not the straight ones."""
    return [x for x in ax.lines if len(x.get_xdata()) > 100]


def marked(ax: Axes, *markers: str) -> list[Line2D]:
    return [x for x in ax.lines if x.get_marker() in markers]


def spans(patches: Iterable[Any]) -> list[tuple[float, float]]:
    """From where to where bands or bars go."""
    return [(x.get_x(), x.get_x() + x.get_width()) for x in patches]


def filled(ax: Axes, color: str) -> list[tuple[float, ...]]:
    """Left, bottom, right and top of what has a colour."""
    found = [c for c in ax.collections if len(c.get_facecolor()) and to_hex(c.get_facecolor()[0]) == color]
    return sorted(tuple(map(float, p.get_extents().extents)) for c in found for p in c.get_paths())


def hatched(ax: Axes) -> list[tuple[float, ...]]:
    return sorted(tuple(map(float, c.get_paths()[0].get_extents().extents)) for c in ax.collections if c.get_hatch())


def words(ax: Axes) -> list[str]:
    """What stands on the axes, in their title, at their sides and in the legend; lines of one text joined."""
    every = [*(x.get_text() for x in (*ax.texts, ax.title, ax.xaxis.label, ax.yaxis.label)), *told(ax)]
    return [x.replace("\n", " ") for x in every if x]


def texts(figure: Figure) -> list[Text]:
    """What can be read, once the figure is drawn; labels of ticks beyond the ends of an axis cannot."""
    hidden = {id(x) for ax in figure.findobj(Axes) for x in _unseen(ax)}
    every = [x for x in figure.findobj(Text) if x.get_visible() and x.get_text().strip()]
    return [x for x in every if id(x) not in hidden]


def _unseen(ax: Axes) -> list[Text]:
    found: list[Text] = []
    for axis, interval in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
        low, high = sorted(interval)
        room = 1e-9 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            seen = ax.axison and low - room <= tick.get_loc() <= high + room
            found += [] if seen else [tick.label1, tick.label2]
        found += [] if ax.axison else [axis.label]
    return found


def overlaps(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that lie on each other, and texts that leave the figure beside nothing."""
    boxes = [(x.get_text(), Text.get_window_extent(x)) for x in texts(figure)]
    frame = figure.bbox
    found = [
        (text, "")
        for text, box in boxes
        if box.x0 < frame.x0 - 1 or box.y0 < frame.y0 - 1 or box.x1 > frame.x1 + 1 or box.y1 > frame.y1 + 1
    ]
    for (text, box), (other_text, other) in combinations(boxes, 2):
        wide = min(box.x1, other.x1) - max(box.x0, other.x0)
        high = min(box.y1, other.y1) - max(box.y0, other.y0)
        found += [(text, other_text)] if min(wide, high) >= 1.5 else []
    return found
