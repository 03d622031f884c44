"""What the page of a requirement says, of gains, dampers and lags whose values can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import asin, pi, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row
from sympy import Rational

import haptisym as hs
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver
from haptisym.verbs.require.feasible import End, Span

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k="100 N/m")
LAG = F.first_order_lag(20)


def scene(environment: Any, *effects: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    return hs.Scene(environment, effects, band, jnd)


@cache
def cutoff(low: float | None = None, high: float | None = None) -> hs.Requirement:
    """Of a lag before a spring."""
    given = None if low is None or high is None else (low, high)
    return hs.require(scene(SPRING, LAG), "omega_c", given)


@cache
def damper(*that: str) -> hs.Requirement:
    """Of a damper behind a lag: the display is active by 100 w 20/(w^2 + 400), for b below 5 N s/m."""
    return hs.require(scene(SPRING, LAG, F.shunt(b=9)), "effects.shunt.b", that=that)


def number(x: Any) -> ExactNumber:
    return ExactNumber(Rational(str(x)))


# The question


def test_the_question_tells_the_parameter_its_unit_the_band_and_the_condition() -> None:
    assert row(cutoff(), "free") == "effects.first-order-lag.omega_c (ω_c), in rad/s"
    assert row(cutoff(), "asked") == "all values > 0"
    assert row(cutoff(), "band") == f"0 rad/s (0 Hz) to 15 rad/s ({15 / 2 / pi:.5g} Hz)"
    assert row(cutoff(), "condition") == "r_r ≤ c_real and r_i ≤ c_imag on the whole band"
    plain = hs.require(scene(SPRING, LAG), "c")  # of 15 20/(225 + 400)
    assert row(plain, "free") == "evaluation.jnd (c), a plain number"
    assert "c binds where" in lines(plain)
    assert "exactly for c ≥ 0.48." in flat(plain)


@pytest.mark.parametrize(
    ("path", "given", "told"),
    [
        ("effects.shunt.b", None, "all values"),
        ("effects.shunt.b", (-2, 3), "values from -2 to 3"),
        ("environment.k", None, "all values ≥ 0"),
        ("effects.first-order-lag.omega_c", (10, 50), "values from 10 to 50"),
    ],
)
def test_what_was_asked_about_is_told_with_its_ends(path: str, given: Any, told: str) -> None:
    assert row(hs.require(scene(SPRING, LAG, F.shunt(b=1)), path, given), "asked") == told


def test_only_a_highest_value_may_have_been_asked_about() -> None:
    up = replace(damper("passive"), domain=replace(damper("passive").domain, high=Rational(7)))
    assert row(up, "asked") == "values up to 7"


@pytest.mark.parametrize(
    ("that", "told"),
    [
        (("transparent",), "r_r ≤ c_real and r_i ≤ c_imag on the whole band"),
        (("passive",), "every passive hand may hold it"),
        (("transparent", "passive"), "r_r ≤ c_real and r_i ≤ c_imag on the whole band; every passive hand may hold it"),
    ],
)
def test_what_is_asked_of_each_frequency_stands_before_what_is_asked_of_all(that: tuple[str, ...], told: str) -> None:
    assert row(damper(*that), "condition") == told


# The answer


def test_a_lag_is_transparent_from_a_cutoff_on_that_the_high_end_of_the_band_sets() -> None:
    """15 wc = 0.1 (225 + wc^2) at the band's end."""
    end = 75 + sqrt(75**2 - 225)
    text = flat(cutoff())
    assert f"The display is transparent on the whole band exactly for ω_c ≥ {end:.5g} rad/s." in text
    assert row(cutoff(), f"{end:.15g}") == f"r_i (imag) the band's high end, 15 rad/s ({15 / 2 / pi:.5g} Hz)"
    assert "Closed form, from the condition at the end of the band:" in text
    assert text.endswith("none is missed and none invented; every digit is proven, not sampled.")
    assert "Nothing binds" not in text
    assert "Nearest" not in text


def test_a_delay_is_transparent_up_to_one_that_the_high_end_of_the_band_sets() -> None:
    """sin(15 tau) = 0.1; none is shorter than nothing."""
    text = flat(hs.require(scene(SPRING, F.delay("10 ms")), "tau"))
    assert f"exactly for 0 ≤ τ ≤ {asin(0.1) / 15:.5g} s." in text
    assert "τ = asin(c)/ω_max" in text


def test_no_value_of_a_range_is_told_with_the_nearest_one_and_how_far_that_is() -> None:
    """At 50 rad/s and 15 rad/s the imaginary part is 750/2725, 2.752 times its threshold."""
    text, most = flat(cutoff(10, 50)), 750 / 2725
    assert "No value that was asked about makes the display transparent on the whole band." in text
    assert (
        f"Nearest of those that were tried is ω_c = 50 rad/s: r_i (imag) reaches {100 * most:.4g} % there (the band's high "
        f"end, 15 rad/s ({15 / 2 / pi:.5g} Hz)), {10 * most:.4g} times its threshold."
    ) in text
    told = text.partition("Proven: no value that was asked about keeps all ratios below ")[2].split()[0]
    assert 1 < float(told) <= 10 * most
    assert text.endswith("Certain: none that will do was missed; that is proven, not sampled.")
    assert "By itself" not in text
    assert "binds where" not in text


