"""JND regions: which changes of dynamics a person does not notice, as exact functions of omega.

Question: at which frequencies does the change from H_env to H_perc lie outside of a region of the
plane? The change is dH = H_perc - H_env, on s = j omega relative to |H_env|:

    (x, y) = (Re dH, Im dH)/|H_env|.

**The factor.** A region that contains 0 is judged by the factor f(omega) by which it must be
enlarged to contain (x, y) (its Minkowski functional): the change is noticed where f > 1. With the
half widths a and b, u = x/a and v = y/b, its square is

    ellipse:   (u^2 - 2 t u v + v^2)/(1 - t^2),  t the tilt,
    polygon:   max over the edges p u + q v = 1 with p u + q v > 0 of (p u + q v)^2,
    one part:  x^2/a^2 with a, in place of one limit, larger or smaller as the part grows or
               shrinks; and a floor in its own unit that must be exceeded as well.

**Why squares, and how.** |H_env| is the square root of a rational function N of omega, |H_env|^2 is
N itself: with X = Re dH and Y = Im dH the squares are quotients of rational functions, exact, whose
signs and zeros are decided. Where H_env is 0 and dH is not they have poles, beside which the change
is noticed. Conditions are handled without case distinctions: to be outside is a
union of ``WayOutside``, each an intersection of conditions g > 0 and squares > 1. As a union is a
maximum and an intersection a minimum of functions, the change is noticed where the maximum over the
ways of min(g..., square - 1...) is positive (a ``Lattice``).

Begin reading at ``Region`` and its ``terms``. ``d`` is a ``Distortion``: H_env, H_perc and dH.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Any, NamedTuple, Self

from sympy import Expr, Integer, S

from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction
from haptisym.kernel.roots import Lattice, Signed
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Corner, Part, Shape


class WayOutside(NamedTuple):
    """One way to be outside a region: at frequencies at which all of ``where`` are positive and all
    ``squares`` are above 1."""

    where: tuple[RealFunction, ...]
    squares: tuple[RealFunction, ...]


@dataclass(frozen=True)
class DynamicsChange:
    """The change dH of a distortion ``d`` in the terms of a region, all in one ring: X = Re dH,
    Y = Im dH and N = |H_env|^2, with what a region makes of them."""

    d: Distortion

    def part(self, part: Part) -> RationalFunction:
        """X or Y, by the part."""
        return part_of(self.d.difference_response, part).function

    @property
    def square(self) -> RationalFunction:
        """N = |H_env|^2."""
        return self.d.squared_modulus.function

    def number(self, x: Expr) -> RationalFunction:
        """A number, or a formula in omega, in the ring of the change."""
        return self.square.ring.convert(x)

    def side(self, x: RationalFunction, power: int) -> RealFunction:
        """A function with the sign of ``x`` at all omega > 0 and the sign of its limit at 0.

        ``x`` : a function that shows on which side a change lies, of the size of |H_env|^power.
        """
        # Near 0 N grows as a product of powers of omega, and |H_env|^power as its power/2. Without
        # that factor, positive for omega > 0, the function is not 0 at omega = 0 merely because
        # H_env is. Where lowest terms of N cancel, or the product has no such root in the ring, the
        # function may still be 0 there: never of the wrong sign.
        reduced = x.reduced()
        growth = [
            (a - b) * power
            for a, b in zip(
                _lowest_powers(self.square.numerator, self.square.ring),
                _lowest_powers(self.square.denominator, self.square.ring),
                strict=True,
            )
        ]
        if any(n < 0 or n % 2 for n in growth) or not any(growth):
            return RealFunction(reduced)
        product = self.square.ring.context.from_dict({tuple(n // 2 for n in growth): 1})
        return RealFunction((reduced / self.square.ring.function(product)).reduced())

    def over(self, square: RationalFunction) -> RealFunction:
        """A square, as X^2, relative to |H_env|^2."""
        return RealFunction((square / self.square).reduced())

    def beyond(self, square: RationalFunction, limit: Expr = S.One) -> RealFunction:
        """A square relative to |H_env|^2, minus the square of a limit."""
        return RealFunction((square / self.square - self.number(limit) ** 2).reduced())


def _lowest_powers(polynomial: Polynomial, ring: PolynomialRing) -> list[int]:
    """The exponents of omega and of all omega^alpha, in places of the ring's generators, of the
    term that is largest near omega = 0: tangents of delay angles grow as omega. 0 for all of them
    where an order alpha is no number."""
    assert isinstance(ring, Axis)
    none = [0] * len(ring.meanings)
    if not all(order.is_number for order in ring.orders):
        return none
    first_order, lowest = ring.size + len(ring.angles), dict[Expr, list[int]]()
    for exponents in polynomial.monoms():
        powers = [*map(int, exponents)]
        tangents = zip(ring.angles, powers[ring.size : first_order], strict=True)
        of_orders = powers[first_order:]
        of_omega = powers[0] + sum(n for angle, n in tangents if not angle.constant)
        total = sum((a * n for a, n in zip(ring.orders, of_orders, strict=True)), of_omega + S.Zero)
        lowest[total] = [of_omega, *none[1:first_order], *of_orders]
    return lowest[min(lowest)]


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
        """The region with other limits, numbers or symbols, for some parts."""

    def __call__(self, d: Distortion) -> RealFunction:
        """The square of the factor that must not exceed 1; SceneError where that is not one
        rational function."""
        squares = self.squares(d)
        if len(squares) > 1:
            raise self._not_smooth
        return squares[0]

    def squares(self, d: Distortion) -> tuple[RealFunction, ...]:
        """The squares whose maximum must not exceed 1; SceneError where the region has conditions,
        or minima, as well."""
        terms = self.terms(d)
        if any(way.where or len(way.squares) > 1 for way in terms):
            raise self._not_smooth
        return tuple(way.squares[0] for way in terms)

    @property
    def _not_smooth(self) -> SceneError:
        """The error of a question that needs one rational function."""
        return SceneError(f"{self.words} has corners: this command needs a square or an ellipse")

    def exceeded(self, d: Distortion) -> Signed:
        """A function that is positive exactly where the change is noticed: rational, or a maximum
        of minima."""
        terms = _minima(self.terms(d))
        return terms[0][0] if len(terms) == len(terms[0]) == 1 else Lattice(terms)


class Joint(Region):
    """A region that judges both parts at once. ``Signed`` : a function whose sign is decided."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """The name of the region, without an article."""

    @abstractmethod
    def projected(self, d: Distortion, part: Part) -> Signed:
        """Positive where one part of the change, the other taken as 0, is outside."""

    @abstractmethod
    def nearer(self, d: Distortion) -> Signed:
        """Positive where the real part is nearer its own limit (that of ``projected``) than the
        imaginary part is to its own: the sign of the difference of their squares."""

    @abstractmethod
    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        """The factor f at a change (x, y), in floats, symbols or arrays; ``number`` : what stands
        for an exact number there."""


def above_one(square: RealFunction) -> RealFunction:
    """The function square - 1 in lowest terms, positive where the square is above 1."""
    # f and f - 1 have the same denominator, and no common factor where f has none.
    f = square.function
    return RealFunction(f.ring.function(f.numerator - f.denominator, f.denominator))


def _minima(ways: Sequence[WayOutside]) -> tuple[tuple[RealFunction, ...], ...]:
    """Of each way all functions that are positive together where it leads outside: its conditions,
    and its squares less 1."""
    return tuple((*way.where, *map(above_one, way.squares)) for way in ways)


@dataclass(frozen=True)
class _OfHalfWidths(Joint):
    """A region in the plane of u = x/a and v = y/b, with half widths a = ``real`` and b =
    ``imag``."""

    real: Expr
    imag: Expr

    def _scaled(self, d: Distortion) -> tuple[DynamicsChange, RationalFunction, RationalFunction]:
        """The change, and X/a and Y/b in its ring: |H_env| u and |H_env| v."""
        change = DynamicsChange(d)
        U = change.part(Part.REAL) / change.number(self.real)
        V = change.part(Part.IMAG) / change.number(self.imag)
        return change, U, V

    def opened(self, limits: Mapping[Part, Expr]) -> Self:
        return replace(self, **{part.value: x for part, x in limits.items()})


@dataclass(frozen=True)
class Ellipse(_OfHalfWidths):
    """The ellipse u^2 - 2 t u v + v^2 <= 1 - t^2, t = ``tilt``, |t| < 1: with extremes of x and y
    at +-a and +-b, so that the rectangle around it does not depend on the tilt."""

    tilt: Expr = Integer(0)
    kind = "ellipse"
    words = "an ellipse"

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        change, U, V = self._scaled(d)
        mixed = change.number(2 * self.tilt) * U * V
        form = U * U + V * V - mixed
        whole = change.number(1 - self.tilt**2)
        return (WayOutside((), (change.over(form / whole),)),)

    def projected(self, d: Distortion, part: Part) -> Signed:
        # Where the other part is 0 the border is at u^2 = 1 - t^2, or v^2.
        change, U, V = self._scaled(d)
        W = U if part is Part.REAL else V
        return change.beyond(W * W / change.number(1 - self.tilt**2))

    def nearer(self, d: Distortion) -> Signed:
        _, U, V = self._scaled(d)
        return RealFunction((U * U - V * V).reduced())

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        u = x / number(self.real)
        v = y / number(self.imag)
        t = number(self.tilt)
        square = (u * u + v * v - 2 * t * u * v) / (1 - t * t)
        return square**0.5


@dataclass(frozen=True)
class Cornered(_OfHalfWidths):
    """The convex polygon p u + q v <= 1 for each edge (p, q); where the edges come in opposite
    pairs, (p u + q v)^2 <= 1 for each pair.

    ``corners`` : (u, v), counterclockwise around 0, which is inside. ``shape`` : which kind it is,
    with corners of its own (a diamond) or any (a polygon).
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
        edges = []
        next_corners = [*self.corners[1:], self.corners[0]]
        # Cramer's rule for p u + q v = 1 at both ends of the edge, (u0, v0) and (u1, v1); with 0
        # inside the determinant is positive.
        for (u0, v0), (u1, v1) in zip(self.corners, next_corners, strict=True):
            determinant = u0 * v1 - v0 * u1
            p = (v1 - v0) / determinant
            q = (u0 - u1) / determinant
            edges.append((p, q))
        return tuple(edges)

    @property
    def pairs(self) -> tuple[Corner, ...]:
        """One edge of each pair of opposite ones; () unless the shape has corners of its own and
        all its edges come in such pairs."""
        # The square of a pair is one function, without a condition on the side.
        if not self.shape.corners:
            return ()
        edges = self.edges
        half = len(edges) // 2
        opposite = tuple((-p, -q) for p, q in edges[:half])
        return edges[:half] if edges[half:] == opposite else ()

    def terms(self, d: Distortion) -> tuple[WayOutside, ...]:
        return self._outside(d, tuple(Part))

    def projected(self, d: Distortion, part: Part) -> Signed:
        if not self.pairs:
            return Lattice(_minima(self._outside(d, (part,))))
        # With opposite edges the largest p (or q) decides for both signs of the part.
        change, U, V = self._scaled(d)
        W = U if part is Part.REAL else V
        largest = change.number(max(self._slopes(part)))
        along = largest * W
        return change.beyond(along * along)

    def _slopes(self, part: Part) -> list[Expr]:
        """The p of all edges for the real part, the q for the imaginary one."""
        return [p if part is Part.REAL else q for p, q in self.edges]

    def _outside(self, d: Distortion, parts: tuple[Part, ...]) -> tuple[WayOutside, ...]:
        """The ways to be outside with these parts of the change, another one taken as 0."""
        change, U, V = self._scaled(d)
        ways = []
        for p, q in self.pairs or self.edges:
            summands = []
            if Part.REAL in parts:
                summands.append(change.number(p) * U)
            if Part.IMAG in parts:
                summands.append(change.number(q) * V)
            along = reduce(add, summands).reduced()
            # p u + q v > 1 is (p u + q v)^2 > 1 where p u + q v > 0.
            condition = () if self.pairs else (change.side(along, 1),)
            ways.append(WayOutside(condition, (change.over(along * along),)))
        return tuple(ways)

    def nearer(self, d: Distortion) -> Signed:
        change, U, V = self._scaled(d)
        if self.pairs:
            U = change.number(max(self._slopes(Part.REAL))) * U
            V = change.number(max(self._slopes(Part.IMAG))) * V
            return RealFunction((U * U - V * V).reduced())
        # With v = 0 the factor is max over p of p u, with u = 0 it is max over q of q v. That the
        # first is larger is: over p the maximum of the minimum over q of p u - q v is positive.
        terms = []
        for p in _extremes(self._slopes(Part.REAL)):
            differences = []
            for q in _extremes(self._slopes(Part.IMAG)):
                difference = change.number(p) * U - change.number(q) * V
                differences.append(RealFunction(difference.reduced()))
            terms.append(tuple(differences))
        return Lattice(tuple(terms))

    def opened(self, limits: Mapping[Part, Expr]) -> Cornered:
        if limits and not self.shape.corners:
            raise SceneError("jnd: a polygon has no limit for one part: change its corners")
        return super().opened(limits)

    def enlarged(self, x: Any, y: Any, number: Callable[[Expr], Any]) -> Any:
        u = x / number(self.real)
        v = y / number(self.imag)
        first, *others = [number(p) * u + number(q) * v for p, q in self.edges]
        largest = first
        for factor in others:
            # max(a, b) = (a + b + |a - b|)/2, which works for numbers and for arrays alike.
            largest = (largest + factor + abs(largest - factor)) / 2
        return largest


