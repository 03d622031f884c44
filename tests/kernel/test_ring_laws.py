"""Polynomials of a ring and rational functions of them: factors, what terms share, and arithmetic, against SymPy."""

from __future__ import annotations

import random
from typing import Any

import pytest
from flint import Ordering, fmpq, fmpq_mpoly_ctx
from sympy import Expr, Integer, Poly, Rational, exp, symbols

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.irreducible import irreducible
from haptisym.kernel.rings import degree_in
from haptisym.kernel.symbols import s

SEEDS = range(20)
a, b = symbols("a b")
E = exp(-s / 2)
RING = Ring.of([a * b * E + s ** Rational(1, 2)])


def drawn(draw: random.Random) -> Expr:
    found = sum(
        (
            draw.choice([-3, Rational(1, 2), 2])
            * s ** draw.randint(0, 3)
            * a ** draw.randint(0, 2)
            * b ** draw.randint(0, 1)
            * E ** draw.randint(0, 2)
            for _ in range(draw.randint(1, 4))
        ),
        Integer(0),
    )
    return found or Integer(1)


def is_same(x: Expr, y: Expr) -> bool:
    e = symbols("e")
    return bool((x - y).subs(E, e).subs(exp(-s), e**2).together().as_numer_denom()[0].expand() == 0)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_polynomials_are_split_into_factors_and_what_all_terms_share(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        x, y = drawn(draw), drawn(draw)
        p = RING.convert(x.expand()).numerator * RING.convert(y.expand()).numerator ** 2
        unit, factors = RING.factors(p)
        product = RING.constant(unit)
        for f, n in factors:
            product *= f**n
        assert product == p
        outside, rest = RING.without_common_functions(p)
        assert is_same(outside * RING.expression(rest), RING.expression(p))
        first = RING.size
        shared = [min(int(e[i]) for e in rest.monoms()) for i in range(first, len(RING.meanings))]
        assert not any(shared)
        assert outside == 1 or outside.has(s)
        assert degree_in([p, p**2], 0) == 2 * int(p.degrees()[0])


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_rational_functions_are_added_multiplied_and_reduced_as_sympy_does(seed: int) -> None:
    draw = random.Random(seed)
    x, y, z = drawn(draw), drawn(draw), drawn(draw)
    f, g = RING.convert(x.expand()) / RING.convert(y.expand()), RING.convert(z.expand())
    for found, true in (
        (f + g, x / y + z),
        (f - g, x / y - z),
        (f * g, x / y * z),
        (f / g, x / y / z),
        (-f, -x / y),
        (f**2, (x / y) ** 2),
        (f**-1, y / x),
    ):
        assert is_same(found.expression(), true)
        reduced = found.reduced()
        assert reduced.equals(found)
        assert reduced.numerator.gcd(reduced.denominator).is_constant()
    assert not f.equals(f + RING.one)
    assert (f - f).is_zero
    assert not f.is_zero
    own = RING.convert((s**4 + 4) * (s**2 - 2)).numerator
    assert sorted(Poly(RING.expression(h), s).degree() for h, _ in RING.factors(own)[1]) == [2, 4]
    assert sorted(Poly(RING.expression(h), s).degree() for h, _ in RING.factors(own, in_square=False)[1]) == [2, 2, 2]


@pytest.mark.parametrize("seed", range(12))
def test_what_is_quickly_called_irreducible_is_no_product(seed: int) -> None:
    """Also none with a factor that is free of the variable that is looked at first."""
    draw, context = random.Random(seed), fmpq_mpoly_ctx.get(("x0", "x1"), Ordering.lex)
    x, y = context.gens()

    def some(a: Any, b: Any) -> Any:
        return a ** draw.randint(1, 2) + draw.randint(-2, 2) * b + draw.choice([1, 3, 5])

    first, second = draw.choice([(y + 3, x**2 + 1), (x + 2, y**3 + x + 1), (some(x, y), some(y, x))])
    assert irreducible(first * second, [0, 1]) is None
    own = x**2 + y + draw.randint(1, 9)
    assert irreducible(own * fmpq(2, 3), [0, 1]) == (fmpq(2, 3), [(own, 1)])
