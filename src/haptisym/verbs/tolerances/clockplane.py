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
from haptisym.verbs.stability.oncircle import Cell, OnCircle, halves

_FIRST = 8  # of each range, to begin with
_MOST_PIECES = 12  # of what else varies, that are looked at for one rectangle


@dataclass(frozen=True)
class ClockPlane:
    """Several loops, the first two of whose numbers make the plane, down to a ``finest`` share, by at ``most`` some cells."""

    loops: Sequence[OnCircle]
    finest: float
    most: int

    def rectangles(self) -> tuple[Array, Array]:
        """Those that are clear, and what is left; (rectangles, 2, 2), in shares of both ranges."""
        waiting, clear, left, looked = deque(_grid()), list[Cell](), list[Cell](), 0
        try:
            while waiting:
                own = waiting.popleft()
                tick()
                is_clear, tried = self._judged(own)
                looked += tried
                if is_clear:
                    clear.append(own)
                elif looked > self.most or max(b - a for a, b in own) <= self.finest:
                    left.append(own)
                else:
                    waiting += halves(own, (0, 1))
        except LimitError:
            left += [own, *waiting]
        return _array(clear), _array(left)

    def _judged(self, own: Cell) -> tuple[bool, int]:
        """Whether a rectangle is clear of all loops for all of what else varies, and in how many cells it was looked at."""
        others, looked = len(self.loops[0].ranges) - 2, 0
        for loop in self.loops:
            waiting, most = [(*own, *[(Fraction(0), Fraction(1))] * others)], looked + (_MOST_PIECES if others else 1)
            while waiting and looked < most:
                cell, looked = waiting.pop(), looked + 1
                if not loop.is_clear(cell):
                    waiting += halves(cell, range(2, len(cell))) if others else [cell]
            if waiting:
                return False, looked
        return True, looked


def _grid() -> Iterator[Cell]:
    steps = [Fraction(i, _FIRST) for i in range(_FIRST + 1)]
    sides = list(pairwise(steps))
    return ((a, b) for a in sides for b in sides)


def _array(cells: Sequence[Cell]) -> Array:
    return np.array([[[float(x) for x in side] for side in cell] for cell in cells]).reshape(-1, 2, 2)
