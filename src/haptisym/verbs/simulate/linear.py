"""A network's state equation in floats, with a row for every signal that something reads.

What clocks, switches and delay lines read is found by following the inputs back: a delayed signal whose derivative is needed
makes that derivative a signal to record, and so on until nothing new is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.descriptor import HIGHEST_ORDER, Input, SignalRow, StateSpace, state_space
from haptisym.verbs.simulate.network import MOTION, Network
from haptisym.verbs.simulate.propagate import Propagator

Reading = tuple[str, int]
"""A signal and how often it is differentiated."""
Drive = tuple[Input, int]
"""An input and how often it is differentiated."""


@dataclass(frozen=True, eq=False)
class Linear:
    """The equations while each switch stays as it is: ``states`` says which of them are closed."""

    exact: StateSpace
    drives: tuple[Drive, ...]
    readings: tuple[Reading, ...]
    propagator: Propagator
    rows: Array
    """(readings, state + drives): a reading is this times [z; w]."""
    everything: Array = field(repr=False)
    """The same for every variable of the equations, from which another system's state is taken."""
    back: Array = field(repr=False)
    """(state, drives): what is subtracted from the chosen variables to give the state."""

    def outputs(self, z: Array, w: Array) -> Array:
        """The readings, from states (..., state) and inputs (..., drives)."""
        n = self.exact.size
        result: Array = z @ self.rows[:, :n].T + w @ self.rows[:, n:].T
        return result

    def weight(self, row: Array, name: str, order: int) -> float:
        """That of a derivative of an input, as it is now, in a row of ``rows``."""
        here = ((x.name, k) == (name, order) and x.lag == 0 for x, k in self.drives)
        return float(sum(row[self.exact.size + i] for i, is_it in enumerate(here) if is_it))

    def poles(self) -> Any:
        """The eigenvalues of the state equation without what comes back through delay lines, 1/s."""
        return np.linalg.eigvals(self.propagator.M) if self.exact.size else np.zeros(0, dtype=complex)


def linear_systems(net: Network, readings: Sequence[Reading]) -> dict[frozenset[int], Linear | None]:
    """The state equation for each set of closed switches; None where it would stop the prescribed motion itself."""
    sets = [frozenset(i for i in range(len(net.switches)) if bits >> i & 1) for bits in range(1 << len(net.switches))]
    exact = {closed: _exact(net, closed) for closed in sets}
    present = [x for x in exact.values() if x is not None]
    wanted = _followed(present, net, readings)
    return {closed: None if x is None else _floats(x, net, wanted) for closed, x in exact.items()}


def _exact(net: Network, closed: frozenset[int]) -> StateSpace | None:
    known = set(net.jumps) - {net.switches[i].target for i in closed}
    try:
        return state_space([*net.equations, *(net.switches[i].closed for i in closed)], known)
    except SceneError:
        if not closed:
            raise
        return None


def _followed(systems: Sequence[StateSpace], net: Network, readings: Sequence[Reading]) -> tuple[Reading, ...]:
    """All signals to record: those asked for, and whatever delay lines need of others."""
    wanted = list(dict.fromkeys(readings))
    for reading in wanted:  # grows while it is walked
        if reading[1] > HIGHEST_ORDER:
            raise SceneError(
                f"{reading[0].split('.')[0]}: the scene needs ever higher derivatives of what comes back through a delay: "
                "it is not causal (an advanced equation)"
            )
        for system in systems:
            for drive, order in _drives_of(system, reading, net):
                new = (drive.name, order)
                if drive.lag != 0 and drive.name != MOTION and new not in wanted:
                    wanted.append(new)
    return tuple(wanted)


def _drives_of(system: StateSpace, reading: Reading, net: Network) -> list[Drive]:
    """The inputs of a signal and of the state equation, with the derivatives that act."""
    driving = [(x, k) for x in system.inputs for k in system.drives(x)]
    if reading[0] in net.jumps and not any(name == reading[0] for name, _ in system.columns):
        return driving
    row = system.signal(*reading)
    direct = [(x, k) for k, c in enumerate(row.inputs) for i, x in enumerate(system.inputs) if c[0, i] != 0]
    back = [(x, k) for k, c in enumerate(system.shifts) for i, x in enumerate(system.inputs) if _any(c, i)]
    return [*driving, *direct, *back]


def _any(matrix: Any, column: int) -> bool:
    return any(matrix[i, column] != 0 for i in range(matrix.nrows()))


def _floats(system: StateSpace, net: Network, readings: tuple[Reading, ...]) -> Linear:
    found = [drive for reading in readings for drive in _drives_of(system, reading, net)]
    drives = tuple(dict.fromkeys([*found, *((x, 0) for x in system.inputs)]))
    own = [_row(system, reading, drives, net) for reading in readings]
    every = [_row(system, key, drives, net) for key in system.columns]
    back = np.zeros((system.size, len(drives)))
    for k, matrix in enumerate(system.shifts):
        for i, channel in enumerate(system.inputs):
            if (channel, k) in drives:
                back[:, drives.index((channel, k))] = [_float(matrix[r, i]) for r in range(system.size)]
    N = np.zeros((system.size, len(drives)))
    for i, (channel, k) in enumerate(drives):
        if k < len(system.N):
            column = system.inputs.index(channel)
            N[:, i] = [_float(system.N[k][r, column]) for r in range(system.size)]
    width = system.size + len(drives)
    steady = tuple(i for i, (x, _) in enumerate(drives) if x.lag == 0 and x.name in net.jumps)
    return Linear(
        system, drives, readings, Propagator(_array(system.M), N, steady), np.array(own).reshape(-1, width),
        np.array(every).reshape(-1, width), back,
    )  # fmt: skip


def _row(system: StateSpace, reading: Reading, drives: tuple[Drive, ...], net: Network) -> list[float]:
    if reading[0] in net.jumps and not any(name == reading[0] for name, _ in system.columns):
        own = (next(x for x in system.inputs if x.name == reading[0] and x.lag == 0), reading[1])
        return [0.0] * system.size + [float(drive == own) for drive in drives]
    row: SignalRow = system.signal(*reading)
    state = [_float(row.state[0, i]) for i in range(system.size)]
    direct = [_float(row.inputs[k][0, system.inputs.index(x)]) if k < len(row.inputs) else 0.0 for x, k in drives]
    return state + direct


def _float(number: Any) -> float:
    return int(number.p) / int(number.q)


def _array(matrix: Any) -> Array:
    return np.array([_float(x) for row in matrix.tolist() for x in row]).reshape(matrix.nrows(), matrix.ncols())
