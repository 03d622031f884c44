"""A scene along its band in ball arithmetic: on each piece of the band a power series whose coefficients are proven.

The links of the chain run in truncated series, without the zeros of H_env on the axis: a free mass at omega = 0 and a resonance
without damping, where ratios are limits, are as good as any other place. What is felt behind the first effects is
remembered, as subsets of effects share their beginnings.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from flint import acb_series, arb, arb_series
from sympy import Expr, Rational

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.shown import Shown, counted
from haptisym.model.chain import Chain
from haptisym.model.jnd import Part
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
