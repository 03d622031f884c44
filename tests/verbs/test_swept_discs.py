"""Discs between the lines hold what they must, operation by operation: against geometry with a hundred digits, sizes far apart."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import numpy as np
import pytest

from haptisym.model.jnd import Part
from haptisym.model.jndtables import read_threshold
from haptisym.model.slope import Slope
from haptisym.verbs.measured.regions import joint_distance, part_distance
from haptisym.verbs.measured.spread import spread
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


@pytest.mark.slow
def test_the_disc_around_what_two_discs_have_in_common_holds_all_of_it() -> None:
    chance = random.Random(11)
    cases = [some(chance) for _ in range(300)]
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
    assert tight > 200
    assert (found.radius <= np.minimum(r, q)).all()


MOVING = [
    {"shape": "ellipse", "real": "0.08 + omega/250", "imag": 0.1, "tilt": "omega/20"},
    {"shape": "ellipse", "real": 2, "imag": "0.01*omega", "tilt": "1 - omega^2/10000000"},
    {"shape": "ellipse", "real": "1/(1 + omega)", "imag": "1/(1 + omega)"},
    {"shape": "diamond", "real": "0.1 + omega/1000", "imag": "3/(2 + omega^2)"},
    {"shape": "polygon", "corners": [[0.1, 0], ["0.02 + omega/1000", 0.1], [-0.1, 0.05], [0, "-0.1 - omega^2/2000"]]},
    {"real": {"higher": "0.08 + omega/99", "lower": "0.12 + omega^2/400"}, "imag": "0.08 + 0.004*omega"},
]


@pytest.mark.parametrize("jnd", MOVING, ids=lambda x: x.get("shape", "sides"))
def test_no_border_moves_farther_in_a_cell_than_is_said(jnd: dict[str, Any]) -> None:
    """The distance of random changes, of both parts and of each, at places all over random cells and in their middles."""
    c, draw = read_threshold(jnd), np.random.default_rng(5)
    low = draw.uniform(0.1, 14, 400)
    high = low * (1 + 10 ** draw.uniform(-9, -0.7, 400))
    middle, x, y = (low + high) / 2, *(10 ** draw.uniform(-3, 1, 400) * draw.choice([-1, 1], 400) for _ in range(2))
    env, size = draw.uniform(-1, 1, 400), (np.ones(400), np.ones(400))
    most = spread(c, low, high, np.ones(400)) + 1e-13 * (1 + np.abs(x) + np.abs(y))
    for share in (0, 0.1, 0.4, 0.8, 1):
        at = low + share * (high - low)
        for part in Part:
            here, there = (part_distance(c, part, w, x, env, size) for w in (middle, at))
            assert (np.abs(here - there) <= most).all()
        both = [joint_distance(c, w, x, y) for w in (middle, at)]
        if both[0] is not None:
            assert (np.abs(both[0] - both[1]) <= most).all()
    assert (most[high - low < 1e-6 * low] < 1e-4).all()


@pytest.mark.parametrize("relative", [False, True])
def test_grown_discs_are_no_smaller_than_the_bound_says(relative: bool) -> None:  # noqa: FBT001
    chance = random.Random(12)
    for _ in range(500):
        size, radius, apart = (10 ** chance.uniform(-8, 8) for _ in range(3))
        bound = 10 ** chance.uniform(-8, 8) if not relative else 10 ** chance.uniform(-12, 2.5) / apart
        found = MP.mpf(float(Slope(bound, relative, "").grown(np.float64(size), np.float64(radius), np.float64(apart))))
        size, radius, way = MP.mpf(size), MP.mpf(radius), MP.mpf(bound) * MP.mpf(apart)
        assert found >= radius + (size + radius) * MP.expm1(way) if relative else found >= radius + way
