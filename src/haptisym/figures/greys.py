"""Figures in greys, for print without colours: each colour becomes the grey that is as light, and
grounds that only their colours distinguish get hatches.

Curves keep their strokes and marks, which distinguish them in grey.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import Collection
from matplotlib.colors import ListedColormap, to_hex, to_rgba_array
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation, Text

from haptisym.figures import pen
from haptisym.programs.values import Array

_HATCHES = {pen.UNSTABLE: "\\\\\\\\", pen.OPEN: "...."}
"""Grounds that are as light as others, and their hatches."""
_UNDER_NAMES = "#c8c8c8"
"""Lines of a hatch over which names can be read."""
_LINEAR = 0.04045, 12.92, 0.055, 2.4
"""sRGB (IEC 61966-2-1): below the first number a value is a multiple of the light, above it a
power."""
_LIGHT = np.array([0.2126, 0.7152, 0.0722])
"""How much red, green and blue light count for luminance."""


def greys(colors: Any) -> Array:
    """Return colours as greys of the same luminance, red, green, blue and opacity in rows.

    >>> greys(["#ffffff", "none", "#00000080"]).round(2).tolist()
    [[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5]]
    """
    rows = to_rgba_array(colors)
    start, slope, offset, power = _LINEAR
    rgb = rows[:, :3]
    light = np.where(rgb <= start, rgb / slope, ((rgb + offset) / (1 + offset)) ** power) @ _LIGHT
    level = np.where(
        light <= start / slope, light * slope, (1 + offset) * light ** (1 / power) - offset
    )
    return np.column_stack([level, level, level, rows[:, 3]]).clip(0, 1)


def put_in_greys(artists: Iterable[Artist]) -> None:
    """Give artists greys in place of their colours, and grounds their hatches."""
    for x in artists:
        if isinstance(x, Line2D):
            x.set(
                color=_grey(x.get_color()),
                markerfacecolor=_grey(x.get_markerfacecolor()),
                markeredgecolor=_grey(x.get_markeredgecolor()),
            )
        elif isinstance(x, Text):
            x.set_color(_grey(x.get_color()))
            patches = [x.get_bbox_patch(), x.arrow_patch if isinstance(x, Annotation) else None]
            put_in_greys(y for y in patches if y is not None)
        elif isinstance(x, Patch):
            hatch = _hatch(x.get_facecolor())
            # The edge is also the colour of the hatch; widths of 0 leave it unseen elsewhere.
            x.set(facecolor=_grey(x.get_facecolor()), edgecolor=_grey(x.get_edgecolor()))
            if hatch:
                x.set(hatch=hatch, edgecolor=_grey(pen.GREY))
        elif isinstance(x, Collection):
            _collection(x)


def _collection(x: Collection) -> None:
    """Give a collection greys: its map of values, or its faces and edges."""
    if x.get_array() is not None:
        colors = x.get_cmap()(np.linspace(0, 1, 256))
        x.set_cmap(ListedColormap(greys(colors)))
        # A ground of filled contours has a map of its one colour.
        hatch = _hatch(colors[0]) if (colors == colors[0]).all() else ""
        if hatch:
            x.set(hatch=hatch, edgecolor=_UNDER_NAMES, linewidth=0)
        return
    faces, edges = x.get_facecolor(), x.get_edgecolor()
    hatch = _hatch(faces[0]) if len(faces) else ""
    if len(edges):
        x.set_edgecolor(greys(edges).tolist())
    if len(faces):
        x.set_facecolor(greys(faces).tolist())
    if hatch:
        x.set_hatch(hatch)
        x.set_edgecolor(_grey(pen.GREY))


def _grey(color: Any) -> Any:
    """Return one colour as a grey."""
    return tuple(greys([color])[0])


def _hatch(color: Any) -> str:
    """Return the hatch of a ground in place of its colour; empty for one that needs none."""
    return _HATCHES.get(to_hex(color), "")
