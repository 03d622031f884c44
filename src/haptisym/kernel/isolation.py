"""All zeros of a function with Taylor coefficients in balls, on an interval: subdivision until each piece is clear."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, log

import flint
from sympy import Expr

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.stretches import Stretch
from haptisym.kernel.subdivision import Waiting
from haptisym.kernel.zeros import SmoothFactor, Undecided, Zero, is_clear, sign_of


class SeriesFactor(SmoothFactor):
    """A factor that has all its Taylor coefficients."""

    known_terms = 4

    @property
    def farthest(self) -> float | None:
        """How many times the low end of a piece its high end may be for ``over`` to have a chance; None: any number of times."""
        return None


def isolated(f: SeriesFactor, low: Ball, high: Ball) -> list[RealNumber]:
    """All zeros between two dyadic numbers: subdivision until each piece is clear, monotone or bent one way only."""
    found: list[RealNumber] = []
    waiting: Waiting[Stretch | tuple[Ball, Ball]] = Waiting(_pieces(f, low, high) if low < high else [])
    for cell in waiting:
        with flint.ctx.workprec(128):
            piece = cell if isinstance(cell, Stretch) else Stretch.of(f.series, *cell)
            answer = _judged(f, piece, len(found))
            if answer is None:
                waiting.add(*_parts(f, piece))
            else:
                found += answer
    return found


def _parts(f: SeriesFactor, piece: Stretch) -> Sequence[Stretch | tuple[Ball, Ball]]:
    """The two parts of a piece, which end where the function is not zero."""
    parts = piece.cut() if piece.is_sharp else None
    if parts:
        return parts
    middle = _cut(f, piece.low, piece.high)
    return (piece.low, middle), (middle, piece.high)


def _pieces(f: SeriesFactor, low: Ball, high: Ball) -> list[tuple[Ball, Ball]]:
    """The interval, cut beforehand where it is hopeless to judge it as a whole."""
    if f.farthest is None or not low > 0:
        return [(low, high)]
    with flint.ctx.workprec(128):
        spread = (high / low).log()
        count = max(1, ceil(float(spread.mid()) / log(f.farthest)))
        places = [(low * (spread * n / count).exp()).mid() for n in range(1, count)]
        return list(pairwise([low, *(_clear(f, x, x / 64) for x in places), high]))


def _judged(f: SeriesFactor, piece: Stretch, index: int) -> list[RealNumber] | None:
    """The zeros in a piece, if it is clear enough to tell."""
    if piece.sign():
        return []
    if piece.sign(1):
        return _between(f, piece, index)
    if bend := piece.sign(2):
        return _on_a_bend(f, piece, bend, index)
    box = piece.low.union(piece.high)
    if box.rel_accuracy_bits() > 60:
        raise UndecidedError(f"how often a function vanishes near omega = {float(box.mid()):.17g} rad/s")
    return None


def _sign(f: SeriesFactor, piece: Stretch, end: int, derivative: int = 0) -> int:
    """The sign of the function, or of its slope, at an end of a piece; UndecidedError if it stays open."""
    if shown := piece.sign_at(end, derivative):
        return shown
    x = (piece.low, piece.high)[end]
    if sign := at_rising_precision(lambda _: sign_of(f.taylor(x, derivative)) or None):
        return sign
    raise UndecidedError(f"the sign of a function at omega = {float(x.mid()):.17g} rad/s")


def _between(f: SeriesFactor, piece: Stretch, index: int) -> list[RealNumber]:
    """On a monotone piece: one zero or none."""
    return [Zero(f, *piece.nearer(), index)] if _sign(f, piece, 0) != _sign(f, piece, -1) else []


def _on_a_bend(f: SeriesFactor, piece: Stretch, bend: int, index: int) -> list[RealNumber]:
    """On a piece that bends one way only: the extremum decides between no zero and two, or stays undecided."""
    left, right = _sign(f, piece, 0), _sign(f, piece, -1)
    if left != right:
        return [Zero(f, piece.low, piece.high, index)]
    if left != bend or _sign(f, piece, 0, 1) == _sign(f, piece, -1, 1):
        return []
    extremum = Zero(f, piece.low, piece.high, index, derivative=1)

    def extreme(bits: int) -> tuple[Ball, int] | None:
        at = extremum.ball(bits)
        sign = Stretch.of(f.series, at.lower(), at.upper()).sign()
        return (at.mid(), sign) if sign else None

    found = at_rising_precision(extreme)
    if found is None:
        return [Undecided(f, extremum)]
    middle, sign = found
    return [] if sign == left else [Zero(f, piece.low, middle, index), Zero(f, middle, piece.high, index + 1)]


def _cut(f: SeriesFactor, a: Ball, b: Ball) -> Ball:
    """A dyadic number a little off the middle of a piece, at which the function is not zero."""
    with flint.ctx.workprec(128):
        return _clear(f, (a + (b - a) * 127 / 256).mid(), (b - a) / 64)


def _clear(f: SeriesFactor, place: Ball, step: Ball) -> Ball:
    """A place or one a little beside it, at which the function is not zero; the place itself where none of them shows that."""
    cuts = [(place + step * n).mid() for n in (0, 1, -3.5, 5.5)]
    return next((cut for cut in cuts if is_clear(f.value(cut))), cuts[0])


def clear_of(f: SeriesFactor, place: Expr, order: int, first: Ball, *, above: bool) -> Ball:
    """A dyadic number beside a zero of known order, with no other zero in between; one as far away as ``first`` is tried first.

    f(x) = f_m(xi) (x - place)^m with f_m the m-th Taylor coefficient about some xi in between, because all lower ones
    vanish at the place: where the enclosure of f_m over the piece is clear of 0, there is no other zero.
    """
    with flint.ctx.workprec(128):
        centre, reach = expression_ball(place), first
        for _ in range(200):
            end = (centre + (reach if above else -reach)).mid()
            if is_clear(f.taylor(centre.union(end), order)):
                return end
            reach = reach / 4
    raise UndecidedError(f"whether a function vanishes again near omega = {place} rad/s")
