"""Laws that every scene keeps: other units, effects that do nothing, chains taken apart and put together."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import Case, Element
from strategies import Drawn, cases, element, evaluate, rationals, scaled, scene, told

import haptisym as hs
from haptisym import effects

PURE = ("first-order-lag", "second-order-lowpass", "gain", "lead-lag", "pade-delay", "admittance-display")
"""Kinds that multiply the force by something, whatever the environment."""


def outline(result: hs.Evaluation) -> tuple[list[Any], list[Any]]:
    """Everything that an evaluation says: first the words, then the frequencies."""
    found = {
        "crossing": [((c.part, c.kind, c.sign, c.multiplicity), [c.omega]) for c in result.crossings],
        "transparent": [((), [x.low.omega, x.high.omega]) for x in result.transparent],
        "percept": [((p.part, p.property, p.change), [p.band.low.omega, p.band.high.omega]) for p in result.percepts],
        "outside": [((), [x.low.omega, x.high.omega]) for x in result.outside_model],
        "environment": [((), [p.omega]) for p in result.changeovers_environment],
        "perceived": [((), [p.omega]) for p in result.changeovers_perceived],
        "unbounded": [((), [p.omega]) for p in result.unbounded],
    }
    words = [(kind, *said) for kind, entries in found.items() for said, _ in entries]
    return [*words, result.stable], [x for entries in found.values() for _, numbers in entries for x in numbers]


def assert_same(one: hs.Evaluation, other: hs.Evaluation, slower: Fraction = Fraction(1)) -> None:
    """Both say the same, the other one with a clock that many times as slow."""
    (words, numbers), (other_words, other_numbers) = outline(one), outline(other)
    assert words == other_words
    for x, y in zip(numbers, other_numbers, strict=True):
        (low, high), (other_low, other_high) = x.bounds(150), y.bounds(150)
        assert low <= other_high * slower
        assert other_low * slower <= high


def with_effects(case: Case, chain: list[hs.Effect]) -> hs.Evaluation:
    plain = scene(case)
    return hs.evaluate(hs.Scene(plain.environment, tuple(chain), plain.band, plain.threshold))


@given(cases(), rationals())
def test_other_units_of_force_change_nothing(case: Case, force: Fraction) -> None:
    assert_same(evaluate(case), evaluate(scaled(case, force=force)))


@given(cases(), rationals())
def test_other_units_of_time_scale_every_frequency(case: Case, time: Fraction) -> None:
    assert_same(evaluate(case), evaluate(scaled(case, time=time)), slower=time)


NOTHING: dict[str, Callable[[], hs.Effect]] = {
    "a gain of one": lambda: effects.series("1"),
    "a gain of one, written as a quotient": lambda: effects.series("(s + 3)/(3 + s)"),
    "a shunt without stiffness": lambda: effects.shunt(k=0),
    "a position loop that is perfect": lambda: effects.admittance_display("1"),
    "a two-port that passes everything": lambda: effects.two_port("1", "0", "0", "1"),
    "a two-port with a common factor": lambda: effects.two_port("s + 2", "0", "0", "s + 2"),
    "a delay of no time": lambda: effects.delay(0),
    "a rational delay of no time": lambda: effects.pade_delay(0, 3),
    "a four-channel teleoperator without delay": lambda: effects.four_channel_teleoperator(1, 2, 3, 4, 5, 6),
    "a wide-open lead and lag": lambda: effects.series("(1 + s*T)/(1 + s*T)", parameters={"T": "1 ms"}),
}
"""Effects that do nothing."""


@given(cases(order=3), st.lists(st.tuples(st.sampled_from(sorted(NOTHING)), st.integers(0, 3)), min_size=1, max_size=3))
def test_what_does_nothing_changes_nothing(case: Case, idle: list[tuple[str, int]]) -> None:
    chain = [*map(told, case.between)]
    for name, at in idle:
        chain.insert(min(at, len(chain)), NOTHING[name]())
    assert_same(evaluate(case), with_effects(case, chain))


@pytest.mark.parametrize("name", sorted(NOTHING))
def test_what_does_nothing_alone_distorts_nothing(name: str) -> None:
    m, b, k = hs.symbols("m b k")
    assert hs.distort(hs.environments.mass_spring_damper(m, b, k), NOTHING[name]()).distortion == 0


def test_a_shunt_whose_formula_is_zero_distorts_nothing() -> None:
    assert hs.distort(hs.environments.mass_spring_damper(k=1), effects.shunt(Z="0")).distortion == 0


@given(cases(order=3), st.data())
def test_a_series_effect_may_be_split(case: Case, data: st.DataObject) -> None:
    one, other = data.draw(rationals()), data.draw(rationals())
    names = {"a": f"{one.numerator}/{one.denominator}", "b": f"{other.numerator}/{other.denominator}"}
    first, second = "a/(s + a)", "(s + b)/(s + 2*b)"
    whole = effects.series(f"({first})*({second})", parameters=names)
    halves = [
        effects.series(first, parameters={"a": names["a"]}),
        effects.series(second, parameters={"b": names["b"]}),
    ]
    chain = [*map(told, case.between)]
    assert_same(with_effects(case, [whole, *chain]), with_effects(case, [*halves, *chain]))


@given(cases(order=3), rationals(), rationals())
def test_two_shunts_are_one(case: Case, one: Fraction, other: Fraction) -> None:
    chain = [*map(told, case.between)]
    apart = [effects.shunt(m=one, b=other), effects.shunt(m=other, k=one)]
    assert_same(
        with_effects(case, [*apart, *chain]),
        with_effects(case, [effects.shunt(m=one + other, b=other, k=one), *chain]),
    )


@given(cases(order=3), rationals(), rationals())
def test_two_springs_in_a_row_are_one(case: Case, one: Fraction, other: Fraction) -> None:
    chain = [*map(told, case.between)]
    apart = [effects.compliance(k=one), effects.compliance(k=other)]
    assert_same(
        with_effects(case, [*chain, *apart]),
        with_effects(case, [*chain, effects.compliance(k=one * other / (one + other))]),
    )


@given(cases(order=4, between=PURE))
def test_the_order_of_pure_series_effects_does_not_matter(case: Case) -> None:
    assert_same(evaluate(case), evaluate(case.with_(between=case.between[::-1])))


def test_the_order_of_a_lag_and_a_shunt_does_matter() -> None:
    environment, lag, mass = hs.environments.mass_spring_damper(k=1), effects.first_order_lag(1), effects.shunt(m=1)
    assert hs.distort(environment, lag, mass).perceived != hs.distort(environment, mass, lag).perceived
    s = hs.s
    # nearest the environment first: the lag acts on the spring, the mass is added to what comes out
    assert (hs.distort(environment, lag, mass).perceived - (1 / (s + 1) + s**2)).equals(0)
    assert (hs.distort(environment, mass, lag).perceived - (1 + s**2) / (s + 1)).equals(0)


@given(cases(order=3), st.data())
def test_a_series_effect_and_its_inverse_change_nothing(case: Case, data: st.DataObject) -> None:
    extra: Element = element(Drawn(data.draw), "first-order-lag")
    cutoff = extra.values["omega_c"]
    inverse = effects.series("(s + w)/w", parameters={"w": f"{cutoff.numerator}/{cutoff.denominator}"})
    chain = [*map(told, case.between)]
    assert_same(evaluate(case), with_effects(case, [told(extra), inverse, *chain]))


@given(cases(order=3), rationals(-1, 2))
def test_a_smaller_threshold_leaves_less_of_the_band_transparent(case: Case, factor: Fraction) -> None:
    strict = case.with_(c={part: c * factor for part, c in case.c.items()})
    wide, narrow = (evaluate(case), evaluate(strict)) if factor < 1 else (evaluate(strict), evaluate(case))
    for interval in narrow.transparent:
        low, high = interval.low.omega.bounds(150)[1], interval.high.omega.bounds(150)[0]
        assert any(x.low.omega.bounds(150)[0] <= low and high <= x.high.omega.bounds(150)[1] for x in wide.transparent)


@given(cases(order=3), st.fractions(Fraction(1, 5), Fraction(4, 5), max_denominator=97))
def test_a_band_in_two_halves_has_the_crossings_of_the_whole(case: Case, share: Fraction) -> None:
    low, high = case.band
    middle = low + (high - low) * share
    whole, first, second = (evaluate(case.with_(band=band)) for band in ((low, high), (low, middle), (middle, high)))

    def crossings(*results: hs.Evaluation) -> set[tuple[Any, ...]]:
        return {(c.part, c.omega.digits(20), c.kind, c.sign, c.multiplicity) for r in results for c in r.crossings}

    assert crossings(first, second) == crossings(whole)


@given(cases(order=3))
def test_a_scene_says_the_same_twice(case: Case) -> None:
    assert evaluate(case).to_json() == evaluate(case).to_json()
