"""Certified zeros of many functions of omega at once, in floats: functions made of delay terms and
of powers of omega, for all parameter sets of a sweep together.

**Problem.** On s = j omega a delay tau gives exp(-j omega tau) = cos(omega tau) - j sin(omega tau),
and a power s^alpha gives omega^alpha. A sweep asks for the zeros, on a band of frequencies, of one
function with the parameters of each of thousands of *sets*. Exact arithmetic would take too long;
floats alone prove nothing. Here floats come with bounds on all their errors: each zero gets an
interval in which it is the only one, and simple; a set for which that fails is marked as undecided.

**Variables.** x = (omega/(high end of the band))^step, 0 <= x <= 1, step 1 or 2. Of each delay,
with the half angle omega tau/2 = k x (k = tau times high end/2, its *rate*; step is then 1),
C = cos(k x) and S = sin(k x)/(k x). Of each power, z = x^alpha. A ``Family`` is a polynomial in x,
in the *waves* C and S and in z whose coefficients are polynomials in the parameters
(``sweep.batch``); a ``Function`` is a difference of products of families, at each set. All
variables lie between -1 and 1. So the *size* of a value, the sum of the absolute values of all its
terms, is bounded with 1 for each wave, and grows with x.

**Errors** are counted in units of the roundoff u of the size (N. J. Higham, Accuracy and Stability
of Numerical Algorithms, section 3.1; see ``sweep.batch``):

- x is given to within 3 u of itself, an angle k x to within n u of itself, n the roundings behind k
  plus 4; libm's part of a sine, a cosine, an exponential or a logarithm is 8 u of it. So C and S,
  each at most 1, are known to within n max(2, k x) + 12 units, as abs(t d sinc(t)/dt) <= 2, and z =
  exp(alpha log x) to within 12 alpha abs(log x) + 20. A term of degree d in them has d times that;
- a term of degree d in x has 3 d for x itself, and what its own operations make
  (``Family.roundings``).

What underflows on the way is smaller than ``TINY`` in total, as all variables are at most 1, and
coefficients do not underflow. Of libm it is assumed that for a double x the value returned is
within ``ULPS`` units in the last place of the true one, for |x| <= ``MOST_ANGLE`` (sin, cos), -40
<= x <= 1 (exp), 0 < x <= 1 (log). IEEE 754 does not say so, and no library proves it. So it is
tested where a sweep runs, once in a process, against balls: at random numbers, and at those nearest
to multiples of pi/2. If the test fails, floats are not used for scenes that need these functions.
Functions without waves and powers may be of wider floats than doubles.

**Interpolation.** Let f be analytic, and |f| <= M, in the ellipse with foci at the ends of a
segment whose half axes are (r + 1/r)/2 and (r - 1/r)/2 times its half width, r > 1 (a Bernstein
ellipse). Then its Chebyshev coefficients a_k are at most 2 M r^-k, and the polynomial p of degree n
through its values at the points (1 - cos(i pi/n))/2 of the segment, i = 0 ... n, has f - p = the
sum over k > n of a_k (T_k - T_m) with some m <= n for each k (L. N. Trefethen, Approximation Theory
and Approximation Practice, theorems 4.1, 8.1 and 8.2). With |T_k| <= 1 and |T_k'| <= k^2 on
[-1, 1],

    |f - p| <= 4 M r^-n/(r - 1),
    |f' - p'| <= 4 M sum over k > n of k^2 r^-k <= 4 M (n + 1)^2 r^-(n + 1)/(1 - q),

q = (1 + 1/(n + 1))^2/r, the slope being that on [-1, 1] (``left_out``). p's Bernstein coefficients
are a fixed matrix times the values (``nodes``).

**Zeros.** p lies between the least and the largest of its Bernstein coefficients, and p' is n times
the polynomial whose Bernstein coefficients are their differences (R. T. Farouki, The Bernstein
polynomial basis: a centennial retrospective, Computer Aided Geometric Design 29, 2012). On a
segment f has no zero if the coefficients have one sign and exceed the remainder. It has at most
one, a simple one, if their differences have one sign and exceed the slope of the remainder, for
then f is monotone; the signs at the ends tell whether there is one. All else is cut in two: p a few
times, by de Casteljau's weights, then the segment, where f is computed anew. A sign counts only
beyond all errors. No ellipse about a segment that begins at x = 0 avoids the branch point of
x^alpha there. On a first segment [0, e] powers are therefore variables of their own between 0 and
e^alpha, in which f is a polynomial: if its coefficients in both of Bernstein's bases have one sign,
f has no zero there.

**Returned**: ``isolate`` gives ``Zeros`` with a verdict for each set, ``refine`` numbers with a
verdict for each zero; each verdict True is a proof. **Failure**: nothing is raised. A set is
undecided where a zero is multiple, lies within rounding errors of another one or of an end of the
band, or where two different powers meet at x = 0; nan, from an overflow or an ellipse that is not
allowed, makes every comparison that proves something False.

Begin reading with ``isolate`` and ``refine``, then ``Function``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, reduce
from itertools import pairwise
from math import comb, pi
from operator import add, mul
from typing import Any, TypeAlias

import flint
import numpy as np
from flint import arb, arb_mat
from numpy.typing import DTypeLike

from haptisym.verbs.sweep.batch import (
    Array,
    Batch,
    Monomial,
    Monomials,
    coefficients,
    error,
    nearest,
)

# What is assumed of libm, and the test of it.

ULPS = 4.0
"""Units in the last place by which a value of libm is assumed to be off at most."""
MOST_ANGLE = 1e4
"""Radians: beyond it floats are not asked for a sine or a cosine."""
_POINTS = 600  # random numbers at which each function is tested
_LIBM_BITS = 160  # of the balls in that test, which are then exact beside a double

# Rounding errors, in units u.

TINY = 1e-280
"""Above the total of what underflows: each product that does is off by at most 2^-1022, and there
are fewer than 10^20."""
_OF_X = 3  # of a point of a segment: the weight of an end, its product, the sum of both
_OF_LIBM = 2 * ULPS  # a unit in the last place is at most 2 u of the value
# Covers the roundings of a bound that is itself computed in floats: some ten operations, and powers
# of small integer degree, are far within a thousandth.
_SLACK = 1.001

# Interpolation.

LEAST_RATIO = 2.0
"""The smallest r of ellipses that are used: with it q < 1 for all degrees n >= 2."""
# Where the search for a good r begins, and between which numbers it stays. This decides only how
# narrow bounds are.
_FIRST_RATIO, _RATIOS = 8.0, (3.0, 1000.0)
# Of the inverse in ``nodes``: far more than are lost at degree 14, where entries reach 10^4.
_NODES_BITS = 400
# Degrees of the interpolants that are tried in turn, the lowest on narrow segments alone: it
# amplifies rounding errors less. The second is for the first segment, from 0 on.
_DEGREES, _DEGREE_AT_0 = (5, 10, 14), 6
_NARROW = 2.0**-6
# How much of the size a remainder may be: else a segment is cut before anything is computed on it.
_READY, _READY_AT_0 = 1e-6, 1e-4

# The search.

# How often a segment is cut in two, and the first one shortened by a factor of 4, before a set
# counts as undecided; and how often an interpolant is halved before f is computed anew, each of
# which every coefficient is charged with (``_interpolated``).
_MOST_CUTS, _MOST_CUTS_AT_0, _MOST_HALVINGS = 40, 9, 5
# Segments that are computed at one time, which bounds the memory of the work arrays.
_AT_ONCE = 8192
# Segments of a set that may be open at one time. So many are left where the function is within its
# rounding errors on a whole stretch: cutting on would find nothing there.
_MOST_OPEN = 200

# Accuracy of zeros.

_MOST_ROUNDS = 60  # of Chandrupatla's method; bisection alone would leave 2^-60 of the bracket
# Relative to the zero: steps are no shorter than this, so that the bracket closes from both sides
# well before it is as narrow as the accuracy that is proven afterwards.
_SHORTEST_STEP = 2e-13
# Relative: how far inside a segment its ends are taken in ``refine``, more than they were rounded.
_INSIDE = 2.0**-49


# Functions


Exponents: TypeAlias = tuple[int, ...]
"""The exponents of a monomial: of x, then of C and S of each angle, then of each power z; or
without that of x."""


@dataclass(frozen=True)
class Variables:
    """The variables beside x of which a function is a polynomial. ``rates``: k of each half angle,
    a monomial in the parameters. ``orders``: alpha of each power z = x^alpha."""

    rates: tuple[Monomial, ...]
    orders: tuple[float, ...]

    @property
    def waves(self) -> int:
        """The number of variables other than x: C and S of each angle, and the powers."""
        return 2 * len(self.rates) + len(self.orders)


@dataclass(frozen=True)
class Family:
    """A polynomial in x, C, S and powers of x whose coefficients are polynomials in the parameters.

    ``exponents``: those of its monomials. ``terms``: monomials of the coefficients, in the
    parameters, each with the place in ``exponents`` of the one it belongs to (``Monomial.power``).
    """

    terms: tuple[Monomial, ...]
    variables: Variables
    exponents: tuple[Exponents, ...]

    def at(self, powers: Monomials) -> Batch:
        """The coefficients at each set of parameters, in the order of ``exponents``."""
        return coefficients(self.terms, len(self.exponents), powers)

    def polynomial(self, powers: Monomials) -> Batch:
        """The coefficients of 1, x, x^2, ..., 0 for those that do not occur; of a family without
        waves and powers."""
        occurring = self.at(powers)
        shape = 2, self.degrees[0] + 1, powers.sets
        values, sizes = np.zeros(shape, powers.dtype)
        of_x = [each[0] for each in self.exponents]
        values[of_x], sizes[of_x] = occurring.values, occurring.sizes
        return Batch(values, sizes, occurring.roundings)

    @cached_property
    def groups(self) -> dict[Exponents, list[tuple[int, int]]]:
        """For each product of waves and powers z, by its exponents, the monomials with it: pairs of
        the exponent of x, descending, and the place in ``exponents``."""
        groups: dict[Exponents, list[tuple[int, int]]] = {}
        places = range(len(self.exponents))
        for place in sorted(places, key=lambda i: -self.exponents[i][0]):
            of_x, *others = self.exponents[place]
            groups.setdefault(tuple(others), []).append((of_x, place))
        return groups

    @cached_property
    def degrees(self) -> Exponents:
        """The highest exponent of x; that of C and S together, for each angle; of each power z.

        C and S of an angle have the same error, that of the angle: only their joint degree counts.
        """
        end = 1 + 2 * len(self.variables.rates)
        joint = [self._joint_degree(i, i + 1) for i in range(1, end, 2)]
        each = [max(column) for column in zip(*self.exponents, strict=True)]
        return (each[0], *joint, *each[end:])

    def _joint_degree(self, i: int, j: int) -> int:
        """The highest sum of two exponents of a monomial."""
        return max(each[i] + each[j] for each in self.exponents)

    @property
    def roundings(self) -> int:
        """The number of roundings of a value that are not those of its coefficients: Horner's rule
        and x itself, products of waves, the sum."""
        of_waves = sum(self.degrees[1:])
        return 3 * self.degrees[0] + of_waves + len(self.groups) + 1


@dataclass(frozen=True)
class FamilyFactor:
    """A family and its coefficients for each set."""

    family: Family
    coefficients: Batch

    def of(self, sets: Array) -> FamilyFactor:
        """The same for some of the sets, which may be repeated."""
        return FamilyFactor(self.family, self.coefficients.of(sets))

    @property
    def roundings(self) -> int:
        """How many roundings a value of it suffers at most."""
        of_x = _OF_X * self.family.degrees[0]
        return self.coefficients.roundings + self.family.roundings + of_x + 1

    def at(self, points: VariablePoints, numbers: Array) -> Array:
        """The value with these numbers for coefficients, in the order of ``Family.exponents``: a
        sum over the products of waves, each times a polynomial in x."""
        total: Array | None = None
        for others, monomials in self.family.groups.items():
            term, wave = points.horner(numbers, monomials), points.product(others)
            term = term if wave is None else term * wave
            total = term if total is None else total + term
        assert total is not None
        return total


@dataclass(frozen=True)
class Function:
    """The product of the factors ``above`` minus that of those ``below``, which is 0 where there
    are none. ``rates``: k of each angle (rows) and set (columns)."""

    variables: Variables
    rates: Array
    above: tuple[FamilyFactor, ...]
    below: tuple[FamilyFactor, ...] = ()

    def __sub__(self, other: Function) -> Function:
        assert not self.below
        assert not other.below
        return replace(self, below=other.above)

    @property
    def sets(self) -> int:
        """The number of parameter sets."""
        return int(self.above[0].coefficients.values.shape[1])

    @property
    def dtype(self) -> DTypeLike:
        """The type of its floats."""
        return self.above[0].coefficients.values.dtype

    def of(self, sets: Array) -> Function:
        """The functions of some of the sets, which may be repeated."""
        above = tuple(factor.of(sets) for factor in self.above)
        below = tuple(factor.of(sets) for factor in self.below)
        return Function(self.variables, self.rates[:, sets], above, below)

    @property
    def _products(self) -> list[tuple[FamilyFactor, ...]]:
        """The one or two products of factors."""
        return [factors for factors in (self.above, self.below) if factors]

    def _degree(self, i: int) -> int:
        """The degree in x (i = 0), an angle or a power, in the order of ``Family.degrees``."""
        return max(_degree(factors, i) for factors in self._products)

    @property
    def power_degrees(self) -> list[int]:
        """The degree in each power z."""
        first = 1 + len(self.variables.rates)
        return [self._degree(first + i) for i in range(len(self.variables.orders))]

    def values(self, x: Array, powers: Array | None = None) -> Array:
        """The values at points of each set: one row for each row of x, one column for each set.

        ``powers``: values of the powers z, where these are variables of their own; they may have
        more dimensions in front, and then so do the values. None: x^alpha.
        """
        points = VariablePoints.of(self.variables, x, self.rates, powers)
        products = []
        for factors in self._products:
            values = [f.at(points, f.coefficients.values) for f in factors]
            products.append(reduce(mul, values))
        total, *subtracted = products
        for product in subtracted:
            total = total - product
        # A function without x, as a mere constant, has one row for all points.
        shape = x.shape
        if powers is not None:
            shape = np.broadcast_shapes(shape, powers.shape[1:])
        return np.broadcast_to(total, shape)

    def sizes(self, x: Array, growth: Array | None = None, powers: Array | None = None) -> Array:
        """The sums of the absolute values of all terms at one x >= 0 of each set, and so for all
        smaller ones.

        ``growth``: bounds of C and S of each angle and set, None: 1. ``powers``: as in ``values``.
        """
        bounds: list[Array] = []
        for row in np.ones_like(self.rates) if growth is None else growth:
            bounds += [row, row]
        if powers is None:
            bounds += [np.exp(alpha * np.log(x)) for alpha in self.variables.orders]
        else:
            bounds += list(powers)
        points = VariablePoints(x, bounds)
        products = []
        for factors in self._products:
            sizes = [f.at(points, f.coefficients.sizes) for f in factors]
            products.append(reduce(mul, sizes))
        return reduce(add, products)

    def error(self, sizes: Array, low: Array, high: Array, *, own_powers: bool = False) -> Array:
        """The bound on the error of values between two x, whose sizes are at most these; inf where
        an angle is larger than ``MOST_ANGLE``.

        ``own_powers``: whether powers z are variables of their own, given as floats.
        """
        roundings = [sum(f.roundings for f in factors) for factors in self._products]
        units = np.full(sizes.shape, float(max(roundings) + 1))
        # Relative to the size, in which C and S count as 1: their absolute errors matter.
        for i, (rate, term) in enumerate(zip(self.rates, self.variables.rates, strict=True)):
            angle = np.abs(rate) * high
            # The monomial of the rate and its constant; x; the product with x.
            behind_angle = 2 + sum(term.exponents) + _OF_X + 1
            of_angle = behind_angle * np.maximum(angle, 2.0)
            units += self._degree(1 + i) * (of_angle + _OF_LIBM + 4)
            # Written so that nan counts as too large.
            units[~(angle < MOST_ANGLE)] = np.inf
        for alpha, degree in zip(self.variables.orders, self.power_degrees, strict=True):
            # exp turns the absolute error of alpha log x into a relative one of the power; the
            # logarithm is largest at the low end.
            of_log: Array | float = 0.0
            if degree and not own_powers:
                of_log = (_OF_LIBM + 4) * alpha * np.abs(np.log(low))
            units += degree * (of_log + _OF_LIBM + 12)
        bound: Array = error(sizes, 1) * units + TINY
        return bound

    def left_out(
        self, low: Array, high: Array, degree: int, powers: Array | None = None
    ) -> tuple[Array, Array]:
        """Bounds on the value and on the slope (by the variable on [-1, 1]) of what interpolation
        of that degree leaves out on segments; nan where no ellipse is allowed.

        ``powers``: upper ends of the powers z, where these are variables of their own.
        """
        angle_degrees = [self._degree(1 + i) for i in range(len(self.rates))]
        # A polynomial of no higher degree is its own interpolant.
        has_waves = any(self.power_degrees) or any(angle_degrees)
        if not has_waves and self._degree(0) <= degree:
            return np.zeros_like(low), np.zeros_like(low)
        middle, half = (low + high) / 2, (high - low) / 2
        ratio = self._good_ratio(middle, half, degree)
        if powers is None and any(self.power_degrees):
            # x^alpha is analytic right of 0 alone, so that the ellipse's left end must stay there:
            # (r + 1/r)/2 < t.
            t = middle / half
            largest = t + np.sqrt((t - 1) * (t + 1))
            ratio = np.minimum(ratio, largest * (1 - 1e-9))
        # The bound needs q < 1, which a smaller r may not give: nan, which no comparison accepts,
        # has the segment cut.
        ratio = np.where(ratio >= LEAST_RATIO, ratio, np.nan)
        # M on the ellipse: |x| is largest at its right end, and |cos(k x)| and |sin(k x)/(k x)| are
        # at most exp(k |Im x|), with |Im x| at most the smaller half axis.
        right_end = (middle + half * (ratio + 1 / ratio) / 2) * _SLACK
        smaller_axis = half * (ratio - 1 / ratio) / 2 * _SLACK
        growth = np.exp(np.abs(self.rates) * smaller_axis) * _SLACK
        return left_out(self.sizes(right_end, growth, powers) * _SLACK, ratio, degree)

    def _good_ratio(self, middle: Array, half: Array, degree: int) -> Array:
        """About the r for which M r^-degree is smallest. Any r that is allowed gives a true bound:
        the choice decides only how narrow it is.

        M grows like exp(K half r/2) (middle + half r/2)^m, K the sum of all rates times degrees, m
        the degree in x. The zero of the logarithmic derivative in r, by two steps of a fixed-point
        iteration.
        """
        total_rate = np.zeros_like(middle)
        for i, rate in enumerate(self.rates):
            total_rate = total_rate + self._degree(1 + i) * np.abs(rate)
        ratio = np.full_like(middle, _FIRST_RATIO)
        for _ in range(2):
            of_power = self._degree(0) * half / (2 * middle + half * ratio)
            steepness = total_rate * half / 2 + of_power
            ratio = np.clip(degree / (steepness + 1e-9), *_RATIOS)
        return ratio


def _degree(factors: Sequence[FamilyFactor], i: int) -> int:
    """The degree of a product: the sum of those of its factors."""
    return sum(f.family.degrees[i] for f in factors)


class VariablePoints:
    """The values of all variables at points of each set.

    ``waves``: those of C, S, C, S, ..., z, ...; each product of them is computed once.
    """

    def __init__(self, x: Array, waves: Sequence[Array]) -> None:
        self._x, self._waves = x, waves
        self._powers_of_x: dict[int, Array] = {1: x}
        self._products: dict[Exponents, Array] = {}

    @classmethod
    def of(
        cls, variables: Variables, x: Array, rates: Array, powers: Array | None
    ) -> VariablePoints:
        """The variables at x, points x sets, for half angles of these rates. ``powers``: values of
        the powers z, None: x^alpha."""
        waves: list[Array] = []
        for rate in rates:
            angle = rate * x
            # sin(t)/t is 1 at t = 0, where the quotient of floats is 0/0.
            is_zero = angle == 0
            divisor = np.where(is_zero, 1.0, angle)
            sinc = np.where(is_zero, 1.0, np.sin(angle) / divisor)
            waves += [np.cos(angle), sinc]
        if powers is not None:
            waves += list(powers)
        elif variables.orders:
            log = np.log(x)
            waves += [np.exp(alpha * log) for alpha in variables.orders]
        return cls(x, waves)

    def horner(self, numbers: Array, monomials: Sequence[tuple[int, int]]) -> Array:
        """The sum of the monomials in x with these coefficients by Horner's rule. ``monomials``:
        pairs of the exponent of x, descending, and the place among the numbers."""
        (exponent, place), *others = monomials
        total: Array = numbers[place]
        for next_exponent, place in others:
            if exponent > next_exponent:
                total = total * self._power_of_x(exponent - next_exponent)
            total = total + numbers[place]
            exponent = next_exponent
        # What is left of the lowest power of x.
        return total * self._power_of_x(exponent) if exponent else total

    def _power_of_x(self, exponent: int) -> Array:
        """x to an integer power >= 1; one rounding less than it."""
        known = self._powers_of_x
        if exponent not in known:
            half = exponent // 2
            known[exponent] = self._power_of_x(exponent - half) * self._power_of_x(half)
        return known[exponent]

    def product(self, exponents: Exponents) -> Array | None:
        """The product of waves and powers z with these exponents; None if it is empty, that is, if
        it is 1."""
        if not any(exponents):
            return None
        if exponents not in self._products:
            last = max(i for i, n in enumerate(exponents) if n)
            lower = list(exponents)
            lower[last] -= 1
            others, wave = self.product(tuple(lower)), self._waves[last]
            self._products[exponents] = wave if others is None else others * wave
        return self._products[exponents]


# Isolation of zeros


@dataclass(frozen=True)
class Zeros:
    """Enclosures of the zeros of a function for many sets: each zero is simple and alone between
    ``low`` and ``high``; in ascending order within each of the ``sets``, and only of decided ones.

    ``decided``: for each set, whether these are proven to be all its zeros on the band. ``first``:
    for each set, the sign at the low end; 0 where it is not proven, and the set not decided.
    """

    sets: Array
    low: Array
    high: Array
    decided: Array
    first: Array


Segments: TypeAlias = tuple[Array, Array, Array]
"""Sets, which may be repeated, low ends, high ends: one segment of the band at each place."""


def isolate(f: Function, edges: Sequence[float], *, first_is_doubt: bool = False) -> Zeros:
    """All zeros between the first and the last edge (0 <= edges <= 1, exact), each alone where f is
    monotone.

    ``first_is_doubt``: the first segment only encloses the true low end, so that a zero on it
    leaves the set undecided.
    """
    with np.errstate(all="ignore"):  # what is not finite has no certain sign
        search = _Search(f, edges[0])
        parts = [search.segment(a, b) for a, b in pairwise(edges)]
        if first_is_doubt:
            search.run(parts.pop(0))
            sets_with_zero = np.concatenate([sets for sets, _, _ in search.with_zero])
            search.doubtful[sets_with_zero] = True
        elif edges[0] == 0 and any(f.power_degrees):
            # No ellipse about a segment that begins at 0 keeps right of 0, so that x^alpha has no
            # interpolant there.
            parts[0] = search.without_start(edges[1])
        search.run(_joined(parts))
        return search.zeros()


class _Search:
    """The search for the zeros of a function for many sets at once.

    ``doubtful``: for each set, whether the search has failed. ``first``: the sign at the low end.
    ``with_zero``: segments that are proven to hold exactly one zero. ``band_low``: the low end of
    the band.
    """

    def __init__(self, f: Function, band_low: float) -> None:
        self.f, self.band_low = f, band_low
        self.doubtful = np.zeros(f.sets, dtype=bool)
        self.first = np.zeros(f.sets, dtype=np.int8)
        none = np.zeros(f.sets, dtype=bool)
        self.with_zero: list[Segments] = [_chosen(self.segment(0, 0), none)]

    def segment(self, low: float, high: float) -> Segments:
        """The same segment for each set."""
        count = self.f.sets
        return np.arange(count), np.full(count, low), np.full(count, high)

    def run(self, waiting: Segments) -> None:
        """Cut segments until each holds one zero or none; sets where that fails are marked as
        doubtful."""
        for _ in range(_MOST_CUTS):
            open_segments = np.bincount(waiting[0], minlength=self.f.sets)
            self.doubtful |= open_segments > _MOST_OPEN
            waiting = _chosen(waiting, ~self.doubtful[waiting[0]])
            sets, low, high = waiting
            if not len(sets):
                return
            is_narrow = high - low < _NARROW
            remaining: list[Segments] = []
            for kind, degrees in ((is_narrow, _DEGREES), (~is_narrow, _DEGREES[1:])):
                batches = _batches(_chosen(waiting, kind))
                remaining += [self._searched(batch, degrees) for batch in batches]
            waiting = _joined(remaining)
        # What is still open after so many cuts holds a multiple zero, or one within rounding
        # errors.
        self.doubtful[waiting[0]] = True

    def _searched(self, segments: Segments, degrees: Sequence[int]) -> Segments:
        """Search segments on which the function is near enough to a polynomial of one of these
        degrees; returned are those, or parts of them, that must be searched again.

        A segment that is too wide for the first degree is tried with the next; for none, it is cut.
        """
        sets, low, high = segments
        if not degrees or not len(sets):
            # By equal ratios where there is a power of x: what decides whether it can be
            # interpolated on a segment is the ratio of its ends.
            return _halves(segments, by_ratio=any(self.f.power_degrees))
        degree, *others = degrees
        f = self.f.of(sets)
        remainder, sizes = f.left_out(low, high, degree), f.sizes(high)
        # Known beforehand, from sizes alone: no values are computed on a segment that would be cut
        # anyway. nan, for an ellipse that is not allowed, is not ready.
        is_ready = remainder[1] <= _READY * sizes
        too_wide = self._searched(_chosen(segments, ~is_ready), others)
        if not is_ready.all():
            f, sizes = f.of(is_ready.nonzero()[0]), sizes[is_ready]
            remainder = remainder[0][is_ready], remainder[1][is_ready]
        segments = _chosen(segments, is_ready)
        end_signs, interpolants = _interpolated(f, segments, sizes, remainder, degree)
        self._note_signs(segments, end_signs)
        return _joined([too_wide, self._judged(segments, interpolants, end_signs)])

    def _note_signs(self, segments: Segments, end_signs: Array) -> None:
        """Record the signs at the low end of the band; sets with a sign at any end that is not
        proven become doubtful.

        Zeros are counted by changes of sign between ends, so that each end needs one. A zero at an
        end, or a segment without a float inside, cannot be settled by cutting.
        """
        sets, low, high = segments
        has_no_sign = (end_signs == 0).any(axis=0)
        self.doubtful[sets[has_no_sign | ~(low < high)]] = True
        is_first = low == self.band_low
        self.first[sets[is_first]] = end_signs[0][is_first]

    def _judged(self, segments: Segments, interpolants: Interpolants, end_signs: Array) -> Segments:
        """Record the segments with exactly one zero, interpolants being halved a few times for
        that; returned are the segments on which that does not suffice."""
        for _ in range(_MOST_HALVINGS):
            none, one = interpolants.judged(end_signs)
            self.with_zero.append(_chosen(segments, one))
            is_open = ~(none | one) & ~self.doubtful[segments[0]]
            if not is_open.any():
                return _chosen(segments, is_open)
            interpolants = interpolants.of(is_open.nonzero()[0]).halves()
            segments = _halves(_chosen(segments, is_open))
            end_signs = interpolants.end_signs()
        none, one = interpolants.judged(end_signs)
        self.with_zero.append(_chosen(segments, one))
        sets, low, high = _chosen(segments, ~(none | one))
        # The ends of halves were rounded, by half an ulp each time: the next floats outside leave
        # gaps of at most 3 u between segments. No zero is in there, as a sign at an end that is
        # proven is so for all x within 3 u of it.
        low = np.maximum(np.nextafter(low, 0), self.band_low)
        high = np.minimum(np.nextafter(high, 1), 1.0)
        return sets, low, high

    def zeros(self) -> Zeros:
        """The enclosures that were found for sets without a doubt."""
        everywhere = _joined(self.with_zero)
        sets, low, high = _chosen(everywhere, ~self.doubtful[everywhere[0]])
        order = np.lexsort((low, sets))
        sets, low, high = sets[order], low[order], high[order]
        return Zeros(sets, low, high, ~self.doubtful, self.first)

    def without_start(self, end: float) -> Segments:
        """The segments between the end and a first one, from 0 on, that is shown to hold no zero.

        There powers are variables of their own. The first segment is shortened by factors of 4
        until the sign is proven on it; sets for which no length is short enough are doubtful.
        """
        sets, low, high = self.segment(0.0, end)
        # Bernstein's basis in two variables, x and one power, is what there is.
        if sum(n > 0 for n in self.f.power_degrees) > 1:
            self.doubtful[:] = True
            return sets, low, high
        none = np.zeros(self.f.sets, dtype=bool)
        rest = [_chosen((sets, low, high), none)]
        for _ in range(_MOST_CUTS_AT_0):
            sign = _sign_from_0(self.f.of(sets), high)
            self.first[sets] = sign
            sets, high = sets[sign == 0], high[sign == 0]
            if not len(sets):
                break
            rest.append((sets, high / 4, high))
            high = high / 4
        self.doubtful[sets] = True
        return _joined(rest)


def _sign_from_0(f: Function, high: Array) -> Array:
    """The sign of each function on all of [0, high] if that is proven, else 0.

    Its one power z = x^alpha is taken as a variable of its own on [0, high^alpha], in which the
    function is a polynomial: a sign on the rectangle of x and z holds on the curve within it.
    """
    low, count = np.zeros_like(high), len(high)
    i = next(i for i, n in enumerate(f.power_degrees) if n)
    of_x, of_z = nodes(_DEGREE_AT_0), nodes(f.power_degrees[i])
    powers = np.zeros((len(f.power_degrees), count))
    # Rounded up, so that the rectangle holds the curve.
    alpha = f.variables.orders[i]
    powers[i] = np.exp(alpha * np.log(high)) * _SLACK
    remainder, _ = f.left_out(low, high, _DEGREE_AT_0, powers)
    sizes = f.sizes(high, powers=powers)
    # Values at all pairs of nodes: of z in rows, of x in columns, sets behind.
    x = high * of_x.high[:, None]
    z = powers[:, None, None] * of_z.high[:, None, None]
    bernstein, roundings = _in_both(of_z, of_x, f.values(x, z))
    # In z the interpolant is exact, in x it leaves out the remainder; both matrices amplify errors.
    wrong = f.error(sizes, low, high, own_powers=True) + error(sizes, roundings)
    in_x = of_x.amplified[:, None] * wrong + remainder
    bounds = of_z.amplified[:, None, None] * in_x
    has_sign = _one_sign(bernstein.reshape(-1, count), bounds.reshape(-1, count))
    is_close = remainder < _READY_AT_0 * sizes
    signs: Array = np.where(has_sign & is_close, np.sign(bernstein[0, 0]), 0.0)
    return signs


def _in_both(of_z: Nodes, of_x: Nodes, values: Array) -> tuple[Array, int]:
    """From values at nodes of the power (first axis) and of x (second axis) to coefficients in both
    of Bernstein's bases, and how often a term is rounded.

    One variable after the other: in a sum over both at once each term would be rounded with every
    one that follows it.
    """
    in_x = np.einsum("mj,ijb->imb", of_x.matrix, values)
    # Each time the weight, the product, and with all terms but its own the sum.
    roundings = (of_x.degree + 2) + (of_z.degree + 2)
    return np.einsum("ki,imb->kmb", of_z.matrix, in_x), roundings


def _batches(segments: Segments) -> Iterator[Segments]:
    """Segments in batches of at most ``_AT_ONCE``."""
    sets, low, high = segments
    for start in range(0, len(sets), _AT_ONCE):
        batch = slice(start, start + _AT_ONCE)
        yield sets[batch], low[batch], high[batch]


def _chosen(segments: Segments, kept: Array) -> Segments:
    """The segments where ``kept`` is True."""
    sets, low, high = segments
    return sets[kept], low[kept], high[kept]


def _joined(parts: Sequence[Segments]) -> Segments:
    """All segments of these parts, in this order; at least one part."""
    sets, low, high = map(np.concatenate, zip(*parts, strict=True))
    return sets, low, high


def _halves(segments: Segments, *, by_ratio: bool = False) -> Segments:
    """The first halves of segments, then the second halves; at the geometric mean of the ends if
    ``by_ratio``, else at the middle."""
    sets, low, high = segments
    middle = np.sqrt(low * high) if by_ratio else (low + high) / 2
    lows = np.concatenate([low, middle])
    highs = np.concatenate([middle, high])
    return np.tile(sets, 2), lows, highs


# Interpolants


@dataclass(frozen=True)
class Interpolants:
    """Interpolating polynomials on segments, by their Bernstein coefficients, segments in columns.

    ``wrong``: a bound on the errors of all coefficients. ``left_out``: bounds on the difference of
    function and polynomial, and on that of their slopes by Bernstein's variable on [0, 1], the
    latter divided by the degree.
    """

    coefficients: Array
    wrong: Array
    left_out: tuple[Array, Array]

    def of(self, columns: Array) -> Interpolants:
        """Those on some of the segments."""
        value, slope = self.left_out
        left_out = value[columns], slope[columns]
        return Interpolants(self.coefficients[:, columns], self.wrong[columns], left_out)

    def end_signs(self) -> Array:
        """The proven signs of the function at both ends, in two rows; 0 where there is none."""
        return _certain(self.coefficients[[0, -1]], self.wrong + self.left_out[0])

    def judged(self, end_signs: Array) -> tuple[Array, Array]:
        """Of each segment whether it is proven to hold no zero, and whether it is proven to hold
        exactly one, given the signs at its ends."""
        value, slope = self.left_out
        # A polynomial lies in the convex hull of its Bernstein coefficients.
        has_sign = _one_sign(self.coefficients, self.wrong + value)
        # The Bernstein coefficients of p' are n times these differences, each of which has the
        # errors of two; so the slope is bounded over n.
        differences = np.diff(self.coefficients, axis=0)
        is_monotone = _one_sign(differences, (2 * self.wrong + slope) * _SLACK)
        is_monotone &= (end_signs != 0).all(axis=0)
        has_change = end_signs[0] != end_signs[1]
        return has_sign | (is_monotone & ~has_change), is_monotone & has_change

    def halves(self) -> Interpolants:
        """The polynomials on the first halves of the segments, then on the second halves, by de
        Casteljau's weights."""
        matrices = halving(len(self.coefficients) - 1)
        halves = [np.einsum("ji,ib->jb", matrix, self.coefficients) for matrix in matrices]
        # On a half the parameter runs half as fast, so that slopes by it are half as large; the
        # roundings of all halvings are in ``wrong`` from the start.
        value, slope = self.left_out
        left_out = np.tile(value, 2), np.tile(slope / 2, 2)
        return Interpolants(np.concatenate(halves, axis=1), np.tile(self.wrong, 2), left_out)


