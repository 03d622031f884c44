"""What holds for a scene whose parameters are known as ranges: proven for all values in the box, or
for none.

Two things are kept apart. Proven: the verdict, by branch and bound over band and box in Taylor
models and by certified charts of single sets of values; the enclosures of the crossings. Estimated:
quantiles over sets drawn at random.

Cells in which the excess keeps its sign are left out, proven. What stays are leaves: crossings, at
which r equals its threshold, lie in them and nowhere else. Leaves that touch form a ``Cluster``.
Where the slope by omega keeps its sign on all of a cluster away from the ends of the band, every
crossing in it goes on through the whole box: the implicit function theorem continues it to all
values, and it cannot leave the cluster, whose surroundings hold none.

How far the crossings of a cluster go: where they are regular they move one way with each parameter
whose slope keeps its sign, so that they go farthest on the face of the box on which all these stand
at their ends. On that face the crossings take up less of the band, and there further slopes may
keep their signs: so it goes on, until a corner is left, which is answered exactly, or a face that
is bounded.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import ceil
from pathlib import Path
from random import Random
from typing import Any, ClassVar, TypeAlias, TypeVar

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, Judged, kept, noticed
from haptisym.judge.excess import Box, Excess, box_of, excess_of
from haptisym.kernel.budget import SECONDS, Budget, Told, limited, share, spared, tick
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.objects import counted, titled
from haptisym.kernel.reals import ExactNumber, RealNumber, rational, whole
from haptisym.kernel.roots import chart
from haptisym.kernel.where import Array, Batches, Cells, Columns, Search, halves, touching, zeros
from haptisym.model.catalogue import Hand
from haptisym.model.scene import Scene, in_hands
from haptisym.model.scenefile import as_scene
from haptisym.programs.taylormodels import TaylorModel
from haptisym.verbs.require.freeparameter import conditions, is_kept_anyway
from haptisym.verbs.stability.ranges import HeldInBox, held_in_box
from haptisym.verbs.sweep.entry import in_floats

_BATCH = 256  # cells that are bounded together
_MOST_CELLS = 3000  # that are examined for one part
# How often a cell is cut: then it is a leaf if crossings in it are regular, or move one way with
# each parameter: one of both is what ``Face`` or ``_greatest`` needs, and finer leaves cost time.
_MOST_SPLITS = 6
_MOST_BEYOND = 800  # cells that are examined for one end
# Shares of the band. Clusters nearer to each other are taken as one, so that a certified frequency,
# which is compared as a float, belongs to one of them without doubt.
_OVERLAP = 1e-8
_FIRST = 32  # pieces of the band to begin with
# Times narrower than another: such a side is not cut where nothing is known of a cell.
_NARROWER = 100


@dataclass(frozen=True)
class Cluster:
    """A connected set of leaves, the cells in which crossings may lie.

    ``cells`` : (cells, sides, 2) in shares of band and ranges. ``signs`` : of the slope along each
    side, the band first, on all of them; 0 where it is not the same or not known. ``low``,
    ``high``: bounds on the crossings in it, shares of the band.
    """

    cells: Array
    signs: tuple[int, ...]
    low: float
    high: float

    @property
    def regular(self) -> bool:
        """Whether the slope by omega keeps its sign in it, so that no two crossings merge."""
        return self.signs[0] != 0

    @property
    def inside(self) -> bool:
        """Whether its crossings keep clear of both ends of the band."""
        return self.clear_of(highest=False) and self.clear_of(highest=True)

    def clear_of(self, *, highest: bool) -> bool:
        """Whether its crossings keep clear of the high, or the low, end of the band."""
        return self.high < 1 if highest else self.low > 0


@dataclass(frozen=True)
class _Bounded:
    """What is proven of the excess over cells.

    ``signs`` : (cells, 1 + sides), of the value and of each slope, 0 where not known. ``omega`` :
    between which shares of the band crossings lie; ``split`` : the side to cut.
    """

    cells: Array
    signs: Array
    omega: Array
    split: Array


def clusters(excess: Excess, within: tuple[float, float] = (0, 1)) -> tuple[Cluster, ...]:
    """All clusters of one criterion, in ascending order of frequency: outside them r equals its
    threshold for no values, proven.

    ``within`` : between which shares of the band they are searched.
    """
    if excess.is_zero:
        return ()
    leaves = _leaves(excess, within)
    return tuple(_apart(_grouped(leaves))) if len(leaves.cells) else ()


def _grouped(leaves: _Bounded) -> list[Cluster]:
    """The connected sets of leaves, in ascending order of frequency."""
    label, connected = touching(leaves.cells), []
    for n in np.unique(label):
        members = _chosen(leaves, label == n)
        signs = members.signs[:, 1:]
        # a slope has a sign on the whole set where all leaves agree on it
        same = np.where((signs == signs[0]).all(0), signs[0], 0)
        low, high = float(members.omega[:, 0].min()), float(members.omega[:, 1].max())
        connected.append(Cluster(members.cells, tuple(map(int, same)), low, high))
    return sorted(connected, key=lambda x: x.low)


def _apart(found: list[Cluster]) -> Iterator[Cluster]:
    """Merge clusters whose frequencies overlap, so that a crossing's frequency identifies its
    cluster."""
    waiting = found[0]
    for x in found[1:]:
        if x.low > waiting.high + _OVERLAP:
            yield waiting
            waiting = x
            continue
        signs = tuple(a if a == b else 0 for a, b in zip(waiting.signs, x.signs, strict=True))
        waiting = Cluster(
            np.concatenate([waiting.cells, x.cells]), signs, waiting.low, max(waiting.high, x.high)
        )
    yield waiting


def _leaves(excess: Excess, within: tuple[float, float]) -> _Bounded:
    """The cells of band and ranges that are left when all others are proven to hold no crossing.

    Where the time is over, what still waits is among them, with nothing known of it.
    """
    first = np.tile([0.0, 1.0], (_FIRST, excess.sides, 1))
    first[:, 0] = sliding_window_view(np.linspace(*within, _FIRST + 1), 2)
    waiting = Batches(
        Columns((first, np.zeros(_FIRST, int))), size=_BATCH, what="cells of band and ranges"
    )
    kept: list[_Bounded] = []
    try:
        for cells, depths in waiting:
            bounds = bounded(excess, cells)
            unclear = _unclear(excess, bounds)
            # A parameter on which the excess does not depend has slope 0, which is no doubt about
            # its sign.
            steady = (bounds.signs[:, 2:] != 0)[:, excess.matters[1:]].all(-1)
            regular, tired = bounds.signs[:, 1] != 0, depths >= _MOST_SPLITS
            clear_of_ends = (bounds.omega[:, 0] > 0) & (bounds.omega[:, 1] < 1)
            # A cell with all signs known, clear of the ends, says all that is wanted. At the ends
            # of the band smaller cells may still show that no crossing leaves it, so that these are
            # cut further.
            enough = ((steady | regular) & tired) | (waiting.examined > _MOST_CELLS)
            leaf = unclear & ((steady & regular & clear_of_ends) | enough)
            kept.append(_chosen(bounds, leaf))
            rest = unclear & ~leaf
            waiting.add(
                Columns(
                    (halves(bounds.cells[rest], bounds.split[rest]), np.tile(depths[rest] + 1, 2))
                )
            )
    except LimitError:
        # of what waits nothing is known: crossings may be anywhere in it
        rest, _ = waiting.rest
        signs = np.zeros((len(rest), 1 + excess.sides), int)
        kept.append(_Bounded(rest, signs, rest[:, 0].copy(), signs[:, 0]))
    return _Bounded(
        *(
            np.concatenate([getattr(x, name) for x in kept])
            for name in ("cells", "signs", "omega", "split")
        )
    )


def _unclear(excess: Excess, found: _Bounded) -> Array:
    """Which cells may hold a zero of the excess: none that is > 0 at the corner where it is least,
    or < 0 where it is greatest."""
    unclear = found.signs[:, 0] == 0
    which = np.flatnonzero(unclear)
    if len(which):
        # Along a side with a slope of one sign the extremes are at its ends. The model over such a
        # face has fewer varying sides, and so a narrower bound than that over the cell.
        corners = [_corner(found.cells[which], found.signs[which, 2:], to) for to in (-1, 1)]
        low, high = (x[:, 0] for x in excess.model(np.concatenate(corners), slopes=0).bounds())
        unclear[which] = ~((low[: len(which)] > 0) | (high[len(which) :] < 0))
    return unclear


def _corner(cells: Array, signs: Array, to: int) -> Array:
    """Each cell with the parameters along which the excess is monotonic at the end where it is
    greatest (1) or least (-1)."""
    moved = cells.copy()
    at = np.where(signs * to > 0, cells[:, 1:, 1], cells[:, 1:, 0])
    moved[:, 1:] = np.where(signs[..., None] != 0, at[..., None], cells[:, 1:])
    return moved


def _chosen(x: _Bounded, which: Array) -> _Bounded:
    return _Bounded(x.cells[which], x.signs[which], x.omega[which], x.split[which])


def bounded(excess: Excess, cells: Array) -> _Bounded:
    """What is proven of the excess over cells, by Taylor models of its value and its slopes."""
    model = excess.model(cells)
    low, high = model.bounds()
    signs = np.where(low > 0, 1, np.where(high < 0, -1, 0))
    c0, c1, c2, r = (x[:, 0] for x in model.arrays)
    # what is not finite is unknown
    with np.errstate(all="ignore"):
        # At the middle frequency of a cell the model has no terms in omega: the value there is c0,
        # give or take what all parameters change. With bounds on the slope by omega a step of the
        # interval Newton method narrows where zeros can be.
        by_parameters = np.abs(c1[:, 1:]).sum(-1)
        by_pairs = np.abs(c2[:, 1:, 1:]).sum((-1, -2))
        rest = by_parameters + by_pairs + r
    omega = zeros(cells[:, 0], c0, rest, (low[:, 1], high[:, 1]))
    return _Bounded(cells, signs, omega, _widest(model, cells, signs, high - low))


def _widest(model: TaylorModel, cells: Array, signs: Array, spread: Array) -> Array:
    """The side of each cell along which the excess, and those of its slopes whose signs are open,
    change most."""
    width = cells[:, :, 1] - cells[:, :, 0]
    with np.errstate(all="ignore"):
        # Value and slopes have different units, so each counts by its share of its own spread.
        weight = np.where((signs == 0) & np.isfinite(spread), 1 / spread, 0.0)
        changes = np.abs(model.c1)
        changes[:, : model.c2.shape[1]] += np.abs(model.c2).sum(-1)
        known = weight[:, :1] > 0
        weighted = (weight[:, :, None] * changes).sum(1)
        score = np.where(known, weighted, changes[:, 0])
        # near a pole only the value's changes are known; but to go on cutting one side does not
        # help where another is too wide
        widest = width.max(-1, keepdims=True)
        score[~known & (width * _NARROWER < widest)] = 0.0
    is_finite = np.isfinite(score).all(-1, keepdims=True)
    is_useful = is_finite & (score > 0).any(-1, keepdims=True)
    # a side of no width cannot be cut, and loses against one of score 0
    choice = np.where(is_useful, score, width) + 1e-300
    return np.argmax(np.where(width > 0, choice, -1), -1)


def beyond(excess: Excess, cells: Array, reached: float, *, highest: bool) -> float:
    """A bound on how low (high) crossings in cells go, shares of the band; ``reached`` itself where
    it is proven that none goes beyond."""
    # the sign of the direction outward, with which both cases are one
    out = 1 if highest else -1
    near, far = (0, 1) if highest else (1, 0)

    def further(parts: Array) -> Array:
        """The parts of some cells that lie beyond what is reached."""
        parts = parts[out * (parts[:, 0, far] - reached) > 0].copy()
        parts[:, 0, near] = out * np.maximum(out * parts[:, 0, near], out * reached)
        return parts

    waiting = Batches(
        further(cells), size=_BATCH, rank=lambda x: -out * x[:, 0, far], most=_MOST_BEYOND + 1
    )
    # the farthest cells first: the bound is the farthest end of what is left at any time
    with suppress(LimitError):
        for cells_now in waiting:
            found = bounded(excess, cells_now)
            found = _chosen(found, _unclear(excess, found))
            narrowed = found.cells.copy()
            narrowed[:, 0, 0] = np.maximum(narrowed[:, 0, 0], found.omega[:, 0])
            narrowed[:, 0, 1] = np.minimum(narrowed[:, 0, 1], found.omega[:, 1])
            is_left = narrowed[:, 0, 0] <= narrowed[:, 0, 1]
            waiting.add(further(halves(narrowed[is_left], found.split[is_left])))
    left = waiting.rest
    return float(out * np.max(out * left[:, 0, far])) if len(left) else reached


@dataclass(frozen=True)
class One:
    """The certified answers for one set of values. ``crossings`` : by the names of criteria,
    without touches; ``transparent`` : on the whole band, None where that is undecided."""

    values: Mapping[str, Expr]
    crossings: Mapping[str, tuple[RealNumber, ...]]
    bandwidth: RealNumber | None
    transparent: bool | None

    @property
    def first(self) -> RealNumber | None:
        """The lowest crossing of any criterion, rad/s; None where there is none."""
        return min((x[0] for x in self.crossings.values() if x), key=float, default=None)


@dataclass(frozen=True)
class Drawn:
    """A set of values that was drawn at random: its first crossing and bandwidth in floats, rad/s,
    and on demand the exact answers."""

    box: Box
    values: Mapping[str, Expr]
    first: float | None
    bandwidth: float | None
    transparent: bool | None

    @cached_property
    def exact(self) -> One:
        """The certified answers for the same values."""
        return one(self.box, self.values)

    @property
    def crossings(self) -> Mapping[str, tuple[RealNumber, ...]]:
        """The certified crossings, as of ``One``."""
        return self.exact.crossings


def drawn(box: Box, samples: int, seed: int) -> tuple[Drawn, ...]:
    """Sets of values drawn uniformly from the box, each answered with certainty: in floats with a
    bound, or exactly."""
    draw = Random(seed)
    shares = (
        # Exact shares of 24 bits, both ends included: what is judged is then exactly what is named,
        # and floats of the values are at most an ulp from them.
        {side.name: Fraction(draw.getrandbits(24), (1 << 24) - 1) for side in box.sides}
        for _ in range(samples)
    )
    sets = [box.values(x) for x in shares]
    if not sets:
        return ()
    rows = np.array([[float(ExactNumber(x)) for x in values.values()] for values in sets]).T
    try:
        columns, left = in_floats(box.scene, tuple(box.scene.ranges().values()), rows)
    except LimitError:
        return ()
    names = [x.name for x in noticed(box.scene.threshold)]
    first = np.fmin.reduce([columns[f"first_crossing_{name}"] for name in names])
    crossings = np.sum([columns[f"crossings_{name}"] for name in names], axis=0)
    unknown = set(left.tolist())

    def answered(n: int) -> Drawn:
        tick(n, samples, "sets of values")
        if n in unknown:
            x = one(box, sets[n])
            return Drawn(box, sets[n], _float(x.first), _float(x.bandwidth), x.transparent)
        low, width = (
            None if np.isnan(x) else float(x) for x in (first[n], columns["bandwidth"][n])
        )
        # without a crossing a ratio keeps its sign: it is below where a bandwidth begins
        is_transparent = bool(crossings[n] == 0) and width is not None
        return Drawn(box, sets[n], low, width, is_transparent)

    return tuple(in_time(map(answered, range(samples))))


_T = TypeVar("_T")


def in_time(found: Iterable[_T]) -> Iterator[_T]:
    """The items that are computed before the time is over."""
    try:
        yield from found
    except LimitError:
        return


def one(box: Box, values: Mapping[str, Expr]) -> One:
    """The certified answers for one set of values out of the box."""
    scene = box.scene.with_values(values)
    d = scene.distortion()
    criteria = noticed(scene.threshold)
    table = chart({x: x.function(d) for x in criteria}, *scene.band)
    # At zeros of odd order, which change the sign. The implicit function theorem continues these
    # through a box; a touch vanishes or splits in two.
    crossings = {
        x.name: tuple(p.omega for p in table.points if (n := p.orders.get(x, 0)) > 0 and n % 2)
        for x in criteria
    }
    end = table.reach(kept(table))
    whole = end is table.points[-1].omega
    shown = values or {side.name: box.scene.knobs[side.name].value for side in box.sides}
    return One(shown, crossings, end, None if table.undecided else whole)


TOLERANCE = Fraction(1, 1000)
"""How far, relatively, an end that is not exact may lie beyond what is reached."""
# Corners that are answered exactly, as ends or to show what happens: all of six parameters.
MOST_CORNERS = 64

End: TypeAlias = tuple[RealNumber, Mapping[str, Expr] | None]
"""A frequency, rad/s, and the corner of the box at which it is reached; None if it is a bound."""


@dataclass(frozen=True)
class Face:
    """A face of a box of parameters: some sides stand at an end, the others vary.

    ``name`` : of the criterion; ``fixed``: 0 for sides at their low end, 1 for those at their high
    one; ``one``: gives the certified answers for a set of values of the whole box.
    """

    whole: Box
    name: str
    fixed: Mapping[str, Fraction]
    one: Callable[[Mapping[str, Expr]], One]

    @cached_property
    def box(self) -> Box:
        """The box of the parameters that still vary on the face."""
        return (
            Box(self.whole.scene.with_values(self._values(self.fixed)))
            if self.fixed
            else self.whole
        )

    @cached_property
    def form(self) -> Excess:
        """The excess of the criterion of that name on this face."""
        return excess_of(
            self.box, next(x for x in noticed(self.box.scene.threshold) if x.name == self.name)
        )

    def _values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        """The values of the named sides at shares of their ranges."""
        return {
            side.name: side.at(shares[side.name])
            for side in self.whole.sides
            if side.name in shares
        }

    def end(self, form: Excess, cluster: Cluster, *, highest: bool) -> End | None:
        """The highest (lowest) frequency of the crossings of a cluster on this face; None if it is
        proven that there is none."""
        # A regular crossing moves by d omega/dp = -F_p/F_omega, of one sign where both slopes have
        # one: it goes farthest at that end of p, whatever the other values are.
        moves = {
            x: n for x, n in self.moves(form, cluster, highest=highest).items() if n is not None
        }
        # beyond an end of the band a crossing is not seen, and need not be farthest at that corner
        settled = cluster.regular and cluster.clear_of(highest=highest)
        if settled and moves and len(moves) < len(self.box.sides):
            face = Face(self.whole, self.name, {**self.fixed, **moves}, self.one)
            try:
                on_face = clusters(face.form, (cluster.low, cluster.high))
            except LimitError:
                return self._bound(form, cluster, None, highest=highest)
            # the farthest first: the first one that holds a crossing has the end
            outward = reversed(on_face) if highest else on_face
            ends = (face.end(face.form, x, highest=highest) for x in outward)
            return next((x for x in ends if x), None)
        corners = list(in_time(self._corners(form, cluster, highest=highest)))
        reached = [
            (x, at.values)
            for at in corners
            for x in at.crossings[self.name]
            if within(self.whole, x, cluster)
        ]
        best = (max if highest else min)(reached, key=lambda x: float(x[0]), default=None)
        # all parameters lead to one corner; without a crossing there a cluster inside the band has
        # none anywhere
        if settled and corners and len(moves) == len(self.box.sides) and (best or cluster.inside):
            return best
        return self._bound(form, cluster, best, highest=highest)

    def moves(self, form: Excess, cluster: Cluster, *, highest: bool) -> dict[str, Fraction | None]:
        """For each side the end at which the crossings of a cluster are highest (lowest), None
        where that is not known."""
        way = -cluster.signs[0] * (1 if highest else -1)
        names = (x.name for x in self.box.sides)
        ends: dict[str, Fraction | None] = {}
        for name, used, sign in zip(names, form.matters[1:], cluster.signs[1:], strict=True):
            # where the excess does not depend on a parameter either end is as good
            is_known = way * sign or not used
            ends[name] = Fraction(int(way * sign > 0)) if is_known else None
        return ends

    def _corners(self, form: Excess, cluster: Cluster, *, highest: bool) -> Iterator[One]:
        """The corners at which crossings may be highest (lowest), each answered exactly."""
        moves = {**self.moves(form, cluster, highest=highest), **self.fixed}
        choices = [
            [x] if x is not None else [Fraction(0), Fraction(1)]
            for x in (moves[y.name] for y in self.whole.sides)
        ]
        names = [side.name for side in self.whole.sides]
        for _, shares in zip(range(MOST_CORNERS), product(*choices), strict=False):
            yield self.one(self._values(dict(zip(names, shares, strict=True))))

    def _bound(self, form: Excess, cluster: Cluster, best: End | None, *, highest: bool) -> End:
        """A bound on the end of the crossings of a cluster: close to what is reached at a corner,
        if anything is, else the end of its leaves."""
        low, high = self.whole.scene.band
        leaf = cluster.high if highest else cluster.low
        share = leaf
        if best:
            slack = float(TOLERANCE) * float(best[0]) * (1 if highest else -1)
            reached = (float(best[0]) + slack - float(low)) / float(high - low)
            share = beyond(form, cluster.cells, reached, highest=highest)
            # not into the frequencies of another cluster
            share = min(share, leaf) if highest else max(share, leaf)
        return at_share(self.whole, share), None


def at_share(box: Box, share: float) -> RealNumber:
    """A frequency that share of the way through the band."""
    low, high = box.scene.band
    exact = Fraction(min(max(share, 0.0), 1.0))
    return ExactNumber(low + rational(exact) * (high - low))


def within(box: Box, x: RealNumber, cluster: Cluster) -> bool:
    """Whether a crossing is one of those of a cluster."""
    low, high = box.scene.band
    # the digits of a certified zero take no time
    with spared():
        share = (float(x) - float(low)) / float(high - low)
    # The share is rounded, and clusters are more than ``_OVERLAP`` apart: a quarter of it to either
    # side holds all roundings, and no crossing of a neighbour.
    return cluster.low - _OVERLAP / 4 <= share <= cluster.high + _OVERLAP / 4


LEVELS = (5, 50, 95)


@dataclass(frozen=True)
class Quantiles:
    """Per cent to rad/s, of the first crossing and of the bandwidth; None where there is none in so
    many of the sets.

    ``transparent`` : how many of the sets are transparent on the whole band.
    """

    first: Mapping[int, float | None]
    bandwidth: Mapping[int, float | None]
    transparent: int


def quantiles(samples: Sequence[Drawn]) -> Quantiles:
    """The quantiles of an answer's samples, of which there must be one at least."""
    # a set without a crossing on the band has it beyond the band; one without a bandwidth has less
    # than any
    beyond, never = float("inf"), -float("inf")
    first = sorted(samples, key=lambda x: beyond if x.first is None else x.first)
    width = sorted(samples, key=lambda x: never if x.bandwidth is None else x.bandwidth)
    # the least value that so many per cent of the samples do not exceed
    places = {p: max(ceil(p * len(samples) / 100) - 1, 0) for p in LEVELS}
    # only the few that are printed are answered exactly
    return Quantiles(
        {p: _float(first[i].exact.first) for p, i in places.items()},
        {p: _float(width[i].exact.bandwidth) for p, i in places.items()},
        sum(x.transparent is True for x in samples),
    )


