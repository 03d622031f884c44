"""Stability: all poles in the open left half plane, against the roots of mpmath and poles placed by hand."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from oracles import MP, Case
from strategies import cases, evaluate
from sympy import Expr, Rational, expand, lambdify, pi

import haptisym as hs
from haptisym.effects import compliance, second_order_lowpass, series, zero_order_hold
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.exact.dynamics import Ring
from haptisym.exact.stability import is_stable
from haptisym.symbols import s


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


@pytest.mark.parametrize("seed", range(24))
def test_the_closed_form_of_a_hold_in_a_loop_is_judged_as_the_winding_number_says(seed: int) -> None:
    """Its pole at 0 is removable: 1 - exp(-s T) vanishes there as well. (An evaluation leaves the sampled loop open.)"""
    k, b, T = 100 * (1 + seed % 6), 1 + 3 * (seed % 4), Rational(1 + 7 * (seed % 5), 200)
    coupling = compliance(k=300 + 400 * (seed % 3), b=1 + 9 * (seed % 2))
    scene = hs.Scene(kelvin_voigt(k, b), (zero_order_hold(T), coupling))
    assert is_stable(scene.distortion().perc) == (winding(scene) == 0)
    assert hs.evaluate(scene).stable is None
