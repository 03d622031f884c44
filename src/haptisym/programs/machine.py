"""A program in floats as machine code, made by Numba: one pass over the frequencies, at the speed
of memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.util import find_spec
from typing import Any

from sympy import (
    Abs,
    Add,
    Expr,
    Float,
    Max,
    Min,
    Mul,
    Pow,
    Symbol,
    asin,
    cos,
    lambdify,
    sin,
    sinc,
    sqrt,
)

from haptisym.kernel.arrays import np
from haptisym.kernel.errors import SceneError
from haptisym.programs.floats import Floats, nearest
from haptisym.programs.program import LAST, SMALL, Operation, Program, sincm1

# Nothing is evaluated: SymPy would reorder sums and products, and the doubles would be others than
# those of ``Floats``.
_WRITTEN: dict[str, Callable[..., Expr]] = {
    "add": lambda x, y: Add(x, y, evaluate=False),
    "sub": lambda x, y: Add(x, Mul(-1, y, evaluate=False), evaluate=False),
    "mul": lambda x, y: Mul(x, y, evaluate=False),
    "div": lambda x, y: Mul(x, Pow(y, -1, evaluate=False), evaluate=False),
    "neg": lambda x: Mul(-1, x, evaluate=False),
    "abs": Abs,
    "sqrt": lambda x: sqrt(x, evaluate=False),
    "cos": cos,
    "sin": sin,
    "sinc": sinc,
    "sincm1": sincm1,
    "asin": asin,
    "max": lambda x, y: Max(x, y, evaluate=False),
    "min": lambda x, y: Min(x, y, evaluate=False),
    "power": lambda x, y: Pow(x, y, evaluate=False),
}


@dataclass(frozen=True, eq=False)
class Machine:
    """A program as machine code: each step rounded for itself, as NumPy does it, and no operation
    reordered.

    Where a program holds no sines, cosines or powers, the doubles are those of ``Floats``, bit for
    bit; those may differ by a few units in the last place between NumPy and the mathematical
    library that Numba calls. Machine code runs where the frequency alone is an array. Arrays of
    parameters are left to ``Floats``, and so are the steps of an encoder, of which that sums what
    does not depend on the frequency once, and not at each.
    Raises SceneError where Numba is not installed.
    """

    program: Program

    def __post_init__(self) -> None:
        if find_spec("numba") is None:
            raise SceneError(
                'engine: "numba" needs Numba, which is not installed: pip install "haptisym[fast]"'
            )

    @cached_property
    def in_numpy(self) -> Floats:
        """The same program as NumPy runs it."""
        return Floats(self.program)

    @cached_property
    def _has_steps(self) -> bool:
        """Whether a sum over the steps of an encoder is computed."""
        return any(step.name == "quantiser" for step in self.program.operations)

    def point(self, inputs: Sequence[float]) -> list[float]:
        """As ``Floats.point``."""
        return self.in_numpy.point(inputs)

    def run(
        self, inputs: Sequence[Any], size: int, out: Sequence[Any], *, watched: bool = False
    ) -> None:
        """As ``Floats.run``, which does what is ``watched``."""
        if watched:
            self.in_numpy.run(inputs, size, out, watched=True)
        else:
            self.fill(inputs, size, out)

    def fill(self, inputs: Sequence[Any], size: int, out: Sequence[Any]) -> None:
        """Fill the arrays ``out``, one for each result; an input is a float or an array of that
        size."""
        omega, *numbers = inputs
        if self._has_steps or not np.ndim(omega) or any(np.ndim(x) for x in numbers):
            self.in_numpy.run(inputs, size, out)
            return
        results = tuple(self.program.results.values())
        # Two rows in one pass: more would compete for the cache, and would need a general loop.
        for n in range(0, len(results), 2):
            _loop(self.program, results[n : n + 2])(omega, tuple(numbers), *out[n : n + 2])


@lru_cache(maxsize=64)
def _loop(program: Program, results: tuple[int, ...]) -> Any:
    """The pass over all frequencies that computes one result or two, compiled."""
    import numba

    # A function of its own loop: one that is given as an argument costs more than a thousand
    # frequencies at each call.
    step = _step(program, results)

    def one(omega: Any, numbers: Any, first: Any) -> None:
        for i in range(omega.size):
            (first[i],) = step(omega[i], *numbers)

    def two(omega: Any, numbers: Any, first: Any, second: Any) -> None:
        for i in range(omega.size):
            first[i], second[i] = step(omega[i], *numbers)

    # NumPy's divisions: a check for 0 would keep them one by one
    return numba.njit(one if len(results) == 1 else two, error_model="numpy")


def _step(program: Program, results: tuple[int, ...]) -> Any:
    """Some results at one frequency, compiled."""
    import numba

    def wave(x: float) -> float:
        return np.sin(x) / x if x != 0.0 else 1.0

    def less_one(x: float) -> float:
        if abs(x) > SMALL:
            return float(np.sin(x) / x - 1.0)
        # Terms of the series differ by the factor -x^2/(n (n - 1)): summed from the last to the
        # first.
        series = 0.0
        for n in range(LAST, 1, -2):
            series = -x * x / (n * (n - 1)) * (1.0 + series)
        return series

    names = [Symbol(f"x{i}") for i in range(len(program.operations))]
    arguments = [Symbol(f"given{i}") for i in range(len(program.inputs))]
    needed = program.needed(results)
    steps = [(names[i], _written(program.operations[i], names, arguments)) for i in needed]
    waves = {"sinc": wave, "sincm1": less_one}
    library = {name: numba.njit(f, error_model="numpy") for name, f in waves.items()}
    outputs = tuple(names[x] for x in results)
    # lambdify prints the steps as they are, in their order: they are the common subexpressions, and
    # there is no more
    source = lambdify(arguments, outputs, [library, "math"], cse=lambda _: (steps, outputs))
    return numba.njit(source, error_model="numpy")


def _written(step: Operation, names: Sequence[Symbol], arguments: Sequence[Symbol]) -> Expr:
    """The SymPy expression of a step in the names of its arguments, for ``lambdify`` to print."""
    if step.name == "input":
        return arguments[step.arguments[0]]
    if step.name == "constant":
        # 17 decimal digits give back every double exactly.
        return Float(float(nearest(step.value)), 17)
    return _WRITTEN[step.name](*(names[x] for x in step.arguments))
