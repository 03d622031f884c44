"""Values that are told in floats: an evaluation at each of them says the same."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import pytest
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.criteria import noticed
from haptisym.verbs.require import floatcells
from haptisym.verbs.require.floatcells import FloatCells, Told, ladder


def told(name: str, path: str, low: float, high: float) -> tuple[FloatCells, list[Told]]:
    scene = hs.load_scene(name)
    free = scene.knobs[path]
    cells = FloatCells(scene, free, noticed(scene.threshold), abs(float(free.value)))
    return cells, cells.told(low, high)


def is_transparent(cells: FloatCells, value: float) -> bool:
    e = hs.evaluate(cells.free.put(cells.scene, Rational(value)))
    return [(x.low, x.high) for x in e.transparent] == [(e.chart.points[0], e.chart.points[-1])]


@pytest.mark.few(3)
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


BROKEN = hs.Scene(
    environments.kelvin_voigt(12, "0.27"),
    (
        effects.position_force_teleoperator("0.55", "0.15", 25, 720, "0.48 ms"),
        effects.second_order_lowpass(2800, "0.86"),
    ),
    (0, 21),
    hs.Threshold.of("0.1"),
)
AT_0 = hs.Scene(environments.maxwell(300, 15), (effects.delay("5 ms"), effects.compliance(12000, 25)), (0, 20))


def test_broken_values_are_told_by_few_cells_where_what_is_left_of_models_outweighs_their_slopes() -> None:
    free = BROKEN.knobs["effects.second-order-lowpass.omega_n"]
    cells = FloatCells(BROKEN, free, noticed(BROKEN.threshold), 2800.0)
    assert all(x.kept is False for x in cells.told(0.0, 2e6))


def test_a_value_at_which_nothing_is_known_does_not_cost_the_others_their_cells(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = list[int]()

    class Noted(floatcells._Search):
        def go(self, ends: Sequence[float]) -> None:
            super().go(ends)
            looked.append(self.looked)

    monkeypatch.setattr(floatcells, "_Search", Noted)
    cells = FloatCells(AT_0, AT_0.knobs["environment.b"], noticed(AT_0.threshold), 15.0)
    first, *others = cells.told(0.0, 8192.0)
    assert (first.low, first.kept) == (0.0, None)
    assert first.high < 1e-4
    assert others
    assert all(x.kept is not None or x.high < 1.01 * x.low for x in others)
    assert looked[0] < 8000


def test_near_a_resonance_what_holds_for_any_environment_tells() -> None:
    hold = hs.Scene(environments.mass_spring_damper(1, "0.01", 100), (effects.zero_order_hold("10 ms"),), (0, 15))
    cells = FloatCells(hold, hold.knobs["environment.m"], noticed(hs.Threshold.of("0.1")), 1.0)
    assert [x.kept for x in cells.told(0.01, 1e6)] == [True]
    larger = hs.Scene(hold.environment, hold.effects, (0, 25))
    assert all(x.kept is not True for x in FloatCells(larger, cells.free, cells.criteria, 1.0).told(0.17, 0.9))


def test_of_a_threshold_nothing_is_told_in_floats() -> None:
    assert told("delayed-spring", "evaluation.jnd", 0.0, 1.0)[1] == [Told(0.0, 1.0, None)]


def test_the_first_cells_are_powers_of_2_of_a_usual_size_on_both_sides_of_0() -> None:
    found = ladder(-3.0, 5.0, 1.0)
    assert (found[0], found[-1]) == (-3.0, 5.0)
    assert {-2.0, -1.0, 0.0, 0.5, 4.0} <= set(found)
    assert found == sorted(found)
