"""Roots to the right of an axis and inside a circle, eliminants and numbers of turns: against roots placed by hand, SymPy and mpmath."""

from __future__ import annotations

import cmath
import random
from dataclasses import dataclass
from math import log2
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from flint import Ordering, arb, fmpq, fmpq_mpoly_ctx
from sympy import Expr, Integer, Poly, Rational, Symbol, cos, exp, pi, sin, symbols
from sympy import discriminant as known_discriminant
from sympy import resultant as known_resultant

from haptisym.kernel import squares
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.eliminants import discriminant, resultant
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.response import on_axis
from haptisym.kernel.rings import PolynomialRing
from haptisym.kernel.rootcount import RootChain, count_roots, floor_of, prevailing
from haptisym.kernel.roots import chart
from haptisym.kernel.schurcohn import Circle, count_on_circle
from haptisym.kernel.stability import is_stable
from haptisym.kernel.symbols import omega, s
from haptisym.kernel.terms import at_least, beginning_at_0, order_at_0, size, terms_of
from haptisym.kernel.turns import is_zero

SEEDS = range(20)

# Roots in Re s >= 0

RIGHT: list[tuple[Expr, int]] = [
    (s + exp(-s), 0), (s + 2 * exp(-s), 2), (s - exp(-s), 1), (s - 5 * exp(-s), 3), (s + 8 * exp(-s), 4), (s + 1 + exp(-s) / 2, 0),
    (2 * s + 1 + s * exp(-s), 0), (s + 2 + exp(-s), 0), (1 + exp(-s) / 2, 0), (s + 1 + s ** Rational(1, 2), 0), (s - s ** Rational(1, 2) + 1, 0),
    (s - Rational(3, 2) * s ** Rational(1, 2) + 1, 2),
]  # fmt: skip
"""Functions whose roots are known: s + a exp(-s) has none up to a = pi/2, then two more with every turn; s - a exp(-s) one up to 3 pi/2."""


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(40))
def test_roots_of_products_are_those_of_their_factors(seed: int) -> None:
    draw = random.Random(seed)
    total, right, axis = Integer(draw.choice([1, -2])), 0, list[Expr]()
    late, own = draw.choice(RIGHT)
    if draw.random() < 0.6:
        total, right = total * late, own
    at_0 = draw.choice([0, 0, 1, 2])
    for _ in range(draw.randint(0, 2)):
        a, b, n = Rational(draw.choice([-3, -1, 1, 2]), 2), draw.randint(1, 6), draw.choice([1, 1, 2])
        match draw.randint(0, 2):
            case 0:
                total, right = total * (s - a) ** n, right + n * bool(a > 0)
            case 1:
                total, right = total * ((s - a) ** 2 + b**2) ** n, right + 2 * n * bool(a > 0)
            case _:
                if b not in axis:
                    total, right, axis = total * (s**2 + b**2) ** n, right, [*axis, *[Integer(b)] * n]
    total *= s**at_0
    ring = Ring.of([late, total.expand()])
    try:
        found = count_roots(ring.convert(total.expand()).numerator, ring)
    except UndecidedError:
        assert (axis and late.has(exp)) or late.has(s ** Rational(1, 2)), total  # whether it is zero just there
        return
    assert found.chain is None
    assert (found.number, found.right) == (right + at_0 + 2 * len(axis), right), total
    expected = sorted({*axis, *([Integer(0)] if at_0 else [])}, key=float)
    assert [round(float(x), 9) for x in found.on_axis] == [float(x) for x in expected]
    stable = is_stable(ring.convert(1 / total.expand()).reduced())
    assert stable in (found.number == 0, None)
    assert stable is not None or ring.functions


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_floor_is_below_what_stands_before_the_highest_power_and_a_chain_is_where_its_zeros_are(seed: int) -> None:
    """L(z) = c_0 + ... + c_n z^n, |z| <= 1; its zeros with |z| < 1 are roots far out on the right."""
    draw = random.Random(seed)
    ring = Ring.of([exp(-s)])
    for _ in range(4):
        c = [draw.randint(-4, 4) for _ in range(draw.randint(2, 4))]
        c[0], c[-1] = c[0] or 3, c[-1] or -1
        group = {(i,): Integer(x) for i, x in enumerate(c) if x}
        zeros = np.roots(c[::-1])
        found = floor_of(group, ring)
        if min(abs(zeros)) < 1 - 1e-6:
            assert found is RootChain.RIGHT
        elif min(abs(zeros)) < 1 + 1e-6:
            assert found is RootChain.NEAR
        else:
            least = min(
                abs(sum(x * cmath.exp(2j * cmath.pi * k * i / 2000) for i, x in enumerate(c))) for k in range(2000)
            )
            assert not isinstance(found, RootChain)
            assert 0 < found <= least + 1e-9
            assert (
                least < 2.01 * found
                or found == c[0] - sum(map(abs, c[1:]))
                or found == abs(c[0]) - sum(map(abs, c[1:]))
                or found == 1
            )
    assert floor_of({(1,): Integer(1)}, ring) is RootChain.RIGHT