@dataclass(frozen=True)
class Sided(Region):
    """A limit on one part of the change: one where its magnitude grows and one where it shrinks, or
    with a floor, or both.

    ``higher``, ``lower`` : limits of |Re dH|/|H_env| or |Im dH|/|H_env| where |Re H_perc| (or
    |Im H_perc|) is above, and below, that of H_env. ``floor`` : a change of the part, in its unit,
    that must be exceeded as well to be noticed; None where there is none. Where the part is as
    large as it was, the larger limit holds, so that what is not noticed is a closed set.
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
        change = DynamicsChange(d)
        X = change.part(self.part)
        square = X * X
        above_higher = change.over(square / change.number(self.higher) ** 2)
        above_lower = change.over(square / change.number(self.lower) ** 2)
        above_floor: tuple[RealFunction, ...] = ()
        if self.floor is not None:
            relative = square / change.number(self.floor) ** 2
            above_floor = (RealFunction(relative.reduced()),)
        if not self.has_sides:
            return (WayOutside((), (above_higher, *above_floor)),)
        env = part_of(d.env_response, self.part).function
        perc = part_of(d.perc_response, self.part).function
        grows = change.side(perc * perc - env * env, 2)
        shrinks = change.side(env * env - perc * perc, 2)
        # The third way has no condition: above both limits it matters not which one holds, also
        # where the magnitudes are equal and neither ``grows`` nor ``shrinks`` is positive.
        return (
            WayOutside((grows,), (above_higher, *above_floor)),
            WayOutside((shrinks,), (above_lower, *above_floor)),
            WayOutside((), (above_higher, above_lower, *above_floor)),
        )

    def opened(self, limits: Mapping[Part, Expr]) -> Sided:
        limit = limits.get(self.part)
        return self if limit is None else replace(self, higher=limit, lower=limit)


def _extremes(values: Sequence[Expr]) -> list[Expr]:
    """Those of some numbers among which the largest product with any factor, of either sign, is:
    the least and the greatest; all of them where one is not rational, as their order is not
    decided here."""
    distinct = sorted(set(values), key=str)
    if all(x.is_Rational for x in distinct):
        return [min(distinct), max(distinct)]
    return distinct
