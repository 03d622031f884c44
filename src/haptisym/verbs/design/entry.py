"""Which values of one to three parameters make the bandwidth largest: the best values found, proven
bounds on how much better others can be, and what it costs to miss them.

The bandwidth B(q) is the end of the transparent interval that starts at the band's low end: the
lowest frequency at which some criterion is exceeded with some environment, the band's high end if
none is. It is upper semicontinuous, so that it has a maximum on a closed box; at the maximum
several criteria are often met at once, and B falls off sharply on either side.

By branch and bound: exact evaluations at single values give what is attained, which counts if what
must be kept is kept there (``attained``); cells that are proven to hold nothing better by more than
the gap are closed (``bound``). Both bounds meet to within the gap, or the larger distance that is
left is in the answer. ``_Search.go`` is where to begin reading.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import cycle
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np
from sympy import Expr, Rational

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, CrossingKind, Judged
from haptisym.kernel.budget import SECONDS, Told, limited, tick
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError, meant
from haptisym.kernel.objects import titled
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.sets import Verdict
from haptisym.kernel.where import Judge, touching
from haptisym.model.catalogue import Hand
from haptisym.model.quantities import Dimension, Number, number
from haptisym.model.scene import Knob, Scene
from haptisym.model.scenefile import SceneFamily, as_family
from haptisym.model.valueranges import ALLOWED, domain
from haptisym.programs.taylormodels import Array
from haptisym.verbs.design.attained import KEPT, PASSIVE, STABLE, STEADY, Attained, Points
from haptisym.verbs.design.bound import LargestBandwidth, broken, profile

Range: TypeAlias = tuple[Number, Number] | None
Free: TypeAlias = Mapping[str, Range] | Sequence[str] | str
Spans: TypeAlias = list[tuple[RealNumber | None, RealNumber | None]]
"""Intervals of one parameter; None for an end that is one of its range, or not known."""
_GAPS = {1: Fraction(1, 1000), 2: Fraction(1, 1000), 3: Fraction(1, 100)}
_TARGETS = (1.0, 0.1, 0.01)
"""How far above what is attained an upper bound is proven first, relatively, before the gap itself:
loose targets close most of the box at little cost, and leave a bound if the time ends early."""
_MISSED = (Rational(1, 100), Rational(1, 20))
_LOSS = 1e-5
_FINEST_HELD = 2.0**-5
# A few roundings of a share: cells that must hold all values with which something is kept are wider
# by it than the floats of their ends.
_ULPS = 1e-15
_MOST_LOSS = 5.0  # seconds for what a best value costs to miss
_MOST_HELD = 20.0  # seconds for all values of one parameter with which what must be kept is


@dataclass(frozen=True)
class Bound(Judged):
    """A criterion that is met at the best values: where, rad/s, and with which environment."""

    criterion: Criterion
    omega: RealNumber
    environment: str


@dataclass(frozen=True)
class Loss:
    """What it costs to miss the best values by up to a relative distance: all values so near attain
    at least ``bandwidth``, rad/s, proven.

    ``kept`` : whether all of them keep what must be kept, None where that is not proven.
    """

    relative: Expr
    bandwidth: float
    kept: bool | None

    def row(self) -> dict[str, Any]:
        """As a row of a document."""
        return {"relative": float(self.relative), "bandwidth": self.bandwidth, "kept": self.kept}


@dataclass(frozen=True, repr=False)
class Design(Answer):
    """The values that make the bandwidth largest, and proven bounds on how large it can be.

    ``given`` : what the scene's own values attain. ``best`` : what the best values found attain,
    exactly, and that they keep what must be kept; None where no values were found that do.
    ``bandwidth`` : between which numbers the largest one lies, rad/s. ``where`` : cells, (cells,
    parameters, 2), SI, outside of which nothing is better than ``best``. ``limit`` : as in
    ``Requirement``; ``why`` : the reason, where something was cut short.
    """

    _schema: ClassVar[str] = "haptisym.design/1"
    _page: ClassVar[str] = "haptisym.pages.design:page"
    _is_in_lines = True
    _figure: ClassVar[str] = "haptisym.figures.design:DESIGN"

    family: SceneFamily
    free: tuple[Knob, ...]
    ranges: tuple[tuple[Expr, Expr], ...]
    keep: tuple[str, ...]
    robust: Expr
    gap: Fraction
    given: Attained | None
    best: Attained | None
    bandwidth: tuple[float, float]
    where: Array
    loss: tuple[Loss, ...] = ()
    limit: float | None = None
    question: DesignQuestion | None = field(default=None, repr=False)
    why: str = ""

    def _line(self) -> str:
        if self.best is None:
            return f"{titled(self.family.title)}: no values were found"
        values = ", ".join(
            f"{x.name} = {float(value):.6g}"
            for x, value in zip(self.free, self.best.values, strict=True)
        )
        return f"{titled(self.family.title)}: {values}: bandwidth {self.bandwidth[0]:.6g} rad/s"

    @property
    def scene(self) -> Scene:
        """The first environment's."""
        return self.family.first

    @property
    def about(self) -> SceneFamily | Scene:
        """The scene, or all of several."""
        return self.family if len(self.family) > 1 else self.family.first

    @property
    def _about(self) -> SceneFamily | Scene:
        return self.about

    @property
    def _varied(self) -> tuple[list[str], list[str]]:
        paths = [x.path for x in self.free]
        return paths, paths

    @property
    def certified(self) -> bool:
        """Whether the bounds are no further apart than the gap, and what must be kept is proven to
        be."""
        (low, high), (start, end) = self.bandwidth, map(float, self.family.band)
        # Where something is noticed from the low end on, the bandwidth is 0, of which no relative
        # gap is possible: it is then a share of the band. Compared exactly.
        least = low if low > start else end - start
        apart = Fraction(high) - Fraction(max(low, start) if high > 0 else low)
        return apart <= self.gap * Fraction(least) and (self.best is None or self.best.kept is True)

    @property
    def is_whole(self) -> bool:
        """Whether nothing is noticed on the band at the best values."""
        return self.best is not None and self.best.is_whole

    @cached_property
    def binding(self) -> tuple[Bound, ...]:
        """The criteria that are exceeded first at the best values, or at what is worst about them,
        to within the gap."""
        if self.best is None or self.is_whole:
            return ()
        end, bindings = self.best.seen * (1 + float(self.gap)), dict[tuple[str, str], Bound]()
        rows = zip(cycle(self.family), self.best.evaluations, strict=False)
        met = [
            Bound(x.criterion, x.omega, name)
            for name, evaluation in rows
            for x in evaluation.crossings
            if x.kind is CrossingKind.EXCEEDS
        ]
        for x in sorted(met, key=lambda x: float(x.omega)):
            if float(x.omega) <= end:
                bindings.setdefault((x.environment, x.criterion.name), x)
        return tuple(bindings.values())

    @property
    def at_ends(self) -> list[tuple[Knob, bool]]:
        """The parameters whose best value is an end of the range searched while the model allows
        values beyond it; True for the upper end."""
        found = []
        if self.best is not None and not self.is_whole:
            for x, value, (low, high) in zip(self.free, self.best.values, self.ranges, strict=True):
                # A millionth of the range was left out at an end that the model does not allow.
                allowed, least = ALLOWED[x.rule], (high - low) / 10**6
                if value == low and (allowed.low is None or low - least > allowed.low):
                    found.append((x, False))
                if value == high and (allowed.high is None or high + least < allowed.high):
                    found.append((x, True))
        return found

    @cached_property
    def clusters(self) -> list[list[tuple[float, float]]]:
        """Boxes, the ends of each parameter, SI, outside of which nothing is better than the best:
        one about each connected set of cells."""
        label = touching(self.where)
        boxes = []
        for n in sorted(set(label.tolist())):
            cells = self.where[label == n]
            low, high = cells[..., 0].min(0).tolist(), cells[..., 1].max(0).tolist()
            boxes.append(list(zip(low, high, strict=True)))
        return boxes

    def _body(self) -> dict[str, Any]:
        several = len(self.family) > 1
        return {
            "free": [
                {"path": x.path, "unit": x.unit, "low": float(a), "high": float(b)}
                for x, (a, b) in zip(self.free, self.ranges, strict=True)
            ],
            "keep": list(self.keep),
            "band": [float(x) for x in self.family.band],
            "given": None
            if self.given is None
            else {"bandwidth": self.given.bandwidth, "kept": self.given.kept},
            "best": self.best and self._row(self.best),
            "bandwidth": list(self.bandwidth),
            "where": [
                {x.path: list(ends) for x, ends in zip(self.free, cluster, strict=True)}
                for cluster in self.clusters
            ],
            "binding": [
                {"criterion": x.criterion.symbol, "omega": float(x.omega)}
                | ({"environment": x.environment} if several else {})
                for x in self.binding
            ],
            "loss": [x.row() for x in self.loss],
            "whole_band": self.is_whole,
            "certified": self.certified,
        }

    def _row(self, found: Attained) -> dict[str, Any]:
        values = {x.path: float(value) for x, value in zip(self.free, found.values, strict=True)}
        return {"values": values, "bandwidth": found.bandwidth, "kept": found.kept}

    def _left(self) -> dict[str, Any]:
        robust = {"robust": float(self.robust)} if self.robust else {}
        limit = {"limit": self.limit} if self.limit is not None else {}
        return robust | limit | ({"reason": self.why} if self.why else {})


