"""JND regions as exact functions: positive where a change (x, y) = (Re dH, Im dH)/|H_env| lies
outside.

A region with 0 inside is judged by how many times it must be enlarged to hold the change, which
must not be more than once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, NamedTuple, Self

from sympy import Expr, Integer, S

from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Lattice, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Corner, Part, Shape


class WayOutside(NamedTuple):
    """One way to be outside: at frequencies at which all of ``where`` are positive, as soon as all
    squares are above 1."""

    where: tuple[RealFunction, ...]
    squares: tuple[RealFunction, ...]


@dataclass(frozen=True)
class DynamicsChange:
    """A change of dynamics: its parts X and Y and the square N of what they are compared with, in
    one ring."""

    d: Distortion

    def part(self, part: Part) -> RationalFunction:
        """X or Y."""
        return part_of(self.d.difference_response, part).function

    @property
    def square(self) -> RationalFunction:
        """N = |H_env|^2."""
        return self.d.squared_modulus.function

    def number(self, x: Expr) -> RationalFunction:
        """A limit's formula in the ring of the change."""
        return self.square.ring.convert(x)

    def side(self, x: RationalFunction, power: int) -> RealFunction:
        """What tells a side and grows as a power of |H_env|: where that vanishes at omega = 0, with
        the sign of its limit."""
        form, variable = x.reduced(), x.ring.variable
        above, below = (
            min(int(n) for n, *_ in p.monoms())
            for p in (self.square.numerator, self.square.denominator)
        )
        order = max(above - below, 0) * power // 2
        return RealFunction(
            (form / form.ring.function(variable**order)).reduced() if order else form
        )

    def over(self, x: RationalFunction) -> RealFunction:
        """A square relative to that of H_env."""
        return RealFunction((x / self.square).reduced())

    def beyond(self, x: RationalFunction, limit: Expr = S.One) -> RealFunction:
        """A square relative to that of H_env, minus that of a limit."""
        return RealFunction((x / self.square - self.number(limit) ** 2).reduced())


class Region(ABC):
    """What is judged of a change at each frequency, and what is drawn of it: all is told by its
    terms."""

    @property
    @abstractmethod
    def words(self) -> str:
        """What it is called in a sentence, with its article."""

    @abstractmethod
    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        """All ways to be outside; the square of how many times the region must be enlarged is the
        largest of their least ones."""

    @abstractmethod
    def opened(self, limits: Mapping[Part, Expr]) -> Region:
        """With other limits for some parts."""

    def __call__(self, d: Distortion) -> RealFunction:
        """The square of what must not exceed 1; SceneError where that is not one smooth
        function."""
        found = self.squares(d)
        if len(found) > 1:
            raise self._not_smooth
        return found[0]

    def squares(self, d: Distortion) -> tuple[RealFunction, ...]:
        """The squares of which the largest must not exceed 1; SceneError where it is not made of
        such."""
        found = self.terms(d)
        if any(x.where or len(x.squares) > 1 for x in found):
            raise self._not_smooth
        return tuple(x.squares[0] for x in found)

    @property
    def _not_smooth(self) -> SceneError:
        return SceneError(f"{self.words} has corners: this command needs a square or an ellipse")

    def exceeded(self, d: Distortion) -> Signed:
        """Positive where the change is noticed."""
        found = tuple((*x.where, *map(above_one, x.squares)) for x in self.terms(d))
        return found[0][0] if len(found) == len(found[0]) == 1 else Lattice(found)


