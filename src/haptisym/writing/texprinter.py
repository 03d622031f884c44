"""Formulas in LaTeX, for amsmath."""

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
from haptisym.writing.texnames import set_name

_OPERATORS = {
    **{x: rf"\{x}" for x in ("sin", "cos", "tan", "cot", "sinh", "cosh", "tanh", "coth", "ln", "max", "min")},
    **{x: rf"\{x}" for x in ("arcsin", "arccos", "arctan")},
}  # fmt: skip
RELATIONS = {"≈": r"\approx", "≠": r"\ne", "≤": r"\le", "≥": r"\ge"}


def formula(expression: Basic) -> str:
    r"""A SymPy expression as LaTeX.

    >>> from haptisym.kernel.symbols import omega, symbols
    >>> m, k = symbols("m k")
    >>> formula(k - m * omega**2)
    'k - m \\omega^{2}'
    """
    return tex(layout(expression))


@singledispatch
def tex(box: Box) -> str:
    """LaTeX of a box."""
    raise TypeError(f"not a box: {type(box).__name__}")


@tex.register
def _(box: Numeral) -> str:
    if not box.exponent:
        return box.digits
    power = f"10^{{{box.exponent}}}"
    return power if box.digits == "1" else rf"{box.digits} \times {power}"


@tex.register
def _(box: Ratio) -> str:
    return rf"\tfrac{{{box.above}}}{{{box.below}}}"


@tex.register
def _(box: Name) -> str:
    return set_name(box)


@tex.register
def _(box: Operator) -> str:
    return _OPERATORS.get(box.name, rf"\operatorname{{{box.name}}}")


@tex.register
def _(box: Sum) -> str:
    text = "".join((" - " if sign < 0 else " + ") + tex(term) for sign, term in box.terms)
    return "-" + text[3:] if text.startswith(" - ") else text[3:]


@tex.register
def _(box: Product) -> str:
    text = tex(box.factors[0])
    for left, right in pairwise(box.factors):
        text += (r" \cdot " if needs_dot(left, right) else r" \, " if isinstance(right, Prefixed) else " ") + tex(right)
    return text


@tex.register
def _(box: Fraction) -> str:
    return rf"\frac{{{tex(box.above)}}}{{{tex(box.below)}}}"


@tex.register
def _(box: Power) -> str:
    exponent = f"{box.exponent.above}/{box.exponent.below}" if isinstance(box.exponent, Ratio) else tex(box.exponent)
    if isinstance(box.base, Applied):
        return f"{tex(box.base.function)}^{{{exponent}}}{_arguments(box.base)}"
    return f"{tex(box.base)}^{{{exponent}}}"


@tex.register
def _(box: Root) -> str:
    return rf"\sqrt{{{tex(box.inside)}}}"


@tex.register
def _(box: Exponential) -> str:
    return f"e^{{{tex(box.exponent)}}}"


@tex.register
def _(box: Applied) -> str:
    return tex(box.function) + _arguments(box)


def _arguments(box: Applied) -> str:
    return parenthesised(", ".join(map(tex, box.arguments)))


@tex.register
def _(box: Prefixed) -> str:
    return f"{tex(box.operator)} {tex(box.operand)}"


@tex.register
def _(box: Fenced) -> str:
    return parenthesised(tex(box.inside))


@tex.register
def _(box: Absolute) -> str:
    return rf"\left| {tex(box.inside)} \right|"


@tex.register
def _(box: Grid) -> str:
    rows = r" \\ ".join(" & ".join(map(tex, row)) for row in box.rows)
    return rf"\begin{{pmatrix}} {rows} \end{{pmatrix}}"


@tex.register
def _(box: Titled) -> str:
    return tex(box.inside)


@tex.register
def _(box: Equation) -> str:
    text = tex(box.sides[0])
    for relation, side in zip(box.relations, box.sides[1:], strict=True):
        text += f" {RELATIONS.get(relation, relation)} {tex(side)}"
    return text


def parenthesised(text: str) -> str:
    """Parentheses: of one size, so that lines can break inside, except around tall formulas."""
    if any(tall in text for tall in (r"\frac", r"\sqrt", r"\left", r"\begin")):
        return rf"\left( {text} \right)"
    if r"\bigl" in text:
        return rf"\Bigl( {text} \Bigr)"
    return rf"\bigl( {text} \bigr)" if "(" in text else f"({text})"
