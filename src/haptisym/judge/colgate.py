"""Whether a sampled loop is passive: Colgate and Schenkel's condition, one polynomial sign in
tan(theta/2).

A device m s^2 + b s + k, its position sampled every T, a controller C(z), the force held: passive
    where, for 0 < theta <= pi, b > T/2 Re((1 - exp(-j theta)) C(exp(j theta)))/(1 - cos theta), b
    >= 0, and its stiffness at rest, C(1) + k, is not negative: else it pushes a softer hand away,
    whatever damps.
With exp(j theta) = (1 + s)/(1 - s), s = j tan(theta/2), the right-hand side is Re((s - 1)/s C) T/2:
a response like any other.
Source: Colgate and Schenkel (1997). Derivation: 18_sampled_passivity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
from flint import arb
from sympy import Expr, Integer

from haptisym.judge.peaks import Greatest, Largest, greatest
from haptisym.kernel.dynamics import RealFunction, Ring, on_axis
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber
from haptisym.kernel.rings import s
from haptisym.kernel.rootcount import is_stable
from haptisym.kernel.roots import chart, ordered, sign_of_number
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
    """theta = 2 atan(t), or pi less that."""

    tangent: RealNumber
    is_far: bool = False

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            found = 2 * self.tangent.ball(bits).atan()
            return arb.pi() - found if self.is_far else found


@dataclass(frozen=True)
class SampledPassivity:
    """Colgate and Schenkel's condition for a display of period ``T``, s, whose device has this
    ``damping``.

    ``sides`` : its right-hand side as a function of tan(theta/2), and of cot(theta/2); None where
    the condition does not apply, for that ``reason``. ``is_settled`` : whether the controller's own
    poles lie inside the unit circle. ``at_rest`` :
    the stiffness of controller and device for what does not move, where it is settled.
    """

    T: Expr
    damping: Expr = Integer(0)
    sides: tuple[RealFunction, RealFunction] | None = None
    is_settled: bool = True
    reason: str = ""
    at_rest: Expr = Integer(0)

    @property
    def asks_nothing(self) -> bool:
        """Whether what the controller asks of damping is negative at every angle."""
        return self.needed is not None and ordered(self.needed.value, ExactNumber(Integer(0))) > 0

    @property
    def pushes(self) -> bool:
        """Whether it pushes away what is held by no stiffness: then no damping is enough."""
        return sign_of_number(self.at_rest) < 0

    @cached_property
    def needed(self) -> Greatest | None:
        """The largest right-hand side: the damping that the device must exceed, and theta. None
        where nothing bounds it."""
        return self._largest(Integer(0))

    def _largest(self, less: Expr) -> Greatest | None:
        """Of the right-hand side less a number."""
        if self.sides is None:
            return None
        shifted = (RealFunction((f.function - f.axis.convert(less)).reduced()) for f in self.sides)
        near, far = (greatest(f, Integer(0), Integer(1)) for f in shifted)
        if near is None or far is None:
            return None
        best = max(((near, False), (far, True)), key=lambda x: float(x[0].value))
        assert best[0].omega is not None
        return Greatest(Largest((near.value, far.value)), ClockAngle(best[0].omega, best[1]))

    @cached_property
    def passive(self) -> bool | None:
        """Whether the device's damping exceeds that, and nothing is pushed away: then the display
        is passive.

        None where not decided.
        """
        if self.sides is None:
            return None
        if self.needed is None or self.pushes or sign_of_number(self.damping) < 0:
            return False
        if not self.is_settled:
            return None
        # a controller that holds no force leaves the device, which need not damp: a free mass is
        # passive
        return all(f.is_zero or self._exceeds(f) for f in self.sides)

    @property
    def hand_needed(self) -> RealNumber | None:
        """The damping of a hand that makes up for what the device lacks, at least 0: with it any
        mass and stiffness will do.

        None where none does, or that is not decided.
        """
        if self.passive:
            return ExactNumber(Integer(0))
        if self.pushes:
            return None
        found = self._largest(self.damping)
        if not (found and self.needed and self.is_settled):
            return None
        return ExactNumber(-self.damping) if self.asks_nothing else found.value

    def is_held_by(self, damping: Expr, stiffness: Expr) -> bool:
        """Whether no root is on the unit circle in a hand that damps so and is so stiff, or more,
        whatever its mass.

        Something must damp: between two samples a motion may go on that none of them sees.
        """
        if self.sides is None or not self.is_settled:
            return False
        if any(sign_of_number(x) <= 0 for x in (self.at_rest + stiffness, self.damping + damping)):
            return False
        found = self._largest(self.damping)
        return found is not None and ordered(found.value, ExactNumber(damping)) > 0

    def _exceeds(self, f: RealFunction) -> bool:
        table = chart(
            {"": RealFunction((f.axis.convert(self.damping) - f.function).reduced())},
            Integer(0),
            Integer(1),
        )
        if table.undecided:
            raise UndecidedError(
                "whether a device has just the damping that its sampled loop needs"
            )
        signs = {
            x
            for p in table.points
            for x in (*p.at.values(), *p.before.values(), *p.after.values())
            if x is not None
        }
        return signs == {1}

    def row(self, digits: int) -> dict[str, Any]:
        """As documents have it."""
        best = self.needed
        rest = {"stiffness_at_rest": float(self.at_rest)} if self.pushes else {}
        told = {
            "damping_needed": None if best is None else float(best.value),
            "digits": None if best is None else best.value.digits(digits),
            "theta": None if best is None or best.omega is None else float(best.omega),
        }
        why = {"reason": self.reason} if self.reason else {}
        return {"T": float(self.T), "passive": self.passive, **told, **rest, **why}


def sampled_passivity(scene: Scene) -> SampledPassivity | None:
    """Colgate and Schenkel's condition for a scene with numbers; None without a clock.

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
    settled = (
        is_stable(inner) is True and inner.numerator.degrees()[0] <= inner.denominator.degrees()[0]
    )
    reason = "" if settled else "the controller has a pole on or outside the unit circle"
    at_rest = loop.at_rest(ring)[0] if settled else Integer(0)
    return SampledPassivity(loop.T, loop.damping, loop.sides(ring), settled, reason, at_rest)


