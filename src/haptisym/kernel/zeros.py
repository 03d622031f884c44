"""All zeros of an irreducible real function f(omega) between two frequencies, each in an enclosure.

An irreducible function, a *factor*, has simple zeros, except by coincidence: then two of them meet
in a tangency. How many zeros does it have on [a, b], and where? Let f be analytic there, and let a
*piece* be a part of [a, b] over which balls enclose f, its slope f' and its curvature f''
(``FunctionPiece``). A piece is decided where one of them has one sign all over it:

- f: no zero.
- f': f is strictly monotone, so there is one simple zero where the signs of f at both ends differ
  (intermediate value theorem), and none where they are equal.
- f'': f is strictly convex or concave. Where the signs at both ends differ there is one simple
  zero. Else there are two, on either side of the extremum, where f has the other sign at it, and
  none where it has the same one. A double zero at the extremum never shows a sign: it is given as
  ``Undecided``.

Any other piece is cut in two (``isolated``). The pieces cover [a, b] without a gap, so no zero is
missed and none is listed twice. UndecidedError is raised near a zero of order 3 or more, about
which no piece is ever decided, and at an end of a piece where f shows no sign.

A simple zero is then enclosed to any number of digits by interval Newton and bisection
(``tightened``). Source: Moore, Kearfott and Cloud, *Introduction to Interval Analysis* (SIAM 2009),
section 8.1.

Begin with ``Factor``, which says what any factor answers, then ``isolated``. A *ball* is an
interval m +- r of FLINT's. One without radius is a *dyadic* number m = n 2^k: the ends of pieces
are such, so that nothing lies between two neighbouring ones. A *place* is an exact frequency,
rational in pi. Unit of all frequencies: rad/s.
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

# Working precision of the search, and the least one of an enclosure.
_BITS = 128
# A piece whose ends agree to this many bits is not cut any more: ``FunctionPiece`` needs the rest
# of ``_BITS`` for the position of its middle.
_FINEST_BITS = 60
# A cut is tried at these multiples of a step from the number that is meant: three further ones in
# case that it is a zero, on both sides, with no pattern that zeros could share.
_CUT_OFFSETS = (0, 1, -3.5, 5.5)
# A piece beside a known zero is made shorter by a factor 4 at most this often: 4^200 is far beyond
# the working precision.
_MOST_REDUCTIONS = 200
# Roundings of the last Newton step cost some bits of an enclosure. With fewer to spare
# ``tightened`` would go on for nothing.
_SPARE_BITS = 24

Jet: TypeAlias = Callable[[Ball, int], Sequence[Ball]]
"""jet(x, n) gives the Taylor coefficients f^(k)/k!, k = 0 to n - 1, each as a ball around its
values about all points of the ball x."""


# What a factor answers.


class Factor(ABC):
    """An irreducible real function f of omega."""

    @abstractmethod
    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        """All zeros strictly between two places, and perhaps others outside; a tangency that stays
        undecided among them, as ``Undecided``."""

    @abstractmethod
    def order_at(self, place: Expr) -> Any:
        """The order of the zero at a place, counted in omega: 0 if f does not vanish there, a
        fraction for powers of omega at 0. UndecidedError where it cannot be decided."""

    @abstractmethod
    def value(self, x: Ball) -> Ball:
        """A ball around all values f(omega), omega in x, at the current working precision."""

    def steady_sign(self, low: Expr, high: Expr) -> int:
        """The sign of f, 1 or -1, all over a closed interval where a quick look proves that there
        is no zero on it; 0 where it does not, which proves nothing."""
        return 0

    def shown_sign(self, place: Expr) -> int:
        """The sign of f at a place, 1 or -1, where one evaluation shows it; 0 where it does not,
        which proves nothing."""
        return 0

    def multiplicity(self, zero: RealNumber) -> int:
        """The order of one of ``zeros``; that of a tangency that stayed undecided is taken as 2."""
        return 2 if isinstance(zero, Undecided) else 1

    def sign_at(self, ball_at: Callable[[int], Ball], most: int = MOST_BITS) -> int:
        """The sign of f, 1 or -1, at a number that is no zero; UndecidedError where ``most`` bits
        do not show it.

        ``ball_at`` : gives a ball around the number for a working precision, in bits.
        """
        tick()
        if sign := at_rising_precision(
            lambda bits: sign_of(self.value(ball_at(bits))) or None, most=most
        ):
            return sign
        raise UndecidedError(
            f"the sign of a function at omega = {float(ball_at(64).mid()):.17g} rad/s"
        )


class SmoothFactor(Factor):
    """A factor of which at least the first two Taylor coefficients, f and f', can be enclosed."""

    @abstractmethod
    def series(self, x: Ball, start: int, stop: int) -> list[Ball]:
        """Balls around the Taylor coefficients f^(k)(omega)/k!, k from ``start`` to before
        ``stop``, for all omega in the ball x."""

    def taylor(self, x: Ball, order: int) -> Ball:
        """A ball around the Taylor coefficients f^(k)(omega)/k!, k = ``order``, for all omega in
        the ball x."""
        return self.series(x, order, order + 1)[0]


