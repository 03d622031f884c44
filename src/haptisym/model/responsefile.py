"""Measured responses, records and motions in files: tables of text, files of MATLAB and of NumPy,
read into numbers in SI.

With X the motion, F the force, H = F/X::

    impedance F/V          H = j omega Z        receptance X/F      H = 1/R
    apparent mass F/A      H = -omega^2 M       mobility V/F        H = j omega/Y
                                                accelerance A/F     H = -omega^2/A

A disc of radius rho |Y| about Y becomes one about 1/Y within rho/(1 - rho) |1/Y|; for rho >= 1 it
is unbounded.

A table has separators (comma, semicolon, tab, blanks), comments (``#``, ``%``, ``*``), maybe a row
of units below its header, and numbers, each read by NumPy to the nearest float; every error names
file and line. Where the separator is no comma, a comma stands before decimals. A table begins where
numbers begin: its header is the line above them, or above a row of units. FRD and ZMA files are Hz,
magnitude (dB of 1 N/m; as it is) and degrees. SciPy reads files of MATLAB, NumPy its own archives.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice, takewhile
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.kernel.objects import counted
from haptisym.model.columns import (
    QUANTITIES,
    RECORD,
    RESPONSE,
    ColumnHeader,
    Layout,
    Scale,
    agreed,
    assigned,
    column_of,
    is_unit,
    known_role,
    scales_of,
)
from haptisym.model.estimating import estimated
from haptisym.model.measured import CONFIDENCE, Estimator, Measurement, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity

LARGEST = 500_000_000
"""The most bytes that a file may have."""
# How archives, images, files of MATLAB, HDF5 or pickles, and UTF-16 begin.
_NOT_TEXT = (b"PK", b"\x89", b"MATLAB", b"\x80", b"\xff\xfe", b"\xfe\xff")
_COMMENTS = "#%*"


def refuse(path: Path, *, text: bool = True) -> None:
    """SceneError unless there is a regular file of a size that can be read, and of ``text`` if that
    is wanted."""
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
    """The end of a message on a missing file: a similar name in its folder, or the folder."""
    folder = path.parent
    if not folder.is_dir():
        return f", and no folder {folder}"
    hint = meant(path.name, sorted(x.name for x in folder.iterdir() if x.is_file())).rstrip()
    return f"; {hint}" if hint else f" in {folder.name or 'this folder'}"


# Tables of text.


class Head(NamedTuple):
    """What stands before the numbers: the columns, the separator of cells (None for blanks), and
    the first line of numbers with its line number."""

    columns: tuple[ColumnHeader, ...]
    separator: str | None
    first: str
    line: int


@dataclass(frozen=True, eq=False)
class Given:
    """The content of a file: its columns, the numbers in SI of those in use by role, and ``place``,
    which gives the place of a row in words."""

    path: Path
    head: Sequence[ColumnHeader]
    roles: Mapping[str, int]
    scales: Mapping[str, Scale]
    rows: Mapping[str, Any]
    place: Callable[[int], str]
    notes: tuple[str, ...] = ()

    def understood(self, *more: str) -> str:
        """How the file was understood, for a page: ``10 lines; Hz, dB, deg; sorted``."""
        units = [x.unit for role, x in self.scales.items() if x.unit and role != "radius"]
        used = self.roles.values()
        unused = [x.text for i, x in enumerate(self.head) if x.text and i not in used]
        spare = ""
        if unused:
            spare = f"not used: {', '.join(unused[:5])}"
            spare += ", ..." if len(unused) > 5 else ""
        lines = counted(len(next(iter(self.rows.values()))), "line")
        notes = (lines, ", ".join(dict.fromkeys(units)), *self.notes, *more, spare)
        return "; ".join(x for x in notes if x)

    @property
    def motion(self) -> MotionKind | None:
        """The motion that the units imply; None where none does."""
        return next((x.motion for x in self.scales.values() if x.motion), None)


Check = Callable[[Sequence[ColumnHeader], Layout], dict[str, int]]
"""A function that finds the column of each role. SceneError where one is missing."""


def _read_text(path: Path, layout: Layout, check: Check, example: str) -> Given:
    """Read a table of text; ``example`` : a header for the message where there is none."""
    try:
        refuse(path)
        with path.open(encoding="utf-8-sig") as file:
            head, roles = _understood_head(file, path, layout, check, example)
            head = _with_units(file, head, roles)
            scales = scales_of(head.columns, roles, layout)
            rows, blank = _rows(path, file, head, roles, scales)
    except UnicodeDecodeError:
        raise SceneError("not text in UTF-8: save it as CSV in UTF-8") from None
    except SceneError:
        raise
    except (OSError, ValueError) as error:
        raise SceneError(str(getattr(error, "strerror", "") or error).lower()) from None

    def place(row: int) -> str:
        """The line of a row of numbers: read again, as only an error asks for it."""
        with path.open(encoding="utf-8-sig") as again:
            lines = _numbered(islice(again, head.line - 1, None), head.line)
            number, _ = next(islice(lines, row, None))
            return f"line {number}"

    notes = ["decimal commas"] if head.separator != "," and "," in head.first else []
    notes += [f"{counted(blank, 'blank row')} left out"] if blank else []
    return Given(path, head.columns, roles, scales, rows, place, tuple(notes))


def _understood_head(
    file: TextIO, path: Path, layout: Layout, check: Check, example: str
) -> tuple[Head, dict[str, int]]:
    """The header and its roles: at the top, or else above the first line of numbers, after what an
    instrument writes before."""
    # The first try is a header in the first line; its error is raised where no other line can be
    # the header, as it says what most users must mend.
    try:
        head = _head(file, path, layout, example)
        _need_numbers(path, head)
        return head, check(head.columns, layout)
    except SceneError:
        file.seek(0)
        start = _line_of_header(file)
        if start is None:
            raise
    file.seek(0)
    head = _head(file, path, layout, example, start)
    return head, check(head.columns, layout)


def _line_of_header(file: TextIO) -> int | None:
    """The number of the line that names the columns, where others come before it: the last one
    above the numbers, or the one above a row of units; None where there are no two lines above.

    Numbers begin with two lines in a row that have as many cells: a preamble may hold a line of
    numbers, too.
    """
    before: list[tuple[int, list[str]]] = []
    above_numbers, width = before, 0
    for at, line in _numbered(file, 1):
        cells = [x for x in _cells(line, _separator(line)) if x]
        is_numbers = len(cells) > 1 and all(map(_is_number, cells))
        if is_numbers and len(cells) == width:
            break
        above_numbers, width = (before, len(cells)) if is_numbers else (above_numbers, 0)
        before = [*before[-1:], (at, _names(line))]
    if len(above_numbers) < 2:
        return None
    (above, names), (last, cells) = above_numbers
    has_units = len(names) == len(cells) and all(map(is_unit, cells))
    return above if has_units else last


def _head(file: TextIO, path: Path, layout: Layout, example: str, start: int = 1) -> Head:
    """The header: the first line from ``start`` on, or a comment before a line of numbers that has
    as many cells."""
    comments: list[str] = []
    for at, line in enumerate(islice(file, start - 1, None), start):
        if not line.strip():
            continue
        if line.lstrip()[0] in _COMMENTS:
            comments.append(line.strip().lstrip("#*% "))
            continue
        separator = _separator(line)
        cells = _cells(line, separator)
        # A line without a number is the header; the first line of numbers tells the separator, as
        # a header may have blanks, or brackets with commas, in its names.
        if not any(map(_is_number, cells)):
            number, first = next(_numbered(file, at + 1), (at, ""))
            if not first:
                break
            names = _names(line)
            # LabVIEW names a column for remarks and leaves it out of the lines.
            if names[-1] == "Comment":
                count = len(_cells(first.rstrip(), _separator(first, line)))
                if count < len(names):
                    names.pop()
            return Head(tuple(map(column_of, names)), _separator(first, line), first, number)
        # Numbers at once: the kind of file, a comment above or the scene must name the columns.
        if len(cells) > 1 and path.suffix.lower() in (".frd", ".zma"):
            kind = "Magnitude (dB)" if path.suffix.lower() == ".frd" else "Magnitude"
            names = ["Frequency (Hz)", kind, "Phase (deg)"]
        elif comments and len(cells) > 1 and len(names := _names(comments[-1])) == len(cells):
            pass
        elif any(isinstance(x, int) for x in layout.columns.values()):
            names = [str(i + 1) for i in range(len(cells))]
        else:
            raise SceneError(
                f"line {at} has numbers: name the columns in the first line, as {example}"
            )
        return Head(tuple(map(column_of, names)), separator, line, at)
    raise SceneError("there are no lines of numbers")


def _need_numbers(path: Path, head: Head) -> None:
    """SceneError unless one of the two lines below the header has two numbers or more.

    The message repeats nothing of the file: a scene from a stranger may name any file.
    """
    with path.open(encoding="utf-8-sig") as again:
        first = [x for _, x in islice(_numbered(islice(again, head.line - 1, None), head.line), 2)]
    if not any(sum(map(_is_number, _cells(x, _separator(x) or head.separator))) > 1 for x in first):
        raise SceneError(
            "there are no lines of numbers, two or more in each, below names of columns"
        )


def _with_units(file: TextIO, head: Head, roles: Mapping[str, int]) -> Head:
    """The header with the units of the row below it, where that row has no number in the first
    column in use; else the header as it is."""
    units, first = _cells(head.first, head.separator), min(roles.values())
    if (
        first >= len(units)
        or not units[first]
        or _is_number(units[first])
        or _has_comma(units[first])
    ):
        return head
    if any(x.unit for x in head.columns if x.text.endswith(("]", ")"))):
        raise SceneError(f"units are in the header and in line {head.line}: leave out one of them")
    if len(units) != len(head.columns):
        raise SceneError(
            f"line {head.line} has {len(units)} units, the header {len(head.columns)} columns"
        )
    columns = tuple(
        x._replace(unit=agreed(x.text, x.unit or unit, unit))
        for x, unit in zip(head.columns, units, strict=True)
    )
    number, line = next(_numbered(file, head.line + 1), (0, ""))
    if not line:
        raise SceneError("there are no lines of numbers")
    return Head(columns, _separator(line, head.first), line, number)


def _rows(
    path: Path, file: TextIO, head: Head, roles: Mapping[str, int], scales: Mapping[str, Scale]
) -> tuple[dict[str, Any], int]:
    """The numbers of each role, and how many rows without any were left out."""
    used, width, is_complex = sorted(set(roles.values())), len(head.columns), "H" in roles
    blank: list[int] = []

    def lines() -> Iterator[str]:
        """The lines of numbers as NumPy reads them."""
        for number, text in _numbered(chain([head.first], file), head.line, blank):
            # Where another separator stands, a comma can only stand before decimals.
            plain = text if head.separator == "," else text.replace(",", ".")
            # NumPy counts only the columns that it uses: where some are left out, a line of another
            # length is found here.
            if len(used) < width and '"' not in text and len(plain.split(head.separator)) != width:
                _refuse_line(number, _cells(text, head.separator), head, used)
            yield _without_i(plain, head.separator) if is_complex else plain

    try:
        kept = None if len(used) == width else used
        kind: Any = complex if is_complex else float
        table: Any = np.loadtxt(
            lines(),
            kind,
            delimiter=head.separator,
            ndmin=2,
            comments=None,
            quotechar='"',
            usecols=kept,
        )
        is_whole = table.shape[1] == len(used)
    except SceneError:
        raise
    except ValueError:
        is_whole = False
    # NumPy is fast and its messages are about arrays: the file is read again, slowly, to name line
    # and column of what is wrong.
    if not is_whole:
        with path.open(encoding="utf-8-sig") as again:
            for number, own in _numbered(islice(again, head.line - 1, None), head.line):
                _refuse_line(number, _cells(own, head.separator), head, used)
        raise SceneError("not a table of numbers")
    rows = {role: table[:, used.index(i)] for role, i in roles.items()}
    # A column called H with real numbers alone is most likely a magnitude; 799+0j says it is not.
    if is_complex and not rows["H"].imag.any() and not re.search(r"\d\s*\*?[ijIJ]", head.first):
        raise SceneError(
            f"{head.columns[roles['H']].text}: has no complex numbers, as 799+30j: add a "
            f"column of the phase"
        )
    return {
        role: (row if role == "H" else row.real) * scales[role].factor for role, row in rows.items()
    }, len(blank)


def _without_i(text: str, separator: str | None) -> str:
    """A line with complex numbers like ``(799 + 30i)`` as NumPy reads them, ``799+30j``."""
    # Blanks inside a number can be taken out unless they, or tabs, separate the cells.
    bare = re.sub(r"[()]" if separator in (None, "\t") else r"[() ]", "", text)
    return re.sub(r"(?<=[\d.])\s*\*?[iIjJ](?![A-Za-z])", "j", bare)


def _numbered(
    lines: Iterable[str], first: int, blank: list[int] | None = None
) -> Iterator[tuple[int, str]]:
    """The lines that are not empty and no comments, without comments at their ends, each with its
    line number; the line numbers of those that hold separators alone go to ``blank``."""
    for number, line in enumerate(lines, first):
        text = line.partition("#")[0]
        if not text.strip() or text.lstrip()[0] in _COMMENTS:
            continue
        if text.strip(' \t,;"\r\n'):
            yield number, text
        elif blank is not None:
            blank.append(number)


def _refuse_line(number: int, cells: Sequence[str], head: Head, used: Sequence[int]) -> None:
    """SceneError if a line has too few or too many cells, or a cell in use that is no number."""
    # Twice as many cells as columns: each number with a decimal comma was cut in two.
    hint = ""
    if (
        len(cells) > len(head.columns)
        and head.separator == ","
        and len(cells) == 2 * len(head.columns)
    ):
        hint = (
            "; if these are decimal commas, separate columns by semicolons, or write decimals "
            "with a point"
        )
    if len(cells) != len(head.columns):
        raise SceneError(
            f"line {number} has {len(cells)} cells, the header {len(head.columns)} columns{hint}"
        )
    for i in used:
        cell, name = cells[i], head.columns[i].text
        if head.separator == "," and _has_comma(cell):
            right = cell.replace(",", ".")
            raise SceneError(
                f"line {number}: {name}: {quoted(cell)}: decimals are written with a point, "
                f"as in {right}"
            )
        if not _is_number(cell):
            what = f"{quoted(cell)} is not a number" if cell else "the cell is empty"
            raise SceneError(f"line {number}: {name}: {what}")


def _separator(line: str, header: str = "") -> str | None:
    """The separator of the cells of a line of numbers; None for blanks."""
    # A tab or semicolon separates whatever else is there. Then numbers between blanks: in "1,5 2,5"
    # the commas are decimal. Only then a comma; and where the line does not tell, the header does.
    if separator := next((x for x in "\t;" if x in line), None):
        return separator
    words = line.split()
    if len(words) > 1 and all(map(_is_number, words)):
        return None
    if "," in line:
        return ","
    return max("\t;,", key=header.count) if set("\t;,") & set(header) else None


def _names(header: str) -> list[str]:
    """The names of a header's columns; between blanks, a unit in brackets belongs to its name."""
    if set("\t;,") & set(header):
        return _cells(header, max("\t;,", key=header.count))
    return re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", header.replace('"', ""))


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line; quotes are those of CSV."""
    if separator is None:
        return line.split()
    return [
        x.strip() for x in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    ]


def _is_number(cell: str) -> bool:
    """Whether a cell is a real or complex number, with a decimal point or comma."""
    plain = _without_i(cell.strip().replace(",", "."), ",")
    try:
        complex(plain)
    except ValueError:
        return False
    # Python reads 1_000 as a number, and j as one: no file means that.
    return "_" not in plain and plain.lower() not in ("j", "+j", "-j")


def _has_comma(cell: str) -> bool:
    """Whether a cell is a number with a decimal comma."""
    return re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) is not None


# Files of MATLAB, and archives of NumPy.

_ARRAYS = (".mat", ".npz")


def _read_variables(path: Path, layout: Layout, check: Check) -> Given:
    """Read the variables of a file of MATLAB or NumPy, or the fields of its one struct, by their
    names."""
    refuse(path, text=False)
    variables = _variables(path)
    structs = [x for x in variables.values() if x.dtype.names and x.size == 1]
    if len(structs) == 1 and not {known_role(x) for x in variables} & {"frequency", "time"}:
        fields = structs[0].reshape(-1)[0]
        variables = {x: np.asarray(fields[x]) for x in fields.dtype.names}
    unit = ""
    # An frd of MATLAB; its other fields say nothing of the response.
    if {"ResponseData", "Frequency"} <= set(variables):
        unit = _unit_of_frd(variables)
        variables = {x: variables[x] for x in ("Frequency", "ResponseData")}
    columns = tuple(
        x._replace(unit=unit) if unit and x.name == "Frequency" else x
        for x in map(column_of, variables)
    )
    roles = check(columns, layout)
    scales = scales_of(columns, roles, layout)
    names = {role: columns[i].text for role, i in roles.items()}
    rows = {
        role: _numbers(x, role, variables[x]) * scales[role].factor for role, x in names.items()
    }
    if len({len(x) for x in rows.values()}) > 1:
        counts = ", ".join(f"{x} has {len(rows[role])}" for role, x in names.items())
        raise SceneError(f"give as many numbers in each variable: {counts}")
    return Given(path, columns, roles, scales, rows, lambda i: f"line {i + 1}")


def _unit_of_frd(variables: Mapping[str, Any]) -> str:
    """The unit of the frequencies in an frd of MATLAB, which may refer to the unit of time;
    SceneError where that is not seconds."""
    unit, time = (_word(variables.get(x)) for x in ("FrequencyUnit", "TimeUnit"))
    if time not in ("", "seconds") and (not unit or "TimeUnit" in unit):
        raise SceneError(
            f"TimeUnit: the frequencies are per {time}: set FrequencyUnit to rad/s or Hz"
        )
    return {"": "rad/s", "rad/TimeUnit": "rad/s", "cycles/TimeUnit": "Hz"}.get(unit, unit)


def _word(given: Any) -> str:
    """A text that MATLAB keeps in an array; empty where there is none."""
    return "" if given is None or not np.size(given) else str(np.ravel(given)[0])


def _variables(path: Path) -> dict[str, Any]:
    """The variables of a file of MATLAB up to version 7, or of an archive of NumPy, by name."""
    if path.suffix.lower() == ".npz":
        return _arrays_of_numpy(path)
    from scipy.io import loadmat

    try:
        variables = loadmat(path)
    except NotImplementedError:
        raise SceneError("version 7.3, which SciPy does not read: save it with -v7") from None
    except Exception as error:  # noqa: BLE001  whatever SciPy raises for what is none
        raise SceneError(f"not a readable MATLAB file: {str(error).lower()}") from None
    return {key: np.asarray(x) for key, x in variables.items() if not key.startswith("__")}


def _arrays_of_numpy(path: Path) -> dict[str, Any]:
    """The arrays of an archive of NumPy; never objects, as unpickling runs code from the file."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            return dict(archive)
    except Exception as error:  # noqa: BLE001  whatever NumPy and zipfile raise for what is none
        raise SceneError(f"not a readable archive of NumPy: {str(error).lower()}") from None


