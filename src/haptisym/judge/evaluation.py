"""The two-step evaluation of a scene, and its answers as text and JSON."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from haptisym.judge.answers import Answers
from haptisym.judge.crossings import Crossing, curves
from haptisym.kernel.errors import SceneError
from haptisym.kernel.periodic import Turned
from haptisym.kernel.polynomials import Root
from haptisym.kernel.reals import ExactNumber, bits_for
from haptisym.kernel.roots import Interval, chart
from haptisym.kernel.shown import Answer, counted, titled
from haptisym.kernel.stability import is_stable
from haptisym.kernel.zeros import Zero
from haptisym.model.caveats import sampled_loop
from haptisym.model.quantities import Number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene

if TYPE_CHECKING:
    from haptisym.verbs.effects.entry import Relevance


class Effort(NamedTuple):
    """What the crossings' digits took: the method that encloses them, the least working precision, bits, and the time, s."""

    method: str
    bits: int
    seconds: float


_METHODS = {
    Root: "certified polynomial roots",
    Turned: "arctangents of certified polynomial roots",
    Zero: "interval Newton in ball arithmetic",
    ExactNumber: "closed form",
}


@dataclass(frozen=True, repr=False)
class Evaluation(Answer, Answers):
    """The answers for a scene; ``print`` shows them as a page of text, ``to_json`` gives the command line's document."""

    _page = "haptisym.pages.evaluation:page"
    isolation: float = field(default=0.0, repr=False, compare=False)
    """Seconds in which everything that happens on the band was found and set apart."""

    def _line(self) -> str:
        width = "no bandwidth" if self.bandwidth is None else f"bandwidth {self.bandwidth.digits(5)} rad/s"
        found = counted(len(self.crossings), "crossing"), counted(len(self.percepts), "percept")
        return f"{titled(self.scene.title)}: {width}, {', '.join(found)}"

    @cached_property
    def effort(self) -> Effort:
        """How the crossings are computed to their digits, and in which time: that of ``isolation`` and of refining them now."""
        started = time.perf_counter()
        for crossing in self.crossings:
            crossing.omega.digits(self.digits)
        kinds = {_METHODS.get(type(crossing.omega), "bisection") for crossing in self.crossings}
        seconds = self.isolation + time.perf_counter() - started
        return Effort(", ".join(sorted(kinds)) or "none needed", bits_for(self.digits), seconds)

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
            **({"unnamed": [_interval(x) for x in self.unnamed]} if self.unnamed else {}),
            "unbounded": [float(p.omega) for p in self.unbounded],
            "stable": self.stable,
            "any_environment": self._any_environment(),
            "certified": self.certified,
            **({"caveats": list(self.caveats)} if self.caveats else {}),
            **self.given.aside_keys(),
            **self._undecided(),
            **self._relevance(),
        }

    def _any_environment(self) -> dict[str, float | None] | None:
        found = self.any_environment
        if found is None:
            return None
        ends = {"transparent_below": found.transparent_below, "opaque_above": found.opaque_above}
        return {name: None if omega is None else float(omega) for name, omega in ends.items()}

    def _undecided(self) -> dict[str, Any]:
        """The key ``undecided``, present only where something is."""
        rows = [{"part": part.value, "enclosure": list(p.omega.enclosure(self.digits))} for part, p in self.undecided]
        return {"undecided": rows} if rows else {}

    def _relevance(self) -> dict[str, Any]:
        """The key ``relevance``, present only where a tolerance was given: what was left out, and the proven bound on it."""
        r = self.relevance
        if r is None:
            return {}
        from haptisym.pages.effects import pruned  # loaded where it is asked for

        names = {"kept": [e.name for e in r.pruned.effects], "dropped": [e.name for e in r.dropped]}
        return {"relevance": {"tolerance": float(r.tolerance), **names, **pruned(r)}}

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


def evaluate(scene: Scene | str | Path, digits: int = 15, *, tolerance: Number | None = None) -> Evaluation:
    """Evaluate a scene with numbers for all parameters; ``digits`` decimal digits of each crossing, as many as wanted.

    ``tolerance`` : if given, only the effects that matter for it are used (see ``relevance``); the answers are those of the scene
    without the others, and ``relevance`` says by how much the full scene's ratios may differ, and where its crossings are.
    Raises SceneError if a parameter is still a symbol.

    >>> from haptisym import effects, environments
    >>> scene = Scene(environments.mass_spring_damper(1.8, 15, 100), (effects.second_order_lowpass(80, 0.5),))
    >>> [c.omega.digits(20) for c in evaluate(scene).crossings]
    ['7.9789167901747077028', '11.937310924322057781']
    """
    scene = as_scene(scene)
    if not isinstance(digits, int) or digits < 1:
        raise SceneError(f"digits: {digits} must be a whole number, at least 1")
    scene.knobs.need_numbers()
    found = None if tolerance is None else _relevance(scene, tolerance)
    used = scene if found is None else found.pruned
    distortion = used.distortion()
    started = time.perf_counter()
    table = chart(curves(distortion, used.threshold), *used.band)
    isolation = time.perf_counter() - started
    stable = None if sampled_loop(used) else is_stable(distortion.perc)
    return Evaluation(used, distortion, table, stable, digits, found, isolation)


def _relevance(scene: Scene, tolerance: Number) -> Relevance:
    from haptisym.verbs.effects.entry import relevance  # loaded where it is asked for

    return relevance(scene, tolerance)


def _interval(x: Interval) -> list[float]:
    return [float(x.low.omega), float(x.high.omega)]
