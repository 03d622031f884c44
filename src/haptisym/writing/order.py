"""The order in which a person writes factors and terms, and the terms that a person takes together."""

from __future__ import annotations

from typing import Any

from sympy import Add, Expr, I, Integer, Mul, Pow, S, Symbol, factor_terms

from haptisym.kernel.symbols import X, omega, s
from haptisym.writing.names import alphabetical


def place(factor: Expr) -> tuple[Any, ...]:
    """Where a factor stands in a product: numbers, X, parameters, their sums, frequencies, s or omega, j, functions, sums."""
    base = base_of(factor)
    if base in (s, omega):
        return (6,)
    if base.is_Symbol:
        return (1 if base == X else 4 if _is_frequency(base) else 2, *alphabetical(base))
    if factor == I:
        return (7,)
    if isinstance(base, Add):
        if not factor.is_Add and not factor.exp.is_Integer:
            return (10,)
        return (9 if base.has(s, omega) else 5 if any(map(_is_frequency, base.free_symbols)) else 3,)
    return 0 if base.is_number else 8, str(factor)


def base_of(factor: Expr) -> Expr:
    """What is raised to a power."""
    return factor.base if isinstance(factor, Pow) else factor


def _is_frequency(symbol: Symbol) -> bool:
    return bool(symbol.name.startswith("omega_"))


def variable_of(expr: Expr) -> Symbol | None:
    """The variable whose powers order a sum: s, omega, else a frequency among the parameters."""
    free = expr.free_symbols
    named = sorted(filter(_is_frequency, free), key=alphabetical)
    return next((x for x in (s, omega, *named) if x in free), None)


def grouped(expr: Add, variable: Symbol | None) -> list[Expr]:
    """The terms of a sum, those with the same power of the variable made one: their coefficients in front of it.

    >>> from sympy import symbols
    >>> b, J, k = symbols("b J k")
    >>> grouped(b * s + J * s + k, s)
    [k, s*(J + b)]
    """
    if variable is None:
        return list(expr.args)
    coefficients: dict[Expr, list[Expr]] = {}
    for term in expr.args:
        coefficient, power = term.as_independent(variable, as_Add=False)
        coefficients.setdefault(power, []).append(coefficient)
    terms: list[Expr] = []
    for power, found in coefficients.items():
        total = factor_terms(Add(*found)) if len(found) > 1 or found[0].has(Add) else found[0]
        is_sum = isinstance(total, Add) or isinstance(-total, Add)
        terms += found if power == 1 and is_sum else [Mul(total, power)]
    return terms


def rank(term: Expr, variable: Symbol | None) -> tuple[Any, ...]:
    """Sort key of a term: descending powers, quotients last, then the natural order of the factors."""
    names = sorted(place(f) for f in Mul.make_args(term) if not f.is_Number)
    return -_degree(term, variable), any(name[0] == 8 for name in names), not names, str(names)


def _degree(term: Expr, variable: Symbol | None) -> Expr:
    """The power of the variable in a term (of all symbols without one); least for quotients of sums."""
    total: Expr = S.Zero
    for f in Mul.make_args(term):
        base, exponent = (f.base, f.exp) if isinstance(f, Pow) else (f, S.One)
        counts = base == variable or (variable is None and base.is_Symbol)
        if counts:
            total += exponent if exponent.is_Number else S.Half
        elif isinstance(base, Add) and exponent.is_Number:
            if exponent < 0 and (variable is None or base.has(variable)):
                return Integer(-1000)
            if not exponent.is_Integer:
                return Integer(-999)
            total += exponent * max(_degree(x, variable) for x in base.args)
    return total