def _numbers(key: str, role: str, given: Any) -> Any:
    """A variable as a row of numbers: one dimension longer than 1 at most, real unless it is H."""
    row = np.asarray(given)
    if row.dtype.kind not in "biufc" or row.size != max(row.shape, default=0):
        raise SceneError(f"{key}: must be one row or column of numbers")
    if row.dtype.kind == "c" and role != "H":
        raise SceneError(f"{key}: must be real")
    return row.ravel().astype(complex if role == "H" else float)


# Responses.


def _response_roles(columns: Sequence[ColumnHeader], layout: Layout) -> dict[str, int]:
    """The columns of a response: a frequency, and H, real and imag, or magnitude and phase."""
    roles = assigned(columns, RESPONSE, layout)
    listed = ", ".join(x.text for x in columns)
    if "frequency" not in roles:
        if any(known_role(x.text) == "time" for x in columns):
            raise SceneError(
                'column "t": for records in time add an estimator, as estimator = "H1" and '
                'segment = "4 s" in [perceived], or '
                '--estimator H1 --segment "4 s"; valid are H1, H2, joint'
            )
        ways = "give one, omega (rad/s) or frequency_hz, or name it, as columns = { frequency = 1 }"
        raise SceneError(f"no column of frequencies: {ways}: there are {listed}")
    # "FRF" beside a phase is a magnitude.
    if "H" in roles and "phase" in roles and "magnitude" not in roles:
        roles["magnitude"] = roles.pop("H")
    forms = [x for x in ({"H"}, {"real", "imag"}, {"magnitude", "phase"}) if x & set(roles)]
    if len(forms) != 1 or not forms[0] <= set(roles):
        lacking = ", ".join(sorted(forms[0] - set(roles))) if len(forms) == 1 else "the response"
        what = "the response is there twice" if len(forms) > 1 else f"no column of {lacking}"
        ways = "give the response in columns real, imag or magnitude, phase_deg, or complex as H"
        raise SceneError(f"{what}: {ways}: there are {listed}")
    return roles


