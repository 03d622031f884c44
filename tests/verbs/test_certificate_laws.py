"""What certificates are made of, module by module: factors, breakpoints, cells and products against the checker's arithmetic, mpmath and known roots."""

from __future__ import annotations

import random
import tomllib
from contextlib import nullcontext
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest
from flint import arb, fmpq
from sympy import Expr, Integer, Rational, exp, lambdify, pi

import haptisym as hs
import haptisym_check.polynomials as checked
import haptisym_check.waves as checked_waves
from haptisym.judge.criteria import noticed
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, Sliver
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.symbols import omega, s
from haptisym.model.quantities import number
from haptisym.model.scenetables import read_scenes
from haptisym.verbs.evaluate import certificate as written
from haptisym.verbs.evaluate import checkable, waves
from haptisym.verbs.evaluate.breakpoints import _between, breakpoints
from haptisym.verbs.evaluate.powers import RectangularRing
from haptisym.verbs.evaluate.products import Factor, Linked, products, rational_products, rows_of, told_rows
from haptisym.verbs.evaluate.waves import ORDER, WaveFactor, cosine_factor
from haptisym.verbs.evaluate.zeros import zeros
from haptisym.verbs.require import certificate as requirements
from haptisym.verbs.require.certificate import _bounds as bounds_of
from haptisym.verbs.require.certificate import _keys, _values
from haptisym.verbs.require.feasible import Binding, End, Kind, Span
from haptisym.verbs.require.freeparameter import Domain
from haptisym_check import RefusedError
from haptisym_check.chart import Chart
from haptisym_check.reading import polynomial
from haptisym_check.slices import Slices
from haptisym_check.values import ONE, Value, combined
from haptisym_check.waves import factor_of
from haptisym_check.zeros import zeros as counted

MP = mpmath.mp.clone()
MP.prec = 600
SEEDS = range(20)


def exact(x: Fraction | int) -> Any:
    return MP.mpf(Fraction(x).numerator) / Fraction(x).denominator


def sign(x: Any) -> int:
    return int(x > 0) - int(x < 0)


def expanded(roots: list[Fraction], first: tuple[int, ...] = (1,)) -> list[int]:
    p = list(first)
    for x in roots:
        p = [
            a + b
            for a, b in zip([*(-x.numerator * c for c in p), 0], [0, *(x.denominator * c for c in p)], strict=True)
        ]
    return p


def rows(draw: random.Random, length: int, width: int) -> tuple[tuple[int, ...], ...]:
    own = [tuple(draw.randint(-9, 9) for _ in range(draw.randint(1, width))) for _ in range(length)]
    return (*own[:-1], (*own[-1], draw.choice([-3, 2])))


def value(p: tuple[tuple[int, ...], ...], x: Any) -> Any:
    return MP.fsum(MP.fsum(c * MP.pi**k for k, c in enumerate(row)) * x**n for n, row in enumerate(p))


