"""Formulas as one line of text, for the screen: the boxes of ``layout`` with signs that a keyboard has."""

from __future__ import annotations

from functools import singledispatch
from itertools import pairwise

from sympy import Basic

from haptisym.writing.boxes import (
    Absolute,
    Applied,
    Box,
    Equation,
    Exponential,
    Fenced,
    Fraction,
    Grid,
    Name,
    Numeral,
    Operator,
    Power,
    Prefixed,
    Product,
    Ratio,
    Root,
    Sum,
    Titled,
    needs_dot,
)
from haptisym.writing.layout import layout

_OPERATORS = {
    **{f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan")}, "arsinh": "asinh", "arcosh": "acosh", "artanh": "atanh",
    "ln": "log",
}  # fmt: skip
_RELATIONS = {"≈": "~", "≠": "!=", "≤": "<=", "≥": ">="}


def plain(expression: Basic) -> str:
    """A formula as one line of text, names as they are called.

    >>> from sympy import Rational, symbols
    >>> from haptisym.kernel.rings import s
    >>> k, omega_n = symbols("k omega_n")
    >>> plain(Rational(9, 5) * s**2 + 15 * s + 100), plain(-k * (s + 1) / (2 * omega_n**2))
    ('1.8 s^2 + 15 s + 100', '-k (s + 1)/(2 omega_n^2)')
    """
    return text(layout(expression))


@singledispatch
def text(box: Box) -> str:
    """Plain text of a box."""
    raise TypeError(f"not a box: {type(box).__name__}")


@text.register
def _(box: Numeral) -> str:
    return f"{box.digits}e{box.exponent}" if box.exponent else box.digits


@text.register
def _(box: Ratio) -> str:
    return f"{box.above}/{box.below}"


@text.register
def _(box: Name) -> str:
    return box.text


@text.register
def _(box: Operator) -> str:
    return _OPERATORS.get(box.name, box.name)


@text.register
def _(box: Sum) -> str:
    shown = "".join((" - " if sign < 0 else " + ") + text(term) for sign, term in box.terms)
    return "-" + shown[3:] if shown.startswith(" - ") else shown[3:]


@text.register
def _(box: Product) -> str:
    shown = _inside(box.factors[0], Ratio, Fraction)
    for left, right in pairwise(box.factors):
        shown += ("*" if needs_dot(left, right) else " ") + _inside(right, Ratio, Fraction)
    return shown


@text.register
def _(box: Fraction) -> str:
    return f"{_inside(box.above, Sum, Fraction, Ratio)}/{_inside(box.below, Sum, Product, Fraction, Ratio)}"


@text.register
def _(box: Power) -> str:
    exponent = _inside(box.exponent, Sum, Product, Fraction, Ratio, Power)
    return f"{_inside(box.base, Ratio)}^{exponent}"


@text.register
def _(box: Root) -> str:
    return f"sqrt({text(box.inside)})"


@text.register
def _(box: Exponential) -> str:
    return f"exp({text(box.exponent)})"


@text.register
def _(box: Applied) -> str:
    return f"{text(box.function)}({', '.join(map(text, box.arguments))})"


@text.register
def _(box: Prefixed) -> str:
    return f"{text(box.operator)} {_inside(box.operand, Sum, Fraction)}"


@text.register
def _(box: Fenced) -> str:
    return f"({text(box.inside)})"


@text.register
def _(box: Absolute) -> str:
    inside = text(box.inside)
    return f"abs({inside})" if "|" in inside else f"|{inside}|"


@text.register
def _(box: Grid) -> str:
    rows = [f"[{', '.join(map(text, row))}]" for row in box.rows]
    return f"[{', '.join(rows)}]"


@text.register
def _(box: Titled) -> str:
    return box.text


@text.register
def _(box: Equation) -> str:
    shown = text(box.sides[0])
    for relation, side in zip(box.relations, box.sides[1:], strict=True):
        shown += f" {_RELATIONS.get(relation, relation)} {text(side)}"
    return shown


def _inside(box: Box, *fenced: type) -> str:
    """A part, in parentheses where it is one of those."""
    return f"({text(box)})" if isinstance(box, fenced) else text(box)
