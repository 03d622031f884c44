"""Every model of the catalogue against its formula, written a second time in complex floats; clocks, closed forms, other packages' systems."""

from __future__ import annotations

import cmath
import json
import pickle
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from itertools import product
from math import acos, asin, comb, cos, factorial, pi, sin
from typing import Any

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import assume, given
from hypothesis import strategies as st
from refusals import refusal
from sympy import Expr, Float, I, Integer, Matrix, Rational, Symbol, cancel, exp, lambdify, sqrt, symbols
from sympy import pi as exact_pi
from sympy.physics.control import Feedback, Parallel, Series, StateSpace, TransferFunction, TransferFunctionMatrix

import haptisym as hs
from haptisym import effects, environments, interop
from haptisym.kernel.harmonics import Harmonic, named_harmonics
from haptisym.kernel.rings import X
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS, METHODS
from haptisym.model.distortion import distort
from haptisym.model.scenefile import parse_scenes

s = hs.s
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


def _arms(p: P, s: complex) -> tuple[complex, complex]:
    return p["Mm"] * s**2 + p["Dm"] * s, p["Ms"] * s**2 + p["Ds"] * s


def _position_position(p: P, s: complex, H: complex) -> complex:
    (Zm, Zs), Cm, Cs = _arms(p, s), p["Bm"] * s + p["Km"], p["Bs"] * s + p["Ks"]
    return Zm + Cm - cmath.exp(-2 * s * p["tau"]) * Cm * Cs / (Zs + Cs + H)


def _position_force(p: P, s: complex, H: complex) -> complex:
    (Zm, Zs), Cs = _arms(p, s), p["Bs"] * s + p["Ks"]
    return Zm + p["scale_f"] * cmath.exp(-2 * s * p["tau"]) * Cs * H / (Zs + Cs + H) * p["scale_x"]


def _four_channel(p: P, s: complex, H: complex) -> complex:
    # what the hand would feel of the environment without delay, and of the slave: both scaled alike
    Zcm, Zcs = (Z + p[f"B{x}"] * s + p[f"K{x}"] for x, Z in zip("ms", _arms(p, s), strict=True))
    E, n = cmath.exp(-2 * s * p["tau"]), p["scale_f"] * p["scale_x"]
    return Zcm + E * (n * H - Zcm) * (Zcm + n * Zcs) / (n * Zcs + n * H - E * (n * H - Zcm))


def _waves(p: P, s: complex, H: complex) -> complex:
    # forwards u = (F + Z X)/2, backwards v = (F - Z X)/2 with Z = b s: each late by tau
    Z, late = p["b"] * s, cmath.exp(-s * p["tau"])
    forwards, backwards = (H + Z) / 2 / late, (H - Z) / 2 * late
    return (forwards + backwards) / ((forwards - backwards) / Z)


def _pade(p: P, s: complex) -> complex:
    n, x = p["order"], s * p["tau"]
    c = [comb(n, i) * factorial(2 * n - i) / factorial(2 * n) for i in range(n + 1)]
    return sum(a * (-x) ** i for i, a in enumerate(c)) / sum(a * x**i for i, a in enumerate(c))


def _rounded(q: float, amplitude: float) -> float:
    # each step is a square wave that begins where the sine has reached the middle between two multiples
    begins = (asin((i - 0.5) * q / amplitude) for i in range(1, int(amplitude / q + 0.5) + 1))
    return 4 * q / (pi * amplitude) * sum(map(cos, begins))


def _limited(limit: float, amplitude: float) -> float:
    angle = asin(min(1.0, limit / amplitude))
    return (2 * angle + sin(2 * angle)) / pi


def _played(gap: float, amplitude: float) -> complex:
    # driven from one flank up to the top, then left there for the angle that the hand needs to cross the play
    if gap >= 2 * amplitude:
        return 0j
    crossing = acos(1 - gap / amplitude)
    return (pi - crossing + sin(2 * crossing) / 2) / pi - 1j * sin(crossing) ** 2 / pi


