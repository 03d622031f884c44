"""Functions over many small boxes at once, with proven bounds: Taylor models of second order for values and slopes.

A ``Model`` is a function of t in [-1, 1]^n as ``c0 + c1.t + t.c2.t``, and a radius ``r`` that bounds all the rest, together with
the same for each of its n slopes d/dt_i: rows of the arrays, the value first; and all that for each of many boxes. What
intervals lose where a variable occurs twice, models keep to third order. Floats, with every rounding error in ``r``: a model is
a proof, not an estimate. Where ``r`` is not finite nothing is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import Any, TypeAlias

import numpy as np

Array: TypeAlias = Any  # numpy arrays of floats

_ROUNDING = 1e-14  # of an operation, relative to the largest values of its operands: some ten roundings of 2^-53 each
_TINY = 1e-290  # against underflow: of a value, and of a coefficient


@dataclass(frozen=True, slots=True)
class Model:
    """``c0`` (boxes, m), ``c1`` (boxes, m, n), ``c2`` (boxes, m, n, n), ``r`` (boxes, m); m = 1 + n: the value and its slopes."""

    c0: Array
    c1: Array
    c2: Array
    r: Array

    @property
    def deviation(self) -> Array:
        """Bounds on the distance from ``c0``."""
        return np.abs(self.c1).sum(-1) + np.abs(self.c2).sum((-1, -2)) + self.r

    def bounds(self) -> tuple[Array, Array]:
        """The least and the greatest that the value and each slope can be, (boxes, m); infinite where nothing is known."""
        radius = self.deviation * (1 + _ROUNDING) + np.abs(self.c0) * _ROUNDING
        radius = np.where(np.isfinite(radius) & np.isfinite(self.c0), radius, np.inf)
        middle = np.where(np.isfinite(radius), self.c0, 0.0)
        return middle - radius, middle + radius

    def __add__(self, other: Model) -> Model:
        sizes = np.abs(self.c0) + self.deviation + np.abs(other.c0) + other.deviation
        return Model(self.c0 + other.c0, self.c1 + other.c1, self.c2 + other.c2, self.r + other.r + _ROUNDING * sizes)

    def __neg__(self) -> Model:
        return Model(-self.c0, -self.c1, -self.c2, self.r)

    def __sub__(self, other: Model) -> Model:
        return self + -other

    def __mul__(self, other: Model) -> Model:
        """The product, its slopes by the product rule."""
        by_value, by_slope = _product(self._value, other), _product(self, other._value)
        for array in (by_slope.c0, by_slope.c1, by_slope.c2, by_slope.r):
            array[:, 0] = 0
        return by_value + by_slope

    @property
    def _value(self) -> Model:
        return Model(self.c0[:, :1], self.c1[:, :1], self.c2[:, :1], self.r[:, :1])

    def times(self, x: float) -> Model:
        """The product with a number that is known to within some roundings."""
        whole = abs(x) * (np.abs(self.c0) + self.deviation)
        r = self.r * abs(x) + _ROUNDING * whole + _TINY
        return Model(self.c0 * x, self.c1 * x, self.c2 * x, r)

    def power(self, n: int) -> Model:
        """The function to a whole power, not 0; unknown where it may be 0, unless n is 1 or 2.

        (1 + y)^n to second order; for |y| <= rho the rest is at most |n (n - 1) (n - 2)|/6 rho^3 times the
        largest (1 + y)^(n - 3).
        """
        if n in (1, 2):
            return self if n == 1 else self * self
        return self._chained(self._power(n), self._power(n - 1).times(n))

    def _power(self, n: int) -> Model:
        """The value to a power, without slopes; not to 1."""
        if n == 2:
            return _product(self._value, self._value)
        a = self.c0[:, :1]
        rho = self.deviation[:, :1] / np.abs(a)
        largest = np.maximum((1 + rho) ** (n - 3), (1 - rho) ** (n - 3))
        rest = np.where(rho < 0.9, abs(n * (n - 1) * (n - 2)) / 6 * rho**3 * largest, np.inf)
        whole = a ** float(n)
        return self._composed(
            whole, n * whole / a, n * (n - 1) / 2 * whole / a**2, rest * np.maximum(np.abs(whole), _TINY)
        )

    def cosine_and_sine(self) -> tuple[Model, Model]:
        """Of an angle in radians."""
        a, rest = self.c0[:, :1], self.deviation[:, :1] ** 3 / 6
        c, s = np.cos(a), np.sin(a)
        cosine, sine = self._composed(c, -s, -c / 2, rest), self._composed(s, c, -s / 2, rest)
        return self._chained(cosine, -sine), self._chained(sine, cosine)

    def sinc(self) -> Model:
        """sin x/x, whose n-th derivative is nowhere larger than 1/(n + 1); the first is a difference of larger numbers."""
        a, rest = self.c0[:, :1], self.deviation[:, :1] ** 3 / 6
        f, df, d2f, d3f = _sinc(a)
        lost = _ROUNDING * np.minimum(np.abs(a), 1)
        value, slope = self._composed(f, df, d2f / 2, rest / 4), self._composed(df, d2f, d3f / 2, rest / 5 + lost)
        return self._chained(value, slope)

    def log(self) -> Model:
        """The logarithm; unknown where the function may be 0."""
        a = self.c0[:, :1]
        rho = self.deviation[:, :1] / a
        rest = np.where((rho >= 0) & (rho < 0.9), rho**3 / 3 / (1 - rho), np.inf)
        value = self._composed(np.log(a), 1 / a, -1 / (2 * a**2), rest)
        return self._chained(value, self._power(-1))

    def exp(self) -> Model:
        """The exponential."""
        e, d = np.exp(self.c0[:, :1]), self.deviation[:, :1]
        value = self._composed(e, e, e / 2, np.maximum(e, _TINY) * d**3 / 6 * np.exp(d))
        return self._chained(value, value)

    def _composed(self, f: Array, df: Array, half: Array, rest: Array) -> Model:
        """f + df x + half x^2 + rest for x = the value minus its middle; without slopes."""
        x1, x2, r = self.c1[:, :1], self.c2[:, :1], self.r[:, :1]
        d1, d2 = np.abs(x1).sum(-1), np.abs(x2).sum((-1, -2))
        c1 = df[..., None] * x1
        c2 = df[..., None, None] * x2 + half[..., None, None] * x1[..., :, None] * x1[..., None, :]
        square = 2 * d1 * (d2 + r) + (d2 + r) ** 2  # of x^2, what is not in c2
        whole = np.abs(f) + np.abs(df) * (d1 + d2) + np.abs(half) * d1**2  # of what is in f, c1 and c2
        lost = _ROUNDING * whole + _TINY * (1 + self.deviation[:, :1]) ** 2
        radius = (np.abs(df) * r + np.abs(half) * square + rest) * (1 + _ROUNDING) + lost
        return Model(f, c1, c2, radius)

    def _chained(self, value: Model, slope: Model) -> Model:
        """The value in row 0, and slope times each slope of this function in the others."""
        found = _product(slope, self)
        found.c0[:, :1], found.c1[:, :1], found.c2[:, :1], found.r[:, :1] = value.c0, value.c1, value.c2, value.r
        return found

    def where(self, known: Array, other: Model) -> Model:
        """This model for the boxes where ``known`` holds, and the other one for the rest."""
        k = known[:, None]
        c1, c2 = np.where(k[..., None], self.c1, other.c1), np.where(k[..., None, None], self.c2, other.c2)
        return Model(np.where(k, self.c0, other.c0), c1, c2, np.where(k, self.r, other.r))


def _sinc(x: Array) -> tuple[Array, ...]:
    """sin x/x and three derivatives: near 0 by their series, else by x f'' + 2 f' + x f = 0."""
    terms = [(-1.0) ** k / factorial(2 * k + 1) * np.eye(1, 29, 2 * k)[0] for k in range(14)]
    near = [
        np.polynomial.Polynomial(sum(terms)).deriv(n) if n else np.polynomial.Polynomial(sum(terms)) for n in range(4)
    ]
    far = np.where(np.abs(x) < 1.5, 1.5, x)
    f = np.sin(far) / far
    df = (np.cos(far) - f) / far
    d2f = -f - 2 * df / far
    d3f = -df - (3 * d2f + f) / far
    return tuple(np.where(np.abs(x) < 1.5, p(x), y) for p, y in zip(near, (f, df, d2f, d3f), strict=True))


