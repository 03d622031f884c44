"""Loops with a clock, whatever the plant, its delays and the controller: against step responses by SciPy, and polynomials against their roots."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import combinations, pairwise
from math import prod
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import acb, arb
from marks import spread
from scipy.linalg import expm
from sympy import Expr, Integer, Rational, Symbol, bernoulli, factorial

from haptisym.kernel.nearone import about_axis, about_one, at_one, circle_tests, has_no_pair, hurwitz, in_v
from haptisym.kernel.pulse import Plant, SampledLoop
from haptisym.kernel.states import _TANH, States, _tanh, opposite_response
from haptisym.model.parameters import Rule
from haptisym.verbs.stability import oncircle
from haptisym.verbs.stability.clockcritical import Opened, Walk
from haptisym.verbs.stability.oncircle import OnCircle

SEEDS = spread(range(30), 2)
k = Symbol("k", positive=True)


def step(Q: list[float], N: list[float], t: float) -> float:
    """The response of N/Q to a unit step, just before the time t."""
    if t <= 0:
        return 0.0
    n = len(Q) - 1
    Q, N = [x / Q[-1] for x in Q], [*(x / Q[-1] for x in N), *[0.0] * (n + 1 - len(N))]
    if not n:
        return N[0]
    M = np.zeros((n + 1, n + 1))
    M[np.arange(n - 1), np.arange(1, n)] = 1
    M[n - 1, :n], M[n - 1, n] = [-x for x in Q[:n]], 1
    C = np.array([a - N[n] * b for a, b in zip(N, Q, strict=True)][:n])
    return float(C @ expm(M * t)[:n, n] + N[n])


def loop(draw: random.Random) -> SampledLoop:
    """A plant with or without integrators and a direct way, with up to two delays; rational numbers, some of them a symbol's."""

    def some() -> Rational:
        return Rational(draw.randint(1, 9), draw.randint(1, 5))

    Q = [draw.choice([Integer(0), some()]), *(some() for _ in range(draw.randint(0, 2))), some()]
    T = Rational(1, draw.choice([1, 2, 5]))
    lags = draw.sample([Integer(0), T, T / 3, 3 * T / 2, 2 * T], draw.randint(1, 2))
    terms = tuple((lag, tuple(draw.choice([-1, 1]) * some() for _ in range(draw.randint(1, len(Q))))) for lag in lags)
    above = (draw.choice([k, some()]), *(some() * k for _ in range(draw.randint(0, 2))))
    below = (Integer(1), *(some() / 9 for _ in range(draw.randint(0, 1))))
    return SampledLoop(Plant(tuple(Q), terms), T, above, below)


