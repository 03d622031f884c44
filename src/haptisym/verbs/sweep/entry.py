"""Sweeps over design spaces: the certified answers of a scene for every combination of values of some parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.kernel.counts import whole
from haptisym.kernel.errors import SceneError
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.stability.entry import in_hands
from haptisym.verbs.sweep.axes import AxisValues, axes
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.blocks import SETS_IN_A_BLOCK, Pace, SweepGrid, compute
from haptisym.verbs.sweep.kernel import Kernel

if TYPE_CHECKING:
    import xarray as xr

MOST_BYTES = 4_000_000_000
"""Of a sweep that is kept in memory: some seventy million sets."""
Progress = Callable[[int, int], None]
"""Told how many sets are done, and how many there are."""


def sweep(
    scene: Scene | str | Path,
    vary: Mapping[str, AxisValues],
    *,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    out: str | Path | None = None,
    lazy: bool = False,
    block: int = SETS_IN_A_BLOCK,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Evaluate a scene for every combination of values: counts proven, frequencies proven to a relative 1e-10.

    ``vary`` : from paths (``effects.NAME.KEY``, ``environment.KEY``, ``rendered.KEY``, ``evaluation.jnd``) to values: floats in
    SI units and rad/s, taken as exactly the binary numbers that they are, or strings with a unit ("40 Hz"), taken as the
    nearest double. Each path is a dimension of the result, in the order given.
    ``hand`` : the hands in which the display is held, as of ``stability``; those of the scene if not given.
    ``out`` : a Zarr store (FILE.zarr) or NetCDF file (FILE.nc) to which blocks are streamed as they are done. If it is there
    already and holds a part of this very sweep, the rest is computed; it is computed on the dask client that is active, or
    with dask's threads. The result is then opened from the file, lazily.
    ``lazy`` : without ``out``, return dask arrays that are computed when asked for, by whatever scheduler is in use.
    ``block`` : sets that one worker holds at most, which bounds the memory. They are computed and written in pieces of about
    a second. Results do not depend on that.
    ``progress`` : called with the number of sets done and of all sets.

    Variables (frequencies in rad/s; NaN for one that does not exist): ``first_crossing_real``, ``first_crossing_imag``,
    ``bandwidth``, ``transparent`` (fraction of the band), ``crossings_real``, ``crossings_imag`` (with a JND region that judges
    both parts at once ``first_crossing_joint`` and ``crossings_joint`` in their place), ``changeover_environment``,
    ``changeover_perceived`` (the lowest), ``changeovers_environment``, ``changeovers_perceived`` (how many) and
    ``method``: 0 certified in floats, 1 exact, 2 not answered (undecided at the precision limit or in ten seconds, or without
    dynamics; counts are then -1).

    For each hand ``unstable_NAME``, the proven number of roots that do not decay (Re s >= 0, with a clock abs(z) >= 1): 0 where
    the display is stable in it, 32767 for a chain of infinitely many, -1 where that was not decided; ``method`` is then 2.

    Raises SceneError for an unknown path, a value that the model does not allow, more sets than memory should hold without
    ``out``, and a package that is missing.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = sweep(load_scene("fu2019"), {"effects.filter.omega_n": [40.0, "80 rad/s"], "evaluation.jnd": [0.1, 0.2]})
    >>> found.bandwidth.values.round(4)
    array([[ 4.944 ,  7.725 ],
           [ 7.9789, 15.    ]])
    """
    scene = in_hands(as_scene(scene), hand)
    xarray = _needed("xarray")
    grid = SweepGrid.of(scene, axes(scene, vary), whole("block", block, of=" of sets"))
    if out is not None:
        from haptisym.verbs.sweep.store import stored

        return stored(grid, Path(out), progress)
    return _lazy(grid, xarray) if lazy else _now(grid, xarray, progress)


def _needed(package: str) -> Any:
    from importlib import import_module

    try:
        return import_module(package)
    except ImportError:
        raise SceneError(f'{package} is missing: a sweep needs "pip install haptisym[sweep]"') from None


def _coordinates(grid: SweepGrid, xarray: Any) -> dict[str, Any]:
    return {axis.path: xarray.Variable(axis.path, axis.values, {"units": axis.unit}) for axis in grid.axes}


def _now(grid: SweepGrid, xarray: Any, progress: Progress | None) -> xr.Dataset:
    needed = grid.sets * sum(dtype.itemsize for dtype, _ in grid.variables.values())
    if needed > MOST_BYTES:
        raise SceneError(
            f'{grid.sets:,} sets take {needed / 1e9:,.0f} GB of memory: let them be streamed to a file, out="FILE.zarr" '
            "(--out FILE.zarr on the command line), or vary fewer values"
        )
    columns = [np.empty(grid.shape, dtype) for dtype, _ in grid.variables.values()]
    done, pace = 0, Pace()
    for region in grid.regions():
        for piece, answers in grid.pieces(region, pace):
            for column, answer in zip(columns, answers, strict=True):
                column[piece] = answer
            done += answers[0].size
            if progress:
                progress(done, grid.sets)
    return _dataset(grid, xarray, columns)


def _dataset(grid: SweepGrid, xarray: Any, columns: list[Any]) -> xr.Dataset:
    names = [axis.path for axis in grid.axes]
    variables = {
        name: (names, column, about) for column, (name, (_, about)) in zip(columns, grid.variables.items(), strict=True)
    }
    found: xr.Dataset = xarray.Dataset(variables, _coordinates(grid, xarray), grid.attributes())
    return found


def _lazy(grid: SweepGrid, xarray: Any) -> xr.Dataset:
    _needed("dask")
    chunks = dict(zip((axis.path for axis in grid.axes), grid.block, strict=True))
    values = [
        xarray.DataArray(axis.values, dims=[axis.path]).chunk({axis.path: chunks[axis.path]}) for axis in grid.axes
    ]
    columns = xarray.apply_ufunc(
        partial(_block, grid.kernel),
        *values,
        dask="parallelized",
        output_core_dims=[()] * len(grid.variables),
        output_dtypes=[dtype for dtype, _ in grid.variables.values()],
    )
    return _dataset(grid, xarray, [column.data for column in columns])


def _block(kernel: Kernel, *values: Array) -> tuple[Array, ...]:
    return compute(kernel, values)
