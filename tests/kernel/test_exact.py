"""Exact numbers, rings of polynomials, rational functions and functions on the axis: against fractions, Decimal, mpmath, FLINT and SymPy."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from math import nextafter, prod
from typing import Any

import flint
import mpmath
import pytest
from flint import arb, fmpq
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import examples
from oracles import DIGITS, MP, Case, digits_of, sign
from oracles import rounded as oracle_rounded
from strategies import cases, rationals, scene
from strategies import exact as rational_of
from sympy import (
    Abs,
    Expr,
    I,
    Integer,
    Poly,
    Rational,
    Symbol,
    cos,
    exp,
    expand,
    factor_list,
    fraction,
    log,
    pi,
    sin,
    sinc,
    sqrt,
    tan,
    together,
)

import haptisym as hs
from haptisym.effects import compliance, first_order_lag, second_order_lowpass, series, shunt
from haptisym.environments import kelvin_voigt, mass_spring_damper
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.reals import (
    ALIKE_BITS,
    ExactNumber,
    Negative,
    RealNumber,
    Sliver,
    SquareRoot,
    bounds,
    dyadic,
    expression_ball,
    is_in_pi,
    ordered,
    outward,
    rational_between,
    rounded,
    short,
)
from haptisym.kernel.rings import Polynomial, PolynomialRing, degree_in, omega, s
from haptisym.kernel.roots import ascending, chart, each_once, sign_of_number
from haptisym.kernel.zerotest import is_zero_number as is_zero_turn
from haptisym.kernel.zerotest import vanishes

a, b = Symbol("a", positive=True), Symbol("b", positive=True)
m, k = hs.symbols("m k")
omega_c, omega_n, zeta = hs.symbols("omega_c omega_n zeta")


# Numbers that know themselves


def exact(x: Fraction) -> ExactNumber:
    return ExactNumber(Rational(x.numerator, x.denominator))


def positive_roots(expression: Expr) -> list[RealNumber]:
    """The positive positive_roots of a polynomial in omega^2, up to 10^16."""
    points = chart({"f": RealFunction(Ring().axis.convert(expression))}, Integer(0), Integer(10) ** 16).points
    return [point.omega for point in points[1:-1]]


def square_root(x: Fraction) -> RealNumber:
    [root] = positive_roots(omega**2 - Rational(x.numerator, x.denominator))
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
    assert Fraction(found) == Fraction(oracle_rounded(expected, count))
    assert len(significant(found)) >= count


@given(positive, st.integers(1, 60))
def test_digits_of_a_multiple_of_pi_are_correctly_rounded(x: Fraction, count: int) -> None:
    found = ExactNumber(Rational(x.numerator, x.denominator) * pi).digits(count)
    assert Fraction(found) == Fraction(oracle_rounded(MP.pi * x.numerator / x.denominator, count))


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


def test_roots_of_higher_degree_have_the_digits_of_mpmath() -> None:
    [root] = positive_roots(omega**6 - 2 * omega**2 - 5)
    expected = MP.findroot(lambda w: w**6 - 2 * w**2 - 5, 1.4)
    assert root.digits(60) == oracle_rounded(expected, 60)
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
    ("value", "count", "even"), [("0.125", 2, "0.12"), ("0.375", 2, "0.38"), ("2.5", 1, "2"), ("12.25", 3, "12.2")]
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
            assert square_root(Fraction(7)).digits(60) == oracle_rounded(MP.sqrt(7), 60)
            assert flint.ctx.prec == bits
    assert flint.ctx.prec == before


@pytest.mark.parametrize(
    ("value", "known"),
    [*((x, True) for x in (Rational(2, 3), pi, 3 * pi**2 - 1 / (pi - 2), (1 + pi) ** -3, Integer(0))),
     *((x, False) for x in (sqrt(2), 1 + sqrt(pi), pi * cos(1), pi**pi, 2**pi, sqrt(2) ** -3, cos(1) ** 2))],
)  # fmt: skip
def test_what_is_made_of_rational_numbers_and_pi_is_known_to_be(value: Expr, *, known: bool) -> None:
    assert is_in_pi(value) is known


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


def as_fraction(x: Any) -> Fraction:
    return Fraction(int(x.p), int(x.q))


def simplest(low: Fraction, high: Fraction) -> Fraction:
    """By trying one denominator after the other; of equal ones the least number in size."""
    for q in range(1, 10_000):
        inside = [
            Fraction(p, q) for p in range(math.floor(low * q), math.ceil(high * q) + 1) if low < Fraction(p, q) < high
        ]
        if inside:
            return min(inside, key=abs)
    raise AssertionError


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(8))
def test_the_number_between_two_others_is_the_simplest_one(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(25):
        low = Fraction(draw.randint(-90, 90), draw.randint(1, 30))
        high = low + Fraction(draw.randint(1, 40), draw.randint(1, 900))
        ends = [ExactNumber(Rational(x.numerator, x.denominator)) for x in (low, high)]
        found = as_fraction(rational_between(*ends))
        # bounds of the ends lie a hair off: an end that is simple itself may be given away, never more
        assert low < found < high
        assert found.denominator <= simplest(low, high).denominator
        own = Rational(draw.randint(-90, 90), draw.randint(1, 30))
        told = rational_between(*ends, own)
        assert told == (own if low < as_fraction(own) < high else rational_between(*ends))
        above, below = (as_fraction(rational_between(*x)) for x in ((ends[0], None), (None, ends[0])))
        assert above.denominator == below.denominator == 1
        assert (math.floor(low) + 1, math.ceil(low) - 1) == (above, below)
    assert rational_between(None, None) == 0
    root = SquareRoot(ExactNumber(Integer(2)))
    assert rational_between(root, ExactNumber(Rational(3, 2)), Rational(7, 5)) == Rational(10, 7)
    assert rational_between(Negative(root), None) == -1
    assert rational_between(None, Negative(root)) == -2


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(6))
def test_decimals_are_those_of_python(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(40):
        x = Fraction(draw.randint(-(10**9), 10**9), draw.randint(1, 10 ** draw.randint(1, 12))) * Fraction(
            10
        ) ** draw.randint(-15, 15)
        if not x:
            continue
        count = draw.randint(1, 18)

        def near(way: str, x: Fraction = x, count: int = count) -> Decimal:
            return Context(prec=count, rounding=way).divide(Decimal(x.numerator), Decimal(x.denominator))

        text = rounded(x, x, count)
        assert text is not None
        assert Decimal(text) == near(ROUND_HALF_EVEN)
        shown = text.lstrip("-").split("E")[0].replace(".", "").lstrip("0")
        assert len(shown) == count or (len(shown) > count and "." not in text)
        low, high = outward(x, x, count)
        assert (Decimal(low), Decimal(high)) == (near(ROUND_FLOOR), near(ROUND_CEILING))
        wide = x + abs(x) * Fraction(1, 10 ** draw.randint(1, 20))
        both = rounded(x, wide, count)
        assert both in (text, None)
        assert (both is None) == (Decimal(rounded(wide, wide, count) or 0) != Decimal(text))
        sliver = Sliver(*(as_fraction(fmpq(round(y * 2**90), 2**90)) for y in (x, x + Fraction(1, 2**60))))
        if sliver.low < sliver.high:
            digits = sliver.digits(count)
            most = [y for n in range(1, count + 1) if (y := rounded(sliver.low, sliver.high, n))]
            assert digits == (most[-1] if most else rounded(sliver.low, sliver.low, 1))
            assert float(sliver) == pytest.approx(float(x), rel=1e-9, abs=1e-15)
    assert [short(ExactNumber(Rational(x))) for x in ("100", "1e25", "0.5", "-3", "1e-9", "12345678")] == [
        "100", "1.0000E+25", "0.5", "-3", "1.0000E-9", "12346000",
    ]  # fmt: skip


def some(draw: random.Random, most: int = 9) -> Rational:
    return Rational(draw.choice([-1, 1]) * draw.randint(1, most), draw.choice([1, 2, 3, 7]))


@pytest.mark.dear("3")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_balls_of_expressions_hold_the_values_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(5):
        x: Expr = abs(some(draw)) + draw.choice([0, pi])
        for _ in range(draw.randint(1, 4)):
            way = draw.randrange(9)
            x = (
                x + some(draw),
                x * some(draw),
                abs(some(draw)) * x**2 + 1,
                sqrt(x**2 + 1),
                cos(x),
                sin(x) + 2,
                sinc(x),
                log(x**2 + 2),
                tan(x / 40),
            )[way]
        with mpmath.workdps(60):
            true = mpmath.mpf(x.evalf(60))
        with flint.ctx.workprec(128):
            low, high = bounds(expression_ball(x))
        slack = Fraction(1, 10**50) * (1 + abs(Fraction(mpmath.nstr(true, 50))))
        assert low - slack <= Fraction(mpmath.nstr(true, 55)) <= high + slack
        assert high - low <= Fraction(1, 2**90) * max(1, abs(high))
    with flint.ctx.workprec(64):
        assert expression_ball(a**2 + b, {a: arb(3), b: arb(1)}) == 10
        assert expression_ball(sqrt(a), {a: arb(0)}) == 0
        assert not expression_ball(1 / sqrt(a), {a: arb(0)}).is_finite()
        assert expression_ball(a**pi, {a: arb(2)}).overlaps(arb(2) ** arb.pi())
    with pytest.raises(TypeError, match="not a real number"):
        expression_ball(exp(Integer(2)))


@pytest.mark.parametrize("seed", range(3))
def test_things_stand_by_their_numbers_and_those_that_are_alike_as_they_were(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(10):
        values = [
            Fraction(draw.randint(1, 9), draw.randint(1, 4)) + draw.choice([0, Fraction(1, 10**150)]) for _ in range(9)
        ]
        named = list(enumerate(values))
        numbers = {name: exact(x) for name, x in named}
        row = sorted(named, key=lambda x: x[1])
        assert ascending([name for name, _ in named], numbers.__getitem__) == [name for name, _ in row]
        firsts = [name for i, (name, x) in enumerate(row) if x not in values[:name] or not i]
        assert each_once([name for name, _ in named], numbers.__getitem__) == firsts
        for a, b in ((draw.choice(named), draw.choice(named)) for _ in range(9)):
            assert ordered(numbers[a[0]], numbers[b[0]]) == (a[1] < b[1]) - (a[1] > b[1])


def test_what_differs_by_less_than_bits_tell_is_alike() -> None:
    root = ExactNumber(sqrt(2))
    for bits, order in ((100, 1), (ALIKE_BITS - 8, 1), (ALIKE_BITS + 8, 0)):
        beyond = ExactNumber(sqrt(2) + Rational(1, 2**bits))
        assert (ordered(root, beyond), ordered(beyond, root)) == (order, -order)
        assert each_once([beyond, root], lambda x: x) == ([root, beyond] if order else [beyond])
    assert ordered(root, root) == 0


@given(st.lists(st.fractions(-9, 9, max_denominator=30), min_size=1, max_size=4))
def test_the_sign_of_a_number_with_pi_in_it_is_that_of_mpmath(c: list[Fraction]) -> None:
    exact = sum((Rational(a.numerator, a.denominator) * pi**n for n, a in enumerate(c)), start=Integer(0))
    assert sign_of_number(exact) == sign(MP.polyval([MP.mpf(a.numerator) / a.denominator for a in reversed(c)], MP.pi))


@pytest.mark.parametrize("digits", [2, 20, 60])
def test_the_sign_of_pi_minus_a_fraction_near_it_is_decided(digits: int) -> None:
    below = Rational(int(MP.floor(MP.pi * MP.mpf(10) ** digits)), 10**digits)
    assert (sign_of_number(pi - below), sign_of_number(pi - below - Rational(1, 10**digits))) == (1, -1)


def test_a_number_that_is_zero_is_known_to_be_zero() -> None:
    assert sign_of_number((pi + 1) ** 2 - pi**2 - 2 * pi - 1) == sign_of_number(1 / pi - pi / pi**2) == 0


# Sums of cosines and sines of parts of a turn


def ring_of(angles: int) -> PolynomialRing:
    return PolynomialRing(omega, functions=[Symbol(f"{kind}{i}") for i in range(angles) for kind in ("cos", "sin")])


def zeros_of(ring: PolynomialRing, i: int, angle: Expr) -> list[Polynomial]:
    """Polynomials that are zero there: cos^2 + sin^2 - 1, and Im (cos + j sin)^m where m half angles are half turns."""
    c, s = ring.context.gens()[2 + 2 * i : 4 + 2 * i]
    m, real, imag = int((angle / 2 / pi).q), ring.constant(1), ring.constant(0)
    for _ in range(m):
        real, imag = real * c - imag * s, real * s + imag * c
    return [c * c + s * s - 1, imag]


def value_of_turns(polynomial: Polynomial, angles: list[Expr]) -> mpmath.mpf:
    halves = [mpmath.pi * mpmath.mpf((a / pi).p) / (2 * (a / pi).q) for a in angles]
    known = [mpmath.mpf(1), mpmath.pi, *(f(x) for x in halves for f in (mpmath.cos, mpmath.sin))]
    return mpmath.fsum(
        mpmath.mpf(int(c.p)) / int(c.q) * prod(x ** int(n) for x, n in zip(known, e, strict=True))
        for e, c in polynomial.to_dict().items()
    )


def drawn_turns(chance: random.Random, ring: PolynomialRing, angles: int) -> Any:
    return ring.context.from_dict(
        {
            (0, chance.randint(0, 1), *(chance.randint(0, 2) for _ in range(2 * angles))): fmpq(
                chance.randint(-4, 4), 3
            )
            for _ in range(3)
        }
    )


@pytest.mark.few("3")
@pytest.mark.parametrize("seed", range(4))
def test_what_is_said_to_be_zero_is_and_nothing_else(seed: int) -> None:
    """Of angles of all signs, of none and of many turns, in products of what is zero, and a trillionth of pi beside it."""
    chance, zero = random.Random(seed), 0
    for _ in range(60):
        count = chance.randint(1, 2)
        ring, angles = (
            ring_of(count),
            [pi * Rational(chance.randint(-9, 9), chance.randint(1, 6)) for _ in range(count)],
        )
        known = [x for i, angle in enumerate(angles) for x in zeros_of(ring, i, angle)]
        polynomial = drawn_turns(chance, ring, count) * chance.choice(known) + drawn_turns(
            chance, ring, count
        ) * chance.choice(known)
        if chance.random() < 0.3:
            polynomial += ring.context.from_dict({(0, 1, *[0] * 2 * count): fmpq(1, 10**12)})
        if chance.random() < 0.3:
            polynomial = drawn_turns(chance, ring, count)
        with mpmath.workdps(80):
            true = abs(value_of_turns(polynomial, angles)) < mpmath.mpf(10) ** -60
        assert is_zero_turn(polynomial, angles) is true, (polynomial, angles)
        zero += true
    assert 20 < zero < 55


def test_of_an_angle_that_is_no_part_of_a_turn_nothing_is_said() -> None:
    """cos a - (cos^2 a/2 - sin^2 a/2) is zero for every a, and sin a is not: neither is told of pi^2/8 rad."""
    ring = ring_of(2)
    _, _, c, _, c2, s2 = ring.context.gens()
    angles = [pi**2 / 8, pi**2 / 16]
    assert is_zero_turn(c - (c2 * c2 - s2 * s2), angles) is None
    assert is_zero_turn(c, angles) is None
    assert is_zero_turn(c - c, angles) is True


def test_what_powers_of_s_make_zero_at_every_frequency_is_seen_to_vanish_beside_delays_and_powers_of_omega() -> None:
    """(R + j X)^3 is j omega where R + j X is (j omega)^(1/3): R^3 - 3 R X^2 is 0, and 3 R^2 X - X^3 is omega."""
    third, late = s ** Rational(1, 3), exp(-s / 2)
    ring = Ring.of([third, late])
    root, wave, speed = (on_axis(ring.convert(x)) for x in (third, late, s))
    axis, (R, X), w = root.real.axis, (root.real.function, root.imag.function), speed.imag.function
    three = axis.convert(Integer(3))
    none, whole = R * R * R - three * R * X * X, three * R * R * X - X * X * X
    others = [axis.one, wave.real.function, wave.imag.function, w * w, R, wave.real.function * X]
    for f, known in (
        (none, True),
        (whole - w, True),
        (whole, False),
        (whole + w, False),
        (whole - three * w, False),
        (R, False),
    ):
        for other in others:
            assert vanishes((f * other).numerator, axis) is known
            assert vanishes((f * other + none).numerator, axis) is known
            assert not vanishes((f * other - w * w * w * w * w).numerator, axis)
    assert vanishes(axis.zero.numerator, axis)


# Rings


E = exp(-s / 2)
RING = Ring.of([a * b * E + s ** Rational(1, 2)])


def drawn(draw: random.Random) -> Expr:
    found = sum(
        (
            draw.choice([-3, Rational(1, 2), 2])
            * s ** draw.randint(0, 3)
            * a ** draw.randint(0, 2)
            * b ** draw.randint(0, 1)
            * E ** draw.randint(0, 2)
            for _ in range(draw.randint(1, 4))
        ),
        Integer(0),
    )
    return found or Integer(1)


def is_same(x: Expr, y: Expr) -> bool:
    """At two places, exactly."""
    e = Symbol("e")
    places = ({s: Rational(n, 9), a: Rational(2, n), b: Rational(n, 4), e: Rational(3, 7)} for n in (5, 13))
    return all((x - y).subs(E, e).subs(exp(-s), e**2).subs(at) == 0 for at in places)


@pytest.mark.dear("6")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_polynomials_are_split_into_factors_and_what_all_terms_share(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        x, y = drawn(draw), drawn(draw)
        p = RING.convert(x.expand()).numerator * RING.convert(y.expand()).numerator ** 2
        unit, factors = RING.factors(p)
        product = RING.constant(unit)
        for f, n in factors:
            product *= f**n
        assert product == p
        outside, rest = RING.without_common_functions(p)
        assert is_same(outside * RING.expression(rest), RING.expression(p))
        first = RING.size
        shared = [min(int(e[i]) for e in rest.monoms()) for i in range(first, len(RING.meanings))]
        assert not any(shared)
        assert outside == 1 or outside.has(s)
        assert degree_in([p, p**2], 0) == 2 * int(p.degrees()[0])


@pytest.mark.slow
@pytest.mark.few("0")
@pytest.mark.parametrize("seed", range(12))
def test_rational_functions_are_added_multiplied_and_reduced_as_sympy_does(seed: int) -> None:
    draw = random.Random(seed)
    x, y, z = drawn(draw), drawn(draw), drawn(draw)
    f, g = RING.convert(x.expand()) / RING.convert(y.expand()), RING.convert(z.expand())
    for found, true in (
        (f + g, x / y + z),
        (f - g, x / y - z),
        (f * g, x / y * z),
        (f / g, x / y / z),
        (-f, -x / y),
        (f**2, (x / y) ** 2),
        (f**-1, y / x),
    ):
        assert is_same(found.expression(), true)
        reduced = found.reduced()
        assert reduced.equals(found)
        assert reduced.numerator.gcd(reduced.denominator).is_constant()
    assert not f.equals(f + RING.one)
    assert (f - f).is_zero
    assert not f.is_zero
    own = RING.convert((s**4 + 4) * (s**2 - 2)).numerator
    assert sorted(Poly(RING.expression(h), s).degree() for h, _ in RING.factors(own)[1]) == [2, 4]
    assert sorted(Poly(RING.expression(h), s).degree() for h, _ in RING.factors(own, in_square=False)[1]) == [2, 2, 2]


w = Symbol("w", positive=True)

monomials = st.tuples(st.integers(0, 3), st.integers(0, 2), st.integers(0, 2), st.integers(-9, 9).filter(bool))

polynomials = st.lists(monomials, min_size=1, max_size=4).map(
    lambda terms: sum(c * w**i * a**j * b**k for i, j, k, c in terms)
)


@examples(15)
@given(polynomials, polynomials, st.integers(1, 2))
def test_factors_are_those_of_sympy(f: Expr, g: Expr, power: int) -> None:
    product = (f * g**power).expand()
    if not product:
        return
    ring = PolynomialRing(w, [a, b])
    unit, found = ring.factors(ring.convert(product).numerator, in_square=False)
    expected = factor_list(product, w, a, b)[1]
    assert unit * prod((ring.expression(x).expand() ** n for x, n in found), start=Rational(1)).expand() == (product)
    assert {_up_to_sign(ring.expression(x).expand()): n for x, n in found} == {
        _up_to_sign(x.expand()): n for x, n in expected
    }


def _up_to_sign(x: Expr) -> frozenset[Expr]:
    return frozenset({x, (-x).expand()})


context = flint.fmpq_mpoly_ctx.get(("x", "a", "b", "c"), flint.Ordering.lex)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_dynamics_keep_their_values_in_a_ring_whatever_their_delays_and_powers(seed: int) -> None:
    draw = random.Random(seed)
    kinds = [
        Rational(draw.randint(1, 9), draw.randint(1, 6)),
        a * Rational(draw.randint(1, 3), 2),
        pi / 4,
        a + Rational(1, 3),
    ]
    lags = [draw.choice(kinds) for _ in range(draw.randint(1, 3))]
    powers = [0, s ** Rational(draw.choice([-7, -1, 1, 5]), 3), s ** (a - 1), s ** (1 + b)]
    x = sum((some(draw) * s ** draw.randint(0, 2) * exp(-s * lag) for lag in lags), some(draw)) / (s + 3) + draw.choice(
        powers
    )
    back = Ring.of([x]).convert(x).expression()
    known = {
        s: Rational(draw.randint(1, 30), 7),
        a: Rational(draw.randint(1, 20), 9),
        b: Rational(draw.randint(1, 8), 9),
    }
    assert abs((back - x).subs(known).evalf(30)) < 1e-15 * (1 + abs(x.subs(known).evalf(30)))
    for lag in (Rational(1, 10), Rational(7, 3)):
        assert Ring.of([exp(-s * lag)]).lags == (lag,)


@pytest.mark.parametrize("power", [1 - 2 * a, -a / 3, 2 * a - 1, 3 - a, -2 * a - 5, a])
def test_a_power_of_s_that_falls_with_a_symbol_is_the_inverse_of_one_that_grows(power: Expr) -> None:
    ring = Ring.of([s**power])
    assert all(x.as_coeff_Mul()[0] > 0 for x in ring.orders)
    told, known = ring.convert(s**power + 1).expression(), {s: Rational(7, 2), a: Rational(1, 3)}
    assert abs((told - s**power - 1).subs(known).evalf(30)) < 1e-20


@pytest.mark.parametrize(
    "refused",
    [sqrt(2 + s), Abs(s), s * 1.5, s**s, sin(s), *(exp(x) for x in (1 - s / 10, -(s**2), -(s**2) - s, -1 / s - s))],
    ids=str,
)
def test_what_is_not_made_of_s_delays_and_powers_with_exact_coefficients_is_refused(refused: Expr) -> None:
    with pytest.raises(hs.SceneError, match="is not made of|must be a number|is not a delay"):
        Ring.of([refused]).convert(refused)


def test_two_symbols_of_one_name_are_refused_rather_than_mixed_up() -> None:
    with pytest.raises(hs.SceneError, match="both named k"):
        hs.distort(mass_spring_damper(k=Symbol("k")), shunt(k=Symbol("k", positive=True)))


# On the axis


integers = st.integers(-5, 5)

in_s = st.lists(integers, min_size=1, max_size=4).map(lambda c: sum(n * s**i for i, n in enumerate(c)))

denominators = in_s.filter(lambda p: p != 0)

quotients = st.builds(lambda p, q: p / q, in_s, denominators)


def is_zero(expression: Expr) -> bool:
    """Whether an expression is 0: its numerator over one denominator, multiplied out (``cancel`` may leave 1/2 - 1/2 unadded)."""
    return expand(fraction(together(expression))[0]) == 0


@pytest.mark.slow
@given(quotients)
def test_parts_and_squared_modulus_are_those_of_complex_numbers(f: Expr) -> None:
    """At rational frequencies, where that is finite."""
    function = Ring().convert(f)
    response, square = on_axis(function), squared_modulus(function)
    below = f.as_numer_denom()[1]
    finite = [at for n in (1, 4, 5, 7, 11, 13) if below.subs(s, I * (at := Rational(n, 3))).expand() != 0]
    assert finite
    for at in finite:
        real, imag = f.subs(s, I * at).expand(complex=True).as_real_imag()
        found = [x.expression().subs(omega, at) for x in (response.real, response.imag, square)]
        assert found == [real, imag, real**2 + imag**2]


DYNAMICS: dict[str, Expr] = {
    "polynomial": 3 * s**4 - s**3 + 2 * s**2 - 7 * s + 5,
    "quotient": (s**3 + 2) / (s**5 - 3 * s**2 + s + 1),
    "delay": (2 + s * exp(-s / 4)) / (s**2 + 3 * exp(-s / 4) + 5),
    "delay squared": exp(-s / 2) * (s + 1) - exp(-s / 4) * s**2 + 3,
    "two delays": (exp(-s / 4) - 2 * exp(-s * pi / 9)) / (s + 3 + exp(-s / 4 - s * pi / 9)),
    "three delays": exp(-s / 4) * (s - exp(-s * pi / 9)) + s**2 * exp(-s * pi**2 / 50) ** 2 - 1,
    "hold": (1 - exp(-s / 5)) / (s / 5),
    "hold and lag": (1 - exp(-s / 5)) * (s + 2) / (s * (s + 7)),
    "root": 3 * sqrt(s) + s + 2,
    "root below": (s + 1) / (s * sqrt(s) + 4),
    "two powers": s ** Rational(1, 3) * (s + 2) / (1 + s ** Rational(3, 4)) + s ** Rational(5, 3),
    "power and delay": (sqrt(s) + exp(-s / 4)) / (s + 2 * sqrt(s) * exp(-s / 4) + 3),
    "two powers and two delays": s ** Rational(1, 3) * exp(-s / 4) + s ** Rational(3, 4) * exp(-s * pi / 9),
    "friction": s**2 + 2 * s + 5 + 3 * I,
    "friction and delay": (s + 2 * I) * exp(-s / 4) / (s + 3 + I),
    "friction, power and delay": (sqrt(s) + I * s) * exp(-s / 4) + 2 * I + s**3,
    "pi": (pi * s**3 + s) / (s**2 + pi**2 * s + 1),
    "pi and delay": (pi * s + exp(-s / 4)) / (s + pi),
}

PLACES = [MP.mpf("0.37"), MP.mpf("6.1")]


def mp_value(expression: Expr, at: object) -> object:
    """An expression in s, or in omega, in mpmath."""
    known = {s: MP.mpc(0, at), omega: at, I: MP.mpc(0, 1), pi: MP.pi}
    if expression in known:
        return known[expression]
    if expression.is_Rational:
        return MP.mpf(int(expression.p)) / int(expression.q)
    arguments = [mp_value(x, at) for x in expression.args]
    if expression.is_Add:
        return MP.fsum(arguments)
    if expression.is_Mul:
        return MP.fprod(arguments)
    if expression.is_Pow:
        return arguments[0] ** (int(expression.exp) if expression.exp.is_Integer else arguments[1])
    return getattr(MP, type(expression).__name__)(*arguments)


@pytest.mark.dear("delay", "friction and delay", "quotient")
@pytest.mark.few("quotient", "delay", "hold", "root", "friction and delay")
@pytest.mark.parametrize("name", DYNAMICS)
def test_on_the_axis_every_form_has_the_values_of_mpmath(name: str) -> None:
    f = DYNAMICS[name]
    dynamics = Ring.of([f]).convert(f).reduced()
    response, square = on_axis(dynamics), squared_modulus(dynamics)
    truths = {
        "real": (response.real, lambda x: mp_value(f, x).real),
        "imag": (response.imag, lambda x: mp_value(f, x).imag),
        "square": (square, lambda x: abs(mp_value(f, x)) ** 2),
        "product": (response.real * square, lambda x: mp_value(f, x).real * abs(mp_value(f, x)) ** 2),
        "quotient": (response.imag / square, lambda x: mp_value(f, x).imag / abs(mp_value(f, x)) ** 2),
        "difference": (response.imag - response.real, lambda x: mp_value(f, x).imag - mp_value(f, x).real),
        "slope of real": (response.real.derivative(), lambda x: MP.diff(lambda w: mp_value(f, w).real, x)),
        "slope of imag": (response.imag.derivative(), lambda x: MP.diff(lambda w: mp_value(f, w).imag, x)),
    }
    for kind, (found, true) in truths.items():
        forms = (
            (found.expression(), found.factored(), found.half_angled.factored())
            if "slope" not in kind
            else (found.half_angled.factored(),)
        )
        for x in PLACES:
            value = true(x)
            limit = MP.mpf(10) ** -25 * (1 + abs(value) + abs(mp_value(f, x)) ** 3)
            for form in forms:
                assert abs(mp_value(form, x) - value) <= limit, (kind, form)
            with flint.ctx.workprec(200):
                ball = found.ball(arb(str(x)))
                assert ball.rad() < 1e-30 * (1 + abs(float(value)) + abs(complex(mp_value(f, x))) ** 3)
                assert abs(MP.mpf(ball.mid().str(60, radius=False)) - value) <= limit, kind


@pytest.mark.dear("1")
@pytest.mark.parametrize("seed", range(6))
def test_at_rest_powers_of_s_that_are_not_whole_leave_the_limit_whatever_cancels(seed: int) -> None:
    """Sums of few powers over others, with and without a delay: at 10^-900 rad/s all but the first power is lost."""
    draw = random.Random(seed)
    for _ in range(4):
        order, first = Rational(draw.choice(["1/2", "1/3", "2/3", "3/4"])), draw.choice([0, 1, 2])
        late = draw.choice([1, 1, exp(-s / 7)])
        above, below = (
            sum(
                draw.choice([-3, 1, 2, 7]) * late ** draw.randint(0, 1) * s ** (first * order + n)
                for n in (0, *draw.sample([order, 3 * order, 1 + order], 2))
            )
            for _ in range(2)
        )
        f = above / below * draw.choice([1, 1, s])
        response, near = on_axis(Ring.of([f]).convert(f)), mp_value(f, MP.mpf(10) ** -900)
        for part, true in ((response.real, near.real), (response.imag, near.imag)):
            with flint.ctx.workprec(200):
                ball = part.ball(arb(0))
            assert ball.rad() < 1e-30
            assert abs(MP.mpf(ball.mid().str(40, radius=False)) - true) < 1e-30


@pytest.mark.slow
@examples(15)
@given(*[st.lists(st.integers(-2, 2).filter(bool), min_size=2, max_size=3)] * 3, st.integers(0, 3), st.integers(0, 3))
def test_a_square_over_a_function_is_in_lowest_terms(
    f: list[int], g: list[int], both: list[int], above: int, below: int
) -> None:
    """Common factors up to three times in each; the witness is the common divisor of the whole."""
    p, q, r = (sum(c * omega**n for n, c in enumerate(row)) for row in (f, g, both))
    one, other = (
        RealFunction(Ring().axis.convert(x).reduced())
        for x in (p * r**above / (q**2 + omega**2), q * r**below / (p**2 + 1))
    )
    found = one.square_over(other).function
    witness = (one.function * one.function / other.function).reduced()
    assert (found.numerator, found.denominator) == (witness.numerator, witness.denominator)
    with pytest.raises(hs.SceneError, match="zero"):
        one.square_over(RealFunction(Ring().axis.zero))


def test_where_omega_is_small_nothing_cancels_in_half_angles() -> None:
    """|exp(-s tau)|^2 = 1, |1 - exp(-s tau)|^2 = 4 sin(omega tau/2)^2, and a hold is 1/4 - j omega/32 or so."""
    late = (s + 1) * exp(-s / 4) * exp(-s * pi / 9)
    assert squared_modulus(Ring.of([late]).convert(late)).half_angled.factored().expand() == omega**2 + 1
    f = 1 - exp(-s / 4)
    tiny = MP.mpf(10) ** -30
    assert (
        abs(mp_value(squared_modulus(Ring.of([f]).convert(f)).half_angled.factored(), tiny) / (tiny / 4) ** 2 - 1)
        < 1e-40
    )
    parts = on_axis(Ring.of([f]).convert(f / s).reduced())
    with flint.ctx.workprec(100):
        for part, true in ((parts.real, 1 / 4), (parts.imag, -1e-40 / 32)):
            ball = part.ball(arb("1e-40"))
            assert float(ball) == pytest.approx(true, rel=1e-12)
            assert ball.rel_accuracy_bits() > 80


# Closed forms of scenes


def numeric(expression: Expr, at: Fraction) -> object:
    """A closed form in omega at a rational frequency, by SymPy's own arithmetic."""
    return MP.mpf(str(expression.subs(omega, rational_of(at)).evalf(50)))


