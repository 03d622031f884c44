"""Irreducible real functions of omega (factors): all zeros in an interval, exact orders, signs.

A real function is taken apart into irreducible factors. Different factors vanish at different
frequencies (for polynomials always, for analytic functions except by coincidence) and each has only
simple zeros or such tangencies as cannot be told from simple pairs. A factor knows all its zeros in
an interval, its order at a given number, and its sign.

What has Taylor coefficients in balls is cut until each piece of the interval is clear: without a
zero, or with one simple zero.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from math import ceil, comb, log
from typing import Any, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Expr

from haptisym.kernel.budget import Waiting, tick
from haptisym.kernel.enclosures import FunctionPiece
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import MOST_BITS, Ball, RealNumber, at_rising_precision, expression_ball


def rounded_up(bits: int) -> int:
    """The next power of two, at least 128, so that questions of about the same precision share one
    cached enclosure."""
    return max(128, 1 << (bits - 1).bit_length())


@lru_cache(maxsize=16)
def around(low: Expr, high: Expr) -> tuple[Ball, Ball]:
    """Two dyadic numbers between which an interval with exact ends lies."""
    with flint.ctx.workprec(128):
        return expression_ball(low).lower(), expression_ball(high).upper()


def exact(x: fmpq) -> Ball:
    """A dyadic number as a ball without radius."""
    with flint.ctx.workprec(max(128, int(x.p).bit_length())):
        return arb(x)


def sign_of(ball: Ball) -> int:
    """1 or -1 for a ball on one side of 0; 0 for one that holds it, or is not a number, as a
    logarithm over 0.

    >>> sign_of(arb("-1.5")), sign_of(arb(1, 2)), sign_of(arb("nan"))
    (-1, 0, 0)
    """
    return int(ball > 0) - int(ball < 0)


def is_clear(ball: Ball) -> bool:
    """Whether a ball lies on one side of 0."""
    return sign_of(ball) != 0


class Factor(ABC):
    """An irreducible real function of omega."""

    @abstractmethod
    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        """All zeros strictly between two numbers, and perhaps others outside; a tangency that stays
        undecided among them."""

    @abstractmethod
    def order_at(self, place: Expr) -> Any:
        """The order of the zero at an exact number, counted in omega; 0 if it is none; a fraction
        for powers of omega at 0."""

    @abstractmethod
    def value(self, x: Ball) -> Ball:
        """A ball around the value at a ball of frequencies, at the current working precision."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        """The sign all over a closed interval where a quick look shows that there is no zero on it;
        0 where it does not."""
        return 0

    def shown_sign(self, place: Expr) -> int:
        """The sign at an exact number where one evaluation shows it, else 0."""
        return 0

    def multiplicity(self, zero: RealNumber) -> int:
        """The order of one of the zeros; that of a tangency that stayed undecided is taken as 2."""
        return 2 if isinstance(zero, Undecided) else 1

    def sign_at(self, place: Callable[[int], Ball], most: int = MOST_BITS) -> int:
        """The sign at a number that is no zero, given as a function from bits to a ball;
        UndecidedError at the limit."""
        tick()
        if sign := at_rising_precision(
            lambda bits: sign_of(self.value(place(bits))) or None, most=most
        ):
            return sign
        raise UndecidedError(
            f"the sign of a function at omega = {float(place(64).mid()):.17g} rad/s"
        )


class SmoothFactor(Factor):
    """A factor whose Taylor coefficients are known."""

    @abstractmethod
    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients of orders from ``start`` to before ``stop`` about
        every point of a ball."""

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficient of that order about every point of a ball of
        frequencies."""
        return self.series(x, order, order + 1)[0]


@dataclass(frozen=True, repr=False)
class Zero(RealNumber):
    """A simple zero of a factor, alone between ``low`` and ``high``, where the signs differ."""

    factor: SmoothFactor
    low: Ball = field(compare=False)
    high: Ball = field(compare=False)
    index: int = 0
    derivative: int = 0
    """0 for a zero of the function itself, 1 for one of its slope."""

    def ball(self, bits: int) -> Ball:
        return _refined(self, self.low, self.high, rounded_up(bits))

    def rough(self) -> Ball:
        return self.low.union(self.high)


@dataclass(frozen=True, repr=False)
class Undecided(RealNumber):
    """A frequency near which a function has a double zero, or two, or none: not decided at the
    precision limit."""

    factor: Factor
    near: Zero

    def ball(self, bits: int) -> Ball:
        return self.near.ball(bits)


@lru_cache(maxsize=4096)
def _refined(zero: Zero, low: Ball, high: Ball, bits: int) -> Ball:
    """The enclosure of a zero, cached, as tight as that many bits allow; it starts from the one
    with half as many bits."""
    k = zero.derivative

    def jet(x: Ball, count: int) -> Sequence[Ball]:
        # Taylor coefficients of the k-th derivative over k!: binomials of those of the function.
        row = zero.factor.series(x, k, k + count)
        return [c * comb(k + n, k) for n, c in enumerate(row)] if k else row

    with flint.ctx.workprec(bits):
        if bits > 128:
            rough = _refined(zero, low, high, bits // 2)
            closer = low.max(rough.lower()), high.min(rough.upper())
            # An end so near to the zero that its sign does not show would stop bisection.
            if all(is_clear(jet(x, 1)[0]) for x in closer):
                low, high = closer
        return tightened(low, high, bits, jet)


Jet: TypeAlias = Callable[[Ball, int], Sequence[Ball]]
"""jet(x, n) gives the first n Taylor coefficients of a function about every point of a ball x."""


def tightened(low: Ball, high: Ball, bits: int, jet: Jet) -> Ball:
    """The enclosure of the one simple zero between two exact numbers, as tight as that many bits
    allow.

    Interval Newton where the slope is clear of 0, bisection elsewhere.
    The ends stay exact numbers: a ball around them reaches a little beyond, where a twin of the
    zero may lie.
    """
    left = sign_of(jet(low, 1)[0])
    while low.union(high).rel_accuracy_bits() < bits - 24:
        tick()
        before, middle = high - low, ((low + high) / 2).mid()
        at, steep = jet(middle, 1)[0], jet(low.union(high), 2)[1]
        # By the mean value theorem the zero lies in m - f(m)/f'(X). Where that did not halve the
        # piece, its half is taken at whose ends the signs differ.
        if is_clear(steep):
            step = middle - at / steep
            low, high = low.max(step.lower()), high.min(step.upper())
        if high - low < before / 2:
            continue
        if not left or not is_clear(at):
            break  # the working precision shows no more
        low, high = (low.max(middle), high) if sign_of(at) == left else (low, high.min(middle))
    return low.union(high)


class SeriesFactor(SmoothFactor):
    """A factor that has Taylor coefficients of all orders."""

    @property
    def farthest(self) -> float | None:
        """The largest ratio of the ends of a piece for which Taylor's theorem can give a useful
        enclosure; None where any ratio will do."""
        return None


def isolated(f: SeriesFactor, low: Ball, high: Ball) -> list[RealNumber]:
    """All zeros between two dyadic numbers, ascending: subdivision until on each piece the sign,
    the slope's sign or the curvature's sign is constant."""
    zeros: list[RealNumber] = []
    waiting = Waiting(_pieces(f, low, high) if low < high else [])
    for a, b in waiting:
        with flint.ctx.workprec(128):
            in_piece = _judged(f, FunctionPiece.of(f.series, a, b), len(zeros))
            if in_piece is None:
                # A little off the middle, as zeros are often at round numbers: at a zero no piece
                # could show the sign of its end.
                middle = _clear(f, (a + (b - a) * 127 / 256).mid(), (b - a) / 64)
                waiting.add((a, middle), (middle, b))
            else:
                zeros += in_piece
    return zeros


def _pieces(f: SeriesFactor, low: Ball, high: Ball) -> list[tuple[Ball, Ball]]:
    """The interval in pieces, each with a ratio of its ends for which an enclosure is of use."""
    if f.farthest is None or not low > 0:
        return [(low, high)]
    with flint.ctx.workprec(128):
        # In equal ratios: cut at equal distances, the first piece would keep nearly all of the ratio.
        spread = (high / low).log()
        count = max(1, ceil(float(spread.mid()) / log(f.farthest)))
        places = [(low * (spread * n / count).exp()).mid() for n in range(1, count)]
        return list(pairwise([low, *(_clear(f, x, x / 64) for x in places), high]))


def _judged(f: SeriesFactor, piece: FunctionPiece, index: int) -> list[RealNumber] | None:
    """The zeros in a piece; None where it must be cut. UndecidedError for one that is too short to
    be cut. ``index`` : the number of zeros below it."""
    if piece.sign():
        return []
    # Monotone: one simple zero or none, by the signs at the ends.
    if piece.sign(1):
        is_crossing = _sign(f, piece, 0) != _sign(f, piece, -1)
        return [Zero(f, piece.low, piece.high, index)] if is_crossing else []
    if bend := piece.sign(2):
        return _on_a_bend(f, piece, bend, index)
    box = piece.low.union(piece.high)
    if box.rel_accuracy_bits() > 60:
        raise UndecidedError(
            f"how often a function vanishes near omega = {float(box.mid()):.17g} rad/s"
        )
    return None


def _sign(f: SeriesFactor, piece: FunctionPiece, end: int, derivative: int = 0) -> int:
    """The sign of the function, or of its slope, at an end of a piece; UndecidedError if it stays
    open."""
    if shown := piece.sign_at(end, derivative):
        return shown
    x = (piece.low, piece.high)[end]
    if sign := at_rising_precision(lambda _: sign_of(f.taylor(x, derivative)) or None):
        return sign
    raise UndecidedError(f"the sign of a function at omega = {float(x.mid()):.17g} rad/s")


def _on_a_bend(f: SeriesFactor, piece: FunctionPiece, bend: int, index: int) -> list[RealNumber]:
    """The zeros in a piece whose curvature has the sign ``bend`` all over it: none, one, or two; or
    one ``Undecided``, where the value at the extremum cannot be distinguished from 0."""
    left, right = _sign(f, piece, 0), _sign(f, piece, -1)
    if left != right:
        return [Zero(f, piece.low, piece.high, index)]
    # Convex and negative at both ends, or concave and positive, or monotone: no zero in between.
    if left != bend or _sign(f, piece, 0, 1) == _sign(f, piece, -1, 1):
        return []
    extremum = Zero(f, piece.low, piece.high, index, derivative=1)

    def extreme(bits: int) -> tuple[Ball, int] | None:
        at = extremum.ball(bits)
        sign = FunctionPiece.of(f.series, at.lower(), at.upper()).sign()
        return (at.mid(), sign) if sign else None

    # A double zero never shows a sign: no precision proves that the extremum is exactly 0.
    shown = at_rising_precision(extreme)
    if shown is None:
        return [Undecided(f, extremum)]
    middle, sign = shown
    if sign == left:
        return []
    return [Zero(f, piece.low, middle, index), Zero(f, middle, piece.high, index + 1)]


def _clear(f: SeriesFactor, place: Ball, step: Ball) -> Ball:
    """A number at or a little beside ``place`` at which the function is shown not to vanish;
    ``place`` itself where none of four is."""
    cuts = [(place + step * n).mid() for n in (0, 1, -3.5, 5.5)]
    return next((cut for cut in cuts if is_clear(f.value(cut))), cuts[0])


def clear_of(f: SeriesFactor, place: Expr, order: int, first: Ball, *, above: bool) -> Ball:
    """A dyadic number beside a zero of known order, with no other zero in between; one as far away
    as ``first`` is tried first.

    f(x) = f_m(xi) (x - place)^m with f_m the m-th Taylor coefficient about some xi in between,
    because all lower ones vanish at the place: where the enclosure of f_m over the piece is clear
    of 0, there is no other zero.
    """
    with flint.ctx.workprec(128):
        centre, reach = expression_ball(place), first
        for _ in range(200):
            end = (centre + (reach if above else -reach)).mid()
            if is_clear(f.taylor(centre.union(end), order)):
                return end
            reach = reach / 4
    raise UndecidedError(f"whether a function vanishes again near omega = {place} rad/s")
