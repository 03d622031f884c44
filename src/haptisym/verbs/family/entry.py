"""What one display does to several environments at once: each, where all stay transparent, and which one binds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval
from haptisym.kernel.shown import counted, titled
from haptisym.model.family import SceneFamily
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_family
from haptisym.verbs.family.regions import FamilyCompared, binding_row, compared_all
from haptisym.verbs.family.worst import FamilyBinding, WorstCase


@dataclass(frozen=True, repr=False)
class FamilyEvaluation(Answer):
    """The answers for each environment of a family, and what holds for all of them. All proven.

    ``answers`` : by the names of the environments. ``worst`` : what holds for all of them. ``regions`` : where other JND models
    were asked about, what each says.
    """

    _schema: ClassVar[str] = "haptisym.evaluations/1"
    _page: ClassVar[str] = "haptisym.pages.family:page"
    _figure: ClassVar[str] = "haptisym.figures.family:family_figure"

    family: SceneFamily
    answers: Mapping[str, Evaluation]
    worst: WorstCase
    digits: int = 15
    regions: tuple[FamilyCompared, ...] = ()

    def _line(self) -> str:
        width = (
            "no common bandwidth" if self.bandwidth is None else f"common bandwidth {self.bandwidth.digits(5)} rad/s"
        )
        return f"{titled(self.family.title)}: {counted(len(self.answers), 'environment')}, {width}"

    @property
    def _about(self) -> SceneFamily:
        return self.family

    @property
    def chart(self) -> Chart:
        """What each environment must not exceed, (name, criterion), on one band."""
        return self.worst.chart

    @property
    def transparent(self) -> tuple[Interval, ...]:
        """The frequencies at which every environment is transparent: closed intervals, perhaps none."""
        return self.worst.transparent

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the common transparent interval that starts at the band's low end; None if none does."""
        return self.worst.bandwidth

    @property
    def binding(self) -> tuple[FamilyBinding, ...]:
        """Who binds at each end of the common transparent set inside the band, in ascending order; see ``WorstCase``."""
        return self.worst.binding

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided, in any environment or in the worst case."""
        own = all(x.certified for x in self.answers.values()) and all(x.certified for x in self.regions)
        return own and not self.chart.undecided

    def _body(self) -> dict[str, Any]:
        return {
            "band": [float(point.omega) for point in (self.chart.points[0], self.chart.points[-1])],
            "threshold": self.family.threshold.row(),
            "environments": [{"name": name, **x.to_dict()} for name, x in self.answers.items()],
            "transparent": [[float(x.low.omega), float(x.high.omega)] for x in self.transparent],
            "binding": [binding_row(x, self.digits) for x in self.binding],
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "certified": self.certified,
            **({"regions": [x.row(self.digits) for x in self.regions]} if self.regions else {}),
        }


def evaluate_all(
    family: SceneFamily | Scene | str | Path,
    digits: int = 15,
    *,
    regions: bool = False,
    proportion: Number | None = None,
    limit: float | None = SECONDS,
) -> FamilyEvaluation:
    """Evaluate one display with several environments: each, the band on which all are transparent, and who binds there.

    ``digits`` : decimal digits of each crossing. ``regions`` : whether ``regions`` is to tell what square, disc and diamond of
    the JND's half widths say. ``proportion`` : of right answers, to which a JND that tells its own is converted. Guaranteed: the
    common transparent set is the intersection of the environments' own; its ends are proven, and which environment they belong
    to. ``limit`` : seconds after which a LimitError says that it is not decided; None for none. Raises SceneError if a parameter
    is still a symbol, UndecidedError where two ends could not be told apart.

    >>> from haptisym.model.scenefile import load_scenes
    >>> found = evaluate_all(load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]))
    >>> [(x.omega.digits(6), x.environment, x.criterion.name) for x in found.binding]
    [('7.97892', 'fu2019', 'real')]
    """
    family = as_family(family)
    if proportion is not None:
        family = family.at_proportion(proportion)
    with limited(limit):
        return _evaluated(family, digits, regions=regions)


def _evaluated(family: SceneFamily, digits: int, *, regions: bool) -> FamilyEvaluation:
    answers = {name: evaluate(scene, digits) for name, scene in family.scenes.items()}
    worst = WorstCase.of(family, family.threshold)
    if not regions:
        return FamilyEvaluation(family, answers, worst, digits)
    answers = {name: e.with_regions() for name, e in answers.items()}
    return FamilyEvaluation(family, answers, worst, digits, compared_all(family, answers, worst))
