"""How far the crossings of a cluster go, over all values of the box: the ends of an enclosure.

Where crossings are regular they move one way with each parameter whose slope keeps its sign, so that they go farthest on the
face of the box on which all these stand at their ends. On that face the crossings take up less of the band, and there further
slopes may keep their signs: so it goes on, until a corner is left, which is answered exactly, or a face that is bounded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import TypeAlias

from sympy import Expr, Rational

from haptisym.judge.criteria import Criterion, noticed
from haptisym.kernel.errors import LimitError
from haptisym.kernel.reals import ExactNumber, RealNumber
from haptisym.verbs.tolerances.box import Box
from haptisym.verbs.tolerances.search import OVERLAP, Cluster, Excess, beyond, clusters, excess_of
from haptisym.verbs.tolerances.single import One, in_time

TOLERANCE = Fraction(1, 1000)
"""Of an end that is not exact: how far, relatively, it may lie beyond what is reached."""
MOST_CORNERS = 64  # sets of values that are tried as witnesses or as ends

End: TypeAlias = tuple[RealNumber, Mapping[str, Expr] | None]
"""A frequency, rad/s, and the corner of the box at which it is reached; None if it is a bound."""


@dataclass(frozen=True)
class Face:
    """Of a box the sets of values in which some sides stand at an end.

    ``name`` : of the criterion; ``fixed``: 0 for sides at their low end, 1 for those at their high one; ``one``: answers a set
    of values of the whole box with certainty.
    """

    whole: Box
    name: str
    fixed: Mapping[str, Fraction]
    one: Callable[[Mapping[str, Expr]], One]

    @cached_property
    def box(self) -> Box:
        """What still varies."""
        return Box(self.whole.scene.with_values(self._values(self.fixed))) if self.fixed else self.whole

    @cached_property
    def form(self) -> Excess:
        """The excess of the criterion of that name on this face."""
        return excess_of(self.box, next(x for x in noticed(self.box.scene.threshold) if x.name == self.name))

    def _values(self, shares: Mapping[str, Fraction]) -> dict[str, Expr]:
        return {side.name: side.at(shares[side.name]) for side in self.whole.sides if side.name in shares}

    def end(self, form: Excess, cluster: Cluster, *, highest: bool) -> End | None:
        """How high (low) the crossings of a cluster go on this face; None if it is proven that there is none."""
        moves = {x: n for x, n in self.moves(form, cluster, highest=highest).items() if n is not None}
        settled = cluster.regular and cluster.clear_of(highest=highest)
        if settled and moves and len(moves) < len(self.box.sides):
            face = Face(self.whole, self.name, {**self.fixed, **moves}, self.one)
            try:
                found = clusters(face.form, (cluster.low, cluster.high))
            except LimitError:
                return self._bound(form, cluster, None, highest=highest)
            ends = (face.end(face.form, x, highest=highest) for x in (reversed(found) if highest else found))
            return next((x for x in ends if x), None)
        corners = list(in_time(self._corners(form, cluster, highest=highest)))
        reached = [(x, at.values) for at in corners for x in at.crossings[self.name] if within(self.whole, x, cluster)]
        best = (max if highest else min)(reached, key=lambda x: float(x[0]), default=None)
        if settled and corners and len(moves) == len(self.box.sides) and (best or cluster.inside):
            return best  # without a crossing at its one corner a cluster has none
        return self._bound(form, cluster, best, highest=highest)

    def moves(self, form: Excess, cluster: Cluster, *, highest: bool) -> dict[str, Fraction | None]:
        """For each side the end at which the crossings of a cluster are highest (lowest), None where that is not known."""
        way = -cluster.signs[0] * (1 if highest else -1)
        signs = dict(
            zip((x.name for x in self.box.sides), zip(form.matters[1:], cluster.signs[1:], strict=True), strict=True)
        )
        return {
            x: Fraction(int(way * sign > 0)) if way * sign or not used else None for x, (used, sign) in signs.items()
        }

    def _corners(self, form: Excess, cluster: Cluster, *, highest: bool) -> Iterator[One]:
        """The corners at which crossings may be highest (lowest), each answered exactly."""
        moves = {**self.moves(form, cluster, highest=highest), **self.fixed}
        choices = [
            [x] if x is not None else [Fraction(0), Fraction(1)] for x in (moves[y.name] for y in self.whole.sides)
        ]
        names = [side.name for side in self.whole.sides]
        for _, shares in zip(range(MOST_CORNERS), product(*choices), strict=False):
            yield self.one(self._values(dict(zip(names, shares, strict=True))))

    def _bound(self, form: Excess, cluster: Cluster, best: End | None, *, highest: bool) -> End:
        low, high = self.whole.scene.band
        leaf = cluster.high if highest else cluster.low
        share = leaf
        if best:
            slack = float(TOLERANCE) * float(best[0]) * (1 if highest else -1)
            reached = (float(best[0]) + slack - float(low)) / float(high - low)
            share = beyond(form, cluster.cells, reached, highest=highest)
            share = min(share, leaf) if highest else max(share, leaf)  # not into the frequencies of another cluster
        return at_share(self.whole, share), None


def at_share(box: Box, share: float) -> RealNumber:
    """A frequency that share of the way through the band."""
    low, high = box.scene.band
    exact = Fraction(min(max(share, 0.0), 1.0))
    return ExactNumber(low + Rational(exact.numerator, exact.denominator) * (high - low))


def within(box: Box, x: RealNumber, cluster: Cluster) -> bool:
    """Whether a crossing is one of those of a cluster."""
    low, high = box.scene.band
    share = (float(x) - float(low)) / float(high - low)
    return cluster.low - OVERLAP / 4 <= share <= cluster.high + OVERLAP / 4


def end_of(
    box: Box, criterion: Criterion, form: Excess, cluster: Cluster, one: Callable[..., One], *, highest: bool
) -> End:
    """How high (low) the crossings of a cluster go, for all values of the box."""
    found = Face(box, criterion.name, {}, one).end(form, cluster, highest=highest)
    return found or (at_share(box, cluster.high if highest else cluster.low), None)
