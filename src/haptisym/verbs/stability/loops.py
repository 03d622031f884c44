"""A loop with one free parameter q: its exact characteristic function C(s; q), and the count of its
roots in Re s >= 0 at one value of q.

A *display* renders a virtual environment through a haptic device; the user's *hand* closes the
loop. H_perc(s) is the dynamics, force over position, that the hand feels, and Z_hand(s) = m s^2 +
b s + k that of the hand. The roots of the loop are the zeros of H_perc + Z_hand. One
parameter q of display or hand stays free, all others have numbers. With D the denominator of
H_perc,

    H_perc + Z_hand = C(s; q)/D(s; q),
    C(s; q) = sum over p, n and i of c[p][n][i] q^i s^p exp(-s (n_1 lag_1 + n_2 lag_2 + ...)),

with exact real numbers c, real powers p >= 0 and whole numbers n_k >= 0. The lag_k are the *unit
delays*: the few delays of which all others are sums of whole multiples. Most often q is in the
coefficients alone; but it may be a delay, and so in the lag_k, or an exponent in a power p.

The module holds ``Loop``, which makes C (``Loop.of``) and counts roots (``Loop.roots_at``);
``CriticalRoot``, the form in which ``crossingcurve``, ``neutralchains``, ``delayswitches`` and
``cellsearch`` return the values of q at which that count changes; and the arithmetic of rows that
these share. Which of them is used when, and what is complete, is in ``critical``.

**Layout of the ring.** A polynomial of ``Loop.ring`` is a FLINT polynomial with the variables x0,
x1, ..., which mean in this order: s, pi, the symbols (q is one of them), exp(-s lag_k) for each
unit delay, s^order for each fractional power, and j if a number of the loop is complex.
``ring.meanings`` is that list, and ``ring.size`` the number of variables before the first delay. A
monomial is the tuple of its exponents.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from flint import arb, fmpq
from sympy import Add, Expr, Integer, Rational, Symbol

from haptisym.judge.passivity import is_stable_by_parts
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    RealNumber,
    expression_ball,
    ordered,
    rational_between,
)
from haptisym.kernel.rings import Polynomial, RationalFunction, coefficients, monomials
from haptisym.kernel.rootcount import Roots, Row, terms_of
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.sets import CriticalValue
from haptisym.model.catalogue import Hand
from haptisym.model.existence import real_roots
from haptisym.model.parameters import values
from haptisym.model.scene import Knob, Scene
from haptisym.model.valueranges import ALLOWED
from haptisym.verbs.stability.held import zeros_of

# Phase of a unit delay, rad, at the frequency up to which roots on the axis are looked for one
# by one. A condition that swings with the phase has a zero every pi radians: some 130 in all.
_MOST_PHASE = 400

_NO_DISPLAY = "a display that is divided by 0"

# The variable of a polynomial in q whose other symbols are gone.
_Q = Symbol("q", real=True)

Exponents: TypeAlias = tuple[int, ...]
"""The exponents n_1, n_2, ... of the unit delays in a product of them, in the ring's order."""

Table: TypeAlias = dict[Expr, dict[Exponents, Row]]
"""The coefficients c of C: table[power of s][exponents of the unit delays][power of q]. A power is
a number, or n + k q where q is an exponent."""


@dataclass(frozen=True)
class CriticalRoot(CriticalValue):
    """A critical value of q, with where its root lies: on the axis at ``omega``, rad/s.

    ``omega`` is None in three cases, in which there is no one frequency: the root comes from
    infinity; there are roots at all frequencies at once; or the value is an end of q's range, which
    may be critical.

    ``sense`` : how many pairs of roots, s and its conjugate, go from the left of the axis to its
    right there as q increases; negative where they go to the left, 0 where they only touch the
    axis; None where that is not known.
    """

    omega: RealNumber | None = None
    sense: int | None = None


