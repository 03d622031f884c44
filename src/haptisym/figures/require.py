"""Figures of requirements: the worst case over the band against one parameter, and the transparent region in two."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from sympy import Expr

from haptisym.figures.scales import RADIANS, Scale, band_scale
from haptisym.figures.style import (
    BLUE,
    DASHED,
    GREY,
    INK,
    RED,
    SHADE,
    SOLID,
    TEXT,
    Look,
    dress,
    entries,
    entry,
    legend,
    limit,
    name_parameter,
    one_column,
    write_note,
)
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values
from haptisym.model.quantities import Dimension
from haptisym.programs.values import Array
from haptisym.verbs.require.designmap import DesignMap, Slice
from haptisym.verbs.require.feasible import Binding, Kind, Span
from haptisym.verbs.require.required import Requirement

_GRID, _VALUES = 600, 400
_COLOUR = {Part.REAL: BLUE, Part.IMAG: RED, None: INK}
_NAME = {Part.REAL: "real part", Part.IMAG: "imaginary part", None: "any environment"}
_STROKE: dict[Part | None, Any] = {Part.REAL: SOLID, Part.IMAG: DASHED, None: (0, (5, 1.5, 1, 1.5))}
_MARKER: dict[Part | None, str] = {Part.REAL: "o", Part.IMAG: "s", None: "D"}
_FILL = {Kind.EDGE: "full", Kind.START: "none", Kind.TOUCH: "bottom"}
_HATCH: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "hatch": "////", "linewidth": 0}


def requirement_figure(found: Requirement | DesignMap) -> Figure:
    """A requirement, or a map of two parameters."""
    if isinstance(found, DesignMap):
        return one_column(2.6, lambda ax: draw_map(ax, found))
    return one_column(2.3, lambda ax: draw_requirement(ax, found))


def parameter_scale(free: Knob, given: Iterable[Expr | None]) -> Scale:
    """Hz for a frequency of which a value was given in Hz; else the parameter's own unit."""
    is_frequency = free.dimension is Dimension.FREQUENCY
    return band_scale(x for x in given if x is not None) if is_frequency else RADIANS


def _label(free: Knob, scale: Scale) -> str:
    return name_parameter(free.name, free.unit if scale.factor == 1 else scale.unit)


# One parameter.


def draw_requirement(ax: Axes, found: Requirement, *, color: str | None = None, label: str = "") -> list[Line2D]:
    """The largest r/c over the band against the parameter, sampled; the exact feasible set in grey, its ends as dots.

    ``color``, ``label`` : of the scene; the set of a further one on the same axes is a bar at the top. Returns the curves.

    >>> from matplotlib.figure import Figure
    >>> from haptisym import load_scene, require
    >>> ax = Figure().add_subplot()
    >>> lines = draw_requirement(ax, require(load_scene("fu2019"), "omega_n"))
    >>> [line.get_label() for line in lines], ax.get_xlabel()
    (['real part', 'imaginary part'], '$\\\\omega_n$ (rad/s)')
    """
    looks = [Look.on(ax, _NAME[part], color, label) for part in found.keys]
    look, own = looks[0], found.free.value
    scale = parameter_scale(found.free, (own, found.domain.low, found.domain.high))
    low, high = _window(found)
    spans = _draw_set(ax, found, look, scale, (low, high))
    t = np.linspace(low, high, _VALUES + 1)[1:]
    curves, lines = _worst(found, t), list[Line2D]()
    for part, one in zip(found.keys, looks, strict=True):
        shown = _COLOUR[part] if one.plain else one.color
        lines += ax.plot(
            scale.of(t), curves[part], color=shown, linestyle=_STROKE[part], linewidth=1.1, label=f"{_NAME[part]}{one.suffix}"
        )  # fmt: skip
    ends = [scale.of(float(end.value)) for end in found.ends if end.value is not None]
    dots = _dots(ax, ends, INK if look.plain else look.color, f"ends, proven{look.suffix}")
    threshold = [] if "threshold" in entries(ax) else [ax.axhline(1, color=GREY, linewidth=0.6, label="threshold")]
    lowest = [float(np.min(worst[np.isfinite(worst)], initial=np.inf)) for worst in curves.values()]
    top = max([3.0, *(1.5 * x for x in lowest if x < np.inf)])  # each curve is seen somewhere
    limit(ax, (scale.of(low), scale.of(high)), (0, top), number=look.number)
    dress(ax)
    ax.set_xlabel(_label(found.free, scale), fontsize=TEXT)
    ax.set_ylabel("worst case on the band, $r/c$", fontsize=TEXT)
    legend(ax, [*lines, *threshold, *spans, *dots])
    return lines


