r"""A document in LaTeX, for pdflatex with article, amsmath and booktabs (graphicx for figures); plain ASCII."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import singledispatchmethod
from itertools import accumulate, groupby
from types import MappingProxyType

from haptisym.writing.document import (
    Block,
    Code,
    Document,
    Equations,
    Facts,
    Figure,
    Flow,
    Notes,
    Number,
    Paragraph,
    Phrase,
    Section,
    Strong,
    Table,
    chosen,
)
from haptisym.writing.plain import NUMBER, said, widths_of
from haptisym.writing.texlines import Names, align
from haptisym.writing.texnames import escape, spaced
from haptisym.writing.texprinter import tex

_NONE: Mapping[str, str] = MappingProxyType({})
_TEMPLATE = r"""\documentclass[a4paper]{article}
\usepackage[margin=2.5cm]{geometry}
\usepackage{amsmath}
\usepackage{array}
\usepackage{booktabs}
%s\allowdisplaybreaks
\emergencystretch=3em
\setlength{\parindent}{0pt}
\setlength{\parskip}{\medskipamount}
\setlength{\abovecaptionskip}{0pt}
\setlength{\belowcaptionskip}{1ex}
\renewcommand{\topfraction}{0.9}
\renewcommand{\textfraction}{0.05}
\renewcommand{\floatpagefraction}{0.85}
%s
\title{%s}
\author{}
\date{\today}

\begin{document}

\maketitle

%s

