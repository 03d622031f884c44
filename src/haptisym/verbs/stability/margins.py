"""Margins: by how much the rendered force may be larger, later or turned until the display shakes in a hand.

The force is that of the environment, or of ``[rendered]``, before all effects. With g of it the loop is A + g B = 0, linear in g,
however the force comes through the effects: they make a Moebius map of it. So g = -A/B on the imaginary axis, and

- *gain*: the nearest g below and above 1 at which the number of roots that shake changes, up to a thousandfold;
- *delay*: the least tau at which it does with g = exp(-s tau), up to a thousand seconds;
- *phase*: of all frequencies with |A/B| = 1 the least angle of -A/B: by so much the force may be turned at any one frequency.

With a clock the factor stands before the controller, and the delay in what moves: from one whole number of samples to the next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor, pi
from typing import Any, TypeAlias, TypeVar

from flint import acb, arb, arb_poly, ctx
from sympy import Integer, Rational, Symbol

from haptisym.effects import delay as delayed
from haptisym.effects import series
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction, on_axis, squared_modulus
from haptisym.kernel.enclosures import over_circle
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, RealNumber, Way, printed
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.sampledloop import SampledLoop
from haptisym.model.catalogue import Effect, Hand
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.stability.critical import critical
from haptisym.verbs.stability.loops import Loop, minus
from haptisym.verbs.stability.sampled import Opened, Walk, loop_of, series_alone

MOST_GAIN, MOST_DELAY = 1000, 1000
_NONE = "no limit found within it"
_NOTHING = Fraction(0)
_FACTOR = series("g_margin", parameters={"g_margin": 1}, name="margin-of-gain")
_LATE = delayed(0, name="margin-of-delay")


@dataclass(frozen=True)
class Limit:
    """A ``value`` at which the display shakes, and at what frequency ``omega``, rad/s; None where roots come from infinity."""

    value: RealNumber
    omega: RealNumber | None


@dataclass(frozen=True, repr=False)
class Margins(Shown):
    """Of a display in a hand: ``below``, ``above``: factors, ``delay`` in s, ``phase`` in degrees; None where there is none.

    ``undecided`` : by the name of a margin why it is not known.
    """

    below: Limit | None = None
    above: Limit | None = None
    delay: Limit | None = None
    phase: Limit | None = None
    undecided: tuple[tuple[str, str], ...] = ()

    def _line(self) -> str:
        return f"gain {_float(self.below)} to {_float(self.above)}, delay {_float(self.delay)} s, phase {_float(self.phase)} deg"

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        nearest = self.above
        if self.below and not (nearest and float(nearest.value) * float(self.below.value) < 1):
            nearest = self.below
        omega = nearest and nearest.omega
        late = self.delay and self.delay.omega
        return {
            "gain": {"below": _float(self.below), "above": _float(self.above), "omega": omega and float(omega)},
            "delay": {"above": _float(self.delay), "omega": late and float(late)},
            "phase_deg": _float(self.phase),
        }


def _float(x: Limit | None) -> float | None:
    return None if x is None else float(x.value)


T = TypeVar("T")
Phis: TypeAlias = "list[tuple[float, float]]"


def margins(scene: Scene, hand: Hand) -> Margins:
    """Of a display that does not shake in a hand.

    >>> from haptisym.model.catalogue import hands
    >>> from haptisym.model.scenefile import load_scene
    >>> found = margins(load_scene("delayed-spring"), hands["postural-arm"])
    >>> found.above.value.digits(5), found.delay.value.digits(4), found.phase.value.digits(4)
    ('1.9985', '0.06655', '59.11')
    """
    if (scene.rendered or scene.environment).H.is_zero:
        return Margins()
    left: list[tuple[str, str]] = []

    def told(name: str, ask: Callable[[], T], none: T) -> T:
        try:
            return ask()
        except (UndecidedError, LimitError) as error:
            left.append((name, str(error)))
            return none

    gain, delay = (_gain_by_clock, _delay_by_clock) if clocks(scene) else (_gain, _delay)
    neither: tuple[Limit | None, Limit | None] = (None, None)
    below, above = told("gain", lambda: gain(scene, hand), neither)
    late = told("delay", lambda: delay(scene, hand), None)
    phase = None if clocks(scene) else told("phase_deg", lambda: _phase(scene, hand), None)
    return Margins(below, above, late, phase, tuple(left))


# Without a clock: the same scene with one more effect, nearest the environment


def _opened(scene: Scene, effect: Effect) -> tuple[Scene, Knob]:
    """The scene with an effect before all others, and the number of that."""
    own = replace(scene, effects=(effect, *scene.effects))
    return own, replace(own.knobs[f"effects.{effect.name}.{effect.parameters[0].key}"], rule=Rule.NONNEGATIVE)


def _critical(scene: Scene, hand: Hand, effect: Effect) -> list[Limit]:
    """The values of the number of such an effect at which the count changes, in order."""
    own, knob = _opened(scene, effect)
    near = critical(own, hand, knob)
    if near.reason and len(near.found) < 2:
        raise UndecidedError(near.reason)
    return [Limit(x.value, x.omega) for x in near.found]


def _gain(scene: Scene, hand: Hand) -> tuple[Limit | None, Limit | None]:
    found = _critical(scene, hand, _FACTOR)
    return _within([x for x in found if float(x.value) < 1]), _within([x for x in found if float(x.value) > 1])


def _within(found: list[Limit]) -> Limit | None:
    return next((x for x in found if 1 / MOST_GAIN <= float(x.value) <= MOST_GAIN), None)


def _delay(scene: Scene, hand: Hand) -> Limit | None:
    found = _critical(scene, hand, _LATE)
    return next((x for x in found if 0 <= float(x.value) <= MOST_DELAY), None)


def _phase(scene: Scene, hand: Hand) -> Limit | None:
    """Where |A/B| = 1 the least angle."""
    own, knob = _opened(scene, _FACTOR)
    loop = Loop.of(own, hand, knob)
    if len(loop.powers) != 2:
        return None
    ratio = RationalFunction(loop.ring, loop.powers[0], loop.powers[1]).reduced()
    condition = minus(squared_modulus(ratio).function, Integer(1))
    settled = asymptotic_sign(condition)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise UndecidedError("where the loop has a gain of 1: it may be at ever higher frequencies")
    table = chart({"": RealFunction(condition.reduced())}, Integer(0), max(settled.radius, Integer(1)))
    if any("" in x.undecided for x in table.points):
        raise UndecidedError("whether the loop comes to a gain of 1")
    response = on_axis(ratio)
    places = [x.omega for x in table.points[1:] if x.orders.get("", 0) > 0]
    found = [Limit(Turned((response.real, response.imag), x), x) for x in places]
    return min(found, key=lambda x: float(x.value), default=None)


@dataclass(frozen=True, repr=False)
class Turned(RealNumber):
    """The angle, degrees, of the loop A/B from 1 + A/B = 0, at a frequency: that of -A/B, whatever its sign."""

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with ctx.workprec(bits + 32):
            x = self.omega.ball(bits + 32)
            real, imag = (part.ball(x) for part in self.ratio)
            angle = abs(acb(real, imag).arg()) if real > 0 else arb.pi() - abs(acb(-real, imag).arg())
            return (arb.pi() - angle) * 180 / arb.pi()


# With a clock


def _loop(scene: Scene, hand: Hand) -> SampledLoop | None:
    """None where nothing is rendered."""
    if not series_alone(scene):
        raise UndecidedError("margins of a loop with more than series effects before the clock")
    loop = loop_of(scene, hand)
    return loop if any(loop.above) and any(x for _, row in loop.plant.terms for x in row) else None


def _gain_by_clock(scene: Scene, hand: Hand) -> tuple[Limit | None, Limit | None]:
    loop = _loop(scene, hand)
    if loop is None:
        return None, None
    g = Symbol("g_margin", positive=True)
    opened = Opened(replace(loop, above=tuple(g * x for x in loop.above)), g)
    home = opened.count(Integer(1))[0]
    ends = Fraction(1, MOST_GAIN), Fraction(MOST_GAIN)
    walk = Walk(opened, Fraction(1), home, Rule.POSITIVE, ends)
    below, above = (_passed(walk, side) for side in (-1, 1))
    return below, above


def _passed(walk: Walk, side: int) -> Limit | None:
    passage, known = walk.towards(side)
    way = Way.DOWN if side > 0 else Way.UP
    if passage is None and (walk.ends[side > 0] - known) * side > 0:
        raise UndecidedError(
            f"searched {'up' if side > 0 else 'down'} to a factor of {printed(known, 4, way)}, {_NONE}"
        )
    return None if passage is None else Limit(passage.value, passage.omega)


def _delay_by_clock(scene: Scene, hand: Hand) -> Limit | None:
    loop = _loop(scene, hand)
    if loop is None:
        return None
    if not loop.T.is_Rational:
        raise UndecidedError("how much delay is allowed: the sampling period is no rational number")
    late = Symbol("tau_margin", positive=True)
    plant = replace(loop.plant, terms=tuple((lag + late, row) for lag, row in loop.plant.terms))
    return _Later(Opened(replace(loop, plant=plant), late), Fraction(int(loop.T.p), int(loop.T.q))).first()


@dataclass(frozen=True)
class _Later:
    """A loop that is later by d whole samples and a share theta of one: z^d Q(z; theta) + N(z; theta) = 0.

    On z = exp(j phi) that asks for |Q| = |N|, whatever d is, and then d phi is an angle of -N/Q: cells of theta and phi tell the
    least d at which they allow it. Before that no root is on the circle; from there on thin cells close in on the first theta.
    """

    opened: Opened
    T: Fraction

    def first(self) -> Limit | None:
        """The least delay at which a root comes to the circle; None where none does, up to a thousand seconds."""
        most = int(MOST_DELAY / self.T)
        pieces = [*self._pieces()]
        parts = [
            (x, a + (b - a) * i / _PARTS, a + (b - a) * (i + 1) / _PARTS) for x, a, b in pieces for i in range(_PARTS)
        ]
        known = [(d, (a, b), part[0]) for part in parts for d, a, b in self._allowed(*part, _FINE, [(0.0, _PI)])]
        least = min((d for d, _, _ in known), default=most)
        if _DEEPEST < least < most:
            raise self._searched(least)
        for d in range(least, min(most, least + _MORE)):
            for loop, low, high in pieces:
                phis = [*dict.fromkeys(phi for _, phi, own in known if own is loop)]
                if (found := self._in(loop, low, high, d, phis)) is not None:
                    return found
        if least < most:
            raise self._searched(least + _MORE)
        return None

    def _searched(self, samples: int, more: Fraction = _NOTHING, why: str = "") -> UndecidedError:
        up_to = printed(1000 * (self.T * samples + more), 4, Way.DOWN)
        return UndecidedError(f"searched up to {up_to} ms, {_NONE}{f': {why}' if why else ''}")

    def _pieces(self) -> Iterator[tuple[Opened, Fraction, Fraction]]:
        """Of one period those within which all delays keep their whole samples."""
        at = Fraction(0)
        while at < self.T:
            loop, last = self.opened.piece(at, self.T, 1)
            yield loop, at, last
            at = last

    def _allowed(
        self, loop: Opened, low: Fraction, high: Fraction, finest: float, phis: Phis, only: int | None = None
    ) -> Iterator[tuple[int, float, float]]:
        """Cells of phi with a root that may be on the circle, and with how many whole samples at least, or ``only`` so many."""
        with ctx.workprec(_BITS):
            q = _between(low, high)
            lines = over_circle(lambda x: loop.loop.sides({loop.symbol: x})[0].coeffs(), q.mid(), q.rad())
            N, slope, _ = (arb_poly(list(x)) for x in zip(*lines, strict=True))
            Q, either = loop.loop.sides({loop.symbol: q})[1], arb(0, 1)
            waiting, looked = [*phis], 0
            while waiting:
                a, b = waiting.pop()
                looked += 1
                if looked > _MOST_CELLS:
                    raise UndecidedError("how much delay is allowed: too many cells of frequency")
                phi = arb(a).union(arb(b))
                above, below = _all_over(N, phi) + _all_over(slope, phi) * either, _all_over(Q, phi)
                if not abs(above).overlaps(abs(below)):
                    continue
                angle = arb("nan") if below.contains(0) else _angle(-above / below)
                d = _least(angle, a, b, only)
                if d is None:
                    continue
                is_sharp = below.abs_upper() < 2 * below.abs_lower()  # not next to a zero of Q, of which there are few
                if b - a > (finest * max(b, _SLOWEST) if is_sharp else _SHARPEST):
                    waiting += [(a, (a + b) / 2), ((a + b) / 2, b)]
                else:
                    yield d, a, b

    def _in(self, loop: Opened, low: Fraction, high: Fraction, d: int, phis: Phis) -> Limit | None:
        """The first in a piece that is later by so many samples, with as many roots as before at its beginning."""
        late = Opened(replace(loop.loop, above=(*[Integer(0)] * d, *loop.loop.above)), loop.symbol)
        waiting, why = Waiting([(low, high, phis)], most=_MOST_CUTS), "too many pieces of delay"
        try:
            for start, end, whole in waiting:
                width = float((end - start) / self.T)
                left = [
                    (a, b) for _, a, b in self._allowed(loop, start, end, min(_COARSE, width / (4 * d + 4)), whole, d)
                ]
                if not left:
                    continue
                if width <= _FINEST:
                    home, count = (late.count(Rational(x.numerator, x.denominator))[0] for x in (start, end))
                    if home != count:
                        found = Walk(late, start, home, Rule.POSITIVE, (start, end)).between(start, end, count)
                        return Limit(_Sum(found.value, Rational(self.T.numerator * d, self.T.denominator)), found.omega)
                    if width < _FINEST**2:
                        raise UndecidedError("whether a root comes to the unit circle and goes back")
                middle = Fraction(float((start + end) / 2))
                waiting.add((start, middle, left), (middle, end, left))
        except UndecidedError as error:
            why = str(error)
        if waiting.rest:
            raise self._searched(d, min(start for start, _, _ in waiting.rest), why)
        return None


def _all_over(polynomial: Any, phi: Ball) -> acb:
    """A polynomial in z - 1 all over a piece of the circle, by its slope: powers of a ball grow faster than what they are of."""
    x, middle = (acb(-2 * (angle / 2).sin() ** 2, angle.sin()) for angle in (phi, phi.mid()))
    return polynomial(middle) + polynomial.derivative()(x) * (x - middle)


def _between(low: Fraction, high: Fraction) -> Ball:
    return (arb(low.numerator) / low.denominator).union(arb(high.numerator) / high.denominator)


_PI = 3.1415926535897936  # a little more
_COARSE, _FINE, _FINEST, _SLOWEST, _MORE, _TURNS, _PARTS = 2.0**-6, 2.0**-12, 2.0**-16, 2.0**-14, 16, 64, 4
_SHARPEST = 2.0**-40
_BITS, _DEEPEST, _MOST_CELLS, _MOST_CUTS = 128, 128, 20_000, 1000


def _angle(x: acb) -> Ball:
    """Of a number, all over its ball: about pi where it is about -1, not both pi and -pi."""
    return x.arg() if not x.real < 0 else (-x).arg() + arb.pi()


def _least(angle: Ball, a: float, b: float, only: int | None) -> int | None:
    """The least whole d >= 0 for which d phi may be an angle, phi from a to b, but for whole turns; None where there is none."""
    if not angle.is_finite() or angle.rad() > 1:
        return only or 0
    first, last = float(angle.lower()) - 1e-9, float(angle.upper()) + 1e-9
    if only is not None:
        turns = ceil((only * a - last) / (2 * pi) - 1e-12), floor((only * b - first) / (2 * pi) + 1e-12)
        return only if turns[0] <= turns[1] else None
    low = 0
    for k in range(_TURNS):
        low = max(0, ceil((first + 2 * pi * k) / b))
        if last + 2 * pi * k >= low * a:
            return low
    return low


@dataclass(frozen=True, repr=False)
class _Sum(RealNumber):
    """Of a number and a rational one."""

    first: RealNumber
    more: Rational

    def ball(self, bits: int) -> Ball:
        with ctx.workprec(bits + 32):
            return self.first.ball(bits + 8) + arb(int(self.more.p)) / int(self.more.q)
