"""Real numbers that can be enclosed in balls of any precision, and their proven digits.

A question about a number is asked in balls of twice as many bits until it is decided, up to a limit
of bits (``at_rising_precision``). From a ball come the nearest float, digits each of which is
proven, ends that are rounded outward, and the simplest rational number between two numbers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from enum import Enum
from fractions import Fraction
from functools import reduce
from math import ceil, floor, isfinite, isnan
from operator import abs as size
from operator import add, ge, gt, index, le, lt, mul, neg, sub, truediv
from types import MappingProxyType
from typing import Any, SupportsIndex, TypeAlias, TypeVar

import flint
from flint import arb, fmpq
from sympy import (
    Expr,
    Float,
    Integer,
    NumberSymbol,
    Pow,
    Rational,
    cos,
    log,
    pi,
    sin,
    sinc,
    sqrt,
    tan,
)

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.objects import Viewed, copied


def whole(
    name: str, given: SupportsIndex, least: int = 1, most: int | None = None, *, of: str = ""
) -> int:
    """A whole number of whatever kind, in its limits; SceneError with its ``name`` and the rule.
    ``of`` : what it counts.

    >>> from sympy import Integer
    >>> whole("digits", 3), whole("digits", Integer(3))
    (3, 3)
    >>> whole("every", 0, 1, 100)
    Traceback (most recent call last):
      ...
    haptisym.kernel.errors.SceneError: every: 0 must be a whole number from 1 to 100
    """
    # To Python True is the number 1; here it is no count.
    try:
        number = None if isinstance(given, bool) else index(given)
    except TypeError:
        number = None
    if number is None or number < least or (most is not None and number > most):
        limits = f", at least {least}" if most is None else f" from {least} to {most}"
        raise SceneError(f"{name}: {given} must be a whole number{of}{limits}")
    return number


def bits_for(count: int) -> int:
    """Relative accuracy in bits with which ``count`` decimal digits are tried first."""
    return int(count * 3.33) + 16


def rounded(low: Fraction, high: Fraction, count: int) -> str | None:
    """The text to which all numbers between two bounds round, with ``count`` significant decimal
    digits; None if they do not round to the same.

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
    """Positional notation where that is readable; with ``count``, trailing zeros up to that many
    digits."""
    if x.is_zero():
        return "0"
    if count is not None:
        x = x.quantize(Decimal(1).scaleb(x.adjusted() - count + 1), context=Context(prec=count + 2))
    return f"{x:f}" if -6 < x.adjusted() < 21 else str(x)


T = TypeVar("T")

MOST_BITS = 1 << 13
"""The precision at which a question is given up as undecided that balls may never decide: whether a
number, or an analytic function, is 0."""
SURE_BITS = 1 << 20
"""The same for a question that balls do decide at some precision, as algebraic numbers that differ
show it at last. It is never reached but by a mistake in the program."""


def at_rising_precision(
    ask: Callable[[int], T | None], first: int = 128, most: int = MOST_BITS
) -> T | None:
    """The first answer there is, asked at working precisions of ``first``, twice that, ... bits;
    None if none up to ``most``.

    >>> at_rising_precision(lambda bits: None if bits < 1000 else bits)
    1024
    """
    # Doubled, the rounds in vain take together no longer than the last one.
    bits = first
    while bits <= most:
        with flint.ctx.workprec(bits):
            answer = ask(bits)
        if answer is not None:
            return answer
        bits *= 2
        tick()
    return None


Ball: TypeAlias = Any  # flint.arb, which ships no types
ALIKE_BITS = 600
"""Bits to which two numbers must agree to count as equal in ``ordered``."""
ORDER_BITS = (128, ALIKE_BITS)  # most numbers are distinguished by the first
_FEW_BITS = 128  # in ``_is_between``, which may miss a number that lies very near to an end


def ordered(x: RealNumber, y: RealNumber) -> int:
    """1 where y is larger than x, -1 where it is smaller, 0 where ``ALIKE_BITS`` do not distinguish
    them."""
    if x is y:
        return 0
    # Rough balls first, which cost nothing, then finer ones.
    for bits in (0, *ORDER_BITS):
        with flint.ctx.workprec(bits or ORDER_BITS[0]):
            change = y.ball(bits) - x.ball(bits) if bits else y.rough() - x.rough()
            if not change.contains(0):
                return int(change > 0) - int(change < 0)
    return 0


