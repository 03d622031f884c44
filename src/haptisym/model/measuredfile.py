"""Measured frequency responses in CSV files: their columns, units and lines, with every error naming file and line."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.model.measured import CONFIDENCE, Measurement, Reals, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity

LARGEST = 500_000_000
"""Bytes of a file."""
COLUMNS = ("omega", "frequency_hz", "real", "imag", "magnitude", "phase_deg", "coherence", "radius")
_STIFF = ("real", "imag", "magnitude", "radius")
_PLAIN_UNITS = {
    "omega": {"rad/s": 1.0, "1/s": 1.0},
    "frequency_hz": {"Hz": 1.0, "kHz": 1000.0},
    "phase_deg": {"deg": 1.0, "°": 1.0, "degree": 1.0, "degrees": 1.0},
    "coherence": {"1": 1.0, "-": 1.0},
}
_NOT_TEXT = (b"PK", b"\x89", b"MATLAB", b"\x80", b"\xff\xfe", b"\xfe\xff")


def read_measurement(path: Path, averages: float | None = None, confidence: float = CONFIDENCE) -> Measurement:
    """The response in a file; SceneError says what is wrong with it, and in which line."""
    try:
        _refuse(path)
        with path.open(encoding="utf-8-sig") as file:
            head = _head(file)
            check_certainty("coherence" in head.columns, "radius" in head.columns, averages, confidence)
            rows = _rows(path, file, head)
        return _measurement(path, head, rows, averages, confidence)
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    except UnicodeDecodeError:
        raise SceneError(f"{path.name}: not text in UTF-8: save it as CSV in UTF-8") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: {str(getattr(error, 'strerror', '') or error).lower()}") from None


def _refuse(path: Path) -> None:
    if path.is_dir():
        raise SceneError("this is a folder: name a file in it")
    if not path.exists():
        raise SceneError(f"there is no such file{_near(path)}")
    if not path.is_file():
        raise SceneError("this is no regular file")
    if path.stat().st_size > LARGEST:
        raise SceneError(f"the file has more than {LARGEST} bytes")
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


def _head(file: TextIO) -> Head:
    lines = ((i, x) for i, x in enumerate(file, 1) if x.strip() and not x.lstrip().startswith("#"))
    at, header = next(lines, (0, ""))
    delimiter = max("\t;,", key=header.count)
    cells = _cells(header, delimiter)
    if len(cells) > 1 and all(_is_number(x) for x in cells):
        raise SceneError(
            f"line {at} holds numbers: the first line must name the columns, as in omega,real,imag,coherence"
        )
    names, units = zip(*map(_named, cells), strict=True) if cells else ((), ())
    columns = _checked(names)
    at, first = next(lines, (at, ""))
    found = _cells(first, delimiter)
    if _is_unit(dict(zip(columns, found, strict=False))):
        if any(units):
            raise SceneError(f"line {at} has units, and so has the header: leave out one of them")
        if len(found) != len(columns):
            raise SceneError(f"line {at} has {len(found)} units, and the header names {len(columns)} columns")
        units = tuple(found)
        at, first = next(lines, (at, ""))
    if not first:
        raise SceneError("there are no lines of numbers in it")
    factors, motion = _factors(columns, units)
    return Head(columns, factors, motion, delimiter, first, at)


def _is_unit(cells: Mapping[str, str]) -> bool:
    """Whether a line has a unit where its frequency would stand."""
    cell = cells.get("omega", cells.get("frequency_hz", ""))
    return bool(cell) and not _is_number(cell) and not _has_comma(cell)


def _named(cell: str) -> tuple[str, str]:
    """``real [N/m]`` is a name and a unit."""
    match = re.fullmatch(r"(.*?)\s*[\[(](.*)[\])]", cell)
    name, unit = match.groups() if match else (cell, "")
    return name.strip().lower(), unit.strip()


def _checked(names: Sequence[str]) -> tuple[str, ...]:
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


def _factors(columns: Sequence[str], units: Sequence[str]) -> tuple[tuple[float, ...], MotionKind | None]:
    found = [_factor(*x) for x in zip(columns, units, strict=True)]
    motions = {motion for _, motion in found if motion}
    if len(motions) > 1:
        raise SceneError("units: translation and rotation cannot be mixed")
    return tuple(factor for factor, _ in found), next(iter(motions), None)


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


# The lines of numbers.


def _rows(path: Path, file: TextIO, head: Head) -> Reals:
    try:
        rows: Reals = np.loadtxt(
            chain([head.first], file), delimiter=head.delimiter, ndmin=2, comments="#", quotechar='"', dtype=float
        )
        is_whole = rows.shape[1] == len(head.columns)
    except UnicodeDecodeError:
        raise
    except ValueError:
        is_whole = False
    if not is_whole:
        for number, line in _numbered(path, head):
            _refuse_line(number, _cells(line, head.delimiter), head)
        raise SceneError("not a table of numbers")
    return rows


def _numbered(path: Path, head: Head) -> Iterator[tuple[int, str]]:
    """The lines of numbers, as text."""
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, 1):
            if number >= head.line and (text := line.partition("#")[0]).strip():
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


# What they say.


@dataclass(frozen=True)
class _Line:
    """The place of a row in the file."""

    path: Path
    head: Head

    def __call__(self, row: int) -> str:
        number = next(n for i, (n, _) in enumerate(_numbered(self.path, self.head)) if i == row)
        return f"line {number}"


def _measurement(path: Path, head: Head, rows: Reals, averages: float | None, confidence: float) -> Measurement:
    column = {x: rows[:, i] * factor for i, (x, factor) in enumerate(zip(head.columns, head.factors, strict=True))}
    omega = column["omega"] if "omega" in column else 2 * np.pi * column["frequency_hz"]
    lines: Any = _Rows(omega, _response(column, _Line(path, head)), column.get("coherence"), column.get("radius"))
    check_lines(lines, _Line(path, head))
    motion, name = head.motion, path.name
    return Measurement(lines.omega, lines.H, lines.coherence, averages, confidence, lines.radius, motion, name, path)


class _Rows(NamedTuple):
    omega: Any
    H: Any
    coherence: Any
    radius: Any


def _response(column: Mapping[str, Reals], place: _Line) -> Any:
    if "real" in column:
        return column["real"] + 1j * column["imag"]
    size, phase = column["magnitude"], column["phase_deg"]
    if (size < 0).any():
        first = int(np.argmax(size < 0))
        raise SceneError(f"{place(first)}: magnitude: {size[first]:.6g} must be 0 or above")
    return size * np.exp(1j * np.deg2rad(phase))
