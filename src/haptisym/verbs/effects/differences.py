"""By how much r_r and r_i differ between a scene with all of its effects and with some of them:
proven bounds all over the band.

With a and b a part of dH with all effects and with some, the difference of the ratios is
``| |a| - |b| |/|H_env| = min(|a - b|, |a + b|)/|H_env|``: a minimum of two smooth functions, so
that no sign has to be known. Ball arithmetic bounds them on each piece of the band by a power
series whose coefficients are proven; where it cannot (a pole of H_perc, a zero of H_env that does
not cancel, a power of omega at 0) the exact functions decide. The largest value is enclosed by
branch and bound (``Difference.supremum``).

The links of the chain are evaluated in truncated series, with the zeros of H_env on the axis
cancelled: a free mass at omega = 0 and a resonance without damping, where ratios are limits, are
then places like any other. What is felt behind the first effects is remembered, as subsets of
effects share their beginnings.
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
from haptisym.judge.peaks import largest_value
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
"""Terms of a power series in the middle of a piece; the next one over the whole piece bounds the
rest, by Taylor's theorem."""
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
        chain_links = links(chain.environment, chain.rendered, chain.matrices)
        self.everything: Kept = frozenset(range(len(chain_links.effects)))
        with series_arithmetic():
            self.band = expression_ball(self.low), expression_ball(self.width)
        self.programs = (chain_links.start, *chain_links.effects)
        # Caches of this object alone: as of methods they would be of the class, and keep every
        # scene alive.
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

    def _first_steps(self, piece: BandPiece, whole: bool, link: int) -> list[Any]:  # noqa: FBT001
        """The steps of a link that depend on s alone, and not on what is felt before it."""
        # flags of what is remembered are positional: one call, one key
        return self._series[link].known(self._along(piece, whole))

    def _in_s(self, piece: BandPiece, whole: bool) -> Series:  # noqa: FBT001
        """s = j omega as a series on a piece."""
        # With ``whole`` the constant term is a ball that holds the piece: each coefficient then
        # holds those at all of its points, as the next one of Taylor's theorem must.
        x = self.middle(piece)
        return (
            along_axis(x + arb(0, self.radius(piece)), TERMS + 1) if whole else along_axis(x, TERMS)
        )

    def _beginning(
        self,
        piece: BandPiece,
        whole: bool,  # noqa: FBT001
    ) -> tuple[Series, Series, Series]:
        """What is rendered, by how much it differs from H_env, and 1/``|H_env|``."""
        H, felt, change = self._results(piece, whole, 0)
        re, im = (self.part_of(H, part) for part in Part)
        return felt, change, (re * re + im * im).rsqrt()

    def _through(
        self,
        piece: BandPiece,
        whole: bool,  # noqa: FBT001
        kept: tuple[int, ...],
    ) -> tuple[Series, Series]:
        """What is felt behind some effects, and dH: from what is felt behind all but the last."""
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
        """The results of a link, given those of the link before; constants as series too."""
        known = self._known(piece, whole, link)
        results = self._series[link].results(known, before)
        return [
            x if isinstance(x, acb_series) else acb_series([x], prec=TERMS + whole) for x in results
        ]

    def changes(
        self, piece: BandPiece, kept: Kept, part: Part, *, whole: bool
    ) -> tuple[Series, Series]:
        """(a - b)/``|H_env|`` and (a + b)/``|H_env|``, where a and b are a part of dH with all
        effects and with some."""
        full, some = (self._change(piece, whole, which, part) for which in (self.everything, kept))
        scale = self._start(piece, whole)[2]
        return (full - some) * scale, (full + some) * scale

    def _change_of(
        self,
        piece: BandPiece,
        whole: bool,  # noqa: FBT001
        kept: Kept,
        part: Part,
    ) -> Any:
        """A part of dH with some effects."""
        return self.part_of(self._behind(piece, whole, tuple(sorted(kept)))[1], part)

    def part_of(self, x: Any, part: Part) -> Any:
        """A part of dH from a series, or from complex floats.

        The zeros of H_env by which all was divided may be an odd power of j omega: then real and
        imaginary part are exchanged, up to a sign, which the moduli do not feel.
        """
        real = (part is Part.REAL) != self._exchanged
        if isinstance(x, acb_series):
            return arb_series([c.real if real else c.imag for c in x.coeffs()], prec=x.prec)
        return x.real if real else x.imag


WIDTH = 2e-7
"""Of the enclosure of a supremum, relative to it."""
_NOTHING = 1e-12  # absolute: an enclosure as narrow as this is enough, also of a supremum near 0
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


