"""Numbers, states, functions and formulas of the kernel, drawn at random: against fractions, Decimal, mpmath, NumPy, SciPy and SymPy."""

from __future__ import annotations

import math
import random
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from itertools import pairwise
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq
from scipy.integrate import quad_vec
from scipy.linalg import expm
from sympy import Expr, Integer, Poly, Rational, Symbol, cos, diff, exp, lambdify, log, pi, sin, sinc, sqrt, tan
from windings import winding

from haptisym.kernel.contour import factor_at, parts_of, turned, value_at, whole
from haptisym.kernel.decimals import outward, rounded
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.exponentials import Exponentials
from haptisym.kernel.factoring import Known, factored_function, is_even_or_odd
from haptisym.kernel.implicit import Equation
from haptisym.kernel.levels import Level, algebraic
from haptisym.kernel.ordering import in_order
from haptisym.kernel.reals import (
    ExactNumber,
    Negative,
    Sliver,
    SquareRoot,
    bounds,
    expression_ball,
    rational_between,
    short,
)
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import PolynomialRing, cleared, degree_in
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.roots import chart
from haptisym.kernel.solutions import solve
from haptisym.kernel.squares import positive_from
from haptisym.kernel.states import States, matrix
from haptisym.kernel.symbols import omega, s
from haptisym.kernel.terms import beginning_at_0, terms_of

SEEDS = range(20)
a, b = Symbol("a", positive=True), Symbol("b", positive=True)


def some(draw: random.Random, most: int = 9) -> Rational:
    return Rational(draw.choice([-1, 1]) * draw.randint(1, most), draw.choice([1, 2, 3, 7]))


def fraction(x: Any) -> Fraction:
    return Fraction(int(x.p), int(x.q))


# Numbers


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
        found = fraction(rational_between(*ends))
        # bounds of the ends lie a hair off: an end that is simple itself may be given away, never more
        assert low < found < high
        assert found.denominator <= simplest(low, high).denominator
        own = Rational(draw.randint(-90, 90), draw.randint(1, 30))
        told = rational_between(*ends, own)
        assert told == (own if low < fraction(own) < high else rational_between(*ends))
        above, below = (fraction(rational_between(*x)) for x in ((ends[0], None), (None, ends[0])))
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
        sliver = Sliver(*(fraction(fmpq(round(y * 2**90), 2**90)) for y in (x, x + Fraction(1, 2**60))))
        if sliver.low < sliver.high:
            digits = sliver.digits(count)
            most = [y for n in range(1, count + 1) if (y := rounded(sliver.low, sliver.high, n))]
            assert digits == (most[-1] if most else rounded(sliver.low, sliver.low, 1))
            assert float(sliver) == pytest.approx(float(x), rel=1e-9, abs=1e-15)
    assert [short(ExactNumber(Rational(x))) for x in ("100", "1e25", "0.5", "-3", "1e-9", "12345678")] == [
        "100", "1.0000E+25", "0.5", "-3", "1.0000E-9", "12346000",
    ]  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(6))
def test_balls_of_expressions_hold_the_values_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(15):
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


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(6))
def test_numbers_are_put_in_order_however_near(seed: int) -> None:
    draw = random.Random(seed)
    squares = [Fraction(draw.randint(1, 50)) for _ in range(4)]
    squares += [squares[0] + Fraction(1, 10**n) for n in draw.sample(range(1, 80), 4)]
    numbers = [SquareRoot(ExactNumber(Rational(x.numerator, x.denominator))) for x in dict.fromkeys(squares)]
    draw.shuffle(numbers)
    told = [fraction(x.square.value) for x in in_order(numbers)]  # type: ignore[attr-defined]
    assert told == sorted(set(squares))


