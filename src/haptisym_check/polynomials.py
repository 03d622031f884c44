"""Pi, and the signs of polynomials (rule 2)."""

from fractions import Fraction
from itertools import pairwise

from haptisym_check.reading import Polynomial
from haptisym_check.scene import need

Point = tuple[int, int]  # numerator and denominator; (1, 0) is infinity


def arctangent(n: int, terms: int) -> list[Fraction]:
    """Bounds of arctan(1/n): an alternating series lies between two of its partial sums that follow one another."""
    sums = [sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(m)) for m in (terms, terms + 1)]
    return sorted(map(Fraction, sums))


FIFTH, OTHER, SCALE = arctangent(5, 75), arctangent(239, 22), 10**100
PI = (int((16 * FIFTH[0] - 4 * OTHER[1]) * SCALE), SCALE), (int((16 * FIFTH[1] - 4 * OTHER[0]) * SCALE) + 1, SCALE)
"""Numbers below and above pi (Machin: pi/4 = 4 arctan 1/5 - arctan 1/239)."""


def times(p: list[int], a: int, b: int) -> list[int]:
    """p (a + b u)."""
    return [a * x + b * y for x, y in zip([*p, 0], [0, *p], strict=True)]


def moved(p: list[int], low: Point, high: Point) -> list[int]:
    """The coefficients of p((a + b u)/(c + d u)) (c + d u)^n: from low = a/c at u = 0 to high = b/d at infinity."""
    found, power = [p[-1]], [1]
    for c in p[-2::-1]:
        power = times(power, low[1], high[1])
        found = [x + c * y for x, y in zip(times(found, low[0], high[0]), power, strict=True)]
    return found


def sliced(p: Polynomial, low: Point = PI[0], high: Point = PI[1]) -> list[list[int]]:
    """Polynomials whose sum, with positive weights, p is for every value between two of what stands beside its variable."""
    width = max(map(len, p))
    return [list(x) for x in zip(*(moved([*row, *[0] * (width - len(row))], low, high) for row in p), strict=True)]


def signs(slices: list[list[int]], low: Point, high: Point) -> list[int]:
    """Those of the coefficients of a polynomial: all slices have them."""
    found = [[(x > 0) - (x < 0) for x in moved(row, low, high)] for row in slices]
    need(all(row == found[0] for row in found), "a sign stays open")
    return found[0]


def sign(rows: list[list[int]], x: Fraction) -> int:
    """The sign at a number >= 0."""
    return signs(rows, x.as_integer_ratio(), (1, 0))[0]


def turns(found: list[int]) -> int:
    """How often signs change, zeros left out."""
    return sum(x != y for x, y in pairwise([x for x in found if x]))
