"""Figures of requirements: the worst case over the band against one parameter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from sympy import Expr, Float, Rational, S

from haptisym.figures import pen
from haptisym.figures.judged import judged, limit_of
from haptisym.figures.sheet import one_column
from haptisym.figures.style import (
    RADIANS,
    Look,
    Scale,
    band_scale,
    dress,
    entries,
    entry,
    legend,
    limit,
    name_parameter,
)
from haptisym.judge.crossings import Criterion
from haptisym.kernel.errors import SceneError
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import values
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Knob
from haptisym.programs.values import Array, Values
from haptisym.verbs.require.feasible import Span
from haptisym.verbs.require.required import Requirement

_GRID, _VALUES = 600, 400
HATCH: dict[str, Any] = {"facecolor": "none", "edgecolor": pen.GREY, "hatch": "////", "linewidth": 0}


class CriterionLook(NamedTuple):
    """How a criterion is drawn."""

    color: str
    stroke: Any
    marker: str


def look_of(x: Criterion) -> CriterionLook:
    """The same in all figures."""
    return _LOOKS.get(x.name, CriterionLook(pen.INK, (0, (5, 1.5, 1, 1.5)), "D"))


_LOOKS = {"real": CriterionLook(pen.BLUE, pen.SOLID, "o"), "imag": CriterionLook(pen.RED, pen.DASHED, "s")}


def requirement_figure(found: Requirement) -> Figure:
    """A requirement on one parameter."""
    return one_column(2.3, lambda ax: draw_requirement(ax, found))


def parameter_scale(free: Knob, given: Iterable[Expr | None]) -> Scale:
    """Hz for a frequency of which a value was given in Hz; else the parameter's own unit."""
    is_frequency = free.dimension is Dimension.FREQUENCY
    return band_scale(x for x in given if x is not None) if is_frequency else RADIANS


def label_of(free: Knob, scale: Scale) -> str:
    """The label of a parameter's axis."""
    return name_parameter(free.name, free.unit if scale.factor == 1 else scale.unit)


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
    looks = [Look.on(ax, x.words, color, label) for x in found.criteria]
    look, own = looks[0], found.free.value
    scale = parameter_scale(found.free, (own, found.domain.low, found.domain.high))
    low, high = _window(found)
    spans = _draw_set(ax, found, look, scale, (low, high))
    t = np.linspace(low, high, _VALUES + 1)[1:]
    curves, lines = _worst(found, t), list[Line2D]()
    for x, one in zip(found.criteria, looks, strict=True):
        own = look_of(x)
        lines += ax.plot(
            scale.of(t), curves[x], color=one.ink(own.color), linestyle=own.stroke, linewidth=1.1,
            label=f"{x.words}{one.suffix}",
        ) if x in curves else []  # fmt: skip
    ends = [scale.of(float(end.value)) for end in found.ends if end.value is not None]
    dots = _dots(ax, ends, look.ink(pen.INK), f"ends, proven{look.suffix}")
    is_new = bool(lines) and "threshold" not in entries(ax)
    threshold = [ax.axhline(1, color=pen.GREY, linewidth=0.6, label="threshold")] if is_new else []
    lowest = [float(np.min(worst[np.isfinite(worst)], initial=np.inf)) for worst in curves.values()]
    top = max([3.0, *(1.5 * x for x in lowest if x < np.inf)])  # each curve is seen somewhere
    limit(ax, (scale.of(low), scale.of(high)), (0, top), number=look.number)
    dress(ax)
    ax.set_xlabel(label_of(found.free, scale), fontsize=pen.TEXT)
    if lines:
        ax.set_ylabel("worst case on the band, $r/c$", fontsize=pen.TEXT)
    else:  # what was asked has no course along a band
        ax.set_yticks([])
        ax.set_ylim(0, 2)
    legend(ax, [*lines, *threshold, *spans, *dots])
    return lines


def kept_words(that: Iterable[str]) -> str:
    """``transparent and stable``: of what was asked."""
    return " and ".join(that)


def _dots(ax: Axes, at: Sequence[float], color: str, label: str) -> list[Line2D]:
    style: dict[str, Any] = {"color": color, "markersize": 3.6, "zorder": 4, "label": label}
    return ax.plot(at, [1.0] * len(at), "o", **style) if at else []


