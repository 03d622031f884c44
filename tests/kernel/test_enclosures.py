"""What certified zeros stand on: Taylor coefficients and ranges that enclose, and factors that are proven irreducible."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from math import comb, prod
from typing import Any

import flint
import mpmath
import pytest
from flint import arb, arb_series, fmpq
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sympy import Expr, Integer, Rational, factor_list, pi, symbols

from haptisym.kernel.bernstein import range_of
from haptisym.kernel.eliminants import discriminant, resultant
from haptisym.kernel.exactwaves import exact_waves, order_at_0, taylor_coefficients
from haptisym.kernel.reals import bounds, expression_ball
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.waves import power_series as power_coefficients
from haptisym.kernel.waves import product
from haptisym.kernel.wavesums import WaveSum, WaveTerm, _compiled

small = st.integers(-5, 5)
rates = st.fractions("1/100", 3, max_denominator=100)


@st.composite
def wave_sums(draw: st.DrawFn) -> WaveSum:
    """Up to three angles, one of which may be constant, and a power of omega."""
    angles = draw(st.lists(st.tuples(rates, st.booleans()), max_size=3))
    degrees = tuple(draw(st.integers(0, 3)) for _ in angles)
    orders = draw(st.sampled_from([(), (Rational(1, 3),)]))
    keys = st.tuples(st.tuples(*(st.integers(0, n) for n in degrees)), st.tuples(*(st.integers(0, 2) for _ in orders)))
    rows = st.lists(st.tuples(small, small), min_size=1, max_size=4).map(tuple)
    terms = tuple(WaveTerm(*key, draw(rows)) for key in draw(st.lists(keys, min_size=1, max_size=5, unique=True)))
    return WaveSum(terms, tuple((Rational(r.numerator, r.denominator), c) for r, c in angles), degrees, orders)


def value(f: WaveSum, x: mpmath.mpf) -> mpmath.mpf:
    """The sum as it is written in the data sheet of ``WaveSum``."""
    total = mpmath.mpf(0)
    for term in f.terms:
        halves = [mpmath.mpf(r.p) / r.q / 2 * (1 if constant else x) for r, constant in f.rates]
        waves = [
            mpmath.sin(h) ** k * mpmath.cos(h) ** (n - k) for h, k, n in zip(halves, term.turns, f.degrees, strict=True)
        ]
        powers = [x ** (mpmath.mpf(a.p) / a.q * n) for a, n in zip(f.orders, term.powers, strict=True)]
        row = [sum(c * mpmath.pi**i for i, c in enumerate(own)) * x**n for n, own in enumerate(term.coefficients)]
        total += sum(row) * prod(waves) * prod(powers)
    return total


@given(wave_sums(), st.fractions("1/2", 12, max_denominator=8))
def test_taylor_coefficients_are_those_of_mpmath(f: WaveSum, place: Rational) -> None:
    with mpmath.workdps(60):
        at = mpmath.mpf(place.numerator) / place.denominator
        expected = mpmath.taylor(lambda x: value(f, x), at, 4)
        with flint.ctx.workprec(200):
            found = f.series(arb(fmpq(place.numerator, place.denominator)), 0, 5)
        scale = max(map(abs, expected)) + 1
        for ball, true in zip(found, expected, strict=True):
            assert abs(mpmath.mpf(ball.mid().str(50, radius=False)) - true) < scale * mpmath.mpf(10) ** -8
            assert float(ball.rad()) < 1e-30 * float(scale)


@given(wave_sums(), st.fractions(1, 12, max_denominator=8), st.sampled_from([0.0, 1e-3, 0.3]))
def test_values_slopes_and_curvatures_over_a_ball_hold_those_of_every_point_in_it(
    f: WaveSum, place: Rational, reach: float
) -> None:
    middle = place.numerator / place.denominator
    with flint.ctx.workprec(128):
        box = arb(middle, reach)
        whole = f.over(box)
        for share in (-1, -0.7, 0, 0.4, 1):
            point = f.series(arb(middle + share * reach), 0, 3)
            assert all(wide.overlaps(thin) for wide, thin in zip(whole, point, strict=True))


@given(st.lists(small, min_size=1, max_size=8), st.sampled_from([0, 1, 3]))
def test_the_range_of_a_polynomial_holds_its_values_and_its_ends(row: list[int], reach: int) -> None:
    with flint.ctx.workprec(128):
        found = range_of([arb(c) for c in row], [arb(reach) ** n for n in range(len(row))])
        for share in range(-8, 9):
            assert found.contains(arb(sum(c * fmpq(share * reach, 8) ** n for n, c in enumerate(row))))


def test_the_range_of_a_monotone_polynomial_is_that_of_its_ends() -> None:
    """Where naive interval arithmetic finds [-7, 7], Bernstein's coefficients end at the values at the ends."""
    found = range_of([arb(0), arb(3), arb(3), arb(1)], [arb(1)] * 4)  # (1 + h)^3 - 1
    assert (float(found.lower()), float(found.upper())) == pytest.approx((-1, 7), abs=1e-7)  # a radius has 30 bits


