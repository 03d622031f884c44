"""Exact numbers made of exponentials: polynomials in algebraic numbers p, in exp(p t) at rational times t, and in pi.

By Lindemann and Weierstrass exponentials of different algebraic numbers are linearly independent over the algebraic numbers. So
such a number is 0 only if it is so once equal exponents are collected, which is a question about algebraic numbers alone; and
those are decided by how near to 0 a number of their size can be without being it. pi stands for itself, as an unknown would.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, lru_cache
from math import factorial, prod
from typing import Any, TypeAlias

import flint
from flint import Ordering, acb, arb, fmpq, fmpq_mpoly_ctx, fmpz_poly

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.monomials import monomials

Element: TypeAlias = Any  # flint.fmpq_mpoly, which ships no types
Exponent: TypeAlias = tuple[fmpq, ...]

_MOST_BITS = 1 << 19  # of the precision at which an algebraic number of some degree is known to be 0


class Exponentials:
    """Q[w, pi, p_1, ..., exp(p_1 t_1), ...] over the roots p_i of irreducible polynomials with whole coefficients (ascending).

    >>> ring = Exponentials([(1, 1)], [fmpq(1, 2), fmpq(1)])                # p = -1
    >>> half, whole = ring.exponential(0, 0), ring.exponential(0, 1)
    >>> ring.is_zero(half * half - whole), ring.is_zero(half - whole)
    (True, False)
    >>> ring = Exponentials([(-2, 0, 1)], [fmpq(1)])                        # +- sqrt 2
    >>> ring.is_zero(ring.exponential(0, 0) * ring.exponential(1, 0) - 1), ring.is_zero(ring.root(0) ** 2 - 2)
    (True, True)
    """

    def __init__(self, factors: Sequence[tuple[int, ...]], times: Sequence[fmpq]) -> None:
        self.factors, self.times = tuple(factors), tuple(times)
        self.owner = [i for i, f in enumerate(factors) for _ in range(len(f) - 1)]
        count = len(self.owner)
        names = ["w", "pi", *(f"p{i}" for i in range(count))]
        names += [f"e{i}_{k}" for i in range(count) for k in range(len(times))]
        self.context = fmpq_mpoly_ctx.get(tuple(names), Ordering.lex)
        self.gens = self.context.gens()

    @property
    def w(self) -> Element:
        """An unknown, in which polynomials may be written."""
        return self.gens[0]

    @property
    def pi(self) -> Element:
        """The generator that stands for pi."""
        return self.gens[1]

    def constant(self, value: Any) -> Element:
        """A rational number."""
        return self.context.constant(value)

    def root(self, i: int) -> Element:
        """The generator that stands for the i-th algebraic number."""
        return self.gens[2 + i]

    def exponential(self, i: int, k: int) -> Element:
        """exp(p_i t_k)."""
        return self.gens[2 + len(self.owner) + i * len(self.times) + k]

    def is_zero(self, x: Element) -> bool:
        """Whether an element without w is 0, exactly but for pi, which is taken as an unknown."""
        groups: list[tuple[int, Exponent, Element]] = []
        for power, exponent, term in self._terms(x):
            place = next((i for i, (n, e, _) in enumerate(groups) if n == power and self._same(e, exponent)), None)
            if place is None:
                groups.append((power, exponent, term))
            else:
                groups[place] = (*groups[place][:2], groups[place][2] + term)
        return all(self._vanishes(total) for _, _, total in groups)

    def _terms(self, x: Element) -> Iterator[tuple[int, Exponent, Element]]:
        """Power of pi, exponent over the roots and what stands before it, of each term."""
        count, size = len(self.owner), len(self.times)
        for powers, value in monomials(x):
            own = [int(n) for n in powers]
            late = own[2 + count :]
            exponent = tuple(
                sum((late[i * size + k] * t for k, t in enumerate(self.times)), fmpq(0)) for i in range(count)
            )
            yield own[1], exponent, self.context.from_dict({(0, 0, *own[2 : 2 + count], *[0] * len(late)): value})

    def _same(self, one: Exponent, other: Exponent) -> bool:
        if one == other:
            return True
        apart = sum(((a - b) * self.root(i) for i, (a, b) in enumerate(zip(one, other, strict=True))), self.constant(0))
        return self._vanishes(apart)

    def _vanishes(self, f: Element) -> bool:
        """Whether a polynomial in the roots is 0: by a bound below which no other algebraic number of its size can be."""
        if f.is_constant():
            return bool(f.is_zero())
        with flint.ctx.workprec(128):
            if not self._value(f).contains(0):
                return False
        bits = self._gap(f)
        if bits > _MOST_BITS:
            raise UndecidedError("whether an algebraic number of high degree is 0")
        with flint.ctx.workprec(bits + 64):
            value = self._value(f)
            while value.contains(0) and value.abs_upper() > arb(2) ** -bits:
                flint.ctx.prec *= 2
                value = self._value(f)
            return bool(value.contains(0))

    def _gap(self, f: Element) -> int:
        """n such that |f| is 0 or above 2^-n: times A it is an algebraic integer, whose conjugates multiply to a whole number."""
        conjugates = prod(factorial(len(q) - 1) for q in self.factors)
        degrees = [int(n) for n in f.degrees()[2 : 2 + len(self.owner)]]
        common = prod({int(c.q) for c in f.coeffs()})
        scale = common * prod(abs(self.factors[j][-1]) ** n for j, n in zip(self.owner, degrees, strict=True))
        sizes = [1 + max(abs(c) for c in q[:-1]) // abs(q[-1]) + 1 for q in self.factors]
        size = sum((abs(int(c.p)) // int(c.q) + 1) for c in f.coeffs())
        size *= prod(sizes[j] ** n for j, n in zip(self.owner, degrees, strict=True))
        bits: int = (conjugates - 1) * (scale * size).bit_length() + int(scale).bit_length() + 1
        return bits

    def _value(self, f: Element) -> Any:
        roots = self._roots(flint.ctx.prec)
        total = acb(0)
        for powers, value in monomials(f):
            total += acb(arb(value)) * prod(
                (z ** int(n) for z, n in zip(roots, powers[2:], strict=False) if n), start=acb(1)
            )
        return total

    @cached_property
    def _roots(self) -> Callable[[int], tuple[Any, ...]]:
        """From a precision to balls around the roots, always in the same order."""
        first = [_roots_of(q, 128) for q in self.factors]

        @lru_cache(maxsize=8)
        def at(bits: int) -> tuple[Any, ...]:
            found: list[Any] = []
            for q, known in zip(self.factors, first, strict=True):
                finer = _roots_of(q, max(bits, 128))
                found += [next(z for z in finer if z.overlaps(own)) for own in known]
            return tuple(found)

        return at


def _roots_of(factor: tuple[int, ...], bits: int) -> list[Any]:
    """Balls around the roots of an irreducible polynomial, no two of which meet."""
    with flint.ctx.workprec(bits):
        return [acb(z) for z, _ in fmpz_poly(list(factor)).complex_roots()]
