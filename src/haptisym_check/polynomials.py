"""Numbers and polynomials of a certificate, and their signs (rule 2)."""

import re
from fractions import Fraction
from typing import Any

from haptisym_check.scene import need

Polynomial = list[list[int]]  # coefficients, ascending, each ascending powers of pi


def arctangent(n: int, terms: int) -> list[Fraction]:
    """Bounds of arctan(1/n): an alternating series lies between two of its partial sums that follow one another."""
    sums = [sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(m)) for m in (terms, terms + 1)]
    return sorted(map(Fraction, sums))


FIFTH, OTHER, SCALE = arctangent(5, 75), arctangent(239, 22), 10**100
PI = int((16 * FIFTH[0] - 4 * OTHER[1]) * SCALE), int((16 * FIFTH[1] - 4 * OTHER[0]) * SCALE) + 1
"""Whole numbers below and above pi 10^100 (Machin: pi/4 = 4 arctan 1/5 - arctan 1/239)."""


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


def polynomial(x: Any) -> Polynomial:
    rows = [listed(row, 100, 1) for row in listed(x, 300, 1)]
    good = all(isinstance(n, str) and re.fullmatch("-?[0-9]{1,2000}", n) for row in rows for n in row)
    need(good and any(n.strip("-0") for n in rows[-1]), "a polynomial is not one, or its leading coefficient is 0")
    return [[int(n) for n in row] for row in rows]


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    need(len(dict(pairs)) == len(pairs), "a key stands twice")
    return dict(pairs)


def small(text: str) -> int:
    need(re.fullmatch("-?[0-9]{1,6}", text), f"{text[:40]} is no small whole number")
    return int(text)


def bounds(p: Polynomial) -> list[list[int]]:
    """Polynomials below and above p, coefficient by coefficient, times one positive number; only one without pi."""
    n = max(map(len, p)) - 1
    ends = [
        [sum(c * PI[end ^ (c < 0)] ** i * SCALE ** (n - i) for i, c in enumerate(row)) for row in p] for end in (0, 1)
    ]
    return ends if n else ends[:1]


def agreed(rows: list[list[int]]) -> list[int]:
    """The signs of numbers that are known between bounds."""
    signs = [[(x > 0) - (x < 0) for x in row] for row in rows]
    need(signs[0] == signs[-1], "a sign stays open")
    return signs[0]


def moved(p: list[int], a: Fraction, b: Fraction) -> list[int]:
    """The coefficients of (1 + u)^n p((a + b u)/(1 + u)), times a positive number."""
    e = a.denominator * b.denominator
    low, high, found, binomial, scale = int(a * e), int(b * e), [p[-1]], [1], 1
    for c in p[-2::-1]:
        scale *= e
        binomial = [x + y for x, y in zip([*binomial, 0], [0, *binomial], strict=True)]
        found = [low * x + high * y for x, y in zip([*found, 0], [0, *found], strict=True)]
        found = [x + c * scale * y for x, y in zip(found, binomial, strict=True)]
    return found


def sign(p: list[list[int]], x: Fraction) -> int:
    """The sign at a number >= 0 of a polynomial known between bounds."""
    return agreed([[moved(row, x, x + 1)[0]] for row in p])[0]
