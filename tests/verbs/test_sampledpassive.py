"""For which values every passive hand may hold a sampled loop: Colgate and Schenkel's bounds by hand, and single verdicts."""

from __future__ import annotations

from math import sqrt
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sympy import Integer, Rational, Symbol

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.verbs.require.sampledpassive import _is_positive


def wall(
    K: Any = 500,
    B: Any = "0.4",
    T: Any = "1 ms",
    b: Any = "0.8",
    *,
    delay: int = 0,
    method: str = "backward-difference",
) -> hs.Scene:
    loop = hs.effects.sampled_loop(T, method, delay=delay)
    return hs.Scene(hs.environments.kelvin_voigt(K, B), (loop, hs.effects.shunt(m="40 g", b=b)))


def ends(r: Any) -> list[tuple[float | None, float | None]]:
    return [tuple(None if e.value is None else float(e.value) for e in (x.low, x.high)) for x in r.feasible]  # type: ignore[misc]


@pytest.mark.parametrize(
    ("free", "span"),
    [
        ("environment.k", (0, 800)), ("environment.b", (0, 0.55)), ("T", (0, 0.0016)), ("effects.shunt.b", (0.65, None)),
    ],
)  # fmt: skip
def test_without_delay_the_device_must_damp_more_than_half_a_sample_of_the_spring_and_the_damper(
    free: str, span: Any
) -> None:
    """b > K T/2 + |B|: K < 800, B < 0.55, T < 1.6 ms, b > 0.65."""
    r = hs.require(wall(), free, that="passive")
    [found] = ends(r)
    assert [x for x in found if x is not None] == pytest.approx([x for x in span if x is not None], rel=1e-15)
    assert (found[1] is None) is (span[1] is None)
    assert r.certified
    [end] = r.ends
    assert not end.closed  # the condition is strict
    assert "exactly for" in str(r)


def test_one_sample_late_the_worst_angle_lies_inside() -> None:
    """K T/2 (1 + 2 x) - B (2 x^2 - 1), x = cos theta: its largest value is u^2/(8 B) + u/2 + B, u = K T."""
    [(_, high)] = ends(hs.require(wall(delay=1), "environment.k", that="passive"))
    assert high == pytest.approx(1000 * (-0.5 + sqrt(0.25 + 0.5)) / 0.625, rel=1e-14)
    r = hs.require(wall(delay=1), "environment.k", that="passive")
    assert [x.kind.value for x in r.ends[0].bindings] == ["tangency"]


def test_where_the_condition_does_not_apply_all_is_left_open_for_that_reason() -> None:
    r = hs.require(wall(method="tustin"), "environment.k", that="passive")  # a damper's pole lies at z = -1
    assert (r.feasible, len(r.undecided)) == ((), 1)
    assert "pole on or outside the unit circle" in str(r)
    lighter = hs.require(wall(), "effects.shunt.m", that="passive")  # less than no mass is none
    assert ends(lighter) == [(0, None)]
    assert len(lighter.undecided) == 1


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 20))])
def test_single_verdicts_agree_with_the_set(seed: int) -> None:
    rng = np.random.default_rng(seed)
    K, B, b = (Rational(int(x), 100) for x in (rng.integers(1, 200_000), rng.integers(0, 200), rng.integers(1, 300)))
    found = wall(K, B, Rational(int(rng.integers(1, 40)), 10_000), b, delay=int(rng.integers(0, 3)))
    free = ("environment.k", "environment.b", "T", "effects.shunt.b")[seed % 4]
    r = hs.require(found, free, that="passive")
    at = found.knobs[free].value
    for value in [at * Rational(int(x), 10) for x in (0, 3, 9, 11, 40)] + [
        Rational(float(e.value)) * x for e in r.ends if e.value for x in (Rational(999, 1000), Rational(1001, 1000))
    ]:
        if value == 0 and free == "T":
            continue
        inside = any(
            (s.low.value is None or float(s.low.value) <= value)
            and (s.high.value is None or value < float(s.high.value))
            for s in r.feasible
        )
        scene = found.with_values({free: value})
        answer = hs.stability(scene).every_passive_hand.passivity.holds
        assert answer is inside or (answer is None and r.undecided)


@pytest.mark.parametrize(("key", "least"), [("m", -0.4), ("k", -3)])
def test_of_two_devices_one_may_lack_what_the_other_has(key: str, least: float) -> None:
    """What is not negative is the mass, and the stiffness, of both together."""
    loop, device = hs.effects.sampled_loop("1 ms", "backward-difference"), hs.effects.shunt(m="400 g", b="0.8", k=3)
    found = hs.Scene(hs.environments.kelvin_voigt(500, "0.4"), (loop, device, hs.effects.shunt(m="10 g", k=1)))
    r = hs.require(found, f"effects.shunt-2.{key}", (Rational(str(least)) * Rational(9, 8), 10), that="passive")
    assert ends(r) == [(least, 10)]
    assert len(r.undecided) == 1


@pytest.mark.few("0")
@pytest.mark.parametrize("seed", range(3))
def test_damping_is_called_left_over_only_where_it_is_at_every_angle(seed: int) -> None:
    """(x - a)^2 + d t between 0 and 1, for t = 2^(1/2): positive for d > 0, not shown to be where it touches 0 or falls below."""
    pick, free = Random(seed), Symbol("t", positive=True)
    value = SquareRoot(ExactNumber(Integer(2)))
    axis, knob = Ring([free]).axis, SimpleNamespace(symbol=free)
    for _ in range(5):
        a, outside = Rational(pick.randint(1, 6), 7), pick.choice([Rational(-1, 3), Rational(9, 7)])
        d = pick.choice([0, Rational(1, 50), Rational(1, 9), -Rational(1, 10**6), -Rational(1, 9)])
        margins = [RealFunction(axis.convert((omega - x) ** 2 + y * free)) for x, y in ((outside, 0), (a, d))]
        assert _is_positive(margins, knob, value) is bool(d > 0)
        assert _is_positive(margins[:1], knob, value)
