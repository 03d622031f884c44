"""Formulas in presentation MathML.

Formulas in presentation MathML, for HTML pages and notebooks. It needs no script and no style sheet.

Quotients of polynomials whose parameters are numbers, brought into a form that can be read on a screen.
"""

from __future__ import annotations

from functools import singledispatch
from itertools import pairwise
from xml.sax.saxutils import escape

from sympy import Add, Basic, Expr, Function, I, Integer, Mul, Rational, Symbol, preorder_traversal
from sympy.core.numbers import ImaginaryUnit

from haptisym.kernel.rings import RationalFunction
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
    Word,
    needs_dot,
)
from haptisym.writing.layout import CAPITALS, approximate, is_short, layout, letter, rounded

_TIMES = "<mo>&#x2062;</mo>"  # no sign to see, but a product to a screen reader
_APPLY = "<mo>&#x2061;</mo>"  # likewise for the value of a function
_MINUS = "<mo>−</mo>"
_COMMA, _SLASH = '<mo rspace="0em">,</mo>', '<mo lspace="0em" rspace="0em">/</mo>'
_SPACE = '<mspace width="0.17em"/>'  # between an operator's upright name and what is next to it
_FENCES = ('stretchy="false"', 'minsize="1.2em" maxsize="1.2em"', 'minsize="1.8em" maxsize="1.8em"')


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
    inside = markup(layout(expression) if isinstance(expression, Basic) else expression)
    style = "block" if display else "inline"
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="{style}">{inside}</math>'


@singledispatch
def markup(box: Box) -> str:
    """One element of MathML for a box."""
    raise TypeError(f"no MathML for {type(box).__name__}: give an expression or a box")


@markup.register
def _(box: Numeral) -> str:
    if not box.exponent:
        return f"<mn>{box.digits}</mn>"
    power = f"<msup><mn>10</mn>{_whole(box.exponent)}</msup>"
    return power if box.digits == "1" else f"<mrow><mn>{box.digits}</mn><mo>×</mo>{power}</mrow>"


def _whole(number: int) -> str:
    return f"<mrow>{_MINUS}<mn>{-number}</mn></mrow>" if number < 0 else f"<mn>{number}</mn>"


@markup.register
def _(box: Ratio) -> str:
    quotient = f"<mfrac><mn>{box.above}</mn><mn>{box.below}</mn></mfrac>"
    return f'<mstyle displaystyle="false">{quotient}</mstyle>'


@markup.register
def _(box: Name) -> str:
    if not box.below:
        return _word(box.head)
    return f"<msub>{_word(box.head)}{_subscript(box)}</msub>"


def _subscript(box: Name) -> str:
    words = [_word(word) for word in box.below]
    return words[0] if len(words) == 1 else f"<mrow>{_COMMA.join(words)}</mrow>"


def _word(word: Word) -> str:
    if word.letters.isdigit():
        return f"<mn>{word.letters}</mn>"
    if word.upright:
        printable = "".join(c if c.isprintable() else "\ufffd" for c in word.letters)
        return f'<mi mathvariant="normal">{escape(printable).replace(" ", "&#xA0;")}</mi>'
    upright = ' mathvariant="normal"' if word.letters in CAPITALS else ""
    return f"<mi{upright}>{letter(word.letters)}</mi>"


@markup.register
def _(box: Operator) -> str:
    return f'<mi mathvariant="normal">{box.name}</mi>'


@markup.register
def _(box: Sum) -> str:
    (sign, first), *others = box.terms
    text = (_MINUS if sign < 0 else "") + markup(first)
    return (
        f"<mrow>{text}{''.join((_MINUS if sign < 0 else '<mo>+</mo>') + markup(term) for sign, term in others)}</mrow>"
    )


@markup.register
def _(box: Product) -> str:
    text = markup(box.factors[0])
    for left, right in pairwise(box.factors):
        text += "<mo>⋅</mo>" if needs_dot(left, right) else _TIMES
        text += (_SPACE if isinstance(right, Prefixed) else "") + markup(right)
    return f"<mrow>{text}</mrow>"


@markup.register
def _(box: Fraction) -> str:
    return f"<mfrac>{markup(box.above)}{markup(box.below)}</mfrac>"


@markup.register
def _(box: Power) -> str:
    exponent = markup(box.exponent)
    if isinstance(box.exponent, Ratio):
        exponent = f"<mrow><mn>{box.exponent.above}</mn>{_SLASH}<mn>{box.exponent.below}</mn></mrow>"
    if isinstance(box.base, Name) and box.base.below:
        return f"<msubsup>{_word(box.base.head)}{_subscript(box.base)}{exponent}</msubsup>"
    if isinstance(box.base, Applied):
        return _applied(f"<msup>{markup(box.base.function)}{exponent}</msup>", box.base)
    return f"<msup>{markup(box.base)}{exponent}</msup>"


@markup.register
def _(box: Root) -> str:
    return f"<msqrt>{markup(box.inside)}</msqrt>"


@markup.register
def _(box: Exponential) -> str:
    return f"<msup><mi>e</mi>{markup(box.exponent)}</msup>"


@markup.register
def _(box: Applied) -> str:
    return _applied(markup(box.function), box)


def _applied(function: str, box: Applied) -> str:
    return f"<mrow>{function}{_APPLY}{_between('(', '<mo>,</mo>'.join(map(markup, box.arguments)), ')')}</mrow>"


@markup.register
def _(box: Prefixed) -> str:
    space = _SPACE if isinstance(box.operator, Operator) else ""
    return f"<mrow>{markup(box.operator)}{_APPLY}{space}{markup(box.operand)}</mrow>"


@markup.register
def _(box: Fenced) -> str:
    return _between("(", markup(box.inside), ")")


@markup.register
def _(box: Absolute) -> str:
    return _between("|", markup(box.inside), "|")


def _between(left: str, inside: str, right: str) -> str:
    """Fences: as tall as tall formulas; around others a little larger than those inside them."""
    is_tall = any(tall in inside for tall in ("<mfrac", "<msqrt", "<mtable"))
    size = "" if is_tall else f" {_FENCES[(_FENCES[0] in inside) + (_FENCES[1] in inside)]}"
    return f"<mrow><mo{size}>{left}</mo>{inside}<mo{size}>{right}</mo></mrow>"


@markup.register
def _(box: Grid) -> str:
    rows = ("".join(f"<mtd>{markup(x)}</mtd>" for x in row) for row in box.rows)
    return _between("(", f"<mtable>{''.join(f'<mtr>{row}</mtr>' for row in rows)}</mtable>", ")")


@markup.register
def _(box: Titled) -> str:
    return markup(box.inside)


@markup.register
def _(box: Equation) -> str:
    text = markup(box.sides[0])
    for relation, side in zip(box.relations, box.sides[1:], strict=True):
        text += f"<mo>{escape(relation)}</mo>{markup(side)}"
    return f"<mrow>{text}</mrow>"


_DIGITS = 6  # significant digits of a number that is too long to write out


def readable(function: RationalFunction, variable: Symbol, digits: int | None = None) -> tuple[Expr, bool]:
    """A quotient of numbers' polynomials for reading, denominators monic, and whether a number in it had to be rounded.

    ``digits`` : to which all numbers are rounded, where they are known no better.

    >>> from haptisym.kernel.rings import s
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
