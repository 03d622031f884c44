"""Closed forms of a distortion against complex numbers: every quantity, moduli as sums of squares, and what is left out."""

from __future__ import annotations

import cmath
import random
from functools import cache
from typing import Any

import pytest
from sympy import Expr, I, Mul, Rational, Symbol, lambdify, sqrt

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.symbols import X, omega, s
from haptisym.model.jnd import Part
from haptisym.pages.closedforms import ClosedForms, on_axis, squared_modulus
from haptisym.writing.document import Line
from haptisym.writing.plain import said

E, F = hs.environments, hs.effects
FREQUENCIES = (0.3, 1.7, 6.1, 23.0)


@cache
def compiled(form: Expr) -> Any:
    return lambdify((omega, X, Symbol("c", positive=True)), form, "mpmath")


@cache
def rows_of(name: str) -> list[Line]:
    return ClosedForms(SCENES[name][0]).all()


def number(form: Expr, w: float) -> complex:
    return complex(compiled(form)(w, 2.5, 0.125))


def quotient(pick: random.Random) -> Expr:
    """Of products of small polynomials, some of them squared, some with a number in front or below."""

    def factor() -> Expr:
        kind = pick.choice(
            [s, s + pick.randint(1, 5), s**2 + pick.randint(1, 9), s**2 + pick.randint(1, 4) * s + 7, s - 2]
        )
        return kind ** pick.choice([1, 1, 2])

    above = Mul(*(factor() for _ in range(pick.randint(0, 2))))
    below = Mul(*(factor() for _ in range(pick.randint(0, 2))))
    return Rational(pick.choice([1, -3, 5]), pick.choice([1, 4])) * (above + pick.choice([0, 1])) / below


@pytest.mark.parametrize("seed", range(20))
def test_parts_and_moduli_of_a_quotient_have_their_values_on_the_imaginary_axis(seed: int) -> None:
    form = quotient(random.Random(seed))
    if form == 0:
        return
    function = Ring().convert(form)
    true = lambdify(s, form, "mpmath")
    for w in FREQUENCIES:
        at = complex(true(1j * w))
        close = 1e-11 * (1 + abs(at))
        assert abs(number(on_axis(function, Part.REAL), w) - at.real) < close
        assert abs(number(on_axis(function, Part.IMAG), w) - at.imag) < close
        assert abs(number(squared_modulus(function), w) - abs(at) ** 2) < 1e-11 * (1 + abs(at) ** 2)


@pytest.mark.parametrize(
    ("form", "real", "square"),
    [
        (1 / (s**2 + s + 4), "(4 - omega**2)/(omega**2 + (4 - omega**2)**2)", "1/(omega**2 + (4 - omega**2)**2)"),
        (s**2 + s + 4, "4 - omega**2", "omega**2 + (4 - omega**2)**2"),
        ((s + 1) ** 2 * (s + 3), None, "(omega**2 + 1)**2*(omega**2 + 9)"),
        (2 * (s + 1), "2", "4*omega**2 + 4"),
        (2 * s**2 + 2 * s + 8, None, "4*omega**2 + (8 - 2*omega**2)**2"),
        ((s + 1) / 2, "1/2", None),
        (1 / (s + 1) ** 2, None, "(omega**2 + 1)**(-2)"),
        (s / (s * (s + 2)), "2/(omega**2 + 4)", "1/(omega**2 + 4)"),
    ],
)
def test_denominators_are_sums_of_two_squares_for_each_factor(form: Expr, real: str | None, square: str | None) -> None:
    function = Ring().convert(form)
    for told, shown in ((real, on_axis(function, Part.REAL)), (square, squared_modulus(function))):
        assert told is None or str(shown) == told


