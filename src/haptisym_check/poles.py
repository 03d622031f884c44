"""Rules 5 and 6: the poles of H_perc."""

from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.link import Product, link
from haptisym_check.polynomials import Polynomial, bounds, keyed, listed, number, polynomial, sign, whole
from haptisym_check.scene import Scene, Value, need


def even_odd(p: Polynomial) -> list[list[list[int]]]:
    """E and O of p(j omega) = E + j omega O, in omega^2, between bounds."""
    return [bounds([[c * (-1) ** k for c in row] for k, row in enumerate(p[i::2])] or [[0]]) for i in (0, 1)]


def turns_round(p: Polynomial, points: list[Fraction]) -> bool:
    """Rule 5: whether p(j omega) lies in one quadrant after the other."""
    even, odd = even_odd(p)
    signs = [(sign(even, x * x), sign(odd, x * x)) for x in points]
    wanted = [((1, 1), (-1, 1), (-1, -1), (1, -1))[k % 4] for k in range(len(p) - 1)]
    return [(a * signs[0][0], b * signs[0][0]) for a, b in signs] == wanted and all(
        x < y for x, y in pairwise([Fraction(0), *points])
    )


def around(p: Polynomial, x: Fraction, y: Fraction, r: Fraction, k: int) -> bool:
    """Whether p has k zeros (0 or 1) within r of x + j y: by Rouche, as one Taylor coefficient is larger than all others."""
    rows = bounds(p)
    spread = [
        (high - low) * (abs(x) + abs(y) + r) ** i for i, (low, high) in enumerate(zip(rows[0], rows[-1], strict=True))
    ]
    found: list[tuple[Fraction, Fraction]] = []
    for c in rows[0][::-1]:  # p(z + u) by Horner: times z + u, plus the next coefficient
        longer = [*found, (Fraction(0), Fraction(0))]
        times = [(a * x - b * y, a * y + b * x) for a, b in longer]
        found = [(a + e, b + f) for (a, b), (e, f) in zip(times, [(Fraction(c), Fraction(0)), *found], strict=True)]
    sizes = [(abs(a) + abs(b)) * r**i for i, (a, b) in enumerate(found)]
    return len(found) > k and max(map(abs, found[k])) * r**k > sum(sizes) - sizes[k] + sum(spread)


def poles(x: Any, scene: Scene) -> bool | None:
    """Whether H_perc is proven stable, or proven not to be; None where nothing is said."""
    if x is None:
        return None
    value, top, rows, turns, disc = keyed(x, "number", "numerator", "factors", "turns", "disc")
    pairs, numerator = [listed(row, 2, 2) for row in listed(rows, 100)], polynomial(top)
    factors = [polynomial(p) for p, _ in pairs]
    every = [(1, numerator), *((1, p) for p in factors)]
    powers = [[0, 1], *([i, -whole(n, 1, 100)] for i, (_, n) in enumerate(pairs, 1))]
    told = {"H_perc": Product({"number": value, "omega": 0, "powers": powers}, len(every))}
    link(told, every, lambda s, pi: {"H_perc": scene.at(Value(s, s=1), pi)[1]})
    if disc is None:
        points = [[number(z) for z in listed(row, 300)] for row in listed(turns, len(factors), len(factors))]
        need(all(map(turns_round, factors, points)), "a factor of the denominator does not turn through the quadrants")
        return True
    index, a, b, c = listed(disc, 4, 4)
    p, x, y, r = factors[whole(index, 0, len(factors) - 1)], number(a), number(b), number(c)
    even, odd = even_odd(p)
    on_axis = (
        x == 0 and y >= r >= 0 and not any(map(any, odd)) and sign(even, (y - r) ** 2) * sign(even, (y + r) ** 2) <= 0
    )
    at_0 = x == y == 0 and not any(p[0])
    need(on_axis or at_0 or (x >= r > 0 and around(p, x, y, r, 1)), "the disc may hold no pole with Re s >= 0")
    need(around(numerator, x, y, r, 0), "the numerator may vanish with the denominator")
    return False
