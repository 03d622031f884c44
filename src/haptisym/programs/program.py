"""Straight-line programs: lists of operations without branches, each run by several arithmetics
(floats, double-doubles, balls, Taylor models).

A program is written once, by a ``Writer`` that shares equal steps and folds constants exactly, so
that all arithmetics compute the same formula, step by step. Folding never changes a value: only
exact rational numbers are combined, and signs are moved outward.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Any, TypeVar

from flint import fmpq
from sympy import (
    Add,
    Expr,
    Function,
    Max,
    Min,
    Mul,
    Pow,
    Rational,
    Symbol,
    asin,
    cos,
    exp,
    sin,
    sinc,
)

from haptisym.kernel.errors import SceneError
from haptisym.kernel.harmonics import Harmonic, quantiser
from haptisym.kernel.rings import Polynomial, PolynomialRing

_ZERO, _ONE = fmpq(0), fmpq(1)
V = TypeVar("V")


class sincm1(Function):  # type: ignore[misc]  # noqa: N801 - named as SymPy names functions
    """The function sin(x)/x - 1, and 0 at x = 0: a step of its own, as the difference of floats
    would lose its digits where x is small."""

    @classmethod
    def eval(cls, x: Expr) -> Expr | None:
        return x if x.is_zero else None


class phi(Function):  # type: ignore[misc]  # noqa: N801 - as above
    """The function (1 - exp(-x))/x, and 1 at x = 0: what a delay leaves of a quotient that is 0/0
    at s = 0."""


SMALL, LAST = 2.0, 27
"""Floats sum the series of sin(x)/x - 1 for |x| <= ``SMALL``, up to the term x^(LAST - 1)/LAST!:
what is left out is less than 2^-65."""


@dataclass(frozen=True, slots=True)
class Operation:
    """One step: ``name`` is add, sub, mul, div, neg, abs, sqrt, cos, sin, sinc, sincm1, exp, phi,
    asin, max, min, quantiser, power, input or constant.

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

    ``labels`` : the name of a step on a page; with a minus before it, the name of its negative.
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
        values = dict(known)
        for i, step in enumerate(self.operations):
            if step.name == "input":
                values[i] = inputs[step.arguments[0]]
            elif i not in values:
                values[i] = functions[step.name](*[values[x] for x in step.arguments])
        return {name: values[x] for name, x in self.results.items()}


@dataclass
class Writer:
    """Writes a program step by step: equal steps are written once, and sums with 0, products with 1
    and operations on numbers are folded. A step is known by its index.

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
        # Sums and products commute: x + y and y + x are one step.
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
        """The same step, named for a page: the first name stays; inputs, their squares and numbers
        get none."""
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
        # Signs move outward: x + (-y) and x - y become the same step, and are computed once.
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
        """-x; of -x it is x, and of x - y it is y - x."""
        a, step = self.number(x), self.operations[x]
        if a is not None:
            return self.constant(-a)
        if step.name == "neg":
            return step.arguments[0]
        if step.name == "sub":
            return self.sub(step.arguments[1], step.arguments[0])
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
        # Division by the number 0 is left to the arithmetic, which says what comes of it.
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
        """The step that computes a SymPy expression in the inputs; SceneError for a function that
        has no step."""
        if given in self.inputs:
            return self.input(given)
        if isinstance(given, Rational):
            return self.constant(fmpq(int(given.p), int(given.q)))
        # pi, roots of numbers and the like stay exact: each arithmetic rounds or encloses them
        # itself.
        if given.is_number:
            return self._step("constant", value=given)
        if isinstance(given, Add | Mul):
            return reduce(
                self.add if isinstance(given, Add) else self.mul, map(self.expression, given.args)
            )
        if isinstance(given, Max | Min):
            name = type(given).__name__.lower()
            return reduce(lambda x, y: self._step(name, x, y), map(self.expression, given.args))
        if isinstance(given, Pow) and given.exp.is_Integer:
            whole = self.power(self.expression(given.base), abs(int(given.exp)))
            return whole if given.exp > 0 else self.div(self.constant(1), whole)
        if isinstance(given, Pow):
            return self._step("power", self.expression(given.base), self.expression(given.exp))
        # A first harmonic is written out; only a staircase has steps without a number.
        if isinstance(given, Harmonic) and not isinstance(given, quantiser):
            return self.expression(given.explicit)
        for kind in (cos, sin, sinc, sincm1, exp, phi, asin, quantiser):
            if isinstance(given, kind):
                return self._step(kind.__name__, self.expression(given.args[0]))
        raise SceneError(f"{given} cannot be compiled: only + - * /, powers, sines and cosines can")

    def polynomial(
        self, ring: PolynomialRing, polynomial: Polynomial, meanings: Sequence[Expr] | None = None
    ) -> int:
        """The step that computes a polynomial, by Horner's rule in each variable; ``meanings`` :
        the expressions in the inputs that the variables stand for, those of the ring unless
        given."""
        terms = {tuple(map(int, e)): value for e, value in polynomial.to_dict().items()}
        return self._horner(terms, meanings or ring.meanings)

    def _horner(self, terms: Mapping[tuple[int, ...], fmpq], meanings: Sequence[Expr]) -> int:
        """The polynomial with these terms: in the first variable, with coefficients that are
        polynomials in the others."""
        if not meanings:
            return self.constant(terms.get((), _ZERO))
        coefficients: dict[int, dict[tuple[int, ...], fmpq]] = {}
        for (power, *rest), value in terms.items():
            coefficients.setdefault(power, {})[tuple(rest)] = value
        if set(coefficients) <= {0}:
            return self._horner(coefficients.get(0, {}), meanings[1:])
        x, total, above = self.expression(meanings[0]), self.constant(0), max(coefficients)
        # Powers that are missing are stepped over: of k + m x^2 one product by x^2, which other
        # polynomials share.
        for power in sorted(coefficients, reverse=True):
            total = self.mul(total, self.power(x, above - power))
            total, above = self.add(total, self._horner(coefficients[power], meanings[1:])), power
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
        """The program of these results: of all steps that were written, those that they need."""
        whole = Program(self.inputs, tuple(self.operations), results)
        used = whole.needed(results.values())
        # Steps that no result needs are left out, so the others get new indices.
        place = {old: new for new, old in enumerate(used)}
        steps = tuple(_moved(self.operations[x], place) for x in used)
        places = {name: place[x] for name, x in results.items()}
        labels = {place[x]: name for x, name in self.labels.items() if x in place}
        return Program(self.inputs, steps, places, labels)


def _moved(step: Operation, place: Mapping[int, int]) -> Operation:
    """A step whose arguments have new places; that of an input is the index of a symbol, not of a
    step."""
    if step.name == "input":
        return step
    return Operation(step.name, tuple(place[x] for x in step.arguments), step.value)