# Factors without delays


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_bounds_of_a_factor_hold_it_and_signs_are_those_of_a_checker(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        own = Factor(rows(draw, draw.randint(1, 5), draw.randint(1, 3)), draw.choice([1, 2]))
        assert len(own.bounds) == 1 + any(len(row) > 1 for row in own.rows)
        x = Fraction(draw.randint(0, 40), draw.randint(1, 9))
        low, high = (
            exact(Fraction(int(p.p), int(p.q)))
            for p in (b(fmpq(x.numerator, x.denominator)) for b in (own.bounds[0], own.bounds[-1]))
        )
        assert low <= value(own.rows, exact(x)) <= high
        assert high - low < MP.mpf(10) ** -80
        other = checked.Factor([list(row) for row in own.rows], own.step)
        assert own.cost == other.cost
        assert own.told() == {"step": own.step, "polynomial": [[str(c) for c in row] for row in own.rows]}
        assert own.sign_at(x) == sign(value(own.rows, exact(x) ** own.step))
        a, b = sorted(Fraction(draw.randint(0, 30), draw.randint(1, 5)) for _ in range(2))
        if a < b:
            _, found = other.signs(a, b)
            moved = own.moved(a, b)
            assert moved is not None
            assert list(moved) == [0] * (len(moved) - len(found)) + found
            from_a = checked.signs(other.slices, (a**own.step).as_integer_ratio(), (1, 0))
            assert list(own.moved(a, None) or ()) == from_a


def test_what_depends_on_pi_beyond_its_digits_stays_open() -> None:
    far = 10**120
    near = Factor(((-int(MP.pi * far), far),), 1)
    assert near.moved(Fraction(1), Fraction(2)) is None
    assert near.sign_at(Fraction(1)) == 0
    far = 10**80
    assert Factor(((-int(MP.pi * far), far),), 1).sign_at(Fraction(1)) == 1


# Factors with sines and powers


def drawn(draw: random.Random, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...]) -> tuple[WaveFactor, Any]:
    most = tuple(draw.randint(0, 2) for _ in delays)
    terms = {}
    for _ in range(draw.randint(1, 4)):
        turns = tuple(draw.randint(0, k) for k in most) + tuple(draw.randint(0, 2) for _ in range(2 * len(orders)))
        terms[turns] = rows(draw, draw.randint(1, 3), 2)

    def at(w: Any) -> Any:
        total = MP.mpf(0)
        for turns, p in terms.items():
            term = value(p, w)
            for tau, k, n in zip(delays, turns, most, strict=False):
                term *= MP.sin(w * exact(tau) / 2) ** k * MP.cos(w * exact(tau) / 2) ** (n - k)
            for i, alpha in enumerate(orders):
                k, m = turns[len(delays) + 2 * i :][:2]
                turned = MP.expjpi(exact(alpha) / 2) * w ** exact(alpha)
                term *= turned.real**k * turned.imag**m
            total += term
        return total

    return WaveFactor(tuple(sorted(terms.items())), most, delays, orders), at


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_taylors_sums_hold_a_wave_factor_and_its_signs_are_those_of_a_checker(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(3):
        delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(0, 2)))
        orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(0 if delays else 1, 1)))
        own, at = drawn(draw, delays, orders)
        other = checked_waves.WaveFactor(own.told(), delays, orders)
        assert own.cost == other.cost
        a = Fraction(draw.randint(8, 30), 4)
        b = a + Fraction(1, draw.choice([4, 8, 30]))
        with waves.flint.ctx.workprec(280):
            model, rest = own._model(own._balls, a, b)
        assert len(model) == ORDER
        for v in (Fraction(-1), Fraction(1, 3), Fraction(1)):
            with waves.flint.ctx.workprec(400):
                total = sum((c * arb(fmpq(v.numerator, v.denominator)) ** n for n, c in enumerate(model)), rest)
                off = total - arb(str(at(exact((a + b + v * (b - a)) / 2))))
                assert off.contains(0)
                assert off.rad() < 1e-6
        with_x = [tuple(map(sign, (at(exact(x)),))) for x in (a, b)]
        assert (own.sign_at(a), own.sign_at(b)) == (with_x[0][0], with_x[1][0])
        try:
            found: Any = other.signs(a, b)[1]
        except RefusedError:
            found = None
        moved = own.moved(a, b)
        assert (found is None and moved is None) or list(moved or ()) == found
        start, high = own.moved(Fraction(0), Fraction(1, 10**6)), MP.mpf(10) ** -30
        assert start == (sign(at(high)),)
        for wide in (Fraction(1, 3), Fraction(3)):
            try:
                also: Any = other.signs(Fraction(0), wide)[1]
            except RefusedError:
                also = None
            moved = own.moved(Fraction(0), wide)
            assert (also is None and moved is None) or list(moved or ()) == also