def value(row: Any, at: Any) -> Any:
    return sum(complex(x) * at**n for n, x in enumerate(row))


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_loop_is_that_of_the_samples_of_step_responses(seed: int) -> None:
    draw = random.Random(seed)
    own, number = loop(draw), Rational(draw.randint(1, 20), 7)
    T, Q = float(own.T), [float(x) for x in own.plant.denominator]
    assert own.whole == tuple(int(lag // own.T) for lag, _ in own.plant.terms)
    told = own.at({k: number})
    rows = {"plain": told.balls(), "known": own.balls({k: arb(int(number.p)) / int(number.q)})}
    poles = np.roots(Q[::-1])
    steps = [[step(Q, [float(x) for x in N], n * T - float(lag)) for n in range(-1, 12)] for lag, N in own.plant.terms]
    for w in (0.05, -0.06 + 0.05j):
        G = 0.0 + 0.0j
        for at in steps:
            G += sum((b - a) * w**n for n, (a, b) in enumerate(pairwise(at)))
        below, above = (value([x.subs(k, number) for x in row], w) for row in (own.below, own.above))
        true = prod(1 - w * np.exp(p * T) for p in poles) * (below + above * G)
        for row in rows.values():
            assert abs(value([x.mid() for x in row], w) - true) < 1e-8 * (1 + abs(true))
    exact = told.exact()
    assert exact is not None
    assert told._exact is not None
    ring = told._exact[0]
    with flint.ctx.workprec(160):
        values = [evaluated(ring, x) for x in exact]
    balls = [float(x.mid()) for x in rows["plain"]]
    balls += [0.0] * (len(values) - len(balls))
    assert len(balls) <= len(values) or max(map(abs, balls[len(values) :])) < 1e-9
    assert (
        np.linalg.matrix_rank(
            np.array([values, balls[: len(values)]]), tol=1e-6 * max(map(abs, values)) * max(map(abs, balls))
        )
        == 1
    )
    assert [told.is_zero(x) for x in exact] == [abs(x) < 1e-30 for x in values]


def evaluated(ring: Any, x: Any) -> float:
    roots = ring._roots(160)
    total = acb(0)
    for powers, c in x.to_dict().items():
        own = [int(n) for n in powers]
        late = own[2 + len(roots) :]
        exponent = sum(
            (z * arb(t) * late[i * len(ring.times) + j] for i, z in enumerate(roots) for j, t in enumerate(ring.times)),
            acb(0),
        )
        term = acb(arb(c)) * arb.pi() ** own[1] * exponent.exp()
        for z, n in zip(roots, own[2:], strict=False):
            term *= z**n
        total += term
    return float(total.real.mid())


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_about_z_equal_to_one_a_loop_is_the_same_but_for_roots_at_0(seed: int) -> None:
    draw = random.Random(seed)
    own, number = loop(draw), arb(draw.randint(1, 20)) / 7
    known: dict[Expr, Any] = {k: number}
    row, plain = ([float(x.mid()) for x in given] for given in (about_one(own, known), own.balls(known)))
    ratios = [abs(value(row, z - 1) / value(plain, 1 / z)) for z in (2.0, 3.0, 2.5)]
    powers = [np.log(x) / np.log(z) for x, z in zip(ratios, (2.0, 3.0, 2.5), strict=True)]
    assert np.allclose(powers, round(powers[0]), atol=1e-7)
    assert powers[0] > len(plain) - 1.5


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_at_z_equal_to_minus_one_a_loop_is_what_its_coefficients_add_up_to(seed: int) -> None:
    """Of numbers that are known well, and for all of wide ones."""
    draw = random.Random(seed)
    own, number = loop(draw), Fraction(draw.randint(1, 20), 7)
    if draw.random() < 0.7:  # slow compared with its clock, as plants are
        own = SampledLoop(own.plant, own.T / draw.choice([4, 20]), own.above, own.below)
    rest = Rational(draw.randint(1, 9), 7)
    own = draw.choice(
        [own, SampledLoop(own.plant, own.T, own.above, (rest, rest))]
    )  # a pole there, as Tustin's rule has
    with flint.ctx.workprec(400):
        true = about_axis(about_one(own, {k: arb(number.numerator) / number.denominator}))
    with flint.ctx.workprec(128):
        for width in ("0", "1e-6", "0.1", "3"):
            wide: dict[Expr, Any] = {k: arb(number.numerator) / number.denominator + arb(0, width)}
            told = in_v(own, wide)
            assert len(told) == len(true)
            assert all(x.overlaps(y) for x, y in zip(told, true, strict=True))
            assert told[-1].overlaps(about_axis(about_one(own, wide))[-1])
    with flint.ctx.workprec(640):
        [*_, sharp] = in_v(own, {k: arb(number.numerator) / number.denominator})
        assert sharp.contains(0) or sharp.rel_accuracy_bits() > 400


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(12))
def test_a_force_that_changes_its_sign_each_period_moves_a_plant_as_matrix_exponentials_tell(seed: int) -> None:
    """(1 + Phi)^-1 Gamma with 60 digits, for plants with poles at 0 and without, wide ones too."""
    draw = random.Random(seed)
    n = draw.randint(1, 4)
    row = [draw.choice([0, draw.randint(1, 60)]) if i < 2 else draw.randint(1, 60) for i in range(n)]
    read, T = [draw.randint(-5, 5) for _ in range(n)], Fraction(1, draw.choice([90, 500, 4000]))
    with mpmath.workdps(60):
        A = mpmath.zeros(n + 1)
        for i in range(n - 1):
            A[i, i + 1] = 1
        for j in range(n):
            A[n - 1, j] = -row[j]
        A[n - 1, n] = 1
        moved = mpmath.expm(A * mpmath.mpf(T.numerator) / T.denominator)
        at = mpmath.lu_solve(moved[:n, :n] + mpmath.eye(n), moved[:n, n])
        true = mpmath.fsum(c * x for c, x in zip(read, at, strict=True))
        with flint.ctx.workprec(160):
            states = States([*map(arb, row), arb(1)])
            found = opposite_response(states, states.row([arb(x) for x in read]), arb(T.numerator) / T.denominator)
            assert found is not None
            assert float(abs(found - arb(mpmath.nstr(true, 55))).upper()) <= 1e-12 * abs(float(true))
            around = States([*(arb(x, arb(x) / 8) for x in row), arb(1)])
            wide = opposite_response(around, around.row([arb(x) for x in read]), arb(T.numerator) / T.denominator)
            assert wide is not None
            assert wide.contains(found.mid())


def test_a_plant_that_is_fast_compared_with_its_clock_is_left_to_other_ways() -> None:
    states = States([arb(9), arb(1)])
    for T, told in (("0.3", False), ("0.17", True)):  # 9 T/2 < pi/4
        assert (opposite_response(states, states.row([arb(1)]), arb(T)) is not None) is told
    fast_if_at_all = States([arb(1, 8), arb(1)])
    assert opposite_response(fast_if_at_all, fast_if_at_all.row([arb(1)]), arb("0.2")) is None


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_hurwitz_determinant_is_orlandos_product_and_pairs_are_seen(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(10):
        roots: list[complex] = []
        while len(roots) < draw.randint(2, 5):
            a, b = draw.choice([-2, -1, 0, 1, 3]), draw.randint(1, 3)
            roots += [complex(a, b), complex(a, -b)] if draw.random() < 0.5 else [complex(draw.choice([-3, -1, 2, 4]))]
        lead = draw.choice([-2, 1, 3])
        c = (lead * np.poly(roots)).real[::-1]
        balls = [arb(float(x)) for x in c]
        n = len(roots)
        true = (-1) ** (n * (n - 1) // 2) * lead ** (n - 1) * prod(x + y for x, y in combinations(roots, 2)).real
        assert abs(float(hurwitz(balls)) - true) < 1e-6 * (1 + abs(true))
        pair = any(x.real == 0 and x.imag for x in roots)
        assert has_no_pair(balls) == (not pair)
        turned = about_axis(balls)
        for v in (0.3, -0.4 + 0.2j):
            assert abs(value([x.mid() for x in turned], v) - value(c, 2 * v / (1 - v)) * (1 - v) ** n) < 1e-8 * (
                1 + abs(value(c, 2 * v / (1 - v)))
            )
        assert len(turned) == n + 1
    assert hurwitz([arb(3), arb(1)]) == 1
    assert has_no_pair([arb(0), arb(1)])
    assert not has_no_pair([arb("nan"), arb(1), arb(1)])


def test_zeros_of_high_powers_are_left_out_when_numbers_are_put_in() -> None:
    plant = Plant((Integer(0), Integer(1), k - 1), ((k, (Integer(1), k - 1)),))
    told = SampledLoop(plant, k, (k, k - 1), (Integer(1), Integer(1) - k)).at({k: Integer(1)})
    assert told == SampledLoop(
        Plant((Integer(0), Integer(1)), ((Integer(1), (Integer(1),)),)), Integer(1), (Integer(1),), (Integer(1),)
    )
    assert SampledLoop(plant, k, (k - 1,), (Integer(1),)).at({k: Integer(1)}).above == (0,)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_where_roots_may_meet_the_circle_is_where_their_number_changes(seed: int) -> None:
    draw = random.Random(seed)
    own, (low, high) = loop(draw), draw.choice([(Rational(1, 4), Rational(8)), (Rational(1), Rational(2))])
    form = OnCircle(own, {k: (low, high)})
    left = form.left()
    values = [low + (high - low) * Rational(n, 40) for n in range(41)]
    counts = []
    for x in values:
        row = [float(c.mid()) for c in own.at({k: x}).balls()]
        size = abs(np.roots(row[::-1]))
        counts.append((int((size < 1).sum()), float(abs(size - 1).min(initial=9))))
    for n, (a, b) in enumerate(pairwise(counts)):
        if a[0] != b[0]:
            assert any(x[0][0] < Fraction(n + 1, 40) and x[0][1] > Fraction(n, 40) for x in left)
    width = sum(float(x[0][1] - x[0][0]) for x in left)
    assert (
        width < 0.1
        or len({x for x, _ in counts}) > 2
        or form._at_one == 0
        or min(x for _, x in counts) < 1e-3
        or not left
    )
    for x, (inside, near) in zip(values, counts, strict=True):
        if near > 1e-6:
            assert form.is_stable({k: x}) in ((True,) if not inside else (False, None))


def test_a_loop_of_one_root_meets_the_circle_where_it_is_at_minus_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """z = 1 - k."""
    monkeypatch.setattr(oncircle, "_MOST_CELLS", 60)
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))
    own = SampledLoop(plant, Integer(1), (k,), (Integer(1),))
    for low, high, stable in ((Rational(1, 2), Rational(3, 2), True), (Rational(5, 2), Integer(4), False)):
        form = OnCircle(own, {k: (low, high)})
        assert form.left() == []
        assert form.is_stable({k: (low + high) / 2}) is stable
    form = OnCircle(own, {k: (Rational(3, 2), Rational(7, 2))})
    left = form.left()
    assert any(x[0][0] <= Fraction(1, 4) <= x[0][1] for x in left)
    assert all(abs(float(x[0][0]) - 0.25) < 0.01 for x in left)


@pytest.mark.parametrize(
    ("late", "above", "always", "which", "critical"),
    [
        (0, (k,), 0, 1, 2),  # z - 1 + k
        (1, (k,), 0, 2, 1),  # z^2 - z + k
        (0, (k - 3,), 0, 0, 3),
        (0, (k, -k), 1, 1, 1),  # (z - 1) (z + k)
        (0, (k - 4, 2 - k / 2), 0, 0, 4),  # z^2 - z + (k - 4) z + 2 - k/2
    ],
)
def test_one_of_three_numbers_changes_its_sign_where_a_root_comes_to_the_circle(
    late: int, above: tuple[Expr, ...], always: int, which: int, critical: int
) -> None:
    plant = Plant((Integer(0), Integer(1)), ((Integer(late), (Integer(1),)),))
    own = SampledLoop(plant, Integer(1), above, (Integer(1),))
    with flint.ctx.workprec(128):
        below, at, beyond = (
            circle_tests(own, {k: critical + arb(x)}, at_one(own), always) for x in ("-0.01", 0, "0.01")
        )
    for n in range(3):
        changes = bool(below[n] * beyond[n] < 0)
        assert (changes, at[n].contains(0)) == ((True, True) if n == which else (False, False))


@pytest.mark.parametrize(("late", "critical"), [(1, "1"), (0, "2")])
def test_a_cell_is_clear_only_if_no_value_in_it_puts_a_root_on_the_circle(late: int, critical: str) -> None:
    """z^2 - z + k: a pair at k = 1; z - 1 + k: a root at -1 at k = 2. Both leave z = 1 for k > 0."""
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), (Integer(1),)),))
    own = SampledLoop(plant, Integer(1), (*[Integer(0)] * late, k), (Integer(1),))
    form = OnCircle(own, {k: (Integer(0), Integer(4))})
    on, ends = Fraction(critical), [Fraction(n, 16) for n in range(65)]
    for a, b in [*pairwise(ends[1:]), *zip(ends, ends[5:], strict=False), *((x, x) for x in ends)]:
        clear = form.is_clear((((a / 4), (b / 4)),))
        assert not (clear and (a <= on <= b or a == 0))
        assert clear or a == 0 or a - Fraction(1, 8) < on < b + Fraction(1, 8) or b - a > Fraction(1, 4)


