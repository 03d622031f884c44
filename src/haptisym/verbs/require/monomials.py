"""Sums of monomials c X^a Y^b with real exponents, over boxes that may reach to X = 0 or Y = 0, in balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat

from haptisym.kernel.reals import Ball

Coefficient: TypeAlias = Any
"""A rational number of FLINT's, or a ball."""
Terms: TypeAlias = Mapping[tuple[Fraction, Fraction], Coefficient]
"""Coefficients by the exponents of X and Y."""
Side: TypeAlias = tuple[Ball, Ball]


@dataclass(frozen=True, eq=False)
class _Table:
    """Coefficients by the numbers of their rows and columns."""

    values: Mapping[tuple[int, int], Coefficient]
    shape: tuple[int, int]

    @cached_property
    def matrix(self) -> Any:
        """All of them, in balls of the working precision that was the first."""
        flat = [arb(0)] * (self.shape[0] * self.shape[1])
        for (i, j), value in self.values.items():
            flat[i * self.shape[1] + j] = arb(value)
        return arb_mat(*self.shape, flat)

    @cached_property
    def sizes(self) -> Any:
        """About the logarithms of the negative ones, -inf in place of others."""
        found = np.full(self.shape, -np.inf)
        for place, value in self.values.items():
            if value < 0:
                found[place] = float(abs(arb(value)).mid().log())
        return found


@dataclass(frozen=True, eq=False)
class Monomials:
    """A sum by its exponents of X and of Y, each in order.

    >>> from flint import fmpq
    >>> own = Monomials.of({(Fraction(1, 2), Fraction(0)): fmpq(3), (Fraction(1), Fraction(2)): fmpq(-1)})
    >>> float(own.over((arb(4), arb(4)), (arb(1), arb(1)))), own.reduced((arb(0), arb(1)), (arb(0), arb(1))).has_constant
    (2.0, True)
    """

    across: tuple[Fraction, ...]
    up: tuple[Fraction, ...]
    table: _Table

    @classmethod
    def of(cls, terms: Terms) -> Monomials:
        """Of the coefficients by the exponents."""
        across, up = (tuple(sorted({e[i] for e in terms})) for i in (0, 1))
        rows, columns = ({x: i for i, x in enumerate(own)} for own in (across, up))
        values = {(rows[a], columns[b]): value for (a, b), value in terms.items()}
        return cls(across, up, _Table(values, (len(across), len(up))))

    @cached_property
    def terms(self) -> Terms:
        """The coefficients by the exponents."""
        return {(self.across[i], self.up[j]): value for (i, j), value in self.table.values.items()}

    @property
    def has_constant(self) -> bool:
        """Whether there is a term without X and Y."""
        return (Fraction(0), Fraction(0)) in self.terms

    def over_power(self, a: Fraction, b: Fraction) -> Monomials:
        """The sum over X^a Y^b."""
        if not a and not b:
            return self
        return Monomials(tuple(x - a for x in self.across), tuple(x - b for x in self.up), self.table)

    def reduced(self, across: Side, up: Side) -> Monomials:
        """Without the powers of X and Y that all terms have, where these may be 0."""
        return self.over_power(
            self.across[0] if across[0].is_zero() else Fraction(0), self.up[0] if up[0].is_zero() else Fraction(0)
        )

    def over(self, across: Side, up: Side, less: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))) -> Ball:
        """The values on a box, of the sum over X^a Y^b where such are given: exponents of its terms, or 0."""
        xs = arb_mat(1, len(self.across), _ranges(self._lattices[0], across, less[0]))
        ys = arb_mat(len(self.up), 1, _ranges(self._lattices[1], up, less[1]))
        return (xs * (self.table.matrix * ys))[0, 0]

    @cached_property
    def _lattices(self) -> tuple[_Lattice, _Lattice]:
        return _on_lattice(self.across), _on_lattice(self.up)

    @cached_property
    def _floats(self) -> tuple[Any, Any]:
        """The exponents, rounded."""
        return np.array(self.across, float)[:, None], np.array(self.up, float)

    def most_negative(self, x: Ball, y: Ball) -> tuple[Fraction, Fraction] | None:
        """The exponents of about the largest negative monomial at a point; None where none is negative."""
        sizes = self.table.sizes + self._floats[0] * float(x.log()) + self._floats[1] * float(y.log())
        i, j = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
        return (self.across[i], self.up[j]) if sizes[i, j] > -np.inf else None


_Lattice: TypeAlias = tuple[int, tuple[int, ...]]
"""A denominator, and numerators over it."""


def _on_lattice(exponents: Sequence[Fraction]) -> _Lattice:
    below = lcm(*(x.denominator for x in exponents))
    return below, tuple(int(x * below) for x in exponents)


def _ranges(lattice: _Lattice, side: Side, less: Fraction) -> list[Ball]:
    """Powers of all numbers between two, which are not negative, with exponents less by one of them."""
    below, exponents = lattice
    if less:
        exponents = tuple([n - int(less * below) for n in exponents])
    low, high = (x if below == 1 else power(x, Fraction(1, below)) for x in side)
    if side[0] is side[1]:
        return [low**n for n in exponents]
    if side[0].is_zero():
        return [arb(0).union(high**n) if n else arb(1) for n in exponents]
    return [(low**n).union(high**n) for n in exponents]


def power(x: Ball, a: Fraction) -> Ball:
    """A number >= 0 to a power >= 0; of a positive one to any."""
    if a == 0:
        return arb(1)
    if a.denominator == 1:
        return x ** int(a)
    return arb(0) if x.is_zero() else (x.log() * a.numerator / a.denominator).exp()