def nowhere_zero(draw: random.Random) -> tuple[Any, Any, WaveFactor, Any]:
    """a cos^2 x + b sin x cos x + c sin^2 x with b^2 < 4 a c: what ends a cell is what is left of Taylor's sum alone."""
    delay, (a, c) = Fraction(draw.randint(1, 9), 7), (draw.randint(2, 9), draw.randint(2, 9))
    b = draw.choice([-2, -1, 1, 2])
    terms = (((0,), ((a,),)), ((1,), ((b,),)), ((2,), ((c,),)))

    def at(w: Any) -> Any:
        x = w * exact(delay) / 2
        return a * MP.cos(x) ** 2 + b * MP.sin(x) * MP.cos(x) + c * MP.sin(x) ** 2

    return (delay,), (), WaveFactor(terms, (2,), (delay,), ()), at


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_from_0_on_a_sign_is_told_no_farther_than_a_checker_tells_it(seed: int) -> None:
    """And as it is at no other number up to there: the widest cell leaves no room for a term that was forgotten."""
    draw = random.Random(seed)
    for i in range(8):
        if i % 2:
            delays = tuple(Fraction(n, 7) for n in draw.sample(range(1, 9), draw.randint(0, 2)))
            orders = tuple(Fraction(n, 10) for n in draw.sample(range(1, 10), draw.randint(0 if delays else 1, 1)))
            own, at = drawn(draw, delays, orders)
        else:
            delays, orders, own, at = nowhere_zero(draw)
        other = checked_waves.WaveFactor(own.told(), delays, orders)
        low, high = Fraction(1, 10**6), Fraction(64)
        if own.moved(Fraction(0), high) is not None:
            continue
        while high > low * Fraction(1000001, 1000000):
            middle = Fraction(round((low + high) / 2 * 10**9), 10**9)
            low, high = (low, middle) if own.moved(Fraction(0), middle) is None else (middle, high)
        told = own.moved(Fraction(0), low)
        assert told is not None
        assert list(told) == other.signs(Fraction(0), low)[1]
        assert {sign(at(exact(low) * MP.mpf(n) / 40)) for n in range(1, 41)} == set(told)


@pytest.mark.parametrize("order", [(), (Fraction(1, 2),), (Fraction(3, 10),)])
def test_from_0_on_a_sign_is_told_up_to_a_zero_that_was_placed_whatever_power_brings_it(
    order: tuple[Fraction, ...],
) -> None:
    """a - b omega^n has its zero where it has; below ORDER a cell may end right before it, and none goes beyond."""
    for n in range(1, ORDER + 3):
        a, b = 3 + n % 4, 2 + n % 3
        row = ((a,), *[(0,)] * (n - 1), (-b,))
        own = WaveFactor((((0,) * (1 + 2 * len(order)), row),), (0,), (Fraction(1, 7),), order)
        zero = Fraction(round((a / b) ** (1 / n) * 10**9), 10**9)
        assert own.moved(Fraction(0), zero * Fraction(10001, 10000)) is None
        assert own.moved(Fraction(0), zero / 50) == (1,)
        if n < ORDER:
            assert own.moved(Fraction(0), zero * Fraction(9999, 10000)) == (1,)


def test_what_cancels_at_0_is_seen_to_cancel() -> None:
    """pi (14 sin x - 3 omega cos x) + c omega^n cos x, x = 3 omega/14, begins with x^3 or omega^n."""
    tau = (Fraction(3, 7),)
    for c, n in ((-2, 2), (3, 3), (-1, 5)):
        cosine = [(0,), (0, -3), *[(0,)] * (n - 2), (c,)]
        own = WaveFactor((((0,), tuple(cosine)), ((1,), ((0, 14),))), (1,), tau)
        assert own.moved(Fraction(0), Fraction(1, 10**6)) == (-1 if n == 2 else 1,)
    assert cosine_factor(1, (Fraction(2), Fraction(3)), (Fraction(1, 2),)).told() == {
        "waves": [0, 1],
        "terms": [[[0, 0, 0, 0], [["1"]]]],
    }


# Functions as products


