"""Functions of omega and parameters, all in shares of their ranges, in the place of an excess over band and box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from haptisym.programs.taylormodels import Model, constant, variable


@dataclass(frozen=True)
class Form:
    """Such a function: ``idle`` sides change nothing, of an ``unknown`` piece of the band nothing is told."""

    of: Callable[..., Model]
    parameters: int
    idle: tuple[int, ...] = ()
    unknown: tuple[float, float] | None = None
    is_zero: bool = False
    asked: list[Any] = field(default_factory=list)

    @property
    def sides(self) -> int:
        return 1 + self.parameters

    @property
    def matters(self) -> Any:
        return np.array([i not in self.idle for i in range(self.sides)])

    def model(self, cells: Any, *, slopes: int = 2) -> Model:
        self.asked.append(cells)
        middle, radius = cells.mean(-1), (cells[..., 1] - cells[..., 0]) / 2
        x = [variable(middle[:, i], radius[:, i], 1.0, i, self.sides) for i in range(self.sides)]
        found = self.of(*x, lambda c: constant(c, len(cells), self.sides))
        if self.unknown:
            low, high = self.unknown
            found.r[(cells[:, 0, 0] < high) & (cells[:, 0, 1] > low)] = np.inf
        return found
