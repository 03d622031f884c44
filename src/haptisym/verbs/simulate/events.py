"""Events of a simulation: when they come, and which scenes would make them mean something infinite."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from heapq import heappop, heappush
from math import gcd
from typing import TypeAlias

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.descriptor import Drive, Linear, Reading
from haptisym.verbs.simulate.motions import Motion
from haptisym.verbs.simulate.network import MOTION, Network, Step, Switch
from haptisym.verbs.simulate.propagate import NODES, at_end, series

_GENERATIONS = 4  # of break points that a jump leaves behind delay lines: each passage through a filter smooths it
Systems: TypeAlias = dict[frozenset[int], Linear | None]


@dataclass(frozen=True)
class Guard:
    """A function of time that is >= 0 as long as an element stays as it is: sign * signal - bound."""

    element: Switch | Step
    reading: Reading
    sign: int
    bound: float


def falls(course: Array, bad: int) -> float:
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


def guards(net: Network, modes: Sequence[int], held: Mapping[str, float], resting: Container[int] = ()) -> list[Guard]:
    """What ends the present state of each element: ``modes`` of the switches, and the values that are ``held``.

    Nothing does of those that are ``resting``, before the motion goes on.
    """
    found = []
    for i, (switch, mode) in enumerate(zip(net.switches, modes, strict=True)):
        if i in resting:
            continue
        if mode == 0:
            found += [Guard(switch, (switch.target, 0), sign, -switch.limit) for sign in (1, -1)]
        else:
            found.append(Guard(switch, (switch.driver, 0), mode, switch.offset))
    for step in net.steps:
        middle, half = held[step.target], step.resolution / 2
        found += [Guard(step, (step.source, 0), sign, sign * middle - half) for sign in (1, -1)]
    return found


def first_event(
    watched: Iterable[Guard], values: Array, column: Callable[[str, int], int], motion: Motion
) -> tuple[int, float, Guard] | None:
    """The first guard that falls below zero in a chunk of steps: in which of them, and where on it, from 0 to 1.

    ``values`` : of all readings at the nodes of each step, in the ``column`` of each.
    """
    found: list[tuple[int, float, Guard]] = []
    for guard in watched:
        course = guard.sign * values[:, :, column(*guard.reading)] - guard.bound
        both = np.concatenate([course, at_end(course[..., None])], axis=1)
        scale = motion.amplitude * (motion.span[1] if isinstance(guard.element, Switch) else 1)
        tolerance = 1e-12 * max(abs(guard.bound), float(np.abs(course).max()), 1e-12 * scale)
        bad = both < -tolerance
        if bad.any():
            step = int(np.argmax(bad.any(axis=1)))
            found.append((step, falls(course[step], int(np.argmax(bad[step]))), guard))
    return min(found, key=lambda event: event[:2]) if found else None


class Breaks:
    """Instants at which what jumped once comes out of a delay line; ``lags`` : of the lines, s."""

    def __init__(self, lags: Sequence[float], known: Iterable[float] = ()) -> None:
        self.lags = lags
        self.due: list[float] = []
        for t in known:
            heappush(self.due, t)
            self.after(t)

    def after(self, t: float) -> None:
        """Something jumps at t."""
        reached = {t}
        for _ in range(_GENERATIONS):
            reached = {t + lag for t in reached for lag in self.lags}
            for t in reached:
                heappush(self.due, t)

    def next(self, t: float) -> list[float]:
        """The first one after t, if there is one; those before are over."""
        while self.due and self.due[0] <= t:
            heappop(self.due)
        return self.due[:1]


def common_measure(one: Fraction, other: Fraction) -> Fraction:
    """The longest time that both are whole multiples of."""
    below = one.denominator * other.denominator
    return Fraction(gcd(one.numerator * other.denominator, other.numerator * one.denominator), below)


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
