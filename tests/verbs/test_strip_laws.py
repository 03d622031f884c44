"""Conditions in balls over cells of values: values, slopes, places and limits of random functions against mpmath and dense samples."""

from __future__ import annotations

import random
from fractions import Fraction
from functools import cache
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, exp, lambdify, pi

import haptisym as hs
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s
from haptisym.verbs.require.cells import ValueSearch
from haptisym.verbs.require.clusters import Strips, places
from haptisym.verbs.require.corners import ZeroAt
from haptisym.verbs.require.feasible import Kind
from haptisym.verbs.require.limits import Limit, long, short
from haptisym.verbs.require.places import CellVerdict, CriticalPlace, MaximumAt, Strip
from haptisym.verbs.require.strips import Shape

MP = mpmath.mp.clone()
MP.prec = 400
SEEDS = range(20)
REAL = noticed(hs.Threshold())[0]
q = Symbol("q", positive=True)


def real_part(x: Expr) -> RealFunction:
    return on_axis(Ring.of([x, q * s]).convert(x)).real


def drawn(draw: random.Random, kind: str) -> Shape:
    """The real part of a sum with the parameter q before powers of s, in a delay beside another, before or beside a power s^alpha."""
    c = [Rational(draw.choice([-5, -3, -2, 1, 2, 4]), draw.choice([1, 3])) for _ in range(8)]
    found = c[0] * q + c[1] * s**2 * q**2 + c[2] * s + c[3] * s**4 * draw.randint(0, 1)
    found += {
        "rational": c[4] + pi * q,
        "delay": (c[4] + c[5] * q * s) * exp(-s / 3) + c[6] * exp(-2 * s / 3),
        "free delay": c[4] * exp(-q * s) + c[5] * s * exp(-2 * q * s),
        "power": c[4] * q * s ** Rational(1, 3) + c[5] * s ** Rational(4, 3),
        "all": c[4] * s * exp(-s / 5) * s ** Rational(1, 2) + c[5] * q**3 * exp(-q * s),
        "from zero": c[4] - c[0] * q - c[4],
        "power from zero": c[4] * q * s ** Rational(1, 3) + c[5] * s ** Rational(4, 3) - c[0] * q,
    }[kind]
    return Shape.of(real_part(found), q)


KINDS = ("rational", "delay", "free delay", "power", "all", "from zero", "power from zero")


def number(x: Any) -> Any:
    return (
        MP.mpf(x.p) / x.q
        if isinstance(x, Rational)
        else MP.mpf(str(x.evalf(130)))
        if isinstance(x, Expr)
        else MP.mpf(x)
    )


@cache
def terms(shape: Shape) -> tuple[list[Any], list[Any], list[Any]]:
    """Rates of half angles and orders, without and with the parameter; and coefficients with all exponents."""
    axis = shape.axis
    halves = [(a.constant, number(pi * 0 + a.rate.subs(q, 0)) / 2, number(a.rate.diff(q)) / 2) for a in axis.angles]
    rows = [
        (MP.mpf(int(c.p)) / int(c.q) * MP.pi ** int(e[1]), [int(n) for n in e])
        for e, c in shape.polynomial.to_dict().items()
    ]
    return halves, [(number(pi * 0 + x.subs(q, 0)), number(pi * 0 + x.diff(q))) for x in axis.orders], rows


def exact(shape: Shape, x: Any, t: Any, *, negative: bool = False) -> Any:
    """The value, term by term; ``negative``: at -x."""
    axis, total = shape.axis, MP.mpf(0)
    at = -x if negative else x
    index, first = axis.meanings.index(q), axis.size + len(axis.angles)
    halves, orders, rows = terms(shape)
    waves = [MP.cos_sin(own + slope * t if constant else (own + slope * t) * at) for constant, own, slope in halves]
    powers = [at ** (own + slope * t) for own, slope in orders]
    for c, e in rows:
        term = c * at ** e[0] * t ** e[index]
        for (cosine, sine), k, n in zip(waves, e[axis.size : first], shape.degrees, strict=True):
            term *= sine**k * cosine ** (n - k)
        for power, n in zip(powers, e[first:], strict=True):
            term *= power**n
        total += term
    return total