@pytest.mark.parametrize("seed", range(2))
def test_what_is_known_to_have_no_root_on_the_right_is_counted_like_anything_else(seed: int) -> None:
    """None but one at 0; and a chain that comes near to the axis is seen."""
    draw = random.Random(seed)
    for _ in range(6):
        total, _ = draw.choice([x for x in RIGHT if not x[1]])
        for _ in range(draw.randint(0, 2)):
            a, b = (Rational(draw.randint(1, 9), 2) for _ in range(2))
            total *= draw.choice([s + a, s**2 + a * s + b])
        at_0 = draw.choice([0, 1])
        ring = Ring.of([total])
        polynomial = ring.convert((total * s**at_0).expand()).numerator
        known, counted = count_roots(polynomial, ring, rests=True), count_roots(polynomial, ring)
        assert (known.number, known.right, known.chain) == (at_0, 0, None)
        assert (counted.number, counted.right, counted.chain) == (at_0, 0, None)
        assert [float(x) for x in known.on_axis] == [float(x) for x in counted.on_axis] == [0.0] * at_0
        late = Ring.of([exp(-s)])
        a, b = draw.randint(1, 9), draw.randint(1, 9)
        mirrored = late.convert(s * (1 + exp(-s)) + a - b * exp(-s) / 10).numerator
        assert count_roots(mirrored, late, rests=True).chain is RootChain.NEAR


