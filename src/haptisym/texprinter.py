"""Formulas in LaTeX, their sums, products and names in the order and shape that people write.

A subclass of SymPy's printer, used by instance: no printer of SymPy, and no setting of one, is ever changed.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from sympy import Abs, Add, Expr, Float, Function, I, Integer, Mul, Pow, Rational, S, Symbol, factor_terms, pi
from sympy.printing.latex import LatexPrinter

from .symbols import X, omega, s
from .texnames import alphabetical, decimal, number, symbol_name


def formula(expression: Expr) -> str:
    """A SymPy expression as LaTeX."""
    return str(FormulaPrinter().doprint(expression))


class FormulaPrinter(LatexPrinter):  # type: ignore[misc]
    """SymPy's LaTeX, with sums, products, numbers and names in the order and shape that people use."""

    def __init__(self) -> None:
        super().__init__({"imaginary_unit": "j"})
        self._orders: dict[Expr, list[Expr]] = {}
        self._quotients: dict[Expr, tuple[int, str, str | None]] = {}

    def _print_Symbol(self, expr: Symbol, style: str = "plain") -> str:
        return symbol_name(expr.name)

    def _print_Rational(self, expr: Rational) -> str:
        return f"{'-' if expr < 0 else ''}{number(abs(expr))}"

    def _print_Float(self, expr: Float) -> str:
        return decimal(Decimal(str(expr)).normalize())

    def _print_Abs(self, expr: Expr, exp: str | None = None) -> str:
        inside = expr.args[0]
        if isinstance(inside, Add) and self.is_negative(inside):
            inside = -inside
        raised = f"^{{{exp}}}" if exp else ""
        return rf"\left| {self.signed(inside)[1]} \right|{raised}"

    def _print_Function(self, expr: Function, exp: str | None = None) -> str:
        name = expr.func.__name__
        if name not in ("sin", "cos", "tan", "sinh", "cosh", "tanh"):
            return str(super()._print_Function(expr, exp))
        raised = f"^{{{exp}}}" if exp else ""
        return rf"\{name}{raised}{parenthesised(self._print(expr.args[0]))}"

    def _print_Pow(self, expr: Pow) -> str:
        base, exponent = expr.args
        if exponent == S.Half:
            return rf"\sqrt{{{self._print(base)}}}"
        if exponent.is_number and exponent.is_negative:
            return self._print_Mul(expr)
        if isinstance(base, Abs | Function):
            return str(self._print(base, exp=self._print(exponent)))
        above = self._print(exponent)
        if isinstance(exponent, Rational) and r"\tfrac" in above:
            above = f"{exponent.p}/{exponent.q}"
        shown = self._print(base)
        return f"{shown if base.is_Symbol or base.is_Integer or base == pi else parenthesised(shown)}^{{{above}}}"

    def _print_Add(self, expr: Add, order: str | None = None) -> str:
        text = ""
        for term in self.written(expr):
            sign, shown = self.signed(term)
            text += (" - " if sign < 0 else " + ") + shown
        return "-" + text[3:] if text.startswith(" - ") else text[3:]

    def _print_Mul(self, expr: Mul) -> str:
        sign, shown = self.signed(expr)
        return f"{'-' if sign < 0 else ''}{shown}"

    def signed(self, expr: Expr) -> tuple[int, str]:
        """The sign to print in front of a term, and the rest of it."""
        sign, above, below = self.quotient(expr)
        return sign, above if below is None else rf"\frac{{{above}}}{{{below}}}"

    def quotient(self, expr: Expr) -> tuple[int, str, str | None]:
        """Sign, numerator and denominator of a term as printed; no denominator where it is 1."""
        if expr not in self._quotients:
            self._quotients[expr] = self._quotient(expr)
        return self._quotients[expr]

    def _quotient(self, expr: Expr) -> tuple[int, str, str | None]:
        if not (isinstance(expr, Mul | Pow) or expr.is_Number):
            return 1, str(self._print(expr)), None
        sign, coefficient, above, below = self._oriented(*_fraction(self._spliced(expr)))
        if not below:
            product = self._product(self._numeral(coefficient), above)
            is_bare_sum = len(above) == 1 and above[0].is_Add and coefficient == 1
            return sign, parenthesised(product) if is_bare_sum else product, None
        upper, lower = coefficient, S.One
        if isinstance(coefficient, Rational) and (coefficient.p == 1 or r"\tfrac" in number(coefficient)):
            upper, lower = Integer(coefficient.p), Integer(coefficient.q)
        return sign, self._product(self._numeral(upper), above), self._product(self._numeral(lower), below)

    def _spliced(self, expr: Expr) -> Expr:
        """The same product, with sums that are written as one term taken apart into its factors."""
        factors = list(Mul.make_args(expr))
        terms = [self.written(f) if isinstance(f, Add) else [f] for f in factors]
        if all(len(x) > 1 or x == [f] for x, f in zip(terms, factors, strict=True)):
            return expr
        return Mul(*(x[0] if len(x) == 1 else f for x, f in zip(terms, factors, strict=True)))

    def _numeral(self, coefficient: Expr) -> str:
        return "" if coefficient == 1 and not isinstance(coefficient, Float) else str(self._print(coefficient))

    def _product(self, numeral: str, factors: list[Expr]) -> str:
        """Factors side by side; a sum in parentheses unless it stands alone."""
        ordered = sorted(factors, key=_place)
        alone = len(ordered) == 1 and not numeral
        shown = [self._print(f) for f in ordered]
        if not alone:
            shown = [parenthesised(x) if f.is_Add else x for f, x in zip(ordered, shown, strict=True)]
        text = numeral
        for x in shown:
            text += (r" \cdot " if text[-1:].isdigit() and x[0].isdigit() else " " if text else "") + x
        return text or "1"

    def _oriented(
        self, coefficient: Expr, above: list[Expr], below: list[Expr]
    ) -> tuple[int, Expr, list[Expr], list[Expr]]:
        """The same quotient with sums that start with a plus where they can; the sign that is left over in front."""
        sign = -1 if coefficient.is_negative else 1
        for factors in (above, below):
            for i, f in enumerate(factors):
                if self._is_flippable(f) and self.is_negative(_base(f)):
                    factors[i], sign = _flipped(f), sign * (-1) ** _exponent(f)
        for factors in (above, below):
            for i, f in enumerate(factors):
                if sign < 0 and self._is_flippable(f) and _exponent(f) % 2 and self._absorbs_minus(_base(f)):
                    factors[i], sign = _flipped(f), 1
        return sign, abs(coefficient), above, below

    def _absorbs_minus(self, total: Add) -> bool:
        """Whether a person would write -(a - b) as (b - a)."""
        return len(total.args) <= 3 and not self.is_negative(-total)

    def _is_flippable(self, factor: Expr) -> bool:
        return isinstance(_base(factor), Add) and _exponent(factor) > 0

    def is_negative(self, expr: Expr) -> bool:
        """Whether a term, or the first term of a sum, is printed with a minus."""
        return self.signed(self.written(expr)[0] if isinstance(expr, Add) else expr)[0] < 0

    def written(self, expr: Add) -> list[Expr]:
        """The terms of a sum as a person orders and groups them."""
        if expr not in self._orders:
            self._orders[expr] = self._in_order(expr)
        return self._orders[expr]

    def _in_order(self, expr: Add) -> list[Expr]:
        variable = _variable(expr)
        terms = _grouped(expr, variable) if variable else list(expr.args)
        descending = sorted(terms, key=lambda term: _rank(term, variable))
        negative = [self.is_negative(term) for term in descending]
        if not negative[0] or all(negative) or (variable and negative[-1]):
            return descending
        ascending = sorted(terms, key=lambda term: (-_rank(term, variable)[0], *_rank(term, variable)[1:]))
        signs = [self.is_negative(term) for term in ascending]
        return [ascending.pop(signs.index(False)), *ascending]


