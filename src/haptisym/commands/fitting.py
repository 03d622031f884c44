"""Pages of text made to fit a terminal: paragraphs, lists of keys and tables of 96 columns, in fewer."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from textwrap import wrap

PAGE = 96
"""Columns of a page as it is written; a pipe gets it so, and no terminal gets a wider one."""
NARROWEST = 40
_ROOM = 22
"""Columns that must be left beside a key; with fewer what it says stands below it."""
_GAP = re.compile(r" {2,}")


def fitted(page: str, columns: int) -> str:
    """The page with lines of at most so many columns (but of 40 at least; a single word or number is never broken).

    >>> print(fitted("Certain: these are all crossings on the band, none is missed", 40))
    Certain: these are all crossings on the
    band, none is missed
    """
    columns = max(columns, NARROWEST)
    if all(len(line) <= columns for line in page.split("\n")):
        return page
    groups = groupby(page.split("\n"), key=bool)
    return "\n".join(x for filled, lines in groups for x in (_block([*lines], columns) if filled else [*lines]))


def _block(lines: list[str], columns: int) -> list[str]:
    """The lines between two empty ones."""
    if all(len(line) <= columns for line in lines):
        return lines
    columns_of = _starts([line for line in lines if not _is_rule(line)])
    if any(map(_is_rule, lines)) or (len(columns_of) > 2 and len(lines) > 1):
        return _table(lines, columns_of, columns)
    return [x for paragraph in _paragraphs(lines) for x in _paragraph(paragraph, columns)]


def _is_rule(line: str) -> bool:
    return len(line.strip()) > 2 and not line.strip(" ─-")


def _starts(lines: Sequence[str]) -> list[int]:
    """Where the columns begin that all of these lines have: after two blanks or more, one below the other."""
    longest = max(map(len, lines), default=0)
    blank = [all(line[i : i + 1] in (" ", "") for line in lines) for i in range(longest)]
    found = [i for i in range(longest) if not blank[i] and (i == 0 or blank[i - 1])]
    return [i for n, i in enumerate(found) if n == 0 or blank[i - 2]]


def _table(lines: list[str], starts: list[int], columns: int) -> list[str]:
    """A table: narrower columns of words if that is enough; else each row as a list of what it says, by the headings."""
    ends = [*starts[1:], PAGE * 10]
    indent = starts[0] if starts else 0
    rows: list[list[str]] = []
    for line in (x for x in lines if not _is_rule(x)):
        cells = [line[a:b].strip() for a, b in zip(starts, ends, strict=True)]
        if len(rows) > 1 and not cells[0] and any(map(_is_rule, lines)):  # a cell that took more than one line
            rows[-1] = [f"{above} {x}".strip() for above, x in zip(rows[-1], cells, strict=True)]
        else:
            rows.append(cells)
    widths = _widths(rows, columns - indent - 2 * (len(starts) - 1))
    if widths is None:
        return [*_listed(rows, indent, columns)]
    laid = [[*_laid(row, widths, indent)] for row in rows]
    if any(map(_is_rule, lines)):
        sign = next(x.strip()[0] for x in lines if _is_rule(x))
        laid.insert(1, [" " * indent + sign * (sum(widths) + 2 * (len(widths) - 1))])
    return [line for row in laid for line in row]


def _widths(rows: Sequence[Sequence[str]], room: int) -> list[int] | None:
    """Widths of the columns that fit, at least their longest words; None if there are none."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    least = [
        max((len(word) for cell in column for word in cell.split()), default=0) for column in zip(*rows, strict=True)
    ]
    least = [max(low, min(w, 8)) for low, w in zip(least, wide, strict=True)]
    while sum(wide) > room:
        i = max(range(len(wide)), key=lambda i: (wide[i] - least[i], wide[i]))
        if wide[i] <= least[i]:
            return None
        wide[i] -= 1
    return wide


def _laid(row: Sequence[str], widths: Sequence[int], indent: int) -> Iterator[str]:
    cells = [wrap(cell, width, break_on_hyphens=False) for cell, width in zip(row, widths, strict=True)]
    for i in range(max(map(len, cells))):
        parts = [(cell[i] if i < len(cell) else "").ljust(width) for cell, width in zip(cells, widths, strict=True)]
        yield " " * indent + "  ".join(parts).rstrip()


def _listed(rows: Sequence[Sequence[str]], indent: int, columns: int) -> Iterator[str]:
    headings, *others = rows
    for n, row in enumerate(others):
        if n:
            yield ""
        for heading, cell in zip(headings, row, strict=True):
            if cell:
                said = f"{heading}: {cell}" if heading else cell
                yield from _wrapped(said, columns, " " * indent, " " * (indent + 2))


def _paragraphs(lines: Sequence[str]) -> Iterator[str]:
    """Lines that were broken only because the page ended are one again."""
    whole, last = lines[0], lines[0]
    for line in lines[1:]:
        if _continues(whole, last, line):
            whole = f"{whole} {line.strip()}"
        else:
            yield whole
            whole = line
        last = line
    yield whole


def _continues(whole: str, last: str, line: str) -> bool:
    """Whether the first word of a line had no room in the line above, and it stands where the rest of a paragraph would."""
    is_full = len(last) + 1 + len(line.split()[0]) > PAGE
    deeper = _indent(line) > _indent(whole)
    return is_full and (deeper or (_indent(line) == _indent(whole) and not _GAP.search(whole.strip())))


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _paragraph(line: str, columns: int) -> list[str]:
    """One paragraph; of one that begins with a key ("  band     0 to 15 rad/s") the rest stands below what it says."""
    if len(line) <= columns:
        return [line]
    inside = _indent(line)
    key = _GAP.search(line, inside)
    if key is None:
        return _wrapped(line[inside:], columns, " " * inside, " " * inside)
    rest, after = line[key.end() :], key.end()
    if columns - after < _ROOM:
        said = _wrapped(line[inside : key.start()], columns, " " * inside, " " * (inside + 2))
        return [*said, *_wrapped(rest, columns, " " * (inside + 4), " " * (inside + 4))]
    return _wrapped(rest, columns, line[:after], " " * after)


def _wrapped(text: str, columns: int, first: str, rest: str) -> list[str]:
    return wrap(
        _GAP.sub("  ", text), columns, initial_indent=first, subsequent_indent=rest,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
