"""What holds for every environment of a family at once, judged by one JND: the worst case, and who binds there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from haptisym.judge.criteria import Criterion, Judged, noticed
from haptisym.kernel.lattices import Signed
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval, Key, Signs, chart
from haptisym.kernel.shown import Shown
from haptisym.model.distortion import Distortion
from haptisym.model.family import SceneFamily
from haptisym.model.jnd import Threshold


@dataclass(frozen=True)
class FamilyBinding(Judged):
    """At this end of the common transparent set this environment breaks this criterion beyond."""

    omega: RealNumber
    environment: str
    criterion: Criterion


@dataclass(frozen=True, repr=False)
class WorstCase(Shown):
    """``chart`` : of each environment and criterion, (name, criterion), what must not be positive, on one band.

    So ends of different environments are told apart, or found equal, exactly.
    """

    chart: Chart
    keys: tuple[tuple[str, Criterion], ...]

    def _line(self) -> str:
        return f"common bandwidth {self.bandwidth.digits(5) if self.bandwidth else 'none'}"

    @classmethod
    def of(cls, family: SceneFamily, threshold: Threshold) -> WorstCase:
        """In one ring: equal functions are found equal."""
        ring, criteria = family.ring(), noticed(threshold)
        functions: dict[Key, Signed] = {}
        for name, scene in family.scenes.items():
            distortion = Distortion.of(scene.distortion().chain, ring)
            functions |= {(name, x): x.function(distortion) for x in criteria}
        return cls(chart(functions, *family.band), tuple((name, x) for name in family for x in criteria))

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        """The frequencies at which every environment is transparent: closed intervals, perhaps none."""
        return self.chart.where(lambda signs: all(signs[key] <= 0 for key in self.keys))

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the common transparent interval that starts at the band's low end; None if none does."""
        first = self.transparent[0] if self.transparent else None
        return first.high.omega if first and first.low is self.chart.points[0] else None

    @cached_property
    def binding(self) -> tuple[FamilyBinding, ...]:
        """Who binds at each end of the common transparent set inside the band, in ascending order.

        Several where their ratios meet their thresholds at the same frequency. Where not even the band's low end is in
        the set, who stands in the way there comes first.
        """
        lowest, highest = self.chart.points[0], self.chart.points[-1]
        blocked = lowest.at if any(lowest.at[key] > 0 for key in self.keys) else lowest.after
        found = self._exceeding(lowest.omega, blocked) if self.bandwidth is None else []
        for x in self.transparent:
            found += [] if x.low is lowest else self._exceeding(x.low.omega, x.low.before)
            found += [] if x.high is highest else self._exceeding(x.high.omega, x.high.after)
        return tuple(dict.fromkeys(found))

    def _exceeding(self, omega: RealNumber, signs: Signs) -> list[FamilyBinding]:
        return [FamilyBinding(omega, name, x) for name, x in self.keys if signs[name, x] > 0]
