"""Where no value of a parameter makes a display transparent: the one that comes nearest, what binds
there, and what is proven. Begin with ``nearest``.

A value comes nearer than another if thresholds that are a smaller multiple of the scene's would do
for it. For one value that multiple is the largest r/c on the band, exact; which value is tried is a
guess in floats, on a grid of frequencies, that proves nothing. Whether any value does with less is
the question itself, asked once more with larger thresholds: where the answer is empty, none does,
proven.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import inf, sqrt

from sympy import Expr, Rational, S

from haptisym.judge.bindings import Binding
from haptisym.judge.crossings import Criterion
from haptisym.judge.peaks import MaximumCandidate, maximum_candidates
from haptisym.kernel.arrays import np
from haptisym.kernel.budget import limited
from haptisym.kernel.errors import SceneError, UndecidedError
from haptisym.kernel.reals import ExactNumber, RealNumber, SquareRoot, rational, rational_between
from haptisym.kernel.rings import omega
from haptisym.kernel.sets import Domain
from haptisym.model.distortion import Distortion
from haptisym.model.parameters import values
from haptisym.model.scene import Knob, Scene
from haptisym.programs.values import Array, Compiled
from haptisym.verbs.require.freeparameter import allowed
from haptisym.verbs.require.solving import solve

# Frequencies and values of the grid, how often it is refined about its best value, and into how
# many values each time.
_FREQUENCIES, _VALUES, _ZOOMS, _EACH = 257, 241, 5, 17
# How far values without bound are looked for, to each side of a usual size.
_DECADES = 6
# By what share less near a value may come that is simpler, or less extreme.
_LEAVE = 0.002
# How far, relatively, simpler values are looked for: the simplest is tried first.
_SIMPLER = (0.1, 0.01, 1e-3, 1e-5)


@dataclass(frozen=True)
class ParameterQuestion:
    """What was asked about one parameter and holds for none of its values; all criteria hold a
    ratio against a number."""

    scene: Scene
    free: Knob
    domain: Domain
    criteria: Sequence[Criterion]

    def best(self) -> Iterator[Expr]:
        """Values at which the largest ratio over its threshold is about as small as anywhere; of
        many not an extreme one."""
        coarse = self._grid()
        worst = self.times(coarse)
        if not np.isfinite(worst).any():
            return
        value, times = self._least(coarse, worst)
        alike, own = coarse[worst <= times * (1 + _LEAVE)], float(self.free.value)
        if own in alike:
            yield self.free.value
        # Of values that come equally near the one closest to the present value; at an end of the
        # grid the least may lie beyond it, and there is no choice.
        elif len(alike) and value not in (coarse[0], coarse[-1]):
            value = float(
                alike[np.argmin(np.abs(alike - own) / (np.abs(alike) + abs(own) + 1e-300))]
            )
        yield from self._simple(value, times)

    def _least(self, grid: Array, worst: Array) -> tuple[float, float]:
        """Where the largest ratio is least, and how large it is there, on finer and finer grids.

        ``worst`` : the largest ratio at each value of the ``grid``; nan where there is no scene.
        """
        for _ in range(_ZOOMS):
            at = _least_at(worst)
            # The least value between two neighbours of the best one, if nothing is missed by the
            # grid before: a guess, whose quality is proven afterwards.
            low, high = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
            finer = np.linspace(low, high, _EACH)
            ratios = self.times(finer)
            if not np.nanmin(ratios, initial=np.inf) <= worst[at]:
                break
            grid, worst = finer, ratios
        at = _least_at(worst)
        return float(grid[at]), float(worst[at])

    def _simple(self, value: float, times: float) -> Iterator[Rational]:
        """The simplest rational number near a value at which the largest ratio is hardly larger;
        the value itself where there is none."""
        for width in _SIMPLER:
            reach = (ExactNumber(Rational(value + sign * width * abs(value))) for sign in (-1, 1))
            found = rational_between(*reach) if value else Rational(0)
            if self._holds(found) and self.times(np.array([float(found)]))[0] <= times * (
                1 + 2 * _LEAVE
            ):
                yield found
                return
        if self._holds(Rational(value)):
            yield Rational(value)

    def _holds(self, x: Expr) -> bool:
        """Whether a value belongs to what was asked about."""
        low, high = self.domain.low, self.domain.high
        above = low is None or bool(x > low) or (self.domain.holds_low and bool(x == low))
        return above and (
            high is None or bool(x < high) or (self.domain.holds_high and bool(x == high))
        )

    def times(self, t: Array) -> Array:
        """The largest ratio over its threshold at each of some values, over a grid of the band; nan
        where there is no scene."""
        if not self._exists_at_0 and (t == 0).any():
            found = np.full(t.shape, np.nan)
            found[t != 0] = self.times(t[t != 0])
            return found
        low, high = (float(x) for x in self.scene.band)
        omega = np.linspace(low, high, _FREQUENCIES)[:, None]
        with np.errstate(all="ignore"):
            # The parameter is none of the compiled ones where it does not matter.
            at = self._compiled(omega, **dict.fromkeys(self._compiled.parameters, t[None, :]))
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
        # By factors about a usual size, and also from either end of the domain: what is asked for
        # may be a small distance from it.
        tails = size * np.logspace(-_DECADES, _DECADES, _VALUES)
        start = low if low is not None else -float(tails[-1])
        end = high if high is not None else max(float(tails[-1]), 2 * start)
        listed = [
            np.linspace(start, end, _VALUES),
            tails,
            -tails,
            start + tails,
            end - tails,
            np.array([size]),
        ]
        found = np.unique(np.concatenate(listed))
        inside = found[(found >= start) & (found <= end)]
        first, last = (
            inside[0] == low and not self.domain.holds_low,
            inside[-1] == high and not self.domain.holds_high,
        )
        return inside[int(first) : len(inside) - int(last)]


# Who asked for values that hold needs to know about how far off all others are, not more.
_SECONDS = 5.0
# With ``times`` needed for the best value, the question is asked again with thresholds times**p
# larger: for p near 1 at first, and a smaller one where that stays open.
_CLOSE = (0.99, 0.9, 0.6)
_ROUNDS = 6


@dataclass(frozen=True)
class Nearest:
    """The value of the parameter that comes nearest, and by how much it fails.

    ``value``: SI. ``ratio``: the largest ratio at it, proven; ``binding``: of what, and where.
    ``times``: by how much the thresholds would have to be larger for this value; ``at_least``: by
    how much, at least, for any value asked about, proven.
    """

    value: Expr
    ratio: RealNumber
    binding: Binding
    times: float
    at_least: float = 1.0


def nearest(r: ParameterQuestion) -> Nearest | None:
    """The value that comes nearest where none will do, found in five seconds; None where none
    shows."""
    plain = all(
        x.region is None and not x.threshold.has(omega) and x.threshold != 0 for x in r.criteria
    )
    if r.free.parts or not plain:
        return None
    best: Nearest | None = None
    with suppress(UndecidedError), limited(_SECONDS):
        best = next(filter(None, (_at(r, value) for value in _tried(r))), None)
        for _ in range(_ROUNDS if best else 0):
            assert best is not None
            found = _bounded(r, best)
            if isinstance(found, float):
                return replace(best, at_least=found)
            better = None if found is None else _at(r, found)
            if better is None or better.times >= best.times:
                break
            best = better
    return best


def _tried(r: ParameterQuestion) -> Iterator[Expr]:
    """Values that may come nearest: as floats tell, and the scene's own."""
    yield from r.best()
    low, high, own = r.domain.low, r.domain.high, r.free.value
    if (low is None or bool(low < own)) and (high is None or bool(own < high)):
        yield own


