"""A display with a clock in a hand: its loop, its roots, and how far a number may go before roots reach the unit circle.

The loop goes through controller, hold and what moves. In v, z = (1 + v)/(1 - v), the circle is the imaginary axis: where there
is no root at z = 1, where B(1) Q(0) + A(1) N(0) = 0, D = A/B and G = N/Q; none at z = -1, where the highest coefficient in v is
0; nor a pair +-j nu, where a determinant of Hurwitz is 0, for any values of a cell, the number of roots with |z| >= 1 is one for
all of its values. From a value on such cells, in balls, follow each other, as long as they may be, up to one in which the number
of roots changes; the zero of its test is closed in on, to any digits.

How far it is asked about is bounded, and the answer says how far; 0 is reached where all values down to it are clear at once.
Without end it is where what damps, or is mass or stiffness beside that, puts no root on the circle, as that damps as Colgate and
Schenkel's condition asks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import flint
from flint import arb
from sympy import Add, Expr, I, Integer, Rational, Symbol, pi

from haptisym.judge.colgate import sampled_passivity
from haptisym.kernel.budget import share, tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, at_rising_precision, expression_ball, fraction_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, degree_in, s
from haptisym.kernel.rootcount import Roots, count_roots, is_stable
from haptisym.kernel.sampledloop import Plant, SampledLoop
from haptisym.model.catalogue import CLOCKS, SAMPLED_LOOP, Effect, Hand, controller, device
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.stability.late import Late, Later, Piece
from haptisym.verbs.stability.opened import Opened, Passage


def clocked_roots(scene: Scene, hand: Hand) -> Roots:
    """The roots in |z| >= 1 of a display with a clock in a hand; those outside the circle are its ``right``."""
    outside, at_1 = loop_of(scene, hand).unstable()
    return Roots(outside + at_1, outside)


def clock_of(scene: Scene) -> tuple[int, Effect]:
    """The one effect with a clock, and its place. UndecidedError where there are two."""
    (place, *others) = [i for i, effect in enumerate(scene.effects) if effect.model in CLOCKS]
    if others:
        raise UndecidedError("the poles of a loop with two samplers")
    return place, scene.effects[place]


def series_alone(scene: Scene) -> bool:
    """Whether what comes before the clock does no more than multiply the force."""
    place, _ = clock_of(scene)
    return all(x.matrix[1:] == (0, 0, 1) for x in scene.effects[:place])


def loop_of(scene: Scene, hand: Hand) -> SampledLoop:
    """Controller, delay, hold, then device, compliance and hand in continuous time; symbols that are left may stay.

    A ``sampled-loop`` samples the position, a ``zero-order-hold`` the force that comes to it: before it all is continuous.
    UndecidedError where a delay or a power of s returns between sampler and hand, or a jump of the force jumps back at once.
    """
    place, clock = clock_of(scene)
    behind, before = scene.effects[place + 1 :], scene.effects[:place]
    rendered = Integer(1) if clock.model == SAMPLED_LOOP else scene.rendering.H
    entries = [x for effect in (*before, *behind) for x in effect.matrix]
    ring = Ring.of([rendered, hand.Z, *entries])
    G = (ring.one / impedance(ring, behind, ring.convert(hand.Z))).reduced()
    above: tuple[Expr, ...] = (Integer(1),)
    below: tuple[Expr, ...] = (Integer(1),)
    if clock.model == SAMPLED_LOOP:
        D = controller(clock)
        above, below = (tuple(D.ring.coefficients(p)) for p in (D.numerator, D.denominator))
    else:
        H = ring.convert(rendered)
        for effect in before:
            a, b, c, d = map(ring.convert, effect.matrix)
            H = ((a * H + b) / (c * H + d)).reduced()
        if H.is_zero:  # the clock holds nothing, and what moves has its own modes alone
            above = (Integer(0),)
        else:
            G = _seen_by_the_clock(G * H)
    return SampledLoop(plant_of(G, ring), clock.parameters[0].value, above, below)


def _seen_by_the_clock(G: RationalFunction) -> RationalFunction:
    """What moves and the force before the clock, in a row, without modes that cancel and fade.

    What the force does not see remains a mode of what moves, and what the motion does not reach one of the force: exp(p T) is
    a root of the loop for each p that cancels. Those that do not fade are left in place.
    """
    ring, common = G.ring, G.numerator.gcd(G.denominator)
    cancelled = RationalFunction(ring, ring.one.numerator, common)
    is_open = any(degree_in([common], i) for i in range(2, ring.size))
    return G.monic() if is_open or not (common.is_constant() or is_stable(cancelled)) else G.reduced()


def impedance(ring: Ring, effects: tuple[Effect, ...], hand: RationalFunction) -> RationalFunction:
    """Force per position that what moves shows to the held force: the hand, seen through effects."""
    Z = hand
    for effect in reversed(effects):
        a, b, c, d = map(ring.convert, effect.matrix)
        top, bottom = Z * d + b, Z * c + a
        if bottom.is_zero:
            raise UndecidedError("the roots of a loop whose force does not reach the hand")
        Z = (top / bottom).reduced()
    if Z.is_zero:
        raise UndecidedError(
            "the roots of a loop with nothing that has mass, damping or stiffness between sampler and hand"
        )
    return Z


def plant_of(G: RationalFunction, ring: Ring) -> Plant:
    """A dynamics between clock and sampler as a plant: delays stand over it alone."""
    first, last = ring.size, ring.size + len(ring.lags)
    if degree_in([G.numerator, G.denominator], ring.meanings.index(I)) if I in ring.meanings else 0:
        raise UndecidedError("the roots of a loop with friction")
    for i in range(first, len(ring.meanings)):
        powers = {int(e[i]) for e in G.denominator.monoms()}
        if len(powers) > 1 or (i >= last and (powers != {0} or any(int(e[i]) for e in G.numerator.monoms()))):
            what = "a delay" if i < last else "a power of s"
            raise UndecidedError(f"the roots of a loop in which {what} returns between sampler and hand")
    early = tuple(int(x) for x in G.denominator.monoms()[0][first:last])
    [(_, bottom)] = _by_delay(ring, G.denominator).items()
    terms = [
        (sum(((n - m) * lag for n, m, lag in zip(turns, early, ring.lags, strict=True)), Integer(0)), row)
        for turns, row in _by_delay(ring, G.numerator).items()
    ]
    if any(lag.could_extract_minus_sign() for lag, _ in terms):
        raise UndecidedError("the roots of a loop that is not causal")
    try:
        return Plant(bottom, tuple(terms))
    except SceneError as error:
        raise UndecidedError(f"the roots of a loop: {error}") from None


def _by_delay(ring: Ring, polynomial: Polynomial) -> Mapping[tuple[int, ...], tuple[Expr, ...]]:
    """For each product of delays the coefficients of its polynomial in s."""
    first, last = ring.size, ring.size + len(ring.lags)
    rows: dict[tuple[int, ...], dict[int, Expr]] = {}
    for exponents, value in polynomial.to_dict().items():
        own = [int(n) for n in exponents]
        row = rows.setdefault(tuple(own[first:last]), {})
        factor = Rational(int(value.p), int(value.q)) * pi ** own[1]
        for symbol, n in zip(ring.symbols, own[2:first], strict=True):
            factor *= symbol**n
        row[own[0]] = row.get(own[0], Integer(0)) + factor
    return {turns: tuple(row.get(n, Integer(0)) for n in range(max(row) + 1)) for turns, row in rows.items()}


@dataclass(frozen=True, repr=False)
class CriticalValue(RealNumber):
    """The zero of one of the three tests between two values at which its signs differ."""

    loop: Opened
    test: int
    low: Fraction
    high: Fraction

    def ball(self, bits: int) -> Ball:
        return _bisected(self, bits)

    def value(self, x: Ball) -> Ball:
        """The test at a point."""
        return self.loop.tests(x)[self.test]


@lru_cache(maxsize=256)
def _bisected(zero: CriticalValue, bits: int) -> Ball:
    """A ball around it of about that relative accuracy: by regula falsi, until signs on both sides of a point confirm it."""
    with flint.ctx.workprec(2 * bits + 64):
        low, high = fraction_ball(zero.low), fraction_ball(zero.high)
        f, g = (zero.value(x) for x in (low, high))
        if f.contains(0) or g.contains(0):
            return low.union(high)
        while high - low > 2 * (width := max(abs(low), abs(high)).mid() * arb(2) ** -bits):
            x = ((low * g - high * f) / (g - f)).mid()
            aside = (low * 33 + high * 31) / 64  # a zero in the very middle has no sign to be told
            for place in ((x - width).mid(), (x + width).mid(), aside.mid()):
                if not low < place < high:
                    continue
                y = zero.value(place)
                if y.contains(0):
                    return low.union(high)
                if (y > 0) == (f > 0):
                    low, f = place, y.mid()
                else:
                    high, g = place, y.mid()
        return low.union(high)


@dataclass(frozen=True, repr=False)
class Swing(RealNumber):
    """The frequency at which roots reach the unit circle, rad/s."""

    value: CriticalValue

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(4 * bits + 128):
            q = self.value.ball(2 * bits + 64)
            if self.value.test == 0:
                return arb(0)
            theta = arb.pi() if self.value.test == 1 else self.value.loop.angle(q, bits)
            return theta / self.value.loop.period(q)


@dataclass(frozen=True, repr=False)
class Sum(RealNumber):
    """Of a number and a rational one."""

    first: RealNumber
    more: Rational

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits + 32):
            return self.first.ball(bits + 8) + arb(int(self.more.p)) / int(self.more.q)


_MOST_BITS = 1 << 12
_BITS, _BITS_OF_WALK = 128, 64  # of a value, and of a cell, which is wide
_ZERO = ExactNumber(Integer(0))
_CLOCK, _REACH, _FAR = 32, 2**10, 10**6
"""Times as much, and as little, a value may be for its nearest limit: of a clock or delay, of others, of a wall's."""
_FINEST = Fraction(1, 1 << 24)  # of a value: where cells are shorter, it is asked whether more roots are behind them
_STEPS = (8, 64, 512)  # of such cells, over which roots are more or fewer, or proven to be as many throughout
_DEEPEST = 8  # times that these are cut
_BESIDE = tuple(Fraction(1, 1 << n) for n in (2, 8, 16, 32))  # of a value with a root at 1, to walk on from there
_GROWTH = Fraction(1, 2)  # of a cell, to the next
_MOST_FINE = 40  # of the shortest cells on a side
_MOST, _BRIEF = 800, 48  # of all cells on a side, and of one that is brief
_QUICK = 4  # times as quick a clock may be where it is brief


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
            raise UndecidedError("the limits of a parameter that is not rational")
    return near


