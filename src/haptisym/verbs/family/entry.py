"""The evaluation of several environments at once, and its answers as text and JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from haptisym.judge.evaluation import evaluate
from haptisym.kernel.shown import Answer, counted, titled
from haptisym.model.family import SceneFamily
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_family
from haptisym.pages.family import page
from haptisym.verbs.family.worstcase import Binding, WorstCase, common_chart


class FamilyEvaluation(Answer, WorstCase):
    """The answers for a family; ``print`` shows them as a page of text, ``to_json`` gives the command line's document."""

    def _line(self) -> str:
        width = (
            "no common bandwidth" if self.bandwidth is None else f"common bandwidth {self.bandwidth.digits(5)} rad/s"
        )
        return f"{titled(self.family.title)}: {counted(len(self.answers), 'environment')}, {width}"

    def __str__(self) -> str:
        return page(self)

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym evaluate --json`` for several environments, schema ``haptisym.evaluations/1``."""
        each = [{"name": name, **x.to_dict()} for name, x in self.answers.items()]  # type: ignore[attr-defined]
        return {
            "schema": "haptisym.evaluations/1",
            "title": self.family.title,
            "band": [float(point.omega) for point in (self.chart.points[0], self.chart.points[-1])],
            "threshold": {"real": str(self.family.threshold.real), "imag": str(self.family.threshold.imag)},
            "environments": each,
            "transparent": [[float(x.low.omega), float(x.high.omega)] for x in self.transparent],
            "binding": [self._binding(x) for x in self.binding],
            "bandwidth": None if self.bandwidth is None else float(self.bandwidth),
            "certified": self.certified,
            **({"nominal": ranges} if (ranges := self.family.ranges()) else {}),
        }

    def _binding(self, x: Binding) -> dict[str, Any]:
        return {
            "at": float(x.omega),
            "digits": x.omega.digits(self.digits),
            "enclosure": list(x.omega.enclosure(self.digits)),
            "environment": x.environment,
            "part": x.part.value,
        }

    def to_json(self) -> str:
        """The document of ``haptisym evaluate --json`` as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)


def evaluate_all(family: SceneFamily | Scene | str | Path, digits: int = 15) -> FamilyEvaluation:
    """Evaluate one display with several environments: each, the band on which all are transparent, and who binds there.

    ``digits`` : decimal digits of each crossing. Guaranteed: the common transparent set is the intersection of the
    environments' own; its ends are proven, and which environment they belong to. Raises SceneError if a parameter is still
    a symbol, UndecidedError where two ends could not be told apart.

    >>> from haptisym.model.scenefile import load_scenes
    >>> found = evaluate_all(load_scenes("fu2019", ["fu2019", "helicopter-cyclic"]))
    >>> [(x.omega.digits(6), x.environment, x.part.value) for x in found.binding]
    [('7.97892', 'fu2019', 'real')]
    """
    family = as_family(family)
    answers = {name: evaluate(scene, digits) for name, scene in family.scenes.items()}
    return FamilyEvaluation(family, answers, common_chart(family), digits)
