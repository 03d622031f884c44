"""Which values are asked about, which conditions are asked of them, and what stands below a line that changes its sign."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, Symbol

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule
from haptisym.verbs.require.existing import without
from haptisym.verbs.require.feasible import End, Span
from haptisym.verbs.require.freeparameter import _upright, asked_of, conditions, domain, each, pieces

Q = Symbol("q", positive=True)
ALLOWED: dict[Rule, Any] = {
    Rule.POSITIVE: lambda x: x > 0,
    Rule.NONNEGATIVE: lambda x: x >= 0,
    Rule.ANY: lambda _: True,
    Rule.FRACTION: lambda x: 0 < x < 1,
}
PLACES = [Rational(n, 8) for n in range(-18, 26)]


@pytest.mark.parametrize("rule", ALLOWED)
def test_the_values_asked_about_are_those_of_the_range_that_the_rule_allows(rule: Rule) -> None:
    """Ranges that end below, at, between and beyond 0 and 1: whatever is in both, with the ends that are in both."""
    free: Any = SimpleNamespace(rule=rule, path="here.q", number=Rational)
    ends = ["-3/2", "-1/2", "0", "1/4", "3/4", "1", "2"]
    for low, high in product(ends, repeat=2):
        given = Rational(low), Rational(high)
        inside = [x for x in PLACES if given[0] <= x <= given[1] and ALLOWED[rule](x)]
        if given[0] >= given[1]:
            with pytest.raises(SceneError, match="must go up"):
                domain(free, (low, high))
            continue
        if len(inside) < 2:
            with pytest.raises(SceneError, match="no value from"):
                domain(free, (low, high))
            continue
        assert members(domain(free, (low, high))) == inside
    assert members(domain(free, None)) == [x for x in PLACES if ALLOWED[rule](x)]
    for wrong in ((1, 2, 3), (1,), ()):
        with pytest.raises(SceneError, match="two ends"):
            domain(free, wrong)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="two ends"):
        domain(free, "12")  # type: ignore[arg-type]


def members(found: Any) -> list[Rational]:
    def holds(x: Rational) -> bool:
        above = found.low is None or x > found.low or (x == found.low and found.holds_low)
        return bool(above and (found.high is None or x < found.high or (x == found.high and found.holds_high)))

    return [x for x in PLACES if holds(x)]


def test_one_part_or_both_are_asked_about_or_any_environment_of_what_it_may_be_asked() -> None:
    scene = hs.load_scene("fu2019")
    real, imag = noticed(scene.threshold)
    knobs = scene.knobs
    filter_, mass = knobs["omega_n"], knobs["environment.m"]
    for part, expected in ((None, (real, imag)), (Part.REAL, (real,)), (Part.IMAG, (imag,))):
        assert asked_of(scene, [filter_, mass], part, any_environment=False) == expected
    both, one = knobs["evaluation.jnd"], knobs["evaluation.jnd.real"]
    for free in ([filter_], [filter_, both], []):
        [found] = asked_of(scene, free, None, any_environment=True)
        assert found.part is None
    for part in Part:
        with pytest.raises(SceneError, match="there are no parts"):
            asked_of(scene, [filter_], part, any_environment=True)
    for free in ([mass], [filter_, mass], [mass, filter_]):
        with pytest.raises(SceneError, match="no parameter of the environment"):
            asked_of(scene, free, None, any_environment=True)
    for free in ([one], [filter_, one], [one, filter_]):
        with pytest.raises(SceneError, match="the thresholds are one"):
            asked_of(scene, free, None, any_environment=True)


def test_a_region_of_several_terms_is_several_conditions_each_with_its_number() -> None:
    felt, lag = hs.environments.mass_spring_damper(k=100), hs.effects.first_order_lag(40)
    diamond = hs.Scene(felt, (lag,), (0, 10), {"shape": "diamond", "real": "0.1", "imag": "0.2"})
    found = conditions(diamond, [diamond.knobs["omega_c"]], noticed(diamond.threshold))
    rules = [x.rule for x in found]
    assert len(rules) > 1
    [own] = noticed(diamond.threshold)
    assert rules == [each(own, i).rule for i in range(1, len(rules) + 1)]
    assert rules[0].endswith("(1)")
    plain = hs.Scene(felt, (lag,), (0, 10))
    real, imag = noticed(plain.threshold)
    told = conditions(plain, [plain.knobs["omega_c"]], (real, imag))
    assert [x.rule for x in told] == [real.rule, imag.rule]
    assert all(isinstance(x, RealFunction) and pieces(x) == (x,) for x in told.values())
    sided = {"real": {"higher": "0.1", "lower": "0.2"}, "imag": "0.1"}
    both = hs.Scene(felt, (lag,), (0, 10), sided)
    ways = conditions(both, [both.knobs["omega_c"]], noticed(both.threshold)[:1])
    assert len(ways) == 3
    assert [len(pieces(x)) for x in ways.values()] == [2, 2, 2]
    assert all(isinstance(x, Lattice) for x in ways.values())
    with pytest.raises(SceneError, match="rational numbers"):
        pieces(Lattice(((object(), object()),)))  # type: ignore[arg-type]
    symbol = plain.with_values({"environment.k": Symbol("k", positive=True)})
    with pytest.raises(SceneError, match="is a symbol"):
        conditions(symbol, [symbol.knobs["omega_c"]], (real,))


def real_function(top: Expr, bottom: Expr) -> RealFunction:
    axis = Ring.of([Q]).axis
    return RealFunction(axis.function(axis.convert(top).numerator, axis.convert(bottom).numerator))


EVEN = omega**4 + 3 * omega**2 * Q + 1
FACTORS: list[Expr] = [omega**2 - 2, omega**2 - Q, omega**2 + Q, Q - 3, Q**2 + 1, EVEN, omega - Q]


@pytest.mark.parametrize("seed", range(2))
def test_a_quotient_is_written_with_its_sign_above_the_line(seed: int) -> None:
    """Products of factors that change signs, of even ones and of such as are positive, below the line; of either constant."""
    pick = Random(seed)
    for _ in range(2):
        rows = [(x, pick.choice([1, 1, 2, 3])) for x in pick.sample(FACTORS, pick.randint(0, 3))]
        constant = Integer(pick.choice([-3, -1, 2]))
        bottom = constant
        for x, n in rows:
            bottom *= x**n
        top = pick.choice(FACTORS) * pick.choice([-1, 2])
        own = real_function(top.expand(), bottom.expand())
        found = _upright(own).function
        ring = own.axis
        for w, q in (("1/3", "1/2"), ("7/5", 5), (2, "5/2"), (9, 4)):
            at = {omega: Rational(w), Q: Rational(q)}
            above, below = (ring.expression(x).subs(at) for x in (found.numerator, found.denominator))
            true = (top / bottom).subs(at)
            assert below > 0
            assert abs(above / below - true) < Rational(1, 10**12)
        if constant > 0 and all(n % 2 == 0 or x == Q**2 + 1 for x, n in rows):
            assert found == own.function


@pytest.mark.parametrize("seed", range(2))
def test_of_intervals_the_values_without_a_scene_are_left_out_and_nothing_else(seed: int) -> None:
    """Inside, at an end, beside; of a single value, be it one end or two that are alike, nothing is left."""
    pick = Random(seed)
    for _ in range(12):
        marks = sorted(pick.sample(range(-8, 9), 4))
        ends = [End(ExactNumber(Integer(x)), pick.random() < 0.6) for x in marks]
        spans = [Span(ends[0], ends[1]), Span(ends[2], ends[3])]
        if pick.random() < 0.3:
            spans[0] = Span(End(None), ends[1])
        if pick.random() < 0.3:
            spans[1] = Span(ends[2], End(None))
        alone = End(ExactNumber(Integer(20)), closed=True)
        spans.append(pick.choice([Span(alone, alone), Span(alone, End(ExactNumber(Integer(20)), closed=True))]))
        gone = pick.sample([*range(-9, 10), 20, 21], 3)
        roots = {x: SquareRoot(ExactNumber(Integer(x**2))) for x in gone if x >= 0}
        found = without(
            spans,
            [roots.get(x, ExactNumber(Integer(x))) if pick.random() < 0.5 else ExactNumber(Integer(x)) for x in gone],
        )
        for n in [*range(-20, 20), 39, 40, 41, 42, 43]:
            x = Fraction(n, 2)
            assert any(_in(y, x) for y in found) is (any(_in(y, x) for y in spans) and x not in gone)
        for y in found:
            assert (
                y.low.value is None or y.high.value is None or float(y.low.value) < float(y.high.value) or y.low.closed
            )


def _in(span: Span, x: Fraction) -> bool:
    low, high = (None if y.value is None else float(y.value) for y in (span.low, span.high))
    above = low is None or low < x or (low == x and span.low.closed)
    return above and (high is None or x < high or (high == x and span.high.closed))
