"""The zeros of polynomials on a band for many parameter sets at once, in machine code (Numba).

**What is found.** Of each function of a sweep without waves (``curves``), a difference of products
of polynomials in x, all zeros on the band and the sign at its low end, for each set; or the set is
left open, for the slower ways of ``passes`` and ``exactanswers``.

**How.** f is expanded in powers of x, then in Bernstein's basis of the band. On a segment f has as
many zeros as its Bernstein coefficients have changes of sign, or an even number fewer (R. T.
Farouki, The Bernstein polynomial basis: a centennial retrospective, Computer Aided Geometric Design
29, 2012): none if there is no change, exactly one, a simple one, if there is one change. Elsewhere
the segment is halved by de Casteljau's algorithm. A zero that is alone is approached by Newton's
steps inside its segment, then proven: f has certain and opposite signs at x (1 - tolerance) and x
(1 + tolerance), both inside the segment.

**Errors.** Every number has its size beside it, the same sum with all terms replaced by their
absolute values; an error is at most (roundings) * (unit) * (size), as in ``batch``. Bernstein's
basis, halving and Horner's rule at x >= 0 have no negative weights, so that sizes go through the
same steps as values. A coefficient whose sign is not certain counts with whichever sign makes the
most changes. The sign at a cut must be certain. nan makes each comparison that proves something
False.

**Arithmetic.** Numbers are doubles (unit 2^-53), or *pairs* of doubles whose sum they are, kept as
complex numbers (unit 2^-103): sums and products of pairs are off by at most 3 and 5 times 2^-106 of
the result (M. Joldes, J.-M. Muller and V. Popescu, Tight and rigorous error bounds for basic
building blocks of double-word arithmetic, ACM Transactions on Mathematical Software 44, 2017,
algorithms 6 and 10; J.-M. Muller and L. Rideau, same journal, 48, 2022), if nothing underflows or
overflows on the way.

Begin with ``compiled_passes``, then ``ZeroSearch.zeros``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import comb
from typing import Any, NamedTuple, TypeVar

import numba
import numpy as np
from numba import types
from numba.extending import overload

from haptisym.verbs.sweep.batch import Array
from haptisym.verbs.sweep.curves import Curves, FamilyProduct, TwoProducts
from haptisym.verbs.sweep.delayterms import TINY, Family
from haptisym.verbs.sweep.passes import VARIABLE_TOLERANCE, Band, Pass
from haptisym.verbs.sweep.signchanges import SignChanges

PAIRS = np.complex128
"""The type of the numbers of arrays that are pairs."""
_UNITS = {np.float64: 2.0**-53, PAIRS: 2.0**-103}
_SPLITTER = 2.0**27 + 1  # of a double into two halves (Dekker)
_MOST_EXPONENT = 900
"""Of two: products of terms and weights between 2^-900 and 2^900 are split and summed without
underflow or overflow in any part."""
_SLACK = 1.001  # covers the roundings of sizes and bounds, as in ``batch``
_OF_TWO_FLOATS = 2.0**-52  # how far, relatively, two neighbouring floats are from one another
# Relative: how far inside a segment its ends are taken. An end is rounded three times, as the span
# of the band, as a part of it and as the sum with the low end, which are all positive, and twice
# more when it is moved: by 5 * 2^-53, of which this is three times as much.
_INSIDE = 2.0**-49
_MOST_CUTS, _MOST_SEGMENTS = 40, 200
_MOST_STEPS = 100  # of Newton's method or bisection
# Relative: a step so short is followed by the proof; one that short leads nowhere else.
_SHORT, _SHORTEST = 1e-7, 1e-15

_F = TypeVar("_F", bound=Callable[..., Any])
_compiled: Callable[[_F], _F] = numba.njit(cache=True, nogil=True, error_model="numpy")
_overloaded: Callable[..., Callable[[_F], _F]] = partial(overload, strict=False)


# Numbers, doubles or pairs
#
# The exact sum and product are those of ``programs.certified``, copied: Numba compiles no function
# that calls a plain one of Python, as that product does, and what it keeps on disk it compiles
# again when this file has changed, not when another one has.


def _sum(a: Any, b: Any) -> Any:
    """The sum of two numbers of one kind."""


def _times(a: Any, b: Any) -> Any:
    """The product of two numbers of one kind."""


def _half(a: Any) -> Any:
    """Half of a number, exactly."""


@_compiled
def _exact_sum(a: float, b: float) -> tuple[float, float]:
    """The rounded sum, and what it leaves (Knuth)."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@_compiled
