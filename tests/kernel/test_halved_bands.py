"""Descartes' rule on halved bands: its coefficients as fractions, its counts beside Sturm's."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise

import pytest
from flint import fmpq, fmpz_poly
from sympy import Poly, Rational, Symbol

from haptisym.kernel.polynomials import PolynomialFactor

x = Symbol("x")


def irreducible(chance: random.Random) -> tuple[int, ...]:
    """Coefficients of up to 10^12, ascending; roots close together in every second case (Mignotte's)."""
    while True:
        n, size = chance.randint(2, 9), 10 ** chance.choice([1, 3, 12])
        row = [chance.randint(-size, size) for _ in range(n + 1)]
        if chance.random() < 0.5:
            a = chance.randint(2, 200)
            row = [-2, 4 * a, -2 * a * a, *[0] * (n - 2), 1] if n > 2 else row
        if row[0] and row[-1]:
            _, factors = fmpz_poly(row).factor()
            found = max((f for f, _ in factors), key=lambda f: f.degree())
            if found.degree() > 1:
                return tuple(map(int, found.coeffs()))


def dyadic(chance: random.Random) -> Fraction:
    return Fraction(chance.randint(0, 1 << 20), 1 << chance.randint(14, 24))


@pytest.mark.parametrize("step", [1, 2])
def test_coefficients_over_a_band_are_those_of_the_moved_polynomial(step: int) -> None:
    """p(x) (1 + t)^n at x^step = a + (b - a)/(1 + t), at whole numbers t, times one number > 0."""
    chance = random.Random(step)
    for _ in range(40):
        row = irreducible(chance)
        low, high = sorted((dyadic(chance), dyadic(chance)))
        if low == high:
            continue
        moved = PolynomialFactor(tuple((c,) for c in row), step)._moved(
            fmpq(low.numerator, low.denominator), fmpq(high.numerator, high.denominator)
        )
        a, b, n = low**step, high**step, len(row) - 1
        ratios = set()
        for t in range(n + 1):
            place = a + (b - a) / (1 + t)
            true = sum(c * place**k for k, c in enumerate(row)) * (1 + t) ** n
            told = sum(int(c) * t**k for k, c in enumerate(moved))
            ratios.add(Fraction(told) / true)
        assert len(ratios) == 1
        assert ratios.pop() > 0
        assert len(moved) == n + 1


@pytest.mark.parametrize("step", [1, 2])
def test_each_interval_holds_one_zero_and_none_is_left_out(step: int) -> None:
    chance, seen = random.Random(10 + step), 0
    for _ in range(80):
        row = irreducible(chance)
        low, high = (Rational(y.numerator, y.denominator) for y in sorted((dyadic(chance), dyadic(chance))))
        if low == high:
            continue
        factor = PolynomialFactor(tuple((c,) for c in row), step)
        p = Poly(list(row[::-1]), x)
        found = factor.zeros(low, high)
        assert len(found) >= p.count_roots(low**step, high**step)
        for zero in found:
            ends = [Rational(*(int(y) for y in (e.fmpq().p, e.fmpq().q))) ** step for e in (zero.low, zero.high)]
            assert p.count_roots(*ends) == 1
            assert p.eval(ends[0]) * p.eval(ends[1]) < 0
            least, most = (Rational(y.numerator, y.denominator) ** step for y in zero.bounds(80))
            assert p.count_roots(least, most) == 1
        assert all(a.high <= b.low for a, b in pairwise(found))
        sign = factor.steady_sign(low, high)
        assert not sign or (not found and sign * p.eval(high**step) > 0)
        seen += len(found)
    assert seen > 25
