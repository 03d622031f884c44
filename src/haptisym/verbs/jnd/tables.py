"""Answers of a person at several levels of a stimulus, and the files that hold them.

A file is a table of counts or of single answers (``model.tablefile``), whose columns are known by
the names that programs of psychophysics give them, or a result of psignifit 4 (JSON). Never a
pickle.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from haptisym.kernel.errors import SceneError, meant, need, quoted, within
from haptisym.kernel.objects import counted
from haptisym.model.columns import ColumnHeader
from haptisym.model.tablefile import (
    ARRAYS,
    ArrayTable,
    Text,
    TextTable,
    open_table,
    reading,
    text_table,
)


@dataclass(frozen=True, slots=True)
class LevelAnswers:
    """The answers at one level: ``count`` of ``trials`` were "more" (or right)."""

    level: float
    count: int
    trials: int

    @property
    def share(self) -> float:
        """The share of answers that count."""
        return self.count / self.trials


@dataclass(frozen=True)
class Answers:
    """The answers of a person, level by level in ascending order; valid by construction.

    ``name`` : where it comes from. ``alternatives`` : of a forced choice, where that is known.
    ``notes`` : what was left out or put together on the way. ``earlier`` : what another program
    found, as it says.
    """

    name: str
    rows: tuple[LevelAnswers, ...]
    alternatives: int | None = None
    notes: tuple[str, ...] = ()
    earlier: str = ""

    def __post_init__(self) -> None:
        if len(self.rows) < 2:
            what = (
                "there are no answers"
                if not self.rows
                else f"all answers are at one level, {self.rows[0].level:g}"
            )
            raise SceneError(f"{what}; a curve needs at least two levels")
        # Where all answers are of one kind the likelihood has no largest value: the curve runs
        # away.
        count, trials = sum(x.count for x in self.rows), sum(x.trials for x in self.rows)
        if count in (0, trials):
            which = "no answer counts" if count == 0 else "every answer counts"
            raise SceneError(
                f"{which} (k = {count} of n = {trials} in all): no curve can be fitted"
            )


def collected(rows: Iterable[tuple[float, int, int]]) -> tuple[LevelAnswers, ...]:
    """Level, count and trials of blocks, put together by level; SceneError where a block is
    impossible.

    >>> collected([(2.0, 1, 4), (1.0, 0, 4), (2.0, 3, 4)])
    (LevelAnswers(level=1.0, count=0, trials=4), LevelAnswers(level=2.0, count=4, trials=8))
    """
    counts: dict[float, list[int]] = defaultdict(lambda: [0, 0])
    for level, count, trials in rows:
        if not isfinite(level):
            raise SceneError(f"level {level} is not a finite number")
        if count < 0 or count > trials:
            raise SceneError(f"level {level:g}: {count} of {trials} responses are impossible")
        counts[level][0] += count
        counts[level][1] += trials
    return tuple(
        LevelAnswers(level, *counts[level]) for level in sorted(counts) if counts[level][1]
    )


MOST_LEVELS = 1000
"""Levels with which a curve is fitted, at the most; more are put together."""


def condensed(answers: Answers) -> Answers:
    """Return the answers with neighbouring levels put together at their means where there are
    very many."""
    rows = answers.rows
    if len(rows) <= MOST_LEVELS:
        return answers
    # About as many trials in each group, so that each mean level is known equally well.
    together = grouped(rows, -(-sum(x.trials for x in rows) // MOST_LEVELS))
    note = f"{len(rows)} levels put into {len(together)} groups of neighbours, each at its mean"
    return replace(answers, rows=together, notes=(*answers.notes, note))


def grouped(rows: Iterable[LevelAnswers], least: int) -> tuple[LevelAnswers, ...]:
    """Put neighbouring levels together until each group has that many trials, at the mean of their
    levels."""
    groups: list[LevelAnswers] = []
    for row in rows:
        if groups and groups[-1].trials < least:
            groups[-1] = _joined(groups[-1], row)
        else:
            groups.append(row)
    # What is left at the end joins the last full group.
    if len(groups) > 1 and groups[-1].trials < least:
        last = groups.pop()
        groups[-1] = _joined(groups[-1], last)
    return tuple(groups)


def _joined(one: LevelAnswers, other: LevelAnswers) -> LevelAnswers:
    trials = one.trials + other.trials
    level = (one.level * one.trials + other.level * other.trials) / trials
    return LevelAnswers(level, one.count + other.count, trials)


ALIASES = {
    "level": (
        "level levels x intensity intensities stimlevel stimlevels stimulus stimuli stim "
        "stimulusintensity stimulusintensities allintensities historystim comparison"
    ),
    "count": (
        "k numpos npos positives ncorrect numcorrect nright hits nyes yes count correct right"
    ),
    "trials": ("n outofnum ntrials trials total ntotal numtrials"),
    "answer": (
        "response responses allresponses historyresp corr resp answer correct iscorrect "
        "outcome y yes"
    ),
}
"""Names of each column, in small letters with nothing in between; a name with a point is known by
its end (key_resp.corr).

