"""What accuracy costs, by laws: a clock that is set by hand, digits of known errors, conditions that have a closed form."""

from __future__ import annotations

import random
import statistics
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import count
from math import inf, log10, nan, pi
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
import regions
import sympy
import threadpoolctl
from flint import arb
from hypothesis import example, given
from hypothesis import strategies as st
from jnds import jnds
from marks import examples
from sympy import sqrt

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.errors import LimitError, SceneError
from haptisym.model.jnd import Threshold
from haptisym.verbs.cost import stopwatch
from haptisym.verbs.cost.entry import Cost
from haptisym.verbs.cost.hardcases import FAMILIES, HardCase, hard_cases
from haptisym.verbs.cost.hardcosts import HardCosts, put
from haptisym.verbs.cost.margins import margin
from haptisym.verbs.cost.measurement import HardRow, Measurement, Omission, front
from haptisym.verbs.cost.methods import CROSSINGS, RATIO_METHODS, Method
from haptisym.verbs.cost.questions import DOUBLE, Crossings, Found, RatioQuestion, right_digits
from haptisym.verbs.cost.stopwatch import interleaved
from haptisym.verbs.cost.summary import duration, hard_summary, summary, worst_verdict, wrong
from haptisym.verbs.cost.sweeps import Answers, SweepQuestion
from haptisym.verbs.cost.tasks import approximated, without
from haptisym.verbs.cost.usual import RefusedError, companion_way, grid_way, naive_way

YES, NO = True, False
"""Of measurements: whether they are proven."""
SPRING = hs.environments.mass_spring_damper(k=100)