# States


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_states_are_moved_as_scipy_moves_them(seed: int) -> None:
    draw = random.Random(seed)
    n = draw.randint(1, 4)
    q = [draw.choice([0, draw.uniform(-50, 50)]) for _ in range(n)] + [1.0]
    own = States([arb(x) for x in q])
    assert own.size == n
    A, t = np.array([[float(own.A[i, j]) for j in range(n)] for i in range(n)]), draw.uniform(0.05, 0.4)
    assert np.poly(A)[::-1] == pytest.approx(q, abs=1e-6 * max(map(abs, q)))
    C = [draw.uniform(-3, 3) for _ in range(n)]
    row = np.array([float(own.row([arb(x) for x in C])[0, j]) for j in range(n)])
    last = np.zeros(n)
    last[-1] = 1

    def moved(x: float) -> Any:
        return expm(A * x)

    integral = quad_vec(moved, 0, t)[0]
    mine = np.array([[float(own.integral(arb(t))[i, j]) for j in range(n)] for i in range(n)])
    assert mine == pytest.approx(integral, rel=1e-8, abs=1e-10)
    held = np.array([float(own.held(arb(t))[i, 0]) for i in range(n)])
    # 1/Q read by C: the step response of a chain of integrators
    plain = np.zeros((n, n))
    plain[np.arange(n - 1), np.arange(1, n)] = 1
    plain[n - 1] = [-x for x in q[:n]]
    true = np.array(C) @ quad_vec(lambda x: expm(plain * x), 0, t)[0] @ last
    assert row @ held == pytest.approx(true, rel=1e-7, abs=1e-10)
    assert float(own.rate) >= 1


def test_states_of_nothing_are_no_states() -> None:
    own = States([arb(1)])
    assert (own.size, own.A.nrows(), own.row([]).ncols(), own.held(arb(1)).nrows(), own.integral(arb(1)).nrows()) == (
        0,
        0,
        0,
        0,
        0,
    )
    assert (matrix([]).nrows(), matrix([[]], 0).nrows(), matrix([[arb(1), arb(2)]], 2).ncols()) == (0, 1, 2)


# Algebraic numbers and exponentials


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_no_number_made_of_roots_is_nearer_to_0_than_the_gap_unless_it_is_0(seed: int) -> None:
    """Combinations that nearly cancel, by continued fractions of sqrt(2) and the golden ratio."""
    draw = random.Random(seed)
    ring = Exponentials([(-2, 0, 1), (-1, -1, 1), (-3, 0, draw.choice([2, 5]))][: draw.randint(1, 3)], [fmpq(1)])
    convergents = [(1, 1), (3, 2), (7, 5), (17, 12), (41, 29), (99, 70), (1393, 985), (47321, 33461)]
    p, q = draw.choice(convergents)
    x = ring.root(0) * draw.choice([q, -q]) + draw.choice([p, -p])
    for i in range(1, len(ring.owner)):
        x = x * draw.choice([1, ring.root(i) - draw.randint(0, 3)])
    x = x * fmpq(draw.randint(1, 9), draw.randint(1, 50))
    gap = ring._gap(x)
    with flint.ctx.workprec(gap + 200):
        value = abs(ring._value(x))
        assert value > arb(2) ** -gap
    assert not ring.is_zero(x)
    assert ring.is_zero(x * (ring.root(0) ** 2 - 2))
    assert not ring.is_zero(x * (ring.root(0) ** 2 - 2) + x)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_from_a_frequency_on_the_late_part_is_the_less(seed: int) -> None:
    draw = random.Random(seed)
    top, late = (
        [draw.randint(-9, 9) for _ in range(3)] + [draw.choice([-3, 2])],
        [draw.randint(-9, 9) for _ in range(3)] + [draw.randint(-1, 1)],
    )
    terms = {Integer(n): {(0,): Integer(x), (2,): Integer(y)} for n, (x, y) in enumerate(zip(top, late, strict=True))}
    found = positive_from(terms, (2,))
    assert found is not None
    w = float(found) * np.concatenate([1 + np.linspace(0, 2, 2000), np.geomspace(3, 1e5, 500)])
    A, B = (np.polyval(x[::-1], 1j * w) for x in (top, late))
    assert (abs(A) > abs(B)).all()
    assert positive_from({Integer(0): {(0,): Integer(1), (2,): Integer(2)}}, (2,)) is None


# Rings and functions


