"""What certified zeros stand on: Taylor coefficients, ranges and signs that enclose, against exact arithmetic, mpmath and FLINT's power series."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import islice, pairwise
from math import comb, prod
from typing import Any

import flint
import mpmath
import pytest
from flint import arb, arb_poly, arb_series, fmpq, fmpq_poly
from hypothesis import assume, given
from hypothesis import strategies as st
from marks import examples
from sympy import Integer, Rational, pi

from haptisym.kernel.delayterms import WaveSum, WaveTerm
from haptisym.kernel.delayterms import power_series as power_coefficients
from haptisym.kernel.enclosures import FunctionPiece, over_ellipse, range_of
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.factors import AnalyticFactor
from haptisym.kernel.leadingterm import clear_of_zero, exact_directions, leading_term, order_at_0, taylor_coefficients
from haptisym.kernel.reals import bounds, dyadic, expression_ball

small = st.integers(-5, 5)


# Sums of waves and powers of omega


speeds = st.fractions("1/100", 3, max_denominator=100)


@st.composite
def wave_sums(draw: st.DrawFn) -> WaveSum:
    """Up to three angles, one of which may be constant, and a power of omega."""
    angles = draw(st.lists(st.tuples(speeds, st.booleans()), max_size=3))
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
            mpmath.sin(h) ** k * mpmath.cos(h) ** (n - k) for h, k, n in zip(halves, term.sines, f.degrees, strict=True)
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


def power_series(f: WaveSum, x: Any, length: int) -> list[Any]:
    """The Taylor coefficients about a number by FLINT's arithmetic of power series, from the sum as it is written."""
    h = arb_series([x, 1], prec=length)
    total = arb_series([0], prec=length)
    for term in f.terms:
        row = sum((arb_series([sum((c * arb.pi() ** i for i, c in enumerate(own)), arb(0))], prec=length) * h**n
                   for n, own in enumerate(term.coefficients)), arb_series([0], prec=length))  # fmt: skip
        for (rate, constant), k, n in zip(f.rates, term.sines, f.degrees, strict=True):
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


@examples(40)
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
    """A sum, a place and a reach of sizes far apart: speeds of 10^-6 to 50, coefficients up to 10^12, places of 10^-6 to 10^4."""
    angles = chance.randint(0, 3)
    speeds = tuple(
        (Rational(chance.choice([-1, 1]) * chance.randint(1, 50), chance.choice([1, 7, 1000, 10**6])) * chance.choice([1, 1, pi]),
         chance.random() < 0.3)
        for _ in range(angles)
    )  # fmt: skip
    degrees = tuple(chance.randint(0, 4) for _ in speeds)
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
    return WaveSum(terms, speeds, degrees, orders), middle, middle * 10 ** chance.uniform(-12, -0.05 if orders else 1)


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
            f, orders=(), terms=tuple(WaveTerm(x.sines, (), x.coefficients) for x in f.terms if x.powers == powers)
        )
        for powers in {x.powers for x in f.terms}
    }
    with flint.ctx.workprec(160):
        box = arb(middle, reach)
        ranges = f.cofactor_ranges(box)
        assert ranges.keys() == alone.keys()
        for powers, own in alone.items():
            check_held([(ranges[powers], *f.cofactor_series(box, [(powers, 1), (powers, 2)]))], own, middle, reach)


@examples(40)
@given(wave_sums(), st.fractions("1/2", 12, max_denominator=8))
def test_coefficients_of_high_order_are_those_of_power_series(f: WaveSum, place: Rational) -> None:
    with flint.ctx.workprec(200):
        at = arb(fmpq(place.numerator, place.denominator))
        for found, true in zip(f.series(at, 0, flint.ctx.cap), power_series(f, at, flint.ctx.cap), strict=True):
            assert found.overlaps(true)
            assert found.rad() < 1e-30 * (1 + abs(true))


@examples(40)
@given(wave_sums(), st.fractions("1/2", 12, max_denominator=8), st.integers(0, 6), st.integers(1, 4))
def test_series_may_begin_at_any_order_and_taylor_coefficients_stand_alone(
    f: WaveSum, place: Rational, start: int, count: int
) -> None:
    with flint.ctx.workprec(150):
        at = arb(fmpq(place.numerator, place.denominator))
        whole = f.series(at, 0, start + count)
        part = f.series(at, start, start + count)
        assert len(part) == count
        for a, b in zip(part, whole[start:], strict=True):
            assert a.overlaps(b)
            assert a.rad() < 1e-30 * (1 + abs(a))
        assert AnalyticFactor(f.terms, f.rates, f.degrees, f.orders).taylor(at, start).overlaps(whole[start])
        assert f.value(at).overlaps(f.series(at, 0, 1)[0])


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


