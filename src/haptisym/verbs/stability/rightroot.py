"""One root on the right for all values of an open number in an interval: enough to say that none of them is stable.

Newton's step in balls, over all these values at once, goes from a box into itself: so each of them has a root in it.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import copysign, isfinite, sqrt

import flint
from flint import acb, arb
from sympy import Rational

from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.verbs.stability.loops import Loop
from haptisym.verbs.stability.reach import lag_of

_BITS = 192
_STARTS = 120
_STEPS = 40
_TRIED = 6  # roots, those that lie farthest to the right
_DEEPEST = 5
_FURTHER = 16  # where values without an end are parted


@dataclass(frozen=True)
class _Values:
    """Those of the open number from one to another, in a ball; those without an end have their inverse there."""

    low: RealNumber | None
    high: RealNumber | None
    ball: Ball

    @classmethod
    def of(cls, low: RealNumber | None, high: RealNumber | None) -> _Values | None:
        """None where the end that there is does not keep 0 out."""
        with flint.ctx.workprec(_BITS):
            if low is not None and high is not None:
                return cls(low, high, low.ball(_BITS).union(high.ball(_BITS)))
            end = low if low is not None else high
            if end is None or not end.ball(_BITS) * (1 if low is not None else -1) > 0:
                return None
            return cls(low, high, (1 / end.ball(_BITS)).union(arb(0)))

    @property
    def middle(self) -> Rational:
        """Between both, as many times the lesser as it goes into the larger; without an end some times as far out."""
        ends = [float(x) for x in (self.low, self.high) if x is not None]
        if len(ends) == 1:
            return Rational(ends[0]) * _FURTHER
        low, high = ends
        between = copysign(sqrt(low * high), low) if low * high > 0 else (low + high) / 2
        return Rational(between if low < between < high else (low + high) / 2)

    def of_row(self, row: Sequence[Ball], at: Ball) -> Ball:
        """A polynomial in the open number at a number of the ball."""
        total = 0 * at
        for c in row if self.low is None or self.high is None else reversed(row):
            total = total * at + c
        return total


@dataclass(frozen=True)
class RightRoots:
    """Of a loop whose delays are numbers."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None, depth: int = _DEEPEST) -> bool:
        """Whether each value between two, and these, is proven to have a root in Re s > 0; None is no end."""
        if self.loop.turns or (values := _Values.of(low, high)) is None:
            return False
        if self._at_once(values):
            return True
        middle = ExactNumber(values.middle)
        return bool(depth) and self.everywhere(low, middle, depth - 1) and self.everywhere(middle, high, depth - 1)

    def _at_once(self, values: _Values) -> bool:
        roots = sorted(set(self._guesses(values)), key=lambda s: -s.real)
        with flint.ctx.workprec(_BITS):
            return any(self._stays(s, s.real / part, values) for s in roots[:_TRIED] for part in (2, 8, 32))

    def _stays(self, s: complex, size: float, values: _Values) -> bool:
        box = acb(arb(s.real, size), arb(s.imag, size))
        slope = self._value(box, values)[1]
        if not box.real > 0 or slope.contains(0):
            return False
        after = acb(s.real, s.imag) - self._value(acb(s.real, s.imag), values)[0] / slope
        return bool(box.contains_interior(after))

    def _value(self, s: Ball, values: _Values) -> tuple[Ball, Ball]:
        """C and its derivative, over the highest power of the open number where the values have no end."""
        length = len(self._balls[0][2])
        value, slope = [acb(0)] * length, [acb(0)] * length
        for p, lag, row in self._balls:
            wave = (-s * lag).exp()
            here = s**p * wave
            along = (p * s ** (p - 1) * wave if p else 0) - lag * here
            value = [x + c * here for x, c in zip(value, row, strict=True)]
            slope = [x + c * along for x, c in zip(slope, row, strict=True)]
        return values.of_row(value, values.ball), values.of_row(slope, values.ball)

    @cached_property
    def _balls(self) -> list[tuple[Ball, Ball, list[Ball]]]:
        """Of each term its power of s, its delay and its row; all rows are of one length."""
        longest = max(len(row) for group in self.loop.table.values() for row in group.values())
        with flint.ctx.workprec(_BITS):
            return [
                (
                    expression_ball(p),
                    expression_ball(lag_of(turns, self.loop)),
                    [*map(expression_ball, row)] + [arb(0)] * (longest - len(row)),
                )
                for p, group in self.loop.table.items()
                for turns, row in group.items()
            ]

    def _guesses(self, values: _Values) -> Iterator[complex]:
        """Where Newton's steps in floats end on the right, from starts along the axis."""
        middle = float(values.ball.mid())
        terms = [
            (float(p), float(lag), float(values.of_row([*map(float, row)], middle))) for p, lag, row in self._balls
        ]
        longest = max((lag for _, lag, _ in terms), default=0) or 1.0
        for i in range(_STARTS):
            found = _newton(terms, complex(0.05, 0.5 * (i + 1)) / longest)
            if found is not None and found.real * longest > 1e-9:
                yield complex(*(float(f"{x:.12g}") for x in (found.real, abs(found.imag))))


def _newton(terms: list[tuple[float, float, float]], s: complex) -> complex | None:
    try:
        for _ in range(_STEPS):
            each = [(p, lag, c * s**p * exp(-s * lag)) for p, lag, c in terms if c]
            slope = sum(x * (p / s - lag) for p, lag, x in each)
            step = sum(x for _, _, x in each) / slope
            s -= step
            if abs(step) < 1e-13 * abs(s):
                return s
    except (ZeroDivisionError, OverflowError):
        return None
    return s if isfinite(s.real) and abs(step) < 1e-9 * abs(s) else None
