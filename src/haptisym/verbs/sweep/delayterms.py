"""Certified zeros of many functions of omega at once, made of powers, sines and cosines: counts
that are proven, or "undecided".

**Families.** On x = (omega/(high end of the band))^step, 0 <= x <= 1, a function is a polynomial in
x, in C = cos(k x) and S = sin(k x)/(k x) of some half angles k x (k = rate of the angle times high
end/2) and in z = x^alpha, whose coefficients are polynomials in the parameters (``batch``). All of
these lie between -1 and 1, so that sizes are had with 1 for each wave, and grow with x.

**Errors** are counted in units of the roundoff u of the size, the sum of the absolute values of all
terms:

- x is given to within 3 u of itself, an angle k x to within n u of itself, n the roundings behind k
  plus 4; libm's part of a sine, a cosine, an exponential or a logarithm is 8 u of it. So C and S,
  each at most 1, are known to within n max(2, k x) + 12 units, as abs(x d sinc(x)/dx) <= 2, and z =
  exp(alpha log x) to within 12 alpha abs(log x) + 20. A term of degree d in them has d times that;
- a term of degree d in x has 3 d for x itself, and what its own operations make
  (``Family.roundings``).

What underflows on the way is smaller than ``TINY`` in total, as all variables are at most 1, and
coefficients do not underflow. Of libm it is assumed that for a double x the value returned is
within ``ULPS`` units in the last place of the true one, for |x| <= ``MOST_ANGLE`` (sin, cos), -40
<= x <= 1 (exp), 0 < x <= 1 (log). IEEE 754 does not say so, and no library proves it. So it is
tested where a sweep runs, once in a process, against balls: at random numbers, and at those nearest
to multiples of pi/2. If the test fails, floats are not used for scenes that need these functions.
Functions without waves may be of wider floats than doubles.

**Interpolation.** Let f be analytic, and |f| <= M, in the ellipse with foci at the ends of a
segment whose half axes are (r + 1/r)/2 and (r - 1/r)/2 times its half width, r > 1. Then its
Chebyshev coefficients a_k are at most 2 M r^-k, and the polynomial p of degree n through its values
at the points (1 - cos(i pi/n))/2 of the segment, i = 0 ... n, has f - p = the sum over k > n of a_k
(T_k - T_m), m <= n (Trefethen, Approximation Theory and Approximation Practice, chapters 4 and 8).
With
|T_k| <= 1 and |T_k'| <= k^2 on [-1, 1],

    |f - p| <= 4 M r^-n/(r - 1),
    |f' - p'| <= 4 M sum over k > n of k^2 r^-k <= 4 M (n + 1)^2 r^-(n + 1)/(1 - q),

q = (1 + 1/(n + 1))^2/r, the slope being that on [-1, 1]. p's Bernstein coefficients are a fixed
matrix times the values.

**Zeros.** On a segment there is no zero if p's Bernstein coefficients have one sign and exceed the
remainder. There is at most one, a simple one, if their differences have one sign and exceed the
slope of the remainder, for then f is monotone; the signs at the ends tell whether there is one. All
else is cut in two: p a few times, by de Casteljau's weights, then the segment, where f is computed
anew. A sign counts only beyond all errors. Powers x^alpha are not what polynomials come near to at
x = 0.
On a first segment [0, e] they are therefore variables of their own between 0 and e^alpha, in which
f is a polynomial: if its coefficients in both of Bernstein's bases have one sign, f has no zero
there. Each zero is then found to a proven accuracy (``refine``).
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

Exponents: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class Variables:
    """The variables beside x of which a function is a polynomial. ``rates``: k of each half angle,
    a monomial in the parameters. ``orders``: alpha of each power of x."""

    rates: tuple[Monomial, ...]
    orders: tuple[float, ...]

    @property
    def waves(self) -> int:
        """The number of variables other than x: C and S of each angle, and the powers."""
        return 2 * len(self.rates) + len(self.orders)


@dataclass(frozen=True)
class Family:
    """A polynomial in x, C, S and powers of x whose coefficients are polynomials in the parameters.

    ``terms``: coefficients of the monomials listed in ``rows``, by their place there. ``rows``:
    exponents of x, then of C and S of each angle, then of the powers.
    """

    terms: tuple[Monomial, ...]
    variables: Variables
    rows: tuple[Exponents, ...]

    def at(self, powers: Monomials) -> Batch:
        """The coefficients at each set of parameters."""
        return coefficients(self.terms, len(self.rows), powers)

    def polynomial(self, powers: Monomials) -> Batch:
        """The coefficients of all powers of x, 0 for those that do not occur; of a family without
        waves."""
        occurring = self.at(powers)
        values, sizes = np.zeros((2, self.degrees[0] + 1, powers.sets), powers.dtype)
        places = [row[0] for row in self.rows]
        values[places], sizes[places] = occurring.values, occurring.sizes
        return Batch(values, sizes, occurring.roundings)

    @cached_property
    def groups(self) -> dict[Exponents, list[tuple[int, int]]]:
        """For each product of waves the powers of x that stand with it, descending, and their
        rows."""
        groups: dict[Exponents, list[tuple[int, int]]] = {}
        for row in sorted(range(len(self.rows)), key=lambda i: -self.rows[i][0]):
            power, *waves = self.rows[row]
            groups.setdefault(tuple(waves), []).append((power, row))
        return groups

    @cached_property
    def degrees(self) -> Exponents:
        """The highest exponent of x; of C and S of an angle together; of each power."""
        angles = len(self.variables.rates)
        each = [max(column) for column in zip(*self.rows, strict=True)]
        # C and S of an angle have the same error, that of the angle, so that only their joint
        # degree counts.
        pairs = [max(row[1 + 2 * i] + row[2 + 2 * i] for row in self.rows) for i in range(angles)]
        return (each[0], *pairs, *each[1 + 2 * angles :])

    @property
    def roundings(self) -> int:
        """The number of roundings of a value that are not those of the coefficients: Horner's rule,
        products of waves, the sum."""
        return 3 * self.degrees[0] + sum(self.degrees[1:]) + len(self.groups) + 1


LEAST_RATIO = 2.0
"""Of the ellipses that are used: q < 1 for degrees from 2 on."""
_BITS = 400


@dataclass(frozen=True)
class Nodes:
    """The interpolation points of a degree, as weights of a segment's two ends, and the matrix that
    takes values there to Bernstein coefficients.

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
    # The matrix from Bernstein coefficients to values is ill-conditioned, by a factor that grows
    # exponentially with the degree: inverted in doubles it would lose digits that no bound accounts
    # for. Here it is inverted in balls and each entry rounded once.
    with flint.ctx.workprec(_BITS):
        high = [(1 - (arb.pi() * i / degree).cos()) / 2 for i in range(degree + 1)]
        # The ends are exactly those of the segment, so that no point lies beyond it.
        high[0], high[-1] = arb(0), arb(1)
        low = [1 - x for x in high]
        basis = [
            [comb(degree, i) * b**i * a ** (degree - i) for i in range(degree + 1)]
            for a, b in zip(low, high, strict=True)
        ]
        inverse = arb_mat(basis).inv().tolist()
        sums = [sum((abs(x) for x in row), arb(0)) for row in inverse]
        rounded = [
            np.array([[nearest(x, dtype) for x in row] for row in rows])
            for rows in ([low, high], inverse, [sums])
        ]
    (low_row, high_row), matrix, [amplified] = rounded
    # The first and the last Bernstein coefficient are the values at the ends: exactly, not by a
    # sum.
    matrix[0], matrix[-1] = np.eye(degree + 1)[[0, -1]]
    return Nodes(degree, low_row, high_row, matrix, amplified * (1 + 1e-12))


