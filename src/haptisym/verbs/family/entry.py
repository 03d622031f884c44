"""What one display does to several environments at once: each, where all stay transparent, and
which one binds.

All are judged by one JND, or by square, disc and diamond of its half widths, where it is asked
whether the conclusion survives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, Judged, noticed
from haptisym.judge.evaluation import OWN, Compared, Evaluation, evaluate
from haptisym.kernel.budget import SECONDS, in_time, limited
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.roots import Chart, Interval, Key, Signed, Signs, chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Threshold
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import SceneFamily, as_family
from haptisym.verbs.family.answers import FamilyAnswers, answer_each


@dataclass(frozen=True)
class FamilyBinding(Judged):
    """An end of the common transparent set, rad/s, beyond which one environment exceeds one
    criterion."""

    omega: RealNumber
    environment: str
    criterion: Criterion


@dataclass(frozen=True, repr=False)
class WorstCase(Shown):
    """All environments together: transparent where each of them is.

    ``chart`` : for each environment and criterion, (name, criterion), the function that must not be
    positive, all on one band: so ends of different environments are distinguished, or found equal,
    exactly.
    """

    chart: Chart
    keys: tuple[tuple[str, Criterion], ...]

    def _line(self) -> str:
        return f"common bandwidth {self.bandwidth.digits(5) if self.bandwidth else 'none'}"

    @classmethod
    def of(cls, family: SceneFamily, threshold: Threshold) -> WorstCase:
        """The worst case of a family by one JND."""
        # in one ring, in which equal functions of different environments are found equal
        ring, criteria = family.ring(), noticed(threshold)
        functions: dict[Key, Signed] = {}
        for name, scene in family.scenes.items():
            distortion = Distortion.of(scene.distortion().chain, ring)
            functions |= {(name, x): x.function(distortion) for x in criteria}
        return cls(
            chart(functions, *family.band), tuple((name, x) for name in family for x in criteria)
        )

    @cached_property
    def transparent(self) -> tuple[Interval, ...]:
        """The frequencies at which every environment is transparent: closed intervals, perhaps
        none."""
        return self.chart.where(lambda signs: all(signs[key] <= 0 for key in self.keys))

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the common transparent interval that starts at the band's low end; None if
        none does."""
        return self.chart.reach(self.transparent)

    @cached_property
    def binding(self) -> tuple[FamilyBinding, ...]:
        """Which environment limits each end of the common transparent set inside the band, in
        ascending order.

        Several where their ratios meet their thresholds at the same frequency. Where not even the
        band's low end is in the set, who stands in the way there comes first.
        """
        lowest, highest = self.chart.points[0], self.chart.points[-1]
        bindings: list[FamilyBinding] = []
        if self.bandwidth is None:
            # exceeded at the low end itself, or only from there on, where a ratio is just reached
            is_exceeded = any(lowest.at[key] > 0 for key in self.keys)
            bindings += self._exceeding(lowest.omega, lowest.at if is_exceeded else lowest.after)
        for x in self.transparent:
            # the ends of the band limit a set without any environment's doing
            if x.low is not lowest:
                bindings += self._exceeding(x.low.omega, x.low.before)
            if x.high is not highest:
                bindings += self._exceeding(x.high.omega, x.high.after)
        return tuple(dict.fromkeys(bindings))

    def _exceeding(self, omega: RealNumber, signs: Signs) -> list[FamilyBinding]:
        """The environments and criteria that are exceeded next to a frequency, by the signs
        there."""
        return [FamilyBinding(omega, name, x) for name, x in self.keys if signs[name, x] > 0]


@dataclass(frozen=True, repr=False)
class FamilyCompared(Shown):
    """The result of one JND region for all environments together (``worst``), and for each:
    ``answers``, by the names of the environments."""

    name: str
    threshold: Threshold
    worst: WorstCase
    answers: Mapping[str, Compared]

    def _line(self) -> str:
        return (
            f"{self.name}: common bandwidth "
            f"{self.bandwidth.digits(5) if self.bandwidth else 'none'}"
        )

    @property
    def bandwidth(self) -> RealNumber | None:
        """The common bandwidth, rad/s; None where there is none."""
        return self.worst.bandwidth

    @property
    def first(self) -> tuple[FamilyBinding, ...]:
        """The environments that limit the common transparent set at its first end; none where it is
        the whole band."""
        bound = self.worst.binding
        return tuple(x for x in bound if x.omega is bound[0].omega)

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        return not self.worst.chart.undecided and all(x.certified for x in self.answers.values())

    def row(self, digits: int) -> dict[str, Any]:
        """The region and its common bandwidth as a row of a document."""
        return {
            "region": self.name,
            "threshold": self.threshold.row(),
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "binding": [binding_row(x, digits) for x in self.first],
            "certified": self.certified,
        }


