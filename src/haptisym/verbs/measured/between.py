"""What is told between the lines, where a bound on the slope is stated.

How far the border of a region moves over a cell of frequency, where its numbers are formulas in omega.

Discs between the lines: each swept by the bound on the slope, over cells of frequency, and H_env over a cell as a disc.

A cell lies between two neighbouring lines. Over all of it the truth lies in the disc of the left line as grown at the cell's
right end, in the disc of the right line as grown at its left end, and so in the smallest disc around what both have in common.

What is told between the lines, where a bound on the slope is stated: stretches that exceed, lie below or stay unresolved.

Cells between neighbouring lines are halved until each is told or no wider than rounding: an end of a stretch that is told lies
within that of where the swept discs cease to tell, always on the safe side.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import isfinite
from typing import Any

import numpy as np
from sympy import Expr

from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.measuredscene import MeasuredScene
from haptisym.model.slope import Slope
from haptisym.programs.program import Program, Writer
from haptisym.programs.taylormodels import Model, Modelled, variable
from haptisym.verbs.measured.judging import CODES, Lines, depth_of, judged, upright, values_of


def spread(c: Threshold, low: Reals, high: Reals, least: Reals) -> Reals:
    """At most how far the border is anywhere in a cell from where it is at its middle, relative to ``|H_env|``.

    ``least`` : the least ``|H_env|`` in the cell, with which a floor is compared.
    """
    if c.is_constant:
        return np.zeros(len(low))
    moves = _Moves(low, high)
    with np.errstate(all="ignore"):
        if c.region.shape is Shape.POLYGON:
            found = _of_polygon(c, moves)
        else:
            sides = [c.real, c.imag, *(x for x in c.region.lower if x is not None)]
            found = sum((moves(x) for x in sides), np.zeros(len(low)))
        if c.region.shape is Shape.ELLIPSE:
            found = _of_ellipse(c, moves, found)
        if c.region.floor is not None and c.region.floor.has(omega):
            found = found + moves(c.region.floor) / least
    return np.where(np.isfinite(found), found, np.inf)


class _Moves:
    """By how much a formula differs at most from what it is at the middle of each cell."""

    def __init__(self, low: Reals, high: Reals) -> None:
        self.middle = (low + high) / 2
        self._at = variable(self.middle, (high - low) / 2, float(high.max()), 0, 1)._value

    def __call__(self, formula: Expr) -> Reals:
        if not formula.has(omega):
            return np.zeros(len(self.middle))
        found = _modelled(formula).run([self._at])[""]
        assert isinstance(found, Model)
        here, (least, most) = values_of(formula, self.middle), (x[:, 0] for x in found.bounds())
        moved: Reals = np.maximum(most - here, here - least)
        return moved


@lru_cache(maxsize=64)
def _modelled(formula: Expr) -> Modelled:
    write = Writer((omega,))
    return Modelled(write.program({"": write.expression(formula)}))


def _of_ellipse(c: Threshold, moves: _Moves, sides: Reals) -> Reals:
    """Its support function is the length of M u with M = [[a, t b], [0, b sqrt(1 - t^2)]]: M moves by no more than this."""
    tilt, turned = np.abs(values_of(c.region.tilt, moves.middle)), moves(c.region.tilt)
    root = upright(tilt)
    roots = [np.abs(root - upright(np.clip(x, 0, 1))) for x in (tilt - turned, tilt + turned)]
    size = values_of(c.real, moves.middle) + values_of(c.imag, moves.middle) + sides
    found: Reals = 2 * sides + size * (turned + np.maximum(*roots))
    return found


def _of_polygon(c: Threshold, moves: _Moves) -> Reals:
    """Corners that move by d change where the border meets an axis by at most d times its farthest over its nearest point."""
    corners = c.region.corners
    d = sum((np.hypot(*(moves(x) for x in corner)) for corner in corners), np.zeros(len(moves.middle)))
    farthest = np.max([np.hypot(*(values_of(x, moves.middle) for x in corner)) for corner in corners], axis=0) + d
    nearest = depth_of(c, moves.middle) - d
    return np.where(nearest > 0, d * farthest / nearest, np.inf)


_ROUNDING = 1e-13
"""Of what is computed around the discs, relative to 1, to the change and to its radius."""


@dataclass(frozen=True, eq=False)
class Cells:
    """``gap`` : after which line each lies; ``low``, ``high`` : its ends, rad/s."""

    gap: Any
    low: Reals
    high: Reals

    def at(self, chosen: Any) -> Cells:
        """Some of them."""
        return Cells(self.gap[chosen], self.low[chosen], self.high[chosen])

    def halves(self) -> Cells:
        """Each as its two halves, in order."""
        middle = (self.low + self.high) / 2
        ends = (np.stack(x, 1).ravel() for x in ((self.low, middle), (middle, self.high)))
        return Cells(np.repeat(self.gap, 2), *ends)


@dataclass(frozen=True, eq=False)
class Discs:
    """``centre``, ``radius`` : one for each cell."""

    centre: Complexes
    radius: Reals


class Swept:
    """The lines of a scene of which the discs are bounded, and what lies between them."""

    def __init__(self, scene: MeasuredScene, x: Lines) -> None:
        kept = np.isfinite(x.perc_radius) & np.isfinite(x.env_radius)
        self.scene, self.omega = scene, x.omega[kept]
        self._felt = _Response(x.felt, self.omega, x.perceived[kept], x.perc_radius[kept])
        self._own = None if x.own is None else _Response(x.own, self.omega, x.environment[kept], x.env_radius[kept])

    @property
    def contradicted(self) -> Any:
        """For each gap, whether discs and bound contradict each other there: no response keeps to both."""
        found = self._felt.contradicted
        return found if self._own is None else found | self._own.contradicted

    def lines(self, cells: Cells) -> Iterator[Lines]:
        """Each cell as a line, in three ways; what is said of one of them is true wherever the discs hold the truth."""
        env = self._environment(cells) if self._own is None else self._own.discs(cells)[-1]
        middle = (cells.low + cells.high) / 2
        size = np.abs(env.centre)
        more = spread(self.scene.threshold, cells.low, cells.high, np.maximum(size - env.radius, 0))
        for felt in self._felt.discs(cells):
            with np.errstate(all="ignore"):
                change, share = (felt.centre - env.centre) / size, env.radius / size
                radius = ((env.radius + felt.radius) / size + np.abs(change) * share) / (1 - share)
                radius = np.where(share < 1, radius + more + _ROUNDING * (1 + np.abs(change) + radius), np.inf)
            own = self._felt.measurement
            yield Lines(middle, env.centre, felt.centre, env.radius, felt.radius, change, radius, own, None)

    @cached_property
    def _program(self) -> Program:
        return self.scene.frame.distortion().chain.program(["environment_real", "environment_imag"])

    def _environment(self, cells: Cells) -> Discs:
        """Around all that the model is over each cell: proven, but for the roundings of the last square root."""
        program = self._program
        at = variable((cells.low + cells.high) / 2, (cells.high - cells.low) / 2, float(cells.high.max()), 0, 1)._value
        found = Modelled(program).run([at] if program.inputs else [])
        with np.errstate(all="ignore"):
            models = (x if isinstance(x, Model) else at.number(x) for x in found.values())
            (a, b), (c, d) = ((low[:, 0], high[:, 0]) for low, high in (x.bounds() for x in models))
            centre = (a + b) / 2 + 0.5j * (c + d)
            known = np.isfinite(centre)
            radius = np.where(known, np.hypot(b - a, d - c) / 2 * (1 + _ROUNDING), np.inf)
        return Discs(np.where(known, centre, 0), radius)


@dataclass(frozen=True, eq=False)
class _Response:
    measurement: Measurement
    omega: Reals
    H: Complexes
    radius: Reals

    def discs(self, cells: Cells) -> list[Discs]:
        """Of the left line, of the right one, and around what they have in common."""
        left, right = self._of(cells.gap, cells.high), self._of(cells.gap + 1, cells.low)
        return [left, right, _common(left, right)]

    def _of(self, line: Any, at: Reals) -> Discs:
        H = self.H[line]
        return Discs(H, self._slope.grown(np.abs(H), self.radius[line], np.abs(at - self.omega[line])))

    @property
    def _slope(self) -> Any:
        return self.measurement.slope

    @property
    def contradicted(self) -> Any:
        sizes, apart = np.abs(self.H) + self.radius, np.diff(self.omega)
        lines = np.arange(len(apart))
        at = self.omega[:-1] + self._slope.nearest((sizes[:-1], sizes[1:]), apart)
        left, right = self._of(lines, at), self._of(lines + 1, at)
        reach = (left.radius + right.radius) * (1 + 1e-12) + 1e-14 * (sizes[:-1] + sizes[1:])
        return np.abs(left.centre - right.centre) > reach


def _common(x: Discs, y: Discs) -> Discs:
    """A disc around what two discs have in common, hardly larger than the smallest: that over their common chord, or one of them.

    From the smaller one's centre the chord is no further than that of the other, and so its place known to roundings of that:
    with them the chord is made longer, and its disc larger.
    """
    first = x.radius <= y.radius
    own, other = np.where(first, x.centre, y.centre), np.where(first, y.centre, x.centre)
    small, large = np.minimum(x.radius, y.radius), np.maximum(x.radius, y.radius)
    step = other - own
    apart = np.abs(step)
    with np.errstate(all="ignore"):
        foot = (apart - (large - small) * (large + small) / apart) / 2
        centre = own + step * (foot / apart)
        chord = np.sqrt(np.maximum((small - foot) * (small + foot), 0) + 1e-14 * small * (small + apart))
        chord += 1e-14 * (apart + np.abs(centre))
        between = (foot > 0) & (chord < small)
    return Discs(np.where(between, centre, own), np.where(between, chord, small))


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
