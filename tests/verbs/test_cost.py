"""What accuracy costs: digits of known errors, conditions that have a closed form, and crossings that the usual ways find, miss and invent."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from functools import partial
from itertools import groupby, pairwise
from math import inf, log10, nan, pi
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
import regions
import sympy
from click.testing import CliRunner
from flint import arb
from hypothesis import assume, example, given
from hypothesis import strategies as st
from jnds import jnds
from marks import examples
from sympy import Symbol

import haptisym as hs
from haptisym.cli import app
from haptisym.judge.crossings import noticed
from haptisym.kernel.errors import SceneError
from haptisym.verbs.cost.entry import Cost, CostMeasurement, approximated, interleaved, without
from haptisym.verbs.cost.hardcosts import hard_cases
from haptisym.verbs.cost.methods import (
    CROSSINGS,
    DOUBLE,
    RATIO_METHODS,
    Crossings,
    FoundCrossings,
    RatioQuestion,
    UnfitMethodError,
    companion_way,
    control_way,
    grid_way,
    margin,
    naive_way,
    right_digits,
    scipy_way,
)

SPRING = hs.environments.mass_spring_damper(k=100)


def lag(omega_c: Any, band: tuple[Any, Any] = (0, 15), jnd: Any = "0.1") -> hs.Scene:
    """A spring behind a lag: r_r = w^2/(w^2 + wc^2), r_i = w wc/(w^2 + wc^2)."""
    return hs.Scene(SPRING, (hs.effects.first_order_lag(omega_c),), band, jnd)


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
    return question.score(
        FoundCrossings({"real": given, "imag": []}), FoundCrossings({"real": [arb(x) for x in true], "imag": []}), held
    )


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


@given(st.lists(st.integers(0, 90), min_size=1, max_size=3, unique=True), st.integers(1, 60))
@examples(30)
@example([3], 3)  # at its corner a ratio is largest, and does not grow at all
def test_the_condition_of_a_ratio_is_how_it_grows_with_the_frequency(omegas: list[int], corner: int) -> None:
    question = RatioQuestion(lag(corner).distortion(), tuple(map(float, omegas)))
    known = [
        abs(x) for w in omegas if w for x in (Fraction(2 * corner**2, corner**2 + w * w), Fraction(corner**2 - w * w, corner**2 + w * w))
    ]  # fmt: skip
    assert question.condition == pytest.approx(float(max(known, default=0)), rel=1e-12)


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


@pytest.mark.slow
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
    assume(abs(known) > 1e-9)
    assert (max(found) > 0) == (known > 0)
    if "shape" not in jnd:
        assert max(found) == pytest.approx(known, abs=1e-12)


def known_crossings(c: float, corner: float, band: tuple[float, float]) -> FoundCrossings:
    """Of a lag: w = wc sqrt(c/(1 - c)), and w/wc + wc/w = 1/c."""
    half = 1 / (2 * c)
    imag = [corner * (half + sign * (half * half - 1) ** 0.5) for sign in (-1, 1)]
    real = [corner * (c / (1 - c)) ** 0.5]
    return FoundCrossings(
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
    with pytest.raises(UnfitMethodError, match="not a polynomial"):
        companion_way(Crossings.of(hs.Scene(SPRING, (hs.effects.delay("0.1 s"),), (0, 15), "0.1")))


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


# Approximants, and what is left out.


def through(felt: Any, *matrices: tuple[Any, ...]) -> Any:
    for a, b, c, d in matrices:
        felt = (a * felt + b) / (c * felt + d)
    return felt


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_pade_approximant_gains_digits_with_its_order() -> None:
    rows = {row.method: row for row in hs.cost("delayed-spring", quick=True).task("delay")}
    orders = [rows[f"Pade, order {n}"].digits for n in range(2, 7)]
    assert orders == sorted(orders)
    assert rows["exact delay"].proven
    assert not any(row.proven for name, row in rows.items() if name != "exact delay")


def test_all_ways_to_a_ratio_agree_where_none_loses_digits() -> None:
    spring = hs.environments.mass_spring_damper(k=100)
    behind_lag = hs.Scene(spring, (hs.effects.first_order_lag(20),))  # r_r = w^2/(w^2 + 400), r_i = 20 w/(w^2 + 400)
    omegas = (0.5, 3.0, 20.0, 55.5)
    question = RatioQuestion(behind_lag.distortion(), omegas)
    known = np.array([[w * w / (w * w + 400), 20 * w / (w * w + 400)] for w in omegas])
    for way in (naive_way, control_way, scipy_way):
        assert way(question)() == pytest.approx(known, rel=1e-11)
    for name, method in RATIO_METHODS.items():
        answer = method.ready(question)()
        assert np.array([[float(x) for x in row] for row in answer]) == pytest.approx(known, rel=1e-11), name
        score = question.score(answer, question.truth(320), method.held)
        assert score.digits >= (method.held - 0.01 if method.proves else 11), name
    late = RatioQuestion(hs.Scene(spring, (hs.effects.delay("0.1 s"),)).distortion(), omegas)
    assert naive_way(late)() == pytest.approx(
        np.array([[1 - np.cos(w / 10), abs(np.sin(w / 10))] for w in omegas]), rel=1e-9
    )
    for way in (control_way, scipy_way):
        with pytest.raises(UnfitMethodError, match="delays and fractional powers"):
            way(late)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no-such-scene"], "no-such-scene"),
        ([], "name a SCENE"),
        (["fu2019", "--figure", "cost.gif"], r"cost\.gif.* must end in \.svg, \.pdf or \.png"),
        (["fu2019", "--figure", "/no/such/folder/cost.svg"], "cannot be written"),
        (["fu2019", "--hard-cases"], "leave out SCENE"),
    ],
)  # fmt: skip
def test_wrong_command_lines_are_refused_before_anything_is_measured(arguments: list[str], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        CliRunner().invoke(app, ["cost", *arguments], catch_exceptions=False, standalone_mode=False)


def test_a_scene_with_symbols_is_refused() -> None:
    scene = hs.Scene(
        hs.environments.mass_spring_damper(k=Symbol("k", positive=True)), (hs.effects.first_order_lag(20),)
    )
    with pytest.raises(SceneError, match="k = k is a symbol"):
        hs.cost(scene)


# --- JND regions -----------------------------------------------------------------------------------------------------

WIDE = {"real": 0.1, "imag": 0.1}


REGIONS: dict[str, Any] = {
    "ellipse": {"shape": "ellipse", **WIDE, "tilt": 0.5},
    "diamond": {"shape": "diamond", **WIDE},
    "polygon": {"shape": "polygon", "corners": [[0.1, 0], [0, 0.1], [-0.1, 0], [0, -0.1]]},
    "sided": {"real": {"higher": 0.08, "lower": 0.12}, "imag": 0.1},
    "floor": {**WIDE, "floor": "15 N/m"},
    "formula": "0.08 + 0.004*omega",
}


@pytest.mark.parametrize("name", REGIONS)
def test_grids_and_eigenvalues_find_the_certified_crossings_of_a_region(name: str) -> None:
    """Two independent ways of floats and the proof agree; what is no one polynomial has no eigenvalues."""
    paper = hs.load_scene("fu2019")
    question = Crossings.of(hs.Scene(paper.environment, paper.effects, paper.band, REGIONS[name]))
    truth = question.certified(30)
    assert sum(map(len, truth.omegas.values())) > 0
    score = question.score(grid_way(question, 4001, brent=True)(), truth, 15)
    assert (score.missed, score.invented) == (0, 0)
    # where the limit jumps, Brent's method ends at the jump just as well
    assert score.digits > 11
    if name in ("ellipse", "formula"):
        assert question.score(companion_way(question)(), truth, 15).digits > 10
        assert question.condition is not None
    else:
        with pytest.raises(UnfitMethodError, match="border of the JND region"):
            companion_way(question)


def test_how_hard_a_crossing_of_an_ellipse_is_says_how_it_moves_with_its_size() -> None:
    paper = hs.load_scene("fu2019")

    def asked(c: str) -> Crossings:
        return Crossings.of(
            hs.Scene(paper.environment, paper.effects, paper.band, {"shape": "ellipse", "real": c, "imag": c})
        )

    low, at, high = (float(asked(c).certified(20).omegas["joint"][0].mid()) for c in ("0.09999", "0.1", "0.10001"))
    assert asked("0.1").condition == pytest.approx((high - low) / at / 2e-4, rel=1e-6)


@pytest.mark.slow
def test_of_the_papers_example_what_is_proven_keeps_its_promise_and_what_is_not_loses_what_it_must(call: Any) -> None:
    """Known: of Re dH/H = (omega/omega_n)^2 floats lose twice the decades, a line through two points gains two with ten times the points."""
    status, out, _ = call("cost", "fu2019", "--quick", "--json")
    document = json.loads(out)
    rows = {(x["task"], x["method"]): x for x in document["rows"]}
    promised = {x.name: x.held for x in (*RATIO_METHODS.values(), *CROSSINGS.values()) if x.proves}
    proven = {method for (task, method), x in rows.items() if x["proven"] and task != "effects"}
    assert (status, document["schema"]) == (0, "haptisym.cost/1")
    assert {"certified", "30 digits", "certified, 50 digits"} <= proven <= set(promised)
    for (_, method), x in rows.items():
        assert not x["proven"] or x["digits"] >= promised.get(method, 15) - 0.01
        assert not x["proven"] or (x["missed"], x["invented"]) == (0, 0)
    lost = 2 * log10(80 / 1.5e-5)
    assert rows["evaluate", "H_perc - H_env in floats"]["digits"] == pytest.approx(DOUBLE - lost, abs=1.5)
    assert rows["evaluate", "fast"]["digits"] > 14
    digits = [rows["crossings", f"grid of 10^{n}"]["digits"] for n in (2, 3, 4, 5)]
    assert all(1.7 < y - x < 2.5 for x, y in pairwise(digits))
    gone = rows["effects", "without filter"]
    assert (gone["missed"], gone["invented"], gone["digits"], gone["proven"]) == (2, 0, 0.0, False)


@pytest.mark.slow
def test_hard_questions_are_answered_with_proof_and_those_of_floats_that_lose_digits_are_told() -> None:
    rows = hs.hard_costs(hard_cases("identities", "cancelled resonance")).rows
    assert {x.verdict for x in rows if x.ours and x.proven} == {"right"}
    assert {x.verdict for x in rows if not x.ours} - {"right"}


def test_values_that_are_hard_are_those_of_the_scene_that_their_name_tells() -> None:
    """A low-pass on a mass, damper and spring, in 400 digits."""
    with mpmath.workdps(400):
        for family, told in LOWPASS.items():
            for case in hard_cases(family):
                question = case.question
                assert isinstance(question, RatioQuestion)
                m, b, k, wn, zeta = (mpmath.mpf(x.numerator) / x.denominator for x in map(Fraction, told(case.name)))
                for w, found in zip(question.omegas, question.truth(12), strict=True):
                    s = mpmath.mpc(0, mpmath.mpf(w))
                    H, below = m * s**2 + b * s + k, s**2 + 2 * zeta * wn * s + wn**2
                    if below == 0:
                        assert not found[0].is_finite()
                        continue
                    dH = H * (wn**2 / below - 1)
                    for ball, part in zip(found, (dH.real, dH.imag), strict=True):
                        assert float(ball.mid()) == pytest.approx(float(abs(part) / abs(H)), rel=1e-10, abs=1e-320)


# --- times -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spread", [0.02, 0.4])
def test_of_times_that_scatter_no_sentence_is_made(spread: float) -> None:
    rows = [
        CostMeasurement("crossings", f"certified, {n} digits", n, t, proven=True, spread=spread)
        for n, t in ((15, 1.0), (50, 1.1))
    ]
    found = Cost(hs.load_scene("fu2019"), tuple(rows), (), {}, {})
    assert (found.busy, found.to_dict()["busy"]) == (spread > 0.15, spread > 0.15)
    assert ("busy: times are not to be trusted" in found.summary) is found.busy
    assert ("15 digits take 1 s" in found.summary) is not found.busy


def test_a_digit_has_no_price_where_its_time_lies_within_the_spread() -> None:
    def said(spread: float) -> str:
        rows = [CostMeasurement("crossings", "x", n, t, proven=True, spread=spread) for n, t in ((15, 1.0), (50, 1.07))]
        return Cost(hs.load_scene("fu2019"), tuple(rows), (), {}, {}).summary

    assert "2 ms a digit" in said(0.03)
    assert "no time that shows" in said(0.04)


def test_contenders_run_in_turn_and_their_repeats_tell_a_spread() -> None:
    calls: list[str] = []
    found = interleaved({x: partial(calls.append, x) for x in "ab"}, 1000.0, rounds=5)
    turns = [(key, len([*row])) for key, row in groupby(calls)]
    assert [key for key, _ in turns] == ["a", "b"] * 6  # once to warm up
    assert {often for _, often in turns[:2]} == {1}
    # What is short runs three times in a row, unless a machine with more to do made its first run long: not both.
    assert 3 in {often for _, often in turns[2:]} <= {1, 3}
    assert all(x.spread is not None and x.spread >= 0 for x in found.values())
    assert interleaved({"a": lambda: None}, 1000.0, rounds=3)["a"].spread is None
