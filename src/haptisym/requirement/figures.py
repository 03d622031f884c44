"""Figures of requirements: the worst case over the band against one parameter, and the transparent region in two."""

from __future__ import annotations

from collections.abc import Iterator
from functools import singledispatch
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from sympy import Symbol

from haptisym.catalogue import values
from haptisym.figures.style import BLUE, GREY, INK, RED, SHADE, SMALL, TEXT, WIDTH, dress, handle, save_as
from haptisym.jnd import Part
from haptisym.numeric.values import Array
from haptisym.quantities import unit_text
from haptisym.tex.latex import latex

from .designmap import DesignMap
from .feasible import Binding, Kind, Span
from .freeparameter import Free
from .question import Requirement

_GRID, _VALUES = 600, 400
_COLOUR = {Part.REAL: BLUE, Part.IMAG: RED, None: INK}
_NAME = {Part.REAL: "real part", Part.IMAG: "imaginary part", None: "any environment"}
_STYLE = {Kind.EDGE: "-", Kind.START: ":", Kind.TOUCH: (0, (4, 1.6))}


def save_requirement(found: Requirement | DesignMap, path: Path) -> None:
    """Write the figure of a requirement or of a design map; SceneError for an ending other than .svg, .pdf, .png."""
    figure = Figure(figsize=(WIDTH, 0.75 * WIDTH), layout="constrained")
    _draw(found, figure.add_subplot())
    save_as(figure, path)


@singledispatch
def _draw(found: object, ax: Axes) -> None:
    raise TypeError(f"no figure of a {type(found).__name__}")


@_draw.register
def draw_requirement(found: Requirement, ax: Axes) -> None:
    """The largest r/c over the band against the parameter, sampled; the exact feasible set in grey, its ends as dots."""
    low, high = _window(found)
    for span in found.feasible:
        a, b = _limits(span, low, high)
        ax.axvspan(a, b, color=SHADE, linewidth=0)
    for i, (start, end) in enumerate(found.undecided):
        a, b = low if start is None else float(start), high if end is None else float(end)
        name = "" if i else "undecided"
        ax.axvspan(a, b, facecolor="none", edgecolor=GREY, hatch="///", linewidth=0, label=name)
    t = np.linspace(low, high, _VALUES + 1)[1:]
    curves = _worst(found, t)
    for part, worst in curves.items():
        ax.plot(t, worst, color=_COLOUR[part], linewidth=1.1, label=_NAME[part])
    ends = [float(end.value) for end in found.ends if end.value is not None]
    ax.plot(ends, [1.0] * len(ends), "o", color=INK, markersize=3.6, zorder=4)
    ax.axhline(1, color=GREY, linewidth=0.6)
    lowest = [float(np.min(worst[np.isfinite(worst)], initial=np.inf)) for worst in curves.values()]
    top = max([3.0, *(1.5 * x for x in lowest if x < np.inf)])  # each curve is seen somewhere
    ax.set(xlim=(low, high), ylim=(0, top))
    dress(ax)
    ax.set_xlabel(_label(found.free.symbol.name, found.free.unit), fontsize=TEXT)
    ax.set_ylabel("worst case on the band, $r/c$", fontsize=TEXT)
    ax.legend(fontsize=SMALL, frameon=False)


def _window(found: Requirement) -> tuple[float, float]:
    """The values drawn: the range, cut where it is unbounded to about the ends of the set and the scene's own value."""
    own = values(found.scene.parameters).get(found.free.symbol, found.scene.threshold.real)
    known = [float(own), *(float(end.value) for end in found.ends if end.value is not None)]
    low, high = found.domain.low, found.domain.high
    reach = 2 * max(abs(x) for x in known) or 1.0
    return (float(low) if low is not None else -reach), (float(high) if high is not None else reach)


def _limits(span: Span, low: float, high: float) -> tuple[float, float]:
    return (
        low if span.low.value is None else float(span.low.value),
        high if span.high.value is None else float(span.high.value),
    )