DEVICE = {"Mm": 0.1, "Ms": 0.1, "Bs": 1, "Ks": 10, "tau": 0.1, "Dm": 1, "Ds": 1}
SCALES = {"scale_x": 1, "scale_f": 1}

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
    "coulomb-friction": ({"force": 1, "amplitude": 0.1}, lambda p, s, H: H + 4j * p["force"] / (pi * p["amplitude"])),
    "encoder": ({"q": 0.1, "amplitude": 0.1}, _series(lambda p, s: _rounded(p["q"], p["amplitude"]))),
    "backlash": ({"gap": 0.1, "amplitude": 0.1}, _series(lambda p, s: _played(p["gap"], p["amplitude"]))),
    "dead-zone": ({"width": 0.1, "amplitude": 0.1}, _series(lambda p, s: 1 - _limited(p["width"], p["amplitude"]))),
    "saturation": ({"limit": 0.1, "amplitude": 0.1}, _series(lambda p, s: _limited(p["limit"], p["amplitude"]))),
    "admittance-display": (
        {"P": "w/(s + w)", "parameters": {"w": 10}, "tau": 0.1},
        lambda p, s, H: H * (s + p["w"]) / p["w"] * cmath.exp(s * p["tau"]),
    ),
    "wave-variables": ({"b": 1, "tau": 0.1}, _waves),
    "position-force-teleoperator": ({**DEVICE, **SCALES}, _position_force),
    "position-position-teleoperator": ({**DEVICE, "Bm": 1, "Km": 10}, _position_position),
    "four-channel-teleoperator": ({**DEVICE, **SCALES, "Bm": 1, "Km": 10}, _four_channel),
    "two-port": (
        {"A": "a + s", "B": "2*s", "C": "c/s", "D": "3", "parameters": {"a": 1, "c": 1}},
        lambda p, s, H: ((p["a"] + s) * H + 2 * s) / (p["c"] / s * H + 3),
    ),
}
"""For each model some parameters, which are scaled at random, and H_perc as a function of H_env."""


def test_every_model_of_the_catalogue_is_checked_here() -> None:
    assert {*ENVIRONMENT, "difference-equation"} == set(ENVIRONMENTS)  # which is in z, and below
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


@pytest.mark.dear("expression", "prony", "two-mass")
@pytest.mark.parametrize("model", ENVIRONMENT)
@given(data=st.data(), omega=frequencies)
def test_environments_are_their_formulas(model: str, data: st.DataObject, omega: float) -> None:
    parameters, formula = ENVIRONMENT[model]
    given_values, floats = scaled(data.draw, parameters)
    expected = formula(floats, 1j * omega)
    assert at(ENVIRONMENTS[model].build(**given_values).H, omega) == pytest.approx(expected, rel=1e-11)


@pytest.mark.dear(
    "first-order-lag",
    "pade-delay",
    "position-force-teleoperator",
    "sampled-loop",
    "series",
    "two-port",
    "wave-variables",
    "zero-order-hold",
)
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


ELEMENTS: dict[str, Callable[[float, float, float], float]] = {
    # the next output, of the input, the size that the element has, and the output before
    "encoder": lambda x, q, _: q * round(x / q),
    "backlash": lambda x, gap, before: min(max(before, x - gap / 2), x + gap / 2),
    "dead-zone": lambda x, width, _: x - min(max(x, -width), width),
    "saturation": lambda x, limit, _: min(max(x, -limit), limit),
}


@pytest.mark.parametrize("ratio", ["3/100", "1/3", "7/10", "1", "3/2", "5/2"])
@pytest.mark.parametrize("model", ELEMENTS)
def test_a_describing_function_is_the_first_harmonic_of_its_element(model: str, ratio: str) -> None:
    count, total, before = 4_000, 0j, 0.0
    for i in range(2 * count):  # of two periods of a sine of size 1 the second one
        angle = 2 * pi * (i + 0.5) / count
        before = ELEMENTS[model](sin(angle), float(Rational(ratio)), before)
        total += before * cmath.exp(-1j * angle) * (i >= count)
    size = next(x for x in EFFECTS[model].slots if x != "amplitude")
    N = EFFECTS[model].build(**{size: Rational(ratio), "amplitude": 1}).matrix[0]
    assert complex(N.evalf(30)) == pytest.approx(2j * total / count, abs=1e-3)


def test_a_describing_function_is_exact_in_symbols_and_a_number_of_sixty_digits_in_numbers() -> None:
    q, a = hs.symbols("q a")
    found = hs.distort(environments.mass_spring_damper(k=1), effects.encoder(q, a)).perceived
    assert found.free_symbols == {q, a}
    three = found.subs({q: 2, a: 3})  # two steps, at 1 and 3: the second just not
    assert abs(three - 4 * 2 / (3 * exact_pi) * sqrt(1 - Rational(1, 9))).evalf(70) < Rational(1, 10**55)


@pytest.mark.parametrize("ratio", ["3/100", "1/7", "1/3", "7/10", "1", "3/2", "2", "5/2"])
@pytest.mark.parametrize("model", ELEMENTS)
def test_a_describing_function_written_out_is_the_number_also_where_nothing_passes(model: str, ratio: str) -> None:
    """As it stands on a page: names, defined one after the other in functions that everybody knows."""
    size = next(x for x in EFFECTS[model].slots if x != "amplitude")
    known = dict(zip(hs.symbols("size amplitude"), (Rational(ratio), Rational(1)), strict=True))
    entry = EFFECTS[model].build(**dict(zip((size, "amplitude"), known, strict=True))).matrix[0]
    names, definitions = named_harmonics(entry.atoms(Harmonic), {"size", "amplitude"})
    for name, form in definitions:
        assert not form.atoms(Harmonic)
        known[name] = form.xreplace(known).doit()
    written = entry.xreplace(names).xreplace(known)
    assert abs((written - EFFECTS[model].build(**{size: Rational(ratio), "amplitude": 1}).matrix[0]).evalf(70)) < 1e-58
    assert {str(x) for x in entry.xreplace(names).free_symbols} <= {"n_p", "n_q"}