@dataclass(frozen=True)
class Walk:
    """From a value on, cell after cell, up to ``ends``; ``home`` : the number of roots there."""

    loop: Opened
    start: Fraction
    home: int
    rule: Rule
    ends: tuple[Fraction, Fraction]
    most: int = _MOST
    """Cells on a side."""
    is_at_1: bool = False
    """Whether a root is at 1 at the very start, and nowhere beside it."""

    def beside(self, side: int) -> Walk | None:
        """From where no root is at 1 any more, on one side; None where the number may not be there."""
        if not self.is_at_1:
            return self
        if side < 0 and self.start == 0 and self.rule is not Rule.ANY:
            return None
        for part in _BESIDE:
            step = (abs(self.start) or 1) * part
            if self._is_alone_at_1(self.start, step):
                start = self.start + side * step
                home, _ = self.loop.count(Rational(start.numerator, start.denominator))
                return replace(self, start=start, home=home, is_at_1=False)
        raise UndecidedError("the limits of a parameter with poles on the unit circle now")

    def _is_alone_at_1(self, value: Fraction, step: Fraction) -> bool:
        """Whether a root passes 1 at a value, and none is on the circle elsewhere on either side of it, proven."""
        symbol = self.loop.symbol
        left = (self.loop.at_one.xreplace({symbol: symbol + value}) / symbol).expand()
        if left.has(1 / symbol) or self.loop.always:
            return False
        with flint.ctx.workprec(_BITS):
            q = arb(0, fraction_ball(step).upper())
            rest = expression_ball(left, {symbol: q}), *self.loop.tests(fraction_ball(value) + q)[1:]
            return not any(x.contains(0) or not x.is_finite() for x in rest)

    def towards(self, side: int) -> tuple[Passage | None, Fraction]:
        """The nearest change on one side, None where there is none, and as far as that is known.

        From one value at which a delay is a whole number of samples to the next: between two the loop is one polynomial.
        """
        if not self.loop.is_timed:
            return self._within(side)
        at, end = self.start, self.ends[side > 0]
        if side > 0 and self.loop.is_late and at >= 0:
            late = self.later()
            if late.passage is not None:
                return late.passage, late.known
            at = late.known
        while (end - at) * side > 0:
            loop, last = self.loop.piece(at, end, side)
            passage, known = replace(self, loop=loop, start=at, ends=(min(at, last), max(at, last)))._within(side)
            if passage is not None or known != last:
                return passage, known
            at = last
        return None, at

    def later(self) -> Late:
        """The same on the way up, of a number that is a delay of all that moves."""
        T, at, pieces = Fraction(int(self.loop.loop.T.p), int(self.loop.loop.T.q)), Fraction(0), list[Piece]()
        while at < T:
            loop, last = self.loop.piece(at, T, 1)
            pieces.append((loop, at, last))
            at = last

        def close(loop: Opened, one: Fraction, other: Fraction) -> Passage | None:
            home, count = (loop.count(Rational(x.numerator, x.denominator))[0] for x in (one, other))
            return None if home == count else replace(self, loop=loop, home=home).between(one, other, count)

        found = Later(pieces, T, close).first(self.start, self.ends[1])
        if found.passage is None:
            return found
        whole = found.samples * self.loop.loop.T
        return replace(found, passage=replace(found.passage, value=Sum(found.passage.value, whole)))

    def _within(self, side: int) -> tuple[Passage | None, Fraction]:
        scale = abs(self.start) or Fraction(1)
        end = self.ends[side > 0]
        at, step, fine, growth = self.start, scale / 64, 0, _GROWTH
        for _ in range(self.most):
            try:
                tick()
            except LimitError:
                break
            if (end - at) * side <= 0:
                found = self._at_0(at, side)
                return found, Fraction(0) if found or self._is_clear_down_to_0(at, side) else at
            further = _short(at + side * step)
            ahead = min(further, end) if side > 0 else max(further, end)
            most = self._most(at, ahead)
            if most == 1:
                most, found = self._once(at, ahead)
                if found is not None:
                    return found, ahead
            if most == 0:
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
                if fine > min(_MOST_FINE, self.most // 20):
                    break
        return None, at

    def _most(self, one: Fraction, other: Fraction) -> int | None:
        with flint.ctx.workprec(_BITS_OF_WALK):
            return self.loop.most(fraction_ball(one).union(fraction_ball(other)))

    def _once(self, one: Fraction, other: Fraction) -> tuple[int | None, Passage | None]:
        """The one change between two values, or 0 where there is none, each test being 0 once there at most; else None.

        A pair comes to the circle only to go over it, as the test for it changes its sign where it is 0: so does the count then.
        """
        try:
            count, on = self.loop.count(Rational(other.numerator, other.denominator))
            if on:
                return None, None
            if count != self.home:
                return None, self.between(one, other, count)
        except UndecidedError:
            return None, None
        with flint.ctx.workprec(_BITS):
            ends = [self.loop.tests(fraction_ball(x))[:2] for x in (one, other)]
        return (0 if all(x * y > 0 for x, y in zip(*ends, strict=True)) else None), None

    def _over(self, one: Fraction, step: Fraction) -> tuple[Passage | None, Fraction]:
        """Past values where balls do not tell: a change there, None if there is none, and how far that goes."""
        for times in _STEPS:
            other = one + times * step
            count, on = self.loop.count(Rational(other.numerator, other.denominator))
            if on:
                raise UndecidedError("where a root stays on the unit circle")
            if count != self.home:
                return self.between(one, other, count), other
            low, high = sorted((one, other))
            if self._has_none(low, high, _DEEPEST):
                return None, other
        raise UndecidedError("whether roots reach the unit circle and go back")

    def _has_none(self, low: Fraction, high: Fraction, depth: int) -> bool:
        """Whether no value between two puts a root on the circle, proven; in ever smaller pieces, as beside one that does."""
        tick()
        if self._most(low, high) == 0:
            return True
        middle = (low + high) / 2
        return depth > 0 and self._has_none(low, middle, depth - 1) and self._has_none(middle, high, depth - 1)

    def between(self, one: Fraction, other: Fraction, count: int) -> Passage:
        """The change between two values that are close to each other, to a count at the other one."""
        low, high = sorted((one, other))
        side = 1 if other > one else -1
        below, above = (self.home, count) if side > 0 else (count, self.home)
        changed = at_rising_precision(lambda _: self._changed(low, high), _BITS, _MOST_BITS)
        if changed is None:
            raise UndecidedError("where roots reach the unit circle together")
        if low < 0 < high:  # whose digits have no end
            if (omega := self._at_zero_itself(changed)) is not None:
                return Passage(_ZERO, omega, below, above)
            sense = at_rising_precision(lambda _: _sign(self.loop.tests(arb(0))[changed]), _BITS, _MOST_BITS)
            if sense is None:
                raise UndecidedError("whether a limit is 0, or next to it")
            with flint.ctx.workprec(_BITS):
                is_below = sense != _sign(self.loop.tests(fraction_ball(low))[changed])
            low, high = (low, Fraction(0)) if is_below else (Fraction(0), high)
        value = CriticalValue(self.loop, changed, low, high)
        return Passage(value, Swing(value), below, above)

    def _at_zero_itself(self, test: int) -> RealNumber | None:
        """The frequency of roots on the circle at the value 0, rad/s, proven: at 1, or where the clock then holds no force."""
        here = self.loop.at(Integer(0))
        if test == 0:
            return _ZERO if self.loop.at_one.xreplace({self.loop.symbol: Integer(0)}) == 0 else None
        if any(here.above) and any(x for _, row in here.plant.terms for x in row):
            return None
        modes = Add(*(x * s**n for n, x in enumerate(here.plant.denominator)))
        ring = Ring.of([modes])
        return next(iter(count_roots(ring.convert(modes).numerator, ring).on_axis), None)

    def _changed(self, low: Fraction, high: Fraction) -> int | None:
        """Which test alone has another sign at the other end; None where balls do not tell."""
        ends = zip(*(self.loop.tests(fraction_ball(x)) for x in (low, high)), strict=True)
        signs = [x * y for x, y in ends]
        changed = [i for i, x in enumerate(signs) if x < 0]
        return changed[0] if len(changed) == 1 and sum(bool(x > 0) for x in signs) == 2 else None

    def _is_clear_down_to_0(self, at: Fraction, side: int) -> bool:
        """Whether no value down to 0, where the number may not be less, puts a root on the circle; 0 is among them."""
        return side < 0 < self.start and self.rule is not Rule.ANY and self._most(at, Fraction(0)) == 0

    def _at_0(self, at: Fraction, side: int) -> Passage | None:
        """At the end of what was looked at: a change at 0 itself, where a root comes to 1; None where that stays open."""
        if side > 0 or self.rule is not Rule.NONNEGATIVE or self.start == 0:
            return None
        try:
            count, _ = self.loop.count(Integer(0))
        except UndecidedError:
            return None
        if count == self.home or not self._is_alone_at_1(Fraction(0), at):
            return None
        return Passage(_ZERO, _ZERO, count, self.home)


def _sign(x: Ball) -> int | None:
    return None if x.contains(0) else 1 if x > 0 else -1


def _short(x: Fraction) -> Fraction:
    """A number nearby with few digits, so that sums of many steps have no more."""
    return Fraction(float(x))


_MOST_PASSAGES = 24


@dataclass(frozen=True)
class Passages:
    """Those ``found``, and between which values (``low``, ``high``) all are; None where nothing ends that on a side."""

    found: tuple[Passage, ...]
    low: Fraction | None = None
    high: Fraction | None = None
    beside: Fraction | None = None
    """From where on it goes up, where the number itself has a root at 1."""


def passages(scene: Scene, hand: Hand, free: Knob, *, brief: bool = False) -> Passages:
    """The nearest below the value that a number has, and the nearest above it. UndecidedError where that stays open.

    ``brief`` : with few cells on a side, as of a number that nobody asked about.
    """
    if free.rule not in (Rule.POSITIVE, Rule.NONNEGATIVE, Rule.ANY):
        raise UndecidedError("an order in a sampled loop")
    loop = opened(scene, hand, free)
    if loop.is_fixed:
        return Passages(())
    walk = _walk(loop, free)
    times = _CLOCK if loop.is_of_clock else _FAR if loop.is_of_wall else _REACH
    more = (abs(walk.start) or 1) * times
    less = walk.start / (_QUICK if brief and loop.is_of_clock else times)
    low = walk.start - more if free.rule is Rule.ANY else less
    walk = replace(walk, ends=(low, walk.start + more), most=_BRIEF if brief else walk.most)
    found = _both_ways(walk, scene, hand, free, 1)
    if found.low == found.high:
        tick()
        raise UndecidedError("the limits of a parameter next to whose value poles come to the unit circle")
    is_whole = found.low == 0 and free.rule is not Rule.ANY
    return replace(found, low=None) if is_whole else found


def passages_in(scene: Scene, hand: Hand, free: Knob, ends: tuple[Expr, Expr]) -> tuple[Opened, Passages]:
    """The loop, and all passages between two values, as far as they are found.

    UndecidedError where that stays open from the value on that the number has.
    """
    loop = opened(scene, hand, free)
    if loop.is_fixed:
        return loop, Passages(())
    low, high = (Fraction(float(x)) for x in ends)
    walk = replace(_walk(loop, free), ends=(low, high))
    found = _both_ways(walk, scene, hand, free, _MOST_PASSAGES)
    assert found.low is not None
    is_whole = found.high is None or found.high >= high
    return loop, replace(found, low=None if found.low <= low else found.low, high=None if is_whole else found.high)


def _walk(loop: Opened, free: Knob) -> Walk:
    """From the value on that a number has."""
    start = start_of(loop, free.value)
    home, on = loop.count(start)
    at = Fraction(int(start.p), int(start.q))
    return Walk(loop, at, home, free.rule, (at, at), is_at_1=on > 0)


def _both_ways(walk: Walk, scene: Scene, hand: Hand, free: Knob, most: int) -> Passages:
    """The first passages on each side, in order, and between which values these are all: None where enough is damped above."""
    down, up = walk.beside(-1), walk.beside(1)
    assert up is not None  # no rule forbids to go up

    def is_enough(value: Fraction) -> bool:
        return is_held(scene, hand, free, Rational(value.numerator, value.denominator))

    found, low = _along(down, -1, most) if down else ([], walk.start)
    found.reverse()
    if down and down.home != up.home:
        at = ExactNumber(Rational(walk.start.numerator, walk.start.denominator))
        found.append(Passage(at, _ZERO, down.home, up.home))
    beside = up.start if walk.is_at_1 else None
    if is_enough(up.start):
        return Passages(tuple(found), low, None, beside)
    above, high = _along(up, 1, most)
    return Passages((*found, *above), low, None if is_enough(high) else high, beside)


def _along(walk: Walk, side: int, most: int) -> tuple[list[Passage], Fraction]:
    """The first passages on a side, as many as may be looked for, and up to which value these are all.

    Beyond one at which roots become fewer the next is looked for as well: what is stable there may end. In half of the time
    that is left: something is left for the other side, and for other numbers.
    """
    found = list[Passage]()
    while True:
        with share(1 / 2):
            passage, known = walk.towards(side)
        if passage is None:
            return found, known
        found.append(passage)
        before, beyond = (passage.below, passage.above)[::side]
        walk = replace(walk, start=known, home=beyond)
        if len(found) >= most and beyond >= before:
            return found, known


def is_held(scene: Scene, hand: Hand, free: Knob, value: Rational) -> bool:
    """Whether from a value of a number on the hand holds the display by what it damps, whatever its mass, proven."""
    symbol = free.symbol
    if any(p.symbol == symbol for p in hand.parameters):
        hand = hand.with_values({symbol.name: value})
    elif _only_adds(scene.with_values({free.path: symbol}), symbol):
        scene = scene.with_values({free.path: value})
    else:
        return False
    found = sampled_passivity(scene)
    try:
        return found is not None and found.is_held_by(hand.b.value, hand.k.value)
    except UndecidedError:
        return False


def _only_adds(scene: Scene, symbol: Symbol) -> bool:
    """Whether a symbol adds mass, damping or stiffness behind the clock, and is nowhere else."""
    place, clock = clock_of(scene)
    felt = scene.rendering.H
    before = [x for effect in scene.effects[:place] for x in effect.matrix]
    if any(x.has(symbol) for x in (felt, *before, *clock.matrix, *(p.value for p in clock.parameters))):
        return False
    devices = [device(x) for x in scene.effects[place + 1 :] if any(y.has(symbol) for y in x.matrix)]
    slopes = [x.diff(symbol) for own in devices if own for x in own]
    return None not in devices and all(x.is_number and x >= 0 for x in slopes)