def _float(x: RealNumber | None) -> float | None:
    return None if x is None else float(x)


class BandVerdict(Enum):
    """Whether the display is transparent on the whole band."""

    ALL = "all"
    NONE = "none"
    DEPENDS = "depends"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Enclosure(Judged):
    """An interval in which crossings of a criterion lie for all values: from ``low`` to ``high``,
    rad/s, proven.

    ``count`` : how many there are for every set of values, touches apart; None if that depends or
    is not known. ``at_low``,
    ``at_high``: the corner of the box at which the end is reached, which then is exact; None for an
    end that is a bound only, at most ``TOLERANCE`` or what the budget allowed beyond.
    ``monotonic``: for each parameter 1 if the crossing grows with it throughout the box, -1 if it
    falls, 0 if neither is proven.
    """

    criterion: Criterion
    low: RealNumber
    high: RealNumber
    count: int | None
    at_low: Mapping[str, Expr] | None
    at_high: Mapping[str, Expr] | None
    monotonic: Mapping[str, int]


_SHARE = 0.4  # of the time that is left, for the first search of two
# shares of the ranges: narrower cells are not cut; pieces of the band behind all cells
_FINEST, _MOST_PIECES = 2.0**-12, 6000


@dataclass(frozen=True, repr=False)
class Tolerances(Answer):
    """The answers for a box of parameters.

    ``box`` : the parameters that vary, each with its range, SI. ``verdict`` : noticed by none, by
    some or by all of its members, or undecided; ``bandwidth`` : the smallest and the largest,
    rad/s; ``enclosures`` : of each crossing, the range it moves over, where it exists for all. All
    of these are proven.
    ``samples`` : members that were drawn for quantiles, at most ``count`` with ``seed``: estimates,
    on which nothing proven depends. ``held`` : of each hand, whether all members are stable in it.
    ``budget`` : what the search was allowed.

    >>> import haptisym as hs
    >>> found = hs.tolerances("fu2019-tolerances", samples=3)
    >>> [float(x) for x in found.bandwidth], len(found.samples)
    ([7.173627271034527, 12.873476301962626], 3)
    """

    _schema: ClassVar[str] = "haptisym.tolerances/1"
    _page: ClassVar[str] = "haptisym.pages.tolerances:page"
    _figure: ClassVar[str] = "haptisym.figures.stability:TOLERANCES"

    box: Box
    count: int = 0
    seed: int = 0
    budget: Budget | None = None
    held: tuple[HeldInBox, ...] = ()
    """For which values the display is stable in each hand of the scene."""

    def _line(self) -> str:
        sides = ", ".join(x.name for x in self.box.sides)
        found = counted(len(self.enclosures), "enclosure")
        return (
            f"{titled(self.box.scene.title)}: {sides} in their ranges, transparent for "
            f"{self.verdict.value}, {found}"
        )

    @property
    def _about(self) -> Scene:
        return self.box.scene

    @property
    def _varied(self) -> tuple[Collection[str], Collection[str]]:
        ranges = self.box.scene.ranges()
        return ranges, ranges

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """The criteria, with nominal thresholds."""
        return noticed(self.box.scene.threshold)

    @property
    def limit(self) -> float | None:
        """The seconds of a limit that cut the work short; None if none did."""
        return self.budget.cut if self.budget else None

    @property
    def why(self) -> str:
        """Why the work was cut short; empty where it was not."""
        return self.budget.why if self.budget else ""

    @property
    def settled(self) -> bool:
        """Whether the verdicts are proven, and nothing was cut short."""
        return self.certified and not self.why

    @cached_property
    def nominal(self) -> One:
        """The scene at its nominal values."""
        return self.one({})

    def one(self, values: Mapping[str, Expr]) -> One:
        """The certified answers for one set of values; what is not named is nominal."""
        key = tuple(values.items())
        if key not in self._known:
            self._known[key] = one(self.box, values)
        return self._known[key]

    @cached_property
    def _known(self) -> dict[tuple[tuple[str, Expr], ...], One]:
        return {}

    @cached_property
    def _search(self) -> dict[Criterion, tuple[Excess, tuple[Cluster, ...]]]:
        """The excess of each criterion and its clusters; empty where the time is over before that
        is known."""
        try:
            forms = {x: excess_of(self.box, x) for x in self.criteria}
        except LimitError:
            return {}
        # Each search has its share of the time, so that one hard criterion does not leave nothing
        # for the other.
        by_excess: dict[Excess, tuple[Cluster, ...]] = {}
        for form in forms.values():
            with share(_SHARE if len(by_excess) < len(forms) - 1 else 1 - _SHARE):
                by_excess[form] = clusters(form)
        return {x: (form, by_excess[form]) for x, form in forms.items()}

    @cached_property
    def enclosures(self) -> tuple[Enclosure, ...]:
        """The intervals in which crossings lie: outside of them there is none for any values of the
        box."""
        low, high = map(ExactNumber, self.box.scene.band)
        anywhere = [
            Enclosure(x, low, high, None, None, None, {})
            for x in self.criteria
            if x not in self._search
        ]
        known = (
            self._enclosure(x, form, y)
            for x, (form, of_criterion) in self._search.items()
            for y in of_criterion
        )
        enclosures = [*anywhere, *known]
        with spared():
            return tuple(sorted(enclosures, key=lambda x: (float(x.low), x.criterion.name)))

    @cached_property
    def _corners(self) -> tuple[One, ...]:
        """The answers at the box's corners, or at as many of them as are tried in time."""
        ends = product((Fraction(0), Fraction(1)), repeat=len(self.box.sides))
        names = [side.name for side in self.box.sides]
        shares = [
            dict(zip(names, x, strict=True))
            for _, x in zip(range(MOST_CORNERS), ends, strict=False)
        ]
        return tuple(in_time(self.one(self.box.values(x)) for x in shares))

    @cached_property
    def samples(self) -> tuple[Drawn, ...]:
        """The sets of values that were drawn in time; none where ranges are of hands alone."""
        return drawn(self.box, self.count, self.seed) if self.box.sides else ()

    def settle(self) -> None:
        """Compute everything that is printed now, so that a limit is kept to; LimitError if not
        even the nominal values are answered in time."""
        _ = self.nominal
        # what is proven comes first, estimates have what is left
        with share(1 - _FOR_SAMPLES):
            _ = self._search, self.enclosures, self.verdict
        # which takes no time after these
        with spared():
            _ = self.bandwidth
        _ = self.samples

    @cached_property
    def verdict(self) -> BandVerdict:
        """Whether the display is transparent on the band for all values, for none, or for some."""
        if self.transparent is not None and self.noticed is not None:
            return BandVerdict.DEPENDS
        if self._is_one and self.nominal.transparent is not None:
            return BandVerdict.ALL if self.nominal.transparent else BandVerdict.NONE
        if not self._search:
            return BandVerdict.UNDECIDED
        if self._always_noticed():
            return BandVerdict.NONE
        return BandVerdict.ALL if self._never_noticed() else BandVerdict.UNDECIDED

    @property
    def _is_one(self) -> bool:
        """Whether one set of values decides for all: nothing varies, or no ratio equals its
        threshold for any (a continuous function without a zero keeps its sign)."""
        return not self.box.sides or (
            bool(self._search)
            and not any(of_criterion for _, of_criterion in self._search.values())
        )

    def _never_noticed(self) -> bool:
        """Whether for no values any frequency is, as where a ratio just reaches its threshold for
        some.

        Where a cluster is steady, the values along which r grows everywhere lead to one corner, and
        r - c, once above 0, stays so on the way: outside of clusters it is nowhere 0. So nothing is
        noticed if nothing is at those corners; and where a slope does not keep its sign, if nothing
        is on the face to which all others lead. The same holds of open cells that hang together, of
        which several may have the same frequencies, where r < c in all others: the way does not
        leave them.
        """
        searched = [
            of_criterion for x, of_criterion in self._search.items() if not self._is_kept_anyway(x)
        ]
        faces: Sequence[Mapping[str, Expr] | None] = [
            self._greatest(form, x) for form, of_criterion in searched for x in of_criterion
        ]
        # where a cluster leaves a slope open, cells of the parameters alone may show more
        if any(len(x or ()) < len(self.box.sides) for x in faces):
            _, faces = self._by_cells
        different = list({tuple((x or {}).items()): x for x in faces}.values())
        try:
            return self.nominal.transparent is True and all(
                x is not None and self._is_kept_on(x) for x in different
            )
        except LimitError:
            return False

    def _is_kept_on(self, face: Mapping[str, Expr]) -> bool:
        """Whether it is proven that nothing is noticed on a face, given by what is fixed there:
        False also where more than one parameter varies on it."""
        free = [x for x in self.box.sides if x.name not in face]
        # ``require`` decides exactly, also where a ratio just reaches its threshold, of one
        # parameter
        if len(free) > 1:
            return False
        if not free:
            return self.one(face).transparent is True
        from haptisym.verbs.require.required import require  # which much else is loaded for

        [side], scene = free, self.box.scene.with_values(face)
        try:
            requirement = require(scene, side.name, (side.low, side.high), limit=None)
        except (SceneError, UndecidedError):
            return False
        return requirement.feasible == requirement.values.pieces

    def _is_kept_anyway(self, criterion: Criterion) -> bool:
        """Whether it is proven that a criterion is satisfied for all values that the model allows,
        also beyond the box."""
        free = tuple(self.box.scene.ranges().values())
        with suppress(LimitError):
            found = conditions(self.box.scene, free, [criterion])
            return all(is_kept_anyway(self.box.scene, free, x, own) for x, own in found.items())
        return False

    def _greatest(self, form: Excess, cluster: Cluster) -> dict[str, Expr]:
        """The ends of the parameters at which r - c is greatest in a cluster; without those of
        which that is not known."""
        signs = [
            x if matters else 1
            for x, matters in zip(cluster.signs[1:], form.matters[1:], strict=True)
        ]
        return {
            x.name: x.at(Fraction(int(n > 0)))
            for x, n in zip(self.box.sides, signs, strict=True)
            if n
        }

    @cached_property
    def transparent(self) -> One | None:
        """A set of values for which the display is transparent on the band, certified; None if none
        was found."""
        return self._witness(transparent=True)

    @cached_property
    def noticed(self) -> One | None:
        """A set of values for which it is not, certified; None if none was found."""
        return self._witness(transparent=False)

    def _witness(self, *, transparent: bool) -> One | None:
        """A set of values that is transparent, or is not: the nominal one, a corner, or the middle
        of a cell; None if none of them is."""
        if self.nominal.transparent is transparent:
            return self.nominal
        if self._is_one or not self._search or (transparent and self._always_noticed()):
            return None
        found = in_time(self._tried(transparent=transparent))
        return next((x for x in found if x.transparent is transparent), None)

    def _tried(self, *, transparent: bool) -> Iterator[One]:
        """Sets of values that may be transparent, or noticed, the simplest first."""
        yield from self._corners
        middles, _ = self._by_cells
        if transparent in middles:
            yield self.one(middles[transparent])

    @cached_property
    def _by_cells(
        self,
    ) -> tuple[Mapping[bool, Mapping[str, Expr]], Sequence[Mapping[str, Expr] | None]]:
        """Values of a cell on all of which the criteria are satisfied (True), and of one on all of
        which one of them is exceeded (False), as far as there are such.

        And where no cell of the latter kind was found, for each connected set of undecided cells
        what is known of the values at which r is greatest; [None] where nothing is known.
        """
        forms = [form for form, _ in self._search.values() if not form.is_zero]
        band = np.linspace(0, 1, _FIRST + 1)
        pieces = sliding_window_view(band, 2)[:, None]
        first = Cells.of(np.tile([0.0, 1.0], (1, len(self.box.sides), 1)), [pieces] * len(forms))
        judges = [form.curve for form in forms]
        search = Search(
            judges, first, wide=lambda x: x[..., 1] - x[..., 0] > _FINEST, most=_MOST_PIECES
        )
        middles = dict[bool, dict[str, Expr]]()
        for cells in search:
            for cell, ceiling in zip(cells.outer, cells.ceiling, strict=True):
                if (is_kept := bool(ceiling == np.inf)) not in middles:
                    middles[is_kept] = self._middle(cell)
            if len(middles) == 2:
                break
        return middles, [None] if False in middles else self._tops(forms, search.left)

    def _tops(self, forms: Sequence[Excess], left: Cells) -> list[dict[str, Expr] | None]:
        """For each connected set of undecided cells what is known of the values at which r is
        greatest; [None] where the time is over."""
        undecided = [
            (form, x.cells(left.outer))
            for form, x in zip(forms, left.pieces, strict=True)
            if len(x)
        ]
        with suppress(LimitError):
            return [
                self._greatest(form, x)
                for form, cells in undecided
                for x in _grouped(bounded(form, cells))
            ]
        return [None]

    def _middle(self, cell: Array) -> dict[str, Expr]:
        """The values in the middle of a cell."""
        middles = (Fraction(float(x)) for x in cell.mean(-1))
        return self.box.values({x.name: n for x, n in zip(self.box.sides, middles, strict=True)})

    def _always_noticed(self) -> bool:
        """Whether something is noticed for all values: a ratio exceeds its threshold at some
        frequency between clusters, where no values change that."""
        return any(self._exceeds_between(x) is not None for x in self.criteria)

    def _exceeds_between(self, criterion: Criterion) -> float | None:
        """The lowest share of the band outside all clusters at which r exceeds c, for the nominal
        and so for all values."""
        form, of_criterion = self._search.get(criterion, (None, ()))
        if form is None or form.is_zero:
            return None
        start = 0.0
        for low, high in [*((x.low, x.high) for x in of_criterion), (1.0, 1.0)]:
            if low > start:
                # one point suffices: between clusters the excess is nowhere 0, for no values
                middle = np.array([[[(start + low) / 2] * 2, *[[0.5, 0.5]] * (form.sides - 1)]])
                # one cell takes no time
                with spared():
                    exceeds = form.model(middle).bounds()[0][0, 0] > 0
                if exceeds:
                    return start
            start = max(start, high)
        return None

    @cached_property
    def bandwidth(self) -> tuple[RealNumber, RealNumber] | None:
        """Proven bounds on the bandwidth for all values, rad/s; None where the nominal scene is not
        transparent from the low end on, or some values may not be."""
        low, high = (ExactNumber(x) for x in self.box.scene.band)
        if self.verdict is BandVerdict.ALL:
            return high, high
        if self.nominal.bandwidth is None or any(
            float(x.low) <= float(low) for x in self.enclosures
        ):
            return None
        # Below all enclosures nothing is noticed for any values. The bandwidth ends for all of them
        # where the first ratio has crossed its threshold whatever the values.
        least = min([x.low for x in self.enclosures] or [high], key=float)
        ends = [self._end_of_first(x) for x in self.criteria]
        return least, min([x for x in ends if x is not None] or [high], key=float)

    def _end_of_first(self, criterion: Criterion) -> RealNumber | None:
        """An upper bound on the frequency from which on r exceeds c for all values; None if no such
        one is proven."""
        share = self._exceeds_between(criterion)
        if share is None:
            return None
        before = [x for x in self.enclosures if x.criterion == criterion and x.high is not None]
        low, high = self.box.scene.band
        edge = float(low) + share * float(high - low)
        return max(
            (x.high for x in before if float(x.high) <= edge * (1 + 1e-9)), key=float, default=None
        )

    @property
    def certified(self) -> bool:
        """Whether the verdict is proven, and that on each hand."""
        return self.verdict is not BandVerdict.UNDECIDED and all(x.share for x in self.held)

    def _enclosure(self, criterion: Criterion, form: Excess, cluster: Cluster) -> Enclosure:
        """The enclosure of the crossings of one cluster."""
        moves = zip(self.box.sides, cluster.signs[1:], strict=True)
        steady = {side.name: int(-sign * cluster.signs[0]) for side, sign in moves}
        alone = cluster.regular and cluster.inside
        # Regular crossings that cannot leave the band neither merge nor vanish: there are as many
        # for all values as for the nominal ones.
        nominal_crossings = [
            x for x in self.nominal.crossings[criterion.name] if within(self.box, x, cluster)
        ]
        count = (
            0
            if self.verdict is BandVerdict.ALL
            else len(nominal_crossings)
            if alone and nominal_crossings
            else None
        )
        face = Face(self.box, criterion.name, {}, self.one)
        (low, at_low), (high, at_high) = (
            self._end(face, form, cluster, highest=end) for end in (False, True)
        )
        return Enclosure(criterion, low, high, count, at_low, at_high, steady)

    def _end(self, face: Face, form: Excess, cluster: Cluster, *, highest: bool) -> End:
        """The end of the crossings of a cluster; that of the cluster where the time is over."""
        found: End | None = None
        with suppress(LimitError):
            found = face.end(form, cluster, highest=highest)
        return found or (at_share(self.box, cluster.high if highest else cluster.low), None)

    def _body(self) -> dict[str, Any]:
        sides = [
            {"name": x.name, "low": float(x.low), "high": float(x.high)} for x in self.box.sides
        ]
        return {
            "band": [float(x) for x in self.box.scene.band],
            "varying": sides,
            "verdict": self.verdict.value,
            "witnesses": {
                "transparent": _witness_row(self.transparent),
                "noticed": _witness_row(self.noticed),
            },
            "crossings": [self._enclosure_row(x) for x in self.enclosures],
            "bandwidth": None if self.bandwidth is None else [float(x) for x in self.bandwidth],
            **({"held": [x.row() for x in self.held]} if self.held else {}),
            "estimates": self._estimates(),
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        return ({} if self.limit is None else {"limit": self.limit}) | (
            {"reason": self.why} if self.why else {}
        )

    def _enclosure_row(self, x: Enclosure) -> dict[str, Any]:
        corners = {"low": _values(x.at_low), "high": _values(x.at_high)}
        enclosure = [x.low.enclosure()[0], x.high.enclosure()[1]]
        row = {
            "part": x.criterion.name,
            "omega": [float(x.low), float(x.high)],
            "enclosure": enclosure,
        }
        return {**row, "count": x.count, "reached_at": corners, "monotonic": dict(x.monotonic)}

    def _estimates(self) -> dict[str, Any] | None:
        if not self.samples:
            return None
        q = quantiles(self.samples)
        rows = {"first_crossing": q.first, "bandwidth": q.bandwidth}
        shown = {key: {str(p): x for p, x in row.items()} for key, row in rows.items()}
        return {
            "samples": len(self.samples),
            "seed": self.seed,
            **shown,
            "transparent": q.transparent,
        }


def _witness_row(one: One | None) -> dict[str, str] | None:
    return None if one is None else _values(one.values)


def _values(values: Mapping[str, Expr] | None) -> dict[str, str] | None:
    return None if values is None else {name: str(x) for name, x in values.items()}


SEED = 2019


def tolerances(
    scene: Scene | str | Path,
    samples: int = 200,
    seed: int = SEED,
    *,
    hand: str | Hand | Iterable[str | Hand] | None = None,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> Tolerances:
    """What holds for all values of a scene's parameters within their ranges.

    Proven: the verdict where it is not ``BandVerdict.UNDECIDED``; that crossings lie in the
    enclosures and nowhere else; how many there are where a count is given; ends that are marked as
    reached at a corner are exact. Estimated: quantiles over ``samples`` sets of values, each
    answered with certainty, drawn uniformly with a seed; none where ranges are of hands alone,
    which change nothing of what is felt. SceneError where nothing has a range.

    ``hand`` : those in which the display is held, as of ``stability``; those of the scene if not
    given. For each, ``held``
    has whether the display is stable in it for all values of display and hand, for some, or
    for none.
    ``limit`` : seconds of processor time after which the work is cut short: enclosures are then
    wider than they need be, the verdict may be undecided and fewer sets be drawn; None for no
    limit. ``told`` : is called now and then with how much is done, of how much, and what it is.
    LimitError if not even the nominal values were answered in time.

    >>> from haptisym import effects, environments
    >>> spring = environments.mass_spring_damper(k="100 N/m +- 10 %")
    >>> lag = effects.first_order_lag("40 rad/s +- 10 %")
    >>> found = tolerances(Scene(spring, (lag,)), samples=0)
    >>> found.verdict.value, [(x.part.value, x.low.digits(5), x.high.digits(5), x.count) for x in found.enclosures]
    ('none', [('imag', '3.6367', '4.4449', 1), ('real', '12.000', '14.667', 1)])
    """
    scene = in_hands(as_scene(scene), hand)
    samples = whole("samples", samples, 0)
    box = box_of(scene)
    with limited(limit, told) as budget:
        # Hands first, with a share of their own: what follows would otherwise use up the time.
        with share(_FOR_HANDS):
            held = tuple(held_in_box(scene, x) for x in scene.hands)
        found = Tolerances(box, samples, seed, budget, held)
        found.settle()
    return found


_FOR_HANDS = 0.3  # of the time
_FOR_SAMPLES = 0.3  # of what is left after the nominal values
