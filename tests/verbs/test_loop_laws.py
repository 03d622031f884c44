"""Loops with an open number, piece by piece: tables, zeros, curves, chains from infinity and pairs, against mpmath, NumPy and dense samples."""

from __future__ import annotations

import cmath
import random
from dataclasses import replace
from itertools import islice, pairwise
from random import Random
from types import SimpleNamespace
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp, lambdify, pi, sympify
from windings import winding

from haptisym.kernel.alike import ordered
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.symbols import omega, s
from haptisym.model.parameters import Rule
from haptisym.verbs.require import freeparameter
from haptisym.verbs.stability import critical, search
from haptisym.verbs.stability.boundary import _eliminated, _near, meetings
from haptisym.verbs.stability.curves import Gap, Meeting, _is_apart, minus
from haptisym.verbs.stability.farout import from_infinity, is_neutral
from haptisym.verbs.stability.loops import ALLOWED, Loop, coefficients, zeros
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.reach import lag_of, reach_of_axis
from haptisym.verbs.stability.search import _Cells
from haptisym.verbs.stability.switches import Switches

SEEDS = range(30)
q = Symbol("q", positive=True)
MP = mpmath.mp.clone()
MP.dps = 40


def loop_of(expression: Expr, low: Expr | None = Integer(0), below: Expr = Integer(1)) -> Loop:  # noqa: B008  exact and constant
    ring = Ring.of([expression, below])
    return Loop(ring, ring.convert(expression).numerator, ring.convert(below).numerator, q, low)


def some(draw: random.Random, most: int = 9) -> Rational:
    return Rational(draw.choice([-1, 1]) * draw.randint(1, most), draw.choice([1, 2, 3]))


def drawn(draw: random.Random, lags: list[Expr], *, degree: int = 2, power: int = 1) -> Expr:
    """A sum of powers of s and of q, each perhaps late."""
    found: Expr = Integer(0)
    for n in range(degree + 1):
        for lag in lags:
            if draw.random() < 0.8:
                found += some(draw) * s**n * q ** draw.randint(0, power) * exp(-s * lag)
    return found + some(draw) * s**degree * q + some(draw)


def test_a_number_may_be_what_its_rule_allows_and_its_ends_where_they_belong_to_it() -> None:
    """The tables of values that are walked through, and of those that are asked about, against the rules one by one."""
    little = Rational(1, 10**9)
    for table in (ALLOWED, freeparameter._ALLOWED):
        assert set(table) == {Rule.POSITIVE, Rule.NONNEGATIVE, Rule.ANY, Rule.FRACTION}
        for rule, (low, high, closed) in table.items():
            for end, side in ((low, -1), (high, 1)):
                far = Rational(side * 10**9)
                assert rule.allows(far) == (end is None)
                if end is not None:
                    told = [rule.allows(x) for x in (end + side * little, end, end - side * little)]
                    assert told == [False, closed, True]


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_table_is_the_function_and_its_powers_are_too(seed: int) -> None:
    draw = random.Random(seed)
    lags = draw.choice([[Integer(0)], [Integer(0), Rational(1, 3)], [Integer(0), Rational(1, 2), pi / 5]])
    expression = drawn(draw, lags, power=draw.randint(0, 3))
    own = loop_of(expression)
    total = sum(
        (
            sum((c * q**i for i, c in enumerate(row)), Integer(0)) * s**p * exp(-s * lag_of(turns, own))
            for p, group in own.table.items()
            for turns, row in group.items()
        ),
        Integer(0),
    )
    powers = sum((own.ring.expression(p) * q**i for i, p in enumerate(own.powers)), Integer(0))
    for at, value in ((Rational(2, 7), Rational(3)), (Rational(-5, 3), Rational(1, 4))):
        known = {s: at, q: value}
        true = expression.subs(known).evalf(30) * own.ring.expression(own.top).subs(known).evalf(30)
        scale = own.ring.expression(own.top).subs(known).evalf(30)
        for found in (total, powers):
            assert abs(found.subs(known).evalf(30) - scale) <= abs(scale) * Rational(1, 10**20)
        assert abs(true) >= 0
    degree = max((i for i, p in enumerate(own.powers) if p), default=0)
    assert len(own.powers) == degree + 1
    assert coefficients(own.top, None) == [own.top]


