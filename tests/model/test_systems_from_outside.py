"""Systems from SymPy and from other packages are real rational functions of s in named real parameters, or are refused by name."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
from sympy import (
    Abs,
    Eq,
    Expr,
    Float,
    I,
    Integer,
    Matrix,
    N,
    Poly,
    Rational,
    Symbol,
    acos,
    asin,
    cbrt,
    cos,
    coth,
    exp,
    lambdify,
    log,
    nan,
    oo,
    pi,
    sin,
    sqrt,
    symbols,
    sympify,
    tan,
    tanh,
)
from sympy.physics.control import (
    Feedback,
    MIMOSeries,
    Parallel,
    Series,
    StateSpace,
    TransferFunction,
    TransferFunctionMatrix,
    lti,
)
from sympy.physics.control.tests import test_lti
from sympy.physics.units import newton, second

import haptisym as hs
from haptisym.kernel.rings import c, omega

s, w = Symbol("s"), Symbol("w", positive=True)
SPRING = hs.environments.mass_spring_damper(k=100)


def evaluated(effect: hs.Effect, felt: hs.Environment = SPRING, high: float = 20) -> list[tuple[str, str]]:
    found = hs.evaluate(hs.Scene(felt, (effect,), (0, high)))
    return [(x.part.value, x.omega.digits(12)) for x in found.crossings]


def test_a_lag_and_a_damper_written_in_s_are_felt_as_such() -> None:
    """|1/(1 + j w/10) - 1|: Im = (w/10)/(1 + w^2/100) = 0.1 and Re = (w^2/100)/(1 + w^2/100) = 0.1, by hand."""
    assert evaluated(hs.interop.series(1 / (1 + s / 10))) == [("imag", "1.01020514434"), ("real", "3.33333333333")]
    damper = hs.interop.environment(100 + 3 * s)
    found = evaluated(hs.effects.first_order_lag("20 rad/s"), damper, 40)
    assert found == [("imag", "2.01169859123"), ("real", "12.0334766133")]


@pytest.mark.parametrize(
    "take", [hs.interop.series, hs.interop.environment, hs.effects.series, hs.environments.expression]
)
@pytest.mark.parametrize(
    ("system", "named"),
    [
        (1 / (1 + I * w / 10), "contains I: write the system in s"),
        (100 + 3 * I * w, "contains I: write the system in s"),
        (I / (s + 1), "contains I: .* real numbers"),
        (Symbol("s", positive=True) + 1, r'declare s without assumptions: Symbol\("s"\)'),
        (s + Symbol("s", positive=True), "s is the Laplace variable: a parameter needs another name"),
        (100 + Symbol("omega"), "contains omega: write the system in s"),
        (s * Symbol("q", imaginary=True), "q is declared imaginary"),
        (s * Symbol("q", commutative=False), "q is declared not commutative"),
        (s + Symbol("q", zero=True), "q is declared zero"),
        (s + Symbol("q", extended_real=False), "q is declared not real"),
    ],
    ids=str,
)
def test_what_is_no_real_system_in_s_is_refused_by_name(take: Callable[[Expr], Any], system: Expr, named: str) -> None:
    with pytest.raises(hs.SceneError, match=named):
        take(system)


@pytest.mark.parametrize(
    "declared", [{"imaginary": True}, {"zero": True}, {"commutative": False}, {"real": False}], ids=str
)
def test_a_parameter_is_a_real_symbol(declared: dict[str, bool]) -> None:
    with pytest.raises(hs.SceneError, match="k: the symbol q is declared"):
        hs.environments.mass_spring_damper(k=Symbol("q", **declared))


def test_an_i_that_cancels_is_none() -> None:
    """1/(s + i) + 1/(s - i) = 2 s/(s^2 + 1)."""
    d = hs.distort(SPRING, hs.interop.series(1 / (s + I) + 1 / (s - I)))
    assert (d.perceived - 200 * s / (s**2 + 1)).cancel() == 0


def test_a_foreign_symbol_is_a_parameter_that_needs_a_value() -> None:
    scene = hs.Scene(SPRING, (hs.interop.series(1 / (1 + s * Symbol("T"))),), (0, 20))
    with pytest.raises(hs.SceneError, match="effects.series.T = T is a symbol; give a number"):
        hs.evaluate(scene)
    found = hs.evaluate(scene.with_values({"effects.series.T": "1/10"}))
    assert float(found.bandwidth) == pytest.approx(1.01020514434)


def test_a_system_in_another_letter_keeps_its_parameters_apart_from_the_laplace_variable() -> None:
    p = Symbol("p")
    assert hs.interop.dynamics(TransferFunction(1, p * Symbol("T") + 1, p)) == 1 / (s * Symbol("T") + 1)
    with pytest.raises(hs.SceneError, match="s is the Laplace variable"):
        hs.interop.dynamics(TransferFunction(1, p * s + 1, p))


def test_a_closed_position_loop_of_zero_is_named() -> None:
    with pytest.raises(hs.SceneError, match="P: .*must not be 0"):
        hs.effects.admittance_display("0")


# --- taken as they are -------------------------------------------------------------------------------------------------

PAPER = hs.load_scene("fu2019")


def written(package: str) -> tuple[Any, Any]:
    """The paper's environment and filter, as a package writes them."""
    above, below = ([1.8, 15, 100], [1]), ([6400], [1, 80, 6400])
    if package == "sympy":
        return 1.8 * s**2 + 15 * s + 100, 6400 / (s**2 + 80 * s + 6400)
    if package == "sympy.physics.control":
        return TransferFunction(1.8 * s**2 + 15 * s + 100, 1, s), TransferFunction(6400, s**2 + 80 * s + 6400, s)
    if package == "coefficients":
        return above, below
    made = import_module(package)
    new = made.tf if package == "control" else made.TransferFunction
    return (new(*above) if package == "control" else above), new(*below)  # SciPy refuses what is improper


@pytest.mark.parametrize("package", ["sympy", "sympy.physics.control", "coefficients", "control", "scipy.signal"])
def test_what_a_control_engineer_has_is_taken_as_it_is(package: str) -> None:
    felt, lowpass = written(package)
    own = hs.distort(felt, lowpass)
    assert own.perceived.equals(PAPER.distortion().perceived)
    found = hs.evaluate(hs.Scene(felt, (lowpass,), (0, 15)))
    assert [x.omega.digits(15) for x in found.crossings] == ["7.97891679017471", "11.9373109243221"]
    assert hs.effects.series(lowpass).matrix == hs.interop.series(lowpass).matrix
    assert hs.environments.expression(felt).H == hs.interop.environment(felt).H


