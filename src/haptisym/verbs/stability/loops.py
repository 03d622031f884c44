"""A display in a hand with one number left open: its characteristic function C(s; q), and where it
meets the imaginary axis.

Pairs of a frequency and a value with a root on the axis are proven by Newton's step: f(omega, q) =
C(j omega; q), each term c(q) exp(p(q) log(j omega) - j omega lag(q)), is 0 in real and imaginary
part. Where the step of a box of both, in balls, stays inside the box, there is one pair in it and
no other.

C = A + q B is real on the axis where q = -Re(A/B) and Im(A/B) = 0: one equation in omega. Of a
higher degree in q, real and imaginary part have a root q in common where their resultant vanishes;
their last remainder before it, linear in q, tells it.
A(s) + B(s) exp(-s tau) is 0 where |A| = |B|, again and again. At a frequency where |A/B| grows
through 1 roots go to the right, at every such delay, and to the left where it falls (Cooke and van
den Driessche, 1986). From each frequency omega they come once in 2 pi/omega seconds: the highest
one is one of the first kind, and so there are ever more roots on the right in the end.

Roots, or a chain of infinitely many, come from infinity where what multiplies the highest power of
s, L(z; q) with z = exp(-s tau), is lost or has a zero with |z| = 1. Which way roots cross the axis
as q > 0 grows is told by the phase of -A/B:
to the right where it grows with omega (the root tendency). Beyond some frequency delays make it one
of the two: then what meets the axis there only adds roots on the right, or only takes them away,
one infinitely long sequence after the other.
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
from sympy import Add, Expr, Integer, Poly, Rational, Symbol, factorial

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
    """The characteristic function of a display in a hand, over the denominator of H_perc;
    ``symbol`` stays open in both.

    ``low``, ``high`` : between which values it may be, None where nothing bounds them. ``rests`` :
    whether with all > 0 there are no roots in Re s >= 0 but at 0, as a hand that damps holds parts
    that only take energy.
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
        """With ``free`` left open: a number of the hand, or of the display."""
        display = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
        Z = hand.dynamics.xreplace(values(p for p in hand.parameters if p.symbol != free.symbol))
        ring = Ring.of([*display.entries(), Z])
        H = display.perceived(range(len(display.matrices)), ring)
        z = ring.convert(Z)
        top = H.numerator * z.denominator + z.numerator * H.denominator
        allowed = ALLOWED[free.rule]
        damps = hand.b.symbol == free.symbol or sign_of_number(hand.b.value) > 0
        is_at_rest = allowed.low is not None and damps and rests(scene, display)
        return cls(ring, top, H.denominator, free.symbol, allowed.low, allowed.high, is_at_rest)

    @cached_property
    def turns(self) -> bool:
        """Whether the open number is in a delay, or in a power of s."""
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
        found = RationalFunction(self.ring, self.top.subs(here), self.bottom.subs(here)).reduced()
        return zeros_of(
            found.numerator, found.denominator, self.ring, rests=self.rests and value > 0
        )

    def exists(self, value: Rational) -> bool:
        """Whether there is a dynamics at a number: not where it is divided by 0, nor where no force
        is left."""
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
        while not self.exists(found):
            found = rational_between(ExactNumber(found), high)
        return found

    @cached_property
    def table(self) -> dict[Rational, dict[tuple[int, ...], Row]]:
        """By the power of s and by how often each unit delay is in it, by ascending powers of the
        open number."""
        found = [terms_of(p, self.ring) if p else {} for p in self.powers]
        table: dict[Rational, dict[tuple[int, ...], Row]] = {}
        for i, terms in enumerate(found):
            for power, group in terms.items():
                for turns, c in group.items():
                    table.setdefault(power, {}).setdefault(turns, [Integer(0)] * len(found))[i] = c
        return table

    @property
    def leading(self) -> dict[tuple[int, ...], Row]:
        """Of the table, the highest power of s; UndecidedError where an open order leaves that
        open."""
        if not any(self.symbol in x.free_symbols for x in self.ring.orders):
            return self.table[max(self.table)]
        ends = [{self.symbol: x} for x in (self.low, self.high) if x is not None]
        for (
            power,
            group,
        ) in (
            self.table.items()
        ):  # a power is linear in an order: it is the highest between two ends as at both
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


