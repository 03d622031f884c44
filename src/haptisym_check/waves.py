"""Rules 7 and 8: signs of factors with sines, cosines and powers of omega, from Taylor's sums and his remainder."""

from collections.abc import Callable
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import accumulate, groupby, repeat
from math import ceil, factorial, lcm
from typing import Any

from haptisym_check.balls import (
    ORDER,
    SCALE,
    Ball,
    Series,
    binomial,
    circle,
    hull,
    in_pi,
    plus,
    power,
    rounded,
    scaled,
    times,
)
from haptisym_check.link import Numbers
from haptisym_check.polynomials import PI, Factor, moved, pairs
from haptisym_check.reading import Polynomial, keyed, listed, polynomial, whole
from haptisym_check.values import need

Terms = list[tuple[tuple[int, ...], Polynomial]]


class Place:
    """Powers of omega, sines, cosines, Re and Im of (j omega)^alpha, as series with the step h, wherever from low to high.

    From 0 on the last two are those of h: what is before them is a power of omega/h.
    """

    def __init__(self, delays: Numbers, orders: Numbers, low: Fraction, high: Fraction, step: Fraction) -> None:
        middle, radius = (low + high) / 2, ceil((high - low) * SCALE / 2)
        one, zero = (SCALE, 0), (0, 0)
        start, ahead = (rounded(x.numerator * SCALE, 0, x.denominator) for x in (middle, step))
        self.first = [one, *[zero] * ORDER]
        self.own = [[(start[0], start[1] + radius), ahead, *[zero] * (ORDER - 1)]]
        for rate in (tau / 2 for tau in delays):
            (c, d), (s, t) = ((m, r + ceil(radius * rate)) for m, r in circle(middle * rate))  # no slope is above 1
            turns = [(c, d), (-s, t), (-c, d), (s, t)]
            weights = [(step * rate) ** n / factorial(n) for n in range(ORDER + 1)]
            self.own += [[scaled(turns[(n + i) % 4], w) for n, w in enumerate(weights)] for i in (3, 0)]
        for alpha in orders:
            ends = (binomial(alpha, step, x) for x in (low, high))
            size = list(map(hull, *ends)) if low else [power(step, alpha), *[zero] * ORDER]
            self.own += [times(size, [(m, r + 1), *[zero] * ORDER]) for m, r in circle(alpha * Fraction(*PI[0]) / 2)]
        self.known: dict[tuple[int, int], Series] = {}

    def power(self, i: int, n: int) -> Series:
        """Of omega (0), then of a sine, its cosine, the next sine, ..., a real part, its imaginary part, ...."""
        if n and (i, n) not in self.known:
            self.known[i, n] = times(self.own[i], self.power(i, n - 1))
        return self.known[i, n] if n else self.first


place = lru_cache(maxsize=8)(Place)


