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
    return laid_out(figure, height, ax)


def laid_out(figure: Figure, height: float, *axes: Axes) -> Figure:
    """The same figure, with room for the legends of its axes above that height; laid out once, so that all files look the same.

    Texts and axes are measured; nothing is drawn, which takes longer.
    """
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.execute(figure)
    [first, *others] = axes
    if not others and first.get_aspect() == 1:
        height = min(0.7 + 2.8 * first.get_data_ratio(), 3.6)
    figure.set_figheight(height + sum(map(_legend_height, axes)))
    engine.execute(figure)
    figure.set_layout_engine("none")
    return figure


def _legend_height(ax: Axes) -> float:
    """The height of the legend, in inches; 0 without one."""
    legend = ax.get_legend()
    return legend.get_window_extent().height / ax.figure.dpi if legend else 0.0
