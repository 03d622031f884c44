"""By how much r_r and r_i differ between a scene with all of its effects and with some of them:
proven bounds all over the band.

With a and b the parts of dH it is ``| |a| - |b| |/|H_env| = min(|a - b|, |a + b|)/|H_env|``: a
minimum of two smooth functions, so that no sign has to be known. Ball arithmetic bounds them piece
by piece, on each piece of the band by a power series whose coefficients are proven; where it cannot
(a pole of H_perc, a zero of H_env that does not cancel, a power of omega at 0) the exact functions
decide. The largest value is enclosed by branch and bound.

The links of the chain run in truncated series, without the zeros of H_env on the axis: a free mass
at omega = 0 and a resonance without damping, where ratios are limits, are as good as any other
place. What is felt behind the first effects is remembered, as subsets of effects share their
beginnings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, nextafter
from typing import Any, NamedTuple

from flint import acb_series, arb, arb_series
from sympy import Expr, Rational

from haptisym.judge.crossings import level
from haptisym.judge.peaks import largest
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, on_axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.objects import Shown, counted
from haptisym.kernel.reals import Ball, SquareRoot, expression_ball
from haptisym.kernel.roots import chart
from haptisym.model.chain import Chain
from haptisym.model.distortion import part_of
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.programs.links import (
    BALL_SERIES,
    InSteps,
    Series,
    along_axis,
    links,
    series_arithmetic,
)

Kept = frozenset[int]
"""The effects of a scene that are there, by their places in it."""

TERMS = 6
"""Of a power series in the middle of a piece; its next term over the whole piece bounds the
rest."""
_REMEMBERED = 1 << 13


class BandPiece(NamedTuple):
    """One of the 2^depth equal pieces of a band, counted from its low end."""

    depth: int = 0
    place: int = 0

    def halves(self) -> tuple[BandPiece, BandPiece]:
        """Its two halves."""
        return BandPiece(self.depth + 1, 2 * self.place), BandPiece(
            self.depth + 1, 2 * self.place + 1
        )


class BallChain(Shown):
    """A scene whose parameters are numbers, to be evaluated for any subset of its effects on pieces
    of its band.

    To be used within ``series_arithmetic``. Series are in the distance from the middle of a piece,
    rad/s: with their coefficients there, or with those that hold everywhere on the piece
    (``whole``).
    """

    def _line(self) -> str:
        return f"of {counted(len(self.everything), 'effect')} in ball arithmetic"

    def __init__(self, scene: Scene) -> None:
        self.low, self.width = scene.band[0], scene.band[1] - scene.band[0]
        chain, self._exchanged = Chain(
            scene.environment.H, scene.rendering.H, tuple(e.matrix for e in scene.effects)
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
        low, high = (
            self.low + self.width * Rational(piece.place + i, 2**piece.depth) for i in (0, 1)
        )
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
        return (
            along_axis(x + arb(0, self.radius(piece)), TERMS + 1) if whole else along_axis(x, TERMS)
        )

    def _beginning(self, piece: BandPiece, whole: bool) -> tuple[Series, Series, Series]:  # noqa: FBT001
        """What is rendered, by how much it differs from H_env, and what to multiply with instead of
        dividing by ``|H_env|``."""
        H, felt, change = self._results(piece, whole, 0)
        re, im = (self.part_of(H, part) for part in Part)
        return felt, change, (re * re + im * im).rsqrt()

    def _through(
        self,
        piece: BandPiece,
        whole: bool,  # noqa: FBT001
        kept: tuple[int, ...],
    ) -> tuple[Series, Series]:
        """What is felt behind some effects, and dH."""
        if not kept:
            return self._start(piece, whole)[:2]
        felt, change = self._results(
            piece, whole, 1 + kept[-1], self._behind(piece, whole, kept[:-1])
        )
        return felt, change

    def _results(
        self,
        piece: BandPiece,
        whole: bool,  # noqa: FBT001
        link: int,
        before: Sequence[Series] = (),
    ) -> list[Series]:
        known = self._known(piece, whole, link)
        found = self._series[link].results(known, before)
        return [
            x if isinstance(x, acb_series) else acb_series([x], prec=TERMS + whole) for x in found
        ]

    def changes(
        self, piece: BandPiece, kept: Kept, part: Part, *, whole: bool
    ) -> tuple[Series, Series]:
        """(a - b)/``|H_env|`` and (a + b)/``|H_env|``, where a and b are a part of dH with all
        effects and with some."""
        full, some = (self._change(piece, whole, which, part) for which in (self.everything, kept))
        scale = self._start(piece, whole)[2]
        return (full - some) * scale, (full + some) * scale

    def _change_of(self, piece: BandPiece, whole: bool, kept: Kept, part: Part) -> Any:  # noqa: FBT001
        """A part of dH with some effects."""
        return self.part_of(self._behind(piece, whole, tuple(sorted(kept)))[1], part)

    def part_of(self, x: Any, part: Part) -> Any:
        """That part of a series, or of complex floats, over the zeros of H_env, which may turn
        it."""
        real = (part is Part.REAL) != self._exchanged
        if isinstance(x, acb_series):
            return arb_series([c.real if real else c.imag for c in x.coeffs()], prec=x.prec)
        return x.real if real else x.imag


WIDTH = 2e-7
"""Of the enclosure of a supremum, relative to it."""
_NOTHING = 1e-12  # a supremum below it is known well enough
_MOST_CELLS = 1 << 15


@dataclass(frozen=True, slots=True)
class Supremum:
    """A proven enclosure of the least upper bound of a function >= 0; both ends are infinite if it
    is unbounded."""

    least: float
    most: float

    @property
    def is_finite(self) -> bool:
        """Whether an upper bound was found."""
        return self.most < inf


_ZERO = 1e-20  # in the middle of some pieces: then it is asked whether the functions are zero
_DEEP = 8  # halvings until a piece that ball arithmetic cannot bound is looked at exactly; near its zero all pieces are loose
_DEEPEST = 24  # halvings until that must tell


@dataclass(frozen=True)
class SupremumBounds:
    """Of a function >= 0 on a piece: a value that it is nowhere below, one that it reaches, one
    that it nowhere exceeds."""

    least: float
    reached: float
    most: float


@dataclass(frozen=True)
class Difference:
    """|r with all effects - r with some| as a function of omega, for one part of one scene."""

    scene: Scene
    balls: BallChain
    kept: Kept
    part: Part

    def supremum(self, limit: float | None = None) -> Supremum:
        """Its least upper bound on the band; with a limit only as narrow as it takes to say on
        which side of it that lies."""
        if self.kept == self.balls.everything:
            return Supremum(0.0, 0.0)
        with series_arithmetic():
            looks_zero = all(min(map(_up, self._middle(BandPiece(3, i)))) < _ZERO for i in range(8))
            if looks_zero and any(f.is_zero for f in self._functions):
                return Supremum(0.0, 0.0)
            least, most = self._bounds(BandPiece())
            waiting = Waiting([(most, BandPiece())], lambda x: -x[0], most=_MOST_CELLS)
            for most, piece in waiting:
                known = least >= most or (limit is not None and (most <= limit or least > limit))
                if known or most - least <= max(WIDTH * least, _NOTHING):
                    break
                halves = [(*self._bounds(half), half) for half in piece.halves()]
                least = max(least, *(reached for reached, _, _ in halves))
                waiting.add(*((bound, half) for _, bound, half in halves))
            return Supremum(least, max([least, *(most for most, _ in waiting.rest)]))

    def _middle(self, piece: BandPiece) -> list[Ball]:
        """a - b and a + b over |H_env| in the middle of a piece."""
        return [
            series[0] for series in self.balls.changes(piece, self.kept, self.part, whole=False)
        ]

    def stays_within(self, limit: Expr) -> bool | None:
        """Whether it exceeds an exact number nowhere, by the exact functions: also where it just
        reaches it. None: undecided."""
        low, high = self.scene.band
        table = chart({i: level(f, limit**2) for i, f in enumerate(self.squares)}, low, high)
        exceeds = bool(table.where(lambda signs: min(signs.values()) > 0))
        return None if table.undecided and not exceeds else not exceeds

    def at_middle(self, piece: BandPiece) -> float:
        """A lower bound of its value in the middle of a piece."""
        return min(map(_down, self._middle(piece)))

    def range(self, piece: BandPiece) -> SupremumBounds:
        """Its range on a piece; unbounded above where ball arithmetic tells no bound."""
        middle, whole = (
            self.balls.changes(piece, self.kept, self.part, whole=x) for x in (False, True)
        )
        h = self.balls.radius(piece)
        found = [_Expansion(*pair, h) for pair in zip(middle, whole, strict=True)]
        reached = max(map(min, zip(*(x.values for x in found), strict=True)))
        return SupremumBounds(min(x.least for x in found), reached, min(x.most for x in found))

    def _bounds(self, piece: BandPiece) -> tuple[float, float]:
        """A value that it reaches on a piece and one that it does not exceed there, both infinite
        where it is unbounded: proven.

        The piece with the highest bound is halved until the enclosure is narrow.
        """
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
        raise UndecidedError(
            f"whether a difference of ratios is bounded near {float(low):.10g} rad/s"
        )

    @cached_property
    def _functions(self) -> tuple[RealFunction, ...]:
        """a - b and a + b, exact."""
        full = self.scene.distortion()
        perceived, env = full.chain.perceived(sorted(self.kept)), full.env
        both = (full.perc - perceived, full.perc + perceived - env - env)
        return tuple(part_of(on_axis(x.reduced()), self.part) for x in both)

    @cached_property
    def squares(self) -> tuple[RealFunction, ...]:
        """``(a - b)^2/|H_env|^2`` and ``(a + b)^2/|H_env|^2``, exact and in lowest terms."""
        modulus = self.scene.distortion().squared_modulus
        return tuple(f * f / modulus for f in self._functions)


class _Expansion:
    """What a series in the middle of a piece, with a bound on the rest of it, says about the
    absolute value on the piece."""

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
