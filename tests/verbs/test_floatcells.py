"""Values that are told in floats: an evaluation at each of them says the same."""

from __future__ import annotations

from itertools import pairwise

import pytest
from sympy import Rational

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.verbs.require.floatcells import FloatCells, Told, ladder


def told(name: str, path: str, low: float, high: float) -> tuple[FloatCells, list[Told]]:
    scene = hs.load_scene(name)
    free = scene.knobs[path]
    cells = FloatCells(scene, free, noticed(scene.threshold), abs(float(free.value)))
    return cells, cells.told(low, high)


def is_transparent(cells: FloatCells, value: float) -> bool:
    e = hs.evaluate(cells.free.put(cells.scene, Rational(value)))
    return [(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]


@pytest.mark.parametrize(
    ("name", "path", "high", "ends"),
    [
        ("four-channel-teleoperation", "environment.b", 1e4, [6.47280, 36.8130]),
        ("four-channel-teleoperation", "effects.teleoperator.tau", 0.05, [0.00576773]),
        ("virtual-wall", "environment.b", 100.0, [14.2773, 35.4501]),
        ("organ-tissue", "effects.communication.tau", 0.05, []),
        ("sampled-wall", "effects.sampling.T", 0.05, []),
    ],
)
def test_all_values_are_told_but_those_next_to_an_end(name: str, path: str, high: float, ends: list[float]) -> None:
    cells, found = told(name, path, 1e-4, high)
    assert (found[0].low, found[-1].high) == (1e-4, high)
    assert all(a.high == b.low for a, b in pairwise(found))
    left = [x for x in found if x.kept is None]
    assert all(any(x.low < end < x.high for x in left) for end in ends)
    assert all(any(x.low <= end <= x.high for end in ends) and x.high < 1.01 * x.low for x in left)
    for x in found:
        if x.kept is not None:
            assert is_transparent(cells, (x.low + x.high) / 2) is x.kept


def test_of_a_threshold_nothing_is_told_in_floats() -> None:
    assert told("delayed-spring", "evaluation.jnd", 0.0, 1.0)[1] == [Told(0.0, 1.0, None)]


def test_the_first_cells_are_powers_of_2_of_a_usual_size_on_both_sides_of_0() -> None:
    found = ladder(-3.0, 5.0, 1.0)
    assert (found[0], found[-1]) == (-3.0, 5.0)
    assert {-2.0, -1.0, 0.0, 0.5, 4.0} <= set(found)
    assert found == sorted(found)
