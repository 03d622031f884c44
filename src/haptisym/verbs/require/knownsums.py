"""Rational multiples of a few numbers, added: real numbers of which it is known where they cancel.

The coefficients of a condition at omega = 0 hold pi and the sines and cosines of constant angles, which are left as they are:
what is 0 whatever these may be is seen to be 0, and two sums that are in a rational ratio are seen to be.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, reduce
from typing import Any, TypeAlias

from flint import arb, arb_poly, fmpq, fmpq_poly

from haptisym.kernel.reals import Ball

Key: TypeAlias = tuple[int, ...]
"""The name of a number: the exponents of what it is a product of; without any, that of 1."""
Coefficient: TypeAlias = Any
"""A rational number of FLINT's, a ``Known``, or a ball."""


@dataclass(frozen=True, eq=False)
class Known:
    """The sum of rational multiples, none of them 0, of numbers that are told apart by names; ``units``: balls around these."""

    parts: Mapping[Key, fmpq]
    units: Mapping[Key, Ball] = field(repr=False)

    @cached_property
    def ball(self) -> Ball:
        """A ball around it, of the working precision that was the first."""
        return sum((self.units[key] * value for key, value in self.parts.items()), arb(0))


def ball(x: Coefficient) -> Ball:
    """A ball around a coefficient."""
    return x.ball if isinstance(x, Known) else arb(x)


def of_parts(parts: Mapping[Key, fmpq], units: Mapping[Key, Ball]) -> Coefficient:
    """The sum of some multiples: a rational number where it is one.

    >>> of_parts({(): fmpq(1, 2), (1,): fmpq(0)}, {(1,): arb.pi()})
    1/2
    """
    left = {key: value for key, value in parts.items() if value}
    return left.get((), fmpq(0)) if left.keys() <= {()} else Known(left, units)


def added(x: Coefficient, y: Coefficient) -> Coefficient:
    """The sum of two coefficients, a ball where one is.

    >>> pi = Known({(1,): fmpq(2)}, {(1,): arb.pi()})
    >>> added(pi, Known({(1,): fmpq(-2)}, {(1,): arb.pi()})), round(float(ball(added(pi, fmpq(1)))), 3)
    (0, 7.283)
    """
    if isinstance(x, fmpq) and isinstance(y, fmpq):
        return x + y
    if not is_exact(x) or not is_exact(y):
        return ball(x) + ball(y)
    parts = dict(parts_of(x))
    for key, value in parts_of(y).items():
        parts[key] = parts.get(key, fmpq(0)) + value
    return of_parts(parts, {**_units(x), **_units(y)})


def is_exact(x: Coefficient) -> bool:
    """Whether a coefficient is not just a ball."""
    return isinstance(x, fmpq | Known)


def parts_of(x: Coefficient) -> Mapping[Key, fmpq]:
    """The multiples of a coefficient that is exact."""
    return x.parts if isinstance(x, Known) else {(): x} if x else {}


def _units(x: Coefficient) -> Mapping[Key, Ball]:
    return x.units if isinstance(x, Known) else {(): arb(1)}


@dataclass(frozen=True, eq=False)
class ExactPolynomial:
    """A polynomial with coefficients that are exact: for each number by its name a polynomial over the rational numbers."""

    parts: Mapping[Key, fmpq_poly]
    units: Mapping[Key, Ball] = field(repr=False)

    @classmethod
    def of(cls, coefficients: Mapping[int, Coefficient]) -> ExactPolynomial:
        """Of coefficients, none of them a mere ball, by their powers."""
        rows: dict[Key, list[fmpq]] = {}
        units: dict[Key, Ball] = {}
        for n, value in coefficients.items():
            units.update(_units(value))
            for key, part in parts_of(value).items():
                rows.setdefault(key, [fmpq(0)] * (max(coefficients) + 1))[n] = part
        return cls({key: fmpq_poly(row) for key, row in rows.items()}, units)

    def shifted(self, at: fmpq, sign: int) -> Iterable[tuple[int, Coefficient]]:
        """The coefficients that are not 0 in w of what it is at ``at + sign w``."""
        inside = fmpq_poly([at, sign])
        moved = {key: own(inside) for key, own in self.parts.items()}
        for n in range(max([0, *(own.degree() + 1 for own in moved.values())])):
            value = of_parts({key: own[n] for key, own in moved.items()}, self.units)
            if isinstance(value, Known) or value:
                yield n, value

    @cached_property
    def common(self) -> fmpq_poly:
        """The largest polynomial over the rational numbers that divides it: all of it, up to one irrational factor, or less."""
        return reduce(fmpq_poly.gcd, self.parts.values(), fmpq_poly([]))

    @cached_property
    def rest(self) -> arb_poly:
        """What is left of it over that polynomial, in balls."""
        return sum((arb_poly(own // self.common) * self.units[key] for key, own in self.parts.items()), arb_poly([]))
