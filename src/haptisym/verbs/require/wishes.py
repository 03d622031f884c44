"""What is asked of a display, alone or together: to be transparent, stable in a hand, fit for every passive hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from haptisym.judge.criteria import PASSIVE, Criterion
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError, meant
from haptisym.model.caveats import clocks
from haptisym.model.knobs import Knob
from haptisym.model.scene import Scene
from haptisym.verbs.require.feasible import Solved
from haptisym.verbs.require.freeparameter import Domain
from haptisym.verbs.require.held import solve_stable, stable_in
from haptisym.verbs.require.passive import solve_passive
from haptisym.verbs.require.sampledpassive import solve_sampled
from haptisym.verbs.require.solving import solve
from haptisym.verbs.require.verdicts import all_open, together

TRANSPARENT, STABLE, SUITS_ALL = "transparent", "stable", "passive"
WISHES = (TRANSPARENT, STABLE, SUITS_ALL)
EVERY_PASSIVE_HAND = replace(
    PASSIVE, words="every passive hand", rule="every passive hand may hold it", kept="fit for every passive hand"
)


def wishes(that: Sequence[str]) -> tuple[str, ...]:
    """What is asked, each thing once, in their order. SceneError names what is none of them."""
    listed = [that] if isinstance(that, str) else list(that)
    for x in listed:
        if x not in WISHES:
            raise SceneError(
                f'that: "{str(x)[:60]}" is none of {", ".join(WISHES)}; {meant(str(x), WISHES)}'.rstrip("; ")
            )
    if not listed:
        raise SceneError(f"that: nothing is asked: one or more of {', '.join(WISHES)}")
    return tuple(x for x in WISHES if x in listed)


def further(scene: Scene, wanted: Sequence[str]) -> tuple[Criterion, ...]:
    """The criteria beside those of the JND: a hand each, and every passive hand."""
    held = tuple(map(stable_in, scene.hands)) if STABLE in wanted else ()
    return (*held, EVERY_PASSIVE_HAND) if SUITS_ALL in wanted else held


def solve_all(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> Solved:
    """All values with which every criterion is kept."""
    found, judged = list[Solved](), [x for x in criteria if x.name not in (STABLE, SUITS_ALL)]
    if judged:
        found.append(solve(scene, free, asked, judged))
    others: list[Callable[[], Solved]] = []
    held = [hand for hand in scene.hands if stable_in(hand) in criteria]
    others += [partial(solve_stable, scene, hand, free, asked) for hand in held]
    if any(x.name == SUITS_ALL for x in criteria):
        others.append(partial(solve_sampled if clocks(scene) else solve_passive, scene, free, asked))
    return together(asked, [*found, *(_or_open(x, asked) for x in others)])


def _or_open(solved: Callable[[], Solved], asked: Domain) -> Solved:
    """The values; all of them undecided where that is not known, or the time does not last."""
    try:
        return solved()
    except LimitError:
        return all_open(asked)
    except UndecidedError as error:
        return all_open(asked, str(error))
