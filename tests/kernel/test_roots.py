"""Sign charts: all roots and poles of some functions on a band, none missed, none invented, all orders exact."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from math import prod
from typing import Any

import flint
import pytest
from flint import arb, arb_poly, fmpq
from hypothesis import given
from hypothesis import strategies as st
from oracles import MP, rounded, sign
from sympy import Expr, Integer, Poly, Rational, Symbol, exp, expand, pi, sqrt
from sympy.abc import x

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.isolation import SeriesFactor, clear_of, isolated
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.levels import Level, algebraic
from haptisym.kernel.ordering import in_order
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import ExactNumber, bounds, dyadic
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.roots import Chart, _whole, chart, sign_of_number
from haptisym.kernel.symbols import omega, s
from haptisym.kernel.zeros import Undecided, around, is_clear, rounded_up, sign_of, tightened
from haptisym.kernel.zeros import Zero as SimpleZero

Zero = tuple[Fraction, int]
"""A square of a frequency, and the order of the zero there (negative for a pole)."""


def function(expression: Expr) -> RealFunction:
    return RealFunction(Ring().axis.convert(expression))


def charted(expression: Expr, low: object = 0, high: object = 100) -> Chart:
    return chart({"f": function(expression)}, Rational(str(low)), Rational(str(high)))


def inside(found: Chart) -> list[tuple[str, int]]:
    """Twelve digits of every point between the ends, and the order of the function there."""
    return [(p.omega.digits(12), p.orders.get("f", 0)) for p in found.points[1:-1]]


squares = st.builds(Fraction, st.integers(1, 900), st.integers(1, 40))
zeros = st.lists(st.tuples(squares, st.integers(-3, 3).filter(bool)), max_size=5, unique_by=lambda z: z[0])


def product(found: list[Zero], factor: int = 1, power: int = 0) -> Expr:
    W = omega**2
    return (
        factor
        * omega**power
        * prod(((W - Rational(w.numerator, w.denominator)) ** n for w, n in found), start=Integer(1))
    )


@given(zeros, st.sampled_from([-2, 1, 3]), st.integers(-2, 3))
def test_zeros_and_poles_placed_on_a_band_are_all_found_with_their_orders(
    found: list[Zero], factor: int, power: int
) -> None:
    points = charted(product(found, factor, power)).points
    assert (points[0].orders.get("f", 0), float(points[0].omega)) == (power, 0.0)
    between = points[1:-1]
    assert [p.orders["f"] for p in between] == [n for _, n in sorted(found)]
    for point, (square, _) in zip(between, sorted(found), strict=True):
        low, high = point.omega.bounds(100)
        assert low**2 <= square <= high**2


@given(zeros, st.sampled_from([-2, 1, 3]), st.integers(-2, 3))
def test_signs_beside_and_at_each_point_are_those_of_the_function(found: list[Zero], factor: int, power: int) -> None:
    points = charted(product(found, factor, power)).points
    for point, (square, order) in zip(points[1:-1], sorted(found), strict=True):
        rest = factor * prod(sign(square - w) ** (n % 2) for w, n in found if w != square)
        assert point.after["f"] == sign(rest)
        assert point.before["f"] == sign(rest) * (-1) ** order
        assert point.at["f"] == (0 if order > 0 or order % 2 else sign(rest))
    assert points[0].before["f"] == points[0].after["f"] * (-1) ** power


@given(
    st.lists(zeros, min_size=2, max_size=3),
    st.fractions(0, 4, max_denominator=9),
    st.fractions(5, 9, max_denominator=9),
)
def test_a_set_of_frequencies_holds_those_whose_signs_pass_the_test(
    several: list[list[Zero]], low: Fraction, high: Fraction
) -> None:
    functions = {i: function(product(found)) for i, found in enumerate(several)}
    result = chart(functions, Rational(low.numerator, low.denominator), Rational(high.numerator, high.denominator))

    def passes(signs: object) -> bool:
        return all(signs[i] <= 0 for i in functions)  # type: ignore[index]

    found = result.where(passes)
    for i in range(1, 200):
        at = low + (high - low) * Fraction(i, 200) + Fraction(1, 10**7)
        values = [prod(sign(at**2 - w) ** (n % 2) for w, n in zeros) for zeros in several]
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


pieces = st.tuples(
    st.lists(st.tuples(st.sampled_from([1, 2, 3, 5]), st.integers(1, 3)), max_size=3, unique_by=lambda z: z[0]),
    st.sampled_from([-1, 1]),
)


@given(st.lists(st.lists(pieces, min_size=1, max_size=2), min_size=1, max_size=3))
def test_the_largest_of_the_smallest_of_functions_vanishes_and_turns_where_it_does(terms: list[list[Any]]) -> None:
    """With an odd order exactly where the sign changes; of one function the order is its own."""
    lattice = Lattice(tuple(tuple(function(product(list(zeros), factor)) for zeros, factor in x) for x in terms))

    def exact(square: Fraction) -> int:
        return max(min(factor * prod(sign(square - w) ** n for w, n in own) for own, factor in x) for x in terms)

    at = {sqrt(Rational(w)): Fraction(w) for x in terms for own, _ in x for w, _ in own}
    found = chart({"f": lattice}, Rational(1, 2), Integer(3)).points
    squares = [Fraction(1, 4), *sorted(at.values()), Fraction(9)]
    assert [float(x.omega) for x in found] == pytest.approx([float(w) ** 0.5 for w in squares])
    for point, (before, here, after) in zip(
        found[1:-1], zip(squares, squares[1:], squares[2:], strict=False), strict=True
    ):
        sides = exact((before + here) / 2), exact((here + after) / 2)
        assert (point.before["f"], point.after["f"]) == sides
        order = point.orders.get("f", 0)
        assert (order > 0) == (exact(here) == 0)
        assert point.at["f"] == exact(here)
        assert order % 2 == (sides[0] != sides[1])
        if len(terms) == len(terms[0]) == 1:
            assert order == dict(terms[0][0][0])[here]


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


# --- pi --------------------------------------------------------------------------------------------------------------


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


# --- signs of numbers ------------------------------------------------------------------------------------------------


@given(st.lists(st.fractions(-9, 9, max_denominator=30), min_size=1, max_size=4))
def test_the_sign_of_a_number_with_pi_in_it_is_that_of_mpmath(c: list[Fraction]) -> None:
    exact = sum((Rational(a.numerator, a.denominator) * pi**n for n, a in enumerate(c)), start=Integer(0))
    assert sign_of_number(exact) == sign(MP.polyval([MP.mpf(a.numerator) / a.denominator for a in reversed(c)], MP.pi))


@pytest.mark.parametrize("digits", [2, 5, 20, 60])
def test_the_sign_of_pi_minus_a_fraction_near_it_is_decided(digits: int) -> None:
    below = Rational(str(MP.floor(MP.pi * MP.mpf(10) ** digits))[: digits + 1]) / 10**digits
    assert sign_of_number(pi - below) == 1
    assert sign_of_number(pi - below - Rational(1, 10**digits)) == -1


def test_a_number_that_is_zero_is_known_to_be_zero() -> None:
    assert sign_of_number((pi + 1) ** 2 - pi**2 - 2 * pi - 1) == 0
    assert sign_of_number(1 / pi - pi / pi**2) == 0


def test_a_function_that_is_zero_everywhere_has_no_sign_anywhere() -> None:
    points = charted(Integer(0)).points
    assert [(p.before["f"], p.at["f"], p.after["f"]) for p in points] == [(0, 0, 0), (0, 0, 0)]


@given(zeros, st.sampled_from([-2, 1, 3]), st.integers(-2, 3))
def test_a_sign_changes_at_odd_zeros_and_odd_poles_alone_and_that_of_nothing_nowhere(
    found: list[Zero], factor: int, power: int
) -> None:
    both = {"f": function(product(found, factor, power)), "nothing": function(Integer(0))}
    result = chart(both, Integer(0), Integer(100))
    odd = [n for _, n in sorted(found) if n % 2]
    changes = [x for x in result.sign_changes("f") if x is not result.points[0]]
    assert [x.orders["f"] for x in changes] == odd
    assert (result.points[0] in result.sign_changes("f")) == power % 2
    assert result.sign_changes("nothing") == ()


def test_taylor_coefficients_of_an_analytic_factor_are_those_of_mpmath_at_any_order() -> None:
    import mpmath

    from haptisym.kernel.analytic import AnalyticFactor
    from haptisym.kernel.wavesums import WaveTerm

    factor = AnalyticFactor(
        (WaveTerm((1,), (1,), ((3,), (1,))), WaveTerm((0,), (0,), ((2,), (0,), (1,)))),
        ((Integer(2), False),),
        (1,),
        (Rational(1, 4),),
    )
    with mpmath.workdps(40):
        expected = mpmath.taylor(
            lambda x: (3 + x) * mpmath.sin(x) * x ** mpmath.mpf("0.25") + (2 + x**2) * mpmath.cos(x), 3, 16
        )
    found = [factor.taylor(flint.arb(3), n) for n in range(17)]
    for i, value in enumerate(expected):
        assert float(found[i].mid()) == pytest.approx(float(value), rel=1e-9)
        assert value != 0


def test_beside_powers_a_zero_has_the_least_order_of_what_stands_with_each_power() -> None:
    """omega^(1/4) sin^k omega + sin omega cos^(k - 1) omega at pi: of order 1; with sin^2 beside both, of order 2."""
    from haptisym.kernel.analytic import AnalyticFactor
    from haptisym.kernel.wavesums import WaveTerm

    def order(one: int, other: int, degree: int) -> int:
        terms = WaveTerm((one,), (1,), ((1,),)), WaveTerm((other,), (0,), ((1,),))
        return AnalyticFactor(terms, ((Integer(2), False),), (degree,), (Rational(1, 4),)).order_at(pi)

    assert [order(2, 1, 2), order(1, 3, 3), order(2, 2, 2), order(3, 2, 4)] == [1, 1, 2, 2]


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


# --- zeros of functions known by their Taylor coefficients alone ------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Placed(SeriesFactor):
    """A polynomial with dyadic zeros, and with how many looks it was asked at which precision."""

    roots: tuple[Fraction, ...]
    sign: int = 1
    looks: list[int] = field(default_factory=list)
    slivers: list[Any] = field(default_factory=list)

    def series(self, x: Any, start: int, stop: int) -> list[Any]:
        self.looks.append(flint.ctx.prec)
        self.slivers.append(x)
        total = arb_poly([self.sign])
        for root in self.roots:
            total = total * arb_poly([x - dyadic(root), 1])
        row = total.coeffs() + [arb(0)] * (stop + 1)
        return row[start:stop]

    def value(self, x: Any) -> Any:
        return self.series(x, 0, 1)[0]

    def over(self, box: Any) -> tuple[Any, Any, Any]:
        value, slope, bend = self.series(box, 0, 3)
        return value, slope, bend

    def zeros(self, low: Expr, high: Expr) -> list[Any]:
        raise NotImplementedError

    def order_at(self, place: Expr) -> int:
        raise NotImplementedError

    def jet(self, x: Any, count: int) -> list[Any]:
        return self.series(x, 0, count)


def dyadic_near(x: float) -> Fraction:
    return Fraction(round(x * 2**40), 2**40)


def brackets(seed: int, count: int) -> list[tuple[Placed, Fraction, Fraction, Fraction]]:
    """Polynomials with one zero between two numbers, of either sign, and twins outside: near, far, or none."""
    pick = random.Random(seed)
    found = []
    for _ in range(count):
        size = 10.0 ** pick.uniform(-3, 3)
        low = dyadic_near(size * pick.uniform(0.5, 1))
        high = low + dyadic_near(size * 10.0 ** pick.uniform(-3, 0)) + Fraction(1, 2**30)
        root = low + (high - low) * Fraction(pick.randint(1, 2**20 - 1), 2**20)
        gaps = [
            (high - low) * Fraction(pick.choice((1, 2**10, 2**18, 2**22)), 2**20) for _ in range(pick.randint(0, 3))
        ]
        others = [low - gap if pick.random() < 0.5 else high + gap for gap in gaps]
        f = Placed((root, *others), pick.choice((-1, 1)))
        if pick.random() < 0.3:
            f, root, low, high = Placed(tuple(-x for x in f.roots), f.sign), -root, -high, -low
        found.append((f, root, low, high))
    return found


@pytest.mark.parametrize("bits", [128, 160, 512])
def test_a_zero_between_two_numbers_is_enclosed_as_tightly_as_asked_and_its_twins_are_not(bits: int) -> None:
    for f, root, low, high in brackets(bits, 60):
        with flint.ctx.workprec(bits):
            found = tightened(dyadic(low), dyadic(high), bits, f.jet)
            first, last = bounds(found)
            fewer = len(f.looks)
            assert found.overlaps(tightened(dyadic(low), dyadic(high), bits, f.jet, terms=4))
            del f.looks[fewer:]
        assert first <= root <= last
        assert low <= first
        assert last <= high
        assert found.rel_accuracy_bits() >= bits - 32
        # Newton's steps double the digits, from a bracket that at worst is halved a few times
        assert len(f.looks) <= 40 + bits // 16, (len(f.looks), f)


def test_newton_from_point_to_point_needs_a_look_for_each_doubling_of_the_digits() -> None:
    """No other zero near: that is how nearly all are found, whichever sign they have."""
    for side in (1, -1):
        f = Placed((side * Fraction(5, 8), side * Fraction(7), side * Fraction(-3)))
        ends = sorted((side * Fraction(1, 2), side * Fraction(13, 16)))
        with flint.ctx.workprec(4096):
            tightened(*map(dyadic, ends), 4096, f.jet)
        assert len(f.looks) <= 14
        with flint.ctx.workprec(4096):
            tightened(*map(dyadic, ends), 4096, f.jet, terms=4)  # the digits grow fourfold
        assert len(f.looks) <= 14 + 9


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
    f = Placed((Fraction(5, 16), Fraction(11, 16), Fraction(3)))
    zero = SimpleZero(f, arb("0.25"), arb("0.5"))
    for bits in (64, 128, 129, 1000, 4096):
        ball = zero.ball(bits)
        first, last = bounds(ball)
        assert first <= Fraction(5, 16) <= last
        assert ball.rel_accuracy_bits() >= bits - 32
    assert sum(prec >= 4096 for prec in f.looks) <= 8
    slope = SimpleZero(Placed((Fraction(1), Fraction(3), Fraction(20))), arb("1.5"), arb("2.5"), derivative=1)
    first, last = bounds(slope.ball(200))  # of x^3 - 24 x^2 + 83 x - 60, whose slope is 3 x^2 - 48 x + 83
    assert (3 * first**2 - 48 * first + 83) * (3 * last**2 - 48 * last + 83) < 0
    assert last - first < Fraction(1, 2**160)


def test_numbers_are_put_in_order_whether_their_brackets_meet_or_not() -> None:
    """Brackets far apart, one inside the other, and zeros 2^-200 apart."""
    near = Fraction(1, 2) + Fraction(1, 2**200)
    brackets = [
        (Fraction(5), "4", "6"), (Fraction(1, 2), "0.25", "3"), (Fraction(7, 8), "0.75", "1"), (near, "0.25", "0.75"),
        (Fraction(2), "1.5", "9"), (Fraction(1, 8), "0", "0.25"),
    ]  # fmt: skip
    numbers = {
        SimpleZero(Placed((root,)), arb(low), arb(high), i): root for i, (root, low, high) in enumerate(brackets)
    }
    for seed in range(20):
        listed = random.Random(seed).sample(list(numbers), len(numbers))
        assert [numbers[x] for x in in_order(listed)] == sorted(numbers.values())


def test_precision_rises_by_doubling_and_ends_at_its_limit() -> None:
    asked: list[tuple[int, int]] = []

    def when(enough: int) -> Callable[[int], int | None]:
        def ask(bits: int) -> int | None:
            asked.append((bits, flint.ctx.prec))
            return 7 if bits >= enough else None

        return ask

    before = flint.ctx.prec
    assert at_rising_precision(when(100)) == 7
    assert asked == [(128, 128)]
    assert at_rising_precision(when(512), most=512) == 7
    assert asked[1:] == [(128, 128), (256, 256), (512, 512)]
    assert at_rising_precision(when(513), most=512) is None
    assert at_rising_precision(lambda _: 0, most=128) == 0
    assert flint.ctx.prec == before


def test_the_sign_of_a_ball_is_that_of_all_its_numbers() -> None:
    for ball, expected in [
        (arb(2), 1), (arb("1e-300"), 1), (arb(3, 2.9), 1), (arb(-1), -1), (-arb("1e-300"), -1), (arb(0), 0), (arb(1, 2), 0),
        (arb(-1, 1), 0), (arb(1, 1), 0), (arb("nan"), 0), (arb(0, 1).log(), 0), (arb(0, float("inf")), 0),
    ]:  # fmt: skip
        assert (sign_of(ball), is_clear(ball)) == (expected, expected != 0)


def test_precisions_are_shared_by_powers_of_two() -> None:
    assert [rounded_up(n) for n in (1, 100, 128, 129, 256, 257, 1000)] == [128, 128, 128, 256, 256, 512, 1024]


def test_an_interval_is_enclosed_in_dyadic_numbers_a_hair_outside() -> None:
    for low, high in (
        (Rational(1, 3), Rational(2, 3)),
        (pi, 2 * pi),
        (Integer(0), Integer(5)),
        (Rational(-7, 9), pi / 7),
    ):
        first, last = around(low, high)
        with flint.ctx.workprec(300):
            ends = [ExactNumber(x).ball(300) for x in (low, high)]
            assert first.is_exact()
            assert last.is_exact()
            assert first <= ends[0].upper()
            assert ends[1].lower() <= last
            assert not first > ends[0].lower()
            assert not last < ends[1].upper()
            assert ends[0] - first < arb(2) ** -120
            assert last - ends[1] < arb(2) ** -120


@pytest.mark.parametrize("seed", range(40))
def test_all_zeros_of_a_function_are_isolated_and_no_others(seed: int) -> None:
    """Up to seven of them, some with a twin a millionth or a trillionth beside."""
    pick = random.Random(seed)
    roots = {dyadic_near(pick.uniform(0.1, 9.9)) for _ in range(pick.randint(0, 4))}
    roots |= {x + dyadic_near(10.0 ** pick.choice((-1, -3, -6, -9))) for x in list(roots)[: pick.randint(0, 3)]}
    outside = [Fraction(-1, 8), Fraction(10) + Fraction(1, 2 ** pick.randint(1, 20))]
    f = Placed((*roots, *outside), pick.choice((-1, 1)))
    found = isolated(f, arb(0), arb(10))
    assert len(found) == len(set(found)) == len(roots)
    for zero, root in zip(found, sorted(roots), strict=True):
        first, last = bounds(zero.ball(256))
        assert first <= root <= last
        assert first > 0
    if roots:
        assert len(f.looks) < 700 * len(roots)
    assert isolated(f, arb(5), arb(5)) == []
    assert isolated(f, arb(6), arb(5)) == []


class Far(Placed):
    """As a function with powers of omega: looked at in pieces whose ends are not far from each other."""

    farthest = 3.0


@pytest.mark.parametrize("seed", range(12))
def test_pieces_cut_beforehand_have_the_same_zeros(seed: int) -> None:
    pick = random.Random(seed)
    low, high = 10.0 ** pick.uniform(-5, 0), 10.0 ** pick.uniform(0.1, 2)
    roots = tuple({dyadic_near(low * (high / low) ** pick.random()) for _ in range(pick.randint(0, 4))})
    found = isolated(Far(roots), arb(low), arb(high))
    assert [float(x) for x in found] == sorted(map(float, roots))


def test_no_piece_ends_on_a_zero() -> None:
    """[1, 16] is cut at two places: here each of them is one of the zeros."""
    with flint.ctx.workprec(128):
        places = [(arb(16).log() * n / 3).exp().mid() for n in (1, 2)]
    roots = tuple(Fraction(int(m)) * Fraction(2) ** int(e) for m, e in (x.man_exp() for x in places))
    assert [bounds(x.ball(200))[0] <= y <= bounds(x.ball(200))[1] for x, y in
            zip(isolated(Far(roots), arb(1), arb(16)), roots, strict=True)] == [True, True]  # fmt: skip


def test_a_pair_that_is_none_is_no_zero_and_a_double_one_is_undecided() -> None:
    """(x - 1)^2 + c, with c a little positive, a little negative, or nothing."""

    class Bowl(Placed):
        def series(self, x: Any, start: int, stop: int) -> list[Any]:
            row = super().series(x, 0, max(stop, 1))
            row[0] = row[0] + self.sign * dyadic(self.depth)
            return row[start:stop]

    for side in (1, -1):
        for depth, count in (
            (Fraction(1, 2**90), 0),
            (Fraction(-1, 2**90), 2),
            (Fraction(1, 4), 0),
            (Fraction(-1, 4), 2),
        ):
            Bowl.depth = depth
            assert len(isolated(Bowl((Fraction(1), Fraction(1)), side), arb(0), arb(3))) == count
        Bowl.depth = Fraction(0)
        [double] = isolated(Bowl((Fraction(1), Fraction(1)), side), arb(0), arb(3))
        assert isinstance(double, Undecided)
        assert abs(float(double.ball(128).mid()) - 1) < 1e-15
        assert double.factor.multiplicity(double) == 2
        assert double.factor.multiplicity(SimpleZero(double.factor, arb(0), arb(3))) == 1
        # one that rises or falls all the way on a piece that bends
        Bowl.depth = Fraction(-1, 4)
        assert len(isolated(Bowl((Fraction(1), Fraction(1)), side), arb(1), arb(3))) == 1
        assert len(isolated(Bowl((Fraction(1), Fraction(1)), side), arb(2), arb(3))) == 0
        assert len(isolated(Bowl((Fraction(1), Fraction(1)), side), arb(-1), arb(0))) == 0


def test_a_triple_zero_is_said_to_be_undecided() -> None:
    with pytest.raises(hs.UndecidedError, match="how often a function vanishes near omega = 1"):
        isolated(Placed((Fraction(1),) * 3), arb(0), arb(3))


def test_a_piece_is_cut_where_the_function_is_not_zero() -> None:
    """Zeros at 127/256 and 131/256 of a band, where it would be cut first."""
    for roots in ((127, 30), (127, 131, 200), (127, 131, 113, 20)):
        f = Placed(tuple(Fraction(n, 256) for n in roots))
        found = isolated(f, arb(0), arb(1))
        assert [round(float(zero) * 256) for zero in found] == sorted(roots)
    with pytest.raises(hs.UndecidedError, match="the sign of a function"):
        isolated(Placed(tuple(Fraction(n, 256) for n in (127, 131, 113, 149))), arb(0), arb(1))


@pytest.mark.parametrize("side", ["above", "below"])
@pytest.mark.parametrize("place", [Integer(2), Rational(1, 3), pi])
def test_a_number_clear_of_a_zero_of_known_order_has_no_other_zero_before_it(place: Expr, side: str) -> None:
    """A zero of order 0, 1 or 2 at the place, another one 2^-20 beside it on either side."""
    above = side == "above"
    with flint.ctx.workprec(256):
        centre = ExactNumber(place).ball(256)

    class Shifted(Placed):
        def series(self, x: Any, start: int, stop: int) -> list[Any]:
            return super().series(x - centre, start, stop)

    near = Fraction(1, 2**20)
    for order in (0, 1, 2):
        f = Shifted((*[Fraction(0)] * order, near, -near, Fraction(5)))
        end = clear_of(f, place, order, arb(1), above=above)
        assert end.is_exact()
        reach = (end - centre) if above else (centre - end)
        assert 0 < reach < dyadic(near)
        assert reach > dyadic(near) / 64
        assert f.slivers[-1].contains(0)  # what was looked at holds the place itself


def test_a_zero_that_has_no_known_order_is_never_clear() -> None:
    with pytest.raises(hs.UndecidedError, match="vanishes again"):
        clear_of(Placed((Fraction(1), Fraction(1))), Integer(1), 1, arb(1), above=True)


# --- charts ----------------------------------------------------------------------------------------------------------


def test_the_order_of_frequencies_is_told_however_near_and_equal_ones_are_said_to_be_undecided() -> None:
    near = [ExactNumber(Rational(1, 3) + Rational(n, 10**60)) for n in (3, 0, 2, 1)]
    assert in_order(near) == [near[1], near[3], near[2], near[0]]
    assert in_order([near[0]]) == near[:1]
    twins = [SimpleZero(Placed((Fraction(1, 2), Fraction(2))), arb(0), arb(1)) for _ in range(2)]
    with pytest.raises(hs.UndecidedError, match=r"whether two frequencies near 0\.5"):
        in_order([*twins, ExactNumber(Integer(3))])


def test_a_level_that_is_an_irrational_number_has_exact_signs_and_orders() -> None:
    """W^2 - 2 W against sqrt(2) - 1 and -1: two zeros, a double one; and signs on both sides of each."""
    W = omega**2
    root = algebraic(sqrt(2))
    points = chart({"f": Level(function(W**2 - 2 * W + 2), root)}, Integer(0), Integer(3)).points
    assert [p.after["f"] for p in points] == [1, -1, 1, 1]
    squares = [1 - (MP.sqrt(2) - 1) ** MP.mpf("0.5"), 1 + (MP.sqrt(2) - 1) ** MP.mpf("0.5")]
    assert [float(p.omega) for p in points[1:-1]] == [float(MP.sqrt(x)) for x in squares]
    steady = chart({"f": Level(function(W + 2), root), "g": Level(function(1 / (W + 2)), root)}, Integer(0), Integer(3))
    assert [(p.after["f"], p.after["g"]) for p in steady.points] == [(1, -1), (1, -1)]


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


@pytest.mark.parametrize(
    ("alpha", "order"), [("1/2", 1), ("3/2", 2), ("-1/2", -1), ("-3/2", -2), ("1/3", 1), ("-5/3", -2), ("2/3", 1)]
)
def test_a_fractional_order_at_rest_is_rounded_away_from_0_and_mirrors_nothing(alpha: str, order: int) -> None:
    assert _whole(Rational(alpha)) == order
    assert [_whole(Integer(n)) for n in (-2, 0, 3)] == [-2, 0, 3]


def test_powers_of_s_below_the_line_have_charts_of_their_own() -> None:
    """k_a s^(1/2) and its inverse: |H|^2 = k_a^2 omega, below and above a rational number; exact at alpha = 1/2."""
    for text, c, place in (
        ("3*s^0.5", 4, Rational(4, 9)),
        ("3/s^0.5", 4, Rational(9, 4)),
        ("1/(1 + s^0.5)", None, None),
    ):
        environment = hs.environments.expression(text, parameters={})
        d = hs.distort(environment, hs.effects.delay("0.01 s"))
        square = d.env_response.real
        table = chart({"re": square, "im": d.env_response.imag}, Integer(0), Integer(9))
        assert len(table.points) == 2
        sign = -1 if "/" in text else 1
        assert [p.after["re"] for p in table.points] == [1, 1]
        assert [p.after["im"] for p in table.points] == [sign, sign]
        assert [p.before["re"] for p in table.points][1:] == [1]
        order = {"3*s^0.5": 1, "3/s^0.5": -1, "1/(1 + s^0.5)": 0}[text]
        assert table.points[0].orders.get("re", 0) == order
        assert table.points[0].orders.get("im", 0) == (order or 1)
        if c is not None and place is not None:  # |Re| = |Im| = c sqrt(1/2) there
            level = square * square - RealFunction(square.axis.convert(Rational(c * c, 2)))
            [point] = chart({"x": level}, Integer(0), Integer(9)).points[1:-1]
            low, high = point.omega.bounds(60)
            target = Fraction(16, 9) if text == "3*s^0.5" else Fraction(9, 16)
            assert low <= target <= high
            assert (point.before["x"], point.after["x"]) == (-sign, sign)


def test_a_tangency_that_stays_undecided_says_of_which_function_and_keeps_its_sign() -> None:
    """1 + cos(omega) + (omega^2 - pi^2)^2 touches 0 at pi, where no finite number of digits shows it; its neighbour does not."""
    f = 1 + exp(-s) + (s**2 + pi**2) ** 2
    touching = on_axis(Ring.of([f]).convert(f)).real
    other = RealFunction(touching.axis.convert(omega**2 - 9))
    for factor in (1, -1):
        turned = RealFunction((touching.function * touching.axis.convert(Integer(factor))).reduced())
        table = chart({"touch": turned, "other": other, "both": turned * other}, Integer(1), Integer(5))
        before, point = table.points[1:-1]
        assert (before.undecided, before.orders) == (frozenset(), {"other": 1, "both": 1})
        assert float(point.omega) == pytest.approx(float(pi))
        assert point.undecided == {"touch", "both"}
        assert point.orders == {"touch": 2, "both": 2}
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
