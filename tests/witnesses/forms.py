"""Functions of omega and parameters, all in shares of their ranges, in the place of an excess over band and box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from haptisym.programs.taylormodels import Model, constant, variable


@dataclass(frozen=True)
class Form:
    """A function of omega and parameters, all in shares of their ranges, in the place of an excess."""

    of: Callable[..., Model]
    parameters: int
    is_zero: bool = False
    asked: list[Any] = field(default_factory=list)

    @property
    def sides(self) -> int:
        return 1 + self.parameters

    @property
    def matters(self) -> Any:
        return np.ones(self.sides, bool)

    def model(self, cells: Any, *, slopes: int = 2) -> Model:
        self.asked.append(cells)
        middle, radius = cells.mean(-1), (cells[..., 1] - cells[..., 0]) / 2
        x = [variable(middle[:, i], radius[:, i], 1.0, i, self.sides) for i in range(self.sides)]
        return self.of(*x, lambda c: constant(c, len(cells), self.sides))
