"""How many zeros many real polynomials have on the right of the imaginary axis: Routh's array in floats, with proven signs.

Where no number in the first column of the array is 0, no zero lies on the axis, and as many on its right as that column changes
its sign (Routh, 1877). Every number has a radius beside it: |computed - exact| <= radius, by the rules below, in which each
rounding of a computed result x adds at most u |x|, u the unit roundoff, and 1e-290 more than whatever underflows. Radii are
computed in floats themselves, from positive terms with some ten roundings each, which a factor 1 + 32 u covers. A sign counts
where the number is larger than its radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from haptisym.verbs.sweep.batch import Array, Batch, error, unit_roundoff

_TINY = 1e-290


class Ball(NamedTuple):
    """Numbers, and how far each may be from the exact one."""

    x: Array
    r: Array


def count_right(p: Batch) -> tuple[Array, Array]:
    """For each set the number of zeros with Re s > 0, and whether it is proven; then there are none on the axis.

    >>> p = np.array([[2.0, 2.0, 1.0], [1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])       # s^2 + s + 2, s^2 - s + 2, s^2 + 1
    >>> [x.tolist() for x in count_right(Batch(p, abs(p), 0))]
    [[0, 2, 0], [True, True, False]]
    """
    with np.errstate(all="ignore"):  # what is not finite has no certain sign
        radius = error(p.sizes, p.roundings) + _TINY
        upper, lower = (Ball(p.values[i::-2], radius[i::-2]) for i in (p.degree, p.degree - 1))
        signs = [_sign(upper)]
        for _ in range(p.degree):
            signs.append(_sign(lower))
            upper, lower = lower, _next(upper, lower)
        column = np.stack(signs)
    return (column[1:] * column[:-1] < 0).sum(axis=0), (column != 0).all(axis=0)


def _sign(row: Ball) -> Array:
    """Of the first number of a row: 0 where it is not certain."""
    found: Array = (row.x[0] > row.r[0]).astype(np.int8) - (row.x[0] < -row.r[0]).astype(np.int8)
    return found


def _next(upper: Ball, lower: Ball) -> Ball:
    """The row a_(j+1) - (a_0/b_0) b_(j+1) that follows rows a and b."""
    u = unit_roundoff(upper.x.dtype)
    q = upper.x[0] / lower.x[0]
    of_q = (upper.r[0] + np.abs(q) * lower.r[0]) / (np.abs(lower.x[0]) - lower.r[0]) + u * np.abs(q)
    a, b = Ball(upper.x[1:], upper.r[1:]), _as_long(Ball(lower.x[1:], lower.r[1:]), len(upper.x) - 1)
    product = q * b.x
    x = a.x - product
    r = a.r + np.abs(q) * b.r + of_q * (np.abs(b.x) + b.r) + u * (np.abs(product) + np.abs(x))
    return Ball(x, r * (1 + 32 * u) + _TINY)


def _as_long(row: Ball, rows: int) -> Ball:
    more = np.zeros((rows - len(row.x), row.x.shape[1]), dtype=row.x.dtype)
    return Ball(np.concatenate([row.x, more]), np.concatenate([row.r, more])) if len(more) else row
