"""Taylor's coefficients in one variable, carried through sums, products and quotients, in balls.

Over a cell q = q0 + r x, -1 <= x <= 1, a function f of q is f_0 + f_1 x + ... + f_(n-1) x^(n-1) + f_n x^n, where f_k is its k-th
derivative times r^k/k!, at q0 for k < n, and somewhere in the cell for k = n (Lagrange). A jet is the row of the f_k, at a number
or all over a cell; f may be a number, a polynomial or a matrix. Together they stay as narrow as the function is smooth, where a
ball grows with each number that occurs twice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add
from typing import Any, NamedTuple, TypeAlias

from flint import arb, arb_poly

from haptisym.kernel.reals import Ball

Value: TypeAlias = Any
"""A number, a polynomial or a matrix in balls, or a jet of them."""


class Jet:
    """f_0, ..., f_n, of one kind; sums, products and quotients are those of the functions.

    >>> x = Jet([arb(2), arb(1), arb(0)])                                   # 2 + x
    >>> [float(c) for c in (1 / (x * x - 3)).row]                           # 1/(1 + 4 x + x^2)
    [1.0, -4.0, 15.0]
    """

    __slots__ = ("row",)

    def __init__(self, row: Sequence[Value]) -> None:
        self.row = tuple(row)

    def __add__(self, x: Value) -> Jet:
        if isinstance(x, Jet):
            return Jet([a + b for a, b in zip(self.row, x.row, strict=True)])
        return Jet([self.row[0] + x, *self.row[1:]])

    def __mul__(self, x: Value) -> Jet:
        if not isinstance(x, Jet):
            return Jet([a * x for a in self.row])
        return Jet([_crossed(self.row[: k + 1], x.row[: k + 1]) for k in range(len(self.row))])

    def __neg__(self) -> Jet:
        return Jet([-a for a in self.row])

    def __sub__(self, x: Value) -> Jet:
        return Jet.__add__(self, -x)

    def __rsub__(self, x: Value) -> Jet:
        return Jet.__add__(-self, x)

    def __rmul__(self, x: Value) -> Jet:
        """Of a number, or of another kind that a jet of numbers is a factor of."""
        return Jet([x * a for a in self.row])

    __radd__ = __add__

    def __truediv__(self, x: Value) -> Jet:
        return self * x._inverse() if isinstance(x, Jet) else Jet([a / x for a in self.row])

    def __rtruediv__(self, x: Value) -> Jet:
        return Jet.__rmul__(self._inverse(), x)

    def __pow__(self, n: int) -> Jet:
        base = self if n >= 0 else self._inverse()
        return reduce(Jet.__mul__, [base] * abs(n), self * 0 + 1)

    def _inverse(self) -> Jet:
        """1/f."""
        row = [1 / self.row[0]]
        for k in range(1, len(self.row)):
            row.append(-_crossed(self.row[1 : k + 1], row) * row[0])
        return Jet(row)

    def __getitem__(self, place: tuple[int, int]) -> Jet:
        """An entry of a matrix."""
        return Jet([a[place] for a in self.row])

    def __call__(self, x: Ball) -> Jet:
        """A polynomial's value."""
        return Jet([a(x) for a in self.row])

    def trace(self) -> Jet:
        """Of a matrix."""
        return Jet([a.trace() for a in self.row])

    def nrows(self) -> int:
        """Of a matrix."""
        return int(self.row[0].nrows())

    def ncols(self) -> int:
        """Of a matrix."""
        return int(self.row[0].ncols())

    def is_zero(self) -> bool:
        """Whether it is 0 with all its derivatives."""
        return all(a.is_zero() for a in self.row)


def _crossed(one: Sequence[Value], other: Sequence[Value]) -> Value:
    """a_0 b_n + ... + a_n b_0."""
    return reduce(add, (a * b for a, b in zip(one, reversed(other), strict=True)))


def value(x: Value) -> Value:
    """What it is, without its derivatives."""
    return x.row[0] if isinstance(x, Jet) else x


def parts(x: Value) -> tuple[Value, ...]:
    """Its Taylor coefficients; a ball is its only one."""
    return x.row if isinstance(x, Jet) else (x,)


def joined(make: Callable[[list[Any]], Value], entries: Sequence[Value]) -> Value:
    """What is made of numbers, entry by entry, of jets where one of them is one: polynomials, matrices."""
    size = max((len(x.row) for x in entries if isinstance(x, Jet)), default=0)
    if not size:
        return make([*entries])
    rows = [x.row if isinstance(x, Jet) else (x, *[arb(0)] * (size - 1)) for x in entries]
    return Jet([make(list(column)) for column in zip(*rows, strict=True)])


def polynomial(entries: Sequence[Value]) -> Value:
    """By its coefficients, ascending."""
    return joined(arb_poly, entries)


def coefficients(p: Value) -> list[Value]:
    """Of a polynomial, ascending."""
    if not isinstance(p, Jet):
        return [*p.coeffs()]
    rows = [[*a.coeffs()] for a in p.row]
    length = max(map(len, rows))
    return [Jet(column) for column in zip(*([*row, *[arb(0)] * (length - len(row))] for row in rows), strict=True)]


def narrowest(found: Sequence[Value]) -> Value:
    """Of numbers that are all true, the one in the narrowest balls."""
    rows = zip(*map(parts, found), strict=True)
    return joined_row([min(row, key=lambda x: float(x.rad())) for row in rows])


def joined_row(row: Sequence[Value]) -> Value:
    """A jet, or the ball that is its only part."""
    return Jet(row) if len(row) > 1 else row[0]


class Line(NamedTuple):
    """All over a cell a function is at + slope x, -1 <= x <= 1: of ``at`` anything, of ``slope`` one number all over it."""

    at: Ball
    slope: Ball

    @property
    def ball(self) -> Ball:
        """All of its values."""
        return self.at + self.slope * arb(0, 1)


def over_cell(function: Callable[[Value], Sequence[Value]], middle: Ball, radius: Ball, order: int) -> list[Line]:
    """The values of functions of q all over |q - middle| <= radius, by their Taylor polynomials and what these leave out.

    >>> [square] = over_cell(lambda q: [q * q - q], arb(1), arb("0.25"), 2)       # from 3/4 - 3/16 to 5/4 + 5/16 by balls
    >>> round(float(square.ball.lower()), 6), round(float(square.ball.upper()), 6)
    (-0.25, 0.3125)
    """
    rest = [arb(0)] * (order - 1)
    at = function(Jet([middle, radius, *rest][:order]))
    over = function(Jet([arb(middle, radius), radius, *rest]))
    return [_line(here, all_over) for here, all_over in zip(at, over, strict=True)]


def _line(here: Value, all_over: Value) -> Line:
    """f_0 + f_1 x + ..., the last coefficient from all over the cell."""
    if not isinstance(here, Jet):
        return Line(here, arb(0))
    row = [*here.row, all_over.row[-1]]
    slope = row[1] if len(row) > 2 else arb(0)
    bent = row if len(row) == 2 else [row[0], arb(0), *row[2:]]
    powers = (1, *((arb(0, 1), arb(0.5, 0.5))[k % 2 == 0] for k in range(1, len(row))))
    return Line(reduce(add, (a * x for a, x in zip(bent, powers, strict=True))), slope)
