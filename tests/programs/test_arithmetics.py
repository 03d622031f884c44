"""One straight-line program in every arithmetic that runs it: balls, double-doubles, power series, steps on a page, code."""

from __future__ import annotations

import operator
import random
import re
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import product
from math import ceil, ldexp, log2, nan
from random import Random
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from chainballs import truth
from flint import acb, acb_series, arb, fmpq
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from sympy import Expr, Float, I, Rational, Symbol, cos, exp, pi, sin, sinc, symbols

import haptisym as hs
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.rings import omega, s
from haptisym.model.catalogue import EFFECTS, ENVIRONMENTS
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.programs import certified as doubled
from haptisym.programs.balls import FUNCTIONS, BallPoint, nearest_double
from haptisym.programs.certified import BLOCK, Doubled, Doubles, add, div, fast_two_sum, of_ball, two_product, two_sum
from haptisym.programs.distortion import closed_program
from haptisym.programs.floats import Floats, judge
from haptisym.programs.links import BALL_SERIES, CHANGE, FELT, FLOATS, InSteps, along_axis, links, series_arithmetic
from haptisym.programs.program import Operation, Program, Writer, sincm1
from haptisym.programs.steps import Steps, page_steps
from haptisym.programs.values import Values
from haptisym.writing.code import DIALECTS, CodeReader, Language, closed

a, b, x0 = symbols("a b x0")
X, Y, Z = Symbol("X"), Symbol("Y"), Symbol("Z")


# Balls

DIGITS200, DIGITS600 = mpmath.mp.clone(), mpmath.mp.clone()  # the second for what cancels
DIGITS200.dps, DIGITS600.dps = 200, 600

WIDTHS = (0, 1e-30, 1e-12, 1e-3, 0.3, 1, 1.7)  # relative: beyond 1 the ball holds 0


def in_mp(x: Fraction) -> Any:
    return DIGITS200.mpf(x.numerator) / x.denominator


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
    return x**y if x else DIGITS200.mpf(0)


def sinc_less_one(x: Any) -> Any:
    return DIGITS200.mpf((DIGITS600.sin(x) - x) / x) if x else DIGITS200.mpf(0)


UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": lambda x: -x,
    "abs": abs,
    "sqrt": DIGITS200.sqrt,
    "cos": DIGITS200.cos,
    "sin": DIGITS200.sin,
    "sinc": lambda x: DIGITS200.sin(x) / x if x else DIGITS200.mpf(1),
    "sincm1": sinc_less_one,
}

BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
}


@pytest.mark.dear("sincm1")
@pytest.mark.parametrize("name", UNARY)
def test_functions_of_wide_balls_hold_those_of_all_their_points(name: str) -> None:
    draw = random.Random(name)
    for _ in range(120):
        x, points = operand(draw, 40 if name in ("neg", "abs", "sqrt") else 8)
        with flint.ctx.workprec(draw.choice((53, 120, 300))):
            found = FUNCTIONS[name](x)
        for point in (p for p in points if name != "sqrt" or p >= 0):
            assert holds(found, UNARY[name](in_mp(point))), (x, point)


@pytest.mark.parametrize("name", BINARY)
def test_sums_products_and_quotients_of_wide_balls_hold_those_of_all_pairs(name: str) -> None:
    draw = random.Random(name)
    for _ in range(150):
        (x, points), (y, others) = operand(draw, 40), operand(draw, 40)
        with flint.ctx.workprec(draw.choice((53, 120, 300))):
            found = FUNCTIONS[name](x, y)
        for p, q in product(points, [y for y in others if name != "div" or y]):
            assert holds(found, BINARY[name](p, q)), (x, y, p, q)


def test_powers_of_wide_positive_balls_hold_those_of_all_their_points() -> None:
    draw = random.Random(7)
    assert FUNCTIONS["power"](arb(0), arb("0.5")) == 0
    for x, points in (operand(draw, 20) for _ in range(250)):
        if min(points) > 0:
            exponent = Fraction(draw.randrange(1, 64), 64)
            found = FUNCTIONS["power"](x, arb(fmpq(exponent.numerator, exponent.denominator)))
            assert found.is_finite()
            assert all(holds(found, power(in_mp(point), in_mp(exponent))) for point in points)


@pytest.mark.parametrize("radius", [1e-30, 1e-3, 0.1])
def test_around_0_sin_x_over_x_less_one_is_between_minus_a_sixth_of_the_square_and_0(radius: float) -> None:
    found = FUNCTIONS["sincm1"](arb(0, radius))
    least = sinc_less_one(DIGITS200.mpf(radius))
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
        assert holds(found, sinc_less_one(DIGITS200.mpf(sign * ldexp(mantissa, exponent))))


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
    for _ in range(1000):
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
    assert decided > 300
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


# How large and small steps may be


def size(value: Any) -> float:
    """The binary logarithm of a number's size, a power of two exactly."""
    mantissa, exponent = mpmath.frexp(abs(value))
    return exponent + log2(mantissa)


