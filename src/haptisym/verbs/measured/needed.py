"""What would resolve the open lines: the coherence, the number of averages or the radius at which their discs decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.model.measured import Measurement, Reals, averages_for, coherence_for
from haptisym.verbs.measured.judging import Judged, Lines

MOST_AVERAGES = 1e6
"""More than anyone takes: a line that would need more lies at its threshold, as far as measuring goes."""

MOST_COHERENCE = 1 - 1e-6
"""More than any bench gives."""


@dataclass(frozen=True)
class Share:
    """What resolves half of the open lines, and all of them; None where nothing sensible does."""

    half: float | None
    all: float | None

    def row(self) -> dict[str, Any]:
        """As a document has it."""
        return {"half": self.half, "all": self.all}


@dataclass(frozen=True)
class Needed:
    """What would resolve open lines if the estimates stay where they are, each quantity alone, the others as they are.

    ``radius`` : at most, relative to ``|H_env|``. ``coherence``, ``averages`` : at least; None where the discs do not come from
    them, or not from them alone.
    """

    lines: int
    radius: Share
    coherence: Share | None
    averages: Share | None


def needed(x: Lines, found: Sequence[Judged]) -> Needed | None:
    """Of the lines that are open in some judgement; None if none is."""
    open_lines = np.any([one.verdict == 0 for one in found], axis=0)
    if not open_lines.any():
        return None
    margins = [np.where(one.verdict == 0, np.abs(one.distance), np.inf) for one in found]
    margin = np.min(margins, axis=0)[open_lines]
    felt, own = x.felt, x.own
    coherence = averages = None
    if felt.coherence is not None and (own is None or own.discs is None):
        coherence, averages = _of_coherence(felt, x, margin, open_lines)
    return Needed(int(open_lines.sum()), _shares(-margin, negated=True), coherence, averages)


def _of_coherence(felt: Measurement, x: Lines, margin: Reals, at: Any) -> tuple[Share, Share]:
    assert felt.averages is not None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = margin * np.abs(x.environment[at]) / np.abs(x.perceived[at])
    coherence = coherence_for(relative, felt.averages, felt.confidence)
    averages = averages_for(relative, felt.coherence[at], felt.confidence)
    return _shares(coherence, most=MOST_COHERENCE), _shares(averages, most=MOST_AVERAGES)


def _shares(values: Reals, *, most: float = np.inf, negated: bool = False) -> Share:
    """The value that is enough for at least half of the lines, and for all; None for one above ``most``."""
    row, middle = np.nan_to_num(values, nan=np.inf), (len(values) - 1) // 2
    found = (
        float(np.partition(row, middle)[middle]),
        float(row.max()),
    )  # as sorting all would give, in a fourth of the time
    half, every = (None if value > most or not np.isfinite(value) else -value if negated else value for value in found)
    return Share(half, every)