def binding_row(x: FamilyBinding, digits: int) -> dict[str, Any]:
    """An end of the common transparent set as a row of a document."""
    return {
        "at": float(x.omega),
        "digits": x.omega.digits(digits),
        "enclosure": list(x.omega.enclosure(digits)),
        "environment": x.environment,
        "part": x.criterion.name,
    }


def compared_all(
    family: SceneFamily, answers: Mapping[str, Evaluation], own: WorstCase
) -> tuple[FamilyCompared, ...]:
    """Square, disc and diamond of the JND's half widths, and the JND itself: each judges all
    environments.

    ``answers`` : of each environment, with its regions. ``own`` : what the JND itself says of all
    of them.
    """
    models = {x.name: x.threshold for x in next(iter(answers.values())).regions}
    each = {
        name: {who: next(x for x in e.regions if x.name == name) for who, e in answers.items()}
        for name in models
    }
    return tuple(
        FamilyCompared(name, model, own if name == OWN else WorstCase.of(family, model), each[name])
        for name, model in models.items()
    )


@dataclass(frozen=True, repr=False)
class FamilyEvaluation(Answer):
    """The answers for each environment of a family, and what holds for all of them. All proven.

    ``answers`` : by the names of the environments. ``worst`` : what holds for all of them.
    ``regions`` : the answers for other JND models, where they were asked about.
    """

    _schema: ClassVar[str] = "haptisym.evaluations/1"
    _page: ClassVar[str] = "haptisym.pages.evaluation:page_family"
    _figure: ClassVar[str] = "haptisym.figures.family:FAMILY"

    family: SceneFamily
    answers: Mapping[str, Evaluation]
    worst: WorstCase
    digits: int = 15
    regions: tuple[FamilyCompared, ...] = ()

    def _line(self) -> str:
        width = (
            "no common bandwidth"
            if self.bandwidth is None
            else f"common bandwidth {self.bandwidth.digits(5)} rad/s"
        )
        return f"{titled(self.family.title)}: {counted(len(self.answers), 'environment')}, {width}"

    @property
    def _about(self) -> SceneFamily:
        return self.family

    @property
    def chart(self) -> Chart:
        """The functions that must not be positive, by (name, criterion), on one band."""
        return self.worst.chart

    @property
    def transparent(self) -> tuple[Interval, ...]:
        """The frequencies at which every environment is transparent: closed intervals, perhaps
        none."""
        return self.worst.transparent

    @property
    def bandwidth(self) -> RealNumber | None:
        """The end of the common transparent interval that starts at the band's low end; None if
        none does."""
        return self.worst.bandwidth

    @property
    def binding(self) -> tuple[FamilyBinding, ...]:
        """Which environment limits each end of the common transparent set inside the band, in
        ascending order; see ``WorstCase``."""
        return self.worst.binding

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided, in any environment or in the worst case."""
        all_answers = all(x.certified for x in self.answers.values()) and all(
            x.certified for x in self.regions
        )
        return all_answers and not self.chart.undecided

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
) -> FamilyEvaluation | Any:
    """Evaluate one display with several environments: each, the band on which all are transparent,
    and which environment limits it there.

    ``digits`` : decimal digits of each crossing. ``regions`` : whether ``regions`` is to have the
    answers for square, disc and diamond of the JND's half widths. ``proportion`` : of right
    answers, to which a JND with a proportion of its own is converted. Proven: the common
    transparent set is the intersection of the environments' own; its ends are proven, and which
    environment they belong to. ``limit`` : seconds of processor time, None for none. Where they are
    over before that, or two ends cannot be ordered, the answers of single environments are
    returned, as of ``answer_each``; LimitError where there is not even one. Raises SceneError if a
    parameter is still a symbol.

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


def _evaluated(
    family: SceneFamily, digits: int, *, regions: bool
) -> FamilyEvaluation | FamilyAnswers:
    """The evaluation of a family; the answers of single environments where the time is over before
    it is known what they have in common."""
    each = answer_each(family, lambda scene: evaluate(scene, digits))
    found = (
        None
        if each.left
        else in_time(lambda: _together(each, digits, regions=regions), _ALL, each.left)
    )
    return each if found is None else found


_ALL = "what all environments have in common"


def _together(each: FamilyAnswers, digits: int, *, regions: bool) -> FamilyEvaluation:
    """The answers of single environments with what holds for all of them."""
    family, answers = each.family, each.answers
    worst = WorstCase.of(family, family.threshold)
    if not regions:
        return FamilyEvaluation(family, answers, worst, digits)
    answers = {name: e.with_regions() for name, e in answers.items()}
    return FamilyEvaluation(family, answers, worst, digits, compared_all(family, answers, worst))