w, a, b = symbols("w a b", positive=True)
monomials = st.tuples(st.integers(0, 3), st.integers(0, 2), st.integers(0, 2), st.integers(-9, 9).filter(bool))
polynomials = st.lists(monomials, min_size=1, max_size=4).map(
    lambda terms: sum(c * w**i * a**j * b**k for i, j, k, c in terms)
)


@given(polynomials, polynomials, st.integers(1, 2))
def test_factors_are_those_of_sympy(f: Expr, g: Expr, power: int) -> None:
    """The quick proof that a polynomial is irreducible must never call one so that is not, nor change a factor."""
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


@st.composite
def in_three_variables(draw: st.DrawFn, least: int, most: int) -> Any:
    """Of a degree in x from least to most, with whole numbers of up to 60 bits."""
    degree = draw(st.integers(least, most))
    key = st.tuples(st.integers(0, degree), st.integers(0, 3), st.just(0), st.integers(0, 2))
    terms = draw(st.dictionaries(key, st.integers(-(2**60), 2**60).filter(bool), min_size=1, max_size=14))
    lead = draw(st.tuples(st.just(degree), st.integers(0, 2), st.just(0), st.integers(0, 1)))
    return context.from_dict({**{e: fmpq(c) for e, c in terms.items()}, lead: fmpq(draw(st.integers(1, 9)))})


@examples(60)
@given(in_three_variables(2, 6), in_three_variables(1, 5))
def test_discriminants_and_resultants_by_values_are_those_of_polynomial_arithmetic(f: Any, g: Any) -> None:
    assert discriminant(f, 0) == f.discriminant("x")
    assert resultant(f, g, 0) == f.resultant(g, "x")


@pytest.mark.slow
def test_a_leading_coefficient_that_vanishes_on_the_first_grid_moves_it() -> None:
    x, a, _, c = context.gens()
    f = (a - 1) * (c - 2) * x**6 + (a + c**2) * x**5 + 7 * x**2 - a * c
    assert discriminant(f, 0) == f.discriminant("x")
    assert discriminant(f**2, 0).is_zero()


# --- containment: wide balls, high orders, sums without angles -------------------------------------------------------


def power_series(f: WaveSum, x: Any, length: int) -> list[Any]:
    """The Taylor coefficients about a number by FLINT's arithmetic of power series, from the sum as it is written."""
    h = arb_series([x, 1], prec=length)
    total = arb_series([0], prec=length)
    for term in f.terms:
        row = sum((arb_series([sum((c * arb.pi() ** i for i, c in enumerate(own)), arb(0))], prec=length) * h**n
                   for n, own in enumerate(term.coefficients)), arb_series([0], prec=length))  # fmt: skip
        for (rate, constant), k, n in zip(f.rates, term.turns, f.degrees, strict=True):
            half = (arb_series([1], prec=length) if constant else h) * (expression_ball(rate) / 2)
            row = row * half.sin() ** k * half.cos() ** (n - k)
        for order, n in zip(f.orders, term.powers, strict=True):
            row = row * ((h.log() * (expression_ball(order) * n)).exp() if n else 1)
        total = total + row
    return (total.coeffs() + [arb(0)] * length)[:length]


def check_held(told: Iterable[Sequence[Any]], f: WaveSum, middle: float, reach: float) -> None:
    """Balls of the first three Taylor coefficients of a sum hold those at points all over a ball of that reach."""
    for share in (-1, -0.93, -0.6, -0.4, 0.2, 0.3, 0.71, 1):
        truths = power_series(f, arb(middle) + arb(share) * arb(reach), 3)
        for balls in told:
            for ball, true in zip(balls, truths, strict=True):
                assert (ball + arb(0, 1e-30) * (1 + abs(true))).contains(true), share


