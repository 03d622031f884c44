"""Whether every passive hand may hold a display: H_perc/s is positive real. Judged on [0, infinity), with a clock up to pi/T."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from math import isfinite
from typing import Any

import flint
from flint import arb
from sympy import Expr, Integer, Rational, pi

from haptisym.judge.colgate import SampledPassivity, sampled_passivity
from haptisym.judge.criteria import PASSIVE
from haptisym.judge.passiveparts import environment_alone
from haptisym.judge.peaks import Greatest, greatest
from haptisym.judge.positivereal import poles_allow, power
from haptisym.kernel.budget import limited
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.far import Far, Sense, far
from haptisym.kernel.reals import ExactNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Chart, Interval, chart, sign_of_number
from haptisym.kernel.symbols import omega
from haptisym.model.caveats import clocks, sampled_loop
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene

_TURNS = 2  # of the longest delay: as far as is listed what goes on for ever, or for long
_MOST_TURNS = 500  # that are charted where a sign settles later
_GRID = 200
_BELOW = 1e-3
_BITS = 128
_PATIENCE = 10.0  # s, as where delays meet in a chain of roots thousands of peaks may have to be compared


class Beyond(Enum):
    """What Im H_perc does beyond the reach of a chart."""

    NEVER = "never negative"
    ALWAYS = "negative everywhere"
    AGAIN = "negative again and again"
    UNKNOWN = "not decided"
    CLOCK = "not looked at: the clock samples no faster motion"
    LATE = "not looked at: the delays turn many times before it settles"


_BEYOND = {
    Sense.POSITIVE: Beyond.NEVER, Sense.NEGATIVE: Beyond.ALWAYS, Sense.BOTH: Beyond.AGAIN, Sense.UNKNOWN: Beyond.UNKNOWN,
}  # fmt: skip


@dataclass(frozen=True)
class Passivity:
    """Where a display gives energy away, and whether every passive hand may hold it. All of it certified.

    ``chart`` : of Im H_perc, from 0 to ``high``. ``beyond`` : what it does above that. ``settled`` : far out.
    """

    scene: Scene
    distortion: Distortion
    chart: Chart
    high: Expr
    beyond: Beyond
    settled: Far = Far(Sense.UNKNOWN)

    @cached_property
    def active(self) -> tuple[Interval, ...]:
        """Where Im H_perc < 0, up to ``high``: the display gives -pi A^2 Im H_perc per cycle of amplitude A."""
        return self.chart.where(lambda signs: signs[PASSIVE] > 0)

    @property
    def is_active(self) -> bool:
        """Whether Im H_perc < 0 anywhere."""
        return bool(self.active) or self.stays_active

    @property
    def stays_active(self) -> bool:
        """Whether Im H_perc < 0 at frequencies above every frequency."""
        return self.beyond in (Beyond.ALWAYS, Beyond.AGAIN) or self.active_from is not None

    @property
    def active_from(self) -> Expr | None:
        """From where on Im H_perc < 0 everywhere, with a gap between ``high`` and that which was not looked at; else None."""
        is_late = self.beyond is Beyond.LATE and self.settled.sense is Sense.NEGATIVE
        return self.settled.radius if is_late else None

    @cached_property
    def holds(self) -> bool | None:
        """Whether every passive hand may hold the display, with a clock by ``sampled``; None where not decided."""
        if self.is_active and not sampled_loop(self.scene):  # where the closed form is no approximation
            return False
        if self.sampled is not None:
            return self._sampled_holds()
        if self.has_passive_parts:
            return True
        if self.beyond is not Beyond.NEVER or self.chart.undecided:
            return None
        return self.poles_allow

    def _sampled_holds(self) -> bool | None:
        try:
            return self.sampled.passive if self.sampled else None
        except UndecidedError:
            return None

    @cached_property
    def sampled(self) -> SampledPassivity | None:
        """With a clock, Colgate and Schenkel's condition."""
        return sampled_passivity(self.scene)

    @cached_property
    def has_passive_parts(self) -> bool:
        """Whether it is made of parts that only take energy."""
        alone = environment_alone(self.scene)
        return alone is not None and passivity(alone).holds is True

    @property
    def takes_energy(self) -> bool:
        """Whether every passive hand may hold the display, and Im H_perc > 0 at every frequency: for rational dynamics."""
        if not self.holds or _ring(self.distortion).lags:
            return False
        points = [x for x in self.chart.points if float(x.omega) > 0]
        signs = [x for p in self.chart.points for x in p.after.values()] + [x for p in points for x in p.at.values()]
        return not _ring(self.distortion).orders and set(signs) == {-1}

    @cached_property
    def poles_allow(self) -> bool | None:
        """Whether H_perc/s has no poles in Re s > 0, and on the axis simple ones with positive residues alone."""
        return True if self.has_passive_parts else poles_allow(self.distortion.perc)

    @cached_property
    def damping(self) -> Greatest | None:
        """b* = sup(-Im H_perc/omega), at least 0: with it a hand is held whatever its mass and stiffness.

        That, where the force under imposed motion is stable. Its frequency is None where it is only approached, far out.
        None where nothing bounds it, and where that is not decided: ``is_unbounded`` tells. Found in ten seconds or not at all.
        """
        if not self.is_active:
            return Greatest(ExactNumber(Integer(0)), None)
        if self.beyond is Beyond.CLOCK:
            return None
        try:
            with limited(_PATIENCE):
                return _damping(self.distortion, self.high)
        except UndecidedError:
            return None

    @cached_property
    def is_unbounded(self) -> bool:
        """Whether -Im H_perc/omega is proven to be unbounded far out, so that no damping of a hand is enough."""
        if not self.stays_active:
            return False
        raw = self.distortion.perc_response.raw_imag
        top, below = (power(p, raw) for p in (raw.numerator, raw.denominator))
        return sign_of_number(top - below - 1) > 0

    @cached_property
    def most_given(self) -> Greatest | None:
        """The largest -Im H_perc up to ``high``, N/m, and where: times pi A^2 it is energy per cycle. None if unbounded."""
        return greatest(PASSIVE.measure(self.distortion), Integer(0), self.high)

    def row(self) -> dict[str, Any]:
        """As documents have it."""
        ends: list[list[float | None]] = [[float(x.low.omega), float(x.high.omega)] for x in self.active]
        if self.beyond is Beyond.ALWAYS:
            ends = [*ends[:-1], [ends[-1][0], None]]
        if self.active_from is not None:
            ends.append([float(self.active_from), None])
        found = {"holds": self.holds, "active": ends, "beyond": self.beyond.value, "reach": float(self.high)}
        return {**found, "poles_allow": self.poles_allow}


