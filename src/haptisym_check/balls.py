"""Numbers with bounds of their errors (rules 7 and 8): sines, cosines and powers, all in parts of one."""

from fractions import Fraction
from functools import cache
from itertools import accumulate

from haptisym_check.polynomials import PI
from haptisym_check.values import need

BITS, GUARD = 280, 64
SCALE, FINER = 1 << BITS, 1 << (BITS + GUARD)
Ball = tuple[int, int]
"""All numbers within a radius of a middle."""


def parts(x: Fraction) -> int:
    """A number to one part of one."""
    return (x.numerator << BITS) // x.denominator


def circle(x: Fraction) -> list[int]:
    """cos x, -sin x, -cos x, sin x, x >= 0, to two parts of one: Taylor's sums at x/2^n < 1/2, and n times twice the angle.

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
    k, y = divmod((2 * artanh((m - 1) / (m + 1)) + n * LN_2) * alpha.numerator // alpha.denominator, LN_2)
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
