"""What certainty costs a sweep, and what accuracy costs a simulation.

What certainty costs a sweep: sets of parameters drawn around a scene, answered by grids of frequencies and with proof.

What the accuracy of a simulation costs: H_perc recovered with other steps, settling times and periods, and without effects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, log10
from time import process_time
from typing import Any, TypeVar

import numpy as np

from haptisym.judge.crossings import noticed
from haptisym.kernel.budget import limited, share, tick
from haptisym.kernel.errors import LimitError, SceneError
from haptisym.kernel.reals import ExactNumber
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.parameters import Rule
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.cost.tasks import DOUBLE, Attempt, Method, RefusedError, Score, Task, naive, prepared, right_digits
from haptisym.verbs.simulate.entry import STEP, Run, band_frequencies, default_amplitude, lock, period_of
from haptisym.verbs.simulate.motions import Sines, multisine
from haptisym.verbs.simulate.network import name_of
from haptisym.verbs.sweep.bernstein import Array
from haptisym.verbs.sweep.passes import AnswerRow, Kernel, exact_answers
from haptisym.verbs.sweep.told import OPEN

_POINTS = 1 << 16
"""Of all grids of a block of sets, so that they stay near the processor."""
_HALVINGS = 46
_SEED = 2019
_FOR_FORMULAS, _FOR_EACH = 0.25, 0.4
"""Shares of the time that is left."""
_Item = TypeVar("_Item")


class Answers(dict[str, Array]):
    """By the names of a sweep's variables a number for each set; of ``asked`` sets ``left_open`` were not reached in time."""

    def __init__(self, columns: Iterable[tuple[str, Array]], asked: int, left_open: Iterable[int] = ()) -> None:
        super().__init__(columns)
        self.asked, self.left_open = asked, frozenset(map(int, left_open))
        if self.answered == 0:
            raise LimitError("no set was answered within its share of the limit")

    @property
    def answered(self) -> int:
        """Sets that were reached."""
        return self.asked - len(self.left_open)

    @property
    def undecided(self) -> int:
        """Sets that were not answered, and say so."""
        return int((self.get("method", np.zeros(0)) == OPEN).sum())


@dataclass(frozen=True)
class SweepQuestion:
    """The first crossing of each criterion, and how many there are, for sets of values of some parameters.

    ``values`` : parameters x sets. ``patience`` : seconds of the processor that exact arithmetic may take for the truth of some.
    """

    scene: Scene
    knobs: tuple[Knob, ...]
    kernel: Kernel
    values: Array
    patience: float

    @classmethod
    def of(cls, scene: Scene, paths: Sequence[str], *, quick: bool) -> SweepQuestion:
        """Values around those of a scene: evenly in the logarithm, from half to twice, or over the range that a parameter has."""
        scene = replace(scene, hands=())
        knobs = _varied(scene, paths)
        with share(_FOR_FORMULAS):  # those that take longer are not used: each set is then answered exactly
            kernel = Kernel.of(scene, knobs)
        sets = (1024 if quick else 8192) if kernel.is_polynomial else 64
        rng = np.random.default_rng(_SEED)
        values = np.array([_drawn(x, rng, sets) for x in knobs])
        return cls(scene, knobs, kernel, values, 1.0 if quick else 20.0)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the criteria."""
        return tuple(x.name for x in noticed(self.scene.threshold))

    @cached_property
    def truth(self) -> Sequence[AnswerRow]:
        """Exact answers of the first sets, as many as there is time for; LimitError where that is none."""
        found = self.exact(self.values.T, self.patience)
        if not found:
            raise LimitError("not decided within the limit: no set was answered exactly, to hold others against")
        return found

    def exact(self, sets: Iterable[Array], patience: float = inf) -> list[AnswerRow]:
        """Exact answers of some sets, one after the other until the time is over."""
        found, end = [], process_time() + patience
        with limited() as budget:
            for one in _in_time(sets):
                row = exact_answers(self.scene, self.knobs, one.tolist())
                if budget.reached and row["method"] == OPEN:
                    break
                found.append(row)
                if process_time() > end:
                    break
        return found

    def score(self, answers: Answers) -> Score:
        """Sets with a wrong count, crossings missed and invented in them, and the right digits of the others' first crossings."""
        wrong, sets, missed, invented, digits = 0, 0, 0, 0, DOUBLE
        for i, true in enumerate(self.truth):
            if i in answers.left_open:
                continue
            pairs = [(int(answers[f"crossings_{x}"][i]), int(true[f"crossings_{x}"])) for x in self.names]
            if any(count < 0 for _, count in pairs):
                continue  # not answered, or no dynamics
            sets += 1
            wrong += any(own != count for own, count in pairs)
            missed += sum(max(count - own, 0) for own, count in pairs)
            invented += sum(max(own - count, 0) for own, count in pairs)
            if all(own == count for own, count in pairs):
                digits = min(
                    digits, *(_digits(answers[k][i], true[k]) for k in self._firsts if not np.isnan(true[k])), DOUBLE
                )
        return Score(digits if sets else 0.0, missed, invented, (wrong, sets))

    @property
    def _firsts(self) -> Iterator[str]:
        return (f"first_crossing_{x}" for x in self.names)


