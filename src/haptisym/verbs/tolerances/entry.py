"""Tolerances as a result: what holds for all values within the ranges of a scene, as text and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sympy import Expr

from haptisym.kernel.budget import Told, limited, share
from haptisym.kernel.errors import SceneError
from haptisym.kernel.shown import Answer, counted, titled
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.pages.tolerances import page
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.proofs import BoxAnswers, Enclosure, One, drawn
from haptisym.verbs.tolerances.quantiles import quantiles

SEED = 2019


class Tolerances(Answer, BoxAnswers):
    """The answers for all values within the ranges; ``print`` shows them, ``to_json`` gives the document."""

    def _line(self) -> str:
        sides = ", ".join(x.name for x in self.box.sides)
        found = counted(len(self.enclosures), "enclosure")
        return f"{titled(self.box.scene.title)}: {sides} in their ranges, transparent for {self.verdict.value}, {found}"

    def __str__(self) -> str:
        return page(self)

    def to_dict(self) -> dict[str, Any]:
        """The document of ``haptisym tolerances --json``, schema ``haptisym.tolerances/1``."""
        scene = self.box.scene
        sides = [{"name": x.name, "low": float(x.low), "high": float(x.high)} for x in self.box.sides]
        return {
            "schema": "haptisym.tolerances/1",
            "title": scene.title,
            "band": [float(x) for x in scene.band],
            "varying": sides,
            "verdict": self.verdict.value,
            "witnesses": {"transparent": _witness(self.transparent), "noticed": _witness(self.noticed)},
            "crossings": [self._enclosure_row(x) for x in self.enclosures],
            "bandwidth": None if self.bandwidth is None else [float(x) for x in self.bandwidth],
            "estimates": self._estimates(),
            "certified": self.certified,
            **(
                {"untied": [list(pair) for pair in scene.untied(scene.ranges())]}
                if scene.untied(scene.ranges())
                else {}
            ),
            **({} if self.limit is None else {"limit": self.limit}),
        }

    def to_json(self) -> str:
        """The document of ``haptisym tolerances --json`` as text."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)

    def _enclosure_row(self, x: Enclosure) -> dict[str, Any]:
        corners = {"low": _values(x.at_low), "high": _values(x.at_high)}
        enclosure = [x.low.enclosure()[0], x.high.enclosure()[1]]
        row = {"part": x.part.value, "omega": [float(x.low), float(x.high)], "enclosure": enclosure}
        return {**row, "count": x.count, "reached_at": corners, "monotonic": dict(x.monotonic)}

    def _estimates(self) -> dict[str, Any] | None:
        if not self.samples:
            return None
        q = quantiles(self)
        rows = {"first_crossing": q.first, "bandwidth": q.bandwidth}
        shown = {key: {str(p): x for p, x in row.items()} for key, row in rows.items()}
        return {"samples": len(self.samples), "seed": self.seed, **shown, "transparent": q.transparent}


def tolerances(
    scene: Scene | str | Path,
    samples: int = 200,
    seed: int = SEED,
    *,
    limit: float | None = None,
    told: Told | None = None,
) -> Tolerances:
    """What holds for all values of a scene's parameters within their ranges.

    Guaranteed: the verdict where it is not ``Verdict.UNDECIDED``; that crossings lie in the enclosures and nowhere else; how many
    there are where a count is given; ends said to be reached at a corner are exact. Estimated: quantiles over ``samples`` sets
    of values, each answered with certainty, drawn uniformly with a seed. SceneError where no parameter has a range.

    ``limit`` : seconds after which the work is cut short: enclosures are then wider than they need be, the verdict may be
    undecided and fewer sets be drawn; None for no limit. ``told`` : is called now and then with how much is done, of how much,
    and what it is. LimitError if not even the nominal values were answered in time.

    >>> from haptisym import effects, environments
    >>> spring = environments.mass_spring_damper(k="100 N/m +- 10 %")
    >>> lag = effects.first_order_lag("40 rad/s +- 10 %")
    >>> found = tolerances(Scene(spring, (lag,)), samples=0)
    >>> found.verdict.value, [(x.part.value, x.low.digits(5), x.high.digits(5), x.count) for x in found.enclosures]
    ('none', [('imag', '3.6367', '4.4449', 1), ('real', '12.000', '14.667', 1)])
    """
    scene = as_scene(scene)
    if not isinstance(samples, int) or samples < 0:
        raise SceneError(f"samples: {samples} must be a whole number, at least 0")
    box = box_of(scene)
    with limited(limit, told) as budget:
        with share(_FOR_SAMPLES):
            found = Tolerances(box, drawn(box, samples, seed), seed, budget)
        found.settle()
    return found


_FOR_SAMPLES = 0.3  # of the time


def _witness(one: One | None) -> dict[str, str] | None:
    return None if one is None else _values(one.values)


def _values(values: Mapping[str, Expr] | None) -> dict[str, str] | None:
    return None if values is None else {name: str(x) for name, x in values.items()}
