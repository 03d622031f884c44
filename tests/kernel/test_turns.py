"""Sums of cosines and sines of parts of a turn: whether one is the number zero, against eighty digits."""

from __future__ import annotations

import random
from math import prod
from typing import Any

import mpmath
import pytest
from flint import fmpq
from sympy import Expr, Integer, Rational, Symbol, exp, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import on_axis
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.kernel.symbols import omega, s
from haptisym.kernel.turns import is_zero, vanishes


def ring_of(angles: int) -> PolynomialRing:
    return PolynomialRing(omega, functions=[Symbol(f"{kind}{i}") for i in range(angles) for kind in ("cos", "sin")])


def zeros_of(ring: PolynomialRing, i: int, angle: Expr) -> list[Polynomial]:
    """Polynomials that are zero there: cos^2 + sin^2 - 1, and Im (cos + j sin)^m where m half angles are half turns."""
    c, s = ring.context.gens()[2 + 2 * i : 4 + 2 * i]
    m, real, imag = int((angle / 2 / pi).q), ring.constant(1), ring.constant(0)
    for _ in range(m):
        real, imag = real * c - imag * s, real * s + imag * c
    return [c * c + s * s - 1, imag]


def value(polynomial: Polynomial, angles: list[Expr]) -> mpmath.mpf:
    halves = [mpmath.pi * mpmath.mpf((a / pi).p) / (2 * (a / pi).q) for a in angles]
    known = [mpmath.mpf(1), mpmath.pi, *(f(x) for x in halves for f in (mpmath.cos, mpmath.sin))]
    return mpmath.fsum(
        mpmath.mpf(int(c.p)) / int(c.q) * prod(x ** int(n) for x, n in zip(known, e, strict=True))
        for e, c in polynomial.to_dict().items()
    )


def drawn(chance: random.Random, ring: PolynomialRing, angles: int) -> Any:
    return ring.context.from_dict(
        {
            (0, chance.randint(0, 1), *(chance.randint(0, 2) for _ in range(2 * angles))): fmpq(
                chance.randint(-4, 4), 3
            )
            for _ in range(3)
        }
    )


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
        polynomial = drawn(chance, ring, count) * chance.choice(known) + drawn(chance, ring, count) * chance.choice(
            known
        )
        if chance.random() < 0.3:
            polynomial += ring.context.from_dict({(0, 1, *[0] * 2 * count): fmpq(1, 10**12)})
        if chance.random() < 0.3:
            polynomial = drawn(chance, ring, count)
        with mpmath.workdps(80):
            true = abs(value(polynomial, angles)) < mpmath.mpf(10) ** -60
        assert is_zero(polynomial, angles) is true, (polynomial, angles)
        zero += true
    assert 20 < zero < 55


def test_of_an_angle_that_is_no_part_of_a_turn_nothing_is_said() -> None:
    """cos a - (cos^2 a/2 - sin^2 a/2) is zero for every a, and sin a is not: neither is told of pi^2/8 rad."""
    ring = ring_of(2)
    _, _, c, _, c2, s2 = ring.context.gens()
    angles = [pi**2 / 8, pi**2 / 16]
    assert is_zero(c - (c2 * c2 - s2 * s2), angles) is None
    assert is_zero(c, angles) is None
    assert is_zero(c - c, angles) is True


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
