"""Proofs that a box of frequencies omega and values q holds exactly one pair with C(j omega; q) =
0, or, beside omega = 0, none.

C is the characteristic function of a loop with one free parameter q (``loops``); s^m, the highest
whole power of s that all of its terms share, is divided out of it in all of this module. The q of a
pair is a *critical value*: there the loop has a root on the imaginary axis. Any C will do: q may be
in its coefficients, in its delays and in its powers of s.

**omega > 0.** f(omega, q) = C(j omega; q), a sum of terms c(q) exp(p(q) log(j omega) - j omega
lag(q)), is two real equations in two unknowns. For a box X with middle x and the Jacobian J of f
over all of X, the *interval Newton operator* is N(X) = x - J(X)^-1 f(x). Every zero of f in X lies
in N(X); if N(X) lies in the interior of X, then X holds exactly one (Moore, Kearfott and Cloud,
Introduction to Interval Analysis, 2009, chapter 8). Boxes are pairs of balls (midpoint and radius)
that FLINT rounds outward, so that this is a proof.

**omega = 0.** The logarithm is lost there, and Im C, which is 0 at omega = 0 for every q, tells
nothing. ``at_0`` finds the q with a root at s = 0 exactly, and ``has_no_pair_beside_0`` excludes
others next to it by Taylor's formula.

Begin with ``Characteristic.only_pair``: it returns the proven ``Pair``, which then has its
frequency and its value to any number of bits. The search that asks for boxes is in ``cellsearch``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import comb, perm
from typing import NamedTuple, Protocol

import flint
from flint import acb, arb
from sympy import Expr, Integer, Poly, factorial

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, RealNumber, expression_ball
from haptisym.kernel.rootcount import Row
from haptisym.verbs.stability.loops import Loop, balls, horner, zeros

# Working precision of the proofs, bits: far finer than the floats that propose the boxes.
_BITS = 128
# Newton steps for one pair at most; each doubles the number of bits, so that far fewer are needed.
_MOST_STEPS = 64
# Bits by which these steps work more finely than the result that is asked for.
_GUARD_BITS = 32
# Powers of s that are tried for the lowest one of C's expansion at 0; ``kernel.rootcount`` tries as
# many, so that no root can be counted at a value of q where this is not enough.
_MOST_ORDERS = 64


class _Constants(NamedTuple):
    """The numbers of one term: balls around the row of c; and power, lag, and the derivatives of
    both by q, as a ball each, or as an expression where it holds q."""

    row: list[Ball]
    others: list[Ball | Expr]


@dataclass(frozen=True)
class _Term:
    """c(q) s^power exp(-s lag). ``row`` : the coefficients of c by ascending powers of q.

    ``slopes`` : the derivatives of power and lag by q.
    """

    row: Row
    power: Expr
    lag: Expr
    slopes: tuple[Expr, Expr]


class NewtonSystem(Protocol):
    """Two real equations in two unknowns, with their interval Newton operator: a
    ``Characteristic``, or in tests a system whose zeros are known."""

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """N of a box: it holds all zeros of the box; None where it has no bounds."""


@dataclass(frozen=True)
class Characteristic:
    """C of a ``loop`` over s^m on the imaginary axis; see the top of the module."""

    loop: Loop

    @cached_property
    def shared(self) -> int:
        """The whole power m of s that all terms of C share."""
        # The first variable of the loop's ring is s.
        return min(int(exponents[0]) for exponents in self.loop.numerator.monoms())

    @cached_property
    def _terms(self) -> list[_Term]:
        q, terms = self.loop.symbol, list[_Term]()
        for power, rows in self.loop.table.items():
            for exponents, row in rows.items():
                lag = self.loop.lag(exponents)
                slopes = power.diff(q), lag.diff(q)
                terms.append(_Term(row, power - self.shared, lag, slopes))
        return terms

    # Pairs with omega > 0: interval Newton

    def only_pair(self, omega: Ball, q: Ball) -> Pair | None:
        """The one pair in a box; None where it is not proven that there is exactly one, be there
        none, several, or one that this box does not prove."""
        with flint.ctx.workprec(_BITS):
            box = self.step(omega, q)
            if box and omega.contains_interior(box[0]) and q.contains_interior(box[1]):
                return Pair(self, *box)
        return None

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """N(X) of the box X = (omega, q), which holds all pairs of X and may reach beyond it; None
        where N(X) has no bounds, as J may be singular in X, or where X touches omega = 0."""
        if not omega > 0:
            return None
        f = self.value(omega.mid(), q.mid())[0]
        _, f_omega, f_q = self.value(omega, q)
        # Cramer's rule. The determinant may be 0 at a double zero.
        determinant = f_omega.real * f_q.imag - f_q.real * f_omega.imag
        if not determinant.is_finite() or determinant.contains(0):
            return None
        of_omega = f.real * f_q.imag - f.imag * f_q.real
        of_q = f_omega.real * f.imag - f_omega.imag * f.real
        return omega.mid() - of_omega / determinant, q.mid() - of_q / determinant

    def value(self, omega: Ball, q: Ball) -> tuple[Ball, Ball, Ball]:
        """Complex balls around f, df/d omega and df/dq over a box with omega > 0, at the current
        working precision."""
        known = {self.loop.symbol: q}
        log = acb(omega.log(), arb.pi() / 2)
        f = f_omega = f_q = acb(0)
        for row, others in self._constants():
            p, lag, p_q, lag_q = (
                x if isinstance(x, arb) else expression_ball(x, known) for x in others
            )
            c, c_q = horner(row, q)
            # A term is c exp(u) with u = p log(j omega) - j omega lag. Its derivatives are c u'
            # exp(u) by omega, and (c' + c u') exp(u) by q, each with its own u'.
            wave = (log * p - acb(0, omega * lag)).exp()
            f += c * wave
            f_omega += c * wave * acb(p / omega, -lag)
            u_q = log * p_q - acb(0, omega * lag_q)
            f_q += wave * (c_q + c * u_q)
        return f, f_omega, f_q

    def _constants(self) -> list[_Constants]:
        """The numbers of each term, at the current working precision."""
        # Those without q are the same in thousands of boxes: one set of balls for each precision.
        if flint.ctx.prec not in self._constants_by_bits:
            self._constants_by_bits[flint.ctx.prec] = [*self._new_constants()]
        return self._constants_by_bits[flint.ctx.prec]

    @cached_property
    def _constants_by_bits(self) -> dict[int, list[_Constants]]:
        return {}

    def _new_constants(self) -> Iterator[_Constants]:
        for x in self._terms:
            others = (x.power, x.lag, *x.slopes)
            exact_or_balls = [y if y.free_symbols else expression_ball(y) for y in others]
            yield _Constants(balls(x.row), exact_or_balls)

    # Roots at s = 0, and next to it

    def at_0(self) -> list[RealNumber]:
        """The values of q with more roots at s = 0 than almost all other values have, exactly: all
        of them, if q is in no power of s.

        If it is in one, C has no expansion at 0 that holds for all q, and the list is empty: it is
        then not known which values there are. Nothing is lost by it, as ``has_no_pair_beside_0`` is
        False for such a C: a search leaves values as open wherever C may vanish at 0.
        UndecidedError where too many terms of the expansion at 0 vanish for all q.
        """
        if self._lowest_term is None:
            return []
        return zeros(self._lowest_term[1].all_coeffs()[::-1])

    @cached_property
    def _lowest_term(self) -> tuple[Expr, Poly] | None:
        """The lowest term P(q) s^n of the expansion of C at s = 0 in which P is not the polynomial
        0, as (n, P); None where q is in a power of s."""
        if any(x.power.free_symbols for x in self._terms):
            return None
        # A term s^p exp(-s lag) has the powers p, p + 1, p + 2, ... All that may be in C are tried
        # in ascending order, up to the first one that may be missing from the list.
        powers = {x.power + k for x in self._terms for k in range(_MOST_ORDERS)}
        end = min(x.power for x in self._terms) + _MOST_ORDERS
        for n in sorted(powers):
            if n < end and not (P := self._coefficient_at_0(n)).is_zero:
                return n, P
        raise UndecidedError("the order of a characteristic function at s = 0")

    def _coefficient_at_0(self, n: Expr) -> Poly:
        """The coefficient of s^n in the expansion of C at s = 0, a polynomial in q."""
        q, total = self.loop.symbol, Integer(0)
        for x in self._terms:
            k = n - x.power
            if k.is_Integer and k >= 0:
                monomials_of_c = (y * q**i for i, y in enumerate(x.row))
                c = sum(monomials_of_c, Integer(0))
                # c s^p exp(-s lag) has c (-lag)^k/k! before s^(p + k).
                total += c * (-x.lag) ** k / factorial(k)
        # A lag that holds q is a number times q, so that its powers are polynomials in q too.
        return Poly(total.expand(), q)

    def has_no_pair_beside_0(self, omega: Ball, q: Ball) -> bool:
        """Whether it is proven that a box that begins at omega = 0 holds no pair with omega > 0;
        False proves nothing.

        Let n be the order of C at s = 0 for almost all q. Then C and its first n - 1 derivatives by
        s are 0 at s = 0, for all q. By Taylor's formula with the remainder as an integral, M_k
        being means of the k-th derivative over the segment from 0 to s,

            C/s^n = M_n/n!,    C/s^n - (C/s^n at 0) = s M_(n+1)/(n+1)!,

        and the value at 0 is real. With s = j omega, Re C/s^n is nowhere 0 if Re of the n-th
        derivative is nowhere 0 over the box, and Im C/s^n if Re of the (n+1)-th is nowhere 0.
        Either excludes a pair. It takes whole powers of s; there is no such n where q is in one.
        """
        if not self._has_whole_powers or self._lowest_term is None:
            return False
        with flint.ctx.workprec(_BITS):
            n = int(self._lowest_term[0])
            derivatives = (self._derivative(k, omega, q) for k in (n, n + 1))
            return any(not x.real.contains(0) for x in derivatives)

    @cached_property
    def _has_whole_powers(self) -> bool:
        return all(x.power.is_Integer for x in self._terms)

    def _derivative(self, n: int, omega: Ball, q: Ball) -> Ball:
        """A complex ball around the n-th derivative of C by s, by Leibniz' rule for s^p times
        exp(-s lag)."""
        s, total = acb(0, omega), acb(0)
        for x in self._terms:
            p, factor = int(x.power), acb(0)
            lag = expression_ball(x.lag, {self.loop.symbol: q})
            for i in range(min(n, p) + 1):
                of_power = perm(p, i) * s ** (p - i)
                factor += comb(n, i) * of_power * (-lag) ** (n - i)
            c, _ = horner(balls(x.row), q)
            total += c * factor * (-s * lag).exp()
        return total


@dataclass(frozen=True, eq=False)
class Pair:
    """The one zero of a ``system`` in the box (``omega``, ``q``), refined to any number of bits."""

    system: NewtonSystem
    omega: Ball
    q: Ball
    _by_bits: dict[int, tuple[Ball, Ball]] = field(default_factory=dict)

    def at(self, bits: int) -> tuple[Ball, Ball]:
        """Balls around frequency and value, to about that many bits; wider where the steps end
        earlier."""
        if bits not in self._by_bits:
            start = self.omega, self.q
            if self._by_bits:
                start = self._by_bits[max(self._by_bits)]
            with flint.ctx.workprec(bits + _GUARD_BITS):
                self._by_bits[bits] = self._refined(start)
        return self._by_bits[bits]

    def _refined(self, box: tuple[Ball, Ball]) -> tuple[Ball, Ball]:
        """The box after Newton steps, at the current working precision."""
        # Steps converge quadratically until the working precision ends it: then they no longer
        # halve either side.
        for _ in range(_MOST_STEPS):
            after = self.system.step(*box)
            if after is None:
                break
            (omega, q), (new_omega, new_q) = box, after
            halves_omega = 2 * new_omega.rad() < omega.rad()
            halves_q = 2 * new_q.rad() < q.rad()
            if not (halves_omega or halves_q):
                break
            box = omega.intersection(new_omega), q.intersection(new_q)
        return box

    @property
    def frequency(self) -> RealNumber:
        """Its omega."""
        return _Coordinate(self, 0)

    @property
    def value(self) -> RealNumber:
        """Its q."""
        return _Coordinate(self, 1)


@dataclass(frozen=True, repr=False)
class _Coordinate(RealNumber):
    """The frequency (``index`` 0) or the value (1) of a pair, as a number."""

    pair: Pair
    index: int

    def ball(self, bits: int) -> Ball:
        return self.pair.at(bits)[self.index]
