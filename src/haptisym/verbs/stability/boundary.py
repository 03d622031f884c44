"""At which values of one open number roots lie on the imaginary axis, and at which frequencies: all of them, certified.

C(s; q) = A + q B is real on the axis where q = -Re(A/B) and Im(A/B) = 0: one equation in omega. Of a higher degree in q, real and
imaginary part have a root q in common where their resultant vanishes; their last remainder before it, linear in q, tells it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in
from haptisym.kernel.roots import chart
from haptisym.verbs.stability.loops import Loop, coefficients

_WINDOWS = 12
_MOST_TURNING = 400  # radians that a delay turns up to where roots are looked for
_FURTHER = 8  # turns of a delay beyond its value
_LOWS = (Rational(15, 16), Rational(1, 2))
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


@dataclass(frozen=True)
class Meeting:
    """A ``value`` of the open number with roots on the axis at ``omega``, rad/s; None where they come from infinity."""

    value: RealNumber
    omega: RealNumber | None


@dataclass(frozen=True)
class Meetings:
    """All of them ``above`` one value and ``below`` another; None where nothing bounds them on that side."""

    found: tuple[Meeting, ...]
    above: Expr | None = None
    below: Expr | None = None


@dataclass(frozen=True)
class Curve:
    """Frequencies where ``condition`` vanishes, and the ``value`` of the open number there: functions of omega, over squares.

    ``square`` : of that value, there.
    """

    condition: RationalFunction
    value: RationalFunction
    square: RationalFunction

    def meetings(self, reach: Expr) -> tuple[Meeting, ...]:
        """All up to a frequency."""
        value = RealFunction(self.value.reduced())
        table = chart({"0": RealFunction(self.condition.reduced()), "q": value}, Integer(0), reach)
        if any("0" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        places = [x for x in table.points if x.orders.get("0", 0) > 0 and x.orders.get("q", 0) >= 0]
        first = table.points[0]
        if first not in places and first.orders.get("q", 0) >= 0:
            places.append(first)  # at omega = 0 every characteristic function is real
        zero = ExactNumber(Integer(0))
        return tuple(Meeting(zero if x.orders.get("q") else ValueAt(value, x.omega), x.omega) for x in places)


def meetings(loop: Loop, value: Expr) -> Iterator[Meetings]:
    """Where an open number puts roots on the axis: all, or in windows that grow. UndecidedError where that is open."""
    far_out = from_infinity(loop)
    if loop.turns:
        yield _of_a_delay(loop, value, far_out)
        return
    curve = _curve(loop)
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
    yield from _windows(loop, curve, value, far_out)


def _near(radius: Expr, loop: Loop) -> Expr:
    """How far to look; UndecidedError where delays turn too often on the way."""
    if any(float(radius * lag) > _MOST_TURNING for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def from_infinity(loop: Loop) -> tuple[Meeting, ...]:
    """The values at which a root, or a chain of them, comes from infinity."""
    return tuple(Meeting(x, None) for x in loop.far_out())


def _windows(loop: Loop, curve: Curve, value: Expr, far_out: tuple[Meeting, ...]) -> Iterator[Meetings]:
    """Where frequencies never end: as far as values lie in a window, about the value that is asked about."""
    done = False
    for j in range(_WINDOWS):
        high, low = (
            abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2),
            value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0),
        )
        for end, sense in ((high, Sense.POSITIVE), (low, Sense.NEGATIVE)):
            ahead = far(_minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                found = (*far_out, *curve.meetings(_near(ahead.radius, loop)))
                done = True
                yield Meetings(found, -high, high) if end is high else Meetings(found, low)
    if not done:
        raise UndecidedError("where roots meet the imaginary axis at ever higher frequencies")


def _minus(f: RationalFunction, number: Expr) -> RationalFunction:
    shift = f.ring.convert(number)
    top = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(top, f.denominator * shift.denominator)


def _curve(loop: Loop) -> Curve | None:
    """Of values other than delays; None where the open number moves no root."""
    powers = loop.powers
    if len(powers) < 2:
        return None
    if len(powers) == 2:
        ratio = RationalFunction(loop.ring, powers[0], powers[1]).reduced()
        below = on_axis(ratio)
        curve = Curve(below.raw_imag, -below.raw_real, squared_modulus(ratio).function)
    else:
        curve = _eliminated(loop)
    if not curve.condition.is_zero:
        return curve
    slope = (
        RealFunction(curve.value.reduced()).derivative().function
    )  # on the axis at all of its values: where these turn
    return Curve(
        slope.ring.function(slope.numerator * slope.denominator, slope.denominator**2), curve.value, curve.square
    )


def _eliminated(loop: Loop) -> Curve:
    axis = loop.ring.axis
    [(real, imag)] = axis.parts([loop.top])
    index = axis.meanings.index(loop.symbol)
    common = real.gcd(imag)
    real, imag = real / common, imag / common
    resultant = real.resultant(imag, f"x{index}")
    linear = _remainder(real, imag, index)
    if resultant.is_zero() or linear is None:
        raise UndecidedError("where roots meet the imaginary axis")
    c0, c1 = linear
    return Curve(axis.function(resultant), axis.function(-c0 * c1, c1 * c1), axis.function(c0 * c0, c1 * c1))


def _remainder(f: Polynomial, g: Polynomial, index: int) -> tuple[Polynomial, Polynomial] | None:
    """Of Euclid's algorithm in one variable, the remainder that is linear in it; None where there is none."""
    while True:
        a, b = coefficients(f, index), coefficients(g, index)
        if len(a) < len(b):
            f, g = g, f
            continue
        if len(b) == 2:
            return b[0], b[1]
        if len(b) < 2:
            return None
        x = f.context().gens()[index]
        while len(a) >= len(b) and not f.is_zero():
            f = b[-1] * f - a[-1] * x ** (len(a) - len(b)) * g
            a = coefficients(f, index)
        if f.is_zero():
            return None
        f, g = g, f


