"""Systems from SymPy and from other packages are real rational functions of s in named real parameters, or are refused by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from sympy import Expr, I, Rational, Symbol, exp
from sympy.physics.control import TransferFunction

import haptisym as hs
from haptisym.kernel.rings import omega

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
    made = pytest.importorskip(package)
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
