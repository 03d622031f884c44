"""A function on a stretch of omega, as a polynomial in Bernstein's basis: signs that hold at every point, cuts that lose nothing."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise
from math import comb
from typing import Any

import flint
import pytest
from flint import arb, arb_mat, arb_poly, fmpq, fmpq_poly

from haptisym.kernel.reals import bounds, dyadic
from haptisym.kernel.stretches import _CUT, Stretch, _cuts


def around(roots: list[Fraction], sign: int) -> Any:
    """The Taylor coefficients of the polynomial with those zeros, about any ball."""

    def series(x: Any, start: int, stop: int) -> list[Any]:
        total = arb_poly([sign])
        for root in roots:
            total = total * arb_poly([x - dyadic(root), 1])
        return (total.coeffs() + [arb(0)] * stop)[start:stop]

    return series


def exact(roots: list[Fraction], sign: int) -> list[Any]:
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
    true = exact(roots, sign)
    with flint.ctx.workprec(128):
        stretches = [Stretch.of(around(roots, sign), *map(dyadic, ends))]
        for _ in range(pick.randint(0, 6)):
            cut = stretches[-1].cut()
            if cut is None:
                break
            assert cut[0].high == cut[1].low
            assert (cut[0].low, cut[1].high) == (stretches[-1].low, stretches[-1].high)
            stretches += pick.sample(cut, 2)
        for x in stretches:
            low, high = bounds(x.low)[0], bounds(x.high)[0]
            for order in range(3):
                seen = [low + (high - low) * Fraction(n, 16) for n in range(17)]
                values = [true[order](fmpq(at.numerator, at.denominator)) for at in seen]
                if said := x.sign(order):
                    assert all(value * said > 0 for value in values)
                for end, value in ((0, values[0]), (-1, values[-1])):
                    if said := x.sign_at(end, order):
                        assert value * said > 0


@pytest.mark.parametrize("seed", range(20))
def test_the_one_zero_of_a_monotone_stretch_lies_between_numbers_near_it_that_are_no_zeros(seed: int) -> None:
    """Also one in the middle of the stretch, or next to one of its ends; others are away from it."""
    pick = random.Random(seed)
    low, reach = Fraction(pick.randint(-64, 64), 32), Fraction(pick.choice((1, 7, 16)), 16)
    root = low + reach * pick.choice(
        (Fraction(1, 2), Fraction(1, 4096), Fraction(4095, 4096), Fraction(11, 32), Fraction(5, 8))
    )
    others = [low + pick.choice((-1, 1)) * Fraction(pick.randint(600, 900), 64) for _ in range(pick.randint(0, 9))]
    true, sign = exact([root, *others], 1)[0], pick.choice((-1, 1))
    with flint.ctx.workprec(128):
        whole = Stretch.of(around([root, *others], sign), dyadic(low), dyadic(low + reach))
        assert whole.sign(1)
        ends = [bounds(x) for x in whole.nearer()]
    assert all(below == above for below, above in ends)
    (left, _), (right, _) = ends
    assert low <= left < root < right <= low + reach
    assert (right - left) * 20 < reach
    assert true(fmpq(left.numerator, left.denominator)) * true(fmpq(right.numerator, right.denominator)) < 0


@pytest.mark.parametrize("size", [fmpq(1), fmpq(10) ** 400, fmpq(10) ** -400])
def test_a_zero_between_slopes_of_all_sizes_stays_enclosed(size: fmpq) -> None:
    """x^7 + x/10^15 - 1 goes up by 10^-15 at 0, and 10^19 times as steeply at 4: a ball around all slopes held 0."""

    def series(x: Any, start: int, stop: int) -> list[Any]:
        row = [-1 + fmpq(1, 10**15) * x + x**7, fmpq(1, 10**15) + 7 * x**6]
        row += [comb(7, n) * x ** (7 - n) for n in range(2, 8)]
        return [size * c for c in [*row, arb(0)][start:stop]]

    with flint.ctx.workprec(128):
        whole = Stretch.of(series, arb(0), arb(4))
        assert whole.sign(1) == 1
        (low, _), (high, _) = map(bounds, whole.nearer())
    assert 0 <= low < high <= 4
    assert low**7 + low / 10**15 < 1 < high**7 + high / 10**15


@pytest.mark.parametrize("sign", [1, -1])
def test_a_stretch_without_zeros_shows_it_when_it_is_cut_often_enough(sign: int) -> None:
    roots = [Fraction(-1), Fraction(-1, 8), Fraction(5), Fraction(9)]
    with flint.ctx.workprec(128):
        waiting, clear = [Stretch.of(around(roots, sign), arb(0), arb("4.5"))], 0
        while waiting:
            x = waiting.pop()
            if x.sign():
                clear += 1
            else:
                parts = x.cut()
                assert x.is_sharp
                assert parts
                waiting += parts
    assert clear < 8


def test_no_cut_is_made_on_a_zero() -> None:
    """The cut of [0, 1] is at 127/256: with ends that hardly exceed it, a zero there shows no sign."""
    with flint.ctx.workprec(128):
        whole = Stretch.of(around([Fraction(2)], 1), arb(0), arb(1))
        cut = whole.cut()
        assert cut is not None
        place = bounds(cut[0].high)[0]
        assert abs(place - Fraction(127, 256)) < Fraction(1, 2**20)
        assert Stretch.of(around([place, Fraction(2)], 1), arb(0), arb(1)).cut() is None


@pytest.mark.parametrize("seed", range(20))
def test_a_zero_between_an_end_and_that_of_the_basis_is_never_overlooked(seed: int) -> None:
    """Bernstein's polynomials live on a hair more than the stretch; the sign at its end is that at the end itself, or does not show."""
    pick = random.Random(seed)
    for _ in range(10):
        low = Fraction(pick.getrandbits(100) | 1 << 100, 1 << 99)
        high = low + Fraction(pick.getrandbits(90) | 1 << 90, 1 << pick.choice([89, 91, 95]))
        with flint.ctx.workprec(128):
            plain = Stretch.of(around([], 1), dyadic(low), dyadic(high))
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
                x = Stretch.of(around([root, *others], sign), dyadic(low), dyadic(high))
                true = exact([root, *others], sign)[0](fmpq(inner.numerator, inner.denominator))
                assert x.sign_at(end) in (0, 1 if true > 0 else -1)


@pytest.mark.parametrize("degree", range(1, 12))
def test_coefficients_of_both_parts_are_those_of_blossoms_and_say_what_the_whole_does(degree: int) -> None:
    """De Casteljau's corners, in fractions; exact, as the cut is a dyadic number."""
    pick = random.Random(degree)
    row = [Fraction(pick.randint(-99, 99), 8) for _ in range(degree + 1)]
    cut, parts = Fraction(int(_CUT.p), int(_CUT.q)), [[row[0]], [row[-1]]]
    level = row
    while len(level) > 1:
        level = [a + cut * (b - a) for a, b in pairwise(level)]
        parts[0].append(level[0])
        parts[1].insert(0, level[-1])
    with flint.ctx.workprec(8 * degree + 64):
        column = arb_mat([[dyadic(x)] for x in row])
        for corners, expected in zip(_cuts(degree), parts, strict=True):
            assert [
                x.contains(dyadic(y)) and x.rad() < 1e-15
                for x, y in zip((corners * column).entries(), expected, strict=True)
            ] == ([True] * (degree + 1))
