"""A formula is laid out once, as a person writes it: order, signs, roots and numbers agree in all outputs, and plain text reads back."""

from __future__ import annotations

import random
import re
import unicodedata
from decimal import Context, Decimal
from fractions import Fraction
from itertools import combinations
from math import gcd
from typing import Any

import mpmath
import pytest
import sympy as sp
from formulas import EXPRESSIONS, are_identical, closed_forms, value_at
from hypothesis import given
from marks import QUICK_SCENES, WRITTEN_OUT, examples, often
from plainreader import expression
from sympy import (
    Abs,
    Add,
    Expr,
    Float,
    I,
    Integer,
    Mul,
    Poly,
    Pow,
    Rational,
    Symbol,
    acos,
    asin,
    atan,
    cos,
    exp,
    fraction,
    pi,
    sqrt,
)

import haptisym as hs
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.rings import PolynomialRing, X, omega, s
from haptisym.pages.words import apart
from haptisym.writing.boxes import Numeral, Ratio, text
from haptisym.writing.latex import escape, formula, tex
from haptisym.writing.layout import QUANTITIES, approximate, decimal, equation, is_short, number, plain, rounded
from haptisym.writing.mathml import estimated, mathml, readable
from haptisym.writing.plain import said

m, b, k, omega_n, zeta, omega_c, tau, J = hs.symbols("m b k omega_n zeta omega_c tau J")


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (m * s**2 + b * s + k, "m s^2 + b s + k"),
        (k - m * omega**2, "k - m omega^2"),
        (b * s + J * s + k, "(b + J) s + k"),
        (-(m * omega**2 + k) / omega, "-(m omega^2 + k)/omega"),
        (Rational(9, 5) * s**2 + Rational(1, 3) * s, "1.8 s^2 + (1/3) s"),
        (Rational(2, 7), "2/7"),
        (-Rational(2, 7), "-2/7"),
        (k / (2 * m), "k/(2 m)"),
        (k / (m * (s + 1)), "k/(m (s + 1))"),
        (sqrt(k / m), "sqrt(k/m)"),
        (100 * s ** Rational(1, 5), "100 s^0.2"),
        (s ** Rational(1, 3), "s^(1/3)"),
        (s ** (2 * tau), "s^(2 tau)"),
        (2 * 3 ** Rational(1, 3) * k, "2*3^(1/3) k"),
        (exp(-s * tau) * k, "k exp(-tau s)"),
        (cos(omega * tau) ** 2, "cos(tau omega)^2"),
        (Abs(k - m * omega**2) / k, "|k - m omega^2|/k"),
        (Abs(k - 2 * Abs(s - 1)), "abs(k - 2 |s - 1|)"),
        (asin(k), "asin(k)"),
        (I * k * omega, "k omega j"),
        (Float("7.74037e-7", 6) * s, "7.74037e-7 s"),
        (Float("2805780", 6), "2805780"),
        (Integer(0), "0"),
        (sp.oo, "∞"),
        (-sp.oo, "-∞"),
        (sp.Lt(k, m), "k < m"),
        (sp.ImmutableMatrix([[k, 0], [1, k]]), "[[k, 0], [1, k]]"),
    ],
)
def test_plain_text_is_written_as_a_person_types_it(expression, expected):
    assert plain(expression) == expected


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (asin(k / m), r"\arcsin\left( \frac{k}{m} \right)"),
        (acos(k) + atan(zeta) ** 2, r"\arccos(k) + \arctan^{2}(\zeta)"),
        (sp.log(k), r"\ln(k)"),
        (sp.asinh(k), r"\operatorname{arsinh}(k)"),
        (Symbol("force") / Symbol("amplitude"), r"\frac{F}{A}"),
        (Symbol("force_stick_friction"), r"F_{\mathrm{stick\,friction}}"),
        ((-2) ** Rational(1, 3), r"(-2)^{1/3}"),
        (sp.oo, r"\infty"),
        (sp.Ge(k, m), r"k \ge m"),
        (sp.ImmutableMatrix([[k, 0], [1, k]]), r"\begin{pmatrix} k & 0 \\ 1 & k \end{pmatrix}"),
    ],
)
def test_what_a_person_would_not_guess_of_sympys_latex(expression, expected):
    assert formula(expression) == expected


