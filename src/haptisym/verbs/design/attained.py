"""Bandwidths that are attained: many sets of values in floats, the best of them exactly, with what must be kept.

Floats only propose: those of a sweep, and where these take long or decide nothing what the one search shows at single
points. What is called attained was evaluated exactly at rational values, and what must be kept was decided there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from operator import mul

import numpy as np
from sympy import Expr, Integer, Rational

from haptisym.judge.crossings import noticed
from haptisym.judge.evaluation import Evaluation, evaluate
from haptisym.judge.excess import Side
from haptisym.judge.passivity import passivity
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import HaptisymError, LimitError
from haptisym.kernel.rings import s
from haptisym.kernel.where import Judge
from haptisym.model.jnd import Part
from haptisym.model.scene import Knob, Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.design.bound import DesignBox, at_points
from haptisym.verbs.sweep.passes import Kernel

PASSIVE, STABLE, STEADY = "passive", "stable", "steady"
KEPT = (PASSIVE, STABLE, STEADY)
_POINTS = {1: 40, 2: 160, 3: 400}
"""Sets of values to begin with, for so many parameters."""
_ROUNDS, _ROUND, _CLOSER = {1: 12, 2: 24, 3: 24}, {1: 16, 2: 40, 3: 80}, {1: 0.25, 2: 0.5, 3: 0.5}
"""Times that the search closes in on the best, sets of values each time, and to which share of the box before."""
_TRIED = 6
"""Of the proposals of a round that look better than what keeps all, how many are tried."""
_GOLDEN = {1: 1.618033988749895, 2: 1.324717957244746, 3: 1.2207440846057596}
"""Roots x of x^(d+1) = x + 1: steps of 1/x, 1/x^2, ... fill a box of d sides evenly."""


@dataclass(frozen=True)
class Attained:
    """Values, SI, and what is exact there: the evaluation of each environment, and whether all that must be is ``kept``.

    None where that is undecided.
    """

    values: tuple[Expr, ...]
    evaluations: tuple[Evaluation, ...]
    kept: bool | None

    @cached_property
    def bandwidth(self) -> float:
        """The smallest of all environments, rad/s, rounded down; 0 where there is none."""
        return min(map(least_of, self.evaluations))

    @property
    def is_whole(self) -> bool:
        """Whether nothing is noticed on the band with any environment."""
        return all(x.bandwidth is not None and x.bandwidth == x.chart.points[-1].omega for x in self.evaluations)


def least_of(x: Evaluation) -> float:
    """The bandwidth, rad/s, rounded down; 0 where there is none."""
    if x.bandwidth is None:
        return 0.0
    value = Fraction(x.bandwidth.enclosure(20)[0])
    found = float(value)
    return found if Fraction(found) <= value else float(np.nextafter(found, -np.inf))


@dataclass
class Points:
    """Sets of values of one to three parameters, of one scene or of one for each environment.

    ``keep`` : what must be kept, in the scenes' hands. ``factors`` : a set of values stands for all that are so many
    times them.
    """

    scenes: Sequence[Scene]
    free: Sequence[Knob]
    ranges: Sequence[tuple[Expr, Expr]]
    keep: Sequence[str]
    factors: Sequence[tuple[Expr, ...]]
    known: dict[tuple[Expr, ...], Attained | None] = field(default_factory=dict)
    _kernels: dict[int, Kernel | None] = field(default_factory=dict)

    @cached_property
    def boxes(self) -> list[DesignBox]:
        """All values, of each environment, and as far off as they may be."""
        sides = tuple(Side(x.symbol.name, *ends, x.unit) for x, ends in zip(self.free, self.ranges, strict=True))
        return [DesignBox(s, sides).times(f) for s, f in product(self.scenes, self.factors)]

    @cached_property
    def criteria(self) -> list[list[Judge]]:
        """What must not be positive on the band, of each box."""
        return [box.criteria() for box in self.boxes]

    @cached_property
    def _scales(self) -> list[tuple[float, float, bool]]:
        ends = [(float(low), float(high)) for low, high in self.ranges]
        return [(low, high, low > 0 and high > 8 * low) for low, high in ends]

    def values(self, shares: Array) -> Array:
        """The values at shares of the box, linear, (sets, parameters)."""
        low, high = np.array([x[:2] for x in self._scales]).T
        return self._inside(low + (high - low) * shares)

    def spread(self, count: int = 0) -> Array:
        """Values all over the box, and its corners; by ratios where a range spans more than a factor of eight."""
        n = len(self.free)
        even = _even(n, 1 + np.arange(count or _POINTS[n]))
        shares = np.concatenate([even, np.array(list(product((0.0, 1.0), repeat=n)))])
        columns = [
            low * (high / low) ** u if by_ratio else low + (high - low) * u
            for (low, high, by_ratio), u in zip(self._scales, shares.T, strict=True)
        ]
        return self._inside(np.stack(columns, -1))

    def _inside(self, values: Array) -> Array:
        low, high = np.array([x[:2] for x in self._scales]).T
        return np.clip(values, low, high)

    def bandwidths(self, values: Array) -> Array:
        """Of sets of values, (sets, parameters), the smallest bandwidth of all environments; in floats, 0 where none is known."""
        found = np.full(len(values), np.inf)
        for (scene, factors), criteria in zip(product(self.scenes, self.factors), self.criteria, strict=True):
            own, left, kernel = np.empty(len(values)), np.arange(len(values)), self._kernel(scene)
            if kernel is not None:
                columns, left = kernel.in_floats((values * np.array(factors, float)).T)
                own = np.nan_to_num(columns["bandwidth"], nan=0.0)
            if len(left):
                own[left] = self._from(criteria, values[left])
            found = np.minimum(found, own)
        return found

    def first_crossings(self, values: Array) -> dict[Part, Array]:
        """From where on each part is noticed with any environment, of sets of values; the band's end where it is not."""
        own = {part: [x for box in self.boxes for x in box.criteria(part)] for part in Part}
        return {part: self._from(criteria, values) for part, criteria in own.items() if criteria}

    def _from(self, criteria: Sequence[Judge], values: Array) -> Array:
        """From where on one of several criteria is exceeded at least, rad/s; the band's end where none is."""
        start, width = np.array([(low, high - low) for low, high, _ in self._scales]).T
        low, high = map(float, self.scenes[0].band)
        shares = at_points(criteria, (values - start) / width)
        return np.select([shares >= 1, shares > 0], [high, low + shares * (high - low)], 0.0)

    def _kernel(self, scene: Scene) -> Kernel | None:
        """What a sweep has; not of several delays, holds, powers of s or of one and a JND region: a set may take it a second."""
        if id(scene) not in self._kernels:
            chain = scene.chain
            parts = ((chain.environment, chain.rendered), *chain.matrices)
            waves = [x for x in parts if not all(entry.is_rational_function(s) for entry in x)]
            many = len(waves) + any(x.region is not None for x in noticed(scene.threshold)) > 1
            self._kernels[id(scene)] = None if many else Kernel.of(replace(scene, hands=()), self.free)
        return self._kernels[id(scene)]

    def attained(self, values: Sequence[Expr]) -> Attained | None:
        """What is exact at some values; None where the model is not defined there."""
        key = tuple(values)
        if key not in self.known:
            try:
                scenes = self._scenes(key)
                self.known[key] = Attained(key, tuple(map(evaluate, scenes)), self._keep_all(scenes))
            except LimitError:
                raise
            except HaptisymError:
                self.known[key] = None
        return self.known[key]

    def _scenes(self, values: Sequence[Expr]) -> list[Scene]:
        each = [
            dict(zip((x.path for x in self.free), map(mul, values, factors), strict=True)) for factors in self.factors
        ]
        return [scene.with_values(own) for scene in self.scenes for own in each]

    def _keep_all(self, scenes: Sequence[Scene]) -> bool | None:
        found = [keeps(scene, x) for x in self.keep for scene in scenes]
        return False if False in found else None if None in found else True

    def best(self, start: Array, least: float = 0.0) -> Attained | None:
        """The best that is found from some sets of values that keeps what must be kept, better than ``least``.

        Proposed by floats, which close in on the best so far, and evaluated exactly.
        """
        values, found = start, self.bandwidths(start)
        centre, top, sides = None, least, len(self.free)
        for n in range(_ROUNDS[sides]):
            tick()
            i = self._first_kept(values, found, top)
            if i is not None:
                centre, top = values[i], float(found[i])
            if centre is None:
                return None
            values = self._near(centre, _CLOSER[sides] ** (n + 1), n)
            found = self.bandwidths(values)
        assert centre is not None
        best = self.attained(exact(centre))
        return best if best and best.kept and best.bandwidth > least else None

    def _near(self, centre: Array, width: float, n: int) -> Array:
        """Sets of values about one, within a share of the box (by ratios: of the logarithm of its range)."""
        count = _ROUND[len(self.free)]
        shares = (_even(len(self.free), np.arange(count) + 7 * n) - 0.5) * 2 * width
        columns = [
            c * (high / low) ** u if by_ratio and c > 0 else c + (high - low) * u
            for c, (low, high, by_ratio), u in zip(centre, self._scales, shares.T, strict=True)
        ]
        return self._inside(np.stack(columns, -1))

    def _first_kept(self, values: Array, found: Array, least: float) -> int | None:
        """The number of the best proposal above ``least`` that keeps all, of the first few that look so."""
        order = [int(i) for i in np.argsort(-found, kind="stable") if found[i] > least]
        for i in order[:_TRIED]:
            tick()
            try:
                if not self.keep or self._keep_all(self._scenes(exact(values[i]))):
                    return i
            except LimitError:
                raise
            except HaptisymError:
                continue
        return None

    def nearest_whole(self, values: Array, high: float, to: Array) -> Attained | None:
        """Of sets of values with which floats see nothing noticed up to ``high``, the nearest that keeps all."""
        found = values[self.bandwidths(values) >= high]
        spans = np.array([high - low for low, high, _ in self._scales])
        for x in found[np.argsort(np.abs((found - to) / spans).max(-1), kind="stable")][:_TRIED]:
            tick()
            own = self.attained(exact(x))
            if own and own.kept and own.is_whole:
                return own
        return None

    def rounded(self, best: Attained, loss: float) -> Attained:
        """The same with fewer digits in the units of the scene, where that costs no more than a share of the bandwidth."""
        sizes = [x.shown_unit(x.motion).size for x in self.free]
        for digits in range(2, 17):
            values = [
                Rational(f"{float(x / size):.{digits}g}") * size for x, size in zip(best.values, sizes, strict=True)
            ]
            if not all(low <= x <= high for x, (low, high) in zip(values, self.ranges, strict=True)):
                continue
            found = self.attained(values)
            if found and found.kept and found.bandwidth >= best.bandwidth * (1 - loss):
                return found
        return best


def _even(sides: int, numbers: Array) -> Array:
    steps = 1 / _GOLDEN[sides] ** np.arange(1, sides + 1)
    return (0.5 + numbers[:, None] * steps) % 1.0


def exact(values: Array) -> tuple[Expr, ...]:
    """Floats as the numbers that they are."""
    return tuple(Rational(*float(x).as_integer_ratio()) for x in values)


def offsets(parameters: int, relative: Expr) -> list[tuple[Expr, ...]]:
    """By what values are multiplied that are off by so much at most: not at all, and all together by as much as they may."""
    ends = [tuple(x) for x in product((1 - relative, 1 + relative), repeat=parameters)] if relative else []
    return [(Integer(1),) * parameters, *ends]


def keeps(scene: Scene, what: str) -> bool | None:
    """Whether a scene is passive, stable in all of its hands, or steady: without shaking, a drift being allowed."""
    if what == PASSIVE:
        return passivity(scene).holds
    from haptisym.verbs.stability.held import held  # which much else is loaded for

    found: list[bool | None] = []
    for hand in scene.hands:
        of_hand = held(scene, hand)
        shakes = of_hand.shakes
        found.append(of_hand.stable if what == STABLE else None if shakes is None else not shakes)
    return False if False in found else None if None in found else True
