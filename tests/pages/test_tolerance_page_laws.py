"""What the page of tolerances says, of dampers and springs: k/10b is where a damper beside a spring is noticed."""

from __future__ import annotations

from functools import cache
from math import pi, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row

import haptisym as hs

E, F = hs.environments, hs.effects


@cache
def beside(k: str = "100 N/m", low: str = "1", high: str = "1", top: int = 15, samples: int = 0) -> hs.Tolerances:
    """A damper beside a spring: r_i = b w/k."""
    b = f"{low} N*s/m" if low == high else [f"{low} N*s/m", f"{high} N*s/m"]
    return hs.tolerances(hs.Scene(E.mass_spring_damper(k=k), (F.shunt(b=b),), (1, top), "0.1"), samples=samples)


# What varies, and the verdict


def test_what_varies_is_told_with_its_ends_its_unit_and_how_far_that_is() -> None:
    both = beside("100 N/m +- 10 %", "0.5", "2")
    assert row(both, "k") == "90 110 N/m by 10 %"
    assert row(both, "b") == "0.5 2 N·s/m by 60 %"
    ratio = hs.Scene(E.mass_spring_damper(k=100), (F.second_order_lowpass(900, ["0.4", "0.6"]),), (1, 5), "0.1")
    assert row(hs.tolerances(ratio, samples=0), "ζ") == "0.4 0.6 by 20 %"
    assert "Band: 1 to 15 rad/s" in lines(both)


@pytest.mark.parametrize(
    ("low", "high", "top", "told"),
    [
        ("0.1", "0.2", 10, "Proven: transparent on the whole band for ALL values within the ranges."),
        ("1.5", "2", 10, "Proven: for NONE of the values within the ranges is the display transparent on the whole band."),
        ("0.5", "2", 10, "Proven: it DEPENDS on the values within the ranges whether the display is transparent on the whole band."),
    ],
)  # fmt: skip
def test_the_verdict_of_a_damper_is_told_and_examples_of_both_kinds_where_it_depends(
    low: str, high: str, top: int, told: str
) -> None:
    """Up to 10 rad/s a damper of less than 1 N s/m is not noticed beside 100 N/m."""
    text = flat(beside("100 N/m", low, high, top))
    assert told in text
    assert text.count("Proven: transparent on") + text.count("Proven: for NONE") + text.count("Proven: it DEPENDS") == 1
    if "DEPENDS" in told:
        good, bad = (
            float(text.partition(f"{how}, for example, with b = ")[2].split()[0].rstrip("."))
            for how in ("Transparent", "Noticed")
        )
        assert 0.5 <= good <= 1 < bad <= 2
    else:
        assert "for example" not in text
    assert "Work was cut short" not in text


# Enclosures


def test_crossings_are_enclosed_by_those_of_the_corners_and_grow_and_fall_with_what_moves_them() -> None:
    """At k/(10 b): from 9 to 11 rad/s with k, and down with b."""
    shown = row(beside("100 N/m +- 10 %"), "r_i")
    assert shown == "=9.00000 =11.0000 1 always k -"
    falls = row(beside("100 N/m", "1", "2"), "r_i")
    assert falls == "=5.00000 =10.0000 1 always - b"
    text = flat(beside("100 N/m +- 10 %"))
    assert "Guaranteed: where the ratios meet their thresholds, whatever the values" in text
    assert (
        "An end marked = is reached, at a corner of the ranges; any other is a bound, which crossings may come near or not."
        in text
    )
    assert (
        f"Guaranteed: the bandwidth lies between 9 rad/s ({9 / 2 / pi:.5g} Hz) and 11 rad/s ({11 / 2 / pi:.5g} Hz)."
        in text
    )


def test_where_a_crossing_leaves_the_band_for_some_values_their_number_is_any() -> None:
    """k/(10 b) from 5 to 20, on a band up to 10 rad/s: that end is the band's, and no crossing."""
    assert row(beside("100 N/m", "0.5", "2", 10), "r_i") == "=5.00000 10.0000 any number - b"


def test_two_numbers_that_move_a_crossing_alike_stand_beside_each_other() -> None:
    """Two dampers beside a spring: at k/(10 (b_1 + b_2))."""
    two = F.shunt(b=["0.5 N*s/m", "0.6 N*s/m"], name="one"), F.shunt(b=["0.7 N*s/m", "0.8 N*s/m"], name="two")
    found = hs.tolerances(hs.Scene(E.mass_spring_damper(k="100 N/m +- 2 %"), two, (1, 15), "0.1"), samples=0)
    low, high = 98 / 14, 102 / 12
    assert row(found, "r_i") == f"={low:.5f} ={high:.5f} 1 always k b_one, b_two"


def test_of_a_region_the_border_is_met_by_the_distortion() -> None:
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2"}
    asked = hs.Scene(E.mass_spring_damper(k="100 N/m +- 10 %"), (F.shunt(b=1),), (1, 30), ellipse)
    found = hs.tolerances(asked, samples=0)
    assert "distortion from (rad/s) to (rad/s) crossings it grows with it falls with" in lines(found)
    assert row(found, "dH") == "=18.0000 =22.0000 1 always k -"
    assert "Guaranteed: where the distortion meets the border of the ellipse, whatever the values" in flat(found)
    few = hs.Scene(E.mass_spring_damper(k="100 N/m +- 10 %"), (F.shunt(b=1),), (1, 15), ellipse)
    assert (
        "The distortion does not meet the border of the ellipse on the band, for any values within the ranges: proven."
        in flat(hs.tolerances(few, samples=0))
    )


