"""A table from a file of any kind: columns by their headers, and what stands in them.

What the columns mean is the caller's: responses, records and motions (``responsefile``) and answers
of people (``verbs.jnd.tables``) are read here alike. The caller gives a function that finds what it
needs among the headers, or refuses; the header is the first line that it takes.

Text has separators (comma, semicolon, tab, blanks), comments (``#``, ``%``, ``*``), maybe lines
before the header, as instruments write them, and a row of units below it; or each row begins with
its name, and the table is turned round. Where the separator is no comma, a comma stands before
decimals. Numbers are read by NumPy to the nearest float, and every error names file and line.

Of arrays by name (MATLAB, NumPy, HDF5, Parquet, universal files), each in a struct or group is a
column. Their readers are SciPy, NumPy, xarray, pandas and pyuff. Begin with ``open_table``.
"""

from __future__ import annotations

import cmath
import csv
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from itertools import chain, islice
from math import radians
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, TypeVar

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.kernel.objects import counted
from haptisym.model.columns import ColumnHeader, agreed, column_of, is_unit, known_role

T = TypeVar("T")
Finder = Callable[[Sequence[ColumnHeader]], T]
"""A function that finds what is needed among headers; SceneError where it is not there."""

LARGEST = 500_000_000
"""The most bytes that a file may have."""
# How files begin that are often taken for tables, and what they are.
_NOT_TEXT = {
    b"PK": "a workbook or an archive: save its sheet as CSV",
    b"\x80": "a pickle, which would run whatever is in it: export the trials as CSV "
    "(saveAsWideText in PsychoPy)",
    b"\x89": "an HDF5 or MATLAB file, or an image: call it .h5 or .mat, or export it as CSV",
    b"MATLAB": "a MATLAB file: call it .mat",
    b"\xff\xfe": "export the columns as CSV in UTF-8",
    b"\xfe\xff": "export the columns as CSV in UTF-8",
}
_PICKLES = (".psydat", ".pkl", ".pickle")
_COMMENTS = "#%*"
# Rows whose texts are in memory at a time.
_BATCH = 2_000
# Lines in which a header is looked for, and of a table whose rows have names.
_MOST_BEFORE = 1000
_MOST_ROWS = 100


def refuse(path: Path, *, pipes: bool = False) -> None:
    """SceneError unless there is a file of a size that can be read; regular, unless ``pipes`` are
    taken too."""
    if path.is_dir():
        raise SceneError("this is a folder: name a file in it")
    if not path.exists():
        raise SceneError(f"there is no such file{_near(path)}")
    if not path.is_file() and not pipes:
        raise SceneError("this is no regular file")
    if path.stat().st_size > LARGEST:
        raise SceneError(f"the file has more than {LARGEST} bytes")


def _near(path: Path) -> str:
    """The end of a message on a missing file: a similar name in its folder, or the folder."""
    folder = path.parent
    if not folder.is_dir():
        return f", and no folder {folder}"
    hint = meant(path.name, sorted(x.name for x in folder.iterdir() if x.is_file())).rstrip()
    return f"; {hint}" if hint else f" in {folder.name or 'this folder'}"


# Text.