@lru_cache(maxsize=16)
def halving(degree: int) -> tuple[Array, Array]:
    """The two matrices that take Bernstein coefficients on a segment to those on its first and on
    its second half (de Casteljau): exact floats, none negative, of row sum 1.

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


# Covers the roundings of a bound that is itself computed in floats: some ten operations, and powers
# of small whole degree, are far within a thousandth.
_SLACK = 1.001


ULPS = 4.0
MOST_ANGLE = 1e4
"""Radians: beyond it floats are not asked for a sine or a cosine."""
_POINTS = 600
_BITS_LIBM = 160


def ulp_errors() -> dict[str, float]:
    """The largest error found of each function, in units in the last place of the true value.

    >>> sorted(ulp_errors()), max(ulp_errors().values()) < ULPS
    (['cos', 'exp', 'log', 'sin'], True)
    """
    return {
        name: _worst(function, points, exact)
        for name, (function, points, exact) in _tested().items()
    }


@cache
def is_trusted() -> bool:
    """Whether the assumption holds at all points tested, in this process."""
    return all(error <= ULPS for error in ulp_errors().values())


def _tested() -> dict[str, tuple[Callable[[Array], Array], Array, Callable[[Any], Any]]]:
    """Each function of NumPy that a family needs, the points to test it at, and its enclosure."""
    rng = np.random.default_rng(2019)
    # Evenly in the logarithm: an angle may be of any size, as a band begins near 0.
    angles = np.exp(rng.uniform(np.log(1e-9), np.log(MOST_ANGLE), _POINTS))
    # Next to multiples of pi/2 a sine or cosine is tiny, and as accurate as the reduction of its
    # argument: the place where a poor library fails.
    hard = np.arange(1, 200) * (pi / 2)
    angles = np.concatenate([angles, hard, -angles[::3]])
    small = np.exp(rng.uniform(np.log(1e-16), 0.0, _POINTS))
    # Next to 1 the logarithm vanishes, and its relative error shows.
    near = 1.0 - np.exp(rng.uniform(np.log(1e-15), 0.0, _POINTS))
    return {
        "sin": (np.sin, angles, arb.sin),
        "cos": (np.cos, angles, arb.cos),
        "exp": (np.exp, np.concatenate([rng.uniform(-40.0, 1.0, _POINTS), -small]), arb.exp),
        "log": (np.log, np.concatenate([small, near]), arb.log),
    }


def _worst(function: Callable[[Array], Array], points: Array, exact: Callable[[Any], Any]) -> float:
    """The largest error of a function at points, in units in the last place.

    It is called with the array and with single numbers, as NumPy may have other code for these.
    """
    worst = 0.0
    singles = np.array([function(x) for x in points[::7]])
    with flint.ctx.workprec(_BITS_LIBM):
        for x, y in [
            *zip(points, function(points), strict=True),
            *zip(points[::7], singles, strict=True),
        ]:
            truth = exact(arb(float(x)))
            apart = abs(arb(float(y)) - truth) / arb(float(np.spacing(abs(float(truth)))))
            worst = max(worst, float(apart.upper()))
    return worst


TINY = 1e-280
# In units u: a point of a segment is rounded three times (the weight of an end, its product, the
# sum of both). A unit in the last place is at most 2 u of the value.
_OF_X, _OF_LIBM = 3, 2 * ULPS
_FIRST_RATIO, _RATIOS = 8.0, (3.0, 1000.0)


@dataclass(frozen=True)
class FamilyFactor:
    """A family and its coefficients for each set."""

    family: Family
    rows: Batch

    def of(self, sets: Array) -> FamilyFactor:
        """For some of the sets."""
        return FamilyFactor(self.family, self.rows.of(sets))

    @property
    def roundings(self) -> int:
        """How many roundings a value of it suffers at most."""
        return self.rows.roundings + self.family.roundings + _OF_X * self.family.degrees[0] + 1

    def at(self, points: VariablePoints, rows: Array) -> Array:
        """The value with these coefficients: a sum over the products of waves, each times a
        polynomial in x."""
        total: Array | None = None
        for waves, powers in self.family.groups.items():
            term, wave = points.horner(rows, powers), points.product(waves)
            term = term if wave is None else term * wave
            total = term if total is None else total + term
        assert total is not None
        return total


@dataclass(frozen=True)
class Function:
    """The product of the factors ``above`` minus that of those ``below`` (none: 0); ``rates``: k of
    each angle and set."""

    variables: Variables
    rates: Array
    above: tuple[FamilyFactor, ...]
    below: tuple[FamilyFactor, ...] = ()

    def __sub__(self, other: Function) -> Function:
        return replace(self, below=other.above)

    @property
    def sets(self) -> int:
        """The number of parameter sets."""
        return int(self.above[0].rows.values.shape[1])

    def of(self, sets: Array) -> Function:
        """The functions of some of the sets, which may be repeated."""
        above, below = (tuple(f.of(sets) for f in side) for side in (self.above, self.below))
        return Function(self.variables, self.rates[:, sets], above, below)

    def _degree(self, i: int) -> int:
        """The degree in x (0), in an angle or in a power, in the order of ``Family.degrees``; a
        product has the sum of those of its factors."""
        return max(sum(f.family.degrees[i] for f in side) for side in (self.above, self.below))

    @property
    def _sides(self) -> list[tuple[FamilyFactor, ...]]:
        return [side for side in (self.above, self.below) if side]

    @property
    def power_degrees(self) -> list[int]:
        """The degrees of the powers of x that are not whole."""
        first = 1 + len(self.variables.rates)
        return [self._degree(first + i) for i in range(len(self.variables.orders))]

    def values(self, x: Array, powers: Array | None = None) -> Array:
        """The values at points of each set, points x sets.

        ``powers``: values of the powers of x, where these are to be variables of their own; they
        may have more dimensions in front, and then so do the values.
        """
        points = VariablePoints.of(self.variables, x, self.rates, powers)
        sides = []
        for side in self._sides:
            factors = [f.at(points, f.rows.values) for f in side]
            sides.append(reduce(mul, factors))
        total = sides[0] - sides[1] if len(sides) > 1 else sides[0]
        # a function without x, as a mere constant, has one row for all points
        shape = x.shape if powers is None else np.broadcast_shapes(x.shape, powers.shape[1:])
        return np.broadcast_to(total, shape)

    def sizes(self, x: Array, growth: Array | None = None, powers: Array | None = None) -> Array:
        """The sums of the absolute values of all terms at one x >= 0 of each set, and so for all
        smaller ones.

        ``growth``: bounds of C and S of each angle and set, 1 if not given.
        """
        growth = np.ones_like(self.rates) if growth is None else growth
        waves = [w for row in growth for w in (row, row)]
        points = VariablePoints(x, [*waves, *(self._powers(x) if powers is None else powers)])
        return reduce(
            add, [reduce(mul, [f.at(points, f.rows.sizes) for f in side]) for side in self._sides]
        )

    def _powers(self, x: Array) -> list[Array]:
        return [np.exp(alpha * np.log(x)) for alpha in self.variables.orders]

    def error(self, sizes: Array, low: Array, high: Array, *, own_powers: bool = False) -> Array:
        """The bound on the error of values between two x, whose sizes are at most these."""
        count = max(sum(f.roundings for f in side) for side in (self.above, self.below)) + 1
        units = np.full(sizes.shape, float(count))
        # Relative to the size, whose factors C and S count as 1: their absolute errors matter. One
        # of an angle is n u (k x), and changes the cosine by at most as much, sin(t)/t by at most 2
        # n u.
        for i, (rate, term) in enumerate(zip(self.rates, self.variables.rates, strict=True)):
            angle = np.abs(rate) * high
            roundings = 2 + sum(term.exponents) + _OF_X + 1
            units += self._degree(1 + i) * (roundings * np.maximum(angle, 2.0) + _OF_LIBM + 4)
            # written so that nan counts as too large
            units[~(angle < MOST_ANGLE)] = np.inf
        for alpha, degree in zip(self.variables.orders, self.power_degrees, strict=True):
            # exp turns the absolute error of alpha log x into a relative one of the power; the
            # logarithm is largest at the low end
            steep = (
                0.0 if own_powers or not degree else (_OF_LIBM + 4) * alpha * np.abs(np.log(low))
            )
            units += degree * (steep + _OF_LIBM + 12)
        bound: Array = error(sizes, 1) * units + TINY
        return bound

    def left_out(
        self, low: Array, high: Array, degree: int, powers: Array | None = None
    ) -> tuple[Array, Array]:
        """Bounds on value and slope of what interpolation of that degree leaves out on segments."""
        has_waves = any(self.power_degrees) or any(
            self._degree(1 + i) for i in range(len(self.rates))
        )
        # a polynomial of no higher degree is its own interpolant
        if not has_waves and self._degree(0) <= degree:
            return np.zeros_like(low), np.zeros_like(low)
        middle, half = (low + high) / 2, (high - low) / 2
        turned = sum(
            (self._degree(1 + i) * np.abs(k) for i, k in enumerate(self.rates)), np.zeros_like(low)
        )
        ratio = np.full_like(low, _FIRST_RATIO)
        # To where M r^-degree is least, as M grows like exp(turned half r/2) (middle + half r/2)^n:
        # the zero of the logarithmic derivative, by two steps of a fixed-point iteration. Any r
        # that is allowed gives a true bound, so that the choice decides only how narrow it is.
        for _ in range(2):
            steep = turned * half / 2 + self._degree(0) * half / (2 * middle + half * ratio)
            ratio = np.clip(degree / (steep + 1e-9), *_RATIOS)
        if powers is None and any(self.power_degrees):
            # x^alpha is analytic right of 0 alone, so that the ellipse's left end must stay there:
            # (r + 1/r)/2 < t
            t = middle / half
            ratio = np.minimum(ratio, (t + np.sqrt((t - 1) * (t + 1))) * (1 - 1e-9))
        # The bound needs q < 1, which a smaller r may not give: nan, which no comparison accepts,
        # has the segment cut.
        ratio = np.where(ratio >= LEAST_RATIO, ratio, np.nan)
        # M on the ellipse: |x| is largest at its right end, and |cos(k x)| and |sin(k x)/(k x)| are
        # at most exp(k |Im x|), with Im x at most the smaller half axis.
        reach = (middle + half * (ratio + 1 / ratio) / 2) * _SLACK
        growth = np.exp(np.abs(self.rates) * (half * (ratio - 1 / ratio) / 2 * _SLACK)) * _SLACK
        return left_out(self.sizes(reach, growth, powers) * _SLACK, ratio, degree)


class VariablePoints:
    """The values of all variables at points of each set.

    ``waves``: those of C, S, C, S, ..., z, ...; each product of them is computed once.
    """

    def __init__(self, x: Array, waves: Sequence[Array]) -> None:
        self._x, self._waves = x, waves
        self._gaps: dict[int, Array] = {1: x}
        self._products: dict[Exponents, Array] = {}

    @classmethod
    def of(
        cls, variables: Variables, x: Array, rates: Array, powers: Array | None
    ) -> VariablePoints:
        """The variables at x, points x sets, for half angles of these rates."""
        waves: list[Array] = []
        for rate in rates:
            angle = rate * x
            # sin(t)/t is 1 at t = 0, where the quotient of floats is 0/0.
            still = angle == 0
            waves += [
                np.cos(angle),
                np.where(still, 1.0, np.sin(angle) / np.where(still, 1.0, angle)),
            ]
        if powers is None and variables.orders:
            log = np.log(x)
            powers = np.array([np.exp(alpha * log) for alpha in variables.orders])
        return cls(x, [*waves, *(() if powers is None else powers)])

    def horner(self, rows: Array, powers: Sequence[tuple[int, int]]) -> Array:
        """The sum of rows times powers of x, which descend."""
        (above, row), *others = powers
        total: Array = rows[row]
        # the last step, without a row, multiplies by what is left of x's lowest power
        for power, row in [*others, (0, -1)]:
            if above > power:
                total = total * self._gap(above - power)
            if row >= 0:
                total = total + rows[row]
            above = power
        return total

    def _gap(self, power: int) -> Array:
        """x to a whole power, one rounding less than it."""
        if power not in self._gaps:
            self._gaps[power] = self._gap(power - power // 2) * self._gap(power // 2)
        return self._gaps[power]

    def product(self, exponents: Exponents) -> Array | None:
        """A product of waves; None if it is empty."""
        if not any(exponents):
            return None
        if exponents not in self._products:
            last = max(i for i, n in enumerate(exponents) if n)
            rest = self.product((*exponents[:last], exponents[last] - 1, *exponents[last + 1 :]))
            self._products[exponents] = (
                self._waves[last] if rest is None else rest * self._waves[last]
            )
        return self._products[exponents]


@dataclass(frozen=True)
class Zeros:
    """Enclosures of the zeros of a function for many sets: each zero is simple and alone between
    ``low`` and ``high``; in ascending order within each of the ``sets``.

    ``decided``: for each set, whether these are proven to be all its zeros on the band. ``first``:
    the sign at the low end.
    """

    sets: Array
    low: Array
    high: Array
    decided: Array
    first: Array


Segments: TypeAlias = tuple[Array, Array, Array]
"""Sets, which may be repeated, low ends, high ends."""
_DEGREES, _DEGREE_AT_0 = (5, 10, 14), 6
"""Degrees of the interpolants that are tried in turn, the lowest for narrow segments alone: it
amplifies rounding errors less. The second is for the first segment, from 0 on."""
_NARROW = 2.0**-6
_READY, _READY_AT_0 = 1e-6, 1e-4
"""How much of the size a remainder may be: else a segment is cut before anything is computed on
it."""
_MOST_CUTS, _MOST_CUTS_AT_0, _MOST_HALVINGS = 40, 9, 5
_AT_ONCE = 8192
# Segments of a set that may be open at one time. So many are left where the function is within its
# rounding errors on a whole stretch: cutting on would find nothing there.
_MOST_OPEN = 200


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
            begin = parts.pop(0)
            search.run(begin)
            search.doubtful[np.concatenate([x[0] for x in search.found])] = True
        elif edges[0] == 0 and any(f.power_degrees):
            # No ellipse about a segment that begins at 0 keeps right of 0, so that x^alpha has no
            # interpolant there.
            parts[0] = search.beyond_0(edges[1])
        search.run(_joined(parts))
        return search.zeros()


class _Search:
    """The search for the zeros of a function for many sets at once.

    ``doubtful`` : the sets for which it has failed. ``first`` : the sign at the low end. ``found``:
    segments that are proven to hold exactly one zero. ``bottom`` : the low end of the band.
    """

    def __init__(self, f: Function, bottom: float) -> None:
        self.f, self.bottom = f, bottom
        self.doubtful = np.zeros(f.sets, dtype=bool)
        self.first = np.zeros(f.sets, dtype=np.int8)
        self.found: list[Segments] = [_chosen(self.segment(0, 0), np.zeros(f.sets, dtype=bool))]

    def segment(self, low: float, high: float) -> Segments:
        """The same segment for each set."""
        return np.arange(self.f.sets), np.full(self.f.sets, low), np.full(self.f.sets, high)

    def run(self, left: Segments) -> None:
        """Cut segments until each holds one zero or none; sets where that fails are marked as
        doubtful."""
        for _ in range(_MOST_CUTS):
            self.doubtful |= np.bincount(left[0], minlength=self.f.sets) > _MOST_OPEN
            left = _chosen(left, ~self.doubtful[left[0]])
            if not len(left[0]):
                return
            narrow = left[2] - left[1] < _NARROW
            kinds = (_chosen(left, narrow), _DEGREES), (_chosen(left, ~narrow), _DEGREES[1:])
            left = _joined(
                [self.narrowed(some, degrees) for part, degrees in kinds for some in _pieces(part)]
            )
        # what is still open after so many cuts holds a multiple zero, or one within rounding errors
        self.doubtful[left[0]] = True

    def narrowed(self, segments: Segments, degrees: Sequence[int]) -> Segments:
        """Search segments on which the function is near enough to a polynomial of one of these
        degrees; returned are those, or parts of them, that must be searched again.

        A segment that is too wide for the first degree is tried with the next; for none, it is cut.
        """
        if not degrees or not len(segments[0]):
            # by equal ratios where there is a power of x: what decides whether it can be
            # interpolated on a segment is the ratio of its ends
            return _halves(segments, by_ratio=any(self.f.power_degrees))
        degree, *others = degrees
        sets, low, high = segments
        f = self.f.of(sets)
        left_out, sizes = f.left_out(low, high, degree), f.sizes(high)
        # Known beforehand, from sizes alone: no values are computed on a segment that would be cut
        # anyway. nan, for no usable ellipse, is not ready.
        ready = left_out[1] <= _READY * sizes
        rest, some = self.narrowed(_chosen(segments, ~ready), others), ready.nonzero()[0]
        if len(some) < len(sets):
            f, sizes, left_out = f.of(some), sizes[some], (left_out[0][some], left_out[1][some])
        segments = _chosen(segments, ready)
        ends, curves = _interpolated(f, segments, sizes, left_out, degree)
        self._told(segments, ends)
        return _joined([rest, *self._searched(segments, curves, ends)])

    def _told(self, segments: Segments, ends: Array) -> None:
        """Record the signs at the ends of segments: sets with one that is not proven become
        doubtful."""
        sets, low, high = segments
        # Zeros are counted by changes of sign between ends, so that each end needs a sign. A zero
        # at an end, or a segment without a double inside, cannot be settled by cutting.
        self.doubtful[sets[(ends == 0).any(axis=0) | ~(low < high)]] = True
        at_bottom = low == self.bottom
        self.first[sets[at_bottom]] = ends[0][at_bottom]

    def _searched(self, segments: Segments, curves: Interpolants, ends: Array) -> list[Segments]:
        """Record the zeros of the interpolants, which are halved a few times for that; returned are
        the segments on which that does not suffice."""
        for _ in range(_MOST_HALVINGS):
            none, one = curves.judged(ends)
            self.found.append(_chosen(segments, one))
            open_ = ~(none | one) & ~self.doubtful[segments[0]]
            if not open_.any():
                return []
            curves, segments = (
                curves.of(open_.nonzero()[0]).halves(),
                _halves(_chosen(segments, open_)),
            )
            ends = curves.ends()
        none, one = curves.judged(ends)
        self.found.append(_chosen(segments, one))
        sets, low, high = _chosen(segments, ~(none | one))
        # the ends of halves were rounded: the next floats outside leave no gap between segments
        return [
            (
                sets,
                np.maximum(np.nextafter(low, 0), self.bottom),
                np.minimum(np.nextafter(high, 1), 1.0),
            )
        ]

    def zeros(self) -> Zeros:
        """The enclosures that were found for sets without a doubt."""
        everywhere = _joined(self.found)
        sets, low, high = _chosen(everywhere, ~self.doubtful[everywhere[0]])
        order = np.lexsort((low, sets))
        return Zeros(sets[order], low[order], high[order], ~self.doubtful, self.first)

    def beyond_0(self, end: float) -> Segments:
        """The segments between the end and a first one, from 0 on, that is shown to hold no zero.

        There powers are variables of their own. The first segment is shortened by factors of 4
        until the sign is proven on it; sets for which no length is short enough are doubtful.
        """
        left = self.segment(0.0, end)
        rest = [_chosen(left, np.zeros(self.f.sets, dtype=bool))]
        # Bernstein's basis in two variables, x and one power, is what there is
        if sum(n > 0 for n in self.f.power_degrees) > 1:
            self.doubtful[:] = True
            return left
        for _ in range(_MOST_CUTS_AT_0):
            sets, low, high = left
            sign = _sign_from_0(self.f.of(sets), high)
            self.first[sets] = sign
            sets, high = sets[sign == 0], high[sign == 0]
            if not len(sets):
                break
            rest.append((sets, high / 4, high))
            left = sets, low[: len(sets)], high / 4
        self.doubtful[sets] = True
        return _joined(rest)


@dataclass(frozen=True)
class Interpolants:
    """Interpolating polynomials on segments, by their Bernstein coefficients, segments in columns.

    ``wrong``: a bound on the errors of all coefficients. ``left_out``: bounds on the difference of
    function and polynomial, and on that of their slopes, the latter divided by the degree.
    """

    coefficients: Array
    wrong: Array
    left_out: tuple[Array, Array]

    def of(self, some: Array) -> Interpolants:
        """For some of the sets."""
        value, slope = self.left_out
        return Interpolants(
            self.coefficients[:, some], self.wrong[some], (value[some], slope[some])
        )

    def ends(self) -> Array:
        """The proven signs of the function at both ends; 0 where there is none."""
        return _certain(self.coefficients[[0, -1]], self.wrong + self.left_out[0])

    def judged(self, ends: Array) -> tuple[Array, Array]:
        """Of each segment whether it is proven to hold no zero, and whether it is proven to hold
        exactly one, given the signs at its ends."""
        value, slope = self.left_out
        # a polynomial lies in the convex hull of its Bernstein coefficients
        none = _one_sign(self.coefficients, self.wrong + value)
        # The Bernstein coefficients of p' are n times these differences, each of which has the
        # errors of two; so the slope is bounded over n.
        monotone = _one_sign(np.diff(self.coefficients, axis=0), (2 * self.wrong + slope) * _SLACK)
        known = monotone & (ends != 0).all(axis=0)
        return none | (known & (ends[0] == ends[1])), known & (ends[0] != ends[1])

    def halves(self) -> Interpolants:
        """The polynomials on the first halves of the segments, then on the second halves, by de
        Casteljau's weights."""
        halves = [
            np.einsum("ji,ib->jb", w, self.coefficients)
            for w in halving(len(self.coefficients) - 1)
        ]
        # On a half the parameter runs half as fast, so that slopes by it are half as large; the
        # roundings of all halvings are in ``wrong`` from the start.
        value, slope = self.left_out
        both = np.concatenate(halves, axis=1)
        return Interpolants(
            both, np.tile(self.wrong, 2), (np.tile(value, 2), np.tile(slope / 2, 2))
        )


