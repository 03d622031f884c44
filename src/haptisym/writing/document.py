"""What a page says, before anyone decides how it is set: words with formulas and numbers among them, tables, figures.

A page is written once, as a ``Document``; the writers ``plain``, ``latex`` and ``html`` set it. Each has two lengths: *brief*
(a terminal, a notebook) and *in full* (a report), and a block may say different things in the two (``Versions``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

from sympy import Expr

from haptisym.writing.boxes import Box, Equation
from haptisym.writing.layout import layout

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True, slots=True)
class Number:
    """A number by its digits, and the nearest double for programs that read the page."""

    digits: str
    value: float


@dataclass(frozen=True, slots=True)
class Strong:
    """Words that must not be overlooked."""

    words: Phrase


@dataclass(frozen=True, slots=True)
class Code:
    """What is typed, letter by letter."""

    text: str


Phrase: TypeAlias = "str | Box | Number | Strong | Code | tuple[Phrase, ...]"
"""Words with formulas, numbers and emphasis among them; phrases are joined by putting them into a tuple."""


@dataclass(frozen=True)
class Paragraph:
    """Sentences that belong together."""

    words: Phrase


@dataclass(frozen=True)
class Notes:
    """Remarks, each on its own line."""

    entries: tuple[Phrase, ...]


@dataclass(frozen=True)
class Facts:
    """A list of what things are called and what they are; ``role`` : its class on a page of HTML."""

    rows: tuple[tuple[Phrase, Phrase], ...]
    role: str = ""


@dataclass(frozen=True)
class Flow:
    """What passes on to what, in order."""

    links: tuple[Phrase, ...]


@dataclass(frozen=True)
class Column:
    """A column of a table: its heading; whether it holds numbers; whether it is told in full only."""

    heading: Phrase
    number: bool = False
    full: bool = False


@dataclass(frozen=True)
class Table:
    """Rows below headings. ``caption`` : what a table is called in a report; text tells that in the section's title."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Phrase, ...], ...]
    caption: Phrase = ""

    def cut(self, *, full: bool) -> Table:
        """Without the columns that are told in full only, unless it is ``full``, and without those that say nothing."""
        kept = [i for i, column in enumerate(self.columns) if (full or not column.full) and not self._is_blank(i)]
        rows = tuple(tuple(row[i] for i in kept) for row in self.rows)
        return Table(tuple(self.columns[i] for i in kept), rows, self.caption)

    def _is_blank(self, i: int) -> bool:
        return is_empty(self.columns[i].heading) and all(is_empty(row[i]) for row in self.rows)


@dataclass(frozen=True)
class Line:
    """``left = value``, or ``left = meaning = value``, where an ``optional`` value is left out if it is long."""

    left: Box
    value: Expr | Box
    relation: str = "="
    meaning: Box | None = None
    optional: bool = False

    @property
    def equation(self) -> Equation:
        """As boxes, for text and MathML."""
        if self.meaning is None:
            return Equation((self.left, self.box), (self.relation,))
        return Equation((self.left, self.meaning, self.box), ("=", self.relation))

    @property
    def box(self) -> Box:
        """The value, set."""
        return layout(self.value) if isinstance(self.value, Expr) else self.value


@dataclass(frozen=True)
class Equations:
    """Equations below each other, aligned at their relations."""

    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Figure:
    """A drawing, in reports only: its name, what it shows, how it is made, and whether it takes the page's whole width."""

    name: str
    caption: Phrase
    draw: Callable[[], Canvas]
    wide: bool = False


@dataclass(frozen=True)
class Live:
    """Something that works on a page of HTML alone: its markup, made when it is wanted."""

    markup: Callable[[], str]


@dataclass(frozen=True)
class Versions:
    """What is said in brief, and what is said in full instead; that is made only when it is wanted."""

    brief: tuple[Block, ...] = ()
    full: Callable[[], Iterable[Block]] = tuple


@dataclass(frozen=True)
class Section:
    """Blocks below a heading; sections within it are its subsections."""

    title: Phrase
    blocks: tuple[Block, ...]
    name: str = ""
    """Its anchor on a page of HTML."""
    appendix: bool = False
    """Whether it stands behind the text in a document of LaTeX."""


Block: TypeAlias = Paragraph | Notes | Facts | Flow | Table | Equations | Figure | Live | Versions | Section


@dataclass(frozen=True)
class Document:
    """A page: its title, lines below it that say where that comes from, and what it says."""

    title: str
    lead: tuple[Phrase, ...]
    blocks: tuple[Block, ...]
    kind: str = ""
    """What a report calls itself, above its title."""


def chosen(blocks: Iterable[Block], *, full: bool, live: bool = False) -> Iterator[Block]:
    """The blocks as they are told in full, or in brief; ``live`` : with what works on a page. What holds nothing is left out."""
    for block in blocks:
        if isinstance(block, Versions):
            yield from chosen(block.full() if full else block.brief, full=full, live=live)
        elif isinstance(block, Section):
            if inside := tuple(chosen(block.blocks, full=full, live=live)):
                yield replace(block, blocks=inside)
        elif isinstance(block, Table):
            yield block.cut(full=full)
        elif live if isinstance(block, Live) else full or not isinstance(block, Figure):
            yield block


def figures_of(blocks: Iterable[Block]) -> Iterator[Figure]:
    """All figures that a report shows."""
    for block in chosen(blocks, full=True):
        if isinstance(block, Section):
            yield from figures_of(block.blocks)
        elif isinstance(block, Figure):
            yield block


def is_empty(phrase: Phrase) -> TypeGuard[Any]:
    """Whether a phrase says nothing."""
    return phrase == "" or (isinstance(phrase, tuple) and all(map(is_empty, phrase)))


def listed(phrases: Iterable[Phrase], word: str = "and") -> Phrase:
    """Phrases in a sentence: "one, two and three"; nothing for none."""
    found = list(phrases)
    between = [*[", "] * (len(found) - 2), *[f" {word} "] * (len(found) > 1), *[""] * bool(found)]
    return tuple(x for pair in zip(found, between, strict=True) for x in pair if x != "")


def coded(words: str) -> Phrase:
    """Words in which what stands between backticks is code."""
    return tuple(Code(x) if i % 2 else x for i, x in enumerate(words.split("`")) if x)