def _fraction(expr: Expr) -> tuple[Expr, list[Expr], list[Expr]]:
    """Number, other factors above and other factors below the line; square roots gathered under one root."""
    coefficient, rest = expr.as_coeff_Mul()
    above: list[Expr] = []
    below: list[Expr] = []
    for f in Mul.make_args(rest):
        if isinstance(f, Pow) and f.exp.could_extract_minus_sign():
            below.append(Pow(f.base, -f.exp))
        elif f != 1:
            above.append(f)
    roots = [f.base for f in (*above, *below) if isinstance(f, Pow) and f.exp == S.Half]
    if len(roots) < 2 or sum(not root.is_nonnegative for root in roots) > 1:
        return coefficient, above, below
    number, under = coefficient**2, S.One
    for f in (*above, *below):
        if isinstance(f, Pow) and f.exp == S.Half:
            number, under = _times(number, under, f.base if f in above else 1 / f.base)
    if any(root.is_Rational for root in roots):
        coefficient = S.One if coefficient > 0 else S.NegativeOne
    else:
        number = S.One
    root = Pow(Mul(number, *Mul.make_args(under), evaluate=False), S.Half, evaluate=False)
    others = [[f for f in x if not (isinstance(f, Pow) and f.exp == S.Half)] for x in (above, below)]
    return coefficient, [*others[0], root], others[1]


