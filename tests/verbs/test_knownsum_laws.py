"""Sums of rational multiples of known numbers, and extrema at values known to any precision."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import pi as turn
from random import Random
from types import SimpleNamespace
from typing import Any

import flint
import pytest
from flint import arb, fmpq, fmpq_poly
from sympy import Expr, Integer, Poly, Rational, S, Symbol, diff, gcd, sqrt

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.reals import ExactNumber, SquareRoot
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.symbols import omega, s
from haptisym.verbs.require.knownsums import ExactPolynomial, Known, added, ball, is_exact, of_parts, parts_of
from haptisym.verbs.require.touches import Surface, Surfaces, isolated_touch, touch

Q, P = Symbol("q", positive=True), Symbol("p", positive=True)


UNITS = {(): arb(1), (1,): arb.pi(), (0, 1): arb(2).sqrt()}
SIZES = {(): 1.0, (1,): turn, (0, 1): 2**0.5}


def multiples(pick: Random) -> dict[Any, Any]:
    return {key: fmpq(pick.randint(-2, 2), pick.randint(1, 3)) for key in pick.sample([*UNITS], pick.randint(0, 3))}


def size(parts: Any) -> float:
    return sum(int(x.p) / int(x.q) * SIZES[key] for key, x in parts.items())


@pytest.mark.parametrize("seed", range(3))
def test_sums_of_multiples_are_exact_where_both_are_and_know_where_they_cancel(seed: int) -> None:
    pick = Random(seed)
    for _ in range(60):
        a, b = multiples(pick), multiples(pick)
        x, y = (of_parts(z, {key: UNITS[key] for key in z}) for z in (a, b))
        for value, own in ((x, a), (y, b)):
            left = {key: z for key, z in own.items() if z}
            assert isinstance(value, fmpq) is (set(left) <= {()})
            assert dict(parts_of(value)) == left
            assert is_exact(value)
            assert float(ball(value)) == pytest.approx(size(own), abs=1e-14)
        both = {key: a.get(key, fmpq(0)) + b.get(key, fmpq(0)) for key in {*a, *b}}
        total = added(x, y)
        assert dict(parts_of(total)) == {key: z for key, z in both.items() if z}
        assert isinstance(total, fmpq) is (not any(z for key, z in both.items() if key))
        assert float(ball(total)) == pytest.approx(size(both), abs=1e-14)
        minus = of_parts({key: -z for key, z in a.items()}, UNITS)
        assert added(x, minus) == 0
        for mixed in (added(x, arb(1) / 3), added(arb(1) / 3, x)):
            assert not is_exact(mixed)
            assert float(mixed) == pytest.approx(size(a) + 1 / 3, abs=1e-14)
    assert isinstance(added(fmpq(1), fmpq(2)), fmpq)
    assert dict(parts_of(fmpq(0))) == {}


@pytest.mark.parametrize("seed", range(4))
def test_an_exact_polynomial_moves_and_splits_into_its_rational_factor_and_the_rest(seed: int) -> None:
    """A common factor that was placed, times coefficients with pi and the root of 2; moved to at + sign w."""
    pick, x = Random(seed), Symbol("x")
    factor = fmpq_poly([pick.randint(1, 5), pick.randint(1, 3), 1][pick.randint(0, 2) :])
    parts = {
        key: factor * fmpq_poly([pick.randint(-3, 3), pick.randint(1, 4)])
        for key in pick.sample([*UNITS], pick.randint(2, 3))
    }
    most = max(own.degree() for own in parts.values())
    rows = {n: of_parts({key: own[n] for key, own in parts.items()}, UNITS) for n in range(most + 1)}
    found = ExactPolynomial.of({n: value for n, value in rows.items() if value != 0})
    assert {key: own for key, own in found.parts.items() if own} == parts
    plain = [Poly([Rational(int(c.p), int(c.q)) for c in reversed(own.coeffs())], x) for own in parts.values()]
    common = plain[0]
    for own in plain[1:]:
        common = gcd(common, own)
    monic = [
        Rational(int(c.p), int(c.q)) for c in reversed((found.common / found.common[found.common.degree()]).coeffs())
    ]
    assert monic == common.monic().all_coeffs()
    at, sign = fmpq(pick.randint(-5, 5), 2), pick.choice([1, -1])
    shifted = dict(found.shifted(at, sign))
    for w in (fmpq(1, 3), fmpq(-2), fmpq(5, 4)):
        place = at + sign * w
        true = sum((ball(value) * arb(place) ** n for n, value in rows.items()), arb(0))
        assert abs(float(sum((ball(y) * arb(w) ** n for n, y in shifted.items()), arb(0)) - true)) < 1e-9
        assert abs(float(arb(found.common(place)) * found.rest(arb(place)) - true)) < 1e-9
    assert all(is_exact(y) and (isinstance(y, Known) or y != 0) for y in shifted.values())
    assert len(shifted) <= most + 1
    assert dict(ExactPolynomial({}, {}).shifted(fmpq(1), 1)) == {}


def test_a_polynomial_of_rational_numbers_alone_moves_as_such_a_polynomial_and_what_is_0_is_not_told() -> None:
    for row, at, sign in (([1, 0, 3], 2, -1), ([4, -4, 1], 2, 1), ([0, 0, 0, 5], 0, -1), ([7], 3, 1)):
        moved = fmpq_poly(row)(fmpq_poly([at, sign]))
        found = ExactPolynomial.of({n: fmpq(x) for n, x in enumerate(row) if x})
        expected = {n: moved[n] for n in range(moved.degree() + 1) if moved[n] != 0}
        assert dict(found.shifted(fmpq(at), sign)) == expected


# --- touches ----------------------------------------------------------------------------------------------------------

ROOT = SquareRoot(ExactNumber(Integer(2)))


def function(top: Expr, bottom: Expr = S.One) -> RealFunction:
    """A real function of omega and q, as the real part of one of s."""
    form = (top / bottom).subs(omega, s)
    return RealFunction(on_axis(Ring.of([form, Q, s]).convert(form.subs(s**2, -(s**2)))).real.function)


@pytest.mark.parametrize("seed", range(4))
def test_an_extremum_is_found_to_any_precision_where_it_is_the_only_one_between_two_frequencies(seed: int) -> None:
    """c (x^2 - q a x) over 1 and more, x = omega^2: at omega = (a q/2)^(1/2) for q = 2^(1/2), a maximum or a minimum."""
    pick = Random(seed)
    a, c = Rational(pick.randint(2, 9)), Rational(pick.choice([-2, -1, 1, 3]))
    top = c * (omega**4 - Q * a * omega**2)
    surface = Surface.of(function(top), Q)
    for bottom, own in ((Integer(1), surface), (omega**2 + Q, Surface.of(function(top, omega**2 + Q), Q))):
        for w, form, order in product((0.75, 2.0), (own.slope, own.bend), (1, 2)):
            if (form is own.slope) is (order == 1):
                true = diff(top / bottom, omega, order).subs({omega: Rational(w), Q: sqrt(2)}).evalf(40)
                with flint.ctx.workprec(200):
                    assert abs(float(own.ball(form, arb(w), ROOT.ball(200)) - arb(str(true)))) < 1e-28
    at = sqrt(a * sqrt(2) / 2)
    for low, high, there in (
        (0.8, 1.2, True),
        (0.999, 1.001, True),
        (1.01, 1.2, False),
        (0.8, 0.99, False),
        (1.2, 1.3, False),
    ):
        start, end = (ExactNumber(Rational((at * x).evalf(20)).limit_denominator(10**9)) for x in (low, high))
        found = touch(surface, ROOT, start, end)
        assert (found is not None) is there
        if found is not None:
            for bits in (64, 300):
                assert found.ball(bits).overlaps(arb(str(at.evalf(120))))
                assert found.ball(bits).rel_accuracy_bits() >= bits - 8
    same = ExactNumber(Rational(at.evalf(20)).limit_denominator(10**6))
    assert touch(surface, ROOT, same, same) is None
    assert touch(surface, ROOT, same, same, beyond=8) is not None
    assert touch(surface, ROOT, same, same, beyond=60) is None
    wide = touch(surface, ROOT, ExactNumber(Rational(1, 100)), ExactNumber(Rational(10)))
    assert wide is None  # another one is at 0, and the curvature changes its sign


def test_an_interval_that_shrinks_to_a_point_is_the_extremum_of_one_function_or_the_zero_of_another() -> None:
    """One function that vanishes at both ends has its extremum there; of two the zero of the first at which that shows."""
    bump, line = function(-(omega**4) + 2 * Q * omega**2), function(omega**2 - Q, omega**2 + 1)
    surfaces = [Surfaces.of(x, Q) for x in (line, bump)]
    at = float(2**0.25)
    low, high = (ExactNumber(Rational(x).limit_denominator(10**6)) for x in (at - 0.01, at + 0.01))

    def near(first: dict[int, int], last: dict[int, int], beyond: int = 0) -> float | None:
        interval: Any = SimpleNamespace(
            low=SimpleNamespace(omega=low, orders=first), high=SimpleNamespace(omega=high, orders=last)
        )
        found = isolated_touch(surfaces, ROOT, interval, beyond)
        return None if found is None else float(found)

    assert near({1: 1}, {1: 1}) == pytest.approx(at, rel=1e-15)  # the bump is greatest at omega^2 = q
    assert near({0: 1}, {0: 1}) is None  # a line has no extremum
    assert near({0: 1}, {0: 1, 1: 1}) is None
    assert near({0: 1, 1: 2}, {1: 1}) == pytest.approx(at, rel=1e-15)
    assert near({0: 1}, {1: 1}) == pytest.approx(at, rel=1e-15)  # the zero of the line
    assert near({0: 1}, {}) == pytest.approx(at, rel=1e-15)
    assert near({}, {0: 1}) == pytest.approx(at, rel=1e-15)
    assert near({1: 1}, {}) is None  # the bump has no zero there
    assert near({}, {}) is None
    assert near({0: -1}, {0: 0}) is None  # a pole is no zero
    for first in (0, 1):
        assert near({first: 1}, {1 - first: 1}) == pytest.approx(at, rel=1e-15)
    low = ExactNumber(Rational(at + 1e-5).limit_denominator(10**9))
    assert near({0: 1}, {}) == pytest.approx(at, rel=1e-15)  # a little outside of the interval, too
    assert near({1: 1}, {1: 1}) is None
    value = Fraction(near({0: 1}, {0: 0}, 3) or 0)
    assert float(value) == pytest.approx(at, rel=1e-15)
