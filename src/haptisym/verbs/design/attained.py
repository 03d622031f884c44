"""Bandwidths that are attained: many sets of values are tried in floats, the best of them exactly,
and what must be kept is decided there.

Floats only propose: those of a sweep, and where these take long or decide nothing, what the branch
and bound of ``bound`` shows at single points. What is called attained was evaluated exactly at
rational values.

Where values may be *off* by a relative distance, what they attain is the smallest bandwidth of all
values so far away. It is bounded from below by branch and bound, from above by single values,
whose ``factors`` (times the values: the middle, the corners, then whatever turned out to be worst
anywhere) are what floats and the upper bound are computed for. ``Points.best`` is where to begin
reading.
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
from haptisym.verbs.sweep.evaluator import SetEvaluator

PASSIVE, STABLE, STEADY = "passive", "stable", "steady"
KEPT = (PASSIVE, STABLE, STEADY)
_POINTS = {1: 40, 2: 160, 3: 400}
"""Sets of values to begin with, by the number of parameters."""
_ROUNDS, _ROUND, _CLOSER = {1: 12, 2: 24, 3: 24}, {1: 16, 2: 40, 3: 80}, {1: 0.25, 2: 0.5, 3: 0.5}
"""Rounds in which the search closes in on the best, sets of values of a round, and the size of the
box of a round over that of the one before; by the number of parameters."""
_TRIED = 6
"""Proposals of a round that are tried exactly, of those that look better than what is attained."""
_FEWER = 4
"""How many times fewer sets and rounds there are for values that may be off, each of which is
looked at many times."""
_GOLDEN = {1: 1.618033988749895, 2: 1.324717957244746, 3: 1.2207440846057596}
"""Roots x of x^(d+1) = x + 1, the golden ratio for d = 1: steps of 1/x, 1/x^2, ... modulo 1 fill a
box of d sides evenly (an additive recurrence of low discrepancy), however many there are."""


@dataclass(frozen=True)
class Attained:
    """What is attained at one set of values, SI: exact evaluations, and whether what must be kept
    is ``kept``, None where that is undecided.

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
        """The bandwidth that is proven to be attained, rad/s; the worst one of values that may be
        off."""
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
    nearest = float(value)
    # the nearest float may lie above: what is attained must not be more than the exact bandwidth
    return nearest if Fraction(nearest) <= value else float(np.nextafter(nearest, -np.inf))


