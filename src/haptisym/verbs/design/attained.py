"""Bandwidths that are attained: many sets of values in floats, the best of them exactly, with what
must be kept.

Floats only propose: those of a sweep, and where these take long or decide nothing what the one
search shows at single points. What is called attained was evaluated exactly at rational values, and
what must be kept was decided there.

Where values may be *off* by a relative distance, what they attain is the smallest bandwidth of all
values so far away. It is bounded from below by the one search and from above by single values,
whose ``factors`` (times the values: the middle, the corners, then whatever turned out to be worst
anywhere) are what floats and the upper bound look at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import inf
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
from haptisym.verbs.design.bound import DesignBox, at_points, smallest
from haptisym.verbs.sweep.passes import Kernel

PASSIVE, STABLE, STEADY = "passive", "stable", "steady"
KEPT = (PASSIVE, STABLE, STEADY)
_POINTS = {1: 40, 2: 160, 3: 400}
"""Sets of values to begin with, for so many parameters."""
_ROUNDS, _ROUND, _CLOSER = {1: 12, 2: 24, 3: 24}, {1: 16, 2: 40, 3: 80}, {1: 0.25, 2: 0.5, 3: 0.5}
"""Times that the search closes in on the best, sets of values each time, and to which share of the
box before."""
_TRIED = 6
"""Of the proposals of a round that look better than what keeps all, how many are tried."""
_FEWER = 4
"""How many times fewer sets and rounds there are for values that may be off, each of which is
looked at many times."""
_GOLDEN = {1: 1.618033988749895, 2: 1.324717957244746, 3: 1.2207440846057596}
"""Roots x of x^(d+1) = x + 1: steps of 1/x, 1/x^2, ... fill a box of d sides evenly."""


@dataclass(frozen=True)
class Attained:
    """Values, SI, and what is exact there: evaluations, and whether all that must be is ``kept``,
    None where that is undecided.

    ``evaluations`` : of each environment; where values may be off those of all factors, and of what
    was found to be worst.
    ``proven`` : what all values attain that are off by as much as they may, rad/s, infinite where
    nothing is noticed with any; None where they are not off.
    """

    values: tuple[Expr, ...]
    evaluations: tuple[Evaluation, ...]
    kept: bool | None
    proven: float | None = None

    @cached_property
    def seen(self) -> float:
        """The smallest bandwidth of all evaluations, rad/s, rounded down; 0 where there is none."""
        return min(map(least_of, self.evaluations))

    @property
    def bandwidth(self) -> float:
        """What is attained for certain, rad/s."""
        return self.seen if self.proven is None else min(self.proven, self.seen)

    @property
    def is_whole(self) -> bool:
        """Whether nothing is noticed on the band with any environment."""
        if self.proven is not None and self.proven < inf:
            return False
        return all(
            x.bandwidth is not None and x.bandwidth == x.chart.points[-1].omega
            for x in self.evaluations
        )


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

    ``keep`` : what must be kept, in the scenes' hands. ``off`` : the relative distance that values
    may be off, 0 if none;
    ``gap`` : to which bounds are to come together. ``factors`` : values are looked at so many times
    what they are.
    """

    scenes: Sequence[Scene]
    free: Sequence[Knob]
    ranges: Sequence[tuple[Expr, Expr]]
    keep: Sequence[str]
    off: Expr
    gap: float
    factors: list[tuple[Expr, ...]] = field(default_factory=list)
    boxes: list[DesignBox] = field(default_factory=list)
    """All values, so many times what they are, of each environment."""
    known: dict[tuple[Expr, ...], Attained | None] = field(default_factory=dict)
    _kernels: dict[int, Kernel | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for x in _offsets(len(self.free), self.off):
            self._look_at(x)

    def _look_at(self, factors: tuple[Expr, ...]) -> None:
        """Values so many times what they are, too."""
        sides = tuple(
            Side(x.symbol.name, *ends, x.unit)
            for x, ends in zip(self.free, self.ranges, strict=True)
        )
        self.factors.append(factors)
        self.boxes += [DesignBox(scene, sides).times(factors) for scene in self.scenes]

    @property
    def criteria(self) -> list[Judge]:
        """What must not be positive on the band, of all boxes."""
        return [judge for box in self.boxes for judge in box.criteria]

    @cached_property
    def _scales(self) -> list[tuple[float, float, bool]]:
        ends = [(float(low), float(high)) for low, high in self.ranges]
        return [(low, high, low > 0 and high > 8 * low) for low, high in ends]

    def values(self, shares: Array) -> Array:
        """The values at shares of the box, linear, (sets, parameters)."""
        low, high = np.array([x[:2] for x in self._scales]).T
        return self._inside(low + (high - low) * shares)

    def spread(self) -> Array:
        """Values all over the box, and its corners; by ratios where a range spans more than a
        factor of eight."""
        n = len(self.free)
        even = _even(n, 1 + np.arange(_POINTS[n] // (_FEWER if self.off else 1)))
        shares = np.concatenate([even, np.array(list(product((0.0, 1.0), repeat=n)))])
        columns = [
            low * (high / low) ** u if by_ratio else low + (high - low) * u
            for (low, high, by_ratio), u in zip(self._scales, shares.T, strict=True)
        ]
        return self._inside(np.stack(columns, -1))

    def _inside(self, values: Array) -> Array:
        low, high = np.array([x[:2] for x in self._scales]).T
        return np.clip(values, low, high)

    def bandwidths(self, values: Array, since: int = 0) -> Array:
        """Of sets of values, (sets, parameters), the smallest bandwidth of all environments and
        factors, in floats.

        A lower and an upper number, (2, sets): both are the same but where floats decide nothing,
        at a threshold that is touched. ``since`` : of the factors from that number on.
        """
        found = np.full((2, len(values)), np.inf)
        boxes = self.boxes[since * len(self.scenes) :]
        for (factors, scene), box in zip(
            product(self.factors[since:], self.scenes), boxes, strict=True
        ):
            own, left, kernel = (
                np.empty((2, len(values))),
                np.arange(len(values)),
                self._kernel(scene),
            )
            if kernel is not None:
                columns, left = kernel.in_floats((values * np.array(factors, float)).T)
                own[:] = np.nan_to_num(columns["bandwidth"], nan=0.0)
            if len(left):
                own[:, left] = self._from(box.criteria, values[left])
            found = np.minimum(found, own)
        return found

    def first_crossings(self, values: Array) -> dict[Part, Array]:
        """From where on each part is noticed with any environment, of sets of values; the band's
        end where it is not."""
        own = {part: [x for box in self.boxes for x in box.criteria_of(part)] for part in Part}
        return {part: self._from(criteria, values)[1] for part, criteria in own.items() if criteria}

    def _from(self, criteria: Sequence[Judge], values: Array) -> Array:
        """From where on, at least and at most, one of several criteria is exceeded, rad/s; the
        band's end where none is."""
        start, width = np.array([(low, high - low) for low, high, _ in self._scales]).T
        low, high = map(float, self.scenes[0].band)
        shares = np.stack(at_points(criteria, (values - start) / width))
        return np.select([shares >= 1, shares > 0], [high, low + shares * (high - low)], 0.0)

    def _kernel(self, scene: Scene) -> Kernel | None:
        """What a sweep has; not of several delays, holds, powers of s or of one and a JND region: a
        set may take it a second."""
        if id(scene) not in self._kernels:
            chain = scene.chain
            parts = ((chain.environment, chain.rendered), *chain.matrices)
            waves = [x for x in parts if not all(entry.is_rational_function(s) for entry in x)]
            many = len(waves) + any(x.region is not None for x in noticed(scene.threshold)) > 1
            self._kernels[id(scene)] = (
                None if many else Kernel.of(replace(scene, hands=()), self.free)
            )
        return self._kernels[id(scene)]

    def attained(self, values: Sequence[Expr]) -> Attained | None:
        """What is attained at some values; None where the model is not defined there."""
        key = tuple(values)
        if key not in self.known:
            try:
                self.known[key] = self._attained(key)
            except LimitError:
                raise
            except HaptisymError:
                self.known[key] = None
        return self.known[key]

    def _attained(self, values: tuple[Expr, ...]) -> Attained:
        scenes = self._scenes(values)
        found = Attained(values, tuple(map(evaluate, scenes)), self._keep_all(scenes))
        if not self.off:
            return found
        proven, at = self.worst(found, self.off, self.gap / 100)
        if at is not None:
            there = tuple(map(evaluate, self._at(at)))
            if min(map(least_of, there)) < found.seen * (
                1 - self.gap / 2
            ):  # worse than by all that are looked at
                pairs = zip(at, values, strict=True)
                self._look_at(tuple(x / value if value else Integer(1) for x, value in pairs))
            found = replace(found, evaluations=(*found.evaluations, *there))
        kept = self.keep_around(values, self.off) if found.kept else found.kept
        return replace(found, kept=kept, proven=proven)

    def fits(self, found: Attained) -> bool:
        """Whether what must be kept is; of values that are off it may stay open, which is said,
        whether all of them do."""
        return found.kept is True or (bool(self.off) and found.kept is None)

    def worst(
        self, found: Attained, relative: Expr, within: float
    ) -> tuple[float, tuple[Expr, ...] | None]:
        """What all values within a relative distance of some attain at least, rad/s, infinite where
        nothing is noticed.

        With the worst of them that were found to attain less than what was known; None where there
        are none.
        """
        each = zip(self.free, found.values, strict=True)
        sides = tuple(Side(x.symbol.name, v, v, x.unit) for x, v in each)
        start, end = map(float, self.scenes[0].band)
        seen = inf if found.is_whole else found.seen
        lowest = known = min(max(seen - start, 0.0) / (end - start), 1.0)
        at = None
        for scene in self.scenes:
            box, least = DesignBox(scene, sides).around(relative), 0.0
            for least, most, where in smallest(  # noqa: B007  the last and closest
                box.criteria, len(self.free), within, known
            ):
                tick()
                if where is not None and most < known:
                    known, at = (
                        most,
                        tuple(
                            x.at(Fraction(float(u))) for x, u in zip(box.sides, where, strict=True)
                        ),
                    )
            if least <= 0:
                tick()  # where the time was over before anything was proven that is no answer
            lowest = min(lowest, least)
        if (
            lowest < 1
            and found.is_whole
            and at is None
            and self._is_whole_around(found.values, relative)
        ):
            return inf, None
        return _frequency(lowest, start, end), at

    def _is_whole_around(self, values: Sequence[Expr], relative: Expr) -> bool:
        """Whether nothing is noticed for all values within a relative distance, also where
        thresholds are reached exactly."""
        from haptisym.verbs.tolerances.proofs import BandVerdict, tolerances

        away = zip((x.path for x in self.free), values, strict=True)
        ranges = {path: sorted((x * (1 - relative), x * (1 + relative))) for path, x in away}
        alone = (replace(scene, hands=()).with_values(ranges) for scene in self.scenes)
        return any(values) and all(
            tolerances(x, samples=0, limit=None).verdict is BandVerdict.ALL for x in alone
        )

    def keep_around(self, values: Sequence[Expr], relative: Expr) -> bool | None:
        """Whether all values within a relative distance keep what must be kept; None where that is
        not proven."""
        if not self.keep:
            return True
        if len(self.free) > 1 or not any(values):  # 0 is off by nothing
            corners = [tuple(map(mul, values, x)) for x in _offsets(len(self.free), relative)]
            found = [self._keep_all(self._at(x)) for x in corners]
            return False if False in found else None if None in found or any(values) else True
        from haptisym.verbs.require.required import require

        [value], [free] = values, self.free
        ends = sorted((value * (1 - relative), value * (1 + relative)))
        for scene in self.scenes:
            asked = require(scene, free.path, (ends[0], ends[1]), that=self.keep, limit=None)
            if asked.undecided:
                return None
            if len(asked.feasible) != 1 or asked.ends:
                return False
        return True

    def _at(self, values: Sequence[Expr]) -> list[Scene]:
        own = dict(zip((x.path for x in self.free), values, strict=True))
        return [scene.with_values(own) for scene in self.scenes]

    def _scenes(self, values: Sequence[Expr]) -> list[Scene]:
        return [
            scene
            for factors in self.factors
            for scene in self._at(tuple(map(mul, values, factors)))
        ]

    def _keep_all(self, scenes: Sequence[Scene]) -> bool | None:
        found = [keeps(scene, x) for x in self.keep for scene in scenes]
        return False if False in found else None if None in found else True

    def best(self, start: Array, least: float = 0.0) -> Attained | None:
        """The best that is found from some sets of values that keeps what must be kept, better than
        ``least``.

        Proposed by floats, which close in on the best so far, and evaluated exactly. Where that
        shows a factor to be worst that nobody had looked at, floats begin again with it.
        """
        looked_at, found = 0, np.array(np.inf)
        while len(self.factors) > looked_at:
            found = np.minimum(found, self.bandwidths(start, looked_at))
            looked_at = len(self.factors)
            best = self._best(start, found, least)
        return best if best and self.fits(best) and best.bandwidth > least else None

    def _best(self, values: Array, found: Array, least: float) -> Attained | None:
        centre, top, sides, looked_at = None, least, len(self.free), len(self.factors)
        # some factors alone are looked at: what is little better by these is hardly ever so by all
        margin = 1 + self.gap / 2 if self.off else 1.0
        for n in range(_ROUNDS[sides] // (_FEWER if self.off else 1)):
            tick()
            better = self._first_kept(values, found, top * margin)
            if better is not None:
                centre, top = better
                if self.off:
                    self.attained(self.exact(centre))
            if centre is None or len(self.factors) > looked_at:
                return None
            values = self._near(centre, _CLOSER[sides] ** (n + 1), n)
            found = self.bandwidths(values)
        assert centre is not None
        return self.attained(self.exact(centre))

    def exact(self, values: Array) -> tuple[Expr, ...]:
        """Floats as the decimals that they are written as, so that what is printed is what was
        evaluated; in the ranges."""
        each = zip(map(Rational, map(repr, values.tolist())), self.ranges, strict=True)
        return tuple(min(max(x, low), high) for x, (low, high) in each)

    def _near(self, centre: Array, width: float, n: int) -> Array:
        """Sets of values about one, within a share of the box (by ratios: of the logarithm of its
        range)."""
        count = _ROUND[len(self.free)]
        shares = (_even(len(self.free), np.arange(count) + 7 * n) - 0.5) * 2 * width
        columns = [
            c * (high / low) ** u if by_ratio and c > 0 else c + (high - low) * u
            for c, (low, high, by_ratio), u in zip(centre, self._scales, shares.T, strict=True)
        ]
        return self._inside(np.stack(columns, -1))

    def _first_kept(self, values: Array, found: Array, least: float) -> tuple[Array, float] | None:
        """The best proposal above ``least`` that keeps all, of the first few that look so, and its
        bandwidth."""
        low, high = found.copy()
        open_ = [
            int(i)
            for i in np.argsort(-high, kind="stable")
            if high[i] > max(low[i] + self._unclear, least)
        ]
        for i in open_[:_TRIED]:
            tick()
            exactly = self.attained(self.exact(values[i]))
            low[i] = 0.0 if exactly is None else exactly.bandwidth
        order = [int(i) for i in np.argsort(-low, kind="stable") if low[i] > least]
        for i in order[:_TRIED]:
            tick()
            try:
                if not self.keep or self._keep_all(self._scenes(self.exact(values[i]))):
                    return values[i], float(low[i])
            except LimitError:
                raise
            except HaptisymError:
                continue
        return None

    @cached_property
    def _unclear(self) -> float:
        """How far floats may be apart, rad/s, where they decide what the bandwidth is."""
        start, end = map(float, self.scenes[0].band)
        return self.gap / 100 * (end - start)

    def nearest_whole(self, values: Array, high: float, to: Array) -> Attained | None:
        """Of sets of values with which floats may see nothing noticed up to ``high``, the nearest
        that keeps all."""
        found = values[self.bandwidths(values)[1] >= high]
        spans = np.array([high - low for low, high, _ in self._scales])
        for x in found[np.argsort(np.abs((found - to) / spans).max(-1), kind="stable")][:_TRIED]:
            tick()
            own = self.attained(self.exact(x))
            if own and self.fits(own) and own.is_whole:
                return own
        return None

    def rounded(self, best: Attained, loss: float) -> Attained:
        """The same with fewer digits in the units of the scene, where that costs no more than a
        share of the bandwidth."""
        sizes = [x.shown_unit(x.motion).size for x in self.free]
        for digits in range(2, 17):
            values = [
                Rational(f"{float(x / size):.{digits}g}") * size
                for x, size in zip(best.values, sizes, strict=True)
            ]
            if not all(
                low <= x <= high for x, (low, high) in zip(values, self.ranges, strict=True)
            ):
                continue
            found = self.attained(values)
            if found and found.kept == best.kept and found.bandwidth >= best.bandwidth * (1 - loss):
                return found
        return best


def _even(sides: int, numbers: Array) -> Array:
    steps = 1 / _GOLDEN[sides] ** np.arange(1, sides + 1)
    return (0.5 + numbers[:, None] * steps) % 1.0


def _frequency(share: float, low: float, high: float) -> float:
    """What a share of a band is, rad/s, rounded down; 0 where it is nothing, infinite where it is
    all."""
    if share >= 1:
        return inf
    return float(np.nextafter(low + share * (high - low), low)) if share > 0 else 0.0


def _offsets(parameters: int, relative: Expr) -> list[tuple[Expr, ...]]:
    """By what values are multiplied that are off by so much at most: not at all, and all together
    by as much as they may."""
    ends = (
        [tuple(x) for x in product((1 - relative, 1 + relative), repeat=parameters)]
        if relative
        else []
    )
    return [(Integer(1),) * parameters, *ends]


def keeps(scene: Scene, what: str) -> bool | None:
    """Whether a scene is passive, stable in all of its hands, or steady: without shaking, a drift
    being allowed."""
    if what == PASSIVE:
        return passivity(scene).holds
    from haptisym.verbs.stability.held import held  # which much else is loaded for

    found: list[bool | None] = []
    for hand in scene.hands:
        of_hand = held(scene, hand)
        shakes = of_hand.shakes
        found.append(of_hand.stable if what == STABLE else None if shakes is None else not shakes)
    return False if False in found else None if None in found else True