def _interpolated(
    f: Function, segments: Segments, sizes: Array, remainder: tuple[Array, Array], degree: int
) -> tuple[Array, Interpolants]:
    """The proven signs of a function at both ends of segments, in two rows, and its interpolants
    there. ``remainder``: as ``Function.left_out`` gives it."""
    _, low, high = segments
    n = nodes(degree, sizes.dtype)
    x = low * n.low[:, None] + high * n.high[:, None]
    values = f.values(x)
    wrong = f.error(sizes, low, high)
    # Not a matrix product of a linear algebra library, whose order of summation may depend on how
    # many columns there are: a set must not be answered differently beside others.
    bernstein = np.einsum("ji,ib->jb", n.matrix, values)
    # The roundings of this sum, and those of all halvings.
    of_sums = error(sizes, (degree + 3) * (1 + _MOST_HALVINGS))
    bound = n.amplified.max() * (wrong + of_sums)
    # At the low end sizes, and so errors, may be much smaller.
    wrong_at_ends = np.array([f.error(f.sizes(low), low, low), wrong])
    end_signs = _certain(values[[0, -1]], wrong_at_ends)
    # Slopes were bounded by the variable on [-1, 1]; on [0, 1], Bernstein's, they are twice that.
    value, slope = remainder
    return end_signs, Interpolants(bernstein, bound, (value, 2 * slope / degree))


