"""The polynomial of a loop with a clock about z = 1, where fast clocks put all roots: in v, z = (1 + v)/(1 - v), in narrow balls.

exp(A T) - 1 = A int_0^T exp(A t) dt has balls as narrow, relatively, as those of the numbers that it is made of; the coefficients
of z^n have not. Roots with |z| < 1 are those with Re v < 0, so that Hurwitz' determinants say where one leaves.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import comb
from typing import Any

import flint
from flint import arb, arb_mat, arb_poly
from sympy import Add, Expr, Integer

from haptisym.kernel.enclosures import Line, Value, coefficients, narrowest, over_cell, polynomial
from haptisym.kernel.pulse import Plant, SampledLoop, States, column, matrix, opposite_response
from haptisym.kernel.reals import Ball, expression_ball

_ORDER, _FEW = 3, 3  # of Taylor's polynomials over a cell; one less where more numbers than these move
_MOST_PIECES = 200  # of the axis, that are looked at for one polynomial


def about_one(loop: SampledLoop, known: Mapping[Expr, Ball]) -> list[Ball]:
    """The coefficients of z^N C(1/z) in z - 1, ascending, in balls; roots at z = 0 may be added."""
    return _row(loop, _plant(loop, known), known)


def _row(loop: SampledLoop, moved: _Moved, known: Mapping[Expr, Ball]) -> list[Ball]:
    size = max(len(loop.above), len(loop.below)) - 1
    above, below = (
        polynomial([expression_ball(x, known) for x in _shifted(row, size)]) for row in (loop.above, loop.below)
    )
    return coefficients(below * moved.below + above * moved.above)


def _plant(loop: SampledLoop, known: Mapping[Expr, Ball]) -> _Moved:
    return _of_numbers(loop.plant, loop.T, flint.ctx.prec) if loop.is_of_numbers else _moved(loop.plant, loop.T, known)


def about_axis(row: Sequence[Ball]) -> list[Ball]:
    """The coefficients in v, ascending, of a polynomial in z - 1 = 2 v/(1 - v)."""
    n = len(row) - 1
    turned = sum((x * own for x, own in zip(row, _turned(n), strict=True)), arb_poly([]))
    c = coefficients(turned)
    return c + [arb(0)] * (n + 1 - len(c))


def hurwitz(c: Sequence[Ball]) -> Ball:
    """The last determinant but one of Hurwitz: 0 where two roots v add up to 0, a pair on the axis among them."""
    n = len(c) - 1
    if n < 2:
        return arb(1)
    down = c[::-1]
    places = [[2 * (j + 1) - (i + 1) for j in range(n - 1)] for i in range(n - 1)]
    return arb_mat([[down[k] if 0 <= k <= n else arb(0) for k in line] for line in places]).det()


def has_no_pair(c: Sequence[Ball], lines: Sequence[Line] = ()) -> bool:
    """Whether no polynomial with coefficients in these balls has roots v = +-j nu, nu > 0, proven.

    They would be zeros of E = c_0 - c_2 x + c_4 x^2 - ... and of O = c_1 - c_3 x + ..., x = nu^2. In wide balls that says more
    than the determinant, in which their widths are multiplied. ``lines`` : how the coefficients move together over a cell. Of
    E = E_0 + E_1 y_1 + E_2 y_2 ... and O likewise, E_i O - O_i E would be zero as well, in which y_i is not.
    """
    if len(c) < 3:
        return True
    if not all(x.is_finite() for x in c):
        return False
    halves = _halves(c)
    if lines:
        halves += _without_each(lines)
    both = [arb_poly(x) for x in halves], [arb_poly(x[::-1]) for x in halves]  # in x, and in 1/x
    waiting = deque((parts, 0.0, 1.0) for parts in both)
    for _ in range(_MOST_PIECES):
        if not waiting:
            return True
        parts, low, high = waiting.popleft()
        at = arb(low).union(arb(high))
        if all(p(at).contains(0) for p in parts):
            middle = (low + high) / 2
            if all(p(arb(middle)).contains(0) for p in parts):
                return False  # at this very place it stays open, however small the piece
            waiting += [(parts, low, middle), (parts, middle, high)]
    return not waiting


def _without_each(lines: Sequence[Line]) -> list[list[Ball]]:
    """Of each number that moves the coefficients, a combination of E and O without it: its coefficients in x."""
    E_0, O_0 = map(arb_poly, _halves([x.at for x in lines]))
    moves = [[*map(arb_poly, _halves(x))] for x in zip(*(x.slopes for x in lines), strict=True)]
    found = []
    for i, (E_i, O_i) in enumerate(moves):
        own = E_i * O_0 - O_i * E_0
        for j, (E_j, O_j) in enumerate(moves):
            if j != i:
                own += (E_i * O_j - O_i * E_j) * arb(0, 1)
        found.append(own.coeffs())
    return found


def _halves(c: Sequence[Ball]) -> list[list[Ball]]:
    """The coefficients of E and O in x."""
    return [[x * (-1) ** i for i, x in enumerate(c[start::2])] for start in (0, 1)]


def at_one(loop: SampledLoop) -> Expr:
    """B(1) Q(0) + A(1) N(0): C(1) times what is nowhere 0."""
    plant = loop.plant
    return (Add(*loop.below) * plant.denominator[0] + Add(*loop.above) * Add(*(N[0] for _, N in plant.terms))).expand()


def at_minus_one(loop: SampledLoop) -> tuple[Expr, Expr]:
    """A(-1) and B(-1), by which N(-1) and Q(-1) are multiplied there."""
    size = max(len(loop.above), len(loop.below)) - 1
    return _at_minus_one(loop.above, size), _at_minus_one(loop.below, size)


def in_v(loop: SampledLoop, known: Mapping[Expr, Ball], always: int = 0) -> list[Ball]:
    """The coefficients in v, ascending, without so many roots that always lie at 1.

    The highest is told at z = -1 itself: with Tustin's rule the controller has a pole there, and all but little of it cancels.
    """
    moved = _plant(loop, known)
    c = about_axis(_row(loop, moved, known)[always:])
    there = _opposite(moved, at_minus_one(loop), known) / (-2) ** always
    return [*c[:-1], there if len(c) % 2 else -there]


def _opposite(moved: _Moved, rows: tuple[Expr, Expr], known: Mapping[Expr, Ball]) -> Ball:
    """C at z = -1, of a controller's two polynomials there."""
    above, below = (expression_ball(x, known) for x in rows)
    return below * moved.below(arb(-2)) + above * moved.opposite


