"""Discs between the lines hold what they must, operation by operation: against geometry with a hundred digits, sizes far apart."""

from __future__ import annotations

import random

import mpmath
import numpy as np
import pytest

from haptisym.model.slope import Slope
from haptisym.verbs.measured.swept import Discs, _common

MP = mpmath.mp.clone()
MP.dps = 100


def some(chance: random.Random) -> tuple[complex, float, complex, float]:
    """Two discs that meet: sizes up to 10^8 apart, centres far from 0, in every third case hardly more than a point in common."""
    size = 10 ** chance.uniform(-6, 6)
    r, q = (size * 10 ** chance.choice([0, 0, 1e-9, chance.uniform(-8, 0)]) for _ in range(2))
    far = chance.choice([r + q, abs(r - q)]) * (1 - 10 ** chance.uniform(-16, -1)) if chance.random() < 0.6 else None
    apart = chance.uniform(abs(r - q), r + q) if far is None else far
    centre = complex(*(chance.gauss(0, 1) for _ in range(2))) * size * 10 ** chance.uniform(-3, 3)
    return centre, r, centre + apart * np.exp(1j * chance.uniform(0, 7)), q


def lens(a: complex, r: float, b: complex, q: float) -> list[mpmath.mpc]:
    """Points of what two discs have in common that reach farthest: its two corners, and those of its arcs on the line of centres."""
    a, b, r, q = MP.mpc(a), MP.mpc(b), MP.mpf(r), MP.mpf(q)
    d = abs(b - a)
    if d >= r + q:
        return []
    along = (b - a) / d if d else MP.mpc(1)
    if d <= abs(r - q):
        c, t = (a, r) if r < q else (b, q)
        return [c + t * MP.expj(n) for n in range(7)]
    foot = (d + (r - q) * (r + q) / d) / 2
    height = MP.sqrt((r - foot) * (r + foot))
    ends = [a + along * MP.mpc(foot, x) for x in (height, -height)]
    turned = [MP.arg((x - c) / along) for c, x in ((a, ends[0]), (b, ends[0]))]
    arcs = [a + r * along * MP.expj(turned[0] * n / 8) for n in range(-8, 9)]
    rest = [b + q * along * MP.expj(MP.pi + (turned[1] - MP.pi) * n / 8) for n in range(-8, 9)]
    return ends + arcs + rest


def test_the_disc_around_what_two_discs_have_in_common_holds_all_of_it() -> None:
    chance = random.Random(11)
    cases = [some(chance) for _ in range(600)]
    a, r, b, q = (np.array(x) for x in zip(*cases, strict=True))
    found = _common(Discs(a, r), Discs(b, q))
    tight = 0
    for n, case in enumerate(cases):
        centre, radius = MP.mpc(complex(found.centre[n])), MP.mpf(float(found.radius[n]))
        points = lens(*case)
        assert all(abs(x - centre) <= radius * (1 + MP.mpf(10) ** -60) for x in points), case
        if points:
            least = max(abs(x - y) for x in points[:2] for y in points) / 2
            tight += float(radius) <= 1.01 * float(least) + 1e-6 * min(case[1], case[3])
    assert tight > 400
    assert (found.radius <= np.minimum(r, q)).all()


@pytest.mark.parametrize("relative", [False, True])
def test_grown_discs_are_no_smaller_than_the_bound_says(relative: bool) -> None:  # noqa: FBT001
    chance = random.Random(12)
    for _ in range(500):
        size, radius, apart = (10 ** chance.uniform(-8, 8) for _ in range(3))
        bound = 10 ** chance.uniform(-8, 8) if not relative else 10 ** chance.uniform(-12, 2.5) / apart
        found = MP.mpf(float(Slope(bound, relative, "").grown(np.float64(size), np.float64(radius), np.float64(apart))))
        size, radius, way = MP.mpf(size), MP.mpf(radius), MP.mpf(bound) * MP.mpf(apart)
        assert found >= radius + (size + radius) * MP.expm1(way) if relative else found >= radius + way
