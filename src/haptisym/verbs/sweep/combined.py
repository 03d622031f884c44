"""Where a lattice of many polynomials changes its sign, for many parameter sets at once: from the zeros of each polynomial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.curves import FamilyLattice, SignedProduct
from haptisym.verbs.sweep.families import Family


@dataclass(frozen=True)
class Found:
    """Frequencies, as fractions of the band's high end, in ascending order for each set."""

    sets: Array
    omega: Array
    first: Array
    """The sign at the band's low end, for each set."""

    def of(self, some: Array, count: int) -> Found:
        """Of some of the sets, numbered anew."""
        number = np.full(count, -1)
        number[some] = np.arange(len(some))
        kept = number[self.sets] >= 0
        return Found(number[self.sets[kept]], self.omega[kept], self.first[some])


@dataclass(frozen=True)
class Ordered:
    """All zeros of some functions, for each set in ascending order behind a row for its low end.

    ``kinds`` : whose zero it is, -1 for a low end. ``signs``: in rows, of each function from there on.
    """

    sets: Array
    omega: Array
    kinds: Array
    signs: Array

    @classmethod
    def of(cls, zeros: list[Found], low: float, count: int) -> Ordered:
        """All zeros of all functions, after the band's low end, in ascending order for each set."""
        every = np.arange(count)
        sets = np.concatenate([every, *(x.sets for x in zeros)])
        omega = np.concatenate([np.full(count, low), *(x.omega for x in zeros)])
        kinds = np.repeat(np.arange(-1, len(zeros)), [count, *(len(x.sets) for x in zeros)])
        order = np.lexsort((kinds, omega, sets))
        sets, omega, kinds = sets[order], omega[order], kinds[order]
        start = np.searchsorted(sets, every)
        signs = np.empty((len(zeros), len(sets)), dtype=np.int8)
        for kind, x in enumerate(zeros):
            passed = np.cumsum(kinds == kind)
            odd = (passed - passed[start][sets]) % 2 == 1
            signs[kind] = np.where(odd, -x.first[sets], x.first[sets])
        return cls(sets, omega, kinds, signs)

    @property
    def begins(self) -> Array:
        """Which rows are those of low ends."""
        found: Array = self.kinds < 0
        return found


def changes(lattice: FamilyLattice, zeros: Mapping[Family, Found], low: float, near: float) -> tuple[Found, Array]:
    """Where the lattice changes its sign, and for which sets that is certain.

    Not where two zeros lie so near each other (relatively, ``near``) that their order is not known, nor where the lattice is 0
    between equal signs, as where several of its functions have one zero, nor where one that is 0 at omega = 0 decides there.
    """
    listed = list(zeros.values())
    count = len(listed[0].first)
    rows = Ordered.of(listed, low, count)
    signs = dict(zip(zeros, rows.signs, strict=True))
    positive = _positive(lattice, signs)
    changed = np.zeros(len(positive), dtype=bool)
    changed[1:] = positive[1:] != positive[:-1]
    changed &= ~rows.begins
    certain = np.ones(count, dtype=bool)
    close = np.diff(rows.omega) <= near * rows.omega[1:]
    certain[rows.sets[1:][close & ~rows.begins[1:] & ~rows.begins[:-1]]] = False
    for kind, f in enumerate(signs):
        own = rows.kinds == kind
        there = {g: row[own] for g, row in signs.items()} | {f: np.zeros(own.sum(), np.int8)}
        vanishes = _positive(lattice, there, or_0=True) & ~_positive(lattice, there)
        certain[rows.sets[own][vanishes != changed[own]]] = False
    begun = {f: row[rows.begins] for f, row in signs.items()}
    certain &= _positive(lattice, begun, at_0=1) == _positive(lattice, begun, at_0=-1)
    first = np.where(positive[rows.begins], 1, -1)
    return Found(rows.sets[changed], rows.omega[changed], first), certain


def _positive(
    lattice: FamilyLattice, signs: Mapping[Family, Array], *, or_0: bool = False, at_0: int | None = None
) -> Any:
    """Where the lattice is positive, ``or_0``; ``at_0`` : with that sign for what begins with 0."""

    def of(x: SignedProduct) -> Any:
        own = np.full_like(next(iter(signs.values())), x.sign if at_0 is None or not x.begins_at_0 else at_0)
        for f in x.factors if at_0 is None or not x.begins_at_0 else ():
            own = own * signs[f]
        return own >= 0 if or_0 else own > 0

    return np.logical_or.reduce([np.logical_and.reduce([of(x) for x in term]) for term in lattice.terms])
