"""Which values of a parameter keep conditions on a whole band, and which break them, in floats with proven bounds.

Cells of band and values, thousands at once, in Taylor models (``programs.taylormodels``): where a condition is negative on a cell
no value of it is broken there; where it is positive on one, all of its values are. What neither shows for is cut, down to
cells a thousandth of their values wide: there the ends lie, for balls to find.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from sympy import Integer

from haptisym.judge.bounds import ANY_ENVIRONMENT, is_series
from haptisym.judge.crossings import Criterion
from haptisym.judge.excess import Box, Excess, LargerExcess, Side, excess_of
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import HaptisymError, LimitError
from haptisym.kernel.rings import omega
from haptisym.model.scene import Knob, Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.require.places import Told

_FIRST = 16
"""Pieces of the band to begin with."""
_MOST, _HARD, _BATCH = 100_000, 2000, 1024
"""Cells that are looked at, after how many the larger excess is asked too, and how many at once: fewer cost as much."""
_NARROW, _FINEST, _SMALL = 1e-3, 1e-10, 1e-3
"""Of values that are cut no further, relative to them; of a piece of the band, to all of it; and of one on which
small values leave open what is known."""

_THRESHOLDS = ("c", "c_real", "c_imag")
Range: TypeAlias = tuple[float, float]
Bounds: TypeAlias = tuple[Excess, Callable[[], Excess] | None]
"""An excess, and what makes one that is never smaller, which near a resonance of the environment is told by far larger cells."""


@dataclass(frozen=True)
class _OneFree(Box):
    """A box with one side, whose shares are the values themselves."""

    name: str = ""

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        return (Side(self.name, Integer(0), Integer(1)),)


@dataclass(frozen=True)
class FloatCells:
    """Criteria of a scene in which one parameter is free; ``scale``: a usual size of it."""

    scene: Scene
    free: Knob
    criteria: Sequence[Criterion]
    scale: float

    def told(self, low: float, high: float) -> list[Told]:
        """What is known of the values from one to another, in order."""
        if not self._excesses:
            return [Told(low, high, None)]
        search = _Search(self._excesses, 0.0 if low * high > 0 else self.scale * _NARROW)
        search.go(ladder(low, high, self.scale))
        return list(_partition(low, high, search.open, search.broken))

    @cached_property
    def _excesses(self) -> tuple[Bounds, ...]:
        """None where one of the criteria is not to be had in floats."""
        is_threshold = self.free.parts or self.free.symbol.name in _THRESHOLDS
        if is_threshold or not all(x.part or x.region or x.name == ANY_ENVIRONMENT.name for x in self.criteria):
            return ()
        try:
            box = _OneFree(self.scene, self.free.symbol.name)
            series = is_series(self.scene.chain)
            return tuple((excess_of(box, x), _larger(box, x) if series else None) for x in self.criteria)
        except HaptisymError:
            return ()


def _larger(box: Box, x: Criterion) -> Callable[[], Excess] | None:
    return None if x.part is None or x.region or x.threshold.has(omega) else cache(partial(LargerExcess, box, x))


@dataclass
class _Search:
    """``least``: the size of values below which widths are no longer relative to them."""

    excesses: Sequence[Bounds]
    least: float
    open: list[Range] = field(default_factory=list)
    broken: list[Range] = field(default_factory=list)
    looked: int = 0

    def go(self, ends: Sequence[float]) -> None:
        """Cut until all is told, or told well enough, or too much was looked at."""
        which = [(x, larger) for x, larger in self.excesses if not x.is_zero]
        waiting = [self._start(ends) for _ in which]
        try:
            while any(map(len, waiting)) and self.looked < _MOST:
                waiting = [self._round(*x, cells) for x, cells in zip(which, waiting, strict=True)]
                union = _union(self.broken)
                self.broken = [(float(a), float(b)) for a, b in union]
                waiting = [_outside(cells, union) for cells in waiting]
        except LimitError:
            pass
        self.open += [(float(a), float(b)) for cells in waiting for a, b in cells[:, 1]]

    def _start(self, ends: Sequence[float]) -> Array:
        steps = np.arange(_FIRST + 1) / _FIRST
        listed = np.array(ends)
        cells = np.empty((len(listed) - 1, _FIRST, 2, 2))
        cells[:, :, 0, 0], cells[:, :, 0, 1] = steps[:-1], steps[1:]
        cells[:, :, 1, 0], cells[:, :, 1, 1] = listed[:-1, None], listed[1:, None]
        return cells.reshape(-1, 2, 2)

    def _round(self, excess: Excess, larger: Callable[[], Excess] | None, cells: Array) -> Array:
        """What is left of some cells, cut."""
        if not len(cells):
            return cells
        left, cut = [], []
        for own in np.array_split(cells, -(-len(cells) // _BATCH)):
            tick(min(self.looked, _MOST), _MOST, "cells of band and values")
            self.looked += len(own)
            found = excess.model(own, slopes=0)
            low, high = (x[:, 0] for x in found.bounds())
            self.broken += [(float(a), float(b)) for a, b in own[low > 0, 1]]
            self._probe(excess, own[(low < 0) & (found.c0[:, 0] > 0)])
            rest = ~(high < 0) & ~(low > 0)
            if larger and self.looked > _HARD and rest.any():
                rest[rest] = ~(larger().model(own[rest], slopes=0).bounds()[1][:, 0] < 0)
            left.append(own[rest])
            cut.append(_changes(found.c1[rest, 0], found.c2[rest, 0], found.r[rest, 0]))
        return self._cut(np.concatenate(left), np.concatenate(cut))

    def _probe(self, excess: Excess, cells: Array) -> None:
        """At the middle frequencies of some cells, for all of their values."""
        if len(cells):
            points = cells.copy()
            points[:, 0] = cells[:, 0].mean(-1)[:, None]
            shown = excess.model(points, slopes=0).bounds()[0][:, 0] > 0
            self.broken += [(float(a), float(b)) for a, b in cells[shown, 1]]

    def _cut(self, cells: Array, changes: Array) -> Array:
        """Cells in pieces along what changes most; those that are narrow enough are left open."""
        widths = cells[..., 1] - cells[..., 0]
        widths[:, 1] /= np.maximum(np.abs(cells[:, 1]).max(-1), self.least)
        narrow = widths < np.array([_FINEST, _NARROW])
        spread = (cells[..., 1] - cells[..., 0]) / np.maximum(np.abs(cells).max(-1), 1e-300)
        weights = np.where(
            np.isfinite(changes).all(-1, keepdims=True), changes, spread
        )  # what is unknown along the wider
        wanted = (weights >= weights.max(-1, keepdims=True) / 4) & ~narrow
        stuck = ~wanted.any(-1)
        small = (np.abs(cells[:, 1]).max(-1) < self.least) & (widths[:, 0] < _SMALL) & (cells[:, 0, 0] > 0)
        lost = ~np.isfinite(changes).all(-1) | (weights[:, 1] >= weights[:, 0] / 4)
        done = (stuck | (small & lost)) & narrow[:, 1]
        wanted[stuck & ~done, 1] = True  # a piece of the band that is narrow: along the values then
        self.open += [(float(a), float(b)) for a, b in cells[done, 1]]
        cells, wanted = cells[~done], wanted[~done]
        parts = 4 if len(cells) * 16 <= _BATCH else 2
        for side in (0, 1):
            cells, wanted = _in_parts(cells, wanted, side, parts)
        return cells


def _changes(c1: Array, c2: Array, rest: Array) -> Array:
    """How much a model changes along each side; what is left of it may be due to either."""
    return np.abs(c1) + np.abs(c2).sum(-1) + rest[:, None]


def _in_parts(cells: Array, wanted: Array, side: int, parts: int) -> tuple[Array, Array]:
    """Cells cut along a side, where that is wanted; between positive numbers that are far apart at their geometric means."""
    now, kept = wanted[:, side], ~wanted[:, side]
    own = cells[now]
    a, b = own[:, side, 0], own[:, side, 1]
    shares = np.arange(parts + 1)[:, None] / parts
    with np.errstate(all="ignore"):
        places = np.where((a > 0) & (4 * a < b), a * (b / a) ** shares, a + (b - a) * shares)
        places = np.where((b < 0) & (a < 4 * b), b * (a / b) ** (1 - shares), places)
        near = np.where(shares == 0, 0.0, 0.25 ** (parts - parts * shares))
        places = np.where((a == 0) & (side == 1), b * near, places)
        places = np.where((b == 0) & (side == 1), a * near[::-1], places)
    places[0], places[-1] = a, b
    pieces = np.repeat(own[None], parts, 0)
    pieces[:, :, side, 0], pieces[:, :, side, 1] = places[:-1], places[1:]
    return (
        np.concatenate([cells[kept], pieces.reshape(-1, 2, 2)]),
        np.concatenate([wanted[kept], np.tile(wanted[now], (parts, 1))]),
    )


def _union(ranges: Sequence[Range]) -> Array:
    """Ranges that touch put together, in order."""
    found: list[list[float]] = []
    for a, b in sorted(ranges):
        if found and a <= found[-1][1]:
            found[-1][1] = max(found[-1][1], b)
        else:
            found.append([a, b])
    return np.array(found).reshape(-1, 2)


def _outside(cells: Array, union: Array) -> Array:
    """The cells whose values are not all among some."""
    if not len(union) or not len(cells):
        return cells
    at = np.searchsorted(union[:, 0], cells[:, 1, 0], side="right") - 1
    inside = (at >= 0) & (cells[:, 1, 1] <= union[np.maximum(at, 0), 1])
    return cells[~inside]


def _partition(low: float, high: float, left: Sequence[Range], broken: Sequence[Range]) -> Iterator[Told]:
    """All values from one to the other, in order: broken, open, or kept where neither."""
    out, doubtful = _union(broken), _union(left)
    places = sorted({low, high, *out.ravel().tolist(), *doubtful.ravel().tolist()})

    def holds(union: Array, a: float, b: float) -> bool:
        return bool(((union[:, 0] <= a) & (b <= union[:, 1])).any())

    for a, b in pairwise(places):
        yield Told(a, b, False if holds(out, a, b) else None if holds(doubtful, a, b) else True)


def ladder(low: float, high: float, scale: float) -> list[float]:
    """Numbers from one to another at which cells may begin: at powers of 2 of a usual size, on both sides of 0."""
    sizes = [scale * 2.0**n for n in range(-60 if low * high > 0 else -20, 60)]
    marks = [-x for x in sizes] + [0.0] + sizes
    return sorted({low, high, *(x for x in marks if low < x < high)})