def test_an_exponential_is_a_delay_and_results_carry_the_symbols_given() -> None:
    m, k, T = map(Symbol, "mkT")
    d = hs.distort(m * s**2 + k, 1 / (1 + T * s))
    assert {m, k, T} < d.real.free_symbols
    assert d.real.subs({m: 2, k: 100, T: Rational(1, 10), omega: 5}) == Rational(-10)  # 50 (1/(1 + 1/4) - 1)
    late = hs.distort(100 + 2 * s, exp(-s / 100))
    assert late.perceived.equals(hs.distort(hs.environments.kelvin_voigt(100, 2), hs.effects.delay("10 ms")).perceived)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((None,), "environment"), ((100 * I + s,), "environment: .*contains I"), ((100 + s, None), "effects"), ((100 + s, I * s), r"effects\[1\]"),
        ((100 + s, 1 / (s + 1), "delay"), "effects"), ((100 + s, TransferFunction(1, s + 1, s), ([1], [1, I])), r"effects\[2\]"),
    ],
)  # fmt: skip
def test_what_is_no_system_is_refused_with_the_argument_named(arguments: tuple[Any, ...], named: str) -> None:
    with pytest.raises(hs.SceneError, match=named):
        hs.distort(*arguments)


# --- numbers and symbols at the door ------------------------------------------------------------------------------------

k, b, m, T, tau, z = (Symbol(x, positive=True) for x in ("k", "b", "m", "T", "tau", "z"))
LAGGED = hs.distort(k + b * s, 1 / (1 + T * s))
LONG = "0.123456789012345678901234567891"


def plain(H: complex, G: complex) -> complex:
    return (G - 1) * H / abs(H)


