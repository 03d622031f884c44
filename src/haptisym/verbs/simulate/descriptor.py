"""From equations of motion to an ordinary state equation, exactly.

The equations of a network are a descriptor system E x' = A x + B w, in which masses beside masses, rigid connections and
prescribed motions make E singular (differential-algebraic, of any index). Each round of ``_reduced`` takes the algebraic
equations, solves them for as many variables and puts these back, over the rational numbers, so that no rank is ever
guessed. What remains is

    z' = M z + N_0 w + N_1 dw/dt + ...,    any signal = K z + C_0 w + C_1 dw/dt + C_2 d2w/dt2 + ...

where w are the inputs: the hand's motion, delayed signals and what clocks and switches set. Only the hand's motion, which is
known with all its derivatives, keeps an N of higher order.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from flint import fmpq, fmpq_mat

from haptisym.kernel.errors import SceneError
from haptisym.verbs.simulate.network import MOTION, Exact, SignalSum

RationalMatrix: TypeAlias = Any  # flint.fmpq_mat, which ships no types

HIGHEST_ORDER = 12
"""Of derivatives of an input: beyond it equations lead around a loop of pure derivatives."""


class Input(NamedTuple):
    """Something that drives the equations: a signal that is known at any time, and by how much it is late."""

    name: str
    lag: Exact


class SignalRow(NamedTuple):
    """A signal in terms of the state and of the inputs' derivatives, order by order."""

    state: RationalMatrix
    inputs: tuple[RationalMatrix, ...]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """z' = M z + N_0 w + N_1 dw/dt + ..., with every variable of the equations as K z + C_0 w + C_1 dw/dt + ...

    ``chosen`` and ``shifts`` lead back: z is the chosen variables minus the sum of R_k times the k-th derivative of w.
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
        """A signal, differentiated that many times."""
        known = max((k for n, k in self.columns if n == name), default=-1)
        column = self.columns[name, min(order, known)]
        row = SignalRow(_row(self.K, column), tuple(_row(c, column) for c in self.C))
        for _ in range(order - known):
            row = self._differentiated(row)
        return row

    def _differentiated(self, row: SignalRow) -> SignalRow:
        moved = [row.state * n for n in self.N]
        return SignalRow(row.state * self.M, tuple(_added(moved, [0 * moved[0], *row.inputs])))

    def reach(self, name: str, order: int, channel: Input) -> int | None:
        """The highest derivative of an input in a signal; -1 if it acts through the state alone, None if not at all."""
        row, index = self.signal(name, order), self.inputs.index(channel)
        direct = [k for k, c in enumerate(row.inputs) if c[0, index] != 0]
        if direct:
            return max(direct)
        for n in self.N:
            moved = fmpq_mat(self.size, 1, [n[i, index] for i in range(self.size)])
            for _ in range(self.size):
                if (row.state * moved)[0, 0] != 0:
                    return -1
                moved = self.M * moved
        return None

    def drives(self, channel: Input) -> list[int]:
        """The orders of an input's derivatives that the state equation holds."""
        index = self.inputs.index(channel)
        return [k for k, n in enumerate(self.N) if any(n[i, index] != 0 for i in range(self.size))]

    @cached_property
    def size(self) -> int:
        """How many unknowns it has."""
        return int(self.M.nrows())


