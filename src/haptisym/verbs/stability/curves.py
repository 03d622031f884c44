"""The curve on which one open number puts roots on the imaginary axis: over frequency, the value that does it.

C(s; q) = A + q B is real on the axis where q = -Re(A/B) and Im(A/B) = 0: one equation in omega. Of a higher degree in q, real and
imaginary part have a root q in common where their resultant vanishes; their last remainder before it, linear in q, tells it.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Integer

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.alike import ordered
from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import Polynomial, RationalFunction
from haptisym.kernel.roots import Point, chart
from haptisym.verbs.stability.loops import Loop, coefficients


@dataclass(frozen=True)
class Meeting:
    """A ``value`` of the open number with roots on the axis at ``omega``, rad/s; None where they come from infinity.

    ``sense`` : how many pairs of roots go from its left to its right there as the number grows; None where that is not told.
    """

    value: RealNumber
    omega: RealNumber | None
    sense: int | None = None

    def is_like(self, other: Meeting) -> bool:
        """Whether both are alike as far as bits go."""
        if self.omega is None or other.omega is None:
            return self.omega is other.omega and not ordered(self.value, other.value)
        return not ordered(self.omega, other.omega) and not ordered(self.value, other.value)


@dataclass(frozen=True)
class Gap:
    """Values between two of which it is not known which ones put roots on the axis; None where nothing bounds them.

    ``reason`` : why; empty where they do at ever higher frequencies.
    """

    low: RealNumber | None
    high: RealNumber | None
    reason: str = ""

    def holds(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether all values between two others are in it."""
        above = self.low is None or (low is not None and ordered(self.low, low) >= 0)
        return above and (self.high is None or (high is not None and ordered(high, self.high) >= 0))


@dataclass(frozen=True)
class Meetings:
    """All, each once, ``above`` one value and ``below`` another, but for ``gaps``; None where nothing bounds them there.

    Values with a chain of infinitely many roots on the right need not be among them, but for those where it comes or goes.
    """

    found: tuple[Meeting, ...]
    above: Expr | None = None
    below: Expr | None = None
    gaps: tuple[Gap, ...] = ()


@dataclass(frozen=True)
class Curve:
    """Frequencies where ``condition`` vanishes, and the ``value`` of the open number there: functions of omega, over squares.

    ``square`` : of that value, there. ``is_linear`` : whether C is A + q B, -A/B being value - j condition.
    """

    condition: RationalFunction
    value: RationalFunction
    square: RationalFunction
    is_linear: bool = False

    def meetings(self, reach: Expr) -> tuple[Meeting, ...]:
        """All above 0 and up to a frequency; at 0 all is real, so that it tells nothing there."""
        value = RealFunction(self.value.reduced())
        table = chart({"0": RealFunction(self.condition.reduced()), "q": value}, Integer(0), reach)
        if any("0" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        places = [x for x in table.points[1:] if x.orders.get("0", 0) > 0 and x.orders.get("q", 0) >= 0]
        zero = ExactNumber(Integer(0))
        return tuple(
            Meeting(zero if x.orders.get("q") else ValueAt(value, x.omega), x.omega, self._sense(x)) for x in places
        )

    def _sense(self, place: Point) -> int | None:
        """To the right where -A/B, as omega grows, comes from below to above the real axis; a root that only touches it stays."""
        return (place.before["0"] - place.after["0"]) // 2 if self.is_linear else None


def minus(f: RationalFunction, number: Expr) -> RationalFunction:
    """A function less a number, over the same denominator."""
    shift = f.ring.convert(number)
    top = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(top, f.denominator * shift.denominator)


def curve_of(loop: Loop) -> Curve | None:
    """Of values other than delays; None where the open number moves no root."""
    powers = loop.powers
    if len(powers) < 2:
        return None
    if len(powers) == 2:
        ratio = RationalFunction(loop.ring, powers[0], powers[1]).reduced()
        below = on_axis(ratio)
        curve = Curve(below.raw_imag, -below.raw_real, squared_modulus(ratio).function, is_linear=True)
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
    if resultant.is_zero() or linear is None or not _is_apart(resultant, linear[1], axis):
        raise UndecidedError("where roots meet the imaginary axis")
    c0, c1 = linear
    return Curve(axis.function(resultant), axis.function(-c0 * c1, c1 * c1), axis.function(c0 * c0, c1 * c1))


def _is_apart(f: Polynomial, g: Polynomial, axis: Axis) -> bool:
    """Whether two polynomials are shown to have no zero > 0 in common: at one, more than one root would be."""
    shared = axis.function(f.gcd(g))
    settled = far(shared)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        return False
    table = chart({"": RealFunction(shared)}, Integer(0), max(settled.radius, Integer(1)))
    return not table.undecided and not any(x.orders.get("") for x in table.points[1:])


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