def _one_sign(values: Array, bounds: Array) -> Array:
    """Whether all numbers of a column are proven to have one and the same sign, given bounds on
    their errors."""
    is_positive, is_negative = values > bounds, values < -bounds
    same: Array = np.logical_or(is_positive.all(axis=0), is_negative.all(axis=0))
    return same


def _certain(values: Array, bounds: Array) -> Array:
    """The signs of numbers, given bounds on their errors; 0 where a sign is not proven."""
    is_positive, is_negative = values > bounds, values < -bounds
    signs: Array = is_positive.astype(np.int8) - is_negative.astype(np.int8)
    return signs


def left_out(bound: Array, ratio: Array, degree: int) -> tuple[Array, Array]:
    """Bounds of |f - p| and, on [-1, 1], of |f' - p'|: ``bound`` is M, ``ratio`` is r >= 2,
    ``degree`` is n in the text at the top."""
    n = degree + 1
    value = 4 * bound * ratio**-degree / (ratio - 1)
    q = (1 + 1 / n) ** 2 / ratio
    slope = 4 * bound * n**2 * ratio**-n / (1 - q)
    return value * _SLACK, slope * _SLACK


@dataclass(frozen=True)
class Nodes:
    """The interpolation points of a degree, as weights ``low`` and ``high`` of a segment's two
    ends, and the ``matrix`` that takes values there to Bernstein coefficients.

    ``amplified``: for each coefficient, how much larger than an error of all values its own may be.
    """

    degree: int
    low: Array
    high: Array
    matrix: Array
    amplified: Array


