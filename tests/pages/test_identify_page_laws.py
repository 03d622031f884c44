"""What the page of an identified model says, of lines whose noise is known, and whose sums anybody can work out."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from math import ceil, log10

import numpy as np
import pytest
from pagewords import flat, lines, row
from scipy.stats import chi2

import haptisym as hs

W = np.arange(1.0, 13.0)
NOISE = np.random.default_rng(3).standard_normal((2, 12))
SPREAD = 0.5
RADIUS = SPREAD * float(np.sqrt(chi2.ppf(0.95, 2)))


@cache
def found(kind: str = "fits") -> hs.Identification:
    """A spring of 100 N/m with 3 N s/m, each part of each line with an error of 0.5 N/m."""
    H = 100 + 3j * W + SPREAD * (NOISE[0] + 1j * NOISE[1])
    radius = {"fits": RADIUS, "does not": RADIUS / 10, "hardly": 16 * RADIUS}.get(kind)
    if kind == "another":
        H, radius = 100 + 3j * W - 1.5 * W**2, None
    discs = {} if radius is None else {"radius": [radius] * len(W)}
    return hs.identify(hs.measured(W, H, **discs), "kelvin-voigt")


def chi_square(kind: str, radius: float) -> float:
    """Of the residuals, with the values that were found."""
    value = {x.parameter.name: x.value for x in found(kind).estimates}
    H = 100 + 3j * W + SPREAD * (NOISE[0] + 1j * NOISE[1])
    left = H - value["k"] - 1j * value["b"] * W
    return float(np.sum(abs(left) ** 2)) / (radius**2 / float(chi2.ppf(0.95, 2)))


# Does the model hold?


def test_a_model_that_fits_is_told_with_the_sum_of_its_residuals_and_its_chance() -> None:
    text, square = flat(found()), chi_square("fits", RADIUS)
    assert (
        "The model fits: neither the size of the residuals nor their order speaks against it. That does not prove it."
        in text
    )
    assert (
        f"chi^2 = {square:.5g} of 22 degrees of freedom; one as large or larger has a chance of {chi2.sf(square, 22):.3g} if "
        "the model holds."
    ) in text
    value = {x.parameter.name: x.value for x in found().estimates}
    left = (100 + 3j * W + SPREAD * (NOISE[0] + 1j * NOISE[1])) - value["k"] - 1j * value["b"] * W
    assert "does NOT fit" not in text
    assert "UNTESTED" not in text
    told = re.search(r"residuals of neighbouring lines correlate by (-?[\d.]+); so much or more has a chance of", text)
    assert told
    near = np.sum((left[1:] * left[:-1].conj()).real) / np.sum(abs(left) ** 2)
    assert float(told[1]) == pytest.approx(near, abs=0.1)
    assert "Lines of a Hann window" not in text


def test_a_model_that_does_not_fit_is_said_not_to_with_a_chance_below_what_doubles_hold() -> None:
    text, square = flat(found("does not")), chi_square("does not", RADIUS / 10)
    assert "The model does NOT fit what was measured. Its parameters are those nearest to it, and no more." in text
    assert f"chi^2 = {square:.5g} of 22 degrees of freedom" in text
    assert chi2.sf(square, 22) == 0
    assert "one as large or larger has a chance below 1e-300 if the model holds." in text
    assert "The model fits:" not in text


def test_without_discs_a_model_is_untested_and_its_errors_come_from_the_residuals() -> None:
    text = flat(found("no discs"))
    assert "UNTESTED: no discs of the lines are known, so that nothing tells how large the residuals may be." in text
    assert "their size is that of the residuals themselves. Nothing is said of other frequencies." in text
    assert "chi^2" not in text
    with_discs = flat(found())
    assert "if the discs are, and if neighbouring lines are independent; then the box holds the true values with a confidence of about 95 %." in with_discs  # fmt: skip
    assert "residuals themselves" not in with_discs


def test_a_model_that_is_refuted_by_the_order_of_residuals_alone_does_not_call_upon_discs_that_nobody_knows() -> None:
    """A spring and damper, of a response with a mass: residuals follow a parabola."""
    text = flat(found("another"))
    assert "The model does NOT fit what was measured." in text
    assert "chi^2" not in text
    assert "if the discs are" not in text
    assert "their size is that of the residuals themselves." in text


@pytest.mark.parametrize(("chance", "near", "advised"), [(0.5, 0.001, True), (0.5, 0.5, False), (0.001, 0.0001, False), (None, 0.001, True), (0.0163, 0.0162, False), (0.0168, 0.0162, True)])  # fmt: skip
def test_to_keep_every_second_line_is_advised_where_their_order_alone_speaks_against_the_model(
    chance: float | None,
    near: float,
    advised: bool,  # noqa: FBT001
) -> None:
    """Each of three tests has a third of what a confidence of 95 % leaves: 1/60."""
    seen = replace(found().verdict, chance=chance, neighbours_chance=near)
    text = flat(replace(found(), verdict=seen))
    assert ("Lines of a Hann window overlap: if these do, keep every second one" in text) == advised
    assert ("degrees of freedom; one as large" in text) == (chance is not None)
    without = flat(replace(found(), verdict=replace(seen, square=None, neighbours=None)))
    assert "if the model holds" not in without
    assert "if they are independent" not in without


# Numbers


def test_the_model_is_written_with_two_digits_more_than_the_best_told_parameter_has_certain_ones() -> None:
    """Of k = 99.87... +- 0.13 some three digits are certain."""
    base = found()
    k, b = sorted(base.estimates, key=lambda x: -x.value)
    for share in (3e-1, 2e-2, 3e-4, 2e-6, 1e-9, 0.0):
        changed = tuple(replace(x, error=share * x.value if x is k else 0.5 * x.value) for x in base.estimates)
        text = row(replace(base, estimates=changed), "fitted")
        told = re.search(r"H_perc\(s\) ≈ ([\d.]+) s \+ ([\d.]+)", text)
        assert told, text
        digits = {len(x.replace(".", "").strip("0")) for x in told.groups()}
        most = 8 if share < 1e-6 else max(2, 1 + ceil(-log10(share)))
        assert max(digits) <= most
        assert max(digits) >= most - 1  # zeros at the end are not told apart from digits
        for shown, true in zip(told.groups(), (b.value, k.value), strict=True):
            assert abs(float(shown) - true) <= max(share * true, 10.0 ** -(most - 2) * true)


def test_each_parameter_has_its_error_its_interval_and_its_side_of_the_box() -> None:
    shown = lines(found())
    assert "parameter value ± error 95 % interval box" in shown
    for x in found().estimates:
        unit = {"k": "N/m", "b": "N·s/m"}[x.parameter.name]
        told = re.fullmatch(
            r"([\d.]+) ([\d.]+) ([\d.]+) to ([\d.]+) ([\d.]+) to ([\d.]+) (\S+)", row(found(), x.parameter.name)
        )
        assert told
        value, error, low, high, least, most = map(float, told.groups()[:6])
        assert told[7] == unit
        assert (value, error) == pytest.approx((x.value, x.error), rel=0.05)
        assert low <= x.value - 1.95 * x.error
        assert high >= x.value + 1.95 * x.error
        assert least <= x.value - 2.24 * x.error
        assert most >= x.value + 2.24 * x.error
        assert least < low < value < high < most


@pytest.mark.slow
def test_parameters_with_one_name_are_told_by_their_paths() -> None:
    """A spring and damper behind a spring: two stiffnesses."""
    w = np.linspace(1, 80, 6)
    H = 1 / (1 / 500 + 1 / (100 + 3j * w))
    twice = hs.identify(hs.measured(w, H, radius=[0.1] * 6), "kelvin-voigt", "compliance")
    heads = [x.split()[0].strip("`") for x in lines(twice) if x]
    assert {"environment.k", "effects.compliance.k"} <= set(heads)
    assert "k" not in heads
    assert "environment.k" not in flat(found())


# What the lines tell


def test_two_parameters_that_only_their_sum_is_told_of_are_named_with_their_correlation() -> None:
    """Between 9.9 and 10.1 rad/s k - m w^2 tells little of either."""
    w = np.linspace(9, 11, 8)
    H = 200 - w**2 + 3j * w + 0.01 * (NOISE[0, :8] + 1j * NOISE[1, :8])
    close = flat(hs.identify(hs.measured(w, H, radius=[0.025] * 8), "mass-spring-damper"))
    told = re.search(r"(\w) and (\w) are told together more than apart: correlation ([\d.]+)\.", close)
    assert told
    assert {told[1], told[2]} == {"m", "k"}
    J = np.array([[1, -x * x] for x in w])
    C = np.linalg.inv(J.T @ J)
    assert float(told[3]) == pytest.approx(C[0, 1] / np.sqrt(C[0, 0] * C[1, 1]), abs=2e-3)
    assert "told together" not in flat(found())


def test_a_parameter_that_the_lines_do_not_tell_is_named_and_no_range_is_written() -> None:
    assert "The scene file (`--scene FILE`) has the box as its ranges, which `haptisym tolerances` takes." in flat(
        found()
    )
    H = 100 + 3j * W + SPREAD * (NOISE[0] + 1j * NOISE[1])
    lagging = flat(hs.identify(hs.measured(W, H, radius=[RADIUS] * 12), "kelvin-voigt", "first-order-lag"))
    assert "The lines do not tell ω_c: leave it out, or give it a value." in lagging
    assert "has values and no ranges: here a range would mean nothing." in lagging
    assert "The lines do not tell" not in flat(found())
    assert "has values and no ranges: here a range would mean nothing." in flat(found("does not"))


def test_lines_that_were_left_out_are_counted_and_starts_that_agreed_too() -> None:
    H = 100 + 3j * W + SPREAD * (NOISE[0] + 1j * NOISE[1])
    few = hs.identify(hs.measured(W, H, radius=[RADIUS] * 12), "kelvin-voigt", band=(2, 9))
    assert row(few, "left out") == "4 lines, off the band, at 0 rad/s or with no coherence at all"
    assert not [x for x in lines(found()) if x.startswith("left out")]
    fit = found().fit
    assert f"{fit.agreeing} of {fit.starts} starts ended in the same least sum; another may be lower" in flat(found())
    assert row(found(), "model") == "kelvin-voigt"
    assert row(found(), "measured") == "measured: 12 lines from 1 to 12 rad/s; radius in the file"
