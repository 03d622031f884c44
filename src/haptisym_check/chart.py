"""Rules 2 to 5: the places of the band, the signs around them, and how many zeros are in Re s >=
0."""

from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import chain, groupby, pairwise
from math import ceil, floor, prod
from typing import Any

from haptisym_check.polynomials import PI, OmegaFactor, affordable, order, signs, sliced, turns
from haptisym_check.scene import PARTS, FactoredNumber, SceneFile, link
from haptisym_check.values import (
    ONE,
    ChainPoint,
    Polynomial,
    Ratio,
    keyed,
    listed,
    need,
    numbers,
    polynomial,
)

# Rules 2, 3 and 4: the places of the band, and what follows from the signs around them.


def ends_of_band(scene: SceneFile) -> list[list[Fraction]]:
    """Bounds of its low end, and of its high end."""
    low, high = (sorted(x.value * Fraction(*pi) ** x.pi for pi in PI) for x in scene.band)
    need(low[1] < high[0], "the band is empty")
    return [low, high]


class PlaceTable:
    """The places of the band in order, with the orders of all factors there, and their signs in
    between."""

    def __init__(
        self,
        scene: SceneFile,
        points: list[Fraction],
        factors: list[OmegaFactor],
        told: list[list[Fraction]],
    ) -> None:
        """``told``: the enclosures of the places."""
        low, high = ends_of_band(scene)
        need(
            0 <= points[0] <= low[0] and low[1] <= points[1],
            "the first cell does not hold the low end of the band",
        )
        need(
            points[-2] <= high[0] and high[1] <= points[-1],
            "the last cell does not hold the high end of the band",
        )
        need(holds(told[0], low), "the low end of the band is not in its enclosure")
        need(holds(told[-1], high), "the high end of the band is not in its enclosure")
        affordable(points, sum(x.cost for x in factors))
        affordable(chain(*told), max((x.cost for x in factors), default=0) // 10)
        self.from_0, self.orders, self.signs = low[1] == 0, list[list[Any]](), list[list[int]]()
        self.powers = [x.powers for x in factors]
        for a, b in pairwise(points):
            leads, found = (
                zip(*(x.signs(a, b) for x in factors), strict=True) if factors else ((), ())
            )
            inner, counts = [[x for x in row if x] for row in found], list(map(turns, found))
            last = [order(row[::-1]) for row in found]
            fits = (low == [a, a] or not any(leads)) and (high == [b, b] or not any(last))
            need(fits, "a factor is zero at a breakpoint")
            most = 1 if low[1] <= a and b <= high[0] else 0
            need(sum(counts) <= most, "a cell may hold two zeros, or one beside an end of the band")
            self.orders, self.signs = (
                self.orders or [list(leads)],
                self.signs or [[x[0] for x in inner]],
            )
            if any(counts):
                own, (x, y) = factors[counts.index(1)], told[min(len(self.orders), len(told) - 1)]
                need(
                    a < x <= y < b and own.sign(x) * own.sign(y) <= 0, "an enclosure holds no zero"
                )
                self.orders.append(counts)
                self.signs.append([x[-1] for x in inner])
        self.orders.append(last)
        need(len(told) == len(self.orders), "there are not as many frequencies as places")


def holds(enclosure: list[Fraction], x: list[Fraction]) -> bool:
    """Whether a place lies in an enclosure."""
    return enclosure[0] <= x[0] and x[1] <= enclosure[1]


def away(order: Fraction | int) -> int:
    """A whole number, rounded away from 0."""
    return ceil(order) if order > 0 else floor(order)


class SignRow:
    """The orders of a function at the places, and its signs before, at and after each."""

    def __init__(self, x: FactoredNumber, chart: PlaceTable) -> None:
        self.order = [
            away(sum(n * found[i] for i, n in x.powers.items())) for found in chart.orders
        ]
        own = (x.number > 0) - (x.number < 0)
        self.between = [
            own * prod(row[i] ** abs(n) for i, n in x.powers.items()) for row in chart.signs
        ]
        one_sided = chart.from_0 and any(
            chart.powers[i] for i in x.powers
        )  # a power of omega has no other side
        self.before = [
            self.between[0] * (-1) ** (0 if one_sided else abs(self.order[0])),
            *self.between,
        ]
        self.after = [*self.between, self.between[-1] * (-1) ** abs(self.order[-1])]
        self.at = [
            0 if n > 0 or a != b else b
            for n, a, b in zip(self.order, self.before, self.after, strict=True)
        ]
        self.line = [x for pair in zip(self.at, self.after, strict=True) for x in pair][
            :-1
        ]  # places and pieces


def runs(line: Iterable[Any]) -> list[tuple[int, int, Any]]:
    """The longest pieces of one value, of a line of places and what is between them, as pairs of
    places."""
    rows = [(x, [i for i, _ in row]) for x, row in groupby(enumerate(line), key=lambda x: x[1])]
    return [(row[0] // 2, (row[-1] + 1) // 2, x) for x, row in rows if x]


def where(test: Callable[[int], bool], *curves: SignRow) -> list[list[int]]:
    """As few closed intervals as possible, of places and of what is between: where all curves
    pass."""
    return [
        [a, b]
        for a, b, _ in runs(all(map(test, x)) for x in zip(*(c.line for c in curves), strict=True))
    ]


def claimed(curves: dict[str, SignRow], *, from_0: bool) -> dict[str, Any]:
    """All that is said of a band, from the chart alone."""
    excess, active = {part: curves[f"excess.{part}"] for part in PARTS}, curves["perceived.imag"]
    places, crossings = range(len(active.order)), []
    for i, (part, c) in ((i, x) for i in places for x in excess.items() if x[1].order[i] > 0):
        touches = c.before[i] == c.after[i] and not (i == 0 and from_0 and c.after[i] > 0)
        kind = "touches" if touches else "exceeds" if c.after[i] > 0 else "returns"
        side = curves[f"difference.{part}"].after[i]
        crossings.append(
            {"at": i, "part": part, "kind": kind, "sign": side, "multiplicity": c.order[i]}
        )
    turning = {name: curves[f"{name}.real"] for name in ("environment", "perceived")}
    return {
        "crossings": crossings,
        "transparent": where(lambda x: x <= 0, *excess.values()),
        "changeovers": {
            name: [i for i in places if c.before[i] * c.after[i] < 0] for name, c in turning.items()
        },
        "percepts": [
            x for part in PARTS for x in percepts(part, *(curves[f"{x}.{part}"] for x in CURVES))
        ],
        "outside_model": where(lambda x: x < 0, active),
        "unbounded": [i for i in places if any(c.order[i] < 0 for c in excess.values())],
    }


CURVES = "environment", "perceived", "excess", "difference", "sum"
PROPERTIES = {
    (1, 1): "stiffness",
    (-1, -1): "mass",
    (1, -1): "stiffness-to-mass",
    (-1, 1): "mass-to-stiffness",
}


def percepts(
    part: str, env: SignRow, perc: SignRow, excess: SignRow, change: SignRow, both: SignRow
) -> list[dict[str, Any]]:
    """What is felt where a ratio exceeds its threshold."""
    line: list[Any] = []
    for i, (x, y, e, n) in enumerate(
        zip(env.between, perc.between, excess.between, both.between, strict=True)
    ):
        felt = None
        if e > 0 and (part == "real" or y >= 0):
            kind = PROPERTIES[x or y, y or x] if part == "real" else "damping"
            felt = kind, ("equal", "higher", "lower")[change.between[i] * n]
        line += [felt if line and felt == line[-1] and excess.at[i] > 0 else None, felt]
    return [
        {"part": part, "from": a, "to": b, "property": x, "change": y}
        for a, b, (x, y) in runs(line)
    ]


# Rule 5: how many zeros a function of s has in Re s >= 0.

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
    """The zeros of p in Re s >= 0: that at 0, and what the turns of p(j omega) = E + j omega O
    between points of omega^2 tell."""
    at_0 = order([any(row) for row in p])
    n, p = len(p) - 1 - at_0, p[at_0:]
    even, odd = (
        sliced([[c * (-1) ** k for c in row] for k, row in enumerate(p[i::2])] or [[0]])
        for i in (0, 1)
    )
    left, last = 0, 0  # zeros in Re s < 0, less those in Re s >= 0; the sign of E O at the end
    for low, high in pairwise([*(x.as_integer_ratio() for x in points), (1, 0)]):
        e, o = signs(even, low, high), signs(odd, low, high)
        need(e[0] and (e[-1] or high == (1, 0)), "E is zero between two cells")
        need(turns(e) + turns(o) < 2 or not turns(e), "a cell may hold two zeros")
        side = next((x for x in o if x), 0)
        left += 2 * turns(e) * (e[0] * side if side else -1)
        last = [x for x in e if x][-1] * o[
            -1
        ]  # which counts where n is odd: the highest power is one of O
    return at_0 + (n - left - n % 2 * last) // 2


def zeros(x: Any, function: Callable[[ChainPoint], Ratio], length: int, share: int = 1) -> int:
    """Those in Re s >= 0 of a function of s and pi, counted with multiplicity; ``length``,
    ``share``: as ``link`` has them."""
    told, product, cells = keyed(x, "factors", "function", "cells")
    factors = [OmegaFactor(polynomial(p)) for p in listed(told, 100)]
    values = lambda s, pi: {"it": function(ChainPoint((s, ONE), pi))}  # noqa: E731
    own = link({"it": product}, ["it"], factors, values, length, share=share)["it"]
    need(own.number, "a function is zero everywhere")
    rows, count = listed(cells, len(factors), len(factors)), 0
    points = [numbers(["0", *listed(row, 300)], 301) for row in rows]
    for i, n in own.powers.items():
        affordable(points[i], factors[i].cost * len(factors) * share)
        found = to_the_right(factors[i].rows, points[i]) if n > 0 else 0
        below = [factors[k].rows for k, m in own.powers.items() if m < 0 and found]
        need(
            all(coprime(factors[i].rows, q) for q in below),
            "a zero may be none: the denominator may share it",
        )
        count += n * found
    return count
