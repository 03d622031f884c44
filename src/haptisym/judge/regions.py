"""JND regions as exact functions of omega that are positive where a change (x, y) = (Re dH, Im
dH)/|H_env| lies outside.

A region with 0 inside is judged by the factor by which it must be enlarged to hold the change,
which must not exceed 1. The square of the factor is a rational function of omega, or the maximum of
minima of several (``Region.terms``): of (x/a)^2 + (y/b)^2 for an ellipse, of (p u + q v)^2 for each
edge of a polygon, u = x/a and v = y/b. Squares, as |H_env| itself is no rational function.
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
    """One way to be outside a region: at frequencies at which all of ``where`` are positive, as
    soon as all ``squares`` are above 1."""

    where: tuple[RealFunction, ...]
    squares: tuple[RealFunction, ...]


@dataclass(frozen=True)
class DynamicsChange:
    """A change of dynamics: its parts X and Y and the square N of what they are compared with, in
    one ring."""

    d: Distortion

    def part(self, part: Part) -> RationalFunction:
        """X or Y, by the part."""
        return part_of(self.d.difference_response, part).function

    @property
    def square(self) -> RationalFunction:
        """N = |H_env|^2."""
        return self.d.squared_modulus.function

    def number(self, x: Expr) -> RationalFunction:
        """A limit's formula in the ring of the change."""
        return self.square.ring.convert(x)

    def side(self, x: RationalFunction, power: int) -> RealFunction:
        """A function whose sign shows on which side a change lies, and which is of the size of a
        ``power`` of |H_env|; where H_env vanishes at omega = 0, with the sign of its limit
        there."""
        # N grows as omega^(above - below) from 0, |H_env| as its root: without that power of omega
        # the function is not 0 at omega = 0 merely because H_env is.
        form, variable = x.reduced(), x.ring.variable
        above, below = (
            min(int(n) for n, *_ in p.monoms())
            for p in (self.square.numerator, self.square.denominator)
        )
        order = max(above - below, 0) * power // 2
        if not order:
            return RealFunction(form)
        return RealFunction((form / form.ring.function(variable**order)).reduced())

    def over(self, x: RationalFunction) -> RealFunction:
        """A square relative to that of H_env."""
        return RealFunction((x / self.square).reduced())

    def beyond(self, x: RationalFunction, limit: Expr = S.One) -> RealFunction:
        """A square relative to that of H_env, minus that of a limit."""
        return RealFunction((x / self.square - self.number(limit) ** 2).reduced())


class Region(ABC):
    """A set of changes that are not noticed, judged at each frequency; its ``terms`` define it."""

    @property
    @abstractmethod
    def words(self) -> str:
        """The name of the region in a sentence, with its article."""

    @abstractmethod
    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        """All ways to be outside. The square of the factor by which the region must be enlarged is,
        over the ways whose conditions hold, the largest of their least squares."""

    @abstractmethod
    def opened(self, limits: Mapping[Part, Expr]) -> Region:
        """The region with other limits for some parts."""

    def __call__(self, d: Distortion) -> RealFunction:
        """The square of the factor that must not exceed 1; SceneError where that is not one smooth
        function."""
        squares = self.squares(d)
        if len(squares) > 1:
            raise self._not_smooth
        return squares[0]

    def squares(self, d: Distortion) -> tuple[RealFunction, ...]:
        """The squares whose maximum must not exceed 1; SceneError where the region has conditions,
        or minima, as well."""
        terms = self.terms(d)
        if any(x.where or len(x.squares) > 1 for x in terms):
            raise self._not_smooth
        return tuple(x.squares[0] for x in terms)

    @property
    def _not_smooth(self) -> SceneError:
        return SceneError(f"{self.words} has corners: this command needs a square or an ellipse")

    def exceeded(self, d: Distortion) -> Signed:
        """Positive where the change is noticed."""
        # All conditions and all excesses of a term are positive together: a minimum of them.
        terms = tuple((*x.where, *map(above_one, x.squares)) for x in self.terms(d))
        return terms[0][0] if len(terms) == len(terms[0]) == 1 else Lattice(terms)


