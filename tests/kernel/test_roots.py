"""Certified zeros: all zeros and poles of functions of omega on a band, none missed, none invented, orders and signs exact; crossings of scenes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import pairwise
from math import ceil, log, prod
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, arb_poly, fmpq, fmpz_poly
from hypothesis import given
from hypothesis import strategies as st
from marks import examples
from oracles import MP, rounded, sign
from scan import FAMILIES, Draw, disagreements
from sympy import Expr, Integer, Poly, Rational, Symbol, acos, asin, exp, expand, lambdify, pi, sqrt

import haptisym as hs
from haptisym import effects, environments
from haptisym.judge.crossings import noticed, opened
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.delayterms import WaveTerm
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.factors import AnalyticFactor, PolynomialFactor
from haptisym.kernel.reals import ExactNumber, bounds, dyadic
from haptisym.kernel.rings import c, omega, s
from haptisym.kernel.roots import Chart, Lattice, chart, in_order
from haptisym.kernel.solutions import solve
from haptisym.kernel.zeros import Undecided, Zero, clear_of, is_clear, isolated, sign_of, tightened
from haptisym.model import catalogue
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part

E, F = hs.environments, hs.effects
AXIS = Ring().axis
w = omega

Placed = tuple[Fraction, int]
"""A square of a frequency, and the order of the zero there (negative for a pole)."""


def function(expression: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(expression))


def charted(expression: Expr, low: object = 0, high: object = 100) -> Chart:
    return chart({"f": function(expression)}, Rational(str(low)), Rational(str(high)))


def inside(found: Chart) -> list[tuple[str, int]]:
    """Twelve digits of every point between the ends, and the order of the function there."""
    return [(p.omega.digits(12), p.orders.get("f", 0)) for p in found.points[1:-1]]


squares = st.builds(Fraction, st.integers(1, 900), st.integers(1, 40))

placements = st.lists(st.tuples(squares, st.integers(-3, 3).filter(bool)), max_size=5, unique_by=lambda z: z[0])


def placed(found: list[Placed], factor: int = 1, power: int = 0) -> Expr:
    W = omega**2
    return (
        factor
        * omega**power
        * prod(((W - Rational(w.numerator, w.denominator)) ** n for w, n in found), start=Integer(1))
    )


# Rational functions


@examples(40)
@given(placements, st.sampled_from([-2, 1, 3]), st.integers(-2, 3))
def test_zeros_and_poles_placed_on_a_band_are_all_found_with_their_orders_and_signs(
    found: list[Placed], factor: int, power: int
) -> None:
    both = {"f": function(placed(found, factor, power)), "nothing": function(Integer(0))}
    result = chart(both, Integer(0), Integer(100))
    first, *between = result.points[:-1]
    assert (first.orders.get("f", 0), float(first.omega)) == (power, 0.0)
    assert first.before["f"] == first.after["f"] * (-1) ** power
    assert [p.orders["f"] for p in between] == [n for _, n in sorted(found)]
    for point, (square, order) in zip(between, sorted(found), strict=True):
        low, high = point.omega.bounds(100)
        assert low**2 <= square <= high**2
        rest = factor * prod(sign(square - x) ** (n % 2) for x, n in found if x != square)
        assert (point.before["f"], point.after["f"]) == (sign(rest) * (-1) ** order, sign(rest))
        assert point.at["f"] == (0 if order > 0 or order % 2 else sign(rest))
        assert point.before["nothing"] == point.at["nothing"] == point.after["nothing"] == 0
    assert result.sign_changes("nothing") == ()
    assert [x for x in result.sign_changes("f") if x is not first] == [p for p in between if p.orders["f"] % 2]
    assert (first in result.sign_changes("f")) == power % 2


@given(
    st.lists(placements, min_size=2, max_size=3),
    st.fractions(0, 4, max_denominator=9),
    st.fractions(5, 9, max_denominator=9),
)
def test_a_set_of_frequencies_holds_those_whose_signs_pass_the_test(
    several: list[list[Placed]], low: Fraction, high: Fraction
) -> None:
    functions = {i: function(placed(found)) for i, found in enumerate(several)}
    result = chart(functions, Rational(low.numerator, low.denominator), Rational(high.numerator, high.denominator))

    def passes(signs: object) -> bool:
        return all(signs[i] <= 0 for i in functions)  # type: ignore[index]

    found = result.where(passes)
    for i in range(1, 200):
        at = low + (high - low) * Fraction(i, 200) + Fraction(1, 10**7)
        values = [prod(sign(at**2 - w) ** (n % 2) for w, n in placements) for placements in several]
        held = any(z.low.omega.bounds(80)[1] < at < z.high.omega.bounds(80)[0] for z in found)
        assert held == all(value <= 0 for value in values)


def test_intervals_are_as_few_as_possible_and_closed_where_the_test_holds_at_their_ends() -> None:
    # negative on (1, 2) and (2, 3), zero at 1, 2, 3; zero alone at 5
    W = omega**2
    found = charted((W - 1) * (W - 4) ** 2 * (W - 9) * (W - 25) ** 2, high=10)

    def spans(allowed: tuple[int, ...]) -> list[tuple[float, float]]:
        return [(float(z.low.omega), float(z.high.omega)) for z in found.where(lambda signs: signs["f"] in allowed)]

    assert spans((0, -1)) == [(1, 3), (5, 5)]
    assert spans((-1,)) == [(1, 2), (2, 3)]
    assert spans((1,)) == [(0, 1), (3, 5), (5, 10)]
    assert spans((0,)) == [(1, 1), (2, 2), (3, 3), (5, 5)]
    assert spans((1, 0, -1)) == [(0, 10)]


coefficients = st.lists(st.integers(-60, 60), min_size=2, max_size=9).filter(lambda c: c[0] and c[-1])


@given(coefficients)
def test_positive_roots_of_any_polynomial_are_as_many_as_sturm_counts(c: list[int]) -> None:
    polynomial = Poly(c, x)
    points = charted(polynomial.as_expr().subs(x, omega**2), high=1000).points
    assert len(points) - 2 == polynomial.count_roots(0, 10**6)
    assert sum(p.orders["f"] for p in points[1:-1]) == sum(
        n * f.count_roots(0, 10**6) for f, n in polynomial.sqf_list()[1]
    )


@given(coefficients)
def test_roots_are_those_of_mpmath(c: list[int]) -> None:
    _, factors = Poly(c, x).sqf_list()
    roots = [z for f, _ in factors for z in MP.polyroots([int(n) for n in f.all_coeffs()], maxsteps=500, extraprec=500)]
    expected = sorted(MP.sqrt(z.real) for z in roots if abs(z.imag) < MP.mpf(10) ** -40 and z.real > 0)
    found = charted(Poly(c, x).as_expr().subs(x, omega**2), high=1000).points[1:-1]
    assert [p.omega.digits(30) for p in found] == [rounded_like(w, 30) for w in expected]


def rounded_like(w: object, count: int) -> str:
    """As the package writes numbers between 1e-6 and 1e21: zeros shown."""
    text = rounded(w, count)
    missing = count - len(text.replace(".", "").lstrip("0"))
    return text + ("" if "." in text else "." * (missing > 0)) + "0" * missing


def test_neighbouring_roots_are_told_apart_however_near() -> None:
    near = Rational(1, 10**60)
    W = omega**2
    assert inside(charted((W - 4) * (W - 4 - near), high=9)) == [("2.00000000000", 1), ("2.00000000000", 1)]
    assert inside(charted(expand((W - 4) * (W - 4 - near)) - near**3, high=9)) == [
        ("2.00000000000", 1),
        ("2.00000000000", 1),
    ]
    assert inside(charted(expand((W - 4) ** 2) + near**3, high=9)) == []


def test_the_roots_of_wilkinson_s_polynomial_are_the_whole_numbers() -> None:
    polynomial = Poly(expand(prod(x - n for n in range(1, 21))), x)
    points = charted(polynomial.as_expr().subs(x, omega**2)).points[1:-1]
    assert [float(MP.mpf(p.omega.digits(40)) ** 2) for p in points] == list(range(1, 21))


def test_the_two_nearest_roots_of_mignotte_s_polynomial_are_found() -> None:
    polynomial = Poly(x**12 - 2 * (1000 * x - 1) ** 2, x)
    points = charted(polynomial.as_expr().subs(x, omega**2)).points[1:-1]
    assert len(points) == polynomial.count_roots(0, 10**4) == 3
    first, second = (p.omega.bounds(400) for p in points[:2])
    assert first[1] < second[0] < first[1] + Fraction(1, 10**19)


x = Symbol("x")


def irreducible(chance: random.Random) -> tuple[int, ...]:
    """Coefficients of up to 10^12, ascending; roots close together in every second case (Mignotte's)."""
    while True:
        n, size = chance.randint(2, 9), 10 ** chance.choice([1, 3, 12])
        row = [chance.randint(-size, size) for _ in range(n + 1)]
        if chance.random() < 0.5:
            a = chance.randint(2, 200)
            row = [-2, 4 * a, -2 * a * a, *[0] * (n - 2), 1] if n > 2 else row
        if row[0] and row[-1]:
            _, factors = fmpz_poly(row).factor()
            found = max((f for f, _ in factors), key=lambda f: f.degree())
            if found.degree() > 1:
                return tuple(map(int, found.coeffs()))


def drawn_dyadic(chance: random.Random) -> Fraction:
    return Fraction(chance.randint(0, 1 << 20), 1 << chance.randint(14, 24))


@pytest.mark.dear("2")
@pytest.mark.parametrize("step", [1, 2])
def test_each_interval_holds_one_zero_and_none_is_left_out(step: int) -> None:
    chance, seen = random.Random(10 + step), 0
    for turn in range(15):
        row = irreducible(chance)
        low, high = (Rational(y.numerator, y.denominator) for y in sorted((drawn_dyadic(chance), drawn_dyadic(chance))))
        if low == high:
            continue
        factor = PolynomialFactor(tuple((c,) for c in row), step)
        p = Poly(list(row[::-1]), x)
        found = factor.zeros(low, high)
        assert len(found) >= p.count_roots(low**step, high**step)
        for zero in found:
            ends = [Rational(*(int(y) for y in (e.fmpq().p, e.fmpq().q))) ** step for e in (zero.low, zero.high)]
            assert p.count_roots(*ends) == 1
            assert p.eval(ends[0]) * p.eval(ends[1]) < 0
            least, most = (Rational(y.numerator, y.denominator) ** step for y in zero.bounds(80))
            assert p.count_roots(least, most) == 1
        assert all(a.high <= b.low for a, b in pairwise(found))
        if turn % 5 == 0:  # searched as if it held waves
            searched = analytic(p.as_expr().subs(x, omega**step)).zeros(low, high)
            assert [z.digits(20) for z in searched] == [z.digits(20) for z in found]
        sign = factor.steady_sign(low, high)
        assert not sign or (not found and sign * p.eval(high**step) > 0)
        seen += len(found)
    assert seen > 4


@pytest.mark.parametrize(
    ("expression", "order", "signs"),
    [
        (omega**3, 3, (-1, 0, 1)), (omega**2, 2, (1, 0, 1)), (1 / omega, -1, (-1, 0, 1)), (-1 / omega**2, -2, (-1, -1, -1)),
        (omega * (omega**2 - 4), 1, (1, 0, -1)),
    ],
)  # fmt: skip
def test_at_rest_powers_of_omega_count_and_odd_ones_turn_the_sign(
    expression: Expr, order: int, signs: tuple[int, ...]
) -> None:
    point = charted(expression, high=1).points[0]
    assert point.orders.get("f", 0) == order
    assert (point.before["f"], point.at["f"], point.after["f"]) == signs


@pytest.mark.parametrize("digits", [0, 9, 30, 90])
def test_signs_after_a_zero_at_an_end_of_a_band_are_those_before_the_next_however_near_it_is(digits: int) -> None:
    """(omega - 5) (omega - 5 - 10^-n) (omega - 8) from 5 on, and its first and last factor alone."""
    near = 5 + Rational(1, 10**digits)
    made = {"f": (omega - 5) * (omega - near) * (omega - 8), "g": omega - 5, "h": 8 - omega}
    points = chart({name: function(expand(f)) for name, f in made.items()}, Integer(5), Integer(9)).points
    signs = {name: [(p.before[name], p.after[name]) for p in points] for name in made}
    assert signs == {
        "f": [(-1, 1), (1, -1), (-1, 1), (1, 1)],
        "g": [(-1, 1), (1, 1), (1, 1), (1, 1)],
        "h": [(1, 1), (1, 1), (1, -1), (-1, -1)],
    }


# pi, roots of numbers


def test_roots_with_pi_in_them_have_exact_orders() -> None:
    W = omega**2
    assert inside(charted(expand((W - pi**2) ** 2 * (W - pi) ** 3), high=9)) == [
        ("1.77245385091", 3),
        ("3.14159265359", 2),
    ]


def test_a_root_at_an_end_of_the_band_with_pi_in_it_is_that_end() -> None:
    points = chart({"f": function(omega**2 - 4 * pi**2)}, Integer(0), 2 * pi).points
    assert [p.orders.get("f", 0) for p in points] == [0, 1]
    assert (points[1].before["f"], points[1].at["f"], points[1].after["f"]) == (-1, 0, 1)
    short = chart({"f": function(omega**2 - 4 * pi**2)}, Integer(0), 2 * pi - Rational(1, 10**50)).points
    assert [p.orders.get("f", 0) for p in short] == [0, 0]


@pytest.mark.parametrize(
    ("constant", "expected"),
    [(4 - pi, 1), (pi - 4, -1), (pi - 3, 1), (1 / (3 - pi), -1), ((pi - 4) ** 2, 1), (-pi, -1)],
)
def test_a_constant_with_pi_in_it_gives_its_sign(constant: Expr, expected: int) -> None:
    points = charted(constant * (omega**2 - 4), high=9).points
    assert [p.after["f"] for p in points] == [-expected, expected, expected]
    assert [p.before["f"] for p in points] == [-expected, -expected, expected]


@pytest.mark.parametrize(
    ("c", "high"),
    [
        ((1, -pi, 1), 3),
        ((1, -3 * pi, pi**2, Rational(1, 2)), 4),
        ((pi, 0, -7, 1 - pi, 2), 4),
        ((1, 0, -pi, -(pi**3), 1), 5),
    ],
)
def test_roots_of_polynomials_with_pi_are_those_of_mpmath(c: tuple[Expr, ...], high: int) -> None:
    values = [evaluated(Integer(1) * z) for z in c]
    roots = MP.polyroots(values, maxsteps=500, extraprec=500)
    expected = sorted(MP.sqrt(z.real) for z in roots if abs(z.imag) < MP.mpf(10) ** -40 and z.real > 0)
    polynomial = sum(a * omega ** (2 * n) for n, a in enumerate(reversed(c)))
    points = charted(polynomial, high=high).points[1:-1]
    assert [p.omega.digits(30) for p in points] == [rounded_like(w, 30) for w in expected if w < high]
    assert points


def evaluated(z: Expr) -> object:
    """A number rational in pi, in mpmath."""
    p = Symbol("p")
    top, bottom = (Poly(e, p).all_coeffs() for e in z.subs(pi, p).together().as_numer_denom())
    values = [MP.polyval([MP.mpf(int(n.p)) / int(n.q) for n in c], MP.pi) for c in (top, bottom)]
    return values[0] / values[1]


def test_a_double_root_stays_double_and_a_near_double_one_does_not_with_pi_in_it() -> None:
    W = omega**2
    square = expand((W**2 - pi * W - 1) ** 2)
    [(_, order)] = inside(charted(square, high=9))
    assert order == 2
    split = inside(charted(square - Rational(1, 10**40), high=9))
    assert [order for _, order in split] == [1, 1]
    assert inside(charted(square + Rational(1, 10**40), high=9)) == []


# Functions known by their Taylor coefficients


def analytic(f: Expr, orders: tuple[Rational, ...] = ()) -> AnalyticFactor:
    """A polynomial in omega and pi, times a number > 0, as it is searched where there are delays; times omega to each power."""
    p = Symbol("p")
    rows = Poly(Poly(f.expand().subs(pi, p), omega, p).clear_denoms()[1].as_expr(), omega).all_coeffs()[::-1]
    coefficients = tuple(tuple(int(c) for c in Poly(row, p).all_coeffs()[::-1]) for row in rows)
    return AnalyticFactor((WaveTerm((), (1,) * len(orders), coefficients),), (), (), orders)


def with_roots(roots: Iterable[Fraction], sign: int = 1, orders: tuple[Rational, ...] = ()) -> AnalyticFactor:
    return analytic(sign * prod((omega - Rational(x) for x in roots), start=Integer(1)), orders)


def dyadic_near(x: float) -> Fraction:
    return Fraction(round(x * 2**40), 2**40)


@pytest.mark.parametrize("bits", [128, 512])
def test_a_zero_between_two_numbers_is_enclosed_as_tightly_as_asked_and_its_twins_are_not(bits: int) -> None:
    """Of polynomials of either sign, with twins outside: near, far, or none."""
    pick = random.Random(bits)
    for side in (1, -1) * 10:
        size = 10.0 ** pick.uniform(-3, 3)
        low = dyadic_near(size * pick.uniform(0.5, 1))
        high = low + dyadic_near(size * 10.0 ** pick.uniform(-3, 0)) + Fraction(1, 2**30)
        root = low + (high - low) * Fraction(pick.randint(1, 2**20 - 1), 2**20)
        gaps = [
            (high - low) * Fraction(pick.choice((1, 2**10, 2**18, 2**22)), 2**20) for _ in range(pick.randint(0, 3))
        ]
        roots = [root, *(low - gap if pick.random() < 0.5 else high + gap for gap in gaps)]
        low, high = sorted((side * low, side * high))

        def jet(x: Any, count: int, roots: list[Fraction] = roots, side: int = side) -> list[Any]:
            row = prod((arb_poly([x - side * dyadic(y), 1]) for y in roots), start=arb_poly([side]))
            return [*row.coeffs(), arb(0), arb(0), arb(0)][:count]

        with flint.ctx.workprec(bits):
            found = tightened(dyadic(low), dyadic(high), bits, jet)
        first, last = bounds(found)
        assert low <= first <= side * root <= last <= high
        assert found.rel_accuracy_bits() >= bits - 32


def test_where_the_working_precision_shows_no_more_the_enclosure_is_as_wide_as_that() -> None:
    """A factor of 2^-100 is lost in a sum with 1 that is taken away again: the sign is not known within 2^-28 of the zero."""
    root = Fraction(1, 3)

    def jet(x: Any, count: int) -> list[Any]:
        blurred = x + arb(0, 2.0**-28)
        return [(blurred - arb(fmpq(1, 3))) * (blurred - 3), 2 * blurred - arb(fmpq(1, 3)) - 3][:count]

    with flint.ctx.workprec(128):
        found = tightened(arb(0), arb(1), 128, jet)
        first, last = bounds(found)
    assert first <= root <= last
    assert last - first < Fraction(1, 2**24)
    assert first >= 0
    assert last <= 1


def test_a_zero_knows_more_digits_by_those_it_has() -> None:
    zero = Zero(with_roots([Fraction(5, 16), Fraction(11, 16), Fraction(3)]), arb("0.25"), arb("0.5"))
    for bits in (64, 129, 1000, 4096):
        ball = zero.ball(bits)
        first, last = bounds(ball)
        assert first <= Fraction(5, 16) <= last
        assert ball.rel_accuracy_bits() >= bits - 32
    slope = Zero(with_roots(map(Fraction, (1, 3, 20))), arb("1.5"), arb("2.5"), derivative=1)
    first, last = bounds(slope.ball(200))  # of x^3 - 24 x^2 + 83 x - 60, whose slope is 3 x^2 - 48 x + 83
    assert (3 * first**2 - 48 * first + 83) * (3 * last**2 - 48 * last + 83) < 0
    assert last - first < Fraction(1, 2**160)


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(24))
def test_all_zeros_of_a_function_are_isolated_and_no_others(seed: int) -> None:
    """Up to seven of them, some with a twin a millionth or a trillionth beside."""
    pick = random.Random(seed)
    roots = {dyadic_near(pick.uniform(0.1, 9.9)) for _ in range(pick.randint(0, 4))}
    roots |= {x + dyadic_near(10.0 ** pick.choice((-1, -3, -6, -9))) for x in list(roots)[: pick.randint(0, 3)]}
    outside = [Fraction(-1, 8), Fraction(10) + Fraction(1, 2 ** pick.randint(1, 20))]
    f = with_roots((*roots, *outside), pick.choice((-1, 1)))
    found = isolated(f, arb(0), arb(10))
    assert len(found) == len(set(found)) == len(roots)
    for zero, root in zip(found, sorted(roots), strict=True):
        first, last = bounds(zero.ball(256))
        assert 0 < first <= root <= last
    assert isolated(f, arb(5), arb(5)) == isolated(f, arb(6), arb(5)) == []