def _worst(found: Requirement, t: Array) -> dict[Part | None, Array]:
    """The largest ratio to its threshold of each part, over a grid of the band."""
    scene, free = found.scene, found.free
    known = {x: v for x, v in values(scene.parameters).items() if x != free.symbol}
    f = scene.chain.at(known).distortion().compile()
    start, end = (float(x) for x in scene.band)
    omega = np.linspace(start, end, _GRID)[:, None]
    with np.errstate(all="ignore"):
        at = f(omega, **({} if free.parts else {free.symbol.name: t[None, :]}))
    relative = np.hypot(at.relative_real, at.relative_imag)
    ratios = {Part.REAL: at.ratio_real, Part.IMAG: at.ratio_imag, None: relative}
    return {part: np.nanmax(ratios[part] / _threshold(found, part, t), axis=0) for part in found.keys}


def _threshold(found: Requirement, part: Part | None, t: Array) -> Array:
    limits = found.scene.threshold
    if part is None:
        return t[None, :] if found.free.parts else np.asarray(float(min(limits.real, limits.imag)))
    return t[None, :] if part in found.free.parts else np.asarray(float(limits[part]))


@_draw.register
def draw_map(found: DesignMap, ax: Axes) -> None:
    """The transparent region in grey, its boundary by part and kind."""
    (a, b), (low, high) = _window_of(found)
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (_limits(span, low, high) for span in (left, right))
        ax.fill_between(at, (y0, z0), (y1, z1), color=SHADE, linewidth=0, antialiased=False)
    labelled = draw_boundary(found, ax)
    ax.set(xlim=(a, b), ylim=(low, high))
    first, second = found.free
    dress(ax)
    ax.set_xlabel(_axis(first), fontsize=TEXT)
    ax.set_ylabel(_axis(second), fontsize=TEXT)
    if labelled:
        ax.legend(handles=labelled, fontsize=SMALL, frameon=False)


def draw_boundary(found: DesignMap, ax: Axes, width: float = 1.1) -> list[Line2D]:
    """The boundary of the transparent region, by what binds there; entries for a legend."""
    _, (low, high) = _window_of(found)
    entries: dict[tuple[Part | None, Kind], Line2D] = {}
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (_limits(span, low, high) for span in (left, right))
        for y, z, one, other in ((y0, z0, left.low, right.low), (y1, z1, left.high, right.high)):
            binding = _of(one.bindings, other.bindings)
            if binding is not None:
                color, style = _COLOUR[binding.part], _STYLE[binding.kind]
                ax.plot(at, (y, z), color=color, linestyle=style, linewidth=width)
                label = f"{_NAME[binding.part]}, {binding.kind.value}"
                entries.setdefault((binding.part, binding.kind), handle(color, style, label, width))
    return list(entries.values())


def _window_of(found: DesignMap) -> tuple[tuple[float, float], tuple[float, float]]:
    (a, b), (low, high) = ((float(x) for x in pair) for pair in found.ranges)
    return (a, b), (low, high)


def _pieces(found: DesignMap) -> Iterator[tuple[tuple[float, float], Span, Span]]:
    """Between neighbouring slices with as many intervals: where they are, and the intervals that belong together."""
    for one, other in pairwise(found.slices):
        spans = (one.requirement.feasible, other.requirement.feasible)
        if len(spans[0]) == len(spans[1]):
            yield from (((float(one.at), float(other.at)), *pair) for pair in zip(*spans, strict=True))


def _of(left: tuple[Binding, ...], right: tuple[Binding, ...]) -> Binding | None:
    """What binds between two slices: what binds at one of them; nothing where the range itself ends at both."""
    found = [*left, *right] if left and right else []
    return found[0] if found else None


def _axis(free: Free) -> str:
    return _label(free.symbol.name, free.unit)


def _label(name: str, unit: str) -> str:
    shown = f"${latex(Symbol(name))}$"
    return shown if unit == "1" else f"{shown} ({unit_text(unit)})"