def polynomial(draw: random.Random, x: Expr, degree: int = 3) -> Expr:
    return sum(
        (draw.randint(-5, 5) * x**n * draw.choice([1, 1, a, pi, a * b]) for n in range(degree + 1)), Integer(0)
    ) + some(draw)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_polynomials_and_quotients_of_a_ring_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    ring = PolynomialRing(omega, [a, b])
    f, g = polynomial(draw, omega), polynomial(draw, omega, 2)
    p = ring.convert(f).numerator
    scale = ring.convert(f).denominator.leading_coefficient()
    assert (ring.expression(p) / Rational(int(scale.p), int(scale.q)) - f).expand() == 0
    row = ring.coefficients(p)
    assert (sum((c * omega**n for n, c in enumerate(row)), Integer(0)) - ring.expression(p)).expand() == 0
    assert row[-1] != 0
    assert (ring.factored_expression(p) - ring.expression(p)).expand() == 0
    plain = Poly(f.subs({a: 2, b: 3, pi: 5}), omega)
    known = ring.univariate(ring.convert(plain.as_expr()).numerator)
    assert known is not None
    assert [fraction(c) for c in known] == [fraction(c) for c in plain.all_coeffs()[::-1]]
    assert (ring.univariate(p) is None) == bool(ring.expression(p).free_symbols - {omega} or ring.expression(p).has(pi))
    quotient = ring.convert(f) / ring.convert(g)
    for told in (quotient.reduced(), quotient.reduced().cleared(), quotient.monic(), quotient.cleared()):
        assert told.equals(quotient)
        assert (told.expression() - f / g).together().expand() == 0
    whole_ones = quotient.reduced().cleared()
    values = [*whole_ones.numerator.coeffs(), *whole_ones.denominator.coeffs()]
    assert all(c.q == 1 for c in values)
    assert math.gcd(*(int(c.p) for c in values)) == 1
    for power in (-2, -1, 0, 3):
        assert ((quotient**power).expression() - (f / g) ** power).together().expand() == 0
    entries = [quotient, ring.convert(f), ring.convert(omega / g), ring.zero]
    plain_ones = cleared(entries)
    for x, y in pairwise(zip(entries, plain_ones, strict=True)):
        assert (x[0] * ring.function(y[1])).equals(y[0] * ring.function(x[1]))
    assert degree_in([p, ring.constant(0)], 0) == Poly(f, omega).degree()
    assert degree_in([ring.constant(0)], 0) == 0
    with flint.ctx.workprec(100):
        ball = ring.ball(p, {omega: arb(2), a: arb(3), b: arb(5), pi: arb.pi()})
    assert float(ball) == pytest.approx(float(ring.expression(p).subs({omega: 2, a: 3, b: 5})))


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_slope_is_that_of_the_quotient_rule_in_lowest_terms_and_so_is_what_it_is_known_to_be_made_of(
    seed: int,
) -> None:
    draw = random.Random(seed)
    tail = draw.choice([1, exp(-s / 3), s ** Rational(1, 3), a * s, exp(-s / 5) * sqrt(s), exp(-s / 3) * a])
    below = draw.choice([1, s, s**2, s ** Rational(1, 3) + 2, (s + 1) ** 2, s * (1 + exp(-s / 5))])
    x = (some(draw) * s**2 + some(draw) * s * draw.randint(0, 1) + some(draw) * tail) / below
    ring = Ring.of([x, a * s])
    f, modulus = on_axis(ring.convert(x)), squared_modulus(ring.convert(x))
    given = [f.real, f.imag, modulus]
    given += [part.square_over(modulus) for part in given[:2]]
    for own in [*given, *(one.derivative() for one in given)]:
        found = own.derivative()
        axis = own.axis
        top, bottom = (axis.function(p) for p in (own.function.numerator, own.function.denominator))
        above, below = (axis.derivative(p.numerator) for p in (top, bottom))
        plain = axis.reduced((above * bottom - top * below) / (bottom * bottom))
        assert (found.function.numerator, found.function.denominator) == (plain.numerator, plain.denominator)
        for function in (own, found):
            pairs = (function.function.numerator, function.above), (function.function.denominator, function.below)
            for whole_one, parts in pairs:
                assert not parts or whole_one.is_zero() or (math.prod(parts, start=1) / whole_one).is_constant()
        if not found.is_zero:
            taken, again = (factored_function(z, Known()) for z in (found, RealFunction(found.function)))
            assert (taken.sign, taken.power) == (again.sign, again.power)
            assert {str(k): n for k, n in taken.exponents.items()} == {str(k): n for k, n in again.exponents.items()}


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_functions_on_the_axis_have_their_values_slopes_and_squares(seed: int) -> None:
    draw = random.Random(seed)
    late = draw.choice([Integer(1), exp(-s / 3), exp(-s / 3) + s ** Rational(1, 3) / 2])

    def one() -> Expr:
        return sum((draw.randint(-5, 5) * s**n for n in range(3)), some(draw)) + draw.choice([0, 1, s]) * late

    x, y = one() / (s**2 + draw.randint(1, 5) * s + 7), one() / (s + draw.randint(1, 5))
    ring = Ring.of([x, y])
    f, g = (on_axis(ring.convert(z)) for z in (x, y))
    value, other = (lambdify(s, z, "mpmath") for z in (x, y))
    for _ in range(3):
        w = mpmath.mpf(draw.randint(1, 80)) / 8
        with flint.ctx.workprec(128):
            at = arb(str(w))
            z, u = value(mpmath.mpc(0, w)), other(mpmath.mpc(0, w))
            pairs = [
                (f.real, z.real), (f.imag, z.imag), (squared_modulus(ring.convert(x)), abs(z) ** 2),
                (f.real + g.imag, z.real + u.imag), (f.real * g.imag, z.real * u.imag), (f.real - g.imag, z.real - u.imag),
            ]  # fmt: skip
            if not g.imag.is_zero and abs(u.imag) > 1e-6:
                pairs += [(f.real / g.imag, z.real / u.imag), (f.real.square_over(g.imag), z.real**2 / u.imag)]
            for function, true in pairs:
                assert float(function.ball(at)) == pytest.approx(float(true), rel=1e-9, abs=1e-9)
            slope = mpmath.diff(lambda v: value(mpmath.mpc(0, v)).real, w)
            assert float(f.real.derivative().ball(at)) == pytest.approx(float(slope), rel=1e-6, abs=1e-6)
    expression = lambdify(omega, f.real.expression(), "mpmath")
    assert complex(expression(mpmath.mpf(2))) == pytest.approx(complex(value(2j).real))
    assert complex(lambdify(omega, f.imag.factored(), "mpmath")(mpmath.mpf(2))) == pytest.approx(
        complex(value(2j).imag)
    )
    with pytest.raises(SceneError, match="zero"):
        f.real.square_over(f.real - f.real)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_product_of_factors_is_the_function_in_value_order_and_sign(seed: int) -> None:
    draw = random.Random(seed)
    late = seed % 3 == 0
    axis = Ring.of([exp(-s / 2)] if late else []).axis
    top, bottom = (
        math.prod(
            ((omega**2 - draw.randint(1, 9)) ** draw.choice([1, 2]) for _ in range(draw.randint(1, 3))),
            start=some(draw) * omega ** draw.randint(0, 2),
        )
        for _ in range(2)
    )
    f = axis.convert(top) / axis.convert(bottom)
    if late:
        t = axis.function(axis.context.gens()[axis.size])
        f = f * (t**2 + axis.convert(Integer(draw.randint(2, 4)))) * t
    function = RealFunction(f.reduced())
    product = factored_function(function, Known(), in_square=True)
    for _ in range(4):
        w = draw.uniform(0.1, 9)
        with flint.ctx.workprec(128):
            at, true = arb(w), function.ball(arb(w))
            sign = product.sign
            for factor, n in product.exponents.items():
                sign *= (1 if factor.value(at) > 0 else -1) ** int(n)
            assert sign == (1 if true > 0 else -1)
    assert product.power == (Poly(top, omega).monoms()[-1][0] - Poly(bottom, omega).monoms()[-1][0]) or late
    if not late:
        orders = {
            round(float(z), 9): n
            for factor, n in product.exponents.items()
            for z in factor.zeros(Rational(1, 10), Integer(9))
        }
        true_orders: dict[float, int] = {}
        for p, side in ((top, 1), (bottom, -1)):
            for root in Poly(p, omega).all_roots():
                if root > 0:
                    true_orders[round(float(root), 9)] = true_orders.get(round(float(root), 9), 0) + side
        assert orders == {x: n for x, n in true_orders.items() if n}
        assert is_even_or_odd(function) is True
        assert is_even_or_odd(RealFunction(axis.convert((omega + 1) / bottom))) is False
        assert is_even_or_odd(RealFunction(axis.convert(omega / (omega**2 + omega + 1)))) is False
    assert factored_function(function - function, Known()).sign == 0


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(10))
def test_a_zero_moves_with_a_number_as_fast_as_differences_tell(seed: int) -> None:
    draw = random.Random(seed)
    c = [draw.randint(1, 9) for _ in range(4)]
    F = c[0] * a * omega**3 + c[1] * omega**2 * cos(omega * b) - c[2] * a**2 - c[3] * omega * b
    ring = PolynomialRing(omega, [a, b], [cos(omega * b)])
    slope = Equation(ring, ring.convert(F).numerator)
    known = {a: draw.uniform(0.5, 2), b: draw.uniform(0.1, 1)}

    def zero(values: dict[Any, float]) -> mpmath.mpf:
        return mpmath.findroot(
            lambdify(omega, F.subs(values), "mpmath"),
            (0.01, 30),
            solver="anderson",
            tol=1e-25,
            maxsteps=500,
            verify=False,
        )

    with mpmath.workdps(30):
        w = zero(known)
        if abs(lambdify(omega, F.subs(known), "mpmath")(w)) > 1e-12:
            return
        for x in (a, b):
            below = diff(F, omega).subs({**known, omega: float(w)})
            if abs(below) < 0.5:
                continue
            told = slope.slope(x).expression().subs({**known, omega: float(w)})
            true = -diff(F, x).subs({**known, omega: float(w)}) / below
            assert float(told) == pytest.approx(float(true), rel=1e-9)
            with flint.ctx.workprec(128):
                balls = {omega: arb(float(w)), a: arb(known[a]), b: arb(known[b])}
                above, under = slope.slope(x).balls(balls)
                assert float(-above / under) == pytest.approx(float(true), rel=1e-9)
                assert abs(float(slope.ball(balls))) < 1e-9
            assert not slope.slope(x).vanishes({})
    still = Equation(ring, ring.convert(omega**2 - b).numerator).slope(a)
    assert still.above == ()
    assert still.vanishes({a: Integer(1)})
    assert Equation(ring, ring.convert(omega**2 - a * (b - 2)).numerator).slope(a).vanishes({b: Integer(2)})