@examples(60)
@given(wave_sums(), st.fractions(2, 12, max_denominator=8), st.sampled_from([1e-6, 0.05, 0.4, 1.3]))
def test_wide_balls_hold_value_slope_and_half_curvature_of_every_point(
    f: WaveSum, place: Rational, reach: float
) -> None:
    middle = place.numerator / place.denominator
    with flint.ctx.workprec(160):
        box = arb(middle, reach)
        whole, naive = f.over(box), f.series(box, 0, 3)
        check_held([whole, naive], f, middle, reach)


def far_apart(chance: random.Random) -> tuple[WaveSum, float, float]:
    """A sum, a place and a reach of sizes far apart: rates of 10^-6 to 50, coefficients up to 10^12, places of 10^-6 to 10^4."""
    angles = chance.randint(0, 3)
    rates = tuple(
        (Rational(chance.choice([-1, 1]) * chance.randint(1, 50), chance.choice([1, 7, 1000, 10**6])) * chance.choice([1, 1, pi]),
         chance.random() < 0.3)
        for _ in range(angles)
    )  # fmt: skip
    degrees = tuple(chance.randint(0, 4) for _ in rates)
    orders = chance.choice([(), (Rational(1, 3),), (Rational(chance.randint(1, 9), 7), Rational(5, 2)), (pi / 5,)])
    keys = {
        (tuple(chance.randint(0, n) for n in degrees), tuple(chance.randint(0, 3) for _ in orders)) for _ in range(4)
    }
    terms = tuple(
        WaveTerm(*key, tuple(tuple(chance.randint(-(10 ** chance.randint(0, 12)), 10**12) for _ in range(chance.randint(1, 3)))
                             for _ in range(chance.randint(1, 5))))
        for key in sorted(keys)
    )  # fmt: skip
    middle = 10 ** chance.uniform(-6, 4)
    return WaveSum(terms, rates, degrees, orders), middle, middle * 10 ** chance.uniform(-12, -0.05 if orders else 1)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(12))
def test_balls_of_sizes_far_apart_hold_value_and_derivatives_at_any_precision(seed: int) -> None:
    chance = random.Random(seed)
    for _ in range(20):
        f, middle, reach = far_apart(chance)
        with flint.ctx.workprec(chance.choice([53, 64, 128, 300])):
            box = arb(middle, reach)
            told = [f.over(box), f.series(box, 0, 5), (f.value(box),)]
            late = f.series(box, 2, 5)
        with flint.ctx.workprec(3000):
            for share in (-1, -0.99, -0.5, 0, 0.3, 0.8, 1):
                true = power_series(f, box.mid() + arb(share) * box.rad(), 5)
                for balls, truths in ((told[0], true), (told[1], true), (told[2], true), (late, true[2:])):
                    assert all(ball.overlaps(x) for ball, x in zip(balls, truths, strict=False)), (f, middle, reach)


@examples(40)
@given(wave_sums(), st.fractions(2, 12, max_denominator=8), st.sampled_from([1e-6, 0.05, 0.4, 1.3]))
def test_what_stands_before_each_power_of_omega_is_held_over_wide_balls(
    f: WaveSum, place: Rational, reach: float
) -> None:
    middle = place.numerator / place.denominator
    alone = {
        powers: replace(
            f, orders=(), terms=tuple(WaveTerm(x.turns, (), x.coefficients) for x in f.terms if x.powers == powers)
        )
        for powers in {x.powers for x in f.terms}
    }
    with flint.ctx.workprec(160):
        box = arb(middle, reach)
        ranges = f.ranges(box)
        assert ranges.keys() == alone.keys()
        for powers, own in alone.items():
            check_held([(ranges[powers], *f.before(box, [(powers, 1), (powers, 2)]))], own, middle, reach)


