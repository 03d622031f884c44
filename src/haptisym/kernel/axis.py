"""Real functions on ``s = j omega`` as quotients of polynomials: a delay is an all-pass in the real
variable t = tan(omega tau/2).

exp(-j omega tau) = (1 - j t)/(1 + j t), and s^alpha is omega^alpha times a constant of the same
kind: both become quotients of polynomials, exact, with exact cancellation. Cosines and sines come
back where a function is written or computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb, prod
from typing import TypeAlias

from flint import fmpq
from sympy import Expr, Symbol, chebyshevt, chebyshevu, cos, pi, sin, sinc

from haptisym.kernel.budget import afford, room
from haptisym.kernel.rings import (
    Polynomial,
    PolynomialRing,
    RationalFunction,
    degree_in,
    monomials,
    omega,
)

ComplexPolynomial: TypeAlias = tuple[Polynomial, Polynomial]
"""Real and imaginary part of a polynomial on ``s = j omega``."""
CONSTANT = -1
"""The number of the constant 1 among the ``harmonics`` of an angle."""


@dataclass(frozen=True)
class Angle:
    """An angle whose half-angle tangent is a variable: omega tau of a delay, or the constant alpha
    pi/2 of ``s^alpha``."""

    rate: Expr
    """Radians per rad/s; for a constant angle, radians."""
    constant: bool = False

    @property
    def value(self) -> Expr:
        """The angle itself, in rad."""
        return self.rate if self.constant else self.rate * omega


class Axis(PolynomialRing):
    """Real functions on ``s = j omega``: polynomials in omega, pi, the parameters, tan(angle/2) and
    omega^alpha.

    ``symbols``, ``lags``, ``orders``: those of the dynamics, and ``j`` whether the imaginary unit
    is among their numbers.
    """

    def __init__(
        self,
        symbols: Iterable[Symbol],
        lags: Sequence[Expr],
        orders: Sequence[Expr],
        *,
        j: bool = False,
    ) -> None:
        self.angles = (
            *(Angle(lag) for lag in lags),
            *(Angle(pi * x / 2, constant=True) for x in orders),
        )
        self.lags, self.orders = tuple(lags), tuple(orders)
        # A name, not tan(...) itself, which SymPy would evaluate at a known angle.
        tangents = [Symbol(f"tan({angle.value}/2)") for angle in self.angles]
        super().__init__(omega, symbols, [*tangents, *(omega**order for order in orders)])
        self.delays, self.complex = len(lags), j

    def convert(self, expression: Expr) -> RationalFunction:
        """The element that a SymPy expression is, of cosines and sines of multiples of the angles,
        too.

        >>> from sympy import Integer
        >>> axis = Axis((), (Integer(2),), ())
        >>> axis.trigonometric(axis.convert(omega * cos(4 * omega) + 3)).expression()
        omega*cos(4*omega) + 3
        """
        if isinstance(expression, cos | sin):
            for angle, tangent in zip(self.angles, self.functions, strict=False):
                n = expression.args[0] / angle.value
                if n.is_Integer and n > 0:
                    # cos n a = T_n(cos a), sin n a = U_(n-1)(cos a) sin a.
                    cosine = (1 - tangent**2) / (1 + tangent**2)
                    sine = 2 * tangent / (1 + tangent**2)
                    if isinstance(expression, cos):
                        return super().convert(chebyshevt(n, cosine))
                    return super().convert(chebyshevu(n - 1, cosine) * sine)
        if expression.is_Pow and expression.base == omega:
            for order in self.orders:
                if (n := expression.exp / order).is_Integer and not expression.exp.is_Integer:
                    return super().convert(omega**order) ** int(n)
        return super().convert(expression)

    def parts(self, polynomials: Sequence[Polynomial]) -> list[ComplexPolynomial]:
        """Real and imaginary part of each polynomial in the dynamics' ring, all times the same
        factor that is not zero."""
        if not self.functions and not self.complex:
            return [self._even_and_odd(p) for p in polynomials]
        # One common degree for all polynomials, so that quotients of them keep their values.
        highest = [degree_in(polynomials, self.size + i) for i in range(len(self.angles))]
        return [self._turned(p, highest) for p in polynomials]

    def _even_and_odd(self, polynomial: Polynomial) -> ComplexPolynomial:
        """Real and imaginary part of a polynomial in s: j^n is 1, j, -1, -j in turn."""
        split: tuple[dict[object, object], dict[object, object]] = ({}, {})
        for exponents, coefficient in monomials(polynomial):
            power = int(exponents[0])
            split[power % 2][exponents] = -coefficient if power % 4 >= 2 else coefficient
        return self.context.from_dict(split[0]), self.context.from_dict(split[1])

    def _turned(self, polynomial: Polynomial, highest: Sequence[int]) -> ComplexPolynomial:
        """Real and imaginary part of a polynomial: each monomial s^n E^k A^l j^i is j^(n + i) times
        all-passes in the half-angle tangents.

        ``highest`` : the degree in each delay and power, in all polynomials that share the factor
        (1 + j t)^highest by which they are multiplied.
        """
        real, imag = self.constant(0), self.constant(0)
        gens, first = self.context.gens(), self.size + len(self.angles)
        groups = self._alike(polynomial)
        # How many terms there will be, asked for before memory and time are spent on them.
        before = sum(len(x) + len(y) for x, y in groups.values())
        terms = before * prod(most + 1 for most in highest)
        room(terms)
        afford(terms)
        for turns, (x, y) in groups.items():
            for i, (turn, most) in enumerate(zip(turns, highest, strict=False)):
                a, b = self._all_pass(i, turn, most)
                x, y = x * a - y * b, x * b + y * a
            for i, turn in enumerate(turns[self.delays : len(highest)]):
                power = gens[first + i] ** turn
                x, y = x * power, y * power
            real, imag = real + x, imag + y
        return real, imag

    def _alike(self, polynomial: Polynomial) -> dict[tuple[int, ...], ComplexPolynomial]:
        """The cofactor at s = j omega of each product of delays and powers, by their exponents."""
        groups: dict[tuple[int, ...], tuple[dict[object, object], dict[object, object]]] = {}
        rest = (0,) * (len(self.meanings) - self.size)
        end = self.size + len(self.angles)
        for exponents, coefficient in monomials(polynomial):
            degrees = tuple(map(int, exponents))
            # The power of j, of s = j omega and of the imaginary unit among the numbers.
            quarter = degrees[0] + (degrees[-1] if self.complex else 0)
            sides = groups.setdefault(degrees[self.size : end], ({}, {}))
            side = sides[quarter % 2]
            place = degrees[: self.size] + rest
            turned = -coefficient if quarter % 4 >= 2 else coefficient
            side[place] = side.get(place, 0) + turned
        return {turns: tuple(map(self.context.from_dict, sides)) for turns, sides in groups.items()}

    @lru_cache(maxsize=256)  # noqa: B019 - a ring lives as long as its functions
    def _all_pass(self, index: int, turn: int, most: int) -> ComplexPolynomial:
        """exp(-j k angle) (1 + j t)^most = (1 - j t)^k (1 + j t)^(most - k); the angle of s^alpha
        turns the other way."""
        t = self.context.gens()[self.size + index]
        forward = t if index >= self.delays else -t
        x, y = self.constant(1), self.constant(0)
        # Times 1 + j t, or 1 - j t, once for each factor.
        for factor in [forward] * turn + [-forward] * (most - turn):
            x, y = x - y * factor, y + x * factor
        return x, y

    def derivative(self, polynomial: Polynomial) -> RationalFunction:
        """d/d omega, with d tan(a/2) = (1 + tan(a/2)^2)/2 da and d omega^alpha = alpha omega^(alpha
        - 1) d omega."""
        total = self.function(polynomial.derivative(0))
        for i, angle in enumerate(self.angles, self.size):
            if not angle.constant:
                turned = (1 + self.context.gens()[i] ** 2) * polynomial.derivative(i)
                total += self.convert(angle.rate / 2) * self.function(turned)
        for i, order in enumerate(self.orders, self.size + len(self.angles)):
            raised = self.context.gens()[i] * polynomial.derivative(i)
            total += self.convert(order) * self.function(raised, self.variable)
        return total

    def trigonometric(self, function: RationalFunction) -> RationalFunction:
        """The function in cosines and sines of the angles and their multiples, as a person would
        write it."""
        degrees = [
            degree_in([function.numerator, function.denominator], self.size + i)
            for i in range(len(self.angles))
        ]
        # An even degree in cosine and sine of the half angle makes harmonics of the angle itself.
        even = [n + n % 2 for n in degrees]
        waves = [
            (cos(n * a.value), sin(n * a.value))
            for a, top in zip(self.angles, even, strict=True)
            for n in range(1, top // 2 + 1)
        ]
        powers = self.functions[len(self.angles) :]
        target = PolynomialRing(
            omega, self.symbols, [*powers, *(wave for pair in waves for wave in pair)]
        )
        return target.function(
            *(self._waves(p, even, target) for p in (function.numerator, function.denominator))
        )

    def _waves(
        self, polynomial: Polynomial, even: Sequence[int], target: PolynomialRing
    ) -> Polynomial:
        """A polynomial in half-angle tangents, times cosines of half angles to the ``even`` powers,
        in harmonics of the angles."""
        # By the exponents of tangents, which one angle after the other become numbers of harmonics.
        rows: dict[tuple[int, ...], dict[tuple[int, ...], fmpq]] = {}
        for exponents, coefficient in monomials(polynomial):
            degrees = [int(n) for n in exponents]
            turns, powers = (
                degrees[self.size : self.size + len(even)],
                degrees[self.size + len(even) :],
            )
            rows.setdefault(tuple(turns), {})[*degrees[: self.size], *powers] = coefficient
        for i, top in enumerate(even):
            spread: dict[tuple[int, ...], dict[tuple[int, ...], fmpq]] = {}
            for turned, row in rows.items():
                for wave, share in harmonics(turned[i], top).items():
                    into = spread.setdefault((*turned[:i], wave, *turned[i + 1 :]), {})
                    for rest, value in row.items():
                        into[rest] = into.get(rest, 0) + share * value
            rows = spread
        terms = {
            (*rest, *_places(waves, even)): x
            for waves, row in rows.items()
            for rest, x in row.items()
            if x
        }
        return target.context.from_dict(terms)

    def without_circles(self, polynomial: Polynomial) -> tuple[Polynomial, list[int]]:
        """A polynomial without its factors 1 + tan^2, and how many there were of each angle: cos^2
        + sin^2 is 1."""
        counts = [0] * len(self.angles)
        if polynomial.is_zero():
            return polynomial, counts
        degrees = polynomial.degrees()[self.size :]
        for i, circle in enumerate(self._circles):
            for _ in range(int(degrees[i]) // 2):
                quotient, rest = divmod(polynomial, circle)
                if not rest.is_zero():
                    break
                polynomial, counts[i] = quotient, counts[i] + 1
        return polynomial, counts

    @cached_property
    def _circles(self) -> list[Polynomial]:
        """1 + tan^2 of each half angle."""
        return [
            tangent**2 + 1
            for tangent in self.context.gens()[self.size : self.size + len(self.angles)]
        ]

    def reduced(self, function: RationalFunction) -> RationalFunction:
        """In lowest terms, the denominator with leading coefficient 1; its factors 1 + tan^2 are
        tried alone, which is fast."""
        top, bottom = function.numerator, function.denominator
        afford(len(top), len(bottom))
        # Factors 1 + tan^2 come from every delay: divided out one by one, they leave a much shorter
        # denominator for the search for a common divisor.
        core, counts = self.without_circles(bottom)
        for circle, count in zip(self._circles, counts, strict=True):
            for _ in range(count):
                quotient, rest = divmod(top, circle)
                if not rest.is_zero():
                    break
                top, bottom = quotient, bottom / circle
        common = top.gcd(core)
        if not common.is_one():
            top, bottom = top / common, bottom / common
        return self.function(top, bottom).monic()

    def half_angles(self, function: RationalFunction) -> RationalFunction:
        """The function in half angles, cos(a/2) and sin(a/2)/omega: without cancellation at low
        frequencies, nor 0/0 at 0."""
        degrees = [
            degree_in([function.numerator, function.denominator], self.size + i)
            for i in range(len(self.angles))
        ]
        target = self._with_waves(_half_waves)
        return target.function(
            *(
                self._homogeneous(p, degrees, target, over=1)
                for p in (function.numerator, function.denominator)
            )
        )

    def in_half_angles(self, polynomial: Polynomial) -> RationalFunction:
        """A polynomial times cosines of half angles, in their cosines and sines: as short as in
        tangents, with all its zeros."""
        degrees = [degree_in([polynomial], self.size + i) for i in range(len(self.angles))]
        target = self._with_waves(lambda angle: (cos(angle.value / 2), sin(angle.value / 2)))
        return target.function(self._homogeneous(polynomial, degrees, target, over=0))

    def _with_waves(self, waves: Callable[[Angle], tuple[Expr, Expr]]) -> PolynomialRing:
        """A ring with two waves of each angle in place of its tangent."""
        own = [wave for angle in self.angles for wave in waves(angle)]
        return PolynomialRing(omega, self.symbols, [*self.functions[len(self.angles) :], *own])

    def _homogeneous(
        self, polynomial: Polynomial, degrees: Sequence[int], target: PolynomialRing, *, over: int
    ) -> Polynomial:
        """A polynomial made homogeneous of these degrees in cosine and sine of each half angle;
        sines of angles that turn stand for sine over omega^``over``."""
        # A factor 1 + tan^2 is 1/cos^2: it lowers the degree by 2 instead.
        polynomial, circles = self.without_circles(polynomial)
        tops = [n - 2 * circle for n, circle in zip(degrees, circles, strict=True)]
        terms = {}
        for exponents, coefficient in monomials(polynomial):
            all_powers = [int(n) for n in exponents]
            turns = all_powers[self.size : self.size + len(degrees)]
            powers = all_powers[self.size + len(degrees) :]
            turning = zip(turns, self.angles, strict=True)
            all_powers[0] += over * sum(k for k, angle in turning if not angle.constant)
            halves = [n for k, top in zip(turns, tops, strict=True) for n in (top - k, k)]
            terms[(*all_powers[: self.size], *powers, *halves)] = coefficient
        return target.context.from_dict(terms)


def _places(waves: Sequence[int], tops: Sequence[int]) -> list[int]:
    """The exponents of a product of waves, one of each angle."""
    return [int(n == wave) for wave, top in zip(waves, tops, strict=True) for n in range(top)]


def _half_waves(angle: Angle) -> tuple[Expr, Expr]:
    """Cosine of a half angle, and its sine over omega; of a constant angle the sine itself."""
    half = angle.value / 2
    return cos(half), sin(half) if angle.constant else angle.rate / 2 * sinc(half)


@lru_cache(maxsize=1024)
def harmonics(k: int, top: int) -> dict[int, fmpq]:
    """sin(x/2)^k cos(x/2)^(top - k), top even, as a sum of harmonics with these coefficients:
    `CONSTANT` stands for 1, 2 (n - 1) for cos n x, 2 n - 1 for sin n x."""
    # z = exp(j x/2): sin = (z - 1/z)/(2 j), cos = (z + 1/z)/2, and j^k only turns the result.
    coefficients: dict[int, int] = {}
    for a in range(k + 1):
        for b in range(top - k + 1):
            n = top - 2 * (a + b)
            coefficients[n] = coefficients.get(n, 0) + (-1) ** a * comb(k, a) * comb(top - k, b)
    sign = (-1) ** (k // 2)
    shares = {}
    for n, c in coefficients.items():
        if c == 0 or n < 0:
            continue
        if n == 0:
            shares[CONSTANT] = fmpq(sign * c, 2**top)
        else:  # even k pairs up to 2 cos, odd k to 2 j sin, over j^k
            shares[n - 2 if k % 2 == 0 else n - 1] = fmpq(2 * sign * c, 2**top)
    return shares
