"""What holds for all values within the ranges of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from haptisym.kernel.budget import SECONDS, Told, limited, share
from haptisym.kernel.counts import whole
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.verbs.stability.entry import in_hands
from haptisym.verbs.tolerances.box import box_of
from haptisym.verbs.tolerances.heldbox import held_in_box
from haptisym.verbs.tolerances.proofs import Tolerances
from haptisym.verbs.tolerances.single import drawn

SEED = 2019


def tolerances(
    scene: Scene | str | Path,
    samples: int = 200,
    seed: int = SEED,
    *,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> Tolerances:
    """What holds for all values of a scene's parameters within their ranges.

    Guaranteed: the verdict where it is not ``Verdict.UNDECIDED``; that crossings lie in the enclosures and nowhere else; how many
    there are where a count is given; ends said to be reached at a corner are exact. Estimated: quantiles over ``samples`` sets
    of values, each answered with certainty, drawn uniformly with a seed; none where ranges are of hands alone, which change
    nothing of what is felt. SceneError where nothing has a range.

    ``hand`` : those in which the display is held, as of ``stability``; those of the scene if not given. Of each it is told, in
    ``held``, whether the display is stable in it for all values of display and hand, for some, or for none.
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
    scene = in_hands(as_scene(scene), hand)
    samples = whole("samples", samples, 0)
    box = box_of(scene)
    with limited(limit, told) as budget:
        with share(_FOR_HANDS):
            held = tuple(held_in_box(scene, x) for x in scene.hands)
        with share(_FOR_SAMPLES):
            found = Tolerances(box, drawn(box, samples, seed) if box.sides else (), seed, budget, held)
        found.settle()
    return found


_FOR_HANDS = 0.3  # of the time
_FOR_SAMPLES = 0.3  # of what is left
