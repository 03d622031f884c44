"""What accuracy costs in time for a scene: digits and seconds of several methods, measured now,
against certified references of higher precision.

Methods take turns, so that a slow moment of a machine that others use too slows all of them equally
(``interleaved``). The tasks are the ratios, the crossings, and the crossings with approximated
delays and with each effect left out. ``cost`` is where to begin reading.
"""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from math import isinf
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar, TypeVar

import numpy as np
from sympy import Expr, cosh, exp, sinh

from haptisym import effects
from haptisym.judge.answers import Answer
from haptisym.kernel.budget import forget, spared
from haptisym.kernel.errors import HaptisymError, SceneError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.rings import s
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.cost.methods import (
    CROSSINGS,
    RATIO_METHODS,
    Attempt,
    Crossings,
    FoundCrossings,
    Method,
    RatioQuestion,
    Score,
    UnfitMethodError,
)

Key = TypeVar("Key", bound=Hashable)
_PACKAGES = ("numpy", "sympy", "python-flint", "scipy", "control", "numba")
# A turn that takes less than ``_SHORT`` seconds is repeated so often in a row, and the quickest run
# counts: the first one finds caches filled by the method before it.
_IN_A_ROW, _SHORT = 3, 0.01


@dataclass(frozen=True)
class MedianTime:
    """The median of the seconds that an attempt took, and what it answered.

    ``spread`` : half of the range in which the middle half of its turns lies, over the median; None
    of fewer than four turns.
    """

    seconds: float
    answer: Any
    spread: float | None = None


def interleaved(
    attempts: Mapping[Key, Callable[[], Any]],
    budget: float,
    *,
    rounds: int = 15,
    told: Callable[[Key, int], None] = lambda key, at: None,
) -> dict[Key, MedianTime]:
    """Every attempt once to warm up, then in turns: at most so many rounds, and none begun after
    ``budget`` seconds.

    An attempt whose first run took more than an eighth of the budget is not repeated. In a turn
    short ones run several times in a row, and the quickest counts: the first pays for what was left
    behind before it. ``told`` is called with each key and its place as its first run begins. An
    attempt that raises a HaptisymError has that for its answer. No attempt profits from certified
    zeros that another one found.

    >>> found = interleaved({"sum": lambda: sum(range(100)), "constant": lambda: 1}, 0.01)
    >>> found["sum"].answer, found["sum"].seconds > found["constant"].seconds
    (4950, True)
    """
    began, answers, first = perf_counter(), {}, {}
    for at, (key, attempt) in enumerate(attempts.items()):
        told(key, at)
        first[key], answers[key] = _once(attempt)
    turns: dict[Key, list[float]] = {key: [] for key in attempts}
    repeated = [key for key in attempts if first[key] <= budget / 8]
    # a limit in time would raise within a measurement
    with spared():
        for _ in range(rounds):
            if perf_counter() - began > budget:
                break
            for key in repeated:
                often = _IN_A_ROW if first[key] < _SHORT else 1
                turns[key].append(min(_once(attempts[key])[0] for _ in range(often)))
    measured: dict[Key, MedianTime] = {}
    for key in attempts:
        # the first run, which pays for imports and caches, only where there is no other
        taken = turns[key] or [first[key]]
        measured[key] = MedianTime(statistics.median(taken), answers[key], _spread(taken))
    return measured


def _spread(turns: list[float]) -> float | None:
    """Half the distance of the quartiles over the median; None of fewer than four turns."""
    if len(turns) < 4:
        return None
    low, middle, high = statistics.quantiles(turns, n=4)
    return (high - low) / (2 * middle)


def _once(attempt: Callable[[], Any]) -> tuple[float, Any]:
    """The seconds of one run and its answer, or the error that it raised."""
    # certified zeros are remembered between calls: a run must not profit from another one's
    forget()
    started = perf_counter()
    try:
        answer = attempt()
    except HaptisymError as refusal:
        answer = refusal
    return perf_counter() - started, answer


def machine() -> dict[str, str]:
    """What is measured on: interpreter, processor count and versions; "absent" for a package that
    is not installed."""

    def of(name: str) -> str:
        try:
            return version(name)
        except PackageNotFoundError:
            return "absent"

    return {
        platform.python_implementation(): platform.python_version(),
        "processors": f"{os.cpu_count()} x {platform.machine()}",
        **{name: of(name) for name in _PACKAGES},
    }


_SCATTER = 0.15  # of the middle half of the repeats: quiet machines have 0.02 to 0.1


