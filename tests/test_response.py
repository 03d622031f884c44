"""Rational functions on the imaginary axis, and the closed forms that people read, against SymPy and mpmath."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from oracles import DIGITS, MP, Case, digits_of
from strategies import cases, exact, rationals, scene
from sympy import Abs, Expr, I, Symbol, cancel, expand, sin, sqrt, together

import haptisym as hs
from haptisym.effects import compliance, first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.exact.dynamics import Ring
from haptisym.exact.response import on_axis, squared_modulus
from haptisym.exact.rings import RationalFunction
from haptisym.symbols import omega, s

m, b, k = hs.symbols("m b k")
omega_c, omega_n, zeta = hs.symbols("omega_c omega_n zeta")

integers = st.integers(-5, 5)
polynomials = st.lists(integers, min_size=1, max_size=4).map(lambda c: sum(n * s**i for i, n in enumerate(c)))
denominators = polynomials.filter(lambda p: p != 0)
quotients = st.builds(lambda p, q: p / q, polynomials, denominators)


def is_zero(expression: Expr) -> bool:
    return cancel(together(expression)) == 0


@given(quotients, quotients)
def test_arithmetic_is_that_of_rational_functions(f: Expr, g: Expr) -> None:
    ring = Ring()
    a, c = ring.convert(f), ring.convert(g)
    assert is_zero((a + c).expression() - (f + g))
    assert is_zero((a - c).expression() - (f - g))
    assert is_zero((a * c).expression() - f * g)
    if c.is_zero:
        with pytest.raises(hs.SceneError, match="zero"):
            a / c
    else:
        assert is_zero((a / c).expression() - f / g)
    assert a.equals(c) == is_zero(f - g)


@given(quotients)
def test_real_and_imaginary_part_are_those_of_sympy(f: Expr) -> None:
    response = on_axis(Ring().convert(f))
    real, imag = together(expand(f.subs(s, I * omega), complex=True)).as_real_imag()
    assert is_zero(expand(response.real.expression() - real, complex=True))
    assert is_zero(expand(response.imag.expression() - imag, complex=True))


@given(quotients)
def test_the_squared_modulus_is_that_of_both_parts(f: Expr) -> None:
    function = Ring().convert(f)
    response = on_axis(function)
    total = response.real.expression() ** 2 + response.imag.expression() ** 2
    assert is_zero(squared_modulus(function).expression() - total)


@given(quotients)
def test_lowest_terms_are_the_same_function_without_a_common_factor(f: Expr) -> None:
    function = Ring().convert(f)
    reduced: RationalFunction = function.reduced()
    assert reduced.equals(function)
    assert reduced.numerator.gcd(reduced.denominator).is_constant()
    assert is_zero(function.factored() - f)


@pytest.mark.parametrize("refused", [sqrt(2) * s, Abs(s), s * 1.5, s**s, sin(s)])
def test_what_is_not_rational_in_s_with_exact_coefficients_is_refused(refused: Expr) -> None:
    with pytest.raises(hs.SceneError, match="is not made of|must be a number"):
        Ring.of([refused]).convert(refused)


def test_two_symbols_of_one_name_are_refused_rather_than_mixed_up() -> None:
    with pytest.raises(hs.SceneError, match="both named k"):
        hs.distort(mass_spring_damper(k=Symbol("k")), shunt(k=Symbol("k", positive=True)))


# --- closed forms at numbers -----------------------------------------------------------------------------------------


def numeric(expression: Expr, at: Fraction) -> object:
    """A closed form in omega at a rational frequency, by SymPy's own arithmetic."""
    return MP.mpf(str(expression.subs(omega, exact(at)).evalf(50)))


