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
of mathematical functions.
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

BLOCK = 4096
_SPLIT = 134217729.0  # 2^27 + 1: splits 53 bits into halves of 26, whose products are exact
# The error counted for a step, relative to its value; what underflow may cost; and a factor that
# covers the rounding of the bounds themselves, and low parts left out of them.
_STEP, _LOST, _UP = 2.0**-100, 2.0**-1060, 1 + 2.0**-40
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
    return s, (a - (s - c)) + (b - c)


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
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


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
    hi, lo = fast_two_sum(p, e + (x.hi * y.lo + x.lo * y.hi))
    if x.error is None:
        return Doubled(hi, lo, None)
    # |x y - x' y'| <= |x| dy + (|y| + dy) dx
    by_y, by_x = np.abs(x.hi) * y.error, (np.abs(y.hi) + y.error) * x.error
    return Doubled(hi, lo, _bound(hi, by_y, by_x))


def div(x: Doubled, y: Doubled) -> Doubled:
    """x / y; its bound is infinite where y may be 0."""
    # A float's quotient t, and one correction by its remainder (x - t y)/y.
    t = x.hi / y.hi
    p, e = two_product(t, y.hi)
    rest = ((x.hi - p) - e) + (x.lo - t * y.lo)
    hi, lo = fast_two_sum(t, rest / y.hi)
    if x.error is None:
        return Doubled(hi, lo, None)
    # |x/y - x'/y'| <= (dx + |x/y| dy)/(|y| - dy)
    below = np.abs(y.hi) - 2 * y.error  # less than |y| less its error, whatever its low part
    moved = (x.error + _LOST + np.abs(hi) * y.error * _UP) / below
    return Doubled(hi, lo, np.where(below > 0, _bound(hi, moved, 0.0), inf))


def sqrt(x: Doubled) -> Doubled:
    """The square root of x >= 0."""
    # A float's root s, and one step of Newton's method, (x - s^2)/(2 s).
    s = np.sqrt(x.hi)
    p, e = two_product(s, s)
    lo = np.where(s == 0, 0.0, (((x.hi - p) - e) + x.lo) / (2 * s))
    hi, lo = fast_two_sum(s, lo)
    if x.error is None:
        return Doubled(hi, lo, None)
    # |sqrt(x) - sqrt(x + d)| <= |d|/sqrt(x). Where x may be 0 the slope of the root has no bound.
    change = x.error + _LOST
    return Doubled(hi, lo, np.where(x.hi > 2 * change, _bound(hi, change / hi, 0.0), inf))


def _bound(value: Any, *carried: Any) -> Any:
    """A bound of the error of a result: what the errors of the operands make of it, and its own."""
    if carried[0] is None:
        return None
    return (carried[0] + carried[1] + np.abs(value) * _STEP) * _UP + _LOST


def of_ball(ball: Ball) -> tuple[float, float, float]:
    """hi, lo and a bound of the error of a number in a ball."""
    hi = float(ball)
    if not np.isfinite(hi):
        return nan, nan, inf
    rest = ball - arb(hi)
    lo = float(rest)
    return hi, lo, float(abs(rest - arb(lo)).upper()) * _UP + _LOST


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
            steps = enumerate(self.program.operations)
            return {
                i: self._of_ball(constant_ball(step.value))
                for i, step in steps
                if step.name == "constant"
            }

    def run(self, inputs: Sequence[Any], size: int) -> dict[str, Doubled]:
        """The results for inputs that are floats or arrays of that size."""
        names = list(self.program.results)
        results = {name: Doubled(np.empty(size), np.empty(size), np.empty(size)) for name in names}
        with np.errstate(all="ignore"):
            for start in range(0, size, BLOCK):
                part = slice(start, start + BLOCK)
                known = self._block([x if np.ndim(x) == 0 else x[part] for x in inputs])
                for name in names:
                    for whole, piece in zip(results[name], known[name], strict=True):
                        whole[part] = piece if piece is not None else nan
        return results

    def _block(self, inputs: Sequence[Any]) -> dict[str, Doubled]:
        """The results for one block; inputs are doubles, so they have no low part and no error."""
        floats = (np.asarray(x)[()] for x in inputs)  # a single number as a NumPy float
        given = [
            Doubled(x, np.zeros_like(x), np.zeros_like(x) if self.bounded else None) for x in floats
        ]
        by_balls = {name: partial(self._by_balls, function) for name, function in FUNCTIONS.items()}
        return self.program.run(by_balls | _ARITHMETIC, given, self.constants)

    def _by_balls(self, function: Callable[..., Ball], *arguments: Doubled) -> Doubled:
        """A function such as a sine or a power, evaluated in balls point by point."""
        # Three columns, hi, lo and error, for each argument; one row for each point.
        parts = [0.0 if x is None else x for argument in arguments for x in argument]
        columns = np.broadcast_arrays(*parts)
        shape = columns[0].shape
        rows = []
        with flint.ctx.workprec(_BITS):
            for row in zip(*(x.ravel().tolist() for x in columns), strict=True):
                balls = [_ball(row[n : n + 3]) for n in range(0, len(row), 3)]
                rows.append(of_ball(function(*balls)))
        if not rows:
            hi, lo, error = (np.empty(shape),) * 3
        else:
            hi, lo, error = (np.array(x).reshape(shape) for x in zip(*rows, strict=True))
        return Doubled(hi, lo, error if self.bounded else None)

    def _of_ball(self, ball: Ball) -> Doubled:
        hi, lo, error = of_ball(ball)
        return Doubled(np.float64(hi), np.float64(lo), np.float64(error) if self.bounded else None)