@pytest.mark.parametrize("seed", range(8))
def test_beside_powers_of_omega_zeros_are_the_same_over_many_decades_also_where_the_band_is_cut(seed: int) -> None:
    pick = random.Random(seed)
    low, high = 10.0 ** pick.uniform(-5, 0), 10.0 ** pick.uniform(0.1, 2)
    roots = {dyadic_near(low * (high / low) ** pick.random()) for _ in range(pick.randint(1, 4))}
    if seed % 2:  # where pieces end that are no wider than that
        low, high, count = 1.0, 16.0, ceil(log(16) / log(with_roots([], orders=(Rational(1, 3),)).largest_ratio or 2))
        with flint.ctx.workprec(128):
            places = [(arb(16).log() * n / count).exp().mid() for n in range(1, count)]
        roots = {Fraction(int(m)) * Fraction(2) ** int(e) for m, e in (x.man_exp() for x in places)}
    f = with_roots(roots, orders=(Rational(1, 3),))
    assert [float(x) for x in isolated(f, arb(low), arb(high))] == sorted(map(float, roots))


@pytest.mark.parametrize("side", [1, -1])
def test_a_pair_that_is_none_is_no_zero_and_a_double_one_is_undecided(side: int) -> None:
    """(x - 1)^2 + c, with c a little positive, a little negative, or nothing."""
    near = Rational(1, 2**90)
    for depth, count in ((near, 0), (-near, 2), (Rational(1, 4), 0), (-Rational(1, 4), 2)):
        assert len(isolated(analytic(side * ((omega - 1) ** 2 + depth)), arb(0), arb(3))) == count
    [double] = isolated(analytic(side * (omega - 1) ** 2), arb(0), arb(3))
    assert isinstance(double, Undecided)
    assert abs(float(double.ball(128).mid()) - 1) < 1e-15
    assert double.factor.multiplicity(double) == 2
    # one that rises or falls all the way on a piece that bends
    bowl = analytic(side * ((omega - 1) ** 2 - Rational(1, 4)))
    assert [len(isolated(bowl, arb(low), arb(high))) for low, high in ((1, 3), (2, 3), (-1, 0))] == [1, 0, 0]


