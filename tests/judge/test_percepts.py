"""How: as which property a distortion is felt, as more or less of it, and where the model says nothing."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import pytest
from answers import floats, intervals
from oracles import MP
from sympy import Rational, pi

import haptisym as hs
from haptisym.effects import first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import expression, kelvin_voigt, mass_spring_damper
from haptisym.judge.percepts import NOT_NAMED
from haptisym.judge.percepts import felt as percept_words
from haptisym.model.jnd import Part

PAPER = hs.Scene(
    mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m"),
    (second_order_lowpass("80 rad/s", 0.5, name="filter"),),
    title="Numerical example",
)


def felt(result: hs.Evaluation, part: str) -> list[tuple[str, str, float, float]]:
    """Property, change and band of the percepts of one part."""
    return [
        (p.property.value, p.change.value, *intervals([p.band])[0]) for p in result.percepts if p.part.value == part
    ]


def ask(environment: hs.Environment, *chain: hs.Effect, high: object = 15, c: object = "0.1") -> hs.Evaluation:
    return hs.evaluate(hs.Scene(environment, chain, (Rational(0), Rational(str(high))), hs.Threshold.of(c)))


def test_the_paper_s_display_feels_lighter_from_8_and_more_damped_from_12() -> None:
    result = hs.evaluate(PAPER)
    [mass], [damping] = felt(result, "real"), felt(result, "imag")
    assert mass == ("mass", "lower", pytest.approx(7.979, abs=5e-4), 15.0)
    assert damping == ("damping", "higher", pytest.approx(11.94, abs=5e-3), 15.0)
    assert mass[2] == float(result.crossings[0].omega)
    assert damping[2] == float(result.crossings[1].omega)
    assert result.outside_model == ()
    assert result.stable is True


def test_half_the_force_of_a_spring_feels_like_less_stiffness() -> None:
    assert felt(ask(mass_spring_damper(k=100), series("1/2")), "real") == [("stiffness", "lower", 0.0, 15.0)]


def test_twice_the_force_of_a_mass_feels_like_more_mass() -> None:
    assert felt(ask(mass_spring_damper(m=2), series("2")), "real") == [("mass", "higher", 0.0, 15.0)]


def test_half_and_twice_the_force_of_a_damper_feel_like_less_and_more_damping() -> None:
    assert felt(ask(mass_spring_damper(b=2), series("1/2")), "imag") == [("damping", "lower", 0.0, 15.0)]
    assert felt(ask(mass_spring_damper(b=2), series("2")), "imag") == [("damping", "higher", 0.0, 15.0)]


def test_a_spring_with_a_mass_before_it_turns_from_less_stiffness_into_mass() -> None:
    # H_perc = 100 - W: noticed from W = 10; mass from 100; more than the spring's 100 from 200
    assert felt(ask(mass_spring_damper(k=100), shunt(m=1)), "real") == [
        ("stiffness", "lower", float(MP.sqrt(10)), 10.0),
        ("stiffness-to-mass", "lower", 10.0, float(MP.sqrt(200))),
        ("stiffness-to-mass", "higher", float(MP.sqrt(200)), 15.0),
    ]


def test_a_mass_beside_a_spring_turns_from_stiffness_into_less_mass() -> None:
    # H_env = -W, H_perc = 1 - W: |1 - W| < W from W = 1/2; mass from 1; unnoticed from 10
    assert felt(ask(mass_spring_damper(m=1), shunt(k=1)), "real") == [
        ("mass-to-stiffness", "higher", 0.0, float(MP.sqrt(0.5))),
        ("mass-to-stiffness", "lower", float(MP.sqrt(0.5)), 1.0),
        ("mass", "lower", 1.0, float(MP.sqrt(10))),
    ]


def test_a_spring_that_leaks_into_the_real_part_of_a_damper_feels_like_stiffness_added() -> None:
    # Re H_env is zero throughout: it takes the side of what is felt; r_r = 2/w
    result = ask(mass_spring_damper(b=1), shunt(k=2))
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 15.0)]


def test_a_damper_turned_into_nothing_is_less_damping_up_to_none() -> None:
    result = ask(mass_spring_damper(b=1), shunt(b=-1, k=1), high=5)
    assert felt(result, "imag") == [("damping", "lower", 0.0, 5.0)]
    assert result.outside_model == ()


def test_no_damping_is_claimed_where_the_display_is_active() -> None:
    # Im H_perc = w(5 - w^2/5): active beyond 5; Im H_env = 5w: noticed where r_i = w^2/25/... exceeds c
    result = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8)
    # r_i = W/25: noticed from sqrt(2.5); Im H_perc = w (5 - W/5) < 0 beyond 5
    assert felt(result, "imag") == [("damping", "lower", float(MP.sqrt(2.5)), 5.0)]
    assert intervals(result.outside_model) == [(5.0, 8.0)]


def test_a_lag_on_a_spring_is_active_everywhere() -> None:
    result = ask(mass_spring_damper(k=100), first_order_lag(20))
    assert intervals(result.outside_model) == [(0.0, 15.0)]
    assert felt(result, "imag") == []
    assert felt(result, "real") == [("stiffness", "lower", float(Fraction(20, 3)), 15.0)]


def test_a_lag_on_a_spring_and_damper_is_active_while_the_lag_is_the_slower() -> None:
    # Im H_perc has the sign of b w_c - k, at every frequency
    passive = ask(kelvin_voigt(100, "5.1"), first_order_lag(20))
    active = ask(kelvin_voigt(100, "4.9"), first_order_lag(20))
    even = ask(kelvin_voigt(100, 5), first_order_lag(20))
    assert (passive.outside_model, even.outside_model) == ((), ())
    assert intervals(active.outside_model) == [(0.0, 15.0)]


def test_activity_that_vanishes_at_one_frequency_is_two_intervals() -> None:
    # Im H_perc = -w (W - 4)^2
    result = ask(expression("s"), shunt(Z="-s - s*(s^2 + 4)^2"), high=3)
    assert intervals(result.outside_model) == [(0.0, 2.0), (2.0, 3.0)]


def test_an_active_environment_may_be_felt_as_damping() -> None:
    # Im H_env = -w, Im H_perc = 2 w
    result = ask(expression("100 - s"), shunt(b=3), high=20)
    # r_i = 3w/|100 - j w| > 1/10 beyond 900 W = 10^4 + W
    assert felt(result, "imag") == [("damping", "higher", float(MP.sqrt(MP.mpf(10000) / 899)), 20.0)]


def test_percepts_are_split_where_the_ratio_falls_to_the_threshold() -> None:
    # r_r = 1/10 + (W - 4)^2/10^3
    result = ask(mass_spring_damper(k=1), shunt(Z="0.1 + (s^2 + 4)^2/1000"), high=3)
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 2.0), ("stiffness", "higher", 2.0, 3.0)]


def test_percepts_are_not_split_where_the_other_part_crosses() -> None:
    # r_r = 1/2 throughout; r_i crosses 1/10 at 1
    result = ask(mass_spring_damper(k=1), shunt(k="0.5", b="0.1"), high=3)
    assert felt(result, "real") == [("stiffness", "higher", 0.0, 3.0)]
    assert felt(result, "imag") == [("damping", "higher", 1.0, 3.0)]


def test_a_reversed_resonance_trades_stiffness_and_mass() -> None:
    # H_perc = -H: r_r = 2 |100 - W|/|H|, r_i = 4 w/|H|, with |H|^2 = (100 - W)^2 + 4 W
    result = ask(mass_spring_damper(m=1, b=2, k=100), series("-1"))
    # r_r = 1/10 where 399 (100 - W)^2 = 4 W
    low, high = (float(w) for w in sorted(MP.polyroots([399, 0, -79804, 0, 3990000]))[2:])
    assert felt(result, "real") == [
        ("stiffness-to-mass", "equal", 0.0, pytest.approx(low, rel=1e-14)),
        ("mass-to-stiffness", "equal", pytest.approx(high, rel=1e-14), 15.0),
    ]
    assert felt(result, "imag") == []


def test_a_changeover_is_a_change_of_sign() -> None:
    # Re H = (1 - W)^2: touches zero at 1
    touching = ask(expression("(s^2 + 1)^2"))
    assert touching.changeovers_environment == ()
    crossing = ask(expression("(s^2 + 1)^3*(s^2 + 9)"))
    assert floats(crossing.changeovers_environment) == [1.0, 3.0]


def test_a_two_mass_environment_goes_from_spring_to_inertia_and_back_through_its_antiresonance() -> None:
    # H = -W + 100 (-W)/(100 - W) + 50: Re H = 0 where W^2 - 250 W + 5000 = 0, and a pole at 10
    environment = hs.environments.two_mass(1, 0, 50, 1, 0, 100)
    zeros = [float(MP.sqrt(125 - z * MP.sqrt(10625))) for z in (1, -1)]
    assert floats(ask(environment, high=20).changeovers_environment) == [zeros[0], 10.0, zeros[1]]


def test_changeovers_at_the_ends_of_the_band_count() -> None:
    scene = hs.Scene(mass_spring_damper(m=1, b=1, k=49), (), (Rational(7), Rational(9)))
    assert floats(hs.evaluate(scene).changeovers_environment) == [7.0]
    assert floats(hs.evaluate(scene.with_band(1, 7)).changeovers_environment) == [7.0]
    assert floats(hs.evaluate(scene.with_band(8, 9)).changeovers_environment) == []


def test_an_environment_that_is_zero_at_rest_changes_over_nowhere() -> None:
    assert ask(mass_spring_damper(m=1, b=1)).changeovers_environment == ()


def test_the_distortion_of_what_is_rendered_compares_with_the_environment() -> None:
    # rendered with half the damping: Re dH = 0 and Im dH = -b w/2
    scene = hs.Scene(kelvin_voigt(100, 10), (), (Rational(0), Rational(15)), rendered=kelvin_voigt(100, 5))
    result = hs.evaluate(scene)
    # 5 w = |100 + 10 j w|/10 at 2500 W = 100 + W
    assert felt(result, "real") == []
    assert felt(result, "imag") == [("damping", "lower", float(MP.sqrt(MP.mpf(100) / 24)), 15.0)]


def test_effects_act_on_what_is_rendered() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (series("1/2"),), rendered=mass_spring_damper(k=200))
    result = hs.evaluate(scene)
    assert (result.crossings, result.percepts) == ((), ())


def test_a_threshold_that_holds_pi_splits_percepts_where_it_says() -> None:
    """A spring of 1 with a mass before it: r_r = W."""
    result = hs.evaluate(hs.Scene(mass_spring_damper(k=1), (shunt(m=1),), (0, 3), hs.Threshold(pi / 5, 1)))
    edge, double = float(MP.sqrt(MP.pi / 5)), float(MP.sqrt(2))
    assert felt(result, "real") == [
        ("stiffness", "lower", edge, 1.0),
        ("stiffness-to-mass", "lower", 1.0, double),
        ("stiffness-to-mass", "higher", double, 3.0),
    ]


SPRING_BEHIND_DELAY = hs.Scene(mass_spring_damper(k=100), (hs.effects.delay("0.1 s"),), (0, 50))
"""H_perc = 100 exp(-0.1 j omega): Im H_perc = -100 sin(omega/10) < 0 up to 10 pi rad/s, and noticed from 10 asin(0.1) on."""


def test_what_is_noticed_while_the_display_is_active_is_told_without_a_name() -> None:
    result = hs.evaluate(SPRING_BEHIND_DELAY)
    start, end = 10 * MP.asin(MP.mpf("0.1")), 10 * MP.pi
    # r_i falls below 10 % shortly before the half turn, so that nothing is noticed from there to the half turn
    [unnamed] = [(float(x.low.omega), float(x.high.omega)) for x in result.unnamed]
    assert unnamed == (pytest.approx(float(start), rel=1e-15), pytest.approx(float(end - start), rel=1e-15))
    assert result.to_dict()["unnamed"] == [list(unnamed)]
    told = [(x.part.value, float(x.band.low.omega), x.words) for x in result.felt]
    assert ("imag", unnamed[0], NOT_NAMED) in told
    assert repr(result).endswith(f", 1 interval {NOT_NAMED}>")
    assert [x for x in told if x[2] != NOT_NAMED] == [
        (p.part.value, float(p.band.low.omega), percept_words(p)) for p in result.percepts
    ]


def test_an_active_display_that_is_not_noticed_has_nothing_without_a_name() -> None:
    """H_perc = 100 - 5 j omega: active everywhere, but less than 10 % of |H_env| up to 2 rad/s."""
    scene = hs.Scene(mass_spring_damper(k=100), (hs.effects.shunt(b=-5),), (0, "19/10"))
    result = hs.evaluate(scene)
    assert (len(result.outside_model), result.unnamed, result.felt) == (1, (), ())


def test_the_document_has_what_is_noticed_without_a_name_where_there_is_some() -> None:
    active = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8)
    assert active.to_dict()["unnamed"] == [[5.0, 8.0]]
    assert active.to_dict()["outside_model"] == [[5.0, 8.0]]
    assert [row.words for row in active.felt] == ["lower damping", NOT_NAMED]
    quiet = ask(mass_spring_damper(b=5), shunt(Z="s^3/5"), high=8, c=10)
    assert "unnamed" not in quiet.to_dict()
    assert quiet.to_dict()["outside_model"] == [[5.0, 8.0]]


def test_the_document_of_the_paper_s_scene_says_the_same() -> None:
    document = json.loads(hs.evaluate(PAPER).to_json())
    real, imag = 7.978916790174708, 11.937310924322058
    assert [(c["part"], c["omega"], c["digits"], c["kind"], c["sign"], c["multiplicity"]) for c in document["crossings"]] == [
        ("real", real, "7.97891679017471", "exceeds", 1, 1), ("imag", imag, "11.9373109243221", "exceeds", 1, 1),
    ]  # fmt: skip
    assert (document["band"], document["threshold"], document["transparent"], document["bandwidth"]) == (
        [0.0, 15.0], {"real": "1/10", "imag": "1/10"}, [[0.0, real]], real,
    )  # fmt: skip
    assert document["percepts"] == [
        {"part": "real", "band": [real, 15.0], "property": "mass", "change": "lower"},
        {"part": "imag", "band": [imag, 15.0], "property": "damping", "change": "higher"},
    ]
    assert (document["outside_model"], document["unbounded"], document["stable"], document["certified"]) == (
        [],
        [],
        True,
        True,
    )


WORDS = [
    ("lower mass", hs.Scene(mass_spring_damper(m=2), (series("1/2"),))), ("higher stiffness", hs.Scene(mass_spring_damper(k=2), (series("2"),))),
    ("lower damping", hs.Scene(mass_spring_damper(b=2), (series("1/2"),))), ("mass instead of stiffness, with equal force", hs.Scene(mass_spring_damper(k=2), (series("-1"),))),
    ("stiffness instead of mass, with higher force", hs.Scene(mass_spring_damper(m=2), (series("-2"),))),
]  # fmt: skip


@pytest.mark.parametrize(("words", "scene"), WORDS, ids=range(len(WORDS)))
def test_the_words_for_a_percept(words: str, scene: hs.Scene) -> None:
    [percept] = hs.evaluate(scene).percepts
    assert percept_words(percept) == words


# --- friction ----------------------------------------------------------------------------------------------------------


def rubbing(jnd: object = None, friction: object = None, force: str = "0.26 N") -> hs.Scene:
    """The paper's display with friction moved by 5 cm: Im dH gains 4 F/(pi A)."""
    chain = (hs.effects.second_order_lowpass(80, "0.5"), hs.effects.coulomb_friction(force, "5 cm"))
    paper = hs.environments.mass_spring_damper(1.8, 15, 100)
    return hs.Scene(paper, chain, (0, 15), **({} if jnd is None else {"threshold": jnd}), friction=friction)


