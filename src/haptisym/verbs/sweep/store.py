"""Sweeps on disk: what is computed is written about every second, and what is there already is not computed again.

The store is a Zarr group whose chunks are the blocks of the sweep. Zarr replaces a chunk's file in one step, and ``method``
is written last; so a set is done exactly where ``method`` has no mark of absence left, whenever the process ended. One block
is worked on by one worker at a time. A NetCDF file is made from such a store at the end, in one step too.
"""

from __future__ import annotations

import shutil
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from haptisym.kernel.errors import SceneError
from haptisym.verbs.sweep.blocks import PATIENCE, Pace, Region, SweepGrid, size

if TYPE_CHECKING:
    import xarray as xr

_NOT_YET = -1
_NETCDF = (".nc", ".nc4", ".h5")


def stored(grid: SweepGrid, out: Path, progress: Callable[[int, int], None] | None = None) -> xr.Dataset:
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


def _as_netcdf(grid: SweepGrid, out: Path, progress: Callable[[int, int], None] | None) -> None:
    store, copy = (out.with_name(out.name + ending) for ending in (".part.zarr", ".part"))
    _fill(grid, store, progress)
    found = _opened(store)
    found.to_netcdf(
        copy,
        engine="h5netcdf",
        encoding={name: {"chunksizes": grid.block, "zlib": True} for name in grid.variables},
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


def _fill(grid: SweepGrid, store: Path, progress: Callable[[int, int], None] | None) -> None:
    zarr = _import("zarr")
    is_new = not store.exists()
    if not is_new:
        try:
            group = zarr.open_group(store, mode="r")
        except (OSError, ValueError, KeyError):
            raise SceneError(f"{store}: is there, but is not a Zarr store") from None
        _same(grid, group.attrs, store)
    else:
        _begin(grid, store)
        group = zarr.open_group(store, mode="r")
    left, done = [], 0
    for region in grid.regions():
        open_sets = 0 if is_new else int((group["method"][region] == _NOT_YET).sum())
        done += 0 if is_new else size(region) - open_sets
        if is_new or open_sets:
            left.append(region)
    if progress:
        progress(done, grid.sets)
    for count in _run(grid, store, left):
        done += count
        if progress:
            progress(done, grid.sets)


def _same(grid: SweepGrid, attributes: Any, where: Path) -> None:
    if attributes.get("fingerprint") != grid.fingerprint:
        raise SceneError(f"{where}: is there, but holds another sweep: remove it, or choose another name")


def _begin(grid: SweepGrid, store: Path) -> None:
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
    for name, (dtype, about) in grid.variables.items():
        fill = np.nan if dtype.kind == "f" else _NOT_YET
        made = group.create_array(
            name, shape=grid.shape, chunks=grid.block, dtype=dtype, dimension_names=names, fill_value=fill
        )
        made.attrs.update(about)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that format 3 does not ask for what xarray looks for first
        zarr.consolidate_metadata(fresh)
    fresh.rename(store)


def _run(grid: SweepGrid, store: Path, left: list[Region]) -> Iterator[int]:
    """Compute and write blocks on the active dask client, or else with the local scheduler; numbers of sets, as they are done.

    A worker hands a block back after about a second, and gets it again until it is done.
    """
    client = _client()
    if client is not None:
        yield from _on_cluster(client, grid, store, left)
        return
    dask = _import("dask")
    together = int(dask.config.get("num_workers", 0) or 0) or 4
    waiting, sets = left[::-1], 1
    while waiting:
        now = [waiting.pop() for _ in range(min(together, len(waiting)))]
        tasks = [dask.delayed(_write, traverse=False)(grid, str(store), region, sets) for region in now]
        parts: Sequence[_Part] = dask.compute(*tasks)
        yield sum(part.done for part in parts)
        sets = min(part.pace for part in parts)
        waiting += [region for region, part in zip(now, parts, strict=True) if part.is_open][::-1]


def _on_cluster(client: Any, grid: SweepGrid, store: Path, left: list[Region]) -> Iterator[int]:
    as_completed = _import("distributed").as_completed
    shared = client.scatter(grid, broadcast=True, hash=False)

    def submitted(region: Region, sets: int) -> Any:
        future = client.submit(_write, shared, str(store), region, sets, pure=False)
        regions[future.key] = region
        return future

    regions: dict[str, Region] = {}
    running = as_completed([submitted(region, 1) for region in left], with_results=True)
    for future, part in running:
        yield part.done
        region = regions.pop(future.key)
        if part.is_open:
            running.add(submitted(region, part.pace))


def _client() -> Any:
    """The dask client that is active, if any: none can be before distributed is loaded."""
    distributed: Any = sys.modules.get("distributed")
    try:
        return distributed.default_client() if distributed else None
    except ValueError:
        return None


class _Part(NamedTuple):
    """What was done of a block in about a second: how many sets, whether some are left, and how many to begin with next."""

    done: int
    is_open: bool
    pace: int


def _write(grid: SweepGrid, store: str, region: Region, sets: int) -> _Part:
    """Compute and write what is missing of a block, for about a second: ``method`` last, as the sign that a set is done."""
    group = _import("zarr").open_group(store, mode="r+")
    missing = group["method"][region] == _NOT_YET
    pace, done, began = Pace(sets), 0, monotonic()
    for piece in _missing(missing, region):
        for part, answers in grid.pieces(piece, pace):
            for name, answer in zip(grid.variables, answers, strict=True):
                group[name][part] = answer
            done += size(part)
            if monotonic() - began >= PATIENCE:
                return _Part(done, done < int(missing.sum()), pace.sets)
    return _Part(done, is_open=False, pace=pace.sets)


def _missing(missing: NDArray[np.bool_], region: Region) -> Iterator[Region]:
    """The sets of a block that are not there yet, in boxes: all of it at first; rows, or parts of rows, after an interruption."""
    if missing.all():
        yield region
    elif missing.any() and size(region) > 1:
        axis = next(i for i, part in enumerate(region) if part.stop - part.start > 1)
        part = region[axis]
        at = (part.start + part.stop) // 2
        for half in (slice(part.start, at), slice(at, part.stop)):
            inside = [slice(None)] * len(region)
            inside[axis] = slice(half.start - part.start, half.stop - part.start)
            yield from _missing(missing[tuple(inside)], (*region[:axis], half, *region[axis + 1 :]))