def test_a_triple_zero_is_said_to_be_undecided() -> None:
    with pytest.raises(hs.UndecidedError, match=r"how often a function vanishes near omega = (1|0\.99999)"):
        isolated(analytic((omega - 1) ** 3), arb(0), arb(3))


def test_a_piece_is_cut_where_the_function_is_not_zero() -> None:
    """Zeros at 127/256 and 131/256 of a band, where it would be cut first."""
    for roots in ((127, 30), (127, 131, 200), (127, 131, 113, 20)):
        found = isolated(with_roots(Fraction(n, 256) for n in roots), arb(0), arb(1))
        assert [round(float(zero) * 256) for zero in found] == sorted(roots)


@pytest.mark.dear("pi-False", "pi-True")
@pytest.mark.parametrize("above", [True, False])
@pytest.mark.parametrize("place", [Integer(2), Rational(1, 3), pi], ids=str)
def test_a_number_clear_of_a_zero_of_known_order_has_no_other_zero_before_it(place: Expr, *, above: bool) -> None:
    """A zero of order 0, 1 or 2 at the place, another one 2^-20 beside it on either side."""
    with flint.ctx.workprec(256):
        centre = ExactNumber(place).ball(256)
    near = Rational(1, 2**20)
    for order in (0, 1, 2):
        v = omega - place
        f = analytic(v**order * (v - near) * (v + near) * (v - 5))
        end = clear_of(f, place, order, arb(1), above=above)
        assert end.is_exact()
        assert 0 < Rational(float((end - centre) if above else (centre - end))) < near
    with pytest.raises(hs.UndecidedError, match="vanishes again"):
        clear_of(analytic((omega - place) ** 2), place, 1, arb(1), above=above)


