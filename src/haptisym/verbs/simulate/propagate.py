"""Time steps of a linear state equation, exact for the equation, and the record of what it put out.

On a step the inputs are polynomials through their values at Gauss points, and the state's response to these is exact: it is
read off SciPy's matrix exponential of the equation extended by the polynomials. Stiff equations therefore need no small
steps, and what a step leaves behind are polynomials again, from which delay lines read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import legendre

from haptisym.programs.values import Array

POINTS = 10
"""Gauss points of a step: its polynomials have degree 9."""

NODES, WEIGHTS = (np.asarray(x) / 2 for x in legendre.leggauss(POINTS))
NODES = NODES + 0.5
"""Places of the Gauss points on a step from 0 to 1, and weights that integrate over it."""

_POWERS = np.arange(POINTS)
_TO_SERIES = np.linalg.inv(np.power.outer(2 * NODES - 1, _POWERS))
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(2 * NODES - 1, POINTS - 1))
_LEFT_ENDS = (-1.0) ** _POWERS[None, :]  # of the Legendre polynomials
_DERIVATIVE = 2 * legendre.legder(np.eye(POINTS), axis=0)  # with respect to a step from 0 to 1
_DERIVATIVE = np.vstack([_DERIVATIVE, np.zeros((1, POINTS))])
_AT_END = np.ones((1, POINTS)) @ _TO_SERIES


def at_end(values: Array) -> Array:
    """The value at the end of a step of polynomials with these values at its nodes (nodes on the last axis but one)."""
    result: Array = (_AT_END @ values)[..., 0, :]
    return result


def finer(samples: Array, places: Array) -> Array:
    """Samples at the nodes of successive steps, evaluated at other places of every step, from 0 to 1."""
    basis = np.power.outer(2 * places - 1, _POWERS) @ _TO_SERIES
    result: Array = (samples.reshape(-1, POINTS) @ basis.T).ravel()
    return result


def series(values: Array) -> Array:
    """Coefficients of ascending powers, on -1 to 1, of polynomials with these values at the nodes of a step."""
    result: Array = _TO_SERIES @ values
    return result


@dataclass(frozen=True, eq=False)
class Propagator:
    """Steps of z' = M z + N w; ``steady`` are the inputs that never change within a step."""

    M: Array
    N: Array
    steady: tuple[int, ...] = ()

    @cached_property
    def _driving(self) -> tuple[list[int], list[int]]:
        """The inputs that move the state at all: those that vary within a step, and the steady ones."""
        active = [i for i in range(self.N.shape[1]) if self.N[:, i].any()]
        return [i for i in active if i not in self.steady], [i for i in active if i in self.steady]

    @cached_property
    def _balance(self) -> Array:
        """Units for the states in which the numbers of the matrix are of like size."""
        from scipy.linalg import matrix_balance  # SciPy is an extra: asked for where it is needed

        _, (scale, _) = matrix_balance(self.M, permute=False, separate=True)
        return np.asarray(scale, dtype=float)

    @lru_cache(maxsize=4096)  # noqa: B019 - a propagator lives as long as its simulation
    def step(self, h: float) -> tuple[Array, Array]:
        """Maps to the state at the nodes and at the end of a step: from the state before it, and from the inputs' values.

        The inputs are a varying one's values node by node, then the steady ones.
        """
        from scipy.linalg import expm

        unchanged, per_second, from_values = self._extended
        n, scale = len(self.M), self._balance
        whole = expm(np.multiply.outer([*NODES, 1.0], unchanged + h * per_second))
        free = whole[:, :n, :n] * scale[:, None] / scale[None, :]
        return free, whole[:, :n, n:] @ (h * from_values) * scale[:, None]

    @cached_property
    def _extended(self) -> tuple[Array, Array, Array]:
        """The equation extended by the inputs' Legendre coefficients, without and with the factor h of a step's length; and the
        way from values at the nodes to these, which has that factor too."""
        scale, (varying, steady) = self._balance, self._driving
        N = self.N / scale[:, None]
        size = np.abs(N).max(axis=0, initial=0.0)  # a large input would cost the exponential its small entries
        n, m, count = len(self.M), len(varying), len(varying) * POINTS
        unchanged = np.zeros((n + count + len(steady),) * 2)
        unchanged[:n, n : n + count] = np.kron(_LEFT_ENDS, N[:, varying] / size[varying])
        unchanged[:n, n + count :] = N[:, steady] / size[steady]
        unchanged[n : n + count, n : n + count] = np.kron(_DERIVATIVE, np.eye(m))
        per_second = np.zeros_like(unchanged)
        per_second[:n, :n] = self.M / scale[:, None] * scale[None, :]
        from_values = np.diag(np.concatenate([np.zeros(count), size[steady]]))
        from_values[:count, :count] = np.kron(_TO_LEGENDRE, np.diag(size[varying]))
        return unchanged, per_second, from_values

    def march(self, z: Array, w: Array, h: float) -> tuple[Array, Array]:
        """The states at all nodes of as many steps as ``w`` has (steps, nodes, inputs), and the state after the last."""
        steps, n = len(w), len(self.M)
        if n == 0:
            return np.zeros((steps, POINTS, 0)), z
        free, forced = self.step(h)
        varying, steady = self._driving
        values = np.concatenate([w[..., varying].reshape(steps, -1), w[:, 0, steady]], axis=1)
        driven = (forced @ values.T).transpose(2, 0, 1)
        starts = np.empty((steps, n))
        for k in range(steps):
            starts[k] = z
            z = free[-1] @ z + driven[k, -1]
        inside = (free[:-1] @ starts.T).transpose(2, 0, 1) + driven[:, :-1]
        return inside, z