@lru_cache(maxsize=16)
def nodes(degree: int, dtype: DTypeLike = np.float64) -> Nodes:
    """Weights and matrix correctly rounded to floats of that type.

    >>> nodes(2).matrix.round(12).tolist()
    [[1.0, 0.0, 0.0], [-0.5, 2.0, -0.5], [0.0, 0.0, 1.0]]
    """
    indices = range(degree + 1)
    # The matrix from Bernstein coefficients to values is ill-conditioned, by a factor that grows
    # exponentially with the degree: inverted in doubles it would lose digits that no bound accounts
    # for. Here it is inverted in balls and each entry rounded once.
    with flint.ctx.workprec(_NODES_BITS):
        high = [(1 - (arb.pi() * i / degree).cos()) / 2 for i in indices]
        # The ends are exactly those of the segment, so that no point lies beyond it.
        high[0], high[-1] = arb(0), arb(1)
        low = [1 - x for x in high]
        basis = [
            [comb(degree, i) * b**i * a ** (degree - i) for i in indices]
            for a, b in zip(low, high, strict=True)
        ]
        inverse = arb_mat(basis).inv().tolist()
        sums = [sum(map(abs, row), arb(0)) for row in inverse]
        low_row, high_row, amplified = (_rounded(row, dtype) for row in (low, high, sums))
        matrix = np.array([_rounded(row, dtype) for row in inverse])
    # The first and the last Bernstein coefficient are the values at the ends: exactly, not by a
    # sum.
    matrix[[0, -1]] = np.eye(degree + 1)[[0, -1]]
    # Entries were rounded, and so were their sums: far within that factor.
    return Nodes(degree, low_row, high_row, matrix, amplified * (1 + 1e-12))