def _draw_set(ax: Axes, found: Requirement, look: Look, scale: Scale, window: tuple[float, float]) -> list[Artist]:
    """The values that are proven to do, and those that are undecided; one entry of each."""
    made: list[Artist] = []
    for span in found.feasible:
        a, b = (scale.of(x) for x in limits_of(span, *window))
        if look.number:
            y = [0.985 - 0.03 * look.number] * 2
            marker = "o" if a == b else ""
            made += ax.plot(
                [a, b], y, color=look.color, linewidth=2.5, alpha=0.6, marker=marker, transform=ax.get_xaxis_transform()
            )
        elif a == b:
            made.append(ax.axvline(a, color=pen.SHADE, linewidth=2, zorder=0))
        else:
            made.append(ax.axvspan(a, b, facecolor=pen.SHADE, linewidth=0, zorder=0))
    word = kept_words(found.that)
    told = made[:1] or [entry(f"no value is {word if found.certified else f'proven {word}'}{look.suffix}")]
    told[0].set_label(f"{word}{look.suffix}" if made else str(told[0].get_label()))
    low, high = window
    for start, end in found.undecided:
        a, b = low if start is None else float(start), high if end is None else float(end)
        patch = ax.axvspan(scale.of(a), scale.of(b), zorder=0, label=f"undecided{look.suffix}", **HATCH)
        told += [patch] if not any(str(x.get_label()).startswith("undecided") for x in told) else []
    return told


def _window(found: Requirement) -> tuple[float, float]:
    """The values drawn: the range, cut where it is unbounded to about the ends of the set and the scene's own value."""
    own = found.free.value
    known = [
        *([] if own.free_symbols else [float(own)]),
        *(float(end.value) for end in found.ends if end.value is not None),
    ]
    low, high = found.domain.low, found.domain.high
    reach = 2 * max((abs(x) for x in known), default=0.0) or 1.0
    return (float(low) if low is not None else -reach), (float(high) if high is not None else reach)


def limits_of(span: Span, low: float, high: float) -> tuple[float, float]:
    """The ends of an interval; where it has none, those that are given."""
    return (
        low if span.low.value is None else float(span.low.value),
        high if span.high.value is None else float(span.high.value),
    )


def _worst(found: Requirement, t: Array) -> dict[Criterion, Array]:
    """The largest ratio to its threshold, over a grid of the band, of each criterion that is about a ratio.

    A gap where there is no scene, as where a formula is divided by zero.
    """
    scene, free = found.scene, found.free
    chain = scene.chain.at({x: v for x, v in values(scene.parameters).items() if x != free.symbol})
    there = np.array([_exists(chain, free, x) for x in t])
    t = t[there]
    f = Distortion.of(chain).compile()
    start, end = (float(x) for x in scene.band)
    omega = np.linspace(start, end, _GRID)[:, None]
    with np.errstate(all="ignore"):
        at = f(omega, **dict.fromkeys(f.parameters, t[None, :]))  # none for a threshold, and for a number of a hand
        curves = {x: _against(x, free, at, omega, t) for x in found.criteria}
    given = {x: np.broadcast_to(curve, t.shape) for x, curve in curves.items() if curve is not None}
    shown = {x: np.full(there.shape, np.nan) for x in given}
    for x, row in shown.items():
        row[there] = given[x]
    return shown


def _exists(chain: Chain, free: Knob, value: float) -> bool:
    try:
        chain.at({free.symbol: Rational(value)})
    except SceneError:
        return False
    return True


def _against(x: Criterion, free: Knob, at: Values, omega: Array, t: Array) -> Array | None:
    """The largest ratio to its limit over the frequencies; where the parameter is that limit, at each of its values."""
    if not x.depends_on(free.parts):
        own = judged(x, at, omega)
        return None if own is None else np.nanmax(own / limit_of(x), axis=0)
    if x.region is None:
        own = judged(replace(x, threshold=S.One), at, omega)
        return None if own is None else np.nanmax(own / t[None, :], axis=0)
    opened = (replace(x, region=x.region.opened(dict.fromkeys(free.parts, Float(c)))) for c in t)
    values = (judged(one, at, omega) for one in opened)
    return np.array([np.nan if own is None else np.nanmax(own) for own in values])
