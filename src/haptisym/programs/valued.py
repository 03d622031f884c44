"""Rational formulas over cells, in Taylor models."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod

from sympy import Add, Expr, Mul, Pow, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.programs.taylormodels import Model


def valued(formula: Expr, known: Mapping[Expr, Model], like: Model) -> Model:
    """A formula of what is known and exact numbers by + * / and whole powers; ``like`` : any model over the same cells."""
    if formula in known:
        return known[formula]
    if not formula.free_symbols & set(known):
        return like.number(floated(formula))
    if isinstance(formula, Add):
        terms = [valued(x, known, like) for x in formula.args]
        return sum(terms[1:], terms[0])
    one = like.number(1.0)
    if isinstance(formula, Mul):
        return prod((valued(x, known, like) for x in formula.args), start=one)
    assert isinstance(formula, Pow)
    power = prod([valued(formula.base, known, like)] * abs(int(formula.exp)), start=one)
    return power if formula.exp > 0 else one / power


def floated(value: Expr) -> float:
    """The number to within a rounding or two. UndecidedError where it is too large for a float."""
    if isinstance(value, Rational):
        try:
            return int(value.p) / int(value.q)
        except OverflowError:
            raise UndecidedError("how numbers compare that are too large for floats") from None
    return float(value.evalf(20)) if value.is_algebraic else float(expression_ball(value))