def test_numbers_are_put_in_order_whether_their_brackets_meet_or_not() -> None:
    """Brackets far apart, one inside the other, zeros 2^-200 apart; of two that are equal it is undecided."""
    near = Fraction(1, 2) + Fraction(1, 2**200)
    numbers = {
        Zero(with_roots([root]), arb(low), arb(high)): root
        for root, low, high in (
            (Fraction(5), "4", "6"), (Fraction(1, 2), "0.25", "3"), (Fraction(7, 8), "0.75", "1"), (near, "0.25", "0.75"),
            (Fraction(2), "1.5", "9"), (Fraction(1, 8), "0", "0.25"),
        )
    }  # fmt: skip
    for seed in range(5):
        listed = random.Random(seed).sample(list(numbers), len(numbers))
        assert [numbers[x] for x in in_order(listed)] == sorted(numbers.values())
    twins = [Zero(with_roots([Fraction(1, 2), Fraction(2)]), arb(0), arb(1)) for _ in range(2)]
    with pytest.raises(hs.UndecidedError, match=r"whether two frequencies near 0\.5"):
        in_order([*twins, ExactNumber(Integer(3))])


def test_the_sign_of_a_ball_is_that_of_all_its_numbers() -> None:
    for ball, expected in [
        (arb(2), 1), (arb("1e-300"), 1), (arb(3, 2.9), 1), (arb(-1), -1), (-arb("1e-300"), -1), (arb(0), 0), (arb(1, 2), 0),
        (arb(-1, 1), 0), (arb(1, 1), 0), (arb("nan"), 0), (arb(0, 1).log(), 0), (arb(0, float("inf")), 0),
    ]:  # fmt: skip
        assert (sign_of(ball), is_clear(ball)) == (expected, expected != 0)


# Delays, powers of s


def test_beside_powers_a_zero_has_the_least_order_of_what_stands_with_each_power() -> None:
    """omega^(1/4) sin^k omega + sin omega cos^(k - 1) omega at pi: of order 1; with sin^2 beside both, of order 2."""

    def order(one: int, other: int, degree: int) -> int:
        terms = WaveTerm((one,), (1,), ((1,),)), WaveTerm((other,), (0,), ((1,),))
        return AnalyticFactor(terms, ((Integer(2), False),), (degree,), (Rational(1, 4),)).order_at(pi)

    assert [order(2, 1, 2), order(1, 3, 3), order(2, 2, 2), order(3, 2, 4)] == [1, 1, 2, 2]


@pytest.mark.parametrize(("power", "k", "square"), [(1, 4, Fraction(4, 9)), (-1, 4, Fraction(9, 4))])
def test_the_parts_of_a_root_of_s_reach_a_level_where_its_modulus_says(power: int, k: int, square: Fraction) -> None:
    """Re = |Im| = 3 (omega/2)^(+-1/2); its square is k/2 at one omega."""
    f = 3 * s ** Rational(power, 2)
    parts = on_axis(Ring.of([f]).convert(f))
    level = parts.real * parts.real - RealFunction(parts.real.axis.convert(Rational(k, 2)))
    rest, point, _ = chart({"re": parts.real, "im": parts.imag, "level": level}, Integer(0), Integer(9)).points
    assert (rest.orders["re"], rest.orders["im"], rest.after["re"], rest.after["im"]) == (power, power, 1, power)
    low, high = point.omega.bounds(60)
    assert low <= square <= high
    assert (point.before["level"], point.after["level"]) == (-power, power)


def test_a_tangency_that_stays_undecided_says_of_which_function_and_keeps_its_sign() -> None:
    """1 + cos(omega) + (omega^2 - pi^2)^2 touches 0 at pi, where no finite number of digits shows it; its neighbour does not."""
    f = 1 + exp(-s) + (s**2 + pi**2) ** 2
    touching = on_axis(Ring.of([f]).convert(f)).real
    other = RealFunction(touching.axis.convert(omega**2 - 9))
    for factor in (1, -1):
        turned = RealFunction((touching.function * touching.axis.convert(Integer(factor))).reduced())
        pieces = {
            "smaller": Lattice(((turned, other),)),
            "larger": Lattice.largest([turned, other]),
        }  # other is positive there
        table = chart({"touch": turned, "other": other, "both": turned * other, **pieces}, Integer(1), Integer(5))
        before, point = table.points[1:-1]
        assert (before.undecided, before.orders) == (
            frozenset(),
            {"other": 1, "both": 1, "smaller" if factor > 0 else "larger": 1},
        )
        assert float(point.omega) == pytest.approx(float(pi))
        assert point.undecided == {"touch", "both", "smaller"}
        assert (point.orders["touch"], point.orders["both"]) == (2, 2)
        assert [p.after["touch"] for p in table.points] == [factor] * 4
        assert [p.after["both"] for p in table.points] == [-factor, factor, factor, factor]
        assert table.undecided == (point,)


def test_powers_of_omega_beside_whole_ones_have_no_other_side_at_rest() -> None:
    """s + s^(3/2): Im is omega (1 + sqrt(omega/2)) or so; s^(1/2) alone, and times s."""
    for f, order in ((s + s ** Rational(3, 2), 1), (sqrt(s), 1), (s * sqrt(s), 2), (s**2 + s ** Rational(1, 2), 1)):
        response = on_axis(Ring.of([f]).convert(f))
        for part in (response.imag, response.real):
            point = chart({"f": part}, Integer(0), Rational(1, 10**6)).points[0]
            assert point.before["f"] == point.after["f"] != 0
        assert chart({"f": response.imag}, Integer(0), Rational(1, 10**6)).points[0].orders["f"] == order


@pytest.mark.parametrize(
    ("f", "order"),
    [
        (1 - exp(-s), 1),
        ((1 - exp(-s)) ** 2, 2),
        (s * (1 - exp(-s)), 2),
        (s**2 - (1 - exp(-s)) ** 2, 3),
        (1 / (1 - exp(-s)), -1),
    ],
)
def test_orders_at_rest_count_what_delays_bring(f: Expr, order: int) -> None:
    """|f|^2 has twice the order of f."""
    dynamics = Ring.of([f]).convert(f).reduced()
    point = chart({"f": squared_modulus(dynamics)}, Integer(0), Rational(1, 10)).points[0]
    assert point.orders["f"] == 2 * order
    assert (point.before["f"], point.after["f"]) == (1, 1)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(16))
def test_zeros_of_one_half_angle_are_where_the_function_changes_sign(seed: int) -> None:
    draw = random.Random(seed)
    a, b, tau = draw.randint(-5, 5), draw.choice([-3, 2, 7]), Rational(draw.randint(1, 9), 7)
    x = a + b * exp(-tau * s) + draw.choice([0, 4]) * exp(-2 * tau * s)
    f = on_axis(Ring.of([x]).convert(x)).real
    low, high = Rational(draw.randint(0, 9), 2), Rational(draw.randint(20, 50), 2)
    table = chart({"it": f}, low, high)
    places = [float(p.omega) for p in table.points[1:-1] if p.orders["it"] % 2]
    grid = np.linspace(float(low), float(high), 40_001)
    own = np.real(
        a + b * np.exp(-1j * float(tau) * grid) + float(x.coeff(exp(-2 * tau * s))) * np.exp(-2j * float(tau) * grid)
    )
    changes = grid[1:][np.sign(own[1:]) * np.sign(own[:-1]) < 0]
    assert len(places) == len(changes)
    assert np.allclose(places, changes, atol=2e-3)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(12))
