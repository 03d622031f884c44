"""What the page of measures says, of a lag before a spring and of a mass and damper beside one: all in closed form."""

from __future__ import annotations

import re
from functools import cache
from math import exp, hypot, pi, sqrt
from typing import Any

import pytest
from pagewords import flat, lines, row

import haptisym as hs
from haptisym.pages.metrics import formulated
from haptisym.writing.boxes import Name

E, F = hs.environments, hs.effects
SPRING = E.mass_spring_damper(k="100 N/m")


@cache
def lag(jnd: str = "0.1") -> hs.Metrics:
    return hs.metrics(hs.Scene(SPRING, (F.first_order_lag(20),), (0, 15), jnd))


@cache
def beside() -> hs.Metrics:
    """A mass of 1 kg and a damper of 1 N s/m beside 1 kg, 2 N s/m and 100 N/m."""
    jnd = {"real": "0.1", "imag": "0.2"}
    return hs.metrics(hs.Scene(E.mass_spring_damper(m=1, b=2, k="100 N/m"), (F.shunt(m=1, b=1),), (1, 15), jnd))


def of(page: Any, title: str) -> list[str]:
    """The lines below a heading."""
    shown = lines(page)
    first = shown.index(title) + 1
    return shown[first : shown.index("", first)]


def test_the_verdict_by_the_jnd_is_told_first_with_the_threshold() -> None:
    first = 20 * (5 - sqrt(24))
    assert row(lag(), "JND") == f"transparent from 0 to {first:.5g} rad/s (c = 10 %)"
    assert row(beside(), "JND").endswith("(c = 10 % and 20 %)")
    nowhere = hs.metrics(hs.Scene(SPRING, (F.series("1.2"),), (0, 15), "0.1"))
    assert row(nowhere, "JND") == "transparent nowhere on the band (c = 10 %)"


def test_the_verdict_by_a_region_is_told_with_the_region() -> None:
    ellipse = {"shape": "ellipse", "real": "0.1", "imag": "0.2"}
    found = hs.metrics(hs.Scene(SPRING, (F.shunt(b=1),), (1, 30), ellipse))
    told = " ".join(lines(found)[2:5])
    assert "JND transparent from 1 to 20 rad/s (an ellipse, 10 % (real) and 20 % (imaginary) of |H_env|)" in told
    nowhere = hs.metrics(hs.Scene(SPRING, (F.series("1.2"),), (1, 30), ellipse))
    assert "JND transparent nowhere on the band (an ellipse" in flat(nowhere)


def test_the_transmitted_impedance_of_a_lag_is_its_own_and_falls_by_3_db_at_the_cutoff() -> None:
    shown = of(lag(), "Transmitted impedance ratio")
    assert shown[0] == "Γ(s) = H_perc(s)/H_env(s) = ω_c/(s + ω_c)"
    assert "-3 dB edge, falling 20 rad/s" in shown
    first = 20 * (5 - sqrt(24))
    assert f"first edge at 20 rad/s, {20 / first:.2g} times the bandwidth by the JND" in shown


def test_the_relative_distortion_of_a_lag_is_largest_at_the_high_end() -> None:
    """w/sqrt(w^2 + 400): 0.6 at 15 rad/s, and a tenth at 2/sqrt(0.99)."""
    shown = of(lag(), "Relative distortion")
    assert shown[0] == "Θ(s) = dH(s)/H_env(s) = -s/(s + ω_c)"
    assert "largest on the band 0.6" in shown
    assert f"at most 10 % from 0 to {2 / sqrt(0.99):.5g} rad/s" in shown


def test_the_range_of_impedance_is_told_with_what_is_felt_of_nothing_and_of_a_rigid_environment() -> None:
    """What stands beside is felt of nothing: |1 (j w)^2 + j w| at 1 and at 15 rad/s."""
    shown = of(beside(), "Impedance range")
    assert shown[:3] == ["Z_min(s) = B/D = s (m_shunt s + b_shunt)", "Z_max(s) = A/C", "Z_width(s) = (A D - B C)/(C D)"]
    assert f"|Z_min| at low end {hypot(1, 1):.5g} N/m" in shown
    assert f"|Z_min| at high end {hypot(225, 15):.5g} N/m" in shown
    assert "|Z_max| everywhere infinite" in shown
    yielding = of(hs.metrics(hs.Scene(SPRING, (F.compliance(k="500 N/m"),), (1, 15), "0.1")), "Impedance range")
    assert "Z_max(s) = A/C = k_compliance" in yielding
    assert "|Z_max| at low end 500 N/m" in yielding
    assert "|Z_min| at low end 0 N/m" in yielding


def test_names_of_quantities_in_words_are_formulas_and_the_words_are_whole() -> None:
    """In LaTeX H_perc is a letter with what is below it; in text nothing is lost and nothing doubled."""
    shown = of(beside(), "Impedance range")
    assert "where there is nothing, Z_min is felt; a rigid environment is felt as rigid" in shown
    passive = flat(beside())
    assert "every passive hand: holds, as Im H_perc ≥ 0 at all frequencies and no pole forbids it" in passive
    assert ">=" not in passive
    told = formulated("Z_min >= r_r, not Zmin, and H_perc")
    assert [x for x in told if isinstance(x, str)] == [" ≥ ", ", not Zmin, and "]
    assert sum(isinstance(x, Name) for x in told) == 3


