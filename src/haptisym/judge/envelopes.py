"""Local maxima of how many times a region must be enlarged: of the square that counts, which changes along the band."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple, TypeAlias

from haptisym.judge.criteria import Criterion
from haptisym.judge.regions import Term
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Key, Point, Signs
from haptisym.model.distortion import Distortion

_Place: TypeAlias = tuple[int, int]
"""Of a square: its term, and its place there."""


class Maximum(NamedTuple):
    """The square that has a local maximum; ``jump`` : whether to one side of it another limit holds at once.

    ``after`` : whether that is the side before it.
    """

    square: RealFunction
    jump: bool
    after: bool = False


@dataclass(frozen=True)
class Envelope:
    """What a criterion judges: the largest, over the terms that hold at a frequency, of their least squares."""

    criterion: Criterion
    terms: tuple[Term, ...]

    @classmethod
    def of(cls, x: Criterion, d: Distortion) -> Envelope:
        """Of a criterion: the terms of its region, or the square that it measures."""
        return cls(x, x.region.terms(d) if x.region else (Term((), (x.measure(d),)),))

    @cached_property
    def squares(self) -> dict[_Place, RealFunction]:
        """All squares, by their places."""
        return {(i, j): f for i, term in enumerate(self.terms) for j, f in enumerate(term.squares)}

    def functions(self) -> dict[Key, RealFunction]:
        """All functions whose signs tell where there is a maximum."""
        found: dict[Key, RealFunction] = {(self, "slope", x): f.derivative() for x, f in self.squares.items()}
        found |= {(self, "over", x, y): self.squares[x] - self.squares[y] for x, y in combinations(self.squares, 2)}
        return found | {(self, "where", i, k): f for i, term in enumerate(self.terms) for k, f in enumerate(term.where)}

    def __hash__(self) -> int:
        return hash(self.criterion)

    def top(self, point: Point) -> Maximum | None:
        """The maximum at a point inside of the band; None where there is none, or no bound."""
        before, after = self._counts(point.before), self._counts(point.after)
        rises = before is not None and point.before[self, "slope", before] > 0 and self._is_finite(point, before)
        falls = after is not None and point.after[self, "slope", after] < 0 and self._is_finite(point, after)
        if before is None or after is None:
            over = (before is not None) - (after is not None)
        else:
            over = self._over(point.at, before, after)
        if before is not None and rises and (over > 0 or (not over and falls)):
            return Maximum(self.squares[before], jump=over > 0)
        if after is not None and falls and over < 0:
            return Maximum(self.squares[after], jump=True, after=True)
        return None

    def plateau(self, point: Point) -> Maximum | None:
        """What counts behind a point if it is a number there, and less before it: as of ``top``, though no maximum."""
        before, after = self._counts(point.before), self._counts(point.after)
        if after is None or point.after[self, "slope", after]:
            return None
        over = -1 if before is None else self._over(point.at, before, after)
        if over < 0:
            return Maximum(self.squares[after], jump=True, after=True)
        rises = before is not None and point.before[self, "slope", before] > 0
        return Maximum(self.squares[after], jump=False) if not over and rises else None

    def holds(self, i: int, signs: Signs) -> int:
        """Whether a term holds (1), does not (-1), or is about to (0)."""
        return min((signs[self, "where", i, k] for k in range(len(self.terms[i].where))), default=1)

    def counting(self, signs: Signs) -> tuple[RealFunction, int]:
        """The square that counts between two points at which a term holds, and the sign of its slope."""
        own = self._counts(signs)
        assert own is not None
        return self.squares[own], signs[self, "slope", own]

    def _is_finite(self, point: Point, x: _Place) -> bool:
        return point.orders.get((self, "slope", x), 0) >= 0

    def _counts(self, signs: Signs) -> _Place | None:
        """The square that counts between two points."""
        best: _Place | None = None
        for i, term in enumerate(self.terms):
            if self.holds(i, signs) <= 0:
                continue
            own = [(i, j) for j in range(len(term.squares))]
            least = next(x for x in own if all(self._over(signs, x, y) <= 0 for y in own))
            if best is None or self._over(signs, least, best) > 0:
                best = least
        return best

    def _over(self, signs: Signs, x: _Place, y: _Place) -> int:
        """The sign of the difference of two squares."""
        if x == y:
            return 0
        return signs[self, "over", x, y] if x < y else -signs[self, "over", y, x]
