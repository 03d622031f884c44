"""From real functions to irreducible factors, each an exact polynomial or an analytic function.

From real functions to irreducible factors, each an exact polynomial or an analytic function.

Discriminants and resultants of polynomials with whole numbers and few further variables: by values modulo primes, exact.

An eliminant is taken modulo word-sized primes at the points of a grid, where its polynomials have one variable, then
interpolated, then put together by the Chinese remainder theorem. How many points and primes suffice is proven. Each term of
the discriminant of c_0 + ... + c_n x^n is a product of 2 n - 2 coefficients whose indices add up to n (n - 1); each term of the
resultant with d_0 + ... + d_m x^m is one of m coefficients c and n coefficients d, with indices that add up to n m. Hence, if
l(c_j) <= a + b j and l(d_j) <= a' + b j, where l is the degree in a further variable, or the logarithm of the sum of the
absolute values of all numbers in it, that of a term is at most (2 n - 2) a + n (n - 1) b, or m a + n a' + n m b.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import combinations, compress, count
from math import ceil, floor, gcd, inf, log2
from operator import index
from typing import Any, TypeAlias

import flint
from flint import arb, fmpq, fmpz, nmod_mat, nmod_poly
from sympy import Expr, Integer

from haptisym.kernel.analytic import AnalyticFactor, PeriodicFactor
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError
from haptisym.kernel.pieces import pieces, sign_between
from haptisym.kernel.polynomials import Level, PolynomialFactor, polynomial_factors
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials
from haptisym.kernel.waves import WaveTerm, vanishes
from haptisym.kernel.zeros import Factor, is_clear, sign_of

_SHORT = 16  # terms of a polynomial above the line for which known factors are tried first

Factored: TypeAlias = tuple[int, Expr, list[tuple[Factor, int]]]


@dataclass(frozen=True)
class Product:
    """A function as sign and powers: ``sign * omega^power * product of factor^exponent``."""

    sign: int
    power: Expr
    exponents: Mapping[Factor, int]


@dataclass(frozen=True, eq=False)
class Known:
    """What has been taken apart for one chart: denominators are mostly alike, or products of others' factors."""

    polynomials: list[tuple[Polynomial, Factored]] = field(default_factory=list)
    factors: list[tuple[Polynomial, Factor]] = field(default_factory=list)


def factored_function(function: RealFunction | Level, known: Known, *, in_square: bool = True) -> Product:
    """The function taken apart; ``known`` gathers what was on the way.

    ``in_square`` : whether even polynomials may be taken apart in omega^2. Of functions on one chart that must be the same, and
    only where all are even or odd: else one frequency might be the zero of two different factors.
    """
    if isinstance(function, Level):
        one = RealFunction(function.function.axis.one / _denominator(function.function))
        below = factored_function(one, known, in_square=in_square)
        return replace(below, exponents={**below.exponents, function.factor: 1})
    top, bottom = function.function.numerator, function.function.denominator
    if top.is_zero():
        return Product(0, Integer(0), {})
    sign, power, exponents = 1, Integer(0), Counter[Factor]()
    for polynomial, parts, direction in ((top, function.above, 1), (bottom, function.below, -1)):
        found = next((taken for other, taken in known.polynomials if other == polynomial), None)
        if found is None:
            found = _factored(
                polynomial, parts or (polynomial,), function.axis, known, in_square=in_square, is_below=direction < 0
            )
            known.polynomials.append((polynomial, found))
        own_sign, own_power, factors = found
        if own_sign == 0 and direction < 0:
            raise SceneError("division by zero")
        sign *= own_sign
        if own_power:
            power += direction * own_power
        for factor, exponent in factors:
            exponents[factor] += direction * exponent
    return Product(sign, power, {factor: n for factor, n in exponents.items() if n} if sign else {})


def _denominator(function: RealFunction) -> RationalFunction:
    return function.axis.function(function.function.denominator)


def is_even_or_odd(function: RealFunction | Level) -> bool:
    """Whether above and below the line there are even powers of omega alone, or odd ones alone."""
    f = function.function if isinstance(function, RealFunction) else function.function.function
    return all(int(p.deflation_index()[0][0]) % 2 == 0 for p in (f.numerator, f.denominator))


