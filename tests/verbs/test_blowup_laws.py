"""Signs of sums of monomials next to a corner: against means, sampled, and the charts and curves that they are told by."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import log
from random import Random
from typing import Any

import pytest
from flint import arb, ctx, fmpq
from plainshapes import exact
from plainsums import Sum, alike, drawn, value

from haptisym.verbs.require.blowups import (
    _at_touch,
    _charts,
    _Curve,
    _curves,
    _halves,
    _is_bare,
    _matched,
    _middle,
    _shows_negative,
    is_negative,
    positive_along,
)
from haptisym.verbs.require.monomials import Monomials, power


@pytest.fixture(autouse=True)
def _precise() -> Any:
    with ctx.workprec(160):
        yield


@pytest.mark.parametrize("seed", range(8))
def test_two_monomials_outweigh_one_between_them_up_to_the_factor_of_their_means(seed: int) -> None:
    """-X^a - Y^b + c X^(a t) Y^(b (1 - t)) is negative for c < t^-t (1 - t)^(t - 1), and positive along a curve beyond."""
    pick = Random(seed)
    a, b = Fraction(pick.randint(2, 12), pick.choice([1, 2])), Fraction(pick.randint(1, 4) * 2)
    t = Fraction(pick.randint(1, 3), 4)
    if (b * (1 - t)).denominator > 1:
        t = Fraction(1, 2)
    border = float(t) ** -float(t) * (1 - float(t)) ** -float(1 - t)
    scale = fmpq(pick.randint(1, 9), pick.randint(1, 9))
    for factor, negative in ((0.9, True), (3.0, False), (-1.0, True)):
        middle = Fraction(factor * border).limit_denominator(10**6)
        terms: Sum = {
            (a, Fraction(0)): -scale,
            (Fraction(0), b): -scale,
            (a * t, b * (1 - t)): scale * fmpq(middle.numerator, middle.denominator),
        }
        terms[2 * a, b / 2] = fmpq(pick.choice([-1, 1]), 9)  # far smaller next to 0
        x, y = arb(1) / 256, arb(1) / 128
        assert is_negative(terms, x, y) is negative
        reach: Any = positive_along(terms, x, y)
        assert (reach is None) is negative
        for n in range(1, 4) if reach is not None else ():
            height = float(reach) / 5.0 ** (n - 1)
            center = height ** float(b / a)
            tops = [
                sum(float(c.p) / float(c.q) * u ** float(e) * height ** float(f) for (e, f), c in terms.items())
                for u in (center * 1.05**k for k in range(-60, 61))
                if u <= 1 / 256
            ]
            assert max(tops) > 0


@pytest.mark.parametrize("seed", range(6))
def test_no_sum_is_said_to_be_negative_where_a_point_is_not(seed: int) -> None:
    """And one that is said to be positive along curves is so at some X for each Y that is tried."""
    pick, told = Random(seed), 0
    for _ in range(12):
        terms = {e: -abs(c) if pick.random() < 0.7 else c for e, c in drawn(pick, below=2, count=5).items()}
        x, y = arb(1) / 8, arb(1) / 4
        grid = [(2.0**-i / 8, 2.0**-j / 4) for i, j in product(range(0, 24, 2), repeat=2)]
        values = [
            sum(float(c.p) / float(c.q) * u ** float(a) * v ** float(b) for (a, b), c in terms.items()) for u, v in grid
        ]
        if is_negative(terms, x, y):
            told += 1
            assert max(values) < 0
        reach: Any = positive_along(terms, x, y)
        if reach is not None:
            assert max(values) > 0
            assert 0 < reach <= y
    assert told


@pytest.mark.parametrize("seed", range(6))
def test_two_charts_cover_a_corner_with_the_same_values_and_the_rest_of_a_box_lies_beside(seed: int) -> None:
    pick = Random(seed)
    a, b = Fraction(pick.randint(2, 9), pick.choice([1, 2])), Fraction(pick.randint(2, 5))
    terms: Sum = {
        (a, Fraction(0)): fmpq(-pick.randint(1, 9)),
        (Fraction(0), b): fmpq(-pick.randint(1, 9)),
        (a, Fraction(b // 2 + 1)): fmpq(2),
    }
    own = Monomials.of(terms)
    x, y = exact(Fraction(1, 2 ** pick.randint(1, 9))), exact(Fraction(1, 2 ** pick.randint(1, 9)))
    p, v = own.slope
    (one, across, up), (other, beside, rising) = _charts(own, x, y)
    assert (across[0].is_zero(), across[1], up[0].is_zero(), up[1]) == (True, x, True, v)
    assert (beside[0].is_zero(), rising[0].is_zero(), rising[1]) == (True, True, y)
    least = min(e + p * f for e, f in terms)
    for i, j in product((1, 3, 8), repeat=2):
        X, Y = x * i / 8, y * j / 8
        ratio = Y / power(X, p)
        true = value(terms, X, Y)
        assert alike(value(one.terms, X, ratio) * X ** exact(least), true)
        t = X / power(Y, 1 / p)
        assert alike(value(other.terms, t, Y), true)
        assert ratio <= up[1] or t <= beside[1]
        assert ratio <= up[1] * 1.000001 or t <= beside[1] * 1.000001
    (width, height), rest = _matched(own, x, y)
    assert abs(float(height / power(width, p) / v) - 1) < 1e-20 or (width == x and height == y)
    area = float(width * height) + sum(float((r - q) * (u - s)) for (q, r), (s, u) in rest)
    assert area == pytest.approx(float(x * y), rel=1e-12)
    assert width <= x
    assert height <= y
    for (q, r), (s, u) in rest:
        assert (q.is_zero() and r == x and s == height and u == y) or (q == width and r == x and s.is_zero() and u == y)


@pytest.mark.parametrize("seed", range(5))
def test_a_box_is_halved_across_where_values_change_more(seed: int) -> None:
    pick = Random(seed)
    for steep in (fmpq(100), fmpq(1, 100)):
        own = Monomials.of({(Fraction(1), Fraction(0)): steep, (Fraction(0), Fraction(1)): fmpq(1)})
        low, high = exact(Fraction(pick.choice([0, 1, 3]))), exact(Fraction(5))
        pieces = _halves(own, (low, high), (low, high))
        cut = 0 if steep > 1 else 1
        assert [(x[cut][0] == low, x[cut][1] == high) for x in pieces] == [(True, False), (False, True)]
        assert pieces[0][cut][1] == pieces[1][cut][0] == _middle(low, high)
        assert all((x[1 - cut][0], x[1 - cut][1]) == (low, high) for x in pieces)
    for a, b, true in ((0, 8, 2.0), (1, 9, 3.0), (4, 6, 5.0), (2, 4, 3.0), (1, 100, 10.0)):
        assert float(_middle(arb(a), arb(b))) == pytest.approx(true)


@pytest.mark.parametrize("seed", range(5))
def test_curves_lead_into_the_corner_and_on_them_a_sum_has_the_sign_of_its_chart(seed: int) -> None:
    pick = Random(seed)
    terms: Sum = {
        (Fraction(6), Fraction(0)): fmpq(-4),
        (Fraction(3), Fraction(1)): fmpq(4),
        (Fraction(0), Fraction(2)): fmpq(-1),
    }
    terms[Fraction(7), Fraction(0)] = fmpq(pick.choice([-3, 3]))  # -(Y - 2 X^3)^2 and what is beside it
    terms[Fraction(pick.randint(8, 9)), Fraction(pick.randint(0, 2))] = fmpq(pick.randint(1, 5))
    found = [*_curves(Monomials.of(terms), 2)]
    assert {x.v for x, _ in found if not x.outer}
    assert any(x.outer for x, _ in found)
    for curve, chart in found:
        for X in (exact(Fraction(1, 64)), exact(Fraction(1, 1 << 20))):
            height = curve.height(X)
            one, other = (
                value(terms, X, height),
                sum((c * X ** exact(a) for a, c in zip(chart.across, chart.along(curve.v), strict=True)), arb(0)),
            )
            assert height < 1
            assert height > 0 or curve.outer
            if abs(one).lower() > 0 and abs(other).lower() > 0:
                assert (one > 0) is (other > 0)
    tested = _Curve(Fraction(2), arb(3), ((Fraction(1, 2), fmpq(5), -1), (Fraction(1), fmpq(7, 2), 1)))
    assert float(tested.height(arb(4))) == pytest.approx(4**0.5 * (5 - 4 * (3.5 + 16 * 3)))
    assert log(float(_Curve(Fraction(3), arb(2)).height(arb(2)))) == pytest.approx(log(16))


def test_a_corner_is_bare_where_both_are_0_and_no_term_is_left() -> None:
    for constant, a, b in product([True, False], [0, 1], [0, 1]):
        own = Monomials.of(
            {(Fraction(1), Fraction(1)): fmpq(2), (Fraction(0), Fraction(0 if constant else 1)): fmpq(1)}
        )
        assert _is_bare(own, arb(a), arb(b)) is (not constant and a == b == 0)


@pytest.mark.parametrize(("low", "high"), [(1, 7), (2, 5), (0, 2), (3, 9), (0, 1)])
def test_a_box_is_in_two_beside_where_what_is_left_at_0_touches_unless_what_comes_next_is_negative(
    low: int, high: int
) -> None:
    """-(Y - 2)^2 and X, or -X; from Y = 2 on to both sides as far as the box goes."""
    touching: Sum = {(Fraction(0), Fraction(n)): fmpq(c) for n, c in ((0, -4), (1, 4), (2, -1))}
    own, up = Monomials.of({**touching, (Fraction(1), Fraction(0)): fmpq(1)}), (arb(low), arb(high))
    across = arb(0), arb(1) / 8
    found = _at_touch(own, across, up)
    true = [(-1, 2 - low), (1, high - 2)] if low <= 2 <= high else []
    assert len(found) == len([size for _, size in true if size > 0])
    for (chart, beside, side), (sign, size) in zip(found, [x for x in true if x[1] > 0], strict=True):
        assert (beside, side[0].is_zero(), float(side[1])) == (across, True, size)
        x, v = arb(1) / 9, arb(1) / 7
        assert alike(value(chart.terms, x, v), x - v**2)
        assert alike(value(own.terms, x, 2 + sign * v), x - v**2)
    assert _at_touch(own, (arb(1) / 16, arb(1) / 8), up) == []
    assert _at_touch(Monomials.of({**touching, (Fraction(1), Fraction(0)): fmpq(-1)}), across, up) == []


def test_a_sum_shows_to_be_negative_over_the_largest_negative_monomial_where_that_does_not_vanish() -> None:
    """Y - Y^2 from 2 to 100: 1/Y - 1 shows it; and the same in X. At a corner, and without a negative monomial, nothing does."""
    near, far = (arb(0), arb(1)), (arb(2), arb(100))
    for i in (0, 1):
        place = [[(Fraction(n), Fraction(0)), (Fraction(0), Fraction(n))][i] for n in (1, 2)]
        own = Monomials.of({place[0]: fmpq(1), place[1]: fmpq(-1)})
        assert _shows_negative(own, *((far, near) if i == 0 else (near, far)))
        assert _shows_negative(own, far, far)
        assert not _shows_negative(own, near, near)
        wide = arb(1) / 2, arb(100)
        assert not _shows_negative(own, *((wide, near) if i == 0 else (near, wide)))
        assert not _shows_negative(Monomials.of({place[0]: fmpq(1), place[1]: fmpq(2)}), far, far)
    assert _shows_negative(Monomials.of({(Fraction(0), Fraction(0)): fmpq(-1)}), near, near)