@dataclass(frozen=True)
class CostMeasurement:
    """One measurement: digits and time of one method at one task.

    ``task`` : evaluate, crossings, delay or effects. ``digits`` : right decimal digits of the worst
    number.
    ``seconds`` : median time; of ``evaluate`` for one frequency, of the other tasks for the whole
    answer. ``spread`` : half of the range of the middle half of the repeats, over it; None of fewer
    than four. ``proven`` : whether the answer is proven.
    ``missed``, ``invented`` : crossings that are there and not found, found and not there.
    """

    task: str
    method: str
    digits: float
    seconds: float
    proven: bool
    missed: int = 0
    invented: int = 0
    spread: float | None = None

    def row(self) -> dict[str, Any]:
        """The measurement as a row of a document, without what is None."""
        return {key: x for key, x in asdict(self).items() if x is not None}

    @property
    def complete(self) -> bool:
        """Whether no crossing is missed and none invented."""
        return not (self.missed or self.invented)

    @property
    def wrong(self) -> str:
        """What is wrong with a count of crossings; "" where nothing is."""
        return wrong_words(self.missed, self.invented)


def wrong_words(missed: int, invented: int) -> str:
    """``misses 2 and invents 1``; "" where nothing is wrong."""
    return " and ".join(
        f"{word} {n}" for word, n in (("misses", missed), ("invents", invented)) if n
    )


@dataclass(frozen=True)
class Omission:
    """A method that was not measured, and why."""

    task: str
    method: str
    reason: str


def front(rows: Iterable[CostMeasurement]) -> tuple[CostMeasurement, ...]:
    """The rows that no other one beats in both digits and time, fastest first; those with wrong
    counts are left out.

    >>> slow, fast, worse = (CostMeasurement("evaluate", "", n, t, False) for n, t in ((30, 2.0), (15, 1.0), (14, 1.5)))
    >>> front([slow, fast, worse]) == (fast, slow)
    True
    """
    best: list[CostMeasurement] = []
    # in order of time a row is on the front if it has more digits than any faster one
    for row in sorted((x for x in rows if x.complete), key=lambda x: (x.seconds, -x.digits)):
        if not best or row.digits > best[-1].digits:
            best.append(row)
    return tuple(best)


@dataclass(frozen=True, repr=False)
class Cost(Answer):
    """Accuracy against time for a scene: measured on this ``machine``, so another one gives other
    times. Made by ``cost``.

    ``rows`` : for each task and method the correct decimal digits, against a proven reference, and
    the median time, s.
    ``left_out`` : methods that were not measured, with the reason. ``condition`` : of each task the
    relative change of its result over that of what is given, infinite at a tangency. ``summary`` :
    the time of a digit, in a sentence.
    """

    _schema: ClassVar[str] = "haptisym.cost/1"
    _page: ClassVar[str] = "haptisym.pages.cost:page"
    settled = True
    _figure: ClassVar[str] = "haptisym.figures.cost:COST"

    scene: Scene
    rows: tuple[CostMeasurement, ...]
    left_out: tuple[Omission, ...]
    condition: Mapping[str, float]
    machine: Mapping[str, str] = field(default_factory=machine)

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self.rows), 'measurement')}"

    @property
    def certified(self) -> bool:
        """False: times are measured."""
        return False

    @property
    def busy(self) -> bool:
        """Whether the repeats scatter so much that something else was running: then no sentence is
        made of the times."""
        spreads = [x.spread for x in self.rows if x.spread is not None]
        return bool(spreads) and statistics.median(spreads) > _SCATTER

    @property
    def summary(self) -> str:
        """What a digit costs here, in a sentence; where times scatter too much, that they do."""
        if self.busy:
            return "This machine is busy: times are not to be trusted."
        crossings = self.task("crossings")
        proven = sorted((x for x in crossings if x.proven), key=lambda x: x.digits)
        if len(proven) < 2:
            return "Here not all crossings are proven."
        first, last = proven[0], proven[-1]
        each = (last.seconds - first.seconds) / (last.digits - first.digits)
        # a difference of two times within the scatter of both is none
        lost = sum((x.spread or 0) * x.seconds for x in (first, last))
        grids = [x for x in crossings if x.method.startswith("grid") and x.method[-1].isdigit()]
        price = (
            f"{duration(each)} a digit"
            if last.seconds - first.seconds > lost
            else "no time that shows"
        )
        said = (
            f"Here all crossings, proven, to {first.digits:.0f} digits take "
            f"{duration(first.seconds)}; more digits cost {price}: "
            f"{last.digits:.0f} of them take {duration(last.seconds)}"
        )
        if grids:
            x = max(grids, key=lambda x: x.seconds)
            found = (
                f"for {x.digits:.1f} digits, and proves nothing" if x.complete else f"and {x.wrong}"
            )
            said += f"; a {x.method} points takes {duration(x.seconds)} {found}"
        return f"{said}."

    def task(self, name: str) -> tuple[CostMeasurement, ...]:
        """The rows of one task."""
        return tuple(row for row in self.rows if row.task == name)

    def _body(self) -> dict[str, Any]:
        return {
            "band": [float(x) for x in self.scene.band],
            "summary": self.summary,
            "busy": self.busy,
            "condition": {task: None if isinf(x) else x for task, x in self.condition.items()},
            "rows": [row.row() for row in self.rows],
            "left_out": [asdict(x) for x in self.left_out],
            "machine": dict(self.machine),
        }


