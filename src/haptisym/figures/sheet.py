"""A figure as a sheet: one column of a journal, with room for its legend, and its files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures.kinds import UNDATED, checked
from haptisym.figures.style import WIDTH


def save(stem: Path, figure: Figure, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """The figure as SVG, PDF and PNG, or as some of them."""
    return [save_as(figure, stem.with_name(f"{stem.name}{kind}")) for kind in kinds]


def save_as(figure: Figure, path: str | Path) -> Path:
    """The figure in one file, as its ending says, the same file for the same figure; SceneError for any other ending."""
    target = checked(path)
    with mpl.rc_context({"svg.hashsalt": "haptisym", "pdf.fonttype": 42}):
        figure.savefig(target, metadata=dict(UNDATED[target.suffix.lower()]), dpi=400)
    return target


def one_column(height: float, draw: Callable[[Axes], object], width: float = WIDTH) -> Figure:
    """A drawing of that height, in inches, without its legend; one with equal scales takes the height that it needs."""
    figure = Figure(figsize=(width, height), layout="compressed")
    ax = figure.add_subplot()
    draw(ax)
    figure.draw_without_rendering()
    if ax.get_aspect() == 1:
        height = min(0.7 + 2.8 * ax.get_data_ratio(), 3.6)
    figure.set_figheight(height + legend_height(ax))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once, so that all files look the same
    return figure


def legend_height(ax: Axes) -> float:
    """The height of the legend, in inches; 0 without one."""
    legend = ax.get_legend()
    return legend.get_window_extent().height / ax.figure.dpi if legend else 0.0
