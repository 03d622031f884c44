"""Rule 7: signs of factors with sines and cosines of omega tau/2, from Taylor's sums and his remainder."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from math import ceil, factorial, lcm
from typing import Any

from haptisym_check.polynomials import PI, Factor, moved
from haptisym_check.reading import keyed, listed, polynomial, whole
from haptisym_check.scene import need

ORDER = 14
SCALE = (
    factorial(ORDER) * 10**70
)  # numbers are told in such parts of one: coefficients of whole numbers over factorials are exact
Ball = tuple[int, int]
"""All numbers within a radius of a middle, both in parts of one."""
Series = list[Ball]
"""Balls that hold h^n f^(n)/n!, n from 0 to ORDER, wherever in an interval."""


def rounded(middle: int, radius: int, by: int) -> Ball:
    """A ball over a positive number."""
    found, rest = divmod(middle, by)
    return found, -(-radius // by) + (rest != 0)


def times(p: Series, q: Series) -> Series:
    """Leibniz: the coefficients of a product."""
    found = []
    for n in range(len(p)):
        pairs = [(*x, *y) for x, y in zip(p[: n + 1], q[n::-1], strict=True) if any(x)]
        radius = sum(abs(a) * d + b * (abs(c) + d) for a, b, c, d in pairs)
        found.append(rounded(sum(a * c for a, _, c, _ in pairs), radius, SCALE))
    return found


def plus(p: Series, q: Series) -> Series:
    """The coefficients of a sum."""
    return [(a + c, b + d) for (a, b), (c, d) in zip(p, q, strict=True)]


def circle(x: Fraction) -> list[Ball]:
    """cos x and sin x, x >= 0: Taylor's sums at x/2^n < 1/2, and angles doubled n times."""
    n = (2 * x.numerator // x.denominator).bit_length()
    need(n < 50, "an angle is too large")
    one = SCALE * 10**20  # finer: what is cut off, and the rest of the sums, stay below one part of one
    y, terms = int(x * one / 2**n), [one]
    for k in range(1, 52):
        terms.append(terms[-1] * y // (one * k))
    c, s = ((sum((-1) ** (k // 2) * terms[k] for k in range(i, 52, 2)) // 10**20, 2 * bool(x)) for i in (0, 1))
    for _ in range(n):
        [cc], [(a, b)], [(m, r)] = times([c], [c]), times([s], [s]), times([c], [s])
        c, s = (cc[0] - a, cc[1] + b), (2 * m, 2 * r)
    return [c, s]


@cache
def power_of_pi(n: int) -> Ball:
    low, high = (x**n * SCALE // y**n for x, y in PI)
    return low, high - low + 1


def in_pi(row: list[int]) -> Ball:
    """A polynomial in pi."""
    found = [(c * power_of_pi(n)[0], abs(c) * power_of_pi(n)[1]) for n, c in enumerate(row)]
    return sum(x for x, _ in found), sum(x for _, x in found)


class Place:
    """Powers of omega, and of its sines and cosines, as series with the step h, wherever from low to high."""

    def __init__(self, delays: tuple[Fraction, ...], low: Fraction, high: Fraction, step: Fraction) -> None:
        middle, radius = (low + high) / 2, ceil((high - low) * SCALE / 2)
        one, zero = (SCALE, 0), (0, 0)
        start, ahead = (rounded(x.numerator * SCALE, 0, x.denominator) for x in (middle, step))
        self.first = [one, *[zero] * ORDER]
        self.own = [[(start[0], start[1] + radius), ahead, *[zero] * (ORDER - 1)]]
        for rate in (tau / 2 for tau in delays):
            (c, d), (s, t) = ((m, r + ceil(radius * rate)) for m, r in circle(middle * rate))  # no slope is above 1
            turns, weights = (
                [(c, d), (-s, t), (-c, d), (s, t)],
                [(step * rate) ** n / factorial(n) for n in range(ORDER + 1)],
            )
            for i in (3, 0):
                rows = [(*turns[(n + i) % 4], w.numerator, w.denominator) for n, w in enumerate(weights)]
                self.own.append([rounded(m * u, r * u, v) for m, r, u, v in rows])
        self.known: dict[tuple[int, int], Series] = {}

    def power(self, i: int, n: int) -> Series:
        """Of omega (0), of a sine (1, 3, ...) or of its cosine (2, 4, ...)."""
        if n and (i, n) not in self.known:
            self.known[i, n] = times(self.own[i], self.power(i, n - 1))
        return self.known[i, n] if n else self.first


place = lru_cache(maxsize=8)(Place)


class WaveFactor(Factor):
    """A sum of polynomials in omega times powers of sines, and of cosines with what is missing to a degree, of omega tau/2."""

    def __init__(self, x: Any, delays: tuple[Fraction, ...]) -> None:
        waves, terms = keyed(x, "waves", "terms")
        n, rows, self.delays = len(delays), [listed(row, 2, 2) for row in listed(terms, 300, 1)], delays
        self.waves = tuple(whole(k, 0, 40) for k in listed(waves, n, n))
        self.terms = [
            (tuple(whole(k, 0, most) for k, most in zip(listed(turns, n, n), self.waves, strict=True)), polynomial(p))
            for turns, p in rows
        ]
        need(len({turns for turns, _ in self.terms}) == len(rows), "a term stands twice in a factor")
        sizes = [max(c.bit_length() for c in row) + len(row) + 40 for _, p in self.terms for row in p]
        self.cost = (sum(sizes) + 500 * len(rows) * (1 + sum(self.waves))) * 2
        need(self.cost < 10**7, "a factor is too large")

    def series(self, at: Place, number: Callable[[list[int]], Ball] = in_pi) -> Series:
        """``number`` : what a coefficient is, with pi in it."""
        total = [(0, 0)] * (ORDER + 1)
        for turns, p in self.terms:
            term = [(0, 0)] * (ORDER + 1)
            for n, (a, b) in enumerate(map(number, p)):
                term = plus(term, [rounded(a * c, abs(a) * d + b * (abs(c) + d), SCALE) for c, d in at.power(0, n)])
            for i, (k, n) in enumerate(zip(turns, self.waves, strict=True)):
                term = times(times(term, at.power(2 * i + 1, k)), at.power(2 * i + 2, n - k))
            total = plus(total, term)
        return total

    @cached_property
    def order_at_0(self) -> int:
        """With a step that makes all angles whole numbers coefficients are exact; each power of pi in them is looked at alone."""
        step = Fraction(2 * lcm(*(tau.denominator for tau in self.delays)))
        here = place(self.delays, Fraction(0), Fraction(0), step)
        width = max(len(row) for _, p in self.terms for row in p)
        found = [self.series(here, lambda row, i=i: (sum(row[i : i + 1]) * SCALE, 0)) for i in range(width)]  # type: ignore[misc]
        order = next((n for n in range(ORDER) if any(row[n] != (0, 0) for row in found)), None)
        need(order is not None, "the order of a zero at 0 stays open")
        return int(order or 0)

    def signs(self, a: Fraction, b: Fraction) -> list[int]:
        here, there = (self.series(place(self.delays, a, x, b - a)) for x in (a, b))
        model, first = [*here[:-1], there[-1]], 0 if a else self.order_at_0  # the sum of c_n v^n from 0 to 1 (Lagrange)
        if found := side(model[first:]):
            return [0] * first + [found]
        need(not first and side([(n * c, n * d) for n, (c, d) in enumerate(model)][1:]), "a sign stays open")
        return [strict(model[:1]), strict(model)]

    def sign(self, x: Fraction) -> int:
        """Of its value at a rational number; refused where its bounds do not tell."""
        return strict(self.series(place(self.delays, x, x, Fraction(0))))


def side(model: Series) -> int:
    """The sign for all v from 0 to 1, if Bernstein's coefficients show it."""
    low, high = (moved([c + way * d for c, d in model], (0, 1), (1, 1)) for way in (-1, 1))
    return all(x > 0 for x in low) - all(x < 0 for x in high)


def strict(model: Series) -> int:
    """The sign of a sum."""
    middle, radius = (sum(column) for column in zip(*model, strict=True))
    need(abs(middle) > radius, "a sign stays open")
    return 1 if middle > 0 else -1


def polynomial_factor(x: Any, delays: tuple[Fraction, ...] = ()) -> Factor:
    """One without sines."""
    step, rows = keyed(x, "step", "polynomial")
    return Factor(polynomial(rows), whole(step, 1, 2), len(delays))


def factor_of(x: Any, delays: tuple[Fraction, ...]) -> Factor:
    """Of a proof."""
    return (WaveFactor if isinstance(x, dict) and "waves" in x else polynomial_factor)(x, delays)
