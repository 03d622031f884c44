"""Floats that are proven, point by point: double-doubles with a bound of their error, and balls for
what that leaves open.

A number is the unevaluated sum hi + lo of two doubles, ``|lo| <= ulp(hi)/2``. Sums, products,
quotients and roots are those of Joldes, Muller and Popescu, "Tight and rigorous error bounds for
basic building blocks of double-word arithmetic" (2017), algorithms 6, 10 and 17; products of floats
without fused multiply-add after Dekker (1971). Their relative errors are at most 3, 7 and 15 times
2^-106; here 2^-100 is counted for each, and 2^-1060 for what may be lost to underflow, which
together leave room for the rounding of the bounds themselves. What overflows becomes not-a-number,
with no bound.

Sines, cosines and powers are taken by ball arithmetic, point by point: no bound rests on a library
of mathematical functions. A *ball* is an interval of any precision, middle and radius (``arb`` of
FLINT).

Begin with ``Certified.run``: double-doubles settle most points (``Doubles``), balls the rest
(``Certified.at``), and the closed form what balls cannot, such as an exact zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import inf, nan
from typing import Any, NamedTuple, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Rational

from haptisym.kernel.arrays import np
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import Ball, RealNumber
from haptisym.programs.balls import FUNCTIONS, BallPoint, PointValue, constant_ball, nearest_double
from haptisym.programs.floats import nearest
from haptisym.programs.program import Program

BLOCK = 4096  # points that run through a program together
_SPLIT = 134217729.0  # 2^27 + 1: splits 53 bits into halves of 26, whose products are exact
_STEP = 2.0**-100  # the error counted for a step, relative to its value
_LOST = 2.0**-1060  # what underflow may cost
# Covers the rounding of the bounds themselves, and low parts left out of them.
_UP = 1 + 2.0**-40
_BITS = 140  # of the balls that stand for sines, cosines and powers


class Doubled(NamedTuple):
    """A number as hi + lo, and ``error``, a bound of its distance from the true value: None, in all
    numbers alike, where errors are not tracked."""

    hi: Any
    lo: Any
    error: Any


def two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """s + e = a + b exactly, s the rounded sum.

    >>> two_sum(1.0, 2.0**-60)
    (1.0, 8.673617379884035e-19)
    """
    s = a + b
    c = s - a
    lost_of_a = a - (s - c)
    return s, lost_of_a + (b - c)


def fast_two_sum(a: Any, b: Any) -> tuple[Any, Any]:
    """The same where ``|a| >= |b|``."""
    s = a + b
    return s, b - (s - a)


def two_product(a: Any, b: Any) -> tuple[Any, Any]:
    """p + e = a b exactly, p the rounded product, while nothing over- or underflows.

    >>> two_product(1 + 2.0**-30, 1 + 2.0**-30) == (1 + 2.0**-29, 2.0**-60)
    True
    """
    p = a * b
    a1, a2 = _halves(a)
    b1, b2 = (a1, a2) if a is b else _halves(b)
    # In this order, from the largest product to the smallest, every sum is exact.
    rest = (a1 * b1 - p) + a1 * b2 + a2 * b1
    return p, rest + a2 * b2


def _halves(a: Any) -> tuple[Any, Any]:
    c = _SPLIT * a
    high = c - (c - a)
    return high, a - high


def _sum(x: Doubled, y: Doubled) -> tuple[Any, Any]:
    s, e = two_sum(x.hi, y.hi)
    t, f = two_sum(x.lo, y.lo)
    v, w = fast_two_sum(s, e + t)
    return fast_two_sum(v, f + w)


def add(x: Doubled, y: Doubled) -> Doubled:
    """x + y."""
    hi, lo = _sum(x, y)
    return Doubled(hi, lo, _bound(hi, x.error, y.error))


def sub(x: Doubled, y: Doubled) -> Doubled:
    """x - y."""
    return add(x, neg(y))


def neg(x: Doubled) -> Doubled:
    """-x, exactly."""
    return Doubled(-x.hi, -x.lo, x.error)


def absolute(x: Doubled) -> Doubled:
    """|x|, exactly."""
    sign = np.where(x.hi < 0, -1.0, 1.0)
    return Doubled(sign * x.hi, sign * x.lo, x.error)


def mul(x: Doubled, y: Doubled) -> Doubled:
    """x y."""
    # The product of both low parts is below 2^-106 of the whole, and is left out.
    p, e = two_product(x.hi, y.hi)
    mixed = x.hi * y.lo + x.lo * y.hi
    hi, lo = fast_two_sum(p, e + mixed)
    if x.error is None:
        return Doubled(hi, lo, None)
    # |x y - x' y'| <= |x| dy + (|y| + dy) dx
    by_y = np.abs(x.hi) * y.error
    largest_y = np.abs(y.hi) + y.error
    return Doubled(hi, lo, _bound(hi, by_y, largest_y * x.error))


def div(x: Doubled, y: Doubled) -> Doubled:
    """x / y; its bound is infinite where y may be 0."""
    # A float's quotient t, and one correction by its remainder (x - t y)/y.
    t = x.hi / y.hi
    p, e = two_product(t, y.hi)
    rest = (x.hi - p) - e
    rest = rest + (x.lo - t * y.lo)
    hi, lo = fast_two_sum(t, rest / y.hi)
    if x.error is None:
        return Doubled(hi, lo, None)
    # |x/y - x'/y'| <= (dx + |x/y| dy)/(|y| - dy)
    below = np.abs(y.hi) - 2 * y.error  # less than |y| less its error, whatever its low part
    carried = np.abs(hi) * y.error * _UP
    moved = (x.error + _LOST + carried) / below
    bound = _bound(hi, moved, 0.0)
    return Doubled(hi, lo, np.where(below > 0, bound, inf))


def sqrt(x: Doubled) -> Doubled:
    """The square root of x >= 0."""
    # A float's root s, and one step of Newton's method, (x - s^2)/(2 s).
    s = np.sqrt(x.hi)
    p, e = two_product(s, s)
    rest = ((x.hi - p) - e) + x.lo
    lo = np.where(s == 0, 0.0, rest / (2 * s))
    hi, lo = fast_two_sum(s, lo)
    if x.error is None:
        return Doubled(hi, lo, None)
    # |sqrt(x) - sqrt(x + d)| <= |d|/sqrt(x). Where x may be 0 the slope of the root has no bound.
    change = x.error + _LOST
    bound = _bound(hi, change / hi, 0.0)
    return Doubled(hi, lo, np.where(x.hi > 2 * change, bound, inf))


def _bound(value: Any, by_x: Any, by_y: Any) -> Any:
    """A bound of the error of a result: what the errors of the operands make of it, and its own.
    None where errors are not tracked."""
    if by_x is None:
        return None
    total = by_x + by_y + np.abs(value) * _STEP
    return total * _UP + _LOST


def of_ball(ball: Ball) -> tuple[float, float, float]:
    """hi, lo and a bound of the error of a number in a ball."""
    hi = float(ball)
    if not np.isfinite(hi):
        return nan, nan, inf
    rest = ball - arb(hi)
    lo = float(rest)
    distance = abs(rest - arb(lo)).upper()
    return hi, lo, float(distance) * _UP + _LOST


_ARITHMETIC: dict[str, Callable[..., Doubled]] = {
    "add": add,
    "sub": sub,
    "mul": mul,
    "div": div,
    "neg": neg,
    "abs": absolute,
    "sqrt": sqrt,
}


@dataclass(frozen=True)
class Doubles:
    """A program in double-doubles, with bounds of the errors if ``bounded``."""

    program: Program
    bounded: bool

    @cached_property
    def constants(self) -> dict[int, Doubled]:
        """The program's constants, each with the bound of what a pair of doubles leaves of it."""
        with flint.ctx.workprec(_BITS):
            constants = {}
            for i, step in enumerate(self.program.operations):
                if step.name == "constant":
                    constants[i] = self._of_ball(constant_ball(step.value))
            return constants

    def run(self, inputs: Sequence[Any], size: int) -> dict[str, Doubled]:
        """The results for inputs that are floats or arrays of that size."""
        names = list(self.program.results)
        results = {}
        for name in names:
            results[name] = Doubled(np.empty(size), np.empty(size), np.empty(size))
        with np.errstate(all="ignore"):
            for start in range(0, size, BLOCK):
                part = slice(start, start + BLOCK)
                of_block = [x if np.ndim(x) == 0 else x[part] for x in inputs]
                known = self._block(of_block)
                for name in names:
                    for whole, piece in zip(results[name], known[name], strict=True):
                        whole[part] = piece if piece is not None else nan
        return results

    def _block(self, inputs: Sequence[Any]) -> dict[str, Doubled]:
        """The results for one block; inputs are doubles, so they have no low part and no error."""
        given = []
        for x in inputs:
            hi = np.asarray(x)[()]  # a single number as a NumPy float
            error = np.zeros_like(hi) if self.bounded else None
            given.append(Doubled(hi, np.zeros_like(hi), error))
        by_balls = {name: partial(self._by_balls, function) for name, function in FUNCTIONS.items()}
        # What both have is done in double-doubles.
        operations = by_balls | _ARITHMETIC
        return self.program.run(operations, given, self.constants)

    def _by_balls(self, function: Callable[..., Ball], *arguments: Doubled) -> Doubled:
        """A function such as a sine or a power, evaluated in balls point by point."""
        # Three columns, hi, lo and error, for each argument; one row for each point.
        parts = [0.0 if x is None else x for argument in arguments for x in argument]
        columns = np.broadcast_arrays(*parts)
        shape = columns[0].shape
        flat = [x.ravel().tolist() for x in columns]
        rows = []
        with flint.ctx.workprec(_BITS):
            for row in zip(*flat, strict=True):
                balls = [_ball(row[n : n + 3]) for n in range(0, len(row), 3)]
                rows.append(of_ball(function(*balls)))
        if rows:
            results = zip(*rows, strict=True)
            hi, lo, error = (np.array(x).reshape(shape) for x in results)
        else:
            hi = lo = error = np.empty(shape)
        return Doubled(hi, lo, error if self.bounded else None)

    def _of_ball(self, ball: Ball) -> Doubled:
        """The double-double nearest to a number in a ball."""
        hi, lo, error = (np.float64(x) for x in of_ball(ball))
        return Doubled(hi, lo, error if self.bounded else None)


