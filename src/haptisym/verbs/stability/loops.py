"""For which values of one open parameter q a loop has roots on the imaginary axis, and where roots
come from infinity.

The loop is a display, the rendered environment, in a user's hand. Its characteristic function C(s;
q) is a sum of terms c(q) s^p exp(-s lag), with real powers p and delays lag. The number of its
roots in Re s >= 0 changes with q only where some lie on the axis or come from infinity, so that
whoever has all of these *critical values* counts roots once between each two of them
(``critical`` calls what is here in turn, ``limits`` counts). Six subjects, each opened by the
docstring of the class or function that is named:

1. ``Loop``: C as a quotient of polynomials in s, exp(-s lag) and q, and as a table by powers of s;
   the exact count of roots at one q.
2. ``Characteristic``, ``Pair``: any C at all. A box of omega and q holds one pair with C(j omega;
   q) = 0: interval Newton.
3. ``CrossingCurve``: q in coefficients alone. One equation in omega: C = A + q B gives q =
   -Re(A/B) where Im(A/B) = 0; for higher degrees in q it is a resultant.
4. ``from_infinity``, ``BesideChains``: the highest power of s. Where its coefficient vanishes a
   root comes from infinity; with delays in it (neutral type), a chain of infinitely many.
5. ``Switches``: q is one delay. A + B exp(-s q) has roots on the axis where |A| = |B|, which way
   they go is told by |A/B| (Cooke and van den Driessche, 1986).
6. ``Tendency``: whether there are roots in Re s >= 0 for all q of an interval, where infinitely
   many values are critical: roots cross one way alone from some frequency on.

What is returned is proven, but that two numbers are taken for one where hundreds of bits do not
tell them apart (``ordered``). UndecidedError where a loop has none of the forms that a subject
covers, or a root touches the axis without a proof that it does.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, groupby, pairwise, product
from math import comb, perm
from typing import Protocol

import flint
from flint import acb, arb, arb_poly, fmpq
from sympy import Add, Expr, Integer, Matrix, Poly, Rational, Symbol, factorial

from haptisym.judge.passivity import rests
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball, rational_between
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in, monomials
from haptisym.kernel.rootcount import Roots, Row, late_turns, squares, terms_of
from haptisym.kernel.roots import ALIKE_BITS, Point, chart, each_once, ordered, sign_of_number
from haptisym.kernel.sets import CriticalValue, CriticalValues, Open
from haptisym.model.catalogue import Hand
from haptisym.model.existence import real_roots
from haptisym.model.parameters import values
from haptisym.model.scene import Knob, Scene
from haptisym.model.valueranges import ALLOWED
from haptisym.verbs.stability.held import zeros_of


@dataclass(frozen=True)
class Loop:
    """The loop: C = H_perc + Z_hand as the quotient of ``top`` and ``bottom``, in both of which the
    ``symbol`` q stays open.

    H_perc is the dynamics, force over position, that the hand feels; ``bottom`` is its denominator.
    A root of the loop is a zero of ``top`` that is none of ``bottom``.

    ``low``, ``high`` : between which values q may be, None where nothing bounds it. ``rests`` :
    whether the loop has no root in Re s >= 0 but at 0 for any q > 0: a hand that damps holds
    passive parts.
    """

    ring: Ring
    top: Polynomial
    bottom: Polynomial
    symbol: Symbol
    low: Expr | None = None
    high: Expr | None = None
    rests: bool = False

    @classmethod
    def of(cls, scene: Scene, hand: Hand, free: Knob) -> Loop:
        """The loop of a display in a hand with ``free`` left open, a parameter of either."""
        display = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        Z = hand.dynamics.xreplace(values(p for p in hand.parameters if p.symbol != free.symbol))
        ring = Ring.of([*display.entries(), Z])
        H = display.perceived(range(len(display.matrices)), ring)
        z = ring.convert(Z)
        top = H.numerator * z.denominator + z.numerator * H.denominator
        # Passivity speaks of parameters > 0, so nothing follows for a q that may be negative. The
        # hand must damp: with its own value, or with q, which then counts where it is > 0.
        allowed = ALLOWED[free.rule]
        damps = hand.b.symbol == free.symbol or sign_of_number(hand.b.value) > 0
        is_at_rest = allowed.low is not None and damps and rests(scene, display)
        return cls(ring, top, H.denominator, free.symbol, allowed.low, allowed.high, is_at_rest)

    @cached_property
    def turns(self) -> bool:
        """Whether q is in a delay or in a power of s, so that it turns the phase of a term."""
        return any(self.symbol in x.free_symbols for x in (*self.ring.lags, *self.ring.orders))

    @property
    def _index(self) -> int:
        return self.ring.meanings.index(self.symbol)

    @cached_property
    def powers(self) -> list[Polynomial]:
        """C by ascending powers of the open number."""
        return coefficients(self.top, self._index if self.symbol in self.ring.meanings else None)

    @property
    def moves(self) -> bool:
        """Whether any root depends on the open number."""
        used = zip(self.top.degrees(), self.ring.meanings, strict=True)
        return any(n and self.symbol in x.free_symbols for n, x in used)

    def at(self, value: Rational) -> Roots:
        """The roots in Re s >= 0 at a number. UndecidedError where there is no display at it."""
        if not self.exists(value):
            raise UndecidedError("a display that is divided by 0")
        # A delay or power with a number for q may be one of the others: the loop is made anew, over
        # the ring in which such are one variable.
        if self.turns:
            known = {self.symbol: value}
            meanings = [x.xreplace(known) for x in self.ring.meanings]
            ring = Ring.of(meanings)
            images = [ring.convert(x) for x in meanings]
            H = (_mapped(self.top, images) / _mapped(self.bottom, images)).reduced()
            return zeros_of(H.numerator, H.denominator, ring, rests=self.rests and value > 0)
        if self.symbol not in self.ring.meanings:
            return zeros_of(self.top, self.bottom, self.ring, rests=self.rests)
        here = {f"x{self._index}": fmpq(int(value.p), int(value.q))}
        # Numerator and denominator may share a factor at this value alone: what cancels is no root.
        found = RationalFunction(self.ring, self.top.subs(here), self.bottom.subs(here)).reduced()
        return zeros_of(
            found.numerator, found.denominator, self.ring, rests=self.rests and value > 0
        )

    def exists(self, value: Rational) -> bool:
        """Whether there is a loop at a value: not where it is divided by 0, nor where top is 0.

        True, and not examined, where q is in a delay or in a power of s.
        """
        if self.turns or self.symbol not in self.ring.meanings:
            return True
        here = {f"x{self._index}": fmpq(int(value.p), int(value.q))}
        return not (self.bottom.subs(here).is_zero() or self.top.subs(here).is_zero())

    def between(
        self, low: RealNumber | None, high: RealNumber | None, own: Expr | None = None
    ) -> Rational:
        """A rational number strictly between two at which there is a display: there is none at few
        of them."""
        found = rational_between(low, high, own)
        # Numerator and denominator are lost at zeros of polynomials in q, which are few: this ends.
        while not self.exists(found):
            found = rational_between(ExactNumber(found), high)
        return found

    @cached_property
    def table(self) -> dict[Rational, dict[tuple[int, ...], Row]]:
        """The coefficients of ``top``: table[power of s][exponents of the unit delays][power of q].

        A unit delay is one exp(-s lag) of which all others are whole powers and products.
        """
        found = [terms_of(p, self.ring) if p else {} for p in self.powers]
        table: dict[Rational, dict[tuple[int, ...], Row]] = {}
        for i, terms in enumerate(found):
            for power, group in terms.items():
                for turns, c in group.items():
                    table.setdefault(power, {}).setdefault(turns, [Integer(0)] * len(found))[i] = c
        return table

    @property
    def leading(self) -> dict[tuple[int, ...], Row]:
        """The row of the table with the highest power of s: what decides at infinity.

        UndecidedError where q is in a power and another one is highest for some of its values.
        """
        if not any(self.symbol in x.free_symbols for x in self.ring.orders):
            return self.table[max(self.table)]
        ends = [{self.symbol: x} for x in (self.low, self.high) if x is not None]
        # Powers are linear in q: one that is not below another at both ends of what q may be, and
        # above it at one, is above it everywhere between.
        for power, group in self.table.items():
            ahead = [[(power - x).xreplace(end) for end in ends] for x in self.table if x != power]
            if len(ends) == 2 and all(min(row) >= 0 and max(row) > 0 for row in ahead):
                return group
        raise UndecidedError("where roots meet the imaginary axis as a power of s changes")


def _mapped(polynomial: Polynomial, images: Sequence[RationalFunction]) -> RationalFunction:
    """A polynomial with other functions for its variables; SymPy would make one delay of a product
    of two."""
    total = images[0].ring.zero
    for exponents, value in monomials(polynomial):
        term = total.ring.function(total.ring.context.constant(value))
        for image, n in zip(images, exponents, strict=True):
            term = term * image ** int(n)
        total = total + term
    return total


_Q = Symbol("q", real=True)


def zeros(row: Sequence[Expr]) -> list[RealNumber]:
    """The real zeros of a polynomial with ascending coefficients; none of the polynomial 0, of
    which every number is one."""
    polynomial = Add(*(c * _Q**n for n, c in enumerate(row)))
    ring = Ring.of([polynomial])
    if _Q not in ring.meanings:
        return []
    index = ring.meanings.index(_Q)
    factors = ring.convert(polynomial).numerator.factor()[1]
    return [x for factor, _ in factors for x in real_roots(factor, index, negative=True)]


def coefficients(polynomial: Polynomial, index: int | None) -> list[Polynomial]:
    """The coefficients of a polynomial by ascending powers of one variable; itself where ``index``
    is None."""
    if index is None:
        return [polynomial]
    rows: list[dict[tuple[int, ...], object]] = [
        {} for _ in range(degree_in([polynomial], index) + 1)
    ]
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        rows[power][tuple(own)] = value
    context = polynomial.context()
    return [context.from_dict(row) for row in rows]


def lag_of(turns: Sequence[int], loop: Loop) -> Expr:
    """How late a product of unit delays is, s."""
    return sum((n * x for n, x in zip(turns, loop.ring.lags, strict=True)), Integer(0))


_BITS_PAIRS = 128
# Newton's steps for one pair, and by how many bits they work more finely than what is asked for.
_MOST_STEPS, _MORE = 64, 32
# Powers of s that are looked at, from that of each term on, for the first that is not lost at 0.
_MOST_ORDERS = 8


@dataclass(frozen=True)
class _Term:
    """c(q) s^power exp(-s lag): ``row`` : of c, by ascending powers of q; ``slopes`` : of power and
    lag along q."""

    row: Row
    power: Expr
    lag: Expr
    slopes: tuple[Expr, Expr]


@dataclass(frozen=True)
class Characteristic:
    """Any C on the imaginary axis, over the power of s that all of its terms share: proofs for
    boxes of omega and q.

    f(omega, q) = C(j omega; q), with terms c(q) exp(p(q) log(j omega) - j omega lag(q)), is two
    real equations in two unknowns. Interval Newton: all zeros in a box lie in N = middle - J^-1
    f(middle), J the Jacobian over all of the box; where N lies inside of the box, there is just
    one. ``only`` returns it as a ``Pair``, None where that is not proven.

    At omega = 0 the logarithm is lost, and C, being real there, vanishes in its imaginary part
    anyway: so ``at_0`` has the q with a root at 0, exactly, and ``is_clear_at_0`` tells of a box
    beside 0, by Taylor's formula, that it holds no pair. False proves nothing.
    """

    loop: Loop

    @cached_property
    def shared(self) -> int:
        """The whole power of s that can be divided out."""
        return min(int(exponents[0]) for exponents in self.loop.top.monoms())

    @cached_property
    def _terms(self) -> list[_Term]:
        q, found = self.loop.symbol, list[_Term]()
        for p, group in self.loop.table.items():
            for turns, row in group.items():
                lag = lag_of(turns, self.loop)
                found.append(_Term(row, p - self.shared, lag, (p.diff(q), lag.diff(q))))
        return found

    @cached_property
    def _in_balls(self) -> dict[int, list[tuple[list[Ball], list[Ball | Expr]]]]:
        return {}

    def _constants(self) -> list[tuple[list[Ball], list[Ball | Expr]]]:
        """The terms' rows and their powers, lags and slopes: what does not hold q as balls, once
        for a working precision."""
        # What does not hold q is the same in thousands of boxes: one set of balls for each
        # precision.
        if flint.ctx.prec not in self._in_balls:
            self._in_balls[flint.ctx.prec] = [
                (
                    _balls(x.row),
                    [
                        y if y.free_symbols else expression_ball(y)
                        for y in (x.power, x.lag, *x.slopes)
                    ],
                )
                for x in self._terms
            ]
        return self._in_balls[flint.ctx.prec]

    def value(self, omega: Ball, q: Ball) -> tuple[Ball, Ball, Ball]:
        """f and its slopes along omega and q, at the current working precision; omega > 0."""
        known, log = {self.loop.symbol: q}, acb(omega.log(), arb.pi() / 2)
        total = along = across = acb(0)
        for row, of in self._constants():
            p, lag, dp, dlag = (x if isinstance(x, arb) else expression_ball(x, known) for x in of)
            c, dc = _horner(row, q)
            # Every term is c exp(u), u = p log(j omega) - j omega lag: its slopes are c u' exp(u)
            # along omega, and c' exp(u) + c u' exp(u) along q.
            wave = (log * p - acb(0, omega * lag)).exp()
            total += c * wave
            along += c * wave * acb(p / omega, -lag)
            across += wave * (dc + c * (log * dp - acb(0, omega * dlag)))
        return total, along, across

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """The step of interval Newton: a box that holds all pairs of a box; None where it has no
        bounds.

        It may reach beyond the box: intersect them.
        """
        if not omega > 0:
            return None
        f = self.value(omega.mid(), q.mid())[0]
        _, along, across = self.value(omega, q)
        # Cramer's rule for two equations; a determinant that may be 0 may belong to a double zero.
        determinant = along.real * across.imag - across.real * along.imag
        if not determinant.is_finite() or determinant.contains(0):
            return None
        return (
            omega.mid() - (f.real * across.imag - f.imag * across.real) / determinant,
            q.mid() - (along.real * f.imag - along.imag * f.real) / determinant,
        )

    def only(self, omega: Ball, q: Ball) -> Pair | None:
        """The one pair in a box; None where it is not proven that there is just one."""
        with flint.ctx.workprec(_BITS_PAIRS):
            found = self.step(omega, q)
            if found and omega.contains_interior(found[0]) and q.contains_interior(found[1]):
                return Pair(self, *found)
        return None

    @cached_property
    def _is_whole(self) -> bool:
        return all(x.power.is_Integer for x in self._terms)

    @cached_property
    def _beginning(self) -> tuple[Expr, Poly] | None:
        """How C begins at s = 0: n, its order for almost all q, and the value of C/s^n at 0, a
        polynomial in q.

        None where that is not known, as where q is in a power.
        """
        if any(x.power.free_symbols for x in self._terms):
            return None
        orders = {x.power + k for x in self._terms for k in range(_MOST_ORDERS)}
        for n in sorted(orders):
            total = Integer(0)
            for x in self._terms:
                if (k := n - x.power).is_Integer and k >= 0:
                    c = sum((y * self.loop.symbol**i for i, y in enumerate(x.row)), Integer(0))
                    # c s^p exp(-s lag) has c (-lag)^k/k! before s^(p + k).
                    total += c * (-x.lag) ** k / factorial(k)
            found = Poly(total.expand(), self.loop.symbol)
            if not found.is_zero:
                return n, found
        return None

    def at_0(self) -> list[RealNumber]:
        """The values of q with more roots at s = 0 than almost all others have."""
        if self._beginning is None:
            return []
        return zeros(self._beginning[1].all_coeffs()[::-1])

    def is_clear_at_0(self, omega: Ball, q: Ball) -> bool:
        """Whether there is no pair with omega > 0 in a box that begins at omega = 0, proven.

        By Taylor's formula with the remainder as an integral, C/s^n is a mean of the derivative of
        order n over [0, s], and C/s^n less its value at 0, which is real, is s times a mean of that
        of order n + 1. So where the real part of the first is nowhere 0 neither is that of C/s^n,
        and where that of the second is nowhere 0 neither is the imaginary part of C/s^n.
        """
        if not self._is_whole or self._beginning is None:
            return False
        with flint.ctx.workprec(_BITS_PAIRS):
            n = int(self._beginning[0])
            return any(not self._derivative(i, omega, q).real.contains(0) for i in (n, n + 1))

    def _derivative(self, n: int, omega: Ball, q: Ball) -> Ball:
        """The n-th derivative of C by s, by Leibniz' rule for s^p times exp(-s lag)."""
        s, total = acb(0, omega), acb(0)
        for x in self._terms:
            p, lag = int(x.power), expression_ball(x.lag, {self.loop.symbol: q})
            each = (
                comb(n, i) * perm(p, i) * s ** (p - i) * (-lag) ** (n - i)
                for i in range(min(n, p) + 1)
            )
            total += _horner(_balls(x.row), q)[0] * sum(each, acb(0)) * (-s * lag).exp()
        return total


