"""Pi, the signs of polynomials (rule 2), and the factors that are polynomials in omega.

How many zeros has p between two numbers? The sign changes of the coefficients of
(c + d u)^n p((a + b u)/(c + d u)) bound the number of zeros between a/c and b/d (Descartes), with
the right parity. No change proves that there is none, one change that there is exactly one. All
arithmetic is in integers; where pi stands in a coefficient, a sign is proven if it is the same for
every value between two rational bounds of pi.

A polynomial is a list of integers, the constant first; a ``Polynomial`` has such a list, a
polynomial in pi, for each coefficient. Begin with ``moved`` and ``signs``.
"""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import pairwise
from math import prod

from haptisym_check.values import MOST_DELAYS_AND_ORDERS, GaussianValue, Polynomial, need

Point = tuple[int, int]  # numerator and denominator; (1, 0) is infinity


def arctangent(n: int, terms: int) -> list[Fraction]:
    """Bounds of arctan(1/n): an alternating series lies between two of its partial sums that follow
    one another."""
    total = Fraction(0)
    sums = []
    for k in range(terms):
        sums.append(total)
        odd = 2 * k + 1
        total += Fraction((-1) ** k, odd * n**odd)
    return sorted([sums[-1], total])


# 5^149 and 239^45 exceed 10^104: both bounds agree with pi to 100 digits.
FIFTH = arctangent(5, 75)
OTHER = arctangent(239, 23)
SCALE = 10**100
LOWER_PI = 16 * FIFTH[0] - 4 * OTHER[1]
UPPER_PI = 16 * FIFTH[1] - 4 * OTHER[0]
PI = ((int(LOWER_PI * SCALE), SCALE), (int(UPPER_PI * SCALE) + 1, SCALE))
"""Numbers below and above pi (Machin: pi/4 = 4 arctan 1/5 - arctan 1/239)."""


def times(p: list[int], a: int, b: int) -> list[int]:
    """p (a + b u)."""
    neighbours = zip([*p, 0], [0, *p], strict=True)
    return [a * x + b * y for x, y in neighbours]


def moved(p: list[int], low: Point, high: Point) -> list[int]:
    """The coefficients of p((a + b u)/(c + d u)) (c + d u)^n: from low = a/c at u = 0 to high = b/d
    at infinity."""
    a, c = low
    b, d = high
    # Horner's scheme with numerator and denominator apart, so that no fraction arises.
    coefficients = [p[-1]]
    power = [1]
    for n in p[-2::-1]:
        power = times(power, c, d)
        raised = times(coefficients, a, b)
        coefficients = [x + n * y for x, y in zip(raised, power, strict=True)]
    return coefficients


def sliced(p: Polynomial, low: Point = PI[0], high: Point = PI[1]) -> list[list[int]]:
    """The slices of p: polynomials without pi, of which p is a sum with positive weights for every
    value of pi (or of the free parameter in its place) between two numbers."""
    # With pi = (low + high v)/(1 + v), v > 0, each coefficient is a polynomial in v over one common
    # power of 1 + v. The slices are what stands at v^0, v^1, ...; equal lengths keep that power
    # common.
    width = max(map(len, p))
    in_v = []
    for row in p:
        missing = [0] * (width - len(row))
        in_v.append(moved([*row, *missing], low, high))
    return [list(x) for x in zip(*in_v, strict=True)]


def signs(slices: list[list[int]], low: Point, high: Point) -> list[int]:
    """The signs of a polynomial's Bernstein coefficients on [low, high], if all of its slices have
    the same ones; refused otherwise."""
    rows = []
    for row in slices:
        coefficients = moved(row, low, high)
        rows.append([(x > 0) - (x < 0) for x in coefficients])
    first = rows[0]
    # Equal signs in every slice survive the sum with positive weights, whatever the weights are.
    alike = all(row == first for row in rows)
    need(alike, "a sign stays open")
    return first


def order(row: Sequence[object]) -> int:
    """How many zeros stand before all else: a polynomial's order at 0."""
    there = [bool(x) for x in row]
    return there.index(True)


def turns(row: list[int]) -> int:
    """How often signs change, zeros left out."""
    others = [x for x in row if x]
    return sum(x != y for x, y in pairwise(others))


def pairs(row: Sequence[int]) -> list[tuple[int, int]]:
    """The first two of a list, the next two, and so on."""
    first, second = row[::2], row[1::2]
    return list(zip(first, second, strict=True))