def products_at(told: dict[str, Any], factors: Any, x: Fraction, delays: Any) -> Any:
    total = exact(Fraction(told["number"]))
    for i, n in told["powers"]:
        own = factors[i]
        if isinstance(own, WaveFactor):
            part = MP.mpf(0)
            for turns, p in own.terms:
                term = value(p, exact(x))
                for tau, k, most in zip(delays, turns, own.waves, strict=False):
                    term *= MP.sin(exact(x * tau) / 2) ** k * MP.cos(exact(x * tau) / 2) ** (most - k)
                for j, alpha in enumerate(own.orders):
                    turned = MP.expjpi(exact(alpha) / 2) * exact(x) ** exact(alpha)
                    k, m = turns[len(delays) + 2 * j :][:2]
                    term *= turned.real**k * turned.imag**m
                part += term
        else:
            part = value(own.rows, exact(x) ** own.step)
        total *= part**n
    return total


def dynamics(draw: random.Random, late: list[Expr], raised: list[Expr]) -> Expr:
    """A quotient of sums of powers of s, delays and fractional powers."""

    def some() -> Expr:
        extra = [exp(-x * s) for x in late] + [s**x for x in raised]
        return sum((draw.randint(-5, 5) * s**n for n in range(3)), Rational(draw.randint(1, 5))) + sum(
            (draw.choice([-2, 1, 3]) * x * s ** draw.randint(0, 1) for x in extra if draw.random() < 0.7), Rational(0)
        )

    found: Expr = some() / (some() + s**3)
    return found if draw.random() < 0.7 else found * pi + 1


