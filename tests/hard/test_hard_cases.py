"""Hard cases stay stable: what is proven is right, what is not says so, and the usual ways fail in public."""

from __future__ import annotations

from fractions import Fraction
from math import inf

import flint
import mpmath
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sympy import Rational

import haptisym as hs
from haptisym.verbs.cost.hardcosts import FAMILIES, HardCase, hard_cases, put
from haptisym.verbs.cost.methods import CROSSINGS, DOUBLE, NAIVE, RATIO_METHODS, Crossings, RatioQuestion, right_digits

MP = mpmath.mp.clone()
MP.dps = 1500
decades = st.integers(-9, 9)
CASES = hard_cases()
VALUES = [case for case in CASES if isinstance(case.question, RatioQuestion)]
COUNTS = [case for case in CASES if isinstance(case.question, Crossings)]
SLOW = {"cascades, values", "cascades, crossings", "long delays"}


def cases(listed: list[HardCase]) -> list[object]:
    """The long ones only in CI, and of the two ladders every tenth step each time."""
    return [
        pytest.param(case, marks=[pytest.mark.slow] if is_slow(case) else [], id=f"{case.family}: {case.name}")
        for case in listed
    ]


def is_slow(case: HardCase) -> bool:
    ladder = case.family == "tangency ladder" and not case.name.startswith(
        ("touch", "10^-1 ", "10^-8 ", "10^-24 ", "10^-40 ")
    )
    return case.family in SLOW or ladder


def test_there_is_a_reason_for_every_family_and_a_case_in_it() -> None:
    assert {case.family for case in CASES} == set(FAMILIES)
    assert len({(case.family, case.name) for case in CASES}) == len(CASES)


# What is proven is right.


@pytest.mark.few(12)
@pytest.mark.parametrize("case", cases(VALUES))
def test_certified_values_are_right_to_the_last_bit(case: HardCase) -> None:
    [row] = put(case, [RATIO_METHODS["certified"]])
    assert row.proven
    assert row.digits >= DOUBLE - 0.01


@pytest.mark.few(15)
@pytest.mark.parametrize("case", cases(COUNTS))
def test_no_certified_crossing_is_missed_or_invented_at_any_number_of_digits(case: HardCase) -> None:
    short, long = put(case, [CROSSINGS["certified, 15 digits"], CROSSINGS["certified, 50 digits"]])
    for row, digits in ((short, 15), (long, 50)):
        assert row.verdict in ("right", "undecided")
        assert row.proven == (row.verdict == "right")
        assert (row.missed, row.invented) == (0, 0)
        assert row.digits >= digits


# Independent witnesses: physics written a second time in 1500 digits, and polynomials whose roots are known.


def ratios(m: str, b: str, k: str, omega_n: str, zeta: str, omega: float) -> tuple[object, object]:
    """r_r and r_i of a low-pass on a mass, damper and spring, from the equations of motion."""
    s = MP.mpc(0, MP.mpf(omega))
    H = MP.mpf(m) * s**2 + MP.mpf(b) * s + MP.mpf(k)
    wn = MP.mpf(omega_n)
    dH = H * wn**2 / (s**2 + 2 * MP.mpf(zeta) * wn * s + wn**2) - H
    return abs(dH.real) / abs(H), abs(dH.imag) / abs(H)


def reference(true: object) -> arb:
    """A number of many digits: to the 53 bits of the default its own radius would count as error."""
    with flint.ctx.workprec(256):
        return arb(MP.nstr(true, 60))


@pytest.mark.parametrize(
    "case", [x for x in VALUES if x.family in ("low frequencies", "light damping")], ids=lambda x: x.name
)
def test_the_reference_is_what_1500_digits_of_the_physics_say(case: HardCase) -> None:
    b = "15" if case.family == "low frequencies" else case.name.removeprefix("b = 10^").removesuffix(" N s/m")
    damping = b if b == "15" else f"1e{b}"
    for omega, found in zip(case.question.omegas, case.question.truth(100), strict=True):
        for true, ball in zip(ratios("1.8", damping, "100", "80", "0.5", omega), found, strict=True):
            assert right_digits(MP.nstr(true, 120), ball, 99.0) == 99.0


