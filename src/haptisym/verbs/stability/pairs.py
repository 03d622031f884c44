"""Pairs of a frequency and a value of the open number at which a loop has a root on the imaginary axis: proven by Newton's step.

f(omega, q) = C(j omega; q), each term c(q) exp(p(q) log(j omega) - j omega lag(q)), is 0 in real and imaginary part. Where the
step of a box of both, in balls, stays inside the box, there is one pair in it and no other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import comb, perm

import flint
from flint import acb, arb
from sympy import Expr, Integer, Poly, factorial

from haptisym.kernel.reals import Ball, Negative, RealNumber, expression_ball
from haptisym.kernel.squares import Row
from haptisym.verbs.stability.loops import Loop, zeros
from haptisym.verbs.stability.reach import lag_of

_BITS = 128
_MOST_STEPS, _MORE = 64, 32
_MOST_ORDERS = 8


@dataclass(frozen=True)
class _Term:
    """c(q) s^power exp(-s lag): ``row`` : of c, by ascending powers of q."""

    row: Row
    power: Expr
    lag: Expr


@dataclass(frozen=True)
class Characteristic:
    """C on the imaginary axis and beside omega = 0, of a loop, over the power of s that all of its terms share."""

    loop: Loop

    @cached_property
    def shared(self) -> int:
        """The whole power of s that can be divided out."""
        return min(int(exponents[0]) for exponents in self.loop.top.monoms())

    @cached_property
    def _terms(self) -> list[_Term]:
        return [
            _Term(row, p - self.shared, lag_of(turns, self.loop))
            for p, group in self.loop.table.items()
            for turns, row in group.items()
        ]

    def value(self, omega: Ball, q: Ball) -> tuple[Ball, Ball, Ball]:
        """f and its slopes along omega and q, at the current working precision; omega > 0."""
        symbol, known, log = self.loop.symbol, {self.loop.symbol: q}, acb(omega.log(), arb.pi() / 2)
        total = along = across = acb(0)
        for term in self._terms:
            p, lag = (expression_ball(x, known) for x in (term.power, term.lag))
            dp, dlag = (expression_ball(x.diff(symbol), known) for x in (term.power, term.lag))
            c, dc = _horner(term.row, q)
            wave = (log * p - acb(0, omega * lag)).exp()
            total += c * wave
            along += c * wave * acb(p / omega, -lag)
            across += wave * (dc + c * (log * dp - acb(0, omega * dlag)))
        return total, along, across

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """Of Newton from the middle of a box: where all pairs in it lie; None where that is not known."""
        if not omega > 0:
            return None
        f = self.value(omega.mid(), q.mid())[0]
        _, along, across = self.value(omega, q)
        turn = along.real * across.imag - across.real * along.imag
        if not turn.is_finite() or turn.contains(0):
            return None
        return (
            omega.mid() - (f.real * across.imag - f.imag * across.real) / turn,
            q.mid() - (along.real * f.imag - along.imag * f.real) / turn,
        )

    def only(self, omega: Ball, q: Ball) -> Pair | None:
        """The one pair in a box; None where it is not proven that there is just one."""
        with flint.ctx.workprec(_BITS):
            found = self.step(omega, q)
            if found and omega.contains_interior(found[0]) and q.contains_interior(found[1]):
                return Pair(self, *found)
        return None

    # Beside omega = 0, where C/s^n, n being its order there for almost all q, is real

    @cached_property
    def _is_whole(self) -> bool:
        return all(x.power.is_Integer for x in self._terms)

    @cached_property
    def _beginning(self) -> tuple[Expr, Poly] | None:
        """n, and the value of C/s^n at 0, a polynomial in q; None where that is not known, as where a power is open."""
        if any(x.power.free_symbols for x in self._terms):
            return None
        orders = {x.power + k for x in self._terms for k in range(_MOST_ORDERS)}
        for n in sorted(orders):
            total = Integer(0)
            for x in self._terms:
                if (k := n - x.power).is_Integer and k >= 0:
                    c = sum((y * self.loop.symbol**i for i, y in enumerate(x.row)), Integer(0))
                    total += c * (-x.lag) ** k / factorial(k)
            found = Poly(total.expand(), self.loop.symbol)
            if not found.is_zero:
                return n, found
        return None

    def at_0(self) -> list[RealNumber]:
        """The values of q with a root that passes through 0."""
        if self._beginning is None:
            return []
        row = self._beginning[1].all_coeffs()[::-1]
        mirrored = [Negative(x) for x in zeros([c * (-1) ** i for i, c in enumerate(row)])] if len(row) > 2 else []
        return [*zeros(row), *mirrored]

    def is_clear_at_0(self, omega: Ball, q: Ball) -> bool:
        """Whether there is no pair with 0 < omega in a box that begins at 0: by Taylor's formula, from means of derivatives of C.

        C/s^n is one of that of order n, less its value at 0, which is real, j omega times one of that of order n + 1.
        """
        if not self._is_whole or self._beginning is None:
            return False
        with flint.ctx.workprec(_BITS):
            n = int(self._beginning[0])
            return any(not self._derivative(i, omega, q).real.contains(0) for i in (n, n + 1))

    def _derivative(self, n: int, omega: Ball, q: Ball) -> Ball:
        """Of C, of that order, along s."""
        s, total = acb(0, omega), acb(0)
        for x in self._terms:
            p, lag = int(x.power), expression_ball(x.lag, {self.loop.symbol: q})
            each = (comb(n, i) * perm(p, i) * s ** (p - i) * (-lag) ** (n - i) for i in range(min(n, p) + 1))
            total += _horner(x.row, q)[0] * sum(each, acb(0)) * (-s * lag).exp()
        return total


def _horner(row: Row, q: Ball) -> tuple[Ball, Ball]:
    """A polynomial and its slope."""
    value = slope = arb(0)
    for c in reversed(row):
        value, slope = value * q + expression_ball(c), slope * q + value
    return value, slope


@dataclass(frozen=True, eq=False)
class Pair:
    """The one pair in a box."""

    form: Characteristic
    omega: Ball
    q: Ball
    _known: dict[int, tuple[Ball, Ball]] = field(default_factory=dict)

    def at(self, bits: int) -> tuple[Ball, Ball]:
        """Frequency and value with about that many bits: by steps until they do not halve the box any more."""
        if bits not in self._known:
            box = self._known[max(self._known)] if self._known else (self.omega, self.q)
            with flint.ctx.workprec(bits + _MORE):
                for _ in range(_MOST_STEPS):
                    after = self.form.step(*box)
                    if after is None or not any(2 * x.rad() < y.rad() for x, y in zip(after, box, strict=True)):
                        break
                    box = box[0].intersection(after[0]), box[1].intersection(after[1])
            self._known[bits] = box
        return self._known[bits]

    @property
    def frequency(self) -> RealNumber:
        """Its omega."""
        return _Of(self, 0)

    @property
    def value(self) -> RealNumber:
        """Its q."""
        return _Of(self, 1)


@dataclass(frozen=True, repr=False)
class _Of(RealNumber):
    """One side of a pair."""

    pair: Pair
    side: int

    def ball(self, bits: int) -> Ball:
        return self.pair.at(bits)[self.side]
