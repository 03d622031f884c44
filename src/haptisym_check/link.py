"""Rule 1: the functions of a proof are those of the scene."""

from collections.abc import Callable, Iterable
from math import prod
from typing import Any

from haptisym_check.polynomials import Polynomial, keyed, listed, number, whole
from haptisym_check.scene import Ratio, Scene, Value, need

PARTS = "real", "imag"
Factors = list[tuple[int, Polynomial]]  # each a polynomial in x^step


class Product:
    """number * x^omega * product of factor^exponent."""

    def __init__(self, x: Any, factors: int) -> None:
        value, omega, powers = keyed(x, "number", "omega", "powers")
        rows = [listed(row, 2, 2) for row in listed(powers, 500)]
        self.number, self.omega = number(value), whole(omega, -500, 500)
        self.powers = {whole(i, 0, factors - 1): whole(n, -100, 100) for i, n in rows}
        need(len(self.powers) == len(rows), "a factor stands twice in a product")

    def at(self, x: Value, factors: list[Value]) -> Ratio:
        """Numerator and denominator, with values of x and the factors."""
        powers = [(x, self.omega), *((factors[i], n) for i, n in self.powers.items())]
        both = [
            Value(
                prod((v.re ** (sign * n) for v, n in powers if sign * n > 0), start=first),
                s=sum(v.s * sign * n for v, n in powers if sign * n > 0),
                pi=sum(v.pi * sign * n for v, n in powers if sign * n > 0),
            )
            for sign, first in ((1, self.number.numerator), (-1, self.number.denominator))
        ]
        return both[0], both[1]


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


def link(told: dict[str, Product], factors: Factors, scene: Callable[[int, int], dict[str, Ratio]]) -> None:
    """RefusedError unless the products are the functions of a scene at (x, pi): on a grid that decides it."""

    def gaps(x: int, pi: int, names: Iterable[str]) -> dict[str, tuple[Value, bool]]:
        """left * bottom - right * top of functions, and whether right and bottom are none of them zero."""
        rows = [[sum(c * pi**i for i, c in enumerate(row)) for row in p] for _, p in factors]
        degrees = [(step, step * (len(p) - 1), max(map(len, p)) - 1) for step, p in factors]
        values = [
            Value(sum(c * x ** (step * i) for i, c in enumerate(row)), 0, s, own)
            for row, (step, s, own) in zip(rows, degrees, strict=True)
        ]
        found, functions = {}, scene(x, pi)
        for name in names:
            (top, bottom), (left, right) = functions[name], told[name].at(Value(x, s=1), values)
            found[name] = left.times(bottom).plus(right.times(top), -1), right.re != 0 and bottom[:2] != (0, 0)
        return found

    most = {name: (max(gap.s, 0), max(gap.pi, 0) + 1) for name, (gap, _) in gaps(0, 1, told).items()}
    n, m = (max(x) for x in zip(*most.values(), strict=True))
    need(n < 3000 and (n + 1) * m <= 100_000, "the degrees are too high")
    defined = set[str]()
    for pi in range(1, m + 1):
        for x in range(max(s for s, own in most.values() if own >= pi) + 1):
            names = [name for name, (s, own) in most.items() if x <= s and pi <= own]
            for name, (gap, there) in gaps(x, pi, names).items():
                need(gap[:2] == (0, 0), f"{name} is not that of the scene")
                defined |= {name} if there else set()
    need(defined == set(told), "a function is nowhere defined")
