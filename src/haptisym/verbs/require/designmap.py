"""Design charts: where in the plane of two parameters what is asked holds, by exact slices and what
is proven between them. Begin with ``design_map``.

*Slices.* A slice is the exact requirement on the second parameter at a value of the first: few to
begin with, more where the boundary bends, or where its kind changes. Between slices the chart draws
straight lines. How far these are off is estimated from how ends bend from slice to slice.

*Rectangles.* What is proven all over the plane are rectangles in which conditions are kept, or
broken, in Taylor models. For transparency one is broken where a condition is broken at one
frequency for all of its values, and kept where every condition is kept on all of the band for all
of them. What shows neither is cut along what changes more, down to 1/256 of both ranges. For
stability in a hand roots are counted (``held_plane``), down to 1/512. From the rectangles follows a
proven bound on how far from the straight lines anything else may be (``Proof.bounds``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

from sympy import Dummy, Expr, Rational

from haptisym.judge.answers import Answer
from haptisym.judge.bindings import IN_HANDS, STABLE, Kind
from haptisym.judge.crossings import Criterion
from haptisym.judge.excess import Box, Side, excess_of
from haptisym.kernel.arrays import np
from haptisym.kernel.budget import SECONDS, Budget, Told, limited, share, spared
from haptisym.kernel.errors import HaptisymError, SceneError, several
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import RealNumber, whole
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import sign_of_number
from haptisym.kernel.sets import combined
from haptisym.kernel.where import Array, search
from haptisym.model.catalogue import Hand
from haptisym.model.jnd import Part
from haptisym.model.quantities import Dimension, Number, number
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.model.scenefile import as_scene
from haptisym.model.valueranges import domain
from haptisym.verbs.require.classical import (
    DAMPING,
    STIFFNESS,
    Encoder,
    StiffnessBound,
    lines,
    need_encoder,
)
from haptisym.verbs.require.freeparameter import (
    asked_of,
    conditions,
    edge_polynomial,
    pieces,
    touch_polynomial,
)
from haptisym.verbs.require.hands import with_hands
from haptisym.verbs.require.required import (
    SUITS_ALL,
    TRANSPARENT,
    Requirement,
    further,
    require,
    wishes,
)
from haptisym.verbs.stability.ranges import grid, held_plane, wider_than


@dataclass(frozen=True)
class Slice:
    """The exact ``requirement`` on the second parameter where the first one is ``at`` a value.

    ``apart`` : of several things asked, that on each alone. ``contours`` : that on what is noticed
    with each of the further thresholds.
    """

    at: Expr
    requirement: Requirement
    apart: tuple[Requirement, ...] = ()
    contours: tuple[Requirement, ...] = ()

    @classmethod
    def of(cls, at: Expr, apart: Sequence[Requirement], contours: Sequence[Requirement]) -> Slice:
        """The slice from the requirements on each thing asked: all of them must hold."""
        one = apart[0]
        if len(apart) == 1:
            return cls(at, one, (), tuple(contours))
        both = combined([x.values for x in apart])
        names = tuple(name for x in apart for name in x.that)
        criteria = tuple(y for x in apart for y in x.criteria)
        # The first one stands for all: they share scene, parameter and range.
        found = replace(one, values=both, criteria=criteria, that=names)
        return cls(at, found, tuple(apart), tuple(contours))

    @property
    def sets(self) -> tuple[Requirement, ...]:
        """All of its sets: what is asked together, each thing alone, each further threshold."""
        return self.requirement, *self.apart, *self.contours

    @cached_property
    def place(self) -> float:
        """The value of the first parameter as a float."""
        return float(self.at)

    @cached_property
    def ends(self) -> tuple[tuple[_End, ...] | None, ...]:
        """For each of its sets the ends of all intervals, in order; None where something was left
        undecided."""
        return tuple(None if r.undecided else tuple(_ends(r)) for r in self.sets)


@dataclass(frozen=True)
class _End:
    """An end of an interval as a double, and what binds there."""

    value: float
    binds: frozenset[tuple[str, Kind]]


def _ends(r: Requirement) -> Iterator[_End]:
    """The ends of a requirement's intervals, two for each."""
    for piece in r.feasible:
        for end in (piece.first, piece.last):
            # A map has a range, so that no interval is without an end.
            assert end is not None
            binds = frozenset((b.criterion.name, b.kind) for b in end.bindings)
            yield _End(float(end.value), binds)


