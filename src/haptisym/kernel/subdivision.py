"""Branch and bound: cells are examined until each is settled; what is not is cut, and its pieces wait their turn.

Every loop of that kind runs on ``Waiting``, so that each has a limit in number and in time, and says what it leaves open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from heapq import heappop, heappush
from typing import Any, Generic, TypeVar

from haptisym.kernel.budget import tick

C = TypeVar("C")


class Waiting(Generic[C]):
    """Cells that wait to be examined: the best one first, or, without a ``rank``, in the order of the domain.

    Iterating gives one after the other, ticks the budget for each, and ends when none waits or ``most`` were given. A loop that
    goes on has settled the cell, unless it put its pieces back with ``add``, in the order of the domain. LimitError out of the
    iteration when the time is over. ``rest`` holds all that is not settled, also the cell in which a loop was left.

    ``rank`` : of a cell, what is least for the one to be examined first. ``what`` : is done, for a progress bar.

    >>> waiting, settled = Waiting([(0, 8)]), []
    >>> for low, high in waiting:
    ...     if high - low > 3:
    ...         waiting.add((low, (low + high) // 2), ((low + high) // 2, high))
    ...     else:
    ...         settled.append((low, high))
    >>> settled
    [(0, 2), (2, 4), (4, 6), (6, 8)]
    """

    def __init__(
        self, cells: Iterable[C], rank: Callable[[C], Any] | None = None, *, most: int | None = None, what: str = ""
    ) -> None:
        self.examined = 0
        self._rank, self._most, self._what = rank, most, what
        self._heap: list[tuple[Any, int, C]] = []
        self._number = 0
        self._given: list[C] = []
        self.add(*cells)

    def add(self, *cells: C) -> None:
        """Let cells wait, in place of the one that was given last; of equal ranks the first comes first."""
        self._given = []
        for cell in cells if self._rank else reversed(cells):
            self._number += 1
            order = self._number if self._rank else -self._number
            heappush(self._heap, (self._rank(cell) if self._rank else 0, order, cell))

    def __iter__(self) -> Iterator[C]:
        while self._heap and (self._most is None or self.examined < self._most):
            tick(self.examined, self.examined + len(self._heap), self._what)
            self.examined += 1
            cell = heappop(self._heap)[-1]
            self._given = [cell]
            yield cell
            self._given = []

    @property
    def rest(self) -> list[C]:
        """All that are not settled, in no order."""
        return [*self._given, *(cell for _, _, cell in self._heap)]
