"""How many crossings an enclosure speaks of: counted one by one for sets of values drawn from random boxes."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from marks import spread
from sympy import Rational

import haptisym as hs
from haptisym import effects, environments
from haptisym.verbs.tolerances.entry import tolerances
from haptisym.verbs.tolerances.proofs import Tolerances


def _ranged(draw: random.Random, value: int) -> str:
    return f"{value} +- {draw.choice([1, 2, 5])} %"


def _scene(seed: int) -> hs.Scene:
    draw = random.Random(seed)
    k, b = _ranged(draw, draw.randint(50, 300)), draw.randint(1, 20)
    environment = draw.choice(
        [
            lambda: environments.mass_spring_damper(m=draw.choice([1, 2]), b=b, k=k),
            lambda: environments.maxwell(k=k, b=_ranged(draw, b)),
            lambda: environments.zener(k0=50, k1=k, b1=b),
        ]
    )()
    effect = draw.choice(
        [
            lambda: effects.second_order_lowpass(_ranged(draw, draw.randint(10, 90)), Rational(draw.randint(1, 9), 10)),
            lambda: effects.compliance(k=_ranged(draw, 900), b=draw.randint(1, 9)),
            lambda: effects.shunt(m=Rational(1, 5), b=draw.randint(1, 3), k=_ranged(draw, 5)),
        ]
    )()
    return hs.Scene(environment, (effect,), (0, draw.choice([15, 40])))


def _counts_match(found: Tolerances) -> None:
    ordered = sorted(found.enclosures, key=lambda x: (x.part.value, float(x.low)))
    for x, y in pairwise(ordered):
        assert x.part is not y.part or float(x.high) < float(y.low), "two enclosures of one ratio overlap"
    for one in (found.nominal, *found.samples, *found._corners):
        for x in found.enclosures:
            low, high = float(x.low) * (1 - 1e-12), float(x.high) * (1 + 1e-12)
            inside = [c for c in one.crossings[x.criterion.name] if low <= float(c) <= high]
            assert x.count in (None, len(inside))


@pytest.mark.parametrize("seed", range(4))
def test_an_enclosure_holds_as_many_crossings_as_it_says(seed: int) -> None:
    _counts_match(tolerances(_scene(seed), samples=6))


@pytest.mark.slow
@pytest.mark.parametrize("seed", spread(range(4, 60), 2))
def test_enclosures_of_many_boxes_hold_as_many_crossings_as_they_say(seed: int) -> None:
    _counts_match(tolerances(_scene(seed), samples=10))


def test_two_crossings_close_together_have_enclosures_of_their_own() -> None:
    """A peak that rises little above the threshold: 1 % of 30 rad/s apart; the slack of an end reaches into neither."""
    dip = "1 + 0.4*s/(s^2 + 2*s + 9)"  # r_i of it: a peak of 1/10 at 2.16 and at 4.16 rad/s
    spring = environments.mass_spring_damper(k=100)
    for threshold in ("0.09999", "0.099999", "0.0999999"):
        scene = hs.Scene(
            spring, (effects.series(dip), effects.shunt(m="1e-9 kg +- 1 %")), (0, 15), hs.Threshold(1, threshold)
        )
        _counts_match(tolerances(scene, samples=3))
