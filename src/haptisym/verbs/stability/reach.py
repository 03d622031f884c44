"""How far out roots of a loop can meet the imaginary axis, for all values of its open number in an interval at once: in balls.

With one delayed product, A(s; q) + B(s; q) exp(-s tau), they do where |A|^2 - |B|^2, a polynomial in omega^2, vanishes: nowhere
beyond a frequency from which on its first terms outweigh all others, and so also where the first is lost but the second is
positive, as at the value at which a chain of roots comes to the axis from its left. With several, |L| has a least value
where all |exp(-s tau)| <= 1, and no root lies in Re s >= 0 from where the highest power of s, times that, outweighs all others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import acb, arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.reals import Ball, expression_ball
from haptisym.kernel.squares import Row, late_turns, squares
from haptisym.verbs.stability.loops import Loop

_BITS = 192
_STEP = Rational(5, 4)
_ARCS = 64


@dataclass(frozen=True)
class Reach(ABC):
    """Beyond which frequency no root meets the axis; ``longest``: the longest delay, s."""

    longest: Expr

    def radius(self, q: Ball, turning: int, *, inverse: bool) -> Rational | None:
        """For all values in a ball; None where delays turn further than that up to it. ``inverse``: for 1/q in the ball.

        Guaranteed where there is no chain of roots on the right, or on the axis but at the ends of the ball.
        """
        with flint.ctx.workprec(_BITS):
            weights = self._weights(q, inverse=inverse)
            if weights is None:
                return None
            last = Rational(turning) / Rational(str(float(self.longest)))
            at = last / 1024
            while at <= last:
                if self._prevails(expression_ball(at), weights):
                    return at
                at *= _STEP
        return None

    @abstractmethod
    def _weights(self, q: Ball, *, inverse: bool) -> Any:
        """What does not depend on the frequency; None where it proves nothing."""

    @abstractmethod
    def _prevails(self, at: Ball, weights: Any) -> bool:
        """Whether no root meets the axis there and beyond."""


def reach_of(loop: Loop) -> Reach:
    """The bound for a loop, by the sharper way where it goes."""
    turns = {x for group in loop.table.values() for x in group if any(x)}
    longest = max((lag_of(x, loop) for x in turns), default=Integer(1))
    late = late_turns(turns, [*loop.table])
    if late is not None and any(not any(x) for x in loop.leading):
        return _Squares(longest, squares(loop.table, late))
    return _sums(loop, turns, longest)


def reach_of_axis(loop: Loop) -> Reach:
    """The bound for roots on the axis itself, guaranteed whether or not there is a chain on the right."""
    turns = {x for group in loop.table.values() for x in group if any(x)}
    return _sums(loop, turns, max((lag_of(x, loop) for x in turns), default=Integer(1)))


def _sums(loop: Loop, turns: set[tuple[int, ...]], longest: Expr) -> Reach:
    units = {i for x in turns for i, n in enumerate(x) if n}
    return _Sums(longest, loop.table, units.pop() if len(units) == 1 else None)


def lag_of(turns: Sequence[int], loop: Loop) -> Expr:
    """How late a product of unit delays is, s."""
    return sum((n * x for n, x in zip(turns, loop.ring.lags, strict=True)), Integer(0))


def _value(row: Row, q: Ball, *, inverse: bool) -> Ball:
    """Of a polynomial in the open number; ``inverse``: times q^-n, n being the length of all rows less 1, at 1/q."""
    total = arb(0)
    for c in row if inverse else reversed(row):
        total = total * q + expression_ball(c)
    return total


@dataclass(frozen=True)
class _Squares(Reach):
    """``rows`` : of |A|^2 - |B|^2 by falling powers of omega^2."""

    rows: Sequence[Row]

    def _weights(self, q: Ball, *, inverse: bool) -> Sequence[Ball]:
        """Lower bounds of the coefficients; the first is not negative where no chain lies on the right."""
        first, *others = (_value(row, q, inverse=inverse).lower() for row in self.rows)
        return [first.max(arb(0)), *others[:1], *(x.min(arb(0)) for x in others[1:])]

    def _prevails(self, at: Ball, weights: Sequence[Ball]) -> bool:
        total = weights[0] * at**2
        for i, weight in enumerate(weights[1:]):
            total += weight / at ** (2 * i)
        return bool(total > 0)


@dataclass(frozen=True)
class _Sums(Reach):
    """``table`` : as that of the loop. ``unit`` : the one unit delay, where there is one."""

    table: Mapping[Rational, Mapping[tuple[int, ...], Row]]
    unit: int | None

    def _weights(self, q: Ball, *, inverse: bool) -> Mapping[Rational, Ball] | None:
        """The least |L|, and of the lower powers how much they may be, negative, by how much lower they are."""
        degree = max(self.table)
        leading = {turns: _value(row, q, inverse=inverse) for turns, row in self.table[degree].items()}
        floor = self._floor(leading)
        if floor is None:
            return None
        found = {Integer(0): floor}
        for p, group in self.table.items():
            if p < degree:
                found[p - degree] = -sum(
                    (abs(_value(row, q, inverse=inverse)).upper() for row in group.values()), arb(0)
                )
        return found

    def _floor(self, leading: Mapping[tuple[int, ...], Ball]) -> Ball | None:
        own = next((x for turns, x in leading.items() if not any(turns)), arb(0))
        margin = abs(own).lower() - sum((abs(x).upper() for turns, x in leading.items() if any(turns)), arb(0))
        if margin > 0:
            return margin.lower()
        return None if self.unit is None else _least_on_circle({t[self.unit]: x for t, x in leading.items()})

    def _prevails(self, at: Ball, weights: Mapping[Rational, Ball]) -> bool:
        return bool(sum((x * at ** expression_ball(p) for p, x in weights.items()), arb(0)) > 0)


def _least_on_circle(leading: Mapping[int, Ball]) -> Ball | None:
    """Of |L(z)| for |z| = 1, and so for |z| <= 1, as it has no zero there."""
    least = None
    for i in range(_ARCS):
        angle = arb(i, 0) / _ARCS + arb(0, 0.5 / _ARCS)
        z = (acb(0, 2) * arb.pi() * angle).exp()
        here = abs(sum((x * z**n for n, x in leading.items()), acb(0))).lower()
        least = here if least is None else least.min(here)
    return least if least is not None and least > 0 else None
