"""Rule 1: the functions of a proof are those of the scene."""

from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import reduce
from itertools import product
from math import prod
from typing import Any

from haptisym_check.factors import Factor
from haptisym_check.reading import keyed, listed, number, whole
from haptisym_check.scene import ONE, Point, Ratio, Scene, Value, degree, need

PARTS = "real", "imag"


class Product:
    """number * x^omega * product of factor^exponent."""

    def __init__(self, x: Any, factors: list[Factor]) -> None:
        value, omega, powers = keyed(x, "number", "omega", "powers")
        rows = [listed(row, 2, 2) for row in listed(powers, 500)]
        self.number, self.omega = number(value), whole(omega, -500, 500)
        self.powers = {whole(i, 0, len(factors) - 1): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")
        waves = [sum(n * k for n, k in zip(self.powers.values(), column, strict=True))
                 for column in zip(*(factors[i].waves for i in self.powers), strict=True)]  # fmt: skip
        need(not any(n % 2 for n in waves), "a product changes its sign in a turn")
        self.circles = [-n // 2 for n in waves]  # cos^2 = 1/(1 + t^2)

    def at(self, x: Value, factors: list[Value], circles: list[Value]) -> Ratio:
        """Numerator and denominator, with values of x, of the factors and of 1 + t^2 for each tangent t."""
        powers = [
            (x, self.omega),
            *((factors[i], n) for i, n in self.powers.items()),
            *zip(circles, self.circles, strict=False),
        ]
        above, below = (
            reduce(Value.times, (v.power(sign * n) for v, n in powers if sign * n > 0), Value(first))
            for sign, first in ((1, self.number.numerator), (-1, self.number.denominator))
        )
        return above, below


def functions(scene: Scene, point: Point) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    (n, d), (p, q) = scene.at(point)
    pd, qn, dq = p.times(d), q.times(n), d.times(q)
    pairs = {"environment": (n, d), "perceived": (p, q), "difference": (pd.plus(qn, -1), dq), "sum": (pd.plus(qn), dq)}
    found: dict[str, Ratio] = {}
    for name, (u, v) in pairs.items():
        turned = u.times(v.conjugate())  # u/v = u conj(v)/|v|^2
        for part, size in zip(PARTS, turned[:2], strict=True):
            found[f"{name}.{part}"] = turned._replace(re=size, im=0), v.times(v.conjugate())
    root = n.times(d).times(q).times(q)
    below = root.times(root.conjugate())
    for part in PARTS:  # (Re (G - H))^2/|H|^2 = (Re ((P D - Q N) conj(D Q)))^2/(|N|^2 |D|^2 |Q|^4)
        x, (top, bottom) = found[f"difference.{part}"][0], scene.threshold[part].at(point.pi)
        square = bottom.times(bottom)
        found[f"excess.{part}"] = x.times(x).times(square).plus(below.times(top).times(top), -1), below.times(square)
    return found


Scenery = Callable[[Point], dict[str, Ratio]]


def link(
    told: dict[str, Product], factors: list[Factor], scene: Scenery, own: tuple[Fraction, ...] = (), turn: Value = ONE
) -> None:
    """RefusedError unless the products are the functions of a scene with these delays, s being ``turn`` times x: on a grid."""

    def gaps(names: Iterable[str], x: int, pi: int, *tangents: int) -> dict[str, tuple[Value, bool]]:
        """left * bottom - right * top of functions, and whether right and bottom are none of them zero."""
        at = Value(x, 0, degree(0))
        circles = [Value(1 + t * t, 0, degree(2 + i, 2)) for i, t in enumerate(tangents)]
        values = [factor.at(x, pi, tangents) for factor in factors]
        found, functions = {}, scene(Point((at.times(turn), ONE), pi, own, tangents))
        for name in names:
            (top, bottom), (left, right) = functions[name], told[name].at(at, values, circles)
            found[name] = left.times(bottom).plus(right.times(top), -1), right.re != 0 and bottom[:2] != (0, 0)
        return found

    start = [0, 1, *[0] * len(own)]
    most = {name: [max(n, 0) for n in gap.degrees[: len(start)]] for name, (gap, _) in gaps(told, *start).items()}
    size = [max(column) + 1 for column in zip(*most.values(), strict=True)]
    entries = sum(len(row) for factor in factors for _, p in factor.terms for row in p)
    need(size[0] <= 3000 and prod(size) * (entries + 500) <= 4 * 10**7, "the degrees are too high")
    defined = set[str]()
    for steps in product(*map(range, size)):
        names = [name for name, high in most.items() if all(map(int.__le__, steps, high))]
        for name, (gap, there) in gaps(names, *map(sum, zip(start, steps, strict=True))).items() if names else ():
            need(gap[:2] == (0, 0), f"{name} is not that of the scene")
            defined |= {name} if there else set()
    need(defined == set(told), "a function is nowhere defined")