def test_where_two_wishes_exclude_each_other_each_is_answered_by_itself() -> None:
    text = flat(damper("transparent", "passive"))
    assert (
        "No value that was asked about makes the display transparent on the whole band and fit for every passive hand."
        in text
    )
    assert (
        "By itself: transparent on the whole band for no value and fit for every passive hand for b ≥ 5 N·s/m." in text
    )
    some = replace(damper("passive"), undecided=((number(-9), number(-8)),))
    both = replace(damper("transparent", "passive"))
    vars(both)["alone"] = (replace(damper("transparent")), some)
    assert "fit for every passive hand for b ≥ 5 N·s/m, while some others are undecided." in flat(both)
    assert "while some others" not in text


def test_a_wish_of_every_passive_hand_binds_beyond_the_band() -> None:
    text = flat(damper("passive"))
    assert "The display is fit for every passive hand exactly for b ≥ 5 N·s/m." in text
    assert row(damper("passive"), "5.00000000000000") == "passive at low frequencies"
    assert "b (N·s/m) binds where" in lines(damper("passive"))


def test_an_end_that_binds_twice_in_the_same_way_has_one_row() -> None:
    """Any spring beside one whose force is zero at 10 rad/s is noticed there: both ends are 0."""
    text = hs.require(scene(E.mass_spring_damper(m=1, k="100 N/m"), F.shunt(k=5), band=(0, 20)), "effects.shunt.k")
    assert "The display is transparent on the whole band exactly for k_shunt = 0 N/m alone." in flat(text)
    bound = f"0 r_r (real) a touch inside the band, 10 rad/s ({10 / 2 / pi:.5g} Hz)"
    assert lines(text).count(bound) == 1


def test_nothing_binds_where_all_that_was_asked_about_will_do_and_that_is_not_said_of_an_end_inside() -> None:
    """With a delay of any length above 0 a spring gives energy away."""
    told = "Nothing binds at an end."
    assert told in flat(hs.require(scene(SPRING, LAG), "omega_c", (200, 300)))
    late = hs.require(scene(SPRING, F.delay("10 ms")), "tau", that=("passive",))
    assert "exactly for τ = 0 s alone." in flat(late)
    assert told not in flat(late)
    inside = replace(cutoff(), feasible=(Span(End(number(150)), End(number(160))),))
    assert told not in flat(inside)
    for low, high in ((210, 300), (200, 290)):
        part = (Span(End(number(low)), End(number(high))),)
        assert told not in flat(replace(hs.require(scene(SPRING, LAG), "omega_c", (200, 300)), feasible=part))


# What is certain


def doubtful(*pairs: tuple[RealNumber | None, RealNumber | None], **own: Any) -> hs.Requirement:
    return replace(cutoff(10, 50), undecided=pairs, **own)


def test_what_is_undecided_is_told_with_its_ends_rounded_outwards_and_all_else_is_decided() -> None:
    text = flat(doubtful((ExactNumber(Rational(41, 3)), ExactNumber(Rational(50, 3)))))
    assert (
        "UNDECIDED: for the values from 13.6666 to 16.6667 neither was proven. About all others everything is." in text
    )
    assert "No value is proven to make the display transparent" in text
    assert "Certain:" not in text
    assert "hatched: undecided" not in text


def test_that_all_others_are_decided_is_not_said_where_there_are_no_others() -> None:
    others = "About all others everything is."
    whole = (number(10), number(50))
    assert others not in flat(doubtful(whole))
    assert others in flat(doubtful((number(10), number(49))))
    assert others in flat(doubtful((number(11), number(50))))
    assert others in flat(doubtful((number(10), number(20)), (number(30), number(50))))
    assert "from 10 to 20 and from 30 to 50" in flat(doubtful((number(10), number(20)), (number(30), number(50))))


def test_an_undecided_value_without_an_end_goes_on_to_infinity_and_why_is_told() -> None:
    text = flat(doubtful((None, None), limit=2.5))
    assert "for the values from minus infinity to infinity neither was proven within the limit of 2.5 s." in text
    assert "neither was proven: it is too long." in flat(doubtful((number(1), None), reason="it is too long"))


def test_values_that_are_proven_beside_some_that_are_not_are_rounded_inwards() -> None:
    end = number("148.4846999")
    part = replace(cutoff(), feasible=(Span(End(end, closed=True), End(None)),), undecided=((number(100), end),))
    text = flat(part)
    assert "The display is transparent on the whole band, proven, for ω_c ≥ 148.49 rad/s." in text
    assert "to 148.485 neither" in text


def test_an_end_of_which_no_more_digits_are_known_is_said_to_lie_in_its_enclosure() -> None:
    found = cutoff()
    near = Sliver(Rational(148), Rational(149))
    text = flat(replace(found, feasible=(Span(End(near, closed=True, bindings=found.ends[0].bindings), End(None)),)))
    assert "Certain: each end lies within the enclosure that is given; of some no more digits are known." in text
    assert "of some no more digits" not in flat(found)


def test_a_figure_of_what_is_judged_on_the_band_says_so_and_what_is_hatched() -> None:
    captions = {
        that: next(str(x.caption) for x in answer.document().blocks if getattr(x, "name", "") == "requirement")
        for that, answer in {
            "on the band": cutoff(),
            "of all": damper("passive"),
            "open": doubtful((number(10), None)),
        }.items()
    }
    assert "The worst case over the band" in captions["on the band"]
    assert "The worst case" not in captions["of all"]
    assert "Grey: " in captions["of all"]
    assert ["hatched: undecided" in captions[x] for x in ("on the band", "of all", "open")] == [False, False, True]