@dataclass(frozen=True)
class Loop:
    """C and D as polynomials of ``ring``, in which the ``symbol`` q stays free: ``numerator``, and
    ``denominator``.

    A root of the loop is a zero of C that is none of D.

    ``low``, ``high`` : the range of values that q may have; None where it has no end on that side.
    ``has_roots_at_0_alone`` : True where it is proven that for all q > 0 no root in Re s >= 0 is
    other than 0, because the display is passive and the hand has damping. False proves nothing.
    """

    ring: Ring
    numerator: Polynomial
    denominator: Polynomial
    symbol: Symbol
    low: Expr | None = None
    high: Expr | None = None
    has_roots_at_0_alone: bool = False

    @classmethod
    def of(cls, scene: Scene, hand: Hand, free: Knob) -> Loop:
        """The loop of a display in a hand with ``free`` as q, a parameter of either."""
        numbers = values(x for x in scene.parameters if x.path != free.path)
        display = scene.chain.at(numbers)
        numbers_of_hand = values(x for x in hand.parameters if x.symbol != free.symbol)
        Z_hand = hand.dynamics.xreplace(numbers_of_hand)
        ring = Ring.of([*display.entries(), Z_hand])
        # H_perc, as it is felt through all effects.
        H = display.perceived(range(len(display.matrices)), ring)
        Z = ring.convert(Z_hand)
        numerator = H.numerator * Z.denominator + Z.numerator * H.denominator
        # What is shown by signs is true for parameters > 0, and for powers of s up to 1. A rule
        # without a low end allows negative q, for which nothing follows; all other rules have the
        # low end 0, and the one with a high end has 1. The hand must have damping: as a number > 0,
        # or as q itself. That q > 0 is asked by ``roots_at``.
        allowed = ALLOWED[free.rule]
        is_power = any(x.has(free.symbol) for x in ring.orders)
        needed = allowed.ends if is_power else (allowed.low,)
        has_damping = hand.b.symbol == free.symbol or sign_of_number(hand.b.value) > 0
        is_passive = None not in needed and has_damping and is_stable_by_parts(scene, display)
        return cls(
            ring, numerator, H.denominator, free.symbol, allowed.low, allowed.high, is_passive
        )

    # How q occurs in C

    @cached_property
    def has_q_in_exponent(self) -> bool:
        """Whether q is in a delay or in a power of s: then C is no polynomial in q."""
        exponents = (*self.ring.lags, *self.ring.orders)
        return any(self.symbol in x.free_symbols for x in exponents)

    @property
    def depends_on_q(self) -> bool:
        """Whether q is in C at all; if not, no root moves."""
        degrees = zip(self.numerator.degrees(), self.ring.meanings, strict=True)
        return any(degree and self.symbol in x.free_symbols for degree, x in degrees)

    @property
    def _index(self) -> int:
        """The number of the variable q; ValueError where q is in no polynomial of the ring."""
        return self.ring.meanings.index(self.symbol)

    @cached_property
    def coefficients(self) -> list[Polynomial]:
        """C by ascending powers of q; C alone where q is in no coefficient."""
        is_variable = self.symbol in self.ring.meanings
        return coefficients(self.numerator, self._index) if is_variable else [self.numerator]

    @cached_property
    def table(self) -> Table:
        """The coefficients of C: ``table[p][n][i]`` is the number before q^i s^p exp(-s sum n_k
        lag_k). A missing p or n stands for 0."""
        of_powers = [terms_of(p, self.ring) if p else {} for p in self.coefficients]
        table: Table = {}
        for i, terms in enumerate(of_powers):
            for power, group in terms.items():
                rows = table.setdefault(power, {})
                for exponents, c in group.items():
                    row = rows.setdefault(exponents, [Integer(0)] * len(of_powers))
                    row[i] = c
        return table

    def lag(self, exponents: Exponents) -> Expr:
        """The delay of a product of unit delays, s."""
        lags = zip(exponents, self.ring.lags, strict=True)
        return sum((n * lag for n, lag in lags), Integer(0))

    @property
    def leading(self) -> dict[Exponents, Row]:
        """The coefficient L of the highest power of s, as the rows of the table: it decides what
        happens at infinity.

        UndecidedError where q is in a power of s and which power is highest depends on q.
        """
        if not any(self.symbol in x.free_symbols for x in self.ring.orders):
            return self.table[max(self.table)]
        ends = [{self.symbol: x} for x in (self.low, self.high) if x is not None]
        # Powers are n + k q: an exponent of s is a number or the symbol. One that is at least
        # another at both ends of q's range, and larger at one, is larger at all values between.
        for power, rows in self.table.items():
            others = [power - x for x in self.table if x != power]
            leads = [[x.xreplace(end) for end in ends] for x in others]
            is_highest = all(min(lead) >= 0 and max(lead) > 0 for lead in leads)
            if len(ends) == 2 and is_highest:
                return rows
        raise UndecidedError("where roots meet the imaginary axis as a power of s changes")

    def has_large_phase(self, radius: Expr) -> bool:
        """Whether a unit delay has at ``radius``, rad/s, a phase too large for one root after the
        other to be looked for. No lag may hold q."""
        return any(float(radius * lag) > _MOST_PHASE for lag in self.ring.lags)

    # One value of q

    def roots_at(self, value: Rational) -> Roots:
        """The roots in Re s >= 0 at q = ``value``, counted exactly.

        UndecidedError where there is no loop at the value, or where the count is undecided.
        Infinitely many are not to be counted where passivity leaves only a root at 0 (``rests``).
        """
        if not self.exists(value):
            raise UndecidedError(_NO_DISPLAY)
        at_0_alone = self.has_roots_at_0_alone and value > 0
        if self.has_q_in_exponent:
            return self._roots_over_another_ring(value, at_0_alone=at_0_alone)
        if self.symbol not in self.ring.meanings:
            # The roots are the same for all q, so for q > 0 too.
            is_passive = self.has_roots_at_0_alone
            return zeros_of(self.numerator, self.denominator, self.ring, rests=is_passive)
        numerator, denominator = self._polynomials_at(value)
        # C and D may share a factor at this value alone: its zeros are no roots.
        ratio = RationalFunction(self.ring, numerator, denominator).reduced()
        return zeros_of(ratio.numerator, ratio.denominator, self.ring, rests=at_0_alone)

    def _roots_over_another_ring(self, value: Rational, *, at_0_alone: bool) -> Roots:
        """``roots_at`` for a q in an exponent: with a number for q its delay or power may be a
        multiple of another one, which is one variable of the ring that is made here."""
        known = {self.symbol: value}
        meanings = [x.xreplace(known) for x in self.ring.meanings]
        ring = Ring.of(meanings)
        images = [ring.convert(x) for x in meanings]
        denominator = _substituted(self.denominator, images)
        if denominator.is_zero:
            raise UndecidedError(_NO_DISPLAY)
        ratio = (_substituted(self.numerator, images) / denominator).reduced()
        return zeros_of(ratio.numerator, ratio.denominator, ring, rests=at_0_alone)

    def exists(self, value: Rational) -> bool:
        """Whether there is a loop at q = ``value``: False where D is the polynomial 0 there, and
        where C is, of which every s would be a root.

        Where q is in an exponent True is returned without a test: ``roots_at`` raises
        UndecidedError at such a value.
        """
        if self.has_q_in_exponent or self.symbol not in self.ring.meanings:
            return True
        numerator, denominator = self._polynomials_at(value)
        return not (denominator.is_zero() or numerator.is_zero())

    def _polynomials_at(self, value: Rational) -> tuple[Polynomial, Polynomial]:
        """C and D with a number for the variable q."""
        number = {f"x{self._index}": fmpq(int(value.p), int(value.q))}
        return self.numerator.subs(number), self.denominator.subs(number)

    def value_between(self, low: RealNumber | None, high: RealNumber | None) -> Rational:
        """A rational number strictly between two numbers, None being no bound, at which there is a
        loop."""
        value = rational_between(low, high)
        # C or D is the polynomial 0 at finitely many q, so this ends.
        while not self.exists(value):
            value = rational_between(ExactNumber(value), high)
        return value


