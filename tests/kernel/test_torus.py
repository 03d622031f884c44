"""How small a polynomial of several exp(-s tau) becomes: against samples, and against one unit delay, where zeros are counted."""

from __future__ import annotations

from itertools import product
from random import Random

import numpy as np
import pytest
from sympy import Expr, Integer, Rational, exp

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.rootcount import RootChain, count_roots, floor_of
from haptisym.kernel.symbols import s
from haptisym.kernel.torus import least_on_torus

Group = dict[tuple[int, ...], Expr]


def drawn(seed: int, units: int, most: int) -> Group:
    pick = Random(seed)
    group: Group = {(0,) * units: Rational(pick.randint(4, 30), 3)}
    for _ in range(pick.randint(2, 4)):
        group[tuple(pick.randint(0, most) for _ in range(units))] = Rational(
            pick.randint(-9, 9) or 1, pick.randint(1, 4)
        )
    return group


def sampled(group: Group, count: int) -> float:
    """The least modulus on a grid of angles."""
    angles = np.exp(2j * np.pi * np.arange(count) / count)
    grids = np.meshgrid(*[angles] * len(next(iter(group))), indexing="ij")
    total = sum(
        float(c) * np.prod([z**n for z, n in zip(grids, turns, strict=True)], axis=0) for turns, c in group.items()
    )
    return float(np.abs(total).min())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_a_least_modulus_is_below_every_sample_and_not_much_below_the_least_of_them(seed: int) -> None:
    units = 2 + seed % 2
    group = drawn(seed, units, 3 if units == 2 else 1)
    least, met = least_on_torus(group), sampled(group, 400 if units == 2 else 80)
    whole = float(sum(abs(c) for c in group.values()))
    if least is not None:
        assert 0.2 * met < least <= met
    else:
        assert met < 0.05 * whole


def test_one_that_vanishes_somewhere_has_no_least_modulus_above_0() -> None:
    for group in (
        {(0, 0): 3, (1, 0): 1, (0, 1): 2},
        {(0, 0): 1, (1, 1): -1},
        {(0, 0): 2, (1, 0): 1, (0, 1): -2, (1, 1): 1},
    ):
        assert least_on_torus({turns: Integer(c) for turns, c in group.items()}) is None


@pytest.mark.parametrize("seed", range(3))
def test_of_one_term_for_each_phase_the_least_is_what_the_largest_exceeds_all_others_by(seed: int) -> None:
    """|c_0 + c_1 z_1 + c_2 z_2|, whatever the signs; what is found is at least half of it, and is measured in the same unit as the c."""
    pick = Random(seed)
    for _ in range(6):
        c = [Rational(pick.choice([-1, 1]) * pick.randint(1, 9), 4) for _ in range(3)]
        c[seed] *= 4
        group: Group = dict(zip(((0, 0), (1, 0), (0, 1)), c, strict=True))
        true, least = 2 * max(map(abs, c)) - sum(map(abs, c)), least_on_torus(group)
        if true <= 0:
            assert least is None
            continue
        assert least is not None
        assert true / 2 <= least <= true
        unit = Rational(2) ** pick.choice([-30, 40])
        assert least_on_torus({turns: unit * x for turns, x in group.items()}) == unit * least


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_what_several_delays_tell_is_what_the_zeros_of_one_tell(seed: int) -> None:
    """With a ratio of two whole numbers all are powers of one unit, whose zeros are counted."""
    group = drawn(seed, 2, 2)
    ring = Ring.of([exp(-s), exp(-s * Rational(1, 1000) * 1234)])
    several = floor_of(group, ring) if least_on_torus(group) is not None else None
    if several is None:
        return
    for a, b in product((1, 2, 3), (1, 3, 4)):
        alike: Group = {}
        for (m, n), c in group.items():
            alike[(a * m + b * n,)] = alike.get((a * m + b * n,), Integer(0)) + c
        row = [float(alike.get((k,), 0)) for k in range(max(k for (k,) in alike) + 1)]
        inside = np.abs(np.roots(row[::-1])).min(initial=2) < 1
        assert isinstance(several, RootChain) == inside, (group, a, b)
        assert not isinstance(several, RootChain) or several is RootChain.RIGHT


def test_roots_with_delays_that_are_no_multiples_of_one_are_counted_where_these_cannot_make_a_chain() -> None:
    """2 s (1 + (z1 + z2 + z1 z2)/4) + 1, z1 = exp(-s), z2 = exp(-1.0313 s): no sum of one, as these come as a product too."""
    z1, z2 = exp(-s), exp(-s * Rational(10313, 10000))
    ring = Ring.of([z1, z2])

    def roots(expression: Expr) -> object:
        found = count_roots(ring.convert(expression).numerator, ring)
        return found.chain or found.number

    product_of_two = (5 + z1) * (3 - 2 * z2) - 1
    assert roots(s * product_of_two + 1) == 0
    assert roots(s * product_of_two - 1) == 1
    assert roots(s * ((1 + 5 * z1) * (3 - 2 * z2) - 1) + 1) is RootChain.RIGHT
