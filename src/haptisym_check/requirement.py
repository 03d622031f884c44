"""Rule 6: for which values of a free parameter a display is transparent on its band, and for which
it is not."""

from collections.abc import Iterable
from fractions import Fraction
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

from haptisym_check.chart import ends_of_band
from haptisym_check.delayterms import WaveFactor, factor_of
from haptisym_check.polynomials import OmegaFactor, Point, affordable, moved, sliced
from haptisym_check.scene import PARTS, FactoredNumber, SceneFile, functions, link
from haptisym_check.values import keyed, listed, need, number, numbers, others

# Rule 6: over a slab of values a factor is a sum, with positive weights, of slices, which are
# functions of omega alone.


def point(x: Any, infinity: int) -> Point:
    """A value as numerator and denominator; infinity is 1/0 or -1/0."""
    return (infinity, 0) if x is None else number(x).as_integer_ratio()


def is_less(x: Point, y: Point) -> bool:
    """Whether x < y."""
    return x[0] * y[1] < y[0] * x[1]


class WavedFactor(WaveFactor):
    """A factor with waves that has other coefficients."""

    def __init__(self, x: WaveFactor, coefficients: Iterable[int]) -> None:
        self.delays, self.orders, self.waves, numbers = (
            x.delays,
            x.orders,
            x.waves,
            iter(coefficients),
        )
        self.terms = [(turns, [[next(numbers)] for _ in p]) for turns, p in x.terms]
        self.all = self.numbers(self.terms)


def rows_of(x: OmegaFactor) -> list[list[int]]:
    """All its coefficients."""
    return [row for _, p in x.terms for row in p]


def cost(x: OmegaFactor) -> tuple[int, int]:
    """Of the signs of its slices, as the limits have it: for each bit of a point, and with waves
    for each point."""
    n, width = len(rows_of(x)), max(map(len, rows_of(x)))
    return (
        (2 * n * width**2, x.cost * width)
        if isinstance(x, WaveFactor)
        else (2 * (n * width) ** 2 + 2000, 0)
    )


class Slices:
    """Those of a factor between two values."""

    def __init__(self, x: OmegaFactor, low: Point, high: Point) -> None:
        bits = sum(n.bit_length() for n in low + high)
        need(bits * max(map(len, rows_of(x))) < 10**5, "the ends of a slab are too long")
        self.step, self.rows = x.step, sliced(rows_of(x), low, high)
        self.waves = (
            [WavedFactor(x, row) if any(row) else None for row in self.rows]
            if isinstance(x, WaveFactor)
            else []
        )

    @lru_cache(maxsize=500)  # noqa: B019 - several functions have the same factors
    def signs(self, a: Fraction, b: Fraction) -> list[set[int]]:
        """Those that each slice may have from a to b; none where it is zero everywhere."""
        if self.waves:
            return [
                {*(x.signs(a, b)[1] if a < b else [x.sign(a)])} if x else set() for x in self.waves
            ]
        low, high = ((x**self.step).as_integer_ratio() for x in (a, b))
        return [{(x > 0) - (x < 0) for x in moved(row, low, high)} - {0} for row in self.rows]

    def side(self, a: Fraction, b: Fraction, closed: tuple[bool, bool]) -> int:
        """The sign from a to b, for all values between those two; ``closed``: for which of these it
        must have it as well."""
        every = self.signs(a, b)
        found = set[int]().union(*every)
        need(len(found) == 1, "a sign is not proven")
        need((every[0] or not closed[0]) and (every[-1] or not closed[1]), "a factor may be zero")
        return found.pop()


# Rule 6: for which values of a free parameter a display is transparent on its band, and for which
# it is not.


def verify(
    told: dict[str, FactoredNumber],
    slices: list[Slices],
    closed: tuple[bool, bool],
    points: Any,
    part: Any,
    scene: SceneFile,
) -> None:
    """That no excess is positive anywhere on the band, or that the one of a part is at some point
    of it."""
    (first, low), (high, last) = ends_of_band(scene)
    at = numbers(points, 500, 1)

    def sign(x: FactoredNumber, a: Fraction, b: Fraction) -> int:
        found = (x.number > 0) - (x.number < 0)
        for i, n in x.powers.items():
            found *= slices[i].side(a, b, closed if a == b or n < 0 else (False, False)) ** abs(n)
        return found

    if part is None:
        need(0 <= at[0] <= first and last <= at[-1], "the cells do not hold the band")
        every = (sign(x, a, b) for a, b in pairwise(at) for x in told.values())
        need(all(x <= 0 for x in every), "an excess may be positive")
    else:
        need(
            f"excess.{part}" in told and low <= at[0] == at[-1] <= high,
            "a point is not on the band",
        )
        need(sign(told[f"excess.{part}"], at[0], at[0]) > 0, "an excess may not be positive")


def values(
    told: dict[str, FactoredNumber], factors: list[OmegaFactor], slabs: Any, scene: SceneFile
) -> list[list[Any]]:
    """Intervals of values, ascending, each with whether the display is transparent for them, and
    which parts bind between."""
    rows = [keyed(x, "from", "to", "points", "part") for x in listed(slabs, 500, 1)]
    triples = [(low, high, x) for low, high, points, _ in rows for x in listed(points, 500, 1)]
    costs = [cost(x) for x in factors]
    affordable(
        (number(x) for triple in triples for x in triple if x is not None), sum(x for x, _ in costs)
    )
    need(
        len(triples) * sum(x for _, x in costs) < 10**8,
        "the cells are too many for factors with waves",
    )
    joins = [a[1] == b[0] and (a[3] is None) == (b[3] is None) for a, b in pairwise(rows)]
    found, binds = list[list[Any]](), list[str]()
    for i, ((low, high, points, part), *closed) in enumerate(
        zip(rows, [False, *joins], [*joins, False], strict=True)
    ):
        ends = point(low, -1), point(high, 1)
        after = not found or (low is not None and not is_less(ends[0], point(found[-1][1], 1)))
        need(is_less(*ends) and after, "the slabs do not ascend")
        need(
            closed[0] or not found or found[-1][2] != (part is None),
            "between two slabs there is more than an end",
        )
        slices = [Slices(x, *ends) for x in factors]
        verify(told, slices, (closed[0], closed[1]), points, part, scene)
        binds += [] if closed[0] or not found else [part or rows[i - 1][3]]
        found = (
            [*found[:-1], [found[-1][0], high, part is None]]
            if closed[0]
            else [*found, [low, high, part is None]]
        )
    return [found, binds]


def requirement(claim: dict[str, Any], proof: Any, scene: SceneFile) -> dict[str, Any]:
    """For which values of a free parameter the display is transparent on the band."""
    whole = isinstance(proof, dict) and {"delays": [], "orders": [], **proof}
    *rest, every, products, slabs = keyed(
        whole, "delays", "orders", "factors", "functions", "slabs"
    )
    parts = [part for part in PARTS if part in listed(claim.get("parts"), 2, 1)]
    need(parts, "the claim is of no part")
    delays, orders = others(*rest)
    factors = [factor_of(x, delays, orders) for x in listed(every, 500)]
    names, at_point = (
        [f"excess.{part}" for part in parts],
        partial(functions, scene, delays, orders),
    )
    told = link(products, names, factors, at_point, scene.length, (len(delays), len(orders)))
    found, binds = values(told, factors, slabs, scene)
    free = listed(claim.get("free"), 9, 1)
    return {"free": free, "parts": parts, "values": found, "binds": binds}