def _factored(
    polynomial: Polynomial,
    parts: Sequence[Polynomial],
    axis: Axis,
    known: Known,
    *,
    in_square: bool,
    is_below: bool,
) -> Factored:
    """Sign, power of omega and irreducible factors; half-angle tangents made homogeneous in cosine and sine.

    ``parts`` : polynomials of which it is the product, up to a number; it alone if none are known.
    The sign is 0 where a factor is zero at every frequency, as cos(2 pi/4) is, or omega^(1/2) omega^(1/2) - omega.
    """
    plain = axis.univariate(polynomial)
    if plain is not None and not axis.functions:
        own_sign, lowest, simple = polynomial_factors(plain, in_square=in_square)
        return own_sign, Integer(lowest), [*simple]
    # where sines meet odd powers of omega not all functions are even
    in_square = in_square and not axis.functions
    tried = [factor for factor, _ in known.factors] if axis.functions else []
    sign, own = pieces(parts, axis, tried, longest=inf if is_below else _SHORT, in_square=in_square)
    sign *= sign_between(polynomial, parts)
    power, found = Integer(0), list[tuple[Factor, int]]()
    for factor, exponent in own:
        exponents = _power_of_omega(factor, axis)
        if exponents is not None:
            power += exponent * exponents
            continue
        made = next((made for other, made in known.factors if other == factor), None)
        if made is None:
            made = _factor(factor, axis)
            if _seems_to_vanish(made, axis) and vanishes(factor, axis):
                return 0, Integer(0), []
            if (alike := _alike(factor, made, axis, known)) is not None:
                made = alike.factor
                sign *= alike.sign**exponent
            else:
                known.factors.append((factor, made))
        if not _changes(factor, axis):
            sign *= made.sign_at(lambda _: arb(1)) ** exponent
        else:
            found.append((made, exponent))
    cosines = [(_cosine(axis, i), -n) for i, n in enumerate(_turning(polynomial, axis)) if n]
    return sign, power, [*found, *cosines]


def _seems_to_vanish(factor: Factor, axis: Axis) -> bool:
    """Whether it may be zero at every frequency, as far as one of them tells: rational powers of omega may cancel."""
    if not axis.orders or not all(x.is_Rational for x in axis.orders):
        return False
    with flint.ctx.workprec(128):
        shown = isinstance(factor, AnalyticFactor) and factor.shows_itself
        return not shown and not is_clear(factor.value(arb(1.25)))


@dataclass(frozen=True)
class _Alike:
    """A known factor, and the sign of the number by which it is multiplied."""

    factor: Factor
    sign: int


def _alike(factor: Polynomial, made: Factor, axis: Axis, known: Known) -> _Alike | None:
    """The known factor of which one is a multiple, as omega^(1/2) cos(pi/4) - 1 is of omega^(1/2) sin(pi/4) - 1.

    In the ring cosine and sine of the angle of a power of s are free of each other; that they are not is looked at here, so
    that different factors do not share all their zeros.
    """
    if not axis.orders or not _changes(factor, axis):
        return None
    for other, taken in known.factors:
        if (
            _turning(other, axis) == _turning(factor, axis)
            and (sign := _seeming_sign(made, taken))
            and not vanishes(own := _leading(other, axis), axis)
            and vanishes(factor * own - other * _leading(factor, axis), axis)
        ):
            return _Alike(taken, sign)
    return None


def _seeming_sign(factor: Factor, other: Factor) -> int:
    """The sign of the quotient of two factors, if it seems to be the same number at two frequencies; else 0."""
    with flint.ctx.workprec(128):
        (a, b), (c, d) = ((f.value(arb(1.25)), f.value(arb(2.75))) for f in (factor, other))
        return 0 if is_clear(a * d - b * c) else sign_of(a * c)