def _balls(row: Row) -> list[Ball]:
    return [*map(expression_ball, row)]


def _horner(row: Sequence[Ball], q: Ball) -> tuple[Ball, Ball]:
    """The value and the slope of a polynomial with ascending coefficients."""
    value = slope = arb(0)
    for c in reversed(row):
        value, slope = value * q + c, slope * q + value
    return value, slope


class Stepped(Protocol):
    """A system of two equations with interval Newton's step."""

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """A box that holds all pairs of a box; None where it has no bounds."""


@dataclass(frozen=True, eq=False)
class Pair:
    """The one pair of a frequency ``omega`` and a value ``q`` in a box, to any number of bits."""

    form: Stepped
    omega: Ball
    q: Ball
    _known: dict[int, tuple[Ball, Ball]] = field(default_factory=dict)

    def at(self, bits: int) -> tuple[Ball, Ball]:
        """Frequency and value with about that many bits: by steps until they do not halve the box
        any more."""
        if bits not in self._known:
            # The step converges quadratically until the working precision bounds it: then it no
            # longer halves the box.
            box = self._known[max(self._known)] if self._known else (self.omega, self.q)
            with flint.ctx.workprec(bits + _MORE):
                for _ in range(_MOST_STEPS):
                    after = self.form.step(*box)
                    if after is None or not any(
                        2 * x.rad() < y.rad() for x, y in zip(after, box, strict=True)
                    ):
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
    """The frequency (0) or the value (1) of a pair, as a number."""

    pair: Pair
    side: int

    def ball(self, bits: int) -> Ball:
        return self.pair.at(bits)[self.side]