def test_an_encoder_of_very_many_steps_is_left_out() -> None:
    assert "leave the encoder out" in refusal(lambda: effects.encoder("1 nm", "1 m").matrix)


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

BROKEN: list[tuple[str, dict[str, Any]]] = [
    ("mass-spring-damper", {"m": -1}), ("mass-spring-damper", {}), ("mass-spring-damper", {"m": "1 N/m"}),
    ("mass-spring-damper", {"mass": 1}), ("kelvin-voigt", {"k": 1}), ("maxwell", {"k": 0, "b": 1}), ("maxwell", {"k": 1, "b": 0}),
    ("zener", {"k0": 1, "k1": 1, "b1": "1 s"}), ("prony", {"k0": 1, "k": [1, 2], "b": [1]}), ("prony", {"k0": 1, "k": [], "b": []}),
    ("prony", {"k0": 1, "k": 1, "b": 1}), ("prony", {"k0": 1, "k": [1] * 21, "b": [1] * 21}), ("prony", {"k0": 1, "k": [-1], "b": [1]}),
    ("spring-pot", {"k_alpha": 1, "alpha": 0}), ("spring-pot", {"k_alpha": 1, "alpha": 1}),
    ("two-mass", {"m1": 1, "b1": 1, "k1": 1, "m2": 0, "b2": 1, "k2": 1}), ("expression", {}), ("expression", {"H": None}),
    ("expression", {"H": "m*s", "parameters": {"k": 1}}),
    ("first-order-lag", {"omega_c": 0}), ("first-order-lag", {"omega_c": "-5 Hz"}), ("first-order-lag", {"omega_c": "5 s"}),
    ("second-order-lowpass", {"omega_n": 1, "zeta": -0.1}), ("second-order-lowpass", {"omega_n": 1}), ("delay", {"tau": "-1 ms"}),
    ("pade-delay", {"tau": 1, "order": 0}), ("pade-delay", {"tau": 1, "order": 11}), ("pade-delay", {"tau": 1, "order": 1.5}),
    ("pade-delay", {"tau": 1, "order": symbols("n")}), ("zero-order-hold", {"T": 0}), ("shunt", {}), ("shunt", {"Z": "s", "k": 1}),
    ("compliance", {}), ("compliance", {"k": -1}), ("coulomb-friction", {"force": 1, "amplitude": 0}), ("wave-variables", {"b": 0, "tau": 1}),
    ("position-force-teleoperator", {"Mm": 1}), ("two-port", {"A": "1"}), ("series", {"G": "s", "gain": 2}), ("series", {"G": ["s"]}),
    ("sampled-loop", {"T": 0, "method": "tustin"}), ("sampled-loop", {"T": 1, "method": "euler"}), ("difference-equation", {"D": "s"}), ("difference-equation", {"D": "z^0.5"}), ("difference-equation", {"D": 1j}),
    ("admittance-display", {"P": "1/(1 + s*tau)", "parameters": {"tau": 1}, "tau": 1}),
    ("sampled-loop", {"T": 1, "method": "tustin", "delay": 0.5}), ("sampled-loop", {"T": 1, "method": "tustin", "delay": -1}),
]  # fmt: skip


@pytest.mark.parametrize(("model", "parameters"), BROKEN)
def test_models_refuse_what_breaks_their_rules(model: str, parameters: dict[str, Any]) -> None:
    with pytest.raises(hs.SceneError):
        (ENVIRONMENTS | EFFECTS)[model].build(**parameters)


def test_compensation_may_be_negative() -> None:
    assert effects.shunt(m="-45 g", b=-1, k=-2).matrix[1] == Rational(-9, 200) * s**2 - s - 2


def test_translation_and_rotation_are_not_mixed() -> None:
    with pytest.raises(hs.SceneError, match="cannot be mixed"):
        hs.Scene(environments.mass_spring_damper("1 kg"), (effects.compliance("5 N*m/rad"),))
    hs.Scene(
        environments.mass_spring_damper("1 kg*m^2"), (effects.compliance("5 N*m/rad"), effects.first_order_lag("5 Hz"))
    )


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


def test_a_band_up_to_nearly_the_largest_float_is_shown() -> None:
    scene = hs.Scene(environments.mass_spring_damper(k=2))
    shown = json.loads(hs.evaluate(scene.with_band(0, "1e280 THz")).to_json())
    assert shown["band"] == [0.0, 6.283185307179587e292]  # 2 pi 10^292 rad/s
    assert shown["bandwidth"] == shown["band"][1]


