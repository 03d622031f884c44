"""Exact reduction of equations of motion to a state equation, and time steps that are exact for it.

The equations of a network are a descriptor system E x' = A x + B w, in which masses beside masses,
rigid connections and prescribed motions make E singular (differential-algebraic, of any index).
Each round of ``_reduced`` takes the algebraic equations, solves them for as many variables and puts
these back, over the rational numbers, so that no rank is ever guessed.
What remains is

    z' = M z + N_0 w + N_1 dw/dt + ...,    any signal = K z + C_0 w + C_1 dw/dt + C_2 d2w/dt2 + ...

where w are the inputs: the hand's motion, delayed signals and what clocks and switches set. Only
the hand's motion, which is known with all its derivatives, keeps an N of higher order. What clocks,
switches and delay lines read is found by following the inputs back: a delayed signal whose
derivative is needed makes that derivative a signal to record, until nothing new is needed.

On a step the inputs are polynomials through their values at Gauss points, and the state's response
to these is exact: it is read off SciPy's matrix exponential of the equation extended by the
polynomials, or of a short step, as between two switches, summed as a series in h M. Stiff equations
therefore need no small steps, and what a step leaves behind are polynomials again, from which delay
lines read.

A *signal* is a force or a motion of the network and its derivatives; a *drive* is an input and how
often it is differentiated, a *reading* a signal and how often. Begin with ``state_space`` for the
exact half, with ``Propagator.step`` for the floats, and with ``linear_systems`` for what joins
them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import chain
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.polynomial import legendre

from haptisym.kernel.errors import SceneError
from haptisym.programs.values import Array
from haptisym.verbs.simulate.network import MOTION, Exact, Network, SignalSum, float_of

POINTS = 10
"""Gauss points of a step: its polynomials have degree 9."""

NODES, WEIGHTS = (np.asarray(x) / 2 for x in legendre.leggauss(POINTS))
NODES = NODES + 0.5
"""Places of the Gauss points on a step from 0 to 1, and weights that integrate over it."""

# Powers of 2 x - 1, on [-1, 1]: there the matrix of ten nodes has a condition number of 2e3, on
# [0, 1] it would have one of 5e6.
_POWERS = np.arange(POINTS)
_TO_SERIES = np.linalg.inv(np.power.outer(2 * NODES - 1, _POWERS))
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(2 * NODES - 1, POINTS - 1))
# P_k(-1) = (-1)^k: the input at the beginning of a step, from its Legendre coefficients.
_LEFT_ENDS = (-1.0) ** _POWERS[None, :]
_DERIVATIVE = 2 * legendre.legder(np.eye(POINTS), axis=0)  # with respect to a step from 0 to 1
_DERIVATIVE = np.vstack([_DERIVATIVE, np.zeros((1, POINTS))])
_AT_END = np.ones((1, POINTS)) @ _TO_SERIES

# Terms of the series, for steps of such a norm of h M: what is left of exp is 1/20! = 4e-19.
_TERMS = 20
_SHORT = 1.0
_PLACES = np.array([*NODES, 1.0])
_FACTORIALS = np.cumprod([1.0, *range(1, _TERMS + 1)])
_EXPONENTS = np.arange(_TERMS)[:, None]
# x^k/k!, and its integral from 0 to x.
_FREE = _PLACES**_EXPONENTS / _FACTORIALS[:-1, None]
_STEADY = _PLACES ** (_EXPONENTS + 1) / _FACTORIALS[1:, None]


def _repeated_integrals() -> Array:
    """Return int_0^x (x - s)^k/k! l(s) ds at the places x, where l is 1 at one node and 0 at the
    others; shape (terms, places, nodes)."""
    # The integrand has degree 19 + 9 at the most; 20 Gauss points are exact up to degree 39.
    x, weights = legendre.leggauss(POINTS + _TERMS // 2)
    s = np.multiply.outer(_PLACES, (x + 1) / 2)
    basis = legendre.legvander(2 * s - 1, POINTS - 1) @ _TO_LEGENDRE
    places = _PLACES[:, None]
    powers = (places - s) ** _EXPONENTS[..., None]
    powers = powers / _FACTORIALS[:-1, None, None]
    weighted = powers * weights * places / 2
    result: Array = np.einsum("kps,psi->kpi", weighted, basis)
    return result


_VARYING = _repeated_integrals()


def at_end(values: Array) -> Array:
    """The value at the end of a step of polynomials with these values at its nodes (nodes on the
    last axis but one)."""
    result: Array = (_AT_END @ values)[..., 0, :]
    return result


def finer(samples: Array, places: Array) -> Array:
    """Samples at the nodes of successive steps, evaluated at other places of every step, from 0 to
    1."""
    basis = np.power.outer(2 * places - 1, _POWERS) @ _TO_SERIES
    result: Array = (samples.reshape(-1, POINTS) @ basis.T).ravel()
    return result


def series(values: Array) -> Array:
    """Coefficients of ascending powers, on -1 to 1, of polynomials with these values at the nodes
    of a step."""
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
        """The inputs that move the state at all: those that vary within a step, and the steady
        ones."""
        varying: list[int] = []
        steady: list[int] = []
        for i in range(self.N.shape[1]):
            if self.N[:, i].any():
                kind = steady if i in self.steady else varying
                kind.append(i)
        return varying, steady

    @cached_property
    def _balance(self) -> Array:
        """Units of the states in which the entries of M are of similar size."""
        from scipy.linalg import matrix_balance  # SciPy is an extra: asked for where it is needed

        _, (scale, _) = matrix_balance(self.M, permute=False, separate=True)
        return np.asarray(scale, dtype=float)

    @lru_cache(maxsize=4096)  # noqa: B019 - a propagator lives as long as its simulation
    def step(self, h: float) -> Array:
        """Maps to the state at the nodes and at the end of a step: (places, state, what it follows
        from).

        That is the state before, a varying input's values node by node, then the steady ones.
        """
        from scipy.linalg import expm

        # The two ways agree to rounding. A matrix exponential is expensive, so that a short step,
        # as between two switches, whose length comes only once, is summed as a series of known
        # terms.
        n = len(self.M)
        varying, steady = self._driving
        width = n + len(varying) * POINTS + len(steady)
        norm = h * self._size
        if norm <= _SHORT:
            weights = norm ** np.arange(_TERMS)
            maps = (weights @ self._series).reshape(len(_PLACES), n, width)
            # An integral over a step has one factor h more than the powers of h M.
            maps[:, :, n:] *= h
            return maps
        unchanged, per_second, from_values = self._extended
        scale = self._balance
        # One exponential for each node: with the polynomial's coefficients as further states, which
        # a nilpotent block differentiates, exp gives the response to the input exactly.
        whole = expm(np.multiply.outer(_PLACES, unchanged + h * per_second))
        free = whole[:, :n, :n] * scale[:, None] / scale[None, :]
        driven = whole[:, :n, n:] @ (h * from_values)
        driven = driven * scale[:, None]
        return np.concatenate([free, driven], axis=2)

    @cached_property
    def _size(self) -> float:
        """A norm of M, 1/s."""
        _, per_second, _ = self._extended
        columns = np.abs(per_second).sum(axis=0)
        return float(columns.max(initial=0.0)) or 1.0

    @cached_property
    def _series(self) -> Array:
        """Coefficients of the same maps as power series in h times the norm of M: of (h M)^k,
        and of (h M)^k N with the inputs' repeated integrals."""
        n = len(self.M)
        scale = self._balance
        varying, steady = self._driving
        _, per_second, _ = self._extended
        M = per_second[:n, :n] / self._size
        N = self.N[:, [*varying, *steady]] / scale[:, None]
        # M^k and M^k N side by side, in balanced units and divided by the norm: no power overflows.
        parts = [np.hstack([np.eye(n), N])]
        for _ in range(_TERMS - 1):
            parts.append(M @ parts[-1])
        blocks = np.split(np.stack(parts), [n, n + len(varying)], axis=2)
        free, moved, held = (block[:, None] for block in blocks)
        free = _FREE[:, :, None, None] * free
        free = free * scale[:, None] / scale[None, :]
        moved = np.einsum("kpi,kqnm->kpnim", _VARYING, moved)
        moved = moved.reshape(_TERMS, len(_PLACES), n, len(varying) * POINTS)
        moved = moved * scale[:, None]
        held = _STEADY[:, :, None, None] * held
        held = held * scale[:, None]
        maps = np.concatenate([free, moved, held], axis=3)
        return maps.reshape(_TERMS, -1)

    @cached_property
    def _extended(self) -> tuple[Array, Array, Array]:
        """The equation extended by the inputs' Legendre coefficients, without and with the factor h
        of a step's length; and the way from values at the nodes to these, which has that factor
        too."""
        scale = self._balance
        varying, steady = self._driving
        N = self.N / scale[:, None]
        # Inputs are scaled to columns of size 1: a large one would cost the exponential its small
        # entries, as its error is relative to the largest.
        size = np.abs(N).max(axis=0, initial=0.0)
        n = len(self.M)
        m = len(varying)
        count = m * POINTS
        inputs = slice(n, n + count)
        width = n + count + len(steady)
        unchanged = np.zeros((width, width))
        by_varying = N[:, varying] / size[varying]
        unchanged[:n, inputs] = np.kron(_LEFT_ENDS, by_varying)
        unchanged[:n, n + count :] = N[:, steady] / size[steady]
        unchanged[inputs, inputs] = np.kron(_DERIVATIVE, np.eye(m))
        per_second = np.zeros_like(unchanged)
        per_second[:n, :n] = self.M / scale[:, None] * scale[None, :]
        constant = np.concatenate([np.zeros(count), size[steady]])
        from_values = np.diag(constant)
        by_nodes = np.diag(size[varying])
        from_values[:count, :count] = np.kron(_TO_LEGENDRE, by_nodes)
        return unchanged, per_second, from_values

    def march(
        self, z: Array, w: Array, h: float, change: Callable[[int, Array], None] | None = None
    ) -> tuple[Array, Array]:
        """The states at all nodes of as many steps as ``w`` has (steps, nodes, inputs), and those
        at their ends, first to last.

        ``change`` : called before each step but the first with its number and the state, sets its
        steady inputs, and the later ones', in ``w``.
        """
        steps = len(w)
        n = len(self.M)
        varying, steady = self._driving
        maps = self.step(h) if n else np.zeros((len(_PLACES), 0, 0))
        values = w[..., varying].reshape(steps, -1)
        states = np.empty((steps + 1, n))
        # Only the states at the ends follow from each other, one after the other; those at the
        # nodes follow from these, all steps in one product below.
        last, moved, held = np.split(maps[-1], [n, n + values.shape[1]], axis=1)
        driven = values @ moved.T
        for k in range(steps):
            if k and change is not None:
                change(k, z)
            states[k] = z
            z = last @ z + driven[k] + held @ w[k, 0, steady]
        states[steps] = z
        known = np.concatenate([states[:-1], values, w[:, 0, steady]], axis=1)
        to_nodes = maps[:-1].reshape(POINTS * n, known.shape[1])
        at_nodes = known @ to_nodes.T
        return at_nodes.reshape(steps, POINTS, n), states


