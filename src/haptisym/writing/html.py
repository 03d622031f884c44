"""A document as a page of HTML that loads nothing from anywhere, and as a piece of one for
notebooks.

HTML is a value: text is escaped by construction, and only what was built here is markup. Equations
are aligned at their relations, long ones broken at their signs, long fractions set in named parts.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import singledispatchmethod
from html import escape
from importlib.resources import files
from itertools import groupby
from types import MappingProxyType
from typing import NamedTuple

from sympy import Expr

from haptisym.writing import document as doc
from haptisym.writing.boxes import (
    Absolute,
    Box,
    Fenced,
    Fraction,
    Name,
    SideBySide,
    Sum,
    Word,
    needs_dot,
)
from haptisym.writing.characters import printable
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.latex import is_long, tex, width
from haptisym.writing.mathml import markup, mathml
from haptisym.writing.plain import NUMBER, said

_EMPTY = frozenset(("meta", "input", "br", "hr"))  # elements that have no end
_NONE: Mapping[str, str] = MappingProxyType({})


class Html(str):
    """Markup. Whatever is not of this type is text, and is escaped where it enters an element."""

    __slots__ = ()


def element(tag: str, *children: str, given: Mapping[str, str] = _NONE) -> Html:
    """An element with its children and its attributes.

    children : ``Html`` stays as it is; any other text is escaped.
    given : attributes by name; their values are escaped.

    >>> element("p", "a < b ", element("em", "c"), given={"title": 'say "d"'})
    '<p title="say &quot;d&quot;">a &lt; b <em>c</em></p>'
    """
    attributes = "".join(f' {name}="{printable(escape(value))}"' for name, value in given.items())
    if tag in _EMPTY:
        return Html(f"<{tag}{attributes}>")
    return Html(f"<{tag}{attributes}>{joined(children)}</{tag}>")


def joined(parts: Iterable[str]) -> Html:
    """Texts and markup one after the other, as markup.

    >>> joined(["<", element("b", "x")])
    '&lt;<b>x</b>'
    """
    return Html("".join(map(_markup, parts)))


def _markup(text: str) -> str:
    """Markup as it is; any other text escaped, without characters that act unseen."""
    return text if isinstance(text, Html) else printable(escape(text))


def script(text: str) -> Html:
    r"""A script element; nothing in its text, a string or a comment, can end it.

    >>> script('"</script><!--"')
    '<script>"<\\/script><\\!--"</script>'
    """
    # In a script only these two sequences mean anything to HTML; a backslash before / or ! means
    # nothing to JavaScript.
    harmless = text.replace("</", "<\\/").replace("<!--", "<\\!--")
    return element("script", Html(harmless))


def data(text: str, identity: str) -> Html:
    """JSON in a script element of that id."""
    # In JSON a < can only stand within a string, where the escape means the same.
    harmless = text.replace("<", "\\u003c")
    return element("script", Html(harmless), given={"type": "application/json", "id": identity})


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
    """The numerators and denominators that were given names, so that one that occurs again is not
    written again."""

    given: dict[Box, Name] = field(default_factory=dict)

    def name(self, box: Box, letter: str) -> tuple[Name, bool]:
        """The name of a part, and whether it is new."""
        if box in self.given:
            return self.given[box], False
        count = 1 + sum(name.head.letters == letter for name in self.given.values())
        self.given[box] = Name(
            f"{letter}_{count}", Word(letter, upright=False), (Word(str(count), upright=False),)
        )
        return self.given[box], True


def display(formulas: Sequence[doc.Line], parts: Parts | None = None) -> Html:
    """The formulas in one block, aligned at their relations, which scrolls by itself where it is
    too wide.

    >>> from haptisym.kernel.rings import s
    >>> from haptisym.writing.document import Line
    >>> from haptisym.writing.layout import QUANTITIES
    >>> display([Line(QUANTITIES["H_env"][0], s)]).count("<mtr>")
    1
    """
    named = Parts() if parts is None else parts
    rows = ""
    for formula in formulas:
        for left, right in _rows(formula, named):
            cells = f"<mtd{_LEFT}>{left}</mtd><mtd{_LEFT}><mrow>{right}</mrow></mtd>"
            rows += f"<mtr{'' if left else _MORE}>{cells}</mtr>"
    table = f'<mtable displaystyle="true">{rows}</mtable>'
    whole = f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">{table}</math>'
    return element("div", Html(whole), given={"class": "scroll formulas"})


def inline(expression: Expr | Box) -> Html:
    """A formula within a line of text."""
    return Html(mathml(expression))


def _rows(f: doc.Line, parts: Parts) -> Iterator[tuple[str, str]]:
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


def _valued(
    left: str, relation: str, box: Box, room: float, parts: Parts
) -> Iterator[tuple[str, str]]:
    """The lines of a value; a quotient that is too wide has names for its parts, which follow."""
    # A sum of one term is a term with a minus.
    minus, quotient = (
        (_MINUS, box.terms[0][1]) if isinstance(box, Sum) and len(box.terms) == 1 else ("", box)
    )
    if not isinstance(quotient, Fraction) or _wide(box) <= room:
        yield from _broken(left, relation, box, room)
        return
    named = [
        (x, *parts.name(x, letter)) if _wide(x) > room - 2 else (x, x, False)
        for x, letter in ((quotient.above, "𝒩"), (quotient.below, "𝒟"))
    ]
    yield left, f"{relation}{minus}{markup(Fraction(named[0][1], named[1][1]))}"
    for part, name, is_new in named:
        if is_new:
            yield from _broken(markup(name), "<mo>=</mo>", part, room)


def _broken(left: str, relation: str, box: Box, room: float) -> Iterator[tuple[str, str]]:
    """A formula in as many lines as it needs; those after the first are set in."""
    first, *others = [markup(box)] if _wide(box) <= room else _lines(list(_pieces(box, 0)), room)
    yield left, relation + first
    for line in others:
        yield "", f'<mspace width="2em"/>{line}'


class _Piece(NamedTuple):
    """Markup that is not broken, its width in em, and how bad a break before it would be."""

    text: str
    width: float
    penalty: int


# More than the penalty of any break that is allowed: 1 for each pair of parentheses, 10 for a
# product.
_NEVER = 1000


def _pieces(box: Box, depth: int) -> Iterator[_Piece]:
    """A formula cut at its signs and between its factors, also within parentheses."""
    if isinstance(box, Sum):
        for i, (sign, term) in enumerate(box.terms):
            before = (
                (_PLUS if sign > 0 else _MINUS).replace("<mo>", _INFIX)
                if i
                else _MINUS
                if sign < 0
                else ""
            )
            yield from _after(before, depth, _pieces(term, depth))
    elif isinstance(box, SideBySide):
        for i, factor in enumerate(box.factors):
            dotted = i > 0 and needs_dot(box.factors[i - 1], factor)
            yield from _after(
                _DOT if dotted else _TIMES if i else "", depth + 10, _pieces(factor, depth)
            )
    elif isinstance(box, Fenced) and _wide(box) > ROOM / 4:
        yield from _fenced(_OPEN, list(_pieces(box.inside, depth + 1)), _CLOSE)
    elif isinstance(box, Absolute) and _wide(box) > ROOM:
        yield from _fenced(_BAR, list(_pieces(box.inside, depth + 1)), _BAR)
    else:
        yield _Piece(markup(box), _wide(box), _NEVER)


def _after(before: str, penalty: int, pieces: Iterable[_Piece]) -> Iterator[_Piece]:
    """The pieces with an operator in front, where a line may be broken."""
    first, *others = pieces
    yield _Piece(
        before + first.text, first.width + (1.2 if "+" in before or "−" in before else 0.0), penalty
    )
    yield from others


def _fenced(left: str, pieces: list[_Piece], right: str) -> Iterator[_Piece]:
    """The pieces with a fence before the first and after the last, which stay with them."""
    first, *others = pieces
    opened = [_Piece(left + first.text, first.width + 0.4, _NEVER), *others]
    yield from opened[:-1]
    yield _Piece(opened[-1].text + right, opened[-1].width + 0.4, opened[-1].penalty)


def _lines(pieces: list[_Piece], room: float) -> Iterator[str]:
    """The pieces on lines that are no wider than the room."""
    rest = room - 3  # the lines after the first one are set in
    while pieces:
        count = _fitting(pieces, room)
        line = "".join(piece.text for piece in pieces[:count])
        # A product's sign that is not seen would leave a line that seems to begin a new formula.
        if line.startswith(_TIMES):
            line = _CROSS + line.removeprefix(_TIMES)
        yield f"<mrow>{line}</mrow>"
        pieces, room = pieces[count:], rest


def _fitting(pieces: Sequence[_Piece], room: float) -> int:
    """How many pieces to put on a line: as many as fit, fewer if that breaks outside of
    parentheses."""
    ends: list[float] = []
    for piece in pieces:
        total = piece.width + (ends[-1] if ends else 0.0)
        if ends and total > room:
            break
        ends.append(total)
    if len(ends) == len(pieces):
        return len(ends)
    allowed = [n for n in range(1, len(ends) + 1) if pieces[n].penalty < _NEVER]
    # Half a line stays empty at most, where a break allows it. Among those the least penalty, then
    # the longest line.
    late = [n for n in allowed if ends[n - 1] > room / 2] or allowed[-1:] or [len(ends)]
    return min(late, key=lambda n: (pieces[n].penalty, -n))


_OPERATORS = re.compile(r"\\[a-z]*(?:sin|cos|tan)h?(?![a-z])")


def _wide(box: Box) -> float:
    """About how wide a box is, em; names of functions are words, with space around."""
    text = tex(box)
    return width(text) + 1.3 * len(_OPERATORS.findall(text))


_POLICY = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "base-uri 'none'; form-action 'none'"
)
"""Nothing is loaded; ``data:`` are the grounds of figures, which are part of the page."""


def html(
    document: Document, drawn: Callable[[doc.Figure], Html], record: tuple[str, str], made: str
) -> str:
    """The whole page, in full: it loads nothing from anywhere, and forbids itself to. Text of the
    scene stays text.

    ``drawn`` : how a figure is drawn within a page; ``record`` : a name and the document of
    ``to_json``, which is kept in the element of that name; ``made`` : by what the page was made.
    """
    style = Html((files("haptisym") / "data" / "report.css").read_text(encoding="utf-8"))
    head = element(
        "head",
        element("meta", given={"charset": "utf-8"}),
        element("meta", given={"http-equiv": "Content-Security-Policy", "content": _POLICY}),
        element(
            "meta", given={"name": "viewport", "content": "width=device-width, initial-scale=1"}
        ),
        element("meta", given={"name": "color-scheme", "content": "light dark"}),
        element("title", document.title),
        element("style", style),
    )
    document = document.prepared(full=True, live=True)
    kind = [element("p", document.kind, given={"class": "kind"})] if document.kind else []
    lead = [element("p", phrase(x), given={"class": "source"}) for x in document.lead]
    above = element("header", *kind, element("h1", document.title), *lead)
    inside = _Writer(drawn).joined(document.blocks)
    below = element("p", made, given={"class": "source"})
    body = element("body", element("main", above, inside, below, data(record[1], record[0])))
    return f"<!DOCTYPE html>\n{element('html', head, body, given={'lang': 'en'})}\n"


def fragment(document: Document, *, formulas: bool = False) -> str:
    """The page in brief, as one element for a notebook; ``formulas`` : with those of the answer."""
    document = document.prepared(full=False, formulas=formulas)
    title = element("p", element("strong", document.title))
    lead = [element("p", phrase(x)) for x in document.lead]
    inside = _Writer(_nothing).joined(document.blocks)
    return str(element("div", title, *lead, inside, given={"class": "haptisym"}))


def _nothing(_figure: doc.Figure) -> Html:
    """No markup in place of a figure: a page in brief has none."""
    return Html()


def phrase(words: Phrase) -> Html:
    """A phrase as markup.

    >>> from haptisym.writing.document import Number
    >>> phrase(("at ", Number("2.5", 2.5), " < 3"))
    'at <data value="2.5">2.5</data> &lt; 3'
    """
    if isinstance(words, tuple):
        return joined(map(phrase, words))
    if isinstance(words, str):
        return joined([words])
    if isinstance(words, doc.Real | doc.Frequency | doc.OfFrequency | doc.Brief):
        return phrase(doc.Style().phrase(words))
    if isinstance(words, doc.Number):
        return element("data", _wrapped(words.digits), given={"value": repr(words.value)})
    if isinstance(words, Strong):
        return element("strong", phrase(words.words))
    return element("code", words.text) if isinstance(words, doc.Code) else inline(words)


_LONG = 25  # characters of a number; a longer one is set on several lines


def _wrapped(digits: str) -> str:
    """The digits of a number; a long one in an element that lets it break anywhere."""
    return element("span", digits, given={"class": "long"}) if len(digits) > _LONG else digits


@dataclass(frozen=True)
class _Writer:
    """Markup of blocks. Named numerators and denominators are shared by all equations of a page."""

    drawn: Callable[[doc.Figure], Html]
    parts: Parts = field(default_factory=Parts)
    depth: int = 2

    def joined(self, blocks: Sequence[Block]) -> Html:
        """Blocks one after the other; small figures side by side."""
        written: list[Html] = []
        for is_pair, group in groupby(
            blocks, key=lambda x: isinstance(x, doc.Figure) and not x.wide
        ):
            inside = map(self.block, group)
            written += _paired(inside) if is_pair else inside
        return joined(written)

    @singledispatchmethod
    def block(self, block: Block) -> Html:
        """The markup of a block."""
        raise TypeError(f"not a block of HTML: {type(block).__name__}")

    @block.register
    def _(self, block: doc.Paragraph) -> Html:
        return element("p", phrase(block.words))

    @block.register
    def _(self, block: doc.Notes) -> Html:
        return joined(element("p", phrase(x)) for x in block.entries)

    @block.register
    def _(self, block: doc.Facts) -> Html:
        rows = (
            element("div", element("dt", phrase(x)), element("dd", phrase(y)))
            for x, y in block.rows
        )
        return element("dl", *rows, given={"class": block.role or "facts"})

    @block.register
    def _(self, block: doc.Flow) -> Html:
        return element(
            "ol", *(element("li", phrase(x)) for x in block.links), given={"class": "chain"}
        )

    @block.register
    def _(self, block: doc.Equations) -> Html:
        return display(block.lines, self.parts)

    @block.register
    def _(self, block: doc.Figure) -> Html:
        return self.drawn(block)

    @block.register
    def _(self, block: doc.Live) -> Html:
        return Html(block.markup())

    @block.register
    def _(self, block: doc.Section) -> Html:
        inside = _Writer(self.drawn, self.parts, self.depth + 1).joined(block.blocks)
        if not block.title:
            return inside
        heading = element(f"h{min(self.depth, 6)}", phrase(block.title))
        if not block.name:
            return joined([heading, inside])
        return element("section", heading, inside, given={"id": block.name})

    @block.register
    def _(self, block: doc.Table) -> Html:
        """It scrolls by itself where it is too wide."""
        shown = [
            [said(x.heading), *(said(row[i]) for row in block.rows)]
            for i, x in enumerate(block.columns)
        ]
        widths = [max(map(len, texts)) for texts in shown]
        # Where the row would be too long although its long columns break, shorter ones break too.
        needed = sum(_CUT if width > _WORDS else width for width in widths)
        most = _WORDS if needed <= _LINE else _TIGHT
        look = [_look(x, texts[1:], most) for x, texts in zip(block.columns, shown, strict=True)]
        columns = list(zip(block.columns, look, strict=True))
        head = element(
            "tr",
            *(element("th", phrase(x.heading), given={"scope": "col", **g}) for x, g in columns),
        )
        cells = [[*map(phrase, row)] for row in block.rows]
        for i, column in enumerate(block.columns):
            if column.number:
                _point([said(row[i]) for row in block.rows], cells, i)
        body = [
            element("tr", *(element("td", x, given=g) for x, g in zip(row, look, strict=True)))
            for row in cells
        ]
        title = [element("caption", phrase(block.caption))] if block.caption else []
        whole = element("table", *title, element("thead", head), element("tbody", *body))
        return element("div", whole, given={"class": "scroll"})


_WORDS, _TIGHT = 34, 18  # characters of a cell; columns with longer ones are set on several lines
# Characters of a row, beyond which _TIGHT holds; and what a column takes that is set on several
# lines.
_LINE, _CUT = 90, 24


def _look(column: doc.Column, shown: Sequence[str], most: int) -> dict[str, str]:
    """The class of a column's cells: of numbers, of words on several lines, or none."""
    if column.number:
        return {"class": "number"}
    longest = max(map(len, shown), default=0)
    if longest > _WORDS:
        return {"class": "words"}
    return {"class": "words tight"} if longest > most else {}


def _paired(figures: Iterable[Html]) -> Iterator[Html]:
    """The figures in one element, side by side."""
    yield element("div", *figures, given={"class": "pair"})


_DIGIT_SPACE = "\N{FIGURE SPACE}"


def _point(shown: Sequence[str], cells: list[list[Html]], i: int) -> None:
    """Move the numbers of a column to the right until their points stand below each other."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in shown]
    # A figure space is as wide as a digit. Numbers so long that they break are left alone.
    for row, n in zip(cells, before, strict=True):
        if 0 < n < max(before) <= _LONG:
            row[i] = joined([_DIGIT_SPACE * (max(before) - n), row[i]])