def _ball(row: Sequence[float]) -> Ball:
    """A ball that holds the number hi + lo with that error; all numbers where the error is
    infinite."""
    hi, lo, error = row
    if error < inf:
        return arb(hi) + arb(lo, error)
    return arb(nan)


FormsAt: TypeAlias = Callable[[Mapping[str, Rational]], Mapping[str, RealFunction]]
"""The closed forms in lowest terms for exact numbers of the parameters; of the ratios their
squares."""
SQUARED = ("ratio_real", "ratio_imag")
"""The fields whose closed form is given by its square."""
_BITS_CERTIFIED = (128, 512, 2048)


@dataclass(frozen=True, eq=False)
class Certified:
    """The results of a program to within one unit in the last place, each of them proven."""

    program: Program
    forms: FormsAt

    def run(self, inputs: Sequence[Any], size: int) -> tuple[dict[str, Any], int]:
        """The doubles by name, and how many points needed balls; inputs are floats or arrays of
        that size."""
        doubled = self.doubles.run(inputs, size)
        values = {}
        left = {}
        for name, x in doubled.items():
            values[name] = self.constant(name, x)
            left[name] = ~self._proven(name, x)
        anywhere = np.logical_or.reduce(list(left.values()))
        points = np.flatnonzero(anywhere)
        # Balls are slow, so they see only the points and the results that are left over.
        for n in points:
            point = tuple(float(x) if np.ndim(x) == 0 else float(x[n]) for x in inputs)
            names = [name for name in left if left[name][n]]
            for name, value in self.at(point, names).items():
                values[name][n] = value
        return values, len(points)

    @cached_property
    def doubles(self) -> Doubles:
        """The same program in pairs of doubles, with the bounds of their errors."""
        return Doubles(self.program, bounded=True)

    def constant(self, name: str, found: Doubled) -> Any:
        """A result that is the same for all arguments is rounded once, from its exact value."""
        step = self.program.operations[self.program.results[name]]
        if step.name == "constant":
            return np.full_like(found.hi, nearest(step.value))
        return found.hi.copy()

    def _proven(self, name: str, x: Doubled) -> Any:
        """Where the high part alone is within one unit in the last place, also of the smaller
        binade at a power of 2."""
        step = self.program.operations[self.program.results[name]]
        if step.name == "constant":
            return np.ones(x.hi.shape, dtype=bool)
        # Comparisons with not-a-number are False: what overflowed stays open.
        size = np.abs(x.hi)
        with np.errstate(all="ignore"):
            unit_below = size - np.nextafter(size, 0)
            return np.abs(x.lo) + x.error <= unit_below

    def at(self, inputs: tuple[float, ...], names: Sequence[str]) -> dict[str, float]:
        """The doubles nearest to results at one point, limits and poles included; not-a-number for
        inputs that are none."""
        if not np.isfinite(inputs).all():
            return dict.fromkeys(names, float("nan"))
        # Powers of omega are defined for omega >= 0 alone; H(-j omega) is the conjugate of H(j
        # omega).
        frequency, *parameters = inputs
        if frequency < 0:
            values = {}
            for name, value in self.at((-frequency, *parameters), names).items():
                is_even = name in SQUARED or name.endswith("real")
                values[name] = value if is_even else -value
            return values
        point = BallPoint(self.program, inputs)
        proven: dict[str, float] = {}
        for bits in _BITS_CERTIFIED:
            left = [name for name in names if name not in proven]
            if not left:
                break
            balls = point.balls(bits)
            for name in left:
                rounded = nearest_double(balls[name], bits)
                if rounded is not None:
                    proven[name] = rounded
        # What balls do not settle, such as 0, a pole, or 0/0 in the steps, the closed form may.
        for name in names:
            if name not in proven:
                proven[name] = self._settled(inputs, name)
        return {name: proven[name] for name in names}

    def _settled(self, inputs: tuple[float, ...], name: str) -> float:
        """The double nearest to a result, from its closed form; not a number where that is
        undecided."""
        try:
            return float(self.exact(inputs, name))
        except UndecidedError:
            return float("nan")

    def exact(self, inputs: tuple[float, ...], name: str) -> PointValue:
        """A result from its closed form in lowest terms."""
        # Every double is a rational number, so the arguments are exact.
        frequency, *values = (x.as_integer_ratio() for x in inputs)
        _, *parameters = self.program.inputs
        known = {}
        for parameter, value in zip(parameters, values, strict=True):
            known[parameter.name] = Rational(*value)
        form = self.forms(known)[name]
        return PointValue(form, fmpq(*frequency), name in SQUARED)

    def number(self, inputs: tuple[float, ...], name: str) -> RealNumber | float:
        """A result to any precision; a float where it is 0, infinite or not a number. SceneError
        for a negative frequency."""
        frequency = inputs[0]
        if frequency < 0:
            raise SceneError(f"digits: omega = {frequency} rad/s must be >= 0")
        if not np.isfinite(inputs).all():
            return float("nan")
        # No ball shows that a result is exactly 0, however narrow it is: the closed form does.
        value = ProgramValue(BallPoint(self.program, inputs), name)
        ball = value.ball(_BITS_CERTIFIED[1])
        if ball.is_finite() and not ball.contains(0):
            return value
        exact = self.exact(inputs, name)
        return exact if exact.special is None else exact.special


@dataclass(frozen=True, slots=True, repr=False)
class ProgramValue(RealNumber):
    """One result of a program at one point."""

    point: BallPoint
    name: str

    def ball(self, bits: int) -> Ball:
        return self.point.balls(bits)[self.name]
