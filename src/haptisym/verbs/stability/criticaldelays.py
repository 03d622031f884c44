"""All delays of a sampled loop that put a root of it on the unit circle: its critical delays.

**Question.** Between what a loop samples and the force that it holds for each period T all is
delayed by tau, the parameter: tau = d T + theta, d whole *samples* and a *rest* theta, 0 <= theta <
T. The loop is

    z^d Q(z) + N(z; theta) = 0,

with polynomials Q (the part without the controller) and N (the part that it adds; modified
z-transform, Jury 1958), and it is stable if all roots have abs(z) < 1. At which tau does a root lie
on the circle, at which frequency, and does it move outward or inward as tau grows?

**Assumed**, and seen to by ``Opened.is_late``: the degree of N is less than that of Q for every
theta, as no force moves what is sampled at once. So no root comes from infinity. And N(z; 0) = z
N(z; T): where d increases by 1, and theta falls from T to 0, the polynomial as a whole gets a
factor z, a root at 0. Together: the roots that are not 0 are continuous in tau.

**Method.** It is the direct method for loops with a delay (Walton and Marshall, IEE Proc. D 134,
1987), for samples. On the circle, z = exp(j omega T) with 0 < omega < pi/T. With L = log(-N/Q) the
equation of the loop is

    L(omega, theta) = j (omega d T - 2 pi k)  for some whole k.                                  (1)

Its real part Re L = 0, a gain abs(N/Q) = 1, depends on neither d nor k: it holds on a few
*unit-gain curves* omega(theta). On these its imaginary part gives, with the *phase* phi = Im L +
omega theta,

    tau = (phi + 2 pi k)/omega.                                                                  (2)

1. ``unit_gain_curves`` bisects boxes of (omega, theta) until in each there is no gain of 1, or at
   most one omega for each theta.
2. For each curve and each k, in ascending order of (2), ``CrossingEquation`` solves (1) for omega
   and tau, by interval Newton and bisection. A solution is a *crossing*.
3. In which direction the root moves there is the sign of the Jacobian determinant of (1)
   (``CrossingEquation.direction``).
4. The number of roots outside of the circle changes at crossings alone: one exact count, at a
   *reference delay*, gives it for all other delays (``CriticalDelays.is_stable_at``).

*Interval Newton* (Neumaier, Interval Methods for Systems of Equations, 1990, chapter 5): for a box
X with the middle m, and an enclosure J of all derivatives of f over X that holds no singular
matrix, all zeros of f in X lie in m - J^-1 f(m). If that is within the interior of X, there is
exactly one.

**Guaranteed.** All numbers are *balls*, intervals with middle and radius (``arb`` of FLINT;
complex: ``acb``), whose operations, at the working precision, enclose all values; comparisons of
balls are True only where they hold for all values. So what is returned is proven, but for one
thing: two numbers of which hundreds of bits agree are taken for equal (``ordered``). What is not
decided is an UndecidedError, None, or an interval of delays in ``CriticalDelays.undecided``.

**Words.** A ``Pair`` is a proven crossing (omega, tau), which it refines to any number of bits by
steps of interval Newton; a ``Passage`` is its delay and its frequency as numbers. An ``Opened`` is
a loop with an open parameter, here tau; its ``loop.sides`` are N and Q as polynomials in z - 1, of
which N is given for theta in place of tau. A ``theta_range`` is one over which N is one analytic
function of theta.

Begin with ``CriticalDelays``.
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
    bounds,
    expression_ball,
    fraction_ball,
    ordered,
    rational,
)
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.stability.characteristic import Pair
from haptisym.verbs.stability.opened import Opened, Passage, Span

Box: TypeAlias = tuple[Ball, Ball]
"""A ball of frequencies omega, rad/s, and one of rests theta or of delays, s."""
Ends: TypeAlias = tuple[float, float]
"""The lower and the upper end of one side of a box."""
Range: TypeAlias = tuple[Fraction, Fraction]
"""The lower and the upper end of a range of theta, s."""

# Working precision, bits.
_BITS = 128
# The range -1 <= x <= 1: times a number, all numbers that are no larger.
_EITHER = arb(0, 1)


# The critical delays, and stability between them.

# Critical delays that are searched for at most: a reader needs the first few.
_MOST_PASSAGES = 64
# A curve whose delays for one k spread over more samples is too wide to be followed.
_MOST_SAMPLES_OF_A_CURVE = 8
# A float is rounded by at most 2^-53 of it: less this share of its size, it is a lower bound.
_ROUNDING = 2.0**-50


@dataclass(eq=False)
class CriticalDelays:
    """The critical delays of a loop, searched in ascending order.

    ``reference_delay`` : a delay, s, at which the unstable roots are counted.
    ``curves`` : the unit-gain curves, from which all critical delays up to ``most``, s, follow
    (None: all at any delay).
    ``passages`` : the critical delays that were found, with their frequencies.
    ``root_changes`` : for each of these, how many more roots are outside of the circle above it.
    ``undecided`` : intervals of delays in which there may be others, or in which the change of a
    passage is not known. While there are any, ``is_stable_at`` tells nothing.
    ``frontier`` : the delay, s, below which no critical delay is missing but in ``undecided``
    (None: none is missing anywhere).
    """

    loop: Opened
    reference_delay: Rational
    curves: list[UnitGainCurve]
    most: Fraction | None
    passages: list[Passage] = field(default_factory=list)
    root_changes: list[int] = field(default_factory=list)
    undecided: list[Span] = field(default_factory=list)
    frontier: Fraction | None = Fraction(0)

    @classmethod
    def of(cls, loop: Opened, reference_delay: Rational, most: Fraction) -> CriticalDelays | None:
        """Prepare the search up to a delay of ``most``, s; None where not all unit-gain curves are
        found.

        The loop must be one of which ``Opened.is_late``.
        """
        period = Fraction(int(loop.loop.T.p), int(loop.loop.T.q))
        curves, is_cut_off = list[UnitGainCurve](), False
        # A term of the plant may have a further delay of its own. N is one function of theta as
        # long as none of these sums gets one more whole sample: ``end`` is where the first one
        # does.
        start = Fraction(0)
        try:
            while start < period:
                loop_of_range, end = loop.piece(start, period)
                further_curves, has_later = unit_gain_curves(loop_of_range, (start, end), most)
                curves += further_curves
                is_cut_off |= has_later
                start = end
        except UndecidedError:
            return None
        return cls(loop, reference_delay, curves, most if is_cut_off else None)

    def advance_to(self, end: Fraction) -> Iterator[Fraction]:
        """Find the critical delays one after the other, up to ``end``, s, or until there are
        ``_MOST_PASSAGES``; yield ``frontier`` after each step. A second call goes on where the last
        one ended."""
        # At a yield the working precision is that of the caller: it is set for each step alone.
        while self._heap and len(self.passages) < _MOST_PASSAGES:
            low, n, k = self._heap[0]
            self._advance_frontier(low)
            if low > end:
                return
            tick()
            with flint.ctx.workprec(_BITS):
                self._search(self.curves[n], k)
                heapreplace(self._heap, self._next_crossings(n, k))
            yield self._advance_frontier(self._heap[0][0])
        # A curve has crossings for ever larger k, so that the heap is empty where there are no
        # curves at all.
        if not self.curves:
            self.frontier = self.most

    def _advance_frontier(self, low: float) -> Fraction:
        """Note that all critical delays below ``low``, a lower bound of all that follow, are known,
        and return the frontier."""
        frontier = max(Fraction(0), Fraction(low))
        self.frontier = frontier if self.most is None else min(frontier, self.most)
        return self.frontier

    @cached_property
    def _heap(self) -> list[tuple[float, int, int]]:
        """For each curve the next k that is to be searched, as of ``_next_crossings``. The least
        delay comes first, so that no critical delay below it is missing."""
        # The first k that may have a delay >= 0 is -1: with the branches of the logarithm in
        # ``enclose_log`` and omega theta <= pi the phase is less than 3 pi.
        with flint.ctx.workprec(_BITS):
            heap = [self._next_crossings(n, -2) for n in range(len(self.curves))]
        heapify(heap)
        return heap

    def _next_crossings(self, n: int, k: int) -> tuple[float, int, int]:
        """For the next k after the given one for which curve ``n`` has delays >= 0: a lower bound
        of these, s; n; and k."""
        while True:
            k += 1
            delays = self.curves[n].delays(k)
            if delays.upper() >= 0:
                low = float(delays.lower())
                return low - abs(low) * _ROUNDING, n, k

    def _search(self, curve: UnitGainCurve, k: int) -> None:
        """Add the critical delays of a curve for one k to ``passages``, or to ``undecided``."""
        T, theta, delays = expression_ball(self.loop.loop.T), curve.box[1], curve.delays(k)
        # The least and the largest d with d T + theta among the delays.
        first = ((delays.lower() - theta.upper()) / T).lower().floor()
        last = ((delays.upper() - theta.lower()) / T).upper().floor()
        first_samples, last_samples = int(first.unique_fmpz()), int(last.unique_fmpz())
        if last_samples - first_samples > _MOST_SAMPLES_OF_A_CURVE:
            self.undecided.append(bounds(delays))
            return
        for samples in range(max(first_samples, 0), last_samples + 1):
            equation = CrossingEquation(curve, samples, k)
            try:
                for pair in equation.crossings():
                    self._add(Passage(pair.value, pair.frequency), equation.direction(pair))
            except UndecidedError:
                self.undecided.append(bounds(delays))

    def _add(self, passage: Passage, direction: int) -> None:
        """Add a critical delay, unless it is there already.

        It is found twice where boxes overlap, and where tau is a whole number of samples, the end
        of one range of theta and the start of the next. There N has a corner: if the directions on
        both sides differ the root only touches the circle. Then UndecidedError; the passage keeps
        the change of one side, which ``undecided`` keeps from use.
        """
        # A root and its conjugate. At z = 1 and z = -1, where a root has none, no curve is proven:
        # abs(N/Q) is even in the angle of z there, so that its slope is 0.
        root_change = 2 * direction
        for i, known in enumerate(self.passages):
            is_same_delay = not ordered(known.value, passage.value)
            if is_same_delay and not ordered(known.omega, passage.omega):
                if self.root_changes[i] != root_change:
                    raise UndecidedError("whether a root comes to the unit circle and goes back")
                return
        self.passages.append(passage)
        self.root_changes.append(root_change)

    def is_stable_at(self, delay: Rational) -> bool | None:
        """Whether the loop is stable with a delay, s.

        None where not all critical delays between it and the reference delay are known, and where
        it is critical itself, as no sum of changes tells how many roots are then on the circle.
        UndecidedError where the roots at the reference delay cannot be counted, as where one of
        them is on the circle.
        """
        number = ExactNumber(delay)
        is_critical = any(not ordered(x.value, number) for x in self.passages)
        if is_critical or not self._are_known_up_to(max(self.reference_delay, delay)):
            return None
        low, high = (ExactNumber(x) for x in sorted((self.reference_delay, delay)))
        change = 0
        for x, root_change in zip(self.passages, self.root_changes, strict=True):
            if low < x.value < high:
                change += root_change
        if delay < self.reference_delay:
            change = -change
        return self._unstable_at_reference + change == 0

    def _are_known_up_to(self, delay: Rational) -> bool:
        """Whether all critical delays up to one, s, are known."""
        if self.undecided:
            return False
        if self.frontier is None:
            return True
        # ``most`` itself is among what is known: curves that were left out, and a lower bound in
        # the heap that is as large, belong to larger delays.
        frontier = rational(self.frontier)
        return delay < frontier or (self.frontier == self.most and delay == frontier)

    @cached_property
    def _unstable_at_reference(self) -> int:
        """The number of roots with abs(z) >= 1 at the reference delay, an exact count."""
        return sum(self.loop.at(self.reference_delay).unstable())


# The logarithm of -N/Q, in balls.


class LogEnclosure(NamedTuple):
    """L = log(-N/Q) over a box of omega and theta.

    ``middle`` : L at the middle of the box. ``by_omega``, ``by_theta`` : enclosures of its partial
    derivatives all over the box. By the mean value theorem they enclose L all over the box.
    """

    middle: acb
    by_omega: acb
    by_theta: acb


class BoxTest(NamedTuple):
    """What is known of a box of omega and theta: whether no root is on the circle in it, as abs(N)
    and abs(Q) differ all over it; else L over the box, or None where L has no bounds."""

    has_no_root: bool
    log: LogEnclosure | None


def enclose_log(loop: Opened, omega: Ball, theta: Ball) -> BoxTest:
    """Test a box, and enclose L over it, on any branch, at the working precision."""
    T = expression_ball(loop.loop.T)
    # z - 1 over the box, and at its middle, where omega has no radius but T may have one.
    z_1, z_1_middle = _on_circle(omega * T), _on_circle(omega.mid() * T)
    polynomials = _enclose_loop(loop, theta.mid(), _radius(theta, T), flint.ctx.prec)
    # As polynomials in the distance from the middle: powers of a wide ball, and balls that cancel
    # far from 0, grow faster than the range of what they enclose.
    N_middle, N_constant, N_linear, N_rate, Q = (
        acb_poly(p)(acb_poly([z_1_middle, 1])) for p in polynomials
    )
    z = z_1 - z_1_middle
    N = N_constant(z) + N_linear(z) * _EITHER
    Q_value = Q(z)
    if not abs(N).overlaps(abs(Q_value)):
        return BoxTest(has_no_root=True, log=None)
    if N.contains(0) or Q_value.contains(0):
        return BoxTest(has_no_root=False, log=None)
    ratio = -N_middle[0] / Q[0]
    # A branch away from its cut, along the negative numbers, where a ball would hold both ends. Its
    # imaginary part is between -pi and 3 pi/2.
    log = (-ratio).log() + acb(0, arb.pi()) if ratio.real < 0 else ratio.log()
    # d log(-N/Q)/dz is N_z/N - Q_z/Q. Its first part is enclosed for the middle theta, as narrow as
    # can be. By the mean value theorem it changes with theta by at most the distance times its
    # derivative (N_z theta - N_z N_theta/N)/N.
    N_z = N_constant.derivative()(z) + N_linear.derivative()(z) * _EITHER
    N_theta, N_z_theta = N_rate(z), N_rate.derivative()(z)
    by_z_at_theta = N_middle.derivative()(z) / N_middle(z) - Q.derivative()(z) / Q_value
    by_z = by_z_at_theta + (N_z_theta - N_z * N_theta / N) / N * _distance(theta)
    # dz/d omega is j T z.
    by_omega = acb(0, 1) * (1 + z_1) * T * by_z
    return BoxTest(has_no_root=False, log=LogEnclosure(log, by_omega, N_theta / N))


def _on_circle(angle: Ball) -> acb:
    """z - 1 for z = exp(j angle), without cancellation at low frequencies."""
    return acb(-2 * (angle / 2).sin() ** 2, angle.sin())


def _radius(theta: Ball, T: Ball) -> Ball:
    """The radius within which N is enclosed about the middle of theta: that of theta, or a tiny
    part of T where it is smaller.

    A derivative is a difference over it, and would lose all digits of a smaller one; so it loses a
    quarter. ``mid`` makes it one number, which the cache of ``_enclose_loop`` finds again.
    """
    return theta.rad().max(T.lower() * arb(2) ** (-flint.ctx.prec // 4)).mid()


def _distance(x: Ball) -> Ball:
    """A ball around all distances of the numbers in a ball from its middle."""
    return x - x.mid()


class _EnclosedLoop(NamedTuple):
    """N and Q as polynomials in z - 1, for all theta within a radius of a middle.

    ``N_middle`` : N for the middle. N(z; theta) = ``N_constant`` + x ``N_linear`` with x = (theta -
    middle)/radius, -1 <= x <= 1. ``N_rate`` : dN/dtheta, for all theta.
    """

    N_middle: arb_poly
    N_constant: arb_poly
    N_linear: arb_poly
    N_rate: arb_poly
    Q: arb_poly


@lru_cache(maxsize=512)
def _enclose_loop(loop: Opened, middle: Ball, radius: Ball, bits: int) -> _EnclosedLoop:
    """Enclose N and Q for all theta within ``radius`` of ``middle``, at the working precision
    ``bits``."""
    # The precision is an argument so that the cache does not return coarser balls.
    assert bits == flint.ctx.prec

    def numerator(theta: Ball) -> list[Ball]:
        """The coefficients of N, ascending in z - 1, for a real or complex ball of theta."""
        coefficients: list[Ball] = loop.loop.sides({loop.symbol: theta})[0].coeffs()
        return coefficients

    # Of each coefficient: a and the slope in a + slope x, a in a ball, -1 <= x <= 1; and its
    # derivative by x all over the range.
    lines = over_ellipse(numerator, middle, radius)
    N, Q = loop.loop.sides({loop.symbol: middle})
    # At z = 1 a delay changes nothing: the coefficient of (z - 1)^0 is that for the middle.
    first = (N[0], arb(0), arb(0))
    columns = zip(first, *lines[1:], strict=True)
    constant, linear, rate = (arb_poly(list(column)) for column in columns)
    return _EnclosedLoop(N, constant, linear, rate * (1 / radius), Q)


def _phase(log: LogEnclosure, omega: Ball, theta: Ball) -> Ball:
    """The phase Im L + omega theta all over a box, by the mean value theorem. ``log`` : L over this
    box."""
    middle = log.middle.imag + omega.mid() * theta.mid()
    by_omega = log.by_omega.imag + theta
    by_theta = log.by_theta.imag + omega
    return middle + by_omega * _distance(omega) + by_theta * _distance(theta)


# The unit-gain curves.

# Boxes of frequency and rest that are examined at most, some seconds.
_MOST_BOXES = 1200
# A curve is cut until it is so many times narrower than its frequency, so that its delays (2)
# spread over a small part of their values.
_NARROW = 32


@dataclass(frozen=True, eq=False)
class UnitGainCurve:
    """A part of a unit-gain curve: abs(N) = abs(Q) at one omega at most for each theta in a box.

    ``theta_range`` : where N is that of the loop; the box may reach beyond it.
    ``phase`` : the phase Im L + omega theta all over the box, on one branch of L; its radius is
    less than 1 rad.
    """

    loop: Opened
    theta_range: Range
    box: Box
    phase: Ball

    def delays(self, k: int) -> Ball:
        """The delays (2), s, for one k, all over the box."""
        return (self.phase + 2 * k * arb.pi()) / self.box[0]

    def log(self, omega: Ball, theta: Ball) -> LogEnclosure | None:
        """L in a part of the box, on the branch of ``phase``; None where it has no bounds."""
        log = enclose_log(self.loop, omega, theta).log
        if log is None or not log.middle.is_finite():
            return None
        phase = log.middle.imag + omega.mid() * theta.mid()
        # On the right branch both phases differ by less than 1 rad, and branches by 2 pi: rounding
        # finds it.
        turns = round(float((self.phase.mid() - phase.mid()) / (2 * arb.pi())))
        return log._replace(middle=log.middle + acb(0, 2 * turns * arb.pi()))


def unit_gain_curves(
    loop: Opened, theta_range: Range, most: Fraction
) -> tuple[list[UnitGainCurve], bool]:
    """All unit-gain curves for a range of theta, but those that give delays above ``most``, s,
    alone; and whether any of these were left out.

    UndecidedError where a box is neither clear nor holds one curve, as where a curve turns back in
    theta.
    """
    start, end = theta_range
    curves, is_cut_off = list[UnitGainCurve](), False
    with flint.ctx.workprec(_BITS):
        # Rounded outward, so that no frequency up to pi/T is missed, and no theta.
        highest = nextafter(float((arb.pi() / expression_ball(loop.loop.T)).upper()), inf)
        whole = (0.0, highest), (nextafter(float(start), -inf), nextafter(float(end), inf))
        waiting = Waiting([whole], most=_MOST_BOXES, what="boxes of frequency")
        for frequencies, thetas in waiting:
            box = _ball(*frequencies), _ball(*thetas)
            has_no_root, log = enclose_log(loop, *box)
            if has_no_root:
                continue
            if log is not None and _is_above(_phase(log, *box), box[0], most):
                is_cut_off = True
                continue
            found = _followed(loop, theta_range, box, log) if log is not None else box
            if isinstance(found, UnitGainCurve):
                curves.append(found)
            elif found is not None:
                # Cut along theta where the box is wider there, relative to the whole, than four
                # times along omega.
                width = (thetas[1] - thetas[0]) / float(end - start)
                is_wide = 4 * (frequencies[1] - frequencies[0]) < width * frequencies[1]
                waiting.add(*_halves(frequencies, thetas, int(is_wide)))
        # Boxes that were not looked at as there were too many.
        if waiting.rest:
            raise UndecidedError("at which frequencies the loop has a gain of 1")
    return curves, is_cut_off


def _ball(low: float, high: float) -> Ball:
    """A ball around all numbers between two floats."""
    return arb(low).union(arb(high))


def _halves(frequencies: Ends, thetas: Ends, cut: int) -> list[tuple[Ends, Ends]]:
    """A box cut in two, along omega (``cut`` 0) or along theta (1)."""
    low, high = (frequencies, thetas)[cut]
    middle = (low + high) / 2
    if cut:
        return [(frequencies, (low, middle)), (frequencies, (middle, high))]
    return [((low, middle), thetas), ((middle, high), thetas)]


def _is_above(phase: Ball, omega: Ball, most: Fraction) -> bool:
    """Whether all delays >= 0 that a box gives by (2) are above ``most``, s: a low frequency takes
    long for a turn. ``phase`` : all over the box."""
    # The phase must be narrow against a turn for the test of one k below.
    if not phase.rad() < 1:
        return False
    turn = 2 * arb.pi()
    # phi + 2 pi k for the first k for which it is nowhere negative in the box. For k - 1 it must be
    # negative everywhere, so that no delay >= 0 is missed.
    first = phase + turn * (-phase / turn).upper().ceil()
    return bool(first - turn < 0 and first > omega.upper() * fraction_ball(most))


def _followed(
    loop: Opened, theta_range: Range, box: Box, log: LogEnclosure
) -> UnitGainCurve | Box | None:
    """The unit-gain curve in a box; None where there is none; the box where neither is proven.
    ``log`` : L over the box.

    It is interval Newton for Re L = 0 in omega, for all theta of the box at once. As the derivative
    is not 0 there is at most one omega for each theta.
    """
    omega, theta = box
    current: LogEnclosure | None = log
    # Each step but the last makes omega narrower by a quarter.
    while current is not None and not current.by_omega.real.contains(0):
        # Re L at the middle omega, for all theta.
        gain = current.middle.real + current.by_theta.real * _distance(theta)
        near = omega.mid() - gain / current.by_omega.real
        if not near.overlaps(omega):
            return None
        before, omega = omega, omega.intersection(near)
        # Where it shrinks no further, what is left is how far omega goes along the curve itself.
        if 4 * omega.rad() > 3 * before.rad():
            phase = _phase(current, before, theta)
            is_narrow = phase.rad() < 1 and _NARROW * omega.rad() < omega.mid()
            return UnitGainCurve(loop, theta_range, (omega, theta), phase) if is_narrow else box
        has_no_root, current = enclose_log(loop, omega, theta)
        if has_no_root:
            return None
    return box


# The equation of a crossing.

# Boxes of frequency and delay that are examined at most for one equation, and Newton steps in each:
# one that holds a simple solution converges in a few.
_MOST_PARTS, _MOST_STEPS = 200, 8


@dataclass(frozen=True, eq=False)
class CrossingEquation:
    """Equation (1) on a unit-gain curve, for d = ``samples`` and one k, as two real equations in
    omega, rad/s, and the delay tau, s."""

    curve: UnitGainCurve
    samples: int
    k: int

    @cached_property
    def whole(self) -> Expr:
        """The whole samples d T, s."""
        return self.samples * self.curve.loop.loop.T

    def crossings(self) -> Iterator[Pair]:
        """All solutions in the box of the curve with theta in its range.

        One at the edge of two parts of the box may come twice. UndecidedError where that is not
        settled, as at a double one.
        """
        omega, theta = self.curve.box
        delay, delays = theta + expression_ball(self.whole), self.curve.delays(self.k)
        if not delay.overlaps(delays):
            return
        waiting = Waiting([(omega, delay.intersection(delays))], most=_MOST_PARTS)
        for box in waiting:
            result = self._contracted(*box)
            if isinstance(result, Pair):
                if self._may_be_in_range(result):
                    yield result
            elif result is not None:
                # On the curve there is at most one omega for each delay: to cut the delay is
                # enough.
                omega, delay = result
                middle = delay.mid()
                waiting.add(
                    (omega, delay.lower().union(middle)), (omega, middle.union(delay.upper()))
                )
        if waiting.rest:
            raise UndecidedError("whether a root comes to the unit circle and goes back")

    def _may_be_in_range(self, pair: Pair) -> bool:
        """Whether a solution is not proven to be outside of the range of theta, where another N is
        that of the loop. One at an end is in both ranges, and ``CriticalDelays._add`` takes it
        once."""
        start, end = (ExactNumber(self.whole + rational(x)) for x in self.curve.theta_range)
        return bool(start <= pair.value <= end)

    def _contracted(self, omega: Ball, delay: Ball) -> Pair | Box | None:
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

    def step(self, omega: Ball, delay: Ball) -> Box | None:
        """The step of interval Newton: a box that holds all solutions in a box; None where it has
        no bounds."""
        linear = self._linear(omega, delay)
        if linear is None or linear.determinant.contains(0):
            return None
        f, f_omega, f_theta, determinant = linear
        whole = expression_ball(self.whole)
        theta = delay - whole
        # By Cramer's rule.
        return (
            omega.mid() - (f_theta.imag * f.real - f_theta.real * f.imag) / determinant,
            whole + (theta.mid() - (f_omega.real * f.imag - f_omega.imag * f.real) / determinant),
        )

    def _linear(self, omega: Ball, delay: Ball) -> _Linear | None:
        """The equation about the middle of a box; None where it has no bounds."""
        # In omega and theta: L is known exactly at the middle theta, whatever the radius of d T.
        whole = expression_ball(self.whole)
        theta = delay - whole
        log = self.curve.log(omega, theta)
        if log is None:
            return None
        f = log.middle - acb(0, omega.mid() * whole - 2 * self.k * arb.pi())
        f_omega, f_theta = log.by_omega - acb(0, whole), log.by_theta
        determinant = f_omega.real * f_theta.imag - f_theta.real * f_omega.imag
        return _Linear(f, f_omega, f_theta, determinant)

    def direction(self, pair: Pair) -> int:
        """1 if the root at a solution leaves the unit circle outward as the delay grows, -1 if
        inward.

        A root obeys d log z = L - 2 pi j k. As L changes with log z = j omega T by L_omega/(j T), w
        d(log z)/d theta = L_theta with w = d + j L_omega/T. So log abs(z) grows by Re(L_theta/w) =
        Re(conj(w) L_theta)/abs(w)^2, and T conj(w) = -j conj(f_omega) with f = L - j (omega d T - 2
        pi k): its sign is that of Im(conj(f_omega) L_theta), the determinant of f, which is not 0
        where Newton's step has proven the solution.
        """
        linear = self._linear(*pair.at(_BITS))
        sign = 0 if linear is None else sign_of(linear.determinant)
        if not sign:
            raise UndecidedError("which way a root goes on the unit circle")
        return sign


class _Linear(NamedTuple):
    """f = L - j (omega d T - 2 pi k) at the middle of a box; enclosures of its derivatives all over
    the box; and their determinant as of two real equations."""

    f: acb
    f_omega: acb
    f_theta: acb
    determinant: arb
