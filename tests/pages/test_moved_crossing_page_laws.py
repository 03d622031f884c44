"""What pages say of how crossings, peaks and bandwidths move: of lags and springs whose answers have closed forms."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row

import haptisym as hs
from haptisym.writing.document import Figure, Section

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k="100 N/m")
LAG = F.first_order_lag(20)
FIRST = 20 * (5 - sqrt(24))


def scene(environment: Any, *effects: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    return hs.Scene(environment, effects, band, jnd)


def said(environment: Any, *effects: Any, **own: Any) -> str:
    return flat(hs.evaluate(scene(environment, *effects, **own)))


def below(page: object, heading: str) -> dict[str, str]:
    """The rows of the table below a heading, by their first word."""
    shown = lines(page)
    first = next(n for n, x in enumerate(shown) if x.startswith(heading))
    found = shown[first + 4 : shown.index("", first + 3)]
    return {x.split()[0]: x.partition(" ")[2] for x in found}


# Sensitivity


def test_crossings_behind_a_lag_move_with_the_cutoff_and_the_threshold_and_not_with_the_stiffness() -> None:
    """w = wc sqrt(c/(1 - c)) of the real part: the elasticity by c is 1/(2 (1 - c)); of the imaginary part by the root's slope."""
    found = hs.sensitivity(scene(SPRING, LAG))
    real = below(found, f"Crossing of r_r at 6.6667 rad/s ({20 / 3 / 2 / pi:.5g} Hz)")
    assert real == {
        "ω_c": "effects.first-order-lag.omega_c +1.0000 +0.33333 rad/s",
        "c": f"evaluation.jnd +{1 / 1.8:.5g} +{20 / 3 / 1.8 / 0.1:.5g} 1", "k": "environment.k 0 0 N/m",
    }  # fmt: skip
    assert [*real] == ["ω_c", "c", "k"]
    imag = below(found, f"Crossing of r_i at {FIRST:.5g} rad/s")
    slope = (FIRST**2 + 400) / (20 - 0.2 * FIRST)  # 20 w = c (w^2 + 400)
    assert imag["c"] == f"evaluation.jnd +{slope * 0.1 / FIRST:.5g} +{slope:.5g} 1"
    assert [*imag] == ["c", "ω_c", "k"]
    text = flat(found)
    assert (
        f"Bandwidth: {FIRST:.5g} rad/s ({FIRST / 2 / pi:.5g} Hz), the first crossing of r_i; it moves as that one does."
        in text
    )
    assert 'every digit proven. Their formulas: `haptisym derive SCENE --of "d omega_r/d NAME"`.' in text
    assert "UNDECIDED" not in text


def test_a_changeover_moves_down_with_each_mass_and_up_with_the_spring() -> None:
    """sqrt(k/(m + M)): by half a per cent with k, down by a quarter with each of two equal masses."""
    found = hs.sensitivity(scene(E.mass_spring_damper(m=1, k="100 N/m"), F.shunt(m=1), band=(0, 9)))
    at = sqrt(50)
    moved = below(found, f"Changeover of H_perc at {at:.5g} rad/s")
    assert moved["k"] == f"environment.k +0.50000 +{at / 200:.5g} N/m"
    assert moved["m"] == f"environment.m -0.25000 -{at / 4:.5g} kg"
    assert "Changeover of H_env" not in flat(found)


def test_without_a_crossing_or_a_bandwidth_nothing_is_said_to_move() -> None:
    never = flat(hs.sensitivity(scene(SPRING, F.series("1.2"))))
    assert "No ratio meets its threshold on the band: there is no crossing to move." in never
    assert "No transparent band starts at the low end of the band: there is no bandwidth to move." in never
    whole = flat(hs.sensitivity(scene(SPRING, F.series("1.05"))))
    assert (
        f"Bandwidth: 15 rad/s ({15 / 2 / pi:.5g} Hz), the whole band, which small changes of parameters leave as it is."
        in whole
    )


def test_formulas_of_sensitivities_are_offered_for_plain_thresholds_alone() -> None:
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2"}
    assert "Their formulas" not in flat(hs.sensitivity(scene(SPRING, F.shunt(b=1), band=(1, 30), jnd=ellipse)))


# Peaks


