"""How: magnitudes of the real and the imaginary part, and what is felt (the paper's Fig. 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from haptisym.figures import pen
from haptisym.figures.nyquist import responses
from haptisym.figures.sampling import band_of, broken, ends_of, evenly, in_window, poles_of, refined, sampled, top_of
from haptisym.figures.style import (
    MOST_NUMBERS,
    Look,
    Scale,
    curve_handles,
    curves,
    dress,
    entry,
    handle,
    legend,
    limit,
    mark_bands,
    name_dynamics,
    plate,
    scale_of,
    share_of,
    spread,
    text_width,
    write_note,
)
from haptisym.judge.crossings import Curve
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.percepts import NOT_NAMED, felt_of
from haptisym.kernel.roots import Interval, Signs
from haptisym.model.jnd import Part
from haptisym.programs.values import Array, Values


@dataclass(frozen=True)
class _Label:
    """What is felt from ``low`` to ``high``, in words."""

    low: float
    high: float
    words: str


def draw_projections(
    ax: Axes,
    evaluation: Evaluation,
    part: Part,
    *,
    color: str | None = None,
    label: str = "",
    hertz: bool | None = None,
) -> list[Line2D]:
    """``|Re|`` or ``|Im|`` of H_env and H_perc over the band (the paper's Fig. 7a and 7b).

    Bold where the part's ratio exceeds its threshold, or both parts together leave a region, with the percept in words; thin on
    grey where it does not.

    ``color``, ``label``, ``hertz`` : as of ``draw_ratios``; the percepts of a further scene on the same axes are not written.
    Returns the lines, of H_env bold and thin, then of H_perc.

    >>> from haptisym import Part, evaluate, load_scene
    >>> from matplotlib.figure import Figure
    >>> lines = draw_projections(Figure().add_subplot(), evaluate(load_scene("fu2019")), Part.REAL)
    >>> [line.get_linewidth() for line in lines]
    [1.6, 0.7, 1.6, 0.7]
    """
    name = rf"\mathrm{{{'Re' if part is Part.REAL else 'Im'}}}"
    first = rf"$|{name}\,H_\mathrm{{env}}|$"
    look, scale = Look.on(ax, first, color, label), scale_of(ax, evaluation.scene.band, hertz=hertz)
    f, grid = evaluation.distortion.compile(), sampled(evaluation)
    exceeded = _exceeded(evaluation, part)
    noticed, unnoticed = evaluation.chart.where(exceeded), evaluation.chart.where(lambda signs: not exceeded(signs))
    top = 1.3 * top_of(_magnitudes(f, grid, part), _magnitudes(f, evenly(evaluation), part)) or 1.0
    omega = refined(lambda w: in_window(_magnitudes(f, w, part), 0, top), grid)
    values = broken(_magnitudes(f, omega, part), omega, poles_of(evaluation))
    spans = mark_bands(ax, unnoticed, look, scale, "not noticed")
    handles, lines = curve_handles(look, rf"|{name}\,", "|"), list[Line2D]()
    for magnitude, (colour, style, _), one in zip(values.T, curves(look), handles, strict=True):
        for weight, among in ((1.6, noticed), (0.7, unnoticed)):
            shown = np.where(_within(omega, among), magnitude, np.nan)
            lines += ax.plot(scale.of(omega), shown, color=colour, linestyle=style, linewidth=weight)
        lines[-2].set_label(str(one.get_label()))
    low, high = band_of(evaluation)
    limit(ax, (scale.of(low), scale.of(high)), (0, top), number=look.number)
    dress(ax, scale.label)
    name_dynamics(ax.yaxis, rf"|{name}\,H|", evaluation.scene)
    numbered = _write_all(ax, _percept_labels(evaluation, part, scale)) if not look.number else []
    legend(ax, [*handles, *spans[:1], *numbered])
    return lines


def _exceeded(evaluation: Evaluation, part: Part) -> Callable[[Signs], bool]:
    """Whether a part is noticed, by itself or together with the other."""
    own = [x for x in evaluation.criteria if x.part in (part, None)]
    other = Part.IMAG if part is Part.REAL else Part.REAL

    def exceeded(signs: Signs) -> bool:
        if not any(signs[x] > 0 for x in own):
            return False
        alone = signs.get((Curve.OUTSIDE, part), 1) > 0
        return alone or signs.get((Curve.OUTSIDE, other), 0) <= 0

    return exceeded


def _write_all(ax: Axes, labels: Sequence[_Label]) -> list[Line2D]:
    """All percepts, or that there are none; what the legend says of those that have only a number."""
    _draw_boundaries(ax, labels)
    if not labels:
        write_note(ax, "never exceeds the threshold")
    return _write_percepts(ax, labels)


def _magnitudes(f: Callable[..., Values], omega: Array, part: Part) -> Array:
    return np.abs(responses(f, omega)[:, (0 if part is Part.REAL else 1) :: 2])


def _percept_labels(evaluation: Evaluation, part: Part, scale: Scale) -> list[_Label]:
    """As what a part is felt where it is noticed, in the words of all outputs and in the order of the bands."""
    together = [_on(scale, x.band, felt_of(x, part)) for x in evaluation.percepts if x.part is None]
    own = [_on(scale, x.band, _short(x.words)) for x in evaluation.felt if x.part is part]
    nameless = [_on(scale, x, _short(NOT_NAMED)) for x in _nameless(evaluation, part)]
    return sorted(together + own + nameless, key=lambda x: x.low)


def _short(words: str) -> str:
    """As a figure has room for it."""
    return "noticed (active)" if words == NOT_NAMED else words


def _nameless(evaluation: Evaluation, part: Part) -> tuple[Interval, ...]:
    """Where a region of both parts is left in this one, and an active display has no name for that."""
    if not any(x.joint for x in evaluation.criteria):
        return ()
    exceeded = _exceeded(evaluation, part)
    return evaluation.chart.where(
        lambda signs: (
            exceeded(signs)
            and signs[Curve.PERCEIVED, Part.IMAG] < 0
            and (part is Part.IMAG or signs[Curve.OUTSIDE, part] <= 0)
        )
    )


def _on(scale: Scale, band: Interval, words: str) -> _Label:
    low, high = ends_of(band)
    return _Label(scale.of(low), scale.of(high), words)


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
        handle(pen.INK, "none", words, marker=f"${n}$", markersize=4, markeredgewidth=0) for words, n in numbers.items()
    ]
    return handles + ([entry(f"and {len(narrow) - len(named)} narrower")] if len(narrow) > len(named) else [])


def _write_inside(ax: Axes, texts: Mapping[_Label, str]) -> None:
    """Texts side by side at the top of the axes, each in its band or tied to it."""
    centres = [share_of(ax, (label.low + label.high) / 2) for label in texts]
    places = spread(centres, [text_width(ax, text) for text in texts.values()])
    for (label, text), centre, place in zip(texts.items(), centres, places, strict=True):
        beside = abs(place - centre) > share_of(ax, label.high) - centre
        ax.annotate(
            text, xy=(centre, 0.82), xytext=(place, 0.98), xycoords="axes fraction", textcoords="axes fraction",
            ha="center", va="top", fontsize=pen.SMALL, linespacing=1.1, bbox=plate("white"),
            arrowprops=pen.LEADER if beside else None,
        )  # fmt: skip


def _fitting(ax: Axes, label: _Label) -> str:
    """The words on one line or two, as fits into the band; nothing if neither does."""
    room = share_of(ax, label.high) - share_of(ax, label.low)
    gap = ", " if ", " in label.words else " "
    layouts = (label.words, label.words.replace(gap, f"{gap.strip()}\n", 1))
    return next((text for text in layouts if text_width(ax, text) <= room), "")


def _draw_boundaries(ax: Axes, labels: Iterable[_Label]) -> None:
    for omega in sorted({x for label in labels for x in (label.low, label.high)} - set(ax.get_xlim())):
        ax.axvline(omega, color=pen.GREY, linewidth=0.5, linestyle=pen.DOTTED, zorder=1)
