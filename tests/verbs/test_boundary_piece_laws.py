"""Which polynomials bound a requirement, and why: of products of known factors, against SymPy's discriminants and resultants."""

from __future__ import annotations

from collections import Counter
from itertools import combinations, product
from math import prod
from random import Random
from typing import Any

import pytest
from plainshapes import function_of, q, real_part
from sympy import Expr, Integer, Poly, Rational, discriminant, exp, expand, pi, resultant

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.require.boundary import _trimmed, critical, edge_polynomial, real_roots, touch_polynomial
from haptisym.verbs.require.feasible import Kind

REAL = noticed(hs.Threshold())[0]
BAND = Integer(2), Rational(7, 2)
EVEN = [w**2 - q, w**2 + 3, w**4 + q * w**2 + 1, w**4 - 5 * w**2 + q]
ODD = [w - q, w**2 + q * w + 2, w**3 - q, 2 * w + q - 9]
ALONE = [q - 3, q**2 + q + 5]


def shape(x: Expr) -> Any:
    """A polynomial in q up to a constant factor; 1 for a number but 0."""
    own = Poly(expand(x), q)
    return own.monic().as_expr() if not own.is_zero else Integer(0)


def is_even(x: Expr) -> bool:
    return bool(expand(x - x.subs(w, -w)) == 0)


def eliminated(f: Expr, g: Expr | None, *, even: bool) -> Any:
    """The discriminant, or a resultant, in omega or in omega^2."""
    own = [expand(y).subs(w, w ** Rational(1, 2)) if even else y for y in (f, *([] if g is None else [g]))]
    return shape(discriminant(own[0], w) if g is None else resultant(own[0], own[1], w))


def degree(f: Expr) -> int:
    return int(Poly(f, w).degree())


def drawn(pick: Random) -> tuple[list[dict[Expr, int]], list[dict[Expr, int]]]:
    """Of one or two functions the factors above and below the line, with how often each is there."""
    pool = EVEN if pick.random() < 0.5 else EVEN + ODD
    tops = [
        {
            f: pick.choice([1, 1, 2, 3])
            for f in [*pick.sample(pool, pick.choice([1, 2])), *pick.sample(ALONE, pick.choice([0, 1]))]
        }
        for _ in range(pick.choice([1, 2]))
    ]
    lows = [
        {
            f: pick.choice([1, 2])
            for f in [
                *pick.sample([w**2 + 7, w**2 + q + 1, w + q + 8], pick.choice([0, 1])),
                *pick.sample([q, q + 2], pick.choice([0, 1, 2])),
            ]
        }
        for _ in tops
    ]
    return tops, lows


@pytest.mark.parametrize("seed", range(9))
def test_a_condition_is_critical_where_factors_vanish_at_ends_of_the_band_touch_or_meet_and_where_it_is_not_defined(
    seed: int,
) -> None:
    pick = Random(seed)
    tops, lows = drawn(pick)
    pieces = [
        function_of(prod(f**n for f, n in top.items()) / prod(f**n for f, n in low.items()))
        for top, low in zip(tops, lows, strict=True)
    ]
    found = Counter(
        (None if reason is None else reason[1], shape(pieces[0].axis.expression(p)))
        for reason, p in critical(REAL, pieces, BAND)
    )
    factors: list[Expr] = []
    for top in tops:
        factors += [f for f, n in top.items() if (n % 2 or not f.has(w)) and f not in factors]
    true: Counter[Any] = Counter()
    for f in factors:
        for kind, end in zip((Kind.START, Kind.EDGE), BAND, strict=True):
            true[kind, shape(f.subs(w, end))] += 1
        if f.has(w) and degree(f) > (2 if is_even(f) else 1):
            true[Kind.TOUCH, eliminated(f, None, even=is_even(f))] += 1
    for f, g in combinations([f for f in factors if f.has(w)], 2):
        true[Kind.TOUCH, eliminated(f, g, even=is_even(f) and is_even(g))] += 1
    undefined = {x for reason, x in found if reason is None and x != 1}
    assert undefined == {shape(f) for low in lows for f in low if not f.has(w)}
    assert Counter({x: n for x, n in found.items() if x[0]}) == true
    assert all(reason is None or reason[0] == REAL for reason, _ in critical(REAL, pieces, BAND))


@pytest.mark.parametrize("seed", range(6))
def test_the_curves_of_a_boundary_are_products_at_an_end_and_of_what_touches_and_meets(seed: int) -> None:
    pick = Random(seed)
    tops, _ = drawn(pick)
    pieces = [function_of(prod(f**n for f, n in top.items())) for top in tops]
    at_end = prod(f.subs(w, 3) ** n for top in tops for f, n in top.items())
    assert shape(edge_polynomial(pieces, Integer(3))) == shape(at_end)
    own = [[f for f, n in top.items() if n % 2 and f.has(w)] for top in tops]
    true = [eliminated(f, None, even=is_even(f)) for row in own for f in row if degree(f) > (2 if is_even(f) else 1)]
    for one, other in combinations(own, 2):
        true += [eliminated(f, g, even=is_even(f) and is_even(g)) for f, g in product(one, other) if f != g]
    assert shape(touch_polynomial(pieces)) == shape(prod(true, start=Integer(1)))
    late = [real_part(exp(-s) + q)]
    with pytest.raises(hs.SceneError, match="no polynomial's zero"):
        edge_polynomial(late, Integer(3))
    with pytest.raises(hs.SceneError, match="no polynomial's zero"):
        touch_polynomial(late)


@pytest.mark.parametrize("seed", range(6))
def test_roots_in_the_parameter_are_told_whatever_powers_of_pi_stand_before_it(seed: int) -> None:
    pick = Random(seed)
    a, b = pick.randint(1, 9), pick.randint(1, 9)

    def roots(x: Expr, *, negative: bool = True) -> list[Any]:
        f = function_of(x)
        return [*real_roots(f.function.numerator, f.axis.meanings.index(q), negative=negative)]

    assert roots(pi * w + 3) == []
    assert roots(a * q - b) == [ExactNumber(Rational(b, a))]
    assert roots(a * q + b, negative=False) == [ExactNumber(Rational(-b, a))]
    for linear in (pi * q - b, a * q + b * pi, (pi + a) * q - b * pi**2):
        [x] = roots(linear)
        assert float(x) == pytest.approx(float(Poly(linear, q).nth(0) / Poly(linear, q).nth(1) * -1), rel=1e-15)
    for square, value in (
        (q**2 - a, a**0.5),
        (q**2 - pi * a, (a * float(pi)) ** 0.5),
        (q**3 - 2 * pi, (2 * float(pi)) ** (1 / 3)),
        (q**3 + 2, -(2 ** (1 / 3))),
    ):
        if a in (1, 4, 9) and square == q**2 - a:
            continue
        both = sorted(map(float, roots(square)))
        true = [-value, value] if square.has(q**2) else [value]
        assert both == pytest.approx(true, rel=1e-15)
        assert sorted(map(float, roots(square, negative=False))) == pytest.approx([x for x in true if x > 0], rel=1e-15)
    for row, short in (((1, 2, 0, 0), (1, 2)), ((0, 0), (0,)), ((5,), (5,)), ((0, 0, 3), (0, 0, 3)), ((4, 0), (4,))):
        assert _trimmed(row) == short