# --- closed forms ----------------------------------------------------------------------------------------------------

LAG = effects.first_order_lag(20)

SCENES: dict[str, tuple[hs.Environment, tuple[hs.Effect, ...], hs.Environment | None]] = {
    "filter": (environments.mass_spring_damper("1.8", 15, 100), (effects.second_order_lowpass(80, Rational(1, 2)),), None),
    "joint": (environments.kelvin_voigt(100, 3), (effects.compliance(k=800, b=4), effects.shunt(m="0.1", b="-0.2")), None),
    "delay": (environments.zener(200, 300, 6), (effects.delay("5 ms"), effects.shunt(b=1)), None),
    "tissue": (environments.spring_pot(120, "0.5", k=10), (LAG,), None),
    "rendered": (environments.kelvin_voigt(100, 3), (effects.position_force_teleoperator("0.2", "0.3", 4, 500),), environments.kelvin_voigt(90, 5)),
    "nothing": (environments.maxwell(100, 5), (), None),
}  # fmt: skip


def number(form: Expr, w: float) -> complex:
    known = {hs.s: 1j * w, hs.omega: w, X: 0.3}
    free = sorted(form.free_symbols, key=str)
    return complex(lambdify(free, form, "numpy")(*(known[x] for x in free)))


@pytest.mark.slow
@pytest.mark.few("delay", "rendered", "tissue")
@pytest.mark.parametrize("name", SCENES)
def test_every_closed_form_is_what_complex_arithmetic_gives(name: str) -> None:
    own, between, rendered = SCENES[name]
    d = distort(own, *between, rendered=rendered)
    for w in (0.7,):
        H, felt = number(own.H, w), number((rendered or own).H, w)
        for effect in between:
            A, B, C, D = (number(x, w) for x in effect.matrix)
            felt = (A * felt + B) / (C * felt + D)
        change, size = felt - H, abs(H)
        told: dict[str, Any] = {
            "environment": H, "perceived": felt, "distortion": change, "real": change.real, "imag": change.imag, "ratio_real": abs(change.real) / size,
            "ratio_imag": abs(change.imag) / size, "relative_real": (change / H).real, "relative_imag": (change / H).imag, "modulus": size,
        }  # fmt: skip
        for key, value in told.items():
            assert number(getattr(d, key), w) == pytest.approx(value, rel=1e-9, abs=1e-9 * size), key
        for p, h in ((d.environment_properties, H), (d.perceived_properties, felt)):
            found = [number(x, w) for x in (p.stiffness, p.mass, p.damping, p.spring_inertia_force, p.damping_force)]
            assert found == pytest.approx(
                [h.real, -h.real / w**2, h.imag / w, 0.3 * h.real, 0.3j * h.imag], rel=1e-8, abs=1e-10 * size
            )
        jnd = d.parameter_jnd(Rational(1, 10))
        assert [number(x, w) for x in (jnd.stiffness, jnd.damping, jnd.mass)] == pytest.approx(
            [size / 10, size / 10 / w, size / 10 / w**2], rel=1e-9
        )
        functions = d.functions(["real", "ratio_imag", "relative_real", "environment_imag", "perceived_real"])
        expected = {
            "real": change.real,
            "ratio_imag": (change.imag / size) ** 2,
            "relative_real": (change / H).real,
            "environment_imag": H.imag,
            "perceived_real": felt.real,
        }
        for key, f in functions.items():
            assert number(f.expression(), w) == pytest.approx(expected[key], rel=1e-8, abs=1e-9 * size), key
    assert repr(d).endswith({0: "no effects>", 1: "1 effect>", 2: "2 effects>"}[len(between)])


@given(st.lists(st.integers(1, 12), min_size=1, max_size=3), st.booleans())
def test_a_changeover_is_the_lowest_frequency_at_which_the_real_part_changes_its_sign(
    roots: list[int],
    twice: bool,  # noqa: FBT001
) -> None:
    """Re H is a product of w^2 - r^2; a root that is there twice changes nothing."""
    s = hs.s
    H = Integer(1)
    for r in roots:
        H = H * (s**2 + r**2)
    H = H * (s**2 + 7) ** 2 if twice else H
    times = {r: roots.count(r) for r in roots}
    odd = sorted(r for r, n in times.items() if n % 2)
    found = distort(environments.expression(H + 3 * s)).changeover_environment
    assert found == (odd[0] if odd else None)
    behind = distort(environments.kelvin_voigt(1, 1), rendered=environments.expression(H + 3 * s))
    assert (behind.changeover_environment, behind.changeover_perceived) == (None, found)


