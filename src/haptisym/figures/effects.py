"""The figure of a scene's influences: what each effect changes, along the band, and which one changes most."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation

from haptisym.figures import pen
from haptisym.figures.style import dress, limit, name_frequency, scale_of, spread, text_width
from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part
from haptisym.programs.links import series_arithmetic
from haptisym.programs.values import Array
from haptisym.verbs.effects.differences import BandPiece
from haptisym.verbs.effects.relevance import Relevance

_DEPTH = 8  # 2^8 samples along the band
_DECADES = 3.5  # below the tolerance that are shown
_STYLES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)))


def draw_influences(
    ax: Axes, found: Relevance, part: Part, *, color: str | None = None, label: str = "", hertz: bool | None = None
) -> list[Line2D]:
    """``|r(full) - r(without it)|`` of each effect over the band: bold where it matters, thin grey where it is left out.

    Each curve bears its name at its end. ``color``, ``label``, ``hertz`` : as of ``haptisym.figures.ratios.draw_ratios``; the
    label stands behind the names. Returns the curves, in the order of the effects.

    >>> from haptisym import load_scene, relevance
    >>> ax = Figure().add_subplot()
    >>> len(draw_influences(ax, relevance(load_scene("sidestick")), Part.REAL))
    2
    """
    levels = [float(np.ravel(line.get_ydata())[0]) for line in ax.lines if line.get_label() == _TOLERANCE]
    number = len(levels)
    ink, scale = color or pen.SCENES[number % len(pen.SCENES)], scale_of(ax, found.scene.band, hertz=hertz)
    grid, curves = _sampled(found, part)
    floor, top = _limits(found, curves)
    tolerance = float(found.tolerance)
    is_told = tolerance in levels
    ax.axhline(tolerance, color=pen.GREY, linewidth=0.6, linestyle=pen.DOTTED, label=_TOLERANCE)
    styles, lines = iter(_STYLES * len(curves)), list[Line2D]()
    for influence, values in zip(found.effects, curves, strict=True):
        look = (ink, 1.2, next(styles)) if influence.kept else (pen.GREY, 0.6, "-")
        shown = np.where(values >= floor / 10, values, np.nan)
        lines += ax.plot(scale.of(grid), shown, color=look[0], linewidth=look[1], linestyle=look[2])
    dress(ax)
    low, high = (scale.of(float(x)) for x in found.scene.band)
    limit(ax, (low, high), (floor, top), number=number)
    ax.set_yscale("log")  # after the limits, as perhaps nothing that is drawn is above 0
    ax.tick_params(axis="y", which="minor", length=0)
    symbol = r"r_\mathrm{r}" if part is Part.REAL else r"r_\mathrm{i}"
    ax.set_ylabel(f"change of ${symbol}$", fontsize=pen.TEXT)
    name_frequency(ax, scale)
    told = f", {label}" if label else f" ({number + 1})" if number else ""
    ends = [
        (f"{x.effect.name}{told}", values[-1], ink if x.kept else pen.GREY)
        for x, values in zip(found.effects, curves, strict=True)
    ]
    _name_ends(ax, ends if is_told else [*ends, (f"{_TOLERANCE}{told if number else ''}", tolerance, pen.GREY)])
    return lines


_TOLERANCE = "tolerance"


def draw_dominance(ax: Axes, found: Relevance) -> list[Patch]:
    """Which effect changes the ratios most, as a strip along the band; a name that has no room is a number, told above.

    Returns the pieces.
    """
    names = list(dict.fromkeys(x.effect.name for x in found.dominance))
    start, end = (float(x) for x in found.scene.band)
    ax.set(xlim=(start, end), ylim=(0, 1))
    pieces: list[Patch] = []
    narrow: list[str] = []
    slivers: list[str] = []
    seen = set[str]()
    for x in found.dominance:
        low, high = float(x.low), float(x.high)
        face = pen.SHADE if names.index(x.effect.name) % 2 == 0 else "#c4c4c4"
        pieces.append(ax.axvspan(low, high, facecolor=face, linewidth=0))
        room, name = (high - low) / (end - start), x.effect.name
        if text_width(ax, name) >= room > text_width(ax, "1"):
            narrow += [] if name in narrow else [name]
            name = str(narrow.index(name) + 1)
        elif text_width(ax, name) >= room:
            slivers.append(name)
            name = ""
        else:
            seen.add(name)
        ax.text((low + high) / 2, 0.45, name, ha="center", va="center", fontsize=pen.SMALL, color=pen.INK)
    ax.axis("off")
    ax.set_title(_dominance_title(narrow, sorted(set(slivers) - seen - set(narrow))), **_QUIET)
    return pieces


_QUIET: dict[str, Any] = {"fontsize": pen.SMALL, "color": pen.GREY, "loc": "left", "pad": 2}


def _dominance_title(narrow: list[str], slivers: list[str]) -> str:
    """What the strip shows, the names that stand as numbers in it, and those of pieces too narrow for that."""
    told = [", ".join(f"{i} {name}" for i, name in enumerate(narrow, 1))] if narrow else []
    told += [f"in slivers {', '.join(slivers)}"] if slivers else []
    title = "changes the ratios most"
    full = f"{title}: {'; '.join(told)}" if told else title
    return full if len(full) <= 70 else f"{title}: {len(narrow) + len(slivers)} more in narrow pieces"


def influences_figure(found: Relevance) -> Figure:
    """The influences on both parts, below the strip of which effect changes them most; SceneError where there are no effects."""
    if not found.effects:
        raise SceneError("figure: the scene has no effects to draw")
    figure = Figure(figsize=(1.3 * pen.WIDTH, 4.3))
    figure.subplots_adjust(left=0.13, right=0.74, top=0.94, bottom=0.09, hspace=0.12)
    strip, real, imag = figure.subplots(3, 1, height_ratios=(0.09, 1, 1))
    draw_dominance(strip, found)
    for ax, part in ((real, Part.REAL), (imag, Part.IMAG)):
        draw_influences(ax, found, part)
    real.tick_params(labelbottom=False)
    real.set_xlabel("")
    return figure


def _sampled(found: Relevance, part: Part) -> tuple[Array, list[Array]]:
    """Frequencies, and each effect's change of a ratio there."""
    pieces = [BandPiece(_DEPTH, i) for i in range(1 << _DEPTH)]
    with series_arithmetic():
        grid = np.array([float(found.balls.middle(piece)) for piece in pieces])
        indices = range(len(found.effects))
        curves = [np.array([found.without(i, part).at_middle(piece) for piece in pieces]) for i in indices]
    return grid, curves