def circle_tests(loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0) -> tuple[Ball, Ball, Ball]:
    """At z = 1, at z = -1, and where two roots v add up to 0: numbers that vanish where a root is on the circle.

    ``one`` : ``at_one``; ``always`` : how many roots lie at 1 whatever the numbers are.
    """
    c = in_v(loop, known, always)
    return c[0] if always else expression_ball(one, known), c[-1], hurwitz(c)


def is_clear(
    loop: SampledLoop, known: Mapping[Expr, Ball], one: Expr, always: int = 0, opposite: tuple[Expr, Expr] | None = None
) -> bool:
    """Whether no root is on the circle for any numbers in balls, proven; two real ones may add up to 0 in v.

    ``opposite`` : ``at_minus_one``, if it is to be without a factor that is 0 nowhere.
    Taylor's polynomials are asked, too: with a resonance between clock and hand, as behind a compliance, balls are up to a
    thousand times as wide as what the coefficients do.
    """

    def told(numbers: Mapping[Expr, Value]) -> list[Value]:
        """At z = 1, at z = -1, and the coefficients in v/T, of which more stay as they are where the clock's period is open."""
        T, c = expression_ball(loop.T, numbers), in_v(loop, numbers, always)
        there = c[-1] if opposite is None else _opposite(_plant(loop, numbers), opposite, numbers)
        return [c[0] if always else expression_ball(one, numbers), there, *(x * T**i for i, x in enumerate(c))]

    if _is_clear(told(known)):
        return True
    moved = {symbol: q for symbol, q in known.items() if q.rel_accuracy_bits() < flint.ctx.prec // 2}
    if not moved:
        return False
    middles, radii = zip(*((q.mid(), q.rad()) for q in moved.values()), strict=True)
    order = _ORDER if len(moved) <= _FEW else _ORDER - 1
    lines = over_cell(lambda x: told({**known, **dict(zip(moved, x, strict=True))}), middles, radii, order)
    return _is_clear([x.ball for x in lines], lines[2:])


def _is_clear(told: Sequence[Ball], lines: Sequence[Line] = ()) -> bool:
    """By what is at z = 1, what is at z = -1, and the coefficients."""
    at_1, opposite, *c = told
    if any(x.contains(0) or not x.is_finite() for x in (at_1, opposite)):
        return False
    return not hurwitz(c).contains(0) or has_no_pair(c, lines)


@dataclass(frozen=True)
class _Moved:
    """``above`` and ``below`` of a pulse transfer function, polynomials in z - 1; ``opposite`` : the first at z = -1."""

    above: Any
    below: Any
    opposite: Ball


@lru_cache(maxsize=64)
def _of_numbers(plant: Plant, period: Expr, bits: int) -> _Moved:
    """Of a plant without symbols, at this working precision: one matrix exponential for all values of a controller."""
    assert bits == flint.ctx.prec
    return _moved(plant, period, {})


def _moved(plant: Plant, period: Expr, known: Mapping[Expr, Ball]) -> _Moved:
    """The pulse transfer function of a plant."""
    whole = plant.samples(period, known)
    T, lead = (expression_ball(x, known) for x in (period, plant.denominator[-1]))
    Q = [expression_ball(x, known) / lead for x in plant.denominator]
    n = len(Q) - 1
    states = States(Q)
    integral = states.integral(T)
    M, held = states.A * integral, column(integral, n - 1)
    total, opposite, (den, adjugate) = arb_poly([]), arb(0), _leverrier(M)
    longest, there = max(whole) + 1, den(arb(-2))
    for (lag, above), ell in zip(plant.terms, whole, strict=True):
        N = [expression_ball(x, known) / lead for x in above]
        N += [arb(0)] * (n + 1 - len(N))
        C = states.row([x - N[n] * q for x, q in zip(N, Q, strict=True)][:n])
        late = expression_ball(lag - ell * period, known)
        own = _power(1) * _between(C, adjugate, held if late.is_zero() else states.held(T - late)) + N[n] * den
        if not late.is_zero():
            own += _between(C, adjugate, states.moved(T - late) * states.held(late))
        total += own * _power(longest - 1 - ell)
        told = [own(arb(-2))]
        least = opposite_response(states, C, T) if late.is_zero() else None
        if least is not None:  # as narrow as its numbers, but no narrower than its series
            told.append((least + N[n]) * there)
        opposite += (-1) ** (longest - 1 - ell) * narrowest(told)
    return _Moved(total, den * _power(longest), opposite)


def _leverrier(M: Any) -> tuple[Any, list[Any]]:
    """|x - M|, and the coefficients of adj(x - M), ascending in x: without differences of what is nearly equal (Leverrier)."""
    n = M.nrows()
    one = matrix([[arb(int(i == j)) for j in range(n)] for i in range(n)])
    row, N = [arb(1)], one
    found = [one] if n else []
    for k in range(1, n + 1):
        moved = N * M
        row.append(-moved.trace() / k)
        N = moved + one * row[-1]
        if k < n:
            found.append(N)
    return polynomial(row[::-1]), found[::-1]


def _between(C: Any, adjugate: list[Any], start: Any) -> Any:
    """C adj(x - M) start."""
    return polynomial([(C * N * start)[0, 0] for N in adjugate])


@lru_cache(maxsize=64)
def _turned(n: int) -> list[Any]:
    """(z - 1)^k (1 - v)^n in v, k = 0, ..., n."""
    return [
        arb_poly([0] * k + [2**k]) * arb_poly([(-1) ** i * comb(n - k, i) for i in range(n - k + 1)])
        for k in range(n + 1)
    ]


@lru_cache(maxsize=64)
def _power(k: int) -> Any:
    """z^k in z - 1."""
    return arb_poly([comb(k, i) for i in range(k + 1)])


@lru_cache(maxsize=64)
def _shifted(row: tuple[Expr, ...], size: int) -> tuple[Expr, ...]:
    """z^size times a polynomial in 1/z, in z - 1: what cancels does so exactly."""
    sums = [Integer(0)] * (size + 1)
    for k, x in enumerate(row):
        for i in range(size - k + 1):
            sums[i] += x * comb(size - k, i)
    return tuple(x.expand() for x in sums)


@lru_cache(maxsize=64)
def _at_minus_one(row: tuple[Expr, ...], size: int) -> Expr:
    """The same at z = -1."""
    return Add(*(x * (-1) ** (size - k) for k, x in enumerate(row))).expand()
