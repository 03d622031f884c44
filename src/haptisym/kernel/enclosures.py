"""Enclosures over an interval or a cell: Bernstein coefficients of polynomials, Taylor coefficients of anything, in balls.

A ball grows with each number that occurs twice in a formula; two forms stay as narrow as the function is smooth.

*Bernstein.* A polynomial of degree n on [-r, r] lies between its least and its greatest coefficient in the basis of Bernstein's
polynomials. A ``Stretch`` is a function between two frequencies as such a polynomial: by Taylor's theorem its last coefficient
is one over the whole piece.

*Jets.* Over a cell q = m + r x, -1 <= x_i <= 1, a function f of q is the sum of f_a x^a over all a of degree < n, and of as
many terms of degree n, where f_a is the derivative of order a times r^a/a!, at m for degrees < n, and somewhere in the cell for
n (Lagrange's rest). A ``Jet`` is the row of the f_a, by rising degree, at a set of numbers or all over a cell; f may be a
number, a polynomial or a matrix, and sums, products and quotients of jets are those of the functions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import combinations_with_replacement, count, pairwise
from math import comb
from operator import add
from typing import Any, NamedTuple, TypeAlias

import flint
from flint import arb, arb_mat, arb_poly, fmpq

from haptisym.kernel.reals import Ball


def range_of(row: Sequence[Ball], reach: Sequence[Ball]) -> Ball:
    """A ball around the values of c_0 + c_1 h + ... for all h from -r to r, given the powers 1, r, r^2, ... of r.

    >>> balls = [arb(c) for c in (3, 0, 1)]
    >>> range_of(balls, [arb(1), arb(2), arb(4)])     # 3 + h^2 for -2 <= h <= 2: by Bernstein not below -1
    [+/- 7.01]
    """
    return reduce(arb.union, _converted([c * power for c, power in zip(row, reach, strict=False)]).entries())


def bernstein_coefficients(row: Sequence[Ball], reach: Ball) -> arb_mat:
    """The Bernstein coefficients of c_0 + c_1 h + ... between h = -r and h = r, in a column.

    >>> bernstein_coefficients([arb(3), arb(0), arb(1)], arb(2)).entries()
    [7.00000000000000, -1.00000000000000, 7.00000000000000]
    """
    scaled, power = [row[0]], arb(1)
    for c in row[1:]:
        power = power * reach
        scaled.append(c * power)
    return _converted(scaled)


def _converted(row: Sequence[Ball]) -> arb_mat:
    degree = len(row) - 1
    return _conversion(degree, flint.ctx.prec) * arb_mat(degree + 1, 1, row)


@lru_cache(maxsize=64)
def _conversion(degree: int, bits: int) -> arb_mat:
    """From the coefficients of 1, u, u^2, ... to those of the Bernstein polynomials on [-1, 1]."""
    with flint.ctx.workprec(bits):
        return arb_mat([[arb(_weight(degree, j, k)) for k in range(degree + 1)] for j in range(degree + 1)])


def _weight(degree: int, j: int, k: int) -> fmpq:
    """The part of u^k = (t - (1 - t))^k (t + (1 - t))^(degree - k), t = (1 + u)/2, in the j-th Bernstein polynomial."""
    ways = sum((-1) ** (k - i) * comb(k, i) * comb(degree - k, j - i) for i in range(min(j, k) + 1))
    return fmpq(ways, comb(degree, j))


Series: TypeAlias = Callable[[Ball, int, int], Sequence[Ball]]
"""Balls around the Taylor coefficients of a function, of orders from one to before another, about every point of a ball."""

_ORDER = 8  # of the polynomial


@dataclass(frozen=True, eq=False, slots=True)
class Stretch:
    """A function between ``low`` and ``high``: at each x in there it, and its slopes, are those of one of the polynomials.

    Taylor's theorem: the last coefficient is one of those over the whole piece; which one may change with x. ``row``: the
    coefficients between the exact numbers ``ends``, which enclose low and high.
    """

    low: Ball
    high: Ball
    ends: tuple[Ball, Ball]
    row: Sequence[Ball]

    @classmethod
    def of(cls, series: Series, low: Ball, high: Ball) -> Stretch:
        """A function with those Taylor coefficients between two exact numbers, at the current working precision."""
        with flint.ctx.workprec(flint.ctx.prec - 60):  # so that the ends of its parts are exact numbers too
            middle = ((low + high) / 2).mid()
        with flint.ctx.workprec(30):
            reach = (high - middle).max(middle - low).upper()
        ends = middle - reach, middle + reach
        row = [*series(middle, 0, _ORDER), *series(ends[0].union(ends[1]), _ORDER, _ORDER + 1)]
        return cls(low, high, ends, bernstein_coefficients(row, reach).entries())

    def sign(self, order: int = 0) -> int:
        """The sign all over the piece, or that of the slope or the curvature; 0 where it does not show."""
        row = self._differences(order)
        if row[0] > 0:
            return int(all(x > 0 for x in row))
        return -int(row[0] < 0 and all(x < 0 for x in row))

    def _differences(self, order: int) -> Sequence[Ball]:
        """The coefficients of the slope, the curvature, ... up to numbers > 0."""
        row = self.row
        for _ in range(order):
            row = [b - a for a, b in pairwise(row)]
        return row

    def sign_at(self, end: int, order: int = 0) -> int:
        """That at one of the ends, 0 for the low one and -1 for the high one; 0 where it does not show."""
        row = self._differences(order)
        found, beyond = row[end], self.ends[end] - (self.low, self.high)[end]
        if not beyond.is_zero() and len(row) > 1:  # by the mean value theorem
            steepest = reduce(arb.max, (abs(b - a).upper() for a, b in pairwise(row))) * (len(row) - 1)
            found = found + steepest * beyond / (self.ends[1] - self.ends[0]) * _EITHER
        return int(found > 0) - int(found < 0)


_EITHER = arb(0, 1)


Value: TypeAlias = Any
"""A number, a polynomial or a matrix in balls, or a jet of them."""


class Jet:
    """The f_a of one kind, in so many ``variables``; sums, products and quotients are those of the functions.

    >>> x = Jet([arb(2), arb(1), arb(0)])                                   # 2 + x
    >>> [float(c) for c in (1 / (x * x - 3)).row]                           # 1/(1 + 4 x + x^2)
    [1.0, -4.0, 15.0]
    >>> x, y = Jet([arb(2), arb(1), arb(0)], 2), Jet([arb(3), arb(0), arb(1)], 2)
    >>> [float(c) for c in (x * y).row]                                     # (2 + x)(3 + y) = 6 + 3 x + 2 y + ...
    [6.0, 3.0, 2.0]
    """

    __slots__ = ("row", "variables")

    def __init__(self, row: Sequence[Value], variables: int = 1) -> None:
        self.row, self.variables = tuple(row), variables

    def _like(self, row: Sequence[Value]) -> Jet:
        return Jet(row, self.variables)

    def __add__(self, x: Value) -> Jet:
        if isinstance(x, Jet):
            return self._like([a + b for a, b in zip(self.row, x.row, strict=True)])
        return self._like([self.row[0] + x, *self.row[1:]])

    def __mul__(self, x: Value) -> Jet:
        if not isinstance(x, Jet):
            return self._like([a * x for a in self.row])
        pairs = _pairs(self.variables, len(self.row))
        return self._like([reduce(add, (self.row[i] * x.row[j] for i, j in own)) for own in pairs])

    def __neg__(self) -> Jet:
        return self._like([-a for a in self.row])

    def __sub__(self, x: Value) -> Jet:
        return Jet.__add__(self, -x)

    def __rsub__(self, x: Value) -> Jet:
        return Jet.__add__(-self, x)

    def __rmul__(self, x: Value) -> Jet:
        """Of a number, or of another kind that a jet of numbers is a factor of."""
        return self._like([x * a for a in self.row])

    __radd__ = __add__

    def __truediv__(self, x: Value) -> Jet:
        return self * x._inverse() if isinstance(x, Jet) else self._like([a / x for a in self.row])

    def __rtruediv__(self, x: Value) -> Jet:
        return Jet.__rmul__(self._inverse(), x)

    def __pow__(self, n: int) -> Jet:
        base = self if n >= 0 else self._inverse()
        return reduce(Jet.__mul__, [base] * abs(n), self * 0 + 1)

    def _inverse(self) -> Jet:
        """1/f."""
        row = [1 / self.row[0]]
        for own in _pairs(self.variables, len(self.row))[1:]:
            row.append(-reduce(add, (self.row[i] * row[j] for i, j in own if i)) * row[0])
        return self._like(row)

    def __getitem__(self, place: tuple[int, int]) -> Jet:
        """An entry of a matrix."""
        return self._like([a[place] for a in self.row])

    def __call__(self, x: Ball) -> Jet:
        """A polynomial's value."""
        return self._like([a(x) for a in self.row])

    def trace(self) -> Jet:
        """Of a matrix."""
        return self._like([a.trace() for a in self.row])

    def nrows(self) -> int:
        """Of a matrix."""
        return int(self.row[0].nrows())

    def ncols(self) -> int:
        """Of a matrix."""
        return int(self.row[0].ncols())

    def is_zero(self) -> bool:
        """Whether it is 0 with all its derivatives."""
        return all(a.is_zero() for a in self.row)


