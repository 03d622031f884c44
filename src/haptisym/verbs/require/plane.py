"""What is proven all over the plane of two parameters: rectangles in which conditions are kept, or broken, in Taylor models.

Of the JND a rectangle is broken where a condition is broken at one frequency for all of its values, and kept where every
condition is kept on all of the band for all of them. What shows neither is cut along what changes more, down to 1/256 of both
ranges. Of a hand roots of the display in it are counted (``held_plane``), down to 1/512.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from sympy import Dummy, Expr

from haptisym.judge.criteria import Criterion
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.shown import Shown
from haptisym.kernel.symbols import omega
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.tolerances.box import Box, Side
from haptisym.verbs.tolerances.heldbox import Pieces, RectangleSearch, held_plane
from haptisym.verbs.tolerances.search import Excess, excess_of

_FIRST_PIECES = 16  # of the band, to begin with
_FINEST, _FINEST_HELD = 2.0**-8, 2.0**-9
_MOST, _BATCH = 60_000, 4096
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
    search = _Search(_FINEST, _MOST, [x for x in excesses if not x.is_zero])
    search.go()
    return _placed(ranges, *(np.concatenate([_NONE, *x]) for x in (search.kept, search.broken, search.left)))


def held_rectangles(scene: Scene, free: tuple[Knob, Knob], ranges: Sequence[tuple[Expr, Expr]]) -> Rectangles | None:
    """The same of what is stable in the hands of a scene; None where nothing is known of it."""
    symbols = [Dummy() if x.parts else x.symbol for x in free]  # a threshold moves no root
    try:
        found = held_plane(
            scene, scene.hands, dict(zip(symbols, ranges, strict=True)), finest=_FINEST_HELD, most=2 * _MOST
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
class _Search(RectangleSearch):
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
        for i in range(0, len(cells), _BATCH):
            tick()
            part = slice(i, i + _BATCH)
            model = excess.model(cells[part], slopes=0)
            low[part], high[part] = (x[:, 0] for x in model.bounds())
            rates[part] = np.abs(model.c1[:, 0]) + np.abs(model.c2[:, 0]).sum(-1)
        self.looked += len(cells)
        return low, high, np.nan_to_num(rates, nan=0.0, posinf=0.0)
