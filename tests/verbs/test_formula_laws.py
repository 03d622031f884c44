"""Which formulas are told for a parameter: short ones with the digits of the value that is meant, where it can be turned."""

from __future__ import annotations

from typing import Any

import pytest
from sympy import Expr, I, Integer, Rational, Symbol, exp, pi, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.solutions import Solution
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.require import closedforms
from haptisym.verbs.require.closedforms import _is, _turned, closed_form

T, W, A = (Symbol(x, positive=True) for x in ("t", "w", "a"))


def condition(form: Expr) -> RealFunction:
    return RealFunction(Ring([T, A]).axis.convert(form))


@pytest.mark.parametrize("number", [sqrt(2), pi / 7, -sqrt(3), Rational(1, 3), 10**20 * sqrt(5), sqrt(5) / 10**20])
def test_a_formula_has_a_value_where_they_agree_in_fifty_two_digits(number: Expr) -> None:
    text = str(number.evalf(70))
    assert _is(number, text)
    for step, told in ((Rational(1, 10**54), True), (Rational(1, 10**50), False), (Rational(1, 10**8), False)):
        for sign in (1, -1):
            assert _is(number * (1 + sign * step), text) is told
    assert not _is(-number, text)
    assert not _is(number + I, text)
    assert not _is(number + I * number / 10**60, text)
    assert not _is(2 * number, text)
    assert not _is(Integer(0), text)


def test_the_first_of_the_solutions_that_is_short_and_has_the_value_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    known, value = {A: Integer(2), W: Integer(3)}, str(sqrt(2).evalf(70))
    right, wrong, other = sqrt(A), A, sqrt(A * W / 3)
    for rows, told in (
        ([right], right), ([wrong], None), ([None], None), ([], None), ([None, wrong, right], right), ([right, other], right),
        ([other, right], other),
    ):  # fmt: skip
        found = tuple(Solution(x, A) for x in rows)
        monkeypatch.setattr(closedforms, "_solved", lambda _, found=found: found)
        assert closed_form(condition(T**2 - A), T, W, known, value) == told
    base = sqrt(A) + sum(A * W ** (k + 2) for k in range(26))
    for form, ops in ((base, 80), (base + W, 81)):
        assert form.count_ops() == ops
        total = str(form.xreplace(known).evalf(70))
        monkeypatch.setattr(closedforms, "_solved", lambda _, x=form: (Solution(x, A),))
        assert (closed_form(condition(T**2 - A), T, W, known, total) is not None) is (ops <= 80)


def test_a_condition_is_turned_where_the_parameter_is_in_powers_or_in_all_delays_alike() -> None:
    assert _turned(condition(T**2 * omega - A), T, W) is not None
    axis = Ring([T, A]).axis
    place = axis.meanings.index(T)
    for count, told in ((600, True), (601, False)):
        rows = [[0] * len(axis.meanings) for _ in range(count)]
        for n, row in enumerate(rows):
            row[0], row[place] = n // 25, n % 25
        many = axis.context.from_dict({tuple(row): 1 for row in rows})
        assert (_turned(RealFunction(axis.function(many)), T, W) is not None) is told
    late, other = exp(-s * T), exp(-s / 10)
    forms = (A * late + 1, True), (A * late**2 + T, True), (A * other + T, False), (late + other, False)
    for form, told in (*forms, (late * other + 1, False), (T * s ** Rational(1, 2), False)):
        ring = Ring.of([form, T, A])
        own: Any = on_axis(ring.convert(form)).real
        assert (_turned(own, T, W) is not None) is told


@pytest.mark.parametrize(
    ("form", "end"),
    [(T**2 * omega**2 - A, sqrt(A) / W), (T * omega - A, A / W), (A * T - omega, W / A), (omega**2 - T, W**2)],
)
def test_a_formula_is_in_the_place_and_the_other_numbers(form: Expr, end: Expr) -> None:
    known = {A: Rational(7, 3), W: Rational(5, 2)}
    value = str(end.subs(known).evalf(70))
    found = closed_form(condition(form), T, W, known, value)
    assert found is not None
    assert (found - end).simplify() == 0
    assert closed_form(condition(form), T, W, known, str((2 * end).subs(known).evalf(70))) is None
