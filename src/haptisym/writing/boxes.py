"""The boxes of typeset mathematics: what a formula looks like, before anyone decides how it is
written down.

``layout`` makes a tree of them from an expression, or for the name of a quantity; ``text`` here,
``latex`` and ``mathml`` write it, each with a table that has a form for every kind of box. Order,
signs and fences of a formula are in the tree, so that all writers agree on them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias


@dataclass(frozen=True, slots=True)
class Numeral:
    """A decimal number >= 0: ``digits`` times ten to the ``exponent``."""

    digits: str
    exponent: int = 0


@dataclass(frozen=True, slots=True)
class Ratio:
    """A small fraction of two whole numbers > 0."""

    above: int
    below: int


@dataclass(frozen=True, slots=True)
class Word:
    """A part of a name: a letter (a Greek one in English), a number, or words; upright or not."""

    letters: str
    upright: bool


@dataclass(frozen=True, slots=True)
class Name:
    """A symbol as it is called (``text``) and as it is set: with subscripts."""

    text: str
    head: Word
    below: tuple[Word, ...] = ()


@dataclass(frozen=True, slots=True)
class Operator:
    """An upright name of the mathematicians: ``cos``, ``arcsin``, ``Re``."""

    name: str


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms with the signs (1 or -1) in front of them; one term alone has a minus."""

    terms: tuple[tuple[int, Box], ...]


@dataclass(frozen=True, slots=True)
class SideBySide:
    """Factors side by side; sums among them are fenced."""

    factors: tuple[Box, ...]


@dataclass(frozen=True, slots=True)
class Fraction:
    """One above the other."""

    above: Box
    below: Box


@dataclass(frozen=True, slots=True)
class Power:
    """A base, fenced where it must be, and its exponent."""

    base: Box
    exponent: Box


@dataclass(frozen=True, slots=True)
class Radical:
    """A square root."""

    inside: Box


@dataclass(frozen=True, slots=True)
class Exponential:
    """e to the exponent."""

    exponent: Box


@dataclass(frozen=True, slots=True)
class Applied:
    """A function with its arguments in parentheses."""

    function: Box
    arguments: tuple[Box, ...]


@dataclass(frozen=True, slots=True)
class Series:
    """The sum of a term over a whole number: its name, and from where to where."""

    term: Box
    index: Box
    first: Box
    last: Box


@dataclass(frozen=True, slots=True)
class Prefixed:
    """An operator in front of its operand, without parentheses: Re H."""

    operator: Box
    operand: Box


@dataclass(frozen=True, slots=True)
class Fenced:
    """Something in parentheses."""

    inside: Box


@dataclass(frozen=True, slots=True)
class Absolute:
    """Something between bars."""

    inside: Box


@dataclass(frozen=True, slots=True)
class MatrixBox:
    """A matrix, row by row."""

    rows: tuple[tuple[Box, ...], ...]


@dataclass(frozen=True, slots=True)
class Titled:
    """A quantity as it is called in plain text, and as it is set."""

    text: str
    inside: Box


@dataclass(frozen=True, slots=True)
class Relation:
    """Sides that are related in turn: ``relations`` (one of ``= ≈ ≠ < > ≤ ≥``) stand between
    ``sides``."""

    sides: tuple[Box, ...]
    relations: tuple[str, ...]


Box: TypeAlias = (
    Numeral
    | Ratio
    | Name
    | Operator
    | Sum
    | SideBySide
    | Fraction
    | Power
    | Radical
    | Exponential
    | Applied
    | Series
    | Prefixed
    | Fenced
    | Absolute
    | MatrixBox
    | Titled
    | Relation
)


def needs_dot(left: Box, right: Box) -> bool:
    """Whether two neighbours in a product need a sign between them: two numbers, or what comes
    after an operator's operand."""
    # Without it 2 3 would be read as 23, and Re H k as Re (H k).
    return isinstance(left, Prefixed) or (
        isinstance(left, Numeral | Ratio) and _starts_with_digit(right)
    )


def _starts_with_digit(box: Box) -> bool:
    """Whether a box is a number or a power of one."""
    base = box.base if isinstance(box, Power) else box
    return isinstance(base, Numeral | Ratio)


