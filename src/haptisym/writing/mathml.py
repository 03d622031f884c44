"""Formulas in presentation MathML, for HTML pages and notebooks, which needs no script and no style
sheet.

A *box* (``writing.boxes``) is a formula laid out: order, signs and parentheses are decided there,
and here each kind of box has one function that gives its markup (``_MARKUP``). Begin with
``mathml``.

Quotients of polynomials whose parameters are numbers are brought into a form that can be read on a
screen (``readable``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from itertools import pairwise
from typing import Any, TypeAlias

from sympy import Add, Basic, Expr, Function, I, Integer, Mul, Rational, Symbol, preorder_traversal
from sympy.core.numbers import ImaginaryUnit

from haptisym.kernel.names import CAPITALS
from haptisym.kernel.rings import RationalFunction
from haptisym.writing import boxes
from haptisym.writing.boxes import Box
from haptisym.writing.characters import printable
from haptisym.writing.layout import approximate, is_short, layout, letter, rounded
from haptisym.writing.rounding import ANYWHERE, Band, faithful

_TIMES = "<mo>&#x2062;</mo>"  # no sign to see, but a product to a screen reader
_APPLY = "<mo>&#x2061;</mo>"  # likewise for the value of a function
_MINUS = "<mo>−</mo>"
_COMMA = '<mo rspace="0em">,</mo>'
_SLASH = '<mo lspace="0em" rspace="0em">/</mo>'
_SPACE = '<mspace width="0.17em"/>'  # between an operator's upright name and what is next to it
# Sizes of fences around plain letters, from inside out.
_FENCES = ('stretchy="false"', 'minsize="1.2em" maxsize="1.2em"', 'minsize="1.8em" maxsize="1.8em"')
_TALL = "<mfrac", "<msqrt", "<mtable"


def mathml(expression: Basic | Box, *, display: bool = False) -> str:
    """Presentation MathML of an expression or of an equation, complete with its ``math`` element.

    expression : a SymPy expression, or a box (see ``equations``).
    display : on a line of its own; else within a line of text.

    Order, signs and names are those of ``latex``; nothing is rounded.

    >>> from haptisym.kernel.rings import s, symbols
    >>> mathml(symbols("k_1") + s, display=True)
    '<math xmlns="http://www.w3.org/1998/Math/MathML" display="block"><mrow><mi>s</mi><mo>+</mo>\
<msub><mi>k</mi><mn>1</mn></msub></mrow></math>'
    """
    if not isinstance(expression, Basic) and type(expression) not in _MARKUP:
        raise TypeError(f"no MathML for {type(expression).__name__}: give an expression or a box")
    box = layout(expression) if isinstance(expression, Basic) else expression
    inside = markup(box)
    style = "block" if display else "inline"
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="{style}">{inside}</math>'


def markup(box: Box) -> str:
    """One element of MathML for a box."""
    return boxes.formed(box, _MARKUP)


def _whole(number: int) -> str:
    """A whole number; a minus is an operator and no part of the number's element."""
    if number < 0:
        return f"<mrow>{_MINUS}<mn>{-number}</mn></mrow>"
    return f"<mn>{number}</mn>"


def _numeral(x: boxes.Numeral) -> str:
    """Digits, times a power of ten where there is one."""
    if not x.exponent:
        return f"<mn>{x.digits}</mn>"
    power = f"<msup><mn>10</mn>{_whole(x.exponent)}</msup>"
    if x.digits == "1":
        return power
    return f"<mrow><mn>{x.digits}</mn><mo>×</mo>{power}</mrow>"


def _subscript(x: boxes.Name) -> str:
    """The subscripts of a name, with commas between them."""
    words = [_word(word) for word in x.below]
    return words[0] if len(words) == 1 else f"<mrow>{_COMMA.join(words)}</mrow>"


def _word(word: boxes.Word) -> str:
    """A part of a name. A single letter in ``mi`` slants unless it says otherwise; capital Greek
    letters stand upright."""
    if word.letters.isdigit():
        return f"<mn>{word.letters}</mn>"
    if word.upright:
        letters = escape(printable(word.letters)).replace(" ", "&#xA0;")
        return f'<mi mathvariant="normal">{letters}</mi>'
    upright = ' mathvariant="normal"' if word.letters in CAPITALS else ""
    return f"<mi{upright}>{letter(word.letters)}</mi>"


def _sum(x: boxes.Sum) -> str:
    """Terms with their signs; no plus before the first."""
    parts = []
    for sign, term in x.terms:
        if sign < 0:
            parts.append(_MINUS)
        elif parts:
            parts.append("<mo>+</mo>")
        parts.append(markup(term))
    return f"<mrow>{''.join(parts)}</mrow>"