class WaveFactor(Factor):
    """A sum of polynomials in omega times powers of sines and cosines to a common degree, and of Re and Im of (j omega)^alpha."""

    def __init__(self, x: Any, delays: Numbers, orders: Numbers = ()) -> None:
        waves, terms = keyed(x, "waves", "terms")
        n, rows, self.delays, self.orders = (
            len(delays),
            [listed(row, 2, 2) for row in listed(terms, 300, 1)],
            delays,
            orders,
        )
        self.waves = tuple(whole(k, 0, 40) for k in listed(waves, n, n))
        most = [*self.waves, *[40] * (2 * len(orders))]
        self.terms = [
            (tuple(map(whole, listed(turns, len(most), len(most)), repeat(0), most)), polynomial(p))
            for turns, p in rows
        ]
        need(len({turns for turns, _ in self.terms}) == len(rows), "a term stands twice in a factor")
        self.powers = any(k for turns, _ in self.terms for k in turns[n:])
        sizes = [max(c.bit_length() for c in row) + len(row) + 40 for _, p in self.terms for row in p]
        self.cost = (sum(sizes) + 500 * len(rows) * (1 + sum(self.degrees[2:]))) * 2
        need(self.cost < 10**7, "a factor is too large")

    def series(self, terms: Terms, at: Place, number: Callable[[list[int]], Ball] = in_pi) -> Series:
        """``number`` : what a coefficient is, with pi in it."""
        total, count = [(0, 0)] * (ORDER + 1), len(self.delays)
        for turns, p in terms:
            term = [(0, 0)] * (ORDER + 1)
            for n, (a, b) in enumerate(map(number, p)):
                term = plus(term, [rounded(a * c, abs(a) * d + b * (abs(c) + d), SCALE) for c, d in at.power(0, n)])
            both = [n for k, most in zip(turns, self.waves, strict=False) for n in (k, most - k)]
            for i, n in enumerate((both + list(turns[count:]))[: len(at.own) - 1], 1):
                term = times(term, at.power(i, n))
            total = plus(total, term)
        return total

    @cached_property
    def beginnings(self) -> list[tuple[Fraction, Terms, list[bool]]]:
        """The terms with each power of omega that is not whole, and which of Taylor's coefficients are not zero beside it at 0.

        With a step that makes all angles whole numbers coefficients are exact; each power of pi in them is looked at alone.
        """
        step = Fraction(2 * lcm(*(tau.denominator for tau in self.delays)))
        here, found = place(self.delays, (), Fraction(0), Fraction(0), step), []
        for powers, rows in groupby(sorted(self.terms, key=self.raised), self.raised):
            terms = list(rows)
            width = max(len(row) for _, p in terms for row in p)
            alone = [self.series(terms, here, lambda row, i=i: (sum(row[i : i + 1]) * SCALE, 0)) for i in range(width)]  # type: ignore[misc]
            exponent = sum((a * (k + m) for a, (k, m) in zip(self.orders, pairs(powers), strict=True)), Fraction(0))
            found.append((exponent, terms, [any(map(any, column)) for column in zip(*alone, strict=True)]))
        return found

    def raised(self, term: tuple[tuple[int, ...], Polynomial]) -> tuple[int, ...]:
        """Its exponents of Re and Im of powers."""
        return term[0][len(self.delays) :]

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        if not a:
            return self.signs_from_0(b)
        model = self.model(self.terms, a, b)
        if found := side(model):
            return 0, [found]
        need(side([(n * c, n * d) for n, (c, d) in enumerate(model)][1:]), "a sign stays open")
        return 0, [strict(model[:1]), strict(model)]

    def model(self, terms: Terms, a: Fraction, b: Fraction) -> Series:
        """Its sum of c_n v^n is theirs, v from 0 to 1 (Lagrange)."""
        here, there = (self.series(terms, place(self.delays, self.orders, a, x, b - a)) for x in (a, b))
        return [*here[:-1], there[-1]]

    def signs_from_0(self, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """A sum of c v^e, v from 0 to 1, has one sign if all of its partial sums have, from the lowest e on (Abel)."""
        total = dict[Fraction, Ball]()
        for exponent, terms, there in self.beginnings:
            for n, (c, d) in enumerate(self.model(terms, Fraction(0), b)):
                if there[n] or n == ORDER:
                    x, y = total.get(exponent + n, (0, 0))
                    total[exponent + n] = x + c, y + d
        sums = [strict(row) for row in accumulate([total[e]] for e in sorted(total))]
        need(len(set(sums)) == 1, "a sign stays open")
        return min(total), sums[:1]

    def sign(self, x: Fraction) -> int:
        """Of its value at a rational number; refused where its bounds do not tell."""
        return strict(self.series(self.terms, place(self.delays, self.orders, x, x, Fraction(0))))


def side(model: Series) -> int:
    """The sign for all v from 0 to 1, if Bernstein's coefficients show it."""
    low, high = (moved([c + way * d for c, d in model], (0, 1), (1, 1)) for way in (-1, 1))
    return all(x > 0 for x in low) - all(x < 0 for x in high)


def strict(model: Series) -> int:
    """The sign of a sum."""
    middle, radius = (sum(column) for column in zip(*model, strict=True))
    need(abs(middle) > radius, "a sign stays open")
    return 1 if middle > 0 else -1


def polynomial_factor(x: Any, delays: Numbers = (), orders: Numbers = ()) -> Factor:
    """One without sines and powers."""
    step, rows = keyed(x, "step", "polynomial")
    return Factor(polynomial(rows), whole(step, 1, 2), len(delays), len(orders))


def factor_of(x: Any, delays: Numbers, orders: Numbers) -> Factor:
    """Of a proof."""
    return (WaveFactor if isinstance(x, dict) and "waves" in x else polynomial_factor)(x, delays, orders)
