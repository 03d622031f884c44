"""A SymPy expression laid out as a person would write it: order and signs of terms, fractions, roots, fences.

The tree (see ``boxes``) is the same for LaTeX, plain text and MathML. Nothing is rounded and nothing is evaluated: the tree
stands for the expression exactly. What it has no box for (a derivative, say) stands as a function of its arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import TypeAlias

from sympy import (
    Abs,
    Add,
    Basic,
    Expr,
    Float,
    Function,
    I,
    Integer,
    MatrixBase,
    Mul,
    Number,
    Pow,
    Rational,
    S,
    Symbol,
    pi,
)
from sympy.core.relational import Relational
from sympy.functions import exp

from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Equation,
    Exponential,
    Fenced,
    Fraction,
    Grid,
    Operator,
    Power,
    Product,
    Ratio,
    Root,
    Sum,
)
from haptisym.writing.names import named
from haptisym.writing.numerals import decimal, number
from haptisym.writing.order import base_of, grouped, place, rank, variable_of
from haptisym.writing.quotients import exponent, flipped, fraction, is_flippable

_FUNCTIONS = {
    **{name: name for name in ("sin", "cos", "tan", "cot", "sinh", "cosh", "tanh", "coth")},
    **{f"a{name}": f"arc{name}" for name in ("sin", "cos", "tan")}, "asinh": "arsinh", "acosh": "arcosh", "atanh": "artanh",
    "log": "ln", "re": "Re", "im": "Im", "Max": "max", "Min": "min", "atan2": "atan2",
}  # fmt: skip
_CONSTANTS = {pi: named("pi"), I: named("j"), S.Exp1: named("e"), S.Infinity: named("∞")}

_RELATIONS = {"==": "=", "!=": "≠", "<": "<", ">": ">", "<=": "≤", ">=": "≥"}

_Quotient: TypeAlias = tuple[int, Expr, list[Expr], list[Expr]]  # sign, number, factors above and below


def layout(expression: Basic) -> Box:
    """The boxes of an expression.

    >>> from haptisym.kernel.symbols import s
    >>> layout(2 * s + 3)
    Sum(terms=((1, Product(factors=(Numeral(digits='2', exponent=0), \
Name(text='s', head=Word(letters='s', upright=False), below=())))), (1, Numeral(digits='3', exponent=0))))
    """
    return _Layout().box(expression)


class _Layout:
    """Boxes, orders of terms and quotients of an expression's parts: what occurs twice is laid out once."""

    def __init__(self) -> None:
        self._boxes: dict[Basic, Box] = {}
        self._orders: dict[Expr, list[Expr]] = {}
        self._quotients: dict[Expr, _Quotient] = {}

    def box(self, expr: Basic) -> Box:
        if expr not in self._boxes:
            self._boxes[expr] = self._made(expr)
        return self._boxes[expr]

    def _made(self, expr: Basic) -> Box:
        if expr in _CONSTANTS:
            return _CONSTANTS[expr]
        for kind, make in self._makers:
            if isinstance(expr, kind):
                return make(self, expr)
        if expr.args:
            return self._applied(named(expr.func.__name__), expr)
        return named(str(expr))

    def _symbol(self, expr: Symbol) -> Box:
        return named(expr.name)

    def _number(self, expr: Number) -> Box:
        if expr.is_extended_negative:
            return Sum(((-1, self.box(-expr)),))
        if isinstance(expr, Float):
            return decimal(Decimal(str(expr)).normalize())
        return number(expr) if isinstance(expr, Rational) else named(str(expr))

    def _sum(self, expr: Add) -> Box:
        return _summed([self._signed(term) for term in self._written(expr)])

    def _product(self, expr: Mul) -> Box:
        return _summed([self._signed(expr)])

    def _power(self, expr: Pow) -> Box:
        if expr.exp.could_extract_minus_sign():
            return self._product(expr)
        if expr.exp == S.Half:
            return Root(self.box(expr.base))
        base = self.box(expr.base)
        is_bare = expr.base.is_Symbol or expr.base in (pi, I) or (expr.base.is_Integer and expr.base >= 0)
        is_bare = is_bare or isinstance(base, Absolute | Applied)
        return Power(base if is_bare else Fenced(base), self.box(expr.exp))

    def _absolute(self, expr: Abs) -> Box:
        inside = expr.args[0]
        if isinstance(inside, Add) and self._is_negative(inside):
            inside = -inside
        return Absolute(self._signed(inside)[1])

    def _exponential(self, expr: exp) -> Box:
        return Exponential(self.box(expr.args[0]))

    def _function(self, expr: Function) -> Box:
        name = expr.func.__name__
        return self._applied(Operator(_FUNCTIONS[name]) if name in _FUNCTIONS else named(name), expr)

    def _applied(self, function: Box, expr: Basic) -> Box:
        return Applied(function, tuple(map(self.box, expr.args)))

    def _matrix(self, expr: MatrixBase) -> Box:
        return Grid(tuple(tuple(map(self.box, row)) for row in expr.tolist()))

    def _relation(self, expr: Relational) -> Box:
        return Equation((self.box(expr.lhs), self.box(expr.rhs)), (_RELATIONS[expr.rel_op],))

    _makers: tuple[tuple[type, Callable[[_Layout, Basic], Box]], ...] = (
        (Symbol, _symbol), (Number, _number), (Mul, _product), (Pow, _power), (Add, _sum), (Abs, _absolute),
        (exp, _exponential), (Function, _function), (MatrixBase, _matrix), (Relational, _relation),
    )  # fmt: skip

    # Signs and quotients.

    def _signed(self, expr: Expr) -> tuple[int, Box]:
        """The sign to print in front of a term, and the rest of it."""
        if not (isinstance(expr, Mul | Pow) or expr.is_Number):
            return 1, self.box(expr)
        sign, coefficient, above, below = self._quotient(expr)
        split = bool(below) and pi in above and isinstance(coefficient, Rational) and coefficient.q < 10
        if not below:
            product = self._side_by_side(coefficient, above)
            return sign, Fenced(product) if isinstance(product, Sum) else product
        upper, lower = coefficient, S.One
        if split or (
            isinstance(coefficient, Rational) and (coefficient.p == 1 or isinstance(number(coefficient), Ratio))
        ):
            upper, lower = Integer(coefficient.p), Integer(coefficient.q)
        return sign, Fraction(self._side_by_side(upper, above), self._side_by_side(lower, below))

    def _side_by_side(self, coefficient: Expr, factors: list[Expr]) -> Box:
        """Factors side by side; a sum in parentheses unless it stands alone."""
        boxes = [self.box(f) for f in sorted(factors, key=place)]
        if coefficient != 1 or isinstance(coefficient, Float) or not boxes:
            boxes.insert(0, self.box(coefficient))
        if len(boxes) == 1:
            return boxes[0]
        return Product(tuple(Fenced(x) if isinstance(x, Sum) else x for x in boxes))

    def _quotient(self, expr: Expr) -> _Quotient:
        """Sign, coefficient >= 0, other factors above and other factors below the line."""
        if expr not in self._quotients:
            self._quotients[expr] = self._oriented(*fraction(self._spliced(expr)))
        return self._quotients[expr]

    def _spliced(self, expr: Expr) -> Expr:
        """The same product, with sums that are written as one term taken apart into its factors."""
        factors = list(Mul.make_args(expr))
        terms = [self._written(f) if isinstance(f, Add) else [f] for f in factors]
        if all(len(x) > 1 or x == [f] for x, f in zip(terms, factors, strict=True)):
            return expr
        return Mul(*(x[0] if len(x) == 1 else f for x, f in zip(terms, factors, strict=True)))

    def _oriented(self, coefficient: Expr, above: list[Expr], below: list[Expr]) -> _Quotient:
        """The same quotient with sums that start with a plus where they can; the sign that is left over in front."""
        sign = -1 if coefficient.is_extended_negative else 1
        for factors in (above, below):
            for i, f in enumerate(factors):
                if is_flippable(f) and self._is_negative(base_of(f)):
                    factors[i], sign = flipped(f), sign * (-1) ** exponent(f)
        for factors in (above, below):
            for i, f in enumerate(factors):
                if sign < 0 and is_flippable(f) and exponent(f) % 2 and self._absorbs_minus(base_of(f)):
                    factors[i], sign = flipped(f), 1
        return sign, abs(coefficient), above, below

    def _absorbs_minus(self, total: Add) -> bool:
        """Whether a person would write -(a - b) as (b - a)."""
        return len(total.args) <= 3 and not self._is_negative(-total)

    def _is_negative(self, expr: Expr) -> bool:
        """Whether a term, or the first term of a sum, is printed with a minus."""
        first = self._written(expr)[0] if isinstance(expr, Add) else expr
        if not (isinstance(first, Mul | Pow) or first.is_Number):
            return False
        return self._quotient(first)[0] < 0

    def _written(self, expr: Add) -> list[Expr]:
        """The terms of a sum as a person orders and groups them."""
        if expr not in self._orders:
            self._orders[expr] = self._in_order(expr)
        return self._orders[expr]

    def _in_order(self, expr: Add) -> list[Expr]:
        """Descending powers; ascending where that avoids a leading minus."""
        variable = variable_of(expr)
        terms = grouped(expr, variable)
        ranks = [rank(term, variable) for term in terms]
        descending = sorted(range(len(terms)), key=lambda i: ranks[i])
        negative = [self._is_negative(term) for term in terms]
        signs = [negative[i] for i in descending]
        if not signs[0] or all(signs) or (variable and signs[-1]):
            return [terms[i] for i in descending]
        ascending = sorted(range(len(terms)), key=lambda i: (-ranks[i][0], *ranks[i][1:]))
        first = next(i for i in ascending if not negative[i])
        return [terms[first], *(terms[i] for i in ascending if i != first)]


def _summed(terms: list[tuple[int, Box]]) -> Box:
    """A sum; one term with a plus is no sum."""
    return terms[0][1] if len(terms) == 1 and terms[0][0] > 0 else Sum(tuple(terms))
