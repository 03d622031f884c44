"""Rectangles of a plane of two numbers for none of whose values a loop with a clock has roots on the unit circle."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.clocked import Cell, OnCircle, halves

_FIRST = 8  # of each range, to begin with
_MOST_PIECES = 48  # of what else varies, that are looked at for one rectangle


@dataclass(frozen=True)
class ClockPlane:
    """Several loops, the first two of whose numbers make the plane, down to a ``finest`` share, by at ``most`` some cells."""

    loops: Sequence[OnCircle]
    finest: float
    most: int

    def rectangles(self) -> tuple[Array, Array]:
        """Those that are clear, and what is left; (rectangles, 2, 2), in shares of both ranges."""
        clear, left, looked = list[Cell](), list[Cell](), 0
        whole: Cell = ((Fraction(0), Fraction(1)),) * (len(self.loops[0].ranges) - 2)
        waiting = deque((own, [[whole] for _ in self.loops]) for own in _grid())
        try:
            while waiting and looked <= self.most:
                own, rest = waiting.popleft()
                tick(looked, self.most, "rectangles")
                rest, tried = self._doubtful(own, rest)
                looked += tried
                if not any(rest):
                    clear.append(own)
                elif max(b - a for a, b in own) <= self.finest:
                    left.append(own)
                else:
                    waiting += ((half, rest) for half in halves(own, (0, 1)))
        except LimitError:
            left.append(own)
        left += [x for x, _ in waiting]
        return _array(clear), _array(left)

    def _doubtful(self, own: Cell, rest: Sequence[Sequence[Cell]]) -> tuple[list[list[Cell]], int]:
        """Of a rectangle, for each loop the cells of what else varies in which it is not clear, and how many were looked at.

        They are cut while it is clear for the middle of them: else it is the rectangle that is too large.
        """
        found, looked = list[list[Cell]](), 0
        for loop, others in zip(self.loops, rest, strict=True):
            waiting, doubtful, most = [*others], list[Cell](), looked + _MOST_PIECES
            while waiting:
                cell, looked = waiting.pop(), looked + 1
                if loop.is_clear((*own, *cell)):
                    continue
                looked += bool(cell)
                if not cell or looked >= most or not loop.is_clear((*own, *map(_middle, cell))):
                    doubtful.append(cell)
                    break
                waiting += halves(cell, range(len(cell)))
            found.append([*waiting, *doubtful])
        return found, looked


def _middle(side: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    return (sum(side, Fraction(0)) / 2,) * 2


def _grid() -> Iterator[Cell]:
    steps = [Fraction(i, _FIRST) for i in range(_FIRST + 1)]
    sides = list(pairwise(steps))
    return ((a, b) for a in sides for b in sides)


def _array(cells: Sequence[Cell]) -> Array:
    return np.array([[[float(x) for x in side] for side in cell] for cell in cells]).reshape(-1, 2, 2)
