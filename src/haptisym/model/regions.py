"""The region of changes that are not noticed, in the plane of x = Re dH/|H_env| and y = Im dH/|H_env|."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import combinations
from typing import TypeAlias

from sympy import Expr, Integer

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.kernel.symbols import omega
from haptisym.model.quantities import MotionKind
from haptisym.model.ranges import ExactRange

Corner: TypeAlias = tuple[Expr, Expr]
MOST_CORNERS = 24


class Shape(Enum):
    """Of the region."""

    SQUARE = "square"
    ELLIPSE = "ellipse"
    DIAMOND = "diamond"
    POLYGON = "polygon"


@dataclass(frozen=True, slots=True)
class Region:
    """What a region is besides its half widths; each number exact, or a rational formula in omega.

    ``tilt`` : of an ellipse. ``corners`` : of a polygon, counterclockwise. ``lower`` : of a square, the limits of Re and Im for
    changes that make the part smaller; None where they are those for changes that make it larger. ``floor`` : of a square, N/m or
    N m/rad, the least change that is noticed; ``motion`` : as its unit tells. ``ranges`` : where numbers of it may lie, by name:
    ``real.lower``, ``imag.lower``, ``floor``, and ``scale``, how many times all of it is as large as was given; ``size`` : that,
    nominal.
    """

    shape: Shape = Shape.SQUARE
    tilt: Expr = Integer(0)
    corners: tuple[Corner, ...] = ()
    lower: tuple[Expr | None, Expr | None] = (None, None)
    floor: Expr | None = None
    motion: MotionKind | None = None
    ranges: tuple[tuple[str, ExactRange], ...] = ()
    size: Expr = Integer(1)

    @property
    def numbers(self) -> dict[str, Expr]:
        """What must be positive besides the half widths, by name."""
        named = {"real: lower": self.lower[0], "imag: lower": self.lower[1], "floor": self.floor}
        return {name: x for name, x in named.items() if x is not None}

    def scaled(self, c: Expr) -> Region:
        """That many times as large."""
        corners = tuple((x * c, y * c) for x, y in self.corners)
        one, other = (None if x is None else x * c for x in self.lower)
        floor = None if self.floor is None else self.floor * c
        ranges = tuple((key, x if key == "scale" else (x[0] * c, x[1] * c)) for key, x in self.ranges)
        return replace(self, corners=corners, lower=(one, other), floor=floor, ranges=ranges)

    def check(self, low: Expr, high: Expr) -> None:
        """SceneError unless the region has 0 inside and is convex at every frequency of a band."""
        if self.shape is Shape.ELLIPSE and not positive(1 - self.tilt**2, low, high):
            raise SceneError(f"tilt: {self.tilt} must lie strictly between -1 and 1{_everywhere([self.tilt])}")
        if self.shape is Shape.POLYGON:
            _check_polygon(self.corners, low, high)


SQUARE = Region()


def positive(value: Expr, low: Expr, high: Expr) -> bool:
    """Whether a number, or a rational formula in omega, is positive (and finite) on a whole band: exact.

    >>> positive(1 - omega / 10, Integer(0), Integer(9)), positive(1 - omega / 10, Integer(0), Integer(10))
    (True, False)
    """
    if not value.has(omega):
        return sign_of_number(value) > 0
    table = chart({"": RealFunction(Ring().axis.convert(value).reduced())}, low, high)
    return all(point.at[""] > 0 and point.orders.get("", 0) >= 0 for point in table.points)


def turning(corners: Sequence[Corner], at: Expr) -> Expr:
    """Twice the area of a polygon at a frequency: positive where its corners go counterclockwise."""
    area = sum((_cross(p, q) for p, q in _edges(corners)), Integer(0))
    found: Expr = area.subs(omega, at)
    return found


def _check_polygon(corners: Sequence[Corner], low: Expr, high: Expr) -> None:
    """SceneError unless corners go once around 0, convex, at every frequency of a band."""
    everywhere = _everywhere(x for corner in corners for x in corner)
    for (i, p), (j, q) in combinations(enumerate(corners, 1), 2):
        if not positive((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2, low, high):
            where = " at some frequency" if everywhere else ""
            raise SceneError(f"corners: {i} and {j} are one point, [{p[0]}, {p[1]}]{where}")
    if not all(positive(_cross(p, q), low, high) for p, q in _edges(corners)) or _turns(corners, low, high) != 1:
        order = "0 must lie inside, not on an edge, and the corners follow in their order around it"
        raise SceneError(f"corners: {_written(corners)}: {order}{everywhere}")
    steps = [(q[0] - p[0], q[1] - p[1]) for p, q in _edges(corners)]
    if not all(positive(_cross(p, q), low, high) for p, q in _edges(steps)):
        convex = "the polygon must be convex, without corners on a straight edge"
        raise SceneError(f"corners: {_written(corners)}: {convex}{everywhere}")


def _written(corners: Sequence[Corner]) -> str:
    """``[[1/10, 0], [0, 1/10], ...]``: the first ones."""
    more = ", ..." if len(corners) > _TOLD else ""
    return f"[{', '.join(f'[{x}, {y}]' for x, y in corners[:_TOLD])}{more}]"


_TOLD = 5


def _everywhere(values: Iterable[Expr]) -> str:
    return " on the whole band" if any(x.has(omega) for x in values) else ""


def _edges(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _cross(p: Corner, q: Corner) -> Expr:
    return (p[0] * q[1] - p[1] * q[0]).expand()


def _turns(corners: Sequence[Corner], low: Expr, high: Expr) -> int:
    """How often corners, each to the left of the one before, go around 0: how often they come up over the axis of x."""
    heights = [sign_of_number(y.subs(omega, (low + high) / 2)) for _, y in corners]
    return sum(a < 0 <= b for a, b in zip(heights, [*heights[1:], heights[0]], strict=True))