@pytest.mark.parametrize("times", range(4))
def test_roots_at_minus_one_are_highest_coefficients_that_vanish(times: int) -> None:
    """z = -1 is v at infinity: the polynomial keeps its length, as roots beyond are counted by it."""
    for rest in ([3], [1, 5], [4, -1, 7]):
        row = np.poly([-2] * times + [-x for x in rest])[::-1]
        turned = about_axis([arb(x) for x in row])
        assert len(turned) == len(row)
        assert [x == 0 for x in turned[::-1]] == [True] * times + [False] * (len(row) - times)
    assert about_axis([arb(0), arb(3)]) == [0, 6]


def placed(own: SampledLoop, at: Rational) -> Any:
    """The roots in w = 1/z, by NumPy."""
    with flint.ctx.workprec(256):
        return np.roots([float(c.mid()) for c in own.at({k: at}).balls()][::-1])


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_the_nearest_changes_of_a_loop_are_where_roots_by_numpy_pass_the_circle(seed: int) -> None:
    draw = random.Random(seed)
    own = loop(draw)
    if seed % 4 == 0:  # nothing but differences: a root stays at 1, once or twice
        plant = Plant(
            (Integer(0), *[Integer(0)] * (seed % 8 == 0), Rational(draw.randint(1, 5)), Integer(1)),
            ((Integer(0), (Integer(1),)),),
        )
        own = SampledLoop(plant, own.T, (k, -k), (Integer(1),))
    opened = Opened(own, k)
    assert opened.is_fixed is not any(x.has(k) for x in (*own.above, *own.below))
    assert Opened(own, Symbol("x")).is_fixed
    start = Rational(draw.randint(1, 30), 10)
    number, on = opened.count(start)
    sizes = abs(placed(own, start))
    always = opened.always
    assert always == ((seed % 4 == 0) if opened.at_one == 0 else 0) or seed % 4
    clear = sizes[abs(sizes - 1) > 1e-5]
    if len(clear) + always == len(sizes):
        assert number == int((clear < 1).sum()) + always
        assert on == 0
    with flint.ctx.workprec(256):
        q = arb(int(start.p)) / int(start.q)
        row, whole = opened.row(q), own.at({k: start}).balls()
        for w in (0.3, -1.7, 2.0):
            left = sum(float(c.mid()) * w**n for n, c in enumerate(row)) * (w - 1) ** always
            assert left == pytest.approx(sum(float(c.mid()) * w**n for n, c in enumerate(whole)), rel=1e-6, abs=1e-9)
    if on:
        return
    walk = Walk(opened, Fraction(int(start.p), int(start.q)), number, Rule.POSITIVE)
    for side in (-1, 1):
        found, known = walk.towards(side)
        last = float(found.value) if found else float(known)
        grid = float(start) * (last / float(start)) ** np.linspace(0.001, 0.999, 30)
        for x in grid:
            near = abs(placed(own, Rational(float(x))))
            far_away = near[abs(near - 1) > 1e-4]
            if len(far_away) + always == len(near):
                assert int((far_away < 1).sum()) + always == number, (float(x), last)
        if found is not None:
            there = abs(placed(own, Rational(last)))
            assert sum(abs(there - 1) < 1e-5) > always
            turned = placed(own, Rational(last))[abs(there - 1) < 1e-5]
            assert min(abs(abs(np.angle(turned)) - float(found.omega) * float(own.T))) < 1e-4
            ends = opened.count(Rational(last * (1 - 1e-9))), opened.count(Rational(last * (1 + 1e-9)))
            assert (ends[0][0], ends[1][0]) == (found.below, found.above)
            assert number in (found.below, found.above)


