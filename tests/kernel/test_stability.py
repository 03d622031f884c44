"""Stability: all poles in the open left half plane, against the roots of mpmath and poles placed by hand."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from oracles import MP, Case
from strategies import cases, evaluate
from sympy import Expr, I, Rational, exp, expand, lambdify, pi, sqrt

import haptisym as hs
from haptisym.effects import compliance, second_order_lowpass, series, zero_order_hold
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.stability import is_stable
from haptisym.kernel.symbols import s


def stable(denominator: Expr, numerator: Expr = 1) -> bool:
    return is_stable(Ring().convert(numerator / denominator).reduced())


def rightmost(c: list[int]) -> object:
    """The largest real part of the roots of a polynomial, highest power first."""
    return max(z.real for z in MP.polyroots(c, maxsteps=1000, extraprec=1000))


@given(st.lists(st.integers(1, 40), min_size=2, max_size=9))
def test_polynomials_of_positive_coefficients_are_judged_as_mpmath_does(c: list[int]) -> None:
    # positive coefficients are necessary, from the third order on not sufficient
    real = rightmost(c)
    assume(abs(real) > MP.mpf(10) ** -9)
    assert stable(sum(n * s**i for i, n in enumerate(reversed(c)))) == (real < 0)


@given(st.lists(st.integers(-20, 20), min_size=2, max_size=8).filter(lambda c: c[0] and c[-1]))
def test_polynomials_of_any_coefficients_are_judged_as_mpmath_does(c: list[int]) -> None:
    real = rightmost(c)
    assume(abs(real) > MP.mpf(10) ** -9)
    assert stable(sum(n * s**i for i, n in enumerate(reversed(c)))) == (real < 0)


rates = st.fractions(Fraction(1, 9), 9, max_denominator=9).filter(bool)


def rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


@given(st.lists(rates, max_size=3), st.lists(st.tuples(rates, rates), max_size=3))
def test_poles_placed_on_the_left_are_stable(real: list[Fraction], pairs: list[tuple[Fraction, Fraction]]) -> None:
    denominator = expand(placed(real, pairs))
    assert stable(denominator)
    assert stable(-denominator)


@given(
    st.lists(rates, max_size=2), st.lists(st.tuples(rates, rates), max_size=2),
    st.sampled_from([s, s - Rational(1, 3), s**2 + 4, s**2 - s + 1, (s**2 + 1) ** 2, s**4 + 1, s**2 - 2, s**2]),
)  # fmt: skip
def test_one_pole_on_the_axis_or_to_its_right_is_enough_to_be_unstable(
    real: list[Fraction], pairs: list[tuple[Fraction, Fraction]], bad: Expr
) -> None:
    assert not stable(expand(placed(real, pairs) * bad))


def placed(real: list[Fraction], pairs: list[tuple[Fraction, Fraction]]) -> Expr:
    result = s**0
    for a in real:
        result *= s + rational(a)
    for a, b in pairs:
        result *= (s + rational(a)) ** 2 + rational(b) ** 2
    return result


@pytest.mark.parametrize("digits", [3, 20, 100])
def test_a_hair_beside_the_axis_decides(digits: int) -> None:
    hair = Rational(1, 10**digits)
    assert stable(s**2 + hair * s + 1)
    assert not stable(s**2 - hair * s + 1)
    assert not stable(s**2 + 1)
    # s^3 + s^2 + s + k: stable for k < 1
    assert stable(s**3 + s**2 + s + 1 - hair)
    assert not stable(s**3 + s**2 + s + 1 + hair)
    assert not stable(s**3 + s**2 + s + 1)


def test_pi_decides_exactly() -> None:
    # s^3 + pi s^2 + pi s + k: stable for k < pi^2
    assert stable(s**3 + pi * s**2 + pi * s + Rational("9.8696044010893586188"))
    assert not stable(s**3 + pi * s**2 + pi * s + Rational("9.8696044010893586189"))
    assert not stable(s**3 + pi * s**2 + pi * s + pi**2)


def test_a_dynamics_without_poles_is_stable() -> None:
    assert stable(s**0, 3 * s**2 + s)


def test_a_pole_that_cancels_does_not_count() -> None:
    assert stable((s - 1) * (s + 2), s - 1)
    assert not stable((s - 1) ** 2 * (s + 2), s - 1)


def test_the_evaluation_says_whether_what_is_felt_is_stable() -> None:
    spring = mass_spring_damper(k=1)
    for effect, expected in (
        (second_order_lowpass(80, "0.5"), True),
        (second_order_lowpass(80, 0), False),
        (series("1/(s - 1)"), False),
        (series("s + 1"), True),
    ):
        assert hs.evaluate(hs.Scene(spring, (effect,))).stable is expected


@given(cases(order=4))
def test_scenes_are_judged_as_mpmath_does(case: Case) -> None:
    real = max((z.real for z in case.poles), default=MP.mpf(-1))
    assume(abs(real) > MP.mpf(10) ** -12)
    assert evaluate(case).stable is bool(real < 0)


def winding(scene: hs.Scene) -> int:
    """Zeros of the denominator of H_perc in the right half plane, by the turns of D(s)/s along its border: a dense sample."""
    d = scene.distortion().perc
    D = lambdify([s], d.ring.expression(d.denominator) / s, "numpy")
    half = np.concatenate([np.geomspace(1e-7, 1, 20_001), np.linspace(1, 4000, 400_001)[1:]])
    arc = 4000 * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 200_001))
    path = np.concatenate([arc, 1j * half[::-1], -1j * half])
    return round(np.sum(np.diff(np.unwrap(np.angle(D(np.append(path, path[0])))))) / (2 * np.pi))


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(24))
def test_the_closed_form_of_a_hold_in_a_loop_is_judged_as_the_winding_number_says(seed: int) -> None:
    """Its pole at 0 is removable: 1 - exp(-s T) vanishes there as well. (An evaluation leaves the sampled loop open.)"""
    k, b, T = 100 * (1 + seed % 6), 1 + 3 * (seed % 4), Rational(1 + 7 * (seed % 5), 200)
    coupling = compliance(k=300 + 400 * (seed % 3), b=1 + 9 * (seed % 2))
    scene = hs.Scene(kelvin_voigt(k, b), (zero_order_hold(T), coupling))
    assert is_stable(scene.distortion().perc) == (winding(scene) == 0)
    assert hs.evaluate(scene).stable is None


# --- delays ----------------------------------------------------------------------------------------------------------


def delayed(denominator: Expr, numerator: Expr = 1) -> bool | None:
    f = numerator / denominator
    return is_stable(Ring.of([f]).convert(f).reduced())


E = exp(-s)


@pytest.mark.parametrize(
    ("denominator", "expected"),
    [
        # s + a E is stable for 0 < a < pi/2; at pi/2 a pair on the axis, of two parts that vanish at once: left open
        (s + E, True), (s + pi / 2 * E, None), (s + Rational("1.5707") * E, True), (s + Rational("1.5709") * E, False),
        (s - E, False), (-s - E, True), (s**2 * E + s + 1, False),
        # s + a + b E: stable whatever the delay for |b| < a; a zero at s = 0 for b = -a
        (s + 2 + E, True), (s + 2 - E, True), (s + 2 + 2 * E, True), (s + 2 - 2 * E, False), (s + 2 - 3 * E, False),
        # (s + 1)^2 + 2 E and more: against the first crossing of the axis
        ((s + 1) ** 2 + 2 * E, True), ((s + 1) ** 2 + 9 * E, False), ((s + 1) ** 3 + E, True), ((s + 1) ** 3 + 9 * E, False),
        (s**2 + 1 + E / 10, False), (s**2 + s / 10 + 1, True), ((s**2 + 1) * (s + 2 + E), False),
        # neutral: s (2 + E) + 1 has an undelayed leading term that prevails; s (1 + 2 E) + 1 has a chain on the right
        (s * (2 + E) + 1, True), (s * (2 - E) + 1, True), (s * (2 - E) - 1, False), (s * (1 + 2 * E) + 1, False),
        (s * (2 - 3 * E) + 1, False), (s * (1 + E - exp(-2 * s)) + 1, False),
        # neutral, with roots as near to the axis as one likes
        (s * (1 - E) + 1, None), (s * (E - 1 - exp(-2 * s)) - 1, None), (-s * (2 + E) - 1, True), (s * (3 + E - exp(-2 * s)) + 1, True),
        # advanced: only a delayed term leads
        (s * E + 1, False), (s**2 * E + s + 3, False),
    ],
)  # fmt: skip
def test_delayed_loops_are_judged_as_the_literature_does(denominator: Expr, expected: object) -> None:
    assert delayed(denominator) is expected


@pytest.mark.few(15)
@pytest.mark.parametrize("a", range(-3, 12))
@pytest.mark.parametrize("b", [-6, -1, 2, 7])
def test_first_order_loops_with_a_delay_are_judged_by_their_rightmost_root(a: int, b: int) -> None:
    """s + a/2 + b/2 exp(-s): the rightmost root is a - W_0(-b e^a), by the Lambert function."""
    if a == -b:
        assert delayed(s + Rational(a, 2) + Rational(b, 2) * E) is False
        return
    with MP.workdps(40):
        root = -MP.mpf(a) / 2 + MP.lambertw(-MP.mpf(b) / 2 * MP.exp(MP.mpf(a) / 2))
    assert delayed(s + Rational(a, 2) + Rational(b, 2) * E) is bool(root.real < 0)


def test_a_pole_at_rest_counts_unless_the_numerator_has_it_too() -> None:
    hold = (1 - E) / s
    assert delayed(s, 1 - E) is True
    assert delayed(s**2, 1 - E) is False
    assert delayed(s**2, (1 - E) ** 2) is True
    assert delayed(s * (s + 1), 1 - E) is True
    assert delayed(s * (s - 1), 1 - E) is False
    assert delayed((s + 1 + E / 2) * s, 1 - E) is True
    assert delayed((s + 1 + 3 * E) * s, 1 - E) is False
    assert delayed(1 - E, s) is None  # a chain of poles on the axis: the leading terms do not outweigh each other
    assert delayed(s + 1 + hold) is True
    assert delayed(s + hold * 9) is False


def test_delays_of_very_different_length_and_friction_below_the_line_are_left_open_and_powers_are_not() -> None:
    assert delayed(s + 3 + E + exp(-pi * s / 1000)) is True
    assert delayed(s + 3 + E + exp(-pi * 1000 * s)) is None
    assert delayed(s + 2 + sqrt(s)) is True
    assert delayed(s + 2 - 3 * sqrt(s)) is False  # s = 1, and s = 4
    assert delayed(s + 2, sqrt(s)) is True
    assert delayed(s + 2 + I) is None
    assert delayed(s + 2, I) is True
    assert delayed(s - 2, I * sqrt(s)) is False
    assert delayed(s + E + sqrt(s) ** 3) is True
    assert delayed(s + 3 * E + sqrt(s) ** 3) is False


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ((1, 2, 3, 4), True),
        ((-1, -2, -3, -4), True),
        ((1, 2, -3, 4), False),
        ((1, 1, 1, 1), False),
        ((1, 0, 2), False),
        ((3,), True),
        ((1, 1), True),
        ((1, -1), False),
        ((1, 0), False),
    ],
)
def test_few_coefficients_decide_as_by_hand(numbers: tuple[int, ...], expected: object) -> None:
    for scale in (Rational(1), Rational(1, 7), pi, -pi):
        assert stable(sum(scale * c * s**n for n, c in enumerate(reversed(numbers)))) is expected
