"""Measured responses and records in files: tables of text, MATLAB, universal files, and what their columns mean.

Lines of plainly written numbers, thousands of cells at once: each cell is the nearest float, as one by one.

The digits of a cell are a whole number w, read eight letters at a time, and its value is w 10^e. Where w and the power of ten
are floats, their quotient is the nearest one; else double-doubles tell which it is, but for one cell in 10^13 or so that may
lie half-way between two floats. Those, and cells with more digits than w holds, are read one by one. Of lines that are written
in another way (quotes, comments, rows of different lengths, what is no number) nothing is said.

Tables of numbers in text files: a header, units, lines, with every error naming file and line.

Frequency responses in files of MATLAB, by SciPy: variables named as the columns of a table.

Measured frequency responses in CSV files: what their columns mean.

Records in time in CSV files: columns t, position, force and, of a closed loop, the reference that drove it.

Frequency responses in universal files, dataset 58 (UFF58), by pyuff.

A measured response from a file of any kind: lines, or records in time.
"""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.kernel.objects import counted
from haptisym.model.estimating import estimated
from haptisym.model.measured import CONFIDENCE, Measurement, Reals, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity
from haptisym.model.welch import Estimator
from haptisym.programs.certified import Doubled, mul

_BEFORE = b"0" * 23 + b"\n"
"""Stands before the first cell, so that every word has its eight letters."""
_KEPT = np.array([0x0F0F0F0F0F0F0F0F >> 8 * (8 - n) << 8 * (8 - n) for n in range(9)], np.uint64)
"""Of a word of eight letters the values of the last n, which are digits."""
_SHIFTED = np.array([10**n for n in range(20)], np.uint64)
_TENS = 10.0 ** np.arange(23)
"""Powers of ten that floats hold exactly."""
_MOST_DIGITS, _FARTHEST = 19, 60
"""Of w, which has 64 bits; of e, where neither a product nor what it lacks can overflow or underflow."""
_DOUBT = 2.0**-100
"""Of a product in double-doubles, as a share: more than its error and that of the power of ten."""
_FEW = 0.05
"""The share of cells that are read one by one; where there are more, the table is not plain."""
_MINUS, _PLUS, _POINT, _E, _END = b"-+.e\n"
_LOWER = 32  # the bit that e has and E lacks


def plain_rows(text: str, delimiter: str, columns: int) -> Reals | None:
    """A row for each line; None where one is written in another way.

    >>> plain_rows("1,2\\n3,-.5e3\\n", ",", 2).tolist(), plain_rows("1,two\\n", ",", 2)
    ([[1.0, 2.0], [3.0, -500.0]], None)
    """
    if not text.isascii():
        return None
    if " " in text:
        text = text.replace(f"{delimiter} ", delimiter)
    cells = _cells(text.rstrip("\n").encode("ascii") + b"\n", ord(delimiter), columns)
    values = None if cells is None else _values(cells)
    return None if values is None else values.reshape(-1, columns)


class _Cells(NamedTuple):
    """w, e and sign of each, and where it stands among the letters; ``alone`` : has more digits than w holds, or a far e."""

    letters: Any
    start: Any
    stop: Any
    is_negative: Any
    digits: Any
    power: Any
    alone: Any