@dataclass(frozen=True)
class Gap:
    """What lies between two neighbouring slices, from ``low`` to ``high``; ``deviation`` : that of
    the sets' boundaries from straight lines, estimated.

    None where no lines join the slices, which differ in how many intervals their sets have, or
    where something is undecided.
    """

    low: float
    high: float
    deviation: float | None


def gaps(slices: Sequence[Slice]) -> tuple[Gap, ...]:
    """What lies between each two slices, in order.

    A line between two points of a function is off by at most h^2/8 times its second derivative.
    That is estimated by the divided differences with the next slices on either side: an estimate,
    which knows nothing of what slices do not show. Where what binds changes, the boundary has a
    corner, and is taken to be off by what such a corner may be.
    """
    return tuple(
        Gap(a.place, b.place, _deviation(i, slices)) for i, (a, b) in enumerate(pairwise(slices))
    )


def _deviation(i: int, slices: Sequence[Slice]) -> float | None:
    """The estimated deviation between one slice and the next, the largest of all sets; None where
    one set has none."""
    found = [_of_set(i, k, slices) for k in range(len(slices[i].sets))]
    known = [x for x in found if x is not None]
    return max(known, default=0.0) if len(known) == len(found) else None


def _of_set(i: int, k: int, slices: Sequence[Slice]) -> float | None:
    """The estimated deviation of the k-th set between slice i and the next."""
    here, there = slices[i].ends[k], slices[i + 1].ends[k]
    if here is None or there is None or len(here) != len(there):
        return None
    most = 0.0
    for j, (a, b) in enumerate(zip(here, there, strict=True)):
        # Nothing binds where the range itself ends: that line is exact.
        if not (a.binds or b.binds):
            continue
        step = slices[i + 1].place - slices[i].place
        bend = _bent(i, k, j, slices)
        # h^2/8 f'' with the second divided difference, f''/2, is h^2/4 of that; four times as much
        # where what binds changes, as there is a corner.
        off = (
            abs(b.value - a.value)
            if bend is None
            else bend * step**2 / (4 if a.binds == b.binds else 1)
        )
        most = max(most, off)
    return most


def _bent(i: int, k: int, j: int, slices: Sequence[Slice]) -> float | None:
    """The second divided difference of the j-th end about the gap i, the larger of those to both
    sides; next to an end of the map, with what it would change by if it went on changing."""
    before, after = (_bend(first, k, j, slices) for first in (i - 1, i))
    if before is not None and after is not None:
        return max(abs(before), abs(after))
    known, beyond = (
        (before, _bend(i - 2, k, j, slices))
        if after is None
        else (after, _bend(i + 1, k, j, slices))
    )
    return None if known is None else abs(known) + (0.0 if beyond is None else abs(known - beyond))


def _bend(first: int, k: int, j: int, slices: Sequence[Slice]) -> float | None:
    """The second divided difference of one end over three slices; None where there are none, or
    they differ in kind."""
    if first < 0 or first + 2 >= len(slices):
        return None
    rows = [slices[first + n].ends[k] for n in range(3)]
    if any(row is None or len(row) != len(rows[0] or ()) for row in rows):
        return None
    (x, y, z), (u, v, w) = (
        [slices[first + n].place for n in range(3)],
        [row[j].value for row in rows if row is not None],
    )
    return ((w - v) / (z - y) - (v - u) / (y - x)) / (z - x)


# Slices to begin with: what lies between two of them and shows on none is not seen.
_FIRST = 9
# Gaps that are so many times better than the worst one wait: with more slices beside them they may
# prove to be good.
_WORST = 8


def even(low: Expr, high: Expr, count: int) -> list[Expr]:
    """That many evenly spaced places, both ends included."""
    return [low + (high - low) * i / (count - 1) for i in range(count)]


def first_places(low: Expr, high: Expr, most: int) -> list[Expr]:
    """The places to begin with."""
    return even(low, high, min(_FIRST, most))