@dataclass
class Record:
    """A record of signals as polynomials, step by step: appended to at the end, read anywhere
    before it; constant before the start."""

    width: int
    before: Array = field(init=False)
    """The constant values before the start; 0 unless set."""
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
        # Doubling keeps the cost of copying proportional to what is recorded.
        while self.count + steps > len(self.times):
            for name in ("times", "lengths", "values", "coefficients"):
                old: Array = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)]))
        span = slice(self.count, self.count + steps)
        self.times[span] = start + h * np.arange(steps)
        self.lengths[span] = h
        self.values[span] = values
        self.coefficients[span] = series(values)
        self.count += steps

    def at(self, t: Array, columns: Sequence[int]) -> Array:
        """Return signals at given times, along a new last axis; before the first step what they
        were before the start."""
        before = self.before[list(columns)]
        if self.count == 0:
            return np.broadcast_to(before, (*t.shape, len(columns)))
        later = np.searchsorted(self.times[: self.count], t, side="right")
        step = np.maximum(later - 1, 0)
        elapsed = t - self.times[step]
        place = 2 * elapsed / self.lengths[step] - 1
        # A time that lies beyond its step by rounding is read at the end: a polynomial of degree 9
        # must not be extrapolated.
        place = np.clip(place, -1.0, 1.0)
        basis = np.power.outer(place, _POWERS)
        coefficients = self.coefficients[step][..., columns]
        values = (basis[..., None, :] @ coefficients)[..., 0, :]
        is_before = (t < self.times[0])[..., None]
        return np.where(is_before, before, values)

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


