"""Discriminants and resultants of polynomials with whole numbers and few further variables: by values modulo primes, exact.

An eliminant is taken modulo word-sized primes at the points of a grid, where its polynomials have one variable, then
interpolated, then put together by the Chinese remainder theorem. How many points and primes suffice is proven. Each term of
the discriminant of c_0 + ... + c_n x^n is a product of 2 n - 2 coefficients whose indices add up to n (n - 1); each term of the
resultant with d_0 + ... + d_m x^m is one of m coefficients c and n coefficients d, with indices that add up to n m. Hence, if
l(c_j) <= a + b j and l(d_j) <= a' + b j, where l is the degree in a further variable, or the logarithm of the sum of the
absolute values of all numbers in it, that of a term is at most (2 n - 2) a + n (n - 1) b, or m a + n a' + n m b.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import combinations, count
from math import ceil, floor, gcd, log2
from typing import Any, TypeAlias

from flint import fmpq, fmpz, nmod_mat, nmod_poly

from haptisym.kernel.budget import tick
from haptisym.kernel.rings import Polynomial

_Pair: TypeAlias = tuple[int, int]
_Eliminant: TypeAlias = Callable[[Sequence[nmod_poly]], Any]
_Rows: TypeAlias = list[dict[_Pair, int]]
"""For each power of the variable to be eliminated, numbers by the exponents of the two others."""


def discriminant(f: Polynomial, main: int) -> Polynomial:
    """The discriminant in the variable of that number; the polynomial has whole coefficients and degree 2 or more in it.

    >>> from flint import Ordering, fmpq_mpoly_ctx
    >>> x, b, c = fmpq_mpoly_ctx.get(("x", "b", "c"), Ordering.lex).gens()
    >>> discriminant(x**2 + b*x + c, 0)
    b^2 - 4*c
    """
    n = int(f.degrees()[main])
    task = _Task.of([f], main, [2 * n - 2], n * (n - 1))
    if task is None:
        return f.discriminant(main)
    # Sylvester's matrix, its first column over c_n: n - 1 rows of n + 1 coefficients, n rows whose factors add up to n (n + 1)/2
    spread = (n - 1) * log2(n + 1) + n * log2(n * (n + 1) / 2)
    return task.solved(spread, lambda polynomials: polynomials[0].discriminant())


def resultant(f: Polynomial, g: Polynomial, main: int) -> Polynomial:
    """The resultant in the variable of that number; the polynomials have whole coefficients and degree 1 or more in it.

    >>> from flint import Ordering, fmpq_mpoly_ctx
    >>> x, b, c = fmpq_mpoly_ctx.get(("x", "b", "c"), Ordering.lex).gens()
    >>> resultant(x**2 + b, x - c, 0)
    b + c^2
    """
    n, m = (int(p.degrees()[main]) for p in (f, g))
    task = _Task.of([f, g], main, [m, n], n * m)
    if task is None:
        return f.resultant(g, main)
    return task.solved(m * log2(n + 1) + n * log2(m + 1), lambda polynomials: polynomials[0].resultant(polynomials[1]))


_LEAST_WEIGHT = {1: 100, 2: 20}  # by the number of further variables: below, polynomial arithmetic is faster


@dataclass(frozen=True)
class _Task:
    """Polynomials by the powers of what is eliminated; how many coefficients of each a term has, and the sum of their indices.

    ``others``: the numbers of the two further variables, and ``strides`` what all their exponents are multiples of.
    """

    context: Any  # flint.fmpq_mpoly_ctx, which ships no types
    polynomials: list[_Rows]
    others: _Pair
    strides: _Pair
    counts: Sequence[int]
    weight: int

    @classmethod
    def of(cls, given: Sequence[Polynomial], main: int, counts: Sequence[int], weight: int) -> _Task | None:
        """None where FLINT's own way is faster, or where there are more further variables than two."""
        every = [i for i in range(len(given[0].degrees())) if i != main]
        others = [i for i in every if any(p.degrees()[i] for p in given)]
        if len(others) not in _LEAST_WEIGHT or weight < _LEAST_WEIGHT[len(others)]:
            return None
        if len(others) == 1:
            idle = [i for i in every if i not in others]
            if not idle:
                return None
            others.append(idle[0])
        exponents = [e for p in given for e in p.monoms()]
        first, second = (reduce(gcd, (int(e[i]) for e in exponents)) or 1 for i in others)
        polynomials = [_rows(p, main, others, (first, second)) for p in given]
        return cls(given[0].context(), polynomials, (others[0], others[1]), (first, second), counts, weight)

    def solved(self, spread: float, eliminant: _Eliminant) -> Polynomial:
        """``spread``: the logarithm of how many terms there are at most, with what stands before them."""
        sizes = (
            1 + floor(self._most(lambda c: max(i for i, _ in c))),
            1 + floor(self._most(lambda c: max(j for _, j in c))),
        )
        bits = 2 + ceil(spread) + ceil(self._most(lambda c: sum(map(abs, c.values())).bit_length()))
        if min(sizes) < 1:  # no term has a degree of 0 or more: there is none
            return self.context.constant(0)
        total, modulus = [0] * (sizes[0] * sizes[1]), 1
        primes = _primes()
        while modulus.bit_length() <= bits:
            tick(modulus.bit_length(), bits, "resultants")
            p = next(primes)
            step = pow(modulus, -1, p)
            found = self._modulo(p, sizes, eliminant)
            total = [x + modulus * ((r - x) * step % p) for x, r in zip(total, found, strict=True)]
            modulus *= p
        return self._polynomial([x - modulus if 2 * x > modulus else x for x in total], sizes[1])

    def _most(self, size: Callable[[Mapping[_Pair, int]], int]) -> Fraction:
        """The most that a size that adds up in products can be in a term."""
        rows = [[(j, Fraction(size(c))) for j, c in enumerate(p) if c] for p in self.polynomials]
        slopes = {Fraction(0)} | {(y - x) / (j - i) for row in rows for (i, x), (j, y) in combinations(row, 2)}
        return min(
            self.weight * b + sum(n * max(x - b * j for j, x in row) for n, row in zip(self.counts, rows, strict=True))
            for b in slopes
        )

    def _modulo(self, p: int, sizes: _Pair, eliminant: _Eliminant) -> list[int]:
        """The coefficients of the eliminant modulo a prime, from its values on a grid where no degree falls."""
        for start in count(1):
            left, right = (_vandermonde(start, n, n, p) for n in sizes)
            tables = [self._tables(rows, start, sizes, p) for rows in self.polynomials]
            if all(all(table[-1]) for table in tables):
                break
        columns = [list(zip(*table, strict=True)) for table in tables]
        values = [int(eliminant([nmod_poly(list(c), p) for c in at])) for at in zip(*columns, strict=True)]
        solved = left.inv() * nmod_mat(*sizes, values, p) * right.inv().transpose()
        return [int(x) for x in solved.entries()]

    def _tables(self, rows: _Rows, start: int, sizes: _Pair, p: int) -> list[list[int]]:
        """The values of each coefficient on the grid."""
        height, width = (1 + max(e[i] for c in rows for e in c) for i in (0, 1))
        down, across = _vandermonde(start, sizes[0], height, p), _vandermonde(start, sizes[1], width, p).transpose()
        tables = []
        for c in rows:
            block = nmod_mat(height, width, p)
            for (i, j), value in c.items():
                block[i, j] = value % p
            tables.append([int(x) for x in (down * block * across).entries()])
        return tables

    def _polynomial(self, values: Sequence[int], width: int) -> Polynomial:
        terms = {}
        size = len(self.context.names())
        for n, value in enumerate(values):
            if value:
                exponents = [0] * size
                for i, power, stride in zip(self.others, divmod(n, width), self.strides, strict=True):
                    exponents[i] = power * stride
                terms[tuple(exponents)] = fmpq(value)
        return self.context.from_dict(terms)


def _rows(p: Polynomial, main: int, others: Sequence[int], strides: _Pair) -> _Rows:
    rows: _Rows = [{} for _ in range(int(p.degrees()[main]) + 1)]
    for exponents, value in zip(p.monoms(), p.coeffs(), strict=True):
        assert value.q == 1
        i, j = (int(exponents[place]) // stride for place, stride in zip(others, strides, strict=True))
        rows[int(exponents[main])][i, j] = int(value.p)
    return rows


@lru_cache(maxsize=256)
def _vandermonde(start: int, points: int, powers: int, p: int) -> nmod_mat:
    """The powers 1, x, x^2, ... of x = start, start + 1, ..."""
    return nmod_mat(points, powers, [pow(x, n, p) for x in range(start, start + points) for n in range(powers)], p)


def _primes() -> Iterator[int]:
    """Primes of 62 bits, descending."""
    return (n for n in count((1 << 62) - 1, -2) if fmpz(n).is_prime())
