"""Margins: by how much the rendered force may be larger, later or turned in phase before the
display becomes unstable in a hand.

The force is that of the environment, or of ``[rendered]``, before all effects. With g of it the
loop is A + g B = 0, linear in g, however the force comes through the effects: they make a Moebius
map of it. So g = -A/B on the imaginary axis, and

- *gain*: the values of g about 1 for which it is stable, of a thousandth to a thousandfold;
- *delay*: the values of tau from 0 on for which it is, with g = exp(-s tau), up to a thousand
  seconds;
- *phase*: the angles below the least one of -A/B at all frequencies with |A/B| = 1: by so much the
  force may be turned at any one frequency.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from flint import acb, arb, ctx
from sympy import Integer, Rational

from haptisym.effects import delay as delayed
from haptisym.effects import series
from haptisym.judge.bindings import STABLE, STEADY, Binding, Kind, stable_in
from haptisym.judge.crossings import Criterion
from haptisym.kernel.asymptoticsign import Sense, sign_without_zeros
from haptisym.kernel.dynamics import RealFunction, on_axis, squared_modulus
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.objects import Shown
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, ordered
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import chart
from haptisym.kernel.sets import (
    STOPPED,
    CriticalValue,
    CriticalValues,
    Domain,
    Question,
    SingleValue,
    ValueSet,
    solve,
)
from haptisym.model.catalogue import Effect, Hand
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene, clocks
from haptisym.verbs.stability.held import drifts
from haptisym.verbs.stability.limits import stable_values
from haptisym.verbs.stability.loops import Loop, minus
from haptisym.verbs.stability.sampledmargins import delays, factors

MOST_GAIN, MOST_DELAY = 1000, 1000
GAINS = Domain(Rational(1, MOST_GAIN), Integer(MOST_GAIN))
DELAYS = Domain(Integer(0), Integer(MOST_DELAY))
ANGLES = Domain(Integer(0), Integer(180))
"""What is searched: factors, delays in s, and angles in degrees."""
_ZERO, _ONE = ExactNumber(Integer(0)), ExactNumber(Integer(1))
_FACTOR = series("g_margin", parameters={"g_margin": 1}, name="margin-of-gain")
_LATE = delayed(0, name="margin-of-delay")


@dataclass(frozen=True, repr=False)
class Margins(Shown):
    """The margins of a display in a hand: the factors on the rendered force, the delays (s) and the
    angles (degrees) of it for which the display is stable.

    Each as far as the ends next to the present value: a factor of 1, no delay, no angle. ``phase``
    : None with a clock.
    """

    gain: ValueSet
    delay: ValueSet
    phase: ValueSet | None = None

    def _line(self) -> str:
        angle = "" if self.phase is None else f", phase {self.phase._line()} deg"
        return f"gain {self.gain._line()}, delay {self.delay._line()} s{angle}"

    @property
    def below(self) -> SingleValue | None:
        """The factor down to which it is stable; None where there is no end, or none that is
        known."""
        return self.gain.end(_ONE, -1)

    @property
    def above(self) -> SingleValue | None:
        """The factor up to which it is stable."""
        return self.gain.end(_ONE, 1)

    @property
    def undecided(self) -> tuple[tuple[str, str], ...]:
        """Pairs of the name of a margin and the reason why it is undecided, maybe on one side."""
        sets = (
            ("gain", self.gain, _ONE),
            ("delay", self.delay, _ZERO),
            ("phase_deg", self.phase, _ZERO),
        )
        left = (
            (name, x.unknown(own, side))
            for name, x, own in sets
            if x is not None
            for side in (-1, 1)
        )
        return tuple(
            dict.fromkeys((name, piece.reason) for name, piece in left if piece is not None)
        )

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        below, above = self.below, self.above
        # The nearer of the two by ratio: above/1 against 1/below.
        nearest = (
            below
            if below and not (above and float(above.value) * float(below.value) < 1)
            else above
        )
        late = self.delay.end(_ZERO, 1)
        return {
            "gain": {"below": _float(below), "above": _float(above), "omega": _omega(nearest)},
            "delay": {"above": _float(late), "omega": _omega(late)},
            "phase_deg": None if self.phase is None else _float(self.phase.end(_ZERO, 1)),
            "searched": {"gain": _ends(GAINS), "delay": _ends(DELAYS)},
        }


def _float(x: SingleValue | None) -> float | None:
    return None if x is None else float(x.value)


def _omega(x: SingleValue | None) -> float | None:
    omega = None if x is None else x.bindings[0].omega
    return None if omega is None else float(omega)


def _ends(x: Domain) -> list[float]:
    return [float(end) for end in (x.low, x.high) if end is not None]


def margins(scene: Scene, hand: Hand) -> Margins:
    """The margins of a display that is stable in a hand, or only drifts.

    >>> from haptisym.model.catalogue import hands
    >>> from haptisym.model.scenefile import load_scene
    >>> margins(load_scene("delayed-spring"), hands["postural-arm"])
    <Margins gain 0.00100000 to 1.99852, delay 0 to 0.0665486 s, phase 0 to 59.1051 deg>
    """
    if (scene.rendered or scene.environment).H.is_zero:
        # A force that is zero stays zero, however large, late or turned.
        return Margins(*(ValueSet.all_of(x, holds=True) for x in (GAINS, DELAYS, ANGLES)))
    if clocks(scene):
        return Margins(
            _told(GAINS, lambda: factors(scene, hand, GAINS)),
            _told(DELAYS, lambda: delays(scene, hand, DELAYS)),
        )
    criterion = stable_in(hand, STEADY if drifts(scene, hand) else STABLE)
    gain, delay = (
        stable_values(*_opened(scene, hand, effect), asked, criterion, near=True)
        for effect, asked in ((_FACTOR, GAINS), (_LATE, DELAYS))
    )
    return Margins(gain, delay, _told(ANGLES, lambda: _phase(scene, hand, criterion)))


def _opened(scene: Scene, hand: Hand, effect: Effect) -> tuple[Scene, Hand, Knob]:
    """The scene with one more effect, nearest the environment, and the parameter of that effect.

    A factor or a delay of the rendered force is thus a parameter like any other, and its limits are
    those of ``stable_values``.
    """
    own = replace(scene, effects=(effect, *scene.effects))
    knob = own.knobs[f"effects.{effect.name}.{effect.parameters[0].key}"]
    return own, hand, replace(knob, rule=Rule.NONNEGATIVE)


def _phase(scene: Scene, hand: Hand, criterion: Criterion) -> ValueSet:
    """The phase margin, as a set of angles from 0 up: to the least angle at a frequency with |A/B|
    = 1."""
    found = _turned(Loop.of(*_opened(scene, hand, _FACTOR)), criterion)
    return _up_to(ANGLES, min(found, key=lambda x: float(x.value), default=None))


def _turned(loop: Loop, criterion: Criterion) -> list[CriticalValue]:
    """The angles of the loop at all frequencies with |A/B| = 1, each with its frequency.

    UndecidedError where such frequencies may be without end, or one is only touched.
    """
    if len(loop.coefficients) != 2:
        return []
    ratio = RationalFunction(loop.ring, loop.coefficients[0], loop.coefficients[1]).reduced()
    condition = minus(squared_modulus(ratio).function, Integer(1))
    settled = sign_without_zeros(condition)
    if settled.sense not in (Sense.POSITIVE, Sense.NEGATIVE):
        raise UndecidedError("where the loop has a gain of 1: it may be at ever higher frequencies")
    table = chart(
        {"": RealFunction(condition.reduced())}, Integer(0), max(settled.radius, Integer(1))
    )
    if any("" in x.undecided for x in table.points):
        raise UndecidedError("whether the loop comes to a gain of 1")
    response = on_axis(ratio)
    places = [x.omega for x in table.points[1:] if x.orders.get("", 0) > 0]
    parts = response.real, response.imag
    return [CriticalValue(Turned(parts, x), (Binding(criterion, x, Kind.AXIS),)) for x in places]


def _up_to(asked: Domain, limit: CriticalValue | None) -> ValueSet:
    """The set of values from the low end up to a limit; all values where there is none."""
    question = Question(
        lambda x: limit is None or ordered(ExactNumber(x), limit.value) > 0,
        asked.low,
        lambda: [CriticalValues([] if limit is None else [limit])],
        lambda _: False,
    )
    return solve(question, asked, near=True)


@dataclass(frozen=True, repr=False)
class Turned(RealNumber):
    """The angle, degrees, by which A/B at a frequency is off -1: |arg(-A/B)|, from 0 to 180."""

    ratio: tuple[RealFunction, RealFunction]
    omega: RealNumber

    def ball(self, bits: int) -> Ball:
        with ctx.workprec(bits + 32):
            x = self.omega.ball(bits + 32)
            real, imag = (part.ball(x) for part in self.ratio)
            # By the half plane that keeps away from the cut of the argument, where a ball would
            # hold all angles.
            angle = (
                abs(acb(real, imag).arg()) if real > 0 else arb.pi() - abs(acb(-real, imag).arg())
            )
            return (arb.pi() - angle) * 180 / arb.pi()


def _told(asked: Domain, ask: Callable[[], ValueSet]) -> ValueSet:
    """A set of values; all of it undecided where that is not known."""
    try:
        return ask()
    except LimitError:
        return ValueSet.all_of(asked, holds=None, reason=STOPPED)
    except UndecidedError as error:
        return ValueSet.all_of(asked, holds=None, reason=str(error))
