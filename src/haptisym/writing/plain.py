"""A document as plain text, as wide as wanted: what a terminal shows, and what ``print`` shows of
an answer."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import singledispatchmethod
from itertools import zip_longest
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
    # Text of a scene must not move the cursor or start a line of its own.
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
    # A number that no page has settled yet is rounded as a page does it by default.
    if isinstance(phrase, doc.Real | doc.Frequency | doc.OfFrequency | doc.Brief):
        return said(doc.Style().phrase(phrase))
    if isinstance(phrase, doc.Number):
        return phrase.digits
    if isinstance(phrase, Strong):
        return said(phrase.words)
    if isinstance(phrase, doc.Code):
        return f"`{phrase.text}`"
    # ``text`` writes what a keyboard has. Signs count only between spaces: the ~ of a name stays.
    return re.sub(r"[A-Za-z]+|(?<= )[<>!]=(?= )|(?<= )~(?= )", _on_a_screen, text(phrase))


def _on_a_screen(word: re.Match[str]) -> str:
    """A Greek letter or relation as it is, not as a keyboard has it."""
    return _RELATIONS.get(word[0]) or letter(word[0])


@dataclass(frozen=True)
class _Writer:
    """The lines of blocks on a page of that many columns."""

    columns: int
    spell: Callable[[str], str]

    def filled(self, phrase: Phrase, first: str = "", rest: str | None = None) -> list[str]:
        """A phrase in lines; ``first`` and ``rest`` are what these begin with."""
        rest = first if rest is None else rest
        # ``wrap`` breaks at plain spaces only, so a no-break space keeps number and unit together;
        # on the page it is a space like any other.
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
        """The lines of blocks, with blank lines between them except between lists that belong
        together."""
        for before, block in zip((None, *blocks), blocks, strict=False):
            # A list belongs to the remarks before it and to another list of its kind; below the
            # answer at the head of a page something new begins.
            is_list = isinstance(block, doc.Equations | doc.Facts)
            is_alike = type(before) is type(block) and not (before and _is_answer(before))
            belongs = is_list and (isinstance(before, doc.Notes) or is_alike)
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
        lines: list[str] = []
        for line in block.lines:
            lines += self.filled(line.equation, _INDENT * 2, _INDENT * 4)
        return lines

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
                # Further lines of a formula are set in, so that they do not look like new ones.
                rest = " " * (after + 4 * _is_formula(words))
                yield from self.filled(words, f"{indent}{key}".ljust(after), rest)
            else:
                yield from self.filled(key, indent, indent + _INDENT)
                yield from self.filled(words, indent + _INDENT)

    @block.register
    def _(self, block: doc.Table, indent: str) -> Iterable[str]:
        heads = [self._cell(x.heading) for x in block.columns]
        cells = [[self._cell(x) for x in row] for row in block.rows]
        rows = _pointed(cells, [x.number for x in block.columns])
        gaps = _GAP * (len(heads) - 1)
        widths = widths_of([heads, *rows], self.columns - len(_INDENT) - gaps)
        # A list has the cells as they were: without columns there is nothing to align points in.
        if widths is None:
            return self._rows_listed(heads, cells)
        rule = _INDENT + self.spell("─") * (sum(widths) + gaps)
        lines = [*_laid(heads, widths), rule]
        for row in rows:
            lines += _laid(row, widths)
        return lines

    @block.register
    def _(self, block: doc.Flow, indent: str) -> Iterable[str]:
        chain: list[Phrase] = [x for link in block.links for x in (" → ", link)]
        return self.filled(tuple(chain[1:]), indent)

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
    """Whether a phrase begins with a formula."""
    first = phrase[0] if isinstance(phrase, tuple) and phrase else phrase
    return isinstance(first, Box)


def widths_of(rows: Sequence[Sequence[str]], room: int) -> list[int] | None:
    """Widths of the columns that fit into ``room`` characters, at least their longest words; None
    if there are none."""
    columns = list(zip(*rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    least = []
    for column, width in zip(columns, widths, strict=True):
        longest = max(len(word) for cell in column for word in cell.split(" "))
        # Eight characters at least, where the column has them: columns of short words would become
        # towers of one word a line.
        least.append(max(longest, min(width, 8)))
    # The widest column that can still give way does, one character at a time: so the room is shared
    # out evenly among the wide ones.
    while sum(widths) > room:
        i = max(range(len(widths)), key=lambda i: (widths[i] > least[i], widths[i]))
        if widths[i] <= least[i]:
            return None
        widths[i] -= 1
    return widths


def _pointed(rows: Sequence[Sequence[str]], numbers: Sequence[bool]) -> list[tuple[str, ...]]:
    """The rows with the decimal points of each column of numbers below each other."""
    if not rows:
        return []
    columns = zip(zip(*rows, strict=True), numbers, strict=True)
    moved = [_column(cells) if is_number else cells for cells, is_number in columns]
    return [*zip(*moved, strict=True)]


def _column(cells: Sequence[str]) -> list[str]:
    """Numbers moved to the right until their points stand below each other; what is no number stays
    as it is."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in cells]
    return [" " * (max(before) - n) + x if n else x for n, x in zip(before, cells, strict=True)]


def _laid(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """The lines of one row; a cell takes more than one where it must."""
    cells = [_filled(x, width) for x, width in zip(row, widths, strict=True)]
    # Cells with fewer lines than the tallest are blank below.
    for line in zip_longest(*cells, fillvalue=""):
        parts = [part.ljust(width) for part, width in zip(line, widths, strict=True)]
        yield (_INDENT + (" " * _GAP).join(parts)).replace("\xa0", " ").rstrip()


def _filled(cell: str, width: int) -> list[str]:
    """A cell in lines of that width."""
    # ``wrap`` would strip the spaces that align the points of numbers.
    if len(cell) <= width:
        return [cell]
    return wrap(cell, width, break_on_hyphens=False, break_long_words=False)