@pytest.mark.few("2", "4", "8")
@pytest.mark.parametrize("seed", SEEDS)
def test_products_are_the_functions_that_they_were_made_of(seed: int) -> None:
    draw = random.Random(seed)
    late = draw.sample([Rational(1, 3), Rational(2, 3), Rational(3, 5)], seed % 3 if seed < 6 else seed % 2)
    raised = draw.sample([Rational(1, 2), Rational(2, 3)], seed // 3 % 3)
    own = [dynamics(draw, late, raised) for _ in range(2 if seed % 2 else 1)]
    ring = Ring.of(own)
    turned = RectangularRing.like(ring) if ring.orders else ring
    functions = {}
    for i, x in enumerate(own):
        f = ring.convert(x)
        response = on_axis(type(f)(turned, f.numerator, f.denominator))
        functions |= {f"{i}.real": response.real, f"{i}.imag": response.imag}
    linked = products(functions)
    assert len(set(linked.factors)) == len(linked.factors)
    for x in (Fraction(1, 2), Fraction(7, 3), Fraction(5)):
        for i, h in enumerate(own):
            true = lambdify(s, h, [{"exp": MP.exp, "pi": MP.pi, "sqrt": MP.sqrt}, "math"])(MP.mpc(0, exact(x)))
            for part, z in (("real", true.real), ("imag", true.imag)):
                found = products_at(linked.told[f"{i}.{part}"], linked.factors, x, linked.delays)
                assert abs(found - z) < MP.mpf(10) ** -9 * (1 + abs(z)), (h, part)
    assert set(linked.orders) == {Fraction(int(x.p), int(x.q)) for x in ring.orders}


def test_products_know_even_functions_zero_and_what_is_in_common() -> None:
    ring = Ring.of([s])
    axis = ring.axis

    def real(x: Expr) -> RealFunction:
        return RealFunction(axis.convert(x).reduced())

    even = {
        "a": real((omega**2 - 1) * (omega**2 + 3) ** 2 / (omega**2 + 2)),
        "b": real(-Rational(3, 2) * (omega**2 - 1)),
        "c": real(Rational(0)),
    }
    factors, told = rational_products(even)
    assert {f.step for f in factors} == {2}
    assert told["c"] == {"number": "0", "powers": []}
    index = {f.rows: i for i, f in enumerate(factors)}
    minus, three, two = (index[(n,), (1,)] for n in (-1, 3, 2))
    assert told["a"] == {"number": "1", "powers": sorted([[minus, 1], [three, 2], [two, -1]])}
    assert told["b"] == {"number": "-3/2", "powers": [[minus, 1]]}
    odd = {"a": real(omega * (omega**2 - 1)), "b": real(omega**2 + 5)}
    factors, told = rational_products(odd)
    assert sorted((f.step, f.rows) for f in factors) == [(1, ((0,), (1,))), (2, ((-1,), (1,))), (2, ((5,), (1,)))]
    mixed = {"a": real(omega**2 - 2 + omega), "b": real(omega**2 - 2)}
    assert {f.step for f in rational_products(mixed)[0]} == {1}


@pytest.mark.parametrize("seed", range(2))
def test_ends_that_are_rational_stand_in_a_certificate_as_they_are_and_others_in_narrow_bounds(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        x = Fraction(draw.randint(-999, 999), draw.choice([1, 3, 7, 64, 10**9 + 7]))
        assert bounds_of(ExactNumber(Rational(x.numerator, x.denominator))) == (x, x)
        low, high = bounds_of(ExactNumber(Rational(x.numerator, x.denominator) + pi))
        assert exact(low) < exact(x) + MP.pi < exact(high)
        assert 0 < high - low < Fraction(1, 10**50)


def test_rows_are_by_the_variable_and_then_by_pi() -> None:
    axis = Ring.of([s]).axis
    found = axis.convert(3 * omega**2 * pi**2 - 5 * omega**2 + 7 * pi - 2 * omega**3).numerator
    assert rows_of(found) == ((0, 7), (0,), (-5, 0, 3), (-2,))
    assert told_rows(((1, -2), (0,))) == [["1", "-2"], ["0"]]


# Breakpoints


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_checker_accepts_breakpoints_between_all_zeros(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(6):
        low, high = Fraction(draw.choice([0, 1])), Fraction(draw.choice([6, 8]))
        roots = sorted(
            {Fraction(draw.randint(int(low * 60) + 1, int(high * 60) - 1), 60) for _ in range(draw.randint(0, 5))}
            | {x for x in (low, high) if draw.random() < 0.3}
        )
        factors = [
            Factor(tuple((c,) for c in expanded([x], draw.choice([(1,), (9, -5, 1), (100, 1)]))), 1) for x in roots
        ]
        factors.append(Factor(tuple((c,) for c in expanded([], (draw.choice([26, 901]), -10, 1))), 1))
        inner = [x for x in roots if low < x < high]
        slivers = [Sliver(x - Fraction(1, 10**6), x + Fraction(1, 10**6)) for x in inner]
        ends = [ExactNumber(Rational(x.numerator, x.denominator)) for x in (low, high)]
        points = breakpoints([ends[0], *slivers, ends[1]], factors)
        told = [[low] * 2, *([x.low, x.high] if hasattr(x, "low") else list(x.bounds(60)) for x in slivers), [high] * 2]
        number = lambda x: SimpleNamespace(value=x, pi=0)  # noqa: E731
        scene: Any = SimpleNamespace(band=[number(low), number(high)])
        chart = Chart(scene, points, [checked.Factor([list(row) for row in f.rows], f.step) for f in factors], told)
        assert len(chart.orders) == len(inner) + 2
        assert len(points) <= 4 * len(inner) + 12
        assert points[0] == low
        assert points[-1] == high


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_is_cut_where_no_factor_vanishes_though_each_vanishes_at_some_place_that_is_tried(seed: int) -> None:
    draw = random.Random(seed)
    low = Fraction(draw.randint(0, 9), draw.randint(1, 9))
    high = low + Fraction(draw.randint(1, 9), draw.randint(1, 9))
    factors, tried = [Factor(((1,), (0,), (1,)), 1)], list[Fraction]()
    for _ in range(4):
        point = _between(factors, low, high)
        assert low < point < high
        assert point not in tried
        tried.append(point)
        factors.append(Factor(((-point.numerator,), (point.denominator,)), 1))


def test_breakpoints_of_a_band_in_hertz_begin_a_little_below_and_end_a_little_above_it() -> None:
    ends = [ExactNumber(2 * pi), ExactNumber(6 * pi)]
    for zeros_at in ([], [Fraction(10)]):
        slivers = [Sliver(x, x) for x in zeros_at]
        factors = [Factor(tuple((c,) for c in expanded(zeros_at)), 1)]
        points = breakpoints([ends[0], *slivers, ends[1]], factors)
        assert 0 <= exact(points[0]) <= 2 * MP.pi < exact(points[1])
        assert exact(points[-2]) < 6 * MP.pi <= exact(points[-1])
        assert 2 * MP.pi - exact(points[0]) < 1e-9
        assert exact(points[-1]) - 6 * MP.pi < 1e-9


@pytest.mark.slow
def test_where_no_cells_suffice_it_is_undecided() -> None:
    twice = Factor(((1,), (-2,), (1,)), 1)
    with pytest.raises(UndecidedError):
        breakpoints([ExactNumber(Rational(0)), ExactNumber(Rational(3))], [twice])


# Zeros in the right half plane


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_checker_counts_the_zeros_that_were_placed(seed: int) -> None:
    draw = random.Random(seed)
    ring = Ring.of([s])
    for _ in range(2):
        right, top, bottom = 0, Rational(draw.choice([1, -3])), Rational(draw.choice([1, 2]))
        for _ in range(draw.randint(1, 5)):
            a, b = Rational(draw.randint(-9, 9), 4), Rational(draw.randint(1, 30), 4)
            pair, n = draw.random() < 0.5, draw.choice([1, 1, 2])
            if pair and a == 0:
                continue
            top *= ((s - a) ** 2 + b**2) ** n if pair else (s - a) ** n
            right += n * (2 if pair else 1) * bool(a >= 0)
        for _ in range(draw.randint(0, 2)):
            bottom *= (
                s**2 + s * Rational(draw.randint(1, 9), 7) + pi
                if draw.random() < 0.5
                else s + Rational(draw.randint(1, 99), 101)
            )
        told = zeros(ring.convert(top / bottom).reduced())
        assert counted(told, _pairs(top, bottom), 20) == right, (top, bottom)


def _pairs(top: Expr, bottom: Expr) -> Any:
    """A quotient at a point of a checker, by Horner's rule."""
    above, below = (x.expand().as_poly(s).all_coeffs() for x in (top, bottom))

    def number(c: Expr, p: int) -> tuple[Value, Value]:
        c0 = c.subs(pi, 0)
        n = Rational(c.subs(pi, p))
        degrees = (0, int(c != c0), 0, 0, 0, 0)
        return Value(int(n.p), 0, degrees), Value(int(n.q))

    def at(point: Any) -> Any:
        found = []
        for row in (above, below):
            total = (Value(0), ONE)
            for c in row:
                total = combined("+", combined("*", total, point.s), number(c, point.pi))
            found.append(total)
        return combined("/", *found)

    return at


def test_zeros_with_pi_and_without_a_real_part() -> None:
    ring = Ring.of([s, pi])
    for f, many in (
        ((s - pi) * (s + 1), 1),
        ((s**2 - pi * s + 7) * (s + pi), 2),
        (s * (s + pi), 1),
        (s**3 + s**2 + 4 * s + 1, 0),
        (s**4 + s**3 + s**2 + 4 * s + 1, 2),
        (s**3 + s + 1, 2),  # no s^2, and so an E that falls short of its place
        (s**5 + s**4 + 3 * s + 1, 2),
        (s**4 + 2 * s + 3, 2),
        (s**7 + 2 * s**3 + s + 5, 4),
    ):
        told = zeros(ring.convert(f).reduced())
        assert counted(told, _pairs(f, Rational(1)), 20) == many
    with pytest.raises(SceneError, match="zero everywhere"):
        zeros(ring.convert(Rational(0)))


# What a certificate has room for


def test_points_of_the_grid_are_counted_from_the_degrees() -> None:
    two = {"waves": [1], "terms": [[[1, 0, 2], [["1", "2"], ["0"], ["-3"]]], [[0, 1, 0], [["8"]]]]}
    one = {"step": 2, "polynomial": [["1"], ["0", "1"], ["1"]]}
    assert list(checkable._degrees(two)) == [2, 1, 1, 2]
    assert list(checkable._degrees(one)) == [4, 1]
    proof = {
        "delays": ["1"],
        "orders": ["1/2"],
        "factors": [two, one],
        "functions": {
            "a": {"number": "1", "powers": [[0, 2], [1, -3]]},
            "b": {"number": "1", "powers": [[1, 1], [0, 1]]},
        },
    }
    # above: 2 * (2, 1, 1, 2), or (2, 1, 1, 2) + (4, 1); below: 3 * (4, 1)
    assert checkable._points(proof) == 13 * 4 * 3 * (5 * 6 // 2)
    assert checkable._points({"cells": []}) == 0
    assert checkable._points({"delays": [], "factors": [], "functions": {}}) == 1


def test_a_checker_that_would_work_too_long_is_told_of() -> None:
    one = [Fraction(3, 4), Fraction(1)]  # seven bits
    limit = 5 * 10**9
    written._afford(one, ["3/4"], [limit // 7])
    for points, ends, costs in (
        (one, [], [limit // 7 + 1]),
        (one, [], [limit // 14 + 1] * 2),
        ([], ["3/4", "1"], [10 * (limit // 7 + 1)]),
    ):
        with pytest.raises(SceneError):
            written._afford(points, ends, costs)
    written._afford([], ["3/4", "1"], [10 * (limit // 7)])


@pytest.mark.parametrize("width", [10, 13, 17])
def test_slabs_are_written_between_ends_that_a_checker_takes_and_hardly_shorter_ones(width: int) -> None:
    """The numbers of both ends have so many bits together; the writer keeps two of them in hand."""
    factor = Factor(((1,) * width, (1,)), 1)
    own = factor_of(factor.told(), (), ())
    most = (10**5 - 1) // width
    for bits, is_written, is_taken in ((most - 2, True, True), (most, False, True), (most + 1, False, False)):
        low, high = Fraction(1), Fraction(2 ** (bits - 4))
        with nullcontext() if is_written else pytest.raises(SceneError, match="too long"):
            requirements._afford([{"from": str(low), "to": str(high), "points": []}], Linked([factor], {}))
        with nullcontext() if is_taken else pytest.raises(RefusedError, match="too long"):
            Slices(own, low.as_integer_ratio(), high.as_integer_ratio())


def test_frequencies_have_room_for_digits_by_what_a_checker_knows() -> None:
    rational, with_pi = Factor(((1,), (1,)), 1), Factor(((1, 1), (1,)), 1)
    e: Any = SimpleNamespace(scene=SimpleNamespace(band=(Rational(0), Rational(9))))
    hertz: Any = SimpleNamespace(scene=SimpleNamespace(band=(Rational(0), 2 * pi)))
    linked = lambda *f, delays=(), orders=(): written.Linked([*f], {}, delays, orders)  # noqa: E731
    assert written._room(e, linked(rational)) == 1000
    assert written._room(e, linked(rational, with_pi)) == 90
    assert written._room(hertz, linked(rational)) == 90
    assert written._room(e, linked(delays=(Fraction(1),))) == written._room(e, linked(orders=(Fraction(1, 2),))) == 50


def test_what_is_read_is_what_is_told() -> None:
    assert polynomial(told_rows(((1, -2), (0, 5)))) == [[1, -2], [0, 5]]


@pytest.mark.parametrize(
    "name", ["fu2019", "four-channel-teleoperation", "virtual-wall", "two-mass-resonance", "zener-tissue"]
)
def test_a_free_number_is_found_in_the_file_of_its_scene_at_its_own_place(name: str) -> None:
    scene = hs.load_scene(name)
    table, found, absent = tomllib.loads(scene.text), 0, dict[str, str]()
    for free in (x for x in scene.knobs if not x.is_of_hand and not x.parts):
        try:
            path = _keys(scene, SimpleNamespace(free=free), None)  # type: ignore[arg-type]
        except hs.SceneError as error:
            absent[free.path] = str(error)  # a default, which the file does not have
            continue
        own: Any = table
        for key in path:
            own = own[key]
        found += 1
        assert number(own, free.dimension).value == free.value
    assert found > 3
    assert all(path in words for path, words in absent.items())


def test_a_number_of_one_of_several_environments_or_of_a_formula_is_found_as_if_there_were_no_others() -> None:
    text = """[[environments]]
name = "soft"
model = "expression"
H = "k_1 + b*s"
parameters = {k_1 = "300 N/m", b = 2}
[[environments]]
model = "kelvin-voigt"
k = 70
b = "3/2"
[[effects]]
model = "delay"
tau = "2 ms"
[[effects]]
model = "first-order-lag"
omega_c = 90
"""
    scenes = read_scenes(text)
    soft, wall = scenes.scenes["soft"], scenes.scenes["kelvin-voigt"]
    for scene, environment, path, keys in (
        (soft, "soft", "environment.k_1", ["environment", "parameters", "k_1"]),
        (soft, "soft", "omega_c", ["effects", 1, "omega_c"]),
        (wall, "kelvin-voigt", "environment.b", ["environment", "b"]),
        (wall, "kelvin-voigt", "effects.delay.tau", ["effects", 0, "tau"]),
    ):
        assert _keys(scene, SimpleNamespace(free=scene.knobs[path]), environment) == keys  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(12))
def test_values_of_a_certificate_are_intervals_that_do_and_those_between_and_beside_them_that_do_not(seed: int) -> None:
    """Up to the bounds of ends at which something binds, and to the very ends of what was asked about."""
    pick, around = random.Random(seed), Fraction(1, 100)
    marks = [Fraction(x, 2) for x in sorted(pick.sample(range(-20, 21), 8))]
    low, high = (x if pick.random() < 0.6 else None for x in (marks[0], marks[-1]))
    count = pick.randint(0, 3)
    places: list[Any] = marks[1 : 1 + 2 * count]
    binds = [True] * len(places)
    if count and pick.random() < 0.5:
        places[0], binds[0] = low, False
    if count and pick.random() < 0.5:
        places[-1], binds[-1] = high, False

    def end(x: Fraction | None, bound: bool) -> End:  # noqa: FBT001
        binding = (Binding(noticed(hs.Threshold())[0], None, Kind.EDGE),) if bound else ()
        return End(
            None if x is None else ExactNumber(Rational(x.numerator, x.denominator)), closed=True, bindings=binding
        )

    def bounds(x: End) -> Any:
        if x.value is None:
            return None
        value = Fraction(str(x.value.value))  # type: ignore[attr-defined]
        return (value - around, value + around) if x.bindings else (value, value)

    listed = [end(x, b) for x, b in zip(places, binds, strict=True)]
    spans = tuple(Span(a, b) for a, b in zip(listed[::2], listed[1::2], strict=True))
    ends = [None if x is None else Rational(x.numerator, x.denominator) for x in (low, high)]
    found = _values(SimpleNamespace(domain=Domain(*ends), feasible=spans), bounds)  # type: ignore[arg-type]
    expected, here, stop = [], low, not count or binds[-1]
    for i in range(count):
        a, b = places[2 * i], places[2 * i + 1]
        if binds[2 * i]:
            expected.append((here, a - around, False))
        expected.append((a + around if binds[2 * i] else a, b - around if binds[2 * i + 1] else b, True))
        here = b + around if binds[2 * i + 1] else b
    expected += [(here, high, False)] if stop else []
    assert found == expected


def test_ends_that_meet_or_single_values_have_no_certificate() -> None:
    def end(x: int) -> End:
        return End(
            ExactNumber(Integer(x)), closed=True, bindings=(Binding(noticed(hs.Threshold())[0], None, Kind.EDGE),)
        )

    def wide(x: End) -> Any:
        return Fraction(int(x.value.value)) - 1, Fraction(int(x.value.value)) + 1  # type: ignore[union-attr]

    asked = Domain(None, None)
    one = end(3)
    for spans, words in (
        ((Span(one, one),), "no room for a single value"),
        ((Span(end(0), end(9)), Span(end(10), end(20))), "told apart"),
    ):
        with pytest.raises(hs.SceneError, match=words):
            _values(SimpleNamespace(domain=asked, feasible=spans), wide)  # type: ignore[arg-type]
