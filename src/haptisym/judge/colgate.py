"""Whether a sampled loop is passive: Colgate and Schenkel's condition, one polynomial sign in
tan(theta/2).

The device is m s^2 + b s + k; its position is sampled every T, passes a controller C(z), and the
force is held for T. The display is passive where, for 0 < theta <= pi::

    b > T/2 Re((1 - exp(-j theta)) C(exp(j theta)))/(1 - cos theta),

b >= 0, and the stiffness at rest, C(1) + k, is not negative: a negative one pushes a softer hand
away, whatever the damping. With exp(j theta) = (1 + s)/(1 - s), s = j tan(theta/2), the right-hand
side is Re((s - 1)/s C) T/2, a frequency response like any other. Near theta = pi the tangent is
infinite; there the cotangent is the variable.

Source: Colgate and Schenkel (1997). Derivation: 18_sampled_passivity. Begin with
``sampled_passivity``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
from flint import arb
from sympy import Expr, Integer

from haptisym.judge.peaks import LargestOf, LargestValue, supremum
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, ordered
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import is_stable
from haptisym.kernel.roots import chart, sign_of_number
from haptisym.model.catalogue import (
    BACK,
    CLOCKS,
    SAMPLED_LOOP,
    DeviceImpedance,
    Effect,
    controller,
    device,
)
from haptisym.model.scene import Scene

_FORCE = "the sampled force depends on more than the sampled position"
_TEN = "something other than mass, spring and damper lies between sampler and hand"


@dataclass(frozen=True, repr=False)
class ClockAngle(RealNumber):
    """The angle theta = 2 atan(t) of a tangent t, or pi - 2 atan(t) if ``is_far``, where t is the
    cotangent."""

    tangent: RealNumber
    is_far: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            angle = 2 * self.tangent.ball(bits).atan()
            return arb.pi() - angle if self.is_far else angle


@dataclass(frozen=True)
class SampledPassivity:
    """Colgate and Schenkel's condition for a display sampled every ``T``, s, whose device has this
    ``damping``, N s/m.

    ``sides`` : the right-hand side as a function of tan(theta/2), and of cot(theta/2), each on [0,
    1]; None where the condition does not apply, for that ``reason``. ``is_settled`` : whether the
    controller's own poles lie inside the unit circle. ``at_rest`` : the static stiffness C(1) + k,
    N/m, where it is settled.
    """

    T: Expr
    damping: Expr = Integer(0)
    sides: tuple[RealFunction, RealFunction] | None = None
    is_settled: bool = True
    reason: str = ""
    at_rest: Expr = Integer(0)

    @property
    def asks_nothing(self) -> bool:
        """Whether the right-hand side is negative at every angle, so that the controller needs no
        damping."""
        return self.needed is not None and ordered(self.needed.value, ExactNumber(Integer(0))) > 0

    @property
    def pushes(self) -> bool:
        """Whether the static stiffness is negative, so that a hand without stiffness is pushed
        away: then no damping is enough."""
        return sign_of_number(self.at_rest) < 0

    @cached_property
    def needed(self) -> LargestValue | None:
        """The largest right-hand side, N s/m, which the device's damping must exceed, and its
        theta. None where it is unbounded, and where the condition does not apply."""
        return self._largest(Integer(0))

    def _largest(self, less: Expr) -> LargestValue | None:
        """The largest value of the right-hand side less a number, and its angle; None as for
        ``needed``."""
        # Angles up to pi/2 by the tangent, the others by the cotangent: both charts end at 1.
        if self.sides is None:
            return None
        shifted = (RealFunction((f.function - f.axis.convert(less)).reduced()) for f in self.sides)
        near, far = (supremum(f, Integer(0), Integer(1)) for f in shifted)
        if near is None or far is None:
            return None
        # Floats choose the half with the angle; the value is the larger of both in any case.
        best, is_far = max(((near, False), (far, True)), key=lambda x: float(x[0].value))
        assert best.omega is not None
        return LargestValue(LargestOf((near.value, far.value)), ClockAngle(best.omega, is_far))

    @cached_property
    def passive(self) -> bool | None:
        """Whether the display is passive: the device's damping exceeds ``needed``, and the static
        stiffness is not negative.

        None where the condition does not apply, or the controller is not settled.
        """
        # One condition that fails is enough for False. For True the controller's own poles must lie
        # inside the unit circle as well, of which conditions on frequencies say nothing.
        if self.sides is None:
            return None
        if self.needed is None or self.pushes or sign_of_number(self.damping) < 0:
            return False
        if not self.is_settled:
            return None
        # A controller that holds no force leaves the device, which need not damp: a free mass is
        # passive. Otherwise the inequality is strict at every angle.
        return all(f.is_zero or self._exceeds(f) for f in self.sides)

    @property
    def hand_needed(self) -> RealNumber | None:
        """The damping of a hand that compensates for what the device lacks, N s/m, at least 0: with
        it the hand is stable for any mass and stiffness.

        None where no damping is enough, or that is undecided.
        """
        if self.passive:
            return ExactNumber(Integer(0))
        if self.pushes:
            return None
        missing = self._largest(self.damping)
        if not (missing and self.needed and self.is_settled):
            return None
        # Where the controller needs none, the hand compensates for a negative damping of the device
        # alone: the total must not be negative.
        return ExactNumber(-self.damping) if self.asks_nothing else missing.value

    def is_held_by(self, damping: Expr, stiffness: Expr) -> bool:
        """Whether no root lies on the unit circle for a hand with this damping, N s/m, and
        stiffness, N/m, or more of them, whatever its mass. False proves nothing.

        The total damping must be positive: between two samples a motion may go on that none of them
        sees.
        """
        if self.sides is None or not self.is_settled:
            return False
        totals = (self.at_rest + stiffness, self.damping + damping)
        if any(sign_of_number(x) <= 0 for x in totals):
            return False
        missing = self._largest(self.damping)
        return missing is not None and ordered(missing.value, ExactNumber(damping)) > 0

    def _exceeds(self, f: RealFunction) -> bool:
        """Whether the damping exceeds one form of the right-hand side at all angles of it."""
        margin = RealFunction((f.axis.convert(self.damping) - f.function).reduced())
        table = chart({"": margin}, Integer(0), Integer(1))
        if table.undecided:
            raise UndecidedError(
                "whether a device has just the damping that its sampled loop needs"
            )
        # Positive at every point and between all of them; outside of the chart there are no signs.
        signs: set[int | None] = set()
        for p in table.points:
            signs |= {*p.at.values(), *p.before.values(), *p.after.values()}
        return signs - {None} == {1}

    def row(self, digits: int) -> dict[str, Any]:
        """The condition as a part of a document, SI."""
        best = self.needed
        rest = {"stiffness_at_rest": float(self.at_rest)} if self.pushes else {}
        needed = {
            "damping_needed": None if best is None else float(best.value),
            "digits": None if best is None else best.value.digits(digits),
            "theta": None if best is None or best.omega is None else float(best.omega),
        }
        why = {"reason": self.reason} if self.reason else {}
        return {"T": float(self.T), "passive": self.passive, **needed, **rest, **why}


def sampled_passivity(scene: Scene) -> SampledPassivity | None:
    """Colgate and Schenkel's condition for a scene with numbers; None where nothing in it is
    sampled.

    >>> from haptisym import effects, environments
    >>> device = effects.shunt(m="0.04", b="0.8")
    >>> wall = Scene(environments.kelvin_voigt(1500, "0.04"), (effects.sampled_loop("1 ms", "backward-difference"), device))
    >>> found = sampled_passivity(wall)                                              # K T/2 + B
    >>> found.needed.value.digits(5), found.passive
    ('0.79000', True)
    """
    if not any(x.model in CLOCKS for x in scene.effects):
        return None
    loop = loop_of(scene)
    if isinstance(loop, SampledPassivity):
        return loop
    ring = Ring()
    inner = ring.convert(loop.C).reduced()
    # The map from z to s takes the unit circle to the imaginary axis, and z = -1 to infinity: a
    # pole there would be a numerator of higher degree.
    is_proper = inner.numerator.degrees()[0] <= inner.denominator.degrees()[0]
    settled = is_stable(inner) is True and is_proper
    reason = "" if settled else "the controller has a pole on or outside the unit circle"
    at_rest = loop.at_rest(ring)[0] if settled else Integer(0)
    return SampledPassivity(loop.T, loop.damping, loop.sides(ring), settled, reason, at_rest)


@dataclass(frozen=True)
class ColgateLoop:
    """A sampled loop: its period T, s, its controller C as a function of s = (z - 1)/(z + 1), and
    its device, SI; in numbers, or with a symbol."""

    T: Expr
    C: Expr
    damping: Expr
    mass: Expr = Integer(0)
    stiffness: Expr = Integer(0)

    def sides(self, ring: Ring) -> tuple[RealFunction, RealFunction]:
        """The right-hand side as a function of tan(theta/2), and of cot(theta/2)."""
        # With s = j cot(theta/2), 1/s is the conjugate of the former s, which has the same real
        # part: (s - 1)/s becomes 1 - s.
        forms = [
            self.T / 2 * (s - 1) / s * self.C,
            self.T / 2 * (1 - s) * self.C.xreplace({s: 1 / s}),
        ]
        near, far = (on_axis(ring.convert(f).reduced()).real for f in forms)
        return near, far

    def at_rest(self, ring: Ring) -> tuple[Expr, Expr]:
        """The static stiffness C(1) + k, and the same times the denominator of C(1), which vanishes
        where the controller integrates."""
        # z = 1 is s = 0: the lowest coefficients of both polynomials.
        inner = ring.convert(self.C).reduced()
        above, below = (
            next(iter(ring.coefficients(x)), Integer(0))
            for x in (inner.numerator, inner.denominator)
        )
        whole = (above + self.stiffness * below).expand()
        return (whole / below if below != 0 else whole), whole


def loop_of(scene: Scene) -> ColgateLoop | SampledPassivity:
    """The loop of a scene in which something is sampled; or, where the condition does not apply,
    the answer with its reason."""
    place = next(i for i, x in enumerate(scene.effects) if x.model in CLOCKS)
    clock = scene.effects[place]
    behind: Sequence[Effect] = scene.effects[place + 1 :]
    T = clock.parameters[0].value
    if clock.model == SAMPLED_LOOP:
        C = controller(clock).expression()
    elif place or (scene.rendered or scene.environment).H.has(s):
        return SampledPassivity(T, reason=_FORCE)
    else:
        C, behind = _held(scene, T, behind)
    impedance = _device(behind)
    if impedance is None:
        return SampledPassivity(T, reason=_TEN)
    # BACK is 1/z, one sample ago.
    C = C.xreplace({BACK: (1 - s) / (1 + s)})
    return ColgateLoop(T, C, impedance.b, impedance.m, impedance.k)


def _held(scene: Scene, T: Expr, behind: Sequence[Effect]) -> tuple[Expr, Sequence[Effect]]:
    """The controller of a spring whose force is sampled, with all delays of whole samples directly
    behind it; and the effects that are left."""
    C, left = (scene.rendered or scene.environment).H, list(behind)
    while left and left[0].model == "delay":
        # A delay of n samples is z^-n. Any other one is no function of z.
        count = left[0].parameters[0].value / T
        if not count.is_Integer:
            break
        C, left = C * BACK**count, left[1:]
    return C, left


def _device(effects: Sequence[Effect]) -> DeviceImpedance | None:
    """Mass, damping and stiffness between sampler and hand; None where there is something else, or
    a negative mass or stiffness. A symbol counts as not negative."""
    parts = [device(x) for x in effects]
    if None in parts:
        return None
    total = DeviceImpedance(*map(sum, zip(DeviceImpedance(), *filter(None, parts), strict=True)))
    known = [x for x in (total.m, total.k) if not x.free_symbols]
    return None if any(sign_of_number(x) < 0 for x in known) else total
