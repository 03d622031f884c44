"""Certified real zeros of many polynomials at once, families of them, and Routh's array.

Polynomials for many parameter sets at once, in floats, with a proven bound on what rounding has done to them.

The bound. Let u be the unit roundoff (2^-53 for doubles). A coefficient is computed from floats by n roundings along any
path of sums and products. Then, unless a product underflows or anything overflows (Higham, Accuracy and Stability of
Numerical Algorithms, sections 3.1 and 3.3),

    |computed - exact| <= gamma_n * size,      gamma_n = n u / (1 - n u),

where ``size`` is the same sum with every term replaced by its absolute value: each term of the exact sum reaches the result
multiplied by at most n factors (1 + delta), |delta| <= u. The proof is by induction over the operations: a product
multiplies sizes and adds the counts of roundings, plus one; a sum adds sizes and takes the larger count, plus one. The size
itself is computed in floats, from at most n positive terms, and is too small by at most a factor (1 - u)^n;
``error`` multiplies by 1.001, which covers this, 1/(1 - n u) and its own three roundings for all n <= 10^9.

Certified real zeros of many polynomials at once: counts that are proven, or an explicit "undecided".

On a segment [a, b] a polynomial p of degree n is written in Bernstein's basis; its coefficients c_0 ... c_n have
c_0 = p(a), c_n = p(b), and the number of zeros between a and b, with multiplicities, is the number of their sign changes or
an even number less (Descartes' rule). Hence: no sign change, no zero; one sign change, exactly one zero, a simple one.
Signs count only where the coefficient exceeds its error bound (``batch.error``); one coefficient whose sign is not known is
harmless between a positive run and a negative run, because whatever its sign, there is one change; two might make three. All else
is undecided and cut in two. An end whose own sign is not certain cannot be helped by cutting: such a set stays undecided.

c_j = sum_i p_i e_i/binomial(n, i), e_i the i-th elementary symmetric function of n - j times a and j times b. As 0 <= a, b <= 1,
all weights lie between 0 and 1, so that sizes are mapped like values; whatever underflows along the way is smaller than
``_TINY`` in total, for degrees below 200.

Families of polynomials: coefficients that are polynomials in parameters, for many values of the parameters at once.

From the exact polynomials of a ring to batches of floats with bounds (``batch``). Values of parameters are taken as exactly
the binary numbers that the floats are; the other numbers of a formula (rational, or rational in pi) are gathered into one
constant for each monomial and rounded once.

How many zeros many real polynomials have on the right of the imaginary axis: Routh's array in floats, with proven signs.

Where no number in the first column of the array is 0, no zero lies on the axis, and as many on its right as that column changes
its sign (Routh, 1877). Every number has a radius beside it: |computed - exact| <= radius, by the rules below, in which each
rounding of a computed result x adds at most u |x|, u the unit roundoff, and 1e-290 more than whatever underflows. Radii are
computed in floats themselves, from positive terms with some ten roundings each, which a factor 1 + 32 u covers. A sign counts
where the number is larger than its radius.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import pairwise
from math import comb, log2
from operator import mul
from typing import Any, NamedTuple, TypeAlias

import flint
import numpy as np
from flint import arb
from numpy.typing import DTypeLike, NDArray
from sympy import Expr, Symbol

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import bounds, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing

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


BITS = 256
_MOST_EXPONENT = 1000  # of two: products within it neither underflow nor overflow, with room for sums


@dataclass(frozen=True)
class Monomial:
    """A monomial of a coefficient: the power of the variable it belongs to, a constant, and the exponents of the parameters.

    ``rest``: what the constant's nearest double leaves of it, for wider floats.
    """

    power: int
    constant: float
    rest: float
    exponents: tuple[int, ...]


@dataclass(frozen=True)
class Family:
    """A polynomial in one variable whose coefficients are polynomials in parameters."""

    terms: tuple[Monomial, ...]

    @property
    def degree(self) -> int:
        """The highest power of any of its terms."""
        return max(term.power for term in self.terms)

    @property
    def reach(self) -> tuple[int, float]:
        """The highest total degree in the parameters, and the largest exponent of two of a constant."""
        return max(sum(t.exponents) for t in self.terms), max(abs(log2(abs(t.constant))) for t in self.terms)

    def at(self, powers: Powers) -> Batch:
        """The polynomial at each set of parameters."""
        shape = (self.degree + 1, powers.sets)
        values, sizes = np.zeros(shape, powers.dtype), np.zeros(shape, powers.dtype)
        for term in self.terms:
            monomial = powers.monomial(term.exponents)
            constant = powers.dtype.type(term.constant) + powers.dtype.type(term.rest)
            values[term.power] += monomial * constant
            sizes[term.power] += np.abs(monomial * constant)
        # a constant's rounding and its product; the products of a monomial; the sum
        return Batch(values, sizes, 2 + self.reach[0] + len(self.terms))


class Powers:
    """Monomials of the parameters' values, each computed once. ``values``: parameters x sets."""

    def __init__(self, values: Array) -> None:
        self.values, self.dtype, self.sets = values, values.dtype, values.shape[1]
        self._known: dict[tuple[int, ...], Array] = {}

    def monomial(self, exponents: tuple[int, ...]) -> Array:
        """The product of the parameters, each to its power; one rounding less than its degree."""
        if exponents not in self._known:
            self._known[exponents] = self._monomial(exponents)
        return self._known[exponents]

    def _monomial(self, exponents: tuple[int, ...]) -> Array:
        last = next((i for i, n in reversed([*enumerate(exponents)]) if n), None)
        if last is None:
            return np.ones(self.sets, self.dtype)
        lower = tuple(n - (i == last) for i, n in enumerate(exponents))
        column: Array = self.values[last]
        return self.monomial(lower) * column if any(lower) else column