RationalMatrix: TypeAlias = Any  # flint.fmpq_mat, which ships no types

HIGHEST_ORDER = 12
"""The highest derivative of an input: beyond it equations lead around a loop of pure
derivatives."""


class Input(NamedTuple):
    """An input of the equations: a signal that is known at any time, and its delay, s."""

    name: str
    lag: Exact


class SignalRow(NamedTuple):
    """A signal in terms of the state and of the inputs' derivatives, order by order."""

    state: RationalMatrix
    inputs: tuple[RationalMatrix, ...]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """z' = M z + N_0 w + N_1 dw/dt + ..., with every variable of the equations as K z + C_0 w + C_1
    dw/dt + ...

    ``chosen`` and ``shifts`` lead back: z is the chosen variables minus the sum of R_k times the
    k-th derivative of w.
    """

    inputs: tuple[Input, ...]
    columns: dict[tuple[str, int], int]
    M: RationalMatrix
    N: tuple[RationalMatrix, ...]
    K: RationalMatrix
    C: tuple[RationalMatrix, ...]
    chosen: tuple[int, ...]
    shifts: tuple[RationalMatrix, ...]

    def signal(self, name: str, order: int = 0) -> SignalRow:
        """Return a signal, differentiated that many times."""
        known = max((k for n, k in self.columns if n == name), default=-1)
        column = self.columns[name, min(order, known)]
        inputs = tuple(_row(c, column) for c in self.C)
        row = SignalRow(_row(self.K, column), inputs)
        # d/dt (a z + sum of c_k w^(k)) = a M z + sum of (a N_k + c_(k-1)) w^(k).
        for _ in range(order - known):
            by_state = [row.state * n for n in self.N]
            by_inputs = [0 * by_state[0], *row.inputs]
            derived = _added(by_state, by_inputs)
            row = SignalRow(row.state * self.M, tuple(derived))
        return row

    def reach(self, name: str, order: int, channel: Input) -> int | None:
        """The highest derivative of an input in a signal; -1 if it acts through the state alone,
        None if not at all."""
        row = self.signal(name, order)
        index = self.inputs.index(channel)
        direct = [k for k, c in enumerate(row.inputs) if c[0, index] != 0]
        if direct:
            return max(direct)
        # a M^j n for j below the number of states: by Cayley and Hamilton the input reaches the
        # signal only if one of them is not 0.
        for n in self.N:
            column = [n[i, index] for i in range(self.size)]
            moved = fmpq_mat(self.size, 1, column)
            for _ in range(self.size):
                felt = row.state * moved
                if felt[0, 0] != 0:
                    return -1
                moved = self.M * moved
        return None

    def drives(self, channel: Input) -> list[int]:
        """The orders of an input's derivatives that the state equation holds."""
        index = self.inputs.index(channel)
        orders = []
        for k, n in enumerate(self.N):
            if any(n[i, index] != 0 for i in range(self.size)):
                orders.append(k)
        return orders

    @cached_property
    def size(self) -> int:
        """Number of states."""
        return int(self.M.nrows())


