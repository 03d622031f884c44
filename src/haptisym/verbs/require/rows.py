"""Sums of powers of one number with exact coefficients: where they change signs, and where they touch 0."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

from flint import arb, arb_poly, fmpq

from haptisym.kernel.reals import Ball
from haptisym.verbs.require.knownsums import Coefficient, ExactPolynomial, is_exact


@dataclass(frozen=True, eq=False)
class Row:
    """A polynomial in Y^(1/below)."""

    polynomial: ExactPolynomial
    below: int

    @classmethod
    def of(cls, values: Mapping[Fraction, Coefficient]) -> Row | None:
        """Of coefficients by their exponents, which are not negative; None where one is but a ball."""
        if not all(map(is_exact, values.values())):
            return None
        below = lcm(*(b.denominator for b in values))
        return cls(ExactPolynomial.of({int(b * below): x for b, x in values.items()}), below)

    @cached_property
    def _factors(self) -> list[tuple[Any, int]]:
        """Those of what the row is up to an irrational factor."""
        common = self.polynomial.common
        return list(common.factor()[1]) if common else []

    @cached_property
    def touches(self) -> tuple[fmpq, ...]:
        """Rational numbers > 0 at which the row has a double root, or one of more; none where Y itself is not in it."""
        if self.below != 1:
            return ()
        linear = (-f[0] / fmpq(f[1]) for f, n in self._factors if n > 1 and f.degree() == 1)
        return tuple(sorted(x for x in linear if x > 0))

    @cached_property
    def _turns(self) -> list[Ball]:
        """About where the polynomial may change signs, up to the irrational factor."""
        odd = (root for f, n in self._factors if n % 2 for root, _ in f.complex_roots())
        return [root.real for root in odd if root.imag.contains(0)]

    def is_nowhere_positive(self, low: Ball, high: Ball) -> bool:
        """Whether the row shows to be positive at no Y^(1/below) between two numbers: what changes signs is squared."""
        common = self.polynomial.common
        if not common:
            return True
        if any(not root <= low and not root >= high for root in self._turns):
            return False
        rest = self.polynomial.rest(low.union(high))
        if not rest > 0 and not rest < 0:
            return False
        middle = arb_poly(common)(((3 * low + 4 * high) / 7).mid())
        return bool(middle * rest < arb(0))