def test_a_peak_is_told_with_its_place_and_its_height_and_that_there_is_none() -> None:
    """A spring of 50 N/m beside 1000 - w^2 and 4 j w: 50/sqrt((1000 - x)^2 + 16 x) is largest at x = 992."""
    found = hs.peaks(scene(E.mass_spring_damper(m=1, b=4, k=1000), F.shunt(k=50), band=(0, 60)))
    at, height = sqrt(992), 50 / sqrt(64 + 16 * 992)
    assert row(found, "r_r") == f"{at:.15g} {at / 2 / pi:.5g} {height:.6g}"
    assert "Certain: these are all of them inside the band" in flat(found)
    assert "times the" not in flat(found)
    assert "No ratio has a local maximum inside the band." in flat(hs.peaks(scene(SPRING, LAG)))


def test_the_peaks_of_a_region_tell_how_many_times_it_must_be_enlarged() -> None:
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2"}
    found = hs.peaks(scene(E.mass_spring_damper(m=1, b=4, k=1000), F.shunt(k=50), band=(0, 60), jnd=ellipse))
    height = 500 / sqrt(64 + 16 * 992)
    assert f" {height:.6g}" in flat(found)
    assert "The value is how many times the ellipse must be enlarged to hold the distortion." in flat(found)


# Ranges of the threshold


def test_the_bandwidths_of_a_range_of_thresholds_go_from_that_of_the_least_to_that_of_the_largest() -> None:
    """20 w = c (w^2 + 400)."""
    low, high = (20 * (1 - sqrt(1 - 4 * c * c)) / (2 * c) for c in (0.08, 0.12))
    text = said(SPRING, LAG, jnd="10 % +- 20 %")
    assert (
        f"For thresholds from 8 % to 12 % the bandwidth is at least {low:.5g} rad/s ({low / 2 / pi:.5g} Hz) and at most "
        f"{high:.5g} rad/s ({high / 2 / pi:.5g} Hz); each value between is reached."
    ) in text
    assert "For thresholds" not in said(SPRING, LAG)


def test_a_threshold_of_one_part_that_binds_nowhere_first_leaves_the_bandwidth_as_it_is() -> None:
    text = said(SPRING, LAG, jnd={"real": ["0.05", "0.1"], "imag": "0.1"})
    assert f"For thresholds from 5 % to 10 % (real) the bandwidth is {FIRST:.5g} rad/s" in text
    assert "whichever it is." in text


def test_a_peak_that_the_threshold_passes_makes_the_bandwidth_jump_to_the_end_of_the_band() -> None:
    """The peak of 50/sqrt((1000 - w^2)^2 + 16 w^2), at 992."""
    text = said(E.mass_spring_damper(m=1, b=4, k=1000), F.shunt(k=50), band=(0, 60), jnd=["0.06", "0.5"])
    peak = 50 / sqrt(64 + 16 * 992)
    assert f"each value between is reached but those from {sqrt(992):.5g} to below 60 rad/s (the threshold passes a peak of {100 * peak:.5g} %)." in text  # fmt: skip


def test_where_some_thresholds_or_all_give_no_bandwidth_that_is_said() -> None:
    """A gain of 1.1 is noticed everywhere below a threshold of 10 %."""
    some = said(SPRING, F.series("1.1"), jnd=["0.05", "0.2"])
    assert (
        f"For thresholds from 5 % to 20 % the bandwidth is 15 rad/s ({15 / 2 / pi:.5g} Hz), where there is one." in some
    )
    assert "whichever" not in some
    assert "There is none for a threshold below 10 %." in some
    none = said(SPRING, F.series("1.3"), jnd=["0.05", "0.2"])
    assert "there is no bandwidth: the distortion is noticed at the band's low end." in none
    assert "There is none for" not in said(SPRING, LAG, jnd="10 % +- 20 %")


# Other regions


@cache
def by_regions() -> hs.Evaluation:
    return hs.evaluate(scene(SPRING, LAG), regions=True)