_NO_SIGN = re.compile(r"e-\d+|10\^\{-\d+\}|<mn>10</mn><mrow><mo>−</mo>|<[^>]*>")
"""What holds a minus that is no sign of a term: powers of ten, and attributes."""


def signs(written: str) -> str:
    """The signs of a formula in the order in which they are written."""
    return "".join(re.findall("[-+]", _NO_SIGN.sub("", written).replace("−", "-")))


@pytest.mark.slow
@given(EXPRESSIONS)
@examples(200)
def test_the_three_outputs_agree_on_every_sign(form):
    assert signs(plain(form)) == signs(mathml(form)) == signs(formula(form))


@pytest.mark.slow
@given(EXPRESSIONS)
@examples(300)
def test_any_plain_formula_reads_back_with_exactly_the_same_value(form):
    assert value_at(expression(plain(form), {x.name: x for x in form.free_symbols})) == value_at(form)


@pytest.mark.dear("fu2019", "sidestick")
@pytest.mark.few("fu2019", "delayed-spring", "sidestick")
@pytest.mark.parametrize("name", often(WRITTEN_OUT, QUICK_SCENES.__contains__))
def test_every_closed_form_of_a_shipped_scene_reads_back_exactly_from_plain_text(name):
    for form in closed_forms(name):
        assert are_identical(expression(plain(form), {x.name: x for x in form.free_symbols}), form), form


def test_the_readers_would_notice_a_wrong_sign_or_power():
    form = omega_n**2 * (m * s**2 + b * s + k) / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
    known = {x.name: x for x in form.free_symbols}
    right = plain(form)
    assert are_identical(expression(right, known), form)
    for old, new in (("+ k", "- k"), ("s^2 + b", "s^3 + b"), ("2 zeta", "3 zeta"), ("b s", "b omega_n")):
        assert old in right
        assert not are_identical(expression(right.replace(old, new), known), form)


def test_numbers_are_added_before_they_are_rounded():
    """-50000 pi^2 + 50000 sqrt(5) pi^2 is 609975.09...; its parts, rounded on their own, make 609980."""
    ring = PolynomialRing(s, [k])
    form, sign = readable(ring.convert((Rational(1, 3) + 10**9 * pi) * k), s)
    assert sign == "≈"
    assert plain(form) == "3.14159e9 k"
    assert rounded(50000 * pi**2 * (sqrt(5) - 1)) == Float("609975", 6)


def test_a_number_is_short_if_it_can_be_read_at_a_glance():
    assert [is_short(Rational(x)) for x in ("1234/5678", "12345/5678", "123456789012", "1e-9", "1.5e-9")] == [
        True, False, True, True, False,
    ]  # fmt: skip


@pytest.mark.parametrize("name", QUANTITIES)
def test_every_quantity_is_set_in_latex_and_plain_text(name):
    e = equation(name, k + s)
    assert tex(e).endswith(" = s + k")
    title = text(e).removesuffix(" = s + k")
    assert title.removesuffix("(s)").replace("Delta_jnd", "jnd") == name


a, c, d = hs.symbols("a c d")


u, v = sp.symbols("u v", real=True)
"""Whose signs are not known."""


IN_ORDER: list[Expr] = [
    3 ** Rational(1, 3), pi, X, b, k, zeta, a + J, omega_c, omega_n, c + omega_n, s, I, cos(m), (d + s) ** 2, sqrt(m + s),
]  # fmt: skip
"""Numbers, X, parameters (Latin before Greek), their sums, frequencies, their sums, s, j, functions, sums with s, roots of sums."""


