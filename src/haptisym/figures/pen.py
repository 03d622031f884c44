"""Pens, colours and strokes of all figures, and the endings of the files that they are written as.

This module loads no matplotlib: a wrong name of a file is refused before anything is computed, so
the endings stand where the command line can ask for them at no cost.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from haptisym.kernel.errors import SceneError

WIDTH = 3.4
"""Inches: one column of a journal."""
TEXT, SMALL = 8.0, 7.0
"""Points: labels of axes; ticks, legends and notes."""
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


def checked(path: str | Path) -> Path:
    """Return the path of a figure; raise SceneError unless its ending is that of a figure.

    >>> checked("chart.svg").suffix
    '.svg'
    """
    target = Path(path)
    if target.suffix.lower() not in UNDATED:
        raise SceneError(f'figure: "{target.name}" must end in .svg, .pdf or .png')
    return target


def checked_report(path: str | Path) -> Path:
    """Return the path of a report; raise SceneError unless it ends as a page or as a PDF."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm", ".pdf"):
        raise SceneError(f'report: the name "{target.name}" must end in .html or .pdf')
    return target