def _dots(ax: Axes, at: Sequence[float], color: str, label: str) -> list[Line2D]:
    style: dict[str, Any] = {"color": color, "markersize": 3.6, "zorder": 4, "label": label}
    return ax.plot(at, [1.0] * len(at), "o", **style) if at else []


def _draw_set(ax: Axes, found: Requirement, look: Look, scale: Scale, window: tuple[float, float]) -> list[Artist]:
    """The values that are proven to do, and those that are undecided; one entry of each."""
    made: list[Artist] = []
    for span in found.feasible:
        a, b = (scale.of(x) for x in _limits(span, *window))
        if look.number:
            y = [0.985 - 0.03 * look.number] * 2
            marker = "o" if a == b else ""
            made += ax.plot(
                [a, b], y, color=look.color, linewidth=2.5, alpha=0.6, marker=marker, transform=ax.get_xaxis_transform()
            )
        elif a == b:
            made.append(ax.axvline(a, color=SHADE, linewidth=2, zorder=0))
        else:
            made.append(ax.axvspan(a, b, facecolor=SHADE, linewidth=0, zorder=0))
    told = made[:1] or [entry(f"no value is {'transparent' if found.certified else 'proven transparent'}{look.suffix}")]
    told[0].set_label(f"transparent{look.suffix}" if made else str(told[0].get_label()))
    low, high = window
    for start, end in found.undecided:
        a, b = low if start is None else float(start), high if end is None else float(end)
        patch = ax.axvspan(scale.of(a), scale.of(b), zorder=0, label=f"undecided{look.suffix}", **_HATCH)
        told += [patch] if not any(str(x.get_label()).startswith("undecided") for x in told) else []
    return told


def _window(found: Requirement) -> tuple[float, float]:
    """The values drawn: the range, cut where it is unbounded to about the ends of the set and the scene's own value."""
    known = [float(found.free.value), *(float(end.value) for end in found.ends if end.value is not None)]
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


# Two parameters.


def draw_map(ax: Axes, found: DesignMap, *, color: str | None = None, label: str = "") -> list[Artist]:
    """The transparent region: each exact slice as an upright stroke with marks where it ends, by what binds there.

    What joins the slices (a light ground, thin lines) is interpolation, and the legend says so. Hatched: undecided on a slice,
    or between slices that differ in kind. Ticks on the lower axis: where the slices are.
    ``color``, ``label`` : of the scene; of a further one on the same axes no ground is drawn. Returns the strokes and the marks.

    >>> from matplotlib.figure import Figure
    >>> from haptisym import design_map, load_scene
    >>> found = design_map(load_scene("fu2019"), ["omega_n", "zeta"], [(60, 200), (0.1, 1)], slices=5)
    >>> strokes, *marks = draw_map(Figure().add_subplot(), found)
    >>> [mark.get_label() for mark in marks]
    ['imaginary part, band-edge']
    """
    look, scales = Look.on(ax, "exact slices", color, label), _scales(found)
    (a, b), (low, high) = _window_of(found)
    strokes = _draw_slices(ax, found, look, scales)
    ground = [] if look.number else _draw_ground(ax, found, scales)
    marks = draw_boundary(ax, found, color=None if look.plain else look.color, suffix=look.suffix)
    open_ones = _draw_undecided(ax, found, scales, look)
    limit(ax, (scales[0].of(a), scales[0].of(b)), (scales[1].of(low), scales[1].of(high)), number=look.number)
    dress(ax)
    ax.set_xlabel(_label(found.free[0], scales[0]), fontsize=TEXT)
    ax.set_ylabel(_label(found.free[1], scales[1]), fontsize=TEXT)
    some = [strokes] if strokes.get_segments() else []
    legend(ax, [*some, *ground, *marks, *open_ones, *_tick_entry(look)])
    if not any(x.requirement.feasible for x in found.slices):
        word = "transparent nowhere" if found.certified else "nowhere proven transparent"
        write_note(ax, f"{word}: on none of {len(found.slices)} exact slices{look.suffix}")
    return [strokes, *marks]


