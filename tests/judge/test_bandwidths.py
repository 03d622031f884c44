"""All bandwidths that a range of thresholds gives: held against exact evaluations at the ends, inside, and on both sides of each jump."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import Case
from strategies import Drawn, Seeded, case, cases, coincident_case, scene
from sympy import Integer

import haptisym as hs
from haptisym.environments import mass_spring_damper
from haptisym.judge.bandwidths import _lower
from haptisym.judge.climb import Bandwidths, Jump
from haptisym.kernel.reals import ExactNumber
from haptisym.writing.plain import plain

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


@pytest.mark.slow
def test_a_jump_of_two_ranges_apart_is_told_without_a_threshold_and_that_of_one_with_it() -> None:
    """The imaginary part stays below its range: what jumps is the same."""
    for imag, more in ((["1", "2"], ""), (None, " (the threshold passes a peak of 20 %)")):
        said = " ".join(plain(ranged(RESONANT, ["0.05", "0.29"], imag).document()).split())
        assert f"each value between is reached but those from 3 to below 40 rad/s{more}." in said


def test_an_end_of_the_range_at_the_very_peak_gives_the_far_side_or_the_jump_alone() -> None:
    below, at, above = (
        ranged(RESONANT, ["0.05", "0.19"]),
        ranged(RESONANT, ["0.05", "0.2"]),
        ranged(RESONANT, ["0.2", "0.3"]),
    )
    assert (below.bandwidths.jumps, above.bandwidths.jumps, len(at.bandwidths.jumps)) == ((), (), 1)
    assert float(at.bandwidths.most) == float(above.bandwidths.least) == 40


def test_two_peaks_of_one_height_are_one_jump_and_a_peak_that_another_ratio_passes_is_none() -> None:
    """For the imaginary part alone both peaks are passed at once; for one number the real part is as high and rising at the first."""
    [jump] = ranged(RESONANT, 1, ["0.05", "0.3"]).bandwidths.jumps
    assert (jump.low.digits(12), float(jump.high)) == ("2.16227766017", 40.0)
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
    assert "there is no bandwidth" in str(ranged(rising, ["0.02", "0.05"]))


@pytest.mark.slow
def test_ranges_of_their_own_leave_out_what_neither_part_reaches() -> None:
    """The smaller one of two bandwidths is below a jump of the one while the other is above."""
    alone = ranged(RESONANT, ["0.05", "0.29"], 1).bandwidths
    assert [float(x.high) for x in alone.jumps] == [40.0]
    lag = replace(RESONANT, effects=(*RESONANT.effects, hs.effects.first_order_lag(200)))
    for real, imag in ((["0.05", "0.29"], 1), (1, ["0.05", "0.3"]), (["0.05", "0.29"], ["0.12", "0.13"])):
        found = ranged(lag, real, imag)
        assert found.certified
        for i in range(9):
            for j in range(9):
                at = [
                    x if not isinstance(x, list) else Fraction(x[0]) + (Fraction(x[1]) - Fraction(x[0])) * t / 8
                    for x, t in ((real, i), (imag, j))
                ]
                assert reached(found, width(lag, *at)), at


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


@pytest.mark.slow
def test_random_scenes_have_jumps_to_be_tested() -> None:
    """The properties above are not about nothing."""
    jumps = [
        len(x.jumps)
        for seed in range(60)
        if (x := ranged(scene(case(Seeded(seed))), ["0.05", "2"]).bandwidths).most is not None
    ]
    assert sum(jumps) >= 10


def test_page_and_document_say_it() -> None:
    found = ranged(RESONANT, ["0.05", "0.1", "0.29"])
    page = " ".join(str(found).split())
    assert "For thresholds from 5 % to 29 % the bandwidth is at least 1.0563 rad/s" in page
    assert (
        "each value between is reached but those from 3 to below 40 rad/s (the threshold passes a peak of 20 %)."
        in page
    )
    told = json.loads(found.to_json())["bandwidths"]
    assert (told["least"]["digits"], told["most"]["value"], told["certified"]) == (
        found.bandwidths.least.digits(15),
        40.0,
        True,
    )
    assert (told["jumps"][0]["from"]["value"], told["jumps"][0]["threshold"]["value"], told["none_below"]) == (
        3.0,
        0.2,
        {},
    )
    assert "bandwidths" not in hs.evaluate("fu2019").to_dict()


# --- one range for both half widths of a region -----------------------------------------------------------------------

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


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_the_ends_of_a_range_of_a_region_are_those_of_its_smallest_and_its_largest(shape: dict[str, Any]) -> None:
    paper = hs.load_scene("fu2019")
    found = in_region(paper, shape, ["0.05", "0.11"])
    ends = [in_region(paper, shape, c).bandwidth for c in ("0.05", "0.11")]
    assert [found.bandwidths.least.digits(20), found.bandwidths.most.digits(20)] == [x.digits(20) for x in ends]
    assert found.bandwidths.is_one_curve
    assert "For thresholds from 5 % to 11 % the bandwidth is at least" in " ".join(str(found).split())


@pytest.mark.slow
@given(cases(order=3), st.sampled_from(SHAPES), st.integers(2, 20), st.integers(1, 40))
def test_every_bandwidth_of_a_region_of_the_range_is_among_those_that_are_said_to_be(
    drawn: Case, shape: dict[str, Any], low: int, more: int
) -> None:
    asked = scene(drawn)
    ends = [Fraction(low, 100), Fraction(low + more, 100)]
    found = in_region(asked, shape, [str(x) for x in ends])
    if not found.bandwidths.certified or found.bandwidths.least is None:
        return
    for share in (0, Fraction(1, 7), Fraction(1, 2), Fraction(5, 6), 1):
        one = in_region(asked, shape, str(ends[0] + share * (ends[1] - ends[0]))).bandwidth
        if one is not None:
            assert reached(found, sum(one.bounds(150), Fraction(0)) / 2)


def drawn(pick: Random, first: int) -> Bandwidths:
    """From a number to another, less some jumps: every second whole number from the first one on."""
    numbers = [ExactNumber(Integer(first + 2 * n)) for n in sorted(pick.sample(range(10), pick.randint(2, 6)))]
    inner = list(pairwise(numbers[:-1]))[:: pick.randint(1, 2)]
    jumps = [Jump(a, b, includes_low=a is numbers[0] or pick.random() < 0.5) for a, b in inner if pick.random() < 0.7]
    return Bandwidths(numbers[0], numbers[-1], tuple(jumps))


def is_given(of: Bandwidths, x: Fraction) -> bool:
    def at(number: Any) -> Fraction:
        return Fraction(int(number.value))

    left_out = any(at(j.low) < x < at(j.high) or (x == at(j.low) and not j.includes_low) for j in of.jumps)
    return at(of.least) <= x <= at(of.most) and not left_out


def test_the_smaller_of_two_bandwidths_is_one_of_either_set_as_far_as_both_reach() -> None:
    """With nothing else known of both, all of either set up to the smaller of their largest."""
    pick = Random(5)
    for _ in range(60):
        one, other = drawn(pick, 0), drawn(pick, 1)
        both = _lower(one, other)
        most = min(Fraction(int(x.most.value)) for x in (one, other))  # type: ignore[union-attr]
        for n in range(-2, 44):
            x = Fraction(n, 2)
            assert is_given(both, x) == ((is_given(one, x) or is_given(other, x)) and x <= most)


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