def _rounded(row: Sequence[arb], dtype: DTypeLike) -> Array:
    """Numbers in narrow balls, each rounded once."""
    return np.array([nearest(x, dtype) for x in row])


@lru_cache(maxsize=16)
def halving(degree: int) -> tuple[Array, Array]:
    """The two matrices that take Bernstein coefficients on a segment to those on its first and on
    its second half (de Casteljau): exact floats, none negative, of row sum 1.

    >>> halving(1)[1].tolist()
    [[0.5, 0.5], [0.0, 1.0]]
    """
    indices = range(degree + 1)
    first = np.array([[comb(j, i) / 2**j for i in indices] for j in indices])
    return first, first[::-1, ::-1].copy()


# Accuracy of zeros


def refine(f: Function, low: Array, high: Array, tolerance: float) -> tuple[Array, Array]:
    """A number near the zero of each function between low and high, where it is monotone, and
    whether it is proven that the zero is within that relative tolerance of it.

    Proven: f has certain and opposite signs at x (1 - tolerance) and x (1 + tolerance), or at the
    segment's end if that is nearer. False: not known.
    """
    with np.errstate(all="ignore"):
        low, high = low.astype(f.dtype), high.astype(f.dtype)
        x = _approached(f, low, high)
        # A segment's end was rounded, and may lie beside the place at which its sign was proven; a
        # change of sign between points well inside is one of the segment's own zero.
        left = np.maximum(low * (1 + _INSIDE), x * (1 - tolerance))
        right = np.minimum(high * (1 - _INSIDE), x * (1 + tolerance))
        return x, _signs(f, left) * _signs(f, right) < 0


