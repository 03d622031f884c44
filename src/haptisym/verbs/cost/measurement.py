"""One measurement of accuracy against time, and by how much a change exceeds what is not noticed.

One measurement of accuracy against time, and what was not measured.

By how much a change exceeds what is not noticed, as plain floats have it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from haptisym.judge.crossings import Criterion
from haptisym.judge.regions import Sided
from haptisym.model.jnd import Part
from haptisym.programs.floats import floats_of


@dataclass(frozen=True)
class Measurement:
    """One measurement.

    ``task`` : evaluate, crossings, delay, effects, simulation or sweep. ``digits`` : right decimal digits of the worst number.
    ``seconds`` : median time; of ``evaluate`` for one frequency, of ``sweep`` for one set, of the other tasks for the whole
    answer. ``spread`` : half of the range of the middle half of the repeats, over it; None of fewer than four. ``proven`` :
    whether the answer is proven. ``missed``, ``invented`` : crossings that are there and not found, found and not there.
    ``wrong``, ``sets`` : of a sweep the sets with a wrong count, of how many held against exact arithmetic; ``left_open`` : how
    many sets of those ``asked`` about were not reached within the limit of time, None where all were.
    """

    task: str
    method: str
    digits: float
    seconds: float
    proven: bool
    missed: int = 0
    invented: int = 0
    wrong: int | None = None
    sets: int | None = None
    left_open: int | None = None
    asked: int | None = None
    spread: float | None = None

    def row(self) -> dict[str, Any]:
        """As documents have it: what is of sweeps alone, or of a limit that was reached, is left out elsewhere."""
        return {key: x for key, x in asdict(self).items() if x is not None}

    @property
    def complete(self) -> bool:
        """Whether no crossing is missed and none invented."""
        return not (self.missed or self.invented)


@dataclass(frozen=True)
class Omission:
    """A method that was not measured, and why."""

    task: str
    method: str
    reason: str


def front(rows: Iterable[Measurement]) -> tuple[Measurement, ...]:
    """The rows that no other one beats in both digits and time, fastest first; those with wrong counts are left out.

    >>> slow, fast, worse = (Measurement("evaluate", "", n, t, False) for n, t in ((30, 2.0), (15, 1.0), (14, 1.5)))
    >>> front([slow, fast, worse]) == (fast, slow)
    True
    """
    found: list[Measurement] = []
    for row in sorted((x for x in rows if x.complete), key=lambda x: (x.seconds, -x.digits)):
        if not found or row.digits > found[-1].digits:
            found.append(row)
    return tuple(found)


@dataclass(frozen=True, kw_only=True)
class HardRow(Measurement):
    """One method's answer to one hard case; ``verdict``: right, how many digits are lost, what is wrong, or why there is none."""

    family: str
    case: str
    condition: float
    ours: bool
    verdict: str

    @property
    def answered(self) -> bool:
        """Whether the method fits the question at all."""
        return not self.verdict.startswith("cannot")


def margin(x: Criterion, omega: Any, H: Any, dH: Any) -> Any:
    """Positive where a change dH of H is noticed: a ratio less its limit, or how many times a region must be enlarged, less 1."""
    size = np.abs(H)
    if x.joint:
        return x.joint.enlarged(np.real(dH) / size, np.imag(dH) / size, lambda c: floats_of(c, omega)) - 1
    part = np.real if x.part is Part.REAL else np.imag
    ratio = np.abs(part(dH)) / size
    if not isinstance(x.region, Sided):
        return ratio - floats_of(x.threshold, omega)
    grows = np.abs(part(H + dH)) - np.abs(part(H))
    higher, lower = (floats_of(c, omega) for c in (x.region.higher, x.region.lower))
    limit = np.where(grows > 0, higher, np.where(grows < 0, lower, np.maximum(higher, lower)))
    least = 0.0 if x.region.floor is None else floats_of(x.region.floor, omega) / size
    return ratio - np.maximum(limit, least)
