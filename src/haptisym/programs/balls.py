"""A program in ball arithmetic: enclosures of its results at single points, as tight as asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import flint
from flint import arb, fmpq

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.programs.program import Program


def power(x: Ball, exponent: Ball) -> Ball:
    """x^exponent for an exponent > 0; 0 at 0."""
    return arb(0) if x.is_zero() else (x.log() * exponent).exp()


def sincm1(x: Ball) -> Ball:
    """sin(x)/x - 1 with as many digits where x is small: between -x^2/6 and 0."""
    if x.contains(0):
        return arb(0).union(-(x * x).upper() / 6)
    mantissa, exponent = abs(x).mid().man_exp()
    lost = max(0, -2 * (int(exponent) + int(mantissa).bit_length()))
    with flint.ctx.workprec(flint.ctx.prec + lost):
        return x.sinc() - 1


FUNCTIONS: dict[str, Callable[..., Ball]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "neg": lambda x: -x,
    "abs": abs,
    "sqrt": lambda x: x.nonnegative_part().sqrt(),
    "cos": arb.cos,
    "sin": arb.sin,
    "sinc": arb.sinc,
    "sincm1": sincm1,
    "power": power,
}


def constant_ball(value: Any) -> Ball:
    """A ball around a constant of a program, at the current working precision."""
    return arb(value) if isinstance(value, fmpq) else expression_ball(value)


@lru_cache(maxsize=256)
def _constants(program: Program, bits: int) -> dict[int, Ball]:
    steps = enumerate(program.operations)
    return {i: constant_ball(step.value) for i, step in steps if step.name == "constant"}


@dataclass(frozen=True, eq=False)
class BallPoint:
    """The results of a program for inputs that are doubles, exactly what they are."""

    program: Program
    inputs: tuple[float, ...]

    def balls(self, bits: int) -> dict[str, Ball]:
        """Balls around all results, computed with that many bits."""
        with flint.ctx.workprec(bits):
            known: dict[int, Ball] = dict(_constants(self.program, bits))
            for i, step in enumerate(self.program.operations):
                if step.name == "input":
                    known[i] = arb(self.inputs[step.arguments[0]])
                elif step.name != "constant":
                    known[i] = FUNCTIONS[step.name](*(known[x] for x in step.arguments))
            return {name: known[x] for name, x in self.program.results.items()}


def nearest_double(ball: Ball, bits: int) -> float | None:
    """The double nearest to a number in a narrow ball, where one is nearest to all of them; a neighbour at a tie.

    >>> nearest_double(arb("0.1"), 53), nearest_double(arb("0.1", "1e-3"), 53)
    (0.1, None)
    """
    if not ball.is_finite():
        return None
    with flint.ctx.workprec(bits + 64):
        low, high = float(ball.lower()), float(ball.upper())
    tie = ball.rel_accuracy_bits() > 200 and bits > 400  # two neighbours, the ball a dot half-way between them
    return low if low == high or tie else None