@dataclass(frozen=True, eq=False)
class Text:
    """The content of a text; a ``line`` is a column where a table was turned round."""

    content: str
    line: str = "line"

    @classmethod
    def of(cls, path: Path, *, pipes: bool = False) -> Text:
        """The text in a file; SceneError for what is none."""
        refuse(path, pipes=pipes)
        with path.open("rb") as file:
            data = file.read(LARGEST)
        kind = next((words for mark, words in _NOT_TEXT.items() if data.startswith(mark)), "")
        # An old pickle begins as text does, and is known by its suffix.
        if path.suffix.lower() in _PICKLES:
            kind = _NOT_TEXT[b"\x80"]
        if kind:
            raise SceneError(f"not text in UTF-8: {kind}")
        try:
            return cls(data.decode("utf-8-sig"))
        except UnicodeDecodeError:
            # Instruments write ° and µ in the encoding of Windows.
            return cls(data.decode("cp1252"))

    def lines(self, first: int = 1) -> Iterator[str]:
        """The lines from a number on."""
        return islice(StringIO(self.content, newline=None), first - 1, None)

    def numbered(self, first: int = 1, blank: list[int] | None = None) -> Iterator[tuple[int, str]]:
        """The lines that are not empty and no comments, without comments at their ends, each with
        its number; the numbers of those that hold separators alone go to ``blank``."""
        for number, line in enumerate(self.lines(first), first):
            text = line.partition("#")[0] if "#" in line else line
            if bare := text.strip(' \t,;"\r\n'):
                if bare[0] not in _COMMENTS:
                    yield number, text
            elif blank is not None and text.strip():
                blank.append(number)

    def turned(self) -> Text | None:
        """The table with rows for columns, where each line is a name, maybe a unit, and numbers;
        None where it is not so."""
        rows = []
        for _, line in islice(self.numbered(), _MOST_ROWS + 1):
            cells = _cells(line, _separator(line))
            rest = cells[1:] if len(cells) > 1 and _is_number(cells[1]) else cells[2:]
            if _is_number(cells[0]) or not rest or not all(map(_is_number, rest)):
                return None
            rows.append([x.replace(";", ",") for x in cells])
        if not 1 < len(rows) <= _MOST_ROWS or len({len(x) for x in rows}) > 1:
            return None
        lines = (";".join(column) for column in zip(*rows, strict=True))
        return Text("\n".join(lines), "column")


class Head(NamedTuple):
    """What stands before the numbers: the columns, the separator of cells (None for blanks), and
    the first line below with its number."""

    columns: tuple[ColumnHeader, ...]
    separator: str | None
    first: str
    line: int


class Numbers(NamedTuple):
    """The numbers of columns, the place of each row from 1, and notes on rows that were left
    out."""

    columns: list[Any]
    places: Sequence[int]
    notes: list[str]