def lag(omega_c: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    """A spring behind a lag: r_r = w^2/(w^2 + wc^2), r_i = w wc/(w^2 + wc^2)."""
    return hs.Scene(SPRING, (hs.effects.first_order_lag(omega_c),), band, jnd)


# Time


class Clock:
    """A clock that goes on by as much as is said, and by nothing else."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        monkeypatch.setattr(stopwatch, "perf_counter", lambda: self.now)

    def takes(self, seconds: Iterator[float]) -> Callable[[], float]:
        def attempt() -> float:
            took = next(seconds)
            self.now += took
            return took

        return attempt


def test_medians_are_of_rounds_in_turns_that_begin_while_there_is_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same by hand: a first run each, then rounds of those that were quick, none begun after the time is over."""
    pick, clock = random.Random(5), Clock(monkeypatch)
    for n in range(60):
        budget, rounds = pick.choice([8, 16, 64]), pick.choice([1, 4, 15])
        taken = {key: [pick.choice([1, 2, budget // 8, budget // 8 + 1, 0.5]) for _ in range(40)] for key in "abcd"}
        found = interleaved({k: clock.takes(iter(x)) for k, x in taken.items()}, budget, rounds=rounds)
        first = {key: x[0] for key, x in taken.items()}
        short, spent, done = [k for k in taken if first[k] <= budget / 8], sum(first.values()), 0
        while done < rounds and spent <= budget:
            done += 1
            spent += sum(taken[k][done] for k in short)
        for key, x in found.items():
            repeats = taken[key][1 : done + 1] if key in short else []
            assert x.seconds == statistics.median(repeats or [first[key]]), (n, key)
            assert x.answer == first[key]


def test_without_a_word_there_are_fifteen_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, clock = count(), Clock(monkeypatch)
    told: list[tuple[str, int]] = []
    interleaved({"a": lambda: next(calls), "b": clock.takes(count(9.0, 0))}, 10.0, told=lambda *x: told.append(x))
    assert (next(calls), told) == (1 + 15, [("a", 0), ("b", 1)])


@pytest.mark.parametrize("seconds", [1e-9, 3.21e-7, 1e-6, 9.999e-4, 1e-3, 0.00123456, 0.5, 1.0, 12.3456, 4321.0])
def test_a_time_is_told_with_three_digits_in_the_largest_unit_that_it_fills(seconds: float) -> None:
    number, unit = duration(seconds).split()
    size = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
    assert float(number) * size[unit] == pytest.approx(seconds, rel=5e-3)
    assert number == f"{float(number):g}"
    assert float(number) >= 1
    assert all(seconds < size[x] or size[x] <= size[unit] for x in size if x != "ns")


# Tables


def test_the_front_is_what_no_other_row_beats() -> None:
    pick = random.Random(3)
    for _ in range(40):
        rows = [
            Measurement("crossings", str(i), pick.randint(0, 6), pick.randint(1, 6), NO, pick.choice([0, 0, 0, 1]), pick.choice([0, 0, 0, 2]))
            for i in range(pick.randint(0, 9))
        ]  # fmt: skip
        whole = {(x.seconds, x.digits) for x in rows if x.missed == x.invented == 0}
        best = {(t, n) for t, n in whole if not any(u <= t and k >= n and (u, k) != (t, n) for u, k in whole)}
        assert [(x.seconds, x.digits) for x in front(rows)] == sorted(best)


def crossing(name: str, digits: float, seconds: float, *, proven: bool = False, **more: int) -> Measurement:
    return Measurement("crossings", name, digits, seconds, proven, **more)


PROVEN = [
    crossing("certified, 50 digits", 50, 2.0, proven=True),
    crossing("certified, 15 digits", 15, 0.25, proven=True),
]
GRIDS = [crossing("grid of 10^2", 4.25, 1e-3), crossing("grid of 10^3", 6.5, 2e-2)]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "Here no method found all crossings and no others."),
        ([crossing("grid of 10^2", 3, 1, missed=1)], "Here no method found all crossings and no others."),
        (
            [*GRIDS, crossing("numpy.roots", 99, 5, invented=2), PROVEN[1]],
            "Here 15.0 digits take 250 ms (certified, 15 digits), and the fastest way gives 4.2 digits in 1 ms (grid of 10^2).",
        ),
        (
            [*PROVEN, *GRIDS, crossing("grid of 10^4 + Brent", 15, 9.0), crossing("numpy.roots", 15, 8.0)],
            ("Here all crossings, proven, to 15 digits take 250 ms; more digits cost 50 ms a digit: 50 of them take 2 s; "
            "a grid of 10^3 points takes 20 ms for 6.5 digits, and proves nothing."),
        ),
        (
            [replace(PROVEN[0], seconds=0.25), PROVEN[1], replace(GRIDS[1], missed=2, invented=1), GRIDS[0]],
            ("Here all crossings, proven, to 15 digits take 250 ms; more digits cost no time that shows: 50 of them take 250 ms; "
            "a grid of 10^3 points takes 20 ms and misses 2 and invents 1."),
        ),
        (
            [*PROVEN, replace(PROVEN[1], task="delay", digits=1), Measurement("evaluate", "certified", 16, 9.0, YES)],
            "Here all crossings, proven, to 15 digits take 250 ms; more digits cost 50 ms a digit: 50 of them take 2 s.",
        ),
        ([Measurement("sweep", "grid of 10^2, halved", 9, 1e-4, NO, 0, 0, 1, 8)], "Here no set was answered with proof."),
        (
            [
                Measurement("sweep", "certified", 15, 3e-3, YES, 0, 0, 0, 8, 7, 9),
                Measurement("sweep", "grid of 10^2, halved", 9, 1e-4, NO, 3, 0, 1, 8),
                Measurement("sweep", "grid of 10^3, halved", 9, 1e-3, NO, 0, 0, 0, 8),
                Measurement("sweep", "grid of 10^4, halved", 9, 1e-3, NO, 0, 0, 0, 0),
            ],
            ("Here a set is answered with proof in 3 ms (7 of 9 sets were not reached within the limit of time); "
            "a grid of 10^2 points takes 100 us and counts 12 % of 8 sets wrong; "
            "a grid of 10^3 points takes 1 ms and counts none of 8 sets wrong."),
        ),
    ],
)  # fmt: skip
def test_what_a_digit_costs_is_said_in_a_sentence(rows: list[Measurement], said: str) -> None:
    assert summary(rows) == said


def hard(verdict: str, digits: float = 1.0, *, ours: bool = False, proven: bool = False, **more: Any) -> HardRow:
    method = more.pop("method", "ours" if ours else "theirs")
    of = {"family": "identities", "case": "a gain of 1", "condition": 1.0} | more
    missed, invented = of.pop("missed", 0), of.pop("invented", 0)
    seconds = of.pop("seconds", 1.0)
    return HardRow("evaluate", method, digits, seconds, proven, missed, invented, **of, ours=ours, verdict=verdict)


def test_hard_answers_are_counted_by_who_gives_them_and_what_is_wrong() -> None:
    rows = [
        hard("right", ours=True, proven=True), hard("undecided", ours=True), hard("right"), hard("wrong"),
        hard("loses 3 digits", case="b"), hard("cannot: no delays", case="c"),
    ]  # fmt: skip
    told = "{} hard questions: haptisym gives {} proven answers, {} of them {}; of 3 answers by the usual ways 2 lose"
    assert hard_summary(rows).startswith(told.format(3, 1, "none", "wrong"))
    assert hard_summary([*rows, hard("wrong", ours=True, proven=True)]).startswith(told.format(3, 2, 1, "WRONG"))
    assert worst_verdict([hard("right"), hard("loses 3 digits", 9), hard("loses 8 digits", 4)]) == "loses 8 digits"
    assert worst_verdict([hard("undecided"), hard("undecided"), hard("wrong")]) == "2 undecided, and said so"
    assert worst_verdict([hard("misses 1", missed=1), hard("x", missed=2)]) == "misses 3"
    assert worst_verdict([hard("x", invented=4), hard("undecided")]) == "invents 4"
    assert worst_verdict([hard("x", invented=4), hard("x", missed=1)]) == "misses 1 and invents 4"
    assert worst_verdict([hard("right")]) == worst_verdict([]) == ""
    assert (wrong(crossing("x", 1, 1)), wrong(crossing("x", 1, 1, invented=2))) == ("", "invents 2")


# Digits


@given(
    true=st.fractions(Fraction(1, 1000), 1000, max_denominator=10**6),
    k=st.integers(-1, 40),
    sign=st.sampled_from([-1, 1]),
    held=st.sampled_from([10.0, DOUBLE, 30.0]),
)
@examples(60)
def test_right_digits_are_the_logarithm_of_the_relative_error(true: Fraction, k: int, sign: int, held: float) -> None:
    own = true * (1 + Fraction(sign, 3) / Fraction(10) ** k)
    with mpmath.workdps(60):
        text = mpmath.nstr(mpmath.mpf(own.numerator) / own.denominator, 55)
        error = abs(Fraction(text) - true) / true
        known = float(-mpmath.log10(mpmath.mpf(error.numerator) / error.denominator)) if error else inf
    with flint.ctx.workprec(300):
        ball = arb(true.numerator) / true.denominator
        assert right_digits(text, ball, held) == pytest.approx(min(max(known, 0.0), held), abs=1e-9)
        assert right_digits(float(own), ball, held) <= held
        turned = text.removeprefix("-") if text.startswith("-") else f"-{text}"
        assert right_digits(turned, -ball, held) == right_digits(text, ball, held)


def test_right_digits_of_what_is_no_number_or_nothing() -> None:
    assert [right_digits(x, arb(1), 15) for x in (nan, inf, -inf, "nan", "inf")] == [0.0] * 5
    assert [right_digits(x, arb("inf"), 15) for x in (inf, -inf, "inf", "-inf")] == [15] * 4
    assert [right_digits(x, arb("inf"), 15) for x in (nan, 1e300, "nan", "1")] == [0.0] * 4
    assert (right_digits(0.0, arb(0), 15), right_digits(1e-300, arb(0), 15), right_digits("1e-300", arb(0), 15)) == (
        15,
        0,
        0,
    )
    tiny = arb(2) ** -1075  # half the smallest double: 0 and it are as near as doubles come
    assert (right_digits(0.0, tiny, 15), right_digits(5e-324, tiny, 15), right_digits("0", tiny, 15)) == (15, 15, 0)
    assert right_digits(1e-323, tiny, 15) == 0.0


def matched(given: list[float], true: list[float], band: tuple[int, int] = (0, 15), held: float = 12.0) -> Any:
    question = Crossings.of(lag(20, band))
    return question.score(Found({"real": given, "imag": []}), Found({"real": [arb(x) for x in true], "imag": []}), held)


def test_each_crossing_takes_the_nearest_number_that_is_free_within_a_hundredth() -> None:
    pick = random.Random(8)
    for _ in range(25):
        true = sorted(pick.sample(range(5, 100, 5), pick.randint(1, 5)))
        errors = [pick.choice([0, 1e-5, -1e-3, 0.0099, -0.0101, 0.2]) for _ in true]
        given = [x * (1 + e) for x, e in zip(true, errors, strict=True) if e != 0.2]
        extra = [0.5 * n for n in range(pick.randint(0, 2))]
        near = [e for e in errors if abs(e) < 0.01]
        score = matched(pick.sample([*given, *extra], len(given) + len(extra)), true, (0, 100))
        assert (score.missed, score.invented) == (len(true) - len(near), len(given) - len(near) + len(extra))
        digits = min((12.0 if e == 0 else -log10(abs(e)) for e in near), default=12.0)
        assert score.digits == (0.0 if score.missed else pytest.approx(digits, abs=1e-6))
    # two for one: the nearer is taken, the other one is none; at 0 what counts is the band
    assert (matched([2.001, 2.0001], [2.0]).digits, matched([2.001, 2.0001], [2.0]).invented) == (
        pytest.approx(-log10(5e-5), rel=1e-6),
        1,
    )
    assert (matched([0.14], [0.0]).missed, matched([0.16], [0.0]).missed) == (0, 1)


def test_the_digits_of_an_answer_are_those_of_its_worst_part() -> None:
    question = Crossings.of(lag(20))
    true = {"real": [arb(2)], "imag": [arb(3)]}
    score = question.score(Found({"real": [2.002], "imag": [3.0]}), Found(true), 15)
    assert score.digits == pytest.approx(3)
    score = question.score(Found({"real": [2.0, 7.0], "imag": []}), Found(true), 15)
    assert (score.digits, score.missed, score.invented) == (0.0, 1, 1)


@given(st.lists(st.integers(0, 90), min_size=1, max_size=3, unique=True), st.integers(1, 60))
@examples(30)
@example([3], 3)  # at its corner a ratio is largest, and does not grow at all
def test_the_condition_of_a_ratio_is_how_it_grows_with_the_frequency(omegas: list[int], corner: int) -> None:
    question = RatioQuestion(lag(corner).distortion(), tuple(map(float, omegas)))
    known = [
        abs(x) for w in omegas if w for x in (Fraction(2 * corner**2, corner**2 + w * w), Fraction(corner**2 - w * w, corner**2 + w * w))
    ]  # fmt: skip
    assert question.condition == pytest.approx(float(max(known, default=0)), rel=1e-12)


def test_where_a_ratio_has_no_bound_there_is_no_condition() -> None:
    undamped = hs.Scene(SPRING, (hs.effects.second_order_lowpass(8, 0),))
    question = RatioQuestion(undamped.distortion(), (8.0,))
    assert (question.condition, question.truth(10)[0][0].is_finite()) == (0.0, False)
    # omega^2/(64 - omega^2): 128/(64 - omega^2)
    assert RatioQuestion(undamped.distortion(), (6.0,)).condition == pytest.approx(128 / 28, rel=1e-12)


@pytest.mark.parametrize("corner", [2, 7, 40])
@pytest.mark.parametrize("c", ["1/5", "1/10"])
def test_the_condition_of_a_crossing_is_how_it_moves_with_its_threshold(corner: int, c: str) -> None:
    """At r_r = c it is (w^2 + wc^2)/(2 wc^2), at r_i = c (w^2 + wc^2)/|wc^2 - w^2|."""
    ratio = Fraction(c)
    scene = lag(corner, (0, 1000), {"real": c, "imag": "2"})
    squared = ratio * corner**2 / (1 - ratio)
    assert Crossings.of(scene).condition == pytest.approx(float((squared + corner**2) / (2 * corner**2)), rel=1e-12)
    both = Crossings.of(lag(corner, (0, 1000), {"real": "2", "imag": c}))
    # w wc = c (w^2 + wc^2): both roots are equally hard
    x = (1 + (1 - 4 * float(ratio) ** 2) ** 0.5) / (2 * float(ratio))
    assert both.condition == pytest.approx((x * x + 1) / abs(x * x - 1), rel=1e-12)


def test_a_crossing_of_a_threshold_that_grows_is_as_hard_as_it_nears_it() -> None:
    """r_r = w^2/(w^2 + 400) = a + b w: the crossing moves with both, by 1/|w r'/r - w c'/c|."""
    scene = lag(20, (1, 15), {"real": "0.01 + 0.01*omega", "imag": "2"})
    [omega] = Crossings.of(scene).certified(20).omegas["real"]
    w = float(omega.mid())
    limit = 0.01 + 0.01 * w
    assert w * w / (w * w + 400) == pytest.approx(limit, rel=1e-14)
    assert Crossings.of(scene).condition == pytest.approx(1 / abs(800 / (w * w + 400) - 0.01 * w / limit), rel=1e-12)


def test_a_touch_is_infinitely_hard_and_a_crossing_at_rest_not_at_all() -> None:
    by_name = {(x.family, x.name): x.question for x in hard_cases("tangency ladder", "rational crossings")}
    assert by_name["tangency ladder", "touch"].condition == inf
    at_rest = by_name["rational crossings", "at 0 rad/s"]
    assert isinstance(at_rest, Crossings)
    assert next(float(x.mid()) for x in at_rest.certified(10).omegas["real"]) == 0
    polygon = {"shape": "polygon", "corners": [["0.1", "0"], ["0", "0.1"], ["-0.1", "0"], ["0", "-0.1"]]}
    assert Crossings.of(lag(20, (0, 15), polygon)).condition is None
    # a crossing that is not on the band is none
    assert Crossings.of(lag(20, (0, 1), {"real": "0.5", "imag": "0.5"})).condition == 0.0


@pytest.mark.parametrize("floor", [None, "0.5"])
def test_where_a_part_only_turns_its_sign_the_larger_limit_holds(floor: str | None) -> None:
    """From 1 to -1 it neither grows nor shrinks."""
    for higher, lower in (("0.2", "0.7"), ("0.7", "0.2")):
        jnd = {"real": {"higher": higher, "lower": lower}, "imag": "1"} | ({"floor": floor} if floor else {})
        [real, _] = noticed(lag(20, (0, 15), jnd).threshold)
        H, omega = np.complex128(1 + 1j), np.float64(2)
        found = {size: float(margin(real, omega, H, np.complex128(size))) for size in (-2, -1.5, 0.5)}
        least = float(floor or 0) / 2**0.5
        limits = {-2: 0.7, -1.5: float(lower), 0.5: float(higher)}
        for size, limit in limits.items():
            assert found[size] == pytest.approx(abs(size) / 2**0.5 - max(limit, least), rel=1e-12)


@given(jnds(), st.data())
@examples(60)
def test_a_margin_in_floats_is_positive_where_a_change_is_noticed(jnd: dict[str, Any], data: st.DataObject) -> None:
    scene = lag(20, (0, 15), jnd)
    numbers = st.floats(-3, 3, allow_subnormal=False).map(lambda x: round(x, 3))
    H = complex(data.draw(numbers) or 1.0, data.draw(numbers))
    G = H * (1 + complex(data.draw(numbers), data.draw(numbers)) / 10)
    omega = data.draw(st.floats(0.5, 15).map(lambda x: round(x, 3)))
    found = [
        float(margin(x, np.float64(omega), np.complex128(H), np.complex128(G - H))) for x in noticed(scene.threshold)
    ]
    known = regions.margin(jnd, H, G, omega)
    if abs(known) > 1e-9:
        assert (max(found) > 0) == (known > 0)
    if "shape" not in jnd:
        assert max(found) == pytest.approx(known, abs=1e-12)


# The usual ways


def test_a_ratio_that_is_one_number_is_answered_for_every_frequency() -> None:
    """Behind a gain of 5/4 both formulas are numbers; large whole numbers stay numbers of NumPy."""
    gain = hs.Scene(hs.environments.mass_spring_damper(k=10**30), (hs.effects.series("5/4"),))
    answer = naive_way(RatioQuestion(gain.distortion(), (1.0, 2.0, 3.0)))()
    assert answer == pytest.approx(np.array([[0.25, 0.0]] * 3))


def known_crossings(c: float, corner: float, band: tuple[float, float]) -> Found:
    """Of a lag: w = wc sqrt(c/(1 - c)), and w/wc + wc/w = 1/c."""
    half = 1 / (2 * c)
    imag = [corner * (half + sign * (half * half - 1) ** 0.5) for sign in (-1, 1)]
    real = [corner * (c / (1 - c)) ** 0.5]
    return Found(
        {n: sorted(arb(x) for x in row if band[0] <= x <= band[1]) for n, row in (("real", real), ("imag", imag))}
    )


@pytest.mark.parametrize("c", ["0.2", "0.4"])
@pytest.mark.parametrize("band", [(0, 90), (9, 41), (11, 39)])
def test_grids_and_eigenvalues_find_what_a_formula_gives(c: str, band: tuple[int, int]) -> None:
    question = Crossings.of(lag(20, band, c))
    known = known_crossings(float(c), 20.0, band)
    for answer, least in ((companion_way(question)(), 13), (grid_way(question, 200, brent=True)(), 13), (grid_way(question, 2000)(), 4)):  # fmt: skip
        score = question.score(answer, known, DOUBLE)
        assert (score.missed, score.invented, score.digits > least) == (0, 0, True)
    for name in ("numpy.roots", "grid of 10^4 + Brent", "certified, 50 digits"):
        assert question.score(CROSSINGS[name].ready(question)(), known, 13).digits > 12.9


def test_between_points_of_a_grid_a_crossing_is_where_a_straight_line_meets_the_threshold() -> None:
    corner, c = 20.0, 0.2
    for points in (12, 40):
        [found] = grid_way(Crossings.of(lag(20, (1, 17), {"real": "0.2", "imag": "2"})), points)().omegas["real"]
        at = np.linspace(1, 17, points)
        over = at**2 / (at**2 + corner**2) - c
        assert found == pytest.approx(float(np.interp(0, over, at)), rel=1e-12)
        assert 1e-5 < abs(found - 10) < 0.1


@pytest.mark.parametrize(("band", "times"), [((0, 32768), 1), ((0, 16384), 1), ((16384, 32768), 1), ((0, 16383), 0)])
def test_a_crossing_at_a_point_of_the_grid_counts_once_also_where_blocks_meet(
    band: tuple[int, int], times: int
) -> None:
    """r_r = 1/2 exactly at the corner, whose float is a point of the grid, the last of a block and the first of the next."""
    scene = lag(16384, band, {"real": "0.5", "imag": "2"})
    answer = grid_way(Crossings.of(scene), band[1] - band[0] + 1)()
    assert answer.omegas["real"] == [16384.0] * times
    assert answer.omegas["imag"] == []


def test_eigenvalues_are_those_of_the_equation_also_where_it_holds_odd_powers() -> None:
    """r_r = (1 + w)/10 behind a lag of 3 rad/s: w^3 - 9 w^2 + 9 w + 9 = 0."""
    question = Crossings.of(lag(3, (0, 15), {"real": "(1 + omega)/10", "imag": "2"}))
    known = sorted(x.real for x in np.roots([1, -9, 9, 9]) if x.real > 0)
    assert companion_way(question)().omegas["real"] == pytest.approx(known, rel=1e-12)
    assert grid_way(question, 500, brent=True)().omegas["real"] == pytest.approx(known, rel=1e-12)
    irrational = Crossings.of(lag(3, (0, 15), Threshold.of(sqrt(2) / 10, 2)))
    with pytest.raises(RefusedError, match="the threshold is not rational"):
        companion_way(irrational)
    with pytest.raises(RefusedError, match="not a polynomial"):
        companion_way(Crossings.of(hs.Scene(SPRING, (hs.effects.delay("0.1 s"),), (0, 15), "0.1")))


def test_what_a_method_holds_and_proves() -> None:
    held = {x.name: (x.held, x.proves, x.ours, x.at_once) for x in (*RATIO_METHODS.values(), *CROSSINGS.values())}
    usual = (DOUBLE, False, False, True)
    assert pytest.approx(15.95459, abs=1e-5) == DOUBLE
    assert held == {
        **dict.fromkeys(["H_perc - H_env in floats", "python-control", "scipy.signal", "numpy.roots", "grid of 10^4 + Brent"], usual),
        **{f"grid of 10^{n}": usual for n in (2, 3, 4, 5, 6)},
        **{name: (DOUBLE, name == "certified", True, True) for name in ("fast", "double-double", "certified")},
        **{f"{n} digits": (n, True, True, False) for n in (30, 100, 300)},
        **{f"certified, {n} digits": (n, True, True, True) for n in (15, 50, 100, 300, 1000)},
    }  # fmt: skip
    for n in (2, 3, 4):
        question = Crossings.of(lag(20, (0, 10**n - 1), {"real": "0.2", "imag": "2"}))
        assert CROSSINGS[f"grid of 10^{n}"].ready(question)().omegas["real"] == [10.0]  # its points are whole numbers


# Hard cases


def ladder(c: Fraction) -> list[float]:
    """Where 0.4 * 2 w^2/((9 - w^2)^2 + 4 w^2) = c: the roots of a square in w^2."""
    c_ = mpmath.mpf(c.numerator) / c.denominator
    half = (14 + mpmath.mpf("0.8") / c_) / 2
    rest = half * half - 81
    return (
        []
        if rest < 0
        else sorted({float(mpmath.sqrt(half - mpmath.sqrt(rest))), float(mpmath.sqrt(half + mpmath.sqrt(rest)))})
    )


def test_the_ladders_are_named_by_how_far_they_are_from_a_touch() -> None:
    named = {x.name: x.question for x in hard_cases("tangency ladder")}
    assert set(named) == {"touch", *(f"10^-{k} {word}" for k in range(1, 41) for word in ("above", "below"))}
    with mpmath.workdps(80):
        for name in ("touch", "10^-1 below", "10^-2 below", "10^-3 above", "10^-30 below", "10^-40 above"):
            question = named[name]
            assert isinstance(question, Crossings)
            k = 0 if name == "touch" else int(name.split()[0][4:])
            c = Fraction(1, 5) + (0 if not k else Fraction(1 if "above" in name else -1, 10**k))
            found = [float(x.mid()) for x in question.certified(15).omegas["real"]]
            assert found == pytest.approx(
                [x for x in ladder(c) if x <= 15] if c < Fraction(1, 5) else [3.0] * (not k), rel=1e-14
            )
            assert question.certified(15).omegas["imag"] == []
    late = {x.name: x.question for x in hard_cases("tangency ladder, delayed")}
    assert set(late) == {f"10^-{k} {word}" for k in range(1, 41, 3) for word in ("above", "below")}
    for name, c in (("10^-1 below", 0.9), ("10^-1 above", 1.1), ("10^-4 below", 1 - 1e-4)):
        question = late[name]
        assert isinstance(question, Crossings)
        known = [5 * np.arcsin(c), 5 * (pi - np.arcsin(c))] if c < 1 else []
        assert [float(x.mid()) for x in question.certified(15).omegas["imag"]] == pytest.approx(
            [x for x in known if x <= 12]
        )
        assert question.certified(15).omegas["real"] == []


LOWPASS = {
    "low frequencies": lambda name: ("9/5", 15, 100, 80, "1/2"),
    "light damping": lambda name: ("9/5", f"1e-{name.split()[2][4:] or 0}", 100, 80, "1/2"),
    "zeta = 1/2": lambda name: ("9/5", "1e-6", 100, 80, "1/2" if name == "exactly" else "0.500000000001"),
    "wide ranges": lambda name: {
        "light and stiff": ("1e-9", 1, "1e9", "1e9", "1e-9"),
        "heavy and soft": ("1e9", 1, "1e-9", "1e-9", "1e9"),
        "light damping": (1, "1e-9", 1, 1, "1e-9"),
    }[name],
    "poles on the axis": lambda name: ("9/5", 15, 100, 80, 0),
}
COUNTED = {"low frequencies": 9, "light damping": 13, "zeta = 1/2": 2, "wide ranges": 3, "poles on the axis": 2, "cascades, values": 3,
           "stiff delays, values": 5, "identities": 3, "H_env(0) = 0": 3, "tangency ladder": 81, "tangency ladder, delayed": 28,
           "cascades, crossings": 3, "clustered thresholds": 3, "Mignotte-like thresholds": 3, "resonance behind a delay": 4,
           "long delays": 2, "rational crossings": 6, "cancelled resonance": 2}  # fmt: skip


def test_values_that_are_hard_are_those_of_the_scene_that_their_name_tells() -> None:
    """A low-pass on a mass, damper and spring, in 400 digits; and which frequencies are asked about."""
    assert {family: len(hard_cases(family)) for family in FAMILIES} == COUNTED
    resonance = mpmath.sqrt(mpmath.mpf(500) / 9)
    with mpmath.workdps(400):
        for family, told in LOWPASS.items():
            for case in hard_cases(family):
                question = case.question
                assert isinstance(question, RatioQuestion)
                m, b, k, wn, zeta = (
                    mpmath.mpf(Fraction(x).numerator) / Fraction(x).denominator for x in map(Fraction, told(case.name))
                )
                for w, found in zip(question.omegas, question.truth(12), strict=True):
                    s = mpmath.mpc(0, mpmath.mpf(w))
                    H, below = m * s**2 + b * s + k, s**2 + 2 * zeta * wn * s + wn**2
                    if below == 0:
                        assert not found[0].is_finite()
                        continue
                    dH = H * (wn**2 / below - 1)
                    for ball, part in zip(found, (dH.real, dH.imag), strict=True):
                        assert float(ball.mid()) == pytest.approx(float(abs(part) / abs(H)), rel=1e-10, abs=1e-320)
    omegas = {
        x.name: x.question.omegas
        for x in hard_cases("low frequencies", "light damping", "zeta = 1/2", "wide ranges", "poles on the axis")
    }  # type: ignore[union-attr]
    assert omegas["at 10^-150 rad/s"] == (1e-150,)
    assert [x / float(resonance) - 1 for x in omegas["b = 10^-3 N s/m"]] == pytest.approx(
        [0, 1e-12, -1e-9, 1e-3], rel=1e-3, abs=3e-16
    )
    assert omegas["exactly"] == omegas["nearly"] == tuple(10.0**-k for k in range(9))
    assert omegas["light damping"] == (1e-9, 1.0, 1e9, 1e30, 1e80, 1e150)
    assert (omegas["at the pole"], omegas["beside the pole"]) == ((80.0,), (80 * (1 + 1e-12), 80 * (1 - 1e-9), 79.0))
    values = {(x.family, x.name): x.question for x in hard_cases("identities", "H_env(0) = 0", "stiff delays, values")}
    for (family, name), question in values.items():
        assert isinstance(question, RatioQuestion)
        truth = [[float(x.mid()) for x in row] for row in question.truth(12)]
        if family == "identities":
            assert (question.omegas, truth) == ((1e-3, 1.0, 7.0, 1e3), [[0.0, 0.0]] * 4)
        if name == "a shunt damper":  # j w over |-2 w^2 + 5 j w|
            assert [x for _, x in truth] == pytest.approx([1 / (4 * w * w + 25) ** 0.5 for w in (0.0, 1e-150, 1.0)])
        if name == "a lag":  # (-2 w^2 + 5 j w)(-j w)/(20 + j w) over |-2 w^2 + 5 j w|
            assert question.omegas == (0.0, 1e-150, 1e-8, 1.0)
            H = complex(-2, 5)
            assert truth[3] == pytest.approx(
                [abs((H * -1j / (20 + 1j)).real) / abs(H), abs((H * -1j / (20 + 1j)).imag) / abs(H)]
            )
        if name == "a mass alone":  # 6400/(6400 - w^2 + 80 j w) - 1
            assert question.omegas == (0.0, 1e-100, 1e-8, 1.0)
            D = 6400 / (6399 + 80j) - 1
            assert truth[3] == pytest.approx([abs(D.real), abs(D.imag)])
        if family == "stiff delays, values":
            tau, w = 10.0 ** int(name.split()[0][3:]), 15.0
            H, at = complex(100 - 1.8 * w * w, 15 * w), question.omegas.index(w)
            dH = H * (np.exp(-1j * w * tau) - 1)
            assert truth[at] == pytest.approx([abs(dH.real) / abs(H), abs(dH.imag) / abs(H)], rel=1e-5)


def test_crossings_that_are_hard_lie_where_their_name_tells() -> None:
    def found(family: str, name: str) -> list[list[float]]:
        [question] = [x.question for x in hard_cases(family) if x.name == name]
        assert isinstance(question, Crossings)
        return [[float(x.mid()) for x in question.certified(17).omegas[part]] for part in ("real", "imag")]

    for n in (4, 10):  # s^2 = -x: crossings at sqrt(x), and where the product is -2/10
        real, imag = found("clustered thresholds", f"{n} crossings")
        known = [(1 + i / 10_000) ** 0.5 for i in range(1, n + 1)]
        assert imag == []
        assert [x for x in real if 1 < x < known[-1] + 1e-4] == pytest.approx(known, rel=1e-14)
    for n, a in ((6, 10), (10, 100)):  # x = w^2: x^n = 2 (a x - 1)^2, or that less 1/5: twice near 1/a, and far from it
        real, _ = found("Mignotte-like thresholds", f"degree {n}")
        row = np.zeros(n + 1)
        row[0], row[-3:] = 1, (-2 * a * a, 4 * a, -2)
        zeros = [x.real for c in (0, 0.2) for x in np.roots([*row[:-1], row[-1] + c]) if abs(x.imag) < 1e-5 < x.real]
        assert real == pytest.approx(sorted(x**0.5 for x in zeros if x < 4), rel=1e-4)
    assert found("rational crossings", "band 0 to 0.15 rad/s")[0] == pytest.approx([0.15])
    assert found("rational crossings", "band 0.15 to 1 rad/s")[0] == pytest.approx([0.15])
    assert found("rational crossings", "band 0.05 to 0.25 rad/s")[0] == pytest.approx([0.15])
    assert found("rational crossings", "at 5 pi rad/s")[0] == pytest.approx([5 * pi])
    # a shunt of 10 N/m beside 100 - w^2: 10/|100 - w^2| = 1/10 at 0 alone, of this band
    assert found("rational crossings", "at 0 rad/s") == [[0.0], []]
    [question] = [x.question for x in hard_cases("long delays") if x.name == "2 s up to 60 rad/s"]
    assert isinstance(question, Crossings)
    assert [x.name for x in hard_cases("long delays")] == ["0.5 s up to 150 rad/s", "2 s up to 60 rad/s"]
    w = np.linspace(0, 60, 200_001)[1:]
    H, s = 100 - 1.8 * w * w + 15j * w, 1j * w
    dH = H * (6400 * np.exp(-2 * s) / (s * s + 80 * s + 6400) - 1)
    for part, x in (("real", dH.real), ("imag", dH.imag)):
        over = np.abs(x) / np.abs(H) > 0.1
        assert len(question.certified(10).omegas[part]) == np.count_nonzero(over[1:] != over[:-1]) > 9


def methods(*answers: Any, held: float = 10.0, **flags: Any) -> list[Method]:
    def ready(answer: Any) -> Callable[[Any], Any]:
        def prepare(question: Any) -> Callable[[], Any]:
            if isinstance(answer, RefusedError):
                raise answer
            if isinstance(answer, SceneError):

                def attempt() -> Any:
                    raise answer

                return attempt
            return lambda: answer

        return prepare

    return [Method(f"way {i}", ready(x), held=held, **flags) for i, x in enumerate(answers)]


def test_a_verdict_says_how_an_answer_fares() -> None:
    """True: r_r = 4/5, r_i = 2/5 at 40 rad/s behind a lag of 20; crossings of 1/5 at 10 rad/s."""
    asked = HardCase("identities", "own", RatioQuestion(lag(20).distortion(), (40.0,)))
    rows = put(asked, methods(
        [(0.8, 0.4)], [(0.8 * (1 + 5e-9), 0.4)], [(0.8 * (1 + 2e-9), 0.4)], [(0.8, 0.4 * (1 + 2e-4))], [(0.8, 0.5)],
        RefusedError("no such thing"), SceneError("not this one"), ours=True, proves=True,
    ))  # fmt: skip
    assert [row.verdict for row in rows] == [
        "right", "loses 2 digits", "right", "loses 6 digits", "wrong", "cannot: no such thing", "cannot: not this one",
    ]  # fmt: skip
    assert [row.proven for row in rows] == [True] * 5 + [False] * 2
    assert [row.answered for row in rows] == [True] * 5 + [False] * 2
    assert {(row.family, row.case, row.ours, row.task) for row in rows} == {("identities", "own", True, "evaluate")}
    assert rows[0].condition == rows[-1].condition == pytest.approx(0.6)
    assert (rows[5].digits, rows[5].seconds) == (0.0, 0.0)
    scene = lag(20, (0, 15), {"real": "1/5", "imag": "2"})
    crossings = HardCase("identities", "own", Crossings.of(scene))
    rows = put(crossings, methods(
        Found({"real": [10.0], "imag": []}), Found({"real": [], "imag": []}), Found({"real": [10.0, 3.0], "imag": [7.0]}),
        Found({"real": [3.0], "imag": []}), Found({"real": [10.0], "imag": []}, undecided=1), proves=True,
    ))  # fmt: skip
    assert [row.verdict for row in rows] == ["right", "misses 1", "invents 2", "misses 1 and invents 1", "undecided"]
    assert [(row.missed, row.invented, row.proven, row.ours) for row in rows] == [
        (0, 0, True, False), (1, 0, True, False), (0, 2, True, False), (1, 1, True, False), (0, 0, False, False),
    ]  # fmt: skip
    assert {row.task for row in rows} == {"crossings"}


# The whole of it, by a clock that goes on by a second each time that somebody looks


@pytest.fixture
def ticking(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = count()
    monkeypatch.setattr(stopwatch, "perf_counter", lambda: float(next(looks)))


@pytest.mark.usefixtures("ticking")
def test_a_quick_look_at_a_lag_is_what_a_second_for_each_attempt_makes_of_it() -> None:
    """Each is asked once, as one second is long; floats for 19 frequencies fifty-two times over, digits for 19."""
    told: list[tuple[str, float]] = []
    cost = hs.cost(lag(20, (1, 12)), quick=True, told=lambda *x: told.append(x))
    ways = {task: [row.method for row in cost.task(task)] for task in ("evaluate", "crossings", "delay", "effects")}
    assert ways == {
        "evaluate": ["H_perc - H_env in floats", "fast", "double-double", "certified", "30 digits", "100 digits"],
        "crossings": [*(f"grid of 10^{n}" for n in (2, 3, 4, 5)), "grid of 10^4 + Brent", "numpy.roots",
                      *(f"certified, {n} digits" for n in (15, 50, 100))],
        "delay": [],
        "effects": ["all effects", "without first-order-lag"],
    }  # fmt: skip
    even, decades = [1 + 1.1 * n for n in range(1, 11)], [12 ** (n / 10) for n in range(10)]
    omegas = sorted({*even, *decades})
    assert len(omegas) == 20
    assert [row.seconds for row in cost.task("evaluate")] == [1 / 1000] * 4 + [1 / 20] * 2
    assert {row.seconds for task in ("crossings", "effects") for row in cost.task(task)} == {1.0}
    shares = [share for _, share in told]
    assert shares == pytest.approx([n / 20 for n in range(21)])
    assert [what for what, _ in told] == [
        *(f"evaluate: {x}" for x in [*ways["evaluate"], "right digits"]),
        *(f"crossings: {x}" for x in [*ways["crossings"], "right digits"]),
        *(f"effects: {x}" for x in [*ways["effects"], "right digits"]), "",
    ]  # fmt: skip
    # 2 wc^2/(w^2 + wc^2) is largest at the lowest frequency; (w^2 + wc^2)/(2 wc^2) and its like at the crossings
    assert cost.condition["evaluate"] == pytest.approx(800 / 401, rel=1e-9)
    x = (1 + 0.96**0.5) / 0.2
    assert (
        cost.condition["crossings"] == cost.condition["effects"] == pytest.approx((x * x + 1) / (x * x - 1), rel=1e-9)
    )
    proven = {row.method: row.digits for row in cost.rows if row.proven}
    assert proven == {"certified": DOUBLE, "30 digits": 30, "100 digits": 100, "all effects": 15, **{f"certified, {n} digits": n for n in (15, 50, 100)}}  # fmt: skip
    # without its only effect nothing is felt otherwise: sqrt(400/9) and 20 (5 - sqrt(24)) are missed
    gone = cost.task("effects")[1]
    assert (gone.missed, gone.invented, gone.digits, gone.proven) == (2, 0, 0.0, False)
    assert cost.left_out == ()
    floats = dict(zip(ways["evaluate"], (row.digits for row in cost.task("evaluate")), strict=True))
    assert 11 < floats["H_perc - H_env in floats"] < floats["double-double"] == DOUBLE
    document = cost.to_dict()
    assert (document["band"], document["machine"], document["left_out"]) == ([1.0, 12.0], dict(cost.machine), [])
    assert [set(row) for row in document["rows"]] == [
        {"task", "method", "digits", "seconds", "proven", "missed", "invented"}
    ] * 17


@pytest.mark.usefixtures("ticking")
def test_a_simulation_is_asked_with_one_setting_changed_at_a_time() -> None:
    felt = hs.environments.maxwell(100, 1000)  # its 10 s are the transient
    scene = hs.Scene(felt, (hs.effects.first_order_lag(20), hs.effects.shunt(b=1)), (0, 5), "0.1")
    threads: set[int] = set()

    def told(*_: object) -> None:
        threads.update(x["num_threads"] for x in threadpoolctl.threadpool_info() if x["user_api"] == "blas")

    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        rows = hs.simulation_cost(scene, quick=True, told=told).rows
    assert threads == {1}  # as a simulation has it
    assert [row.method for row in rows] == [
        *(f"steps of {x} rad" for x in (7.2, 5.4, 3.6, 2.7, 1.8, 0.9, 0.45)),
        *(f"transient of 1e-{n}" for n in ("01", "03", "06", "09")),
        "1 period", "2 periods", "3 periods", "6 periods", "without first-order-lag", "without shunt",
    ]  # fmt: skip
    digits = {row.method: row.digits for row in rows}
    assert digits["steps of 7.2 rad"] < digits["steps of 5.4 rad"] - 1 < digits["steps of 3.6 rad"] - 2 < DOUBLE
    left = [digits[f"transient of 1e-{n}"] for n in ("01", "03", "06", "09")]
    assert left == sorted(left)
    assert 3 < left[0] < left[1] - 1 < left[2] - 3 < left[3]
    assert min(digits[x] for x in ("steps of 1.8 rad", "steps of 0.9 rad", "steps of 0.45 rad", "6 periods")) > 12
    # without its damper the force lacks b s, without its lag 1/(1 + s/20): told by the worst of five frequencies
    omegas = [1j * n for n in range(1, 6)]
    felt = [100 * s / (s + 0.1) for s in omegas]
    whole = [H / (1 + s / 20) + s for H, s in zip(felt, omegas, strict=True)]
    late, early = (
        [H / x + y for H, x, y in zip(felt, *row, strict=True)]
        for row in (([1 + s / 20 for s in omegas], [0] * 5), ([1] * 5, omegas))
    )
    for name, gone in (("without shunt", late), ("without first-order-lag", early)):
        worst = max(abs(a / b - 1) for a, b in zip(gone, whole, strict=True))
        assert digits[name] == pytest.approx(-log10(worst), abs=1e-6)
    assert {(row.task, row.seconds, row.proven) for row in rows} == {("simulation", 1.0, False)}


def test_a_page_of_what_was_measured_says_each_number_once() -> None:
    rows = (
        Measurement("evaluate", "fast", 15.4321, 2e-7, NO),
        Measurement("evaluate", "30 digits", 30, 5e-5, YES),
        *PROVEN,
        crossing("grid of 10^2", 19.96, 1e-3, missed=1, invented=2),
        crossing("grid of 10^3", 20.0, 1e-3),
        Measurement("sweep", "grid of 10^2, halved", 9, 1e-4, NO, 3, 0, 1, 8, 7, 9),
    )
    left = (Omission("delay", "Pade, order 2", "no delay"),)
    condition = {"evaluate": 2.345, "crossings": inf}
    cost = Cost(lag(20), rows, left, condition, {"CPython": "9.9", "processors": "3 x z80"})
    lines = [" ".join(line.split()) for line in str(cost).splitlines()]
    flat = " ".join(" ".join(lines).split())
    for line in (
        "fast 15.4 200 ns no", "30 digits 30 50 us yes", "certified, 50 digits 50 2 s yes", "certified, 15 digits 15.0 250 ms yes",
        "grid of 10^2 20.0 1 ms no misses 1 and invents 2", "grid of 10^3 20 1 ms no", "grid of 10^2, halved 9.0 100 us no 12 % of 8 sets",
        "method right digits time proven sets with a wrong count",
        "The ratios r_r and r_i: time for one frequency (condition number 2.3)",
        "The crossings on the band: time for all of them (condition number infinite: a touch)",
        "A sweep over sets of parameters: time for a set",
    ):  # fmt: skip
        assert lines.count(line) == 1, line
    for sentence in (
        summary(rows), "grid of 10^2, halved: 7 of 9 sets were not reached within the limit of time.",
        "Left out: Pade, order 2 (no delay).", "Measured on CPython 9.9, processors 3 x z80.",
    ):  # fmt: skip
        assert flat.count(sentence) == 1, sentence
    assert "delays" not in flat
    assert (cost.certified, repr(cost)) == (False, '<Cost "Untitled scene": 7 measurements>')
    document = cost.to_dict()
    assert (document["condition"], document["left_out"]) == (
        {"evaluate": 2.345, "crossings": None}, [{"task": "delay", "method": "Pade, order 2", "reason": "no delay"}],
    )  # fmt: skip
    assert document["rows"][0] == {
        "task": "evaluate", "method": "fast", "digits": 15.4321, "seconds": 2e-7, "proven": False, "missed": 0, "invented": 0,
    }  # fmt: skip


def test_a_page_of_hard_cases_has_a_line_for_each_family_and_method() -> None:
    two = {"family": "tangency ladder", "condition": inf}
    rows = (
        hard("right", 15.96, ours=True, proven=True, method="certified", condition=2.0, seconds=1.0),
        hard("right", 15.0, ours=True, method="certified", case="b", condition=7.0, seconds=4.0),
        hard("loses 3 digits", 12.0, method="floats", seconds=2e-3),
        hard("cannot: no delays", 0.0, method="control", seconds=0.0),
        replace(hard("misses 2", 0.0, method="grid", seconds=3e-3, missed=2, **two), task="crossings"),
    )
    costs = HardCosts(rows, {"CPython": "9.9"})
    lines = [" ".join(line.split()) for line in str(costs).splitlines()]
    flat = " ".join(" ".join(lines).split())
    for line in (
        "certified 2/2 15.0 2.5 s no", "floats 0/1 12.0 2 ms no loses 3 digits", "control cannot: no delays",
        "grid 0/1 0.0 3 ms no misses 2", "2 questions about values of r_r and r_i, condition number up to 7.",
        "1 question about crossings, condition number up to infinity.",
        f"identities: {FAMILIES['identities']}", f"tangency ladder: {FAMILIES['tangency ladder']}",
    ):  # fmt: skip
        assert lines.count(line) == 1, line
    assert flat.count(hard_summary(rows)) == flat.count("Measured on CPython 9.9.") == 1
    assert "light damping" not in flat
    assert (costs.certified, repr(costs)) == (False, "<HardCosts 5 answers>")
    document = costs.to_dict()
    assert [row["condition"] for row in document["rows"]] == [2.0, 7.0, 1.0, 1.0, None]
    assert (document["families"], document["summary"]) == (FAMILIES, hard_summary(rows))


# Sweeps


RANGED = """
[environment]
model = "mass-spring-damper"
m = [0.5, 2, 50]
b = 0
k = 50
[[effects]]
model = "second-order-lowpass"
omega_n = 80
zeta = 0.75
[[effects]]
model = "shunt"
b = [-3, -2, 1]
[[effects]]
name = "backwards"
model = "shunt"
m = -0.5
[[effects]]
model = "delay"
tau = "0 s"
[evaluation]
band = [0, 15]
jnd = 0.2
"""


def test_sets_are_drawn_evenly_in_the_logarithm_from_half_to_twice_or_over_a_range() -> None:
    """Of 1024 numbers a quarter lies in each quarter, but for a few; 0 is left out."""
    scene = hs.parse_scene(RANGED.replace('[[effects]]\nmodel = "delay"\ntau = "0 s"\n', ""))
    question = SweepQuestion.of(scene, [], quick=True)
    ends = {
        "m": (0.5, 50),
        "k": (25, 100),
        "omega_n": (40, 160),
        "zeta": (0.375, 1.5),
        "b_shunt": (-3, 1),
        "m_backwards": (-0.25, -1),
    }
    names = [x.symbol.name for x in question.knobs]
    assert sorted(names) == sorted(ends)
    assert question.values.shape == (6, 1024)
    for name, row in zip(names, question.values, strict=True):
        low, high = ends[name]
        assert min(low, high) <= row.min() < row.max() <= max(low, high)
        place = (row - low) / (high - low) if low < 0 < high else np.log(row / low) / np.log(high / low)
        assert np.histogram(place, 4, (0, 1))[0] == pytest.approx(256, abs=60), name
    again = SweepQuestion.of(scene, ["zeta"], quick=True)
    assert again.values.shape == (1, 1024)
    assert SweepQuestion.of(scene, ["zeta"], quick=True).values.tolist() == again.values.tolist()


def answers(real: list[float], first: list[float], left: tuple[int, ...] = ()) -> Answers:
    none = np.zeros(len(real))
    return Answers(
        [("crossings_real", np.array(real)), ("first_crossing_real", np.array(first)), ("crossings_imag", none), ("first_crossing_imag", none * nan)],
        len(real) + len(left), left,
    )  # fmt: skip


def test_sets_with_a_wrong_count_are_counted_and_the_digits_of_the_others() -> None:
    """Behind a lag of wc r_r = 1/5 at wc/2: one crossing if that is on the band, which ends at 15 rad/s, and none beyond."""
    question = SweepQuestion.of(lag(20, (1, 15), {"real": "0.2", "imag": "2"}), ["omega_c"], quick=True)
    question = replace(question, values=np.array([[12.0, 20.0, 28.0, 40.0]]), patience=inf)
    truth = question.truth
    assert [(row["crossings_real"], row["crossings_imag"]) for row in truth] == [(1, 0), (1, 0), (1, 0), (0, 0)]
    assert [row["first_crossing_real"] for row in truth[:3]] == pytest.approx([6, 10, 14], rel=1e-12)
    right = question.score(answers([1, 1, 1, 0], [6, 10, 14, nan]))
    assert (right.digits, right.missed, right.invented, right.wrong) == (pytest.approx(DOUBLE, abs=1), 0, 0, (0, 4))
    worse = question.score(answers([1, 1, 1, 0], [6.006, 10, 14.00014, nan]))
    assert (worse.digits, worse.wrong) == (pytest.approx(3, abs=1e-6), (0, 4))
    bad = question.score(answers([0, 3, 1, 1], [nan, 11, 14 * (1 + 1e-6), 3]))
    assert (bad.digits, bad.missed, bad.invented, bad.wrong) == (pytest.approx(6, abs=1e-6), 1, 3, (3, 4))
    cut = question.score(answers([1, 1, 1], [6, 10.001, 14], (3,)))
    assert (cut.digits, cut.wrong) == (pytest.approx(4, abs=1e-6), (0, 3))
    assert question.score(answers([1, 1, 1, 0], [nan, 10, 14, nan])).digits == 0.0
    with pytest.raises(LimitError, match="no set was answered"):
        answers([], [], (0, 1))
    assert answers([1], [2.0], (1, 2)).answered == 1


@pytest.mark.parametrize("path", ["tau", "environment.b", "jnd"])
def test_a_sweep_varies_numbers_of_the_display_that_are_not_0(path: str) -> None:
    with pytest.raises(SceneError, match="cannot be varied here: only numbers of the display can, other than 0"):
        SweepQuestion.of(hs.parse_scene(RANGED), [path], quick=True)


def test_without_a_word_everything_varies_that_can() -> None:
    scene = hs.Scene(hs.environments.spring_pot(80, "0.8", 50), (hs.effects.pade_delay("2 ms", 3),), (0, 15), "0.1")
    question = SweepQuestion.of(scene, [], quick=True)
    varied = {x.symbol.name: row for x, row in zip(question.knobs, question.values, strict=True)}
    assert set(varied) == {"k_alpha", "alpha", "k", "tau"}
    assert 0.4 <= varied["alpha"].min() < 0.5 < 0.85 < varied["alpha"].max() <= 0.9  # a fraction of 1 stays one
    assert question.values.shape == (4, 64)  # each is answered exactly, one by one
    fixed = hs.Scene(hs.environments.expression("100 + 3*s"), (hs.effects.series("1/(1 + s)"),), (0, 15), "0.1")
    with pytest.raises(SceneError, match="this scene has none that could be"):
        SweepQuestion.of(fixed, [], quick=True)


# Approximants, and what is left out.


def through(felt: Any, *matrices: tuple[Any, ...]) -> Any:
    for a, b, c, d in matrices:
        felt = (a * felt + b) / (c * felt + d)
    return felt


def test_an_approximant_stands_for_each_delay_and_its_inverse_for_a_lead_and_an_effect_left_out_is_gone() -> None:
    """Pade approximants of e^-x of equal degrees, by their factorials; waves hold e^(s tau) and e^(-s tau)."""
    scene = hs.Scene(
        hs.environments.mass_spring_damper("0.5", 3, 40),
        (hs.effects.delay("30 ms"), hs.effects.first_order_lag(40), hs.effects.wave_variables(12, "20 ms")),
    )
    with mpmath.workdps(30):
        b, tau, T, w, s = 12, mpmath.mpf("0.02"), mpmath.mpf("0.03"), 40, mpmath.mpc(1, 7)
        H = s * s / 2 + 3 * s + 40
        for order in (1, 2, 5):
            row = [mpmath.factorial(2 * order - k) * mpmath.binomial(order, k) for k in range(order + 1)]

            def pade(x: Any, row: list[Any] = row) -> Any:
                return mpmath.fsum(c * (-x) ** k for k, c in enumerate(row)) / mpmath.fsum(
                    c * x**k for k, c in enumerate(row)
                )

            lead, lag = 1 / pade(s * tau), pade(s * tau)
            even, odd = (lead + lag) / 2, (lead - lag) / 2
            waves = (even, b * s * odd, odd / (b * s), even)
            delay, late = (pade(s * T), 0, 0, 1), (w / (s + w), 0, 0, 1)
            found = approximated(scene.distortion(), order).perc.expression()
            own = sympy.lambdify(hs.s, found.xreplace({p.symbol: p.value for p in scene.parameters}), "mpmath")(s)
            assert abs(own / through(H, delay, late, waves) - 1) < 1e-20, order
        exact = (
            (mpmath.exp(-s * T), 0, 0, 1),
            late,
            (mpmath.cosh(s * tau), b * s * mpmath.sinh(s * tau), mpmath.sinh(s * tau) / (b * s), mpmath.cosh(s * tau)),
        )
        for i in range(3):
            found = without(scene.distortion().chain, i).perc.expression()
            own = sympy.lambdify(hs.s, found.xreplace({p.symbol: p.value for p in scene.parameters}), "mpmath")(s)
            assert abs(own / through(H, *exact[:i], *exact[i + 1 :]) - 1) < 1e-20, i
