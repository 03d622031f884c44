"""The data of a sweep as charts take them: names and units of axes, and where the bandwidth jumps between sets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.figures.scales import RADIANS, Scale, floats_scale
from haptisym.figures.style import name_parameter
from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.sweep.told import HELD

if TYPE_CHECKING:
    import xarray as xr


_MOST_PIXELS = 1200  # along an axis; a chart in print shows no more


def dimensions(data: xr.Dataset, count: int) -> list[str]:
    """The parameters of a sweep over so many; SceneError for any other."""
    found = [str(name) for name in data.bandwidth.dims]
    if len(found) != count or min(data.bandwidth.shape) < 2:
        raise SceneError(
            f"a chart shows one or two parameters with at least two values each, not {dict(data.bandwidth.sizes)}: "
            "choose with Dataset.sel, or sweep fewer"
        )
    return found


def thinned_data(data: xr.Dataset, names: tuple[str, str]) -> xr.Dataset:
    """What a map shows, no finer than it is seen."""
    steps = {name: slice(None, None, -(-data.sizes[name] // _MOST_PIXELS)) for name in names}
    wanted = ["bandwidth", *(f"crossings_{name}" for name in judged_in(data)), *held_in(data)]
    return data[wanted].isel(steps).load()


def axis_name(data: xr.Dataset, path: str, scale: Scale) -> str:
    """Symbol and unit of a parameter, whose element is named only where another one has the same symbol."""
    keys = {str(other): _symbol(str(other)) for other in data.bandwidth.dims}
    shared = list(keys.values()).count(keys[path]) > 1 or path.startswith("rendered.")
    element = "_" + "_".join(path.split(".")[:-1]).removeprefix("effects_").replace("-", "_") if shared else ""
    unit = str(data[path].attrs.get("units", ""))
    return name_parameter(keys[path] + element, unit if scale.factor == 1 else scale.unit)


def _symbol(path: str) -> str:
    _, _, key = path.rpartition(".")
    return key if not path.startswith("evaluation.") else "c" if key == "jnd" else f"c_{key}"


def axis_scale(data: xr.Dataset, path: str) -> Scale:
    """Hz where the frequencies of an axis begin and end with short numbers in Hz."""
    is_frequency = data[path].attrs.get("units") == "rad/s"
    return floats_scale([data[path].values.min(), data[path].values.max()]) if is_frequency else RADIANS


def is_logarithmic(x: Array) -> bool:
    """Whether values are spaced by equal ratios rather than evenly."""
    if len(x) < 3 or x.min() <= 0:
        return False
    even, ratio = np.diff(x), np.diff(np.log(x))
    return bool(np.ptp(ratio) < 1e-6 * abs(ratio).max() and np.ptp(even) > 1e-6 * abs(even).max())


def held_in(data: xr.Dataset) -> list[str]:
    """The variables of a sweep that tell of a hand."""
    return [str(name) for name in data.data_vars if str(name).startswith(HELD)]


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
    across, up = edges(x), edges(y)
    found = []
    for i, row in enumerate(z):
        found += [[(across[j], up[i]), (across[j], up[i + 1])] for j in jumps_of(row, counts[:, i], band)]
    for j, column in enumerate(z.T):
        found += [[(across[j], up[i]), (across[j + 1], up[i])] for i in jumps_of(column, counts[:, :, j], band)]
    return found


def edges(x: Array) -> Array:
    """The ends of the cells whose middles are given."""
    middles = (x[1:] + x[:-1]) / 2
    found: Array = np.concatenate([[x[0]], middles, [x[-1]]])
    return found
