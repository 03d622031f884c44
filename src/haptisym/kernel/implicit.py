"""How a zero omega of F(omega, p) = 0 moves with a parameter: d omega/dp = -(dF/dp)/(dF/d omega)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq
from sympy import Add, Expr, Integer, Rational, Symbol

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.kernel.symbols import omega

FunctionTerms: TypeAlias = tuple[tuple[Expr, Polynomial], ...]
"""A sum of polynomials of a ring, each times an expression: what a derivative of a polynomial in functions is."""


@dataclass(frozen=True)
class Equation:
    """F = 0 for a frequency; F is a polynomial in omega, the parameters and functions of them (cos(omega tau), omega^alpha).

    >>> from haptisym.kernel.symbols import symbols
    >>> m, k = symbols("m k")
    >>> ring = PolynomialRing(omega, [m, k])
    >>> Equation(ring, ring.convert(k - m * omega**2).numerator).slope(k).expression()
    1/(2*m*omega)
    """

    ring: PolynomialRing
    F: Polynomial

    def ball(self, known: Mapping[Expr, Ball]) -> Ball:
        """A ball around F where the symbols have these values, at the current working precision."""
        return self.ring.ball(self.F, _meanings(self.ring, known))

    def partial(self, x: Symbol) -> FunctionTerms:
        """dF/dx: a derivative of each variable of the ring that depends on x times dF by that variable; () where it is 0."""
        chain = [(meaning.diff(x), self.F.derivative(i)) for i, meaning in enumerate(self.ring.meanings)]
        return tuple((factor, p) for factor, p in chain if factor != 0 and not p.is_zero())

    def slope(self, parameter: Symbol) -> ImplicitSlope:
        """d omega/d parameter."""
        return ImplicitSlope(self.ring, self.partial(parameter), self.partial(omega))


@dataclass(frozen=True)
class ImplicitSlope:
    """``-above/below``, which is d omega/d parameter at every zero at which ``below``, dF/d omega, is not 0."""

    ring: PolynomialRing
    above: FunctionTerms
    below: FunctionTerms

    def expression(self) -> Expr:
        """The closed form."""
        above, below = (Add(*(f * self.ring.expression(p) for f, p in terms)) for terms in (self.above, self.below))
        return -above / below

    def vanishes(self, known: Mapping[Symbol, Expr]) -> bool:
        """Whether ``above`` is 0 at every frequency for these values of parameters. (False: not seen to be.)"""
        return all(f.xreplace(known) == 0 or self._at(p, known).is_zero() for f, p in self.above)

    def _at(self, polynomial: Polynomial, known: Mapping[Symbol, Expr]) -> Polynomial:
        places = {self.ring.meanings.index(x): v for x, v in known.items() if isinstance(v, Rational)}
        return polynomial.subs({i: fmpq(int(v.p), int(v.q)) for i, v in places.items()})

    def balls(self, known: Mapping[Expr, Ball]) -> tuple[Ball, Ball]:
        """Balls around ``above`` and ``below`` where the symbols have these values, at the current working precision."""
        values = _meanings(self.ring, known)
        return self._ball(self.above, values, known), self._ball(self.below, values, known)

    def _ball(self, terms: FunctionTerms, values: Mapping[Expr, Ball], known: Mapping[Expr, Ball]) -> Ball:
        parts = (expression_ball(f, known) * self.ring.ball(p, values) for f, p in terms)
        return sum(parts, expression_ball(Integer(0)))


def _meanings(ring: PolynomialRing, known: Mapping[Expr, Ball]) -> dict[Expr, Ball]:
    """What the variables of a ring are worth, as far as the symbols in them are known."""
    return {x: expression_ball(x, known) for x in ring.meanings if all(y in known for y in x.free_symbols)}