def begins_with(shape: Shape) -> Any:
    return number(Rational(*shape.order_at_zero.as_integer_ratio()))


def ball(x: Fraction) -> Any:
    return arb(x.numerator) / x.denominator


def near(found: Any, true: Any) -> bool:
    """Whether a ball holds a number, up to what the number is rounded by."""
    return bool((found - arb(MP.nstr(true, 60))).abs_lower() <= 1e-50 * (1 + abs(float(true))))


def holds(found: Any, true: Any, width: float = 1e-12) -> bool:
    """Whether a ball holds a number, and is not wide."""
    return near(found, true) and float(found.rad()) <= width * (1 + abs(float(true)))


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_has_the_values_and_slopes_of_its_function(kind: str, seed: int) -> None:
    draw = random.Random(f"{kind} {seed}")
    shape = drawn(draw, kind)
    x, t = Fraction(draw.randint(1, 40), 8), Fraction(draw.randint(1, 40), 16)
    X, T = number(Rational(x.numerator, x.denominator)), number(Rational(t.numerator, t.denominator))
    with flint.ctx.workprec(200):
        compiled = shape.over(ball(t))
        assert holds(compiled.value(ball(x)), exact(shape, X, T))
        change = shape.change
        assert change is not None
        assert holds(change.over(ball(t)).value(ball(x)), MP.diff(lambda v: exact(shape, X, v), T))
        most = int(shape.polynomial.degrees()[shape.axis.meanings.index(q)])
        beyond = shape.beyond(1 / ball(t)).value(ball(x))
        width = 1e-12 if not any(a.rate.has(q) for a in shape.axis.angles) else 1e9
        assert holds(beyond, exact(shape, X, T) / T ** (most + most % 2), width)
        k = begins_with(shape)
        tiny = MP.mpf(10) ** -30
        assert MP.log(abs(exact(shape, tiny, T) / exact(shape, tiny / 2, T))) / MP.log(2) > k - 1e-6
        if not shape.axis.orders:
            k = int(k)
            ratio = exact(shape, X, T, negative=True) / exact(shape, X, T) * (-1) ** k
            assert not shape.is_even or abs(ratio - 1) < 1e-30
            assert shape.is_even or abs(ratio - 1) > 1e-30
        for end in (Fraction(1, 4), Fraction(2)):
            whole = shape.from_zero(compiled, ball(end))
            for n in range(1, 9):
                at = number(Rational(end.numerator * n, end.denominator * 8))
                true = exact(shape, at, T) / at**k
                assert near(whole, true)
        at_0, tiny = shape.seen_at(compiled, arb(0)), MP.mpf(10) ** -40
        assert abs(float(at_0.mid()) - float(exact(shape, tiny, T) / tiny**k)) < 1e-9 * (1 + abs(float(at_0.mid())))
        assert not shape.is_fixed


@pytest.mark.few("rational-3", "delay-5", "from zero-1", "power-2")
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_strip_holds_its_function_for_all_values_of_its_cell_and_is_as_wide_as_needed(kind: str, seed: int) -> None:
    draw = random.Random(f"strip {kind} {seed}")
    shape = drawn(draw, kind)
    k = begins_with(shape)
    t, size = Fraction(draw.randint(2, 40), 16), Fraction(1, 2 ** draw.randint(2, 9))
    x, reach = Fraction(draw.choice([0, *range(4, 40)]), 8), Fraction(1, 2 ** draw.randint(2, 7))
    with flint.ctx.workprec(150):
        strip = Strip.of(shape, ball(t), ball(t + size))
        box = ball(x).union(ball(x + reach))
        over, point = strip.over(box), strip.value(ball(x + reach))
        sampled: list[list[Any]] = [[], [], []]
        for i in range(3):
            T = number(Rational(t.numerator, t.denominator)) + number(
                Rational(size.numerator * i, size.denominator * 2)
            )
            for n in (1, 2, 4):
                X = number(Rational(x.numerator, x.denominator)) + number(
                    Rational(reach.numerator * n, reach.denominator * 4)
                )
                own = lambda v, T=T: exact(shape, v, T) / (v**k if x == 0 else 1)  # noqa: E731
                row = [own(X), MP.diff(own, X), MP.diff(own, X, 2) / 2]
                for found, true, kept in zip(over, row, sampled, strict=True):
                    if x == 0 and kept is sampled[1] and k and shape.is_even:
                        assert not found.is_finite() or found.contains(0) or (found > 0) == (true > 0)
                        continue  # the sign alone is told
                    kept.append(true)
                    assert not found.is_finite() or near(found, true)
            end = number(Rational((x + reach).numerator, (x + reach).denominator))
            assert near(point, exact(shape, end, T))
        if x and size <= Fraction(1, 64) and reach <= Fraction(1, 32):
            for found, kept in zip(over, sampled, strict=True):
                spread, largest = float(max(kept) - min(kept)), float(max(map(abs, kept)))
                assert float(found.rad()) <= 2 * spread + 0.1 * largest + 0.5
        middle = strip.broken_in_the_middle(ball(x + reach))
        true = exact(shape, end, number(Rational((2 * t + size).numerator, 2 * (2 * t + size).denominator)))
        assert abs(true) < 1e-9 or middle == (true > 0)


