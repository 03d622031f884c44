"""Decimal digits of numbers that are known between two bounds."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction


def bits_for(count: int) -> int:
    """Relative accuracy in bits with which ``count`` decimal digits are tried first."""
    return int(count * 3.33) + 16


def rounded(low: Fraction, high: Fraction, count: int) -> str | None:
    """What all numbers between two bounds are, rounded to ``count`` significant decimal digits; None if that differs.

    >>> rounded(Fraction(1, 8), Fraction(129, 1024), 2), rounded(Fraction(1, 8), Fraction(1, 7), 2)
    (None, None)
    >>> rounded(Fraction(1, 3), Fraction(334, 1000), 2)
    '0.33'
    """
    rounding = Context(prec=count, rounding=ROUND_HALF_EVEN)
    first, last = (_decimal(x, rounding) for x in (low, high))
    return _plain(first, count) if first == last else None


def outward(low: Fraction, high: Fraction, count: int) -> tuple[str, str]:
    """Two bounds with ``count`` significant decimal digits, rounded away from each other."""
    down, up = (Context(prec=count, rounding=rounding) for rounding in (ROUND_FLOOR, ROUND_CEILING))
    return _plain(_decimal(low, down)), _plain(_decimal(high, up))


def _decimal(x: Fraction, context: Context) -> Decimal:
    return context.divide(Decimal(x.numerator), Decimal(x.denominator))


def _plain(x: Decimal, count: int | None = None) -> str:
    """Positional notation where that is readable; with ``count``, trailing zeros up to that many digits."""
    if x.is_zero():
        return "0"
    if count is not None:
        x = x.quantize(Decimal(1).scaleb(x.adjusted() - count + 1), context=Context(prec=count + 2))
    return f"{x:f}" if -6 < x.adjusted() < 21 else str(x)
