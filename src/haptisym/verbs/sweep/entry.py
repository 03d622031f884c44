"""Sweeps over design spaces: the certified answers of a scene for every combination of values of
some parameters.

A sweep is a grid of parameter sets, cut into blocks that are computed one by one and in any order,
in memory (``sweep``) or on disk.

What is computed is written about every second, and what is there already is not computed again
(``stored``). The store is a Zarr group whose chunks are the blocks of the sweep. Zarr replaces a
chunk's file in one step, and ``method`` is written last; so a set is done exactly where ``method``
has no mark of absence left, whenever the process ended. One block is worked on by one worker at a
time, and on one sweep by one process. Until all sets are there the store has a name of its own;
then it is renamed, or a NetCDF file is made from it, in one step too. Whoever opens one, a worker
too, asks whether it is this sweep.

The answer in short is its axes, ranges and counts, not the sets themselves.
"""

from __future__ import annotations

import json
import shutil
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import cached_property, partial
from hashlib import sha256
from importlib import import_module
from itertools import product
from math import ceil, prod
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from haptisym.judge.answers import Answer
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.reals import whole
from haptisym.model.catalogue import Hand
from haptisym.model.files import beside, claimed, replacing
from haptisym.model.jnd import Part
from haptisym.model.scene import Knob, Scene, in_hands
from haptisym.model.scenefile import as_scene
from haptisym.verbs.sweep.axes import (
    EXACT,
    FLOAT,
    HELD,
    INFINITE,
    UNKNOWN,
    AxisValues,
    SweepAxis,
    SweepVariables,
    axes,
)
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.evaluator import SetEvaluator
from haptisym.verbs.sweep.passes import TOLERANCE

if TYPE_CHECKING:
    import xarray as xr


SETS_IN_A_BLOCK = 65_536
_MANY_SETS = 250_000  # for which machine code is worth loading, and compiling once
PATIENCE = 1.0
"""Seconds after which, as nearly as one can tell, what is computed is written down and told."""
Region: TypeAlias = tuple[slice, ...]
Progress: TypeAlias = Callable[[int, int], None]
"""Is called with the number of sets that are done, and of all."""


@dataclass
class Pace:
    """The number of sets that are computed at a time: as many as take about ``PATIENCE`` seconds by
    the time of those before; a single one at first."""

    sets: int = 1

    def took(self, seconds: float, sets: int) -> None:
        """Choose the next block by how long this one took."""
        wanted = sets * PATIENCE / max(seconds, 1e-6)
        # no more than eight times as many: the next sets may be harder than these were
        self.sets = max(1, int(min(wanted, 8 * self.sets)))


def size(region: Region) -> int:
    """How many sets there are in a block."""
    return prod(part.stop - part.start for part in region)