def zeros(row: Sequence[Expr]) -> list[RealNumber]:
    """The real zeros of a polynomial with ascending coefficients."""
    polynomial = Add(*(c * _Q**n for n, c in enumerate(row)))
    ring = Ring.of([polynomial])
    if _Q not in ring.meanings:
        return []
    index = ring.meanings.index(_Q)
    factors = ring.convert(polynomial).numerator.factor()[1]
    return [x for factor, _ in factors for x in real_roots(factor, index, negative=True)]


def coefficients(polynomial: Polynomial, index: int | None) -> list[Polynomial]:
    """By ascending powers of one variable; one alone where there is none."""
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


_Q = Symbol("q", real=True)
_BITS_PAIRS = 128
_MOST_STEPS, _MORE = 64, 32
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
    """C on the imaginary axis and beside omega = 0, of a loop, over the power of s that all of its
    terms share."""

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
            wave = (log * p - acb(0, omega * lag)).exp()
            total += c * wave
            along += c * wave * acb(p / omega, -lag)
            across += wave * (dc + c * (log * dp - acb(0, omega * dlag)))
        return total, along, across

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """Of Newton from the middle of a box: where all pairs in it lie; None where that is not
        known."""
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
        with flint.ctx.workprec(_BITS_PAIRS):
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
        """n, and the value of C/s^n at 0, a polynomial in q; None where that is not known, as where
        a power is open."""
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
        return zeros(self._beginning[1].all_coeffs()[::-1])

    def is_clear_at_0(self, omega: Ball, q: Ball) -> bool:
        """Whether there is no pair with 0 < omega in a box that begins at 0: by Taylor's formula,
        from means of derivatives of C.

        C/s^n is one of that of order n, less its value at 0, which is real, j omega times one of
        that of order n + 1.
        """
        if not self._is_whole or self._beginning is None:
            return False
        with flint.ctx.workprec(_BITS_PAIRS):
            n = int(self._beginning[0])
            return any(not self._derivative(i, omega, q).real.contains(0) for i in (n, n + 1))

    def _derivative(self, n: int, omega: Ball, q: Ball) -> Ball:
        """Of C, of that order, along s."""
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
    """A polynomial and its slope."""
    value = slope = arb(0)
    for c in reversed(row):
        value, slope = value * q + c, slope * q + value
    return value, slope


class Stepped(Protocol):
    """What has Newton's step."""

    def step(self, omega: Ball, q: Ball) -> tuple[Ball, Ball] | None:
        """A box around all pairs in a box; None where that is not told."""


@dataclass(frozen=True, eq=False)
class Pair:
    """The one pair in a box."""

    form: Stepped
    omega: Ball
    q: Ball
    _known: dict[int, tuple[Ball, Ball]] = field(default_factory=dict)

    def at(self, bits: int) -> tuple[Ball, Ball]:
        """Frequency and value with about that many bits: by steps until they do not halve the box
        any more."""
        if bits not in self._known:
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
    """One side of a pair."""

    pair: Pair
    side: int

    def ball(self, bits: int) -> Ball:
        return self.pair.at(bits)[self.side]


@dataclass(frozen=True)
class Meeting(CriticalValue):
    """A value of the open number with roots on the axis at ``omega``, rad/s; None where they come
    from infinity.

    ``sense`` : how many pairs of roots go from its left to its right there as the number grows;
    None where that is not told.
    """

    omega: RealNumber | None = None
    sense: int | None = None


@dataclass(frozen=True)
class CrossingCurve:
    """Frequencies where ``condition`` vanishes, and the ``value`` of the open number there:
    functions of omega, over squares.

    ``square`` : of that value, there. ``is_linear`` : whether C is A + q B, -A/B being value - j
    condition.
    """

    condition: RationalFunction
    value: RationalFunction
    square: RationalFunction
    is_linear: bool = False

    def meetings(self, reach: Expr) -> tuple[Meeting, ...]:
        """All above 0 and up to a frequency; at 0 all is real, so that it tells nothing there."""
        value = RealFunction(self.value.reduced())
        table = chart({"0": RealFunction(self.condition.reduced()), "q": value}, Integer(0), reach)
        if any("0" in point.undecided for point in table.points):
            raise UndecidedError("whether a root touches the imaginary axis")
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
        """To the right where -A/B, as omega grows, comes from below to above the real axis; a root
        that only touches it stays."""
        return (place.before["0"] - place.after["0"]) // 2 if self.is_linear else None