class Joint(Region):
    """A region that judges both parts at once."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """The name of the region, without an article."""

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
    """The function that is positive where a square is above 1."""
    # f and f - 1 have the same denominator, and no common factor where f has none.
    f = square.function
    return RealFunction(f.ring.function(f.numerator - f.denominator, f.denominator))


@dataclass(frozen=True)
class _OfHalfWidths(Joint):
    """A region in the plane of u = x/a and v = y/b, with half widths a = ``real`` and b =
    ``imag``."""

    real: Expr
    imag: Expr

    def _scaled(self, d: Distortion) -> tuple[DynamicsChange, RationalFunction, RationalFunction]:
        """The change, and X/a and Y/b in its ring."""
        w = DynamicsChange(d)
        return w, w.part(Part.REAL) / w.number(self.real), w.part(Part.IMAG) / w.number(self.imag)

    def opened(self, limits: Mapping[Part, Expr]) -> Self:
        return replace(self, **{part.value: x for part, x in limits.items()})


@dataclass(frozen=True)
class Ellipse(_OfHalfWidths):
    """The ellipse (x/a)^2 - 2 t (x/a)(y/b) + (y/b)^2 <= 1 - t^2, t = ``tilt``."""

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
        # Where the other part is 0 the border is at (x/a)^2 = 1 - t^2.
        w, *scaled = self._scaled(d)
        x = scaled[part is Part.IMAG]
        return w.beyond(x * x / w.number(1 - self.tilt**2))

    def nearer(self, d: Distortion) -> Signed:
        _, u, v = self._scaled(d)
        return RealFunction((u * u - v * v).reduced())

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        u, v, t = x / number(self.real), y / number(self.imag), number(self.tilt)
        return ((u * u + v * v - 2 * t * u * v) / (1 - t * t)) ** 0.5


@dataclass(frozen=True)
class Cornered(_OfHalfWidths):
    """The polygon p u + q v <= 1 for each edge (p, q); where the edges come in opposite pairs, (p u
    + q v)^2 <= 1 for each pair.

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
        """The pair (p, q) of each edge, p u + q v = 1 on it."""
        lines = []
        next_corners = [*self.corners[1:], self.corners[0]]
        # Cramer's rule for p u + q v = 1 at both ends; with 0 inside the determinant is positive.
        for (x, y), (right, up) in zip(self.corners, next_corners, strict=True):
            area = x * up - y * right
            lines.append(((up - y) / area, (x - right) / area))
        return tuple(lines)

    @property
    def pairs(self) -> tuple[Corner, ...]:
        """One edge of each pair of opposite ones; none unless the shape has fixed corners and all
        its edges come in such pairs."""
        # The square of a pair is one function, without a condition on the side.
        half = len(self.edges) // 2
        paired = self.shape.corners and self.edges[half:] == tuple(
            (-p, -q) for p, q in self.edges[:half]
        )
        return self.edges[:half] if paired else ()

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        return self._outside(d, tuple(Part))

    def projected(self, d: Distortion, part: Part) -> Signed:
        # With opposite edges the largest p (or q) decides for both signs of the part.
        if self.pairs:
            index = part is Part.IMAG
            w, *scaled = self._scaled(d)
            x = w.number(max(edge[index] for edge in self.edges)) * scaled[index]
            return w.beyond(x * x)
        ways = self._outside(d, (part,))
        return Lattice(tuple((*x.where, *map(above_one, x.squares)) for x in ways))

    def _outside(self, d: Distortion, parts: tuple[Part, ...]) -> tuple[WayOutside, ...]:
        """The ways to be outside of some parts of the change, the other one taken as 0."""
        w, *scaled = self._scaled(d)
        ways = []
        for edge in self.pairs or self.edges:
            summands = [w.number(edge[x is Part.IMAG]) * scaled[x is Part.IMAG] for x in parts]
            along = (summands[0] + summands[1] if len(summands) == 2 else summands[0]).reduced()
            # p u + q v > 1 is (p u + q v)^2 > 1 where p u + q v > 0.
            condition = () if self.pairs else (w.side(along, 1),)
            ways.append(WayOutside(condition, (w.over(along * along),)))
        return tuple(ways)

    def nearer(self, d: Distortion) -> Signed:
        w, u, v = self._scaled(d)
        if self.pairs:
            u, v = (w.number(max(edge[i] for edge in self.edges)) * x for i, x in enumerate((u, v)))
            return RealFunction((u * u - v * v).reduced())
        # max_p p u > max_q q v, which is max over p of the min over q of p u - q v.
        across, up = (_extremes([edge[i] for edge in self.edges]) for i in (0, 1))
        rows = []
        for p in across:
            differences = ((w.number(p) * u - w.number(q) * v).reduced() for q in up)
            rows.append(tuple(map(RealFunction, differences)))
        return Lattice(tuple(rows))

    def opened(self, limits: Mapping[Part, Expr]) -> Cornered:
        if limits and not self.shape.corners:
            raise SceneError("jnd: a polygon has no limit for one part: change its corners")
        return super().opened(limits)

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        # max(a, b) = (a + b + |a - b|)/2, which works for numbers and for arrays alike.
        u, v = x / number(self.real), y / number(self.imag)
        factors = (number(p) * u + number(q) * v for p, q in self.edges)
        return reduce(lambda largest, one: (largest + one + abs(largest - one)) / 2, factors)


@dataclass(frozen=True)
class Sided(Region):
    """A limit on one part of the change: one where its magnitude grows and one where it shrinks, or
    with a floor, or both.

    ``higher``, ``lower`` : limits of |Re dH|/|H_env| or |Im dH|/|H_env|. ``floor`` : a change of
    the part, in its unit, that must be exceeded as well to be noticed. Where the part is as large
    as it was, the larger limit holds, so that what is not noticed is a closed set.
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
        least: tuple[RealFunction, ...] = ()
        if self.floor is not None:
            least = (RealFunction((square / w.number(self.floor) ** 2).reduced()),)
        if not self.has_sides:
            return (WayOutside((), (higher, *least)),)
        env, perc = (part_of(x, self.part).function for x in (d.env_response, d.perc_response))
        up, down = (w.side(x, 2) for x in (perc * perc - env * env, env * env - perc * perc))
        # The third way has no condition: above both limits it matters not which one holds, also
        # where the magnitudes are equal and neither ``up`` nor ``down`` is positive.
        return (
            WayOutside((up,), (higher, *least)),
            WayOutside((down,), (lower, *least)),
            WayOutside((), (higher, lower, *least)),
        )

    def opened(self, limits: Mapping[Part, Expr]) -> Sided:
        x = limits.get(self.part)
        return self if x is None else replace(self, higher=x, lower=x)


def _extremes(values: Sequence[Expr]) -> list[Expr]:
    """Those of some values among which the largest product with any number is: the ends, where all
    are rational numbers."""
    listed = sorted(set(values), key=str)
    return [min(listed), max(listed)] if all(x.is_Rational for x in listed) else listed