\end{document}
"""


def latex(document: Document, figures: Mapping[str, str] = _NONE) -> str:
    """The whole document, in full. ``figures`` : the files of its figures, by their names; others are left out.

    >>> latex(Document("A title", (), (Paragraph("5 % more"),))).count("5 \\\\% more")
    1
    """
    kind, title = escape(document.kind), escape(document.title)
    graphics = "\\usepackage{graphicx}\n" if figures else ""
    information = _information(f"{document.kind}: {document.title}" if kind else document.title)
    body = "\n\n".join([*map(phrase, document.lead), fragment(document.blocks, figures)])
    return _TEMPLATE % (graphics, information, rf"{kind}\\[1ex] \large {title}" if kind else title, body)


def fragment(blocks: Iterable[Block], figures: Mapping[str, str] = _NONE, *, depth: int = 0) -> str:
    """Blocks as a piece of a document; ``depth`` : of their headings, 2 for paragraphs."""
    return _Writer(figures, depth=depth).joined(list(chosen(blocks, full=True)))


def piece(document: Document) -> str:
    """A document as a piece of another one, without title and source: what it says of its scene, and its blocks."""
    return fragment([*_asides(document), *document.blocks], depth=2)


def tables(document: Document) -> str:
    """The tables of a document in brief, and what it says below its title but for the source, which is a string."""
    found = chosen(document.blocks, full=False)
    return fragment([*_tables(found), *_asides(document)])


def _asides(document: Document) -> list[Block]:
    return [Paragraph(x) for x in document.lead if not isinstance(x, str)]


def _tables(blocks: Iterable[Block]) -> Iterator[Table]:
    for block in blocks:
        if isinstance(block, Section):
            yield from _tables(block.blocks)
        elif isinstance(block, Table):
            yield block


def _information(title: str) -> str:
    """What the PDF says about itself, plain or in UTF-16, and an identity that does not depend on where it was made."""
    plain = re.fullmatch(r"[\w ,.:;'=/+-]*(?:\([\w ,.:;'=/+-]*\)[\w ,.:;'=/+-]*)*", title, re.ASCII)
    coded = ("\ufeff" + title).encode("utf-16-be").hex().upper()
    told = f"({title})" if plain else f"<{coded}>"
    return rf"\ifdefined\pdfinfo \pdfinfo{{/Title {told} /Creator (haptisym)}} \pdftrailerid{{}} \fi"


def phrase(words: Phrase) -> str:
    r"""A phrase in LaTeX.

    >>> from haptisym.writing.names import named
    >>> phrase((named("r_r"), " exceeds 10\xa0%"))
    '$r_r$ exceeds 10~\\%'
    """
    if isinstance(words, tuple):
        return "".join(map(phrase, words))
    if isinstance(words, str):
        return "~".join(map(spaced, words.split("\xa0")))
    if isinstance(words, Number):
        return _digits(words.digits)
    if isinstance(words, Strong):
        return rf"\textbf{{{phrase(words.words)}}}"
    return rf"\texttt{{{_typed(words.text)}}}" if isinstance(words, Code) else f"${tex(words)}$"


def _typed(text: str) -> str:
    """What is typed, its quotation marks straight."""
    return escape(text).replace("''", r"\char34{}") if '"' in text else escape(text)


_LONG_NUMBER = 25  # digits; a longer one is set on several lines


def _digits(digits: str) -> str:
    if len(digits) <= _LONG_NUMBER:
        return spaced(digits)
    return r"\allowbreak ".join(digits[i : i + 5] for i in range(0, len(digits), 5))


@dataclass(frozen=True)
class _Writer:
    """LaTeX of blocks. Named numerators and denominators are shared by all equations of a document."""

    figures: Mapping[str, str]
    names: Names = field(default_factory=Names)
    depth: int = 0

    def joined(self, blocks: Sequence[Block]) -> str:
        """Blocks one after the other: a display belongs to the paragraph before it; figures stand side by side."""
        text = ""
        for kind, group in groupby(blocks, key=lambda x: isinstance(x, Figure) and not x.wide):
            for written in [self._side_by_side(list(group))] if kind else map(self._written, group):
                between = "\n" if written.startswith(r"\begin{align*}") else "\n\n"
                text += (between if text and written else "") + written
        return text

    @singledispatchmethod
    def _written(self, block: Block) -> str:
        raise TypeError(f"not a block of LaTeX: {type(block).__name__}")

    @_written.register
    def _(self, block: Paragraph) -> str:
        return phrase(block.words)

    @_written.register
    def _(self, block: Notes) -> str:
        return "\n\n".join(map(phrase, block.entries))

    @_written.register
    def _(self, block: Facts) -> str:
        rows = [rf"  \item[\normalfont {phrase(key)}] {phrase(words)}" for key, words in block.rows]
        return "\n".join(
            [r"\begin{description} \setlength{\itemsep}{0pt} \setlength{\parskip}{0pt}", *rows, r"\end{description}"]
        )

    @_written.register
    def _(self, block: Flow) -> str:
        return " $\\to$ ".join(map(phrase, block.links)) + "."

    @_written.register
    def _(self, block: Equations) -> str:
        return align(block.lines, self.names)

    @_written.register
    def _(self, block: Section) -> str:
        inside = _Writer(self.figures, self.names, self.depth + 1).joined(block.blocks)
        if not block.title:
            return inside
        command = ("section", "subsection", "paragraph")[min(self.depth, 2)]
        appendix = "\\appendix\n\n" if block.appendix else ""
        return f"{appendix}\\{command}{{{phrase(block.title)}}}\n\n{inside}"

    @_written.register
    def _(self, block: Figure) -> str:
        return self._floating([block], 0.8)

    def _side_by_side(self, figures: Sequence[Block]) -> str:
        drawn = [x for x in figures if isinstance(x, Figure)]
        return "\n\n".join(filter(None, (self._floating(drawn[i : i + 2], 0.48) for i in range(0, len(drawn), 2))))

    def _floating(self, figures: Iterable[Figure], width: float) -> str:
        columns = "\\hfill\n".join(
            f"\\begin{{minipage}}[t]{{{width}\\linewidth}}\\centering\n"
            f"\\includegraphics[width=\\linewidth]{{{self.figures[x.name]}}}\n"
            f"\\caption{{{phrase(x.caption)}}}\n\\end{{minipage}}"
            for x in figures
            if x.name in self.figures
        )
        return f"\\begin{{figure}}[!htbp]\n\\centering\n{columns}\n\\end{{figure}}" if columns else ""

    @_written.register
    def _(self, block: Table) -> str:
        heads = [phrase(x.heading) for x in block.columns]
        cells = [[*map(phrase, row)] for row in block.rows]
        for i, column in enumerate(block.columns):
            if column.number:
                _point([said(row[i]) for row in block.rows], cells, i)
        rows = [f"    {' & '.join(row)} \\\\" for row in cells]
        columns, lines = _columns(block)
        ends = list(accumulate(lines))
        pieces = [
            [row for _, row in group]
            for _, group in groupby(zip(ends, rows, strict=True), lambda x: (x[0] - 1) // _MOST)
        ]
        return "\n\n".join(_table(block, columns, heads, x, is_first=i == 0) for i, x in enumerate(pieces))


_MOST = 32  # lines of a table, so that it fits on a page
_LINE = 88  # characters of a line of a table
_GAP = 3
_CHARACTER = 0.175  # cm, as wide as a character is on average
_PARAGRAPHS = r">{\raggedright\arraybackslash}p{%.2fcm}"  # a narrow column that is justified tears its words apart


def _point(shown: Sequence[str], cells: list[list[str]], i: int) -> None:
    """Move the numbers of a column to the right until their points stand below each other."""
    before = [len(found[0]) if (found := NUMBER.match(x)) else 0 for x in shown]
    for row, n in zip(cells, before, strict=True):
        if n and n < max(before) <= _LONG_NUMBER:
            row[i] = rf"\phantom{{{'0' * (max(before) - n)}}}{row[i]}"


def _table(table: Table, columns: str, heads: Sequence[str], rows: Sequence[str], *, is_first: bool) -> str:
    caption = phrase(table.caption) + ("" if is_first else " (Continued.)")
    named = [f"  \\caption{{{caption}}}"] if table.caption else []
    return "\n".join([
        r"\begin{table}[!htbp]", r"  \centering", *named, rf"  \begin{{tabular}}{{{columns}}}", r"    \toprule",
        f"    {' & '.join(heads)} \\\\", r"    \midrule", *rows, r"    \bottomrule", r"  \end{tabular}", r"\end{table}",
    ])  # fmt: skip


def _columns(table: Table) -> tuple[str, list[int]]:
    """The columns of a table, as wide as they are, or paragraphs where the line would be too long; and lines of each row."""
    rows = [[_breakable(x) for x in row] for row in ([c.heading for c in table.columns], *table.rows)]
    natural = [max(map(len, column)) for column in zip(*rows, strict=True)]
    room = _LINE - _GAP * (len(natural) - 1)
    wide = widths_of(rows, room) or _narrowed(natural, room)
    columns = ["l" if w >= n else _PARAGRAPHS % (w * _CHARACTER) for w, n in zip(wide, natural, strict=True)]
    lines = [max(-(-len(x) // w) for x, w in zip(row, wide, strict=True)) for row in rows[1:]]
    return " ".join(columns), [max(n, 1) for n in lines]


def _narrowed(natural: Sequence[int], room: int) -> list[int]:
    """Widths that fit, although some words then do not: the widest columns give way."""
    wide = list(natural)
    while sum(wide) > max(room, len(wide)):
        wide[wide.index(max(wide))] -= 1
    return wide


def _breakable(words: Phrase) -> str:
    """About the characters of a phrase, with spaces where long numbers may break."""
    shown = said(words)
    return re.sub(r"\S{25,}", lambda x: " ".join(x[0][i : i + 5] for i in range(0, len(x[0]), 5)), shown)