@dataclass
class Record:
    """Signals as polynomials, step by step: appended to at the end, read anywhere before it; constant before the start."""

    width: int
    before: Array = field(init=False)
    """What they were before the start; 0 if not said."""
    times: Array = field(default_factory=lambda: np.zeros(1024))
    lengths: Array = field(default_factory=lambda: np.zeros(1024))
    values: Array = field(default_factory=lambda: np.zeros((0, POINTS, 0)))
    coefficients: Array = field(default_factory=lambda: np.zeros((0, POINTS, 0)))
    count: int = 0

    def __post_init__(self) -> None:
        self.before = np.zeros(self.width)
        self.values = np.zeros((1024, POINTS, self.width))
        self.coefficients = np.zeros((1024, POINTS, self.width))

    def append(self, start: float, h: float, values: Array) -> None:
        """Steps of length h from a start on, with values (steps, nodes, signals)."""
        steps = len(values)
        while self.count + steps > len(self.times):
            self._grow()
        span = slice(self.count, self.count + steps)
        self.times[span], self.lengths[span] = start + h * np.arange(steps), h
        self.values[span], self.coefficients[span] = values, series(values)
        self.count += steps

    def _grow(self) -> None:
        for name in ("times", "lengths", "values", "coefficients"):
            old: Array = getattr(self, name)
            setattr(self, name, np.concatenate([old, np.zeros_like(old)]))

    def at(self, t: Array, columns: Sequence[int]) -> Array:
        """Signals at given times, along a new last axis; what they were before, before the first step."""
        if self.count == 0:
            return np.broadcast_to(self.before[list(columns)], (*t.shape, len(columns)))
        last = np.maximum(np.searchsorted(self.times[: self.count], t, side="right") - 1, 0)
        place = np.clip(2 * (t - self.times[last]) / self.lengths[last] - 1, -1.0, 1.0)
        basis = np.power.outer(place, _POWERS)[..., None, :]
        found = (basis @ self.coefficients[last][..., columns])[..., 0, :]
        return np.where((t < self.times[0])[..., None], self.before[list(columns)], found)

    @property
    def instants(self) -> Array:
        """The times of all nodes, (steps, nodes)."""
        steps = slice(0, self.count)
        result: Array = self.times[steps, None] + self.lengths[steps, None] * NODES
        return result

    @property
    def quadrature(self) -> Array:
        """Weights that integrate over all steps, (steps, nodes)."""
        result: Array = self.lengths[: self.count, None] * WEIGHTS
        return result
