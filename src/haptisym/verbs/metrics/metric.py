"""One measure of transparency: its closed forms, its proven numbers, its source, and what it says."""

from __future__ import annotations

from dataclasses import dataclass, field

from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.shown import Shown
from haptisym.verbs.metrics.forms import Form
from haptisym.verbs.metrics.measured import Bands, Measured


@dataclass(frozen=True)
class Value:
    """One number of a measure, or bands, or a word; None where it is infinite. ``unit`` is empty for a ratio.

    Where there is a tolerance: ``reference`` is the environment's own number, ``kept`` whether the value is near enough.
    """

    what: str
    value: RealNumber | int | str | Bands | None
    unit: str = ""
    reference: RealNumber | int | None = None
    tolerance: str = ""
    kept: bool = True


@dataclass(frozen=True, repr=False)
class Metric(Shown):
    """A measure: ``forms`` its closed forms, ``values`` its numbers, ``evidence`` how well ``source`` is known to say so."""

    name: str
    forms: tuple[Form, ...]
    values: tuple[Value, ...]
    source: str
    evidence: str
    verdict: str

    def _line(self) -> str:
        return f"{self.name}: {self.verdict}"


@dataclass(frozen=True)
class MetricRows:
    """All measures of a scene, its JND evaluation, and where they disagree (``notes``)."""

    evaluation: Evaluation
    metrics: tuple[Metric, ...]
    notes: tuple[str, ...]
    measured: Measured = field(repr=False)

    def __getitem__(self, name: str) -> Metric:
        for metric in self.metrics:
            if metric.name == name:
                return metric
        raise SceneError(f'no measure is called "{name}": these are {", ".join(x.name for x in self.metrics)}')
