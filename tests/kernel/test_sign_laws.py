"""Signs far out, signs of what is made of minima and maxima, and zeros of numbers made of exponentials: against samples and mpmath."""

from __future__ import annotations

import itertools
import math
import random
from itertools import pairwise
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import arb, fmpq
from sympy import Expr, Integer, Rational, exp, lambdify, pi

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.exponentials import Exponentials
from haptisym.kernel.factoring import _polynomial_factor
from haptisym.kernel.far import Sense, far
from haptisym.kernel.lattices import Lattice, Piece, met
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.roots import chart
from haptisym.kernel.symbols import omega as w
from haptisym.kernel.symbols import s

SEEDS = range(40)
AXIS = Ring().axis


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
@pytest.mark.parametrize("seed", SEEDS)
def test_signs_far_out_are_those_of_samples(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(2):
        x = far_out(draw)
        if not x.has(s):
            continue
        value, response = lambdify(s, x), on_axis(Ring.of([x]).convert(x))
        for raw, part in ((response.raw_real, np.real), (response.raw_imag, np.imag)):
            found = far(raw)
            begin = max(1e9, float(found.radius))
            grid = np.linspace(begin, begin + 4000, 20_001)
            own = part(value(1j * grid))
            lead = float(raw_degree(x))
            own = own / grid**lead
            low, high, size = own.min(), own.max(), abs(own).max()
            if found.sense in (Sense.POSITIVE, Sense.NEGATIVE):
                assert low * found.sense.value > -1e-3 * size
                assert high * found.sense.value > -1e-3 * size
                beyond = float(found.radius) * np.concatenate(
                    [1 + np.linspace(1e-9, 3, 20_001), np.logspace(0.6, 3, 4001)]
                )
                near = part(value(1j * beyond)) * found.sense.value
                assert (near > -1e-9 * abs(near).max()).all()
                assert found.radius > 0
            elif found.sense is Sense.BOTH:
                assert low < 1e-3 * size
                assert high > -1e-3 * size
            if low > 0.3 * size or high < -0.3 * size:
                assert found.sense is (Sense.POSITIVE if low > 0 else Sense.NEGATIVE)
            if low < -0.2 * size and high > 0.2 * size:
                assert found.sense is Sense.BOTH


@pytest.mark.parametrize("turns", [1, 3, 16, 24])
def test_how_far_out_a_sign_is_settled_does_not_turn_on_how_fine_the_unit_of_the_delays_is(turns: int) -> None:
    """2 omega^2 outweighs 100 |omega|^(1/2) from 50^(2/3) rad/s on, whatever part of the delay is taken as the unit."""
    ring = Ring.of([exp(-s / 500), s ** Rational(1, 2)])
    late = ring.convert(exp(-s / 500))
    x = ring.convert(2 * s**2) + ring.convert(100 * s ** Rational(1, 2)) * late**turns
    found = far(on_axis(x).raw_real)
    assert found.sense is Sense.NEGATIVE
    assert found.radius <= 3 * 50 ** (2 / 3)


def test_where_waves_keep_clear_of_0_they_prevail_over_what_is_less_than_their_least() -> None:
    """omega^2 (3/2 + cos omega + cos 2 omega) - k: 3/8 omega^2 where cos is -1/4, and k is any share of a power of two."""
    lead = s**2 * (Rational(3, 2) + exp(-s) + exp(-2 * s))
    ring = Ring.of([lead])
    whole = ring.convert(lead.expand())
    for n in range(8):
        k = Rational(round(2**10 * 2 ** (n / 4)), 2**6)
        found = far(on_axis(-whole - ring.convert(k)).raw_real)
        assert found.sense is Sense.POSITIVE
        assert k < Rational(3, 8) * found.radius**2 < 40 * k
        still = ring.convert(
            (s**2 * (5 - exp(-s) - 2 * exp(-2 * s))).expand()
        )  # at least 5 - 3, and nothing is given away
        found = far(on_axis(-still - ring.convert(k)).raw_real)
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


# What is positive where all pieces of some term are


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
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
        for n in (1, 3, 5, 8):
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
    for n in range(41, 640, 7):
        at = Rational(n, 80)
        if at not in places:
            assert any(float(x.low.omega) <= at <= float(x.high.omega) for x in kept) == (value(at) <= 0)


@pytest.mark.parametrize("group", range(4))
def test_a_lattice_has_a_pole_where_it_grows_without_bound_on_a_side(group: int) -> None:
    """Not where a piece does that is outweighed: of the smaller the one that goes to infinity, of the larger the one that goes below all."""
    for seed in range(10 * group, 10 * group + 10):
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


@pytest.mark.parametrize("seed", range(4))
def test_a_lattice_is_undecided_where_its_sign_turns_on_that_of_a_piece_that_may_touch_0(seed: int) -> None:
    """Right there such a piece may be on either side of 0, or be 0; all others have the signs of both sides."""
    draw = random.Random(seed)
    for _ in range(30):
        shape = [draw.randint(1, 2) for _ in range(draw.randint(1, 3))]
        names = [[Piece("it", i, j) for j in range(n)] for i, n in enumerate(shape)]
        lattice = Lattice(tuple((RealFunction(AXIS.one),) * n for n in shape))
        signs = {x: draw.choice([-1, 1]) for term in names for x in term}
        doubtful = [x for x in signs if draw.random() < 0.4]
        seen = set()
        for guess in itertools.product((-1, 0, 1), repeat=len(doubtful)):
            own = {**signs, **dict(zip(doubtful, guess, strict=True))}
            seen.add(max(min(own[x] for x in term) for term in names))
        orders = dict.fromkeys(doubtful, 2)
        found = met(lattice, "it", orders, (signs, signs), frozenset([*doubtful, "another"]))
        assert found.undecided is (len(seen) > 1)
        assert found.before == found.after == max(min(signs[x] for x in term) for term in names)


def test_the_largest_of_functions_is_positive_where_any_of_them_is() -> None:
    any_of = Lattice.largest(RealFunction(AXIS.convert(x)) for x in (w - 3, 2 - w, (w - 5) ** 2 - 9))
    points = chart({"it": any_of}, Integer(1), Integer(9)).points
    assert [(float(p.omega), p.after["it"]) for p in points[:-1] if p.before["it"] != p.after["it"]] == [
        (2, -1),
        (3, 1),
    ]
    assert points[0].before["it"] == 1


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


@pytest.mark.parametrize("seed", range(6))
def test_a_factor_without_waves_has_the_values_of_its_polynomial_whatever_is_missing_of_it(seed: int) -> None:
    """Of powers of omega and of pi before them, each there or not: what is even is kept in squares, and nothing else is."""
    draw = random.Random(seed)
    for _ in range(40):
        rows = [
            [draw.choice([0, 0, -2, 1, 3]) for _ in range(draw.choice([1, 1, 2, 3]))] for _ in range(draw.randint(1, 6))
        ]
        own = sum((c * pi**k * w**n for n, row in enumerate(rows) for k, c in enumerate(row)), Integer(0))
        if own == 0:
            continue
        factor = _polynomial_factor(AXIS.convert(own).numerator)
        for x in (0.5, 1.0, 2.75):
            with flint.ctx.workprec(128):
                ball = factor.value(arb(x))
            assert float(ball) == pytest.approx(float(own.subs(w, Rational(x))), rel=1e-12, abs=1e-12)


def with_a_pole(draw: random.Random) -> Expr:
    factor = (w - draw.choice([1, 2, 3, 4])) ** draw.choice([-2, -1, -1, 1, 2])
    return Integer(draw.choice([-2, -1, 1, 3])) * factor + draw.choice([0, 0, 1])


# Numbers made of exponentials

MP = mpmath.mp.clone()
MP.prec = 300


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_numbers_made_of_exponentials_are_zero_where_they_are(seed: int) -> None:
    draw = random.Random(seed)
    factors = draw.choice([[(1, 1)], [(-2, 0, 1)], [(3, 2), (-2, 0, 1)], [(1, 1, 1)], [(5, 2, 3)], [(-1, 2), (1, 3)]])
    times = [fmpq(1, 2), fmpq(1)]
    ring = Exponentials(factors, times)
    roots = [complex(x) for f in factors for x in np.roots(f[::-1])]
    order = [complex(x.real.mid(), x.imag.mid()) for x in ring._roots(128)]
    assert sorted((round(x.real, 9), round(x.imag, 9)) for x in roots) == sorted(
        (round(x.real, 9), round(x.imag, 9)) for x in order
    )

    def some() -> tuple[Any, Any]:
        """An element, and its value."""
        total, value = ring.constant(draw.randint(-3, 3)), MP.mpf(0)
        value += int(total.coeffs()[0]) if not total.is_zero() else 0
        for _ in range(draw.randint(1, 3)):
            i, k, c = draw.randrange(len(order)), draw.randrange(2), draw.choice([-2, 1, 3])
            z = [MP.mpc(x) for x in exactly()][i]
            which = draw.randint(0, 2)
            element = [ring.root(i), ring.exponential(i, k), ring.pi][which]
            total += c * element
            value += c * [z, MP.exp(z * [MP.mpf(1) / 2, 1][k]), MP.pi][which]
        return total, value

    def exactly() -> list[Any]:
        exact = [x for f in factors for x in MP.polyroots([MP.mpf(c) for c in f[::-1]], maxsteps=200, extraprec=400)]
        return [min(exact, key=lambda z: abs(complex(z) - x)) for x in order]

    for _ in range(3):
        (x, a), (y, b) = some(), some()
        assert ring.is_zero(x) == (abs(a) < 1e-60)
        assert ring.is_zero(x * y) == (abs(a * b) < 1e-60)
        assert ring.is_zero((x + y) ** 2 - x**2 - 2 * x * y - y**2)
        assert not ring.is_zero((x + y) ** 2 - x**2 - 2 * x * y - y**2 + 1)
    for i, z in enumerate(exactly()):
        own = next(f for f in factors if abs(sum(c * z**n for n, c in enumerate(f))) < 1e-60)
        polynomial = sum((c * ring.root(i) ** n for n, c in enumerate(own)), ring.constant(0))
        assert ring.is_zero(polynomial)
        assert ring.is_zero(polynomial * ring.exponential(i, 0) + ring.exponential(i, 1) - ring.exponential(i, 0) ** 2)
        assert not ring.is_zero(polynomial * 3 + ring.constant(fmpq(1, 10**30)))


def test_a_zero_at_five_quarters_beside_powers_of_omega_is_one_like_any_other() -> None:
    """There it is looked whether powers cancel everywhere."""
    x = (16 * s**2 + 25) * (s ** Rational(1, 2) + 1)
    f = on_axis(Ring.of([x]).convert(x.expand())).imag
    table = chart({"it": f}, Integer(1), Integer(2))
    assert [(float(p.omega), p.before["it"], p.after["it"]) for p in table.points[1:-1]] == [(1.25, 1, -1)]


def test_where_the_highest_waves_touch_0_those_below_decide_with_all_their_terms() -> None:
    """omega^3 (1 + cos 2 omega) + omega cos 2 omega: 2 omega^3 + omega at n pi, -omega between."""
    x = -(s**3) * (1 + exp(-2 * s)) + s * exp(-2 * s)
    assert far(on_axis(Ring.of([x]).convert(x.expand())).raw_imag).sense not in (Sense.POSITIVE, Sense.NEGATIVE)
    x = -(s**3) * (1 + exp(-2 * s)) + s * (2 + exp(-2 * s))
    assert far(on_axis(Ring.of([x]).convert(x.expand())).raw_imag).sense is Sense.POSITIVE


def test_a_zero_of_a_lattice_is_as_manifold_as_that_of_the_term_that_vanishes() -> None:
    """max(min(w - 3, -1), (w - 3)^3) is (w - 3)^3 there."""
    terms = [[w - 3, Integer(-1)], [(w - 3) ** 3]]
    lattice = Lattice(tuple(tuple(RealFunction(AXIS.convert(x).reduced()) for x in term) for term in terms))
    [place] = chart({"it": lattice}, Rational(1, 2), Integer(8)).points[1:-1]
    assert (float(place.omega), place.orders["it"]) == (3, 3)
