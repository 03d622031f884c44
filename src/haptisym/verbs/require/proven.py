"""What is proven of a set between the slices of a map: how far from straight lines between them anything else may be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from sympy import Expr

from haptisym.kernel.shown import Shown
from haptisym.programs.taylormodels import Array
from haptisym.verbs.require.feasible import End
from haptisym.verbs.require.plane import Rectangles
from haptisym.verbs.require.required import Requirement
from haptisym.verbs.require.slices import Slice

_ROUNDING, _SAME = 1e-9, 1e-12
"""Of a bound, and of a range."""


@dataclass(frozen=True, repr=False)
class Proof(Shown):
    """What is proven of one set of a map, all over its plane: rectangles inside and outside of it, and those left open.

    ``set`` : its number among the sets of a slice; ``jnd`` : the threshold, where it is not the scene's; ``window`` : the range
    of the second parameter.
    """

    set: int
    jnd: Expr | None
    rectangles: Rectangles
    window: tuple[Expr, Expr]

    def _line(self) -> str:
        return f"of set {self.set}: {self.rectangles}"

    def bounds(self, slices: Sequence[Slice]) -> tuple[float | None, ...]:
        """Between each two slices, how far from the lines that join them the set may differ from what these enclose.

        In units of the second parameter. None where no lines join them, or where something else is possible that no line is near.
        """
        rows = [(x.place, x.sets[self.set]) for x in slices]
        return tuple(self._bound((a, b), x, y) for (a, x), (b, y) in pairwise(rows))

    def _bound(self, at: tuple[float, float], one: Requirement, other: Requirement) -> float | None:
        if one.undecided or other.undecided or len(one.feasible) != len(other.feasible):
            return None
        lines = self._lines(one, other, "low", -np.inf), self._lines(one, other, "high", np.inf)
        kept, broken, left = (_Between(*_within(x, *at), *lines) for x in self.rectangles.parts)
        found = max(kept.distance, broken.depth, left.distance, left.depth)
        return found * (1 + _ROUNDING) if np.isfinite(found) else None

    def _lines(self, one: Requirement, other: Requirement, name: str, beyond: float) -> Array:
        """One end of each interval on both slices, (intervals, 2); infinite where that is the end of the range on both."""
        low, high = map(float, self.window)
        found = np.array([[_place(getattr(x, name)) for x in own.feasible] for own in (one, other)]).reshape(2, -1).T
        edges = np.abs(found - (low if beyond < 0 else high)) <= _SAME * (high - low)
        return np.where(edges.all(-1, keepdims=True), beyond, found)


@dataclass(frozen=True, eq=False)
class _Between:
    """Rectangles between two slices, cut off there, and the lines that join the ends of intervals on these.

    ``shares`` : (rectangles, 2), of the way from slice to slice; ``values`` : (rectangles, 2), of the second parameter.
    """

    shares: Array
    values: Array
    lows: Array
    highs: Array

    @property
    def distance(self) -> float:
        """How far from all intervals some of their points may be."""
        below, above = (
            self._at(self.lows).max(-1) - self.values[:, :1],
            self.values[:, 1:] - self._at(self.highs).min(-1),
        )
        return _most(np.maximum(np.maximum(below, above), 0.0).min(-1, initial=np.inf))

    @property
    def depth(self) -> float:
        """How far inside of an interval some of their points may be, from its nearer end."""
        over, under = (
            self.values[:, 1:] - self._at(self.lows).min(-1),
            self._at(self.highs).max(-1) - self.values[:, :1],
        )
        return _most(np.maximum(np.minimum(over, under), 0.0).max(-1, initial=0.0))

    def _at(self, lines: Array) -> Array:
        """The lines where the rectangles begin and end, (rectangles, lines, 2)."""
        start, end = lines[None, :, :1], lines[None, :, 1:]
        with np.errstate(invalid="ignore"):
            found = start + (end - start) * self.shares[:, None]
        return np.where(np.isinf(start) & np.isinf(end), start, found)


def _most(x: Array) -> float:
    return float(x.max(initial=0.0))


def _within(cells: Array, a: float, b: float) -> tuple[Array, Array]:
    """Of the rectangles those between two values of the first parameter: shares of the way, and values of the second one."""
    own = cells[(cells[:, 0, 0] < b) & (cells[:, 0, 1] > a)]
    return (np.clip(own[:, 0], a, b) - a) / (b - a), own[:, 1]


def _place(end: End) -> float:
    assert end.value is not None  # a map has a range
    return float(end.value)
