"""What is noticed with a JND region, a second time: straight from its definition, in plain complex arithmetic.

A JND is the table that a scene file has, its numbers texts. Nothing here comes from the package.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping, Sequence
from typing import Any

Jnd = Mapping[str, Any]


def number(text: Any, omega: float) -> float:
    """The float that a text of numbers, omega, + - * / ** means."""

    def of(node: ast.AST) -> float:
        if isinstance(node, ast.Expression):
            return of(node.body)
        if isinstance(node, ast.Constant):
            return float(node.value)  # type: ignore[arg-type]
        if isinstance(node, ast.Name):
            return omega
        if isinstance(node, ast.UnaryOp):
            return -of(node.operand)
        assert isinstance(node, ast.BinOp)
        a, b = of(node.left), of(node.right)
        return {ast.Add: a + b, ast.Sub: a - b, ast.Mult: a * b}.get(type(node.op)) or _other(node.op, a, b)

    return of(ast.parse(str(text), mode="eval"))


def _other(op: ast.operator, a: float, b: float) -> float:
    return a / b if isinstance(op, ast.Div) else a**b if isinstance(op, ast.Pow) else 0.0


def margin(jnd: Jnd, H: complex, G: complex, omega: float) -> float:
    """Positive where the change from H to G is noticed, negative where it is not; 0 at the border."""
    x, y = (G - H).real / abs(H), (G - H).imag / abs(H)
    if "shape" not in jnd:
        return max(_part(jnd, "real", H.real, G.real, abs(H), omega), _part(jnd, "imag", H.imag, G.imag, abs(H), omega))
    return outside(jnd, x, y, omega)


def outside(jnd: Jnd, x: float, y: float, omega: float) -> float:
    """The same of a change relative to |H_env|, for the shapes that judge both parts at once."""
    if jnd["shape"] == "polygon":
        corners = [(number(p, omega), number(q, omega)) for p, q in jnd["corners"]]
        return max(_beyond(p, q, x, y) for p, q in _edges(corners))
    a, b = number(jnd["real"], omega), number(jnd["imag"], omega)
    if jnd["shape"] == "diamond":
        return abs(x) / a + abs(y) / b - 1
    t = number(jnd.get("tilt", 0), omega)
    return (x / a) ** 2 - 2 * t * (x / a) * (y / b) + (y / b) ** 2 - (1 - t**2)


def _edges(corners: Sequence[tuple[float, float]]) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """The edges of a polygon, counterclockwise."""
    found = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    area = sum(p[0] * q[1] - p[1] * q[0] for p, q in found)
    return found if area > 0 else [(q, p) for p, q in found]


def _beyond(p: tuple[float, float], q: tuple[float, float], x: float, y: float) -> float:
    """How far a point lies to the right of an edge, as a multiple of how far 0 lies to the left of it."""
    of_point = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
    of_zero = p[0] * q[1] - p[1] * q[0]
    return -of_point / of_zero


def _part(jnd: Jnd, part: str, h: float, g: float, size: float, omega: float) -> float:
    """Of one part: by how much, relative to |H_env|, it exceeds the limit that holds."""
    given = jnd[part]
    if isinstance(given, Mapping):
        ways = [number(given["higher"], omega), number(given["lower"], omega)]
        limit = ways[0] if abs(g) > abs(h) else ways[1] if abs(g) < abs(h) else max(ways)
    else:
        limit = number(given, omega)
    floor = number(jnd["floor"], omega) / size if "floor" in jnd else 0.0
    return abs(g - h) / size - max(limit, floor)


def enlarged(jnd: Jnd, H: complex, G: complex, omega: float) -> dict[str, float]:
    """How many times a polygon, or the limit of a part, must be enlarged to hold a change."""
    size = abs(H)
    if "shape" in jnd:
        corners = [(number(p, omega), number(q, omega)) for p, q in jnd["corners"]]
        x, y = (G - H).real / size, (G - H).imag / size
        return {"joint": 1 + max(_beyond(p, q, x, y) for p, q in _edges(corners))}
    found = {}
    for part, h, g in (("real", H.real, G.real), ("imag", H.imag, G.imag)):
        given = jnd[part]
        own = given["higher" if abs(g) > abs(h) else "lower"] if isinstance(given, Mapping) else given
        floor = number(jnd["floor"], omega) / size if "floor" in jnd else 0.0
        found[part] = abs(g - h) / size / max(number(own, omega), floor)
    return found


def middle(ends: tuple[float, float], share: float) -> float:
    """A frequency of a band."""
    return math.fsum([ends[0] * (1 - share), ends[1] * share])