def _times(number: Expr, rest: Expr, factor: Expr) -> tuple[Expr, Expr]:
    return (number * factor, rest) if factor.is_Rational else (number, rest * factor)


def _base(factor: Expr) -> Expr:
    return factor.base if isinstance(factor, Pow) else factor


def _exponent(factor: Expr) -> int:
    """A whole exponent; 0 for any other one."""
    if not isinstance(factor, Pow):
        return 1
    return int(factor.exp) if factor.exp.is_Integer else 0


def _flipped(factor: Expr) -> Expr:
    return Pow(-_base(factor), _exponent(factor))


def _place(factor: Expr) -> tuple[Any, ...]:
    """Where a factor stands in a product: numbers, X, parameters, their sums, frequencies, s or omega, j, functions, sums."""
    base = _base(factor)
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


def _is_frequency(symbol: Symbol) -> bool:
    return bool(symbol.name.startswith("omega_"))


def _variable(expr: Expr) -> Symbol | None:
    """The variable whose powers order a sum: s, omega, else a frequency among the parameters."""
    free = expr.free_symbols
    named = sorted(filter(_is_frequency, free), key=alphabetical)
    return next((x for x in (s, omega, *named) if x in free), None)


def _grouped(expr: Add, variable: Symbol) -> list[Expr]:
    """The terms of a sum, those with the same power of the variable made one: their coefficients in front of it."""
    coefficients: dict[Expr, list[Expr]] = {}
    for term in expr.args:
        coefficient, power = term.as_independent(variable, as_Add=False)
        coefficients.setdefault(power, []).append(coefficient)
    terms: list[Expr] = []
    for power, found in coefficients.items():
        total = factor_terms(Add(*found))
        is_sum = isinstance(total, Add) or isinstance(-total, Add)
        terms += found if power == 1 and is_sum else [Mul(total, power)]
    return terms


def _rank(term: Expr, variable: Symbol | None) -> tuple[Any, ...]:
    """Sort key of a term: descending powers, quotients last, then the natural order of the factors."""
    degree = _degree(term, variable)
    names = sorted(_place(f) for f in Mul.make_args(term) if not f.is_Number)
    return -degree, any(name[0] == 8 for name in names), not names, str(names)


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


def parenthesised(text: str) -> str:
    """Parentheses: of one size, so that lines can break inside, except around tall formulas."""
    if any(tall in text for tall in (r"\frac", r"\sqrt", r"\left", r"\begin")):
        return rf"\left( {text} \right)"
    if r"\bigl" in text:
        return rf"\Bigl( {text} \Bigr)"
    return rf"\bigl( {text} \bigr)" if "(" in text else f"({text})"
