"""A display in a hand with one number left open, and where on its way roots meet the imaginary axis: the functions.

A display in a hand with one number left open: its characteristic function C(s; q), and where on its way C meets the axis.

How far out roots of a loop can meet the imaginary axis, for all values of its open number in an interval at once: in balls.

With one delayed product, A(s; q) + B(s; q) exp(-s tau), they do where |A|^2 - |B|^2, a polynomial in omega^2, vanishes: nowhere
beyond a frequency from which on its first terms outweigh all others, and so also where the first is lost but the second is
positive, as at the value at which a chain of roots comes to the axis from its left. With several, |L| has a least value
where all |exp(-s tau)| <= 1, and no root lies in Re s >= 0 from where the highest power of s, times that, outweighs all others.

Pairs of a frequency and a value of the open number at which a loop has a root on the imaginary axis: proven by Newton's step.

f(omega, q) = C(j omega; q), each term c(q) exp(p(q) log(j omega) - j omega lag(q)), is 0 in real and imaginary part. Where the
step of a box of both, in balls, stays inside the box, there is one pair in it and no other.

The curve on which one open number puts roots on the imaginary axis: over frequency, the value that does it.

C(s; q) = A + q B is real on the axis where q = -Re(A/B) and Im(A/B) = 0: one equation in omega. Of a higher degree in q, real and
imaginary part have a root q in common where their resultant vanishes; their last remainder before it, linear in q, tells it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import comb, perm
from typing import Any

import flint
from flint import acb, arb, fmpq
from sympy import Expr, Integer, Poly, Rational, Symbol, factorial

from haptisym.judge.passivity import rests
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.axis import Axis
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis, squared_modulus
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Sense, far
from haptisym.kernel.reals import Ball, ExactNumber, Negative, RealNumber, expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in, monomials, omega
from haptisym.kernel.rootcount import Roots, Row, late_turns, squares, terms_of
from haptisym.kernel.roots import Point, chart, ordered, sign_of_number
from haptisym.model.catalogue import Hand
from haptisym.model.parameters import Rule, values
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.stability.held import zeros_of

ALLOWED: dict[Rule, tuple[Expr | None, Expr | None, bool]] = {
    Rule.POSITIVE: (Integer(0), None, False),
    Rule.NONNEGATIVE: (Integer(0), None, True),
    Rule.ANY: (None, None, True),
    Rule.FRACTION: (Integer(0), Integer(1), False),
}
"""The values that a rule allows, and whether its ends belong to them."""


@dataclass(frozen=True)
class Loop:
    """The characteristic function of a display in a hand, over the denominator of H_perc; ``symbol`` stays open in both.

    ``low``, ``high`` : between which values it may be, None where nothing bounds them. ``rests`` : whether with all > 0
    there are no roots in Re s >= 0 but at 0, as a hand that damps holds parts that only take energy.
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
        low, high, _ = ALLOWED[free.rule]
        damps = hand.b.symbol == free.symbol or sign_of_number(hand.b.value) > 0
        return cls(
            ring, top, H.denominator, free.symbol, low, high, low is not None and damps and rests(scene, display)
        )

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

    def at(self, value: Rational) -> Roots:
        """The roots in Re s >= 0 at a number."""
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
        return zeros_of(found.numerator, found.denominator, self.ring, rests=self.rests and value > 0)

    def exists(self, value: Rational) -> bool:
        """Whether there is a dynamics at a number: not where it is divided by 0."""
        if self.turns or self.symbol not in self.ring.meanings:
            return True
        return not self.bottom.subs({f"x{self._index}": fmpq(int(value.p), int(value.q))}).is_zero()

    @cached_property
    def table(self) -> dict[Rational, dict[tuple[int, ...], Row]]:
        """By the power of s and by how often each unit delay is in it, by ascending powers of the open number."""
        found = [terms_of(p, self.ring) if p else {} for p in self.powers]
        table: dict[Rational, dict[tuple[int, ...], Row]] = {}
        for i, terms in enumerate(found):
            for power, group in terms.items():
                for turns, c in group.items():
                    table.setdefault(power, {}).setdefault(turns, [Integer(0)] * len(found))[i] = c
        return table

    @property
    def leading(self) -> dict[tuple[int, ...], Row]:
        """Of the table, the highest power of s; UndecidedError where an open order leaves that open."""
        if not any(self.symbol in x.free_symbols for x in self.ring.orders):
            return self.table[max(self.table)]
        ends = [{self.symbol: x} for x in (self.low, self.high) if x is not None]
        for (
            power,
            group,
        ) in self.table.items():  # a power is linear in an order: it is the highest between two ends as at both
            ahead = [[(power - x).xreplace(end) for end in ends] for x in self.table if x != power]
            if len(ends) == 2 and all(min(row) >= 0 and max(row) > 0 for row in ahead):
                return group
        raise UndecidedError("where roots meet the imaginary axis as a power of s changes")


