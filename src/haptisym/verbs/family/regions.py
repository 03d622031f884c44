"""Does the conclusion for several environments survive another JND model?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from haptisym.judge.evaluation import Evaluation
from haptisym.judge.spread import OWN, Compared
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.shown import Shown
from haptisym.model.family import SceneFamily
from haptisym.model.jnd import Threshold
from haptisym.verbs.family.worst import FamilyBinding, WorstCase


@dataclass(frozen=True, repr=False)
class FamilyCompared(Shown):
    """What one region says of all environments together, and of each: ``answers``, by the names of the environments."""

    name: str
    threshold: Threshold
    worst: WorstCase
    answers: Mapping[str, Compared]

    def _line(self) -> str:
        return f"{self.name}: common bandwidth {self.bandwidth.digits(5) if self.bandwidth else 'none'}"

    @property
    def bandwidth(self) -> RealNumber | None:
        """The common one."""
        return self.worst.bandwidth

    @property
    def first(self) -> tuple[FamilyBinding, ...]:
        """Who binds at the first end of the common transparent set; none where it is the whole band."""
        bound = self.worst.binding
        return tuple(x for x in bound if x.omega is bound[0].omega)

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        return not self.worst.chart.undecided and all(x.certified for x in self.answers.values())

    def row(self, digits: int) -> dict[str, Any]:
        """As a row of a document."""
        return {
            "region": self.name,
            "threshold": self.threshold.row(),
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "binding": [binding_row(x, digits) for x in self.first],
            "certified": self.certified,
        }


def binding_row(x: FamilyBinding, digits: int) -> dict[str, Any]:
    """Who binds where, as documents have it."""
    return {
        "at": float(x.omega),
        "digits": x.omega.digits(digits),
        "enclosure": list(x.omega.enclosure(digits)),
        "environment": x.environment,
        "part": x.criterion.name,
    }


def compared_all(family: SceneFamily, answers: Mapping[str, Evaluation], own: WorstCase) -> tuple[FamilyCompared, ...]:
    """Square, disc and diamond of the JND's half widths, and the JND itself: each judges all environments.

    ``answers`` : of each environment, with its regions. ``own`` : what the JND itself says of all of them.
    """
    models = {x.name: x.threshold for x in next(iter(answers.values())).regions}
    each = {name: {who: _of(e, name) for who, e in answers.items()} for name in models}
    return tuple(
        FamilyCompared(name, model, own if name == OWN else WorstCase.of(family, model), each[name])
        for name, model in models.items()
    )


def _of(e: Evaluation, name: str) -> Compared:
    return next(x for x in e.regions if x.name == name)
