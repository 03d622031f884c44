"""How large and how small the steps of a program can get: where floats can neither overflow nor lose digits to underflow."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import frexp, inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from haptisym.programs.floats import nearest
from haptisym.programs.program import Program

_MIN, _MAX = np.minimum.reduce, np.maximum.reduce
_SINE = 70.0  # no cosine, and no sine of a double of at least 2^-69, is smaller than 2^-70


class MagnitudeRange(NamedTuple):
    """What is known of a step at all frequencies: 2^low <= abs(x) <= 2^high where it is not 0; if it is >= 0; if never 0."""

    low: float
    high: float
    positive: bool = False
    nonzero: bool = False


class Judgement(NamedTuple):
    """``safe`` : no step over- or underflows; ``finite`` : nor is there a division by 0, so that all results are finite."""

    safe: bool
    finite: bool


def judge(program: Program, inputs: Sequence[Any], digits: int, limit: int) -> Judgement:
    """Whether every step that is not 0 stays between 2^-limit and 2^limit, in arithmetic with that many binary digits.

    >>> from sympy import Symbol
    >>> from haptisym.programs.program import Writer
    >>> x = Symbol("x")
    >>> write = Writer((x,))
    >>> program = write.program({"y": write.div(write.constant(1), write.power(write.input(x), 3))})
    >>> judge(program, [1e100], 53, 1020)
    Judgement(safe=True, finite=True)
    >>> judge(program, [np.array([0.0, 1.0])], 53, 1020), judge(program, [1e-110], 53, 1020).safe
    (Judgement(safe=True, finite=False), False)
    """
    return judged(program, ranges(inputs), digits, limit)


def ranges(inputs: Sequence[Any]) -> tuple[MagnitudeRange, ...]:
    """Of inputs, in powers of two, so that others of about the same size have the same ones."""
    return tuple(_of_array(np.asarray(x)) for x in inputs)


def judged(program: Program, inputs: Sequence[MagnitudeRange], digits: int, limit: int) -> Judgement:
    """The same for inputs in these ranges."""
    known: list[MagnitudeRange] = []
    finite = True
    for step in program.operations:
        if step.name == "input":
            known.append(inputs[step.arguments[0]])
        elif step.name == "constant":
            known.append(_of_number(float(nearest(step.value))))
        else:
            known.append(_step(step.name, step.arguments, [known[x] for x in step.arguments], digits))
            finite = finite and (step.name != "div" or known[step.arguments[1]].nonzero)
        if not (known[-1].low > -limit and known[-1].high < limit):
            return Judgement(safe=False, finite=False)
    return Judgement(safe=True, finite=finite)


@lru_cache(maxsize=1024)
def _of_number(x: float) -> MagnitudeRange:
    return _of_array(np.asarray(x))


def _of_array(x: Any) -> MagnitudeRange:
    """The range of given numbers; where all are 0, that of 1."""
    least, most = (float(_MIN(x, None)), float(_MAX(x, None))) if x.size else (inf, -inf)
    low, high = least if least > 0 else float(np.min(np.abs(x), where=x != 0, initial=inf)), max(most, -least)
    if not isfinite(high) and x.size:
        return MagnitudeRange(-inf, inf)
    if low == inf:
        return MagnitudeRange(0.0, 0.0, positive=True)
    return MagnitudeRange(frexp(low)[1] - 1.0, float(frexp(high)[1]), least >= 0, least > 0 or most < 0)


def _step(name: str, arguments: Sequence[int], of: Sequence[MagnitudeRange], digits: int) -> MagnitudeRange:
    x = of[0]
    if name in ("neg", "abs"):
        return x._replace(positive=name == "abs")
    if name == "sqrt":
        return MagnitudeRange(x.low / 2 - 1, x.high / 2 + 1, positive=True, nonzero=x.nonzero)
    if name in ("sin", "cos", "sinc"):
        least = {"sin": min(-_SINE, x.low - 1), "cos": -_SINE, "sinc": -_SINE - max(x.high, 0.0)}[name]
        return MagnitudeRange(least, 0.0)
    if name == "sincm1":  # between -x^2/6 and -x^2/8 for abs(x) <= 2, between -5/4 and -1/2 beyond
        return MagnitudeRange(min(2 * x.low - 3, -1.0), min(2 * x.high - 2, 1.0), nonzero=x.nonzero)
    y = of[1]
    both = x.nonzero and y.nonzero
    if name == "mul":
        return MagnitudeRange(
            x.low + y.low, x.high + y.high, (x.positive and y.positive) or arguments[0] == arguments[1], both
        )
    if name == "div":
        return MagnitudeRange(x.low - y.high - 1, x.high - y.low + 1, x.positive and y.positive, x.nonzero)
    if name == "power":  # of an exponent between 0 and 1
        return MagnitudeRange(min(x.low, 0.0), max(x.high, 0.0), positive=True, nonzero=x.nonzero)
    if name == "add" and x.positive and y.positive:
        return MagnitudeRange(min(x.low, y.low), max(x.high, y.high) + 1, positive=True, nonzero=x.nonzero or y.nonzero)
    return MagnitudeRange(min(x.low, y.low) - digits - 1, max(x.high, y.high) + 1)