def _mapped(polynomial: Polynomial, images: Sequence[RationalFunction]) -> RationalFunction:
    """A polynomial with other functions for its variables; SymPy would make one delay of a product of two."""
    total = images[0].ring.zero
    for exponents, value in monomials(polynomial):
        term = total.ring.function(total.ring.context.constant(value))
        for image, n in zip(images, exponents, strict=True):
            term = term * image ** int(n)
        total = total + term
    return total


def zeros(row: Sequence[Expr]) -> list[RealNumber]:
    """The zeros >= 0 of a polynomial with ascending coefficients; those of a linear one whatever their sign."""
    while row and row[-1] == 0:
        row = row[:-1]
    if len(row) < 2:
        return []
    if len(row) == 2:
        return [ExactNumber(-row[0] / row[1])]
    ring = Ring().axis
    f = RealFunction(ring.convert(sum((c * omega**n for n, c in enumerate(row)), Integer(0))))
    with flint.ctx.workprec(128):
        bound = max(abs(expression_ball(c / row[-1])).upper() for c in row[:-1]) + 1
    table = chart({"": f}, Integer(0), Integer(int(bound.ceil().unique_fmpz())))
    return [x.omega for x in table.points if x.orders.get("")]


def coefficients(polynomial: Polynomial, index: int | None) -> list[Polynomial]:
    """By ascending powers of one variable; one alone where there is none."""
    if index is None:
        return [polynomial]
    rows: list[dict[tuple[int, ...], object]] = [{} for _ in range(degree_in([polynomial], index) + 1)]
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        rows[power][tuple(own)] = value
    context = polynomial.context()
    return [context.from_dict(row) for row in rows]


_BITS = 192
_STEP = Rational(5, 4)
_ARCS = 64


@dataclass(frozen=True)
class Reach(ABC):
    """Beyond which frequency no root meets the axis; ``longest``: the longest delay, s."""

    longest: Expr

    def radius(self, q: Ball, turning: int, *, inverse: bool) -> Rational | None:
        """For all values in a ball; None where delays turn further than that up to it. ``inverse``: for 1/q in the ball.

        Guaranteed where there is no chain of roots on the right, or on the axis but at the ends of the ball.
        """
        with flint.ctx.workprec(_BITS):
            weights = self._weights(q, inverse=inverse)
            if weights is None:
                return None
            last = Rational(turning) / Rational(str(float(self.longest)))
            at = last / 1024
            while at <= last:
                if self._prevails(expression_ball(at), weights):
                    return at
                at *= _STEP
        return None

    @abstractmethod
    def _weights(self, q: Ball, *, inverse: bool) -> Any:
        """What does not depend on the frequency; None where it proves nothing."""

    @abstractmethod
    def _prevails(self, at: Ball, weights: Any) -> bool:
        """Whether no root meets the axis there and beyond."""


def reach_of(loop: Loop) -> Reach:
    """The bound for a loop, by the sharper way where it goes."""
    turns = {x for group in loop.table.values() for x in group if any(x)}
    longest = max((lag_of(x, loop) for x in turns), default=Integer(1))
    late = late_turns(turns, [*loop.table])
    if late is not None and any(not any(x) for x in loop.leading):
        return _Squares(longest, squares(loop.table, late))
    return _sums(loop, turns, longest)