def _exact_product(a: float, b: float) -> tuple[float, float]:
    """The rounded product, and what it leaves (Dekker)."""
    product = a * b
    far_a, far_b = _SPLITTER * a, _SPLITTER * b
    high_a, high_b = far_a - (far_a - a), far_b - (far_b - b)
    low_a, low_b = a - high_a, b - high_b
    # The order of these sums is that in which each of them is exact.
    left = high_a * high_b - product
    left += high_a * low_b
    left += low_a * high_b
    return product, left + low_a * low_b


@_compiled
def _normal(high: float, low: float) -> complex:
    """A pair from two doubles, the second of which is the smaller one."""
    total = high + low
    return complex(total, low - (total - high))


@_overloaded(_sum)
def _sum_of(a: Any, b: Any) -> Any:
    if not isinstance(a, types.Complex):
        return lambda a, b: a + b

    def of_pairs(a: complex, b: complex) -> complex:
        high, low = _exact_sum(a.real, b.real)
        of_lows, rest = _exact_sum(a.imag, b.imag)
        first = _normal(high, low + of_lows)
        return _normal(first.real, rest + first.imag)

    return of_pairs


@_overloaded(_times)
def _times_of(a: Any, b: Any) -> Any:
    if not isinstance(a, types.Complex):
        return lambda a, b: a * b

    def of_pairs(a: complex, b: complex) -> complex:
        high, low = _exact_product(a.real, b.real)
        crossed = a.real * b.imag + a.imag * b.real
        return _normal(high, low + crossed)

    return of_pairs


@_overloaded(_half)
def _half_of(a: Any) -> Any:
    if not isinstance(a, types.Complex):
        return lambda a: a * 0.5
    return lambda a: complex(a.real * 0.5, a.imag * 0.5)


# One function of one set


@_compiled
def _search(
    c: Array,
    sizes: Array,
    n: int,
    roundings: float,
    weights: Array,
    low: float,
    doubt: float,
    unit: float,
    tolerance: float,
    stack: Array,
    stacked: Array,
    places: Array,
    found: Array,
) -> tuple[int, int]:
    """The number of zeros of one function on the band, -1 for an open one, and the sign at the low
    end; the zeros are in ``found``.

    An error is a bound of the roundings and ``TINY``, which is more than what all products lose
    that underflow: coefficients do not, but high powers of a small x may.
    ``c``, ``sizes``, ``n``, ``roundings`` : its coefficients, of powers of x up to n. ``weights`` :
    those of Bernstein's basis. ``doubt`` : how far, relatively, the low end may lie below ``low``.
    ``stack``, ``stacked``, ``places`` : room for the coefficients of segments, their sizes, and
    their start, width and number of cuts, relative to the band.
    """
    for j in range(n + 1):
        total, size = weights[j, 0] * 0.0, 0.0
        for i in range(n + 1):
            total = _sum(total, _times(weights[j, i], c[i]))
            size += weights[j, i].real * sizes[i]
        stack[0, j], stacked[0, j] = total, size
    # A weight, its product, the sum.
    of_basis = roundings + n + 3
    start, width, cuts = places[0], places[1], places[2]
    start[0], width[0], cuts[0] = 0.0, 1.0, 0.0
    # A term of degree n changes by n times as much as x, relatively.
    bound = _SLACK * (unit * of_basis + doubt * n)
    at_low = stack[0, 0].real
    if not abs(at_low) > bound * stacked[0, 0] + TINY:
        return -1, 0
    first = 1 if at_low > 0 else -1
    count, level = 0, 0
    for _ in range(_MOST_SEGMENTS):
        if level < 0:
            return count, first
        b, z = stack[level], stacked[level]
        # Each halving rounds n sums, one after the other.
        bound = _SLACK * unit * (of_basis + n * cuts[level])
        most = _most_changes(b, z, n, bound)
        if most < 0:
            return -1, 0
        if most == 1:
            span = 1.0 - low
            left, right = low + span * start[level], low + span * (start[level] + width[level])
            zero = _refined(c, sizes, n, roundings, left, right, b[0].real > 0, unit, tolerance)
            if not zero > 0:
                return -1, 0
            found[count] = zero
            count += 1
        if most <= 1:
            level -= 1
            continue
        if cuts[level] == _MOST_CUTS:
            return -1, 0
        cuts[level] += 1
        width[level] *= 0.5
        cuts[level + 1], width[level + 1] = cuts[level], width[level]
        start[level + 1] = start[level]
        start[level] += width[level]
        level += 1
        _cut(b, z, n, stack[level], stacked[level])
    return -1, 0


