"""How: magnitudes of the real and the imaginary part, and what is felt (the paper's Fig. 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.crossings import Curve
from haptisym.evaluation import Evaluation
from haptisym.exact.roots import Interval
from haptisym.jnd import Part
from haptisym.numeric.values import Array, Values

from .nyquist import responses
from .sampling import band_of, broken, ends_of, evenly, in_window, poles_of, refined, sampled, top_of
from .style import (
    CURVES,
    DOTTED,
    FREQUENCY,
    GREY,
    INK,
    LEADER,
    MOST_NUMBERS,
    SHADE,
    SMALL,
    TEXT,
    _share,
    _spread,
    curve_handles,
    dress,
    entry,
    handle,
    legend,
    name_dynamics,
    plate,
    shade,
    text_width,
    write_note,
)


@dataclass(frozen=True)
class _Label:
    """What is felt from ``low`` to ``high``, in words."""

    low: float
    high: float
    words: str


def draw_projections(ax: Axes, evaluation: Evaluation, part: Part) -> None:
    """``|Re|`` or ``|Im|`` of H_env and H_perc over the band (the paper's Fig. 7a and 7b).

    Bold where the part's ratio exceeds its threshold, with the percept in words; thin on grey where it does not.
    """
    f, grid, labels = evaluation.distortion.compile(), sampled(evaluation), _percept_labels(evaluation, part)
    noticed = evaluation.chart.where(lambda signs: signs[Curve.EXCESS, part] > 0)
    unnoticed = evaluation.chart.where(lambda signs: signs[Curve.EXCESS, part] <= 0)
    top = 1.3 * top_of(_magnitudes(f, grid, part), _magnitudes(f, evenly(evaluation), part)) or 1.0
    omega = refined(lambda w: in_window(_magnitudes(f, w, part), 0, top), grid)
    values = broken(_magnitudes(f, omega, part), omega, poles_of(evaluation))
    shade(ax, unnoticed)
    for magnitude, (color, style, _) in zip(values.T, CURVES, strict=True):
        for weight, where in ((1.6, noticed), (0.7, unnoticed)):
            shown = np.where(_within(omega, where), magnitude, np.nan)
            ax.plot(omega, shown, color=color, linestyle=style, linewidth=weight)
    ax.set(xlim=band_of(evaluation), ylim=(0, top))
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    dress(ax)
    ax.set_xlabel(FREQUENCY, fontsize=TEXT)
    name_dynamics(ax.yaxis, rf"|{name}\,H|", evaluation)
    shaded = [Patch(facecolor=SHADE, label="not noticed")] if unnoticed else []
    _draw_boundaries(ax, labels)
    numbered = _write_percepts(ax, labels)
    legend(ax, [*curve_handles(rf"|{name}\,", "|"), *shaded, *numbered])
    if not labels:
        write_note(ax, "never exceeds the threshold")


def _magnitudes(f: Callable[..., Values], omega: Array, part: Part) -> Array:
    return np.abs(responses(f, omega)[:, (0 if part is Part.REAL else 1) :: 2])


def _percept_labels(evaluation: Evaluation, part: Part) -> list[_Label]:
    """The percepts of a part, and where it is noticed but active, so that the paper's model has no percept for it."""
    percepts = [
        _Label(*ends_of(p.band), f"{p.property.value}, {p.change.value}") for p in evaluation.percepts if p.part is part
    ]
    active = evaluation.chart.where(
        lambda signs: signs[Curve.EXCESS, part] > 0 and part is Part.IMAG and signs[Curve.PERCEIVED, part] < 0
    )
    return sorted(
        [*percepts, *(_Label(*ends_of(x), "active, no percept") for x in active)], key=lambda label: label.low
    )


def _within(omega: Array, intervals: Iterable[Interval]) -> Any:
    """Which samples lie on closed intervals."""
    found = np.zeros(omega.shape, dtype=bool)
    for low, high in map(ends_of, intervals):
        found |= (omega >= low) & (omega <= high)
    return found


def _write_percepts(ax: Axes, labels: Sequence[_Label]) -> list[Line2D]:
    """The words of each percept inside its band, or a number where it is too narrow, and the legend of these numbers."""
    fitting = {label: text for label in labels if (text := _fitting(ax, label))}
    narrow = sorted((x for x in labels if x not in fitting), key=lambda x: x.low - x.high)
    named = sorted(narrow[:MOST_NUMBERS], key=lambda x: x.low)
    numbers = {words: str(n) for n, words in enumerate(dict.fromkeys(x.words for x in named), 1)}
    _write_inside(ax, {x: fitting.get(x) or numbers[x.words] for x in labels if x in fitting or x in named})
    handles = [
        handle(INK, "none", words, marker=f"${n}$", markersize=4, markeredgewidth=0) for words, n in numbers.items()
    ]
    return handles + ([entry(f"and {len(narrow) - len(named)} narrower")] if len(narrow) > len(named) else [])


def _write_inside(ax: Axes, texts: Mapping[_Label, str]) -> None:
    """Texts side by side at the top of the axes, each in its band or tied to it."""
    centres = [_share(ax, (label.low + label.high) / 2) for label in texts]
    places = _spread(centres, [text_width(ax, text) for text in texts.values()])
    for (label, text), centre, place in zip(texts.items(), centres, places, strict=True):
        beside = abs(place - centre) > _share(ax, label.high) - centre
        ax.annotate(
            text, xy=(centre, 0.82), xytext=(place, 0.98), xycoords="axes fraction", textcoords="axes fraction",
            ha="center", va="top", fontsize=SMALL, linespacing=1.1, bbox=plate("white"),
            arrowprops=LEADER if beside else None,
        )  # fmt: skip


def _fitting(ax: Axes, label: _Label) -> str:
    """The words on one line or two, as fits into the band; nothing if neither does."""
    room = _share(ax, label.high) - _share(ax, label.low)
    layouts = (label.words, label.words.replace(", ", ",\n"))
    return next((text for text in layouts if text_width(ax, text) <= room), "")


def _draw_boundaries(ax: Axes, labels: Iterable[_Label]) -> None:
    for omega in sorted({x for label in labels for x in (label.low, label.high)} - set(ax.get_xlim())):
        ax.axvline(omega, color=GREY, linewidth=0.5, linestyle=DOTTED, zorder=1)
