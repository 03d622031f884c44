"""Corners placed by hand: a function that rises through 0 where another falls, for cells below, around and above the value."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import pi
from random import Random

import flint
import mpmath
import pytest
from flint import arb
from plainshapes import exact, q, rational, real_part, shape_of, strip_of
from sympy import Expr, exp, lambdify

from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.require.corners import Corner, ZeroAt, _steepness, corner_signs, zero
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.places import CriticalPlace, Strip
from haptisym.verbs.require.strips import Shape

MP = mpmath.mp.clone()
MP.dps = 60
NARROW = Fraction(1, 1 << 12)


def between(low: Fraction, high: Fraction) -> CriticalPlace:
    return CriticalPlace(Kind.TOUCH, exact(low), exact(high), piece=0, other=1)


def signs(own: Iterable[Strip], place: CriticalPlace) -> tuple[int, int] | None:
    rising, falling = own
    return corner_signs(rising, falling, place)


@pytest.mark.parametrize("seed", range(4))
def test_at_a_corner_the_least_of_two_functions_changes_its_sign_with_the_value(seed: int) -> None:
    """(w - x)(1 + e (w - x)^2) a + b (q - v), zero at about w = x - b (q - v)/a, and -(w - x) c + d (q - v)."""
    pick = Random(seed)
    for _ in range(3):
        x, v = Fraction(pick.randint(8, 40), 8), Fraction(pick.randint(-20, 20), 4)
        a, c, e = (pick.randint(1, 4) for _ in range(3))
        b, d = pick.choice([(0, 1), (0, -2), (1, 0), (-1, 0), (2, 1), (-2, 1), (1, -2)])
        steep = Fraction(d) + Fraction(c * b, a)
        if abs(steep) < Fraction(1, 2):
            continue
        rising = a * (w - rational(x)) * (1 + e * (w - rational(x)) ** 2) + b * (q - rational(v))
        falling = -c * (w - rational(x)) + d * (q - rational(v))
        with flint.ctx.workprec(160):
            place = between(x - Fraction(1, 32), x + Fraction(1, 16))
            for low, high in ((v - NARROW, v + 2 * NARROW), (v + NARROW, v + 2 * NARROW), (v - 3 * NARROW, v - NARROW)):
                own = strip_of(rising, low, high), strip_of(falling, low, high)
                assert signs(own, place) == tuple(1 if (t - v) * steep > 0 else -1 for t in (low, high))
            ends = strip_of(rising, v, v + NARROW), strip_of(falling, v, v + NARROW)
            assert signs(ends, place) is None  # at an end of the cell the sign is not known
        found = Corner(
            shape_of(rising), shape_of(falling), (place.low, place.high), exact(v - NARROW), exact(v + 2 * NARROW)
        )
        for bits in (50, 300) if d else (140,):
            for number, true in ((found, v), (ZeroAt(found), x)):
                near = number.ball(bits)
                assert near.contains(exact(true))
                assert near.rad() < arb(2) ** (12 - bits)


def test_a_corner_of_waves_has_its_value_in_closed_form() -> None:
    """-cos(q w) rises through 0 at q w = pi/2, where c - w falls through it at w = c: q is pi/(2 c)."""
    for c in (Fraction(1), Fraction(5, 2)):
        rising, falling = (Shape.of(real_part(f), q) for f in (-exp(-q * s), rational(c) + s * s / rational(c)))
        value = Fraction(pi / 2) / c
        low, high = value - Fraction(1, 64), value + Fraction(1, 32)
        with flint.ctx.workprec(128):
            place = between(c - Fraction(1, 8), c + Fraction(1, 8))
            own = (Strip.of(f, exact(low), exact(high)) for f in (rising, falling))
            assert signs(own, place) == (-1, 1)  # with a longer delay the zero comes earlier
            found = Corner(rising, falling, (place.low, place.high), exact(low), exact(high))
        with flint.ctx.workprec(300):
            assert found.ball(200).overlaps(arb.pi() / (2 * exact(c)))
            assert ZeroAt(found).ball(200).contains(exact(c))


@pytest.mark.parametrize("seed", range(6))
def test_how_fast_the_one_changes_at_the_zero_of_the_other_is_a_total_derivative(seed: int) -> None:
    pick = Random(seed)

    def some() -> Expr:
        a, b, c = (pick.randint(1, 5) for _ in range(3))
        return pick.choice([a * w + b * w**3 - c * q, a * w - b * q**2 * w**2 / 50, b * q + a * w**2, a * w**2 + b * w])

    one, other = some() - 7, pick.choice([-1, 1]) * some()
    f, g = (lambdify((w, q), x, modules=[MP, "mpmath"]) for x in (one, other))
    t = Fraction(pick.randint(4, 12), 8)
    T = MP.mpf(t.numerator) / t.denominator

    def moved(value: object) -> object:
        at = MP.findroot(lambda x: f(x, value), 1.0)
        return g(at, value)

    true = MP.diff(moved, T)
    with flint.ctx.workprec(200):
        at = arb(MP.nstr(MP.findroot(lambda x: f(x, T), 1.0), 55))
        found = _steepness(shape_of(one), shape_of(other), exact(t), at)
    assert abs(float(found.mid()) - float(true)) < 1e-14 * (1 + abs(float(true)))
    assert found.rad() < 1e-15 * (1 + abs(float(true)))


def test_there_is_a_corner_only_where_both_vanish_for_all_values_and_what_decides_changes_one_way() -> None:
    """Zeros at r and f, of which the first moves a little with q, between 3 and 5: outside, at an end, and beside each other."""
    marks = [Fraction(n) for n in range(2, 7)] + [Fraction(9, 2)]
    with flint.ctx.workprec(128):
        for r in marks:
            for f in marks:
                moving = w - rational(r) + (q - 1) / 1000
                own = [strip_of(x, 1 - NARROW, 1 + NARROW) for x in (moving, rational(f) - w)]
                found = signs(own, between(Fraction(3), Fraction(5)))
                if r == f and 3 < r < 5:
                    assert found == (-1, 1)  # below 1 the first has its zero later, where the second is negative
                elif 3 < r < 5 and 3 < f < 5:
                    assert found == ((1, 1) if f > r else (-1, -1))
                else:
                    assert found is None
                assert corner_signs(own[1], own[0], between(Fraction(3), Fraction(5))) is None
        rising, falling = shape_of(q * w - 4 * q), shape_of(4 * q - w * q)
        alike = [Strip.of(x, exact(1), exact(2)) for x in (rising, falling)]
        assert signs(alike, between(Fraction(3), Fraction(5))) is None  # whether it changes one way is not sure
        level = 4 - w + (q - 1) ** 2 - rational(NARROW**2 / 4)  # at the zero of w - 4 it falls and rises again
        turning = [strip_of(x, 1 - NARROW, 1 + NARROW) for x in (w - 4 + 0 * q, level)]
        assert signs(turning, between(Fraction(3), Fraction(5))) is None
        slow = [strip_of(x, 1 - NARROW, 1 + NARROW) for x in (w - 4 + 0 * q, 4 - w + (1 - q) / 100)]
        assert signs(slow, between(Fraction(3), Fraction(5))) == (1, -1)
        inverse = arb(1) / 2
        far = [Strip.beyond(x, inverse) for x in (shape_of(q * w - 4 * q), shape_of(4 * q - w * q - 1))]
        assert signs(far, between(Fraction(3), Fraction(5))) is None


@pytest.mark.parametrize("t", [Fraction(1, 2), Fraction(3)])
def test_a_zero_between_two_frequencies_is_that_of_the_function_for_the_value(t: Fraction) -> None:
    with flint.ctx.workprec(200):
        found = zero(shape_of(w**2 - q), exact(t), (exact(Fraction(1, 2)), exact(2)), 200)
        assert found.contains(exact(t).sqrt())
        assert found.rad() < 1e-45
        wide = zero(
            shape_of(w**2 - q), exact(t).union(exact(t + Fraction(1, 4))), (exact(Fraction(1, 2)), exact(2)), 200
        )
        assert wide.contains(exact(t).sqrt())
        assert wide.contains(exact(t + Fraction(1, 4)).sqrt())
