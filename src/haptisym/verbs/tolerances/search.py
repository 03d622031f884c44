"""Branch and bound over band and box: where r may equal its threshold, and which way such crossings move.

Cells in which the excess keeps its sign are left out, proven. What stays are leaves: crossings lie in them and nowhere else.
Leaves that touch form a ``Cluster``. Where the slope by omega keeps its sign on all of a cluster away from the ends of the
band, every crossing in it goes on through the whole box: the implicit function theorem continues it to all values, and it
cannot leave the cluster, whose surroundings hold none.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from haptisym.judge.excess import Excess
from haptisym.kernel.errors import LimitError
from haptisym.kernel.where import Array, Batches, Columns, halves

_BATCH = 256  # cells that are bounded together
_MOST_CELLS = 3000  # that are looked at for one part
_MOST_SPLITS = 6  # of a cell: then it is a leaf if crossings in it are regular, or move one way with each parameter
_MOST_BEYOND = 800  # cells that are looked at for one end
OVERLAP = 1e-8  # shares of the band: clusters nearer to each other are taken as one
_FIRST = 32  # pieces of the band to begin with


@dataclass(frozen=True)
class Cluster:
    """Leaves that hang together, (cells, sides, 2) in shares; ``signs``: of the slopes on all of them, 0 where not the same.

    ``regular``: the slope by omega keeps its sign. ``low``, ``high``: bounds on the crossings in it, shares of the band.
    """

    cells: Array
    signs: tuple[int, ...]
    low: float
    high: float

    @property
    def regular(self) -> bool:
        """Whether the slope by omega keeps its sign in it."""
        return self.signs[0] != 0

    @property
    def inside(self) -> bool:
        """Whether its crossings keep clear of both ends of the band."""
        return self.clear_of(highest=False) and self.clear_of(highest=True)

    def clear_of(self, *, highest: bool) -> bool:
        """Whether its crossings keep clear of the high, or the low, end of the band."""
        return self.high < 1 if highest else self.low > 0


@dataclass(frozen=True)
class _Bounded:
    """Cells with the signs of value and slopes (0: not known), where their crossings lie, and the side to split."""

    cells: Array
    signs: Array
    omega: Array
    split: Array


def clusters(excess: Excess, within: tuple[float, float] = (0, 1)) -> tuple[Cluster, ...]:
    """All clusters of one part, in ascending order of frequency: outside them no r equals its threshold, proven.

    ``within`` : between which shares of the band is looked.
    """
    if excess.is_zero:
        return ()
    leaves = _leaves(excess, within)
    if not len(leaves.cells):
        return ()
    label, found = together(leaves.cells), []
    for n in np.unique(label):
        own = _chosen(leaves, label == n)
        signs = own.signs[:, 1:]
        same = np.where((signs == signs[0]).all(0), signs[0], 0)
        ends = float(own.omega[:, 0].min()), float(own.omega[:, 1].max())
        found.append(Cluster(own.cells, tuple(int(x) for x in same), *ends))
    return tuple(_apart(sorted(found, key=lambda x: x.low)))


def _apart(found: list[Cluster]) -> Iterator[Cluster]:
    """Clusters whose frequencies overlap as one, so that a frequency tells to which a crossing belongs."""
    waiting = found[0]
    for x in found[1:]:
        if x.low > waiting.high + OVERLAP:
            yield waiting
            waiting = x
            continue
        signs = tuple(a if a == b else 0 for a, b in zip(waiting.signs, x.signs, strict=True))
        waiting = Cluster(np.concatenate([waiting.cells, x.cells]), signs, waiting.low, max(waiting.high, x.high))
    yield waiting


def _leaves(excess: Excess, within: tuple[float, float]) -> _Bounded:
    first = np.tile([0.0, 1.0], (_FIRST, excess.sides, 1))
    first[:, 0] = sliding_window_view(np.linspace(*within, _FIRST + 1), 2)
    waiting = Batches(Columns((first, np.zeros(_FIRST, int))), size=_BATCH, what="cells of band and ranges")
    kept: list[_Bounded] = []
    try:
        for cells, depths in waiting:
            found = bounded(excess, cells)
            unclear = _unclear(excess, found)
            steady = (found.signs[:, 2:] != 0)[:, excess.matters[1:]].all(-1)
            regular, tired = found.signs[:, 1] != 0, depths >= _MOST_SPLITS
            clear_of_ends = (found.omega[:, 0] > 0) & (found.omega[:, 1] < 1)
            enough = ((steady | regular) & tired) | (waiting.examined > _MOST_CELLS)
            leaf = unclear & ((steady & regular & clear_of_ends) | enough)
            kept.append(_chosen(found, leaf))
            rest = unclear & ~leaf
            waiting.add(Columns((halves(found.cells[rest], found.split[rest]), np.tile(depths[rest] + 1, 2))))
    except LimitError:  # of what waits nothing is known: crossings may be anywhere in it
        rest, _ = waiting.rest
        signs = np.zeros((len(rest), 1 + excess.sides), int)
        kept.append(_Bounded(rest, signs, rest[:, 0].copy(), signs[:, 0]))
    return _Bounded(
        *(np.concatenate([getattr(x, name) for x in kept]) for name in ("cells", "signs", "omega", "split"))
    )


def _unclear(excess: Excess, found: _Bounded) -> Array:
    """Where the excess may vanish: not where it is > 0 at the corner where it is least, or < 0 where it is greatest."""
    unclear = found.signs[:, 0] == 0
    which = np.flatnonzero(unclear)
    if len(which):
        corners = [_corner(found.cells[which], found.signs[which, 2:], to) for to in (-1, 1)]
        low, high = (x[:, 0] for x in excess.model(np.concatenate(corners), slopes=0).bounds())
        unclear[which] = ~((low[: len(which)] > 0) | (high[len(which) :] < 0))
    return unclear


def _corner(cells: Array, signs: Array, to: int) -> Array:
    """Each cell with the parameters along which the excess is monotonic at the end where it is greatest (1) or least (-1)."""
    moved = cells.copy()
    at = np.where(signs * to > 0, cells[:, 1:, 1], cells[:, 1:, 0])
    moved[:, 1:] = np.where(signs[..., None] != 0, at[..., None], cells[:, 1:])
    return moved


def _chosen(x: _Bounded, which: Array) -> _Bounded:
    return _Bounded(x.cells[which], x.signs[which], x.omega[which], x.split[which])


def bounded(excess: Excess, cells: Array) -> _Bounded:
    """What is known about the excess over cells."""
    model = excess.model(cells)
    low, high = model.bounds()
    signs = np.where(low > 0, 1, np.where(high < 0, -1, 0))
    with np.errstate(all="ignore"):
        omega = _contracted(cells, model.c0[:, 0], model.c1[:, 0], model.c2[:, 0], model.r[:, 0], low[:, 1], high[:, 1])
        weight = np.where((signs == 0) & np.isfinite(high), 1 / (high - low), 0.0)
        changes = np.abs(model.c1)
        changes[:, : model.c2.shape[1]] += np.abs(model.c2).sum(-1)
        score = np.where(
            weight[:, :1] > 0, (weight[:, :, None] * changes).sum(1), changes[:, 0]
        )  # near a pole the value's alone
    width = cells[:, :, 1] - cells[:, :, 0]
    score = np.where(np.isfinite(score).all(-1, keepdims=True) & (score > 0).any(-1, keepdims=True), score, width)
    return _Bounded(cells, signs, omega, np.argmax(np.where(width > 0, score + 1e-300, -1), -1))


def _contracted(cells: Array, c0: Array, c1: Array, c2: Array, r: Array, least: Array, most: Array) -> Array:
    """Where in each cell the excess may vanish, in shares of the band: F = F(t_0 = 0) + dF/dt_0 t_0 for one slope of the cell."""
    rest = np.abs(c1[:, 1:]).sum(-1) + np.abs(c2[:, 1:, 1:]).sum((-1, -2)) + r
    ends = np.stack([-(c0 + a * rest * (1 + 1e-13)) / g for a in (-1, 1) for g in (least, most)])
    steady = (least * most > 0) & np.isfinite(ends).all(0)
    low = np.where(steady, np.clip(ends.min(0) - 1e-13, -1, 1), -1)
    high = np.where(steady, np.clip(ends.max(0) + 1e-13, -1, 1), 1)
    middle, radius = cells[:, 0].mean(-1), (cells[:, 0, 1] - cells[:, 0, 0]) / 2
    return np.stack([middle + radius * low, middle + radius * high], -1) + np.array([-1e-15, 1e-15])


def together(cells: Array) -> Array:
    """A label for each cell, the same for cells that touch, directly or through others."""
    label = np.full(len(cells), -1)
    low, high = np.ascontiguousarray(cells.T)
    alone = np.arange(len(cells))
    while len(alone):
        first, waiting = alone[0], [alone[0]]
        label[first] = first
        while waiting:
            own = waiting.pop()
            near = (low[:, alone] <= high[:, own, None]).all(0) & (low[:, own, None] <= high[:, alone]).all(0)
            label[alone[near]] = first
            waiting += alone[near].tolist()
            alone = alone[~near]
    return label


def beyond(excess: Excess, cells: Array, reached: float, *, highest: bool) -> float:
    """A bound on how low (high) crossings in cells go, shares of the band: ``reached`` itself where none goes beyond."""
    out = 1 if highest else -1
    near, far = (0, 1) if highest else (1, 0)

    def further(own: Array) -> Array:
        """What of some cells is beyond."""
        own = own[out * (own[:, 0, far] - reached) > 0].copy()
        own[:, 0, near] = out * np.maximum(out * own[:, 0, near], out * reached)
        return own

    waiting = Batches(further(cells), size=_BATCH, rank=lambda x: -out * x[:, 0, far], most=_MOST_BEYOND + 1)
    with suppress(LimitError):
        for own in waiting:
            found = bounded(excess, own)
            found = _chosen(found, _unclear(excess, found))
            own = found.cells.copy()
            own[:, 0, 0] = np.maximum(own[:, 0, 0], found.omega[:, 0])
            own[:, 0, 1] = np.minimum(own[:, 0, 1], found.omega[:, 1])
            whole = own[:, 0, 0] <= own[:, 0, 1]
            waiting.add(further(halves(own[whole], found.split[whole])))
    left = waiting.rest
    return float(out * np.max(out * left[:, 0, far])) if len(left) else reached
