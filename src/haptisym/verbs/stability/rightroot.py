"""One root on the right for all values of an open number in an interval: enough to say that none of them is stable.

Newton's step in balls, over all these values at once, goes from a box into itself: so each of them has a root in it.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import isfinite

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


@dataclass(frozen=True)
class RightRoots:
    """Of a loop whose delays are numbers."""

    loop: Loop

    def everywhere(self, low: RealNumber | None, high: RealNumber | None, depth: int = _DEEPEST) -> bool:
        """Whether each value from one to another, with both, is proven to have a root in Re s > 0."""
        if low is None or high is None or self.loop.turns:
            return False
        if self._at_once(low, high):
            return True
        middle = ExactNumber(Rational((float(low) + float(high)) / 2))
        return bool(depth) and self.everywhere(low, middle, depth - 1) and self.everywhere(middle, high, depth - 1)

    def _at_once(self, low: RealNumber, high: RealNumber) -> bool:
        roots = sorted(set(self._guesses((float(low) + float(high)) / 2)), key=lambda s: -s.real)
        with flint.ctx.workprec(_BITS):
            q = low.ball(_BITS).union(high.ball(_BITS))
            return any(self._stays(s, s.real / part, q) for s in roots[:_TRIED] for part in (2, 8, 32))

    def _stays(self, s: complex, size: float, q: Ball) -> bool:
        box = acb(arb(s.real, size), arb(s.imag, size))
        slope = self._value(box, q)[1]
        if not box.real > 0 or slope.contains(0):
            return False
        after = acb(s.real, s.imag) - self._value(acb(s.real, s.imag), q)[0] / slope
        return bool(box.contains_interior(after))

    def _value(self, s: Ball, q: Ball) -> tuple[Ball, Ball]:
        """C and its derivative."""
        value, slope = acb(0), acb(0)
        for p, lag, row in self._balls:
            c = acb(0)
            for x in reversed(row):
                c = c * q + x
            term = c * s**p * (-s * lag).exp()
            value, slope = value + term, slope + term * (p / s - lag)
        return value, slope

    @cached_property
    def _balls(self) -> list[tuple[Ball, Ball, list[Ball]]]:
        """Of each term its power of s, its delay and its row."""
        with flint.ctx.workprec(_BITS):
            return [
                (expression_ball(p), expression_ball(lag_of(turns, self.loop)), [*map(expression_ball, row)])
                for p, group in self.loop.table.items()
                for turns, row in group.items()
            ]

    def _guesses(self, q: float) -> Iterator[complex]:
        """Where Newton's steps in floats end on the right, from starts along the axis."""
        terms = [(float(p), float(lag), sum(float(c) * q**i for i, c in enumerate(row))) for p, lag, row in self._balls]
        longest = max((lag for _, lag, _ in terms), default=0) or 1.0
        for i in range(_STARTS):
            found = _newton(terms, complex(0.05, 0.5 * (i + 1)) / longest)
            if found is not None and found.real * longest > 1e-9:
                yield complex(*(float(f"{x:.12g}") for x in (found.real, abs(found.imag))))


def _newton(terms: list[tuple[float, float, float]], s: complex) -> complex | None:
    try:
        for _ in range(_STEPS):
            each = [(p, lag, c * s**p * exp(-s * lag)) for p, lag, c in terms]
            slope = sum(x * (p / s - lag) for p, lag, x in each)
            step = sum(x for _, _, x in each) / slope
            s -= step
            if abs(step) < 1e-13 * abs(s):
                return s
    except (ZeroDivisionError, OverflowError):
        return None
    return s if isfinite(s.real) and abs(step) < 1e-9 * abs(s) else None
