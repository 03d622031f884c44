"""Rule 5: how many zeros a function of s has in Re s >= 0."""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.link import link
from haptisym_check.polynomials import Factor, affordable, order, signs, sliced, turns
from haptisym_check.reading import Polynomial, keyed, listed, numbers, polynomial
from haptisym_check.values import ONE, Point, Ratio, need

PRIME = 2**61 - 1


def coprime(p: Polynomial, q: Polynomial) -> bool:
    """Whether p and q have no zero in common, not even with 3 in place of pi and modulo a prime."""
    a, b = ([sum(c * 3**i for i, c in enumerate(row)) % PRIME for row in x] for x in (p, q))
    while a[-1] and b and b[-1]:  # Euclid: what is left of a when b is taken from it
        while len(a) >= len(b):
            by = a[-1] * pow(b[-1], -1, PRIME)
            a = [(x - by * y) % PRIME for x, y in zip(a, [0] * (len(a) - len(b)) + b, strict=True)]
            while a and not a[-1]:
                a.pop()
        a, b = b, a
    return not b and len(a) == 1


def to_the_right(p: Polynomial, points: list[Fraction]) -> int:
    """The zeros of p in Re s >= 0: that at 0, and what the turns of p(j omega) = E + j omega O between points of omega^2 tell."""
    at_0 = order([any(row) for row in p])
    n, p = len(p) - 1 - at_0, p[at_0:]
    even, odd = (sliced([[c * (-1) ** k for c in row] for k, row in enumerate(p[i::2])] or [[0]]) for i in (0, 1))
    left, last = 0, 0  # zeros in Re s < 0, less those in Re s >= 0; the sign of E O at the end
    for low, high in pairwise([*(x.as_integer_ratio() for x in points), (1, 0)]):
        e, o = signs(even, low, high), signs(odd, low, high)
        need(e[0] and (e[-1] or high == (1, 0)), "E is zero between two cells")
        need(turns(e) + turns(o) < 2 or not turns(e), "a cell may hold two zeros")
        side = next((x for x in o if x), 0)
        left += 2 * turns(e) * (e[0] * side if side else -1)
        last = [x for x in e if x][-1] * o[-1]  # which counts where n is odd: the highest power is one of O
    return at_0 + (n - left - n % 2 * last) // 2


def zeros(x: Any, function: Callable[[Point], Ratio], length: int, share: int = 1) -> int:
    """Those in Re s >= 0 of a function of s and pi, counted with multiplicity; ``length``, ``share``: as ``link`` has them."""
    told, product, cells = keyed(x, "factors", "function", "cells")
    factors = [Factor(polynomial(p)) for p in listed(told, 100)]
    values = lambda s, pi: {"it": function(Point((s, ONE), pi))}  # noqa: E731
    own = link({"it": product}, ["it"], factors, values, length, share=share)["it"]
    need(own.number, "a function is zero everywhere")
    rows, count = listed(cells, len(factors), len(factors)), 0
    points = [numbers(["0", *listed(row, 300)], 301) for row in rows]
    for i, n in own.powers.items():
        affordable(points[i], factors[i].cost * len(factors) * share)
        found = to_the_right(factors[i].rows, points[i]) if n > 0 else 0
        below = [factors[k].rows for k, m in own.powers.items() if m < 0 and found]
        need(all(coprime(factors[i].rows, q) for q in below), "a zero may be none: the denominator may share it")
        count += n * found
    return count
