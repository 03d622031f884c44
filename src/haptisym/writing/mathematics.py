"""Equations for a page: aligned at their relations, long ones broken at their signs, long fractions in named parts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from sympy import Expr

from haptisym.writing.boxes import Absolute, Box, Fenced, Fraction, Name, Product, Sum, Word, needs_dot
from haptisym.writing.document import Line
from haptisym.writing.htmltext import Html, element
from haptisym.writing.latex import is_long, tex, width
from haptisym.writing.mathml import markup, mathml

ROOM = 38.0
"""Width of a line of the page's one column, em."""
_MINUS, _PLUS, _DOT, _TIMES = "<mo>−</mo>", "<mo>+</mo>", "<mo>⋅</mo>", "<mo>&#x2062;</mo>"
_INFIX = '<mo form="infix">'  # spaced as between two terms, also at the start of a line
_CROSS = '<mo form="infix">×</mo>'  # the product's sign, where a line starts with a factor
_LEFT = ' style="text-align: left"'
_MORE = ' class="more"'  # a line that belongs to the one above
_OPEN, _CLOSE = (f'<mo minsize="1.2em" maxsize="1.2em">{fence}</mo>' for fence in "()")
_BAR = '<mo stretchy="false">|</mo>'


@dataclass
class Parts:
    """The numerators and denominators that were given names, so that one that occurs again is not written again."""

    given: dict[Box, Name] = field(default_factory=dict)

    def name(self, box: Box, letter: str) -> tuple[Name, bool]:
        """The name of a part, and whether it is new."""
        if box in self.given:
            return self.given[box], False
        count = 1 + sum(name.head.letters == letter for name in self.given.values())
        self.given[box] = Name(f"{letter}_{count}", Word(letter, upright=False), (Word(str(count), upright=False),))
        return self.given[box], True


def display(formulas: Sequence[Line], parts: Parts | None = None) -> Html:
    """The formulas in one block, aligned at their relations, which scrolls by itself where it is too wide.

    >>> from haptisym.kernel.symbols import s
    >>> from haptisym.writing.equations import QUANTITIES
    >>> display([Line(QUANTITIES["H_env"][0], s)]).count("<mtr>")
    1
    """
    named = Parts() if parts is None else parts
    rows = "".join(
        f"<mtr{'' if left else _MORE}><mtd{_LEFT}>{left}</mtd><mtd{_LEFT}><mrow>{right}</mrow></mtd></mtr>"
        for f in formulas
        for left, right in _rows(f, named)
    )
    table = f'<mtable displaystyle="true">{rows}</mtable>'
    whole = f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">{table}</math>'
    return element("div", Html(whole), given={"class": "scroll formulas"})


def inline(expression: Expr | Box) -> Html:
    """A formula within a line of text."""
    return Html(mathml(expression))


def _rows(f: Line, parts: Parts) -> Iterator[tuple[str, str]]:
    """Left and right side of each line, the relation at the start of the right one."""
    left = markup(f.left)
    is_left_out = f.optional and is_long(f.value)
    relation = f"<mo>{f.relation}</mo>"
    if f.meaning is not None:
        meaning, value = markup(f.meaning), f.box
        if not is_left_out and _wide(f.meaning) + _wide(value) <= ROOM - _wide(f.left):
            yield left, f"<mo>=</mo>{meaning}{relation}{markup(value)}"
            return
        yield left, f"<mo>=</mo>{meaning}"
        left = ""
    if not is_left_out:
        yield from _valued(left, relation, f.box, ROOM - _wide(f.left), parts)


def _valued(left: str, relation: str, box: Box, room: float, parts: Parts) -> Iterator[tuple[str, str]]:
    minus, quotient = (_MINUS, box.terms[0][1]) if isinstance(box, Sum) and len(box.terms) == 1 else ("", box)
    if not isinstance(quotient, Fraction) or _wide(box) <= room:
        yield from _broken(left, relation, box, room)
        return
    named = [(x, *parts.name(x, letter)) if _wide(x) > room - 2 else (x, x, False)
             for x, letter in ((quotient.above, "𝒩"), (quotient.below, "𝒟"))]  # fmt: skip
    yield left, f"{relation}{minus}{markup(Fraction(named[0][1], named[1][1]))}"
    for part, name, is_new in named:
        if is_new:
            yield from _broken(markup(name), "<mo>=</mo>", part, room)