@pytest.mark.dear("div", "mul", "sqrt")
@pytest.mark.parametrize("name", [*UNARY, *BINARY, "power"])
def test_a_step_is_safe_only_where_no_result_over_or_underflows(name: str) -> None:
    """Of all pairs of the numbers given, in floats of that many digits; of what multiplies and divides little is given away."""
    draw = random.Random(name)
    pair = name in BINARY or name == "power"
    program = Program(
        (X, Y),
        (Operation("input", (0,)), Operation("input", (1,)), Operation(name, (0, 1) if pair else (0,))),
        {"it": 2},
    )
    for digits in (53, 100) * 10:
        xs, ys = (numbers_of(draw, 4) for _ in range(2))
        ys = [draw.uniform(0.01, 0.99)] if name == "power" else ys if pair else [1.0]
        xs = [abs(x) for x in xs] if name in ("sqrt", "power") else xs
        context = mpmath.mp.clone()
        context.prec = digits if name in BINARY else 200
        function = BINARY.get(name) or (power if pair else lambda x, _: UNARY[name](x))
        made = [function(context.mpf(x), context.mpf(y)) for x in xs for y in ys if y or name != "div"]
        most = max(abs(size(z)) for z in (*made, *xs, *ys) if z)
        given = [np.array(xs), np.array(ys)]
        assert not judge(program, given, digits, ceil(most) - 1).safe
        if name in ("mul", "div", "neg", "abs", "sqrt"):
            found = judge(program, given, digits, ceil(most) + 4)
            assert found.safe
            assert found.finite == (name != "div" or min(ys) > 0 or max(ys) < 0)


def numbers_of(draw: random.Random, count: int) -> list[float]:
    """Of all sizes up to 2^59 and from 2^-59 on; of one sign or of both, sometimes with 0 among them, and neighbours."""
    low, high = sorted(draw.randint(-59, 59) for _ in "ab")
    found = [2.0 ** draw.uniform(low, high) * draw.choice([1, 1, -1]) for _ in range(count - 1)]
    return [*found, draw.choice([0.0, float(np.nextafter(found[0], 0)), 2.0**low])]


def test_the_smallest_cosine_of_a_double_is_reckoned_with() -> None:
    """6381956970095103 2^797 is nearest to a multiple of pi/2: its cosine is 2^-60.9, and 17 such factors are no double."""
    write = Writer((X,))
    program = write.program({"it": write.power(write.expression(cos(X)), 17)})
    assert not judge(program, [6381956970095103.0 * 2.0**797], 53, 1020).safe


# Double-doubles


COUNT = 600


