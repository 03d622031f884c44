"""Measured responses and records in files: tables of text and files of MATLAB, and what their columns mean.

Each column of a table, or variable of MATLAB, has a role: with a frequency it is part of a response, with a time part of a
record, from which a response is estimated. A role follows from the name and its unit ("Magnitude (dB)", "position [mm]",
"/joint_states/position[0]"), or a scene states it: ``columns`` (role to header, or number from 1), ``unit`` (of a role), and
``quantity`` (what the response is). What two columns could be, and what has no unit where several are usual, is refused.

With X the motion, F the force, H = F/X::

    impedance F/V          H = j omega Z        receptance X/F      H = 1/R
    apparent mass F/A      H = -omega^2 M       mobility V/F        H = j omega/Y
                                                accelerance A/F     H = -omega^2/A

A disc of radius rho |Y| about Y becomes one about 1/Y within rho/(1 - rho) |1/Y|; for rho >= 1 it is unbounded.

A table has separators (comma, semicolon, tab, blanks), comments (``#``, ``%``, ``*``), maybe a row of units below its header,
and numbers, each read by NumPy to the nearest float; every error names file and line. Where the separator is no comma, a comma
stands before decimals. FRD and ZMA files are Hz, magnitude (dB of 1 N/m; as it is) and degrees. SciPy reads files of MATLAB.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice, takewhile
from pathlib import Path
from typing import Any, NamedTuple, TextIO

import numpy as np

from haptisym.kernel.errors import SceneError, meant, quoted
from haptisym.kernel.objects import counted
from haptisym.model.estimating import estimated
from haptisym.model.measured import CONFIDENCE, Estimator, Measurement, check_certainty, check_lines
from haptisym.model.quantities import Dimension, MotionKind, quantity, read_unit

LARGEST = 500_000_000
"""Bytes of a file."""
_NOT_TEXT = (b"PK", b"\x89", b"MATLAB", b"\x80", b"\xff\xfe", b"\xfe\xff")
_COMMENTS = "#%*"


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


# What a column is, by its name and by what the scene states.


@dataclass(frozen=True)
class Layout:
    """What a scene states about a file. SceneError for what is none.

    ``columns`` : role to header or number from 1. ``unit`` : role to unit. ``quantity`` : of the response.
    """

    columns: Mapping[str, str | int] = field(default_factory=dict)
    unit: Mapping[str, str] = field(default_factory=dict)
    quantity: str | None = None

    def __post_init__(self) -> None:
        for key, kinds in (("columns", str | int), ("unit", str)):
            given = getattr(self, key)
            example, kind = ("F", "a header, or a number from 1") if key == "columns" else ("Hz", "a unit")
            if not isinstance(given, Mapping):
                raise SceneError(f'{key}: give a table, as {key} = {{ frequency = "{example}" }}')
            for role, x in given.items():
                if role not in _ROLES:
                    valid = ", ".join(_ROLES)
                    raise SceneError(f"{key}: unknown column {quoted(role)}: {meant(role, _ROLES)}valid are {valid}")
                if not isinstance(x, kinds) or isinstance(x, bool) or (isinstance(x, str) and not x.strip()):
                    raise SceneError(f"{key}: {role}: {quoted(x)} must be {kind}")
        if self.quantity is not None and self.quantity not in list(_QUANTITIES):
            near, valid = meant(str(self.quantity), _QUANTITIES), ", ".join(_QUANTITIES)
            raise SceneError(f"quantity: {quoted(self.quantity)} is unknown: {near}valid are {valid}")


_QUANTITIES = {
    "stiffness": (0, 1), "impedance": (1, 1), "apparent-mass": (2, 1),
    "receptance": (0, -1), "mobility": (1, -1), "accelerance": (2, -1),
}  # fmt: skip
"""The order of the derivative of motion, and the power of force over it."""
_RESPONSE = {
    "frequency": "omega w frequency freq f hz angular_frequency",
    "H": "h frf txy tf response z " + " ".join(_QUANTITIES).replace("-", "_"), "real": "real re",
    "imag": "imag im imaginary", "magnitude": "magnitude mag gain amplitude modulus abs spl |h|",
    "phase": "phase angle arg", "coherence": "coherence coh cxy gamma2", "radius": "radius",
}  # fmt: skip
_RECORD = {
    "time": "t time timestamp",
    "position": "position pos x q displacement",
    "force": "force effort torque f",
    "reference": "reference ref",
}
_PLURAL = {"frequency": "frequencies", "time": "times"}
_ROLES = (*_RESPONSE, *_RECORD)
_TOGETHER = [{"H", "real", "imag", "magnitude", "phase"}, {"coherence", "radius"}]
_SUFFIXES = {
    "hz": "Hz", "khz": "kHz", "deg": "deg", "rad": "rad", "db": "dB", "n": "N",
    "s": "s", "ms": "ms", "us": "us", "ns": "ns", "m": "m", "mm": "mm",
}  # fmt: skip


_HERTZ = {"hz": 2 * np.pi, "khz": 2000 * np.pi}
_RADIANS = {"rad/s": 1.0, "1/s": 1.0, "rad/sec": 1.0}
_DEGREES = dict.fromkeys(("deg", "°", "degree", "degrees"), np.pi / 180)
_RAD = dict.fromkeys(("rad", "radian", "radians"), 1.0)


class Column(NamedTuple):
    """A column as its header has it: ``real [N/m]`` is a name and a unit, and so is ``phase_deg``."""

    text: str
    name: str
    unit: str

    @property
    def bare(self) -> str:
        """Without topic, namespace and index: ``/joint_states/position[0]`` and ``field.position0`` are positions."""
        last = re.split(r"[/.]", re.sub(r"[\[.]?\d+\]?$", "", self.name))[-1]
        return re.sub(r"[\s_-]+", "_", last.lstrip("%#_ ").lower()).strip("_")


def _column(cell: str) -> Column:
    match = re.fullmatch(r"(.*\S)\s*[\[(]((?:[^\[\]()]|\([^()]*\))*)[\])]", cell)
    name, unit = (match[1].strip(), match[2].strip()) if match and not match[2].strip().isdigit() else (cell, "")
    suffix = re.fullmatch(r"(.+)_([A-Za-z]+)", name)
    if suffix and suffix[2].lower() in _SUFFIXES:
        return Column(cell, suffix[1], _agreed(name, _SUFFIXES[suffix[2].lower()], unit))
    return Column(cell, name, unit)


def _agreed(name: str, implied: str, unit: str) -> str:
    """The unit of ``phase_deg`` and such, which another unit may not contradict."""
    own, other = implied.lower(), unit.lower()
    if unit in ("", "-") or own == other or any({own, other} <= set(x) for x in (_HERTZ, _DEGREES)):
        return implied if unit in ("", "-") else unit
    hint = f": call the column {'omega' if other in _RADIANS else name.rpartition('_')[0]}"
    raise SceneError(f"{name}: the unit must be {implied}, not {quoted(unit)}{hint}")


def _assigned(columns: Sequence[Column], names: Mapping[str, str], layout: Layout) -> dict[str, int]:
    """The place of each role. SceneError where a role has two columns, or a name may be a slip of the pen."""
    found = {role: _place(columns, role, x) for role, x in layout.columns.items() if role in names}
    if strange := [x for x in layout.columns if x not in names]:
        raise SceneError(f"columns: {strange[0]}: here it is one of {', '.join(names)}")
    stated = set().union(*(group for group in _TOGETHER if group & set(found)))
    known = {word: role for role, words in names.items() for word in words.split()}
    for i, x in enumerate(columns):
        role = known.get(x.bare)
        if i in found.values() or role in layout.columns or role in stated:
            continue
        if role is None:
            if layout.columns or _known_role(x.text) or not (hint := meant(x.bare, [y for y in known if len(y) > 3])):
                continue
            way = f"columns = {{ {next(iter(names))} = 1 }}"
            raise SceneError(f"unknown column {quoted(x.text)}: {hint}else name the columns, as {way}")
        if role in found:
            both = f"{quoted(columns[found[role]].text)} and {quoted(x.text)}"
            way = f"columns = {{ {role} = {quoted(x.text)} }}"
            raise SceneError(f"two columns of {_PLURAL.get(role, role)}, {both}: leave out one, or write {way}")
        found[role] = i
    return found


def _place(columns: Sequence[Column], role: str, wanted: str | int) -> int:
    if isinstance(wanted, int):
        if not 1 <= wanted <= len(columns):
            raise SceneError(f"columns: {role}: there are {len(columns)} columns, and {wanted} is none of them")
        return wanted - 1
    spelt = [{x.text, x.name} for x in columns]
    for names, name in ((spelt, wanted), ([{y.lower() for y in x} for x in spelt], wanted.lower())):
        places = [i for i, own in enumerate(names) if name in own]
        if len(places) == 1:
            return places[0]
        if places:
            raise SceneError(
                f"columns: {role}: {len(places)} columns have the name {quoted(wanted)}: give a number from 1"
            )
    listed = ", ".join(x.text for x in columns)
    raise SceneError(f"columns: {role}: there is no column {quoted(wanted)}: there are {listed}")


def _unit(role: str, column: Column, layout: Layout) -> str:
    """What the header states, or else the scene."""
    own = "" if column.unit == "-" else column.unit
    stated = layout.unit.get(role, "")
    if own and stated and own.lower() != stated.lower():
        raise SceneError(f"unit: {role}: the file has {quoted(own)}: leave out {quoted(stated)}")
    return own or stated


# Units.


class Scale(NamedTuple):
    """What the numbers of a column are multiplied by, their unit as it was understood, and the motion that it implies."""

    factor: float
    unit: str
    motion: MotionKind | None = None
    decibel: bool = False


def _scales(columns: Sequence[Column], roles: Mapping[str, int], layout: Layout) -> dict[str, Scale]:
    if strange := [x for x in layout.unit if x not in roles]:
        raise SceneError(f"unit: {strange[0]}: the columns in use are {', '.join(roles)}")
    units = {role: _unit(role, columns[i], layout) for role, i in roles.items()}
    size = [x for x in ("H", "real", "imag", "magnitude") if x in roles]
    named, bare = [x for x in size if units[x]], [x for x in size if not units[x]]
    if named and bare:
        unit = units[named[0]]
        raise SceneError(f"{bare[0]} has no unit, and {named[0]} has {unit}: write {bare[0]} [{unit}]")
    if named and not units.get("radius", "is not there"):
        units["radius"] = units[named[0]]
    if units.get("radius", "").lower().startswith("db"):
        raise SceneError("radius: a radius in dB is none of a disc: give its unit, as radius [N/m]")
    found = {role: _scale(role, unit, columns[roles[role]], layout) for role, unit in units.items()}
    if len({x.motion for x in found.values() if x.motion}) > 1:
        raise SceneError("units: translation and rotation cannot be mixed")
    return found


def _scale(role: str, unit: str, column: Column, layout: Layout) -> Scale:
    if role == "frequency":
        return _frequency_scale(unit, column)
    if role == "phase":
        if not unit:
            raise SceneError(f'{column.text}: the phase has no unit: add unit = {{ phase = "deg" }}, or "rad"')
        return Scale(_listed(column.text, unit, _DEGREES | _RAD), "deg" if unit.lower() in _DEGREES else "rad")
    if role == "coherence":
        return Scale(_listed(column.text, unit or "1", {"1": 1.0, "%": 0.01}), "")
    if role in _RECORD:
        return _record_scale(role, unit)
    return _size_scale(role, unit, column, layout)


def _listed(name: str, unit: str, known: Mapping[str, float], hint: str = "") -> float:
    if unit.lower() not in known:
        raise SceneError(f"{name}: the unit must be {' or '.join(list(known)[:2])}, not {quoted(unit)}{hint}")
    return known[unit.lower()]


def _frequency_scale(unit: str, column: Column) -> Scale:
    if column.bare == "omega":
        hint = ": call the column frequency_hz" if unit.lower() in _HERTZ else ""
        return Scale(_listed("omega", unit or "rad/s", _RADIANS, hint), "rad/s")
    if not unit and column.bare in ("w", "angular_frequency"):
        return Scale(1.0, "rad/s (assumed)")
    if not unit and column.name.lower() != "hz":
        if not re.search("[a-z]", column.bare):
            raise SceneError('the frequency has no unit: add unit = { frequency = "Hz" }, or "rad/s"')
        return Scale(2 * np.pi, "Hz (assumed)")
    factor = _listed(column.text, unit or "Hz", _HERTZ | _RADIANS)
    return Scale(factor, "rad/s" if factor == 1 else "Hz" if factor < 10 else "kHz")


def _size_scale(role: str, unit: str, column: Column, layout: Layout) -> Scale:
    """Of a response and of a radius: to N/m and s, or their turned over."""
    order, power = _QUANTITIES[layout.quantity or "stiffness"]
    named = column.bare.replace("_", "-")
    if role != "radius" and layout.quantity is None and named in _QUANTITIES and named != "stiffness":
        raise SceneError(f'{column.text}: add quantity = "{named}", or "stiffness" if it is force per position')
    decibel = re.fullmatch(r"(?i:db)\s*(?:\(|\[|(?i:re)\b)?\s*1?\s*(.*?)[\])]?", unit)
    if decibel and role not in ("H", "magnitude"):
        raise SceneError(f"{column.text}: {quoted(unit)}: only a magnitude is in dB")
    own = decibel[1] if decibel else unit
    if not own:
        return Scale(1.0, "dB" if decibel else "SI", decibel=bool(decibel))
    try:
        if (order, power) == (0, 1):
            read = quantity(f"1 {own}", Dimension.STIFFNESS)
            return Scale(float(read.value), unit, read.motion, bool(decibel))
        value, powers = read_unit(own, own, "")
    except SceneError as error:
        raise SceneError(f"{column.text}: {str(error).rstrip('.')}{_otherwise(own)}") from None
    length = power * powers.get("length", 0)
    if (power * powers.get("mass", 0), power * powers.get("time", 0)) != (1, order - 2) or length not in (0, 2):
        raise SceneError(
            f"{column.text}: {quoted(own)} is no unit of {layout.quantity}{_otherwise(own, layout.quantity)}"
        )
    return Scale(float(value), unit, MotionKind.ROTATION if length else MotionKind.TRANSLATION, bool(decibel))


def _otherwise(unit: str, own: str | None = "stiffness") -> str:
    """A hint where the unit is that of another quantity."""
    try:
        _, powers = read_unit(unit, unit, "")
    except SceneError:
        return ""
    for name, (order, power) in _QUANTITIES.items():
        if name != own and (power * powers.get("mass", 0), power * powers.get("time", 0)) == (1, order - 2):
            return f'; this is {name.replace("-", " ")}: add quantity = "{name}"'
    return ""


_DIMENSIONS = {
    "time": Dimension.TIME, "position": Dimension.DISPLACEMENT, "force": Dimension.FORCE, "reference": Dimension.ANY,
}  # fmt: skip


def _record_scale(role: str, unit: str) -> Scale:
    if not unit or role == "reference":
        return Scale(1.0, unit or "SI")
    try:
        read = quantity(f"1 {unit}", _DIMENSIONS[role])
    except SceneError as error:
        raise SceneError(f"{'t' if role == 'time' else role}: {error}") from None
    return Scale(float(read.value), unit, read.motion)


# Tables of text.


class Head(NamedTuple):
    """What stands before the numbers: the columns, their separator (blanks: None), the first line of numbers, and which it is."""

    columns: tuple[Column, ...]
    separator: str | None
    first: str
    line: int


@dataclass(frozen=True, eq=False)
class Given:
    """What a file has: its columns, the numbers of those in use in SI, and the place of each row in words."""

    path: Path
    head: Sequence[Column]
    roles: Mapping[str, int]
    scales: Mapping[str, Scale]
    rows: Mapping[str, Any]
    place: Callable[[int], str]
    notes: tuple[str, ...] = ()

    def understood(self, *more: str) -> str:
        """``10 lines; Hz, dB, deg; sorted``."""
        shown = dict.fromkeys(x.unit for role, x in self.scales.items() if x.unit and role != "radius")
        left = [x.text for i, x in enumerate(self.head) if x.text and i not in self.roles.values()]
        spare = f"not used: {', '.join(left[:5])}{', ...' * (len(left) > 5)}" if left else ""
        lines = counted(len(next(iter(self.rows.values()))), "line")
        return "; ".join(x for x in (lines, ", ".join(shown), *self.notes, *more, spare) if x)

    @property
    def motion(self) -> MotionKind | None:
        """As the units imply."""
        return next((x.motion for x in self.scales.values() if x.motion), None)


Check = Callable[[Sequence[Column], Layout], dict[str, int]]
"""Which column has which role. SceneError where one is missing."""


def _read_text(path: Path, layout: Layout, check: Check, example: str) -> Given:
    try:
        refuse(path)
        with path.open(encoding="utf-8-sig") as file:
            head = _head(file, path, layout, example)
            roles = check(head.columns, layout)
            head = _with_units(file, head, roles)
            scales = _scales(head.columns, roles, layout)
            rows = _rows(path, file, head, roles, scales)
    except UnicodeDecodeError:
        raise SceneError("not text in UTF-8: save it as CSV in UTF-8") from None
    except SceneError:
        raise
    except (OSError, ValueError) as error:
        raise SceneError(str(getattr(error, "strerror", "") or error).lower()) from None

    def place(row: int) -> str:
        with path.open(encoding="utf-8-sig") as again:
            return f"line {next(islice(_numbered(islice(again, head.line - 1, None), head.line), row, None))[0]}"

    has_commas = head.separator != "," and "," in head.first
    return Given(path, head.columns, roles, scales, rows, place, ("decimal commas",) if has_commas else ())


def _head(file: TextIO, path: Path, layout: Layout, example: str) -> Head:
    """The header: the first line, or a comment before a line of numbers that has as many cells."""
    comments: list[str] = []
    for at, line in enumerate(file, 1):
        if not line.strip():
            continue
        if line.lstrip()[0] in _COMMENTS:
            comments.append(line.strip().lstrip("#*% "))
            continue
        separator = _separator(line)
        cells = _cells(line, separator)
        if not any(map(_is_number, cells)):
            number, first = next(_numbered(file, at + 1), (at, ""))
            if not first:
                break
            return Head(tuple(map(_column, _names(line))), _separator(first, line), first, number)
        if len(cells) > 1 and path.suffix.lower() in (".frd", ".zma"):
            kind = "Magnitude (dB)" if path.suffix.lower() == ".frd" else "Magnitude"
            names = ["Frequency (Hz)", kind, "Phase (deg)"]
        elif comments and len(cells) > 1 and len(names := _names(comments[-1])) == len(cells):
            pass
        elif any(isinstance(x, int) for x in layout.columns.values()):
            names = [str(i + 1) for i in range(len(cells))]
        else:
            raise SceneError(f"line {at} has numbers: name the columns in the first line, as {example}")
        return Head(tuple(map(_column, names)), separator, line, at)
    raise SceneError("there are no lines of numbers")


def _with_units(file: TextIO, head: Head, roles: Mapping[str, int]) -> Head:
    """With the units of a row below the header, which has no number where the first column in use has one."""
    found, first = _cells(head.first, head.separator), min(roles.values())
    if first >= len(found) or not found[first] or _is_number(found[first]) or _has_comma(found[first]):
        return head
    if any(x.unit for x in head.columns if x.text.endswith(("]", ")"))):
        raise SceneError(f"units are in the header and in line {head.line}: leave out one of them")
    if len(found) != len(head.columns):
        raise SceneError(f"line {head.line} has {len(found)} units, the header {len(head.columns)} columns")
    columns = tuple(
        x._replace(unit=_agreed(x.text, x.unit or unit, unit)) for x, unit in zip(head.columns, found, strict=True)
    )
    number, line = next(_numbered(file, head.line + 1), (0, ""))
    if not line:
        raise SceneError("there are no lines of numbers")
    return Head(columns, _separator(line, head.first), line, number)


def _rows(
    path: Path, file: TextIO, head: Head, roles: Mapping[str, int], scales: Mapping[str, Scale]
) -> dict[str, Any]:
    used, width, is_complex = sorted(set(roles.values())), len(head.columns), "H" in roles

    def lines() -> Iterator[str]:
        for number, text in _numbered(chain([head.first], file), head.line):
            # where another separator stands, a comma can only stand before decimals
            plain = text if head.separator == "," else text.replace(",", ".")
            if len(used) < width and '"' not in text and len(plain.split(head.separator)) != width:
                _refuse_line(number, _cells(text, head.separator), head, used)
            yield _without_i(plain, head.separator) if is_complex else plain

    try:
        kept = None if len(used) == width else used
        kind: Any = complex if is_complex else float
        table: Any = np.loadtxt(
            lines(), kind, delimiter=head.separator, ndmin=2, comments=None, quotechar='"', usecols=kept
        )
        is_whole = table.shape[1] == len(used)
    except SceneError:
        raise
    except ValueError:
        is_whole = False
    if not is_whole:
        with path.open(encoding="utf-8-sig") as again:
            for number, own in _numbered(islice(again, head.line - 1, None), head.line):
                _refuse_line(number, _cells(own, head.separator), head, used)
        raise SceneError("not a table of numbers")
    rows = {role: table[:, used.index(i)] for role, i in roles.items()}
    if is_complex and not rows["H"].imag.any() and not re.search(r"\d\s*\*?[ijIJ]", head.first):
        raise SceneError(
            f"{head.columns[roles['H']].text}: has no complex numbers, as 799+30j: add a column of the phase"
        )
    return {role: (row if role == "H" else row.real) * scales[role].factor for role, row in rows.items()}


def _without_i(text: str, separator: str | None) -> str:
    """``(799 + 30i)`` as NumPy reads it."""
    bare = re.sub(r"[()]" if separator in (None, "\t") else r"[() ]", "", text)
    return re.sub(r"(?<=[\d.])\s*\*?[iIjJ](?![A-Za-z])", "j", bare)


def _numbered(lines: Iterable[str], first: int) -> Iterator[tuple[int, str]]:
    """Those of numbers, as text, and which line it is."""
    for number, line in enumerate(lines, first):
        if (text := line.partition("#")[0]).strip() and text.lstrip()[0] not in _COMMENTS:
            yield number, text


def _refuse_line(number: int, cells: Sequence[str], head: Head, used: Sequence[int]) -> None:
    """SceneError if the line holds what is no number, or too many of them."""
    hint = ""
    if len(cells) > len(head.columns) and head.separator == "," and len(cells) == 2 * len(head.columns):
        hint = "; if these are decimal commas, separate columns by semicolons, or write decimals with a point"
    if len(cells) != len(head.columns):
        raise SceneError(f"line {number} has {len(cells)} cells, the header {len(head.columns)} columns{hint}")
    for i in used:
        cell, name = cells[i], head.columns[i].text
        if head.separator == "," and _has_comma(cell):
            right = cell.replace(",", ".")
            raise SceneError(f"line {number}: {name}: {quoted(cell)}: decimals are written with a point, as in {right}")
        if not _is_number(cell):
            what = f"{quoted(cell)} is not a number" if cell else "the cell is empty"
            raise SceneError(f"line {number}: {name}: {what}")


def _separator(line: str, header: str = "") -> str | None:
    """Of the cells of a line of numbers; None where blanks stand between them."""
    if found := next((x for x in "\t;" if x in line), None):
        return found
    words = line.split()
    if len(words) > 1 and all(map(_is_number, words)):
        return None
    if "," in line:
        return ","
    return max("\t;,", key=header.count) if set("\t;,") & set(header) else None


def _names(header: str) -> list[str]:
    if set("\t;,") & set(header):
        return _cells(header, max("\t;,", key=header.count))
    return re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", header.replace('"', ""))


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return [x.strip() for x in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def _is_number(cell: str) -> bool:
    """Real or complex, with a point or a comma."""
    plain = _without_i(cell.strip().replace(",", "."), ",")
    try:
        complex(plain)
    except ValueError:
        return False
    return "_" not in plain and plain.lower() not in ("j", "+j", "-j")


def _has_comma(cell: str) -> bool:
    return re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) is not None


# Files of MATLAB.


def _read_mat(path: Path, layout: Layout, check: Check) -> Given:
    """Variables by their names, or the fields of the one struct. SciPy reads files up to version 7."""
    refuse(path, text=False)
    found = _variables(path)
    structs = [x for x in found.values() if x.dtype.names and x.size == 1]
    if len(structs) == 1 and not {_known_role(x) for x in found} & {"frequency", "time"}:
        own = structs[0].reshape(-1)[0]
        found = {x: np.asarray(own[x]) for x in own.dtype.names}
    columns = tuple(map(_column, found))
    roles = check(columns, layout)
    scales = _scales(columns, roles, layout)
    names = {role: columns[i].text for role, i in roles.items()}
    rows = {role: _numbers(x, role, found[x]) * scales[role].factor for role, x in names.items()}
    if len({len(x) for x in rows.values()}) > 1:
        counts = ", ".join(f"{x} has {len(rows[role])}" for role, x in names.items())
        raise SceneError(f"give as many numbers in each variable: {counts}")
    return Given(path, columns, roles, scales, rows, lambda i: f"line {i + 1}")


def _known_role(name: str) -> str:
    bare = _column(name).bare
    return next((role for role, words in (_RESPONSE | _RECORD).items() if bare in words.split()), "")


def _variables(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        found = loadmat(path)
    except NotImplementedError:
        raise SceneError("version 7.3, which SciPy does not read: save it with -v7") from None
    except Exception as error:  # noqa: BLE001  whatever SciPy raises for what is none
        raise SceneError(f"not a readable MATLAB file: {str(error).lower()}") from None
    return {key: np.asarray(x) for key, x in found.items() if not key.startswith("__")}


def _numbers(key: str, role: str, given: Any) -> Any:
    row = np.asarray(given)
    if row.dtype.kind not in "biufc" or row.size != max(row.shape, default=0):
        raise SceneError(f"{key}: must be one row or column of numbers")
    if row.dtype.kind == "c" and role != "H":
        raise SceneError(f"{key}: must be real")
    return row.ravel().astype(complex if role == "H" else float)


# Responses.


def _response_roles(columns: Sequence[Column], layout: Layout) -> dict[str, int]:
    roles = _assigned(columns, _RESPONSE, layout)
    listed = ", ".join(x.text for x in columns)
    if "frequency" not in roles:
        if any(_known_role(x.text) == "time" for x in columns):
            raise SceneError(
                'column "t": for records in time add an estimator, as estimator = "H1" and segment = "4 s" in [perceived], or '
                '--estimator H1 --segment "4 s"; valid are H1, H2, joint'
            )
        ways = "give one, omega (rad/s) or frequency_hz, or name it, as columns = { frequency = 1 }"
        raise SceneError(f"no column of frequencies: {ways}: there are {listed}")
    if "H" in roles and "phase" in roles and "magnitude" not in roles:
        roles["magnitude"] = roles.pop("H")
    forms = [x for x in ({"H"}, {"real", "imag"}, {"magnitude", "phase"}) if x & set(roles)]
    if len(forms) != 1 or not forms[0] <= set(roles):
        what = "it is there twice" if len(forms) > 1 else "it is missing"
        ways = "give the response in columns real, imag or magnitude, phase_deg, or complex as H"
        raise SceneError(f"{what}: {ways}: there are {listed}")
    return roles


def _measurement(given: Given, layout: Layout, averages: float | None, confidence: float) -> Measurement:
    rows = given.rows
    omega, H, coherence, radius = rows["frequency"], _response(given), rows.get("coherence"), rows.get("radius")
    check_certainty(coherence is not None, radius is not None, averages, confidence)
    place, notes = given.place, []
    last = len(omega) - 1
    if last and (np.diff(omega) < 0).all():
        omega, H, coherence, radius = (None if x is None else x[::-1] for x in (omega, H, coherence, radius))
        place = lambda i: given.place(last - i)  # noqa: E731
        notes.append("sorted")
    check_lines(omega, H, coherence, radius, place)
    own = Measurement(omega, H, coherence, averages, confidence, radius, given.motion, given.path.name, given.path)
    if (layout.quantity or "stiffness") != "stiffness":
        own, left = _converted(own, str(layout.quantity), place)
        notes += [str(layout.quantity).replace("-", " "), left]
    return replace(own, understood=given.understood(*notes))


def _response(given: Given) -> Any:
    rows = given.rows
    if "H" in rows:
        return rows["H"]
    if "real" in rows:
        return rows["real"] + 1j * rows["imag"]
    size, scale = rows["magnitude"], given.scales["magnitude"]
    if scale.decibel:
        size = scale.factor * 10 ** (size / scale.factor / 20)
    elif (size < 0).any():
        first = int(np.argmax(size < 0))
        way = 'if it is in dB, add unit = { magnitude = "dB" }'
        raise SceneError(f"{given.place(first)}: magnitude: {size[first]:.6g} must be 0 or above; {way}")
    return size * np.exp(1j * rows["phase"])


def _converted(m: Measurement, kind: str, place: Callable[[int], str]) -> tuple[Measurement, str]:
    """Force per position of another quantity, and what was left out: at 0 rad/s a derivative of motion shows none."""
    order, power = _QUANTITIES[kind]
    kept = m.omega > 0 if order else np.isfinite(m.omega)
    if not kept.any():
        raise SceneError(f"{kind}: there is no line above 0 rad/s")
    if power < 0 and not m.H[kept].all():
        first = int(np.argmax(kept & (m.H == 0)))
        raise SceneError(f"{place(first)}: {kind}: is 0, and force per position would be infinite")
    own = m.at(kept)
    factor = (1j * own.omega) ** order
    left = "" if kept.all() else "line at 0 left out"
    if power > 0:
        radius = None if own.radius is None else own.radius * np.abs(factor)
        return replace(own, H=own.H * factor, radius=radius), left
    H, radius = factor / own.H, None
    if own.discs is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            share = own.discs / np.abs(own.H)
            radius = np.where(share < 1, np.abs(H) * share / (1 - share), np.inf)
    return replace(own, H=H, coherence=None, averages=None, radius=radius), left


# Records in time.

_OFF = 0.75
"""Of the spacing: how far a sample may stand from its even place, or a step be from the mean step; times are rounded in files."""


def _record_roles(columns: Sequence[Column], layout: Layout) -> dict[str, int]:
    roles = _assigned(columns, _RECORD, layout)
    listed = ", ".join(x.text for x in columns[:20])
    if missing := [x for x in ("time", "position", "force") if x not in roles]:
        key = "t" if missing[0] == "time" else missing[0]
        way = f"or name it, as columns = {{ {missing[0]} = 1 }}"
        raise SceneError(f"no column {key}: records in time have t, position and force; {way}: there are {listed}")
    return roles


def read_record(path: Path, estimator: str, *, layout: Layout | None = None, **settings: Any) -> Measurement:
    """The response of the records in a file; ``settings`` : as of ``estimated``. SceneError says what is wrong, and where."""
    own = layout or Layout()
    try:
        given = _read(path, own, _record_roles, "t,position,force")
        rows = given.rows
        joint = estimator.lower() == Estimator.JOINT.value
        if joint and "reference" not in rows:
            raise SceneError("estimator: joint needs the column reference, the signal that drives the loop")
        rate, note = _rate(given)
        found = estimated(
            rows["position"], rows["force"], rate, estimator=estimator, reference=rows["reference"] if joint else None,
            name=path.name, motion=given.motion, **settings,
        )  # fmt: skip
    except SceneError as error:
        raise error.within(path.name or str(path)) from None
    return replace(found, path=path, understood=given.understood(note))


def _rate(given: Given) -> tuple[float, str]:
    """Samples a second, and which part of a second times are in that count from 1970. SceneError where samples are not even."""
    t = given.rows["time"]
    for key, row in given.rows.items():
        if not np.isfinite(row).all():
            raise SceneError(
                f"{given.place(int(np.argmin(np.isfinite(row))))}: {'t' if key == 'time' else key}: must be finite"
            )
    parts = ((1e17, 1e-9, "ns"), (1e14, 1e-6, "us"), (1e11, 1e-3, "ms"))
    part, note = next(((x, f"time in {unit} since 1970") for least, x, unit in parts if t[0] > least), (1.0, ""))
    if not note or given.scales["time"].unit != "SI":
        part, note = 1.0, ""
    t = (t - t[0]) * part if note else t
    if len(t) < 2 or t[-1] <= t[0]:
        raise SceneError("t: must rise from sample to sample")
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    off = np.abs(t - even) > _OFF * step
    jumps = np.abs(np.diff(t) - step) > _OFF * step
    if jumps.any() or off.any():
        first = int(np.argmax(jumps)) + 1 if jumps.any() else int(np.argmax(off))
        gap = f"{t[first]:.6g} s follows {t[first - 1]:.6g} s, and samples are {step:.4g} s apart"
        raise SceneError(f"{given.place(first)}: t: {gap}: resample the record evenly")
    return float(1 / step), note


RECORDS = ("estimator", "segment", "overlap", "window", "every")
"""Keys of a response that is estimated from records in time."""
LAYOUT = ("columns", "unit", "quantity")
"""Keys of what a file has."""


def _read(path: Path, layout: Layout, check: Check, example: str) -> Given:
    return _read_mat(path, layout, check) if path.suffix.lower() == ".mat" else _read_text(path, layout, check, example)


_STATED = re.compile(r"#\s*(averages|confidence|slope)\s*=\s*(\S.*)")


def _stated(path: Path) -> dict[str, str]:
    """What comments before all else state of the lines, as ``Measurement.to_csv`` writes it."""
    with path.open(encoding="utf-8-sig") as file:
        found = takewhile(bool, map(_STATED.match, file))
        return {x[1]: x[2].strip() for x in found if x}


def read_file(path: Path, averages: float | None, confidence: float | None, settings: Mapping[str, Any]) -> Measurement:
    """The response in a file; of records in time where an estimator is named. ``settings`` : by ``RECORDS`` and ``LAYOUT``.

    What the file states of its lines holds where it is not given.
    """
    for key in settings:
        if key not in (*RECORDS, *LAYOUT):
            valid = (*RECORDS, *LAYOUT)
            raise SceneError(f'unknown key "{key}": {meant(key, valid)}valid are {", ".join(valid)}')
    layout = Layout(**{key: x for key, x in settings.items() if key in LAYOUT and x is not None})
    records = {key: x for key, x in settings.items() if key in RECORDS}
    if not records:
        refuse_universal(path)
        try:
            given = _read(path, layout, _response_roles, "omega,real,imag,coherence")
            own = {} if path.suffix.lower() == ".mat" else _stated(path)
            slope = own.pop("slope", None)
            stated = {key: float(quantity(text, Dimension.RATIO).value) for key, text in own.items()}
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
    return read_record(path, confidence=CONFIDENCE if confidence is None else confidence, layout=layout, **records)


def refuse_universal(path: Path) -> None:
    """SceneError for the name of a universal file (dataset 58)."""
    if path.suffix.lower() in (".uff", ".unv"):
        raise SceneError(
            f"{path.name}: universal files are not read: use CSV with the columns frequency_hz, real, imag "
            "and coherence (pyuff reads the datasets of a universal file)"
        )
