"""Where a rational function meets an algebraic number that is not rational: its own peak, say, exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import flint
from flint import fmpq, fmpq_poly
from sympy import Dummy, Expr, Rational, minimal_polynomial

from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.polynomials import PolynomialFactor, Root, polynomial_factors
from haptisym.kernel.precision import SURE_BITS, at_rising_precision
from haptisym.kernel.reals import Ball, RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.symbols import omega
from haptisym.kernel.zeros import Factor


def algebraic(value: Expr) -> Root:
    """A positive algebraic number as a root of its minimal polynomial.

    >>> from sympy import sqrt
    >>> algebraic((sqrt(5) + 1) / 2).digits(20)
    '1.6180339887498948482'
    """
    x = Dummy()
    minimal = minimal_polynomial(value, x, polys=True).clear_denoms(convert=True)[1]
    factor = PolynomialFactor(tuple((int(c),) for c in minimal.all_coeffs()[::-1]), step=1)

    def near(bits: int) -> Ball:  # SymPy is asked for three times the digits that it is trusted with
        digits = bits * 3 // 10
        return flint.arb(str(value.evalf(3 * digits + 10)), abs(value.evalf(5)) * Rational(1, 10**digits))

    return the_one(factor.positive_roots(), near)


def the_one(candidates: list[Root], near: Callable[[int], Ball]) -> Root:
    """The one among different numbers that equals a number given by balls around it, from a count of bits."""

    def alone(bits: int) -> Root | None:
        ball = near(bits)
        found = [x for x in candidates if x.ball(bits).overlaps(ball)]
        return found[0] if len(found) == 1 else None

    found = at_rising_precision(alone, 64, SURE_BITS)
    if found is None:
        raise UndecidedError("which root of a polynomial is meant")
    return found


@dataclass(frozen=True)
class Level:
    """A rational function of omega that is never negative, minus a positive algebraic number that is not rational.

    SceneError unless all other numbers in it are rational.
    """

    function: RealFunction
    number: Root

    @cached_property
    def factor(self) -> LevelFactor:
        """What stands above the line: numerator - number * denominator, over the field of the number."""
        axis, f = self.function.axis, self.function.function
        top, bottom = (axis.univariate(p) for p in (f.numerator, f.denominator))
        if axis.functions or top is None or bottom is None:
            raise SceneError(
                "a threshold that is not a rational number needs a scene without delays, powers of s and pi"
            )
        return LevelFactor(self.function, self.number, _norm_factors(fmpq_poly(top), fmpq_poly(bottom), self.number))


def _norm_factors(top: fmpq_poly, bottom: fmpq_poly, number: Root) -> tuple[tuple[PolynomialFactor, int], ...]:
    """The factors over Q of the product of top - x bottom over all conjugates x of the number.

    Where the quotient top/bottom equals the number it equals no conjugate: zeros of the one function have there, in the
    product, the same order.
    """
    minimal = [c for (c,) in number.factor.coefficients]
    norm = sum((fmpq(c) * top**i * bottom ** (len(minimal) - 1 - i) for i, c in enumerate(minimal)), fmpq_poly([0]))
    return tuple(polynomial_factors(norm.coeffs())[2])


@dataclass(frozen=True)
class LevelFactor(Factor):
    """numerator - number * denominator of a rational function: its zeros are zeros of ``parts``, of that order each."""

    function: RealFunction
    number: Root
    parts: tuple[tuple[PolynomialFactor, int], ...]

    def value(self, x: Ball) -> Ball:
        axis, f = self.function.axis, self.function.function
        above, below = (axis.ball(p, {omega: x}) for p in (f.numerator, f.denominator))
        return above - self.number.ball(flint.ctx.prec) * below

    def zeros(self, low: Expr, high: Expr) -> list[RealNumber]:
        return [x for f, _ in self.parts for x in f.zeros(low, high) if self._meets(x)]

    def multiplicity(self, zero: RealNumber) -> int:
        return next(n for f, n in self.parts if f == getattr(zero, "factor", None))

    def order_at(self, place: Expr) -> int:
        # at a rational number its value is rational, at one with pi it is not algebraic: never the number
        return 0

    def _meets(self, x: RealNumber) -> bool:
        """Whether the function has this very value there, not that of a conjugate: of one it has."""
        # a square of a ratio is not negative: only positive conjugates come into question
        return (
            the_one(self.number.factor.positive_roots(), lambda bits: self.function.ball(x.ball(bits))) == self.number
        )
