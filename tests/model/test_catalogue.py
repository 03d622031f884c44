"""Every model of the catalogue against its formula, written a second time in complex floats, and the rules for parameters."""

from __future__ import annotations

import cmath
import json
from collections.abc import Callable, Mapping
from math import comb, factorial, pi
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Expr, I, Rational, symbols

import haptisym as hs
from haptisym import effects, environments
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS

P = Mapping[str, Any]


def _in_a_row(*stiffnesses: complex) -> complex:
    return 1 / sum(1 / z for z in stiffnesses)


ENVIRONMENT: dict[str, tuple[dict[str, Any], Callable[[P, complex], complex]]] = {
    "mass-spring-damper": ({"m": 1, "b": 1, "k": 1}, lambda p, s: p["m"] * s * s + p["b"] * s + p["k"]),
    "kelvin-voigt": ({"k": 1, "b": 1}, lambda p, s: p["k"] + p["b"] * s),
    "maxwell": ({"k": 1, "b": 1}, lambda p, s: _in_a_row(p["k"], p["b"] * s)),
    "zener": ({"k0": 1, "k1": 1, "b1": 1}, lambda p, s: p["k0"] + _in_a_row(p["k1"], p["b1"] * s)),
    "prony": (
        {"k0": 1, "k": [1, 1, 1], "b": [1, 1, 1]},
        lambda p, s: p["k0"] + sum(_in_a_row(k, b * s) for k, b in zip(p["k"], p["b"], strict=True)),
    ),
    "spring-pot": (
        {"k_alpha": 1, "alpha": 0.1, "k": 1},
        lambda p, s: p["k"] + p["k_alpha"] * abs(s) ** p["alpha"] * cmath.exp(1j * pi / 2 * p["alpha"]),
    ),
    "two-mass": (
        {"m1": 1, "b1": 1, "k1": 1, "m2": 1, "b2": 1, "k2": 1},
        lambda p, s: p["m1"] * s**2 + p["b1"] * s + p["k1"] + _in_a_row(p["m2"] * s**2, p["k2"] + p["b2"] * s),
    ),
    "expression": (
        {"H": "m*s^2 + k*s/(s + w) - 3", "parameters": {"m": 1, "k": 1, "w": 1}},
        lambda p, s: p["m"] * s * s + p["k"] * s / (s + p["w"]) - 3,
    ),
}
"""For each model some parameters, which are scaled at random, and H_env."""


def _series(G: Callable[[P, complex], complex]) -> Callable[[P, complex, complex], complex]:
    return lambda p, s, H: G(p, s) * H


def _position_position(p: P, s: complex, H: complex) -> complex:
    Zm, Zs, Cm, Cs = p["Mm"] * s**2, p["Ms"] * s**2, p["Bm"] * s + p["Km"], p["Bs"] * s + p["Ks"]
    return Zm + Cm - cmath.exp(-2 * s * p["tau"]) * Cm * Cs / (Zs + Cs + H)


def _position_force(p: P, s: complex, H: complex) -> complex:
    Zs, Cs = p["Ms"] * s**2, p["Bs"] * s + p["Ks"]
    return p["Mm"] * s**2 + cmath.exp(-2 * s * p["tau"]) * Cs * H / (Zs + Cs + H)


def _four_channel(p: P, s: complex, H: complex) -> complex:
    Zcm, Zcs = (p[f"M{x}"] * s**2 + p[f"B{x}"] * s + p[f"K{x}"] for x in "ms")
    E = cmath.exp(-2 * s * p["tau"])
    return Zcm + E * (H - Zcm) * (Zcm + Zcs) / (Zcs + H - E * (H - Zcm))


def _waves(p: P, s: complex, H: complex) -> complex:
    # forwards u = (F + Z X)/2, backwards v = (F - Z X)/2 with Z = b s: each late by tau
    Z, late = p["b"] * s, cmath.exp(-s * p["tau"])
    forwards, backwards = (H + Z) / 2 / late, (H - Z) / 2 * late
    return (forwards + backwards) / ((forwards - backwards) / Z)


def _pade(p: P, s: complex) -> complex:
    n, x = p["order"], s * p["tau"]
    c = [comb(n, i) * factorial(2 * n - i) / factorial(2 * n) for i in range(n + 1)]
    return sum(a * (-x) ** i for i, a in enumerate(c)) / sum(a * x**i for i, a in enumerate(c))


DEVICE = {"Mm": 0.1, "Ms": 0.1, "Bs": 1, "Ks": 10, "tau": 0.1}