# A delay that is open


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """The delay for which A + B exp(-j omega tau) vanishes at a frequency where both are of one size, and ``turn`` more turns."""

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber
    turn: int
    multiple: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            x = self.omega.ball(bits)
            angle = -acb(*(part.ball(x) for part in self.ratio)).arg()  # exp(-j omega tau) = -A/B
            return (angle + 2 * arb.pi() * self.turn) / (x * expression_ball(self.multiple))


def _of_a_delay(loop: Loop, value: Expr, far_out: tuple[Meeting, ...]) -> Meetings:
    """The nearest delays about one that is asked about."""
    ring, symbol = loop.ring, loop.symbol
    units = [i for i, lag in enumerate(ring.lags) if symbol in lag.free_symbols]
    if len(units) != 1 or any(symbol in x.free_symbols for x in ring.orders):
        raise UndecidedError("a number that is in several delays")
    rows = coefficients(loop.top, ring.size + units[0])
    multiple = ring.lags[units[0]] / symbol
    if len(rows) != 2 or multiple.free_symbols or degree_in([loop.top], ring.meanings.index(symbol)):
        raise UndecidedError("a delay that comes back several times")
    plain = [ring.expression(x) for x in rows]
    target = Ring.of(plain)
    above, below = map(target.convert, plain)
    ratio = (-above / below).reduced()
    size = squared_modulus(ratio).function
    condition = _minus(size, Integer(1))
    settled = far(condition)
    if settled.sense not in _SETTLED:
        raise UndecidedError("where roots meet the imaginary axis")
    response = on_axis(ratio)
    table = chart({"": RealFunction(condition.reduced())}, Integer(0), max(settled.radius, Integer(1)))
    places = [x.omega for x in table.points[1:] if x.orders.get("", 0) > 0]
    parts = response.real, response.imag
    found = [x for omega in places for x in _turned(parts, omega, multiple, value)]
    ends = [(2 * _most(omega, multiple, value) - 1) * 3.14 / (float(omega) * float(multiple)) for omega in places]
    return Meetings((*far_out, *found), below=Rational(min(ends)).limit_denominator(10**9) if ends else None)


def _most(omega: RealNumber, multiple: Expr, value: Expr) -> int:
    """Turns of a frequency that are looked at: some beyond those of the value."""
    return int(float(omega) * float(value * multiple) / 6.28) + _FURTHER


def _turned(parts: tuple[RealFunction, RealFunction], omega: RealNumber, multiple: Expr, value: Expr) -> list[Meeting]:
    """Of one frequency, the delays > 0 up to some turns beyond a value."""
    every = (DelayAt(parts, omega, turn, multiple) for turn in range(_most(omega, multiple, value) + 1))
    return [Meeting(x, omega) for x in every if float(x) > 0]