@pytest.mark.parametrize("group", range(3))
def test_zeros_of_a_row_are_those_of_numpy_that_are_not_negative(group: int) -> None:
    for seed in range(12 * group, 12 * group + 12):
        draw = random.Random(seed)
        roots = [Rational(draw.randint(-6, 6), draw.choice([1, 2])) for _ in range(draw.randint(0, 4))]
        row: list[Expr] = [some(draw)]
        if seed % 3 == 0:  # far out
            roots = [x * 1000 for x in roots]
        if seed % 4 == 0:
            row = [row[0] * draw.choice([pi, 1]), Integer(0), row[0]]  # times 1 + x^2, or pi + x^2
        for x in roots:
            row = [a - x * b for a, b in zip([Integer(0), *row], [*row, Integer(0)], strict=True)]
        row = [c.expand() for c in row] + [Integer(0)] * draw.randint(0, 2)
        length = max(i for i, c in enumerate(row) if c != 0) + 1
        found = zeros(row)
        if length == 2:
            assert found == [ExactNumber(roots[0])]
        elif length < 2:
            assert found == []
        else:
            assert [float(x) for x in found] == pytest.approx(sorted({float(x) for x in roots if x >= 0}), abs=1e-12)
    assert zeros([]) == zeros([Integer(0), Integer(0)]) == zeros([Integer(3)]) == []


@pytest.mark.parametrize("seed", range(3))
def test_zeros_are_found_as_far_out_as_coefficients_of_one_size_put_them(seed: int) -> None:
    """x^2 - x - 1 has one beyond all of its coefficients."""
    draw = random.Random(seed)
    for row in [
        [-1, -1, 1],
        *([draw.choice([-1, 0, 1]) for _ in range(draw.randint(2, 5))] + [draw.choice([-1, 1])] for _ in range(12)),
    ]:
        true = [x.real for x in np.roots(row[::-1]) if abs(x.imag) < 1e-6 and x.real > -1e-6]
        if len(row) > 2 and all(abs(x - y) > 1e-3 for x, y in pairwise(sorted(true))):
            assert [float(x) for x in zeros([*map(Integer, row)])] == pytest.approx(sorted(true), abs=1e-9)


@pytest.mark.few(11)
@pytest.mark.parametrize("seed", range(6))
def test_numbers_are_in_order_and_gaps_hold_what_is_between_their_ends(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(30):
        ends = [None if draw.random() < 0.2 else draw.randint(-3, 3) for _ in range(4)]
        a, b, c, d = (None if x is None else ExactNumber(Integer(x)) for x in ends)
        if a is not None and c is not None:
            assert ordered(a, c) == (ends[2] > ends[0]) - (ends[2] < ends[0])  # type: ignore[operator]
        low = ends[0] is None or (ends[2] is not None and ends[2] >= ends[0])
        high = ends[1] is None or (ends[3] is not None and ends[3] <= ends[1])
        assert Gap(a, b).holds(c, d) is (low and high)
    near = ExactNumber(Rational(1, 3)), ExactNumber(Rational(1, 3) + Rational(1, 2**400))
    assert (ordered(*near), ordered(*near[::-1]), ordered(near[0], near[0])) == (1, -1, 0)


@pytest.mark.parametrize("seed", range(4))
def test_a_function_less_a_number_is_that(seed: int) -> None:
    draw = random.Random(seed)
    axis = Ring.of([q]).axis
    f = (omega**2 * some(draw) + q) / (omega + draw.randint(1, 4))
    for number in (some(draw), pi * some(draw), Integer(0)):
        assert (minus(axis.convert(f), number).expression() - (f - number)).together().expand() == 0


@pytest.mark.parametrize("group", range(3))
def test_polynomials_are_apart_where_they_share_no_positive_zero(group: int) -> None:
    for seed in range(8 * group, 8 * group + 8):
        draw = random.Random(seed)
        axis = Ring.of([q]).axis
        roots = [[draw.choice([-5, -3, -1, 0, 1, 2, 7, 900]) for _ in range(draw.randint(1, 3))] for _ in range(2)]
        both = [
            axis.convert((some(draw) * np.prod([omega - x for x in each], initial=Integer(1))).expand()).numerator
            for each in roots
        ]
        shared = set(roots[0]) & set(roots[1])
        assert _is_apart(both[0], both[1], axis) is not any(x > 0 for x in shared)
    late = Ring.of([exp(-s)]).axis
    t = late.context.gens()[late.size]  # the tangent of half an angle, 0 again and again
    assert not _is_apart(t * (t + 2), t * (t**2 + 3), late)
    assert _is_apart(t**2 + 2, t, late)


# Values that come from infinity: L(z; q) has as many zeros inside of the unit circle, and on it, between two of them


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(40))
def test_a_chain_comes_or_goes_at_values_from_infinity_alone(seed: int) -> None:
    """The zeros of L(z; q), one delay, or two that nothing joins, inside of |z| < 1."""
    draw = random.Random(seed)
    two = seed % 4 == 3
    lags = [Integer(0), Rational(1, 2), Integer(1)] if not two else [Integer(0), Integer(1), pi]
    rows = [[Integer(draw.randint(-4, 4)) for _ in range(draw.choice([1, 2, 2]))] for _ in lags]
    if seed % 5 == 4:  # the same zeros for all q
        rows = [[x * draw.randint(1, 3), 2 * x * draw.randint(1, 1)] for x in map(Integer, (3, 1, -2))][: len(lags)]
    leading = sum(
        (
            sum((c * q**i for i, c in enumerate(row)), Integer(0)) * exp(-s * lag)
            for row, lag in zip(rows, lags, strict=True)
        ),
        Integer(0),
    )
    if leading.expand() == 0:
        return
    own = loop_of(s**2 * leading + s + 3 + q)
    assert is_neutral(own) is any(c != 0 for row in rows[1:] for c in row)
    try:
        found = sorted(float(x.value) for x in from_infinity(own) if float(x.value) >= 0)
    except UndecidedError:
        return
    assert all(x.omega is None for x in from_infinity(own))
    last = None
    for a in np.linspace(0.013, 7.97, 120):
        c = [sum(float(x) * a**i for i, x in enumerate(row)) for row in rows]
        if two:  # phases that are independent: |c0| > |c1| + |c2|
            margin = abs(c[0]) - abs(c[1]) - abs(c[2])
            kind, near = margin > 0, abs(margin)
        else:
            sizes = abs(np.roots(c[::-1]))
            kind, near = int((sizes < 1).sum()), abs(sizes - 1).min(initial=9)
        if near < 1e-9:
            continue
        if last is not None and last[1] != kind:
            assert any(last[0] - 1e-9 <= x <= a + 1e-9 for x in found), (last, a, kind, found)
        last = a, kind


