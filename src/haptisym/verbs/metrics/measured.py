"""The exact functions that measures of transparency are read off, and their charts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from sympy import Expr, Integer

from haptisym.judge.bounds import around
from haptisym.judge.criteria import PASSIVE, Criterion, kept
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction, squared_modulus
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Chart, Interval, Point, chart
from haptisym.kernel.symbols import omega
from haptisym.model.caveats import clocks
from haptisym.model.distortion import Distortion
from haptisym.model.quantities import MotionKind
from haptisym.verbs.metrics.freeresponse import FreeResponse, Rule, free_response
from haptisym.verbs.metrics.judging import LLEWELLYN, WITHIN_3_DB, relative, relative_square
from haptisym.verbs.metrics.twoport import TwoPort
from haptisym.verbs.metrics.unconditional import Unconditional, unconditional

Bands: TypeAlias = tuple[Interval, ...]
FAR = 100
"""Times the band: how far edges at 3 dB are looked for where no delay makes them endless."""


@dataclass(frozen=True)
class Measured:
    """What the measures are read off: exact functions and their charts."""

    evaluation: Evaluation

    @property
    def d(self) -> Distortion:
        """What is felt instead of the environment."""
        return self.evaluation.distortion

    @property
    def band(self) -> tuple[Expr, Expr]:
        """Its ends, rad/s."""
        low, high = self.evaluation.scene.band
        return low, high

    @cached_property
    def port(self) -> TwoPort:
        """The chain as a two-port."""
        ring = self.d.env.ring
        return TwoPort.of(self.d.chain, ring)  # type: ignore[arg-type]

    @cached_property
    def rendered(self) -> RationalFunction:
        """The dynamics that is rendered, in the ring of the chain."""
        return self.d.env.ring.convert(self.d.chain.rendered).reduced()

    @cached_property
    def relative(self) -> Criterion | None:
        """|dH/H_env| against the smaller threshold; None where the JND is no number for each part."""
        plain = self.evaluation.scene.threshold.is_plain
        return relative(min(x.threshold for x in self.evaluation.criteria)) if plain else None

    @cached_property
    def sensitivity_square(self) -> RealFunction | None:
        """|S|^2 of the change to that of the rendered dynamics; None where the port has none."""
        found = self.port.sensitivity(self.rendered)
        return None if found is None else squared_modulus(found)

    @cached_property
    def reach(self) -> Expr:
        """How far edges are looked for, rad/s."""
        return self.band[1] * (1 if self.d.env.ring.functions else FAR)

    @cached_property
    def edges(self) -> Chart:
        """Where the transmitted impedance is 3 dB below and above the environment."""
        return self._chart(WITHIN_3_DB, self.reach)

    def _chart(self, criteria: Iterable[Criterion], high: Expr) -> Chart:
        return chart({x: x.function(self.d) for x in criteria}, self.band[0], high)

    @cached_property
    def _inside(self) -> Chart:
        return self._chart(WITHIN_3_DB, self.band[1])

    @property
    def inside(self) -> Bands:
        """Where it is within 3 dB of the environment's, on the band."""
        return kept(self._inside)

    @cached_property
    def _within(self) -> Chart:
        if self.relative:
            return self._chart([self.relative], self.band[1])
        return chart({"": around(self.evaluation.scene.threshold, relative_square(self.d))[0]}, *self.band)

    @property
    def within(self) -> Bands:
        """Where |dH/H_env| is at most the smaller threshold, or within the largest circle that the region holds."""
        return self._within.where(lambda signs: all(sign <= 0 for sign in signs.values()))

    @cached_property
    def _passive(self) -> Chart:
        return self._chart([PASSIVE], self.band[1])

    @property
    def passive(self) -> Bands:
        """Where on the band Im H_perc >= 0."""
        return kept(self._passive)

    @cached_property
    def _llewellyn(self) -> Chart | None:
        return None if self.port.least is None else self._chart(LLEWELLYN, self.band[1])

    @cached_property
    def unconditional(self) -> Unconditional:
        """What Llewellyn's criterion says at all frequencies, poles included."""
        return unconditional(self.d, self.port) if not clocks(self.evaluation.scene) else Unconditional(None, None)

    @property
    def llewellyn(self) -> Bands | None:
        """Where on the band Llewellyn's conditions on the axis hold; None where the hybrid matrix does not exist (D = 0)."""
        return None if self._llewellyn is None else kept(self._llewellyn)

    @property
    def certified(self) -> bool:
        """Whether nothing on any chart was left undecided."""
        charts = (self.edges, self._inside, self._within, self._passive, self._llewellyn)
        return self.evaluation.certified and not any(x.undecided for x in charts if x is not None)

    @cached_property
    def effective(self) -> tuple[tuple[RealNumber, dict[str, RealNumber | None]], ...]:
        """Effective stiffness, mass and damping of H_perc at the band's ends and at the crossings; None where infinite."""
        axis = self.d.perc_response.real.axis
        w = RealFunction(axis.convert(omega))
        real, imag = self.d.perc_response.real, self.d.perc_response.imag
        minus = RealFunction(axis.convert(Integer(-1)))
        own = {"k": real, "m": minus * real / (w * w), "b": imag / w}
        excesses = {x: x.function(self.d) for x in self.evaluation.criteria}
        points = chart({**own, **excesses}, *self.band).points
        ends = (points[0], points[-1])
        shown = [p for p in points if p in ends or any(p.orders.get(x, 0) > 0 for x in excesses)]
        return tuple((p.omega, {key: value_at(f, p, key) for key, f in own.items()}) for p in shown)

    @cached_property
    def free(self) -> FreeResponse:
        """What the display does when it is let go, as an aeroplane's is judged."""
        return free_response(self.d)

    @cached_property
    def free_of_a_helicopter(self) -> FreeResponse:
        """The same, as a helicopter's is judged."""
        return free_response(self.d, Rule.HELICOPTER)

    @property
    def unit(self) -> str:
        """Of a dynamic stiffness."""
        return "N m/rad" if self.evaluation.scene.motion is MotionKind.ROTATION else "N/m"

    @property
    def units(self) -> dict[str, str]:
        """Of stiffness, mass and damping."""
        if self.evaluation.scene.motion is MotionKind.ROTATION:
            return {"k": "N m/rad", "m": "kg m^2", "b": "N m s/rad"}
        return {"k": "N/m", "m": "kg", "b": "N s/m"}


def value_at(f: RealFunction, point: Point, key: object) -> RealNumber | None:
    """The value of a function of a chart at one of its points: 0 at a zero, None at a pole."""
    order = point.orders.get(key, 0)
    if order < 0:
        return None
    return ExactNumber(Integer(0)) if order > 0 or f.is_zero else ValueAt(f, point.omega)


def covers(bands: Bands, table: Chart) -> bool:
    """Whether a set is the whole band."""
    ends = [table.points[i].omega for i in (0, -1)]
    return len(bands) == 1 and [bands[0].low.omega, bands[0].high.omega] == ends
