"""A sampled loop with parameters in ranges: whether a root is on the unit circle for any of their
values.

The number of roots in |z| >= 1 changes only where one is on the circle: where none is, for any
values, one exact count holds for all of them. Cells of values, in balls, are cut until each is
proven clear of the circle (by the tests of ``opened``), or there are too many. Begin with
``OnCircle.left``; what is left proves nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

import flint
from flint import arb, arb_mat
from sympy import Expr, Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, expression_ball, fraction_ball
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.sampledloop import SampledLoop, hurwitz_rows, is_clear
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clockedloop import loop_of

# Working precision, bits: cells are wide, so that rounding is small beside them.
_BITS_OF_CELLS = 96
# Cells that are looked at: some seconds.
_MOST_CELLS = 3000

Cell: TypeAlias = tuple[tuple[Fraction, Fraction], ...]
"""From which share of each range to which."""


@dataclass(frozen=True)
class OnCircle:
    """A sampled loop with symbols for some of its parameters, and the ``ranges`` of these, lowest
    and highest value."""

    loop: SampledLoop
    ranges: Mapping[Symbol, tuple[Expr, Expr]]

    @classmethod
    def of(cls, scene: Scene, hand: Hand, ranges: Mapping[Symbol, tuple[Expr, Expr]]) -> OnCircle:
        """The loop of a scene in a hand. UndecidedError where a root stays at z = 1 for all values,
        so that no cell would ever be clear."""
        display = {p.path: p.symbol for p in scene.parameters if p.symbol in ranges}
        own = {p.symbol.name: p.symbol for p in hand.parameters if p.symbol in ranges}
        found = cls(loop_of(scene.with_values(display), hand.with_values(own)), ranges)
        if found.loop.at_one == 0:
            raise UndecidedError(
                "the roots of a sampled loop of which one stays at z = 1, for all values at once"
            )
        return found

    def left(self) -> list[Cell]:
        """The cells in which a root may be on the circle; outside of them none is, proven.

        An empty list proves that none is anywhere.
        """
        waiting, looked = [((Fraction(0), Fraction(1)),) * len(self.ranges)], 0
        while waiting and looked < _MOST_CELLS:
            tick(looked, _MOST_CELLS, "cells of ranges")
            cell, looked = waiting.pop(0), looked + 1
            if not self.is_clear(cell):
                waiting += cell_halves(cell, range(len(cell)))
        return waiting

    def is_clear(self, cell: Cell) -> bool:
        """Whether no root is on the circle for any values of a cell, proven."""
        with flint.ctx.workprec(_BITS_OF_CELLS):
            try:
                return is_clear(self.loop, self._at(cell), self.loop.at_one)
            except (UndecidedError, ZeroDivisionError, ValueError):
                return False

    def is_stable(self, values: Mapping[Symbol, Expr]) -> bool | None:
        """Whether the loop is stable for some values and all that clear cells join to them, or for
        none of these; None where that is not known.

        The roots are counted before anything cancels. So none at all proves that it is stable; one
        may cancel at some of the values, which would be stable, unless ``hides_none``.
        """
        if self.loop.at(values).unstable() == (0, 0):
            return True
        return False if self.hides_none else None

    @cached_property
    def hides_none(self) -> bool:
        """Whether nothing that does not decay can be hidden, for any values: neither by the plant
        nor by the controller.

        The plant's poles have Re s < 0, by Hurwitz, but for some at s = 0, which would show at z =
        1; those of the controller have |z| <= 1, as their coefficients tell.
        """
        with flint.ctx.workprec(_BITS_OF_CELLS):
            known = self._at(((Fraction(0), Fraction(1)),) * len(self.ranges))
            plant = list(self.loop.plant.denominator)
            # Poles at s = 0 are taken off: what they hide would be a root at z = 1, on the circle.
            while plant[0] == 0:
                plant.pop(0)
            # Hurwitz' criterion asks for a positive leading coefficient.
            if expression_ball(plant[-1], known) < 0:
                plant = [-x for x in plant]
            # A polynomial whose first coefficient outweighs the sum of all others, all in size, has
            # no root beyond the unit circle.
            first, *others = (expression_ball(x, known) for x in self.loop.below)
            return (
                self._is_never_negative(plant[0])
                and _is_hurwitz([expression_ball(x, known) for x in plant])
                and bool(abs(first) >= sum(map(abs, others), arb(0)))
            )

    def _is_never_negative(self, formula: Expr) -> bool:
        """Whether a formula is shown not to be negative for any values: a sum of products of
        nonnegative numbers and symbols. False proves nothing."""
        terms = formula.expand().as_ordered_terms()
        lows = [self.ranges[x][0] for x in formula.free_symbols]
        has_no_minus = all(x.as_coeff_Mul()[0] >= 0 for x in terms)
        return has_no_minus and all(sign_of_number(x) >= 0 for x in lows)

    def _at(self, cell: Cell) -> dict[Expr, Ball]:
        """The values of a cell, in balls; at the current working precision."""
        known: dict[Expr, Ball] = {}
        for (symbol, (low, high)), (start, end) in zip(self.ranges.items(), cell, strict=True):
            a, b = expression_ball(low), expression_ball(high)
            first = a + fraction_ball(start) * (b - a)
            last = a + fraction_ball(end) * (b - a)
            known[symbol] = first.union(last)
        return known


def cell_halves(cell: Cell, sides: Sequence[int]) -> list[Cell]:
    """A cell cut in two along the widest of some sides."""
    i = max(sides, key=lambda n: cell[n][1] - cell[n][0])
    low, high = cell[i]
    middle = (low + high) / 2
    return [(*cell[:i], part, *cell[i + 1 :]) for part in ((low, middle), (middle, high))]


def _is_hurwitz(row: Sequence[Ball]) -> bool:
    """Whether a polynomial with ascending coefficients, the first of them >= 0, is proven to have
    all roots in Re s < 0, or one at 0: by Hurwitz' determinants."""
    if not all(x > 0 for x in row[1:]):
        return False
    # All leading minors but the last one: it is that before it times the first coefficient, which
    # may be 0.
    rows = hurwitz_rows(row)
    minors = (arb_mat([line[:k] for line in rows[:k]]).det() for k in range(1, len(row) - 1))
    return all(x > 0 for x in minors)
