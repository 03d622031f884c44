"""A document as plain text, as wide as wanted: what a terminal shows, and what ``print`` shows of
an answer."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import singledispatchmethod
from textwrap import wrap

from haptisym.writing import document as doc
from haptisym.writing.boxes import Box, text
from haptisym.writing.characters import printable
from haptisym.writing.document import Block, Document, Phrase, Strong
from haptisym.writing.layout import letter

PAGE = 80
"""Columns of a page that goes to no terminal, so that it can be compared."""
WIDEST = 96
"""Columns of a page at most, however wide the terminal."""
NARROWEST = 40
_ROOM = 22
"""Columns that must be left beside a key; with fewer, what it says stands below it."""
_GAP = 3  # between columns of a table
_INDENT = "  "
_RELATIONS = {"<=": "≤", ">=": "≥", "!=": "≠", "~": "≈"}
NUMBER = re.compile(r"[=+-]?[\d,]+")
"""What stands before the point of a number; = marks an end that is reached."""


def plain(
    document: Document,
    columns: int = PAGE,
    spell: Callable[[str], str] = str,
    *,
    digits: int = doc.DIGITS,
    formulas: bool = False,
) -> str:
    """The page in brief, in lines of at most so many columns (but of 40 at least; a single word or
    number is never broken).

    ``spell`` : how words are spelt in the characters that there are. ``digits`` : of its
    numbers. ``formulas`` : whether it has them.

    >>> from haptisym.writing.document import Document, Paragraph, Section
    >>> print(plain(Document("A title", (), (Section("When?", (Paragraph("Never on this band."),)),)), 40))
    A title
    <BLANKLINE>
    When?
    <BLANKLINE>
      Never on this band.
    <BLANKLINE>
    """
    writer = _Writer(
        max(columns, NARROWEST), lambda words: spell(" ".join(printable(words).splitlines()))
    )
    document = document.prepared(full=False, digits=digits, formulas=formulas)
    head = [line for x in (document.title, *document.lead) if x for line in writer.filled(x)]
    blocks = document.blocks
    return "\n".join([*head, "", *writer.blocks(blocks, "")]) + "\n"


def said(phrase: Phrase) -> str:
    """A phrase as plain text.

    >>> from haptisym.writing.document import Number
    >>> from haptisym.writing.layout import named
    >>> said(("at ", named("omega"), " = ", Number("2.5", 2.5)))
    'at ω = 2.5'
    """
    if isinstance(phrase, tuple):
        return "".join(map(said, phrase))
    if isinstance(phrase, str):
        return phrase
    if isinstance(phrase, doc.Real | doc.Frequency | doc.OfFrequency):
        return said(doc.Style().phrase(phrase))
    if isinstance(phrase, doc.Number):
        return phrase.digits
    if isinstance(phrase, Strong):
        return said(phrase.words)
    if isinstance(phrase, doc.Code):
        return f"`{phrase.text}`"
    return re.sub(r"[A-Za-z]+|(?<= )[<>!]=(?= )|(?<= )~(?= )", _on_a_screen, text(phrase))


def _on_a_screen(word: re.Match[str]) -> str:
    """Greek letters and relations as they are, not as a keyboard has them."""
    return _RELATIONS.get(word[0]) or letter(word[0])


@dataclass(frozen=True)
class _Writer:
    """The lines of blocks on a page of that many columns."""

    columns: int
    spell: Callable[[str], str]

    def filled(self, phrase: Phrase, first: str = "", rest: str | None = None) -> list[str]:
        """A phrase in lines; ``first`` and ``rest`` are what these begin with."""
        rest = first if rest is None else rest
        lines = wrap(
            self._cell(phrase),
            self.columns,
            initial_indent=first,
            subsequent_indent=rest,
            break_long_words=False,
            break_on_hyphens=False,
        )
        return [line.replace("\xa0", " ") for line in lines]

    def blocks(self, blocks: Sequence[Block], indent: str) -> Iterator[str]:
        """Blank lines stand between them, except between lists that belong together."""
        for before, block in zip((None, *blocks), blocks, strict=False):
            belongs = isinstance(before, doc.Notes) and isinstance(block, doc.Equations | doc.Facts)
            belongs |= (
                type(before) is type(block)
                and isinstance(block, doc.Equations | doc.Facts)
                and not _is_answer(before)
            )
            if before is not None and not belongs:
                yield ""
            yield from self.block(block, indent)

    @singledispatchmethod
    def block(self, block: Block, indent: str) -> Iterable[str]:
        """The lines of a block."""
        raise TypeError(f"not a block of text: {type(block).__name__}")

    @block.register
    def _(self, block: doc.Paragraph, indent: str) -> Iterable[str]:
        return self.filled(block.words, indent)

    @block.register
    def _(self, block: doc.Notes, indent: str) -> Iterable[str]:
        return [line for entry in block.entries for line in self.filled(entry, indent)]

    @block.register
    def _(self, block: doc.Equations, indent: str) -> Iterable[str]:
        return [
            line for x in block.lines for line in self.filled(x.equation, _INDENT * 2, _INDENT * 4)
        ]

    @block.register
    def _(self, block: doc.Section, indent: str) -> Iterable[str]:
        if block.title:
            yield from self.filled(block.title, indent)
            if not isinstance(block.blocks[0], doc.Notes | doc.Equations | doc.Facts):
                yield ""
        yield from self.blocks(block.blocks, _INDENT if block.title else indent)

    @block.register
    def _(self, block: doc.Facts, indent: str) -> Iterable[str]:
        keys = [self.spell(said(key)) for key, _ in block.rows]
        indent = "" if _is_answer(block) else _INDENT
        after = len(indent) + max(map(len, keys), default=0) + 2
        for key, (_, words) in zip(keys, block.rows, strict=True):
            if self.columns - after >= _ROOM:
                yield from self.filled(
                    words, f"{indent}{key}".ljust(after), " " * (after + 4 * _is_formula(words))
                )
            else:
                yield from self.filled(key, indent, indent + _INDENT)
                yield from self.filled(words, indent + _INDENT)

    @block.register
    def _(self, block: doc.Table, indent: str) -> Iterable[str]:
        heads = [self._cell(x.heading) for x in block.columns]
        told = [[self._cell(x) for x in row] for row in block.rows]
        rows = _pointed(told, [x.number for x in block.columns])
        widths = widths_of([heads, *rows], self.columns - len(_INDENT) - _GAP * (len(heads) - 1))
        if widths is None:
            return self._rows_listed(heads, told)
        laid = [[*_laid(row, widths)] for row in (heads, *rows)]
        rule = _INDENT + self.spell("─") * (sum(widths) + _GAP * (len(widths) - 1))
        return [*laid[0], rule, *(line for row in laid[1:] for line in row)]

    @block.register
    def _(self, block: doc.Flow, indent: str) -> Iterable[str]:
        return self.filled(tuple(x for link in block.links for x in (" → ", link))[1:], indent)

    def _cell(self, phrase: Phrase) -> str:
        """A phrase; what must stay on one line holds no plain space."""
        return _PERCENT.sub("\xa0%", self.spell(said(phrase)))

    def _rows_listed(self, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
        """A table that has no room: each row as a list of what it says."""
        for n, row in enumerate(rows):
            if n:
                yield ""
            for head, cell in zip(heads, row, strict=True):
                if cell:
                    yield from self.filled(
                        f"{head}: {cell}" if head else cell, _INDENT, _INDENT * 2
                    )


def _is_answer(block: Block) -> bool:
    """Whether it is the lines of answer at the head of a page."""
    return isinstance(block, doc.Facts) and block.role == "findings"


_PERCENT = re.compile(r"(?<=\d) %")


def _is_formula(phrase: Phrase) -> bool:
    first = phrase[0] if isinstance(phrase, tuple) and phrase else phrase
    return isinstance(first, Box)


def widths_of(rows: Sequence[Sequence[str]], room: int) -> list[int] | None:
    """Widths of the columns that fit, at least their longest words; None if there are none."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    words = [
        [len(word) for cell in column for word in cell.split(" ")]
        for column in zip(*rows, strict=True)
    ]
    least = [
        max(max(lengths, default=0), min(w, 8)) for lengths, w in zip(words, wide, strict=True)
    ]
    while sum(wide) > room:
        i = max(range(len(wide)), key=lambda i: (wide[i] > least[i], wide[i]))
        if wide[i] <= least[i]:
            return None
        wide[i] -= 1
    return wide


