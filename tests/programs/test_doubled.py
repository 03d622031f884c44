"""Double-doubles: exact transformations are exact, and every bound of an error holds."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import isqrt

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational, Symbol, cos, pi, sin, sinc

from haptisym.programs import doubled
from haptisym.programs.doubled import BLOCK, Doubled, Doubles, add, div, fast_two_sum, of_ball, two_product, two_sum
from haptisym.programs.floats import Floats
from haptisym.programs.magnitudes import judge
from haptisym.programs.program import Program, Writer, sincm1

numbers = st.floats(min_value=-1e100, max_value=1e100).filter(lambda x: x == 0 or abs(x) > 1e-100)
pairs = st.tuples(numbers, st.floats(-0.5, 0.5), st.floats(0, 1e-20))


def number(pair: tuple[float, float, float]) -> tuple[Doubled, list[Fraction]]:
    """A double-double with a bound, and the ends of what it stands for."""
    hi, low, relative = pair
    lo = low * float(np.spacing(abs(hi)))
    error = relative * abs(hi)
    middle = Fraction(hi) + Fraction(lo)
    x = Doubled(np.float64(hi), np.float64(lo), np.float64(error))
    return x, [middle - Fraction(error), middle + Fraction(error)]


@given(numbers, numbers)
def test_sums_and_products_of_two_doubles_are_exact(a: float, b: float) -> None:
    assert sum(map(Fraction, two_sum(a, b))) == Fraction(a) + Fraction(b)
    assert sum(map(Fraction, two_product(a, b))) == Fraction(a) * Fraction(b)


OPERATIONS: list[tuple[Callable[..., Doubled], Callable[[Fraction, Fraction], Fraction]]] = [
    (doubled.add, lambda x, y: x + y),
    (doubled.sub, lambda x, y: x - y),
    (doubled.mul, lambda x, y: x * y),
    (doubled.div, lambda x, y: x / y),
]


@pytest.mark.parametrize("place", range(4), ids=["sum", "difference", "product", "quotient"])
@given(pairs, pairs)
def test_the_bound_of_the_error_holds_for_all_that_the_operands_may_be(
    place: int, first: tuple[float, float, float], second: tuple[float, float, float]
) -> None:
    ours, exact = OPERATIONS[place]
    (x, ends), (y, others) = number(first), number(second)
    assume(place < 3 or y.hi != 0)
    with np.errstate(all="ignore"):
        found = ours(x, y)
    assume(np.isfinite(found.error))
    middle = Fraction(float(found.hi)) + Fraction(float(found.lo))
    for a in ends:
        for c in others:
            assert abs(middle - exact(a, c)) <= Fraction(float(found.error))


@given(pairs)
def test_the_bound_of_a_root_holds(given_pair: tuple[float, float, float]) -> None:
    x, (low, high) = number(given_pair)
    assume(x.hi > 0 and low > 0)
    with np.errstate(all="ignore"):
        found = doubled.sqrt(x)
    assume(np.isfinite(found.error))
    scale = 1 << 800
    for end in (low, high):
        root = Fraction(isqrt(int(end * scale * scale)), scale)
        assert abs(Fraction(float(found.hi)) + Fraction(float(found.lo)) - root) <= Fraction(
            float(found.error)
        ) + Fraction(2, scale)


def test_what_overflows_has_no_bound() -> None:
    huge = Doubled(np.float64(1e300), np.float64(0), np.float64(0))
    with np.errstate(all="ignore"):
        assert not np.isfinite(doubled.mul(huge, huge).error)


X = Symbol("X")


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


# --- thousands of operands: wide errors, zeros, tiny and huge numbers ------------------------------------------------

COUNT = 1500


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


def exact(x: float) -> fmpq:
    return fmpq(*float(x).as_integer_ratio())


def ends(x: Doubled, n: int) -> tuple[fmpq, fmpq]:
    middle, error = exact(x.hi[n]) + exact(x.lo[n]), exact(x.error[n])
    return middle - error, middle + error


def deviations(found: Doubled, n: int, truths: list[fmpq]) -> fmpq:
    """How far the result lies from the furthest of these."""
    middle = exact(found.hi[n]) + exact(found.lo[n])
    return max(abs(middle - truth) for truth in truths)


PLAIN = {"add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y, "div": lambda x, y: x / y}
SLACK, OWN, LOST = fmpq(1001, 1000), fmpq(1, 2**99), fmpq(1, 2**1058)


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
            nothing = name == "div" and (c <= 2 * exact(y.error[n]) or d >= -2 * exact(y.error[n]))
            assert overflows or nothing or (name == "div" and abs(exact(y.hi[n])) < fmpq(1, 2**900)), n
            continue
        bounded += 1
        corners = [PLAIN[name](p, q) for p in (a, b) for q in (c, d)]
        away, bound = deviations(found, n, corners), exact(found.error[n])
        assert away <= bound, n
        size, of = abs(exact(found.hi[n])), (exact(x.error[n]), exact(y.error[n]))
        if name == "div":
            below = abs(exact(y.hi[n])) - 2 * of[1]
            widest = (of[0] + size * of[1] + LOST) / below
        elif name == "mul":
            widest = abs(exact(x.hi[n])) * of[1] + abs(exact(y.hi[n])) * of[0] + of[0] * of[1]
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
            assert low <= exact(x.error[n]) + LOST, n
            continue
        bounded += 1
        middle, bound = exact(found.hi[n]) + exact(found.lo[n]), exact(found.error[n])
        assert max(fmpq(0), middle - bound) ** 2 <= low, n
        assert high <= (middle + bound) ** 2, n
        # (sqrt(x) + b)^2 - x = 2 sqrt(x) b + b^2, b at most twice what the ends need
        assert bound <= 2 * SLACK * (exact(x.error[n]) + LOST) / middle + middle * OWN + LOST, n
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
    a, b = (np.ldexp(rng.uniform(-2, 2, 4000), rng.integers(-400, 400, 4000)) for _ in range(2))
    b[::3] = -a[::3] * (1 + rng.integers(-4, 5, len(a[::3])) * 2.0**-52)
    for pair, of in ((two_sum(a, b), PLAIN["add"]), (two_product(a, b), PLAIN["mul"]), (two_product(a, a), None)):
        for s, e, x, y in zip(*pair, a, b, strict=True):
            assert exact(s) + exact(e) == (of(exact(x), exact(y)) if of else exact(x) ** 2)
            assert abs(e) <= np.spacing(abs(s)) / 2
    large, small = np.where(abs(a) >= abs(b), a, b), np.where(abs(a) >= abs(b), b, a)
    for s, e, x, y in zip(*fast_two_sum(large, small), a, b, strict=True):
        assert exact(s) + exact(e) == exact(x) + exact(y)


@given(st.fractions(-(10**9), 10**9), st.sampled_from([0, 1e-40, 1e-20, 1e-3, 0.9]), st.integers(-900, 900))
def test_a_ball_in_two_doubles_is_held_by_them_and_their_bound(x: Fraction, relative: float, exponent: int) -> None:
    with flint.ctx.workprec(140):
        ball = arb(fmpq(x.numerator, x.denominator)) * arb(1, relative) * arb(2) ** exponent
        hi, lo, error = map(exact, of_ball(ball))
    low, high = _dyadic(ball.mid()) - _dyadic(ball.rad()), _dyadic(ball.mid()) + _dyadic(ball.rad())
    assert hi + lo - error <= low
    assert high <= hi + lo + error
    assert error <= (high - low) / 2 * SLACK + abs(hi) * OWN + LOST


@pytest.mark.parametrize("exponent", [-1060, -1073, -1076, -1100, -9999])
def test_a_number_beside_the_smallest_doubles_is_held_by_them_and_their_bound(exponent: int) -> None:
    hi, lo, error = map(exact, of_ball(3 * arb(2) ** exponent))
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


# --- whole programs --------------------------------------------------------------------------------------------------

Y, Z = Symbol("Y"), Symbol("Z")


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


MP = mpmath.mp.clone()
MP.dps = 200


def truths(x: float, y: float) -> dict[str, object]:
    a, b = MP.mpf(x), MP.mpf(y)
    return {
        "sum": a + b, "difference": a - b, "product": a * b, "quotient": a / b, "opposite": -a, "size": abs(a),
        "root": MP.sqrt(abs(a)), "third": a / 3, "circle": b * MP.pi - a, "cos": MP.cos(a), "sin": MP.sin(a * b),
        "sinc": MP.sinc(a), "sincm1": MP.sinc(a) - 1, "power": abs(b) ** (MP.mpf(3) / 10), "pi": +MP.pi, "input": a,
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
    x, y = points(150)
    bounded, plain = (Doubles(program, bounded=b).run([x, y, abs(y)], x.size) for b in (True, False))
    for name, found in bounded.items():
        assert (found.hi == plain[name].hi).all()
        assert (abs(found.lo - plain[name].lo) <= abs(found.hi) * 2.0**-99).all()
        assert np.isnan(plain[name].error).all()
        for n in range(x.size):
            true = truths(x[n], y[n])[name]
            away = abs(MP.mpf(found.hi[n]) + MP.mpf(found.lo[n]) - true)
            assert away <= MP.mpf(found.error[n]), (name, n)
            size = abs(x[n]) + abs(y[n]) if name in ("sum", "difference", "circle") else abs(true)
            # a sine of a product knows its angle to 2^-100 of it
            size += abs(x[n] * y[n]) if name == "sin" else 0
            assert found.error[n] <= 8 * size * MP.mpf(2) ** -100 + MP.mpf(2) ** -1000, (name, n)


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
