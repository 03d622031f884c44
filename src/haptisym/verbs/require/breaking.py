"""Where on a band conditions are broken at one value of their parameter: a rational number, or an algebraic one near others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import flint
from flint import arb
from sympy import Expr, Rational, Symbol, pi

from haptisym.judge.criteria import Criterion
from haptisym.kernel.axis import Axis
from haptisym.kernel.eliminants import resultant
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.polynomials import Root
from haptisym.kernel.precision import SURE_BITS, at_rising_precision
from haptisym.kernel.reals import Ball, ExactNumber, Negative, RealNumber, rational_between
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import Interval, chart
from haptisym.kernel.symbols import omega
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.require.boundary import of_factor, substituted
from haptisym.verbs.require.freeparameter import Conditions, pieces

_ROUNDS = (8, 32, 128, 512)
"""Bits by which a critical value is approached for a witness, before its number field is asked."""


@dataclass(frozen=True)
class BrokenInterval:
    """Frequencies at which a condition is broken, for a value of the parameter."""

    criterion: Criterion
    band: Interval


@dataclass(frozen=True)
class Cell:
    """An open interval of values with one answer, told at a sample: where conditions are broken there; nowhere if feasible."""

    sample: Rational
    broken: tuple[BrokenInterval, ...]

    @property
    def feasible(self) -> bool:
        """Whether nothing is broken in it."""
        return not self.broken


@dataclass(frozen=True)
class Breaking:
    """Conditions in omega and one parameter on a band, at values of the parameter."""

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]

    @cached_property
    def pieces(self) -> Mapping[Criterion, tuple[RealFunction, ...]]:
        """Of each condition the functions that must not all be positive."""
        return {x: pieces(condition) for x, condition in self.conditions.items()}

    @property
    def ring(self) -> Axis:
        """The one in which all pieces are written."""
        return next(iter(self.pieces.values()))[0].axis

    @cached_property
    def index(self) -> int:
        """The parameter's number among the variables of the ring."""
        return self.ring.meanings.index(self.free)

    def at(self, value: Expr) -> tuple[BrokenInterval, ...]:
        """Where the first of the broken conditions is, at a number that is rational, or rational in pi; () if none is."""
        return next((found for criterion in self.conditions if (found := self.of(criterion, value))), ())

    def of(self, criterion: Criterion, value: Expr) -> tuple[BrokenInterval, ...]:
        """Where a condition is broken at such a number; the points have the orders of its functions by their places."""
        table = chart(dict(enumerate(self._functions(criterion, value))), *self.band)
        return tuple(BrokenInterval(criterion, x) for x in table.where(lambda signs: min(signs.values()) > 0))

    def _functions(self, criterion: Criterion, value: Expr) -> list[RealFunction]:
        """What stands above the line of each; 1 where one is nowhere defined."""
        found = []
        for piece in self.pieces[criterion]:
            if self._put(piece.function.denominator, value).is_zero():
                return [RealFunction(self.ring.one)]
            found.append(RealFunction(self.ring.function(self._put(piece.function.numerator, value))))
        return found

    def _put(self, polynomial: Polynomial, value: Expr) -> Polynomial:
        return substituted(polynomial, self.index, self.ring.convert(value))

    def near(self, value: RealNumber, cells: Sequence[Cell]) -> bool:
        """Whether a condition is broken at an algebraic value between two cells that are not feasible.

        First at frequencies at which one is broken nearby; where none shows, in the number field of the value.
        """
        if any(self._positive_at(x, value) for cell in cells for x in cell.broken):
            return True
        beside = (self.at(approached(value, cell.sample, bits)) for bits in _ROUNDS for cell in cells)
        if any(self._positive_at(x, value) for broken in beside for x in broken):
            return True
        return any(self._exceeds_exactly(criterion, value) for criterion in self.conditions)

    def _positive_at(self, excess: BrokenInterval, value: RealNumber) -> bool:
        """Whether a condition that is broken at a near value shows to be so, at the same frequency, at this one."""
        place = rational_between(excess.band.low.omega, excess.band.high.omega)
        with flint.ctx.workprec(512):
            at = ExactNumber(place).ball(512), value.ball(512)
            return all(self._value(piece, *at) > 0 for piece in self.pieces[excess.criterion])

    def may_bind(self, criterion: Criterion, place: RealNumber, value: RealNumber) -> bool:
        """Whether none of several functions is negative at a frequency where one of them vanishes."""
        own = self.pieces[criterion]
        with flint.ctx.workprec(512):
            return len(own) == 1 or not any(self._value(f, place.ball(512), value.ball(512)) < 0 for f in own)

    def _value(self, piece: RealFunction, place: Ball, value: Ball) -> Ball:
        return self.ring.ball(piece.function.numerator, {omega: place, pi: arb.pi(), self.free: value})

    def _exceeds_exactly(self, criterion: Criterion, value: RealNumber) -> bool:
        """By the zeros of norms: between them every function has one sign, which any frequency in between tells."""
        root = value.number if isinstance(value, Negative) else value
        assert isinstance(root, Root)
        minimal = of_factor(self.ring, self.index, root.factor, mirrored=root is not value)
        own = self.pieces[criterion]
        tops = [f.function.cleared().numerator for f in own]
        norms = [resultant(p, minimal, self.index) if p.degrees()[self.index] else p for p in tops]
        if any(norm.is_zero() for norm in norms):
            return False
        table = chart({i: RealFunction(self.ring.function(norm)) for i, norm in enumerate(norms)}, *self.band)
        between = [rational_between(a.omega, b.omega) for a, b in pairwise(table.points)]
        return any(all(self._sign(f, place, value) > 0 for f in own) for place in between)

    def _sign(self, piece: RealFunction, place: Rational, value: RealNumber) -> int:
        """The sign of a function where it is not zero."""
        at = ExactNumber(place)
        sign = at_rising_precision(
            lambda bits: sign_of(self._value(piece, at.ball(bits), value.ball(bits))) or None, most=SURE_BITS
        )
        if sign is None:
            raise UndecidedError(f"the sign of a condition at omega = {place} rad/s")
        return sign


def approached(value: RealNumber, sample: Rational, bits: int) -> Rational:
    """A rational number between a value and a sample, nearer the value by that many bits."""
    low, high = value.bounds(bits + 64)
    start = low if ExactNumber(sample).bounds(64)[0] < low else high
    at = Rational(start.numerator, start.denominator)
    return at + (sample - at) / 2**bits