def _broken(left: str, relation: str, box: Box, room: float) -> Iterator[tuple[str, str]]:
    first, *others = [markup(box)] if _wide(box) <= room else _lines(list(_pieces(box, 0)), room)
    yield left, relation + first
    for line in others:
        yield "", f'<mspace width="2em"/>{line}'


class _Piece(NamedTuple):
    """Markup that is not broken, its width in em, and how bad a break before it would be."""

    text: str
    width: float
    penalty: int


_NEVER = 1000


def _pieces(box: Box, depth: int) -> Iterator[_Piece]:
    """A formula cut at its signs and between its factors, also within parentheses."""
    if isinstance(box, Sum):
        for i, (sign, term) in enumerate(box.terms):
            before = (_PLUS if sign > 0 else _MINUS).replace("<mo>", _INFIX) if i else _MINUS if sign < 0 else ""
            yield from _after(before, depth, _pieces(term, depth))
    elif isinstance(box, Product):
        for i, factor in enumerate(box.factors):
            dotted = i > 0 and needs_dot(box.factors[i - 1], factor)
            yield from _after(_DOT if dotted else _TIMES if i else "", depth + 10, _pieces(factor, depth))
    elif isinstance(box, Fenced) and _wide(box) > ROOM / 4:
        yield from _fenced(_OPEN, list(_pieces(box.inside, depth + 1)), _CLOSE)
    elif isinstance(box, Absolute) and _wide(box) > ROOM:
        yield from _fenced(_BAR, list(_pieces(box.inside, depth + 1)), _BAR)
    else:
        yield _Piece(markup(box), _wide(box), _NEVER)


def _after(before: str, penalty: int, pieces: Iterable[_Piece]) -> Iterator[_Piece]:
    """The pieces with an operator in front, where a line may be broken."""
    first, *others = pieces
    yield _Piece(before + first.text, first.width + (1.2 if "+" in before or "−" in before else 0.0), penalty)
    yield from others


def _fenced(left: str, pieces: list[_Piece], right: str) -> Iterator[_Piece]:
    first, *others = pieces
    opened = [_Piece(left + first.text, first.width + 0.4, _NEVER), *others]
    yield from opened[:-1]
    yield _Piece(opened[-1].text + right, opened[-1].width + 0.4, opened[-1].penalty)


def _lines(pieces: list[_Piece], room: float) -> Iterator[str]:
    rest = room - 3  # the lines after the first one are set in
    while pieces:
        count = _fitting(pieces, room)
        line = "".join(piece.text for piece in pieces[:count])
        yield f"<mrow>{_CROSS + line.removeprefix(_TIMES) if line.startswith(_TIMES) else line}</mrow>"
        pieces, room = pieces[count:], rest


def _fitting(pieces: Sequence[_Piece], room: float) -> int:
    """How many pieces to put on a line: as many as fit, fewer if that breaks outside of parentheses."""
    ends: list[float] = []
    for piece in pieces:
        total = piece.width + (ends[-1] if ends else 0.0)
        if ends and total > room:
            break
        ends.append(total)
    if len(ends) == len(pieces):
        return len(ends)
    allowed = [n for n in range(1, len(ends) + 1) if pieces[n].penalty < _NEVER]
    late = [n for n in allowed if ends[n - 1] > room / 2] or allowed[-1:] or [len(ends)]
    return min(late, key=lambda n: (pieces[n].penalty, -n))


_OPERATORS = re.compile(r"\\[a-z]*(?:sin|cos|tan)h?(?![a-z])")


def _wide(box: Box) -> float:
    """About how wide a box is, em; names of functions are words, with space around."""
    text = tex(box)
    return width(text) + 1.3 * len(_OPERATORS.findall(text))
