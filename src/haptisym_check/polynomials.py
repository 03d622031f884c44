"""Pi, the signs of polynomials (rule 2), and the factors that are polynomials in omega."""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from math import prod

from haptisym_check.values import MOST_OTHERS, GaussianValue, Polynomial, need

Point = tuple[int, int]  # numerator and denominator; (1, 0) is infinity


def arctangent(n: int, terms: int) -> list[Fraction]:
    """Bounds of arctan(1/n): an alternating series lies between two of its partial sums that follow
    one another."""
    sums = [
        sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(m))
        for m in (terms, terms + 1)
    ]
    return sorted(map(Fraction, sums))


FIFTH, OTHER, SCALE = arctangent(5, 75), arctangent(239, 22), 10**100
PI = (
    (int((16 * FIFTH[0] - 4 * OTHER[1]) * SCALE), SCALE),
    (int((16 * FIFTH[1] - 4 * OTHER[0]) * SCALE) + 1, SCALE),
)
"""Numbers below and above pi (Machin: pi/4 = 4 arctan 1/5 - arctan 1/239)."""


def times(p: list[int], a: int, b: int) -> list[int]:
    """p (a + b u)."""
    return [a * x + b * y for x, y in zip([*p, 0], [0, *p], strict=True)]


def moved(p: list[int], low: Point, high: Point) -> list[int]:
    """The coefficients of p((a + b u)/(c + d u)) (c + d u)^n: from low = a/c at u = 0 to high = b/d
    at infinity."""
    found, power = [p[-1]], [1]
    for c in p[-2::-1]:
        power = times(power, low[1], high[1])
        found = [x + c * y for x, y in zip(times(found, low[0], high[0]), power, strict=True)]
    return found


def sliced(p: Polynomial, low: Point = PI[0], high: Point = PI[1]) -> list[list[int]]:
    """Polynomials whose sum, with positive weights, p is for every value between two of what stands
    beside its variable."""
    width = max(map(len, p))
    return [
        list(x)
        for x in zip(
            *(moved([*row, *[0] * (width - len(row))], low, high) for row in p), strict=True
        )
    ]


def signs(slices: list[list[int]], low: Point, high: Point) -> list[int]:
    """Those of the coefficients of a polynomial: all slices have them."""
    found = [[(x > 0) - (x < 0) for x in moved(row, low, high)] for row in slices]
    need(all(row == found[0] for row in found), "a sign stays open")
    return found[0]


def order(row: Sequence[object]) -> int:
    """How many zeros stand before all else: a polynomial's order at 0."""
    return [bool(x) for x in row].index(True)


def turns(found: list[int]) -> int:
    """How often signs change, zeros left out."""
    return sum(x != y for x, y in pairwise([x for x in found if x]))


def pairs(row: Sequence[int]) -> list[tuple[int, int]]:
    """The first two of a list, the next two, and so on."""
    return list(zip(row[::2], row[1::2], strict=True))


def affordable(numbers: Iterable[Fraction], cost: int) -> None:
    """That signs, with that cost where numbers have one bit, are soon found at all of some
    numbers."""
    bits = sum(x.denominator.bit_length() + x.numerator.bit_length() for x in numbers)
    need(bits * cost < 5 * 10**9, "the cells are too many, or too fine")


class OmegaFactor:
    """A polynomial in omega^step, as sum of one term; others have sines in their terms."""

    step, powers = 1, False

    def __init__(self, rows: Polynomial, step: int = 1, delays: int = 0, orders: int = 0) -> None:
        self.rows, self.step, self.waves = rows, step, (0,) * delays
        self.terms = [((0,) * (delays + 2 * orders), rows)]
        self.cost = len(rows) ** 3 * max(map(len, rows)) + 1000

    @cached_property
    def slices(self) -> list[list[int]]:
        """Polynomials whose sum, with positive weights, it is for pi between its bounds."""
        return sliced(self.rows)

    @cached_property
    def size(self) -> int:
        """The words of all coefficients, and what it costs however few they are."""
        return 10 + sum(1 + c.bit_length() // 64 for _, p in self.terms for row in p for c in row)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """In omega, in pi, in each tangent, and in Re and Im of each power together."""
        count, every = len(self.waves), [row for _, p in self.terms for row in p]
        high = self.step * max(len(p) - 1 for _, p in self.terms), max(map(len, every)) - 1
        both = zip(
            *([sum(x) for x in pairs(turns[count:])] for turns, _ in self.terms), strict=True
        )
        found = (*high, *self.waves, *map(max, both))
        return (*found, *[0] * (MOST_OTHERS + 2 - len(found)))

    @lru_cache(maxsize=500)  # noqa: B019 - a grid asks for the same ones often
    def values(self, x: int, pi: int) -> list[int]:
        """Those of the polynomials of all terms."""
        power = x**self.step
        return [
            sum(c * pi**k * power**n for n, row in enumerate(p) for k, c in enumerate(row))
            for _, p in self.terms
        ]

    def at(self, x: int, pi: int, others: list[int]) -> GaussianValue:
        """The value, over cos(omega tau/2)^n for each delay, where tangents, and Re and Im of
        powers, are whole numbers."""
        each = zip(self.terms, self.values(x, pi), strict=True)
        return GaussianValue(
            sum(own * prod(map(pow, others, turns)) for (turns, _), own in each), 0, self.degrees
        )

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """The order of the zero at a; signs whose changes are the zeros between a and b, then as
        many zeros as the order at b."""
        found = signs(
            self.slices, (a**self.step).as_integer_ratio(), (b**self.step).as_integer_ratio()
        )
        n = order(found)
        return n * (1 if a else self.step), found[n:]  # at 0 the order is one in omega

    def sign(self, x: Fraction) -> int:
        """Of its value at a rational number."""
        return signs(self.slices, (x**self.step).as_integer_ratio(), (1, 0))[0]