def affordable(numbers: Iterable[Fraction], cost: int) -> None:
    """Refuse a certificate whose signs would take too long: ``cost`` is that of all signs at a
    number of one bit, and the work is proportional to the bits."""
    bits = 0
    for x in numbers:
        bits += x.denominator.bit_length()
        bits += x.numerator.bit_length()
    need(bits * cost < 5 * 10**9, "the cells are too many, or too fine")


class OmegaFactor:
    """A polynomial in omega^step, written as a sum of one term; ``WaveFactor`` has sines, cosines
    and powers in its terms.

    A term is a pair: exponents (of each sine, then of Re and Im of each power of omega), and a
    polynomial in omega.
    """

    step = 1
    powers = False  # whether powers of omega that are not whole stand in it

    def __init__(self, rows: Polynomial, step: int = 1, delays: int = 0, orders: int = 0) -> None:
        self.rows = rows
        self.step = step
        self.waves = (0,) * delays
        exponents = (0,) * (delays + 2 * orders)
        self.terms = [(exponents, rows)]
        # Moving takes about n^2 products of integers whose lengths grow with n.
        width = max(map(len, rows))
        self.cost = len(rows) ** 3 * width + 1000

    @cached_property
    def slices(self) -> list[list[int]]:
        """The slices of the polynomial for pi between its bounds."""
        return sliced(self.rows)

    @cached_property
    def size(self) -> int:
        """The words of all coefficients, and what it costs however few they are."""
        words = 10
        for _, p in self.terms:
            for row in p:
                words += sum(1 + c.bit_length() // 64 for c in row)
        return words

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Bounds of the degrees in omega, in pi, in each tangent, and in Re and Im of each power
        together."""
        count = len(self.waves)
        longest = max(len(p) for _, p in self.terms)
        widest = max(len(row) for _, p in self.terms for row in p)
        in_omega = self.step * (longest - 1)
        in_pi = widest - 1
        # Sines and cosines are homogeneous of degree n in each term: over cos^n that is a
        # polynomial of degree n in the tangent, so the degree is the factor's, not a term's.
        of_terms = []
        for exponents, _ in self.terms:
            real_and_imag = pairs(exponents[count:])
            of_terms.append([sum(x) for x in real_and_imag])
        in_powers = map(max, zip(*of_terms, strict=True))
        degrees = (in_omega, in_pi, *self.waves, *in_powers)
        missing = MOST_DELAYS_AND_ORDERS + 2 - len(degrees)
        return degrees + (0,) * missing

    @lru_cache(maxsize=500)  # noqa: B019 - a grid asks for the same ones often
    def values(self, x: int, pi: int) -> list[int]:
        """The values of the polynomials of all terms, with x for omega and a whole number for
        pi."""
        power = x**self.step
        values = []
        for _, p in self.terms:
            value = 0
            for n, row in enumerate(p):
                in_pi = sum(c * pi**k for k, c in enumerate(row))
                value += in_pi * power**n
            values.append(value)
        return values

    def at(self, x: int, pi: int, others: list[int]) -> GaussianValue:
        """The value, over cos(omega tau/2)^n for each delay, where tangents, and Re and Im of
        powers, are whole numbers."""
        total = 0
        values = self.values(x, pi)
        for (exponents, _), value in zip(self.terms, values, strict=True):
            total += value * prod(map(pow, others, exponents))
        return GaussianValue(total, 0, self.degrees)

    def signs(self, a: Fraction, b: Fraction) -> tuple[Fraction | int, list[int]]:
        """The order of the zero at a; signs whose changes are the zeros between a and b, then as
        many zeros as the order at b."""
        low = a**self.step
        high = b**self.step
        row = signs(self.slices, low.as_integer_ratio(), high.as_integer_ratio())
        n = order(row)
        # The polynomial is one in omega^step: at 0 its order in omega is step times as high, at
        # a > 0 omega^step - a^step has a simple zero and the order is the same.
        order_at_a = n if a else n * self.step
        return order_at_a, row[n:]

    def sign(self, x: Fraction) -> int:
        """The sign of its value at a rational number."""
        # On [x, infinity] the coefficient at u = 0 is the value at x times a positive number.
        power = x**self.step
        row = signs(self.slices, power.as_integer_ratio(), (1, 0))
        return row[0]
