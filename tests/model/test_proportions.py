"""Thresholds at another proportion of right answers: the cumulative Gaussian of Jones, Hunter and Lafontaine's two numbers."""

from __future__ import annotations

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Rational

import haptisym as hs
from haptisym.model.jndtables import read_threshold
from haptisym.model.proportions import DIGITS, Conversion

PAPER = hs.load_scene("fu2019")
AT_75 = {"real": 0.1, "imag": 0.1, "proportion": 0.75}


def with_jnd(jnd: object) -> hs.Scene:
    return hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, jnd)


def test_two_different_jnds_of_one_paper_are_one() -> None:
    """19 % at 71 % right answers is 34.14 % at 84 %."""
    found = read_threshold({"real": 0.19, "imag": 0.19, "proportion": 0.71}).at_proportion(0.84)
    assert float(found.real) == pytest.approx(0.3414387697, abs=1e-10)


@given(st.integers(51, 99), st.integers(51, 99))
def test_the_factor_is_the_quotient_of_two_quantiles_to_all_its_digits(start: int, end: int) -> None:
    p, q = Rational(start, 100), Rational(end, 100)
    mp = mpmath.mp.clone()
    mp.dps = 60
    one, other = (mp.erfinv(2 * mp.mpf(n) / 100 - 1) for n in (start, end))
    found = Conversion(p, q).factor
    assert abs(mp.mpf(int(found.p)) / int(found.q) - other / one) <= abs(other / one) * mp.mpf(10) ** (1 - DIGITS)


def test_the_papers_example_at_84_percent_loses_the_crossing_of_its_real_part() -> None:
    [crossing] = hs.evaluate(with_jnd(AT_75), proportion="84 %").crossings
    assert crossing.criterion.name == "imag"
    assert float(crossing.omega) == pytest.approx(14.5345990489774, rel=1e-14)
    [rounded] = hs.evaluate(with_jnd(0.14744)).crossings  # the reference's digits are those of the rounded c
    assert float(rounded.omega) == pytest.approx(14.534683158, abs=5e-10)


def test_a_region_is_scaled_as_a_whole() -> None:
    c = Conversion(Rational(3, 4), Rational(21, 25)).factor
    tilted = read_threshold(
        {"shape": "ellipse", "real": 0.1, "imag": "0.1 + omega/50", "tilt": 0.5, "proportion": 0.75}
    )
    found = tilted.at_proportion(0.84)
    assert (found.real, found.region.tilt) == (c / 10, Rational(1, 2))
    assert (found.imag - tilted.imag * c).expand() == 0
    corners = [[0.1, 0], [0, 0.1], [-0.1, -0.1]]
    polygon = read_threshold({"shape": "polygon", "corners": corners, "proportion": 0.75}).at_proportion(0.84)
    assert polygon.region.corners[0] == (c / 10, 0)
    sided = read_threshold({"real": {"higher": 0.1, "lower": 0.2}, "imag": 0.1, "floor": 2, "proportion": 0.75})
    assert sided.at_proportion(0.84).region.numbers == {"real: lower": c / 5, "floor": 2 * c}


def test_the_document_tells_the_conversion_and_how_exact_it_is() -> None:
    row = hs.evaluate(with_jnd(AT_75), proportion=0.84).to_dict()["threshold"]
    assert row["proportion"] == 0.84
    assert row["conversion"]["factor"].startswith("1.4743854638571647")
    low, high = map(Rational, row["conversion"]["enclosure"])
    assert 0 < high - low < Rational(1, 10**DIGITS)
    assert "brought from" in str(hs.evaluate(with_jnd(AT_75), proportion=0.84))


@pytest.mark.parametrize(
    ("jnd", "proportion", "told"),
    [
        (0.1, 0.84, "does not tell its own"),
        (AT_75, 0.5, "above 0.5"),
        (AT_75, 1, "below 1"),
        (AT_75, "x", "proportion"),
        ({**AT_75, "proportion": 0.4}, 0.84, "above 0.5"),
    ],
)
def test_what_cannot_be_converted_is_told(jnd: object, proportion: object, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.evaluate(with_jnd(jnd), proportion=proportion)
