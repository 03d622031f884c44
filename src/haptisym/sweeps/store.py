"""Sweeps on disk: blocks are written as they are done, and what is there already is not computed again.

The store is a Zarr group whose chunks are the blocks of the sweep. Zarr replaces a chunk's file in one step, and ``method``
is written last; so a block is done exactly where ``method`` has no mark of absence left, whenever the process ended. A
NetCDF file is made from such a store at the end, in one step too.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from haptisym.errors import SceneError

from .blocks import VARIABLES, Grid, Region, compute

if TYPE_CHECKING:
    import xarray as xr

_NOT_YET = -1
_NETCDF = (".nc", ".nc4", ".h5")


def stored(grid: Grid, out: Path, progress: Callable[[int, int], None] | None = None) -> xr.Dataset:
    """The sweep in a file: begun, continued, or found done; opened from there with one dask chunk for each block."""
    if out.suffix == ".zarr":
        _fill(grid, out, progress)
        return _opened(out)
    if out.suffix not in _NETCDF:
        raise SceneError(f"{out}: the name must end in .zarr (Zarr) or .nc (NetCDF)")
    _import("h5py"), _import("h5netcdf")  # asked for now, not after hours of work
    if not out.exists():
        _as_netcdf(grid, out, progress)
    xarray = _import("xarray")
    try:
        found: xr.Dataset = xarray.open_dataset(out, engine="h5netcdf", chunks={})
    except OSError:
        raise SceneError(f"{out}: is there, but is not a NetCDF file") from None
    _same(grid, found.attrs, out)
    return found


def _as_netcdf(grid: Grid, out: Path, progress: Callable[[int, int], None] | None) -> None:
    store, copy = (out.with_name(out.name + ending) for ending in (".part.zarr", ".part"))
    _fill(grid, store, progress)
    found = _opened(store)
    found.to_netcdf(
        copy, engine="h5netcdf", encoding={name: {"chunksizes": grid.block, "zlib": True} for name in VARIABLES}
    )
    copy.replace(out)
    shutil.rmtree(store)


def _opened(store: Path) -> xr.Dataset:
    found: xr.Dataset = _import("xarray").open_zarr(store, consolidated=False)
    return found


def _import(package: str) -> Any:
    from importlib import import_module

    try:
        return import_module(package)
    except ImportError:
        raise SceneError(f'{package} is missing: a sweep in a file needs "pip install haptisym[sweep]"') from None


def _fill(grid: Grid, store: Path, progress: Callable[[int, int], None] | None) -> None:
    zarr = _import("zarr")
    if store.exists():
        try:
            group = zarr.open_group(store, mode="r")
        except (OSError, ValueError, KeyError):
            raise SceneError(f"{store}: is there, but is not a Zarr store") from None
        _same(grid, group.attrs, store)
    else:
        _begin(grid, store)
        group = zarr.open_group(store, mode="r")
    left = [region for region in grid.regions() if (group["method"][region] == _NOT_YET).any()]
    done = grid.sets - sum(_size(region) for region in left)
    if progress:
        progress(done, grid.sets)
    for count in _run(grid, store, left):
        done += count
        if progress:
            progress(done, grid.sets)


def _same(grid: Grid, attributes: Any, where: Path) -> None:
    if attributes.get("fingerprint") != grid.fingerprint:
        raise SceneError(f"{where}: is there, but holds another sweep: remove it, or choose another name")


def _begin(grid: Grid, store: Path) -> None:
    """An empty store under another name, then renamed: it is there with all of its arrays or not at all."""
    zarr = _import("zarr")
    fresh = store.with_name(store.name + ".new")
    shutil.rmtree(fresh, ignore_errors=True)
    group = zarr.create_group(fresh, attributes=grid.attributes())
    names = [axis.path for axis in grid.axes]
    for axis in grid.axes:
        made = group.create_array(
            axis.path, shape=axis.values.shape, dtype=axis.values.dtype, dimension_names=[axis.path], fill_value=np.nan
        )
        made.attrs.update({"units": axis.unit})
        made[:] = axis.values
    for name, (dtype, about) in VARIABLES.items():
        fill = np.nan if dtype.kind == "f" else _NOT_YET
        made = group.create_array(
            name, shape=grid.shape, chunks=grid.block, dtype=dtype, dimension_names=names, fill_value=fill
        )
        made.attrs.update(about)
    fresh.rename(store)


def _size(region: Region) -> int:
    return int(np.prod([part.stop - part.start for part in region]))


def _run(grid: Grid, store: Path, left: list[Region]) -> Iterator[int]:
    """Compute and write blocks on the active dask client, or else with the local scheduler; the number of sets of each."""
    client = _client()
    if client is not None:
        as_completed = _import("distributed").as_completed
        shared = client.scatter(grid, broadcast=True, hash=False)
        futures = [client.submit(_write, shared, str(store), region, pure=False) for region in left]
        for _, count in as_completed(futures, with_results=True):
            yield count
        return
    dask = _import("dask")
    together = int(dask.config.get("num_workers", 0) or 0) or 4
    for i in range(0, len(left), together):
        tasks = [dask.delayed(_write, traverse=False)(grid, str(store), region) for region in left[i : i + together]]
        yield from dask.compute(*tasks)


def _client() -> Any:
    """The dask client that is active, if any: none can be before distributed is loaded."""
    distributed: Any = sys.modules.get("distributed")
    try:
        return distributed.default_client() if distributed else None
    except ValueError:
        return None


def _write(grid: Grid, store: str, region: Region) -> int:
    """One block: ``method`` last, as the sign that it is done."""
    group = _import("zarr").open_group(store, mode="r+")
    answers = compute(grid.kernel, np.ix_(*grid.values(region)))
    for name, answer in zip(VARIABLES, answers, strict=True):
        group[name][region] = answer
    return answers[0].size
