"""When: the numbers of the paper, tangencies and ends of bands; random scenes against Sturm's theorem and exact arithmetic; laws that every scene keeps."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Any

import pytest
import strategies
import sympy
from answers import floats, intervals, is_outside_model, is_transparent, number_below, of_part, percepts_at, told
from hypothesis import assume
from hypothesis import strategies as st
from marks import rarely
from oracles import DIGITS, MP, Case, Element, Facts, Hertz, digits_of, excess_roots, in_square, rounded, sign
from paper import ask, paper
from strategies import Drawn, Scale, Seeded, cases, element, evaluate, number, rationals, scaled, scene
from strategies import told as effect_of

import haptisym as hs
from haptisym import effects
from haptisym.effects import first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import mass_spring_damper

SPRING = mass_spring_damper(k=1)


def test_the_paper_s_display_is_noticed_at_eight_and_at_twelve() -> None:
    result = evaluate(paper())
    assert [(c.part.value, c.omega.digits(18), c.kind.value, c.sign, c.multiplicity) for c in result.crossings] == [
        ("real", "7.97891679017470770", "exceeds", 1, 1),
        ("imag", "11.9373109243220578", "exceeds", 1, 1),
    ]


def test_on_a_wide_band_the_imaginary_part_returns_at_156() -> None:
    result = evaluate(paper(1000))
    imag = of_part(result, "imag")
    assert [(c.omega.digits(18), c.kind.value) for c in imag] == [
        ("11.9373109243220578", "exceeds"),
        ("156.245841062892840", "returns"),
    ]


@pytest.mark.parametrize(("part", "about"), [("real", 8), ("imag", 12), ("imag", 156)])
def test_fifty_digits_are_fifty_correct_digits(part: str, about: int) -> None:
    case = paper(1000)
    omega = MP.findroot(lambda w: case.ratio(part, w) - MP.mpf(1) / 10, about)
    found = [c.omega.digits(50) for c in of_part(evaluate(case), part)]
    assert rounded(omega, 50) in found


def test_every_number_of_digits_is_correctly_rounded() -> None:
    case = paper()
    omega = MP.findroot(lambda w: case.ratio("real", w) - MP.mpf(1) / 10, 8)
    [crossing] = of_part(evaluate(case), "real")
    for count in range(1, 70):
        assert crossing.omega.digits(count) == rounded(omega, count)


def test_the_document_shows_as_many_digits_as_asked_for_and_an_enclosure() -> None:
    scene = hs.Scene(mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"), (second_order_lowpass(80, 0.5),))
    document = hs.evaluate(scene, 50).to_dict()["crossings"][0]
    case = paper()
    omega = MP.findroot(lambda w: case.ratio("real", w) - MP.mpf(1) / 10, 8)
    assert document["digits"] == rounded(omega, 50)
    assert document["omega"] == float(omega)
    low, high = document["enclosure"]
    assert MP.mpf(low) < omega < MP.mpf(high)
    assert Decimal(high) - Decimal(low) < Decimal(10) ** -48


def test_the_paper_s_changeovers_are_the_eigenfrequency_and_788() -> None:
    result = evaluate(paper())
    [environment], [perceived] = result.changeovers_environment, result.changeovers_perceived
    assert environment.omega.digits(60) == rounded(MP.sqrt(MP.mpf(100) / MP.mpf("1.8")), 60)
    assert perceived.omega.digits(8) == "7.8794812"
    omega = MP.findroot(lambda w: paper().dynamics(MP.mpc(0, w), DIGITS)[1].real, 7.9)
    assert perceived.omega.digits(60) == rounded(omega, 60)


@pytest.mark.slow
def test_just_below_its_peak_the_ratio_crosses_twice_and_just_above_never() -> None:
    omega = MP.findroot(lambda w: MP.diff(lambda x: paper().ratio("real", x), w), 109)
    highest = paper().ratio("real", omega)
    top = Fraction(rounded(highest, 62))
    for k in range(1, 41):
        step = Fraction(1, 10**k)
        below, above = evaluate(paper(1000, top - step)), evaluate(paper(1000, top + step))
        first, second = of_part(below, "real")
        assert (first.kind.value, second.kind.value) == ("exceeds", "returns"), k
        assert MP.mpf(first.omega.digits(60)) < omega < MP.mpf(second.omega.digits(60)), k
        assert of_part(above, "real") == [], k


# --- tangencies, ends of the band, environments that vanish ----------------------------------------------------------


def bandpass(c: str, gain: str = "0.4") -> hs.Evaluation:
    """G - 1 is a band-pass on a circle through 0 whose real part peaks at s = 3j: at half the gain."""
    return ask(SPRING, series(f"1 + {gain}*s/(s^2 + 2*s + 9)"), c=c)


def test_an_exact_touch_is_one_crossing_of_multiplicity_two_and_the_band_stays_transparent() -> None:
    result = bandpass("0.2")
    assert told(result) == [("real", 3.0, "touches", 1, 2)]
    assert result.crossings[0].omega.enclosure(20) == ("3", "3")
    assert intervals(result.transparent) == [(0.0, 15.0)]
    assert float(result.bandwidth) == 15.0
    assert result.percepts == ()


@pytest.mark.parametrize("power", [3, 12, 30, 90])
def test_a_hair_beside_an_exact_touch_there_are_two_crossings_or_none(power: int) -> None:
    hair = Fraction(1, 10**power)
    assert [c.kind.value for c in bandpass(str(Fraction(1, 5) - hair)).crossings if c.part is hs.Part.REAL] == [
        "exceeds",
        "returns",
    ]
    assert bandpass(str(Fraction(1, 5) + hair)).crossings == ()


def test_a_gain_on_a_resonance_touches_the_threshold_where_only_the_damper_works() -> None:
    # r_i = |Im H|/(10 |H|) is 1/10 where Re H = 0, at 7; r_r = |Re H|/(10 |H|) where Im H = 0, at 0
    result = ask(mass_spring_damper(m=1, b=1, k=49), series("0.9"))
    assert told(result) == [("real", 0.0, "touches", -1, 2), ("imag", 7.0, "touches", -1, 2)]
    assert intervals(result.transparent) == [(0.0, 15.0)]
    assert result.percepts == ()


def test_a_ratio_that_dips_to_the_threshold_is_transparent_at_that_one_frequency() -> None:
    # a notch: Re(G - 1) falls from 0.4 to 0.2 at s = 3j and rises again; Im(G - 1) is 0 there
    result = ask(SPRING, series("1 + 0.4*(s^2 + s + 9)/(s^2 + 2*s + 9)"), c="0.2")
    assert told(result) == [("real", 3.0, "touches", 1, 2)]
    assert intervals(result.transparent) == [(3.0, 3.0)]
    assert result.bandwidth is None
    assert [(p.part.value, *intervals([p.band])) for p in result.percepts] == [
        ("real", (0.0, 3.0)),
        ("real", (3.0, 15.0)),
    ]


def on_a_spring(real: str, **options: object) -> hs.Evaluation:
    """A unit spring with a shunt that holds only even powers of s: r_r is the modulus of that polynomial in W = -s^2."""
    return ask(SPRING, shunt(Z=real.replace("W", "(-s^2)")), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("power", "kind"), [(1, "exceeds"), (2, "touches"), (3, "exceeds"), (4, "touches"), (5, "exceeds"), (6, "touches")]
)
def test_multiplicities_are_exact(power: int, kind: str) -> None:
    result = on_a_spring(f"0.1 + (W - 4)^{power}/10^6", band=(1, 3))
    assert told(result) == [("real", 2.0, kind, 1, power)]


def test_a_ratio_that_falls_through_the_threshold_returns() -> None:
    result = on_a_spring("0.1 - (W - 4)^3/10^6", band=(1, 3))
    assert told(result) == [("real", 2.0, "returns", 1, 3)]
    assert intervals(result.transparent) == [(2.0, 3.0)]


def test_the_sign_is_that_of_the_difference() -> None:
    assert told(on_a_spring("-0.1*W/9")) == [("real", 3.0, "exceeds", -1, 1)]
    assert told(on_a_spring("0.1*W/9")) == [("real", 3.0, "exceeds", 1, 1)]


def test_a_crossing_at_the_high_end_of_the_band_belongs_to_it() -> None:
    result = ask(mass_spring_damper(k=100), shunt(m="0.1"), band=(0, 10))
    assert told(result) == [("real", 10.0, "exceeds", -1, 1)]
    assert intervals(result.transparent) == [(0.0, 10.0)]
    assert result.percepts == ()


def test_a_crossing_just_beyond_the_high_end_does_not() -> None:
    high = Fraction(10) - Fraction(1, 10**40)
    result = ask(mass_spring_damper(k=100), shunt(m="0.1"), band=(0, high))
    assert result.crossings == ()
    assert intervals(result.transparent) == [(0.0, 10.0)]  # the nearest double of the high end


def test_a_crossing_at_the_low_end_leaves_one_transparent_frequency() -> None:
    result = ask(mass_spring_damper(k=100), shunt(m="0.1"), band=(10, 20))
    assert told(result) == [("real", 10.0, "exceeds", -1, 1)]
    assert intervals(result.transparent) == [(10.0, 10.0)]
    assert [(p.part.value, *intervals([p.band])) for p in result.percepts] == [("real", (10.0, 20.0))]


def test_a_crossing_at_an_end_of_the_band_given_in_hertz_belongs_to_it() -> None:
    # r_r = W/(W + w^2) = 1/10 at omega = w/3: at a third of the cut-off
    scene = hs.Scene(mass_spring_damper(k=100), (first_order_lag("1 Hz"),))
    for band in (("0 Hz", "1/3 Hz"), ("1/3 Hz", "1 Hz"), ("0.1 Hz", "0.9 Hz")):
        [crossing] = (c for c in hs.evaluate(scene.with_band(*band)).crossings if c.part is hs.Part.REAL)
        assert crossing.omega.digits(40) == rounded(2 * MP.pi / 3, 40)
        assert crossing.kind is hs.CrossingKind.EXCEEDS


def test_points_outside_the_band_are_not_reported() -> None:
    # |(W - 1)(W - 16)| = 30 at (17 -+ sqrt(105))/2 and (17 -+ sqrt(345))/2, none of which lies between 4 and 9
    result = on_a_spring("(W - 1)*(W - 16)/100", band=(2, 3), c="0.3")
    assert result.crossings == ()
    assert result.changeovers_environment == ()
    assert floats(result.chart.points)[0] == 2.0
    assert floats(result.chart.points)[-1] == 3.0


def test_an_opaque_start_has_no_bandwidth() -> None:
    result = on_a_spring("0.5 - 0.1*W")
    assert [c[:3] for c in told(result)] == [("real", 2.0, "returns"), ("real", float(MP.sqrt(6)), "exceeds")]
    assert result.bandwidth is None
    assert intervals(result.transparent) == [(2.0, float(MP.sqrt(6)))]


def test_a_display_that_is_opaque_everywhere_has_an_empty_transparent_set() -> None:
    result = on_a_spring("0.5 + W")
    assert result.transparent == ()
    assert result.bandwidth is None
    assert result.crossings == ()
    assert [(p.part.value, *intervals([p.band])) for p in result.percepts] == [("real", (0.0, 15.0))]


def test_bandwidth_is_that_of_the_interval_that_starts_at_the_low_end() -> None:
    result = on_a_spring("W*(W - 9)/100", band=(0, 5))
    # |W (W - 9)| = 10 at W = 9/2 -+ sqrt(41)/2 (beyond 9 only one) and W (9 - W) = 10 at 9/2 -+ sqrt(41)/2
    roots = [float(MP.sqrt((9 + z * MP.sqrt(41)) / 2)) for z in (-1, 1)] + [float(MP.sqrt((9 + MP.sqrt(121)) / 2))]
    assert [c[1] for c in told(result)] == roots
    assert intervals(result.transparent) == [(0.0, roots[0]), (roots[1], roots[2])]
    assert float(result.bandwidth) == roots[0]


def test_a_ratio_that_starts_at_the_threshold_and_falls_touches_it_at_zero() -> None:
    result = on_a_spring("0.1 - W/10^4")
    assert told(result) == [("real", 0.0, "touches", 1, 2)]
    assert float(result.bandwidth) == 15.0


def test_a_ratio_that_starts_at_the_threshold_and_rises_is_transparent_at_zero_alone() -> None:
    result = on_a_spring("0.1 + W/10^4")
    assert [(c.part.value, float(c.omega), c.kind.value) for c in result.crossings] == [("real", 0.0, "exceeds")]
    assert intervals(result.transparent) == [(0.0, 0.0)]
    assert float(result.bandwidth) == 0.0


def test_each_part_has_its_own_threshold() -> None:
    # G - 1 = -s/(s + 2) at s = j is -1/5 - 2/5 j
    result = ask(SPRING, first_order_lag(2), band=(0, "1.5"), c="1/5", imag="2/5")
    assert told(result) == [("real", 1.0, "exceeds", -1, 1), ("imag", 1.0, "exceeds", -1, 1)]
    assert intervals(result.transparent) == [(0.0, 1.0)]


def test_swapped_thresholds_give_other_crossings() -> None:
    # r_r = W/(W + 4) = 2/5 at W = 8/3; r_i = 2 w/(W + 4) = 1/5 at w = 5 - sqrt(21)
    result = ask(SPRING, first_order_lag(2), band=(0, 2), c="2/5", imag="1/5")
    assert [c[:3] for c in told(result)] == [
        ("imag", float(5 - MP.sqrt(21)), "exceeds"),
        ("real", float(MP.sqrt(MP.mpf(8) / 3)), "exceeds"),
    ]


def test_one_part_may_cross_where_the_other_touches() -> None:
    # at its corner a lag has G - 1 = -1/2 - 1/2 j, where the imaginary part peaks
    result = ask(SPRING, first_order_lag(7), c="1/2")
    assert told(result) == [("real", 7.0, "exceeds", -1, 1), ("imag", 7.0, "touches", -1, 2)]
    assert intervals(result.transparent) == [(0.0, 7.0)]


def test_a_threshold_above_every_ratio_is_never_crossed() -> None:
    result = ask(SPRING, first_order_lag(7), c="1.1", band=(0, 1000))
    assert result.crossings == ()
    assert float(result.bandwidth) == 1000.0


@pytest.mark.parametrize(
    ("environment", "real", "imag"),
    [  # a series effect acts on a mass as G - 1 does, on a damper with the parts swapped
        (mass_spring_damper(m=3), Fraction(20, 3), 100 - 40 * MP.sqrt(6)),
        (mass_spring_damper(b=3), 100 - 40 * MP.sqrt(6), Fraction(20, 3)),
    ],
)
def test_an_environment_that_is_zero_at_rest_has_the_ratios_limit_there(
    environment: hs.Environment, real: object, imag: object
) -> None:
    result = ask(environment, first_order_lag(20))
    assert {c.part.value: float(c.omega) for c in result.crossings} == {"real": float(real), "imag": float(imag)}
    assert {c.kind.value for c in result.crossings} == {"exceeds"}
    assert float(result.bandwidth) == min(float(real), float(imag))
    assert result.unbounded == ()


def test_mass_and_damper_with_a_lag_cross_where_sturm_and_mpmath_say() -> None:
    case = Case(Element("mass-spring-damper", {"m": Fraction(1), "b": Fraction(1)}),
                (Element("first-order-lag", {"omega_c": Fraction(20)}),))  # fmt: skip
    result = evaluate(case)
    assert case.counts == {"real": 1, "imag": 1}
    for crossing, about in zip(result.crossings, (2.3, 4.8), strict=True):
        part = crossing.part.value
        omega = MP.findroot(lambda w, part=part: case.ratio(part, w) - MP.mpf(1) / 10, about)
        assert crossing.omega.digits(40) == rounded(omega, 40)
    assert result.unbounded == ()


def test_a_gain_on_an_environment_that_is_zero_at_rest_is_noticed_from_there_on() -> None:
    result = ask(mass_spring_damper(m=1), series("1.2"))
    assert (result.crossings, result.transparent, result.bandwidth) == ((), (), None)
    assert [(p.part.value, p.property.value, p.change.value, *intervals([p.band])) for p in result.percepts] == [
        ("real", "mass", "higher", (0.0, 15.0))
    ]


def test_a_spring_beside_a_mass_is_noticed_without_bound_at_rest() -> None:
    # r_r = 1/omega^2
    result = ask(mass_spring_damper(m=1), shunt(k=1))
    assert told(result) == [("real", float(MP.sqrt(10)), "returns", 1, 1)]
    assert floats(result.unbounded) == [0.0]
    assert intervals(result.transparent) == [(float(MP.sqrt(10)), 15.0)]
    assert result.bandwidth is None


def test_a_resonance_without_damping_invents_no_crossing() -> None:
    # the environment cancels: r_r = W/(W + 400), r_i = 20 w/(W + 400), whatever the resonance at 7
    result = ask(mass_spring_damper(m=1, k=49), first_order_lag(20))
    assert [(c.part.value, float(c.omega)) for c in result.crossings] == [
        ("imag", float(100 - 40 * MP.sqrt(6))),
        ("real", float(Fraction(20, 3))),
    ]
    assert result.unbounded == ()


def test_an_antiresonance_without_damping_invents_no_crossing_either() -> None:
    # H_env is real, with zeros below and above its pole at 10: r_r = |Re(G - 1)| and r_i = |Im(G - 1)| all the same
    result = ask(hs.environments.two_mass(1, 0, 50, 1, 0, 100), first_order_lag(20), band=(0, 20))
    assert [(c.part.value, float(c.omega)) for c in result.crossings] == [
        ("imag", float(100 - 40 * MP.sqrt(6))),
        ("real", float(Fraction(20, 3))),
    ]
    assert result.unbounded == ()
    assert float(result.bandwidth) == float(100 - 40 * MP.sqrt(6))


def test_a_resonance_with_a_hair_of_damping_keeps_its_two_crossings() -> None:
    # at resonance H collapses over a width of b/m and its phase flips: two crossings, less than 1e-4 rad/s apart
    case = Case(Element("mass-spring-damper", {"m": Fraction(9, 5), "b": Fraction(1, 10**6), "k": Fraction(100)}),
                (Element("first-order-lag", {"omega_c": Fraction(80)}),))  # fmt: skip
    case = case.with_(c={"real": Fraction(1, 20), "imag": Fraction(1)})
    result = evaluate(case)
    assert len(of_part(result, "real")) == case.counts["real"] == 2
    first, second = (float(c.omega) for c in of_part(result, "real"))
    assert 0 < second - first < 1e-4
    assert abs(first - float(MP.sqrt(MP.mpf(500) / 9))) < 1e-4


def test_damping_beside_an_undamped_environment_is_unbounded_at_the_resonance() -> None:
    # r_i = 0.1 w/|49 - W| = 1/10 where W -+ w = 49
    result = ask(mass_spring_damper(m=1, k=49), shunt(b="0.1"))
    low, high = ((MP.sqrt(197) - 1) / 2, (MP.sqrt(197) + 1) / 2)
    assert told(result) == [("imag", float(low), "exceeds", 1, 1), ("imag", float(high), "returns", 1, 1)]
    assert floats(result.unbounded) == [7.0]
    assert result.unbounded[0].omega.enclosure(30) == ("7", "7")
    assert intervals(result.transparent) == [(0.0, float(low)), (float(high), 15.0)]
    assert [(p.part.value, *intervals([p.band])) for p in result.percepts] == [("imag", (float(low), float(high)))]


@pytest.mark.parametrize("band", [(0, 7), (7, 15), ("6.9", 7)])
def test_a_ratio_unbounded_at_an_end_of_the_band_is_not_transparent_there(band: tuple[object, object]) -> None:
    result = ask(mass_spring_damper(m=1, k=49), shunt(b="0.1"), band=band)
    assert floats(result.unbounded) == [7.0]
    assert all(not x.low.omega.bounds(60)[0] <= 7 <= x.high.omega.bounds(60)[1] for x in result.transparent)


def test_a_pole_of_the_display_on_the_axis_is_unbounded_and_opaque() -> None:
    # G = 100/(s^2 + 100): G - 1 = W/(100 - W), real; on a spring r_r = 1/10 at W = 100/11 and never above 10
    result = ask(mass_spring_damper(k=5), second_order_lowpass(10, 0))
    assert told(result) == [("real", float(MP.sqrt(MP.mpf(100) / 11)), "exceeds", 1, 1)]
    assert floats(result.unbounded) == [10.0]
    assert floats(result.changeovers_perceived) == [10.0]
    assert result.stable is False


@pytest.mark.parametrize(
    "chain", [(), (series("1"),), (shunt(k=0),), (shunt(k=3), shunt(k=-3)), (series("2"), series("1/2"))]
)
def test_where_nothing_is_distorted_nothing_is_noticed(chain: tuple[hs.Effect, ...]) -> None:
    result = ask(mass_spring_damper(m=1, b=1, k=49), *chain)
    assert (result.crossings, result.percepts, result.unbounded) == ((), (), ())
    assert intervals(result.transparent) == [(0.0, 15.0)]
    assert float(result.bandwidth) == 15.0
    assert floats(result.changeovers_environment) == floats(result.changeovers_perceived) == [7.0]


def test_a_ratio_that_is_the_threshold_everywhere_is_transparent_and_crosses_nowhere() -> None:
    result = ask(mass_spring_damper(k=100), series("0.9"))
    assert (result.crossings, result.percepts) == ((), ())
    assert intervals(result.transparent) == [(0.0, 15.0)]


def test_a_hair_more_than_the_threshold_everywhere_is_opaque_everywhere() -> None:
    result = ask(mass_spring_damper(k=100), series("0.9 - 10^(-60)"))
    assert (result.crossings, result.transparent) == ((), ())
    assert [(p.property.value, p.change.value, *intervals([p.band])) for p in result.percepts] == [
        ("stiffness", "lower", (0.0, 15.0))
    ]


def test_a_reversed_spring_feels_like_as_much_mass() -> None:
    result = ask(mass_spring_damper(k=100), series("-1"))
    assert (result.crossings, result.transparent, result.bandwidth) == ((), (), None)
    assert [(p.part.value, p.property.value, p.change.value) for p in result.percepts] == [
        ("real", "stiffness-to-mass", "equal")
    ]


def test_a_reversed_damper_is_outside_the_model_and_claims_no_percept() -> None:
    result = ask(mass_spring_damper(b=100), series("-1"))
    assert result.percepts == ()
    assert intervals(result.outside_model) == [(0.0, 15.0)]
    assert result.transparent == ()


# --- random scenes against Sturm's theorem, exact arithmetic and mpmath ----------------------------------------------


PARTS = ("real", "imag")


@cache
def judged(seed: int) -> tuple[Case, hs.Evaluation]:
    case = strategies.case(Seeded(seed), order=4)
    return case, evaluate(case)


quick_seeds = ("0", "1", "2", "3", "5", "8", "13", "21", "34", "46", "51", "55")
each_seed = pytest.mark.parametrize("seed", range(60))


def samples(case: Case, count: int, seed: int = 0) -> list[Fraction]:
    """Rational frequencies inside the band, in order."""
    pick = Seeded(seed)
    low, high = (Fraction(sympy.Rational(str(digits_of(x)))) for x in case.band)
    return sorted({low + (high - low) * Fraction(pick.whole(1, 99_999), 100_000) ** 2 for _ in range(count)})


@pytest.mark.dear("3", "4")
@pytest.mark.few("3", "1", "4")
@pytest.mark.parametrize("seed", range(5))
def test_the_polynomial_of_the_oracle_is_that_of_sympy_s_real_and_imaginary_parts(seed: int) -> None:
    case = strategies.case(Seeded(seed), order=2)
    omega = sympy.Symbol("omega", positive=True)
    H, G = case.dynamics(sympy.I * omega, strategies.exact)
    square = sympy.together(sympy.expand(H * sympy.conjugate(H), complex=True))
    for part, difference in zip(PARTS, sympy.together(G - H).as_real_imag(), strict=True):
        written_out = sympy.cancel(sympy.together(sympy.expand(difference, complex=True)))
        excess = sympy.cancel(sympy.together(written_out**2 / square - strategies.exact(case.c[part]) ** 2))
        written = sympy.Poly(sympy.fraction(excess)[0], omega, domain="QQ")
        assert in_square(written).monic() == case.excess[part].monic(), case


@pytest.mark.parametrize("seed", range(6))
def test_exact_facts_are_those_of_mpmath(seed: int) -> None:
    case = strategies.case(Seeded(seed))
    for omega in samples(case, 5):
        facts = case.facts(omega)
        for part in PARTS:
            assert facts[part].excess == sign(case.ratio(part, digits_of(omega)) - digits_of(case.c[part]))


def above_zero(result: hs.Evaluation) -> list[hs.Crossing]:
    return [c for c in result.crossings if float(c.omega) > 0]


def near(result: hs.Evaluation, crossing: hs.Crossing) -> tuple[Fraction, Fraction]:
    """Rational frequencies just below and just above a crossing, with no other point of the chart in between."""
    points = [p.omega.bounds(120) for p in result.chart.points]
    low, high = crossing.omega.bounds(120)
    gap = min(abs(low - x) for x, _ in points if x != low)
    return low - gap / 1000, high + gap / 1000


def expected_percepts(part: str, at: Facts) -> list[tuple[str, str]]:
    """Section 2.3 of the paper, for one frequency."""
    if at.excess <= 0 or (part == "imag" and at.perc < 0):
        return []
    sides = {
        (1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness",
        (0, 1): "stiffness", (1, 0): "stiffness", (0, -1): "mass", (-1, 0): "mass",
    }  # fmt: skip
    change = {1: "higher", -1: "lower", 0: "equal"}[at.larger]
    return [("damping" if part == "imag" else sides[at.env, at.perc], change)]


def check_at(case: Case, result: hs.Evaluation, omega: Fraction) -> None:
    """Everything that an evaluation says about one frequency."""
    facts = case.facts(omega)
    assert is_transparent(result, omega) == all(facts[part].excess <= 0 for part in PARTS), (omega, case)
    assert is_outside_model(result, omega) == (facts["imag"].perc < 0), (omega, case)
    for part in PARTS:
        assert percepts_at(result, part, omega) == expected_percepts(part, facts[part]), (omega, case)


@pytest.mark.dear("0", "2", "34")
@pytest.mark.few(*quick_seeds)
@each_seed
def test_crossings_of_random_scenes_are_as_many_as_sturm_counts_and_at_each_the_ratio_is_the_threshold(
    seed: int,
) -> None:
    case, result = judged(seed)
    for part in PARTS:
        assert len(of_part(result, part)) == case.counts[part], (part, case)
    for crossing in above_zero(result):
        part = crossing.part.value
        ratio = case.ratio(part, MP.mpf(crossing.omega.digits(55)))
        assert abs(ratio - digits_of(case.c[part])) < MP.mpf(10) ** -35, (crossing, case)


@pytest.mark.dear("0", "2")
@pytest.mark.few(*quick_seeds)
@each_seed
def test_kind_sign_and_multiplicity_of_a_crossing_are_those_of_exact_values_on_either_side(seed: int) -> None:
    kinds = {(-1, 1): "exceeds", (1, -1): "returns", (-1, -1): "touches", (1, 1): "touches"}
    case, result = judged(seed)
    for crossing in above_zero(result):
        before, after = (case.facts(omega)[crossing.part.value] for omega in near(result, crossing))
        assert crossing.kind.value == kinds[before.excess, after.excess], (crossing, case)
        assert crossing.sign == before.difference == after.difference, (crossing, case)
    low, high = (strategies.exact(x) ** 2 for x in case.band)
    for part in PARTS:
        _, factors = case.excess[part].sqf_list() if case.counts[part] else (1, [])
        expected = sum(n * int(f.count_roots(low, high)) for f, n in factors)
        found = of_part(result, part)
        # the multiplicity counts in omega, of which W is the square at 0 and a simple function elsewhere
        assert sum(c.multiplicity if float(c.omega) else c.multiplicity // 2 for c in found) == expected, case


@pytest.mark.few(*quick_seeds)
@each_seed
def test_transparent_set_percepts_and_activity_hold_exactly_the_frequencies_they_should(seed: int) -> None:
    case, result = judged(seed)
    for omega in samples(case, 7, seed):
        check_at(case, result, omega)
    if seed % 4 == 0:  # and just beside every point of the chart
        points = sorted(p.omega.bounds(120) for p in result.chart.points)
        for (_, below_gap), (above_gap, _) in pairwise(points):
            gap = above_gap - below_gap
            check_at(case, result, below_gap + gap / 10**6)
            check_at(case, result, above_gap - gap / 10**6)


@pytest.mark.few(*quick_seeds)
@each_seed
def test_between_changeovers_the_real_part_keeps_its_sign(seed: int) -> None:
    case, result = judged(seed)
    marks = [(omega, case.facts(omega)["real"]) for omega in samples(case, 5, seed)]
    for (low, at_low), (high, at_high) in pairwise(marks):
        for found, a, b in (
            (result.changeovers_environment, at_low.env, at_high.env),
            (result.changeovers_perceived, at_low.perc, at_high.perc),
        ):
            changes = number_below(found, high) - number_below(found, low)
            assert a * b == (-1) ** changes or a == b == 0, (low, high, case)


@pytest.mark.dear("3")
@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(40))
def test_where_zeros_poles_and_ends_coincide_the_evaluation_is_still_right(seed: int) -> None:
    case = strategies.coincident_case(Seeded(seed))
    result = evaluate(case)
    assert {part: len(of_part(result, part)) for part in PARTS} == case.counts
    points = sorted(p.omega.bounds(120) for p in result.chart.points)
    for (_, start), (end, _) in pairwise(points):
        for share in (Fraction(1, 10**6), Fraction(1, 2), 1 - Fraction(1, 10**6)):
            check_at(case, result, start + (end - start) * share)


DAMPED = ("kelvin-voigt", "maxwell", "zener")

LAGGING = ("first-order-lag", "second-order-lowpass", "gain", "lead-lag", "pade-delay", "admittance-display")


@cache
def with_pi(seed: int) -> tuple[Case, hs.Evaluation]:
    """A random scene whose cut-offs are in Hz beside rational numbers, on a band that ends at a number of Hz."""
    pick = Seeded(seed)
    case = strategies.case(pick, order=3, felt=DAMPED, between=LAGGING)
    effects = [Element("first-order-lag", {"omega_c": Hertz(number(pick, Scale(0, 3)))})]
    for old in case.between[:1]:
        turned = {n: Hertz(x) if n in ("omega_c", "omega_n", "w") else x for n, x in old.values.items()}
        effects.append(Element(old.kind, turned))
    case = case.with_(between=tuple(effects), band=(Fraction(0), Hertz(number(pick, Scale(0, 2)))))
    return case, evaluate(case)


@pytest.mark.dear("2")
@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(24))
def test_scenes_with_pi_have_the_crossings_of_mpmath(seed: int) -> None:
    case, result = with_pi(seed)
    for part in PARTS:
        expected = excess_roots(case, part)
        found = [c for c in above_zero(result) if c.part.value == part]
        assert len(found) == len(expected), (part, case)
        for crossing, omega in zip(found, expected, strict=True):
            assert abs(MP.mpf(crossing.omega.digits(40)) / omega - 1) < MP.mpf(10) ** -25, (part, case)


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(24))
def test_scenes_with_pi_are_judged_as_mpmath_does_at_any_frequency(seed: int) -> None:
    case, result = with_pi(seed)
    for omega in samples(case, 6, seed):
        check_at(case, result, omega)


def test_scenes_with_pi_have_crossings_of_both_parts() -> None:
    found = [crossing.part.value for seed in range(24) for crossing in with_pi(seed)[1].crossings]
    assert min(found.count("real"), found.count("imag")) >= 10


# --- laws that every scene keeps -------------------------------------------------------------------------------------

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


@rarely(cases(), rationals())
def test_other_units_of_force_change_nothing(case: Case, force: Fraction) -> None:
    assert_same(evaluate(case), evaluate(scaled(case, force=force)))


@rarely(cases(), rationals())
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


@rarely(
    cases(order=3), st.lists(st.tuples(st.sampled_from(sorted(NOTHING)), st.integers(0, 3)), min_size=1, max_size=3)
)
def test_what_does_nothing_changes_nothing(case: Case, idle: list[tuple[str, int]]) -> None:
    chain = [*map(effect_of, case.between)]
    for name, at in idle:
        chain.insert(min(at, len(chain)), NOTHING[name]())
    assert_same(evaluate(case), with_effects(case, chain))


@pytest.mark.parametrize("name", sorted(NOTHING))
def test_what_does_nothing_alone_distorts_nothing(name: str) -> None:
    m, b, k = hs.symbols("m b k")
    assert hs.distort(hs.environments.mass_spring_damper(m, b, k), NOTHING[name]()).distortion == 0


@rarely(cases(order=3), st.data())
def test_a_series_effect_may_be_split(case: Case, data: st.DataObject) -> None:
    one, other = data.draw(rationals()), data.draw(rationals())
    names = {"a": f"{one.numerator}/{one.denominator}", "b": f"{other.numerator}/{other.denominator}"}
    first, second = "a/(s + a)", "(s + b)/(s + 2*b)"
    whole = effects.series(f"({first})*({second})", parameters=names)
    halves = [effects.series(first, parameters={"a": names["a"]}), effects.series(second, parameters={"b": names["b"]})]
    chain = [*map(effect_of, case.between)]
    assert_same(with_effects(case, [whole, *chain]), with_effects(case, [*halves, *chain]))


@rarely(cases(order=3), rationals(), rationals())
def test_two_shunts_are_one(case: Case, one: Fraction, other: Fraction) -> None:
    chain = [*map(effect_of, case.between)]
    apart = [effects.shunt(m=one, b=other), effects.shunt(m=other, k=one)]
    assert_same(
        with_effects(case, [*apart, *chain]), with_effects(case, [effects.shunt(m=one + other, b=other, k=one), *chain])
    )


@pytest.mark.slow
@rarely(cases(order=3), rationals(), rationals())
def test_two_springs_in_a_row_are_one(case: Case, one: Fraction, other: Fraction) -> None:
    chain = [*map(effect_of, case.between)]
    apart = [effects.compliance(k=one), effects.compliance(k=other)]
    assert_same(
        with_effects(case, [*chain, *apart]),
        with_effects(case, [*chain, effects.compliance(k=one * other / (one + other))]),
    )


@rarely(cases(order=4, between=PURE))
def test_the_order_of_pure_series_effects_does_not_matter(case: Case) -> None:
    assert_same(evaluate(case), evaluate(case.with_(between=case.between[::-1])))


def test_the_order_of_a_lag_and_a_shunt_does_matter() -> None:
    environment, lag, mass = hs.environments.mass_spring_damper(k=1), effects.first_order_lag(1), effects.shunt(m=1)
    assert hs.distort(environment, lag, mass).perceived != hs.distort(environment, mass, lag).perceived
    s = hs.s
    # nearest the environment first: the lag acts on the spring, the mass is added to what comes out
    assert (hs.distort(environment, lag, mass).perceived - (1 / (s + 1) + s**2)).equals(0)
    assert (hs.distort(environment, mass, lag).perceived - (1 + s**2) / (s + 1)).equals(0)


@rarely(cases(order=3), st.data())
def test_a_series_effect_and_its_inverse_change_nothing(case: Case, data: st.DataObject) -> None:
    extra: Element = element(Drawn(data.draw), "first-order-lag")
    cutoff = extra.values["omega_c"]
    inverse = effects.series("(s + w)/w", parameters={"w": f"{cutoff.numerator}/{cutoff.denominator}"})
    chain = [*map(effect_of, case.between)]
    assert_same(evaluate(case), with_effects(case, [effect_of(extra), inverse, *chain]))


@rarely(cases(order=3), rationals(-1, 2))
def test_a_smaller_threshold_leaves_less_of_the_band_transparent(case: Case, factor: Fraction) -> None:
    strict = case.with_(c={part: c * factor for part, c in case.c.items()})
    wide, narrow = (evaluate(case), evaluate(strict)) if factor < 1 else (evaluate(strict), evaluate(case))
    assume(narrow.transparent)
    for interval in narrow.transparent:
        low, high = interval.low.omega.bounds(150)[1], interval.high.omega.bounds(150)[0]
        assert any(x.low.omega.bounds(150)[0] <= low and high <= x.high.omega.bounds(150)[1] for x in wide.transparent)


@rarely(cases(order=3), st.fractions(Fraction(1, 5), Fraction(4, 5), max_denominator=97))
def test_a_band_in_two_halves_has_the_crossings_of_the_whole(case: Case, share: Fraction) -> None:
    low, high = case.band
    middle = low + (high - low) * share
    whole, first, second = (evaluate(case.with_(band=band)) for band in ((low, high), (low, middle), (middle, high)))

    def crossings(*results: hs.Evaluation) -> set[tuple[Any, ...]]:
        return {(c.part, c.omega.digits(20), c.kind, c.sign, c.multiplicity) for r in results for c in r.crossings}

    assert crossings(first, second) == crossings(whole)
