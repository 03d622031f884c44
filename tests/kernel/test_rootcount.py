"""How many roots lie on the right: against roots placed by hand, those of mpmath, and winding numbers of sampled contours."""

from __future__ import annotations

import cmath
import random
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
import windings
from hypothesis import assume, given
from hypothesis import strategies as st
from oracles import MP
from sympy import Expr, I, Integer, Rational, exp, expand, lambdify, pi, sqrt
from windings import late_mass

import haptisym as hs
from haptisym.kernel import contour
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.rootcount import RootChain, Roots, _need_few_turns, _turn_along, count_roots, floor_of
from haptisym.kernel.symbols import s

E = exp(-s)
LATE = exp(-pi * s)


def roots(expression: Expr) -> Roots:
    ring = Ring.of([expression])
    return count_roots(ring.convert(expression).numerator, ring)


def winding(expression: Expr, reach: float = 60.0, left: float = 1e-3) -> int | None:
    """The roots with Re s > left and |s| < reach, by the turns of sampled values around a half disc; None if too coarse."""
    f = lambdify(s, expression, "numpy")
    arc = left + reach * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 20_001))
    axis = left + 1j * reach * np.linspace(1, -1, 60_001)
    values = f(np.concatenate([arc, axis]))
    turn = np.angle(values[1:] / values[:-1])
    return round(float(turn.sum()) / (2 * np.pi)) if np.abs(turn).max() < 1 else None


whole = st.integers(-9, 9)


@given(st.lists(whole, min_size=2, max_size=8).filter(lambda c: c[0]))
def test_roots_of_polynomials_are_counted_as_mpmath_finds_them(c: list[int]) -> None:
    real = [z.real for z in MP.polyroots(c, maxsteps=2000, extraprec=2000)]
    assume(all(abs(x) > MP.mpf(10) ** -9 for x in real))
    found = roots(sum(n * s**i for i, n in enumerate(reversed(c))))
    assert (found.number, found.right, found.on_axis) == (sum(x > 0 for x in real), sum(x > 0 for x in real), ())


rates = (
    st.fractions(Fraction(1, 9), 9, max_denominator=9).filter(bool).map(lambda x: Rational(x.numerator, x.denominator))
)


@given(
    st.lists(st.tuples(rates, rates, st.sampled_from([-1, 1])), max_size=2),
    st.lists(st.tuples(rates, st.integers(1, 2)), max_size=2, unique_by=lambda x: x[0]), st.integers(0, 3),
)  # fmt: skip
def test_roots_placed_on_the_axis_are_counted_as_often_as_they_are_there(
    pairs: list[tuple[Rational, Rational, int]], on_axis: list[tuple[Rational, int]], at_0: int
) -> None:
    f = s**at_0
    for a, b, side in pairs:
        f *= (s - side * a) ** 2 + b**2
    for w, times in on_axis:
        f *= (s**2 + w**2) ** times
    right = 2 * sum(side > 0 for _, _, side in pairs)
    found = roots(expand(f * (s + 3)))
    assert (found.right, found.number) == (right, right + at_0 + 2 * sum(times for _, times in on_axis))
    assert [float(x) for x in found.on_axis] == pytest.approx(
        sorted([0.0] * (at_0 > 0) + [float(w) for w, _ in on_axis])
    )


LOOPS = [
    s**2 + s + 1 + 5 * E, s**3 + 2 * s**2 + 40 * s * E + 7, s**2 - 3 * s + 2 + E, s + 1 + 20 * E, s**2 + 100 * E + 5 * s,
    s * (2 + E) + 30 * exp(-3 * s), s**2 * (3 - E - E**2) - 8 * s + 50, s**2 * (5 + E + LATE) + 90 * LATE + s,
    # |L| > 0 on the disc though the delayed terms outweigh the undelayed one: z = -1 +- j/sqrt(3) are its zeros
    s * (1 + Rational(3, 2) * E + Rational(3, 4) * E**2) + 1, s**2 * (1 + Rational(3, 2) * E + Rational(3, 4) * E**2) + 400,
    s - 3 * sqrt(s) + 1, s**2 + 5 * sqrt(s) * E + 1, s**2 + 30 * E * sqrt(s) + s, s**2 - 7 * s ** Rational(4, 5) + 9,
]  # fmt: skip


