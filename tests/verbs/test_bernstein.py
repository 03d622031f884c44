"""Certified counts of zeros of many polynomials at once, against exact arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, zip_longest
from itertools import product as cartesian
from math import comb

import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from haptisym.verbs.sweep import bernstein
from haptisym.verbs.sweep.batch import MOST_TERMS, Array, Batch, error, nearest, product
from haptisym.verbs.sweep.bernstein import isolate, refine

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


@pytest.mark.parametrize("cuts", [0, 1, 3])
def test_however_few_cuts_there_are_no_decided_count_is_wrong(cuts: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bernstein, "_MOST_CUTS", cuts)
    polynomials = random_polynomials(20, 5)
    found = isolate(batch(*polynomials), EDGES)
    counts = np.bincount(found.sets, minlength=len(polynomials))
    for i in np.flatnonzero(found.decided):
        assert counts[i] == len(zeros(polynomials[i], Fraction(0), Fraction(1)))
    assert 0 < found.decided.sum() < len(polynomials)


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
    return [x - y for x, y in zip_longest(a, b, fillvalue=Fraction(0))]


# --- the bound, as it is proven --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Path:
    """A number that knows only through how many roundings it went; a float is one that was rounded once, an int exact."""

    roundings: int = 0

    def __add__(self, other: object) -> Path:
        if not isinstance(other, Path):  # nothing but the 0 that sums begin with
            return self
        return Path(max(self.roundings, other.roundings) + 1)

    def __mul__(self, other: object) -> Path:
        if isinstance(other, int):  # nothing but the 1 that powers begin with
            return self
        return Path(self.roundings + (other.roundings if isinstance(other, Path) else 1) + 1)

    __radd__ = __sub__ = __rsub__ = __add__
    __rmul__ = __mul__


def paths(degree: int, roundings: int) -> Batch:
    values = np.array([[Path(roundings)]] * (degree + 1), dtype=object)
    return Batch(values, values, roundings)


def longest(values: Array) -> int:
    return max(x.roundings for x in values.ravel())


@pytest.mark.parametrize("first", [(0, 1), (1, 7), (3, 0), (6, 4)])
@pytest.mark.parametrize("second", [(0, 0), (1, 2), (4, 9)])
def test_products_and_differences_count_the_roundings_of_the_longest_path(
    first: tuple[int, int], second: tuple[int, int]
) -> None:
    a, b = paths(*first), paths(*second)
    for found in (a * b, b * a, a * b * a, a - b, b - a):
        assert longest(found.values) == found.roundings
    assert len((a * b).values) == first[0] + second[0] + 1
    assert len((a - b).values) == max(first[0], second[0]) + 1


@pytest.mark.parametrize("degree", [0, 1, 2, 5, 9])
def test_signs_count_the_roundings_of_the_longest_path(degree: int, monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[int] = []
    taken: list[int] = []

    def error_counted(sizes: Array, roundings: int) -> Array:
        counted.append(roundings)
        return sizes

    def signs(values: Array, bound: Array) -> Array:
        taken.append(longest(values))
        return np.zeros(values.shape, np.int8)

    def in_any_order(_: str, weights: Array, terms: Array) -> Array:
        """The last sums: a weight that was rounded, a product, and as many sums as there may be."""
        return np.full((*weights.shape[:-1], 1), Path(longest(terms) + 2 + degree), dtype=object)

    monkeypatch.setattr(np, "einsum", in_any_order)
    monkeypatch.setattr(bernstein, "error", error_counted)
    monkeypatch.setattr(bernstein, "_certain_signs", signs)
    p, x = paths(degree, 3), np.array([Path()], dtype=object)
    bernstein._signs_on_segments(p, EDGES)
    bernstein._signs_at(p, x)
    bernstein._signs_on_halves(p, x, x, x)
    on_segments, at, *halves = zip(counted, taken, strict=True)
    assert on_segments == (degree + 5, degree + 5)
    assert at == (2 * degree + 3, 2 * degree + 3)
    assert len(halves) == 2
    assert all(path <= bound <= path + 1 for bound, path in halves)


@pytest.mark.parametrize("dtype", [np.float64, np.longdouble])
@pytest.mark.parametrize("roundings", [0, 1, 7, 1000, 10**9])
def test_the_bound_is_that_of_so_many_roundings_and_hardly_more(dtype: type, roundings: int) -> None:
    eps = Fraction(2) ** -int(np.finfo(dtype).nmant)
    n = roundings * eps / 2
    for size in (1.0, 3.7, 1e-200):
        [found] = error(np.array([size], dtype), roundings)
        gamma = n / (1 - n) * Fraction(size)
        assert gamma <= Fraction(*found.as_integer_ratio()) <= Fraction(1002, 1000) * gamma


def test_no_more_roundings_are_bounded_than_the_proof_allows() -> None:
    error(np.ones(1), MOST_TERMS)
    with pytest.raises(AssertionError):
        error(np.ones(1), MOST_TERMS + 1)
    assert MOST_TERMS <= 10**9


@pytest.mark.parametrize("dtype", [np.float64, np.longdouble])
def test_a_constant_is_rounded_once(dtype: type) -> None:
    u = Fraction(2) ** -(int(np.finfo(dtype).nmant) + 1)
    for x in (Fraction(1, 3), Fraction(-22, 7), Fraction(10**30, 7**20), Fraction(5, 2)):
        found = nearest(x, dtype)
        assert type(found) is dtype
        assert abs(Fraction(*found.as_integer_ratio()) - x) <= u * abs(x)


@pytest.mark.few(3)
@pytest.mark.parametrize("dtype", [np.float64, np.longdouble])
@pytest.mark.parametrize("degrees", [(0, 0), (0, 3), (4, 1), (2, 2), (5, 7)])
def test_sizes_are_those_of_the_terms_and_bound_what_rounding_did(dtype: type, degrees: tuple[int, int]) -> None:
    rng = np.random.default_rng(sum(degrees))
    a, b = ((rng.uniform(-1, 1, (n + 1, 60)) * 10.0 ** rng.integers(-9, 9, (n + 1, 60))).astype(dtype) for n in degrees)
    x, y = Batch(a, abs(a), 0), Batch(b, abs(b), 0)
    for found, of in (
        (x * y, _times),
        (x - y, _difference),
        (y - x, lambda p, q: _difference(q, p)),
        (product([x, y, x]), _thrice),
    ):
        bound = error(found.sizes, found.roundings)
        for i in range(60):
            p, q = ([Fraction(*c.as_integer_ratio()) for c in rows[:, i]] for rows in (a, b))
            rows = zip(found.values[:, i], found.sizes[:, i], bound[:, i], strict=True)
            sizes = _thrice(list(map(abs, p)), list(map(abs, q))) if of is _thrice else None
            exact = of(p, q)
            for n, (value, size, limit) in enumerate(rows):
                assert abs(Fraction(*value.as_integer_ratio()) - exact[n]) <= Fraction(*limit.as_integer_ratio())
                if sizes:
                    assert abs(Fraction(*size.as_integer_ratio()) / sizes[n] - 1) < Fraction(1, 10**12)


def _thrice(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    found = [Fraction(0)] * (2 * len(p) + len(q) - 2)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            for k, z in enumerate(p):
                found[i + j + k] += x * y * z
    return found


def test_a_sign_is_certain_only_beyond_the_bound_and_what_may_have_been_lost_to_underflow() -> None:
    bounds = np.array([0.0, 1e-300, 1e-280, 3e-280, 1e-16, 1.0, np.inf, np.nan])
    finite = np.where(np.isfinite(bounds), bounds, 1.0)
    for scale in (0.0, 0.5, 0.999, 1.0, 1.0001, 1.5, 2.0, 1e30):
        for v in (scale * (finite + 1e-280), -scale * (finite + 1e-280)):
            found = bernstein._certain_signs(v, bounds)
            certain = np.isfinite(bounds) & (np.abs(v) > bounds + 1e-280)
            assert (found == np.where(certain, np.sign(v), 0)).all()


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_a_row_of_signs_is_classified_by_what_those_that_are_not_known_may_be(count: int) -> None:
    """No zero or one, exactly where every choice of the unknown ones has so many changes; at the ends they must be known."""

    def changes(row: tuple[int, ...]) -> int:
        known = [x for x in row if x]
        return sum(x != y for x, y in pairwise(known))

    rows = list(cartesian((-1, 0, 1), repeat=count))
    none, one = bernstein._classified(np.array(rows, np.int8).T)
    for row, no, single in zip(rows, none, one, strict=True):
        possible = {changes(x) for x in cartesian(*((sign,) if sign else (-1, 0, 1) for sign in row))}
        ends = bool(row[0] and row[-1])
        assert no == (ends and possible == {0}), row
        assert single == (ends and possible == {1}), row


@pytest.mark.parametrize("degree", [0, 1, 2, 4])
def test_bernstein_coefficients_are_those_of_the_polynomial_on_its_segment(degree: int) -> None:
    """sum_j c_j binomial(n, j) t^j (1 - t)^(n - j) is p(a + t (b - a)), by both ways to compute them."""
    p = [Fraction(c) for c in (3, -5, 7, 2, -4)[: degree + 1]]
    edges = (0.0, 0.125, 0.5, 1.0)
    on_segments = bernstein._weights(edges, degree, np.dtype(np.float64))
    for (a, b), weights in zip(pairwise(edges), on_segments, strict=True):
        shifted = bernstein._bernstein(np.array([[float(c)] for c in p]), np.array([a]), np.array([b]))[:, 0]
        for c in (weights @ [float(x) for x in p], shifted):
            for t in (0.0, 0.25, 0.7, 1.0):
                value = sum(x * comb(degree, j) * t**j * (1 - t) ** (degree - j) for j, x in enumerate(c))
                assert value == pytest.approx(
                    float(sum(x * Fraction(a + t * (b - a)) ** i for i, x in enumerate(p))), abs=1e-13
                )


# --- cutting and refining --------------------------------------------------------------------------------------------


def from_roots(*roots: float) -> list[float]:
    return np.polynomial.polynomial.polyfromroots(roots).tolist()


def test_zeros_that_only_cutting_sets_apart_are_in_order_and_alone() -> None:
    """Three and more in one segment, some of them close; the sets between them have none, so that numbers are not mixed up."""
    roots = [(0.31, 0.33, 0.5), (0.6, 0.61, 0.62, 0.9), (), (0.02, 0.021, 0.2), (0.7,)]
    signs = [1, -1, 1, -1, 1]
    degree = max(map(len, roots))
    rows = [[s * c for c in from_roots(*r)] + [0.0] * (degree - len(r)) for r, s in zip(roots, signs, strict=True)]
    for edges in (EDGES, (0.0, 1.0), (0.0, 0.015, 0.95, 1.0)):
        found = isolate(batch(*rows), edges)
        assert found.decided.all()
        assert found.sets.tolist() == [i for i, r in enumerate(roots) for _ in r]
        expected = [x for r in roots for x in r]
        assert all(a < x < b for a, x, b in zip(found.low, expected, found.high, strict=True))
        assert found.first.tolist() == [s * (-1) ** len(r) for s, r in zip(signs, roots, strict=True)]
        mine = [(a, b) for i, a, b in zip(found.sets, found.low, found.high, strict=True) if i == 1]
        assert all(b <= c for (_, b), (c, _) in pairwise(mine))


@pytest.mark.parametrize("low", [0.0, 0.01])
def test_the_sign_at_the_low_end_is_known_where_only_a_short_segment_shows_it(low: float) -> None:
    """A value there that is next to nothing beside those elsewhere: lost in the first bound, clear in that of its own end."""
    for sign in (1, -1):
        step = [sign * c for c in (1e-14 * (1 + low), 0.0, 0.0, 1.0, 0.0)]  # moved to the low end below
        shifted = (
            np.polynomial.Polynomial(step)(np.polynomial.Polynomial([-low, 1.0])).coef if low else np.array(step[:4])
        )
        hump = np.polynomial.Polynomial(shifted) * np.polynomial.Polynomial([0.72, -1.7, 1.0])  # zeros at 0.8 and 0.9
        rows = hump.coef.tolist()
        found = isolate(batch(rows), (low, 1.0))
        if low == 0.0:
            assert found.decided.all()
            assert found.first.tolist() == [sign]
            assert found.sets.tolist() == [0, 0]
        assert not found.decided.any() or found.first.tolist() == [sign]


def test_a_doubtful_first_segment_is_not_cut_and_leaves_the_others_as_they_are() -> None:
    """Where the low end lies is not known better: a zero in the first segment, or two, cannot be told from none."""
    rows = [
        from_roots(0.05, 0.07, 0.6),
        from_roots(0.5, 0.6, 0.7),
        from_roots(0.05, 0.5, 0.6),
        from_roots(0.3, 0.9, 1.2),
    ]
    found = isolate(batch(*rows), (0.0, 0.1, 0.4, 1.0), first_is_doubt=True)
    assert found.decided.tolist() == [False, True, False, True]
    assert found.sets.tolist() == [1, 1, 1, 3, 3]
    assert found.first.tolist()[1::2] == [-1, -1]
    certain = isolate(batch(*rows), (0.0, 0.1, 0.4, 1.0))
    assert certain.decided.all()
    assert certain.sets.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3]


def test_a_set_with_an_end_that_is_not_certain_is_given_up_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds: list[int] = []
    halves = bernstein._signs_on_halves

    def counted(p: Batch, *ends: Array) -> Array:
        rounds.append(p.values.shape[1])
        return halves(p, *ends)

    monkeypatch.setattr(bernstein, "_signs_on_halves", counted)
    at_ends = [[0.0, 1.0, -1.5], [0.5, -1.5, 1.0], [float("nan"), 1.0, 1.0]]
    assert not isolate(batch(*at_ends), (0.0, 1.0)).decided.any()
    assert rounds == [3]
    rounds.clear()
    double = isolate(batch(from_roots(0.4375, 0.4375), [*from_roots(0.25), 0.0]), (0.0, 1.0))
    assert double.decided.tolist() == [False, True]
    assert len(rounds) <= 48


def test_zeros_well_apart_are_all_proven_and_found_to_the_last_digits() -> None:
    rng = np.random.default_rng(4)
    roots = (np.arange(5)[:, None] + rng.uniform(0.2, 0.8, (5, 200))) / 5  # one in each fifth of the band
    rows = [from_roots(*column) for column in roots.T]
    p = batch(*rows)
    found = isolate(p, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0))
    assert found.decided.all()
    assert (np.bincount(found.sets) == 5).all()
    x, proven = refine(p.of(found.sets), found.low, found.high, 1e-10)
    assert proven.all()
    exact = np.array([z for row in rows[:20] for z, _ in zeros(row, Fraction(0), Fraction(1))])
    assert (abs(x[:100] / exact - 1) <= 1e-12).all()
    assert np.median(abs(x[:100] / exact - 1)) < 1e-14
    assert not refine(p.of(found.sets), found.low, found.high, 1e-17)[1].any()  # finer than floats are
    again, wide = refine(
        Batch(*(a.astype(np.longdouble) for a in (p.values, p.sizes)), 0).of(found.sets), found.low, found.high, 1e-13
    )
    assert again.dtype == np.longdouble
    assert wide.all()


def test_a_zero_is_proven_only_on_its_own_side_of_the_segment_s_end() -> None:
    """Twins a thousandth beside an end, with a tolerance of a hundredth: the other one must not disturb the signs."""
    for low, high, inside in ((0.0, 0.5, 0.4995), (0.5, 1.0, 0.5005)):
        p = batch(from_roots(0.4995, 0.5005))
        x, proven = refine(p, np.array([low]), np.array([high]), 0.01)
        assert proven.all()
        assert low < x[0] < high
        assert x[0] == pytest.approx(inside, rel=1e-10)


def test_what_is_no_number_or_has_no_zero_is_never_proven() -> None:
    p = batch([np.nan, 1.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 0.0], [np.inf, -1.0, 0.0], [1.0, -1e-300, 0.0])
    _, proven = refine(p, np.full(5, 0.1), np.full(5, 0.9), 1e-3)
    assert not proven.any()


@pytest.mark.parametrize("exponent", [1, 3, 11])
def test_newton_is_kept_in_its_bracket_where_slopes_mislead(exponent: int) -> None:
    """(x - 0.3)^n + a little: flat around the middle, where Newton's steps leave the band, or steep beside it."""
    shifted = np.polynomial.Polynomial(from_roots(*[0.3] * exponent)) + 1e-3
    for sign in (1, -1):
        p = batch((sign * shifted).coef.tolist())
        x, proven = refine(p, np.array([0.0]), np.array([1.0]), 1e-6)
        root = 0.3 - 1e-3 ** (1 / exponent)
        if root > 0:
            assert proven.all()
            assert x[0] == pytest.approx(root, rel=1e-6)