def test_products_of_waves_are_zero_or_infinite_where_their_factors_are_and_as_often(seed: int) -> None:
    """Half turns of a delay are places like any other: 1 + cos is zero twice there, and what is divided by it has a pole."""
    draw = random.Random(seed)
    tau = draw.choice([Rational(1), Rational(3, 2), Rational(2, 5)])
    response = on_axis(Ring.of([exp(-tau * s)]).convert(exp(-tau * s)))
    axis = response.real.axis
    one, rest = axis.convert(Integer(1)), axis.convert(w**2 - 2)
    cosine, sine = response.real.function, response.imag.function  # of which the sine has a minus
    powers = dict(zip((one + cosine, one - cosine, sine, rest), (draw.randint(-2, 2) for _ in range(4)), strict=True))
    whole = one
    for f, n in powers.items():
        whole = whole * f**n if n >= 0 else whole / f**-n
    up, down, odd, own = powers.values()
    table = chart({"f": RealFunction(whole.reduced())}, Integer(0), Integer(10))
    found = {float(p.omega): int(p.orders.get("f", 0)) for p in table.points[:-1]}
    turns = [k * math.pi / float(tau) for k in range(100) if k * math.pi / float(tau) < 10]
    true = {x: 2 * (up if k % 2 else down) + odd for k, x in enumerate(turns)} | {math.sqrt(2): own}
    true = {x: n for x, n in sorted(true.items()) if n or x == 0}
    assert [*found] == pytest.approx([*true], rel=1e-12)
    assert [*found.values()] == [*true.values()]
    for a, b in pairwise(table.points):
        at = (float(a.omega) + float(b.omega)) / 2
        sign = (-math.sin(at * float(tau))) ** odd * (at**2 - 2) ** own
        assert a.after["f"] == b.before["f"] == math.copysign(1, sign)


def test_a_zero_at_five_quarters_beside_powers_of_omega_is_one_like_any_other() -> None:
    """There it is looked whether powers cancel everywhere."""
    x = (16 * s**2 + 25) * (s ** Rational(1, 2) + 1)
    f = on_axis(Ring.of([x]).convert(x.expand())).imag
    table = chart({"it": f}, Integer(1), Integer(2))
    assert [(float(p.omega), p.before["it"], p.after["it"]) for p in table.points[1:-1]] == [(1.25, 1, -1)]


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(16))
def test_zeros_as_formulas_are_those_of_a_chart(seed: int) -> None:
    draw = random.Random(seed)
    kind = seed % 4
    if kind == 0:
        f = (draw.randint(-5, 5) + draw.randint(-5, 5) * omega**2 + draw.choice([0, 1, -2]) * omega**4) * (
            omega**2 + draw.randint(-4, 3)
        )
        ring = Ring.of([])
        function = RealFunction(ring.axis.convert(f + 0 * omega).reduced())
    else:
        x = (
            draw.randint(-3, 3) + draw.randint(1, 4) * exp(-s * Rational(draw.randint(1, 5), 2)),
            draw.randint(-3, 3) + 2 * exp(-s / 2) + draw.randint(-1, 1) * exp(-s),
            draw.randint(1, 5) * s ** Rational(draw.randint(1, 4), 5) * s + draw.randint(-5, 5),
        )[kind - 1]
        response = on_axis(Ring.of([x]).convert(x))
        function = draw.choice([response.real, response.imag])
    if function.is_zero:
        return
    high = Integer(12)
    table = chart({"": function}, Integer(0), high)
    true = {round(float(p.omega), 9): p.orders[""] for p in table.points[1:-1] if p.orders.get("", 0) > 0}
    found: dict[float, int] = {}
    for told in solve(function):
        if told.omega is None:
            return
        start, period = complex(told.omega.evalf(20)), float(told.period)
        if abs(start.imag) > 1e-12:
            continue
        turns = range(-3, 200) if period else range(1)
        for n in turns:
            w = start.real + n * period
            if 1e-9 < w < 12 - 1e-9:
                found[round(w, 9)] = max(found.get(round(w, 9), 0), told.order)
    assert sorted(found) == pytest.approx(sorted(true), abs=1e-7)
    assert [found[x] for x in sorted(found)] == [true[x] for x in sorted(true)]


# Signs far out


def far_out(draw: random.Random) -> Expr:
    """Powers of s with numbers before them, one or two delays, and perhaps a power s^alpha in all of it."""
    lags = draw.choice([[Rational(1, 2)], [Rational(1, 3), Rational(1, 2)], [Integer(1), pi]])
    late = [exp(-x * s) for x in lags]
    top = draw.choice([s, s**2, s**2 * s ** Rational(1, 3), s ** Rational(1, 2)])
    lead = (
        draw.choice([-5, -1, 2, 3])
        + sum((draw.choice([-2, -1, 0, 1, 3]) * x for x in late), Integer(0))
        + draw.choice([0, 1]) * late[0] ** 2
    )
    return (
        top * lead
        + draw.choice([-9, 40]) * s ** Rational(1, 4) * late[-1]
        + draw.choice([pi, -30]) * late[0]
        + draw.randint(-9, 9)
    ).expand()


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(16))
def test_signs_far_out_are_those_of_samples(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(1):
        x = far_out(draw)
        assert x.has(s)
        value, response = lambdify(s, x), on_axis(Ring.of([x]).convert(x))
        for raw, part in ((response.raw_real, np.real), (response.raw_imag, np.imag)):
            found = asymptotic_sign(raw)
            begin = max(1e9, float(found.radius))
            grid = np.linspace(begin, begin + 4000, 8001)
            own = part(value(1j * grid))
            lead = float(raw_degree(x))
            own = own / grid**lead
            low, high, size = own.min(), own.max(), abs(own).max()
            if found.sense in (Sense.POSITIVE, Sense.NEGATIVE):
                assert low * found.sense.value > -1e-3 * size
                assert high * found.sense.value > -1e-3 * size
                beyond = float(found.radius) * np.concatenate(
                    [1 + np.linspace(1e-9, 3, 8001), np.logspace(0.6, 3, 2001)]
                )
                near = part(value(1j * beyond)) * found.sense.value
                assert (near > -1e-9 * abs(near).max()).all()
                assert found.radius > 0
            elif found.sense is Sense.BOTH:
                assert low < 1e-3 * size
                assert high > -1e-3 * size
            if low > 0.3 * size or high < -0.3 * size:
                assert found.sense in (Sense.POSITIVE if low > 0 else Sense.NEGATIVE, Sense.UNKNOWN)
            if low < -0.2 * size and high > 0.2 * size:
                assert found.sense is Sense.BOTH


def test_what_stands_still_prevails_over_what_is_less_than_it_exceeds_its_waves_by() -> None:
    """omega^2 (5 - cos omega - 2 cos 2 omega) - k: at least 2 omega^2, and nothing is given away."""
    lead = s**2 * (5 - exp(-s) - 2 * exp(-2 * s))
    ring = Ring.of([lead])
    whole = ring.convert(lead.expand())
    for n in range(8):
        k = Rational(round(2**10 * 2 ** (n / 4)), 2**6)
        found = asymptotic_sign(on_axis(-whole - ring.convert(k)).raw_real)
        assert found.sense is Sense.POSITIVE
        assert k < 2 * found.radius**2 <= 4 * k


def raw_degree(x: Expr) -> Rational:
    """The highest power of s."""
    return max(
        (
            term.subs(dict.fromkeys(term.atoms(exp), 1)).as_coeff_Mul()[1].as_base_exp()[1]
            if term.subs(dict.fromkeys(term.atoms(exp), 1)).has(s)
            else Integer(0)
        )
        for term in x.as_ordered_terms()
    )


def test_where_the_highest_waves_touch_0_nothing_is_said() -> None:
    """omega^3 (1 + cos 2 omega) + omega cos 2 omega: 2 omega^3 + omega at n pi, -omega between."""
    x = -(s**3) * (1 + exp(-2 * s)) + s * exp(-2 * s)
    assert asymptotic_sign(on_axis(Ring.of([x]).convert(x.expand())).raw_imag).sense is Sense.UNKNOWN


# What is positive where all pieces of some term are


@pytest.mark.dear("2")
@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(16))
def test_signs_of_a_lattice_are_those_of_its_pieces(seed: int) -> None:
    draw = random.Random(seed)
    roots = list(range(1, 8))

    def piece() -> Expr:
        found: Expr = Integer(draw.choice([-2, 1]))
        for _ in range(draw.randint(1, 3)):
            found *= (w - draw.choice(roots)) ** draw.choice([1, 1, 2, -1])
        return found

    terms = [[piece() for _ in range(draw.randint(1, 3))] for _ in range(draw.randint(1, 3))]
    lattice = Lattice(tuple(tuple(RealFunction(AXIS.convert(x).reduced()) for x in term) for term in terms))
    table = chart({"it": lattice}, Rational(1, 2), Integer(8))

    def value(at: Rational) -> int:
        rows = [[float(x.subs(w, at)) for x in term] for term in terms]
        return max(min(int(y > 0) - int(y < 0) for y in row) for row in rows)

    places = [Rational(round(float(p.omega) * 2), 2) for p in table.points]
    assert [abs(float(p.omega) - float(x)) < 1e-9 for p, x in zip(table.points, places, strict=True)] == [True] * len(
        places
    )
    for a, b, point in zip(places, places[1:], table.points, strict=False):
        for n in (1, 8):
            assert value(a + (b - a) * Rational(n, 9)) == point.after["it"]
    for at, point in zip(places[1:-1], table.points[1:-1], strict=True):
        beside = value(at - Rational(1, 9)), value(at + Rational(1, 9))
        assert (point.before["it"], point.after["it"]) == beside
        order = point.orders.get("it", 0)
        finite = all(x.as_numer_denom()[1].subs(w, at) != 0 for term in terms for x in term)
        if finite:
            assert point.at["it"] == value(at)
            assert order > 0 or value(at) != 0 or beside == (0, 0)
            assert not order or order % 2 == (beside[0] != beside[1])
    kept = table.where(lambda signs: signs["it"] <= 0)
    for n in range(41, 640, 23):
        at = Rational(n, 80)
        if at not in places:
            assert any(float(x.low.omega) <= at <= float(x.high.omega) for x in kept) == (value(at) <= 0)