def test_every_two_factors_of_a_product_stand_in_the_order_of_their_kinds() -> None:
    for one, two in combinations(IN_ORDER, 2):
        shown = plain(Mul(one, two))
        first, second = (f"({plain(x)})" if x.is_Add else plain(x) for x in (one, two))
        assert shown in (f"{first} {second}", f"{second} {first}"), shown
        assert shown == f"{first} {second}", shown
    for one, two in combinations([x.xreplace({s: omega}) for x in IN_ORDER], 2):
        assert plain(Mul(one, two)).startswith(f"({plain(one)})" if one.is_Add else plain(one))


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        # descending powers of s, numbers last; a sum to a power counts as its highest term
        (k + b * s + m * s**2 + 3, "m s^2 + b s + k + 3"),
        (s**3 + k * (s + 1) ** 2, "s^3 + k (s + 1)^2"),
        (s**3 + k * (s**2 + 1) ** 2, "k (s^2 + 1)^2 + s^3"),
        (s**3 + k * (s**3 + s + 1), "k (s^3 + s + 1) + s^3"),
        # quotients of sums that hold s last of all, behind roots of such sums; without s below they are coefficients
        (k / (s + 1) + m + s, "s + m + k/(s + 1)"),
        (k / (s + 1) + sqrt(s + 1) + m, "m + sqrt(s + 1) + k/(s + 1)"),
        (k * s / (a + b) + m + s**2, "s^2 + k s/(a + b) + m"),
        (1 / s + s + 1, "s + 1 + 1/s"),
        # without s, omega or a frequency all symbols count
        (a + b * c + 2, "b c + a + 2"),
        (a**3 + b * c + d, "a^3 + b c + d"),
        (a / (b + c) + d + 1, "d + 1 + a/(b + c)"),
        (a**b + c**2 + d, "c^2 + d + a^b"),
        ((s + 1) ** k + s**3, "s^3 + (s + 1)^k"),
        # functions behind what has the same power, numbers too
        (cos(b) + 1 + k, "k + 1 + cos(b)"),
        (k + k * cos(b), "k + k cos(b)"),
        (a * s**2 + s**2 * cos(b), "(a + cos(b)) s^2"),
        # omega, and frequencies among the parameters, where there is no s
        (k - m * omega**2 + b * omega, "k + b omega - m omega^2"),
        (k * omega_n + m * omega_n**2 + b, "m omega_n^2 + k omega_n + b"),
        (omega_c * omega_n**2 + omega_c**2 * omega_n, "omega_c^2 omega_n + omega_c omega_n^2"),
        # what has the same power of s is taken together, and what all of it has in common stands in front
        (2 * b * s + 2 * k * s + 1, "2 (b + k) s + 1"),
        (s * (2 * b + 2 * k) + 1, "2 (b + k) s + 1"),
        (b * s - k * s + 1, "(b - k) s + 1"),
        (s * (b - k) + a + c, "(b - k) s + a + c"),
        (a * b + a * c + s, "s + a (b + c)"),
    ],
)
def test_terms_stand_as_a_person_orders_them(form: Expr, shown: str) -> None:
    assert plain(form) == shown


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        (sqrt(k / m), "sqrt(k/m)"), (3 * sqrt(k / m), "3 sqrt(k/m)"), (-3 * sqrt(k / m), "-3 sqrt(k/m)"), (1 / sqrt(k * m), "1/sqrt(k m)"),
        (a / (sqrt(k) * sqrt(m) * b), "a/(b sqrt(k m))"), (sqrt(2) * sqrt(k), "sqrt(2 k)"), (3 * sqrt(2) * sqrt(k), "sqrt(18 k)"),
        (-sqrt(2) * sqrt(k), "-sqrt(2 k)"), (-3 * sqrt(2) * sqrt(k / m) * a, "-a sqrt(18 k/m)"), (sqrt(k) / sqrt(2), "sqrt(0.5 k)"),
        (sqrt(2) * sqrt(k) / sqrt(m), "sqrt(2 k/m)"), (sqrt(k), "sqrt(k)"), (5 * sqrt(2), "5 sqrt(2)"), (a * sqrt(k) / m, "a sqrt(k)/m"),
        (sqrt(u) * sqrt(k), "sqrt(k u)"), (sqrt(u) * sqrt(v), "sqrt(u) sqrt(v)"), (sqrt(u) / sqrt(v), "sqrt(u)/sqrt(v)"),
        (sqrt(u) * sqrt(v) * sqrt(k), "sqrt(k) sqrt(u) sqrt(v)"), (b / sqrt(k), "b/sqrt(k)"), (k ** Rational(3, 2) / sqrt(m), "k^1.5/sqrt(m)"),
    ],
)  # fmt: skip
def test_square_roots_are_gathered_under_one_where_no_two_signs_are_unknown(form: Expr, shown: str) -> None:
    assert plain(form) == shown
    known = {x.name: x for x in form.free_symbols}
    at = {x: Rational(n, 7) for n, x in enumerate(sorted(form.free_symbols, key=str), 2)}
    assert float(expression(shown, known).subs(at)) == pytest.approx(float(form.subs(at)))


