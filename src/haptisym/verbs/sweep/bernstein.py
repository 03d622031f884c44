"""Certified real zeros of many polynomials at once: counts that are proven, or an explicit "undecided".

On a segment [a, b] a polynomial p of degree n is written in Bernstein's basis; its coefficients c_0 ... c_n have
c_0 = p(a), c_n = p(b), and the number of zeros between a and b, with multiplicities, is the number of their sign changes or
an even number less (Descartes' rule). Hence: no sign change, no zero; one sign change, exactly one zero, a simple one.
Signs count only where the coefficient exceeds its error bound (``batch.error``); one coefficient whose sign is not known is
harmless between a positive run and a negative run, because whatever its sign, there is one change; two might make three. All else
is undecided and cut in two. An end whose own sign is not certain cannot be helped by cutting: such a set stays undecided.

c_j = sum_i p_i e_i/binomial(n, i), e_i the i-th elementary symmetric function of n - j times a and j times b. As 0 <= a, b <= 1,
all weights lie between 0 and 1, so that sizes are mapped like values; whatever underflows along the way is smaller than
``_TINY`` in total, for degrees below 200.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import comb

import numpy as np
from numpy.typing import DTypeLike

from haptisym.verbs.sweep.batch import Array, Batch, error, nearest

MOST_DEGREE = 200
_MOST_CUTS = 48
_TINY = 1e-280
_ROUNDS = 5  # of Newton's method, before those that have converged are set aside
_MOST_ROUNDS = 20


@dataclass(frozen=True)
class Zeros:
    """Where the zeros lie: each simple, alone between ``low`` and ``high``, in ascending order for each ``set``.

    ``decided``: for each set, whether these are proven to be all its zeros on the band. ``first``: the sign at the low end.
    """

    sets: Array
    low: Array
    high: Array
    decided: Array
    first: Array


def isolate(p: Batch, edges: Sequence[float], *, first_is_doubt: bool = False) -> Zeros:
    """All zeros between the first and the last edge (0 <= edges <= 1, exact), which start as the ends of segments.

    ``first_is_doubt``: the first segment only encloses the true low end, so that a zero on it leaves the set undecided.

    >>> one = np.array([[6.0], [-25.0], [25.0]])     # 25 x^2 - 25 x + 6 = (5 x - 2)(5 x - 3)
    >>> isolate(Batch(one, abs(one), 0), (0.0, 0.45, 1.0)).low
    array([0.  , 0.45])
    """
    with np.errstate(all="ignore"):  # what is not finite has no certain sign
        signs = _signs_on_segments(p, tuple(edges))
        none, one = _classified(signs)
        undecided = ~(none | one)
        doubtful = np.zeros(p.values.shape[1], dtype=bool)
        if first_is_doubt:
            doubtful |= ~none[0]
            one[0] = undecided[0] = False
        first = signs[0, 0].copy()
        sets, segment = one.T.nonzero()
        ends = np.asarray(edges)
        found = [(sets, ends[segment], ends[segment + 1])]
        segment, rest = undecided.nonzero()
        found += _cut(p, (rest, ends[segment], ends[segment + 1]), doubtful, first)
    return _gathered(found, ~doubtful, first)


def _gathered(found: list[tuple[Array, Array, Array]], decided: Array, first: Array) -> Zeros:
    sets, low, high = (np.concatenate(column) for column in zip(*found, strict=True))
    kept = decided[sets]
    sets, low, high = sets[kept], low[kept], high[kept]
    if any(len(x[0]) for x in found[1:]):
        order = np.lexsort((low, sets))
        sets, low, high = sets[order], low[order], high[order]
    return Zeros(sets, low, high, decided, first)


def _signs_on_segments(p: Batch, edges: tuple[float, ...]) -> Array:
    """Signs of the Bernstein coefficients, segments x (n + 1) x sets: 0 where not certain."""
    weights = _weights(edges, p.degree, np.dtype(p.values.dtype))
    # einsum, not a library's matrix product, whose order of operations may depend on how many sets there are
    values = np.einsum("sji,ib->sjb", weights, p.values)
    # the last size of a segment is its largest, and one for all saves most of this work
    sizes = np.einsum("si,ib->sb", weights[:, -1], p.sizes)
    return _certain_signs(values, error(sizes, p.roundings + p.degree + 2)[:, None])


def _certain_signs(values: Array, bound: Array) -> Array:
    bound = bound + _TINY
    return (values > bound).view(np.int8) - (values < -bound).view(np.int8)


def _classified(signs: Array) -> tuple[Array, Array]:
    """Of signs along the last axis but one: certainly no zero, certainly one."""
    first, last = signs[..., 0, :], signs[..., -1, :]
    steps = (signs[..., :-1, :] - signs[..., 1:, :]) * first[..., None, :]
    falls = (steps >= 0).all(axis=-2)  # +...+ 0...0 -...-, or its opposite
    agreement = first * last
    sure = np.count_nonzero(signs, axis=-2) >= signs.shape[-2] - 1  # at most one of them is not known
    return falls & (agreement > 0), falls & sure & (agreement < 0)


@lru_cache(maxsize=64)
def _weights(edges: tuple[float, ...], degree: int, dtype: DTypeLike) -> Array:
    """From powers to Bernstein coefficients on each segment: segments x (n + 1) x (n + 1)."""
    exact = [Fraction(x) for x in edges]
    rows = [[_blossom(a, b, degree, j) for j in range(degree + 1)] for a, b in pairwise(exact)]
    weights = np.array([[[nearest(x, dtype) for x in row] for row in segment] for segment in rows], dtype=dtype)
    weights.setflags(write=False)
    return weights


def _blossom(a: Fraction, b: Fraction, degree: int, j: int) -> list[Fraction]:
    """The coefficients of (1 + a y)^(n - j) (1 + b y)^j, each over binomial(n, i)."""
    found = [Fraction(1)]
    for x in [a] * (degree - j) + [b] * j:
        found = [a + x * b for a, b in zip([*found, Fraction(0)], [Fraction(0), *found], strict=True)]
    return [x / comb(degree, i) for i, x in enumerate(found)]


def _cut(
    p: Batch, open_: tuple[Array, Array, Array], doubtful: Array, first: Array
) -> list[tuple[Array, Array, Array]]:
    """Cut undecided segments until each holds one zero or none; sets where that fails are marked as doubtful."""
    found: list[tuple[Array, Array, Array]] = []
    bottom = open_[1].min(initial=1.0)
    for _ in range(_MOST_CUTS):
        kept = ~doubtful[open_[0]]
        sets, low, high = (x[kept] for x in open_)
        if not len(sets):
            return found
        middle = ((np.sqrt(low) + np.sqrt(high)) / 2) ** 2  # half way in frequency, if the variable is its square
        signs = _signs_on_halves(p.of(sets), low, middle, high)
        sets, low, high = np.tile(sets, 2), np.concatenate([low, middle]), np.concatenate([middle, high])
        none, one = _classified(signs)
        lost = (signs[0] == 0) | (signs[-1] == 0) | ~(low < high)
        doubtful[sets[lost]] = True
        at_bottom = low == bottom
        first[sets[at_bottom]] = np.where(first[sets[at_bottom]], first[sets[at_bottom]], signs[0][at_bottom])
        found.append((sets[one], low[one], high[one]))
        rest = ~(none | one)
        open_ = (sets[rest], low[rest], high[rest])
    doubtful[open_[0]] = True
    return found


def _signs_on_halves(p: Batch, low: Array, middle: Array, high: Array) -> Array:
    """Signs of the Bernstein coefficients of each polynomial on a segment of its own: below its middle, then above it."""
    ends = [x.astype(p.values.dtype) for x in (low, middle, high)]
    sizes, signs = [_horner(p.sizes, x) for x in ends], []
    for (a, b), (least, most) in zip(pairwise(ends), pairwise(sizes), strict=True):
        bound = np.empty_like(p.sizes)
        bound[0] = least  # tight where p may be small, at the low end; sizes grow, and elsewhere the last one will do
        bound[1:] = most
        # at most 3 n for the shift and the power of the width together; n + 2 for the last sums, in whatever order
        signs.append(_certain_signs(_bernstein(p.values, a, b), error(bound, p.roundings + 4 * p.degree + 2)))
    return np.concatenate(signs, axis=1)


def _bernstein(coefficients: Array, low: Array, high: Array) -> Array:
    """By Horner's shift to low, scaled by the width, then the coefficients on [0, 1]."""
    q = coefficients.copy()
    degree = len(q) - 1
    for k in range(degree):
        for i in range(degree - 1, k - 1, -1):
            q[i] += low * q[i + 1]
    width, power = high - low, np.ones_like(low)
    for i in range(1, degree + 1):
        power = power * width
        q[i] *= power
    found: Array = np.einsum("ji,ib->jb", _weights((0.0, 1.0), degree, q.dtype)[0], q)
    return found


