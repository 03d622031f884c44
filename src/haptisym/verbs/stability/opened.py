"""A sampled loop with one number left open, and the values of that number at which roots come to the unit circle.

An ``Opened`` loop answers at a number (how many roots have |z| >= 1), and for a ball of numbers: which of the three tests of
Schur and Cohn may vanish there. A ``Passage`` is a value at which the count changes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flint
from flint import acb_poly, arb
from sympy import Expr, Integer, Poly, Rational, Symbol, ceiling, floor

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.sampledloop import SampledLoop, Timed, circle_tests, most_on_circle


@dataclass(frozen=True)
class Passage:
    """A ``value`` at which the number of roots with |z| >= 1 changes, from ``below`` to ``above``; ``omega`` : theirs, rad/s."""

    value: RealNumber
    omega: RealNumber
    below: int
    above: int


@dataclass(frozen=True)
class Opened:
    """A loop in which a symbol stands for one number."""

    loop: SampledLoop
    symbol: Symbol

    @cached_property
    def is_fixed(self) -> bool:
        """Whether the number is nowhere in it."""
        return self.symbol not in self.loop.symbols

    @cached_property
    def is_of_wall(self) -> bool:
        """Whether the number is in what is felt alone: what moves has the same modes for all of its values."""
        own = self.loop.T, *self.loop.plant.denominator, *(lag for lag, _ in self.loop.plant.terms)
        return not any(x.has(self.symbol) for x in own)

    @property
    def is_of_clock(self) -> bool:
        """Whether the number is in the period, or in a delay."""
        return any(x.has(self.symbol) for x in (self.loop.T, *(lag for lag, _ in self.loop.plant.terms)))

    def at(self, value: Rational) -> SampledLoop:
        """The loop at a number."""
        return self.loop.at({self.symbol: value})

    def count(self, value: Rational) -> tuple[int, int]:
        """The roots with |z| >= 1 at a number, and those on the circle that are not there at any number."""
        outside, at_1 = self.at(value).unstable()
        return outside + at_1, at_1 - self.always

    @cached_property
    def at_one(self) -> Expr:
        """C(1) times what is nowhere 0."""
        return self.loop.at_one

    @cached_property
    def always(self) -> int:
        """How many roots lie at 1 whatever the number is."""
        return 0 if self.at_one != 0 else self.at(Rational(7919, 6007)).roots_at_one

    @property
    def _ratios(self) -> list[Expr]:
        """Delays over the period that depend on the number."""
        found = [lag / self.loop.T for lag, _ in self.loop.plant.terms]
        return [x for x in found if x.has(self.symbol)]

    @property
    def is_timed(self) -> bool:
        """Whether the number changes how many samples a delay is."""
        return bool(self._ratios)

    @cached_property
    def is_late(self) -> bool:
        """Whether the number is a delay of all that moves, and of nothing else, and the period rational."""
        others = self.loop.T, *self.loop.above, *self.loop.below, *self.loop.plant.denominator
        terms = self.loop.plant.terms
        apart = any(x.has(self.symbol) for x in (*others, *(x for _, row in terms for x in row)))
        late = all(
            lag.diff(self.symbol) == 1 and lag.xreplace({self.symbol: Integer(0)}).is_Rational for lag, _ in terms
        )
        return late and not apart and bool(self.loop.T.is_Rational) and not self.always

    def piece(self, start: Fraction, end: Fraction, side: int) -> tuple[Opened, Fraction]:
        """The loop from a value on as far as its delays keep their whole samples, and up to where that is."""
        q, last = Rational(start.numerator, start.denominator), Rational(end.numerator, end.denominator)
        turns = list[Expr]()
        for ratio in self._ratios:
            here = ratio.xreplace({self.symbol: q})
            if not here.is_Rational:
                raise UndecidedError("the limits of a parameter that is not rational")
            grows = (ratio.diff(self.symbol).xreplace({self.symbol: q}) > 0) == (side > 0)
            n = floor(here) + 1 if grows else ceiling(here) - 1
            above, below = (Poly(x, self.symbol) for x in (ratio - n).together().as_numer_denom())
            if n >= 0 and above.degree() == 1 and below.degree() < 2:
                turns += [x for x in (-above.nth(0) / above.nth(1),) if (x - q) * side > 0]
        stop = min((last, *turns), key=lambda x: (x - q) * side)
        middle = {self.symbol: (q + stop) / 2}
        period, plant = self.loop.T.xreplace(middle), self.loop.plant
        whole = tuple(int(floor(lag.xreplace(middle) / period)) for lag, _ in plant.terms)
        timed = Timed(plant.denominator, plant.terms, whole)
        return Opened(replace(self.loop, plant=timed), self.symbol), Fraction(int(stop.p), int(stop.q))

    def tests(self, q: Ball) -> tuple[Ball, Ball, Ball]:
        """At z = 1, at z = -1, and where two roots v add up to 0: numbers that vanish where a root is on the circle."""
        return circle_tests(self.loop, {self.symbol: q}, self.at_one, self.always)

    def most(self, q: Ball) -> int | None:
        """For how many numbers in a ball each test is 0 at most, proven: 0, with no root on the circle, or 1; None: open."""
        try:
            return most_on_circle(self.loop, {self.symbol: q}, self.at_one, self.always)
        except (UndecidedError, ZeroDivisionError):
            return None

    def angle(self, q: Ball, bits: int) -> Ball:
        """Of the pair on the circle: its argument, to so many bits; not finite where balls do not tell."""
        try:
            roots = acb_poly(self.loop.in_v({self.symbol: q}, self.always)).roots(
                tol=arb(2) ** -bits, maxprec=2 * flint.ctx.prec
            )
        except ValueError:
            return arb("nan")
        found = [2 * v.imag.atan() for v in roots if v.real.contains(0) and v.imag > 0]
        return found[0] if len(found) == 1 else arb("nan")

    def period(self, q: Ball) -> Ball:
        """T, s."""
        return expression_ball(self.loop.T, {self.symbol: q})