@pytest.mark.few("1", "2")
@pytest.mark.parametrize("seed", SEEDS)
def test_next_to_0_the_power_decides_with_which_a_function_begins_whatever_its_order_in_a_cell(seed: int) -> None:
    draw = random.Random(seed)
    c = [Rational(draw.choice([-5, -3, -2, 1, 2, 4]), draw.choice([1, 3])) for _ in range(4)]
    held = s ** draw.randint(0, 1)
    shape = Shape.of(real_part(held * (c[0] * s**q + c[1] * s * s**q + c[2] * s * exp(-s / 3) + c[3] * s**3)), q)
    low = draw.choice([1, 2, 5, 9, 14, 16, 20, 30])  # thirty-seconds
    with flint.ctx.workprec(150):
        strip = Strip.of(shape, arb(low) / 32, arb(low + 1) / 32)
        tiny = arb(10) ** -300
        short = strip.over(arb(0).union(tiny))[0]
        for end in (tiny, arb(1) / 8, arb(3)):
            found = strip.over(arb(0).union(end))[0]
            for n in range(1, 9):
                x = MP.mpf(str(float(end))) * n / 8
                for t in (low, low + MP.mpf(1) / 2, low + 1):
                    true = exact(shape, x, t / MP.mpf(32))
                    assert not found > 0 or true > 0
                    assert not found < 0 or true < 0
    assert short > 0 or short < 0


@pytest.mark.parametrize("seed", range(5))
def test_next_to_0_a_function_over_the_power_that_it_begins_with_is_enclosed_with_the_sign_of_its_slope(
    seed: int,
) -> None:
    """Of waves and powers that begin at 0 with omega to a power, even and odd beyond it, for all values of a cell."""
    draw, told = random.Random(seed), [0, 0]
    for _ in range(6):
        c = [Rational(draw.choice([-5, -3, -2, 1, 2, 4]), draw.choice([1, 3])) for _ in range(4)]
        held = s ** draw.choice([1, 2, 3])
        bracket = c[0] * q + c[1] * s**2 + c[2] * (exp(-s / 3) - 1) + draw.choice([0, 1]) * c[3] * s**4
        shape = Shape.of(real_part(held * bracket), q)
        k, t, end = int(begins_with(shape)), Fraction(draw.randint(4, 40), 16), Fraction(1, draw.choice([1, 4, 16]))
        with flint.ctx.workprec(150):
            strip = Strip.of(shape, ball(t), ball(t + Fraction(1, 128)))
            value, slope, bend = strip.over(arb(0).union(ball(end)))
            assert value.is_finite()
            assert not bend.is_finite()
            rows = list[Any]()
            for T in (t, t + Fraction(1, 256), t + Fraction(1, 128)):
                T = number(Rational(*T.as_integer_ratio()))
                for n in (1, 3, 8):
                    X = number(Rational(*(end * n / 8).as_integer_ratio()))
                    own = lambda v, T=T, k=k, shape=shape: exact(shape, v, T) / v**k  # noqa: E731
                    assert near(value, own(X))
                    rows.append(MP.diff(own, X))
            middle = own(MP.mpf(2) ** -40)
            if slope.is_finite() and shape.is_even:
                told[0] += not slope.contains(0)
                assert not slope > 0 or min(rows) > 0
                assert not slope < 0 or max(rows) < 0
            elif slope.is_finite():
                told[1] += 1
                assert all(near(slope, x) for x in rows)
            else:
                assert value < 0 or middle < 0
    assert told[0] or told[1]


