"""Values that are told in floats: an evaluation at each of them says the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.criteria import noticed
from haptisym.programs.taylormodels import Model
from haptisym.verbs.require import floatcells
from haptisym.verbs.require.energyterms import variables
from haptisym.verbs.require.floatcells import FloatCells, Told, _in_parts, _outside, _partition, _union, ladder


def told(name: str, path: str, low: float, high: float) -> tuple[FloatCells, list[Told]]:
    scene = hs.load_scene(name)
    free = scene.knobs[path]
    cells = FloatCells(scene, free, noticed(scene.threshold), abs(float(free.value)))
    return cells, cells.told(low, high)


class _Known(FloatCells):
    """Of given excesses."""

    def __init__(self, excesses: list[Any], scale: float) -> None:
        object.__setattr__(self, "scale", scale)
        self.__dict__["_excesses"] = tuple(excesses)


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


@dataclass(frozen=True)
class Parabola:
    """a q + b x - c x^2 + d over shares x of the band and values q: an excess of which all is known."""

    a: Fraction
    b: Fraction
    c: Fraction
    d: Fraction
    is_zero: bool = False

    def model(self, cells: Any, slopes: int) -> Model:
        assert slopes == 0
        x, q = variables(cells)
        return q.times(float(self.a)) + x.times(float(self.b)) - (x * x).times(float(self.c)) + x.number(float(self.d))

    def most(self, q: Fraction) -> Fraction:
        """The largest of all x from 0 to 1."""
        places = [Fraction(0), Fraction(1), *([self.b / (2 * self.c)] if 0 < self.b < 2 * self.c else [])]
        return max(self.a * q + self.b * x - self.c * x**2 + self.d for x in places)


@pytest.mark.parametrize("seed", range(6))
def test_values_are_told_as_the_largest_excess_over_the_band_says_and_little_stays_open(seed: int) -> None:
    """One to three parabolas over x, which values move up or down; ranges on one side of 0, on both, and from 0 on."""
    pick = Random(seed)

    def some() -> Fraction:
        return Fraction(pick.randint(-12, 12), 8)

    for _ in range(4):
        scale = Fraction(2) ** pick.randint(-3, 3)
        own = [
            Parabola(pick.choice([1, -1, 2]) / scale, some(), Fraction(pick.randint(0, 16), 8), some())
            for _ in range(pick.randint(1, 3))
        ]
        low, high = (x * scale for x in pick.choice([(-3, 3), (0, 5), (-4, 0), (1, 9), (-8, -2)]))
        cells = _Known([(x, None) for x in own], float(scale))
        found = cells.told(float(low), float(high))
        assert (found[0].low, found[-1].high) == (low, high)
        assert all(a.high == b.low for a, b in pairwise(found))
        stays = [-(x.most(Fraction(0))) / x.a for x in own]  # where the largest of one is 0
        for x in found:
            a, b = Fraction(x.low), Fraction(x.high)
            for q in (a, (a + b) / 2, b):
                top = max(y.most(q) for y in own)
                assert x.kept is None or (top <= 0 if x.kept else top > 0 or q in (a, b))
            if x.kept is None:
                near = min(float(scale) * 2e-3, 1e9)
                assert any(float(a) - near <= end <= float(b) + near for end in stays)
                size = max(abs(x.low), abs(x.high), float(scale) * 1e-3)
                assert x.high - x.low <= 3e-3 * len(own) * size


@pytest.mark.parametrize("seed", range(6))
def test_ranges_are_put_together_cut_and_set_against_each_other_as_on_a_line_of_points(seed: int) -> None:
    pick = Random(seed)
    rows = [tuple(sorted(pick.sample(range(30), 2))) for _ in range(pick.randint(0, 5))]
    left = [tuple(sorted(pick.sample(range(30), 2))) for _ in range(pick.randint(0, 5))]
    broken = {n for a, b in rows for n in range(a, b)}  # from n to n + 1
    union = _union([(float(a), float(b)) for a, b in rows])
    assert {n for a, b in union for n in range(int(a), int(b))} == broken
    assert all(a[1] < b[0] for a, b in pairwise(union))
    cells = np.array([[[0.0, 1.0], sorted(pick.sample(range(30), 2))] for _ in range(20)], float)
    kept = _outside(cells, union)
    assert [x for x in cells.tolist() if not set(range(int(x[1][0]), int(x[1][1]))) <= broken] == kept.tolist()
    told = [*_partition(0.0, 30.0, left, rows)]
    assert (told[0].low, told[-1].high) == (0, 30)
    doubtful = {n for a, b in left for n in range(a, b)}
    for x in told:
        own = set(range(int(x.low), int(x.high)))
        assert x.kept is (False if own <= broken else None if own <= doubtful else True)
        assert x.kept is not True or not own & (broken | doubtful)
    wanted = np.array([[pick.random() < 0.5, pick.random() < 0.5] for _ in cells])
    places = cells + np.array([0.0, pick.choice([-40, -15, 0, 5])])[:, None]
    for side, parts in ((0, 2), (1, 4), (1, 2)):
        pieces, flags = _in_parts(places, wanted, side, parts)
        assert len(pieces) == len(places) + (parts - 1) * wanted[:, side].sum() == len(flags)
        areas = (places[..., 1] - places[..., 0]).prod(-1), (pieces[..., 1] - pieces[..., 0]).prod(-1)
        assert areas[1].sum() == pytest.approx(areas[0].sum())
        assert (areas[1] > 0).all()
        for cell, flag in zip(places, wanted, strict=True):
            inside = (pieces[:, :, 0] >= cell[:, 0]).all(-1) & (pieces[:, :, 1] <= cell[:, 1]).all(-1)
            assert inside.sum() >= (parts if flag[side] else 1)
        for a, b in pieces[len(places) - wanted[:, side].sum() :, side]:
            assert side == 0 or not 0 < 40 * a < b
            assert side == 0 or not a < 40 * b < 0


@pytest.mark.parametrize(("low", "high"), [(-3.0, 5.0), (0.0, 7.0), (-9.0, 0.0), (1.5, 1e4), (-1e3, -1e-9)])
def test_first_cells_lie_between_all_powers_of_2_of_a_usual_size(low: float, high: float) -> None:
    """Down to 2^-20 of it where they reach 0, and to 2^-60 where they do not."""
    for scale in (1.0, 3.0):
        found = ladder(low, high, scale)
        least = 2.0 ** (-60 if low * high > 0 else -20)
        marks = {sign * scale * 2.0**n for n in range(-60, 60) for sign in (1, -1) if 2.0**n >= least} | {0.0}
        assert found == sorted({low, high} | {x for x in marks if low < x < high})
