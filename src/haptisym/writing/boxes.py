"""The boxes of typeset mathematics: what a formula looks like, before anyone decides how it is written down.

``layout`` makes a tree of them from an expression, ``equations`` for the names of quantities; ``texprinter``, ``plain`` and
``mathml`` write it. Order, signs and fences of a formula are in the tree, so that all writers agree on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


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
class Product:
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
class Root:
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
class Grid:
    """A matrix, row by row."""

    rows: tuple[tuple[Box, ...], ...]


@dataclass(frozen=True, slots=True)
class Titled:
    """A quantity as it is called in plain text, and as it is set."""

    text: str
    inside: Box


@dataclass(frozen=True, slots=True)
class Equation:
    """Sides that are related in turn: ``relations`` (one of ``= ≈ ≠ < > ≤ ≥``) stand between ``sides``."""

    sides: tuple[Box, ...]
    relations: tuple[str, ...]


Box: TypeAlias = (
    Numeral | Ratio | Name | Operator | Sum | Product | Fraction | Power | Root | Exponential | Applied | Prefixed | Fenced
    | Absolute | Grid | Titled | Equation
)  # fmt: skip


def needs_dot(left: Box, right: Box) -> bool:
    """Whether two neighbours in a product need a sign between them: two numbers, or what comes after an operator's operand."""
    return isinstance(left, Prefixed) or (isinstance(left, Numeral | Ratio) and _starts_with_digit(right))


def _starts_with_digit(box: Box) -> bool:
    base = box.base if isinstance(box, Power) else box
    return isinstance(base, Numeral | Ratio)
