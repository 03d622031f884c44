"""The questions of ``haptisym cost``: what is asked of a scene, by which methods, and how their answers are scored."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from sympy import Expr, cosh, exp, sinh

from haptisym import effects
from haptisym.kernel.errors import SceneError
from haptisym.kernel.symbols import s
from haptisym.model.chain import Chain
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene
from haptisym.verbs.cost.measurement import Omission
from haptisym.verbs.cost.methods import CROSSINGS, RATIO_METHODS, Method
from haptisym.verbs.cost.questions import Attempt, Crossings, Found, RatioQuestion, Score
from haptisym.verbs.cost.usual import RefusedError

_DIGITS = 15
"""Of the crossings whose time and shift are compared when delays are approximated or effects left out."""
_PADE_ORDERS = range(1, 7)
_MANY = 10_000  # frequencies at once


@dataclass(frozen=True)
class Task:
    """Attempts at one question, each with the score of its answer."""

    name: str
    attempts: Mapping[Method, Attempt]
    score: Callable[[Method, Any], Score]
    left_out: tuple[Omission, ...] = ()
    condition: float | None = None
    per: Callable[[Method, Any], int] = lambda method, answer: 1
    """By what the seconds of an attempt are divided."""


def prepared(methods: Iterable[Method], question: Any, task: str) -> tuple[dict[Method, Attempt], tuple[Omission, ...]]:
    """The methods that fit a question, ready; and those that do not, with the reason."""
    ready, left_out = {}, []
    for method in methods:
        try:
            ready[method] = method.ready(question)
        except (RefusedError, SceneError) as refusal:
            left_out.append(Omission(task, method.name, str(refusal)))
    return ready, tuple(left_out)


def evaluate_task(scene: Scene, *, quick: bool) -> Task:
    """The ratios along the band, by floats of several kinds and to many digits."""
    few = RatioQuestion(scene.distortion(), _frequencies(scene, 10 if quick else 40))
    count = len(few.omegas)
    many = RatioQuestion(few.distortion, few.omegas * ((_MANY // 10 if quick else _MANY) // count))
    methods = [x for x in RATIO_METHODS.values() if not x.packages and not (quick and x.held > 100)]
    groups = [
        prepared([x for x in methods if x.at_once is at_once], question, "evaluate")
        for at_once, question in ((True, many), (False, few))
    ]
    truth = few.truth(int(max(x.held for x in methods)) + 10)
    return Task(
        "evaluate",
        {**groups[0][0], **groups[1][0]},
        lambda method, answer: few.score(answer[:count], truth, method.held),
        (*groups[0][1], *groups[1][1]),
        few.condition,
        lambda method, _: len((many if method.at_once else few).omegas),
    )


def _frequencies(scene: Scene, count: int) -> tuple[float, ...]:
    """Evenly and logarithmically along the band, without 0."""
    low, high = (float(x) for x in scene.band)
    even = np.linspace(low, high, count + 1)[1:]
    decades = np.geomspace(low or 1e-6 * high, high, count, endpoint=False)
    return tuple(float(x) for x in np.union1d(even, decades))


def crossings_task(scene: Scene, *, quick: bool) -> Task:
    """All crossings, by grids, eigenvalues and proof."""
    left = ("grid of 10^6", "certified, 300 digits", "certified, 1000 digits") if quick else ()
    methods = [x for x in CROSSINGS.values() if x.name not in left]
    question = Crossings.of(scene)
    attempts, left_out = prepared(methods, question, "crossings")
    return Task("crossings", attempts, _against(question), left_out, question.condition)


def _against(question: Crossings) -> Callable[[Method, Found], Score]:
    """The score of an answer against the certified crossings of a question, with digits to spare."""
    known: dict[int, Found] = {}

    def score(method: Method, answer: Found) -> Score:
        digits = int(method.held) + 15
        if digits not in known:
            known[digits] = question.certified(digits)
        return question.score(answer, known[digits], method.held)

    return score


def delay_tasks(scene: Scene) -> Iterable[Task]:
    """The crossings with Pade approximants for delays; nothing for a scene without any."""
    d = scene.distortion()
    if d.perc.ring.functions and any(x.has(exp) for x in d.perc.ring.functions):
        others = {f"Pade, order {n}": partial(approximated, d, n) for n in _PADE_ORDERS}
        yield _compared("delay", Crossings.of(scene), "exact delay", others)


def approximated(distortion: Distortion, order: int) -> Distortion:
    """The closed forms with a Pade approximant of that order for every delay."""
    late = distortion.chain.map(lambda form: form.rewrite([cosh, sinh], exp).replace(exp, partial(_pade, order)))
    return Distortion.of(late)


def _pade(order: int, exponent: Expr) -> Expr:
    lag = -exponent / s
    approximant: Expr = effects.pade_delay(abs(lag), order).matrix[0]
    return approximant if lag > 0 else 1 / approximant


def effects_tasks(scene: Scene) -> Iterable[Task]:
    """The crossings with each effect left out; nothing for a scene without any."""
    if scene.effects:
        chain = scene.distortion().chain
        others = {f"without {x.name}": partial(without, chain, i) for i, x in enumerate(scene.effects)}
        yield _compared("effects", Crossings.of(scene), "all effects", others)


def without(chain: Chain, index: int) -> Distortion:
    """The closed forms without one of the effects."""
    left = (*chain.matrices[:index], *chain.matrices[index + 1 :])
    return Distortion.of(Chain(chain.environment, chain.rendered, left))


def _compared(task: str, exact: Crossings, name: str, others: Mapping[str, Callable[[], Distortion]]) -> Task:
    """The crossings of the scene, and of simpler ones in its place: proven for them, but not for the scene."""
    attempts = {_way(name, proves=True): _ready(exact)}
    left_out = []
    for other, make in others.items():
        try:
            question = Crossings(make(), exact.threshold, exact.band)
        except SceneError as error:
            left_out.append(Omission(task, other, str(error)))
        else:
            attempts[_way(other, proves=False)] = _ready(question)
    return Task(task, attempts, _against(exact), tuple(left_out), exact.condition)


def _way(name: str, *, proves: bool) -> Method:
    return Method(name, _ready, proves=proves, ours=True, held=_DIGITS)


def _ready(question: Crossings) -> Attempt:
    _ = question.functions  # the equations are given to all
    return partial(question.certified, _DIGITS)