@pytest.mark.parametrize(
    ("form", "shown"),
    [
        # a minus in front goes into a sum of at most three terms that then begins with a plus
        (-(k * (a - b)), "k (b - a)"),
        (-(k * (a - b + c)), "k (b - a - c)"),
        (-(k * (a - b + c - d)), "-k (a - b + c - d)"),
        (-(k * (a - b) ** 3), "k (b - a)^3"),
        (-(k * (a - b) ** 2), "-k (a - b)^2"),
        (-(k * (a + b)), "-k (a + b)"),
        (-k / (a - b), "k/(b - a)"),
        (-k * (a + c) / (s - b), "k (a + c)/(b - s)"),
        (-k * sqrt(a - b), "-k sqrt(a - b)"),
        # a sum that would begin with a minus changes its sign, and so does its product where the power is odd
        (k * (-(s**2) + b * s - 1), "-k (s^2 - b s + 1)"),
        (k * (-(s**2) + b * s - 1) ** 2, "k (s^2 - b s + 1)^2"),
        (k * sqrt(-(s**2) + b * s - 1), "k sqrt(-s^2 + b s - 1)"),
        (k * (-(s**2) + b * s - 1) ** Rational(3, 2), "k (-s^2 + b s - 1)^1.5"),
        (k / (-(s**2) + b * s - 1) ** 3, "-k/(s^2 - b s + 1)^3"),
        (Abs(-(s**2) + b * s - 1, evaluate=False), "|s^2 - b s + 1|"),
        (Abs(s**2 - b * s + 1, evaluate=False), "|s^2 - b s + 1|"),
        (Abs(-k * s, evaluate=False), "|k s|"),
        # a sum that is one term when its like powers are taken together is taken apart into factors
        (k * (b * s + J * s), "k (b + J) s"),
        (k * (b * s - J * s), "k (b - J) s"),
        (k / (b * s + J * s), "k/((b + J) s)"),
        (k * (b * s + J * s) * (s + 1), "k (b + J) s (s + 1)"),
        # numbers of a quotient
        (k / (3 * m), "k/(3 m)"),
        (2 * k / (3 * m), "2 k/(3 m)"),
        (3 * k / (2 * m), "1.5 k/m"),
        (-3 * k / (2 * m), "-1.5 k/m"),
        (3 * pi / (2 * m), "3 pi/(2 m)"),
        (Rational(3, 16) * pi / m, "0.1875 pi/m"),
        (3 * pi * k / 8, "0.375 pi k"),
        (Mul(Rational(1, 3), k, evaluate=False), "(1/3) k"),
        (Integer(-3), "-3"),
        (Pow(0, k, evaluate=False), "0^k"),
        (Pow(Integer(-2), k, evaluate=False), "(-2)^k"),
        (Pow(Rational(1, 2), k, evaluate=False), "(0.5)^k"),
        (pi**k, "pi^k"),
        (exp(k) * cos(k) ** 2, "cos(k)^2 exp(k)"),
        (sp.nan, "nan"),
        (sp.Eq(k, m + 1, evaluate=False), "k = m + 1"),
        (sp.Ne(k, m, evaluate=False), "k != m"),
    ],
)
def test_signs_and_numbers_stand_where_a_person_writes_them(form: Expr, shown: str) -> None:
    assert plain(form) == shown


def test_a_fraction_of_one_character_stays_the_number_that_it_is() -> None:
    """The half of 2½ had become 12, and the whole of it 212."""
    seen = 0
    for c in map(chr, range(0x3000)):
        if "FRACTION" in unicodedata.decomposition(c).upper() and "NUMERATOR" not in unicodedata.name(c):
            found = re.fullmatch(r"2\\textsuperscript\{(\d+)\}/\\textsubscript\{(\d+)\}", escape(f"2{c}"))
            assert found, c
            assert int(found[1]) / int(found[2]) == pytest.approx(unicodedata.numeric(c))
            seen += 1
    assert seen > 15