def _leading(polynomial: Polynomial, axis: Axis) -> Polynomial:
    """What stands before the highest power of omega, and of the tangents that turn."""
    found: dict[tuple[Expr, tuple[int, ...]], dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(polynomial):
        power, of_pi, *own = map(int, exponents)
        waves, powers = own[axis.size - 2 :][: len(axis.angles)], own[axis.size - 2 + len(axis.angles) :]
        still = [n if angle.constant else 0 for n, angle in zip(waves, axis.angles, strict=True)]
        raised = sum((x * n for x, n in zip(axis.orders, powers, strict=True)), Integer(power))
        turning = tuple(n - m for n, m in zip(waves, still, strict=True))
        group, key = (
            found.setdefault((raised, turning), {}),
            (0, of_pi, *own[: axis.size - 2], *still, *[0] * len(powers)),
        )
        group[key] = group.get(key, 0) + value
    return axis.context.from_dict(found[max(found)])


def _power_of_omega(factor: Polynomial, axis: Axis) -> Expr | None:
    """The exponent of a factor that is omega or omega^alpha itself; None for any other factor."""
    if len(factor) > 1:
        return None
    if factor == axis.variable:
        return Integer(1)
    for order, generator in zip(axis.orders, axis.context.gens()[axis.size + len(axis.angles) :], strict=True):
        if factor == generator:
            return order
    return None


def _changes(factor: Polynomial, axis: Axis) -> bool:
    """Whether a factor changes with omega: by omega itself, by an angle of a delay or by a power omega^alpha."""
    degrees = [int(n) for n in factor.degrees()]
    return bool(degrees[0]) or any(_turning(factor, axis)) or any(degrees[axis.size + len(axis.angles) :])


def _turning(polynomial: Polynomial, axis: Axis) -> list[int]:
    """The degree in the half-angle tangent of each angle, 0 for the constant ones."""
    degrees = [int(n) for n in polynomial.degrees()[axis.size :]]
    return [0 if angle.constant else n for angle, n in zip(axis.angles, degrees, strict=False)]


def _factor(factor: Polynomial, axis: Axis) -> Factor:
    """An irreducible polynomial of the axis as a factor."""
    degrees = [int(n) for n in factor.degrees()]
    return _analytic_factor(factor, axis) if any(degrees[axis.size :]) else _polynomial_factor(factor)


def _polynomial_factor(factor: Polynomial) -> PolynomialFactor:
    rows = _rows([(index(e[0]), index(e[1]), index(c.p)) for e, c in monomials(factor)])
    even = not any(any(row) for row in rows[1::2])
    return PolynomialFactor(rows[::2] if even else rows, 2 if even else 1)


def _rows(terms: Sequence[tuple[int, int, int]]) -> tuple[tuple[int, ...], ...]:
    """Coefficients of ascending powers of omega, each as the coefficients of ascending powers of pi; given are both powers."""
    rows: list[tuple[int, ...]] = [_NONE] * (max(terms)[0] + 1)
    for power, of_pi, value in terms:
        if of_pi or rows[power] is not _NONE:
            row = rows[power] + (0,) * (of_pi + 1 - len(rows[power]))
            rows[power] = (*row[:of_pi], value, *row[of_pi + 1 :])
        else:
            rows[power] = (value,)
    return tuple(rows)


_NONE = (0,)


def _analytic_factor(factor: Polynomial, axis: Axis) -> AnalyticFactor:
    angles, first = len(axis.angles), axis.size
    groups: dict[tuple[int, ...], list[tuple[int, int, int]]] = {}
    tick()
    for exponents, value in monomials(factor):
        groups.setdefault(exponents[first:], []).append((index(exponents[0]), index(exponents[1]), index(value.p)))
    sums = sorted([(tuple(map(index, waves)), _rows(found)) for waves, found in groups.items()])
    terms = tuple([WaveTerm(waves[:angles], waves[angles:], rows) for waves, rows in sums])
    return _made(terms, tuple(map(int, factor.degrees()[first : first + angles])), axis)


def _cosine(axis: Axis, index: int) -> AnalyticFactor:
    """The cosine of a half angle, which homogeneous forms of different degrees leave behind."""
    degrees = tuple(int(i == index) for i in range(len(axis.angles)))
    return _made((WaveTerm((0,) * len(axis.angles), (0,) * len(axis.orders), ((1,),)),), degrees, axis)


def _made(terms: tuple[WaveTerm, ...], degrees: tuple[int, ...], axis: Axis) -> AnalyticFactor:
    """The factor, of the kind that knows most about its zeros; angles that it does not hold are none of its."""
    angles = list(compress(axis.angles, degrees))
    shorter = terms
    if len(angles) < len(degrees):
        shorter = tuple([WaveTerm(tuple(compress(x.turns, degrees)), x.powers, x.coefficients) for x in terms])
    alone = len(angles) == 1 and not angles[0].constant
    kind = PeriodicFactor if alone and all(map(_is_rational, terms)) else AnalyticFactor
    rates = tuple([(angle.rate, angle.constant) for angle in angles])
    return kind(shorter, rates, tuple(compress(degrees, degrees)), axis.orders)


def _is_rational(term: WaveTerm) -> bool:
    """Whether it is a rational number times sines and cosines."""
    return len(term.coefficients) == 1 and len(term.coefficients[0]) == 1 and not any(term.powers)


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
        polynomials = [_rows_in_eliminants(p, main, others, (first, second)) for p in given]
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


def _rows_in_eliminants(p: Polynomial, main: int, others: Sequence[int], strides: _Pair) -> _Rows:
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
