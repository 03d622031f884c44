"""Which zeros and poles of a real function meet at a frequency, and where each goes as a parameter moves.

A sign changes at a zero of odd order of what stands above or below the line of f(omega, p). For the scene's own p several may
lie on one frequency: a pole without damping is a zero above the line on a double zero below it, and with a little damping the
zero alone is left, beside it. Counted are the real branches through the point that change the sign, for p a little smaller
and a little larger; one alone is where the frequency goes, and its slope follows from its own factor by implicit differentiation.
Derivation: 14_sensitivity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Expr, Integer, Rational, Symbol, pi

from haptisym.kernel.implicit import Equation, ImplicitSlope
from haptisym.kernel.precision import at_rising_precision
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber
from haptisym.kernel.rings import Polynomial, PolynomialRing
from haptisym.kernel.symbols import omega
from haptisym.kernel.zeros import is_clear, sign_of

_USUAL_BITS = 128
Factors: TypeAlias = tuple[tuple[Equation, int], ...]
"""Irreducible factors as equations, each with its order."""
SymbolValues: TypeAlias = tuple[tuple[Symbol, RealNumber], ...]
ZERO = ExactNumber(Integer(0))
"""What does not move at first order."""
Branch: TypeAlias = RealNumber | None
"""The slope of a branch; None where it is infinite, or one of several that leave the point."""
Sides: TypeAlias = tuple[list[Branch], list[Branch]]
"""The branches for a parameter a little smaller, and a little larger."""


@dataclass(frozen=True)
class Meeting:
    """Factors, each with its order, that vanish or nearly vanish at a frequency, where the symbols have these ``values``."""

    factors: Factors
    parameter: Symbol
    values: SymbolValues

    def sides(self) -> Sides | None:
        """The branches that change the sign, below and above the parameter's value; None where that stays open.

        Complete for polynomials with rational values of the symbols, but where more than two branches of one factor meet.
        """
        core = self._core()
        if core is None:
            return None
        below: list[Branch] = []
        above: list[Branch] = []
        for factor, order in self.factors:
            found = self._of(factor, core) if order % 2 else ([], [])
            if found is None:
                return None
            below, above = below + found[0], above + found[1]
        return below, above

    def is_still(self) -> bool:
        """Whether a simple zero of the only factor does not move at first order: dF/dp is 0 there. (False: not seen to be.)"""
        core, [(factor, _)] = self._core(), self.factors
        return core is not None and self._vanishes(
            factor.ring, _derivative(factor.ring, factor.F, self.parameter), core
        )

    def _of(self, factor: Equation, core: Polynomial) -> Sides | None:
        """The real branches of one factor F, by the lowest terms of its Taylor series at the point."""
        ring, here = factor.ring, self._here(factor.ring, factor.F)
        times = 0 if here.is_zero() else _multiplicity(core, here)  # F = p - value is 0 nowhere beside the value
        if times == 0:
            return [], []
        F_p = _derivative(ring, factor.F, self.parameter)
        if times == 1:
            slope = ZERO if self._vanishes(ring, F_p, core) else Slope(factor.slope(self.parameter), self.values)
            return [slope], [slope]
        if not self._vanishes(ring, F_p, core):  # a d omega^times + b dp = 0
            return self._fold(ring, factor.F, F_p, times)
        return self._pair(ring, factor.F, core) if times == 2 else None

    def _fold(self, ring: PolynomialRing, F: Polynomial, F_p: Polynomial, times: int) -> Sides | None:
        """Infinitely fast: on both sides where ``times`` is odd, else twice on one side and not at all on the other."""
        if times % 2:
            return [None], [None]
        highest = F
        for _ in range(times):
            highest = _derivative(ring, highest, omega)
        one, other = self._sign(ring, highest), self._sign(ring, F_p)
        if not one or not other:
            return None
        return ([None, None], []) if one * other > 0 else ([], [None, None])

    def _pair(self, ring: PolynomialRing, F: Polynomial, core: Polynomial) -> Sides | None:
        """a d omega^2 + 2 b d omega dp + c dp^2 = 0: two lines where b^2 > a c, the point alone where b^2 < a c."""
        F_w, F_p = _derivative(ring, F, omega), _derivative(ring, F, self.parameter)
        a, b, c = (_derivative(ring, *x) for x in ((F_w, omega), (F_w, self.parameter), (F_p, self.parameter)))
        discriminant = b * b - a * c
        sign = None if self._vanishes(ring, discriminant, core) else self._sign(ring, discriminant)
        if sign is None:
            return None
        lines: list[Branch] = [None, None] if sign > 0 else []  # where the frequency goes, two of them leave open
        return lines, list(lines)

    def _core(self) -> Polynomial | None:
        """The irreducible polynomial that the frequency is a zero of; None but for polynomials with rational values."""
        plain = not any(f.ring.functions for f, _ in self.factors)
        if not plain or not all(isinstance(value, Rational) for value in self._numbers.values()):
            return None
        left: dict[str, Polynomial] = {}
        for factor, _ in self.factors:
            here = self._here(factor.ring, factor.F)
            for core, _ in [] if here.is_zero() else here.factor()[1]:
                if self._sign(factor.ring, core) is None:
                    left[str(core)] = core
        return next(iter(left.values())) if len(left) == 1 else None

    def _here(self, ring: PolynomialRing, polynomial: Polynomial) -> Polynomial:
        """A polynomial with the symbols' values in place."""
        known = {ring.meanings.index(x): v for x, v in self._numbers.items() if x in ring.meanings}
        return polynomial.subs({i: fmpq(int(v.p), int(v.q)) for i, v in known.items()})

    @property
    def _numbers(self) -> dict[Symbol, Any]:
        """The symbols' exact values, None where a number has none."""
        return {x: v.value if isinstance(v, ExactNumber) else None for x, v in self.values if x != omega}

    def _vanishes(self, ring: PolynomialRing, polynomial: Polynomial, core: Polynomial) -> bool:
        here = self._here(ring, polynomial)
        return bool(here.is_zero()) or _multiplicity(core, here) > 0

    def _sign(self, ring: PolynomialRing, polynomial: Polynomial) -> int | None:
        """The sign here, -1 or 1; None where it is 0, or too near to it."""
        return at_rising_precision(lambda bits: sign_of(ring.ball(polynomial, balls(self.values, bits))) or None, 64)