def _signs(f: Function, x: Array) -> Array:
    """The proven signs of each function at its x; 0 where there is none."""
    bounds = f.error(f.sizes(x), x, x)
    return _certain(f.values(x[None])[0], bounds)


def _approached(f: Function, low: Array, high: Array) -> Array:
    """A float near the zero of each function between low and high, of which nothing is proven yet.

    By inverse quadratic interpolation where that is safe, and bisection elsewhere (T. R.
    Chandrupatla, A new hybrid quadratic/bisection algorithm, Advances in Engineering Software 28,
    1997). The zero lies between a, the last point, and b; c is the point before them.
    """
    zeros, open_ = (low + high) / 2, np.arange(len(low))
    a, b = low.copy(), high.copy()
    at_a = f.values(a[None])[0]
    at_b = f.values(b[None])[0]
    # The next point, as a part of the way from a to b.
    part = at_a / (at_a - at_b)
    for _ in range(_MOST_ROUNDS):
        if not len(open_):
            break
        x = a + part * (b - a)
        at_x = f.values(x[None])[0]
        is_same_side = (at_x > 0) == (at_a > 0)
        c = np.where(is_same_side, a, b)
        at_c = np.where(is_same_side, at_a, at_b)
        b = np.where(is_same_side, b, a)
        at_b = np.where(is_same_side, at_b, at_a)
        a, at_a = x, at_x
        # The secant through the bracket's ends is nearer than either, where it lies between them.
        nearer = np.where(np.abs(at_a) < np.abs(at_b), a, b)
        secant = a - at_a * ((b - a) / (at_b - at_a))
        is_between = (secant - a) * (secant - b) < 0
        zeros[open_] = np.where(is_between, secant, nearer)
        shortest = _SHORTEST_STEP * np.abs(nearer) / np.abs(b - a)
        part = _part_of_way(a, b, c, at_a, at_b, at_c)
        part = np.clip(part, shortest, 1 - shortest)
        is_open = (shortest < 0.5) & (at_a != 0) & (at_b != 0)
        if not is_open.all():
            a, at_a = a[is_open], at_a[is_open]
            b, at_b = b[is_open], at_b[is_open]
            part, open_ = part[is_open], open_[is_open]
            f = f.of(is_open.nonzero()[0])
    return zeros


