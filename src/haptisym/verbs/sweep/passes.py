"""One batch of parameter sets in floats: zeros that are proven, and the answers that are read off them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from sympy import Expr

from haptisym.kernel.reals import ExactNumber, bounds
from haptisym.verbs.sweep.batch import Array, product
from haptisym.verbs.sweep.bernstein import Zeros, isolate, refine
from haptisym.verbs.sweep.combined import Found, Ordered, changes
from haptisym.verbs.sweep.curves import Curves, Excess, FamilyLattice, FamilyProduct
from haptisym.verbs.sweep.families import Family, Powers, within_reach
from haptisym.verbs.sweep.told import ABSENT, FLOAT, SYSTEMS

TOLERANCE = 1e-10
"""Relative: every frequency that is answered is proven to lie this close to the true one."""
NARROWER = 0.95 * TOLERANCE
"""Of (omega/scale)^step, step 1 or 2; the rest is for taking the root and scaling back."""
Columns: TypeAlias = dict[str, Array]


@dataclass(frozen=True)
class Band:
    """The band as fractions of its high end, to the power of the curves' variable.

    ``doubtful``: the exact low end is no double, and lies in the first segment.
    """

    high: float
    low_fraction: float
    ends: tuple[float, ...]
    doubtful: bool

    @classmethod
    def of(cls, low: Expr, high: Expr, step: int) -> Band:
        """The band as the unit interval; ends rounded outwards."""
        below, above = bounds(ExactNumber((low / high) ** step).tight_ball(200))
        first, last = _float_below(below), -_float_below(-above)
        ends = (first,) if first == last else (first, last)
        return cls(float(ExactNumber(high)), float(ExactNumber(low / high)), ends, len(ends) > 1)

    def edges(self, segments: int, step: int) -> tuple[float, ...]:
        """Ends of segments that are alike in frequency."""
        start = self.ends[-1] ** (1 / step)
        inner = ((start + (1 - start) * i / segments) ** step for i in range(1, segments))
        return (*self.ends, *(x for x in inner if self.ends[-1] < x < 1), 1.0)


def _float_below(x: Fraction) -> float:
    nearest = float(x)
    return nearest if Fraction(nearest) <= x else float(np.nextafter(nearest, -np.inf))


class Pass:
    """One batch in floats of one kind."""

    def __init__(self, curves: Curves, band: Band, values: Array) -> None:
        self.curves, self.band, self.sets = curves, band, values.shape[1]
        self.powers = Powers(values)
        self.decided = within_reach(values, curves.products)
        self._products: dict[FamilyProduct, Any] = {}

    def answers(self) -> tuple[Columns, Array]:
        """All variables, and for which sets they are proven."""
        with np.errstate(all="ignore"):
            self._no_zero_in(self.curves.definite)
            parts = {name: self._crossings(e) for name, e in self.curves.excess.items()}
            turns = [self._zeros(None if x is None else self._at(x)) for x in self.curves.changeovers]
        columns: Columns = {"method": np.full(self.sets, FLOAT, dtype=np.int8)}
        for name, found in parts.items():
            columns[f"crossings_{name}"], columns[f"first_crossing_{name}"] = self._told(found)
        for name, found in zip(SYSTEMS, turns, strict=True):
            columns[f"changeovers_{name}"], columns[f"changeover_{name}"] = self._told(found)
        return columns | self._transparency(parts, columns), self.decided

    def _at(self, families: FamilyProduct) -> Any:
        """A product for each set, once: something that can be subtracted from another, and isolated."""
        if families not in self._products:
            self._products[families] = self._product(families)
        return self._products[families]

    def _product(self, families: FamilyProduct) -> Any:
        single = len(families) == 1
        return families[0].at(self.powers) if single else product([self._at((f,)) for f in families])

    def _no_zero_in(self, families: Sequence[Family]) -> None:
        for f in families:
            found = self._isolated(self._at((f,)))
            self.decided[found.sets] = False

    def _crossings(self, e: Excess | None) -> Found:
        """Where a criterion's sign changes."""
        if not isinstance(e, FamilyLattice):
            return self._zeros(None if e is None else self._at(e.above) - self._at(e.below))
        zeros = {f: self._zeros(self._at((f,))) for f in e.factors}
        if not zeros:
            return Found(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, e.sign))
        found, certain = changes(e, zeros, self.band.low_fraction, 4 * TOLERANCE)
        self.decided &= certain
        return found

    def _isolated(self, p: Any) -> Zeros:
        found = self._all_zeros(p)
        self.decided &= found.decided
        return found

    def _all_zeros(self, p: Any) -> Zeros:
        edges = self.band.edges(_segments(p.degree), self.curves.step)
        return isolate(p, edges, first_is_doubt=self.band.doubtful)

    def _refined(self, p: Any, low: Array, high: Array) -> tuple[Array, Array]:
        return refine(p, low, high, NARROWER)

    def _zeros(self, p: Any) -> Found:
        if p is None:
            return Found(np.zeros(0, dtype=int), np.zeros(0), np.full(self.sets, -1))
        found = self._isolated(p)
        x, proven = self._refined(p.of(found.sets), found.low, found.high)
        self.decided[found.sets[~proven]] = False
        return Found(found.sets, (np.sqrt(x) if self.curves.step == 2 else x).astype(float), found.first)

    def _told(self, found: Found) -> tuple[Array, Array]:
        """How many, and the first one."""
        column = np.full(self.sets, ABSENT)
        begins = np.ones(len(found.sets), dtype=bool)
        begins[1:] = found.sets[1:] != found.sets[:-1]
        column[found.sets[begins]] = found.omega[begins] * self.band.high
        return np.bincount(found.sets, minlength=self.sets), column

    def _transparency(self, parts: Mapping[str, Found], columns: Columns) -> Columns:
        clear = np.logical_and.reduce([found.first < 0 for found in parts.values()])
        ends = np.fmin.reduce(
            [*(columns[f"first_crossing_{name}"] for name in parts), np.full(self.sets, self.band.high)]
        )
        return {"bandwidth": np.where(clear, ends, ABSENT), "transparent": self._fraction(parts, columns)}

    def _fraction(self, parts: Mapping[str, Found], columns: Columns) -> Array:
        """The part of the band where all are negative."""
        low, clear = self.band.low_fraction, []
        for name, found in parts.items():
            # with one crossing at most, a part is negative on one interval: from the low end or up to the high end
            cross = np.nan_to_num(columns[f"first_crossing_{name}"] / self.band.high, nan=1.0)
            clear.append((np.where(found.first < 0, low, cross), np.where(found.first < 0, cross, 1.0)))
        starts, ends = zip(*clear, strict=True)
        lengths: Array = np.maximum(np.minimum.reduce(ends) - np.maximum.reduce(starts), 0.0)
        several = np.logical_or.reduce([columns[f"crossings_{name}"] > 1 for name in parts]).nonzero()[0]
        if len(several):
            lengths[several] = _alternating([found.of(several, self.sets) for found in parts.values()], low)
        return lengths / (1.0 - low)


def _alternating(parts: Sequence[Found], low: float) -> Array:
    """The total length on which all are negative, from all crossings in order."""
    count = len(parts[0].first)
    rows = Ordered.of(list(parts), low, count)
    following = np.append(rows.omega[1:], 1.0)
    following[:-1][rows.begins[1:]] = 1.0
    clear = (rows.signs < 0).all(axis=0)
    return np.bincount(rows.sets, weights=(following - rows.omega) * clear, minlength=count)


def _segments(degree: int) -> int:
    """Into how many segments the band is cut at first: more cost every set, fewer cost those that need to be cut further."""
    return 1 if degree < 2 else 4