def test_what_would_not_be_noticed_without_friction_is_friction() -> None:
    found = hs.evaluate(rubbing())
    told = [
        (x.property.value, *(float(y.omega) for y in (x.band.low, x.band.high)))
        for x in found.percepts
        if x.part is Part.IMAG
    ]
    alone = [float(x.omega) for x in hs.evaluate("fu2019").crossings if x.criterion.name == "imag"]
    [own] = [float(x.omega) for x in found.crossings if x.criterion.name == "imag"]
    assert told == [("friction", own, pytest.approx(alone[0])), ("damping", pytest.approx(alone[0]), 15)]
    assert [x.words for x in found.felt if x.part is Part.IMAG] == ["friction", "higher damping"]


def test_of_a_region_too() -> None:
    disc = {"shape": "ellipse", "real": 0.1, "imag": 0.1}
    words = {x.words for x in hs.evaluate(rubbing(disc)).felt}
    assert any("friction" in x for x in words)
    assert not any("friction" in x.words for x in hs.evaluate(rubbing(disc, force="0 N")).felt)


@pytest.mark.parametrize(
    ("friction", "noticed"),
    [
        (None, None), ({"floor": "0.26 N"}, False), ({"floor": "0.2599 N"}, True), ({"weber": "20 %", "reference": "0.22 N"}, False),
        ({"weber": "10 %", "reference": "0.22 N"}, True), ({"weber": "10 %", "reference": "0.5 N", "floor": "0.3 N"}, False),
        ({"weber": "10 %", "reference": "0.5 N"}, True),
    ],
)  # fmt: skip
def test_friction_is_noticed_beyond_a_floor_and_a_share_of_what_should_be_felt(
    friction: Any, *, noticed: bool | None
) -> None:
    found = hs.evaluate(rubbing(friction=friction))
    assert found.to_dict()["friction"]["noticed"] is noticed
    assert "a separate threshold" in " ".join(str(found).split()) or noticed is not None
    assert hs.evaluate("fu2019").friction is None


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"floor": "1 s"}, "floor"),
        ({"weber": -1}, "weber"),
        ({"wbr": 1}, "weber"),
        (0.2, "table"),
        ({"floor": "1 N*m"}, "rotational"),
    ],
)
def test_a_threshold_of_friction_that_makes_no_sense_is_refused(given: Any, said: str) -> None:
    with pytest.raises(hs.SceneError, match=said):
        hs.Scene(hs.environments.mass_spring_damper(k="100 N/m"), friction=given)


def test_a_late_admittance_display_says_that_people_report_more_mass() -> None:
    late = (hs.effects.admittance_display("1/(1 + s/500)"), hs.effects.delay("25 ms"))
    assert any(
        "e0138012" in x for x in hs.evaluate(hs.Scene(hs.environments.mass_spring_damper(m=6), late, (1, 15))).caveats
    )
    assert not any("e0138012" in x for x in hs.evaluate("admittance-display").caveats)
