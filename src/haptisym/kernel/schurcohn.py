"""How many roots a polynomial has inside the unit circle and on it: Schur and Cohn's recursion on certified signs.

With f* the polynomial whose coefficients are those of f in reverse, b f - a f* (a the lowest coefficient of f, b its highest)
has as many roots inside as f where |b| > |a|, those on the circle among them, and one of its roots is 0. Each step decides
|b| - |a| by balls; where these cannot, whether a = b or a = -b is asked of the exact coefficients. Where it is so: f = +-f* has
its roots in pairs z, 1/z or on the circle, and as many outside as its derivative (Cohn); any other f is multiplied by 2 z - 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, Protocol, TypeAlias

from haptisym.kernel.budget import afford
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.precision import MOST_BITS, at_rising_precision
from haptisym.kernel.reals import Ball

Exact: TypeAlias = Any
_EXACT_FROM = 512  # bits from which on a ball around 0 makes one ask whether it is 0


class Circle(NamedTuple):
    """The roots of a polynomial, each as often as it counts."""

    inside: int
    on: int
    outside: int


class Coefficients(Protocol):
    """A polynomial, ascending: balls around its coefficients, and, if they are ever needed, the coefficients themselves."""

    def balls(self) -> Sequence[Ball]:
        """At the current working precision."""

    def exact(self) -> Sequence[Exact] | None:
        """Elements of some ring, or a common multiple of them; None where they are not known exactly."""

    def is_zero(self, x: Exact) -> bool:
        """Whether a coefficient is 0, decided exactly."""


def count_on_circle(polynomial: Coefficients) -> Circle:
    """Inside, on and outside the unit circle, certified.

    UndecidedError where a sign stays open as the coefficients are not known exactly.

    >>> from flint import arb, fmpq
    >>> @dataclass
    ... class Rational:
    ...     c: list
    ...     def balls(self): return [arb(fmpq(x)) for x in self.c]
    ...     def exact(self): return [fmpq(x) for x in self.c]
    ...     def is_zero(self, x): return x == 0
    >>> count_on_circle(Rational([2, -5, 2])), count_on_circle(Rational([1, 0, 2, 0, 1]))          # (2 z - 1)(z - 2), (z^2 + 1)^2
    (Circle(inside=1, on=0, outside=1), Circle(inside=0, on=4, outside=0))
    """

    def ask(bits: int) -> Circle | None:
        known = _Known(polynomial, bits)
        try:
            return known.count([_Lazy(x, partial(known.coefficient, i)) for i, x in enumerate(polynomial.balls())])
        except _RiseError:
            return None

    found = at_rising_precision(ask, 128, MOST_BITS)
    if found is None:
        raise UndecidedError("whether a root lies on the unit circle")
    return found


class _RiseError(Exception):
    """More precision is needed."""


def _product(x: Exact, y: Exact) -> Exact:
    if hasattr(x, "__len__"):  # a polynomial in exponentials: products grow from step to step
        afford(len(x), len(y))
    return x * y


@dataclass(frozen=True)
class _Lazy:
    """A number as a ball, and exactly once that is asked for."""

    ball: Ball
    make: Callable[[], Exact]

    @cached_property
    def exact(self) -> Exact:
        return self.make()

    def __add__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball + other.ball, lambda: self.exact + other.exact)

    def __sub__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball - other.ball, lambda: self.exact - other.exact)

    def __mul__(self, other: _Lazy) -> _Lazy:
        return _Lazy(self.ball * other.ball, lambda: _product(self.exact, other.exact))

    def times(self, factor: int) -> _Lazy:
        return _Lazy(factor * self.ball, lambda: factor * self.exact)


@dataclass(frozen=True)
class _Known:
    """What is asked about a polynomial at one precision."""

    polynomial: Coefficients
    bits: int

    @cached_property
    def exact(self) -> Sequence[Exact]:
        found = self.polynomial.exact()
        if found is None:
            raise _RiseError
        return found

    def coefficient(self, i: int) -> Exact:
        """The exact ones may end before the balls do, at what is 0."""
        return self.exact[i] if i < len(self.exact) else self.exact[0] - self.exact[0]

    def is_zero(self, x: _Lazy) -> bool:
        """_RiseError where only more precision will tell."""
        if x.ball.is_zero():
            return True
        if not x.ball.contains(0):
            return False
        if self.bits >= _EXACT_FROM and self.polynomial.is_zero(x.exact):
            return True
        raise _RiseError

    def count(self, c: list[_Lazy]) -> Circle:
        """The roots of a polynomial whose coefficients are not all 0."""
        inside, on = 0, 0
        while self.is_zero(c[-1]):
            c = c[:-1]
        while self.is_zero(c[0]):
            c, inside = c[1:], inside + 1
        for at in (1, -1):
            while len(c) > 1 and self.is_zero(_value(c, at)):
                c, on = _without(c, at), on + 1
        rest = self.rest(c) if len(c) > 1 else Circle(0, 0, 0)
        return Circle(rest.inside + inside, rest.on + on, rest.outside)

    def rest(self, c: list[_Lazy]) -> Circle:
        """Of a polynomial without roots at 0, 1 and -1."""
        n = len(c) - 1
        for sign in (1, -1):
            if self.is_zero(c[-1] - c[0].times(sign)):
                if all(self.is_zero(x - y.times(sign)) for x, y in zip(c, c[::-1], strict=True)):
                    own = self.count([x.times(i) for i, x in enumerate(c)][1:])
                    return Circle(own.outside, n - 2 * own.outside, own.outside)
                more = self.count(
                    [y.times(2) - x for x, y in zip([*c, _nothing(c)], [_nothing(c), *c], strict=True)]
                )  # (2 z - 1) f
                return Circle(more.inside - 1, more.on, more.outside)
        a, b = c[0], c[-1]
        larger = bool((b.ball - a.ball) * (b.ball + a.ball) > 0)
        if not larger:  # f* has the roots 1/z
            c, a, b = c[::-1], b, a
        found = self.count([b * x - a * y for x, y in zip(c[1:], c[::-1][1:], strict=True)])
        found = Circle(found.inside + 1, found.on, found.outside)
        return found if larger else Circle(found.outside, found.on, found.inside)


def _nothing(c: Sequence[_Lazy]) -> _Lazy:
    return c[0].times(0)


def _value(c: Sequence[_Lazy], at: int) -> _Lazy:
    """At 1 or -1."""
    total = c[0]
    for i, x in enumerate(c[1:], 1):
        total = total + x.times(at**i)
    return total


def _without(c: Sequence[_Lazy], at: int) -> list[_Lazy]:
    """The quotient by z - at."""
    row = [c[-1]]
    for x in c[-2:0:-1]:
        row.append(x + row[-1].times(at))
    return row[::-1]
