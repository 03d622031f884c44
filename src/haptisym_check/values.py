"""Values of polynomials, exact, with bounds on their degrees; numbers, lists and objects of a
certificate; refusals.

A polynomial of several variables is never written out: it is computed at whole numbers, in Gaussian
integers, and carries a bound of its degree in each variable. If it vanishes at more points than
that bound allows it is zero (rule 1). ``keyed``, ``listed``, ``whole`` and ``number`` refuse
whatever the format does not allow, before anything is computed with it.
"""

import re
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import add
from typing import Any, NamedTuple

# Values of polynomials, exact, with bounds on their degrees; and what is said where a certificate
# proves nothing.


class RefusedError(Exception):
    """What a certificate does not prove, or what is not understood."""


class UnreadableError(RefusedError):
    """There is nothing to check: a file is missing, or is no JSON (the certificate), no TOML (the
    scene)."""


def need(condition: object, why: str) -> None:
    """Raise RefusedError with the reason unless the condition holds."""
    if not condition:
        raise RefusedError(why)


# Limits of the format: delays and orders together, as the grid has one dimension more for each, and
# bits of an integer, as a power of a power in a formula could otherwise be of any length.
MOST_OTHERS, MOST_BITS = 4, 30_000
Degrees = tuple[int, ...]


def degree(place: int, n: int = 1) -> Degrees:
    """The degrees of the n-th power of the variable at a place: s or omega, pi, tan(omega tau/2) of
    each delay, (j omega)^alpha of each order."""
    return (0,) * place + (n,) + (0,) * (MOST_OTHERS + 1 - place)


class GaussianValue(NamedTuple):
    """A Gaussian integer, the value of a polynomial at some point, with bounds on its degrees in
    each variable."""

    re: int
    im: int = 0
    degrees: Degrees = degree(0, 0)

    def plus(self, x: "GaussianValue", sign: int = 1) -> "GaussianValue":
        """x + y, or x - y."""
        return GaussianValue(
            self.re + sign * x.re, self.im + sign * x.im, tuple(map(max, self.degrees, x.degrees))
        )

    def times(self, x: "GaussianValue") -> "GaussianValue":
        """x y."""
        re, im = self.re * x.re - self.im * x.im, self.re * x.im + self.im * x.re
        need(re.bit_length() + im.bit_length() < MOST_BITS, "a number is too large")
        return GaussianValue(re, im, tuple(map(add, self.degrees, x.degrees)))

    def power(self, n: int) -> "GaussianValue":
        """x^n for n >= 0."""
        return reduce(GaussianValue.times, [self] * n) if n else ONE

    def conjugate(self) -> "GaussianValue":
        """The complex conjugate: for s = j omega a polynomial in omega, of the same degree."""
        return GaussianValue(self.re, -self.im, self.degrees)


# Numerator and denominator of a dynamics: nothing is divided, and common factors stay, as only the
# product across, left bottom - right top, is ever tested.
Ratio = tuple[GaussianValue, GaussianValue]
ONE = GaussianValue(1)
# The polynomial 0 has a degree below all others, also after it is multiplied by them.
ZERO = GaussianValue(0, 0, (-(10**6),) * (MOST_OTHERS + 2))


