"""Programs and formulas in Taylor models, number by number: against mpmath, in points and over boxes."""

from __future__ import annotations

import random

import mpmath
import numpy as np
import pytest
from sympy import Expr, Rational, Symbol, cos, diff, lambdify, pi, sin, sinc, sqrt

from haptisym.kernel.errors import UndecidedError
from haptisym.programs.modelled import Modelled
from haptisym.programs.program import Writer
from haptisym.programs.taylormodels import Model, variable
from haptisym.programs.valued import floated, valued

X, Y = Symbol("x", positive=True), Symbol("y", positive=True)
C = Rational(7, 3)
RATIONAL: list[Expr] = [
    X + C, C - X, X - C, 5 * X, -X / 3, X / C, C / X, X + Y, X - Y, Y - X, X * Y, X / Y, 1 / (X * Y), -X, X**3 - 2 * X, (X + 2 * Y) / (3 - X * Y / 40), X**-2 + Y, pi * X - Y / pi**2, X + 0 * Y,
]  # fmt: skip
OTHERS: list[Expr] = [
    cos(X * Y), sin(X + 1), cos(1) * X - sin(Rational(2)) / Y, sinc(X) + Y, X**Y, (X + Y) ** Rational(1, 3), X * sqrt(2) + sqrt(Y), X * cos(C) ** 2 + Rational(3, 2) ** Rational(1, 3),
]  # fmt: skip


def boxes(draw: random.Random, radius: float) -> list[Model]:
    middles = np.array([[draw.uniform(0.5, 3) for _ in range(2)] for _ in range(6)])
    return [variable(middles[:, i], np.full(6, radius), 4.0, i, 2) for i in range(2)]


def holds(found: Model, given: list[Model], formula: Expr, radius: float) -> None:
    """The value and both slopes, in units of half a box, at corners and inside; nothing is given away in points."""
    exact = [lambdify((X, Y), f, "mpmath") for f in (formula, radius * diff(formula, X), radius * diff(formula, Y))]
    low, high = found.bounds()
    with mpmath.workdps(40):
        for n in range(6):
            for t in ((0, 0), (1, 1), (-1, 1), (0.5, -1)):
                at = [mpmath.mpf(float(x.c0[n, 0])) + radius * mpmath.mpf(u) for x, u in zip(given, t, strict=True)]
                for i, f in enumerate(exact):
                    assert low[n, i] <= f(*at) <= high[n, i]
    size = 1 + np.abs(found.c0[:, :1])
    assert ((high - low) <= (1e-11 + 40 * radius * (radius + (np.arange(3) == 0))) * size).all()


@pytest.mark.parametrize("radius", [0.0, 1 / 64])
@pytest.mark.parametrize("formula", [*RATIONAL, *OTHERS], ids=str)
def test_a_program_has_the_values_and_slopes_of_its_formula(formula: Expr, radius: float) -> None:
    write = Writer((X, Y))
    given = boxes(random.Random(str(formula)), radius)
    found = Modelled(write.program({"it": write.expression(formula)})).run(given)["it"]
    assert isinstance(found, Model)
    holds(found, given, formula, radius)


@pytest.mark.parametrize("formula", RATIONAL, ids=str)
def test_a_rational_formula_has_its_values_and_slopes(formula: Expr) -> None:
    for radius in (0.0, 1 / 64):
        given = boxes(random.Random(str(formula)), radius)
        holds(valued(formula, dict(zip((X, Y), given, strict=True)), given[0]), given, formula, radius)


def test_a_number_that_no_input_is_in_is_one_float_and_what_is_too_large_is_none() -> None:
    write = Writer((X, Y))
    numbers = {"one": cos(1) / pi + 2, "two": sqrt(2) - 5, "three": Rational(1, 3)}
    found = Modelled(write.program({name: write.expression(x) for name, x in numbers.items()})).run(
        boxes(random.Random(1), 0.0)
    )
    assert found == {name: pytest.approx(float(x.evalf(30)), rel=1e-15) for name, x in numbers.items()}
    for x in (*numbers.values(), 10**400 / Rational(10**399)):
        assert floated(x) == pytest.approx(float(x.evalf(30)), rel=1e-15)
    with pytest.raises(UndecidedError, match="too large for floats"):
        floated(Rational(10**400))
