"""A program in ball arithmetic at single points, and the value of a closed form at an exact
frequency.

``BallPoint`` gives enclosures of a program's results with any number of bits. Balls never show that
a result is exactly 0, or infinite, or the limit of 0/0: ``PointValue`` decides these from the
closed form in lowest terms, over the rational numbers where that is possible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, nan
from typing import Any

import flint
from flint import arb, arb_series, fmpq, fmpq_poly
from sympy import Expr, Pow, Rational, Symbol, cos

from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.harmonics import quantiser
from haptisym.kernel.reals import MOST_BITS, Ball, RealNumber, at_rising_precision, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing, omega
from haptisym.programs.program import Program


def power(x: Ball, exponent: Ball) -> Ball:
    """x^exponent for x >= 0 and an exponent > 0; 0 at 0."""
    # The power grows with x, so it lies between 0 and that of the upper end; log 0 is not finite.
    if x.contains(0):
        top = x.upper()
        return arb(0) if top.is_zero() else arb(0).union((top.log() * exponent).exp())
    return (x.log() * exponent).exp()


def sincm1(x: Ball) -> Ball:
    """sin(x)/x - 1 with as many digits where x is small: between -x^2/6 and 0."""
    if x.contains(0):
        return arb(0).union(-(x * x).upper() / 6)
    # The difference is about x^2/6: it loses two bits for each bit that x is below 1.
    mantissa, exponent = abs(x).mid().man_exp()
    lost = max(0, -2 * (int(exponent) + int(mantissa).bit_length()))
    with flint.ctx.workprec(flint.ctx.prec + lost):
        return x.sinc() - 1


def arc_sine(x: Ball) -> Ball:
    """asin x for -1 <= x <= 1, of a ball that may reach beyond."""
    low, high = (max(min(end, arb(1)), arb(-1)).asin() for end in (x.lower(), x.upper()))
    return low.union(high)


FUNCTIONS: dict[str, Callable[..., Ball]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "neg": lambda x: -x,
    "abs": abs,
    "sqrt": lambda x: x.nonnegative_part().sqrt(),
    "cos": arb.cos,
    "sin": arb.sin,
    "sinc": arb.sinc,
    "sincm1": sincm1,
    "asin": arc_sine,
    "max": arb.max,
    "min": arb.min,
    "quantiser": quantiser.value,
    "power": power,
}


def constant_ball(value: Any) -> Ball:
    """A ball around a constant of a program, at the current working precision."""
    return arb(value) if isinstance(value, fmpq) else expression_ball(value)


@lru_cache(maxsize=256)
def _constants(program: Program, bits: int) -> dict[int, Ball]:
    steps = enumerate(program.operations)
    return {i: constant_ball(step.value) for i, step in steps if step.name == "constant"}


@dataclass(frozen=True, eq=False)
class BallPoint:
    """The results of a program for inputs that are doubles, exactly what they are."""

    program: Program
    inputs: tuple[float, ...]

    def balls(self, bits: int) -> dict[str, Ball]:
        """Balls around all results, computed with that many bits."""
        with flint.ctx.workprec(bits):
            constants = _constants(self.program, bits)
            results: Mapping[str, Ball] = self.program.run(
                FUNCTIONS, [*map(arb, self.inputs)], constants
            )
            return dict(results)


def nearest_double(ball: Ball, bits: int) -> float | None:
    """The double nearest to a number in a narrow ball, where one is nearest to all of them; a
    neighbour at a tie.

    >>> nearest_double(arb("0.1"), 53), nearest_double(arb("0.1", "1e-3"), 53)
    (0.1, None)
    """
    if not ball.is_finite():
        return None
    with flint.ctx.workprec(bits + 64):
        low, high = float(ball.lower()), float(ball.upper())
    # A number half-way between two doubles is never enclosed on one side of the middle. After so
    # many bits both neighbours are within half a unit, and a bit, of it.
    tie = ball.rel_accuracy_bits() > 200 and bits > 400
    return low if low == high or tie else None


# Of the series at omega = 0: their precision and length. A coefficient that so many bits do not
# distinguish from 0 is taken for 0.
_LIMIT_BITS, _TERMS = 1024, 32


@dataclass(frozen=True, repr=False)
class PointValue(RealNumber):
    """The value of a real function, in lowest terms and with no symbol left, at an exact frequency;
    or its square root.

    ``special`` is the value where that is 0, infinite or not a number. At omega = 0 the value is
    the limit from above.

    >>> from haptisym.kernel.dynamics import Ring
    >>> f = RealFunction(Ring().axis.convert(omega / (omega**2 + 1)))
    >>> float(PointValue(f, fmpq(3))), float(PointValue(f, fmpq(3), rooted=True)), PointValue(f, fmpq(0)).special
    (0.3, 0.5477225575051661, 0.0)
    """

    function: RealFunction
    frequency: fmpq
    rooted: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            value = self._ball()
            return value.nonnegative_part().sqrt() if self.rooted else value

    def _ball(self) -> Ball:
        # At omega = 0 the function itself may be 0/0; the quotient is then that of the limit.
        above, below = self._quotient
        if isinstance(above, fmpq):
            return arb(above / below)
        if not self.frequency:
            return above / below
        return self.function.ball(arb(self.frequency))

    def __float__(self) -> float:
        """The nearest double; infinite at a pole, not a number where there is no limit."""
        if self.special is not None:
            return self.special
        value = at_rising_precision(lambda bits: nearest_double(self.ball(bits), bits))
        if value is None:
            raise UndecidedError(
                f"{self.function.expression()} at {self.frequency} rad/s, with {MOST_BITS} bits"
            )
        return value

    @property
    def special(self) -> float | None:
        """The value as a float if it is 0, infinite or not a number, which no ball of small
        relative radius can enclose; otherwise None."""
        above, below = self._quotient
        if above is None:
            return self._pole
        if above == 0:
            return 0.0 if below != 0 else nan
        if below == 0:
            return inf if self.rooted or above > 0 else -inf
        return None

    @property
    def _pole(self) -> float | None:
        """The infinite value where the denominator, with pi or other functions in it, is exactly 0
        and the numerator is not."""
        f = self.function.function
        if not _vanishes(f.ring, f.denominator, self.frequency):
            return None
        if _vanishes(f.ring, f.numerator, self.frequency):
            return None
        if self.rooted:
            return inf
        return None  # on which side balls cannot tell

    @cached_property
    def _quotient(self) -> tuple[Any, Any]:
        """Numerator and denominator where they are rational numbers, or the limit's at 0; otherwise
        None."""
        f = self.function.function
        if f.is_zero:
            return fmpq(0), fmpq(1)
        # Without pi, delays and fractional powers the value at a double is a rational number.
        rows = [f.ring.univariate(p) for p in (f.numerator, f.denominator)]
        if rows[0] is not None and rows[1] is not None:
            return fmpq_poly(rows[0])(self.frequency), fmpq_poly(rows[1])(self.frequency)
        return (None, None) if self.frequency else self._limit()

    def _limit(self) -> tuple[Any, Any]:
        """The limit at 0 from above, from the leading terms of numerator and denominator."""
        # Of a function c omega^n/(d omega^m) to first order the limit is c/d for n = m, 0 for n >
        # m, and infinite otherwise, with the sign of c/d: as 1/0 or -1/0.
        f = self.function.half_angled
        with flint.ctx.workprec(_LIMIT_BITS):
            (n, above), (m, below) = (_leading(f.ring, p) for p in (f.numerator, f.denominator))
        if n == m:
            return above, below
        return (fmpq(0), fmpq(1)) if n > m else (fmpq(1 if above / below > 0 else -1), fmpq(0))


def _vanishes(ring: PolynomialRing, polynomial: Polynomial, frequency: fmpq) -> bool:
    """Whether a polynomial of a ring of real functions is 0 at a frequency whatever the functions
    beside omega are there."""
    # As a polynomial in the other generators it must have no coefficient but 0 at that frequency:
    # exact, and enough, though not necessary if the generators depend on each other.
    place = ring.meanings.index(omega)
    coefficients: dict[tuple[int, ...], fmpq] = {}
    for exponents, coefficient in polynomial.to_dict().items():
        powers = [int(n) for n in exponents]
        power_of_omega = powers.pop(place)
        others, value = tuple(powers), coefficient * frequency**power_of_omega
        coefficients[others] = coefficients.get(others, fmpq(0)) + value
    return not any(coefficients.values())


def _leading(ring: PolynomialRing, polynomial: Polynomial) -> tuple[Rational, Ball]:
    """The lowest power of omega in a polynomial of a ring of real functions, and its
    coefficient."""
    coefficients: dict[Rational, Ball] = {}
    for shift, series in _series(ring, polynomial):
        for n, coefficient in enumerate(series):
            coefficients[shift + n] = coefficients.get(shift + n, arb(0)) + coefficient
    nonzero = ((power, x) for power, x in coefficients.items() if not x.contains(0))
    return min(nonzero, default=(Rational(0), arb(0)))


def _series(ring: PolynomialRing, polynomial: Polynomial) -> Iterator[tuple[Rational, list[Ball]]]:
    """The terms of a polynomial, each as a fractional power of omega and a power series of the
    rest."""
    values = [_power_series(x) for x in ring.meanings]
    for exponents, coefficient in polynomial.to_dict().items():
        total, shift = arb_series([arb(coefficient)], _TERMS), Rational(0)
        for meaning, value, n in zip(ring.meanings, values, map(int, exponents), strict=True):
            if value is None:
                shift += n * meaning.exp
            elif n:
                total = total * value**n
        yield shift, [total[i] for i in range(_TERMS)]


def _power_series(meaning: Expr) -> Any:
    """A generator of such a ring as a power series in omega; None for a fractional power."""
    if meaning == omega:
        return arb_series([0, 1], _TERMS)
    # A symbol that a ring brings along, such as that of the threshold, occurs in no polynomial
    # here.
    if isinstance(meaning, Symbol):
        return arb_series([0], _TERMS)
    if not meaning.has(omega):
        return arb_series([expression_ball(meaning)], _TERMS)
    if isinstance(meaning, Pow):
        return None
    # A cosine or sin(x)/x of x = rate omega: neighbouring terms of cos x differ by the factor
    # -x^2/((n + 1)(n + 2)), those of sin(x)/x by -x^2/((n + 2)(n + 3)).
    scale, wave = meaning.as_independent(omega, as_Add=False)
    rate = expression_ball(wave.args[0] / omega)
    first = 1 if isinstance(wave, cos) else 2
    row, term = [arb(0)] * _TERMS, expression_ball(scale)
    for n in range(0, _TERMS, 2):
        row[n] = term
        term = -term * rate**2 / ((n + first) * (n + first + 1))
    return arb_series(row, _TERMS)