def minus(f: RationalFunction, number: Expr) -> RationalFunction:
    """A function less a number, over the same denominator."""
    shift = f.ring.convert(number)
    top = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(top, f.denominator * shift.denominator)


def curve_of(loop: Loop) -> CrossingCurve | None:
    """Of values other than delays; None where the open number moves no root."""
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
    slope = (
        RealFunction(curve.value.reduced()).derivative().function
    )  # on the axis at all of its values: where these turn
    return CrossingCurve(
        slope.ring.function(slope.numerator * slope.denominator, slope.denominator**2),
        curve.value,
        curve.square,
    )


def _eliminated(loop: Loop) -> CrossingCurve:
    axis = loop.ring.axis
    [(real, imag)] = axis.parts([loop.top])
    index = axis.meanings.index(loop.symbol)
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
    """Whether two polynomials are shown to have no zero > 0 in common: at one, more than one root
    would be."""
    shared = axis.function(f.gcd(g))
    settled = asymptotic_sign(shared)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        return False
    table = chart({"": RealFunction(shared)}, Integer(0), max(settled.radius, Integer(1)))
    return not table.undecided and not any(x.orders.get("") for x in table.points[1:])


def _remainder(f: Polynomial, g: Polynomial, index: int) -> tuple[Polynomial, Polynomial] | None:
    """Of Euclid's algorithm in one variable, the remainder that is linear in it; None where there
    is none."""
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
        while len(a) >= len(b) and not f.is_zero():
            f = b[-1] * f - a[-1] * x ** (len(a) - len(b)) * g
            a = coefficients(f, index)
        if f.is_zero():
            return None
        f, g = g, f


ENDLESS = "where roots meet the imaginary axis at ever higher frequencies"
_MOST_DELAYED = 5


def from_infinity(loop: Loop) -> tuple[Meeting, ...]:
    """All values at which roots come from infinity, and perhaps others. UndecidedError where delays
    meet in another way."""
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
    if len(delayed) > (1 if len(units) == 1 else _MOST_DELAYED):
        raise UndecidedError(
            "where a chain of roots comes to the axis: several delays are in the highest power of s"
        )
    own = leading.get((0,) * len(loop.ring.lags), [Integer(0)])
    found = list[RealNumber]()
    for signs in product(
        (1, -1), repeat=len(delayed)
    ):  # |own| = sum of |delayed|, whatever their signs are
        found += zeros(
            _sum(
                [
                    own,
                    *(
                        [sign * c for c in leading[x]]
                        for sign, x in zip(signs, delayed, strict=True)
                    ),
                ]
            )
        )
    return tuple(Meeting(x) for x in found)


def _is_product(leading: Mapping[tuple[int, ...], Row]) -> bool:
    """Whether L = c(q) A(z): its zeros are the same for all q, and all of them are lost where c is
    0."""
    first, *others = leading.values()
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
    """Between which values, of those at which chains of roots come to the axis, there is none on
    the right or at the axis."""
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    inside = [x.value for x in far_out if _is_between(x.value, low, high)]
    found = pairwise([low, *each_once(inside, lambda x: x), high])
    return [(a, b) for a, b in found if loop.at(loop.between(a, b)).chain is None]


_RADIANS = 40, 120  # that the delay turns up to where roots are looked for beside a chain
_HALVINGS = 40  # of values beside a chain
_STEPS = 32  # of frequencies, each by a quarter higher than the one before it