_STROKES = "transparent on the slice"


def _scales(found: DesignMap) -> tuple[Scale, Scale]:
    one, other = (parameter_scale(x, (*pair, x.value)) for x, pair in zip(found.free, found.ranges, strict=True))
    return one, other


def _draw_slices(ax: Axes, found: DesignMap, look: Look, scales: tuple[Scale, Scale]) -> LineCollection:
    """An upright stroke along each interval of each slice, and a tick on the axis for each slice."""
    _, window = _window_of(found)
    color = GREY if look.plain else look.color
    rows = [(scales[0].of(float(x.at)), x.requirement) for x in found.slices]
    lines = [[(x, scales[1].of(y)) for y in _limits(span, *window)] for x, r in rows for span in r.feasible]
    label = f"{_STROKES}{look.suffix}" if lines else ""
    strokes = LineCollection(lines, colors=color, linewidths=0.7, zorder=1, label=label)
    ax.add_collection(strokes)
    ax.plot([x for x, _ in rows], [0] * len(rows), transform=ax.get_xaxis_transform(), clip_on=False, **_tick(color))
    return strokes


def _tick(color: str) -> dict[str, Any]:
    return {"color": color, "linestyle": "none", "marker": 3, "markersize": 2.5}


def _tick_entry(look: Look) -> list[Artist]:
    color = GREY if look.plain else look.color
    return [Line2D([], [], label=f"exact slices{look.suffix}", **{**_tick(color), "marker": "|", "markersize": 5})]


def _draw_ground(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale]) -> list[Artist]:
    """A light ground between slices of one kind, which proves nothing."""
    _, window = _window_of(found)
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (_limits(span, *window) for span in (left, right))
        x, bottom, top = (
            scale.of(np.array(pair))
            for scale, pair in zip((scales[0], *[scales[1]] * 2), (at, (y0, z0), (y1, z1)), strict=True)
        )
        ax.fill_between(x, bottom, top, color=SHADE, linewidth=0, antialiased=False, zorder=0)
    return [Patch(facecolor=SHADE, label="between slices: interpolated")] if any(True for _ in _pieces(found)) else []