def _measurement(
    given: Given, layout: Layout, averages: float | None, confidence: float
) -> Measurement:
    """The measured response of a file: checked, in rising order, as force per position."""
    rows = given.rows
    omega, H, coherence, radius = (
        rows["frequency"],
        _response(given),
        rows.get("coherence"),
        rows.get("radius"),
    )
    check_certainty(coherence is not None, radius is not None, averages, confidence)
    # A sweep from high to low is a response as well: it is turned round, and errors still name the
    # lines of the file.
    place, notes = given.place, []
    last = len(omega) - 1
    if last and (np.diff(omega) < 0).all():
        omega, H, coherence, radius = (
            None if x is None else x[::-1] for x in (omega, H, coherence, radius)
        )
        place = lambda i: given.place(last - i)  # noqa: E731
        notes.append("sorted")
    check_lines(omega, H, coherence, radius, place)
    response = Measurement(
        omega, H, coherence, averages, confidence, radius, given.motion, given.path.name, given.path
    )
    if layout.sign < 0:
        response = replace(response, H=-response.H)
        notes.append("sign turned round")
    if (layout.quantity or "stiffness") != "stiffness":
        response, left = _converted(response, str(layout.quantity), place)
        notes += [str(layout.quantity).replace("-", " "), left]
    return replace(response, understood=given.understood(*notes))


