"""Rules 7 and 8: signs of factors with sines, cosines and powers of omega, from Taylor's sums and his remainder."""

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from functools import cache, cached_property
from itertools import accumulate, groupby, repeat, zip_longest
from math import factorial, lcm
from operator import mul
from typing import Any

from haptisym_check.balls import SCALE, Ball, in_pi
from haptisym_check.link import Numbers
from haptisym_check.polynomials import Factor, moved, pairs
from haptisym_check.reading import Polynomial, keyed, listed, polynomial, whole
from haptisym_check.series import ORDER, Series, Terms, place
from haptisym_check.values import need


class WaveFactor(Factor):
    """A sum of polynomials in omega times powers of sines and cosines to a common degree, and of Re and Im of (j omega)^alpha."""

    def __init__(self, x: Any, delays: Numbers, orders: Numbers = ()) -> None:
        waves, terms = keyed(x, "waves", "terms")
        n, rows = len(delays), [listed(row, 2, 2) for row in listed(terms, 300, 1)]
        self.delays, self.orders = delays, orders
        self.waves = tuple(whole(k, 0, 40) for k in listed(waves, n, n))
        most = [*self.waves, *[40] * (2 * len(orders))]
        exponents = [tuple(map(whole, listed(x, len(most), len(most)), repeat(0), most)) for x, _ in rows]
        self.terms = [(x, polynomial(p)) for x, (_, p) in zip(exponents, rows, strict=True)]
        need(len(set(exponents)) == len(rows), "a term stands twice in a factor")
        self.powers = any(any(x[n:]) for x in exponents)
        sizes = [max(c.bit_length() for c in row) + len(row) + 40 for _, p in self.terms for row in p]
        self.cost = (sum(sizes) + 500 * len(rows) * (1 + sum(self.degrees[2:]))) * 2
        need(self.cost < 10**7, "a factor is too large")
        self.all = self.numbers(self.terms)

    def raised(self, term: tuple[tuple[int, ...], Polynomial]) -> tuple[int, ...]:
        """Its exponents of Re and Im of powers."""
        return term[0][len(self.delays) :]

    def numbers(self, terms: list[Any], number: Callable[[list[int]], Ball] = in_pi) -> Terms:
        """``number`` : what a coefficient is, with pi in it."""
        found = []
        for turns, p in terms:
            own = [n for k, most in zip(turns, self.waves, strict=False) for n in (k, most - k)]
            found.append(((0, *own, *turns[len(own) // 2 :]), list(map(number, p))))
        return found

    def sizes(self, terms: Terms) -> Terms:
        """With cosines alone, whose largest sizes are those of sines."""
        cosines, found = [x for n in self.waves for x in (0, n)], dict[tuple[int, ...], list[Ball]]()
        for powers, p in terms:
            key = (0, *cosines, *powers[1 + len(cosines) :])
            rows = zip_longest(found.get(key, []), p, fillvalue=(0, 0))
            found[key] = [(x + abs(m) + r, 0) for (x, _), (m, r) in rows]
        return list(found.items())

    def model(self, terms: Terms, a: Fraction, b: Fraction) -> Series:
        """All c_n, n < N, and what the sum of c_n v^n, v from -1 to 1 (0 to 1 from 0 on), is off theirs by at most (Lagrange)."""
        middle = (a + b) / 2 if a else a
        row, lost = place(self.delays, self.orders, middle, middle, b - middle).total(terms)
        largest, more = place(self.delays, self.orders, a, b, b - middle).total(self.sizes(terms))
        return row[:-1], lost + largest[-1] + more

    @cached_property
    def beginnings(self) -> list[tuple[Fraction, Terms, list[bool]]]:
        """The terms with each power of omega that is not whole, and which of Taylor's coefficients are not zero beside it at 0.

        With a step that makes angles multiples of N! coefficients are whole numbers; each power of pi in them is looked at alone.
        """
        step = Fraction(2 * factorial(ORDER) * lcm(*(tau.denominator for tau in self.delays)))
        here, found = place(self.delays, (), Fraction(0), Fraction(0), step), []
        for powers, rows in groupby(sorted(self.terms, key=self.raised), self.raised):
            terms = list(rows)
            width = max(len(row) for _, p in terms for row in p)
            each = [self.numbers(terms, lambda row, i=i: (sum(row[i : i + 1]) * SCALE, 0)) for i in range(width)]  # type: ignore[misc]
            there = [any(column) for column in zip(*(here.total(x)[0][:-1] for x in each), strict=True)]
            exponent = sum((a * (k + m) for a, (k, m) in zip(self.orders, pairs(powers), strict=True)), Fraction(0))
            found.append((exponent, self.numbers(terms), [*there, True]))
        return found

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        if not a:
            return self.signs_from_0(b)
        row, lost = self.model(self.all, a, b)
        if found := side(row, lost):
            return 0, [found]
        need(side([n * c for n, c in enumerate(row)][1:], ORDER * lost), "a sign stays open")
        return 0, [strict(sum(row[::2]) - sum(row[1::2]), lost), strict(sum(row), lost)]

    def signs_from_0(self, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """A sum of c v^e, v from 0 to 1, has one sign if all of its partial sums have, from the lowest e on (Abel)."""
        total, lost = Counter[Fraction](), 0
        for exponent, terms, there in self.beginnings:
            row, more = self.model(terms, Fraction(0), b)
            lost += more
            total.update({exponent + n: c for n, c in enumerate([*row, 0]) if there[n]})
        signs = [strict(x, lost) for x in accumulate(total[e] for e in sorted(total))]
        need(len(set(signs)) == 1, "a sign stays open")
        return min(total), signs[:1]

    def sign(self, x: Fraction) -> int:
        """Of its value at a rational number; refused where its bounds do not tell."""
        [value], lost = place(self.delays, self.orders, x, x, Fraction(0)).total(self.all)
        return strict(value, lost)


@cache
def bernstein(count: int) -> list[tuple[int, ...]]:
    """Of 1, v, v^2, ...: Bernstein's coefficients on [-1, 1], times those of (1 + u)^n, with which each row begins."""
    units = ([0] * n + [1] + [0] * (count - 1 - n) for n in range(count))
    return list(zip(*(moved(x, (-1, 1), (1, 1)) for x in units), strict=True))


def side(row: list[int], lost: int) -> int:
    """The sign for all v from -1 to 1, if Bernstein's coefficients show it."""
    found = [(sum(map(mul, row, x)), lost * x[0]) for x in bernstein(len(row))]
    return all(x > most for x, most in found) - all(x < -most for x, most in found)


def strict(x: int, lost: int) -> int:
    """The sign of a number."""
    need(abs(x) > lost, "a sign stays open")
    return 1 if x > 0 else -1


def polynomial_factor(x: Any, delays: Numbers = (), orders: Numbers = ()) -> Factor:
    """One without sines and powers."""
    step, rows = keyed(x, "step", "polynomial")
    return Factor(polynomial(rows), whole(step, 1, 2), len(delays), len(orders))


def factor_of(x: Any, delays: Numbers, orders: Numbers) -> Factor:
    """Of a proof."""
    return (WaveFactor if isinstance(x, dict) and "waves" in x else polynomial_factor)(x, delays, orders)
