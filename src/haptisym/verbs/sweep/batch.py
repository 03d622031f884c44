"""Numbers of many parameter sets at once, in floats, with a proven bound on what rounding has done
to them.

The bound. Let u be the unit roundoff (2^-53 for doubles). A number is computed from floats by n
roundings along any path of sums and products. Then, unless a product underflows or anything
overflows (Higham, Accuracy and Stability of Numerical Algorithms, sections 3.1 and 3.3),

    |computed - exact| <= gamma_n * size,      gamma_n = n u / (1 - n u),

where ``size`` is the same sum with every term replaced by its absolute value: each term of the
exact sum reaches the result multiplied by at most n factors (1 + delta), |delta| <= u. The proof is
by induction over the operations: a product multiplies sizes and adds the counts of roundings, plus
one; a sum adds sizes and takes the larger count, plus one. The size itself is computed in floats,
from at most n positive terms, and is too small by at most a factor (1 - u)^n; ``error`` multiplies
by 1.001, which covers this, 1/(1 - n u) and its own three roundings for all n <= 10^9.

What is computed are coefficients that are polynomials in parameters (``Monomial``). Values of
parameters are taken as exactly the binary numbers that the floats are; the other numbers of a
formula (rational, or rational in pi) are gathered into one constant for each monomial and rounded
once.

``count_right`` counts the zeros of many real polynomials on the right of the imaginary axis by
Routh's array. Where no number in its first column is 0, no zero lies on the axis, and as many on
its right as that column changes its sign (Routh, 1877).
Every number has a radius beside it: |computed - exact| <= radius, by the rules below, in which each
rounding of a computed result x adds at most u |x|, and 1e-290 more than whatever underflows. Radii
are computed in floats themselves, from positive terms with some ten roundings each, which a factor
1 + 32 u covers. A sign counts where the number is larger than its radius.

A *set* is one value of each parameter. Begin with ``coefficients`` (a ``Batch`` of numbers with
their sizes), then ``error`` and ``count_right``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import log2
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import DTypeLike, NDArray

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import bounds

Array: TypeAlias = NDArray[Any]
"""Of floats, of either precision."""
_HAS_WIDER = np.finfo(np.longdouble).nmant in (63, 112)
FLOAT_KINDS = (np.float64, np.longdouble) if _HAS_WIDER else (np.float64,)
"""Kinds of floats, tried in this order: NumPy's longdouble where it is a wider IEEE format, and
neither a double by another name nor a pair of doubles."""
MOST_TERMS = 10**9
_SLACK = 1.001


@dataclass(frozen=True)
class Batch:
    """Coefficients in rows, sets in columns: of ascending powers where they are those of a
    polynomial.

    ``sizes``: sums of absolute values as above. ``roundings``: how many of them lie behind a
    coefficient at most.
    """

    values: Array
    sizes: Array
    roundings: int

    @property
    def degree(self) -> int:
        """That of all its polynomials."""
        return len(self.values) - 1

    def of(self, sets: Array) -> Batch:
        """The coefficients for some of the sets, which may be repeated."""
        return Batch(self.values[:, sets], self.sizes[:, sets], self.roundings)


def unit_roundoff(dtype: DTypeLike) -> float:
    """u of a float type."""
    return float(np.finfo(dtype).eps) / 2


def error(sizes: Array, roundings: int) -> Array:
    """The bound on the rounding errors of numbers of these sizes."""
    assert roundings <= MOST_TERMS
    return sizes * (_SLACK * unit_roundoff(sizes.dtype) * roundings)


def nearest(x: arb, dtype: DTypeLike) -> Any:
    """The middle of a narrow ball as a float of that type, with one rounding of that type."""
    kind: Any = np.dtype(dtype).type
    high = float(x.mid())
    if kind is np.float64:
        return kind(high)
    # A wider float is the sum of two doubles, the second being what the first leaves: the only
    # rounding is that of their sum.
    rest = float((x - arb(high)).mid())
    return kind(high) + kind(rest)


BITS = 256
# Of two. A double reaches from 2^-1022 to 2^1024: products of terms within 2^+-1000 neither
# underflow nor overflow, and 2^22 of them may still be added up.
MOST_EXPONENT = 1000


@dataclass(frozen=True)
class Monomial:
    """A monomial of a coefficient: the row of the coefficient it belongs to, a constant, and the
    exponents of the parameters.

    ``rest``: what the constant's nearest double leaves of it, for wider floats.
    """

    power: int
    constant: float
    rest: float
    exponents: tuple[int, ...]


def monomial(power: int, exponents: tuple[int, ...], ball: arb) -> Monomial:
    """One with a constant in that ball; UndecidedError where too few of its bits are known."""
    # A constant counts as one rounding of an exact number. It and its rest hold 106 bits, so that
    # what the ball leaves open must lie beyond these.
    if not ball.is_exact() and ball.rel_accuracy_bits() < 128:
        raise UndecidedError(
            f"a coefficient near {float(ball.mid())} has fewer than 128 correct bits"
        )
    # As a fraction, since the float of a ball's middle is not promised to be the nearest one.
    middle, _ = bounds(ball.mid())
    constant = float(middle)
    exact = type(middle)(constant)
    rest = float(middle - exact)
    return Monomial(power, constant, rest, exponents)


class Monomials:
    """Monomials of the parameters' values, each computed once. ``values``: parameters x sets."""

    def __init__(self, values: Array) -> None:
        self.values = values
        self.dtype = values.dtype
        self.sets = values.shape[1]
        self._known: dict[tuple[int, ...], Array] = {}

    def monomial(self, exponents: tuple[int, ...]) -> Array:
        """The product of the parameters, each to its power; one rounding less than its degree."""
        if exponents not in self._known:
            self._known[exponents] = self._monomial(exponents)
        return self._known[exponents]

    def _monomial(self, exponents: tuple[int, ...]) -> Array:
        # One factor is split off, the rest is looked up: n factors take n - 1 products, as the
        # count of roundings has it, and monomials with a common part share these.
        there = [i for i, n in enumerate(exponents) if n]
        if not there:
            return np.ones(self.sets, self.dtype)
        last = there[-1]
        column: Array = self.values[last]
        lower = list(exponents)
        lower[last] -= 1
        if not any(lower):
            return column
        return self.monomial(tuple(lower)) * column