SCENES: dict[str, tuple[Any, Any, Any]] = {
    "lag": (hs.distort(E.mass_spring_damper(2, 3, 100), F.first_order_lag(20)), lambda z: 2 * z * z + 3 * z + 100, lambda z: 20 / (z + 20)),
    "delay": (hs.distort(E.maxwell(100, 5), F.delay("10 ms")), lambda z: 500 * z / (5 * z + 100), lambda z: cmath.exp(-0.01 * z)),
    "two": (
        hs.distort(E.kelvin_voigt(100, 3), F.first_order_lag(20), F.first_order_lag(20)), lambda z: 100 + 3 * z, lambda z: 400 / (z + 20) ** 2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_every_quantity_of_a_distortion_has_its_value(name: str) -> None:
    _, env, gain = SCENES[name]
    rows = {said(x.left): x for x in rows_of(name)}
    assert len(rows) == len(rows_of(name))
    for w in FREQUENCIES:
        h = complex(env(1j * w))
        p = h * complex(gain(1j * w))
        change = p - h
        true: dict[str, complex] = {
            "Re dH": change.real, "Im dH": change.imag, "|H_env|^2": abs(h) ** 2, "r_r": abs(change.real) / abs(h), "r_i": abs(change.imag) / abs(h),
            "Re(dH/H_env)": (change / h).real, "Im(dH/H_env)": (change / h).imag,
        }  # fmt: skip
        for system, own in (("env", h), ("perc", p)):
            true |= {
                f"k_{system}": own.real, f"m_{system}": -own.real / w**2, f"b_{system}": own.imag / w, f"F_si_{system}": 2.5 * own.real,
                f"F_d_{system}": 2.5j * own.imag,
            }  # fmt: skip
        true |= {f"Δ_jnd {key}": 0.125 * abs(h) / w**n for n, key in enumerate("kbm")}
        found = {
            key: number(x.value, w) for key, x in rows.items() if not key.startswith("H_") and isinstance(x.value, Expr)
        }
        named = {key.replace("(ωj)", "").replace("(ω)", ""): x for key, x in found.items()}
        aliases = {
            "jnd k": "Δ_jnd k",
            "jnd b": "Δ_jnd b",
            "jnd m": "Δ_jnd m",
            "Delta_jnd k": "Δ_jnd k",
            "Delta_jnd b": "Δ_jnd b",
            "Delta_jnd m": "Δ_jnd m",
        }
        named = {aliases.get(key, key): x for key, x in named.items()}
        assert set(named) == set(true)
        for key, value in true.items():
            assert abs(named[key] - value) <= 1e-10 * (1 + abs(value)), (key, w)


def test_what_has_a_meaning_may_be_left_out_and_dynamics_may_not() -> None:
    forms = ClosedForms(SCENES["lag"][0])
    optional = {said(x.left).replace("(ωj)", "").replace("(ω)", "") for x in rows_of("lag") if x.optional}
    assert {"r_r", "r_i", "m_env", "m_perc", "F_si_env", "F_d_env", "F_si_perc", "F_d_perc"} <= optional
    assert len(optional) == 8 + 3
    for rows in (forms.dynamics(), forms.difference(), forms.relative()):
        assert not any(x.optional for x in rows)
    meant = [x for x in rows_of("lag") if x.meaning is not None]
    assert {said(x.left).replace("(ω)", "") for x in forms.ratios()} <= {said(x.left).replace("(ω)", "") for x in meant}


def test_a_ratio_is_the_modulus_of_a_part_over_that_of_the_environment() -> None:
    d = SCENES["lag"][0]
    [real, imag] = ClosedForms(d).ratios()
    for row, part in ((real, Part.REAL), (imag, Part.IMAG)):
        assert isinstance(row.value, Expr)
        assert row.value.has(sqrt(squared_modulus(d.env))) or number(row.value, 3.0).real >= 0
        for w in FREQUENCIES:
            assert number(row.value, w).real == pytest.approx(
                abs(number(on_axis(d.difference, part), w)) / abs(number(squared_modulus(d.env), w)) ** 0.5
            )


def test_a_row_is_a_line_with_the_name_of_a_quantity() -> None:
    [env, perc] = ClosedForms(SCENES["two"][0]).dynamics()
    assert isinstance(env, Line)
    assert [said(x.left) for x in (env, perc)] == ["H_env(s)", "H_perc(s)"]
    for w in FREQUENCIES:
        assert complex(lambdify(s, env.value, "mpmath")(1j * w)) == pytest.approx(100 + 3j * w)
        assert complex(lambdify(s, perc.value, "mpmath")(1j * w)) == pytest.approx(
            (100 + 3j * w) * 400 / (1j * w + 20) ** 2
        )
    assert not any(isinstance(x.value, Expr) and x.value.has(I) for x in ClosedForms(SCENES["two"][0]).difference())
