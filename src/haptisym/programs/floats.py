"""A program in floats: block by block, so that all that is computed stays in the cache, into buffers made once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
        flag: Any = "raise" if watched else "ignore"
        with np.errstate(divide="ignore", invalid="ignore", over=flag, under=flag):
            plan = self._plan(tuple([not isinstance(x, np.ndarray) for x in inputs]))
            known = plan.known.copy()
            for i, x in plan.numbers:
                known[i] = np.float64(inputs[x])
            for i, function, arguments in plan.single:
                known[i] = function(*[known[x] for x in arguments])
            buffers = [*np.empty((plan.buffers, min(size, BLOCK)))]
            if size <= BLOCK:
                self._block(plan, known, inputs, [*buffers, *out])
            else:
                for start in range(0, size, BLOCK):
                    part = slice(start, min(start + BLOCK, size))
                    held = [*(row[: part.stop - start] for row in buffers), *(x[part] for x in out)]
                    given = [x if np.ndim(x) == 0 else x[part] for x in inputs]
                    self._block(plan, known.copy(), given, held)
        for n, x, what, place in plan.others:
            out[n][...] = known[x] if what == "number" else inputs[place] if what == "input" else out[place]

    def _plan(self, numbers: tuple[bool, ...]) -> _Plan:
        """For inputs of which these are single numbers: made once, as it takes longer than a thousand frequencies."""
        if numbers not in self._plans:
            self._plans[numbers] = _plan(self.program, self.constants, numbers)
        return self._plans[numbers]

    @cached_property
    def _plans(self) -> dict[tuple[bool, ...], _Plan]:
        return {}

    @staticmethod
    def _block(plan: _Plan, known: list[Any], inputs: Sequence[Any], held: Sequence[Any]) -> None:
        for i, x in plan.inputs:
            known[i] = inputs[x]
        known += held
        for function, x, y, place in plan.steps:
            if y is None:
                function(known[x], known[place])
            else:
                function(known[x], known[y], known[place])


@dataclass(frozen=True)
class _Plan:
    """What is done, in order. ``known`` : the constants in their places, ``numbers`` and ``single`` : what is one number for all
    frequencies. ``steps`` : those that differ from frequency to frequency, with the places of their arguments and of what they
    make: behind the places of all operations stand so many ``buffers``, and then the results. ``others`` : results that are a
    number, an input, or another result.
    """

    known: list[Any]
    numbers: tuple[tuple[int, int], ...]
    single: tuple[tuple[int, Callable[..., Any], tuple[int, ...]], ...]
    inputs: tuple[tuple[int, int], ...]
    steps: tuple[tuple[Callable[..., Any], int, int | None, int], ...]
    buffers: int
    others: tuple[tuple[int, int, str, int], ...]


def _plan(program: Program, constants: Mapping[int, np.float64], are_numbers: Sequence[bool]) -> _Plan:
    operations, results = program.operations, tuple(program.results.values())
    known: list[Any] = [constants.get(i) for i in range(len(operations))]
    numbers: list[tuple[int, int]] = []
    inputs: list[tuple[int, int]] = []
    single, are_single = [], set(constants)
    for i, step in enumerate(operations):
        if step.name == "input":
            (numbers if are_numbers[step.arguments[0]] else inputs).append((i, step.arguments[0]))
            are_single |= {i} if are_numbers[step.arguments[0]] else set()
        elif step.name != "constant" and all(x in are_single for x in step.arguments):
            single.append((i, UFUNCS[step.name], step.arguments))
            are_single.add(i)
    moving = [(i, x) for i, x in enumerate(operations) if i not in are_single and x.name != "input"]
    put, count = _places(moving, operations, results)
    steps = []
    for i, step in moving:
        x, y = (put.get(a, a) for a in (*step.arguments, -1)[:2])
        steps.append((UFUNCS[step.name], x, None if y < 0 else y, put[i]))
    others = []
    for n, x in enumerate(results):
        if x in are_single:
            others.append((n, x, "number", 0))
        elif operations[x].name == "input":
            others.append((n, x, "input", operations[x].arguments[0]))
        elif results.index(x) < n:
            others.append((n, x, "result", results.index(x)))
    return _Plan(known, tuple(numbers), tuple(single), tuple(inputs), tuple(steps), count, tuple(others))


def _places(
    moving: Sequence[tuple[int, Operation]], operations: Sequence[Operation], results: tuple[int, ...]
) -> tuple[dict[int, int], int]:
    """Where each step is put: behind the places of all operations into as few buffers as will do, or into a result."""
    last = _last_uses(operations, results)
    direct = {x: n for n, x in reversed(list(enumerate(results)))}
    free: list[int] = []
    place: dict[int, int] = {}
    count = 0
    for i, step in moving:
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
    size = len(operations)
    return {x: size + (n if n >= 0 else count - 1 - n) for x, n in place.items()}, count


def _last_uses(operations: Sequence[Operation], results: Sequence[int]) -> dict[int, int]:
    last = {x: i for i, step in enumerate(operations) if step.name != "input" for x in step.arguments}
    return {**last, **dict.fromkeys(results, len(operations))}
