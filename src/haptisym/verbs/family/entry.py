"""What one display does to several environments at once: each, where all stay transparent, and which one binds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion, Judged, noticed
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.lattices import Signed
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval, Key, Signs, chart
from haptisym.kernel.shown import counted, titled
from haptisym.model.distortion import Distortion
from haptisym.model.family import SceneFamily
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_family


@dataclass(frozen=True)
class FamilyBinding(Judged):
    """At this end of the common transparent set this environment breaks this criterion beyond."""

    omega: RealNumber
    environment: str
    criterion: Criterion


@dataclass(frozen=True, repr=False)
class FamilyEvaluation(Answer):
    """The answers for each environment of a family, and what holds for all of them. All proven.

    ``answers`` : by the names of the environments. ``chart`` : r^2 - c^2 of each environment and criterion, (name, criterion), on
    one band, so that ends of different environments are told apart, or found equal, exactly.
    """

    _schema: ClassVar[str] = "haptisym.evaluations/1"
    _page: ClassVar[str] = "haptisym.pages.family:page"
    _figure: ClassVar[str] = "haptisym.figures.family:family_figure"

    family: SceneFamily
    answers: Mapping[str, Evaluation]
    chart: Chart
    digits: int = 15

    def _line(self) -> str:
        width = (
            "no common bandwidth" if self.bandwidth is None else f"common bandwidth {self.bandwidth.digits(5)} rad/s"
        )
        return f"{titled(self.family.title)}: {counted(len(self.answers), 'environment')}, {width}"

    @property
    def _about(self) -> SceneFamily:
        return self.family

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
    def binding(self) -> tuple[FamilyBinding, ...]:
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

    def _exceeding(self, omega: RealNumber, signs: Signs) -> list[FamilyBinding]:
        keys = [(name, x) for name in self.family for x in noticed(self.family.threshold)]
        return [FamilyBinding(omega, name, x) for name, x in keys if signs[name, x] > 0]

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided, in any environment or in the worst case."""
        return not self.chart.undecided and all(x.certified for x in self.answers.values())

    def _body(self) -> dict[str, Any]:
        return {
            "band": [float(point.omega) for point in (self.chart.points[0], self.chart.points[-1])],
            "threshold": self.family.threshold.row(),
            "environments": [{"name": name, **x.to_dict()} for name, x in self.answers.items()],
            "transparent": [[float(x.low.omega), float(x.high.omega)] for x in self.transparent],
            "binding": [self._binding(x) for x in self.binding],
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "certified": self.certified,
        }

    def _binding(self, x: FamilyBinding) -> dict[str, Any]:
        return {
            "at": float(x.omega),
            "digits": x.omega.digits(self.digits),
            "enclosure": list(x.omega.enclosure(self.digits)),
            "environment": x.environment,
            "part": x.criterion.name,
        }


def evaluate_all(family: SceneFamily | Scene | str | Path, digits: int = 15) -> FamilyEvaluation:
    """Evaluate one display with several environments: each, the band on which all are transparent, and who binds there.

    ``digits`` : decimal digits of each crossing. Guaranteed: the common transparent set is the intersection of the
    environments' own; its ends are proven, and which environment they belong to. Raises SceneError if a parameter is still
    a symbol, UndecidedError where two ends could not be told apart.

    >>> from haptisym.model.scenefile import load_scenes
    >>> found = evaluate_all(load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]))
    >>> [(x.omega.digits(6), x.environment, x.criterion.name) for x in found.binding]
    [('7.97892', 'fu2019', 'real')]
    """
    family = as_family(family)
    answers = {name: evaluate(scene, digits) for name, scene in family.scenes.items()}
    return FamilyEvaluation(family, answers, common_chart(family), digits)


def common_chart(family: SceneFamily) -> Chart:
    """r^2 - c^2 of all environments and criteria on the family's band, in one ring: equal functions are found equal."""
    ring = family.ring()
    functions: dict[Key, Signed] = {}
    for name, scene in family.scenes.items():
        distortion = Distortion.of(scene.distortion().chain, ring)
        functions |= {(name, x): x.function(distortion) for x in noticed(family.threshold)}
    return chart(functions, *family.band)
