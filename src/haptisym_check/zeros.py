"""Rule 5: how many zeros a function of s has in Re s >= 0."""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.factors import Factor
from haptisym_check.link import Product, link
from haptisym_check.polynomials import signs, sliced, turns
from haptisym_check.reading import Polynomial, keyed, listed, numbers, polynomial
from haptisym_check.scene import Point, Ratio, need

PRIME = 2**61 - 1


def coprime(p: Polynomial, q: Polynomial) -> bool:
    """Whether p and q have no zero in common, not even with 3 in place of pi and modulo a prime."""
    a, b = ([sum(c * 3**i for i, c in enumerate(row)) % PRIME for row in x] for x in (p, q))
    whole = bool(a[-1] and b[-1])
    while b:  # Euclid: what is left of a when b is taken from it
        while len(a) >= len(b):
            by = a[-1] * pow(b[-1], -1, PRIME)
            a = [(x - by * y) % PRIME for x, y in zip(a, [0] * (len(a) - len(b)) + b, strict=True)]
            while a and not a[-1]:
                a.pop()
        a, b = b, a
    return whole and len(a) == 1


def to_the_right(p: Polynomial, points: list[Fraction]) -> int:
    """The zeros of p in Re s >= 0, from the turns of p(j omega) = E + j omega O between points of omega^2."""
    even, odd = (sliced([[c * (-1) ** k for c in row] for k, row in enumerate(p[i::2])] or [[0]]) for i in (0, 1))
    left, last = 0, 0  # zeros in Re s < 0, less those in Re s >= 0; the sign of E O at the end
    for low, high in pairwise([(0, 1), *(x.as_integer_ratio() for x in points), (1, 0)]):
        e, o = signs(even, low, high), signs(odd, low, high)
        need(e[0] and (e[-1] or high == (1, 0)), "E is zero between two cells")
        need(turns(e) + turns(o) < 2 or not turns(e), "a cell may hold two zeros")
        side = next((x for x in o if x), 0)
        left += 2 * turns(e) * (e[0] * side if side else -1)
        last = [x for x in e if x][-1] * next((x for x in o[::-1] if x), 0)
    return (len(p) - 1 - left - (len(p) - 1) % 2 * last) // 2


def zeros(x: Any, function: Callable[[Point], Ratio]) -> int:
    """Those in Re s >= 0 of a function of s and pi, counted with multiplicity."""
    told, product, cells = keyed(x, "factors", "function", "cells")
    factors = [polynomial(p) for p in listed(told, 100)]
    linked = [Factor(p) for p in factors]
    own = Product(product, linked)
    link({"the function": own}, linked, lambda point: {"the function": function(point)})
    need(own.number, "a function is zero everywhere")
    points, count = [numbers(row, 300) for row in listed(cells, len(factors), len(factors))], max(own.omega, 0)
    need(all(row[0] > 0 for row in points if row), "a cell is empty")
    below = [factors[i] for i, n in own.powers.items() if n < 0]
    need(not count or all(any(q[0]) for q in below), "a zero at s = 0 may be none")
    for i, n in own.powers.items():
        found = to_the_right(factors[i], points[i]) if n > 0 else 0
        need(
            not found or all(coprime(factors[i], q) for q in below), "a zero may be none: the denominator may share it"
        )
        count += n * found
    return count
