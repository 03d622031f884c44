"""Answers of a person at several levels of a stimulus, as they are counted."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import isfinite

from haptisym.kernel.errors import SceneError


@dataclass(frozen=True, slots=True)
class Row:
    """``count`` of ``trials`` answers at a level were "more" (or right)."""

    level: float
    count: int
    trials: int

    @property
    def share(self) -> float:
        """Counted answers over all of the level."""
        return self.count / self.trials


@dataclass(frozen=True)
class Answers:
    """What was answered, level by level in ascending order; valid by construction.

    ``name`` : where it comes from. ``alternatives`` : of a forced choice, where that is known. ``notes`` : what was left out or
    put together on the way. ``earlier`` : what another program found, as it says.
    """

    name: str
    rows: tuple[Row, ...]
    alternatives: int | None = None
    notes: tuple[str, ...] = ()
    earlier: str = ""

    def __post_init__(self) -> None:
        if len(self.rows) < 2:
            what = "there are no answers" if not self.rows else f"all answers are at one level, {self.rows[0].level:g}"
            raise SceneError(f"{what}; a curve needs at least two levels")
        count, trials = sum(x.count for x in self.rows), sum(x.trials for x in self.rows)
        if count in (0, trials):
            told = "no answer counts" if count == 0 else "every answer counts"
            raise SceneError(f"{told} (k = {count} of n = {trials} in all): nothing can be fitted to that")


def collected(rows: Iterable[tuple[float, int, int]]) -> tuple[Row, ...]:
    """Level, count and trials of blocks, put together by level; SceneError where a block is impossible.

    >>> collected([(2.0, 1, 4), (1.0, 0, 4), (2.0, 3, 4)])
    (Row(level=1.0, count=0, trials=4), Row(level=2.0, count=4, trials=8))
    """
    counts: dict[float, list[int]] = defaultdict(lambda: [0, 0])
    for level, count, trials in rows:
        if not isfinite(level):
            raise SceneError(f"level {level} is not a finite number")
        if count < 0 or count > trials:
            raise SceneError(f"level {level:g}: {count} of {trials} answers cannot be")
        counts[level][0] += count
        counts[level][1] += trials
    return tuple(Row(level, *counts[level]) for level in sorted(counts) if counts[level][1])


MOST_LEVELS = 1000
"""With which a curve is fitted; more are put together."""


def condensed(answers: Answers) -> Answers:
    """The same with neighbouring levels put together at their means where there are very many."""
    rows = answers.rows
    if len(rows) <= MOST_LEVELS:
        return answers
    each = -(-sum(x.trials for x in rows) // MOST_LEVELS)
    groups: list[list[Row]] = [[]]
    filled = 0
    for row in rows:
        if filled >= each:
            groups.append([])
            filled = 0
        groups[-1].append(row)
        filled += row.trials
    together = tuple(
        Row(sum(x.level * x.trials for x in group) / _trials(group), sum(x.count for x in group), _trials(group))
        for group in groups
    )
    note = f"{len(rows)} levels put into {len(together)} groups of neighbours, each at its mean"
    return replace(answers, rows=together, notes=(*answers.notes, note))


def _trials(rows: Iterable[Row]) -> int:
    return sum(x.trials for x in rows)
