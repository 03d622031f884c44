"""A sampled loop with one number left open: for which values of it a root is on the unit circle.

In v, z = (1 + v)/(1 - v), the circle is the imaginary axis. There is no root at z = 1 where B(1)
Q(0) + A(1) N(0) is not 0, D = A/B and G = N/Q: a polynomial in the number, whose zeros are found by
themselves. There is none at z = -1 where the highest coefficient in v is not 0, and no pair where a
determinant of Hurwitz is not. A stretch of values is *clear* where both are proven not to be 0 for
any of its values, in balls: it is cut until it is, or until each of the two is 0 once at most. Then
the signs at its ends tell which one is, and two counts whether what adds up to 0 is a pair on the
circle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flint
from flint import acb_poly, arb
from sympy import Add, Expr, Integer, Poly, PolynomialError, Rational, Symbol, ceiling, floor

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    Negative,
    RealNumber,
    at_rising_precision,
    expression_ball,
    fraction_ball,
)
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.sampledloop import SampledLoop, Timed, circle_tests, most_on_circle
from haptisym.kernel.sets import Bisected
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.stability.loops import zeros

_BITS, _MOST_BITS = 96, 1 << 12
_FINEST = Fraction(1, 1 << 24)  # of a value: shorter stretches stay open
_CLOSEST, _MOST_CLOSER = (
    Fraction(1, 1 << 44),
    200,
)  # of those in which the number of roots is known to change
_ONE, _MINUS_ONE, _PAIR = range(3)  # the tests

Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Passage:
    """A ``value`` at which a root is on the unit circle, and its frequency ``omega``, rad/s."""

    value: RealNumber
    omega: RealNumber


@dataclass(frozen=True)
class Looked:
    """What was ``found`` up to an ``end`` in a ``number`` of stretches, and which of them are
    ``left`` open."""

    found: list[Passage]
    left: list[Span]
    end: Fraction
    number: int


@dataclass(frozen=True)
class Opened:
    """A loop in which a symbol stands for one number."""

    loop: SampledLoop
    symbol: Symbol

    @cached_property
    def is_fixed(self) -> bool:
        """Whether the number is nowhere in it."""
        return self.symbol not in self.loop.symbols

    @property
    def is_of_clock(self) -> bool:
        """Whether the number is in the period."""
        return self.symbol in self.loop.T.free_symbols

    def at(self, value: Expr) -> SampledLoop:
        """The loop at a number."""
        return self.loop.at({self.symbol: value})

    @cached_property
    def always(self) -> int:
        """How many roots lie at 1 whatever the number is."""
        return 0 if self.loop.at_one != 0 else self.at(Rational(7919, 6007)).roots_at_one

    # A number that changes how many whole samples a delay is

    @cached_property
    def _ratios(self) -> list[Expr]:
        """Delays over the period that depend on the number."""
        found = [lag / self.loop.T for lag, _ in self.loop.plant.terms]
        return [x for x in found if x.has(self.symbol)]

    def samples(self, value: Rational) -> int:
        """How many whole samples the longest delay is, of those that depend on the number."""
        ratios = [x.xreplace({self.symbol: value}) for x in self._ratios]
        return max((int(floor(x)) for x in ratios), default=0)

    @cached_property
    def is_late(self) -> bool:
        """Whether the number is a delay of all that moves, and of nothing else, and the period
        rational."""
        others = self.loop.T, *self.loop.above, *self.loop.below, *self.loop.plant.denominator
        terms = self.loop.plant.terms
        apart = any(x.has(self.symbol) for x in (*others, *(x for _, row in terms for x in row)))
        late = all(
            lag.diff(self.symbol) == 1 and lag.xreplace({self.symbol: Integer(0)}).is_Rational
            for lag, _ in terms
        )
        return late and not apart and bool(self.loop.T.is_Rational) and not self.always

    def piece(self, start: Fraction, end: Fraction) -> tuple[Opened, Fraction]:
        """The loop from a value on towards another one as far as its delays keep their whole
        samples, and up to where that is."""
        if not self._ratios:
            return self, end
        q, last, side = _exact(start), _exact(end), 1 if end > start else -1
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
        return Opened(replace(self.loop, plant=timed), self.symbol), Fraction(
            int(stop.p), int(stop.q)
        )

    # Where roots are on the circle

    @cached_property
    def at_rest(self) -> tuple[Passage, ...]:
        """The values that put a root at z = 1; and 0 where that swings without the clock, as it
        then holds no force."""
        form, _ = self.loop.at_one.together().as_numer_denom()
        try:
            row = [] if self.always or self.is_fixed else Poly(form, self.symbol).all_coeffs()[::-1]
        except PolynomialError:
            raise UndecidedError(
                "which values put a root at z = 1: they are no zeros of a polynomial"
            ) from None
        mirrored = (
            [Negative(x) for x in zeros([c * (-1) ** i for i, c in enumerate(row)])]
            if len(row) > 2
            else []
        )
        still = [Passage(x, ExactNumber(Integer(0))) for x in (*zeros(row), *mirrored)]
        return (*still, *([Passage(ExactNumber(Integer(0)), self.swing)] if self.swing else []))

    @cached_property
    def swing(self) -> RealNumber | None:
        """The frequency, rad/s, with which it swings at the value 0, where the clock then holds no
        force."""
        try:
            here = self.at(Integer(0))
        except ZeroDivisionError:
            return None
        if any(here.above) and any(x for _, row in here.plant.terms for x in row):
            return None
        modes = Add(*(x * s**n for n, x in enumerate(here.plant.denominator)))
        if modes.free_symbols != {s}:
            return None
        ring = Ring.of([modes])
        return next(
            (x for x in count_roots(ring.convert(modes).numerator, ring).on_axis if float(x)), None
        )

    def most(self, span: Span) -> int | None:
        """For how many values each test is 0 at most, but for that at z = 1: 0, with no root on the
        circle, or 1; None: open."""
        with flint.ctx.workprec(_BITS):
            q = fraction_ball(span[0]).union(fraction_ball(span[1]))
            try:
                return most_on_circle(self.loop, {self.symbol: q}, Integer(1), self.always)
            except (UndecidedError, ZeroDivisionError):
                return None

    def passages(self, span: Span, most: int) -> Looked:
        """Where roots come to the circle beside z = 1, from the first end on, towards the other
        one."""
        looked = self._cut(span, most, _FINEST)
        found, left = looked.found, list[Span]()
        for x in joined(looked.left):  # where two of them meet there may be a root
            told = self._told(x)
            if told is not None:
                found += told
            elif self._differs(
                x
            ):  # balls overestimate: what holds a root for certain is cut further
                closer = self._cut(x, _MOST_CLOSER, _CLOSEST)
                found += closer.found
                left += joined(closer.left) if closer.end == x[1] else [x]
            else:
                left.append(x)
        return replace(looked, found=found, left=left)

    def _cut(self, span: Span, most: int, finest: Fraction) -> Looked:
        """The same in stretches that are cut until they are told, or as short as that share of
        their values."""
        found, left, waiting, number = list[Passage](), list[Span](), [span], 0
        shortest = abs(span[1] - span[0]) * finest
        while waiting and number < most:
            tick()
            start, end = own = waiting.pop()
            number += 1
            told = self._told(own)
            if told is not None:
                found += told
            elif abs(end - start) > finest * max(abs(start), abs(end), shortest):
                middle = Fraction(
                    float((33 * start + 31 * end) / 64)
                )  # not where a number that was thought out is
                waiting += [(middle, end), (start, middle)]
            else:
                left.append(own)
        return Looked(found, left, waiting[-1][0] if waiting else span[1], number)

    def _differs(self, span: Span) -> bool:
        """Whether the roots outside of the circle are not as many at both ends."""
        try:
            first, last = (self.at(_exact(x)).unstable() for x in span)
        except UndecidedError:
            return False
        return first != last

    def _told(self, span: Span) -> list[Passage] | None:
        """The passage in a stretch, or that there is none; None where that is not proven."""
        most = self.most(span)
        if not most:
            return None if most is None else []
        low, high = sorted(span)
        signs = [self._signs(x) for x in (low, high)]
        if None in (*signs[0], *signs[1]):
            return None
        changed = [i for i in (_ONE, _MINUS_ONE, _PAIR) if signs[0][i] * signs[1][i] < 0]  # type: ignore[operator]
        if len(changed) > 1 or (changed and self._has_rest(low, high)):
            return None
        if changed == [_PAIR]:
            try:
                counts = {sum(self.at(_exact(x)).unstable()) for x in (low, high)}
            except UndecidedError:
                return None
            changed = changed if len(counts) > 1 else []  # two real ones add up to 0
        return [self._passage(low, high, test) for test in changed]

    def _passage(self, low: Fraction, high: Fraction, test: int) -> Passage:
        """Where a test changes its sign between two values."""

        def is_above(value: Rational) -> bool | None:
            sign = self._sign(Fraction(int(value.p), int(value.q)), test)
            return None if sign is None else sign > 0

        value = Bisected(is_above, low, high, is_above(_exact(low)) is True)
        return Passage(value, Swing(self, test, value))

    def _has_rest(self, low: Fraction, high: Fraction) -> bool:
        """Whether a value that puts a root at z = 1 may lie between two."""
        with flint.ctx.workprec(_BITS):
            span = fraction_ball(low).union(fraction_ball(high))
            return any(
                x.value.ball(_BITS).overlaps(span) for x in self.at_rest if not float(x.omega)
            )

    def _signs(self, value: Fraction) -> tuple[int | None, int | None, int | None]:
        """Of the tests at a value; 0 of one that is known to be 0 there, None of one that is not
        told."""
        if not value and self.swing:
            return self._sign(value, _ONE), self._sign(value, _MINUS_ONE), 0
        return self._sign(value, _ONE), self._sign(value, _MINUS_ONE), self._sign(value, _PAIR)

    def _sign(self, value: Fraction, test: int) -> int | None:
        if test == _ONE and not self.always:
            return 1  # zeros of that are known
        return at_rising_precision(
            lambda _: sign_of(self.tests(fraction_ball(value))[test]) or None, _BITS, _MOST_BITS
        )

    def tests(self, q: Ball) -> tuple[Ball, Ball, Ball]:
        """At z = 1, at z = -1, and where two roots v add up to 0: numbers that vanish where a root
        is on the circle."""
        return circle_tests(self.loop, {self.symbol: q}, self.loop.at_one, self.always)

    def angle(self, q: Ball, bits: int) -> Ball:
        """Of the pair on the circle: its argument, to so many bits; not finite where balls do not
        tell."""
        try:
            roots = acb_poly(self.loop.in_v({self.symbol: q}, self.always)).roots(
                tol=arb(2) ** -bits, maxprec=2 * flint.ctx.prec
            )
        except ValueError:
            return arb("nan")
        found = [2 * v.imag.atan() for v in roots if v.real.contains(0) and v.imag > 0]
        return found[0] if len(found) == 1 else arb("nan")


def joined(spans: Sequence[Span]) -> list[Span]:
    """Those that touch as one."""
    found = list[Span]()
    for low, high in sorted((min(x), max(x)) for x in spans):
        if found and found[-1][1] == low:
            found[-1] = found[-1][0], high
        else:
            found.append((low, high))
    return found


def _exact(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


@dataclass(frozen=True, repr=False)
class Swing(RealNumber):
    """The frequency at which roots reach the unit circle at a value, where a test is 0, rad/s."""

    loop: Opened
    test: int
    value: RealNumber

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(4 * bits + 128):
            q = self.value.ball(2 * bits + 64)
            if self.test == _ONE:
                return arb(0)
            theta = arb.pi() if self.test == _MINUS_ONE else self.loop.angle(q, bits)
            return theta / expression_ball(self.loop.loop.T, {self.loop.symbol: q})