def _cells(text: bytes, delimiter: int, columns: int) -> _Cells | None:
    """All that is no digit has its place, or None: a sign first, a point, an e with its sign, the end."""
    letters = np.frombuffer(_BEFORE + text, np.uint8)
    marks = np.flatnonzero(letters - np.uint8(ord("0")) > 9)
    kinds = letters[marks]
    ends = np.flatnonzero((kinds == delimiter) | (kinds == _END))
    at, ends = ends[:-1] + 1, ends[1:]
    if not _is_table(kinds[ends], delimiter, columns):
        return None
    begin = marks[at - 1] + 1
    sign, is_negative = _signs(kinds, marks, at, begin)
    at += sign
    start, point = begin + sign, marks[at]
    has_point = kinds[at] == _POINT
    at += has_point
    stop, end = marks[at], marks[ends]
    words = np.ndarray(len(letters) - 7, "<u8", letters, strides=(1,))
    exponent: Any = 0
    if (has_e := kinds[at] | _LOWER == _E).any():
        at += has_e
        sign, is_below = _signs(kinds, marks, at, stop + 1)
        sign, count = sign & has_e, np.where(has_e, end - stop - 1 - (sign & has_e), 0)
        at += sign
        if (count[has_e] < 1).any() or (count > 8).any():
            return None
        exponent = _number(words, end, count).astype(np.int64)
        exponent = np.where(is_below & has_e, -exponent, exponent)
    whole, part = point - start, stop - point - has_point
    if (at != ends).any() or (whole + part < 1).any():
        return None
    left, right = _number(words, point, whole), _number(words, stop, part)
    digits, power = left * _SHIFTED.take(part, mode="clip") + right, exponent - part
    alone = whole + part > _MOST_DIGITS
    if alone.any():
        alone &= (
            (left > 0) | (whole > _MOST_DIGITS) | (part > 24) | (_word(words, stop - 16, part - 16) >= 1000)
        )  # but for zeros that lead
    alone |= np.abs(power) > _FARTHEST
    return _Cells(letters, begin, end, is_negative, digits, power, alone)


def _is_table(ends: Any, delimiter: int, columns: int) -> bool:
    """Whether cells end as those of a table do: with a delimiter, and the last of each row with its line."""
    if len(ends) % columns:
        return False
    rows = ends.reshape(-1, columns)
    return bool((rows[:, :-1] == delimiter).all() and (rows[:, -1] == _END).all())


def _signs(kinds: Any, marks: Any, at: Any, place: Any) -> tuple[Any, Any]:
    """Where a sign stands at its place, and where that is a minus."""
    own = kinds[at]
    here = marks[at] == place
    return ((own == _MINUS) | (own == _PLUS)) & here, (own == _MINUS) & here


def _number(words: Any, stop: Any, count: Any) -> Any:
    """That of the ``count`` digits before ``stop``."""
    found = _word(words, stop, count)
    for more in (8, 16):
        if count.max() > more:
            found += 10**more * _word(words, stop - more, count - more)
    return found


def _word(words: Any, stop: Any, count: Any) -> Any:
    """The same of up to eight, the bytes of a word, the first one lowest: pairs are put together, then fours, then all."""
    word = words[stop - 8] & _KEPT.take(count, mode="clip")
    for times, mask, bits in ((10, 0x00FF00FF00FF00FF, 8), (100, 0x0000FFFF0000FFFF, 16), (10_000, 0xFFFFFFFF, 32)):
        word = (times * word + (word >> bits)) & mask
    return word


def _values(x: _Cells) -> Reals | None:
    """The floats; None where too many would be read one by one."""
    alone, digits, power = x.alone, x.digits, x.power
    if alone.any():
        digits, power = (np.where(alone, 0, y) for y in (digits, power))
    if digits.max() <= 2**53 and power.min() > -len(_TENS) and power.max() <= 0:
        found: Reals = digits.astype(float) / _TENS[-power]
    else:
        found, sure = _product(digits, power)
        alone = alone | ~sure
    np.negative(found, out=found, where=x.is_negative)
    if (few := np.flatnonzero(alone)).size > _FEW * len(found) + 1:
        return None
    found[few] = [float(bytes(x.letters[x.start[i] : x.stop[i]])) for i in few.tolist()]
    return found


def _product(digits: Any, power: Any) -> tuple[Reals, Any]:
    """w 10^e, and where it is the nearest float for sure: no rounding of the double-doubles could have led to another one."""
    high = digits.astype(float)
    low = (digits - high.astype(np.uint64)).view(np.int64).astype(float)
    tens, rest = (x[power + _FARTHEST] for x in _powers())
    found, lacking, _ = mul(Doubled(high, low, None), Doubled(tens, rest, None))
    doubt = _DOUBT * found
    return found, (found + (lacking - doubt) == found) & (found + (lacking + doubt) == found)