def duration(seconds: float) -> str:
    """A time with three digits and a readable unit.

    >>> duration(0.00123456), duration(3.2e-7)
    ('1.23 ms', '320 ns')
    """
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= unit:
            return f"{float(f'{seconds / unit:.3g}'):g} {name}"
    return f"{float(f'{seconds / 1e-9:.3g}'):g} ns"


Progressed = Callable[[str, float], None]
"""Is called with what is measured next and the share that is done, from 0 to 1."""
_ROUNDS = 25
_BUDGETS = {"evaluate": 4.0, "crossings": 4.0, "delay": 2.0, "effects": 2.0}
"""Seconds after which no repeats of a task are begun."""
_DIGITS = 15
"""Digits of the crossings when delays are approximated or effects left out: their time and shift
are compared."""
_PADE_ORDERS = range(1, 7)
_MANY = 10_000  # frequencies at once


@dataclass(frozen=True)
class Task:
    """One question: the attempts at it, by method, and how their answers are scored."""

    name: str
    attempts: Mapping[Method, Attempt]
    score: Callable[[Method, Any], Score]
    left_out: tuple[Omission, ...] = ()
    condition: float | None = None
    per: Callable[[Method], int] = lambda method: 1
    """By how much the seconds of an attempt are divided: the frequencies that it answers for."""


def cost(
    scene: Scene | str | Path, *, quick: bool = False, told: Progressed = lambda what, share: None
) -> Cost:
    """Measure what accuracy costs for a scene with numbers: the ratios, the crossings, delays, and
    each effect left out.

    ``quick`` : fewer methods and fewer repeats, for a first look. ``told`` : called as it goes on.
    The equations are given to every method beforehand, what is timed is the way from there to the
    answer; medians of interleaved repeats, so that ratios of times hold on a busy machine. Right
    digits are those that agree with a certified reference of higher precision.
    SceneError for a scene with symbols.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = cost(load_scene("fu2019"), quick=True)
    >>> sorted({row.task for row in found.rows}), all(row.complete for row in found.rows if row.proven)
    (['crossings', 'effects', 'evaluate'], True)
    """
    scene = as_scene(scene)
    scene.knobs.need_numbers()
    tasks = [_evaluate(scene, quick=quick), _crossings(scene, quick=quick), *_simpler(scene)]
    return _measured(scene, tasks, 0.1 if quick else 1.0, told)


def _measured(scene: Scene, tasks: list[Task], patience: float, told: Progressed) -> Cost:
    """All attempts of all tasks, timed and scored; ``patience`` stretches the time that repeats may
    take."""
    count, done = sum(len(task.attempts) + 1 for task in tasks), 0
    rows: list[CostMeasurement] = []
    left_out = [x for task in tasks for x in task.left_out]
    for task in tasks:
        # defaults hold the values of this turn of the loop
        def said(method: Method, at: int, before: int = done, name: str = task.name) -> None:
            told(f"{name}: {method.name}", (before + at) / count)

        timed = interleaved(
            task.attempts, patience * _BUDGETS[task.name], rounds=_ROUNDS, told=said
        )
        done += len(task.attempts)
        told(f"{task.name}: correct digits", done / count)
        done += 1
        for method, x in timed.items():
            if isinstance(x.answer, HaptisymError):
                left_out.append(Omission(task.name, method.name, str(x.answer)))
                continue
            score, seconds = task.score(method, x.answer), x.seconds / task.per(method)
            # a proof that leaves a place undecided is none of all crossings
            proven = method.proves and not getattr(x.answer, "undecided", 0)
            counts = score.missed, score.invented, x.spread
            rows.append(
                CostMeasurement(task.name, method.name, score.digits, seconds, proven, *counts)
            )
    told("", 1.0)
    return Cost(
        scene,
        tuple(rows),
        tuple(left_out),
        {x.name: x.condition for x in tasks if x.condition is not None},
    )


def _prepared(
    methods: Iterable[Method], question: Any, task: str
) -> tuple[dict[Method, Attempt], tuple[Omission, ...]]:
    """The methods that fit a question, ready; and those that do not, with the reason."""
    ready, left_out = {}, []
    for method in methods:
        try:
            ready[method] = method.ready(question)
        except (UnfitMethodError, SceneError) as refusal:
            left_out.append(Omission(task, method.name, str(refusal)))
    return ready, tuple(left_out)


