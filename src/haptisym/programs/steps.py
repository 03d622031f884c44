"""A straight-line program as named steps: the intermediate steps that pages print and that
generated code computes.

``page_steps`` turns a program into ``Steps``, SymPy expressions by name. Generated code subclasses
``Reader`` for expressions of its own kind. Steps with a label have it as their name in both.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import count
from types import MappingProxyType
from typing import Any, Generic, TypeVar

from sympy import (
    Abs,
    Expr,
    Function,
    Max,
    Min,
    Pow,
    Rational,
    Symbol,
    acos,
    asin,
    cos,
    count_ops,
    default_sort_key,
    factor_terms,
    pi,
    sin,
    sqrt,
)

from haptisym.kernel.harmonics import quantiser
from haptisym.kernel.objects import Shown, counted
from haptisym.programs.program import Operation, Program


@dataclass(frozen=True, repr=False)
class Steps(Shown):
    """A straight-line computation: definitions in order, then named results.

    ``definitions`` : pairs of a name and its value, an expression in the arguments and in earlier
    names.
    ``results`` : named expressions in the arguments and in the defined names.

    >>> from sympy import symbols
    >>> W, k, m, omega = symbols("W k m omega")
    >>> Steps(((W, omega**2),), {"real": k - m * W}).free_symbols == {k, m, omega}
    True
    """

    definitions: tuple[tuple[Symbol, Expr], ...]
    results: Mapping[str, Expr]

    def _line(self) -> str:
        return f"{', '.join(self.results)} in {counted(len(self.definitions), 'definition')}"

    def only(self, names: Iterable[str]) -> Steps:
        """Some of the results, and the definitions that they need; a definition that is one result
        and is used nowhere else is written as the result."""
        results = {name: self.results[name] for name in names}
        uses = Counter(x for e in results.values() for x in e.free_symbols)
        needed: dict[Symbol, Expr] = {}
        # Backward, as a definition is needed if a later one that is needed itself uses it.
        for name, value in reversed(self.definitions):
            equal_results = [key for key, result in results.items() if result == name]
            if len(equal_results) == uses[name] == 1:
                results[equal_results[0]] = value
            elif uses[name]:
                needed[name] = value
            uses.update(value.free_symbols if uses[name] else ())
        return Steps(tuple(reversed(needed.items())), results)

    @property
    def named(self) -> dict[str, Expr]:
        """All steps and results by their names, in order."""
        return {**{x.name: value for x, value in self.definitions}, **self.results}

    def _values(self) -> list[Expr]:
        return [*self.named.values()]

    @property
    def free_symbols(self) -> frozenset[Symbol]:
        """The symbols that the computation needs values for: all but those that it defines."""
        used = {x for e in self._values() for x in e.free_symbols}
        return frozenset(used - {name for name, _ in self.definitions})

    @property
    def operations(self) -> int:
        """The number of arithmetic operations and function calls, each definition counted once;
        those within numbers are none.

        >>> from sympy import cos, symbols
        >>> a, b = symbols("a b")
        >>> Steps((), {"y": (a + b) * cos(a + b)}).operations
        4
        """
        # SymPy counts the number 3/7 as a division.
        numbers = {
            x: _FRACTION
            for e in self._values()
            for x in e.atoms(Rational)
            if x.q != 1 and abs(x.p) != 1
        }
        return sum(int(count_ops(e.xreplace(numbers))) for e in self._values())

    def at(self, values: Mapping[Symbol, Expr]) -> dict[str, Expr]:
        """The results for given values of the arguments (exact for exact values), computed
        definition by definition.

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
"""The fields of ``programs.values.Values`` that describe the distortion itself."""