@pytest.mark.slow
@examples(15)
@given(cases(order=3), rationals(-1, 2))
def test_closed_forms_have_the_values_of_mpmath(case: Case, at: Fraction) -> None:
    d = scene(case).distortion()
    H, G = case.dynamics(MP.mpc(0, digits_of(at)), DIGITS)
    D, size = G - H, abs(H)
    assume(size > MP.mpf(10) ** -40 * abs(G))  # at a zero of H_env there is no ratio
    expected = {
        "real": D.real, "imag": D.imag,
        "ratio_real": abs(D.real) / size, "ratio_imag": abs(D.imag) / size,
        "relative_real": (D / H).real, "relative_imag": (D / H).imag,
    }  # fmt: skip
    for name, value in expected.items():
        assert abs(numeric(getattr(d, name), at) - value) <= MP.mpf(10) ** -40 * (abs(value) + abs(D) + abs(G)), name
    for form, value in ((d.environment, H), (d.perceived, G), (d.distortion, D)):
        found = form.subs(s, I * rational_of(at)).evalf(50).as_real_imag()
        assert abs(MP.mpc(str(found[0]), str(found[1])) - value) <= MP.mpf(10) ** -40 * (abs(H) + abs(G))


def test_the_relative_distortion_of_a_series_effect_holds_no_environment() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), second_order_lowpass(omega_n, zeta))
    assert (d.relative_real.free_symbols | d.relative_imag.free_symbols) <= {omega, omega_n, zeta}
    G = omega_n**2 / (s**2 + 2 * zeta * omega_n * s + omega_n**2)
    real, imag = (G.subs(s, I * omega) - 1).as_real_imag()
    assert is_zero(expand(d.relative_real - real, complex=True))
    assert is_zero(expand(d.relative_imag - imag, complex=True))


