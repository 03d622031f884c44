"""Sums of monomials with real exponents: what is done with them leaves their values, at points with exact roots."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random
from typing import Any

import pytest
from flint import arb, ctx, fmpq, fmpq_poly
from plainshapes import exact
from plainsums import POINTS, Sum, alike, drawn, value

from haptisym.verbs.require.knownsums import Known, ball
from haptisym.verbs.require.monomials import Monomials, power


@pytest.fixture(autouse=True)
def _precise() -> Any:
    with ctx.workprec(160):
        yield


@pytest.mark.parametrize("seed", range(6))
def test_parts_of_a_sum_are_its_terms_and_what_it_is_divided_by_leaves_its_values(seed: int) -> None:
    pick = Random(seed)
    given = drawn(pick, under=2)
    own = Monomials.of(given)
    assert own.terms == given
    across, up = sorted({a for a, _ in given}), sorted({b for _, b in given})
    assert ([*own.across], [*own.up]) == (across, up)
    assert own.has_constant is ((Fraction(0), Fraction(0)) in given)
    for n, least in enumerate(across):
        left = own.above(n)
        assert (None if left is None else left.terms) == ({e: c for e, c in given.items() if e[0] > least} or None)
        assert own.row(n) is not None
    mixed = Monomials.of({**given, (across[-1], Fraction(9)): arb(2, 1)})
    assert [mixed.row(n) is None for n in range(len(across))] == [False] * (len(across) - 1) + [True]
    a, b = pick.choice(across[:2]), pick.choice(up[:2])
    less: Any
    for less in ((a, b), (a, Fraction(0)), (Fraction(0), b), (Fraction(0), Fraction(0))):
        divided = own.over_power(*less)
        for x, y in POINTS:
            assert alike(
                value(divided.terms, exact(x), exact(y)) * exact(x) ** exact(less[0]) * exact(y) ** exact(less[1]),
                value(given, exact(x), exact(y)),
            )
    zero, one, two = arb(0), arb(1), arb(2)
    for first, second in product([zero, one], repeat=2):
        reduced = own.reduced((first, two), (second, two)).terms
        less = (across[0] if first is zero else 0, up[0] if second is zero else 0)
        assert reduced == {(x - less[0], y - less[1]): c for (x, y), c in given.items()}


@pytest.mark.parametrize("seed", range(8))
def test_along_curves_and_beside_lines_a_sum_has_the_values_of_the_other(seed: int) -> None:
    """Y = at + w and at - w, Y = X^p v over a power of X, and at a number Y; of exact coefficients, known sums and balls."""
    pick = Random(seed)
    given = drawn(pick)
    if seed % 2:
        given[Fraction(3), Fraction(4)] = Known({(): fmpq(1, 3), (1,): fmpq(-2)}, {(): arb(1), (1,): arb.pi()})
        given[Fraction(3), Fraction(2)] = arb(5) / 7
    own = Monomials.of(given)
    for at, sign in product([fmpq(0), fmpq(2), fmpq(3, 2)], [1, -1]):
        moved = own.shifted(at, sign)
        assert all(isinstance(c, Known) or c for c in moved.terms.values())
        for x, y in POINTS:
            place = exact(Fraction(int(at.p), int(at.q)) + sign * y / 9)
            assert alike(
                value(moved.terms, exact(x), exact(y / 9)),
                sum((ball(c) * exact(x) ** exact(a) * place ** int(b) for (a, b), c in given.items()), arb(0)),
            )
    for p in (Fraction(1), Fraction(2, 3), Fraction(5, 2)):
        risen = own.risen(p)
        least = min(a + p * b for a, b in given)
        assert risen.across[0] == 0
        for x, v in POINTS:
            assert alike(
                value(risen.terms, exact(x), exact(v)) * exact(x) ** exact(least),
                value(given, exact(x), exact(v) * exact(x) ** exact(p)),
            )
    for x, v in POINTS:
        rows = own.along(exact(v))
        assert len(rows) == len(own.across)
        assert alike(
            sum((c * exact(x) ** exact(a) for a, c in zip(own.across, rows, strict=True)), arb(0)),
            value(given, exact(x), exact(v)),
        )


@pytest.mark.parametrize("seed", range(6))
def test_over_a_box_a_sum_has_all_its_values_and_one_monomial_no_others(seed: int) -> None:
    pick = Random(seed)
    given = drawn(pick, under=2)
    own = Monomials.of(given)
    ends = [sorted(Fraction(pick.randint(0 if pick.random() < 0.5 else 1, 9), 4) for _ in range(2)) for _ in range(2)]
    sides: Any = [tuple(map(exact, pair)) for pair in ends]
    found = own.over(*sides)
    shares = [Fraction(n, 4) for n in range(5)]
    for i, j in product(shares, repeat=2):
        x, y = (a + (b - a) * k for (a, b), k in zip(ends, (i, j), strict=True))
        if x > 0 and y > 0:
            assert found.overlaps(value(given, exact(x), exact(y)))
    a, b = pick.choice([*given])
    for place, side, n in (((a, Fraction(0)), sides[0], a), ((Fraction(0), b), sides[1], b)):
        single = Monomials.of({place: fmpq(1)}).over(*sides)
        for told, end in ((single.lower(), side[0]), (single.upper(), side[1])):
            assert float(told) == pytest.approx(
                float(power(end, n)), rel=1e-7, abs=1e-7 * (1 + float(power(side[1], n)))
            )
    x, y = exact(Fraction(9, 4)), exact(Fraction(4, 9))
    for less in ((a, b), (a, Fraction(0)), (Fraction(0), b)):
        point = own.over((x, x), (y, y), less)
        assert alike(point * x ** exact(less[0]) * y ** exact(less[1]), value(given, x, y))


@pytest.mark.parametrize("seed", range(6))
def test_the_most_negative_monomial_at_a_point_is_the_least_of_all(seed: int) -> None:
    pick = Random(seed)
    given = drawn(pick, under=3)
    own = Monomials.of(given)
    for x, y in ((0.1, 3.0), (7.0, 0.2), (1e-6, 1e-9), (1.0, 1.0)):
        values = {e: float(c.p) / float(c.q) * x ** float(e[0]) * y ** float(e[1]) for e, c in given.items()}
        found = own.most_negative(arb(x), arb(y))
        if min(values.values()) >= 0:
            assert found is None
        else:
            assert found is not None
            assert values[found] == pytest.approx(min(values.values()), rel=1e-12)
    assert Monomials.of({e: abs(c) for e, c in given.items()}).most_negative(arb(1), arb(1)) is None


@pytest.mark.parametrize("seed", range(8))
def test_of_what_is_left_at_0_double_roots_are_told_and_of_newtons_polygon_the_first_edge(seed: int) -> None:
    """(Y - a)^2 (Y - b)(Y + c)^2 Y^n, and X^k before others: a alone touches; slope by all pairs of terms."""
    pick = Random(seed)
    a, b, c = pick.sample([fmpq(1, 2), fmpq(2), fmpq(3), fmpq(7, 3)], 3)
    n = pick.randint(0, 2)
    row = (
        fmpq_poly([-a, 1]) ** pick.choice([2, 4]) * fmpq_poly([-b, 1]) * fmpq_poly([c, 1]) ** 2 * fmpq_poly([0, 1]) ** n
    )
    given: Sum = {(Fraction(0), Fraction(i)): x for i, x in enumerate(row.coeffs()) if x}
    for _ in range(4):
        given[Fraction(pick.randint(1, 9), pick.choice([1, 2])), Fraction(pick.randint(0, 4))] = fmpq(
            pick.choice([-3, 2, 5])
        )
    own = Monomials.of(given)
    assert [*own.touches] == [a]
    halves = Monomials.of({**given, (Fraction(5), Fraction(1, 2)): fmpq(1)})
    assert [*halves.touches] == []
    least = min(y for x, y in given if x == 0)
    below = {e: x for e, x in given.items() if e[1] < least}
    if not below:
        return
    p, v = own.slope
    assert p == min(x / (least - y) for x, y in below)
    left = [(least - y, c) for (x, y), c in below.items() if x / (least - y) == p]
    rise, end = min(left, key=lambda row: row[0])
    alike_at = (abs(float(end)) / abs(float(given[Fraction(0), least]))) ** (1 / float(rise))
    touching = [2 * float(arb(x)) for x in own.risen(p).touches]
    assert float(v) == pytest.approx(max([alike_at, *touching]), rel=1e-12)


def test_where_a_coefficient_may_be_0_terms_are_taken_to_be_alike_at_1() -> None:
    about_0, one, four = arb(0, 1), fmpq(1), fmpq(-4)
    for first, last, at in (
        (one, about_0, 1.0),
        (about_0, one, 1.0),
        (about_0, about_0, 1.0),
        (one, four, 2.0),
        (four, one, 0.5),
    ):
        own = Monomials.of({(Fraction(0), Fraction(2)): first, (Fraction(3), Fraction(0)): last})
        p, v = own.slope
        assert (p, float(v)) == (Fraction(3, 2), at)


@pytest.mark.parametrize(
    ("x", "a"),
    [
        (0, 0),
        (0, Fraction(1, 2)),
        (0, 3),
        (2, Fraction(-1, 2)),
        (2, -3),
        (9, Fraction(1, 2)),
        (5, 0),
        (3, 4),
        (8, Fraction(2, 3)),
    ],
)
def test_a_power_of_a_number_that_is_not_negative(x: int, a: Any) -> None:
    true = 1.0 if a == 0 else float(x) ** float(a)
    assert float(power(arb(x), Fraction(a))) == pytest.approx(true, rel=1e-14)
    assert power(arb(x), Fraction(a)).rad() < 1e-30
