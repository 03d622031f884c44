"""A sampled loop whose delay is the open parameter: all delays that put a root on the unit circle.

A delay is d whole samples and a rest theta, 0 <= theta < T, and the loop is z^d Q(z) + N(z; theta)
= 0. On the circle, z = exp(j omega T), that asks for log(-N/Q) = j (omega d T - 2 pi k) for some
whole k. The real part, |N| = |Q|, does not depend on d: it holds on a few curves omega(theta).
Boxes of omega and theta are cut until none is there, or just one omega for each theta
(``curves``). Along a curve the imaginary part tells at which delays, however many samples these
are: for each k interval Newton in balls closes in on them (``Turn``). Which way a root then goes is
the sign of a derivative, so that one exact count tells the number for all other delays
(``Lateness``, where to begin).

All that is returned is proven. UndecidedError, or ``left``, for what is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache
from heapq import heapify, heapreplace
from math import inf, nextafter
from typing import NamedTuple, TypeAlias

import flint
from flint import acb, acb_poly, arb, arb_poly
from sympy import Expr, Rational

from haptisym.kernel.budget import Waiting, tick
from haptisym.kernel.enclosures import over_ellipse
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    at_rising_precision,
    bounds,
    expression_ball,
    fraction_ball,
    ordered,
    rational,
)
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.stability.characteristic import Pair
from haptisym.verbs.stability.opened import Opened, Passage, Span

_BITS, _MOST_BITS = 128, 1 << 10
_MOST_BOXES, _DEEPEST, _MOST_STEPS = 1200, 200, 8
_MOST_PASSAGES = 64
# A piece of a curve whose delays after k turns spread over more samples is too wide to be followed.
_MANY = 8
# The next float above pi: up to the Nyquist frequency, and rather a little more.
_PI = 3.1415926535897936
_ROUNDING = 2.0**-50
# How many times narrower than its frequency a piece of a curve is to be.
_NARROW = 32

Box: TypeAlias = tuple[Ball, Ball]
Sides: TypeAlias = tuple[float, float]


class Log(NamedTuple):
    """log(-N/Q): its value in the ``middle`` of a box, and its slopes ``along`` omega and with
    theta, ``later``, all over the box."""

    middle: acb
    along: acb
    later: acb


@dataclass(frozen=True, eq=False)
class AngleCurve:
    """A piece of a curve on which |N| = |Q|: at most one omega for each theta in a ``box`` of both.

    ``piece`` : the rests theta for which N is the loop's, s; the box may reach beyond them.
    ``turn`` : the angle of -N/Q plus omega theta, all over the box: the phase by which a delay of
    turn/omega, and of each whole turn more, puts a root on the circle.
    """

    loop: Opened
    piece: tuple[Fraction, Fraction]
    box: Box
    turn: Ball

    def delays(self, k: int) -> Ball:
        """The delays, s, at which a root is on the circle after k whole turns, all over the box."""
        return (self.turn + 2 * k * arb.pi()) / self.box[0]

    def log(self, omega: Ball, theta: Ball) -> Log | None:
        """log(-N/Q) in a part of the box, on the branch of the curve's angle; None where it has no
        bounds."""
        log = log_of(self.loop, omega, theta)[1]
        if log is None:
            return None
        turn = log.middle.imag + omega.mid() * theta.mid()
        # The curve's turn is known to less than half of one: rounding finds the branch.
        whole = round(float((self.turn.mid() - turn.mid()) / (2 * arb.pi())))
        return log._replace(middle=log.middle + acb(0, 2 * whole * arb.pi()))


@lru_cache(maxsize=512)
def _sides(loop: Opened, middle: Ball, radius: Ball, bits: int) -> list[arb_poly]:
    """Polynomials in z - 1: N at the middle theta; two of which N, all over, is the first give or
    take the second; its slope along theta; and Q."""
    # The working precision is part of what is asked, so that the cache does not give away coarser
    # balls.
    assert bits == flint.ctx.prec

    def numerator(theta: Ball) -> list[Ball]:
        coefficients: list[Ball] = loop.loop.sides({loop.symbol: theta})[0].coeffs()
        return coefficients

    lines = over_ellipse(numerator, middle, radius)
    N, Q = loop.loop.sides({loop.symbol: middle})
    # At z = 1 a delay changes nothing: the value there is exact, with no width and no slope.
    start = (N[0], arb(0), arb(0))
    columns = zip(start, *lines[1:], strict=True)
    at, more, rates = (arb_poly(list(column)) for column in columns)
    return [N, at, more, rates * (1 / radius), Q]


def log_of(loop: Opened, omega: Ball, theta: Ball) -> tuple[bool, Log | None]:
    """Whether no root is on the circle in a box, as |N| and |Q| differ; and log(-N/Q), None where
    that has no bounds."""
    T, bits = expression_ball(loop.loop.T), flint.ctx.prec
    # z - 1 = exp(j angle) - 1 without cancellation at low frequencies.
    # The middle is that of omega, times T with its radius: interval Newton steps from there.
    x, middle = (
        acb(-2 * (angle / 2).sin() ** 2, angle.sin()) for angle in (omega * T, omega.mid() * T)
    )
    # The slope is a difference over the radius: of a shorter one it would have fewer digits.
    radius = theta.rad().max(T.lower() * arb(2) ** (-bits // 4)).mid()
    # Shifted to the middle: powers of a wide ball, and balls that cancel far from 0, grow faster
    # than the range of what they enclose.
    parts = [acb_poly(p)(acb_poly([middle, 1])) for p in _sides(loop, theta.mid(), radius, bits)]
    here, at, more, slope, below = (p(x - middle) for p in parts)
    above = at + more * arb(0, 1)
    if not abs(above).overlaps(abs(below)):
        return True, None
    if above.contains(0) or below.contains(0):
        return False, None
    there = -parts[0][0] / parts[-1][0]
    # Away from the cut of the logarithm, along the negative numbers, where a ball would hold both
    # ends.
    log = there.log() if not there.real < 0 else (-there).log() + acb(0, arb.pi())
    rises, risen, rising, falls = (parts[i].derivative()(x - middle) for i in (0, 1, 3, 4))
    risen += parts[2].derivative()(x - middle) * arb(0, 1)
    # The slope rises/here is that at the middle theta; by the mean value theorem in theta it
    # changes by no more than its own slope along theta, (rising - risen slope/above)/above, times
    # the way from there.
    along = rises / here - falls / below + (rising - risen * slope / above) / above * _off(theta)
    return False, Log(log, acb(0, 1) * (1 + x) * T * along, slope / above)


def _off(x: Ball) -> Ball:
    """The ball about 0 that is as wide as another: how far a point may be off the middle."""
    return x - x.mid()


def curves(
    loop: Opened, piece: tuple[Fraction, Fraction], most: Fraction
) -> tuple[list[AngleCurve], bool]:
    """All pieces of curves for rests theta in a ``piece``, s, but those with roots on the circle at
    delays beyond ``most`` alone; and whether there may be any of these.

    UndecidedError where a box is neither clear nor holds one piece.
    """
    start, end = piece
    found, is_cut_off = list[AngleCurve](), False
    with flint.ctx.workprec(_BITS):
        highest = float(arb(_PI) / expression_ball(loop.loop.T).lower())
        first = (0.0, highest), (nextafter(float(start), -inf), nextafter(float(end), inf))
        waiting = Waiting([first], most=_MOST_BOXES, what="boxes of frequency")
        for frequencies, delays in waiting:
            box = _ball(*frequencies), _ball(*delays)
            clear, log = log_of(loop, *box)
            if clear:
                continue
            if log and _is_later(_turn(log, *box), box[0], most):
                is_cut_off = True
                continue
            curve = _followed(loop, piece, box, log) if log else box
            if isinstance(curve, AngleCurve):
                found.append(curve)
            elif curve is not None:
                # Cut along theta where the box is wider there, relative to the whole, than four
                # times along omega.
                width = (delays[1] - delays[0]) / float(end - start)
                is_wide = 4 * (frequencies[1] - frequencies[0]) < width * frequencies[1]
                waiting.add(*_halves(frequencies, delays, int(is_wide)))
        if waiting.rest:
            raise UndecidedError("at which frequencies the loop has a gain of 1")
    return found, is_cut_off


def _ball(low: float, high: float) -> Ball:
    return arb(low).union(arb(high))


def _halves(frequencies: Sides, delays: Sides, cut: int) -> list[tuple[Sides, Sides]]:
    """A box cut in two, along omega (0) or along theta (1)."""
    low, high = (frequencies, delays)[cut]
    middle = (low + high) / 2
    if cut:
        return [(frequencies, (low, middle)), (frequencies, (middle, high))]
    return [((low, middle), delays), ((middle, high), delays)]


def _turn(log: Log, omega: Ball, theta: Ball) -> Ball:
    """The angle of -N/Q plus omega theta, all over a box, by the mean value theorem."""
    middle = log.middle.imag + omega.mid() * theta.mid()
    return middle + (log.along.imag + theta) * _off(omega) + (log.later.imag + omega) * _off(theta)


def _is_later(phase: Ball, omega: Ball, most: Fraction) -> bool:
    """Whether a box has roots on the circle at delays beyond ``most`` alone, as a low frequency
    takes long for a turn. ``phase`` : as of ``AngleCurve``."""
    if not phase.rad() < 1:
        return False
    # The first turn that is not below 0; the one before it is, so that no delay is missed.
    first = phase + 2 * arb.pi() * (-phase / (2 * arb.pi())).upper().ceil()
    return bool(first - 2 * arb.pi() < 0 and first > omega.upper() * fraction_ball(most))


def _followed(
    loop: Opened, piece: tuple[Fraction, Fraction], box: Box, log: Log | None
) -> AngleCurve | Box | None:
    """The piece of a curve in a box; None where there is none; a box where neither is shown.

    Interval Newton for Re log(-N/Q) = 0 in omega, for all theta of the box at once: as the slope is
    not 0 there is at most one omega for each.
    """
    omega, theta = box
    while log is not None and not log.along.real.contains(0):
        near = omega.mid() - (log.middle.real + log.later.real * _off(theta)) / log.along.real
        if not near.overlaps(omega):
            return None
        before, omega = omega, omega.intersection(near)
        # It shrinks no further: what is left is how far omega goes along the curve itself.
        if 4 * omega.rad() > 3 * before.rad():
            turn = _turn(log, before, theta)
            is_narrow = turn.rad() < 1 and _NARROW * omega.rad() < omega.mid()
            return AngleCurve(loop, piece, (omega, theta), turn) if is_narrow else box
        clear, log = log_of(loop, omega, theta)
        if clear:
            return None
    return box


@dataclass(frozen=True, eq=False)
class Turn:
    """The equation log(-N/Q) = j (omega d T - 2 pi k) on a curve, for d = ``samples`` and one k: in
    the unknowns omega and delay, s. ``pairs`` are its solutions."""

    curve: AngleCurve
    samples: int
    k: int

    @cached_property
    def whole(self) -> Expr:
        """The whole samples, s."""
        return self.samples * self.curve.loop.loop.T

    def step(self, omega: Ball, delay: Ball) -> Box | None:
        """The step of interval Newton: a box that holds all solutions of a box; None where it has
        no bounds."""
        whole = expression_ball(self.whole)
        # Newton is in omega and theta: log.middle is exactly there, whatever the radius of T.
        theta = delay - whole
        log = self.curve.log(omega, theta)
        if log is None:
            return None
        off = log.middle - acb(0, omega.mid() * whole - 2 * self.k * arb.pi())
        a, b, c, d = log.along.real, log.later.real, log.along.imag - whole, log.later.imag
        determinant = a * d - b * c
        if determinant.contains(0):
            return None
        return (
            omega.mid() - (d * off.real - b * off.imag) / determinant,
            whole + (theta.mid() - (a * off.imag - c * off.real) / determinant),
        )

    def pairs(self) -> Iterator[Pair]:
        """All solutions in the curve's box whose rest is in its piece. One that is at the edge of
        two parts of the box may come twice. UndecidedError where that is not settled, as at a
        double one."""
        omega, theta = self.curve.box
        delay, delays = theta + expression_ball(self.whole), self.curve.delays(self.k)
        if not delay.overlaps(delays):
            return
        waiting = Waiting([(omega, delay.intersection(delays))], most=_DEEPEST)
        for box in waiting:
            found = self._closed(*box)
            if isinstance(found, Pair):
                if self._is_in_piece(found):
                    yield found
            elif found is not None:
                omega, delay = found
                middle = delay.mid()
                waiting.add(
                    (omega, delay.lower().union(middle)), (omega, middle.union(delay.upper()))
                )
        if waiting.rest:
            raise UndecidedError("whether a root comes to the unit circle and goes back")

    def _is_in_piece(self, pair: Pair) -> bool:
        """Whether a solution is not proven to be outside of the piece: there another N is the
        loop's."""
        start, end = (ExactNumber(self.whole + rational(x)) for x in self.curve.piece)
        return ordered(pair.value, start) <= 0 <= ordered(pair.value, end)

    def _closed(self, omega: Ball, delay: Ball) -> Pair | Box | None:
        """The one solution in a box, None where there is none, or the smaller box that is left."""
        for _ in range(_MOST_STEPS):
            after = self.step(omega, delay)
            if after is None:
                break
            if not (omega.overlaps(after[0]) and delay.overlaps(after[1])):
                return None
            if omega.contains_interior(after[0]) and delay.contains_interior(after[1]):
                return Pair(self, *after)
            omega, delay = omega.intersection(after[0]), delay.intersection(after[1])
        return omega, delay

    def sense(self, pair: Pair) -> int:
        """1 if the root leaves the unit circle outward as the delay grows, -1 if inward.

        UndecidedError where balls do not tell.
        """
        found = at_rising_precision(lambda bits: self._sense(*pair.at(bits)), _BITS, _MOST_BITS)
        if found is None:
            raise UndecidedError("which way a root goes on the unit circle")
        return found

    def _sense(self, omega: Ball, delay: Ball) -> int | None:
        log = self.curve.log(omega, delay - expression_ball(self.whole))
        if log is None:
            return None
        # With L = log(-N/Q) the root obeys d log z = L, and L changes with log z = j omega T by
        # L_omega/(j T): so d(log z)/d theta = L_theta/(d + j L_omega/T), of which the real part is
        # the growth of log |z|.
        late = self.samples + acb(0, 1) * log.along / expression_ball(self.curve.loop.loop.T)
        return sign_of((log.later / late).real) or None


