"""Numbers made of pi and of cosines and sines of parts of a turn, which are algebraic: whether one is zero is decided."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import lcm
from typing import TypeAlias

import flint
from flint import fmpq, fmpz_poly
from sympy import Expr, Integer, Symbol, pi

from haptisym.kernel.axis import Axis
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, omega
from haptisym.kernel.zeros import is_clear

_FINEST = 20_000  # parts of a turn, of which exact cosines are added up
_HALF = fmpq(1, 2)


def is_zero(polynomial: Polynomial, angles: Sequence[Expr]) -> bool | None:
    """Whether a polynomial in pi and the cosines and sines of half of some angles is the number zero: exact.

    The variables are those of a ring ``omega, pi, cos, sin, cos, sin, ...``. None where a turn would have too many parts, and
    where an angle is no part of a turn. With z a root of unity, cos = (z^k + z^-k)/2 and sin = (z^k - z^-k)/(2 i): each
    coefficient of a power of pi, which is transcendental, must be a multiple of z's cyclotomic polynomial.
    """
    if polynomial.is_zero():
        return True
    exponents = [tuple(map(int, e)) for e in polynomial.monoms()]
    used = [i for i in range(len(angles)) if any(e[2 + 2 * i] or e[3 + 2 * i] for e in exponents)]
    turns = {i: angles[i] / (4 * pi) for i in used}  # half an angle, as parts of a turn
    if not all(x.is_Rational for x in turns.values()):
        return None
    whole = lcm(4, *(int(x.q) for x in turns.values()))
    if whole > _FINEST:
        return None
    rows: dict[int, dict[int, fmpq]] = {}
    for exponent, value in zip(exponents, polynomial.coeffs(), strict=True):
        product = {0: value}
        for i in used:
            k = int(turns[i] * whole)
            product = _times(product, ((k, _HALF), (-k, _HALF)), exponent[2 + 2 * i], whole)
            quarter = whole // 4  # 1/i = -i
            product = _times(product, ((k - quarter, _HALF), (-k - quarter, -_HALF)), exponent[3 + 2 * i], whole)
        row = rows.setdefault(exponent[1], {})
        for n, x in product.items():
            row[n] = row.get(n, fmpq(0)) + x
    return all(_is_multiple(row, whole) for row in rows.values())


def _times(x: dict[int, fmpq], y: Iterable[tuple[int, fmpq]], count: int, whole: int) -> dict[int, fmpq]:
    """A sum of powers of a root of unity times another one, that many times."""
    for _ in range(count):
        found: dict[int, fmpq] = {}
        for i, a in x.items():
            for j, b in y:
                found[(i + j) % whole] = found.get((i + j) % whole, fmpq(0)) + a * b
        x = found
    return x


def _is_multiple(row: dict[int, fmpq], whole: int) -> bool:
    """Whether a sum of powers of a root of unity is zero."""
    below = lcm(*(int(x.q) for x in row.values()))
    coefficients = [0] * whole
    for n, x in row.items():
        coefficients[n] = int(x.p) * (below // int(x.q))
    return bool((fmpz_poly(coefficients) % fmpz_poly.cyclotomic(whole)) == 0)


Terms: TypeAlias = dict[tuple[int, ...], fmpq]


def vanishes(polynomial: Polynomial, axis: Axis) -> bool:
    """Whether a polynomial of an axis is zero at every frequency, as Re s^(1/2) s^(1/2) is. (False: not seen to be.)

    Equal powers of omega, and of tangents that turn, are gathered: what stands before each must be the number zero.
    """
    constant = [i for i, angle in enumerate(axis.angles) if angle.constant]
    every = [int(n) for n in polynomial.degrees()]
    if polynomial.is_zero() or not constant or any(every[2 : axis.size]) or not all(x.is_Rational for x in axis.orders):
        return bool(polynomial.is_zero())
    degrees = every[axis.size :]
    groups: dict[tuple[Expr, tuple[int, ...]], Terms] = {}
    for exponents, value in zip(polynomial.monoms(), polynomial.coeffs(), strict=True):
        power, of_pi, *own = map(int, exponents)
        own = own[axis.size - 2 :]
        raised = sum((x * n for x, n in zip(axis.orders, own[len(axis.angles) :], strict=False)), Integer(power))
        turning = tuple(n for i, n in enumerate(own[: len(axis.angles)]) if i not in constant)
        waves = [n for i in constant for n in (degrees[i] - own[i], own[i])]
        group, key = groups.setdefault((raised, turning), {}), (0, of_pi, *waves)
        group[key] = group.get(key, fmpq(0)) + value
    angles = [axis.angles[i].value for i in constant]
    ring = PolynomialRing(omega, functions=[Symbol(f"{kind}{i}") for i in constant for kind in ("cos", "sin")])
    return all(_is_nothing(ring, group, angles) for group in groups.values())


def _is_nothing(ring: PolynomialRing, terms: Terms, angles: Sequence[Expr]) -> bool:
    polynomial = ring.context.from_dict(terms)
    with flint.ctx.workprec(128):
        halves = [expression_ball(angle / 2).sin_cos() for angle in angles]
        waves = [x for sine, cosine in halves for x in (cosine, sine)]
        if is_clear(ring.ball(polynomial, dict(zip(ring.meanings[1:], (flint.arb.pi(), *waves), strict=True)))):
            return False
    return bool(is_zero(polynomial, angles))