def reach_of_axis(loop: Loop) -> Reach:
    """The bound for roots on the axis itself, guaranteed whether or not there is a chain on the right."""
    turns = {x for group in loop.table.values() for x in group if any(x)}
    return _sums(loop, turns, max((lag_of(x, loop) for x in turns), default=Integer(1)))


def _sums(loop: Loop, turns: set[tuple[int, ...]], longest: Expr) -> Reach:
    units = {i for x in turns for i, n in enumerate(x) if n}
    return _Sums(longest, loop.table, units.pop() if len(units) == 1 else None)


def lag_of(turns: Sequence[int], loop: Loop) -> Expr:
    """How late a product of unit delays is, s."""
    return sum((n * x for n, x in zip(turns, loop.ring.lags, strict=True)), Integer(0))


def _value(row: Row, q: Ball, *, inverse: bool) -> Ball:
    """Of a polynomial in the open number; ``inverse``: times q^-n, n being the length of all rows less 1, at 1/q."""
    total = arb(0)
    for c in row if inverse else reversed(row):
        total = total * q + expression_ball(c)
    return total


@dataclass(frozen=True)
class _Squares(Reach):
    """``rows`` : of |A|^2 - |B|^2 by falling powers of omega^2."""

    rows: Sequence[Row]

    def _weights(self, q: Ball, *, inverse: bool) -> Sequence[Ball]:
        """Lower bounds of the coefficients; the first is not negative where no chain lies on the right."""
        first, *others = (_value(row, q, inverse=inverse).lower() for row in self.rows)
        return [first.max(arb(0)), *others[:1], *(x.min(arb(0)) for x in others[1:])]

    def _prevails(self, at: Ball, weights: Sequence[Ball]) -> bool:
        total = weights[0] * at**2
        for i, weight in enumerate(weights[1:]):
            total += weight / at ** (2 * i)
        return bool(total > 0)


@dataclass(frozen=True)
class _Sums(Reach):
    """``table`` : as that of the loop. ``unit`` : the one unit delay, where there is one."""

    table: Mapping[Rational, Mapping[tuple[int, ...], Row]]
    unit: int | None

    def _weights(self, q: Ball, *, inverse: bool) -> Mapping[Rational, Ball] | None:
        """The least |L|, and of the lower powers how much they may be, negative, by how much lower they are."""
        degree = max(self.table)
        leading = {turns: _value(row, q, inverse=inverse) for turns, row in self.table[degree].items()}
        floor = self._floor(leading)
        if floor is None:
            return None
        found = {Integer(0): floor}
        for p, group in self.table.items():
            if p < degree:
                found[p - degree] = -sum(
                    (abs(_value(row, q, inverse=inverse)).upper() for row in group.values()), arb(0)
                )
        return found

    def _floor(self, leading: Mapping[tuple[int, ...], Ball]) -> Ball | None:
        own = next((x for turns, x in leading.items() if not any(turns)), arb(0))
        margin = abs(own).lower() - sum((abs(x).upper() for turns, x in leading.items() if any(turns)), arb(0))
        if margin > 0:
            return margin.lower()
        return None if self.unit is None else _least_on_circle({t[self.unit]: x for t, x in leading.items()})

    def _prevails(self, at: Ball, weights: Mapping[Rational, Ball]) -> bool:
        return bool(sum((x * at ** expression_ball(p) for p, x in weights.items()), arb(0)) > 0)


def _least_on_circle(leading: Mapping[int, Ball]) -> Ball | None:
    """Of |L(z)| for |z| = 1, and so for |z| <= 1, as it has no zero there."""
    least = None
    for i in range(_ARCS):
        angle = arb(i, 0) / _ARCS + arb(0, 0.5 / _ARCS)
        z = (acb(0, 2) * arb.pi() * angle).exp()
        here = abs(sum((x * z**n for n, x in leading.items()), acb(0))).lower()
        least = here if least is None else least.min(here)
    return least if least is not None and least > 0 else None


_BITS_PAIRS = 128
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
        with flint.ctx.workprec(_BITS_PAIRS):
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