@pytest.mark.parametrize("group", range(4))
def test_a_lattice_has_a_pole_where_it_grows_without_bound_on_a_side(group: int) -> None:
    """Not where a piece does that is outweighed: of the smaller the one that goes to infinity, of the larger the one that goes below all."""
    for seed in range(4 * group, 4 * group + 4):
        draw = random.Random(seed)
        terms = [[with_a_pole(draw) for _ in range(draw.randint(1, 3))] for _ in range(draw.randint(1, 3))]
        lattice = Lattice(tuple(tuple(RealFunction(AXIS.convert(x).reduced()) for x in term) for term in terms))
        table = chart({"it": lattice}, Rational(1, 2), Integer(5))
        seen = {float(p.omega): p.orders.get("it", 0) for p in table.points}
        for place in (1, 2, 3, 4):
            near = [place + sign * Rational(1, 10**9) for sign in (-1, 1)]
            sides = [max(min(x.subs(w, at) for x in term) for term in terms) for at in near]
            if max(map(abs, sides)) > 10**6:
                assert seen[place] == (-1 if sides[0] * sides[1] < 0 or 0 in sides else -2)
            else:
                assert seen.get(place, 0) >= 0


def with_a_pole(draw: random.Random) -> Expr:
    factor = (w - draw.choice([1, 2, 3, 4])) ** draw.choice([-2, -1, -1, 1, 2])
    return Integer(draw.choice([-2, -1, 1, 3])) * factor + draw.choice([0, 0, 1])


def test_the_largest_of_functions_is_positive_where_any_of_them_is() -> None:
    any_of = Lattice.largest(RealFunction(AXIS.convert(x)) for x in (w - 3, 2 - w, (w - 5) ** 2 - 9))
    points = chart({"it": any_of}, Integer(1), Integer(9)).points
    assert [(float(p.omega), p.after["it"]) for p in points[:-1] if p.before["it"] != p.after["it"]] == [
        (2, -1),
        (3, 1),
    ]
    assert points[0].before["it"] == 1


def test_a_zero_of_a_lattice_is_as_manifold_as_that_of_the_term_that_vanishes() -> None:
    """max(min(w - 3, -1), (w - 3)^3) is (w - 3)^3 there."""
    terms = [[w - 3, Integer(-1)], [(w - 3) ** 3]]
    lattice = Lattice(tuple(tuple(RealFunction(AXIS.convert(x).reduced()) for x in term) for term in terms))
    [place] = chart({"it": lattice}, Rational(1, 2), Integer(8)).points[1:-1]
    assert (float(place.omega), place.orders["it"]) == (3, 3)


# Crossings of scenes


PAPER = E.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")

FILTER = F.second_order_lowpass("80 rad/s", "0.5")


@pytest.mark.dear("four-channel and delay-11")
@pytest.mark.few(8)
@pytest.mark.parametrize("turn", range(12))
@pytest.mark.parametrize("family", FAMILIES)
def test_a_scan_in_floats_and_mpmath_finds_nothing_to_deny(family: str, turn: int) -> None:
    """Three hundred random scenes: every crossing, cell, percept and active band is confirmed at hundreds of frequencies."""
    case = Draw(1000 * list(FAMILIES).index(family) + turn).case(family)
    try:
        result = hs.evaluate(hs.parse_scene(case.text))
    except hs.UndecidedError:  # an honest answer, but not one of a random scene
        pytest.fail("a random scene stayed undecided")
    assert disagreements(case, result, count=300) == []


@pytest.mark.slow
@pytest.mark.parametrize("k", range(13))
def test_the_pair_beside_a_lightly_damped_resonance_is_found(k: int) -> None:
    environment = E.mass_spring_damper("1.8 kg", Rational(1, 10**k), "100 N/m")
    scene = hs.Scene(environment, (FILTER, F.delay("1 ms")), (0, 15), hs.Threshold.of("0.05"))
    result = hs.evaluate(scene)
    assert result.certified
    near = [
        c
        for c in result.crossings
        if c.part is hs.Part.REAL and abs(float(c.omega) - np.sqrt(100 / 1.8)) < 2 * 10.0**-k
    ]
    if k >= 2:
        assert [c.kind.value for c in near] == ["exceeds", "returns"]
        [low, high] = (c.omega.bounds(200)[0] for c in near)
        assert 0.3 * 10.0**-k < float(high - low) < 3 * 10.0**-k
    if k == 6:
        f = scene.distortion().compile()
        assert not (f(np.linspace(1e-3, 15, 1_000_000)).ratio_real > 0.05).any(), "a grid of a million points misses it"


def test_a_zero_with_a_twin_beside_it_is_not_taken_for_the_other() -> None:
    """Two crossings 6e-11 apart beside a resonance, each where mpmath has it."""
    scene = hs.parse_scene(
        '[environment]\nmodel = "mass-spring-damper"\nm = "6.3"\nb = "0.0013"\nk = "720"\n'
        '[[effects]]\nmodel = "compliance"\nk = "15000"\n[[effects]]\nmodel = "zero-order-hold"\nT = "0.0007814"\n'
        '[evaluation]\nband = ["26 rad/s", "1300 rad/s"]\njnd = { real = "0.066", imag = "0.73" }'
    )
    first, second = [c for c in hs.evaluate(scene).crossings if c.part is hs.Part.REAL]
    assert first.omega.digits(12) == "49.9523562402"
    assert 5e-11 < float(second.omega) - float(first.omega) < 7e-11


@pytest.mark.parametrize("turns", [1, 10, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_long_delay_on_a_spring_crosses_at_all_its_inverse_sines(turns: int) -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay(1),), (0, turns))
    found = [float(c.omega) for c in hs.evaluate(scene).crossings if c.part is hs.Part.IMAG]
    first = np.arcsin(0.1)
    expected = sorted(x for n in range(turns + 2) for x in (n * np.pi + first, n * np.pi - first) if 0 < x < turns)
    assert found == pytest.approx(expected, rel=1e-13)


