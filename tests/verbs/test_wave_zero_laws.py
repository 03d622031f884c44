"""Zeros of many functions with waves and powers at once: those that were placed by hand, each found once, alone and to its digits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import comb
from random import Random
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest

from haptisym.verbs.sweep import wavezeros
from haptisym.verbs.sweep.batch import Batch
from haptisym.verbs.sweep.chebyshev import left_out, nodes
from haptisym.verbs.sweep.families import Monomial, Powers
from haptisym.verbs.sweep.waveroots import refine
from haptisym.verbs.sweep.waves import Variables, WaveFamily
from haptisym.verbs.sweep.wavevalues import TINY, Factor, Points, WaveFunction
from haptisym.verbs.sweep.wavezeros import Curves, _interpolated, isolate

ORDERS = (0.25, 0.5)


@dataclass
class Placed:
    """Functions of one kind, one for each set, where they vanish beyond 0, and their signs just above it."""

    function: WaveFunction
    exact: list[Any]
    zeros: list[list[mpmath.mpf]]
    signs: list[int]


def placed(pick: Random, sets: int, lines: int, *, wave: bool, orders: tuple[int, ...] = ()) -> Placed:
    """Products of x - a, cos(k x) - b and x^alpha - c, with alpha of those ``orders``."""
    factors: list[tuple[tuple[int, ...], list[float]]] = []
    k = [pick.uniform(0.5, 12.0) for _ in range(sets)]
    factors += [((1, 0, 0, 0, 0), [pick.uniform(-0.5, 1.5) for _ in range(sets)]) for _ in range(lines)]
    factors += [((0, 1, 0, 0, 0), [pick.uniform(-1.2, 1.2) for _ in range(sets)])] if wave else []
    for i in orders:
        row = (0, 0, 0, *(int(i == n) for n in range(2)))
        factors.append((row, [pick.uniform(-0.3, 1.2) for _ in range(sets)]))
    count = 1 + len(factors)
    unit = [tuple(int(i == j) for j in range(count)) for i in range(count)]
    variables = Variables((Monomial(0, 1.0, 0.0, unit[0]),), ORDERS)
    known = Powers(np.array([k, *(x for _, x in factors)]))
    above = list[Factor]()
    for i, (row, _) in enumerate(factors):
        terms = Monomial(0, -1.0, 0.0, unit[1 + i]), Monomial(1, 1.0, 0.0, (0,) * count)
        family = WaveFamily(terms, variables, ((0,) * 5, row))
        above.append(Factor(family, family.at(known)))
    own = [[(row, mpmath.mpf(x[n])) for row, x in factors] for n in range(sets)]
    return Placed(
        WaveFunction(variables, np.array([k]), tuple(above)),
        [lambda x, n=n: mpmath.fprod(_value(row, x, k[n]) - y for row, y in own[n]) for n in range(sets)],
        [[z for row, y in own[n] for z in _zeros(row, y, k[n])] for n in range(sets)],
        [int(np.prod([1 if _value(row, mpmath.mpf(0), k[n]) > y else -1 for row, y in own[n]])) for n in range(sets)],
    )


def _value(row: tuple[int, ...], x: mpmath.mpf, k: float) -> mpmath.mpf:
    line, wave, _, *orders = row
    return x if line else mpmath.cos(k * x) if wave else x ** mpmath.mpf(ORDERS[orders.index(1)])


def _zeros(row: tuple[int, ...], y: mpmath.mpf, k: float) -> list[mpmath.mpf]:
    """Beyond 0, as far as twice the end."""
    line, wave, _, *orders = row
    if wave:
        first = mpmath.acos(y) / k if abs(y) <= 1 else mpmath.inf
        return [z for n in range(5) for e in (1, -1) if 0 < (z := 2 * n * mpmath.pi / k + e * first) < mpmath.inf]
    return [y if line else y ** (1 / mpmath.mpf(ORDERS[orders.index(1)]))] if y > 0 else []


def _hold(given: Placed, low: float) -> float:
    """What is decided and proven is right; how large a share is, of functions whose zeros are well apart."""
    f = given.function
    found = isolate(f, (low, 0.4, 1.0))
    told = {accuracy: refine(f.of(found.sets), found.low, found.high, accuracy) for accuracy in (1e-9, 1e-14, 1e-16)}
    _, proven = told[1e-9]
    clear = decided = asked = shown = 0
    for i in range(f.sets):
        inside = sorted(z for z in given.zeros[i] if low < z < 1)
        marks = sorted([mpmath.mpf(low), mpmath.mpf("0.4"), mpmath.mpf(1), *given.zeros[i]])
        apart = min(b - a for a, b in pairwise(marks)) > 1e-3
        clear += apart
        if not found.decided[i]:
            continue
        decided += apart
        own = np.flatnonzero(found.sets == i)
        assert len(own) == len(inside)
        for j, z in zip(own, inside, strict=True):
            assert found.low[j] <= z <= found.high[j]
            for accuracy, (x, sure) in told.items():
                assert not sure[j] or abs(mpmath.mpf(float(x[j])) - z) <= mpmath.mpf(accuracy) * z
            asked, shown = asked + apart, shown + (apart and proven[j])
        assert found.first[i] == given.signs[i] * (-1) ** sum(z <= low for z in given.zeros[i])
    return min(decided / max(clear, 1), shown / max(asked, 1))


class Rounded:
    """How often the terms of a number were rounded, at most: a product and a sum are, each."""

    def __init__(self, often: int) -> None:
        self.often = often

    def __mul__(self, other: Rounded) -> Rounded:
        return Rounded(self.often + other.often + 1)

    def __add__(self, other: Any) -> Rounded:
        return Rounded(max(self.often, other.often) + 1) if isinstance(other, Rounded) else self

    __radd__ = __add__


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
def test_no_term_of_coefficients_in_two_bases_is_rounded_more_often_than_is_counted(degree: int) -> None:
    """As its operations tell, and in floats: beside a 1 each half of a last digit is lost, and so the sum falls short by that."""
    n, m = nodes(degree), nodes(6)
    weights = [np.full(x.matrix.shape, Rounded(1), dtype=object) for x in (n, m)]
    ones = [np.ones_like(x.matrix) for x in (n, m)]
    first, second = ((replace(n, matrix=a), replace(m, matrix=b)) for a, b in (weights, ones))
    found, counted = wavezeros._in_both(*first, np.full((degree + 1, 7, 1), Rounded(0), dtype=object))
    assert {x.often for x in found.ravel()} == {counted}
    values = np.full((degree + 1, 7, 3), 2.0**-53)
    values[0, 0] = 1.0
    sums, counted = wavezeros._in_both(*second, values)
    exact = 1 + (7 * (degree + 1) - 1) * Fraction(1, 2**53)
    assert all(abs(Fraction(x) - exact) <= counted * Fraction(1, 2**53) * exact for x in sums.ravel().tolist())
    places = [Fraction(x) for x in np.random.default_rng(degree).uniform(-1, 1, values.size).tolist()]
    plain, _ = wavezeros._in_both(n, m, np.array(places, float).reshape(values.shape))
    for k, i, b in np.ndindex(*plain.shape):
        true = sum(
            Fraction(n.matrix[k, p].item()) * Fraction(m.matrix[i, q].item()) * places[(p * 7 + q) * 3 + b]
            for p in range(degree + 1)
            for q in range(7)
        )
        size = Fraction(n.amplified[k].item()) * Fraction(m.amplified[i].item())
        assert abs(Fraction(plain[k, i, b].item()) - true) <= counted * Fraction(1, 2**53) * size


@pytest.mark.parametrize("seed", range(6))
def test_no_term_of_a_sum_of_waves_is_rounded_more_often_than_is_counted(seed: int) -> None:
    """Of values from coefficients and an x that were rounded some times, and of their coefficients in all halvings."""
    pick = Random(seed)
    unit = (0, 1)
    variables = Variables((Monomial(0, 1.0, 0.0, unit), Monomial(0, 2.0, 0.0, unit)), ORDERS)
    for _ in range(20):
        most = [pick.choice([0, 1, 2, 5, 9]), *(pick.choice([0, 1, 3]) for _ in range(6))]
        some = {tuple(pick.randint(0, n) for n in most) for _ in range(pick.randint(1, 12))}
        every = {(n, *row[1:]) for row in some for n in range(row[0])} if pick.random() < 0.5 else set()  # of x
        rows = sorted(some | every)
        terms = tuple(Monomial(i, 1.0, 0.0, unit) for i in range(len(rows)))
        known = np.full((len(rows), 1), Rounded(pick.randint(0, 30)), dtype=object)
        batch = Batch(known, known, max(x.often for x in known.ravel()))
        factor = Factor(WaveFamily(terms, variables, tuple(rows)), batch)
        x, waves = np.array([Rounded(3)], dtype=object), [np.array([Rounded(0)], dtype=object)] * 6
        [value] = factor.at(Points(x, waves), known)
        assert value.often <= factor.roundings


@pytest.mark.parametrize("degree", [5, 14])
def test_no_coefficient_is_rounded_more_often_than_is_counted_however_often_it_is_halved(degree: int) -> None:
    found = np.full((degree + 1, 1), Rounded(0), dtype=object)
    found = np.einsum("ji,ib->jb", np.full((degree + 1, degree + 1), Rounded(1), dtype=object), found)
    for _ in range(wavezeros._MOST_HALVINGS):
        weights = np.full((degree + 1, degree + 1), Rounded(0), dtype=object)
        found = np.einsum("ji,ib->jb", weights, found)
    counted: list[int] = []
    stub: Any = SimpleNamespace(
        values=lambda x: np.zeros_like(x), error=lambda *_: np.zeros(1), sizes=lambda x: np.zeros_like(x)
    )

    def counts(_: Any, often: int) -> Any:
        counted.append(often)
        return np.zeros(1)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wavezeros, "error", counts)
        ends = np.array([0.25]), np.array([0.5])
        _interpolated(stub, (np.array([0]), *ends), np.ones(1), (np.zeros(1), np.zeros(1)), degree)
    [often] = counted
    assert max(x.often for x in found.ravel()) <= often <= 2 * max(x.often for x in found.ravel())


@pytest.mark.parametrize("orders", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("wave", [False, True])
@pytest.mark.parametrize("lines", [0, 2])
def test_a_product_is_a_polynomial_where_neither_a_wave_nor_a_power_is_in_any_factor(
    *, lines: int, wave: bool, orders: tuple[int, ...]
) -> None:
    if lines or wave or orders:
        function = placed(Random(1), 3, lines, wave=wave, orders=orders).function
        assert function.is_polynomial is (not wave and not orders)
        line = placed(Random(2), 3, 1, wave=False).function
        assert (line - function).is_polynomial is (function - line).is_polynomial is function.is_polynomial


@pytest.mark.parametrize(
    ("lines", "wave", "orders", "low"),
    [
        (1, True, (), 0.0),
        (2, True, (), 0.03125),
        (2, False, (1,), 0.0),
        (1, True, (0,), 0.0),
        (1, True, (1,), 0.25),
        (0, False, (0, 1), 0.0),
    ],
)
def test_zeros_that_were_placed_are_found_each_alone(
    lines: int,
    wave: bool,  # noqa: FBT001
    orders: tuple[int, ...],
    low: float,
) -> None:
    """Also where a power makes x = 0 a place at which no polynomial comes near to the function."""
    with mpmath.workdps(40):
        share = _hold(placed(Random(f"{lines} {orders} {low}"), 60, lines, wave=wave, orders=orders), low)
    assert share > 0.9 or (share == 0 and len(orders) > 1)  # two powers at once are left open at 0


@pytest.mark.parametrize("cuts", [0, 1, 3])
def test_however_few_cuts_there_are_nothing_decided_is_wrong(cuts: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wavezeros, "_MOST_CUTS", cuts)
    monkeypatch.setattr(wavezeros, "_MOST_CUTS_AT_0", 1 + cuts)
    with mpmath.workdps(40):
        assert _hold(placed(Random(cuts), 40, 2, wave=True, orders=(1,)), 0.0) < 0.95


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_zeros_that_were_placed_are_found_each_alone_in_many_functions(seed: int) -> None:
    """Two powers at once are left open at 0, and nowhere else."""
    pick = Random(seed)
    with mpmath.workdps(40):
        for _ in range(6):
            wave, orders = pick.choice([(True, ()), (False, (0,)), (True, (1,)), (False, (0, 1))])
            low = pick.choice([0.0, 0.0, 2.0**-10, 0.125])
            shares = _hold(placed(pick, 200, pick.randint(0, 2), wave=wave, orders=orders), low)
            assert shares > 0.9 or (low == 0 and len(orders) > 1 and shares == 0)


@pytest.mark.parametrize("degree", [5, 14])
def test_a_function_and_its_slope_lie_about_its_polynomial_within_what_is_said(degree: int) -> None:
    """Of random products on random segments; and little more than that is said."""
    pick = Random(degree)
    given = placed(pick, 8, 2, wave=True, orders=(1,))
    f = given.function
    low = np.array([pick.uniform(0.1, 0.8) for _ in range(f.sets)])
    high = low * np.array([1 + pick.choice([0.02, 0.1, 0.2]) for _ in range(f.sets)])
    sizes = f.sizes(high)
    ends, curves = _interpolated(f, (np.arange(f.sets), low, high), sizes, f.left_out(low, high, degree), degree)
    value, slope = curves.left_out
    for i in range(f.sets):
        b, a, width = curves.coefficients[:, i], mpmath.mpf(low[i]), mpmath.mpf(high[i]) - mpmath.mpf(low[i])
        off, turned = mpmath.mpf(0), mpmath.mpf(0)
        for t in (mpmath.mpf(n) / 16 for n in range(1, 16)):
            x = a + t * width
            with mpmath.workdps(40):
                p = _bernstein(b, t)
                rate = degree * _bernstein(np.diff(b), t)
                off = max(off, abs(given.exact[i](x) - p))
                turned = max(turned, abs(mpmath.diff(given.exact[i], x) * width - rate))
        assert off <= value[i] + curves.wrong[i]
        assert turned <= degree * (slope[i] + 2 * curves.wrong[i])
        assert value[i] <= 1e6 * off + 1e-12 * sizes[i]
        assert slope[i] <= 1e6 * turned + 1e-11 * sizes[i]
        assert curves.wrong[i] <= 1e-9 * sizes[i]
        for end, x in zip(ends[:, i], (a, a + width), strict=True):
            assert end in (0, mpmath.sign(given.exact[i](x)))


def _bernstein(b: Any, t: mpmath.mpf) -> mpmath.mpf:
    n = len(b) - 1
    return mpmath.fsum(mpmath.mpf(float(x)) * comb(n, k) * t**k * (1 - t) ** (n - k) for k, x in enumerate(b))


def test_what_is_told_of_polynomials_holds_for_all_that_they_may_stand_for() -> None:
    """No zero, however they are moved by what they leave out; and one, a simple one, however they are bent by it."""
    pick, degree, sets = np.random.default_rng(3), 5, 4000
    b = np.sort(pick.uniform(-1, 1, (degree + 1, sets)), axis=0) * pick.choice([-1, 1], sets) + pick.uniform(
        -1, 1, sets
    )
    b[:, ::7] = pick.uniform(-1, 1, (degree + 1, len(b[0, ::7])))
    wrong, value, slope = (10.0 ** pick.uniform(-4, -0.3, sets) for _ in range(3))
    curves = Curves(b, wrong, (value, slope))
    ends = curves.ends()
    none, one = curves.judged(ends)
    t = np.linspace(0, 1, 101)[:, None]
    p = sum(comb(degree, k) * t**k * (1 - t) ** (degree - k) * b[k][:, None].T for k in range(degree + 1))
    rate = sum(comb(4, k) * t**k * (1 - t) ** (4 - k) * np.diff(b, axis=0)[k][:, None].T for k in range(degree))
    moved, bent = wrong + value, 2 * wrong + slope
    assert (ends == np.where(np.abs(b[[0, -1]]) > moved, np.sign(b[[0, -1]]), 0)).all()
    keeps = (np.abs(p).min(axis=0) > moved) & (np.sign(p).min(axis=0) == np.sign(p).max(axis=0))
    rises = (np.abs(rate).min(axis=0) > bent) & (np.sign(rate).min(axis=0) == np.sign(rate).max(axis=0))
    known, opposite = (ends != 0).all(axis=0), ends[0] != ends[1]
    assert (keeps | (rises & known & ~opposite))[none].all()
    assert (rises & known & opposite)[one].all()
    # and all is told that the coefficients by themselves show, with a little to spare
    assert none[(b > 1.01 * moved).all(axis=0) | (b < -1.01 * moved).all(axis=0)].all()
    steps = np.diff(b, axis=0)
    plain = (steps > 1.01 * bent).all(axis=0) | (steps < -1.01 * bent).all(axis=0)
    assert (none | one)[plain & known].all()
    assert min(none.sum(), one.sum()) > 100
    halved = curves.of(np.arange(50)).halves()
    for side, start in ((slice(50), 0.0), (slice(50, 100), 0.5)):
        at = (start + np.linspace(0, 1, 7) / 2)[:, None]
        whole = sum(comb(degree, k) * at**k * (1 - at) ** (degree - k) * b[k, :50] for k in range(degree + 1))
        u = np.linspace(0, 1, 7)[:, None]
        part = sum(
            comb(degree, k) * u**k * (1 - u) ** (degree - k) * halved.coefficients[k, side] for k in range(degree + 1)
        )
        assert np.abs(whole - part).max() < 1e-14
        assert (halved.left_out[0][side] == value[:50]).all()
        assert (halved.left_out[1][side] == slope[:50] / 2).all()  # of a function on half the way


# Bounds, as they are proven


@pytest.mark.parametrize("degree", [2, 5, 14])
@pytest.mark.parametrize("ratio", [2.0, 3.0, 17.5])
def test_what_interpolation_leaves_out_is_the_tail_of_a_series(degree: int, ratio: float) -> None:
    """The sum of 4 M r^-k over all k > n, and for the slope of k^2 times that, here of the least bound of it that is used."""
    value, slope = left_out(np.array([0.7]), np.array([ratio]), degree)
    tail = [mpmath.nsum(lambda k, p=p: 4 * mpmath.mpf(0.7) * k**p * mpmath.mpf(ratio) ** -k, [degree + 1, mpmath.inf]) for p in (0, 2)]  # fmt: skip
    assert tail[0] <= value[0] <= 1.002 * tail[0]
    first = 4 * mpmath.mpf(0.7) * (degree + 1) ** 2 * mpmath.mpf(ratio) ** -(degree + 1)
    geometric = first / (1 - (1 + mpmath.mpf(1) / (degree + 1)) ** 2 / ratio)
    assert tail[1] <= slope[0]
    assert geometric <= slope[0] <= 1.002 * geometric


@pytest.mark.parametrize("seed", range(3))
def test_errors_are_counted_in_units_by_the_rules_of_the_proof(seed: int) -> None:
    """n max(2, k x) + 12 for each degree in a wave, 12 alpha |log x| + 20 for one in a power, and what its own operations make."""
    pick = Random(seed)
    for _ in range(12):
        sets, rates, orders = 5, [pick.randint(0, 3) for _ in range(pick.randint(0, 2))], ORDERS[: pick.randint(0, 2)]
        variables = Variables(tuple(Monomial(0, 1.0, 0.0, (n, 0)) for n in rates), orders)
        sides: list[list[Factor]] = []
        for _ in range(pick.randint(1, 2)):
            sides.append([])
            for _ in range(pick.randint(1, 2)):
                rows = [tuple(pick.randint(0, 2) for _ in range(1 + variables.waves)) for _ in range(3)]
                family = WaveFamily(tuple(Monomial(i, 1.0, 0.0, (0, 0)) for i in range(3)), variables, tuple(rows))
                ones = np.ones((3, sets))
                sides[-1].append(Factor(family, Batch(ones, ones, pick.randint(0, 9))))
        turns = np.array([[10 ** pick.uniform(-1, 2) for _ in range(sets)] for _ in rates]).reshape(-1, sets)
        f = WaveFunction(variables, turns, *map(tuple, sides))
        low = np.array([10 ** pick.uniform(-4, -1) for _ in range(sets)])
        high, sizes = low * 3, np.array([10 ** pick.uniform(-3, 3) for _ in range(sets)])
        for own_powers in (False, True):
            found = f.error(sizes, low, high, own_powers=own_powers)
            for i in range(sets):
                units = 1 + max(sum(x.rows.roundings + x.family.roundings + 3 * x.family.degrees[0] + 1 for x in side) for side in sides)  # fmt: skip
                for n, rate in enumerate(rates):
                    degree = max(sum(x.family.degrees[1 + n] for x in side) for side in sides)
                    units += degree * ((rate + 6) * max(2.0, turns[n][i] * high[i]) + 12)
                for n, alpha in enumerate(orders):
                    degree = max(sum(x.family.degrees[1 + len(rates) + n] for x in side) for side in sides)
                    units += degree * ((0 if own_powers else 12 * alpha * abs(np.log(low[i]))) + 20)
                assert found[i] == pytest.approx(sizes[i] * units * 2.0**-53 * 1.001, rel=1e-12)
        assert (f.error(np.zeros(sets), low, high) == TINY).all()
        far = np.full(sets, 1.0001e4) if rates else high
        if rates:
            one = replace(f, rates=np.ones((len(rates), sets)))
            assert np.isinf(one.error(sizes, far, far)).all()
            assert np.isfinite(one.error(sizes, 0.99 * far, 0.99 * far)).all()
