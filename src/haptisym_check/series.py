"""Taylor's sums with sines, cosines and powers of omega (rules 7 and 8)."""

from fractions import Fraction
from functools import lru_cache, reduce
from itertools import accumulate
from math import factorial
from operator import mul
from typing import Any

from haptisym_check.balls import BITS, SCALE, Ball, circle, parts, power
from haptisym_check.link import Numbers
from haptisym_check.polynomials import PI

ORDER = 14
Series = tuple[list[int], int]
"""Coefficients of v^n, n from 0 to ORDER, in parts of one, and a bound of the sum of all their errors."""
Terms = list[tuple[tuple[int, ...], list[Ball]]]
"""Products of powers (as of ``Place``), each with the coefficients of a polynomial in omega."""


def times(p: Series, q: Series) -> Series:
    """Leibniz: the coefficients of a product; those of p may be fewer."""
    (a, r), (b, s) = p, q
    lost = (sum(map(abs, a)) + r) * s + r * sum(map(abs, b))  # |p q - a b| <= |p| |q - b| + |p - a| |b|
    return [sum(map(mul, a, b[n::-1])) >> BITS for n in range(len(b))], (lost >> BITS) + 1 + len(b)


def plus(p: Series, q: Series) -> Series:
    """The coefficients of a sum."""
    return [x + y for x, y in zip(p[0], q[0], strict=True)], p[1] + q[1]


def waves(turns: list[int], ahead: Fraction, count: int) -> list[Series]:
    """Of the sine and the cosine of an angle + ahead v, from its ``circle``, or from the largest sizes of that."""
    x, y = ahead.as_integer_ratio()
    weights = [(x**n << BITS) // (y**n * factorial(n)) for n in range(count)]
    lost = 2 * (sum(weights) >> BITS) + 2 + 2 * count
    return [([turns[(n + i) % 4] * w >> BITS for n, w in enumerate(weights)], lost) for i in (3, 0)]


def binomial(alpha: Fraction, low: Fraction, high: Fraction, step: Fraction, count: int) -> Series:
    """Of omega^alpha at a number, or of the sizes from low to high; of h^alpha from 0 on."""
    ahead = step / low if low else Fraction(0)
    weights = list(accumulate(range(1, count), lambda w, n: w * (alpha - n + 1) * ahead / n, initial=Fraction(1)))
    (first, lost), (own, more) = power(high if low else step, alpha), power(low or step, alpha)
    later = [own * w.numerator // w.denominator for w in weights[1:]]
    errors = lost + int(more * sum(map(abs, weights))) + 1 + count
    return [first, *(map(abs, later) if low < high else later)], errors


class Place:
    """Powers of omega, sines, cosines, Re and Im of (j omega)^alpha, as series with the step h: at a number, or from low to high,
    where coefficients are the largest sizes of theirs. From 0 on the last two are those of h: before them is a power of omega/h.
    """

    def __init__(self, delays: Numbers, orders: Numbers, low: Fraction, high: Fraction, step: Fraction) -> None:
        count = ORDER + 1 if step else 1
        rest = [0] * (count - 1)
        self.own: list[Series] = [([parts(high), parts(step)][:count], 2)]
        for rate in (tau / 2 for tau in delays):
            self.own += waves([SCALE] * 4 if low < high else circle(high * rate), step * rate, count)
        for alpha in orders:
            size, turns = binomial(alpha, low, high, step, count), circle(alpha * Fraction(*PI[0]) / 2)
            self.own += [times(size, ([x, *rest], 3)) for x in turns[::3]]
        self.none = (0,) * len(self.own)
        self.known: dict[tuple[int, ...], Series] = {self.none: ([SCALE, *rest], 0)}
        self.tables: dict[int, tuple[Any, ...]] = {}

    def product(self, powers: tuple[int, ...]) -> Series:
        """Of omega (first), of a sine, its cosine, the next sine, ..., a real part, its imaginary part, ..., to these powers."""
        if powers not in self.known:
            i = max(i for i, n in enumerate(powers) if n)
            self.known[powers] = times(self.own[i], self.product((*powers[:i], powers[i] - 1, *powers[i + 1 :])))
        return self.known[powers]

    def polynomial(self, p: list[Ball]) -> Series:
        """In omega."""
        if len(p) not in self.tables:
            rows, errors = zip(*(self.product((n, *self.none[1:])) for n in range(len(p))), strict=True)
            sizes = [sum(map(abs, row)) + lost for row, lost in zip(rows, errors, strict=True)]
            self.tables[len(p)] = list(zip(*rows, strict=True)), errors, sizes
        columns, errors, sizes = self.tables[len(p)]
        middles, radii = zip(*p, strict=True)
        lost = sum(map(mul, map(abs, middles), errors)) + sum(map(mul, radii, sizes))
        return [sum(map(mul, middles, x)) >> BITS for x in columns], (lost >> BITS) + 1 + len(columns)

    def total(self, terms: Terms) -> Series:
        """Of their sum."""
        return reduce(plus, (times(self.polynomial(p), self.product(powers[: len(self.own)])) for powers, p in terms))


place = lru_cache(maxsize=8)(Place)