@pytest.mark.parametrize(
    ("low", "signs"), [(Fraction(5, 8), None), (Fraction(7, 8), (-1, -1)), (Fraction(3, 8), (1, 1))]
)
def test_of_an_order_that_changes_signs_are_told_where_they_are_the_same_for_all_of_a_cell(
    low: Fraction, signs: tuple[int, int] | None
) -> None:
    """cos(q pi/2) - 1/2 at 1 rad/s, which is 0 for q = 2/3."""
    with flint.ctx.workprec(128):
        strip = Strip.of(Shape.of(real_part(s**q - Rational(1, 2)), q), ball(low), ball(low + Fraction(1, 8)))
        assert strip.change is None
        assert strip.signs(CriticalPlace(Kind.EDGE, arb(1), arb(1), Integer(1))) == signs


def shape_of(x: Expr) -> Shape:
    axis = Ring.of([q * s]).axis
    return Shape.of(RealFunction(axis.convert(x)), q)


def strips(low: Fraction, high: Fraction, *functions: Expr) -> Strips:
    return Strips.of([shape_of(x) for x in functions], ball(low), ball(high))


BAND = (Integer(1), Integer(5))
NARROW = Fraction(1, 1024)


@pytest.mark.parametrize(
    ("function", "kind", "value", "at"),
    [
        (q - (w - 3) ** 2 - 2, Kind.TOUCH, 2, 3.0),
        (2 - (w - 3) ** 2 - q, Kind.TOUCH, 2, 3.0),
        (q**2 - (w**2 - 4) ** 2 - 9, Kind.TOUCH, 3, 2.0),
        (q - 10 + w, Kind.EDGE, 5, 5.0),
        (w - q, Kind.EDGE, 5, 5.0),
        (q - 3 - w, Kind.START, 4, 1.0),
        (3 - w - q, Kind.START, 2, 1.0),
        (w**2 * q - 50, Kind.EDGE, 2, 5.0),
    ],
)
def test_the_place_at_which_a_condition_binds_is_found_and_the_value_known(
    function: Expr, kind: Kind, value: int, at: float
) -> None:
    with flint.ctx.workprec(128):
        rising = function.subs({q: value + 1, w: Rational(at)}) > 0
        ends = (value - 3 * NARROW, value + NARROW) if rising else (value - NARROW, value + 3 * NARROW)
        condition = strips(*ends, function)  # it is kept in the middle
        found = places(condition, BAND)
        assert isinstance(found, list), found
        [place] = found
        assert place.kind is kind
        assert place.low <= at <= place.high
        assert place.high - place.low < 0.5
        assert place.omega == {Kind.TOUCH: None, Kind.EDGE: BAND[1], Kind.START: BAND[0]}[kind]
        assert condition.signs(place) == ((-1, 1) if rising else (1, -1))
        crossing = condition.crossing(place)
        for bits in (60, 200):
            with flint.ctx.workprec(bits + 40):
                assert crossing.ball(bits).contains(value)
                assert crossing.ball(bits).rad() < arb(2) ** (10 - bits)
        beside = strips(*ends, w + 9, function)
        [other] = places(beside, BAND)  # type: ignore[misc]
        assert (other.kind, other.piece, other.other, other.omega) == (kind, 1, None, place.omega)
        assert beside.signs(other) == condition.signs(place)
        assert beside.crossing(other).ball(60).contains(value)
        assert places(strips(*ends, w - 9, function), BAND) == []
        if kind is Kind.TOUCH:
            top = MaximumAt(crossing).ball(80)  # type: ignore[arg-type]
            assert abs(top - at) < 1e-15
        for low, high, verdict in (
            (value + NARROW, value + 2 * NARROW, rising),
            (value - 2 * NARROW, value - NARROW, not rising),
        ):
            condition = strips(low, high, function)
            found = places(condition, BAND)
            if verdict and isinstance(found, list):
                assert [condition.signs(x) for x in found] == [(1, 1)]
            elif isinstance(found, list):
                assert {condition.signs(x) for x in found} <= {(-1, -1)}
            else:
                assert found is CellVerdict.BROKEN
                assert verdict
            assert condition.signs(place) in (((1, 1) if verdict else (-1, -1)), None)


