"""What the page of an evaluation says, of springs and masses whose crossings are known in closed form."""

from __future__ import annotations

import re
from dataclasses import replace
from decimal import Decimal
from math import cos, pi, sin, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row
from sympy import Rational

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.pages.words import unlike
from haptisym.writing.document import Figure, Section

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k="100 N/m")
LAG = F.first_order_lag(20)


def scene(environment: Any, *effects: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1", **own: Any) -> hs.Scene:
    return hs.Scene(environment, effects, band, jnd, **own)


def said(environment: Any, *effects: Any, **own: Any) -> str:
    return flat(hs.evaluate(scene(environment, *effects, **own)))


# What was left out


def test_what_was_left_out_is_named_with_a_bound_that_holds_and_where_crossings_then_lie() -> None:
    """A delay changes Im most at the high end: by sin(w tau), and Re by 1 - cos(w tau)."""
    tau = 1e-3
    asked = scene(SPRING, F.shunt(b=1), F.delay("1 ms"), band=(1, 12))
    text = flat(hs.evaluate(asked, tolerance="0.02"))
    told = re.search(
        r"Without delay: leaving it out changes r_r by at most (\S+) and r_i by at most (\S+) anywhere", text
    )
    assert told
    full = [(1 + 0.12j) * (cos(12 * tau) - 1j * sin(12 * tau)), 1 + 0.12j]
    real, imag = abs(abs(full[0].real - 1) - 0), abs(full[0].imag - full[1].imag)
    assert real <= float(told[1]) <= 1.05 * real
    assert imag <= float(told[2]) <= 1.05 * imag
    assert "proven (tolerance 0.02). What follows is exact for the scene without it." in text
    place = re.search(r"Its crossings lie in \[([\d.]+), ([\d.]+)\] \(imag\) rad/s\.", text)
    assert place
    assert float(place[1]) < 0.1 / (0.01 - tau) < float(place[2])  # (0.01 - tau) w, nearly
    assert "effects shunt perceived" in text


def test_several_effects_are_left_out_together_and_a_scene_without_crossings_is_told_so() -> None:
    both = flat(hs.evaluate(scene(SPRING, F.first_order_lag("1 MHz"), F.shunt(b="1e-6 N*s/m")), tolerance="0.02"))
    assert "Without first-order-lag and shunt: leaving them out changes" in both
    assert (
        "exact for the scene without them. The full scene differs by no more than that. It has no crossings on the band."
        in both
    )
    assert "effects none" in lines(hs.evaluate(scene(SPRING, F.delay("1 us"), band=(1, 12)), tolerance="0.02"))


def test_where_all_effects_matter_nothing_is_said_to_be_left_out() -> None:
    asked = scene(SPRING, F.shunt(b=1), band=(1, 12))
    assert "Without" not in flat(hs.evaluate(asked, tolerance="0.02"))
    assert "Without" not in flat(hs.evaluate(asked))


# The scene


def test_the_page_begins_with_the_dynamics_the_band_and_the_threshold() -> None:
    shown = hs.evaluate(scene(E.mass_spring_damper(m="2 kg", b=3, k=100), replace(F.shunt(b=4), name="grease"), LAG))
    assert lines(shown)[0] == "Untitled scene"
    assert row(shown, "environment") == "H_env(s) = 2 s^2 + 3 s + 100 N/m"
    assert row(shown, "effects") == "grease (shunt), first-order-lag"
    assert row(shown, "perceived") == "H_perc(s) = (40 s^2 + 140 s + 2000)/(s + 20) N/m"
    assert row(shown, "band") == f"0 rad/s (0 Hz) to 15 rad/s ({15 / 2 / pi:.5g} Hz)"
    assert row(shown, "threshold") == "10 % of |H_env|"
    assert not [x for x in lines(shown) if x.startswith("rendered")]


def test_two_thresholds_are_told_with_the_part_that_each_is_of() -> None:
    shown = hs.evaluate(scene(SPRING, LAG, jnd={"real": "0.05", "imag": "0.125"}))
    assert row(shown, "threshold") == "5 % (real) and 12.5 % (imaginary) of |H_env|"
    assert "r_i rises above 12.5 %" in flat(shown)
    assert "r_r rises above 5 %" in flat(shown)


def test_what_a_controller_renders_stands_between_the_environment_and_what_is_felt() -> None:
    shown = hs.evaluate(scene(SPRING, rendered=E.mass_spring_damper(k="104 N/m")))
    assert row(shown, "rendered") == "H_rendered(s) = 104 N/m"
    assert row(shown, "distortion") == "Re dH = 4"
    assert row(shown, "effects") == "none"


def test_a_scene_of_rotation_is_told_in_its_units() -> None:
    text = said(E.mass_spring_damper(k="2 N*m/rad"), F.shunt(b="1 N*m*s/rad"))
    assert "H_env(s) = 2 N·m/rad" in text
    assert "H_perc(s) = s + 2 N·m/rad" in text
    assert "N/m" not in text


# Step 1


@pytest.mark.parametrize(
    ("gain", "told"),
    [
        ("1.05", "These effects in series stay unnoticed with any environment whatever on this band."),
        ("1.12", "Already at the low end of the band these effects in series are noticed with some environment."),
        ("1.2", "Already at the low end of the band these effects in series are noticed with some environment; with every one they are noticed above 0 rad/s."),
    ],
)  # fmt: skip
def test_a_gain_is_judged_whatever_stands_behind_it(gain: str, told: str) -> None:
    """|G - 1| is 0.05, below the threshold of 0.1; 0.12, below sqrt(2) of it; and 0.2, above."""
    text = said(SPRING, F.series(gain))
    assert text.count(told) == 1
    assert ("with every one" in text) == (gain == "1.2")
    assert ("Already" in text) == (gain != "1.05")


def test_a_lag_is_unnoticed_with_any_environment_up_to_one_frequency_and_noticed_with_all_above_another() -> None:
    """|1/(1 + j w/20) - 1|^2 = w^2/(w^2 + 400) is c^2 at 20 c/sqrt(1 - c^2), here with c = 0.1 and c sqrt(2)."""
    low, high = (20 * sqrt(c2 / (1 - c2)) for c2 in (0.01, 0.02))
    assert (
        f"With any environment whatever, up to {low:.5g} rad/s these effects in series stay unnoticed; with every one they "
        f"are noticed above {high:.5g} rad/s."
    ) in said(SPRING, LAG)
    cut = said(SPRING, LAG, band=(0, 2.5))
    assert f"up to {low:.5g} rad/s these effects in series stay unnoticed." in cut


def test_of_effects_that_are_not_in_series_and_of_none_nothing_is_said_of_other_environments() -> None:
    for effects in ((), (F.shunt(b=1),), (LAG, F.shunt(b=1))):
        assert "ny environment" not in said(SPRING, *effects)
        assert "some environment" not in said(SPRING, *effects)


def test_step_1_tells_the_bandwidth_all_crossings_and_the_sign_of_the_distortion_there() -> None:
    """Re dH/100 = -w^2/(w^2 + 400) is -0.1 at 20/3, Im dH/100 = -20 w/(w^2 + 400) is -0.1 at 20 (5 - sqrt(24))."""
    first = 20 * (5 - sqrt(24))
    shown = hs.evaluate(scene(SPRING, LAG))
    assert (
        f"At {first:.5g} rad/s ({first / 2 / pi:.5g} Hz). Below that the display is perceptually transparent"
        in flat(shown)
    )
    assert row(shown, "real") == f"6.66666666666667 {20 / 3 / 2 / pi:.5g} r_r rises above 10 % Re dH < 0"
    assert row(shown, "imag") == f"{first:.15g} {first / 2 / pi:.5g} r_i rises above 10 % Im dH < 0"


def test_a_display_that_is_transparent_nowhere_everywhere_or_only_further_up_is_said_to_be_so() -> None:
    """A spring of 1 N/m beside a mass of 1 kg is noticed below sqrt(10) rad/s, where it is a tenth of w^2."""
    assert "At every frequency of the band: the display is transparent nowhere. No ratio meets" in said(
        SPRING, F.series("1.2")
    )
    assert "Never on this band: the display is perceptually transparent on the whole of it." in said(
        SPRING, F.series("1.05")
    )
    above = said(E.mass_spring_damper(m=1), F.shunt(k=1))
    assert (
        "From the low end of the band on. The display is perceptually transparent only from 3.1623 to 15 rad/s."
        in above
    )
    assert "r_r falls below 10 % Re dH > 0" in above


def test_a_display_that_is_transparent_again_further_up_is_told_with_both_bands() -> None:
    """A spring of 50 N/m beside a mass of 1 kg on 1000 N/m is more than a tenth of it where |1000 - w^2| < 500."""
    text = said(E.mass_spring_damper(m=1, k=1000), F.shunt(k=50), band=(0, 60))
    low, high = sqrt(500), sqrt(1500)
    assert f"At {low:.5g} rad/s ({low / 2 / pi:.5g} Hz), its bandwidth. The display is perceptually transparent" in text
    assert f"from 0 to {low:.5g} rad/s and from {high:.5g} to 60 rad/s." in text
    assert (
        f"A ratio is unbounded at {sqrt(1000):.5g} rad/s: nothing to compare with there (H_env = 0, or dH infinite)."
        in text
    )


# Step 2


def test_what_is_felt_is_told_with_the_band_and_the_part_where_a_ratio_exceeds() -> None:
    """A mass of 1 kg beside one of 1 kg and 100 N/m: felt forces are equal and opposite where 2 w^2 - 100 = 100 - w^2."""
    shown = hs.evaluate(scene(E.mass_spring_damper(m=1, k=100), F.shunt(m=1)))
    first, change, equal = sqrt(100 / 11), sqrt(50), sqrt(200 / 3)
    for line in (
        f"{first:.5g} to {change:.5g} real lower stiffness",
        f"{change:.5g} to {equal:.5g} real mass instead of stiffness, with lower force",
        f"{equal:.5g} to 10 real mass instead of stiffness, with higher force", "10 to 15 real higher mass",
    ):  # fmt: skip
        assert lines(shown).count(line) == 1, line
    text = flat(shown)
    assert f"Spring and inertia change over at 10 rad/s in the environment, at {change:.5g} rad/s as felt." in text
    assert "A ratio is unbounded at 10 rad/s: nothing" in text
    assert "Nothing is noticed" not in text


def test_a_changeover_that_only_one_of_both_has_is_told_beside_no_frequency() -> None:
    beside = said(E.mass_spring_damper(m=1), F.shunt(k=1))
    assert "Spring and inertia change over at no frequency in the environment, at 1 rad/s as felt." in beside
    before = said(E.mass_spring_damper(m=1, k=100), F.shunt(k="-100 N/m"))
    assert "change over at 10 rad/s in the environment, at no frequency as felt." in before
    assert "change over" not in said(SPRING, LAG)


def test_where_nothing_is_noticed_the_reason_is_the_region_or_the_ratios() -> None:
    assert "Nothing is noticed on the band: neither ratio exceeds its threshold." in said(SPRING, F.series("1.05"))
    disc = {"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.5"}
    assert "Nothing is noticed on the band: the distortion never leaves the ellipse." in said(
        SPRING, F.series("1.05"), jnd=disc
    )
    text = said(SPRING, LAG, jnd=disc)
    assert "joint" in text
    assert "dH leaves the ellipse" in text
    assert "Nothing is noticed" not in text


def test_an_active_display_is_said_to_be_outside_the_model_and_whether_that_is_noticed() -> None:
    lagging = said(SPRING, LAG)
    assert (
        "The imaginary part is outside the paper's model from 0 to 15 rad/s, so that no property is named for what is noticed "
        "there: the display is active (Im H_perc < 0)."
    ) in lagging
    assert "imag noticed, not named" in lagging
    early = said(SPRING, LAG, band=(0, 2))
    assert "outside the paper's model from 0 to 2 rad/s, but not noticed there: the display is active" in early
    passive = said(SPRING, F.shunt(b=1))
    assert "outside the paper's model" not in passive
    assert "A ratio is unbounded" not in passive


# What is certain


def test_what_stayed_open_is_told_with_its_place_and_nothing_else_is_called_certain() -> None:
    """As if it had not been decided what happens where the imaginary part rises above its threshold."""
    found = hs.evaluate(scene(SPRING, LAG))
    [point] = [x for x in found.chart.points if x.omega.digits(3) == "2.02"]
    points = tuple(
        replace(x, undecided=frozenset(found.criteria[1:2])) if x is point else x for x in found.chart.points
    )
    text = flat(replace(found, chart=replace(found.chart, points=points)))
    assert (
        "UNDECIDED at the precision limit: whether a ratio touches its threshold, crosses it twice or stays clear of it near "
        "2.0204 rad/s (imag). Everything else is proven."
    ) in text
    assert "Certain:" not in text
    assert "Undecided" not in flat(found)
    assert "UNDECIDED" not in flat(found)
    assert "Certain: these are all crossings on the band" in flat(found)
    place = re.search(r"part near ω \(rad/s\) ─+ imag \[([\d.]+), ([\d.]+)\]", text)
    assert place
    assert Decimal(place[1]) < 20 * (5 - Decimal(24).sqrt()) < Decimal(place[2])
    assert text.count("r_i rises") == 0


# What reports have besides


def test_the_figure_of_ratios_is_wide_the_others_are_not_and_the_derivation_is_an_appendix() -> None:
    page = hs.evaluate(scene(SPRING, LAG)).document()
    sections = [x for x in page.blocks if isinstance(x, Section)]
    wide = {x.name: x.wide for own in sections for x in own.blocks if isinstance(x, Figure)}
    assert wide == {
        "ratios": True,
        "projections-real": False,
        "projections-imag": False,
        "nyquist": False,
        "jnd-square": False,
    }
    assert [x.title for x in sections if x.appendix] == ["Derivation"]


def test_a_closed_form_that_fills_lines_is_told_by_the_number_of_its_terms() -> None:
    """Of s^60 + ... + s^22 + 5: the powers between 22 and 0 are no terms."""
    powers = " + ".join(f"{7 * n + 13}*s^{n}" for n in range(22, 61))
    text = said(E.expression(f"{powers} + 5"), band=(1, 2))
    assert "environment H_env(s) has 40 terms over 1: see `haptisym derive`" in text
    assert "perceived H_perc(s) has 40 terms over 1: see `haptisym derive`" in text
    assert "haptisym derive" not in said(SPRING, LAG)


def test_a_ratio_that_touches_its_threshold_is_said_to_with_how_many_roots_meet_there() -> None:
    """20 w/(w^2 + 400) is at most a half, at 20 rad/s."""
    shown = hs.evaluate(scene(SPRING, LAG, band=(0, 30), jnd={"real": "0.9", "imag": "0.5"}))
    assert row(shown, "imag") == f"20.0000000000000 {20 / 2 / pi:.5g} r_i touches 50 % (2-fold) Im dH < 0"
    assert "fold)" not in said(SPRING, LAG)


def test_that_no_ratio_meets_its_threshold_is_said_without_reserve_where_all_is_decided() -> None:
    found = hs.evaluate(scene(SPRING, F.series("1.05")))
    assert "No ratio meets its threshold on the band." in flat(found)
    first = replace(found.chart.points[0], undecided=frozenset(found.criteria[:1]))
    opened = replace(found, chart=replace(found.chart, points=(first, *found.chart.points[1:])))
    assert "No ratio meets its threshold on the band, as far as that was decided." in flat(opened)


@pytest.mark.parametrize(
    ("jnd", "told"),
    [
        ({"shape": "ellipse", "real": "0.1", "imag": "0.1"}, "an ellipse, 10 % of |H_env|"),
        ({"shape": "ellipse", "real": "0.1", "imag": "0.2", "tilt": "0.5"}, "an ellipse, 10 % (real) and 20 % (imaginary) of |H_env|, tilt 0.5"),
        ({"shape": "diamond", "real": "0.1", "imag": "0.1"}, "a diamond, 10 % of |H_env|"),
        ({"shape": "polygon", "corners": [["0.1", "0"], ["0", "0.2"], ["-0.1", "-0.1"]]}, "a polygon with the corners (10 %, 0 %), (0 %, 20 %) and (-10 %, -10 %) of |H_env|"),
        ({"real": "0.1", "imag": {"higher": "0.1", "lower": "0.05"}}, "10 % (real) and 10 % higher or 5 % lower (imaginary) of |H_env|"),
        ({"real": "0.1", "imag": "0.1", "floor": "2 N/m"}, "10 % of |H_env|, and at least 2 N/m"),
        ({"real": "0.1 + omega/100", "imag": "0.2"}, "0.01 ω + 0.1 (real) and 20 % (imaginary) of |H_env|"),
    ],
)  # fmt: skip
def test_a_region_is_told_with_its_shape_its_widths_and_what_it_has_besides(jnd: Any, told: str) -> None:
    shown = lines(hs.evaluate(scene(SPRING, F.shunt(b=1), jnd=jnd)))
    first = next(n for n, x in enumerate(shown) if x.startswith("threshold "))
    assert " ".join(shown[first : shown.index("", first)]) == f"threshold {told}"


def test_frequencies_that_are_near_each_other_are_told_in_order_with_digits_that_differ() -> None:
    """As they would be where a band is a millionth wide."""
    for row_of in (["2", "2.000001", "3"], ["1.9999999", "2", "2.0000001"], ["5", "7"]):
        shown = [float(x.digits) for x in unlike([ExactNumber(Rational(x)) for x in row_of])]
        assert shown == sorted(set(shown))
        assert shown == pytest.approx([float(x) for x in row_of], rel=1e-5)
