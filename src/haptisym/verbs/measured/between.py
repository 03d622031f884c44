"""What is told between the lines, where a bound on the slope is stated: stretches that exceed, lie below or stay unresolved.

Cells between neighbouring lines are halved until each is told or no wider than rounding: an end of a stretch that is told lies
within that of where the swept discs cease to tell, always on the safe side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from haptisym.model.jnd import Part
from haptisym.model.measured import Reals
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.slope import Slope
from haptisym.verbs.measured.judging import CODES, Lines, judged
from haptisym.verbs.measured.swept import Cells, Swept

_NARROW = 1e-12
"""Of its frequency: a cell that is not halved any more."""
_MOST = 200
"""Cells of one gap at one time: more are open only where a disc follows the border, and stay so."""
_TOGETHER = 100_000
"""Gaps."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """From ``low`` to ``high``, rad/s, without gaps; ``code`` : 1 exceeds, -1 below, 0 unresolved."""

    low: Reals
    high: Reals
    code: Any

    def __len__(self) -> int:
        return len(self.code)

    def rows(self) -> list[dict[str, Any]]:
        """As documents have it."""
        ends = zip(self.low.tolist(), self.high.tolist(), self.code.tolist(), strict=True)
        return [{"band": [low, high], "verdict": CODES[code].value} for low, high, code in ends]

    def length(self, code: int) -> float:
        """Of all of one kind together, rad/s."""
        own = self.code == code
        return float((self.high[own] - self.low[own]).sum())


@dataclass(frozen=True, eq=False)
class Between:
    """``told`` : of each part, and of None where the region judges both together. ``contradicted`` : from where to where lines
    differ by more than discs and bound allow, so that nothing is said. ``grown`` : the radius that discs have at most between
    the lines, relative to ``|H_env|``; of a stretch of none, 0."""

    told: Mapping[Part | None, Stretches]
    contradicted: tuple[tuple[float, float], ...]
    grown: float

    def row(self, slopes: Mapping[str, Slope]) -> dict[str, Any]:
        """As documents have it. ``slopes`` : of which response each bound is."""
        bounds = {key: {"bound": x.bound, "unit": x.unit, "relative": x.relative} for key, x in slopes.items()}
        told = {part.value if part else "joint": x.rows() for part, x in self.told.items()}
        contradicted = [list(x) for x in self.contradicted]
        return {
            "slope": bounds,
            **told,
            "contradicted": contradicted,
            "grown": self.grown if isfinite(self.grown) else None,
        }


def between(scene: MeasuredScene, x: Lines) -> Between | None:
    """Of all gaps between the lines that a scene judges; None without a bound on the slope."""
    if scene.perceived.slope is None:
        return None
    swept = Swept(scene, x)
    wrong = swept.contradicted
    parts = [part for part in (*Part, None) if judged(scene, x, part)]
    told = {part: _joined(swept, wrong, part) for part in parts}
    lost = [(float(a), float(b)) for a, b in zip(swept.omega[:-1][wrong], swept.omega[1:][wrong], strict=True)]
    return Between(told, tuple(lost), _grown(swept))


def _grown(swept: Swept) -> float:
    """At the places half-way, where grown discs have most."""
    gaps = np.arange(len(swept.omega) - 1)
    if not len(gaps):
        return 0.0
    middle = (swept.omega[:-1] + swept.omega[1:]) / 2
    radii = [x.radius for x in swept.lines(Cells(gaps, middle, middle)) if x.radius is not None]
    return float(np.min(radii[:2], axis=0).max())


def _joined(swept: Swept, wrong: Any, part: Part | None) -> Stretches:
    """Neighbouring cells that are told alike as one stretch."""
    gaps = np.flatnonzero(~wrong)
    found = [(Cells(lost := np.flatnonzero(wrong), swept.omega[lost], swept.omega[lost + 1]), np.zeros(len(lost), int))]
    for start in range(0, len(gaps), _TOGETHER):
        found += _settled(swept, gaps[start : start + _TOGETHER], part)
    low, high = (np.concatenate([getattr(cells, key) for cells, _ in found]) for key in ("low", "high"))
    code, order = np.concatenate([x for _, x in found]), np.argsort(low, kind="stable")
    low, high, code = low[order], high[order], code[order]
    if not len(code):
        return Stretches(low, high, code)
    starts = np.flatnonzero(np.diff(code, prepend=2))
    return Stretches(low[starts], high[np.append(starts[1:], len(code)) - 1], code[starts])


def _settled(swept: Swept, gaps: Any, part: Part | None) -> list[tuple[Cells, Any]]:
    """Cells of gaps, each with what is told of it."""
    found = []
    cells = Cells(gaps, swept.omega[gaps], swept.omega[gaps + 1])
    while len(cells.gap):
        code, is_open = _code(swept, cells, part)
        crowd = np.bincount(cells.gap[~is_open & (code == 0)], minlength=len(swept.omega)) > _MOST
        done = (code != 0) | is_open | (cells.high - cells.low <= _NARROW * cells.high) | crowd[cells.gap]
        found.append((cells.at(done), code[done]))
        cells = cells.at(~done).halves()
    return found


def _code(swept: Swept, cells: Cells, part: Part | None) -> tuple[Any, Any]:
    """Of each cell what one of its discs tells, and whether it lies too far within what none tells to be halved."""
    middle = (cells.low + cells.high) / 2
    codes, is_open = np.zeros(len(middle), int), np.ones(len(middle), bool)
    for whole, point in zip(swept.lines(cells), swept.lines(Cells(cells.gap, middle, middle)), strict=True):
        told, here = judged(swept.scene, whole, part), judged(swept.scene, point, part)
        assert told
        assert here
        assert whole.radius is not None
        assert point.radius is not None
        codes = np.where(codes == 0, told.verdict, codes)
        with np.errstate(invalid="ignore"):
            moved = whole.radius - point.radius + np.abs(told.distance - here.distance)
            is_open &= point.radius - np.abs(here.distance) > 2 * moved
    return codes, is_open & (codes == 0)
