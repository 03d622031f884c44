"""What one display does to several environments at once: where all stay transparent, and which one binds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from haptisym.judge.answers import Answers
from haptisym.judge.crossings import excess
from haptisym.kernel.levels import Level
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Chart, Interval, Key, Signs, chart
from haptisym.model.family import SceneFamily
from haptisym.model.jnd import Part


@dataclass(frozen=True)
class Binding:
    """At this end of the common transparent set this environment's ratio of this part exceeds its threshold beyond."""

    omega: RealNumber
    environment: str
    part: Part


@dataclass(frozen=True)
class WorstCase:
    """The answers for each environment of a family, and what holds for all of them. All proven.

    ``answers`` : by the names of the environments. ``chart`` : r^2 - c^2 of each environment and part, (name, part), on
    one band, so that ends of different environments are told apart, or found equal, exactly.
    """

    family: SceneFamily
    answers: Mapping[str, Answers]
    chart: Chart = field(repr=False)
    digits: int = 15

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        """The frequencies at which every environment is transparent: closed intervals, perhaps none."""
        return self.chart.where(lambda signs: all(sign <= 0 for sign in signs.values()))

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the common transparent interval that starts at the band's low end; None if none does."""
        first = self.transparent[0] if self.transparent else None
        return first.high.omega if first and first.low is self.chart.points[0] else None

    @cached_property
    def binding(self) -> tuple[Binding, ...]:
        """Who binds at each end of the common transparent set inside the band, in ascending order.

        Several where their ratios meet their thresholds at the same frequency. Where not even the band's low end is in
        the set, who stands in the way there comes first.
        """
        lowest, highest = self.chart.points[0], self.chart.points[-1]
        blocked = lowest.at if any(sign > 0 for sign in lowest.at.values()) else lowest.after
        found = self._exceeding(lowest.omega, blocked) if self.bandwidth is None else []
        for x in self.transparent:
            found += [] if x.low is lowest else self._exceeding(x.low.omega, x.low.before)
            found += [] if x.high is highest else self._exceeding(x.high.omega, x.high.after)
        return tuple(dict.fromkeys(found))

    def _exceeding(self, omega: RealNumber, signs: Signs) -> list[Binding]:
        keys = [(name, part) for name in self.family for part in Part]
        return [Binding(omega, name, part) for name, part in keys if signs[name, part] > 0]

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided, in any environment or in the worst case."""
        return not self.chart.undecided and all(x.certified for x in self.answers.values())


def common_chart(family: SceneFamily) -> Chart:
    """r^2 - c^2 of all environments and parts on the family's band, in one ring: equal functions are found equal."""
    ring = family.ring()
    functions: dict[Key, RealFunction | Level] = {}
    for name, scene in family.scenes.items():
        distortion = scene.distortion().chain.distortion(ring)
        functions |= {(name, part): excess(distortion, family.threshold[part], part) for part in Part}
    return chart(functions, *family.band)