@_compiled
def _cut(b: Array, sizes: Array, n: int, lower: Array, lower_sizes: Array) -> None:
    """Leave the coefficients on the second half of a segment, and put those on the first half in
    ``lower`` (de Casteljau)."""
    for k in range(n):
        lower[k] = b[0]
        lower_sizes[k] = sizes[0]
        # Each coefficient becomes the mean of itself and its neighbour.
        for i in range(n - k):
            both = _sum(b[i], b[i + 1])
            b[i] = _half(both)
            sizes[i] = 0.5 * (sizes[i] + sizes[i + 1])
    lower[n] = b[0]
    lower_sizes[n] = sizes[0]


@_compiled
def _most_changes(b: Array, sizes: Array, n: int, bound: float) -> int:
    """The most changes of sign that Bernstein coefficients may have, of which some signs are not
    certain; -1 where that of the first or last one is not."""
    last, open_signs, most = 0, 0, 0
    for j in range(n + 1):
        value, error = b[j].real, bound * sizes[j] + TINY
        sign = 1 if value > error else -1 if value < -error else 0
        if not sign:
            open_signs += 1
            continue
        if not last and open_signs:
            return -1
        changed = 1 if last and sign != last else 0
        # Signs in between that are not known may alternate.
        most += changed + 2 * ((open_signs + 1 - changed) // 2)
        last, open_signs = sign, 0
    return -1 if open_signs else most


@_compiled
def _refined(
    c: Array,
    sizes: Array,
    n: int,
    roundings: float,
    left: float,
    right: float,
    falls: bool,  # noqa: FBT001
    unit: float,
    tolerance: float,
) -> float:
    """A number within that relative tolerance of the one zero between two x; nan where that is not
    proven. ``falls`` : whether the function is positive on the left."""
    low, high, x, previous = left, right, 0.5 * (left + right), right - left
    # The ends were rounded.
    inside, end = left * (1 + _INSIDE), right * (1 - _INSIDE)
    for _ in range(_MOST_STEPS):
        value, slope = _at(c, n, x)
        if (value > 0) == falls:
            low = x
        else:
            high = x
        following = x - value / slope
        # Newton's step where it stays inside and is shorter by half than the one before.
        if not (low <= following <= high and abs(following - x) < 0.5 * previous):
            following = 0.5 * (low + high)
        previous = abs(following - x)
        x = following
        if previous <= _SHORT * x:
            before = _sign(c, sizes, n, roundings, max(inside, x * (1 - tolerance)), unit)
            after = _sign(c, sizes, n, roundings, min(end, x * (1 + tolerance)), unit)
            if before * after < 0:
                return x
            if previous <= _SHORTEST * x:
                break
    return np.nan


@_compiled
def _at(c: Array, n: int, x: float) -> tuple[float, float]:
    """The value and the slope at x, in doubles, by Horner's rule."""
    place = c[0] * 0.0 + x
    value, slope = c[n], 0.0
    for i in range(n - 1, -1, -1):
        slope = slope * x + value.real
        value = _sum(_times(value, place), c[i])
    return value.real, slope


@_compiled
def _sign(c: Array, sizes: Array, n: int, roundings: float, x: float, unit: float) -> int:
    """The sign at x if it is certain, else 0."""
    value, _ = _at(c, n, x)
    size = 0.0
    for i in range(n, -1, -1):
        size = size * x + sizes[i]
    # A product and a sum for each power.
    error = _SLACK * unit * (roundings + 2 * n) * size + TINY
    return 1 if value > error else -1 if value < -error else 0


# All functions of all sets


@_compiled
def _multiplied(
    a: Array, of_a: Array, n: int, b: Array, of_b: Array, m: int, room: Array, rooms: Array
) -> None:
    """Multiply a polynomial of degree n, and its sizes, by one of degree m, in place."""
    none, degree = a[0] * 0.0, n + m
    for k in range(degree + 1):
        # The coefficient of x^k is the sum of a_i b_(k - i), 0 <= i <= n and 0 <= k - i <= m.
        total, size = none, 0.0
        first = max(0, k - m)
        last = min(n, k)
        for i in range(first, last + 1):
            product = _times(a[i], b[k - i])
            total = _sum(total, product)
            size += of_a[i] * of_b[k - i]
        room[k] = total
        rooms[k] = size
    for k in range(degree + 1):
        a[k] = room[k]
        of_a[k] = rooms[k]


@_compiled
def _evaluate(
    values: Array,
    constants: Array,
    exponents: Array,
    powers: Array,
    ends: Array,
    factors: Array,
    sizes: Array,
) -> None:
    """Fill the coefficients of all factors for one set, and their sizes."""
    none, term = constants[0] * 0.0, 0
    for f in range(len(ends)):
        for i in range(factors.shape[1]):
            factors[f, i], sizes[f, i] = none, 0.0
        for j in range(term, ends[f]):
            x, power = constants[j], powers[j]
            for i in range(len(values)):
                for _ in range(exponents[j, i]):
                    x = _times(x, none + values[i])
            factors[f, power] = _sum(factors[f, power], x)
            sizes[f, power] += abs(x.real)
        term = ends[f]


class _Arrays(NamedTuple):
    """What ``_all_zeros`` reads, the same for all sets.

    ``constants``, ``exponents``, ``powers`` : of each term its constant, the exponents of the
    parameters, and the power of x. ``ends`` : of each factor the end of its terms. ``degrees`` : of
    each factor.
    ``listed`` : the factors of all products, one after the other. ``above``, ``below`` : of each
    function the ends of its two products there. ``of_functions`` : degrees. ``roundings`` : behind
    a coefficient. ``weights`` : those of Bernstein's basis, by degree.
    ``low``, ``doubt``, ``unit``, ``tolerance`` : as in ``_search``.
    """

    constants: Array
    exponents: Array
    powers: Array
    ends: Array
    degrees: Array
    listed: Array
    above: Array
    below: Array
    of_functions: Array
    roundings: Array
    weights: Array
    low: float
    doubt: float
    unit: float
    tolerance: float


@_compiled
def _all_zeros(values: Array, zeros: Array, counts: Array, first: Array, given: _Arrays) -> None:
    """Fill zeros, their counts and the signs at the low end, for each function and set."""
    ends, degrees, listed = given.ends, given.degrees, given.listed
    most, kind = given.weights.shape[0], given.constants.dtype
    factors, sizes = np.zeros((len(ends), most), kind), np.zeros((len(ends), most))
    products, product_sizes = np.zeros((3, most), kind), np.zeros((3, most))
    stack, stacked = np.zeros((_MOST_CUTS + 2, most), kind), np.zeros((_MOST_CUTS + 2, most))
    places, none = np.zeros((3, _MOST_CUTS + 2)), given.constants[0] * 0.0
    for column in range(values.shape[1]):
        _evaluate(
            values[:, column], given.constants, given.exponents, given.powers, ends, factors, sizes
        )
        place = 0
        for function in range(len(given.of_functions)):
            n = given.of_functions[function]
            for side in range(2):
                product, product_size, degree = products[side], product_sizes[side], 0
                end = given.below[function] if side else given.above[function]
                for i in range(n + 1):
                    product[i], product_size[i] = none, 0.0
                for j in range(place, end):
                    f = listed[j]
                    if j == place:
                        degree = degrees[f]
                        for i in range(degree + 1):
                            product[i], product_size[i] = factors[f, i], sizes[f, i]
                        continue
                    _multiplied(
                        product,
                        product_size,
                        degree,
                        factors[f],
                        sizes[f],
                        degrees[f],
                        products[2],
                        product_sizes[2],
                    )
                    degree += degrees[f]
                place = end
            for i in range(n + 1):
                products[0, i] = _sum(products[0, i], none - products[1, i])
                product_sizes[0, i] += product_sizes[1, i]
            counts[function, column], first[function, column] = _search(
                products[0],
                product_sizes[0],
                n,
                given.roundings[function],
                given.weights[n],
                given.low,
                given.doubt,
                given.unit,
                given.tolerance,
                stack,
                stacked,
                places,
                zeros[function, column],
            )


@dataclass(frozen=True)
class ZeroSearch:
    """The functions of a sweep as arrays for machine code, with numbers of one kind.

    ``index`` : the place of each function. ``most`` : zeros of one function at most, and one more.
    """

    index: dict[TwoProducts, int]
    most: int
    arrays: _Arrays

    @classmethod
    def of(cls, curves: Curves, ends: tuple[float, ...], kind: Any) -> ZeroSearch | None:
        """The plan for all functions of a scene on a band from its low end, of which ``ends`` are
        one float or the two about it, to 1; None where weights are too small, or there is no
        function."""
        functions = list(dict.fromkeys(curves.functions))
        if not functions:
            return None
        families = list(dict.fromkeys(f for above, below in functions for f in (*above, *below)))
        terms = [(f, term) for f in families for term in f.terms]
        of_functions = [max(map(_degree, sides)) for sides in functions]
        most = max(of_functions) + 1
        weights = np.zeros((most, most, most), kind)
        for n in set(of_functions):
            weights[n, : n + 1, : n + 1] = _weights(n, Fraction(ends[-1]), kind)
        sizes = np.abs(weights[weights != 0])
        if sizes.min() < 2.0**-_MOST_EXPONENT:
            return None
        place = {f: i for i, f in enumerate(families)}
        sides = [[place[f] for f in side] for function in functions for side in function]
        above, below = np.cumsum([len(x) for x in sides]).reshape(-1, 2).T
        return cls(
            {function: i for i, function in enumerate(functions)},
            most,
            _Arrays(
                np.array([_number(t.constant, t.rest, kind) for _, t in terms]),
                np.array([t.exponents for _, t in terms]),
                np.array([f.exponents[t.power][0] for f, t in terms]),
                np.cumsum([len(f.terms) for f in families]),
                np.array([f.degrees[0] for f in families]),
                np.array([i for side in sides for i in side]),
                above,
                below,
                np.array(of_functions),
                np.array([float(_roundings(x)) for x in functions]),
                weights,
                ends[-1],
                _OF_TWO_FLOATS if len(ends) > 1 else 0.0,
                _UNITS[kind],
                VARIABLE_TOLERANCE,
            ),
        )

    def zeros(self, values: Array) -> tuple[Array, Array, Array]:
        """For each function and set the zeros in ascending order, behind them room for more; how
        many there are, -1 where that is open; and the sign at the low end."""
        shape = len(self.index), values.shape[1]
        zeros = np.empty((*shape, self.most))
        counts, first = np.empty((2, *shape), np.int64)
        _all_zeros(values, zeros, counts, first, self.arrays)
        return zeros, counts, first


class CompiledPass(Pass):
    """A pass of which the zeros are computed in machine code."""

    most_exponent = _MOST_EXPONENT

    def __init__(self, plan: ZeroSearch, curves: Curves, band: Band, values: Array) -> None:
        super().__init__(curves, band, values)
        self.index = plan.index
        self.zeros, self.counts, self.first = plan.zeros(values)
        self.decided &= (self.counts >= 0).all(axis=0)

    def _sets_with_zero(self, f: Family) -> Array:
        sets: Array = self.counts[self.index[(f,), ()]].nonzero()[0]
        return sets

    def _sign_changes(self, above: FamilyProduct, below: FamilyProduct = ()) -> SignChanges:
        i = self.index[above, below]
        is_zero = np.arange(self.zeros.shape[2]) < self.counts[i][:, None]
        return self._changes(is_zero.nonzero()[0], self.zeros[i][is_zero], self.first[i])


def compiled_passes(curves: Curves, band: Band) -> list[Callable[[Array], CompiledPass]]:
    """The passes in machine code for a scene, in doubles, then in pairs; none where weights are too
    small."""
    plans = [ZeroSearch.of(curves, band.ends, kind) for kind in _UNITS]
    return [partial(CompiledPass, plan, curves, band) for plan in plans if plan]


def _degree(factors: FamilyProduct) -> int:
    return sum(f.degrees[0] for f in factors)


def _number(high: float, low: float, kind: Any) -> Any:
    return complex(high, low) if kind is PAIRS else high


def _weights(n: int, low: Fraction, kind: Any) -> list[list[Any]]:
    """The matrix from coefficients of powers of x to those of Bernstein's basis on [low, 1]: of x^i
    the mean, over all choices of i of n numbers, of their product, j of them being 1 and the others
    ``low``."""
    exact = [
        [
            sum(
                (comb(j, k) * comb(n - j, i - k) * low ** (i - k) for k in range(i + 1)),
                Fraction(0),
            )
            / comb(n, i)
            for i in range(n + 1)
        ]
        for j in range(n + 1)
    ]
    return [[_number(float(x), float(x - Fraction(float(x))), kind) for x in row] for row in exact]


def _roundings(function: TwoProducts) -> int:
    """How many roundings lie behind a coefficient of a function at most."""
    return max(map(_of_product, function)) + 1


def _of_product(factors: FamilyProduct) -> int:
    """The same for a product: of each factor its own, then a product and a sum of at most as many
    terms as one of both polynomials has."""
    return sum(_of_factor(f) + 1 + f.degrees[0] + 1 for f in factors)


def _of_factor(f: Family) -> int:
    # A constant's rounding and its product; the products of a monomial; the sum.
    return 2 + max(sum(t.exponents) for t in f.terms) + len(f.terms)
