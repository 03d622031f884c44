"""Events of a simulation: when they come, and which scenes would make them mean something infinite."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.linear import Drive, Linear, Reading
from haptisym.verbs.simulate.motions import Motion
from haptisym.verbs.simulate.network import MOTION, Network, Step, Switch
from haptisym.verbs.simulate.propagate import NODES, series

Systems: TypeAlias = dict[frozenset[int], Linear | None]


@dataclass(frozen=True)
class Guard:
    """A function of time that is >= 0 as long as an element stays as it is: sign * signal - bound."""

    element: Switch | Step
    reading: Reading
    sign: int
    bound: float


def falls(course: Array, both: Array, bad: int) -> float:
    """Where on the step, from 0 to 1, a guard falls through zero before the node ``bad``."""
    from scipy.optimize import brentq  # SciPy is an extra: asked for where it is needed

    coefficients = series(course[:, None])[:, 0]
    places = np.concatenate([[0.0], NODES, [1.0]])

    def value(place: float) -> float:
        return float(np.polynomial.polynomial.polyval(2 * place - 1, coefficients))

    start = next((i for i in range(bad, -1, -1) if value(places[i]) > 0), None)
    if start is None:
        return 0.0
    return float(brentq(value, places[start], places[bad + 1], xtol=1e-15))


def check_jumps(net: Network, systems: Systems) -> None:
    """Raise SceneError where the derivative of something that jumps is needed."""
    allowed = {h.target: 0 for h in net.holds} | {s.target: 0 for s in net.steps}
    # saturation has kinks alone; friction has too where it acts on a spring and so cannot jump
    allowed |= {s.target: int(bool(s.offset) or _moves_itself(s, systems)) for s in net.switches}
    for system in systems.values():
        for drive in system.drives if system else ():
            if drive[1] > allowed.get(drive[0].name, drive[1]) and system and _acts(system, drive, net):
                element = next(e for e in net.elements if e.target == drive[0].name)
                raise SceneError(
                    f"{element.name}: what comes out of it jumps, and the scene differentiates it; put a filter behind it, "
                    "or render a filtered velocity ([rendered])"
                )


def check_derivatives(motion: Motion, systems: Systems) -> None:
    """Raise SceneError where the scene needs more derivatives of the motion than it has."""
    present = [system for system in systems.values() if system]
    needed = [
        k for x in present for drive in x.drives for k in [drive[1]] if drive[0].name == MOTION and _acts(x, drive)
    ]
    if max(needed, default=0) > motion.smoothness:
        raise SceneError(
            f"{motion.name}: the scene needs derivative {max(needed)} of the motion; a recording has {motion.smoothness}"
        )


def _moves_itself(switch: Switch, systems: Systems) -> bool:
    """Whether the derivative of a friction force is in the velocity that it acts on."""
    system = systems[frozenset()]
    assert system is not None
    row = system.rows[system.readings.index((switch.driver, 0))]
    places = [system.exact.size + i for i, (x, k) in enumerate(system.drives) if (x.name, k) == (switch.target, 1)]
    return bool(row[places].any())


def _acts(system: Linear, drive: Drive, net: Network | None = None) -> bool:
    """Whether an input's derivative is in anything but the velocities that only switches look at."""
    watched = [(s.driver, k) for s in net.switches for k in (0, 1)] if net else []
    rows = [i for i, reading in enumerate(system.readings) if reading not in watched]
    index = system.drives.index(drive)
    return bool(system.rows[rows, system.exact.size + index].any() or system.propagator.N[:, index].any())