def refined(
    found: list[Slice],
    cut: Callable[[Expr, int], Slice],
    budget: Budget,
    most: int,
    size: tuple[float, float],
    share: float,
) -> list[Slice]:
    """Slices refined by halving gaps, until lines between them are off by no more than a share of
    the range, as estimated.

    Slices that differ in kind are to be no further from each other than that share of the first
    range. ``size`` : of both ranges. It ends at ``most`` slices, and where the time is over.
    """
    while len(found) < most and not budget.reached:
        with spared():
            worst = _worst(found, size, share)[: most - len(found)]
        if not worst:
            break
        more = list[Slice]()
        for i in worst:
            more.append(cut((found[i].at + found[i + 1].at) / 2, len(found) + len(more)))
            if budget.reached:  # what could be told apart is
                break
        found = sorted([*found, *more], key=lambda x: x.place)
    return found


def _worst(found: Sequence[Slice], size: tuple[float, float], share: float) -> list[int]:
    """The gaps that are worth a slice, the worst first."""
    scores = [
        (gap.high - gap.low) / size[0] if gap.deviation is None else gap.deviation / size[1]
        for gap in gaps(found)
    ]
    for i, (a, b) in enumerate(pairwise(found)):
        # Beside an undecided slice another one would stay undecided too.
        if None in (*a.ends, *b.ends):
            scores[i] = 0.0
    limit = max(share, max(scores, default=0.0) / _WORST)
    return sorted(
        (i for i, x in enumerate(scores) if x > share and x >= limit), key=lambda i: -scores[i]
    )


# Pieces of the band to begin with.
_PIECES = 16
# Shares of both ranges down to which rectangles are cut, for what is noticed and for hands.
_FINEST_PLANE, _FINEST_HELD = 2.0**-8, 2.0**-9
# Cells of band and plane that are looked at.
_MOST_PLANE = 60_000


@dataclass(frozen=True, eq=False, repr=False)
class Rectangles(Shown):
    """Rectangles that fill a plane, (rectangles, 2, 2): from where to where, of each parameter, SI.

    ``kept`` : conditions are kept for all of their values; ``broken`` : for none; ``left`` :
    neither was shown.
    """

    kept: Array
    broken: Array
    left: Array

    def _line(self) -> str:
        return f"{len(self.kept)} kept, {len(self.broken)} broken, {len(self.left)} undecided"

    @property
    def parts(self) -> tuple[Array, Array, Array]:
        """All three."""
        return self.kept, self.broken, self.left

    @property
    def share_left(self) -> float:
        """The share of the area about which nothing is proven."""
        areas = [float((x[..., 1] - x[..., 0]).prod(-1).sum()) for x in self.parts]
        return areas[2] / sum(areas)


def rectangles(
    scene: Scene,
    free: tuple[Knob, Knob],
    ranges: Sequence[tuple[Expr, Expr]],
    criteria: Sequence[Criterion],
) -> Rectangles | None:
    """The plane of two parameters in rectangles in which criteria are kept, or broken; None where
    a criterion has no bounds in floats."""
    try:
        box = _Plane(
            scene, tuple(Side(x.name, *pair) for x, pair in zip(free, ranges, strict=True))
        )
        if not _is_modelled(box, free, criteria):
            return None
        excesses = [excess_of(box, x) for x in criteria]
    except HaptisymError:
        return None
    judges, steps = [x.curve for x in excesses if not x.is_zero], np.arange(_PIECES + 1) / _PIECES
    band = np.stack([steps[:-1], steps[1:]], -1)[:, None]
    found = search(
        judges, grid(), band, wide=wider_than(_FINEST_PLANE), most=_MOST_PLANE, what="rectangles"
    )
    return _placed(ranges, *(x.outer for x in found.parts))


def held_rectangles(
    scene: Scene, free: tuple[Knob, Knob], ranges: Sequence[tuple[Expr, Expr]]
) -> Rectangles | None:
    """The plane of two parameters in rectangles in which a display is stable in all hands of a
    scene, or not; None where nothing is known of it."""
    # A threshold moves no root: a symbol that is nowhere in the loop stands for it.
    symbols = [Dummy() if x.parts else x.symbol for x in free]
    try:
        found = held_plane(
            scene,
            scene.hands,
            dict(zip(symbols, ranges, strict=True)),
            finest=_FINEST_HELD,
            most=2 * _MOST_PLANE,
        )
    except HaptisymError:
        return None
    return _placed(ranges, found.stable, found.unstable, found.left)