def state_space(equations: Sequence[SignalSum], known: Iterable[str] = ()) -> StateSpace:
    """Return the state equation of as many equations of motion as there are unknown signals.

    ``known``: signals that are inputs beside the motion and everything late. Raises SceneError
    where the equations contradict each other or leave a signal open.

    >>> x, f, u = SignalSum.of("x"), SignalSum.of("f"), SignalSum.of("motion")
    >>> system = state_space([f - 2 * x.d(2) - 3 * x, x - u])       # a mass and a spring, moved by hand: no state at all
    >>> system.size, [str(c[0, 0]) for c in system.signal("f").inputs]
    (0, ['3', '0', '2'])
    """
    known = tuple(known)
    fixed = {MOTION, *known}
    keys = [key for equation in equations for key in equation.terms]
    if any(lag < 0 for _, _, lag in keys):
        raise SceneError("a negative delay cannot be simulated")
    inputs: list[Input] = []
    # The highest derivative of each unknown in the equations.
    orders: dict[str, int] = {}
    for name, order, lag in keys:
        if name in fixed or lag != 0:
            inputs.append(Input(name, lag))
        if name not in fixed:
            own_order = order if lag == 0 else 0
            orders[name] = max(orders.get(name, 0), own_order)
    inputs += [Input(name, fmpq(0)) for name in known]
    distinct = tuple(dict.fromkeys(inputs))
    return _reduced(_Descriptor.of(equations, distinct, orders))


