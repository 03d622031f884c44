"""The hard cases as a figure: families against methods, the darker a cell the more of its questions are answered wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from haptisym.figures import pen
from haptisym.figures.style import dots, raised
from haptisym.verbs.cost.hardcosts import HardCosts
from haptisym.verbs.cost.measurement import HardRow
from haptisym.verbs.cost.summary import worst_verdict

_CELL, _LEFT, _LINE = 0.98, 1.95, 0.34  # inches: width of a cell, of the names of families, height of a line
_TITLES = {"evaluate": "Values of the ratios", "crossings": "Crossings"}
_DARKEST = 0.42
"""The share of ink of a cell without a right answer: figures on it are still read, in grey print too."""


def hard_costs_figure(found: HardCosts) -> Figure:
    """A table for the questions about values above one for those about crossings."""
    rows = found.rows
    groups = [[row for row in rows if row.task == task] for task in _TITLES]
    groups = [group for group in groups if group]
    sizes = [(len(_names(group, "method")), len(_names(group, "family"))) for group in groups]
    width = _LEFT + _CELL * max(columns for columns, _ in sizes) + 0.1
    height = sum(_LINE * (lines + 2.0) for _, lines in sizes) + 0.35
    figure = Figure(figsize=(width, height))
    top = height + 0.1
    for group, (columns, lines) in zip(groups, sizes, strict=True):
        top -= _LINE * 1.9
        place = (_LEFT / width, (top - _LINE * lines) / height, _CELL * columns / width, _LINE * lines / height)
        draw_table(figure.add_axes(place), group)
        top -= _LINE * lines
    figure.legend(handles=_handles(), loc="lower center", ncols=4, fontsize=pen.SMALL, frameon=False, handlelength=1.4)
    return figure


def draw_table(ax: Axes, rows: Sequence[HardRow]) -> None:
    """Families down, methods across; in each cell how many answers are right, and what is wrong with the others."""
    methods, families = _names(rows, "method"), _names(rows, "family")
    ax.set(xlim=(0, len(methods)), ylim=(len(families), 0))
    ax.set_axis_off()
    title = _TITLES[rows[0].task]
    ax.text(-_LEFT / _CELL + 0.1, -0.6, title, fontsize=pen.TEXT + 1, color=pen.INK, fontweight="bold")
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
            _draw_cell(ax, (j, i), [row for row in rows if row.family == family and row.method == method])


def draw_cases(ax: Axes, found: HardCosts) -> None:
    """How many of the hard cases each method answers, for the first task."""
    draw_table(ax, [row for row in found.rows if row.task == found.rows[0].task])


def _draw_cell(ax: Axes, place: tuple[int, int], rows: Sequence[HardRow]) -> None:
    x, y = place
    answered = [row for row in rows if row.answered]
    if not answered:
        ax.text(
            x + 0.5, y + 0.5, "cannot", fontsize=pen.SMALL, color=pen.GREY, ha="center", va="center", fontstyle="italic"
        )
        return
    right = sum(row.verdict == "right" for row in answered)
    share = 1 - right / len(answered)
    ax.add_patch(Rectangle((x + 0.02, y + 0.05), 0.96, 0.9, facecolor=_shade(share), edgecolor=pen.GREY, linewidth=0.4))
    face = pen.INK if all(row.proven for row in answered) else "white"
    ax.plot(x + 0.13, y + 0.34, color=pen.INK, **dots(4, markeredgewidth=0.8, markerfacecolor=face))
    ax.text(x + 0.22, y + 0.34, f"{right} of {len(answered)}", fontsize=pen.SMALL, color=pen.INK, va="center")
    said = _short(worst_verdict(answered)) or f"{min(row.digits for row in answered):.0f} digits"
    ax.text(x + 0.08, y + 0.71, said, fontsize=pen.SMALL - 1, color=pen.INK, va="center")


def _shade(share: float) -> Any:
    ink = to_rgb(pen.INK)
    return tuple(1 - _DARKEST * share * (1 - level) for level in ink)


def _short(verdict: str) -> str:
    """The wrong counts with signs: what is missed and what is invented."""
    return verdict.replace("misses ", "−").replace("invents ", "+").replace(" and ", "  ")


def _folded(method: str) -> str:
    return raised(method).replace(" in floats", "\nin floats").replace(" + Brent", "\n+ Brent").replace(", ", ",\n")


def _names(rows: Sequence[HardRow], attribute: str) -> list[str]:
    return list(dict.fromkeys(str(getattr(row, attribute)) for row in rows))


def _handles() -> list[Any]:
    mark = dots(4, color=pen.INK, markeredgewidth=0.8)
    return [
        Line2D([], [], **mark, label="proven"),
        Line2D([], [], markerfacecolor="white", **mark, label="not proven"),
        Patch(facecolor=_shade(1), edgecolor=pen.GREY, linewidth=0.4, label="no answer right"),
        Line2D([], [], linestyle="none", label="−  crossings missed   +  invented"),
    ]