def test_a_changeover_in_symbols_is_a_formula_where_one_root_is_the_lowest() -> None:
    m, b, k, k2 = hs.symbols("m b k k_2")
    assert distort(environments.mass_spring_damper(m, b, k)).changeover_environment == sqrt(k) / sqrt(m)
    assert distort(environments.spring_pot(k, "0.3")).changeover_environment is None
    s = hs.s
    lower = environments.expression((s**2 + 4 * k) * (s**2 + k), parameters={"k": k})
    assert distort(lower).changeover_environment == sqrt(k)
    either = environments.expression((s**2 + k2) * (s**2 + k), parameters={"k": k, "k_2": k2})
    assert distort(either).changeover_environment is None
    pole = distort(environments.expression("1/(s^2 + 49)")).changeover_environment
    assert pole == 7


def test_what_is_felt_of_nothing_or_infinite_everywhere_is_refused() -> None:
    for own, between, told in (
        (environments.expression("s - s"), (), "the environment is zero at every frequency"),
        (
            environments.kelvin_voigt(1, 1),
            (effects.two_port("1", "0", "1", "-1 - s"),),
            "effect 1 makes H_perc infinite, or 0/0, at every frequency",
        ),
        (
            environments.kelvin_voigt(100, 0),
            (effects.shunt(k=-200), effects.compliance(k=100), effects.compliance(k=50)),
            "effect 2 makes H_perc infinite, or 0/0, at every frequency .* write it and the next one as one effect",
        ),
    ):
        with pytest.raises(hs.SceneError, match=told):
            distort(own, *between)
    # Written as one effect: three springs in a row, of which the first two have no compliance together.
    as_one = effects.compliance(k=1 / (Rational(1, 100) + Rational(1, 50)))
    felt = distort(environments.kelvin_voigt(100, 0), effects.shunt(k=-200), as_one).perceived
    assert felt == 1 / (1 / Integer(100 - 200) + Rational(1, 100) + Rational(1, 50)) == 50


# --- clocks ----------------------------------------------------------------------------------------------------------

WALL = environments.kelvin_voigt(500, 3)

S_OF_Z = {
    "backward-difference": lambda z, T: (1 - 1 / z) / T,
    "tustin": lambda z, T: 2 / T * (z - 1) / (z + 1),
    "forward-difference": lambda z, T: (z - 1) / T,
}


def held(H, T: float, method: str, delay: int, omega: float) -> complex:  # type: ignore[no-untyped-def]
    """The witness: the Fourier coefficient at omega of a staircase whose steps are D(z) z^-delay times samples of exp(j omega t)."""
    z = cmath.exp(1j * omega * T)
    step = H(S_OF_Z[method](z, T)) * z**-delay
    pieces = 2000  # of one step: midpoint rule for (1/T) int_0^T exp(-j omega t) dt
    return step * sum(cmath.exp(-1j * omega * T * (i + 0.5) / pieces) for i in range(pieces)) / pieces


@pytest.mark.dear("0-backward-difference", "3-tustin")
@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["backward-difference", "tustin"])
@pytest.mark.parametrize("delay", [0, 1, 3])
@given(part=st.floats(0.01, 0.99))
def test_what_is_felt_is_the_staircase_at_its_own_frequency(method: str, delay: int, part: float) -> None:
    T = 0.004
    omega = part * pi / T
    perceived = hs.distort(WALL, hs.effects.sampled_loop("4 ms", method, delay)).perceived
    found = complex(perceived.subs(hs.s, I * omega).evalf(30))
    expected = held(lambda s: 500 + 3 * s, T, method, delay, omega)
    assert found == pytest.approx(expected, rel=1e-5)


def test_a_spring_is_rendered_alike_by_all_methods() -> None:
    spring = hs.environments.mass_spring_damper(k=500)
    felt = {hs.distort(spring, hs.effects.sampled_loop("4 ms", method)).perceived for method in METHODS}
    assert felt == {hs.distort(spring, hs.effects.zero_order_hold("4 ms")).perceived}


@pytest.mark.slow
@given(
    st.lists(st.integers(-5, 9), min_size=1, max_size=3),
    st.lists(st.integers(1, 9), min_size=1, max_size=3),
    st.sampled_from(METHODS),
    st.integers(1, 9),
)
def test_a_difference_equation_is_the_dynamics_with_what_the_method_makes_of_s(
    above: list[int], below: list[int], method: str, tenths: int
) -> None:
    assume(any(above))
    top, bottom = (sum((Integer(a) * s**i for i, a in enumerate(x)), Integer(0)) for x in (above, below))
    loop = effects.sampled_loop(Rational(tenths, 10), method)
    T, w = tenths / 10, 1.3
    of = S_OF_Z[method](cmath.exp(1j * w * T), T)
    parts = [sum(a * of**i for i, a in enumerate(x)) for x in (above, below)]
    assume(abs(parts[1]) > 1e-6)
    degree = max(i for i, a in enumerate(above) if a)
    if method == "forward-difference" and degree > len(below) - 1:
        assert "future samples" in refusal(hs.Scene, environments.expression(top / bottom), (loop,))
        return
    hold = (1 - cmath.exp(-1j * w * T)) / (1j * w * T)
    found = at(hs.distort(environments.expression(top / bottom), loop).perceived, w)
    assert found == pytest.approx(hold * parts[0] / parts[1], rel=1e-9)


