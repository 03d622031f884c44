"""Certified counts of zeros of many polynomials at once, against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from haptisym.sweeps.batch import Array, Batch, error
from haptisym.sweeps.bernstein import isolate, refine

EDGES = (0.0, 0.3, 0.55, 1.0)


def batch(*polynomials: list[float], dtype: type = np.float64) -> Batch:
    """Polynomials whose coefficients are exactly these floats."""
    values = np.array(polynomials, dtype=dtype).T
    return Batch(values, abs(values), 0)


def zeros(polynomial: list[float], low: Fraction, high: Fraction) -> list[tuple[float, int]]:
    """All real zeros between low and high with multiplicity, from FLINT's certified complex roots of the exact polynomial."""
    exact = fmpq_poly([fmpq(*Fraction(x).as_integer_ratio()) for x in polynomial])
    real = [(z.real, n) for z, n in exact.complex_roots() if z.imag == 0]
    return sorted((float(x), n) for x, n in real if low < Fraction(float(x)) < high)


def random_polynomials(count: int, degree: int) -> list[list[float]]:
    """Half of them with all zeros near the band, so that there is something to count."""
    rng = np.random.default_rng(degree)
    wild = rng.integers(-9, 10, (count, degree + 1)).astype(float)
    wild[:, -1] = wild[:, -1] + (wild[:, -1] == 0)
    near = np.array([np.polynomial.polynomial.polyfromroots(rng.uniform(-0.2, 1.2, degree)) for _ in range(count)])
    return [*wild.tolist(), *near.tolist()]


@pytest.mark.parametrize("degree", [1, 2, 3, 6, 9])
def test_every_decided_count_is_the_exact_one_and_nearly_all_are_decided(degree: int) -> None:
    polynomials = random_polynomials(60, degree)
    p = batch(*polynomials)
    found = isolate(p, EDGES)
    counts = np.bincount(found.sets, minlength=len(polynomials))
    undecided = 0
    for i, polynomial in enumerate(polynomials):
        if not found.decided[i]:  # a zero at an end, a double one, a cluster
            undecided += 1
            continue
        exact = zeros(polynomial, Fraction(0), Fraction(1))
        assert counts[i] == len(exact)
        assert found.first[i] == np.sign(polynomial[0])
        mine = found.sets == i
        for (x, _), low, high in zip(exact, found.low[mine], found.high[mine], strict=True):
            assert low < x < high
    assert undecided < 0.15 * len(polynomials)


def test_refined_zeros_are_as_accurate_as_promised() -> None:
    polynomials = random_polynomials(60, 5)
    p = batch(*polynomials)
    found = isolate(p, EDGES)
    x, proven = refine(p.of(found.sets), found.low, found.high, 1e-12)
    assert proven.mean() > 0.75  # clusters of zeros are too sensitive
    for i, root, sure in zip(found.sets, x, proven, strict=True):
        if sure:
            nearest = min((z for z, _ in zeros(polynomials[i], Fraction(0), Fraction(1))), key=lambda z: abs(z - root))
            assert abs(nearest - root) <= 1.0001e-12 * root


def test_a_double_zero_is_never_decided_and_its_neighbours_are() -> None:
    # (x - 0.4)^2 with 0.4 the nearest double, then the same a little lower and a little higher
    square = np.array([0.4 * 0.4, -0.8, 1.0])
    exactly = [[0.25, -1.0, 1.0], [0.25 - 1e-9, -1.0, 1.0], [0.25 + 1e-9, -1.0, 1.0], square.tolist()]
    found = isolate(batch(*exactly), (0.0, 0.7, 1.0))
    assert found.decided.tolist()[:3] == [False, True, True]
    assert np.bincount(found.sets, minlength=4).tolist()[:3] == [0, 2, 0]


def test_a_zero_at_an_end_or_at_an_edge_is_not_decided() -> None:
    at_ends = [[0.0, 1.0], [-1.0, 1.0], [-0.3, 1.0]]
    assert isolate(batch(*at_ends), EDGES).decided.tolist() == [False, False, False]


def test_a_doubtful_first_segment_may_hold_no_zero() -> None:
    lines = [[-0.1, 1.0], [-0.6, 1.0]]
    found = isolate(batch(*lines), (0.0, 0.2, 1.0), first_is_doubt=True)
    assert found.decided.tolist() == [False, True]
    assert found.sets.tolist() == [1]


def test_what_is_not_finite_is_not_decided() -> None:
    found = isolate(batch([np.nan, 1.0], [np.inf, -np.inf], [1.0, 1.0]), EDGES)
    assert found.decided.tolist() == [False, False, True]


def test_an_error_bound_as_large_as_the_value_leaves_it_undecided() -> None:
    p = batch([-0.5, 1.0])
    blurred = Batch(p.values, np.full_like(p.sizes, 1e10), 10**6)
    assert isolate(p, EDGES).decided.all()
    assert not isolate(blurred, EDGES).decided.any()


def test_results_do_not_depend_on_how_many_are_done_at_once() -> None:
    polynomials = random_polynomials(200, 6)
    together = isolate(batch(*polynomials), EDGES)
    for i, polynomial in enumerate(polynomials[::7]):
        alone = isolate(batch(polynomial), EDGES)
        mine = together.sets == 7 * i
        assert together.decided[7 * i] == alone.decided[0]
        assert together.low[mine].tolist() == alone.low.tolist()


@given(st.lists(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3), min_size=3, max_size=3))
def test_the_bound_holds_for_products_and_differences(rows: list[list[float]]) -> None:
    a, b, c = (batch(row) for row in rows)
    found = a * b * c - a * a
    exact = _difference(_times(_times(rows[0], rows[1]), rows[2]), _times(rows[0], rows[0]))
    bound: Array = error(found.sizes, found.roundings)[:, 0] + 1e-300
    for value, truth, limit in zip(found.values[:, 0], exact, bound, strict=True):
        assert abs(Fraction(float(value)) - truth) <= Fraction(float(limit))


def _times(a: list[float], b: list[float]) -> list[Fraction]:
    result = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += Fraction(x) * Fraction(y)
    return result


def _difference(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    return [x - (b[i] if i < len(b) else 0) for i, x in enumerate(a)]
