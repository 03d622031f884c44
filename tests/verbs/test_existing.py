"""Values at which a scene does not exist are in no set of values: an environment that is zero leaves nothing to feel."""

from __future__ import annotations

from typing import Any

import pytest
from sympy import sqrt

import haptisym as hs
from haptisym.verbs.require.existing import missing


def damper(formula: str, *effects: hs.Effect) -> hs.Scene:
    return hs.Scene(hs.environments.expression(formula, parameters={"q": "3/2"}), effects, (0, 10))


def ends(r: Any) -> list[tuple[Any, ...]]:
    return [
        tuple(y for e in (x.low, x.high) for y in (None if e.value is None else float(e.value), e.closed))
        for x in r.feasible
    ]


LATE, LAGGING = hs.effects.delay("1 ms"), hs.effects.first_order_lag(100)


@pytest.mark.parametrize("that", ["passive", "stable"])
@pytest.mark.parametrize("effect", [LATE, LAGGING])
def test_no_damper_at_all_is_no_scene(effect: hs.Effect, that: str) -> None:
    r = hs.require(damper("q*s", effect, hs.effects.shunt(b=5)), "q", (-2, 2), that=that, hand="postural-arm")
    assert (ends(r), r.certified) == ([(-2, True, 0, False), (0, False, 2, True)], True)


@pytest.mark.parametrize("effect", [hs.effects.delay("1 us"), hs.effects.first_order_lag(10000)])
def test_a_value_that_takes_all_is_left_out_wherever_it_lies(effect: hs.Effect) -> None:
    """In series the ratios do not depend on q; |G - 1| is 1e-5 and 1e-3 at most."""
    assert ends(hs.require(damper("q*s - s", effect), "q", (0, 2))) == [(0, True, 1, False), (1, False, 2, True)]
    assert ends(hs.require(damper("q*s - s", effect), "q", (1, 2))) == [(1, False, 2, True)]
    assert ends(hs.require(damper("q*s - s", effect), "q", (0, 1))) == [(0, True, 1, False)]


def test_values_that_are_missing_may_be_irrational_or_those_that_formulas_divide_by() -> None:
    root = damper("q^2*s - 2*s", LAGGING)
    assert [float(x) for x in missing(root, root.knobs["q"])] == [float(sqrt(2)), -float(sqrt(2))]
    r = hs.require(root, "q", (-1, 2), that="passive")
    assert ends(r) == [(pytest.approx(2**0.5, rel=1e-15), False, 2, True)]
    pole = damper("s + s/(q - 1)", LAGGING)
    assert sorted(map(float, missing(pole, pole.knobs["q"]))) == [0, 1]
    assert missing(pole, pole.knobs["c"]) == missing(pole, pole.knobs["omega_c"]) == []
