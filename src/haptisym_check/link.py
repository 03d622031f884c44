"""Rule 1: the functions of a proof are those of the scene."""

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from math import prod
from operator import add
from typing import Any

from haptisym_check.polynomials import Factor
from haptisym_check.reading import keyed, listed, number, whole
from haptisym_check.scene import ONE, Point, Ratio, Scene, Value, combined, degree, need

PARTS = "real", "imag"


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


def functions(scene: Scene, delays: tuple[Fraction, ...], x: Value, pi: int, *tangents: int) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    h, g = scene.at(Point((x.times(Value(0, 1)), ONE), pi, delays, tangents))
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


def link(
    x: Any, names: list[str], factors: list[Factor], scene: Callable[..., dict[str, Ratio]], delays: int = 0
) -> dict[str, Product]:
    """Products, proven to be functions of a scene, which it gives for omega (or s), pi and tangents: on a grid."""
    told = {name: Product(y, factors) for name, y in zip(names, keyed(x, *names), strict=True)}

    def gaps(x: int, pi: int, *tangents: int) -> dict[str, tuple[Value, bool]]:
        """left * bottom - right * top of functions, and whether right and bottom are none of them zero."""
        circles = [Value(1 + t * t, 0, degree(2 + i, 2)) for i, t in enumerate(tangents)]
        values = [factor.at(x, pi, tangents) for factor in factors]
        found, functions = {}, scene(Value(x, 0, degree(0)), pi, *tangents)
        for name in names:
            (top, bottom), (left, right) = functions[name], told[name].at(values, circles)
            found[name] = left.times(bottom).plus(right.times(top), -1), right.re != 0 and bottom[:2] != (0, 0)
        return found

    start, defined = [0, 1, *[0] * delays], set[str]()
    degrees = zip(*(gap.degrees for gap, _ in gaps(*start).values()), strict=True)
    size = [max(0, *column) + 1 for column in degrees][: len(start)]
    work = sum(x.size for x in factors) + sum(x.size for x in told.values()) + 500
    need(size[0] <= 3000 and prod(size) * work <= 10**8, "the degrees are too high")
    for steps in product(*map(range, size)):
        for name, (gap, there) in gaps(*map(add, start, steps)).items():
            need(gap[:2] == (0, 0), f"{name} is not that of the scene")
            defined |= {name} if there else set()
    need(len(defined) == len(told), "a function is nowhere defined")
    return told