def _cut(region: Region, most: int) -> tuple[Region, Region]:
    """The first sets of a block, not many more than so many where one axis can be cut so, and the
    rest."""
    axis = next(i for i, part in enumerate(region) if part.stop - part.start > 1)
    before, part, behind = region[:axis], region[axis], region[axis + 1 :]
    start, stop = part.start, part.stop
    # both parts get one value of this axis at least
    wanted = max(1, most // size(behind))
    middle = start + min(wanted, stop - start - 1)
    first = (*before, slice(start, middle), *behind)
    rest = (*before, slice(middle, stop), *behind)
    return first, rest


@dataclass(frozen=True)
class SweepGrid:
    """All sets of a sweep: every combination of the values of its axes."""

    scene: Scene
    axes: tuple[SweepAxis, ...]
    block: tuple[int, ...]
    """How many values of each axis a block holds at most."""

    @classmethod
    def of(cls, scene: Scene, axes: Sequence[SweepAxis], sets: int = SETS_IN_A_BLOCK) -> SweepGrid:
        """The grid with blocks of about that many sets, as long as possible along the last axes."""
        shape, left = [], sets
        for axis in reversed(axes):
            shape.append(max(1, min(len(axis.values), left)))
            left //= shape[-1]
        return cls(replace(scene), tuple(axes), tuple(reversed(shape)))

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def sets(self) -> int:
        """How many sets of values there are."""
        return prod(self.shape)

    @property
    def variables(self) -> dict[str, tuple[np.dtype[Any], dict[str, str]]]:
        """Name and type of what is computed of each set, with its attributes in a data set."""
        return SweepVariables.of(self.scene).variables

    @cached_property
    def evaluator(self) -> SetEvaluator:
        """What computes the variables of sets."""
        return SetEvaluator.of(
            self.scene, [axis.knob for axis in self.axes], many=self.sets >= _MANY_SETS
        )

    def regions(self) -> Iterator[Region]:
        """The blocks, in the order of the grid."""
        starts = [range(ceil(n / size)) for n, size in zip(self.shape, self.block, strict=True)]
        for index in product(*starts):
            yield tuple(
                slice(i * b, min((i + 1) * b, n))
                for i, b, n in zip(index, self.block, self.shape, strict=True)
            )

    def pieces(self, region: Region, pace: Pace) -> Iterator[tuple[Region, tuple[Array, ...]]]:
        """All variables of a block, in pieces that take about a second each; the results do not
        depend on how it is cut."""
        waiting = [region]
        while waiting:
            piece = waiting.pop()
            while size(piece) > pace.sets:
                piece, rest = _cut(piece, pace.sets)
                waiting.append(rest)
            began = monotonic()
            answers = compute(self.evaluator, np.ix_(*self.values(piece)))
            pace.took(monotonic() - began, size(piece))
            yield piece, answers

    def values(self, region: Region) -> list[Array]:
        """The values of each axis in a block."""
        return [axis.values[part] for axis, part in zip(self.axes, region, strict=True)]

    def attributes(self) -> dict[str, Any]:
        """The attributes of the data set: scene, band, threshold, accuracy, fingerprint."""
        return {
            "schema": "haptisym.sweep/1",
            "title": self.scene.title,
            "source": self.scene.source,
            "band": [
                self.evaluator.band.high * self.evaluator.band.low_fraction,
                self.evaluator.band.high,
            ],
            **_threshold(self.scene),
            "relative_accuracy": TOLERANCE,
            "certified": (
                "All counts are proven. Values of the swept parameters are taken as exactly "
                "the binary numbers stored here."
            ),
            "floats": self._how,
            "fingerprint": self.fingerprint,
            **self._asides(),
        }

    @property
    def _how(self) -> str:
        """A sentence on which arithmetic proves the counts."""
        if self.evaluator.curves is None:
            return _ALL_EXACT
        return f"{_IN_FLOATS}{_WITH_SINES}" if self.evaluator.has_waves else _IN_FLOATS

    def _asides(self) -> dict[str, Any]:
        """The scene's notes, on what is estimated, nominal or exists twice, as text, which every
        kind of file can hold."""
        swept = [axis.path for axis in self.axes]
        notes = self.scene.asides(swept, swept)
        keys = self.scene.aside_keys(swept, swept)
        return {key: json.dumps(x) for key, x in keys.items()} | (
            {"notes": "\n".join(notes)} if notes else {}
        )

    @cached_property
    def fingerprint(self) -> str:
        """A digest of everything that the results depend on."""
        # Exact values as text. What is swept is left out: its values are those of the axes, and the
        # scene's own do not matter.
        scene = self.scene
        elements = [
            [
                place,
                x.model,
                [[p.key, str(p.value)] for p in x.parameters if not self._is_swept(p.symbol)],
                str(x.dynamics),
            ]
            for place, x in scene.elements()
        ]
        c = scene.threshold
        swept = {part for axis in self.axes for part in axis.knob.parts}
        plain = [
            "" if part in swept else str(x)
            for part, x in ((Part.REAL, c.real), (Part.IMAG, c.imag))
        ]
        hands = [
            [x.name, [str(p.value) for p in x.parameters if not self._is_swept(p.symbol)]]
            for x in scene.hands
        ]
        parts = [
            _FORMAT,
            TOLERANCE,
            elements,
            hands,
            [str(x) for x in scene.band],
            plain if c.is_plain else c.row(),
            [[axis.path, axis.values.tolist()] for axis in self.axes],
        ]
        return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()

    def _is_swept(self, symbol: object) -> bool:
        return any(axis.knob.symbol == symbol for axis in self.axes)


def _threshold(scene: Scene) -> dict[str, Any]:
    """Both limits; of what is more than two numbers the whole region, as text."""
    c = scene.threshold
    if c.is_plain:
        return {"threshold": [str(c.real), str(c.imag)]}
    return {"threshold": json.dumps(c.row())}


_IN_FLOATS = (
    "method 0 where floats with an error bound prove the counts, exact arithmetic elsewhere"
)
_WITH_SINES = (
    "; the bound rests on sines, cosines, exponentials and logarithms within 4 units in the last "
    "place, as tested here"
)
_ALL_EXACT = "floats do not answer this scene with these parameters: every set is answered exactly"


def compute(evaluator: SetEvaluator, values: Sequence[Array]) -> tuple[Array, ...]:
    """All variables, in their order, of every combination of values in arrays that broadcast
    together."""
    together = np.broadcast_arrays(*values)
    columns = evaluator.answers(np.stack([np.ravel(x) for x in together]))
    shape = together[0].shape
    return tuple(
        columns[name].reshape(shape).astype(dtype, copy=False)
        for name, (dtype, _) in evaluator.sweep_variables.variables.items()
    )


def needed(package: str) -> Any:
    """The package; SceneError says how to install it."""
    try:
        return import_module(package)
    except ImportError:
        raise SceneError(
            f'{package} is missing: a sweep needs "pip install haptisym[sweep]"'
        ) from None


_FORMAT = 2
"""The version of what is written; a store of another one is not continued."""
# the fill value of ``method`` and of counts; a method is 0, 1 or 2 once a set is done
_NOT_YET = -1
_NETCDF = (".nc", ".nc4", ".h5")


def unfinished(out: Path) -> Path:
    """The store that holds the sets of a file until all of them are there."""
    return out.with_name(f"{out.name}.part.zarr")


def stored(grid: SweepGrid, out: Path, progress: Progress | None = None) -> xr.Dataset:
    """The sweep in a file: begun, continued, or found done; opened from there with one dask chunk
    for each block.

    SceneError unless the file is of this very sweep and all sets are there.
    """
    if out.suffix not in (".zarr", *_NETCDF):
        raise SceneError(f"{out}: end the name in .zarr (Zarr) or .nc (NetCDF)")
    # asked for now, not after hours of work
    for package in ("zarr",) if out.suffix == ".zarr" else ("zarr", "h5py", "h5netcdf"):
        needed(package)
    # workers may run in other folders
    place = out.absolute()
    try:
        if not _is_made(grid, place):
            place.parent.mkdir(parents=True, exist_ok=True)
            with claimed(place):
                _make(grid, place, progress)
    except OSError as error:
        raise SceneError(
            f"{out}: cannot be written: {(error.strerror or str(error)).lower()}"
        ) from error
    found = _opened(grid, place)
    if progress:
        progress(grid.sets, grid.sets)
    return found


def _is_made(grid: SweepGrid, place: Path) -> bool:
    """Whether a file is there with all sets."""
    if not place.exists():
        return False
    with _opened(grid, place) as found, needed("dask").config.set(scheduler="synchronous"):
        return bool((found["method"] != _NOT_YET).all())


def _make(grid: SweepGrid, place: Path, progress: Progress | None) -> None:
    """Compute what is missing in a store next to the place, and put it there whole."""
    # by another process, while this one waited for its claim
    if _is_made(grid, place):
        return
    store, dask = unfinished(place), needed("dask")
    if place.exists() and place.suffix != ".zarr":
        raise SceneError(f"{place}: not all sets are there: remove it, or choose another name")
    # a Zarr store in place with sets missing is one to be continued
    if place.exists():
        place.rename(store)
    elif not store.exists():
        _begin(grid, store)
    _fill(grid, store, progress)
    if place.suffix == ".zarr":
        store.rename(place)
        return
    encoding = {name: {"chunksizes": grid.block, "zlib": True} for name in grid.variables}
    with (
        replacing(place) as fresh,
        _opened(grid, store) as found,
        dask.config.set(scheduler="synchronous"),
    ):
        found.to_netcdf(fresh, engine="h5netcdf", encoding=encoding)
    shutil.rmtree(store)


def _opened(grid: SweepGrid, place: Path) -> xr.Dataset:
    """The data set of a file; SceneError unless it is this very sweep, with all its values and
    variables."""
    xarray, is_zarr = needed("xarray"), place.suffix == ".zarr"
    try:
        if is_zarr:
            found: xr.Dataset = xarray.open_zarr(place, consolidated=False)
        else:
            found = xarray.open_dataset(place, engine="h5netcdf", chunks={})
    except (OSError, ValueError, KeyError):
        kind = "Zarr store" if is_zarr else "NetCDF file"
        raise SceneError(f"{place}: exists, but is not a {kind}: choose another name") from None
    _same(grid, found.attrs, place)
    # the fingerprint is an attribute, and arrays may have been lost or changed beside it
    held = all(
        x.path in found.coords and np.array_equal(found[x.path].values, x.values) for x in grid.axes
    )
    if not held or not {*grid.variables} <= {*found}:
        raise SceneError(
            f"{place}: values or variables of the sweep are missing in it: remove it, or "
            f"choose another name"
        )
    return found


def _fill(grid: SweepGrid, store: Path, progress: Progress | None) -> None:
    """Compute what is missing in a store. SceneError where it is missing still."""
    _opened(grid, store).close()
    group, regions = needed("zarr").open_group(store, mode="r"), list(grid.regions())

    def missing() -> list[int]:
        return [int((group["method"][region] == _NOT_YET).sum()) for region in regions]

    left = missing()
    done = grid.sets - sum(left)
    if progress:
        progress(done, grid.sets)
    for count in _run(
        grid, store, [region for region, sets in zip(regions, left, strict=True) if sets]
    ):
        done += count
        if progress:
            progress(done, grid.sets)
    if lost := sum(missing()):
        raise SceneError(
            f"{store}: {lost:,} of {grid.sets:,} sets did not arrive: workers must write to "
            f"this very folder"
        )


def _same(grid: SweepGrid, attributes: Any, where: Path) -> None:
    """SceneError unless the attributes of a store are those of this sweep."""
    if attributes.get("fingerprint") != grid.fingerprint:
        raise SceneError(f"{where}: exists with another sweep: remove it, or choose another name")


def _begin(grid: SweepGrid, store: Path) -> None:
    """Make an empty store under a name of its own, then rename it: it is there with all of its
    arrays or not at all."""
    fresh = beside(store)
    try:
        _lay(grid, fresh)
        fresh.rename(store)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _lay(grid: SweepGrid, store: Path) -> None:
    """Make all arrays of a store: the axes with their values, the variables with fill values."""
    zarr = needed("zarr")
    group = zarr.create_group(store, attributes=grid.attributes())
    names = [axis.path for axis in grid.axes]
    for axis in grid.axes:
        made = group.create_array(
            axis.path,
            shape=axis.values.shape,
            dtype=axis.values.dtype,
            dimension_names=[axis.path],
            fill_value=np.nan,
        )
        made.attrs.update({"units": axis.unit})
        made[:] = axis.values
    for name, (dtype, about) in grid.variables.items():
        fill = np.nan if dtype.kind == "f" else _NOT_YET
        made = group.create_array(
            name,
            shape=grid.shape,
            chunks=grid.block,
            dtype=dtype,
            dimension_names=names,
            fill_value=fill,
        )
        made.attrs.update(about)
    with warnings.catch_warnings():
        # it warns that consolidated metadata, which xarray looks for first, is no part of format 3
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(store)


def _run(grid: SweepGrid, store: Path, left: list[Region]) -> Iterator[int]:
    """Compute and write blocks on the active dask client, or else with the local scheduler; numbers
    of sets, as they are done.

    A worker hands a block back after about a second, and gets it again until it is done.
    """
    client = _client()
    if client is not None:
        yield from _on_cluster(client, grid, store, left)
        return
    dask = needed("dask")
    # A round of pieces ends with its slowest, so that all begin the next one at the smallest pace;
    # between rounds the caller is told, and may stop.
    together = int(dask.config.get("num_workers", 0) or 0) or 4
    waiting, sets = left[::-1], 1
    while waiting:
        now = [waiting.pop() for _ in range(min(together, len(waiting)))]
        tasks = [
            dask.delayed(_write, traverse=False)(grid, str(store), region, sets) for region in now
        ]
        parts: Sequence[_Part] = dask.compute(*tasks)
        yield sum(part.done for part in parts)
        sets = min(part.pace for part in parts)
        waiting += [region for region, part in zip(now, parts, strict=True) if part.is_open][::-1]


def _on_cluster(client: Any, grid: SweepGrid, store: Path, left: list[Region]) -> Iterator[int]:
    """Compute and write blocks on a dask cluster; numbers of sets, as they are done."""
    distributed = needed("distributed")
    lost = (
        distributed.KilledWorker,
        needed("distributed.comm").CommClosedError,
        CancelledError,
        TimeoutError,
    )

    def submitted(region: Region, sets: int) -> Any:
        future = client.submit(_write, shared, str(store), region, sets, pure=False)
        regions[future.key] = region
        return future

    regions: dict[str, Region] = {}
    try:
        # Sent once to each worker. No task is pure: a block that is handed back is the same call
        # again, and must be run again.
        shared = client.scatter(grid, broadcast=True, hash=False)
        running = distributed.as_completed(
            [submitted(region, 1) for region in left], with_results=True
        )
        for future, part in running:
            yield part.done
            region = regions.pop(future.key)
            if part.is_open:
                running.add(submitted(region, part.pace))
    except lost as error:
        what = f"the workers were lost ({type(error).__name__})"
        raise SceneError(
            f"{what}; what is done is in {store}, and the same call goes on from there"
        ) from error


def _client() -> Any:
    """The dask client that is active, if any: none can be before distributed is loaded."""
    distributed: Any = sys.modules.get("distributed")
    try:
        return distributed.default_client() if distributed else None
    except ValueError:
        return None


class _Part(NamedTuple):
    """What was done of a block in about a second: how many sets, whether some are left, and how
    many to begin with next."""

    done: int
    is_open: bool
    pace: int


def _write(grid: SweepGrid, store: str, region: Region, sets: int) -> _Part:
    """Compute and write what is missing of a block, for about a second: ``method`` last, as the
    sign that a set is done."""
    try:
        group = needed("zarr").open_group(store, mode="r+")
    except (OSError, ValueError, KeyError):
        raise SceneError(
            f"{store}: a worker has no such store: all workers must write to this very folder"
        ) from None
    _same(grid, group.attrs, Path(store))
    missing = group["method"][region] == _NOT_YET
    # ``method`` is the last of the variables: a piece that was cut off while it was written has no
    # method yet, and is computed again
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
    """The sets of a block that are not there yet, in boxes: all of it at first; rows, or parts of
    rows, after an interruption."""
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


MOST_BYTES = 4_000_000_000
"""Of a sweep that is kept in memory: some seventy million sets."""


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
    """Evaluate a scene for every combination of values: counts proven, frequencies proven to a
    relative 1e-10.

    ``vary`` : from paths (``effects.NAME.KEY``, ``environment.KEY``, ``rendered.KEY``,
    ``evaluation.jnd``) to values: floats in SI units and rad/s, taken as exactly the binary numbers
    that they are, or strings with a unit ("40 Hz"), taken as the nearest double. Each path is a
    dimension of the result, in the order given.
    ``hand`` : the hands in which the display is held, as of ``stability``; those of the scene if
    not given.
    ``out`` : a Zarr store (FILE.zarr) or NetCDF file (FILE.nc) to which blocks are streamed as they
    are done. If it is there already and holds a part of this very sweep, the rest is computed; it
    is computed on the dask client that is active, or with dask's threads. The result is then opened
    from the file, lazily.
    ``lazy`` : without ``out``, return dask arrays that are computed when asked for, by whatever
    scheduler is in use.
    ``block`` : sets that one worker holds at most, which bounds the memory. They are computed and
    written in pieces of about a second. Results do not depend on that.
    ``progress`` : called with the number of sets done and of all sets.

    Variables (frequencies in rad/s; NaN for one that does not exist): ``first_crossing_real``,
    ``first_crossing_imag``,
    ``bandwidth``, ``transparent`` (fraction of the band), ``crossings_real``, ``crossings_imag``
    (with a JND region that judges both parts at once ``first_crossing_joint`` and
    ``crossings_joint`` in their place), ``changeover_environment``,
    ``changeover_perceived`` (the lowest), ``changeovers_environment``, ``changeovers_perceived``
    (how many) and
    ``method``: 0 certified in floats, 1 exact, 2 not answered (undecided at the precision limit or
    in ten seconds, or without dynamics; counts are then -1).

    For each hand ``unstable_NAME``, the proven number of roots that do not decay (Re s >= 0, with a
    clock abs(z) >= 1): 0 where the display is stable in it, 32767 for a chain of infinitely many,
    -1 where that was not decided; ``method`` is then 2.

    Raises SceneError for an unknown path, a value that the model does not allow, more sets than
    memory should hold without
    ``out``, and a package that is missing.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = sweep(load_scene("fu2019"), {"effects.filter.omega_n": [40.0, "80 rad/s"], "evaluation.jnd": [0.1, 0.2]})
    >>> found.bandwidth.values.round(4)
    array([[ 4.944 ,  7.725 ],
           [ 7.9789, 15.    ]])
    """
    scene = in_hands(as_scene(scene), hand)
    xarray = needed("xarray")
    grid = SweepGrid.of(scene, axes(scene, vary), whole("block", block, of=" of sets"))
    if out is not None:
        return stored(grid, Path(out), progress)
    return _lazy(grid, xarray) if lazy else _now(grid, xarray, progress)


def _now(grid: SweepGrid, xarray: Any, progress: Progress | None) -> xr.Dataset:
    """The sweep in memory, computed here; SceneError where it would not fit."""
    needed = grid.sets * sum(dtype.itemsize for dtype, _ in grid.variables.values())
    if needed > MOST_BYTES:
        raise SceneError(
            f"{grid.sets:,} sets take {needed / 1e9:,.0f} GB of memory: stream them to a "
            f'file, out="FILE.zarr" '
            "(--out FILE.zarr on the command line), or vary fewer values"
        )
    columns = [np.empty(grid.shape, dtype) for dtype, _ in grid.variables.values()]
    # one pace for all blocks: what one has shown holds for the next
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
    """The data set of a grid from its columns, which may be arrays or dask arrays."""
    names = [axis.path for axis in grid.axes]
    # Told that these are arrays, xarray asks neither dask nor pint whether they know them, which
    # would load both, and SciPy with them: a second.
    variables = {
        name: xarray.Variable(names, column, about, fastpath=True)
        for column, (name, (_, about)) in zip(columns, grid.variables.items(), strict=True)
    }
    indexes = {
        axis.path: xarray.indexes.PandasIndex(needed("pandas").Index(axis.values), axis.path)
        for axis in grid.axes
    }
    places = {name: index.create_variables()[name] for name, index in indexes.items()}
    for axis in grid.axes:
        places[axis.path].attrs["units"] = axis.unit
    coordinates = xarray.Coordinates(places, indexes)
    found: xr.Dataset = xarray.Dataset(variables, coordinates, grid.attributes())
    return found


def _lazy(grid: SweepGrid, xarray: Any) -> xr.Dataset:
    """The sweep as dask arrays, of which nothing is computed yet."""
    needed("dask")
    chunks = dict(zip((axis.path for axis in grid.axes), grid.block, strict=True))
    values = [
        xarray.DataArray(axis.values, dims=[axis.path]).chunk({axis.path: chunks[axis.path]})
        for axis in grid.axes
    ]
    columns = xarray.apply_ufunc(
        partial(_block, grid.evaluator),
        *values,
        dask="parallelized",
        output_core_dims=[()] * len(grid.variables),
        output_dtypes=[dtype for dtype, _ in grid.variables.values()],
    )
    return _dataset(grid, xarray, [column.data for column in columns])


def _block(evaluator: SetEvaluator, *values: Array) -> tuple[Array, ...]:
    return compute(evaluator, values)


def in_floats(
    scene: Scene, varied: Sequence[Knob], values: Array
) -> tuple[dict[str, Array], Array]:
    """The variables of single sets of values where floats prove them, and the numbers of the sets
    that floats leave undecided; without those of hands.

    ``values`` : of what varies in rows, sets in columns, taken as exactly the binary numbers that
    they are.
    """
    return SetEvaluator.of(replace(scene, hands=()), varied).in_floats(values)


@dataclass(frozen=True, repr=False)
class Swept(Answer):
    """The data of a sweep of a scene, and the file to which they were written."""

    _schema: ClassVar[str] = "haptisym.sweep/1"
    _page: ClassVar[str] = "haptisym.pages.sweep:page"
    _figure: ClassVar[str] = "haptisym.figures.sweep:SWEEP"

    scene: Scene
    data: xr.Dataset
    out: Path | None = None

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(int(self.data.method.size), 'set')}"

    @property
    def certified(self) -> bool:
        """Whether every set has an answer."""
        return not bool(_is_open(self.data).any())

    @property
    def _varied(self) -> tuple[Collection[str], Collection[str] | None]:
        paths = [str(name) for name in self.data.method.dims]
        return paths, paths

    def _body(self) -> dict[str, Any]:
        data, variables = self.data, SweepVariables.of(self.scene)
        of_hands = [_held(data[name]) for name in data.data_vars if str(name).startswith(HELD)]
        method = data.method.data
        methods = [int(x.sum()) for x in (method == FLOAT, method == EXACT, _is_open(data))]
        return {
            "band": [float(x) for x in data.attrs["band"]],
            "vary": [_axis(data, str(name)) for name in data.method.dims],
            "sets": int(data.method.size),
            **dict(zip(("certified_in_floats", "exact", "open"), methods, strict=True)),
            "ranges": {name: _range(data[name]) for name in variables.floats},
            "counts": {name: _counts(data[name]) for name in variables.counts},
            **({"held": of_hands} if of_hands else {}),
            "out": None if self.out is None else str(self.out),
        }

    def _left(self) -> dict[str, Any]:
        notes = self.asides()
        return ({"notes": notes} if notes else {}) | (
            {} if self.certified else {"open_at": _places(self.data)}
        )


