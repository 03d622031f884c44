"""Rules 7 and 8: signs of factors with sines, cosines and powers of omega, in numbers with bounds
of their errors."""

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from functools import cache, cached_property, lru_cache, reduce
from itertools import accumulate, groupby, repeat, zip_longest
from math import factorial, lcm
from operator import mul
from typing import Any

from haptisym_check.polynomials import PI, OmegaFactor, moved, pairs
from haptisym_check.scene import Numbers
from haptisym_check.values import Polynomial, keyed, listed, need, polynomial, whole

# Numbers with bounds of their errors (rules 7 and 8): sines, cosines and powers, all in parts of
# one.

BITS, GUARD = 280, 64
SCALE, FINER = 1 << BITS, 1 << (BITS + GUARD)
Ball = tuple[int, int]
"""All numbers within a radius of a middle."""


def parts(x: Fraction) -> int:
    """A number to one part of one."""
    return (x.numerator << BITS) // x.denominator


def circle(x: Fraction) -> list[int]:
    """cos x, -sin x, -cos x, sin x, x >= 0, to two parts of one: Taylor's sums at x/2^n < 1/2, and
    n times twice the angle.

    That doubles errors, as squares of complex numbers of size one do.
    """
    n = (2 * x.numerator // x.denominator).bit_length()
    need(n < 50, "an angle is too large")
    y = x.numerator * FINER // (x.denominator << n)
    terms = list(accumulate(range(1, 64), lambda term, k: term * y // (FINER * k), initial=FINER))
    c, s = (sum(terms[i::4]) - sum(terms[i + 2 :: 4]) for i in (0, 1))
    for _ in range(n):
        c, s = c * c - s * s >> (BITS + GUARD), 2 * c * s >> (BITS + GUARD)
    return [x >> GUARD for x in (c, -s, -c, s)]


def artanh(x: Fraction) -> int:
    """The sum of x^n/n, n odd, |x| <= 1/3, to a thousand parts of FINER."""
    y = int(x * FINER)
    powers = accumulate(range(109), lambda z, _: z * (y * y // FINER) // FINER, initial=y)
    return sum(z // n for z, n in zip(powers, range(1, 221, 2), strict=True))


LN_2 = 2 * artanh(Fraction(1, 3))


def power(x: Fraction, alpha: Fraction) -> Ball:
    """x^alpha = exp(alpha ln x), x > 0 and 0 < alpha < 1; ln (1 + y)/(1 - y) = 2 artanh y."""
    n = x.numerator.bit_length() - x.denominator.bit_length()
    need(x > 0 and abs(n) < 10**5, "a number is too large, or too small")
    m = x / Fraction(2) ** n  # between 1/2 and 2
    k, y = divmod(
        (2 * artanh((m - 1) / (m + 1)) + n * LN_2) * alpha.numerator // alpha.denominator, LN_2
    )
    total = sum(accumulate(range(1, 80), lambda term, i: term * y // (FINER * i), initial=FINER))
    up, down = max(k, 0), GUARD + max(-k, 0)
    return total << up >> down, (10**12 << up >> down) + 2  # 2^k exp y


@cache
def power_of_pi(n: int) -> Ball:
    low, high = (x**n * SCALE // y**n for x, y in PI)
    return low, high - low + 1


def in_pi(row: list[int]) -> Ball:
    """A polynomial in pi."""
    found = [(c * power_of_pi(n)[0], abs(c) * power_of_pi(n)[1]) for n, c in enumerate(row)]
    return sum(x for x, _ in found), sum(x for _, x in found)


# Taylor's sums with sines, cosines and powers of omega (rules 7 and 8).

ORDER = 14
Series = tuple[list[int], int]
"""Coefficients of v^n, n from 0 to ORDER, in parts of one, and a bound of the sum of all their
errors."""
Terms = list[tuple[tuple[int, ...], list[Ball]]]
"""Products of powers (as of ``SeriesPoint``), each with the coefficients of a polynomial in omega."""


def times(p: Series, q: Series) -> Series:
    """Leibniz: the coefficients of a product; those of p may be fewer."""
    (a, r), (b, s) = p, q
    lost = (sum(map(abs, a)) + r) * s + r * sum(
        map(abs, b)
    )  # |p q - a b| <= |p| |q - b| + |p - a| |b|
    return [sum(map(mul, a, b[n::-1])) >> BITS for n in range(len(b))], (lost >> BITS) + 1 + len(b)


def plus(p: Series, q: Series) -> Series:
    """The coefficients of a sum."""
    return [x + y for x, y in zip(p[0], q[0], strict=True)], p[1] + q[1]


def waves(turns: list[int], ahead: Fraction, count: int) -> list[Series]:
    """Of the sine and the cosine of an angle + ahead v, from its ``circle``, or from the largest
    sizes of that."""
    x, y = ahead.as_integer_ratio()
    weights = [(x**n << BITS) // (y**n * factorial(n)) for n in range(count)]
    lost = 2 * (sum(weights) >> BITS) + 2 + 2 * count
    return [([turns[(n + i) % 4] * w >> BITS for n, w in enumerate(weights)], lost) for i in (3, 0)]


def binomial(alpha: Fraction, low: Fraction, high: Fraction, step: Fraction, count: int) -> Series:
    """Of omega^alpha at a number, or of the sizes from low to high; of h^alpha from 0 on."""
    ahead = step / low if low else Fraction(0)
    weights = list(
        accumulate(
            range(1, count), lambda w, n: w * (alpha - n + 1) * ahead / n, initial=Fraction(1)
        )
    )
    (first, lost), (own, more) = power(high if low else step, alpha), power(low or step, alpha)
    later = [own * w.numerator // w.denominator for w in weights[1:]]
    errors = lost + int(more * sum(map(abs, weights))) + 1 + count
    return [first, *(map(abs, later) if low < high else later)], errors


class SeriesPoint:
    """Powers of omega, sines, cosines, Re and Im of (j omega)^alpha, as series with the step h: at
    a number, or from low to high, where coefficients are the largest sizes of theirs. From 0 on the
    last two are those of h: before them is a power of omega/h.
    """

    def __init__(
        self, delays: Numbers, orders: Numbers, low: Fraction, high: Fraction, step: Fraction
    ) -> None:
        count = ORDER + 1 if step else 1
        rest = [0] * (count - 1)
        self.own: list[Series] = [([parts(high), parts(step)][:count], 2)]
        for rate in (tau / 2 for tau in delays):
            self.own += waves(
                [SCALE] * 4 if low < high else circle(high * rate), step * rate, count
            )
        for alpha in orders:
            size, turns = (
                binomial(alpha, low, high, step, count),
                circle(alpha * Fraction(*PI[0]) / 2),
            )
            self.own += [times(size, ([x, *rest], 3)) for x in turns[::3]]
        self.none = (0,) * len(self.own)
        self.known: dict[tuple[int, ...], Series] = {self.none: ([SCALE, *rest], 0)}
        self.tables: dict[int, tuple[Any, ...]] = {}

    def product(self, powers: tuple[int, ...]) -> Series:
        """Of omega (first), of a sine, its cosine, the next sine, ..., a real part, its imaginary
        part, ..., to these powers."""
        if powers not in self.known:
            i = max(i for i, n in enumerate(powers) if n)
            self.known[powers] = times(
                self.own[i], self.product((*powers[:i], powers[i] - 1, *powers[i + 1 :]))
            )
        return self.known[powers]

    def polynomial(self, p: list[Ball]) -> Series:
        """In omega."""
        if len(p) not in self.tables:
            rows, errors = zip(
                *(self.product((n, *self.none[1:])) for n in range(len(p))), strict=True
            )
            sizes = [sum(map(abs, row)) + lost for row, lost in zip(rows, errors, strict=True)]
            self.tables[len(p)] = list(zip(*rows, strict=True)), errors, sizes
        columns, errors, sizes = self.tables[len(p)]
        middles, radii = zip(*p, strict=True)
        lost = sum(map(mul, map(abs, middles), errors)) + sum(map(mul, radii, sizes))
        return [sum(map(mul, middles, x)) >> BITS for x in columns], (lost >> BITS) + 1 + len(
            columns
        )

    def total(self, terms: Terms) -> Series:
        """Of their sum."""
        return reduce(
            plus,
            (
                times(self.polynomial(p), self.product(powers[: len(self.own)]))
                for powers, p in terms
            ),
        )


place = lru_cache(maxsize=8)(SeriesPoint)


# Rules 7 and 8: signs of factors with sines, cosines and powers of omega, from Taylor's sums and
# his remainder.


class WaveFactor(OmegaFactor):
    """A sum of polynomials in omega times powers of sines and cosines to a common degree, and of Re
    and Im of (j omega)^alpha."""

    def __init__(self, x: Any, delays: Numbers, orders: Numbers = ()) -> None:
        waves, terms = keyed(x, "waves", "terms")
        n, rows = len(delays), [listed(row, 2, 2) for row in listed(terms, 300, 1)]
        self.delays, self.orders = delays, orders
        self.waves = tuple(whole(k, 0, 40) for k in listed(waves, n, n))
        most = [*self.waves, *[40] * (2 * len(orders))]
        exponents = [
            tuple(map(whole, listed(x, len(most), len(most)), repeat(0), most)) for x, _ in rows
        ]
        self.terms = [(x, polynomial(p)) for x, (_, p) in zip(exponents, rows, strict=True)]
        need(len(set(exponents)) == len(rows), "a term stands twice in a factor")
        self.powers = any(any(x[n:]) for x in exponents)
        sizes = [
            max(c.bit_length() for c in row) + len(row) + 40 for _, p in self.terms for row in p
        ]
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
        cosines, found = (
            [x for n in self.waves for x in (0, n)],
            dict[tuple[int, ...], list[Ball]](),
        )
        for powers, p in terms:
            key = (0, *cosines, *powers[1 + len(cosines) :])
            rows = zip_longest(found.get(key, []), p, fillvalue=(0, 0))
            found[key] = [(x + abs(m) + r, 0) for (x, _), (m, r) in rows]
        return list(found.items())

    def model(self, terms: Terms, a: Fraction, b: Fraction) -> Series:
        """All c_n, n < N, and what the sum of c_n v^n, v from -1 to 1 (0 to 1 from 0 on), is off
        theirs by at most (Lagrange)."""
        middle = (a + b) / 2 if a else a
        row, lost = place(self.delays, self.orders, middle, middle, b - middle).total(terms)
        largest, more = place(self.delays, self.orders, a, b, b - middle).total(self.sizes(terms))
        return row[:-1], lost + largest[-1] + more

    @cached_property
    def beginnings(self) -> list[tuple[Fraction, Terms, list[bool]]]:
        """The terms with each power of omega that is not whole, and which of Taylor's coefficients
        are not zero beside it at 0.

        With a step that makes angles multiples of N! coefficients are whole numbers; each power of
        pi in them is looked at alone.
        """
        step = Fraction(2 * factorial(ORDER) * lcm(*(tau.denominator for tau in self.delays)))
        here, found = place(self.delays, (), Fraction(0), Fraction(0), step), []
        for powers, rows in groupby(sorted(self.terms, key=self.raised), self.raised):
            terms = list(rows)
            width = max(len(row) for _, p in terms for row in p)
            each = [
                self.numbers(terms, lambda row, i=i: (sum(row[i : i + 1]) * SCALE, 0))  # type: ignore[misc]
                for i in range(width)
            ]
            there = [
                any(column) for column in zip(*(here.total(x)[0][:-1] for x in each), strict=True)
            ]
            exponent = sum(
                (a * (k + m) for a, (k, m) in zip(self.orders, pairs(powers), strict=True)),
                Fraction(0),
            )
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
        """A sum of c v^e, v from 0 to 1, has one sign if all of its partial sums have, from the
        lowest e on (Abel)."""
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
    """Of 1, v, v^2, ...: Bernstein's coefficients on [-1, 1], times those of (1 + u)^n, with which
    each row begins."""
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


def polynomial_factor(x: Any, delays: Numbers = (), orders: Numbers = ()) -> OmegaFactor:
    """One without sines and powers."""
    step, rows = keyed(x, "step", "polynomial")
    return OmegaFactor(polynomial(rows), whole(step, 1, 2), len(delays), len(orders))


def factor_of(x: Any, delays: Numbers, orders: Numbers) -> OmegaFactor:
    """Of a proof."""
    return (WaveFactor if isinstance(x, dict) and "waves" in x else polynomial_factor)(
        x, delays, orders
    )