def not_clear(factors: Factors, values: SymbolValues) -> Factors:
    """The factors, of which at least one vanishes here, that are not proven to differ from 0."""

    def alone(bits: int) -> Factors | None:
        nonlocal factors
        known = balls(values, bits)
        factors = tuple((factor, order) for factor, order in factors if not is_clear(factor.ball(known)))
        return factors if len(factors) <= 1 else None

    if len(factors) > 1:
        at_rising_precision(alone, 64)
    return factors


def balls(values: SymbolValues, bits: int) -> dict[Expr, Ball]:
    """Enclosures of exact values, and of pi at the working precision."""
    return {pi: arb.pi(), **{symbol: number.ball(bits) for symbol, number in values}}


def _multiplicity(core: Polynomial, polynomial: Polynomial) -> int:
    """How often an irreducible polynomial divides one that is not 0."""
    times = 0
    while True:
        quotient, rest = divmod(polynomial, core)
        if not rest.is_zero():
            return times
        polynomial, times = quotient, times + 1


def _derivative(ring: PolynomialRing, polynomial: Polynomial, x: Symbol) -> Polynomial:
    return polynomial.derivative(ring.meanings.index(x)) if x in ring.meanings else 0 * polynomial


@dataclass(frozen=True, repr=False)
class Slope(RealNumber):
    """An implicit derivative where its symbols have these values."""

    slope: ImplicitSlope
    values: SymbolValues

    def ball(self, bits: int) -> Ball:
        above, below = self._parts(bits)
        with flint.ctx.workprec(bits):
            return -above / below

    def _parts(self, bits: int) -> tuple[Ball, Ball]:
        """Balls around what stands above and below; a float, five digits and a sign are read off one and the same."""
        enough = max(bits, _USUAL_BITS)
        if enough not in self._known:
            with flint.ctx.workprec(enough):
                self._known[enough] = self.slope.balls(balls(self.values, enough))
        return self._known[enough]

    @cached_property
    def _known(self) -> dict[int, tuple[Ball, Ball]]:
        return {}

    def is_clear(self) -> bool:
        """Whether neither dF/dp nor dF/d omega is 0: proven."""
        return bool(at_rising_precision(lambda bits: all(map(is_clear, self._parts(bits))) or None, _USUAL_BITS))
