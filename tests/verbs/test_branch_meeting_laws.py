"""Factors that vanish together at a frequency: how often, which of them at all, and how the branches of each leave it."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from typing import Any

import flint
import pytest
from sympy import Expr, Integer, Rational, Symbol, pi

from haptisym.kernel.implicit import Equation
from haptisym.kernel.reals import ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.symbols import omega
from haptisym.verbs.sensitivity.branches import ZERO, Meeting, Slope, _multiplicity, balls, not_clear

P, B = Symbol("p", real=True), Symbol("b", real=True)
RING = PolynomialRing(omega, [P, B])


def equation(expression: Expr) -> Equation:
    return Equation(RING, RING.convert(expression.expand()).numerator)


def values(w: Any, p: Any, b: Any = 2) -> tuple[tuple[Symbol, RealNumber], ...]:
    numbers = [x if isinstance(x, RealNumber) else ExactNumber(Integer(0) + x) for x in (w, p, b)]
    return tuple(zip((omega, P, B), numbers, strict=True))


def meeting(*rows: tuple[Expr, int], at: Any = (3, 5)) -> Meeting:
    return Meeting(tuple((equation(x), n) for x, n in rows), P, values(*at))


def told(sides: Any) -> Any:
    return None if sides is None else [sorted((None if x is None else float(x) for x in row), key=str) for row in sides]


def test_how_often_a_factor_divides_a_polynomial() -> None:
    core = RING.convert(omega**2 - 2).numerator
    for n, rest in product(range(4), (Integer(1), omega + 1, (omega - 3) ** 2)):
        assert _multiplicity(core, RING.convert(((omega**2 - 2) ** n * rest).expand()).numerator) == n


@pytest.mark.parametrize("seed", range(3))
def test_of_several_factors_those_are_kept_that_vanish_and_one_alone_is_never_asked(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        hits = [draw.random() < 0.4, draw.random() < 0.4, True]
        rows = [
            (equation((omega - 3) * (1 + P) if hit else omega - 3 + draw.choice([1, -2]) * P / 7), draw.randint(1, 3))
            for hit in hits
        ]
        assert [*not_clear(tuple(rows), values(3, 5))] == [row for row, hit in zip(rows, hits, strict=True) if hit]
    alone = ((equation(omega - 1), 1),)
    assert not_clear(alone, values(3, 5)) == alone
    assert not_clear((), values(3, 5)) == ()
    near = (equation(omega - 3), 1), (equation(omega - 3 + Rational(1, 2**100) * P), 2)
    assert not_clear(near, values(3, 5)) == near[:1]


def test_a_simple_zero_is_still_where_the_slope_along_the_parameter_vanishes() -> None:
    for expression, still in (
        (omega - 3 + (P - 5) ** 2, True),
        (omega - P + 2, False),
        (omega - 3, True),
        ((omega - 3) * (P + 1), True),
    ):
        assert meeting((expression, 1)).is_still() is still
    assert meeting((omega**2 - 2 + (P - 5) ** 2 * omega, 1), at=(SquareRoot(ExactNumber(Integer(2))), 5)).is_still()
    assert not meeting((omega - 3 + (P - pi) ** 2, 1), at=(3, pi)).is_still()  # no rational value: it is not seen


def test_each_factor_of_odd_order_gives_its_branches_and_those_of_all_are_told_together() -> None:
    """At 3 rad/s where p is 5: lines, folds to either side, an inflection, two lines that cross, a point alone and a cusp."""
    x, y = P - 5, omega - 3
    known: dict[Expr, Any] = {
        y - 2 * x: [[2.0], [2.0]],
        y * (1 + omega) + x * 12: [[-3.0], [-3.0]],
        y + x**2: [[0.0], [0.0]],
        y**2 - x: [[], [None, None]],
        y**2 * 7 + x * (1 + y): [[None, None], []],
        y**4 - 3 * x: [[], [None] * 2],
        y**3 + x: [[None], [None]],
        y**2 - 4 * x**2: None,
        (y - x) ** 2 - 3 * x**2 * (1 + y): [[None, None], [None, None]],
        y**2 + x**2: [[], []],
        y + 4: [[], []],
        x + 0 * y: [[], []],
    }
    for expression, expected in known.items():
        for order in (1, 2, 3):
            found = meeting((expression, order), (y - 2 * x, 2)).sides()
            if order % 2 and expected is None:
                continue  # two factors in one, which is not irreducible
            assert told(found) == (expected if order % 2 else [[], []]), (expression, order)
    both = meeting((y - 2 * x, 1), (y**2 - x, 3), (y + x, 1)).sides()
    assert told(both) == [[-1.0, 2.0], [-1.0, 2.0, None, None]]
    assert meeting((y**2 - x**3, 1)).sides() is None  # a cusp
    assert meeting((y**3 - x**2 * y - x**4, 1)).sides() is None  # three
    assert meeting((omega - P, 1), at=(pi, pi)).sides() is None


def test_a_slope_is_minus_one_derivative_over_the_other_and_clear_where_neither_is_0() -> None:
    """omega^2 = b p: omega/(2 p), at irrational numbers too."""
    for p, b in ((2, 9), (pi, 3), (Fraction(1, 3), 5)):
        number = Rational(p) if isinstance(p, Fraction) else Integer(0) + p
        w = SquareRoot(ExactNumber(number * b))
        slope = Slope(equation(omega**2 - B * P).slope(P), values(w, number, b))
        assert float(slope) == pytest.approx(float(w) / (2 * float(number)), rel=1e-15)
        assert slope.digits(40) == Slope(equation(3 * omega**2 - 3 * B * P).slope(P), values(w, number, b)).digits(40)
        assert slope.is_clear()
    for expression in (omega**2 - 9 + (P - 5) ** 2, (omega - 3) ** 2 - (P - 5)):
        assert not Slope(equation(expression).slope(P), values(3, 5)).is_clear()
    with flint.ctx.workprec(100):
        found = balls(values(3, 5), 100)
        assert found[pi].overlaps(flint.arb.pi())
        assert [float(found[x]) for x in (omega, P, B)] == [3, 5, 2]
    assert float(ZERO) == 0