@dataclass(frozen=True, eq=False)
class _Descriptor:
    """The equations as E x' = A x + B_0 w + B_1 dw/dt + ...; ``columns`` : where each unknown,
    (name, order), is in x."""

    inputs: tuple[Input, ...]
    columns: dict[tuple[str, int], int]
    E: RationalMatrix
    A: RationalMatrix
    B: tuple[RationalMatrix, ...]

    @classmethod
    def of(
        cls, equations: Sequence[SignalSum], inputs: tuple[Input, ...], orders: dict[str, int]
    ) -> _Descriptor:
        # algebraic variables first: they are the ones that algebraic equations are solved for
        ordered = sorted(orders, key=lambda name: orders[name] > 0)
        listed = [(name, k) for name in ordered for k in range(max(orders[name], 1))]
        columns = {key: i for i, key in enumerate(listed)}
        # x^(k+1) is the derivative of x^(k): one more equation for each unknown derivative.
        chains = [(name, k) for name, k in listed if k + 1 < orders[name]]
        size = len(columns)
        rows = len(equations) + len(chains)
        keys = [key for equation in equations for key in equation.terms]
        of_inputs = [k for name, k, lag in keys if Input(name, lag) in inputs]
        depth = 1 + max(of_inputs, default=0)
        E = fmpq_mat(rows, size)
        A = fmpq_mat(rows, size)
        B = tuple(fmpq_mat(rows, len(inputs)) for _ in range(depth))
        for i, equation in enumerate(equations):
            for (name, order, lag), value in equation.terms.items():
                channel = Input(name, lag)
                if channel in inputs:
                    B[order][i, inputs.index(channel)] -= value
                elif order and order == orders[name]:
                    E[i, columns[name, order - 1]] += value
                else:
                    A[i, columns[name, order]] -= value
        for i, (name, order) in enumerate(chains, len(equations)):
            E[i, columns[name, order]] = fmpq(1)
            A[i, columns[name, order + 1]] = fmpq(1)
        return cls(inputs, columns, E, A, B)


def _reduced(system: _Descriptor) -> StateSpace:
    """Reduce a descriptor system to a state equation; SceneError where it has no unique solution.

    In each round the variables are K z + C_0 w + C_1 dw/dt + ... of those, z, that are left.
    """
    E, A, B = system.E, system.A, list(system.B)
    size = E.ncols()
    width = len(system.inputs)
    if E.nrows() != size:
        raise SceneError(
            f"the effects give {E.nrows()} equations for {size} unknowns: they do not "
            f"determine the motion"
        )
    chosen = list(range(size))
    K = fmpq_mat(size, size)
    C = [fmpq_mat(size, width)]
    for i in range(size):
        K[i, i] = fmpq(1)
    # A round takes out the equations without a derivative, and what it puts in their place may have
    # none again. When no equation is algebraic E has full rank: the echelon form is solved for z'.
    while True:
        upper, lower = _row_reduced(E, A, B)
        if not lower:
            break
        if len(B) > HIGHEST_ORDER * 2:
            raise SceneError("the effects form a loop of pure derivatives")
        pivots, back, forward = _solved(lower, E.ncols(), len(B), width)
        keep = [i for i in range(E.ncols()) if i not in pivots]
        E, A, B = _substituted(upper, E.ncols(), width, back, forward)
        C = _added(C, [K * f for f in forward])
        K = K * back
        chosen = [chosen[i] for i in keep]
    # The echelon form is [1 | -M | -N_0 | -N_1 | ...].
    inputs = 2 * len(chosen)  # the column where they begin
    rows = _stack(upper, inputs + width * len(B))
    M = -1 * _columns(rows, len(chosen), inputs)
    N = []
    for k in range(len(B)):
        start = inputs + k * width
        N.append(-1 * _columns(rows, start, start + width))
    return _without_derivatives(system, M, N, K, C, tuple(chosen))


def _row_reduced(
    E: RationalMatrix, A: RationalMatrix, B: Sequence[RationalMatrix]
) -> tuple[list[list[Any]], list[list[Any]]]:
    """The rows of [E | -A | -B] in echelon form: those with a derivative, and those without."""
    parts = [E, -1 * A, *(-1 * b for b in B)]
    tables = [part.tolist() for part in parts]
    size = E.ncols()
    width = 2 * size + sum(b.ncols() for b in B)
    table = [list(chain(*row)) for row in zip(*tables, strict=True)]
    form, _ = _stack(table, width).rref()
    rows = [row for row in form.tolist() if any(x != 0 for x in row)]
    # A row of inputs alone would prescribe what is given, and fewer rows than unknowns leave a
    # signal free. Numbers are exact: that an entry is 0 is known.
    lower = [row for row in rows if all(x == 0 for x in row[:size])]
    prescribes = any(all(x == 0 for x in row[: 2 * size]) for row in lower)
    if prescribes or len(rows) < size:
        raise SceneError("the effects contradict each other, or do not determine a signal")
    # In echelon form rows without a derivative come last.
    upper = rows[: len(rows) - len(lower)]
    return upper, lower