def test_commensurable_delays_add_up() -> None:
    one = hs.evaluate(hs.Scene(PAPER, (FILTER, F.delay("3 ms")), (0, 150)))
    two = hs.evaluate(hs.Scene(PAPER, (F.delay("1 ms"), FILTER, F.delay("2 ms")), (0, 150)))
    assert [c.omega.digits(40) for c in one.crossings] == [c.omega.digits(40) for c in two.crossings]


@pytest.mark.parametrize(("c", "crossings"), [("2", None), ("1.999999999999", 2), ("2.000000000001", 0)])
def test_a_tangency_of_a_delayed_scene_is_said_to_be_open(c: str, crossings: int | None) -> None:
    """r_r = 1 - cos(omega tau) has its maximum 2 at pi/tau."""
    scene = hs.Scene(E.mass_spring_damper(k=1), (F.delay(1),), (0, 6), hs.Threshold.of(c, 5))
    result = hs.evaluate(scene)
    if crossings is None:
        [touch] = [x.omega for x in result.crossings] or [point.omega for _, point in result.undecided]
        assert float(touch) == pytest.approx(np.pi, rel=1e-12)
        assert [x.kind.value for x in result.crossings] in ([], ["touches"])
    else:
        assert result.certified
        assert len(result.crossings) == crossings


def test_three_hundred_digits_of_a_delayed_crossing_are_those_of_the_inverse_sine() -> None:
    scene = hs.Scene(E.mass_spring_damper(k=100), (F.delay("0.25"),), (0, 5))
    [crossing] = [c for c in hs.evaluate(scene, 300).crossings if c.part is hs.Part.IMAG]
    with mpmath.workdps(320):
        assert crossing.omega.digits(300) == mpmath.nstr(4 * mpmath.asin(mpmath.mpf(1) / 10), 300, strip_zeros=False)


@pytest.mark.parametrize(
    ("long", "short"), [("10 ms", "0.01 ms"), pytest.param("10 s", "1 ns", marks=pytest.mark.slow)]
)
def test_a_delay_that_is_thousands_of_another_one_keeps_a_variable_of_its_own(long: str, short: str) -> None:
    """Not a power of the short one's, of degree 1000 and more: a delay of next to nothing moves the crossings by as little."""
    wall = hs.environments.mass_spring_damper("1.8 kg", "15 N*s/m", "100 N/m")
    both, alone = (
        hs.evaluate(hs.Scene(wall, effects, (0, 3))).crossings
        for effects in ((hs.effects.delay(long), hs.effects.delay(short)), (hs.effects.delay(long),))
    )
    assert [c.part for c in both] == [c.part for c in alone]
    for one, other in zip(both, alone, strict=True):
        assert float(one.omega) == pytest.approx(float(other.omega), rel=2e-3)


@pytest.mark.few(3)
@pytest.mark.parametrize("band", [("25 Hz", "75 Hz"), ("0 Hz", "25 Hz"), ("12.5 Hz", "100 Hz")])
@pytest.mark.parametrize(
    "environment", [hs.environments.mass_spring_damper(k=100), hs.environments.spring_pot(100, "0.3")]
)
def test_a_band_may_end_where_the_phase_of_a_delay_is_a_quarter_turn(
    environment: hs.Environment, band: tuple[str, str]
) -> None:
    """There Re H_perc of a spring vanishes exactly: an end of the band is a zero, not an undecided sign."""
    found = hs.evaluate(hs.Scene(environment, (hs.effects.delay("10 ms"),), band))
    assert found.certified
    wider = hs.evaluate(hs.Scene(environment, (hs.effects.delay("10 ms"),), ("0 Hz", "101 Hz"))).crossings
    low, high = (float(x) for x in found.scene.band)
    inside = [float(c.omega) for c in wider if low <= float(c.omega) <= high]
    assert [float(c.omega) for c in found.crossings] == pytest.approx(inside, rel=1e-12)


@pytest.mark.parametrize(("order", "c"), [("0.5", 19), ("1.5", 2)])
def test_half_orders_that_change_both_parts_alike_are_undecided(order: str, c: int) -> None:
    """Re = +-Im of c (j omega)^(n + 1/2): both ratios meet their thresholds at one frequency, by two functions."""
    scene = hs.Scene(E.kelvin_voigt(341, Rational("16.2")), (F.shunt(Z=f"{c}*s^{order}"),), (0, 15))
    with pytest.raises(hs.UndecidedError, match="are the same"):
        hs.evaluate(scene)


Dynamics = Callable[[mpmath.mpc, mpmath.mpc], mpmath.mpc]
"""What is felt of a dynamics, and s."""

ORDERS = ("1/2", "1/4", "3/4", "1/3", "2/3", "1/8", "2/5", "0.3", "0.37")


def an_effect(draw: random.Random) -> tuple[hs.Effect, Dynamics]:
    k, b = draw.choice([200, 500, 900]), draw.choice([1, 2, 10])
    power = Rational(draw.choice(ORDERS))
    exponent = mpmath.mpf(power.p) / power.q
    return draw.choice(
        [
            (effects.compliance(k=k), lambda h, s: h / (1 + h / k)),
            (effects.compliance(b=k), lambda h, s: h / (1 + h / (k * s))),
            (effects.compliance(k=k, b=b), lambda h, s: h / (1 + h / (k + b * s))),
            (effects.shunt(b=b), lambda h, s: h + b * s),
            (effects.shunt(m="0.1", b=b), lambda h, s: h + s * s / 10 + b * s),
            (effects.shunt(k=-b), lambda h, s: h - b),
            (effects.first_order_lag(k), lambda h, s: h * k / (k + s)),
            (effects.series(10 / (10 + hs.s**power)), lambda h, s: h * 10 / (10 + s**exponent)),
        ]
    )


def with_spring_pot(draw: random.Random) -> tuple[hs.Scene, Callable[[mpmath.mpf], dict[Part, mpmath.mpf]]]:
    """A scene with a spring-pot, and the excess r - c of both parts at a frequency, written out once more."""
    order, size, k = Rational(draw.choice(ORDERS)), draw.choice([1, 5, 80]), draw.choice([0, 0, 50])
    chain = [an_effect(draw) for _ in range(draw.randint(1, 2))]
    environment = environments.spring_pot(size, order, k) if k else environments.spring_pot(size, order)

    def excess(w: mpmath.mpf) -> dict[Part, mpmath.mpf]:
        s = mpmath.mpc(0, w)
        own = felt = k + size * s ** (mpmath.mpf(order.p) / order.q)
        for _, change in chain:
            felt = change(felt, s)
        d = felt - own
        return {part: abs(x) / abs(own) - mpmath.mpf("0.1") for part, x in zip(Part, (d.real, d.imag), strict=True)}

    return hs.Scene(environment, tuple(effect for effect, _ in chain), (0, 15)), excess


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(40))
def test_scenes_with_powers_are_decided_from_zero_on(seed: int) -> None:
    scene, excess = with_spring_pot(random.Random(seed))
    found = [x for x in hs.evaluate(scene).crossings if x.kind.value != "touches"]
    with mpmath.workdps(25):
        decades = [mpmath.mpf(10) ** (mpmath.mpf(n) / 12 - mpmath.mpf("8.0123")) for n in range(108)]
        grid = sorted([*decades, *(mpmath.mpf(n) / 12 - mpmath.mpf("0.00123") for n in range(1, 181))])
        values = [excess(w) for w in grid]
        for part in Part:
            signs = [v[part] > 0 for v in values]
            turns = [(a, b) for a, b, x, y in zip(grid, grid[1:], signs, signs[1:], strict=False) if x != y]
            own = [float(x.omega) for x in found if x.part is part and float(x.omega) >= grid[0]]
            assert len(own) == len(turns), (part, own, turns)
            assert all(a <= w <= b for w, (a, b) in zip(own, turns, strict=True))