class SeriesFactor(SmoothFactor):
    """A factor of which Taylor coefficients of all orders can be enclosed, for omega > 0 at
    least."""

    @property
    def largest_ratio(self) -> float | None:
        """The largest ratio high/low of the ends of a piece over which the enclosures are of use;
        None where they are over any piece."""
        return None


# The values that are found.


@dataclass(frozen=True, repr=False)
class Zero(RealNumber):
    """A simple zero of a factor, alone between the dyadic numbers ``low`` and ``high``, where the
    signs differ.

    ``derivative`` : 0 for a zero of f itself, 1 for one of its slope. ``index`` : the number of
    zeros of f below it in the interval of the search. Two zeros are equal where factor, index and
    derivative are, whatever the enclosures: so ``==`` is for zeros of one search alone. Those of
    two searches are compared by their balls (``kernel.reals.ordered``), and enclosures are cached
    with their ends.
    """

    factor: SmoothFactor
    low: Ball = field(compare=False)
    high: Ball = field(compare=False)
    index: int = 0
    derivative: int = 0

    def ball(self, bits: int) -> Ball:
        return _refined(self, self.low, self.high, rounded_up(bits))

    def rough(self) -> Ball:
        return self.low.union(self.high)


@dataclass(frozen=True, repr=False)
class Undecided(RealNumber):
    """A frequency near which a factor has a double zero, or two simple ones, or none: not decided
    at the precision limit. ``near`` : the zero of the slope at which it is the question."""

    factor: Factor
    near: Zero

    def ball(self, bits: int) -> Ball:
        return self.near.ball(bits)


# The search.


def isolated(f: SeriesFactor, low: Ball, high: Ball) -> list[RealNumber]:
    """All zeros of a factor between two dyadic numbers, ascending, by subdivision.

    f must not vanish at the two numbers themselves. Each entry is a ``Zero``, or ``Undecided`` for
    a tangency. UndecidedError as the module says.
    """
    zeros: list[RealNumber] = []
    # Pieces come in ascending order, also those of a cut: so the zeros that are listed already are
    # those below, and their number is the index of the next.
    waiting = Waiting(_pieces(f, low, high) if low < high else [])
    for a, b in waiting:
        with flint.ctx.workprec(_BITS):
            piece = FunctionPiece.of(f.series, a, b)
            in_piece = _zeros_in(f, piece, len(zeros))
            if in_piece is not None:
                zeros += in_piece
                continue
            # A little off the middle, as zeros are often at round numbers: at a zero no piece
            # could show the sign of its end.
            off_middle = a + (b - a) * 127 / 256
            cut = _cut_near(f, off_middle.mid(), (b - a) / 64)
            waiting.add((a, cut), (cut, b))
    return zeros


def _pieces(f: SeriesFactor, low: Ball, high: Ball) -> list[tuple[Ball, Ball]]:
    """The pieces to begin with: few, and none with a larger ratio of its ends than is of use."""
    if f.largest_ratio is None or not low > 0:
        return [(low, high)]
    with flint.ctx.workprec(_BITS):
        # In equal ratios. Cut at equal distances, the first piece would keep nearly all of the
        # ratio.
        spread = (high / low).log()
        count = max(1, ceil(float(spread.mid()) / log(f.largest_ratio)))
        cuts: list[Ball] = []
        for n in range(1, count):
            x = (low * (spread * n / count).exp()).mid()
            cuts.append(_cut_near(f, x, x / 64))
        return list(pairwise([low, *cuts, high]))