# One line of text, for the screen, with signs that a keyboard has.


def formed(box: Box, forms: Mapping[type, Callable[[Any], str]]) -> str:
    """A box as a writer writes it: ``forms`` has a form for every kind. TypeError for what is no
    box."""
    if type(box) not in forms:
        raise TypeError(f"not a box: {type(box).__name__}")
    return forms[type(box)](box)


def text(box: Box) -> str:
    """A box as one line of plain text.

    >>> text(Relation((Name("x", Word("x", False)), Sum(((-1, Numeral("2")), (1, Radical(Numeral("3")))))), ("≤",)))
    'x <= -2 + sqrt(3)'
    """
    return formed(box, _TEXT)


# What a keyboard can type: relations, and functions by the names that programs have for them.
_KEYS = {
    "≈": "~",
    "≠": "!=",
    "≤": "<=",
    "≥": ">=",
    "ln": "log",
    "arsinh": "asinh",
    "arcosh": "acosh",
    "artanh": "atanh",
}
_KEYS |= {f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan")}


def _inside(box: Box, *fenced: type) -> str:
    """A part, in parentheses where it is one of those."""
    return f"({text(box)})" if isinstance(box, fenced) else text(box)


def _product(x: SideBySide) -> str:
    """Factors side by side, as text."""
    # On one line 2/3 k could be read as 2/(3 k), so a quotient among factors has parentheses.
    parts = [_inside(x.factors[0], Ratio, Fraction)]
    for left, right in pairwise(x.factors):
        parts.append(("*" if needs_dot(left, right) else " ") + _inside(right, Ratio, Fraction))
    return "".join(parts)


def signed(terms: Sequence[tuple[int, Box]], form: Callable[[Box], str]) -> str:
    """Terms with their signs between them, the first one's only where it is a minus."""
    shown = "".join((" - " if sign < 0 else " + ") + form(term) for sign, term in terms)
    return f"-{shown[3:]}" if shown.startswith(" - ") else shown[3:]


def related(x: Relation, form: Callable[[Box], str], relations: Mapping[str, str]) -> str:
    """The sides of an equation with its relations between them."""
    shown = form(x.sides[0])
    for sign, side in zip(x.relations, x.sides[1:], strict=True):
        shown += f" {relations.get(sign, sign)} {form(side)}"
    return shown


_TEXT: Mapping[type, Callable[[Any], str]] = {
    Numeral: lambda x: f"{x.digits}e{x.exponent}" if x.exponent else x.digits,
    Ratio: lambda x: f"{x.above}/{x.below}",
    Name: lambda x: x.text,
    Operator: lambda x: _KEYS.get(x.name, x.name),
    Sum: lambda x: signed(x.terms, text),
    SideBySide: _product,
    Fraction: lambda x: (
        f"{_inside(x.above, Sum, Fraction, Ratio)}/"
        f"{_inside(x.below, Sum, SideBySide, Fraction, Ratio)}"
    ),
    Power: lambda x: (
        f"{_inside(x.base, Ratio)}^{_inside(x.exponent, Sum, SideBySide, Fraction, Ratio, Power)}"
    ),
    Radical: lambda x: f"sqrt({text(x.inside)})",
    Exponential: lambda x: f"exp({text(x.exponent)})",
    Applied: lambda x: f"{text(x.function)}({', '.join(map(text, x.arguments))})",
    Series: lambda x: f"sum({text(x.term)}, {text(x.index)} = {text(x.first)} to {text(x.last)})",
    Prefixed: lambda x: f"{text(x.operator)} {_inside(x.operand, Sum, Fraction)}",
    Fenced: lambda x: f"({text(x.inside)})",
    Absolute: lambda x: (
        f"abs({text(x.inside)})" if "|" in text(x.inside) else f"|{text(x.inside)}|"
    ),
    MatrixBox: lambda x: (
        "[" + ", ".join("[" + ", ".join(map(text, row)) + "]" for row in x.rows) + "]"
    ),
    Titled: lambda x: x.text,
    Relation: lambda x: related(x, text, _KEYS),
}
