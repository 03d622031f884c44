"""The answers of a sweep for single sets of parameters, exact: from the certified chart of an evaluation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from sympy import Expr, Rational

from haptisym.judge.criteria import judged, kept, noticed
from haptisym.judge.crossings import Curve
from haptisym.judge.percepts import changeovers
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.lattices import Signed
from haptisym.kernel.roots import Chart, Key, Point, chart
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.sweep.told import ABSENT, EXACT, Told

AnswerRow: TypeAlias = dict[str, float]

LONGEST = 10.0  # s for one set


def exact_answers(scene: Scene, swept: Sequence[Knob], values: Sequence[float]) -> AnswerRow:
    """All variables of a sweep for one set of values, which are taken as exactly the binary numbers that the floats are.

    None of it where that takes longer than ``LONGEST`` seconds.
    """
    exact = [Rational(*Fraction(float(x)).as_integer_ratio()) for x in values]
    try:
        with limited(LONGEST):
            found = _chart(scene, swept, exact)
    except (SceneError, UndecidedError):  # no dynamics at all here (H_env = 0 everywhere, C H + D = 0), or a doubt
        return Told.of(scene).no_answer()
    return Told.of(scene).no_answer() if found.undecided else _row(found)


def _chart(scene: Scene, swept: Sequence[Knob], values: Sequence[Expr]) -> Chart:
    given = {x.symbol: value for x, value in zip(swept, values, strict=True)}
    limits = {part: value for x, value in zip(swept, values, strict=True) for part in x.parts}
    known = {p.symbol: p.value for p in scene.parameters}
    d = Distortion.of(scene.chain.at({**known, **given}))
    threshold = scene.threshold.with_limits(limits)
    asked: dict[Key, Signed] = {x: x.function(d) for x in noticed(threshold)}
    asked[Curve.ENVIRONMENT, Part.REAL] = part_of(d.env_response, Part.REAL)
    asked[Curve.PERCEIVED, Part.REAL] = part_of(d.perc_response, Part.REAL)
    return chart(asked, *scene.band)


def _row(found: Chart) -> AnswerRow:
    row: AnswerRow = {"method": EXACT, **_step(found)}
    places: Mapping[str, Sequence[Point]] = {
        "environment": changeovers(found, Curve.ENVIRONMENT),
        "perceived": changeovers(found, Curve.PERCEIVED),
    }
    for name, points in places.items():
        row[f"changeovers_{name}"] = len(points)
        row[f"changeover_{name}"] = _first(points)
    return row


def _step(found: Chart) -> AnswerRow:
    """When: crossings and what is transparent."""
    row: AnswerRow = {}
    for x in judged(found):
        points = [p for p in found.points if p.orders.get(x, 0) > 0]
        row[f"crossings_{x.name}"] = len(points)
        row[f"first_crossing_{x.name}"] = _first(points)
    intervals = kept(found)
    low, high = (float(found.points[i].omega) for i in (0, -1))
    clear = sum(float(x.high.omega) - float(x.low.omega) for x in intervals)
    begins = intervals and intervals[0].low is found.points[0]
    row["transparent"] = clear / (high - low)
    row["bandwidth"] = float(intervals[0].high.omega) if begins else ABSENT
    return row


def _first(points: Sequence[Point]) -> float:
    return float(points[0].omega) if points else ABSENT
