"""Critical values of a delay: the values of tau at which A(s) + B(s) exp(-s tau) has roots on the
imaginary axis, and a value from which on it always has roots on the right.

A and B are polynomials in s and in other delays, free of tau. A root j omega, omega > 0, needs
|A(j omega)| = |B(j omega)|, a condition without tau: few frequencies fulfil it. At each of them
exp(-j omega tau) = -A/B holds for a first tau >= 0, and from there on once in 2 pi/omega seconds.
Cooke and van den Driessche (On zeroes of some transcendental equations, Funkcialaj Ekvacioj 29,
1986) proved which way the roots go: at each such tau one pair goes to the right where |A/B|
increases with omega through 1, and to the left where it decreases.

The exponent may also hold k tau: k is the *multiple*, a number, and 1 in most loops.

Begin with ``Switches.of``: it returns the first critical delay of each frequency, or raises
UndecidedError for another form or for |A| and |B| that are equal at ever higher frequencies.
``Switches.up_to`` lists all critical delays up to a bound, proven; ``unstable_from`` is the value
from which on there are roots on the right. Roots at s = 0, and chains from infinity, do not count
among them (``critical`` adds both).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.asymptoticsign import Sense, sign_without_zeros
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.rings import RationalFunction, coefficients, degree_in
from haptisym.kernel.roots import chart
from haptisym.verbs.stability.loops import CriticalRoot, Loop, minus

# Critical delays of each frequency that are listed beyond the value that tau has.
_MORE_PERIODS = 8
# Critical delays that are listed at most in order to reach ``unstable_from``.
_MOST_LISTED = 300
# Working precision, bits, of numbers whose sign is asked for.
_BITS = 192
# Bounds of pi and 2 pi for floats: below them, so that a count of periods errs upward.
_BELOW_PI, _BELOW_2_PI = 3.14, 6.28

# The names of functions on a chart, which has all of their zeros and poles on a band, and the signs
# between (``kernel.roots``).
_CONDITION, _IMAG = "condition", "imag"


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """The number tau = (2 pi ``periods`` - arg(-A/B))/(k omega), s, with the argument from -pi to
    pi at a frequency ``omega`` with |A| = |B|.

    ``ratio`` : the real and the imaginary part of -A/B. ``multiple`` : k. ``is_real`` : whether
    -A/B is 1 or -1 at omega: then its imaginary part is taken to be exactly 0, as a ball around -1
    would reach over the cut of the argument.
    """

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber
    periods: int
    multiple: Expr
    is_real: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            omega = self.omega.ball(bits)
            real, imag = (part.ball(omega) for part in self.ratio)
            angle = -acb(real, 0 if self.is_real else imag).arg()
            phase = angle + 2 * arb.pi() * self.periods
            return phase / (omega * expression_ball(self.multiple))

    @property
    def rate(self) -> float:
        """k omega, rad/s, rounded: the phase of the delay grows by so much with a second of tau."""
        return float(self.omega) * float(self.multiple)

    def periods_up_to(self, delay: float) -> int:
        """How many further critical delays of this frequency are listed: all up to a delay, s, and
        some more."""
        return int(self.rate * delay / _BELOW_2_PI) + _MORE_PERIODS


@dataclass(frozen=True)
class Switches:
    """The critical delays of A + B exp(-s k tau).

    ``firsts`` : the first delay >= 0 of each frequency, by ascending frequencies. ``senses`` : of
    each frequency 1 where |A/B| increases through 1, -1 where it decreases, 0 where it touches 1.
    ``differ_at_0`` : whether |A| and |B| differ at omega = 0. If not, roots may also cross at s =
    0, and the senses do not say which way pairs go.
    """

    firsts: tuple[DelayAt, ...]
    senses: tuple[int, ...]
    differ_at_0: bool

    @classmethod
    def of(cls, loop: Loop) -> Switches:
        """The switches of a loop with q as a delay, of which no chain of roots is on the right.

        UndecidedError where it has another form, or where |A| = |B| cannot be decided.
        """
        ratio, multiple = _ratio(loop)
        condition = minus(squared_modulus(ratio).function, Integer(1))
        at_infinity = sign_without_zeros(condition)
        if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            raise UndecidedError("where roots meet the imaginary axis")
        response = on_axis(ratio)
        functions = {_CONDITION: RealFunction(condition.reduced()), _IMAG: response.imag}
        points = chart(functions, Integer(0), max(at_infinity.radius, Integer(1))).points
        if any(_CONDITION in point.undecided for point in points):
            raise UndecidedError("whether a root touches the imaginary axis")
        at_0, *others = points
        parts = response.real, response.imag
        firsts, senses = list[DelayAt](), list[int]()
        for point in others:
            if point.orders.get(_CONDITION, 0) > 0:
                is_real = response.imag.is_zero or point.orders.get(_IMAG, 0) > 0
                delay = DelayAt(parts, point.omega, 0, multiple, is_real=is_real)
                firsts.append(_first(delay))
                change = point.after[_CONDITION] - point.before[_CONDITION]
                senses.append(change // 2)
        differ_at_0 = at_0.orders.get(_CONDITION, 0) <= 0
        return cls(tuple(firsts), tuple(senses), differ_at_0)

    @property
    def _each(self) -> list[tuple[DelayAt, int]]:
        return [*zip(self.firsts, self.senses, strict=True)]

    def up_to(self, value: Expr) -> tuple[tuple[CriticalRoot, ...], Rational | None]:
        """All critical delays >= 0 up to a bound beyond ``value``, and that bound, s; None for the
        bound where there are no others."""
        if not self.firsts:
            return (), None
        end = self._end(value)
        roots = list[CriticalRoot]()
        for first, sense in self._each:
            known_sense = sense if self.differ_at_0 else None
            roots += _listed(first, first.periods_up_to(end), known_sense)
        # The phase of a first delay is at least 0, and n further periods are listed: the first one
        # that is not is at 2 (n + 1) pi/(k omega) or later. This stays safely below it.
        bounds = list[float]()
        for first in self.firsts:
            phase = (2 * first.periods_up_to(end) - 1) * _BELOW_PI
            bounds.append(phase / first.rate)
        return tuple(roots), Rational(min(bounds)).limit_denominator(10**9)

    def _end(self, value: Expr) -> float:
        """Up to which delay all critical ones are listed: up to ``unstable_from`` if those are not
        too many, else up to the value."""
        last = self.unstable_from
        if last is None:
            return float(value)
        number = sum(float(last) * x.rate / _BELOW_2_PI for x in self.firsts)
        if number >= _MOST_LISTED:
            return float(value)
        return max(float(value), float(last))

    @cached_property
    def unstable_from(self) -> Rational | None:
        """A delay, s, such that for every larger one there are roots on the right; None where none
        is proven.

        Let theta_i, from 0 to 2 pi, be the phase of the first delay of the frequency omega_i (k
        times omega here). Up to tau, at least (omega_i tau - theta_i)/(2 pi) pairs have crossed
        there, and at most one more. Counted as +1 to the right and -1 to the left, more pairs have
        gone to the right than to the left where

            tau sum(sense_i omega_i) > sum(sense_i theta_i) + 2 pi (number of senses that are -1).

        Pairs that are on the right at tau = 0 already are not counted, which is on the safe side.
        The first sum is positive where |A| > |B| at infinity: the highest frequency has sense 1.
        """
        if not self.differ_at_0:
            return None
        with flint.ctx.workprec(_BITS):
            slope, offset = arb(0), arb(0)
            for first, sense in self._each:
                rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
                slope += sense * rate
                start = sense * _phase_of_first(first.ball(_BITS) * rate)
                offset += start + (2 * arb.pi() if sense < 0 else 0)
            if not slope > 0:
                return None
            # Upward, by more than a float in decimal digits can lose.
            last = float((offset / slope).upper()) * (1 + 1e-9)
            return Rational(str(last)) + Rational(1, 10**12)


def _first(x: DelayAt) -> DelayAt:
    """The first delay >= 0 of a frequency: that of the argument from -pi to pi, or one period
    later."""
    return replace(x, periods=1) if x.ball(_BITS) < 0 else x


def _phase_of_first(phase: Ball) -> Ball:
    """The phase theta of the first delay > 0; a ball from 0 to 2 pi where ``phase`` may be 0, as
    the first one is then a period later."""
    return phase if phase > 0 else arb(0).union(2 * arb.pi())


def _listed(first: DelayAt, periods: int, sense: int | None) -> Iterator[CriticalRoot]:
    """The critical delays of one frequency from its first one on, for that many further periods."""
    for n in range(periods + 1):
        delay = replace(first, periods=first.periods + n)
        # 0 is the end of what a delay may be: a root there is on the axis, but crosses nothing.
        if delay.ball(_BITS).is_zero():
            yield CriticalRoot(ExactNumber(Integer(0)), omega=first.omega)
        elif float(delay) > 0:
            yield CriticalRoot(delay, omega=first.omega, sense=sense)


def _ratio(loop: Loop) -> tuple[RationalFunction, Expr]:
    """-A/B and k of a loop A + B exp(-s k tau), tau being q.

    UndecidedError where q is in several unit delays or in a power of s, where exp(-s q) has several
    powers, or where q is in a coefficient as well.
    """
    ring, symbol = loop.ring, loop.symbol
    units = [i for i, lag in enumerate(ring.lags) if symbol in lag.free_symbols]
    is_in_power = any(symbol in x.free_symbols for x in ring.orders)
    if len(units) != 1 or is_in_power:
        raise UndecidedError("a number that is in several delays")
    rows = coefficients(loop.numerator, ring.size + units[0])
    delayed = [n for n, row in enumerate(rows) if n and row]
    if len(delayed) != 1:
        raise UndecidedError("a delay that comes back several times")
    multiple = delayed[0] * ring.lags[units[0]] / symbol
    if multiple.free_symbols or degree_in([loop.numerator], ring.meanings.index(symbol)):
        raise UndecidedError("a delay that comes back several times")
    # Over a ring without the delay q, of which A and B hold nothing.
    expressions = [ring.expression(x) for x in (rows[0], rows[-1])]
    target = Ring.of(expressions)
    A, B = map(target.convert, expressions)
    return (-A / B).reduced(), multiple
