"""The stable straight-line program of a distortion as steps that can be printed as code."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from itertools import count
from types import MappingProxyType

from sympy import Abs, Expr, Pow, Rational, Symbol, cos, sin, sinc, sqrt

from haptisym.programs.program import Operation, Program, sincm1
from haptisym.verbs.derive.steps import Steps

_MADE: Mapping[str, Callable[..., Expr]] = MappingProxyType(
    {
        "add": lambda x, y: x + y,
        "sub": lambda x, y: x - y,
        "mul": lambda x, y: x * y,
        "div": lambda x, y: x / y,
        "neg": lambda x: -x,
        "power": Pow,
        "abs": Abs,
        "sqrt": sqrt,
        "cos": cos,
        "sin": sin,
        "sinc": sinc,
        "sincm1": sincm1,
    }
)


def program_steps(program: Program) -> Steps:
    """The program, with a name for what is used twice, and for each sum that is a factor: SymPy would multiply it out.

    >>> from haptisym.programs.program import Writer
    >>> a, b = Symbol("a"), Symbol("b")
    >>> write = Writer((a, b))
    >>> difference = write.sub(write.input(a), write.input(b))
    >>> steps = program_steps(write.program({"y": write.mul(write.constant(3), difference)}))
    >>> steps.definitions, steps.results
    (((x0, a - b),), {'y': 3*x0})
    """
    taken = {x.name for x in program.inputs}
    names = (Symbol(name, real=True) for n in count() if (name := f"x{n}") not in taken)
    named = _named(program)
    values: list[Expr] = []
    definitions: list[tuple[Symbol, Expr]] = []
    for n, step in enumerate(program.operations):
        value = _value(program, step, values)
        if n in named:
            definitions.append((next(names), value))
            value = definitions[-1][0]
        values.append(value)
    return Steps(tuple(definitions), {name: values[n] for name, n in program.results.items()})


def _value(program: Program, step: Operation, values: list[Expr]) -> Expr:
    if step.name == "input":
        return program.inputs[step.arguments[0]]
    if step.name == "constant":
        return step.value if isinstance(step.value, Expr) else Rational(int(step.value.p), int(step.value.q))
    return _MADE[step.name](*(values[n] for n in step.arguments))


def _named(program: Program) -> set[int]:
    """The steps that get a name."""
    uses: Counter[int] = Counter(program.results.values())
    factors: set[int] = set()
    for step in program.operations:
        if step.name != "input":
            uses.update(step.arguments)
            factors.update(step.arguments if step.name not in ("add", "sub") else ())
    plain = ("input", "constant")
    return {
        n
        for n, step in enumerate(program.operations)
        if step.name not in plain and (uses[n] > 1 or (n in factors and step.name in ("add", "sub")))
    }
