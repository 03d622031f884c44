"""Which values of a parameter keep conditions on a whole band, in floats with proven bounds, and all over a plane of two.

Which values of a parameter keep conditions on a whole band, and which break them, in floats with proven bounds.

Cells of band and values, thousands at once, in Taylor models (``programs.taylormodels``): where a condition is negative on a cell
no value of it is broken there; where it is positive on one, all of its values are. What neither shows for is cut, down to
cells a thousandth of their values wide: there the ends lie, for balls to find.

What is proven all over the plane of two parameters: rectangles in which conditions are kept, or broken, in Taylor models.

Of the JND a rectangle is broken where a condition is broken at one frequency for all of its values, and kept where every
condition is kept on all of the band for all of them. What shows neither is cut along what changes more, down to 1/256 of both
ranges. Of a hand roots of the display in it are counted (``held_plane``), down to 1/512.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from sympy import Dummy, Expr, Integer

from haptisym.judge.bounds import is_series
from haptisym.judge.crossings import Criterion
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import HaptisymError, LimitError
from haptisym.kernel.objects import Shown
from haptisym.kernel.rings import omega
from haptisym.model.scene import Knob, Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.tolerances.box import Box, Side
from haptisym.verbs.tolerances.heldbox import Pieces, RectangleSearch, held_plane
from haptisym.verbs.tolerances.search import Excess, LargerExcess, excess_of

_FIRST = 16
"""Pieces of the band to begin with."""
_MOST, _BATCH = 30_000, 1024
"""Cells that are looked at, and how many at once at most: fewer cost as much."""
_NARROW, _FINEST, _SMALL = 1e-3, 1e-10, 1e-3
"""Of values that are cut no further, relative to them; of a piece of the band, to all of it; and of one on which
small values leave open what is known."""

_THRESHOLDS = ("c", "c_real", "c_imag")
Range: TypeAlias = tuple[float, float]
Bounds: TypeAlias = tuple[Excess, Excess | None]
"""An excess, and one that is never smaller, which near a resonance of the environment is told by far larger cells."""


@dataclass(frozen=True)
class Told:
    """Values between two floats: ``kept`` with all conditions on all of the band, or not; None where that is not told."""

    low: float
    high: float
    kept: bool | None


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
        if is_threshold or not all(x.part or x.region for x in self.criteria):
            return ()
        try:
            box = _OneFree(self.scene, self.free.symbol.name)
            series = is_series(self.scene.chain)
            return tuple((excess_of(box, x), _larger(box, x) if series else None) for x in self.criteria)
        except HaptisymError:
            return ()


def _larger(box: Box, x: Criterion) -> Excess | None:
    return None if x.region or x.threshold.has(omega) else LargerExcess(box, x)


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

    def _round(self, excess: Excess, larger: Excess | None, cells: Array) -> Array:
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
            if larger and rest.any():
                rest[rest] = ~(larger.model(own[rest], slopes=0).bounds()[1][:, 0] < 0)
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


_FIRST_PIECES = 16  # of the band, to begin with
_FINEST_PLANE, _FINEST_HELD = 2.0**-8, 2.0**-9
_MOST_PLANE, _BATCH_PLANE = 60_000, 4096
"""Cells of band and plane that are looked at, and how many at once."""


@dataclass(frozen=True, eq=False, repr=False)
class Rectangles(Shown):
    """Rectangles that fill a plane, (rectangles, 2, 2): from where to where, of each parameter, SI.

    ``kept`` : conditions are kept for all of their values; ``broken`` : for none; ``left`` : neither was shown.
    """

    kept: Array
    broken: Array
    left: Array

    def _line(self) -> str:
        return f"{len(self.kept)} kept, {len(self.broken)} broken, {len(self.left)} left open"

    @property
    def parts(self) -> tuple[Array, Array, Array]:
        """All three."""
        return self.kept, self.broken, self.left

    @property
    def share_left(self) -> float:
        """Of the area, about which nothing is proven."""
        areas = [float((x[..., 1] - x[..., 0]).prod(-1).sum()) for x in self.parts]
        return areas[2] / sum(areas)


def rectangles(
    scene: Scene, free: tuple[Knob, Knob], ranges: Sequence[tuple[Expr, Expr]], criteria: Sequence[Criterion]
) -> Rectangles | None:
    """The plane of two parameters in rectangles; None where a criterion is none that models of floats are made of."""
    try:
        box = _Plane(scene, tuple(Side(x.name, *pair) for x, pair in zip(free, ranges, strict=True)))
        if not _is_modelled(box, free, criteria):
            return None
        excesses = [excess_of(box, x) for x in criteria]
    except HaptisymError:
        return None
    search = _SearchInPlane(_FINEST_PLANE, _MOST_PLANE, [x for x in excesses if not x.is_zero])
    search.go()
    return _placed(ranges, *(np.concatenate([_NONE, *x]) for x in (search.kept, search.broken, search.left)))


def held_rectangles(scene: Scene, free: tuple[Knob, Knob], ranges: Sequence[tuple[Expr, Expr]]) -> Rectangles | None:
    """The same of what is stable in the hands of a scene; None where nothing is known of it."""
    symbols = [Dummy() if x.parts else x.symbol for x in free]  # a threshold moves no root
    try:
        found = held_plane(
            scene, scene.hands, dict(zip(symbols, ranges, strict=True)), finest=_FINEST_HELD, most=2 * _MOST_PLANE
        )
    except HaptisymError:
        return None
    return _placed(ranges, found.stable, found.unstable, found.left)


def common(planes: Sequence[Rectangles]) -> Array:
    """Rectangles that are kept in all of several planes of the same ranges; what they fill may be cut otherwise."""
    count = round(1 / _FINEST_HELD)
    every = np.ones((count, count), bool)
    cells = np.concatenate(planes[0].parts)
    low, high = cells[..., 0].min(0), cells[..., 1].max(0)
    for plane in planes:
        own = np.zeros_like(every)
        shares = (plane.kept - low[:, None]) / (high - low)[:, None] * count
        for (a, b), (c, d) in np.rint(shares).astype(int):
            own[a:b, c:d] = True
        every &= own
    steps = np.linspace(low, high, count + 1)
    rows = [[steps[[i, i + 1], 0], steps[[a, b], 1]] for i, row in enumerate(every) for a, b in _runs(row)]
    return np.array(rows).reshape(-1, 2, 2)


def _runs(row: Array) -> list[tuple[int, int]]:
    """From where to where a row holds."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))


