"""The range of a polynomial with balls for coefficients, between its least and its greatest Bernstein coefficient."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, reduce
from math import comb

import flint
from flint import arb, arb_mat, fmpq

from haptisym.kernel.reals import Ball


def range_of(row: Sequence[Ball], reach: Sequence[Ball]) -> Ball:
    """A ball around the values of c_0 + c_1 h + ... for all h from -r to r, given the powers 1, r, r^2, ... of r.

    >>> balls = [arb(c) for c in (3, 0, 1)]
    >>> range_of(balls, [arb(1), arb(2), arb(4)])     # 3 + h^2 for -2 <= h <= 2: by Bernstein not below -1
    [+/- 7.01]
    """
    return reduce(arb.union, _converted([c * power for c, power in zip(row, reach, strict=False)]).entries())


def coefficients(row: Sequence[Ball], reach: Ball) -> arb_mat:
    """The Bernstein coefficients of c_0 + c_1 h + ... between h = -r and h = r, in a column.

    >>> coefficients([arb(3), arb(0), arb(1)], arb(2)).entries()
    [7.00000000000000, -1.00000000000000, 7.00000000000000]
    """
    scaled, power = [row[0]], arb(1)
    for c in row[1:]:
        power = power * reach
        scaled.append(c * power)
    return _converted(scaled)


def _converted(row: Sequence[Ball]) -> arb_mat:
    degree = len(row) - 1
    return _conversion(degree, flint.ctx.prec) * arb_mat(degree + 1, 1, row)


@lru_cache(maxsize=64)
def _conversion(degree: int, bits: int) -> arb_mat:
    """From the coefficients of 1, u, u^2, ... to those of the Bernstein polynomials on [-1, 1]."""
    with flint.ctx.workprec(bits):
        return arb_mat([[arb(_weight(degree, j, k)) for k in range(degree + 1)] for j in range(degree + 1)])


def _weight(degree: int, j: int, k: int) -> fmpq:
    """The part of u^k = (t - (1 - t))^k (t + (1 - t))^(degree - k), t = (1 + u)/2, in the j-th Bernstein polynomial."""
    ways = sum((-1) ** (k - i) * comb(k, i) * comb(degree - k, j - i) for i in range(min(j, k) + 1))
    return fmpq(ways, comb(degree, j))
