"""Which effects of a scene matter for a tolerance: how much each changes r_r and r_i, and the
fewest that do for all, with proof.

The fewest effects are found by sampling and decided by proof: ``|r_full - r_kept| <= bound`` at
every frequency of the band (``differences``). So the full scene's ratio equals its threshold c only
where the kept scene's ratio lies between c - bound and c + bound, and the chart of the kept scene
at these two levels encloses all its crossings. For a JND region of another shape the whole band
is the enclosure.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, groupby
from math import comb, inf, nextafter
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from sympy import Expr, Rational

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, Judged, noticed
from haptisym.kernel.arrays import np
from haptisym.kernel.budget import SECONDS, Waiting, limited
from haptisym.kernel.errors import SceneError
from haptisym.kernel.objects import titled
from haptisym.kernel.reals import RealNumber
from haptisym.kernel.rings import omega
from haptisym.kernel.roots import Chart, Interval, Signed, chart, sign_of_number
from haptisym.model.catalogue import Effect
from haptisym.model.jnd import Part, positive
from haptisym.model.quantities import Dimension, Number, number
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene
from haptisym.programs.links import FLOATS, InSteps, series_arithmetic
from haptisym.verbs.effects.differences import (
    BallChain,
    BandPiece,
    Difference,
    Kept,
    Supremum,
    SupremumBounds,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DEPTH = 7  # ratios are sampled in the middles of 2^7 pieces of the band
_MOST_SUBSETS = 1 << 12  # subsets that are examined: all of 12 effects


@dataclass(frozen=True)
class Selection:
    """Effects that are kept, with the largest change that the others make together.

    ``smallest`` : whether it is proven that no smaller set is within the tolerance, and none of
    this size with a lower bound.
    """

    kept: Kept
    bound: Mapping[Part, Supremum]
    smallest: bool

    @property
    def worst(self) -> float:
        """The largest of its bounds."""
        return max(x.most for x in self.bound.values())


@dataclass(frozen=True)
class SubsetSearch:
    """The search in one scene for one tolerance, an exact number >= 0.

    Effects may make up for each other, so a set that does is not known from a larger or a smaller
    one: all sets are gone through by size. Sampling only says in which order to look, and where: a
    set is refused for a frequency at which the change is proven to exceed the tolerance, and taken
    for a bound that is proven not to.
    """

    scene: Scene
    balls: BallChain
    tolerance: Expr

    def choose(self) -> Selection:
        """The fewest effects; of several sets that size, the one with the lowest bound."""
        everything, examined, smallest = self.balls.everything, 0, True
        for size in range(len(everything)):
            examined += comb(len(everything), size)
            if examined > _MOST_SUBSETS:
                return self._one_by_one()
            sets = [frozenset(kept) for kept in combinations(sorted(everything), size)]
            verdicts = {kept: self._verdict(kept) for kept in sets}
            # A set of which it is undecided whether it suffices may be one that does: then a larger
            # one is not proven to be the smallest.
            smallest = smallest and None not in verdicts.values()
            found = [
                self._choice(kept, smallest=smallest) for kept, within in verdicts.items() if within
            ]
            if found:
                return min(found, key=lambda choice: choice.worst)
        return self._choice(everything, smallest=smallest)

    def _one_by_one(self) -> Selection:
        """A small set, if not surely the smallest: effects are left out in turn while the bound
        allows it."""
        kept = self.balls.everything
        while True:
            smaller = sorted((kept - {i} for i in kept), key=lambda x: self._sampled(x)[0])
            found = next((x for x in smaller if self._verdict(x)), None)
            if found is None:
                return self._choice(kept, smallest=False)
            kept = found

    def _choice(self, kept: Kept, *, smallest: bool) -> Selection:
        """The selection of a set that is within the tolerance, with its bounds."""
        # Where the supremum just reaches the tolerance its enclosure is a little wider: that it is
        # no more was then proven by the exact functions.
        found = {part: self._difference(kept, part).supremum() for part in Part}
        above = nextafter(self._limit, inf)
        bound = {part: Supremum(x.least, min(x.most, above)) for part, x in found.items()}
        return Selection(kept, bound, smallest)

    def _verdict(self, kept: Kept) -> bool | None:
        """Whether a set of effects is within the tolerance; None where that is undecided."""
        # the sample says where to look; one ball there refutes most sets without a search
        change, part, piece = self._sampled(kept)
        if change > self._limit and self._at(kept, part, piece) > self._limit:
            return False
        verdicts = [self._within(self._difference(kept, part)) for part in Part]
        return None if None in verdicts and False not in verdicts else all(verdicts)

    def _within(self, difference: Difference) -> bool | None:
        """Whether a difference exceeds the tolerance nowhere; None where that is undecided."""
        # by the exact functions only where balls cannot separate the supremum from the tolerance
        found = difference.supremum(self._limit)
        if found.most <= self._limit or found.least > self._limit:
            return found.most <= self._limit
        return difference.stays_within(self.tolerance)

    def _difference(self, kept: Kept, part: Part) -> Difference:
        return Difference(self.scene, self.balls, kept, part)

    def _at(self, kept: Kept, part: Part, piece: BandPiece) -> float:
        """A proven lower bound of the change of a ratio in the middle of a piece."""
        with series_arithmetic():
            return self._difference(kept, part).at_middle(piece)

    @cached_property
    def _limit(self) -> float:
        """The largest float that is not above the tolerance."""
        near = float(self.tolerance)
        return (
            near if Rational(*near.as_integer_ratio()) <= self.tolerance else nextafter(near, -inf)
        )

    def _sampled(self, kept: Kept) -> tuple[float, Part, BandPiece]:
        """The largest change among samples, not proven, and where it is."""
        both = self._samples.ratios(kept)
        with np.errstate(invalid="ignore"):
            # Infinite less infinite, at a pole of both, is nan, and shows no change.
            change = np.nan_to_num(np.abs(both - self._all), nan=0.0)
        part, index = np.unravel_index(int(change.argmax()), change.shape)
        return float(change[part, index]), tuple(Part)[int(part)], BandPiece(_DEPTH, int(index))

    @cached_property
    def _samples(self) -> _Samples:
        return _Samples(self.balls)

    @cached_property
    def _all(self) -> NDArray[np.float64]:
        return self._samples.ratios(self.balls.everything)


class _Samples:
    """The links of a scene in the middles of pieces, as floats."""

    def __init__(self, balls: BallChain) -> None:
        self.balls = balls
        with series_arithmetic(), np.errstate(all="ignore"):
            self.omega = np.array(
                [float(balls.middle(BandPiece(_DEPTH, i))) for i in range(1 << _DEPTH)]
            )
            self.links = [InSteps(program, FLOATS) for program in balls.programs]
            self.known = [link.known(1j * self.omega) for link in self.links]

    def ratios(self, kept: Kept) -> NDArray[np.float64]:
        """r_r and r_i in two rows, in floats without a bound on their errors."""
        with np.errstate(all="ignore"):
            H, *state = self.links[0].results(self.known[0])
            for i in sorted(kept):
                state = [*self.links[1 + i].results(self.known[1 + i], state)]
            size = np.abs(H)
            parts = [self.balls.part_of(state[1], part) for part in Part]
            ratios = [np.abs(x / size) for x in parts]
        return np.stack([np.broadcast_to(x, self.omega.shape) for x in ratios])


_FINEST = 10  # halvings of the band after which two effects count as equal: 1/1000 of it


@dataclass(frozen=True)
class Influence:
    """What leaving out one effect changes: per part the supremum of ``|r(full) - r(without it)|``
    on the band; infinite if unbounded. ``kept`` : whether the effect is among those kept."""

    effect: Effect
    change: Mapping[Part, Supremum]
    kept: bool


@dataclass(frozen=True)
class CrossingEnclosure(Judged):
    """An interval of the band, rad/s, in which the full scene's ratio may cross its threshold:
    outside all of them it does not.

    ``certain`` : whether it holds at least one, as the ratio is on different sides of its threshold
    below and above; otherwise it may hold none or several.
    """

    criterion: Criterion
    low: RealNumber
    high: RealNumber
    certain: bool

    @property
    def bounds(self) -> tuple[float, float]:
        """The ends as floats, rounded outward."""
        low, high = self.low.bounds(60)[0], self.high.bounds(60)[1]
        down, up = float(low), float(high)
        return down if down <= low else nextafter(down, 0), up if up >= high else nextafter(up, inf)


@dataclass(frozen=True)
class Dominance:
    """An interval, rad/s, on which one effect changes r_r or r_i more than any other one changes
    either: proven."""

    effect: Effect
    low: Expr
    high: Expr


@dataclass(frozen=True, repr=False)
class Relevance(Answer):
    """Which effects of a scene matter for a tolerance.

    ``tolerance`` : by how much r_r and r_i may change, 1. ``pruned`` : the scene with the effects
    that are kept.
    ``bound`` : of each part the largest change of its ratio on the band that leaving out all others
    makes together, 1; proven.
    ``smallest`` : whether it is proven that no smaller set of effects is within the tolerance
    (``docs/reference-tolerances.md``).
    ``dropped``, ``effects`` : the names left out, and a row for each effect.

    >>> import haptisym as hs
    >>> found = hs.relevance("sidestick", "0.01")
    >>> found.dropped, found.smallest
    ((), True)
    """

    _schema: ClassVar[str] = "haptisym.effects/1"
    _page: ClassVar[str] = "haptisym.pages.effects:page"
    _figure: ClassVar[str] = "haptisym.figures.effects:EFFECTS"

    scene: Scene
    tolerance: Expr
    pruned: Scene
    bound: Mapping[Part, Supremum]
    smallest: bool
    balls: BallChain

    def _line(self) -> str:
        kept = f"{len(self.pruned.effects)} of {len(self.scene.effects)} effects"
        return f"{titled(self.scene.title)}: {kept} matter for a tolerance of {self.tolerance}"

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy puts the scene into ball arithmetic again: balls cannot be pickled."""
        return _again, (self.scene, self.tolerance, self.pruned, self.bound, self.smallest)

    @property
    def dropped(self) -> tuple[Effect, ...]:
        """The effects that are left out."""
        return tuple(e for e in self.scene.effects if e not in self.pruned.effects)

    @cached_property
    def effects(self) -> tuple[Influence, ...]:
        """Every effect of the scene with its influence."""
        return tuple(
            Influence(
                effect,
                {part: self.without(i, part).supremum() for part in Part},
                effect in self.pruned.effects,
            )
            for i, effect in enumerate(self.scene.effects)
        )

    def without(self, index: int, part: Part) -> Difference:
        """The change of a ratio, a function of omega, by leaving out one effect."""
        return Difference(self.scene, self.balls, self.balls.everything - {index}, part)

    @cached_property
    def crossings(self) -> tuple[CrossingEnclosure, ...]:
        """The intervals that hold the full scene's crossings, in ascending order; elsewhere on the
        band there is none."""
        found = [
            enclosure for x in noticed(self.pruned.threshold) for enclosure in self._enclosures(x)
        ]
        return tuple(sorted(found, key=lambda x: (float(x.low), x.criterion.name)))

    def _enclosures(self, criterion: Criterion) -> Iterator[CrossingEnclosure]:
        """The intervals of one criterion, and places at which the chart is undecided."""
        # the kept ratio is not below the low level, nor above the high one
        table = chart(self._levels(criterion), *self.pruned.band)
        for x in table.where(lambda signs: signs.get("low", 1) >= 0 >= signs.get("high", -1)):
            yield CrossingEnclosure(criterion, x.low.omega, x.high.omega, _passes(table, x))
        for point in table.undecided:
            yield CrossingEnclosure(criterion, point.omega, point.omega, certain=False)

    def _levels(self, criterion: Criterion) -> dict[str, Signed]:
        """Functions of the kept scene: ``high`` positive where the full one is above, ``low``
        negative where it is below.

        None for a region: its crossings may be anywhere on the band.
        """
        d = self.pruned.distortion()
        if criterion.part is None or criterion.region:
            return {}
        c, square = criterion.threshold, criterion.measure(d)
        bound = Rational(*self.bound[criterion.part].most.as_integer_ratio())
        above, below = c + bound, c - bound
        levels: dict[str, Signed] = {"high": replace(criterion, threshold=above).exceeded(square)}
        # squares are compared: a negative level, below which no ratio lies, would count as its
        # modulus
        is_positive = positive(below, *self.pruned.band) if c.has(omega) else below.evalf() > 0
        if is_positive:
            levels["low"] = replace(criterion, threshold=below).exceeded(square)
        return levels

    @cached_property
    def operations(self) -> tuple[int, int]:
        """Arithmetic operations of the distortion in named steps: for all effects, and for those
        that are kept."""
        full = self.scene.chain.steps.operations
        return full, self.pruned.chain.steps.operations if self.dropped else full

    @cached_property
    def dominance(self) -> tuple[Dominance, ...]:
        """Which effect changes the ratios most, along the band; in the gaps two effects are equal,
        or it is undecided, to 1/1000 of the band."""
        with series_arithmetic():
            pieces = list(self._dominated())
        found = []
        for index, run in groupby(pieces, key=lambda pair: pair[0]):
            if index is not None:
                ends = [self.balls.ends(piece) for _, piece in run]
                found.append(Dominance(self.scene.effects[index], ends[0][0], ends[-1][1]))
        return tuple(found)

    def _dominated(self) -> Iterator[tuple[int | None, BandPiece]]:
        """The band in pieces, each with the effect that dominates on it, if one does."""
        waiting = Waiting([BandPiece()])
        for piece in waiting:
            ranges = [self._range(i, piece) for i in range(len(self.scene.effects))]
            first = max(range(len(ranges)), key=lambda i: ranges[i].least, default=None)
            # one effect changes more everywhere on the piece than any other one anywhere
            dominates = first is not None and all(
                x.most < ranges[first].least for i, x in enumerate(ranges) if i != first
            )
            if dominates:
                yield first, piece
            elif first is None or piece.depth >= _FINEST:
                yield None, piece
            else:
                waiting.add(*piece.halves())

    def _range(self, index: int, piece: BandPiece) -> SupremumBounds:
        """Bounds on the larger one of an effect's changes of r_r and r_i on a piece."""
        real, imag = (self.without(index, part).range(piece) for part in Part)
        return SupremumBounds(
            max(real.least, imag.least), max(real.reached, imag.reached), max(real.most, imag.most)
        )

    def _body(self) -> dict[str, Any]:
        return {
            "tolerance": float(self.tolerance),
            "effects": [
                {
                    "name": x.effect.name,
                    "model": x.effect.model,
                    "influence": _upper(x.change),
                    "kept": x.kept,
                }
                for x in self.effects
            ],
            **self._full(),
            "dominance": [
                {"name": x.effect.name, "band": [float(x.low), float(x.high)]}
                for x in self.dominance
            ],
            "operations": dict(zip(("full", "kept"), self.operations, strict=True)),
        }

    def row(self) -> dict[str, Any]:
        """The part on the full scene of a document about the pruned one."""
        names = {
            "kept": [e.name for e in self.pruned.effects],
            "dropped": [e.name for e in self.dropped],
        }
        return {"tolerance": float(self.tolerance), **names, **self._full()}

    def _full(self) -> dict[str, Any]:
        """What is proven of the full scene: bound, crossings, and whether no smaller set of effects
        does."""
        return {
            "bound": _upper(self.bound),
            "smallest": self.smallest,
            "crossings": [
                {"part": x.criterion.name, "enclosure": [*x.bounds], "certain": x.certain}
                for x in self.crossings
            ],
        }


