"""By how much r_r and r_i differ between a scene with all of its effects and with some of them, everywhere on the band: proven.

With a and b the parts of dH it is ``| |a| - |b| |/|H_env| = min(|a - b|, |a + b|)/|H_env|``: a minimum of two smooth functions,
so that no sign has to be known. Ball arithmetic bounds them piece by piece; where it cannot (a pole of H_perc, a zero of H_env
that does not cancel, a power of omega at 0) the exact functions decide.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, nextafter

from flint import arb
from sympy import Expr

from haptisym.judge.criteria import level
from haptisym.judge.peaks import largest
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, SquareRoot
from haptisym.kernel.response import RealFunction, on_axis
from haptisym.kernel.roots import chart
from haptisym.model.distortion import part_of
from haptisym.model.jnd import Part
from haptisym.model.scene import Scene
from haptisym.programs.series import Series, series_arithmetic
from haptisym.verbs.effects.ballchain import TERMS, BallChain, BandPiece, Kept
from haptisym.verbs.effects.suprema import Supremum, supremum

_NOTHING = 1e-20  # in the middle of some pieces: then it is asked whether the functions are zero
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
        return all(_up(min(self._middle(piece), key=_up)) < _NOTHING for piece in pieces)

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