@given(wave_sums())
def test_a_sum_that_shows_itself_is_not_zero_everywhere(f: WaveSum) -> None:
    with flint.ctx.workprec(128):
        shown = f.is_shown_nonzero
    assume(shown)
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
        assert not WaveSum((cosine,), right, (1,), ()).is_shown_nonzero
        assert WaveSum((sine,), right, (1,), ()).is_shown_nonzero
        assert not WaveSum((cube, line), (), (), (Rational(1, 3),)).is_shown_nonzero
        double = [WaveTerm(turns, (), ((n,),)) for turns, n in (((1, 0), 2), ((0, 1), -1), ((2, 1), 1))]
        assert not WaveSum(tuple(double), ((Integer(1), False), (Integer(2), False)), (2, 1), ()).is_shown_nonzero


@examples(40)
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


# Orders at omega = 0 and at eighths of a turn


@examples(40)
@given(wave_sums())
def test_orders_at_zero_are_those_of_the_exact_taylor_coefficients(f: WaveSum) -> None:
    turning = [i for i, (_, constant) in enumerate(f.rates) if not constant]
    own = replace(
        f,
        orders=(),
        rates=tuple(f.rates[i] for i in turning),
        degrees=tuple(f.degrees[i] for i in turning),
        terms=tuple({tuple(x.sines[i] for i in turning): WaveTerm(tuple(x.sines[i] for i in turning), (), x.coefficients)
                     for x in f.terms}.values()),
    )  # fmt: skip
    waves = exact_directions(own, Integer(0))
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
        waves = exact_directions(f, place)
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


MEETING = {"1/2": 8, "2/3": 6, "4/3": 3, "4/5": 5}
"""Orders, and of how many half angles alpha pi/4 the sum is a whole number of half turns: there Im (cos + j sin)^m is 0."""