def _response(given: Given) -> Any:
    """The complex response of a file, in its own quantity and SI."""
    rows = given.rows
    if "H" in rows:
        return rows["H"]
    if "real" in rows:
        return rows["real"] + 1j * rows["imag"]
    size, scale = rows["magnitude"], given.scales["magnitude"]
    # The factor of the unit in dB re 1 N/mm, say, was put on the dB themselves: it is taken off,
    # and put on the number that they mean.
    if scale.decibel:
        size = scale.factor * 10 ** (size / scale.factor / 20)
    elif (size < 0).any():
        first = int(np.argmax(size < 0))
        way = 'if it is in dB, add unit = { magnitude = "dB" }'
        raise SceneError(
            f"{given.place(first)}: magnitude: {size[first]:.6g} must be 0 or above; {way}"
        )
    return size * np.exp(1j * rows["phase"])


def _converted(m: Measurement, kind: str, place: Callable[[int], str]) -> tuple[Measurement, str]:
    """The response as force per position, from another quantity, and a note on what was left out:
    at 0 rad/s a derivative of motion is 0 whatever the motion."""
    order, power = QUANTITIES[kind]
    kept = m.omega > 0 if order else np.isfinite(m.omega)
    if not kept.any():
        raise SceneError(f"{kind}: there is no line above 0 rad/s")
    if power < 0 and not m.H[kept].all():
        first = int(np.argmax(kept & (m.H == 0)))
        raise SceneError(f"{place(first)}: {kind}: is 0, and force per position would be infinite")
    lines = m.at(kept)
    factor = (1j * lines.omega) ** order
    note = "" if kept.all() else "line at 0 left out"
    if power > 0:
        radius = None if lines.radius is None else lines.radius * np.abs(factor)
        return replace(lines, H=lines.H * factor, radius=radius), note
    H, radius = factor / lines.H, None
    # The disc of relative radius rho about Y becomes one within rho/(1 - rho) of 1/Y, unbounded
    # where it holds 0. It is given as a radius: coherence does not describe a disc off its centre.
    if lines.discs is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            share = lines.discs / np.abs(lines.H)
            radius = np.where(share < 1, np.abs(H) * share / (1 - share), np.inf)
    return replace(lines, H=H, coherence=None, averages=None, radius=radius), note


