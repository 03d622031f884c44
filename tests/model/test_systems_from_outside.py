"""Systems from SymPy and from other packages are real rational functions of s in named real parameters, or are refused by name."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from typing import Any

import pytest
from sympy import Expr, Float, I, Matrix, Rational, Symbol, asin, cbrt, exp, sqrt
from sympy.physics.control import (
    Feedback,
    MIMOSeries,
    Parallel,
    Series,
    StateSpace,
    TransferFunction,
    TransferFunctionMatrix,
)

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
        (1 / (1 + I * w / 10), "contains I: write it in s"),
        (100 + 3 * I * w, "contains I: write it in s"),
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