def drawn(pick: random.Random) -> Fraction:
    below = pick.choice([1, 2, 3, 7, 8, 10, 64, 125, 1000, 2**12, 5**9, 10**7, 3 * 10**4])
    return Fraction(pick.randint(0, 10 ** pick.randint(1, 12)), below)


def digits_of(value: Fraction) -> int | None:
    """Of a decimal that ends, without zeros at its end; None for another number."""
    places = next((n for n in range(40) if (value * 10**n).denominator == 1), None)
    return None if places is None else len(str(int(value * 10**places)))


def test_a_fraction_is_a_decimal_where_that_ends_within_six_digits_or_is_shorter() -> None:
    pick, seen = random.Random(1), set()
    values = [drawn(pick) for _ in range(600)]
    values += [
        Fraction(1234567, 8),
        Fraction(1, 2**10),
        Fraction(1, 2**20),
        Fraction(3, 5**8),
        Fraction(1, 256),
        Fraction(999, 512),
    ]
    for value in values:
        told = number(Rational(value.numerator, value.denominator))
        length = digits_of(value)
        both = len(f"{value.numerator}{value.denominator}")
        is_decimal = value.denominator == 1 or (length is not None and (length <= 6 or length < both))
        seen.add((is_decimal, length is None, length is not None and length == both))
        if isinstance(told, Ratio):
            assert not is_decimal, value
            assert (told.above, told.below) == (value.numerator, value.denominator)
            assert gcd(told.above, told.below) == 1
        else:
            assert is_decimal, value
            assert Fraction(told.digits) * Fraction(10) ** told.exponent == value
            assert value.denominator != 1 or told == Numeral(str(value.numerator))
            assert not told.digits.endswith("0") or "." not in told.digits
    assert {(True, False, False), (False, True, False), (True, False, True)} <= seen


@pytest.mark.parametrize("power", range(-8, 12))
@pytest.mark.parametrize("mantissa", ["1", "1.5", "9.99", "1.0203"])
def test_a_decimal_has_a_power_of_ten_from_ten_millions_on_and_below_a_ten_thousandth(
    mantissa: str, power: int
) -> None:
    value = Decimal(mantissa).scaleb(power)
    told = decimal(value)
    assert Decimal(told.digits).scaleb(told.exponent) == value
    assert (told.exponent != 0) == (value < Decimal("0.0001") or value >= 10**7)
    if told.exponent:
        assert (told.digits, told.exponent) == (mantissa, power)
    assert "E" not in told.digits
    assert (
        plain(Float(str(value), 15))
        == plain(Float(str(value), 8))
        == (f"{mantissa}e{power}" if told.exponent else f"{value:f}")
    )


def test_a_number_is_short_up_to_eight_digits_of_a_fraction_and_twelve_signs_of_a_decimal() -> None:
    for value, short in (
        ("1234567/3", True), ("12345679/3", False), ("1111/3333", True), ("1234/5677", True), ("12343/5677", False), ("1/1234567", True), ("1/12345678", False),
        ("123456789012", True), ("1234567890123", False), ("1.2345678901", True), ("1.23456789012", False), ("0.1234567891", True),
        ("0.12345678912", False), ("1e-7", True), ("1e-30", True), ("2e-7", False), ("1.5e-7", False), ("0", True),
    ):  # fmt: skip
        assert is_short(Rational(value)) == is_short(-Rational(value)) == short, value


def six(value: Expr, digits: int = 6) -> Decimal:
    """To so many digits, from fifty of mpmath's."""
    with mpmath.workdps(50):
        exact = mpmath.mpf(str(value.evalf(50)))
        return Context(prec=digits).create_decimal(mpmath.nstr(exact, 45))


def is_rounded(shown: Expr, true: Expr, digits: int = 6) -> bool:
    return isinstance(shown, Float) and Decimal(str(shown)) == six(true, digits)


def is_easy(x: Expr) -> bool:
    """Whether nobody needs it rounded: short, and times pi or its square at most."""
    for unit in (Integer(1), pi, pi**2):
        ratio = x / unit
        if ratio.is_Rational:
            return is_short(ratio)
    return False


