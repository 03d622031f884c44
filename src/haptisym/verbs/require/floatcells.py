"""Which values of a parameter keep conditions on a whole band, and which break them, in floats with proven bounds.

The one search (``kernel.where``) with the values as its outer side, the band as its inner one, and the excess of each
criterion in Taylor models as a judge. Values are cut down to a thousandth of themselves: what is still open then holds
the ends of the set, for balls to find.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import groupby

import numpy as np
from sympy import Integer

from haptisym.judge.bounds import ANY_ENVIRONMENT, is_series
from haptisym.judge.crossings import Criterion
from haptisym.judge.excess import Box, Excess, LargerExcess, Side, excess_of
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.rings import omega
from haptisym.kernel.where import Array, Curve, search
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.require.places import Told

_FIRST = 16
"""Pieces of the band to begin with."""
_HARD = 2000
"""After how many cells the larger excess is asked too."""
_NARROW = 1e-3
"""Of values that are cut no further, relative to them."""

_THRESHOLDS = ("c", "c_real", "c_imag")


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
        if self._excesses is None:
            return [Told(low, high, None)]
        least = 0.0 if low * high > 0 else self.scale * _NARROW  # a size below which widths are no longer relative

        def wide(cells: Array) -> Array:
            return cells[..., 1] - cells[..., 0] >= _NARROW * np.maximum(np.abs(cells).max(-1), least)

        marks, steps = np.array(ladder(low, high, self.scale)), np.arange(_FIRST + 1) / _FIRST
        outer, inner = (np.stack([x[:-1], x[1:]], -1)[:, None] for x in (marks, steps))
        judges = [_Judge(*x) for x in self._excesses]
        found = search(judges, outer, inner, wide=wide, what="cells of band and values")
        rows = ((x.outer[:, 0].tolist(), kept) for x, kept in zip(found.parts, (True, False, None), strict=True))
        return _merged(sorted((Told(a, b, kept) for cells, kept in rows for a, b in cells), key=lambda x: x.low))

    @cached_property
    def _excesses(self) -> list[tuple[Excess, Callable[[], Excess] | None]] | None:
        """None where one of the criteria is not to be had in floats."""
        is_threshold = self.free.parts or self.free.symbol.name in _THRESHOLDS
        if is_threshold or not all(x.part or x.region or x.name == ANY_ENVIRONMENT.name for x in self.criteria):
            return None
        try:
            box = _OneFree(self.scene, self.free.symbol.name)
            series = is_series(self.scene.chain)
            listed = [(excess_of(box, x), _larger(box, x) if series else None) for x in self.criteria]
            return [x for x in listed if not x[0].is_zero]
        except HaptisymError:
            return None


def _larger(box: Box, x: Criterion) -> Callable[[], Excess] | None:
    return None if x.part is None or x.region or x.threshold.has(omega) else cache(partial(LargerExcess, box, x))


@dataclass
class _Judge:
    """An excess, and what makes one that is never smaller, which near a resonance of the environment larger cells show."""

    excess: Excess
    larger: Callable[[], Excess] | None
    looked: int = 0

    def __call__(self, cells: Array) -> Curve:
        self.looked += len(cells)
        found = self.excess.curve(cells)
        if self.larger and self.looked > _HARD:
            rest = np.flatnonzero(~found.negative)
            if len(rest):
                return found.known_negative(rest[self.larger().curve(cells[rest]).negative])
        return found


def _merged(told: Sequence[Told]) -> list[Told]:
    """Neighbours of which the same is known as one."""
    rows = (list(own) for _, own in groupby(told, lambda x: x.kept))
    return [Told(own[0].low, own[-1].high, own[0].kept) for own in rows]


def ladder(low: float, high: float, scale: float) -> list[float]:
    """Numbers from one to another at which cells may begin: at powers of 2 of a usual size, on both sides of 0."""
    sizes = [scale * 2.0**n for n in range(-60 if low * high > 0 else -20, 60)]
    marks = [-x for x in sizes] + [0.0] + sizes
    return sorted({low, high, *(x for x in marks if low < x < high)})
