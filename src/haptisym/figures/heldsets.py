"""Where the sets of a sweep are not stable in a hand: hatched over the one parameter, or on the map of two."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from haptisym.figures.style import GREY, RED
from haptisym.programs.values import Array
from haptisym.verbs.sweep.told import HELD, UNKNOWN

if TYPE_CHECKING:
    import xarray as xr

_HATCHES = ("////", "\\\\\\\\", "||||", "----")


def held_in(data: xr.Dataset) -> list[str]:
    """The variables of a sweep that tell of a hand."""
    return [str(name) for name in data.data_vars if str(name).startswith(HELD)]


def draw_held_curves(ax: Axes, data: xr.Dataset, x: Array) -> list[Patch]:
    """Upright strips about the sets that are not stable in a hand, over the values of one parameter; entries for a legend."""

    def strip(where: Any, style: dict[str, Any]) -> None:
        ax.fill_between(x, 0, 1, where=where, step="mid", transform=ax.get_xaxis_transform(), zorder=0, **style)

    return _each(data, strip)


def draw_held_map(ax: Axes, data: xr.Dataset, x: Array, y: Array) -> list[Patch]:
    """The same over two parameters."""

    def patch(where: Any, style: dict[str, Any]) -> None:
        found = ax.contourf(x, y, where.astype(float), levels=[0.5, 1.5], colors="none", hatches=[style["hatch"]])
        found.set(edgecolor=style["edgecolor"], linewidth=0.0)

    return _each(data, patch)


def _each(data: xr.Dataset, draw: Any) -> list[Patch]:
    handles = []
    for name, hatch in zip(held_in(data), _HATCHES, strict=False):
        counts, hand = data[name].values, str(data[name].attrs["hand"])
        for where, said, color in ((counts > 0, "not stable", RED), (counts == UNKNOWN, "stability not decided", GREY)):
            style: dict[str, Any] = {"facecolor": "none", "edgecolor": color, "linewidth": 0.0, "hatch": hatch}
            if np.any(where):
                draw(where, style)
                handles.append(Patch(label=f"{said} in {hand}", **{**style, "linewidth": 0.4}))
    return handles
