"""A page before anyone decides how it is set: words with formulas and numbers among them, tables,
figures.

A page is written once, as a ``Document``; the writers ``plain``, ``latex`` and ``html`` set it.
Each has two lengths, *brief* (a terminal, a notebook) and *in full* (a report), and a block may be
different in the two (``Versions``).

A page holds numbers, not digits: a ``Real`` is exact and has the direction in which it may be
rounded, a ``Frequency`` has no unit yet. ``Document.prepared`` rounds each once, to the digits that
were asked for, and puts frequencies into the scene's unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

from sympy import Expr, pi

from haptisym.kernel.reals import Printable, Way, in_unit, printed
from haptisym.model.quantities import RADIANS, Unit
from haptisym.writing.boxes import Box, Relation
from haptisym.writing.layout import layout, named

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True, slots=True)
class Number:
    """A number by its digits, and the nearest double for programs that read the page."""

    digits: str
    value: float


@dataclass(frozen=True, slots=True)
class Real:
    """A number that is rounded where the page is written; ``least`` : digits that it needs, as
    others would look the same.

    ``most`` : digits that it has, of an estimate. ``unit`` : in which it is printed, and which is
    printed behind it.
    """

    value: Printable
    way: Way
    least: int = 1
    unit: Unit = Unit("")
    most: int = 1000


@dataclass(frozen=True, slots=True)
class Frequency:
    """A frequency, given in rad/s: printed in the page's unit, in rad/s with Hz in brackets.

    ``alone`` : the number without its unit, which stands in the heading or behind it.
    """

    value: Printable
    way: Way
    least: int = 1
    alone: bool = False


@dataclass(frozen=True, slots=True)
class OfFrequency:
    """What depends on the page's unit of frequency: ``unit``, its name; ``symbol``, omega or f."""

    of: str


FREQUENCY_UNIT, FREQUENCY = OfFrequency("unit"), OfFrequency("symbol")
"""The name of the page's unit of frequency, and the symbol of what is measured in it."""


@dataclass(frozen=True, slots=True)
class Strong:
    """Words that must not be overlooked."""

    words: Phrase


@dataclass(frozen=True, slots=True)
class Code:
    """What is typed, letter by letter."""

    text: str


@dataclass(frozen=True, slots=True)
class Brief:
    """Words that only a page in brief has: what to type next, which no reader of a report can."""

    words: Phrase


DIGITS = 4
"""The digits of a page's numbers where no others are asked for."""
Phrase: TypeAlias = (
    "str | Box | Number | Real | Frequency | OfFrequency | Strong | Code | Brief "
    "| tuple[Phrase, ...]"
)
"""Words with formulas, numbers and emphasis among them; phrases are joined by putting them into a
tuple."""


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
    """A list of what things are called and what they are; ``role`` : its class on a page of
    HTML."""

    rows: tuple[tuple[Phrase, Phrase], ...]
    role: str = ""


@dataclass(frozen=True)
class Flow:
    """What passes on to what, in order."""

    links: tuple[Phrase, ...]


@dataclass(frozen=True)
class Column:
    """A column of a table: its heading; whether it holds numbers; whether it is there in full only.

    ``hertz`` : of frequencies, whose heading ends with the page's unit; where that is rad/s a
    column in Hz follows.
    """

    heading: Phrase
    number: bool = False
    full: bool = False
    hertz: bool = False


@dataclass(frozen=True)
class Table:
    """Rows below headings. ``caption`` : what a table is called in a report; in text the section's
    title has it. ``main`` : whether it goes into a paper though it is not the first of its page."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Phrase, ...], ...]
    caption: Phrase = ""
    main: bool = False

    def cut(self, *, full: bool) -> Table:
        """The table without the columns that are there in full only, unless it is ``full``, and
        without empty ones."""
        wanted = [i for i, column in enumerate(self.columns) if full or not column.full]
        kept = [i for i in wanted if not self._is_blank(i)]
        rows = tuple(tuple(row[i] for i in kept) for row in self.rows)
        return replace(self, columns=tuple(self.columns[i] for i in kept), rows=rows)

    def _is_blank(self, i: int) -> bool:
        """Whether a column holds nothing, not even a heading."""
        return is_empty(self.columns[i].heading) and all(is_empty(row[i]) for row in self.rows)


@dataclass(frozen=True)
class Line:
    """``left = value``, or ``left = meaning = value``, where an ``optional`` value is left out if
    it is long."""

    left: Box
    value: Expr | Box
    relation: str = "="
    meaning: Box | None = None
    optional: bool = False

    @property
    def equation(self) -> Relation:
        """The equation as boxes, for text and MathML."""
        if self.meaning is None:
            return Relation((self.left, self.box), (self.relation,))
        return Relation((self.left, self.meaning, self.box), ("=", self.relation))

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
    """A drawing, in reports only: its name, what it shows, how it is made, and whether it takes the
    page's whole width."""

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
    """What a page has in brief, and what it has in full instead; that is made only when it is
    wanted."""

    brief: tuple[Block, ...] = ()
    full: Callable[[], Iterable[Block]] = tuple


