"""The two-step evaluation of a scene: when a distortion is noticed, and how it is felt."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .crossings import Crossing, Curve, curves, find_crossings, transparent_set, unbounded_points
from .distortion import Distortion
from .errors import SceneError
from .percepts import Percept, changeovers, find_percepts, outside_model
from .reals import RealNumber
from .roots import Chart, Interval, Point, chart
from .scene import Scene
from .stability import is_stable


@dataclass(frozen=True)
class Evaluation:
    """The answers for a scene, all proven: nothing is missed on the band and nothing is invented.

    ``crossings``: where r_r or r_i meets its threshold. ``transparent``: where neither exceeds it, a union of closed
    intervals. ``changeovers``: where Re H_env and Re H_perc change sign. ``percepts``: what is felt where a ratio
    exceeds. ``outside_model``: where Im H_perc < 0. ``unbounded``: where a ratio is infinite. ``stable``: whether all
    poles of H_perc lie in the open left half plane. ``digits``: decimal digits shown of each crossing.
    """

    scene: Scene
    distortion: Distortion = field(repr=False)
    chart: Chart = field(repr=False)
    stable: bool | None
    digits: int = 15

    @cached_property
    def crossings(self) -> tuple[Crossing, ...]:
        return find_crossings(self.chart)

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        return transparent_set(self.chart)

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the transparent interval that starts at the band's low end; None if none does."""
        first = self.transparent[0] if self.transparent else None
        return first.high.omega if first and first.low is self.chart.points[0] else None

    @cached_property
    def changeovers_environment(self) -> tuple[Point, ...]:
        return changeovers(self.chart, Curve.ENVIRONMENT)

    @cached_property
    def changeovers_perceived(self) -> tuple[Point, ...]:
        return changeovers(self.chart, Curve.PERCEIVED)

    @cached_property
    def percepts(self) -> tuple[Percept, ...]:
        return find_percepts(self.chart)

    @cached_property
    def outside_model(self) -> tuple[Interval, ...]:
        return outside_model(self.chart)

    @cached_property
    def unbounded(self) -> tuple[Point, ...]:
        return unbounded_points(self.chart)

    @property
    def certified(self) -> bool:
        """Whether every number here is proven, none estimated."""
        return True

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym evaluate --json``, schema ``haptisym.evaluation/1``."""
        return {
            "schema": "haptisym.evaluation/1",
            "title": self.scene.title,
            "band": [float(point.omega) for point in (self.chart.points[0], self.chart.points[-1])],
            "threshold": {"real": str(self.scene.threshold.real), "imag": str(self.scene.threshold.imag)},
            "crossings": [self._crossing(c) for c in self.crossings],
            "transparent": [_interval(x) for x in self.transparent],
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "changeovers": {
                "environment": [float(p.omega) for p in self.changeovers_environment],
                "perceived": [float(p.omega) for p in self.changeovers_perceived],
            },
            "percepts": [
                {
                    "part": p.part.value,
                    "band": _interval(p.band),
                    "property": p.property.value,
                    "change": p.change.value,
                }
                for p in self.percepts
            ],
            "outside_model": [_interval(x) for x in self.outside_model],
            "unbounded": [float(p.omega) for p in self.unbounded],
            "stable": self.stable,
            "certified": self.certified,
        }

    def _crossing(self, c: Crossing) -> dict[str, Any]:
        return {
            "part": c.part.value,
            "omega": float(c.omega),
            "digits": c.omega.digits(self.digits),
            "enclosure": list(c.omega.enclosure(self.digits)),
            "kind": c.kind.value,
            "sign": c.sign,
            "multiplicity": c.multiplicity,
        }

    def to_json(self) -> str:
        """The document of ``haptisym evaluate --json`` as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)


def evaluate(scene: Scene, digits: int = 15) -> Evaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing, as many as wanted.

    Raises SceneError if a parameter is still a symbol.

    >>> from . import effects, environments
    >>> scene = Scene(environments.mass_spring_damper(1.8, 15, 100), (effects.second_order_lowpass(80, 0.5),))
    >>> [c.omega.digits(20) for c in evaluate(scene).crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    if digits < 1:
        raise SceneError(f"digits: {digits} must be at least 1")
    free = [p for p in scene.parameters if p.value.free_symbols]
    if free:
        raise SceneError(
            f"{free[0].key} = {free[0].value} is a symbol: an evaluation needs numbers; use distort for formulas"
        )
    distortion = scene.distortion()
    low, high = scene.band
    table = chart(curves(distortion, scene.threshold), low, high)
    return Evaluation(scene, distortion, table, is_stable(distortion.perc), digits)


def _interval(x: Interval) -> list[float]:
    return [float(x.low.omega), float(x.high.omega)]