def _part_of_way(a: Array, b: Array, c: Array, at_a: Array, at_b: Array, at_c: Array) -> Array:
    """The part of the way from a to b that is tried next, given the values there and at c."""
    xi = (a - b) / (c - b)
    phi = (at_a - at_b) / (at_c - at_b)
    # Chandrupatla's condition: the inverse quadratic through the three points is monotonic between
    # a and b, so that its zero lies there.
    is_safe = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
    of_b = at_a / (at_b - at_a) * at_c / (at_b - at_c)
    way_to_c = (c - a) / (b - a)
    of_c = way_to_c * at_a / (at_c - at_a)
    of_c = of_c * at_b / (at_c - at_b)
    by_inverse = of_b + of_c
    # Equal values divide by 0: then too the middle is tried.
    is_usable = is_safe & np.isfinite(by_inverse)
    return np.where(is_usable, by_inverse, 0.5)


# The test of libm


@cache
def is_trusted() -> bool:
    """Whether the assumption about libm holds at all points tested, in this process."""
    return all(error <= ULPS for error in ulp_errors().values())


def ulp_errors() -> dict[str, float]:
    """The largest error found of each function, in units in the last place of the true value.

    >>> sorted(ulp_errors()), max(ulp_errors().values()) < ULPS
    (['cos', 'exp', 'log', 'sin'], True)
    """
    return {
        name: _largest_error(function, points, exact)
        for name, (function, points, exact) in _tested().items()
    }


