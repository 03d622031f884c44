"""Charts as sheets and files: one column of a journal wide, with room for legends; what every
answer draws on axes of the caller.

A sheet is laid out twice: framed, so that words are fitted to axes of their final width, and
filled, with room for the legends.
PDF files hold of each font the letters that a figure uses, without the tables by which letters are
found and set: matplotlib has placed them, and to read and cut down these tables takes most of the
time of a file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptisym.figures import pen
from haptisym.figures.greys import put_in_greys
from haptisym.figures.layers import Panel, fill, frame
from haptisym.figures.pen import UNDATED, checked
from haptisym.kernel.errors import NothingToDrawError, meant
from haptisym.model.files import replacing

if TYPE_CHECKING:
    from haptisym.judge.answers import Answer

A = TypeVar("A")


class Drawings(Generic[A]):
    """What can be drawn of a kind of answer.

    ``kinds`` : of each name the chart, the first drawn unasked. ``sheets`` : of each name of a file
    the figure; the kinds if not given. Either raises NothingToDrawError where an answer has nothing
    of the kind.
    """

    def __init__(
        self,
        kinds: Mapping[str, Callable[[A], Panel]],
        sheets: Mapping[str, Callable[[A, pen.FigureStyle], Figure]] | None = None,
    ) -> None:
        self.kinds = dict(kinds)
        self._sheets = {} if sheets is None else dict(sheets)
        self._own = sheets is not None

    def figure(
        self, answer: A, name: str = "", *, wide: bool = False, style: pen.FigureStyle = pen.SCREEN
    ) -> Figure:
        """One of the sheets, the first if none is named; one column wide, or one and a half."""
        if self._own:
            made = self._sheets[name or next(iter(self._sheets))](answer, style)
        else:
            chart = self.kinds[name or next(iter(self.kinds))](answer)
            made = sheet(chart, wide=wide, style=style)
        _estimated(made, getattr(answer, "_about", None), style)
        if style.is_paper:
            put_in_greys(made.findobj(include_self=False))
        return made

    def save(
        self,
        answer: A,
        directory: str | Path,
        format: str,  # noqa: A002
        style: pen.FigureStyle,
    ) -> list[Path]:
        """Write all of them as SVG, PDF and PNG, or in one format, in a directory that is made if
        need be."""
        folder, paths, kinds = Path(directory), list[Path](), pen.endings(format)
        folder.mkdir(parents=True, exist_ok=True)
        for name in self._sheets if self._own else self.kinds:
            try:
                figure = self.figure(answer, name, style=style)
            except NothingToDrawError:
                continue
            paths += [save_as(figure, folder / f"{name}{kind}") for kind in kinds]
        return paths


def drawings_of(found: Answer) -> Drawings[Any]:
    """What can be drawn of an answer."""
    drawings: Drawings[Any] = resolve_name(found._figure)
    return drawings


def draw_figure(found: Answer, name: str = "", *, wide: bool = False, style: str = "") -> Figure:
    """A figure of an answer by its name."""
    return drawings_of(found).figure(found, name, wide=wide, style=pen.styled(style))


def save_figures(
    found: Answer,
    directory: str | Path,
    format: str = "",  # noqa: A002
    style: str = "",
) -> list[Path]:
    """All figures of an answer as files. The same answer gives the same files, byte for byte."""
    return drawings_of(found).save(found, directory, format, pen.styled(style))


def plot(
    found: Answer,
    ax: Axes | None,
    kind: str,
    color: str | None,
    label: str,
    style: pen.FigureStyle,
    look: Mapping[str, Any],
) -> Axes:
    """Draw an answer; the axes. ``kind`` : of its drawings, the first if empty. Raises
    NothingToDrawError for any other."""
    kinds = drawings_of(found).kinds
    if kind and kind not in kinds:
        raise NothingToDrawError(
            f'kind: "{kind}" is none of this answer: {meant(kind, kinds)}these are '
            f"{', '.join(kinds)}"
        )
    chart = kinds[kind or next(iter(kinds))](found)
    axes = _axes(style) if ax is None else ax
    before = set(axes.findobj())
    fill(frame(axes, chart, color=color, label=label, style=style), chart, **look)
    if style.is_paper:
        put_in_greys(x for x in axes.findobj() if x not in before)
    return axes


def _axes(style: pen.FigureStyle) -> Axes:
    """Return new axes of pyplot: notebooks show these by themselves, and ``plt.show()`` does in a
    script."""
    from matplotlib import pyplot

    width = pen.WIDTH if style.is_paper else 1.5 * pen.WIDTH
    figure = pyplot.figure(figsize=(width, width / 1.5), layout="constrained")
    return figure.add_subplot()


# Sheets.


def sheet(
    *charts: Panel, wide: bool = False, joined: bool = True, style: pen.FigureStyle = pen.SCREEN
) -> Figure:
    """Charts above each other, each of its height without its legend; one with equal scales takes
    the height that it needs.

    ``joined`` : whether all have the lower axis of the last one.
    """
    heights = [chart.height for chart in charts]
    width = 1.5 * pen.WIDTH if wide and not style.is_paper else pen.WIDTH
    figure = Figure(figsize=(width, sum(heights)), layout="compressed")
    grid: Any = figure.subplots(
        len(charts), 1, sharex="all" if joined else "none", squeeze=False, height_ratios=heights
    )
    axes: Sequence[Axes] = grid[:, 0]
    # Legends and words are fitted to the width of the axes, which is known after a first layout of
    # the axes alone.
    frames = [frame(ax, chart, style=style) for ax, chart in zip(axes, charts, strict=True)]
    for ax in axes[:-1] if joined else ():
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")
    if len(charts) > 1:
        figure.align_ylabels()
    _arrange(figure)
    for on, chart in zip(frames, charts, strict=True):
        fill(on, chart)
        if joined and on.ax is not axes[-1]:
            on.ax.set_xlabel("")
    height = sum(heights)
    if len(axes) == 1 and axes[0].get_aspect() == 1:
        # With equal scales the ratio of the data gives the height that the width needs; 0.7 inch is
        # for the labels.
        height = min(0.7 + 2.8 * axes[0].get_data_ratio(), 3.6)
    figure.set_figheight(height + sum(map(_legend_height, axes)))
    _arrange(figure)
    with mpl.rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
        # With "none" a placeholder would stay, for which every file is drawn twice.
        figure.set_layout_engine(None)
    return figure


def _arrange(figure: Figure) -> None:
    """Lay a figure out: texts and axes are measured; to draw them would take longer."""
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.execute(figure)


def _legend_height(ax: Axes) -> float:
    """The height of the legend, in inches; 0 without one."""
    legend = ax.get_legend()
    return legend.get_window_extent().height / ax.figure.dpi if legend else 0.0


_LINE = 0.2  # inches


def _estimated(figure: Figure, about: object, style: pen.FigureStyle) -> None:
    """Add a line above a figure that says so where the numbers of the scene were estimated."""
    level = getattr(about, "level", None)
    if level is None:
        return
    width, height = figure.get_size_inches()
    share = height / (height + _LINE)
    # The figure grows by a line at its top; the axes keep their size in inches.
    for ax in figure.axes:
        box = ax.get_position()
        ax.set_position((box.x0, box.y0 * share, box.width, box.height * share))
    figure.set_size_inches(width, height + _LINE)
    said = f"estimated: {float(100 * level):g} % region of the fit"
    figure.text(0.02, 1 - 0.02 * share, said, fontsize=style.small, color=pen.GREY, va="top")


# Files.


def save_as(figure: Figure, path: str | Path) -> Path:
    """The figure in one file, as its ending says, the same file for the same figure; SceneError for
    any other ending."""
    target = checked(path)
    with (
        # The salt makes ids in SVG the same each time; type 42 embeds fonts as TrueType.
        mpl.rc_context({"svg.hashsalt": "haptisym", "pdf.fonttype": 42}),
        _letters_alone(target),
        replacing(target) as fresh,
    ):
        figure.savefig(fresh, metadata=dict(UNDATED[target.suffix.lower()]), dpi=400)
    return target


_SETTING = ("GDEF", "GPOS", "GSUB", "MATH", "kern")
"""Tables of a font by which letters are placed and combined, which matplotlib has done."""


@contextmanager
def _letters_alone(target: Path) -> Iterator[None]:
    """Write fonts of a PDF file without these tables while the context lasts; they are not even
    read."""
    if target.suffix.lower() != ".pdf":
        yield
        return
    fonts: Any = import_module("fontTools.subset")
    load = fonts.load_font

    def bare(*given: Any) -> Any:
        font = load(*given)
        for table in {*_SETTING} & {*font.keys()}:
            del font[table]
        # Which glyph a letter is, matplotlib knows: it asks for glyphs, so an empty table will do.
        font["cmap"] = fonts.ttLib.newTable("cmap")
        font["cmap"].tableVersion, font["cmap"].tables = 0, []
        return font

    fonts.load_font = bare
    try:
        yield
    finally:
        # The function belongs to another package: it is put back whatever happens.
        fonts.load_font = load