@pytest.mark.parametrize(
    ("rising", "falling", "value", "at"),
    [(w - 3, q - w, 3, 3), (w - q, 4 - w, 4, 4), (w**2 - 4 * q, 20 - w**2 - q, 4, 4), (w - 2 * q, q + 1 - w, 1, 2)],
)
def test_a_corner_is_where_one_rises_over_the_zero_of_the_other(
    rising: Expr, falling: Expr, value: int, at: int
) -> None:
    with flint.ctx.workprec(128):
        for pair in ((rising, falling), (falling, rising)):
            condition = strips(value - NARROW, value + NARROW, *pair)
            found = places(condition, BAND)
            assert isinstance(found, list), found
            [place] = found
            assert (place.kind, pair[place.piece], pair[place.other or 0]) == (Kind.TOUCH, rising, falling)
            assert place.low <= at <= place.high
            grid = [
                max(
                    min(float(f.subs({q: value + way * NARROW, w: at + Rational(n, 4096)})) for f in pair)
                    for n in range(-8, 9)
                )
                for way in (-1, 1)
            ]
            assert condition.signs(place) == tuple(1 if x > 0 else -1 for x in grid)
            crossing = condition.crossing(place)
            assert crossing.ball(100).contains(value)
            assert crossing.ball(100).rad() < 1e-25
            assert abs(ZeroAt(crossing).ball(80) - at) < 1e-15  # type: ignore[arg-type]


def largest(functions: list[Expr], t: Fraction) -> float:
    """Of the least function over the band."""
    grid = np.linspace(1.0, 5.0, 801)
    rows = [np.broadcast_to(lambdify((w, q), f, "numpy")(grid, float(t)), grid.shape) for f in functions]
    return float(np.min(rows, axis=0).max())


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(40))
def test_what_is_said_of_a_cell_holds_for_its_values_and_is_said_where_it_is_clear(seed: int) -> None:
    draw = random.Random(seed)

    def some() -> Expr:
        a, b, c = (Rational(draw.randint(-20, 20), 8) for _ in range(3))
        top = Rational(draw.randint(8, 40), 8)
        return draw.choice([
            q * a - (w - top) ** 2 + c, c - (w**2 - top**2) ** 2 / 9 + a * q, a * w + b * q + c, a * (w - top) * (w - 3) - q + b,
        ])  # fmt: skip

    functions = [some() for _ in range(draw.choice([1, 1, 2]))]
    with flint.ctx.workprec(96):
        for _ in range(4):
            low = Fraction(draw.randint(1, 60), 16)
            high = low + Fraction(1, draw.choice([4, 64, 1024]))
            found = places(strips(low, high, *functions), BAND)
            tops = [largest(functions, low + (high - low) * n / 6) for n in range(7)]
            if found is CellVerdict.BROKEN:
                assert min(tops) > -1e-4
            elif isinstance(found, list):
                for place in found:
                    assert isinstance(place, CriticalPlace)
                    assert 1 <= float(place.low) <= float(place.high) <= 5
                if not found:
                    assert max(tops) < 1e-9
            if high - low < 0.001 and max(tops) < -0.05:
                assert found == []
            if high - low < 0.001 and min(tops) > 0.05:
                assert found is CellVerdict.BROKEN


# Limits