_Function: TypeAlias = Callable[[Array], Array]
_BallFunction: TypeAlias = Callable[[Any], Any]


def _tested() -> dict[str, tuple[_Function, Array, _BallFunction]]:
    """Each function of NumPy that a family needs, the points to test it at, and its enclosure."""
    rng = np.random.default_rng(2019)
    # Evenly in the logarithm: an angle may be of any size, as a band begins near 0.
    angles = np.exp(rng.uniform(np.log(1e-9), np.log(MOST_ANGLE), _POINTS))
    # Next to multiples of pi/2 a sine or cosine is tiny, and as accurate as the reduction of its
    # argument: the place where a poor library fails.
    far = np.geomspace(200, MOST_ANGLE / (pi / 2), 200).astype(int)
    hard = np.concatenate([np.arange(1, 200), far]) * (pi / 2)
    angles = np.concatenate([angles, hard, -angles[::3]])
    small = np.exp(rng.uniform(np.log(1e-300), 0.0, _POINTS))
    # Next to 1 the logarithm vanishes, and its relative error shows.
    near_1 = 1.0 - np.exp(rng.uniform(np.log(1e-15), 0.0, _POINTS))
    exponents = np.concatenate([rng.uniform(-40.0, 1.0, _POINTS), -small])
    return {
        "sin": (np.sin, angles, arb.sin),
        "cos": (np.cos, angles, arb.cos),
        "exp": (np.exp, exponents, arb.exp),
        "log": (np.log, np.concatenate([small, near_1]), arb.log),
    }


def _largest_error(function: _Function, points: Array, exact: _BallFunction) -> float:
    """The largest error of a function at points, in units in the last place.

    It is called with the array and with single numbers, as NumPy may have other code for these.
    """
    largest = 0.0
    singles = points[::7]
    arguments = np.concatenate([points, singles])
    at_singles = np.array([function(x) for x in singles])
    values = np.concatenate([function(points), at_singles])
    with flint.ctx.workprec(_LIBM_BITS):
        for x, y in zip(arguments, values, strict=True):
            truth = exact(arb(float(x)))
            unit = arb(float(np.spacing(abs(float(truth)))))
            difference = abs(arb(float(y)) - truth) / unit
            largest = max(largest, float(difference.upper()))
    return largest