def _interpolated(
    f: Function, segments: Segments, sizes: Array, left_out: tuple[Array, Array], degree: int
) -> tuple[Array, Interpolants]:
    """The proven signs of a function at both ends of segments, and its interpolants there."""
    _, low, high = segments
    n = nodes(degree, sizes.dtype)
    values = f.values(low * n.low[:, None] + high * n.high[:, None])
    wrong = f.error(sizes, low, high)
    # Not a matrix product of a linear algebra library, whose order of summation may depend on how
    # many columns there are: a set must not be answered differently beside others.
    coefficients = np.einsum("ji,ib->jb", n.matrix, values)
    # the roundings of this sum, and those of all halvings
    bound = n.amplified.max() * (wrong + error(sizes, (degree + 3) * (1 + _MOST_HALVINGS)))
    value, slope = left_out
    # at the low end sizes, and so errors, may be much smaller
    at_ends = np.array([f.error(f.sizes(low), low, low), wrong])
    # slopes were bounded by the variable on [-1, 1]; on [0, 1], Bernstein's, they are twice that
    return _certain(values[[0, -1]], at_ends), Interpolants(
        coefficients, bound, (value, 2 * slope / degree)
    )


def _one_sign(values: Array, bounds: Array) -> Array:
    found: Array = np.logical_or((values > bounds).all(axis=0), (values < -bounds).all(axis=0))
    return found