def operands(seed: int, *, below: float = 1.0) -> Doubled:
    """Numbers of all sizes and signs with low parts up to half a unit; a quarter with no error, the others up to that wide."""
    rng = np.random.default_rng(seed)
    exponents = np.concatenate(
        [
            rng.integers(low, high, COUNT // 5)
            for low, high in ((-3, 4), (-60, 60), (-480, 480), (-540, -500), (-1074, -960))
        ]
    )
    hi = np.ldexp(rng.uniform(1, 2, COUNT) * rng.choice([-1, 1], COUNT), exponents)
    hi[rng.random(COUNT) < 0.04] = 0.0
    hi[rng.random(COUNT) < 0.1] = rng.choice([1.0, -1.0, 3.0, 2.0**-30, 1 + 2.0**-52])
    lo = rng.choice([0.0, 0.5, -0.5, 0.3, -0.01], COUNT) * np.where(hi == 0, 0.0, np.spacing(np.abs(hi)))
    error = np.abs(hi) * below * 10.0 ** rng.choice([0, -1, -3, -9, -17, -25], COUNT)
    error[rng.random(COUNT) < 0.25] = 0.0
    order = rng.permutation(COUNT)
    return Doubled(hi[order], lo[order], error[order])


def close_to(x: Doubled, seed: int) -> Doubled:
    """Opposites of them up to a few units of the last place of either part: sums cancel."""
    rng = np.random.default_rng(seed)
    hi = -x.hi * (1 + rng.choice([0.0, 2.0**-52, -(2.0**-51), 2.0**-20, 1.0], COUNT))
    return Doubled(hi, -x.lo * rng.choice([1, 0, -1], COUNT), x.error * rng.choice([0, 1, 1e-6], COUNT))


def in_fmpq(x: float) -> fmpq:
    return fmpq(*float(x).as_integer_ratio())


def ends(x: Doubled, n: int) -> tuple[fmpq, fmpq]:
    middle, error = in_fmpq(x.hi[n]) + in_fmpq(x.lo[n]), in_fmpq(x.error[n])
    return middle - error, middle + error


def deviations(found: Doubled, n: int, truths: list[fmpq]) -> fmpq:
    """How far the result lies from the furthest of these."""
    middle = in_fmpq(found.hi[n]) + in_fmpq(found.lo[n])
    return max(abs(middle - truth) for truth in truths)


PLAIN = {"add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y, "div": lambda x, y: x / y}

SLACK, OWN, LOST = fmpq(1001, 1000), fmpq(1, 2**99), fmpq(1, 2**1058)


@pytest.mark.dear("add-any", "mul-any", "sub-close")
@pytest.mark.parametrize("second", ["any", "close"])
@pytest.mark.parametrize("name", PLAIN)
def test_bounds_hold_at_the_corners_of_thousands_of_operands_and_are_not_much_wider(name: str, second: str) -> None:
    x = operands(1)
    y = close_to(x, 3) if second == "close" else operands(2, below=0.4 if name == "div" else 1.0)
    with np.errstate(all="ignore"):
        found = getattr(doubled, name)(x, y)
    bounded = 0
    for n in range(COUNT):
        (a, b), (c, d) = ends(x, n), ends(y, n)
        if not np.isfinite(found.error[n]):
            overflows = max(abs(q) for q in (a, b)) * (max(abs(q) for q in (c, d)) if name == "mul" else 1) > 2**900
            nothing = name == "div" and (c <= 2 * in_fmpq(y.error[n]) or d >= -2 * in_fmpq(y.error[n]))
            assert overflows or nothing or (name == "div" and abs(in_fmpq(y.hi[n])) < fmpq(1, 2**900)), n
            continue
        bounded += 1
        corners = [PLAIN[name](p, q) for p in (a, b) for q in (c, d)]
        away, bound = deviations(found, n, corners), in_fmpq(found.error[n])
        assert away <= bound, n
        size, of = abs(in_fmpq(found.hi[n])), (in_fmpq(x.error[n]), in_fmpq(y.error[n]))
        if name == "div":
            below = abs(in_fmpq(y.hi[n])) - 2 * of[1]
            widest = (of[0] + size * of[1] + LOST) / below
        elif name == "mul":
            widest = abs(in_fmpq(x.hi[n])) * of[1] + abs(in_fmpq(y.hi[n])) * of[0] + of[0] * of[1]
        else:
            widest = of[0] + of[1]
        assert bound <= widest * SLACK + size * OWN + LOST, n
    assert bounded > 0.6 * COUNT


def test_bounds_of_roots_hold_at_both_ends_and_are_at_most_twice_too_wide() -> None:
    x = operands(5, below=0.45)
    x = Doubled(np.abs(x.hi), np.where(x.hi == 0, 0.0, x.lo), x.error)
    with np.errstate(all="ignore"):
        found = doubled.sqrt(x)
    bounded = 0
    for n in range(COUNT):
        low, high = ends(x, n)
        if not np.isfinite(found.error[n]):
            assert low <= in_fmpq(x.error[n]) + LOST, n
            continue
        bounded += 1
        middle, bound = in_fmpq(found.hi[n]) + in_fmpq(found.lo[n]), in_fmpq(found.error[n])
        assert max(fmpq(0), middle - bound) ** 2 <= low, n
        assert high <= (middle + bound) ** 2, n
        # (sqrt(x) + b)^2 - x = 2 sqrt(x) b + b^2, b at most twice what the ends need
        assert bound <= 2 * SLACK * (in_fmpq(x.error[n]) + LOST) / middle + middle * OWN + LOST, n
    assert bounded > 0.7 * COUNT


def test_magnitudes_and_opposites_keep_the_error_and_drop_or_turn_the_sign() -> None:
    x = operands(6)
    turned, size = doubled.neg(x), doubled.absolute(x)
    for n in range(COUNT):
        low, high = ends(x, n)
        assert ends(turned, n) == (-high, -low)
        assert ends(size, n) == ((low, high) if x.hi[n] >= 0 else (-high, -low))


def test_sums_and_products_of_any_two_doubles_that_neither_over_nor_underflow_are_exact() -> None:
    rng = np.random.default_rng(8)
    a, b = (np.ldexp(rng.uniform(-2, 2, 1500), rng.integers(-400, 400, 1500)) for _ in range(2))
    b[::3] = -a[::3] * (1 + rng.integers(-4, 5, len(a[::3])) * 2.0**-52)
    for pair, of in ((two_sum(a, b), PLAIN["add"]), (two_product(a, b), PLAIN["mul"]), (two_product(a, a), None)):
        for z, e, x, y in zip(*pair, a, b, strict=True):
            assert in_fmpq(z) + in_fmpq(e) == (of(in_fmpq(x), in_fmpq(y)) if of else in_fmpq(x) ** 2)
            assert abs(e) <= np.spacing(abs(z)) / 2
    large, small = np.where(abs(a) >= abs(b), a, b), np.where(abs(a) >= abs(b), b, a)
    for z, e, x, y in zip(*fast_two_sum(large, small), a, b, strict=True):
        assert in_fmpq(z) + in_fmpq(e) == in_fmpq(x) + in_fmpq(y)


@given(st.fractions(-(10**9), 10**9), st.sampled_from([0, 1e-40, 1e-20, 1e-3, 0.9]), st.integers(-900, 900))
def test_a_ball_in_two_doubles_is_held_by_them_and_their_bound(x: Fraction, relative: float, exponent: int) -> None:
    with flint.ctx.workprec(140):
        ball = arb(fmpq(x.numerator, x.denominator)) * arb(1, relative) * arb(2) ** exponent
        hi, lo, error = map(in_fmpq, of_ball(ball))
    low, high = _dyadic(ball.mid()) - _dyadic(ball.rad()), _dyadic(ball.mid()) + _dyadic(ball.rad())
    assert hi + lo - error <= low
    assert high <= hi + lo + error
    assert error <= (high - low) / 2 * SLACK + abs(hi) * OWN + LOST


@pytest.mark.parametrize("exponent", [-1060, -1073, -1076, -1100, -9999])
def test_a_number_beside_the_smallest_doubles_is_held_by_them_and_their_bound(exponent: int) -> None:
    hi, lo, error = map(in_fmpq, of_ball(3 * arb(2) ** exponent))
    assert abs(3 * fmpq(2) ** exponent - hi - lo) <= error


def _dyadic(x: arb) -> fmpq:
    mantissa, exponent = x.man_exp()
    return fmpq(int(mantissa)) * fmpq(2) ** int(exponent)


def test_what_is_no_number_or_beyond_doubles_has_no_bound() -> None:
    for ball in (arb("nan"), arb(2) ** 1100, -(arb(2) ** 1100), arb(1) / arb(0)):
        hi, lo, error = of_ball(ball)
        assert np.isnan(hi)
        assert np.isnan(lo)
        assert error == np.inf


def every_function() -> Program:
    """One program that takes every step there is; Z is to be the size of Y."""
    write = Writer((X, Y, Z))
    x, y = write.input(X), write.input(Y)
    size = write.abs(x)
    third = write.expression(Rational(1, 3))
    circle = write.expression(pi)
    power = write.expression(Z ** Rational(3, 10))
    given = {
        "sum": write.add(x, y), "difference": write.sub(x, y), "product": write.mul(x, y), "quotient": write.div(x, y),
        "opposite": write.neg(x), "size": size, "root": write.sqrt(size), "third": write.mul(x, third),
        "circle": write.sub(write.mul(y, circle), x), "cos": write.expression(cos(X)), "sin": write.expression(sin(X * Y)),
        "sinc": write.expression(sinc(X)), "sincm1": write.expression(sincm1(X)), "power": power, "pi": circle, "input": x,
    }  # fmt: skip
    return write.program(given)


def truths(x: float, y: float) -> dict[str, object]:
    a, b = DIGITS200.mpf(x), DIGITS200.mpf(y)
    return {
        "sum": a + b, "difference": a - b, "product": a * b, "quotient": a / b, "opposite": -a, "size": abs(a),
        "root": DIGITS200.sqrt(abs(a)), "third": a / 3, "circle": b * DIGITS200.pi - a, "cos": DIGITS200.cos(a), "sin": DIGITS200.sin(a * b),
        "sinc": DIGITS200.sinc(a), "sincm1": DIGITS200.sinc(a) - 1, "power": abs(b) ** (DIGITS200.mpf(3) / 10), "pi": +DIGITS200.pi, "input": a,
    }  # fmt: skip


def points(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(11)
    x, y = (
        np.ldexp(rng.uniform(1, 2, count), rng.integers(-40, 12, count)) * rng.choice([-1, 1], count) for _ in range(2)
    )
    y[::5] = x[::5] / np.pi  # where the difference of both cancels
    return x, y


def test_every_step_of_a_program_in_double_doubles_is_held_by_its_bound_and_nearly_sharp() -> None:
    program = every_function()
    x, y = points(12)
    bounded, plain = (Doubles(program, bounded=b).run([x, y, abs(y)], x.size) for b in (True, False))
    for name, found in bounded.items():
        assert (found.hi == plain[name].hi).all()
        assert (abs(found.lo - plain[name].lo) <= abs(found.hi) * 2.0**-99).all()
        assert np.isnan(plain[name].error).all()
        for n in range(x.size):
            true = truths(x[n], y[n])[name]
            away = abs(DIGITS200.mpf(found.hi[n]) + DIGITS200.mpf(found.lo[n]) - true)
            assert away <= DIGITS200.mpf(found.error[n]), (name, n)
            size = abs(x[n]) + abs(y[n]) if name in ("sum", "difference", "circle") else abs(true)
            # a sine of a product knows its angle to 2^-100 of it
            size += abs(x[n] * y[n]) if name == "sin" else 0
            assert found.error[n] <= 8 * size * DIGITS200.mpf(2) ** -100 + DIGITS200.mpf(2) ** -1000, (name, n)


@pytest.mark.parametrize("size", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 7])
def test_blocks_of_double_doubles_change_nothing(size: int) -> None:
    write = Writer((X, Y))
    program = write.program(
        {"q": write.div(write.add(write.input(X), write.constant(1)), write.input(Y)), "x": write.input(X)}
    )
    x, y = np.random.default_rng(size).uniform(1, 2, (2, size))
    found = Doubles(program, bounded=True).run([x, y], size)
    hi = div(add(Doubled(x, 0 * x, 0 * x), Doubled(1.0, 0.0, 0.0)), Doubled(y, 0 * y, 0 * y))
    for ours, theirs in zip(found["q"], hi, strict=True):
        assert (ours == theirs).all()
    assert (found["x"].hi == x).all()
    single = Doubles(program, bounded=True).run([x, 1.5], size)["q"]  # a number among arrays
    assert (single.hi == div(add(Doubled(x, 0 * x, 0 * x), Doubled(1.0, 0.0, 0.0)), Doubled(1.5, 0.0, 0.0)).hi).all()


@given(
    st.lists(st.sampled_from(["square", "add one", "less one", "invert", "root"]), max_size=6), st.floats(1e-300, 1e300)
)
def test_what_is_judged_safe_neither_overflows_nor_underflows(steps: list[str], at: float) -> None:
    write = Writer((X,))
    y = write.input(X)
    one = write.constant(1)
    for step in steps:
        y = {
            "square": lambda y: write.mul(y, y), "add one": lambda y: write.add(y, one), "less one": lambda y: write.sub(y, one),
            "invert": lambda y: write.div(one, y), "root": lambda y: write.sqrt(write.abs(y)),
        }[step](y)  # fmt: skip
    program = write.program({f"y{n}": n for n in range(len(write.operations))})
    if not judge(program, [at], 53, 1020).safe:
        return
    out = np.empty((len(program.results), 1))
    Floats(program).run([np.array([at])], 1, out)
    value = {step: float(out[n, 0]) for n, step in enumerate(program.results.values())}
    for i, step in enumerate(program.operations):
        assert value[i] == 0 or not np.isfinite(value[i]) or 2.0**-1020 <= abs(value[i]) <= 2.0**1020
        operands = [value[x] for x in step.arguments] if step.name in ("mul", "div") else []
        if operands and all(np.isfinite(operands)) and (step.name == "mul" or operands[1]):
            assert np.isfinite(value[i])  # nothing but a division by 0 makes infinity
            assert (value[i] == 0) == (operands[0] == 0 or (step.name == "mul" and operands[1] == 0))


# Power series over balls


TERMS = 5

TINY = DIGITS200.mpf(10) ** -40

Row = list[Any]


def times(x: Row, y: Row) -> Row:
    return [DIGITS200.fsum(x[i] * y[k - i] for i in range(k + 1)) for k in range(TERMS)]


def over(x: Row, y: Row) -> Row:
    found: Row = []
    for k in range(TERMS):
        found.append((x[k] - DIGITS200.fsum(found[i] * y[k - i] for i in range(k))) / y[0])
    return found


def exponential(x: Row) -> Row:
    found = [DIGITS200.exp(x[0])]
    for k in range(1, TERMS):  # f' = x' f
        found.append(DIGITS200.fsum(i * x[i] * found[k - i] for i in range(1, k + 1)) / k)
    return found


def mean(x: Row) -> Row:
    """(1 - exp(-x))/x, as the sum of (-x)^n/(n + 1)!."""
    total, power = [DIGITS200.mpc(0)] * TERMS, [DIGITS200.mpc(1)] + [DIGITS200.mpc(0)] * (TERMS - 1)
    for n in range(110):
        total = [a + b / DIGITS200.factorial(n + 1) for a, b in zip(total, power, strict=True)]
        power = times(power, [-c for c in x])
    return total


ON_SERIES: dict[str, tuple[Callable[..., Row], int]] = {
    "add": (lambda x, y: [a + b for a, b in zip(x, y, strict=True)], 2),
    "sub": (lambda x, y: [a - b for a, b in zip(x, y, strict=True)], 2),
    "mul": (times, 2),
    "div": (over, 2),
    "neg": (lambda x: [-a for a in x], 1),
    "exp": (exponential, 1),
    "phi": (mean, 1),
}


def middle_of(ball: Any) -> Any:
    mantissa, exponent = ball.mid().man_exp()
    return DIGITS200.mpf((int(mantissa), int(exponent)))


def holds_complex(ball: Any, value: Any) -> bool:
    """Whether a complex ball holds_complex a number, to within 1e-40 of its size."""
    slack = TINY * (1 + abs(value))
    return all(
        not part.is_finite() or abs(middle_of(part.mid()) - own) <= middle_of(part.rad()) + slack
        for part, own in ((ball.real, value.real), (ball.imag, value.imag))
    )


def series_operand(random: np.random.Generator, radius: float) -> tuple[Any, list[Any]]:
    """A series whose first coefficient is a ball, often near or around 0, and one of the series that it stands for."""
    middle = complex(*random.normal(0, random.choice([1e-3, 0.3, 3]), 2)) * random.choice([0, 1], p=[0.2, 0.8])
    shift = complex(*random.choice([-1.0, -0.6, 0.0, 1.0], 2)) * radius
    later = [complex(*random.normal(0, 2, 2)) for _ in range(TERMS - 1)]
    ball = acb(arb(middle.real, radius), arb(middle.imag, radius))
    own = DIGITS200.mpc(
        DIGITS200.mpf(middle.real) + DIGITS200.mpf(shift.real), DIGITS200.mpf(middle.imag) + DIGITS200.mpf(shift.imag)
    )
    return acb_series([ball, *map(acb, later)], prec=TERMS), [own, *map(DIGITS200.mpc, later)]


@pytest.mark.dear("phi")
@pytest.mark.parametrize("name", ON_SERIES)
def test_an_operation_holds_the_taylor_coefficients_at_every_point_of_its_operands(name: str) -> None:
    function, count = ON_SERIES[name]
    random = np.random.default_rng(sum(map(ord, name)))
    known = 0
    for _ in range(10 if name == "phi" else 60):
        radius = random.choice([0.0, 1e-12, 1e-3, 0.3, 2.0])
        pairs = [series_operand(random, radius) for _ in range(count)]
        if name == "div" and abs(pairs[1][1][0]) == 0:
            continue
        with series_arithmetic():
            found = BALL_SERIES[name](*(x for x, _ in pairs))
        true = function(*(own for _, own in pairs))
        assert all(holds_complex(found[k], DIGITS200.mpc(c)) for k, c in enumerate(true)), (pairs, true)
        known += all(found[k].is_finite() for k in range(TERMS))
    assert known > 5


def test_a_quotient_by_what_may_vanish_and_a_power_of_what_may_be_zero_are_unknown() -> None:
    with series_arithmetic():
        near = along_axis(arb(0.1, 0.2), TERMS)
        assert not BALL_SERIES["div"](acb(1), near)[0].is_finite()
        assert not BALL_SERIES["power"](near, acb(0.5))[0].is_finite()
        root = BALL_SERIES["power"](along_axis(arb(4, 0.1), TERMS), acb(0.5))
    for w in (3.9, 4.0, 4.1):
        true = DIGITS200.taylor(
            lambda t, w=w: DIGITS200.sqrt(DIGITS200.mpc(0, 1) * (DIGITS200.mpf(w) + t)), 0, TERMS - 1
        )
        slack = [abs(middle_of(root[k].real.rad())) + 1e-12 for k in range(TERMS)]
        assert all(abs(middle_of(root[k].real.mid()) - c.real) <= slack[k] for k, c in enumerate(true))


def test_phi_around_0_is_known_as_well_as_its_argument() -> None:
    with series_arithmetic():
        for radius in (1e-1, 1e-3, 1e-6):
            found = BALL_SERIES["phi"](along_axis(arb(radius / 2, radius / 2), TERMS))
            assert all(float(found[k].real.rad() + found[k].imag.rad()) < 3 * radius for k in range(TERMS))
            for share in (0, 0.3, 1):  # from 0 on, on one side
                true = mean(
                    [
                        DIGITS200.mpc(0, share * DIGITS200.mpf(radius)),
                        DIGITS200.mpc(0, 1),
                        *[DIGITS200.mpc(0)] * (TERMS - 2),
                    ]
                )
                assert all(holds_complex(found[k], DIGITS200.mpc(c)) for k, c in enumerate(true))


def test_links_are_the_chain_matrices_one_after_the_other() -> None:
    """At one frequency, from the entries of the matrices: a gain, a shunt, a compliance, waves."""
    c, w, tau = 5 + 2 * s, Rational(30), Rational(1, 50)
    waves = (
        (exp(s * tau) + exp(-s * tau)) / 2, 10 * s * (exp(s * tau) - exp(-s * tau)) / 2,
        (exp(s * tau) - exp(-s * tau)) / (20 * s), (exp(s * tau) + exp(-s * tau)) / 2,
    )  # fmt: skip
    one, none = Rational(1), Rational(0)
    matrices = [(w / (s + w), none, none, one), (one, 3 * s**2, none, one), (one, none, 1 / c, one), waves]
    H, rendered = 2 * s**2 + 7 * s + 90, 2 * s**2 + 7 * s + 80
    own = links(H, rendered, matrices)
    at = 11j
    felt, change = InSteps(own.start, FLOATS).results(InSteps(own.start, FLOATS).known(at))[1:]
    F, X = complex(rendered.subs(s, at)), 1 + 0j
    for matrix, program in zip(matrices, own.effects, strict=True):
        assert program.inputs == (s, FELT, CHANGE)
        link = InSteps(program, FLOATS)
        felt, change = link.results(link.known(at), (felt, change))
        A, B, C, D = (complex(entry.subs(s, at)) for entry in matrix)
        F, X = A * F + B * X, C * F + D * X
        assert felt == pytest.approx(F / X, rel=1e-12)
        assert change == pytest.approx(F / X - complex(H.subs(s, at)), rel=1e-11)
    with series_arithmetic():
        link = InSteps(own.effects[-1], BALL_SERIES)
        near = along_axis(arb(0, 0.01), TERMS)
        assert link.results(link.known(near), (acb_series([acb(90)], prec=TERMS),) * 2)[0][0].is_finite()


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_link_that_is_0_over_0_at_rest_has_its_limit_there(order: int) -> None:
    """(w (1 - exp(-s tau))/s)^n is (w tau)^n at s = 0; the change of it to what comes before is one less."""
    tau, w = Rational(1, 5), Rational(3)
    hold = (w * (1 - exp(-s * tau)) / s) ** order
    one, none = Rational(1), Rational(0)
    start, [effect] = (own := links(90 + s, 90 + s, [(hold, none, none, one)])).start, own.effects
    with series_arithmetic():
        for at in (arb(0), arb(0.25)):
            near = along_axis(at, TERMS)
            _, felt, change = InSteps(start, BALL_SERIES).results(InSteps(start, BALL_SERIES).known(near), [])
            link = InSteps(effect, BALL_SERIES)
            found, moved = (x[0] for x in link.results(link.known(near), (felt, change)))
            z = mpmath.mpc(0, float(at.mid()))
            gain = (3 * (1 - mpmath.exp(-z / 5)) / z if at != 0 else mpmath.mpf(3) / 5) ** order
            for ball, truth in ((found, (90 + z) * gain), (moved, (90 + z) * (gain - 1))):
                assert complex(float(ball.real), float(ball.imag)) == pytest.approx(complex(truth), rel=1e-13)


# Closed forms and steps of chains

E, F = hs.environments, hs.effects

LAG = F.second_order_lowpass(70, "0.6")

CHAINS = {
    "a wave line": hs.Scene(E.mass_spring_damper(2, 3, 90), (F.wave_variables(3, "20 ms"),)),
    "a wave line to a damped spring": hs.Scene(E.kelvin_voigt(90, 3), (F.wave_variables("7/2", "20 ms"),)),
    "a delay": hs.Scene(E.kelvin_voigt(90, 3), (F.delay("20 ms"),)),
    "a low-pass": hs.Scene(E.mass_spring_damper("1/2", 3, 90), (LAG,)),
    "a lag of a link": hs.Scene(E.maxwell(90, 4), (F.first_order_lag(20), F.compliance(k=500))),
    "an undamped wall": hs.Scene(E.mass_spring_damper("1/2", 0, 90), (LAG,)),
}


@pytest.mark.dear("a wave line")
@pytest.mark.parametrize("name", CHAINS)
def test_a_program_of_closed_forms_has_the_values_of_the_matrices(name: str) -> None:
    scene, pick = CHAINS[name], Random(name)
    chain = scene.chain
    program = closed(chain)
    for _ in range(3):
        at = pick.randint(1, 900) / 16
        values = {p.symbol.name: float(p.value) * pick.randint(9, 24) / 16 for p in scene.parameters}
        point = BallPoint(program, (at, *(values[x.name] for x in program.inputs[1:])))
        with flint.ctx.workprec(400):
            expected = truth(chain, at, values, 400)
            found = point.balls(400)
            assert found.keys() == expected.keys()
            for field, true in expected.items():
                assert abs(found[field] - true) < arb(2) ** -300 * (1 + abs(true)), field


GIVEN = {
    "expression": {"H": "k + b*s/(1 + s*T)", "parameters": {"k": 90, "b": 3, "T": "20 ms"}},
    "prony": {"k0": 50, "k": [10, 20], "b": [3, 4]},
    "series": {"G": "(1 + s*T)/(1 + s*T/9)", "parameters": {"T": "10 ms"}},
    "admittance-display": {"P": "1/(1 + s*T)", "parameters": {"T": "8 ms"}},
    "two-port": {"A": "1 + s*T", "B": "m*s^2", "C": "1/k", "D": "1", "parameters": {"T": "3 ms", "m": 0.2, "k": 3000}},
    "pade-delay": {"tau": "20 ms", "order": 2},
    "sampled-loop": {"T": "20 ms", "method": "backward-difference", "delay": 1},
}

VALUES = {"zeta": 0.6, "alpha": 0.5, "omega_n": 70, "omega_c": 40, "tau": 0.02, "T": 0.01}


def built(kind: str, models, build):  # type: ignore[no-untyped-def]
    slots = models[kind].slots
    given = GIVEN.get(kind) or {
        key: VALUES.get(key, Rational(3 + 7 * i, 2)) for i, (key, slot) in enumerate(slots.items()) if not slot.formula
    }
    return models[kind].build(**given)


@cache
def pair(environment: str, effect: str) -> hs.Scene:
    return hs.Scene(built(environment, ENVIRONMENTS, None), (built(effect, EFFECTS, None),), (0, 30))


def felt(scene: hs.Scene, values: dict[Expr, Expr]) -> dict[str, object]:
    """The witness: the chain matrix applied to H_env at s = j omega, in complex numbers of sixty digits."""

    def at(entry: Expr) -> object:
        return mp.mpmathify(entry.xreplace({**values, hs.s: I * values[hs.omega]}).evalf(60))

    chain = scene.chain
    H = at(chain.environment)
    perceived = H
    for a, b, c, d in chain.matrices:
        perceived = (at(a) * perceived + at(b)) / (at(c) * perceived + at(d))
    dH = perceived - H
    relative = dH / H
    return {
        "real": dH.real, "imag": dH.imag, "ratio_real": abs(dH.real) / abs(H), "ratio_imag": abs(dH.imag) / abs(H),
        "relative_real": relative.real, "relative_imag": relative.imag, "environment_real": H.real,
        "environment_imag": H.imag, "perceived_real": perceived.real, "perceived_imag": perceived.imag,
    }  # fmt: skip


PLAIN_EFFECTS, PLAIN_ENVIRONMENTS = (
    ("second-order-lowpass", "delay", "shunt", "two-port"),
    ("mass-spring-damper", "maxwell"),
)
ALONE = {"difference-equation"}  # behind a sampled loop alone
PAIRS = sorted({*product(ENVIRONMENTS.keys() - ALONE, PLAIN_EFFECTS), *product(PLAIN_ENVIRONMENTS, EFFECTS)})


@pytest.mark.dear("mass-spring-damper-delay")
@pytest.mark.few(
    "mass-spring-damper-delay",
    "kelvin-voigt-second-order-lowpass",
    "mass-spring-damper-first-order-lag",
    "maxwell-shunt",
)
@pytest.mark.parametrize(("environment", "effect"), PAIRS)
def test_every_formula_of_every_pair_of_models_has_the_value_of_its_chain(environment: str, effect: str) -> None:
    """In steps with symbols for all parameters, and in lowest terms with numbers, at random values of the parameters."""
    scene = pair(environment, effect)
    steps = page_steps(scene.chain.program(Values._fields))
    pick = random.Random(f"{environment} {effect}")
    values = {p.symbol: p.value * Rational(pick.randint(60, 140), 100) for p in scene.parameters}
    d = Distortion.of(scene.chain.at(values))
    closed_forms = dict(zip(Values._fields, (
        d.real, d.imag, d.ratio_real, d.ratio_imag, d.relative_real, d.relative_imag,
        d.env_response.real.factored(), d.env_response.imag.factored(),
        d.perc_response.real.factored(), d.perc_response.imag.factored()), strict=True))  # fmt: skip
    values[hs.omega] = Float(Rational(pick.randint(1, 6000), 97), 60)
    with mp.workdps(60):
        expected = felt(scene, values)
        for forms in ({name: x.xreplace(values) for name, x in closed_forms.items()}, steps.at(values)):
            for name, value in expected.items():
                assert abs(mp.mpmathify(forms[name].evalf(60)) - value) < 1e-30 * max(abs(value), 1e-6), name


def cascade(count: int) -> Chain:
    m, b, k = hs.symbols("m b k")
    filters = [F.second_order_lowpass(*hs.symbols(f"omega_{i} zeta_{i}")) for i in range(1, count + 1)]
    H = E.mass_spring_damper(m, b, k).H
    return Chain(H, H, tuple(f.matrix for f in filters))


def test_the_steps_of_a_cascade_multiply_out_to_its_closed_form_exactly() -> None:
    chain = cascade(2)
    d = Distortion.of(chain)
    numbers = {x: Rational(n + 2, 3) for n, x in enumerate(sorted({*d.free_symbols, hs.omega}, key=str))}
    found = chain.steps.at(numbers)
    lowest = {x: getattr(d.difference_response, x).factored().xreplace(numbers) for x in ("real", "imag")}
    assert {x: found[x] for x in lowest} == lowest
    size = d.squared_modulus.factored().xreplace(numbers)
    assert (found["ratio_real"] ** 2).expand() == (lowest["real"] ** 2 / size).expand()


def test_a_name_that_a_parameter_has_already_is_not_given_twice() -> None:
    R, U, P = hs.symbols("R U P")
    steps = hs.distort(E.mass_spring_damper(R, 1, U), F.second_order_lowpass(P, 1)).chain.steps
    names = [x.name for x, _ in steps.definitions]
    assert len(set(names)) == len(names)
    assert not {"R", "U", "P"} & set(names)


def written(expression, label=""):
    """A program of one expression in a and b."""
    write = Writer((a, b, x0))
    step = write.expression(expression)
    return write, write.label(step, label) if label else step


def in_code(program):
    """The definitions and the results in Python."""
    names = {x: x.name for x in program.inputs}
    reader = CodeReader(program, {*names.values()}, dialect=DIALECTS[Language.NUMPY], names=names)
    results = reader.results()
    return {x: y.text for x, y in reader.definitions}, {x: y.text for x, y in results.items()}


def test_some_results_need_some_definitions_and_none_for_a_mere_result():
    c, d, e = symbols("c d e")
    steps = Steps(((c, a + 1), (d, c * b), (e, b**2)), {"x": d, "y": e, "z": c + e})
    assert steps.only(["x"]) == Steps(((c, a + 1),), {"x": c * b})
    assert steps.only(["y", "z"]) == Steps(((c, a + 1), (e, b**2)), {"y": e, "z": c + e})


def test_a_defined_name_is_never_one_of_the_arguments():
    write, total = written(x0 + a, "b")
    root = write.sqrt(write.expression(a - b))
    program = write.program({"y": write.mul(total, total), "z": write.add(root, write.div(write.input(a), root))})
    definitions, results = in_code(program)
    assert definitions.keys() == {"bx", "x1"}
    assert results["y"] == "bx*bx"
    assert {x.name for x, _ in page_steps(program).definitions} == {"bx"}


def test_a_page_has_whole_angles_and_code_has_their_halves():
    write, change = written(-2 * sin(a / 2) ** 2, "P")
    program = write.program({"y": write.mul(change, write.input(b))})
    [(P, whole)] = page_steps(program).definitions
    assert (P.name, whole) == ("P", cos(a) - 1)
    assert "cos" not in str(in_code(program))


RUN = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "abs": abs,
}


@pytest.mark.parametrize("seed", range(8))
def test_steps_of_any_operations_are_worth_what_the_operations_are_on_a_page_and_in_code(seed: int) -> None:
    """Operations on fractions one by one; the program, which folds what it can; its page; its code, run by Python in fractions."""
    known = {"a": Fraction(3, 7), "b": Fraction(-5, 3), "x0": Fraction(11, 2)}
    chance = random.Random(seed)
    for _ in range(30):
        write = Writer((a, b, x0))
        steps = [*map(write.input, (a, b, x0)), *map(write.constant, (2, fmpq(-1, 4), 0, 1, -1))]
        values = [*known.values(), *map(Fraction, (2, "-1/4", 0, 1, -1))]
        for n in range(12):
            name = chance.choice(list(RUN))
            chosen = [chance.randrange(len(steps)) for _ in range(1 if name in ("neg", "abs") else 2)]
            if name == "div" and not values[chosen[1]]:
                continue
            steps.append(getattr(write, name)(*(steps[i] for i in chosen)))
            values.append(RUN[name](*(values[i] for i in chosen)))
            if chance.random() < 0.2:
                steps[-1] = write.label(steps[-1], f"S{n}")
        program, true = write.program({"y": steps[-1], "z": steps[-2]}), {"y": values[-1], "z": values[-2]}
        assert {name: in_fractions(program, list(known.values()))[x] for name, x in program.results.items()} == true
        page = page_steps(program).at({x: Rational(known[x.name]) for x in (a, b, x0)})
        assert {name: Fraction(int(x.p), int(x.q)) for name, x in page.items()} == true
        definitions, results = in_code(program)
        named = dict(known)
        for name, text in {**definitions, **results}.items():
            named[name] = evaluated(text, named)
        assert {name: named[name] for name in true} == true


def in_fractions(program: Program, inputs: list[Fraction]) -> list[Fraction]:
    found: list[Fraction] = []
    for step in program.operations:
        if step.name == "input":
            found.append(inputs[step.arguments[0]])
        elif step.name == "constant":
            found.append(Fraction(int(step.value.p), int(step.value.q)))
        else:
            found.append(RUN[step.name](*(found[x] for x in step.arguments)))
    return found


def evaluated(text, known):
    """Python's own value of an expression, its numbers taken as fractions."""
    exact = re.sub(r"(?<![\w.])\d+\.?\d*(e[+-]?\d+)?", r"Fraction('\g<0>')", text.replace("np.abs", "abs"))
    return eval(exact, {"Fraction": Fraction, "abs": abs}, known)  # noqa: S307 - our own code


@pytest.mark.parametrize("n", range(8))
@pytest.mark.parametrize("dynamics", [(), (hs.s**2 + 3 * hs.s + 5,)])
def test_the_root_of_a_closed_form_squares_to_it(n, dynamics):
    """Of a squared modulus, with its sum of squares or without, and of a power that only even ones make positive."""
    ring = Ring.of([hs.s])
    square = RealFunction(
        ring.axis.convert(((5 - omega**2) ** 2 + 9 * omega**2) ** n * (omega - 2) ** 2 / (omega**2 + 1) ** n)
    )
    program = closed_program({"ratio": square}, [ring.convert(x).numerator for x in dynamics], ())
    at = {omega: Rational(3, 2)}
    found = page_steps(program).at(at)["ratio"]
    assert found > 0
    assert found**2 == square.expression().xreplace(at)
