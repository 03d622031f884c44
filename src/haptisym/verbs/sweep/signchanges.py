"""What follows from the sign changes of several functions on a band, for many parameter sets at
once?

A *set* is one value for each swept parameter; arrays have one entry for each set, or one for each
zero with the index of its set. A function that is not 0 everywhere is known by its sign at the low
end and the frequencies at which it changes (``SignChanges``). From these follow, by sorting:

- the sign changes of a *lattice*, the maximum over terms of the minimum of several functions, each
  a product of factors (``lattice_changes``). Its sign is a function of the signs of the factors
  alone, so it changes at zeros of factors alone;
- the share of the band on which several functions are negative (``transparent_share``).

Frequencies are fractions of the band's high end, so that the band ends at 1. All are doubles, each
known to a relative tolerance; where two are so close that their order is not known, the set is not
decided. Begin with ``lattice_changes``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.curves import FamilyLattice, SignedProduct
from haptisym.verbs.sweep.delayterms import Family


@dataclass(frozen=True)
class SignChanges:
    """The sign changes of a function on the band for many sets.

    ``sets`` : the index of the set of each. ``omega`` : the frequencies, as fractions of the band's
    high end, in ascending order for each set. ``first`` : for each set the sign at the low end.
    """

    sets: Array
    omega: Array
    first: Array


@dataclass(frozen=True)
class OrderedChanges:
    """The sign changes of several functions, in rows: for each set in ascending order behind a row
    for its low end.

    ``sets``, ``omega`` : as of ``SignChanges``. ``kinds`` : the index of the function that changes
    its sign, -1 for a low end. ``signs``: functions x rows, of each function from that row on up to
    the next.
    """

    sets: Array
    omega: Array
    kinds: Array
    signs: Array

    @classmethod
    def of(cls, changes: list[SignChanges], low: float, count: int) -> OrderedChanges:
        """Those of some functions for ``count`` sets, from the band's low end on, a fraction of its
        high end."""
        every = np.arange(count)
        sets = np.concatenate([every, *(x.sets for x in changes)])
        omega = np.concatenate([np.full(count, low), *(x.omega for x in changes)])
        lengths = [count, *(len(x.sets) for x in changes)]
        kinds = np.repeat(np.arange(-1, len(changes)), lengths)
        # By set, then by frequency; at the low end itself its own row, of kind -1, comes before
        # zeros there.
        order = np.lexsort((kinds, omega, sets))
        sets, omega, kinds = sets[order], omega[order], kinds[order]
        # From where each set's rows begin: the sign of a function is its first one, changed once
        # for each of its zeros that was passed.
        start = np.searchsorted(sets, every)
        signs = np.empty((len(changes), len(sets)), dtype=np.int8)
        for kind, x in enumerate(changes):
            passed = np.cumsum(kinds == kind)
            is_odd = (passed - passed[start][sets]) % 2 == 1
            signs[kind] = np.where(is_odd, -x.first[sets], x.first[sets])
        return cls(sets, omega, kinds, signs)

    @property
    def is_low_end(self) -> Array:
        """Which rows are those of low ends."""
        is_low_end: Array = self.kinds < 0
        return is_low_end


def lattice_changes(
    lattice: FamilyLattice, changes: Mapping[Family, SignChanges], low: float, near: float
) -> tuple[SignChanges, Array]:
    """The sign changes of a lattice, from those of each of its factors, and for which sets they are
    proven.

    They are not where two zeros lie so near each other (relatively, ``near``) that their order is
    not known, nor where the lattice is 0 between equal signs, as where several of its functions
    have one zero, nor where a function that is 0 at omega = 0 decides there.
    ``low`` : the band's low end, a fraction of its high end.
    """
    listed = list(changes.values())
    count = len(listed[0].first)
    rows = OrderedChanges.of(listed, low, count)
    signs = dict(zip(changes, rows.signs, strict=True))
    positive = _is_positive(lattice, signs)
    is_change = np.zeros(len(positive), dtype=bool)
    is_change[1:] = positive[1:] != positive[:-1]
    is_change &= ~rows.is_low_end
    decided = np.ones(count, dtype=bool)
    is_close = np.diff(rows.omega) <= near * rows.omega[1:]
    are_zeros = ~rows.is_low_end[1:] & ~rows.is_low_end[:-1]
    decided[rows.sets[1:][is_close & are_zeros]] = False
    for kind, f in enumerate(signs):
        is_zero_of_f = rows.kinds == kind
        there = {g: row[is_zero_of_f] for g, row in signs.items()}
        there[f] = np.zeros(is_zero_of_f.sum(), np.int8)
        # With f = 0 and the signs of the others there, the lattice is >= 0 or < 0, and > 0 or not:
        # so it is 0 where it is >= 0, but not > 0. Its sign must change at such a place, and there
        # alone: 0 between equal signs is a tangency, and no continuous function changes its sign
        # without a 0, so that the order of the zeros is not known then. Such a set is left.
        vanishes = _is_positive(lattice, there, or_0=True) & ~_is_positive(lattice, there)
        sets = rows.sets[is_zero_of_f]
        decided[sets[vanishes != is_change[is_zero_of_f]]] = False
    at_low = {f: row[rows.is_low_end] for f, row in signs.items()}
    # What is 0 at omega = 0 counts there as one sign and as the other: where both give the same,
    # the sign of the lattice does not depend on it.
    with_1 = _is_positive(lattice, at_low, at_0=1)
    with_minus_1 = _is_positive(lattice, at_low, at_0=-1)
    decided &= with_1 == with_minus_1
    first = np.where(positive[rows.is_low_end], 1, -1)
    return SignChanges(rows.sets[is_change], rows.omega[is_change], first), decided


def _is_positive(
    lattice: FamilyLattice,
    signs: Mapping[Family, Array],
    *,
    or_0: bool = False,
    at_0: int | None = None,
) -> Any:
    """Where the lattice is positive; with ``or_0``, where it is positive or 0. ``signs`` : of its
    factors, in any number of places.

    ``at_0`` : the sign that functions have which vanish at omega = 0; None for places elsewhere.
    """
    places = np.shape(next(iter(signs.values())))

    def is_positive(x: SignedProduct) -> Any:
        has_given_sign = at_0 is not None and x.vanishes_at_0
        sign = np.full(places, at_0 if has_given_sign else x.sign, dtype=np.int8)
        for f in () if has_given_sign else x.factors:
            sign = sign * signs[f]
        return sign >= 0 if or_0 else sign > 0

    positive = ([is_positive(x) for x in term] for term in lattice.terms)
    return np.logical_or.reduce([np.logical_and.reduce(x) for x in positive])


def transparent_share(excesses: list[SignChanges], low: float) -> Array:
    """The share of the band, from ``low`` to 1, on which all are negative, for each set."""
    count = len(excesses[0].first)
    rows = OrderedChanges.of(excesses, low, count)
    following = np.append(rows.omega[1:], 1.0)
    following[:-1][rows.is_low_end[1:]] = 1.0
    is_transparent = (rows.signs < 0).all(axis=0)
    lengths = (following - rows.omega) * is_transparent
    return np.bincount(rows.sets, weights=lengths, minlength=count) / (1.0 - low)