@cache
def _powers() -> tuple[Reals, Reals]:
    """Powers of ten, as sums of two floats."""
    exact = [Fraction(10) ** e for e in range(-_FARTHEST, _FARTHEST + 1)]
    high = np.array([float(x) for x in exact])
    return high, np.array([float(x - Fraction(h)) for x, h in zip(exact, high.tolist(), strict=True)])


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
    cells = _cells_in_csvtable(header, delimiter)
    if len(cells) > 1 and all(_is_number(x) for x in cells):
        raise SceneError(f"line {at} holds numbers: the first line must name the columns, as in {form.example}")
    names, units = zip(*map(_named, cells), strict=True) if cells else ((), ())
    columns = form.check(names)
    at, first = next(lines, (at, ""))
    found = _cells_in_csvtable(first, delimiter)
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
            _refuse_line(number, _cells_in_csvtable(own, head.delimiter), head)
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


def _cells_in_csvtable(line: str, delimiter: str) -> list[str]:
    return [x.strip() for x in next(csv.reader([line], delimiter=delimiter), [])]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _has_comma(cell: str) -> bool:
    return re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) is not None


_NAMES = ("omega", "frequency_hz", "H", "real", "imag", "coherence", "radius")


def read_mat(path: Path, averages: float | None, confidence: float) -> Measurement:
    """The response in a file: ``omega`` or ``frequency_hz``; ``H``, or ``real`` and ``imag``; ``coherence`` or ``radius``.

    SceneError says what is missing. It needs SciPy, which reads files up to version 7.
    """
    try:
        refuse(path, text=False)
        rows = _variables(path)
        if ("omega" in rows) == ("frequency_hz" in rows):
            raise SceneError("the variables must hold the frequencies once: omega (rad/s) or frequency_hz")
        if "H" not in rows and not {"real", "imag"} <= set(rows):
            raise SceneError("the variables must hold the response: H, or real and imag")
        if "H" in rows and (others := [x for x in ("real", "imag") if x in rows]):
            raise SceneError(
                f"the variables hold the response twice, as H and as {' and '.join(others)}: leave out one of them"
            )
        omega = rows["omega"] if "omega" in rows else 2 * np.pi * rows["frequency_hz"]
        H = rows["H"] if "H" in rows else rows["real"] + 1j * rows["imag"]
        coherence, radius = rows.get("coherence"), rows.get("radius")
        check_certainty(coherence is not None, radius is not None, averages, confidence)
        if any(x is not None and len(x) != len(omega) for x in (H, coherence, radius)):
            raise SceneError("the variables must have as many numbers as each other")
        check_lines(_Rows(omega, H, coherence, radius), lambda i: f"line {i + 1}")  # type: ignore[arg-type]
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return Measurement(omega, H, coherence, averages, confidence, radius, name=path.name, path=path)


