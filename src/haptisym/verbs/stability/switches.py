"""The values of an open delay at which roots switch sides: A(s) + B(s) exp(-s tau) = 0 where |A| = |B|, again and again.

At a frequency where |A/B| grows through 1 roots go to the right, at every such delay, and to the left where it falls (Cooke
and van den Driessche, 1986). From each frequency omega they come once in 2 pi/omega seconds: the highest one is one of the
first kind, and so there are ever more roots on the right in the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import RationalFunction, degree_in
from haptisym.kernel.roots import chart
from haptisym.verbs.stability.curves import Meeting, minus
from haptisym.verbs.stability.loops import Loop, coefficients

_FURTHER = 8  # turns of a delay beyond its value
_MOST_FURTHER = 300  # of all frequencies together, where that tells of all delays
_BITS = 192


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """The delay for which A + B exp(-j omega tau) vanishes at a frequency where both are of one size, and ``turn`` more turns.

    ``is_real`` : whether -A/B is a real number there, and so 1 or -1: balls around an angle of 0 or pi do not tell.
    """

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber
    turn: int
    multiple: Expr
    is_real: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            x = self.omega.ball(bits)
            real, imag = (part.ball(x) for part in self.ratio)
            angle = -acb(real, 0 if self.is_real else imag).arg()  # exp(-j omega tau) = -A/B
            return (angle + 2 * arb.pi() * self.turn) / (x * expression_ball(self.multiple))


@dataclass(frozen=True)
class Switches:
    """The first delays >= 0 at the frequencies where |A| = |B|, each with the sense in which |A/B| goes through 1 there.

    ``is_still`` : whether |A| and |B| differ at omega = 0.
    """

    firsts: tuple[DelayAt, ...]
    senses: tuple[int, ...]
    is_still: bool

    @classmethod
    def of(cls, loop: Loop) -> Switches:
        """Of a loop with an open delay and without a chain of roots on the right. UndecidedError where it has another form."""
        ratio, multiple = _ratio(loop)
        condition = minus(squared_modulus(ratio).function, Integer(1))
        settled = far(condition)
        if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            raise UndecidedError("where roots meet the imaginary axis")
        response = on_axis(ratio)
        functions = {"": RealFunction(condition.reduced()), "imag": response.imag}
        table = chart(functions, Integer(0), max(settled.radius, Integer(1)))
        if any("" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        first, *points = table.points
        found = [x for x in points if x.orders.get("", 0) > 0]
        real = [response.imag.is_zero or x.orders.get("imag", 0) > 0 for x in found]
        parts = response.real, response.imag
        each = (DelayAt(parts, x.omega, 0, multiple, is_real=y) for x, y in zip(found, real, strict=True))
        senses = tuple((x.after[""] - x.before[""]) // 2 for x in found)
        return cls(tuple(map(_first, each)), senses, first.orders.get("", 0) <= 0)

    def up_to(self, value: Expr) -> tuple[tuple[Meeting, ...], Rational | None]:
        """All delays >= 0 up to some turns beyond a value, and up to which delay these are all; None where no others come."""
        if not self.firsts:
            return (), None
        end = self._end(value)
        found = tuple(
            x
            for first, sense in self._each
            for x in _turned(first, _turns(first, end), sense if self.is_still else None)
        )
        last = min((2 * _turns(x, end) - 1) * 3.14 / _rate(x) for x in self.firsts)
        return found, Rational(last).limit_denominator(10**9)

    def _end(self, value: Expr) -> float:
        """As far as all that comes after can be told, if that is not too far."""
        last = self.unstable_from
        if last is None:
            return float(value)
        many = sum(float(last) * _rate(x) / 6.28 for x in self.firsts)
        return max(float(value), float(last)) if many < _MOST_FURTHER else float(value)

    @cached_property
    def unstable_from(self) -> Rational | None:
        """A delay beyond which there are roots on the right for all delays; None where that is not shown.

        Of a frequency whose delays begin at theta/omega, theta from 0 to 2 pi, at least (omega tau - theta)/(2 pi) have come at
        tau, and at most one more. So there are roots where the sum of senses omega tau is beyond what is lost at the beginning.
        """
        if not self.is_still:
            return None
        with flint.ctx.workprec(_BITS):
            slope, lost = arb(0), arb(0)
            for first, sense in self._each:
                rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
                slope += sense * rate
                lost += sense * _beginning(first.ball(_BITS) * rate) + (2 * arb.pi() if sense < 0 else 0)
            if not slope > 0:
                return None
            return Rational(str(float((lost / slope).upper()) * (1 + 1e-9))) + Rational(1, 10**12)

    def come(self, delay: RealNumber) -> int:
        """How many pairs of roots have come to the right less those that have gone, from a delay on up to the next; at least.

        ``delay`` : a number, or one of those at which roots switch sides. What stays open of a number is taken as gone.
        """
        passed = (_passed(x, delay, sense > 0, self._is_of(x, delay)) for x, sense in self._each)
        return sum(sense * n for (_, sense), n in zip(self._each, passed, strict=True))

    @property
    def _each(self) -> list[tuple[DelayAt, int]]:
        return [*zip(self.firsts, self.senses, strict=True)]

    def _is_of(self, first: DelayAt, delay: RealNumber) -> bool:
        """Whether a delay at which roots switch sides belongs to the frequency of the ``first``: to no other, that is."""
        if not isinstance(delay, DelayAt):
            return False
        near = [x for x in self.firsts if x.omega.ball(_BITS).overlaps(delay.omega.ball(_BITS))]
        return near == [first]


def _passed(first: DelayAt, delay: RealNumber, surely: bool, own: bool) -> int:  # noqa: FBT001
    """How many delays of a frequency are not beyond one; ``surely`` : of which that is shown, else of which it may be."""
    if own and isinstance(delay, DelayAt):
        return delay.turn - first.turn + 1
    with flint.ctx.workprec(_BITS):
        rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
        turns = (delay.ball(_BITS) - first.ball(_BITS)) * rate / (2 * arb.pi())
        return max(0, int((turns.lower() if surely else turns.upper()).floor().unique_fmpz()) + 1)


def _first(x: DelayAt) -> DelayAt:
    """Without a turn, or one turn later where that is negative."""
    return replace(x, turn=1) if x.ball(_BITS) < 0 else x


def _beginning(angle: Ball) -> Ball:
    """Of a frequency, the angle > 0 of the first delay that is one; all up to 2 pi where a ball does not tell."""
    return angle if angle > 0 else arb(0).union(2 * arb.pi())


def _rate(x: DelayAt) -> float:
    return float(x.omega) * float(x.multiple)


def _turns(x: DelayAt, end: float) -> int:
    return int(_rate(x) * end / 6.28) + _FURTHER


def _turned(first: DelayAt, turns: int, sense: int | None) -> Iterator[Meeting]:
    """Of one frequency, from its first delay on."""
    for turn in range(turns + 1):
        delay = replace(first, turn=first.turn + turn)
        if delay.ball(_BITS).is_zero():
            yield Meeting(ExactNumber(Integer(0)), first.omega)
        elif float(delay) > 0:
            yield Meeting(delay, first.omega, sense)


def _ratio(loop: Loop) -> tuple[RationalFunction, Expr]:
    """-A/B and how often the open delay is in the exponent."""
    ring, symbol = loop.ring, loop.symbol
    units = [i for i, lag in enumerate(ring.lags) if symbol in lag.free_symbols]
    if len(units) != 1 or any(symbol in x.free_symbols for x in ring.orders):
        raise UndecidedError("a number that is in several delays")
    rows = coefficients(loop.top, ring.size + units[0])
    late = [n for n, row in enumerate(rows) if n and row]
    if len(late) != 1:
        raise UndecidedError("a delay that comes back several times")
    multiple = late[0] * ring.lags[units[0]] / symbol
    if multiple.free_symbols or degree_in([loop.top], ring.meanings.index(symbol)):
        raise UndecidedError("a delay that comes back several times")
    plain = [ring.expression(x) for x in (rows[0], rows[-1])]
    target = Ring.of(plain)
    above, below = map(target.convert, plain)
    return (-above / below).reduced(), multiple