# Pairs


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_values_and_slopes_of_a_characteristic_function_are_those_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    lags = draw.choice([[Integer(0), q], [Integer(0), q / 3, pi * q + 1], [Integer(0), Rational(1, 2), q]])
    expression = drawn(draw, lags, power=2) * (s if seed % 3 == 0 else 1)
    if seed % 2:
        expression += some(draw) * s ** Rational(1, 2) * (s if seed % 3 == 0 else 1)
    form = Characteristic(loop_of(expression.expand()))
    shared = form.shared
    assert shared == (seed % 3 == 0)
    f = lambdify((s, q), form.loop.ring.expression(form.loop.top) / s**shared, MP)
    for _ in range(3):
        w, x = MP.mpf(draw.randint(1, 40)) / 8, MP.mpf(draw.randint(1, 40)) / 16

        def at(a: Any, b: Any) -> Any:
            return f(MP.mpc(0, a), b)

        with flint.ctx.workprec(128):
            found = form.value(arb(str(w)), arb(str(x)))
        true = at(w, x), MP.diff(lambda a, x=x, at=at: at(a, x), w), MP.diff(lambda b, w=w, at=at: at(w, b), x)
        for mine, theirs in zip(found, true, strict=True):
            assert complex(mine) == pytest.approx(complex(theirs), rel=1e-12, abs=1e-12)


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_one_pair_in_a_box_is_told_to_any_digits_and_none_where_there_is_none(seed: int) -> None:
    """C = A (s^2 + w^2) + B (q - v) is 0 at s = j w, q = v."""
    draw = random.Random(seed)
    w, v = Rational(draw.randint(1, 20), 4), Rational(draw.randint(1, 20), 8)
    A, B = s + draw.randint(1, 5) + exp(-s / 2), draw.randint(1, 4) * s + 2 + exp(-s * q)
    form = Characteristic(loop_of(((s**2 + w**2) * A + (q - v) * B).expand()))
    size = 2.0**-15
    off = draw.uniform(-0.3, 0.3) * size
    pair = form.only(arb(float(w) + off, size), arb(float(v) - off, size))
    assert pair is not None
    for bits in (64, 500, 200, 900):
        at = pair.at(bits)
        assert pair.at(bits) is at
        for ball, true in zip(at, (w, v), strict=True):
            assert ball.contains(arb(int(true.p)) / int(true.q))
            assert ball.rel_accuracy_bits() >= bits - 30
    assert pair.frequency.digits(60) == ExactNumber(w).digits(60)
    assert pair.value.digits(60) == ExactNumber(v).digits(60)
    assert form.only(arb(float(w) + 4 * size, size), arb(float(v), size)) is None
    assert form.only(arb(float(w), size), arb(float(v) + 4 * size, size)) is None
    assert form.step(arb(0, 1), arb(float(v), size)) is None
    assert form.only(arb(float(w), 50), arb(float(v), 50)) is None


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(20))
def test_roots_through_0_are_at_values_where_the_first_term_of_the_expansion_is_lost(seed: int) -> None:
    """C/s^n at 0, n being the order there; the expansion by SymPy."""
    draw = random.Random(seed)
    order = seed % 3
    first = (q - 2) * (q + 3) * (q if seed % 2 else 1)
    late = 1 - exp(-s * Rational(draw.randint(1, 4), 3))
    expression = (s**2 + some(draw) * s**3 + first * (2 - exp(-s * pi))) * late**order
    form = Characteristic(loop_of(expression.expand()))
    found = sorted({round(float(x), 9) for x in form.at_0()})
    assert found == ([-3, 0, 2] if seed % 2 else [-3, 2])
    if order == 0:  # of C itself: clear where it keeps its real part
        for low, high, clear in ((3, 4, True), (1.5, 2.5, False)):
            assert form.is_clear_at_0(arb(0).union(arb(2) ** -6), arb(low).union(arb(high))) is clear
    broken = Characteristic(loop_of((expression + s ** Rational(1, 2) * 7 * late**order).expand()))
    assert broken.is_clear_at_0(arb(0).union(arb(2) ** -6), arb(3).union(arb(4))) is False


