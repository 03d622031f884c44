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

    ``of`` : what was asked; ``set`` : its number among the sets of a slice; ``jnd`` : the threshold, where it is not the scene's;
    ``window`` : the range of the second parameter.
    """

    of: str
    set: int
    jnd: Expr | None
    rectangles: Rectangles
    window: tuple[Expr, Expr]

    def _line(self) -> str:
        return f"{self.of}: {self.rectangles}"

    def bounds(self, slices: Sequence[Slice]) -> tuple[float | None, ...]:
        """Between each two slices, how far from the lines that join them the set may differ from what these enclose.

        In units of the second parameter. Of what stays open it is told from the ends of the range too, where the set reaches
        there. None where slices differ in kind, or where something else is possible that no line is near.
        """
        rows = [(x.place, x.sets[self.set]) for x in slices]
        return tuple(self._bound((a, b), x, y) for (a, x), (b, y) in pairwise(rows))

    def _bound(self, at: tuple[float, float], one: Requirement, other: Requirement) -> float | None:
        if one.undecided or other.undecided or len(one.feasible) != len(other.feasible):
            return None
        edges = float(self.window[0]), float(self.window[1])
        low, high = (_ends(one, other, name) for name in ("low", "high"))
        lines = _unbounded(low, edges[0], -np.inf), _unbounded(high, edges[1], np.inf)
        kept, broken = (_Between(*_within(x, *at), *lines, (-np.inf, np.inf)) for x in self.rectangles.parts[:2])
        left = _Between(*_within(self.rectangles.left, *at), low, high, edges)
        found = max(kept.distance, broken.depth, left.distance, left.depth)
        return found * (1 + _ROUNDING) if np.isfinite(found) else None


@dataclass(frozen=True, eq=False)
class _Between:
    """Rectangles between two slices, cut off there, and the lines that join the ends of intervals on these.

    ``shares`` : (rectangles, 2), of the way from slice to slice; ``values`` : (rectangles, 2), of the second parameter.
    """

    shares: Array
    values: Array
    lows: Array
    highs: Array
    edges: tuple[float, float]

    def _most(self, found: Array) -> float:
        """The largest; of rectangles at an end of the range no more than what they reach to from there."""
        is_there = (self.values <= self.edges[0]).any(-1) | (self.values >= self.edges[1]).any(-1)
        reached = np.where(is_there, self.values[:, 1] - self.values[:, 0], np.inf)
        return float(np.minimum(found, reached).max(initial=0.0))

    @property
    def distance(self) -> float:
        """How far from all intervals some of their points may be."""
        below, above = (
            self._at(self.lows).max(-1) - self.values[:, :1],
            self.values[:, 1:] - self._at(self.highs).min(-1),
        )
        return self._most(np.maximum(np.maximum(below, above), 0.0).min(-1, initial=np.inf))

    @property
    def depth(self) -> float:
        """How far inside of an interval some of their points may be, from its nearer end."""
        over, under = (
            self.values[:, 1:] - self._at(self.lows).min(-1),
            self._at(self.highs).max(-1) - self.values[:, :1],
        )
        return self._most(np.maximum(np.minimum(over, under), 0.0).max(-1, initial=0.0))

    def _at(self, lines: Array) -> Array:
        """The lines where the rectangles begin and end, (rectangles, lines, 2)."""
        start, end = lines[None, :, :1], lines[None, :, 1:]
        with np.errstate(invalid="ignore"):
            found = start + (end - start) * self.shares[:, None]
        return np.where(np.isinf(start) & np.isinf(end), start, found)


def _within(cells: Array, a: float, b: float) -> tuple[Array, Array]:
    """Of the rectangles those between two values of the first parameter: shares of the way, and values of the second one."""
    own = cells[(cells[:, 0, 0] < b) & (cells[:, 0, 1] > a)]
    return (np.clip(own[:, 0], a, b) - a) / (b - a), own[:, 1]


def _ends(one: Requirement, other: Requirement, name: str) -> Array:
    """One end of each interval on both slices, (intervals, 2)."""
    return np.array([[_place(getattr(x, name)) for x in own.feasible] for own in (one, other)]).reshape(2, -1).T


def _unbounded(ends: Array, edge: float, beyond: float) -> Array:
    """The same, infinite where it is the end of the range on both slices."""
    return np.where((np.abs(ends - edge) <= _SAME * abs(edge)).all(-1, keepdims=True), beyond, ends)


def _place(end: End) -> float:
    assert end.value is not None  # a map has a range
    return float(end.value)