@pytest.mark.parametrize("late", [T, "T"])
@pytest.mark.parametrize(
    "value", [0.02, Fraction(1, 50), Decimal("0.02"), "0.02", "20 ms", Rational(1, 50), Float("0.02", 40)]
)
def test_values_are_put_in_by_symbol_or_name_as_they_are_written(late: Any, value: Any) -> None:
    d = LAGGED.at({late: value, k: 100})
    assert d.free_symbols == {b}
    assert d.perceived.equals(50 * (b * s + 100) / (s + 50))
    found = float(d.at({"b": 1}).bandwidth(0.1))
    assert abs(plain(100 + 1j * found, 1 / (1 + 0.02j * found)).imag) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"tau": 1}, '"tau": valid are T, b, k'), ({"kk": 1}, 'did you mean "k"'), ({"k": -1}, "k: .*>= 0"), ({"T": "x"}, "T: "),
        ({"k": True}, "k: "), ([1], "values"),
    ],
)  # fmt: skip
def test_what_is_no_value_of_a_parameter_is_refused_by_name(values: Any, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        LAGGED.at(values)


MODEL = hs.distort(hs.environments.mass_spring_damper(k=k), hs.effects.delay(T))


@pytest.mark.parametrize(
    ("d", "values", "told"),
    [
        (MODEL, {T: "20 mm"}, "T: .*not a time"), (MODEL.at({k: "1 N/mm"}), {"T": "1 kg"}, "T: .*not a time"), (MODEL.at({T: tau}), {tau: "2 m"}, "tau: .*not a time"),
        (MODEL, {k: "20 mm"}, "k: .*not a stiffness"), (hs.distort(k, hs.effects.delay(T)), {T: "1 m"}, "T: .*not a time"),
        (hs.load_scene("delayed-spring").symbolic_distortion(), {"tau": "20 mm"}, "not a time"), (hs.derive("delayed-spring").distortion, {"tau": "20 mm"}, "not a time"),
    ],
)  # fmt: skip
def test_what_a_parameter_of_a_model_measures_is_known(d: hs.Distortion, values: Any, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        d.subs(values)


def test_a_symbol_of_an_expression_or_in_two_places_measures_anything() -> None:
    assert MODEL.at({k: "1 N/mm", T: "20 ms"}) == hs.distort(1000, exp(-s / 50))
    assert hs.distort(k, exp(-s * T)).at({T: "20 mm"}) == MODEL.at({T: 0.02})
    both = hs.distort(hs.environments.mass_spring_damper(m=k, k=k))
    assert both.at({k: "3 kg"}).environment == 3 * s**2 + 3


def test_a_number_of_many_digits_keeps_them_on_every_way_in() -> None:
    exact, given = Rational(LONG), Float(LONG, 30)
    lag = hs.effects.first_order_lag(given)
    assert (hs.distort(given + s).environment, hs.interop.dynamics(([given, 0], [1]))) == (exact + s, exact * s)
    assert (lag.parameters[0].value, LAGGED.at({"T": given}).chain) == (exact, LAGGED.at({"T": exact}).chain)
    assert LAGGED.threshold_polynomial("real", given) == LAGGED.threshold_polynomial("real", exact)
    assert LAGGED.threshold_polynomial("real", Decimal(LONG)) == LAGGED.threshold_polynomial("real", exact)
    with pytest.raises(hs.SceneError, match="exponent"):
        hs.distort(Float("1e-400", 30) + s)


def test_numbers_and_roots_are_systems() -> None:
    """A Butterworth filter is -omega^2 (omega^2 + w^2)/(omega^4 + w^4) off, and a mass critically damped has its double root."""
    butter = hs.distort(100, 1 / (1 + sqrt(2) * s / w + s**2 / w**2))
    assert butter.relative_real.equals(-(omega**2) * (omega**2 + w**2) / (omega**4 + w**4))
    found = float(butter.at({w: 20}).bandwidth(Fraction(1, 10)))
    G = 1 / (1 + 2**0.5 * 1j * found / 20 - found**2 / 400)
    assert abs((G - 1).imag) == pytest.approx(0.1)
    damped = hs.distort(m * s**2 + 2 * z * sqrt(k * m) * s + k, 0.5)
    assert damped.at({z: 1, m: 2, k: 8}).environment == 2 * (s + 2) ** 2
    assert damped.at({m: 2, k: 3}).perceived.equals(s**2 + sqrt(6) * z * s + Rational(3, 2))
    assert hs.distort(k, (s + sqrt(6)) * (s - sqrt(2) * sqrt(3)) / (s**2 - 6)).distortion == 0
    with pytest.raises(hs.SceneError, match="fractional powers"):
        hs.evaluate(hs.Scene(1 + sqrt(2) * s, ()))
    with pytest.raises(hs.SceneError, match="fractional powers"):
        hs.distort(k, 1 / (1 + s * sqrt(Symbol("a", real=True))))


def test_what_is_told_by_factors_over_the_rationals_is_not_told_of_irrational_numbers() -> None:
    """The real part (W - 2^(1/2))^2 is touched, so no sign changes; its factor over Q[x, 2^(1/2)] is irreducible."""
    touched = m * (s**4 + 2 * sqrt(2) * s**2 + 2)
    assert [x.omega for x in hs.distort(touched).changeovers.environment] == [None]
    for known in (hs.distort(touched).at({m: 1}), hs.distort(s**2 + cbrt(2))):
        with pytest.raises(hs.SceneError, match=r"2\b.*rational"):
            str(known.changeovers)


def test_delays_that_act_together_are_one() -> None:
    two = hs.distort(k, exp(-s * tau), exp(-s * T), omega=w)
    assert two.crossings("imag")[0].omega == asin(c) / (T + tau)
    both, one = hs.distort(k, exp(-s * tau), exp(-s * tau)), hs.distort(k, exp(-2 * s * tau))
    assert both.crossings("imag") == one.crossings("imag")
    assert hs.distort(k, exp(-s * tau)).crossings("imag", Rational(3, 2)) == ()
    assert (
        LAGGED.crossings("real", Symbol("eps") - 1)[0].conditions[-1] == Symbol("eps") - 1
    )  # below 1 it is no threshold


@pytest.mark.parametrize(
    ("d", "level", "more"),
    [
        (LAGGED, omega / 10, {}), (LAGGED, s, {}), (LAGGED, Symbol("k"), {}), (LAGGED, 0, {}), (LAGGED, float("nan"), {}),
        (hs.distort(k, 1 / (1 + T * s), omega=Symbol("c")), c, {}), (hs.distort(k + c * s, 0.5), c, {}), (LAGGED, 0.1, {"band": (0, 1)}),
        (hs.distort(k, exp(-s * tau)), 0.1, {"band": (0, 1)}), (hs.distort(k, 1 / (1 + s**z)), 0.1, {"band": (0, 1)}),
    ],
)  # fmt: skip
def test_a_threshold_has_symbols_of_its_own_and_a_band_takes_numbers(d: hs.Distortion, level: Any, more: Any) -> None:
    with pytest.raises(hs.SceneError):
        d.crossings("real", level, **more)


def test_parameters_may_be_called_as_the_threshold_or_self() -> None:
    damper, me = Symbol("c", positive=True), Symbol("self", positive=True)
    found = hs.distort(b * s + k, 1 / (1 + T * s)).crossings("real", 0.1)[0].equation
    assert hs.distort(damper * s + k, 1 / (1 + T * s)).crossings("real", 0.1)[0].equation.equals(found.subs(b, damper))
    assert hs.distort(me, 0.5).compile(of=["real"])(1.0, self=3).real == -1.5
    cancelled = hs.distort(k, 1 / (1 + s / 10))
    [crossing] = cancelled.crossings("imag", 0.1, band=(0, 9))
    assert cancelled.bandwidth(0.1).digits(12) == crossing.digits(12) == "1.01020514434"


def test_a_distortion_and_what_it_answers_are_values() -> None:
    again = hs.distort(k + b * s, 1 / (1 + T * s))
    known = again.at({k: 100, b: 1, T: 0.02})
    found = known.crossings("imag", 0.1)[0]
    assert (again == LAGGED, hash(again) == hash(LAGGED), known == LAGGED) == (True, True, False)
    assert pickle.loads(pickle.dumps(again)) == again
    assert pickle.loads(pickle.dumps((known, found)))[1].digits(30) == found.digits(30)
    derived = hs.derive(LAGGED)
    assert [x in derived for x in ("Re dH", "omega_perc", 3)] == [True, False, False]
    assert next(iter(derived)) == "H_env"
    solution = hs.distort(k, exp(-s * tau)).crossings("imag")[0]
    assert solution._repr_latex_().startswith(r"$\displaystyle \omega = \frac{\arcsin")


def test_points_are_drawn_as_symbols_are_declared() -> None:
    low, whole = Symbol("low", negative=True), Symbol("n", integer=True, positive=True)
    found = hs.verify(hs.distort(low + whole * s, 1 / (1 + T * s)), 10)
    assert all(x.values["low"] < 0 < x.values["n"] == int(x.values["n"]) for x in found.rows)
    with pytest.raises(hs.SceneError, match="odd"):
        hs.verify(hs.distort(Symbol("odd", irrational=True) + s), 1)


def test_systems_of_systems_are_taken_and_a_loop_without_dynamics_is_refused() -> None:
    state = StateSpace(Matrix([[-1 / T]]), Matrix([[1]]), Matrix([[1 / T]]), Matrix([[0]]))
    lag, one = TransferFunction(1, 1 + T * s, s), StateSpace(*(Matrix([[x]]) for x in (0, 0, 0, 1)))
    G = 1 / (1 + T * s)
    for system, expected in (
        (TransferFunctionMatrix([[lag]]), G),
        (MIMOSeries(TransferFunctionMatrix([[lag]]), TransferFunctionMatrix([[lag]])), G**2),
        (Series(state, lag), G**2),
        (Parallel(state, Series(lag, state)), G + G**2),
        (Feedback(state, lag), G / (1 + G**2)),
        (Feedback(lag, state, 1), G / (1 - G**2)),
    ):
        assert (hs.interop.dynamics(system) - expected).together().expand() == 0
    with pytest.raises(hs.SceneError, match="loop"):
        hs.interop.dynamics(Feedback(one, one, 1))


def test_leading_terms_in_1_over_omega_are_exact_and_0_is_no_crossing() -> None:
    """Of k/s, k/(j omega) = -j k/omega; and Im(3 omega - omega^3 ...) is 0 at 0, which is not positive."""
    at_rest = hs.distort(k * s, 1 + 1 / s**2).asymptote()
    assert (at_rest.distortion, at_rest.real, at_rest.imag) == (k / s, 0, -k / omega)
    assert not at_rest.imag.has(Float)
    touching = hs.distort(1 + s, 1 + Rational(1, 10) + s**2)
    assert all(float(x) > 0 for x in touching.crossings("real", Rational(1, 10)))


# By every door the same.


p, S = symbols("p S")
LAG = 1 / (1 + T * s)
DIGITS = 60
FORMS = ("real", "imag", "ratio_real", "ratio_imag", "relative_real", "relative_imag")


# Values.


@pytest.mark.parametrize(
    ("value", "exact"),
    [
        (3, 3), (0.1, Rational(1, 10)), (np.float64(0.1), Rational(1, 10)), (np.int64(3), 3), (Fraction(1, 3), Rational(1, 3)),
        (Decimal("0.1"), Rational(1, 10)), ("0.1", Rational(1, 10)), ("2 N/mm", 2000), (Rational(2, 7), Rational(2, 7)),
        (Float("0.1", 30), Rational(1, 10)), (pi, pi), (sqrt(2), sqrt(2)), (2 * b, 2 * b), (sqrt(b * m), sqrt(b * m)),
        (mpmath.mpf(3), 3),
    ],
    ids=str,
)  # fmt: skip
def test_a_value_is_put_in_exactly_in_every_way_of_writing_it(value: Any, exact: Any) -> None:
    expected = (k + b * s).subs(k, exact)
    plain = Symbol("k")
    for found in (
        LAGGED.at({k: value}),
        LAGGED.at({"k": value}),
        LAGGED.at({plain: value}),
        LAGGED.subs(k, value),
        LAGGED.subs("k", value),
        LAGGED.subs({k: value}),
        LAGGED.subs([(k, value)]),
    ):
        assert (found.environment - expected).expand() == 0
        assert found == LAGGED.at({k: value})
    assert LAGGED.at({k: b, b: k}).environment == b + k * s  # all at once


@pytest.mark.parametrize(
    ("put", "told"),
    [
        (lambda: LAGGED.at({"kk": 1}), 'unknown parameter "kk": did you mean "k"'), (lambda: LAGGED.at({"s": 1}), 'unknown parameter "s"'),
        (lambda: LAGGED.at([(k, 1)]), "values"), (lambda: LAGGED.at({k: 1j}), "k: "), (lambda: LAGGED.at({k: float("nan")}), "k: "),
        (lambda: LAGGED.at({k: oo}), "k: .*finite"), (lambda: LAGGED.at({k: None}), "k: "), (lambda: LAGGED.at({k: True}), "k: "),
        (lambda: LAGGED.at({k: np.array([1, 2])}), "k: "), (lambda: LAGGED.at({k: -3}), "k: .*>= 0"), (lambda: LAGGED.at({k: s}), "k: .*s"),
        (lambda: LAGGED.at({k: omega}), "k: .*omega"), (lambda: LAGGED.at({k: I}), "k: .*I"), (lambda: LAGGED.at({k: "100 foo"}), "k: "),
        (lambda: LAGGED.subs(k), "subs"), (lambda: LAGGED.subs(1, 2, 3), "subs"), (lambda: LAGGED.at({"omega": -1}), "omega"),
        (lambda: LAGGED.at({"omega": "1 m"}), "omega: "), (lambda: LAGGED.at({T: Symbol("b")}), "assumptions differ"),
        (lambda: LAGGED.at({T: 2 * second}), "give text"), (lambda: hs.distort(k * newton, LAG), "give text"),
        (lambda: hs.distort(100, 1 / (s**2 + 9)).at({"omega": 3}).real, "divided by zero"),
    ],
)  # fmt: skip
def test_what_cannot_be_put_in_is_told(put: Callable[[], object], told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        put()


def test_a_frequency_that_is_put_in_goes_into_all_closed_forms() -> None:
    known = {k: 100, b: 3, T: Rational(1, 50)}
    for key, value in (("omega", 8), (Symbol("omega"), 8), (omega, Integer(8)), ("omega", "8 rad/s"), (omega, 8.0)):
        here = LAGGED.subs(key, value)
        for name in (*FORMS, "modulus"):
            assert getattr(here, name) == getattr(LAGGED, name).subs(omega, 8)
        assert here.at(known).real == LAGGED.real.subs(omega, 8).subs(known)
        assert here.at(known) == LAGGED.at({**known, omega: 8}) != LAGGED.at(known)
    assert LAGGED.at({"omega": "1 Hz"}).imag == LAGGED.imag.subs(omega, 2 * pi)
    here = hs.distort(k + b * s, LAG, omega=w).subs(w, 8)
    assert here.environment_properties.stiffness == k
    assert here.environment_properties.damping == b
    steps = here.steps("real")
    value = steps.at({k: Rational(2), b: Rational(3), T: Rational(5)})["real"]
    assert value == here.real.subs({k: 2, b: 3, T: 5})
    assert hs.verify(here, 2).worst["closed form"] < 1e-9
    assert here.crossings("real", 0.1)[0].equation.has(w)  # the frequency of a crossing is another one


@pytest.mark.parametrize(
    "level", [0.1, "0.1", "10 %", Fraction(1, 10), Decimal("0.1"), Rational(1, 10), np.float64(0.1), Float(0.1)]
)
def test_a_threshold_is_read_as_it_is_written(level: Any) -> None:
    known = LAGGED.at({k: 100, b: 1, T: 0.02})
    assert known.bandwidth(level).digits(15) == "5.03154589262463"
    assert [x.digits(12) for x in known.crossings("real", level)] == ["25.4990211049", "484.519616508"]
    assert known.crossings("real", level, band=("0 Hz", "10 Hz"))[0].digits(12) == "25.4990211049"
    assert LAGGED.threshold_polynomial("real", level) == LAGGED.threshold_polynomial("real", 0.1)


def test_parameters_to_keep_and_closed_forms_are_named_by_symbols_too() -> None:
    expected = hs.derive("fu2019", keep=["zeta", "k"])
    zeta = Symbol("zeta")
    assert (
        hs.derive("fu2019", keep=[zeta, k])["Re dH"]
        == hs.derive("fu2019", keep=(zeta, "k"))["Re dH"]
        == expected["Re dH"]
    )
    assert hs.derive("fu2019", keep=k)["H_env"] == Rational(9, 5) * s**2 + 15 * s + k
    for wrong in (
        lambda: hs.derive("fu2019", keep=3),
        lambda: hs.derive("fu2019", keep=["omegan"]),
        lambda: LAGGED.compile(of=3),
        lambda: LAGGED.lambdify("real", "numpyy"),
        lambda: LAGGED.lambdify("rael"),
        lambda: LAGGED.lambdify("modulus", steps=True),
        lambda: hs.verify(LAGGED, 0),
    ):
        with pytest.raises(hs.SceneError):
            wrong()


# Doors.


def systems(count: int, seed: int = 57) -> Iterator[tuple[list[Expr], list[Expr]]]:
    """Rows of coefficients, highest power first, of random systems with numbers, parameters and roots."""
    draw = Random(seed)
    pieces = [Integer(2), Rational(3, 7), Rational(1, 10), k, b, m * T, sqrt(k * m), sqrt(2), sqrt(k + m), k / b]

    def row(length: int) -> list[Expr]:
        return [draw.choice(pieces) + draw.choice([0, *pieces]) for _ in range(length)]

    for _ in range(count):
        yield row(draw.randint(1, 3)), row(draw.randint(2, 3))


def valued(form: Any, at: dict[Any, Any]) -> Any:
    """A value of an expression in complex arithmetic of 60 digits."""
    return mpmath.mpmathify(Expr.subs(form, at).evalf(DIGITS)) if isinstance(form, Expr) else form


def in_powers(row: list[Expr], x: Expr) -> Expr:
    return sum((a * x**n for n, a in enumerate(reversed(row))), Integer(0))


@pytest.mark.few(2)
@pytest.mark.parametrize("coefficients", [*systems(12)], ids=str)
def test_a_system_is_the_same_behind_every_door(coefficients: tuple[list[Expr], list[Expr]]) -> None:
    """Written in s, in another letter, in j omega, as a transfer function, and as rows of coefficients; against 60 digits."""
    above, below = coefficients
    G, H = (lambda x: in_powers(above, x) / in_powers(below, x)), (lambda x: k + b * x + m * x**2)
    d = hs.distort(H(s), G(s))
    jw = I * w
    others = [
        hs.distort(H(p), G(p), laplace=p),
        hs.distort(TransferFunction(H(s), 1, s), TransferFunction(in_powers(above, S), in_powers(below, S), S)),
        hs.distort(
            Poly(H(s), s), TransferFunctionMatrix([[TransferFunction(in_powers(above, s), in_powers(below, s), s)]])
        ),
        hs.distort(([m, b, k], [1]), (above, below)),
        hs.distort(hs.environments.mass_spring_damper(m, b, k), hs.effects.series(G(s))),
    ]
    for other in others:
        assert other == d
        assert hash(other) == hash(d)
    in_omega = hs.distort(H(jw), G(jw), omega=w)
    assert in_omega == hs.distort(H(s), G(s), omega=w)
    assert in_omega.real == d.real.subs(omega, w)
    known = {k: Rational(7, 3), b: Rational(5, 11), m: Rational(13, 9), T: Rational(17, 5), omega: Rational(31, 7)}
    with mpmath.workdps(DIGITS):
        env = valued(H(I * omega), known)
        change = valued(H(I * omega) * (G(I * omega) - 1), known)
        expected = (
            change.real,
            change.imag,
            abs(change.real) / abs(env),
            abs(change.imag) / abs(env),
            (change / env).real,
            (change / env).imag,
        )
        for name, value in zip(FORMS, expected, strict=True):
            assert abs(valued(getattr(d, name), known) - value) <= mpmath.mpf(10) ** -45 * (1 + abs(change))


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        (k + I * w * b, k + b * s), (k - m * w**2 + I * w * b, k + b * s + m * s**2), (exp(-I * w * tau), exp(-s * tau)),
        (w / (w - I / T), T * s / (T * s + 1)), (b * sqrt(I * w), b * sqrt(s)), (b * (I * w) ** z, b * s**z),
        ((1 - exp(-I * w * T)) / (I * w * T), (1 - exp(-s * T)) / (s * T)), (cos(w * T), (exp(s * T) + exp(-s * T)) / 2),
        (sin(w * T) / w, (exp(s * T) - exp(-s * T)) / (2 * s)), (1 / (1 + 2 * z * I * w / k - (w / k) ** 2), 1 / (1 + 2 * z * s / k + (s / k) ** 2)),
        (k + I * Symbol("w") * b, k + b * s), (k + I * omega * b, k + b * s),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_written_in_j_omega_is_rewritten_in_s(written: Expr, meant: Expr) -> None:
    assert hs.distort(k, written, omega=w) == hs.distort(k, meant, omega=w)


@pytest.mark.parametrize(
    "written",
    [k + w * b, k * (1 + I * b), 1 / sqrt(1 + w**2 * T**2), Abs(I * w + k), sqrt(w) * b, k + b * s + w, (I * w) ** I, 2**w, I * k],
    ids=str,
)  # fmt: skip
def test_what_is_not_real_in_j_omega_is_refused(written: Expr) -> None:
    with pytest.raises(hs.SceneError, match="effects"):
        hs.distort(k, written, omega=w)


def test_another_letter_is_asked_about_and_never_silently_a_parameter() -> None:
    for letter in (p, S):
        with pytest.raises(hs.SceneError, match=f"is {letter} the Laplace variable.*laplace={letter}"):
            hs.distort(k + b * letter, 1 / (1 + T * letter))
        with pytest.raises(hs.SceneError, match="is . the Laplace"):
            hs.distort(k + b * s, 1 / (1 + T * letter))
        own = Symbol(letter.name, positive=True)
        assert hs.distort(k + own * s, LAG).free_symbols == {k, own, T}
        assert hs.distort(k, own).perceived == k * own
    with pytest.raises(hs.SceneError, match="Laplace"):
        hs.distort(k + s, 1 / (1 + T * p), laplace=p)
    with pytest.raises(hs.SceneError, match="laplace"):
        hs.distort(k, LAG, laplace="p")


@pytest.mark.few("W", "self", "E", "lambda", "c_", "omega_0")
@pytest.mark.parametrize(
    "name", ["c", "W", "self", "X", "E", "M", "F", "I", "pi", "lambda", "x0", "real", "c_", "values", "omega_0"]
)
def test_a_parameter_may_have_any_name_but_that_of_s_and_omega(name: str) -> None:
    own = Symbol(name, positive=True)
    d, other = hs.distort(k + own * s, LAG), LAGGED
    there, back = {b: own}, {own: b}
    assert d.real.xreplace(back).equals(other.real)
    polynomial = d.threshold_polynomial("real", 0.1)
    expected = other.threshold_polynomial("real", 0.1).as_expr().subs(Symbol("W", positive=True), 4)
    assert polynomial.as_expr().subs(polynomial.gen, 4).xreplace(back).equals(expected)
    equations = [[x.equation for x in each.crossings("imag", 0.1)] for each in (d, other)]
    assert equations[0][0].xreplace(back).equals(equations[1][0])
    assert d.crossings("imag")[0].equation.free_symbols > {own, k, T}
    at = {"k": 2.0, "T": 3.0, name: 5.0}
    assert float(d.compile(of=["imag"])(0.5, **at).imag) == pytest.approx(
        float(other.imag.subs({omega: 0.5, k: 2, T: 3, b: 5}))
    )
    names = sorted(d.free_symbols, key=str)
    assert d.lambdify("imag", "math")(0.5, *(at[x.name] for x in names)) == pytest.approx(
        float(d.imag.subs({omega: 0.5, **{x: at[x.name] for x in names}}))
    )
    assert d.environment_properties.spring_inertia_force.free_symbols > {k}
    assert len({x.name for x in d.environment_properties.damping_force.free_symbols}) == 3
    assert hs.verify(d, 2).worst["named steps"] < 1e-9
    assert there
    assert str(hs.derive(d))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (log(2) + s, "symbol of its own"), (exp(-k), "delay"), (nan * k, "finite"), (oo, "finite"), (Eq(k, 1), "not a system"), (Matrix([[k]]), "not a system"),
        (1j, "give one of"), ("100", "give one of"), (True, "give one of"), ([1, 2], "give one of"), (sqrt(Symbol("q")) + s, "positive"),
        (Symbol("j") * s + k, "I"), (k + s * Symbol("s", positive=True), "Laplace"),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_system_is_refused_with_the_way(given: Any, told: str) -> None:
    with pytest.raises(hs.SceneError, match=told):
        hs.distort(given, LAG)


def test_roots_of_constants_are_constants() -> None:
    """The poles of a Butterworth filter of order 4 are exp(j pi (2 i + 1)/8 ...): |G|^2 = 1/(1 + omega^8), by hand."""
    fourth = 1 / ((1 + 2 * cos(pi / 8) * s + s**2) * (1 + 2 * sin(pi / 8) * s + s**2))
    d = hs.distort(k, fourth)
    square = d.perceived_properties.real**2 + d.perceived_properties.imag**2
    for frequency in (Rational(1, 3), Rational(7, 5)):
        assert abs(square.subs({omega: frequency, k: 1}).evalf(50) - 1 / (1 + frequency**8)) < Float("1e-45", 50)
    assert hs.verify(d, 5).worst["closed form"] < 1e-9
    assert hs.distort(k + sqrt(k + m) * s, (sqrt(k + m) ** 2 - m) / k).perceived == k + sqrt(k + m) * s
    assert hs.verify(hs.distort(k + sqrt(k + m) * s, LAG), 5).worst["named steps"] < 1e-9


SLOW = {
    "MIMOFeedback_construction",
    "conversion",
    "StateSpace_dsolve",
    "StateSpace_series",
    "Feedback_functions",
    "issue_26161",
}


@pytest.fixture(scope="module")
def of_sympy() -> list[Any]:
    """All systems with one input and one output that SymPy's own tests of physics.control make."""
    made: dict[Any, None] = {}
    kinds = [
        "TransferFunction",
        "Series",
        "Parallel",
        "Feedback",
        "StateSpace",
        "TransferFunctionMatrix",
        "MIMOSeries",
        "PIDController",
    ]

    def recording(kind: Any) -> Callable[..., Any]:
        make = kind.__new__

        def new(cls: Any, *args: Any, **more: Any) -> Any:
            system = make(cls, *args, **more)
            made.setdefault(system)
            return system

        return new

    with pytest.MonkeyPatch.context() as patch:
        for kind in (getattr(lti, name) for name in kinds):
            patch.setattr(kind, "__new__", recording(kind))
        for name, test in vars(test_lti).items():
            if name.startswith("test_") and name.removeprefix("test_") not in SLOW:
                test()
    return [x for x in made if isinstance(x, lti.LinearTimeInvariant) and (x.num_inputs, x.num_outputs) == (1, 1)]


def by_numbers(system: Any, at: dict[Any, Any]) -> Any:
    """A system's value at a point of s, from its parts."""
    if isinstance(system, lti.StateSpace):
        A, B, C, D = (x.subs(at).evalf(40) for x in (system.A, system.B, system.C, system.D))
        return (C * (at[hs.s] * Matrix.eye(A.rows) - A).inv() * B + D)[0, 0] if A.rows else D[0, 0]
    if isinstance(system, lti.TransferFunctionMatrix):
        return by_numbers(system.args[0][0][0], at)
    parts = [by_numbers(x, at) if isinstance(x, lti.LinearTimeInvariant) else x for x in system.args]
    if isinstance(system, lti.Series | lti.MIMOSeries):
        return parts[0] * by_numbers(type(system)(*system.args[1:]), at) if len(parts) > 1 else parts[0]
    if isinstance(system, lti.Parallel | lti.MIMOParallel):
        return sum(parts)
    if isinstance(system, lti.Feedback):
        return parts[0] / (1 - system.sign * parts[0] * parts[1])
    above, below = (x if isinstance(x, lti.LinearTimeInvariant) else x.subs(at) for x in (system.num, system.den))
    return above / below


@pytest.mark.slow
@pytest.mark.core
@pytest.mark.filterwarnings("ignore")
def test_the_systems_of_sympy_s_own_tests_are_taken_or_refused_by_name(of_sympy: list[Any]) -> None:
    taken, refused = 0, list[str]()
    for system in of_sympy:
        try:
            found = hs.interop.dynamics(system)
        except hs.SceneError as error:
            refused.append(str(error))
            continue
        taken += 1
        if any(isinstance(x, lti.LinearTimeInvariant) for x in system.args) and isinstance(
            system, lti.TransferFunction
        ):
            continue
        free = sorted(found.free_symbols | system.free_symbols, key=str)
        at = {x: Rational(3 + 2 * n, 7 + n) for n, x in enumerate(free)}
        letter = getattr(system, "var", None)
        at |= {x: Rational(11, 13) for x in (letter, hs.s) if x is not None}
        try:
            expected = complex(by_numbers(system, at))
        except (ZeroDivisionError, ValueError, TypeError):
            continue
        assert complex(found.subs(at)) == pytest.approx(expected, rel=1e-9, abs=1e-9), system
    assert taken > 400
    expected = "parameter needs another name|contains|take one of each"
    assert [x for x in refused if not re.search(expected, x)] == []


# Answers.


def test_equal_systems_give_equal_formulas() -> None:
    one, both = hs.distort(k + m * s**2, exp(-s * (T + tau))), hs.distort(k + m * s**2, exp(-s * tau), exp(-s * T))
    assert one == both
    for name in FORMS:
        assert getattr(one, name) == getattr(both, name)
    assert (both.real - (k - m * omega**2) * (cos(omega * (T + tau)) - 1)).expand() == 0
    assert both.threshold_polynomial("imag") == one.threshold_polynomial("imag")
    assert [x.omega for x in both.crossings("imag", c)][:2] == [asin(c) / (T + tau), (pi - asin(c)) / (T + tau)]
    assert [x.omega for x in hs.distort(k, LAG).crossings("real", c)] == [sqrt(c) / (T * sqrt(1 - c))]
    first, last = (x.omega for x in hs.distort(k, LAG).crossings("imag", c))
    assert [((first - x) * (last - x)).equals(0) for x in ((1 - sqrt(1 - 4 * c**2)) / (2 * T * c),)] == [True]


@pytest.mark.parametrize(
    ("order", "by"),
    [(Rational(1, 2), sqrt(2) / 2), (Rational(1, 3), sqrt(3) / 2), (Rational(3, 4), sin(pi / 8)), (z, cos(pi * z / 2))],
)
def test_a_spring_pot_is_crossed_at_a_formula(order: Expr, by: Expr) -> None:
    """Re (j omega)^a = omega^a cos(a pi/2), so that b omega^a cos(a pi/2) = c k."""
    d = hs.distort(k, rendered=k + b * s**order)
    values = {k: 100, b: 2, c: Rational(1, 10)} | ({z: Rational(2, 5)} if order == z else {})
    found = [x for x in (y.put(values) for y in d.crossings("real", c)) if x is not None]
    [crossing] = [x.omega for x in found if x.omega is not None and not x.conditions]
    expected = (c * k / (b * by)) ** (1 / order)
    assert crossing.evalf(30) == pytest.approx(expected.subs(values).evalf(30))
    assert "tan" not in str(d.threshold_polynomial("real"))
    assert d.steps("real").operations < 12
    assert hs.verify(d, 3).worst["named steps"] < 1e-9


@pytest.mark.few(5)
@pytest.mark.parametrize(
    ("d", "parameter", "values"),
    [
        (hs.distort(k, LAG), T, {}), (LAGGED, b, {k: 100, T: Rational(1, 10)}), (LAGGED, "k", {b: 3, T: Rational(1, 10)}),
        (hs.distort(k, exp(-s * tau)), tau, {}), (hs.distort(m * s**2 + 2 * z * sqrt(k * m) * s + k, LAG), z, {k: 100, m: 2, T: Rational(1, 30)}),
        (hs.distort(k, rendered=k + sqrt(b) * s), b, {k: 100}), (LAGGED, c, {k: 100, b: 3, T: Rational(1, 50)}),
        (hs.distort(k, exp(-s * tau), hs.effects.shunt(m=m)), m, {k: 100, tau: Rational(1, 20)}),
    ],
)  # fmt: skip
def test_a_crossing_is_solved_for_a_parameter(d: hs.Distortion, parameter: Any, values: Any) -> None:
    """Put in again, each value makes 5 rad/s a crossing: r^2 = c^2, to 40 digits."""
    x, at = Symbol(str(parameter), positive=True), {**values, omega: Integer(5)}
    solved = hs.solve_for(d, "crossing", parameter, c)
    count = 0
    for name, found in solved._asdict().items():
        for solution in found:
            known = {**at, **({} if x == c else {c: Rational(1, 10)})}
            put = solution.put(known)
            if put is None or put.omega is None or put.conditions:
                continue
            count += 1
            ratio = getattr(d, f"ratio_{name}").subs(values | {omega: 5})
            assert abs((ratio - c).subs({x: put.omega} | known).evalf(50)) < Float("1e-40", 50)
            assert (solution.parameter, put.parameter) == (x, x)
    assert count


def test_a_formula_takes_values_as_the_distortion_does_and_is_asked_again_where_a_condition_is_0() -> None:
    """Two lags: 1 - Re 1/(1 + j x)^2 = c is 1 - y = (1 - c) (1 + y)^2 with y = x^2, by hand."""
    k, T, level = symbols("k T level", positive=True)
    d = hs.distort(k, 1 / (1 + T * s) ** 2)
    formulas = d.crossings("real", level)
    given: dict[Any, Any] = {"level": 0.9, Symbol("T"): "20 ms", k: 100}
    told = sorted(float(x) for y in formulas if (x := y.put(given)))
    # y^2 + 12 y - 9 = 0
    assert told == pytest.approx([50 * np.sqrt(-6 + np.sqrt(45))])
    with pytest.raises(hs.SceneError, match="did you mean"):
        formulas[0].put({"Level": 0.9})
    for x in formulas:
        with pytest.raises(hs.SceneError, match="ask again"):
            x.put({"level": 1, "T": 1})
    assert [sympify(x) for x in d.at({"T": "20 ms"}).crossings("real", 1)] == [50]
    [lag] = hs.distort(k, 1 / (1 + T * s)).crossings("real", level)
    assert sympify(lag) == lag.omega
    assert w - lag == w - sqrt(level) / (T * sqrt(1 - level))


def test_changeovers_are_solved_for_a_parameter_and_a_frequency_may_be_a_number() -> None:
    d = hs.distort(k + b * s + m * s**2, LAG)
    [solution] = hs.solve_for(d, "changeover", m).environment
    assert solution.omega == k / omega**2
    assert [x.omega for x in hs.solve_for(hs.distort(k, LAG).subs(omega, 5), "crossing", T, 0.1).real] == [
        Rational(1, 15)
    ]
    [first, _] = hs.solve_for(hs.distort(k, exp(-s * tau)), "crossing", tau, c).real
    assert first.omega == acos(1 - c) / omega
    for wrong in ((d, "crossings", m), (d, "crossing", "mm"), (d, "changeover", c), (d, "crossing", m, -1)):
        with pytest.raises(hs.SceneError):
            hs.solve_for(*wrong)


@pytest.mark.parametrize("parameter", [k, b, m, tau])
def test_a_changeover_behind_a_delay_is_solved_for_a_parameter(parameter: Symbol) -> None:
    """Put in again, Re of (k + b s + m s^2) exp(-s tau) at s = 5j changes its sign, on either side of w^2 = k/m; a
    delay's values, the least of them positive, come again with every half turn."""
    felt = (k + b * s + m * s**2) * exp(-s * tau)
    told, turn = hs.solve_for(hs.distort(k + b * s + m * s**2, exp(-s * tau)), "changeover", parameter), pi / 5
    for stiffness in (20, 50, 80):
        known = {k: Integer(stiffness), b: Integer(3), m: Integer(2), tau: Rational(2, 5), omega: Integer(5)}
        del known[parameter]
        found = [x for x in (y.put(known) for y in told.perceived) if x is not None and not x.conditions]
        assert found or parameter != tau
        for x in found:
            assert (x.period, x.omega >= 0) == (turn if parameter == tau else 0, True)
            assert parameter != tau or x.omega <= turn
            value = felt.subs({parameter: x.omega, **known}).subs(s, 5 * I)
            assert abs(complex(value.evalf(30)).real) < 1e-12
    assert hs.solve_for(hs.distort(k + m * s**2, exp(-s * tau)), "changeover", k).environment[0].omega == m * omega**2


def test_half_a_turn_of_a_delay_is_solved_for() -> None:
    """Re of (k + b s)(1 + exp(-s tau))/2 has the factor cos(w tau/2), whose zero has an infinite tangent of half of the
    angle: with k = b w it changes its sign where w tau is pi or 3 pi/2, and nowhere else within a turn."""
    half = hs.distort(k + b * s, (1 + exp(-s * tau)) / 2)
    known = {k: Integer(10), b: Integer(2), omega: Integer(5)}
    put = [x.put(known) for x in hs.solve_for(half, "changeover", tau).perceived]
    assert sorted(x.omega for x in put if x is not None) == [pi / 5, 3 * pi / 10]


def test_where_all_symbols_cancel_an_equation_without_a_formula_is_answered_in_numbers() -> None:
    """A factor with a positive root in proven numbers, none for one without: as on a grid of complex numbers."""
    d = hs.distort(k, 1 / (1 + s) ** 3)
    at = np.geomspace(1e-3, 1e3, 200_001)
    change = 1 / (1 + 1j * at) ** 3 - 1
    for part, values in (("real", change.real), ("imag", change.imag)):
        seen = at[np.flatnonzero(np.diff(np.sign(abs(values) - 0.1)))]
        assert [float(x) for x in d.crossings(part, 0.1)] == pytest.approx(seen, rel=1e-4)

    assert [x.omega for x in hs.distort(k, 1 / (1 + s)).crossings("real", 0.1)] == [Rational(1, 3)]


def test_a_formula_that_is_real_for_no_real_values_is_not_told() -> None:
    lag, level = Symbol("T"), Symbol("c")
    [found] = hs.distort(Symbol("k"), 1 / (1 + lag * s)).crossings("real", level)
    assert found.put({lag: Rational(-1, 2), level: Rational(1, 2)}).omega == 2
    assert set(found.conditions) == {1 - level, level}


@pytest.mark.parametrize("more", [(), (LAG,), (1 / (z + 2 * b * s + s**2),), (hs.effects.compliance(k=b),)])
def test_a_factor_that_is_real_on_the_axis_cancels_in_the_ratios(more: tuple[Any, ...]) -> None:
    """k + m s^2 and a delay: ratios, on the page of LaTeX too, are those of complex numbers without |k - m w^2| above and
    below the line; beside a mass, where dH does not vanish with H_env, it stays below."""
    felt = k + m * s**2
    d = hs.distort(felt, exp(-s * tau), *more)
    drawn = Random(str(more))
    values = {x: Rational(drawn.uniform(0.2, 3)) for x in (*d.free_symbols, omega)}
    size = abs(complex(felt.subs({s: I * omega}).subs(values).evalf(30)))
    change = complex(d.distortion.subs({s: I * omega}).subs(values).evalf(30))
    for name, part in (("ratio_real", change.real), ("ratio_imag", change.imag)):
        form = getattr(d, name)
        assert float(form.subs(values)) == pytest.approx(abs(part) / size, rel=1e-12)
        assert form.as_numer_denom()[1].has(Abs(k - m * omega**2)) is False, form
    [row] = [x for x in hs.latex(d).splitlines() if x.strip().startswith(r"r_i(")]
    assert r"\left| k - m" not in row
    assert hs.distort(felt, hs.effects.shunt(m=z)).ratio_real == z * omega**2 / Abs(k - m * omega**2)
    assert hs.distort(felt, exp(-s * tau)).subs({k: 4, m: 1, tau: 0.1, omega: 2}).ratio_imag == sin(Rational(1, 5))


def test_answers_are_formulas_to_a_notebook() -> None:
    solution = hs.distort(k, LAG).crossings("real")[0]
    found = {
        "solution": solution,
        "changeovers": hs.distort(k + m * s**2, LAG).changeovers,
        "numbers": hs.distort(100 + s**2, 1 / (1 + s)).changeovers,
        "steps": LAGGED.steps(),
        "derivation": hs.derive(LAGGED),
        "solved": hs.solve_for(hs.distort(k, LAG), "crossing", T),
        "asymptote": LAGGED.asymptote(),
        "slow": LAGGED.low_frequency,
    }
    for name, x in found.items():
        shown = x._repr_latex_()
        assert shown.startswith("$"), name
        assert hs.latex(x), name
        assert pickle.loads(pickle.dumps(x)) == x, name
    assert hs.latex(solution) == r"\omega = \frac{\sqrt{\frac{c}{1 - c}}}{T},\quad 1 - c > 0"
    listed = hs.latex(hs.distort(k, LAG).crossings("real"))
    assert listed == "\\begin{align*}\n  &" + hs.latex(solution) + "\n\\end{align*}"


@pytest.mark.parametrize("written", [tanh(T * s), 1 / coth(T * s), -I * tan(I * T * s)])
def test_hyperbolic_functions_are_delays(written: Expr) -> None:
    """The tangent of j omega T is j tan(omega T)."""
    found = hs.distort(k, rendered=k * (1 + written))
    assert (found.imag - k * tan(omega * T)).subs({k: 2, T: 3, omega: Rational(1, 7)}).evalf() == pytest.approx(0)
    assert found.real == 0


def test_a_certified_number_keeps_all_its_digits_in_sympy_and_mpmath() -> None:
    """The ratio's own equation solved with 60 digits, and 50 asin(1/10), which are known without haptisym."""
    [lagged] = hs.distort(100, 1 / (1 + s / 50) ** 3).crossings("real", 0.1)
    [late] = hs.distort(100, exp(-s / 50)).crossings("imag", 0.1, band=(0, 100))
    with mpmath.workdps(60):
        known = mpmath.findroot(lambda x: 1 - mpmath.re(1 / mpmath.mpc(1, x / 50) ** 3) - mpmath.mpf(1) / 10, 6.6)
        assert abs(mpmath.mpf(lagged) - known) < mpmath.mpf(10) ** -57
        assert abs(lambdify(w, w * lagged, "mpmath")(1) - known) < mpmath.mpf(10) ** -57
        assert f"{lagged:.40f}" == mpmath.nstr(known, 41, strip_zeros=False)
    for x, exact in ((lagged, Float(known, 60)), (late, 50 * asin(Rational(1, 10)))):
        assert abs(N(2 * x + w - w - 2 * exact, 5)) < 1e-57
        again = pickle.loads(pickle.dumps(x * w))
        assert again == w * x
        assert {x: 1, sympify(x): 2} == {x: 2}
        assert abs(N(again.subs(w, 1) - exact, 5)) < 1e-57
    # A first zero of each of two searches: the second one is at pi minus the angle of the first.
    further, *_ = hs.distort(100, exp(-s / 50)).crossings("imag", 0.1, band=(20, 300))
    assert N(further + late - 50 * pi, 5, chop=1e-50) == 0
    assert further - late != 0
    assert sorted([lagged, late, 6, Rational(53, 10)]) == [late, Rational(53, 10), 6, lagged]
    assert late < 50 * asin(Rational(1, 9)) < lagged <= lagged < float("inf")
    put_in = hs.distort(100, 1 / (1 + s / 50) ** 3).at({"omega": lagged})
    assert abs(N(put_in.ratio_real - Rational(1, 10), 5)) < 1e-40
    # A root that is rational, 20 c/(1 - c) in squares with c = 1/5, is that number.
    assert sympify(hs.distort(100, 20 / (s + 20)).crossings("real", 0.2)[0]) is Integer(10)


def test_a_distortion_goes_back_to_sympy() -> None:
    for of, form in (("H_env", LAGGED.environment), ("H_perc", LAGGED.perceived), ("dH", LAGGED.distortion)):
        assert (hs.interop.to_sympy(LAGGED, of).to_expr() - form).together().expand() == 0
    assert hs.distort(hs.interop.to_sympy(LAGGED, "H_env"), hs.interop.to_sympy(LAG)) == LAGGED
    assert hs.interop.to_sympy(LAGGED) == hs.interop.to_sympy(LAGGED, "H_perc")
    state = StateSpace(Matrix([[-1 / T]]), Matrix([[1]]), Matrix([[1 / T]]), Matrix([[0]]))
    assert hs.distort(k + b * s, state) == LAGGED
    with pytest.raises(hs.SceneError, match="H_env, H_perc or dH"):
        hs.interop.to_sympy(LAGGED, "Re dH")
    with pytest.raises(hs.SceneError, match="not rational"):
        hs.interop.to_sympy(hs.distort(k, exp(-s * tau)))


def test_steps_are_a_function_of_each_step_and_the_result() -> None:
    d = hs.distort(k + b * s + m * s**2, LAG, exp(-s * tau))
    at = {k: 100.0, b: 3.0, m: 2.0, T: 0.02, tau: 0.01}
    arguments = [at[x] for x in sorted(at, key=str)]
    grid = np.array([1.0, 7.0, 30.0])
    for name in FORMS:
        found = d.lambdify(name, steps=True)(grid, *arguments)
        assert [*found] == [x.name for x, _ in d.steps(name).definitions] + [name]
        assert found[name] == pytest.approx(d.lambdify(name)(grid, *arguments))
        assert found[name] == pytest.approx(
            getattr(d.compile(of=[name])(grid, **{x.name: v for x, v in at.items()}), name)
        )
    exact = d.steps("real").at({**{x: Rational(v) for x, v in at.items()}, omega: Rational(7)})["real"]
    assert d.lambdify("real", "mpmath", steps=True)(mpmath.mpf(7), *arguments)["real"] == pytest.approx(float(exact))
