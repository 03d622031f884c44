"""How far a number may go before a display with a clock shakes: where roots of its loop reach the unit circle, by balls.

There is a root z = 1 where B(1) Q(0) + A(1) N(0) = 0, D = A/B and G = N/Q; a root z = -1 where the highest coefficient in v is 0,
z = (1 + v)/(1 - v); a pair on the circle where a determinant of Hurwitz is. From a value on, cells in which none of the three
vanishes follow each other, as long as they may be, up to one in which the number of roots changes; its zero is closed in on.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import flint
from flint import acb_poly, arb
from sympy import Expr, Integer, Rational, Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.nearone import at_one, circle_tests, is_clear
from haptisym.kernel.pulse import SampledLoop
from haptisym.kernel.reals import Ball, ExactNumber, expression_ball
from haptisym.kernel.schurcohn import count_on_circle
from haptisym.model.hand import Hand
from haptisym.model.knobs import Knob
from haptisym.model.parameters import Rule
from haptisym.model.scene import Scene
from haptisym.verbs.stability.clocked import loop_of
from haptisym.verbs.stability.clockvalues import CriticalValue, Passage, Swing

_BITS = 128
_ZERO = ExactNumber(Integer(0))
_REACH = 10  # times that a value is doubled, and halved, at the most
_FINEST = Fraction(1, 1 << 24)  # of a value: where cells are shorter, it is asked whether more roots are behind them
_STEPS = (8, 64, 512)  # of such cells, over which roots are more or fewer, or proven to be as many throughout
_DEEPEST = 8  # times that these are cut
_GROWTH = Fraction(1, 2)  # of a cell, to the next
_MOST_CELLS, _MOST_FINE = 1000, 40  # on a side; of them the shortest


def opened(scene: Scene, hand: Hand, free: Knob) -> Opened:
    """The loop with a symbol for a number of the hand or of the display."""
    symbol = free.symbol
    if any(p.symbol == symbol for p in hand.parameters):
        return Opened(loop_of(scene, hand.with_values({symbol.name: symbol})), symbol)
    return Opened(loop_of(scene.with_values({free.path: symbol}), hand), symbol)


def start_of(loop: Opened, value: Expr) -> Rational:
    """From which value to walk: the number's own, or a rational one beside it with no root on the circle in between."""
    if isinstance(value, Rational):
        return value
    near = Rational(float(value))
    with flint.ctx.workprec(_BITS):
        q = expression_ball(value).union(expression_ball(near))
        if any(x.contains(0) or not x.is_finite() for x in loop.tests(q)):
            raise UndecidedError("how far a number may go that is no rational one")
    return near


@dataclass(frozen=True)
class Opened:
    """A loop in which a symbol stands for one number."""

    loop: SampledLoop
    symbol: Symbol

    @cached_property
    def is_fixed(self) -> bool:
        """Whether the number is nowhere in it."""
        plant = self.loop.plant
        every = (
            self.loop.T,
            *self.loop.above,
            *self.loop.below,
            *plant.denominator,
            *(x for lag, N in plant.terms for x in (lag, *N)),
        )
        return not any(x.has(self.symbol) for x in every)

    def at(self, value: Rational) -> SampledLoop:
        """The loop at a number."""
        return self.loop.at({self.symbol: value})

    def count(self, value: Rational) -> tuple[int, int]:
        """The roots with |z| >= 1 at a number, and those on the circle that are not there at any number."""
        found = self.at(value).circle()
        return found.inside + found.on, found.on - self.always - self.loop.hidden[1]

    @cached_property
    def at_one(self) -> Expr:
        """C(1) times what is nowhere 0."""
        return at_one(self.loop)

    @cached_property
    def opposite(self) -> tuple[Expr, Expr] | None:
        """What is at z = -1, where that is not told by the coefficients."""
        return None

    @cached_property
    def always(self) -> int:
        """How many roots lie at 1 whatever the number is."""
        if self.at_one != 0:
            return 0
        found = count_on_circle(self.at(Rational(7919, 6007)))
        return found.on

    def row(self, q: Ball) -> list[Ball]:
        """The coefficients at a ball of numbers, but for the roots that are always at 1."""
        row = self.loop.balls({self.symbol: q})
        for _ in range(self.always):
            rest = [row[-1]]
            for x in row[-2:0:-1]:
                rest.append(x + rest[-1])
            row = rest[::-1]
        return row

    def tests(self, q: Ball) -> tuple[Ball, Ball, Ball]:
        """At z = 1, at z = -1, and where two roots v add up to 0: numbers that vanish where a root is on the circle."""
        return circle_tests(self.loop, {self.symbol: q}, self.at_one, self.always)

    def is_clear(self, q: Ball) -> bool:
        """Whether no root is on the circle for any number in a ball, proven."""
        try:
            return is_clear(self.loop, {self.symbol: q}, self.at_one, self.always, self.opposite)
        except (UndecidedError, ZeroDivisionError):
            return False

    def angle(self, q: Ball, bits: int) -> Ball:
        """Of the pair on the circle: its argument, to so many bits; not finite where balls do not tell."""
        try:
            roots = acb_poly(self.row(q)).roots(tol=arb(2) ** -bits, maxprec=2 * flint.ctx.prec)
        except ValueError:
            return arb("nan")
        found = [z.arg() for z in roots if abs(z).overlaps(arb(1)) and z.imag > 0]
        return found[0] if len(found) == 1 else arb("nan")

    def period(self, q: Ball) -> Ball:
        """T, s."""
        return expression_ball(self.loop.T, {self.symbol: q})


