"""Rule 1: the functions of the proof are those of the scene."""

from collections.abc import Callable
from math import prod
from typing import Any

from haptisym_check.polynomials import Polynomial, keyed, listed, number, whole
from haptisym_check.scene import Ratio, Scene, Value, need

PARTS = "real", "imag"


class Product:
    """number * x^omega * product of factor^exponent."""

    def __init__(self, x: Any, factors: int) -> None:
        value, omega, powers = keyed(x, "number", "omega", "powers")
        rows = [listed(row, 2, 2) for row in listed(powers, 500)]
        self.number, self.omega = number(value), whole(omega, -500, 500)
        self.powers = {whole(i, 0, factors - 1): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")

    def sides(self, x: int, factors: list[int]) -> tuple[int, int]:
        """Numerator and denominator, with values of x and the factors."""
        powers = [(x, self.omega), *((factors[i], n) for i, n in self.powers.items())]
        above, below = (prod(base ** max(sign * n, 0) for base, n in powers) for sign in (1, -1))
        return self.number.numerator * above, self.number.denominator * below

    def degrees(self, own: int, factors: list[int]) -> list[int]:
        """Those of numerator and denominator, with degrees of x and the factors."""
        powers = [(own, self.omega), *((factors[i], n) for i, n in self.powers.items())]
        return [sum(degree * max(sign * n, 0) for degree, n in powers) for sign in (1, -1)]


def functions(scene: Scene, omega: int, pi: int) -> dict[str, Ratio]:
    """The ten functions, numerator and denominator, at a frequency."""
    (n, d), (p, q) = scene.at(Value(0, omega, s=1), pi)
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
        x, (top, bottom) = found[f"difference.{part}"][0], scene.threshold[part].at(pi)
        square = bottom.times(bottom)
        found[f"excess.{part}"] = x.times(x).times(square).plus(below.times(top).times(top), -1), below.times(square)
    return found


def link(
    told: dict[str, Product], factors: list[tuple[int, Polynomial]], scene: Callable[[int, int], dict[str, Ratio]]
) -> None:
    """RefusedError unless the products are the functions of a scene at (x, pi): on a grid that decides it."""
    by_x, by_pi = [step * (len(p) - 1) for step, p in factors], [max(map(len, p)) - 1 for _, p in factors]
    size: dict[str, list[int]] = {}
    for name, (top, bottom) in scene(0, 1).items():
        (up, down), (over, under) = told[name].degrees(1, by_x), told[name].degrees(0, by_pi)
        size[name] = [max(top.s + down, bottom.s + up, 0) + 1, max(top.pi + under, bottom.pi + over, 0) + 1]
    n, m = (max(x) for x in zip(*size.values(), strict=True))
    need(n <= 3000 and n * m <= 100_000, "the degrees are too high")
    vanishing = set(told)
    for pi in range(1, m + 1):
        rows = [(step, [sum(c * pi**i for i, c in enumerate(row)) for row in p]) for step, p in factors]
        for x in range(max(k for k, most in size.values() if most >= pi)):
            values = [sum(c * x ** (step * i) for i, c in enumerate(row)) for step, row in rows]
            for name, (top, bottom) in scene(x, pi).items():
                if x < size[name][0] and pi <= size[name][1]:
                    left, right = told[name].sides(x, values)
                    need(
                        left * bottom.re == right * top.re and left * bottom.im == right * top.im,
                        f"{name} is not that of the scene",
                    )
                    vanishing -= {name} if bottom[:2] != (0, 0) and right else set()
    need(not vanishing, f"{', '.join(vanishing)} is nowhere defined")
