"""A figure of tolerances: the guaranteed enclosures as bars, the crossings of the drawn sets of values as dots on them."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from haptisym.figures import pen
from haptisym.figures.sheet import laid_out, one_column
from haptisym.figures.stability import HEIGHT, draw_held, hands_figure
from haptisym.figures.style import (
    Look,
    Scale,
    dots,
    dress_rows,
    legend,
    limit,
    name_frequency,
    scale_of,
    threshold_symbol,
    written,
)
from haptisym.judge.crossings import Criterion
from haptisym.kernel.errors import NothingToDrawError
from haptisym.verbs.tolerances.proofs import Tolerances

_HEIGHT = 0.7


def draw_tolerances(
    ax: Axes, a: Tolerances, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Artist]:
    """A row for each ratio: grey where it may cross, proven; dots for each drawn set of values; a stroke for the nominal ones.

    ``color``, ``label``, ``hertz`` : as of ``haptisym.figures.ratios.draw_ratios``; enclosures of a further scene are outlines,
    in the row of what they are about.
    Returns the bars of the enclosures. NothingToDrawError where no values bring a crossing, unless another scene is there.

    >>> from haptisym import load_scene, tolerances
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().add_subplot()
    >>> bars = draw_tolerances(ax, tolerances(load_scene("fu2019-tolerances"), samples=20))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['for all values', 'drawn at random', 'nominal values']
    """
    name = "for all values"
    look, scale = Look.on(ax, name, color, label), scale_of(ax, a.box.scene.band, hertz=hertz)
    if not (look.number or _has_rows(a)):
        raise NothingToDrawError("nothing is met on the band, for any values within the ranges")
    low, high = (scale.of(float(x)) for x in a.box.scene.band)
    face: dict[str, Any] = {"facecolor": pen.SHADE, "edgecolor": look.ink(pen.GREY), "linewidth": 0.5}
    if look.number:
        face |= {"facecolor": "none", "linewidth": 1.0}
    before = [x.get_text() for x in ax.get_yticklabels()] if look.number else []
    names, bars = list(dict.fromkeys([*before, *map(_name, a.criteria)])), list[Artist]()
    for criterion in a.criteria:
        row = names.index(_name(criterion))
        for x in a.enclosures:
            if x.criterion == criterion:
                left, right = scale.of(float(x.low)), scale.of(float(x.high))
                bars += ax.barh(row, right - left, left=left, height=_HEIGHT, zorder=1, **face)
        _draw_row(ax, a, row, criterion.name, look, scale)
    limit(ax, (low, high), (-0.5, len(names) - 0.5), number=look.number)
    dress_rows(ax, names, pen.TEXT)
    name_frequency(ax, scale)
    handles = [
        Patch(label=f"{name}{look.suffix}", **face),
        Line2D([], [], color=look.ink(pen.BLUE), label=f"drawn at random{look.suffix}", **dots(2.2)),
        Line2D(
            [], [], color=look.ink(pen.INK), label=f"nominal values{look.suffix}", **dots(7, "|", markeredgewidth=1.4)
        ),
    ]
    some = {
        0: bars,
        1: any(found for x in a.samples for found in x.crossings.values()),
        2: any(a.nominal.crossings.values()),
    }
    legend(ax, [x for i, x in enumerate(handles) if some[i]])
    return bars


def _name(x: Criterion) -> str:
    """Of a row: what is met in it."""
    return x.joint.kind if x.joint else f"{written(x)[:-1]} = {threshold_symbol(x)[1:]}"


def _draw_row(ax: Axes, a: Tolerances, row: int, name: str, look: Look, scale: Scale) -> None:
    drawn = [(scale.of(float(x)), n) for n, one in enumerate(a.samples) for x in one.crossings[name]]
    heights = [row + 0.5 * ((n * 0.618) % 1 - 0.5) for _, n in drawn]  # spread evenly, to tell dots apart
    ax.plot([x for x, _ in drawn], heights, ".", markersize=1.6, color=look.ink(pen.BLUE), zorder=2)
    nominal = [scale.of(float(x)) for x in a.nominal.crossings[name]]
    ends = (row - _HEIGHT / 2, row + _HEIGHT / 2)
    ax.vlines(nominal, *ends, color=look.ink(pen.INK), linewidth=1.4, zorder=3)


def tolerances_figure(a: Tolerances) -> Figure:
    """The rows of both parts, and below them the plane of the hand; NothingToDrawError where there is neither."""
    if a.held:
        with suppress(NothingToDrawError):
            return _with_hands(a) if _has_rows(a) else hands_figure(a)
    return enclosures_figure(a)


def enclosures_figure(a: Tolerances) -> Figure:
    """The rows alone; NothingToDrawError where no values bring a crossing."""
    return one_column(_height(a), lambda ax: draw_tolerances(ax, a))


def _has_rows(a: Tolerances) -> bool:
    return bool(a.enclosures) or any(a.nominal.crossings.values()) or any(any(x.crossings.values()) for x in a.samples)


def _height(a: Tolerances) -> float:
    return 1.5 if len(a.criteria) > 1 else 1.3


def _with_hands(a: Tolerances) -> Figure:
    """Both on one sheet."""
    heights = (_height(a), HEIGHT)
    figure = Figure(figsize=(pen.WIDTH, sum(heights)), layout="compressed")
    upper, lower = figure.subplots(2, 1, height_ratios=heights)
    draw_tolerances(upper, a)
    draw_held(lower, a)
    return laid_out(figure, sum(heights), upper, lower)
