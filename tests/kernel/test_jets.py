"""Taylor coefficients that go through sums, products, quotients and matrix exponentials: those of the functions, and no value outside."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import flint
import pytest
from flint import arb, arb_mat, arb_poly, fmpq
from mpmath import expm, matrix, mp, mpf
from sympy import Rational, Symbol, series

from haptisym.kernel.jets import Jet, coefficients, narrowest, over_cell, parts, polynomial, value
from haptisym.kernel.states import States, norm, widened

x = Symbol("x")


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
    return whole(draw.randint(1, 9)) / (one * one + 3) if kind == 5 else (one * one + 1) ** draw.choice([-2, -1, 0, 3])


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", range(12))
def test_a_jet_of_a_formula_is_its_taylor_series(seed: int) -> None:
    """By SymPy, exactly: also where a jet is divided by a whole number, which a float would round."""
    with flint.ctx.workprec(200):
        own = rational(random.Random(seed), 3, Jet([exactly(Fraction(1, 3)), arb(1), arb(0), arb(0)]), int)
        formula = rational(random.Random(seed), 3, Rational(1, 3) + x, Rational)
        expected = series(formula, x, 0, 4).removeO()
        for k, part in enumerate(own.row):
            c = expected.coeff(x, k)
            assert part.overlaps(exactly(Fraction(int(c.p), int(c.q))))
            assert part.rad() < 1e-40 * (1 + abs(part.mid()))


@pytest.mark.parametrize("seed", range(12))
def test_over_a_cell_a_function_has_all_its_values_and_hardly_more(seed: int) -> None:
    draw = random.Random(seed)
    middle, radius = Fraction(draw.randint(-20, 20), 7), Fraction(1, draw.choice([4, 16, 64]))
    function = lambda q: [rational(random.Random(seed), 3, q, int), q * 0 + 2]  # noqa: E731
    with flint.ctx.workprec(200):
        order = draw.choice([1, 2, 3])
        line, constant = over_cell(function, exactly(middle), exactly(radius), order)
        assert constant.ball.contains(2)
        values = []
        for k in range(-8, 9):
            y = Fraction(k, 8)
            exact = rational(random.Random(seed), 3, middle + radius * y, Fraction)
            assert line.ball.overlaps(exactly(exact))
            assert (line.at + line.slope * exactly(y)).overlaps(exactly(exact))
            values.append(exact)
        small = over_cell(function, exactly(middle), exactly(radius / 1000), 3)[0].ball
        spread = abs(
            rational(random.Random(seed), 3, middle + radius / 1000, Fraction)
            - rational(random.Random(seed), 3, middle - radius / 1000, Fraction)
        )
        assert float(small.rad()) <= 0.51 * float(spread) + 1e-5 * float(radius) * max(
            1.0, abs(float(max(values, key=abs)))
        )


def test_of_two_true_balls_the_narrower_one_counts_in_each_coefficient() -> None:
    one, other = Jet([arb(1, 0.5), arb(2)]), Jet([arb(1), arb(2, 0.5)])
    assert [float(c.rad()) for c in narrowest([one, other]).row] == [0, 0]
    assert narrowest([arb(1, 0.5), arb(1)]).is_exact()
    assert (parts(arb(3)), value(one).mid(), value(arb(3))) == ((arb(3),), 1, 3)


def test_polynomials_of_jets_multiply_and_are_taken_apart() -> None:
    """(1 + (2 + x) z)(x + z) = x + (1 + 2 x + x^2) z + (2 + x) z^2."""
    p, q = polynomial([arb(1), Jet([arb(2), arb(1), arb(0)])]), polynomial([Jet([arb(0), arb(1), arb(0)]), arb(1)])
    product = p * q
    assert [[float(c) for c in row.row] for row in coefficients(product)] == [[0, 1, 0], [1, 2, 1], [2, 1, 0]]
    assert [float(c) for c in product(arb(2)).row] == [10, 9, 2]
    assert [float(c) for c in coefficients(arb_poly([1, 2]) * p)[1].row] == [4, 1, 0]
    assert Jet([arb(0), arb(0)]).is_zero()
    assert not Jet([arb(0), arb(1)]).is_zero()


def plant(draw: random.Random, size: int) -> list[Fraction]:
    return [Fraction(draw.randint(-40, 40), draw.randint(1, 9)) for _ in range(size)] + [Fraction(1)]


@pytest.mark.parametrize("seed", range(8))
def test_what_holds_a_plant_for_some_time_is_its_matrix_exponential(seed: int) -> None:
    """By mpmath: int_0^t exp(A t) dt and exp(A t), in states that are the derivatives times powers of a rate."""
    draw = random.Random(seed)
    n, t = draw.randint(1, 4), Fraction(draw.randint(1, 60), 20)
    Q = plant(draw, n)
    with mp.workdps(60), flint.ctx.workprec(160):
        states = States([exactly(c) for c in Q])
        A = matrix([[mpf(str(states.A[i, j].mid().str(50, radius=False))) for j in range(n)] for i in range(n)])
        own, moved, held = states.integral(exactly(t)), states.moved(exactly(t)), states.held(exactly(t))
        block = expm(
            matrix(
                [
                    [A[i, j] if j < n and i < n else mpf(int(i < n and j == n + i)) for j in range(2 * n)]
                    for i in range(2 * n)
                ]
            )
            * mpf(t.numerator)
            / t.denominator,
            method="taylor",
        )
        scale = max(1, max(abs(block[i, j]) for i in range(n) for j in range(2 * n)))
        for i in range(n):
            assert abs(mpf(held[i, 0].mid().str(40, radius=False)) - block[i, 2 * n - 1]) < scale * mpf(10) ** -25
            for j in range(n):
                for found, exact in ((own[i, j], block[i, n + j]), (moved[i, j], block[i, j])):
                    assert abs(mpf(found.mid().str(40, radius=False)) - exact) < scale * mpf(10) ** -25
                    assert float(found.rad()) < scale * 1e-25


def test_masses_alone_are_moved_exactly() -> None:
    """1/s^2: no power of A beyond the first, so that nothing is left out of its series."""
    found = States([arb(0), arb(0), arb(1)]).integral(arb(2))
    assert [[found[i, j].is_exact() for j in range(2)] for i in range(2)] == [[True] * 2] * 2
    assert [[float(found[i, j]) for j in range(2)] for i in range(2)] == [[2, 2], [0, 2]]
    nothing = States([arb(1)])
    assert (nothing.size, nothing.integral(arb(1)).nrows(), nothing.moved(arb(1)).ncols()) == (0, 0, 0)


def test_wide_balls_hold_every_exponential_of_what_is_in_them() -> None:
    draw = random.Random(3)
    for _ in range(20):
        middle, radius = plant(draw, 3), Fraction(1, draw.choice([3, 30, 300]))
        states = States([arb(exactly(c), exactly(radius)) for c in middle[:-1]] + [arb(1)])
        wide = states.integral(arb("0.25"))
        inner = [c + radius * Fraction(draw.randint(-8, 8), 8) for c in middle[:-1]]
        with flint.ctx.workprec(200):
            one = States([*map(exactly, inner), arb(1)])
            scaled = one.integral(arb("0.25"))
            for i in range(3):
                for j in range(3):  # states of another rate: the i-th times rate^(2 - i)
                    ratio = (states.rate / one.rate) ** (j - i) if states.rate != one.rate else arb(1)
                    assert wide[i, j].overlaps(scaled[i, j] * ratio)
    assert not States([arb("nan"), arb(1)]).integral(arb(1))[0, 0].is_finite()
    assert not States([arb(10) ** 40, arb(1)]).integral(arb(1))[0, 0].is_finite()


def test_the_size_of_a_matrix_of_jets_counts_all_coefficients() -> None:
    M = Jet([arb_mat([[1, -2], [0, 3]]), arb_mat([[0, 1], [-1, 0]])])
    assert float(norm(M)) == 4
    assert float(norm(arb_mat([[1, -2], [0, 2]]))) == 3
    assert [float(c.rad()) for c in widened(M, arb(1))[0, 1].row] == pytest.approx([1, 1])