def passivity(scene: Scene, distortion: Distortion | None = None) -> Passivity:
    """Where a scene with numbers gives energy away on [0, infinity): at least as far as its band, and what is beyond.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = passivity(load_scene("zener-tissue"))
    >>> found.holds, found.beyond.name, [x.low.omega.digits(7) for x in found.active]
    (False, 'ALWAYS', ['92.70739'])
    """
    d = distortion or scene.closed
    periods = clocks(scene)
    settled = Far(Sense.POSITIVE) if periods else far(d.perc_response.raw_imag)
    high, is_late = (pi / max(periods, key=float), False) if periods else _reach(scene, d, settled)
    beyond = Beyond.CLOCK if periods else Beyond.LATE if is_late else _BEYOND[settled.sense]
    return Passivity(scene, d, chart({PASSIVE: PASSIVE.function(d)}, Integer(0), high), high, beyond, settled)


def _reach(scene: Scene, d: Distortion, settled: Far) -> tuple[Expr, bool]:
    """As far as a chart goes: where the sign is settled, else some turns of the delays; the band in any case.

    And whether it settles only after too many turns.
    """
    band, is_settled = scene.band[1], settled.sense in (Sense.POSITIVE, Sense.NEGATIVE)
    own = most_charted(d, settled.radius) if is_settled else _TURNS * _turn(d)
    is_late = is_settled and own != settled.radius
    return (own, is_late) if sign_of_number(own - band) > 0 else (band, is_late)


def most_charted(d: Distortion, high: Expr) -> Expr:
    """As far as is looked at, rad/s: all if the longest delay turns some hundred times up to there, else two of its turns."""
    turn = _turn(d)
    return _TURNS * turn if turn and sign_of_number(high - _MOST_TURNS * turn) > 0 else high


def _turn(d: Distortion) -> Expr:
    """Of the longest delay, rad/s; 0 where there is none."""
    lags = _ring(d).lags
    return 2 * pi / max(lags, key=float) if lags else Integer(0)


def _ring(d: Distortion) -> Ring:
    ring = d.perc.ring
    assert isinstance(ring, Ring)
    return ring


# The damping that a hand needs


def _damping(d: Distortion, high: Expr) -> Greatest | None:
    """sup(-Im H_perc/omega): found on a chart that reaches as far as the function may be that large."""
    axis: Any = d.perc_response.raw_imag.ring
    raw = d.perc_response.raw_imag
    needed = PASSIVE.measure(d) / RealFunction(axis.convert(omega))
    if not needed.function.numerator.degrees()[0] and len(axis.angles) == 1 and not axis.orders:
        return greatest(needed, Integer(0), 2 * pi / axis.angles[0].rate)  # a wave, which repeats
    for value in _tried(needed, high):
        left = far(axis.convert(value * omega) + raw)
        if left.sense is Sense.POSITIVE:
            reach = left.radius if sign_of_number(left.radius - high) > 0 else high
            found = greatest(needed, Integer(0), reach)
            limit = ExactNumber(value)
            return Greatest(limit, None) if found and found.value.ball(_BITS) < limit.ball(_BITS) else found
    return None


def _tried(needed: RealFunction, high: Expr) -> list[Expr]:
    """Bounds to try: the limit far out of a rational function, and a little less than the largest value seen."""
    with flint.ctx.workprec(64):
        end = float(high)
        seen = (float(needed.ball(arb(end * (k / _GRID) ** 2))) for k in range(1, _GRID + 1))
        most = max((x for x in seen if isfinite(x)), default=0.0)
    found = [Rational(most * (1 - _BELOW))] if most > 0 else []
    top, below = needed.function.numerator, needed.function.denominator
    if needed.axis.functions or int(top.degrees()[0]) != int(below.degrees()[0]):
        return found
    limit = needed.axis.coefficients(top)[-1] / needed.axis.coefficients(below)[-1]
    return [*found, limit] if sign_of_number(limit) > 0 else found
