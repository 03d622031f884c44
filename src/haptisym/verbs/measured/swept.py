"""Discs between the lines: each swept by the bound on the slope, over cells of frequency, and H_env over a cell as a disc.

A cell lies between two neighbouring lines. Over all of it the truth lies in the disc of the left line as grown at the cell's
right end, in the disc of the right line as grown at its left end, and so in the smallest disc around what both have in common.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from haptisym.model.measured import Complexes, Measurement, Reals
from haptisym.model.measuredscene import MeasuredScene
from haptisym.programs.modelled import Modelled
from haptisym.programs.program import Program
from haptisym.programs.taylormodels import Model, variable
from haptisym.verbs.measured.judging import Lines
from haptisym.verbs.measured.spread import spread

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
