"""For which values of one parameter a polynomial condition holds all over a band: exact.

A condition N(omega, t) <= 0, N a polynomial, holds on the whole band for a set of values t. The set can begin or end only
where a zero of N in omega enters over an end of the band, N(end, t) = 0, or where two zeros meet: where the discriminant of
a factor of N or the resultant of two factors vanishes. These *critical values* are roots of polynomials in t; between
neighbours the answer is the same for all t, and one exact test at a rational number tells it (a cylindrical
decomposition in one parameter). At a critical value itself the answer is that of a feasible neighbour, as what does not
exceed does not exceed in the limit; between two others it is tested in the number field of the value. Of several polynomials
that must not all be positive, as a region asks for, the factors are those of all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from sympy import Expr, Integer, Symbol

from haptisym.judge.criteria import Criterion
from haptisym.kernel.budget import tick
from haptisym.kernel.errors import LimitError
from haptisym.kernel.ordering import in_order
from haptisym.kernel.reals import ExactNumber, RealNumber, rational_between
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import sign_of_number
from haptisym.verbs.require.boundary import Reason, critical, in_square, irreducible, is_even, real_roots
from haptisym.verbs.require.breaking import Breaking, BrokenInterval, Cell, approached
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, runs
from haptisym.verbs.require.freeparameter import Conditions, Domain
from haptisym.verbs.require.touches import Surfaces, isolated_touch

_LARGE, _LARGE_ODD = 10, 16
"""Degree in omega^2 of a condition, a device of order 4; in omega, where odd powers are among them."""
_NEAR = ((12, 0), (48, 0), (192, 0), (12, 6), (48, 24), (192, 96))
"""Bits by which a value is approached for its touches, and how far outside of the excess they are sought: zeros of two factors
that move to the same side meet outside."""


@dataclass(frozen=True)
class Problem:
    """Conditions in omega and one parameter, to be kept on a whole band; ``allowed``: whether the scene exists at a value."""

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]
    domain: Domain
    allowed: Callable[[Expr], bool]

    def solve(self) -> Solved:
        """All values of the domain for which every condition holds on the whole band, as intervals in order.

        LimitError if the time does not last for the critical values; if not for what lies between them, that stays undecided.
        """
        values = self._values
        low, high = self.domain.low, self.domain.high
        places: list[RealNumber | None] = [*([None] if low is None else []), *values, *([None] if high is None else [])]
        cells = [self._cell(a, b, i / len(places)) for i, (a, b) in enumerate(pairwise(places))]
        around = list(zip([None, *cells], [*cells, None], strict=True))
        at = [self._known_to_hold(x, *near) for x, near in zip(places, around, strict=True)]

        def end(i: int, *, closed: bool) -> End:
            beside_open = None in cells[max(i - 1, 0) : i + 1]  # the set may go on there
            return End(places[i], closed, () if beside_open else self._bindings(places[i], around[i]))

        found = runs([x is True for x in at], [cell is not None and cell.feasible for cell in cells])
        open_ = runs([x is None for x in at], [cell is None for cell in cells])
        spans = []
        for i, j, a, b in found:
            low = end(i, closed=a)
            spans.append(Span(low, low if i == j else end(j, closed=b)))  # of a single value both ends are one
        return Solved(tuple(spans), tuple((places[i], places[j]) for i, j, _, _ in open_))

    @property
    def is_large(self) -> bool:
        """Whether critical values take long, and balls tell the same: the scene exists for all values of the domain."""
        functions = [piece.function for own in self._breaking.pieces.values() for piece in own]
        if not any(_is_large(f.numerator) for f in functions if not f.numerator.is_zero()):
            return False
        below = [f for g in functions for f, _ in irreducible(g.denominator)]
        return not any(f.degrees()[self._breaking.index] and not f.degrees()[0] for f in below)

    def prepare(self) -> None:
        """Find the critical values, which is most of the work."""
        self._values  # noqa: B018 - kept from here on

    def _cell(self, low: RealNumber | None, high: RealNumber | None, done: float) -> Cell | None:
        """The values between two neighbours; None where the time was over before they were decided."""
        try:
            tick(done, 1, "values between critical ones")
            sample = rational_between(low, high)
            return Cell(sample, self._breaking.at(sample))
        except LimitError:
            return None

    def _known_to_hold(self, value: RealNumber | None, before: Cell | None, after: Cell | None) -> bool | None:
        """Whether the conditions hold at a value; None where the time was over before that was decided."""
        try:
            return value is not None and self._holds(value, before, after)
        except LimitError:
            return None

    # Critical values

    @cached_property
    def _values(self) -> list[RealNumber]:
        """The critical values in the domain and its ends, in order."""
        ends = [ExactNumber(x) for x in (self.domain.low, self.domain.high) if x is not None]
        inside = in_order([*ends, *(x for x in self._reasons if not any(_equal(x, end) for end in ends))])
        start = inside.index(ends[0]) if self.domain.low is not None else 0
        stop = inside.index(ends[-1]) + 1 if self.domain.high is not None else len(inside)
        return inside[start:stop]

    @cached_property
    def _reasons(self) -> dict[RealNumber, set[Reason]]:
        """All critical values, and why each is one."""
        found: dict[RealNumber, set[Reason]] = {}
        if self._negative:
            found[ExactNumber(Integer(0))] = set()
        for criterion, own in self._breaking.pieces.items():
            for reason, polynomial in critical(criterion, own, self.band):
                for factor, _ in polynomial.factor()[1]:
                    for value in real_roots(factor, self._breaking.index, negative=self._negative):
                        found.setdefault(value, set()).add(reason)
        return found

    @property
    def _negative(self) -> bool:
        """Whether the domain may hold values below 0."""
        return self.domain.low is None or sign_of_number(self.domain.low) < 0

    @cached_property
    def _breaking(self) -> Breaking:
        return Breaking(self.conditions, self.free, self.band)

    def _holds(self, value: RealNumber, before: Cell | None, after: Cell | None) -> bool:
        """Whether the conditions hold at a critical value, or at an end of the domain."""
        if not self._belongs(value):
            return False
        if isinstance(value, ExactNumber):
            return self.allowed(value.value) and not self._breaking.at(value.value)
        if None in self._reasons[value]:
            return False
        if (before and before.feasible) or (after and after.feasible):
            return True
        return not self._breaking.near(value, [cell for cell in (before, after) if cell])

    def _belongs(self, value: RealNumber) -> bool:
        low = self.domain.low is not None and value == ExactNumber(self.domain.low)
        high = self.domain.high is not None and value == ExactNumber(self.domain.high)
        return not (low and not self.domain.holds_low) and not (high and not self.domain.holds_high)

    # What binds

    def _bindings(self, value: RealNumber | None, around: tuple[Cell | None, Cell | None]) -> tuple[Binding, ...]:
        if value is None:
            return ()
        reasons = self._reasons.get(value, set())
        at_ends: dict[tuple[str, Kind], Binding] = {}  # of the edges of a region one
        for criterion in self.conditions:
            for kind, end in zip((Kind.EDGE, Kind.START), self.band[::-1], strict=True):
                if (criterion, kind) in reasons and self._breaking.may_bind(criterion, ExactNumber(end), value):
                    at_ends.setdefault((criterion.name, kind), Binding(criterion, ExactNumber(end), kind))
        found = at_ends.values()
        touching = [criterion for criterion in self.conditions if (criterion, Kind.TOUCH) in reasons]
        try:
            touches = [x for criterion in touching for x in self._touches(criterion, value, around)]
            return tuple(_distinct([*found, *touches]))  # a touch at an end of the band is what binds there
        except LimitError:  # at which frequency was not found in time
            return (*found, *(Binding(criterion, None, Kind.TOUCH) for criterion in touching))

    def _touches(
        self, criterion: Criterion, value: RealNumber, around: tuple[Cell | None, Cell | None]
    ) -> Iterator[Binding]:
        """The touches inside the band at a value: what the excess just beside it shrinks to."""
        surfaces = [Surfaces.of(piece, self.free) for piece in self._breaking.pieces[criterion]]
        for cell in around:
            if cell is None or cell.feasible:
                continue
            for bits, beyond in _NEAR:
                excess = self._breaking.of(criterion, approached(value, cell.sample, bits))
                near = [x.band for x in excess if self._inside(x)]
                isolated = [isolated_touch(surfaces, value, x, beyond) for x in near]
                if isolated and all(isolated):
                    yield from (Binding(criterion, x, Kind.TOUCH) for x in isolated)
                    return

    def _inside(self, excess: BrokenInterval) -> bool:
        ends = [ExactNumber(x) for x in self.band]
        return excess.band.low.omega not in ends and excess.band.high.omega not in ends


def _equal(x: RealNumber, end: ExactNumber) -> bool:
    return isinstance(x, ExactNumber) and sign_of_number(x.value - end.value) == 0


def _distinct(found: Iterable[Binding]) -> list[Binding]:
    """Without those that another before them has at the same frequency, an end of the band or another term of a region."""
    kept: list[Binding] = []
    for x in found:
        if x.omega is None or not any(_alike(x, y) for y in kept):
            kept.append(x)
    return kept


def _alike(x: Binding, y: Binding) -> bool:
    one, other = x.omega, y.omega
    assert one is not None
    return x.criterion.name == y.criterion.name and other is not None and bool(one.ball(256).overlaps(other.ball(256)))


def _is_large(polynomial: Polynomial) -> bool:
    return int(in_square(polynomial).degrees()[0]) >= (_LARGE if is_even(polynomial) else _LARGE_ODD)