class ChainPoint(NamedTuple):
    """Where a chain is computed: s, and whole numbers in place of pi and of what depends on omega
    otherwise.

    ``others``: tan(omega tau/2) of delays tau, then Re and Im of (j omega)^alpha of orders alpha.
    """

    s: Ratio
    pi: int
    delays: tuple[Fraction, ...] = ()
    orders: tuple[Fraction, ...] = ()
    others: tuple[Any, ...] = ()

    def raised(self, exponent: Fraction) -> Ratio:
        """s to a power: a whole one, times that of an order."""
        n, order = int(exponent // 1), exponent % 1
        need(
            abs(n) < 100 and (not order or order in self.orders),
            "a power of s: the proof has no such order",
        )
        top, bottom = (x.power(abs(n)) for x in self.s[:: 1 if n >= 0 else -1])
        # A power that is not whole is one more variable, and no root is taken: identities in it
        # hold for all of its values, so also for s^alpha.
        i = len(self.delays) + self.orders.index(order) if order else 0
        re, im = self.others[i] if order else (1, 0)
        return top.times(GaussianValue(re, im, degree(2 + i, int(order > 0)))), bottom

    def delayed(self, lag: Fraction) -> GaussianValue:
        """(1 - j t)^n, where exp(-s lag) = ((1 - j t)/(1 + j t))^n and t = tan(omega tau/2) of the
        delay tau = lag/n of the proof."""
        if not lag:
            return ONE
        divisor = next((i for i, tau in enumerate(self.delays) if lag % tau == 0), None)
        i = divisor or 0
        # 64 keeps the degree in the tangent, and with it the grid, small.
        need(
            divisor is not None and lag / self.delays[i] <= 64,
            "a delay: the proof has none that it is a multiple of",
        )
        return GaussianValue(1, -self.others[i], degree(2 + i)).power(int(lag / self.delays[i]))


def combined(sign: str, x: Ratio, y: Ratio) -> Ratio:
    """x + y, x - y, x * y or x / y."""
    if sign in "*/":
        top, bottom = y if sign == "*" else y[::-1]
        return x[0].times(top), x[1].times(bottom)
    return x[0].times(y[1]).plus(y[0].times(x[1]), 1 if sign == "+" else -1), x[1].times(y[1])


# Numbers, lists and objects of a certificate.

Polynomial = list[list[int]]  # coefficients, ascending, each ascending powers of pi


def keyed(x: Any, *keys: str) -> list[Any]:
    """The values of an object that has these keys and no other."""
    need(
        isinstance(x, dict) and x.keys() == set(keys),
        f"expected an object with the keys {', '.join(keys)}",
    )
    return [x[key] for key in keys]


def listed(x: Any, most: int, least: int = 0) -> list[Any]:
    """A list of so many entries."""
    need(
        isinstance(x, list) and least <= len(x) <= most,
        f"expected a list of {least} to {most} entries",
    )
    return list(x)


def whole(x: Any, low: int, high: int) -> int:
    """A whole number within bounds."""
    # JSON's true is an int to Python, and no number of the format.
    need(type(x) is int and low <= x <= high, f"expected a whole number from {low} to {high}")
    return int(x)


def number(x: Any) -> Fraction:
    """A number as the format writes it."""
    # An exponent without a bound would let a short text stand for a number of any size.
    pattern = r"-?[0-9]{1,2000}(/[1-9][0-9]{0,1999}|(\.[0-9]{1,2000})?(E[+-]?[0-9]{1,3})?)"
    need(isinstance(x, str) and re.fullmatch(pattern, x), "a number is not written as one")
    return Fraction(x)


def numbers(x: Any, most: int, least: int = 0) -> list[Fraction]:
    """A list of numbers that ascends."""
    row = [number(y) for y in listed(x, most, least)]
    need(all(a < b for a, b in pairwise(row)), "numbers do not ascend")
    return row


def others(*told: Any) -> list[tuple[Fraction, ...]]:
    """The delays and the orders of a proof, from two lists of numbers."""
    delays, orders = (tuple(number(x) for x in listed(row, MOST_OTHERS)) for row in told)
    fits = all(0 < x < 2**100 and x.denominator < 2**100 for x in delays + orders)
    need(
        fits and all(x < 1 for x in orders) and len(delays + orders) <= MOST_OTHERS,
        "delays or orders are not positive, too large, or too many",
    )
    return [delays, orders]


def polynomial(x: Any) -> Polynomial:
    """The coefficients of a polynomial, ascending, each by powers of pi."""
    rows = [listed(row, 100, 1) for row in listed(x, 300, 1)]
    every = [n for row in rows for n in row]
    good = all(isinstance(n, str) and re.fullmatch("-?[0-9]{1,2000}", n) for n in every)
    # A leading coefficient with any part that is not 0 is not 0 at pi, which is transcendental: so
    # the degree is the length, as rules 2 and 5 need it.
    need(
        good and any(n.strip("-0") for n in rows[-1]),
        "a polynomial is not one, or its leading coefficient is 0",
    )
    return [[int(n) for n in row] for row in rows]
