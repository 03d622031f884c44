"""The excess r^2 - c^2 over cells of band and box, in Taylor models: proven bounds on it and on its slopes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from haptisym.judge.criteria import Criterion
from haptisym.kernel.errors import SceneError
from haptisym.model.jnd import Part
from haptisym.programs.modelled import Modelled
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Array, Model, variable
from haptisym.programs.valued import floated
from haptisym.verbs.tolerances.box import Box

_BENT = 7  # sides: with more of them the curvature of all slopes costs more than the cells that it spares


class Excess:
    """r^2 - c^2 of a criterion of one part, for every frequency of the band and every set of values of the box.

    ``model`` takes cells, an array (cells, sides, 2): for omega, then for each side of the box, from which share of its way to
    which, 0 the low end and 1 the high end.
    """

    def __init__(self, box: Box, criterion: Criterion) -> None:
        part = criterion.part
        if part is None:
            raise SceneError(f"{criterion.words}: tolerances are told of criteria of one part alone")
        self._over(box)
        chain, exchanged = box.scene.chain.at(self._fixed).without_axis_zeros()
        seen = part if not exchanged else Part.IMAG if part is Part.REAL else Part.REAL
        self._name = f"squared_{seen.value}"
        self._program = chain.program([self._name])
        self._inputs = self._places(self._program)
        c = box.part_name(part)
        self._limit = 1 + self._names.index(c) if c in self._names else None
        self._c = floated(criterion.threshold)

    def _over(self, box: Box) -> None:
        """What varies, and within which ends."""
        self._names = [side.name for side in box.sides]
        self._fixed = {p.symbol: p.value for p in box.scene.parameters if p.symbol.name not in self._names}
        ends = [box.scene.band, *((side.low, side.high) for side in box.sides)]
        self._intervals = [(floated(low), floated(high - low)) for low, high in ends]
        self.sides = len(ends)
        self.order = 2 if self.sides <= _BENT else 1

    def _places(self, program: Program) -> list[int]:
        """Of each input of a program the number of its side, omega being that of 0."""
        return [0, *(1 + self._names.index(x.name) for x in program.inputs[1:])]

    @cached_property
    def is_zero(self) -> bool:
        """Whether r is 0 everywhere."""
        return bool(self._program.operations[self._program.results[self._name]].value == 0)

    def model(self, cells: Array, *, slopes: int | None = None) -> Model:
        """The excess over each cell; t_i goes from -1 to 1 along its side i. Unknown where a pole may lie in the cell.

        ``slopes`` : of which order; none if 0, and whatever suits so many sides if not said.
        """
        slopes = self.order if slopes is None else slopes
        with np.errstate(all="ignore"):  # what is not finite is unknown, which every caller asks about
            inputs = [self._variable(i, cells, slopes=slopes) for i in self._inputs]
            square = self._square(inputs)
            c = inputs[0].number(self._c) if self._limit is None else self._variable(self._limit, cells, slopes=slopes)
            minus = -(c * c)
            return minus + square if isinstance(square, Model) else minus.plus(square)

    def _square(self, inputs: Sequence[Model]) -> Model | float:
        return Modelled(self._program).run(inputs)[self._name]

    @cached_property
    def matters(self) -> Array:
        """For omega and each side, whether the excess depends on it."""
        limit = np.array([i == self._limit for i in range(self.sides)])
        return limit | self._used(self._program)

    def _used(self, program: Program) -> Array:
        """For omega and each side, whether the results of a program depend on it; of omega it is said anyway."""
        steps = [program.operations[i] for i in program.needed(program.results.values())]
        used = {step.arguments[0] for step in steps if step.name == "input"}
        inputs = self._places(program)
        places = {0, *(inputs[i] for i in used)}
        return np.array([i in places for i in range(self.sides)])

    def _variable(self, i: int, cells: Array, *, slopes: int) -> Model:
        (low, width), (start, end) = self._intervals[i], cells[:, i].T
        middle, radius = low + width * (start + end) / 2, width * (end - start) / 2
        size = abs(low) + width * np.maximum(np.abs(start), np.abs(end))
        return variable(middle, radius, size, i, self.sides, slopes=slopes)


class LargerExcess(Excess):
    """|G - 1|^2 - c^2 of a criterion of one part, for effects in series: r is never larger, whatever the environment."""

    def __init__(self, box: Box, criterion: Criterion) -> None:
        super().__init__(box, criterion)
        self._program = box.scene.chain.at(self._fixed).program(_RELATIVE)
        self._inputs = self._places(self._program)

    def _square(self, inputs: Sequence[Model]) -> Model:
        found = Modelled(self._program).run(inputs)
        x, y = (v if isinstance(v, Model) else inputs[0].number(v) for v in (found[name] for name in _RELATIVE))
        return x * x + y * y


_RELATIVE = ("relative_real", "relative_imag")
