"""Where ratios are largest, and all bandwidths that a range of thresholds gives: against closed forms, samples, and exact evaluations of single thresholds."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise, product
from math import pi as float_pi
from math import sqrt as root
from random import Random
from typing import Any

import numpy as np
import pytest
from certificates import region_scene
from flint import fmpq, fmpq_poly
from hypothesis import assume, given
from hypothesis import strategies as st
from oracles import MP, Case, rounded
from paper import paper
from regions import enlarged, number, outside
from strategies import Drawn, cases, coincident_case, scene
from sympy import Expr, Integer, Rational, exp, lambdify, pi, sqrt

import haptisym as hs
from haptisym.effects import delay, first_order_lag, series, shunt
from haptisym.environments import mass_spring_damper
from haptisym.judge.bindings import Kind
from haptisym.judge.peaks import largest_value, maximum_candidates, supremum
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.rings import omega as w

PAPER = hs.load_scene("fu2019")
FU = PAPER.with_band(0, 1000)
BAND = (Integer(1), Integer(9))


def real(x: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(x.together()).reduced())


def on_a_spring(Z: str, jnd: Any, band: tuple[Any, Any]) -> hs.Scene:
    """Of even powers of s, W for -s^2, r_r is the modulus; of odd ones r_i."""
    return hs.Scene(mass_spring_damper(k=1), (shunt(Z=Z.replace("W", "(-s^2)")),), band, jnd)


# --- peaks -----------------------------------------------------------------------------------------------------------


def real_peak() -> hs.Peak:
    [peak] = [p for p in hs.peaks(FU) if p.part is hs.Part.REAL]
    return peak


def test_the_paper_s_ratio_peaks_where_the_derivative_at_fifty_digits_vanishes() -> None:
    omega = MP.findroot(lambda w: MP.diff(lambda x: paper().ratio("real", x), w), 109)
    peak = real_peak()
    assert peak.omega.digits(30) == rounded(omega, 30)
    assert peak.ratio.digits(30) == rounded(paper().ratio("real", omega), 30)


def test_a_threshold_at_the_very_peak_is_touched_there_and_nowhere_crossed() -> None:
    """r_i of a lag is w/(1 + w^2), largest, 1/2, at the corner frequency."""
    scene = hs.Scene(mass_spring_damper(k=100), (first_order_lag(30),), (0, 1000), hs.Threshold(2, Rational(1, 2)))
    [peak] = (x for x in hs.peaks(scene) if x.part is hs.Part.IMAG)
    result = hs.evaluate(scene)
    [touch] = result.crossings
    assert (touch.kind.value, touch.multiplicity, touch.omega.digits(40)) == ("touches", 2, peak.omega.digits(40))
    assert [(float(x.low.omega), float(x.high.omega)) for x in result.transparent] == [(0, 1000)]


@pytest.mark.dear("4-Part.IMAG", "4-Part.REAL")
@pytest.mark.few(3)
@pytest.mark.parametrize("part", [hs.Part.REAL, hs.Part.IMAG])
@pytest.mark.parametrize("seed", range(6))
def test_every_peak_of_a_random_scene_is_between_two_crossings_of_a_threshold_just_below_its_height(
    part: hs.Part, seed: int
) -> None:
    gain, corner = Rational(seed + 2, 7), Rational(3 * seed + 2, 2)
    scene = hs.Scene(
        mass_spring_damper(m=Rational(seed + 1, 5), b=4, k=90),
        (first_order_lag(corner), series(f"1 + {gain}*s/(s^2 + 2*s + 30)")),
        (0, 200),
    )
    peaks = [p for p in hs.peaks(scene) if p.part is part and p.ratio.digits(5) != "0"]
    assert peaks
    for peak in peaks:
        height, at = Rational(peak.ratio.digits(30)), float(peak.omega)
        for share, beside in ((-1, [-1, 1]), (1, [])):
            limits = {p.value: height * (1 + share * Rational(1, 10**14)) if p is part else 1000 for p in hs.Part}
            near = (c.omega for c in hs.evaluate(replace(scene, threshold=hs.Threshold(**limits))).crossings)
            assert [1 if x > at else -1 for x in map(float, near) if abs(x - at) < 1e-4 * at] == beside


def test_a_delayed_spring_peaks_where_the_sine_does() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (delay("0.1 s"),), (1, 40))
    assert [(p.part.value, p.omega.digits(15), p.ratio.digits(5)) for p in hs.peaks(scene)] == [
        ("imag", rounded(5 * MP.pi, 15), "1.0000"),
        ("real", rounded(10 * MP.pi, 15), "2.0000"),
    ]


def test_peaks_next_to_the_ends_of_the_band_are_there() -> None:
    scene = hs.Scene(mass_spring_damper(k=100), (series("1 + 0.4*s/(s^2 + 2*s + 9)"),))
    wide = [(p.part, p.omega.digits(12)) for p in hs.peaks(scene)]
    assert len(wide) == 3
    for band in (("2.16", "4.17"), ("2.1", "4.2"), ("0", "100"), ("2", "1000")):
        assert [(p.part, p.omega.digits(12)) for p in hs.peaks(scene.with_band(*band))] == wide
    assert [(p.part, p.omega.digits(12)) for p in hs.peaks(scene.with_band("2.17", "4.16"))] == wide[1:2]


def needed(jnd: Any, H: complex, G: complex, omega: float) -> dict[str, float]:
    """How many times a region must be enlarged."""
    if jnd.get("shape") not in ("ellipse", "diamond"):
        return enlarged(jnd, H, G, omega)
    beyond, t = outside(jnd, (G - H).real / abs(H), (G - H).imag / abs(H), omega), number(jnd.get("tilt", 0), omega)
    return {"joint": 1 + beyond if jnd["shape"] == "diamond" else root(1 + beyond / (1 - t**2))}


@pytest.mark.few("1", "8", "19")
@pytest.mark.parametrize("seed", range(40))
def test_peaks_of_a_region_are_where_samples_of_how_many_times_it_must_be_enlarged_have_them(seed: int) -> None:
    text = region_scene(seed)
    plain, jnd = hs.parse_scene(text), tomllib.loads(text)["evaluation"]["jnd"]
    asked = hs.Scene(plain.environment, plain.effects, plain.band, jnd, rendered=plain.rendered)
    curve = asked.distortion().compile()

    def at(omega: Any) -> dict[str, Any]:
        v = curve(np.asarray(omega))
        rows = zip(
            v.environment_real + 1j * v.environment_imag, v.perceived_real + 1j * v.perceived_imag, omega, strict=True
        )
        found = [needed(jnd, *x) for x in rows]
        return {key: np.array([x[key] for x in found]) for key in found[0]}

    grid = np.linspace(*(float(x) for x in plain.band), 121)[1:]
    sampled, found = at(grid), hs.peaks(asked)
    infinite = [float(x.omega) for x in hs.evaluate(asked).unbounded]
    for key, ratio in sampled.items():
        told = [x for x in found if x.criterion.name == key]
        for i in range(1, len(grid) - 1):
            if ratio[i] > max(ratio[i - 1], ratio[i + 1]) + 1e-9:
                assert any(grid[i - 1] <= x <= grid[i + 1] for x in [*(float(y.omega) for y in told), *infinite]), (
                    key,
                    i,
                )
        for x in told:
            beside = at(float(x.omega) * np.array([1 - 1e-9, 1, 1 + 1e-9]))[key]
            assert beside.max() * (1 if x.in_limits else number(jnd[key], 0)) == pytest.approx(float(x.ratio), rel=1e-3)
            assert x.jump or min(beside[1] - beside[0], beside[1] - beside[2]) > -1e-9 * beside[1]


POLES: dict[Expr, tuple[Rational, int] | None] = {
    1 / (w - 1): None, 1 / (9 - w): None, 1 / (w - 4): None, 1 / (4 - w): None, 1 / (w - 4) ** 2: None, 1 / (w - 1) ** 2: None, 1 / (w - 9) ** 2: None,
    1 / (1 - w): (Rational(-1, 8), 9), 1 / (w - 9): (Rational(-1, 8), 1), -1 / (w - 4) ** 2: (Rational(-1, 25), 9), -1 / (w - 6) ** 2: (Rational(-1, 25), 1),
    -1 / (w - 1) ** 2: (Rational(-1, 64), 9), -1 / (w - 9) ** 2: (Rational(-1, 64), 1), 1 / (w - 1) - 1 / (w - 9): None, 1 / (1 - w) + 1 / (w - 9): (Rational(-1, 2), 5),
    1 / (1 - w) - 1 / (w - 9): None, 1 / (w - 1) + 1 / (w - 9): None,
}  # fmt: skip
"""On [1, 9] with its largest value and where; None where it grows beyond everything in it."""


FINITE: dict[Expr, tuple[Expr, Expr]] = {
    -((w**2 - 3) ** 2): (Integer(0), sqrt(3)), -((w - 1) ** 2): (Integer(0), Integer(1)), w - 9: (Integer(0), Integer(9)), 1 - w: (Integer(0), Integer(1)),
    w * (8 - w): (Integer(16), Integer(4)), 7 + 0 * w: (Integer(7), Integer(1)), -w * (8 - w): (Integer(9), Integer(9)), 0 * w: (Integer(0), Integer(1)),
    (w - 5) ** 3: (Integer(64), Integer(9)), -((w - 5) ** 4) - 2: (Integer(-2), Integer(5)),
}  # fmt: skip


@pytest.mark.parametrize("x", POLES, ids=str)
def test_what_grows_beyond_everything_inside_of_a_band_has_no_largest_value_and_what_falls_there_has(x: Expr) -> None:
    expected, found = POLES[x], supremum(real(x), *BAND)
    assert maximum_candidates(real(x), *BAND) is None
    assert largest_value(real(x), *BAND) is None
    if expected is None:
        assert found is None
        return
    assert found is not None
    assert found.omega is not None
    assert (float(found.value), float(found.omega)) == (pytest.approx(float(expected[0]), rel=1e-15), expected[1])


@pytest.mark.parametrize("x", FINITE, ids=str)
def test_the_largest_value_is_told_at_zeros_and_where_nothing_changes_too(x: Expr) -> None:
    value, place = FINITE[x]
    found, own = supremum(real(x), *BAND), largest_value(real(x), *BAND)
    assert found is not None
    assert found.omega is not None
    assert own is not None
    assert float(found.value) == float(own) == float(value)
    if x.has(w):
        assert float(found.omega) == pytest.approx(float(place), rel=1e-15)


GRID = np.linspace(1.0, 9.0, 8001)


def samples(x: Expr) -> Any:
    return np.broadcast_to(lambdify(w, x, "numpy")(GRID), GRID.shape)


def hill(draw: random.Random) -> Expr:
    """A square of a ratio: a slope with resonances."""
    found = Rational(draw.randint(1, 9), 10) + w * Rational(draw.randint(-1, 6), 20)
    for _ in range(draw.randint(1, 2)):
        at, size = Rational(draw.randint(9, 80), 8), Rational(draw.randint(2, 20), 10)
        found += size / (1 + 4 * (w - at) ** 2)
    return found.together() ** 2


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(20))
def test_the_largest_value_on_a_band_is_that_of_samples(seed: int) -> None:
    draw = random.Random(seed)
    x = hill(draw) - hill(draw) + Rational(draw.randint(-9, 9), 3)
    f, own = real(x), samples(x)
    top = largest_value(f, *BAND)
    assert top is not None
    assert abs(float(top) - own.max()) < 1e-3
    best = supremum(f, *BAND)
    assert best is not None
    assert best.omega is not None
    assert abs(float(best.value) - own.max()) < 1e-3
    assert abs(float(lambdify(w, x)(float(best.omega))) - own.max()) < 1e-3
    listed = maximum_candidates(f, *BAND)
    assert listed is not None
    assert [t.kind for t in listed if t.kind is not Kind.TOUCH] == [Kind.START, Kind.EDGE]
    inside = [GRID[i] for i in range(1, len(GRID) - 1) if own[i - 1] < own[i] > own[i + 1]]
    told = [float(t.omega) for t in listed if t.kind is Kind.TOUCH]
    assert len(told) == len(inside)
    assert np.allclose(told, inside, atol=0.002)
    for sign, bound in ((1, None), (-1, 0)):
        pole = real(x + sign / (w - 4) ** 2)
        assert largest_value(pole, *BAND) is None
        assert (supremum(pole, *BAND) is None) == (bound is None)
        one_sided = real(x + sign / (w - 4))
        assert supremum(one_sided, *BAND) is None
        assert (
            supremum(one_sided, Integer(4), Integer(9)) is None
            if sign > 0
            else supremum(one_sided, Integer(1), Integer(4)) is None
        )
        low, high = (1, 4) if sign > 0 else (4, 9)
        beside = supremum(one_sided, Integer(low), Integer(high))  # it falls without bound at one end
        assert beside is not None
        at = np.linspace(low, high, 20_001)[slice(0, -1) if sign > 0 else slice(1, None)]
        assert abs(float(beside.value) - lambdify(w, x + sign / (w - 4))(at).max()) < 1e-3


def test_the_tops_of_a_function_are_its_ends_and_its_local_maxima() -> None:
    def all_of(expression: Expr, low: int, high: int) -> list[tuple[str, str, Kind]]:
        found = maximum_candidates(RealFunction(Ring().axis.convert(expression)), Integer(low), Integer(high))
        assert found is not None
        return [(x.omega.digits(3), x.value.digits(4), x.kind) for x in found]

    W = hs.omega**2
    START, EDGE, TOUCH = Kind.START, Kind.EDGE, Kind.TOUCH
    assert all_of(W, 1, 3) == [("1.00", "1.000", START), ("3.00", "9.000", EDGE)]
    assert all_of(-((W - 4) ** 2), 1, 3) == [("1.00", "-9.000", START), ("2.00", "0", TOUCH), ("3.00", "-25.00", EDGE)]
    assert all_of((W - 4) ** 2, 1, 3) == [("1.00", "9.000", START), ("3.00", "25.00", EDGE)]
    assert all_of((W - 4) ** 3, 1, 3) == [("1.00", "-27.00", START), ("3.00", "125.0", EDGE)]
    assert all_of(W - 4, 2, 3) == [("2.00", "0", START), ("3.00", "5.000", EDGE)]
    assert all_of(1 - (W - 1) ** 2 * (W - 4) ** 2, 0, 3) == [
        ("0", "-15.00", START), ("1.00", "1.000", TOUCH), ("2.00", "1.000", TOUCH), ("3.00", "-1599", EDGE)
    ]  # fmt: skip
    assert all_of(Integer(7) + 0 * W, 0, 3) == [("0", "7.000", START), ("3.00", "7.000", EDGE)]
    assert maximum_candidates(RealFunction(Ring().axis.convert(1 / (W - 4))), Integer(0), Integer(3)) is None


def test_a_slope_that_nearly_vanishes_leaves_open_whether_there_is_a_top() -> None:
    """omega + sin(omega) + ..., whose slope 1 + cos(omega) + (W - pi^2)^2 touches 0 at pi."""
    f = (1 + pi**4) * hs.s + 2 * pi**2 / 3 * hs.s**3 + hs.s**5 / 5 - exp(-hs.s)
    rising = on_axis(Ring.of([f]).convert(f)).imag
    with pytest.raises(hs.UndecidedError, match="local maximum where its slope nearly vanishes"):
        maximum_candidates(rising, Integer(1), Integer(5))
    found = maximum_candidates(rising, Integer(4), Integer(5))
    assert found is not None
    assert [x.kind for x in found] == [Kind.START, Kind.EDGE]


# --- ranges of thresholds --------------------------------------------------------------------------------------------


RESONANT = hs.Scene(mass_spring_damper(k=100), (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),), (0, 40))
"""G - 1 runs on a circle: the real part peaks at 3 rad/s with 1/5, the imaginary part twice with 1/10, where the real part has 1/10 too."""


def ranged(scene: hs.Scene, real: Any, imag: Any = None) -> hs.Evaluation:
    return hs.evaluate(replace(scene, threshold=hs.Threshold.of(real, imag)))


def width(scene: hs.Scene, real: Any, imag: Any = None) -> Fraction | None:
    """The bandwidth that the plain evaluation has for one threshold, to 150 bits."""
    found = ranged(scene, real, imag).bandwidth
    return None if found is None else sum(found.bounds(150), Fraction(0)) / 2


def reached(found: hs.Evaluation, x: Fraction) -> bool:
    """Whether a bandwidth is among those that are said to be, to 100 bits."""
    all_, near = found.bandwidths, Fraction(1, 1 << 90) * max(x, Fraction(1, 1000))
    ends = [sum(y.bounds(150), Fraction(0)) / 2 for y in (all_.least, all_.most)]
    gaps = [[sum(y.bounds(150), Fraction(0)) / 2 for y in (jump.low, jump.high)] for jump in all_.jumps]
    return ends[0] - near <= x <= ends[1] + near and not any(low + near < x < high - near for low, high in gaps)


def test_the_papers_example_has_the_bandwidths_between_those_of_the_ends() -> None:
    found = ranged(hs.load_scene("fu2019"), "0.10 +- 0.02").bandwidths
    assert found.least.digits(16) == "6.533581844485885"
    assert found.most.digits(16) == ranged(hs.load_scene("fu2019"), "0.12").bandwidth.digits(16) == "12.99301407693839"
    assert (found.jumps, found.blocked, found.certified) == ((), {}, True)


def test_a_document_has_every_number_of_the_bandwidths_within_its_enclosure_and_null_where_there_is_none() -> None:
    softer = hs.Scene(
        mass_spring_damper(k=100), (hs.effects.series("1 - 0.1/(1 + s)"),), (0, 40)
    )  # r_r falls from 1/10 on
    row, blocked = (ranged(x, ["0.05", "0.29"]).bandwidths.row(12) for x in (RESONANT, softer))
    [jump] = row["jumps"]
    for told, true in (
        (row["least"], width(RESONANT, "0.05")), (row["most"], 40), (jump["from"], 3), (jump["to"], 40), (jump["threshold"], Fraction(1, 5)),
        (blocked["none_below"]["jnd"], Fraction(1, 10)), (blocked["least"], 40),
    ):  # fmt: skip
        low, high = map(Fraction, told["enclosure"])
        assert low - Fraction(1, 10**40) <= true <= high + Fraction(1, 10**40)
        assert high - low <= true / 10**11
        assert abs(Fraction(told["digits"]) - true) <= true / 10**11
        assert told["value"] == float(true)
    rising = hs.Scene(mass_spring_damper(k=100), (hs.effects.series("1.1 + 0.1*s"),), (0, 40))  # r_r is 1/10 everywhere
    none = ranged(rising, ["0.02", "0.05"]).bandwidths.row(12)
    assert (none["least"], none["most"], none["jumps"]) == (None, None, [])


def test_the_bandwidth_jumps_over_a_peak_and_the_threshold_of_the_peak_gives_the_far_side() -> None:
    found = ranged(RESONANT, ["0.05", "0.29"]).bandwidths
    [jump] = found.jumps
    assert (jump.low.digits(20), jump.high.digits(20), jump.threshold.digits(20)) == (
        "3" + "." + "0" * 19,
        "4" + "0." + "0" * 18,
        "0.2" + "0" * 19,
    )
    assert width(RESONANT, "0.2") == 40
    assert width(RESONANT, Fraction(1, 5) - Fraction(1, 10**30)) < 3
    assert 3 - width(RESONANT, Fraction(1, 5) - Fraction(1, 10**30)) < Fraction(1, 10**10)


def test_an_end_of_the_range_at_the_very_peak_gives_the_far_side_or_the_jump_alone() -> None:
    below, at, above = (
        ranged(RESONANT, ["0.05", "0.19"]),
        ranged(RESONANT, ["0.05", "0.2"]),
        ranged(RESONANT, ["0.2", "0.3"]),
    )
    assert (below.bandwidths.jumps, above.bandwidths.jumps, len(at.bandwidths.jumps)) == ((), (), 1)
    assert float(at.bandwidths.most) == float(above.bandwidths.least) == 40


def test_peaks_of_one_height_leave_open_what_lies_between_the_ends_and_a_peak_that_another_ratio_passes_is_none() -> (
    None
):
    """Of the imaginary part alone two are 1/10 high; for one number the real part is as high and rising at the first."""
    alone = ranged(RESONANT, 1, ["0.05", "0.3"]).bandwidths
    assert (alone.certified, alone.undecided) == (False, "whether two peaks of the ratios are equally high")
    assert (middle(alone.least), middle(alone.most)) == (width(RESONANT, 1, "0.05"), 40)
    together = ranged(RESONANT, ["0.05", "0.15"]).bandwidths
    assert together.jumps == ()
    assert together.certified


def test_no_threshold_below_the_ratio_at_the_low_end_gives_a_bandwidth() -> None:
    softer = hs.Scene(mass_spring_damper(k=100), (hs.effects.series("1 - 0.1/(1 + s)"),), (0, 40))
    found = ranged(softer, ["0.05", "0.2"]).bandwidths  # r_r falls from 1/10 on, r_i rises to 1/20
    assert found.blocked["jnd"].digits(10) == "0.1000000000"
    assert float(found.least) == float(found.most) == 40
    assert width(softer, "0.1") == 40
    assert width(softer, "0.0999") is None
    rising = hs.Scene(mass_spring_damper(k=100), (hs.effects.series("1.1 + 0.1*s"),), (0, 40))
    found = ranged(rising, ["0.05", "0.2"]).bandwidths
    assert (found.least.digits(5), found.most.digits(5)) == (
        "1.0000",
        "2.0000",
    )  # r_r is 1/10 everywhere, r_i grows from 0
    growing = hs.Scene(mass_spring_damper(k=100), (hs.effects.series("1.1 - 0.01*s^2"),), (0, 40))
    assert float(ranged(growing, ["0.05", "0.2"]).bandwidths.least) == 0
    assert ranged(rising, ["0.02", "0.05"]).bandwidths.most is None


@pytest.mark.slow
def test_ranges_of_their_own_leave_out_what_neither_part_reaches() -> None:
    """The smaller one of two bandwidths is below a jump of the one while the other is above."""
    alone = ranged(RESONANT, ["0.05", "0.29"], 1).bandwidths
    assert [float(x.high) for x in alone.jumps] == [40.0]
    lag = replace(RESONANT, effects=(*RESONANT.effects, hs.effects.first_order_lag(200)))
    for real, imag in ((["0.05", "0.29"], 1), (1, ["0.05", "0.3"]), (["0.05", "0.29"], ["0.12", "0.13"])):
        found = ranged(lag, real, imag)
        assert found.certified
        for i in range(4):
            for j in range(4):
                at = [
                    x if not isinstance(x, list) else Fraction(x[0]) + (Fraction(x[1]) - Fraction(x[0])) * t / 3
                    for x, t in ((real, i), (imag, j))
                ]
                assert reached(found, width(lag, *at)), at


@pytest.mark.slow
def test_a_delay_has_certified_jumps_too() -> None:
    delayed = hs.Scene(
        mass_spring_damper(k=100), (hs.effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"), hs.effects.delay("1 ms")), (0, 40)
    )
    found = ranged(delayed, ["0.05", "0.29"])
    [jump] = found.bandwidths.jumps
    peak = max((p for p in hs.peaks(delayed) if p.part is hs.Part.REAL), key=lambda p: float(p.ratio))
    assert jump.low.digits(20) == peak.omega.digits(20)
    c = Fraction(jump.threshold.bounds(60)[1])
    assert float(width(delayed, c)) == pytest.approx(float(jump.high), rel=1e-9)
    assert found.certified
    assert reached(found, width(delayed, "0.15"))


class Ratio:
    """|p(omega^2)| of a polynomial whose slope vanishes at known places, on a band of omega^2."""

    def __init__(self, pick: Random) -> None:
        self.low, self.high = Fraction(pick.choice([0, 0, 1])), Fraction(pick.choice([4, 9, 16]))
        places = [Fraction(pick.randint(-2, 20), pick.choice([1, 1, 2])) for _ in range(pick.randint(1, 3))]
        slope = fmpq_poly([fmpq(pick.choice([1, -1, 2]), pick.randint(1, 3))])
        for x in places:
            slope *= fmpq_poly([-_fmpq(x), 1])
        self.p = slope.integral() + fmpq(pick.randint(-12, 12), 2)
        self.stops = {x for x in places if self.low < x < self.high}

    def at(self, x: Fraction) -> Fraction:
        found = abs(self.p(_fmpq(x)))
        return Fraction(int(found.p), int(found.q))

    def scene(self, low: Fraction, high: Fraction) -> hs.Scene:
        text = " + ".join(f"({c})*W^{n}" for n, c in enumerate(self.p.coeffs()))
        return on_a_spring(text, [str(low), str(high)], (round(root(self.low)), round(root(self.high))))

    def bandwidth(self, c: Fraction) -> float | None:
        """Up to where it is nowhere above c: in omega^2."""
        if self.at(self.low) > c:
            return None
        roots = [z for level in (c, -c) for z, _ in (self.p - _fmpq(level)).complex_roots() if z.imag == 0]
        inside = sorted(
            x for x in {self.low, self.high, *(Fraction(float(z.real)) for z in roots)} if self.low <= x <= self.high
        )
        for a, b in pairwise(inside):  # between zeros that agree as floats nothing is looked at
            if b - a > Fraction(1, 10**9) and self.at((a + b) / 2) > c:
                return float(a)
        return float(self.high)

    def records(self) -> list[tuple[Fraction, Fraction]]:
        """The local maxima inside of the band that are higher than all before them, with their heights."""
        found, top, near = list[tuple[Fraction, Fraction]](), self.at(self.low), Fraction(1, 10**6)
        for x in sorted(self.stops):
            if all(self.at(x + e) < self.at(x) for e in (-near, near)) and self.at(x) > top:
                found.append((x, self.at(x)))
            top = max(top, self.at(x))
        return found


def _fmpq(x: Fraction) -> fmpq:
    return fmpq(x.numerator, x.denominator)


def _is(x: hs.RealNumber | None, square: float | None) -> bool:
    return x is None if square is None else x is not None and abs(float(x) ** 2 - square) <= 1e-8 * max(square, 1e-3)


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(80))
def test_the_bandwidth_jumps_at_each_peak_that_is_higher_than_all_before_it(seed: int) -> None:
    pick = Random(seed)
    ratio = Ratio(pick)
    start, records = ratio.at(ratio.low), ratio.records()
    marks = [h for _, h in records] + [start]
    low = pick.choice([x for h in marks for x in (h, h / 2, h * Fraction(9, 10)) if x > 0] or [Fraction(1)])
    high = pick.choice([x for x in (*marks, *(2 * x for x in marks)) if x > low] or [2 * low])
    found = hs.evaluate(ratio.scene(low, high)).bandwidths
    assert found.certified
    assert _is(found.most, ratio.bandwidth(high))
    if found.most is None:
        assert (found.least, found.jumps) == (None, ())
        return
    assert [float(x) for x in found.blocked.values()] == pytest.approx([float(start)] if start > low else [])
    first = max(low, start)
    assert _is(found.least, ratio.bandwidth(first))
    expected = [(x, h) for x, h in records if first < h <= high]
    assert len(found.jumps) == len(expected)
    for jump, (x, h) in zip(found.jumps, expected, strict=True):
        assert _is(jump.low, float(x))
        assert _is(jump.high, ratio.bandwidth(h))
        assert float(jump.threshold) == pytest.approx(float(h))
        assert not jump.includes_low


LOW = float_pi / 3
"""In rad/s, a sixth of a hertz: there a ratio has no value that is a fraction."""


@pytest.mark.parametrize(
    ("Z", "least", "start"),
    [
        ("W/4", LOW, LOW**2 / 4),  # it rises from the start on
        ("(W - 4)/4", root(8 - LOW**2), 1 - LOW**2 / 4),  # it falls, and is as high again
        ("(W - 4)/4 + s/3", 3 * (1 - LOW**2 / 4), 1 - LOW**2 / 4),  # the other one is higher there
    ],
)
def test_from_an_end_of_the_band_that_is_no_fraction_bandwidths_begin_with_what_the_ratio_there_gives(
    Z: str, least: float, start: float
) -> None:
    found = hs.evaluate(on_a_spring(Z, ["1/20", "4"], ("1/6 Hz", "3 rad/s"))).bandwidths
    assert (float(found.least), float(found.most)) == (pytest.approx(least, rel=1e-14), 3)
    assert [float(x) for x in found.blocked.values()] == [pytest.approx(start, rel=1e-14)]


def test_whether_a_ratio_touches_an_end_of_the_range_stays_open_and_beside_it_nothing_does() -> None:
    """r_r = 1 - (1 + cos(omega) + (omega^2 - pi^2)^2)/1000 is 1 at pi alone, which no number of digits shows."""

    def found(high: str) -> Any:
        late = (delay(1), series("-1/1000"), shunt(Z="2 - 1/1000 - (s^2 + pi^2)^2/1000"))
        return hs.evaluate(
            hs.Scene(mass_spring_damper(k=1), late, (1, 5), {"real": ["1/2", high], "imag": 2})
        ).bandwidths

    assert not found("1").certified
    assert found("1").undecided
    above = found("1.001")
    assert float(above.most) == 5


def check(case: Case, low: Fraction, high: Fraction, *, apart: bool) -> None:
    own = scene(case)
    other = [str(1.5 * float(low)), str(1.5 * float(high))] if apart else None
    found = ranged(own, [str(float(low)), str(float(high))], other)
    low, high = Fraction(str(float(low))), Fraction(str(float(high)))
    ends = [width(own, c, None if other is None else other[i]) for i, c in enumerate((low, high))]
    all_ = found.bandwidths
    if ends[1] is None:
        assert all_.most is None
        return
    assert abs(sum(all_.most.bounds(150), Fraction(0)) / 2 - ends[1]) <= Fraction(1, 1 << 90) * ends[1]
    if not found.certified or all_.least is None:
        return
    for i in range(6):
        c = low + (high - low) * i / 5
        for j in range(6) if other else [None]:
            d = None if j is None else Fraction(other[0]) + (Fraction(other[1]) - Fraction(other[0])) * j / 5
            at = width(own, c, d)
            assert at is None or reached(found, at)
            assert (at is None) <= bool(all_.blocked)
    for jump in all_.jumps if not apart else ():
        below, above = jump.threshold.bounds(80)
        near = Fraction(1, 1 << 60)
        before, after = (width(own, c * (1 + sign * near)) for c, sign in ((below, -1), (above, 1)))
        assert before is None or before < sum(jump.low.bounds(150), Fraction(0)) / 2
        assert after * (1 + near) > sum(jump.high.bounds(150), Fraction(0)) / 2


SHARES = st.sampled_from([Fraction(n, 100) for n in (1, 2, 5, 10, 20, 50, 100)])


@pytest.mark.slow
@given(cases(), SHARES, st.sampled_from([Fraction(11, 10), Fraction(3, 2), Fraction(4)]), st.booleans())
def test_every_bandwidth_of_a_random_scene_is_among_those_that_are_said_to_be(
    case: Case,
    low: Fraction,
    factor: Fraction,
    apart: bool,  # noqa: FBT001
) -> None:
    check(case, low, low * factor, apart=apart)


@pytest.mark.slow
@given(st.data(), SHARES, st.sampled_from([Fraction(11, 10), Fraction(2), Fraction(5)]), st.booleans())
def test_so_it_is_where_zeros_and_poles_and_peaks_coincide(
    data: st.DataObject,
    low: Fraction,
    factor: Fraction,
    apart: bool,  # noqa: FBT001
) -> None:
    check(coincident_case(Drawn(data.draw)), low, low * factor, apart=apart)


def test_the_landing_of_a_sharp_peak_has_as_many_digits_as_are_asked_for() -> None:
    """Beside the peak the ratio falls off so fast that hundreds of bits tell the frequencies of its flanks apart."""
    told = scene_of('model = "two-mass"\nm1 = 1\nb1 = 1\nk1 = 1\nm2 = 1\nb2 = "1/10"\nk2 = 100')
    [jump] = hs.evaluate(told).bandwidths.jumps
    assert jump.high.digits(60) == "10." + 58 * "0"


def scene_of(environment: str) -> hs.Scene:
    lead = 'G = "(1 + s*T1)/(1 + s*T2)"\nparameters = { T1 = "1/100", T2 = "31/1000" }'
    return hs.parse_scene(
        f'[environment]\n{environment}\n[[effects]]\nmodel = "series"\n{lead}\n[evaluation]\nband = [0, 10]\njnd = ["1/5", "11/50"]\n'
    )


# --- ranges of regions -----------------------------------------------------------------------------------------------

SHAPES: list[dict[str, Any]] = [
    {"shape": "ellipse"},
    {"shape": "ellipse", "tilt": "1/2"},
    {"shape": "ellipse", "tilt": "-4/5"},
    {"shape": "diamond"},
]


def in_region(scene: hs.Scene, shape: dict[str, Any], c: Any) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(scene.environment, scene.effects, scene.band, {**shape, "real": c, "imag": c}))


def test_a_disc_around_a_circle_is_passed_on_all_of_it_at_once() -> None:
    """dH/|H| = 0.4 s/(s^2 + 2 s + 9) runs on a circle through 0, farthest out with 1/5 at 3 rad/s."""
    found = in_region(RESONANT, {"shape": "ellipse"}, ["0.05", "0.3"]).bandwidths
    [jump] = found.jumps
    assert (jump.low.digits(15), float(jump.high), jump.threshold.digits(15)) == (
        "3.00000000000000",
        40.0,
        "0.200000000000000",
    )
    assert found.certified


@pytest.mark.dear("{'shape': 'diamond'}", "{'shape': 'ellipse', 'tilt': '-4/5'}")
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_the_ends_of_a_range_of_a_region_are_those_of_its_smallest_and_its_largest(shape: dict[str, Any]) -> None:
    paper = hs.load_scene("fu2019")
    found = in_region(paper, shape, ["0.05", "0.11"])
    ends = [in_region(paper, shape, c).bandwidth for c in ("0.05", "0.11")]
    assert [found.bandwidths.least.digits(20), found.bandwidths.most.digits(20)] == [x.digits(20) for x in ends]
    assert found.bandwidths.is_one_curve


@pytest.mark.slow
@given(cases(order=3), st.sampled_from(SHAPES), st.integers(2, 20), st.integers(1, 40))
def test_every_bandwidth_of_a_region_of_the_range_is_among_those_that_are_said_to_be(
    drawn: Case, shape: dict[str, Any], low: int, more: int
) -> None:
    asked = scene(drawn)
    ends = [Fraction(low, 100), Fraction(low + more, 100)]
    found = in_region(asked, shape, [str(x) for x in ends])
    assume(found.bandwidths.certified and found.bandwidths.least is not None)
    shares = (0, Fraction(1, 7), Fraction(1, 2), Fraction(5, 6), 1)
    each = [in_region(asked, shape, str(ends[0] + x * (ends[1] - ends[0]))).bandwidth for x in shares]
    assume(any(each))
    for one in filter(None, each):
        assert reached(found, sum(one.bounds(150), Fraction(0)) / 2)


DIAMOND = {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]}

NEAR = Fraction(1, 1 << 60)


def judged(asked: hs.Scene, jnd: Any) -> hs.Evaluation:
    return hs.evaluate(hs.Scene(asked.environment, asked.effects, asked.band, jnd))


def middle(x: hs.RealNumber | None) -> Fraction | None:
    return None if x is None else sum(x.bounds(150), Fraction(0)) / 2


def bandwidth_for(asked: hs.Scene, jnd: Any) -> Fraction | None:
    return middle(judged(asked, jnd).bandwidth)


def times(x: Any, t: Fraction) -> Any:
    """Limits that many times as large."""
    if isinstance(x, dict):
        return {key: y if key in ("shape", "tilt") else times(y, t) for key, y in x.items()}
    if isinstance(x, list):
        return [times(y, t) for y in x]
    return f"({x})*({t})" if "omega" in str(x) else str(Fraction(str(x)) * t)


def is_told(found: Any, x: Fraction) -> bool:
    near = Fraction(1, 1 << 90) * max(x, Fraction(1, 1000))
    inside = any(middle(j.low) + near < x < middle(j.high) - near for j in found.jumps)
    return middle(found.least) - near <= x <= middle(found.most) + near and not inside


def ends_are(found: Any, low: Fraction | None, high: Fraction | None) -> None:
    """The least and the most are those of the ends."""
    assert (found.most is None) == (high is None)
    for told, x in ((found.least, low), (found.most, high)):
        assert x is None or abs(middle(told) - x) <= Fraction(1, 1 << 90) * x


def scales(asked: hs.Scene, jnd: Any, low: Fraction, high: Fraction) -> Any:
    """What is said of a scale from low to high, held against multiples of the region."""
    found = judged(asked, {**jnd, "scale": [str(low), str(high)]}).bandwidths
    ends = [bandwidth_for(asked, times(jnd, t)) for t in (low, high)]
    ends_are(found, *ends)
    if not found.certified or found.most is None:
        return found
    assert (ends[0] is None) == bool(found.blocked)
    for i in range(1, 6):
        t = low + (high - low) * i / 6
        x = bandwidth_for(asked, times(jnd, t))
        assert x is None or is_told(found, x)
        assert all((x is None) == (t < middle(y)) for y in found.blocked.values())
    for jump in found.jumps:
        below, above = jump.threshold.bounds(80)
        before, after = (bandwidth_for(asked, times(jnd, t)) for t in (below * (1 - NEAR), above * (1 + NEAR)))
        assert before is None or before <= middle(jump.low) * (1 + NEAR)
        assert after * (1 + NEAR) >= middle(jump.high)
        if before is not None:
            assert (before == middle(jump.low)) if jump.includes_low else (before < middle(jump.low))
    return found


@pytest.mark.dear("13")
@pytest.mark.few("13", "31")
@pytest.mark.parametrize("seed", range(60))
def test_a_region_of_a_random_scene_that_is_scaled_has_the_bandwidths_of_its_multiples(seed: int) -> None:
    text = region_scene(seed)
    scales(hs.parse_scene(text), tomllib.loads(text)["evaluation"]["jnd"], Fraction(1, 2), Fraction(5, 2))


def places(jnd: Any) -> Iterator[tuple[str, ...]]:
    """Where a number stands that may have a range: not those in omega, tilts and corners."""
    for key, x in jnd.items():
        for path, y in [((key, way), y) for way, y in x.items()] if isinstance(x, dict) else [((key,), x)]:
            if path[0] in ("real", "imag", "floor") and "omega" not in str(y):
                yield path


def put(jnd: Any, path: tuple[str, ...], given: Any) -> Any:
    key, *rest = path
    return {**jnd, key: put(jnd[key], tuple(rest), given) if rest else given}


def apart(asked: hs.Scene, jnd: Any, listed: list[tuple[str, ...]]) -> Any:
    """What is said of ranges of several numbers, held against their values."""
    nominal = {path: Fraction(str(jnd[path[0]][path[1]] if len(path) > 1 else jnd[path[0]])) for path in listed}
    shares = [Fraction(n, 10) for n in (6, 9, 13, 20)]

    def at(chosen: tuple[Fraction, ...]) -> Fraction | None:
        own = jnd
        for path, t in zip(listed, chosen, strict=True):
            own = put(own, path, str(nominal[path] * t))
        return bandwidth_for(asked, own)

    wide = jnd
    for path, x in nominal.items():
        wide = put(wide, path, [str(x * shares[0]), str(x * shares[-1])])
    found = judged(asked, wide).bandwidths
    ends_are(found, *(at((t,) * len(listed)) for t in (shares[0], shares[-1])))
    for chosen in product(shares, repeat=len(listed)) if found.most is not None and found.least is not None else ():
        x = at(chosen)
        assert x is None or is_told(found, x), chosen
    return found


@pytest.mark.dear("43")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(60))
def test_ranges_of_the_numbers_of_a_random_region_give_the_bandwidths_of_their_values(seed: int) -> None:
    text = region_scene(seed)
    jnd = tomllib.loads(text)["evaluation"]["jnd"]
    listed = list(places(jnd))[: 1 + seed % 2]
    if listed and jnd.get("tilt", "0/10") == "0/10":
        apart(hs.parse_scene(text), jnd, listed)


def test_a_floor_and_limits_for_each_way_move_the_papers_example_between_known_values() -> None:
    """Known: a floor of 15 N/m crosses at 8.88766..., a limit of 8 % for growth at 6.53358... and returns at 7.65752..."""
    floor = judged(PAPER, {"real": 0.1, "imag": 0.1, "floor": ["5 N/m", "15 N/m"]}).bandwidths
    assert (floor.least.digits(15), floor.most.digits(15)) == ("7.97891679017471", "8.88766189298739")
    sides = {"real": {"higher": ["0.06", "0.08"], "lower": 0.12}, "imag": 0.1}
    found = judged(PAPER, sides).bandwidths
    assert (found.most.digits(14), found.jumps, found.ends_alone) == ("6.5335818444859", (), False)
    wide = judged(PAPER, put(sides, ("real", "higher"), ["0.06", "0.2"])).bandwidths
    [jump] = wide.jumps  # where |Re H_perc| = |Re H_env| the lower limit takes over, and is not exceeded
    assert (jump.low.digits(14), jump.includes_low) == ("7.6575265525", False) or jump.low.digits(12) == "7.65752655249"
    assert bandwidth_for(PAPER, put(sides, ("real", "higher"), "0.0962")) < jump.low.bounds(90)[0]


@pytest.mark.slow
def test_the_bandwidth_stands_where_a_tighter_limit_takes_over_and_leaves_out_what_lies_behind_the_step() -> None:
    """Re G = 1 - 2.5 * 4 w^2/((9 - w^2)^2 + 4 w^2) is -1, where a spring's part is as large as it was, for (9 - w^2)^2 = w^2: at
    (sqrt(37) -+ 1)/2. Between the limit for growth holds. Behind that r_r falls from 2, which the tighter limit 2 - w/10 judges.
    """
    spring = hs.environments.mass_spring_damper(k=100)
    asked = hs.Scene(spring, (hs.effects.series("1 - 5*s/(s^2 + 2*s + 9)"),), (0, 19))
    jnd = {"real": {"higher": "4", "lower": "2 - omega/10"}, "imag": "100"}
    first, second = (Fraction(Decimal(37).sqrt() + n) / 2 for n in (-1, 1))
    found = scales(asked, jnd, Fraction(1, 2), Fraction(3))
    assert [(float(x.low), x.includes_low) for x in found.jumps] == [(float(first), False), (float(second), True)]
    assert float(found.jumps[0].high) == float(second)
    assert float(found.jumps[1].threshold) == pytest.approx(float(2 / (2 - second / 10)), rel=1e-15)
    stands = [bandwidth_for(asked, times(jnd, Fraction(t))) for t in ("1.172", "1.18", "1.19")]
    assert stands == [middle(found.jumps[1].low)] * 3


def test_a_diamond_of_corners_jumps_as_the_diamond_does() -> None:
    one = judged(PAPER, {**DIAMOND, "scale": ["0.5", "2"]}).bandwidths
    other = judged(PAPER, {"shape": "diamond", "real": ["0.05", "0.2"], "imag": ["0.05", "0.2"]}).bandwidths
    [a], [b] = one.jumps, other.jumps
    assert [x.digits(15) for x in (one.least, one.most, a.low, a.high)] == [
        x.digits(15) for x in (other.least, other.most, b.low, b.high)
    ]
    assert 10 * float(b.threshold) == pytest.approx(float(a.threshold))


def test_of_several_numbers_with_ranges_of_their_own_the_ends_alone_are_told() -> None:
    for jnd, ends in (
        ({"real": ["0.09", "0.11"], "imag": 0.1, "floor": ["5 N/m", "15 N/m"]}, [{"real": x, "imag": 0.1, "floor": y} for x, y in (("0.09", "5 N/m"), ("0.11", "15 N/m"))]),
        ({"shape": "ellipse", "real": ["0.09", "0.11"], "imag": ["0.108", "0.132"]}, [{"shape": "ellipse", "real": a, "imag": b} for a, b in (("0.09", "0.108"), ("0.11", "0.132"))]),
        ({"real": ["0.09", "0.11"], "imag": ["0.1", "0.2"]}, [{"real": "0.09", "imag": "0.1"}, {"real": "0.11", "imag": "0.2"}]),
    ):  # fmt: skip
        found = judged(PAPER, jnd).bandwidths
        assert (found.ends_alone, found.row(5).get("ends_alone"), found.jumps, found.certified) == (
            True,
            True,
            (),
            True,
        )
        assert [x.digits(20) for x in (found.least, found.most)] == [
            judged(PAPER, x).bandwidth.digits(20) for x in ends
        ]


def test_a_box_has_no_side_for_a_scale() -> None:
    asked = hs.Scene(PAPER.environment, PAPER.effects, PAPER.band, {**DIAMOND, "scale": [1, 2]})
    with pytest.raises(hs.SceneError, match="a range of scale is for haptisym evaluate"):
        hs.tolerances(asked)
    assert asked.aside_keys()["nominal"] == {"evaluation.jnd.scale": [1.0, 2.0]}


@pytest.mark.dear("1/3-2*s^(2/3)")
@pytest.mark.parametrize(("order", "more"), [("1/2", "2*s"), ("1/3", "2*s^(2/3)")])
def test_a_scale_that_is_needed_where_powers_of_s_leave_0_over_0_is_that_of_the_limit(order: str, more: str) -> None:
    """A quarter more of a spring-pot is five times a disc of a twentieth, at 0 rad/s."""
    felt = hs.environments.expression(f"100*s^({order}) + {more}")
    jnd = {"shape": "ellipse", "real": 0.05, "imag": 0.05, "scale": ["1/2", "90"]}
    found = hs.evaluate(hs.Scene(hs.environments.spring_pot(80, order), (), (0, 60), jnd, rendered=felt)).bandwidths
    assert found.certified
    assert [float(x) for x in (found.most, *found.blocked.values())] == [60, 5]


# --- where what is judged stays the same for a while, as a floor makes it --------------------------------------------


FELT = hs.environments.mass_spring_damper(k=100, m=1)


def floored(jnd: Any, damper: str, band: tuple[Any, Any]) -> hs.Evaluation:
    """10 N/m and a damper are added: Re dH = 10 and Im dH = b omega, beside |H_env| = |100 - omega^2|."""
    rendered = hs.environments.mass_spring_damper(k=110, m=1, b=damper)
    return hs.evaluate(hs.Scene(FELT, (), band, jnd, rendered=rendered))


def limits(real: Any, floor: str, **more: Any) -> dict[str, Any]:
    """The imaginary part is noticed as soon as it exceeds the floor."""
    return {"real": real, "imag": "0.000001", "floor": f"{floor} N/m", **more}


def told(found: Any) -> list[Any]:
    jumps = [(float(x.low), float(x.high), float(x.threshold), x.includes_low) for x in found.jumps]
    return [float(found.least), float(found.most), jumps, {name: float(x) for name, x in found.blocked.items()}]


def near(x: Any) -> Any:
    return [
        pytest.approx(y, rel=1e-12) if not isinstance(y, list) else [pytest.approx(z, rel=1e-12) for z in y] for y in x
    ]


@pytest.mark.few(5)
@pytest.mark.parametrize(("c", "floor"), [("1/5", "10"), ("1/5", "15"), ("1/20", "3"), ("1/6", "7")])
@pytest.mark.parametrize("damper", ["0", "1", "1/2", "1/3"])
def test_a_scale_at_which_a_floor_is_never_exceeded_jumps_over_all_that_it_judges(
    c: str, floor: str, damper: str
) -> None:
    """10/|100 - omega^2| > c t and 10 > f t: from where the first holds for t = 10/f on, to b omega = 10 or the end of the band."""
    limit, f, b = map(Fraction, (c, floor, damper))
    found = floored(limits(c, floor, scale=["1/1000", "20"]), damper, (0, 40)).bandwidths
    assert found is not None
    most = min(float(20 * f / b), 40) if b else 40
    start, top, landing = root(100 - f / limit), 10 / f, float(10 / b) if b else 40
    jumps = [(start, landing, float(top), False)]
    assert found.certified
    assert told(found) == near([0, most, jumps, {"scale": float(1 / (10 * limit))}])
    asked = floored(limits(c, floor), damper, (0, 40))
    assert not hs.peaks(asked.scene)  # nowhere is there more than on both sides


@pytest.mark.parametrize("floor", ["10", "15", "7"])
def test_where_a_tighter_limit_takes_over_and_the_floor_holds_at_once_the_bandwidth_stands_until_it_is_passed(
    floor: str,
) -> None:
    """Re H_perc = -Re H_env at omega^2 = 105: before it grows, by 10 times the limit at the most, behind it shrinks."""
    jnd = limits({"higher": "10", "lower": "1/20"}, floor, scale=["1/100", "5"])
    found = floored(jnd, "0", ("10.1", 30)).bandwidths
    assert found is not None
    top = float(10 / Fraction(floor))
    start = float(1 / (Fraction("10.1") ** 2 - 100))
    assert found.certified
    assert told(found) == near([root(105), 30, [(root(105), 30, top, True)], {"scale": start}])


@pytest.mark.few(4)
@pytest.mark.parametrize("floor", ["10", "15", "7"])
@pytest.mark.parametrize(("damper", "landing"), [("1", 10), ("0", 30), ("3", Fraction(10, 3))])
def test_a_floor_that_judges_from_the_low_end_of_the_band_on_is_passed_on_all_of_its_piece_by_the_least_scale(
    floor: str, damper: str, landing: Fraction
) -> None:
    found = floored(limits("1/100", floor, scale=["1/100", "100"]), damper, (0, 30)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([float(landing), 30, [], {"scale": float(10 / Fraction(floor))}])


@pytest.mark.parametrize(
    ("low", "high", "least", "most", "jumps"),
    [
        ("1/100", "2/3", 0, 10, [(5, 10, 2 / 3, False)]),
        ("2/3", "5", 10, 12, []),
        ("1/100", "333/500", 0, root(100 - 50 * 500 / 333), []),
    ],
)
def test_an_end_of_the_range_may_be_the_very_height_of_a_plateau(
    low: str, high: str, least: float, most: float, jumps: list[Any]
) -> None:
    """50/(100 - omega^2) up to 5 rad/s, 2/3 from there to 10, and omega/15 behind."""
    found = floored(limits("1/5", "15", scale=[low, high]), "1", (0, 12)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([least, most, jumps, {} if least else {"scale": 0.5}])


@pytest.mark.parametrize(("higher", "lower", "least"), [("1", "3", "2/3"), ("3", "1", "2/3"), ("5", "5/2", "2/5")])
def test_of_a_part_that_is_turned_round_and_as_large_as_it_was_the_larger_limit_holds(
    higher: str, lower: str, least: str
) -> None:
    """A spring that pushes where it pulled: r_r = 2."""
    spring = hs.environments.mass_spring_damper(k=100)
    jnd = {"real": {"higher": higher, "lower": lower}, "imag": "1", "scale": ["1/3", "2"]}
    found = hs.evaluate(hs.Scene(spring, (hs.effects.series("-1"),), (0, 30), jnd)).bandwidths
    assert found is not None
    assert found.certified
    assert told(found) == near([30, 30, [], {"scale": float(Fraction(least))}])