EFFECT: dict[str, tuple[dict[str, Any], Callable[[P, complex, complex], complex]]] = {
    "first-order-lag": ({"omega_c": 10}, _series(lambda p, s: p["omega_c"] / (s + p["omega_c"]))),
    "second-order-lowpass": (
        {"omega_n": 10, "zeta": 0.1},
        _series(lambda p, s: 1 / ((s / p["omega_n"]) ** 2 + 2 * p["zeta"] * s / p["omega_n"] + 1)),
    ),
    "delay": ({"tau": 0.1}, _series(lambda p, s: cmath.exp(-s * p["tau"]))),
    "pade-delay": ({"tau": 0.1, "order": 4}, _series(_pade)),
    "zero-order-hold": (
        {"T": 0.1},  # a delay of half a sample and the sine of the other half over itself
        _series(lambda p, s: cmath.exp(-s * p["T"] / 2) * cmath.sinh(s * p["T"] / 2) / (s * p["T"] / 2)),
    ),
    "sampled-loop": (  # by itself, with nothing to render: what it is late by
        {"T": 0.1, "method": "tustin", "delay": 2},
        _series(lambda p, s: cmath.exp(-s * p["T"] * 5 / 2) * cmath.sinh(s * p["T"] / 2) / (s * p["T"] / 2)),
    ),
    "series": (
        {"G": "(1 + s*a)/(1 + s*b)^2", "parameters": {"a": 0.1, "b": 0.1}},
        _series(lambda p, s: (1 + s * p["a"]) / (1 + s * p["b"]) ** 2),
    ),
    "shunt": ({"m": 0.1, "b": 1, "k": 1}, lambda p, s, H: H + p["m"] * s**2 + p["b"] * s + p["k"]),
    "compliance": ({"k": 10, "b": 1}, lambda p, s, H: _in_a_row(H, p["k"] + p["b"] * s)),
    "coulomb-friction": (
        {"force": 1, "amplitude": 0.1},
        lambda p, s, H: H + 4j * p["force"] / (pi * p["amplitude"]),
    ),
    "admittance-display": (
        {"P": "w/(s + w)", "parameters": {"w": 10}},
        lambda p, s, H: H * (s + p["w"]) / p["w"],
    ),
    "wave-variables": ({"b": 1, "tau": 0.1}, _waves),
    "position-force-teleoperator": (DEVICE, _position_force),
    "position-position-teleoperator": ({**DEVICE, "Bm": 1, "Km": 10}, _position_position),
    "four-channel-teleoperator": ({**DEVICE, "Bm": 1, "Km": 10}, _four_channel),
    "two-port": (
        {"A": "a + s", "B": "2*s", "C": "c/s", "D": "3", "parameters": {"a": 1, "c": 1}},
        lambda p, s, H: ((p["a"] + s) * H + 2 * s) / (p["c"] / s * H + 3),
    ),
}
"""For each model some parameters, which are scaled at random, and H_perc as a function of H_env."""


def test_every_model_of_the_catalogue_is_checked_here() -> None:
    assert set(ENVIRONMENT) == set(ENVIRONMENTS)
    assert set(EFFECT) == set(EFFECTS)


scales = st.integers(2, 99).map(lambda n: Rational(n, 10))


