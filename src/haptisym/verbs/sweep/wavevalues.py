"""Values of products of wave families for many sets at once, and bounds on what rounding, libm and interpolation did to them.

All errors are counted in units u = 2^-53 of the size (``batch``), the sum of the absolute values of all terms with 1 for
each wave:

- x is given to within 3 u of itself, an angle k x to within n u of itself, n the roundings behind k plus 4; libm's part of a
  sine, a cosine, an exponential or a logarithm is 8 u of it (``libm``). So C and S, each at most 1, are known to within
  n max(2, k x) + 12 units, as abs(x d sinc(x)/dx) <= 2, and z = exp(alpha log x) to within 12 alpha abs(log x) + 20. A term
  of degree d in them has d times that;
- a term of degree d in x has 3 d for x itself, and what its own operations make (``WaveFamily.roundings``).

What underflows on the way is smaller than ``TINY`` in total, as all variables are at most 1, and coefficients do not underflow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add, mul

import numpy as np

from haptisym.verbs.sweep.batch import Array, Batch, error, product
from haptisym.verbs.sweep.chebyshev import LEAST_RATIO, left_out
from haptisym.verbs.sweep.libm import MOST_ANGLE, ULPS
from haptisym.verbs.sweep.waves import Exponents, Variables, WaveFamily

TINY = 1e-280
_OF_X, _OF_LIBM = 3, 2 * ULPS
_SLACK = 1.001
_FIRST_RATIO, _RATIOS = 8.0, (3.0, 1000.0)


@dataclass(frozen=True)
class Factor:
    """A family and its coefficients for each set."""

    family: WaveFamily
    rows: Batch

    def of(self, sets: Array) -> Factor:
        """For some of the sets."""
        return Factor(self.family, self.rows.of(sets))

    @property
    def roundings(self) -> int:
        """How many a value of it suffers at most."""
        return self.rows.roundings + self.family.roundings + _OF_X * self.family.degrees[0] + 1

    @property
    def polynomial(self) -> Batch:
        """The same as a polynomial in x, where no wave occurs in it."""
        places = [row[0] for row in self.family.rows]
        values, sizes = np.zeros((2, max(places) + 1, self.rows.values.shape[1]))
        values[places], sizes[places] = self.rows.values, self.rows.sizes
        return Batch(values, sizes, self.rows.roundings)

    def at(self, points: Points, rows: Array) -> Array:
        """The value with these coefficients: a sum over the products of waves, each times a polynomial in x."""
        total: Array | None = None
        for waves, powers in self.family.groups.items():
            term, wave = points.horner(rows, powers), points.product(waves)
            term = term if wave is None else term * wave
            total = term if total is None else total + term
        assert total is not None
        return total


@dataclass(frozen=True)
class WaveFunction:
    """The product of the factors ``above`` minus that of those ``below`` (none: 0); ``rates``: k of each angle and set."""

    variables: Variables
    rates: Array
    above: tuple[Factor, ...]
    below: tuple[Factor, ...] = ()

    def __sub__(self, other: WaveFunction) -> WaveFunction:
        return replace(self, below=other.above)

    @property
    def sets(self) -> int:
        """How many sets there are."""
        return int(self.above[0].rows.values.shape[1])

    def of(self, sets: Array) -> WaveFunction:
        """Those of some of the sets, which may be repeated."""
        above, below = (tuple(f.of(sets) for f in side) for side in (self.above, self.below))
        return WaveFunction(self.variables, self.rates[:, sets], above, below)

    def _degree(self, i: int) -> int:
        """Of x (0), of an angle or of a power, in the order of ``WaveFamily.degrees``."""
        return max(sum(f.family.degrees[i] for f in side) for side in (self.above, self.below))

    @property
    def _sides(self) -> list[tuple[Factor, ...]]:
        return [side for side in (self.above, self.below) if side]

    @property
    def is_polynomial(self) -> bool:
        """Whether no wave occurs in it."""
        return not any(any(f.family.degrees[1:]) for side in (self.above, self.below) for f in side)

    @property
    def polynomial(self) -> Batch:
        """The same where no wave occurs in it."""
        above, *below = (product([f.polynomial for f in side]) for side in self._sides)
        return above - below[0] if below else above

    @property
    def power_degrees(self) -> list[int]:
        """The degrees of the powers of x that are not whole."""
        first = 1 + len(self.variables.rates)
        return [self._degree(first + i) for i in range(len(self.variables.orders))]

    def values(self, x: Array, powers: Array | None = None) -> Array:
        """At points of each set: points x sets. ``powers``: instead of x^alpha, if that is to be a variable of its own.

        They may have more dimensions in front, and then so do the values.
        """
        points = Points.of(self.variables, x, self.rates, powers)
        found = [reduce(mul, [f.at(points, f.rows.values) for f in side]) for side in self._sides]
        shape = x.shape if powers is None else np.broadcast_shapes(x.shape, powers.shape[1:])
        return np.broadcast_to(found[0] - found[1] if len(found) > 1 else found[0], shape)

    def sizes(self, x: Array, growth: Array | None = None, powers: Array | None = None) -> Array:
        """The sums of the absolute values of all terms at one x >= 0 of each set, and so for all smaller ones.

        ``growth``: bounds of C and S of each angle and set, 1 if not given.
        """
        growth = np.ones_like(self.rates) if growth is None else growth
        waves = [w for row in growth for w in (row, row)]
        points = Points(x, [*waves, *(self._powers(x) if powers is None else powers)])
        return reduce(add, [reduce(mul, [f.at(points, f.rows.sizes) for f in side]) for side in self._sides])

    def _powers(self, x: Array) -> list[Array]:
        return [np.exp(alpha * np.log(x)) for alpha in self.variables.orders]

    def error(self, sizes: Array, low: Array, high: Array, *, own_powers: bool = False) -> Array:
        """The bound on the error of values between two x, whose sizes are at most these."""
        count = max(sum(f.roundings for f in side) for side in (self.above, self.below)) + 1
        units = np.full(sizes.shape, float(count))
        for i, (rate, term) in enumerate(zip(self.rates, self.variables.rates, strict=True)):
            angle = np.abs(rate) * high
            roundings = 2 + sum(term.exponents) + _OF_X + 1
            units += self._degree(1 + i) * (roundings * np.maximum(angle, 2.0) + _OF_LIBM + 4)
            units[~(angle < MOST_ANGLE)] = np.inf
        for alpha, degree in zip(self.variables.orders, self.power_degrees, strict=True):
            steep = 0.0 if own_powers or not degree else (_OF_LIBM + 4) * alpha * np.abs(np.log(low))
            units += degree * (steep + _OF_LIBM + 12)
        bound: Array = error(sizes, 1) * units + TINY
        return bound

    def left_out(self, low: Array, high: Array, degree: int, powers: Array | None = None) -> tuple[Array, Array]:
        """Bounds on value and slope of what interpolation of that degree leaves out on segments."""
        middle, half = (low + high) / 2, (high - low) / 2
        turned = sum((self._degree(1 + i) * np.abs(k) for i, k in enumerate(self.rates)), np.zeros_like(low))
        ratio = np.full_like(low, _FIRST_RATIO)
        for _ in range(2):  # to where M r^-degree is least, as M grows like exp(turned half r/2) (middle + half r/2)^n
            steep = turned * half / 2 + self._degree(0) * half / (2 * middle + half * ratio)
            ratio = np.clip(degree / (steep + 1e-9), *_RATIOS)
        if powers is None and any(self.power_degrees):
            t = middle / half  # the ellipse must stay right of 0, where powers are analytic
            ratio = np.minimum(ratio, (t + np.sqrt((t - 1) * (t + 1))) * (1 - 1e-9))
        ratio = np.where(ratio >= LEAST_RATIO, ratio, np.nan)
        reach = (middle + half * (ratio + 1 / ratio) / 2) * _SLACK
        growth = np.exp(np.abs(self.rates) * (half * (ratio - 1 / ratio) / 2 * _SLACK)) * _SLACK
        return left_out(self.sizes(reach, growth, powers) * _SLACK, ratio, degree)


class Points:
    """The variables at points of each set. ``waves``: C, S, C, S, ..., z, ...; their products are computed once."""

    def __init__(self, x: Array, waves: Sequence[Array]) -> None:
        self._x, self._waves = x, waves
        self._gaps: dict[int, Array] = {1: x}
        self._products: dict[Exponents, Array] = {}

    @classmethod
    def of(cls, variables: Variables, x: Array, rates: Array, powers: Array | None) -> Points:
        """Those at points x sets."""
        waves: list[Array] = []
        for rate in rates:
            angle = rate * x
            still = angle == 0
            waves += [np.cos(angle), np.where(still, 1.0, np.sin(angle) / np.where(still, 1.0, angle))]
        if powers is None and variables.orders:
            log = np.log(x)
            powers = np.array([np.exp(alpha * log) for alpha in variables.orders])
        return cls(x, [*waves, *(() if powers is None else powers)])

    def horner(self, rows: Array, powers: Sequence[tuple[int, int]]) -> Array:
        """The sum of rows times powers of x, which descend."""
        (above, row), *others = powers
        total: Array = rows[row]
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
            self._products[exponents] = self._waves[last] if rest is None else rest * self._waves[last]
        return self._products[exponents]
