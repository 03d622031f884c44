"""Pi, the signs of polynomials (rule 2), and the factors that are polynomials in omega.

How many zeros has p between two numbers? The sign changes of the coefficients of
(c + d u)^n p((a + b u)/(c + d u)) bound the number of zeros between a/c and b/d (Descartes), with
the right parity. No change proves that there is none, one change that there is exactly one. All
arithmetic is in integers; where pi stands in a coefficient, a sign is proven if it is the same for
every value between two rational bounds of pi. Begin with ``moved`` and ``signs``.
"""

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


# 5^150 and 239^44 exceed 10^104: both bounds agree with pi to 100 digits.
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
    # Horner's scheme with numerator and denominator apart, so that no fraction arises.
    coefficients, power = [p[-1]], [1]
    for c in p[-2::-1]:
        power = times(power, low[1], high[1])
        raised = times(coefficients, low[0], high[0])
        coefficients = [x + c * y for x, y in zip(raised, power, strict=True)]
    return coefficients


def sliced(p: Polynomial, low: Point = PI[0], high: Point = PI[1]) -> list[list[int]]:
    """The slices of p: polynomials without pi, of which p is a sum with positive weights for every
    value of pi (or of the free parameter in its place) between two numbers."""
    # With pi = (low + high v)/(1 + v), v > 0, each coefficient is a polynomial in v over one common
    # power of 1 + v. The slices are what stands at v^0, v^1, ...; equal lengths keep that power
    # common.
    width = max(map(len, p))
    in_v = (moved([*row, *[0] * (width - len(row))], low, high) for row in p)
    return [list(x) for x in zip(*in_v, strict=True)]


def signs(slices: list[list[int]], low: Point, high: Point) -> list[int]:
    """The signs of a polynomial's Bernstein coefficients on [low, high], if all of its slices have
    the same ones; refused otherwise."""
    rows = [[(x > 0) - (x < 0) for x in moved(row, low, high)] for row in slices]
    # Equal signs in every slice survive the sum with positive weights, whatever the weights are.
    need(all(row == rows[0] for row in rows), "a sign stays open")
    return rows[0]


def order(row: Sequence[object]) -> int:
    """How many zeros stand before all else: a polynomial's order at 0."""
    return [bool(x) for x in row].index(True)


def turns(row: list[int]) -> int:
    """How often signs change, zeros left out."""
    return sum(x != y for x, y in pairwise([x for x in row if x]))


def pairs(row: Sequence[int]) -> list[tuple[int, int]]:
    """The first two of a list, the next two, and so on."""
    return list(zip(row[::2], row[1::2], strict=True))


def affordable(numbers: Iterable[Fraction], cost: int) -> None:
    """Refuse a certificate whose signs would take too long: ``cost`` is that of all signs at a
    number of one bit, and the work is proportional to the bits."""
    bits = sum(x.denominator.bit_length() + x.numerator.bit_length() for x in numbers)
    need(bits * cost < 5 * 10**9, "the cells are too many, or too fine")


class OmegaFactor:
    """A polynomial in omega^step, written as a sum of one term; ``WaveFactor`` has sines, cosines
    and powers in its terms.

    A term is a pair: exponents (of each sine, then of Re and Im of each power of omega), and a
    polynomial in omega.
    """

    step, powers = 1, False

    def __init__(self, rows: Polynomial, step: int = 1, delays: int = 0, orders: int = 0) -> None:
        self.rows, self.step, self.waves = rows, step, (0,) * delays
        self.terms = [((0,) * (delays + 2 * orders), rows)]
        # Moving takes about n^2 products of integers whose lengths grow with n.
        self.cost = len(rows) ** 3 * max(map(len, rows)) + 1000

    @cached_property
    def slices(self) -> list[list[int]]:
        """The slices of the polynomial for pi between its bounds."""
        return sliced(self.rows)

    @cached_property
    def size(self) -> int:
        """The words of all coefficients, and what it costs however few they are."""
        return 10 + sum(1 + c.bit_length() // 64 for _, p in self.terms for row in p for c in row)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Bounds of the degrees in omega, in pi, in each tangent, and in Re and Im of each power
        together."""
        count, every = len(self.waves), [row for _, p in self.terms for row in p]
        in_omega = self.step * max(len(p) - 1 for _, p in self.terms)
        in_pi = max(map(len, every)) - 1
        # Sines and cosines are homogeneous of degree n in each term: over cos^n that is a
        # polynomial of degree n in the tangent, so the degree is the factor's, not a term's.
        of_terms = ([sum(x) for x in pairs(exponents[count:])] for exponents, _ in self.terms)
        in_powers = map(max, zip(*of_terms, strict=True))
        degrees = (in_omega, in_pi, *self.waves, *in_powers)
        return (*degrees, *[0] * (MOST_OTHERS + 2 - len(degrees)))

    @lru_cache(maxsize=500)  # noqa: B019 - a grid asks for the same ones often
    def values(self, x: int, pi: int) -> list[int]:
        """The values of the polynomials of all terms, with x for omega and a whole number for
        pi."""
        power = x**self.step
        return [
            sum(c * pi**k * power**n for n, row in enumerate(p) for k, c in enumerate(row))
            for _, p in self.terms
        ]

    def at(self, x: int, pi: int, others: list[int]) -> GaussianValue:
        """The value, over cos(omega tau/2)^n for each delay, where tangents, and Re and Im of
        powers, are whole numbers."""
        total = 0
        for (exponents, _), value in zip(self.terms, self.values(x, pi), strict=True):
            total += value * prod(map(pow, others, exponents))
        return GaussianValue(total, 0, self.degrees)

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """The order of the zero at a; signs whose changes are the zeros between a and b, then as
        many zeros as the order at b."""
        low, high = ((x**self.step).as_integer_ratio() for x in (a, b))
        row = signs(self.slices, low, high)
        n = order(row)
        # The polynomial is one in omega^step: at 0 its order in omega is step times as high, at
        # a > 0 omega^step - a^step has a simple zero and the order is the same.
        return n * (1 if a else self.step), row[n:]

    def sign(self, x: Fraction) -> int:
        """The sign of its value at a rational number."""
        # On [x, infinity] the coefficient at u = 0 is the value at x times a positive number.
        return signs(self.slices, (x**self.step).as_integer_ratio(), (1, 0))[0]