@dataclass(frozen=True, eq=False)
class TextTable:
    """A table of text below its header."""

    text: Text
    head: Head

    @property
    def columns(self) -> tuple[ColumnHeader, ...]:
        """The headers."""
        return self.head.columns

    @property
    def line(self) -> str:
        """What a row is called."""
        return self.text.line

    @property
    def has_commas(self) -> bool:
        """Whether a comma in a number stands before its decimals."""
        return self.head.separator != ","

    @property
    def notes(self) -> list[str]:
        """Words on how it was read: with decimal commas."""
        first = _with_complex(self.head.first, self.head.separator)
        return ["decimal commas"] if self.has_commas and "," in first else []

    def cells(self, _: Sequence[int], blank: list[int]) -> Iterator[tuple[int, list[str]]]:
        """The cells of each line, with its number; the numbers of those that hold separators alone
        go to ``blank``."""
        at = [0]

        def lines() -> Iterator[str]:
            for at[0], line in self.text.numbered(self.head.line, blank):
                yield line

        # A quoted cell may go on in the next line.
        rows: Iterable[list[str]] = map(str.split, lines())
        if self.head.separator is not None:
            rows = csv.reader(lines(), delimiter=self.head.separator, skipinitialspace=True)
        try:
            for row in rows:
                yield at[0], row
        except csv.Error as error:
            raise SceneError(f"not a table: {error}") from None

    def numbers(self, used: Sequence[int], complex_one: int | None) -> Numbers:
        """The numbers of columns; lines without one in each are left out and counted.
        ``complex_one`` : the column that may be complex. SceneError, with line and column, for what
        is no number."""
        places, blank, partial = array("q"), list[int](), list[int]()
        rows = self._complete(used, places, blank, partial)
        parts: list[list[Any]] = [[] for _ in used]
        # In batches, as the texts of numbers take many times their memory.
        while batch := list(islice(rows, _BATCH)):
            first = len(places) - len(batch)
            for i, part, cells in zip(used, parts, zip(*batch, strict=True), strict=True):
                part.append(self._converted(i, cells, places[first:], is_complex=i == complex_one))
        if not places:
            raise SceneError("there are no lines of numbers")
        notes = [f"{counted(len(blank), 'blank row')} left out"] if blank else []
        notes += [f"{counted(len(partial), 'incomplete row')} left out"] if partial else []
        return Numbers([np.concatenate(x) for x in parts], places, notes)

    def _complete(
        self, used: Sequence[int], places: array[int], blank: list[int], partial: list[int]
    ) -> Iterator[list[str]]:
        """The cells in use of each line that has all of them; its number goes to ``places``, those
        of others to ``blank`` and ``partial``."""
        width = len(self.columns)
        for number, cells in self.cells(used, blank):
            if len(cells) != width:
                self._refuse_length(number, len(cells))
            chosen = [cells[i] for i in used]
            if "" in chosen:
                partial.append(number)
                continue
            places.append(number)
            yield chosen

    def _converted(
        self, column: int, cells: Sequence[str], places: Sequence[int], *, is_complex: bool
    ) -> Any:
        """Cells of a column as numbers."""
        # Python reads 1_000 as a number: no file means that.
        text = "\n".join(cells).replace("_", "x")
        if is_complex:
            text = _as_python(text, self.head.separator)
        elif self.has_commas:
            text = text.replace(",", ".")
        try:
            kind: Any = complex if is_complex else float
            return np.fromiter(map(kind, text.split("\n")), kind)
        except ValueError:
            # Of a complex number in a column of real ones the first line is named.
            are_wrong = (not _is_number(x) or ("," in x and not self.has_commas) for x in cells)
            wrong = next((k for k, is_wrong in enumerate(are_wrong) if is_wrong), 0)
            self._refuse_cell(places[wrong], column, cells[wrong].strip())

    def _refuse_length(self, number: int, length: int) -> NoReturn:
        """SceneError for a line with too few or too many cells."""
        width = len(self.columns)
        # Twice as many cells as columns: each number with a decimal comma was cut in two.
        hint = ""
        if self.head.separator == "," and length == 2 * width:
            hint = (
                "; if these are decimal commas, separate columns by semicolons, or write decimals "
                "with a point"
            )
        raise SceneError(f"line {number} has {length} cells, the header {width} columns{hint}")

    def _refuse_cell(self, number: int, column: int, cell: str) -> NoReturn:
        """SceneError for a cell that is no number."""
        where = f"{self.line} {number}: {self.columns[column].text}: {quoted(cell)}"
        if _has_comma(cell):
            right = cell.replace(",", ".")
            raise SceneError(f"{where}: decimals are written with a point, as in {right}")
        raise SceneError(f"{where} is not a number")

    def is_written_complex(self) -> bool:
        """Whether the first line has a complex number, as 799+0j."""
        plain = _as_python(self.head.first, self.head.separator)
        return re.search(r"\d\s*\*?[jJ]", plain) is not None


def text_table(
    text: Text,
    find: Finder[T],
    example: str,
    *,
    without_header: Sequence[str] = (),
    is_counted: bool = False,
    least: int = 2,
) -> tuple[TextTable, T]:
    """The table in a text, and what is found among its headers.

    The header is at the top, or else further down, after what an instrument writes before it; or
    the rows have names. The error is that of the last line that could be the header.
    ``example`` : a header for the message where there is none. ``without_header`` : the names of
    columns where numbers begin at once; ``is_counted`` : whether numbers from 1 will do as names.
    ``least`` : how many numbers a line has at least.
    """
    error: SceneError | None = None
    heads = ((text, x) for x in _heads(text, without_header, is_counted=is_counted, least=least))
    for source, head in chain(heads, _of_named_rows(text)):
        try:
            return TextTable(source, head), find(head.columns)
        except SceneError as refused:
            # Of rows that might have names nothing is said: that they had was only a try.
            error = refused if source is text else error
    if error is not None:
        raise error
    at, first = next(text.numbered(), (1, ""))
    if _count_of_numbers(first):
        raise SceneError(f"line {at} has numbers: name the columns in the first line, as {example}")
    # The message repeats nothing of the file: a scene from a stranger may name any file.
    raise SceneError(
        "there are no lines of numbers below names of columns"
        + (", two or more in each" if least > 1 else "")
    )


