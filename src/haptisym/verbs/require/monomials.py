"""Sums of monomials c X^a Y^b with real exponents, over boxes that may reach to X = 0 or Y = 0, in balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat, arb_poly, fmpq

from haptisym.kernel.reals import Ball
from haptisym.verbs.require.knownsums import Coefficient, ExactPolynomial, added, ball, is_exact
from haptisym.verbs.require.rows import Row

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
            flat[i * self.shape[1] + j] = ball(value)
        return arb_mat(*self.shape, flat)

    @cached_property
    def sizes(self) -> Any:
        """About the logarithms of the negative ones, -inf in place of others."""
        found = np.full(self.shape, -np.inf)
        for place, value in self.values.items():
            if ball(value) < 0:
                found[place] = float(abs(ball(value)).mid().log())
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
    _rows: dict[int, Row | None] = field(default_factory=dict, init=False, repr=False)
    _above: dict[int, Monomials | None] = field(default_factory=dict, init=False, repr=False)
    _shifted: dict[tuple[fmpq, int], Monomials] = field(default_factory=dict, init=False, repr=False)
    _risen: dict[Fraction, Monomials] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(cls, terms: Terms) -> Monomials:
        """Of the coefficients by the exponents."""
        below, under = (lcm(*(e[i].denominator for e in terms)) for i in (0, 1))
        return cls.on({(int(a * below), int(b * under)): value for (a, b), value in terms.items()}, below, under)

    @classmethod
    def on(cls, cells: Mapping[tuple[int, int], Coefficient], below: int, under: int) -> Monomials:
        """Of the coefficients by the numerators of the exponents, over two numbers."""
        across, up = (sorted({e[i] for e in cells}) for i in (0, 1))
        rows, columns = ({x: i for i, x in enumerate(own)} for own in (across, up))
        values = {(rows[a], columns[b]): value for (a, b), value in cells.items()}
        table = _Table(values, (len(across), len(up)))
        return cls(tuple(Fraction(x, below) for x in across), tuple(Fraction(y, under) for y in up), table)

    @cached_property
    def terms(self) -> Terms:
        """The coefficients by the exponents."""
        return {(self.across[i], self.up[j]): value for (i, j), value in self.table.values.items()}

    @property
    def has_constant(self) -> bool:
        """Whether there is a term without X and Y."""
        return (Fraction(0), Fraction(0)) in self.terms

    def row(self, n: int) -> Row | None:
        """What stands before the n-th power of X; None where a coefficient of it is but a ball."""
        if n not in self._rows:
            self._rows[n] = Row.of({self.up[j]: value for (i, j), value in self.table.values.items() if i == n})
        return self._rows[n]

    def above(self, n: int) -> Monomials | None:
        """The sum without the first powers of X up to the n-th; None where nothing is left."""
        if n not in self._above:
            (below, xs), (under, ys) = self._lattices
            left = {(xs[i], ys[j]): value for (i, j), value in self.table.values.items() if i > n}
            self._above[n] = Monomials.on(left, below, under) if left else None
        return self._above[n]

    @cached_property
    def touches(self) -> tuple[fmpq, ...]:
        """Rational Y > 0 at which what stands before the least power of X has a double root, or one of more."""
        first = self.row(0)
        return first.touches if first and all(b.denominator == 1 for b in self.up) else ()

    def shifted(self, at: fmpq, sign: int) -> Monomials:
        """The sum in X and w, Y = at + sign w, where Y is in whole powers: what cancels there is not in it."""
        if (at, sign) not in self._shifted:
            (below, xs), (_, ys) = self._lattices
            rows: dict[int, dict[int, Coefficient]] = {x: {} for x in xs}
            for (i, j), value in self.table.values.items():
                rows[xs[i]][ys[j]] = value
            found = {(x, n): value for x, row in rows.items() for n, value in _moved(row, at, sign).items()}
            self._shifted[at, sign] = Monomials.on(found, below, 1)
        return self._shifted[at, sign]

    @cached_property
    def slope(self) -> tuple[Fraction, Ball]:
        """The slope p of the edge of Newton's polygon next to X = 0, and about where along Y = X^p v its terms are alike.

        That is beyond where these touch 0, which is all on one side of it then.
        """
        b = min(b for a, b in self.terms if a == 0)
        others = [(a / (b - other), b - other, value) for (a, other), value in self.terms.items() if other < b]
        p, rise, value = min(others, key=lambda x: x[:2])
        first, last = (abs(float(ball(x).mid())) for x in (self.terms[Fraction(0), b], value))
        alike = (last / first) ** (1 / float(rise)) if first and last else 1.0
        return p, arb(max([alike, *(2 * float(arb(x)) for x in self.risen(p).touches)]))

    def risen(self, p: Fraction) -> Monomials:
        """The sum in X and v over a power of X, Y = X^p v."""
        if p not in self._risen:
            (below, xs), (under, ys) = self._lattices
            common = lcm(below, p.denominator * under)
            across, steps = [x * (common // below) for x in xs], [int(p * y * common / under) for y in ys]
            found = {(across[i] + steps[j], ys[j]): value for (i, j), value in self.table.values.items()}
            least = min(a for a, _ in found)
            self._risen[p] = Monomials.on({(a - least, b): value for (a, b), value in found.items()}, common, under)
        return self._risen[p]

    def along(self, v: Ball) -> tuple[Ball, ...]:
        """What stands before the powers of X, in order, at a number Y = v >= 0."""
        powers = arb_mat(len(self.up), 1, _ranges(self._lattices[1], (v, v), Fraction(0)))
        return tuple((self.table.matrix * powers).entries())

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


def _moved(row: Mapping[int, Coefficient], at: fmpq, sign: int) -> dict[int, Coefficient]:
    """The coefficients of a polynomial in w, Y = at + sign w."""
    found = dict(ExactPolynomial.of({n: value for n, value in row.items() if is_exact(value)}).shifted(at, sign))
    if not all(map(is_exact, row.values())):
        rest = [row[n] if n in row and not is_exact(row[n]) else arb(0) for n in range(max(row) + 1)]
        for n, value in enumerate(arb_poly(rest)(arb_poly([at, sign])).coeffs()):
            found[n] = added(found.get(n, fmpq(0)), value)
    return found


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
