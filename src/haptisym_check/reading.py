"""Numbers, lists and objects of a certificate."""

import re
from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.values import MOST_OTHERS, need

Polynomial = list[list[int]]  # coefficients, ascending, each ascending powers of pi


def keyed(x: Any, *keys: str) -> list[Any]:
    """The values of an object that has these keys and no other."""
    need(isinstance(x, dict) and x.keys() == set(keys), f"expected an object with the keys {', '.join(keys)}")
    return [x[key] for key in keys]


def listed(x: Any, most: int, least: int = 0) -> list[Any]:
    """A list of so many entries."""
    need(isinstance(x, list) and least <= len(x) <= most, f"expected a list of {least} to {most} entries")
    return list(x)


def whole(x: Any, low: int, high: int) -> int:
    """A whole number within bounds."""
    need(type(x) is int and low <= x <= high, f"expected a whole number from {low} to {high}")
    return int(x)


def number(x: Any) -> Fraction:
    """A number as the format writes it."""
    pattern = r"-?[0-9]{1,2000}(/[1-9][0-9]{0,1999}|(\.[0-9]{1,2000})?(E[+-]?[0-9]{1,3})?)"
    need(isinstance(x, str) and re.fullmatch(pattern, x), "a number is not written as one")
    return Fraction(x)


def numbers(x: Any, most: int, least: int = 0) -> list[Fraction]:
    """A list of them that ascends."""
    found = [number(y) for y in listed(x, most, least)]
    need(all(a < b for a, b in pairwise(found)), "numbers do not ascend")
    return found


def others(*told: Any) -> list[tuple[Fraction, ...]]:
    """Delays and orders."""
    delays, orders = (tuple(number(x) for x in listed(row, MOST_OTHERS)) for row in told)
    fits = all(0 < x < 2**100 and x.denominator < 2**100 for x in delays + orders) and all(x < 1 for x in orders)
    need(fits and len(delays + orders) <= MOST_OTHERS, "delays or orders are not positive, too large, or too many")
    return [delays, orders]


def polynomial(x: Any) -> Polynomial:
    """Its coefficients, ascending, each by powers of pi."""
    rows = [listed(row, 100, 1) for row in listed(x, 300, 1)]
    good = all(isinstance(n, str) and re.fullmatch("-?[0-9]{1,2000}", n) for row in rows for n in row)
    need(good and any(n.strip("-0") for n in rows[-1]), "a polynomial is not one, or its leading coefficient is 0")
    return [[int(n) for n in row] for row in rows]