def _placed(ranges: Sequence[tuple[Expr, Expr]], *shares: Array) -> Rectangles:
    """Rectangles in shares of both ranges where they are."""
    lows, widths = (np.array(x)[:, None] for x in ([float(a) for a, _ in ranges], [float(b - a) for a, b in ranges]))
    return Rectangles(*(lows + widths * x for x in shares))


_NONE = np.empty((0, 2, 2))


@dataclass(frozen=True)
class _Plane(Box):
    """A box of two sides."""

    pair: tuple[Side, ...] = ()

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        return self.pair


def _is_modelled(box: Box, free: Sequence[Knob], criteria: Sequence[Criterion]) -> bool:
    """Whether each is a criterion of the JND of which a free threshold is a plain number."""
    if any(x.is_of_hand for x in free) or not all(x.part or x.region for x in criteria):
        return False
    limits = [x for x in free if x.parts]
    if not limits:
        return True
    plain = all(x.region is None and not x.threshold.has(omega) for x in criteria)
    return plain and all(
        box.part_name(x.part) == limit.name for x in criteria for limit in limits if x.part and x.part in limit.parts
    )


def _points(pieces: Pieces) -> Pieces:
    """One frequency of each piece of the band: the end of the band where it reaches there."""
    band = pieces.rest[:, 0]
    at = np.where(band[:, 1] == 1, 1.0, band.mean(-1))
    return Pieces(pieces.owner, np.stack([at, at], -1)[:, None])


@dataclass
class _SearchInPlane(RectangleSearch):
    """Rectangles in which conditions are kept, or broken; behind each are the pieces of the band on which that is open."""

    excesses: Sequence[Excess]
    kept: list[Array] = field(default_factory=list)
    broken: list[Array] = field(default_factory=list)

    def go(self) -> None:
        """Tell all rectangles."""
        steps = np.arange(_FIRST_PIECES + 1) / _FIRST_PIECES
        self._search([np.stack([steps[:-1], steps[1:]], -1)[:, None]] * len(self.excesses))

    def _round(self, plane: Array, pieces: Sequence[Pieces]) -> tuple[Array, list[Pieces]]:
        broken, changes = np.zeros(len(plane), bool), np.zeros((len(plane), 2))
        found = [self._judged(x, plane, own, broken, changes) for x, own in zip(self.excesses, pieces, strict=True)]
        doubtful = np.zeros(len(plane), bool)
        for own in found:
            doubtful[own.owner] = True
        doubtful &= ~broken
        self.kept.append(plane[~doubtful & ~broken])
        self.broken.append(plane[broken])
        return self._cut(plane, doubtful, changes, found)

    def _judged(self, excess: Excess, plane: Array, own: Pieces, broken: Array, changes: Array) -> Pieces:
        """The pieces of the band that stay in doubt; what is ``broken``, and along what it changes, is noted."""
        for again in (True, False):
            own = own.where(~broken[own.owner])
            low, high, rates = self._bounds(excess, own.cells(plane))
            broken[own.owner[low > 0]] = True
            doubt = ~(high < 0)
            own, rates = own.where(doubt), rates[doubt]
            broken[own.owner[self._bounds(excess, _points(own).cells(plane))[0] > 0]] = True
            if again:
                wide = rates[:, 0] >= rates[:, 1:].max(-1) / 2
                own = own.cut(wide, np.zeros(len(wide), int))
            else:
                np.maximum.at(changes, own.owner, rates[:, 1:])
        return own

    def _bounds(self, excess: Excess, cells: Array) -> tuple[Array, Array, Array]:
        """Bounds on an excess over cells, and how much it changes along each side; 0 where that is not known."""
        low, high, rates = np.empty(len(cells)), np.empty(len(cells)), np.empty(cells.shape[:2])
        for i in range(0, len(cells), _BATCH_PLANE):
            tick()
            part = slice(i, i + _BATCH_PLANE)
            model = excess.model(cells[part], slopes=0)
            low[part], high[part] = (x[:, 0] for x in model.bounds())
            rates[part] = np.abs(model.c1[:, 0]) + np.abs(model.c2[:, 0]).sum(-1)
        self.looked += len(cells)
        return low, high, np.nan_to_num(rates, nan=0.0, posinf=0.0)
