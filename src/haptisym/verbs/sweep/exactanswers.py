"""What are the answers of a sweep for one parameter set, in exact arithmetic?

For the few sets that floats leave undecided: the certified *chart* (``kernel.roots``: all zeros of
several functions on a band, and the signs in between, proven) of an evaluation, and the exact count
of roots in a hand. Values of parameters are taken as exactly the binary numbers that the floats
are. A sweep has very many sets: each has ``_LONGEST_EXACT`` seconds, and none has an error; what is
not answered is said so in the row.

Begin with ``exact_answers``; ``exact_count`` is for hands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from sympy import Expr, Rational

from haptisym.judge.crossings import PerceptFunction, judged, kept, noticed
from haptisym.judge.percepts import changeovers
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.roots import Chart, Key, Point, Signed, chart
from haptisym.model.distortion import Distortion, part_of
from haptisym.model.jnd import Part
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.sweep.axes import ABSENT, EXACT, INFINITE, UNKNOWN, SweepVariables

_LONGEST_EXACT = 10.0
"""Seconds for one set in exact arithmetic. A sweep has very many: one that is harder is left
without an answer."""

AnswerRow: TypeAlias = dict[str, float]
"""By the name of a variable its value for one set."""


def exact_answers(scene: Scene, swept: Sequence[Knob], values: Sequence[float]) -> AnswerRow:
    """All variables of a sweep but those of hands for one set of values, which are taken as exactly
    the binary numbers that the floats are; the row of a set without answers where something stays
    undecided, or takes longer than ``_LONGEST_EXACT`` seconds.
    """
    exact = [_rational(x) for x in values]
    no_answer = SweepVariables.of(scene).no_answer()
    try:
        with limited(_LONGEST_EXACT):
            table = _chart(scene, swept, exact)
    # There are no dynamics for these values: H_env = 0 everywhere, or H_perc is divided by 0. Or it
    # stays undecided.
    except (SceneError, UndecidedError):
        return no_answer
    return no_answer if table.undecided else _row(table)


def _rational(x: float) -> Rational:
    """A float as exactly the number that it is."""
    return Rational(*Fraction(float(x)).as_integer_ratio())


def _chart(scene: Scene, swept: Sequence[Knob], values: Sequence[Expr]) -> Chart:
    """The certified zeros and signs of all functions of a scene for one set of values."""
    pairs = list(zip(swept, values, strict=True))
    given = {x.symbol: value for x, value in pairs}
    limits = {part: value for x, value in pairs for part in x.parts}
    known = {p.symbol: p.value for p in scene.parameters}
    d = Distortion.of(scene.chain.at({**known, **given}))
    threshold = scene.threshold.with_limits(limits)
    functions: dict[Key, Signed] = {x: x.function(d) for x in noticed(threshold)}
    responses = {
        PerceptFunction.ENVIRONMENT: d.env_response,
        PerceptFunction.PERCEIVED: d.perc_response,
    }
    for system, response in responses.items():
        functions[system, Part.REAL] = part_of(response, Part.REAL)
    return chart(functions, *scene.band)


def _row(table: Chart) -> AnswerRow:
    """All variables of a set but those of hands, read off its chart."""
    row: AnswerRow = {"method": EXACT, **_crossings_and_bandwidth(table)}
    points_of: Mapping[str, Sequence[Point]] = {
        "environment": changeovers(table, PerceptFunction.ENVIRONMENT),
        "perceived": changeovers(table, PerceptFunction.PERCEIVED),
    }
    for name, points in points_of.items():
        row[f"changeovers_{name}"] = len(points)
        row[f"changeover_{name}"] = _first_frequency(points)
    return row


def _crossings_and_bandwidth(table: Chart) -> AnswerRow:
    """The variables that say when something is noticed: crossings, bandwidth, transparent share."""
    row: AnswerRow = {}
    for x in judged(table):
        points = [p for p in table.points if p.orders.get(x, 0) > 0]
        row[f"crossings_{x.name}"] = len(points)
        row[f"first_crossing_{x.name}"] = _first_frequency(points)
    intervals = kept(table)
    low, high = (float(table.points[i].omega) for i in (0, -1))
    lengths = (float(x.high.omega) - float(x.low.omega) for x in intervals)
    end = table.reach(intervals)
    row["transparent"] = sum(lengths) / (high - low)
    row["bandwidth"] = ABSENT if end is None else float(end)
    return row


def _first_frequency(points: Sequence[Point]) -> float:
    """The frequency of the first point, rad/s; ABSENT where there is none."""
    return float(points[0].omega) if points else ABSENT


def exact_count(scene: Scene, index: int, swept: Sequence[Knob], values: Sequence[float]) -> int:
    """The number of roots in Re s >= 0 in the hand of that index for one set, whose values are
    taken as exactly the binary numbers that the floats are. INFINITE for a chain of infinitely many
    roots; UNKNOWN where it stays undecided, or takes longer than ``_LONGEST_EXACT`` seconds."""
    # Loaded for scenes with hands alone: counting roots brings much else.
    from haptisym.verbs.stability.held import unstable_roots

    pairs = zip(swept, values, strict=True)
    try:
        # Thresholds do not move roots.
        at = scene.with_values({x.path: _rational(value) for x, value in pairs if not x.parts})
        with limited(_LONGEST_EXACT):
            roots = unstable_roots(at, at.hands[index])
    except (SceneError, UndecidedError):
        return UNKNOWN
    if roots.number is not None:
        return roots.number
    return INFINITE if roots.chain else UNKNOWN
