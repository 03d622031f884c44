"""Exact rational functions of ``s`` and the real functions that they become on ``s = j omega``.

A dynamics is a quotient of polynomials over the rational numbers in ``s``, ``pi`` and the parameters. On ``s = j omega``
even powers of ``s`` are real and odd ones imaginary, so that real part, imaginary part and squared modulus are had by
polynomial arithmetic alone: no complex numbers, no ``as_real_imag``, no ``simplify``. ``pi`` is transcendental, so it
is one more variable, and every test for zero stays exact.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add, mul
from typing import Any, TypeAlias

from flint import Ordering, fmpq, fmpq_mpoly_ctx
from sympy import Add, Expr, Integer, Mul, Pow, Rational, Symbol, pi

from .errors import SceneError
from .symbols import conflicting, omega, s

Polynomial: TypeAlias = Any  # flint.fmpq_mpoly, which ships no types


class Ring:
    """Polynomials over Q in the frequency variable (``s``, or ``omega`` on the axis), ``pi`` and the given symbols.

    >>> m, k = Symbol("m"), Symbol("k")
    >>> ring = Ring([m, k])
    >>> H = ring.convert(m * s**2 + k)
    >>> response = H.on_axis()
    >>> response.real.expression(), response.imag.expression()
    (k - m*omega**2, 0)
    """

    def __init__(self, symbols: Iterable[Symbol] = ()) -> None:
        self.symbols = tuple(sorted(set(symbols) - {s, omega}, key=str))
        clash = conflicting([*self.symbols])
        if clash is not None:
            raise SceneError(f"two different symbols are both named {clash}: give one of them another name")
        names = ("s", "pi", *(f"p_{symbol.name}" for symbol in self.symbols))
        self.context = fmpq_mpoly_ctx.get(names, Ordering.lex)
        self.variable, self.pi, *parameters = self.context.gens()
        self._generators = {
            s: self.variable,
            omega: self.variable,
            pi: self.pi,
            **dict(zip(self.symbols, parameters, strict=True)),
        }

    @classmethod
    def of(cls, expressions: Iterable[Expr]) -> Ring:
        """The smallest ring that holds the given expressions."""
        return cls(symbol for e in expressions for symbol in e.free_symbols)

    def constant(self, value: int | Rational) -> Polynomial:
        """A rational number as a polynomial."""
        exact = Rational(value)
        return self.context.constant(fmpq(int(exact.p), int(exact.q)))

    @property
    def zero(self) -> RationalFunction:
        return RationalFunction(self, self.constant(0), self.constant(1))

    @property
    def one(self) -> RationalFunction:
        return RationalFunction(self, self.constant(1), self.constant(1))

    def convert(self, expression: Expr) -> RationalFunction:
        """The rational function that a SymPy expression is; SceneError where it is not one.

        >>> Ring().convert(1 / s + s / (s + 1)).expression()
        (s**2 + s + 1)/(s*(s + 1))
        """
        if expression in self._generators:
            return RationalFunction(self, self._generators[expression], self.constant(1))
        if isinstance(expression, Rational):
            return RationalFunction(self, self.constant(expression), self.constant(1))
        if isinstance(expression, Add):
            return reduce(add, map(self.convert, expression.args))
        if isinstance(expression, Mul):
            return reduce(mul, map(self.convert, expression.args))
        if isinstance(expression, Pow) and isinstance(expression.exp, Integer):
            return self.convert(expression.base) ** int(expression.exp)
        raise SceneError(f"{expression} is not a rational function of s with exact coefficients")

    def polynomial_expression(self, polynomial: Polynomial, variable: Symbol) -> Expr:
        """A polynomial as a SymPy sum over the powers of ``variable``, each with its coefficient collected."""
        return Add(*(coefficient * variable**power for power, coefficient in self._powers(polynomial).items()))

    def _powers(self, polynomial: Polynomial) -> dict[int, Expr]:
        powers: dict[int, list[Expr]] = {}
        for exponents, coefficient in polynomial.to_dict().items():
            power, of_pi, *rest = map(int, exponents)
            factors = [symbol**n for symbol, n in zip(self.symbols, rest, strict=True) if n]
            number = Rational(int(coefficient.p), int(coefficient.q))
            powers.setdefault(power, []).append(Mul(number, pi**of_pi, *factors))
        return {power: Add(*terms) for power, terms in powers.items()}

    def coefficients(self, polynomial: Polynomial) -> list[Expr]:
        """The coefficients of a polynomial, ascending in powers of the variable."""
        powers = self._powers(polynomial)
        return [powers.get(n, Integer(0)) for n in range(max(powers, default=0) + 1)]

    def factored_expression(self, polynomial: Polynomial, variable: Symbol) -> Expr:
        """A polynomial as the product of its factors."""
        unit, factors = self.factors(polynomial)
        return Mul(unit, *(self.polynomial_expression(f, variable) ** n for f, n in factors))

    def factors(self, polynomial: Polynomial) -> tuple[Rational, list[tuple[Polynomial, int]]]:
        """A number and the factors over Q; of an even polynomial, those in the square of the variable.

        >>> ring = Ring()
        >>> ring.factors(ring.variable**4 + 4)       # not (s^2 - 2 s + 2) (s^2 + 2 s + 2)
        (1, [(s^4 + 4, 1)])
        """
        powers = [int(exponents[0]) for exponents in polynomial.monoms()]
        lowest = min(powers, default=0)
        step = 2 if powers and all((power - lowest) % 2 == 0 for power in powers) else 1
        deflated = {((int(e[0]) - lowest) // step, *e[1:]): c for e, c in polynomial.to_dict().items()}
        unit, factors = self.context.from_dict(deflated).factor()
        inflated = [(self._inflated(factor, step), int(n)) for factor, n in factors]
        own = [(self.variable, lowest)] if lowest else []
        return Rational(int(unit.p), int(unit.q)), own + inflated

    def _inflated(self, polynomial: Polynomial, step: int) -> Polynomial:
        return self.context.from_dict({(step * int(e[0]), *e[1:]): c for e, c in polynomial.to_dict().items()})


@dataclass(frozen=True, slots=True, eq=False)
class RationalFunction:
    """A quotient of two polynomials of one ring. Arithmetic does not cancel: ``reduced`` does, once, where it matters."""

    ring: Ring
    numerator: Polynomial
    denominator: Polynomial

    def __add__(self, other: RationalFunction) -> RationalFunction:
        if self.denominator == other.denominator:
            return self._new(self.numerator + other.numerator, self.denominator)
        top = self.numerator * other.denominator + other.numerator * self.denominator
        return self._new(top, self.denominator * other.denominator)

    def __neg__(self) -> RationalFunction:
        return self._new(-self.numerator, self.denominator)

    def __sub__(self, other: RationalFunction) -> RationalFunction:
        return self + -other

    def __mul__(self, other: RationalFunction) -> RationalFunction:
        return self._new(self.numerator * other.numerator, self.denominator * other.denominator)

    def __truediv__(self, other: RationalFunction) -> RationalFunction:
        if other.is_zero:
            raise SceneError("division by zero")
        return self._new(self.numerator * other.denominator, self.denominator * other.numerator)

    def __pow__(self, exponent: int) -> RationalFunction:
        if exponent < 0:
            return self.ring.one / self**-exponent
        return self._new(self.numerator**exponent, self.denominator**exponent)

    def _new(self, numerator: Polynomial, denominator: Polynomial) -> RationalFunction:
        return RationalFunction(self.ring, numerator, denominator)

    @property
    def is_zero(self) -> bool:
        return bool(self.numerator.is_zero())

    def equals(self, other: RationalFunction) -> bool:
        """Whether both are the same function: exact."""
        return (self - other).is_zero

    def reduced(self) -> RationalFunction:
        """In lowest terms, the denominator with leading coefficient 1."""
        common = self.numerator.gcd(self.denominator)
        top, bottom = self.numerator / common, self.denominator / common
        leading = bottom.leading_coefficient()
        return self._new(top / leading, bottom / leading)

    def on_axis(self) -> Response:
        """Its values on ``s = j omega``, as real functions of omega."""
        a, b = parts(self.numerator)
        c, d = parts(self.denominator)
        modulus = c * c + d * d
        return Response(self._new(a * c + b * d, modulus), self._new(b * c - a * d, modulus))

    def squared_modulus(self) -> RationalFunction:
        """|f(j omega)|^2, in lowest terms."""
        (a, b), (c, d) = parts(self.numerator), parts(self.denominator)
        return self._new(a * a + b * b, c * c + d * d).reduced()

    def expression(self, variable: Symbol = s) -> Expr:
        """A SymPy quotient, in lowest terms, the denominator in factors."""
        reduced = self.reduced().cleared()
        top = self.ring.polynomial_expression(reduced.numerator, variable)
        return top / self.ring.factored_expression(reduced.denominator, variable)

    def factored(self, variable: Symbol = s) -> Expr:
        """A SymPy quotient, in lowest terms, both numerator and denominator in factors."""
        reduced = self.reduced().cleared()
        top = self.ring.factored_expression(reduced.numerator, variable)
        return top / self.ring.factored_expression(reduced.denominator, variable)

    def cleared(self) -> RationalFunction:
        """The same function with whole coefficients, as small as they can be, in numerator and denominator."""
        from math import gcd, lcm

        coefficients = [*self.numerator.coeffs(), *self.denominator.coeffs()]
        below = reduce(lcm, (int(c.q) for c in coefficients), 1)
        above = reduce(gcd, (int(c.p) * (below // int(c.q)) for c in coefficients), 0) or 1
        scale = fmpq(below, above)
        return self._new(self.numerator * scale, self.denominator * scale)


def parts(polynomial: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Real and imaginary part of a polynomial in ``s`` on ``s = j omega``, as polynomials in omega.

    >>> ring = Ring()
    >>> parts(ring.variable**3 + 2 * ring.variable**2 + 5)     # the variable s stands for omega in the result
    (-2*s^2 + 5, -s^3)
    """
    context = polynomial.context()
    split: tuple[dict[Any, Any], dict[Any, Any]] = ({}, {})
    for exponents, coefficient in polynomial.to_dict().items():
        power = int(exponents[0])
        split[power % 2][exponents] = -coefficient if power % 4 >= 2 else coefficient
    return context.from_dict(split[0]), context.from_dict(split[1])


@dataclass(frozen=True)
class Response:
    """A dynamics on ``s = j omega``: real and imaginary part as exact real functions of omega."""

    raw_real: RationalFunction
    raw_imag: RationalFunction

    @cached_property
    def real(self) -> RealFunction:
        return RealFunction(self.raw_real.reduced())

    @cached_property
    def imag(self) -> RealFunction:
        return RealFunction(self.raw_imag.reduced())


@dataclass(frozen=True)
class RealFunction:
    """A real rational function of omega, in lowest terms."""

    function: RationalFunction

    def __mul__(self, other: RealFunction) -> RealFunction:
        return RealFunction((self.function * other.function).reduced())

    def __truediv__(self, other: RealFunction) -> RealFunction:
        return RealFunction((self.function / other.function).reduced())

    def __sub__(self, other: RealFunction) -> RealFunction:
        return RealFunction((self.function - other.function).reduced())

    @property
    def is_zero(self) -> bool:
        return self.function.is_zero

    def expression(self) -> Expr:
        """The closed form in omega, in lowest terms, the denominator in factors."""
        return self.function.expression(omega)

    def factored(self) -> Expr:
        """The closed form in omega, numerator and denominator in factors."""
        return self.function.factored(omega)
