"""The exact functions that measures of transparency are read off, and their charts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from sympy import Expr, Integer, Rational

from haptisym.judge.crossings import Curve, level
from haptisym.judge.evaluation import Evaluation
from haptisym.judge.peaks import ValueAt
from haptisym.kernel.levels import Level
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.response import RealFunction, on_axis, squared_modulus
from haptisym.kernel.rings import RationalFunction
from haptisym.kernel.roots import Chart, Interval, Point, Signs, chart
from haptisym.kernel.symbols import omega
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.quantities import Motion
from haptisym.verbs.metrics.freeresponse import FreeResponse, free_response
from haptisym.verbs.metrics.twoport import TwoPort

Bands: TypeAlias = tuple[Interval, ...]
FAR = 100
"""Times the band: how far edges at 3 dB are looked for where no delay makes them endless."""


@dataclass(frozen=True)
class Measured:
    """What the measures are read off: exact functions and their charts."""

    evaluation: Evaluation

    @property
    def d(self) -> Distortion:
        return self.evaluation.distortion

    @property
    def band(self) -> tuple[Expr, Expr]:
        low, high = self.evaluation.scene.band
        return low, high

    @cached_property
    def port(self) -> TwoPort:
        ring = self.d.env.ring
        return TwoPort.of(self.d.chain, ring)  # type: ignore[arg-type]

    @cached_property
    def rendered(self) -> RationalFunction:
        return self.d.env.ring.convert(self.d.chain.rendered).reduced()

    @cached_property
    def ratio_square(self) -> RealFunction:
        """|H_perc/H_env|^2."""
        return squared_modulus((self.d.perc / self.d.env).reduced())

    @cached_property
    def relative_square(self) -> RealFunction:
        """|dH/H_env|^2."""
        return squared_modulus((self.d.difference / self.d.env).reduced())

    @cached_property
    def sensitivity_square(self) -> RealFunction | None:
        found = self.port.sensitivity(self.rendered)
        return None if found is None else squared_modulus(found)

    @cached_property
    def reach(self) -> Expr:
        """How far edges are looked for, rad/s."""
        return self.band[1] * (1 if self.d.env.ring.functions else FAR)

    @cached_property
    def edges(self) -> Chart:
        """Where the transmitted impedance is 3 dB below and above the environment."""
        return chart(self._decibels(), self.band[0], self.reach)

    def _decibels(self) -> dict[str, RealFunction | Level]:
        limits = {"-3 dB": Rational(1, 2), "+3 dB": Integer(2)}
        return {key: level(self.ratio_square, limit) for key, limit in limits.items()}

    @cached_property
    def _inside(self) -> Chart:
        return chart(self._decibels(), *self.band)

    @property
    def inside(self) -> Bands:
        """Where it is within 3 dB of the environment's, on the band."""
        return self._inside.where(lambda signs: signs["-3 dB"] >= 0 >= signs["+3 dB"])

    @cached_property
    def least_threshold(self) -> Expr:
        threshold = self.evaluation.scene.threshold
        return min(threshold.real, threshold.imag)

    @cached_property
    def _within(self) -> Chart:
        return chart({"excess": level(self.relative_square, (self.least_threshold**2).expand())}, *self.band)

    @property
    def within(self) -> Bands:
        """Where |dH/H_env| is at most the smaller threshold."""
        return self._within.where(lambda signs: signs["excess"] <= 0)

    @cached_property
    def passive(self) -> Bands:
        """Where Im H_perc >= 0."""
        return self.evaluation.chart.where(lambda signs: signs[Curve.PERCEIVED, Part.IMAG] >= 0)

    @cached_property
    def _llewellyn(self) -> Chart | None:
        least, leak, gain = self.port.least, self.port.leak, self.port.gain
        if least is None or leak is None or gain is None:
            return None
        own, other = on_axis(least).imag, on_axis(leak).imag
        margin = on_axis(gain).real - RealFunction((own * other).function + (own * other).function)
        functions = {"h11": own, "h22": other, "margin": margin, "excess": margin * margin - squared_modulus(gain)}
        return chart(functions, *self.band)

    @property
    def absolutely_stable(self) -> Bands | None:
        """Where Llewellyn's conditions on the axis hold; None where the hybrid matrix does not exist (D = 0)."""
        return None if self._llewellyn is None else self._llewellyn.where(_llewellyn)

    @property
    def certified(self) -> bool:
        """Whether nothing on any chart was left undecided."""
        charts = (self.edges, self._inside, self._within, self._llewellyn)
        return self.evaluation.certified and not any(x.undecided for x in charts if x is not None)

    @cached_property
    def effective(self) -> tuple[tuple[RealNumber, dict[str, RealNumber | None]], ...]:
        """Effective stiffness, mass and damping of H_perc at the band's ends and at the crossings; None where infinite."""
        axis = self.d.perc_response.real.axis
        w = RealFunction(axis.convert(omega))
        real, imag = self.d.perc_response.real, self.d.perc_response.imag
        minus = RealFunction(axis.convert(Integer(-1)))
        own = {"k": real, "m": minus * real / (w * w), "b": imag / w}
        excesses = {part: level(self.d.squared_ratios[part], (c**2).expand()) for part, c in self._limits().items()}
        points = chart({**own, **excesses}, *self.band).points
        shown = [
            p for i, p in enumerate(points) if i in (0, len(points) - 1) or any(p.orders.get(x, 0) > 0 for x in Part)
        ]
        return tuple((p.omega, {key: value_at(f, p, key) for key, f in own.items()}) for p in shown)

    def _limits(self) -> dict[Part, Expr]:
        return {part: self.evaluation.scene.threshold[part] for part in Part}

    @cached_property
    def free(self) -> FreeResponse:
        return free_response(self.d)

    @property
    def unit(self) -> str:
        """Of a dynamic stiffness."""
        return "N m/rad" if self.evaluation.scene.motion is Motion.ROTATION else "N/m"

    @property
    def units(self) -> dict[str, str]:
        """Of stiffness, mass and damping."""
        if self.evaluation.scene.motion is Motion.ROTATION:
            return {"k": "N m/rad", "m": "kg m^2", "b": "N m s/rad"}
        return {"k": "N/m", "m": "kg", "b": "N s/m"}


def _llewellyn(signs: Signs) -> bool:
    return signs["h11"] >= 0 >= signs["h22"] and signs["margin"] >= 0 and signs["excess"] >= 0


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
