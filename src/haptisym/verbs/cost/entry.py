"""What accuracy costs in time for a scene: measured live, in a sentence and in numbers.

What was measured, in a sentence, and the words for times and counts that go with it.

What accuracy costs in time for a scene: measured live, against certified references of higher precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from math import isinf
from pathlib import Path
from statistics import median
from typing import Any, ClassVar

from haptisym.judge.answers import Answer
from haptisym.kernel.budget import ONE_THREAD, limited
from haptisym.kernel.errors import HaptisymError
from haptisym.kernel.objects import counted, titled
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.cost.measurement import HardRow, Measurement, Omission
from haptisym.verbs.cost.stopwatch import Timed, interleaved, machine
from haptisym.verbs.cost.tasks import Method, Task, crossings_task, delay_tasks, effects_tasks, evaluate_task, prepared

_SCATTER = 0.15  # of the middle half of the repeats: quiet machines have 0.02 to 0.1
BUSY = "This machine is busy: times are not to be trusted."


def is_busy(rows: Sequence[Measurement]) -> bool:
    """Whether the repeats scatter so much that something else was running."""
    spreads = [x.spread for x in rows if x.spread is not None]
    return bool(spreads) and median(spreads) > _SCATTER


def summary(rows: Sequence[Measurement]) -> str:
    """What a digit costs, in a sentence; of a sweep what certainty costs; of times that scatter that they do."""
    if is_busy(rows):
        return BUSY
    if rows and rows[0].task == "sweep":
        return _of_sweep(rows)
    proven = sorted((x for x in rows if x.task == "crossings" and x.proven), key=lambda x: x.digits)
    if len(proven) < 2:
        return _best(rows)
    first, last = proven[0], proven[-1]
    each = (last.seconds - first.seconds) / (last.digits - first.digits)
    lost = sum((x.spread or 0) * x.seconds for x in (first, last))
    grids = [x for x in rows if x.task == "crossings" and x.method.startswith("grid") and x.method[-1].isdigit()]
    finest = max(grids, key=lambda x: x.seconds, default=None)
    price = f"{duration(each)} a digit" if last.seconds - first.seconds > lost else "no time that shows"
    return (
        f"Here all crossings, proven, to {first.digits:.0f} digits take {duration(first.seconds)}; more digits cost {price}: "
        f"{last.digits:.0f} of them take {duration(last.seconds)}" + (f"; {_grid(finest)}" if finest else "") + "."
    )


def _of_sweep(rows: Sequence[Measurement]) -> str:
    ours = next((x for x in rows if x.proven), None)
    if ours is None:
        return "Here no set was answered with proof."
    grids = [x for x in rows if not x.proven and x.sets]
    told = [
        f"a {x.method.partition(',')[0]} points takes {duration(x.seconds)} and counts {share_wrong(x)} wrong"
        for x in grids
    ]
    said = f" ({not_reached(ours)})" if ours.left_open else ""
    return (
        f"Here a set is answered with proof in {duration(ours.seconds)}{said}" + "".join(f"; {x}" for x in told) + "."
    )


def not_reached(row: Measurement) -> str:
    """Of a sweep, for how many sets the time was too short."""
    return f"{row.left_open} of {row.asked} sets were not reached within the limit of time"


def share_wrong(row: Measurement) -> str:
    """``1.6 % of 500 sets``; "" of what is no sweep."""
    if row.wrong is None or not row.sets:
        return ""
    share = f"{100 * row.wrong / row.sets:.2g} %" if row.wrong else "none"
    return f"{share} of {row.sets} sets"


def _grid(row: Measurement) -> str:
    if not row.complete:
        return f"a {row.method} points takes {duration(row.seconds)} and {wrong(row)}"
    return f"a {row.method} points takes {duration(row.seconds)} for {row.digits:.1f} digits, and proves nothing"


def _best(rows: Sequence[Measurement]) -> str:
    best = max((x for x in rows if x.complete), key=lambda x: x.digits, default=None)
    if best is None:
        return "Here no method found all crossings and no others."
    low = min((x for x in rows if x.complete), key=lambda x: x.seconds)
    return (
        f"Here {best.digits:.1f} digits take {duration(best.seconds)} ({best.method}), and the fastest way gives "
        f"{low.digits:.1f} digits in {duration(low.seconds)} ({low.method})."
    )


def wrong(row: Measurement) -> str:
    """What is wrong with a count of crossings; "" where nothing is."""
    parts = [f"{word} {n}" for word, n in (("misses", row.missed), ("invents", row.invented)) if n]
    return " and ".join(parts)


def duration(seconds: float) -> str:
    """A time with three digits and a readable unit.

    >>> duration(0.00123456), duration(3.2e-7)
    ('1.23 ms', '320 ns')
    """
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= unit:
            return f"{float(f'{seconds / unit:.3g}'):g} {name}"
    return f"{float(f'{seconds / 1e-9:.3g}'):g} ns"


def hard_summary(rows: Sequence[HardRow]) -> str:
    """How many of the questions each side answers right, in a sentence."""
    count = len({(row.family, row.case) for row in rows})
    proven = [row for row in rows if row.ours and row.proven]
    wrong = sum(row.verdict != "right" for row in proven)
    usual = [row for row in rows if not row.ours and row.answered]
    failed = sum(row.verdict != "right" for row in usual)
    said = "none of them wrong" if not wrong else f"{wrong} of them WRONG"
    return (
        f"{count} hard questions: haptisym gives {len(proven)} proven answers, {said}; of {len(usual)} answers by the usual ways "
        f"{failed} lose digits, miss crossings or invent some, and none says so."
    )


def worst_verdict(rows: Iterable[HardRow]) -> str:
    """What goes wrong in some cases, all together; "" where nothing does."""
    listed = list(rows)
    missed, invented = sum(row.missed for row in listed), sum(row.invented for row in listed)
    if missed or invented:
        return " and ".join(f"{word} {n}" for word, n in (("misses", missed), ("invents", invented)) if n)
    if any(row.verdict == "undecided" for row in listed):
        return f"{sum(row.verdict == 'undecided' for row in listed)} undecided, and said so"
    bad = [row for row in listed if row.verdict != "right"]
    return min(bad, key=lambda row: row.digits).verdict if bad else ""


Progressed = Callable[[str, float], None]
"""Called with what is measured next and the share that is done, from 0 to 1."""
_ROUNDS = 25
_BUDGETS = {"evaluate": 4.0, "crossings": 4.0, "delay": 2.0, "effects": 2.0, "simulation": 3.0, "sweep": 6.0}
"""Seconds after which no repeats of a task are begun."""
_FOR_REPEATS = 0.25
"""The share of a limit after which no repeats are begun."""


@dataclass(frozen=True, repr=False)
class Cost(Answer):
    """Accuracy against time for a scene, measured.

    ``condition`` : of each question, how much its answer changes, relatively, with what is asked; infinite at a touch.
    """

    _schema: ClassVar[str] = "haptisym.cost/1"
    _page: ClassVar[str] = "haptisym.pages.cost:page"
    _figure: ClassVar[str] = "haptisym.figures.cost:cost_figure"

    scene: Scene
    rows: tuple[Measurement, ...]
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
        """Whether the repeats scatter so much that something else was running: then no sentence is made of the times."""
        return is_busy(self.rows)

    @property
    def summary(self) -> str:
        """What a digit costs here, in a sentence."""
        return summary(self.rows)

    def task(self, name: str) -> tuple[Measurement, ...]:
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


def cost(scene: Scene | str | Path, *, quick: bool = False, told: Progressed = lambda what, share: None) -> Cost:
    """Measure what accuracy costs for a scene with numbers: the ratios, the crossings, delays, and each effect left out.

    ``quick`` : fewer methods and fewer repeats, for a first look. ``told`` : called as it goes on. The equations are given to
    every method beforehand, what is timed is the way from there to the answer; medians of interleaved repeats, so that ratios of
    times hold on a busy machine. Right digits are those that agree with a certified reference of higher precision.
    SceneError for a scene with symbols.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = cost(load_scene("fu2019"), quick=True)
    >>> sorted({row.task for row in found.rows}), all(row.complete for row in found.rows if row.proven)
    (['crossings', 'effects', 'evaluate'], True)
    """
    scene = as_scene(scene)
    scene.knobs.need_numbers()
    tasks = [
        evaluate_task(scene, quick=quick),
        crossings_task(scene, quick=quick),
        *delay_tasks(scene),
        *effects_tasks(scene),
    ]
    return _measured(scene, tasks, 0.1 if quick else 1.0, told)


def simulation_cost(
    scene: Scene | str | Path, *, quick: bool = False, told: Progressed = lambda what, share: None
) -> Cost:
    """Measure what accuracy costs a simulation in time: H_perc recovered along the band, against its closed form.

    Steps, what is left of the transient, and the periods of the lock-in are varied one at a time; then each effect is left out.
    Needs SciPy. SceneError for a scene that cannot be simulated.

    >>> from haptisym.model.scenefile import load_scene
    >>> rows = simulation_cost(load_scene("fu2019"), quick=True).rows
    >>> max(row.digits for row in rows) > 11, min(row.digits for row in rows) < 4
    (True, True)
    """
    from haptisym.verbs.cost.sweeps import Recovery, simulation_methods

    scene = as_scene(scene)
    scene.knobs.need_numbers()
    question = Recovery(scene)
    with ONE_THREAD:  # as ``simulate`` has it
        question.check()
        attempts, left_out = prepared(simulation_methods(question), question, "simulation")
        task = Task("simulation", attempts, lambda method, answer: question.score(answer), left_out)
        return _measured(scene, [task], 0.3 if quick else 3.0, told)


def sweep_cost(
    scene: Scene | str | Path,
    free: Sequence[str] = (),
    *,
    quick: bool = False,
    limit: float | None = None,
    told: Progressed = lambda what, share: None,
) -> Cost:
    """Measure what certainty costs a sweep: time for a set, and how often a grid of frequencies counts crossings wrong.

    ``free`` : paths of the parameters that vary, all numbers of the display if not given; each over its range if the scene states
    one, else from half of its value to twice, always the same random sets. Wrong is what exact arithmetic tells otherwise, on as
    many sets as there is time for. ``limit`` : seconds for all of it; rows say how many sets were not reached (``left_open``).
    LimitError where none could be answered exactly within it. SceneError for a scene with symbols, or nothing that varies.

    >>> from haptisym.model.scenefile import load_scene
    >>> ours, *grids = sweep_cost(load_scene("fu2019"), quick=True).rows
    >>> ours.wrong, ours.proven, all(row.sets == ours.sets for row in grids)
    (0, True, True)
    """
    from haptisym.verbs.cost.sweeps import sweep_task

    scene = as_scene(scene)
    scene.knobs.need_numbers()
    paths = [free] if isinstance(free, str) else list(free)
    patience = 0.2 if quick else 3.0
    if limit is not None:
        patience = min(patience, limit * _FOR_REPEATS / _BUDGETS["sweep"])
    with limited(limit):
        told("formulas", 0.0)
        return _measured(scene, [sweep_task(scene, paths, quick=quick)], patience, told)


def _measured(scene: Scene, tasks: list[Task], patience: float, told: Progressed) -> Cost:
    """All attempts of all tasks, timed and scored; ``patience`` stretches the time that repeats may take."""
    count, done = sum(len(task.attempts) + 1 for task in tasks), 0
    rows: list[Measurement] = []
    left_out = [x for task in tasks for x in task.left_out]
    for task in tasks:
        said = partial(_tell, told, task.name, done, count)
        timed = interleaved(task.attempts, patience * _BUDGETS[task.name], rounds=_ROUNDS, told=said)
        done += len(task.attempts)
        told(f"{task.name}: right digits", done / count)
        done += 1
        left_out += [Omission(task.name, m.name, str(x.answer)) for m, x in timed.items() if _refused(x)]
        rows += [_row(task, method, x) for method, x in timed.items() if not _refused(x)]
    told("", 1.0)
    return Cost(scene, tuple(rows), tuple(left_out), {x.name: x.condition for x in tasks if x.condition is not None})


def _tell(told: Progressed, task: str, before: int, count: int, method: Method, at: int) -> None:
    told(f"{task}: {method.name}", (before + at) / count)


def _refused(timed: Timed) -> bool:
    return isinstance(timed.answer, HaptisymError)


def _row(task: Task, method: Method, timed: Timed) -> Measurement:
    score = task.score(method, timed.answer)
    proven = method.proves and not getattr(timed.answer, "undecided", 0)
    seconds = timed.seconds / task.per(method, timed.answer)
    wrong, sets = score.wrong or (None, None)
    late, asked = (len(left), timed.answer.asked) if (left := getattr(timed.answer, "left_open", ())) else (None, None)
    counts = score.missed, score.invented, wrong, sets, late, asked
    return Measurement(task.name, method.name, score.digits, seconds, proven, *counts, timed.spread)