def test_the_sign_at_the_low_end_is_not_that_of_another_segment_that_was_cut() -> None:
    """1e-14 - x^3: positive at 0 and up to 2e-5; two zeros more beside each other in the upper half."""
    rows = [
        np.polynomial.Polynomial([sign * 1e-14, 0, 0, -sign]) * np.polynomial.Polynomial(from_roots(0.8, 0.82))
        for sign in (1, -1)
    ]
    found = isolate(batch(*(p.coef.tolist() for p in rows)), (0.0, 0.5, 1.0))
    assert found.decided.all()
    assert found.first.tolist() == [1, -1]
    assert found.sets.tolist() == [0, 0, 0, 1, 1, 1]
    x, proven = refine(batch(*(p.coef.tolist() for p in rows)).of(found.sets), found.low, found.high, 1e-10)
    assert proven.all()
    assert x.tolist() == pytest.approx([1e-14 ** (1 / 3), 0.8, 0.82] * 2, rel=1e-9)


def test_a_zero_at_which_newton_arrives_by_small_steps_is_found_all_the_same() -> None:
    """x^4 - 1e-40: from the middle of the band each step takes off a quarter, eighty of them."""
    for sign in (1, -1):
        p = batch([-sign * 1e-40, 0.0, 0.0, 0.0, sign])
        x, proven = refine(p, np.array([0.0]), np.array([1.0]), 1e-10)
        assert proven.all()
        assert x[0] == pytest.approx(1e-10, rel=1e-10)