def test_a_lag_on_a_mass_spring_damper_by_hand() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    # dH = -j w/(w_c + j w) (k - m w^2 + j b w)
    below = omega_c**2 + omega**2
    assert is_zero(d.real - omega**2 * (b * omega_c - k + m * omega**2) / below)
    assert is_zero(d.imag + omega * (omega_c * (k - m * omega**2) + b * omega**2) / below)
    assert is_zero(d.ratio_real**2 - d.real**2 / ((k - m * omega**2) ** 2 + b**2 * omega**2))


def test_a_shunt_and_a_compliance_by_hand() -> None:
    K = hs.symbols("K")
    assert hs.distort(kelvin_voigt(k, b), shunt(m=m)).distortion == m * s**2
    d = hs.distort(kelvin_voigt(k, b), compliance(k=K))
    assert is_zero(d.perceived - 1 / (1 / (k + b * s) + 1 / K))


def test_properties_are_those_of_section_2_3() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), series("2"))
    felt, X = d.environment_properties, Symbol("X")
    assert is_zero(felt.stiffness - (k - m * omega**2))
    assert is_zero(felt.mass - (m - k / omega**2))
    assert is_zero(felt.damping - b)
    assert is_zero(felt.spring_inertia_force - X * (k - m * omega**2))
    assert is_zero(felt.damping_force - I * X * b * omega)
    assert is_zero(d.perceived_properties.damping - 2 * b)


