"""For which values of one parameter a display is stable in its hands, and with any passive
operator: each question with what answers it. Begin with ``of_hands``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from haptisym.judge.bindings import IN_HANDS, stable_in
from haptisym.judge.crossings import PASSIVE, Criterion
from haptisym.kernel.errors import SceneError
from haptisym.kernel.sets import Domain, ValueSet
from haptisym.model.catalogue import Hand, how_to_give
from haptisym.model.scene import Knob, Scene, chosen_hand, clocks
from haptisym.verbs.require.passive import solve_passive, solve_sampled
from haptisym.verbs.stability.limits import stable_values


def with_hands(scene: Scene, given: str | Hand | None) -> Scene:
    """The scene in the hand that is asked about; its own if none is."""
    found = scene if given is None else scene.with_hands(chosen_hand(scene, given))
    if not found.hands:
        raise SceneError(f"a display is stable in a hand, and none is given: {how_to_give()}")
    return found


def of_hands(
    scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]
) -> list[Callable[[], ValueSet]]:
    """A function for each criterion about hands that finds its values: not called yet, so that one
    that stays undecided does not keep the others from an answer."""
    both = [(hand, stable_in(hand, what)) for hand in scene.hands for what in IN_HANDS]
    held = [(hand, x) for hand, x in both if x in criteria]
    found: list[Callable[[], ValueSet]] = [
        partial(stable_values, scene, hand, free, asked, x) for hand, x in held
    ]
    if any(x.name == PASSIVE.name for x in criteria):
        # A clock makes passivity another condition, Colgate and Schenkel's.
        passive = solve_sampled if clocks(scene) else solve_passive
        found.append(partial(passive, scene, free, asked))
    return found
