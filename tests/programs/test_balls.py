"""Balls and magnitudes, operation by operation: what they hold, on thousands of wide operands, and that it is hardly more."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction
from math import frexp, inf, ldexp, log2, nan
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq
from sympy import Symbol

from haptisym.programs import magnitudes
from haptisym.programs.balls import FUNCTIONS, BallPoint, nearest_double
from haptisym.programs.magnitudes import MagnitudeRange, judge
from haptisym.programs.program import Writer

MP = mpmath.mp.clone()
MP.dps = 200
LONG = mpmath.mp.clone()  # for what cancels
LONG.dps = 600
WIDTHS = (0, 1e-30, 1e-12, 1e-3, 0.3, 1, 1.7)  # relative: beyond 1 the ball holds 0


def exactly(x: Fraction) -> Any:
    return MP.mpf(x.numerator) / x.denominator


def holds(ball: arb, value: Any) -> bool:
    """Whether a ball holds a number of 200 digits, or the exact rational that it is."""
    with flint.ctx.workprec(1200):
        if isinstance(value, Fraction):
            return bool(ball.contains(fmpq(value.numerator, value.denominator)))
        if not value:
            return bool(ball.contains(0))
        mantissa, exponent = value.man_exp
        middle = arb(int(mantissa)) * arb(2) ** int(exponent) * (1 if value > 0 else -1)
        return bool(ball.overlaps(arb(middle, abs(middle) * arb(2) ** -600)))


def operand(draw: random.Random, decades: int) -> tuple[arb, list[Fraction]]:
    """A ball of dyadic ends and points of it: both ends, the middle, 0 if it is in it."""
    middle = Fraction(draw.choice((-1, 1)) * draw.randrange(2**29, 2**30), 2**30) * Fraction(2) ** draw.randint(
        -decades, decades
    )
    radius = Fraction(float(abs(middle))) * Fraction(draw.choice(WIDTHS))
    if draw.random() < 0.05:
        middle = Fraction(0)
    with flint.ctx.workprec(600):
        ball = arb(fmpq(middle.numerator, middle.denominator), fmpq(radius.numerator, radius.denominator))
        radius = Fraction(float(ball.rad()))
    ends = [middle - radius, middle, middle + radius, middle + radius / 3]
    return ball, ends + [Fraction(0)] * (ends[0] < 0 < ends[2])


def power(x: Any, y: Any) -> Any:
    return x**y if x else MP.mpf(0)


def sincm1(x: Any) -> Any:
    return MP.mpf((LONG.sin(x) - x) / x) if x else MP.mpf(0)


UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": lambda x: -x,
    "abs": abs,
    "sqrt": MP.sqrt,
    "cos": MP.cos,
    "sin": MP.sin,
    "sinc": lambda x: MP.sin(x) / x if x else MP.mpf(1),
    "sincm1": sincm1,
}
BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
}


@pytest.mark.parametrize("name", UNARY)
def test_functions_of_wide_balls_hold_those_of_all_their_points(name: str) -> None:
    draw = random.Random(name)
    for _ in range(400):
        x, points = operand(draw, 40 if name in ("neg", "abs", "sqrt") else 8)
        with flint.ctx.workprec(draw.choice((53, 120, 300))):
            found = FUNCTIONS[name](x)
        for point in points:
            if name != "sqrt" or point >= 0:
                assert holds(found, UNARY[name](exactly(point))), (x, point)


@pytest.mark.parametrize("name", BINARY)
def test_sums_products_and_quotients_of_wide_balls_hold_those_of_all_pairs(name: str) -> None:
    draw = random.Random(name)
    for _ in range(500):
        (x, points), (y, others) = operand(draw, 40), operand(draw, 40)
        with flint.ctx.workprec(draw.choice((53, 120, 300))):
            found = FUNCTIONS[name](x, y)
        for a in points:
            for b in others:
                if name != "div" or b:
                    assert holds(found, BINARY[name](a, b)), (x, y, a, b)


def test_powers_of_wide_positive_balls_hold_those_of_all_their_points() -> None:
    draw = random.Random(7)
    assert FUNCTIONS["power"](arb(0), arb("0.5")) == 0
    for _ in range(500):
        x, points = operand(draw, 20)
        if min(points) <= 0:
            continue
        exponent = Fraction(draw.randrange(1, 64), 64)
        found = FUNCTIONS["power"](x, arb(fmpq(exponent.numerator, exponent.denominator)))
        assert found.is_finite()
        for point in points:
            assert holds(found, power(exactly(point), exactly(exponent)))


@pytest.mark.parametrize("radius", [1e-30, 1e-3, 0.1])
def test_around_0_sin_x_over_x_less_one_is_between_minus_a_sixth_of_the_square_and_0(radius: float) -> None:
    found = FUNCTIONS["sincm1"](arb(0, radius))
    least = sincm1(MP.mpf(radius))
    assert float(found.upper()) <= radius**2 * 1e-6
    assert holds(found, least)
    assert float(found.lower()) >= float(least) * 1.001


@pytest.mark.parametrize("exponent", [0, -1, -3, -30, -150, -400])
@pytest.mark.parametrize("sign", [1, -1])
def test_sin_x_over_x_less_one_keeps_its_digits_in_balls(exponent: int, sign: int) -> None:
    for mantissa in (0.5, 0.75, 0.999):
        with flint.ctx.workprec(100):
            found = FUNCTIONS["sincm1"](arb(sign * ldexp(mantissa, exponent)))
        assert found.rel_accuracy_bits() >= 90
        assert holds(found, sincm1(MP.mpf(sign * ldexp(mantissa, exponent))))


def test_balls_of_a_program_hold_its_results_at_its_doubles_and_tighten_with_the_bits() -> None:
    x, y = Symbol("x"), Symbol("y")
    write = Writer((x, y))
    a, b, third = write.input(x), write.input(y), write.constant(fmpq(1, 3))
    program = write.program(
        {"f": write.div(write.add(write.mul(a, b), third), write.sub(a, b)), "g": write.mul(third, a)}
    )
    draw = random.Random(3)
    for _ in range(200):
        p, q = (draw.uniform(-1, 1) * 10.0 ** draw.randint(-30, 30) for _ in "xy")
        exact_a, exact_b = Fraction(p), Fraction(q)
        for bits in (53, 200, 400):
            found = BallPoint(program, (p, q)).balls(bits)
            assert holds(found["f"], (exact_a * exact_b + Fraction(1, 3)) / (exact_a - exact_b))
            assert holds(found["g"], exact_a / 3)
            assert found["g"].rel_accuracy_bits() >= bits - 4


def test_a_nearest_double_is_nearest_to_every_number_of_its_ball() -> None:
    draw = random.Random(11)
    decided = 0
    for _ in range(3000):
        middle = Fraction(draw.randrange(2**80)) * Fraction(2) ** draw.randint(-160, 80) * draw.choice((-1, 1))
        with flint.ctx.workprec(400):
            ball = arb(
                fmpq(middle.numerator, middle.denominator),
                abs(float(middle)) * draw.choice((1e-40, 1e-20, 3e-17, 1e-15)),
            )
        found = nearest_double(ball, 100)
        with flint.ctx.workprec(400):
            ends = [
                Fraction(*map(int, (e.numer(), e.denom())))
                for e in (z.mid().fmpq() for z in (ball.lower(), ball.upper()))
            ]
        if found is not None:
            decided += 1
            assert all(float(x) == found for x in ends)
        else:
            assert float(ends[0]) != float(ends[1])
    assert decided > 1000
    assert nearest_double(arb(nan), 53) is nearest_double(arb("1", "inf"), 53) is None


def test_halfway_between_two_doubles_is_given_up_only_when_many_bits_see_a_dot_there() -> None:
    with flint.ctx.workprec(2000):
        tie = arb(1) + arb(2) ** -53
        dots = {bits: tie + arb(0, arb(2) ** -bits) for bits in (60, 190, 210, 390, 1000)}
    assert nearest_double(dots[1000], 1000) in (1.0, 1.0 + 2.0**-52)
    assert nearest_double(dots[390], 401) in (1.0, 1.0 + 2.0**-52)
    assert nearest_double(dots[210], 401) in (1.0, 1.0 + 2.0**-52)
    assert nearest_double(dots[190], 1000) is nearest_double(dots[60], 1000) is None
    assert nearest_double(dots[390], 400) is None


# Magnitudes: 2^low <= abs(x) <= 2^high for every step.


def between(draw: random.Random, of: MagnitudeRange) -> list[float]:
    """Numbers of a range: both ends of either sign that it has, something inside, and 0 where that may be."""
    sizes = [2.0**of.low, 2.0**of.high, 2.0 ** draw.uniform(of.low, of.high)]
    return [*sizes, *(() if of.positive else (-x for x in sizes)), *(() if of.nonzero else (0.0,))]


def drawn(draw: random.Random, low: int = -90, high: int = 90) -> MagnitudeRange:
    a, b = sorted(float(draw.randint(low, high)) for _ in "ab")
    return MagnitudeRange(a, b, draw.random() < 0.5, draw.random() < 0.5)


def bits_of(value: Any) -> float:
    """The binary logarithm of a size, a power of two exactly."""
    mantissa, exponent = mpmath.frexp(abs(value))
    return exponent + log2(mantissa)


def assert_in(of: MagnitudeRange, value: Any) -> None:
    if value:
        assert of.low <= bits_of(value) <= of.high, (of, value)
    else:
        assert not of.nonzero, (of, value)
    assert value >= 0 or not of.positive, (of, value)


@pytest.mark.parametrize("name", ["add", "sub", "mul", "div"])
@pytest.mark.parametrize("digits", [53, 100])
@pytest.mark.parametrize("times", [40, pytest.param(400, marks=pytest.mark.slow)])
def test_the_range_of_a_step_holds_what_floats_make_of_all_in_its_operands(name: str, digits: int, times: int) -> None:
    draw, context = random.Random(f"{name} {digits}"), mpmath.mp.clone()
    context.prec = digits
    widest = 0.0
    for _ in range(times):
        x, y = drawn(draw), drawn(draw)
        found = magnitudes._step(name, (0, 1), (x, y), digits)
        made = []
        for a in between(draw, x):
            for b in between(draw, y):
                if name != "div" or b:
                    made.append(BINARY[name](context.mpf(a), context.mpf(b)))
                    assert_in(found, made[-1])
        sizes = [bits_of(z) for z in made if z]
        widest = max(widest, found.high - max(sizes))
        if name in ("mul", "div"):
            widest = max(widest, min(sizes) - found.low)
            assert found.nonzero == (x.nonzero if name == "div" else x.nonzero and y.nonzero)
            assert found.positive == (x.positive and y.positive)
    assert widest <= 1.6


def test_a_difference_of_near_floats_may_be_as_small_as_their_last_place() -> None:
    for digits in (53, 100):
        x = MagnitudeRange(0.0, 1.0)
        found = magnitudes._step("sub", (0, 1), (x, x), digits)
        assert found == MagnitudeRange(-digits - 1, 2.0)  # one place more, for pairs of doubles with a gap between them
        assert magnitudes._step("sub", (0, 1), (x, MagnitudeRange(-4.0, -2.0)), digits) == MagnitudeRange(
            -4.0 - digits - 1, 2.0
        )


def test_a_sum_of_what_is_not_negative_loses_nothing_and_a_square_is_not_negative() -> None:
    x, y = MagnitudeRange(-3.0, 5.0, positive=True), MagnitudeRange(-7.0, 2.0, positive=True, nonzero=True)
    assert magnitudes._step("add", (0, 1), (x, y), 53) == MagnitudeRange(-7.0, 6.0, positive=True, nonzero=True)
    assert magnitudes._step("add", (0, 1), (x, x), 53) == MagnitudeRange(-3.0, 6.0, positive=True)
    assert magnitudes._step("add", (0, 1), (x, y._replace(positive=False)), 53).low < -7.0 - 53
    z = MagnitudeRange(-4.0, 3.0)
    assert magnitudes._step("mul", (2, 2), (z, z), 53) == MagnitudeRange(-8.0, 6.0, positive=True)
    assert not magnitudes._step("mul", (2, 3), (z, z), 53).positive


@pytest.mark.slow
@pytest.mark.parametrize("name", ["neg", "abs", "sqrt", "sin", "cos", "sinc", "sincm1"])
def test_the_range_of_a_function_holds_it(name: str) -> None:
    draw = random.Random(name)
    for _ in range(800):
        x = drawn(draw, -60, 300)
        found = magnitudes._step(name, (0,), (x,), 53)
        for a in between(draw, x):
            if name != "sqrt" or a >= 0:
                assert_in(found, UNARY[name](MP.mpf(a)))
        if name == "sqrt":
            assert found.high - found.low <= (x.high - x.low) / 2 + 2
        if name in ("neg", "abs"):
            assert found[:2] == x[:2]
            assert found.nonzero == x.nonzero


def test_the_smallest_cosine_of_a_double_is_in_its_range() -> None:
    worst = 6381956970095103.0 * 2.0**797  # the double nearest to a multiple of pi/2: the cosine is 2^-60.9
    size = float(MP.log(abs(mpmath_cosine(worst)), 2))
    found = magnitudes._step("cos", (0,), (MagnitudeRange(800.0, 850.0),), 53)
    assert found.low <= size < -60
    assert found.low >= -72
    assert found.high == 0


def mpmath_cosine(x: float) -> Any:
    context = mpmath.mp.clone()
    context.dps = 400
    return context.cos(x)


@pytest.mark.parametrize("exponent", [0.01, 0.5, 0.99])
def test_the_range_of_a_power_holds_it(exponent: float) -> None:
    draw = random.Random(str(exponent))
    for _ in range(400):
        x = drawn(draw)._replace(positive=True)
        found = magnitudes._step("power", (0, 1), (x, MagnitudeRange(-1.0, 0.0, positive=True, nonzero=True)), 53)
        for a in between(draw, x):
            assert_in(found, power(MP.mpf(a), MP.mpf(exponent)))
        assert found.high <= max(x.high, 0)
        assert found.low >= min(x.low, 0)


def test_the_range_of_given_numbers_is_theirs_within_a_bit() -> None:
    draw = random.Random(5)
    pool = [0.0, 5e-324, 2.0**-1022, 1e-300, 0.1, 0.5, 1.0, 2.0, 3.7, 1e300, 1.7e308]
    for _ in range(2000):
        given = np.array([draw.choice(pool) * draw.choice((1, -1, 1)) for _ in range(draw.randint(1, 4))])
        found = magnitudes._of_array(given)
        sizes = [frexp(abs(float(v)))[1] for v in given if v]
        for v in given:
            assert_in(found, MP.mpf(float(v)))
        if sizes:
            assert found.low == min(sizes) - 1
            assert found.high == max(sizes)
            assert found.positive == bool((given >= 0).all())
            assert found.nonzero == bool((given > 0).all() or (given < 0).all())


def test_what_has_no_size_has_no_range_and_zeros_have_that_of_one() -> None:
    for bad in ([inf], [1.0, inf], [-inf, 2.0], [nan], [1.0, nan]):
        assert magnitudes._of_array(np.array(bad)) == MagnitudeRange(-inf, inf)
    for zeros in ([0.0], [0.0, -0.0], []):
        assert magnitudes._of_array(np.array(zeros)) == MagnitudeRange(0.0, 0.0, positive=True)


@pytest.mark.parametrize("size", [200.0, 499.0, 501.0, 600.0])
def test_a_program_is_safe_up_to_the_limit_and_not_beyond(size: float) -> None:
    x = Symbol("x")
    write = Writer((x,))
    for program, at in (
        (write.program({"y": write.mul(write.input(x), write.input(x))}), 2.0 ** (size / 2)),
        (write.program({"y": write.mul(write.input(x), write.input(x))}), 2.0 ** (-size / 2)),
        (write.program({"y": write.input(x)}), 2.0**size),
    ):
        assert judge(program, [at], 53, 510).safe == (size < 505)
        assert judge(program, [np.array([at, 1.0])], 53, 510).finite == (size < 505)
