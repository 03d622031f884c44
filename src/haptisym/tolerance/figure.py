"""A figure of tolerances: the guaranteed enclosures as bars, the crossings of the drawn sets of values as dots on them."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.errors import NothingToDrawError
from haptisym.figures.style import BLUE, INK, SHADE, SMALL, TEXT, WIDTH, save_as
from haptisym.jnd import Part

from .proofs import BoxAnswers

_NAMES = {Part.REAL: r"$r_\mathrm{r} = c$", Part.IMAG: r"$r_\mathrm{i} = c$"}


def draw_tolerances(ax: Axes, a: BoxAnswers) -> None:
    """A row for each part: grey where it may cross, proven; blue dots for each drawn set; a stroke for the nominal values."""
    low, high = (float(x) for x in a.box.scene.band)
    for row, part in enumerate(Part):
        for x in a.enclosures:
            if x.part is part:
                ax.barh(row, float(x.high) - float(x.low), left=float(x.low), height=0.7, color=SHADE, zorder=1)
        drawn = [(float(x), n) for n, one in enumerate(a.samples) for x in one.crossings[part]]
        heights = [row + 0.5 * ((n * 0.618) % 1 - 0.5) for _, n in drawn]  # spread evenly, to tell dots apart
        ax.plot([x for x, _ in drawn], heights, ".", markersize=1.6, color=BLUE, zorder=2)
        nominal = [float(x) for x in a.nominal.crossings[part]]
        ax.vlines(nominal, row - 0.35, row + 0.35, color=INK, linewidth=1.1, zorder=3)
    ax.set(xlim=(low, high), ylim=(len(Part) - 0.5, -0.5))
    ax.set_yticks(range(len(Part)), [_NAMES[part] for part in Part], fontsize=TEXT)
    ax.tick_params(labelsize=SMALL, length=2, width=0.5, color=INK)
    ax.tick_params(axis="y", length=0, labelsize=TEXT)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.set_xlabel(r"$\omega$ (rad/s)", fontsize=TEXT)
    ax.set_title("grey: guaranteed for all values; dots: drawn at random; stroke: nominal", fontsize=SMALL, loc="left")


def save_tolerances(a: BoxAnswers, path: Path) -> None:
    """The figure in a file; SceneError for another ending than .svg, .pdf or .png, or where no values bring a crossing."""
    if not a.enclosures and not any(x.crossings[part] for x in (a.nominal, *a.samples) for part in Part):
        raise NothingToDrawError("no ratio meets its threshold on the band, for any values within the ranges")
    figure = Figure(figsize=(WIDTH + 0.6, 1.6), layout="constrained")
    draw_tolerances(figure.subplots(), a)
    save_as(figure, path)
