"""Whether the force under imposed motion is stable: all poles of H_perc in Re s < 0."""

from __future__ import annotations

from sympy import Integer, pi

from haptisym.judge.passiveparts import environment_alone, takes_energy
from haptisym.judge.passivity import passivity
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.roots import chart
from haptisym.kernel.stability import is_stable
from haptisym.model.caveats import sampled_loop
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene

_TURNS = 2  # of the longest delay
_NAME = "H_perc"


def force_is_stable(scene: Scene, distortion: Distortion) -> bool | None:
    """Whether all poles of H_perc have Re s < 0; None where that is not decided, or they do not tell, as with a clock in a loop.

    By ``is_stable``; where that stays open, as infinitely many poles come as near to the axis as one likes, by the parts: of an
    environment that damps none reaches it. A display without losses is real on the axis, where its poles show.
    """
    if sampled_loop(scene):
        return None
    found = is_stable(distortion.perc)
    if found is not None:
        return found
    alone = environment_alone(scene)
    try:
        if alone and (passivity(alone).takes_energy or _damps(alone)):
            return True
        return False if _has_pole_on_axis(distortion) else None
    except UndecidedError:
        return None


def _damps(scene: Scene) -> bool:
    """Whether Im H_env > 0 at every frequency > 0 by signs alone, powers of s included."""
    return takes_energy(scene.environment.H) and not scene.closed.env_response.raw_imag.is_zero


def _has_pole_on_axis(distortion: Distortion) -> bool:
    """Whether H_perc is real on the axis, and has a pole among the first turns of its longest delay."""
    perceived, ring = distortion.perc_response, distortion.perc.ring
    assert isinstance(ring, Ring)
    if not ring.lags or not perceived.raw_imag.is_zero:
        return False
    high = _TURNS * 2 * pi / max(ring.lags)
    points = chart({_NAME: perceived.real}, Integer(0), high).points
    return any(x.orders.get(_NAME, 0) < 0 and _NAME not in x.undecided for x in points[1:])
