"""Numbers between bounds (rules 7 and 8): sines, cosines and powers, and Taylor's sums with them."""

from fractions import Fraction
from functools import cache
from itertools import accumulate, repeat
from math import factorial

from haptisym_check.polynomials import PI
from haptisym_check.values import need

ORDER = 14
SCALE = (
    factorial(ORDER) * 10**70
)  # numbers are told in such parts of one: coefficients of whole numbers over factorials are exact
FINER = SCALE * 10**20
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
    one = FINER  # what is cut off, and the rest of the sums, stay below one part of one
    y, terms = int(x * one / 2**n), [one]
    for k in range(1, 52):
        terms.append(terms[-1] * y // (one * k))
    c, s = ((sum((-1) ** (k // 2) * terms[k] for k in range(i, 52, 2)) // 10**20, 2 * bool(x)) for i in (0, 1))
    for _ in range(n):
        [cc], [(a, b)], [(m, r)] = times([c], [c]), times([s], [s]), times([c], [s])
        c, s = (cc[0] - a, cc[1] + b), (2 * m, 2 * r)
    return [c, s]


def artanh(x: Fraction) -> int:
    """The sum of x^n/n, n odd, |x| <= 1/3, to a thousand parts of FINER."""
    y = int(x * FINER)
    total, square = y, y * y // FINER
    for n in range(3, 221, 2):
        y = y * square // FINER
        total += y // n
    return total


LN_2 = 2 * artanh(Fraction(1, 3))


def power(x: Fraction, alpha: Fraction) -> Ball:
    """x^alpha = exp(alpha ln x), x > 0 and 0 < alpha < 1; ln (1 + y)/(1 - y) = 2 artanh y."""
    n = x.numerator.bit_length() - x.denominator.bit_length()
    need(x > 0 and abs(n) < 10**5, "a number is too large, or too small")
    m = x / Fraction(2) ** n  # between 1/2 and 2
    k, y = divmod((2 * artanh((m - 1) / (m + 1)) + n * LN_2) * alpha.numerator // alpha.denominator, LN_2)
    term = total = FINER
    for i in range(1, 80):
        term = term * y // (FINER * i)
        total += term
    up, down = max(k, 0), max(-k, 0)
    return rounded(total << up, 10**12 << up, 10**20 << down)  # 2^k exp y


def binomial(alpha: Fraction, step: Fraction, x: Fraction) -> Series:
    """h^n/n! times the n-th derivative of omega^alpha at x."""
    weights = accumulate(range(ORDER), lambda w, n: w * (alpha - n) * step / (x * (n + 1)), initial=Fraction(1))
    return list(map(scaled, repeat(power(x, alpha)), weights))


def scaled(x: Ball, by: Fraction) -> Ball:
    """A ball times a number."""
    return rounded(x[0] * by.numerator, x[1] * abs(by.numerator), by.denominator)


def hull(x: Ball, y: Ball) -> Ball:
    """What holds two balls, and all between."""
    return (x[0] + y[0]) // 2, (abs(x[0] - y[0]) + 1) // 2 + max(x[1], y[1]) + 1


@cache
def power_of_pi(n: int) -> Ball:
    low, high = (x**n * SCALE // y**n for x, y in PI)
    return low, high - low + 1


def in_pi(row: list[int]) -> Ball:
    """A polynomial in pi."""
    found = [(c * power_of_pi(n)[0], abs(c) * power_of_pi(n)[1]) for n, c in enumerate(row)]
    return sum(x for x, _ in found), sum(x for _, x in found)