def _certain(values: Array, bounds: Array) -> Array:
    return (values > bounds).astype(np.int8) - (values < -bounds).astype(np.int8)


def _sign_from_0(f: Function, high: Array) -> Array:
    """The sign of each function on all of [0, high] if that is proven, else 0.

    Its one power z = x^alpha is taken as a variable of its own on [0, high^alpha], in which the
    function is a polynomial: a sign on the rectangle of x and z holds on the curve within it.
    """
    low = np.zeros_like(high)
    place = next(i for i, n in enumerate(f.power_degrees) if n)
    m, n = nodes(_DEGREE_AT_0), nodes(f.power_degrees[place])
    powers = np.zeros((len(f.power_degrees), len(high)))
    # rounded up, so that the rectangle holds the curve
    order = f.variables.orders[place]
    powers[place] = np.exp(order * np.log(high)) * _SLACK
    value, _ = f.left_out(low, high, _DEGREE_AT_0, powers)
    sizes = f.sizes(high, powers=powers)
    # values at all pairs of nodes: of z in rows, of x in columns, sets behind
    x = high * m.high[:, None]
    z = powers[:, None, None] * n.high[:, None, None]
    coefficients, roundings = _in_both(n, m, f.values(x, z))
    # in z the interpolant is exact, in x it leaves out ``value``; both matrices amplify errors
    wrong = f.error(sizes, low, high, own_powers=True) + error(sizes, roundings)
    in_x = m.amplified[:, None] * wrong + value
    bounds = n.amplified[:, None, None] * in_x
    count = len(high)
    same = _one_sign(coefficients.reshape(-1, count), bounds.reshape(-1, count))
    is_close = value < _READY_AT_0 * sizes
    signs: Array = np.where(same & is_close, np.sign(coefficients[0, 0]), 0.0)
    return signs