def _is_open(data: xr.Dataset) -> Any:
    """Which sets have no answer, or were not computed: an array of NumPy or dask, as the data
    are."""
    # Of the array itself, here and below: xarray would load dask for what NumPy does.
    method = data.method.data
    return (method != FLOAT) & (method != EXACT)


def _axis(data: xr.Dataset, name: str) -> dict[str, Any]:
    x = data[name].values
    ends = {"low": float(x.min()), "high": float(x.max())}
    return {"path": name, "unit": data[name].attrs["units"], **ends, "values": len(x)}


def _range(column: xr.DataArray) -> list[float] | None:
    x = column.data
    # filled, since dask warns of blocks that hold NaN alone; the ends are the wrong way round where
    # all of it is NaN
    low = float(np.where(np.isnan(x), np.inf, x).min())
    high = float(np.where(np.isnan(x), -np.inf, x).max())
    return None if low > high else [low, high]


def _counts(column: xr.DataArray) -> dict[str, int]:
    """The number of sets, by the value of a column of counts."""
    x = column.data
    low, high = int(x.min()), int(x.max())
    return {str(n): sets for n in range(max(low, 0), high + 1) if (sets := int((x == n).sum()))}


def _held(column: xr.DataArray) -> dict[str, Any]:
    """The number of sets that are stable in a hand, and of the others by their roots in
    Re s >= 0."""
    numbers, counts = np.unique(column.values, return_counts=True)
    sets = dict(zip(numbers.tolist(), counts.tolist(), strict=True))
    infinite, undecided = sets.pop(INFINITE, 0), sets.pop(UNKNOWN, 0)
    # after both marks were taken out what is left are numbers of roots, 0 for a stable display
    return {
        "hand": column.attrs["hand"],
        "variable": str(column.name),
        "stable": sets.get(0, 0),
        "unstable": {str(n): x for n, x in sets.items()},
        "infinite": infinite,
        "undecided": undecided,
    }


def _places(data: xr.Dataset, most: int = 5) -> list[dict[str, float]]:
    """The parameters of the first few sets that have no answer."""
    where = np.argwhere(np.asarray(_is_open(data)))[:most]
    names = [str(name) for name in data.method.dims]
    return [
        {name: float(data[name].values[i]) for name, i in zip(names, index, strict=True)}
        for index in where
    ]