def test_where_nothing_is_met_for_any_values_that_is_said_and_the_bandwidth_is_the_band() -> None:
    text = flat(beside("100 N/m", "0.1", "0.2", 10))
    assert "No ratio meets its threshold on the band, for any values within the ranges: proven." in text
    assert f"Proven: the bandwidth is 10 rad/s ({10 / 2 / pi:.5g} Hz)." in text
    assert "Guaranteed" not in text


def test_where_the_low_end_is_noticed_no_bandwidth_is_told() -> None:
    text = flat(beside("100 N/m", "12", "13"))
    assert "That the display is transparent from the low end of the band on is not proven for all values." in text
    assert "the bandwidth" not in text


# Estimates


def test_quantiles_are_told_as_estimates_of_so_many_sets_and_none_where_there_is_no_crossing() -> None:
    found = beside("100 N/m", "0.5", "2", 10, samples=5)
    text = flat(found)
    assert "Estimated, NOT guaranteed: quantiles over 5 sets of values, drawn uniformly (seed 2019)" in text
    clear = sum(float(x.values["b"]) <= 1 for x in found.samples)
    assert 0 < clear < 5
    assert f"Of these sets {clear} are transparent on the whole band." in text
    assert row(found, "bandwidth").endswith(" 10")
    assert row(found, "first crossing").endswith(" none")
    first = [float(x) for x in row(found, "first crossing").split() if x != "none"]
    ends = sorted(100 / (10 * float(x.values["b"])) for x in found.samples)
    assert ends[0] - 1e-3 <= first[0] <= first[-1] <= 10
    assert "Estimated" not in flat(beside("100 N/m", "0.5", "2", 10))


# Hands


def held(low: str, high: str, *, damping: Any = "3.6 N*s/m") -> hs.Tolerances:
    """A spring of 100 N/m behind a lag of 20 rad/s: stable in a hand of 10 N/m and 3.6 N s/m below 295.2/560 kg."""
    hand = hs.Hand("own", m=low if low == high else [low, high], b=damping, k="10 N/m")
    return hs.tolerances(
        hs.Scene(E.mass_spring_damper(k="100 N/m"), (F.first_order_lag(20),), (1, 10), "0.1", hands=(hand,)), samples=0
    )


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        ("0.50 kg", "0.52 kg", "the display is stable for ALL values within the ranges."),
        ("0.53 kg", "0.60 kg", "for NONE of the values within the ranges is the display stable."),
        ("0.50 kg", "0.60 kg", "it DEPENDS on the values within the ranges whether the display is stable."),
    ],
)
def test_of_a_hand_that_varies_it_is_told_in_which_of_its_masses_the_display_is_stable(
    low: str, high: str, told: str
) -> None:
    """(b + 20 m) (10 + 20 b) > 2200 m by Routh."""
    text = flat(held(low, high))
    ends = f"{float(low[:4]):g} to {float(high[:4]):g}"
    assert f"Proven: held in own (m_h from {ends}), {told}" in text
    assert row(held(low, high), "m_h").startswith(f"{float(low[:4]):g} {float(high[:4]):g} kg by ")
    if "DEPENDS" in told:
        good, bad = (
            float(text.partition(f"{how}, for example, with m_h = ")[2].split()[0].rstrip("."))
            for how in ("Stable", "Not stable")
        )
        assert 0.5 <= good < 295.2 / 560 < bad <= 0.6
    else:
        assert "for example" not in text


def test_where_hands_alone_vary_the_display_itself_is_told_as_it_is() -> None:
    text = flat(held("0.50 kg", "0.52 kg"))
    first = 20 * (5 - sqrt(24))
    assert "Proven: the display, of which nothing varies, is NOT transparent on the whole band." in text
    assert "Proven: where the ratios meet their thresholds" in text
    assert "An end marked = is a crossing, exactly; any other is a bound." in text
    assert f"Proven: the bandwidth is {first:.5g} rad/s" in text
    assert row(held("0.50 kg", "0.52 kg"), "r_i") == f"={first:.6g} ={first:.6g} 1 always - -"
    assert "whatever the values" not in text


def test_a_hand_with_numbers_is_named_without_ranges() -> None:
    scene = hs.Scene(
        E.mass_spring_damper(k="100 N/m +- 1 %"),
        (F.first_order_lag(20),),
        (1, 10),
        "0.1",
        hands=(hs.Hand("own", m="0.5 kg", b="9 N*s/m", k="10 N/m"),),
    )
    text = flat(hs.tolerances(scene, samples=0))
    assert (9 + 20 * 0.5) * (10 + 20 * 9) > 0.5 * 20 * (10 + 101)  # by Routh
    assert "Proven: held in own, the display is stable for ALL values within the ranges." in text


def test_a_hand_about_an_axis_varies_in_the_units_of_a_rotation() -> None:
    hand = hs.Hand("wrist", m=["0.010 kg*m^2", "0.011 kg*m^2"], b="0.2 N*m*s/rad", k="1 N*m/rad")
    scene = hs.Scene(E.mass_spring_damper(k="1 N*m/rad"), (F.shunt(b="0.1 N*m*s/rad"),), (1, 10), "0.1", hands=(hand,))
    assert row(hs.tolerances(scene, samples=0), "m_h").startswith("0.01 0.011 kg·m² by ")


def test_work_that_was_cut_short_is_told_with_the_limit_and_the_sets_that_were_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = "Work was cut short to keep within the limit of 0.5 s: enclosures may be wider than they need be, and 5 sets of values were drawn. What is said to be proven is."  # fmt: skip
    found = beside("100 N/m", "0.5", "2", 10, samples=5)
    with monkeypatch.context() as given:
        given.setattr(hs.Tolerances, "limit", 0.5)
        assert told in flat(found)
    assert "Work was cut short" not in flat(found)
