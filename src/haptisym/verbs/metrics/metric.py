"""One measure of transparency: its closed forms, its proven numbers, its source, and what it says."""

from __future__ import annotations

from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.judge.evaluation import Evaluation
from haptisym.kernel.errors import SceneError
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.shown import Shown, counted, titled
from haptisym.model.scene import Scene
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


@dataclass(frozen=True, repr=False)
class Metrics(Answer):
    """All measures of a scene, its JND evaluation, and where they disagree (``notes``)."""

    _schema: ClassVar[str] = "haptisym.metrics/1"
    _page: ClassVar[str] = "haptisym.pages.metrics:page"
    _figure: ClassVar[str] = "haptisym.figures.metrics:metrics_figure"

    evaluation: Evaluation
    metrics: tuple[Metric, ...]
    notes: tuple[str, ...]
    measured: Measured
    tell_absolute: bool = False

    @property
    def told(self) -> tuple[Metric, ...]:
        """Those of the page: absolute stability, which most displays lack, where it holds or is asked for."""
        is_absolute = self["absolute stability"].verdict.startswith("absolutely stable")
        return tuple(x for x in self.metrics if self.tell_absolute or is_absolute or x.name != "absolute stability")

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self.metrics), 'measure')}"

    @property
    def scene(self) -> Scene:
        """That of the evaluation."""
        return self.evaluation.scene

    @property
    def certified(self) -> bool:
        """Whether nothing that a measure is read off was left undecided."""
        return self.measured.certified

    def __getitem__(self, name: str) -> Metric:
        for metric in self.metrics:
            if metric.name == name:
                return metric
        raise SceneError(f'no measure is called "{name}": these are {", ".join(x.name for x in self.metrics)}')

    def _body(self) -> dict[str, Any]:
        e = self.evaluation
        return {
            "band": [float(e.chart.points[i].omega) for i in (0, -1)],
            "jnd": {
                "threshold": e.scene.threshold.row(),
                "transparent": _pairs(e.transparent),
                "bandwidth": None if e.bandwidth is None else float(e.bandwidth),
            },
            "metrics": [_metric_row(x) for x in self.metrics],
            "notes": list(self.notes),
            **({"caveats": list(e.caveats)} if e.caveats else {}),
            "certified": self.certified,
        }


_FORMULAS = "haptisym.pages.metrics:formulas"
"""What writes the formulas of a measure; loaded when they are wanted."""


def _metric_row(x: Metric) -> dict[str, Any]:
    return {
        "name": x.name,
        "formula": resolve_name(_FORMULAS)(x),
        "values": [_value_row(v) for v in x.values],
        "unit": next((v.unit for v in x.values), ""),
        "source": x.source,
        "evidence": x.evidence,
        "verdict": x.verdict,
    }


def _value_row(x: Value) -> dict[str, Any]:
    found = {"what": x.what, "value": _plain(x.value), "unit": x.unit}
    if x.reference is None:
        return found
    return {**found, "environment": _plain(x.reference), "tolerance": x.tolerance, "kept": x.kept}


def _plain(value: RealNumber | int | str | Bands | None) -> Any:
    """A number, a list of bands, a word, or null for what is infinite."""
    if isinstance(value, tuple):
        return _pairs(value)
    return float(value) if isinstance(value, RealNumber) else value


def _pairs(bands: Bands) -> list[list[float]]:
    return [[float(x.low.omega), float(x.high.omega)] for x in bands]
