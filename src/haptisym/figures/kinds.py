"""What files figures are written as. Loads no matplotlib, so that a wrong name is told before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from haptisym.kernel.errors import SceneError

UNDATED: Mapping[str, Mapping[str, None]] = MappingProxyType(
    {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {"Software": None}}
)
"""The endings, and what is left out of each so that the same figure gives the same file."""


def checked(path: str | Path) -> Path:
    """The path of a figure; SceneError unless it ends as one.

    >>> checked("chart.svg").suffix
    '.svg'
    """
    target = Path(path)
    if target.suffix.lower() not in UNDATED:
        raise SceneError(f'figure: "{target.name}" must end in .svg, .pdf or .png')
    return target


def checked_report(path: str | Path) -> Path:
    """The path of a report; SceneError unless it ends as one."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm", ".pdf"):
        raise SceneError(f'report: the name "{target.name}" must end in .html or .pdf')
    return target
