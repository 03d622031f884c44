"""Figures of what accuracy costs: correct digits over seconds, both logarithmic, a panel for each
question; and the hard cases as a table.

Filled marks are proven, open ones are not. The lines are the Pareto fronts of all methods and of
the proven ones: no method has more digits in less time. Answers with a wrong number of crossings,
or without a correct digit, stand on the grey strip below.

The table has families of hard cases down and methods across; the darker a cell, the more of its
questions are answered wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import fill, wrap
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from haptisym.figures import pen
from haptisym.figures.files import Drawings
from haptisym.figures.layers import Layer, On, Panel, Room, dots, number, raised, small, thin
from haptisym.verbs.cost.entry import Cost, CostMeasurement, duration, front
from haptisym.verbs.cost.hardcosts import HardCosts, HardRow, worst_verdict
from haptisym.writing.characters import printable

_PANEL, _ALONE = (3.5, 2.7), (6.8, 3.6)
"""Inches: a panel among others, and one alone."""
_LEAST = 0.7
"""Right digits below which there are none to speak of."""
_STRIP = 0.4
"""Where answers stand that have none, or a wrong count."""
_DASHED: Any = (0, (3, 2))
_TITLES = {
    "evaluate": "Evaluating the ratios at one frequency",
    "crossings": "Finding all crossings",
    "delay": "Approximating the delay",
    "effects": "Leaving an effect out",
}


def draw_cost(
    ax: Axes, rows: Sequence[CostMeasurement], style: pen.FigureStyle = pen.SCREEN
) -> None:
    """Right digits over time for the methods of one task."""
    thin(ax, style)
    ax.set(xscale="log", yscale="log")
    times = [row.seconds for row in rows]
    ax.set_xlim(min(times) / 3, max(times) * 3)
    ax.set_ylim(_STRIP / 1.5, 2.5 * max(20.0, *(row.digits for row in rows)))
    ax.axhspan(ax.get_ylim()[0], _LEAST / 1.1, facecolor=pen.SHADE, linewidth=0, zorder=0)
    # A method without a correct digit is no point of a front, however quick it is.
    telling = [row for row in rows if row.digits > _LEAST]
    _draw_front(ax, telling, color=pen.GREY, linewidth=0.9, linestyle=_DASHED)
    _draw_front(ax, [row for row in telling if row.proven], color=pen.INK, linewidth=1.2)
    for row in rows:
        _mark(ax, row)
    _dress(ax)
    ax.set_title(_TITLES[rows[0].task], fontsize=pen.TEXT, loc="left", color=pen.INK)
    ax.set_xlabel("time", fontsize=small(ax))
    ax.set_ylabel("correct digits", fontsize=small(ax))


@dataclass(frozen=True)
class _Panel(Layer):
    """Methods of one task, or a table of hard cases."""

    rows: Sequence[CostMeasurement] | Sequence[HardRow]
    put: Any

    def draw(self, on: On) -> list[Artist]:
        self.put(on.ax, self.rows)
        return []


def task(found: Cost) -> Panel:
    """Return a panel of correct digits over time for the methods of the first task."""
    return Panel([_Panel(found.task(found.rows[0].task), draw_cost)])


def _place(row: CostMeasurement) -> tuple[float, float]:
    """Return the place of a method's mark: on the strip below if a count is wrong or no digit is
    correct."""
    return row.seconds, row.digits if row.complete and row.digits > _LEAST else _STRIP


def _draw_front(ax: Axes, rows: Iterable[CostMeasurement], **style: Any) -> None:
    """Draw the steps of the methods that none beats in both digits and time."""
    best = front(rows)
    if best:
        # The best method stays the best for all longer times: its step goes on to the rim.
        end = (ax.get_xlim()[1], best[-1].digits)
        places = [*((row.seconds, row.digits) for row in best), end]
        ax.plot(*zip(*places, strict=True), drawstyle="steps-post", zorder=2, **style)


def _mark(ax: Axes, row: CostMeasurement) -> None:
    """Draw the mark of a method: filled if its answers are proven."""
    ax.plot(
        *_place(row),
        color=pen.INK,
        zorder=4,
        **dots(4.6, markerfacecolor=pen.INK if row.proven else "white", markeredgewidth=0.9),
    )


def _dress(ax: Axes) -> None:
    """Set the ticks of times and of digits."""
    ax.xaxis.set_major_locator(LogLocator(numticks=8))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: duration(x).replace("us", "µs")))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda y, _: number(y)))
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_minor_locator(NullLocator())
    ax.set_yticks([y for y in (1, 3, 10, 16, 30, 100, 300, 1000) if y < ax.get_ylim()[1]])
    ax.grid(visible=True, axis="y", color=pen.SHADE, linewidth=0.5, zorder=0)
    ax.set_axisbelow(True)


# Names beside the marks, clear of marks and of each other.


def _draw_names(ax: Axes, rows: Sequence[CostMeasurement]) -> None:
    """Write the name of each method beside its mark, where it covers neither a mark nor another
    name; once the axes have their size."""
    room, size = Room(ax), small(ax)
    for row in rows:
        room.take_point(*_place(row))
    for line in ax.get_lines():
        if line.get_drawstyle() == "steps-post":
            x = np.asarray(line.get_xdata(), dtype=float)
            y = np.asarray(line.get_ydata(), dtype=float)
            # The corners of the steps, which matplotlib draws without storing them: each time with
            # the digits before it and after it.
            room.take_line(np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1])
    for row in sorted(rows, key=_place, reverse=True):
        name = raised(f"{row.method}: {row.wrong}" if row.wrong else row.method)
        right, up = room.beside(*_place(row), name, size)
        # A line leads to a name that is not right beside its mark.
        leader = (
            pen.LEADER
            if max(abs(right), abs(up)) > 2 * size and (up > size or up < -2 * size)
            else None
        )
        ax.annotate(
            name,
            _place(row),
            xytext=(right, up),
            textcoords="offset points",
            fontsize=size,
            color=pen.INK,
            va="bottom",
            zorder=5,
            arrowprops=leader,
        )


# The whole figure.


def cost_figure(found: Cost, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """A panel for each task, two in a row; what the marks mean stands below, or in the place that
    is left."""
    rows = found.rows
    groups = [group for task in _TITLES if (group := [row for row in rows if row.task == task])]
    columns = 1 if style.is_paper else min(2, len(groups))
    lines = -(-len(groups) // columns)
    width, height = _PANEL if columns > 1 else _ALONE
    width = pen.WIDTH if style.is_paper else width
    figure = Figure(figsize=(width * columns, height * lines + 0.3), layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    for ax, group in zip(axes, groups, strict=False):
        draw_cost(ax, group, style)
    figure.suptitle(
        "\n".join(wrap(printable(found.scene.title), 44 if style.is_paper else 88)),
        fontsize=pen.TEXT + 1,
        color=pen.INK,
    )
    look: dict[str, Any] = {
        "handles": _handles(rows),
        "fontsize": style.small,
        "frameon": False,
        "handlelength": 2,
    }
    if len(groups) < len(axes):
        _explain(axes[-1], found.summary, look)
    else:
        figure.legend(loc="outside lower center", ncols=2 if style.is_paper else 5, **look)
    # Names are placed beside marks in points of the page. So axes get their sizes first, and the
    # engine that set them is taken off: it would move them again on saving.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for ax, group in zip(axes, groups, strict=False):
        _draw_names(ax, group)
    return figure


def _explain(ax: Axes, said: str, look: dict[str, Any]) -> None:
    """Write the summary and the legend in the place of a panel."""
    ax.set_axis_off()
    summary = fill(raised(said.replace(" us", " µs")), 52)
    ax.text(
        0,
        0.97,
        summary,
        fontsize=pen.SMALL,
        color=pen.INK,
        va="top",
        linespacing=1.5,
        transform=ax.transAxes,
    )
    ax.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.0), labelspacing=0.6, **look)


def _handles(rows: Sequence[CostMeasurement]) -> list[Any]:
    """Return the entries of the legend, only for what is drawn."""
    mark = dots(4.6, color=pen.INK, markeredgewidth=0.9)
    proven = any(row.proven for row in rows)
    return [
        *([Line2D([], [], **mark, label="proven")] if proven else []),
        Line2D([], [], markerfacecolor="white", **mark, label="not proven"),
        *(
            [Line2D([], [], color=pen.INK, linewidth=1.2, label="best of the proven")]
            if proven
            else []
        ),
        Line2D([], [], color=pen.GREY, linewidth=0.9, linestyle=_DASHED, label="best of all"),
        Patch(facecolor=pen.SHADE, label="no correct digit, or a wrong count"),
    ]


_CELL, _LEFT, _LINE = 0.98, 1.95, 0.34
"""Inches: width of a cell, width of the names of families, height of a line."""
_TABLES = {"evaluate": "Values of the ratios", "crossings": "Crossings"}
_DARKEST = 0.42
"""The share of ink of a cell without a right answer: figures on it are still read, in grey print
too."""


def hard_costs_figure(found: HardCosts, style: pen.FigureStyle = pen.SCREEN) -> Figure:
    """A table for the questions about values above one for those about crossings, wider than a
    column in every style."""
    rows = found.rows
    groups = [[row for row in rows if row.task == task] for task in _TABLES]
    groups = [group for group in groups if group]
    sizes = [(len(_names(group, "method")), len(_names(group, "family"))) for group in groups]
    width = _LEFT + _CELL * max(columns for columns, _ in sizes) + 0.1
    height = sum(_LINE * (lines + 2.0) for _, lines in sizes) + 0.35
    figure = Figure(figsize=(width, height))
    top = height + 0.1
    for group, (columns, lines) in zip(groups, sizes, strict=True):
        # About two lines of room for the heads above each table.
        top -= _LINE * 1.9
        place = (
            _LEFT / width,
            (top - _LINE * lines) / height,
            _CELL * columns / width,
            _LINE * lines / height,
        )
        draw_table(figure.add_axes(place), group)
        top -= _LINE * lines
    figure.legend(
        handles=_table_handles(),
        loc="lower center",
        ncols=4,
        fontsize=pen.SMALL,
        frameon=False,
        handlelength=1.4,
    )
    return figure


def draw_table(ax: Axes, rows: Sequence[HardRow]) -> None:
    """Families down, methods across; in each cell how many answers are right, and what is wrong
    with the others."""
    methods, families = _names(rows, "method"), _names(rows, "family")
    # The axis goes downwards, so that the first family is on top.
    ax.set(xlim=(0, len(methods)), ylim=(len(families), 0))
    ax.set_axis_off()
    title = _TABLES[rows[0].task]
    ax.text(
        -_LEFT / _CELL + 0.1, -0.6, title, fontsize=pen.TEXT + 1, color=pen.INK, fontweight="bold"
    )
    for j, method in enumerate(methods):
        ours = any(row.ours for row in rows if row.method == method)
        weight = "bold" if ours else "normal"
        ax.text(
            j + 0.5,
            -0.2,
            _folded(method),
            fontsize=pen.SMALL,
            color=pen.INK,
            ha="center",
            va="bottom",
            fontweight=weight,
        )
    for i, family in enumerate(families):
        ax.text(-0.08, i + 0.5, family, fontsize=pen.SMALL, color=pen.INK, ha="right", va="center")
        for j, method in enumerate(methods):
            _draw_cell(
                ax, (j, i), [row for row in rows if row.family == family and row.method == method]
            )


def cases(found: HardCosts) -> Panel:
    """How many of the hard cases each method answers, for the first task."""
    return Panel(
        [_Panel([row for row in found.rows if row.task == found.rows[0].task], draw_table)]
    )


def _draw_cell(ax: Axes, place: tuple[int, int], rows: Sequence[HardRow]) -> None:
    """Draw one family with one method: how many answers are right, whether all are proven, and the
    worst of the others."""
    x, y = place
    answered = [row for row in rows if row.answered]
    if not answered:
        ax.text(
            x + 0.5,
            y + 0.5,
            "cannot",
            fontsize=pen.SMALL,
            color=pen.GREY,
            ha="center",
            va="center",
            fontstyle="italic",
        )
        return
    right = sum(row.verdict == "right" for row in answered)
    share = 1 - right / len(answered)
    ax.add_patch(
        Rectangle(
            (x + 0.02, y + 0.05),
            0.96,
            0.9,
            facecolor=_shade(share),
            edgecolor=pen.GREY,
            linewidth=0.4,
        )
    )
    # One answer that is not proven leaves the mark open.
    face = pen.INK if all(row.proven for row in answered) else "white"
    ax.plot(x + 0.13, y + 0.34, color=pen.INK, **dots(4, markeredgewidth=0.8, markerfacecolor=face))
    ax.text(
        x + 0.22,
        y + 0.34,
        f"{right} of {len(answered)}",
        fontsize=pen.SMALL,
        color=pen.INK,
        va="center",
    )
    said = _short(worst_verdict(answered)) or f"{min(row.digits for row in answered):.0f} digits"
    ax.text(x + 0.08, y + 0.71, said, fontsize=pen.SMALL - 1, color=pen.INK, va="center")


def _shade(share: float) -> Any:
    """Return the grey of a cell, by the share of its questions that are answered wrong."""
    ink = to_rgb(pen.INK)
    return tuple(1 - _DARKEST * share * (1 - level) for level in ink)


def _short(verdict: str) -> str:
    """Return a verdict with signs: − for crossings that are missed, + for invented ones."""
    return verdict.replace("misses ", "−").replace("invents ", "+").replace(" and ", "  ")


def _folded(method: str) -> str:
    """Return the name of a method in lines that fit above a column."""
    return (
        raised(method)
        .replace(" in floats", "\nin floats")
        .replace(" + Brent", "\n+ Brent")
        .replace(", ", ",\n")
    )


def _names(rows: Sequence[HardRow], attribute: str) -> list[str]:
    """Return the names of methods, or of families, in the order in which they come."""
    return list(dict.fromkeys(str(getattr(row, attribute)) for row in rows))


def _table_handles() -> list[Any]:
    """Return the entries of the legend of the tables."""
    mark = dots(4, color=pen.INK, markeredgewidth=0.8)
    return [
        Line2D([], [], **mark, label="proven"),
        Line2D([], [], markerfacecolor="white", **mark, label="not proven"),
        Patch(facecolor=_shade(1), edgecolor=pen.GREY, linewidth=0.4, label="no answer right"),
        Line2D([], [], linestyle="none", label="−  crossings missed   +  invented"),
    ]


COST = Drawings[Cost]({"time": task}, {"cost": cost_figure})
HARD = Drawings[HardCosts]({"cases": cases}, {"hard-cases": hard_costs_figure})
