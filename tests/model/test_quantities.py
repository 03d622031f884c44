"""Quantities: exact values, wrong dimensions, and everything that is not a number."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Expr, I, Rational, nan, oo, pi, zoo

import haptisym as hs
from haptisym.model.quantities import Dimension, MotionKind, decimal, quantity
from haptisym.model.units import _USUAL, _measured, read_unit, si_unit

EXACT: list[tuple[str, Dimension, Expr]] = [
    ("1.8 kg", Dimension.MASS, Rational(9, 5)),
    ("45 g", Dimension.MASS, Rational(45, 1000)),
    ("45 mg", Dimension.MASS, Rational(45, 10**6)),
    ("2 t", Dimension.MASS, Rational(2000)),
    ("1 lb", Dimension.MASS, Rational(45359237, 10**8)),
    ("3 kg*m^2", Dimension.MASS, Rational(3)),
    ("3 g*cm^2", Dimension.MASS, Rational(3, 10**7)),
    ("15 N*s/m", Dimension.DAMPING, Rational(15)),
    ("15 N s/m", Dimension.DAMPING, Rational(15)),
    ("15 N·s/m", Dimension.DAMPING, Rational(15)),
    ("15 N s m^-1", Dimension.DAMPING, Rational(15)),
    ("15 kg/s", Dimension.DAMPING, Rational(15)),
    ("15 N*ms/mm", Dimension.DAMPING, Rational(15)),
    ("2 N*m*s/rad", Dimension.DAMPING, Rational(2)),
    ("2 N*m*s/deg", Dimension.DAMPING, 360 / pi),
    ("2 N*m/rpm", Dimension.DAMPING, 60 / pi),
    ("100 N/m", Dimension.STIFFNESS, Rational(100)),
    ("5 kN/m", Dimension.STIFFNESS, Rational(5000)),
    ("5 N/mm", Dimension.STIFFNESS, Rational(5000)),
    ("5 N/cm", Dimension.STIFFNESS, Rational(500)),
    # 1 lbf = 0.45359237 kg * 9.80665 m/s^2 and 1 in = 0.0254 m, by definition
    ("1 lbf/in", Dimension.STIFFNESS, Rational("0.45359237") * Rational("9.80665") / Rational("0.0254")),
    ("1 lbf/ft", Dimension.STIFFNESS, Rational("0.45359237") * Rational("9.80665") / Rational("0.3048")),
    ("3 N*m/rad", Dimension.STIFFNESS, Rational(3)),
    ("1 N*m/deg", Dimension.STIFFNESS, 180 / pi),
    ("1 kgf", Dimension.FORCE, Rational("9.80665")),
    ("0.2 N*m", Dimension.FORCE, Rational(1, 5)),
    ("1 J", Dimension.FORCE, Rational(1)),
    ("5 cm", Dimension.DISPLACEMENT, Rational(1, 20)),
    ("5 µm", Dimension.DISPLACEMENT, Rational(5, 10**6)),
    ("5 um", Dimension.DISPLACEMENT, Rational(5, 10**6)),
    ("5 nm", Dimension.DISPLACEMENT, Rational(5, 10**9)),
    ("1 in", Dimension.DISPLACEMENT, Rational(254, 10**4)),
    ("180 deg", Dimension.DISPLACEMENT, pi),
    ("90 °", Dimension.DISPLACEMENT, pi / 2),
    ("0.5 rad", Dimension.DISPLACEMENT, Rational(1, 2)),
    ("80 rad/s", Dimension.FREQUENCY, Rational(80)),
    ("80 1/s", Dimension.FREQUENCY, Rational(80)),
    ("15 Hz", Dimension.FREQUENCY, 30 * pi),
    ("2 kHz", Dimension.FREQUENCY, 4000 * pi),
    ("60 rpm", Dimension.FREQUENCY, 2 * pi),
    ("90 deg/s", Dimension.FREQUENCY, pi / 2),
    ("3 rev/min", Dimension.FREQUENCY, pi / 10),
    ("5 ms", Dimension.TIME, Rational(1, 200)),
    ("7 us", Dimension.TIME, Rational(7, 10**6)),
    ("2 min", Dimension.TIME, Rational(120)),
    ("10 %", Dimension.RATIO, Rational(1, 10)),
    ("0.5", Dimension.RATIO, Rational(1, 2)),
    ("9/5 kg", Dimension.MASS, Rational(9, 5)),
    ("1/3", Dimension.RATIO, Rational(1, 3)),
    ("  2.50   kg ", Dimension.MASS, Rational(5, 2)),
    ("+.5e-3 kg", Dimension.MASS, Rational(1, 2000)),
    ("-45 g", Dimension.MASS, Rational(-45, 1000)),
    ("3 (N)/(m)", Dimension.STIFFNESS, Rational(3)),
    ("12 N*s^0.5/m", Dimension.ANY, Rational(12)),
]


@pytest.mark.parametrize(("text", "dimension", "value"), EXACT, ids=[text for text, _, _ in EXACT])
def test_units_are_read_exactly(text: str, dimension: Dimension, value: Expr) -> None:
    assert quantity(text, dimension).value == value


PREFIXES = {"T": 12, "G": 9, "M": 6, "k": 3, "h": 2, "da": 1, "d": -1, "c": -2, "m": -3, "µ": -6, "u": -6, "n": -9}


@pytest.mark.parametrize("prefix", PREFIXES)
@pytest.mark.parametrize(("unit", "dimension"), [("N", Dimension.FORCE), ("g", Dimension.ANY), ("s", Dimension.TIME)])
def test_prefixes_are_powers_of_ten(prefix: str, unit: str, dimension: Dimension) -> None:
    plain = quantity(f"7 {unit}", dimension).value
    assert quantity(f"7 {prefix}{unit}", dimension).value == plain * Rational(10) ** PREFIXES[prefix]


@pytest.mark.parametrize(
    ("text", "dimension"),
    [
        ("15 N", Dimension.STIFFNESS), ("15 N*s/m", Dimension.STIFFNESS), ("15 N/m", Dimension.DAMPING),
        ("15 kg", Dimension.TIME), ("15 s", Dimension.FREQUENCY), ("15 Hz", Dimension.TIME), ("15 m", Dimension.MASS),
        ("15 N/m", Dimension.RATIO), ("15 kg*m", Dimension.MASS), ("15 rad/s^2", Dimension.FREQUENCY),
        ("15 kg*m^3", Dimension.MASS), ("15 N*m^2/rad", Dimension.STIFFNESS), ("15 s^2", Dimension.TIME),
    ],
)  # fmt: skip
def test_a_wrong_dimension_is_refused_with_the_unit_expected(text: str, dimension: Dimension) -> None:
    with pytest.raises(hs.SceneError) as refused:
        quantity(text, dimension)
    assert text in str(refused.value)
    assert "expected" in str(refused.value)
    for unit in {*dimension.value} - {"1"}:
        assert unit in str(refused.value)


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "kg", "nan", "NaN", "inf", "-inf kg", "infinity", "1,5 kg", "1.8.2 kg", "--1 kg", "1 2 kg", "1e kg",
        "0x10 kg", "1_000 kg", "1/0 kg", "1/2/3 kg", "1 kg kg^-1 kg lb/", "1 unknown", "1 kg)", "1 (kg", "1 kg^",
        "1 kg^kg", "1 kg - m", "1 kg; import os", "1 __import__('os')", "1 kg\x00", "1 µ", "1 kilo", "1 degC",
        "1 Ns/m", "1 KG", "1 2^3 kg", "j kg", "1j kg", "e kg", "1e400 kg", "1e-400 kg", "1e99999999999999999999 kg",
        "9" * 1000 + " kg", "1/" + "9" * 1000 + " kg", "1 " + "(" * 500 + "kg" + ")" * 500, "1 kg^99999999999",
        "1 " + "kg*" * 5000 + "kg", "½ kg",
    ],
)  # fmt: skip
def test_what_is_not_a_finite_number_with_a_known_unit_is_refused(text: str) -> None:
    with pytest.raises(hs.SceneError) as refused:
        quantity(text, Dimension.MASS)
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize(
    "given_value", [float("nan"), float("inf"), -float("inf"), Decimal("NaN"), Decimal("Infinity"), oo, -oo, zoo, I,
                    True, False, None, [1], {}, object(), b"1 kg", 1j],
)  # fmt: skip
def test_what_is_not_a_real_number_is_refused(given_value: object) -> None:
    with pytest.raises(hs.SceneError):
        quantity(given_value, Dimension.MASS)  # type: ignore[arg-type]


def test_sympy_s_nan_is_refused() -> None:
    with pytest.raises(hs.SceneError):
        quantity(nan, Dimension.MASS)


def test_a_sum_of_different_units_is_refused() -> None:
    with pytest.raises(hs.SceneError):
        quantity("1 kg + kg^2", Dimension.MASS)


@pytest.mark.parametrize("text", ["1 kg+kg", "3 kg-kg", "1 -kg", "1 (1+1)*kg"])
def test_a_unit_is_a_product_of_powers(text: str) -> None:
    with pytest.raises(hs.SceneError):
        quantity(text, Dimension.MASS)


@pytest.mark.parametrize(
    ("text", "dimension"), [("4 kg^0.5*kg^0.5", Dimension.MASS), ("4 rad^0.5*rad^0.5/s", Dimension.FREQUENCY)]
)
def test_fractional_powers_of_units_whose_factor_is_1_are_exact(text: str, dimension: Dimension) -> None:
    assert quantity(text, dimension).value == 4


@pytest.mark.parametrize(
    ("text", "dimension"), [("1 lb^0.5*lb^0.5", Dimension.MASS), ("4 Hz^0.5*s^-0.5", Dimension.FREQUENCY)]
)
def test_fractional_powers_of_units_with_other_factors_are_refused(text: str, dimension: Dimension) -> None:
    with pytest.raises(hs.SceneError, match="may have fractional powers"):
        quantity(text, dimension)


@given(st.integers(-(10**12), 10**12), st.integers(0, 12))
def test_decimal_texts_are_read_exactly(digits: int, places: int) -> None:
    text = f"{Decimal(digits).scaleb(-places):f}"
    assert decimal(text) == Rational(digits, 10**places)
    assert quantity(f"{text} N", Dimension.FORCE).value == Rational(digits, 10**places)


@given(st.integers(-999, 999), st.integers(-300, 300))
def test_exponents_of_ten_are_read_exactly(digits: int, exponent: int) -> None:
    assert decimal(f"{digits}e{exponent}") == digits * Rational(10) ** exponent


@given(st.floats(-1e200, 1e200).filter(lambda x: not 0 < abs(x) < 1e-200))
def test_a_float_means_its_shortest_decimal_text(x: float) -> None:
    assert quantity(x, Dimension.RATIO).value == Rational(Fraction(Decimal(repr(x))))


def test_numbers_of_every_exact_kind_are_read_exactly() -> None:
    for one in (3, Fraction(3), Decimal(3), 3.0, "3", "3.000", sympy.Integer(3), sympy.Float(3.0)):
        assert quantity(one, Dimension.MASS).value == 3  # type: ignore[arg-type]
    assert quantity(0.1, Dimension.RATIO).value == Rational(1, 10)
    assert quantity(sympy.Float(0.1), Dimension.RATIO).value == Rational(1, 10)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.longdouble, np.int8, np.int64, np.uint16])
def test_scalars_of_numpy_are_the_numbers_that_they_show(kind: type) -> None:
    """Of ``np.arange(100, 500, 100)`` each was refused as no number."""
    shown = "12" if issubclass(kind, np.integer) else "1.8"
    assert quantity(kind(shown), Dimension.STIFFNESS).value == decimal(shown)
    with pytest.raises(hs.SceneError, match="not a number"):
        quantity(np.bool_(1), Dimension.STIFFNESS)


def test_a_unit_tells_the_motion_and_a_bare_number_does_not() -> None:
    assert quantity("1 kg", Dimension.MASS).motion is MotionKind.TRANSLATION
    assert quantity("1 kg*m^2", Dimension.MASS).motion is MotionKind.ROTATION
    assert quantity("1 N/m", Dimension.STIFFNESS).motion is MotionKind.TRANSLATION
    assert quantity("1 N*m/rad", Dimension.STIFFNESS).motion is MotionKind.ROTATION
    assert quantity("1 mm", Dimension.DISPLACEMENT).motion is MotionKind.TRANSLATION
    assert quantity("1 deg", Dimension.DISPLACEMENT).motion is MotionKind.ROTATION
    assert quantity("1", Dimension.MASS).motion is None
    assert quantity("1 Hz", Dimension.FREQUENCY).motion is None
    assert quantity(1, Dimension.STIFFNESS).motion is None


def test_thresholds_are_positive_fractions() -> None:
    assert hs.Threshold.of("12 %", "1/3") == hs.Threshold(Rational(3, 25), Rational(1, 3))
    assert hs.Threshold.of(0.1) == hs.Threshold()
    for bad in (0, -1, "0.1 m", "nan", float("inf"), True, None):
        with pytest.raises(hs.SceneError, match="real"):
            hs.Threshold.of(bad)  # type: ignore[arg-type]
    with pytest.raises(hs.SceneError, match="imag"):
        hs.Threshold.of("0.1", 0)


@pytest.mark.parametrize("unit", sorted(_USUAL))
def test_the_units_that_are_known_by_heart_are_those_of_pint(unit: str) -> None:
    factor, exponents = _measured(unit, unit, unit, "")
    assert _USUAL[unit] == (factor, exponents)


@given(st.dictionaries(st.sampled_from(["mass", "length", "time"]), st.integers(-2, 2).filter(bool)))
def test_the_si_unit_of_base_dimensions_is_read_as_just_these(powers: dict[str, int]) -> None:
    exponents = tuple(sorted((base, Fraction(power)) for base, power in powers.items()))
    name = si_unit(exponents)
    assert read_unit(name, name, "") == (1, dict(exponents)) if powers else name == ""


@pytest.mark.parametrize(
    ("given_unit", "told"),
    [
        ("ms", "s"),
        ("g", "kg"),
        ("Hz", "rad/s"),
        ("mN*mm*s", "N*m*s"),
        ("kN/cm", "N/m"),
        ("N*s^2/mm", "kg"),
        ("N*s/m^3", "N*s/m^3"),
    ],
)
def test_the_number_of_a_formula_has_the_si_unit_of_what_was_given(given_unit: str, told: str) -> None:
    scene = hs.Scene(hs.environments.expression("q*s", parameters={"q": f"3 {given_unit}"}))
    assert scene.knobs["q"].unit == told
    assert scene.parameters[0].stated().endswith(f" {told}")
    assert hs.Scene(hs.environments.expression("q*s", parameters={"q": "3"})).parameters[0].stated() == "q = 3"


def test_dimensions_with_fractions_or_of_no_base_unit_have_no_si_unit() -> None:
    assert si_unit((("mass", Fraction(1)), ("time", Fraction(-3, 2)))) == ""
    assert si_unit((("printing_unit", Fraction(1)),)) == ""
    assert si_unit((("length", Fraction(10)),)) == ""
