"""Numbers and polynomials of a certificate, and their signs (rule 2)."""

import re
from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.scene import need

Polynomial = list[list[int]]  # coefficients, ascending, each ascending powers of pi
Point = tuple[int, int]  # numerator and denominator; (1, 0) is infinity


def arctangent(n: int, terms: int) -> list[Fraction]:
    """Bounds of arctan(1/n): an alternating series lies between two of its partial sums that follow one another."""
    sums = [sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(m)) for m in (terms, terms + 1)]
    return sorted(map(Fraction, sums))


FIFTH, OTHER, SCALE = arctangent(5, 75), arctangent(239, 22), 10**100
PI = (int((16 * FIFTH[0] - 4 * OTHER[1]) * SCALE), SCALE), (int((16 * FIFTH[1] - 4 * OTHER[0]) * SCALE) + 1, SCALE)
"""Numbers below and above pi (Machin: pi/4 = 4 arctan 1/5 - arctan 1/239)."""


def keyed(x: Any, *keys: str) -> list[Any]:
    """The values of an object that has these keys and no other."""
    need(isinstance(x, dict) and x.keys() == set(keys), f"expected an object with the keys {', '.join(keys)}")
    return [x[key] for key in keys]


def listed(x: Any, most: int, least: int = 0) -> list[Any]:
    need(isinstance(x, list) and least <= len(x) <= most, f"expected a list of {least} to {most} entries")
    return list(x)


def whole(x: Any, low: int, high: int) -> int:
    need(type(x) is int and low <= x <= high, f"expected a whole number from {low} to {high}")
    return int(x)


def number(x: Any) -> Fraction:
    pattern = r"-?[0-9]{1,2000}(/[1-9][0-9]{0,1999}|(\.[0-9]{1,2000})?(E[+-]?[0-9]{1,3})?)"
    need(isinstance(x, str) and re.fullmatch(pattern, x), f"{str(x)[:40]!r} is not a number")
    return Fraction(x)


def numbers(x: Any, most: int, least: int = 0) -> list[Fraction]:
    """A list of them that ascends."""
    found = [number(y) for y in listed(x, most, least)]
    need(all(a < b for a, b in pairwise(found)), "numbers do not ascend")
    return found


def polynomial(x: Any) -> Polynomial:
    rows = [listed(row, 100, 1) for row in listed(x, 300, 1)]
    good = all(isinstance(n, str) and re.fullmatch("-?[0-9]{1,2000}", n) for row in rows for n in row)
    need(good and any(n.strip("-0") for n in rows[-1]), "a polynomial is not one, or its leading coefficient is 0")
    return [[int(n) for n in row] for row in rows]


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