@dataclass(frozen=True)
class Meeting:
    """A ``value`` of the open number with roots on the axis at ``omega``, rad/s; None where they come from infinity.

    ``sense`` : how many pairs of roots go from its left to its right there as the number grows; None where that is not told.
    """

    value: RealNumber
    omega: RealNumber | None
    sense: int | None = None

    def is_like(self, other: Meeting) -> bool:
        """Whether both are alike as far as bits go."""
        if self.omega is None or other.omega is None:
            return self.omega is other.omega and not ordered(self.value, other.value)
        return not ordered(self.omega, other.omega) and not ordered(self.value, other.value)


@dataclass(frozen=True)
class Gap:
    """Values between two of which it is not known which ones put roots on the axis; None where nothing bounds them.

    ``reason`` : why; empty where they do at ever higher frequencies.
    """

    low: RealNumber | None
    high: RealNumber | None
    reason: str = ""

    def holds(self, low: RealNumber | None, high: RealNumber | None) -> bool:
        """Whether all values between two others are in it."""
        above = self.low is None or (low is not None and ordered(self.low, low) >= 0)
        return above and (self.high is None or (high is not None and ordered(high, self.high) >= 0))


@dataclass(frozen=True)
class Meetings:
    """All, each once, ``above`` one value and ``below`` another, but for ``gaps``; None where nothing bounds them there.

    Values with a chain of infinitely many roots on the right need not be among them, but for those where it comes or goes.
    """

    found: tuple[Meeting, ...]
    above: Expr | None = None
    below: Expr | None = None
    gaps: tuple[Gap, ...] = ()


@dataclass(frozen=True)
class Curve:
    """Frequencies where ``condition`` vanishes, and the ``value`` of the open number there: functions of omega, over squares.

    ``square`` : of that value, there. ``is_linear`` : whether C is A + q B, -A/B being value - j condition.
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
        places = [x for x in table.points[1:] if x.orders.get("0", 0) > 0 and x.orders.get("q", 0) >= 0]
        zero = ExactNumber(Integer(0))
        return tuple(
            Meeting(zero if x.orders.get("q") else ValueAt(value, x.omega), x.omega, self._sense(x)) for x in places
        )

    def _sense(self, place: Point) -> int | None:
        """To the right where -A/B, as omega grows, comes from below to above the real axis; a root that only touches it stays."""
        return (place.before["0"] - place.after["0"]) // 2 if self.is_linear else None


def minus(f: RationalFunction, number: Expr) -> RationalFunction:
    """A function less a number, over the same denominator."""
    shift = f.ring.convert(number)
    top = f.numerator * shift.denominator - shift.numerator * f.denominator
    return f.ring.function(top, f.denominator * shift.denominator)


def curve_of(loop: Loop) -> Curve | None:
    """Of values other than delays; None where the open number moves no root."""
    powers = loop.powers
    if len(powers) < 2:
        return None
    if len(powers) == 2:
        ratio = RationalFunction(loop.ring, powers[0], powers[1]).reduced()
        below = on_axis(ratio)
        curve = Curve(below.raw_imag, -below.raw_real, squared_modulus(ratio).function, is_linear=True)
    else:
        curve = _eliminated(loop)
    if not curve.condition.is_zero:
        return curve
    slope = (
        RealFunction(curve.value.reduced()).derivative().function
    )  # on the axis at all of its values: where these turn
    return Curve(
        slope.ring.function(slope.numerator * slope.denominator, slope.denominator**2), curve.value, curve.square
    )


def _eliminated(loop: Loop) -> Curve:
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
    return Curve(axis.function(resultant), axis.function(-c0 * c1, c1 * c1), axis.function(c0 * c0, c1 * c1))


def _is_apart(f: Polynomial, g: Polynomial, axis: Axis) -> bool:
    """Whether two polynomials are shown to have no zero > 0 in common: at one, more than one root would be."""
    shared = axis.function(f.gcd(g))
    settled = far(shared)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        return False
    table = chart({"": RealFunction(shared)}, Integer(0), max(settled.radius, Integer(1)))
    return not table.undecided and not any(x.orders.get("") for x in table.points[1:])


def _remainder(f: Polynomial, g: Polynomial, index: int) -> tuple[Polynomial, Polynomial] | None:
    """Of Euclid's algorithm in one variable, the remainder that is linear in it; None where there is none."""
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