@dataclass(frozen=True)
class BesideChains:
    """Of a loop A + B exp(-s tau), beyond which frequency no value of some puts roots on the axis.

    Where |A|^2 - |B|^2, a polynomial in omega^2 with these ``rows`` of coefficients, is positive:
    also where the first of them is lost, as at a value at which a chain comes to the axis. ``lag``
    : tau.
    """

    rows: Sequence[Row]
    lag: Expr

    @classmethod
    def of(cls, loop: Loop) -> BesideChains | None:
        """None of a loop of another form."""
        turns = {x for group in loop.table.values() for x in group if any(x)}
        late = late_turns(turns, [*loop.table])
        if late is None or not any(not any(x) for x in loop.leading):
            return None
        return cls(squares(loop.table, late), lag_of(late, loop))

    def meetings(
        self, curve: CrossingCurve, low: RealNumber, high: RealNumber | None
    ) -> Iterator[CriticalValues]:
        """All between two values, between which no chain is on the right nor at the axis, but for
        gaps, which become smaller."""
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
        radius = self._radius(low, high, last)
        middle = ExactNumber(
            2 * rational_between(low, None) if high is None else rational_between(low, high)
        )
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
        """For all values between two; without end of 1/q, over a power of q. It grows with omega,
        but for a power of it."""
        with flint.ctx.workprec(_BITS):
            a, inverse = low.ball(_BITS), high is None
            if inverse and not a > 0:
                return None
            q = (1 / a).union(arb(0)) if high is None else a.union(high.ball(_BITS))
            own = [
                _horner(_balls(row[::-1] if inverse else row), q)[0].lower() for row in self.rows
            ]
            weights = arb_poly([own[0].max(arb(0)), *own[1:2], *(x.min(arb(0)) for x in own[2:])])
            start = expression_ball(last) / 1024
            first = bisect_left(
                range(_STEPS), 1, key=lambda i: weights((start * arb(1.25) ** i) ** -2) > 0
            )
        return None if first == _STEPS else last / 1024 * Rational(5, 4) ** first


_FURTHER = 8  # turns of a delay beyond its value
_MOST_FURTHER = 300  # of all frequencies together, where that tells of all delays
_BITS = 192


@dataclass(frozen=True, repr=False)
class DelayAt(RealNumber):
    """The delay for which A + B exp(-j omega tau) vanishes at a frequency where both are of one
    size, and ``turn`` more turns.

    ``is_real`` : whether -A/B is a real number there, and so 1 or -1: balls around an angle of 0 or
    pi do not tell.
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
    """The first delays >= 0 at the frequencies where |A| = |B|, each with the sense in which |A/B|
    goes through 1 there.

    ``is_still`` : whether |A| and |B| differ at omega = 0.
    """

    firsts: tuple[DelayAt, ...]
    senses: tuple[int, ...]
    is_still: bool

    @classmethod
    def of(cls, loop: Loop) -> Switches:
        """Of a loop with an open delay and without a chain of roots on the right. UndecidedError
        where it has another form."""
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
        """All delays >= 0 up to some turns beyond a value, and up to which delay these are all;
        None where no others come."""
        if not self.firsts:
            return (), None
        end = self._end(value)
        found = tuple(
            x
            for first, sense in self._each
            for x in _turned(first, _turns(first, end), sense if self.is_still else None)
        )
        last = min((2 * _turns(x, end) - 1) * 3.14 / _rate(x) for x in self.firsts)
        return found, Rational(last).limit_denominator(10**9)

    def _end(self, value: Expr) -> float:
        """As far as all that comes after can be told, if that is not too far."""
        last = self.unstable_from
        if last is None:
            return float(value)
        many = sum(float(last) * _rate(x) / 6.28 for x in self.firsts)
        return max(float(value), float(last)) if many < _MOST_FURTHER else float(value)

    @cached_property
    def unstable_from(self) -> Rational | None:
        """A delay beyond which there are roots on the right for all delays; None where that is not
        shown.

        Of a frequency whose delays begin at theta/omega, theta from 0 to 2 pi, at least (omega tau
        - theta)/(2 pi) have come at tau, and at most one more. So there are roots where the sum of
        senses omega tau is beyond what is lost at the beginning.
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
            return Rational(str(float((lost / slope).upper()) * (1 + 1e-9))) + Rational(1, 10**12)

    @property
    def _each(self) -> list[tuple[DelayAt, int]]:
        return [*zip(self.firsts, self.senses, strict=True)]