@pytest.mark.parametrize("loop", LOOPS, ids=str)
def test_roots_of_loops_with_delays_and_powers_are_those_that_a_sampled_contour_winds_around(loop: Expr) -> None:
    found = roots(loop)
    assert found.right == winding(loop)


@given(st.lists(whole, min_size=2, max_size=4).filter(lambda c: c[0]), st.lists(whole, min_size=1, max_size=3), rates)
def test_random_loops_with_a_delay_are_counted_as_their_contour_winds(
    a: list[int], b: list[int], lag: Rational
) -> None:
    assume(len(b) < len(a))
    loop = sum(n * s**i for i, n in enumerate(reversed(a))) + exp(-s * lag) * sum(n * s**i for i, n in enumerate(b))
    above, below = winding(loop, left=1e-4), winding(loop, left=-1e-4)
    assume(above is not None and above == below)  # no root on the axis, or hardly beside it
    assert roots(loop).number == above


@pytest.mark.parametrize(
    ("chain", "where"),
    [
        (1 + 2 * E, RootChain.RIGHT), (2 + 3 * LATE, RootChain.RIGHT), (E, RootChain.RIGHT), (1 + E, RootChain.NEAR), (1 - E**2, RootChain.NEAR),
        (1 + E / 2 + LATE, RootChain.RIGHT), (1 + E / 2 + LATE / 2, RootChain.NEAR), (1 + E - E**2, RootChain.RIGHT), (1 - E + E**2, RootChain.NEAR),
        (1 + E / 2 + LATE / 3, None), (1 + Rational(3, 2) * E + Rational(3, 4) * E**2, None),
    ],
    ids=str,
)  # fmt: skip
def test_the_chain_of_a_neutral_function_is_recognised(chain: Expr, where: RootChain | None) -> None:
    found = roots(expand(chain * s**2) + 3 * s + 1)
    assert found.chain is where
    assert (found.number is None) is (where is not None)


def test_a_delay_that_all_terms_share_has_no_roots() -> None:
    assert roots(100 * E).number == 0
    assert roots(expand(E**2 * LATE * (s**2 - s + 4))).right == 2
    assert roots(expand(E * (s + 1 + 2 * s * E))).chain is RootChain.RIGHT


@pytest.mark.parametrize("hand", ["400", "499.9999", "500", "2000"])
def test_a_delayed_mass_is_held_by_no_lighter_one(hand: str) -> None:
    """(500 s^2 + 100) exp(-s/2) + m s^2 + 40 s + 900: the chain lies at Re s = 2 log(500/m)."""
    found = roots((500 * s**2 + 100) * exp(-s / 2) + Rational(hand) * s**2 + 40 * s + 900)
    expected = RootChain.RIGHT if float(hand) < 500 else RootChain.NEAR if hand == "500" else None
    assert found.chain is expected


@pytest.mark.parametrize(("gap", "number"), [("0.5", 4), ("2", 2), ("9.8", 2), ("9.9", 0), ("652", 2)])
def test_beside_a_chain_roots_are_counted_up_to_where_the_late_terms_are_outweighed(gap: str, number: int) -> None:
    """500 kg late by 0.108 s in a slightly heavier hand: A + B exp(-s tau) turns with A from where |A| > |B| on."""
    late = (500 * s**2 + Rational("131.4") * s + 11691) * exp(-s * Rational("0.108"))
    loop = late + (500 + Rational(gap)) * s**2 + 100 * s + 20000
    sampled = late_mass((500, 131.4, 11691), (500 + float(gap), 100, 20000), 0.108)
    assert sampled is not None
    assert (roots(loop).number, windings.winding(*sampled)) == (number, number)
    placed = roots(expand(loop * s * (s**2 + 49) ** 2))  # three roots more, on the axis, two of them double
    assert (placed.number, placed.right, [float(x) for x in placed.on_axis]) == (number + 5, number, [0, 7])


def test_what_is_not_counted_says_so() -> None:
    for loop in (s + 2 + I, s + 3 + E + exp(-1000 * pi * s), s * (1 + E + E * LATE) + 1):
        with pytest.raises(hs.UndecidedError):
            roots(loop)