def _product(x: Model, y: Model) -> Model:
    """Row by row; one of the two may have a single row."""
    c0 = x.c0 * y.c0
    c1 = x.c0[..., None] * y.c1 + y.c0[..., None] * x.c1
    c2 = x.c0[..., None, None] * y.c2 + y.c0[..., None, None] * x.c2 + x.c1[..., :, None] * y.c1[..., None, :]
    x1, y1 = np.abs(x.c1).sum(-1), np.abs(y.c1).sum(-1)
    x2, y2 = np.abs(x.c2).sum((-1, -2)), np.abs(y.c2).sum((-1, -2))
    xs, ys = np.abs(x.c0) + x1 + x2, np.abs(y.c0) + y1 + y2
    r = x1 * y2 + x2 * y1 + x2 * y2 + xs * y.r + ys * x.r + x.r * y.r
    return Model(c0, c1, c2, r * (1 + _ROUNDING) + _ROUNDING * (xs * ys) + _TINY)


def constant(value: float, boxes: int, sides: int) -> Model:
    """A number, known to within some roundings; its slopes are 0."""
    zero = np.zeros((boxes, 1 + sides))
    return _flat(np.full(boxes, value), zero)


def variable(middle: Array, radius: Array, size: float, side: int, sides: int) -> Model:
    """middle + radius t_side for each box, to within some roundings of numbers up to ``size``."""
    found = _flat(middle, np.zeros((len(middle), 1 + sides)))
    found.c1[:, 0, side] = radius
    found.c0[:, 1 + side] = radius
    found.r[:, 0] = found.r[:, 1 + side] = _ROUNDING * size
    return found


def between(low: Array, high: Array, sides: int) -> Model:
    """A function that lies between two numbers, with slopes of which nothing is known."""
    r = np.full((len(low), 1 + sides), np.inf)
    r[:, 0] = (high - low) / 2 * (1 + _ROUNDING)
    return _flat((low + high) / 2, r)


def _flat(value: Array, r: Array) -> Model:
    boxes, rows = r.shape
    c0 = np.zeros(r.shape)
    c0[:, 0] = value
    r[:, 0] += _ROUNDING * np.abs(value) + _TINY
    return Model(c0, np.zeros((boxes, rows, rows - 1)), np.zeros((boxes, rows, rows - 1, rows - 1)), r)