@pytest.mark.few(5)
@pytest.mark.parametrize("seed", SEEDS)
def test_beside_0_boxes_called_clear_hold_no_pair(seed: int) -> None:
    draw = random.Random(seed)
    expression = drawn(draw, [Integer(0), q, Rational(1, 3)], power=2)
    if seed % 2:
        expression = expression - expression.subs(s, 0) * exp(-s)
    form = Characteristic(loop_of(expression.expand()))
    f = lambdify((s, q), expression, "numpy")
    low = draw.uniform(0.1, 4)
    for reach, width in ((0.01, 0.01), (0.2, 0.05), (1, 0.3)):
        if not form.is_clear_at_0(arb(0).union(arb(reach)), arb(low).union(arb(low + width))):
            continue
        grid = np.linspace(reach / 400, reach, 400)
        for x in np.linspace(low, low + width, 9):
            assert abs(f(1j * grid, x)).min() > 0
            real = f(1j * grid, x) / (1j * grid) ** (seed % 2)
            assert (real.real > 0).all() or (real.real < 0).all() or (abs(real.imag) > 0).all()


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_derivative_beside_0_is_that_of_mpmath(seed: int) -> None:
    draw = random.Random(seed)
    expression = drawn(draw, [Integer(0), q, Rational(1, 3)], degree=3, power=2)
    form = Characteristic(loop_of(expression.expand()))
    f = lambdify((s, q), form.loop.ring.expression(form.loop.top), MP)
    w, x = MP.mpf(draw.randint(1, 40)) / 8, MP.mpf(draw.randint(1, 40)) / 16
    for n in range(4):
        true = MP.diff(lambda z, x=x: f(z, x), MP.mpc(0, w), n)
        with flint.ctx.workprec(128):
            assert complex(form._derivative(n, arb(str(w)), arb(str(x)))) == pytest.approx(
                complex(true), rel=1e-9, abs=1e-9
            )


