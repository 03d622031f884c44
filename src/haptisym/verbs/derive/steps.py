"""Straight-line computations: what is printed as code."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from sympy import Add, Dummy, Expr, Mul, Pow, Symbol, count_ops, cse, default_sort_key, numbered_symbols

from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import Shown, counted


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

    @classmethod
    def sharing(cls, results: Mapping[str, Expr]) -> Steps:
        """The computation of some expressions in which each common subexpression is computed once.

        >>> from sympy import symbols
        >>> a, b = symbols("a b")
        >>> steps = Steps.sharing({"up": (a + b) ** 2, "down": 1 / (a + b)})
        >>> steps.definitions, steps.results
        (((x0, a + b),), {'up': x0**2, 'down': 1/x0})
        """
        return cls((), results).shared()

    def shared(self) -> Steps:
        """The same computation, with a definition for what occurs twice or more, and for what a whole power is taken of.

        Numbers that stand together, such as 2 pi/3, stay together.
        """
        names = [name for name, _ in self.definitions]
        hidden: dict[Expr, Symbol] = {}
        values = [map_numbers(e, lambda x: _hide(x, hidden)) for e in self._values()]
        powers = [x for e in values for x in e.atoms(Pow) if x.exp.is_Integer and x.exp != -1 and not x.base.is_Symbol]
        taken = {x.name for x in self.free_symbols | {*names}}
        fresh = (x for x in numbered_symbols("x", real=True) if x.name not in taken)
        # a base that is listed by itself as well occurs twice: it gets its name
        bases = sorted({x.base for x in powers}, key=default_sort_key)
        found, kept = cse([*values, *bases], symbols=fresh, order="none")
        shown = {symbol: number for number, symbol in hidden.items()}
        found = [(name, value.xreplace(shown)) for name, value in found]
        kept = [value.xreplace(shown) for value in kept]
        own, rest = kept[: len(names)], kept[len(names) : len(values)]
        alias = {value: name for name, value in zip(names, own, strict=True) if value in dict(found)}
        listed = [(alias.get(name, name), value.xreplace(alias)) for name, value in found]
        listed += [(x, e.xreplace(alias)) for x, e in zip(names, own, strict=True) if e not in alias]
        return Steps(_ordered(listed), {x: e.xreplace(alias) for x, e in zip(self.results, rest, strict=True)})

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
        >>> Steps((), {"y": (a + b) * cos(a + b)}).operations, Steps.sharing({"y": (a + b) * cos(a + b)}).operations
        (4, 3)
        """
        return sum(int(count_ops(map_numbers(e, _constant))) for e in self._values())

    def expressions(self) -> dict[str, Expr]:
        """The results as expressions in the arguments alone: all definitions put in."""
        return self.at({})

    def at(self, values: Mapping[Symbol, Expr]) -> dict[str, Expr]:
        """The results for given values of the arguments (exact for exact values), computed definition by definition.

        >>> from sympy import Integer, symbols
        >>> a, b = symbols("a b")
        >>> Steps.sharing({"y": (a + b) ** 2 + 1 / (a + b)}).at({a: Integer(1), b: Integer(2)})
        {'y': 28/3}
        """
        known: dict[Symbol, Expr] = dict(values)
        for name, value in self.definitions:
            known[name] = value.xreplace(known)
        return {name: value.xreplace(known) for name, value in self.results.items()}


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


def _hide(number: Expr, hidden: dict[Expr, Symbol]) -> Expr:
    """A symbol for an irrational number, so that it is not taken apart."""
    return number if number.is_Rational else hidden.setdefault(number, Dummy(real=True))


def _constant(number: Expr) -> Expr:
    return number if number.is_Integer else Symbol("number")


def _ordered(definitions: Sequence[tuple[Symbol, Expr]]) -> tuple[tuple[Symbol, Expr], ...]:
    """The definitions so that each comes after all that it uses, otherwise in their order."""
    values = dict(definitions)
    placed: dict[Symbol, Expr] = {}

    def place(name: Symbol) -> None:
        for used in sorted(values[name].free_symbols & values.keys() - placed.keys(), key=default_sort_key):
            place(used)
        placed[name] = values[name]

    for name in values:
        if name not in placed:
            place(name)
    return tuple(placed.items())