@examples(60)
@given(st.fractions("1/9", 9, max_denominator=9), st.integers(-7, 7), st.integers(1, 12), st.sampled_from([0, 1, 5]))
def test_powers_of_squares_have_their_exact_taylor_coefficients(r: Fraction, k: int, length: int, wide: int) -> None:
    """About r^2, x^(k/2) has binomial(k/2, n) r^(k - 2 n); a ball around r^2 holds those of all its points."""
    exact, binomial = [], Fraction(1)
    for n in range(length):
        exact.append(binomial * Fraction(r.numerator, r.denominator) ** (k - 2 * n))
        binomial = binomial * (Fraction(k, 2) - n) / (n + 1)
    with flint.ctx.workprec(100):
        square = arb(fmpq(r.numerator, r.denominator)) ** 2
        found = power_coefficients(square + square * arb(0, wide / 16), arb(k) / 2, length)
    assert len(found) == length
    assert all(low <= x <= high for (low, high), x in zip(map(bounds, found), exact, strict=True))
    assert wide or all(ball.rel_accuracy_bits() > 60 for ball, x in zip(found, exact, strict=True) if x)


@given(st.lists(st.tuples(small, small), min_size=1, max_size=20))
def test_a_product_of_taylor_series_is_that_of_exact_arithmetic(rows: list[tuple[int, int]]) -> None:
    left, right = ([row[i] for row in rows] for i in (0, 1))
    exact = [sum(left[m] * right[n - m] for m in range(n + 1)) for n in range(len(rows))]
    with flint.ctx.workprec(60):
        found = product([arb(x, 0.25) for x in left], [arb(x, 0.5) for x in right])
        least = product([arb(x) - arb(0.25) for x in left], [arb(x) + arb(0.5) for x in right])
    assert len(found) == len(least) == len(exact)
    assert all(ball.contains(x) and ball.contains(y) for ball, x, y in zip(found, exact, least, strict=True))


@given(wave_sums())
def test_a_sum_that_shows_itself_is_not_zero_everywhere(f: WaveSum) -> None:
    with flint.ctx.workprec(128):
        shown = f.shows_itself
    if shown:
        with mpmath.workdps(40):
            assert any(abs(value(f, mpmath.mpf(n) / 7)) > 1e-30 for n in range(1, 60))


def test_sums_that_cancel_do_not_show_themselves() -> None:
    """cos(pi/2) (1 + omega), and omega^(1/3) omega^(1/3) omega^(1/3) - omega, are 0; sin(pi/2) omega is not.

    Nor do those of two angles: 2 sin x cos x cos 2x - (cos^2 x - sin^2 x) sin 2x is 0.
    """
    right = ((pi, True),)
    cosine, sine = (WaveTerm((k,), (), ((1,), (1,))) for k in (0, 1))
    cube, line = WaveTerm((), (3,), ((1,),)), WaveTerm((), (0,), ((0,), (-1,)))
    with flint.ctx.workprec(128):
        assert not WaveSum((cosine,), right, (1,), ()).shows_itself
        assert WaveSum((sine,), right, (1,), ()).shows_itself
        assert not WaveSum((cube, line), (), (), (Rational(1, 3),)).shows_itself
        double = [WaveTerm(turns, (), ((n,),)) for turns, n in (((1, 0), 2), ((0, 1), -1), ((2, 1), 1))]
        assert not WaveSum(tuple(double), ((Integer(1), False), (Integer(2), False)), (2, 1), ()).shows_itself


@pytest.mark.parametrize("reach", [1e-4, 0.02, 0.2])
def test_ranges_over_a_ball_are_nearly_those_of_the_function(reach: float) -> None:
    """sin(x)^3 - 3 x cos(x) sin(x)^2 x^(1/3) ...: terms that cancel, over balls shorter than its waves."""
    terms = (
        WaveTerm((3,), (0,), ((1,), (2,))),
        WaveTerm((2,), (1,), ((0,), (-3,))),
        WaveTerm((0,), (0,), ((5,), (0,), (-1, 2))),
    )
    f = WaveSum(terms, ((Rational(2), False),), (3,), (Rational(1, 3),))
    for place in (1.0, 2.7, 6.0):
        with flint.ctx.workprec(128):
            found = f.over(arb(place, reach))
            grid = [f.series(arb(place + reach * n / 50), 0, 3) for n in range(-50, 51)]
        for n, ball in enumerate(found):
            values = [float(row[n].mid()) for row in grid]
            assert float(ball.upper() - ball.lower()) <= 1.6 * (max(values) - min(values)) + 1e-9


