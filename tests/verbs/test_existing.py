"""Values at which a scene does not exist are in no set of values: an environment that is zero leaves nothing to feel."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import pytest
from sympy import Integer, Rational, sqrt

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.reals import ExactNumber
from haptisym.verbs.require.existing import missing, without
from haptisym.verbs.require.feasible import Binding, End, Kind, Span


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
    lead = hs.effects.series("1 + s/(q - w)/900", parameters={"q": 1, "w": "5 Hz"})
    turned = hs.Scene(hs.environments.kelvin_voigt(90, 3), (lead,), (0, 5))
    [found] = missing(turned, turned.knobs["q"])
    assert found.digits(30) == "31.4159265358979323846264338328"  # 10 pi


@pytest.mark.parametrize("seed", range(10))
def test_intervals_without_some_values_hold_all_others_as_before(seed: int) -> None:
    """At ends, inside and outside; of intervals that are one value too; ends that stay keep what binds there."""
    pick = Random(seed)
    marks = sorted(pick.sample(range(-9, 10), 6))
    binding = Binding(noticed(hs.Threshold())[0], None, Kind.EDGE)

    def end(x: int | None) -> End:
        return End(None if x is None else ExactNumber(Integer(x)), x is not None and pick.random() < 0.5, (binding,))

    spans = [Span(end(a), end(b)) for a, b in zip(marks[::2], marks[1::2], strict=True)]
    if pick.random() < 0.5:
        spans[0] = Span(End(None), spans[0].high)
        spans[-1] = Span(spans[-1].low, End(None))
    alone = End(ExactNumber(Integer(marks[2])), closed=True)
    if pick.random() < 0.5:
        spans[1] = Span(alone, alone)
    gone = [Rational(x, pick.choice([1, 1, 2])) for x in pick.sample(range(-10, 11), 4)] + [Rational(marks[0])]
    found = without(spans, [ExactNumber(x) for x in gone])

    def holds(listed: Sequence[Span], x: Rational) -> bool:
        return any(
            (s.low.value is None or s.low.value.value < x or (s.low.value.value == x and s.low.closed))  # type: ignore[attr-defined]
            and (s.high.value is None or x < s.high.value.value or (s.high.value.value == x and s.high.closed))  # type: ignore[attr-defined]
            for s in listed
        )

    for n in range(-44, 45):
        x = Rational(n, 4)
        assert holds(found, x) is (holds(spans, x) and x not in gone)
    kept = {y.value.value: y.bindings for s in spans for y in (s.low, s.high) if y.value}  # type: ignore[attr-defined]
    for y in (y for s in found for y in (s.low, s.high) if y.value):
        assert y.bindings == kept.get(y.value.value, ())  # type: ignore[union-attr]
