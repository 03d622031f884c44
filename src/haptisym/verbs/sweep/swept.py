"""What a sweep says in short: axes, ranges and counts of its data, not the sets themselves."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from haptisym.judge.answers import Answer
from haptisym.kernel.shown import counted, titled
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.told import EXACT, FLOAT, HELD, INFINITE, OPEN, UNKNOWN, Told

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, repr=False)
class Swept(Answer):
    """The data of a sweep of a scene, and the file to which they were written."""

    _schema: ClassVar[str] = "haptisym.sweep/1"
    _page: ClassVar[str] = "haptisym.pages.sweep:page"
    _figure: ClassVar[str] = "haptisym.figures.sweep:swept_figure"

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