def test_beside_a_chain_a_delay_that_turns_thousands_of_times_is_not_counted() -> None:
    for mass in (Rational(1001, 1000), Integer(3)):
        with pytest.raises(UndecidedError, match="thousands of times"):
            roots((s**2 + s + 9) * exp(-(10**6) * s) + mass * s**2 + s + 4)


def test_a_delayed_spring_in_a_hand_is_stable_from_the_damping_that_the_field_knows() -> None:
    """100 N/m late by 36 ms in a hand of 0.5 kg: at b the pair is at omega, m omega^2 = k cos, b omega = k sin of omega tau."""

    def spring(b: str) -> int | None:
        return roots(100 * exp(-s * Rational(36, 1000)) + s**2 / 2 + Rational(b) * s).number

    with MP.workdps(30):
        w = MP.findroot(lambda w: w**2 / 2 - 100 * MP.cos(w * MP.mpf("0.036")), 13)
        critical = 100 * MP.sin(w * MP.mpf("0.036")) / w
        assert MP.nstr(critical, 17) == "3.4635997327677041"
        assert (
            spring(MP.nstr(critical - MP.mpf(10) ** -12, 25)),
            spring(MP.nstr(critical + MP.mpf(10) ** -12, 25)),
        ) == (2, 0)


@pytest.mark.parametrize("turns", [("1.6", 0), ("2.4", 0), (2, "0.4")])
def test_a_turn_that_is_near_no_whole_number_is_not_counted(turns: tuple[object, object]) -> None:
    with pytest.raises(UndecidedError, match="a turn"):
        contour.whole(flint.arb(*turns))
    assert [contour.whole(flint.arb(*x)) for x in (("1.7", 0), ("2.3", 0), (2, "0.3"))] == [2, 2, 2]


@pytest.mark.parametrize("seed", range(3))
def test_a_polynomial_turns_from_0_to_1_by_the_angles_of_its_linear_factors_at_1(seed: int) -> None:
    """k times some 1 + c x, |c| < 1: each stays on the right of the imaginary axis, their product need not."""
    draw = random.Random(seed)
    for count in (1, 2, 3, 4):
        side = draw.choice([-1, 1])
        places = [cmath.rect(draw.uniform(0.8, 0.95), side * draw.uniform(1.9, 2.6)) for _ in range(count)]
        row = cmath.rect(draw.uniform(0.1, 9), draw.uniform(-3, 3)) * np.poly([-c for c in places])
        terms = [(flint.acb(z.real, z.imag), n) for n, z in enumerate(row.tolist())]
        found = _turn_along(terms, flint.arb(0), flint.arb(1), 20)
        assert float(found.mid()) == pytest.approx(sum(cmath.phase(1 + c) for c in places), abs=1e-9)
        assert found.rad() < 1e-9


def test_a_delay_may_turn_two_thousand_radians_up_to_the_reach() -> None:
    """Of those that are there: the second delay is in no term."""
    ring: Any = SimpleNamespace(lags=(Integer(8), Integer(1000), pi))
    terms = {Integer(0): {(1, 0, 0): Integer(1), (0, 0, 2): Integer(3)}, Integer(1): {(0, 0, 0): Integer(2)}}
    _need_few_turns(Integer(250), terms, ring)
    for more in (Rational(251), 250 + Rational(1, 10**30)):
        with pytest.raises(UndecidedError, match="thousands of times"):
            _need_few_turns(more, terms, ring)


@pytest.mark.parametrize(
    ("lags", "chain"),
    [
        ((Integer(1), pi), RootChain.RIGHT),
        ((pi / 3, 2 * pi**2), RootChain.RIGHT),
        ((sqrt(2), 2 * sqrt(2)), None),  # z and z^2: 1 + 3 (z + z^2)/5 has its zeros at |z| = 1.29
        ((pi, 3 * pi), None),
        ((pi, 1 + pi), None),
    ],
)
def test_phases_oppose_where_delays_are_known_to_be_no_multiples_of_each_other(
    lags: tuple[Expr, Expr], chain: RootChain | None
) -> None:
    group = {(0, 0): Integer(1), (1, 0): Rational(3, 5), (0, 1): Rational(3, 5)}
    ring: Any = SimpleNamespace(lags=lags)
    if chain is not None:
        assert floor_of(group, ring) is chain
        return
    with pytest.raises(UndecidedError, match="several delays"):
        floor_of(group, ring)
