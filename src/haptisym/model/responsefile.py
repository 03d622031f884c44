"""Measured responses and records in files: tables of text and files of MATLAB, and what their columns mean.

A table has a header that names its columns, units in the header or in a row below it, and lines of numbers; every error names
file and line. NumPy reads the numbers, each to the nearest float. Where it cannot, ``csv`` finds the cell that is no number. Of
files of MATLAB, which SciPy reads, the variables are named as the columns of a table.

The columns tell what a file holds: with frequencies the lines of a response, with ``t`` a record of motion and force, from which
a response is estimated.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, islice
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.model.estimating import estimated
from haptisym.model.measured import CONFIDENCE, Estimator, Measurement, Reals, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity

LARGEST = 500_000_000
"""Bytes of a file."""
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
    """The table in a file; SceneError gives the line and what is wrong."""
    try:
        refuse(path)
        with path.open(encoding="utf-8-sig") as file:
            head = _head(file, form)
            return NumberTable(path, head, _rows(path, file, head))
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
        raise SceneError(f"line {at} has numbers: name the columns in the first line, as {form.example}")
    names, units = zip(*map(_named, cells), strict=True) if cells else ((), ())
    columns = form.check(names)
    at, first = next(lines, (at, ""))
    found = _cells(first, delimiter)
    if _is_unit(dict(zip(columns, found, strict=False)), form):
        if any(units):
            raise SceneError(f"units are in the header and in line {at}: leave out one of them")
        if len(found) != len(columns):
            raise SceneError(f"line {at} has {len(found)} units, the header {len(columns)} columns")
        units = tuple(found)
        at, first = next(lines, (at, ""))
    if not first:
        raise SceneError("there are no lines of numbers")
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


def _rows(path: Path, file: TextIO, head: Head) -> Reals:
    lines = _numbered(chain([head.first], file), head.line)
    # where another delimiter stands, a comma can only stand before decimals
    texts = (text if head.delimiter == "," else text.replace(",", ".") for _, text in lines)
    try:
        rows: Reals = np.loadtxt(texts, delimiter=head.delimiter, ndmin=2, comments=None, quotechar='"', dtype=float)
        is_whole = rows.shape[1] == len(head.columns)
    except ValueError:
        is_whole = False
    if not is_whole:
        with path.open(encoding="utf-8-sig") as again:
            for number, own in _numbered(islice(again, head.line - 1, None), head.line):
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
        raise SceneError(f"line {number} has {len(cells)} cells, the header {len(head.columns)} columns{hint}")
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


_NAMES = ("omega", "frequency_hz", "H", "real", "imag", "coherence", "radius")


def read_mat(path: Path, averages: float | None, confidence: float) -> Measurement:
    """The response in a file: ``omega`` or ``frequency_hz``; ``H``, or ``real`` and ``imag``; ``coherence`` or ``radius``.

    SceneError says what is missing. It needs SciPy, which reads files up to version 7.
    """
    try:
        refuse(path, text=False)
        rows = _variables(path)
        if ("omega" in rows) == ("frequency_hz" in rows):
            raise SceneError("give the frequencies as one variable: omega (rad/s) or frequency_hz")
        if "H" not in rows and not {"real", "imag"} <= set(rows):
            raise SceneError("the response is missing: give the variable H, or real and imag")
        if "H" in rows and (others := [x for x in ("real", "imag") if x in rows]):
            raise SceneError(f"the response is there twice, as H and as {' and '.join(others)}: leave out one of them")
        omega = rows["omega"] if "omega" in rows else 2 * np.pi * rows["frequency_hz"]
        H = rows["H"] if "H" in rows else rows["real"] + 1j * rows["imag"]
        coherence, radius = rows.get("coherence"), rows.get("radius")
        if any(x is not None and len(x) != len(omega) for x in (H, coherence, radius)):
            raise SceneError("give as many numbers in each variable")
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return Measurement(omega, H, coherence, averages, confidence, radius, name=path.name, path=path)


def _variables(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found = loadmat(path, variable_names=_NAMES)
    except NotImplementedError:
        raise SceneError("version 7.3, which SciPy does not read: save it with -v7") from None
    except Exception as error:  # noqa: BLE001  whatever SciPy raises for what is none
        raise SceneError(f"not a readable MATLAB file: {str(error).lower()}") from None
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
    """The response in a file; SceneError gives the line and what is wrong."""
    try:
        table = read_table(path, _LINES)
        check_certainty("coherence" in table.column, "radius" in table.column, averages, confidence)
        return _measurement(table, averages, confidence)
    except SceneError as error:
        raise error.within(path.name or str(path)) from None


def _line_columns(names: Sequence[str]) -> tuple[str, ...]:
    if "t" in names:
        raise SceneError(
            'column "t": for records in time add an estimator, as estimator = "H1" and segment = "4 s" in [perceived], or '
            '--estimator H1 --segment "4 s"; valid are H1, H2, joint'
        )
    for name in names:
        if name not in COLUMNS:
            raise SceneError(f"unknown column {quoted(name)}: {meant(name, COLUMNS)}valid are {', '.join(COLUMNS)}")
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    frequencies = [x for x in ("omega", "frequency_hz") if x in names]
    if len(frequencies) != 1:
        raise SceneError(
            f"{'two columns' if frequencies else 'no column'} of frequencies: give one, omega (rad/s) or frequency_hz"
        )
    forms = [pair for pair in (("real", "imag"), ("magnitude", "phase_deg")) if set(pair) & set(names)]
    if len(forms) != 1 or not set(forms[0]) <= set(names):
        raise SceneError(
            f"give the response in columns real, imag or magnitude, phase_deg: there are {', '.join(names)}"
        )
    return tuple(names)


def _line_factor(column: str, unit: str) -> tuple[float, MotionKind | None]:
    """What the numbers of a column are multiplied by, and the motion that its unit implies."""
    if not unit or unit == "-":
        return 1.0, None
    known = _PLAIN_UNITS.get(column)
    if known is not None:
        if unit not in known:
            raise SceneError(
                f"{column}: the unit must be {next(iter(known))}, not {quoted(unit)}{_otherwise(column, unit)}"
            )
        return known[unit], None
    if unit.lower().startswith("db"):
        raise SceneError(f"{column}: {quoted(unit)}: give the magnitude in N/m, 10^(dB/20) times the value at 0 dB")
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
        raise SceneError(f"{bare[0]} has no unit, and {named[0]} has {unit}: write {bare[0]} [{unit}]")
    if named and not known.get("radius", "is not there"):
        known["radius"] = known[named[0]]
    return tuple(known.values())


_LINES = Form(("omega", "frequency_hz"), _line_columns, _line_factor, "omega,real,imag,coherence", _units)


def _measurement(table: NumberTable, averages: float | None, confidence: float) -> Measurement:
    column = table.column
    omega = column["omega"] if "omega" in column else 2 * np.pi * column["frequency_hz"]
    H, coherence, radius = _response(table), column.get("coherence"), column.get("radius")
    check_lines(omega, H, coherence, radius, table.place)
    motion, path = table.head.motion, table.path
    return Measurement(omega, H, coherence, averages, confidence, radius, motion, path.name, path)


def _response(table: NumberTable) -> Any:
    column = table.column
    if "real" in column:
        return column["real"] + 1j * column["imag"]
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
        table = read_table(path, _RECORD)
        column = table.column
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in column:
            raise SceneError("estimator: joint needs the column reference, the signal that drives the loop")
        taken = column["reference"] if joint else None
        found = estimated(
            column["position"], column["force"], _rate(table), estimator=estimator, reference=taken, name=path.name,
            motion=table.head.motion, **settings,
        )  # fmt: skip
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return replace(found, path=path)


def _record_columns(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in RECORD_COLUMNS:
            raise SceneError(
                f"unknown column {quoted(name)}: {meant(name, RECORD_COLUMNS)}records in time have {', '.join(RECORD_COLUMNS)}"
            )
        if names.count(name) > 1:
            raise SceneError(f"column {name} is there twice")
    missing = [x for x in RECORD_COLUMNS if x not in names and x != "reference"]
    if missing:
        raise SceneError(f"no column {missing[0]}: records in time have t, position and force")
    return tuple(names)


def _record_factor(column: str, unit: str) -> tuple[float, MotionKind | None]:
    if not unit or unit == "-" or column == "reference":
        return 1.0, None
    try:
        read = quantity(f"1 {unit}", RECORD_COLUMNS[column])
    except SceneError as error:
        raise SceneError(f"{column}: {error}") from None
    return float(read.value), read.motion


_RECORD = Form(("t",), _record_columns, _record_factor, "t,position,force")


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
        gap = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{table.place(first)}: t: {gap}: resample the record evenly")
    return float(1 / step)


RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""Keys of a response that is estimated from records in time."""


def read_file(path: Path, averages: float | None, confidence: float, records: Mapping[str, Any]) -> Measurement:
    """The response in a file; of records in time where an estimator is named."""
    if not records:
        refuse_universal(path)
        read = read_mat if path.suffix.lower() == ".mat" else read_measurement
        return read(path, averages, confidence)
    for key in records:
        if key not in RECORDS:
            raise SceneError(f'unknown key "{key}": {meant(key, RECORDS)}valid are {", ".join(RECORDS)}')
    if not isinstance(records.get("estimator"), str):
        raise SceneError('estimator is missing: add estimator = "H1", "H2" or "joint"')
    if averages is not None:
        raise SceneError("averages: leave it out, as it follows from the segments")
    return read_record(path, confidence=confidence, **records)


def refuse_universal(path: Path) -> None:
    """SceneError for the name of a universal file (dataset 58)."""
    if path.suffix.lower() in (".uff", ".unv"):
        raise SceneError(
            f"{path.name}: universal files are not read: use CSV with the columns frequency_hz, real, imag "
            "and coherence (pyuff reads the datasets of a universal file)"
        )