@given(cases(order=3), rationals(-1, 2))
def test_closed_forms_have_the_values_of_mpmath(case: Case, at: Fraction) -> None:
    d = scene(case).distortion()
    H, G = case.dynamics(MP.mpc(0, digits_of(at)), DIGITS)
    D, size = G - H, abs(H)
    expected = {
        "real": D.real, "imag": D.imag,
        "ratio_real": abs(D.real) / size, "ratio_imag": abs(D.imag) / size,
        "relative_real": (D / H).real, "relative_imag": (D / H).imag,
    }  # fmt: skip
    for name, value in expected.items():
        assert abs(numeric(getattr(d, name), at) - value) <= MP.mpf(10) ** -40 * (abs(value) + abs(D) + abs(G)), name
    for form, value in ((d.environment, H), (d.perceived, G), (d.distortion, D)):
        found = form.subs(s, I * exact(at)).evalf(50).as_real_imag()
        assert abs(MP.mpc(str(found[0]), str(found[1])) - value) <= MP.mpf(10) ** -40 * (abs(H) + abs(G))


@examples(10)
@given(cases(order=3))
def test_compiled_functions_have_the_values_of_mpmath(case: Case) -> None:
    f = scene(case).distortion().compile()
    at = np.array([[0.3, 2.0, 11.0], [47.0, 130.0, 900.0]])
    values = f(at)
    for position in np.ndindex(at.shape):
        H, G = case.dynamics(MP.mpc(0, MP.mpf(float(at[position]))), DIGITS)
        D = G - H
        expected = {
            "real": D.real, "imag": D.imag, "ratio_real": abs(D.real) / abs(H), "ratio_imag": abs(D.imag) / abs(H),
            "relative_real": (D / H).real, "relative_imag": (D / H).imag, "environment_real": H.real,
            "environment_imag": H.imag, "perceived_real": G.real, "perceived_imag": G.imag,
        }  # fmt: skip
        for name, value in expected.items():
            relative = name.startswith("r") and name not in ("real",)
            scale = 1 + abs(D / H) if relative else abs(H) + abs(G)
            found = getattr(values, name)
            assert found.shape == at.shape
            assert abs(float(found[position]) - value) <= 1e-6 * scale, (name, at[position])


# --- the paper's closed forms ----------------------------------------------------------------------------------------


def test_the_relative_distortion_of_a_series_effect_holds_no_environment() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), second_order_lowpass(omega_n, zeta))
    assert (d.relative_real.free_symbols | d.relative_imag.free_symbols) <= {omega, omega_n, zeta}
    G = omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
    real, imag = (G.subs(s, I * omega) - 1).as_real_imag()
    assert is_zero(expand(d.relative_real - real, complex=True))
    assert is_zero(expand(d.relative_imag - imag, complex=True))


def test_a_lag_on_a_mass_spring_damper_by_hand() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    # dH = -j w/(w_c + j w) (k - m w^2 + j b w)
    below = omega_c**2 + omega**2
    assert is_zero(d.real - omega**2 * (b * omega_c - k + m * omega**2) / below)
    assert is_zero(d.imag + omega * (omega_c * (k - m * omega**2) + b * omega**2) / below)
    assert is_zero(d.ratio_real**2 - d.real**2 / ((k - m * omega**2) ** 2 + b**2 * omega**2))


def test_a_shunt_and_a_compliance_by_hand() -> None:
    K = hs.symbols("K")
    assert hs.distort(kelvin_voigt(k, b), shunt(m=m)).distortion == m * s**2
    d = hs.distort(kelvin_voigt(k, b), compliance(k=K))
    assert is_zero(d.perceived - 1 / (1 / (k + b * s) + 1 / K))


def test_properties_are_those_of_section_2_3() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), series("2"))
    felt, X = d.environment_properties, Symbol("X")
    assert is_zero(felt.stiffness - (k - m * omega**2))
    assert is_zero(felt.mass - (m - k / omega**2))
    assert is_zero(felt.damping - b)
    assert is_zero(felt.spring_inertia_force - X * (k - m * omega**2))
    assert is_zero(felt.damping_force - I * X * b * omega)
    assert is_zero(d.perceived_properties.damping - 2 * b)


