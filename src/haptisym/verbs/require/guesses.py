"""Which value of a parameter comes nearest to what is asked: a guess in floats, on a grid of frequencies. It proves nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from sympy import Expr, Rational, S

from haptisym.judge.criteria import Criterion
from haptisym.kernel.reals import ExactNumber, rational_between
from haptisym.model.distortion import Distortion
from haptisym.model.knobs import Knob
from haptisym.model.parameters import values
from haptisym.model.scene import Scene
from haptisym.programs.values import Array, Compiled
from haptisym.verbs.require.existing import allowed
from haptisym.verbs.require.freeparameter import Domain

_FREQUENCIES, _VALUES, _ZOOMS, _EACH = 257, 241, 5, 17
_DECADES = 6
"""To each side of a usual size: how far values without bound are looked for."""
_LEAVE = 0.002
"""By how much less near a value may come that is simpler, or less extreme."""
_SIMPLER = (0.1, 0.01, 1e-3, 1e-5)
"""How far, relatively, simpler values are looked for."""


@dataclass(frozen=True)
class Guesses:
    """A question about one parameter; criteria that are about ratios, held against numbers."""

    scene: Scene
    free: Knob
    domain: Domain
    criteria: Sequence[Criterion]

    def best(self) -> Iterator[Expr]:
        """Values at which the largest ratio over its threshold is about as small as anywhere; of many not an extreme one."""
        coarse = self._grid()
        worst = self.times(coarse)
        if not np.isfinite(worst).any():
            return
        value, times = self._least(coarse, worst)
        alike, own = coarse[worst <= times * (1 + _LEAVE)], float(self.free.value)
        if own in alike:
            yield self.free.value
        elif len(alike) and value not in (coarse[0], coarse[-1]):
            value = float(alike[np.argmin(np.abs(alike - own) / (np.abs(alike) + abs(own) + 1e-300))])
        yield from self._simple(value, times)

    def _least(self, grid: Array, worst: Array) -> tuple[float, float]:
        """Where the largest ratio is least, and how large it is there, on finer and finer grids."""
        for _ in range(_ZOOMS):
            at = int(np.argmin(np.where(np.isfinite(worst), worst, np.inf)))
            finer = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], _EACH)
            own = self.times(finer)
            if not np.nanmin(own, initial=np.inf) <= worst[at]:
                break
            grid, worst = finer, own
        at = int(np.argmin(np.where(np.isfinite(worst), worst, np.inf)))
        return float(grid[at]), float(worst[at])

    def _simple(self, value: float, times: float) -> Iterator[Rational]:
        for width in _SIMPLER:
            reach = (ExactNumber(Rational(value + sign * width * abs(value))) for sign in (-1, 1))
            found = rational_between(*reach) if value else Rational(0)
            if self._holds(found) and self.times(np.array([float(found)]))[0] <= times * (1 + 2 * _LEAVE):
                yield found
                return
        if self._holds(Rational(value)):
            yield Rational(value)

    def _holds(self, x: Expr) -> bool:
        low, high = self.domain.low, self.domain.high
        above = low is None or bool(x > low) or (self.domain.holds_low and bool(x == low))
        return above and (high is None or bool(x < high) or (self.domain.holds_high and bool(x == high)))

    def times(self, t: Array) -> Array:
        """The largest ratio over its threshold at each of some values, over a grid of the band; nan where there is no scene."""
        if not self._exists_at_0 and (t == 0).any():
            found = np.full(t.shape, np.nan)
            found[t != 0] = self.times(t[t != 0])
            return found
        low, high = (float(x) for x in self.scene.band)
        omega = np.linspace(low, high, _FREQUENCIES)[:, None]
        with np.errstate(all="ignore"):
            at = self._compiled(
                omega, **dict.fromkeys(self._compiled.parameters, t[None, :])
            )  # none where it does not matter
            listed = [x.sampled(at) / float(x.threshold) for x in self.criteria if x.sampled]
        worst = np.fmax.reduce([np.fmax.reduce(x, axis=0) for x in listed], axis=0)
        return np.asarray(np.broadcast_to(worst, t.shape))

    @cached_property
    def _exists_at_0(self) -> bool:
        return allowed(self.scene, self.free, S.Zero)

    @cached_property
    def _compiled(self) -> Compiled:
        known = {x: v for x, v in values(self.scene.parameters).items() if x != self.free.symbol}
        return Distortion.of(self.scene.chain.at(known)).compile()

    def _grid(self) -> Array:
        """Values all over the domain: at equal steps, and at equal steps of their logarithms."""
        low, high = (None if x is None else float(x) for x in (self.domain.low, self.domain.high))
        size = abs(float(self.free.value)) or 1.0
        tails = size * np.logspace(-_DECADES, _DECADES, _VALUES)
        start = low if low is not None else -float(tails[-1])
        end = high if high is not None else max(float(tails[-1]), 2 * start)
        listed = [np.linspace(start, end, _VALUES), tails, -tails, start + tails, end - tails, np.array([size])]
        found = np.unique(np.concatenate(listed))
        inside = found[(found >= start) & (found <= end)]
        first, last = inside[0] == low and not self.domain.holds_low, inside[-1] == high and not self.domain.holds_high
        return inside[int(first) : len(inside) - int(last)]