@pytest.mark.slow
@pytest.mark.few(2)
@pytest.mark.parametrize("method", ["backward-difference", "tustin"])
@pytest.mark.parametrize("rendered", ["k + b*s", "k + b*s*w/(s + w)"])
def test_the_simulated_clock_agrees_with_the_closed_form(method: str, rendered: str) -> None:
    """The difference equation in time, sample by sample, knows no exp(-s T)."""
    wall = environments.expression(rendered, parameters={"k": 500, "b": 3, **({"w": 300} if "w" in rendered else {})})
    run = hs.simulate(
        hs.Scene(wall, (effects.sampled_loop("10 ms", method, 1), effects.shunt(m="0.1"))), hs.sine("1 cm", 20)
    )
    assert run.agrees
    assert run.built == ("sampled-loop", "shunt")


CLOCKED = """
[environment]
model = "mass-spring-damper"
k = 500
b = 3
{more}
[[effects]]
name = "loop"
model = "sampled-loop"
T = "1 ms"
method = "{method}"
{behind}
"""
BESIDE = '[[effects]]\nname = "other"\nmodel = "{}"\n'
NO_CLOCK = [
    ({"more": BESIDE.format("shunt") + "m = 0.1\n"}, "must be the first effect"),
    ({"behind": BESIDE.format("zero-order-hold") + 'T = "2 ms"'}, "effects.other: a second sampler"),
    ({"behind": BESIDE.format("sampled-loop") + 'T = "2 ms"\nmethod = "tustin"'}, "effects.other: a second sampler"),
    ({"more": BESIDE.format("zero-order-hold") + 'T = "2 ms"\n'}, "effects.other: a second sampler"),
    ({"method": "forward-difference"}, "effects.loop: forward-difference would need future samples"),
    ({"method": "tustinn"}, "did you mean"),
    ({"more": '[rendered]\nmodel = "spring-pot"\nk_alpha = 80\nalpha = 0.5\n'}, "rational in s"),
]


@pytest.mark.parametrize(("keys", "told"), NO_CLOCK)
def test_what_a_clock_cannot_render_or_stand_beside_is_refused(keys: dict[str, str], told: str) -> None:
    text = CLOCKED.format(**({"more": "", "method": "tustin", "behind": ""} | keys))
    assert told in refusal(hs.parse_scene, text)


def test_a_scene_with_other_values_an_environment_of_a_family_and_a_copy_keep_their_clock() -> None:
    text = CLOCKED.format(more="", method="tustin", behind="")
    moved = hs.parse_scene(text).with_values({"environment.k": 200, "effects.loop.T": "2 ms"})
    wall, loop = environments.mass_spring_damper(k=200, b=3), effects.sampled_loop("2 ms", "tustin")
    assert moved.distortion().perceived == hs.distort(wall, loop).perceived
    several = text.replace("[environment]", '[[environments]]\nname = "a"').replace(
        "[[effects]]", '[[environments]]\nname = "b"\nmodel = "kelvin-voigt"\nk = 90\nb = 1\n[[effects]]', 1
    )
    found = parse_scenes(several).scenes["b"]
    expected = hs.distort(environments.kelvin_voigt(90, 1), effects.sampled_loop("1 ms", "tustin")).perceived
    assert found.distortion().perceived == expected
    assert pickle.loads(pickle.dumps(found)).distortion().perceived == expected


# --- systems of other packages ---------------------------------------------------------------------------------------

FILTER = Rational(6400) / (s**2 + 80 * s + 6400)

MSD = Rational(9, 5) * s**2 + 15 * s + 100

LEAD = (Rational(3, 10) * s + 1) / (Rational(7, 100) * s + 1)

p, k, m = symbols("p k m")

w = Symbol("s", complex=True)