@examples(40)
@given(wave_sums(), st.fractions("1/2", 12, max_denominator=8), st.integers(0, 6), st.integers(1, 4))
def test_series_may_begin_at_any_order_and_taylor_coefficients_stand_alone(
    f: WaveSum, place: Rational, start: int, count: int
) -> None:
    with flint.ctx.workprec(150):
        at = arb(fmpq(place.numerator, place.denominator))
        whole = f.series(at, 0, start + count)
        part = f.series(at, start, start + count)
        compiled = _compiled(f, 150)
        assert len(part) == count
        for a, b in zip(part, whole[start:], strict=True):
            assert a.overlaps(b)
            assert a.rad() < 1e-30 * (1 + abs(a))
        assert compiled.taylor(at, start).overlaps(whole[start])
        assert f.value(at).overlaps(f.series(at, 0, 1)[0])
        assert compiled.value(at).overlaps(f.value(at))


@examples(60)
@given(wave_sums(), st.fractions("1/2", 12, max_denominator=8))
def test_coefficients_of_high_order_are_those_of_power_series(f: WaveSum, place: Rational) -> None:
    with flint.ctx.workprec(200):
        at = arb(fmpq(place.numerator, place.denominator))
        for found, true in zip(f.series(at, 0, flint.ctx.cap), power_series(f, at, flint.ctx.cap), strict=True):
            assert found.overlaps(true)
            assert found.rad() < 1e-30 * (1 + abs(true))


def test_sums_without_angles_are_polynomials_with_powers() -> None:
    line = WaveSum((WaveTerm((), (), ((2,), (0, 3), (1,))),), (), (), ())  # 2 + 3 pi x + x^2
    with flint.ctx.workprec(100):
        row = line.series(arb(2), 0, 4)
        for found, true in zip(row, (6 + 6 * arb.pi(), 3 * arb.pi() + 4, arb(1), arb(0)), strict=True):
            assert found.overlaps(true)
            assert found.rad() < 1e-25
        still = WaveSum(
            (WaveTerm((1,), (), ((2,),)), WaveTerm((0,), (), ((5,),))), ((pi / 3, True),), (1,), ()
        )  # 2 sin + 5 cos of pi/6
        assert still.value(arb(7)).overlaps(1 + 5 * arb(3).sqrt() / 2)
        assert all(c.is_zero() for c in still.series(arb(7), 1, 4))
        assert [float(c.mid()) for c in power_coefficients(arb(4), arb("0.5"), 4)] == [2, 0.25, -1 / 64, 1 / 512]
        assert len(power_coefficients(arb(4), arb("0.5"), 1)) == 1


@given(
    st.lists(st.tuples(small, st.sampled_from([0, 1, "1/8"])), min_size=1, max_size=7),
    st.sampled_from([0, "1/64", 1, 5]),
)
def test_the_range_of_a_polynomial_with_balls_for_coefficients_holds_all_its_values(
    row: list[tuple[int, object]], reach: object
) -> None:
    """Bernstein's coefficients of every choice in the balls; no wider than those of the middles and the radii apart."""
    r = Rational(str(reach))
    radii = [Rational(str(x)) for _, x in row]
    with flint.ctx.workprec(128):
        balls = [arb(fmpq(c), float(x)) for (c, _), x in zip(row, radii, strict=True)]
        found = range_of(balls, [arb(fmpq(int(r.p), int(r.q))) ** n for n in range(len(row))])
        low, high = (Rational(end.mid().str(40, radius=False)) for end in (found.lower(), found.upper()))
    places = [Rational(share, 8) * r for share in range(-8, 9)]
    values = [
        sum(
            (c + side * x * (1 if h**n >= 0 else -1)) * h**n
            for n, ((c, _), x) in enumerate(zip(row, radii, strict=True))
        )
        for h in places
        for side in (1, -1)
    ]
    hair = Rational(1, 10**7) * (1 + max(map(abs, values)))
    assert low - hair <= min(values)
    assert max(values) <= high + hair
    # at the ends Bernstein's coefficients are the values, and all are at most the sum of sizes
    assert (
        max(abs(low), abs(high))
        <= sum((abs(c) + x) * 2**n * r**n for n, ((c, _), x) in enumerate(zip(row, radii, strict=True))) + hair
    )


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 6])
def test_a_linear_polynomial_s_range_is_exact_in_any_degree(degree: int) -> None:
    """Degree elevation changes nothing: 3 + 2 h on [-5, 5] is [-7, 13], with however many zeros behind."""
    with flint.ctx.workprec(128):
        row = [arb(3), arb(2)][: degree + 1] + [arb(0)] * (degree - 1)
        found = range_of(row, [arb(5) ** n for n in range(degree + 1)])
    expected = (-7, 13) if degree else (3, 3)
    assert (float(found.lower()), float(found.upper())) == pytest.approx(expected, abs=1e-6)