@dataclass(frozen=True)
class Formulas:
    """What a page in brief has only where formulas are asked for, and what it has ``otherwise``."""

    blocks: Callable[[], Iterable[Block]]
    otherwise: Iterable[Block] = ()


@dataclass(frozen=True)
class Section:
    """Blocks below a heading; sections within it are its subsections."""

    title: Phrase
    blocks: tuple[Block, ...]
    name: str = ""
    """Its anchor on a page of HTML."""
    appendix: bool = False
    """Whether it stands behind the text in a document of LaTeX."""


Block: TypeAlias = (
    Paragraph
    | Notes
    | Facts
    | Flow
    | Table
    | Equations
    | Figure
    | Live
    | Versions
    | Formulas
    | Section
)


@dataclass(frozen=True)
class Document:
    """A page: its title, lines below it, and what it has."""

    title: str
    lead: tuple[Phrase, ...]
    blocks: tuple[Block, ...]
    kind: str = ""
    """What a report calls itself, above its title."""
    frequency: Unit = RADIANS
    """The unit in which frequencies are printed."""

    def prepared(
        self,
        *,
        full: bool,
        live: bool = False,
        digits: int = DIGITS,
        formulas: bool = False,
        typed: bool = True,
    ) -> Document:
        """The page as it is written, in full or in brief: its numbers rounded; ``live`` : with what
        works on a page of HTML; ``typed`` : in brief, with what to type next."""
        style = Style(full, live, digits, formulas, self.frequency, typed)
        return replace(
            self, lead=tuple(map(style.phrase, self.lead)), blocks=tuple(style.chosen(self.blocks))
        )

    def figures(self) -> Iterator[Figure]:
        """All figures that a report has."""
        return _figures(self.prepared(full=True).blocks)


def _figures(blocks: Iterable[Block]) -> Iterator[Figure]:
    """All figures of blocks, also of those within sections."""
    for block in blocks:
        if isinstance(block, Section):
            yield from _figures(block.blocks)
        elif isinstance(block, Figure):
            yield block


