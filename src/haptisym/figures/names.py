"""Names beside points that meet neither each other, nor points, lines or the edge of the axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from haptisym.programs.values import Array

_WIDE, _HIGH = 0.51, 0.95
"""Of a letter, and of a line, in sizes of the font."""
_MARK = 3.0  # half of a point's width, pt
_NEAR, _FAR = 5.0, 14.0  # pt from a point to its name
_OUTSIDE, _MET, _DOUBTFUL, _CROSSED, _LONG = 50.0, 20.0, 12.0, 8.0, 0.35
"""What a place costs: to leave the axes, to meet something, to seem another point's, to be crossed by a line; per pt away."""

Box = tuple[float, float, float, float]
"""Left, bottom, right, top, in points of the page."""


@dataclass
class Room:
    """What is on the axes already: boxes, and points of lines, in points of the page."""

    ax: Axes
    boxes: list[Box] = field(default_factory=list)
    lines: list[Array] = field(default_factory=list)
    points: list[tuple[float, float]] = field(default_factory=list)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """A place of the data, in points of the page."""
        found = self._on_page([x], [y])
        return float(found[0, 0]), float(found[0, 1])

    def _on_page(self, x: Sequence[float] | Array, y: Sequence[float] | Array) -> Array:
        transform: Any = self.ax.transData
        found: Array = transform.transform(np.column_stack([x, y])) * 72 / self.ax.figure.dpi
        return found

    def take_point(self, x: float, y: float, half: float = _MARK) -> None:
        """Nothing is written over a point."""
        a, b = self.at(x, y)
        self.points.append((a, b))
        self.boxes.append((a - half, b - half, a + half, b + half))

    def take_line(self, x: Sequence[float] | Array, y: Sequence[float] | Array) -> None:
        """Nothing is written over a line, if there is another place."""
        found = self._on_page(x, y)
        self.lines.append(_dense(found[np.isfinite(found).all(axis=1)]))

    def beside(self, x: float, y: float, text: str, size: float) -> tuple[float, float]:
        """Where a name is best: from its point, pt, to its lower left corner. That place is taken then."""
        a, b = self.at(x, y)
        wide, high = _WIDE * size * len(text), _HIGH * size
        tried = [
            (
                self._cost(box := (a + i, b + j, a + i + wide, b + j + high)) + self._doubt(box, (a, b)) + _LONG * gap,
                n,
                i,
                j,
            )
            for n, (gap, i, j) in enumerate(_tried(wide, high))
        ]
        _, _, right, up = min(tried)
        self.boxes.append((a + right, b + up, a + right + wide, b + up + high))
        return right, up

    def _doubt(self, box: Box, own: tuple[float, float]) -> float:
        """What it costs that another point is nearer to a name than its own."""
        return _DOUBTFUL * any(_apart(box, x) <= _apart(box, own) for x in self.points if x != own)

    def crowded(self, place: tuple[float, float], size: float) -> float:
        """What it costs to write a number about a place."""
        a, b = self.at(*place)
        return self._cost((a - 0.6 * size, b - 0.6 * size, a + 0.6 * size, b + 0.6 * size))

    def away(self, one: tuple[float, float], other: tuple[float, float]) -> float:
        """How far two places are from each other, pt."""
        return float(np.hypot(*np.subtract(self.at(*one), self.at(*other))))

    def _cost(self, box: Box) -> float:
        left, bottom, right, top = box
        extents: Any = self.ax.bbox.extents
        edge = extents * 72 / self.ax.figure.dpi
        cost = _OUTSIDE * (left < edge[0] + 1 or bottom < edge[1] + 1 or right > edge[2] - 1 or top > edge[3] - 1)
        cost += _MET * sum(left < x1 and x0 < right and bottom < y1 and y0 < top for x0, y0, x1, y1 in self.boxes)
        for line in self.lines:
            x, y = line.T
            cost += _CROSSED * bool(((x > left) & (x < right) & (y > bottom) & (y < top)).any())
        return float(cost)


def _tried(wide: float, high: float) -> Iterator[tuple[float, float, float]]:
    """How far places of a name are, and where, the usual ones first: to the right, above and below, to the left; then farther."""
    for gap in (_NEAR, _FAR, 2 * _FAR):
        sides = (-high / 2, gap / 2, -high - gap / 2, gap, -high - gap)
        yield from ((gap, gap, up) for up in sides)
        yield from ((gap, -wide / 2, up) for up in (gap, -high - gap))
        yield from ((gap, -wide - gap, up) for up in sides)


def _apart(box: Box, point: tuple[float, float]) -> float:
    """How far a point is from a box."""
    (left, bottom, right, top), (x, y) = box, point
    return float(np.hypot(max(left - x, 0.0, x - right), max(bottom - y, 0.0, y - top)))


def _dense(points: Array) -> Array:
    """A line as points that are no more than about a point of the page apart."""
    if len(points) < 2:
        return points
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.linspace(0, along[-1], min(int(along[-1]) + 2, 20_000))
    return np.column_stack([np.interp(fine, along, points[:, i]) for i in (0, 1)])