def test_two_delays_oppose_where_they_are_independent() -> None:
    ring = Ring.of([exp(-s), exp(-pi * s)])
    both = {(1, 0): Integer(1), (0, 1): Integer(1)}
    one, of_pi = ((1, 0), (0, 1))
    assert {one, of_pi} == both.keys()
    assert floor_of({(0, 0): Integer(3), **both}, ring) == 1
    assert floor_of({(0, 0): -pi, **both}, ring) == pi - 2
    assert floor_of({(0, 0): Integer(2), **both}, ring) is RootChain.NEAR
    assert floor_of({(0, 0): Rational(3, 2), **both}, ring) is RootChain.RIGHT
    with pytest.raises(UndecidedError):
        floor_of({(0, 0): Integer(1), (1, 1): Integer(1), (1, 0): Integer(1)}, ring)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_from_a_radius_on_the_highest_power_prevails(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(20):
        degree, floor = Rational(draw.randint(3, 9), 2), Rational(draw.randint(1, 30), 7)
        weights = {
            Rational(n, 2): Rational(draw.randint(1, 10**6), draw.randint(1, 99))
            for n in draw.sample(range(2 * int(degree)), 2)
        }
        found = prevailing(degree, floor, weights)

        def holds(r: float, degree: Rational = degree, floor: Rational = floor, weights: Any = weights) -> bool:
            return bool(floor * r**degree > sum(weight * r**p for p, weight in weights.items()))

        assert float(found) == 2.0 ** round(log2(found))
        assert holds(float(found))
        assert found == Rational(1, 2**20) or not holds(float(found) / 2)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_beginning_at_0_is_that_of_the_function(seed: int) -> None:
    draw = random.Random(seed)
    mp = mpmath.mp.clone()
    mp.prec = 900
    for _ in range(3):
        x = sum(
            (draw.randint(-3, 3) * s**n * exp(-draw.randint(0, 2) * s / 3) for n in (0, 0, 0, 1, 1, 2)), Integer(0)
        ).expand()
        x = x - x.subs(s, 0) * draw.randint(0, 1) + draw.choice([0, 0, 2]) * s ** Rational(5, 2)
        if x == 0 or x.is_number:
            continue
        ring = Ring.of([x, exp(-s / 3)])
        polynomial = ring.convert(x).numerator
        order, sign = beginning_at_0(terms_of(polynomial, ring), ring)
        assert order == order_at_0(polynomial, ring)
        tiny = mp.mpf(10) ** -40

        def value(v: Any, x: Expr = x) -> Any:
            total = mp.mpf(0)
            for term in x.as_ordered_terms():
                c, rest = term.as_coeff_Mul()
                n = (
                    rest.subs(exp(-s / 3), 1).subs(exp(-2 * s / 3), 1).as_base_exp()[1]
                    if rest.has(s) and rest.subs(exp(-s / 3), 1).subs(exp(-2 * s / 3), 1) != 1
                    else 0
                )
                late = 2 if rest.has(exp(-2 * s / 3)) else 1 if rest.has(exp(-s / 3)) else 0
                total += mp.mpf(c.p) / c.q * v ** (mp.mpf(n.p) / n.q if n else 0) * mp.exp(-late * v / 3)
            return total

        slope = mp.log(abs(value(tiny) / value(tiny / 2))) / mp.log(2)
        assert abs(slope - float(order)) < 1e-6
        assert (value(tiny) > 0) == (sign > 0)
    assert [at_least(x) for x in (Rational(0), Rational(1, 3), Rational(1), Rational(7, 3))] == [0, 1, 1, 3]
    assert (size(-pi), size(Integer(3))) == (pi, 3)


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_squares_on_the_axis_are_those_of_both_polynomials(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(10):
        a, b = ([draw.randint(-9, 9) for _ in range(draw.randint(1, 4))] for _ in range(2))
        a[-1], b[-1] = a[-1] or 2, b[-1] or 1
        table: Any = {}
        for row, turns in ((a, (0, 0)), (b, (0, 1))):
            for n, c in enumerate(row):
                if c:
                    table.setdefault(Rational(n), {})[turns] = [Integer(c)]
        found = [int(row[0]) for row in squares.squares(table, (0, 1))]
        w = draw.randint(1, 9)
        A, B = (sum(c * (1j * w) ** n for n, c in enumerate(row)) for row in (a, b))
        own = sum(c * w ** (2 * (len(found) - 1 - i)) for i, c in enumerate(found))
        assert own == round(abs(A) ** 2 - abs(B) ** 2)
        if (len(a), abs(a[-1])) <= (len(b), abs(b[-1])):
            continue
        own_terms = {p: {turns: row[0] for turns, row in group.items()} for p, group in table.items()}
        start = squares.positive_from(own_terms, (0, 1))
        assert start is not None
        for n in range(200):
            at = float(start) * 1.1**n
            A, B = (sum(c * (1j * at) ** k for k, c in enumerate(row)) for row in (a, b))
            assert abs(A) > abs(B)
    assert squares.late_turns({(0, 0), (0, 2)}, [Rational(1)]) == (0, 2)
    assert squares.late_turns({(0, 0), (0, 2), (1, 0)}, [Rational(1)]) is None
    assert squares.late_turns({(0, 0)}, [Rational(1)]) is None
    assert squares.late_turns({(0, 2)}, [Rational(1, 2)]) is None
    open_one: Any = {Rational(1): {(0,): [Integer(1), Integer(2)]}, Rational(0): {(1,): [Integer(3), Integer(0)]}}
    assert squares.squares(open_one, (1,)) == [[1, 4, 4], [-9, 0, 0]]


# Inside a circle


@dataclass
class Whole:
    c: list[int]
    known: bool = True

    def balls(self) -> list[Any]:
        return (
            [arb(x) for x in self.c]
            if self.known
            else [arb(x) + arb(0, 1) * arb(2) ** (10 - flint.ctx.prec) for x in self.c]
        )

    def exact(self) -> Any:
        return [fmpq(x) for x in self.c] if self.known else None

    def is_zero(self, x: Any) -> bool:
        return bool(x == 0)


def product(rows: list[list[int]]) -> list[int]:
    found = [1]
    for row in rows:
        found = [
            sum(found[i] * row[n - i] for i in range(len(found)) if 0 <= n - i < len(row))
            for n in range(len(found) + len(row) - 1)
        ]
    return found


PLACED = [
    ([-1, 2], (1, 0, 0)), ([-2, 1], (0, 0, 1)), ([1, -2], (1, 0, 0)), ([3, 1], (0, 0, 1)), ([0, 1], (1, 0, 0)), ([-1, 1], (0, 1, 0)), ([1, 1], (0, 1, 0)),
    ([1, 0, 1], (0, 2, 0)), ([1, 1, 1], (0, 2, 0)), ([5, -6, 5], (0, 2, 0)), ([2, -5, 2], (1, 0, 1)), ([1, 0, 2], (2, 0, 0)), ([5, 1, 1], (0, 0, 2)), ([1, 2, 5], (2, 0, 0)),
]  # fmt: skip


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_roots_inside_on_and_outside_of_a_circle_are_those_that_were_placed(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(8):
        chosen = [draw.choice(PLACED) for _ in range(draw.randint(1, 4))]
        row = product([[draw.choice([-3, 1])], *(row for row, _ in chosen)])
        own = Circle(*(sum(x) for x in zip(*(count for _, count in chosen), strict=True)))
        assert count_on_circle(Whole([*row, *[0] * draw.randint(0, 2)])) == own, row


def test_of_a_root_on_the_circle_nothing_is_said_without_exact_coefficients() -> None:
    with pytest.raises(UndecidedError):
        count_on_circle(Whole([1, 1, 1], known=False))
    assert count_on_circle(Whole([3, 4, 5], known=False)) == (2, 0, 0)
    assert count_on_circle(Whole([5, 4, 3], known=False)) == (0, 0, 2)


# Eliminants

X = symbols("x a b")


def polynomial(draw: random.Random, degree: int, others: int, context: Any) -> tuple[Any, Expr]:
    """With whole coefficients, and the same for SymPy."""
    gens, total, same = context.gens(), context.constant(0), Integer(0)
    for n in range(degree + 1):
        for _ in range(2):
            c, i, j = draw.choice([-7, -2, 1, 3, 100]), draw.randint(0, 2), draw.randint(0, 1) * (others > 1)
            if draw.random() < 0.5 or n == degree:
                total += c * gens[0] ** n * gens[1] ** i * gens[2] ** j
                same += c * X[0] ** n * X[1] ** i * X[2] ** j
    return total, same


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_eliminants_are_those_of_sympy(seed: int) -> None:
    draw = random.Random(seed)
    context = fmpq_mpoly_ctx.get(("x", "a", "b"), Ordering.lex)
    others = draw.choice([1, 2])
    n, m = draw.choice([(11, 10), (3, 2)] if others == 1 else [(5, 4), (2, 2), (4, 5)])
    (f, p), (g, q) = (polynomial(draw, k, others, context) for k in (n, m))
    if f.degrees()[0] < 2 or g.degrees()[0] < 1:
        return
    at = {X[1]: draw.randint(2, 9), X[2]: draw.randint(2, 9)}  # SymPy is asked for numbers
    found = resultant(f, g, 0).to_dict()

    def value(terms: Any) -> Any:
        return sum(
            Rational(int(c.p), int(c.q)) * at[X[1]] ** int(e[1]) * at[X[2]] ** int(e[2]) for e, c in terms.items()
        )

    top = [Poly(y, X[0]).LC().subs(at) for y in (p, q)]
    if 0 in top:
        return
    assert value(found) == known_resultant(p.subs(at), q.subs(at), X[0])
    if (others == 2 and n == 5) or others == 1:
        assert value(discriminant(f, 0).to_dict()) == known_discriminant(Poly(p.subs(at), X[0]))
    shared = context.gens()[0] - context.gens()[1]
    assert resultant(f * shared, g * shared, 0).is_zero()
    assert discriminant(f * shared**2, 0).is_zero()


# Numbers of turns


@pytest.mark.few(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_numbers_made_of_cosines_of_parts_of_a_turn_are_zero_where_sympy_and_mpmath_say_so(seed: int) -> None:
    draw = random.Random(seed)
    c0, s0, c1, s1 = (Symbol(x) for x in ("cos0", "sin0", "cos1", "sin1"))
    ring = PolynomialRing(omega, functions=[c0, s0, c1, s1])
    for _ in range(6):
        a, b = (pi * Rational(draw.randint(1, 20), draw.choice([2, 3, 4, 5, 6, 12])) for _ in range(2))
        x = sum(
            (
                draw.randint(-2, 2) * c0 ** draw.randint(0, 2) * s1 ** draw.randint(0, 2) * pi ** draw.randint(0, 1)
                for _ in range(3)
            ),
            Integer(0),
        )
        zero = draw.choice([c0**2 + s0**2 - 1, (c1**2 + s1**2) ** 2 - 1, c0 * 0])
        known = {c0: cos(a / 2), s0: sin(a / 2), c1: cos(b / 2), s1: sin(b / 2)}
        for y in (x, zero * (x + 1), zero * pi + x):
            true = abs(complex(y.subs(known).evalf(40))) if y != 0 else 0.0
            assert is_zero(ring.convert(y.expand()).numerator if y != 0 else ring.constant(0), [a, b]) == (
                true < 1e-25
            ), (y, a, b)
    triple = 4 * c0**3 - 3 * c0 - Rational(1, 2)
    assert is_zero(ring.convert(triple).numerator, [2 * pi / 9, pi])
    assert not is_zero(ring.convert(triple).numerator, [2 * pi / 7, pi])
    assert is_zero(ring.convert(s0 - Rational(1, 2)).numerator, [pi / 3, pi])
    assert is_zero(ring.convert(s0 + Rational(1, 2)).numerator, [-pi / 3, pi])
    assert is_zero(ring.convert(s1 - Rational(1, 2)).numerator, [pi, pi / 3])
    assert is_zero(ring.convert(2 * s0 * s1 - pi * c0).numerator, [pi, pi / 3]) is False
    assert is_zero(ring.convert(2 * s0 * s1 - 1).numerator, [pi, pi / 3])
    assert is_zero(ring.convert(s0 * s1 - 1).numerator, [Integer(1), pi / 3]) is None
    assert is_zero(ring.convert(s0 - 1).numerator, [Integer(1), pi]) is None
    assert is_zero(ring.convert(s0 - 1).numerator, [pi / 20_001, pi]) is None


# A half angle alone


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_zeros_of_one_half_angle_are_where_the_function_changes_sign(seed: int) -> None:
    draw = random.Random(seed)
    a, b, tau = draw.randint(-5, 5), draw.choice([-3, 2, 7]), Rational(draw.randint(1, 9), 7)
    x = a + b * exp(-tau * s) + draw.choice([0, 4]) * exp(-2 * tau * s)
    f = on_axis(Ring.of([x]).convert(x)).real
    low, high = Rational(draw.randint(0, 9), 2), Rational(draw.randint(20, 50), 2)
    table = chart({"it": f}, low, high)
    places = [float(p.omega) for p in table.points[1:-1] if p.orders["it"] % 2]
    grid = np.linspace(float(low), float(high), 40_001)
    own = np.real(
        a + b * np.exp(-1j * float(tau) * grid) + float(x.coeff(exp(-2 * tau * s))) * np.exp(-2j * float(tau) * grid)
    )
    changes = grid[1:][np.sign(own[1:]) * np.sign(own[:-1]) < 0]
    assert len(places) == len(changes)
    assert np.allclose(places, changes, atol=2e-3)