def coefficients(terms: Sequence[Monomial], rows: int, powers: Monomials) -> Batch:
    """The sums of the monomials of each row, at each set of parameters."""
    values, sizes = np.zeros((2, rows, powers.sets), powers.dtype)
    kind = powers.dtype.type
    for term in terms:
        constant = kind(term.constant) + kind(term.rest)
        product = powers.monomial(term.exponents) * constant
        values[term.power] += product
        sizes[term.power] += np.abs(product)
    # a constant's rounding and its product; the products of a monomial; the sum
    degree = max(sum(t.exponents) for t in terms)
    return Batch(values, sizes, 2 + degree + len(terms))


def within_reach(
    values: Array, products: Iterable[Sequence[Sequence[Monomial]]], most: float = MOST_EXPONENT
) -> Array:
    """The sets for which no product of sums of monomials, one of each of those in a row, can
    underflow or overflow.

    ``most`` : the largest exponent of two of a product. With |log2| of every parameter that is not
    zero at most e, any product of terms lies within 2^+-(degree e + constants).
    """
    # In the bound of Higham a rounding is relative, which is not so where a product underflows. 0
    # is exact, whatever it is multiplied with, so that parameters of 0 are allowed.
    limit = min((_limit(sums, most) for sums in products), default=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        exponents = np.abs(np.log2(np.abs(values)))
    fits = (values == 0) | (exponents <= limit)
    within: Array = fits.all(axis=0)
    return within


def _limit(sums: Sequence[Sequence[Monomial]], most: float) -> float:
    """The largest |log2| of the parameters for which no product of terms, one of each sum, leaves
    the range of floats."""
    degree = 0
    constants = 0.0
    for terms in sums:
        degree += max(sum(t.exponents) for t in terms)
        constants += max(abs(log2(abs(t.constant))) for t in terms)
    return (most - constants) / max(degree, 1)


# Zeros in Re s > 0.

_TINY_ROUTH = 1e-290  # more than whatever underflows in one step


class Ball(NamedTuple):
    """Numbers, and how far each may be from the exact one."""

    x: Array
    r: Array


def count_right(p: Batch) -> tuple[Array, Array]:
    """For each set the number of zeros with Re s > 0, and whether it is proven; then there are none
    on the axis.

    >>> p = np.array([[2.0, 2.0, 1.0], [1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])       # s^2 + s + 2, s^2 - s + 2, s^2 + 1
    >>> [x.tolist() for x in count_right(Batch(p, abs(p), 0))]
    [[0, 2, 0], [True, True, False]]
    """
    with np.errstate(all="ignore"):  # what is not finite has no certain sign
        radius = error(p.sizes, p.roundings) + _TINY_ROUTH
        # The first two rows of Routh's array: the coefficients of every second power, from the
        # highest and from the next one down.
        highest, next_lower = p.degree, p.degree - 1
        upper = Ball(p.values[highest::-2], radius[highest::-2])
        lower = Ball(p.values[next_lower::-2], radius[next_lower::-2])
        signs = [_sign(upper)]
        for _ in range(p.degree):
            signs.append(_sign(lower))
            upper, lower = lower, _next(upper, lower)
        column = np.stack(signs)
    changes = column[1:] * column[:-1] < 0
    proven = (column != 0).all(axis=0)
    return changes.sum(axis=0), proven


def _sign(row: Ball) -> Array:
    """The sign of the first number of a row in each set; 0 where the radius leaves it open."""
    x, r = row.x[0], row.r[0]
    positive = (x > r).astype(np.int8)
    negative = (x < -r).astype(np.int8)
    signs: Array = positive - negative
    return signs


def _next(upper: Ball, lower: Ball) -> Ball:
    """The row a_(j+1) - (a_0/b_0) b_(j+1) of Routh's array that follows its rows a and b."""
    u = unit_roundoff(upper.x.dtype)
    q = upper.x[0] / lower.x[0]
    size_of_q = np.abs(q)
    # |A/B - a/b| <= (r_a + |a/b| r_b)/(|b| - r_b) for |A - a| <= r_a, |B - b| <= r_b, and u |q| for
    # the division. Where r_b >= |b| this bounds nothing; but then the sign of b, which is in the
    # first column too, counts as 0, and the set as undecided whatever comes after it.
    least_divisor = np.abs(lower.x[0]) - lower.r[0]
    of_dividend = upper.r[0] + size_of_q * lower.r[0]
    of_q = of_dividend / least_divisor + u * size_of_q
    a = Ball(upper.x[1:], upper.r[1:])
    b = _as_long(Ball(lower.x[1:], lower.r[1:]), len(upper.x) - 1)
    product = q * b.x
    x = a.x - product
    inherited = a.r + size_of_q * b.r + of_q * (np.abs(b.x) + b.r)
    r = inherited + u * (np.abs(product) + np.abs(x))
    return Ball(x, r * (1 + 32 * u) + _TINY_ROUTH)


def _as_long(row: Ball, rows: int) -> Ball:
    """A row filled up with exact zeros: those of Routh's array get shorter every second time."""
    missing = rows - len(row.x)
    if not missing:
        return row
    zeros = np.zeros((missing, row.x.shape[1]), dtype=row.x.dtype)
    return Ball(np.concatenate([row.x, zeros]), np.concatenate([row.r, zeros]))