def limit(functions: list[Expr], band: tuple[Expr, Expr], *, inverse: bool, sign: int = 1) -> Limit:
    own = [on_axis(Ring.of([x, q * s]).convert(x)).real for x in functions]
    found = Limit.of(own, q, band, inverse=inverse, sign=sign)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("function", "inverse", "verdict"),
    [
        (q - 1, False, CellVerdict.KEPT),
        (q - 1, True, CellVerdict.BROKEN),
        (1 - q, False, CellVerdict.BROKEN),
        (1 - q, True, CellVerdict.KEPT),
        (-q, False, CellVerdict.KEPT),  # also at the limit itself it binds, but it is kept before
        (q**2 - q, False, CellVerdict.KEPT),
        (q**2 - q, True, CellVerdict.BROKEN),
        (q**2 * s**2 + q, False, CellVerdict.BROKEN),  # q - q^2 w^2
        (q**2 * s**2 + q * s**4 / 100, True, CellVerdict.KEPT),
        (s**2 + q * s**4, False, CellVerdict.KEPT),  # -w^2 + q w^4
        (s**2 + q, False, CellVerdict.BROKEN),  # q - w^2 at w = 0
        (s**2 - q, False, CellVerdict.KEPT),
        (s**2 + s**4 * q**2, True, CellVerdict.BROKEN),
        (-q * exp(-s / 3) - 3 * q, True, CellVerdict.KEPT),
        (q * s * exp(-s / 3) * -1 - 1, False, CellVerdict.KEPT),
        (q * exp(-s / 3) - 1, True, CellVerdict.BROKEN),
        (-(q**2) * s ** Rational(1, 2) - 1, False, CellVerdict.KEPT),
        (q * s ** Rational(1, 2) - 1, True, CellVerdict.BROKEN),
    ],
)
@pytest.mark.parametrize("low", [Integer(0), Integer(1)])
def test_what_becomes_of_a_condition_at_a_limit(
    function: Expr, low: Expr, *, inverse: bool, verdict: CellVerdict
) -> None:
    if low == 1 and function == s**2 + q:
        verdict = CellVerdict.KEPT
    with flint.ctx.workprec(128):
        own = limit([function], (low, Integer(2)), inverse=inverse)
        reach, found = Fraction(1, 64), None
        for _ in range(8):
            found, value = own.verdict(reach, 8)
            if found is not CellVerdict.OPEN:
                break
            reach /= 16
        assert found is verdict
        assert 0 < value <= reach
        mirrored = limit([function.subs(q, -q)], (low, Integer(2)), inverse=inverse, sign=-1)
        assert mirrored.verdict(reach, 8) == (found, value)
        for n in (1, 3, 1000):
            u = value / n
            t = 1 / u if inverse else u
            true = Shape.of(real_part(function), q)
            top = max(
                exact(
                    true,
                    number(Rational(low)) + (2 - number(Rational(low))) * MP.mpf(k) / 4000 + MP.mpf(10) ** -20,
                    number(Rational(t.numerator, t.denominator)),
                )
                for k in (*range(1, 20), *range(50, 4001, 200), 4000)
            )
            assert (top > 0) == (verdict is CellVerdict.BROKEN) or (low == 0 and function == s**2 + q)


def test_of_two_functions_one_that_is_kept_is_not_enough_for_a_limit_and_one_that_is_broken_is() -> None:
    with flint.ctx.workprec(128):
        for functions, verdict in (
            ([q - 1, -q - 2], CellVerdict.KEPT),
            ([q - 1, q + 2], CellVerdict.BROKEN),
            ([q + 1, q - 2], CellVerdict.BROKEN),
        ):
            assert limit(functions, BAND, inverse=False).verdict(Fraction(1, 64), 8)[0] is verdict
        rate = on_axis(Ring.of([exp(-q * s), q * s]).convert(exp(-q * s))).real
        assert Limit.of([rate], q, BAND, inverse=False, sign=1) is None


@pytest.mark.parametrize(
    ("function", "verdict"),
    [
        (exp(-q * s) - 1, CellVerdict.KEPT),  # cos - 1 = -2 sin^2, a half angle twice
        (1 - exp(-q * s), CellVerdict.BROKEN),
        (exp(-q * s) - 2, CellVerdict.KEPT),
        (2 * exp(-q * s) - 1, CellVerdict.BROKEN),
        (s * exp(-q * s) - q * 9, CellVerdict.KEPT),  # w sin q w - 9 q
        (s * exp(-q * s) - q, CellVerdict.BROKEN),
    ],
)
def test_what_becomes_of_a_condition_as_a_delay_goes_to_0(function: Expr, verdict: CellVerdict) -> None:
    with flint.ctx.workprec(128):
        found = short([real_part(function)], q, (Integer(1), Integer(2)), Fraction(1, 100))
    assert found is verdict