def with_powers(draw: random.Random) -> tuple[WaveSum, Callable[[mpmath.mpf], mpmath.mpf]]:
    """Sums of powers omega^(alpha l) of which some begin with what cancels, behind a delay; and the same in mpmath."""
    order, m = draw.choice(list(MEETING.items()))
    alpha, lag = Rational(order), Rational(draw.randint(1, 9), 7)
    nothing = [(-1) ** (k // 2) * comb(m, k) if k % 2 else 0 for k in range(m + 1)]
    terms: dict[tuple[tuple[int, int], int], list[int]] = {}
    for power in range(draw.randint(1, 3)):
        for _ in range(2):
            low, late, size = draw.randint(0, 2), draw.randint(0, 1), draw.choice([-3, 1, 2])
            for k in range(m + 1):
                row = terms.setdefault(((k, late), power), [0] * 5)
                row[low] += size * nothing[k]
                row[low + draw.randint(0, 2)] += draw.randint(-2, 2) * (draw.random() < 0.2 and low > 0)
    kept = {key: row for key, row in terms.items() if any(row)}
    found = WaveSum(
        tuple(WaveTerm(turns, (power,), tuple((c,) for c in row)) for (turns, power), row in kept.items()),
        ((pi * alpha / 2, True), (lag, False)),
        (m, 1),
        (alpha,),
    )

    def value(w: mpmath.mpf) -> mpmath.mpf:
        exponent = mpmath.mpf(alpha.p) / alpha.q
        (c, s), late = (f(mpmath.pi * exponent / 4) for f in (mpmath.cos, mpmath.sin)), w * lag.p / lag.q / 2
        delayed, raised = (mpmath.cos(late), mpmath.sin(late)), w**exponent
        return mpmath.fsum(
            mpmath.polyval(row[::-1], w) * raised**power * s**k * c ** (m - k) * delayed[turn]
            for ((k, turn), power), row in kept.items()
        )

    return found, value


@pytest.mark.dear("2")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(20))
def test_the_first_term_that_stays_is_found_and_no_zero_lies_before_the_place_that_is_said_to_be_clear(
    seed: int,
) -> None:
    draw, seen = random.Random(seed), 0
    for _ in range(6):
        f, value = with_powers(draw)
        with mpmath.workdps(260):
            near = [value(mpmath.mpf(10) ** n) for n in (-20, -25)]
            if abs(near[0]) < mpmath.mpf(10) ** -200:
                continue  # nothing at all
            exponent = mpmath.log(abs(near[0] / near[1]), 10) / 5
            assert abs(exponent - float(leading_term(f).exponent)) < 1e-2
            reach = mpmath.mpf(float(clear_of_zero(f, arb(2))))
            points = [reach * mpmath.mpf(10) ** -n for n in (20, 5, 2, 1)] + [reach * n / 12 for n in range(1, 13)]
            assert {value(x) > 0 for x in points} == {near[0] > 0}
            assert reach > 0
            seen += bool(leading_term(f).exponent > 0)
    assert seen > 1


@pytest.mark.parametrize("more", [1, -1, -3])
def test_powers_of_omega_that_are_closer_than_floats_are_not_put_in_a_wrong_order(more: int) -> None:
    """omega^(pi/4) - (1 + more/10^20) omega^r, r the first twenty digits of pi/4, is 0 where
    omega^(pi/4 - r) = 1 + more/10^20: at some frequency of everyday size."""
    size, digits = 10**20, Rational(78539816339744830961, 10**20)
    terms = WaveTerm((), (1, 0), ((size,),)), WaveTerm((), (0, 1), ((-size - more,),))
    f = WaveSum(terms, (), (), (pi / 4, digits))
    with mpmath.workdps(60):
        zero = mpmath.exp(mpmath.log1p(mpmath.mpf(more) / size) / (mpmath.pi / 4 - mpmath.mpf(digits.p) / digits.q))
        assert 0.001 < zero < 10
    with pytest.raises(UndecidedError):
        clear_of_zero(f, arb(10))


# Ranges of polynomials


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


def test_the_range_of_a_monotone_polynomial_is_that_of_its_ends() -> None:
    """Where naive interval arithmetic finds [-7, 7], Bernstein's coefficients end at the values at the ends."""
    found = range_of([arb(0), arb(3), arb(3), arb(1)], [arb(1)] * 4)  # (1 + h)^3 - 1
    assert (float(found.lower()), float(found.upper())) == pytest.approx((-1, 7), abs=1e-7)  # a radius has 30 bits


# Stretches of omega, in Bernstein's basis


def around(roots: list[Fraction], sign: int) -> Any:
    """The Taylor coefficients of the polynomial with those zeros, about any ball."""

    def series(x: Any, start: int, stop: int) -> list[Any]:
        total = arb_poly([sign])
        for root in roots:
            total = total * arb_poly([x - dyadic(root), 1])
        return (total.coeffs() + [arb(0)] * stop)[start:stop]

    return series


def with_slopes(roots: list[Fraction], sign: int) -> list[Any]:
    """The polynomial itself over the rational numbers, its slope and its curvature."""
    found = fmpq_poly([sign])
    for root in roots:
        found = found * fmpq_poly([fmpq(-root.numerator, root.denominator), 1])
    return [found, found.derivative(), found.derivative().derivative()]


@pytest.mark.parametrize("seed", range(20))
def test_signs_on_a_stretch_and_on_its_parts_are_those_of_exact_values(seed: int) -> None:
    """Polynomials of degree up to 14: above the order of the stretch, so that Taylor's remainder counts."""
    pick = random.Random(seed)
    roots = [Fraction(pick.randint(-300, 600), 64) for _ in range(pick.randint(1, 14))]
    sign, ends = pick.choice((-1, 1)), sorted(Fraction(pick.randint(0, 4000), 1024) for _ in range(2))
    ends[1] += Fraction(1, 1024)
    true, told = with_slopes(roots, sign), 0
    with flint.ctx.workprec(128):
        parts = sorted({*ends, *(ends[0] + (ends[1] - ends[0]) * Fraction(n, 8) for n in pick.sample(range(1, 8), 3))})
        stretches = [FunctionPiece.of(around(roots, sign), *map(dyadic, x)) for x in [tuple(ends), *pairwise(parts)]]
        for x in stretches:
            low, high = bounds(x.low)[0], bounds(x.high)[0]
            for order in range(3):
                seen = [low + (high - low) * Fraction(n, 16) for n in range(17)]
                values = [true[order](fmpq(at.numerator, at.denominator)) for at in seen]
                if said := x.sign(order):
                    told += 1
                    assert all(value * said > 0 for value in values)
                for end, value in ((0, values[0]), (-1, values[-1])):
                    if said := x.sign_at(end, order):
                        told += 1
                        assert value * said > 0
    assert told


@pytest.mark.parametrize("seed", range(20))
def test_a_zero_between_an_end_and_that_of_the_basis_is_never_overlooked(seed: int) -> None:
    """Bernstein's polynomials live on a hair more than the stretch; the sign at its end is that at the end itself, or does not show."""
    pick = random.Random(seed)
    for _ in range(10):
        low = Fraction(pick.getrandbits(100) | 1 << 100, 1 << 99)
        high = low + Fraction(pick.getrandbits(90) | 1 << 90, 1 << pick.choice([89, 91, 95]))
        with flint.ctx.workprec(128):
            plain = FunctionPiece.of(around([], 1), dyadic(low), dyadic(high))
            ends = [bounds(x)[0] for x in plain.ends]
            assert ends[0] <= low < high <= ends[1]
            for end, inner, outer in ((0, low, ends[0]), (-1, high, ends[1])):
                if inner == outer:
                    continue
                root = outer + (inner - outer) * Fraction(pick.randint(1, 4095), 4096)
                others = [
                    (high + pick.randint(0, 2) if end else low - pick.randint(0, 2))
                    - Fraction(pick.randint(0, 3)) * (low - high)
                    for _ in range(pick.choice([0, 2]))
                ]
                sign = pick.choice([-1, 1])
                x = FunctionPiece.of(around([root, *others], sign), dyadic(low), dyadic(high))
                true = with_slopes([root, *others], sign)[0](fmpq(inner.numerator, inner.denominator))
                assert x.sign_at(end) in (0, 1 if true > 0 else -1)


# Circles


def exactly(q: Fraction | int) -> Any:
    return arb(fmpq(Fraction(q).numerator, Fraction(q).denominator))


def rational(draw: random.Random, depth: int, leaf: Any, whole: Any) -> Any:
    """A random formula of x with numbers of Python among it, which is 1/0 nowhere near 0."""
    if depth == 0:
        return leaf
    one, kind = rational(draw, depth - 1, leaf, whole), draw.randrange(7)
    if kind < 4:
        other = rational(draw, depth - 1, leaf, whole) if draw.random() < 0.6 else whole(draw.randint(1, 9))
        return one + other if kind == 0 else one - other if kind == 1 else other - one if kind == 2 else one * other
    if kind == 4:
        return one / whole(draw.randint(2, 9))
    if kind == 5:
        return whole(draw.randint(1, 9)) / (one * one + 3)
    below, n = one * one + 1, draw.choice([-2, -1, 0, 3])
    return below**n if n >= 0 else whole(1) / below**-n


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(24))
def test_an_interpolated_function_has_all_its_values_and_slopes_and_hardly_more(seed: int) -> None:
    """At 17 places in between, exactly, whatever the interval; where it is small, by what the function changes over it."""
    draw = random.Random(seed)
    middle = Fraction(draw.randint(-20, 20), 7)
    told = 0
    for n in (4, 16, 64, 1000):
        radius = Fraction(1, n)
        with flint.ctx.workprec(200):
            line, constant = over_ellipse(
                lambda q: [rational(random.Random(seed), 3, q, int), q * 0 + 2], exactly(middle), exactly(radius)
            )
            assert constant.ball.contains(2)
            values = []
            for k in range(-8, 9):
                y = Fraction(k, 8)
                values.append(rational(random.Random(seed), 3, middle + radius * y, Fraction))
                assert not line.ball.is_finite() or line.ball.contains(exactly(values[-1]))
                assert not line.at.is_finite() or (line.at + line.slope * exactly(y)).contains(exactly(values[-1]))
            # Between two places the function has their mean slope somewhere.
            for before, after in pairwise(values):
                assert not line.rate.is_finite() or line.rate.contains(exactly(8 * (after - before)))
            told += line.ball.is_finite()
    assert told
    assert float(line.ball.rad()) <= 0.51 * float(max(values) - min(values)) + 1e-4 * float(
        radius * (1 + max(map(abs, values)))
    )


def test_sine_and_exponential_interpolated_are_nearly_straight() -> None:
    """exp(q) - 1 and sin(q) about 0, each a part of the other's argument: to a part in a million, where balls are off by a half."""
    with flint.ctx.workprec(128):
        [found] = over_ellipse(lambda q: [(q.exp() - 1).sin() - q], arb(0), arb("0.01"))
        assert abs(found.slope) < 1e-8
        assert float(found.at.lower()) <= -5e-7 + 1e-4 / 2
        assert found.ball.contains(((arb("0.01")).exp() - 1).sin() - arb("0.01"))
        assert found.ball.rad() < 3e-5
