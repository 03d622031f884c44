"""Loops with a clock: roots inside a circle against NumPy, pulse transfer functions against SciPy and mpmath, pairs on an axis by hand."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import combinations, pairwise, product
from math import prod
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq, fmpz_poly
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from scipy.linalg import expm
from sympy import Expr, Integer, Rational, Symbol, pi

from haptisym.kernel.enclosures import LinearEnclosure
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.sampledloop import (
    Plant,
    SampledLoop,
    States,
    about_axis,
    circle_tests,
    has_no_pair,
    hurwitz,
    is_clear,
    opposite_response,
)

k = Symbol("k", positive=True)
ONE = (Integer(1),)


# Roots inside, on and outside of a circle


def polynomial_loop(c: list[int]) -> SampledLoop:
    """The loop of an integrator with a clock of 1 s whose characteristic polynomial is that one; c[0] is not 0."""
    above = (c[0] + c[1], *c[2:]) if len(c) > 1 else (c[0],)
    return SampledLoop(
        Plant((Integer(0), Integer(1)), ((Integer(0), ONE),)), Integer(1), tuple(map(Integer, above)), (Integer(c[0]),)
    )


FACTORS: dict[tuple[int, ...], tuple[int, int, int]] = {  # with what is known of their roots: inside, on, outside
    (-1, 1): (0, 1, 0), (1, 1): (0, 1, 0), (1, 0, 1): (0, 2, 0), (1, 1, 1): (0, 2, 0), (5, -6, 5): (0, 2, 0),
    (-1, 2): (1, 0, 0), (-2, 1): (0, 0, 1), (1, 3): (1, 0, 0), (3, 1): (0, 0, 1), (1, 1, 3): (2, 0, 0), (3, 1, 1): (0, 0, 2),
    (2, -5, 2): (1, 0, 1), (1, 0, 0, 0, 1): (0, 4, 0), (1, 2, 5): (2, 0, 0),
}  # fmt: skip


@examples(40)
@given(st.lists(st.sampled_from(sorted(FACTORS)), min_size=1, max_size=6), st.sampled_from([-3, 1]))
def test_products_of_known_factors_are_counted_but_for_roots_on_the_circle_beside_a_single_one_at_1(
    chosen: list[tuple[int, ...]], lead: int
) -> None:
    outside, on, _ = (sum(column) for column in zip(*(FACTORS[f] for f in chosen), strict=True))  # of z = 1/w
    row = prod((fmpz_poly(list(f)) for f in chosen), start=fmpz_poly([lead]))
    own, at_1 = polynomial_loop([int(x) for x in row.coeffs()]), chosen.count((-1, 1))
    zs = [1 / x for f in chosen for x in np.roots(f[::-1])]
    mirrored = any(abs(a * b - 1) < 1e-9 for a, b in combinations(zs, 2))  # several such pairs may stay open
    if on == at_1 < 2:
        try:
            assert own.unstable() == (outside, at_1)
        except UndecidedError:
            assert mirrored
    else:
        with pytest.raises(UndecidedError):
            own.unstable()


@examples(40)
@given(st.lists(st.integers(-4, 4), min_size=2, max_size=7).filter(lambda c: c[0] and c[-1]))
def test_roots_of_random_polynomials_are_where_numpy_finds_them(c: list[int]) -> None:
    sizes = np.abs(np.roots(c))  # of z
    on = np.sum(np.abs(sizes - 1) < 1e-3)
    try:
        outside, at_1 = polynomial_loop(c).unstable()
    except UndecidedError:
        assert on
        return
    assert at_1 <= on
    assert np.sum(sizes > 1 + 1e-3) <= outside <= np.sum(sizes > 1 - 1e-3)


# Pulse transfer functions


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


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(15))
def test_a_loop_is_that_of_the_samples_of_step_responses(seed: int) -> None:
    draw = random.Random(seed)
    own, number = loop(draw), Rational(draw.randint(1, 20), 7)
    T, Q = float(own.T), [float(x) for x in own.plant.denominator]
    poles = np.roots(Q[::-1])
    steps = [[step(Q, [float(x) for x in N], n * T - float(lag)) for n in range(-1, 12)] for lag, N in own.plant.terms]
    for w in (0.05, -0.06 + 0.05j):
        G = 0.0 + 0.0j
        for at in steps:
            G += sum((b - a) * w**n for n, (a, b) in enumerate(pairwise(at)))
        below, above = (value([x.subs(k, number) for x in row], w) for row in (own.below, own.above))
        true = prod(1 - w * np.exp(p * T) for p in poles) * (below + above * G)
        for row in (own.at({k: number}).balls(), own.balls({k: arb(int(number.p)) / int(number.q)})):
            assert abs(value([x.mid() for x in row], w) - true) < 1e-8 * (1 + abs(true))


def numbers(row: list[Any]) -> tuple[Any, ...]:
    return tuple(Rational(str(x)) for x in row)


def loop_of(Q: list[Any], terms: dict[str, list[Any]], T: str, above: list[Any], below: list[Any]) -> SampledLoop:
    plant = Plant(numbers(Q), tuple((Rational(lag), numbers(N)) for lag, N in terms.items()))
    return SampledLoop(plant, Rational(T), numbers(above), numbers(below))


LOOPS = {
    "a wall": loop_of([0, "0.8", "0.04"], {"0": [1]}, "0.001", [900, -400], [1]),
    "no damping": loop_of([0, 0, 1], {"0": [1]}, "1", ["0.5", "-0.25"], [1]),
    "late by a sample and a half": loop_of([0, "0.8", "0.04"], {"0.0015": [1]}, "0.001", [200], [1]),
    "two ways": loop_of([5, 3, 4, 1], {"0": [1, 2], "0.7": [0, 1]}, "0.5", [1, 1], [2, -1]),
    "a double pole": loop_of([1, 2, 1], {"0": [1, 3]}, "0.5", [2], [1, "-0.25"]),
    "a node without mass": loop_of([400, 8, 1], {"0": [500, 8, 1]}, "0.01", [0.5], [1]),
    "filtered": loop_of([400, "8.8", "0.04"], {"0": [1]}, "0.001", [3000, -1000], [1, "-0.5"]),
}


def simulated_eigenvalues(own: SampledLoop) -> list[Any]:
    """The witness: the loop_of's matrix from one sample to the next, by mpmath's matrix exponential of the plant and what is held.

    Its state: the plant's of each way, past forces, past positions. Everything is carried through time, nothing transformed.
    """
    with mpmath.workdps(40):
        T = mpmath.mpf(own.T.p) / own.T.q
        Q = [mpmath.mpf(int(x.p)) / int(x.q) for x in own.plant.denominator]
        n = len(Q) - 1
        above, below = ([mpmath.mpf(int(x.p)) / int(x.q) for x in row] for row in (own.above, own.below))
        past = 3
        size = n * len(own.plant.terms) + 2 * past

        def step(state: list[Any]) -> list[Any]:
            m = n * len(own.plant.terms)
            positions, forces = state[m : m + past], state[m + past :]  # the latest first
            after, y = [], mpmath.mpf(0)
            for i, (lag, N) in enumerate(own.plant.terms):
                tau = mpmath.mpf(lag.p) / lag.q
                ell = int(mpmath.floor(tau / T))
                rest = tau - ell * T
                x = mpmath.matrix(state[n * i : n * i + n])
                for time, u in ((rest, forces[ell + 1]), (T - rest, forces[ell])):
                    rows = mpmath.zeros(n + 1)
                    for j in range(n - 1):
                        rows[j, j + 1] = 1
                    for j in range(n):
                        rows[n - 1, j] = -Q[j] / Q[n]
                    rows[n - 1, n] = 1 / Q[n]
                    moved = mpmath.expm(rows * time) * mpmath.matrix([*x, u])
                    x = mpmath.matrix([moved[j] for j in range(n)])
                c = [mpmath.mpf(int(v.p)) / int(v.q) for v in N] + [mpmath.mpf(0)] * (n + 1 - len(N))
                y += sum((c[j] - c[n] * Q[j] / Q[n]) * x[j] for j in range(n)) + c[n] / Q[n] * forces[ell]
                after += list(x)
            positions = [y, *positions[:-1]]
            u = -sum(a * positions[i] for i, a in enumerate(above)) - sum(
                b * forces[i] for i, b in enumerate(below[1:])
            )
            return [*after, *positions, u / below[0], *forces[:-1]]

        columns = [step([mpmath.mpf(int(i == j)) for i in range(size)]) for j in range(size)]
        matrix = mpmath.matrix(size, size)
        for j, column in enumerate(columns):
            for i, x in enumerate(column):
                matrix[i, j] = x
        # a plant for each way is one too many: what they have in common alone is driven
        own_modes = [mpmath.exp(p * T) for p in mpmath.polyroots(Q[::-1])] if len(own.plant.terms) > 1 else []
        return [z for z in mpmath.eig(matrix)[0] if abs(z) > 1e-3 and all(abs(z - x) > 1e-20 for x in own_modes)]


@pytest.mark.few("late by a sample and a half")
@pytest.mark.parametrize("name", LOOPS)
def test_the_roots_are_the_eigenvalues_of_the_sampled_matrix(name: str) -> None:
    own = LOOPS[name]
    eigenvalues = simulated_eigenvalues(own)
    assert sum(own.unstable()) == sum(abs(z) > 1 + 1e-12 for z in eigenvalues)
    with flint.ctx.workprec(256):
        row = own.balls()
        for z in eigenvalues:
            w = 1 / complex(z)
            size = sum(abs(float(c)) * abs(w) ** i for i, c in enumerate(row))
            assert abs(sum(float(c) * w**i for i, c in enumerate(row))) < 1e-9 * size


def test_a_loop_on_its_boundary_stays_open_and_beside_it_does_not() -> None:
    """b = 0, alpha = 2 beta (2 - beta)/(2 + beta): all numbers rational, a pair of roots exactly on the circle."""
    beta = Rational(1, 2)
    alpha = 2 * beta * (2 - beta) / (2 + beta)
    plant = Plant((Integer(0), Integer(0), Integer(1)), ((Integer(0), ONE),))
    below, at, beyond = (
        SampledLoop(plant, Integer(1), (alpha * x + beta, -beta), ONE)
        for x in (Rational(99, 100), 1, Rational(101, 100))
    )
    assert (below.unstable(), beyond.unstable()) == ((0, 0), (2, 0))
    with pytest.raises(UndecidedError, match="whether a root lies on the unit circle"):
        at.unstable()


def test_a_handle_that_nothing_holds_has_a_root_at_one() -> None:
    """A damper alone leaves the place free: z = 1 whatever exp(-b T/m) is, exactly; pi in the controller changes nothing."""
    plant = Plant((Integer(0), Rational(4, 5), Rational(1, 25)), ((Integer(0), ONE),))
    for size in (Integer(100), 30 * pi):
        assert SampledLoop(plant, Rational(1, 1000), (size, -size), ONE).unstable() == (0, 1)


def test_an_impulse_is_refused() -> None:
    with pytest.raises(SceneError, match="impulse"):
        Plant(ONE, ((Integer(0), (Integer(1), Integer(1))),))


@pytest.mark.parametrize(("gain", "expected"), [(3, (1, 0)), (Rational(3, 2), (0, 0)), (2, None)])
def test_beside_pi_in_a_plant_roots_are_told_by_balls_and_one_on_the_circle_stays_open(
    gain: Any, expected: tuple[int, int] | None
) -> None:
    """1 + (k - 1) w, of gain k pi before 1/(pi s) with a clock of 1 s."""
    loop_of = SampledLoop(
        Plant((Integer(0), pi), ((Integer(0), (Integer(1),)),)), Integer(1), (gain * pi,), (Integer(1),)
    )
    if expected is None:
        with pytest.raises(UndecidedError, match="whether a root lies on the unit circle"):
            loop_of.unstable()
    else:
        assert loop_of.unstable() == expected


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(24))
def test_a_controller_that_sees_differences_alone_has_as_many_roots_at_one_as_it_takes_and_the_plant_has(
    seed: int,
) -> None:
    """(1 - w)^j before a plant with i integrators, whatever its other poles and delays: exactly min(i, j) roots at 1; more than one stay open."""
    draw = random.Random(seed)
    i, j = draw.randint(1, 2), draw.randint(1, 3)
    Q = (*[Integer(0)] * i, *(Rational(draw.randint(1, 9), 4) for _ in range(draw.randint(1, 2))))
    lag = draw.choice([Integer(0), Rational(1, 20), Rational(1, 5)])
    above = fmpz_poly([1, -1]) ** j * draw.randint(1, 9)
    own = SampledLoop(Plant(Q, ((lag, ONE),)), Rational(1, 10), tuple(Integer(int(x)) for x in above.coeffs()), ONE)
    if min(i, j) == 1:
        assert own.unstable()[1] == 1
    else:
        with pytest.raises(UndecidedError):
            own.unstable()


def test_zeros_of_high_powers_are_left_out_when_numbers_are_put_in() -> None:
    plant = Plant((Integer(0), Integer(1), k - 1), ((k, (Integer(1), k - 1)),))
    told = SampledLoop(plant, k, (k, k - 1), (Integer(1), Integer(1) - k)).at({k: Integer(1)})
    assert told == SampledLoop(
        Plant((Integer(0), Integer(1)), ((Integer(1), (Integer(1),)),)), Integer(1), (Integer(1),), (Integer(1),)
    )
    assert SampledLoop(plant, k, (k - 1,), (Integer(1),)).at({k: Integer(1)}).above == (0,)


# What moves a plant


def exactly(q: Fraction | int) -> Any:
    return arb(fmpq(Fraction(q).numerator, Fraction(q).denominator))


def plant(draw: random.Random, size: int) -> list[Fraction]:
    return [Fraction(draw.randint(-40, 40), draw.randint(1, 9)) for _ in range(size)] + [Fraction(1)]


@pytest.mark.parametrize("seed", range(8))
def test_what_holds_a_plant_for_some_time_is_its_matrix_exponential(seed: int) -> None:
    """By mpmath: int_0^t exp(A t) dt, in states that are the derivatives times powers of a rate."""
    draw = random.Random(seed)
    n, t = draw.randint(1, 4), Fraction(draw.randint(1, 60), 20)
    Q = plant(draw, n)
    with mpmath.workdps(60), flint.ctx.workprec(160):
        states = States([exactly(c) for c in Q])
        both = mpmath.zeros(2 * n)
        for i, j in product(range(n), repeat=2):
            both[i, j] = mpmath.mpf(states.A[i, j].mid().str(50, radius=False))
            both[i, n + j] = int(i == j)
        block = mpmath.expm(both * mpmath.mpf(t.numerator) / t.denominator, method="taylor")
        limit = max(1, max(abs(block[i, j]) for i in range(n) for j in range(2 * n))) * mpmath.mpf(10) ** -25
        own = states.integral(exactly(t))
        for i, j in product(range(n), repeat=2):
            found, exact = own[i, j], block[i, n + j]
            assert abs(mpmath.mpf(found.mid().str(40, radius=False)) - exact) < limit
            assert float(found.rad()) < limit


def test_masses_alone_are_moved_exactly() -> None:
    """1/s^2: no power of A beyond the first, so that nothing is left out of its series."""
    found = States([arb(0), arb(0), arb(1)]).integral(arb(2))
    assert [[found[i, j].is_exact() for j in range(2)] for i in range(2)] == [[True] * 2] * 2
    assert [[float(found[i, j]) for j in range(2)] for i in range(2)] == [[2, 2], [0, 2]]
    nothing = States([arb(1)])
    assert (nothing.size, nothing.integral(arb(1)).nrows()) == (0, 0)


def test_wide_balls_hold_every_exponential_of_what_is_in_them() -> None:
    draw = random.Random(3)
    for _ in range(20):
        middle, radius = plant(draw, 3), Fraction(1, draw.choice([3, 30, 300]))
        states = States([arb(exactly(c), exactly(radius)) for c in middle[:-1]] + [arb(1)])
        wide = states.integral(arb("0.25"))
        inner = [c + radius * Fraction(draw.randint(-8, 8), 8) for c in middle[:-1]]
        with flint.ctx.workprec(200):
            one = States([*map(exactly, inner), arb(1)])
            scaled = one.integral(arb("0.25"))
            for i in range(3):
                for j in range(3):  # states of another rate: the i-th times rate^(2 - i)
                    ratio = (states.rate / one.rate) ** (j - i) if states.rate != one.rate else arb(1)
                    assert wide[i, j].overlaps(scaled[i, j] * ratio)
    assert not States([arb("nan"), arb(1)]).integral(arb(1))[0, 0].is_finite()
    assert not States([arb(10) ** 40, arb(1)]).integral(arb(1))[0, 0].is_finite()


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


# Near z = 1 and z = -1, and pairs on the axis


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(15))
def test_about_z_equal_to_one_a_loop_is_the_same_but_for_roots_at_0(seed: int) -> None:
    draw = random.Random(seed)
    own, number = loop(draw), arb(draw.randint(1, 20)) / 7
    known: dict[Expr, Any] = {k: number}
    row, plain = ([float(x.mid()) for x in given] for given in (own.about_one(known), own.balls(known)))
    ratios = [abs(value(row, z - 1) / value(plain, 1 / z)) for z in (2.0, 3.0, 2.5)]
    powers = [np.log(x) / np.log(z) for x, z in zip(ratios, (2.0, 3.0, 2.5), strict=True)]
    assert np.allclose(powers, round(powers[0]), atol=1e-7)
    assert powers[0] > len(plain) - 1.5


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(15))
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
        true = about_axis(own.about_one({k: arb(number.numerator) / number.denominator}))
    with flint.ctx.workprec(128):
        for width in ("0", "1e-6", "0.1", "3"):
            wide: dict[Expr, Any] = {k: arb(number.numerator) / number.denominator + arb(0, width)}
            told = own.in_v(wide)
            assert len(told) == len(true)
            assert all(x.overlaps(y) for x, y in zip(told, true, strict=True))
            assert told[-1].overlaps(about_axis(own.about_one(wide))[-1])
    with flint.ctx.workprec(640):
        [*_, sharp] = own.in_v({k: arb(number.numerator) / number.denominator})
        assert sharp.contains(0) or sharp.rel_accuracy_bits() > 400


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(15))
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


@pytest.mark.parametrize("times", range(4))
def test_roots_at_minus_one_are_highest_coefficients_that_vanish(times: int) -> None:
    """z = -1 is v at infinity: the polynomial keeps its length, as roots beyond are counted by it."""
    for rest in ([3], [1, 5], [4, -1, 7]):
        row = np.poly([-2] * times + [-x for x in rest])[::-1]
        turned = about_axis([arb(x) for x in row])
        assert len(turned) == len(row)
        assert [x == 0 for x in turned[::-1]] == [True] * times + [False] * (len(row) - times)
    assert about_axis([arb(0), arb(3)]) == [0, 6]


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
            circle_tests(own, {k: critical + arb(x)}, own.at_one, always) for x in ("-0.01", 0, "0.01")
        )
    for n in range(3):
        changes = bool(below[n] * beyond[n] < 0)
        assert (changes, at[n].contains(0)) == ((True, True) if n == which else (False, False))


@pytest.mark.parametrize(("late", "critical"), [(1, "1"), (0, "2")])
def test_a_cell_is_clear_only_if_no_value_in_it_puts_a_root_on_the_circle(late: int, critical: str) -> None:
    """z^2 - z + k: a pair at k = 1; z - 1 + k: a root at -1 at k = 2. Both leave z = 1 for k > 0."""
    plant = Plant((Integer(0), Integer(1)), ((Integer(0), ONE),))
    own = SampledLoop(plant, Integer(1), (*[Integer(0)] * late, k), ONE)
    on, ends = Fraction(critical), [Fraction(n, 16) for n in range(65)]
    for a, b in [*pairwise(ends), *zip(ends, ends[5:], strict=False), *((x, x) for x in ends)]:
        clear = is_clear(
            own, {k: arb(fmpq(a.numerator, a.denominator)).union(arb(fmpq(b.numerator, b.denominator)))}, own.at_one
        )
        assert not (clear and (a <= on <= b or a == 0))
        assert clear or a == 0 or a - Fraction(1, 8) < on < b + Fraction(1, 8) or b - a > Fraction(1, 4)


@pytest.mark.parametrize(
    ("c", "none"),
    [
        ([1, 1, 1], True), ([1, 0, 1], False), ([1, 1, 1, 1], False),  # (v + 1)(v^2 + 1)
        ([-1, 0, 1], True), ([-1, -1, 1, 1], True),  # v = +-1 is no pair on the axis
        ([0, 1, 1], True), ([0, 0, 1], False), ([4, 0, 5, 0, 1], False), ([1, 1], True), ([0], True),
        ([float("nan"), 1, 1], False), ([1, 1, float("inf")], False),
    ],
)  # fmt: skip
def test_a_pair_on_the_axis_is_seen_and_no_other(c: list[float], *, none: bool) -> None:
    assert has_no_pair([arb(x) for x in c]) is none


@pytest.mark.dear("9")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(12))
def test_no_polynomial_within_balls_without_a_pair_has_one(seed: int) -> None:
    """Where one does, its number of roots with Re v > 0 is not that of another: the two are joined within the balls."""
    rng = np.random.default_rng(seed)
    told = 0
    for _ in range(25):
        roots = rng.normal(size=5) * 10.0 ** rng.uniform(-3, 1, 5)
        middle = np.real(
            np.poly(np.concatenate([roots[:1], *((x + 1j * y, x - 1j * y) for x, y in roots[1:].reshape(2, 2))]))
        )
        width = abs(middle) * 10.0 ** rng.uniform(-2, -0.5)
        if has_no_pair([arb(m, w) for m, w in zip(middle[::-1], width[::-1], strict=True)]):
            told += 1
            counts = {int((np.roots(middle + width * x).real > 0).sum()) for x in rng.choice([-1.0, 0.3, 1.0], (30, 6))}
            assert len(counts) == 1
    assert told > 1


def test_of_wide_balls_more_is_known_than_by_the_determinant() -> None:
    """(v + 1)^5, each coefficient by 10 %."""
    wide = [arb(x, 0.1 * x) for x in (1, 5, 10, 10, 5, 1)]
    assert hurwitz(wide).contains(0)
    assert has_no_pair(wide)


@pytest.mark.parametrize("seed", range(4))
def test_a_pair_on_the_axis_for_some_number_is_never_passed_by(seed: int) -> None:
    """(v^2 + nu^2)(v + a) has such a pair at one number; away from it, E and O move so that neither is 0 alone."""
    draw, told = random.Random(seed), 0
    for _ in range(25):
        nu2, a = draw.uniform(0.2, 4), draw.uniform(0.2, 4)
        middle = [a * nu2, nu2, a, 1.0]
        slopes, there = [draw.uniform(-1, 1) for _ in middle], draw.uniform(-1, 1)
        for beside in (0, 3):  # of all moves, in the lowest coefficient: at that number, and far from it
            at = [c - x * there for c, x in zip(middle, slopes, strict=True)]
            at[0] += beside * sum(map(abs, slopes)) * (1 + nu2)
            lines = [LinearEnclosure(arb(c), arb(x)) for c, x in zip(at, slopes, strict=True)]
            clear = has_no_pair([x.ball for x in lines], lines)
            assert not (clear and not beside)
            told += clear
    assert told > 2


def test_moves_that_a_combination_shows_to_miss_the_axis_are_told() -> None:
    """v^3 + a v^2 + b v + 1/2 has a pair on the axis where a b = 1/2: not where a = 1 + y/2 and b = 1 - y/2, y^2 < 1."""
    lines = [
        LinearEnclosure(arb("0.5"), arb(0)),
        LinearEnclosure(arb(1), arb("-0.5")),
        LinearEnclosure(arb(1), arb("0.5")),
        LinearEnclosure(arb(1), arb(0)),
    ]
    assert not has_no_pair([x.ball for x in lines])  # 1/2 < a, b < 3/2
    assert has_no_pair([x.ball for x in lines], lines)  # a b >= 3/4
    wider = [x._replace(slope=x.slope * arb("1.6")) for x in lines]
    assert not has_no_pair([x.ball for x in wider], wider)  # 1.8 * 0.2
