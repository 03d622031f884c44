"""The order in which a person writes the terms of a formula, and formulas as plain text."""

from __future__ import annotations

from sympy import Add, Expr, Float, I, Integer, Mul, Rational, Symbol, preorder_traversal
from sympy.core.numbers import ImaginaryUnit
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from .reals import ExactNumber
from .rings import RationalFunction
from .symbols import omega, s

_DIGITS = 6  # significant digits of a number that is too long to write out


def written_order(terms: list[Expr]) -> list[Expr]:
    """The terms of a sum in descending powers of s or omega; ascending where that avoids a leading minus.

    >>> from sympy import symbols
    >>> m, b, k = symbols("m b k")
    >>> written_order([k, b * s, m * s**2]), written_order([-m * omega**2, k])
    ([m*s**2, b*s, k], [k, -m*omega**2])
    """
    descending = sorted(terms, key=lambda term: (-_power(term), str(term)))
    first, last = descending[0], descending[-1]
    if first.could_extract_minus_sign() and not last.could_extract_minus_sign():
        return sorted(terms, key=lambda term: (_power(term), str(term)))
    return descending


def _power(term: Expr) -> int:
    powers = term.as_powers_dict()
    return max(int(powers.get(x, 0)) for x in (s, omega))


def decimal_text(number: Rational, longest: int = 12) -> str:
    """A rational number as people write it: 1.8 where the decimal ends early, 1/3 where it does not.

    >>> decimal_text(Rational(9, 5)), decimal_text(Rational(1, 3)), decimal_text(Integer(-4))
    ('1.8', '1/3', '-4')
    """
    below = int(number.q)
    for prime in (2, 5):
        while below % prime == 0:
            below //= prime
    if number.q == 1 or below != 1:
        return str(number)
    places = next(n for n in range(1, 400) if 10**n % number.q == 0)
    if places > longest:
        return str(number)
    digits = f"{abs(int(number * 10**places)):0{places + 1}d}"
    return f"{'-' if number < 0 else ''}{digits[:-places]}.{digits[-places:]}"


class _Printer(StrPrinter):  # type: ignore[misc]  # SymPy ships no types
    """SymPy's text, with sums in written order and numbers as decimals in front."""

    def _as_ordered_terms(self, expr: Expr, order: str | None = None) -> list[Expr]:
        return written_order(list(expr.args))

    def _print_Rational(self, expr: Rational) -> str:
        return decimal_text(expr)

    def _print_Float(self, expr: Float) -> str:
        return f"{float(expr):.{_DIGITS}g}"

    def _print_Mul(self, expr: Expr) -> str:
        number, rest = expr.as_coeff_Mul()
        if not isinstance(number, Rational) or number.q == 1:
            return str(super()._print_Mul(expr))
        text = decimal_text(number)
        return f"{f'({text})' if '/' in text else text}*{self.parenthesize(rest, PRECEDENCE['Mul'])}"


def plain(expression: Expr) -> str:
    """A formula as one line of text.

    >>> from sympy import symbols
    >>> plain(Rational(9, 5) * s**2 + 15 * s + 100)
    '1.8 s^2 + 15 s + 100'
    """
    text = str(_Printer({"order": None}).doprint(expression))
    return text.replace("**", "^").replace("*", " ")


def rounded(function: RationalFunction, variable: Symbol) -> tuple[Expr, bool]:
    """A quotient of numbers' polynomials for reading, denominators monic, and whether a number in it had to be rounded.

    >>> from .rings import PolynomialRing
    >>> rounded(PolynomialRing(s).convert((3 * s + 9) / (4 * s**2 + 7)), s)
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
    exact = all(_is_short(c) for c in [*above, *(c for row, _ in below for c in row)])
    shown = _polynomial(above, variable, exact=exact)
    return outside * shown / Mul(*(_polynomial(row, variable, exact=exact) ** n for row, n in below)), not exact


def _is_short(coefficient: Expr) -> bool:
    """Whether all numbers in it are rational and short to write."""
    rational = all(isinstance(x, Rational | ImaginaryUnit) or not x.is_number for x in preorder_traversal(coefficient))
    return rational and all(len(decimal_text(x)) <= _DIGITS + 4 for x in coefficient.atoms(Rational))


def _rounded(coefficient: Expr) -> Expr:
    """A number to a few digits, unless it is a short whole one; in a larger expression, each of its numbers."""
    if coefficient.free_symbols or coefficient.has(I):
        parts = [term.as_independent(I, *term.free_symbols, as_Add=False) for term in Add.make_args(coefficient)]
        return Add(*(_rounded(number) * rest for number, rest in parts))
    if isinstance(coefficient, Integer) and abs(coefficient) < 10**_DIGITS:
        return coefficient
    return Float(ExactNumber(coefficient).digits(_DIGITS + 3))


def _polynomial(coefficients: list[Expr], variable: Symbol, *, exact: bool) -> Expr:
    """The sum of coefficients times ascending powers, its lowest power in front."""
    shown = [c if exact else _rounded(c) for c in coefficients]
    lowest = next((n for n, c in enumerate(shown) if c != 0), 0)
    return variable**lowest * Add(*(c * variable**n for n, c in enumerate(shown[lowest:])))