# Levels, formulas and turns


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(8))
def test_where_a_quotient_meets_a_root_of_a_number_is_where_sympy_solves_it(seed: int) -> None:
    draw = random.Random(seed)
    number = draw.choice([sqrt(draw.choice([2, 3, 5, 6])), (sqrt(5) + draw.randint(1, 3)) / 2, sqrt(7) - 2])
    root = algebraic(number)
    assert root.digits(30) == ExactNumber(number).digits(30)
    f = (draw.randint(0, 5) + draw.randint(0, 4) * omega**2 + omega**4) / (
        omega**2 + draw.randint(1, 4)
    ) ** draw.choice([1, 2])
    axis = Ring.of([]).axis
    factor = Level(RealFunction(axis.convert(f).reduced()), root).factor
    above, below = f.together().as_numer_denom()
    squares = np.roots([float(c) for c in Poly((above - number * below).expand().subs(omega, sqrt(a)), a).all_coeffs()])
    true = sorted(x.real**0.5 for x in squares if abs(x.imag) < 1e-12 and x.real > 1e-12)
    found = sorted({round(float(x), 10) for x in factor.zeros(Rational(1, 10**6), Integer(1000))})
    assert [x for x in found if x > 2e-6] == pytest.approx([x for x in true if x > 2e-6], abs=1e-8)
    for x in factor.zeros(Rational(1, 10**6), Integer(1000)):
        assert factor.multiplicity(x) >= 1
    with flint.ctx.workprec(128):
        assert float(factor.value(arb(2))) == pytest.approx(
            float((above - number * below).subs(omega, 2))
            / float(below.subs(omega, 2) / axis.expression(axis.convert(f).reduced().denominator).subs(omega, 2))
        )
    assert factor.order_at(Integer(3)) == 0


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_zeros_as_formulas_are_those_of_a_chart(seed: int) -> None:
    draw = random.Random(seed)
    kind = seed % 4
    if kind == 0:
        f = (draw.randint(-5, 5) + draw.randint(-5, 5) * omega**2 + draw.choice([0, 1, -2]) * omega**4) * (
            omega**2 + draw.randint(-4, 3)
        )
        ring = Ring.of([])
        function = RealFunction(ring.axis.convert(f + 0 * omega).reduced())
    else:
        x = (
            draw.randint(-3, 3) + draw.randint(1, 4) * exp(-s * Rational(draw.randint(1, 5), 2)),
            draw.randint(-3, 3) + 2 * exp(-s / 2) + draw.randint(-1, 1) * exp(-s),
            draw.randint(1, 5) * s ** Rational(draw.randint(1, 4), 5) * s + draw.randint(-5, 5),
        )[kind - 1]
        response = on_axis(Ring.of([x]).convert(x))
        function = draw.choice([response.real, response.imag])
    if function.is_zero:
        return
    high = Integer(12)
    table = chart({"": function}, Integer(0), high)
    true = {round(float(p.omega), 9): p.orders[""] for p in table.points[1:-1] if p.orders.get("", 0) > 0}
    found: dict[float, int] = {}
    for told in solve(function):
        if told.omega is None:
            return
        start, period = complex(told.omega.evalf(20)), float(told.period)
        if abs(start.imag) > 1e-12:
            continue
        turns = range(-3, 200) if period else range(1)
        for n in turns:
            w = start.real + n * period
            if 1e-9 < w < 12 - 1e-9:
                found[round(w, 9)] = max(found.get(round(w, 9), 0), told.order)
    assert sorted(found) == pytest.approx(sorted(true), abs=1e-7)
    assert [found[x] for x in sorted(found)] == [true[x] for x in sorted(true)]


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_function_turns_along_the_axis_as_far_as_samples_do(seed: int) -> None:
    draw = random.Random(seed)
    x = (
        sum((draw.randint(-5, 5) * s**n for n in range(3)), some(draw))
        + 3 * s**3
        + draw.randint(-6, 6) * draw.choice([1, s]) * exp(-s / 2)
    )
    if seed % 3 == 0:
        x += draw.randint(1, 4) * s ** Rational(3, 2)
    ring = Ring.of([x])
    top = ring.convert(x.expand()).numerator
    terms = terms_of(top, ring)
    f = lambdify(s, ring.expression(top), "numpy")
    order, sign = beginning_at_0(terms, ring)
    start, reach = order + (0 if sign > 0 else 2), Rational(draw.randint(3, 15))
    try:
        curve, angle = turned(parts_of(top, ring), terms, start, reach, ring)
    except UndecidedError:
        return
    w = np.geomspace(1e-9, float(reach), 20_001)
    values = f(1j * w)
    angles = np.angle(values[1:] / values[:-1])
    if abs(angles).max() > 0.5 or any(
        p.orders.get("real", 0) > 0 and p.orders.get("imag", 0) > 0 for p in curve.points
    ):
        return
    steps = angles.sum() * 2 / np.pi
    begin = float(start)
    assert float(angle) == pytest.approx(begin + steps, abs=1e-2 if seed % 3 else 0.2)
    with flint.ctx.workprec(128):
        assert complex(value_at(terms, reach, ring)) == pytest.approx(complex(f(1j * float(reach))), rel=1e-9)
        group = terms[Integer(0)]
        late = sum(
            complex(c)
            * np.exp(-1j * float(reach) * sum(n * float(lag) for n, lag in zip(turns, ring.lags, strict=True)))
            for turns, c in group.items()
        )
        assert complex(factor_at(group, reach, ring)) == pytest.approx(late)
    for n in (-2, 0, 5):
        assert whole(arb(n, 0) + arb(3) / 10) == n == whole(arb(n) - arb(3) / 10)
        with pytest.raises(UndecidedError):
            whole(arb(n) + arb(2) / 5)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(30))
