"""Which way roots cross the imaginary axis as an open number grows: where it is one way alone, one count tells of endless values.

C = A + q B has a root at j omega where g = -A/B is q. It moves to the right as q > 0 grows if the phase of g grows with omega
there, and to the left if it falls (the root tendency). Beyond some frequency delays make it one of the two: then what meets the
axis there only adds roots on the right, or only takes them away, one infinitely long sequence after the other.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import flint
from sympy import Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.alike import ALIKE_BITS, ordered
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import RationalFunction
from haptisym.verbs.stability.curves import Curve, curve_of
from haptisym.verbs.stability.farout import from_infinity
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.switches import Switches

_MOST_TURNING = 400  # radians that a delay turns up to where roots cross either way


@dataclass(frozen=True)
class _Settled:
    """The ``sense`` of the ``rate`` of g's phase beyond a frequency.

    ``curve`` : of the loop. ``known`` : all values with roots on the axis below that frequency, or at infinity.
    """

    sense: int
    rate: RationalFunction
    curve: Curve
    known: tuple[RealNumber, ...]


@dataclass(frozen=True)
class Tendency:
    """Of a loop and its open number."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether each value from one to another is proven to have a root in Re s >= 0; an end that is None is endless."""
        with suppress(UndecidedError):
            return self._of_a_delay(low) if self.loop.turns else self._from_an_end(low, high)
        return False

    def _of_a_delay(self, low: RealNumber | None) -> bool:
        if low is None or not (found := Switches.of(self.loop)).is_still:
            return False
        last = found.unstable_from
        return (last is not None and ordered(ExactNumber(last), low) >= 0) or found.come(low) > 0

    def _from_an_end(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """From the end on at which roots lie on the right already, if from there on they cross to the right alone."""
        side = 1 if low is not None and float(low) >= 0 else -1 if high is not None and float(high) <= 0 else 0
        if not side or self._settled is None:
            return False
        found = self._settled
        if any(_is_between(x, low, high) for x in found.known):
            return False
        start = low if side * found.sense > 0 else high
        return start is not None and self._has_some_beyond(start, found)

    @cached_property
    def _settled(self) -> _Settled | None:
        """None where the phase goes both ways for ever, or up to a frequency to which delays turn very often."""
        if len(self.loop.powers) != 2 or (curve := curve_of(self.loop)) is None or curve.condition.is_zero:
            return None
        rate = _rate(curve)
        found = far(rate)
        if found.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            return None
        if any(float(found.radius * lag) > _MOST_TURNING for lag in self.loop.ring.lags):
            return None
        near = curve.meetings(max(found.radius, Integer(1)))
        known = (*Characteristic(self.loop).at_0(), *(x.value for x in (*near, *from_infinity(self.loop))))
        return _Settled(found.sense.value, rate, curve, known)

    def _has_some_beyond(self, start: RealNumber, found: _Settled) -> bool:
        """Whether roots lie on the right beside a value, on the side to which others can only join them."""
        if isinstance(start, ExactNumber) and isinstance(start.value, Rational):
            return bool(self.loop.at(start.value).right)
        if not isinstance(start, ValueAt):
            return False
        with flint.ctx.workprec(ALIKE_BITS):  # those on the axis itself, if it is there that the value puts them
            omega, curve = start.omega.ball(ALIKE_BITS), found.curve
            rate, own, zero = (RealFunction(f).ball(omega) for f in (found.rate, curve.value, curve.condition))
            return bool(own.overlaps(start.ball(ALIKE_BITS)) and zero.contains(0) and found.sense * rate > 0)


def _rate(curve: Curve) -> RationalFunction:
    """Of the phase of g over frequency, times something positive."""
    u, v = curve.value, curve.condition  # g is u - j v, both over the same square
    axis = RealFunction(u).axis
    turned = [axis.derivative(x.numerator) * axis.function(y.numerator) for x, y in ((u, v), (v, u))]
    return turned[0] - turned[1]


def _is_between(x: RealNumber, low: RealNumber | None, high: RealNumber | None) -> bool:
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)