def page_steps(program: Program) -> Steps:
    """The steps of a program as a page prints them: labelled steps have their labels as names, long
    repeated ones x0, x1, ...; half angles are joined where that is shorter.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.distortion import distort
    >>> from haptisym.kernel.rings import symbols
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
    reader = _PageReader(program, {"c", *(x.name for x in program.inputs)})
    results = reader.results()

    def plain(value: Expr) -> Expr:
        return value.xreplace({x: x.args[0] for x in value.atoms(_HELD)})

    return Steps(
        tuple((Symbol(name, real=True), plain(value)) for name, value in reader.definitions),
        {name: plain(value) for name, value in results.items()},
    )


_FRACTION = Symbol("fraction")
_HELD = Function("held")
"""Keeps an angle that is a number from being put into cosines and sines."""
V = TypeVar("V")


@dataclass
class Reader(ABC, Generic[V]):
    """Reads a program, operation by operation, into expressions of some kind; ``taken`` : names
    that no step may get.

    Steps with labels get them as names, if others use them, and what is used twice and ``is_worth``
    it gets x0, x1, ...
    """

    program: Program
    taken: set[str]
    values: list[V] = field(default_factory=list)
    definitions: list[tuple[str, V]] = field(default_factory=list)
    named: dict[Operation, V] = field(default_factory=dict)

    @abstractmethod
    def input(self, symbol: Symbol) -> V:
        """The value of an argument."""

    @abstractmethod
    def constant(self, value: Any) -> V:
        """The value of a rational number, or of pi."""

    @abstractmethod
    def made(self, operation: str, *arguments: V) -> V:
        """The value of an operation on values."""

    @abstractmethod
    def name(self, name: str) -> V:
        """The value that a step of that name has."""

    @abstractmethod
    def is_name(self, value: V) -> bool:
        """Whether it is a mere name, or the negative of one."""

    def written(self, value: V) -> V:
        """A value as it is to be shown."""
        return value

    def is_worth(self, value: V) -> bool:
        """Whether a value that comes more than once deserves a name."""
        return True

    def results(self) -> dict[str, V]:
        """The results; after this ``definitions`` has the steps."""
        program = self.program
        uses, all_uses = _uses(program), _uses(program, program.results.values())
        for n, step in enumerate(program.operations):
            value = self.value(step)
            # A labelled step that is a result and nothing else needs no definition.
            label = program.labels.get(n, "") if uses[n] else ""
            is_repeated = all_uses[n] > 1 and step.name not in ("input", "constant", "neg")
            if label or is_repeated:
                value = self.written(value)
                if (label or self.is_worth(value)) and not self.is_name(value):
                    value = self.defined(step, value, label)
            self.values.append(value)
        return {x: self.written(self.values[n]) for x, n in program.results.items()}

    def value(self, step: Operation) -> V:
        """The value of a step, from those of its arguments."""
        if step.name == "input":
            return self.input(self.program.inputs[step.arguments[0]])
        if step.name == "constant":
            return self.constant(step.value)
        # Where y - x has a name N, x - y is written as -N.
        if step.name == "sub":
            opposite = Operation("sub", step.arguments[::-1])
            if opposite in self.named:
                return self.made("neg", self.named[opposite])
        return self.made(step.name, *(self.values[n] for n in step.arguments))

    def defined(self, step: Operation, value: V, label: str) -> V:
        """Define a step's value under a free name; returns what stands for it from here on."""
        # A label "-N" names the negative: N = -value is defined, and the value is written as -N.
        stem = label.removeprefix("-")
        names = (f"{stem}{'x' * n}" if stem else f"x{n}" for n in count())
        name = next(x for x in names if x not in self.taken)
        self.taken.add(name)
        is_negative, named = label.startswith("-"), self.name(name)
        self.definitions.append((name, self.made("neg", value) if is_negative else value))
        if is_negative:
            named = self.made("neg", named)
        self.named[step] = named
        return named


class _PageReader(Reader[Expr]):
    def input(self, symbol: Symbol) -> Expr:
        return symbol

    def constant(self, value: Any) -> Expr:
        if not isinstance(value, Expr):
            return Rational(int(value.p), int(value.q))
        # cos(pi/8) or sin(pi/8), of a power of s, is a nest of roots as a number: it stays what it
        # is until double angles have been looked for.
        angle = acos(value)
        if value.is_Rational or not (angle / pi).is_Rational:
            return value
        wave, half = (cos, angle) if 4 * angle <= pi else (sin, pi / 2 - angle)
        return wave(_HELD(half))

    def made(self, operation: str, *arguments: Expr) -> Expr:
        return _MADE[operation](*arguments)

    def name(self, name: str) -> Expr:
        return Symbol(name, real=True)

    def is_name(self, value: Expr) -> bool:
        return bool((-value if value.could_extract_minus_sign() else value).is_Symbol)

    def written(self, value: Expr) -> Expr:
        return _whole_angles(value)

    def is_worth(self, value: Expr) -> bool:
        return bool(value.free_symbols and count_ops(value) > _SHORT)


_SHORT = 6  # operations that stand on a page twice, without a name
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
        "sinc": lambda x: sin(x) / x,
        "sincm1": lambda x: sin(x) / x - 1,
        "asin": asin,
        "max": Max,
        "min": Min,
        "quantiser": quantiser,
    }
)


def _uses(program: Program, results: Iterable[int] = ()) -> Counter[int]:
    """How often each step is used, by others and as these results; a negative's uses are those of
    the step itself."""
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
    # 2 sin a cos a = sin 2a, 2 cos^2 a = 1 + cos 2a, 2 sin^2 a = 1 - cos 2a: products are looked
    # for in the expanded form, as they may hide in a factor.
    joined = value.expand()
    for angle in angles:
        both, wave = cos(angle) * sin(angle), cos(2 * angle)
        squares = {cos(angle): (1 + wave) / 2, sin(angle): (1 - wave) / 2}
        joined = joined.replace(
            lambda x, squares=squares: x.is_Pow and x.base in squares and x.exp.is_Integer,
            lambda x, squares=squares: squares[x.base] ** (x.exp // 2) * x.base ** (x.exp % 2),
        ).replace(
            lambda x, both=both: x.is_Mul and {*both.args} <= {*x.args},
            lambda x, both=both, angle=angle: x / both * sin(2 * angle) / 2,
        )
    others = map(factor_terms, (joined, joined.expand()))
    shortest = min(value, *(x.func(*x.args) if x.args else x for x in others), key=count_ops)
    return value if shortest == value else _whole_angles(shortest)
