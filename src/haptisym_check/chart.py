"""Rules 2, 3 and 4: the places of the band, and what follows from the signs around them."""

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from math import prod
from typing import Any

from haptisym_check.link import PARTS, Product
from haptisym_check.polynomials import PI, SCALE, Polynomial, agreed, bounds, moved, sign
from haptisym_check.scene import Scene, need


class Chart:
    """The places of the band in order, with the orders of all factors there, and their signs in between."""

    def __init__(
        self, scene: Scene, points: list[Fraction], factors: list[tuple[int, Polynomial]], told: list[Any]
    ) -> None:
        """``told``: the enclosures of the places."""
        low, high = (sorted(x.value * Fraction(pi, SCALE) ** x.pi for pi in PI) for x in scene.band)
        need(0 <= points[0] <= low[0] and low[1] <= points[1], "the first cell does not hold the low end of the band")
        need(points[-2] <= high[0] and high[1] <= points[-1], "the last cell does not hold the high end of the band")
        need(low[1] < high[0] and all(a < b for a, b in pairwise(points)), "the breakpoints do not ascend")
        self.from_0, self.orders, self.signs = low[1] == 0, [dict[int, int]()], list[list[int]]()
        size = sum(x.denominator.bit_length() + x.numerator.bit_length() for x in points)
        need(size * sum(len(p) ** 3 for _, p in factors) < 2 * 10**9, "the cells are too many, or too fine")
        rows, last, enclosures = [(step, bounds(p)) for step, p in factors], dict[int, int](), iter(told)
        need(told and holds(next(enclosures), *low), "the low end of the band is not in its enclosure")
        for a, b in pairwise(points):
            starts, stops = low == [a, a], high == [b, b]
            found = [agreed([moved(p, a**step, b**step) for p in ps]) for step, ps in rows]
            inner = [[x for x in signs if x] for signs in found]
            leads = {i: signs.index(inner[i][0]) for i, signs in enumerate(found) if not signs[0]}
            trails = {i: signs[::-1].index(inner[i][-1]) for i, signs in enumerate(found) if not signs[-1]}
            need((starts or not leads) and (stops or not trails), "a factor is zero at a breakpoint")
            self.orders[0], last = self.orders[0] | leads, last | trails
            self.signs = self.signs or [[x[0] for x in inner]]
            turns = [sum(x != y for x, y in pairwise(signs)) for signs in inner]
            beside = (a == points[0] and not starts) or (b == points[-1] and not stops)
            need(sum(turns) <= (0 if beside else 1), "a cell may hold two zeros, or one beside an end of the band")
            if any(turns):
                (step, ps), (x, y) = rows[turns.index(1)], next(enclosures, (a, a - 1))
                need(a <= x <= y <= b and sign(ps, x**step) * sign(ps, y**step) <= 0, "an enclosure holds no zero")
                self.orders.append({turns.index(1): 1})
                self.signs.append([x[-1] for x in inner])
        self.orders.append(last)
        need(holds(next(enclosures, (high[1] + 1, high[0])), *high), "the high end of the band is not in its enclosure")
        need(next(enclosures, None) is None, "there are more frequencies than places")


def holds(enclosure: Any, low: Fraction, high: Fraction) -> bool:
    return bool(enclosure[0] <= low and high <= enclosure[1])


class Curve:
    """The orders of a function at the places, and its signs before, at and after each."""

    def __init__(self, x: Product, chart: Chart) -> None:
        orders = [sum(n * found.get(i, 0) for i, n in x.powers.items()) for found in chart.orders]
        self.order = [orders[0] + (x.omega if chart.from_0 else 0), *orders[1:]]
        between = [
            ((x.number > 0) - (x.number < 0)) * prod(row[i] ** abs(n) for i, n in x.powers.items())
            for row in chart.signs
        ]
        self.before = [between[0] * (-1) ** self.order[0], *between]
        self.after = [*between, between[-1] * (-1) ** self.order[-1]]
        self.at = [0 if n > 0 or a != b else b for n, a, b in zip(self.order, self.before, self.after, strict=True)]


def where(test: Callable[[int], bool], *curves: Curve) -> list[list[int]]:
    """As few closed intervals as possible, of places and of what is between: where all curves pass."""
    at, after = (
        [all(map(test, x)) for x in zip(*rows, strict=True)]
        for rows in ([c.at for c in curves], [c.after for c in curves])
    )
    found: list[list[int]] = []
    for i, here in enumerate(at):
        if here and not (i and after[i - 1]):
            found.append([i, i])
        if i + 1 < len(at) and after[i]:
            found = [*found[:-1], [found[-1][0], i + 1]] if here else [*found, [i, i + 1]]
    return found


def claimed(curves: dict[str, Curve], *, from_0: bool) -> dict[str, Any]:
    """All that is said of a band, from the chart alone."""
    excess, active = {part: curves[f"excess.{part}"] for part in PARTS}, curves["perceived.imag"]
    places, crossings = range(len(active.order)), []
    for i in places:
        for part, c in excess.items():
            if c.order[i] > 0:
                touches = c.before[i] == c.after[i] and not (i == 0 and from_0 and c.after[i] > 0)
                kind = "touches" if touches else "exceeds" if c.after[i] > 0 else "returns"
                side = curves[f"difference.{part}"].after[i]
                crossings.append({"at": i, "part": part, "kind": kind, "sign": side, "multiplicity": c.order[i]})
    turning = {name: curves[f"{name}.real"] for name in ("environment", "perceived")}
    return {
        "crossings": crossings,
        "transparent": where(lambda x: x <= 0, *excess.values()),
        "changeovers": {name: [i for i in places if c.before[i] * c.after[i] < 0] for name, c in turning.items()},
        "percepts": [x for part in PARTS for x in percepts(part, *(curves[f"{x}.{part}"] for x in CURVES))],
        "outside_model": where(lambda x: x < 0, active),
        "unbounded": [i for i in places if any(c.order[i] < 0 for c in excess.values())],
    }


CURVES = "environment", "perceived", "excess", "difference", "sum"
PROPERTIES = {(1, 1): "stiffness", (-1, -1): "mass", (1, -1): "stiffness-to-mass", (-1, 1): "mass-to-stiffness"}


def percepts(part: str, env: Curve, perc: Curve, excess: Curve, change: Curve, both: Curve) -> list[dict[str, Any]]:
    """What is felt where a ratio exceeds its threshold."""
    found: list[dict[str, Any]] = []
    for i, (x, y) in enumerate(zip(env.after[:-1], perc.after[:-1], strict=True)):
        if excess.after[i] > 0 and (part == "real" or y >= 0):
            kind = PROPERTIES[x or y, y or x] if part == "real" else "damping"
            felt = {"property": kind, "change": ("equal", "higher", "lower")[change.after[i] * both.after[i]]}
            if found and found[-1] == {**found[-1], "to": i, **felt} and excess.at[i] > 0:
                found[-1]["to"] = i + 1
            else:
                found.append({"part": part, "from": i, "to": i + 1, **felt})
    return found