def common(planes: Sequence[Rectangles]) -> Array:
    """Rectangles that fill what is kept in all of several planes of the same ranges.

    On the grid of the finest cut, of which all rectangles are made: exact, without polygons.
    """
    count = round(1 / _FINEST_HELD)
    every = np.ones((count, count), bool)
    cells = np.concatenate(planes[0].parts)
    low, high = cells[..., 0].min(0), cells[..., 1].max(0)
    for plane in planes:
        own = np.zeros_like(every)
        shares = (plane.kept - low[:, None]) / (high - low)[:, None] * count
        for (a, b), (c, d) in np.rint(shares).astype(int):
            own[a:b, c:d] = True
        every &= own
    steps = np.linspace(low, high, count + 1)
    rows = [
        [steps[[i, i + 1], 0], steps[[a, b], 1]]
        for i, row in enumerate(every)
        for a, b in _runs(row)
    ]
    return np.array(rows).reshape(-1, 2, 2)


def _runs(row: Array) -> list[tuple[int, int]]:
    """The runs of True in a row, as first index and one past the last."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))


def _placed(ranges: Sequence[tuple[Expr, Expr]], *shares: Array) -> Rectangles:
    """Rectangles in the units of both ranges, from their shares of these."""
    lows, widths = (
        np.array(x)[:, None]
        for x in ([float(a) for a, _ in ranges], [float(b - a) for a, b in ranges])
    )
    return Rectangles(*(lows + widths * x for x in shares))


@dataclass(frozen=True)
class _Plane(Box):
    """A box of two sides."""

    pair: tuple[Side, ...] = ()

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        return self.pair


def _is_modelled(box: Box, free: Sequence[Knob], criteria: Sequence[Criterion]) -> bool:
    """Whether all criteria are of the JND and can be bounded in floats, with any free threshold a
    plain number."""
    if any(x.is_of_hand for x in free) or not all(x.part or x.region for x in criteria):
        return False
    limits = [x for x in free if x.parts]
    if not limits:
        return True
    plain = all(x.region is None and not x.threshold.has(omega) for x in criteria)
    return plain and all(
        box.part_name(x.part) == limit.name
        for x in criteria
        for limit in limits
        if x.part and x.part in limit.parts
    )


# More than rounding adds to a bound, relatively; and within what share of a range's end a value is
# that end.
_ROUNDING, _SAME = 1e-9, 1e-12


@dataclass(frozen=True, repr=False)
class Proof(Shown):
    """What is proven of one set of a map, all over its plane: rectangles inside and outside of it,
    and those undecided.

    ``of`` : what was asked; ``set`` : its number among the sets of a slice; ``jnd`` : the
    threshold, where it is not the scene's;
    ``window`` : the range of the second parameter.
    """

    of: str
    set: int
    jnd: Expr | None
    rectangles: Rectangles
    window: tuple[Expr, Expr]

    def _line(self) -> str:
        return f"{self.of}: {self.rectangles}"

    def bounds(self, slices: Sequence[Slice]) -> tuple[float | None, ...]:
        """For each gap, how far from the lines that join its slices the set may differ from what
        these enclose: a proven bound, in units of the second parameter.

        None where slices differ in kind, or where something else is possible that no line is near.
        """
        rows = [(x.place, x.sets[self.set]) for x in slices]
        return tuple(self._bound((a, b), x, y) for (a, x), (b, y) in pairwise(rows))

    def _bound(self, at: tuple[float, float], one: Requirement, other: Requirement) -> float | None:
        """The bound between two slices ``at`` two values of the first parameter.

        A kept rectangle may lie outside of the lines' intervals, by its ``distance``; a broken one
        inside, by its ``depth``; one that stays open may be either.
        """
        if one.undecided or other.undecided or len(one.feasible) != len(other.feasible):
            return None
        edges = float(self.window[0]), float(self.window[1])
        low, high = (_ends_in_proven(one, other, name) for name in ("low", "high"))
        # An interval that ends with the range has no boundary there: nothing kept is outside of
        # it, and nothing broken is less deep for its end. Of open ones the range's end counts too.
        unbounded = _unbounded(low, edges[0], -np.inf), _unbounded(high, edges[1], np.inf)
        everywhere = (-np.inf, np.inf)
        kept, broken = (
            _Between(*_within(x, *at), *unbounded, everywhere) for x in self.rectangles.parts[:2]
        )
        left = _Between(*_within(self.rectangles.left, *at), low, high, edges)
        bound = max(kept.distance, broken.depth, left.distance, left.depth)
        return bound * (1 + _ROUNDING) if np.isfinite(bound) else None


@dataclass(frozen=True, eq=False)
class _Between:
    """Rectangles between two slices, cut off there, and the lines that join the ends of intervals
    on these.

    ``shares`` : (rectangles, 2), of the way from slice to slice; ``values`` : (rectangles, 2), of
    the second parameter.
    """

    shares: Array
    values: Array
    lows: Array
    highs: Array
    edges: tuple[float, float]

    def _most(self, found: Array) -> float:
        """The largest of some lengths, one for each rectangle; at an end of the range a rectangle
        counts no more than its own height."""
        is_there = (self.values <= self.edges[0]).any(-1) | (self.values >= self.edges[1]).any(-1)
        reached = np.where(is_there, self.values[:, 1] - self.values[:, 0], np.inf)
        return float(np.minimum(found, reached).max(initial=0.0))

    @property
    def distance(self) -> float:
        """The largest distance of any of their points from all intervals."""
        # Lines are straight: over a rectangle each is farthest from it at one of its two sides.
        below = self._at(self.lows).max(-1) - self.values[:, :1]
        above = self.values[:, 1:] - self._at(self.highs).min(-1)
        return self._most(np.maximum(np.maximum(below, above), 0.0).min(-1, initial=np.inf))

    @property
    def depth(self) -> float:
        """The largest distance by which any of their points is inside of an interval, from its
        nearer end."""
        over = self.values[:, 1:] - self._at(self.lows).min(-1)
        under = self._at(self.highs).max(-1) - self.values[:, :1]
        return self._most(np.maximum(np.minimum(over, under), 0.0).max(-1, initial=0.0))

    def _at(self, lines: Array) -> Array:
        """The lines where the rectangles begin and end, (rectangles, lines, 2)."""
        start, end = lines[None, :, :1], lines[None, :, 1:]
        with np.errstate(invalid="ignore"):
            found = start + (end - start) * self.shares[:, None]
        return np.where(np.isinf(start) & np.isinf(end), start, found)


def _within(cells: Array, a: float, b: float) -> tuple[Array, Array]:
    """The rectangles that reach between two values of the first parameter, cut off there: their
    shares of the way, and their values of the second one."""
    between = cells[(cells[:, 0, 0] < b) & (cells[:, 0, 1] > a)]
    return (np.clip(between[:, 0], a, b) - a) / (b - a), between[:, 1]


def _ends_in_proven(one: Requirement, other: Requirement, name: str) -> Array:
    """One end of each interval on both slices, (intervals, 2)."""
    rows = [[float(getattr(x, name)) for x in own.feasible] for own in (one, other)]
    return np.array(rows).reshape(2, -1).T


def _unbounded(ends: Array, edge: float, beyond: float) -> Array:
    """Ends of intervals on two slices, as infinite where they are the end of the range on both."""
    return np.where((np.abs(ends - edge) <= _SAME * abs(edge)).all(-1, keepdims=True), beyond, ends)


_RANGES = "give one for each of the two, as [(60, 200), (0.1, 1)]"
# The largest share of the time that rectangles may take.
_FOR_PROOFS = 0.3


@dataclass(frozen=True)
class Plan:
    """At most that many slices, lines between them to be off by a share of the second range; evenly
    placed if it is None."""

    most: int
    within: Expr | None

    def __post_init__(self) -> None:
        # Lines need two slices at least.
        whole("slices", self.most, 2)


def share_of(given: Number) -> Expr:
    """The exact number; SceneError unless it is one, and positive."""
    found = number(given, Dimension.RATIO).value
    if sign_of_number(found) <= 0:
        raise SceneError(
            f"within: {given} must be > 0, a share of the range of the second parameter"
        )
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
        cls,
        scene: Scene,
        paths: Sequence[str],
        ranges: Sequence[tuple[Number, Number]],
        options: Mapping[str, Any],
        wanted: tuple[str, ...],
        jnd: Sequence[Number],
    ) -> Asked:
        """SceneError where paths, ranges or thresholds are not fit."""
        first, second = scene.knobs.chosen(paths)
        scene.knobs.need_numbers((first, second))
        judged = asked_of(scene, (first, second), **options) if TRANSPARENT in wanted else ()
        if len(several("ranges", ranges, _RANGES)) != 2:
            raise SceneError(f"ranges: {len(ranges)} will not do: {_RANGES}")
        across, along = (
            (free.number(a), free.number(b))
            for free, (a, b) in zip((first, second), ranges, strict=True)
        )
        for free, pair in zip((first, second), (across, along), strict=True):
            # Checks the range; what it returns is made anew where it is needed.
            domain(free, pair)
        thresholds = _thresholds(scene, (first, second), jnd, wanted)
        criteria = (*judged, *further(scene, wanted))
        return cls(scene, (first, second), (across, along), wanted, criteria, thresholds, options)

    def cut(self, at: Expr) -> Slice:
        """The slice at a value of the first parameter."""
        here, path, along = self.free[0].put(self.scene, at), self.free[1].path, self.ranges[1]
        apart = [
            require(here, path, along, that=[x], limit=None, **self.options) for x in self.wanted
        ]
        others = (here.with_values({THRESHOLD: x}) for x in self.thresholds)
        return Slice.of(
            at, apart, [require(x, path, along, limit=None, **self.options) for x in others]
        )

    def proofs(self) -> tuple[Proof, ...]:
        """What is proven all over the plane: of what is transparent, with each threshold, and of
        what is stable."""
        with share(_FOR_PROOFS):
            found = [*self._of_transparent(), *self._of_stable()]
        return tuple(x for x in found if x.rectangles.share_left < 1)

    def _of_transparent(self) -> Iterator[Proof]:
        if TRANSPARENT not in self.wanted:
            return
        # The sets of a slice, in order: what is asked together, each alone if it is several, the
        # contours.
        first = 1 + len(self.wanted) if len(self.wanted) > 1 else 1
        asked: list[tuple[int, Expr | None, Scene]] = [(self._set(TRANSPARENT), None, self.scene)]
        asked += [
            (first + i, c, self.scene.with_values({THRESHOLD: c}))
            for i, c in enumerate(self.thresholds)
        ]
        for i, jnd, scene in asked:
            plane = rectangles(
                scene, self.free, self._window, asked_of(scene, self.free, **self.options)
            )
            if plane:
                yield Proof(TRANSPARENT, i, jnd, plane, self._window[1])

    def _of_stable(self) -> Iterator[Proof]:
        if STABLE in self.wanted and (
            plane := held_rectangles(self.scene, self.free, self._window)
        ):
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
            # At most half of the time that is left, but for the last slice to begin with.
            with share(1 / min(len(start) - n, 2) if n < len(start) else 1 / 2):
                return self.cut(at)

        places = (
            even(low, high, plan.most)
            if plan.within is None
            else first_places(low, high, plan.most)
        )
        start = [at for at in places if self.free[0].rule.allows(at)]
        found = [cut(at, n) for n, at in enumerate(start)]
        if plan.within is not None:
            one, other = (float(b - a) for a, b in self.ranges)
            found = refined(found, cut, budget, plan.most, (one, other), float(plan.within))
        return tuple(found)


def _thresholds(
    scene: Scene, free: Sequence[Knob], jnd: Sequence[Number], wanted: Sequence[str]
) -> tuple[Expr, ...]:
    """The further thresholds, each once. SceneError where nothing is asked of what is noticed, or
    the threshold is free."""
    if not jnd:
        return ()
    if TRANSPARENT not in wanted:
        raise SceneError(
            "jnd: further thresholds are of what is noticed: ask for transparent too, or "
            "leave them out"
        )
    for x in (x for x in free if x.parts):
        raise SceneError(
            f"jnd: further thresholds and {x.path}, which is free, are the same: leave out "
            f"one of them"
        )
    if scene.threshold.region.corners:
        raise SceneError(
            "jnd: the scene's threshold is a polygon, which is given by its corners and not "
            "by one number"
        )
    knob = scene.knobs[THRESHOLD]
    for c in jnd:
        knob.check(c)
    return tuple(dict.fromkeys(knob.number(c) for c in jnd))


@dataclass(frozen=True, repr=False)
class DesignMap(Answer):
    """The values of two parameters for which a scene is transparent, or what else is asked: exact
    along slices.

    ``slices`` : in ascending order of the first parameter, each with its value ``at`` and the
    ``Requirement`` of the second there.
    ``gaps`` : how far straight lines between slices are off, estimated; ``within`` : what that was
    to be, a share of the second range.
    ``proofs`` : of each criterion for which that is known, what is proven between the slices too.
    """

    _schema: ClassVar[str] = "haptisym.designmap/1"
    _page: ClassVar[str] = "haptisym.pages.require:page_map"
    _figure: ClassVar[str] = "haptisym.figures.requirement:DESIGN_MAP"

    scene: Scene
    free: tuple[Knob, Knob]
    ranges: tuple[tuple[Expr, Expr], tuple[Expr, Expr]]
    slices: tuple[Slice, ...]
    criteria: tuple[Criterion, ...] = ()
    that: tuple[str, ...] = (TRANSPARENT,)
    thresholds: tuple[Expr, ...] = ()
    encoder: Encoder | None = None
    within: Expr | None = None
    proofs: tuple[Proof, ...] = ()

    def _line(self) -> str:
        first, second = (x.path for x in self.free)
        return (
            f"{titled(self.scene.title)}: {second} over {first}, "
            f"{counted(len(self.slices), 'slice')}"
        )

    @property
    def certified(self) -> bool:
        """Whether all slices are."""
        return all(r.certified for x in self.slices for r in (x.requirement, *x.contours))

    @cached_property
    def gaps(self) -> tuple[Gap, ...]:
        """What lies between neighbouring slices, and how far lines between them are off, as
        estimated."""
        return gaps(self.slices)

    @property
    def deviation(self) -> float | None:
        """The largest estimate of all, in units of the second parameter; None where no slices are
        joined by lines."""
        return max((x.deviation for x in self.gaps if x.deviation is not None), default=None)

    @cached_property
    def bounds(self) -> dict[Proof, tuple[float | None, ...]]:
        """For each proof, the bound on how far off lines may be in each gap; None where no lines
        join the slices."""
        return {x: x.bounds(self.slices) for x in self.proofs}

    def bound(self, proof: Proof) -> float | None:
        """The largest bound of a proof, in units of the second parameter; None where no slices are
        joined by lines."""
        return max((x for x in self.bounds[proof] if x is not None), default=None)

    @property
    def height(self) -> float:
        """The width of the second parameter's range."""
        low, high = self.ranges[1]
        return float(high - low)

    @property
    def is_coarse(self) -> bool:
        """Whether the slices were too few for what their lines were to be off by."""
        return (
            self.within is not None
            and self.deviation is not None
            and self.deviation > float(self.within) * self.height
        )

    def curves(self) -> dict[tuple[Criterion, Kind], Expr]:
        """Polynomials in both parameters (and pi) that vanish on the boundary: at the band's ends,
        and the discriminants.

        Every point of the boundary is a zero of one of them. SceneError for scenes with delays or
        powers of s. Those of touches are large for devices of order 4 and more.
        """
        judged = [x for x in self.criteria if x.name not in (*IN_HANDS, SUITS_ALL)]
        found = {x: pieces(own) for x, own in conditions(self.scene, self.free, judged).items()}
        curves = dict[tuple[Criterion, Kind], Expr]()
        for x, functions in found.items():
            for kind, end in zip((Kind.START, Kind.EDGE), self.scene.band, strict=True):
                curves[x, kind] = edge_polynomial(functions, end)
        for x, functions in found.items():
            curves[x, Kind.TOUCH] = touch_polynomial(functions)
        return curves

    @cached_property
    def lines(self) -> tuple[StiffnessBound, ...]:
        """The classical bounds on a stiffness for which the scene has what they need, where
        stability is asked."""
        return lines(self.scene, self.free, self.encoder) if STABLE in self.that else ()

    @property
    def stiffest(self) -> tuple[Slice, RealNumber] | None:
        """The slice along a wall's damping that is stable up to the largest stiffness, and that
        stiffness; None if it is beyond the range, or undecided."""
        if STABLE not in self.that or [x.path for x in self.free] != [DAMPING, STIFFNESS]:
            return None
        i = self.that.index(STABLE)
        held = [(x, (x.apart or (x.requirement,))[i]) for x in self.slices]
        if any(r.undecided for _, r in held):
            return None
        tops = [(x, r.feasible[-1].last) for x, r in held if r.feasible]
        # An end without a binding is the range's: the slice may be stable further up.
        if not all(end and end.bindings for _, end in tops):
            return None
        heights = ((x, end.value) for x, end in tops if end)
        return max(heights, key=lambda row: float(row[1]), default=None)

    @property
    def _varied(self) -> tuple[list[str], list[str]]:
        paths = [x.path for x in self.free]
        return paths, paths

    def _body(self) -> dict[str, Any]:
        return {
            "free": [x.path for x in self.free],
            "unit": [x.unit for x in self.free],
            "range": [[float(x) for x in pair] for pair in self.ranges],
            "band": [float(x) for x in self.scene.band],
            "condition": [x.name for x in self.criteria],
            "criteria": list(self.that),
            "slices": [
                {"at": float(x.at), **x.requirement.rows(), **_apart(x), **self._contours(x)}
                for x in self.slices
            ],
            **(
                {
                    "lines": [
                        {"name": x.name, "rule": x.rule, "assumes": x.assumes} for x in self.lines
                    ]
                }
                if self.lines
                else {}
            ),
            "between": [{"from": x.low, "to": x.high, "deviation": x.deviation} for x in self.gaps],
            "deviation": self.deviation,
            **({"proven": [self._proven(x) for x in self.proofs]} if self.proofs else {}),
            "certified": self.certified,
        }

    def _proven(self, x: Proof) -> dict[str, Any]:
        """What is proven of a set between the slices."""
        return {
            "of": x.of,
            "jnd": None if x.jnd is None else float(x.jnd),
            "open": x.rectangles.share_left,
            "bound": self.bound(x),
            "between": list(self.bounds[x]),
        }

    def _contours(self, x: Slice) -> dict[str, Any]:
        """The values for which nothing is noticed with other thresholds."""
        rows = [
            {"jnd": float(jnd), "feasible": r.spans(), "certified": r.certified}
            for jnd, r in zip(self.thresholds, x.contours, strict=True)
        ]
        return {"contours": rows} if rows else {}


