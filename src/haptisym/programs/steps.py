"""A straight-line program in named steps: what pages show and code computes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Set
from dataclasses import dataclass, field
from itertools import count
from types import MappingProxyType

from sympy import (
    Abs,
    Add,
    Expr,
    Mul,
    Pow,
    Rational,
    Symbol,
    cos,
    count_ops,
    default_sort_key,
    factor_terms,
    sin,
    sinc,
    sqrt,
)

from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import Shown, counted
from haptisym.programs.program import Operation, Program, sincm1


@dataclass(frozen=True, repr=False)
class Steps(Shown):
    """A straight-line computation: definitions in order, then named results.

    ``definitions`` : pairs of a name and its value, an expression in the arguments and in earlier names.
    ``results`` : named expressions in the arguments and in the defined names.
    Raises SceneError where a name is defined twice, or used before its definition.

    >>> from sympy import symbols
    >>> W, k, m, omega = symbols("W k m omega")
    >>> Steps(((W, omega**2),), {"real": k - m * W}).free_symbols == {k, m, omega}
    True
    """

    definitions: tuple[tuple[Symbol, Expr], ...]
    results: Mapping[str, Expr]

    def _line(self) -> str:
        return f"{', '.join(self.results)} in {counted(len(self.definitions), 'definition')}"

    def __post_init__(self) -> None:
        names = [name for name, _ in self.definitions]
        for i, (name, value) in enumerate(self.definitions):
            if name in names[:i]:
                raise SceneError(f"{name} is defined twice")
            early = value.free_symbols & set(names[i:])
            if early:
                raise SceneError(f"{name} = {value} uses {min(map(str, early))} before its definition")

    def only(self, names: Iterable[str]) -> Steps:
        """Some of the results, and the definitions that they need, but those that are one result and nothing else."""
        results = {name: self.results[name] for name in names}
        uses = Counter(x for e in results.values() for x in e.free_symbols)
        kept: dict[Symbol, Expr] = {}
        for name, value in reversed(self.definitions):
            own = [key for key, result in results.items() if result == name]
            if len(own) == uses[name] == 1:
                results[own[0]] = value
            elif uses[name]:
                kept[name] = value
            uses.update(value.free_symbols if uses[name] else ())
        return Steps(tuple(reversed(kept.items())), results)

    def _values(self) -> list[Expr]:
        return [*(value for _, value in self.definitions), *self.results.values()]

    @property
    def free_symbols(self) -> frozenset[Symbol]:
        """What the computation needs to be given."""
        used = {x for e in self._values() for x in e.free_symbols}
        return frozenset(used - {name for name, _ in self.definitions})

    @property
    def operations(self) -> int:
        """The number of arithmetic operations and function calls, each definition counted once; those within numbers are none.

        >>> from sympy import cos, symbols
        >>> a, b = symbols("a b")
        >>> Steps((), {"y": (a + b) * cos(a + b)}).operations
        4
        """
        return sum(int(count_ops(map_numbers(e, _constant))) for e in self._values())

    def at(self, values: Mapping[Symbol, Expr]) -> dict[str, Expr]:
        """The results for given values of the arguments (exact for exact values), computed definition by definition.

        >>> from sympy import Integer, symbols
        >>> a, b = symbols("a b")
        >>> Steps(((c := Symbol("c"), a + b),), {"y": c**2 + 1 / c}).at({a: Integer(1), b: Integer(2)})
        {'y': 28/3}
        """
        known: dict[Symbol, Expr] = dict(values)
        for name, value in self.definitions:
            known[name] = value.xreplace(known)
        return {name: value.xreplace(known) for name, value in self.results.items()}


DISTORTION = ("real", "imag", "ratio_real", "ratio_imag", "relative_real", "relative_imag")
"""Of the fields of ``numeric.Values`` those that tell of the distortion itself."""
_CODE: Mapping[str, Callable[..., Expr]] = MappingProxyType(
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


def code_steps(program: Program) -> Steps:
    """A program with its labels as names, a name for whatever else is used twice, and one for each sum that is a factor.

    SymPy would multiply the latter out.

    >>> from haptisym.programs.program import Writer
    >>> a, b = Symbol("a"), Symbol("b")
    >>> write = Writer((a, b))
    >>> difference = write.sub(write.input(a), write.input(b))
    >>> steps = code_steps(write.program({"y": write.mul(write.constant(3), difference)}))
    >>> steps.definitions, steps.results
    (((x0, a - b),), {'y': 3*x0})
    """
    factors: set[int] = set()
    for step in program.operations:
        factors.update(step.arguments if step.name not in ("input", "add", "sub") else ())
    sums = {n for n in factors if program.operations[n].name in ("add", "sub")}
    return _Reader(program, sums).steps()


def page_steps(program: Program) -> Steps:
    """The same for a person: in whole angles where that is shorter, and what has no label and is short has no name.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> from haptisym.kernel.symbols import symbols
    >>> m, b, k, omega_c = symbols("m b k omega_c")
    >>> chain = distort(environments.mass_spring_damper(m, b, k), effects.first_order_lag(omega_c)).chain
    >>> steps = page_steps(chain.program(["real", "imag"]))
    >>> for name, value in steps.definitions:
    ...     print(name, "=", value)
    R = k - m*omega**2
    X = b*omega
    M = omega**2 + omega_c**2
    L = -omega*omega_c
    E = -L*X - R*omega**2
    F = L*R - X*omega**2
    >>> steps.results["imag"]
    F/M
    """
    return _PageReader(program).steps()


@dataclass
class _Reader:
    """Reads a program once; ``always`` : the steps that get a name in any case."""

    program: Program
    always: Set[int] = frozenset()
    values: list[Expr] = field(default_factory=list)
    definitions: dict[Symbol, Expr] = field(default_factory=dict)
    named: dict[Operation, Expr] = field(default_factory=dict)

    made = _CODE
    least = 1
    """Operations of what is used twice and gets a name without a label."""

    def steps(self) -> Steps:
        uses, all_uses = _uses(self.program), _uses(self.program, self.program.results.values())
        for n, step in enumerate(self.program.operations):
            value, label = self.value(step), self.program.labels.get(n, "") if uses[n] else ""
            if n in self.always or label or (all_uses[n] > 1 and step.name not in ("input", "constant", "neg")):
                value = self.written(value)
                if n in self.always or label or count_ops(value) >= self.least:
                    value = self.name(step, value, label)
            self.values.append(value)
        results = {x: self.written(self.values[n]) for x, n in self.program.results.items()}
        return Steps(tuple(self.definitions.items()), results)

    def written(self, value: Expr) -> Expr:
        return value

    def value(self, step: Operation) -> Expr:
        if step.name == "input":
            return self.program.inputs[step.arguments[0]]
        if step.name == "constant":
            given = step.value
            return given if isinstance(given, Expr) else Rational(int(given.p), int(given.q))
        if step.name == "sub" and (opposite := Operation("sub", step.arguments[::-1])) in self.named:
            return -self.named[opposite]
        return self.made[step.name](*(self.values[n] for n in step.arguments))

    def name(self, step: Operation, value: Expr, label: str) -> Expr:
        """A symbol for a value, unless it is one already, or the negative of one."""
        if (-value if value.could_extract_minus_sign() else value).is_Symbol:
            return value
        sign, stem = (-1, label[1:]) if label.startswith("-") else (1, label)
        taken = {x.name for x in (*self.program.inputs, *self.definitions)} | {"c"}
        names = (f"{stem}{'x' * n}" if stem else f"x{n}" for n in count())
        symbol = Symbol(next(x for x in names if x not in taken), real=True)
        self.definitions[symbol] = sign * value
        self.named[step] = sign * symbol
        return sign * symbol


class _PageReader(_Reader):
    made = MappingProxyType({**_CODE, "sinc": lambda x: sin(x) / x, "sincm1": lambda x: sin(x) / x - 1})
    least = 7

    def written(self, value: Expr) -> Expr:
        return _whole_angles(value)


def _uses(program: Program, results: Iterable[int] = ()) -> Counter[int]:
    """How often each step is used, by others and as these results; a negative's uses are those of the step itself."""
    uses = Counter(results)
    for n in reversed(range(len(program.operations))):
        step = program.operations[n]
        for x in step.arguments if step.name != "input" else ():
            uses[x] += uses[n] if step.name == "neg" else 1
    return uses


