"""Tables of answers in files: CSV of counts or of single answers, and results of psignifit 4 as JSON. Never a pickle."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import TextIOWrapper
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import Any, TextIO

from haptisym.kernel.errors import SceneError, need, quoted
from haptisym.kernel.shown import counted
from haptisym.verbs.jnd.answers import Answers, collected
from haptisym.verbs.jnd.columns import TOLD, Columns, find_columns, position

_MOST_CHARACTERS = 10_000_000
"""Of a document of JSON."""
_MOST_TRIALS = 10**12
_NOT_TEXT = {
    b"PK": "a workbook: save its sheet as CSV",
    b"\x80": "a pickle, which would run whatever is in it: export the trials as CSV (saveAsWideText in PsychoPy)",
    b"\x89HDF": "an HDF5 or MATLAB file: export level, k and n as CSV",
    b"MATLAB": "a MATLAB file: export level, k and n as CSV, as by writetable",
}


def read_answers(path: str | Path, named: Mapping[str, str], where: Mapping[str, str]) -> Answers:
    """The answers in a file. ``named`` : columns by what they hold; ``where`` : only lines with these values. SceneError says
    what is wrong."""
    need("data", path, (str, Path), "give a file of answers, or Answers")
    path = Path(path)
    try:
        with path.open("rb") as raw:  # opened once, as it may be a pipe
            _refuse(path, raw.peek(8))
            with TextIOWrapper(raw, encoding="utf-8-sig", newline="") as file:
                return _read(path, file, named, where)
    except SceneError as error:
        raise error.within(path.name) from None
    except IsADirectoryError:
        raise SceneError(f"{path} is a folder: name a file in it") from None
    except FileNotFoundError:
        raise SceneError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{path.name}: {_unreadable(error)}") from None


def _unreadable(error: OSError | ValueError) -> str:
    if isinstance(error, UnicodeDecodeError):
        return "not text in UTF-8: save it as CSV in UTF-8"
    return getattr(error, "strerror", "") or str(error)


def _refuse(path: Path, begins: bytes) -> None:
    told = next((words for mark, words in _NOT_TEXT.items() if begins.startswith(mark)), "")
    if path.suffix.lower() in (".psydat", ".pkl", ".pickle"):
        told = _NOT_TEXT[b"\x80"]
    if told:
        raise SceneError(f"this is {told}")


def _read(path: Path, file: TextIO, named: Mapping[str, str], where: Mapping[str, str]) -> Answers:
    first = next((line for line in file if line.strip()), "")
    if not first.lstrip().startswith(("{", "[")):
        return _Table.begun(first, file, named, where).answers(path.name)
    if named or where:
        raise SceneError("this is a document of JSON, which has no columns: leave their names out")
    text = first + file.read(_MOST_CHARACTERS)
    if len(text) >= _MOST_CHARACTERS:
        raise SceneError(f"a document of JSON may have {_MOST_CHARACTERS} characters at most")
    return _from_psignifit(path.name, text)


# One line after the other.


@dataclass
class _Table:
    """Lines with the same cells are read once, however many there are."""

    header: list[str]
    columns: Columns
    has_commas: bool
    where: Mapping[int, str]
    lines: Counter[tuple[str, ...]] = field(default_factory=Counter)
    first: dict[tuple[str, ...], int] = field(default_factory=dict)
    others: dict[str, set[str]] = field(default_factory=dict)

    @classmethod
    def begun(cls, first: str, file: TextIO, named: Mapping[str, str], where: Mapping[str, str]) -> _Table:
        delimiter = max("\t;,", key=first.count)
        try:
            [header, *_], lines = (
                list(csv.reader([first], delimiter=delimiter)) or [[]],
                csv.reader(file, delimiter=delimiter),
            )
            header = [x.strip() for x in header]
            _refuse_numbers(header)
            found = cls(
                header,
                find_columns(header, named),
                delimiter != ",",
                {position(header, x): y for x, y in where.items()},
            )
            found._count(lines)
        except csv.Error as error:
            raise SceneError(f"not a table: {error}") from None
        return found

    def _count(self, lines: Iterator[list[str]]) -> None:
        used, need = self.columns.used, max(chain(self.columns.used, self.where)) + 1
        told = [(name, i) for i, name in enumerate(self.header) if name.lower() in TOLD and i not in self.where]
        sets = [(self.others.setdefault(name, set()), i) for name, i in told]
        wanted = tuple(self.where.items())
        for number, cells in enumerate(lines, 2):
            if len(cells) < need:
                if any(cells):
                    cells += [""] * (need - len(cells))
                else:
                    continue
            if any(cells[i].strip() != value for i, value in wanted):
                continue
            key = tuple(["" if cells[i].strip().lower() in _NOTHING else cells[i] for i in used])
            if key not in self.first:
                self.first[key] = number
            self.lines[key] += 1
            for values, i in sets:
                if i < len(cells) and cells[i] and key[-1]:
                    values.add(cells[i])

    def answers(self, name: str) -> Answers:
        """What was answered."""
        if self.where and not self.lines:
            told = " and ".join(f"{self.header[i]} = {value[:40]}" for i, value in self.where.items())
            raise SceneError(f"no line has {told}")
        blank = sum(times for cells, times in self.lines.items() if not all(x.strip() for x in cells))
        half = blank - sum(times for cells, times in self.lines.items() if not any(x.strip() for x in cells))
        if half == sum(self.lines.values()) > 0:
            raise SceneError("no line has both a level and an answer")
        notes = [f"{counted(half, 'line')} without a level or an answer left out"] if half else []
        notes += [
            f"{counted(len(x), 'value')} of {key} put together; choose with --where {key}=..."
            for key, x in self.others.items()
            if len(x) > 1
        ]
        return Answers(name, collected(self._rows()), notes=tuple(notes))

    def _rows(self) -> Iterator[tuple[float, int, int]]:
        for cells, times in self.lines.items():
            if all(x.strip() for x in cells):
                try:
                    yield self._row(cells, times)
                except SceneError as error:
                    raise error.within(f"line {self.first[cells]}") from None

    def _row(self, cells: Sequence[str], times: int) -> tuple[float, int, int]:
        level = self._number("level", cells[0])
        if self.columns.answer is not None:
            return level, times * _is_yes(cells[1]), times
        count, trials = self._whole("k", cells[1]), self._whole("n", cells[2])
        if count > trials:
            raise SceneError(f"k = {count} is more than n = {trials}")
        return level, times * count, times * trials

    def _number(self, key: str, text: str) -> float:
        try:
            found = float(text.replace(",", ".") if self.has_commas else text)
        except ValueError:
            raise SceneError(f"{key}: {quoted(text)} is not a number") from None
        if not isfinite(found):
            raise SceneError(f"{key}: {quoted(text)} is not a finite number")
        return found

    def _whole(self, key: str, text: str) -> int:
        found = self._number(key, text)
        if found < 0 or found != int(found) or found > _MOST_TRIALS:
            raise SceneError(f"{key}: {quoted(text)} is no count of answers: it must be a whole number")
        return int(found)


def _refuse_numbers(header: Sequence[str]) -> None:
    def is_number(text: str) -> bool:
        try:
            float(text)
        except ValueError:
            return False
        return True

    if any(header) and all(map(is_number, filter(None, header))):
        raise SceneError("the first line holds numbers: it must name the columns, as in level,k,n")


_NOTHING = {"none", "na", "n/a", "null"}  # as programs write what is not there
_YES = {"1": 1, "1.0": 1, "true": 1, "yes": 1, "0": 0, "0.0": 0, "false": 0, "no": 0}


def _is_yes(text: str) -> int:
    found = _YES.get(text.strip().lower())
    if found is None:
        raise SceneError(f"answer: {quoted(text)} must be 1 or 0 (or true or false, yes or no)")
    return found


# psignifit 4.


def _from_psignifit(name: str, text: str) -> Answers:
    try:
        table = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"not valid JSON: {str(error) or 'nested too deeply'}") from None
    data = table.get("data") if isinstance(table, dict) else table
    if not isinstance(data, list) or not all(isinstance(x, list) and len(x) == 3 for x in data):
        raise SceneError("this JSON is no result of psignifit 4: it needs data, a list of [level, k, n]")
    found = Answers(name, collected(map(_block, data)))
    return replace(found, **_configured(table)) if isinstance(table, dict) else found


def _block(row: Sequence[Any]) -> tuple[float, int, int]:
    if not all(isinstance(x, int | float) and not isinstance(x, bool) and isfinite(x) for x in row):
        raise SceneError(f"data: {quoted(row)} must be three numbers, level, k and n")
    level, count, trials = row
    if count != int(count) or trials != int(trials) or not 0 <= count <= trials:
        raise SceneError(f"data: {quoted(row)}: k and n must be whole numbers, and k at most n")
    return float(level), int(count), int(trials)


def _configured(table: Mapping[str, Any]) -> dict[str, Any]:
    """The forced choice that psignifit was told of, and the threshold and width that it found."""
    told, found = table.get("configuration"), table.get("parameter_estimate_MAP")
    settings = told if isinstance(told, dict) else {}
    choices = settings.get("experiment_choices")
    is_forced = settings.get("experiment_type") == "nAFC" and isinstance(choices, int) and choices > 1
    numbers = [found.get(key) if isinstance(found, dict) else None for key in ("threshold", "width")]
    known = [x for x in numbers if isinstance(x, int | float) and isfinite(x)]
    is_told = settings.get("sigmoid") == "norm" and len(known) == 2
    earlier = "psignifit found threshold {:.6g} and width {:.6g}".format(*known) if is_told else ""
    return {"alternatives": choices if is_forced else None, "earlier": earlier}
