"""Exact tests for zero: whether a number made of pi, cosines and sines is 0, and whether a function
of omega with powers omega^alpha is 0 at every frequency.

A delay tau gives exp(-j omega tau) on s = j omega, and a power s^alpha gives omega^alpha exp(j
alpha pi/2): real functions of omega hold cosines and sines of *delay angles* omega tau and of
*constant angles* alpha pi/2. A ring of polynomials takes all of them for independent variables.
Those of delay angles are independent of omega. Those of constant angles are numbers, and a power
omega^alpha of a rational alpha is algebraic: polynomials that are not 0 in the ring may then be 0
as functions, as Re(s^(1/2) s^(1/2)) = Re(j omega) = 0.

**Problem.** Given a polynomial with rational coefficients in pi and in cosines and sines of half
angles that are rational parts of a turn: is the number 0? No ball decides that it is.

**Theorems.** pi is transcendental (F. Lindemann, 1882), while cosines and sines of rational parts
of a turn are algebraic: the number is 0 exactly where the coefficient of each power of pi is. With
z a primitive N-th root of unity of which all half angles are multiples, z^k = exp(j k 2 pi/N),

    cos = (z^k + z^-k)/2,      sin = (z^k - z^-k)/(2 j),      1/j = -j = z^(-N/4) for N = 4, 8, ...,

so that each coefficient is a polynomial in z. The minimal polynomial of z over Q is the N-th
cyclotomic polynomial (S. Lang, Algebra, chapter VI, theorem 3.1): a polynomial in z is 0 exactly
where this one divides it.

**Returned**: True and False of ``is_zero_number`` are proofs, None is "not known"; True of
``vanishes`` is a proof, False is "not known". **Failure**: nothing is raised; what is not decided
is an angle that is no rational part of a turn, or N above ``_LARGEST_ORDER``.

Begin reading with ``is_zero_number``; ``vanishes`` asks it for the coefficients of a function.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import lcm
from typing import TypeAlias

import flint
from flint import arb, fmpq, fmpz_poly
from sympy import Expr, Integer, Symbol, pi

from haptisym.kernel.axis import Axis
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, monomials, omega
from haptisym.kernel.zeros import is_clear

# The largest N: polynomials with so many coefficients are divided, which takes some milliseconds.
_LARGEST_ORDER = 20_000
# Shows at once that most numbers are not 0.
_BITS = 128
_HALF = fmpq(1, 2)

_RootSum: TypeAlias = dict[int, fmpq]
"""A sum of powers of z: rational coefficients by exponents from 0 to N - 1, as z^N = 1."""


def is_zero_number(polynomial: Polynomial, angles: Sequence[Expr]) -> bool | None:
    """Whether a polynomial in pi and in cosines and sines of half of some angles is the number 0:
    True and False are exact.

    None: not known, as an angle that occurs is no rational part of a turn, or as N would be larger
    than ``_LARGEST_ORDER``.

    ``polynomial``: of a ring with the variables omega, pi, then cosine and sine of half of each
    angle in turn; omega does not occur in it. ``angles``: in rad.
    """
    if polynomial.is_zero():
        return True
    terms = [(list(map(int, exponents)), number) for exponents, number in monomials(polynomial)]
    assert not any(exponents[0] for exponents, _ in terms), "omega"
    # Half of each angle that occurs, in turns. Exponents 2 + 2 i and 3 + 2 i are those of the
    # cosine and the sine of angle i.
    halves: dict[int, Expr] = {}
    for i, angle in enumerate(angles):
        cosine, sine = 2 + 2 * i, 3 + 2 * i
        if any(exponents[cosine] or exponents[sine] for exponents, _ in terms):
            halves[i] = angle / (4 * pi)
    if not all(half.is_Rational for half in halves.values()):
        return None
    # N is a multiple of 4, so that 1/j is a power of z too.
    order = lcm(4, *(int(half.q) for half in halves.values()))
    if order > _LARGEST_ORDER:
        return None
    quarter = order // 4
    coefficients: dict[int, _RootSum] = {}  # of the powers of pi
    for exponents, number in terms:
        term = {0: number}
        for i, half in halves.items():
            k = int(half * order)
            cosine_in_z = (k, _HALF), (-k, _HALF)
            sine_in_z = (k - quarter, _HALF), (-k - quarter, -_HALF)
            term = _times_power(term, cosine_in_z, exponents[2 + 2 * i], order)
            term = _times_power(term, sine_in_z, exponents[3 + 2 * i], order)
        coefficient = coefficients.setdefault(exponents[1], {})
        for n, x in term.items():
            coefficient[n] = coefficient.get(n, fmpq(0)) + x
    return all(_is_zero(coefficient, order) for coefficient in coefficients.values())


def _times_power(
    x: _RootSum, factor: Iterable[tuple[int, fmpq]], count: int, order: int
) -> _RootSum:
    """A sum of powers of z times the ``count``-th power of another one, which is given in pairs of
    exponent and coefficient; ``order`` is N."""
    for _ in range(count):
        spread: _RootSum = {}
        for i, a in x.items():
            for j, b in factor:
                n = (i + j) % order
                spread[n] = spread.get(n, fmpq(0)) + a * b
        x = spread
    return x


def _is_zero(x: _RootSum, order: int) -> bool:
    """Whether a sum of powers of a primitive root of unity of that order is 0: exact."""
    # Times the common denominator it is a polynomial over the integers, whose remainder modulo a
    # polynomial with leading coefficient 1 is one too.
    denominator = lcm(*(int(a.q) for a in x.values()))
    row = [0] * order
    for n, a in x.items():
        row[n] = int(a.p) * (denominator // int(a.q))
    return bool((fmpz_poly(row) % fmpz_poly.cyclotomic(order)) == 0)


_Terms: TypeAlias = dict[tuple[int, ...], fmpq]
"""A polynomial: coefficients by the exponents of all variables."""


def vanishes(polynomial: Polynomial, axis: Axis) -> bool:
    """True: a polynomial of an axis is proven to be 0 at every frequency, as that of Re(s^(1/2)
    s^(1/2)) is. False: nothing is known.

    Only polynomials without parameters, with rational orders alpha, are tested beyond being the
    zero polynomial. Terms with equal powers of omega, omega^alpha counted in, and equal powers of
    the tangents of delay angles are gathered: where the number before each such group is 0, so is
    the function.
    """
    if polynomial.is_zero():
        return True
    constant_angles = [i for i, angle in enumerate(axis.angles) if angle.constant]
    degrees = [int(n) for n in polynomial.degrees()]
    has_parameters = any(degrees[2 : axis.size])
    has_rational_orders = all(order.is_Rational for order in axis.orders)
    if not constant_angles or has_parameters or not has_rational_orders:
        return False
    # Exponents of a term: omega, pi, parameters, then tangents of all angles, then omega^alpha.
    first_power = axis.size + len(axis.angles)
    degrees_in_tangents = degrees[axis.size : first_power]
    groups: dict[tuple[Expr, tuple[int, ...]], _Terms] = {}
    for exponents, number in monomials(polynomial):
        each = list(map(int, exponents))
        tangents = each[axis.size : first_power]
        of_omega = Integer(each[0])
        for order, n in zip(axis.orders, each[first_power:], strict=True):
            of_omega += order * n
        of_delays = tuple(n for i, n in enumerate(tangents) if i not in constant_angles)
        # tan^k = sin^k cos^(degree - k)/cos^degree, and cos^degree is common to all terms. It is
        # not 0: alpha pi/4 is an odd multiple of pi/2 for even integers alpha alone.
        waves: list[int] = []
        for i in constant_angles:
            waves += [degrees_in_tangents[i] - tangents[i], tangents[i]]
        group = groups.setdefault((of_omega, of_delays), {})
        key = 0, each[1], *waves
        group[key] = group.get(key, fmpq(0)) + number
    names = [Symbol(f"{kind}{i}") for i in constant_angles for kind in ("cos", "sin")]
    ring = PolynomialRing(omega, functions=names)
    angles = [axis.angles[i].value for i in constant_angles]
    numbers = map(ring.context.from_dict, groups.values())
    return all(_is_shown_zero(ring, number, angles) for number in numbers)


def _is_shown_zero(ring: PolynomialRing, polynomial: Polynomial, angles: Sequence[Expr]) -> bool:
    """True: a polynomial as in ``is_zero_number`` is proven to be the number 0. False: nothing is
    known."""
    # Balls first: most numbers are not 0, which they show at once.
    with flint.ctx.workprec(_BITS):
        waves: list[Ball] = []
        for angle in angles:
            sine, cosine = expression_ball(angle / 2).sin_cos()
            waves += [cosine, sine]
        numbers = arb.pi(), *waves
        values = dict(zip(ring.meanings[1:], numbers, strict=True))
        if is_clear(ring.ball(polynomial, values)):
            return False
    return bool(is_zero_number(polynomial, angles))