# Records in time.

_OFF = 0.75
"""The share of the spacing by which a sample may stand off its even place, or a step differ from
the mean step: times are rounded in files."""


def _record_roles(columns: Sequence[ColumnHeader], layout: Layout) -> dict[str, int]:
    """The columns of records in time: time, position, force, and a reference if there is one."""
    roles = assigned(columns, RECORD, layout)
    listed = ", ".join(x.text for x in columns[:20])
    if missing := [x for x in ("time", "position", "force") if x not in roles]:
        key = "t" if missing[0] == "time" else missing[0]
        way = f"or name it, as columns = {{ {missing[0]} = 1 }}"
        raise SceneError(
            f"no column {key}: records in time have t, position and force; {way}: there are "
            f"{listed}"
        )
    return roles


def read_record(
    path: Path, estimator: str, *, layout: Layout | None = None, **settings: Any
) -> Measurement:
    """The response of the records in a file; ``settings`` : as of ``estimated``. SceneError says
    what is wrong, and where."""
    stated = layout or Layout()
    try:
        given = _read(path, stated, _record_roles, "t,position,force")
        rows = given.rows
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in rows:
            raise SceneError(
                "estimator: joint needs the column reference, the signal that drives the loop"
            )
        rate, note = _rate(given)
        response = estimated(
            rows["position"],
            stated.sign * rows["force"],
            rate,
            estimator=estimator,
            reference=rows["reference"] if joint else None,
            name=path.name,
            motion=given.motion,
            **settings,
        )
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    turned = "sign turned round" if stated.sign < 0 else ""
    return replace(response, path=path, understood=given.understood(note, turned))


