"""Rules 2 to 5: the places of the band, the signs around them, and how many zeros are in Re s >= 0.

Every function of a proof is a number times powers of factors. So its zeros, poles and signs on the
whole band follow from those of the factors: the breakpoints cut the band into cells with at most
one zero of one factor each, and a *place* is an end of the band or such a zero. Orders at the
places and signs in between decide everything that ``claimed`` derives, and nothing else enters it.
Begin with ``PlaceTable``, then ``SignRow``. The zeros in Re s >= 0 are counted at the end by the
turns of p(j omega) about 0.
"""

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
    GaussianValue,
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
    """Rational bounds of the band's low end, and of its high end; both equal where there is no
    pi."""
    bounds_of_pi = [Fraction(*x) for x in PI]
    ends = []
    for x in scene.band:
        bounds = [x.value * pi**x.pi for pi in bounds_of_pi]
        ends.append(sorted(bounds))
    low, high = ends
    need(low[1] < high[0], "the band is empty")
    return [low, high]


class PlaceTable:
    """The places of the band in order, with the orders of all factors there (``orders``), and their
    signs in between (``signs``: one row fewer)."""

    def __init__(
        self,
        scene: SceneFile,
        points: list[Fraction],
        factors: list[OmegaFactor],
        told: list[list[Fraction]],
    ) -> None:
        """``told``: the enclosures of the places, as the claim has them."""
        low, high = ends_of_band(scene)
        starts = 0 <= points[0] <= low[0] and low[1] <= points[1]
        need(starts, "the first cell does not hold the low end of the band")
        ends = points[-2] <= high[0] and high[1] <= points[-1]
        need(ends, "the last cell does not hold the high end of the band")
        need(holds(told[0], low), "the low end of the band is not in its enclosure")
        need(holds(told[-1], high), "the high end of the band is not in its enclosure")
        # All factors are examined in each cell, but only one of them at each enclosure: its value
        # at a point costs far less than its coefficients.
        costs = [x.cost for x in factors]
        affordable(points, sum(costs))
        affordable(chain(*told), max(costs, default=0) // 10)
        self.from_0 = low[1] == 0
        self.orders: list[list[Any]] = []
        self.signs: list[list[int]] = []
        self.powers = [x.powers for x in factors]
        for a, b in pairwise(points):
            leads, rows = [], []  # orders at a, and signs from there on to b
            for factor in factors:
                lead, row = factor.signs(a, b)
                leads.append(lead)
                rows.append(row)
            inner = [[x for x in row if x] for row in rows]
            counts = [turns(row) for row in rows]
            last = [order(row[::-1]) for row in rows]
            # A zero at a breakpoint between cells would belong to none of them. An end of the band
            # is a place of its own, so there a zero is allowed.
            fits_at_a = low == [a, a] or not any(leads)
            fits_at_b = high == [b, b] or not any(last)
            need(fits_at_a and fits_at_b, "a factor is zero at a breakpoint")
            # In a cell that holds an end of the band inside, a zero could be on either side of it.
            in_band = low[1] <= a and b <= high[0]
            most = 1 if in_band else 0
            need(sum(counts) <= most, "a cell may hold two zeros, or one beside an end of the band")
            if not self.orders:
                self.orders.append(leads)
                self.signs.append([x[0] for x in inner])
            if any(counts):
                zero = factors[counts.index(1)]
                # A claim with too few enclosures is refused below, once all places are counted.
                x, y = told[min(len(self.orders), len(told) - 1)]
                inside = a < x <= y < b and zero.sign(x) * zero.sign(y) <= 0
                need(inside, "an enclosure holds no zero")
                # One sign change is a simple zero, so the other factors have the order 0.
                self.orders.append(counts)
                self.signs.append([x[-1] for x in inner])
        self.orders.append(last)
        need(len(told) == len(self.orders), "there are not as many frequencies as places")


def holds(enclosure: list[Fraction], x: list[Fraction]) -> bool:
    """Whether a place, known between two numbers, lies in an enclosure."""
    low, high = enclosure
    return low <= x[0] and x[1] <= high


def away(order: Fraction | int) -> int:
    """A whole number, rounded away from 0."""
    return ceil(order) if order > 0 else floor(order)


class SignRow:
    """The orders of a function at the places, and its signs before, at and after each.

    An order is positive at a zero, negative at a pole. ``between`` has the signs of the open pieces
    between neighbouring places; ``line`` alternates those at places and those of pieces.
    """

    def __init__(self, x: FactoredNumber, chart: PlaceTable) -> None:
        powers = x.powers.items()
        # At omega = 0 an order may be a fraction; rounded away from 0 it still tells a zero from a
        # pole, and both from neither.
        self.order = []
        for orders in chart.orders:
            total = sum(n * orders[i] for i, n in powers)
            self.order.append(away(total))
        sign = (x.number > 0) - (x.number < 0)
        self.between = []
        for row in chart.signs:
            of_factors = prod(row[i] ** abs(n) for i, n in powers)
            self.between.append(sign * of_factors)
        # A function with a power of omega that is not whole has no values below 0.
        one_sided = chart.from_0 and any(chart.powers[i] for i in x.powers)
        # Beyond an end of the band nothing was examined, but the order at that end tells whether
        # the sign changes there.
        first = self.between[0]
        if not one_sided:
            first *= (-1) ** abs(self.order[0])
        last = self.between[-1] * (-1) ** abs(self.order[-1])
        self.before = [first, *self.between]
        self.after = [*self.between, last]
        # Different signs without a zero: a pole of odd order, which has no sign itself.
        self.at = []
        for n, a, b in zip(self.order, self.before, self.after, strict=True):
            unsigned = n > 0 or a != b
            self.at.append(0 if unsigned else b)
        line = chain(*zip(self.at, self.after, strict=True))
        self.line = list(line)[:-1]  # no piece follows the last place


def runs(line: Iterable[Any]) -> list[tuple[int, int, Any]]:
    """The longest pieces of one value that is not empty, of a line that alternates places and what
    is between them, as pairs of places."""
    pieces = []
    start = 0
    for x, row in groupby(line):
        stop = start + len(list(row))
        # Entry 2 k of a line is place k, entry 2 k + 1 the piece from place k to k + 1.
        if x:
            pieces.append((start // 2, stop // 2, x))
        start = stop
    return pieces


def where(test: Callable[[int], bool], *curves: SignRow) -> list[list[int]]:
    """As few closed intervals as possible, of places and of what is between: where all curves
    pass."""
    lines = [curve.line for curve in curves]
    passed = [all(map(test, signs)) for signs in zip(*lines, strict=True)]
    return [[a, b] for a, b, _ in runs(passed)]


def claimed(curves: dict[str, SignRow], *, from_0: bool) -> dict[str, Any]:
    """All that an evaluation claims of a band, from the signs and orders of its functions alone
    (rule 4)."""
    excess = {part: curves[f"excess.{part}"] for part in PARTS}
    active = curves["perceived.imag"]
    places = range(len(active.order))
    crossings = []
    unbounded = []
    for i in places:
        if any(c.order[i] < 0 for c in excess.values()):
            unbounded.append(i)
        for part, c in excess.items():
            if c.order[i] <= 0:
                continue
            positive_after = c.after[i] > 0
            # An excess has no other side at omega = 0: positive just above, it exceeds there.
            begins = i == 0 and from_0 and positive_after
            kind = "exceeds" if positive_after else "returns"
            if c.before[i] == c.after[i] and not begins:
                kind = "touches"
            crossing = {
                "at": i,
                "part": part,
                "kind": kind,
                "sign": curves[f"difference.{part}"].after[i],
                "multiplicity": c.order[i],
            }
            crossings.append(crossing)
    changeovers = {}
    for name in ("environment", "perceived"):
        c = curves[f"{name}.real"]
        changeovers[name] = [i for i in places if c.before[i] * c.after[i] < 0]
    felt = []
    for part in PARTS:
        of_part = [curves[f"{name}.{part}"] for name in CURVES]
        felt += percepts(part, *of_part)
    return {
        "crossings": crossings,
        "transparent": where(lambda x: x <= 0, *excess.values()),
        "changeovers": changeovers,
        "percepts": felt,
        "outside_model": where(lambda x: x < 0, active),
        "unbounded": unbounded,
    }


CURVES = "environment", "perceived", "excess", "difference", "sum"
PROPERTIES = {
    (1, 1): "stiffness",
    (-1, -1): "mass",
    (1, -1): "stiffness-to-mass",
    (-1, 1): "mass-to-stiffness",
}


CHANGES = {0: "equal", 1: "higher", -1: "lower"}


def percepts(
    part: str, env: SignRow, perc: SignRow, excess: SignRow, change: SignRow, both: SignRow
) -> list[dict[str, Any]]:
    """What is felt where a ratio exceeds its threshold: intervals of one property and one
    change."""
    line: list[Any] = []
    for i, e in enumerate(excess.between):
        x = env.between[i]
        y = perc.between[i]
        felt = None
        # A negative Im H_perc generates energy: no damping is felt there.
        if e > 0 and (part == "real" or y >= 0):
            # A real part that is zero everywhere has no sign and takes that of the other.
            kind = PROPERTIES[x or y, y or x] if part == "real" else "damping"
            # The sign of (G - H)(G + H) = G^2 - H^2: larger or smaller in size, whatever the signs.
            grows = change.between[i] * both.between[i]
            felt = kind, CHANGES[grows]
        # The entry of a place joins the pieces on both sides where the excess is positive there.
        same = bool(line) and felt == line[-1]
        joined = felt if same and excess.at[i] > 0 else None
        line += joined, felt
    rows = []
    for a, b, (kind, grown) in runs(line):
        rows.append({"part": part, "from": a, "to": b, "property": kind, "change": grown})
    return rows


# Rule 5: how many zeros a function of s has in Re s >= 0.

# Large enough that a resultant that is not zero is hardly ever zero modulo it; small enough for
# quick arithmetic. A claim is never proven by accident: modulo a prime Euclid's algorithm can only
# miss that two polynomials are coprime.
PRIME = 2**61 - 1


def modular(p: Polynomial) -> list[int]:
    """The coefficients of p modulo the prime, with 3 in place of pi."""
    values = [sum(c * 3**i for i, c in enumerate(row)) for row in p]
    return [value % PRIME for value in values]


def coprime(p: Polynomial, q: Polynomial) -> bool:
    """Whether p and q have no zero in common, not even with 3 in place of pi and modulo a prime;
    False if that is not proven."""
    # A resultant with whole coefficients that is not zero modulo a prime, for a whole number in
    # place of pi, is not the polynomial 0; so it is not zero at pi, which is transcendental.
    # A leading coefficient that vanishes would change the resultant: nothing is proven then.
    a, b = modular(p), modular(q)
    while a[-1] and b and b[-1]:  # Euclid: what is left of a when b is taken from it
        while len(a) >= len(b):
            by = a[-1] * pow(b[-1], -1, PRIME)
            zeros_below = [0] * (len(a) - len(b))
            pairs = zip(a, zeros_below + b, strict=True)
            a = [(x - by * y) % PRIME for x, y in pairs]
            while a and not a[-1]:
                a.pop()
        a, b = b, a
    return not b and len(a) == 1


def to_the_right(p: Polynomial, points: list[Fraction]) -> int:
    """The zeros of p in Re s >= 0: that at 0, and what the turns of p(j omega) = E + j omega O
    between points of omega^2 tell."""
    at_0 = order([any(row) for row in p])
    p = p[at_0:]
    n = len(p) - 1
    halves = []
    for half in (p[::2], p[1::2]):
        # s^(2 k) is (-1)^k omega^(2 k) at s = j omega.
        in_square = [[c * (-1) ** k for c in row] for k, row in enumerate(half)]
        halves.append(sliced(in_square or [[0]]))
    even, odd = halves
    # Mikhailov: from omega = 0 to infinity p(j omega) turns by as many right angles as p has zeros
    # in Re s < 0 more than in Re s >= 0. Where E is zero the curve crosses the imaginary axis: each
    # time counts for two right angles, in the direction that the sign of E O before it shows.
    left = 0  # zeros in Re s < 0, less those in Re s >= 0
    last = 0  # the sign of E O at the end
    infinity = (1, 0)
    ends = [x.as_integer_ratio() for x in points]
    for low, high in pairwise([*ends, infinity]):
        e = signs(even, low, high)
        o = signs(odd, low, high)
        begins_and_ends = e[0] and (e[-1] or high == infinity)
        need(begins_and_ends, "E is zero between two cells")
        zeros_of_e = turns(e)
        need(zeros_of_e + turns(o) < 2 or not zeros_of_e, "a cell may hold two zeros")
        side = next((x for x in o if x), 0)
        # Without O the zeros of p are those of E, in pairs +-s: a zero of E at W > 0 is a pair on
        # the imaginary axis, which counts as two in Re s >= 0.
        direction = e[0] * side if side else -1
        left += 2 * zeros_of_e * direction
        # Counts where n is odd only: the highest power is then one of O, and the curve ends with
        # one more right angle.
        last_of_e = [x for x in e if x][-1]
        last = last_of_e * o[-1]
    if n % 2:
        left += last
    return at_0 + (n - left) // 2


def zeros(x: Any, function: Callable[[ChainPoint], Ratio], length: int, share: int = 1) -> int:
    """The number of zeros in Re s >= 0 of a function of s and pi, counted with multiplicity;
    ``length``, ``share``: as ``link`` has them."""
    told, product, cells = keyed(x, "factors", "function", "cells")
    factors = [OmegaFactor(polynomial(p)) for p in listed(told, 100)]

    def values(s: GaussianValue, pi: int) -> dict[str, Ratio]:
        return {"it": function(ChainPoint((s, ONE), pi))}

    products = link({"it": product}, ["it"], factors, values, length, share=share)
    proven = products["it"]
    need(proven.number, "a function is zero everywhere")
    rows = listed(cells, len(factors), len(factors))
    points = [numbers(["0", *listed(row, 300)], 301) for row in rows]
    denominator = [factors[k].rows for k, m in proven.powers.items() if m < 0]
    count = 0
    for i, n in proven.powers.items():
        factor = factors[i]
        affordable(points[i], factor.cost * len(factors) * share)
        unstable = to_the_right(factor.rows, points[i]) if n > 0 else 0
        # A zero in common with a denominator may cancel. Only those in Re s >= 0 are counted, so
        # factors without any need no such proof.
        distinct = not unstable or all(coprime(factor.rows, q) for q in denominator)
        need(distinct, "a zero may be none: the denominator may share it")
        count += n * unstable
    return count