def _heads(
    text: Text, without_header: Sequence[str], *, is_counted: bool, least: int
) -> Iterator[Head]:
    """Each line that may be the header: one without numbers above a line that has some, or above a
    row of units; as many cells in both, but at the top, where the line below is then refused."""
    lines = list(islice(text.numbered(), _MOST_BEFORE))
    if lines and _count_of_numbers(lines[0][1]):
        yield from _without_names(text, *lines[0], without_header, is_counted=is_counted)
    for k, (number, line) in enumerate(lines[1:]):
        separator = _separator(line, lines[k][1])
        cells = _cells(line.rstrip(), separator)
        if sum(map(_is_number, cells)) < least or _is_row_of_units(cells):
            continue
        own, above = lines[k][1], lines[k - 1][1]
        units = _cells(own, _separator(own, above))
        candidates: list[tuple[str, list[str]]] = [(own, [])]
        if k > 0 and len(_names(above)) == len(units) and not _is_number(units[0]):
            # Units that nobody knows are taken for some below the first line alone.
            if _is_row_of_units(units):
                candidates = [(above, units)]
            elif k == 1:
                candidates.insert(0, (above, units))
        for header, row_of_units in candidates:
            names = _names(header)
            # LabVIEW names a column for remarks and leaves it out of the lines.
            if names[-1:] == ["Comment"] and len(cells) < len(names):
                names.pop()
            if (k == 0 or len(names) == len(cells)) and not any(map(_is_number, names)):
                yield Head(_with_units(names, row_of_units), separator, line, number)


def _is_row_of_units(cells: Sequence[str]) -> bool:
    """Whether cells are units, of which a 1 may be one, but no row of answers "m, 1, 1"."""
    numbers = sum(map(_is_number, cells))
    return 2 * numbers < len(cells) and not _is_number(cells[0]) and all(map(is_unit, cells))


def _with_units(names: Sequence[str], units: Sequence[str]) -> tuple[ColumnHeader, ...]:
    """The headers, with the units of a row of their own if there is one."""
    columns = tuple(map(column_of, names))
    if not units:
        return columns
    pairs = zip(columns, units, strict=True)
    return tuple(x._replace(unit=agreed(x.text, x.unit or unit, unit)) for x, unit in pairs)


def _without_names(
    text: Text, number: int, line: str, without_header: Sequence[str], *, is_counted: bool
) -> Iterator[Head]:
    """The header of numbers that begin at once: a comment above, the kind of file or the scene
    names the columns; none where nothing does."""
    separator = _separator(line)
    cells = _cells(line, separator)
    above = [x.strip().lstrip("#*% ") for x in islice(text.lines(), number - 1) if x.strip()]
    named = _names(above[-1]) if above else []
    if len(named) == len(cells) > 1 and (not without_header or any(map(known_role, named))):
        names = named
    elif len(cells) > 1 and without_header:
        names = list(without_header)
    elif is_counted:
        names = [str(i + 1) for i in range(len(cells))]
    else:
        return
    yield Head(tuple(map(column_of, names)), separator, line, number)


def _of_named_rows(text: Text) -> Iterator[tuple[Text, Head]]:
    """The header of a table whose rows have names, if this is one."""
    if turned := text.turned():
        yield from ((turned, x) for x in _heads(turned, (), is_counted=False, least=1))


def _count_of_numbers(line: str) -> int:
    return sum(map(_is_number, _cells(line, _separator(line))))


# Cells.


def _separator(line: str, header: str = "") -> str | None:
    """The separator of the cells of a line of numbers; None for blanks."""
    # One that stands as often in the header is it. A tab or semicolon separates whatever else is
    # there. Then numbers between blanks: in "1,5 2,5" the commas are decimal. Only then a comma.
    own = max("\t;,", key=header.count)
    if header.count(own) and line.count(own) == header.count(own):
        return own
    if separator := next((x for x in "\t;" if x in line), None):
        return separator
    words = line.split()
    if len(words) > 1 and all(map(_is_number, words)):
        return None
    if "," in line:
        return ","
    return own if own in header else None


