"""Requirements in a JND polygon where each edge is a parabola in frequency: which values do, and where they bind, by hand."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

import pytest

import haptisym as hs
from haptisym.verbs.require.feasible import End, Kind

Corner = tuple[Fraction, Fraction]
SHAPES = [
    [(1, 0), (0, 1), (-1, 0), (0, -1)], [(2, 0), (0, 1), (-1, 0), (0, -2)], [(1, 1), (-1, 1), (-1, -1), (1, -1)],
    [(2, 1), (-1, 2), (-1, -1), (1, -1)], [(1, -1), (1, 2), (-2, 0)], [(2, 0), (1, 1), (-1, 1), (-2, 0), (0, -1)],
]  # fmt: skip


def edges(corners: list[Corner]) -> list[Corner]:
    """p x + q y = 1 along each."""
    found = []
    for (a, b), (c, d) in zip(corners, [*corners[1:], corners[0]], strict=True):
        size = a * d - b * c
        found.append(((d - b) / size, (a - c) / size))
    return found


def _extreme(rows: list[tuple[Fraction, Fraction, Fraction]], band: tuple[int, int], sign: int) -> Any:
    """The least (sign 1) or the largest (-1) of parabolas u + v w + x w^2 on a band, and where it is."""
    values: dict[Fraction, Fraction] = {}
    for u, v, x in rows:
        places = {Fraction(w) for w in band} | ({-v / (2 * x)} if x and band[0] < -v / (2 * x) < band[1] else set())
        for w in places:
            value = sign * (u + v * w + x * w**2)
            values[w] = min(value, values.get(w, value))
    least = min(values.values(), default=None)
    return (None, set()) if least is None else (sign * least, {w for w, y in values.items() if y == least})


def _is(end: End, value: Fraction, places: set[Fraction], band: tuple[int, int]) -> None:
    assert end.closed
    assert end.value is not None
    low, high = end.value.bounds(80)
    assert low <= value <= high
    assert end.bindings
    for binding in end.bindings:
        assert binding.omega is not None
        at = float(binding.omega)
        assert any(abs(at - float(w)) < 1e-12 for w in places)
        kind = Kind.START if at == band[0] else Kind.EDGE if at == band[1] else Kind.TOUCH
        assert binding.kind is kind


def _hold(pick: Random) -> bool:
    scale = Fraction(1, pick.choice([2, 3, 5]))
    corners = [(scale * x, scale * y) for x, y in pick.choice(SHAPES)]
    d, c = Fraction(pick.randint(-3, 3), 40), Fraction(pick.randint(-4, 4), 100)
    band = (pick.choice([0, 0, 1, 2]), pick.randint(3, 7))
    gain = hs.effects.series("1 + t + c*s^2 + d*s", parameters={"t": "1/10", "c": str(c), "d": str(d)})
    region = {"shape": "polygon", "corners": [[str(x), str(y)] for x, y in corners]}
    scene = hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), band, region)
    found = hs.require(scene, "t", (-9, 9))
    own = edges(corners)  # of x = t - c w^2 and y = d w
    tops = [(1 / p, -q * d / p, c) for p, q in own if p > 0]
    bottoms = [(1 / p, -q * d / p, c) for p, q in own if p < 0]
    kept = all(q * d * w <= 1 for p, q in own if p == 0 for w in band)
    (high, highest), (low, lowest) = _extreme(tops, band, 1), _extreme(bottoms, band, -1)
    assert found.undecided == ()
    if not kept or low > high:
        assert found.feasible == ()
        return False
    [span] = found.feasible
    if low == high:  # one value alone, at which both bind
        lowest = highest = lowest | highest
    _is(span.low, low, lowest, band)
    _is(span.high, high, highest, band)
    return True


@pytest.mark.few("10")
@pytest.mark.parametrize("seed", range(11))
def test_values_in_a_polygon_are_those_between_the_extremes_of_parabolas(seed: int) -> None:
    pick = Random(seed)
    count = 8 if seed < 10 else 2
    assert sum(_hold(pick) for _ in range(count)) > count // 8
