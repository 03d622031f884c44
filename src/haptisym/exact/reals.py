"""Real numbers that know themselves to any precision: certified enclosures, correct digits, nearest floats."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from functools import reduce
from operator import add, mul
from types import MappingProxyType
from typing import Any, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Add, Expr, Integer, Mul, Pow, Rational, cos, pi, sin, sinc

from haptisym.errors import UndecidedError

Ball: TypeAlias = Any  # flint.arb, which ships no types
_MOST_BITS = 1 << 20


class RealNumber(ABC):
    """A real number that can be enclosed as tightly as asked for.

    ``float(x)`` is the nearest double, ``x.digits(n)`` has n correct digits, ``x.enclosure(n)`` is a proven interval.
    """

    __slots__ = ()

    @abstractmethod
    def ball(self, bits: int) -> Ball:
        """A ball (flint ``arb``) that contains the number, computed with about that many bits."""

    def tight_ball(self, bits: int) -> Ball:
        """A ball that contains the number, with that relative accuracy in bits (or exact, as for zero)."""
        working = bits + 16
        while working < _MOST_BITS:
            with flint.ctx.workprec(working):
                ball = self.ball(working)
                if ball.is_exact() or ball.rel_accuracy_bits() >= bits:
                    return ball
            working *= 2
        raise UndecidedError(f"{bits} bits of a number were not reached with {_MOST_BITS} bits of working precision")

    def bounds(self, bits: int) -> tuple[Fraction, Fraction]:
        """Rational lower and upper bounds, that many bits of relative accuracy apart."""
        return bounds(self.tight_ball(bits))

    def __float__(self) -> float:
        bits = 60
        while True:
            low, high = self.bounds(bits)
            if (
                float(low) == float(high) or bits > 2000
            ):  # beyond that it is the tie between two doubles: any is nearest
                return float(low)
            bits *= 4

    def digits(self, count: int = 15) -> str:
        """The number rounded to ``count`` significant decimal digits, each of them proven.

        >>> ExactNumber(pi).digits(20), ExactNumber(Rational(1, 4)).digits(3)
        ('3.1415926535897932385', '0.250')
        """
        rounding = Context(prec=count, rounding=ROUND_HALF_EVEN)
        bits = int(count * 3.33) + 16
        while True:
            low, high = (_decimal(x, rounding) for x in self.bounds(bits))
            if low == high or bits > 4 * (count + 200):  # beyond that it is a tie, within 200 more digits
                return _plain(low, count)
            bits += 64 + bits // 2

    def enclosure(self, count: int = 15) -> tuple[str, str]:
        """Decimal lower and upper bounds, ``count`` digits or more alike; proven, rounded outward.

        >>> ExactNumber(pi).enclosure(5)
        ('3.1415926', '3.1415927')
        """
        low, high = self.bounds(int((count + 3) * 3.33) + 16)
        down, up = Context(prec=count + 3, rounding=ROUND_FLOOR), Context(prec=count + 3, rounding=ROUND_CEILING)
        return _plain(_decimal(low, down)), _plain(_decimal(high, up))


@dataclass(frozen=True, slots=True)
class ExactNumber(RealNumber):
    """A number given in closed form: rational, or rational in pi."""

    value: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return expression_ball(self.value)

    def __str__(self) -> str:
        return str(self.value)


@dataclass(frozen=True, slots=True)
class SquareRoot(RealNumber):
    """The square root of a number that is not negative.

    >>> SquareRoot(ExactNumber(Integer(2))).digits(10)
    '1.414213562'
    """

    square: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.square.ball(bits).max(arb(0)).sqrt()


_FUNCTIONS: dict[Any, Callable[[Ball], Ball]] = {cos: arb.cos, sin: arb.sin, sinc: arb.sinc}


def expression_ball(value: Expr, known: Mapping[Expr, Ball] = MappingProxyType({})) -> Ball:
    """A ball around a number made of rational numbers, pi, roots, sines and cosines, at the current working precision.

    ``known``: balls that symbols stand for.
    """
    if value in known:
        return known[value]
    if isinstance(value, Rational):
        return arb(fmpq(int(value.p), int(value.q)))
    if value == pi:
        return arb.pi()
    if isinstance(value, Add | Mul):
        return reduce(add if isinstance(value, Add) else mul, (expression_ball(x, known) for x in value.args))
    if isinstance(value, Pow) and isinstance(value.exp, Integer):
        return expression_ball(value.base, known) ** int(value.exp)
    if isinstance(value, Pow) and isinstance(value.exp, Rational):
        base = expression_ball(value.base, known)
        return arb(0) if base == 0 and value.exp > 0 else (base.log() * expression_ball(value.exp)).exp()
    if value.func in _FUNCTIONS:
        return _FUNCTIONS[value.func](expression_ball(value.args[0], known))
    raise TypeError(f"{value} is not a real number made of rational numbers, pi, roots, sines and cosines")


def bounds(ball: Ball) -> tuple[Fraction, Fraction]:
    """Rational lower and upper bound of a ball, at the current working precision or better.

    >>> bounds(arb("0.5"))
    (Fraction(1, 2), Fraction(1, 2))
    """
    middle, radius = _dyadic(ball.mid()), _dyadic(ball.rad())
    return middle - radius, middle + radius


def _dyadic(exact: Ball) -> Fraction:
    mantissa, exponent = exact.man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def _decimal(x: Fraction, context: Context) -> Decimal:
    return context.divide(Decimal(x.numerator), Decimal(x.denominator))


def _plain(x: Decimal, count: int | None = None) -> str:
    """Positional notation where that is readable; with ``count``, trailing zeros up to that many digits."""
    if x.is_zero():
        return "0"
    if count is not None:
        x = x.quantize(Decimal(1).scaleb(x.adjusted() - count + 1), context=Context(prec=count + 2))
    return f"{x:f}" if -6 < x.adjusted() < 21 else str(x)