def test_the_least_noticeable_parameter_moves_the_dynamics_by_the_threshold() -> None:
    c = hs.symbols("c")
    d = hs.distort(mass_spring_damper(m, b, k))
    least = d.parameter_jnd(c)
    modulus = sqrt((k - m * omega**2) ** 2 + (b * omega) ** 2)
    H = m * s**2 + b * s + k
    for symbol, change in ((k, least.stiffness), (b, least.damping), (m, least.mass)):
        moved = expand(H.subs(symbol, symbol + change) - H)
        assert is_zero(moved.subs(s, I * omega) * moved.subs(s, -I * omega) - (c * modulus) ** 2)


def test_changeovers_in_closed_form_are_where_the_evaluation_finds_them() -> None:
    environment = mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    d = hs.distort(environment, second_order_lowpass(80, 0.5))
    result = hs.evaluate(hs.Scene(environment, (second_order_lowpass(80, 0.5),)))
    assert float(d.changeover_environment) == float(result.changeovers_environment[0].omega)
    assert float(d.changeover_perceived) == pytest.approx(float(result.changeovers_perceived[0].omega), rel=1e-14)


def test_the_changeover_of_the_perceived_dynamics_with_symbols_makes_its_real_part_vanish() -> None:
    d = hs.distort(mass_spring_damper(m, b, k), first_order_lag(omega_c))
    found = d.changeover_perceived
    assert found is not None
    # Re H_perc = w_c (w_c (k - m W) + b W)/(w_c^2 + W): zero at W = w_c k/(w_c m - b)
    assert is_zero(found**2 - omega_c * k / (omega_c * m - b))