def _product(x: boxes.SideBySide) -> str:
    """Factors, with a dot between those that would run together."""
    parts = [markup(x.factors[0])]
    for left, right in pairwise(x.factors):
        parts.append("<mo>⋅</mo>" if boxes.needs_dot(left, right) else _TIMES)
        if isinstance(right, boxes.Prefixed):
            parts.append(_SPACE)
        parts.append(markup(right))
    return f"<mrow>{''.join(parts)}</mrow>"


def _power(x: boxes.Power) -> str:
    base = x.base
    exponent = markup(x.exponent)
    # A small fraction on two lines would be too small to read in an exponent.
    if isinstance(x.exponent, boxes.Ratio):
        above, below = x.exponent.above, x.exponent.below
        exponent = f"<mrow><mn>{above}</mn>{_SLASH}<mn>{below}</mn></mrow>"
    # Subscript and exponent stand one above the other, and the exponent of a function on its name.
    if isinstance(base, boxes.Name) and base.below:
        return f"<msubsup>{_word(base.head)}{_subscript(base)}{exponent}</msubsup>"
    if isinstance(base, boxes.Applied):
        function = f"<msup>{markup(base.function)}{exponent}</msup>"
        return _applied(function, base)
    return f"<msup>{markup(base)}{exponent}</msup>"


def _applied(function: str, x: boxes.Applied) -> str:
    """A function, as markup, with its arguments in parentheses."""
    arguments = "<mo>,</mo>".join(map(markup, x.arguments))
    return f"<mrow>{function}{_APPLY}{_between('(', arguments, ')')}</mrow>"


def _between(left: str, inside: str, right: str) -> str:
    """Fences: as tall as tall formulas; around others a little larger than those inside them."""
    # Without a size a fence stretches with what is inside. Around plain letters it would then be as
    # tall as they are, whatever is nested, so three fixed sizes tell the levels apart.
    size = ""
    if not any(tall in inside for tall in _TALL):
        small, middle, _ = _FENCES
        level = (small in inside) + (middle in inside)
        size = f" {_FENCES[level]}"
    return f"<mrow><mo{size}>{left}</mo>{inside}<mo{size}>{right}</mo></mrow>"


def _prefixed(x: boxes.Prefixed) -> str:
    """An operator and what it is applied to, without parentheses."""
    space = _SPACE if isinstance(x.operator, boxes.Operator) else ""
    return f"<mrow>{markup(x.operator)}{_APPLY}{space}{markup(x.operand)}</mrow>"


def _series(x: boxes.Series) -> str:
    """A sum sign with its limits, and the term."""
    below = f"<mrow>{markup(x.index)}<mo>=</mo>{markup(x.first)}</mrow>"
    sign = f"<munderover><mo>∑</mo>{below}{markup(x.last)}</munderover>"
    return f"<mrow>{sign}{markup(x.term)}</mrow>"


def _grid(x: boxes.MatrixBox) -> str:
    """A matrix in parentheses."""
    rows = []
    for row in x.rows:
        entries = "".join(f"<mtd>{markup(y)}</mtd>" for y in row)
        rows.append(f"<mtr>{entries}</mtr>")
    return _between("(", f"<mtable>{''.join(rows)}</mtable>", ")")


def _equation(x: boxes.Relation) -> str:
    """Sides with the relations between them."""
    first, *others = x.sides
    parts = [markup(first)]
    for sign, side in zip(x.relations, others, strict=True):
        parts.append(f"<mo>{escape(sign)}</mo>{markup(side)}")
    return f"<mrow>{''.join(parts)}</mrow>"


def _name(x: boxes.Name) -> str:
    """A name with its subscripts."""
    head = _word(x.head)
    return f"<msub>{head}{_subscript(x)}</msub>" if x.below else head


_SMALL = '<mstyle displaystyle="false"><mfrac><mn>{}</mn><mn>{}</mn></mfrac></mstyle>'
_MARKUP: Mapping[type, Callable[[Any], str]] = {
    boxes.Numeral: _numeral,
    boxes.Ratio: lambda x: _SMALL.format(x.above, x.below),
    boxes.Name: _name,
    boxes.Operator: lambda x: f'<mi mathvariant="normal">{x.name}</mi>',
    boxes.Sum: _sum,
    boxes.SideBySide: _product,
    boxes.Fraction: lambda x: f"<mfrac>{markup(x.above)}{markup(x.below)}</mfrac>",
    boxes.Power: _power,
    boxes.Radical: lambda x: f"<msqrt>{markup(x.inside)}</msqrt>",
    boxes.Exponential: lambda x: f"<msup><mi>e</mi>{markup(x.exponent)}</msup>",
    boxes.Applied: lambda x: _applied(markup(x.function), x),
    boxes.Series: _series,
    boxes.Prefixed: _prefixed,
    boxes.Fenced: lambda x: _between("(", markup(x.inside), ")"),
    boxes.Absolute: lambda x: _between("|", markup(x.inside), "|"),
    boxes.MatrixBox: _grid,
    boxes.Titled: lambda x: markup(x.inside),
    boxes.Relation: _equation,
}


