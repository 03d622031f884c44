"""Taylor coefficients that go through sums, products, quotients and matrix exponentials: those of the functions, and no value outside."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import flint
import pytest
from flint import arb, arb_mat, arb_poly, fmpq
from mpmath import expm, matrix, mp, mpf
from sympy import Rational, Symbol, factorial, series

from haptisym.kernel.jets import Jet, Line, coefficients, narrowest, over_cell, parts, polynomial, powers, value
from haptisym.kernel.nearone import has_no_pair
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
    function = lambda q: [rational(random.Random(seed), 3, q[0], int), q[0] * 0 + 2]  # noqa: E731
    with flint.ctx.workprec(200):
        order = draw.choice([1, 2, 3])
        line, constant = over_cell(function, [exactly(middle)], [exactly(radius)], order)
        assert constant.ball.contains(2)
        values = []
        for k in range(-8, 9):
            y = Fraction(k, 8)
            exact = rational(random.Random(seed), 3, middle + radius * y, Fraction)
            assert line.ball.overlaps(exactly(exact))
            assert (line.at + line.slopes[0] * exactly(y)).overlaps(exactly(exact))
            values.append(exact)
        small = over_cell(function, [exactly(middle)], [exactly(radius / 1000)], 3)[0].ball
        spread = abs(
            rational(random.Random(seed), 3, middle + radius / 1000, Fraction)
            - rational(random.Random(seed), 3, middle - radius / 1000, Fraction)
        )
        assert float(small.rad()) <= 0.51 * float(spread) + 1e-5 * float(radius) * max(
            1.0, abs(float(max(values, key=abs)))
        )


def in_two(draw: random.Random, depth: int, leaves: Any, whole: Any) -> Any:
    """A random formula of several numbers, which is 1/0 nowhere where they are real."""
    if depth == 0:
        return draw.choice(leaves)
    one, other = (in_two(draw, depth - 1, leaves, whole) for _ in range(2))
    kind = draw.randrange(5)
    if kind == 4:
        return whole(draw.randint(1, 9)) / (one * one + 3)
    return [one + other, one - other, one * other, one * other * whole(draw.randint(2, 5))][kind]


@pytest.mark.parametrize("seed", range(4))
def test_a_jet_in_two_numbers_has_the_partial_derivatives_of_its_formula(seed: int) -> None:
    y = Symbol("y")
    with flint.ctx.workprec(200):
        start = exactly(Fraction(1, 3)), exactly(Fraction(-2, 5))
        rest = [arb(0)] * 3
        leaves = [Jet([start[0], arb(1), arb(0), *rest], 2), Jet([start[1], arb(0), arb(1), *rest], 2)]
        own = in_two(random.Random(seed), 3, leaves, int)
        formula = in_two(random.Random(seed), 3, [x, y], Rational)
        for (i, j), part in zip(powers(2, 6), own.row, strict=True):
            c = formula.diff(x, i, y, j).subs({x: Rational(1, 3), y: Rational(-2, 5)}) / (factorial(i) * factorial(j))
            assert part.overlaps(exactly(Fraction(int(c.p), int(c.q))))
            assert part.rad() < 1e-40 * (1 + abs(part.mid()))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_over_a_box_a_function_lies_along_its_plane(order: int) -> None:
    """At random values of three numbers, exactly; what is left beside the plane falls with the box, by the order of the terms."""
    draw = random.Random(order)
    for seed in range(6):
        middles = [Fraction(draw.randint(-9, 9), 7) for _ in range(3)]
        width = []
        for radius in (Fraction(1, 8), Fraction(1, 800)):
            with flint.ctx.workprec(200):
                [line] = over_cell(
                    lambda q, seed=seed: [in_two(random.Random(seed), 3, q, int) + q[0] * 0],
                    [*map(exactly, middles)],
                    [exactly(radius)] * 3,
                    order,
                )
                for _ in range(10):
                    at = [Fraction(draw.randint(-8, 8), 8) for _ in range(3)]
                    values = [m + radius * t for m, t in zip(middles, at, strict=True)]
                    value = exactly(in_two(random.Random(seed), 3, values, Fraction))
                    plane = sum((c * exactly(t) for c, t in zip(line.slopes, at, strict=True)), line.at)
                    assert line.ball.overlaps(value)
                    assert plane.overlaps(value)
                width.append(float((line.at if order > 1 else line.ball).rad()))
        assert width[1] <= 1.5 * width[0] * 0.01 ** min(order, 2)


@pytest.mark.parametrize("seed", range(4))
def test_a_pair_on_the_axis_for_some_numbers_of_a_box_is_never_passed_by(seed: int) -> None:
    """(v^2 + nu^2)(v + a) has such a pair at one place of the box; away from it, E and O move so that neither is 0 alone."""
    draw, told = random.Random(seed), 0
    for _ in range(25):
        nu2, a = draw.uniform(0.2, 4), draw.uniform(0.2, 4)
        middle = [a * nu2, nu2, a, 1.0]
        slopes = [[draw.uniform(-1, 1) for _ in middle] for _ in range(3)]
        there = [draw.uniform(-1, 1) for _ in slopes]
        for beside in (0, 3):  # of the sum of all moves, in the lowest coefficient: within the box, and far outside
            at = [c - sum(m[i] * t for m, t in zip(slopes, there, strict=True)) for i, c in enumerate(middle)]
            at[0] += beside * sum(abs(m[i]) for m in slopes for i in range(4)) * (1 + nu2)
            lines = [Line(arb(c), tuple(arb(m[i]) for m in slopes)) for i, c in enumerate(at)]
            clear = has_no_pair([x.ball for x in lines], lines)
            assert not (clear and not beside)
            told += clear
    assert told > 2


def test_moves_that_a_combination_shows_to_miss_the_axis_are_told() -> None:
    """v^3 + a v^2 + b v + 1/2 has a pair on the axis where a b = 1/2: not on the box, where one rises as the other falls."""
    a, b = (arb("0.2"), arb("0.3")), (arb("-0.3"), arb("-0.2"))
    fixed = (arb(0), arb(0))
    lines = [Line(arb("0.5"), fixed), Line(arb(1), b), Line(arb(1), a), Line(arb(1), fixed)]
    assert not has_no_pair([x.ball for x in lines])  # 1/2 < a, b < 3/2
    assert has_no_pair([x.ball for x in lines], lines)  # a b >= 3/4
    wider = [x._replace(slopes=tuple(c * arb("1.6") for c in x.slopes)) for x in lines]
    assert not has_no_pair([x.ball for x in wider], wider)  # 1.8 * 0.2


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