@dataclass(frozen=True)
class Walk:
    """From a value on, cell after cell."""

    loop: Opened
    start: Fraction
    home: int
    rule: Rule

    def towards(self, side: int) -> tuple[Passage | None, Fraction]:
        """The nearest change on one side, None where there is none, and as far as that is known."""
        scale = abs(self.start) or Fraction(1)
        end = self._end(side, scale)
        at, step, fine, growth = self.start, scale / 64, 0, _GROWTH
        for _ in range(_MOST_CELLS):
            try:
                tick()
            except LimitError:
                break
            if at == end:
                found = self._at_0(at, side)
                return found, Fraction(0) if found or self._is_clear_down_to_0(at, side) else at
            further = _short(at + side * step)
            ahead = min(further, end) if side > 0 else max(further, end)
            if self._is_clear(at, ahead):
                at, step, growth = ahead, _short(step * (1 + growth)), min(_GROWTH, _short(growth * Fraction(5, 4)))
            elif step > _FINEST * max(abs(at), scale * _FINEST):
                step, growth = step / 2, growth / 2  # soon about as long as may be
            else:
                try:
                    found, at = self._over(at, side * step)
                except UndecidedError:
                    break
                fine += 1
                if found is not None:
                    return found, at
                if fine > _MOST_FINE:
                    break
        return None, at

    def _end(self, side: int, scale: Fraction) -> Fraction:
        far: Fraction = self.start + side * scale * 2**_REACH
        return far if side > 0 or self.rule is Rule.ANY else self.start / 2**_REACH

    def _is_clear(self, one: Fraction, other: Fraction) -> bool:
        with flint.ctx.workprec(_BITS):
            return self.loop.is_clear(_ball(one).union(_ball(other)))

    def _over(self, one: Fraction, step: Fraction) -> tuple[Passage | None, Fraction]:
        """Past values where balls do not tell: a change there, None if there is none, and how far that goes."""
        for times in _STEPS:
            other = one + times * step
            count, on = self.loop.count(Rational(other.numerator, other.denominator))
            if on:
                raise UndecidedError("where a root stays on the unit circle")
            if count != self.home:
                return self._between(one, other, count), other
            low, high = sorted((one, other))
            if self._has_none(low, high, _DEEPEST):
                return None, other
        raise UndecidedError("whether roots reach the unit circle and go back")

    def _has_none(self, low: Fraction, high: Fraction, depth: int) -> bool:
        """Whether no value between two puts a root on the circle, proven; in ever smaller pieces, as beside one that does."""
        tick()
        with flint.ctx.workprec(_BITS):
            if self.loop.is_clear(_ball(low).union(_ball(high))):
                return True
        middle = (low + high) / 2
        return depth > 0 and self._has_none(low, middle, depth - 1) and self._has_none(middle, high, depth - 1)

    def _between(self, one: Fraction, other: Fraction, count: int) -> Passage:
        """The change between two values that are close to each other, to a count at the other one."""
        low, high = sorted((one, other))
        side = 1 if other > one else -1
        below, above = (self.home, count) if side > 0 else (count, self.home)
        with flint.ctx.workprec(_BITS):
            ends = [self.loop.tests(_ball(x)) for x in (low, high)]
            changed = [i for i, (x, y) in enumerate(zip(*ends, strict=True)) if x * y < 0]
        if len(changed) != 1:
            raise UndecidedError("where roots reach the unit circle together")
        if low < 0 < high and changed[0] == 0 and self.loop.at_one.xreplace({self.loop.symbol: Integer(0)}) == 0:
            return Passage(_ZERO, _ZERO, below, above)
        value = CriticalValue(self.loop, changed[0], low, high)
        return Passage(value, Swing(value), below, above)

    def _is_clear_down_to_0(self, at: Fraction, side: int) -> bool:
        """Whether no value down to 0, where the number may not be less, puts a root on the circle; 0 is among them."""
        return side < 0 < self.start and self.rule is not Rule.ANY and self._is_clear(at, Fraction(0))

    def _at_0(self, at: Fraction, side: int) -> Passage | None:
        """At the end of what was looked at: a change at 0 itself, where a root comes to 1; None where that stays open."""
        if side > 0 or self.rule is not Rule.NONNEGATIVE or self.start == 0:
            return None
        try:
            count, _ = self.loop.count(Integer(0))
        except UndecidedError:
            return None
        left = (self.loop.at_one / self.loop.symbol).expand()
        with flint.ctx.workprec(_BITS):
            q = arb(0).union(_ball(at))
            rest = expression_ball(left, {self.loop.symbol: q}), *self.loop.tests(q)[1:]
            clear = not any(x.contains(0) or not x.is_finite() for x in rest)
        if count == self.home or not clear or left.has(1 / self.loop.symbol) or self.loop.always:
            return None
        return Passage(_ZERO, _ZERO, count, self.home)


def _short(x: Fraction) -> Fraction:
    """A number nearby with few digits, so that sums of many steps have no more."""
    return Fraction(float(x))


def _ball(x: Fraction) -> Any:
    return arb(x.numerator) / arb(x.denominator)