def _first(x: DelayAt) -> DelayAt:
    """Without a turn, or one turn later where that is negative."""
    return replace(x, turn=1) if x.ball(_BITS) < 0 else x


def _beginning(angle: Ball) -> Ball:
    """Of a frequency, the angle > 0 of the first delay that is one; all up to 2 pi where a ball
    does not tell."""
    return angle if angle > 0 else arb(0).union(2 * arb.pi())


def _rate(x: DelayAt) -> float:
    return float(x.omega) * float(x.multiple)


def _turns(x: DelayAt, end: float) -> int:
    return int(_rate(x) * end / 6.28) + _FURTHER


def _turned(first: DelayAt, turns: int, sense: int | None) -> Iterator[Meeting]:
    """Of one frequency, from its first delay on."""
    for turn in range(turns + 1):
        delay = replace(first, turn=first.turn + turn)
        if delay.ball(_BITS).is_zero():
            yield Meeting(ExactNumber(Integer(0)), omega=first.omega)
        elif float(delay) > 0:
            yield Meeting(delay, omega=first.omega, sense=sense)


def _ratio(loop: Loop) -> tuple[RationalFunction, Expr]:
    """-A/B and how often the open delay is in the exponent."""
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
    target = Ring.of(plain)
    above, below = map(target.convert, plain)
    return (-above / below).reduced(), multiple


_MOST_TURNING = 400  # radians that a delay turns up to where roots cross either way


@dataclass(frozen=True)
class _Settled:
    """The ``sense`` of the ``rate`` of g's phase beyond a frequency.

    ``curve`` : of the loop. ``known`` : all values with roots on the axis below that frequency, or
    at infinity.
    """

    sense: int
    rate: RationalFunction
    curve: CrossingCurve
    known: tuple[RealNumber, ...]


@dataclass(frozen=True)
class Tendency:
    """Of a loop and its open number."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether each value from one to another is proven to have a root in Re s >= 0; an end that
        is None is endless."""
        with suppress(UndecidedError):
            return self._of_a_delay(low) if self.loop.turns else self._from_an_end(low, high)
        return False

    def _of_a_delay(self, low: RealNumber | None) -> bool:
        last = Switches.of(self.loop).unstable_from
        return low is not None and last is not None and ordered(ExactNumber(last), low) >= 0

    def _from_an_end(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """From the end on at which roots lie on the right already, if from there on they cross to
        the right alone."""
        side = (
            1
            if low is not None and float(low) >= 0
            else -1
            if high is not None and float(high) <= 0
            else 0
        )
        if not side or self._settled is None:
            return False
        found = self._settled
        if any(_is_between(x, low, high) for x in found.known):
            return False
        start = low if side * found.sense > 0 else high
        return start is not None and self._has_some_beyond(start, found)

    @cached_property
    def _settled(self) -> _Settled | None:
        """None where the phase goes both ways for ever, or up to a frequency to which delays turn
        very often."""
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

    def _has_some_beyond(self, start: RealNumber, found: _Settled) -> bool:
        """Whether roots lie on the right beside a value, on the side to which others can only join
        them."""
        if isinstance(start, ExactNumber) and isinstance(start.value, Rational):
            return bool(self.loop.at(start.value).right)
        if not isinstance(start, ValueAt):
            return False
        with flint.ctx.workprec(
            ALIKE_BITS
        ):  # those on the axis itself, if it is there that the value puts them
            omega, curve = start.omega.ball(ALIKE_BITS), found.curve
            rate, own, zero = (
                RealFunction(f).ball(omega) for f in (found.rate, curve.value, curve.condition)
            )
            return bool(
                own.overlaps(start.ball(ALIKE_BITS)) and zero.contains(0) and found.sense * rate > 0
            )


def _turning_of(curve: CrossingCurve) -> RationalFunction:
    """Of the phase of g over frequency, times something positive."""
    u, v = curve.value, curve.condition  # g is u - j v, both over the same square
    axis = RealFunction(u).axis
    turned = [
        axis.derivative(x.numerator) * axis.function(y.numerator) for x, y in ((u, v), (v, u))
    ]
    return turned[0] - turned[1]


def _is_between(x: RealNumber, low: RealNumber | None, high: RealNumber | None) -> bool:
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)
