"""When a number is a decimal, a fraction or a power of ten, when it is too long to be read, and how it is rounded then."""

from __future__ import annotations

import random
from decimal import Context, Decimal
from fractions import Fraction
from math import gcd
from typing import Any

import mpmath
import pytest
from sympy import Add, Expr, Float, I, Integer, Poly, Rational, Symbol, cos, exp, fraction, pi, sqrt

from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega, s
from haptisym.writing.boxes import Numeral, Ratio
from haptisym.writing.formula import readable
from haptisym.writing.mathtext import plain
from haptisym.writing.numerals import approximate, decimal, is_short, number, rounded

k, tau = Symbol("k"), Symbol("tau")


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


# Rounding


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


def test_numbers_within_powers_and_functions_are_rounded_and_exponents_are_not() -> None:
    long = Rational(10**9, 7)
    cases: list[tuple[Expr, Any]] = [
        ((s + long) ** 3, lambda x: x.base.coeff(s, 0)),
        (cos(long * s), lambda x: x.args[0].coeff(s)),
        (k * exp(-long * s), lambda x: -x.args[1].args[0].coeff(s)),
        ((k + long) / (s + 1), lambda x: next(y for y in x.args if y.has(k)).coeff(k, 0)),
    ]
    for form, inside in cases:
        assert is_rounded(inside(approximate(form)), long), form
        assert is_rounded(inside(approximate(form, 9)), long, 9), form
    power = approximate(long * s ** Rational(1, 3))
    assert power.as_coeff_Mul()[1] == s ** Rational(1, 3)
    assert approximate(s ** Rational(1, 3)) == s ** Rational(1, 3)
    assert approximate(long * k * s**2).free_symbols == {k, s}
    assert is_rounded(approximate(long), long)
    assert approximate(Rational(1, 3)) == Rational(1, 3)
    assert is_rounded(approximate(sqrt(2)), sqrt(2))


def test_a_number_is_rounded_to_the_nearest_of_six_digits_and_both_parts_of_one_with_a_phase() -> None:
    for value in (pi, 50 * pi, Rational(2, 3), pi**2 / 7, Rational(10**20, 3), -pi):
        assert is_rounded(rounded(value), value)
        assert is_rounded(rounded(value, 9), value, 9)
        assert rounded(value)._prec < rounded(value, 9)._prec
    both = rounded(pi + I / 3)
    real, imag = both.as_real_imag()
    assert is_rounded(real, pi)
    assert is_rounded(imag, Rational(1, 3))
    alone = rounded(I / 3)
    assert alone.as_real_imag()[0] == 0
    assert is_rounded(alone.as_real_imag()[1], Rational(1, 3))
    assert is_rounded(rounded(2 * pi + I, 3).as_real_imag()[0], 2 * pi, 3)


# Quotients


def polynomial(pick: random.Random, degree: int, most: int) -> Expr:
    found = [Rational(pick.randint(-most, most), pick.choice([1, 2, 3])) for _ in range(degree)]
    return Add(*(c * s**n for n, c in enumerate([*found, Rational(pick.randint(1, most))])))


def test_a_quotient_that_can_be_read_is_what_it_was_with_denominators_that_begin_with_one() -> None:
    pick = random.Random(5)
    for _ in range(25):
        above, below = (
            polynomial(pick, pick.randint(0, 3), 9) * s ** pick.randint(0, 2),
            polynomial(pick, pick.randint(0, 2), 9),
        )
        shown, is_approximate = readable(PolynomialRing(s).convert(above / below), s)
        assert not is_approximate
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
        shown, is_approximate = readable(PolynomialRing(s).convert(above / below), s)
        assert is_approximate
        for at in (Rational(1, 2), Rational(7)):
            assert float(shown.subs(s, at)) == pytest.approx(float((above / below).subs(s, at)), rel=3e-6)
        numbers = [x for x in shown.atoms() if x.is_Number]
        assert all(isinstance(x, Float) or (x.is_Integer and abs(x) < 10**6) for x in numbers)
        assert any(isinstance(x, Float) for x in numbers)


def test_digits_that_are_asked_for_are_given_even_where_a_quotient_could_be_read() -> None:
    shown, is_approximate = readable(PolynomialRing(s).convert((s / 3 + 10**5) / (s + 2)), s, 3)
    assert is_approximate
    [third] = [x for x in shown.atoms(Float) if x < 1]
    assert is_rounded(third, Rational(1, 3), 3)
    assert [x for x in shown.atoms(Float) if x > 1] == [Float("100000", 3)]
    assert readable(PolynomialRing(s).convert((s / 3 + 10**5) / (s + 2)), s)[1] is False
    assert not readable(PolynomialRing(s).convert((s / 3 + 99) / (s + 2)), s, 2)[0].has(Float("99.0", 2))


def test_parameters_stay_beside_their_numbers_and_a_phase_beside_its() -> None:
    ring = PolynomialRing(omega, [k])
    long = Rational(10**9, 7)
    shown, is_approximate = readable(ring.convert((long * k * omega + 2 * k + Rational(1, 3)) / (k * omega + 1)), omega)
    assert is_approximate
    for at in ({k: 3, omega: 5}, {k: Rational(1, 7), omega: 2}):
        true = ((long * k * omega + 2 * k + Rational(1, 3)) / (k * omega + 1)).subs(at)
        assert float(shown.subs(at)) == pytest.approx(float(true), rel=3e-6)
    phased = PolynomialRing(omega, functions=[I])  # a phase, as of friction, is one more function
    form = ((I * long + Rational(2, 3)) * omega + Rational(1, 3)) / (omega + 1)
    mixed, is_approximate = readable(phased.convert(form), omega)
    assert is_approximate
    assert complex(mixed.subs(omega, 3)) == pytest.approx(complex(form.subs(omega, 3)), rel=3e-6)
    assert all(isinstance(x, Float) or x.is_Integer for x in mixed.atoms() if x.is_Number)
    exact, is_approximate = readable(phased.convert((3 * omega + I) / (omega + 1)), omega)
    assert not is_approximate
    assert exact.subs(omega, 3) == (9 + I) / 4


def test_powers_that_all_terms_have_stand_in_front() -> None:
    shown, _ = readable(PolynomialRing(s).convert((3 * s**3 + 2 * s**2) / (s + 1)), s)
    assert plain(shown) == "s^2 (3 s + 2)/(s + 1)"
    assert plain(readable(PolynomialRing(s).convert(s + 2), s)[0]) == "s + 2"
    assert plain(readable(PolynomialRing(s).convert(5 * s / (2 * s + 4)), s)[0]) == "2.5 s/(s + 2)"
    assert readable(PolynomialRing(s).convert(s - s), s) == (0, False)
