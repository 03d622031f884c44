"""A program in floats: block by block, so that all that is computed stays in the cache, into buffers made once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import fmpq

from haptisym.kernel.reals import ExactNumber
from haptisym.programs.program import Operation, Program
from haptisym.programs.sinc import sinc, sincm1

BLOCK = 8192


UFUNCS: dict[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "cos": np.cos,
    "sin": np.sin,
    "sinc": sinc,
    "sincm1": sincm1,
    "power": np.power,
}
_SELDOM = frozenset({"sinc", "sincm1"})


def nearest(value: Any) -> np.float64:
    """The double nearest to an exact constant of a program."""
    if isinstance(value, fmpq):
        try:
            return np.float64(int(value.p) / int(value.q))
        except OverflowError:
            return np.float64(np.inf if value > 0 else -np.inf)
    return np.float64(float(ExactNumber(value)))


@dataclass(frozen=True)
class Floats:
    """A program in floats, for inputs of which some are single numbers."""

    program: Program

    @cached_property
    def constants(self) -> dict[int, np.float64]:
        """The program's constants, each rounded once."""
        steps = enumerate(self.program.operations)
        return {i: nearest(step.value) for i, step in steps if step.name == "constant"}

    def run(self, inputs: Sequence[Any], size: int, out: Sequence[Any], *, watched: bool = False) -> None:
        """Fill the arrays ``out``, one for each result; an input is a float or an array of that size.

        ``watched`` : FloatingPointError where the processor says that a step overflowed, or lost digits to underflow.
        """
        results = tuple(self.program.results.values())
        flag: Any = "raise" if watched else "ignore"
        with np.errstate(divide="ignore", invalid="ignore", over=flag, under=flag):
            single = self._single(inputs)
            plan = _plan(self.program, frozenset(single), results)
            buffers = np.empty((plan.buffers, BLOCK))
            for start in range(0, size, BLOCK):
                self._block(plan, single, inputs, out, buffers, slice(start, min(start + BLOCK, size)))
        for n, x in enumerate(results):
            if x in single:
                out[n][...] = single[x]
            elif self.program.operations[x].name == "input":
                out[n][...] = inputs[self.program.operations[x].arguments[0]]
            elif results.index(x) < n:
                out[n][...] = out[results.index(x)]

    def _single(self, inputs: Sequence[Any]) -> dict[int, np.float64]:
        """The steps that are one number for all frequencies."""
        found = dict(self.constants)
        for i, step in enumerate(self.program.operations):
            if step.name == "input":
                given = inputs[step.arguments[0]]
                if np.ndim(given) == 0:
                    found[i] = np.float64(given)
            elif step.name != "constant" and all(x in found for x in step.arguments):
                found[i] = UFUNCS[step.name](*(found[x] for x in step.arguments))
        return found

    def _block(self, plan: _Plan, single: Any, inputs: Any, out: Any, buffers: Any, part: slice) -> None:
        size = part.stop - part.start
        held: list[Any] = [*(row[:size] for row in buffers), *(x[part] for x in out)]
        known: list[Any] = [None] * len(self.program.operations)
        for i, value in single.items():
            known[i] = value
        for i, x in plan.inputs:
            known[i] = inputs[x][part]
        for i, function, (x, *y), place in plan.steps:
            known[i] = function(known[x], known[y[0]], held[place]) if y else function(known[x], held[place])


@dataclass(frozen=True)
class _Plan:
    """The steps that differ from frequency to frequency, and the buffer of each; buffers beyond ``buffers`` are the results."""

    inputs: tuple[tuple[int, int], ...]
    steps: tuple[tuple[int, Callable[..., Any], tuple[int, ...], int], ...]
    buffers: int


def _plan(program: Program, single: frozenset[int], results: tuple[int, ...]) -> _Plan:
    last = _last_uses(program.operations, results)
    steps, inputs, free, count = [], [], [], 0
    place: dict[int, int] = {}
    direct = {x: n for n, x in reversed(list(enumerate(results)))}
    for i, step in enumerate(program.operations):
        if i in single:
            continue
        if step.name == "input":
            inputs.append((i, step.arguments[0]))
            continue
        ended = {x for x in step.arguments if last.get(x) == i and x in place and x not in direct}
        if step.name not in _SELDOM:  # these read their argument again after they have begun to write
            free += [place[x] for x in ended]
        if i in direct:
            place[i] = -1 - direct[i]
        else:
            if not free:
                free, count = [count], count + 1
            place[i] = free.pop()
        if step.name in _SELDOM:
            free += [place[x] for x in ended]
        steps.append((i, UFUNCS[step.name], step.arguments, place[i]))
    placed = [(i, f, arguments, x if x >= 0 else count - 1 - x) for i, f, arguments, x in steps]
    return _Plan(tuple(inputs), tuple(placed), count)


def _last_uses(operations: Sequence[Operation], results: Sequence[int]) -> dict[int, int]:
    last = {x: i for i, step in enumerate(operations) if step.name != "input" for x in step.arguments}
    return {**last, **dict.fromkeys(results, len(operations))}
