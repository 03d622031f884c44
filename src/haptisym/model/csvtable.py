"""Tables of numbers in text files: a header, units, lines, with every error naming file and line."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.model.measured import Reals
from haptisym.model.plainrows import plain_rows
from haptisym.model.quantities import MotionKind

LARGEST = 500_000_000
"""Bytes of a file."""
_TOGETHER = 1 << 17
"""Letters that are read at once: what is made of them stays close to the processor, and in memory that is used again."""
_NOT_TEXT = (b"PK", b"\x89", b"MATLAB", b"\x80", b"\xff\xfe", b"\xfe\xff")


@dataclass(frozen=True)
class Form:
    """What a table may hold.

    ``first`` : the columns of which one is always there; where it has no number stand units. ``check`` : the names, or an
    error. ``factor`` : of a column and its unit what its numbers are multiplied by, and what motion it implies.
    ``example`` : of a header.
    """

    first: tuple[str, ...]
    check: Callable[[Sequence[str]], tuple[str, ...]]
    factor: Callable[[str, str], tuple[float, MotionKind | None]]
    example: str
    units: Callable[[Sequence[str], Sequence[str]], Sequence[str]] = lambda _, units: units
    """Of columns and their units, all units: those of columns that have none may follow from the others; or an error."""


@dataclass(frozen=True, eq=False)
class NumberTable:
    """Numbers by column, in SI, and where each line stands."""

    path: Path
    head: Head
    rows: Reals

    @cached_property
    def column(self) -> Mapping[str, Reals]:
        """A column by its name."""
        named = zip(self.head.columns, self.head.factors, strict=True)
        return {x: self.rows[:, i] * factor if factor != 1 else self.rows[:, i] for i, (x, factor) in enumerate(named)}

    def place(self, row: int) -> str:
        """The line of a row in the file."""
        with self.path.open(encoding="utf-8-sig") as file:
            lines = _numbered(islice(file, self.head.line - 1, None), self.head.line)
            return f"line {next(islice(lines, row, None))[0]}"


def read_table(path: Path, form: Form) -> NumberTable:
    """The table in a file; SceneError says what is wrong with it, and in which line."""
    try:
        refuse(path)
        with path.open(encoding="utf-8-sig") as file:
            head = _head(file, form)
            return NumberTable(path, head, _rows(file, head))
    except UnicodeDecodeError:
        raise SceneError("not text in UTF-8: save it as CSV in UTF-8") from None
    except SceneError:
        raise
    except (OSError, ValueError) as error:
        raise SceneError(str(getattr(error, "strerror", "") or error).lower()) from None


def refuse(path: Path, *, text: bool = True) -> None:
    """SceneError unless a file is there that can be read: of ``text``, if that is wanted."""
    if path.is_dir():
        raise SceneError("this is a folder: name a file in it")
    if not path.exists():
        raise SceneError(f"there is no such file{_near(path)}")
    if not path.is_file():
        raise SceneError("this is no regular file")
    if path.stat().st_size > LARGEST:
        raise SceneError(f"the file has more than {LARGEST} bytes")
    if not text:
        return
    with path.open("rb") as begun:
        if begun.read(8).startswith(_NOT_TEXT):
            raise SceneError("not text in UTF-8: export the columns as CSV in UTF-8")


def _near(path: Path) -> str:
    folder = path.parent
    if not folder.is_dir():
        return f", and no folder {folder}"
    hint = meant(path.name, sorted(x.name for x in folder.iterdir() if x.is_file())).rstrip()
    return f"; {hint}" if hint else f" in {folder.name or 'this folder'}"


# The header, and units.


class Head(NamedTuple):
    """What stands before the numbers: columns in their order, what each is multiplied by, and the first line of numbers."""

    columns: tuple[str, ...]
    factors: tuple[float, ...]
    motion: MotionKind | None
    delimiter: str
    first: str
    line: int


def _head(file: TextIO, form: Form) -> Head:
    lines = ((i, x) for i, x in enumerate(file, 1) if x.strip() and not x.lstrip().startswith("#"))
    at, header = next(lines, (0, ""))
    delimiter = max("\t;,", key=header.count)
    cells = _cells(header, delimiter)
    if len(cells) > 1 and all(_is_number(x) for x in cells):
        raise SceneError(f"line {at} holds numbers: the first line must name the columns, as in {form.example}")
    names, units = zip(*map(_named, cells), strict=True) if cells else ((), ())
    columns = form.check(names)
    at, first = next(lines, (at, ""))
    found = _cells(first, delimiter)
    if _is_unit(dict(zip(columns, found, strict=False)), form):
        if any(units):
            raise SceneError(f"line {at} has units, and so has the header: leave out one of them")
        if len(found) != len(columns):
            raise SceneError(f"line {at} has {len(found)} units, and the header names {len(columns)} columns")
        units = tuple(found)
        at, first = next(lines, (at, ""))
    if not first:
        raise SceneError("there are no lines of numbers in it")
    factors, motion = _factors(columns, units, form)
    return Head(columns, factors, motion, delimiter, first, at)


def _is_unit(cells: Mapping[str, str], form: Form) -> bool:
    """Whether a line has a unit where the number of its first column would stand."""
    cell = next((cells[x] for x in form.first if x in cells), "")
    return bool(cell) and not _is_number(cell) and not _has_comma(cell)


def _named(cell: str) -> tuple[str, str]:
    """``real [N/m]`` is a name and a unit."""
    match = re.fullmatch(r"(.*?)\s*[\[(](.*)[\])]", cell)
    name, unit = match.groups() if match else (cell, "")
    return name.strip().lower(), unit.strip()


def _factors(columns: Sequence[str], units: Sequence[str], form: Form) -> tuple[tuple[float, ...], MotionKind | None]:
    units = form.units(columns, units)
    found = [form.factor(*x) for x in zip(columns, units, strict=True)]
    motions = {motion for _, motion in found if motion}
    if len(motions) > 1:
        raise SceneError("units: translation and rotation cannot be mixed")
    return tuple(factor for factor, _ in found), next(iter(motions), None)


# The lines of numbers.


def _rows(file: TextIO, head: Head) -> Reals:
    parts, line = [], head.line
    for text in _texts(file, head.first):
        if head.delimiter != ",":  # which then can only stand before decimals
            text = text.replace(",", ".")
        plain = plain_rows(text, head.delimiter, len(head.columns))
        parts.append((_any_rows(text, line, head) if plain is None else plain).T)
        line += text.count("\n")
    rows: Reals = np.concatenate(parts, axis=1).T  # each column lies in one piece
    return rows


def _texts(file: TextIO, first: str) -> Iterator[str]:
    """The first line and the others, many at once."""
    text = first + file.read(_TOGETHER)
    while text:
        yield text + file.readline()
        text = file.read(_TOGETHER)


def _any_rows(text: str, line: int, head: Head) -> Reals:
    """Of lines from that one on, however they are written: with quotes, comments, NaN."""
    if next(_numbered(StringIO(text), line), None) is None:
        return np.empty((0, len(head.columns)))
    try:
        rows: Reals = np.loadtxt(
            StringIO(text), delimiter=head.delimiter, ndmin=2, comments="#", quotechar='"', dtype=float
        )
        is_whole = rows.shape[1] == len(head.columns)
    except ValueError:
        is_whole = False
    if not is_whole:
        for number, own in _numbered(StringIO(text), line):
            _refuse_line(number, _cells(own, head.delimiter), head)
        raise SceneError("not a table of numbers")
    return rows


def _numbered(lines: Iterable[str], first: int) -> Iterator[tuple[int, str]]:
    """Those of numbers, as text, and which line it is."""
    for number, line in enumerate(lines, first):
        if (text := line.partition("#")[0]).strip():
            yield number, text


def _refuse_line(number: int, cells: Sequence[str], head: Head) -> None:
    """SceneError if the line holds what is no number, or too many of them."""
    hint = ""
    if len(cells) > len(head.columns) and head.delimiter == "," and len(cells) == 2 * len(head.columns):
        hint = "; if these are decimal commas, write decimals with a point"
    if len(cells) != len(head.columns):
        raise SceneError(
            f"line {number} has {len(cells)} cells, and the header names {len(head.columns)} columns{hint}"
        )
    for name, cell in zip(head.columns, cells, strict=True):
        if _has_comma(cell):
            right = cell.replace(",", ".")
            raise SceneError(f"line {number}: {name}: {quoted(cell)}: decimals are written with a point, as in {right}")
        if not _is_number(cell):
            what = f"{quoted(cell)} is not a number" if cell else "the cell is empty"
            raise SceneError(f"line {number}: {name}: {what}")


def _cells(line: str, delimiter: str) -> list[str]:
    return [x.strip() for x in next(csv.reader([line], delimiter=delimiter), [])]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _has_comma(cell: str) -> bool:
    return re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) is not None