SAME = {
    "an expression": (6400 / (s**2 + 80.0 * s + 6400), FILTER),
    "another symbol s": (6400 / (w**2 + 80 * w + 6400), FILTER),
    "a pair of lists": (([6400], [1, 80, 6400]), FILTER),
    "a pair of arrays": ((np.array([6400]), np.array([1.0, 80.0, 6400.0])), FILTER),
    "numbers of every kind": (([Decimal("0.3"), "1"], [Fraction(7, 100), np.int64(1)]), LEAD),
    "single precision": (([np.float32(0.3), 1], [0.07, 1]), LEAD),
    "an improper pair": (([1.8, 15, 100], [1]), MSD),
    "an environment": (environments.mass_spring_damper("1.8 kg", 15, 100), MSD),
    "an effect": (effects.second_order_lowpass(80, 0.5), FILTER),
    "SymPy": (TransferFunction(6400, p**2 + 80 * p + 6400, p), FILTER),
    "SymPy with floats": (TransferFunction(0.3 * p + 1, 0.07 * p + 1, p), LEAD),
    "SymPy with parameters": (TransferFunction(k, m * p**2 + k, p), k / (m * s**2 + k)),
    "SymPy in series": (Series(TransferFunction(2, p, p), TransferFunction(3, p + 1, p)), 6 / (s * (s + 1))),
    "SymPy in parallel": (Parallel(TransferFunction(2, p, p), TransferFunction(3, p + 1, p)), 2 / s + 3 / (s + 1)),
    "SymPy in feedback": (Feedback(TransferFunction(5, p, p), TransferFunction(1, 1, p)), 5 / (s + 5)),
    "SymPy with a delay": (TransferFunction(exp(-p / 50), p + 1, p), exp(-s / 50) / (s + 1)),
    "SymPy's state space": (StateSpace(Matrix([[0, 1], [-k, -3]]), Matrix([0, 1]), Matrix([[k, 0]]), Matrix([[0]])), k / (s**2 + 3 * s + k)),
    "control": (control.tf([6400], [1, 80, 6400]), FILTER),
    "control, improper": (control.tf([1.8, 15, 100], [1]), MSD),
    "control, dt = None": (control.TransferFunction([0.3, 1], [0.07, 1], None), LEAD),
    "control, series": (control.tf([2], [1, 0]) * control.tf([3], [1, 1]), 6 / (s * (s + 1))),
    "control's state space": (control.ss([[0, 1], [-6400, -80]], [[0], [6400]], [[1, 0]], [[0]]), FILTER),
    "control's feedthrough": (control.ss([[-0.1]], [[1]], [[0.3]], [[2]]), 2 + Rational(3, 10) / (s + Rational(1, 10))),
    "control's gain": (control.ss([], [], [], [[2.5]]), Rational(5, 2)),
    "SciPy": (scipy.signal.TransferFunction([6400], [1, 80, 6400]), FILTER),
    "SciPy's lti": (scipy.signal.lti([6400], [1, 80, 6400]), FILTER),
    "SciPy's zeros and poles": (scipy.signal.ZerosPolesGain([-2], [-1 + 3j, -1 - 3j, -0.1], 0.5), Rational(1, 2) * (s + 2) / ((s**2 + 2 * s + 10) * (s + Rational(1, 10)))),
    "SciPy's poles alone": (scipy.signal.lti([], [-4.0], 4), 4 / (s + 4)),
    "SciPy's state space": (scipy.signal.StateSpace([[0, 1], [-6400, -80]], [[0], [6400]], [[1, 0]], [[0]]), FILTER),
}  # fmt: skip


@pytest.mark.dear("SciPy's zeros and poles")
@pytest.mark.parametrize(("system", "wanted"), SAME.values(), ids=SAME.keys())
def test_a_system_comes_in_exactly(system: Any, wanted: Expr) -> None:
    found = interop.dynamics(system)
    assert not found.atoms(Float)
    assert cancel(found - wanted) == 0
    assert interop.environment(system).model == "expression"
    assert cancel(interop.environment(system).H - wanted) == 0
    assert cancel(interop.series(system, name="given").matrix[0] - wanted) == 0
    assert interop.series(system, name="given").name == "given"


def test_a_fourth_order_state_space_has_the_response_that_its_own_package_computes():
    rng = np.random.default_rng(1)
    system = control.ss(
        rng.normal(size=(4, 4)).round(3), rng.normal(size=(4, 1)).round(3), rng.normal(size=(1, 4)).round(3), [[0.25]]
    )
    H = interop.dynamics(system)
    for omega in (0, 1, 12):
        assert abs(complex(H.subs(s, 1j * omega)) - system(1j * omega)) < 1e-9