@pytest.mark.parametrize(
    ("function", "least"),
    [
        (exp(-q * s) - Rational(1, 2), 1.0),
        (exp(-q * s) - 2, None),
        (exp(-2 * q * s) + Rational(1, 2), 0.5),
        (-exp(-q * s) - Rational(9, 10), None),
        (-exp(-q * s) - Rational(1, 2), 1.0),
        (q * exp(-q * s) - q / 2 - 3, 6.0),  # also beside the delay: by its inverse
        (q**2 * s * exp(-q * s) - 20, 4.0),  # q^2 w sin q w - 20
        (q * exp(-q * s) - 2 * q + 3, None),
        (s * exp(-q * s) / q - 1, None),  # it falls with its inverse
    ],
)
def test_beyond_a_long_delay_a_condition_is_broken_at_some_phase(function: Expr, least: float | None) -> None:
    with flint.ctx.workprec(128):
        found = long([real_part(function)], q, (Integer(1), Integer(2)))
        assert (found is None) == (least is None)
        if found is not None:
            assert found < 100
            assert least is not None
            assert float(found) > least
            own = Shape.of(real_part(function), q)
            for n in (1, 3):
                value = n * number(Rational(found.numerator, found.denominator))
                assert max(exact(own, 1 + MP.mpf(k) / 500, value) for k in range(501)) > 0


def test_of_two_functions_of_which_both_must_be_positive_no_phase_is_told_where_a_number_stands_beside_its_delay() -> (
    None
):
    one, other = (real_part(q * exp(-q * s) - c * q) for c in (Rational(1, 2), Rational(1, 3)))
    search = ValueSearch({REAL: Lattice(((one, other),))}, q, (Integer(1), Integer(2)), Fraction(1))
    assert search._tail_by_phase(1) is None
    alone = ValueSearch({REAL: one}, q, (Integer(1), Integer(2)), Fraction(1))._tail_by_phase(1)
    assert alone is not None
    assert (alone.verdict, alone.high) == (CellVerdict.BROKEN, None)
    assert ValueSearch({REAL: one}, q, (Integer(1), Integer(2)), Fraction(1))._tail_by_phase(-1) is None


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("functions", "verdict"),
    [
        ([q - 1], CellVerdict.BROKEN), ([1 - q], CellVerdict.KEPT), ([1 - q, 2 - q], CellVerdict.KEPT), ([1 - q, q - 2], CellVerdict.BROKEN),
        ([q * exp(-s / 3) - q / 2], CellVerdict.BROKEN), ([q * exp(-s / 3) - 2 * q], CellVerdict.KEPT),
        ([q * s**2 + 9 * q], CellVerdict.BROKEN), ([1 - q, q * s**2 + 3 * q], CellVerdict.BROKEN), ([q * s**2 + q, 1 - q], CellVerdict.OPEN),
    ],
)  # fmt: skip
def test_beyond_a_number_a_condition_is_told_for_all_values_at_once(
    functions: list[Expr], verdict: CellVerdict, sign: int
) -> None:
    """Of both signs; what only just does at an end of the band, as 1 - w^2 at 1 rad/s, stays open."""
    names = noticed(hs.Threshold())
    own = {x: real_part(f.subs(q, q**2)) for x, f in zip(names, functions, strict=False)}
    search = ValueSearch(own, q, (Integer(1), Integer(2)), Fraction(1))
    assert search._beyond(sign, sign * Fraction(100)) is verdict


def test_beyond_a_number_values_of_one_sign_alone_are_looked_at() -> None:
    """q^2 + 3 q over q^2 is 1 + 3/q: above 0 beyond 2, and not beyond -2; mirrored the other way round."""
    for sign in (1, -1):
        search = ValueSearch({REAL: real_part(q**2 + 3 * sign * q)}, q, (Integer(1), Integer(2)), Fraction(1))
        assert search._beyond(sign, sign * Fraction(2)) is CellVerdict.BROKEN
        assert search._beyond(-sign, -sign * Fraction(2)) is CellVerdict.OPEN