def test_roots_on_the_right_are_those_that_a_contour_winds_around(seed: int) -> None:
    """Several delays, fractional orders, a delay that comes twice; the highest power of s outweighs what is late in it."""
    draw = random.Random(seed)
    lags = draw.choice([[Rational(1, 2)], [Rational(1, 3), Rational(1, 2)], [Rational(1, 4), pi / 9], [Integer(0)]])
    x = (
        4 * s**2
        + sum(
            (draw.randint(-6, 6) * s**n * exp(-s * draw.choice(lags)) for n in range(2) for _ in range(2)), Integer(0)
        )
        + draw.randint(-5, 5) * s
        + draw.randint(1, 9)
    )
    if seed % 3 == 0:
        x += draw.choice([-2, 3]) * s ** draw.choice([Rational(1, 2), Rational(3, 2), Rational(5, 3)])
    if seed % 4 == 0:
        x += draw.choice([-3, -1, 1, 3]) * s**2 * exp(-s * lags[0])
    ring = Ring.of([x.expand()])
    try:
        found = count_roots(ring.convert(x.expand()).numerator, ring)
    except UndecidedError:
        return
    true = winding(lambdify(s, x, "numpy"), 60.0)
    if true is not None and not found.on_axis:
        assert found.chain is None
        assert found.right == found.number == true


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_dynamics_keep_their_values_in_a_ring_whatever_their_delays_and_powers(seed: int) -> None:
    draw = random.Random(seed)
    lags = [
        draw.choice(
            [
                Rational(draw.randint(1, 9), draw.randint(1, 6)),
                a * Rational(draw.randint(1, 3), 2),
                pi / 4,
                a + Rational(1, 3),
            ]
        )
        for _ in range(draw.randint(1, 3))
    ]
    x: Expr = sum((some(draw) * s ** draw.randint(0, 2) * exp(-s * lag) for lag in lags), some(draw))
    x = x / (s + draw.randint(1, 4)) + draw.choice(
        [0, s ** Rational(draw.choice([-7, -1, 1, 5]), 3), s ** (a - 1), s ** (1 + b)]
    )
    ring = Ring.of([x])
    told = ring.convert(x)
    back = told.expression()
    for _ in range(2):
        known = {
            s: Rational(draw.randint(1, 30), 7),
            a: Rational(draw.randint(1, 20), 9),
            b: Rational(draw.randint(1, 8), 9),
        }
        assert abs((back - x).subs(known).evalf(30)) < 1e-15 * (1 + abs(x.subs(known).evalf(30)))
    numerator = told.numerator
    if not ring.orders:
        value = ring.expression(numerator)
        assert (ring.expression(ring.at_0(numerator)) - value.subs(s, 0)).expand() == 0
        slope, rates = ring.expression(ring.slope(numerator)), [ring.convert(lag).denominator for lag in ring.lags]
        common = math.prod((ring.expression(p) for p in rates), start=Integer(1))
        assert (
            abs((slope - common * diff(value, s)).subs({s: Rational(1, 3), a: Rational(2, 7), b: 1}).evalf(20)) < 1e-12
        )
        shift = ring.convert(ring.expression(ring.at_0(numerator))).numerator
        flat = numerator - shift
        if not flat.is_zero():
            assert ring.order_at_0(flat) >= 1
            assert ring.order_at_0(flat * ring.variable**2) == ring.order_at_0(flat) + 2
    for wrong in (exp(-(s**2)), exp(-s - 1), s ** (a * s)):
        with pytest.raises(SceneError):
            Ring.of([wrong]).convert(wrong)