# How far out roots may meet the axis


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_beyond_its_reach_nothing_is_0_on_the_axis_for_any_value_or_its_inverse(seed: int) -> None:
    draw = random.Random(seed)
    lags = [Integer(0), Rational(1, 2), Integer(1)] if seed % 2 else [Integer(0), Rational(1, 2), pi / 4]
    lead = (
        9 * s**2 * (1 + q)
        + draw.choice([-2, 3]) * s**2 * q * exp(-s * lags[1])
        + draw.choice([-2, 3]) * s**2 * exp(-s * lags[2])
    )
    expression = lead + s * drawn(draw, lags, degree=0) + drawn(draw, lags, degree=0)
    own = loop_of(expression.expand())
    f = lambdify((s, q), own.ring.expression(own.top), "numpy")
    known = reach_of_axis(own)
    for low, high, inverse in ((0.5, 0.7, False), (2.0, 2.1, False), (0.0, 0.1, True)):
        found = known.radius(arb(low).union(arb(high)), 100_000, inverse=inverse)
        assert found is not None
        for u in np.linspace(low, high, 5):
            if inverse and not u:
                continue
            x = 1 / u if inverse else u
            w = float(found) * np.concatenate([1 + np.linspace(0, 3, 2000), np.geomspace(4, 1e4, 200)])
            assert abs(f(1j * w, x) / w**2).min() > 0.0
            here = w[:1]
            lower = sum(
                abs(sum(float(c) * x**i for i, c in enumerate(row))) * here ** float(p)
                for p, group in own.table.items() if p < 2 for row in group.values()
            )  # fmt: skip
            assert (abs(np.array([9 * (1 + x)])) - 3 * x - 3 <= 0) or (
                lower < (9 * (1 + x) + 3 * x + 3) * here**2
            ).all()
    assert known.radius(arb(0.5).union(arb(0.7)), 1, inverse=False) is None or own.table is not None


def winds(f: Any, x: float, reach: float) -> int | None:
    return winding(lambda z: f(z, x), reach)


# Where a search looks for pairs


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(12))
def test_a_cell_is_told_where_the_pair_in_it_would_be_if_it_were_straight(seed: int) -> None:
    """C = A (s^2 + w^2) + B (q - v) over ever smaller cells about (w, v), off their middles."""
    draw = random.Random(seed)
    w, v = Rational(draw.randint(4, 20), 4), Rational(draw.randint(4, 20), 8)
    A, B = 3 * s**2 + s + draw.randint(1, 5) + exp(-s / 2), draw.randint(1, 4) * s + 2 + exp(-s * q)
    form = Characteristic(loop_of(((s**2 + w**2) * A + (q - v) * B).expand()))
    cells = _Cells(form, v - Rational(1, 3), v + Rational(1, 2))
    reach = cells.axis.reach
    assert reach is not None
    assert reach > w
    place = np.array([float(w) / reach, float((v - cells.low) / (cells.high - cells.low))])
    off = np.array([draw.uniform(-0.9, 0.9), draw.uniform(-0.9, 0.9)])
    for size in (2.0**-9, 2.0**-12, 2.0**-15, 2.0**-18):
        cell = np.stack([place - size * (1 + off), place + size * (1 - off)], -1)[None]
        told = [*cells._likely(cell)]
        assert [i for i, _ in told] == [0] or size > 2.0**-18
        assert all(t == pytest.approx(off, abs=0.1) for _, t in told)
    cells._prove(cell)
    [found] = cells.found
    assert (found.value.digits(20), found.omega and found.omega.digits(20)) == (
        ExactNumber(v).digits(20),
        ExactNumber(w).digits(20),
    )
    assert cells._is_settled(cell).all()
    assert not cells._is_settled(cell + 20 * size).any()
    cells._prove(cell)
    assert len(cells.found) == 1


