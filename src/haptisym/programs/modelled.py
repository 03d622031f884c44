"""A program in Taylor models: proven bounds on its results and their slopes, over many boxes of inputs at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import flint

from haptisym.kernel.budget import tick
from haptisym.programs.balls import FUNCTIONS, constant_ball
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Model

ModelOrFloat: TypeAlias = Model | float
"""Numbers that are the same everywhere stay floats, to within some roundings."""


def _sum(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    if isinstance(x, Model):
        return x + y if isinstance(y, Model) else x.plus(y)
    assert isinstance(y, Model)
    return y.plus(x)


def _product(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    if isinstance(x, Model):
        return x * y if isinstance(y, Model) else x.times(y)
    assert isinstance(y, Model)
    return y.times(x)


def _quotient(x: ModelOrFloat, y: ModelOrFloat) -> ModelOrFloat:
    one = x if isinstance(x, Model) else y
    assert isinstance(one, Model)
    upper, lower = (v if isinstance(v, Model) else one.number(v) for v in (x, y))
    return upper / lower


OPERATIONS: dict[str, Callable[..., ModelOrFloat]] = {
    "add": _sum,
    "sub": lambda x, y: _sum(x, -y),
    "mul": _product,
    "div": _quotient,
    "neg": lambda x: -x,
    "cos": lambda x: x.cosine_and_sine()[0],
    "sin": lambda x: x.cosine_and_sine()[1],
    "sinc": Model.sinc,
    "sincm1": Model.sincm1,
    "power": lambda x, order: x.to_the(order if isinstance(order, Model) else x.number(order)),
}


@dataclass(frozen=True, eq=False)
class Modelled:
    """A program without ``abs`` and ``sqrt``, whose slopes jump."""

    program: Program

    def run(self, inputs: Sequence[Model]) -> dict[str, ModelOrFloat]:
        """The results by name: for inputs in the order of the program's."""
        known: dict[int, ModelOrFloat] = dict(self._constants)
        for i, step in enumerate(self.program.operations):
            if step.name == "input":
                known[i] = inputs[step.arguments[0]]
            elif i not in known:
                tick()
                known[i] = OPERATIONS[step.name](*(known[x] for x in step.arguments))
        return {name: known[x] for name, x in self.program.results.items()}

    @cached_property
    def _constants(self) -> Mapping[int, float]:
        """The steps that depend on no input, to within a rounding."""
        balls: dict[int, Any] = {}
        with flint.ctx.workprec(200):
            for i, step in enumerate(self.program.operations):
                if step.name == "constant":
                    balls[i] = constant_ball(step.value)
                elif step.name != "input" and all(x in balls for x in step.arguments):
                    balls[i] = FUNCTIONS[step.name](*(balls[x] for x in step.arguments))
            return {i: float(x.mid()) for i, x in balls.items()}