def _evaluate(scene: Scene, *, quick: bool) -> Task:
    """The ratios along the band, by floats of several kinds and to many digits."""
    # A call for many frequencies costs less for each of them: methods that can are timed so, with
    # the same few repeated, for which there is a reference.
    few = RatioQuestion(scene.distortion(), _frequencies(scene, 10 if quick else 40))
    count = len(few.omegas)
    many = RatioQuestion(few.distortion, few.omegas * ((_MANY // 10 if quick else _MANY) // count))
    methods = [x for x in RATIO_METHODS.values() if not x.packages and not (quick and x.held > 100)]
    groups = [
        _prepared([x for x in methods if x.at_once is at_once], question, "evaluate")
        for at_once, question in ((True, many), (False, few))
    ]
    truth = few.truth(int(max(x.held for x in methods)) + 10)
    return Task(
        "evaluate",
        {**groups[0][0], **groups[1][0]},
        lambda method, answer: few.score(answer[:count], truth, method.held),
        (*groups[0][1], *groups[1][1]),
        few.condition,
        lambda method: len((many if method.at_once else few).omegas),
    )


def _frequencies(scene: Scene, count: int) -> tuple[float, ...]:
    """Evenly and logarithmically along the band, without 0."""
    low, high = (float(x) for x in scene.band)
    # at 0 rad/s a ratio may be a limit, which formulas in floats do not have
    even = np.linspace(low, high, count + 1)[1:]
    decades = np.geomspace(low or 1e-6 * high, high, count, endpoint=False)
    return tuple(float(x) for x in np.union1d(even, decades))


def _crossings(scene: Scene, *, quick: bool) -> Task:
    """All crossings, by grids, eigenvalues and proof."""
    left = ("grid of 10^6", "certified, 300 digits", "certified, 1000 digits") if quick else ()
    question = Crossings.of(scene)
    attempts, left_out = _prepared(
        (x for x in CROSSINGS.values() if x.name not in left), question, "crossings"
    )
    return Task("crossings", attempts, _against(question), left_out, question.condition)


def _against(question: Crossings) -> Callable[[Method, FoundCrossings], Score]:
    """The score of an answer against the certified crossings of a question, with digits to
    spare."""
    known: dict[int, FoundCrossings] = {}

    # references of as many digits as a method claims are computed once for all methods that do
    def score(method: Method, answer: FoundCrossings) -> Score:
        digits = int(method.held) + 15
        if digits not in known:
            known[digits] = question.certified(digits)
        return question.score(answer, known[digits], method.held)

    return score


def _simpler(scene: Scene) -> Iterator[Task]:
    """The crossings with Pade approximants for delays, if there are any, and with each effect left
    out."""
    d, chain, exact = scene.distortion(), scene.distortion().chain, Crossings.of(scene)
    if any(x.has(exp) for x in d.perc.ring.functions):
        others = {f"Pade, order {n}": partial(approximated, d, n) for n in _PADE_ORDERS}
        yield _compared("delay", exact, "exact delay", others)
    if scene.effects:
        others = {
            f"without {x.name}": partial(without, chain, i) for i, x in enumerate(scene.effects)
        }
        yield _compared("effects", exact, "all effects", others)


def approximated(distortion: Distortion, order: int) -> Distortion:
    """The closed forms with a Pade approximant of that order for every delay."""

    def pade(exponent: Expr) -> Expr:
        lag = -exponent / s
        approximant: Expr = effects.pade_delay(abs(lag), order).matrix[0]
        # an exponential that grows is the inverse of a delay
        return approximant if lag > 0 else 1 / approximant

    return Distortion.of(
        distortion.chain.map(lambda form: form.rewrite([cosh, sinh], exp).replace(exp, pade))
    )


def without(chain: Chain, index: int) -> Distortion:
    """The closed forms without one of the effects."""
    left = (*chain.matrices[:index], *chain.matrices[index + 1 :])
    return Distortion.of(Chain(chain.environment, chain.rendered, left))


def _compared(
    task: str, exact: Crossings, name: str, others: Mapping[str, Callable[[], Distortion]]
) -> Task:
    """The crossings of the scene, and of simpler ones in its place: proven for them, but not for
    the scene."""

    def ready(question: Crossings) -> Attempt:
        # the equations are given to all, and are not timed
        _ = question.functions
        return partial(question.certified, _DIGITS)

    attempts = {Method(name, ready, proves=True, ours=True, held=_DIGITS): ready(exact)}
    left_out = []
    for other, make in others.items():
        try:
            question = Crossings(make(), exact.threshold, exact.band)
        except SceneError as error:
            left_out.append(Omission(task, other, str(error)))
        else:
            attempts[Method(other, ready, ours=True, held=_DIGITS)] = ready(question)
    return Task(task, attempts, _against(exact), tuple(left_out), exact.condition)
