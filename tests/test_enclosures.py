"""What certified zeros stand on: Taylor coefficients and ranges that enclose, and factors that are proven irreducible."""

from __future__ import annotations

from math import prod
from typing import Any

import flint
import mpmath
import pytest
from flint import arb, fmpq
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from sympy import Expr, Rational, factor_list, symbols

from haptisym.exact.bernstein import range_of
from haptisym.exact.eliminants import discriminant, resultant
from haptisym.exact.rings import PolynomialRing
from haptisym.exact.wavesums import Term, WaveSum

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
    terms = tuple(Term(*key, draw(rows)) for key in draw(st.lists(keys, min_size=1, max_size=5, unique=True)))
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


def test_a_leading_coefficient_that_vanishes_on_the_first_grid_moves_it() -> None:
    x, a, _, c = context.gens()
    f = (a - 1) * (c - 2) * x**6 + (a + c**2) * x**5 + 7 * x**2 - a * c
    assert discriminant(f, 0) == f.discriminant("x")
    assert discriminant(f**2, 0).is_zero()