def test_the_tangency_ladder_steps_from_two_crossings_over_a_touch_to_none() -> None:
    ladder = {case.name: case.question for case in hard_cases("tangency ladder")}
    found = {name: hs_crossings(question) for name, question in ladder.items() if not is_slow_name(name)}
    assert len(found) >= 9
    for name, crossings in found.items():
        kinds = [c.kind.value for c in crossings]
        assert kinds == (["touches"] if name == "touch" else ["exceeds", "returns"] if "below" in name else []), name


@pytest.mark.slow
def test_the_whole_tangency_ladder() -> None:
    for case in hard_cases("tangency ladder"):
        count = {"touch": 1}.get(case.name, 2 if "below" in case.name else 0)
        assert len(hs_crossings(case.question)) == count, case.name


def is_slow_name(name: str) -> bool:
    return not name.startswith(("touch", "10^-1 ", "10^-8 ", "10^-24 ", "10^-40 "))


def hs_crossings(question: Crossings) -> tuple[hs.Crossing, ...]:
    from haptisym.judge.crossings import find_crossings

    return find_crossings(question.chart())


@pytest.mark.parametrize("case", hard_cases("tangency ladder, delayed"), ids=lambda x: x.name)
def test_the_delayed_ladder_has_two_crossings_below_and_none_above(case: HardCase) -> None:
    c = case.question.threshold.imag
    found = case.question.certified(60).omegas["imag"]
    assert len(found) == (2 if c < 1 else 0)
    angle = MP.asin(MP.mpf(int(c.p)) / int(c.q)) if c < 1 else None
    for ball, true in zip(found, (5 * angle, 5 * (MP.pi - angle)) if angle is not None else (), strict=True):
        assert right_digits(MP.nstr(true, 80), ball, 55.0) == 55.0


@pytest.mark.parametrize("case", hard_cases("clustered thresholds"), ids=lambda x: x.name)
def test_clustered_crossings_are_where_they_were_put(case: HardCase) -> None:
    n = int(case.name.split()[0])
    found = case.question.certified(50).omegas["real"]
    squares = [1 + Fraction(i, 10_000) for i in range(1, n + 1)]
    assert len(found) >= n
    for square in squares:
        root = MP.sqrt(MP.mpf(square.numerator) / square.denominator)
        assert any(right_digits(MP.nstr(root, 70), ball, 45.0) == 45.0 for ball in found)


def test_a_rational_crossing_on_the_end_of_the_band_is_found_once_on_either_side() -> None:
    for case in hard_cases("rational crossings")[:4]:
        [c] = hs_crossings(case.question)
        assert c.omega.digits(20).rstrip("0") == "0.15"


@pytest.mark.slow
@given(
    m=decades, b=decades, k=decades, omega_n=decades, zeta=decades,
    omega=st.integers(-150, 150), digit=st.floats(1, 10, exclude_max=True),
)  # fmt: skip
@examples(30)
def test_certified_values_are_right_over_eighteen_decades_of_every_parameter(
    m: int, b: int, k: int, omega_n: int, zeta: int, omega: int, digit: float
) -> None:
    texts = [f"1e{x}" for x in (m, b, k, omega_n, zeta)]
    numbers = [Rational(10) ** x for x in (m, b, k, omega_n, zeta)]
    d = hs.distort(hs.environments.mass_spring_damper(*numbers[:3]), hs.effects.second_order_lowpass(*numbers[3:]))
    w = digit * 10.0**omega
    [found] = RATIO_METHODS["certified"].ready(RatioQuestion(d, (w,)))()
    for value, true in zip(found, ratios(*texts, w), strict=True):
        assert right_digits(float(value), reference(true), DOUBLE) >= DOUBLE - 0.01


# The usual ways fail in public; a stable form that were replaced by the naive one would fail with them.