def _in_both(n: Nodes, m: Nodes, values: Array) -> tuple[Array, int]:
    """From values at nodes of the power and of x to coefficients in both of Bernstein's bases, and
    how often a term is rounded.

    One variable after the other: in a sum over both at once each term would be rounded with every
    one that follows it.
    """
    of_x = np.einsum("mj,ijb->imb", m.matrix, values)
    # each time the weight, the product, and with all terms but its own the sum
    return np.einsum("ki,imb->kmb", n.matrix, of_x), (m.degree + 2) + (n.degree + 2)


def _pieces(segments: Segments) -> Iterator[Segments]:
    """Segments in batches of at most ``_AT_ONCE``, which bounds the memory of the work arrays."""
    sets, low, high = segments
    for i in range(0, len(sets), _AT_ONCE):
        yield sets[i : i + _AT_ONCE], low[i : i + _AT_ONCE], high[i : i + _AT_ONCE]


def _chosen(segments: Segments, kept: Array) -> Segments:
    sets, low, high = segments
    return sets[kept], low[kept], high[kept]


def _joined(parts: Sequence[Segments]) -> Segments:
    sets, low, high = (np.concatenate(column) for column in zip(*parts, strict=True))
    return sets, low, high


def _halves(segments: Segments, *, by_ratio: bool = False) -> Segments:
    sets, low, high = segments
    middle = np.sqrt(low * high) if by_ratio else (low + high) / 2
    return np.tile(sets, 2), np.concatenate([low, middle]), np.concatenate([middle, high])