def _varied(scene: Scene, paths: Sequence[str]) -> tuple[Knob, ...]:
    """The parameters asked for, or all numbers of the scene that are not 0; SceneError where there are none."""
    knobs = scene.knobs.chosen(paths) if paths else tuple(x for x in scene.knobs if not x.parts and x.value != 0)
    scene.knobs.need_numbers(knobs)
    for x in knobs:
        if x.value == 0 or x.parts:
            raise SceneError(f"{x.path}: cannot be varied here: only numbers of the display can, other than 0")
    if not knobs:
        raise SceneError("cost --sweep varies parameters, and this scene has none that could be")
    return knobs


def _drawn(x: Knob, rng: np.random.Generator, sets: int) -> Array:
    """Values over the range of a parameter, evenly in the logarithm where that has one; without a range from half to twice."""
    value = float(ExactNumber(x.value))
    low, high = value / 2, min(2 * value, (1 + value) / 2) if x.rule is Rule.FRACTION else 2 * value
    if x.interval is not None:
        low, high = (float(ExactNumber(end)) for end in x.interval)
    if low * high <= 0:
        return rng.uniform(low, high, sets)
    found: Array = np.sign(low) * np.exp(rng.uniform(np.log(abs(low)), np.log(abs(high)), sets))
    return found


def _digits(own: float, true: float) -> float:
    """Right decimal digits."""
    error = abs(own - true) / true if true else abs(own)
    return DOUBLE if error == 0 else min(max(-log10(error), 0.0), DOUBLE) if error == error else 0.0


# The ways.


def _in_time(items: Iterable[_Item]) -> Iterator[_Item]:
    """Until the time is over."""
    for x in items:
        try:
            tick()
        except LimitError:
            return
        yield x


def _shared(attempt: Attempt) -> Attempt:
    """An attempt that leaves time to those after it."""

    def bounded() -> Any:
        with share(_FOR_EACH):
            return attempt()

    return bounded


def certified_way(question: SweepQuestion) -> Attempt:
    """Ours: floats that prove their counts, and exact arithmetic for the sets that they leave."""
    values = question.values

    def attempt() -> Answers:
        columns, left = question.kernel.in_floats(values)
        rows = question.exact(values[:, left].T)
        for i, row in zip(left, rows, strict=False):
            for name, value in row.items():
                columns[name][i] = value
        return Answers(columns.items(), values.shape[1], left[len(rows) :])

    return _shared(attempt)


def grid_way(points: int, question: SweepQuestion) -> Attempt:
    """Sign changes on a grid, each found by halving; RefusedError where the ratios are not held against numbers."""
    criteria = noticed(question.scene.threshold)
    if any(x.region or x.part is None or x.threshold.free_symbols for x in criteria):
        raise RefusedError("the threshold is more than a number for each part")
    known = {p.symbol: p.value for p in question.scene.parameters}
    free = {x.symbol: x.symbol for x in question.knobs}
    both = naive(Distortion.of(question.scene.chain.at(known | free)), list(free))
    limits = [float(ExactNumber(x.threshold)) for x in criteria]
    low, high = (float(x) for x in question.scene.band)
    at = np.linspace(low, high, points)[:, None]

    def above(omega: Array, some: Array) -> list[Array]:
        with np.errstate(all="ignore"):
            H, dH = both(omega, *some)
            size = np.abs(H)
            shares: dict[Part | None, Array] = {
                Part.REAL: np.abs(np.real(dH)) / size,
                Part.IMAG: np.abs(np.imag(dH)) / size,
            }
        shape = np.broadcast_shapes(omega.shape, some.shape[1:])
        return [np.broadcast_to(shares[x.part] > limit, shape) for x, limit in zip(criteria, limits, strict=True)]

    def attempt() -> Answers:
        width, sets = max(1, _POINTS // points), question.values.shape[1]
        parts = [_block(at, question.values[:, i : i + width], above) for i in _in_time(range(0, sets, width))]
        rows = [np.concatenate(x) for x in zip(*parts, strict=True)]
        keys = [f"{kind}_{x.name}" for x in criteria for kind in ("crossings", "first_crossing")]
        return Answers(zip(keys, rows, strict=bool(parts)), sets, range(len(parts) * width, sets))

    return _shared(attempt)


def _block(at: Array, some: Array, above: Any) -> list[Array]:
    """Of some sets for each criterion the counts and the first crossings."""
    found: list[Array] = []
    for part, over in enumerate(above(at, some)):
        row, column = (over[1:] != over[:-1]).nonzero()
        low, high, before = at[row, 0], at[row + 1, 0], over[row, column]
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            same = above(middle, some[:, column])[part] == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        first = np.full(some.shape[1], np.inf)
        np.minimum.at(first, column, (low + high) / 2)
        found += [np.bincount(column, minlength=some.shape[1]), np.where(np.isinf(first), np.nan, first)]
    return found


def sweep_task(scene: Scene, paths: Sequence[str], *, quick: bool) -> Task:
    """All sets, by grids and with proof."""
    question = SweepQuestion.of(scene, paths, quick=quick)
    methods = [
        Method("certified", certified_way, proves=True, ours=True, held=10),
        *(Method(f"grid of 10^{n}, halved", partial(grid_way, 10**n)) for n in ((2, 3) if quick else (2, 3, 4))),
    ]
    attempts, left_out = prepared(methods, question, "sweep")
    return Task("sweep", attempts, lambda _, answer: question.score(answer), left_out, per=lambda _, x: x.answered)


_STEPS = (7.2, 5.4, 3.6, 2.7, 1.8, STEP, 0.45)
"""Radians of the highest frequency on a step."""
_TOLERANCES = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12)
"""What is left of the transient when the lock-in begins, if its slowest pole tells."""
_PERIODS = (1, 2, 3, 4, 6)
"""Base periods that the lock-in looks at."""
_TIGHT, _LONG = 1e-12, 4
_COUNT = 5  # frequencies along the band


