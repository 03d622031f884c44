"""Where a ratio is largest, exactly, and thresholds that are irrational algebraic numbers."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest
from oracles import MP, rounded
from paper import ask, paper
from sympy import CRootOf, Expr, I, Integer, Rational, Symbol, exp, pi, sqrt

import haptisym as hs
from haptisym.effects import delay, first_order_lag, series, shunt
from haptisym.environments import mass_spring_damper
from haptisym.judge.peaks import largest, tops
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction, on_axis

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


@pytest.mark.few(3)
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
    assert r"$r_r$ touches 136.706~\%" in hs.latex(result)


@pytest.mark.parametrize("c", [-sqrt(2), I, sqrt(-2), pi * sqrt(2), 1 - sqrt(2)])
def test_a_threshold_must_be_a_positive_number(c: object) -> None:
    with pytest.raises(hs.SceneError, match="real: "):
        hs.Threshold(c)


@pytest.mark.parametrize("c", ["0.1 +- 150 %", "0.1 +- 100 %", 0, "-0.1"])
def test_a_threshold_is_positive_all_over_its_range(c: object) -> None:
    for limits, key in (((c, "0.1"), "real"), (("0.1", c), "imag")):
        with pytest.raises(hs.SceneError, match=f"{key}: .* must be > 0"):
            hs.Threshold.of(*limits)


def test_an_irrational_threshold_is_refused_where_the_scene_is_not_rational() -> None:
    with pytest.raises(hs.SceneError, match="without delays"):
        ask(mass_spring_damper(k=1), delay("0.1 s"), c=GOLDEN)


def test_a_pole_of_a_ratio_is_no_peak_and_a_maximum_at_an_end_of_the_band_is_none() -> None:
    """An undamped environment, where a damper beside it has an infinite ratio at 2 rad/s; a ratio that only grows."""
    unbounded = hs.Scene(mass_spring_damper(m=1, k=4), (shunt(b=1),), (0, 10))
    assert [float(x.omega) for x in hs.evaluate(unbounded).unbounded] == [2.0]
    assert hs.peaks(unbounded) == ()
    growing = hs.Scene(mass_spring_damper(k=100), (shunt(m=1),), (0, 10))
    assert hs.peaks(growing) == ()


def test_a_maximum_of_higher_order_is_one_peak_and_an_inflection_is_none() -> None:
    """|1 - (W - 4)^4/1000| peaks flatly at 2; W + (W - 4)^3 only grows, with slope 0 nowhere; (W - 4)^3 + 64 rests at 2."""
    flat = hs.Scene(mass_spring_damper(k=1), (shunt(Z="1 - (-s^2 - 4)^4/1000"),), (1, 3))
    [peak] = hs.peaks(flat)
    assert (peak.part, float(peak.omega), peak.ratio.digits(5), peak.threshold) == (hs.Part.REAL, 2.0, "1.0000", 1)
    resting = hs.Scene(mass_spring_damper(k=1), (shunt(Z="64 + (-s^2 - 4)^3"),), (0, 3))
    assert hs.peaks(resting) == ()


def test_peaks_next_to_the_ends_of_the_band_are_there() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (series("1 + 0.4*s/(s^2 + 2*s + 9)"),))
    wide = [(p.part, p.omega.digits(12)) for p in hs.peaks(scene)]
    assert len(wide) == 3
    for band in (("2.16", "4.17"), ("2.1", "4.2"), ("0", "100"), ("2", "1000")):
        assert [(p.part, p.omega.digits(12)) for p in hs.peaks(scene.with_band(*band))] == wide
    assert [(p.part, p.omega.digits(12)) for p in hs.peaks(scene.with_band("2.17", "4.16"))] == wide[1:2]


@pytest.mark.slow
def test_the_height_of_a_peak_in_closed_form_is_the_number_that_its_digits_are() -> None:
    """Several roots of the same minimal polynomial, some of them negative: the index tells which."""
    gains = [
        "1 + 3/7*s/(s^2 + 2*s + 30)",
        "1 - 2*(s + 1)/(s^3 + 2*s^2 + 30*s + 7)",
        "1 + s^2/(s^4 + s^3 + 20*s^2 + 3*s + 40)",
    ]
    count = 0
    for gain in gains:
        scene = hs.Scene(mass_spring_damper(m="1/5", b=4, k=90), (first_order_lag("7/2"), series(gain)), (0, 200))
        for peak in hs.peaks(scene):
            count += 1
            assert peak.threshold is not None
            assert Decimal(str(peak.threshold.evalf(30))) == pytest.approx(
                Decimal(peak.ratio.digits(30)), rel=Decimal("1e-25")
            )
    assert count >= 4


@pytest.mark.parametrize("what", ["pi", "delay", "both"])
def test_the_height_of_a_peak_has_no_closed_form_where_numbers_or_functions_are_not_rational(what: str) -> None:
    chain = {
        "pi": (first_order_lag("1 Hz"), series("1 + s/(s^2 + 2*s + 30)")),
        "delay": (delay("0.1 s"),),
        "both": (first_order_lag("1 Hz"), delay("0.1 s")),
    }[what]
    found = hs.peaks(hs.Scene(mass_spring_damper(m=1, b=4, k=90), chain, (0, 40)))
    assert found
    assert [p.threshold for p in found] == [None] * len(found)


def test_the_largest_value_is_at_an_end_at_a_zero_or_at_a_peak() -> None:
    def at_most(expression: Expr, low: int, high: int) -> str:
        return largest(RealFunction(Ring().axis.convert(expression)), Integer(low), Integer(high)).digits(6)

    w = hs.omega
    assert at_most(w**2, 1, 3) == "9.00000"
    assert at_most(1 / (w**2 + 1), 1, 3) == "0.500000"
    assert at_most(-((w**2 - 4) ** 2), 1, 3) == "0"
    assert at_most(-(w**2) - 1, 0, 3) == "-1.00000"
    assert at_most(w / (w**2 + 4), 0, 5) == "0.250000"
    assert at_most(w**2 - 4, 2, 3) == "5.00000"
    assert largest(RealFunction(Ring().axis.convert(-1 / (w**2 - 4) ** 2)), Integer(0), Integer(3)) is None


def test_the_tops_of_a_function_are_its_ends_and_its_local_maxima() -> None:
    def all_of(expression: Expr, low: int, high: int) -> list[tuple[str, str, bool | None]]:
        found = tops(RealFunction(Ring().axis.convert(expression)), Integer(low), Integer(high))
        assert found is not None
        return [(x.omega.digits(3), x.value.digits(4), x.end) for x in found]

    W = hs.omega**2
    assert all_of(W, 1, 3) == [("1.00", "1.000", False), ("3.00", "9.000", True)]
    assert all_of(-((W - 4) ** 2), 1, 3) == [("1.00", "-9.000", False), ("2.00", "0", None), ("3.00", "-25.00", True)]
    assert all_of((W - 4) ** 2, 1, 3) == [("1.00", "9.000", False), ("3.00", "25.00", True)]
    assert all_of((W - 4) ** 3, 1, 3) == [("1.00", "-27.00", False), ("3.00", "125.0", True)]
    assert all_of(W - 4, 2, 3) == [("2.00", "0", False), ("3.00", "5.000", True)]
    assert all_of(1 - (W - 1) ** 2 * (W - 4) ** 2, 0, 3) == [
        ("0", "-15.00", False), ("1.00", "1.000", None), ("2.00", "1.000", None), ("3.00", "-1599", True)
    ]  # fmt: skip
    assert all_of(Integer(7) + 0 * W, 0, 3) == [("0", "7.000", False), ("3.00", "7.000", True)]
    assert tops(RealFunction(Ring().axis.convert(1 / (W - 4))), Integer(0), Integer(3)) is None


def test_a_slope_that_nearly_vanishes_leaves_open_whether_there_is_a_top() -> None:
    """omega + sin(omega) + ..., whose slope 1 + cos(omega) + (W - pi^2)^2 touches 0 at pi."""
    f = (1 + pi**4) * hs.s + 2 * pi**2 / 3 * hs.s**3 + hs.s**5 / 5 - exp(-hs.s)
    rising = on_axis(Ring.of([f]).convert(f)).imag
    with pytest.raises(hs.UndecidedError, match="local maximum where its slope nearly vanishes"):
        tops(rising, Integer(1), Integer(5))
    found = tops(rising, Integer(4), Integer(5))
    assert found is not None
    assert [x.end for x in found] == [False, True]


def test_peaks_are_told_in_a_document_and_in_a_line_each() -> None:
    """Re G = 1 + 0.4 (2 w^2)/((9 - w^2)^2 + 4 w^2) is largest at 3 rad/s, 1.2."""
    gain = hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)")
    found = hs.peaks(hs.Scene(hs.environments.mass_spring_damper(k=100), (gain,), (0, 15)))
    assert repr(found) == '<Peaks "Untitled scene": 3 peaks>'
    real = found[1]
    assert repr(real) == "<Peak r_r = 0.200000 at 3.00000 rad/s>"
    row = found.to_dict()["peaks"][1]
    assert row == {
        "part": "real", "omega": 3.0, "digits": "3.00000000000000", "enclosure": list(real.omega.enclosure()), "ratio": 0.2,
        "ratio_digits": "0.200000000000000",
    }  # fmt: skip
    assert [x["part"] for x in found.to_dict()["peaks"]] == ["imag", "real", "imag"]
    assert (found.to_dict()["band"], found.to_dict()["certified"], "undecided" in found.to_dict()) == (
        [0, 15],
        True,
        False,
    )
    disc = hs.peaks(
        hs.Scene(
            hs.environments.mass_spring_damper(k=100), (gain,), (0, 15), {"shape": "ellipse", "real": 0.1, "imag": 0.1}
        )
    )
    [one] = disc
    assert (one.in_limits, one.threshold, one.ratio.digits(5)) == (True, None, "2.0000")
    open_ = hs.Peaks(found.scene, found, [ExactNumber(Integer(2))])
    assert (open_.certified, open_.to_dict()["undecided"]) == (False, [list(ExactNumber(Integer(2)).enclosure())])