_MOST_ROUNDS = 60
# Relative to the zero: steps are no shorter than this, so that the bracket closes from both sides
# well before it is as narrow as the accuracy that is proven afterwards.
_FINE = 2e-13
_INSIDE = 2.0**-49


def refine(f: Function, low: Array, high: Array, tolerance: float) -> tuple[Array, Array]:
    """The zero of each function between low and high, where it is monotone, and whether it is
    proven to that accuracy.

    Proven: f has certain and opposite signs at x (1 - tolerance) and x (1 + tolerance), or at the
    segment's end if that is nearer.
    """
    with np.errstate(all="ignore"):
        low, high = (x.astype(f.above[0].rows.values.dtype) for x in (low, high))
        x = _approached(f, low, high)
        # A segment's end was rounded, and may lie beside the place at which its sign was proven; a
        # change of sign between points well inside is one of the segment's own zero.
        low, high = low * (1 + _INSIDE), high * (1 - _INSIDE)
        below, above = np.maximum(low, x * (1 - tolerance)), np.minimum(high, x * (1 + tolerance))
        return x, _signs(f, below) * _signs(f, above) < 0


def _signs(f: Function, x: Array) -> Array:
    value, bound = f.values(x[None])[0], f.error(f.sizes(x), x, x)
    signs: Array = (value > bound).astype(np.int8) - (value < -bound).astype(np.int8)
    return signs