@dataclass(frozen=True)
class Style:
    """How a page is prepared: see ``Document.prepared``."""

    full: bool = False
    live: bool = False
    digits: int = DIGITS
    formulas: bool = False
    frequency: Unit = RADIANS
    typed: bool = True

    def chosen(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """The blocks that the page has, their numbers rounded; what holds nothing is left out."""
        # Versions and formulas are functions, so that what is not wanted is never made.
        for block in blocks:
            if isinstance(block, Versions):
                yield from self.chosen(block.full() if self.full else block.brief)
            elif isinstance(block, Formulas):
                yield from self.chosen(
                    block.blocks() if self.full or self.formulas else block.otherwise
                )
            elif isinstance(block, Section):
                if inside := tuple(self.chosen(block.blocks)):
                    yield replace(block, title=self.phrase(block.title), blocks=inside)
            elif (
                self.live if isinstance(block, Live) else self.full or not isinstance(block, Figure)
            ):
                yield self._settled(block)

    def _settled(self, block: Block) -> Block:
        """A block with its numbers rounded; what is none of these holds no phrase to round."""
        if isinstance(block, Table):
            return self._table(block)
        if isinstance(block, Paragraph):
            return Paragraph(self.phrase(block.words))
        if isinstance(block, Notes):
            entries = map(self.phrase, block.entries)
            return Notes(tuple(x for x in entries if not is_empty(x)))
        if isinstance(block, Facts):
            return replace(
                block, rows=tuple((self.phrase(x), self.phrase(y)) for x, y in block.rows)
            )
        if isinstance(block, Flow):
            return Flow(tuple(map(self.phrase, block.links)))
        return (
            replace(block, caption=self.phrase(block.caption))
            if isinstance(block, Figure)
            else block
        )

    def _table(self, table: Table) -> Table:
        """Its numbers rounded, frequencies of rad/s in two columns."""
        columns: list[Column] = []
        rows: list[list[Phrase]] = [[] for _ in table.rows]
        two = self.frequency == RADIANS
        for i, column in enumerate(table.columns):
            heading = column.heading
            if column.hertz:
                heading = (column.heading, " (", FREQUENCY_UNIT, ")")
            # The unit is in the heading now: a table that is settled again gets no second one.
            columns.append(replace(column, heading=self.phrase(heading), hertz=False))
            columns += [Column("Hz", number=True, full=column.full)] * (column.hertz and two)
            for row, cells in zip(table.rows, rows, strict=True):
                cells.append(self.phrase(row[i]))
                if column.hertz and two:
                    cells.append(self._hertz(row[i]))
        words = tuple(columns), tuple(map(tuple, rows)), self.phrase(table.caption)
        return Table(*words, table.main).cut(full=self.full)

    def _hertz(self, cell: Phrase) -> Phrase:
        """The frequency of a cell in Hz."""
        return (
            self._real(Real(in_unit(cell.value, _HERTZ), cell.way, cell.least))
            if isinstance(cell, Frequency)
            else ""
        )

    def phrase(self, words: Phrase) -> Phrase:
        """A phrase with its numbers rounded and its frequencies in the page's unit."""
        if isinstance(words, tuple):
            return tuple(map(self.phrase, words))
        if isinstance(words, Real):
            return self._real(words)
        if isinstance(words, Frequency):
            return self._frequency(words)
        if isinstance(words, OfFrequency):
            is_omega = self.frequency == RADIANS
            return (
                self.frequency.text if words.of == "unit" else named("omega" if is_omega else "f")
            )
        if isinstance(words, Brief):
            return self.phrase(words.words) if self.typed and not self.full else ""
        return Strong(self.phrase(words.words)) if isinstance(words, Strong) else words

    def _real(self, x: Real) -> Phrase:
        """A number, rounded in its direction, with its unit."""
        # Rounded once, from the exact number in the unit that is printed: twice could pass a bound.
        value = in_unit(x.value, x.unit.size)
        number = Number(
            printed(value, min(max(self.digits, x.least), x.most), x.way), float(x.value)
        )
        return (number, f"\xa0{x.unit.text}") if x.unit.text else number

    def _frequency(self, x: Frequency) -> Phrase:
        """A frequency in the page's unit; in rad/s with Hz in brackets, unless it is 0."""
        shown = self._real(Real(in_unit(x.value, self.frequency.size), x.way, x.least))
        if x.alone:
            return shown
        if self.frequency != RADIANS or float(x.value) == 0:
            return shown, f"\xa0{self.frequency.text}"
        return shown, f"\xa0{self.frequency.text} (", self._hertz(x), "\xa0Hz)"


_HERTZ = 2 * pi


def is_empty(phrase: Phrase) -> TypeGuard[Any]:
    """Whether a phrase holds nothing."""
    return phrase == "" or (isinstance(phrase, tuple) and all(map(is_empty, phrase)))


def listed(phrases: Iterable[Phrase], word: str = "and") -> Phrase:
    """Phrases in a sentence: "one, two and three"; nothing for none."""
    items = list(phrases)
    # What stands behind each: commas, the word behind the last but one, nothing behind the last.
    after = [*[", "] * (len(items) - 2), *[f" {word} "] * (len(items) > 1), *[""] * bool(items)]
    return tuple(x for pair in zip(items, after, strict=True) for x in pair if x != "")


_LEADS_ON = re.compile(r"(; [^;`]*`haptisym [^`]*`[^.;`]*)(?=\.)")


def coded(words: str) -> Phrase:
    """Words in which what stands between backticks is code; a last clause with a command of
    haptisym is for a page in brief alone.

    >>> coded("nominal values; see `haptisym tolerances`.")
    (('nominal values',), Brief(words=('; see ', Code(text='haptisym tolerances'))), ('.',))
    """

    def typed(part: str) -> Phrase:
        return tuple(Code(x) if i % 2 else x for i, x in enumerate(part.split("`")) if x)

    first, *others = _LEADS_ON.split(words, maxsplit=1)
    return (typed(first), Brief(typed(others[0])), typed(others[1])) if others else typed(first)