def _ball(row: Sequence[float]) -> Ball:
    hi, lo, error = row
    return arb(hi) + arb(lo, error) if error < inf else arb(nan)


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
        values = {name: self.constant(name, x) for name, x in doubled.items()}
        open_ = {name: ~self._proven(name, x) for name, x in doubled.items()}
        points = np.flatnonzero(np.logical_or.reduce(list(open_.values())))
        # Balls are slow, so they see only the points and the results that are left over.
        for n in points:
            point = tuple(float(x) if np.ndim(x) == 0 else float(x[n]) for x in inputs)
            names = [name for name in open_ if open_[name][n]]
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
        return (
            np.full_like(found.hi, nearest(step.value))
            if step.name == "constant"
            else found.hi.copy()
        )

    def _proven(self, name: str, x: Doubled) -> Any:
        """Where the high part alone is within one unit in the last place, also of the smaller
        binade at a power of 2."""
        if self.program.operations[self.program.results[name]].name == "constant":
            return np.ones(x.hi.shape, dtype=bool)
        # Comparisons with not-a-number are False: what overflowed stays open.
        size = np.abs(x.hi)
        with np.errstate(all="ignore"):
            return np.abs(x.lo) + x.error <= size - np.nextafter(size, 0)

    def at(self, inputs: tuple[float, ...], names: Sequence[str]) -> dict[str, float]:
        """The doubles nearest to results at one point, limits and poles included; not-a-number for
        inputs that are none."""
        if not np.isfinite(inputs).all():
            return dict.fromkeys(names, float("nan"))
        # Powers of omega are defined for omega >= 0 alone; H(-j omega) is the conjugate of H(j
        # omega).
        if inputs[0] < 0:
            mirrored = self.at((-inputs[0], *inputs[1:]), names)
            return {
                name: value if name in SQUARED or name.endswith("real") else -value
                for name, value in mirrored.items()
            }
        point, proven = BallPoint(self.program, inputs), {}
        for bits in _BITS_CERTIFIED:
            left = [name for name in names if name not in proven]
            if left:
                balls = point.balls(bits)
                rounded = {name: nearest_double(balls[name], bits) for name in left}
                proven.update({name: value for name, value in rounded.items() if value is not None})
        # What balls do not settle, such as 0, a pole, or 0/0 in the steps, the closed form may.
        return {
            name: proven[name] if name in proven else self._settled(inputs, name) for name in names
        }

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
        known = {
            x.name: Rational(*value)
            for x, value in zip(self.program.inputs[1:], values, strict=True)
        }
        return PointValue(self.forms(known)[name], fmpq(*frequency), name in SQUARED)

    def number(self, inputs: tuple[float, ...], name: str) -> RealNumber | float:
        """A result to any precision; a float where it is 0, infinite or not a number. SceneError
        for a negative frequency."""
        if inputs[0] < 0:
            raise SceneError(f"digits: omega = {inputs[0]} rad/s must be >= 0")
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
