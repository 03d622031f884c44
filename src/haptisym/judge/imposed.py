"""Whether the force under imposed motion is stable: all poles of H_perc in Re s < 0."""

from __future__ import annotations

from haptisym.judge.passiveparts import environment_alone
from haptisym.judge.passivity import passivity
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.stability import is_stable
from haptisym.model.caveats import sampled_loop
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0; None where that is not decided, or they do not tell, as with a clock in a loop.

    By ``is_stable``; where that stays open, as infinitely many poles come as near to the axis as one likes, by the parts.
    """
    if sampled_loop(scene):
        return None
    found = is_stable(distortion.perc)
    if found is not None:
        return found
    alone = environment_alone(scene)
    try:
        return True if alone and passivity(alone).takes_energy else None
    except UndecidedError:
        return None
