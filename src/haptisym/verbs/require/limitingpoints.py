"""Where conditions bind, for all values of a parameter in a cell: functions of frequency in balls, edges, maxima, corners.

A real function of frequency over an interval of values of one parameter, in balls: for scenes with delays and powers.

The condition N(omega, t) <= 0 is written as a sum of p(omega, t) sin^k cos^(n - k) omega^(alpha l), the waves those of half the
angles omega tau; n is even, so that the sign is that of the condition itself. Over a ball of values of t this is an analytic
function of omega with balls for coefficients. Without waves and powers it is a polynomial in both, which Bernstein coefficients
bound over cells as wide as they come (``Sheet``): fu2019 with omega_n free takes 991 boxes, by balls alone 23,839.

A real function of frequency for all values of a parameter in a cell, and the values at which it binds there.

Where two functions that must not both be positive bind together: one rises over the zero of the other, which falls.

Where on a band a condition can bind, for all values of a parameter in a cell: edges, single maxima, and corners.

A condition of several functions, which must not all be positive, is kept where one of them is negative; where all others are
positive, the one that is left decides. A corner is where two decide, of which one rises and the other falls.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from fractions import Fraction
from functools import cache, cached_property, lru_cache, reduce
from math import factorial
from operator import sub
from typing import TypeAlias

import flint
from flint import arb, arb_poly
from sympy import Expr, Rational, Symbol

from haptisym.judge.bindings import Kind
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import Waiting
from haptisym.kernel.delayterms import CompiledWaves
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.enclosures import Sheet, range_of
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.kernel.zeros import rounded_up, tightened

_Waves: TypeAlias = tuple[int, ...]
_Rows: TypeAlias = Mapping[tuple[_Waves, _Waves], list[arb_poly]]


@dataclass(frozen=True, order=True)
class _Exponent:
    """A power of omega in a term: a number, and how often it holds each omega^alpha whose order is not known as one."""

    known: Fraction
    open: tuple[int, ...]

    def __sub__(self, other: _Exponent) -> _Exponent:
        return _Exponent(self.known - other.known, tuple(map(sub, self.open, other.open)))

    def over(self, orders: Sequence[Ball]) -> Ball:
        """Its values for all orders in balls."""
        known = arb(self.known.numerator) / self.known.denominator
        return sum((order * n for order, n in zip(orders, self.open, strict=True) if n), known)


@dataclass(frozen=True, eq=False)
class Shape:
    """What stands above the line of a real function of omega and one parameter."""

    polynomial: Polynomial
    axis: Axis
    free: Symbol
    degrees: tuple[int, ...]
    """Of the waves of each angle: even, and at least that of the polynomial in the tangent of half the angle."""

    @classmethod
    def of(cls, function: RealFunction, free: Symbol) -> Shape:
        """Of a function whose zeros over omega and the free number are asked."""
        axis, numerator = function.axis, function.function.numerator
        turns = [int(n) for n in numerator.degrees()[axis.size : axis.size + len(axis.angles)]]
        return cls(numerator, axis, free, tuple(n + n % 2 for n in turns))

    @cached_property
    def change(self) -> Shape | None:
        """The derivative in the parameter; None where it is the order of a power, or where nothing depends on it.

        d tan(a/2) = (1 + tan(a/2)^2) da/2, and d cos(a/2)^n = -n tan(a/2) cos(a/2)^n da/2.
        """
        axis = self.axis
        if any(order.has(self.free) for order in axis.orders):
            return None
        index = axis.meanings.index(self.free)
        total = self.polynomial.derivative(index)
        for i, (angle, n) in enumerate(zip(axis.angles, self.degrees, strict=True), axis.size):
            if not angle.constant and angle.rate.has(self.free):
                t = axis.context.gens()[i]
                rate = axis.convert(angle.rate.diff(self.free) / 2)  # a number, as delays are multiples of one time
                half = axis.variable * rate.numerator / rate.denominator
                total += ((1 + t**2) * self.polynomial.derivative(i) - n * t * self.polynomial) * half
        return None if total.is_zero() else Shape(total, axis, self.free, self.degrees)

    @cached_property
    def is_fixed(self) -> bool:
        """Whether the parameter is nowhere in it."""
        axis = self.axis
        inside = any(x.has(self.free) for x in (*axis.orders, *(a.rate for a in axis.angles)))
        return not inside and not self.polynomial.degrees()[axis.meanings.index(self.free)]

    @cached_property
    def order_at_zero(self) -> Fraction:
        """A power of omega that every term holds, by itself, in sines and in omega^alpha, whatever the parameter.

        A hold divides by one, and an environment that has no force at rest begins with one.
        """
        return min(x.known for x in self._exponents)

    @cached_property
    def is_even(self) -> bool:
        """Whether the function over that power of omega is one of omega^2; not where there are powers of omega."""
        return not any((x.known - self.order_at_zero) % 2 for x in self._exponents)

    @cached_property
    def _exponents(self) -> set[_Exponent]:
        """Of omega, with which the terms begin."""
        axis = self.axis
        turning = [i for i, angle in enumerate(axis.angles, axis.size) if not angle.constant]
        first = axis.size + len(axis.angles)
        monoms = [[int(n) for n in e] for e in self.polynomial.monoms()]
        return {self._exponent(e[0] + sum(e[i] for i in turning), e[first:]) for e in monoms}

    def _exponent(self, n: int, powers: Sequence[int]) -> _Exponent:
        """Of omega in omega^n and products of omega^alpha."""
        own = list(zip(self.axis.orders, powers, strict=True))
        known = sum((Fraction(a.p, a.q) * k for a, k in own if isinstance(a, Rational)), Fraction(n))
        return _Exponent(known, tuple(0 if isinstance(a, Rational) else k for a, k in own))

    def _least(self, orders: Sequence[Ball]) -> _Exponent:
        """An exponent of omega that is nowhere less in another term, for all orders of powers in balls."""
        for x in sorted(self._exponents):
            if all(y == x or (y - x).over(orders) >= 0 for y in self._exponents):
                return x
        return _Exponent(self.order_at_zero, (0,) * len(orders))

    def seen_at(self, compiled: CompiledWaves, at: Ball) -> Ball:
        """The value of the function, or of its derivative in the parameter, at a frequency; at 0 as ``from_zero``."""
        return self.from_zero(compiled, at) if at.is_zero() else compiled.value(at)

    def from_zero(self, compiled: CompiledWaves, end: Ball) -> Ball:
        """A ball around the values from omega = 0 to a number, over the power of omega with which the function begins there.

        ``compiled`` : the function, or its derivative in the parameter, which begins with no lower one.
        """
        box, total, least = arb(0).union(end), arb(0), self._least(compiled.exponents)
        raised = cache(lambda exponent: _power(end, (exponent - least).over(compiled.exponents)))
        for turns, powers, row in compiled.terms:
            held = [self._exponent(n + sum(turns), powers) for n in range(len(row))]
            term = sum((x * raised(own) for x, own in zip(row, held, strict=True) if not x.is_zero()), arb(0))
            for rate, k, degree in zip(compiled.rates, turns, compiled.degrees, strict=True):
                term = term * (rate * (rate * box).sinc()) ** k * (rate * box).cos() ** (degree - k)
            total = total + term
        return total

    def over(self, value: Ball) -> CompiledWaves:
        """The function of omega for a ball of values of the parameter, at the current working precision."""
        known = {self.free: value}
        rates = [expression_ball(a.rate, known) / 2 for a in self.axis.angles]
        exponents = [expression_ball(x, known) for x in self.axis.orders]
        return self._compiled(_coefficients(self, flint.ctx.prec), value, rates, exponents)

    def _compiled(self, coefficients: _Rows, value: Ball, rates: list[Ball], exponents: list[Ball]) -> CompiledWaves:
        constant = [a.constant for a in self.axis.angles]
        turning = [i for i in range(len(rates)) if not constant[i]]
        terms: dict[tuple[_Waves, _Waves], arb_poly] = {}
        for (turns, powers), row in coefficients.items():
            polynomial = arb_poly([p(value) for p in row])
            for i, k in enumerate(turns):
                if i not in turning:
                    polynomial = polynomial * _wave(rates[i], k, self.degrees[i])
            key = tuple(turns[i] for i in turning), powers
            terms[key] = terms[key] + polynomial if key in terms else polynomial
        return CompiledWaves(
            tuple(rates[i] for i in turning),
            tuple(self.degrees[i] for i in turning),
            tuple(exponents),
            tuple((*key, polynomial.coeffs()) for key, polynomial in terms.items()),
        )


@lru_cache(maxsize=64)
def _coefficients(shape: Shape, bits: int) -> _Rows:
    """By the powers of waves and of omega^alpha: for each power of omega a polynomial in the parameter, with so many bits."""
    axis, index = shape.axis, shape.axis.meanings.index(shape.free)
    first, highest = axis.size + len(axis.angles), int(shape.polynomial.degrees()[index])
    found: dict[tuple[_Waves, _Waves], list[list[Ball]]] = {}
    with flint.ctx.workprec(bits):
        for exponents, value in monomials(shape.polynomial):
            own = [int(n) for n in exponents]
            rows = found.setdefault((tuple(own[axis.size : first]), tuple(own[first:])), [])
            rows += [[arb(0)] * (highest + 1) for _ in range(own[0] + 1 - len(rows))]
            rows[own[0]][own[index]] += arb(value) * arb.pi() ** own[1] if own[1] else value
        return {key: [arb_poly(row) for row in rows] for key, rows in found.items()}


def _wave(half: Ball, k: int, degree: int) -> Ball:
    """sin^k cos^(degree - k) of a constant half angle."""
    sine, cosine = half.sin_cos()
    return sine**k * cosine ** (degree - k)


def _power(end: Ball, exponent: Ball) -> Ball:
    """Of a ball from 0 to a number, from 0 on; the exponent is not negative."""
    return arb(1) if exponent == 0 else arb(0) if end.is_zero() else arb(0).union(end.upper() ** exponent)


_MOST_ROWS = 4  # of a Taylor series in the parameter: conditions are squares of what is mostly linear in it
_NARROWED = 6  # times that the frequencies around a maximum are cut from both sides
NOTHING = arb(0, "inf")


class CellVerdict(Enum):
    """What is known of a cell of values: the condition is kept all over the band, or broken somewhere, for all of them."""

    KEPT = "kept"
    BROKEN = "broken"
    OPEN = "open"


@dataclass(frozen=True)
class Told:
    """Values between two floats: ``kept`` with all conditions on all of the band, or not; None where that is not told."""

    low: float
    high: float
    kept: bool | None


@dataclass(frozen=True)
class CriticalPlace:
    """Where alone a condition can bind: at an end of the band, or at the one maximum or corner between two frequencies."""

    kind: Kind
    low: Ball
    high: Ball
    omega: Expr | None = None
    piece: int = 0
    other: int | None = None
    """Of the functions of a condition the one that is decisive; for a corner the rising one, and the falling one."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A condition for all values of the parameter in a cell, in balls."""

    shape: Shape
    whole: CompiledWaves
    ends: tuple[Ball, Ball]

    @classmethod
    def of(cls, shape: Shape, low: Ball, high: Ball) -> Strip:
        """The cell between two dyadic numbers."""
        return cls(shape, shape.over(low.union(high)), (low, high))

    @cached_property
    def _sheet(self) -> Sheet | None:
        """The condition as a polynomial in both: as tight for a wide cell as for a narrow one; None where it is none."""
        axis = self.shape.axis
        if axis.angles or axis.orders:
            return None
        [powers] = _coefficients(self.shape, flint.ctx.prec).values()
        return Sheet.of(powers, *self.ends)

    @property
    def most_boxes(self) -> int:
        """Into how many pieces the band is cut at most."""
        low, high = self.ends
        return _FEW_BOXES if self._sheet and (high - low) * 4 > high.max(-low) else _MOST_BOXES

    @cached_property
    def _from_zero(self) -> tuple[Sheet, Sheet | None]:
        """The same over the power of omega that is a factor; its slope over omega where it is a function of omega^2."""
        assert self._sheet is not None
        sheet = self._sheet.divided(int(self.shape.order_at_zero))
        return sheet, sheet.steepness if self.shape.is_even else None

    @cached_property
    def middle(self) -> CompiledWaves:
        """The condition for the middle of the cell."""
        return self.shape.over(((self.ends[0] + self.ends[1]) / 2).mid())

    @cached_property
    def change(self) -> CompiledWaves | None:
        """The derivative in the parameter, for the whole cell; None where there is none."""
        return self.shape.change.over(self.ends[0].union(self.ends[1])) if self.shape.change else None

    @cached_property
    def _rows(self) -> tuple[CompiledWaves, ...]:
        """Taylor's coefficients in the parameter about the middle of the cell, times n!; the last one for all of the cell."""
        low, high = self.ends
        found, shape = [self.middle], self.shape.change
        while shape is not None and shape.change is not None and len(found) < _MOST_ROWS:
            found.append(shape.over(((low + high) / 2).mid()))
            shape = shape.change
        return (*found, shape.over(low.union(high))) if shape is not None else ()

    @cached_property
    def _reach(self) -> list[Ball]:
        """The powers of half the width of the cell, over n!."""
        low, high = self.ends
        reach = (low.union(high) - ((low + high) / 2).mid()).abs_upper()
        return [reach**n / factorial(n) for n in range(len(self._rows))]

    def _together(self, row: Sequence[Ball]) -> Ball:
        """The values for all of the cell, from those of the coefficients."""
        return range_of(row, self._reach)

    def value(self, x: Ball) -> Ball:
        """The values at a ball of frequencies, for all values of the parameter."""
        if self._sheet is not None:
            return self._sheet.at(x)
        value = self.whole.value(x)
        if value > 0 or value < 0 or not self._rows:
            return value
        return _both(value, self._together([f.value(x) for f in self._rows]))

    def over(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Value, slope and half curvature over a ball of frequencies."""
        if self._sheet is not None:
            return self._by_sheet(box.lower(), box.upper())
        if self.whole.exponents and not box > 0:
            return self.shape.from_zero(self.whole, box.upper()), NOTHING, NOTHING
        if self.shape.order_at_zero and not box > 0:
            return self._over_zero(box)
        value, slope, bend = self.whole.over(box)
        if value < 0 or not self._rows:
            return value, slope, bend
        rows = zip(*(f.over(box) for f in self._rows), strict=True)
        value, slope, bend = (_both(x, self._together(y)) for x, y in zip((value, slope, bend), rows, strict=True))
        return value, slope, bend

    def _by_sheet(self, low: Ball, high: Ball) -> tuple[Ball, Ball, Ball]:
        """The same of a polynomial; from 0 on over the power of omega that is a factor, and what has the sign of the slope."""
        assert self._sheet is not None
        if low > 0 or not self.shape.order_at_zero:
            return self._sheet.over(low, high)
        sheet, steepness = self._from_zero
        value, slope, bend = sheet.over(low, high)
        return value, steepness.over(low, high)[0] if steepness else slope, bend

    def _over_zero(self, box: Ball) -> tuple[Ball, Ball, Ball]:
        """Of f(x)/x^k, k a power of omega that is a factor: a k-th Taylor coefficient in between, and its slope the next one.

        The slope of an even function is 2 x times half a curvature in between: that has its sign, and stands for it.
        """
        k = int(self.shape.order_at_zero)
        value = self.coefficient(box, k)
        if value < 0 or self.coefficient(arb(0), k) < 0:  # of a piece that shows to be kept when it is cut
            return value, NOTHING, NOTHING
        return value, self.coefficient(box, k + (2 if self.shape.is_even else 1)), NOTHING

    def coefficient(self, box: Ball, n: int) -> Ball:
        """Taylor's in omega, over a ball of frequencies, for all values of the parameter."""
        if self._sheet is not None:
            return self._sheet.at(box, n)
        value = self.whole.taylor(box, n)
        if value < 0 or value > 0 or not self._rows:
            return value
        return _both(value, self._together([f.taylor(box, n) for f in self._rows]))

    def broken_in_the_middle(self, x: Ball) -> bool:
        """Whether the condition is broken at a frequency for the middle of the cell."""
        return bool(self.middle.value(x) > 0)

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        """The signs at a place for both ends of the cell, if it changes one way only in between; None if that is not sure."""
        at_edge = place.omega is not None
        near = expression_ball(place.omega) if at_edge else self._around_maximum(place)
        sign = _sign(self.shape.seen_at(self.whole, near) if at_edge else self.over(near)[0])
        if not sign and self.shape.is_fixed:
            sign = self._sign(place, self.ends[0])
        if sign:
            return sign, sign
        if self.change is None:
            return None
        if not _sign(self.shape.seen_at(self.change, near) if at_edge else self.change.over(near)[0]):
            return None
        found = [self._sign(place, end) for end in self.ends]
        return None if 0 in found else (found[0], found[1])

    def _around_maximum(self, place: CriticalPlace) -> Ball:
        """Frequencies among which the maximum at a place is, for all values of the parameter: there the slope falls through 0."""
        low, high = place.low, place.high
        for share in (4, 2, 4 / 3) * _NARROWED:
            x = (low + (high - low) / share).mid()
            slope = self.whole.taylor(x, 1)
            low, high = (x, high) if slope > 0 else (low, x) if slope < 0 else (low, high)
        return low.union(high)

    def _sign(self, place: CriticalPlace, value: Ball) -> int:
        if place.omega is not None:
            ball = self.shape.seen_at(self.shape.over(value), expression_ball(place.omega))
        else:
            x = maximum(self.shape, value, (place.low, place.high), flint.ctx.prec)
            ball = self.shape.over(value).over(x)[0]
        return _sign(ball)

    def crossing(self, place: CriticalPlace) -> Edge | Summit:
        """The value of the parameter at which the condition binds at a place."""
        if place.omega is not None:
            return Edge(self.shape, place.omega, *self.ends)
        return Summit(self.shape, (place.low, place.high), *self.ends)


def _sign(x: Ball) -> int:
    return 1 if x > 0 else -1 if x < 0 else 0


def _both(a: Ball, b: Ball) -> Ball:
    """What two enclosures of one number leave."""
    if not (a.is_finite() and b.is_finite()):
        return a if a.is_finite() else b
    return a.intersection(b)


@dataclass(frozen=True, repr=False)
class Edge(RealNumber):
    """The value of the parameter in a cell at which a condition binds at a given frequency: the one zero there."""

    shape: Shape
    place: Expr
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits, change = rounded_up(bits), self.shape.change
        assert change is not None
        with flint.ctx.workprec(bits):
            at = expression_ball(self.place)

            def jet(t: Ball, count: int) -> list[Ball]:
                return [self.shape.seen_at(f.over(t), at) for f in (self.shape, change)[:count]]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class Summit(RealNumber):
    """The value of the parameter in a cell at which the one maximum of a condition between two frequencies is 0."""

    shape: Shape
    between: tuple[Ball, Ball]
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        if bits not in self._balls:
            self._balls[bits] = self._refined(bits)
        return self._balls[bits]

    @cached_property
    def _balls(self) -> dict[int, Ball]:
        """Those that were asked for: each takes as long as a small map, and maps print an end several times."""
        return {}

    def _refined(self, bits: int) -> Ball:
        change = self.shape.change
        assert change is not None
        with flint.ctx.workprec(bits):

            def jet(t: Ball, count: int) -> list[Ball]:
                at = maximum(self.shape, t, self.between, bits)
                return [f.over(t).over(at)[0] for f in (self.shape, change)[:count]]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class MaximumAt(RealNumber):
    """The frequency of the maximum that a ``Summit`` is about."""

    summit: Summit

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(2 * bits):
            return maximum(self.summit.shape, self.summit.ball(2 * bits), self.summit.between, 2 * bits)


def maximum(shape: Shape, t: Ball, between: tuple[Ball, Ball], bits: int) -> Ball:
    """Where the slope in omega vanishes between two frequencies, for a ball of values of the parameter."""
    strip = shape.over(t)
    return tightened(*between, bits, lambda x, count: [n * c for n, c in enumerate(strip.series(x, 1, count + 1), 1)])


@dataclass(frozen=True, repr=False)
class Corner(RealNumber):
    """The value of the parameter in a cell at which the zero of ``rising`` between two frequencies is one of ``falling``."""

    rising: Shape
    falling: Shape
    between: tuple[Ball, Ball]
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(bits):

            def jet(t: Ball, count: int) -> list[Ball]:
                at = zero(self.rising, t, self.between, bits)
                return [self.falling.over(t).over(at)[0], _steepness(self.rising, self.falling, t, at)][:count]

            return tightened(self.low, self.high, bits, jet)


@dataclass(frozen=True, repr=False)
class ZeroAt(RealNumber):
    """The frequency of a ``Corner``."""

    corner: Corner

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(2 * bits):
            return zero(self.corner.rising, self.corner.ball(2 * bits), self.corner.between, 2 * bits)


def zero(shape: Shape, t: Ball, between: tuple[Ball, Ball], bits: int) -> Ball:
    """Where a function vanishes between two frequencies, for a ball of values of the parameter."""
    strip = shape.over(t)
    return tightened(*between, bits, lambda x, count: strip.series(x, 0, count))


def _steepness(rising: Shape, falling: Shape, t: Ball, at: Ball) -> Ball:
    """How fast the value of ``falling`` at the zero of ``rising`` changes with the parameter."""
    changes = [0 if x.change is None else x.change.over(t).over(at)[0] for x in (rising, falling)]
    slopes = [x.over(t).over(at)[1] for x in (rising, falling)]
    return changes[1] - slopes[1] * changes[0] / slopes[0]


def corner_signs(rising: Strip, falling: Strip, place: CriticalPlace) -> tuple[int, int] | None:
    """1 where both are positive somewhere between the frequencies, -1 where nowhere, for both ends of a cell.

    None unless both vanish there for all values of the cell, and what decides changes one way only.
    """
    a, b = place.low, place.high
    shows = rising.value(a) < 0 < rising.value(b) and falling.value(b) < 0 < falling.value(a)
    if not shows:
        return None
    low, high = rising.ends
    steep = _steepness(rising.shape, falling.shape, low.union(high), a.union(b))
    if not (steep > 0 or steep < 0):
        return None
    found = []
    for t in (low, high):
        value = falling.shape.over(t).over(zero(rising.shape, t, (a, b), flint.ctx.prec))[0]
        found.append(1 if value > 0 else -1 if value < 0 else 0)
    return None if 0 in found else (found[0], found[1])


_MOST_BOXES, _FINEST = 200, 20
_FEW_BOXES = 40
"""Of a wide cell of polynomials, which shows itself in a few boxes if at all."""
_SAMPLES, _NEAR_END = 24, 1 << 10
_STEPS = 3
"""Of Newton's from a frequency at which a condition is broken to the maximum beside it."""


@dataclass(frozen=True, eq=False)
class Strips:
    """A condition for all values of the parameter in a cell: functions that must not all be positive, in balls."""

    strips: tuple[Strip, ...]

    @classmethod
    def of(cls, shapes: Sequence[Shape], low: Ball, high: Ball) -> Strips:
        """The cell between two dyadic numbers."""
        return cls(tuple(Strip.of(x, low, high) for x in shapes))

    @property
    def most_boxes(self) -> int:
        """Into how many pieces the band is cut at most."""
        return min(strip.most_boxes for strip in self.strips)

    def value(self, x: Ball) -> Ball:
        """The values of the least function at a ball of frequencies, for all values of the parameter."""
        return reduce(arb.min, (strip.value(x) for strip in self.strips))

    def broken_in_the_middle(self, x: Ball) -> bool:
        """Whether the condition is broken at a frequency for the middle of the cell."""
        return all(strip.broken_in_the_middle(x) for strip in self.strips)

    def risen(self, suspects: Sequence[Ball], low: Ball, high: Ball) -> Iterator[Ball]:
        """Frequencies between two, nearer a maximum of the condition for the middle of the cell: Newton's steps from a suspect.

        Where the condition is broken by little it is at the maximum that all of the cell shows it. Not of several functions.
        """
        [strip, *others] = self.strips
        compiled = strip.middle
        at = max(suspects, key=lambda x: float(compiled.value(x).mid()))
        for _ in range(0 if others else _STEPS):
            slope, bend = compiled.series(at, 1, 3)
            if not bend < 0:
                return
            at = (at - slope / (2 * bend)).mid()
            if not (low < at < high):
                return
            yield at

    def signs(self, place: CriticalPlace) -> tuple[int, int] | None:
        """The signs at a place for both ends of the cell, if it changes one way only in between; None if that is not sure."""
        one = self.strips[place.piece]
        return one.signs(place) if place.other is None else corner_signs(one, self.strips[place.other], place)

    def crossing(self, place: CriticalPlace) -> Edge | Summit | Corner:
        """The value of the parameter at which the condition binds at a place."""
        one = self.strips[place.piece]
        if place.other is None:
            return one.crossing(place)
        return Corner(one.shape, self.strips[place.other].shape, (place.low, place.high), *one.ends)


@dataclass(frozen=True)
class _Box:
    """A piece of the band on which a condition did not show to be kept, with the signs of slope and curvature there.

    ``pieces`` : the functions that did not show to be positive; one, or two for a corner, whose ``slopes`` are given.
    """

    low: Ball
    high: Ball
    slope: int
    bend: int
    pieces: tuple[int, ...] = (0,)
    slopes: tuple[int, ...] = ()


_Found: TypeAlias = "CellVerdict | list[CriticalPlace]"


def places(condition: Strips, band: tuple[Expr, Expr]) -> _Found:
    """All places where a condition can bind, for all values of a cell; or BROKEN; or OPEN where that is not clear."""
    low, high = expression_ball(band[0]).lower(), expression_ball(band[1]).upper()
    near_ends = (low + (high - low) / _NEAR_END).mid(), expression_ball(band[1]).lower()
    if any(condition.value(x) > 0 for x in near_ends):
        return CellVerdict.BROKEN
    samples = [(low + (high - low) * i / _SAMPLES).mid() for i in range(1, _SAMPLES)]
    suspects = [x for x in samples if condition.broken_in_the_middle(x)]
    if suspects:  # the cell is broken there, or near there, or it must be cut
        broken = any(condition.value(x) > 0 for x in (*suspects, *condition.risen(suspects, low, high)))
        return CellVerdict.BROKEN if broken else CellVerdict.OPEN
    boxes = _unclear(condition, low, high)
    if isinstance(boxes, CellVerdict):
        return boxes
    found: list[CriticalPlace] = []
    for cluster in _clusters(boxes):
        place = _decided(condition, cluster, low, high, band)
        if place is CellVerdict.OPEN:
            return CellVerdict.OPEN
        if isinstance(place, CriticalPlace):
            found.append(place)
    return found


def _unclear(condition: Strips, low: Ball, high: Ball) -> CellVerdict | list[_Box]:
    """The pieces of the band on which the condition does not show to be kept, in order."""
    found: list[_Box] = []
    waiting = Waiting([(low, high)])
    for a, b in waiting:
        box = _box(condition, a, b)
        if box is None:
            continue
        middle = ((a + b) / 2).mid()
        if condition.value(middle) > 0:
            return CellVerdict.BROKEN
        if condition.broken_in_the_middle(middle):
            broken = any(condition.value(x) > 0 for x in condition.risen([middle], a, b))
            return CellVerdict.BROKEN if broken else CellVerdict.OPEN
        if waiting.examined > condition.most_boxes:
            return CellVerdict.OPEN
        if (b - a) * _FINEST < high - low and (box.slope or box.bend < 0 or box.slopes):
            found.append(box)
        else:
            waiting.add((a, middle), (middle, b))
    return found


def _box(condition: Strips, a: Ball, b: Ball) -> _Box | None:
    """What is known of a condition on a piece of the band; None where it is kept."""
    box, open_ = a.union(b), dict[int, tuple[int, int]]()
    for i, strip in enumerate(condition.strips):
        value, slope, bend = strip.over(box)
        if value < 0:
            return None
        if not (value > 0 and len(condition.strips) > 1):
            open_[i] = _sign_in_clusters(slope), _sign_in_clusters(bend)
    if len(open_) == 1:
        [(i, (slope, bend))] = open_.items()
        return _Box(a, b, slope, bend, (i,))
    slopes = tuple(slope for slope, _ in open_.values())
    return _Box(a, b, 0, 0, tuple(open_), slopes if sorted(slopes) == [-1, 1] else ())


def _sign_in_clusters(ball: Ball) -> int:
    return 1 if ball > 0 else -1 if ball < 0 else 0


def _clusters(boxes: list[_Box]) -> list[list[_Box]]:
    """Pieces that follow each other without a gap."""
    found: list[list[_Box]] = []
    for box in boxes:
        if found and found[-1][-1].high == box.low:
            found[-1].append(box)
        else:
            found.append([box])
    return found


def _decided(
    condition: Strips, cluster: list[_Box], low: Ball, high: Ball, band: tuple[Expr, Expr]
) -> CriticalPlace | CellVerdict:
    """Where alone in a piece the condition can bind: by one of its functions, or by two at a corner."""
    deciding = sorted({i for box in cluster for i in box.pieces})
    if len(deciding) == 1:
        place = _place(condition.strips[deciding[0]], cluster, low, high, band)
        return replace(place, piece=deciding[0]) if isinstance(place, CriticalPlace) else place
    a, b = cluster[0].low, cluster[-1].high
    if len(deciding) > 2 or a == low or b == high:
        return CellVerdict.OPEN
    slopes = [_sign_in_clusters(condition.strips[i].over(a.union(b))[1]) for i in deciding]
    if sorted(slopes) != [-1, 1]:
        return CellVerdict.OPEN
    rising, falling = deciding if slopes[0] > 0 else deciding[::-1]
    return CriticalPlace(Kind.TOUCH, a, b, piece=rising, other=falling)


def _place(
    strip: Strip, cluster: list[_Box], low: Ball, high: Ball, band: tuple[Expr, Expr]
) -> CriticalPlace | CellVerdict:
    """Where alone in a piece the condition can bind; KEPT if it is largest where it is known to be kept."""
    a, b = cluster[0].low, cluster[-1].high
    bent = all(box.bend < 0 for box in cluster)
    rises = all(box.slope > 0 or (box.bend < 0 and _slope(strip, box.high) > 0) for box in reversed(cluster))
    falls = all(
        box.slope < 0 or (box.bend < 0 and (_is_level(strip, box.low) or _slope(strip, box.low) < 0)) for box in cluster
    )
    if rises:
        return CriticalPlace(Kind.EDGE, a, b, band[1]) if b == high else CellVerdict.KEPT
    if falls:
        return CriticalPlace(Kind.START, a, b, band[0]) if a == low else CellVerdict.KEPT
    if bent and _slope(strip, a) > 0 and _slope(strip, b) < 0:
        return CriticalPlace(Kind.TOUCH, a, b)
    return CellVerdict.OPEN


def _is_level(strip: Strip, x: Ball) -> bool:
    """Whether the slope is 0 there as that of a function of omega^2 is at 0: a fall begins there too."""
    return bool(x == 0) and strip.shape.is_even


def _slope(strip: Strip, x: Ball) -> int:
    return _sign_in_clusters(strip.coefficient(x, 1))
