"""At which values of one open number roots lie on the imaginary axis, and at which frequencies: all of them, certified."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import degree_in
from haptisym.kernel.roots import chart
from haptisym.verbs.stability.curves import Curve, Meeting, Meetings, curve_of, minus
from haptisym.verbs.stability.farout import from_infinity, is_neutral
from haptisym.verbs.stability.loops import Loop, coefficients
from haptisym.verbs.stability.neutral import neutral_meetings
from haptisym.verbs.stability.pairs import Characteristic
from haptisym.verbs.stability.search import searched

_WINDOWS = 12
_MOST_TURNING = 400  # radians that a delay turns up to where roots are looked for
_FURTHER = 8  # turns of a delay beyond its value
_LOWS = (Rational(15, 16), Rational(1, 2))
_BITS = 128
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


def meetings(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """Where an open number puts roots on the axis: all, or in windows that grow. UndecidedError where that is open.

    By one equation in omega as far as that goes, and from there on by a search over both.
    """
    is_whole = True
    try:
        for window in _eliminated(loop, value):
            yield window
            is_whole = not window.gaps
    except LimitError:
        raise
    except UndecidedError as error:
        if not is_whole:
            raise
        yield from searched(loop, value, str(error))


def _eliminated(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """By one equation in omega."""
    far_out = from_infinity(loop)
    if loop.turns:
        if _has_chain(loop, value):  # whatever the delay, as long as there is one
            yield Meetings((*far_out, Meeting(ExactNumber(Integer(0)), None)))
        else:
            yield _of_a_delay(loop, value, far_out)
        return
    if len(loop.powers) > 2:  # at omega = 0 one of the two equations is no condition
        far_out = (*far_out, *(Meeting(x, ExactNumber(Integer(0))) for x in Characteristic(loop).at_0()))
    curve = curve_of(loop)
    if curve is None:
        yield Meetings(far_out)
        return
    if curve.condition.is_zero:  # one value alone puts roots there, everywhere
        here = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield Meetings((*far_out, Meeting(here, None)))
        return
    settled = far(curve.condition)
    if settled.sense in _SETTLED:
        yield Meetings((*far_out, *curve.meetings(_near(settled.radius, loop))))
        return
    if is_neutral(loop):
        yield from neutral_meetings(loop, curve, far_out)
    else:
        yield from _windows(loop, curve, value, far_out)


def _near(radius: Expr, loop: Loop) -> Expr:
    """How far to look; UndecidedError where delays turn too often on the way."""
    if any(float(radius * lag) > _MOST_TURNING for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _windows(loop: Loop, curve: Curve, value: Expr, far_out: tuple[Meeting, ...]) -> Iterator[Meetings]:
    """Where frequencies never end: as far as values lie in a window, about the value that is asked about."""
    done = False
    for j in range(_WINDOWS):
        high, low = (
            abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2),
            value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0),
        )
        for end, sense in ((high, Sense.POSITIVE), (low, Sense.NEGATIVE)):
            ahead = far(minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                found = (*far_out, *curve.meetings(_near(ahead.radius, loop)))
                done = True
                yield Meetings(found, -high, high) if end is high else Meetings(found, low)
    if not done:
        raise UndecidedError("where roots meet the imaginary axis at ever higher frequencies")


# A delay that is open


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether infinitely many roots lie on the right, or come to the axis, at a delay > 0: at all of them, or at none."""
    with suppress(UndecidedError):
        return loop.at(Rational(value) if value.is_Rational and value else Integer(1)).chain is not None
    return False


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


def _of_a_delay(loop: Loop, value: Expr, far_out: tuple[Meeting, ...]) -> Meetings:
    """The nearest delays about one that is asked about."""
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
    ratio = (-above / below).reduced()
    size = squared_modulus(ratio).function
    condition = minus(size, Integer(1))
    settled = far(condition)
    if settled.sense not in _SETTLED:
        raise UndecidedError("where roots meet the imaginary axis")
    response = on_axis(ratio)
    functions = {"": RealFunction(condition.reduced()), "imag": response.imag}
    table = chart(functions, Integer(0), max(settled.radius, Integer(1)))
    if any("" in point.undecided for point in table.points):
        raise UndecidedError("whether a root touches the imaginary axis")
    points = [x for x in table.points[1:] if x.orders.get("", 0) > 0]
    places = [x.omega for x in points]
    real = [response.imag.is_zero or x.orders.get("imag", 0) > 0 for x in points]
    parts = response.real, response.imag
    firsts = [DelayAt(parts, x, 0, multiple, is_real=y) for x, y in zip(places, real, strict=True)]
    found = [x for first in firsts for x in _turned(first, value)]
    ends = [(2 * _most(omega, multiple, value) - 1) * 3.14 / (float(omega) * float(multiple)) for omega in places]
    return Meetings((*far_out, *found), below=Rational(min(ends)).limit_denominator(10**9) if ends else None)


def _most(omega: RealNumber, multiple: Expr, value: Expr) -> int:
    """Turns of a frequency that are looked at: some beyond those of the value."""
    return int(float(omega) * float(value * multiple) / 6.28) + _FURTHER


def _turned(first: DelayAt, value: Expr) -> Iterator[Meeting]:
    """Of one frequency, the delays >= 0 up to some turns beyond a value, from that without a turn on."""
    for turn in range(_most(first.omega, first.multiple, value) + 1):
        delay = replace(first, turn=turn)
        if delay.ball(_BITS).is_zero():
            yield Meeting(ExactNumber(Integer(0)), first.omega)
        elif float(delay) > 0:
            yield Meeting(delay, first.omega)