def _rate(given: Given) -> tuple[float, str]:
    """The samples a second, and a note where times without a unit count ns, us or ms from 1970, as
    logging programs write them. SceneError where samples are not evenly spaced."""
    t = given.rows["time"]
    for key, row in given.rows.items():
        if not np.isfinite(row).all():
            raise SceneError(
                f"{given.place(int(np.argmin(np.isfinite(row))))}: "
                f"{'t' if key == 'time' else key}: must be finite"
            )
    # Each bound is 3.2 years in its unit: no record is so long, and every clock since 1973 is
    # above.
    counts = ((1e17, 1e-9, "ns"), (1e14, 1e-6, "us"), (1e11, 1e-3, "ms"))
    unit_in_s, note = next(
        ((x, f"time in {unit} since 1970") for least, x, unit in counts if t[0] > least), (1.0, "")
    )
    if not note or given.scales["time"].unit != "SI":
        unit_in_s, note = 1.0, ""
    # The difference first: of nearby doubles it is exact, and products would be rounded again.
    t = (t - t[0]) * unit_in_s if note else t
    if len(t) < 2 or t[-1] <= t[0]:
        raise SceneError("t: must rise from sample to sample")
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    is_off = np.abs(t - even) > _OFF * step
    jumps = np.abs(np.diff(t) - step) > _OFF * step
    if jumps.any() or is_off.any():
        first = int(np.argmax(jumps)) + 1 if jumps.any() else int(np.argmax(is_off))
        gap = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{given.place(first)}: t: {gap}: resample the record evenly")
    return float(1 / step), note