k, n: quickpsy. StimLevels, NumPos, OutOfNum, PM.x, PM.response: Palamedes. trialData.stim,
trialData.outcome, history_stim, history_resp: QUEST+. trials.intensity, trials.response,
key_resp.corr: PsychoPy.
"""
TOLD = ("participant", "subject", "subj", "observer", "session", "condition", "hand")
"""Columns whose values are different people or conditions: told where they are put together."""


@dataclass(frozen=True)
class AnswerColumns:
    """The columns of a table by position: ``count`` and ``trials``, or else ``answer``, one to a
    line.

    ``second`` : the level of the second interval, where ``level`` is that of the first and answers
    are intervals.
    """

    level: int
    count: int | None
    trials: int | None
    answer: int | None
    second: int | None = None

    @property
    def used(self) -> tuple[int, ...]:
        """The positions, level first."""
        return tuple(
            x
            for x in (self.level, self.second, self.count, self.trials, self.answer)
            if x is not None
        )


def find_columns(header: Sequence[str], named: Mapping[str, str]) -> AnswerColumns:
    """The columns that hold level and answers; ``named`` : those that the caller names. SceneError
    where there are none.

    >>> find_columns(["trial", "k1", "k2", "answer"], {})
    AnswerColumns(level=1, count=None, trials=None, answer=3, second=2)
    """
    # Two intervals have two columns of levels, of which none is called a level.
    if "level" not in named and (pair := _two_intervals(header)) is not None:
        answer = _named(header, "answer", named) if "answer" in named else _known(header, "answer")
        if answer is not None:
            return AnswerColumns(pair[0], None, None, answer, pair[1])
    columns = {
        key: _named(header, key, named) if key in named else _known(header, key) for key in ALIASES
    }
    level, count, trials, answer = (columns[key] for key in ("level", "count", "trials", "answer"))
    if count is None and answer is None:
        count = next(
            (i for i, name in enumerate(header) if _is_per_cent(name) and i != level), None
        )
    if level is None:
        raise SceneError(_missing(header, "the levels", "level"))
    # A name such as "correct" may be of counts or of single answers: with a column of trials next
    # to it, it is of counts.
    if count is not None and trials is not None and "answer" not in named:
        return AnswerColumns(level, count, trials, None)
    if answer is not None and answer != level:
        return AnswerColumns(level, None, None, answer)
    lacking = "how many answers counted (k) of how many (n), nor one answer a line"
    raise SceneError(_missing(header, lacking, "count and --trials, or --answer,"))


def _two_intervals(header: Sequence[str]) -> tuple[int, int] | None:
    """Where the levels of two intervals are: the only two columns that differ in a last 1 and 2,
    and no other has levels."""
    pairs = []
    for i, x in enumerate(header):
        second = f"{x[:-1]}2"
        if x.endswith("1") and second in header:
            pairs.append((i, header.index(second)))
    if len(pairs) != 1:
        return None
    others = [x for i, x in enumerate(header) if i not in pairs[0]]
    return pairs[0] if _known(others, "level") is None else None


def _is_per_cent(name: str) -> bool:
    return "%" in name or _plain(name).startswith(("percent", "pct"))


def position(header: Sequence[str], name: str) -> int:
    """Where a column of exactly that name is; SceneError where none is."""
    if name in header:
        return header.index(name)
    raise SceneError(f"no column {quoted(name)}: {meant(name, header)}there are {_listed(header)}")


def _named(header: Sequence[str], key: str, named: Mapping[str, str]) -> int:
    try:
        return position(header, named[key])
    except SceneError as error:
        raise error.within(key) from None


def _known(header: Sequence[str], key: str) -> int | None:
    """Return where a column is whose name is known, the first alias first; SceneError where two
    have one alias."""
    plain = [_plain(x) for x in header]
    for alias in ALIASES[key].split():
        places = [i for i, x in enumerate(plain) if x == alias]
        if len(places) > 1:
            both = " or ".join(quoted(header[i]) for i in places)
            raise SceneError(f"{key}: columns {both} both fit: choose one with --{key}")
        if places:
            return places[0]
    return None


def _plain(name: str) -> str:
    """Return a name as ``ALIASES`` has it."""
    return re.sub(r"[^a-z]", "", name.lower().rpartition(".")[2])


def _missing(header: Sequence[str], what: str, option: str) -> str:
    return f"no column holds {what}: there are {_listed(header)}; name it with --{option} COLUMN"


def _listed(header: Sequence[str]) -> str:
    shown = ", ".join(x[:40] for x in header[:12] if x)
    return f"{shown}, ..." if len(header) > 12 else shown or "none"


_MOST_CHARACTERS = 10_000_000
"""Characters of a JSON document, at the most."""
_MOST_TRIALS = 10**12


@dataclass(frozen=True)
class Coding:
    """The meaning of answers: the word for "more", if one was named, and the level of the standard,
    which two intervals need.

    ``is_forced`` : of a forced choice, where answers are right or wrong, and 1 or 2 would be a
    choice instead.
    """

    more: str | None = None
    reference: float | None = None
    is_forced: bool = False


def read_answers(
    path: str | Path, named: Mapping[str, str], where: Mapping[str, str], coding: Coding = Coding()
) -> Answers:
    """The answers in a file. ``named`` : columns by what they hold; ``where`` : only lines with
    these values. SceneError says what is wrong."""
    need("data", path, (str, Path), "give a file of responses, or Answers")
    path = Path(path)
    find = partial(_found, named)
    with reading(path):
        if path.suffix.lower() in ARRAYS:
            return _from_table(path.name, *open_table(path, find, ""), where, coding)
        text = Text.of(path, pipes=True)
        begun = next((line for line in text.lines() if line.strip()), "")
        if not begun.lstrip().startswith(("{", "[")):
            table = text_table(text, find, "level,k,n", least=1)
            return _from_table(path.name, *table, where, coding)
        if named or where or coding.more is not None:
            raise SceneError("JSON has no columns: leave their names out")
        document = text.content
        if len(document) >= _MOST_CHARACTERS:
            raise SceneError(f"a document of JSON may have {_MOST_CHARACTERS} characters at most")
        return _from_psignifit(path.name, document)


def _found(named: Mapping[str, str], columns: Sequence[ColumnHeader]) -> AnswerColumns:
    """The columns of answers, by their headers without units; those that the caller names may have
    them."""
    # "level" and "level (dB)" have one name without units: the one that is named has them.
    given = {x.name for x in columns if x.text in named.values()}
    bare = [x.text if x.unit == "%" or x.name in given else x.name for x in columns]
    short = {x.text: name for x, name in zip(columns, bare, strict=True)}
    return find_columns(bare, {key: short.get(x, x) for key, x in named.items()})


def _from_table(
    name: str,
    table: TextTable | ArrayTable,
    columns: AnswerColumns,
    where: Mapping[str, str],
    coding: Coding,
) -> Answers:
    """Return the answers in a table."""
    header = [x.text for x in table.columns]
    wanted = {position(header, x): y for x, y in where.items()}
    others = {i: set[str]() for i, x in enumerate(header) if x.lower() in TOLD and i not in wanted}
    kept: list[tuple[int, list[str]]] = []
    half, count = 0, 0
    # A line without level and answer is skipped; one with half of them is counted as left out.
    for number, row in table.cells(columns.used, []):
        cells = [x.strip() for x in row] + [""] * (len(header) - len(row))
        if not any(cells) or any(cells[i] != value for i, value in wanted.items()):
            continue
        count += 1
        used = ["" if cells[i].lower() in _NOTHING else cells[i] for i in columns.used]
        if used[-1]:
            for i in others:
                others[i] |= {cells[i]} - {""}
        if all(used):
            kept.append((number, used))
        else:
            half += any(used)
    rows, which = _rows(header, columns, kept, coding, has_commas=table.has_commas)
    if wanted and not count:
        conditions = [f"{header[i]} = {value[:40]}" for i, value in wanted.items()]
        raise SceneError(f"no line has {' and '.join(conditions)}")
    if half == count > 0:
        raise SceneError("no line has both a level and a response")
    notes = [which] if which else []
    notes += [f"{counted(half, 'line')} without a level or an answer left out"] if half else []
    notes += [
        (
            f"{counted(len(x), 'value')} of {header[i]} put together; choose with --where "
            f"{header[i]}=..."
        )
        for i, x in others.items()
        if len(x) > 1
    ]
    return Answers(name, collected(rows), notes=tuple(notes))


def _rows(
    header: Sequence[str],
    columns: AnswerColumns,
    kept: Sequence[tuple[int, Sequence[str]]],
    coding: Coding,
    *,
    has_commas: bool,
) -> tuple[list[tuple[float, int, int]], str]:
    """Return level, answers that count and of how many for each line; and words for which answers
    counted, where that followed from the answers themselves."""
    read: Callable[[Sequence[str]], tuple[float, int, int]]
    number = partial(_number, has_commas=has_commas)
    which = ""
    if columns.count is not None:
        if coding.more is not None:
            raise SceneError("more: the table has counts, not single answers: leave it out")
        read = partial(_of_counts, number, is_per_cent=_is_per_cent(header[columns.count]))
    elif columns.second is not None:
        if coding.reference is None:
            raise SceneError(
                "two intervals have a level each: add --reference, the level of the standard"
            )
        read = partial(_of_two_intervals, number, coding.reference)
    else:
        more, less = _meaning([cells[-1] for _, cells in kept], coding)
        which = "" if "1" in more and "0" in less else f'"{next(iter(more))}" counted as more'
        read = partial(_of_one, number, more, less)
    rows = []
    for line, cells in kept:
        try:
            rows.append(read(cells))
        except SceneError as error:
            raise error.within(f"line {line}") from None
    return rows, which


def _of_one(
    number: Callable[[str, str], float],
    more: Collection[str],
    less: Collection[str],
    cells: Sequence[str],
) -> tuple[float, int, int]:
    """Read a level and one answer."""
    answer = cells[1].lower()
    if answer not in (*more, *less):
        words = (
            "must be 1 or 0 (or true or false, yes or no; of two other words name the one for "
            "more, as --more"
        )
        raise SceneError(f"answer: {quoted(cells[1])} {words} {cells[1][:20]})")
    return number("level", cells[0]), int(answer in more), 1


def _of_two_intervals(
    number: Callable[[str, str], float], reference: float, cells: Sequence[str]
) -> tuple[float, int, int]:
    """Read the levels of two intervals, one of which is the standard, and which was answered; no
    trial where both are the standard."""
    levels = [number("level", x) for x in cells[:2]]
    if cells[2] not in ("1", "2"):
        raise SceneError(
            f"answer: {quoted(cells[2])} must be 1 or 2, the interval that was more; or add --level"
        )
    if reference not in levels:
        raise SceneError(
            f"neither {cells[0]} nor {cells[1]} is the level of the standard, {reference:g}"
        )
    # The answer counts where the interval that is no standard was called the one that is more.
    other = 1 if levels[0] == reference else 0
    return levels[other], int(cells[2] == str(other + 1)), int(levels[0] != levels[1])


def _of_counts(
    number: Callable[[str, str], float], cells: Sequence[str], *, is_per_cent: bool = False
) -> tuple[float, int, int]:
    """Read a level, k and n, where k may be given as a percentage of n."""
    keys = "level", "k", "n"
    level, k, n = (number(key, x) for key, x in zip(keys, cells, strict=True))
    # A percentage that was rounded to a whole number is off by half at the most.
    if is_per_cent:
        share, k = k, round(k * n / 100)
        if abs(100 * k - share * n) > n / 2:
            raise SceneError(f"{quoted(cells[1])} % of {n:g} is no whole number of responses")
    for key, x, text in zip("kn", (k, n), cells[1:], strict=True):
        if x < 0 or x != int(x) or x > _MOST_TRIALS:
            raise SceneError(f"{key}: {quoted(text)} is no count of responses: give a whole number")
    if k > n:
        raise SceneError(f"k = {int(k)} is more than n = {int(n)}")
    return level, int(k), int(n)


def _number(key: str, text: str, *, has_commas: bool = False) -> float:
    try:
        value = float(text.replace(",", ".") if has_commas else text)
    except ValueError:
        raise SceneError(f"{key}: {quoted(text)} is not a number") from None
    if not isfinite(value):
        raise SceneError(f"{key}: {quoted(text)} is not a finite number")
    return value


_NOTHING = {"none", "na", "n/a", "null"}  # as programs write what is not there
_MORE = [
    "1",
    "1.0",
    "true",
    "yes",
    "more",
    "higher",
    "greater",
    "larger",
    "stiffer",
    "heavier",
    "comp",
    "comparison",
    "test",
]
_LESS = [
    "0",
    "0.0",
    "false",
    "no",
    "less",
    "lower",
    "smaller",
    "softer",
    "lighter",
    "ref",
    "reference",
    "standard",
    "-1",
    "-1.0",
]


def _meaning(answers: Iterable[str], coding: Coding) -> tuple[Collection[str], Collection[str]]:
    """Which answers, in small letters, count as more and which as less: as named, or as two numbers
    or words say."""
    given, more = dict.fromkeys(x.lower() for x in answers), coding.more
    if more is not None:
        if more.lower() not in given:
            raise SceneError(f"more: no answer is {quoted(more)}: there are {_listed(list(given))}")
        others = [x for x in given if x != more.lower()]
        if len(others) > 1:
            raise SceneError(
                f"more: besides {quoted(more)} there are {_listed(others)}: choose lines "
                f"with --where"
            )
        return [more.lower()], others
    # 1 and 2 alone: the second interval, or the larger number, is more. Of a forced choice they
    # would be the choice, and not whether it was right.
    if "2" in given and set(given) <= {"1", "2"} and not coding.is_forced:
        return ["2"], ["1"]
    return _MORE, _LESS


# psignifit 4.


def _from_psignifit(name: str, text: str) -> Answers:
    try:
        table = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"not valid JSON: {str(error) or 'nested too deeply'}") from None
    data = table.get("data") if isinstance(table, dict) else table
    if not isinstance(data, list) or not all(isinstance(x, list) and len(x) == 3 for x in data):
        raise SceneError(
            "this JSON is no result of psignifit 4: give data, a list of [level, k, n]"
        )
    rows = []
    for row in data:
        with within("data"):
            rows.append(_of_counts(_number, [str(x) for x in row]))
    answers = Answers(name, collected(rows))
    return replace(answers, **_configured(table)) if isinstance(table, dict) else answers


def _configured(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the forced choice that psignifit was told of, and words for the threshold and width
    that it found."""
    configuration = table.get("configuration")
    settings = configuration if isinstance(configuration, dict) else {}
    choices = settings.get("experiment_choices")
    is_forced = (
        settings.get("experiment_type") == "nAFC" and isinstance(choices, int) and choices > 1
    )
    estimates = table.get("parameter_estimate_MAP")
    values = estimates if isinstance(estimates, dict) else {}
    numbers = [values.get(key) for key in ("threshold", "width")]
    known = [x for x in numbers if isinstance(x, int | float) and isfinite(x)]
    is_told = settings.get("sigmoid") == "norm" and len(known) == 2
    earlier = "psignifit found threshold {:.6g} and width {:.6g}".format(*known) if is_told else ""
    return {"alternatives": choices if is_forced else None, "earlier": earlier}