def _apart(x: Slice) -> dict[str, Any]:
    """The rows of a document with the values for each of several things asked, alone."""
    if not x.apart:
        return {}
    return {"apart": {name: r.spans() for r in x.apart for name in r.that}}


WITHIN = Rational(1, 200)
"""What a map is refined to: lines between slices off by so much of the second range, as
estimated."""


def design_map(
    scene: Scene | str | Path,
    paths: Sequence[str],
    ranges: Sequence[tuple[Number, Number]],
    *,
    part: Part | None = None,
    any_environment: bool = False,
    that: Sequence[str] = (TRANSPARENT,),
    hand: str | Hand | None = None,
    jnd: Sequence[Number] = (),
    friction: Number | None = None,
    resolution: Number | None = None,
    slices: int = 41,
    within: Number | None = None,
    uniform: bool = False,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> DesignMap:
    """The transparent region in two parameters, by at most that many slices, more of them where its
    boundary bends.

    ``paths``: of both parameters; ``ranges``: of each, SI or with a unit. Every slice is a
    ``Requirement`` on the second one.
    ``within``: a share of the second range: slices are put in until straight lines between them are
    off by no more, as estimated, and slices that differ in kind no further apart than that share of
    the first range; 0.5 % if not given.
    ``uniform``: all slices, as far from each other, instead.
    ``that``, ``hand``, ``limit``, ``told``: as in ``require``; of slices that were not reached in
    time every value is undecided.
    ``jnd``: further thresholds, each with the region that is transparent with it. ``friction``,
    ``resolution``: of a device and its encoder, for Abbott and Okamura's bound next to the other
    classical ones.

    >>> from haptisym.model.scenefile import load_scene
    >>> found = design_map(load_scene("fu2019"), ["zeta", "omega_n"], [("0.4", "0.6"), (50, 500)], slices=3)
    >>> [x.requirement.feasible[0].low.digits(6) for x in found.slices]
    ['103.831', '122.356', '141.462']
    """
    plan = Plan(slices, None if uniform else WITHIN if within is None else share_of(within))
    wanted = wishes(that)
    scene = with_hands(as_scene(scene), hand) if {*IN_HANDS} & {*wanted} else as_scene(scene)
    asked = Asked.of(
        scene, paths, ranges, {"part": part, "any_environment": any_environment}, wanted, jnd
    )
    encoder = Encoder.of(scene, friction, resolution)
    need_encoder(scene, asked.free, encoder)
    with limited(limit, told) as budget:
        proofs = asked.proofs()
        found = asked.cut_all(plan, budget)
    return DesignMap(
        scene,
        asked.free,
        asked.ranges,
        found,
        asked.criteria,
        wanted,
        asked.thresholds,
        encoder,
        plan.within,
        proofs,
    )
