"""Analytic functions on segments as polynomials, with a bound on what is left out.

Let f be analytic, and |f| <= M, in the ellipse with foci at the ends of a segment whose half axes are (r + 1/r)/2 and
(r - 1/r)/2 times its half width, r > 1. Then its Chebyshev coefficients a_k are at most 2 M r^-k, and the polynomial p of
degree n through its values at the points (1 - cos(i pi/n))/2 of the segment, i = 0 ... n, has f - p = the sum over k > n of
a_k (T_k - T_m), m <= n (Trefethen, Approximation Theory and Approximation Practice, chapters 4 and 8). With |T_k| <= 1 and
|T_k'| <= k^2 on [-1, 1],

    |f - p| <= 4 M r^-n/(r - 1),      |f' - p'| <= 4 M sum over k > n of k^2 r^-k <= 4 M (n + 1)^2 r^-(n + 1)/(1 - q),

q = (1 + 1/(n + 1))^2/r, the slope being that on [-1, 1]. p's Bernstein coefficients are a fixed matrix times the values.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import comb

import flint
import numpy as np
from flint import arb, arb_mat

from haptisym.verbs.sweep.batch import Array

LEAST_RATIO = 2.0
"""Of the ellipses that are used: q < 1 for degrees from 2 on."""
_BITS = 400


@dataclass(frozen=True)
class Nodes:
    """The points of a degree as weights of a segment's two ends, and what takes values there to Bernstein coefficients.

    ``amplified``: for each coefficient, how much larger than an error of all values its own may be.
    """

    degree: int
    low: Array
    high: Array
    matrix: Array
    amplified: Array


@lru_cache(maxsize=16)
def nodes(degree: int) -> Nodes:
    """Weights and matrix correctly rounded.

    >>> nodes(2).matrix.round(12).tolist()
    [[1.0, 0.0, 0.0], [-0.5, 2.0, -0.5], [0.0, 0.0, 1.0]]
    """
    with flint.ctx.workprec(_BITS):
        high = [(1 - (arb.pi() * i / degree).cos()) / 2 for i in range(degree + 1)]
        high[0], high[-1] = arb(0), arb(1)
        low = [1 - x for x in high]
        basis = [
            [comb(degree, i) * b**i * a ** (degree - i) for i in range(degree + 1)]
            for a, b in zip(low, high, strict=True)
        ]
        inverse = arb_mat(basis).inv().tolist()
        sums = [sum((abs(x) for x in row), arb(0)) for row in inverse]
        rounded = [np.array([[float(x) for x in row] for row in rows]) for rows in ([low, high], inverse, [sums])]
    (low_row, high_row), matrix, [amplified] = rounded
    matrix[0], matrix[-1] = np.eye(degree + 1)[[0, -1]]
    return Nodes(degree, low_row, high_row, matrix, amplified * (1 + 1e-12))


@lru_cache(maxsize=16)
def halving(degree: int) -> tuple[Array, Array]:
    """What takes Bernstein coefficients on a segment to those on its first and on its second half: exact, not negative.

    >>> halving(1)[1].tolist()
    [[0.5, 0.5], [0.0, 1.0]]
    """
    first = np.array([[comb(j, i) / 2**j for i in range(degree + 1)] for j in range(degree + 1)])
    return first, first[::-1, ::-1].copy()


def left_out(bound: Array, ratio: Array, degree: int) -> tuple[Array, Array]:
    """Bounds of |f - p| and, on [-1, 1], of |f' - p'|: ``bound`` is M, ``ratio`` is r >= 2."""
    n = degree + 1
    value = 4 * bound * ratio**-degree / (ratio - 1)
    slope = 4 * bound * n**2 * ratio**-n / (1 - (1 + 1 / n) ** 2 / ratio)
    return value * _SLACK, slope * _SLACK


_SLACK = 1.001
