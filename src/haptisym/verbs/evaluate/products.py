"""The functions behind an evaluation as products of polynomials with whole coefficients, as a certificate tells them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
from flint import arb, fmpq_poly
from sympy import Rational

from haptisym.kernel.axis import Axis
from haptisym.kernel.errors import SceneError
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.verbs.evaluate.powers import RectangularAxis
from haptisym.verbs.evaluate.waves import Rows, WaveFactor, cosine_factor, wave_factor

PI = 1  # the place of pi among what a polynomial is in
_BITS = 330  # of pi: the 100 digits that a checker has


@dataclass(frozen=True)
class Factor:
    """A polynomial in variable^step."""

    rows: Rows
    step: int

    @cached_property
    def bounds(self) -> tuple[fmpq_poly, ...]:
        """Polynomials below and above it for arguments >= 0; one alone where pi is not in it."""
        if all(len(row) == 1 for row in self.rows):
            return (fmpq_poly([row[0] for row in self.rows]),)
        with flint.ctx.workprec(_BITS):
            balls = [sum((n * arb.pi() ** i for i, n in enumerate(row)), arb(0)) for row in self.rows]
            return tuple(
                fmpq_poly([x.fmpq() for x in ends]) for ends in ([b.lower() for b in balls], [b.upper() for b in balls])
            )

    @property
    def cost(self) -> int:
        """Of a sign of it, as the limits of the format have it."""
        return len(self.rows) ** 3 * max(map(len, self.rows)) + 1000

    def told(self) -> dict[str, Any]:
        """As a certificate tells it."""
        return {"step": self.step, "polynomial": told_rows(self.rows)}

    def moved(self, low: Fraction, high: Fraction | None) -> tuple[int, ...] | None:
        """The signs of the coefficients of (1 + u)^n p((low + high u)/(1 + u)), (None: p(low + u)); None where one is open."""
        ends = low**self.step, None if high is None else high**self.step
        found = [_signs(p, len(self.rows) - 1, *ends) for p in self.bounds]
        return found[0] if found[0] == found[-1] else None

    def sign_at(self, x: Fraction) -> int:
        """The sign at a number >= 0; 0 where it is zero, or open."""
        return (self.moved(x, None) or (0,))[0]


def _signs(p: fmpq_poly, degree: int, low: Fraction, high: Fraction | None) -> tuple[int, ...]:
    start = flint.fmpq(low.numerator, low.denominator)
    if high is None:
        there = p(fmpq_poly([start, 1]))
        return tuple((there[n] > 0) - (there[n] < 0) for n in range(degree + 1))
    end = flint.fmpq(high.numerator, high.denominator)
    there = p(fmpq_poly([start, end - start]))
    turned = fmpq_poly([there[n] for n in range(degree, -1, -1)])(fmpq_poly([1, 1]))
    return tuple((turned[n] > 0) - (turned[n] < 0) for n in range(degree, -1, -1))


@dataclass
class Factors:
    """The factors of some functions, each of them once, and the functions as products of them."""

    listed: dict[Factor, int] = field(default_factory=dict)
    known: list[tuple[Polynomial, Any]] = field(default_factory=list)
    second: int = PI
    """The place in the ring of what stands beside the variable."""

    def product(self, x: RealFunction, *, in_square: bool) -> dict[str, Any]:
        """``number * product of factor^exponent``."""
        return self.quotient(x.axis, x.function.numerator, x.function.denominator, in_square=in_square)

    def quotient(self, ring: PolynomialRing, top: Polynomial, bottom: Polynomial, *, in_square: bool) -> dict[str, Any]:
        """The same of a quotient of polynomials."""
        if top.is_zero():
            return {"number": "0", "powers": []}
        number, powers = Rational(1), Counter[int]()
        for polynomial, sign in ((top, 1), (bottom, -1)):
            unit, factors = self._taken(ring, polynomial, in_square=in_square)
            number *= unit**sign
            for factor, n in factors:
                powers[self._index(factor, in_square=in_square)] += sign * n
        return {"number": str(number), "powers": [[i, n] for i, n in sorted(powers.items()) if n]}

    def _taken(self, ring: PolynomialRing, polynomial: Polynomial, *, in_square: bool) -> Any:
        found = next((taken for other, taken in self.known if other == polynomial), None)
        if found is None:
            found = ring.factors(polynomial, in_square=in_square)
            self.known.append((polynomial, found))
        return found

    def _index(self, factor: Polynomial, *, in_square: bool) -> int:
        rows = rows_of(factor, self.second)
        even = in_square and not any(any(row) for row in rows[1::2])
        return self.listed.setdefault(Factor(rows[::2] if even else rows, 2 if even else 1), len(self.listed))


def rows_of(polynomial: Polynomial, second: int = PI) -> Rows:
    """The coefficients of a polynomial with whole ones in the variable and pi, or another; SceneError where it holds more."""
    rows: dict[int, dict[int, int]] = {}
    for powers, value in polynomial.to_dict().items():
        _need_alone([int(n) for n in powers], second)
        rows.setdefault(int(powers[0]), {})[int(powers[second])] = int(value.p)
    return tuple(
        tuple(row.get(i, 0) for i in range(max(row, default=0) + 1))
        for row in (rows.get(n, {}) for n in range(max(rows) + 1))
    )


def _need_alone(powers: Sequence[int], second: int) -> None:
    """SceneError where a polynomial holds more than the variable and what stands beside it."""
    others = [i for i, n in enumerate(powers) if n and i not in (0, second)]
    if others:
        raise SceneError(BESIDE_PI if others == [PI] else NOT_RATIONAL)


def told_rows(rows: Rows) -> list[list[str]]:
    """As a certificate tells them."""
    return [[str(n) for n in row] for row in rows]


NOT_RATIONAL = (
    "a certificate needs a rational scene: this one has a delay, a hold or a fractional power of s, "
    "so that its functions are no quotients of polynomials"
)


BESIDE_PI = "a certificate with a free parameter needs a scene without pi, in formulas too: write frequencies in rad/s, not in Hz"


def are_even(functions: Sequence[RealFunction]) -> bool:
    """Whether all numerators and denominators are even or odd in omega; those of Coulomb friction are not."""
    every = (p for f in functions for p in (f.function.numerator, f.function.denominator) if not p.is_zero())
    return all(len({int(e[0]) % 2 for e in p.monoms()}) == 1 for p in every)


@dataclass(frozen=True)
class Linked:
    """Functions as products of factors; ``delays`` : tau of the half angles omega tau/2 in factors, the longest first.

    ``orders`` : of the powers (j omega)^alpha.
    """

    factors: list[Factor | WaveFactor]
    told: dict[str, dict[str, Any]]
    delays: tuple[Fraction, ...] = ()
    orders: tuple[Fraction, ...] = ()


def products(functions: Mapping[str, RealFunction], second: int = PI) -> Linked:
    """The factors of real functions, and each function as the product of them; ``second`` : as of ``Factors``."""
    axis = next(iter(functions.values())).axis
    powers = axis.powers if isinstance(axis, RectangularAxis) else ()
    if not axis.functions and not powers:
        factors, told = rational_products(functions, second)
        return Linked([*factors], told)
    others = [*axis.lags[::-1], *powers]
    if len(others) > _MOST_OTHERS or not all(x.is_Rational and max(x.p, x.q) < _LARGEST for x in others):
        raise SceneError(NO_ROOM)
    exact = tuple(Fraction(int(x.p), int(x.q)) for x in others)
    delays, orders = exact[: len(axis.lags)], exact[len(axis.lags) :]
    waves = WaveProducts(axis, delays, orders, second)
    told = {name: waves.product(f) for name, f in functions.items()}
    return Linked(list(waves.listed), told, delays, orders)


_MOST_OTHERS, _LARGEST = 4, 2**100
NO_ROOM = (
    f"a certificate of a scene with delays or powers of s has room for {_MOST_OTHERS} delays that are no multiples of each "
    "other and orders together, each a rational number (a delay in seconds) of at most 30 digits"
)


class WaveProducts:
    """The factors of functions with delays or powers, each of them once."""

    def __init__(
        self, axis: Axis, delays: tuple[Fraction, ...], orders: tuple[Fraction, ...], second: int = PI
    ) -> None:
        self.axis, self.delays, self.orders, self.second = axis, delays, orders, second
        self.listed: dict[Factor | WaveFactor, int] = {}
        self.known: list[tuple[Polynomial, Any]] = []

    def product(self, x: RealFunction) -> dict[str, Any]:
        """``number * product of factor^exponent``."""
        if x.is_zero:
            return {"number": "0", "powers": []}
        number, found = Rational(1), Counter[Factor | WaveFactor]()
        for polynomial, sign in ((x.function.numerator, 1), (x.function.denominator, -1)):
            unit, factors = self._taken(polynomial)
            number *= unit**sign
            for factor, n in factors:
                found[factor] += sign * n
        powers = {self.listed.setdefault(factor, len(self.listed)): n for factor, n in found.items() if n}
        return {"number": str(number), "powers": [list(x) for x in sorted(powers.items())]}

    def _taken(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Factor | WaveFactor, int]]]:
        found = next((taken for other, taken in self.known if other == polynomial), None)
        if found is None:
            found = self._factors(polynomial)
            self.known.append((polynomial, found))
        return found

    def _factors(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Factor | WaveFactor, int]]]:
        """A number, and factors with their exponents: tangents made homogeneous in cosine and sine."""
        size, count = self.axis.size, len(self.delays)
        number, factors = self.axis.factors(self.axis.without_circles(polynomial)[0], in_square=False)
        found = list[tuple[Factor | WaveFactor, int]]()
        first = size - 2 * len(self.orders)
        for factor, n in factors:
            _need_alone([int(k) for k in factor.degrees()[:first]], self.second)
            if any(factor.degrees()[first:]):
                found.append((wave_factor(factor, size, self.delays, self.orders, self.second), n))
            else:
                found.append((Factor(rows_of(factor, self.second), 1), n))
        turning = [int(n) for n in polynomial.degrees()[size : size + count]][::-1]
        cosines = [(cosine_factor(i, self.delays, self.orders), -n) for i, n in enumerate(turning) if n]
        return number, [*found, *cosines]


def rational_products(
    functions: Mapping[str, RealFunction], second: int = PI
) -> tuple[list[Factor], dict[str, dict[str, Any]]]:
    """The same of functions without delays; ``second`` : as of ``Factors``."""
    factors, even = Factors(second=second), are_even(list(functions.values()))
    told = {name: factors.product(f, in_square=even) for name, f in functions.items()}
    return list(factors.listed), told