def _names(header: str) -> list[str]:
    """The names of a header's columns; between blanks, a unit in brackets belongs to its name."""
    if set("\t;,") & set(header):
        return _cells(header, max("\t;,", key=header.count))
    return re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", header.replace('"', ""))


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line; quotes are those of CSV."""
    if separator is None:
        return line.split()
    reader = csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [x.strip() for x in next(reader, [])]


# LTspice writes complex numbers as (-3.01dB,-45°), or as 0.5,-0.5.
_POLAR = re.compile(r"\(\s*([-+.\deE]+)\s*dB\s*,\s*([-+.\deE]+)\s*°\s*\)")
_PAIR = re.compile(r"([-+]?\d+\.\d*(?:[eE][-+]?\d+)?),([-+]?\d+\.\d*(?:[eE][-+]?\d+)?)")


def _with_complex(text: str, separator: str | None) -> str:
    """The text with complex numbers of LTspice as Python writes them; a comma between two numbers
    that have points is none before decimals."""
    if separator == "," or "," not in text:
        return text
    text = _POLAR.sub(lambda x: _complex_text(_from_decibel(float(x[1]), float(x[2]))), text)
    return _PAIR.sub(lambda x: _complex_text(complex(float(x[1]), float(x[2]))), text)


def _from_decibel(size: float, degrees: float) -> complex:
    return cmath.rect(10 ** (size / 20), radians(degrees))


def _complex_text(x: complex) -> str:
    return f"{x.real!r}{x.imag:+.17g}j"


def _as_python(text: str, separator: str | None, *, is_complex: bool = True) -> str:
    """A line as NumPy and Python read numbers: with points, and complex ones like ``(799 + 30i)``
    as ``799+30j``."""
    if is_complex:
        text = _with_complex(text, separator)
    # Where another separator stands, a comma can only stand before decimals.
    plain = text if separator == "," else text.replace(",", ".")
    if not is_complex:
        return plain
    # Blanks inside a number can be taken out unless they, or tabs, separate the cells.
    bare = re.sub(r"[()]" if separator in (None, "\t") else r"[() ]", "", plain)
    return re.sub(r"(?<=[\d.])[ \t]*\*?[iIjJ](?![A-Za-z])", "j", bare)


def _is_number(cell: str) -> bool:
    """Whether a cell is a real or complex number, with a decimal point or comma."""
    plain = _as_python(cell.strip(), ";")
    try:
        complex(plain)
    except ValueError:
        return False
    # Python reads 1_000 as a number, and j as one: no file means that.
    return "_" not in plain and plain.lower() not in ("j", "+j", "-j")


def _has_comma(cell: str) -> bool:
    """Whether a cell is a number with a decimal comma."""
    return re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) is not None


# Arrays by name.


@dataclass(frozen=True, eq=False)
class ArrayTable:
    """Arrays of a file, each a column."""

    columns: tuple[ColumnHeader, ...]
    arrays: tuple[Any, ...]
    notes: tuple[str, ...] = ()
    has_commas = False
    line = "line"

    def numbers(self, used: Sequence[int], complex_one: int | None) -> Numbers:
        """The numbers of columns. SceneError unless each array is one row or column of numbers,
        real but for ``complex_one``, and all are as long."""
        rows = []
        for i in used:
            row, key = np.asarray(self.arrays[i]), self.columns[i].text
            if row.dtype.kind not in "biufc" or row.size != max(row.shape, default=1):
                raise SceneError(f"{key}: must be one row or column of numbers")
            if row.dtype.kind == "c" and i != complex_one:
                raise SceneError(f"{key}: must be real")
            rows.append(row.ravel())
        if len({*map(len, rows)}) > 1:
            counts = ", ".join(str(len(x)) for x in rows)
            raise SceneError(f"give as many numbers in each variable: there are {counts}")
        return Numbers(rows, range(1, len(rows[0]) + 1), [])

    def cells(self, used: Sequence[int], _: list[int]) -> Iterator[tuple[int, list[str]]]:
        """The cells of each place, with its number; empty where an array has none, or is no row."""
        columns = [_cells_of(x) for x in self.arrays]
        for k in range(max(len(columns[i]) for i in used)):
            yield k + 1, [x[k] if k < len(x) else "" for x in columns]

    def is_written_complex(self) -> bool:
        """True: an array is complex, or it is not."""
        return True


def _cells_of(given: Any) -> list[str]:
    """An array as texts, each number the shortest that is read back; empty for a matrix."""
    row = np.asarray(given)
    if row.size != max(row.shape, default=1):
        return []
    return ["" if x != x else f"{x}".removesuffix(".0").strip() for x in row.ravel().tolist()]


def _array_table(path: Path, find: Finder[T]) -> tuple[ArrayTable, T]:
    """The arrays of a file, or of the one struct or group in it among whose names what is needed
    is found."""
    refuse(path)
    kind, read = ARRAYS[path.suffix.lower()]
    try:
        content = read(path)
    except SceneError:
        raise
    except ImportError as missing:
        # pandas raises one of its own, with the name of what reads for it in the text.
        package = missing.name or "pyarrow"
        raise SceneError(
            f"a {kind} is read by {package}: pip install {package}, or use CSV"
        ) from None
    except Exception as unreadable:  # noqa: BLE001  whatever a reader raises for what is none
        raise SceneError(f"not a readable {kind}: {str(unreadable).lower()}") from None
    error = SceneError("there are no arrays")
    taken: list[tuple[str, ArrayTable, T]] = []
    for name, arrays in _structs("", content):
        columns = tuple(map(column_of, arrays))
        try:
            found = find(columns)
        except SceneError as refused:
            error = refused
            continue
        taken.append((name, ArrayTable(columns, tuple(arrays.values())), found))
        # What stands at the top goes before what is inside.
        if not name:
            break
    if len(taken) > 1:
        raise SceneError(f"{taken[0][0]} and {taken[1][0]} both hold a table: keep one")
    for _, table, found in taken:
        return table, found
    raise error


def _structs(name: str, content: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The arrays at the top by name, then those of each struct; of an array of structs each field
    is a column."""
    inside = {}
    for key, x in content.items():
        if isinstance(x, Mapping):
            inside[key] = x
        elif np.ndim(x) == 1 and len(x) and isinstance(x[0], Mapping):
            inside[key] = {field: [row.get(field) for row in x] for field in x[0]}
    arrays = {key: x for key, x in content.items() if not isinstance(x, Mapping)}
    if arrays:
        yield name, arrays
    for key, x in inside.items():
        yield from _structs(f"{name}.{key}" if name else key, x)


