"""A plant in states: where a force that is held takes it, by matrix exponentials in balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from math import frexp
from operator import mul
from typing import Any

import flint
from flint import arb, arb_mat, fmpq

from haptisym.kernel.jets import Value, joined, like, parts, value
from haptisym.kernel.reals import Ball

_MOST_DOUBLINGS = 64


def matrix(rows: list[list[Value]], columns: int | None = None) -> Any:
    """A matrix, which may be of no size."""
    width = len(rows) if columns is None else columns
    if not rows or not width:
        return arb_mat(len(rows), width)
    return joined(lambda entries: arb_mat(len(rows), width, entries), [x for row in rows for x in row])


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
        sizes = [float(abs(value(q)).mid()) ** (1 / (n - i)) for i, q in enumerate(self.Q[:n])]
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

    def held(self, time: Value) -> Any:
        """Where a unit force that is held for some time takes the plant from rest."""
        return column(self.integral(time), self.size - 1)

    def moved(self, time: Value) -> Any:
        """exp(A time)."""
        return self._one + self.A * self.integral(time)

    def integral(self, time: Value) -> Any:
        """int_0^time exp(A t) dt = time S(A time), S(X) = 1 + X/2! + X^2/3! + ...: by its series of a small X, which is doubled.

        As S(2 X) = S(X) + X S(X)^2/2, nothing is taken off what is nearly equal to it.
        """
        X, total = self.A * time, self._one
        doublings = max(0, frexp(float(norm(X).upper()))[1] + 2)  # then |X| <= 1/4
        if doublings > _MOST_DOUBLINGS:
            return total * arb("nan")
        X, rest, k = X * arb(2) ** -doublings, arb(1), 1
        while rest > arb(2) ** -(flint.ctx.prec + 8):
            k, rest = k + 1, rest / (4 * (k + 1))  # 4^(1 - k)/k!, more than the terms from X^k/(k + 1)! on
        for n in range(k, 1, -1):
            total = self._one + X * total * (arb(1) / n)
        last = reduce(mul, [X] * self.size, self._one)
        if not norm(last).is_zero():  # of masses alone nothing is left out, as no higher power is there
            total = widened(total, rest)
        for _ in range(doublings):
            total, X = total + X * total * total * arb(0.5), X * 2
        return total * time

    @cached_property
    def _one(self) -> Any:
        return matrix([[arb(int(i == j)) for j in range(self.size)] for i in range(self.size)])


def column(M: Any, j: int) -> Any:
    """Of a matrix, as one."""
    return matrix([[M[i, j]] for i in range(M.nrows())], 1)


def norm(X: Any) -> Ball:
    """The largest sum of sizes in a row; of a jet that of all its coefficients: the norm of a block matrix that stands for it."""
    n = X.nrows()
    return max(
        (sum((abs(x).upper() for j in range(n) for x in parts(X[i, j])), arb(0)) for i in range(n)), default=arb(0)
    )


def widened(M: Any, radius: Ball) -> Any:
    """With so much more in each entry, and each of its Taylor coefficients."""
    own, columns = arb(0, radius.upper()), range(M.ncols())
    rows = [[like(M[i, j], [own for _ in parts(M[i, j])]) for j in columns] for i in range(M.nrows())]
    return M + matrix(rows, len(columns))


def opposite_response(states: States, C: Any, period: Ball) -> Ball | None:
    """What C reads, just before the force changes, of a force that changes its sign each period: at z = -1.

    C tanh(X)/A e, X = A T/2, is T/2 C e + T/2 C (tanh(X)/X - 1) e, by Taylor's series: where the plant is slow compared with the
    clock little of it is left, without a difference of what is nearly equal. None where the series is of no use.
    """
    n = states.size
    X = states.A * (period / 2)
    if not 4 * norm(X) < arb.pi():
        return None
    column = matrix([[arb(int(i == n - 1))] for i in range(n)], 1)
    found = matrix([[arb(0)] for _ in range(n)], 1)
    for share in _TANH[1:]:
        column = X * (X * column)
        found += column * arb(share)
    most = max((abs(x).upper() for i in range(n) for x in parts(column[i, 0])), default=arb(0))
    found = widened(found, most * (4 / arb.pi() ** 2) ** (len(_TANH) - 1) / 3)
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
