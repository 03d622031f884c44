"""Where the bandwidth of a sweep jumps from one set to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.programs.values import Array

if TYPE_CHECKING:
    import xarray as xr


def jumps_of(y: Array, counts: Any, band: float) -> Any:
    """The places before which a curve is broken; ``counts`` : of the crossings of the parts that it depends on, in rows.

    Where a pair of crossings of a part comes or goes, and the curve moves more there than beside: the lowest one may be among
    them. A crossing alone comes in over an end of the band, so that the curve goes on; there, as elsewhere, it is only broken
    where it moves far more than on both sides.
    """
    steps = np.pad(np.abs(np.diff(y)), 1, constant_values=np.nan)
    least, most = (np.nan_to_num(pick(steps[:-2], steps[2:])) for pick in (np.fmin, np.fmax))
    pairs = (np.abs(np.diff(counts, axis=1)) > 1).any(axis=0)
    smooth = np.where(pairs, np.maximum(1.5 * least, 0.004 * band), np.maximum(6 * most, 0.05 * band))
    return (steps[1:-1] > smooth).nonzero()[0] + 1


JUDGED = ("real", "imag", "joint")
"""The names of the criteria of which a sweep may tell, in the order of its charts."""


def judged_in(data: xr.Dataset) -> list[str]:
    """The names of the criteria of which a sweep tells."""
    return [name for name in JUDGED if f"crossings_{name}" in data]


def crossing_counts(data: xr.Dataset) -> Any:
    """How many crossings there are, of each criterion."""
    return np.stack([data[f"crossings_{name}"].values for name in judged_in(data)]).astype(np.int64)


def jump_edges(data: xr.Dataset, x: Array, y: Array, z: Array, band: float) -> list[list[tuple[float, float]]]:
    """The edges between neighbouring sets across which the bandwidth jumps, as pieces of lines."""
    counts = crossing_counts(data)
    across, up = _edges(x), _edges(y)
    found = []
    for i, row in enumerate(z):
        found += [[(across[j], up[i]), (across[j], up[i + 1])] for j in jumps_of(row, counts[:, i], band)]
    for j, column in enumerate(z.T):
        found += [[(across[j], up[i]), (across[j + 1], up[i])] for i in jumps_of(column, counts[:, :, j], band)]
    return found


def _edges(x: Array) -> Array:
    """The ends of the cells whose middles are given."""
    middles = (x[1:] + x[:-1]) / 2
    edges: Array = np.concatenate([[x[0]], middles, [x[-1]]])
    return edges