def _cut_near(f: SeriesFactor, x: Ball, step: Ball) -> Ball:
    """A dyadic number at or a little beside x at which f is shown not to vanish; x itself where
    that is shown at none of four, so that nothing is proven."""
    cuts = [(x + step * n).mid() for n in _CUT_OFFSETS]
    for cut in cuts:
        if is_clear(f.value(cut)):
            return cut
    return cuts[0]


def _zeros_in(f: SeriesFactor, piece: FunctionPiece, index: int) -> list[RealNumber] | None:
    """The zeros in a piece; None where it must be cut. UndecidedError where it is too short for
    that. ``index`` : the number of zeros below it."""
    if piece.sign():
        return []
    if piece.sign(1):
        is_crossing = _end_sign(f, piece, 0) != _end_sign(f, piece, -1)
        return [Zero(f, piece.low, piece.high, index)] if is_crossing else []
    if curvature := piece.sign(2):
        return _zeros_of_convex(f, piece, curvature, index)
    whole = piece.low.union(piece.high)
    if whole.rel_accuracy_bits() > _FINEST_BITS:
        raise UndecidedError(
            f"how often a function vanishes near omega = {float(whole.mid()):.17g} rad/s"
        )
    return None


def _zeros_of_convex(
    f: SeriesFactor, piece: FunctionPiece, curvature: int, index: int
) -> list[RealNumber]:
    """The zeros in a piece all over which f'' has the sign ``curvature``: none, one, two, or one
    ``Undecided`` where the extremum cannot be distinguished from 0."""
    left, right = _end_sign(f, piece, 0), _end_sign(f, piece, -1)
    if left != right:
        return [Zero(f, piece.low, piece.high, index)]
    # f is convex and negative at both ends, or concave and positive: below (above) its chord.
    if left != curvature:
        return []
    # The slope changes its sign nowhere, as it is monotone: so is f.
    if _end_sign(f, piece, 0, 1) == _end_sign(f, piece, -1, 1):
        return []
    extremum = Zero(f, piece.low, piece.high, index, derivative=1)

    def sign_at_extremum(bits: int) -> tuple[Ball, int] | None:
        ball = extremum.ball(bits)
        sign = FunctionPiece.of(f.series, ball.lower(), ball.upper()).sign()
        return (ball.mid(), sign) if sign else None

    shown = at_rising_precision(sign_at_extremum)
    if shown is None:
        return [Undecided(f, extremum)]
    middle, sign = shown
    if sign == left:
        return []
    first = Zero(f, piece.low, middle, index)
    return [first, Zero(f, middle, piece.high, index + 1)]


def _end_sign(f: SeriesFactor, piece: FunctionPiece, end: int, derivative: int = 0) -> int:
    """The sign, 1 or -1, of f (derivative 0) or f' (1) at an end of a piece: the low one for
    ``end`` 0, the high one for -1, as the index of a sequence. UndecidedError where no precision up
    to ``MOST_BITS`` shows it."""
    if shown := piece.sign_at(end, derivative):
        return shown
    x = (piece.low, piece.high)[end]
    # The end is the same at any precision, which is that of the arithmetic (``flint.ctx``).
    if sign := at_rising_precision(lambda _: sign_of(f.taylor(x, derivative)) or None):
        return sign
    raise UndecidedError(f"the sign of a function at omega = {float(x.mid()):.17g} rad/s")


def clear_of(f: SeriesFactor, place: Expr, order: int, first: Ball, *, above: bool) -> Ball:
    """A dyadic number beside a place where f has a zero of known order m, without any other zero
    from the place up (or, not ``above``, down) to that number, which is included.

    ``first`` : the distance that is tried first, > 0; then a quarter of it, and so on.
    UndecidedError where none will do.

    Proof: by Taylor's theorem f(x) = f_m(xi) (x - place)^m for some xi between place and x, where
    f_m = f^(m)/m!, as all lower coefficients vanish at the place. The ball over which f_m is
    enclosed holds the place and the number itself, as it was rounded. So where the enclosure does
    not contain 0, x = place is the only zero in between. If the distance is below the rounding to
    128 bits, the number may be the place itself, or on its other side: but it is in the ball, and
    by the same formula the place is the only zero in all of the ball.
    """
    with flint.ctx.workprec(_BITS):
        centre, distance = expression_ball(place), first
        for _ in range(_MOST_REDUCTIONS):
            end = (centre + (distance if above else -distance)).mid()
            if is_clear(f.taylor(centre.union(end), order)):
                return end
            distance = distance / 4
    raise UndecidedError(f"whether a function vanishes again near omega = {place} rad/s")


