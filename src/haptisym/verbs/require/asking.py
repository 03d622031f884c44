"""What is asked of a map: on each of its slices, how many of them there are and where, and all over its plane."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from sympy import Expr

from haptisym.judge.criteria import Criterion
from haptisym.kernel.budget import Budget, share
from haptisym.kernel.counts import whole
from haptisym.kernel.errors import SceneError, several
from haptisym.kernel.roots import sign_of_number
from haptisym.model.knobs import THRESHOLD, Knob
from haptisym.model.quantities import Dimension, Number, number
from haptisym.model.scene import Scene
from haptisym.verbs.require.entry import require
from haptisym.verbs.require.freeparameter import asked_of, domain
from haptisym.verbs.require.placing import even, first_places, refined
from haptisym.verbs.require.plane import held_rectangles, rectangles
from haptisym.verbs.require.proven import Proof
from haptisym.verbs.require.slices import Slice
from haptisym.verbs.require.wishes import STABLE, TRANSPARENT, further

_RANGES = "give one for each of the two, as [(60, 200), (0.1, 1)]"
_FOR_PROOFS = 0.3
"""Of the time, at most."""


@dataclass(frozen=True)
class Plan:
    """At most that many slices, lines between them to be off by a share of the second range; evenly placed if it is None."""

    most: int
    within: Expr | None

    def __post_init__(self) -> None:
        whole("slices", self.most, 2)


def share_of(given: Number) -> Expr:
    """The exact number; SceneError unless it is one, and positive."""
    found = number(given, Dimension.RATIO).value
    if sign_of_number(found) <= 0:
        raise SceneError(f"within: {given} must be > 0, a share of the range of the second parameter")
    return found


@dataclass(frozen=True)
class Asked:
    """What is asked on every slice of a map."""

    scene: Scene
    free: tuple[Knob, Knob]
    ranges: tuple[tuple[Expr, Expr], tuple[Expr, Expr]]
    wanted: tuple[str, ...]
    criteria: tuple[Criterion, ...]
    thresholds: tuple[Expr, ...]
    options: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, scene: Scene, paths: Sequence[str], ranges: Sequence[tuple[Number, Number]], options: Mapping[str, Any],
        wanted: tuple[str, ...], jnd: Sequence[Number],
    ) -> Asked:  # fmt: skip
        """SceneError where paths, ranges or thresholds are not fit."""
        first, second = scene.knobs.chosen(paths)
        scene.knobs.need_numbers((first, second))
        judged = asked_of(scene, (first, second), **options) if TRANSPARENT in wanted else ()
        if len(several("ranges", ranges, _RANGES)) != 2:
            raise SceneError(f"ranges: {len(ranges)} will not do: {_RANGES}")
        across, along = ((free.number(a), free.number(b)) for free, (a, b) in zip((first, second), ranges, strict=True))
        for free, pair in zip((first, second), (across, along), strict=True):
            domain(free, pair)
        thresholds = _thresholds(scene, (first, second), jnd, wanted)
        criteria = (*judged, *further(scene, wanted))
        return cls(scene, (first, second), (across, along), wanted, criteria, thresholds, options)

    def cut(self, at: Expr) -> Slice:
        """The slice at a value of the first parameter."""
        here, path, along = self.free[0].put(self.scene, at), self.free[1].path, self.ranges[1]
        apart = [require(here, path, along, that=[x], limit=None, **self.options) for x in self.wanted]
        others = (here.with_values({THRESHOLD: x}) for x in self.thresholds)
        return Slice.of(at, apart, [require(x, path, along, limit=None, **self.options) for x in others])

    def proofs(self) -> tuple[Proof, ...]:
        """What is proven all over the plane: of what is transparent, with each threshold, and of what is stable."""
        with share(_FOR_PROOFS):
            found = [*self._of_transparent(), *self._of_stable()]
        return tuple(x for x in found if x.rectangles.share_left < 1)

    def _of_transparent(self) -> Iterator[Proof]:
        if TRANSPARENT not in self.wanted:
            return
        first = 1 + len(self.wanted) if len(self.wanted) > 1 else 1
        asked: list[tuple[int, Expr | None, Scene]] = [(self._set(TRANSPARENT), None, self.scene)]
        asked += [(first + i, c, self.scene.with_values({THRESHOLD: c})) for i, c in enumerate(self.thresholds)]
        for i, jnd, scene in asked:
            plane = rectangles(scene, self.free, self._window, asked_of(scene, self.free, **self.options))
            if plane:
                yield Proof(TRANSPARENT, i, jnd, plane, self._window[1])

    def _of_stable(self) -> Iterator[Proof]:
        if STABLE in self.wanted and (plane := held_rectangles(self.scene, self.free, self._window)):
            yield Proof(STABLE, self._set(STABLE), None, plane, self._window[1])

    def _set(self, name: str) -> int:
        """The number of what is asked among the sets of a slice."""
        return 1 + self.wanted.index(name) if len(self.wanted) > 1 else 0

    @property
    def _window(self) -> tuple[tuple[Expr, Expr], tuple[Expr, Expr]]:
        """Both ranges, as far as the rules of the parameters allow."""
        one, other = (domain(x, pair) for x, pair in zip(self.free, self.ranges, strict=True))
        ends = one.low, one.high, other.low, other.high
        a, b, c, d = (x for x in ends if x is not None)  # a map has ranges
        return (a, b), (c, d)

    def cut_all(self, plan: Plan, budget: Budget) -> tuple[Slice, ...]:
        """All slices; one that is slow leaves time to the others."""
        low, high = self.ranges[0]

        def cut(at: Expr, n: int) -> Slice:
            budget.say(n, plan.most, "slices")
            with share(1 / min(len(start) - n, 2) if n < len(start) else 1 / 2):
                return self.cut(at)

        places = even(low, high, plan.most) if plan.within is None else first_places(low, high, plan.most)
        start = [at for at in places if self.free[0].rule.allows(at)]
        found = [cut(at, n) for n, at in enumerate(start)]
        if plan.within is not None:
            one, other = (float(b - a) for a, b in self.ranges)
            found = refined(found, cut, budget, plan.most, (one, other), float(plan.within))
        return tuple(found)


def _thresholds(scene: Scene, free: Sequence[Knob], jnd: Sequence[Number], wanted: Sequence[str]) -> tuple[Expr, ...]:
    """The further thresholds, each once. SceneError where nothing is asked of what is noticed, or the threshold is free."""
    if not jnd:
        return ()
    if TRANSPARENT not in wanted:
        raise SceneError("jnd: further thresholds are of what is noticed: ask for transparent too, or leave them out")
    for x in (x for x in free if x.parts):
        raise SceneError(f"jnd: further thresholds and {x.path}, which is free, say the same: leave out one of them")
    if scene.threshold.region.corners:
        raise SceneError("jnd: the scene's threshold is a polygon, which is given by its corners and not by one number")
    knob = scene.knobs[THRESHOLD]
    for c in jnd:
        knob.check(c)
    return tuple(dict.fromkeys(knob.number(c) for c in jnd))
