"""Loops with a clock: counts of roots against NumPy, pulse transfer functions against SciPy and mpmath, exact numbers against both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import acb, arb, fmpq, fmpq_poly
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.signal import cont2discrete
from sympy import Integer, Rational, pi

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.exponentials import Exponentials
from haptisym.kernel.pulse import Plant, SampledLoop
from haptisym.kernel.schurcohn import Circle, count_on_circle

ONE = (Integer(1),)


@dataclass
class Whole:
    """A polynomial with rational coefficients."""

    c: list[Any]

    def balls(self) -> list[Any]:
        return [arb(fmpq(x)) for x in self.c]

    def exact(self) -> list[Any]:
        return [fmpq(x) for x in self.c]

    def is_zero(self, x: Any) -> bool:
        return bool(x == 0)


def product(*factors: list[int]) -> list[int]:
    total = fmpq_poly([1])
    for f in factors:
        total *= fmpq_poly(f)
    return [int(x.p) for x in total.coeffs()]


small = st.integers(-4, 4)
FACTORS: dict[tuple[int, ...], tuple[int, int, int]] = {  # with what is known of their roots: inside, on, outside
    (-1, 1): (0, 1, 0), (1, 1): (0, 1, 0), (1, 0, 1): (0, 2, 0), (1, 1, 1): (0, 2, 0), (5, -6, 5): (0, 2, 0),
    (-1, 2): (1, 0, 0), (-2, 1): (0, 0, 1), (1, 3): (1, 0, 0), (3, 1): (0, 0, 1), (1, 1, 3): (2, 0, 0), (3, 1, 1): (0, 0, 2),
    (2, -5, 2): (1, 0, 1), (0, 1): (1, 0, 0), (1, 0, 0, 0, 1): (0, 4, 0),
}  # fmt: skip


@given(st.lists(st.sampled_from(sorted(FACTORS)), min_size=1, max_size=6))
def test_products_of_known_factors_are_counted_degenerate_as_they_may_be(chosen: list[tuple[int, ...]]) -> None:
    expected = [sum(column) for column in zip(*(FACTORS[f] for f in chosen), strict=True)]
    assert count_on_circle(Whole(product(*map(list, chosen)))) == Circle(*expected)


@given(st.lists(small, min_size=2, max_size=7))
def test_roots_of_random_polynomials_are_where_numpy_finds_them(c: list[int]) -> None:
    assume(c[-1] and c[0])
    sizes = np.abs(np.roots(c[::-1]))
    found = count_on_circle(Whole(c))
    assert sum(found) == len(c) - 1
    assert found.inside >= np.sum(sizes < 1 - 1e-3)
    assert found.outside >= np.sum(sizes > 1 + 1e-3)
    assert found.on <= np.sum(np.abs(sizes - 1) < 1e-3)


def test_what_is_not_known_exactly_and_vanishes_stays_undecided() -> None:
    class Vague(Whole):
        def balls(self) -> list[Any]:
            return [arb(x, 1e-30) for x in self.c]

        def exact(self) -> Any:
            return None

    with pytest.raises(UndecidedError, match="on the unit circle"):
        count_on_circle(Vague([1, 0, 1]))


def test_exponentials_are_zero_where_their_exponents_are_equal() -> None:
    """The roots of s^3 - 2 add up to 0, so the product of their exponentials is 1; no two of them alone make anything of the kind."""
    ring = Exponentials([(-2, 0, 0, 1)], [fmpq(1)])
    E = [ring.exponential(i, 0) for i in range(3)]
    assert ring.is_zero(E[0] * E[1] * E[2] - 1)
    assert not ring.is_zero(E[0] * E[1] - 1)
    assert ring.is_zero(ring.root(0) * ring.root(1) * ring.root(2) - 2)
    # sqrt 2 times itself in two factors: exp(sqrt 8) is exp(sqrt 2)^2, of either sign
    both = Exponentials([(-2, 0, 1), (-8, 0, 1)], [fmpq(1)])
    equal = [both.is_zero(both.exponential(0, 0) ** 2 - both.exponential(i, 0)) for i in (2, 3)]
    assert sorted(equal) == [False, True]


def numbers(row: list[Any]) -> tuple[Any, ...]:
    return tuple(Rational(str(x)) for x in row)


def loop(Q: list[Any], terms: dict[str, list[Any]], T: str, above: list[Any], below: list[Any]) -> SampledLoop:
    plant = Plant(numbers(Q), tuple((Rational(lag), numbers(N)) for lag, N in terms.items()))
    return SampledLoop(plant, Rational(T), numbers(above), numbers(below))


coefficient = st.integers(-9, 9)


@given(
    Q=st.lists(coefficient, min_size=1, max_size=4),
    N=st.lists(coefficient, min_size=1, max_size=4),
    T=st.sampled_from(["1/10", "1/2", "1"]),
)
def test_the_pulse_transfer_function_is_scipys(Q: list[int], N: list[int], T: str) -> None:
    """With D = 1 the loop's polynomial is denominator plus numerator."""
    Q = [*Q, 3]
    N = N[: len(Q) - 1]
    assume(N[-1])
    own = loop(Q, {"0": N}, T, [1], [1])
    with flint.ctx.workprec(128):
        both = [float(x) for x in own.balls()]
    top, bottom, _ = cont2discrete((N[::-1], Q[::-1]), float(Rational(T)), "zoh")
    expected = np.zeros(max(len(both), len(bottom)))
    expected[: len(bottom)] += bottom
    expected[len(bottom) - top.size : len(bottom)] += top.ravel()
    np.testing.assert_allclose(
        [*both, *[0] * (expected.size - len(both))], expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max()
    )