def test_the_least_noticeable_parameter_moves_the_dynamics_by_the_threshold() -> None:
    c = hs.symbols("c")
    d = hs.distort(mass_spring_damper(m, b, k))
    least = d.parameter_jnd(c)
    modulus = sqrt((k - m * omega**2) ** 2 + (b * omega) ** 2)
    H = m * s**2 + b * s + k
    for symbol, change in ((k, least.stiffness), (b, least.damping), (m, least.mass)):
        moved = expand(H.subs(symbol, symbol + change) - H)
        assert is_zero(moved.subs(s, I * omega) * moved.subs(s, -I * omega) - (c * modulus) ** 2)


def test_changeovers_in_closed_form_are_where_the_evaluation_finds_them() -> None:
    environment = mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    d = hs.distort(environment, second_order_lowpass(80, 0.5))
    result = hs.evaluate(hs.Scene(environment, (second_order_lowpass(80, 0.5),)))
    assert float(d.changeover_environment) == float(result.changeovers_environment[0].omega)
    assert float(d.changeover_perceived) == pytest.approx(float(result.changeovers_perceived[0].omega), rel=1e-14)


def test_a_rational_changeover_has_a_closed_form_too() -> None:
    assert hs.distort(mass_spring_damper(m=1, b=1, k=49)).changeover_environment == 7


def test_the_changeover_of_the_perceived_dynamics_with_symbols_makes_its_real_part_vanish() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    found = d.changeover_perceived
    assert found is not None
    # Re H_perc = w_c (w_c (k - m W) + b W)/(w_c^2 + W): zero at W = w_c k/(w_c m - b)
    assert is_zero(found**2 - omega_c * k / (omega_c * m - b))


# --- compiled functions ----------------------------------------------------------------------------------------------


def test_compiled_functions_keep_the_shape_also_of_constants() -> None:
    f = hs.distort(mass_spring_damper(k=100), series("2")).compile()
    for at in (1.0, [1.0, 2.0], [[1.0], [2.0]], np.zeros((2, 0))):
        assert f(at).real.shape == np.shape(at)
        assert (f(at).real == 100.0).all()
        assert (f(at).imag == 0.0).all()


def test_compiled_functions_take_whole_numbers_larger_than_numpy_s() -> None:
    f = hs.distort(mass_spring_damper(m=10**25, b=10**24, k=10**25), first_order_lag(10**21)).compile()
    values = f(np.array([1.0, 2.0]))
    assert values.environment_real.tolist() == pytest.approx([0.0, -3e25], rel=1e-14)
    assert values.relative_imag.tolist() == pytest.approx([-1e-21, -2e-21], rel=1e-14)
    assert values.real.dtype == np.float64


def test_compiled_functions_broadcast_their_parameters() -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()
    values = f(np.array([1.0, 2.0, 3.0]), k=np.array([[10.0], [20.0]]), omega_c=2.0)
    assert values.real.shape == (2, 3)
    assert np.allclose(values.real, [[-2.0, -5.0, -10 * 9 / 13], [-4.0, -10.0, -20 * 9 / 13]], rtol=1e-14)


@pytest.mark.parametrize("given_values", [{}, {"k": 1.0}, {"k": 1.0, "omega_c": 1.0, "m": 1.0}])
def test_compiled_functions_name_the_parameters_they_need(given_values: dict[str, float]) -> None:
    f = hs.distort(mass_spring_damper(k=k), first_order_lag(omega_c)).compile()
    with pytest.raises(hs.SceneError, match="k, omega_c"):
        f(1.0, **given_values)


def test_at_rest_the_ratios_of_an_environment_that_is_zero_there_are_their_limits() -> None:
    f = hs.distort(mass_spring_damper(m=2, b=3), series("2")).compile()
    values = f([0.0, 1.0])
    assert values.ratio_imag[0] == 1.0
    assert values.ratio_real[0] == 0.0
    unbounded = hs.distort(mass_spring_damper(m=1), shunt(k=1)).compile()([0.0])
    assert np.isinf(unbounded.ratio_real[0])