def _bounded(r: ParameterQuestion, best: Nearest) -> float | Expr | None:
    """By how much every value fails at least, or a value that comes nearer than the best; None
    where neither shows."""
    for power in _CLOSE:
        # A simple rational number: thresholds stay exact, with few digits.
        times = _simple(best.times**power)
        if not 1 < float(times) < best.times:
            return 1.0
        larger = [replace(x, threshold=(x.threshold * times).expand()) for x in r.criteria]
        found = solve(r.scene, r.free, r.domain, larger)
        if found.feasible:
            first = found.feasible[0]
            return None if first.is_single else rational_between(first.low, first.high)
        # No value does with thresholds so much larger: down by more than a rounding, to stay
        # proven.
        if not found.undecided:
            return float(times) * (1 - 1e-15)
    return None


def _least_at(ratios: Array) -> int:
    """The index of the least finite ratio."""
    return int(np.argmin(np.where(np.isfinite(ratios), ratios, np.inf)))


def _simple(x: float) -> Rational:
    """A rational number near a float, with a denominator of at most 1000."""
    near = Fraction(x).limit_denominator(1000)
    return rational(near)


def _at(r: ParameterQuestion, value: Expr) -> Nearest | None:
    """How far a value is from doing; None where the scene does not exist at it, or a ratio has no
    bound."""
    try:
        scene = r.free.put(r.scene, value)
        d = scene.distortion()
    except SceneError:
        return None
    worst: tuple[float, Criterion, MaximumCandidate] | None = None
    for x in r.criteria:
        found = maximum_candidates(x.measure(d), *scene.band)
        if found is None:
            return None
        top = max(found, key=lambda top: float(top.value))
        times = sqrt(max(float(top.value), 0.0)) / float(x.threshold)
        if worst is None or times > worst[0]:
            worst = times, x, top
    if worst is None or worst[0] == inf:
        return None
    times, x, top = worst
    return Nearest(value, SquareRoot(top.value), Binding(x, top.omega, top.kind), times)
