"""The polynomial of a loop with a clock in exact numbers: the pulse transfer function by residues at the poles of G(s)/s."""

from __future__ import annotations

from collections.abc import Sequence
from math import lcm
from typing import Any, TypeAlias

from flint import fmpq, fmpq_poly
from sympy import Expr, pi

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.exponentials import Element, Exponentials
from haptisym.kernel.monomials import monomials

Numbers: TypeAlias = Sequence[Expr]
"""Coefficients, ascending: rational numbers times powers of pi, and sums of such."""
Late: TypeAlias = tuple[Expr, int, Numbers]
"""Of a way through the plant: the part of a sample that it is late by (s), the whole samples, and its numerator."""


def residues(
    denominator: Numbers, ways: Sequence[Late], T: Expr, controller: tuple[Numbers, Numbers]
) -> tuple[Exponentials, list[Element]]:
    """The ring, and the coefficients of ``SampledLoop`` in w, ascending, times a number that is not 0.

    Rational: the plant's denominator, T and what the ways are late by; the other numbers may hold pi.
    """
    return _Residues(denominator, ways, T, controller).polynomial()


def _fmpq(x: Expr) -> fmpq:
    return fmpq(int(x.p), int(x.q))


class _Residues:
    def __init__(
        self, denominator: Numbers, ways: Sequence[Late], T: Expr, controller: tuple[Numbers, Numbers]
    ) -> None:
        self.ways, self.T, self.controller = ways, _fmpq(T), controller
        Q = fmpq_poly([_fmpq(x) for x in denominator])
        if not Q:
            raise UndecidedError("the roots of a loop in which nothing resists the force")
        self.at_0 = next(i for i, x in enumerate(Q.coeffs()) if x)
        self.lead = Q.coeffs()[-1]
        split = fmpq_poly(Q.coeffs()[self.at_0 :]).factor()[1]
        rows = [_whole(f) for f, _ in split]
        times = sorted({self.T, *(self.T - _fmpq(late) for late, _, _ in ways)})
        self.ring, self.times = Exponentials(rows, times), times
        self.poles = [n for row, (_, n) in zip(rows, split, strict=True) for _ in range(len(row) - 1)]
        # s, exp(s t) and what is differentiated live in a ring of the same kind, with s a root of its own
        self.free = Exponentials([*rows, (0, 1)], times)

    def polynomial(self) -> tuple[Exponentials, list[Element]]:
        """In w, ascending, times a number that is not 0."""
        ring, one = self.ring, self.ring.constant(1)
        T = self.times.index(self.T)
        lines = [one - ring.w] + [one - ring.exponential(i, T) * ring.w for i in range(len(self.poles))]
        orders = [self.at_0 + 1, *self.poles]  # of G(s)/s; the samples of its sum are taken 1 - w times
        tops, scales = zip(*(self._residue(i, n) for i, n in enumerate(orders)), strict=True)
        total, common = ring.constant(0), one
        for x in scales:
            common = common * x
        for i, top in enumerate(tops):
            others = one
            for j, (line, n) in enumerate(zip(lines, orders, strict=True)):
                if j != i:
                    others = others * line**n * scales[j]
            total = total + top * others
        den = one
        for line, n in zip(lines, [self.at_0, *self.poles], strict=True):
            den = den * line**n
        above, below = (self._row(row) for row in self.controller)
        found = below * den * common + above * total
        return ring, _by_power(ring, found)

    def _row(self, coefficients: Numbers) -> Element:
        """A polynomial in w whose coefficients may hold pi."""
        total = self.ring.constant(0)
        for n, x in enumerate(coefficients):
            for term in x.expand().as_ordered_terms():
                number, rest = term.as_coeff_Mul()
                power = 0 if rest == 1 else int(rest.as_base_exp()[1])
                assert rest == pi**power
                total = total + self.ring.constant(_fmpq(number)) * self.ring.pi**power * self.ring.w**n
        return total

    def _residue(self, place: int, order: int) -> tuple[Element, Element]:
        """Of a pole, 0 or one of the roots: what stands over (1 - w exp(p T))^order, times a number, and that number."""
        free, count = self.free, len(self.poles)
        s, k = free.root(count), self.times.index(self.T)
        R = free.constant(self.lead)  # Q(s) s without the pole
        for j, n in enumerate([self.at_0 + 1, *self.poles]):
            if j != place:
                R = R * (s - (free.root(j - 1) if j else free.constant(0))) ** n
        line = free.constant(1) - free.exponential(count, k) * free.w
        top = self._above(s, count)
        scale = free.constant(1)
        for n in range(1, order):  # (top/(R line)^n)' = (top' R line - n top (R line)')/(R line)^(n + 1)
            below = R * line
            top = self._slope(top, count) * below - n * top * self._slope(below, count)
            scale = scale * n
        return self._put(top, place), self._put(scale * R**order, place)

    def _above(self, s: Element, count: int) -> Element:
        """Sum over the delays of N(s) exp(s (T - theta)) w^(l + 1)."""
        free, total = self.free, self.free.constant(0)
        for late, ell, above in self.ways:
            k = self.times.index(self.T - _fmpq(late))
            N = sum((self._number(x) * s**n for n, x in enumerate(above)), free.constant(0))
            total = total + N * free.exponential(count, k) * free.w ** (ell + 1)
        return total

    def _number(self, x: Expr) -> Element:
        total = self.free.constant(0)
        for term in x.expand().as_ordered_terms():
            number, rest = term.as_coeff_Mul()
            power = 0 if rest == 1 else int(rest.as_base_exp()[1])
            total = total + self.free.constant(_fmpq(number)) * self.free.pi**power
        return total

    def _slope(self, x: Element, count: int) -> Element:
        """d/ds, where s and its exponentials are the last root's."""
        free = self.free
        total = x.derivative(2 + count)
        for k, t in enumerate(self.times):
            place = 2 + count + 1 + count * len(self.times) + k
            total = total + t * free.exponential(count, k) * x.derivative(place)
        return total

    def _put(self, x: Element, place: int) -> Element:
        """At s = the pole, in the ring of the poles alone."""
        ring, count = self.ring, len(self.poles)
        at = ring.root(place - 1) if place else ring.constant(0)
        roots = [*(ring.root(i) for i in range(count)), at]
        own = [ring.exponential(place - 1, k) if place else ring.constant(1) for k in range(len(self.times))]
        exponentials = [ring.exponential(i, k) for i in range(count) for k in range(len(self.times))]
        return x.compose(ring.w, ring.pi, *roots, *exponentials, *own, ctx=ring.context)


def _whole(factor: fmpq_poly) -> tuple[int, ...]:
    """An irreducible polynomial with whole coefficients."""
    scale = lcm(*(int(c.q) for c in factor.coeffs()))
    return tuple(int((c * scale).p) for c in factor.coeffs())


def _by_power(ring: Exponentials, polynomial: Element) -> list[Element]:
    rows: dict[int, dict[tuple[int, ...], Any]] = {}
    for (n, *rest), value in monomials(polynomial):
        rows.setdefault(int(n), {})[(0, *map(int, rest))] = value
    return [ring.context.from_dict(rows.get(n, {})) for n in range(max(rows) + 1)]
