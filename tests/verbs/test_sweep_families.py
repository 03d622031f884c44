"""Families of polynomials and waves in floats: what they may read, which sets are within reach, and what errors they own up to."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import log2, prod
from random import Random

import flint
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp, lambdify, pi, sympify

import haptisym as hs
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.sweep.curves import ClosedForms, Reader
from haptisym.verbs.sweep.families import Family, Monomial, Powers, family, monomial, within_reach
from haptisym.verbs.sweep.passes import Band
from haptisym.verbs.sweep.waves import Variables, WaveFamily, WaveReader, is_readable
from haptisym.verbs.sweep.wavevalues import Factor, WaveFunction


def drawn(pick: Random) -> tuple[list[Family], np.ndarray]:
    """Families of few terms whose constants are powers of two, small ones, large ones or usual, and sets of two such parameters."""
    most, families = pick.choice([40, 500, 700]), []
    least = pick.choice([-most, most // 2])
    for _ in range(pick.randint(1, 2)):
        rows = [
            (
                pick.randint(0, 3),
                2.0 ** pick.randint(min(least, most), max(least + most // 2, most)),
                pick.randint(0, 3),
                pick.randint(0, 3),
            )
            for _ in range(pick.randint(1, 3))
        ]
        rows = [(n, x if pick.random() < 0.9 else 1 / x, a, b) for n, x, a, b in rows]
        if pick.random() < 0.4:
            rows = [(n, 1 / x if x > 1 else x, a, b) for n, x, a, b in rows]
        families.append(Family(tuple(Monomial(n, x, 0.0, (a, b)) for n, x, a, b in rows)))
    reach = pick.choice([3, 45, 300])
    sets = [[pick.choice([0.0, *[2.0 ** pick.randint(-reach, reach)] * 5]) for _ in range(4)] for _ in range(2)]
    return families, np.array(sets)


@pytest.mark.parametrize("seed", range(8))
def test_a_function_is_read_as_the_signs_of_what_comes_an_odd_number_of_times(seed: int) -> None:
    """What comes an even number of times above the line, and all below it, must not vanish: there the signs are not the answer."""
    pick = Random(seed)
    for _ in range(6):
        squares = pick.sample((2, 3, 5, 6, 7, 8), 4)
        whole = Rational(pick.choice([-3, -1, 2]), 5) * w ** pick.choice([0, 1, 2, 3])
        powers = {n: pick.choice([-3, -2, -1, 1, 2, 3, 4]) for n in squares}
        f = RealFunction(Ring().axis.convert(whole * prod((w**2 - n) ** k for n, k in powers.items())))
        reader = Reader(hs.load_scene("fu2019"), [], ClosedForms({}, (f,)))
        told = reader._signs(f)
        rows = [[x.at(Powers(np.zeros((0, 1)))).values[:, 0] for x in own] for own in (told.factors, reader.definite)]
        roots = [sorted(15**2 * (np.roots(row[::-1])[0] ** (2 / reader.step)).real for row in own) for own in rows]
        assert roots[0] == pytest.approx(sorted(n for n, k in powers.items() if k % 2))
        assert roots[1] == pytest.approx(sorted(n for n, k in powers.items() if k < 0 or k % 2 == 0))
        assert told.begins_at_0 is whole.has(w)
        again = Reader(hs.load_scene("fu2019"), [], ClosedForms({}, (f,)))
        turning = again._changeover(f)
        assert turning is not None
        zeros = [np.roots(x.at(Powers(np.zeros((0, 1)))).values[::-1, 0]) for x in turning]
        places = sorted(15**2 * (x[0] ** (2 / again.step)).real for x in zeros if len(x))
        assert places == pytest.approx(sorted(n for n, k in powers.items() if k > 0 and k % 2))
        assert [x.terms for x in again.definite] == [x.terms for x in reader.definite]
        for at in (0.5, 1.1, 1.6, 1.9, 2.1, 2.4, 2.6, 2.8, 3.5):
            own = told.sign * prod(float(np.polyval(row[::-1], (at / 15) ** reader.step)) for row in rows[0])
            assert np.sign(own) == np.sign(float(f.ball(arb(at))))


@pytest.mark.parametrize("step", [1, 2])
def test_segments_of_a_band_ascend_from_its_low_end_to_1_and_are_alike_in_frequency(step: int) -> None:
    """However near its ends are: also where only few doubles lie between them, or none."""
    for low in (0, 1, "1/3", 7, "99/10", *(10 - Rational(10) ** -n for n in (3, 8, 13, 15, 16, 17, 30)), pi, "5"):
        band = Band.of(sympify(low), Integer(10), step)
        share = (sympify(low) / 10) ** step
        for segments in (1, 2, 7, 64):
            edges = band.edges(segments, step)
            first, *_, last = edges
            assert last == 1.0
            assert all(a < b for a, b in pairwise(edges[:-1]))
            assert edges[-2] < 1 or band.ends[-1] == 1
            assert bool(share >= Rational(first))
            assert bool(share <= Rational(band.ends[-1]))
            assert band.doubtful is (len(band.ends) == 2) is not bool(share.is_rational and Rational(first) == share)
            if float(share) < 0.98:
                places = np.array(edges[len(band.ends) - 1 :]) ** (1 / step)
                assert np.diff(places) == pytest.approx((1 - places[0]) / segments, rel=1e-9)


def test_a_constant_is_read_only_where_128_bits_of_it_are_known() -> None:
    with flint.ctx.workprec(200):
        for ball in (arb(3), arb(2) ** 500, arb(1) / 3, arb.pi() * 10**30):
            own = monomial(2, (1,), ball)
            assert (own.power, own.exponents, own.constant) == (2, (1,), float(ball.mid()))
            assert abs(arb(own.constant) + arb(own.rest) - ball) < abs(ball) * 2.0**-104
        fine, coarse = arb(1, 2.0**-140), arb(1, 2.0**-120)
        assert monomial(0, (), fine).constant == 1
        with pytest.raises(UndecidedError, match="fewer than 128"):
            monomial(0, (), coarse)


@pytest.mark.parametrize("seed", range(4))
def test_no_product_of_terms_leaves_the_floats_where_a_set_is_within_reach(seed: int) -> None:
    """Nor do sums of a few of them; and sets of usual numbers are within reach of usual constants."""
    pick = Random(seed)
    for _ in range(40):
        families, values = drawn(pick)
        _stay_within(families, values)


def _stay_within(families: list[Family], values: np.ndarray) -> None:
    for i, within in enumerate(within_reach(values, [families])):
        pair = [Fraction(float(x)) for x in values[:, i]]
        for terms in product(*(f.terms for f in families)):
            value = prod(
                (Fraction(t.constant) * prod(x**n for x, n in zip(pair, t.exponents, strict=True)) for t in terms),
                start=Fraction(1),
            )
            assert not within or value == 0 or Fraction(1, 2**1000) <= value <= 2**1000
    small = all(abs(log2(t.constant)) < 200 for f in families for t in f.terms)
    usual = (values == 0) | (np.abs(np.log2(np.where(values, values, 1.0))) < 45)
    assert not small or within_reach(values, [families])[usual.all(axis=0)].all()


@pytest.mark.parametrize("seed", range(4))
def test_coefficients_lie_within_their_error_where_they_are_within_reach(seed: int) -> None:
    """Of numbers that are no powers of two."""
    pick = Random(seed)
    for _ in range(20):
        families, values = drawn(pick)
        _lie_within(families[0], values * np.array([[1.1], [1 / 3]]))


def _lie_within(family: Family, values: np.ndarray) -> None:
    with np.errstate(all="ignore"):
        found, u = family.at(Powers(values)), Fraction(1, 2**53)
    for i, within in enumerate(within_reach(values, [[family]])):
        pair = [Fraction(float(x)) for x in values[:, i]]
        for power in range(family.degree + 1) if within else ():
            own = [
                Fraction(t.constant) * prod(x**n for x, n in zip(pair, t.exponents, strict=True))
                for t in family.terms if t.power == power
            ]  # fmt: skip
            size = Fraction(float(found.sizes[power, i]))
            assert abs(Fraction(float(found.values[power, i])) - sum(own)) <= found.roundings * u * size * Fraction(
                1001, 1000
            )
            assert sum(own) <= size * (1 + 1000 * u)


@pytest.mark.parametrize("alpha", [0.5, 0.9, 1.7])
def test_powers_of_frequencies_of_any_size_lie_within_their_error(alpha: float) -> None:
    """The further x is from 1, the more of log x is lost; a small part of that bound is not enough."""
    sets = 300
    x = 10.0 ** np.random.default_rng(3).uniform(-160, 0, sets)
    variables = Variables((), (alpha,))
    family = WaveFamily((Monomial(0, 1.0, 0.0, (0,)),), variables, ((0, 1),))
    f = WaveFunction(variables, np.zeros((0, sets)), (Factor(family, family.at(Powers(np.ones((1, sets))))),))
    values, wrong = f.values(x[None])[0], f.error(f.sizes(x), x, x)
    with flint.ctx.workprec(300):
        exact = [(arb(float(y)).log() * arb(alpha)).exp() for y in x]
        off = np.array([float(abs(arb(float(v)) - e)) for v, e in zip(values, exact, strict=True)])
    assert (off <= wrong).all()
    assert (off > wrong / 100).any()
    assert (wrong < 1e-11 * values + 1e-270).all()


@pytest.mark.parametrize("degree", [6, 12])
@pytest.mark.parametrize("alpha", [0.5, 1.5])
def test_what_polynomials_leave_out_of_powers_is_bounded_beside_0_too(alpha: float, degree: int) -> None:
    """Or said to be unknown; further away from 0 it is little."""
    low = np.array([1e-3, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.5, 0.9])
    high, sets = np.ones_like(low), len(low)
    variables = Variables((), (alpha,))
    family = WaveFamily((Monomial(0, 1.0, 0.0, (0,)),), variables, ((0, 1),))
    f = WaveFunction(variables, np.zeros((0, sets)), (Factor(family, family.at(Powers(np.ones((1, sets))))),))
    value, slope = f.left_out(low, high, degree)
    y = -np.cos(np.pi * np.arange(degree + 1) / degree)
    for i in range(sets):
        middle, half = (low[i] + high[i]) / 2, (high[i] - low[i]) / 2
        p = np.polynomial.Polynomial.fit(y, (middle + half * y) ** alpha, degree, domain=[-1, 1])
        t = np.linspace(-1, 1, 801)
        off = np.abs(p(t) - (middle + half * t) ** alpha).max()
        steep = np.abs(p.deriv()(t) - half * alpha * (middle + half * t) ** (alpha - 1)).max()
        assert not value[i] < off - 1e-12  # what floats do to the polynomial that is fitted here
        assert not slope[i] < steep - 1e-10
    assert (value[-2:] < 1e-3).all()


def test_next_to_0_nothing_bounds_what_polynomials_leave_out_of_powers() -> None:
    """Powers are analytic right of 0 alone: of a segment that nearly begins there every ellipse around it reaches beyond."""
    variables = Variables((), (0.5,))
    family = WaveFamily((Monomial(0, 1.0, 0.0, (0,)),), variables, ((0, 1),))
    f = WaveFunction(variables, np.zeros((0, 2)), (Factor(family, family.at(Powers(np.ones((1, 2))))),))
    for found in f.left_out(np.array([1e-6, 1e-3]), np.array([1.0, 1.0]), 8):
        assert not np.isfinite(found).any()


TAU, ALPHA, P = Symbol("tau", positive=True), Symbol("alpha", positive=True), Symbol("p", positive=True)


@pytest.mark.parametrize(
    ("H", "expected"),
    [
        (exp(-s * TAU), True),
        (exp(-s * TAU * P**2 / 3), True),
        (s ** Rational(1, 2) * exp(-s / 7), True),
        (exp(-s * (TAU + P)), True),  # two delays
        (exp(-s * TAU / (1 + P)), False),
        (s**ALPHA, False),
        (s**ALPHA * exp(-s * TAU), False),
        (s ** Rational(1, 2) * exp(-s * TAU / (1 + P)), False),
    ],
)
def test_delays_that_are_monomials_and_powers_that_are_numbers_are_read_and_no_others(
    H: Expr, *, expected: bool
) -> None:
    assert is_readable(on_axis(Ring.of([H, P, TAU]).convert(1 + H)).real) is expected


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(6))
def test_functions_that_are_read_and_constants_beside_them_have_their_values_on_every_set(seed: int) -> None:
    """In x = omega/scale, beside waves and powers; of a constant the same at every frequency."""
    pick = Random(seed)
    H = draw_one(pick)
    ring = Ring.of([H, P, TAU])
    function, scale = on_axis(ring.convert(H)).real, Rational(pick.randint(2, 40))
    reader = WaveReader(function, [P, TAU], scale)
    sets = np.array([[pick.uniform(0.5, 2) for _ in range(5)] for _ in range(2)])
    powers, variables = Powers(sets), reader._variables
    rates = np.array(
        [[t.constant * p ** t.exponents[0] * tau ** t.exponents[1] for p, tau in sets.T] for t in variables.rates]
    ).reshape(-1, 5)

    def of(family: WaveFamily) -> WaveFunction:
        return WaveFunction(variables, rates, (Factor(family, family.at(powers)),))

    top, bottom = (
        of(reader.family(x, Rational(1, 3))) for x in (function.half_angled.numerator, function.half_angled.denominator)
    )
    number = of(reader.constant(Monomial(0, 2.5, 0.0, (2, 1))))
    assert number.is_polynomial
    assert not any(number.above[0].family.degrees)
    value = lambdify((s, P, TAU), H, "numpy")
    for x in (0.1, 0.35, 0.9):
        at = np.full((1, 5), x)
        true = value(1j * x * float(scale), *sets).real
        assert top.values(at)[0] / bottom.values(at)[0] == pytest.approx(true, rel=1e-9)
        assert number.values(at)[0] == pytest.approx(2.5 * sets[0] ** 2 * sets[1])


def draw_one(pick: Random) -> Expr:
    """A stiffness, a mass or a damping, late, and perhaps a tissue."""
    late = exp(-s * TAU * pick.choice([1, P, Rational(1, 3)]) / 50)
    found = pick.randint(1, 9) * P + s**2 * pick.randint(0, 2) + (pick.randint(1, 9) + P * s) * late
    return found + (s ** Rational(pick.randint(1, 3), 4) if pick.random() < 0.6 else 0)


def test_a_polynomial_is_read_as_one_in_a_power_of_a_scaled_frequency_whatever_parameters_it_holds() -> None:
    """Against SymPy; a parameter that is nowhere in it has the exponent 0, wherever it stands among them."""
    pick = Random(17)
    a, b, other = (Symbol(x, positive=True) for x in ("a", "b", "other"))
    for _ in range(10):
        step, scale, factor = (
            pick.choice([1, 2, 3]),
            Rational(pick.randint(1, 40), 7),
            pick.choice([1, pi, Rational(2, 3)]),
        )
        terms = [
            pick.choice([-3, -1, 2, 7]) * pick.choice([1, pi, pi**2]) * a ** pick.randint(0, 3) * b ** pick.randint(0, 2) * w ** (n * step)
            for n in (0, *pick.sample(range(4), 3))
        ]  # fmt: skip
        form = sum(terms, a * b)
        axis = Ring.of([a * b]).axis
        function = axis.convert(form)
        given = pick.sample([a, b, other], 3)
        found = family(axis, function.numerator, given, scale, step, sympify(factor))
        known = {a: Rational(5, 3), b: Rational(-7, 4), other: Rational(11), w: Rational(9, 5)}
        x = float((known[w] / scale) ** step)
        values = [float(known[p]) for p in given]
        sizes = [
            t.constant * prod(v**n for v, n in zip(values, t.exponents, strict=True)) * x**t.power for t in found.terms
        ]
        exact = float((factor * axis.expression(function.numerator)).subs(known).evalf(30))
        assert float((axis.expression(function.numerator) / axis.expression(function.denominator) - form).expand()) == 0
        assert sum(sizes) == pytest.approx(exact, rel=1e-13, abs=1e-13 * sum(map(abs, sizes)))
        assert all(t.exponents[given.index(other)] == 0 for t in found.terms)
        for t in found.terms:  # a double, and what it leaves
            assert abs(t.rest) <= 2.0**-53 * abs(t.constant)
