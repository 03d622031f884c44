"""Whether a loop is unstable for all values of an interval of q, also where infinitely many of them
are critical: by the direction in which roots cross the imaginary axis.

The *root tendency* (Olgac and Sipahi, IEEE Trans. Automatic Control 47(5), 2002) is the direction
in which a root crosses the axis as a parameter increases. Here C = A + q B, and roots cross at q =
g(j omega), g = -A/B. For q > 0 they go to the right where the phase of g increases with omega, and
to the left where it decreases; for q < 0 it is the other way round. With delays in A and B roots
may cross at ever higher frequencies, but above some frequency omega_0 the phase may be monotone.
Then consider an interval of q without a value that puts a root on the axis below omega_0, at 0, or
at infinity: all roots that cross in it do so in one direction. From one of its ends to the other
they are only added, so that if there is one at the first of these ends, there is one everywhere.

For q a delay the same follows from ``delayswitches``: from some delay on there are always roots on
the right.

``RootTendency.is_unstable_throughout`` is the one entry point. True is proven; False proves
nothing, and no UndecidedError is raised.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import flint
from sympy import Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import ALIKE_BITS, ExactNumber, RealNumber, ordered
from haptisym.kernel.rings import RationalFunction
from haptisym.verbs.stability.characteristic import Characteristic
from haptisym.verbs.stability.crossingcurve import CrossingCurve, curve_of
from haptisym.verbs.stability.delayswitches import Switches
from haptisym.verbs.stability.loops import Loop, is_between
from haptisym.verbs.stability.neutralchains import from_infinity


@dataclass(frozen=True)
class _OneWay:
    """A loop A + q B in which the phase of g is monotone above a frequency omega_0.

    ``direction`` : 1 where it increases there, -1 where it decreases. ``slope`` : a function of
    omega with the sign of the phase's derivative. ``curve`` : of the loop. ``others`` : all values
    of q that put a root on the axis at or below omega_0, or at infinity.
    """

    direction: int
    slope: RationalFunction
    curve: CrossingCurve
    others: tuple[RealNumber, ...]


@dataclass(frozen=True)
class RootTendency:
    """The direction in which the roots of a ``loop`` cross the axis; see the top of the module."""

    loop: Loop

    def is_unstable_throughout(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether it is proven that for each value from ``low`` to ``high`` (None: no end) there is
        a root in Re s >= 0. False proves nothing."""
        with suppress(UndecidedError):
            if self.loop.has_q_in_exponent:
                return self._is_beyond_last_delay(low)
            return self._is_joined_from_an_end(low, high)
        return False

    def _is_beyond_last_delay(self, low: RealNumber | None) -> bool:
        """Whether q is a delay and the interval lies where there are always roots on the right."""
        last = Switches.of(self.loop).unstable_from
        if low is None or last is None:
            return False
        # ``ordered`` is -1 where its second argument is the smaller one.
        return ordered(ExactNumber(last), low) >= 0

    def _is_joined_from_an_end(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether C is A + q B, and roots are only added to some that are there at one end."""
        # An interval with values on both sides of q = 0 has no one direction.
        side = 0
        if low is not None and float(low) >= 0:
            side = 1
        elif high is not None and float(high) <= 0:
            side = -1
        one_way = self._one_way if side else None
        if one_way is None or any(is_between(x, low, high) for x in one_way.others):
            return False
        start = low if side * one_way.direction > 0 else high
        return start is not None and self._has_roots_beside(start, one_way)

    @cached_property
    def _one_way(self) -> _OneWay | None:
        """The loop with its direction above omega_0; None where C is not A + q B, where the phase
        is not proven to be monotone, or where the delays' phase at omega_0 is so large that the
        roots below it are too many."""
        if len(self.loop.coefficients) != 2:
            return None
        curve = curve_of(self.loop)
        if curve is None or curve.condition.is_zero:
            return None
        slope = _phase_slope(curve)
        at_infinity = asymptotic_sign(slope)
        if at_infinity.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            return None
        if self.loop.has_large_phase(at_infinity.radius):
            return None
        roots = curve.roots(max(at_infinity.radius, Integer(1)))
        others = (
            *Characteristic(self.loop).at_0(),
            *(x.value for x in roots),
            *(x.value for x in from_infinity(self.loop)),
        )
        return _OneWay(at_infinity.sense.value, slope, curve, others)

    def _has_roots_beside(self, start: RealNumber, one_way: _OneWay) -> bool:
        """Whether it is proven that roots lie on the right for values of the interval next to its
        end ``start``, from which on roots are only added.

        At a rational end they are counted. Another end is a critical value, which puts a pair on
        the axis at a known frequency: this pair goes to the right if the phase of g has the same
        direction at that frequency.
        """
        if isinstance(start, ExactNumber) and isinstance(start.value, Rational):
            return bool(self.loop.roots_at(start.value).right)
        if not isinstance(start, ValueAt):
            return False
        with flint.ctx.workprec(ALIKE_BITS):
            omega, curve = start.omega.ball(ALIKE_BITS), one_way.curve
            slope = RealFunction(one_way.slope).ball(omega)
            value = RealFunction(curve.value).ball(omega)
            condition = RealFunction(curve.condition).ball(omega)
            # A value of another loop's curve is excluded by this. That balls contain 0 proves no
            # root; that the value is critical does.
            is_on_curve = value.overlaps(start.ball(ALIKE_BITS)) and condition.contains(0)
            return bool(is_on_curve and one_way.direction * slope > 0)


def _phase_slope(curve: CrossingCurve) -> RationalFunction:
    """The derivative by omega of the phase of g, times a positive function.

    With g = u - j v, u the value and v the condition of the curve, the phase is -atan(v/u), and its
    derivative (u' v - u v')/(u^2 + v^2). u and v have the same denominator, of which the
    derivatives cancel: those of the numerators are enough.
    """
    u, v = curve.value, curve.condition
    axis = RealFunction(u).axis
    first = axis.derivative(u.numerator) * axis.function(v.numerator)
    second = axis.derivative(v.numerator) * axis.function(u.numerator)
    return first - second
