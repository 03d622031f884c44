"""What becomes of conditions as a parameter goes to 0 or without bound, step by step: against formulas, exactly, and sampled."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from math import cos, sin, tau
from random import Random

import flint
import pytest
from flint import arb
from plainshapes import exact, function_of, q, rational, real_part
from sympy import Expr, Integer, Rational, exp, lambdify, pi, sqrt

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.require.knownsums import ball
from haptisym.verbs.require.limits import (
    Limit,
    _alone,
    _at_phases,
    _exact,
    _order_in,
    _rational,
    _terms,
    _turned,
    long,
    short,
)
from haptisym.verbs.require.places import CellVerdict

KEPT, BROKEN, OPEN = CellVerdict.KEPT, CellVerdict.BROKEN, CellVerdict.OPEN


@pytest.mark.parametrize("seed", range(10))
def test_a_polynomial_in_a_parameter_becomes_one_in_what_goes_to_0_of_the_same_sign(seed: int) -> None:
    """P(w, t) at t = u, -u, 1/u and -1/u is the other times a power of u, and that has a term without u."""
    pick = Random(seed)
    for inverse, sign in product([False, True], [1, -1]):
        rows = {(i, n): pick.randint(-5, 5) for i in range(3) for n in range(pick.randint(0, 2), pick.randint(3, 5))}
        rows[1, 3], rows[0, 2] = 7, pick.choice([-3, 3])
        own = function_of(sum((c * w**i * q**n for (i, n), c in rows.items()), Integer(0)))
        index = own.axis.meanings.index(q)
        found = _turned(own.function.numerator, index, inverse=inverse, sign=sign)
        powers = {int(e[index]) for e in found.monoms()}
        assert min(powers) == 0
        real = {n for (_, n), c in rows.items() if c}
        assert max(powers) == max(real) - min(real)
        least = -max(real) if inverse else min(real)
        for x, u in product(
            [Fraction(2), Fraction(-1, 3), Fraction(5, 7)], [Fraction(1, 2), Fraction(3), Fraction(1, 5)]
        ):
            t = sign * (1 / u if inverse else u)
            before = sum(c * x**i * t**n for (i, n), c in rows.items())
            after = sum(
                Fraction(int(c.p), int(c.q)) * x ** int(e[0]) * u ** int(e[index]) for e, c in found.to_dict().items()
            )
            assert before == after * u**least


@pytest.mark.parametrize("seed", range(3))
def test_near_0_a_condition_is_the_sum_of_its_monomials(seed: int) -> None:
    """Of powers s^(1/2) and s^(2/3), delays, pi and the parameter before each; for both directions and signs."""
    pick = Random(seed)
    c = [Rational(pick.choice([-3, -2, 1, 2, 5]), pick.choice([1, 2])) for _ in range(6)]
    formula = c[0] * q**2 * s ** Rational(1, 2) + c[1] * q + c[2] * pi * s**2 * q**2 + pick.choice([
        c[3] * exp(-s / 3) * q, c[3] * s ** Rational(2, 3), c[3] * exp(-s / 2) * s ** Rational(3, 2),
        c[3] * q**3 * (exp(-s / 5) - 1),
    ]) + c[4] * s**4  # fmt: skip
    for inverse, sign in ((False, 1), (False, -1), (True, 1), (True, -1)):
        with flint.ctx.workprec(200):
            limit = Limit.of([real_part(formula)], q, (Integer(0), Integer(1)), inverse=inverse, sign=sign)
            assert limit is not None
            assert (limit.inverse, limit.sign) == (inverse, sign)
            [shape] = limit.shapes
            known = _terms(shape, arb(1) / 8)
            assert any(b == 0 for _, b in known)
            for x, u in (
                (Fraction(1, 64), Fraction(1, 32)),
                (Fraction(1, 9), Fraction(2)),
                (Fraction(1, 500), Fraction(1, 7)),
            ):
                X, U = exact(x), exact(u)
                total = sum((ball(value) * X ** exact(a) * U ** exact(b) for (a, b), value in known.items()), arb(0))
                value = shape.over(U).value(X)
                assert total.overlaps(value)
                assert abs(float(total.mid() - value.mid())) <= 1e-7 * (1 + abs(float(value.mid())))
                t = sign * (1 / u if inverse else u)
                least = (
                    -max(int(e[0]) for e in _powers(formula)) if inverse else min(int(e[0]) for e in _powers(formula))
                )
                true = complex(formula.subs({q: rational(t), s: 1j * rational(x)}).evalf(30)).real
                assert float(value.mid()) * float(u) ** least == pytest.approx(true, rel=1e-9)


def _powers(formula: Expr) -> list[tuple[int, ...]]:
    """Of the parameter, of each term of the real part, where no term vanishes."""
    return [(int(term.as_coeff_exponent(q)[1]),) for term in formula.expand().args]


def test_a_limit_is_asked_of_numbers_in_no_delay_and_in_no_exponent() -> None:
    for formula in (exp(-q * s) + q, s**q + 1, q * s ** (q / 2)):
        assert Limit.of([real_part(formula)], q, (Integer(0), Integer(1)), inverse=False, sign=1) is None
    assert (
        Limit.of([real_part(q * exp(-s) + s ** Rational(1, 2))], q, (Integer(0), Integer(1)), inverse=True, sign=1)
        is not None
    )
    assert _rational(Rational(-3, 7)) == Fraction(-3, 7)
    for x in (pi, sqrt(2)):
        with pytest.raises(UndecidedError, match="no rational number"):
            _rational(x)


@pytest.mark.parametrize("x", [Fraction(1, 3), Fraction(-1, 3), Fraction(2, 3), Fraction(10**30 + 1), Fraction(3, 4)])
def test_a_double_that_is_not_larger_is_the_nearest_one_below(x: Fraction) -> None:
    with flint.ctx.workprec(200):
        found = _exact(exact(x))
    assert Fraction(float(found)) == found <= x
    assert x - found <= abs(x) / 2**51


def test_a_verdict_stays_and_places_that_are_left_are_open() -> None:
    assert [_alone(x) for x in CellVerdict] == [*CellVerdict]
    assert (_alone([]), _alone([1]), _alone([1, 2])) == (KEPT, OPEN, OPEN)


@pytest.mark.parametrize(
    ("formula", "order"),
    [
        (q * exp(-q * s), 1), (q**2 * s + q * 3, 1), (exp(-q * s) - 1, 2), (exp(-q * s), 0), (s * (exp(-q * s) - exp(q * s)), 1),
        (q * (exp(-q * s) - 1), 3), (q * (exp(-s / 3) - 1), 1), (q**3 + exp(-s / 3) * q**2, 2), (5 + q, 0),
    ],
)  # fmt: skip
def test_the_power_of_a_delay_that_all_terms_hold_is_counted_in_numbers_and_in_tangents(
    formula: Expr, order: int
) -> None:
    """cos - 1 is -2 sin^2 of half the angle, over cos^2 + sin^2: two tangents."""
    assert _order_in(real_part(formula), q) == order


@pytest.mark.parametrize("seed", range(5))
def test_as_a_delay_goes_to_0_all_conditions_must_be_kept_and_one_that_is_broken_is_enough(seed: int) -> None:
    rows = [
        (exp(-q * s) - 2, KEPT), (2 * exp(-q * s) - 1, BROKEN), (exp(-q * s) - 1, KEPT), (1 - exp(-q * s), BROKEN),
        (q * s**2 - q, KEPT), (s * exp(-q * s) - q * 4, OPEN), (-q * exp(-q * s), KEPT),
    ]  # fmt: skip
    pick = Random(seed)
    for _ in range(6):
        chosen = pick.sample(rows, pick.choice([1, 2, 3]))
        with flint.ctx.workprec(128):
            found = short([real_part(x) for x, _ in chosen], q, (Integer(1), Integer(2)), Fraction(1, 128))
        told = [x for _, x in chosen]
        assert found is (BROKEN if BROKEN in told else OPEN if OPEN in told else KEPT)


@pytest.mark.parametrize("seed", range(6))
def test_several_conditions_are_kept_near_a_limit_where_all_are_and_broken_where_one_is(seed: int) -> None:
    """On bands from 1 and from 0 on; what is said holds for all u up to the number that comes with it."""
    pick = Random(seed)
    rows = [
        (q - 1, KEPT), (1 - q, BROKEN), (q * w**2 - 3, KEPT), (w**2 - q - 9, KEPT), (w**2 - 3 - q, BROKEN),
        (q**2 - q, KEPT), (q + q**2 * w**2, BROKEN),
    ]  # fmt: skip
    for low in (0, 1):
        chosen = pick.sample(rows, pick.choice([1, 2, 3]))
        with flint.ctx.workprec(128):
            limit = Limit.of([function_of(x) for x, _ in chosen], q, (Integer(low), Integer(2)), inverse=False, sign=1)
            assert limit is not None
            reach = Fraction(1, pick.choice([1, 2, 16, 256]))
            found, up_to = limit.verdict(reach, 8)
        true = BROKEN if BROKEN in [x for _, x in chosen] else KEPT
        assert found is true or (found is OPEN and reach > Fraction(1, 16))
        assert 0 < up_to <= reach
        plain = [lambdify((w, q), f, "math") for f, _ in chosen]
        for n in (1, 3, 100):
            tops = [f(low + k / 50, float(up_to) / n) for f in plain for k in range(1, 50 * (2 - low) + 1)]
            assert found is OPEN or (max(tops) > 0) is (found is BROKEN)


# Delays without bound


@pytest.mark.parametrize("rate", [1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_beyond_a_long_delay_a_condition_is_broken_somewhere_for_every_value(seed: int, rate: int) -> None:
    """a cos + b w sin of rate q w, and c and d/q: the longest run of sixteenths of the band tells how far."""
    pick = Random(seed)
    a, b, c, d = pick.randint(1, 6), pick.choice([-1, 0, 1]), pick.randint(-5, 2), pick.choice([0, 3])
    formula = q * (a * exp(-rate * q * s) + b * s * exp(-rate * q * s) + c) + d
    with flint.ctx.workprec(128):
        found = long([real_part(formula)], q, (Integer(1), Integer(3)))
    edges = [1 + 2 * Fraction(i, 16) for i in range(17)]
    longest = wide = Fraction(0)
    for tangent in (0, 1, -1, 3, -3):
        x, y = Fraction(1 - tangent**2, 1 + tangent**2), Fraction(2 * tangent, 1 + tangent**2)
        run = loose = 0
        for low, high in pairwise(edges):
            run = run + 1 if min(a * x + b * y * v + c for v in (low, high)) > Fraction(1, 9) else 0
            loose = loose + 1 if min(a * x + b * y * v + c for v in (low, high)) > -Fraction(1, 99) else 0
            longest, wide = max(longest, Fraction(run, 8)), max(wide, Fraction(loose, 8))
    if not longest:
        return
    assert found is not None
    assert float(found) <= max(1024 / (3 * rate), 1.02 * tau / (rate * float(longest))) * 1.001
    assert float(found) >= 16 / (3 * rate) * 0.999
    if not d:  # then the sign at each phase does not change with the delay
        assert float(found) >= 1.009 * tau / (rate * float(wide))
    for t in (float(found), 1.7 * float(found), 9.1 * float(found)):
        grid = [1 + n / 20000 for n in range(0, 40001, 7)]
        assert max(t * (a * cos(rate * t * x) + b * x * sin(rate * t * x) + c) + d for x in grid) > 0


def test_a_delay_is_long_where_the_last_piece_of_the_band_holds_a_turn() -> None:
    """20 w sin - 51 is positive from 2.55 to 3 rad/s alone, and that at a quarter of a turn: of sixteenths the last three."""
    with flint.ctx.workprec(128):
        found = long([real_part(q * (20 * s * exp(-q * s) - 51))], q, (Integer(1), Integer(3)))
    assert found is not None
    assert tau / 0.45 < float(found) < 1.02 * tau / 0.375


def test_a_delay_alone_that_turns_once_may_be_long_and_no_other() -> None:
    with flint.ctx.workprec(96):
        for formula in (exp(-q * s) + exp(-sqrt(2) * q * s) + 5, 3 + q * exp(-s), exp(-q * s) * s**q + 9):
            assert long([real_part(formula)], q, (Integer(1), Integer(2))) is None
        assert long([real_part(exp(-q * s) - 2)], q, (Integer(1), Integer(2))) is None
        two = [real_part(x + 0 * exp(-q * s)) for x in (exp(-q * s) - 2, exp(-q * s) - Rational(1, 2))]
        assert long(two, q, (Integer(1), Integer(2))) is not None  # one is enough


def test_a_condition_at_a_phase_is_that_of_the_wave_there_by_the_inverse() -> None:
    """2 cos + w sin + 1/q at tangents 0, 1, -1, 3 and -3 of half the angle, times 1 + T^2."""
    own = real_part(q**2 * (2 * exp(-q * s) + s * exp(-q * s)) + q)
    index = next(i for i, x in enumerate(own.axis.angles) if x.rate.has(q))
    with flint.ctx.workprec(96):
        shapes = [*_at_phases(own, q, index)]
        assert len(shapes) == 5
        for shape, T in zip(shapes, (0, 1, -1, 3, -3), strict=True):
            x, y = Fraction(1 - T * T, 1 + T * T), Fraction(2 * T, 1 + T * T)
            for at, u in ((Fraction(3, 2), Fraction(1, 4)), (Fraction(2), Fraction(1, 50))):
                true = (2 * x + at * y + u) * (1 + T * T)
                value = shape.over(exact(u)).value(exact(at))
                assert value.overlaps(exact(true))
                assert value.rad() < 1e-20