def _solved(
    lower: list[list[Any]], size: int, depth: int, width: int
) -> tuple[list[int], RationalMatrix, list[RationalMatrix]]:
    """The pivot variables of algebraic equations, and all variables in terms of the others and of
    the inputs."""
    rows = [row[size:] for row in lower]
    pivots = [next(i for i, x in enumerate(row) if x != 0) for row in rows]
    keep = [i for i in range(size) if i not in pivots]
    back = fmpq_mat(size, len(keep))
    forward = [fmpq_mat(size, width) for _ in range(depth)]
    for position, i in enumerate(keep):
        back[i, position] = fmpq(1)
    for pivot, row in zip(pivots, rows, strict=True):
        for position, i in enumerate(keep):
            back[pivot, position] = -row[i]
        for k in range(depth):
            for c in range(width):
                forward[k][pivot, c] = -row[size + k * width + c]
    return pivots, back, forward


def _substituted(
    upper: list[list[Any]],
    size: int,
    width: int,
    back: RationalMatrix,
    forward: list[RationalMatrix],
) -> tuple[RationalMatrix, RationalMatrix, list[RationalMatrix]]:
    """The remaining equations in the remaining variables; a derivative of a replaced one raises the
    inputs' order."""
    table = _stack(upper, 2 * size + width * len(forward))
    E = _columns(table, 0, size)
    A = -1 * (_columns(table, size, 2 * size))
    starts = [2 * size + k * width for k in range(len(forward))]
    B = [-1 * (_columns(table, start, start + width)) for start in starts]
    # x = back x' + sum of forward_k w^(k): A x adds to the inputs' orders as they are, E dx/dt to
    # those one higher.
    B = _added(B, [A * f for f in forward])
    derived = [-1 * (E * f) for f in forward]
    B = _added(B, [fmpq_mat(len(upper), width), *derived])
    while len(B) > 1 and B[-1] == fmpq_mat(len(upper), width):
        B.pop()
    return E * back, A * back, B


def _without_derivatives(
    system: _Descriptor,
    M: RationalMatrix,
    N: list[RationalMatrix],
    K: RationalMatrix,
    C: list[RationalMatrix],
    chosen: tuple[int, ...],
) -> StateSpace:
    """Return the state equation with z shifted, so that no derivative of an input but the motion
    drives it.

    From the highest k down z - N_k w^(k-1) takes the place of z. For the motion this is left
    undone: it would make large numbers that cancel where the equations are stiff.
    """
    # The inputs that are moved: a projection onto all but the hand's motion.
    count = len(system.inputs)
    moving = fmpq_mat(count, count)
    for i, channel in enumerate(system.inputs):
        moving[i, i] = fmpq(int(channel.name != MOTION))
    shifts = [fmpq_mat(M.nrows(), count) for _ in N]
    for k in range(len(N) - 1, 0, -1):
        top = N[k] * moving
        shifts[k - 1] += top
        N[k] -= top
        N[k - 1] += M * top
        # K times what was taken out of z acts on the signals at the order k - 1.
        lower_orders = [fmpq_mat(K.nrows(), count) for _ in range(k - 1)]
        C = _added(C, [*lower_orders, K * top])
    return StateSpace(
        inputs=system.inputs,
        columns=system.columns,
        M=M,
        N=tuple(N),
        K=K,
        C=tuple(C),
        chosen=chosen,
        shifts=tuple(shifts[:-1]),
    )


# Matrices of exact numbers


def _stack(rows: list[list[Any]], width: int) -> RationalMatrix:
    """The matrix with these rows; ``width`` columns also where there is no row."""
    entries = list(chain(*rows))
    return fmpq_mat(len(rows), width, entries)


def _columns(matrix: RationalMatrix, first: int, last: int) -> RationalMatrix:
    """The columns from one to before another."""
    rows = [row[first:last] for row in matrix.tolist()]
    return _stack(rows, last - first)