def draw_boundary(
    ax: Axes, found: DesignMap, *, color: str | None = None, suffix: str = "", width: float = 0.6
) -> list[Line2D]:
    """The ends of all slices, marked by what binds there, joined by lines that interpolate; an entry of each for a legend.

    ``suffix`` : what the entries end with; ``width`` : of the lines, points.
    """
    _, window = _window_of(found)
    scales = _scales(found)
    drawn: dict[tuple[Part | None, Kind], Line2D] = {}
    for at, left, right in _pieces(found):
        (y0, y1), (z0, z1) = (_limits(span, *window) for span in (left, right))
        for y, z, one, other in ((y0, z0, left.low, right.low), (y1, z1, left.high, right.high)):
            binding = _of(one.bindings, other.bindings)
            if binding is not None:
                style: dict[str, Any] = {"color": color or _COLOUR[binding.part], "linestyle": _STROKE[binding.part]}
                ends = scales[0].of(np.array(at)), scales[1].of(np.array([y, z]))
                ax.plot(*ends, linewidth=width, zorder=2, **style)
    for key, places in _ends(found).items():
        part, kind = key
        points = [(scales[0].of(x), scales[1].of(y)) for x, y in places]
        shown = color or _COLOUR[part]
        [drawn[key]] = ax.plot(
            *zip(*points, strict=True), color=shown, linestyle="none", marker=_MARKER[part], markersize=2.8,
            markeredgewidth=0.6, fillstyle=_FILL[kind], markerfacecoloralt="white", zorder=3,
            label=f"{_NAME[part]}, {kind.value}{suffix}",
        )  # fmt: skip
    return list(drawn.values())


def _ends(found: DesignMap) -> dict[tuple[Part | None, Kind], list[tuple[float, float]]]:
    """The exact ends of all slices, by the first condition that binds there."""
    places: dict[tuple[Part | None, Kind], list[tuple[float, float]]] = {}
    for x in found.slices:
        for end in x.requirement.ends:
            if end.bindings and end.value is not None:
                key = (end.bindings[0].part, end.bindings[0].kind)
                places.setdefault(key, []).append((float(x.at), float(end.value)))
    return places


def _draw_undecided(ax: Axes, found: DesignMap, scales: tuple[Scale, Scale], look: Look) -> list[Artist]:
    """Hatched: what a slice leaves open, halfway to its neighbours, and what lies between slices that differ in kind."""
    boxes = [*_left_open(found), *_between(found)]
    for (a, b), (c, d) in boxes:
        x, y = scales[0].of(np.array([a, b])), scales[1].of(np.array([c, d]))
        ax.fill_between(x, [y[0]] * 2, [y[1]] * 2, zorder=1, **_HATCH)
    return [Patch(label=f"undecided{look.suffix}", **_HATCH)] if boxes else []


Box = tuple[tuple[float, float], tuple[float, float]]


def _left_open(found: DesignMap) -> Iterator[Box]:
    _, (low, high) = _window_of(found)
    at = [float(x.at) for x in found.slices]
    middles = [at[0], *((a + b) / 2 for a, b in pairwise(at)), at[-1]] if at else []
    for x, around in zip(found.slices, pairwise(middles), strict=True):
        for start, end in x.requirement.undecided:
            yield around, (low if start is None else float(start), high if end is None else float(end))


def _between(found: DesignMap) -> Iterator[Box]:
    """The intervals of two neighbouring slices that have not as many."""
    _, window = _window_of(found)
    for one, other in pairwise(found.slices):
        spans = one.requirement.feasible + other.requirement.feasible
        if not _alike(one, other):
            for span in spans:
                yield (float(one.at), float(other.at)), _limits(span, *window)


def _alike(one: Slice, other: Slice) -> bool:
    return len(one.requirement.feasible) == len(other.requirement.feasible)


def _window_of(found: DesignMap) -> tuple[tuple[float, float], tuple[float, float]]:
    (a, b), (low, high) = ((float(x) for x in pair) for pair in found.ranges)
    return (a, b), (low, high)


def _pieces(found: DesignMap) -> Iterator[tuple[tuple[float, float], Span, Span]]:
    """Between neighbouring slices with as many intervals: where they are, and the intervals that belong together."""
    for one, other in pairwise(found.slices):
        if _alike(one, other):
            spans = zip(one.requirement.feasible, other.requirement.feasible, strict=True)
            yield from (((float(one.at), float(other.at)), *pair) for pair in spans)


def _of(left: tuple[Binding, ...], right: tuple[Binding, ...]) -> Binding | None:
    """What binds between two slices: what binds at one of them; nothing where the range itself ends at both."""
    found = [*left, *right] if left and right else []
    return found[0] if found else None