def _upper(change: Mapping[Part, Supremum]) -> dict[str, float | None]:
    """Certified upper bounds; null where there is none."""
    return {part.value: change[part].most if change[part].is_finite else None for part in Part}


def _again(
    scene: Scene,
    tolerance: Expr,
    pruned: Scene,
    bound: Mapping[Part, Supremum],
    smallest: bool,  # noqa: FBT001
) -> Relevance:
    return Relevance(scene, tolerance, pruned, bound, smallest, BallChain(scene))


def _passes(table: Chart, interval: Interval) -> bool:
    """Whether the kept scene's ratio comes from one side of both levels and leaves to the other."""
    if interval.low is table.points[0] or interval.high is table.points[-1]:
        return False
    before, after = interval.low.before, interval.high.after
    # outside the interval the ratio is below both levels or above both, and the full one with it
    below = [signs.get("low", 1) < 0 for signs in (before, after)]
    return below[0] != below[1]


TOLERANCE = Rational(1, 100)
"""Unless told otherwise: a tenth of the usual JND."""


def relevance(
    scene: Scene | str | Path, tolerance: Number = TOLERANCE, *, limit: float | None = SECONDS
) -> Relevance:
    """Find which effects of a scene matter: the fewest with which r_r and r_i stay within a
    tolerance of the full scene's.

    ``tolerance`` : a number >= 0, of the ratios. Proven: the bound holds at every frequency of
    the band for both ratios and all left-out effects together; of 12 effects or fewer no smaller
    set does. ``limit`` : seconds of processor time after which a LimitError is raised;
    None for none. Raises SceneError for a scene with symbols for numbers, and for a
    tolerance that is none.

    >>> from haptisym import effects, environments
    >>> from haptisym.model.jnd import Part
    >>> between = (effects.first_order_lag("20 rad/s"), effects.first_order_lag("1 MHz", name="cable"))
    >>> found = relevance(Scene(environments.mass_spring_damper(1.8, 15, 100), between))
    >>> [e.name for e in found.pruned.effects], found.bound[Part.REAL].most < 1e-5
    (['first-order-lag'], True)
    """
    scene = as_scene(scene)
    most = _tolerance(tolerance)
    scene.knobs.need_numbers()
    balls = BallChain(scene)
    with limited(limit):
        choice = SubsetSearch(scene, balls, most).choose()
    kept = tuple(effect for i, effect in enumerate(scene.effects) if i in choice.kept)
    return Relevance(
        scene, most, replace(scene, effects=kept), choice.bound, choice.smallest, balls
    )


def _tolerance(given: Number) -> Expr:
    """A tolerance as an exact number; SceneError where it is not rational, or negative."""
    try:
        value = number(given, Dimension.RATIO).value
    except SceneError as error:
        raise error.within("tolerance") from None
    if not value.is_Rational or sign_of_number(value) < 0:
        raise SceneError(f'tolerance: "{given}" must be rational and >= 0')
    return value