@dataclass
class Points:
    """Evaluates sets of values of one to three parameters, of one scene or of one for each
    environment.

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
    _evaluators: dict[int, SetEvaluator | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for x in _offsets(len(self.free), self.off):
            self._look_at(x)

    def _look_at(self, factors: tuple[Expr, ...]) -> None:
        """Judge values from now on also by what they attain when multiplied by these factors."""
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
        """The range of each parameter, and whether values are spread over it by equal ratios: where
        it spans more than a factor of eight."""
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
        """The smallest bandwidth of all environments and factors at sets of values, (sets,
        parameters), in floats, rad/s.

        A lower and an upper number, (2, sets): both are the same but where floats decide nothing,
        at a threshold that is touched. ``since`` : only the factors from that number on count.
        """
        smallest_yet = np.full((2, len(values)), np.inf)
        boxes = self.boxes[since * len(self.scenes) :]
        pairs = product(self.factors[since:], self.scenes)
        for (factors, scene), box in zip(pairs, boxes, strict=True):
            of_scene = np.empty((2, len(values)))
            left, evaluator = np.arange(len(values)), self._evaluator(scene)
            if evaluator is not None:
                columns, left = evaluator.in_floats((values * np.array(factors, float)).T)
                of_scene[:] = np.nan_to_num(columns["bandwidth"], nan=0.0)
            # the box is multiplied by the factors, so that its shares are those of the values
            if len(left):
                of_scene[:, left] = self._from(box.criteria, values[left])
            smallest_yet = np.minimum(smallest_yet, of_scene)
        return smallest_yet

    def first_crossings(self, values: Array) -> dict[Part, Array]:
        """The frequencies, rad/s, from which on each part is noticed with some environment, at sets
        of values; the band's end where it is not."""
        by_part = {part: [x for box in self.boxes for x in box.criteria_of(part)] for part in Part}
        return {
            part: self._from(criteria, values)[1] for part, criteria in by_part.items() if criteria
        }

    def _from(self, criteria: Sequence[Judge], values: Array) -> Array:
        """Lower and upper bounds on the frequency from which on one of several criteria is
        exceeded, rad/s; the band's end where none is."""
        start, width = np.array([(low, high - low) for low, high, _ in self._scales]).T
        low, high = map(float, self.scenes[0].band)
        shares = np.stack(at_points(criteria, (values - start) / width))
        return np.select([shares >= 1, shares > 0], [high, low + shares * (high - low)], 0.0)

    def _evaluator(self, scene: Scene) -> SetEvaluator | None:
        """The evaluator of a sweep of the scene; None for several delays, holds or powers of s, or
        one with a JND region, of which a single set may take a sweep a second."""
        if id(scene) not in self._evaluators:
            chain = scene.chain
            parts = ((chain.environment, chain.rendered), *chain.matrices)
            waves = [x for x in parts if not all(entry.is_rational_function(s) for entry in x)]
            many = len(waves) + any(x.region is not None for x in noticed(scene.threshold)) > 1
            self._evaluators[id(scene)] = (
                None if many else SetEvaluator.of(replace(scene, hands=()), self.free)
            )
        return self._evaluators[id(scene)]

    def attained(self, values: Sequence[Expr]) -> Attained | None:
        """What is attained at some values; None where the model is not defined there."""
        key = tuple(values)
        if key not in self.known:
            try:
                self.known[key] = self._attained(key)
            # that the time is over is no property of these values, and not to be remembered as one
            except LimitError:
                raise
            except HaptisymError:
                self.known[key] = None
        return self.known[key]

    def _attained(self, values: tuple[Expr, ...]) -> Attained:
        """What is attained at some values, which may be off."""
        scenes = self._scenes(values)
        found = Attained(values, tuple(map(evaluate, scenes)), self._keep_all(scenes))
        if not self.off:
            return found
        proven, at = self.worst(found, self.off, self.gap / 100)
        if at is not None:
            there = tuple(map(evaluate, self._at(at)))
            # worse than by all factors so far: what floats and the upper bound compute would not
            # come down to what is attained without this one
            if min(map(least_of, there)) < found.seen * (1 - self.gap / 2):
                pairs = zip(at, values, strict=True)
                self._look_at(tuple(x / value if value else Integer(1) for x, value in pairs))
            found = replace(found, evaluations=(*found.evaluations, *there))
        kept = self.keep_around(values, self.off) if found.kept else found.kept
        return replace(found, kept=kept, proven=proven)

    def fits(self, found: Attained) -> bool:
        """Whether what must be kept is kept. Of values that may be off it may be undecided whether
        all of them keep it; these are accepted, and the answer is then not certified."""
        return found.kept is True or (bool(self.off) and found.kept is None)

    def worst(
        self, found: Attained, relative: Expr, within: float
    ) -> tuple[float, tuple[Expr, ...] | None]:
        """A lower bound on what all values within a relative distance attain, rad/s, infinite where
        nothing is noticed; and the worst of them, None where none attains less than is known."""
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
            # 0 is also where a search begins: where the time was over before anything was proven,
            # the tick raises, and 0 is no answer
            if least <= 0:
                tick()
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
        """Whether it is proven that nothing is noticed for all values within a relative distance:
        by the verdict of ``tolerances``, which decides also where thresholds are just reached."""
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
        # Of several parameters the corners may refute, but prove nothing of what lies between;
        # values that are all 0 are off by nothing, and their one corner is all.
        if len(self.free) > 1 or not any(values):
            corners = [tuple(map(mul, values, x)) for x in _offsets(len(self.free), relative)]
            verdicts = [self._keep_all(self._at(x)) for x in corners]
            if False in verdicts:
                return False
            return None if None in verdicts or any(values) else True
        from haptisym.verbs.require.required import require

        [value], [free] = values, self.free
        ends = sorted((value * (1 - relative), value * (1 + relative)))
        for scene in self.scenes:
            required = require(scene, free.path, (ends[0], ends[1]), that=self.keep, limit=None)
            if required.undecided:
                return None
            if len(required.feasible) != 1 or required.ends:
                return False
        return True

    def _at(self, values: Sequence[Expr]) -> list[Scene]:
        """The scenes of all environments with these values."""
        by_path = dict(zip((x.path for x in self.free), values, strict=True))
        return [scene.with_values(by_path) for scene in self.scenes]

    def _scenes(self, values: Sequence[Expr]) -> list[Scene]:
        """The scenes of all environments with these values times all factors."""
        return [
            scene
            for factors in self.factors
            for scene in self._at(tuple(map(mul, values, factors)))
        ]

    def _keep_all(self, scenes: Sequence[Scene]) -> bool | None:
        """Whether all scenes keep what must be kept; None where that is undecided."""
        found = [keeps(scene, x) for x in self.keep for scene in scenes]
        return False if False in found else None if None in found else True

    def best(self, start: Array, least: float = 0.0) -> Attained | None:
        """The best values that are found from some sets of values, better than ``least`` and with
        what must be kept; None where none are found.

        Proposed by floats, which close in on the best so far, and evaluated exactly. Where that
        shows a new factor to be the worst one, floats begin again with it.
        """
        examined, bandwidths = 0, np.array(np.inf)
        while len(self.factors) > examined:
            # those of earlier factors are known from the round before
            bandwidths = np.minimum(bandwidths, self.bandwidths(start, examined))
            examined = len(self.factors)
            best = self._best(start, bandwidths, least)
        return best if best and self.fits(best) and best.bandwidth > least else None

    def _best(self, values: Array, bandwidths: Array, least: float) -> Attained | None:
        """One search in rounds about the best so far; None where nothing better keeps what it must,
        or a new factor was found to be the worst."""
        centre, top, sides, examined = None, least, len(self.free), len(self.factors)
        # only some factors are evaluated: what is little better by these is hardly ever so by all
        margin = 1 + self.gap / 2 if self.off else 1.0
        for n in range(_ROUNDS[sides] // (_FEWER if self.off else 1)):
            tick()
            better = self._first_kept(values, bandwidths, top * margin)
            if better is not None:
                centre, top = better
                # an exact evaluation is what finds new factors
                if self.off:
                    self.attained(self.exact(centre))
            if centre is None or len(self.factors) > examined:
                return None
            values = self._near(centre, _CLOSER[sides] ** (n + 1), n)
            bandwidths = self.bandwidths(values)
        assert centre is not None
        return self.attained(self.exact(centre))

    def exact(self, values: Array) -> tuple[Expr, ...]:
        """Floats as the decimals that they are written as, so that what is printed is what was
        evaluated; within the ranges."""
        decimals = map(Rational, map(repr, values.tolist()))
        # the float of a range's end may lie outside of it
        pairs = zip(decimals, self.ranges, strict=True)
        return tuple(min(max(x, low), high) for x, (low, high) in pairs)

    def _near(self, centre: Array, width: float, n: int) -> Array:
        """Sets of values about one, within a share of the box (by ratios: of the logarithm of its
        range)."""
        count = _ROUND[len(self.free)]
        # from another number on in each round, so that no round repeats the points of the last one
        shares = (_even(len(self.free), np.arange(count) + 7 * n) - 0.5) * 2 * width
        columns = []
        for c, (low, high, by_ratio), u in zip(centre, self._scales, shares.T, strict=True):
            is_ratio = by_ratio and c > 0
            columns.append(c * (high / low) ** u if is_ratio else c + (high - low) * u)
        return self._inside(np.stack(columns, -1))

    def _first_kept(
        self, values: Array, bandwidths: Array, least: float
    ) -> tuple[Array, float] | None:
        """The best proposal above ``least`` that keeps what must be kept, of the first few that
        look so, and its bandwidth; None where none of them does."""
        low, high = bandwidths.copy()
        # where a threshold is touched floats leave the bandwidth open: it is evaluated exactly
        unclear = [
            int(i)
            for i in np.argsort(-high, kind="stable")
            if high[i] > max(low[i] + self._unclear, least)
        ]
        for i in unclear[:_TRIED]:
            tick()
            exactly = self.attained(self.exact(values[i]))
            low[i] = 0.0 if exactly is None else exactly.bandwidth
        order = [int(i) for i in np.argsort(-low, kind="stable") if low[i] > least]
        for i in order[:_TRIED]:
            tick()
            try:
                if not self.keep or self._keep_all(self._scenes(self.exact(values[i]))):
                    return values[i], float(low[i])
            # That the time is over is no property of these values.
            except LimitError:
                raise
            except HaptisymError:
                continue
        return None

    @cached_property
    def _unclear(self) -> float:
        """How far a lower and an upper float may be apart, rad/s, to count as one bandwidth."""
        start, end = map(float, self.scenes[0].band)
        return self.gap / 100 * (end - start)

    def nearest_whole(self, values: Array, high: float, to: Array) -> Attained | None:
        """The values nearest to ``to`` at which nothing is noticed up to ``high`` and what must be
        kept is kept, of those for which floats leave that possible; None where there are none."""
        possible = values[self.bandwidths(values)[1] >= high]
        spans = np.array([high - low for low, high, _ in self._scales])
        distances = np.abs((possible - to) / spans).max(-1)
        for x in possible[np.argsort(distances, kind="stable")][:_TRIED]:
            tick()
            attained = self.attained(self.exact(x))
            if attained and self.fits(attained) and attained.is_whole:
                return attained
        return None

    def rounded(self, best: Attained, loss: float) -> Attained:
        """The best values with as few digits, in the units of the scene, as cost no more than a
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
    """Points of the evenly filling sequence, (numbers, sides), by their numbers in it."""
    steps = 1 / _GOLDEN[sides] ** np.arange(1, sides + 1)
    return (0.5 + numbers[:, None] * steps) % 1.0


def _frequency(share: float, low: float, high: float) -> float:
    """The frequency at a share of a band, rad/s, rounded down; 0 for no share, infinite for all of
    the band."""
    if share >= 1:
        return inf
    return float(np.nextafter(low + share * (high - low), low)) if share > 0 else 0.0


def _offsets(parameters: int, relative: Expr) -> list[tuple[Expr, ...]]:
    """The factors of values that may be off: the middle, and all corners, where each is off by as
    much as it may."""
    ends = (
        [tuple(x) for x in product((1 - relative, 1 + relative), repeat=parameters)]
        if relative
        else []
    )
    return [(Integer(1),) * parameters, *ends]


def keeps(scene: Scene, what: str) -> bool | None:
    """Whether a scene is passive, stable in all of its hands, or steady: without an oscillating
    root that grows, a drift being allowed. None where that is undecided."""
    if what == PASSIVE:
        return passivity(scene).holds
    from haptisym.verbs.stability.held import held  # which much else is loaded for

    found: list[bool | None] = []
    for hand in scene.hands:
        of_hand = held(scene, hand)
        shakes = of_hand.shakes
        found.append(of_hand.stable if what == STABLE else None if shakes is None else not shakes)
    return False if False in found else None if None in found else True
