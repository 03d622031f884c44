"""A plant in states: where a force that is held takes it, by matrix exponentials in balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import arb, arb_mat, fmpq

from haptisym.kernel.reals import Ball


def matrix(rows: list[list[Ball]], columns: int | None = None) -> Any:
    """A matrix, which may be of no size."""
    width = len(rows) if columns is None else columns
    return arb_mat(rows) if rows and width else arb_mat(len(rows), width)


@dataclass(frozen=True)
class States:
    """The companion form of a monic denominator Q(s), coefficients ascending, in balls.

    The i-th state is the i-th derivative times rate^(n - 1 - i): with entries of one size a matrix exponential, whose error is
    one for all of its entries, stays narrow where the numbers it is made of are.
    """

    Q: Sequence[Ball]

    @property
    def size(self) -> int:
        """How many states there are: the degree of Q."""
        return len(self.Q) - 1

    @cached_property
    def rate(self) -> Ball:
        """About how fast the plant is, 1/s."""
        n = self.size
        sizes = [float(abs(q).mid()) ** (1 / (n - i)) for i, q in enumerate(self.Q[:n])]
        return arb(max([*sizes, 1.0]))

    @cached_property
    def A(self) -> Any:
        """The companion matrix of Q, its states scaled by the rate."""
        n, rate = self.size, self.rate
        last = [-q / rate ** (n - 1 - j) for j, q in enumerate(self.Q[:n])]
        return matrix([[rate * int(j == i + 1) for j in range(n)] for i in range(n - 1)] + ([last] if n else []))

    def row(self, C: Sequence[Ball]) -> Any:
        """What reads c_0 y + c_1 y' + ... off the states."""
        n = self.size
        return matrix([[c / self.rate ** (n - 1 - j) for j, c in enumerate(C)]], n)

    def held(self, time: Ball) -> Any:
        """Where a unit force that is held for some time takes the plant from rest."""
        n, A = self.size, self.A
        rows = [[*(A[i, j] for j in range(n)), arb(int(i == n - 1))] for i in range(n)]
        moved = (matrix([*rows, [arb(0)] * (n + 1)]) * time).exp()
        return matrix([[moved[i, n]] for i in range(n)], 1)

    def integral(self, time: Ball) -> Any:
        """int_0^time exp(A t) dt."""
        n, A = self.size, self.A
        rows = [[*(A[i, j] for j in range(n)), *(self.rate * int(i == j) for j in range(n))] for i in range(n)]
        moved = (matrix([*rows, *([arb(0)] * (2 * n) for _ in range(n))]) * time).exp()
        return matrix([[moved[i, n + j] / self.rate for j in range(n)] for i in range(n)])


def opposite_response(states: States, C: Any, period: Ball) -> Ball | None:
    """What C reads, just before the force changes, of a force that changes its sign each period: at z = -1.

    C tanh(X)/A e, X = A T/2, is T/2 C e + T/2 C (tanh(X)/X - 1) e, by Taylor's series: where the plant is slow compared with the
    clock little of it is left, without a difference of what is nearly equal. None where the series is of no use.
    """
    n = states.size
    X = states.A * (period / 2)
    if not all(4 * sum((abs(X[i, j]) for j in range(n)), arb(0)) < arb.pi() for i in range(n)):
        return None
    column = matrix([[arb(int(i == n - 1))] for i in range(n)], 1)
    found = matrix([[arb(0)] for _ in range(n)], 1)
    for share in _TANH[1:]:
        column = X * (X * column)
        found += column * arb(share)
    left = (
        max((abs(column[i, 0]).upper() for i in range(n)), default=arb(0)) * (4 / arb.pi() ** 2) ** (len(_TANH) - 1) / 3
    )
    found += matrix([[arb(0, left)] for _ in range(n)], 1)
    direct = C[0, n - 1] if n else arb(0)
    return (direct + (C * found)[0, 0] if n else direct) * period / 2


def _tanh(count: int) -> list[fmpq]:
    """The coefficients of tanh(x)/x in x^2: tanh' = 1 - tanh^2."""
    row = [fmpq(1)]
    for k in range(1, count):
        row.append(-sum((row[i] * row[k - 1 - i] for i in range(k)), fmpq(0)) / (2 * k + 1))
    return row


_TANH = _tanh(16)
"""Each at most (4/pi^2)^k large: tanh(x)/x is the sum of 8/((2 j - 1)^2 pi^2 + 4 x^2)."""