def _approached(f: Function, low: Array, high: Array) -> Array:
    """A float near the zero of each function between a and b, of which nothing is proven yet.

    By inverse quadratic interpolation where that is safe, and bisection elsewhere (Chandrupatla
    1997).
    """
    found, open_ = (low + high) / 2, np.arange(len(low))
    a, b = low.copy(), high.copy()
    at_a, at_b = f.values(a[None])[0], f.values(b[None])[0]
    share = at_a / (at_a - at_b)
    c, at_c = a, at_a
    for _ in range(_MOST_ROUNDS):
        if not len(open_):
            break
        x = a + share * (b - a)
        at_x = f.values(x[None])[0]
        alike = (at_x > 0) == (at_a > 0)
        c, at_c = np.where(alike, a, b), np.where(alike, at_a, at_b)
        b, at_b = np.where(alike, b, a), np.where(alike, at_b, at_a)
        a, at_a = x, at_x
        # the secant through the bracket's ends is nearer than either, where it lies between them
        best = np.where(np.abs(at_a) < np.abs(at_b), a, b)
        straight = a - at_a * ((b - a) / (at_b - at_a))
        found[open_] = np.where((straight - a) * (straight - b) < 0, straight, best)
        least = _FINE * np.abs(best) / np.abs(b - a)
        left = (least < 0.5) & (at_a != 0) & (at_b != 0)
        share = np.clip(_next(a, b, c, at_a, at_b, at_c), least, 1 - least)
        if not left.all():
            a, b, at_a, at_b, share, open_ = (x[left] for x in (a, b, at_a, at_b, share, open_))
            f = f.of(left.nonzero()[0])
    return found


def _next(a: Array, b: Array, c: Array, at_a: Array, at_b: Array, at_c: Array) -> Array:
    """The part of the way from a to b that is tried next."""
    xi = (a - b) / (c - b)
    phi = (at_a - at_b) / (at_c - at_b)
    # Chandrupatla's condition: the inverse quadratic through the three points is monotonic between
    # a and b, so that its zero lies there.
    safe = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
    of_b = at_a / (at_b - at_a) * at_c / (at_b - at_c)
    of_c = (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
    by_inverse = of_b + of_c
    # equal values divide by 0: then too the middle is tried
    is_usable = safe & np.isfinite(by_inverse)
    return np.where(is_usable, by_inverse, 0.5)