class Joint(Region):
    """A region that judges both parts at once."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """What it is called, without an article."""

    @abstractmethod
    def projected(self, d: Distortion, part: Part) -> Signed:
        """Positive where one part of the change, the other taken as 0, is outside."""

    @abstractmethod
    def nearer(self, d: Distortion) -> Signed:
        """Positive where the real part is nearer its own limit than the imaginary part."""

    @abstractmethod
    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        """How many times the region must be enlarged, in floats; ``number`` : the floats of an
        exact number."""


def above_one(square: RealFunction) -> RealFunction:
    """Positive where a square is above 1."""
    f = square.function
    return RealFunction(f.ring.function(f.numerator - f.denominator, f.denominator))


@dataclass(frozen=True)
class _OfHalfWidths(Joint):
    """A region in the plane of u = x/a and v = y/b."""

    real: Expr
    imag: Expr

    def _scaled(self, d: Distortion) -> tuple[DynamicsChange, RationalFunction, RationalFunction]:
        """X/a and Y/b."""
        w = DynamicsChange(d)
        return w, w.part(Part.REAL) / w.number(self.real), w.part(Part.IMAG) / w.number(self.imag)

    def opened(self, limits: Mapping[Part, Expr]) -> Self:
        return replace(self, **{part.value: x for part, x in limits.items()})


@dataclass(frozen=True)
class Ellipse(_OfHalfWidths):
    """(x/a)^2 - 2 t (x/a)(y/b) + (y/b)^2 <= 1 - t^2."""

    tilt: Expr = Integer(0)
    kind = "ellipse"
    words = "an ellipse"

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        w, u, v = self._scaled(d)
        twice = w.number(2 * self.tilt)
        return (
            WayOutside((), (w.over((u * u + v * v - twice * u * v) / w.number(1 - self.tilt**2)),)),
        )

    def projected(self, d: Distortion, part: Part) -> Signed:
        w, *own = self._scaled(d)
        x = own[part is Part.IMAG]
        return w.beyond(x * x / w.number(1 - self.tilt**2))

    def nearer(self, d: Distortion) -> Signed:
        _, u, v = self._scaled(d)
        return RealFunction((u * u - v * v).reduced())

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        u, v, t = x / number(self.real), y / number(self.imag), number(self.tilt)
        return ((u * u + v * v - 2 * t * u * v) / (1 - t * t)) ** 0.5


@dataclass(frozen=True)
class Cornered(_OfHalfWidths):
    """p u + q v <= 1 for each edge; where the opposite of each edge is one, too, (p u + q v)^2 <= 1
    for each pair.

    ``corners`` : (u, v), counterclockwise around 0. ``shape`` : a polygon, or what it is called.
    """

    corners: tuple[Corner, ...]
    shape: Shape = Shape.POLYGON

    @property
    def kind(self) -> str:
        return self.shape.value

    @property
    def words(self) -> str:
        return self.shape.words

    @property
    def edges(self) -> tuple[Corner, ...]:
        """(p, q) of each edge."""
        found = []
        for (x, y), (right, up) in zip(
            self.corners, [*self.corners[1:], self.corners[0]], strict=True
        ):
            area = x * up - y * right
            found.append(((up - y) / area, (x - right) / area))
        return tuple(found)

    @property
    def pairs(self) -> tuple[Corner, ...]:
        """One edge of each pair of opposite ones; none unless all are such, as a shape that tells
        its corners has them."""
        half = len(self.edges) // 2
        paired = self.shape.corners and self.edges[half:] == tuple(
            (-p, -q) for p, q in self.edges[:half]
        )
        return self.edges[:half] if paired else ()

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        return self._outside(d, tuple(Part))

    def projected(self, d: Distortion, part: Part) -> Signed:
        if self.pairs:
            w, *own = self._scaled(d)
            x = (
                w.number(max(edge[part is Part.IMAG] for edge in self.edges))
                * own[part is Part.IMAG]
            )
            return w.beyond(x * x)
        return Lattice(
            tuple((*x.where, *map(above_one, x.squares)) for x in self._outside(d, (part,)))
        )

    def _outside(self, d: Distortion, parts: tuple[Part, ...]) -> tuple[WayOutside, ...]:
        w, *scaled = self._scaled(d)
        found = []
        for edge in self.pairs or self.edges:
            own = [w.number(edge[part is Part.IMAG]) * scaled[part is Part.IMAG] for part in parts]
            along = (own[0] + own[1] if len(own) == 2 else own[0]).reduced()
            found.append(
                WayOutside(() if self.pairs else (w.side(along, 1),), (w.over(along * along),))
            )
        return tuple(found)

    def nearer(self, d: Distortion) -> Signed:
        w, u, v = self._scaled(d)
        if self.pairs:
            u, v = (w.number(max(edge[i] for edge in self.edges)) * x for i, x in enumerate((u, v)))
            return RealFunction((u * u - v * v).reduced())
        across, up = (_extremes([edge[i] for edge in self.edges]) for i in (0, 1))
        return Lattice(
            tuple(
                tuple(RealFunction((w.number(p) * u - w.number(q) * v).reduced()) for q in up)
                for p in across
            )
        )

    def opened(self, limits: Mapping[Part, Expr]) -> Cornered:
        if limits and not self.shape.corners:
            raise SceneError("jnd: a polygon has no limit for one part: change its corners")
        return super().opened(limits)

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        u, v = x / number(self.real), y / number(self.imag)
        found = (number(p) * u + number(q) * v for p, q in self.edges)
        return reduce(lambda largest, one: (largest + one + abs(largest - one)) / 2, found)


@dataclass(frozen=True)
class Sided(Region):
    """One part, with a limit for a magnitude that grows and one for a magnitude that shrinks, or
    with a floor, or both.

    Where the part is as large as it was, the larger limit holds, so that what is not noticed is a
    closed set.
    """

    part: Part
    higher: Expr
    lower: Expr
    floor: Expr | None = None

    @property
    def has_sides(self) -> bool:
        """Whether it matters in which way the part changes."""
        return bool(self.higher != self.lower)

    @property
    def words(self) -> str:
        return f"a JND with {'limits for higher and lower' if self.has_sides else 'a floor'}"

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        w = DynamicsChange(d)
        square = w.part(self.part) * w.part(self.part)
        higher, lower = (w.over(square / w.number(x) ** 2) for x in (self.higher, self.lower))
        least = (
            ()
            if self.floor is None
            else (RealFunction((square / w.number(self.floor) ** 2).reduced()),)
        )
        if not self.has_sides:
            return (WayOutside((), (higher, *least)),)
        env, perc = (part_of(x, self.part).function for x in (d.env_response, d.perc_response))
        up, down = (w.side(x, 2) for x in (perc * perc - env * env, env * env - perc * perc))
        return (
            WayOutside((up,), (higher, *least)),
            WayOutside((down,), (lower, *least)),
            WayOutside((), (higher, lower, *least)),
        )

    def opened(self, limits: Mapping[Part, Expr]) -> Sided:
        x = limits.get(self.part)
        return self if x is None else replace(self, higher=x, lower=x)


def _extremes(values: Sequence[Expr]) -> list[Expr]:
    """Those among which the largest multiple is: the ends, where they are rational numbers."""
    listed = sorted(set(values), key=str)
    return [min(listed), max(listed)] if all(x.is_Rational for x in listed) else listed