@dataclass(frozen=True)
class DesignQuestion:
    """The question: scenes by environment, free parameters, each between two values, SI, and what
    must be kept. ``robust`` : the relative distance that values may be off; ``gap`` : that of the
    bounds."""

    family: SceneFamily
    free: tuple[Knob, ...]
    ranges: tuple[tuple[Expr, Expr], ...]
    keep: tuple[str, ...]
    robust: Expr
    gap: float

    @property
    def scenes(self) -> list[Scene]:
        """One for each environment."""
        return list(self.family.scenes.values())

    @cached_property
    def points(self) -> Points:
        """What evaluates single sets of values."""
        return Points(self.scenes, self.free, self.ranges, self.keep, self.robust, self.gap)

    @property
    def _passive(self) -> list[tuple[Judge, int]]:
        """Functions that are positive where the display is not passive, if it must be."""
        return [x for box in self.points.boxes for x in box.passive] if PASSIVE in self.keep else []

    def search(self, cells: Array | None = None) -> LargestBandwidth:
        """A search for the upper bound in cells outside of which nothing better is left; without
        any, in all that may keep what must be kept."""
        return LargestBandwidth(
            self.points.criteria, self._passive, self._held[0] if cells is None else cells
        )

    @cached_property
    def _held(self) -> tuple[Array, Array]:
        """Two sets of cells, in shares: those that hold all values with which what must be kept may
        be kept, and those with which it is proven not to be.

        Of one parameter from ``require``; of more where the display must be stable, from the plane
        of its hands. Else all of the box, and none.
        """
        whole = np.tile([0.0, 1.0], (1, len(self.free), 1))
        if len(self.free) == 1:
            return (whole, whole[:0]) if self._alone is None else self._held_alone(self._alone)
        if self.robust or STABLE not in self.keep:
            return whole, whole[:0]
        try:
            return self._held_plane()
        except UndecidedError:
            return whole, whole[:0]

    @cached_property
    def _alone(self) -> Spans | None:
        """The intervals of one parameter in which what must be kept is kept, or may be, in order;
        None where that is not known."""
        if self.robust or not self.keep or len(self.free) > 1:
            return None
        from haptisym.verbs.require.required import require

        try:
            found = require(
                self.scenes[0], self.free[0].path, self.ranges[0], that=self.keep, limit=_MOST_HELD
            )
        except UndecidedError:
            return None
        return [(x.low, x.high) for x in found.values.pieces if x.verdict is not Verdict.FAILS]

    @property
    def single(self) -> list[Expr]:
        """Single values of one parameter that keep what must be kept while their neighbours do not;
        those that are rational. Samples would never hit them."""
        found = [a.value for a, b in self._alone or () if isinstance(a, ExactNumber) and a == b]
        return [x for x in found if x.is_Rational]

    def refused(self, finest: float, most: int) -> Array:
        """Cells, (cells, parameters, 2), in shares, for all values of which what must be kept is
        proven to be broken."""
        active = (
            broken(self._passive, len(self.free), finest, most)
            if self._passive
            else self._held[1][:0]
        )
        return np.concatenate([active, self._held[1]])

    def profile(self, within: float, most: int) -> tuple[Array, Array]:
        """Cells in shares, and between which numbers, rad/s, the bandwidths of their values lie; as
        of ``bound.profile``."""
        cells, shares = profile(self.points.criteria, len(self.free), within, most)
        low, high = map(float, self.family.band)
        return cells, np.where(shares > 0, low + shares * (high - low), 0.0)

    def _held_alone(self, spans: Spans) -> tuple[Array, Array]:
        """Both sets of cells of one parameter, from the intervals that may be allowed: these
        widened by what their ends are rounded, and what lies between them."""
        low, high = self.ranges[0]

        def share(x: RealNumber | None, end: int, none: float) -> float:
            if x is None:
                return none
            exact = Rational(x.enclosure(20)[end])
            return float((exact - low) / (high - low))

        ends = [[share(a, 0, 0.0) - _ULPS, share(b, 1, 1.0) + _ULPS] for a, b in spans]
        allowed = np.clip(np.array(ends).reshape(-1, 1, 2), 0.0, 1.0)
        between = np.concatenate([[0.0], np.sort(allowed.ravel()), [1.0]]).reshape(-1, 1, 2)
        return allowed, between[between[:, 0, 1] > between[:, 0, 0]]

    def _held_plane(self) -> tuple[Array, Array]:
        """Both sets of cells of two or three parameters, by the stability in the plane of the first
        two for all values of the third."""
        from haptisym.verbs.stability.ranges import held_plane

        sides = {x.symbol: ends for x, ends in zip(self.free, self.ranges, strict=True)}
        first = dict(list(sides.items())[:2])
        rest = {x: ends for x, ends in sides.items() if x not in first}
        plane = held_plane(self.scenes[0], self.scenes[0].hands, first, rest, finest=_FINEST_HELD)
        both = []
        # what is undecided in the plane may be stable, and must be searched
        for cells in (np.concatenate([plane.stable, plane.left]), plane.unstable):
            all_sides = np.tile([0.0, 1.0], (len(cells), len(self.free), 1))
            all_sides[:, :2] = cells
            both.append(all_sides)
        return both[0], both[1]