def _row(matrix: RationalMatrix, index: int) -> RationalMatrix:
    """One row, as a matrix of one."""
    entries = matrix.tolist()[index] if matrix.ncols() else []
    return fmpq_mat(1, matrix.ncols(), entries)


def _added(one: Sequence[RationalMatrix], other: Sequence[RationalMatrix]) -> list[RationalMatrix]:
    """Return the sums order by order; the shorter list counts as zero beyond its end."""
    longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
    sums = list(longer)
    for i, matrix in enumerate(shorter):
        sums[i] = sums[i] + matrix
    return sums


Reading = tuple[str, int]
"""A signal and how often it is differentiated."""
Drive = tuple[Input, int]
"""An input and how often it is differentiated."""


class DriveGroup(NamedTuple):
    """The inputs that are late by as many seconds: those of the hand's motion with their orders,
    and the others."""

    lag: float
    hand: list[int]
    orders: list[int]
    others: list[int]
    columns: list[int]
    """Where the others are in the record, if they are late."""


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
    """The rows of every variable of the equations, from which another system's state is taken."""
    back: Array = field(repr=False)
    """(state, drives): what is subtracted from the chosen variables to give the state."""

    @cached_property
    def columns(self) -> dict[Reading, int]:
        """The position of each reading among the rows."""
        return {reading: i for i, reading in enumerate(self.readings)}

    @cached_property
    def steady(self) -> dict[str, int]:
        """Where among the drives each signal is that elements set."""
        places = {}
        for i in self.propagator.steady:
            channel, order = self.drives[i]
            if order == 0:
                places[channel.name] = i
        return places

    @cached_property
    def groups(self) -> tuple[DriveGroup, ...]:
        """The inputs, grouped by their delay."""
        # Read from the record or from the motion once for each lag, not once for each input.
        groups: dict[float, DriveGroup] = {}
        for i, (x, order) in enumerate(self.drives):
            lag = int(x.lag.p) / int(x.lag.q)
            group = groups.setdefault(lag, DriveGroup(lag, [], [], [], []))
            if x.name == MOTION:
                group.hand.append(i)
                group.orders.append(order)
            else:
                group.others.append(i)
                if lag:
                    column = self.readings.index((x.name, order))
                    group.columns.append(column)
        return tuple(groups.values())

    def outputs(self, z: Array, w: Array) -> Array:
        """The readings, from states (..., state) and inputs (..., drives)."""
        n = self.exact.size
        by_state, by_drives = self.rows[:, :n], self.rows[:, n:]
        result: Array = z @ by_state.T + w @ by_drives.T
        return result

    def weight(self, row: Array, name: str, order: int) -> float:
        """Return the weight of a derivative of an undelayed input in a row of ``rows``."""
        of_drives = row[self.exact.size :]
        total = 0
        for weight, (x, k) in zip(of_drives, self.drives, strict=True):
            if x.name == name and k == order and x.lag == 0:
                total += weight
        return float(total)

    def poles(self) -> Any:
        """Return the eigenvalues of the state equation, 1/s, as if nothing came back through
        delay lines."""
        if not self.exact.size:
            return np.zeros(0, dtype=complex)
        return np.linalg.eigvals(self.propagator.M)


def linear_systems(
    net: Network, readings: Sequence[Reading]
) -> dict[frozenset[int], Linear | None]:
    """The state equation for each set of closed switches; None where it would stop the prescribed
    motion itself."""
    # All 2^n sets of n switches (at most 3): the exact reduction is slow and is never made in a
    # run.
    count = len(net.switches)
    exact = {}
    for bits in range(1 << count):
        closed = frozenset(i for i in range(count) if bits >> i & 1)
        exact[closed] = _exact(net, closed)
    present = [x for x in exact.values() if x is not None]
    wanted = _followed(present, net, readings)
    systems: dict[frozenset[int], Linear | None] = {}
    for closed, system in exact.items():
        systems[closed] = None if system is None else _floats(system, net, wanted)
    return systems


def _exact(net: Network, closed: frozenset[int]) -> StateSpace | None:
    """Return the state equation with these switches closed; None where they contradict each other
    or the prescribed motion."""
    switches = [net.switches[i] for i in closed]
    known = set(net.jumps) - {switch.target for switch in switches}
    equations = [*net.equations, *(switch.closed for switch in switches)]
    try:
        return state_space(equations, known)
    except SceneError:
        if not closed:
            raise
        return None