def state_space(equations: Sequence[SignalSum], known: Iterable[str] = ()) -> StateSpace:
    """The state equation of as many equations of motion as there are unknown signals.

    ``known``: signals that are inputs beside the motion and everything late. Raises SceneError where the equations contradict
    each other or leave a signal open.

    >>> x, f, u = SignalSum.of("x"), SignalSum.of("f"), SignalSum.of("motion")
    >>> system = state_space([f - 2 * x.d(2) - 3 * x, x - u])       # a mass and a spring, moved by hand: no state at all
    >>> system.size, [str(c[0, 0]) for c in system.signal("f").inputs]
    (0, ['3', '0', '2'])
    """
    known = tuple(known)
    fixed = {MOTION, *known}
    keys = [(key, value) for equation in equations for key, value in equation.terms.items()]
    present = [Input(n, lag) for (n, _, lag), _ in keys if n in fixed or lag != 0]
    inputs = tuple(dict.fromkeys([*present, *(Input(n, fmpq(0)) for n in known)]))
    orders: dict[str, int] = {}
    if any(lag < 0 for (_, _, lag), _ in keys):
        raise SceneError("a negative delay cannot be simulated: it needs signals before they are there")
    for (name, order, lag), _ in keys:
        if name not in fixed:
            orders[name] = max(orders.get(name, 0), order if lag == 0 else 0)
    return _reduced(_Descriptor.of(equations, inputs, orders))


@dataclass(frozen=True, eq=False)
class _Descriptor:
    """E x' = A x + B_0 w + B_1 dw/dt + ...: the rows of the matrices."""

    inputs: tuple[Input, ...]
    columns: dict[tuple[str, int], int]
    E: RationalMatrix
    A: RationalMatrix
    B: tuple[RationalMatrix, ...]

    @classmethod
    def of(cls, equations: Sequence[SignalSum], inputs: tuple[Input, ...], orders: dict[str, int]) -> _Descriptor:
        # algebraic variables first: they are the ones that algebraic equations are solved for
        ordered = sorted(orders, key=lambda name: orders[name] > 0)
        listed = [(name, k) for name in ordered for k in range(max(orders[name], 1))]
        columns = {key: i for i, key in enumerate(listed)}
        chains = [key for key in listed if key[1] + 1 < orders[key[0]]]
        size, rows = len(columns), len(equations) + len(chains)
        depth = 1 + max((k for e in equations for n, k, lag in e.terms if Input(n, lag) in inputs), default=0)
        E, A = fmpq_mat(rows, size), fmpq_mat(rows, size)
        B = tuple(fmpq_mat(rows, len(inputs)) for _ in range(depth))
        for i, equation in enumerate(equations):
            for (name, order, lag), value in equation.terms.items():
                if Input(name, lag) in inputs:
                    B[order][i, inputs.index(Input(name, lag))] -= value
                elif order and order == orders[name]:
                    E[i, columns[name, order - 1]] += value
                else:
                    A[i, columns[name, order]] -= value
        for i, (name, order) in enumerate(chains, len(equations)):
            E[i, columns[name, order]], A[i, columns[name, order + 1]] = fmpq(1), fmpq(1)
        return cls(inputs, columns, E, A, B)


def _reduced(system: _Descriptor) -> StateSpace:
    E, A, B = system.E, system.A, list(system.B)
    size, width = E.ncols(), len(system.inputs)
    if E.nrows() != size:
        raise SceneError(
            f"the effects give {E.nrows()} equations for {size} unknowns: they do not determine the motion"
        )
    chosen = list(range(size))
    K, C = _identity(size), [fmpq_mat(size, width)]
    while True:
        upper, lower = _row_reduced(E, A, B)
        if not lower:
            break
        if len(B) > HIGHEST_ORDER * 2:
            raise SceneError("the effects lead around a loop of pure derivatives")
        pivots, back, forward = _solved(lower, E.ncols(), len(B), width)
        keep = [i for i in range(E.ncols()) if i not in pivots]
        E, A, B = _substituted(upper, E.ncols(), width, back, forward)
        K, C = K * back, _added(C, [K * f for f in forward])
        chosen = [chosen[i] for i in keep]
    rows = _stack(upper, len(chosen) * 2 + width * len(B))
    M = _negative(_columns(rows, len(chosen), 2 * len(chosen)))
    N = [
        _negative(_columns(rows, 2 * len(chosen) + k * width, 2 * len(chosen) + (k + 1) * width)) for k in range(len(B))
    ]
    return _without_derivatives(system, M, N, K, C, tuple(chosen))