@dataclass
class _Search:
    """The work on a question, and what is known of it when the time is over.

    ``upper`` : no values attain more than this share of the band. ``cells`` : outside of them no
    values are better than the best.
    """

    question: DesignQuestion
    gap: float
    best: Attained | None = None
    given: Attained | None = None
    upper: float = 1.0
    cells: Array = field(default_factory=lambda: np.empty((0, 1, 2)))
    is_refused: bool = False
    """Whether it is proven that no values keep what must be kept."""

    def __post_init__(self) -> None:
        low, high = self.question.family.band
        self._low, self._high = float(low), float(high)
        self.points = self.question.points

    def share(self, bandwidth: float) -> float:
        """The share of the band below a frequency; 0 for one below the band."""
        return max((bandwidth - self._low) / (self._high - self._low), 0.0)

    def frequency(self, share: float) -> float:
        """The frequency at a share of the band, rad/s."""
        return self._low + share * (self._high - self._low)

    @property
    def attained(self) -> float:
        """The bandwidth of the best values so far, as a share of the band; 0 without any."""
        if self.best is None:
            return 0.0
        return 1.0 if self.best.is_whole else self.share(self.best.bandwidth)

    def go(self) -> None:
        """Find the best, and prove how much better it can be."""
        self.cells = np.tile([0.0, 1.0], (1, len(self.question.free), 1))
        self._start()
        if self.attained < 1:
            self._prove()
            self._at_ends()
        if self.attained >= 1:
            self.cells = self.cells[:0]

    def _at_ends(self) -> None:
        """Take the end of a range for the best value of a parameter where it has more bandwidth,
        which a search to within a gap leaves beside it."""
        for i, ends in enumerate(self.question.ranges):
            for end, share in zip(ends, (0.0, 1.0), strict=True):
                if self.best is None or not (self.cells[:, i] == share).any():
                    continue
                values = (*self.best.values[:i], end, *self.best.values[i + 1 :])
                found = self.points.attained(values)
                if found and self.points.fits(found) and found.bandwidth > self.best.bandwidth:
                    self.best = found

    def _prove(self) -> None:
        """Bring the upper bound down to what is attained, target by target."""
        cover = self.question.search()
        try:
            for relative in (*(x for x in _TARGETS if x > self.gap), self.gap):
                proven = None
                while proven is None:
                    looked_at = len(self.points.factors)
                    aim = partial(self._aim, relative=relative)
                    proven = cover.prove(aim, self._offer)
                    if self.attained >= 1:
                        return
                    # A new factor means new criteria: a new search begins, in the cells that may
                    # still hold something better by the old ones.
                    if len(self.points.factors) > looked_at:
                        cover = self.question.search(self._open_in(cover))
                    elif proven is None:
                        return
                self.upper = min(self.upper, proven)
        finally:
            self.cells = cover.better_than(self.attained)
            self.is_refused = self.best is None and not len(self._open_in(cover))

    def _open_in(self, cover: LargestBandwidth) -> Array:
        """Cells that may hold something better; where nothing is attained all that may keep what
        must be kept."""
        return cover.better_than(-1e-9 if self.best is None else self.attained)

    def _aim(self, share: float, relative: float) -> float:
        """The share of the band up to which an upper bound is to be brought down, for what is
        attained: higher by a relative distance, or by a share of the band where that is 0."""
        # what is rounded on the way stays within the gap
        relative *= 1 - 1e-6
        return min(
            self.share(self.frequency(share) * (1 + relative)) if share > 0 else relative, 1.0
        )

    def _start(self) -> None:
        """Find good values to begin with: the scene's own, values all over the box, and single ones
        that samples would not hit."""
        points, given = self.points, tuple(x.value for x in self.question.free)
        self.given = points.attained(given)
        inside = all(
            low <= x <= high for x, (low, high) in zip(given, self.question.ranges, strict=True)
        )
        if inside and self.given and points.fits(self.given):
            self.best = self.given
        if self.attained >= 1:
            return
        start = points.spread()
        whole = points.nearest_whole(start, self._high, np.array([float(x) for x in given]))
        found = whole or points.best(start, self.best.bandwidth if self.best else 0.0)
        # a bandwidth of 0 that keeps what must be kept is an answer too
        if found is None and self.best is None:
            some = map(points.attained, map(points.exact, start[:: max(len(start) // 12, 1)]))
            found = next((x for x in some if x and points.fits(x)), None)
        self.best = found or self.best
        for x in self.question.single if self.attained < 1 else ():
            alone = points.attained([x])
            if (
                alone
                and points.fits(alone)
                and (self.best is None or alone.bandwidth > self.best.bandwidth)
            ):
                self.best = alone
        self._round()

    def _round(self) -> None:
        """Give the best values as few digits as cost a twentieth of the gap at most."""
        if self.best is not None and self.best is not self.given:
            self.best = self.points.rounded(self.best, self.gap / 20)

    def bounds(self) -> tuple[float, float]:
        """The bounds of the largest bandwidth, rad/s; where values may be off, of the largest worst
        one."""
        if self.is_refused:
            return 0.0, 0.0
        upper = self._high if self.upper >= 1 else 0.0
        if 0 < self.upper < 1:
            # rounded up, as it is an upper bound
            upper = min(float(np.nextafter(self.frequency(self.upper), np.inf)), self._high)
        if self.best is None:
            return 0.0, upper
        if self.best.is_whole:
            return self._high, self._high
        return self.best.bandwidth, max(upper, self.best.bandwidth)

    def where(self) -> Array:
        """Cells outside of which nothing is better, SI."""
        low, width = np.array([(float(a), float(b - a)) for a, b in self.question.ranges]).T
        cells = self.cells if len(self.cells) else np.empty((0, len(low), 2))
        return low[:, None] + width[:, None] * cells

    def losses(self) -> list[Loss]:
        """What it costs to miss the best values, by increasing distance; without those distances of
        which nothing was proven in time."""
        best, losses = self.best, list[Loss]()
        if best is None:
            return losses
        robust = Loss(self.question.robust, best.bandwidth, best.kept)
        middle = replace(
            best, evaluations=best.evaluations[: len(self.question.scenes)], proven=None
        )
        for relative in reversed(_MISSED):
            try:
                with limited(_MOST_LOSS):
                    low = min(self.points.worst(middle, relative, _LOSS)[0], self._high)
                    kept = self.points.keep_around(best.values, relative)
            except (LimitError, UndecidedError, SceneError):
                continue
            # what is proven for all values within a larger distance holds for these too
            further = [x for x in (robust, *losses) if x.relative >= relative]
            low = max([low, *(x.bandwidth for x in further)])
            losses.append(Loss(relative, low, kept or any(x.kept for x in further) or kept))
        return losses[::-1]

    def _offer(self, shares: Array) -> float | None:
        """Try points of the box that may be better, as of ``bound.Offer``."""
        tick()
        if not len(shares):
            return self.attained
        looked_at = len(self.points.factors)
        values, least = self.points.values(shares), self.best.bandwidth if self.best else 0.0
        # not for a gain of less than a twentieth of the gap, which rounding the values may cost
        better = self._near(values, least * (1 + self.gap / 20))
        if better is not None:
            self.best = better
            self._round()
        return self.attained if len(self.points.factors) == looked_at else None

    def _near(self, values: Array, least: float) -> Attained | None:
        """Something better than ``least`` near some sets of values."""
        # Floats judge values that may be off by the factors known so far: one exact evaluation
        # finds the factor that is missing.
        if self.question.robust:
            found = self.points.attained(self.points.exact(values[0]))
            return found if found and self.points.fits(found) and found.bandwidth > least else None
        _, most = self.points.bandwidths(values)
        if not (most > least).any():
            return None
        return self.points.best(values[np.argsort(-most, kind="stable")[:8]], least)


def design(
    scene: SceneFamily | Scene | str | Path,
    free: Free,
    *,
    keep: Sequence[str] | str = (),
    hand: str | Hand | None = None,
    robust: Number | None = None,
    gap: Number | None = None,
    limit: float | None = SECONDS,
    told: Told | None = None,
) -> Design:
    """The values of one to three parameters with which the bandwidth is largest, with proven bounds
    on how large it can be.

    ``scene`` : of formulas; with several environments the least of their bandwidths counts.
    ``free`` : paths or names, with the range of each, numbers in SI or strings with a unit; a tenth
    to ten times its value where none is given.
    ``keep`` : "passive", "stable" (in ``hand``, or in all hands of the scene), "steady" (without
    shaking, a drift allowed).
    ``robust`` : a share, such as "5 %": the values whose worst bandwidth is largest when all are
    off by up to as much.
    ``gap`` : relative, to which bounds are to come together; 1e-3, for three parameters 1e-2.
    ``limit``, ``told`` : as in
    ``require``.

    Proven: the best values attain the lower bound and keep everything, exactly; no values of
    the box that keep everything attain more than the upper one. SceneError where the scene, a path
    or a range does not fit.

    >>> found = design("fu2019", {"zeta": (0.3, 1)})
    >>> [x.name for x in found.free], found.certified
    (['zeta'], True)
    """
    family = as_family(scene)
    wanted = _wishes(keep)
    if hand is not None or {STABLE, STEADY} & set(wanted):
        from haptisym.verbs.require.hands import with_hands  # which much else is loaded for

        family = SceneFamily(
            {k: with_hands(x, hand) for k, x in family.scenes.items()}, family.title, family.source
        )
    knobs, ranges = _box(family, free)
    off = Rational(0) if robust is None else _share("robust", robust)
    within = _GAPS[len(knobs)] if gap is None else Fraction(str(_share("gap", gap)))
    question = DesignQuestion(family, knobs, ranges, wanted, off, float(within))
    search = _Search(question, float(within))
    with limited(limit, told) as budget:
        with suppress(LimitError):
            search.go()
        losses = tuple(search.losses())
    return Design(
        family,
        knobs,
        ranges,
        wanted,
        off,
        within,
        search.given,
        search.best,
        search.bounds(),
        search.where(),
        losses,
        budget.cut,
        question,
        budget.why,
    )


def _share(what: str, given: Number) -> Expr:
    """A rational share, above 0 and at most a half; SceneError for another number."""
    found = number(given, Dimension.RATIO).value
    if not (found.is_Rational and 0 < found <= Rational(1, 2)):
        raise SceneError(f"{what}: {given} must be a share above 0, at most 0.5 (or 50 %)")
    return found


def _wishes(keep: Sequence[str] | str) -> tuple[str, ...]:
    """What must be kept, each once, in the order of ``KEPT``; SceneError for what is none of it."""
    listed = [keep] if isinstance(keep, str) else list(keep)
    for x in listed:
        if x not in KEPT:
            said = f'keep: "{str(x)[:60]}" is none of {", ".join(KEPT)}; {meant(str(x), KEPT)}'
            raise SceneError(said.rstrip("; "))
    return tuple(x for x in KEPT if x in listed)


def _box(family: SceneFamily, free: Free) -> tuple[tuple[Knob, ...], tuple[tuple[Expr, Expr], ...]]:
    """The free parameters, and the range in which each is searched."""
    listed = [free] if isinstance(free, str) else free
    ranges: dict[str, Range] = (
        dict(listed) if isinstance(listed, Mapping) else dict.fromkeys(listed)
    )
    if not 1 <= len(ranges) <= 3:
        raise SceneError(
            f"{len(ranges)} parameters are free: the best values of one, two or three are found"
        )
    knobs = family.first.knobs
    chosen = [knobs[path].felt() for path in ranges]
    for path, x in zip(ranges, chosen, strict=True):
        if x.parts:
            raise SceneError(
                f"{x.path} is what a person notices, and nothing to design: choose a "
                f"parameter of the display"
            )
        if chosen.count(x) > 1:
            raise SceneError(f"{x.path} is free twice, the second time as {path}")
        if len(family) > 1 and not x.path.startswith("effects."):
            raise SceneError(
                f"{x.path} is of one environment: with several, choose parameters of effects"
            )
    for scene in family.scenes.values():
        scene.knobs.need_numbers(chosen)
        if not scene.threshold.is_box or scene.threshold.ranges:
            raise SceneError(
                "the JND has a range: give it a number here, which the best values depend on"
            )
    return tuple(chosen), tuple(
        _range(x, given) for x, given in zip(chosen, ranges.values(), strict=True)
    )


def _range(free: Knob, given: Range) -> tuple[Expr, Expr]:
    """The two ends, SI, within what the model allows; of an end that is not allowed itself a
    millionth is left out."""
    value = free.value
    if given is None and (value.free_symbols or not value):
        raise SceneError(
            f"{free.path} is {value}, so that a tenth to ten times of it is no range: give "
            f"one, as {free.path}=1:10"
        )
    allowed = domain(
        free, given or ((value / 10, value * 10) if value > 0 else (value * 10, -value * 10))
    )
    low, high = allowed.low, allowed.high
    assert low is not None
    assert high is not None
    inside = (high - low) / 10**6
    return low if allowed.holds_low else low + inside, high if allowed.holds_high else high - inside