def in_sympy(x: RealNumber) -> Expr:
    """The number in expressions of SymPy: exact, evaluated to any number of digits."""
    return x._sympy_()


def _calculated(operation: Callable[..., Any]) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """An operation on numbers as SymPy has it: a method, and the one for the other order."""
    return (
        lambda x, *others: operation(in_sympy(x), *others),
        lambda x, other: operation(other, in_sympy(x)),
    )


def _compared(operation: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """A comparison of numbers: by ``ordered``, with rational ones too, else as SymPy has it."""

    def method(x: RealNumber, other: Any) -> Any:
        is_finite = not isinstance(other, float) or isfinite(other)
        if isinstance(other, int | float | Fraction | Rational) and is_finite:
            other = ExactNumber(Rational(other))
        if isinstance(other, RealNumber):
            return operation(0, ordered(x, other))
        return operation(in_sympy(x), other)

    return method


class RealNumber(Viewed, ABC):
    """A real number that can be enclosed to any precision.

    ``float(x)`` is the nearest double, ``x.digits(n)`` has n correct digits, ``x.enclosure(n)`` is
    a proven interval, ``f"{x:.3f}"`` is correctly rounded. Numbers compare by ``<``, where 600 bits
    that agree count as equal. SymPy takes them into expressions, exactly, and so do ``x + 1`` and
    ``2*x``: ``N(2*x, 50)`` has 50 correct digits.

    >>> from sympy import N
    >>> x = SquareRoot(ExactNumber(Integer(2)))
    >>> f"{x:.3f}", x < 1.5, N(x + 1, 30)
    ('1.414', True, 2.41421356237309504880168872421)
    """

    __slots__ = ()
    __reduce__ = copied
    __add__, __radd__ = _calculated(add)
    __sub__, __rsub__ = _calculated(sub)
    __mul__, __rmul__ = _calculated(mul)
    __truediv__, __rtruediv__ = _calculated(truediv)
    __pow__, __rpow__ = _calculated(pow)
    __neg__, __abs__ = _calculated(neg)[0], _calculated(size)[0]
    __lt__, __le__, __gt__, __ge__ = map(_compared, (lt, le, gt, ge))

    def _sympy_(self) -> Expr:
        """The number in expressions of SymPy: exact, evaluated to any number of digits."""
        return Proven(self)

    def _mpmath_(self, bits: int, rounding: str) -> Float:
        """The number for mpmath, rounded to the nearest."""
        return Float._new(self.settled(lambda x: rational(x)._as_mpf_val(bits), bits + 16), bits)

    def __format__(self, how: str) -> str:
        """The number in a format of floats (and its digits, of ``Decimal``), correctly rounded."""
        if "." not in how:
            if not how.endswith(tuple("eEfFgG%")):
                return format(str(self), how)
            # Floats are shown with six decimals unless asked otherwise.
            how = f"{how[:-1]}.6{how[-1]}"
        count = 400 + int("0" + "".join(filter(str.isdigit, how.partition(".")[2])))
        return self.settled(lambda x: format(_decimal(x, Context(prec=count)), how))

    @abstractmethod
    def ball(self, bits: int) -> Ball:
        """A ball (flint ``arb``) that contains the number, computed with about that many bits."""

    def rough(self) -> Ball:
        """A ball that contains the number, as tight as is known without further work."""
        return self.ball(64)

    def __repr__(self) -> str:
        """Its digits; an interval where so many are not known."""
        try:
            return self.digits()
        except UndecidedError:
            return "[{}, {}]".format(*self.enclosure(5))

    def tight_ball(self, bits: int) -> Ball:
        """A ball that contains the number, with that relative accuracy in bits, or exact, as for
        zero."""

        def tight(working: int) -> Ball | None:
            ball = self.ball(working)
            return ball if ball.is_exact() or ball.rel_accuracy_bits() >= bits else None

        found = at_rising_precision(tight, bits + 16, SURE_BITS)
        if found is None:
            raise UndecidedError(
                f"a number to {bits} bits, with {SURE_BITS} bits of working precision"
            )
        return found

    def bounds(self, bits: int) -> tuple[Fraction, Fraction]:
        """Rational lower and upper bounds, that many bits of relative accuracy apart."""
        return bounds(self.tight_ball(bits))

    def __float__(self) -> float:
        """The nearest double: both ends of a ball round to it."""
        with flint.ctx.workprec(128):
            ball = self.tight_ball(60)
            ends = float(ball.lower()), float(ball.upper())
        if ends[0] == ends[1] and isfinite(ends[0]):
            return ends[0]
        # Fractions round correctly everywhere, also near the ends of the range of doubles.
        return self.settled(float, 240)

    def settled(self, shown: Callable[[Fraction], T], bits: int = 80) -> T:
        """What a rounding ``shown`` makes of the number: of both ends of an enclosure, as tight as
        it takes, from ``bits`` on; UndecidedError where no more is known of it."""
        # Where so many bits more do not decide, the number is a tie, half way between two results.
        most = 4 * bits + 1600
        while True:
            low, high = self.bounds(bits)
            found = shown(low)
            if found == shown(high):
                return found
            if bits > most and (high - low) * 2 ** (bits // 2) < abs(low):
                return found
            if bits > most:
                raise UndecidedError(f"a number of which {self} is known, to more digits")
            bits += 64 + bits // 2

    def digits(self, count: int = 15) -> str:
        """The number rounded to ``count`` significant decimal digits, each of them proven.

        >>> ExactNumber(pi).digits(20), ExactNumber(Rational(1, 4)).digits(3)
        ('3.1415926535897932385', '0.250')
        """
        count = whole("digits", count)
        return self.settled(lambda x: rounded(x, x, count) or "", bits_for(count))

    def enclosure(self, count: int = 15) -> tuple[str, str]:
        """Decimal lower and upper bounds, ``count`` digits or more equal; proven, rounded outward.

        >>> ExactNumber(pi).enclosure(5)
        ('3.1415926', '3.1415927')
        """
        return outward(*self.bounds(bits_for(count + 3)), count + 3)


class Proven(NumberSymbol):  # type: ignore[misc]
    """A number as SymPy has it: a constant, as pi is, with as many proven digits as are asked for.

    >>> Proven(SquareRoot(ExactNumber(Integer(2)))).evalf(30)
    1.41421356237309504880168872421
    """

    __slots__ = ("number",)
    is_real = True

    def __new__(cls, number: RealNumber) -> Proven:
        found: Proven = super().__new__(cls)
        found.number = number
        return found

    def __getnewargs__(self) -> tuple[RealNumber]:
        return (self.number,)

    def _hashable_content(self) -> tuple[RealNumber]:
        return (self.number,)

    def __eq__(self, other: object) -> bool:
        own = other.number if isinstance(other, Proven) else other
        if not isinstance(own, RealNumber):
            return False
        # Zeros of two searches may be counted alike and differ.
        return self.number == own and not ordered(self.number, own)

    def __hash__(self) -> int:
        return hash(self.number)

    def _eval_is_positive(self) -> bool | None:
        return True if self.number.rough() > 0 else None

    def _as_mpf_val(self, bits: int) -> Any:
        return self.number._mpmath_(bits, "n")._mpf_

    def approximation_interval(self, _: type) -> tuple[Integer, Integer]:
        """The whole numbers between which SymPy is to find it."""
        low = self.number.settled(floor)
        return Integer(low), Integer(low + 1)

    def __int__(self) -> int:
        return int(self.number.settled(int))

    def _sympystr(self, _: object) -> str:
        return repr(self.number)

    _latex = _sympyrepr = _sympystr

    def _mpmathcode(self, printer: Any) -> str:
        # A function of mpmath is called at any precision: so many digits that none asks for more.
        return f"{printer._module_format('mpmath.mpf')}('{self.number.digits(300)}')"


@dataclass(frozen=True, slots=True, repr=False)
class ExactNumber(RealNumber):
    """A number given in closed form: rational, or rational in pi."""

    value: Expr

    def _sympy_(self) -> Expr:
        return self.value

    def __repr__(self) -> str:
        return str(self.value) if len(str(self.value)) <= 20 else self.digits()

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return expression_ball(self.value)

    def __str__(self) -> str:
        return str(self.value)


@dataclass(frozen=True, slots=True, repr=False)
class SquareRoot(RealNumber):
    """The square root of a number that is not negative.

    >>> SquareRoot(ExactNumber(Integer(2))).digits(10)
    '1.414213562'
    """

    square: RealNumber

    def _sympy_(self) -> Expr:
        return sqrt(in_sympy(self.square))

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.square.ball(bits).max(arb(0)).sqrt()


_FUNCTIONS: dict[Any, Callable[[Ball], Ball]] = {
    cos: arb.cos,
    sin: arb.sin,
    tan: arb.tan,
    sinc: arb.sinc,
    log: arb.log,
}


def is_in_pi(value: Expr) -> bool:
    """Whether an expression is made of rational numbers and pi by + - * / and whole powers."""
    if value.is_Pow:
        return bool(value.exp.is_Integer) and is_in_pi(value.base)
    if value.is_Add or value.is_Mul:
        return all(map(is_in_pi, value.args))
    return value == pi or bool(value.is_Rational)


def expression_ball(value: Expr, known: Mapping[Expr, Ball] = MappingProxyType({})) -> Ball:
    """A ball around a number made of rationals, pi, roots, logarithms, sines and tangents, at the
    current working precision.

    ``known``: balls that symbols stand for.
    """
    if value.is_Rational:
        return arb(fmpq(int(value.p), int(value.q)))
    if known and value in known:
        return known[value]
    if value is pi:
        return arb.pi()
    if isinstance(value, Proven):
        return value.number.ball(flint.ctx.prec)
    if value.is_Add or value.is_Mul:
        return reduce(add if value.is_Add else mul, (expression_ball(x, known) for x in value.args))
    # A whole power is a product, and allows a negative base; any other one needs a logarithm, which
    # 0 has not.
    if isinstance(value, Pow) and isinstance(value.exp, Integer):
        return expression_ball(value.base, known) ** int(value.exp)
    if isinstance(value, Pow):
        base = expression_ball(value.base, known)
        if base.is_zero() and value.exp.is_positive:
            return base
        return (base.log() * expression_ball(value.exp, known)).exp()
    if value.func in _FUNCTIONS:
        return _FUNCTIONS[value.func](expression_ball(value.args[0], known))
    raise TypeError(
        f"{value} is not a real number made of rational numbers, pi, roots, logarithms, "
        f"sines, cosines and tangents"
    )


def short(x: RealNumber, digits: int = 5) -> str:
    """A number with so many digits, without zeros at their end, for use in a sentence.

    >>> short(ExactNumber(Rational(5, 2))), short(ExactNumber(pi))
    ('2.5', '3.1416')
    """
    shown = x.digits(digits)
    return shown.rstrip("0").rstrip(".") if "." in shown and "E" not in shown else shown


class Way(Enum):
    """How a number is rounded where it is printed: bounds and ranges outward, allowed sets inward,
    all else to the nearest."""

    NEAREST = ROUND_HALF_EVEN
    DOWN = ROUND_FLOOR
    UP = ROUND_CEILING


Printable: TypeAlias = "RealNumber | Fraction | Expr | float"


def printed(x: Printable, digits: int, way: Way) -> str:
    """A number as it is printed: with so many significant digits, rounded once, from the full
    number.

    A number that needs no more digits is printed exactly. ``DOWN``: not larger than the number,
    ``UP``: not less; proven.

    >>> printed(ExactNumber(pi), 4, Way.DOWN), printed(ExactNumber(pi), 4, Way.UP), printed(2.5, 4, Way.UP)
    ('3.141', '3.142', '2.5')
    >>> printed(ExactNumber(Integer(70) - Rational(1, 10**9)), 4, Way.NEAREST), printed(14646442000.5, 4, Way.UP)
    ('70.00', '1.465e10')
    """
    if isinstance(x, float) and not isfinite(x):
        return "undefined" if isnan(x) else "-infinity" if x < 0 else "infinity"
    if isinstance(x, Expr):
        x = ExactNumber(x)
    # A float stands for its shortest decimal text: 0.1 is one tenth.
    if isinstance(x, float | int):
        x = Fraction(repr(float(x)) if isinstance(x, float) else x)
    if isinstance(x, ExactNumber) and x.value.is_Rational:
        x = Fraction(int(x.value.p), int(x.value.q))
    if isinstance(x, Fraction):
        return _readable(_decimal(x, Context(prec=digits, rounding=way.value)), digits, x)
    if way is Way.NEAREST:
        return _readable(Decimal(x.digits(digits)), digits)
    # A number at a short decimal (a maximum at 3.6) may not be known to be exactly that. If its
    # enclosure is still around the decimal with ``_SAME`` bits, it is printed so, not rounded away.
    low, high = x.bounds(bits_for(digits + 3))
    nearest = _decimal(low, Context(prec=digits))
    if low <= Fraction(nearest) <= high:
        low, high = x.bounds(_SAME)
        if low <= Fraction(nearest) <= high and (high - low) * 2 ** (_SAME - 10) <= abs(low):
            return _readable(nearest, digits, Fraction(nearest))
    return _readable(
        _decimal(low if way is Way.DOWN else high, Context(prec=digits, rounding=way.value)), digits
    )


def _readable(x: Decimal, digits: int, exact: Fraction | None = None) -> str:
    """Positional notation where that is readable, else with an exponent; zeros at the end only
    where digits were cut off, that is, where ``exact`` is another number."""
    if x.is_zero():
        return "0"
    if exact == Fraction(x) and _SMALLEST <= x.adjusted() < max(_LARGEST, digits):
        return f"{x.normalize():f}"
    x = x.quantize(Decimal(1).scaleb(x.adjusted() - digits + 1), context=Context(prec=digits + 2))
    if _SMALLEST <= x.adjusted() < max(_LARGEST, digits):
        return f"{x:f}"
    mantissa = (
        x.scaleb(-x.adjusted()).normalize() if exact == Fraction(x) else x.scaleb(-x.adjusted())
    )
    return f"{mantissa:f}e{x.adjusted()}"


_SAME = 200
"""Bits of agreement with a short decimal, from which on a number is printed as that decimal: a
maximum at 3.6 is not printed as "above 3.601"."""
_SMALLEST, _LARGEST = -4, 7  # powers of ten of numbers that are printed without an exponent


@dataclass(frozen=True, slots=True, repr=False)
class Scaled(RealNumber):
    """A number in another unit, as certain as the number.

    >>> Scaled(SquareRoot(ExactNumber(Integer(2))), Rational(1, 1000)).digits(4)
    '1414'
    """

    number: RealNumber
    unit: Expr
    """The size of the unit, in SI units."""

    def _sympy_(self) -> Expr:
        return in_sympy(self.number) / self.unit

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.number.ball(bits) / expression_ball(self.unit)


def in_unit(x: Printable, unit: Expr) -> Printable:
    """A number in SI units, converted to a unit of that size: a float stays a float, an exact
    number stays exact."""
    if unit == 1:
        return x
    if isinstance(x, ExactNumber | Expr):
        return ExactNumber((x if isinstance(x, Expr) else x.value) / unit)
    if isinstance(x, RealNumber):
        return Scaled(x, unit)
    size = float(unit)
    if isinstance(x, float):
        return x / size
    return x / Fraction(int(unit.p), int(unit.q)) if unit.is_Rational else float(x) / size


def bounds(ball: Ball) -> tuple[Fraction, Fraction]:
    """Rational lower and upper bound of a ball, at the current working precision or better.

    >>> bounds(arb("0.5"))
    (Fraction(1, 2), Fraction(1, 2))
    """
    middle, radius = _dyadic(ball.mid()), _dyadic(ball.rad())
    return middle - radius, middle + radius


def _dyadic(exact: Ball) -> Fraction:
    """The number that a ball without radius is."""
    mantissa, exponent = map(int, exact.man_exp())
    return Fraction(mantissa << exponent) if exponent >= 0 else Fraction(mantissa, 1 << -exponent)


@dataclass(frozen=True, slots=True, repr=False)
class Negative(RealNumber):
    """The opposite of a number.

    >>> Negative(ExactNumber(Integer(2))).digits(3)
    '-2.00'
    """

    number: RealNumber

    def _sympy_(self) -> Expr:
        return -in_sympy(self.number)

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return -self.number.ball(bits)


def rational(x: Fraction) -> Rational:
    """The same number as SymPy has it.

    >>> rational(Fraction(2, 6))
    1/3
    """
    return Rational(x.numerator, x.denominator)


def rational_between(
    low: RealNumber | None, high: RealNumber | None, own: Expr | None = None
) -> Rational:
    """The simplest rational number strictly between two different numbers; None stands for no bound
    on that side.

    ``own`` : the one that is taken if it lies between.

    >>> rational_between(ExactNumber(Rational(1, 3)), ExactNumber(Rational(2, 3))), rational_between(ExactNumber(pi), None)
    (1/2, 4)
    >>> rational_between(ExactNumber(Integer(0)), None, Rational(3, 250)), rational_between(ExactNumber(pi), None, Integer(3))
    (3/250, 4)
    """
    if isinstance(own, Rational) and _is_between(low, own, high):
        return own
    if low is None:
        return Integer(0) if high is None else Integer(ceil(high.bounds(16)[0]) - 1)
    if high is None:
        return Integer(floor(low.bounds(16)[1]) + 1)

    # Between the upper bound of the one and the lower bound of the other: strictly between the
    # numbers.
    def ends(bits: int) -> tuple[Fraction, Fraction] | None:
        below, above = low.bounds(bits)[1], high.bounds(bits)[0]
        return (below, above) if below < above else None

    apart = at_rising_precision(ends, 16, SURE_BITS)
    if apart is None:
        raise UndecidedError("whether two numbers are different")
    return rational(_simplest(*apart))


def _is_between(low: RealNumber | None, own: Rational, high: RealNumber | None) -> bool:
    """Whether a number is shown to lie strictly between two others; False proves nothing."""
    with flint.ctx.workprec(_FEW_BITS):
        here = arb(fmpq(int(own.p), int(own.q)))
        return bool(
            (low is None or low.ball(_FEW_BITS) < here)
            and (high is None or here < high.ball(_FEW_BITS))
        )


def _simplest(low: Fraction, high: Fraction) -> Fraction:
    """The fraction with the smallest denominator strictly between two others: their common
    continued fraction, up to where they part."""
    if low < 0:
        return Fraction(0) if high > 0 else -_simplest(-high, -low)
    whole = floor(low)
    if whole + 1 < high:
        return Fraction(whole + 1)
    # No whole number in between. With a whole ``low``, its fraction has no further term to share.
    if low == whole:
        return whole + Fraction(1, floor(1 / (high - whole)) + 1)
    return whole + 1 / _simplest(1 / (high - whole), 1 / (low - whole))


def fraction_ball(x: Fraction) -> Ball:
    """A fraction as a ball of the current working precision."""
    return arb(x.numerator) / arb(x.denominator)


def dyadic(x: Fraction) -> Ball:
    """A dyadic fraction as an exact ball.

    >>> dyadic(Fraction(3, 8))
    0.375000000000000
    """
    return arb(x.numerator) * arb(2) ** (1 - x.denominator.bit_length())


@dataclass(frozen=True, slots=True, repr=False)
class Sliver(RealNumber):
    """A number of which no more is known than two dyadic fractions between which it lies."""

    low: Fraction
    high: Fraction

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return dyadic(self.low).union(dyadic(self.high))

    def bounds(self, bits: int) -> tuple[Fraction, Fraction]:
        return self.low, self.high

    def __float__(self) -> float:
        return float((self.low + self.high) / 2)

    def digits(self, count: int = 15) -> str:
        """The digits that are known, at most ``count``.

        >>> Sliver(Fraction(1, 4), Fraction(1, 4) + Fraction(1, 2**40)).digits(30)
        '0.25000000000'
        """
        known = (rounded(self.low, self.high, n) for n in range(whole("digits", count), 0, -1))
        return next(filter(None, known), "") or rounded(self.low, self.low, 1) or ""
