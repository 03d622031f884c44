"""Where a ratio is largest, exactly, and thresholds that are irrational algebraic numbers."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest
from oracles import MP, rounded
from sympy import CRootOf, I, Rational, Symbol, pi, sqrt
from test_crossings import ask, paper

import haptisym as hs
from haptisym.effects import delay, first_order_lag, series
from haptisym.environments import mass_spring_damper

FU = hs.load_scene("fu2019").with_band(0, 1000)


def with_threshold(scene: hs.Scene, real: object, imag: object = 1) -> hs.Evaluation:
    return hs.evaluate(replace(scene, threshold=hs.Threshold(real, imag)))


def real_peak() -> hs.Peak:
    [peak] = [p for p in hs.peaks(FU) if p.part is hs.Part.REAL]
    return peak


def test_the_paper_s_ratio_peaks_where_the_derivative_at_fifty_digits_vanishes() -> None:
    omega = MP.findroot(lambda w: MP.diff(lambda x: paper().ratio("real", x), w), 109)
    peak = real_peak()
    assert peak.omega.digits(30) == rounded(omega, 30)
    assert peak.ratio.digits(30) == rounded(paper().ratio("real", omega), 30)


def test_a_threshold_at_the_very_peak_is_touched_there_and_nowhere_crossed() -> None:
    peak = real_peak()
    [touch] = with_threshold(FU, peak.threshold).crossings
    assert (touch.kind.value, touch.multiplicity, touch.omega.digits(40)) == ("touches", 2, peak.omega.digits(40))
    assert [(float(x.low.omega), float(x.high.omega)) for x in with_threshold(FU, peak.threshold).transparent] == [
        (0, 1000)
    ]


@pytest.mark.parametrize("part", [hs.Part.REAL, hs.Part.IMAG])
@pytest.mark.parametrize("seed", range(6))
def test_every_peak_of_a_random_scene_is_touched_by_a_threshold_of_its_height(part: hs.Part, seed: int) -> None:
    gain, corner = Rational(seed + 2, 7), Rational(3 * seed + 2, 2)
    scene = hs.Scene(
        mass_spring_damper(m=Rational(seed + 1, 5), b=4, k=90),
        (first_order_lag(corner), series(f"1 + {gain}*s/(s^2 + 2*s + 30)")),
        (0, 200),
    )
    for peak in (p for p in hs.peaks(scene) if p.part is part and p.ratio.digits(5) != "0"):
        limits = {p.value: peak.threshold if p is part else 1000 for p in hs.Part}
        result = hs.evaluate(replace(scene, threshold=hs.Threshold(**limits)))
        touched = [c for c in result.crossings if c.omega.digits(25) == peak.omega.digits(25)]
        assert [(c.kind.value, c.multiplicity) for c in touched] == [("touches", 2)]


def test_a_delayed_spring_peaks_where_the_sine_does() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (delay("0.1 s"),), (1, 40))
    assert [(p.part.value, p.omega.digits(15), p.ratio.digits(5), p.threshold) for p in hs.peaks(scene)] == [
        ("imag", rounded(5 * MP.pi, 15), "1.0000", None),
        ("real", rounded(10 * MP.pi, 15), "2.0000", None),
    ]


GOLDEN = (sqrt(5) - 1) / 2
ROOT = CRootOf(Symbol("x") ** 5 - Symbol("x") + Rational(1, 7), 2)


@pytest.mark.parametrize("c", [GOLDEN, ROOT, sqrt(2) + sqrt(3) - 3, sqrt(2) / 10])
def test_an_irrational_threshold_is_crossed_between_rational_ones_a_hair_beside_it(c: object) -> None:
    about = Fraction(str(c.evalf(60)))
    results = [
        with_threshold(FU, value, value) for value in (about - Fraction(1, 10**50), c, about + Fraction(1, 10**50))
    ]
    below, exact, above = ([(x.part, x.kind, x.omega) for x in r.crossings] for r in results)
    assert len(below) == len(exact) == len(above) > 0
    for (part, kind, low), (part_, kind_, x), (_, _, high) in zip(below, exact, above, strict=True):
        assert (part, kind) == (part_, kind_)
        first, middle, last = (Decimal(number.digits(70)) for number in (low, x, high))
        assert first < middle < last or last < middle < first
        assert abs(last - first) < Decimal("1e-40")


def test_irrational_thresholds_print_as_decimals_and_typeset() -> None:
    result = with_threshold(FU, real_peak().threshold)
    assert "r_r touches 136.706 %" in str(result)
    assert r"\approx 1.36706324889" in hs.latex(result)


@pytest.mark.parametrize("c", [-sqrt(2), I, sqrt(-2), pi * sqrt(2), 1 - sqrt(2)])
def test_a_threshold_must_be_a_positive_number(c: object) -> None:
    with pytest.raises(hs.SceneError, match="real: "):
        hs.Threshold(c)


def test_an_irrational_threshold_is_refused_where_the_scene_is_not_rational() -> None:
    with pytest.raises(hs.SceneError, match="without delays"):
        ask(mass_spring_damper(k=1), delay("0.1 s"), c=GOLDEN)
