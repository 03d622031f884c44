"""A real function of frequency over an interval of values of one parameter, in balls: for scenes with delays and powers.

The condition N(omega, t) <= 0 is written as a sum of p(omega, t) sin^k cos^(n - k) omega^(alpha l), the waves those of half the
angles omega tau; n is even, so that the sign is that of the condition itself. Over a ball of values of t this is an analytic
function of omega with balls for coefficients.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from operator import sub
from typing import TypeAlias

import flint
from flint import arb, arb_poly
from sympy import Rational, Symbol

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.monomials import monomials
from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.waves import CompiledWaves

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

    def beyond(self, inverse: Ball) -> CompiledWaves:
        """The function, over an even power of the parameter, for a ball of values of 1/parameter, which may hold 0.

        Delays that the parameter is part of have waves of any phase: balls from -1 to 1.
        """
        if any(x.has(self.free) for x in self.axis.orders):
            raise SceneError(f"{self.free} is the order of a power: it has no values without bound")
        most = int(self.polynomial.degrees()[self.axis.meanings.index(self.free)])
        most += most % 2
        mirrored = {
            key: [arb_poly([p[most - n] for n in range(most + 1)]) for p in row]
            for key, row in _coefficients(self, flint.ctx.prec).items()
        }
        rates = [None if a.rate.has(self.free) else expression_ball(a.rate) / 2 for a in self.axis.angles]
        return self._compiled(mirrored, inverse, rates, [expression_ball(x) for x in self.axis.orders])

    def _compiled(
        self, coefficients: _Rows, value: Ball, rates: list[Ball | None], exponents: list[Ball]
    ) -> CompiledWaves:
        constant = [a.constant for a in self.axis.angles]
        turning = [i for i, rate in enumerate(rates) if rate is not None and not constant[i]]
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


def _wave(half: Ball | None, k: int, degree: int) -> Ball:
    """sin^k cos^(degree - k) of a constant half angle, or of any at all."""
    if half is None:
        low = 0 if k % 2 == 0 else -1  # the degree is even
        return arb(low).union(arb(1)) if degree > 0 else arb(1)
    sine, cosine = half.sin_cos()
    return sine**k * cosine ** (degree - k)


def _power(end: Ball, exponent: Ball) -> Ball:
    """Of a ball from 0 to a number, from 0 on; the exponent is not negative."""
    return arb(1) if exponent == 0 else arb(0) if end.is_zero() else arb(0).union(end.upper() ** exponent)
