"""Real functions on ``s = j omega`` as quotients of polynomials: a delay is an all-pass in the real
variable t = tan(omega tau/2).

exp(-j omega tau) = (1 - j t)/(1 + j t), and s^alpha is omega^alpha times a constant of the same
kind: both become quotients of polynomials, exact, with exact cancellation. Cosines and sines come
back where a function is written or computed.

The exponents of a monomial of an ``Axis`` are those of omega, of pi and the parameters (``size``
in all), of tan(angle/2) for each angle, delays first, and of omega^alpha for each order. A *wave*
is a cosine or a sine of a multiple of an angle. Begin with ``Axis.parts``.
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
    is among their numbers. ``turned``, ``fixed``: further angles and functions that do not depend
    on omega.
    """

    def __init__(
        self,
        symbols: Iterable[Symbol],
        lags: Sequence[Expr],
        orders: Sequence[Expr],
        *,
        j: bool = False,
        turned: Sequence[Expr] = (),
        fixed: Sequence[Expr] = (),
    ) -> None:
        of_delays = [Angle(lag) for lag in lags]
        constant = [Angle(x, constant=True) for x in (*(pi * y / 2 for y in orders), *turned)]
        self.angles = (*of_delays, *constant)
        self.lags = tuple(lags)
        self.orders = tuple(orders)
        # A name, not tan(...) itself, which SymPy would evaluate at a known angle.
        tangents = [Symbol(f"tan({angle.value}/2)") for angle in self.angles]
        powers = [omega**order for order in orders]
        super().__init__(omega, symbols, [*tangents, *powers, *fixed])
        self.delays = len(lags)
        self.complex = j

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
                    circle = 1 + tangent**2
                    cosine = (1 - tangent**2) / circle
                    sine = 2 * tangent / circle
                    if isinstance(expression, cos):
                        return super().convert(chebyshevt(n, cosine))
                    return super().convert(chebyshevu(n - 1, cosine) * sine)
        if expression.is_Pow and expression.base == omega:
            exponent = expression.exp
            for order in self.orders:
                n = exponent / order
                if n.is_Integer and not exponent.is_Integer:
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
            side = split[power % 2]
            side[exponents] = -coefficient if power % 4 >= 2 else coefficient
        real, imag = map(self.context.from_dict, split)
        return real, imag

    def _turned(self, polynomial: Polynomial, highest: Sequence[int]) -> ComplexPolynomial:
        """Real and imaginary part of a polynomial: each monomial s^n E^k A^l j^i is j^(n + i) times
        all-passes in the half-angle tangents.

        ``highest`` : the degree in each delay and power, in all polynomials that share the factor
        (1 + j t)^highest by which they are multiplied.
        """
        real = imag = self.constant(0)
        first_power = self.size + len(self.angles)
        powers = self.context.gens()[first_power:]
        groups = self._alike(polynomial)
        # How many terms there will be, asked for before memory and time are spent on them.
        before = sum(len(x) + len(y) for x, y in groups.values())
        terms = before * prod(most + 1 for most in highest)
        room(terms)
        afford(terms)
        for exponents, (x, y) in groups.items():
            for i, (n, most) in enumerate(zip(exponents, highest, strict=False)):
                a, b = self._all_pass(i, n, most)
                x, y = x * a - y * b, x * b + y * a
            for power, n in zip(powers, exponents[self.delays :], strict=False):
                factor = power**n
                x = x * factor
                y = y * factor
            real = real + x
            imag = imag + y
        return real, imag

    def _alike(self, polynomial: Polynomial) -> dict[tuple[int, ...], ComplexPolynomial]:
        """The cofactor at s = j omega of each product of delays and powers, by their exponents."""
        groups: dict[tuple[int, ...], tuple[dict[object, object], dict[object, object]]] = {}
        rest = (0,) * (len(self.meanings) - self.size)
        end = self.size + len(self.angles)
        for exponents, coefficient in monomials(polynomial):
            degrees = tuple(map(int, exponents))
            # The power of j, of s = j omega and of the imaginary unit among the numbers.
            quarter = degrees[0]
            if self.complex:
                quarter += degrees[-1]
            sides = groups.setdefault(degrees[self.size : end], ({}, {}))
            side = sides[quarter % 2]
            place = degrees[: self.size] + rest
            turned = -coefficient if quarter % 4 >= 2 else coefficient
            side[place] = side.get(place, 0) + turned
        cofactors = {}
        for key, sides in groups.items():
            real, imag = map(self.context.from_dict, sides)
            cofactors[key] = real, imag
        return cofactors

    @lru_cache(maxsize=256)  # noqa: B019 - a ring lives as long as its functions
    def _all_pass(self, index: int, k: int, most: int) -> ComplexPolynomial:
        """exp(-j k angle) (1 + j t)^most = (1 - j t)^k (1 + j t)^(most - k); the angle of s^alpha
        turns the other way."""
        t = self.context.gens()[self.size + index]
        forward = t if index >= self.delays else -t
        x = self.constant(1)
        y = self.constant(0)
        factors = [forward] * k + [-forward] * (most - k)
        # (x + j y) (1 + j t), or times 1 - j t, once for each factor.
        for factor in factors:
            x, y = x - y * factor, y + x * factor
        return x, y

    def derivative(self, polynomial: Polynomial) -> RationalFunction:
        """d/d omega, with d tan(a/2) = (1 + tan(a/2)^2)/2 da and d omega^alpha = alpha omega^(alpha
        - 1) d omega."""
        gens = self.context.gens()
        total = self.function(polynomial.derivative(0))
        for i, angle in enumerate(self.angles, self.size):
            if not angle.constant:
                circle = 1 + gens[i] ** 2
                turned = circle * polynomial.derivative(i)
                total += self.convert(angle.rate / 2) * self.function(turned)
        for i, order in enumerate(self.orders, self.size + len(self.angles)):
            raised = gens[i] * polynomial.derivative(i)
            total += self.convert(order) * self.function(raised, self.variable)
        return total

    def trigonometric(self, function: RationalFunction) -> RationalFunction:
        """The function in cosines and sines of the angles and their multiples, as a person would
        write it."""
        above, below = function.numerator, function.denominator
        # An even degree in cosine and sine of the half angle makes harmonics of the angle itself.
        even = [n + n % 2 for n in self._tangent_degrees(above, below)]
        waves: list[Expr] = []
        for angle, top in zip(self.angles, even, strict=True):
            for n in range(1, top // 2 + 1):
                waves += cos(n * angle.value), sin(n * angle.value)
        powers = self.functions[len(self.angles) :]
        target = PolynomialRing(omega, self.symbols, [*powers, *waves])
        numerator = self._waves(above, even, target)
        return target.function(numerator, self._waves(below, even, target))

    def _tangent_degrees(self, *polynomials: Polynomial) -> list[int]:
        """The common degree of polynomials in the tangent of each half angle."""
        return [degree_in(polynomials, self.size + i) for i in range(len(self.angles))]

    def _waves(
        self, polynomial: Polynomial, even: Sequence[int], target: PolynomialRing
    ) -> Polynomial:
        """A polynomial in half-angle tangents, times cosines of half angles to the ``even`` powers,
        in harmonics of the angles."""
        # By the exponents of tangents, which one angle after the other become numbers of harmonics.
        rows: dict[tuple[int, ...], dict[tuple[int, ...], fmpq]] = {}
        end = self.size + len(even)
        for exponents, coefficient in monomials(polynomial):
            degrees = [int(n) for n in exponents]
            of_tangents = tuple(degrees[self.size : end])
            others = (*degrees[: self.size], *degrees[end:])
            row = rows.setdefault(of_tangents, {})
            row[others] = coefficient
        for i, top in enumerate(even):
            spread: dict[tuple[int, ...], dict[tuple[int, ...], fmpq]] = {}
            for key, row in rows.items():
                before, after = key[:i], key[i + 1 :]
                for wave, share in harmonics(key[i], top).items():
                    into = spread.setdefault((*before, wave, *after), {})
                    for rest, value in row.items():
                        into[rest] = into.get(rest, 0) + share * value
            rows = spread
        terms = {}
        for numbers, row in rows.items():
            places = _places(numbers, even)
            for rest, value in row.items():
                if value:
                    terms[(*rest, *places)] = value
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
                polynomial = quotient
                counts[i] += 1
        return polynomial, counts

    @cached_property
    def _circles(self) -> list[Polynomial]:
        """1 + tan^2 of each half angle."""
        end = self.size + len(self.angles)
        tangents = self.context.gens()[self.size : end]
        return [tangent**2 + 1 for tangent in tangents]

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
                top = quotient
                bottom = bottom / circle
        common = top.gcd(core)
        if not common.is_one():
            top = top / common
            bottom = bottom / common
        return self.function(top, bottom).monic()

    def half_angles(self, function: RationalFunction) -> RationalFunction:
        """The function in half angles, cos(a/2) and sin(a/2)/omega: without cancellation at low
        frequencies, nor 0/0 at 0."""
        above, below = function.numerator, function.denominator
        degrees = self._tangent_degrees(above, below)
        target = self._with_waves(_half_waves)
        numerator = self._homogeneous(above, degrees, target, over=1)
        denominator = self._homogeneous(below, degrees, target, over=1)
        return target.function(numerator, denominator)

    def in_half_angles(self, polynomial: Polynomial) -> RationalFunction:
        """A polynomial times cosines of half angles, in their cosines and sines: as short as in
        tangents, with all its zeros."""
        degrees = self._tangent_degrees(polynomial)
        target = self._with_waves(lambda angle: (cos(angle.value / 2), sin(angle.value / 2)))
        in_waves = self._homogeneous(polynomial, degrees, target, over=0)
        return target.function(in_waves)

    def _with_waves(self, waves: Callable[[Angle], tuple[Expr, Expr]]) -> PolynomialRing:
        """A ring with two waves of each angle in place of its tangent."""
        own = [wave for angle in self.angles for wave in waves(angle)]
        powers = self.functions[len(self.angles) :]
        return PolynomialRing(omega, self.symbols, [*powers, *own])

    def _homogeneous(
        self, polynomial: Polynomial, degrees: Sequence[int], target: PolynomialRing, *, over: int
    ) -> Polynomial:
        """A polynomial made homogeneous of these degrees in cosine and sine of each half angle;
        sines of angles that turn stand for sine over omega^``over``."""
        # A factor 1 + tan^2 is 1/cos^2: it lowers the degree by 2 instead.
        polynomial, circles = self.without_circles(polynomial)
        tops = [n - 2 * circle for n, circle in zip(degrees, circles, strict=True)]
        end = self.size + len(degrees)
        terms = {}
        for exponents, coefficient in monomials(polynomial):
            all_powers = [int(n) for n in exponents]
            of_tangents = all_powers[self.size : end]
            powers = all_powers[end:]
            of_waves: list[int] = []
            for k, top, angle in zip(of_tangents, tops, self.angles, strict=True):
                of_waves += top - k, k  # of the cosine, and of the sine
                if not angle.constant:
                    all_powers[0] += over * k
            terms[(*all_powers[: self.size], *powers, *of_waves)] = coefficient
        return target.context.from_dict(terms)


def _places(waves: Sequence[int], tops: Sequence[int]) -> list[int]:
    """The exponents of a product of waves, one of each angle, given their numbers among the
    harmonics."""
    places = []
    for wave, top in zip(waves, tops, strict=True):
        places += [int(n == wave) for n in range(top)]
    return places


def _half_waves(angle: Angle) -> tuple[Expr, Expr]:
    """Cosine of a half angle, and its sine over omega; of a constant angle the sine itself."""
    half = angle.value / 2
    sine = sin(half) if angle.constant else angle.rate / 2 * sinc(half)
    return cos(half), sine


@lru_cache(maxsize=1024)
def harmonics(k: int, top: int) -> dict[int, fmpq]:
    """sin(x/2)^k cos(x/2)^(top - k), top even, as a sum of harmonics with these coefficients:
    `CONSTANT` stands for 1, 2 (n - 1) for cos n x, 2 n - 1 for sin n x."""
    # z = exp(j x/2): sin = (z - 1/z)/(2 j), cos = (z + 1/z)/2, and j^k only turns the result.
    coefficients: dict[int, int] = {}
    for a in range(k + 1):
        of_sine = (-1) ** a * comb(k, a)
        for b in range(top - k + 1):
            n = top - 2 * (a + b)
            before = coefficients.get(n, 0)
            coefficients[n] = before + of_sine * comb(top - k, b)
    sign = (-1) ** (k // 2)
    shares = {}
    for n, c in coefficients.items():
        if c == 0 or n < 0:
            continue
        if n == 0:
            shares[CONSTANT] = fmpq(sign * c, 2**top)
        else:  # even k pairs up to 2 cos, odd k to 2 j sin, over j^k
            number = n - 2 if k % 2 == 0 else n - 1
            shares[number] = fmpq(2 * sign * c, 2**top)
    return shares
