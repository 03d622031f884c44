"""The polynomials in a parameter that vanish where a condition binds: common zeros and touches that were put there."""

from __future__ import annotations

import pytest
from sympy import Expr, Integer, Rational, Symbol

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require.boundary import critical, touch_polynomial
from haptisym.verbs.require.feasible import Kind

q = Symbol("q", positive=True)
AXIS = Ring.of([q]).axis
CRITERION = noticed(hs.load_scene("fu2019").threshold)[0]


def vanish(pieces: list[Expr], kind: Kind, value: Rational) -> bool:
    """Whether some polynomial of a kind has a root at a value."""
    functions = [RealFunction(AXIS.convert(x)) for x in pieces]
    found = critical(CRITERION, functions, (Integer(1), Integer(7)))
    own = [AXIS.expression(p) for reason, p in found if reason is not None and reason[1] is kind]
    return any(x.subs(q, value) == 0 for x in own)


@pytest.mark.parametrize(
    ("f", "g", "value"),
    [
        (w**2 - q, w**2 - 4, 4),
        (w**2 - q, w - 2, 4),  # one even, the other not
        (w - 2, w**2 - q, 4),
        (w - q, w - 3, 3),
        (w**2 - q * w + 1, w**4 - 16, Rational(5, 2)),
        (w**4 - q * w**2 + 3, w**2 - 2, Rational(7, 2)),
    ],
)
def test_where_two_factors_have_a_frequency_in_common_a_touch_is_critical(f: Expr, g: Expr, value: Rational) -> None:
    assert vanish([f * g], Kind.TOUCH, value)
    assert vanish([f, g], Kind.TOUCH, value)
    assert not vanish([f, g], Kind.TOUCH, Rational(77, 10))
    polynomial = touch_polynomial([RealFunction(AXIS.convert(x)) for x in (f, g)])
    assert polynomial.subs(q, value) == 0
    assert polynomial.subs(q, Rational(77, 10)) != 0


@pytest.mark.parametrize(
    ("f", "value"), [(w**4 - q * w**2 + 1, 2), (w**2 - q * w + 9, 6), (w**4 - 6 * w**2 + q, 9), (w**3 - 3 * w + q, 2)]
)
def test_a_factor_touches_0_where_two_of_its_zeros_meet_and_an_even_power_of_it_binds_nowhere(
    f: Expr, value: int
) -> None:
    assert vanish([f], Kind.TOUCH, Rational(value))
    assert touch_polynomial([RealFunction(AXIS.convert(f))]).subs(q, value) == 0
    assert touch_polynomial([RealFunction(AXIS.convert(f**2))]) == 1
    assert not vanish([f**2], Kind.TOUCH, Rational(value))


@pytest.mark.parametrize("f", [w**2 - q, w * q - 3, q**2 * w**4 - w - 2])
def test_at_both_ends_of_the_band_a_value_is_critical_that_has_a_zero_there(f: Expr) -> None:
    for kind, end in ((Kind.START, 1), (Kind.EDGE, 7)):
        functions = [RealFunction(AXIS.convert(f))]
        found = critical(CRITERION, functions, (Integer(1), Integer(7)))
        own = [AXIS.expression(p) for reason, p in found if reason is not None and reason[1] is kind]
        assert [(x / f.subs(w, end)).cancel().is_Rational for x in own] == [True]