def family(
    ring: PolynomialRing, polynomial: Polynomial, parameters: Sequence[Symbol], scale: Expr, step: int, factor: Expr
) -> Family:
    """``factor`` times a polynomial of a ring, as one in (omega/scale)^step, the parameters being the only symbols in it.

    ``factor`` and ``scale``: numbers.
    """
    columns = {x: i for i, x in enumerate(ring.meanings)}
    places = [columns.get(x) for x in parameters]
    with flint.ctx.workprec(BITS):
        numbers = [expression_ball(x) for x in ring.meanings[1:2]]
        unit, scaled = expression_ball(factor), expression_ball(scale)
        found: dict[tuple[int, tuple[int, ...]], arb] = {}
        for given, coefficient in polynomial.to_dict().items():
            own = [int(n) for n in given]
            assert not own[0] % step
            key = own[0] // step, tuple(own[i] if i is not None else 0 for i in places)
            term = arb(coefficient) * unit * numbers[0] ** own[1] * scaled ** own[0]
            found[key] = found.get(key, arb(0)) + term
        return Family(tuple(monomial(*key, ball) for key, ball in sorted(found.items())))


def monomial(power: int, exponents: tuple[int, ...], ball: arb) -> Monomial:
    """One with a constant in that ball; UndecidedError where too few of its bits are known."""
    if not ball.is_exact() and ball.rel_accuracy_bits() < 128:
        raise UndecidedError(f"a coefficient near {float(ball.mid())} has fewer than 128 correct bits")
    middle, _ = bounds(ball.mid())
    constant = float(middle)
    return Monomial(power, constant, float(middle - type(middle)(constant)), exponents)


def within_reach(values: Array, products: Iterable[Sequence[Family]]) -> Array:
    """The sets for which no coefficient of these products of families can underflow or overflow.

    With |log2| of every parameter that is not zero at most e, any product of terms lies within 2^+-(degree e + constants).
    """
    limit = min((_limit([f.reach for f in families]) for families in products), default=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        exponents = np.abs(np.log2(np.abs(values)))
    within: Array = ((values == 0) | (exponents <= limit)).all(axis=0)
    return within


def _limit(reaches: Sequence[tuple[int, float]]) -> float:
    degree, constants = sum(d for d, _ in reaches), sum(c for _, c in reaches)
    return (_MOST_EXPONENT - constants) / max(degree, 1)


_TINY_ROUTH = 1e-290


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
        radius = error(p.sizes, p.roundings) + _TINY_ROUTH
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
    return Ball(x, r * (1 + 32 * u) + _TINY_ROUTH)


def _as_long(row: Ball, rows: int) -> Ball:
    more = np.zeros((rows - len(row.x), row.x.shape[1]), dtype=row.x.dtype)
    return Ball(np.concatenate([row.x, more]), np.concatenate([row.r, more])) if len(more) else row