NUMBERS = [
    Integer(3), Integer(999999), Integer(1000000), Integer(-1000001), Rational(1, 3), Rational(-7, 2), 2 * pi, pi / 3, 5 * pi**2, pi**3, sqrt(2), 3 * sqrt(5),
    Rational(10**9 + 1, 7), -Rational(123456789, 987654), pi * Rational(10**9 + 1, 7), Integer(10) ** 12, Integer(10) ** 13 + 1, 1 + pi, pi * sqrt(3),
]  # fmt: skip


@pytest.mark.slow
def test_a_formula_is_rounded_all_over_where_one_of_its_numbers_is_long_and_nowhere_else() -> None:
    pick, seen = random.Random(2), set()
    for _ in range(60):
        found = [pick.choice(NUMBERS) for _ in range(3)]
        form = Add(*(c * s**n for n, c in enumerate(found)))
        shown, easy = approximate(form), all(map(is_easy, found))
        seen.add(easy)
        if easy:
            assert shown == form
            continue
        for n, c in enumerate(found):
            told = shown.coeff(s, n)
            kept = c.is_Integer and abs(c) < 10**6
            assert told == c if kept else is_rounded(told, c), (told, c)
    assert seen == {True, False}


def test_numbers_within_powers_are_rounded_and_exponents_and_phases_are_not() -> None:
    long = Rational(10**9, 7)
    cases: list[tuple[Expr, Any]] = [
        ((s + long) ** 3, lambda x: x.base.coeff(s, 0)),
        ((k + long) / (s + 1), lambda x: next(y for y in x.args if y.has(k)).coeff(k, 0)),
    ]
    for form, inside in cases:
        assert is_rounded(inside(approximate(form)), long), form
        assert is_rounded(inside(approximate(form, 9)), long, 9), form
    assert approximate(long * cos(long * s)).args[1] == cos(long * s)
    power = approximate(long * s ** Rational(1, 3))
    assert power.as_coeff_Mul()[1] == s ** Rational(1, 3)
    assert approximate(s ** Rational(1, 3)) == s ** Rational(1, 3)
    assert approximate(long * k * s**2).free_symbols == {k, s}
    assert is_rounded(approximate(long), long)
    assert approximate(Rational(1, 3)) == Rational(1, 3)
    assert is_rounded(approximate(sqrt(2)), sqrt(2))


def polynomial(pick: random.Random, degree: int, most: int) -> Expr:
    found = [Rational(pick.randint(-most, most), pick.choice([1, 2, 3])) for _ in range(degree)]
    return Add(*(c * s**n for n, c in enumerate([*found, Rational(pick.randint(1, most))])))


@pytest.mark.slow
def test_a_quotient_that_can_be_read_is_what_it_was_with_denominators_that_begin_with_one() -> None:
    pick = random.Random(5)
    for _ in range(25):
        above, below = (
            polynomial(pick, pick.randint(0, 3), 9) * s ** pick.randint(0, 2),
            polynomial(pick, pick.randint(0, 2), 9),
        )
        shown, sign = readable(PolynomialRing(s).convert(above / below), s)
        assert sign == "="
        for at in (Rational(2, 7), Integer(11)):
            assert shown.subs(s, at) == above.subs(s, at) / below.subs(s, at)
        bottom = fraction(shown)[1]
        for factor in bottom.as_ordered_factors():
            base = factor.as_base_exp()[0]
            assert base.is_Rational or Poly(base, s).LC() == 1 or all(c.is_Integer for c in Poly(base, s).all_coeffs())


def test_a_quotient_with_a_long_number_above_or_below_is_rounded_in_all_of_its_numbers() -> None:
    long = Rational(10**9, 7)
    for above, below in (
        (long * s**2 + s / 3, s + 2),
        (s / 3 + 1, s + long),
        (s / 3 + 1, 3 * s**2 + long),
        (s * pi + 1, s + 1),
    ):
        shown, sign = readable(PolynomialRing(s).convert(above / below), s)
        assert sign == "≈"
        for at in (Rational(1, 2), Rational(7)):
            assert float(shown.subs(s, at)) == pytest.approx(float((above / below).subs(s, at)), rel=3e-6)
        numbers = [x for x in shown.atoms() if x.is_Number]
        assert all(isinstance(x, Float) or (x.is_Integer and abs(x) < 10**6) for x in numbers)
        assert any(isinstance(x, Float) for x in numbers)


