"""A sampled loop with one open parameter: for which values of it a root is on the unit circle.

With z = (1 + v)/(1 - v) the circle becomes the imaginary axis of v, and three numbers tell whether
a root is on it. At z = 1: B(1) Q(0) + A(1) N(0), for the controller A/B and the plant N/Q, a
polynomial in the parameter whose zeros are found by themselves. At z = -1: the highest coefficient
in v. A pair: Hurwitz' determinant of order n - 1, which vanishes where two roots v add up to 0
(Orlando's formula), as a pair on the axis does, and two real ones may.

An interval of values is *clear* where the last two are proven not to be 0 for any of its values, in
balls. It is cut until it is, or until each of the two is 0 once at most, as its slope has one sign:
then the signs at its ends tell whether it is, and the counts there whether what adds up to 0 is a
pair on the circle. Intervals that are too short for that stay open.

Roots are continuous in the parameter as long as no delay gets one more whole sample
(``Opened.piece``); where it does, they may jump over the circle (``Opened.jumps_at``). Begin with
``Opened.passages``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial

import flint
from flint import acb_poly, arb
from sympy import Add, Expr, Integer, Poly, PolynomialError, Rational, Symbol, ceiling, floor

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    RealNumber,
    at_rising_precision,
    expression_ball,
    fraction_ball,
    rational,
)
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import count_roots
from haptisym.kernel.sampledloop import SampledLoop, Timed, circle_tests, most_on_circle
from haptisym.kernel.sets import Bisected
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.stability.loops import zeros

_BITS, _MOST_BITS = 96, 1 << 12
# Intervals that are shorter, relative to their values, stay open.
_FINEST = Fraction(1, 1 << 24)
# The same where the number of roots is known to change in one, and how many are then looked at.
_CLOSEST, _MOST_CLOSER = Fraction(1, 1 << 44), 200
# The three tests, in the order of ``tests``.
_ONE, _MINUS_ONE, _PAIR = range(3)

Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Passage:
    """A ``value`` at which a root is on the unit circle, and its frequency ``omega``, rad/s."""

    value: RealNumber
    omega: RealNumber


@dataclass(frozen=True)
class Looked:
    """What was ``found`` up to an ``end`` in a ``number`` of intervals, and which of them are
    ``left`` open."""

    found: list[Passage]
    left: list[Span]
    end: Fraction
    number: int


@dataclass(frozen=True)
class Opened:
    """A sampled loop in which a symbol stands for its open parameter."""

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
        """The loop at a number. UndecidedError where it then has none, as without a mass or damping
        that is needed."""
        try:
            return self.loop.at({self.symbol: value})
        except SceneError as error:
            raise UndecidedError(f"the roots of a loop: {error}") from None

    @cached_property
    def always(self) -> int:
        """How many roots lie at 1 whatever the number is."""
        # At a value that is none of a simple kind, as at one of these a root may come to 1.
        return 0 if self.loop.at_one != 0 else self.at(Rational(7919, 6007)).roots_at_one

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
    def _jumps(self) -> bool:
        """Whether a force moves what is sampled at once, without mass or damping in between."""
        order = len(self.loop.plant.denominator) - 1
        return any(any(row[order:]) for _, row in self.loop.plant.terms)

    def jumps_at(self, value: Fraction) -> list[RealNumber]:
        """A value alone, if roots may jump there, over the circle without being on it: where such a
        force comes a whole sample later. Else nothing."""
        number = rational(value)
        ratios = (x.xreplace({self.symbol: number}) for x in self._ratios)
        is_later = self._jumps and any(x and x.is_Integer for x in ratios)
        return [ExactNumber(number)] if is_later else []

    @cached_property
    def is_late(self) -> bool:
        """Whether the parameter is a delay of all that moves, and in nothing else, the period is
        rational, and the roots are continuous in it."""
        others = self.loop.T, *self.loop.above, *self.loop.below, *self.loop.plant.denominator
        terms = self.loop.plant.terms
        coefficients = (x for _, row in terms for x in row)
        is_elsewhere = any(x.has(self.symbol) for x in (*others, *coefficients))
        none = {self.symbol: Integer(0)}
        is_delay = all(
            lag.diff(self.symbol) == 1 and lag.xreplace(none).is_Rational for lag, _ in terms
        )
        is_rational = bool(self.loop.T.is_Rational)
        return is_delay and is_rational and not (is_elsewhere or self._jumps or self.always)

    def piece(self, start: Fraction, end: Fraction) -> tuple[Opened, Fraction]:
        """The loop from a value on towards another one as far as its delays keep their whole
        samples, and up to where that is."""
        if not self._ratios:
            return self, end
        q, last, side = rational(start), rational(end), 1 if end > start else -1
        # A delay has a new number of whole samples where its ratio to the period comes to the next
        # whole number: linear in the parameter, or not looked for.
        turns = list[Expr]()
        for ratio in self._ratios:
            here = ratio.xreplace({self.symbol: q})
            if not here.is_Rational:
                raise UndecidedError("the limits of a parameter that is not rational")
            grows = (ratio.diff(self.symbol).xreplace({self.symbol: q}) > 0) == (side > 0)
            n = floor(here) + 1 if grows else ceiling(here) - 1
            above, below = (Poly(x, self.symbol) for x in (ratio - n).together().as_numer_denom())
            if n >= 0 and above.degree() == 1 and below.degree() < 2:
                turn = -above.nth(0) / above.nth(1)
                turns += [turn] if (turn - q) * side > 0 else []
        stop = min((last, *turns), key=lambda x: (x - q) * side)
        # At the ends of the piece a delay may be a whole number of samples; amid it floors are
        # certain.
        middle = {self.symbol: (q + stop) / 2}
        period, plant = self.loop.T.xreplace(middle), self.loop.plant
        whole = tuple(int(floor(lag.xreplace(middle) / period)) for lag, _ in plant.terms)
        timed = Timed(plant.denominator, plant.terms, whole)
        return Opened(replace(self.loop, plant=timed), self.symbol), Fraction(
            int(stop.p), int(stop.q)
        )

    @cached_property
    def at_rest(self) -> tuple[Passage, ...]:
        """The values that put a root at z = 1; and 0 where the clock then holds no force and what
        moves swings by itself."""
        form, _ = self.loop.at_one.together().as_numer_denom()
        try:
            row = [] if self.always or self.is_fixed else Poly(form, self.symbol).all_coeffs()[::-1]
        except PolynomialError:
            raise UndecidedError(
                "which values put a root at z = 1: they are no zeros of a polynomial"
            ) from None
        still = [Passage(x, ExactNumber(Integer(0))) for x in zeros(row)]
        return (*still, *([Passage(ExactNumber(Integer(0)), self.swing)] if self.swing else []))

    @cached_property
    def swing(self) -> RealNumber | None:
        """The frequency, rad/s, of an undamped mode at the value 0, where the clock then holds no
        force; None where there is none."""
        try:
            here = self.at(Integer(0))
        except (UndecidedError, ZeroDivisionError):
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
        """For how many values of an interval each test (but that at z = 1) is 0 at most: 0, so that
        no root is on the circle, or 1; None: open."""
        with flint.ctx.workprec(_BITS):
            q = fraction_ball(span[0]).union(fraction_ball(span[1]))
            try:
                return most_on_circle(self.loop, {self.symbol: q}, Integer(1), self.always)
            except (UndecidedError, ZeroDivisionError):
                return None

    def passages(self, span: Span, most: int) -> Looked:
        """All values of an interval with a root on the circle, but at z = 1: from its first end on,
        in ``most`` intervals at most."""
        looked = self._cut(span, most, _FINEST)
        found, left = looked.found, list[Span]()
        # Joined first: where two of them meet there may be a root, which neither alone can tell.
        for x in joined(looked.left):
            passages = self._told(x)
            if passages is not None:
                found += passages
            # Balls overestimate: an interval that holds a root for certain is cut further.
            elif self._differs(x):
                closer = self._cut(x, _MOST_CLOSER, _CLOSEST)
                found += closer.found
                left += joined(closer.left) if closer.end == x[1] else [x]
            else:
                left.append(x)
        return replace(looked, found=found, left=left)

    def _cut(self, span: Span, most: int, finest: Fraction) -> Looked:
        """What an interval holds, cut until each part is settled, or as short as ``finest``,
        relative to its values."""
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
                # Off the middle: a critical value that is a simple number would be at the end of
                # two parts, and settled in neither.
                middle = Fraction(float((33 * start + 31 * end) / 64))
                waiting += [(middle, end), (start, middle)]
            else:
                left.append(own)
        return Looked(found, left, waiting[-1][0] if waiting else span[1], number)

    def _differs(self, span: Span) -> bool:
        """Whether the numbers of roots outside of the circle differ between both ends; False also
        where they are not known."""
        try:
            first, last = (self.at(rational(x)).unstable() for x in span)
        except UndecidedError:
            return False
        return first != last

    def _told(self, span: Span) -> list[Passage] | None:
        """The passages in an interval: one, or none; None where neither is proven."""
        most = self.most(span)
        if not most:
            return None if most is None else []
        low, high = sorted(span)
        changed: list[int] = []
        for i, (at_low, at_high) in enumerate(
            zip(self._signs(low), self._signs(high), strict=True)
        ):
            if at_low is None or at_high is None:
                return None
            if at_low * at_high < 0:
                changed.append(i)
        # Where two tests change at once, or a root may come through z = 1 as well, the counts at
        # the ends do not tell which roots came.
        if len(changed) > 1 or (changed and self._has_rest(low, high)):
            return None
        if changed == [_PAIR]:
            try:
                counts = {sum(self.at(rational(x)).unstable()) for x in (low, high)}
            except UndecidedError:
                return None
            # Two real roots v that add up to 0, z and 1/z, change no count.
            changed = changed if len(counts) > 1 else []
        return [self._passage(low, high, test) for test in changed]

    def _passage(self, low: Fraction, high: Fraction, test: int) -> Passage:
        """Where a test changes its sign between two values."""
        is_above = partial(self._is_above, test)  # an answer is pickled with it
        value = Bisected(is_above, low, high, is_above(rational(low)) is True)
        return Passage(value, Swing(self, test, value))

    def _is_above(self, test: int, value: Rational) -> bool | None:
        """Whether a test is positive at a value; None where that is not told."""
        sign = self._sign(Fraction(int(value.p), int(value.q)), test)
        return None if sign is None else sign > 0

    def _has_rest(self, low: Fraction, high: Fraction) -> bool:
        """Whether a value that puts a root at z = 1 may lie between two."""
        with flint.ctx.workprec(_BITS):
            span = fraction_ball(low).union(fraction_ball(high))
            return any(
                x.value.ball(_BITS).overlaps(span) for x in self.at_rest if not float(x.omega)
            )

    def _signs(self, value: Fraction) -> tuple[int | None, int | None, int | None]:
        """The signs of the three tests at a value; 0 of one that is known to be 0 there, None of
        one that stays open."""
        pair = 0 if not value and self.swing else self._sign(value, _PAIR)
        return self._sign(value, _ONE), self._sign(value, _MINUS_ONE), pair

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
        """The argument of the pair on the circle, rad, to so many bits; not finite where balls do
        not single it out."""
        try:
            roots = acb_poly(self.loop.in_v({self.symbol: q}, self.always)).roots(
                tol=arb(2) ** -bits, maxprec=2 * flint.ctx.prec
            )
        except ValueError:
            return arb("nan")
        found = [2 * v.imag.atan() for v in roots if v.real.contains(0) and v.imag > 0]
        return found[0] if len(found) == 1 else arb("nan")


def joined(spans: Sequence[Span]) -> list[Span]:
    """Intervals in ascending order, those that touch as one."""
    runs = list[Span]()
    for low, high in sorted((min(x), max(x)) for x in spans):
        if runs and runs[-1][1] == low:
            runs[-1] = runs[-1][0], high
        else:
            runs.append((low, high))
    return runs


@dataclass(frozen=True, repr=False)
class Swing(RealNumber):
    """The frequency at which roots reach the unit circle at a value, where a test is 0, rad/s."""

    loop: Opened
    test: int
    value: RealNumber

    def ball(self, bits: int) -> Ball:
        # The root of a polynomial is known to fewer digits than its coefficients, the value to
        # fewer than the precision: rather too many bits than a ball that tells nothing.
        with flint.ctx.workprec(4 * bits + 128):
            q = self.value.ball(2 * bits + 64)
            if self.test == _ONE:
                return arb(0)
            theta = arb.pi() if self.test == _MINUS_ONE else self.loop.angle(q, bits)
            return theta / expression_ball(self.loop.loop.T, {self.loop.symbol: q})