REFUSED = {
    "two inputs": (control.ss([[-1]], [[1, 2]], [[1]], [[0, 0]]), "2 inputs and 1 outputs"),
    "a matrix of SymPy": (TransferFunctionMatrix([[TransferFunction(1, p, p)], [TransferFunction(2, p, p)]]), "1 inputs and 2 outputs"),
    "two outputs in SciPy": (scipy.signal.TransferFunction([[1, 2], [3, 4]], [1, 1]), "several outputs"),
    "two inputs in SciPy": (scipy.signal.StateSpace([[-1]], [[1, 2]], [[1]], [[0, 0]]), "2 inputs and 1 outputs"),
    "discrete in control": (control.tf([1], [1, 0.5], 0.001), r"discrete time \(dt = 0.001\).*zero-order-hold"),
    "discrete without dt": (control.tf([1], [1, 0.5], dt=True), "discrete time"),
    "discrete in SciPy": (scipy.signal.dlti([1], [1, 0.5], dt=0.01), "discrete time"),
    "lonely complex roots": (scipy.signal.ZerosPolesGain([], [-1 + 3j, -2], 1), "conjugate pairs"),
    "complex coefficients": (([1], [1, 2j]), "is complex"),
    "not a number": (([1], [1, float("nan")]), "nan"),
    "a zero denominator": (([1], [0, 0]), "denominator is zero"),
    "a string": ("1/(s + 1)", "is not a system"),
    "three things": (([1], [1], [1]), "is not a system"),
    "a shunt": (effects.shunt(m="1 kg"), "not an effect in series"),
    "frequency data": (control.frd([1, 2], [1, 2]), "is not a system"),
}  # fmt: skip


@pytest.mark.parametrize(("system", "message"), REFUSED.values(), ids=REFUSED.keys())
def test_what_is_no_continuous_system_with_one_input_and_one_output_is_refused(system, message):
    with pytest.raises(hs.SceneError, match=message):
        interop.dynamics(system)


MONIC = [FILTER, MSD, Rational(1, 10) / s, s / 10**6, MSD / (s + 1), (s + 2) / (s**2 + s / 10 + 400)]

SCALED = [LEAD, 1 / (3 * s + 1), (s + 1) / (s * (7 * s + 3))]

EXPORTS = [interop.to_sympy, interop.to_control, interop.to_scipy]


def named(x):
    return getattr(x, "__name__", None) or str(x)


@pytest.mark.parametrize(("H", "export"), [*product(MONIC, EXPORTS), *product(SCALED, EXPORTS[:2])], ids=named)
def test_there_and_back_is_the_same_system_exactly(H, export):
    assert cancel(interop.dynamics(export(H)) - H) == 0


@pytest.mark.parametrize("H", SCALED, ids=str)
def test_scipy_divides_by_the_leading_coefficient_and_rounds(H):
    back = interop.dynamics(interop.to_scipy(H))
    assert abs(complex((back / H).subs(s, 3j)) - 1) < 1e-15


def test_the_exported_system_is_one_of_the_other_package_with_the_coefficients_as_they_are_written():
    there = interop.to_control(environments.mass_spring_damper("1.8 kg", 15, 100))
    assert (there.num[0][0].tolist(), there.den[0][0].tolist()) == ([1.8, 15, 100], [1])
    assert there.isctime()
    there = interop.to_scipy(effects.second_order_lowpass(80, 0.5))
    assert isinstance(there, scipy.signal.TransferFunction)
    assert (there.num.tolist(), there.den.tolist()) == ([6400], [1, 80, 6400])
    assert interop.to_sympy(k / (m * s**2 + k)) == TransferFunction(k, k + m * s**2, s)


def test_irrational_coefficients_are_the_nearest_doubles():
    assert interop.to_control(effects.first_order_lag("20 Hz")).den[0][0].tolist() == [1, 125.66370614359172]
    assert interop.dynamics(interop.to_sympy(1 / (s + 40 * exact_pi))) == 1 / (s + 40 * exact_pi)


def test_all_parts_of_a_distortion_can_be_exported():
    d = hs.load_scene("fu2019").distortion()
    assert cancel(interop.dynamics(interop.to_control(d.perceived)) - MSD * FILTER) == 0
    assert cancel(interop.dynamics(interop.to_scipy(d.distortion)) - MSD * (FILTER - 1)) == 0
    omega = 7.5
    assert abs(interop.to_control(d.distortion)(1j * omega).real - float(d.real.subs(hs.omega, omega))) < 1e-11


@pytest.mark.parametrize("export", EXPORTS, ids=lambda f: f.__name__)
@pytest.mark.parametrize(
    ("system", "message"),
    [
        (effects.delay("5 ms"), r"exp\(-s/200\) is not rational in s.*pade-delay"),
        (environments.spring_pot(80, "0.25"), "not rational in s"),
        (hs.load_scene("stick-with-friction").distortion().perceived, "I"),
    ],
)
def test_a_delay_a_fraction_of_a_derivative_and_friction_cannot_be_exported(system, message, export):
    with pytest.raises(hs.SceneError, match=message):
        export(system)


@pytest.mark.parametrize("export", [interop.to_control, interop.to_scipy], ids=lambda f: f.__name__)
def test_symbols_must_have_values_before_numbers_are_exported(export):
    with pytest.raises(hs.SceneError, match="k, m are symbols: give values"):
        export(k / (m * s**2 + k))


def test_a_delay_that_cancels_does_not_stand_in_the_way():
    assert cancel(interop.dynamics(interop.to_control(exp(-s) / (s * exp(-s) + exp(-s)))) - 1 / (s + 1)) == 0
