"""Margins: by how much the rendered force may be larger, later or turned until the display shakes in a hand.

The force is that of the environment, or of ``[rendered]``, before all effects. With g of it the loop is A + g B = 0, linear in g,
however the force comes through the effects: they make a Moebius map of it. So g = -A/B on the imaginary axis, and

- *gain*: the nearest g below and above 1 at which the number of roots that shake changes, up to a thousandfold;
- *delay*: the least tau at which it does with g = exp(-s tau), up to a thousand seconds;
- *phase*: of all frequencies with |A/B| = 1 the least angle of -A/B: by so much the force may be turned at any one frequency.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from flint import acb, arb, ctx
from sympy import Expr, Integer, Rational

from haptisym.effects import delay as delayed
from haptisym.effects import series
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.dynamics import RealFunction, on_axis, squared_modulus
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, Way, in_unit, printed
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.sets import Domain, Piece, Point, ValueSet, Verdict
from haptisym.model.catalogue import Effect, Hand
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.stability.critical import critical
from haptisym.verbs.stability.loops import Loop, minus
from haptisym.verbs.stability.sampledmargins import delays, factors

MOST_GAIN, MOST_DELAY = 1000, 1000
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


def _gain_by_clock(scene: Scene, hand: Hand) -> tuple[Limit | None, Limit | None]:
    piece = _about(factors(scene, hand, _GAINS), Integer(1), ("factor", Integer(1)))
    return _limit(piece.first), _limit(piece.last)


def _delay_by_clock(scene: Scene, hand: Hand) -> Limit | None:
    return _limit(_about(delays(scene, hand, _DELAYS), Integer(0), ("ms", Rational(1, 1000))).last)


_GAINS = Domain(Rational(1, MOST_GAIN), Integer(MOST_GAIN))
_DELAYS = Domain(Integer(0), Integer(MOST_DELAY))


def _about(found: ValueSet, own: Expr, unit: tuple[str, Expr]) -> Piece:
    """The piece that holds about a value. UndecidedError where what comes next to it is not known, with what is."""
    piece, (name, size) = found.about(ExactNumber(own)), unit
    if piece.verdict is not Verdict.HOLDS:
        raise UndecidedError(piece.reason or "nothing is known of the loop as it is")
    for x in found.undecided:
        for end, is_next, word, way in (
            (piece.first, x.last, "most", Way.UP),
            (piece.last, x.first, "least", Way.DOWN),
        ):
            if end is not None and end == is_next:
                raise UndecidedError(f"at {word} {printed(in_unit(end.value, size), 4, way)} {name}; {x.reason}")
    return piece


def _limit(end: Point | None) -> Limit | None:
    return Limit(end.value, end.bindings[0].omega) if end is not None and end.bindings else None