def scaled(draw: Callable[[st.SearchStrategy[Any]], Any], parameters: P) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the package is given (exact), and the same as floats."""
    given_values: dict[str, Any] = {}
    floats: dict[str, Any] = {}
    for name, value in parameters.items():
        if name == "parameters":
            given_values[name], inner = scaled(draw, value)
            floats.update(inner)
        elif isinstance(value, str) or name in ("order", "delay"):
            given_values[name] = floats[name] = value
        elif isinstance(value, list):
            given_values[name] = [draw(scales) * Rational(str(x)) for x in value]
            floats[name] = [float(x) for x in given_values[name]]
        else:
            given_values[name] = draw(scales) * Rational(str(value))
            floats[name] = float(given_values[name])
    return given_values, floats


def at(expression: Expr, omega: float) -> complex:
    return complex(expression.subs(hs.s, I * omega).evalf(30))


frequencies = st.floats(0.05, 40)


@pytest.mark.parametrize("model", ENVIRONMENT)
@given(data=st.data(), omega=frequencies)
def test_environments_are_their_formulas(model: str, data: st.DataObject, omega: float) -> None:
    parameters, formula = ENVIRONMENT[model]
    given_values, floats = scaled(data.draw, parameters)
    expected = formula(floats, 1j * omega)
    assert at(ENVIRONMENTS[model].build(**given_values).H, omega) == pytest.approx(expected, rel=1e-11)


@pytest.mark.few(9)
@pytest.mark.parametrize("model", EFFECT)
@given(data=st.data(), omega=frequencies, H=st.complex_numbers(min_magnitude=1, max_magnitude=100))
def test_effects_are_their_formulas(model: str, data: st.DataObject, omega: float, H: complex) -> None:
    parameters, formula = EFFECT[model]
    given_values, floats = scaled(data.draw, parameters)
    a, b, c, d = (at(entry, omega) for entry in EFFECTS[model].build(**given_values).matrix)
    expected = formula(floats, 1j * omega, H)
    assert (a * H + b) / (c * H + d) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    ("model", "reciprocal"),
    [
        ("shunt", True),
        ("compliance", True),
        ("wave-variables", True),
        ("first-order-lag", False),
        ("coulomb-friction", True),
    ],
)
def test_what_is_built_of_springs_and_masses_is_reciprocal(model: str, reciprocal: bool) -> None:  # noqa: FBT001
    parameters, _ = EFFECT[model]
    a, b, c, d = EFFECTS[model].build(**parameters).matrix
    determinant = complex((a * d - b * c).subs(hs.s, I * 3).evalf(30))
    assert (determinant == pytest.approx(1, rel=1e-12)) is reciprocal


@pytest.mark.parametrize("order", range(1, 11))
def test_a_pade_approximant_agrees_with_the_delay_to_twice_its_order(order: int) -> None:
    G = effects.pade_delay(1, order).matrix[0]
    for omega in (0.01, 0.1):
        error = abs(complex((G.subs(hs.s, I * Rational(str(omega)))).evalf(60) - cmath.exp(-1j * omega)))
        assert error < max(omega ** (2 * order + 1), 4e-16)
    all_pass = complex(G.subs(hs.s, 7 * I).evalf(30))
    assert abs(all_pass) == pytest.approx(1, rel=1e-12)


def test_a_parameter_that_is_absent_is_not_there() -> None:
    s = hs.s
    m, b, k = (hs.symbols(x) for x in "mbk")
    assert m * s**2 == environments.mass_spring_damper(m=m).H
    assert b * s == environments.mass_spring_damper(b=b).H
    assert k == environments.mass_spring_damper(k=k).H
    assert environments.mass_spring_damper(m=m).H.free_symbols == {m, s}
    assert effects.compliance(k=k).matrix == (1, 0, 1 / k, 1)
    assert effects.compliance(b=b).matrix == (1, 0, 1 / (b * s), 1)
    assert effects.shunt(m=m).matrix == (1, m * s**2, 0, 1)
    assert effects.shunt(Z="3*s").matrix == (1, 3 * s, 0, 1)


def test_numbers_strings_and_symbols_are_all_parameters() -> None:
    s = hs.s
    plain = symbols("k")
    assert 100 + s / 2 == environments.kelvin_voigt("100 N/m", 0.5).H
    assert plain + s / 3 == environments.kelvin_voigt(plain, "1/3").H
    assert effects.first_order_lag(2 * plain).matrix[0] == 2 * plain / (s + 2 * plain)


def test_symbols_may_be_given_in_each_other_s_places() -> None:
    m, k = hs.symbols("m k")
    swapped = environments.mass_spring_damper(m=k, k=m).H
    assert (swapped - (k * hs.s**2 + m)).equals(0)


# --- rules -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("mass-spring-damper", {"m": -1}), ("mass-spring-damper", {}), ("mass-spring-damper", {"m": "1 N/m"}),
        ("mass-spring-damper", {"mass": 1}), ("kelvin-voigt", {"k": 1}), ("maxwell", {"k": 0, "b": 1}),
        ("maxwell", {"k": 1, "b": 0}), ("zener", {"k0": 1, "k1": 1, "b1": "1 s"}),
        ("prony", {"k0": 1, "k": [1, 2], "b": [1]}), ("prony", {"k0": 1, "k": [], "b": []}),
        ("prony", {"k0": 1, "k": 1, "b": 1}), ("prony", {"k0": 1, "k": [1] * 21, "b": [1] * 21}),
        ("prony", {"k0": 1, "k": [-1], "b": [1]}), ("spring-pot", {"k_alpha": 1, "alpha": 0}),
        ("spring-pot", {"k_alpha": 1, "alpha": 1}), ("spring-pot", {"k_alpha": 1, "alpha": 1.5}),
        ("two-mass", {"m1": 1, "b1": 1, "k1": 1, "m2": 0, "b2": 1, "k2": 1}), ("expression", {}),
        ("expression", {"H": None}), ("expression", {"H": "m*s", "parameters": {"k": 1}}),
    ],
)  # fmt: skip
def test_environments_refuse_what_breaks_their_rules(model: str, parameters: dict[str, Any]) -> None:
    with pytest.raises(hs.SceneError):
        ENVIRONMENTS[model].build(**parameters)


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("first-order-lag", {"omega_c": 0}), ("first-order-lag", {"omega_c": "-5 Hz"}),
        ("first-order-lag", {"omega_c": "5 s"}), ("second-order-lowpass", {"omega_n": 1, "zeta": -0.1}),
        ("second-order-lowpass", {"omega_n": 1}), ("delay", {"tau": "-1 ms"}), ("pade-delay", {"tau": 1, "order": 0}),
        ("pade-delay", {"tau": 1, "order": 11}), ("pade-delay", {"tau": 1, "order": 1.5}),
        ("pade-delay", {"tau": 1, "order": symbols("n")}), ("zero-order-hold", {"T": 0}), ("shunt", {}),
        ("shunt", {"Z": "s", "k": 1}), ("compliance", {}), ("compliance", {"k": -1}),
        ("coulomb-friction", {"force": 1, "amplitude": 0}), ("wave-variables", {"b": 0, "tau": 1}),
        ("position-force-teleoperator", {"Mm": 1}), ("two-port", {"A": "1"}), ("series", {"G": "s", "gain": 2}),
        ("series", {"G": ["s"]}),
    ],
)  # fmt: skip
def test_effects_refuse_what_breaks_their_rules(model: str, parameters: dict[str, Any]) -> None:
    with pytest.raises(hs.SceneError):
        EFFECTS[model].build(**parameters)


def test_compensation_may_be_negative() -> None:
    assert effects.shunt(m="-45 g", b=-1, k=-2).matrix[1] == Rational(-9, 200) * hs.s**2 - hs.s - 2


def test_an_unknown_parameter_lists_the_valid_ones() -> None:
    with pytest.raises(hs.SceneError, match='"mass": valid are m, b, k'):
        environments.mass_spring_damper(mass=1)


# --- in a scene ------------------------------------------------------------------------------------------------------


def test_translation_and_rotation_are_not_mixed() -> None:
    with pytest.raises(hs.SceneError, match="cannot be mixed"):
        hs.Scene(environments.mass_spring_damper("1 kg"), (effects.compliance("5 N*m/rad"),))
    hs.Scene(
        environments.mass_spring_damper("1 kg*m^2"), (effects.compliance("5 N*m/rad"), effects.first_order_lag("5 Hz"))
    )


def test_parameters_of_one_name_stay_apart_in_a_scene() -> None:
    spring = environments.mass_spring_damper(m=1, k=2)
    scene = hs.Scene(spring, (effects.shunt(k=3), effects.compliance(k=5), effects.compliance(k=7)), rendered=spring)
    assert len({p.symbol for p in scene.parameters}) == len(scene.parameters) == 7
    substituted = scene.symbolic_distortion().perceived.subs({p.symbol: p.value for p in scene.parameters})
    assert (substituted - scene.distortion().perceived).equals(0)


COLLISIONS: dict[str, Callable[[], hs.Scene]] = {
    "a parameter named like a renamed one": lambda: hs.Scene(
        environments.expression("k*s + k_shunt", parameters={"k": 2, "k_shunt": 3}), (effects.shunt(k=5),)
    ),
    "two effects whose names differ in a hyphen": lambda: hs.Scene(
        environments.mass_spring_damper(k=2),
        (effects.first_order_lag(1, name="a-b"), effects.first_order_lag(3, name="a b")),
    ),
    "an effect named like a numbered one": lambda: hs.Scene(
        environments.mass_spring_damper(k=2),
        tuple(effects.first_order_lag(n, name=name) for n, name in ((1, "f"), (2, "f"), (3, "f-2"))),
    ),
}


@pytest.mark.parametrize("which", COLLISIONS)
def test_symbols_of_a_scene_are_unique(which: str) -> None:
    scene = COLLISIONS[which]()
    assert len({p.symbol for p in scene.parameters}) == len(scene.parameters)
    substituted = scene.symbolic_distortion().perceived.subs({p.symbol: p.value for p in scene.parameters})
    assert (substituted - scene.distortion().perceived).equals(0)


def test_a_band_beyond_the_largest_float_is_refused() -> None:
    scene = hs.Scene(environments.mass_spring_damper(k=2))
    with pytest.raises(
        hs.SceneError, match=r'band: "1e300 THz": in SI units the number must lie between 1e-300 and 1e300'
    ):
        scene.with_band(0, "1e300 THz")


def test_a_band_up_to_nearly_the_largest_float_is_shown() -> None:
    scene = hs.Scene(environments.mass_spring_damper(k=2))
    shown = json.loads(hs.evaluate(scene.with_band(0, "1e280 THz")).to_json())
    assert shown["band"] == [0.0, 6.283185307179587e292]  # 2 pi 10^292 rad/s
    assert shown["bandwidth"] == shown["band"][1]