@pytest.mark.parametrize("seed", range(4))
def test_however_few_cells_are_looked_at_a_pair_is_found_once_or_lies_in_a_gap(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """-A/B is real at pairs of frequency and value that a dense grid shows; what is found and what is left are all of them."""
    draw = random.Random(seed)
    lag = Rational(draw.randint(1, 9), 8)
    A, B = s**2 + draw.randint(0, 3) * s + draw.randint(1, 30), draw.choice([1, 2 + s]) * exp(-s * lag)
    own, ratio = loop_of(A + q * B), lambdify(s, -A / B, "numpy")
    low, high = Rational(draw.randint(-5, 5)), Rational(draw.randint(8, 20), 1)
    w = np.linspace(1e-3, 60, 400_001)
    g = ratio(1j * w)
    at = np.flatnonzero((g.imag[1:] * g.imag[:-1] < 0) & (g.real[1:] > float(low) + 1e-3) & (g.real[1:] < float(high) - 1e-3))  # fmt: skip
    true = sorted((float(g.real[i]), float(w[i])) for i in at)
    for most in (0, 70, 150, 300, 10**5):
        monkeypatch.setattr(search, "_MOST_CELLS", most)
        cells = _Cells(Characteristic(own), low, high)
        gaps = [tuple(map(float, search._ends(x))) for x in search._joined(cells.settle())]
        found = sorted((float(x.value), float(x.omega)) for x in cells.found if x.omega is not None)
        assert all(low <= a < b <= high for a, b in gaps)
        assert most or gaps == [(float(low), float(high))]
        assert most < 10**5 or not gaps
        for x in found:
            assert sum(x == pytest.approx(y, abs=2e-3, rel=1e-3) for y in true) <= 1
            assert abs(ratio(1j * x[1]) - x[0]) < 1e-9 * (1 + abs(x[0]))
        for y in true:
            times = sum(x == pytest.approx(y, abs=2e-3, rel=1e-3) for x in found)
            assert times == 1 or (times == 0 and any(a - 2e-3 <= y[0] <= b + 2e-3 for a, b in gaps)), (most, y)


@pytest.mark.parametrize(
    ("low", "high"), [(None, None), (Integer(0), None), (Integer(0), Integer(20)), (None, Integer(7))]
)
@pytest.mark.parametrize("stops", [(None, None), (3, None), (None, 2), (1, 1), (2, 4)])
def test_windows_of_a_search_are_tiled_by_strips_and_end_at_what_is_allowed_or_at_a_gap(
    low: Expr | None, high: Expr | None, stops: tuple[int | None, int | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """On either side up to a gap at the end of a window, at the j-th of them; what no search went to is one more gap."""
    own = replace(loop_of(s**2 + s + 9 + q * exp(-s / 2), low), high=high)
    strips: list[tuple[Expr, Expr]] = []
    ends: list[list[Expr]] = [[], []]

    def in_strip(_: Any, a: Expr, b: Expr) -> tuple[list[Meeting], list[Gap]]:
        strips.append((a, b))
        gaps = []
        for side, x in enumerate((a, b)):
            if x not in (ends[1 - side] or [None])[-1:] and (side == 0) == (x < 5):
                ends[side].append(x)
                if len(ends[side]) == stops[side]:
                    gaps.append(search._gap(*sorted((x, x + (b - a) / 9 * (1 - 2 * side))), "why"))
        return [Meeting(ExactNumber((a + b) / 2), ExactNumber(Integer(1)))], gaps

    monkeypatch.setattr(search, "_in_strip", in_strip)
    *windows, last = search.searched(own, Integer(5), "no reach")
    assert 1 <= len(windows) <= 7
    assert (last.above, last.below) == (low, high)
    first, final = windows[0], windows[-1]
    assert strips[0] == (first.above, first.below)
    pieces = sorted(strips)
    assert all(a[1] == b[0] for a, b in pairwise(pieces))
    assert (pieces[0][0], pieces[-1][1]) == (final.above, final.below)
    for x, y in pairwise(windows):
        assert x.above is not None
        assert x.below is not None
        assert y.above is not None
        assert y.below is not None
        assert y.above <= x.above < 5 < x.below <= y.below
        assert x.found == y.found[: len(x.found)]
    assert last.found[0] == Meeting(ExactNumber(Integer(-9)), ExactNumber(Integer(0)))  # C(0) = 9 + q
    assert len(last.found) == 1 + len(strips)
    why = [tuple(search._ends(x)) for x in last.gaps if x.reason == "why"]
    assert len(why) == sum(n is not None and n <= len(x) for n, x in zip(stops, ends, strict=True))
    for side, (n, bound, end) in enumerate(zip(stops, (low, high), (final.above, final.below), strict=True)):
        if n is None:
            assert end == bound if bound is not None else len(ends[side]) == 7
        else:
            assert ends[side][-1] == end
            assert len(ends[side]) == n
        beyond = [x for x in last.gaps if x.reason == search._BEYOND and (x.high if side == 0 else x.low) == ExactNumber(end)]  # fmt: skip
        assert len(beyond) == (end != bound)
        for x in beyond:
            assert (x.low if side == 0 else x.high) == (None if bound is None else ExactNumber(bound))
    assert len(last.gaps) == len(why) + (final.above != low) + (final.below != high)


# All of it: what meets the axis is where winding numbers change


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_winding_numbers_change_at_meetings_alone_whatever_the_number_stands_in(seed: int) -> None:
    draw = random.Random(seed)
    kind = seed % 4
    body = 2 * s**2 + draw.randint(1, 4) * s + draw.randint(2, 9)
    lag = Rational(draw.randint(1, 6), 5)
    if kind == 0:  # in a delay
        expression = body + (draw.randint(1, 9) + draw.choice([0, 1]) * s) * exp(-s * q * draw.choice([1, 2]))
    elif kind == 1:
        expression = body + q * (draw.randint(1, 5) + draw.choice([0, 1]) * s) * exp(-s * lag)
    elif kind == 2:
        expression = (
            (q + draw.randint(1, 3)) * s**2
            + draw.randint(1, 4) * s
            + draw.randint(2, 5)
            + (draw.randint(1, 3) * s**2 + 2) * exp(-s * lag)
        )
    else:
        expression = body + q**2 * s + q * draw.choice([-3, -6]) * s + draw.choice([-1, 2]) * q * exp(-s * lag)
    own, value = loop_of(expression.expand()), Rational(draw.randint(2, 30), 10)
    f = lambdify((s, q), expression, "numpy")
    windows = []
    try:
        for n, window in enumerate(meetings(own, value)):
            windows.append(window)
            if n > 4:
                break
    except UndecidedError:
        pass
    for window in windows:
        low = 0.0 if window.above is None else max(float(window.above), 0.0)
        high = 6.0 if window.below is None else min(float(window.below), 6.0)
        places = sorted(float(x.value) for x in window.found if low < float(x.value) < high)
        for gap in window.gaps:
            a, b = (end if x is None else float(x) for x, end in ((gap.low, low), (gap.high, high)))
            places += [x for x in np.linspace(a, b, 400) if low < x < high]
        for x in window.found:
            if x.omega is not None and 0 < float(x.value) < 50 and float(x.omega) > 0:
                with mpmath.workdps(40):
                    precise = lambdify((s, q), expression, "mpmath")
                    assert abs(precise(mpmath.mpc(0, x.omega.digits(35)), mpmath.mpf(x.value.digits(35)))) < 1e-25
        cells = [(a, b) for a, b in pairwise([low, *sorted(places), high]) if b - a > 1e-3 * (high - low)]
        for a, b in cells[:12]:
            known = own.at(Rational((a + b) / 2))
            if known.chain is None:
                counts = {winds(f, a + (b - a) * t, 80.0) for t in (0.03, 0.5, 0.97)} - {None}
                assert counts <= {known.number}, (a, b, counts, places)


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", SEEDS)
def test_delays_at_which_roots_meet_the_axis_are_all_turns_of_all_frequencies(seed: int) -> None:
    """A + B exp(-s tau): |A| = |B| at frequencies by NumPy, and there tau = (angle(-B/A) + 2 pi n)/(multiple omega)."""
    draw = random.Random(seed)
    a, b = [1, draw.randint(0, 3), draw.randint(1, 30)], [draw.randint(0, 2), draw.randint(1, 40)]
    multiple = draw.choice([Integer(1), Integer(2), Rational(2, 3)])
    expression = sum((x * s**n for n, x in enumerate(a[::-1])), Integer(0)) + sum(
        (x * s**n for n, x in enumerate(b[::-1])), Integer(0)
    ) * exp(-s * multiple * q)
    value = Rational(draw.randint(0, 8), 4)
    known, below = Switches.of(loop_of(expression)).up_to(value)
    A, B = np.poly1d(a), np.poly1d(b)
    even = np.poly1d([1, a[1] ** 2 - 2 * a[2], a[2] ** 2]) - np.poly1d([b[0] ** 2, b[1] ** 2])
    squares = [x.real for x in even.roots if abs(x.imag) < 1e-9 and x.real > 1e-9]
    limit = float(below) if below is not None else 60.0
    true = []
    for w in np.sqrt(squares):
        angle = cmath.phase(-B(1j * w) / A(1j * w))
        true += [((angle + 2 * np.pi * n) / (w * float(multiple)), w) for n in range(-1, 400)]
    inside = sorted(x for x in true if -1e-9 < x[0] < limit - 1e-9)
    mine = sorted((float(x.value), float(x.omega or 0)) for x in known if float(x.value) < limit - 1e-9)
    if below is None:
        assert not squares
        assert not mine
    else:
        assert limit > float(value)
        assert mine == [pytest.approx(x, rel=1e-9, abs=1e-9) for x in inside]


def test_where_both_terms_are_alike_the_delay_is_0_or_of_half_turns_exactly() -> None:
    """s^2 + 2 s + 100 - (2 s + 50) exp(-s tau): at 0 s^2 + 50 is left; held by any small delay. With + it is so at half a turn."""
    A, B = s**2 + 2 * s + 100, 2 * s + 50
    [first, *_] = Switches.of(loop_of(A - B * exp(-s * q))).up_to(Rational(1, 100))[0]
    assert (first.value, first.omega and float(first.omega)) == (ExactNumber(Integer(0)), 50**0.5)
    delays = [x.value for x in Switches.of(loop_of(A + B * exp(-s * q))).up_to(Rational(1, 100))[0]]
    half = [MP.pi * (2 * n + 1) / MP.sqrt(50) for n in range(3)]
    for true in half:
        assert any(abs(MP.mpf(x.digits(30)) - true) < MP.mpf(10) ** -25 for x in delays)
    free: Any = SimpleNamespace(path="tau", value=Rational(1, 100), rule=Rule.NONNEGATIVE)
    told = critical._Walk(loop_of(A - B * exp(-s * q)), free).nearest()
    assert (float(told.found[0].value), told.found[0].below, told.found[0].above, told.reason) == (0, 2, 0, "")
    assert winding(lambda z: z**2 + 2 * z + 100 - (2 * z + 50) * np.exp(-z / 100), 100.0) == 0


OPEN: dict[str, tuple[Expr, Expr | None]] = {
    "a power of s changes": (s**2 + s**q + 1, Integer(0)),
    "a number that may be negative": (s**2 * (q**2 + exp(-s) - 3) + 1, None),
    "many delays meet": (
        s**2 * (9 + q + sum((exp(-s * Rational(1, 97 + n)) for n in range(7)), Integer(0))) + 1,
        Integer(0),
    ),
    "delays meet that are no multiples": (s**2 * (1 + exp(-s * q) + 2 * exp(-s)) + 1, Integer(0)),
    "a number that is in several delays": (s**2 + exp(-s * q) + exp(-s * q * pi) + 3, Integer(0)),
    "a delay that comes back several times": (s**2 + s + exp(-s * q) + exp(-2 * s * q) + 9, Integer(0)),
    "where roots meet the imaginary axis: its delays turn very often": (
        q + s + s**2 / 10**6 + 900 * exp(-s),
        Integer(0),
    ),
}


@pytest.mark.parametrize("reason", OPEN)
def test_what_one_equation_leaves_open_is_left_open_for_its_reason(reason: str) -> None:
    expression, low = OPEN[reason]
    with pytest.raises(UndecidedError, match=reason):
        list(islice(_eliminated(loop_of(expression, low), Integer(1)), 3))


def test_delays_may_turn_so_far_on_the_way_and_no_further() -> None:
    own = loop_of(s + q * exp(-s))
    assert _near(Rational(399), own) == 399
    assert _near(Rational(1, 9), own) == 1
    with pytest.raises(UndecidedError, match="its delays turn very often"):
        _near(Rational(401), own)
    assert _near(Rational(10**6), loop_of(s + q)) == 10**6


def test_the_highest_power_of_s_is_the_one_that_is_so_at_all_values_of_an_order() -> None:
    """Powers that are linear in it, by many values between two; where two of them pass each other it is left open."""
    pick, q, told = Random(29), Symbol("q"), [0, 0]
    for _ in range(120):
        low, high = sorted(pick.sample([Rational(n, 4) for n in range(5)], 2))
        powers = {Rational(pick.randint(0, 4), 4) + pick.choice([0, 1, 2, -1]) * q for _ in range(pick.randint(1, 4))}
        table = {x: object() for x in pick.sample(sorted(map(sympify, powers), key=str), len(powers))}
        ring = SimpleNamespace(orders=(q,))
        loop: Any = SimpleNamespace(symbol=q, ring=ring, low=low, high=high, table=table)
        values = [low + (high - low) * Rational(n, 8) for n in range(9)]
        highest = [x for x in table if all(x.subs(q, v) >= y.subs(q, v) for y in table for v in values)]
        if highest:
            told[0] += 1
            assert Loop.leading.fget(loop) is table[highest[0]]  # type: ignore[attr-defined]
        else:
            told[1] += 1
            with pytest.raises(UndecidedError, match="a power of s changes"):
                Loop.leading.fget(loop)  # type: ignore[attr-defined]
        loop.high = None
        with pytest.raises(UndecidedError):
            Loop.leading.fget(loop)  # type: ignore[attr-defined]
    assert min(told) > 15


@pytest.mark.parametrize("low", [-1000, -1, 0, 5])
def test_what_rounding_takes_of_a_value_goes_by_its_size_whatever_its_sign(low: int) -> None:
    cells = _Cells(Characteristic(loop_of(s**2 + s + 2 + q * exp(-s))), Rational(low), Rational(low) + Rational(1, 100))
    width, place = Rational(1, 100), cells._scale[0] + cells._scale[1] / 3
    assert (cells._lost > np.spacing(np.abs(place))).all()
    assert (cells._lost < 1e-6 * (np.abs(place) + float(width) + 1000)).all()
