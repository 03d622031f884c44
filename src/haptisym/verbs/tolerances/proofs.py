"""What can be said about a scene whose parameters are known as ranges: proven for all values in the box, or for none.

Two things are kept apart. Proven: the verdict, by branch and bound over band and box in Taylor models (``search``) and by
certified charts of single sets of values; the enclosures of the crossings. Estimated: quantiles over sets drawn at random.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any, ClassVar

import numpy as np
from sympy import Expr

from haptisym.judge.answers import Answer
from haptisym.judge.criteria import Criterion, noticed
from haptisym.kernel.budget import Budget, share
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.kernel.shown import counted, titled
from haptisym.model.scene import Scene
from haptisym.verbs.tolerances.box import Box
from haptisym.verbs.tolerances.ends import MOST_CORNERS, end_of, within
from haptisym.verbs.tolerances.heldbox import HeldInBox
from haptisym.verbs.tolerances.quantiles import quantiles
from haptisym.verbs.tolerances.search import Cluster, Excess, clusters, excess_of
from haptisym.verbs.tolerances.single import One, in_time, one
from haptisym.verbs.tolerances.verdicts import Enclosure, Verdict

_SHARE = 0.4  # of the time that is left, for the first search of two


@dataclass(frozen=True, repr=False)
class Tolerances(Answer):
    """The answers for a box of parameters; ``samples`` are estimates, all else is proven."""

    _schema: ClassVar[str] = "haptisym.tolerances/1"
    _page: ClassVar[str] = "haptisym.pages.tolerances:page"
    _figure: ClassVar[str] = "haptisym.figures.tolerances:tolerances_figure"

    box: Box
    samples: tuple[One, ...]
    seed: int = 0
    budget: Budget | None = None
    held: tuple[HeldInBox, ...] = ()
    """For which values the display is stable in each hand of the scene."""

    def _line(self) -> str:
        sides = ", ".join(x.name for x in self.box.sides)
        found = counted(len(self.enclosures), "enclosure")
        return f"{titled(self.box.scene.title)}: {sides} in their ranges, transparent for {self.verdict.value}, {found}"

    @property
    def _about(self) -> Scene:
        return self.box.scene

    @property
    def _varied(self) -> tuple[Collection[str], Collection[str]]:
        ranges = self.box.scene.ranges()
        return ranges, ranges

    @cached_property
    def criteria(self) -> tuple[Criterion, ...]:
        """What is judged, with nominal thresholds."""
        return noticed(self.box.scene.threshold)

    @property
    def limit(self) -> float | None:
        """The seconds of a limit that cut the work short; None if none did."""
        return self.budget.seconds if self.budget and self.budget.reached else None

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
        forms = {x: excess_of(self.box, x) for x in self.criteria}
        found: dict[Excess, tuple[Cluster, ...]] = {}
        for form in forms.values():
            with share(_SHARE if len(found) < len(forms) - 1 else 1 - _SHARE):
                found[form] = clusters(form)
        return {x: (form, found[form]) for x, form in forms.items()}

    @cached_property
    def enclosures(self) -> tuple[Enclosure, ...]:
        """Where crossings lie, for all values: outside these there is none, for no values of the box."""
        found = (self._enclosure(x, form, y) for x, (form, own) in self._search.items() for y in own)
        return tuple(sorted(found, key=lambda x: (float(x.low), x.criterion.name)))

    @cached_property
    def _corners(self) -> tuple[One, ...]:
        """The box's corners, or as many of them as are looked at."""
        ends = product((Fraction(0), Fraction(1)), repeat=len(self.box.sides))
        names = [side.name for side in self.box.sides]
        shares = [dict(zip(names, x, strict=True)) for _, x in zip(range(MOST_CORNERS), ends, strict=False)]
        return tuple(in_time(self.one(self.box.values(x)) for x in shares))

    def settle(self) -> None:
        """Find everything that is told, so that a limit is kept to; LimitError if not even the nominal values are."""
        _ = self.nominal, self._search, self.enclosures, self.verdict, self.transparent, self.noticed, self.bandwidth

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the display is transparent on the band for all values, for none, or for some."""
        if self.transparent is not None and self.noticed is not None:
            return Verdict.DEPENDS
        alone = not self.box.sides or not any(own for _, own in self._search.values())
        if alone and self.nominal.transparent is not None:
            return Verdict.ALL if self.nominal.transparent else Verdict.NONE
        if self._always_noticed():
            return Verdict.NONE
        return Verdict.ALL if self._never_noticed() else Verdict.UNDECIDED

    def _never_noticed(self) -> bool:
        """Whether for no values any frequency is, as where a ratio just reaches its threshold for some.

        Where a cluster is steady, the values along which r grows everywhere lead to one corner, and r - c, once above 0, stays so
        on the way: outside of clusters it is nowhere 0. So nothing is noticed if nothing is at those corners.
        """
        corners = [self._greatest(form, x) for form, own in self._search.values() for x in own]
        try:
            return all(x is not None and self.one(x).transparent is True for x in [{}, *corners])
        except LimitError:
            return False

    def _greatest(self, form: Excess, cluster: Cluster) -> dict[str, Expr] | None:
        """The values for which r - c is greatest in a cluster; None where that is not known."""
        signs = [x if matters else 1 for x, matters in zip(cluster.signs[1:], form.matters[1:], strict=True)]
        if not all(signs):
            return None
        return self.box.values({x.name: Fraction(int(n > 0)) for x, n in zip(self.box.sides, signs, strict=True)})

    @cached_property
    def transparent(self) -> One | None:
        """A set of values for which the display is transparent on the band, certified; None if none was found."""
        return next((x for x in self._witnesses() if x.transparent is True), None)

    @cached_property
    def noticed(self) -> One | None:
        """A set of values for which it is not, certified; None if none was found."""
        return next((x for x in self._witnesses() if x.transparent is False), None)

    def _witnesses(self) -> Iterator[One]:
        yield self.nominal
        yield from self.samples
        if not self._always_noticed():
            yield from self._corners

    def _always_noticed(self) -> bool:
        """Whether some frequency is noticed whatever the values: one between clusters, at which a ratio exceeds for all."""
        return any(self._exceeds_between(x) is not None for x in self.criteria)

    def _exceeds_between(self, criterion: Criterion) -> float | None:
        """The lowest share of the band outside all clusters at which r exceeds c, for the nominal and so for all values."""
        form, own = self._search[criterion]
        if form.is_zero:
            return None
        start = 0.0
        for low, high in [*((x.low, x.high) for x in own), (1.0, 1.0)]:
            if low > start:
                middle = np.array([[[(start + low) / 2] * 2, *[[0.5, 0.5]] * (form.sides - 1)]])
                try:
                    exceeds = form.model(middle).bounds()[0][0, 0] > 0
                except LimitError:
                    return None
                if exceeds:
                    return start
            start = max(start, high)
        return None

    @cached_property
    def bandwidth(self) -> tuple[RealNumber, RealNumber] | None:
        """The least and the greatest that the bandwidth can be, guaranteed; None if not transparent from the low end on."""
        low, high = (ExactNumber(x) for x in self.box.scene.band)
        if self.nominal.bandwidth is None or any(float(x.low) <= float(low) for x in self.enclosures):
            return None
        least = min([x.low for x in self.enclosures] or [high], key=float)
        ends = [self._end_of_first(x) for x in self.criteria]
        return least, min([x for x in ends if x is not None] or [high], key=float)

    def _end_of_first(self, criterion: Criterion) -> RealNumber | None:
        """From where on r exceeds c whatever the values, at the latest; None if nowhere for certain."""
        share = self._exceeds_between(criterion)
        if share is None:
            return None
        before = [x for x in self.enclosures if x.criterion == criterion and x.high is not None]
        low, high = self.box.scene.band
        edge = float(low) + share * float(high - low)
        return max((x.high for x in before if float(x.high) <= edge * (1 + 1e-9)), key=float, default=None)

    @property
    def certified(self) -> bool:
        """Whether the verdict is proven, and that on each hand."""
        return self.verdict is not Verdict.UNDECIDED and all(x.share for x in self.held)

    def _enclosure(self, criterion: Criterion, form: Excess, cluster: Cluster) -> Enclosure:
        steady = self._steady(form, cluster)
        alone = cluster.regular and cluster.inside
        own = [x for x in self.nominal.crossings[criterion.name] if within(self.box, x, cluster)]
        count = len(own) if alone and own else None
        ends = [end_of(self.box, criterion, form, cluster, self.one, highest=highest) for highest in (False, True)]
        (low, at_low), (high, at_high) = ends
        return Enclosure(criterion, low, high, count, at_low, at_high, steady)

    def _steady(self, form: Excess, cluster: Cluster) -> dict[str, int]:
        """The way in which the crossings of a cluster move with each parameter."""
        moves = [-sign * cluster.signs[0] for sign in cluster.signs[1:]]
        return {side.name: int(n) for side, n in zip(self.box.sides, moves, strict=True)}

    def _body(self) -> dict[str, Any]:
        sides = [{"name": x.name, "low": float(x.low), "high": float(x.high)} for x in self.box.sides]
        return {
            "band": [float(x) for x in self.box.scene.band],
            "varying": sides,
            "verdict": self.verdict.value,
            "witnesses": {"transparent": _witness(self.transparent), "noticed": _witness(self.noticed)},
            "crossings": [self._enclosure_row(x) for x in self.enclosures],
            "bandwidth": None if self.bandwidth is None else [float(x) for x in self.bandwidth],
            **({"held": [x.row() for x in self.held]} if self.held else {}),
            "estimates": self._estimates(),
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        return {} if self.limit is None else {"limit": self.limit}

    def _enclosure_row(self, x: Enclosure) -> dict[str, Any]:
        corners = {"low": _values(x.at_low), "high": _values(x.at_high)}
        enclosure = [x.low.enclosure()[0], x.high.enclosure()[1]]
        row = {"part": x.criterion.name, "omega": [float(x.low), float(x.high)], "enclosure": enclosure}
        return {**row, "count": x.count, "reached_at": corners, "monotonic": dict(x.monotonic)}

    def _estimates(self) -> dict[str, Any] | None:
        if not self.samples:
            return None
        q = quantiles(self.samples)
        rows = {"first_crossing": q.first, "bandwidth": q.bandwidth}
        shown = {key: {str(p): x for p, x in row.items()} for key, row in rows.items()}
        return {"samples": len(self.samples), "seed": self.seed, **shown, "transparent": q.transparent}


def _witness(one: One | None) -> dict[str, str] | None:
    return None if one is None else _values(one.values)


def _values(values: Mapping[str, Expr] | None) -> dict[str, str] | None:
    return None if values is None else {name: str(x) for name, x in values.items()}
