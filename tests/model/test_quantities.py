"""Numbers with units, ranges and formulas: exact values, wrong dimensions, and everything that is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import pint
import pytest
import sympy
from hypothesis import assume, example, given
from hypothesis import strategies as st
from refusals import refusal
from sympy import Eq, Expr, I, Rational, Symbol, nan, oo, pi, sqrt, true, zoo

import haptisym as hs
from haptisym.environments import expression
from haptisym.kernel.rings import s as symbol
from haptisym.model.parameters import Rule, ranged, spread
from haptisym.model.quantities import Dimension, MotionKind, decimal, evaluate, quantity, read_unit, si_unit

K = Dimension.STIFFNESS
FRACTIONS = st.fractions(-50, 50, max_denominator=20)


def exact(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


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
    ("8 Nm/rad", Dimension.STIFFNESS, Rational(8)),
    ("0.4 Nms/rad", Dimension.DAMPING, Rational(2, 5)),
    ("0.05 kgm^2", Dimension.MASS, Rational(1, 20)),
    ("2 kg.m2", Dimension.MASS, Rational(2)),
    ("3 gcm²", Dimension.MASS, Rational(3, 10**7)),
    ("1 N-m/rad", Dimension.STIFFNESS, Rational(1)),
    ("1 N.m.rad-1", Dimension.STIFFNESS, Rational(1)),
    ("140 mNm/deg", Dimension.STIFFNESS, Rational(126, 5) / pi),
    ("7 Nmm/rad", Dimension.STIFFNESS, Rational(7, 1000)),
    ("2 kNs/m", Dimension.DAMPING, Rational(2000)),
    ("1 lbfs/in", Dimension.DAMPING, Rational("4.4482216152605") / Rational("0.0254")),
    ("1 ozf-in", Dimension.FORCE, Rational("4.4482216152605") / 16 * Rational("0.0254")),
    ("3 ms", Dimension.TIME, Rational(3, 1000)),  # not metres times seconds
]


@pytest.mark.parametrize(("text", "dimension", "value"), EXACT, ids=[text for text, _, _ in EXACT])
def test_units_are_read_exactly(text: str, dimension: Dimension, value: Expr) -> None:
    assert quantity(text, dimension).value == value


@pytest.mark.parametrize(
    ("text", "dimension", "told"),
    [
        ("1 N*m/dge", Dimension.STIFFNESS, 'did you mean "N*m/deg"?'),  # not N*m/rad, which is 57 times less
        ("2 radd/s", Dimension.FREQUENCY, 'did you mean "rad/s"?'),
        ("2 kg*m^2/foo", Dimension.MASS, 'unknown unit "kg*m^2/foo". Masses'),
    ],
)
def test_a_unit_that_is_proposed_has_the_size_of_what_was_written(text: str, dimension: Dimension, told: str) -> None:
    assert told in refusal(quantity, text, dimension)


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
    for unit in {*dimension.value} - {"1"}:
        assert unit in str(refused.value)


NO_NUMBERS: list[Any] = [
    "", " ", "kg", "nan", "NaN", "inf", "-inf kg", "infinity", "1,5 kg", "1.8.2 kg", "--1 kg", "1 2 kg", "1e kg",
    "0x10 kg", "1_000 kg", "1/0 kg", "1/2/3 kg", "1 kg kg^-1 kg lb/", "1 unknown", "1 kg)", "1 (kg", "1 kg^",
    "1 kg^kg", "1 kg - m", "1 kg+kg", "3 kg-kg", "1 -kg", "1 (1+1)*kg", "1 kg; import os", "1 __import__('os')", "1 kg\x00", "1 µ", "1 kilo", "1 degC",
    "1 Ns/m", "1 KG", "1 2^3 kg", "j kg", "1j kg", "e kg", "1e301 kg", "1e-301 kg", "1e300 t", "1e-299 mg", "1e99999999999999999999 kg", "1" * 201,
    "9" * 1000 + " kg", "1/" + "9" * 1000 + " kg", "1 " + "(" * 500 + "kg" + ")" * 500, "1 kg^99999999999",
    "1 " + "kg*" * 5000 + "kg", "½ kg", "1 lb^0.5*lb^0.5",
    float("nan"), float("inf"), -float("inf"), Decimal("NaN"), Decimal("Infinity"), oo, -oo, zoo, nan, I, sqrt(2), 2**pi, pi ** Rational(1, 2),
    True, False, np.bool_(1), None, [1], {}, object(), b"1 kg", 1j,
]  # fmt: skip


@pytest.mark.parametrize("given_value", NO_NUMBERS, ids=lambda x: repr(x)[:20])
def test_what_is_not_a_finite_real_number_with_a_known_unit_is_refused(given_value: Any) -> None:
    assert 0 < len(refusal(quantity, given_value, Dimension.MASS)) < 400


@pytest.mark.parametrize(
    "text", ["1" * 200, "1/" + "3" * 200, "1e300", "1e-300", "1e0300", "0/7", "1e296 kN/m", "0 kN/m", " 3 N/m "]
)
def test_a_number_may_be_as_long_and_as_large_as_a_float_can_show(text: str) -> None:
    assert not refusal(quantity, text, K)


@pytest.mark.parametrize(
    ("text", "dimension"), [("4 kg^0.5*kg^0.5", Dimension.MASS), ("4 rad^0.5*rad^0.5/s", Dimension.FREQUENCY)]
)
def test_fractional_powers_of_units_whose_factor_is_1_are_exact(text: str, dimension: Dimension) -> None:
    assert quantity(text, dimension).value == 4


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
    for tenth in (0.1, sympy.Float(0.1), np.float64(0.1)):
        assert quantity(tenth, Dimension.RATIO).value == Rational(1, 10)
    for given_ in (pi, 2 / pi + 1, pi**-3, Rational(1, 3) * pi):
        assert quantity(given_, K).value == given_
    assert quantity(0.1 * pi, K).value == pi / 10


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.longdouble, np.int8, np.int64, np.uint16])
def test_scalars_of_numpy_are_the_numbers_that_they_show(kind: type) -> None:
    shown = "12" if issubclass(kind, np.integer) else "1.8"
    assert quantity(kind(shown), Dimension.STIFFNESS).value == decimal(shown)


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


@cache
def registry() -> pint.UnitRegistry[Any]:
    return pint.UnitRegistry()


UNITS = [
    "%", "rad", "kg", "g", "m", "mm", "s", "ms", "rad/s", "N", "N/m", "N*s/m", "N*m", "N*m/rad", "N*m*s/rad", "kg*m^2", "mN*mm*s", "kN/cm", "lbf/in", "rpm",
    "lb", "lbs", "oz", "slug", "in", "ft", "deg", "°", "deg/s", "kgf", "kgf/mm", "lbf", "ozf", "lbf*s/ft", "ozf*in/deg", "N/mm", "t", "min", "J",
    "newton", "kilonewtons", "pound", "pounds", "ounce", "inch", "foot", "feet", "degree", "radians", "microsecond", "grams", "tonne", "percent",
]  # fmt: skip


@pytest.mark.dear("%", "rad")
@pytest.mark.parametrize("unit", UNITS)
def test_units_are_those_of_pint(unit: str) -> None:
    own = registry().Quantity(1.0, unit.replace("^", "**").replace("%", "percent")).to_base_units()
    powers = {name.strip("[]"): power for name, power in own.dimensionality.items()}
    factor, exponents = read_unit(unit, unit, "")
    assert float(factor) == pytest.approx(own.magnitude, rel=1e-15)
    assert {name: float(x) for name, x in exponents.items()} == powers


@example({"time": -9})
@example({"time": -10})
@example({"length": 10})
@example({"mass": 5})
@example({"mass": -5})
@given(st.dictionaries(st.sampled_from(["mass", "length", "time"]), st.integers(-12, 12).filter(bool)))
def test_the_si_unit_of_base_dimensions_is_read_as_just_these_or_would_have_powers_of_two_digits(
    powers: dict[str, int],
) -> None:
    exponents = tuple(sorted((base, Fraction(power)) for base, power in powers.items()))
    name = si_unit(exponents)
    newtons, length, time = (powers.get(x, 0) for x in ("mass", "length", "time"))  # kg^n is N^n s^2n/m^n
    if powers and max(map(abs, (newtons, length - newtons, time + 2 * newtons))) <= 9:
        assert read_unit(name, name, "") == (1, dict(exponents))
    else:
        assert name == ""


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


# --- ranges ----------------------------------------------------------------------------------------------------------


@given(FRACTIONS, st.fractions(0, 50, max_denominator=20), st.sampled_from(["+-", "+/-", "±"]))
def test_a_range_lies_around_its_centre_by_its_deviation_or_its_share(c: Fraction, d: Fraction, sign: str) -> None:
    found = ranged(f"{c} N/m {sign} {d} N/m", K)
    assert found.nominal.value == exact(c)
    assert found.interval == (None if d == 0 else (exact(c - d), exact(c + d)))
    assert ranged(f"{c}{sign}{d}", K).interval == found.interval
    assume(c != 0)
    off = abs(c) * d / 100
    assert ranged(f"{c} N/m {sign} {d} %", K).interval == (None if d == 0 else (exact(c - off), exact(c + off)))


@given(st.lists(FRACTIONS, min_size=2, max_size=3))
def test_a_list_is_a_range_where_it_rises(row: list[Fraction]) -> None:
    told = [f"{x} N/m" for x in row]
    if row != sorted(row):
        assert "must not be above" in refusal(ranged, told, K) or "must lie between" in refusal(ranged, told, K)
        return
    found = ranged(told, K)
    middle = row[1] if len(row) == 3 else (row[0] + row[1]) / 2
    assert (found.nominal.value, found.nominal.motion) == (exact(middle), MotionKind.TRANSLATION)
    assert found.interval == (None if row[0] == row[-1] else (exact(row[0]), exact(row[-1])))


@given(FRACTIONS, FRACTIONS, FRACTIONS)
def test_a_range_is_told_by_its_per_cent_only_where_it_is_even_and_leaves_out_zero(
    a: Fraction, b: Fraction, c: Fraction
) -> None:
    low, nominal, high = sorted([a, b, c])
    assume(low < high)
    for middle in (nominal, (low + high) / 2):
        even = middle - low == high - middle and low * high > 0
        words = (
            f"by {float(50 * (high - low) / abs(middle)):.4g} %"
            if even
            else f"from {float(low):.6g} to {float(high):.6g}"
        )
        assert spread(exact(middle), (exact(low), exact(high))) == words


@pytest.mark.parametrize(
    ("given_", "told"),
    [
        ("0 N/m +- 5 %", "percentage of zero"), ("0 N/m +- 5 N/m", ""), ("3 N/m +- -1 N/m", "must be >= 0"), ("3 N/m +- -5 %", "must be >= 0"),
        ("3 N/m +- 1", "units of the same kind"), ("3 +- 1 N/m", "units of the same kind"), ("3 +- 1 +- 1", "is not a range"), ("+- 1", "is not a range"),
        ("3 +-", "is not a range"), ("3 N/m +- 2 m", "is not a stiffness"), ([1], "is not a range"), ([1, 2, 3, 4], "or three"), ([2, 1], "must not be above"),
        ([1, 3, 2], "must lie between"), ([1, "2 N/m"], "units of the same kind"), (["1 N/m", 2, "3 N/m"], "same kind"), (["1 N/m", "2 N*m/rad"], "same kind"),
        ([1, Symbol("x")], "must be numbers"), ([1, Symbol("x"), 2], "must be numbers"), ([1, 1], ""), ([1, 1, 2], ""), ([1, 2, 2], ""),
    ],
)  # fmt: skip
def test_what_is_no_range_is_told(given_: Any, told: str) -> None:
    said = refusal(ranged, given_, K)
    assert told in said
    assert bool(told) == bool(said)


# --- parameters ------------------------------------------------------------------------------------------------------


def test_a_rule_allows_the_numbers_that_it_names_and_of_two_the_stricter_holds() -> None:
    values = [Rational(x) for x in ("-1", "-1/9", "0", "1/9", "8/9", "1", "3/2", "10", "11", "100", "101")]
    witness = {
        Rule.POSITIVE: lambda x: x > 0, Rule.NONNEGATIVE: lambda x: x >= 0, Rule.ANY: lambda _: True, Rule.FRACTION: lambda x: 0 < x < 1,
        Rule.ORDER: lambda x: x.q == 1 and 1 <= x <= 10, Rule.WHOLE: lambda x: x.q == 1 and 0 <= x <= 100,
    }  # fmt: skip
    symbol = Symbol("k")
    for rule, allows in witness.items():
        assert [rule.allows(x) for x in values] == [allows(x) for x in values]
        assert rule.allows(symbol) == (rule not in (Rule.ORDER, Rule.WHOLE))
        for other in witness:
            both = rule.and_also(other)
            assert both in (rule, other)
            assert rule.and_also(rule) is rule
            assert both is other.and_also(rule)
            if {rule, other} <= {Rule.ANY, Rule.NONNEGATIVE, Rule.POSITIVE, Rule.FRACTION}:
                assert [both.allows(x) for x in values] == [allows(x) and witness[other](x) for x in values]


def test_parameters_are_stated_with_their_units_and_ranges() -> None:
    told = {
        "m = 9/5 kg": hs.environments.mass_spring_damper(m="1.8 kg"),
        "m = 2 kg·m²": hs.environments.mass_spring_damper(m="2 kg*m^2"),
        "k = 3 N/m, from 2 to 4 N/m": hs.environments.mass_spring_damper(k=[2, 4]),
        "zeta = 1/2": hs.effects.second_order_lowpass(80, 0.5),
        "tau": hs.effects.delay(hs.symbols("tau")),
        "tau = x": hs.effects.delay(Symbol("x", positive=True)),
    }
    for words, element in told.items():
        stated = [p.stated().replace("kg*m^2", "kg·m²") for p in element.parameters]
        assert any(words == x or (words == "tau = x" and x.startswith("tau = x")) for x in stated), stated


# --- formulas --------------------------------------------------------------------------------------------------------

NAMES = {"x": Fraction(3), "y": Fraction(-2, 7), "s_1": Fraction(5, 2)}


def value(text: str) -> Fraction:
    return evaluate(text, number=Fraction, name=NAMES.__getitem__)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2*3", 7), ("(1 + 2)*3", 9), ("2*x^2 - (x + 1)/4", 17), ("8/4/2", 1), ("8/(4/2)", 4), ("8 - 4 - 2", 2),
        ("8 - (4 - 2)", 6), ("-x^2", -9), ("(-x)^2", 9), ("2^-1", Fraction(1, 2)), ("2^(-2)", Fraction(1, 4)),
        ("2**3", 8), ("2 ** +3", 8), ("-2*-3", 6), ("2*-x^2", -18), ("--x", 3), ("+-+x", -3), ("1.5e2", 150),
        (".5", Fraction(1, 2)), ("2.", 2), ("1e-3", Fraction(1, 1000)), ("s_1*2", 5), ("x\n + \t 1", 4), ("x^0", 1),
        ("0^0", 1), ("6/2*3", 9), ("2*3^2", 18), ("(2*3)^2", 36), ("-1^2", -1), ("((((x))))", 3), ("1 - -1", 2),
        ("x^1.0", 3),
    ],
)  # fmt: skip
def test_formulas_mean_what_they_say(text: str, expected: Fraction | int) -> None:
    assert value(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "1 +", "* 1", "1 1", "2x", "x y", "(1", "1)", "()", "1 + )", "x^", "x^y", "x^x", "x^(1+1)", "x^^2",
        "x***2", "2^3^2", "x**2**2", "1..2", "1e", "1e+", "x.y", "x[0]", "x(1)", "sin(x)", "x, y", "x; y", "x = 1",
        "x == 1", "x != 1", "x < 1", "x > 1", "x % 2.", "x // 2", "x & 1", "x | 1", "~x", "!x", "'x'", '"x"',
        "lambda: 0", "__import__('os')", "__import__", "().__class__", "x.__class__", "exec", "eval(1)", "{}", "[]",
        "x if x else y", "not x", "x@y", "$x", "#x", "x\\", "x?", "`x`", "x\x00", "½", "x²", "√x", "π", "∞", "nan",
        "inf", "oo", "zoo", "True", "None", "unknown", "1/0", "x/(x - 3)", "0^-1", "(x - 3)^(-2)", "1j", "0x1", "1_0",
        "x‐1", "x−1", "x×2", "１＋１", "\u202e1", "x\u00a0\u200by",
    ],
)  # fmt: skip
def test_what_is_not_in_the_grammar_is_refused(text: str) -> None:
    with pytest.raises(hs.ExpressionError):
        value(text)


TOO_MUCH = [
    "x^100000", "x^999999999999999999999", "10^10^10", "(10^10)^10^10", "9^9999999", "(((x^9)^9)^9)^9", "((s^50)^50)^50",
    "9^999*9^999*9^999", "(" * 1000 + "x" + ")" * 1000, "-" * 3000 + "x", "+" * 3000 + "x", "(-" * 100 + "x" + ")" * 100, "x" * 5000, "1" * 5000,
    "*".join(["x"] * 100), "+".join(["1"] * 3000), "(x+1)^60*(x+1)^60", "x^-61", "1e9999999999", "x^1e9", "x^0.0000000000000001", "((1+x)^30)^3",
    "x^" * 1000 + "2", "(" * 61 + "x" + ")" * 61, "+".join([f"{i}{'7' * 180}*s^{i}" for i in range(12)]), "((9^999)^999)^999",
]  # fmt: skip


@pytest.mark.parametrize("text", TOO_MUCH, ids=range(len(TOO_MUCH)))
def test_what_is_too_large_or_too_deep_is_refused(text: str) -> None:
    assert 0 < len(refusal(expression, text, parameters={"x": 1})) < 400


LIMITS: dict[str, bool] = {
    "x^(1/99)": True, "x^(1/100)": False, "x^(100/99)": False, "x^0.1234567890": True, "x^0.12345678901": False, "x^1e3": False, "x^(1/0)": False, "x^(1.5/2)": False,
    "x^1/100": True, "x^(2+1)": False, "x^(-2)": True, "x^(+2)": True, "x^60": True, "x^61": False, "x^30*x^30": True, "x^30*x^31": False, "x^30/x^31": False,
    "x^60+x^60": True, "x^(-61)": False, "x^59.5": True, "x^60.5": False, "(x+1)^60": True, "(x*x)^30": True, "(x*x)^31": False, "2^61": True,
    "1/(x-x)": False, "1" * 2000: True, "1" * 2000 + "*1": False, "1" * 1000 + "+" + "1" * 1000: True, "1" * 1000 + "-" + "1" * 1001: False, "10^1000": True,
    "10^1001": False, "x" + " " * 3999: True, "x" + " " * 4000: False, "-" * 60 + "x": True, "-" * 61 + "x": False, "(" * 60 + "x" + ")" * 60: True,
}  # fmt: skip


@pytest.mark.parametrize("text", LIMITS, ids=range(len(LIMITS)))
def test_a_formula_may_go_up_to_its_limits(text: str) -> None:
    assert (refusal(evaluate, text, number=Fraction, name={"x": Fraction(1)}.__getitem__) == "") is LIMITS[text]


@pytest.mark.parametrize(
    ("text", "told", "at"),
    [
        ("x^2^3", "needs parentheses", 3), ("2*exp(x)", 'model = "delay"', 2), ("2*exq(x)", 'write "exq*("', 2), ("sqrt(x)", "s^0.5", 0),
        ("1+cosh(x)", "wave-variables", 2), ("x(2)", 'write "x*("', 0), ("e^x", 'model = "delay"', 0), ("x^y", "must be a number", 2), ("x^(1/100)", "up to 99", 3),
        ("x^(2", 'expected ")"', 4), ("x*", "found the end", 2), ("x^61", "higher than 60", 1), ("1/0", "division by zero", 1), ("x # y", "not allowed", 2),
        ("1 + x*y", 'unknown name "y"', 6), ("x" + "+x" * 40 + "+y" + "+x" * 30, 'unknown name "y"', None),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_formula_is_told_with_a_mark_under_the_place(text: str, told: str, at: int | None) -> None:
    names = {"x": Fraction(1), "e": Fraction(2)}
    message, shown, mark = refusal(evaluate, text, number=Fraction, name=names.__getitem__).split("\n")
    assert told in message
    if at is None:  # far into a formula the piece around it is shown
        assert (shown[mark.index("^")], len(shown) < 120) == ("y", True)
    else:
        assert (shown.strip(), mark.index("^") - 4) == (text, at)


def test_a_unit_has_no_sums_and_no_signs() -> None:
    def of(text: str) -> str:
        return refusal(evaluate, text, number=Fraction, name={"x": Fraction(3)}.__getitem__, sums=False)

    assert not of("x/x^-2*(x*x)^(1/1)")
    assert of("x+x")
    assert of("-x")


Formula = tuple[str, Fraction, int]
"""A text, its value, and how tightly it binds: 0 a sum, 1 a product, 2 a sign, 3 a power, 4 an atom."""

SPACE = st.sampled_from(["", " ", "  "])


def in_brackets(formula: Formula, least: int) -> str:
    text, _, binding = formula
    return text if binding >= least else f"({text})"


@st.composite
def formulas(draw: Callable[[st.SearchStrategy[object]], object], depth: int = 4) -> Formula:
    if depth == 0 or draw(st.integers(0, 4)) == 0:
        if draw(st.booleans()):
            name = draw(st.sampled_from(sorted(NAMES)))
            return str(name), NAMES[str(name)], 4
        number = draw(st.sampled_from(["0", "1", "2", "7", "0.5", "12.25", "3e-1", ".75", "4."]))
        return str(number), Fraction(str(number)), 4
    one = draw(formulas(depth - 1))
    other = draw(formulas(depth - 1))
    gap = draw(SPACE)
    kind = draw(st.sampled_from(["+", "-", "*", "/", "sign", "power"]))
    assert isinstance(one, tuple)
    assert isinstance(other, tuple)
    if kind == "+":
        return f"{one[0]}{gap}+{gap}{in_brackets(other, 1)}", one[1] + other[1], 0
    if kind == "-":
        return f"{one[0]}{gap}-{gap}{in_brackets(other, 1)}", one[1] - other[1], 0
    if kind == "*":
        return f"{in_brackets(one, 1)}{gap}*{gap}{in_brackets(other, 2)}", one[1] * other[1], 1
    if kind == "/" and other[1]:
        return f"{in_brackets(one, 1)}{gap}/{gap}{in_brackets(other, 2)}", one[1] / other[1], 1
    if kind == "sign":
        return f"-{gap}{in_brackets(one, 2)}", -one[1], 2
    exponent = draw(st.integers(-2 if one[1] else 0, 3))
    assert isinstance(exponent, int)
    sign = draw(st.sampled_from(["^", "**"]))
    return f"{in_brackets(one, 4)}{gap}{sign}{gap}{exponent}", one[1] ** exponent, 3


@given(formulas())
def test_random_formulas_have_the_value_of_fractions(formula: Formula) -> None:
    text, expected, _ = formula
    assert value(text) == expected


@given(st.text(alphabet="0123456789.+-*/^() sxe", max_size=25))
def test_any_text_is_either_a_value_or_an_error_of_ours(text: str) -> None:
    try:
        found = value(text)
    except hs.ExpressionError:
        return
    assert isinstance(found, int | float | Fraction | complex)


@given(st.text(alphabet="sλµ²½−×√π∞١ａé🙂\u202e\u200b\x00\n\t +-*/^()12.", max_size=30))
def test_any_unicode_text_as_dynamics_is_either_a_formula_or_an_error_of_ours(text: str) -> None:
    try:
        found = expression(text)
    except hs.SceneError:
        return
    assert found.H.free_symbols <= {hs.s}


DYNAMICS: dict[str, tuple[str, str]] = {
    "a zero within": ("s + 1/(1/(s - s))", "zero"), "a root of a number": ("2^0.5", "only s has fractional powers"), "a root of pi": ("pi^0.5*s", "only s has fractional powers"),
    "a root of a sum": ("m*(s + 1)^0.5", "only s has fractional powers"), "a root of a square": ("m*(s^2)^0.5", "only s has fractional powers"), "a name": ("m*s + c", "valid are s, pi, m"),
    "a delay": ("m*exp(-s*m)", "delay"), "a decimal quotient as exponent": ("m*s^(0.5/2)", "whole numbers"),
}  # fmt: skip


@pytest.mark.parametrize("name", DYNAMICS)
def test_what_is_no_dynamics_is_refused(name: str) -> None:
    text, told = DYNAMICS[name]
    assert told in refusal(lambda: hs.distort(expression(text, parameters={"m": 1})))


def test_names_of_parameters_may_not_hide_the_variable() -> None:
    for name in ("s", "omega", "pi", "j", "1x", "a b", "", "a-b"):
        with pytest.raises(hs.SceneError, match="no name for a parameter"):
            expression("s", parameters={name: 1})


@pytest.mark.parametrize("hertz", ["12", "0.5", "1e3"])
def test_pi_in_a_formula_is_exact_as_it_is_in_a_frequency_in_hertz(hertz: str) -> None:
    wall = hs.environments.mass_spring_damper(2, 15, 100)
    by_hand = hs.effects.series("1/(1 + s/(2*pi*f))", parameters={"f": f"{hertz} 1/s"})
    of_catalogue = hs.effects.first_order_lag(f"{hertz} Hz")
    assert hs.distort(wall, by_hand).perceived.equals(hs.distort(wall, of_catalogue).perceived)
    one, two = (hs.evaluate(hs.Scene(wall, (x,), (0, 40), "0.05")) for x in (by_hand, of_catalogue))
    assert [x.omega.digits(40) for x in one.crossings] == [x.omega.digits(40) for x in two.crossings]
    assert one.certified


@pytest.mark.parametrize("given", ["12 Hz", ["5 Hz", "12 Hz"]])
def test_a_value_in_hertz_beside_pi_is_refused_as_its_turns_would_count_twice(given: object) -> None:
    with pytest.raises(hs.SceneError, match="already contains 2 pi .*: leave pi out of the formula, or give f in 1/s"):
        hs.effects.series("1/(1 + s/(2*pi*f))", parameters={"f": given})
    hs.effects.series("1/(1 + s/(2*pi*f))*g/(s + g)", parameters={"f": "12 1/s", "g": "12 rad/s"})
    hs.effects.series("1/(1 + s/f)", parameters={"f": given})


def test_a_threshold_may_be_a_formula_in_hertz() -> None:
    wall, lag = hs.environments.mass_spring_damper(2, 15, 100), hs.effects.first_order_lag(30)
    found = hs.evaluate(hs.Scene(wall, (lag,), (0, 40), "0.05 + omega/(2*pi)/50")).crossings
    assert found
    for x in found:
        w = complex(0, float(x.omega))
        H, G = 2 * w**2 + 15 * w + 100, 30 / (w + 30)
        change = (G * H - H) / abs(H)
        part = change.real if x.part is hs.Part.REAL else change.imag
        assert abs(part) == pytest.approx(
            0.05 + w.imag / (2 * math.pi) / 50, abs=1e-12
        )  # of floats, far above their last digit


def test_a_formula_may_be_a_number_hold_a_power_of_pi_and_broken_powers_of_s() -> None:
    assert Eq(expression("pi^2*s").H, pi**2 * symbol) is true
    assert [expression(x).H for x in (2, 2.0, "2", "2.0")] == [2] * 4
    for text, order in (("s^(1/3)", "1/3"), ("s^(-1/3)", "-1/3"), ("s^( 3 / 12 )", "1/4"), ("s^(6/3)", "2")):
        assert expression(f"5*{text}").dynamics == 5 * symbol ** Rational(order)


POUND = Rational(45359237, 10**8) * Rational(980665, 10**5)  # N, by definition


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1 lb/in", Dimension.STIFFNESS, POUND / Rational(254, 10**4)),
        ("1 oz-in/rad", Dimension.STIFFNESS, POUND / 16 * Rational(254, 10**4)),
        ("1 in-lb/rad", Dimension.STIFFNESS, POUND * Rational(254, 10**4)),
        ("2 lbs", Dimension.MASS, 2 * Rational(45359237, 10**8)),
        ("2 lbs", Dimension.FORCE, 2 * POUND),
        ("2 gf", Dimension.FORCE, 2 * Rational(980665, 10**8)),
        ("2 kp", Dimension.FORCE, 2 * Rational(980665, 10**5)),
        ("5 N·s·m⁻¹", Dimension.DAMPING, 5),
        ("3 Nm·rad⁻¹", Dimension.STIFFNESS, 3),
        ("1 dyn/cm", Dimension.STIFFNESS, Rational(1, 1000)),
    ],
)
def test_units_of_catalogues_and_of_superscripts_are_exact(text: str, dimension: Dimension, value: Any) -> None:
    assert quantity(text, dimension).value == value


@pytest.mark.parametrize(
    ("text", "dimension", "offered"),
    [
        ("1 MM", Dimension.DISPLACEMENT, 'did you mean "mm" or "Mm"?'),
        ("1 MHZ", Dimension.FREQUENCY, 'did you mean "mHz" or "MHz"?'),
        ("1 KHZ", Dimension.FREQUENCY, 'did you mean "kHz"?'),
        ("1 milisec", Dimension.TIME, ""),
        ("1 kgmm", Dimension.MASS, ""),
        ("0.14 Nm/deg", Dimension.DAMPING, ""),
    ],
)
def test_what_is_offered_has_the_size_of_what_was_written_or_both_are(
    text: str, dimension: Dimension, offered: str
) -> None:
    said = refusal(quantity, text, dimension)
    assert said
    assert offered in said
    assert ("did you mean" in said) == bool(offered)