def _limits(found: Relevance, curves: list[Array]) -> tuple[float, float]:
    """From some decades below the tolerance, or the largest change, to a little above the largest change."""
    largest = max((float(values.max()) for values in curves), default=0.0)
    middle = float(found.tolerance) or largest or 1.0
    return middle * 10**-_DECADES, 2 * max(largest, middle)


_END = "_end"
"""The mark of names beside the axes, by which those of a scene drawn before are found."""


def _name_ends(ax: Axes, ends: list[tuple[str, float, str]]) -> None:
    """The name of each curve beside its end, those that would overlap moved apart, those that are there already, too."""
    before = [x for x in ax.texts if isinstance(x, Annotation) and x.get_label() == _END]
    rows = [(x.get_text(), float(x.xy[1]), str(x.get_color())) for x in before]
    for old in before:
        old.remove()
    low, high = np.log10(ax.get_ylim())
    seen = sorted(
        (max((np.log10(value) - low) / (high - low), 0.0), name, max(value, 10**low), color)
        for name, value, color in [*rows, *ends]
        if value
    )
    height = pen.SMALL * 1.15 * ax.figure.dpi / (72 * ax.bbox.height)
    places = spread([share for share, *_ in seen], [height] * len(seen))
    for (_, name, value, color), place in zip(seen, places, strict=True):
        ax.annotate(
            name, xy=(1, value), xytext=(1.05, place), xycoords=ax.get_yaxis_transform(), textcoords="axes fraction",
            va="center", fontsize=pen.SMALL, color=color, label=_END,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": pen.GREY, "shrinkA": 0, "shrinkB": 0, "relpos": (0, 0.5)},
        )  # fmt: skip