LOOPS = {
    "a wall": loop([0, "0.8", "0.04"], {"0": [1]}, "0.001", [900, -400], [1]),
    "no damping": loop([0, 0, 1], {"0": [1]}, "1", ["0.5", "-0.25"], [1]),
    "late by a sample and a half": loop([0, "0.8", "0.04"], {"0.0015": [1]}, "0.001", [200], [1]),
    "two ways": loop([5, 3, 4, 1], {"0": [1, 2], "0.7": [0, 1]}, "0.5", [1, 1], [2, -1]),
    "a double pole": loop([1, 2, 1], {"0": [1, 3]}, "0.5", [2], [1, "-0.25"]),
    "a node without mass": loop([400, 8, 1], {"0": [500, 8, 1]}, "0.01", [0.5], [1]),
    "filtered": loop([400, "8.8", "0.04"], {"0": [1]}, "0.001", [3000, -1000], [1, "-0.5"]),
}


def simulated_eigenvalues(own: SampledLoop) -> list[Any]:
    """The witness: the loop's matrix from one sample to the next, by mpmath's matrix exponential of the plant and what is held.

    Its state: the plant's of each way, past forces, past positions. Everything is carried through time, nothing transformed.
    """
    with mpmath.workdps(60):
        T = mpmath.mpf(own.T.p) / own.T.q
        Q = [mpmath.mpf(int(x.p)) / int(x.q) for x in own.plant.denominator]
        n = len(Q) - 1
        above, below = ([mpmath.mpf(int(x.p)) / int(x.q) for x in row] for row in (own.above, own.below))
        past = 4
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


@pytest.mark.few("a wall", "late by a sample and a half", "filtered")
@pytest.mark.parametrize("name", LOOPS)
def test_the_roots_are_the_eigenvalues_of_the_sampled_matrix(name: str) -> None:
    own = LOOPS[name]
    eigenvalues = simulated_eigenvalues(own)
    found = count_on_circle(own)
    assert found.inside + found.on == sum(abs(z) > 1 + 1e-12 for z in eigenvalues)  # w = 1/z
    with flint.ctx.workprec(256):
        row = own.balls()
        for z in eigenvalues:
            w = 1 / complex(z)
            size = sum(abs(float(c)) * abs(w) ** i for i, c in enumerate(row))
            assert abs(sum(float(c) * w**i for i, c in enumerate(row))) < 1e-9 * size


@pytest.mark.parametrize("name", LOOPS)
def test_exact_coefficients_are_what_the_balls_enclose(name: str) -> None:
    own = LOOPS[name]
    exact = own.exact()
    assert exact is not None
    ring = own._exact[0]  # type: ignore[index]
    with flint.ctx.workprec(300):
        roots = ring._roots(300)
        values = [acb(0), acb.pi(), *roots, *((z * arb(t)).exp() for z in roots for t in ring.times)]
        found = []
        for element in exact:
            total = acb(0)
            for powers, value in element.to_dict().items():
                term = acb(arb(value))
                for n, x in zip(powers, values, strict=True):
                    term *= x ** int(n) if int(n) else 1
                total += term
            found.append(total)
        balls = own.balls()
        assert len(found) == len(balls)
        for x, y in zip(found, balls, strict=True):
            assert (x * balls[0]).overlaps(found[0] * y)


def test_a_loop_on_its_boundary_is_on_the_circle_exactly() -> None:
    """b = 0, alpha = 2 beta (2 - beta)/(2 + beta): all numbers rational, a pair of roots exactly on the circle."""
    beta = Rational(1, 2)
    alpha = 2 * beta * (2 - beta) / (2 + beta)
    counts = []
    for factor in (Rational(99, 100), 1, Rational(101, 100)):
        plant = Plant((Integer(0), Integer(0), Integer(1)), ((Integer(0), ONE),))
        counts.append(count_on_circle(SampledLoop(plant, Integer(1), (alpha * factor + beta, -beta), ONE)))
    assert [(x.inside, x.on) for x in counts] == [(0, 0), (0, 2), (2, 0)]


def test_a_handle_that_nothing_holds_has_a_root_at_one() -> None:
    """A damper alone leaves the place free: z = 1 whatever exp(-b T/m) is, exactly; pi in the controller changes nothing."""
    plant = Plant((Integer(0), Rational(4, 5), Rational(1, 25)), ((Integer(0), ONE),))
    for size in (Integer(100), 30 * pi):
        assert count_on_circle(SampledLoop(plant, Rational(1, 1000), (size, -size), ONE)) == Circle(0, 1, 2)


def test_an_impulse_is_refused() -> None:
    with pytest.raises(SceneError, match="impulse"):
        Plant(ONE, ((Integer(0), (Integer(1), Integer(1))),))


@pytest.mark.parametrize(("gain", "expected"), [(3, Circle(1, 0, 0)), (Rational(3, 2), Circle(0, 0, 1)), (2, None)])
def test_beside_pi_in_a_plant_roots_are_told_by_balls_and_one_on_the_circle_stays_open(
    gain: Any, expected: Circle | None
) -> None:
    """1 + (k - 1) w, of gain k pi before 1/(pi s) with a clock of 1 s."""
    loop = SampledLoop(Plant((Integer(0), pi), ((Integer(0), (Integer(1),)),)), Integer(1), (gain * pi,), (Integer(1),))
    assert loop.exact() is None
    if expected is None:
        with pytest.raises(UndecidedError, match="whether a root lies on the unit circle"):
            count_on_circle(loop)
    else:
        assert count_on_circle(loop) == expected
