"""A document as a page of HTML that loads nothing from anywhere, and as a piece of one for notebooks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import singledispatchmethod
from importlib.resources import files
from itertools import groupby

from haptisym.writing.document import (
    Block,
    Code,
    Column,
    Document,
    Equations,
    Facts,
    Figure,
    Flow,
    Live,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    chosen,
)
from haptisym.writing.htmltext import Html, data, element, joined
from haptisym.writing.mathematics import Parts, display, inline
from haptisym.writing.plain import NUMBER, said

_POLICY = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
    "base-uri 'none'; form-action 'none'"
)
"""Nothing is loaded; ``data:`` are the grounds of figures, which are part of the page."""


def html(document: Document, drawn: Callable[[Figure], Html], record: tuple[str, str], made: str) -> str:
    """The whole page, in full: it loads nothing from anywhere, and forbids itself to. Text of the scene stays text.

    ``drawn`` : how a figure is drawn within a page; ``record`` : a name and the document of ``to_json``, which is kept in the
    element of that name; ``made`` : by what the page was made.
    """
    style = Html((files("haptisym") / "data" / "report.css").read_text(encoding="utf-8"))
    head = element(
        "head", element("meta", given={"charset": "utf-8"}),
        element("meta", given={"http-equiv": "Content-Security-Policy", "content": _POLICY}),
        element("meta", given={"name": "viewport", "content": "width=device-width, initial-scale=1"}),
        element("meta", given={"name": "color-scheme", "content": "light dark"}),
        element("title", document.title), element("style", style),
    )  # fmt: skip
    kind = [element("p", document.kind, given={"class": "kind"})] if document.kind else []
    lead = [element("p", phrase(x), given={"class": "source"}) for x in document.lead]
    above = element("header", *kind, element("h1", document.title), *lead)
    inside = _Writer(drawn).joined(list(chosen(document.blocks, full=True, live=True)))
    below = element("p", made, given={"class": "source"})
    body = element("body", element("main", above, inside, below, data(record[1], record[0])))
    return f"<!DOCTYPE html>\n{element('html', head, body, given={'lang': 'en'})}\n"


def fragment(document: Document) -> str:
    """The page in brief, as one element for a notebook."""
    title = element("p", element("strong", document.title))
    lead = [element("p", phrase(x)) for x in document.lead]
    inside = _Writer(_nothing).joined(list(chosen(document.blocks, full=False)))
    return str(element("div", title, *lead, inside, given={"class": "haptisym"}))


def _nothing(_figure: Figure) -> Html:
    return Html()


def phrase(words: Phrase) -> Html:
    """A phrase as markup.

    >>> phrase(("at ", Number("2.5", 2.5), " < 3"))
    'at <data value="2.5">2.5</data> &lt; 3'
    """
    if isinstance(words, tuple):
        return joined(map(phrase, words))
    if isinstance(words, str):
        return joined([words])
    if isinstance(words, Number):
        return element("data", _wrapped(words.digits), given={"value": repr(words.value)})
    if isinstance(words, Strong):
        return element("strong", phrase(words.words))
    return element("code", words.text) if isinstance(words, Code) else inline(words)


_LONG = 25  # characters of a number; a longer one is set on several lines


def _wrapped(digits: str) -> str:
    return element("span", digits, given={"class": "long"}) if len(digits) > _LONG else digits


@dataclass(frozen=True)
class _Writer:
    """Markup of blocks. Named numerators and denominators are shared by all equations of a page."""

    drawn: Callable[[Figure], Html]
    parts: Parts = field(default_factory=Parts)
    depth: int = 2

    def joined(self, blocks: Sequence[Block]) -> Html:
        """Blocks one after the other; small figures side by side."""
        return joined(
            x
            for is_pair, group in groupby(blocks, key=lambda x: isinstance(x, Figure) and not x.wide)
            for x in (_paired(map(self.block, group)) if is_pair else map(self.block, group))
        )

    @singledispatchmethod
    def block(self, block: Block) -> Html:
        """The markup of a block."""
        raise TypeError(f"not a block of HTML: {type(block).__name__}")

    @block.register
    def _(self, block: Paragraph) -> Html:
        return element("p", phrase(block.words))

    @block.register
    def _(self, block: Notes) -> Html:
        return joined(element("p", phrase(x)) for x in block.entries)

    @block.register
    def _(self, block: Facts) -> Html:
        rows = (element("div", element("dt", phrase(x)), element("dd", phrase(y))) for x, y in block.rows)
        return element("dl", *rows, given={"class": block.role or "facts"})

    @block.register
    def _(self, block: Flow) -> Html:
        return element("ol", *(element("li", phrase(x)) for x in block.links), given={"class": "chain"})

    @block.register
    def _(self, block: Equations) -> Html:
        return display(block.lines, self.parts)

    @block.register
    def _(self, block: Figure) -> Html:
        return self.drawn(block)

    @block.register
    def _(self, block: Live) -> Html:
        return Html(block.markup())

    @block.register
    def _(self, block: Section) -> Html:
        inside = _Writer(self.drawn, self.parts, self.depth + 1).joined(block.blocks)
        if not block.title:
            return inside
        heading = element(f"h{min(self.depth, 6)}", phrase(block.title))
        if not block.name:
            return joined([heading, inside])
        return element("section", heading, inside, given={"id": block.name})

    @block.register
    def _(self, block: Table) -> Html:
        """It scrolls by itself where it is too wide."""
        shown = [[said(x.heading), *(said(row[i]) for row in block.rows)] for i, x in enumerate(block.columns)]
        widths = [max(map(len, x)) for x in shown]
        most = _WORDS if sum(_CUT if x > _WORDS else x for x in widths) <= _LINE else _TIGHT
        look = [_look(x, own[1:], most) for x, own in zip(block.columns, shown, strict=True)]
        columns = list(zip(block.columns, look, strict=True))
        head = element("tr", *(element("th", phrase(x.heading), given={"scope": "col", **g}) for x, g in columns))
        cells = [[*map(phrase, row)] for row in block.rows]
        for i, column in enumerate(block.columns):
            if column.number:
                _point([said(row[i]) for row in block.rows], cells, i)
        body = [element("tr", *(element("td", x, given=g) for x, g in zip(row, look, strict=True))) for row in cells]
        title = [element("caption", phrase(block.caption))] if block.caption else []
        whole = element("table", *title, element("thead", head), element("tbody", *body))
        return element("div", whole, given={"class": "scroll"})


_WORDS, _TIGHT = 34, 18  # characters of a cell; columns with longer ones are set on several lines
_LINE, _CUT = (
    90,
    24,
)  # characters of a row, where the second number holds if they are more; and what such a column takes


def _look(column: Column, shown: Sequence[str], most: int) -> dict[str, str]:
    if column.number:
        return {"class": "number"}
    longest = max(map(len, shown), default=0)
    if column.full or longest > _WORDS:
        return {"class": "words"}
    return {"class": "words tight"} if longest > most else {}


def _paired(figures: Iterable[Html]) -> Iterator[Html]:
    yield element("div", *figures, given={"class": "pair"})


_DIGIT_SPACE = "\N{FIGURE SPACE}"


def _point(shown: Sequence[str], cells: list[list[Html]], i: int) -> None:
    """Move the numbers of a column to the right until their points stand below each other."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in shown]
    for row, n in zip(cells, before, strict=True):
        if 0 < n < max(before) <= _LONG:
            row[i] = joined([_DIGIT_SPACE * (max(before) - n), row[i]])
