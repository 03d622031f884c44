"""Where a lattice of functions changes its sign, for many sets at once: against its values, one by one."""

from __future__ import annotations

from itertools import pairwise
from math import prod
from random import Random
from typing import Any

import numpy as np
import pytest

from haptisym.verbs.sweep.combined import Found, changes
from haptisym.verbs.sweep.curves import FamilyLattice, SignedProduct

LOW, NEAR = 0.5, 0.01


def value(lattice: FamilyLattice, signs: dict[Any, int], at_0: int | None = None) -> int:
    """The largest of its terms, each the least of its functions, as a sign."""

    def of(x: SignedProduct) -> int:
        return at_0 if at_0 is not None and x.begins_at_0 else x.sign * prod(signs[f] for f in x.factors)

    return max(min(map(of, term)) for term in lattice.terms)


def expected(
    lattice: FamilyLattice, zeros: dict[Any, list[float]], first: dict[Any, int]
) -> tuple[list[float], int, bool]:
    """Where it changes, its sign at the low end, and whether that is certain."""
    signs, places, found = dict(first), sorted(x for own in zeros.values() for x in own), []
    certain = all(b - a > NEAR * b for a, b in pairwise(places))
    certain &= (value(lattice, signs, 1) > 0) is (value(lattice, signs, -1) > 0)
    start = 1 if value(lattice, signs) > 0 else -1
    for x in places:
        [own] = [f for f, row in zeros.items() if x in row][:1]
        before = value(lattice, signs) > 0
        at = value(lattice, {**signs, own: 0})
        signs[own] = -signs[own]
        changed = (value(lattice, signs) > 0) is not before
        certain &= (at == 0) is changed
        found += [x] * changed
    return found, start, certain


@pytest.mark.parametrize("seed", range(12))
def test_a_lattice_changes_its_sign_where_its_values_do_and_says_where_that_is_not_known(seed: int) -> None:
    """Zeros far from each other; next to each other; and functions that are 0 at omega = 0, beside which others decide or not."""
    draw, count, names = Random(seed), 40, "pqr"
    late = bool(seed % 3)

    def product() -> SignedProduct:
        factors: tuple[Any, ...] = tuple(draw.sample(names, draw.randint(1, 2)))
        return SignedProduct(draw.choice([-1, 1]), factors, late and draw.random() < 0.3)

    lattice = FamilyLattice(
        tuple(tuple(product() for _ in range(draw.randint(1, 3))) for _ in range(draw.randint(1, 3)))
    )
    rows, told = [], []
    for _ in range(count):
        places = [n / 2 for n in draw.sample(range(2, 30), 6)]
        if draw.random() < 0.3:
            places[1] = places[0] * (1 + draw.choice([0.004, 0.02]))
        if draw.random() < 0.3:
            places[2] = LOW * 1.004  # the low end itself is no zero
        zeros: dict[Any, list[float]] = {f: [] for f in names}
        for x in places:
            zeros[draw.choice(names)].append(x)
        rows.append(zeros)
        told.append({f: draw.choice([-1, 1]) for f in names})
    given: dict[Any, Found] = {}
    for f in names:
        own = [(i, x) for i, zeros in enumerate(rows) for x in sorted(zeros[f])]
        sets, omega = (np.array([x[k] for x in own], dtype=kind) for k, kind in ((0, int), (1, float)))
        given[f] = Found(sets, omega, np.array([x[f] for x in told], dtype=np.int8))
    found, certain = changes(lattice, given, LOW, NEAR)
    for i, (zeros, first) in enumerate(zip(rows, told, strict=True)):
        places, start, sure = expected(lattice, zeros, first)
        assert bool(certain[i]) is sure
        assert found.first[i] == start
        if sure:
            assert found.omega[found.sets == i].tolist() == places
    assert seed or 5 < certain.sum() < 35  # both kinds are there


def test_of_some_sets_what_was_found_keeps_its_order_under_new_numbers() -> None:
    found = Found(np.array([0, 0, 1, 3]), np.array([1.0, 2.0, 1.5, 4.0]), np.array([1, -1, 1, -1], dtype=np.int8))
    some = found.of(np.array([0, 3]), 4)
    assert (some.sets.tolist(), some.omega.tolist(), some.first.tolist()) == ([0, 0, 1], [1.0, 2.0, 4.0], [1, -1])