def test_what_other_regions_say_is_told_with_how_far_they_are_apart() -> None:
    """|G - 1| = c on the disc; w^2 + 20 w = c (w^2 + 400) on the diamond."""
    disc, diamond = 20 * 0.1 / sqrt(0.99), (sqrt(100 + 0.9 * 40) - 10) / 0.9
    text = flat(by_regions())
    for name, at, what in (("square", FIRST, "r_i rises above 10 %"), ("disc", disc, "dH leaves the disc"), ("diamond", diamond, "dH leaves the diamond")):  # fmt: skip
        assert row(by_regions(), name).startswith(f"{at:.13g}"[:12])
        assert row(by_regions(), name).endswith(what)
    assert (
        f"By these regions the bandwidth lies between {diamond:.5g} and {FIRST:.5g} rad/s: the largest is {FIRST / diamond:.3g} "
        "times the smallest."
    ) in text
    assert "Does it survive another JND model?" not in lines(hs.evaluate(scene(SPRING, LAG)))


@pytest.mark.parametrize(
    ("gain", "told"),
    [
        ("1.05", "All regions give the same bandwidth, 15 rad/s."),
        ("1.3", "No region gives a bandwidth: that survives another JND model."),
    ],
)
def test_regions_that_agree_about_a_gain_are_said_to(gain: str, told: str) -> None:
    found = hs.evaluate(scene(SPRING, F.series(gain)), regions=True)
    assert told in flat(found)
    assert ("whole band" in flat(found)) == (gain == "1.05")


def test_whether_there_is_a_bandwidth_may_depend_on_the_region() -> None:
    """A complex gain: 8 % in each part at all frequencies above, within the square, and outside of disc and diamond."""
    both = E.expression("100 + 100*s"), F.series("1.08 + 0.08*s", parameters={})
    found = hs.evaluate(hs.Scene(both[0], (both[1],), (1, 2), "0.2"), regions=True)
    widths = {x.name: x.bandwidth for x in found.regions}
    depends = "Whether there is a bandwidth depends on the JND model; where there is, it lies between"
    assert (depends in flat(found)) == (0 < sum(x is None for x in widths.values()) < len(widths))
    swapped = replace(found, regions=(replace(found.regions[0], bandwidth=None), *found.regions[1:]))
    assert (depends in flat(swapped)) == any(x.bandwidth for x in found.regions[1:])


# Ranges of other kinds, and figures


def test_a_range_of_one_part_alone_is_told_with_the_part_although_both_are_alike_in_the_middle() -> None:
    assert "For thresholds from 5 % to 15 % (real) the bandwidth is" in said(
        SPRING, LAG, jnd={"real": ["0.05", "0.15"], "imag": "0.1"}
    )
    both = said(SPRING, LAG, jnd={"real": ["0.05", "0.1"], "imag": ["0.08", "0.12"]})
    assert "For thresholds from 5 % to 10 % (real) and from 8 % to 12 % (imaginary) the bandwidth is" in both


def test_a_region_that_may_be_larger_is_told_by_its_scale() -> None:
    """A damper of 1 N s/m beside 100 N/m leaves an ellipse of 20 % at 20 rad/s times its scale."""
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2", "scale": ["0.5", "1.25"]}
    text = said(SPRING, F.shunt(b=1), band=(1, 30), jnd=ellipse)
    assert (
        f"For a JND from 0.5 to 1.25 times as large the bandwidth is at least 10 rad/s ({10 / 2 / pi:.5g} Hz) and at most 25 rad/s"
        in text
    )
    assert "There is none" not in text
    gain = said(SPRING, F.series("1.06"), jnd={**ellipse, "scale": ["0.25", "2"]})
    assert "There is none for a scale below 0.6." in gain


def figures(page: Any) -> list[str]:
    """Of a document, those of its sections too; none is drawn."""
    found = [x.name for x in page.blocks if isinstance(x, Figure)]
    return found + [name for x in page.blocks if isinstance(x, Section) for name in figures(x)]


def test_bandwidths_over_a_range_and_elasticities_are_drawn_where_there_are_any() -> None:
    ranged = hs.evaluate(scene(SPRING, LAG, jnd="10 % +- 20 %")).document()
    assert "bandwidths" in figures(ranged)
    assert "bandwidths" not in figures(hs.evaluate(scene(SPRING, LAG)).document())
    assert figures(hs.sensitivity(scene(SPRING, LAG)).document()) == ["elasticities"]
    assert figures(hs.sensitivity(scene(SPRING, F.series("1.2"))).document()) == []