@pytest.mark.slow
def test_the_naive_form_loses_every_digit_below_1e_7_rad_s() -> None:
    low = [x for x in hard_cases("low frequencies") if x.question.omegas[0] <= 1e-7]
    assert len(low) >= 6
    for case in low:
        naive, stable = put(case, [NAIVE, RATIO_METHODS["certified"]])
        assert naive.digits < 1
        assert stable.digits > 15.9


@pytest.mark.parametrize("omega", [1e-20, 1e-10, 1e-8, 1e-7, 1e-5, 1e-2])
def test_even_fast_floats_keep_their_digits_at_low_frequencies(omega: float) -> None:
    paper = hs.load_scene("fu2019").distortion()
    question = RatioQuestion(paper, (omega,))
    [pair] = RATIO_METHODS["fast"].ready(question)()
    assert question.score([pair], question.truth(30), DOUBLE).digits > 15


@pytest.mark.parametrize("tau", ["1e-9 s", "1e-6 s", "1e-3 s"])
def test_fast_floats_keep_their_digits_for_short_delays(tau: str) -> None:
    d = hs.distort(hs.environments.mass_spring_damper(1.8, 15, 100), hs.effects.delay(tau))
    question = RatioQuestion(d, (1e-6, 1.0, 15.0))
    fast, naive = (
        question.score(RATIO_METHODS[x].ready(question)(), question.truth(30), DOUBLE).digits
        for x in ("fast", NAIVE.name)
    )
    assert fast > 14.5
    assert naive < 3


@pytest.mark.slow
def test_a_grid_misses_what_lies_between_its_points() -> None:
    [case] = [x for x in hard_cases("resonance behind a delay") if "10^-6" in x.name]
    grid, proven = put(case, [CROSSINGS["grid of 10^4 + Brent"], CROSSINGS["certified, 15 digits"]])
    assert grid.missed == 4
    assert proven.verdict == "right"


def test_the_companion_matrix_miscounts_near_a_tangency() -> None:
    ladder = [
        x
        for x in hard_cases("tangency ladder")
        if x.name in ("10^-20 above", "10^-25 below", "10^-30 above", "10^-31 below")
    ]
    rows = [put(case, [CROSSINGS["numpy.roots"]])[0] for case in ladder]
    assert any(row.missed for row in rows)
    assert any(row.invented for row in rows)


# How hard the questions are.


def test_the_condition_number_of_a_crossing_is_c_over_omega_times_the_slope() -> None:
    spring = hs.environments.mass_spring_damper(k=100)
    d = hs.distort(
        spring, hs.effects.first_order_lag(20)
    )  # r_r = omega^2/(omega^2 + 400): r' = 800 omega/(omega^2 + 400)^2
    question = Crossings(d, hs.Threshold.of(Rational(1, 5), 1), (Rational(0), Rational(15)))
    assert question.condition == pytest.approx(0.2 / (10 * 800 * 10 / 500**2), rel=1e-12)


@pytest.mark.slow
def test_the_condition_number_of_a_touch_is_infinite() -> None:
    [touch] = [x for x in hard_cases("tangency ladder") if x.name == "touch"]
    assert touch.question.condition == inf


def test_a_small_frequency_is_no_hard_question() -> None:
    for case in hard_cases("low frequencies"):
        assert case.question.condition == pytest.approx(2, abs=1e-3)  # r_r goes as omega^2


@pytest.mark.parametrize(
    ("given", "true", "digits"),
    [(1.0, "1", DOUBLE), (1.001, "1", 3.0), (-1.0, "1", 0.0), (float("nan"), "1", 0.0), (float("inf"), "inf", DOUBLE),
     (1e300, "inf", 0.0), (0.0, "1e-400", DOUBLE), (1e-300, "0", 0.0), ("0.333", "0.33333333333333333333", 3.0)],
)  # fmt: skip
def test_right_digits_come_from_the_relative_error(given: object, true: str, digits: float) -> None:
    assert right_digits(given, arb(true), DOUBLE) == pytest.approx(digits, abs=1e-3)