def _pointed(rows: Sequence[Sequence[str]], numbers: Sequence[bool]) -> list[tuple[str, ...]]:
    """The rows with the decimal points of each column of numbers below each other."""
    if not rows:
        return []
    columns = [
        _column(cells) if is_number else cells
        for cells, is_number in zip(zip(*rows, strict=True), numbers, strict=True)
    ]
    return [*zip(*columns, strict=True)]


def _column(cells: Sequence[str]) -> list[str]:
    """Numbers moved to the right until their points stand below each other; what is no number stays
    as it is."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in cells]
    return [" " * (max(before) - n) + x if n else x for n, x in zip(before, cells, strict=True)]


def _laid(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """The lines of one row; a cell takes more than one where it must."""
    cells = [_filled(x, width) for x, width in zip(row, widths, strict=True)]
    for i in range(max(map(len, cells), default=0)):
        parts = [
            (cell[i] if i < len(cell) else "").ljust(width)
            for cell, width in zip(cells, widths, strict=True)
        ]
        yield (_INDENT + (" " * _GAP).join(parts)).replace("\xa0", " ").rstrip()


def _filled(cell: str, width: int) -> list[str]:
    return (
        [cell]
        if len(cell) <= width
        else wrap(cell, width, break_on_hyphens=False, break_long_words=False)
    )