def test_the_real_part_of_s_is_seen_to_vanish_where_s_is_the_square_of_its_root() -> None:
    """Re dH of a spring-pot sqrt(s) behind a compliance k: -80^2/k Re s is no part of its expansion, -905.1 omega^1.5 begins it."""
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, "1/2"), (effects.compliance(k=500),), (0, 15)))
    assert [(x.part, x.omega.digits(12)) for x in found.crossings] == [
        (Part.IMAG, "0.457264930490"),
        (Part.REAL, "11.3360688383"),
    ]
    with mpmath.workdps(40):

        def excess(w: mpmath.mpf) -> mpmath.mpf:
            felt = 80 * mpmath.sqrt(mpmath.mpc(0, w))
            return abs((felt * felt / (felt + 500)).imag) / abs(felt) - mpmath.mpf("0.1")

        assert abs(mpmath.findroot(excess, 0.457) - float(found.crossings[0].omega)) < 1e-12


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("order", "gain"), [("1/2", "1/2"), ("1/3", "2/3"), ("1/4", "3/4"), ("1/7", "6/7"), ("0.37", "0.63")]
)
@pytest.mark.parametrize("delay", ["0 ms", "2 ms"])
def test_what_a_spring_pot_and_a_power_of_s_make_a_damper_has_no_real_part(order: str, gain: str, delay: str) -> None:
    """80 s^a (s^b/10) is 8 s where a + b = 1, as cos(a pi/2 + b pi/2) is 0: r_i = |omega^b/10 - sin(a pi/2)|, late or not."""
    a, b = Rational(order), Rational(gain)
    late = () if delay == "0 ms" else (effects.delay(delay),)
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, a), (effects.series(hs.s**b / 10), *late), (0, 15)))
    assert not found.undecided
    if late:
        assert [x.part for x in found.crossings] == [Part.IMAG] * len(found.crossings)
        return
    assert not found.changeovers_perceived
    assert {x.property.value for x in found.percepts if x.part is Part.REAL} == {"stiffness"}
    with mpmath.workdps(30):
        sine = mpmath.sin(mpmath.pi * a.p / a.q / 2)
        places = [(10 * (sine + mpmath.mpf(c) / 10)) ** (mpmath.mpf(b.q) / b.p) for c in (-1, 1)]
        expected = [w for w in places if w <= 15]
        assert [x.part for x in found.crossings] == [Part.IMAG] * len(expected)
        assert all(
            abs(mpmath.mpf(x.omega.digits(25)) / w - 1) < 1e-23 for x, w in zip(found.crossings, expected, strict=True)
        )


def test_next_to_the_exact_case_the_real_part_is_seen() -> None:
    """cos(a pi/2 + b pi/2) < 0 where a + b is a little above 1: the real part is that of a mass, however small."""
    scene = hs.Scene(environments.spring_pot(80, "1/3"), (effects.series(hs.s ** Rational("0.666667") / 10),), (0, 15))
    found = hs.evaluate(scene)
    assert {x.property.value for x in found.percepts if x.part is Part.REAL} == {"stiffness-to-mass"}


def test_powers_of_s_that_make_up_one_another_are_nothing_or_everything() -> None:
    """s^(1/2) s^(1/3) s^(1/6)/s is 1, at every frequency: it is seen, although each power is a variable of its own."""
    chain = [effects.series(hs.s ** Rational(x)) for x in ("1/2", "1/3", "1/6", "-1")]
    found = hs.evaluate(hs.Scene(environments.spring_pot(80, "1/2"), tuple(chain), (0, 15)))
    assert (found.crossings, found.percepts, found.undecided) == ((), (), ())
    [whole] = found.transparent
    assert (float(whole.low.omega), float(whole.high.omega)) == (0, 15)


# Crossings as formulas


TAU, K, B, M, OMEGA_C, K_ALPHA, ALPHA = hs.symbols("tau k b m omega_c k_alpha alpha")

NUMBERS = {
    TAU: Rational(3, 100), K: Integer(120), B: Integer(7), M: Rational(9, 5), OMEGA_C: Integer(60), K_ALPHA: Integer(80),
    ALPHA: Rational(1, 4), c: Rational(1, 10),
}  # fmt: skip

CASES = {
    "delay on a spring": ((E.mass_spring_damper(k=K),), (F.delay(TAU),)),
    "delay on a damper": ((E.mass_spring_damper(b=B),), (F.delay(TAU),)),
    "delay on a mass": ((E.mass_spring_damper(m=M),), (F.delay(TAU),)),
    "lag on a spring": ((E.mass_spring_damper(k=K),), (F.first_order_lag(OMEGA_C),)),
    "lag on a damper": ((E.mass_spring_damper(b=B),), (F.first_order_lag(OMEGA_C),)),
    "lag on a spring-pot": ((E.spring_pot(K_ALPHA, ALPHA),), (F.first_order_lag(OMEGA_C),)),
    "mass beside a spring": ((E.mass_spring_damper(k=K),), (F.shunt(m=M),)),
    "spring behind a damper": ((E.mass_spring_damper(b=B),), (F.compliance(k=K),)),
}


def symbolic(name: str) -> Distortion:
    [environment], effects = CASES[name]
    return hs.distort(environment, *effects)


def numeric_scene(name: str, high: int) -> hs.Scene:
    """The same scene with numbers for all parameters."""
    [environment], effects = CASES[name]

    def with_numbers(element):  # type: ignore[no-untyped-def]
        arguments = {p.key: NUMBERS[p.value] for p in element.parameters}
        models = catalogue.ENVIRONMENTS if isinstance(element, hs.Environment) else catalogue.EFFECTS
        return models[element.model].build(**arguments)

    return hs.Scene(with_numbers(environment), tuple(map(with_numbers, effects)), (0, high))


def excess(d: hs.Distortion, part: hs.Part) -> RealFunction:
    """r^2 - c^2 of a part, c a symbol."""
    [found] = [x.function(d) for x in opened(noticed(hs.Threshold()), hs.Part) if x.part is part]
    assert isinstance(found, RealFunction)
    return found


@pytest.mark.dear("delay on a spring-real", "lag on a spring-real")
@pytest.mark.few(
    "delay on a spring-real", "delay on a damper-imag", "lag on a spring-real", "mass beside a spring-real"
)
@pytest.mark.parametrize("part", list(hs.Part), ids=lambda p: p.value)
@pytest.mark.parametrize("name", CASES)
def test_formulas_give_exactly_the_certified_crossings(name: str, part: hs.Part) -> None:
    high = 150
    formulas = solve(excess(symbolic(name), part))
    assert all(x.omega is not None for x in formulas)
    found = set()
    for solution in formulas:
        first = solution.omega.xreplace(NUMBERS).evalf(30)
        period = solution.period.xreplace(NUMBERS).evalf(30)
        for turn in range(-3, 4) if period else [0]:
            value = first + turn * period
            if value.is_real and 0 < value < high:
                found.add(round(float(value), 9))
    certified = [x for x in hs.evaluate(numeric_scene(name, high)).crossings if x.part is part]
    assert sorted(found) == [round(float(x.omega), 9) for x in certified]


def test_a_delay_on_a_spring_is_noticed_at_the_inverse_sine_and_cosine() -> None:
    d = symbolic("delay on a spring")
    assert solve(excess(d, hs.Part.IMAG))[0].omega == asin(c) / TAU
    assert solve(excess(d, hs.Part.REAL))[0].omega == acos(1 - c) / TAU


@pytest.mark.parametrize(
    ("environment", "effects", "expected"),
    [
        (E.mass_spring_damper(M, B, K), (), sqrt(K) / sqrt(M)),
        (E.kelvin_voigt(K, B), (F.shunt(m=M),), sqrt(K) / sqrt(M)),
        (E.mass_spring_damper(k=K), (F.delay(TAU),), pi / (2 * TAU)),
        (E.mass_spring_damper(b=B), (F.delay(TAU),), pi / TAU),
        (E.kelvin_voigt(K, B), (), None),
    ],
)
def test_changeovers_of_models_of_few_parameters_are_formulas(environment, effects, expected) -> None:  # type: ignore[no-untyped-def]
    assert hs.distort(environment, *effects).changeover_perceived == expected


def test_what_cannot_be_inverted_is_its_own_answer() -> None:
    [solution] = solve(excess(hs.distort(E.kelvin_voigt(K, B), F.delay(TAU)), hs.Part.REAL))
    assert solution.omega is None
    assert solution.equation.has(omega)
