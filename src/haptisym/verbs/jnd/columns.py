"""Which columns of a table hold levels and answers: the names that programs of psychophysics give them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from haptisym.kernel.errors import SceneError, meant, quoted

ALIASES = {
    "level": (
        "level", "levels", "x", "intensity", "intensities", "stimlevel", "stimlevels", "stimulus", "stimuli", "stim",
        "stimulusintensity", "stimulusintensities", "allintensities", "comparison",
    ),
    "count": (
        "k", "numpos", "npos", "positives", "ncorrect", "numcorrect", "nright", "hits", "nyes", "yes", "count", "correct",
        "right",
    ),
    "trials": ("n", "outofnum", "ntrials", "trials", "total", "ntotal", "numtrials"),
    "answer": (
        "response", "responses", "allresponses", "corr", "resp", "answer", "correct", "iscorrect", "outcome", "y", "yes",
    ),
}  # fmt: skip
"""By what each is called, in small letters without anything between; a name with a point is known by its end (key_resp.corr).

k, n: quickpsy. StimLevels, NumPos, OutOfNum: Palamedes. trials.intensity, trials.response, key_resp.corr: PsychoPy.
"""
TOLD = ("participant", "subject", "subj", "observer", "session", "condition", "hand")
"""Columns whose values are different people or conditions: told where they are put together."""


@dataclass(frozen=True)
class Columns:
    """Where a table has what, by position: ``count`` and ``trials``, or else ``answer``, one to a line."""

    level: int
    count: int | None
    trials: int | None
    answer: int | None

    @property
    def used(self) -> tuple[int, ...]:
        """The positions, level first."""
        return tuple(x for x in (self.level, self.count, self.trials, self.answer) if x is not None)


def find_columns(header: Sequence[str], named: Mapping[str, str]) -> Columns:
    """The columns that hold level and answers; ``named`` : those that the caller names. SceneError where there are none."""
    found = {key: _named(header, key, named) if key in named else _known(header, key) for key in ALIASES}
    level, count, trials, answer = (found[key] for key in ("level", "count", "trials", "answer"))
    if level is None:
        raise SceneError(_missing(header, "the levels", "level"))
    if count is not None and trials is not None and "answer" not in named:
        return Columns(level, count, trials, None)
    if answer is not None and answer != level:
        return Columns(level, None, None, answer)
    lacking = "how many answers counted (k) of how many (n), nor one answer a line"
    raise SceneError(_missing(header, lacking, "count and --trials, or --answer,"))


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
    plain = [_plain(x) for x in header]
    for alias in ALIASES[key]:
        places = [i for i, x in enumerate(plain) if x == alias]
        if len(places) > 1:
            both = " or ".join(quoted(header[i]) for i in places)
            raise SceneError(f"{key}: it may be column {both}: name it with --{key}")
        if places:
            return places[0]
    return None


def _plain(name: str) -> str:
    return re.sub(r"[^a-z]", "", name.lower().rpartition(".")[2])


def _missing(header: Sequence[str], what: str, option: str) -> str:
    return f"no column holds {what}: there are {_listed(header)}; name it with --{option} COLUMN"


def _listed(header: Sequence[str]) -> str:
    shown = ", ".join(x[:40] for x in header[:12] if x)
    return f"{shown}, ..." if len(header) > 12 else shown or "none"