@lru_cache(maxsize=64)
def powers(variables: int, length: int) -> tuple[tuple[int, ...], ...]:
    """The exponents a of the first terms, by rising degree: whole degrees.

    >>> powers(2, 6)
    ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    """
    found = list[tuple[int, ...]]()
    for degree in count():
        if len(found) == length:
            return tuple(found)
        assert len(found) < length, "a degree that is not whole"
        for chosen in combinations_with_replacement(range(variables), degree):
            found.append(tuple(map(chosen.count, range(variables))))
    raise AssertionError


@lru_cache(maxsize=64)
def _pairs(variables: int, length: int) -> tuple[tuple[tuple[int, int], ...], ...]:
    """Which terms of two factors make each term of their product."""
    own = powers(variables, length)
    place = {a: i for i, a in enumerate(own)}
    found: list[list[tuple[int, int]]] = [[] for _ in own]
    for i, a in enumerate(own):
        for j, b in enumerate(own):
            k = place.get(tuple(map(add, a, b)))
            if k is not None:
                found[k].append((i, j))
    return tuple(map(tuple, found))


def value(x: Value) -> Value:
    """What it is, without its derivatives."""
    return x.row[0] if isinstance(x, Jet) else x


def parts(x: Value) -> tuple[Value, ...]:
    """Its Taylor coefficients; a ball is its only one."""
    return x.row if isinstance(x, Jet) else (x,)