# Motions.


def read_motion(path: Path) -> Given:
    """Time and position of a recorded motion: columns with such names, or the only two of a table.
    SceneError otherwise."""
    return _read(path, Layout(columns={"time": 1, "position": 2}), _motion_roles, "t,x")


def _motion_roles(columns: Sequence[ColumnHeader], _: Layout) -> dict[str, int]:
    """The columns of a motion: of two columns the first is time, of more they go by their names."""
    if len(columns) == 2 and known_role(columns[1].text) != "time":
        return {"time": 0, "position": 1}
    roles = assigned(columns, {key: RECORD[key] for key in ("time", "position")}, Layout())
    if len(roles) < 2:
        listed = ", ".join(x.text for x in columns[:20])
        raise SceneError(f"give a time and a displacement, in columns t and x: there are {listed}")
    return roles


RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""The keys, in a scene, of a response that is estimated from records in time."""
LAYOUT = ("columns", "unit", "quantity", "sign")
"""The keys, in a scene, that say what the columns of a file are."""


def _read(path: Path, layout: Layout, check: Check, example: str) -> Given:
    """Read a file of any kind, by its ending."""
    if path.suffix.lower() in _ARRAYS:
        return _read_variables(path, layout, check)
    return _read_text(path, layout, check, example)


_STATED = re.compile(r"# haptisym: (averages|confidence|slope)\s*=\s*(\S.*)")


def _stated(path: Path) -> dict[str, str]:
    """The certainty that comments at the head of a file state, as ``Measurement.to_csv`` writes
    them: values by the keys averages, confidence and slope."""
    with path.open(encoding="utf-8-sig") as file:
        matches = takewhile(bool, map(_STATED.match, file))
        return {x[1]: x[2].strip() for x in matches if x}


def read_file(
    path: Path, averages: float | None, confidence: float | None, settings: Mapping[str, Any]
) -> Measurement:
    """The response in a file; of records in time where an estimator is named. ``settings`` : by
    ``RECORDS`` and ``LAYOUT``.

    What the file states of its lines holds where it is not given.
    """
    for key in settings:
        if key not in (*RECORDS, *LAYOUT):
            valid = (*RECORDS, *LAYOUT)
            raise SceneError(
                f'unknown key "{key}": {meant(key, valid)}valid are {", ".join(valid)}'
            )
    layout = Layout(**{key: x for key, x in settings.items() if key in LAYOUT and x is not None})
    records = {key: x for key, x in settings.items() if key in RECORDS}
    if not records:
        refuse_universal(path)
        try:
            given = _read(path, layout, _response_roles, "omega,real,imag,coherence")
            comments = {} if path.suffix.lower() in _ARRAYS else _stated(path)
            slope = comments.pop("slope", None)
            stated = {
                key: float(quantity(text, Dimension.RATIO).value) for key, text in comments.items()
            }
            averages = stated.get("averages") if averages is None else averages
            level = stated.get("confidence", CONFIDENCE) if confidence is None else confidence
            return replace(_measurement(given, layout, averages, level), slope=slope)
        except SceneError as error:
            raise error.within(path.name or str(path)) from None
    if not isinstance(records.get("estimator"), str):
        raise SceneError('estimator is missing: add estimator = "H1", "H2" or "joint"')
    if averages is not None:
        raise SceneError("averages: leave it out, as it follows from the segments")
    if layout.quantity not in (None, "stiffness"):
        raise SceneError("quantity: leave it out: of records force per position is estimated")
    return read_record(
        path, confidence=CONFIDENCE if confidence is None else confidence, layout=layout, **records
    )


def refuse_universal(path: Path) -> None:
    """SceneError for the name of a universal file (dataset 58)."""
    if path.suffix.lower() in (".uff", ".unv"):
        raise SceneError(
            f"{path.name}: universal files are not read: use CSV with the columns "
            f"frequency_hz, real, imag "
            "and coherence (pyuff reads the datasets of a universal file)"
        )