@dataclass(frozen=True)
class ColgateLoop:
    """Period, controller as a function of s = (z - 1)/(z + 1), and the device; in numbers, or with
    a symbol."""

    T: Expr
    C: Expr
    damping: Expr
    mass: Expr = Integer(0)
    stiffness: Expr = Integer(0)

    def sides(self, ring: Ring) -> tuple[RealFunction, RealFunction]:
        """The right-hand side as a function of tan(theta/2), and of cot(theta/2)."""
        found = [
            self.T / 2 * (s - 1) / s * self.C,
            self.T / 2 * (1 - s) * self.C.xreplace({s: 1 / s}),
        ]
        near, far = (on_axis(ring.convert(f).reduced()).real for f in found)
        return near, far

    def at_rest(self, ring: Ring) -> tuple[Expr, Expr]:
        """C(1) + k, and that times what C(1) is divided by, which is 0 where the controller is not
        settled."""
        inner = ring.convert(self.C).reduced()
        above, below = (
            next(iter(ring.coefficients(x)), Integer(0))
            for x in (inner.numerator, inner.denominator)
        )
        whole = (above + self.stiffness * below).expand()
        return (whole / below if below != 0 else whole), whole


def loop_of(scene: Scene) -> ColgateLoop | SampledPassivity:
    """Of a scene with a clock; what is said where the condition does not apply."""
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
    own = _device(behind)
    if own is None:
        return SampledPassivity(T, reason=_TEN)
    return ColgateLoop(T, C.xreplace({BACK: (1 - s) / (1 + s)}), own.b, own.m, own.k)


def _held(scene: Scene, T: Expr, behind: Sequence[Effect]) -> tuple[Expr, Sequence[Effect]]:
    """A spring whose force is sampled as the controller of its position, with the whole samples
    that come late behind it."""
    C, left = (scene.rendered or scene.environment).H, list(behind)
    while (
        left and left[0].model == "delay" and (count := left[0].parameters[0].value / T).is_Integer
    ):
        C, left = C * BACK**count, left[1:]
    return C, left


def _device(effects: Sequence[Effect]) -> DeviceImpedance | None:
    """Mass, damping and stiffness between clock and hand; None where there is something else, or a
    negative mass or stiffness.

    Of a symbol it is not asked whether it is negative.
    """
    parts = [device(x) for x in effects]
    if None in parts:
        return None
    total = DeviceImpedance(*map(sum, zip(DeviceImpedance(), *filter(None, parts), strict=True)))
    known = [x for x in (total.m, total.k) if not x.free_symbols]
    return None if any(sign_of_number(x) < 0 for x in known) else total
