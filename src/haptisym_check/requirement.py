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
from itertools import chain, pairwise
from typing import Any

from haptisym_check.chart import ends_of_band
from haptisym_check.delayterms import WaveFactor, factor_of
from haptisym_check.polynomials import OmegaFactor, Point, affordable, moved, sliced
from haptisym_check.scene import PARTS, FactoredNumber, SceneFile, functions, link
from haptisym_check.values import delays_and_orders, keyed, listed, need, number, numbers

# A value is a ``Point``, numerator and denominator, as it may be infinite.


def point(x: Any, infinity: int) -> Point:
    """A value as numerator and denominator; infinity is 1/0 or -1/0."""
    if x is None:
        return infinity, 0
    return number(x).as_integer_ratio()


def is_less(x: Point, y: Point) -> bool:
    """Whether x < y."""
    a, b = x
    c, d = y
    return a * d < c * b


class WavedFactor(WaveFactor):
    """A factor with the same terms as another one, and other coefficients, without the free
    parameter: a slice of it."""

    def __init__(self, x: WaveFactor, coefficients: Iterable[int]) -> None:
        self.delays = x.delays
        self.orders = x.orders
        self.waves = x.waves
        # In the order of ``rows_of``, which the slices were cut from.
        numbers = iter(coefficients)
        self.terms = []
        for exponents, p in x.terms:
            row = [[next(numbers)] for _ in p]
            self.terms.append((exponents, row))
        self.all = self.numbers(self.terms)


def rows_of(x: OmegaFactor) -> list[list[int]]:
    """All coefficients of a factor, each by powers of the free parameter."""
    return [row for _, p in x.terms for row in p]


def cost(x: OmegaFactor) -> tuple[int, int]:
    """The cost of the signs of a factor's slices, as the limits have it: for each bit of a point,
    and with waves for each point."""
    rows = rows_of(x)
    n = len(rows)
    width = max(map(len, rows))
    # With waves the numbers have one length, that of BITS: the bits of a point hardly matter.
    if isinstance(x, WaveFactor):
        return 2 * n * width**2, x.cost * width
    return 2 * (n * width) ** 2 + 2000, 0


class Slices:
    """The slices of a factor between two values; the first belongs to the low one, the last to the
    high one."""

    def __init__(self, x: OmegaFactor, low: Point, high: Point) -> None:
        rows = rows_of(x)
        width = max(map(len, rows))
        bits = sum(n.bit_length() for n in low + high)
        # Moving raises the ends to powers up to the width.
        need(bits * width < 10**5, "the ends of a slab are too long")
        self.step = x.step
        self.rows = sliced(rows, low, high)
        self.waves: list[WavedFactor | None] = []
        if isinstance(x, WaveFactor):
            for row in self.rows:
                self.waves.append(WavedFactor(x, row) if any(row) else None)

    @lru_cache(maxsize=500)  # noqa: B019 - several functions have the same factors
    def signs(self, a: Fraction, b: Fraction) -> list[set[int]]:
        """The signs that each slice may have from a to b; none where it is zero everywhere."""
        if self.waves:
            signs: list[set[int]] = []
            for x in self.waves:
                if x is None:
                    signs.append(set())
                elif a < b:
                    _, row = x.signs(a, b)
                    signs.append(set(row))
                else:
                    signs.append({x.sign(a)})
            return signs
        low = (a**self.step).as_integer_ratio()
        high = (b**self.step).as_integer_ratio()
        every = []
        for slice_of_p in self.rows:
            coefficients = moved(slice_of_p, low, high)
            # Coefficients that are zero are left out: the polynomial may vanish at a or b, nowhere
            # in between.
            signs_or_0 = {(c > 0) - (c < 0) for c in coefficients}
            every.append(signs_or_0 - {0})
        return every

    def side(self, a: Fraction, b: Fraction, closed: tuple[bool, bool]) -> int:
        """The factor's sign from a to b, for all values strictly between the two; ``closed``: for
        which of the two it must have it as well."""
        every = self.signs(a, b)
        signs = set[int]().union(*every)
        need(len(signs) == 1, "a sign is not proven")
        # At an end of the slab all weights but one vanish: the factor is the first or last slice.
        at_low, at_high = closed
        zero_at_low = at_low and not every[0]
        zero_at_high = at_high and not every[-1]
        need(not zero_at_low and not zero_at_high, "a factor may be zero")
        return signs.pop()


