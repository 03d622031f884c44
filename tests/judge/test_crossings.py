"""When: the numbers of the paper, tangencies, and the edges of every question about a band."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import pytest
from answers import floats, intervals, of_part, told
from oracles import DIGITS, MP, Case, Element, rounded
from paper import ask, paper
from strategies import evaluate
from sympy import Expr, Rational, pi, sqrt

import haptisym as hs
from haptisym.effects import compliance, first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import expression, mass_spring_damper
from haptisym.judge.criteria import level, noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega

SPRING = mass_spring_damper(k=1)


# --- the paper's scene -----------------------------------------------------------------------------------------------


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


def test_the_paper_s_changeover_in_closed_form_is_the_undamped_eigenfrequency() -> None:
    m, b, k = hs.symbols("m b k")
    assert hs.distort(mass_spring_damper(m, b, k)).changeover_environment == sqrt(k) / sqrt(m)


# --- tangency --------------------------------------------------------------------------------------------------------


def peak() -> tuple[object, object]:
    """Where r_r of the paper's scene is largest, and how large."""
    omega = MP.findroot(lambda w: MP.diff(lambda x: paper().ratio("real", x), w), 109)
    return omega, paper().ratio("real", omega)


def test_the_peak_of_the_paper_s_real_ratio_is_at_109() -> None:
    omega, highest = peak()
    assert (rounded(omega, 12), rounded(highest, 12)) == ("108.948122405", "1.36706324889")


@pytest.mark.slow
def test_just_below_its_peak_the_ratio_crosses_twice_and_just_above_never() -> None:
    omega, highest = peak()
    top = Fraction(rounded(highest, 62))
    for k in range(1, 41):
        step = Fraction(1, 10**k)
        below, above = evaluate(paper(1000, top - step)), evaluate(paper(1000, top + step))
        first, second = of_part(below, "real")
        assert (first.kind.value, second.kind.value) == ("exceeds", "returns"), k
        assert MP.mpf(first.omega.digits(60)) < omega < MP.mpf(second.omega.digits(60)), k
        assert of_part(above, "real") == [], k


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


# --- the ends of the band --------------------------------------------------------------------------------------------


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
    assert [c[:3] for c in told(result)] == [
        ("real", 2.0, "returns"),
        ("real", float(MP.sqrt(6)), "exceeds"),
    ]
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
    assert [(c.part.value, float(c.omega)) for c in result.crossings] == [("real", 0.0)]
    assert intervals(result.transparent) == [(0.0, 0.0)]
    assert float(result.bandwidth) == 0.0


def test_a_ratio_that_starts_at_the_threshold_and_rises_exceeds_there() -> None:
    assert [c.kind.value for c in on_a_spring("0.1 + W/10^4").crossings] == ["exceeds"]


# --- two thresholds, two parts ---------------------------------------------------------------------------------------


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


# --- environments that vanish ----------------------------------------------------------------------------------------


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


# --- nothing to notice -----------------------------------------------------------------------------------------------


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


# --- scenes that are refused -----------------------------------------------------------------------------------------


def test_an_environment_that_is_zero_is_refused() -> None:
    with pytest.raises(hs.SceneError, match="nothing to feel"):
        ask(expression("s - s"))


def test_effects_that_make_everything_infinite_are_refused() -> None:
    with pytest.raises(hs.SceneError, match="infinite"):
        ask(expression("-s"), compliance(b=1))


@pytest.mark.parametrize("band", [(5, 5), (6, 5), (-1, 5)])
def test_a_band_must_go_upwards_from_zero_or_more(band: tuple[int, int]) -> None:
    with pytest.raises(hs.SceneError, match="band"):
        ask(SPRING, band=band)


def test_an_evaluation_needs_numbers() -> None:
    with pytest.raises(hs.SceneError, match="symbol"):
        ask(mass_spring_damper(k=hs.symbols("k")))


@pytest.mark.parametrize(
    ("kind", "verb"), [("EXCEEDS", "exceeds"), ("RETURNS", "returns below"), ("TOUCHES", "touches")]
)
@pytest.mark.parametrize(("part", "ratio"), [(hs.Part.REAL, "r_r"), (hs.Part.IMAG, "r_i")])
def test_a_crossing_shows_how_its_ratio_meets_the_threshold(kind: str, verb: str, part: hs.Part, ratio: str) -> None:
    found = hs.evaluate(hs.load_scene("fu2019")).crossings[0]
    [criterion] = [x for x in noticed(hs.Threshold()) if x.part is part]
    crossing = hs.Crossing(criterion, found.omega, hs.CrossingKind[kind], 1, 1)
    assert f"{ratio} {verb} its threshold at" in repr(crossing)


@pytest.mark.parametrize(
    "limit",
    [Rational(1, 10), 2 / pi, Rational(7), omega / 50 + pi, (omega + 1) / (3 * omega + 40), 5 / (omega**2 + pi), 1 / (7 * omega + 3) + 2],
)  # fmt: skip
def test_what_exceeds_a_limit_is_the_measure_less_the_limit_over_something_positive(limit: Expr) -> None:
    measure = (omega**2 + 3) / (omega**2 + 5 * omega + 1)
    found = level(RealFunction(Ring().axis.convert(measure)), limit)
    assert isinstance(found, RealFunction)
    assert (found.function.expression() - measure + limit).together().cancel() == 0
