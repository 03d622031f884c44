"""Straight-line programs: one list of operations for every arithmetic that runs it (floats,
double-doubles, balls)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from flint import fmpq
from sympy import Add, Expr, Function, Mul, Pow, Rational, Symbol, cos, exp, sin, sinc

from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, PolynomialRing

_ZERO, _ONE = fmpq(0), fmpq(1)
V = TypeVar("V")


class sincm1(Function):  # type: ignore[misc]  # noqa: N801 - named as SymPy names functions
    """sin(x)/x - 1, and 0 at x = 0: for floats, in which the difference would lose its digits where
    x is small."""

    @classmethod
    def eval(cls, x: Expr) -> Expr | None:
        return x if x.is_zero else None


class phi(Function):  # type: ignore[misc]  # noqa: N801 - as above
    """(1 - exp(-x))/x, and 1 at x = 0: what a delay leaves of a quotient that is 0/0 at s = 0."""


SMALL, LAST = 2.0, 27
"""Up to which x floats sum the series of sin(x)/x - 1, and to which term x^(LAST - 1)/LAST!: less
than 2^-65 is left out."""


@dataclass(frozen=True, slots=True)
class Operation:
    """One step: ``name`` is add, sub, mul, div, neg, abs, sqrt, cos, sin, sinc, sincm1, exp, phi,
    power, input or constant.

    ``arguments`` : indices of earlier steps; for an input its index. ``value`` : of a constant, an
    ``fmpq`` or a SymPy number.
    """

    name: str
    arguments: tuple[int, ...] = ()
    value: Any = None


@dataclass(frozen=True, eq=False)
class Program:
    """Operations in order, and the indices of the results by name. Inputs are in the order of
    ``inputs``.

    ``labels`` : what a reader calls a step; with a minus before it, what he calls its negative.
    """

    inputs: tuple[Symbol, ...]
    operations: tuple[Operation, ...]
    results: Mapping[str, int]
    labels: Mapping[int, str] = field(default_factory=dict)

    def needed(self, results: Iterable[int]) -> list[int]:
        """The steps that some steps need, themselves included, in order."""
        used: set[int] = set()
        waiting = list(results)
        while waiting:
            x = waiting.pop()
            if x not in used:
                used.add(x)
                step = self.operations[x]
                waiting += step.arguments if step.name != "input" else ()
        return sorted(used)

    def run(
        self, functions: Mapping[str, Callable[..., V]], inputs: Sequence[V], known: Mapping[int, V]
    ) -> dict[str, V]:
        """The results by name in an arithmetic of ``functions``; ``known`` : its constants, by
        their places."""
        found = dict(known)
        for i, step in enumerate(self.operations):
            if step.name == "input":
                found[i] = inputs[step.arguments[0]]
            elif i not in found:
                found[i] = functions[step.name](*[found[x] for x in step.arguments])
        return {name: found[x] for name, x in self.results.items()}


@dataclass
class Writer:
    """Writes a program: equal steps are written once, and what is trivial is not written at all.

    >>> x = Symbol("x")
    >>> write = Writer((x,))
    >>> write.mul(write.input(x), write.constant(1)) == write.input(x)
    True
    >>> square = write.power(write.input(x), 2)
    >>> [step.name for step in write.program({"y": write.add(square, square)}).operations]
    ['input', 'mul', 'add']
    """

    inputs: tuple[Symbol, ...]
    operations: list[Operation] = field(default_factory=list)
    known: dict[Operation, int] = field(default_factory=dict)
    labels: dict[int, str] = field(default_factory=dict)

    def _step(self, name: str, *arguments: int, value: Any = None) -> int:
        if name in ("add", "mul"):
            arguments = tuple(sorted(arguments))
        step = Operation(name, arguments, value)
        if step not in self.known:
            self.known[step] = len(self.operations)
            self.operations.append(step)
        return self.known[step]

    def input(self, symbol: Symbol) -> int:
        """The step that reads an argument."""
        return self._step("input", self.inputs.index(symbol))

    def constant(self, value: Any) -> int:
        """The step that is a rational number."""
        return self._step("constant", value=value if isinstance(value, fmpq) else fmpq(value))

    def label(self, x: int, name: str) -> int:
        """The same step under a name, for a reader: the first name stays; inputs, their squares and
        numbers have none."""
        step = self.operations[x]
        is_square = len(set(step.arguments)) == 1 < len(step.arguments)
        if step.name == "neg":
            self.label(step.arguments[0], f"-{name}")
        elif not (
            step.name in ("input", "constant")
            or (is_square and self.operations[step.arguments[0]].name == "input")
        ):
            self.labels.setdefault(x, name)
        return x

    def number(self, x: int) -> fmpq | None:
        """The rational number that a step is, if it is one."""
        value = self.operations[x].value
        return value if isinstance(value, fmpq) else None

    def add(self, x: int, y: int) -> int:
        """x + y; zeros, constants and opposites are folded."""
        a, b = self.number(x), self.number(y)
        if a is not None and b is not None:
            return self.constant(a + b)
        if a == _ZERO or b == _ZERO:
            return y if a == _ZERO else x
        for one, other in ((x, y), (y, x)):
            if self.operations[other].name == "neg":
                return self.sub(one, self.operations[other].arguments[0])
        return self._step("add", x, y)

    def sub(self, x: int, y: int) -> int:
        """x - y, folded likewise."""
        a, b = self.number(x), self.number(y)
        if a is not None and b is not None:
            return self.constant(a - b)
        if b == _ZERO or a == _ZERO:
            return x if b == _ZERO else self.neg(y)
        if self.operations[y].name == "neg":
            return self.add(x, self.operations[y].arguments[0])
        return self.constant(0) if x == y else self._step("sub", x, y)

    def neg(self, x: int) -> int:
        """-x; twice is not at all."""
        a, step = self.number(x), self.operations[x]
        if a is not None:
            return self.constant(-a)
        if step.name in ("neg", "sub"):
            return (
                step.arguments[0]
                if step.name == "neg"
                else self.sub(step.arguments[1], step.arguments[0])
            )
        return self._step("neg", x)

    def mul(self, x: int, y: int) -> int:
        """x y; zeros, ones and constants are folded."""
        a, b = self.number(x), self.number(y)
        if a is not None and b is not None:
            return self.constant(a * b)
        if _ZERO in (a, b):
            return self.constant(0)
        if _ONE in (a, b):
            return y if a == _ONE else x
        if -1 in (a, b):
            return self.neg(y if a == -1 else x)
        for one, other in ((x, y), (y, x)):
            if self.operations[one].name == "neg":
                return self.neg(self.mul(self.operations[one].arguments[0], other))
        return self._step("mul", x, y)

    def div(self, x: int, y: int) -> int:
        """x / y, folded likewise."""
        a, b = self.number(x), self.number(y)
        if b == _ONE or a == _ZERO:
            return x
        if a is not None and b:
            return self.constant(a / b)
        for one, other in ((x, y), (y, x)):
            if self.operations[one].name == "neg":
                inner = self.operations[one].arguments[0]
                return self.neg(self.div(inner, other) if one == x else self.div(other, inner))
        return self._step("div", x, y)

    def power(self, x: int, n: int) -> int:
        """x^n for n >= 0, by repeated squaring."""
        if n == 0:
            return self.constant(1)
        if n == 1:
            return x
        half = self.power(x, n // 2)
        square = self.mul(half, half)
        return self.mul(square, x) if n % 2 else square

    def abs(self, x: int) -> int:
        """|x|."""
        step = self.operations[x]
        inner = step.arguments[0] if step.name == "neg" else x
        value = self.number(inner)
        return self.constant(abs(value)) if value is not None else self._step("abs", inner)

    def sqrt(self, x: int) -> int:
        """The square root of x."""
        return self._step("sqrt", x)

    def expression(self, given: Expr) -> int:
        """A SymPy expression in the inputs."""
        if given in self.inputs:
            return self.input(given)
        if isinstance(given, Rational):
            return self.constant(fmpq(int(given.p), int(given.q)))
        if given.is_number:
            return self._step("constant", value=given)
        if isinstance(given, Add | Mul):
            first, *others = map(self.expression, given.args)
            for x in others:
                first = self.add(first, x) if isinstance(given, Add) else self.mul(first, x)
            return first
        if isinstance(given, Pow) and given.exp.is_Integer:
            whole = self.power(self.expression(given.base), abs(int(given.exp)))
            return whole if given.exp > 0 else self.div(self.constant(1), whole)
        if isinstance(given, Pow):
            return self._step("power", self.expression(given.base), self.expression(given.exp))
        for kind in (cos, sin, sinc, sincm1, exp, phi):
            if isinstance(given, kind):
                return self._step(kind.__name__, self.expression(given.args[0]))
        raise SceneError(f"{given} cannot be compiled: only + - * /, powers, sines and cosines can")

    def polynomial(
        self, ring: PolynomialRing, polynomial: Polynomial, meanings: Sequence[Expr] | None = None
    ) -> int:
        """A polynomial by Horner's rule in each variable; they mean expressions in the inputs,
        those of the ring unless given."""
        terms = {tuple(map(int, e)): value for e, value in polynomial.to_dict().items()}
        return self._horner(terms, meanings or ring.meanings)

    def _horner(self, terms: Mapping[tuple[int, ...], fmpq], meanings: Sequence[Expr]) -> int:
        if not meanings:
            return self.constant(terms.get((), _ZERO))
        rows: dict[int, dict[tuple[int, ...], fmpq]] = {}
        for (power, *rest), value in terms.items():
            rows.setdefault(power, {})[tuple(rest)] = value
        if set(rows) <= {0}:
            return self._horner(rows.get(0, {}), meanings[1:])
        x, total, above = self.expression(meanings[0]), self.constant(0), max(rows)
        for power in sorted(rows, reverse=True):
            total = self.mul(total, self.power(x, above - power))
            total, above = self.add(total, self._horner(rows[power], meanings[1:])), power
        return self.mul(total, self.power(x, above))

    def product(self, ring: PolynomialRing, polynomial: Polynomial) -> int:
        """A polynomial as the product of its factors."""
        unit, factors = ring.factors(polynomial)
        if [n for _, n in factors] == [1]:
            return self.polynomial(ring, polynomial)
        total = self.expression(unit)
        for factor, n in factors:
            total = self.mul(total, self.power(self.polynomial(ring, factor), n))
        return total

    def program(self, results: Mapping[str, int]) -> Program:
        """What the results need of all that was written."""
        whole = Program(self.inputs, tuple(self.operations), results)
        used = whole.needed(results.values())
        place = {old: new for new, old in enumerate(used)}
        steps = tuple(_moved(self.operations[x], place) for x in used)
        labels = {place[x]: name for x, name in self.labels.items() if x in place}
        return Program(self.inputs, steps, {name: place[x] for name, x in results.items()}, labels)


def _moved(step: Operation, place: Mapping[int, int]) -> Operation:
    if step.name == "input":
        return step
    return Operation(step.name, tuple(place[x] for x in step.arguments), step.value)