def _matlab(path: Path) -> dict[str, Any]:
    """The variables of a file of MATLAB up to version 7."""
    from scipy.io import loadmat

    try:
        variables = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise SceneError("version 7.3, which SciPy does not read: save it with -v7") from None
    return _with_frd({key: x for key, x in variables.items() if not key.startswith("__")})


def _with_frd(fields: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a struct, and of those in it, with the columns of an frd in its place."""
    if {"ResponseData", "Frequency"} <= set(fields):
        return _frd(fields)
    return {key: _with_frd(x) if isinstance(x, Mapping) else x for key, x in fields.items()}


def _frd(fields: Mapping[str, Any]) -> dict[str, Any]:
    """The columns of an frd of MATLAB, whose frequencies may refer to the unit of time; SceneError
    where that is not seconds."""
    unit, time = (str(fields.get(x, "")) for x in ("FrequencyUnit", "TimeUnit"))
    if time not in ("", "seconds") and (not unit or "TimeUnit" in unit):
        raise SceneError(
            f"TimeUnit: the frequencies are per {time}: set FrequencyUnit to rad/s or Hz"
        )
    known = {"": "rad/s", "rad/TimeUnit": "rad/s", "cycles/TimeUnit": "Hz"}
    return {
        f"Frequency [{known.get(unit, unit)}]": fields["Frequency"],
        "ResponseData": fields["ResponseData"],
    }


def _archive(path: Path) -> dict[str, Any]:
    """The arrays of an archive of NumPy; never objects, as unpickling runs code from the file."""
    with np.load(path, allow_pickle=False) as archive:
        return dict(archive)


def _hierarchy(path: Path) -> dict[str, Any]:
    """The arrays of a file of HDF5 or netCDF with their units, and of each group."""
    from xarray import open_groups

    groups = open_groups(path, engine="h5netcdf", phony_dims="sort")
    content = {}
    for place, group in groups.items():
        content[place.strip("/")] = {
            f"{name} [{x.attrs['units']}]" if x.attrs.get("units") else str(name): x.to_numpy()
            for name, x in group.variables.items()
        }
        group.close()
    return content.pop("") | content


def _parquet(path: Path) -> dict[str, Any]:
    """The columns of a file of Parquet."""
    from pandas import read_parquet

    return {str(name): x.to_numpy() for name, x in read_parquet(path).items()}


# Codes of universal files: what an abscissa and an ordinate are, with the SI unit; what a
# function is.
_UNIVERSAL_UNITS = {8: "m", 9: "N", 11: "m/s", 12: "m/s^2", 13: "N", 17: "s", 18: "Hz"}
_UNIVERSAL_KINDS = {4: "H", 6: "coherence"}
_UNIVERSAL_RECORDS = {8: "position", 9: "force", 13: "force"}


def _universal(path: Path) -> dict[str, Any]:
    """The functions of a universal file (dataset 58): frequency response H, coherence, or records,
    over one abscissa, each with its unit."""
    from pyuff import UFF

    sets = UFF(str(path)).read_sets()
    functions = [x for x in (sets if isinstance(sets, list) else [sets]) if x["type"] == 58]
    if not functions:
        raise SceneError("there is no dataset 58: use CSV")
    is_time = functions[0]["abscissa_spec_data_type"] == 17
    axis = "time" if is_time else "frequency"
    content = {f"{axis} [{_label(functions[0], 'abscissa')}]": functions[0]["x"]}
    for i, x in enumerate(functions, 1):
        name = _UNIVERSAL_KINDS.get(x["func_type"])
        if is_time:
            name = _UNIVERSAL_RECORDS.get(x["ordinate_spec_data_type"])
        unit = _label(x, "ordinate")
        if name == "H":
            below = _label(x, "orddenom")
            unit = f"{unit}/{below if below.isalnum() else f'({below})'}"
        content[f"{name or 'function'} {i}{f' [{unit}]' if name != 'coherence' else ''}"] = x[
            "data"
        ]
    return content


def _label(function: Mapping[str, Any], axis: str) -> str:
    """The unit of an axis as it is labelled; that of SI, in which these files are, where no label
    is a unit."""
    label = str(function.get(f"{axis}_axis_units_lab") or "").strip()
    if label and label != "-" and is_unit(label):
        return label
    return _UNIVERSAL_UNITS.get(function[f"{axis}_spec_data_type"], "")


ARRAYS: dict[str, tuple[str, Callable[[Path], dict[str, Any]]]] = {
    ".mat": ("file of MATLAB", _matlab),
    ".npz": ("archive of NumPy", _archive),
    **dict.fromkeys((".h5", ".hdf5", ".nc"), ("file of HDF5", _hierarchy)),
    ".parquet": ("file of Parquet", _parquet),
    **dict.fromkeys((".uff", ".unv"), ("universal file", _universal)),
}
"""Files of arrays by their endings: what they are called, and how they are read."""


def open_table(
    path: Path, find: Finder[T], example: str, **ways: Any
) -> tuple[TextTable | ArrayTable, T]:
    """The table in a file, and what is found among its headers; ``ways`` : as of ``text_table``."""
    if path.suffix.lower() in ARRAYS:
        return _array_table(path, find)
    return text_table(Text.of(path), find, example, **ways)


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Name the file in errors; what the system and the decoder raise becomes a SceneError."""
    try:
        yield
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    except UnicodeDecodeError:
        raise SceneError(f"{path.name}: not text in UTF-8: save it as CSV in UTF-8") from None
    except (OSError, ValueError) as error:
        words = str(getattr(error, "strerror", "") or error).lower()
        raise SceneError(f"{path.name}: {words}") from None