def test_parameters_stay_beside_their_numbers_and_a_phase_beside_its() -> None:
    ring = PolynomialRing(omega, [k])
    long = Rational(10**9, 7)
    shown, sign = readable(ring.convert((long * k * omega + 2 * k + Rational(1, 3)) / (k * omega + 1)), omega)
    assert sign == "≈"
    for at in ({k: 3, omega: 5}, {k: Rational(1, 7), omega: 2}):
        true = ((long * k * omega + 2 * k + Rational(1, 3)) / (k * omega + 1)).subs(at)
        assert float(shown.subs(at)) == pytest.approx(float(true), rel=3e-6)
    phased = PolynomialRing(omega, functions=[I])  # a phase, as of friction, is one more function
    form = ((I * long + Rational(2, 3)) * omega + Rational(1, 3)) / (omega + 1)
    mixed, sign = readable(phased.convert(form), omega)
    assert sign == "≈"
    assert complex(mixed.subs(omega, 3)) == pytest.approx(complex(form.subs(omega, 3)), rel=3e-6)
    assert all(isinstance(x, Float) or x.is_Integer for x in mixed.atoms() if x.is_Number)
    exact, sign = readable(phased.convert((3 * omega + I) / (omega + 1)), omega)
    assert sign == "="
    assert exact.subs(omega, 3) == (9 + I) / 4


def test_a_sign_is_no_digit_of_a_long_number() -> None:
    digits = "123456789" * 3
    for n in range(1, 27):
        for value in (Integer(digits[:n]), Rational(int(digits[:n]), 7), Rational(int(digits[:n]), 10**n)):
            assert is_short(-value) == is_short(value), value


@pytest.mark.parametrize("number", [-12, 999999, -999999, 1234567, -123456789])
def test_a_quotient_shows_whole_numbers_of_at_most_six_digits_as_they_are(number: int) -> None:
    ring = PolynomialRing(s)
    shown, sign = readable(ring.convert((number * s + Rational(10**12 + 1, 7)) / (s + 1)), s)
    assert sign == "≈"
    assert (f"{abs(number)} s" in plain(shown)) == (abs(number) < 10**6)


def test_a_delay_stays_exact_in_a_quotient_that_is_rounded_unless_it_is_known_no_better() -> None:
    late = hs.distort(hs.environments.kelvin_voigt("100/7", 2), hs.effects.delay("0.019093053221796195 s")).perc
    long, short = map(plain, (readable(late, s)[0], estimated(late, s, 4)))  # type: ignore[index]
    assert "exp(-0.019093053221796195 s)" in long
    assert "exp(-0.01909 s)" in short


def test_ends_of_a_band_that_would_look_alike_are_told_apart() -> None:
    """A resonance of damping 1e-9: bands of step 2 went from 1000000000000 to 1000000000000 rad/s."""
    near = [ExactNumber(x) for x in (Rational(1), Rational(10**9 + 1, 10**9), Rational(2), Rational(2))]
    assert [said(x) for x in apart(near)] == ["1", "1.000000001", "2", "2"]
    assert [said(x) for x in apart(near[1:3])] == ["1.000", "2"]


@pytest.mark.parametrize("value", [Rational(323, 250) ** 9, Rational(3, 10) ** 40, Rational(10**35 + 1, 2)])
def test_a_decimal_of_more_than_28_digits_is_written_with_all_of_them(value: Rational) -> None:
    """It had been rounded, without a word."""
    assert expression(plain(value), {}) == value


def test_a_number_is_rounded_to_the_nearest_of_six_digits_and_both_parts_of_one_with_a_phase() -> None:
    for value in (pi, 50 * pi, Rational(2, 3), pi**2 / 7, Rational(10**20, 3), -pi):
        assert is_rounded(rounded(value), value)
        assert is_rounded(rounded(value, 9), value, 9)
    real, imag = rounded(pi + I / 3).as_real_imag()
    assert is_rounded(real, pi)
    assert is_rounded(imag, Rational(1, 3))
