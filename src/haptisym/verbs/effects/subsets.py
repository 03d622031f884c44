"""The fewest effects that give the ratios of a whole scene within a tolerance: found by sampling, decided by proof."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import comb, inf, nextafter

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Rational

from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.programs.series import FLOATS, InSteps, series_arithmetic
from haptisym.verbs.effects.differences import BallChain, BandPiece, Difference, Kept, Supremum

_DEPTH = 7  # of the pieces in whose middles ratios are sampled
_MOST_SUBSETS = 1 << 12  # that are gone through: all of 12 effects


@dataclass(frozen=True)
class Selection:
    """Effects that are kept, with the largest change that the others make together.

    ``smallest`` : whether every smaller set, and every one as small with a lower bound, is proven not to do.
    """

    kept: Kept
    bound: Mapping[Part, Supremum]
    smallest: bool

    @property
    def worst(self) -> float:
        """The largest of its bounds."""
        return max(x.most for x in self.bound.values())


@dataclass(frozen=True)
class SubsetSearch:
    """The search in one scene for one tolerance, an exact number >= 0.

    Effects may make up for each other, so a set that does is not known from a larger or a smaller one: all sets are
    gone through by size. Sampling only says in which order to look, and where: a set is refused for a frequency at which
    the change is proven to exceed the tolerance, and taken for a bound that is proven not to.
    """

    scene: Scene
    balls: BallChain
    tolerance: Expr

    def choose(self) -> Selection:
        """The fewest effects; of several sets that size, the one with the lowest bound."""
        everything, gone_through, smallest = self.balls.everything, 0, True
        for size in range(len(everything)):
            gone_through += comb(len(everything), size)
            if gone_through > _MOST_SUBSETS:
                return self._one_by_one()
            sets = [frozenset(kept) for kept in combinations(sorted(everything), size)]
            verdicts = {kept: self._verdict(kept) for kept in sets}
            smallest = smallest and None not in verdicts.values()
            found = [self._choice(kept, smallest=smallest) for kept, within in verdicts.items() if within]
            if found:
                return min(found, key=lambda choice: choice.worst)
        return self._choice(everything, smallest=smallest)

    def _one_by_one(self) -> Selection:
        """A small set, if not surely the smallest: effects are left out in turn while the bound allows it."""
        kept = self.balls.everything
        while True:
            smaller = sorted((kept - {i} for i in kept), key=lambda x: self._sampled(x)[0])
            found = next((x for x in smaller if self._verdict(x)), None)
            if found is None:
                return self._choice(kept, smallest=False)
            kept = found

    def _choice(self, kept: Kept, *, smallest: bool) -> Selection:
        found = {part: self._difference(kept, part).supremum() for part in Part}
        above = nextafter(self._limit, inf)
        bound = {part: Supremum(x.least, min(x.most, above)) for part, x in found.items()}
        return Selection(kept, bound, smallest)

    def _verdict(self, kept: Kept) -> bool | None:
        """Whether a set does; None where that stayed undecided."""
        change, part, piece = self._sampled(kept)
        if change > self._limit and self._at(kept, part, piece) > self._limit:
            return False
        verdicts = [self._within(self._difference(kept, part)) for part in Part]
        return None if None in verdicts and False not in verdicts else all(verdicts)

    def _within(self, difference: Difference) -> bool | None:
        found = difference.supremum(self._limit)
        if found.most <= self._limit or found.least > self._limit:
            return found.most <= self._limit
        return difference.stays_within(self.tolerance)

    def _difference(self, kept: Kept, part: Part) -> Difference:
        return Difference(self.scene, self.balls, kept, part)

    def _at(self, kept: Kept, part: Part, piece: BandPiece) -> float:
        with series_arithmetic():
            return self._difference(kept, part).at_middle(piece)

    @cached_property
    def _limit(self) -> float:
        """The largest float that is not above the tolerance."""
        near = float(self.tolerance)
        return near if Rational(*near.as_integer_ratio()) <= self.tolerance else nextafter(near, -inf)

    def _sampled(self, kept: Kept) -> tuple[float, Part, BandPiece]:
        """The largest change among samples, not proven, and where it is."""
        both = self._samples.ratios(kept)
        with np.errstate(invalid="ignore"):
            change = np.nan_to_num(np.abs(both - self._all), nan=0.0)
        part, index = np.unravel_index(int(change.argmax()), change.shape)
        return float(change[part, index]), tuple(Part)[int(part)], BandPiece(_DEPTH, int(index))

    @cached_property
    def _samples(self) -> _Samples:
        return _Samples(self.balls)

    @cached_property
    def _all(self) -> NDArray[np.float64]:
        return self._samples.ratios(self.balls.everything)


class _Samples:
    """The links of a scene in the middles of pieces, as floats."""

    def __init__(self, balls: BallChain) -> None:
        self.balls = balls
        with series_arithmetic(), np.errstate(all="ignore"):
            self.omega = np.array([float(balls.middle(BandPiece(_DEPTH, i))) for i in range(1 << _DEPTH)])
            self.links = [InSteps(program, FLOATS) for program in balls.programs]
            self.known = [link.known(1j * self.omega) for link in self.links]

    def ratios(self, kept: Kept) -> NDArray[np.float64]:
        """r_r and r_i in two rows."""
        with np.errstate(all="ignore"):
            H, *state = self.links[0].results(self.known[0])
            for i in sorted(kept):
                state = [*self.links[1 + i].results(self.known[1 + i], state)]
            parts = [np.abs(self.balls.part_of(state[1], part) / np.abs(H)) for part in Part]
        return np.stack([np.broadcast_to(x, self.omega.shape) for x in parts])
