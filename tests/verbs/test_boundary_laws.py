"""What bounds a requirement, piece by piece: critical values against dense samples, sums that cancel against SymPy, beginnings against mpmath."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq, fmpq_poly
from sympy import Expr, Integer, Poly, Rational, Symbol, factor_list, lambdify, pi, real_roots
from sympy import discriminant as known_discriminant
from sympy import resultant as known_resultant

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.polynomials import PolynomialFactor
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega as w
from haptisym.verbs.require.blowups import is_negative, positive_along
from haptisym.verbs.require.boundary import (
    critical,
    edge_polynomial,
    in_square,
    irreducible,
    is_even,
    of_factor,
    substituted,
    touch_polynomial,
)
from haptisym.verbs.require.boundary import real_roots as found_roots
from haptisym.verbs.require.feasible import Kind, runs
from haptisym.verbs.require.freeparameter import _is_modulus, _is_positive
from haptisym.verbs.require.knownsums import ExactPolynomial, Known, added, ball, is_exact, of_parts, parts_of
from haptisym.verbs.require.lowest import beginning
from haptisym.verbs.require.monomials import Monomials, power

SEEDS = range(20)
q = Symbol("q", positive=True)
AXIS = Ring.of([q]).axis
INDEX = AXIS.meanings.index(q)
CRITERION = noticed(hs.load_scene("fu2019").threshold)[0]


def top(x: Expr) -> Any:
    return AXIS.convert(x).numerator


def drawn(draw: random.Random, even: object, degree: int = 2) -> Expr:
    """A polynomial in omega, or omega^2, and q."""
    x = w**2 if even else w
    return (
        sum((draw.randint(-4, 4) * x**i * q**k for i in range(degree + 1) for k in range(2)), Integer(0))
        + draw.choice([1, -2, 3]) * x**degree
    )


@pytest.mark.few("16")
@pytest.mark.parametrize("seed", SEEDS)
def test_polynomials_are_split_and_put_together_as_sympy_does(seed: int) -> None:
    draw = random.Random(seed)
    for even in (True, False):
        f, g = drawn(draw, even), drawn(draw, even, 1)
        p = top((f * g**2).expand())
        own = {AXIS.expression(x): n for x, n in irreducible(p)}
        assert is_even(p) == (not any(n % 2 for (n,) in Poly((f * g**2).expand(), w).monoms()))
        product: Expr = Integer(1)
        for x, n in own.items():
            product *= x**n
        assert (product / AXIS.expression(p)).cancel().is_Rational
        if not even:
            assert sorted(own.values()) == sorted(n for x, n in factor_list((f * g**2).expand())[1] if x.free_symbols)
        if is_even(p):
            assert (AXIS.expression(in_square(p)).subs(w, w**2) - AXIS.expression(p)).expand() == 0
        else:
            assert in_square(p) == p
        for value in (Rational(3), Rational(-2, 3), pi, pi / 3, (pi + 1) / (2 - pi)):
            found = AXIS.expression(substituted(p, 0, AXIS.convert(value)))
            true = AXIS.expression(p).subs(w, value)
            ratio = (found / true).subs(q, Rational(7, 5)) if true != 0 else Integer(1)
            assert ratio.evalf() > 0
            other = (found / true).subs(q, Rational(11, 3)) if true != 0 else Integer(1)
            assert abs(float(ratio / other) - 1) < 1e-9


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_roots_of_an_irreducible_polynomial_in_the_parameter_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    x = Symbol("x")
    for _ in range(4):
        f = sum((draw.randint(-6, 6) * x**n for n in range(draw.randint(1, 3))), Integer(0)) + draw.choice(
            [1, 2]
        ) * x ** draw.randint(1, 3)
        for factor, _ in factor_list(f)[1]:
            if factor == x:
                continue
            p = top(factor.subs(x, q))
            known = sorted(float(r) for r in real_roots(Poly(factor, x)))
            linear = factor.as_poly(x).degree() == 1
            for negative in (True, False):
                found = sorted(float(r) for r in found_roots(p, INDEX, negative=negative))
                assert np.allclose(found, [r for r in known if r > 0 or negative or linear])
            own = AXIS.expression(p)
            assert [*found_roots(top(w), INDEX, negative=True)] == []
            assert own is not None
    of_pi = [*found_roots(top(pi * q - 3 + 2 * pi**2), INDEX, negative=True)]
    assert [float(r) for r in of_pi] == [pytest.approx(float(3 / pi - 2 * pi))]
    assert [float(r) for r in found_roots(top(q**2 - pi), INDEX, negative=True)] == [
        pytest.approx(float(pi**0.5)),
        pytest.approx(-float(pi**0.5)),
    ]


def test_a_factor_in_the_parameter_becomes_a_polynomial_of_the_ring() -> None:
    factor = PolynomialFactor(((1, 2), (3,), (0, 0, 5)), step=1)
    assert (
        AXIS.expression(of_factor(AXIS, INDEX, factor, mirrored=False)).expand()
        == 1 + 2 * pi + 3 * q + 5 * pi**2 * q**2
    )
    assert (
        AXIS.expression(of_factor(AXIS, INDEX, factor, mirrored=True)).expand() == 1 + 2 * pi - 3 * q + 5 * pi**2 * q**2
    )


def broken(functions: list[Any], t: float, grid: Any) -> bool:
    """Whether all functions are positive somewhere on the band."""
    rows = [np.broadcast_to(f(grid, t), grid.shape) for f in functions]
    return bool((np.min(rows, axis=0) > 0).any())


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(40))
def test_a_condition_changes_at_critical_values_alone(seed: int) -> None:
    draw = random.Random(seed)
    functions: list[Expr] = []
    while len(functions) < draw.choice([1, 1, 2]):
        f = drawn(draw, draw.random() < 0.5)
        if f.has(q) and f.has(w):
            functions.append(f if draw.random() < 0.7 else f / (w**2 * q + draw.randint(1, 3)))
    band, grid = (Integer(1), Integer(4)), np.linspace(1, 4, 3001)
    pieces = [RealFunction(AXIS.convert(f)) for f in functions]
    values: list[float] = []
    for _, p in critical(CRITERION, pieces, band):
        if not p.is_zero() and AXIS.expression(p).has(q):
            values += [float(r) for r in real_roots(Poly(AXIS.expression(p), q)) if r > 0]
    told, compiled = np.array(sorted(values)), [lambdify((w, q), f, "numpy") for f in functions]
    for low in np.arange(0.1, 6, 0.1):
        states = [broken(compiled, t, grid) for t in (low, low + 0.1)]
        if states[0] != states[1]:
            a, b = low, low + 0.1
            for _ in range(12):
                middle = (a + b) / 2
                a, b = (middle, b) if broken(compiled, middle, grid) == states[0] else (a, middle)
            assert (abs(told - a) < 3e-3 * (1 + a)).any(), (functions, a, told)


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_polynomials_of_a_boundary_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    f, g = w**2 * draw.randint(1, 4) + q * w + draw.randint(1, 5), w**3 + draw.randint(1, 4) * w + q
    pieces = [RealFunction(AXIS.convert(x)) for x in (f, g)]
    touched = touch_polynomial(pieces)
    true = known_discriminant(f, w) * known_discriminant(g, w) * known_resultant(f, g, w)
    assert (touched / true).cancel().is_Rational
    assert (edge_polynomial(pieces, Integer(3)) / (f * g).subs(w, 3)).cancel().is_Rational
    found = [
        (reason, AXIS.expression(p)) for reason, p in critical(CRITERION, pieces, (Integer(2), Integer(5))) if reason
    ]
    kinds = [reason[1] for reason, _ in found]
    assert [kinds.count(x) for x in (Kind.START, Kind.EDGE, Kind.TOUCH)] == [2, 2, 3]
    over = RealFunction(AXIS.convert(f / (w**2 + q) / (q - 3)))
    undefined = [
        AXIS.expression(p) for reason, p in critical(CRITERION, [over], (Integer(2), Integer(5))) if reason is None
    ]
    assert any(x.has(q) and x.subs(q, 3) == 0 for x in undefined)
    assert not any(x.has(w) for x in undefined)


# Sums that are known to cancel

UNITS = {(): arb(1), (1,): arb.pi(), (2,): arb.pi() ** 2}


def known(draw: random.Random) -> tuple[Any, Expr]:
    parts = {
        key: fmpq(draw.randint(-3, 3), draw.choice([1, 2])) for key in draw.sample([(), (1,), (2,)], draw.randint(0, 3))
    }
    own = sum((Rational(int(c.p), int(c.q)) * pi ** (key[0] if key else 0) for key, c in parts.items()), Integer(0))
    return of_parts(parts, UNITS), own


def told(x: Any) -> Expr:
    return sum(
        (Rational(int(c.p), int(c.q)) * pi ** (key[0] if key else 0) for key, c in parts_of(x).items()), Integer(0)
    )


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_sums_of_multiples_of_pi_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        (x, a), (y, b) = known(draw), known(draw)
        assert told(x) == a
        assert told(added(x, y)) == a + b
        assert isinstance(x, Known) == (not a.is_Rational)
        assert is_exact(x)
        assert abs(float(ball(x)) - float(a)) < 1e-12
        mixed = added(x, arb(2))
        assert not is_exact(mixed)
        assert abs(float(mixed) - float(a) - 2) < 1e-12
        rows = {n: known(draw) for n in draw.sample(range(5), 3)}
        own = ExactPolynomial.of({n: c for n, (c, _) in rows.items()})
        at, sign, t = fmpq(draw.randint(-3, 3), 2), draw.choice([-1, 1]), Symbol("t")
        true = Poly(
            sum(
                (c * (Rational(int(at.p), int(at.q)) + sign * t) ** n for n, (_, c) in rows.items()), Integer(0)
            ).expand(),
            t,
        )
        moved = dict(own.shifted(at, sign))
        assert {n: told(c) for n, c in moved.items()} == {n: c.expand() for (n,), c in true.terms() if c != 0}
        common = own.common
        for part in own.parts.values():
            assert part % common == 0
        x0 = arb(3) / 7
        whole = sum((ball(c) * x0**n for n, (c, _) in rows.items()), arb(0))
        again = own.rest(x0) * common(fmpq(3, 7)) if own.parts and common != fmpq_poly([]) else whole
        assert abs(float(whole) - float(again)) < 1e-9


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_coefficients_at_0_are_those_of_taylor(seed: int) -> None:
    draw, mp = random.Random(seed), mpmath.mp.clone()
    mp.prec = 400
    axis = Ring([], [Rational(1, draw.randint(2, 9)), Rational(3, 7)]).axis
    x, p, s_, t_ = axis.context.gens()
    degrees = [draw.choice([2, 4]) for _ in range(2)]
    polynomial = sum(
        (
            draw.randint(-5, 5)
            * x ** draw.randint(0, 3)
            * p ** draw.randint(0, 1)
            * s_ ** draw.randint(0, degrees[0])
            * t_ ** draw.randint(0, degrees[1])
            for _ in range(4)
        ),
        axis.constant(2),
    )
    rows = beginning(axis, polynomial, degrees, 7)
    assert len(rows) == 7

    def value(at: Any) -> Any:
        total = mp.mpf(0)
        for e, c in polynomial.to_dict().items():
            term = mp.mpf(int(c.p)) / int(c.q) * at ** int(e[0]) * mp.pi ** int(e[1])
            for lag, k, n in zip(axis.lags, map(int, e[2:]), degrees, strict=True):
                half = at * lag.p / lag.q / 2
                term *= mp.sin(half) ** k * mp.cos(half) ** (n - k)
            total += term
        return total

    true = mp.taylor(value, 0, 6)
    for row, c in zip(rows, true, strict=True):
        assert abs(sum(mp.mpf(int(v.p)) / int(v.q) * mp.pi ** key[1] for key, v in row.items()) - c) < 1e-40
        assert all(key[0] == key[2] == key[3] == 0 for key in row)


# Sums of monomials next to a corner


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_sum_of_monomials_is_the_same_however_it_is_written(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(6):
        given = {
            (Fraction(draw.randint(0, 6), 2), Fraction(draw.randint(0, 4))): fmpq(
                draw.choice([-5, -1, 2, 3]), draw.randint(1, 3)
            )
            for _ in range(5)
        }
        own = Monomials.of(given)
        assert dict(own.terms) == given
        assert own.has_constant == ((Fraction(0), Fraction(0)) in given)

        def at(x: float, y: float, given: Any = given) -> float:
            return float(sum(float(c.p) / float(c.q) * x ** float(a) * y ** float(b) for (a, b), c in given.items()))

        def found(m: Monomials, x: float, y: float) -> float:
            return float(m.over((arb(x), arb(x)), (arb(y), arb(y))))

        x, y = draw.uniform(0.2, 2), draw.uniform(0.2, 2)
        near = lambda value: pytest.approx(value, rel=1e-9, abs=1e-9)  # noqa: E731
        assert found(own, x, y) == near(at(x, y))
        p = Fraction(draw.randint(1, 5), draw.randint(1, 3))
        risen = own.risen(p)
        least = min(a + p * b for a, b in given)
        assert found(risen, x, y) == near(at(x, x ** float(p) * y) / x ** float(least))
        place, sign = fmpq(draw.randint(1, 3), 2), draw.choice([-1, 1])
        assert found(own.shifted(place, sign), x, y) == near(at(x, float(place.p) / float(place.q) + sign * y))
        rows = sorted({a for a, _ in given})
        for n, a in enumerate(rows):
            above = own.above(n)
            rest = at(x, y, {e: c for e, c in given.items() if e[0] > a})
            assert (0 if above is None else found(above, x, y)) == near(rest)
        a, b = draw.choice([*given])
        assert found(own.over_power(a, b), x, y) == near(at(x, y) / (x ** float(a) * y ** float(b)))
        lowest = min(a for a, _ in given), min(b for _, b in given)
        zero = arb(0)
        reduced = own.reduced((zero, arb(1)), (zero, arb(1)))
        assert found(reduced, x, y) == near(at(x, y) / (x ** float(lowest[0]) * y ** float(lowest[1])))
        assert own.reduced((arb(1), arb(2)), (arb(1), arb(2))) is own or found(
            own.reduced((arb(1), arb(2)), (arb(1), arb(2))), x, y
        ) == near(at(x, y))
        along = own.along(arb(y))
        assert [float(c) for c in along] == [
            near(at(1, y, {e: c for e, c in given.items() if e[0] == a})) for a in rows
        ]
        box = own.over((arb(x), arb(x + 0.5)), (arb(y), arb(y + 0.3)))
        for i in range(4):
            for k in range(4):
                assert (box - arb(at(x + i / 6, y + k / 10))).abs_lower() < 1e-9
        negative = {
            e: abs(float(c.p) / float(c.q)) * x ** float(e[0]) * y ** float(e[1]) for e, c in given.items() if c < 0
        }
        assert own.most_negative(arb(x), arb(y)) == (max(negative, key=lambda e: negative[e]) if negative else None)
    assert float(power(arb(8), Fraction(2, 3))) == pytest.approx(4)
    assert power(arb(0), Fraction(1, 3)) == 0
    assert power(arb(0), Fraction(0)) == 1
    assert float(power(arb(2), Fraction(-1))) == 0.5


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", range(40))
def test_signs_next_to_a_corner_are_those_of_samples_however_near(seed: int) -> None:
    draw = random.Random(seed)
    given = {
        (Fraction(draw.randint(0, 6), 2), Fraction(draw.randint(0, 4))): fmpq(draw.choice([-6, -4, -2, -1, 1, 2]))
        for _ in range(draw.randint(2, 5))
    }

    def at(x: float, y: float) -> float:
        return float(sum(float(c.p) * x ** float(a) * y ** float(b) for (a, b), c in given.items()))

    grid = [2.0 ** (-n / 3) for n in range(1, 60)]
    with flint.ctx.workprec(96):
        end = arb(2.0 ** (-1 / 3))
        if is_negative(given, end, end):
            assert all(at(x, y) < 0 for x in grid for y in grid)
        height = positive_along(given, end, end)
        if height is not None:
            low = float(height.lower())
            assert low > 0
            for n in range(0, 60, 6):
                y = low * 2.0**-n
                assert any(at(2.0 ** (-k / 8 - 1 / 3), y) > 0 for k in range(4000)), (given, y)
        if all(c < 0 for c in given.values()):
            assert is_negative(given, end, end)
        if all(c > 0 for c in given.values()):
            assert height is not None
        assert height is None or not is_negative(given, end, end)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_runs_of_a_set_along_a_line(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(40):
        at = [draw.random() < 0.5 for _ in range(draw.randint(1, 6))]
        between = [draw.random() < 0.5 for _ in at[1:]]
        line = [x for pair in zip(at, [*between, False], strict=True) for x in pair][:-1]
        inside = [False] * len(line)
        for first, last, has_first, has_last in runs(at, between):
            a, b = 2 * first + (not has_first), 2 * last - (not has_last)
            assert a <= b
            assert all(line[a : b + 1])
            assert not any(inside[max(a - 1, 0) : b + 2])
            inside[a : b + 1] = [True] * (b + 1 - a)
        assert inside == line


@pytest.mark.parametrize("seed", range(6))
def test_a_sum_of_exact_and_of_known_and_of_enclosed_terms_is_the_same_from_another_place_on(seed: int) -> None:
    """In w, Y = at + sign w: each coefficient that is exact stays so where no ball is added to it."""
    draw = random.Random(seed)
    rows: dict[tuple[Fraction, Fraction], Any] = {}
    for a in (0, 1, 3):
        for b in draw.sample(range(6), 3):
            value = Fraction(draw.randint(-9, 9) or 1, draw.choice([1, 2]))
            exact = fmpq(value.numerator, value.denominator)
            rows[Fraction(a, 2), Fraction(b)] = draw.choice(
                [exact, arb(exact), Known({(): exact, (1,): exact}, {(): arb(1), (1,): arb.pi()})]
            )
    own = Monomials.of(rows)
    at, sign = fmpq(draw.randint(1, 7), 2), draw.choice([1, -1])
    moved = own.shifted(at, sign)
    for step in (fmpq(1, 3), fmpq(5, 4)):
        for x in (fmpq(1, 4), fmpq(9, 4)):
            X, Y, W = arb(x), arb(at + sign * step), arb(step)
            truth = sum((ball(value) * power(X, a) * Y ** int(b) for (a, b), value in rows.items()), arb(0))
            found = sum((ball(value) * power(X, a) * W ** int(b) for (a, b), value in moved.terms.items()), arb(0))
            assert truth.overlaps(found)
            assert found.rad() < 1e-9
    for (a, _), value in moved.terms.items():
        if all(is_exact(y) for (other, _), y in rows.items() if other == a):
            assert is_exact(value)


@pytest.mark.parametrize("touch", [1, 2, 5])
@pytest.mark.parametrize("p", [Fraction(1), Fraction(2), Fraction(3, 2)])
def test_charts_meet_beyond_all_numbers_at_which_what_is_left_along_a_slope_touches_0(p: Fraction, touch: int) -> None:
    """-(Y - t X^p)^2 (Y + X^p), and more that is less near the corner: along Y = X^p v it is -(v - t)^2 (v + 1)."""
    t = touch
    rows = {(0, 3): -1, (p, 2): 2 * t - 1, (2 * p, 1): 2 * t - t**2, (3 * p, 0): -(t**2)}
    terms = {(Fraction(a), Fraction(b)): fmpq(n) for (a, b), n in rows.items() if n} | {(4 * p, Fraction(1)): fmpq(7)}
    own = Monomials.of(terms)
    slope, meet = own.slope
    assert slope == p
    assert meet == 2 * t
    assert own.risen(p).touches == (fmpq(t),)
    assert [float(x) for x in own.risen(p).along(arb(meet))] == [-(t**2) * (2 * t + 1), 14 * t]


@pytest.mark.parametrize("seed", range(4))
def test_what_is_the_square_of_a_modulus_is_seen_to_be_positive_and_no_other_irreducible_polynomial(seed: int) -> None:
    """|f(j omega)|^2 of f with the parameter in its coefficients; omega^2 - a is none, nor -|f|^2, nor what has omega alone."""
    draw = random.Random(seed)
    m, b, k = (Rational(draw.randint(1, 9)) for _ in range(3))
    square = top(((k * q - m * w**2) ** 2 + (b * w) ** 2).expand())
    mirrored = top((-((k * q - m * w**2) ** 2) - (b * w) ** 2).expand())
    assert _is_modulus(square)
    assert _is_positive(square)
    for other in (mirrored, top(w**2 - k * q), top(w + k * q), top(w**2 - m * w + k)):
        assert not _is_modulus(other)
        assert not _is_positive(other)
    assert _is_positive(top(m * w**2 + k * q**2 + b))
    assert not _is_positive(top(m * w**2 + k * q**2 - b))
    assert not _is_positive(top(m * w**2 + k * q + b))
