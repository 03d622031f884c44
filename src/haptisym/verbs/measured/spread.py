"""How far the border of a region moves over a cell of frequency, where its numbers are formulas in omega."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from sympy import Expr

from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Threshold
from haptisym.model.measured import Reals
from haptisym.model.regions import Shape
from haptisym.programs.modelled import Modelled
from haptisym.programs.program import Writer
from haptisym.programs.taylormodels import Model, variable
from haptisym.verbs.measured.regions import depth_of, upright, values_of


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