@dataclass(frozen=True)
class Meeting(CriticalValue):
    """A critical value: roots lie on the axis at ``omega``, rad/s, or come from infinity (None).

    ``sense`` : how many pairs of roots go from its left to its right there as q grows, negative
    where they go to the left; None where that is not known.
    """

    omega: RealNumber | None = None
    sense: int | None = None


@dataclass(frozen=True)
class CrossingCurve:
    """Where a loop with q in its coefficients alone has roots on the axis: where ``condition``
    vanishes, with q = ``value`` there.

    All three are functions of omega whose denominators are squares, so that a numerator has the
    sign of the whole. ``square`` : the square of that value, there alone: of A + q B it is |A/B|^2,
    which may settle far out where -Re(A/B) swings on. ``is_linear`` : whether C is A + q B; then
    -A/B is value - j condition.

    ``meetings`` returns all critical values up to a frequency; ``curve_of`` makes the curve of a
    loop. UndecidedError where a root that touches the axis is not told from one that stays away.
    """

    condition: RationalFunction
    value: RationalFunction
    square: RationalFunction
    is_linear: bool = False

    def meetings(self, reach: Expr) -> tuple[Meeting, ...]:
        """All with omega > 0, up to a frequency; at 0 C is real, so that the condition tells
        nothing."""
        value = RealFunction(self.value.reduced())
        table = chart({"0": RealFunction(self.condition.reduced()), "q": value}, Integer(0), reach)
        if any("0" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        # Where the value has a pole the root is not on the axis for any q.
        places = [
            x for x in table.points[1:] if x.orders.get("0", 0) > 0 and x.orders.get("q", 0) >= 0
        ]
        zero = ExactNumber(Integer(0))
        return tuple(
            Meeting(
                zero if x.orders.get("q") else ValueAt(value, x.omega),
                omega=x.omega,
                sense=self._sense(x),
            )
            for x in places
        )

    def _sense(self, place: Point) -> int | None:
        """How many pairs of roots go to the right; None where C is not linear in q.

        C = 0 is q = g(s), g = -A/B: near the axis g maps the right half plane to the right of the
        curve g(j omega). As q grows along the real axis it crosses that curve, and the root goes to
        the right where Im g rises through 0 with omega; where Im g only touches 0 none crosses.
        """
        return (place.before["0"] - place.after["0"]) // 2 if self.is_linear else None


def minus(f: RationalFunction, number: Expr) -> RationalFunction:
    """A function less a number, over the same denominator."""
    shift = f.ring.convert(number)
    top = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(top, f.denominator * shift.denominator)


def curve_of(loop: Loop) -> CrossingCurve | None:
    """The curve of a loop with q in its coefficients; None where q moves no root.

    UndecidedError where elimination does not give one value of q for each frequency.
    """
    powers = loop.powers
    if len(powers) < 2:
        return None
    if len(powers) == 2:
        ratio = RationalFunction(loop.ring, powers[0], powers[1]).reduced()
        below = on_axis(ratio)
        curve = CrossingCurve(
            below.raw_imag, -below.raw_real, squared_modulus(ratio).function, is_linear=True
        )
    else:
        curve = _eliminated(loop)
    if not curve.condition.is_zero:
        return curve
    # A/B is real on all of the axis: for each value of -A/B roots lie on it. They leave it where
    # two of them meet, which is where that value turns back.
    slope = RealFunction(curve.value.reduced()).derivative().function
    return CrossingCurve(
        slope.ring.function(slope.numerator * slope.denominator, slope.denominator**2),
        curve.value,
        curve.square,
    )


def _eliminated(loop: Loop) -> CrossingCurve:
    """The curve where C is of a higher degree in q: Re C and Im C have a root q in common where
    their resultant vanishes.

    The last remainder of Euclid's algorithm before it, c0 + c1 q (the first subresultant, to a
    factor), tells that root.
    """
    axis = loop.ring.axis
    [(real, imag)] = axis.parts([loop.top])
    index = axis.meanings.index(loop.symbol)
    # With a factor in common the resultant would be 0 everywhere and tell nothing.
    common = real.gcd(imag)
    real, imag = real / common, imag / common
    resultant = real.resultant(imag, f"x{index}")
    linear = _remainder(real, imag, index)
    if resultant.is_zero() or linear is None or not _is_apart(resultant, linear[1], axis):
        raise UndecidedError("where roots meet the imaginary axis")
    c0, c1 = linear
    return CrossingCurve(
        axis.function(resultant), axis.function(-c0 * c1, c1 * c1), axis.function(c0 * c0, c1 * c1)
    )


def _is_apart(f: Polynomial, g: Polynomial, axis: Axis) -> bool:
    """Whether two polynomials are shown to have no zero > 0 in common.

    At one of resultant and c1, Re C and Im C share more than one root q, and c0 + c1 q tells none.
    """
    shared = axis.function(f.gcd(g))
    settled = asymptotic_sign(shared)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        return False
    table = chart({"": RealFunction(shared)}, Integer(0), max(settled.radius, Integer(1)))
    return not table.undecided and not any(x.orders.get("") for x in table.points[1:])


def _remainder(f: Polynomial, g: Polynomial, index: int) -> tuple[Polynomial, Polynomial] | None:
    """The remainder of Euclid's algorithm that is linear in one variable, as (c0, c1); None where
    there is none."""
    while True:
        a, b = coefficients(f, index), coefficients(g, index)
        if len(a) < len(b):
            f, g = g, f
            continue
        if len(b) == 2:
            return b[0], b[1]
        if len(b) < 2:
            return None
        x = f.context().gens()[index]
        # Pseudo-division: times the leading coefficient, so that no fractions arise.
        while len(a) >= len(b) and not f.is_zero():
            f = b[-1] * f - a[-1] * x ** (len(a) - len(b)) * g
            a = coefficients(f, index)
        if f.is_zero():
            return None
        f, g = g, f


ENDLESS = "where roots meet the imaginary axis at ever higher frequencies"
# Delayed terms before the highest power of s: each doubles the choices of signs that are tried.
_MOST_DELAYED = 5


def from_infinity(loop: Loop) -> tuple[Meeting, ...]:
    """All values of q at which roots come from infinity, and perhaps others.

    Far out C is s^n L(z; q), L the coefficient of the highest power of s, with z = exp(-s lag). A
    root comes from infinity where L vanishes for all z. Where delays are in L (a loop of neutral
    type) each zero z of it is a chain of infinitely many roots, with Re s near -log|z|/lag: a chain
    comes to the axis where L has a zero with |z| = 1. L = a + sum of d_i z_i begins or ceases to
    have such zeros where one of |a|, |d_i| is the sum of all others: a zero of a + sum of +-d_i.

    That holds where the z_i turn independently of each other. UndecidedError where they do not
    (two are powers of one z, or one is a product of others), where they are too many, or where q is
    in one of several.
    """
    leading = loop.leading
    delayed = [turns for turns in leading if any(turns)]
    units = {i for turns in delayed for i, n in enumerate(turns) if n}
    if len(units) > 1 and any(loop.symbol in loop.ring.lags[i].free_symbols for i in units):
        raise UndecidedError(
            "where a chain of roots comes to the axis: its delays are no multiples of one"
        )
    if not any(any(row[1:]) for row in leading.values()):
        return ()
    if _is_product(leading):
        return tuple(Meeting(x) for x in zeros(next(iter(leading.values()))))
    if len(delayed) > _MOST_DELAYED or Matrix(delayed).rank() < len(delayed):
        raise UndecidedError(
            "where a chain of roots comes to the axis: several delays are in the highest power of s"
        )
    undelayed = leading.get((0,) * len(loop.ring.lags), [Integer(0)])
    found = list[RealNumber]()
    # Which signs the coefficients have changes with q: all choices of them are tried.
    for signs in product((1, -1), repeat=len(delayed)):
        signed = [[sign * c for c in leading[x]] for sign, x in zip(signs, delayed, strict=True)]
        found += zeros(_sum([undelayed, *signed]))
    return tuple(Meeting(x) for x in found)


def _is_product(leading: Mapping[tuple[int, ...], Row]) -> bool:
    """Whether L = c(q) A(z): its zeros are the same for all q, and all of them are lost where c is
    0."""
    first, *others = leading.values()
    # All rows are multiples of the first where all minors of two rows and columns are 0.
    places = list(combinations(range(len(first)), 2))
    return not any(
        sign_of_number(first[i] * row[k] - first[k] * row[i]) for row in others for i, k in places
    )


def _sum(rows: list[Row]) -> Row:
    longest = max(map(len, rows))
    return [sum((row[i] for row in rows if i < len(row)), Integer(0)) for i in range(longest)]


def clear_of_chains(
    loop: Loop, far_out: Sequence[Meeting]
) -> list[tuple[RealNumber | None, RealNumber | None]]:
    """The intervals of q, between values of ``far_out``, in which no chain of roots lies on the
    right or comes to the axis.

    One count in each tells: a chain moves over the axis only at one of these values.
    """
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    inside = [x.value for x in far_out if _is_between(x.value, low, high)]
    found = pairwise([low, *each_once(inside, lambda x: x), high])
    return [(a, b) for a, b in found if loop.at(loop.between(a, b)).chain is None]


# Phase of the delay, rad, up to which roots are looked for beside a chain: first the nearer one.
_RADIANS = 40, 120
# How often an interval of values beside a chain is halved.
_HALVINGS = 40
# Frequencies that are tried for a bound, each higher by a quarter: as 1.25^32 is about 1260, they
# reach from 1/1024 of the highest one to beyond it.
_STEPS = 32
_BITS = 192


@dataclass(frozen=True)
class BesideChains:
    """A neutral loop A + B exp(-s tau) for q between two values at which a chain of roots comes to
    the axis: all critical values.

    As q nears such a value roots meet the axis at ever higher frequencies. But none does beyond a
    frequency from which on |A|^2 - |B|^2 > 0, a polynomial in omega^2 whose coefficients, by
    falling powers, are ``rows`` of powers of q. Also where the first of them vanishes, as it does
    at the end itself, the next ones may prove that. ``lag`` : tau.

    ``meetings`` yields the critical values, and as ``open`` the intervals for which no bound was
    found. ``of`` returns None for a loop of another form.
    """

    rows: Sequence[Row]
    lag: Expr

    @classmethod
    def of(cls, loop: Loop) -> BesideChains | None:
        """The loop in this form; None where it has another one."""
        turns = {x for group in loop.table.values() for x in group if any(x)}
        late = late_turns(turns, [*loop.table])
        if late is None or not any(not any(x) for x in loop.leading):
            return None
        return cls(squares(loop.table, late), lag_of(late, loop))

    def meetings(
        self, curve: CrossingCurve, low: RealNumber, high: RealNumber | None
    ) -> Iterator[CriticalValues]:
        """All critical values between two, between which no chain is on the right nor at the axis.

        Each yield replaces the one before: its open intervals are no larger.
        """
        for turning in _RADIANS:
            last = Rational(turning) / Rational(str(float(self.lag)))
            pieces = [*self._pieces(low, high, last, _HALVINGS)]
            known = [radius for _, _, radius in pieces if radius is not None]
            runs = [
                list(run) for is_open, run in groupby(pieces, lambda x: x[2] is None) if is_open
            ]
            gaps = [Open(run[0][0], run[-1][1], ENDLESS) for run in runs]
            yield CriticalValues(curve.meetings(max(known)) if known else (), gaps)
            if not gaps:
                return

    def _pieces(
        self, low: RealNumber, high: RealNumber | None, last: Rational, depth: int
    ) -> Iterator[tuple[RealNumber, RealNumber | None, Rational | None]]:
        """Intervals that fill the one between two values, each with the frequency beyond which no
        root meets the axis; None where none was found."""
        radius = self._radius(low, high, last)
        middle = ExactNumber(
            2 * rational_between(low, None) if high is None else rational_between(low, high)
        )
        # An interval of which no single value has a bound will have none in its parts either.
        if (
            radius is not None
            or not depth
            or not any(x and self._radius(x, x, last) for x in (low, middle, high))
        ):
            yield low, high, radius
            return
        yield from self._pieces(low, middle, last, depth - 1)
        yield from self._pieces(middle, high, last, depth - 1)

    def _radius(self, low: RealNumber, high: RealNumber | None, last: Rational) -> Rational | None:
        """A frequency, at most ``last``, beyond which |A|^2 - |B|^2 > 0 for all values between two;
        None where none is shown.

        Without an upper end the polynomial is taken over a power of q, as one in 1/q.
        """
        with flint.ctx.workprec(_BITS):
            a, inverse = low.ball(_BITS), high is None
            if inverse and not a > 0:
                return None
            q = (1 / a).union(arb(0)) if high is None else a.union(high.ball(_BITS))
            lowest = [
                _horner(_balls(row[::-1] if inverse else row), q)[0].lower() for row in self.rows
            ]
            # P/omega^(2n) >= w0 + w1 x + ..., x = omega^-2. No chain is on the right, so w0 >= 0;
            # with w2 and all further ones <= 0 that bound over x falls as x grows, whatever w1
            # is: where it is positive it is so at all higher frequencies, and bisection finds it.
            weights = arb_poly(
                [lowest[0].max(arb(0)), *lowest[1:2], *(x.min(arb(0)) for x in lowest[2:])]
            )
            start = expression_ball(last) / 1024
            first = bisect_left(
                range(_STEPS), 1, key=lambda i: weights((start * arb(1.25) ** i) ** -2) > 0
            )
        return None if first == _STEPS else last / 1024 * Rational(5, 4) ** first


# Turns of a delay that are listed beyond the value that it has.
_FURTHER = 8
# Critical delays that are listed at most to come to where there are roots on the right for ever.
_MOST_FURTHER = 300


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """A delay, s, for which A + B exp(-j omega tau) vanishes at a frequency where |A| = |B|:
    ``turn`` turns after the first.

    ``ratio`` : real and imaginary part of -A/B. ``multiple`` : how often the delay is in the
    exponent. ``is_real`` : whether -A/B is a real number there, and so 1 or -1: then its imaginary
    part is taken to be 0, as a ball about it reaches over the cut of the argument.
    """

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber
    turn: int
    multiple: Expr
    is_real: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            x = self.omega.ball(bits)
            real, imag = (part.ball(x) for part in self.ratio)
            angle = -acb(real, 0 if self.is_real else imag).arg()  # exp(-j omega tau) = -A/B
            return (angle + 2 * arb.pi() * self.turn) / (x * expression_ball(self.multiple))


@dataclass(frozen=True)
class Switches:
    """A loop A(s) + B(s) exp(-s tau) whose open number is the delay tau: the critical delays.

    Roots are on the axis where |A| = |B|, at few frequencies omega that do not depend on tau, and
    from each of them once in 2 pi/omega seconds. At a frequency where |A/B| grows through 1 a pair
    goes to the right, at each such delay, and to the left where it falls (Cooke and van den
    Driessche, 1986). Beyond the highest of them |A| > |B|, so that there |A/B| grows: pairs go to
    the right more often than to the left, and from some delay on the loop is never stable.

    ``firsts`` : the first delay >= 0 of each frequency. ``senses`` : 1 where |A/B| grows, -1 where
    it falls, 0 where it touches 1. ``is_still`` : whether |A| and |B| differ at omega = 0; else
    roots may also come through s = 0, and no senses are told. ``of`` raises UndecidedError for
    another form, or where |A| and |B| are alike at ever higher frequencies.
    """

    firsts: tuple[DelayAt, ...]
    senses: tuple[int, ...]
    is_still: bool

    @classmethod
    def of(cls, loop: Loop) -> Switches:
        """The switches of a loop with an open delay and without a chain of roots on the right.

        UndecidedError where it has another form.
        """
        ratio, multiple = _ratio(loop)
        condition = minus(squared_modulus(ratio).function, Integer(1))
        settled = asymptotic_sign(condition)
        if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            raise UndecidedError("where roots meet the imaginary axis")
        response = on_axis(ratio)
        functions = {"": RealFunction(condition.reduced()), "imag": response.imag}
        table = chart(functions, Integer(0), max(settled.radius, Integer(1)))
        if any("" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
        first, *points = table.points
        found = [x for x in points if x.orders.get("", 0) > 0]
        real = [response.imag.is_zero or x.orders.get("imag", 0) > 0 for x in found]
        parts = response.real, response.imag
        each = (
            DelayAt(parts, x.omega, 0, multiple, is_real=y)
            for x, y in zip(found, real, strict=True)
        )
        senses = tuple((x.after[""] - x.before[""]) // 2 for x in found)
        return cls(tuple(map(_first, each)), senses, first.orders.get("", 0) <= 0)

    def up_to(self, value: Expr) -> tuple[tuple[Meeting, ...], Rational | None]:
        """All critical delays >= 0 up to some turns beyond a value, and up to which delay these are
        all (None: everywhere)."""
        if not self.firsts:
            return (), None
        end = self._end(value)
        found = tuple(
            x
            for first, sense in self._each
            for x in _turned(first, _turns(first, end), sense if self.is_still else None)
        )
        # The first delay that is not listed is at least (2 n + 1) pi/omega, n turns being listed,
        # as the angle of the first is above -pi; 3.14 < pi keeps the bound on the safe side.
        last = min((2 * _turns(x, end) - 1) * 3.14 / _rate(x) for x in self.firsts)
        return found, Rational(last).limit_denominator(10**9)

    def _end(self, value: Expr) -> float:
        """Up to where delays are listed: as far as there are roots on the right for all further
        ones, if that is not too many; else up to the value."""
        last = self.unstable_from
        if last is None:
            return float(value)
        many = sum(float(last) * _rate(x) / 6.28 for x in self.firsts)
        return max(float(value), float(last)) if many < _MOST_FURTHER else float(value)

    @cached_property
    def unstable_from(self) -> Rational | None:
        """A delay from which on there are roots on the right for all delays; None where that is not
        shown.

        From a frequency whose delays begin at theta/omega, theta from 0 to 2 pi, at least (omega
        tau - theta)/(2 pi) pairs have crossed at tau, and at most one more. So the number of pairs
        on the right is positive where sum(sense omega) tau exceeds sum(sense theta), and 2 pi more
        for each frequency from which pairs go to the left. Those that are there at tau = 0 are not
        counted, which is on the safe side.
        """
        if not self.is_still:
            return None
        with flint.ctx.workprec(_BITS):
            slope, lost = arb(0), arb(0)
            for first, sense in self._each:
                rate = first.omega.ball(_BITS) * expression_ball(first.multiple)
                slope += sense * rate
                lost += sense * _beginning(first.ball(_BITS) * rate) + (
                    2 * arb.pi() if sense < 0 else 0
                )
            if not slope > 0:
                return None
            # Upward, by more than what a float in decimal digits can lose.
            return Rational(str(float((lost / slope).upper()) * (1 + 1e-9))) + Rational(1, 10**12)

    @property
    def _each(self) -> list[tuple[DelayAt, int]]:
        return [*zip(self.firsts, self.senses, strict=True)]


def _first(x: DelayAt) -> DelayAt:
    """The first delay >= 0 of a frequency: the argument from -pi to pi, or one turn more."""
    return replace(x, turn=1) if x.ball(_BITS) < 0 else x


def _beginning(angle: Ball) -> Ball:
    """The angle theta of a frequency's first delay > 0; all from 0 to 2 pi where a ball reaches to
    0."""
    return angle if angle > 0 else arb(0).union(2 * arb.pi())


def _rate(x: DelayAt) -> float:
    return float(x.omega) * float(x.multiple)


def _turns(x: DelayAt, end: float) -> int:
    """How many turns are listed, up to a delay and some further; 6.28 < 2 pi, so rather one
    more."""
    return int(_rate(x) * end / 6.28) + _FURTHER


def _turned(first: DelayAt, turns: int, sense: int | None) -> Iterator[Meeting]:
    """The critical delays of one frequency, from its first one on."""
    for turn in range(turns + 1):
        delay = replace(first, turn=first.turn + turn)
        # A delay of 0 is the end of what it may be: a root there is on the axis, but crosses
        # nothing.
        if delay.ball(_BITS).is_zero():
            yield Meeting(ExactNumber(Integer(0)), omega=first.omega)
        elif float(delay) > 0:
            yield Meeting(delay, omega=first.omega, sense=sense)


def _ratio(loop: Loop) -> tuple[RationalFunction, Expr]:
    """-A/B, and how often the open delay is in the exponent. UndecidedError for another form."""
    ring, symbol = loop.ring, loop.symbol
    units = [i for i, lag in enumerate(ring.lags) if symbol in lag.free_symbols]
    if len(units) != 1 or any(symbol in x.free_symbols for x in ring.orders):
        raise UndecidedError("a number that is in several delays")
    rows = coefficients(loop.top, ring.size + units[0])
    late = [n for n, row in enumerate(rows) if n and row]
    if len(late) != 1:
        raise UndecidedError("a delay that comes back several times")
    multiple = late[0] * ring.lags[units[0]] / symbol
    if multiple.free_symbols or degree_in([loop.top], ring.meanings.index(symbol)):
        raise UndecidedError("a delay that comes back several times")
    plain = [ring.expression(x) for x in (rows[0], rows[-1])]
    # In a ring without the open delay, of which A and B hold nothing.
    target = Ring.of(plain)
    above, below = map(target.convert, plain)
    return (-above / below).reduced(), multiple


# Phase of a delay, rad, at the frequency below which roots cross either way: where it is larger
# there are too many of them to be found one by one.
_MOST_TURNING = 400


@dataclass(frozen=True)
class _Settled:
    """A loop A + q B in which the phase of g = -A/B has one ``sense`` beyond a frequency.

    ``rate`` : a function of the sign of that phase's slope. ``curve`` : of the loop. ``known`` :
    all values with roots on the axis below that frequency, at 0 or at infinity.
    """

    sense: int
    rate: RationalFunction
    curve: CrossingCurve
    known: tuple[RealNumber, ...]


@dataclass(frozen=True)
class Tendency:
    """Whether a loop has roots in Re s >= 0 for all values of an interval, however many of these
    are critical.

    Roots of A + q B cross the axis at q = g(j omega), g = -A/B. As q > 0 grows they go to the right
    where the phase of g grows with omega, and to the left where it falls: the root tendency. With
    delays, one of the two holds beyond some frequency. In an interval without a value that puts
    roots on the axis below it, roots then cross one way alone: if some are on the right at the end
    from which they only join, some are there for all values. (Of a delay: ``Switches``.)

    ``everywhere`` returns True where that is proven; False proves nothing.
    """

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether each value from one to another is proven to have a root in Re s >= 0; an end that
        is None is endless."""
        with suppress(UndecidedError):
            return self._of_a_delay(low) if self.loop.turns else self._from_an_end(low, high)
        return False

    def _of_a_delay(self, low: RealNumber | None) -> bool:
        """The verdict of ``everywhere`` for a delay: from one on there are roots for ever."""
        last = Switches.of(self.loop).unstable_from
        return low is not None and last is not None and ordered(ExactNumber(last), low) >= 0

    def _from_an_end(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """The verdict of ``everywhere`` for a loop A + q B: from the end on at which roots lie on
        the right already, roots cross to the right alone."""
        # At q < 0 the phase of g is pi, and Im g falls where it grows: the sense is reversed. An
        # interval with values on both sides of 0 has neither.
        side = 0
        if low is not None and float(low) >= 0:
            side = 1
        elif high is not None and float(high) <= 0:
            side = -1
        if not side or self._settled is None:
            return False
        settled = self._settled
        if any(_is_between(x, low, high) for x in settled.known):
            return False
        start = low if side * settled.sense > 0 else high
        return start is not None and self._has_some_beyond(start, settled)

    @cached_property
    def _settled(self) -> _Settled | None:
        """The loop with the sense beyond a frequency; None where the phase goes both ways for ever,
        or up to a frequency to which delays turn very often."""
        if (
            len(self.loop.powers) != 2
            or (curve := curve_of(self.loop)) is None
            or curve.condition.is_zero
        ):
            return None
        rate = _turning_of(curve)
        found = asymptotic_sign(rate)
        if found.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
            return None
        if any(float(found.radius * lag) > _MOST_TURNING for lag in self.loop.ring.lags):
            return None
        near = curve.meetings(max(found.radius, Integer(1)))
        known = (
            *Characteristic(self.loop).at_0(),
            *(x.value for x in (*near, *from_infinity(self.loop))),
        )
        return _Settled(found.sense.value, rate, curve, known)

    def _has_some_beyond(self, start: RealNumber, settled: _Settled) -> bool:
        """Whether roots lie on the right next to an end, inside of the interval in which others can
        only join them.

        At a rational end they are counted. Of another one it is known that it puts a pair on the
        axis: that pair goes to the right if the phase has that sense at its frequency too.
        """
        if isinstance(start, ExactNumber) and isinstance(start.value, Rational):
            return bool(self.loop.at(start.value).right)
        if not isinstance(start, ValueAt):
            return False
        with flint.ctx.workprec(ALIKE_BITS):
            omega, curve = start.omega.ball(ALIKE_BITS), settled.curve
            rate, value, condition = (
                RealFunction(f).ball(omega) for f in (settled.rate, curve.value, curve.condition)
            )
            # Balls that contain 0 prove no root, but rule out a value of another curve's.
            is_on_curve = value.overlaps(start.ball(ALIKE_BITS)) and condition.contains(0)
            return bool(is_on_curve and settled.sense * rate > 0)


def _turning_of(curve: CrossingCurve) -> RationalFunction:
    """The slope of the phase of g along omega, times something positive."""
    # g = u - j v has the phase -atan(v/u), of which the slope is (u' v - u v')/(u^2 + v^2); over
    # the same square the slopes of the denominators cancel.
    u, v = curve.value, curve.condition
    axis = RealFunction(u).axis
    turned = [
        axis.derivative(x.numerator) * axis.function(y.numerator) for x, y in ((u, v), (v, u))
    ]
    return turned[0] - turned[1]


def _is_between(x: RealNumber, low: RealNumber | None, high: RealNumber | None) -> bool:
    """Whether a number lies strictly between two others; None: without end."""
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)
