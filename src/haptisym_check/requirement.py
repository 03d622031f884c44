"""Rule 6: for which values of a free parameter a display is transparent on its band, and for which it is not."""

from fractions import Fraction
from itertools import pairwise
from typing import Any

from haptisym_check.chart import ends_of_band
from haptisym_check.link import Product
from haptisym_check.polynomials import Factor, Point, affordable, moved, sliced
from haptisym_check.reading import keyed, listed, number, numbers
from haptisym_check.scene import Scene
from haptisym_check.values import need


def side(slices: list[list[int]], a: Fraction, b: Fraction, closed: tuple[bool, bool] | None) -> int:
    """The sign from a to b, for all values of a slab; zero nowhere if ``closed`` says which of its borders belong to it."""
    rows = [moved(q, a.as_integer_ratio(), b.as_integer_ratio()) for q in slices]
    found = {(x > 0) - (x < 0) for row in rows for x in row} - {0}
    need(len(found) == 1, "a sign is not proven")
    borders = [row for row, own in zip((rows[0], rows[-1]), closed or (), strict=False) if own]
    need(closed is None or (all(map(any, zip(*rows, strict=True))) and all(map(all, borders))), "a factor may be zero")
    return found.pop()


def point(x: Any, infinity: int) -> Point:
    """A value as numerator and denominator; infinity is 1/0 or -1/0."""
    return (infinity, 0) if x is None else number(x).as_integer_ratio()


def is_less(x: Point, y: Point) -> bool:
    """Whether x < y."""
    return x[0] * y[1] < y[0] * x[1]


Slices = list[tuple[int, list[list[int]]]]


def verify(
    told: dict[str, Product], slices: Slices, closed: tuple[bool, bool], points: Any, part: Any, scene: Scene
) -> None:
    """That no excess is positive anywhere on the band, or that the one of a part is at some point of it."""
    (first, low), (high, last) = ends_of_band(scene)
    at = numbers(points, 500, 1)

    def sign(x: Product, a: Fraction, b: Fraction, *, firm: bool) -> int:
        found = (x.number > 0) - (x.number < 0)
        for i, n in x.powers.items():
            step, own = slices[i]
            found *= side(own, a**step, b**step, closed if firm or n < 0 else None) ** abs(n)
        return found

    if part is None:
        need(0 <= at[0] <= first and last <= at[-1], "the cells do not hold the band")
        for x in told.values():
            need(all(sign(x, a, b, firm=False) <= 0 for a, b in pairwise(at)), "an excess may be positive")
    else:
        need(f"excess.{part}" in told and low <= at[0] == at[-1] <= high, "a point is not on the band")
        need(sign(told[f"excess.{part}"], at[0], at[0], firm=True) > 0, "an excess may not be positive")


def values(told: dict[str, Product], factors: list[Factor], slabs: Any, scene: Scene) -> list[list[Any]]:
    """Intervals of values, ascending, each with whether the display is transparent for them, and which parts bind between."""
    rows = [keyed(x, "from", "to", "points", "part") for x in listed(slabs, 500, 1)]
    cost = 2 * sum((len(x.rows) * max(map(len, x.rows))) ** 2 + 1000 for x in factors)
    triples = ((low, high, x) for low, high, points, _ in rows for x in listed(points, 500, 1))
    affordable((number(x) for triple in triples for x in triple if x is not None), cost)
    joins = [a[1] == b[0] and (a[3] is None) == (b[3] is None) for a, b in pairwise(rows)]
    found, binds = list[list[Any]](), list[str]()
    for i, ((low, high, points, part), *closed) in enumerate(zip(rows, [False, *joins], [*joins, False], strict=True)):
        ends = point(low, -1), point(high, 1)
        after = not found or (low is not None and not is_less(ends[0], point(found[-1][1], 1)))
        need(is_less(*ends) and after, "the slabs do not ascend")
        need(closed[0] or not found or found[-1][2] != (part is None), "between two slabs there is more than an end")
        slices = [(x.step, sliced(x.rows, *ends)) for x in factors]
        verify(told, slices, (closed[0], closed[1]), points, part, scene)
        binds += [] if closed[0] or not found else [part or rows[i - 1][3]]
        found = [*found[:-1], [found[-1][0], high, part is None]] if closed[0] else [*found, [low, high, part is None]]
    return [found, binds]
