"""Figures of the best values: the bandwidth over one parameter with its proven bounds, or level
lines over two.

The curve and the level lines are computed in floats. The bounds, the hatched values that break what
must be kept, and the marks are proven.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist

from haptisym.figures import pen
from haptisym.figures.files import Drawings
from haptisym.figures.layers import (
    DrawnAxis,
    Ground,
    Layer,
    Mark,
    On,
    Panel,
    Polyline,
    frequency,
    handle,
    parameter,
    small,
)
from haptisym.kernel.errors import NothingToDrawError
from haptisym.model.jnd import Part
from haptisym.programs.values import Array
from haptisym.verbs.design.entry import Design, DesignQuestion

_VALUES, _GRID = 241, 49
_WITHIN, _MOST = 1 / 200, 100_000
"""How far apart bounds are to be, a share of the band; pieces that are looked at."""
_FINEST, _ROOM = {1: 2.0**-12, 2: 2.0**-9}, 1.04
_REFUSED = {"facecolor": "none", "edgecolor": pen.GREY, "hatch": "////", "linewidth": 0}


def design(found: Design) -> Panel:
    """The bandwidth over one or two free parameters. NothingToDrawError for three."""
    question = found.question
    if question is None or len(found.free) > 2:
        raise NothingToDrawError(
            "the bandwidth is drawn over one parameter or over two: leave out one of them"
        )
    axes = [_axis(found, i) for i in range(len(found.free))]
    return (
        _curve(found, question, axes[0])
        if len(axes) == 1
        else _map(found, question, axes[0], axes[1])
    )


def _axis(found: Design, i: int) -> DrawnAxis:
    """Return the axis of a free parameter, logarithmic where its range spans more than a factor of
    8."""
    low, high = (float(x) for x in found.ranges[i])
    free = found.free[i]
    own = parameter(free, free.name, (low, high))
    is_log = low > 0 and high > 8 * low
    return DrawnAxis(own.label, own.unit, own.ends, own.dimension, log=is_log)


def _places(axis: DrawnAxis, count: int) -> Array:
    """Return values along an axis, evenly spaced as it is drawn; SI."""
    assert axis.ends
    return np.geomspace(*axis.ends, count) if axis.log else np.linspace(*axis.ends, count)


def _curve(found: Design, question: DesignQuestion, axis: DrawnAxis) -> Panel:
    """Return the panel of one parameter: the bandwidth, and bounds that are proven for each cell of
    its range."""
    values = _places(axis, _VALUES)
    cells, bounds = question.profile(_WITHIN, _MOST)
    (_, bandwidths), end = question.points.bandwidths(values[:, None]), float(found.family.band[1])
    named = f"bandwidth if off by {float(100 * found.robust):g} %" if found.robust else "bandwidth"
    layers: list[Layer] = [
        Ground(_si(found, cells[:, 0], 0), (bounds[:, 0], bounds[:, 1]), label="proven bounds"),
        *_refused(found, question),
        Polyline(values, bandwidths, width=2.0, label=named),
        *_parts(question, values, end),
        *_marks(found, lambda values, bandwidth: ([values[0]], [bandwidth])),
    ]
    # A hundredth of the band at least, so that a bandwidth of 0 everywhere still has an axis.
    top = min(1.2 * float(bandwidths.max(initial=end / 100)), end)
    upright = DrawnAxis(
        "bandwidth",
        found.family.frequency,
        (0.0, top * _ROOM),
        frequency(found.family.frequency).dimension,
    )
    return Panel(layers, axis, upright, height=2.3)


_LOOKS = {
    Part.REAL: ("real part noticed", pen.BLUE, pen.SOLID),
    Part.IMAG: ("imaginary part noticed", pen.RED, pen.DASHED),
}


def _parts(question: DesignQuestion, values: Array, end: float) -> Iterator[Layer]:
    """Yield from which frequency on each part is noticed: the lower one limits the bandwidth."""
    for part, first in question.points.first_crossings(values[:, None]).items():
        if (first < end).any():
            label, color, stroke = _LOOKS[part]
            # A part that is not noticed up to the end of the band has no frequency to draw.
            yield Polyline(
                values, np.where(first < end, first, np.nan), color, stroke, 0.9, label=label
            )


def _map(found: Design, question: DesignQuestion, x: DrawnAxis, y: DrawnAxis) -> Panel:
    """Return the panel of two parameters: level lines of the bandwidth on a grid."""
    u, v = _places(x, _GRID), _places(y, _GRID)
    sets = np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)
    levels = _Levels(
        u,
        v,
        question.points.bandwidths(sets)[1].reshape(len(v), len(u)),
        label="bandwidth, " + found.family.frequency.text,
    )
    layers = [
        *_refused(found, question),
        levels,
        *_marks(found, lambda values, _: ([values[0]], [values[1]])),
    ]
    return Panel(layers, x, y, height=2.6)


def _si(found: Design, shares: Array, i: int) -> tuple[Array, Array]:
    """Return the ends of cells, given as shares of a parameter's range, in SI."""
    low, high = (float(x) for x in found.ranges[i])
    ends = low + (high - low) * shares
    return ends[:, 0], ends[:, 1]


def _refused(found: Design, question: DesignQuestion) -> Iterator[Layer]:
    """Yield the hatched values for which a condition that must be kept is proven to be broken."""
    cells = question.refused(_FINEST[len(found.free)], _MOST) if found.keep else np.empty((0, 1, 2))
    if not len(cells):
        return
    # Over one parameter a refused interval is hatched over the whole height.
    top = np.tile([0.0, _ROOM * float(found.family.band[1])], (len(cells), 1))
    y = (top[:, 0], top[:, 1]) if len(found.free) == 1 else _si(found, cells[:, 1], 1)
    yield Ground(
        _si(found, cells[:, 0], 0), y, label=f"not {' and '.join(found.keep)}", look=_REFUSED
    )


def _marks(found: Design, place: object) -> Iterator[Layer]:
    """Yield marks of the scene's values, where they lie in the ranges, and of the best ones."""
    for one, label, face in (
        (found.given, "as in the scene", "white"),
        (found.best, "best", pen.INK),
    ):
        if one is None:
            continue
        values = [float(x) for x in one.values]
        if all(float(a) <= x <= float(b) for x, (a, b) in zip(values, found.ranges, strict=True)):
            xs, ys = place(values, one.bandwidth)  # type: ignore[operator]
            yield Mark(xs, ys, size=5, face=face, label=label, look={"zorder": 6, "clip_on": False})


@dataclass(frozen=True)
class _Levels(Layer):
    """Level lines of numbers on a grid, with their values."""

    x: Array
    y: Array
    z: Array

    def draw(self, on: On) -> list[Artist]:
        style: dict[str, Any] = {"colors": pen.BLUE, "linewidths": 0.7, "zorder": 2}
        lines = on.ax.contour(on.x.of(self.x), on.y.of(self.y), self.z, 8, **style)
        on.ax.clabel(lines, fontsize=small(on.ax), fmt="%g", inline_spacing=2)
        return [handle(pen.BLUE, pen.SOLID, "", 0.7)]


DESIGN = Drawings[Design]({"design": design})
