"""A figure as a sheet: one column of a journal, with room for its legend; and all figures of an answer as files."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Generic, TypeVar

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures import pen
from haptisym.figures.kinds import UNDATED, checked

A = TypeVar("A")


class Drawings(Generic[A]):
    """The figures of a kind of answer by their names: how high each is, in inches, and what draws it.

    ``without`` : the names of those for which an answer has nothing.
    """

    def __init__(
        self, rows: Mapping[str, tuple[float, Callable[[Axes, A], object]]], without: Callable[[A], Collection[str]]
    ) -> None:
        self._rows = MappingProxyType(dict(rows))
        self._without = without

    def figure(self, answer: A, name: str, *, wide: bool = False) -> Figure:
        """One of them, one column wide, or one and a half."""
        height, draw = self._rows[name]
        found = one_column(height, lambda ax: draw(ax, answer), 1.5 * pen.WIDTH if wide else pen.WIDTH)
        return estimated(found, getattr(answer, "scene", None))

    def save(self, answer: A, directory: str | Path, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
        """All of them as files, as of ``save_all``."""
        without = self._without(answer)
        return save_all(
            {name: self.figure(answer, name) for name in self._rows if name not in without}, directory, kinds
        )


def estimated(figure: Figure, about: object) -> Figure:
    """The same, with a line above it that says so where the numbers of a scene were estimated."""
    level = getattr(about, "level", None)
    if level is None:
        return figure
    width, height = figure.get_size_inches()
    share = height / (height + _LINE)
    for ax in figure.axes:
        box = ax.get_position()
        ax.set_position((box.x0, box.y0 * share, box.width, box.height * share))
    figure.set_size_inches(width, height + _LINE)
    said = f"estimated: {float(100 * level):g} % region of the fit"
    figure.text(0.02, 1 - 0.02 * share, said, fontsize=pen.SMALL, color=pen.GREY, va="top")
    return figure


_LINE = 0.2  # inches


def save_all(figures: Mapping[str, Figure], directory: str | Path, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """Figures by their names as SVG, PDF and PNG, or as some of them, in a directory that is made if need be.

    The same figures give the same files, byte for byte.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    return [path for name, figure in figures.items() for path in save(folder / name, figure, kinds)]


def save(stem: Path, figure: Figure, kinds: Iterable[str] = tuple(UNDATED)) -> list[Path]:
    """The figure as SVG, PDF and PNG, or as some of them."""
    return [save_as(figure, stem.with_name(f"{stem.name}{kind}")) for kind in kinds]


def save_as(figure: Figure, path: str | Path) -> Path:
    """The figure in one file, as its ending says, the same file for the same figure; SceneError for any other ending."""
    target = checked(path)
    with mpl.rc_context({"svg.hashsalt": "haptisym", "pdf.fonttype": 42}):
        figure.savefig(target, metadata=dict(UNDATED[target.suffix.lower()]), dpi=400)
    return target


def one_column(height: float, draw: Callable[[Axes], object], width: float = pen.WIDTH) -> Figure:
    """A drawing of that height, in inches, without its legend; one with equal scales takes the height that it needs."""
    figure = Figure(figsize=(width, height), layout="compressed")
    ax = figure.add_subplot()
    draw(ax)
    return laid_out(figure, height, ax)


def stacked(height: float, *panels: tuple[float, Callable[[Axes], object]], aligned: bool = False) -> Figure:
    """Drawings above each other over one axis of frequencies: the share of that height that each has, and what draws it.

    ``aligned`` : whether the labels of the upright axes stand below each other.
    """
    figure = Figure(figsize=(pen.WIDTH, height), layout="compressed")
    shares = [share for share, _ in panels]
    axes = list(figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=shares)[:, 0])
    for ax, (_, draw) in zip(axes, panels, strict=True):
        draw(ax)
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")
    if aligned:
        figure.align_ylabels()
    return laid_out(figure, height, *axes)


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
