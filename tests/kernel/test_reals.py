"""Real numbers that know themselves: digits, enclosures and nearest floats against mpmath and whole-number arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import isqrt, nextafter

import flint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import MP, rounded
from sympy import Expr, Integer, Rational, cos, pi, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber, RealNumber, Sliver, dyadic, is_in_pi
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.symbols import omega


def exact(x: Fraction) -> ExactNumber:
    return ExactNumber(Rational(x.numerator, x.denominator))


def roots(expression: Expr) -> list[RealNumber]:
    """The positive roots of a polynomial in omega^2, up to 10^16."""
    points = chart({"f": RealFunction(Ring().axis.convert(expression))}, Integer(0), Integer(10) ** 16).points
    return [point.omega for point in points[1:-1]]


def square_root(x: Fraction) -> RealNumber:
    [root] = roots(omega**2 - Rational(x.numerator, x.denominator))
    return root


def significant(text: str) -> str:
    """The digits of a decimal text, without point, exponent and leading zeros."""
    return text.upper().split("E")[0].replace(".", "").lstrip("0")


million = st.integers(1, 10**6)
positive = st.builds(lambda n, d, e: Fraction(n, d) * Fraction(10) ** e, million, million, st.integers(-9, 9))


@given(positive)
def test_the_float_of_a_rational_number_is_the_nearest(x: Fraction) -> None:
    assert float(exact(x)) == float(x)
    assert float(square_root(x**2)) == float(x)


@given(positive)
def test_the_float_of_a_square_root_is_the_nearest(x: Fraction) -> None:
    assert float(square_root(x)) == float(MP.sqrt(MP.mpf(x.numerator) / x.denominator))


@given(positive, st.integers(1, 60))
def test_digits_of_a_square_root_are_correctly_rounded(x: Fraction, count: int) -> None:
    found = square_root(x).digits(count)
    expected = MP.sqrt(MP.mpf(x.numerator) / x.denominator)
    assert Fraction(found) == Fraction(rounded(expected, count))
    assert len(significant(found)) >= count


@given(positive, st.integers(1, 60))
def test_digits_of_a_multiple_of_pi_are_correctly_rounded(x: Fraction, count: int) -> None:
    found = ExactNumber(Rational(x.numerator, x.denominator) * pi).digits(count)
    assert Fraction(found) == Fraction(rounded(MP.pi * x.numerator / x.denominator, count))


@given(positive, st.integers(1, 40))
def test_an_enclosure_holds_the_number_and_is_narrow(x: Fraction, count: int) -> None:
    low, high = map(Fraction, square_root(x).enclosure(count))
    assert low**2 <= x <= high**2
    assert high - low <= low / 10**count


@given(positive, st.integers(10, 300))
def test_bounds_hold_the_number_with_the_accuracy_asked_for(x: Fraction, bits: int) -> None:
    low, high = square_root(x).bounds(bits)
    assert low**2 <= x <= high**2
    assert high - low <= 4 * high / 2**bits


def test_a_thousand_digits_of_a_square_root_are_those_of_whole_number_arithmetic() -> None:
    found = square_root(Fraction(2)).digits(1000)
    assert abs(Fraction(found) - Fraction(isqrt(2 * 10**2200), 10**1100)) < Fraction(1, 10**999)
    whole = isqrt(2 * 10**2000)  # sqrt(2)*10^1000, rounded down
    assert found.replace(".", "") == str((whole + 5) // 10)


def test_roots_of_higher_degree_have_the_digits_of_mpmath() -> None:
    [root] = roots(omega**6 - 2 * omega**2 - 5)
    expected = MP.findroot(lambda w: w**6 - 2 * w**2 - 5, 1.4)
    assert root.digits(60) == rounded(expected, 60)
    assert float(root) == float(expected)


@pytest.mark.parametrize("value", [Fraction(1, 8), Fraction(5, 2), Fraction(1, 4), Fraction(3, 1000), Fraction(7)])
@pytest.mark.parametrize("make", [exact, lambda x: square_root(x**2)])
def test_a_decimal_number_shows_as_many_digits_as_asked_for(
    value: Fraction, make: Callable[[Fraction], RealNumber]
) -> None:
    for count in (3, 10, 40):
        found = make(value).digits(count)
        assert Fraction(found) == value
        assert len(significant(found)) == count


@pytest.mark.parametrize(
    ("value", "count", "even"),
    [("0.125", 2, "0.12"), ("0.375", 2, "0.38"), ("2.5", 1, "2"), ("12.25", 3, "12.2")],
)
def test_a_tie_between_two_decimals_goes_to_the_even_one(value: str, count: int, even: str) -> None:
    assert exact(Fraction(value)).digits(count) == even
    assert square_root(Fraction(value) ** 2).digits(count) == even


@pytest.mark.parametrize("value", [1 + Fraction(1, 2**53), 1 + Fraction(3, 2**53), Fraction(3 * 2**52 + 1, 2**52) / 2])
def test_a_tie_between_two_floats_goes_to_the_even_one(value: Fraction) -> None:
    assert float(exact(value)) == float(value)
    assert float(square_root(value**2)) == float(value)


@pytest.mark.parametrize("hair", [Fraction(1, 10**30), Fraction(-1, 10**30), Fraction(1, 10**90), Fraction(-1, 10**90)])
def test_a_hair_beside_a_tie_decides_it(hair: Fraction) -> None:
    value = 1 + Fraction(1, 2**53) + hair
    expected = nextafter(1.0, 2.0) if hair > 0 else 1.0
    assert float(exact(value)) == expected
    assert float(square_root(value**2)) == expected
    irrational = square_root((1 + Fraction(1, 2**53)) ** 2 + hair)
    assert float(irrational) == expected


def test_numbers_are_written_in_places_where_that_is_readable_and_in_powers_of_ten_elsewhere() -> None:
    assert exact(Fraction(1, 10**5)).digits(3) == "0.0000100"
    assert exact(Fraction(1, 10**12)).digits(3) == "1.00E-12"
    assert exact(Fraction(10**30)).digits(3) == "1.00E+30"
    assert exact(Fraction(123456)).digits(6) == "123456"
    assert exact(Fraction(0)).digits(5) == "0"
    assert exact(Fraction(0)).enclosure(5) == ("0", "0")
    assert float(exact(Fraction(0))) == 0.0


def test_the_working_precision_of_flint_is_left_as_it_was_and_does_not_matter() -> None:
    before = flint.ctx.prec
    root = square_root(Fraction(3))
    expected = (root.digits(80), root.enclosure(30), float(root), root.bounds(200))
    assert flint.ctx.prec == before
    for bits in (10, 1000):
        with flint.ctx.workprec(bits):
            assert (root.digits(80), root.enclosure(30), float(root), root.bounds(200)) == expected
            assert square_root(Fraction(7)).digits(60) == rounded(MP.sqrt(7), 60)
            assert flint.ctx.prec == bits
    assert flint.ctx.prec == before


def test_a_number_between_two_others_is_drawn_in_their_middle() -> None:
    assert [float(Sliver(Fraction(a, 8), Fraction(b, 8))) for a, b in ((2, 6), (-8, 2), (-3, -1))] == [
        0.5,
        -0.375,
        -0.25,
    ]


@pytest.mark.parametrize(
    "value", [Rational(2, 3), pi, 1 + pi, 3 * pi**2 - 1 / (pi - 2), 2 / pi, (1 + pi) ** -3, Integer(0)]
)
def test_what_is_made_of_rational_numbers_and_pi_is_known_to_be(value: Expr) -> None:
    assert is_in_pi(value)


@pytest.mark.parametrize(
    "value", [sqrt(2), sqrt(pi), 1 + sqrt(pi), pi * cos(1), pi**pi, 2**pi, sqrt(2) ** -3, cos(1) ** 2]
)
def test_what_holds_other_numbers_is_not(value: Expr) -> None:
    assert not is_in_pi(value)


@given(st.fractions(-9, 9, max_denominator=64), st.integers(1, 1 << 20), st.integers(2, 300))
def test_a_sliver_is_all_numbers_between_its_ends_however_many_bits_are_asked_for(
    low: Fraction, width: int, bits: int
) -> None:
    start = Fraction(round(low * 4096), 4096)
    x = Sliver(start, start + Fraction(width, 1 << 30))
    ball = x.ball(bits)
    assert ball.contains(dyadic(x.low))
    assert ball.contains(dyadic(x.high))
    assert float(ball.rad()) <= float(x.high - x.low) + 2.0 ** (3 - bits) * (1 + abs(float(x.high)))
    assert x.bounds(bits) == (x.low, x.high)
    assert x.low <= Fraction(float(x)) <= x.high or float(x) == float((x.low + x.high) / 2)