def _substituted(polynomial: Polynomial, images: Sequence[RationalFunction]) -> RationalFunction:
    """A polynomial with ``images[i]`` for its i-th variable. By hand, because SymPy would write a
    product of two delays as one delay, which the ring of the images may not have."""
    total = images[0].ring.zero
    for exponents, coefficient in monomials(polynomial):
        term = total.ring.function(total.ring.context.constant(coefficient))
        for image, n in zip(images, exponents, strict=True):
            term = term * image ** int(n)
        total = total + term
    return total


# Rows: the coefficients of a polynomial in q, by ascending powers


def zeros(row: Sequence[Expr]) -> list[RealNumber]:
    """The real zeros of the polynomial in q with ascending coefficients ``row``, each once; an
    empty list for the polynomial 0, of which every number is a zero."""
    terms = (c * _Q**n for n, c in enumerate(row))
    polynomial = Add(*terms)
    ring = Ring.of([polynomial])
    if _Q not in ring.meanings:
        return []
    index = ring.meanings.index(_Q)
    factors = ring.convert(polynomial).numerator.factor()[1]
    return [x for factor, _ in factors for x in real_roots(factor, index, negative=True)]


def balls(row: Row) -> list[Ball]:
    """Balls around the coefficients of a row, at the current working precision."""
    return [*map(expression_ball, row)]


def horner(row: Sequence[Ball], q: Ball) -> tuple[Ball, Ball]:
    """The value and the derivative at q of the polynomial with ascending coefficients ``row``."""
    value = derivative = arb(0)
    for c in reversed(row):
        value, derivative = value * q + c, derivative * q + value
    return value, derivative


# Polynomials, functions and numbers


def minus(f: RationalFunction, number: Expr) -> RationalFunction:
    """f - number, over the denominator of f, which stays nowhere negative if it was so."""
    shift = f.ring.convert(number)
    numerator = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(numerator, f.denominator * shift.denominator)


def is_between(x: RealNumber, low: RealNumber | None, high: RealNumber | None) -> bool:
    """Whether x lies strictly between two numbers, None being no bound on that side. Numbers that
    ``kernel.reals.ordered`` does not distinguish count as equal."""
    # ``ordered`` is 1 where its second argument is the larger one.
    is_above = low is None or ordered(low, x) > 0
    return is_above and (high is None or ordered(x, high) > 0)
