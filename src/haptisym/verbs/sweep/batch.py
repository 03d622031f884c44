"""Polynomials for many parameter sets at once, in floats, with a proven bound on what rounding has done to them.

The bound. Let u be the unit roundoff (2^-53 for doubles). A coefficient is computed from floats by n roundings along any
path of sums and products. Then, unless a product underflows or anything overflows (Higham, Accuracy and Stability of
Numerical Algorithms, sections 3.1 and 3.3),

    |computed - exact| <= gamma_n * size,      gamma_n = n u / (1 - n u),

where ``size`` is the same sum with every term replaced by its absolute value: each term of the exact sum reaches the result
multiplied by at most n factors (1 + delta), |delta| <= u. The proof is by induction over the operations: a product
multiplies sizes and adds the counts of roundings, plus one; a sum adds sizes and takes the larger count, plus one. The size
itself is computed in floats, from at most n positive terms, and is too small by at most a factor (1 - u)^n;
``error`` multiplies by 1.001, which covers this, 1/(1 - n u) and its own three roundings for all n <= 10^9.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from operator import mul
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

Array: TypeAlias = NDArray[Any]
"""Of floats, of either precision."""
MOST_TERMS = 10**9
_SLACK = 1.001


@dataclass(frozen=True)
class Batch:
    """One polynomial for each set: coefficients of ascending powers in rows, sets in columns.

    ``sizes``: sums of absolute values as above. ``roundings``: how many of them lie behind a coefficient at most.
    """

    values: Array
    sizes: Array
    roundings: int

    @property
    def degree(self) -> int:
        """That of all its polynomials."""
        return len(self.values) - 1

    def of(self, sets: Array) -> Batch:
        """The polynomials of some of the sets, which may be repeated."""
        return Batch(self.values[:, sets], self.sizes[:, sets], self.roundings)

    def __mul__(self, other: Batch) -> Batch:
        terms = min(self.degree, other.degree) + 1
        return Batch(
            _product(self.values, other.values),
            _product(self.sizes, other.sizes),
            self.roundings + other.roundings + terms,
        )

    def __sub__(self, other: Batch) -> Batch:
        rows = max(self.degree, other.degree) + 1
        values = _padded(self.values, rows)
        values[: other.degree + 1] -= other.values
        sizes = _padded(self.sizes, rows)
        sizes[: other.degree + 1] += other.sizes
        return Batch(values, sizes, max(self.roundings, other.roundings) + 1)


def product(factors: Sequence[Batch]) -> Batch:
    """The product of at least one factor."""
    return reduce(mul, factors)


def _product(a: Array, b: Array) -> Array:
    short, long = (a, b) if len(a) <= len(b) else (b, a)
    result = np.zeros((len(a) + len(b) - 1, a.shape[1]), dtype=a.dtype)
    for i, row in enumerate(short):
        result[i : i + len(long)] += row * long
    return result


def _padded(rows: Array, count: int) -> Array:
    result = np.zeros((count, rows.shape[1]), dtype=rows.dtype)
    result[: len(rows)] = rows
    return result


def unit_roundoff(dtype: DTypeLike) -> float:
    """u of a float type."""
    return float(np.finfo(dtype).eps) / 2


def error(sizes: Array, roundings: int) -> Array:
    """The bound on the rounding errors of numbers of these sizes."""
    assert roundings <= MOST_TERMS
    return sizes * (_SLACK * unit_roundoff(sizes.dtype) * roundings)


def nearest(x: Fraction, dtype: DTypeLike) -> Any:
    """An exact number as a float of that type, with one rounding of that type."""
    kind: Any = np.dtype(dtype).type
    high = float(x)
    return kind(high) if kind is np.float64 else kind(high) + kind(float(x - Fraction(high)))