class _Rows(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _variables(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found = loadmat(path, variable_names=_NAMES)
    except NotImplementedError:
        raise SceneError("a file of version 7.3, which SciPy does not read: save it with -v7") from None
    except Exception as error:  # noqa: BLE001  whatever SciPy raises for what is none
        raise SceneError(f"not a file of MATLAB that can be read: {str(error).lower()}") from None
    return {key: _numbers(key, found[key]) for key in _NAMES if key in found}


def _numbers(key: str, given: Any) -> Any:
    row = np.asarray(given)
    if row.dtype.kind not in "biufc" or row.size != max(row.shape, default=0):
        raise SceneError(f"{key}: must be one row or column of numbers")
    if row.dtype.kind == "c" and key != "H":
        raise SceneError(f"{key}: must be real")
    return row.ravel().astype(complex if key == "H" else float)


COLUMNS = ("omega", "frequency_hz", "real", "imag", "magnitude", "phase_deg", "coherence", "radius")
_STIFF = ("real", "imag", "magnitude", "radius")
_PLAIN_UNITS = {
    "omega": {"rad/s": 1.0, "1/s": 1.0},
    "frequency_hz": {"Hz": 1.0, "kHz": 1000.0},
    "phase_deg": {"deg": 1.0, "°": 1.0, "degree": 1.0, "degrees": 1.0},
    "coherence": {"1": 1.0, "-": 1.0},
}


def read_measurement(path: Path, averages: float | None = None, confidence: float = CONFIDENCE) -> Measurement:
    """The response in a file; SceneError says what is wrong with it, and in which line."""
    try:
        table = read_table(path, _FORM)
        check_certainty("coherence" in table.column, "radius" in table.column, averages, confidence)
        return _measurement(table, averages, confidence)
    except SceneError as error:
        raise error.within(path.name or str(path)) from None


def _checked(names: Sequence[str]) -> tuple[str, ...]:
    if "t" in names:
        raise SceneError(
            'column "t": a record in time, not lines of a response: say how that is estimated, as --estimator H1 --segment '
            '"4 s", or with these as keys of [perceived]; H1, H2 and joint there are'
        )
    for name in names:
        if name not in COLUMNS:
            raise SceneError(f"unknown column {quoted(name)}: {meant(name, COLUMNS)}known are {', '.join(COLUMNS)}")
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    frequencies = [x for x in ("omega", "frequency_hz") if x in names]
    if len(frequencies) != 1:
        raise SceneError(
            f"{'two columns' if frequencies else 'no column'} of frequencies: give one, omega (rad/s) or frequency_hz"
        )
    forms = [pair for pair in (("real", "imag"), ("magnitude", "phase_deg")) if set(pair) & set(names)]
    if len(forms) != 1 or not set(forms[0]) <= set(names):
        raise SceneError(f"the response is written real, imag or magnitude, phase_deg: there are {', '.join(names)}")
    return tuple(names)


def _factor(column: str, unit: str) -> tuple[float, MotionKind | None]:
    """What the numbers of a column are multiplied by, and the motion that its unit implies."""
    if not unit or unit == "-":
        return 1.0, None
    known = _PLAIN_UNITS.get(column)
    if known is not None:
        if unit not in known:
            raise SceneError(
                f"{column}: the unit is {quoted(unit)}, and must be {next(iter(known))}{_otherwise(column, unit)}"
            )
        return known[unit], None
    if unit.lower().startswith("db"):
        raise SceneError(f"{column}: {quoted(unit)}: give the magnitude itself in N/m, 10^(dB/20) of what 0 dB is")
    try:
        read = quantity(f"1 {unit}", Dimension.STIFFNESS)
    except SceneError as error:
        raise SceneError(f"{column}: {error}{_velocity(unit)}") from None
    return float(read.value), read.motion


def _otherwise(column: str, unit: str) -> str:
    if column == "omega" and unit in _PLAIN_UNITS["frequency_hz"]:
        return ": call the column frequency_hz"
    return ": call the column omega" if column == "frequency_hz" and unit in _PLAIN_UNITS["omega"] else ""


def _velocity(unit: str) -> str:
    """A hint where the unit is that of force per velocity."""
    try:
        quantity(f"1 {unit}", Dimension.DAMPING)
    except SceneError:
        return ""
    return "; this is force per velocity: multiply by j omega to have force per position"


def _units(columns: Sequence[str], units: Sequence[str]) -> tuple[str, ...]:
    """A radius without a unit has that of H beside it; SceneError where one column of H has a unit and the other has none."""
    known = dict(zip(columns, units, strict=True))
    of_h = [x for x in ("real", "imag", "magnitude") if x in known]
    named, bare = [x for x in of_h if known[x]], [x for x in of_h if not known[x]]
    if named and bare:
        unit = known[named[0]]
        raise SceneError(
            f"{bare[0]} has no unit, and {named[0]} has {unit}: write {bare[0]} [{unit}], or whatever it is in"
        )
    if named and not known.get("radius", "is not there"):
        known["radius"] = known[named[0]]
    return tuple(known.values())


_FORM = Form(("omega", "frequency_hz"), _checked, _factor, "omega,real,imag,coherence", _units)


def _measurement(table: NumberTable, averages: float | None, confidence: float) -> Measurement:
    column = table.column
    omega = column["omega"] if "omega" in column else 2 * np.pi * column["frequency_hz"]
    lines: Any = _RowsInMeasuredfile(omega, _response(table), column.get("coherence"), column.get("radius"))
    check_lines(lines, table.place)
    motion, path = table.head.motion, table.path
    return Measurement(
        lines.omega, lines.H, lines.coherence, averages, confidence, lines.radius, motion, path.name, path
    )


class _RowsInMeasuredfile(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _response(table: NumberTable) -> Any:
    column = table.column
    if "real" in column:
        H = 1j * column["imag"]
        H += column["real"]
        return H
    size, phase = column["magnitude"], column["phase_deg"]
    if (size < 0).any():
        first = int(np.argmax(size < 0))
        raise SceneError(f"{table.place(first)}: magnitude: {size[first]:.6g} must be 0 or above")
    return size * np.exp(1j * np.deg2rad(phase))


RECORD_COLUMNS = {
    "t": Dimension.TIME,
    "position": Dimension.DISPLACEMENT,
    "force": Dimension.FORCE,
    "reference": Dimension.ANY,
}
_OFF = 0.75
"""Of the spacing: how far a sample may stand from its even place, or a step be from the mean step; times are rounded in files."""


def read_record(path: Path, estimator: str, **settings: Any) -> Measurement:
    """The response of the records in a file; ``settings`` : as of ``estimated``. SceneError says what is wrong, and where."""
    try:
        table = read_table(path, _FORM_RECORDFILE)
        column = table.column
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in column:
            raise SceneError("estimator: joint needs a column reference: the signal that drove the loop")
        taken = column["reference"] if joint else None
        found = estimated(
            column["position"], column["force"], _rate(table), estimator=estimator, reference=taken, name=path.name,
            motion=table.head.motion, **settings,
        )  # fmt: skip
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return replace(found, path=path)


def _checked_in_recordfile(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in RECORD_COLUMNS:
            raise SceneError(
                f"unknown column {quoted(name)}: {meant(name, RECORD_COLUMNS)}of records are known {', '.join(RECORD_COLUMNS)}"
            )
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    missing = [x for x in RECORD_COLUMNS if x not in names and x != "reference"]
    if missing:
        raise SceneError(f"no column {missing[0]}: records in time have t, position and force")
    return tuple(names)


def _factor_in_recordfile(column: str, unit: str) -> tuple[float, MotionKind | None]:
    if not unit or unit == "-" or column == "reference":
        return 1.0, None
    try:
        read = quantity(f"1 {unit}", RECORD_COLUMNS[column])
    except SceneError as error:
        raise SceneError(f"{column}: {error}") from None
    return float(read.value), read.motion


_FORM_RECORDFILE = Form(("t",), _checked_in_recordfile, _factor_in_recordfile, "t,position,force")


def _rate(table: NumberTable) -> float:
    """Samples a second. SceneError where samples are not even."""
    t = table.column["t"]
    for key, row in table.column.items():
        if not np.isfinite(row).all():
            raise SceneError(f"{table.place(int(np.argmin(np.isfinite(row))))}: {key}: must be finite")
    if len(t) < 2 or t[-1] <= t[0]:
        raise SceneError("t: must rise from sample to sample")
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    off = np.abs(t - even) > _OFF * step
    jumps = np.abs(np.diff(t) - step) > _OFF * step
    if jumps.any() or off.any():
        first = int(np.argmax(jumps)) + 1 if jumps.any() else int(np.argmax(off))
        told = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{table.place(first)}: t: {told}: a gap, or not sampled evenly; resample the record first")
    return float(1 / step)


_RESPONSE, _COHERENCE = 4, 6
"""What a dataset holds, its ``func_type``."""
_FORCES, _DISPLACEMENT, _UNKNOWN, _FREQUENCY = (9, 13), 8, 0, 18
"""What an axis holds, its ``spec_data_type``."""


def read_uff(path: Path, averages: float | None, confidence: float) -> Measurement:
    """The one frequency response in a file, force per displacement in SI, with its coherence if that is there.

    SceneError for a file with none or several, and for other quantities than force and displacement. It needs pyuff.
    """
    try:
        refuse(path, text=False)
        sets = _sets(path)
        found = [x for x in sets if x.get("func_type") == _RESPONSE]
        if len(found) != 1:
            raise SceneError(f"there are {counted(len(found), 'frequency response')} in it, and must be one")
        _check_axes(found[0])
        omega, H = 2 * np.pi * np.asarray(found[0]["x"], dtype=float), np.asarray(found[0]["data"], dtype=complex)
        coherence = _coherence(sets, found[0])
        check_certainty(coherence is not None, False, averages, confidence)  # noqa: FBT003
        check_lines(_RowsInUff(omega, H, coherence, None), lambda i: f"line {i + 1}")  # type: ignore[arg-type]
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return Measurement(omega, H, coherence, averages, confidence, name=path.name, path=path)


class _RowsInUff(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _sets(path: Path) -> list[dict[str, Any]]:
    """The datasets 58 of a file."""
    import pyuff

    try:
        with _files_left_open():
            file = pyuff.UFF(str(path))
            kinds = [int(x) for x in file.get_set_types()]
            return [file.read_sets(i) for i, kind in enumerate(kinds) if kind == 58]
    except Exception as error:  # noqa: BLE001  pyuff raises plain ones
        raise SceneError(f"not a universal file that can be read: {str(error).lower()}") from None


@contextmanager
def _files_left_open() -> Iterator[None]:
    """pyuff leaves files to be closed by the collector, which warns of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _check_axes(found: dict[str, Any]) -> None:
    above, below = found.get("ordinate_spec_data_type", 0), found.get("orddenom_spec_data_type", 0)
    if above not in (*_FORCES, _UNKNOWN) or below not in (_DISPLACEMENT, _UNKNOWN):
        raise SceneError(
            f"the response is not force per displacement (data types {above} over {below}): turn it over, or multiply it by "
            "powers of j omega, until it is"
        )


def _coherence(sets: list[dict[str, Any]], response: dict[str, Any]) -> Any:
    found = [x for x in sets if x.get("func_type") == _COHERENCE]
    if not found:
        return None
    if len(found) > 1 or not np.array_equal(found[0]["x"], response["x"]):
        raise SceneError("its coherence must be one dataset, at the frequencies of the response")
    return np.clip(np.real(found[0]["data"]), 0, 1)


def shown_hertz(hertz: Any) -> Any:
    """Frequencies with the six digits that a universal file has for them.

    >>> shown_hertz([1 / 3, 2]).tolist()
    [0.333333, 2.0]
    """
    return np.array([float(f"{x:.5e}") for x in hertz])


def write_uff(m: Measurement, path: str | Path) -> Path:
    """Write the lines, and their coherence, as datasets 58: twelve digits of each part, six of each frequency in Hz."""
    import pyuff

    rows = [(_RESPONSE, m.H)] + ([(_COHERENCE, m.coherence)] if m.coherence is not None else [])
    with _files_left_open():
        for i, (kind, data) in enumerate(rows):
            pyuff.UFF(str(path)).write_sets(_dataset(m, kind, data), "add" if i else "overwrite")
    return Path(path)


def _dataset(m: Measurement, kind: int, data: Any) -> dict[str, Any]:
    import pyuff

    hertz = m.omega / (2 * np.pi)
    above, below = (_FORCES[1], _DISPLACEMENT) if kind == _RESPONSE else (_UNKNOWN, _UNKNOWN)
    made: dict[str, Any] = pyuff.prepare_58(
        binary=0, func_type=kind, data=data, x=hertz, id1=m.name[:80] or "haptisym", id2="NONE", id3="NONE", id4="NONE",
        id5="NONE", ver_num=0, load_case_id=0, rsp_ent_name="NONE", rsp_node=1, rsp_dir=1, ref_ent_name="NONE", ref_node=1,
        ref_dir=1, ord_data_type=6 if kind == _RESPONSE else 4, num_pts=len(hertz), abscissa_spacing=0,
        abscissa_min=float(hertz[0]), abscissa_inc=0.0, z_axis_value=0.0, abscissa_spec_data_type=_FREQUENCY,
        ordinate_spec_data_type=above, orddenom_spec_data_type=below,
    )  # fmt: skip
    return made


RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""Keys of a response that is estimated from records in time."""


_LINES = {".uff": read_uff, ".unv": read_uff, ".mat": read_mat}
"""By the ending of a file what reads its lines; all other files are tables."""


def read_file(path: Path, averages: float | None, confidence: float, records: Mapping[str, Any]) -> Measurement:
    """The response in a file; of records in time where an estimator is named."""
    if not records:
        return _LINES.get(path.suffix.lower(), read_measurement)(path, averages, confidence)
    for key in records:
        if key not in RECORDS:
            raise SceneError(f'unknown key "{key}": {meant(key, RECORDS)}valid are {", ".join(RECORDS)}')
    if not isinstance(records.get("estimator"), str):
        raise SceneError(
            "estimator is missing: of records in time say by which, H1, H2 or joint, the response is estimated"
        )
    if averages is not None:
        raise SceneError("averages: of records in time they follow from the segments: leave it out")
    return read_record(path, confidence=confidence, **records)
