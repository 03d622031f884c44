"""By how much ratios differ between a scene and some of its effects: bounds all over the band.

A scene along its band in ball arithmetic: on each piece of the band a power series whose coefficients are proven.

The links of the chain run in truncated series, without the zeros of H_env on the axis: a free mass at omega = 0 and a resonance
without damping, where ratios are limits, are as good as any other place. What is felt behind the first effects is
remembered, as subsets of effects share their beginnings.

The largest value of a function on an interval, between two proven bounds: by branch and bound.

By how much r_r and r_i differ between a scene with all of its effects and with some of them, everywhere on the band: proven.

With a and b the parts of dH it is ``| |a| - |b| |/|H_env| = min(|a - b|, |a + b|)/|H_env|``: a minimum of two smooth functions,
so that no sign has to be known. Ball arithmetic bounds them piece by piece; where it cannot (a pole of H_perc, a zero of H_env
that does not cancel, a power of omega at 0) the exact functions decide.

Where a region may, and where it must, be left by a scene whose distortion is known but for a bound on each part.

The changes of Re dH and Im dH, relative to ``|H_env|``, by what was left out are at most e_r and e_i large. Of a region that
judges both parts, how many times it must be enlarged is sublinear: it changes at most by what the box of these changes takes.
Of one part |x| changes at most by e, and ``P^2 - E^2``, P and E that part of H_perc and H_env, whose sign tells whether it
grows, at most by e P^2 + (e + e^2) |H_env|^2; |X| > F + e |H_env| where X^2 > (1 + e) F^2 + (e + e^2) |H_env|^2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, nextafter, sqrt
from typing import Any, NamedTuple, Protocol, Self, TypeAlias, TypeVar

from flint import acb_series, arb, arb_series
from sympy import Expr, Rational

from haptisym.judge.crossings import level
from haptisym.judge.peaks import largest
from haptisym.judge.regions import Change, Diamond, Ellipse, Polygon, Region, Sided
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.objects import Shown, counted
from haptisym.kernel.reals import Ball, SquareRoot, expression_ball
from haptisym.kernel.rings import RationalFunction, omega
from haptisym.kernel.roots import Lattice, Signed, chart
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part, positive
from haptisym.model.scene import Scene
from haptisym.programs.links import links
from haptisym.programs.series import BALL_SERIES, InSteps, Series, along_axis, series_arithmetic

Kept = frozenset[int]
"""The effects of a scene that are there, by their places in it."""

TERMS = 6
"""Of a power series in the middle of a piece; its next term over the whole piece bounds the rest."""
_REMEMBERED = 1 << 13


class BandPiece(NamedTuple):
    """One of the 2^depth equal pieces of a band, counted from its low end."""

    depth: int = 0
    place: int = 0

    def halves(self) -> tuple[BandPiece, BandPiece]:
        """Its two halves."""
        return BandPiece(self.depth + 1, 2 * self.place), BandPiece(self.depth + 1, 2 * self.place + 1)


class BallChain(Shown):
    """A scene whose parameters are numbers, to be evaluated for any subset of its effects on pieces of its band.

    To be used within ``series_arithmetic``. Series are in the distance from the middle of a piece, rad/s: with their
    coefficients there, or with those that hold everywhere on the piece (``whole``).
    """

    def _line(self) -> str:
        return f"of {counted(len(self.everything), 'effect')} in ball arithmetic"

    def __init__(self, scene: Scene) -> None:
        self.low, self.width = scene.band[0], scene.band[1] - scene.band[0]
        rendered = scene.rendered or scene.environment
        chain, self._exchanged = Chain(
            scene.environment.H, rendered.H, tuple(e.matrix for e in scene.effects)
        ).without_axis_zeros()
        own = links(chain.environment, chain.rendered, chain.matrices)
        self.everything: Kept = frozenset(range(len(own.effects)))
        with series_arithmetic():
            self.band = expression_ball(self.low), expression_ball(self.width)
        self.programs = (own.start, *own.effects)
        self._series = [InSteps(program, BALL_SERIES) for program in self.programs]
        self._known = lru_cache(_REMEMBERED)(self._first_steps)
        self._behind = lru_cache(_REMEMBERED)(self._through)
        self._start = lru_cache(_REMEMBERED)(self._beginning)
        self._along = lru_cache(_REMEMBERED)(self._in_s)
        self._change = lru_cache(_REMEMBERED)(self._change_of)

    def ends(self, piece: BandPiece) -> tuple[Expr, Expr]:
        """The exact ends of a piece, rad/s."""
        low, high = (self.low + self.width * Rational(piece.place + i, 2**piece.depth) for i in (0, 1))
        return low, high

    def middle(self, piece: BandPiece) -> Ball:
        """The middle of a piece of the band."""
        low, width = self.band
        return low + width * arb(2 * piece.place + 1) * arb(2) ** (-piece.depth - 1)

    def radius(self, piece: BandPiece) -> Ball:
        """Half the width of a piece, rounded up."""
        return (self.band[1] * arb(2) ** (-piece.depth - 1)).upper()

    def _first_steps(self, piece: BandPiece, whole: bool, link: int) -> list[Any]:  # noqa: FBT001 - remembered by piece
        return self._series[link].known(self._along(piece, whole))

    def _in_s(self, piece: BandPiece, whole: bool) -> Series:  # noqa: FBT001
        x = self.middle(piece)
        return along_axis(x + arb(0, self.radius(piece)), TERMS + 1) if whole else along_axis(x, TERMS)

    def _beginning(self, piece: BandPiece, whole: bool) -> tuple[Series, Series, Series]:  # noqa: FBT001
        """What is rendered, by how much it differs from H_env, and what to multiply with instead of dividing by ``|H_env|``."""
        H, felt, change = self._results(piece, whole, 0)
        re, im = (self.part_of(H, part) for part in Part)
        return felt, change, (re * re + im * im).rsqrt()

    def _through(self, piece: BandPiece, whole: bool, kept: tuple[int, ...]) -> tuple[Series, Series]:  # noqa: FBT001
        """What is felt behind some effects, and dH."""
        if not kept:
            return self._start(piece, whole)[:2]
        felt, change = self._results(piece, whole, 1 + kept[-1], self._behind(piece, whole, kept[:-1]))
        return felt, change

    def _results(self, piece: BandPiece, whole: bool, link: int, before: Sequence[Series] = ()) -> list[Series]:  # noqa: FBT001
        known = self._known(piece, whole, link)
        found = self._series[link].results(known, before)
        return [x if isinstance(x, acb_series) else acb_series([x], prec=TERMS + whole) for x in found]

    def changes(self, piece: BandPiece, kept: Kept, part: Part, *, whole: bool) -> tuple[Series, Series]:
        """(a - b)/``|H_env|`` and (a + b)/``|H_env|``, where a and b are a part of dH with all effects and with some."""
        full, some = (self._change(piece, whole, which, part) for which in (self.everything, kept))
        scale = self._start(piece, whole)[2]
        return (full - some) * scale, (full + some) * scale

    def _change_of(self, piece: BandPiece, whole: bool, kept: Kept, part: Part) -> Any:  # noqa: FBT001
        """A part of dH with some effects."""
        return self.part_of(self._behind(piece, whole, tuple(sorted(kept)))[1], part)

    def part_of(self, x: Any, part: Part) -> Any:
        """That part of a series, or of complex floats, over the zeros of H_env, which may turn it."""
        real = (part is Part.REAL) != self._exchanged
        if isinstance(x, acb_series):
            return arb_series([c.real if real else c.imag for c in x.coeffs()], prec=x.prec)
        return x.real if real else x.imag


Bounds: TypeAlias = tuple[float, float]

WIDTH = 2e-7
"""Of the enclosure of a supremum, relative to it."""
_NOTHING = 1e-12  # a supremum below it is known well enough
_MOST_CELLS = 1 << 15


class Divisible(Protocol):
    """A part of the domain that can be halved."""

    def halves(self) -> tuple[Self, Self]:
        """Its two parts, which together are all of it."""


C = TypeVar("C", bound=Divisible)


@dataclass(frozen=True, slots=True)
class Supremum:
    """A proven enclosure of the least upper bound of a function >= 0; both ends are infinite if it is unbounded."""

    least: float
    most: float

    @property
    def is_finite(self) -> bool:
        """Whether an upper bound was found."""
        return self.most < inf


def supremum(whole: C, bounds: Callable[[C], Bounds], limit: float | None = None) -> Supremum:
    """The supremum of a function over ``whole``.

    ``bounds`` : of a cell, a value that the function reaches on it and one that it does not exceed there (both infinite only if
    it is proven to be unbounded). The cell with the highest bound is halved until the enclosure is narrow, or, with a ``limit``,
    until it is proven on which side of it the supremum lies (equal counts as below).

    >>> @dataclass(frozen=True)
    ... class Span:
    ...     low: float
    ...     high: float
    ...     def halves(self):
    ...         middle = (self.low + self.high) / 2
    ...         return Span(self.low, middle), Span(middle, self.high)
    >>> found = supremum(Span(0, 3), lambda x: (max(x.low * (2 - x.low), 0), max(x.high * (2 - x.low), 0)))
    >>> found.least <= 1 <= found.most < 1.00001
    True
    """
    least, most = bounds(whole)
    waiting = Waiting([(most, whole)], lambda x: -x[0], most=_MOST_CELLS)
    for most, cell in waiting:
        if least >= most or _is_enough(least, most, limit):
            break
        halves = [(*bounds(half), half) for half in cell.halves()]
        least = max(least, *(reached for reached, _, _ in halves))
        waiting.add(*((bound, half) for _, bound, half in halves))
    return Supremum(least, max([least, *(most for most, _ in waiting.rest)]))


def _is_enough(least: float, most: float, limit: float | None) -> bool:
    if limit is not None and (most <= limit or least > limit):
        return True
    return most - least <= max(WIDTH * least, _NOTHING)


_NOTHING_DIFFERENCES = 1e-20  # in the middle of some pieces: then it is asked whether the functions are zero
_DEEP = 8  # halvings until a piece that ball arithmetic cannot bound is looked at exactly; near its zero all pieces are loose
_DEEPEST = 24  # halvings until that must tell


@dataclass(frozen=True)
class SupremumBounds:
    """Of a function >= 0 on a piece: a value that it is nowhere below, one that it reaches, one that it nowhere exceeds."""

    least: float
    reached: float
    most: float


@dataclass(frozen=True)
class Difference:
    """|r with all effects - r with some| as a function of omega, for one part of one scene.

    ``signed`` : |a - b|/|H_env| instead, which is what a region that tells signs apart asks for.
    """

    scene: Scene
    balls: BallChain
    kept: Kept
    part: Part
    signed: bool = False

    def supremum(self, limit: float | None = None) -> Supremum:
        """Its least upper bound on the band; with a limit only as narrow as it takes to say on which side of it that lies."""
        if self.kept == self.balls.everything:
            return Supremum(0.0, 0.0)
        with series_arithmetic():
            if self._looks_zero() and any(f.is_zero for f in self._functions):
                return Supremum(0.0, 0.0)
            return supremum(BandPiece(), self._bounds, limit)

    def _looks_zero(self) -> bool:
        pieces = (BandPiece(3, i) for i in range(8))
        return all(_up(min(self._middle(piece), key=_up)) < _NOTHING_DIFFERENCES for piece in pieces)

    def _middle(self, piece: BandPiece) -> list[Ball]:
        """a - b and a + b over |H_env| in the middle of a piece."""
        return [series[0] for series in self._changes(piece, whole=False)]

    def _changes(self, piece: BandPiece, *, whole: bool) -> tuple[Series, ...]:
        """The series of a - b and, where signs do not matter, of a + b."""
        minus, plus = self.balls.changes(piece, self.kept, self.part, whole=whole)
        return (minus,) if self.signed else (minus, plus)

    def stays_within(self, limit: Expr) -> bool | None:
        """Whether it exceeds an exact number nowhere, by the exact functions: also where it just reaches it. None: undecided."""
        low, high = self.scene.band
        table = chart({i: level(f, limit**2) for i, f in enumerate(self.squares)}, low, high)
        exceeds = bool(table.where(lambda signs: min(signs.values()) > 0))
        return None if table.undecided and not exceeds else not exceeds

    def at_middle(self, piece: BandPiece) -> float:
        """A lower bound of its value in the middle of a piece."""
        return min(map(_down, self._middle(piece)))

    def range(self, piece: BandPiece) -> SupremumBounds:
        """Its range on a piece; unbounded above where ball arithmetic tells no bound."""
        middle, whole = (self._changes(piece, whole=x) for x in (False, True))
        h = self.balls.radius(piece)
        found = [_Expansion(*pair, h) for pair in zip(middle, whole, strict=True)]
        reached = max(map(min, zip(*(x.values for x in found), strict=True)))
        return SupremumBounds(min(x.least for x in found), reached, min(x.most for x in found))

    def _bounds(self, piece: BandPiece) -> tuple[float, float]:
        found = self.range(piece)
        if found.most == inf and piece.depth >= _DEEP:
            return self._exact_bounds(piece)
        return found.reached, found.most

    def _exact_bounds(self, piece: BandPiece) -> tuple[float, float]:
        """Bounds by the exact functions; both infinite where both functions have the same pole."""
        low, high = self.balls.ends(piece)
        tops = [largest(f, low, high) for f in self.squares]
        bounded = [nextafter(float(SquareRoot(top)), inf) for top in tops if top is not None]
        if bounded:
            return 0.0, min(bounded)
        points = chart(dict(enumerate(self.squares)), low, high).points
        if any(all(p.orders.get(i, 0) < 0 for i in range(len(self.squares))) for p in points):
            return inf, inf
        if piece.depth < _DEEPEST:
            return 0.0, inf
        raise UndecidedError(f"whether a difference of ratios is bounded near {float(low):.10g} rad/s")

    @cached_property
    def _functions(self) -> tuple[RealFunction, ...]:
        """a - b and, where signs do not matter, a + b, exact."""
        full = self.scene.distortion()
        perceived, env = full.chain.perceived(sorted(self.kept)), full.env
        both = (full.perc - perceived, full.perc + perceived - env - env)
        return tuple(part_of(on_axis(x.reduced()), self.part) for x in both[: 1 if self.signed else 2])

    @cached_property
    def squares(self) -> tuple[RealFunction, ...]:
        """``(a - b)^2/|H_env|^2`` and ``(a + b)^2/|H_env|^2``, exact and in lowest terms."""
        modulus = self.scene.distortion().squared_modulus
        return tuple(f * f / modulus for f in self._functions)


class _Expansion:
    """What a series in the middle of a piece, with a bound on the rest of it, says about the absolute value on the piece."""

    def __init__(self, middle: Series, whole: Series, radius: Ball) -> None:
        terms = [*(middle[k] for k in range(TERMS)), whole[TERMS]]
        spread = sum((abs(c) * radius**k for k, c in enumerate(terms) if k), arb(0))
        centre = abs(terms[0])
        inside = radius * (1 - arb(2) ** -40)
        self.least = max(nextafter(_down(terms[0]) - _up(spread), -inf), 0.0)
        self.most = min(_up(centre + spread), _up(whole[0]))
        self.values = [_down(terms[0]), *(_down(_polynomial(terms, t)) for t in (-inside, inside))]


def _polynomial(coefficients: list[Ball], t: Ball) -> Ball:
    total = arb(0)
    for c in reversed(coefficients):
        total = total * t + c
    return total


def _up(x: Ball) -> float:
    """A float that |x| does not exceed."""
    return nextafter(float(x.abs_upper()), inf) if x.is_finite() else inf


def _down(x: Ball) -> float:
    """A float that |x| is not below."""
    return max(nextafter(float(x.abs_lower()), -inf), 0.0) if x.is_finite() else 0.0


ChangeBounds = Mapping[Part, Rational]
"""Of the change of each part, relative to |H_env|."""


class Levels(NamedTuple):
    """Not positive: the region is not left for certain; ``must`` : positive where it is left for certain."""

    may: Signed | None
    """None where it may be left anywhere."""
    must: Signed


def levels(region: Region, d: Distortion, change: ChangeBounds, band: tuple[Expr, Expr]) -> Levels:
    """The functions of a scene without some effects that tell where the full one may, and must, leave a region."""
    if isinstance(region, Sided):
        return _of_part(region, d, change[region.part], band)
    reach = _reach(region, change, band)
    must = _at(region, d, 1 + reach)
    return Levels(_at(region, d, 1 - reach) if reach < 1 else None, must)


def _at(region: Region, d: Distortion, times: Expr) -> Lattice:
    """Positive where a region must be enlarged more often than that."""
    number = Change(d).number(times**2)
    return Lattice(
        tuple((*x.where, *(RealFunction((f.function - number).reduced()) for f in x.squares)) for x in region.terms(d))
    )


def _reach(region: Region, change: ChangeBounds, band: tuple[Expr, Expr]) -> Rational:
    """How many times a region must be enlarged to hold every change within the bounds; rounded up."""
    e, f = change[Part.REAL], change[Part.IMAG]
    if isinstance(region, Polygon):
        edges = [[_root(_most(x**2, band)) for x in edge] for edge in region.edges]
        return max(p * e + q * f for p, q in edges)
    assert isinstance(region, Diamond | Ellipse)
    u, v = e / region.real, f / region.imag
    if isinstance(region, Diamond):
        return _most(u + v, band)
    return _root(_most((u + v) ** 2 / (1 - region.tilt**2), band))


def _most(x: Expr, band: tuple[Expr, Expr]) -> Rational:
    """The largest value of a number, or of a formula that is never negative, on the band; rounded up."""
    if not x.has(omega):
        return Rational(x)
    found = largest(RealFunction(Ring().axis.convert(x).reduced()), *band)
    assert found is not None  # a region is one on the whole band
    high = found.bounds(60)[1]
    return Rational(high.numerator, high.denominator)


def _root(x: Rational) -> Rational:
    return Rational(nextafter(sqrt(nextafter(float(x), inf)), inf))


def _of_part(x: Sided, d: Distortion, e: Rational, band: tuple[Expr, Expr]) -> Levels:
    w = Change(d)
    own, size = w.part(x.part), w.square
    square = w.over(own * own).function
    spread = w.number(e + e**2) * size
    env, perc = (part_of(f, x.part).function for f in (d.env_response, d.perc_response))
    grown, unsure = perc * perc - env * env, w.number(e) * perc * perc + spread
    floor = [] if x.floor is None else [w.number(x.floor) ** 2]
    far = [w.number(1 + e) * own * own + spread - f for f in floor]
    sure = [own * own - w.number(1 + e) * f - spread for f in floor]

    def above(limit: Expr) -> list[RationalFunction]:
        """|x| above a limit; nothing where the limit is not positive."""
        return [square - w.number(limit) ** 2] if _is_positive(limit, band) else []

    ways = [((), x.higher)] if not x.has_sides else [((grown,), x.higher), ((-grown,), x.lower)]
    may = [[*(g + unsure for g in way), *above(limit - e), *far] for way, limit in ways]
    must = [[*(g - unsure for g in way), *above(limit + e), *sure] for way, limit in ways]
    must.append([*above(x.higher + e), *above(x.lower + e), *sure])
    return Levels(_lattice(may) if all(may) else None, _lattice(must))


def _is_positive(limit: Expr, band: tuple[Expr, Expr]) -> bool:
    return positive(limit, *band) if limit.has(omega) else bool(limit > 0)


def _lattice(terms: list[list[RationalFunction]]) -> Lattice:
    return Lattice(tuple(tuple(RealFunction(f.reduced()) for f in term) for term in terms))
