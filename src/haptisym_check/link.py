"""Rule 1: the functions of a proof are those of the scene."""

from collections.abc import Callable
from fractions import Fraction
from itertools import chain, product
from math import prod
from typing import Any

from haptisym_check.polynomials import Factor
from haptisym_check.reading import keyed, listed, number, whole
from haptisym_check.scene import Scene
from haptisym_check.values import ONE, Point, Ratio, Value, combined, degree, need

PARTS = "real", "imag"
Sides = tuple[Value, Value, Value, Value]
Numbers = tuple[Fraction, ...]


class Product:
    """number * product of factor^exponent."""

    def __init__(self, x: Any, factors: list[Factor]) -> None:
        value, powers = keyed(x, "number", "powers")
        rows = [listed(row, 2, 2) for row in listed(powers, 500)]
        self.number, self.powers = number(value), {whole(i, 0, len(factors) - 1): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")
        need(self.number or not rows, "a function that is zero everywhere has no factors")
        self.size = sum(abs(n) * factors[i].size for i, n in self.powers.items())
        waves = list(map(sum, zip(*([n * k for k in factors[i].waves] for i, n in self.powers.items()), strict=True)))
        need(not any(n % 2 for n in waves), "a product changes its sign in a turn")
        self.circles = [-n // 2 for n in waves]  # cos^2 = 1/(1 + t^2)

    def at(self, factors: list[Value], circles: list[Value]) -> Ratio:
        """Numerator and denominator, with values of the factors and of 1 + t^2 for each tangent t."""
        found = [Value(self.number.numerator), Value(self.number.denominator)]
        for x, n in [*((factors[i], n) for i, n in self.powers.items()), *zip(circles, self.circles, strict=False)]:
            found[n < 0] = found[n < 0].times(x.power(abs(n)))
        return found[0], found[1]


def functions(scene: Scene, delays: Numbers, orders: Numbers, x: Value, pi: int, *others: Any) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    h, g = scene.at(Point((x.times(Value(0, 1)), ONE), pi, delays, orders, others))
    pairs = {"environment": h, "perceived": g, "difference": combined("-", g, h), "sum": combined("+", g, h)}
    found: dict[str, Ratio] = {}
    for name, (u, v) in pairs.items():
        turned = u.times(v.conjugate())  # u/v = u conj(v)/|v|^2
        for part, size in zip(PARTS, turned[:2], strict=True):
            found[f"{name}.{part}"] = turned._replace(re=size, im=0), v.times(v.conjugate())
    root = h[0].times(h[1]).times(g[1]).times(g[1])  # H = N/D, G = P/Q
    for part in PARTS:  # (Re (G - H))^2/|H|^2 = (Re ((P D - Q N) conj(D Q)))^2/(|N|^2 |D|^2 |Q|^4)
        y, limit = found[f"difference.{part}"][0], scene.threshold[part].at(pi)
        ratio = y.times(y), root.times(root.conjugate())
        found[f"excess.{part}"] = combined("-", ratio, combined("*", limit, limit))
    return found


Values = Callable[..., dict[str, Ratio]]
Counts = tuple[int, int]


class Grid:
    """Functions of a scene, and as told, at whole numbers in place of omega (or s), pi, tangents and powers."""

    def __init__(
        self, told: dict[str, Product], factors: list[Factor], scene: Values, delays: int, orders: int
    ) -> None:
        self.told, self.factors, self.scene, self.delays, self.orders = told, factors, scene, delays, orders
        self.start = self.sides(0, 1, *[0] * delays, *[(0, 0)] * orders)

    def sides(self, x: int, pi: int, *others: Any) -> dict[str, Sides]:
        """Numerator and denominator of each function in the scene, and as told."""
        circles = [Value(1 + t * t, 0, degree(2 + i, 2)) for i, t in enumerate(others[: self.delays])]
        values = [own.at(x, pi, [*others[: self.delays], *chain(*others[self.delays :])]) for own in self.factors]
        functions = self.scene(Value(x, 0, degree(0)), pi, *others)
        return {name: (*functions[name], *told.at(values, circles)) for name, told in self.told.items()}

    def elsewhere(self, k: int) -> dict[str, Sides]:
        """The same at a place that differs from others in all numbers."""
        powers = ((k + 3 + i, k + 4) for i in range(self.orders))
        return self.sides(k, k + 1, *range(k + 2, k + 2 + self.delays), *powers)

    def zero(self, names: set[str], rests: Callable[[str, Sides], list[Value]], cost: int) -> set[str]:
        """Those of which polynomials vanish on a grid that shows that they are zero; on it left bottom must be right top."""
        rows = (x.degrees for name in names for x in rests(name, self.start[name]))
        n, m, *size = [max(0, *column) + 1 for column in zip(*rows, strict=True)][: 2 + self.delays + self.orders]
        tangents, powers = size[: self.delays], size[self.delays :]
        corners = [k * (k + 1) // 2 for k in powers]  # of Re and Im together, as their degrees are
        need(n <= 3000 and n * m * prod(tangents + corners) * cost <= 3 * 10**7, "the degrees are too high")
        triangles = ([(i, k) for i in range(most) for k in range(most - i)] for most in powers)
        for at in product(*map(list[Any], (range(n), range(1, m + 1), *map(range, tangents), *triangles))):
            found = self.sides(*at) if names else {}
            wrong = [name for name in names if across(name, found[name])[0][:2] != (0, 0)]
            need(not wrong, f"{', '.join(sorted(wrong))}: not that of the scene")
            names = {name for name in names if all(x[:2] == (0, 0) for x in rests(name, found[name]))}
        return names


def across(_: str, x: Sides) -> list[Value]:
    """left bottom - right top: zero where both fractions are one function."""
    return [x[2].times(x[1]).plus(x[3].times(x[0]), -1)]


def link(
    x: Any, names: list[str], factors: list[Factor], scene: Values, length: int, waves: Counts = (0, 0), share: int = 1
) -> dict[str, Product]:
    """Products, proven to be functions of a scene, which it gives for omega (or s), pi, tangents and powers: on a grid.

    ``length``: of the scene's formulas. ``waves``: how many delays and how many orders there are. ``share``: one of how many such
    questions it is, which together may take so long as one.
    """
    told = {name: Product(y, factors) for name, y in zip(names, keyed(x, *names), strict=True)}
    cost = share * (sum(x.size for x in factors) + sum(x.size for x in told.values()) + 5 * length + 100)
    grid, fixed = Grid(told, factors, scene, *waves), dict[str, tuple[Value, Value]]()
    for k in range(17, 25):
        other = grid.elsewhere(k) if len(fixed) < len(told) else {}
        fixed |= {name: (x[3], x[1]) for name, x in other.items() if x[3].re and x[1][:2] != (0, 0)}
    need(len(fixed) == len(told), "a function is nowhere defined")

    def multiples(name: str, x: Sides) -> list[Value]:
        """What vanishes where the scene's numerator and denominator are those told, times one number."""
        u, v = (y._replace(degrees=degree(0, 0)) for y in fixed[name])
        return [x[i].times(u).plus(x[i + 2].times(v), -1) for i in range(2)]

    left = set(names) - grid.zero(set(names), multiples, cost)
    need(not left or grid.zero(left, across, cost) == left, "a function is not that of the scene")
    return told