# Enclosures of one simple zero.


@lru_cache(maxsize=4096)
def _refined(zero: Zero, low: Ball, high: Ball, bits: int) -> Ball:
    """The enclosure of a zero between ``low`` and ``high``, as tight as that many bits allow. It is
    cached, and starts from the one with half as many bits."""
    k = zero.derivative

    def jet(x: Ball, count: int) -> Sequence[Ball]:
        row = zero.factor.series(x, k, k + count)
        if not k:
            return row
        # With c_n = f^(n)/n!, the Taylor coefficients of f^(k)/k! are binomial(k + n, k) c_(k+n).
        return [c * comb(k + n, k) for n, c in enumerate(row)]

    with flint.ctx.workprec(bits):
        if bits > _BITS:
            rough = _refined(zero, low, high, bits // 2)
            closer = low.max(rough.lower()), high.min(rough.upper())
            # An end so near to the zero that its sign does not show would stop bisection.
            if all(is_clear(jet(x, 1)[0]) for x in closer):
                low, high = closer
        return tightened(low, high, bits, jet)


def tightened(low: Ball, high: Ball, bits: int, jet: Jet) -> Ball:
    """The enclosure of the one simple zero of f between two dyadic numbers, as tight as that many
    bits allow; wider where the working precision shows no more.

    Interval Newton: by the mean value theorem the zero lies in m - f(m)/f'(X), where X is the piece
    and m its middle, if f'(X) does not contain 0. Where that does not halve the piece it is
    bisected. The ends stay dyadic numbers: a ball around them reaches a little beyond, where a
    neighbouring zero may lie.
    """
    low_sign = sign_of(jet(low, 1)[0])
    while low.union(high).rel_accuracy_bits() < bits - _SPARE_BITS:
        tick()
        length = high - low
        middle = ((low + high) / 2).mid()
        value = jet(middle, 1)[0]
        slope = jet(low.union(high), 2)[1]
        if is_clear(slope):
            newton = middle - value / slope
            low, high = low.max(newton.lower()), high.min(newton.upper())
        if high - low < length / 2:
            continue
        if not low_sign or not is_clear(value):
            break  # the working precision shows no more
        if sign_of(value) == low_sign:
            low = low.max(middle)
        else:
            high = high.min(middle)
    return low.union(high)


# Balls, signs, dyadic numbers.


def sign_of(ball: Ball) -> int:
    """1 or -1 for a ball on one side of 0; 0 for one that contains 0, or is not a number, such as a
    logarithm over 0.

    >>> sign_of(arb("-1.5")), sign_of(arb(1, 2)), sign_of(arb("nan"))
    (-1, 0, 0)
    """
    return int(ball > 0) - int(ball < 0)


def is_clear(ball: Ball) -> bool:
    """Whether a ball lies on one side of 0: then nothing in it is 0."""
    return sign_of(ball) != 0


@lru_cache(maxsize=16)
def dyadic_ends(low: Expr, high: Expr) -> tuple[Ball, Ball]:
    """Two dyadic numbers between which an interval with exact ends lies: it is rounded outward."""
    with flint.ctx.workprec(_BITS):
        return expression_ball(low).lower(), expression_ball(high).upper()


def dyadic_ball(x: fmpq) -> Ball:
    """A dyadic number, given as a fraction, as a ball without radius."""
    with flint.ctx.workprec(max(_BITS, int(x.p).bit_length())):
        return arb(x)


def rounded_up(bits: int) -> int:
    """The next power of two, at least 128, so that questions of about the same precision share one
    cached enclosure."""
    return max(_BITS, 1 << (bits - 1).bit_length())