def _whole_angles(value: Expr) -> Expr:
    """The same with cos x for cos(x/2)^2 - sin(x/2)^2 and the like, if that is shorter."""
    angles = sorted({x.args[0] for x in value.atoms(cos, sin)}, key=default_sort_key)
    if not angles:
        return value
    found = value.expand()
    for angle in angles:
        both, wave = cos(angle) * sin(angle), cos(2 * angle)
        found = found.replace(
            lambda x, both=both: x.is_Mul and {*both.args} <= {*x.args},
            lambda x, both=both, angle=angle: x / both * sin(2 * angle) / 2,
        ).xreplace({cos(angle) ** 2: (1 + wave) / 2, sin(angle) ** 2: (1 - wave) / 2})
    others = map(factor_terms, (found, found.expand()))
    return min(value, *(x.func(*x.args) if x.args else x for x in others), key=count_ops)


def map_numbers(expression: Expr, change: Callable[[Expr], Expr]) -> Expr:
    """The expression with another one for each number in it; numbers that stand together are one, exponents are left.

    >>> from sympy import pi, sqrt, symbols
    >>> x, two = symbols("x two")
    >>> map_numbers(2 * pi * sqrt(x) + 2, lambda number: two)
    two*sqrt(x) + two
    """
    if expression.is_number:
        return change(expression)
    if isinstance(expression, Add | Mul):
        numbers = [x for x in expression.args if x.is_number]
        others = [map_numbers(x, change) for x in expression.args if not x.is_number]
        return expression.func(*([change(expression.func(*numbers))] if numbers else []), *others)
    if isinstance(expression, Pow) and expression.exp.is_number:
        return map_numbers(expression.base, change) ** expression.exp
    return expression.func(*(map_numbers(x, change) for x in expression.args)) if expression.args else expression


def _constant(number: Expr) -> Expr:
    return number if number.is_Integer else Symbol("number")
