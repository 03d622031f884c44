"""Numbers as people write them.

Numbers are exact. A whole number is written as it is, without separators; a fraction as a decimal where that ends within
six digits, or is shorter (9/5 is 1.8), else as a fraction. Only ``approximate`` and ``rounded`` round, and whoever uses them
says so.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal

from sympy import Add, Expr, Float, Function, I, Mul, Pow, Rational, S, pi

from haptisym.kernel.reals import ExactNumber
from haptisym.writing.boxes import Numeral, Ratio

_SHORT = 6  # digits of a decimal that a paper would print
_READABLE = 12  # digits of a decimal that can be read
_READABLE_RATIO = 8  # digits of a fraction, above and below


def number(value: Rational) -> Numeral | Ratio:
    """An exact rational number >= 0.

    >>> number(Rational(9, 5)), number(Rational(1, 3)), number(Rational(1, 10**6))
    (Numeral(digits='1.8', exponent=0), Ratio(above=1, below=3), Numeral(digits='1', exponent=-6))
    """
    if value.q == 1:
        return Numeral(str(value.p))
    exact = _terminating(value)
    if exact is not None:
        length = len(exact.as_tuple().digits)
        if length <= _SHORT or length < len(f"{value.p}{value.q}"):
            return decimal(exact)
    return Ratio(int(value.p), int(value.q))


def _terminating(value: Rational) -> Decimal | None:
    below, places = int(value.q), 0
    for prime in (2, 5):
        power = 0
        while below % prime == 0:
            below, power = below // prime, power + 1
        places = max(places, power)
    # from text: arithmetic of decimals rounds to 28 digits
    return None if below > 1 else Decimal(f"{int(value.p) * 10**places // int(value.q)}E-{places}")


def decimal(value: Decimal) -> Numeral:
    """A decimal >= 0 with a power of ten where it would have many zeros.

    >>> decimal(Decimal("0.00025")), decimal(Decimal("4.0919E9"))
    (Numeral(digits='0.00025', exponent=0), Numeral(digits='4.0919', exponent=9))
    """
    if -4 <= value.adjusted() < 7:
        return Numeral(f"{value:f}")
    first, *others = map(str, value.as_tuple().digits)
    rest = "".join(others).rstrip("0")
    return Numeral(f"{first}.{rest}" if rest else first, value.adjusted())


def approximate(expression: Expr, digits: int = 6) -> Expr:
    """The formula with long numbers, and if there are any then irrational ones too, rounded to that many digits.

    >>> from sympy import Symbol
    >>> s = Symbol("s")
    >>> approximate(Rational(408233133, 200000001) * s + 40 * pi), approximate(Rational(4, 3) * s + 40 * pi)
    (2.04117*s + 125.664, 4*s/3 + 40*pi)
    """
    if _with_numbers(expression, lambda x: x if _is_readable(x) else rounded(x, digits)) == expression:
        return expression
    return _with_numbers(expression, lambda x: x if x.is_Integer and abs(x) < 10**digits else rounded(x, digits))


def _with_numbers(expression: Expr, change: Callable[[Expr], Expr]) -> Expr:
    if not expression.free_symbols:
        return change(expression)
    if isinstance(expression, Pow):
        return Pow(_with_numbers(expression.base, change), expression.exp)
    if isinstance(expression, Function):
        return expression.func(*(_with_numbers(x, change) for x in expression.args))
    if not isinstance(expression, Add | Mul):
        return expression
    known, rest = expression.as_independent(*expression.free_symbols, as_Add=isinstance(expression, Add))
    others = (_with_numbers(x, change) for x in expression.func.make_args(rest))
    return expression.func(change(known), *others)


def rounded(value: Expr, digits: int = 6) -> Expr:
    """A number, rational in pi, correctly rounded."""
    if value.has(I):  # the phase of friction
        return Add(*(x * rounded(y, digits) for x, y in zip((1, I), value.as_real_imag(), strict=True) if y))
    return Float(ExactNumber(value).digits(digits), digits)


def is_short(value: Rational) -> bool:
    """Whether a rational number can be read as it is: few digits, and no power of ten beside them.

    >>> is_short(Rational(68, 15)), is_short(Rational(12345678)), is_short(Rational(408233133, 200000001))
    (True, True, False)
    """
    match number(abs(value)):
        case Ratio(above, below):
            return len(f"{above}{below}") <= _READABLE_RATIO
        case Numeral(digits, exponent):
            return len(digits) <= _READABLE and (not exponent or digits == "1")
    raise AssertionError


def _is_readable(value: Expr) -> bool:
    rational, rest = value.as_coeff_Mul()
    return is_short(rational) and rest in (S.One, pi, pi**2)