def test_sensitivity_is_one_where_effects_stand_beside() -> None:
    assert of(beside(), "Sensitivity")[0] == "dH_perc/dH_env = (A D - B C)/(C H_env(s) + D)^2 = 1"
    assert of(lag(), "Sensitivity")[0].endswith("= ω_c/(s + ω_c)")


def test_passivity_is_told_where_it_is_lost_and_by_how_much() -> None:
    """Im H_perc = -2000 w/(w^2 + 400) is -48 N/m at 15 rad/s, and -5 w near rest."""
    shown = of(lag(), "Passivity")
    assert shown[0] == "Im H_perc(s) ≥ 0"
    for line in (
        "Im H_perc ≥ 0 on the band at 0 rad/s (0 Hz) alone", "Im H_perc < 0, looked at up to 15 rad/s from 0 to 15 rad/s",
        "most energy given per cycle, over π A² at 15 rad/s 48 N/m", "every passive hand does not hold",
        "hand damping that makes up for it, set at 0 rad/s 5 N·s/m", "force stable under imposed motion yes",
    ):  # fmt: skip
        assert line in shown
    assert "Im H_perc < 0, looked at up to 15 rad/s nowhere" in of(beside(), "Passivity")


def test_stiffness_mass_and_damping_are_told_at_the_ends_and_at_crossings() -> None:
    shown = of(beside(), "Effective impedance")
    assert shown[0] == "k_perc = Re H_perc = k - (m + m_shunt) ω^2"
    assert shown[2] == "b_perc = Im H_perc/ω = b + b_shunt"
    for line in ("stiffness at 1 rad/s 98 N/m", "mass at 1 rad/s -98 kg", "damping at 1 rad/s 3 N·s/m", "stiffness at 15 rad/s -350 N/m",
                 f"mass at 15 rad/s {350 / 225:.5g} kg"):  # fmt: skip
        assert line in shown
    assert "mass at 0 rad/s infinite" in of(lag(), "Effective impedance")


def test_a_free_response_is_compared_with_that_of_the_environment_and_its_tolerances() -> None:
    """Zeros of s^2 + 2 s + 100 and of 2 s^2 + 3 s + 100."""
    shown = " ".join(of(beside(), "Free response"))
    own, felt = (1.0, sqrt(99)), (0.75, sqrt(50 - 0.75**2))
    assert (
        f"P_1, period {2 * pi / felt[1]:.5g} s, environment {2 * pi / own[1]:.5g} s; tolerance 20 %: NOT KEPT" in shown
    )
    first, true = (exp(-pi * x / y) for x, y in (felt, own))
    assert f"A_1/A_d {first:.5g}, environment {true:.5g}; tolerance 10 % of A_1: kept" in shown
    counts = [sum(exp(-n * pi * x / y) > 0.05 for n in range(1, 30)) for x, y in (felt, own)]
    assert (
        f"overshoots above 5 % of A_d {counts[0]}, environment {counts[1]}; tolerance the same number to within 1: kept"
        in shown
    )
    none = of(lag(), "Free response")
    assert any(x.startswith("not offered: no zero is complex") for x in none)


def test_conditions_are_told_before_what_they_say() -> None:
    shown = of(lag(), "Absolute stability")
    assert shown[:4] == [
        "Im (B/D) ≥ 0",
        "Im (C/D) ≤ 0",
        "Re g - 2 Im (B/D)*Im (C/D) ≥ |g|",
        "g = (A D - B C)/D^2 = ω_c/(s + ω_c)",
    ]
    assert of(lag(), "Free response")[:3] == [
        "P_0 = (π - atan(ω_d/σ))/ω_d",
        "P_n = 2 π/ω_d",
        "A_n/A_d = exp(-n π σ/ω_d)",
    ]


def test_a_formula_that_is_long_in_symbols_stands_in_numbers() -> None:
    long = hs.metrics(
        hs.Scene(
            E.mass_spring_damper(m="1.23456789", b="2.345678901", k="100.456789 N/m"),
            (F.second_order_lowpass("81.2345678", "0.7071067812"), F.compliance(k="1234.5678 N/m")), (1, 15), "0.1",
        )
    )  # fmt: skip
    theta = of(long, "Relative distortion")[0]
    assert theta.startswith("Θ(s) = dH(s)/H_env(s) ≈ -(s^2 + ")
    assert "ω_n" not in theta
    told = re.fullmatch(r".* ≈ -\(s\^2 \+ ([\d.]+) s \+ ([\d.]+)\)/\(s\^2 \+ ([\d.]+) s \+ ([\d.]+)\)", theta)
    assert told
    b1, k1, b2, k2 = map(float, told.groups())
    s = 7j
    env = 1.23456789 * s * s + 2.345678901 * s + 100.456789
    g = 81.2345678**2 / (s * s + 2 * 0.7071067812 * 81.2345678 * s + 81.2345678**2)
    perc = 1 / (1 / (g * env) + 1 / 1234.5678)
    assert -(s * s + b1 * s + k1) / (s * s + b2 * s + k2) == pytest.approx((perc - env) / env, rel=1e-4)


def test_each_measure_has_its_source_and_the_last_words_are_certain_or_not() -> None:
    text = flat(lag())
    assert text.count("Source: ") == len(lag().metrics) == 8
    assert text.endswith("How far a source was read is said beside it.")
    assert "Certain: every edge, band and number is proven" in text
    assert "UNDECIDED" not in text


def test_where_measures_disagree_is_told_and_not_where_they_do_not() -> None:
    assert "Where they disagree" in lines(lag())
    assert "is blind to it, while the JND test is not." in flat(lag())
    assert "Where they disagree" not in lines(beside())
