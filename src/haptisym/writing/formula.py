"""Quotients of polynomials whose parameters are numbers, brought into a form that can be read on a screen."""

from __future__ import annotations

from sympy import Add, Expr, Function, I, Integer, Mul, Rational, Symbol, preorder_traversal
from sympy.core.numbers import ImaginaryUnit

from haptisym.kernel.rings import RationalFunction
from haptisym.writing.layout import approximate, is_short, rounded

_DIGITS = 6  # significant digits of a number that is too long to write out


def readable(function: RationalFunction, variable: Symbol, digits: int | None = None) -> tuple[Expr, bool]:
    """A quotient of numbers' polynomials for reading, denominators monic, and whether a number in it had to be rounded.

    ``digits`` : to which all numbers are rounded, where they are known no better.

    >>> from haptisym.kernel.symbols import s
    >>> from haptisym.kernel.rings import PolynomialRing
    >>> readable(PolynomialRing(s).convert((3 * s + 9) / (4 * s**2 + 7)), s)
    ((3*s/4 + 9/4)/(s**2 + 7/4), False)
    """
    ring = function.ring
    reduced = function.reduced()
    lead, factors = ring.factors(reduced.denominator)
    below = []
    for factor, exponent in factors:
        coefficients = ring.coefficients(factor)
        first = coefficients[-1] if coefficients[-1].is_number else Integer(1)
        lead *= first**exponent
        below.append(([c / first for c in coefficients], exponent))
    outside, numerator = ring.without_common_functions(reduced.numerator)
    above = [(c / lead).expand() for c in ring.coefficients(numerator)]
    exact = digits is None and all(_is_short(c) for c in [*above, *(c for row, _ in below for c in row)])
    kept = None if exact else digits or _DIGITS
    shown = _polynomial(above, variable, kept)
    form = outside * shown / Mul(*(_polynomial(row, variable, kept) ** n for row, n in below))
    return form if kept is None else _with_rounded_delays(form, kept), not exact


def _with_rounded_delays(form: Expr, digits: int) -> Expr:
    """With the numbers in arguments of functions, as of ``exp(-s*tau)``, rounded where they are long."""
    return form.xreplace({f: f.func(*(approximate(x, digits) for x in f.args)) for f in form.atoms(Function)})


def _is_short(coefficient: Expr) -> bool:
    """Whether all numbers in it are rational and short to write."""
    rational = all(isinstance(x, Rational | ImaginaryUnit) or not x.is_number for x in preorder_traversal(coefficient))
    return rational and all(is_short(x) for x in coefficient.atoms(Rational))


def _rounded(coefficient: Expr, digits: int) -> Expr:
    """A number to a few digits, unless it is a whole one as short as that; in a larger expression, each of its numbers."""
    if coefficient.free_symbols or coefficient.has(I):
        numbers: dict[Expr, Expr] = {}
        for term in Add.make_args(coefficient):
            number, rest = term.as_independent(I, *term.free_symbols, as_Add=False)
            numbers[rest] = numbers.get(rest, 0) + number
        return Add(*(_rounded(number, digits) * rest for rest, number in numbers.items()))
    if isinstance(coefficient, Integer) and abs(coefficient) < 10**digits:
        return coefficient
    return rounded(coefficient, digits)


def _polynomial(coefficients: list[Expr], variable: Symbol, digits: int | None) -> Expr:
    """The sum of coefficients times ascending powers, its lowest power in front; exact, or rounded to digits."""
    shown = [c if digits is None else _rounded(c, digits) for c in coefficients]
    lowest = next((n for n, c in enumerate(shown) if c != 0), 0)
    return variable**lowest * Add(*(c * variable**n for n, c in enumerate(shown[lowest:])))