def _row_reduced(
    E: RationalMatrix, A: RationalMatrix, B: Sequence[RationalMatrix]
) -> tuple[list[list[Any]], list[list[Any]]]:
    """The rows of [E | -A | -B] in echelon form: those with a derivative, and those without."""
    table = _beside([E, -1 * A, *(-1 * b for b in B)])
    form, _ = table.rref()
    rows = [row for row in form.tolist() if any(x != 0 for x in row)]
    size = E.ncols()
    lower = [row for row in rows if all(x == 0 for x in row[:size])]
    if any(all(x == 0 for x in row[: 2 * size]) for row in lower) or len(rows) < size:
        raise SceneError("the effects contradict each other or leave a signal open: the motion is not determined")
    return rows[: len(rows) - len(lower)], lower


def _solved(
    lower: list[list[Any]], size: int, depth: int, width: int
) -> tuple[list[int], RationalMatrix, list[RationalMatrix]]:
    """The pivot variables of algebraic equations, and all variables in terms of the others and of the inputs."""
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
    upper: list[list[Any]], size: int, width: int, back: RationalMatrix, forward: list[RationalMatrix]
) -> tuple[RationalMatrix, RationalMatrix, list[RationalMatrix]]:
    """The remaining equations in the remaining variables; a derivative of a replaced one raises the inputs' order."""
    table = _stack(upper, 2 * size + width * len(forward))
    E, A = _columns(table, 0, size), _negative(_columns(table, size, 2 * size))
    B = [_negative(_columns(table, 2 * size + k * width, 2 * size + (k + 1) * width)) for k in range(len(forward))]
    B = _added(B, [A * f for f in forward])
    B = _added(B, [fmpq_mat(len(upper), width), *(-1 * (E * f) for f in forward)])
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
    """The same with z moved, so that of all inputs but the motion no derivative drives it.

    From the highest k down z - N_k w^(k-1) takes the place of z. For the motion this is left undone: it would make large numbers
    that cancel where the equations are stiff.
    """
    moving = fmpq_mat(len(system.inputs), len(system.inputs))
    for i, channel in enumerate(system.inputs):
        moving[i, i] = fmpq(int(channel.name != MOTION))
    shifts = [fmpq_mat(M.nrows(), len(system.inputs)) for _ in N]
    for k in range(len(N) - 1, 0, -1):
        top = N[k] * moving
        shifts[k - 1] += top
        N[k] -= top
        N[k - 1] += M * top
        C = _added(C, [*(fmpq_mat(K.nrows(), len(system.inputs)) for _ in range(k - 1)), K * top])
    return StateSpace(system.inputs, system.columns, M, tuple(N), K, tuple(C), chosen, tuple(shifts[:-1]))


# Matrices of exact numbers


def _identity(size: int) -> RationalMatrix:
    return fmpq_mat(size, size, [fmpq(int(i == k)) for i in range(size) for k in range(size)])


def _negative(matrix: RationalMatrix) -> RationalMatrix:
    return -1 * matrix


def _stack(rows: list[list[Any]], width: int) -> RationalMatrix:
    return fmpq_mat(len(rows), width, [x for row in rows for x in row])


def _beside(parts: Sequence[RationalMatrix]) -> RationalMatrix:
    rows = zip(*(part.tolist() for part in parts), strict=True)
    return _stack([[x for piece in row for x in piece] for row in rows], sum(part.ncols() for part in parts))


def _columns(matrix: RationalMatrix, first: int, last: int) -> RationalMatrix:
    return _stack([row[first:last] for row in matrix.tolist()], last - first)


def _row(matrix: RationalMatrix, index: int) -> RationalMatrix:
    return fmpq_mat(1, matrix.ncols(), matrix.tolist()[index] if matrix.ncols() else [])


def _added(one: Sequence[RationalMatrix], other: Sequence[RationalMatrix]) -> list[RationalMatrix]:
    """Sums order by order; the shorter list counts as zero beyond its end."""
    longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
    return [a + shorter[i] if i < len(shorter) else a for i, a in enumerate(longer)]