def _followed(
    systems: Sequence[StateSpace], net: Network, readings: Sequence[Reading]
) -> tuple[Reading, ...]:
    """Return all signals to record: the requested ones, and those of which delay lines need the
    past."""
    wanted = list(dict.fromkeys(readings))
    for reading in wanted:  # grows while it is walked
        # An advanced equation needs a higher derivative of its own delayed past in each round: the
        # list would never end.
        name, order = reading
        if order > HIGHEST_ORDER:
            element, *_ = name.split(".")
            raise SceneError(
                f"{element}: the scene needs ever higher derivatives of a delayed signal: "
                "it is not causal (an advanced equation)"
            )
        for system in systems:
            for channel, order_of_drive in _drives_of(system, reading, net):
                new = (channel.name, order_of_drive)
                is_recorded = channel.lag != 0 and channel.name != MOTION
                if is_recorded and new not in wanted:
                    wanted.append(new)
    return tuple(wanted)


def _is_set(system: StateSpace, name: str, net: Network) -> bool:
    """Whether an element sets a signal, so that it is an input and no variable of the equations."""
    return name in net.jumps and not any(name == variable for variable, _ in system.columns)


def _drives_of(system: StateSpace, reading: Reading, net: Network) -> list[Drive]:
    """The inputs of a signal and of the state equation, with the derivatives that act."""
    driving = [(x, k) for x in system.inputs for k in system.drives(x)]
    name, order = reading
    if _is_set(system, name, net):
        return driving
    row = system.signal(name, order)
    inputs = list(enumerate(system.inputs))
    direct = []
    for k, c in enumerate(row.inputs):
        direct += [(x, k) for i, x in inputs if c[0, i] != 0]
    # What shifts the state is needed to take it over from another system when a switch moves.
    back = []
    for k, c in enumerate(system.shifts):
        for i, x in inputs:
            if any(c[r, i] != 0 for r in range(c.nrows())):
                back.append((x, k))
    return [*driving, *direct, *back]


def _floats(system: StateSpace, net: Network, readings: tuple[Reading, ...]) -> Linear:
    """Return a system in floats: exact numbers are rounded here, once, after all that cancels has
    cancelled."""
    needed = [drive for reading in readings for drive in _drives_of(system, reading, net)]
    needed += [(x, 0) for x in system.inputs]
    drives = tuple(dict.fromkeys(needed))
    wanted = [_row_in_linear(system, reading, drives, net) for reading in readings]
    every = [_row_in_linear(system, key, drives, net) for key in system.columns]
    back = np.zeros((system.size, len(drives)))
    N = np.zeros((system.size, len(drives)))
    steady = []
    for i, (channel, k) in enumerate(drives):
        column = system.inputs.index(channel)
        if k < len(system.shifts):
            shift = system.shifts[k]
            back[:, i] = [float_of(shift[r, column]) for r in range(system.size)]
        if k < len(system.N):
            driven = system.N[k]
            N[:, i] = [float_of(driven[r, column]) for r in range(system.size)]
        if channel.lag == 0 and channel.name in net.jumps:
            steady.append(i)
    width = system.size + len(drives)
    return Linear(
        exact=system,
        drives=drives,
        readings=readings,
        propagator=Propagator(_array(system.M), N, tuple(steady)),
        rows=np.array(wanted).reshape(-1, width),
        everything=np.array(every).reshape(-1, width),
        back=back,
    )


def _row_in_linear(
    system: StateSpace, reading: Reading, drives: tuple[Drive, ...], net: Network
) -> list[float]:
    """The weights of the state and of the drives in a signal."""
    name, order = reading
    if _is_set(system, name, net):
        present = next(x for x in system.inputs if x.name == name and x.lag == 0)
        itself = (present, order)
        no_state = [0.0] * system.size
        return no_state + [float(drive == itself) for drive in drives]
    row = system.signal(name, order)
    weights = [float_of(row.state[0, i]) for i in range(system.size)]
    for x, k in drives:
        weight = fmpq(0)
        if k < len(row.inputs):
            weight = row.inputs[k][0, system.inputs.index(x)]
        weights.append(float_of(weight))
    return weights


def _array(matrix: RationalMatrix) -> Array:
    """A matrix of exact numbers in floats."""
    entries = [float_of(x) for row in matrix.tolist() for x in row]
    return np.array(entries).reshape(matrix.nrows(), matrix.ncols())
