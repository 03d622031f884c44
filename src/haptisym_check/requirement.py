"""Rule 6: for which values of a free parameter a display is transparent on its band, and for which
it is not.

The free parameter p takes the place of pi in all coefficients. Between two values, a *slab*, with
p = (low + high v)/(1 + v) and v > 0, a factor is a sum of slices, functions of omega alone, with
positive weights. So a sign on which all slices agree in a cell is that of the factor for all values
of the slab and all frequencies of the cell. Begin with ``verify`` (one slab), then ``values`` (all
of them).
"""

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
    """A factor with the same terms as another one, and other coefficients, without the free
    parameter: a slice of it."""

    def __init__(self, x: WaveFactor, coefficients: Iterable[int]) -> None:
        self.delays, self.orders, self.waves = x.delays, x.orders, x.waves
        # In the order of ``rows_of``, which the slices were cut from.
        numbers = iter(coefficients)
        self.terms = [(turns, [[next(numbers)] for _ in p]) for turns, p in x.terms]
        self.all = self.numbers(self.terms)


def rows_of(x: OmegaFactor) -> list[list[int]]:
    """All coefficients of a factor, each by powers of the free parameter."""
    return [row for _, p in x.terms for row in p]


def cost(x: OmegaFactor) -> tuple[int, int]:
    """The cost of the signs of a factor's slices, as the limits have it: for each bit of a point,
    and with waves for each point."""
    n, width = len(rows_of(x)), max(map(len, rows_of(x)))
    # With waves the numbers have one length, that of BITS: the bits of a point hardly matter.
    if isinstance(x, WaveFactor):
        return 2 * n * width**2, x.cost * width
    return 2 * (n * width) ** 2 + 2000, 0


class Slices:
    """The slices of a factor between two values; the first belongs to the low one, the last to the
    high one."""

    def __init__(self, x: OmegaFactor, low: Point, high: Point) -> None:
        rows = rows_of(x)
        width, bits = max(map(len, rows)), sum(n.bit_length() for n in low + high)
        # Moving raises the ends to powers up to the width.
        need(bits * width < 10**5, "the ends of a slab are too long")
        self.step, self.rows = x.step, sliced(rows, low, high)
        self.waves: list[WavedFactor | None] = []
        if isinstance(x, WaveFactor):
            self.waves = [WavedFactor(x, row) if any(row) else None for row in self.rows]

    @lru_cache(maxsize=500)  # noqa: B019 - several functions have the same factors
    def signs(self, a: Fraction, b: Fraction) -> list[set[int]]:
        """The signs that each slice may have from a to b; none where it is zero everywhere."""
        if self.waves:
            signs: list[set[int]] = []
            for x in self.waves:
                row = [] if x is None else x.signs(a, b)[1] if a < b else [x.sign(a)]
                signs.append(set(row))
            return signs
        # Coefficients that are zero are left out: the polynomial may vanish at a or b, nowhere in
        # between.
        low, high = ((x**self.step).as_integer_ratio() for x in (a, b))
        return [{(x > 0) - (x < 0) for x in moved(row, low, high)} - {0} for row in self.rows]

    def side(self, a: Fraction, b: Fraction, closed: tuple[bool, bool]) -> int:
        """The factor's sign from a to b, for all values strictly between the two; ``closed``: for
        which of the two it must have it as well."""
        every = self.signs(a, b)
        signs = set[int]().union(*every)
        need(len(signs) == 1, "a sign is not proven")
        # At an end of the slab all weights but one vanish: the factor is the first or last slice.
        need((every[0] or not closed[0]) and (every[-1] or not closed[1]), "a factor may be zero")
        return signs.pop()


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
    """Refuse a slab unless no excess is positive anywhere on the band, where ``part`` is None, or
    the excess of that part is positive at the point."""
    (first, low), (high, last) = ends_of_band(scene)
    at = numbers(points, 500, 1)

    def sign(x: FactoredNumber, a: Fraction, b: Fraction) -> int:
        """The sign of a product from a to b, for all values of the slab."""
        result = (x.number > 0) - (x.number < 0)
        for i, n in x.powers.items():
            # At an end of the slab a numerator may vanish: an excess of 0 is still not positive.
            # A denominator may not, and at a point, where an excess must be positive, no factor.
            firmly = closed if a == b or n < 0 else (False, False)
            result *= slices[i].side(a, b, firmly) ** abs(n)
        return result

    if part is None:
        need(0 <= at[0] <= first and last <= at[-1], "the cells do not hold the band")
        # The ends of cells are not examined. An excess is a bounded quotient of analytic functions
        # next to them, so it has no pole there, and by continuity is not positive.
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
    # Neighbours with a common end and the same result are joined, so the end belongs to both. Where
    # the result changes, the end is a zero of an excess and belongs to none.
    joins = [a[1] == b[0] and (a[3] is None) == (b[3] is None) for a, b in pairwise(rows)]
    intervals, binds = list[list[Any]](), list[str]()
    for i, ((low, high, points, part), *closed) in enumerate(
        zip(rows, [False, *joins], [*joins, False], strict=True)
    ):
        ends = point(low, -1), point(high, 1)
        first = not intervals
        after = first or (low is not None and not is_less(ends[0], point(intervals[-1][1], 1)))
        need(is_less(*ends) and after, "the slabs do not ascend")
        need(
            closed[0] or first or intervals[-1][2] != (part is None),
            "between two slabs there is more than an end",
        )
        slices = [Slices(x, *ends) for x in factors]
        verify(told, slices, (closed[0], closed[1]), points, part, scene)
        # One of two neighbours with different results names a part: that part's ratio exceeds its
        # threshold on one side of the end between them.
        binds += [] if closed[0] or first else [part or rows[i - 1][3]]
        if closed[0]:
            intervals[-1] = [intervals[-1][0], high, part is None]
        else:
            intervals.append([low, high, part is None])
    return [intervals, binds]


def requirement(claim: dict[str, Any], proof: Any, scene: SceneFile) -> dict[str, Any]:
    """For which values of a free parameter the display is transparent on the band."""
    # Delays and orders may be absent in a requirement's proof; what is no object ``keyed`` refuses.
    whole = isinstance(proof, dict) and {"delays": [], "orders": [], **proof}
    *rest, every, products, slabs = keyed(
        whole, "delays", "orders", "factors", "functions", "slabs"
    )
    parts = [part for part in PARTS if part in listed(claim.get("parts"), 2, 1)]
    need(parts, "the claim is of no part")
    delays, orders = others(*rest)
    factors = [factor_of(x, delays, orders) for x in listed(every, 500)]
    names = [f"excess.{part}" for part in parts]
    at_point = partial(functions, scene, delays, orders)
    told = link(products, names, factors, at_point, scene.length, (len(delays), len(orders)))
    intervals, binds = values(told, factors, slabs, scene)
    free = listed(claim.get("free"), 9, 1)
    return {"free": free, "parts": parts, "values": intervals, "binds": binds}