# Where a - b or a + b is below it in the middle of some pieces, it is decided exactly whether it is
# the zero function, of which balls would say only that it is small.
_ZERO = 1e-20
# Halvings until a piece that ball arithmetic cannot bound is examined by the exact functions, which
# are slow; before that wide pieces near a zero of H_env have no bound either.
_DEEP = 8
_DEEPEST = 24  # halvings after which a piece without a bound is undecided


@dataclass(frozen=True)
class SupremumBounds:
    """Bounds on a function >= 0 on a piece: ``least``, a value that it is nowhere below;
    ``reached``, one that it has or exceeds somewhere; ``most``, one that it nowhere exceeds."""

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
        """An enclosure of its least upper bound on the band; with a limit only as narrow as it
        takes to decide on which side of the limit that lies.

        The piece with the highest bound is halved until the enclosure is narrow.
        """
        if self.kept == self.balls.everything:
            return Supremum(0.0, 0.0)
        with series_arithmetic():
            looks_zero = all(min(map(_up, self._middle(BandPiece(3, i)))) < _ZERO for i in range(8))
            if looks_zero and any(f.is_zero for f in self._functions):
                return Supremum(0.0, 0.0)
            least, most = self._bounds(BandPiece())
            waiting = Waiting([(most, BandPiece())], lambda x: -x[0], most=_MOST_CELLS)
            for most, piece in waiting:
                # this piece has the highest bound of all that wait
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
        reaches it. None where that is undecided."""
        # the minimum of both functions exceeds the limit where both do
        low, high = self.scene.band
        table = chart({i: level(f, limit**2) for i, f in enumerate(self.squares)}, low, high)
        exceeds = bool(table.where(lambda signs: min(signs.values()) > 0))
        return None if table.undecided and not exceeds else not exceeds

    def at_middle(self, piece: BandPiece) -> float:
        """A lower bound of its value in the middle of a piece."""
        return min(map(_down, self._middle(piece)))

    def range(self, piece: BandPiece) -> SupremumBounds:
        """Its range on a piece; unbounded above where ball arithmetic gives no bound."""
        middle, whole = (
            self.balls.changes(piece, self.kept, self.part, whole=x) for x in (False, True)
        )
        h = self.balls.radius(piece)
        both = [_Expansion(*pair, h) for pair in zip(middle, whole, strict=True)]
        # the minimum of both functions at each of the points at which they are known
        smaller = map(min, zip(*(x.values for x in both), strict=True))
        least, most = min(x.least for x in both), min(x.most for x in both)
        return SupremumBounds(least, max(smaller), most)

    def _bounds(self, piece: BandPiece) -> tuple[float, float]:
        """A value that it reaches on a piece and one that it does not exceed there, both infinite
        where it is unbounded: proven."""
        bounds = self.range(piece)
        if bounds.most == inf and piece.depth >= _DEEP:
            return self._exact_bounds(piece)
        return bounds.reached, bounds.most

    def _exact_bounds(self, piece: BandPiece) -> tuple[float, float]:
        """Bounds by the exact functions; both infinite where both functions have the same pole."""
        low, high = self.balls.ends(piece)
        tops = [largest_value(f, low, high) for f in self.squares]
        bounded = [nextafter(float(SquareRoot(top)), inf) for top in tops if top is not None]
        # the minimum of both is bounded by the one of them that is
        if bounded:
            return 0.0, min(bounded)
        # Each has a pole, perhaps at different frequencies, at each of which the other one bounds
        # the minimum: then halves hold one pole each.
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
        """a - b and a + b, exact, for the part of dH with all effects and with those kept."""
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
    """Bounds on the absolute value of a function on a piece, from its Taylor expansion about the
    middle: f(m + t) = sum of c_k t^k for k < n, and c_n(x) t^n for some x of the piece.

    ``least``, ``most`` : all over the piece. ``values`` : lower bounds at its middle and near both
    of its ends.
    """

    def __init__(self, middle: Series, whole: Series, radius: Ball) -> None:
        terms = [*(middle[k] for k in range(TERMS)), whole[TERMS]]
        sizes = (abs(c) * radius**k for k, c in enumerate(terms) if k)
        spread = sum(sizes, arb(0))
        # the radius is rounded up: well inside, so that the points lie on the piece
        inside = radius * (1 - arb(2) ** -40)
        at_ends = [_polynomial(terms, t) for t in (-inside, inside)]
        at_middle = _down(terms[0])
        self.least = max(nextafter(at_middle - _up(spread), -inf), 0.0)
        # on wide pieces the direct enclosure may be the better one
        by_series = _up(abs(terms[0]) + spread)
        self.most = min(by_series, _up(whole[0]))
        self.values = [at_middle, *map(_down, at_ends)]


def _polynomial(coefficients: list[Ball], t: Ball) -> Ball:
    """The value of a polynomial with ascending coefficients, by Horner's rule."""
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