def joined(make: Callable[[list[Any]], Value], entries: Sequence[Value]) -> Value:
    """What is made of numbers, entry by entry, of jets where one of them is one: polynomials, matrices."""
    jet = next((x for x in entries if isinstance(x, Jet)), None)
    if jet is None:
        return make([*entries])
    rows = [x.row if isinstance(x, Jet) else (x, *[arb(0)] * (len(jet.row) - 1)) for x in entries]
    return like(jet, [make(list(column)) for column in zip(*rows, strict=True)])


def polynomial(entries: Sequence[Value]) -> Value:
    """By its coefficients, ascending."""
    return joined(arb_poly, entries)


def coefficients(p: Value) -> list[Value]:
    """Of a polynomial, ascending."""
    if not isinstance(p, Jet):
        return [*p.coeffs()]
    rows = [[*a.coeffs()] for a in p.row]
    length = max(map(len, rows))
    return [like(p, column) for column in zip(*([*row, *[arb(0)] * (length - len(row))] for row in rows), strict=True)]


def narrowest(found: Sequence[Value]) -> Value:
    """Of numbers that are all true, the one in the narrowest balls."""
    rows = zip(*map(parts, found), strict=True)
    return like(found[0], [min(row, key=lambda x: float(x.rad())) for row in rows])


def like(x: Value, row: Sequence[Value]) -> Value:
    """A jet in as many variables as another one, or the ball that is the only part of what is no jet."""
    return Jet(row, x.variables) if isinstance(x, Jet) else row[0]


class Line(NamedTuple):
    """All over a cell a function is at + slopes . x, -1 <= x_i <= 1: of ``at`` anything, of a slope one number all over it."""

    at: Ball
    slopes: tuple[Ball, ...]

    @property
    def ball(self) -> Ball:
        """All of its values."""
        return sum((slope * arb(0, 1) for slope in self.slopes), self.at)


def over_cell(
    function: Callable[[list[Value]], Sequence[Value]], middles: Sequence[Ball], radii: Sequence[Ball], order: int
) -> list[Line]:
    """The values of functions of q all over |q_i - middle_i| <= radius_i, by their Taylor polynomials and what these leave out.

    >>> [square] = over_cell(lambda q: [q[0] * q[0] - q[0]], [arb(1)], [arb("0.25")], 2)  # from 3/4 - 3/16 to 5/4 + 5/16 by balls
    >>> round(float(square.ball.lower()), 6), round(float(square.ball.upper()), 6)
    (-0.25, 0.3125)
    """
    n = len(middles)

    def of_degree(degree: int, values: Sequence[Ball]) -> Sequence[Value]:
        length = comb(n + degree, n)
        return function([
            Jet([x, *(r if i == k else arb(0) for k in range(n)), *[arb(0)] * length][:length], n)
            for i, (x, r) in enumerate(zip(values, radii, strict=True))
        ])  # fmt: skip

    at = of_degree(order - 1, middles)
    over = of_degree(order, [arb(x, r) for x, r in zip(middles, radii, strict=True)])
    return [_line(here, all_over, n) for here, all_over in zip(at, over, strict=True)]


def _line(here: Value, all_over: Value, n: int) -> Line:
    """The terms of the lower degrees, and those of the highest from all over the cell."""
    if not isinstance(here, Jet):
        return Line(here, (arb(0),) * n)
    row = [*here.row, *all_over.row[len(here.row) :]]
    straight = slice(1, n + 1 if len(here.row) > 1 else 1)
    bent = [row[0]] + [
        c * (arb(0, 1) if any(k % 2 for k in a) else arb(0.5, 0.5))
        for a, c in [*zip(powers(n, len(row)), row, strict=True)][straight.stop :]
    ]
    return Line(reduce(add, bent), tuple(row[straight]) or (arb(0),) * n)
