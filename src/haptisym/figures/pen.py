"""Pens, colours and strokes of all figures, and the endings of the files that they are written as.

This module loads no matplotlib: a wrong name of a file is refused before anything is computed, so
the endings stand where the command line can ask for them at no cost.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from haptisym.kernel.errors import SceneError

WIDTH = 3.4
"""Inches: one column of a journal."""
TEXT, SMALL = 8.0, 7.0
"""Points: labels of axes; ticks, legends and notes."""


@dataclass(frozen=True)
class FigureStyle:
    """A style says how figures are set: the size of ticks, legends and notes, pt; whether in greys
    alone and never wider than one column."""

    small: float = SMALL
    is_paper: bool = False


SCREEN, PAPER = FigureStyle(), FigureStyle(TEXT, is_paper=True)
STYLES: Mapping[str, FigureStyle] = MappingProxyType({"": SCREEN, "paper": PAPER})
"""The styles of figures by their names; the usual one has none."""


def styled(name: str) -> FigureStyle:
    """Return a style by its name; raise SceneError for an unknown one."""
    if name not in STYLES:
        raise SceneError(
            f'style: "{name}" is unknown: valid is "paper"; leave it out for the usual one'
        )
    return STYLES[name]


INK, BLUE, RED, GREY, SHADE = "#222222", "#1f4e9e", "#c03028", "#7a7a7a", "#e6e6e6"
UNSTABLE = "#f3dcd8"  # the ground where a hand is shaken
OPEN = "#f2c14e"  # the ground where nothing is decided
SOLID: Any = "-"
DASHED: Any = (0, (4, 1.6))
DOTTED: Any = (0, (1, 2))
LEADER = {"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "shrinkA": 0, "shrinkB": 0}
STROKES = (SOLID, DASHED, DOTTED)
"""Strokes of the curves of a scene's criteria, in their order."""
SCENES = (INK, "#d0701f", BLUE, "#7cc0c8", "#8f5a9e")
"""Colours of the first, second, ... scene that is drawn on the same axes."""
CURVES = ((BLUE, SOLID, r"H_\mathrm{env}"), (RED, DASHED, r"H_\mathrm{perc}"))
"""Colour, stroke and name of environment and perceived dynamics."""

MOST_LABELS = 12
"""Crossings whose frequencies are written in a figure, at most; of more their numbers in the table
of the page."""

UNDATED: Mapping[str, Mapping[str, None]] = MappingProxyType(
    # matplotlib writes the day, or its own version, unless an entry is None: either would change
    # the file without a change of the figure.
    {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {"Software": None}}
)
"""The endings of figures, and what is left out of each so that the same figure gives the same
file."""


def endings(format: str = "") -> tuple[str, ...]:  # noqa: A002  as matplotlib calls it
    """Return the endings of figures, or that of one format; raise SceneError for an unknown one."""
    if format and f".{format}" not in UNDATED:
        valid = ", ".join(x.removeprefix(".") for x in UNDATED)
        raise SceneError(f'format: "{format}" is unknown: valid are {valid}')
    return (f".{format}",) if format else tuple(UNDATED)


def checked(path: str | Path, format: str = "") -> Path:  # noqa: A002
    """Return the path of a figure; raise SceneError unless its ending is that of a figure, and of
    the format if one is given.

    A name without an ending gets that of the format.

    >>> checked("chart.svg").suffix, checked("chart", "pdf").name
    ('.svg', 'chart.pdf')
    """
    target, valid = Path(path), endings(format)
    if format and target.suffix.lower() not in UNDATED:
        return target.with_name(target.name + valid[0])
    if target.suffix.lower() not in valid:
        wanted = f"{valid[0]} as the format is {format}" if format else ".svg, .pdf or .png"
        raise SceneError(f'figure: "{target.name}" must end in {wanted}')
    return target


def checked_report(path: str | Path) -> Path:
    """Return the path of a report; raise SceneError unless it ends as a page or as a PDF."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm", ".pdf"):
        raise SceneError(f'report: the name "{target.name}" must end in .html or .pdf')
    return target