@pytest.mark.parametrize("digits", [1, 6, 40, 90])
def test_roots_that_nearly_agree_are_two_numbers_however_large_they_are(digits: int) -> None:
    """sqrt(n + 1) - sqrt(n) is less than any bound that sees 1, 0 and the coefficients of the difference alone."""
    n = 10 ** (2 * digits) + 1
    ring = Exponentials([(-n, 0, 1), (-n - 1, 0, 1)], [fmpq(1)])
    with flint.ctx.workprec(2000):
        place = {bool(z.real > 0): i for i, z in enumerate(ring._roots(2000)) if i < 2}
        other = {bool(z.real > 0): i for i, z in enumerate(ring._roots(2000)) if i >= 2}
        x = ring.root(other[True]) - ring.root(place[True])
        assert abs(ring._value(x)) > arb(2) ** -ring._gap(x)
        assert ring._gap(x) == ring._gap(-x) == ring._gap(ring.root(0) + ring.root(2))
    assert not ring.is_zero(x)
    assert ring.is_zero(x * (ring.root(other[True]) + ring.root(place[True])) - 1)
    assert ring.is_zero(ring.root(0) + ring.root(1))


def test_an_exponential_is_a_delay_where_its_exponent_is_s_times_a_time_and_nothing_else() -> None:
    for lag in (Rational(1, 10), Rational(7, 3)):
        assert Ring.of([exp(-s * lag)]).lags == (lag,)
    for exponent in (1 - s / 10, -(s**2), -(s**2) - s, -1 / s - s, -(s**2) + 3, s * 0 + 2):
        with pytest.raises(SceneError, match=r"is not a delay: the exponent must be -s times a time"):
            Ring.of([exp(exponent)])


@pytest.mark.parametrize("power", [1 - 2 * a, -a / 3, 2 * a - 1, 3 - a, -2 * a - 5, a])
def test_a_power_of_s_that_falls_with_a_symbol_is_the_inverse_of_one_that_grows(power: Expr) -> None:
    ring = Ring.of([s**power])
    assert all(x.as_coeff_Mul()[0] > 0 for x in ring.orders)
    told, known = ring.convert(s**power + 1).expression(), {s: Rational(7, 2), a: Rational(1, 3)}
    assert abs((told - s**power - 1).subs(known).evalf(30)) < 1e-20
