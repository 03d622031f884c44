"""Sign charts: all roots and poles of some functions on a band, none missed, none invented, all orders exact."""

from __future__ import annotations

from fractions import Fraction
from math import prod

import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import MP, rounded, sign
from sympy import Expr, Integer, Poly, Rational, Symbol, expand, pi
from sympy.abc import x

import haptisym as hs
from haptisym.exact.dynamics import Ring
from haptisym.exact.response import RealFunction
from haptisym.exact.roots import Chart, chart, sign_of_number
from haptisym.symbols import omega

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


def test_taylor_coefficients_of_an_analytic_factor_are_those_of_mpmath_at_any_order() -> None:
    import flint
    import mpmath

    from haptisym.exact.analytic import AnalyticFactor
    from haptisym.exact.wavesums import Term

    factor = AnalyticFactor(
        (Term((1,), (1,), ((3,), (1,))), Term((0,), (0,), ((2,), (0,), (1,)))),
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