@dataclass(eq=False)
class Lateness:
    """The critical delays of a loop: those ``found`` by now, and up to which delay, ``frontier``,
    they are all (None: everywhere).

    ``own`` : the delay that the scene has. ``most`` : the delay up to which ``curves`` have all
    roots on the circle (None: at all delays). ``senses`` : how many roots more are outside of the
    circle beyond each delay. ``left`` : intervals of delays in which others may be.
    """

    loop: Opened
    own: Rational
    curves: list[AngleCurve]
    most: Fraction | None
    found: list[Passage] = field(default_factory=list)
    senses: list[int] = field(default_factory=list)
    left: list[Span] = field(default_factory=list)
    frontier: Fraction | None = Fraction(0)

    @classmethod
    def of(cls, loop: Opened, own: Expr, most: Fraction) -> Lateness | None:
        """The search, with all of its curves up to a delay of ``most``; None where these are not
        settled."""
        at, period = Fraction(0), Fraction(int(loop.loop.T.p), int(loop.loop.T.q))
        found, is_cut_off = list[AngleCurve](), False
        try:
            while at < period:
                piece, last = loop.piece(at, period)
                more, is_more_cut_off = curves(piece, (at, last), most)
                found += more
                is_cut_off |= is_more_cut_off
                at = last
        except UndecidedError:
            return None
        return cls(loop, Rational(own), found, most if is_cut_off else None)

    def known(self, end: Fraction) -> Iterator[Fraction]:
        """Find the critical delays one after the other, up to ``end``; yield up to where all are
        known, after each. A second call goes on where the last one ended."""
        # The working precision is that of the caller while this waits at a yield.
        while self._heap and len(self.found) < _MOST_PASSAGES:
            low, n, k = self._heap[0]
            self._proceed(low)
            if low > end:
                return
            tick()
            with flint.ctx.workprec(_BITS):
                self._look(self.curves[n], k)
                heapreplace(self._heap, self._ahead(self.curves[n], n, k))
            self._proceed(self._heap[0][0])
            if self.frontier is not None:
                yield self.frontier
        if not self._heap:
            self.frontier = self.most

    def _proceed(self, low: float) -> None:
        """Note that all critical delays below a lower bound of those that follow are known."""
        frontier = max(Fraction(0), Fraction(low))
        self.frontier = frontier if self.most is None else min(frontier, self.most)

    @cached_property
    def _heap(self) -> list[tuple[float, int, int]]:
        """The next turn of each curve. The earliest comes first, so that delays are complete up to
        its bound."""
        with flint.ctx.workprec(_BITS):
            heap = [self._ahead(x, n, -2) for n, x in enumerate(self.curves)]
        heapify(heap)
        return heap

    def _ahead(self, curve: AngleCurve, n: int, k: int) -> tuple[float, int, int]:
        """The next turn of a curve after k whose delays are not all < 0, with a lower bound on
        them: as the heap has it."""
        while True:
            k += 1
            delays = curve.delays(k)
            if delays.upper() > 0:
                return float(delays.lower()) * (1 - _ROUNDING), n, k

    def _look(self, curve: AngleCurve, k: int) -> None:
        """Add the critical delays of a curve after k turns to what was ``found``, or to
        ``left``."""
        T, theta, delays = expression_ball(self.loop.loop.T), curve.box[1], curve.delays(k)
        first, last = (
            int(x.floor().unique_fmpz())  # of a number without radius: just one
            for x in (
                ((delays.lower() - theta.upper()) / T).lower(),
                ((delays.upper() - theta.lower()) / T).upper(),
            )
        )
        if last - first > _MANY:
            self.left.append(bounds(delays))
            return
        for samples in range(max(first, 0), last + 1):
            turn = Turn(curve, samples, k)
            try:
                for pair in turn.pairs():
                    self._add(Passage(pair.value, pair.frequency), turn.sense(pair))
            except UndecidedError:
                self.left.append(bounds(delays))

    def _add(self, passage: Passage, sense: int) -> None:
        """Add a critical delay, unless it is there: parts of curves overlap a little, and a whole
        number of samples is at the end of one piece and at the start of the next."""
        # A pair of roots: at z = 1 and z = -1, where there is one alone, |N/Q| is even in the
        # angle, so that its slope is 0 and no curve is proven.
        roots = 2 * sense
        for i, known in enumerate(self.found):
            same_value = not ordered(known.value, passage.value)
            if same_value and not ordered(known.omega, passage.omega):
                if self.senses[i] != roots:
                    raise UndecidedError("whether a root comes to the unit circle and goes back")
                return
        self.found.append(passage)
        self.senses.append(roots)

    def holds(self, value: Rational) -> bool | None:
        """Whether the loop is stable with a delay, by the exact count at its own one and the roots
        that cross in between; None where these are not all known."""
        # At a critical delay itself a root is on the circle, or may be: the sum tells nothing.
        at = ExactNumber(value)
        if not self._is_told(value) or any(not ordered(x.value, at) for x in self.found):
            return None
        low, high = sorted((self.own, value))
        between = [
            sense
            for x, sense in zip(self.found, self.senses, strict=True)
            if ordered(ExactNumber(low), x.value) > 0 and ordered(x.value, ExactNumber(high)) > 0
        ]
        return self._home + (1 if value > self.own else -1) * sum(between) == 0

    def _is_told(self, value: Rational) -> bool:
        """Whether all critical delays between the loop's own delay and another one are known."""
        last = max(self.own, value)
        if self.left or self.frontier is None:
            return not self.left
        # ``most`` itself is among what is known: what was cut off, and a lower bound in the heap
        # that is as large, stand for larger delays.
        frontier = rational(self.frontier)
        return last < frontier or (self.frontier == self.most and last == frontier)

    @cached_property
    def _home(self) -> int:
        return sum(self.loop.at(self.own).unstable())