# --- orders at omega = 0 ----------------------------------------------------------------------------------------------


@examples(60)
@given(wave_sums())
def test_orders_at_zero_are_those_of_the_exact_taylor_coefficients(f: WaveSum) -> None:
    turning = [i for i, (_, constant) in enumerate(f.rates) if not constant]
    own = replace(
        f,
        orders=(),
        rates=tuple(f.rates[i] for i in turning),
        degrees=tuple(f.degrees[i] for i in turning),
        terms=tuple({tuple(x.turns[i] for i in turning): WaveTerm(tuple(x.turns[i] for i in turning), (), x.coefficients)
                     for x in f.terms}.values()),
    )  # fmt: skip
    waves = exact_waves(own, Integer(0))
    assert waves is not None
    exact = taylor_coefficients(own, Integer(0), waves)
    first = next((n for n, c in zip(range(12), exact, strict=False) if not c.is_zero), None)
    assert order_at_0(own) == first


def test_what_cancels_at_zero_for_long_is_followed_order_by_order() -> None:
    """(sin x - x cos x)^k has order 3 k, with pi before it too; a constant angle is not its business."""
    for k in range(1, 5):
        terms = tuple(
            WaveTerm((j,), (), (*[(0, 0)] * (k - j), (0, comb(k, j) * (-1) ** (k - j)))) for j in range(k + 1)
        )
        assert order_at_0(WaveSum(terms, ((Rational(2), False),), (k,), ())) == 3 * k
    turned = WaveSum((WaveTerm((1,), (), ((1,),)),), ((pi / 3, True),), (1,), ())
    assert order_at_0(turned) is None
    assert order_at_0(WaveSum((WaveTerm((1,), (), ((1,),)),), ((pi / 3, False),), (1,), ())) is None


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(8))
def test_exact_taylor_coefficients_at_eighths_of_a_turn_are_those_of_power_series_times_one_number(seed: int) -> None:
    chance, seen, zero = random.Random(seed), 0, 0
    for _ in range(20):
        base, turning = Rational(chance.randint(1, 9), chance.choice([1, 2, 7, 1000])), chance.choice([Integer(1), pi])
        rates = tuple((base * turning * chance.randint(1, 4), False) for _ in range(chance.randint(1, 2)))
        degrees = tuple(chance.randint(1, 4) for _ in rates)
        keys = sorted({tuple(chance.randint(0, n) for n in degrees) for _ in range(4)})
        f = WaveSum(
            tuple(
                WaveTerm(key, (), tuple((chance.randint(-9, 9), chance.randint(-1, 1)) for _ in range(3)))
                for key in keys
            ),
            rates,
            degrees,
            (),
        )
        place = chance.choice([Integer(0), chance.randint(-9, 30) * pi / (2 * base * turning)])
        waves = exact_waves(f, place)
        if waves is None:
            continue
        found = list(islice(taylor_coefficients(f, place, waves), 4))
        with flint.ctx.workprec(600):
            true = power_series(f, expression_ball(place), 4)
            own = [in_pi(x.numerator) / in_pi(x.denominator) for x in found]
            for x, a, b in zip(found, own, true, strict=True):
                assert x.is_zero == (abs(b) < arb(2) ** -400)
                assert all((a * d).overlaps(b * c) for c, d in zip(own, true, strict=True))
                zero += x.is_zero
        seen += 1
    assert seen > 15
    assert zero > 0


def in_pi(polynomial: Any) -> Any:
    """The value of a polynomial of which pi is the only variable that is there."""
    assert all(not any(n for i, n in enumerate(map(int, e)) if i != 1) for e in polynomial.monoms())
    return sum((arb(c) * arb.pi() ** int(e[1]) for e, c in polynomial.to_dict().items()), arb(0))