@pytest.mark.parametrize("seed", range(12))
def test_what_a_loop_may_hide_does_not_hang_on_the_signs_that_its_quotients_are_written_with(seed: int) -> None:
    """D = A/B = (-A)/(-B), G likewise; it may hide something where a pole of G is not on the left, or one of D outside of the circle."""
    draw = random.Random(seed)
    own = loop(draw)
    poles = [x for x in np.roots([float(x) for x in own.plant.denominator[::-1]]) if x != 0]
    outside = abs(np.roots([float(x) for x in own.below])) > 1
    found = []
    for sign, other in ((1, 1), (-2, 1), (1, -3), (-1, -1)):
        terms = tuple((lag, tuple(sign * x for x in N)) for lag, N in own.plant.terms)
        plant = Plant(tuple(sign * x for x in own.plant.denominator), terms)
        same = SampledLoop(plant, own.T, tuple(other * x for x in own.above), tuple(other * x for x in own.below))
        found.append(OnCircle(same, {k: (Rational(1), Rational(2))}).hides_none)
    assert len(set(found)) == 1
    if found[0]:
        assert all(x.real < 0 for x in poles)
        assert not outside.any()
    assert (
        found[0]
        or any(x.real > -1e-9 for x in poles)
        or outside.any()
        or not all(x >= 0 for x in own.plant.denominator)
    )


def test_coefficients_of_tanh_are_those_that_bernoulli_numbers_give() -> None:
    """tanh(x)/x is the sum of 4^n (4^n - 1) B_2n/(2n)! x^(2n - 2) from n = 1 on."""
    expected = [4**n * (4**n - 1) * bernoulli(2 * n) / factorial(2 * n) for n in range(1, 17)]
    for found in (_tanh(16), _TANH):
        assert [Rational(int(x.p), int(x.q)) for x in found] == expected
    assert _tanh(1) == [1]
