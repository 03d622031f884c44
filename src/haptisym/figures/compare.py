"""The figure of a comparison: the ratios of all devices, one chart for each criterion, a colour and
a stroke for each device, its name at its curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from haptisym.figures import pen
from haptisym.figures.curves import (
    broken,
    columns,
    evenly,
    in_window,
    is_share,
    limit_of,
    name_of,
    refined,
    sampled,
    top_of,
)
from haptisym.figures.files import Drawings, sheet
from haptisym.figures.layers import DrawnAxis, Layer, Limit, Mark, Panel, Polyline, frequency
from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.evaluation import Evaluation
from haptisym.model.jnd import Part, Threshold
from haptisym.programs.floats import floats_of
from haptisym.programs.values import Array
from haptisym.verbs.compare.entry import Comparison
from haptisym.verbs.measured.entry import MeasuredEvaluation
from haptisym.writing.characters import printable

_COLORS = (pen.INK, "#d0701f", pen.BLUE, "#3a9aa5", "#8f5a9e", pen.RED)
_STROKES: tuple[Any, ...] = (
    pen.SOLID,
    pen.DASHED,
    pen.DOTTED,
    (0, (6, 1.5, 1, 1.5)),
    (0, (1, 1)),
    (0, (8, 2)),
)
"""Colours and strokes of the devices in their order: in grey the strokes alone tell them apart."""


@dataclass(frozen=True)
class _Sampled:
    """The curve, or the points, of one device under one criterion."""

    name: str
    omega: Array
    ratio: Array
    color: str
    stroke: Any
    measured: bool = False


def ratios(found: Comparison, which: int = 0) -> Panel:
    """One criterion of all devices over their bands, with its thresholds and the frequencies at
    which each meets it."""
    names = _criteria(found)
    name = names[which]
    layers, curves, limits, top = list[Layer](), list[_Sampled](), dict[float, None](), 0.0
    label = ""
    for i, device in enumerate(found):
        color, stroke = _COLORS[i % len(_COLORS)], _STROKES[i % len(_STROKES)]
        if not isinstance(device.answer, Evaluation):
            points, levels, symbol = _points(device.name, device.answer, name, color)
            curves += points
            label = label or symbol
            limits |= dict.fromkeys(levels)
            continue
        criterion = next((x for x in device.answer.criteria if x.name == name), None)
        if criterion is None:
            continue
        label, limit = name_of(criterion), limit_of(criterion)
        limits[limit] = None
        omega, ratio, highest = _curve(device.answer, criterion)
        top = max(top, highest, 2 * limit)
        curves.append(_Sampled(device.name, omega, ratio, color, stroke))
        crossed = [float(x.omega) for x in device.answer.crossings if x.criterion == criterion]
        look = {"clip_on": False, "markeredgewidth": 0.8}
        layers.append(Mark(crossed, [limit] * len(crossed), color, look=look))
    finite = [x.ratio[np.isfinite(x.ratio)] for x in curves if x.measured]
    peaks = [float(x.max(initial=0.0)) for x in finite]
    # Points that are not far above the curves of scenes are all shown.
    whole_points = max([1.06 * x for x in peaks] + [2 * x for x in limits], default=1.0)
    top = whole_points if top < whole_points < 2 * top else top or whole_points
    # Marks at the ends of the axes are whole, unless some are beyond them, which are cut off.
    whole = {"clip_on": max(peaks, default=0.0) > top}
    drawn: list[Layer] = [
        Mark(x.omega, x.ratio, x.color, size=2.4, name=printable(x.name), look=whole)
        if x.measured
        else Polyline(x.omega, x.ratio, x.color, x.stroke, name=printable(x.name))
        for x in curves
    ]
    # One legend for all charts, which is that of the first.
    words = "" if which else "threshold"
    thresholds = [Limit(x, label=words, shared=True) for x in limits]
    ends = [(float(x.omega.min()), float(x.omega.max())) for x in curves]
    low, high = min(x for x, _ in ends), max(x for _, x in ends)
    axis = frequency(found[0].scene.frequency, (low, high))
    return Panel(
        [*drawn, *thresholds, *layers], axis, DrawnAxis(label or name, ends=(0, top)), height=1.5
    )


def _criteria(found: Comparison) -> list[str]:
    """Return the names of all criteria; of measured devices alone those of the parts."""
    each = [x.answer.criteria for x in found if isinstance(x.answer, Evaluation)]
    names = dict.fromkeys(y.name for x in each for y in x)
    return list(names) or [part.value for part in Part]


def _curve(e: Evaluation, criterion: Criterion) -> tuple[Array, Array, float]:
    """Return frequencies, rad/s, what is judged there, and the height of the axis that shows it."""
    f = e.distortion.compile()

    def judged(omega: Array) -> Array:
        return columns([criterion], f(omega), omega)

    grid = sampled(e)
    top = top_of(judged(grid), judged(evenly(e)), limit_of(criterion))
    omega = refined(lambda x: in_window(judged(x), 0, top), grid)
    return omega, broken(judged(omega), omega, e.unbounded)[:, 0], top


def _points(
    device: str, answer: MeasuredEvaluation, name: str, color: str
) -> tuple[list[_Sampled], list[float], str]:
    """Return the measured ratios of a part, its threshold as a level of the axis, if it is one, and
    what the axis is called; no points where a region judges both parts together."""
    lines, scene = answer.lines, answer.scene
    parts = {Part.REAL.value: lines.change.real, Part.IMAG.value: lines.change.imag}
    if name not in parts:
        return [], [], ""
    # The ratio itself, unless its threshold is a number, or a formula in omega to divide by.
    of_part = {x.name: x for x in noticed(Threshold())}[name]
    ratio, limits = np.abs(parts[name]), list[float]()
    for x in noticed(scene.threshold):
        if x.name == name and x.region is None:
            of_part, limits = x, [limit_of(x)]
            ratio = ratio / floats_of(x.threshold, lines.omega) if is_share(x) else ratio
    return (
        [_Sampled(device, lines.omega, ratio, color, None, measured=True)],
        limits,
        name_of(of_part),
    )


def charts(found: Comparison, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """A chart for each criterion, one above the other."""
    return sheet(*(ratios(found, i) for i in range(len(_criteria(found)))), style=style)


COMPARISON = Drawings[Comparison](
    {"real": ratios, "imag": lambda found: ratios(found, min(1, len(_criteria(found)) - 1))},
    {"compare": charts},
)
