"""The figure of a scene's influences: what each effect changes, along the band, and which one changes most."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.errors import SceneError
from haptisym.figures.style import GREY, INK, SHADE, SMALL, TEXT, WIDTH, _spread, dress, save_as, text_width
from haptisym.jnd import Part
from haptisym.numeric.values import Array

from .ballchain import Piece, series_arithmetic
from .relevance import Relevance

_DEPTH = 8  # 2^8 samples along the band
_DECADES = 3.5  # below the tolerance that are shown
_STYLES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)))


def draw_influences(ax: Axes, found: Relevance, part: Part) -> None:
    """``|r(full) - r(without it)|`` of each effect over the band: black where it matters, grey where it is left out."""
    grid, curves = _sampled(found, part)
    floor, top = _limits(found, curves)
    tolerance = float(found.tolerance)
    ax.axhline(tolerance, color=GREY, linewidth=0.6, linestyle=(0, (1, 2)))
    styles = iter(_STYLES * len(curves))
    for influence, values in zip(found.effects, curves, strict=True):
        look = (INK, 1.2, next(styles)) if influence.kept else (GREY, 0.6, "-")
        shown = np.where(values >= floor / 10, values, np.nan)
        ax.plot(grid, shown, color=look[0], linewidth=look[1], linestyle=look[2])
    dress(ax)
    ax.set_yscale("log")
    ax.set(xlim=[float(x) for x in found.scene.band], ylim=(floor, top))
    ax.tick_params(axis="y", which="minor", length=0)
    symbol = r"r_\mathrm{r}" if part is Part.REAL else r"r_\mathrm{i}"
    ax.set_ylabel(f"change of ${symbol}$", fontsize=TEXT)
    ends = [
        (x.effect.name, values[-1], INK if x.kept else GREY) for x, values in zip(found.effects, curves, strict=True)
    ]
    _name_ends(ax, [*ends, ("tolerance", tolerance, GREY)])


def draw_dominance(ax: Axes, found: Relevance) -> None:
    """Which effect changes the ratios most, as a strip along the band."""
    names = list(dict.fromkeys(x.effect.name for x in found.dominance))
    ax.set(xlim=[float(x) for x in found.scene.band], ylim=(0, 1))
    for x in found.dominance:
        low, high = float(x.low), float(x.high)
        face = SHADE if names.index(x.effect.name) % 2 == 0 else "#c4c4c4"
        ax.axvspan(low, high, facecolor=face, linewidth=0)
        if text_width(ax, x.effect.name) < (high - low) / float(found.scene.band[1] - found.scene.band[0]):
            ax.text((low + high) / 2, 0.45, x.effect.name, ha="center", va="center", fontsize=SMALL, color=INK)
    ax.axis("off")
    ax.set_title("changes the ratios most", fontsize=SMALL, color=GREY, loc="left", pad=2)


def save_influences(found: Relevance, path: str | Path) -> Path:
    """The figure of both parts as .svg, .pdf or .png, by the ending of the file's name; SceneError for any other."""
    if not found.effects:
        raise SceneError("figure: the scene has no effects to draw")
    figure = Figure(figsize=(1.3 * WIDTH, 4.3))
    figure.subplots_adjust(left=0.13, right=0.74, top=0.94, bottom=0.09, hspace=0.12)
    strip, real, imag = figure.subplots(3, 1, height_ratios=(0.09, 1, 1))
    draw_dominance(strip, found)
    for ax, part in ((real, Part.REAL), (imag, Part.IMAG)):
        draw_influences(ax, found, part)
    real.tick_params(labelbottom=False)
    imag.set_xlabel(r"$\omega$ (rad/s)", fontsize=TEXT)
    return save_as(figure, path)


def _sampled(found: Relevance, part: Part) -> tuple[Array, list[Array]]:
    """Frequencies, and each effect's change of a ratio there."""
    pieces = [Piece(_DEPTH, i) for i in range(1 << _DEPTH)]
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


def _name_ends(ax: Axes, ends: list[tuple[str, float, str]]) -> None:
    """The name of each curve beside its end, those that would overlap moved apart."""
    low, high = np.log10(ax.get_ylim())
    seen = sorted(
        (max((np.log10(value) - low) / (high - low), 0.0), name, color) for name, value, color in ends if value
    )
    height = SMALL * 1.15 * ax.figure.dpi / (72 * ax.bbox.height)
    places = _spread([share for share, _, _ in seen], [height] * len(seen))
    for (share, name, color), place in zip(seen, places, strict=True):
        ax.annotate(
            name, xy=(1, share), xytext=(1.05, place), xycoords="axes fraction", textcoords="axes fraction", va="center",
            fontsize=SMALL, color=color,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 0, "shrinkB": 0, "relpos": (0, 0.5)},
        )  # fmt: skip