# One slab, and then all of them.


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
            nonzero = a == b or n < 0
            side = slices[i].side(a, b, closed if nonzero else (False, False))
            result *= side ** abs(n)
        return result

    if part is None:
        begins = 0 <= at[0] <= first
        need(begins and last <= at[-1], "the cells do not hold the band")
        # The ends of cells are not examined. An excess is a bounded quotient of analytic functions
        # next to them, so it has no pole there, and by continuity is not positive.
        for a, b in pairwise(at):
            for x in told.values():
                need(sign(x, a, b) <= 0, "an excess may be positive")
    else:
        name = f"excess.{part}"
        one_point = at[0] == at[-1]
        on_band = one_point and low <= at[0] <= high
        need(name in told and on_band, "a point is not on the band")
        need(sign(told[name], at[0], at[0]) > 0, "an excess may not be positive")


def joined(a: list[Any], b: list[Any]) -> bool:
    """Whether two neighbouring slabs have a common end and the same result: the end then belongs to
    both. Where the result changes, the end is a zero of an excess and belongs to none."""
    _, high, _, part = a
    low, _, _, next_part = b
    same_result = (part is None) == (next_part is None)
    return bool(high == low) and same_result


def values(
    told: dict[str, FactoredNumber], factors: list[OmegaFactor], slabs: Any, scene: SceneFile
) -> list[list[Any]]:
    """Intervals of values, ascending, each with whether the display is transparent for them, and
    which parts bind between."""
    rows = [keyed(x, "from", "to", "points", "part") for x in listed(slabs, 500, 1)]
    # The ends of a slab enter the work at each of its points.
    triples: list[tuple[Any, ...]] = []
    for low, high, points, _ in rows:
        triples += [(low, high, x) for x in listed(points, 500, 1)]
    costs = [cost(x) for x in factors]
    finite = (x for x in chain(*triples) if x is not None)
    affordable(map(number, finite), sum(per_bit for per_bit, _ in costs))
    of_waves = sum(per_point for _, per_point in costs)
    need(len(triples) * of_waves < 10**8, "the cells are too many for factors with waves")
    joins = [joined(a, b) for a, b in pairwise(rows)]
    intervals: list[list[Any]] = []
    binds: list[str] = []
    for i, (low, high, points, part) in enumerate(rows):
        closed = i > 0 and joins[i - 1], i < len(joins) and joins[i]
        ends = point(low, -1), point(high, 1)
        transparent = part is None
        if intervals:
            _, last_end, last_transparent = intervals[-1]
            after = low is not None and not is_less(ends[0], point(last_end, 1))
            need(is_less(*ends) and after, "the slabs do not ascend")
            changes = last_transparent != transparent
            need(closed[0] or changes, "between two slabs there is more than an end")
        else:
            need(is_less(*ends), "the slabs do not ascend")
        slices = [Slices(x, *ends) for x in factors]
        verify(told, slices, closed, points, part, scene)
        if closed[0]:
            intervals[-1] = [intervals[-1][0], high, transparent]
            continue
        if intervals:
            # One of two neighbours with different results names a part: that part's ratio exceeds
            # its threshold on one side of the end between them.
            _, _, _, part_before = rows[i - 1]
            binds.append(part or part_before)
        intervals.append([low, high, transparent])
    return [intervals, binds]


def requirement(claim: dict[str, Any], proof: Any, scene: SceneFile) -> dict[str, Any]:
    """For which values of a free parameter the display is transparent on the band."""
    # Delays and orders may be absent in a requirement's proof; what is no object ``keyed`` refuses.
    whole = isinstance(proof, dict) and {"delays": [], "orders": [], **proof}
    keys = "delays", "orders", "factors", "functions", "slabs"
    *rest, every, products, slabs = keyed(whole, *keys)
    parts = [part for part in PARTS if part in listed(claim.get("parts"), 2, 1)]
    need(parts, "the claim is of no part")
    delays, orders = delays_and_orders(*rest)
    factors = [factor_of(x, delays, orders) for x in listed(every, 500)]
    names = [f"excess.{part}" for part in parts]
    at_point = partial(functions, scene, delays, orders)
    counts = len(delays), len(orders)
    told = link(products, names, factors, at_point, scene.length, counts)
    intervals, binds = values(told, factors, slabs, scene)
    free = listed(claim.get("free"), 9, 1)
    return {"free": free, "parts": parts, "values": intervals, "binds": binds}
