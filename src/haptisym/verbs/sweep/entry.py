"""Sweeps over design spaces: the certified answers of a scene for every combination of values of some parameters.

The answer in short is its axes, ranges and counts, not the sets themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from haptisym.judge.answers import Answer
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.reals import whole
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Knob, Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.stability.entry import in_hands
from haptisym.verbs.sweep.axes import EXACT, FLOAT, HELD, INFINITE, OPEN, UNKNOWN, AxisValues, Told, axes
from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.blocks import SETS_IN_A_BLOCK, Pace, SweepGrid, compute, needed, stored
from haptisym.verbs.sweep.passes import Kernel

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
    xarray = needed("xarray")
    grid = SweepGrid.of(scene, axes(scene, vary), whole("block", block, of=" of sets"))
    if out is not None:
        return stored(grid, Path(out), progress)
    return _lazy(grid, xarray) if lazy else _now(grid, xarray, progress)


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
    needed("dask")
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


def in_floats(scene: Scene, varied: Sequence[Knob], values: Array) -> tuple[dict[str, Array], Array]:
    """What floats prove of single sets of values, and the numbers of the sets that they leave open; nothing of hands.

    ``values`` : of what varies in rows, sets in columns, taken as exactly the binary numbers that they are.
    """
    return Kernel.of(replace(scene, hands=()), varied).in_floats(values)


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
        return not bool((self.data.method == OPEN).any())

    @property
    def _varied(self) -> tuple[Collection[str], Collection[str] | None]:
        paths = [str(name) for name in self.data.method.dims]
        return paths, paths

    def _body(self) -> dict[str, Any]:
        data, told = self.data, Told.of(self.scene)
        held = [_held(data[name]) for name in data.data_vars if str(name).startswith(HELD)]
        methods = [int((data.method == kind).sum()) for kind in (FLOAT, EXACT, OPEN)]
        return {
            "band": [float(x) for x in data.attrs["band"]],
            "vary": [_axis(data, str(name)) for name in data.method.dims],
            "sets": int(data.method.size),
            **dict(zip(("certified_in_floats", "exact", "open"), methods, strict=True)),
            "ranges": {name: _range(data[name]) for name in told.floats},
            "counts": {name: _counts(data[name]) for name in told.counts},
            **({"held": held} if held else {}),
            "out": None if self.out is None else str(self.out),
        }

    def _left(self) -> dict[str, Any]:
        notes = self.asides()
        return ({"notes": notes} if notes else {}) | ({} if self.certified else {"open_at": _places(self.data)})


def _axis(data: xr.Dataset, name: str) -> dict[str, Any]:
    x = data[name].values
    ends = {"low": float(x.min()), "high": float(x.max())}
    return {"path": name, "unit": data[name].attrs["units"], **ends, "values": len(x)}


def _range(column: xr.DataArray) -> list[float] | None:
    low, high = float(column.fillna(np.inf).min()), float(column.fillna(-np.inf).max())
    return None if low > high else [low, high]  # dask warns of blocks that hold NaN alone


def _counts(column: xr.DataArray) -> dict[str, int]:
    """How many sets have that many."""
    low, high = int(column.min()), int(column.max())
    return {str(n): found for n in range(max(low, 0), high + 1) if (found := int((column == n).sum()))}


def _held(column: xr.DataArray) -> dict[str, Any]:
    """How many sets are stable in a hand, and how many have that many roots in Re s >= 0."""
    numbers = [int(n) for n in np.unique(column)]
    sets = {n: int((column == n).sum()) for n in numbers}
    infinite, undecided = sets.pop(INFINITE, 0), sets.pop(UNKNOWN, 0)
    own = {"hand": column.attrs["hand"], "variable": str(column.name), "stable": sets.get(0, 0)}
    return {**own, "unstable": {str(n): x for n, x in sets.items()}, "infinite": infinite, "undecided": undecided}


def _places(data: xr.Dataset, most: int = 5) -> list[dict[str, float]]:
    """The parameters of the first few sets that have no answer."""
    where = np.argwhere((data.method == OPEN).values)[:most]
    names = [str(name) for name in data.method.dims]
    return [{name: float(data[name].values[i]) for name, i in zip(names, index, strict=True)} for index in where]