@dataclass(frozen=True)
class Recovery:
    """H_perc along the band of a scene, recovered from a simulation under a multisine, against the closed form."""

    scene: Scene

    @cached_property
    def motion(self) -> Sines:
        """The multisine that the hand makes."""
        motion = multisine(default_amplitude(self.scene), band_frequencies(self.scene, _COUNT))
        assert isinstance(motion, Sines)
        return motion

    @cached_property
    def truth(self) -> Any:
        """The closed form, certified to the last digit."""
        values = self.scene.distortion().compile("certified", of=("perceived_real", "perceived_imag"))(
            np.array(self.motion.omegas)
        )
        return values.perceived_real + 1j * values.perceived_imag

    def check(self) -> None:
        """SceneError, with the reason, where the scene cannot be simulated."""
        Run(self.scene, self.motion, (), STEP, None)

    def recovered(self, scene: Scene, step: float, tolerance: float, periods: int) -> Any:
        """What a simulation of a scene, this one or a simpler one, gives back for H_perc."""
        run = Run(scene, self.motion, (), step, None)
        window = periods * period_of(self.motion)
        run.advance(self.motion.fade + run.settling(tolerance) + window)
        run.advance(np.ceil(run.engine.t / period_of(self.motion) - 1e-9) * period_of(self.motion))
        force = run.engine.signal(name_of(run.ports[-1].F))
        phasors = np.array([self.motion.phasor(omega) for omega in self.motion.omegas])
        return lock(run.engine.record, force, self.motion, window, 1).values / phasors

    def score(self, answer: Any) -> Score:
        """Right digits of the worst of the frequencies, from the error of the complex number as a fraction of its size."""
        from flint import arb

        return Score(
            min(right_digits(1 + abs(x / y - 1), arb(1), DOUBLE) for x, y in zip(answer, self.truth, strict=True))
        )


def simulation_methods(question: Recovery) -> Iterator[Method]:
    """The ways to simulate: one setting changed at a time, then each effect left out."""
    scene = question.scene
    for step in _STEPS:
        yield _way(f"steps of {step:g} rad", scene, step, _TIGHT, _LONG)
    for tolerance in _TOLERANCES[:-1]:
        yield _way(f"transient of {tolerance:.0e}", scene, STEP, tolerance, _LONG)
    for periods in _PERIODS:
        if periods != _LONG:
            yield _way(f"{periods} period{'s' * (periods > 1)}", scene, STEP, _TIGHT, periods)
    for i, effect in enumerate(scene.effects):
        rest = (*scene.effects[:i], *scene.effects[i + 1 :])
        simpler = Scene(scene.environment, rest, scene.band, scene.threshold, scene.rendered)
        yield _way(f"without {effect.name}", simpler, STEP, _TIGHT, _LONG)


def _way(name: str, scene: Scene, step: float, tolerance: float, periods: int) -> Method:
    def prepare(question: Recovery) -> Callable[[], Any]:
        _ = question.truth
        return partial(question.recovered, scene, step, tolerance, periods)

    return Method(name, prepare, packages=("scipy",), ours=True)