def refine(p: Batch, low: Array, high: Array, tolerance: float) -> tuple[Array, Array]:
    """The zero of each polynomial that lies alone between low and high, and whether it is proven to that accuracy.

    Proven: p has certain and opposite signs at x (1 - tolerance) and x (1 + tolerance), or at the segment's end if that is
    nearer. Newton's method, with bisection wherever it would leave the bracket.
    """
    with np.errstate(all="ignore"):
        low, high = low.astype(p.values.dtype), high.astype(p.values.dtype)
        at_low, at_high = _horner(p.values, low), _horner(p.values, high)
        start = low - at_low * ((high - low) / (at_high - at_low))
        start = np.where((start > low) & (start < high), start, (low + high) / 2)
        x = _newton(p.values, low, high, start, at_low > 0)
        below, above = np.maximum(low, x * (1 - tolerance)), np.minimum(high, x * (1 + tolerance))
        return x, _signs_at(p, below) * _signs_at(p, above) < 0


def _newton(p: Array, low: Array, high: Array, x: Array, falls: Array, rounds: int = _MOST_ROUNDS) -> Array:
    close = np.zeros(len(x), dtype=bool)
    tiny = np.sqrt(np.finfo(p.dtype).eps) / 8  # a step of Newton's method that short ends at the limit of the floats
    for _ in range(_ROUNDS):
        value, slope = _with_slope(p, x)
        left = (value > 0) == falls
        low, high = np.where(left, x, low), np.where(left, high, x)
        step = value / slope
        better = x - step
        close = np.abs(step) <= tiny * x  # then rounding may put it just outside of the bracket
        x = np.where(close | ((better > low) & (better < high)), better, (low + high) / 2)
    far = (~close).nonzero()[0]
    if len(far) and rounds:
        x[far] = _newton(p[:, far], low[far], high[far], x[far], falls[far], rounds - 1)
    return x


def _horner(p: Array, x: Array) -> Array:
    value: Array = p[-1].copy()
    for row in p[-2::-1]:
        value *= x
        value += row
    return value


def _with_slope(p: Array, x: Array) -> tuple[Array, Array]:
    value, slope = p[-1].copy(), np.zeros_like(x)
    for row in p[-2::-1]:
        slope *= x
        slope += value
        value *= x
        value += row
    return value, slope


def _signs_at(p: Batch, x: Array) -> Array:
    return _certain_signs(_horner(p.values, x), error(_horner(p.sizes, x), p.roundings + 2 * p.degree))