def readable(
    function: RationalFunction, variable: Symbol, band: Band = ANYWHERE
) -> tuple[Expr, str] | None:
    """A quotient of numbers' polynomials for reading, denominators monic, and the sign before it,
    as it may be rounded.

    None where no rounded form is true on the band.

    >>> from haptisym.kernel.rings import s
    >>> from haptisym.kernel.rings import PolynomialRing
    >>> readable(PolynomialRing(s).convert((3 * s + 9) / (4 * s**2 + 7)), s)
    ((3*s/4 + 9/4)/(s**2 + 7/4), '=')
    """
    parts = _parts(function)
    _, *polynomials = parts
    # Exact where it can be read as it is; else rounded, and only if that is true on the band.
    if all(all(map(_is_short, row)) for row, _ in polynomials):
        return _quotient(parts, variable, None), "="
    return faithful(lambda digits: _quotient(parts, variable, digits), band)


def estimated(function: RationalFunction, variable: Symbol, digits: int) -> Expr:
    """The same with all numbers rounded to so many digits, those of delays, too, where they are
    known no better."""
    form = _quotient(_parts(function), variable, digits)
    replaced = {}
    for f in form.atoms(Function):
        arguments = [approximate(x, digits) for x in f.args]
        replaced[f] = f.func(*arguments)
    return form.xreplace(replaced)


_Parts: TypeAlias = "list[tuple[list[Expr], int]]"
"""Coefficients of polynomials with the powers that they have in a product; the first is a function
in front of all."""


def _parts(function: RationalFunction) -> _Parts:
    """The factors of a quotient, denominators monic."""
    ring = function.ring
    reduced = function.reduced()
    lead, factors = ring.factors(reduced.denominator)
    # The leading numbers of all factors are gathered and divided into the numerator, so that each
    # factor below begins with a power alone.
    below = []
    for factor, exponent in factors:
        coefficients = ring.coefficients(factor)
        highest = coefficients[-1]
        first = highest if highest.is_number else Integer(1)
        lead *= first**exponent
        monic = [c / first for c in coefficients]
        below.append((monic, -exponent))
    outside, numerator = ring.without_common_functions(reduced.numerator)
    above = [(c / lead).expand() for c in ring.coefficients(numerator)]
    return [([outside], 1), (above, 1), *below]


def _quotient(parts: _Parts, variable: Symbol, digits: int | None) -> Expr:
    """The product of the factors, all numbers rounded to so many digits, or exact."""
    (outside, _), *others = parts
    factors = [_polynomial(row, variable, digits) ** n for row, n in others]
    return outside[0] * Mul(*factors)


def _is_short(coefficient: Expr) -> bool:
    """Whether all numbers in it are rational and short to write."""
    for x in preorder_traversal(coefficient):
        if x.is_number and not isinstance(x, Rational | ImaginaryUnit):
            return False
    return all(is_short(x) for x in coefficient.atoms(Rational))


def _rounded(coefficient: Expr, digits: int) -> Expr:
    """A number to a few digits, unless it is a whole one as short as that; in a larger expression,
    each of its numbers."""
    # Terms with the same symbols are one number times these, and rounded once: two numbers that
    # nearly cancel keep their digits.
    if coefficient.free_symbols or coefficient.has(I):
        numbers: dict[Expr, Expr] = {}
        for term in Add.make_args(coefficient):
            number, rest = term.as_independent(I, *term.free_symbols, as_Add=False)
            numbers[rest] = numbers.get(rest, 0) + number
        terms = [_rounded(number, digits) * rest for rest, number in numbers.items()]
        return Add(*terms)
    if isinstance(coefficient, Integer) and abs(coefficient) < 10**digits:
        return coefficient
    return rounded(coefficient, digits)


def _polynomial(coefficients: list[Expr], variable: Symbol, digits: int | None) -> Expr:
    """The sum of coefficients times ascending powers, its lowest power in front; exact, or rounded
    to digits."""
    shown = coefficients
    if digits is not None:
        shown = [_rounded(c, digits) for c in coefficients]
    # s (s + 2), not s^2 + 2 s: zeros at 0 are seen.
    lowest = next((n for n, c in enumerate(shown) if c != 0), 0)
    terms = [c * variable**n for n, c in enumerate(shown[lowest:])]
    return variable**lowest * Add(*terms)
