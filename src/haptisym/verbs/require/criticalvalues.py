"""For which values of one parameter a polynomial condition holds all over a band: exact.

A condition N(omega, t) <= 0, N a polynomial, holds on the whole band for a set of values t. The set can begin or end only
where a zero of N in omega enters over an end of the band, N(end, t) = 0, or where two zeros meet: where the discriminant of
a factor of N or the resultant of two factors vanishes. These *critical values* are roots of polynomials in t; between
neighbours the answer is the same for all t, and one exact test at a rational number tells it (a cylindrical
decomposition in one parameter). At a critical value itself the answer is that of a feasible neighbour, as what does not
exceed does not exceed in the limit; between two others it is tested in the number field of the value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import flint
from flint import arb
from sympy import Expr, Integer, Rational, Symbol, pi

from haptisym.judge.criteria import Criterion
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.eliminants import resultant
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.polynomials import Root
from haptisym.kernel.precision import SURE_BITS, at_rising_precision
from haptisym.kernel.reals import Ball, ExactNumber, Negative, RealNumber, rational_between
from haptisym.kernel.response import RealFunction
from haptisym.kernel.rings import Polynomial
from haptisym.kernel.roots import Interval, chart, in_order, sign_of_number
from haptisym.kernel.symbols import omega
from haptisym.kernel.zeros import sign_of
from haptisym.verbs.require.boundary import Reason, critical, in_square, irreducible, of_factor, real_roots, substituted
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, runs
from haptisym.verbs.require.freeparameter import Conditions, Domain
from haptisym.verbs.require.touches import Surface, touch

_LARGE = 10  # degree in omega^2 of a condition: a device of order 4
_ROUNDS = (8, 32, 128, 512)
"""Bits by which a critical value is approached for a witness, before its number field is asked."""

_NEAR = ((12, 0), (48, 0), (192, 0), (12, 6), (48, 24), (192, 96))
"""Bits by which a value is approached for its touches, and how far outside of the excess they are sought: zeros of two factors
that move to the same side meet outside."""


@dataclass(frozen=True)
class BrokenInterval:
    """Frequencies at which a condition is broken, for a value of the parameter."""

    criterion: Criterion
    band: Interval


@dataclass(frozen=True)
class Cell:
    """An open interval of values with one answer, told at a sample: where conditions are broken there; nowhere if feasible."""

    sample: Rational
    broken: tuple[BrokenInterval, ...]

    @property
    def feasible(self) -> bool:
        return not self.broken


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
        spans = tuple(Span(end(i, closed=a), end(j, closed=b)) for i, j, a, b in found)
        return Solved(spans, tuple((places[i], places[j]) for i, j, _, _ in open_))

    @property
    def is_large(self) -> bool:
        """Whether critical values take long, and balls tell the same: the scene exists for all values of the domain."""
        functions = [condition.function for condition in self.conditions.values()]
        if max(int(in_square(f.numerator).degrees()[0]) for f in functions if not f.numerator.is_zero()) < _LARGE:
            return False
        below = [f for g in functions for f, _ in irreducible(g.denominator)] + [
            g.denominator.term_content() for g in functions
        ]
        return not any(f.degrees()[self._index] and not f.degrees()[0] for f in below)

    def prepare(self) -> None:
        """Find the critical values, which is most of the work."""
        self._values  # noqa: B018 - kept from here on

    def _cell(self, low: RealNumber | None, high: RealNumber | None, done: float) -> Cell | None:
        """The values between two neighbours; None where the time was over before they were decided."""
        try:
            tick(done, 1, "values between critical ones")
            sample = rational_between(low, high)
            return Cell(sample, self._broken(sample))
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
        for criterion, condition in self.conditions.items():
            for reason, polynomial in critical(criterion, condition, self.band):
                for factor, _ in polynomial.factor()[1]:
                    for value in real_roots(factor, self._index, negative=self._negative):
                        found.setdefault(value, set()).add(reason)
        return found

    @property
    def _negative(self) -> bool:
        """Whether the domain may hold values below 0."""
        return self.domain.low is None or sign_of_number(self.domain.low) < 0

    @cached_property
    def _index(self) -> int:
        """The parameter's number among the variables of the ring."""
        return self._ring.meanings.index(self.free)

    @property
    def _ring(self) -> Axis:
        return next(iter(self.conditions.values())).axis

    # The answer at a value

    def _holds(self, value: RealNumber, before: Cell | None, after: Cell | None) -> bool:
        """Whether the conditions hold at a critical value, or at an end of the domain."""
        if not self._belongs(value):
            return False
        if isinstance(value, ExactNumber):
            return self.allowed(value.value) and not self._broken(value.value)
        if None in self._reasons[value]:
            return False
        if (before and before.feasible) or (after and after.feasible):
            return True
        return not self._exceeds(value, [cell for cell in (before, after) if cell])

    def _belongs(self, value: RealNumber) -> bool:
        low = self.domain.low is not None and value == ExactNumber(self.domain.low)
        high = self.domain.high is not None and value == ExactNumber(self.domain.high)
        return not (low and not self.domain.holds_low) and not (high and not self.domain.holds_high)

    def _broken(self, value: Expr) -> tuple[BrokenInterval, ...]:
        """Where the first of the broken conditions is, at a number that is rational, or rational in pi; () if none is."""
        return next((found for criterion in self.conditions if (found := self._excess(criterion, value))), ())

    def _excess(self, criterion: Criterion, value: Expr) -> tuple[BrokenInterval, ...]:
        condition = self.conditions[criterion].function
        at, below = self._at(condition.numerator, value), self._at(condition.denominator, value)
        sign = RealFunction(self._ring.function(at)) if not below.is_zero() else self._one
        table = chart({criterion: sign}, *self.band)
        return tuple(BrokenInterval(criterion, x) for x in table.where(lambda signs: signs[criterion] > 0))

    @property
    def _one(self) -> RealFunction:
        return RealFunction(self._ring.one)

    def _at(self, polynomial: Polynomial, value: Expr) -> Polynomial:
        return substituted(polynomial, self._index, self._ring.convert(value))

    def _exceeds(self, value: RealNumber, cells: Sequence[Cell]) -> bool:
        """Whether a condition is broken at an algebraic value between two cells that are not feasible.

        First at frequencies at which one is broken nearby; where none shows, in the number field of the value.
        """
        if any(self._positive_at(x, value) for cell in cells for x in cell.broken):
            return True
        near = (self._broken(_approached(value, cell.sample, bits)) for bits in _ROUNDS for cell in cells)
        if any(self._positive_at(x, value) for broken in near for x in broken):
            return True
        return any(self._exceeds_exactly(criterion, value) for criterion in self.conditions)

    def _positive_at(self, excess: BrokenInterval, value: RealNumber) -> bool:
        """Whether a condition that is broken at a near value shows to be so, at the same frequency, at this one."""
        place = rational_between(excess.band.low.omega, excess.band.high.omega)
        with flint.ctx.workprec(512):
            return bool(self._value(excess.criterion, ExactNumber(place).ball(512), value.ball(512)) > 0)

    def _value(self, criterion: Criterion, place: Ball, value: Ball) -> Ball:
        numerator = self.conditions[criterion].function.numerator
        return self._ring.ball(numerator, {omega: place, pi: arb.pi(), self.free: value})

    def _exceeds_exactly(self, criterion: Criterion, value: RealNumber) -> bool:
        """By the zeros of the norm: between them a condition has one sign, which any frequency in between tells."""
        root = value.number if isinstance(value, Negative) else value
        assert isinstance(root, Root)
        minimal = of_factor(self._ring, self._index, root.factor, mirrored=root is not value)
        norm = resultant(self.conditions[criterion].function.cleared().numerator, minimal, self._index)
        places = [x.omega for x in chart({criterion: RealFunction(self._ring.function(norm))}, *self.band).points]
        if norm.is_zero():
            return False
        return any(self._sign(criterion, rational_between(a, b), value) > 0 for a, b in pairwise(places))

    def _sign(self, criterion: Criterion, place: Rational, value: RealNumber) -> int:
        """The sign of a condition where it is not zero."""
        at = ExactNumber(place)
        sign = at_rising_precision(
            lambda bits: sign_of(self._value(criterion, at.ball(bits), value.ball(bits))) or None, most=SURE_BITS
        )
        if sign is None:
            raise UndecidedError(f"the sign of a condition at omega = {place} rad/s")
        return sign

    # What binds

    def _bindings(self, value: RealNumber | None, around: tuple[Cell | None, Cell | None]) -> tuple[Binding, ...]:
        if value is None:
            return ()
        reasons = self._reasons.get(value, set())
        found = [
            Binding(criterion, ExactNumber(end), kind)
            for criterion in self.conditions
            for kind, end in zip((Kind.EDGE, Kind.START), self.band[::-1], strict=True)
            if (criterion, kind) in reasons
        ]
        touching = [criterion for criterion in self.conditions if (criterion, Kind.TOUCH) in reasons]
        try:
            return (*found, *(x for criterion in touching for x in self._touches(criterion, value, around)))
        except LimitError:  # at which frequency was not found in time
            return (*found, *(Binding(criterion, None, Kind.TOUCH) for criterion in touching))

    def _touches(
        self, criterion: Criterion, value: RealNumber, around: tuple[Cell | None, Cell | None]
    ) -> Iterator[Binding]:
        """The touches inside the band at a value: what the excess just beside it shrinks to."""
        numerator = RealFunction(self._ring.function(self.conditions[criterion].function.numerator))
        surface = Surface.of(numerator, self.free)
        for cell in around:
            if cell is None or cell.feasible:
                continue
            for bits, beyond in _NEAR:
                near = [
                    x.band for x in self._excess(criterion, _approached(value, cell.sample, bits)) if self._inside(x)
                ]
                isolated = [touch(surface, value, x.low.omega, x.high.omega, beyond) for x in near]
                if isolated and all(isolated):
                    yield from (Binding(criterion, x, Kind.TOUCH) for x in isolated)
                    return

    def _inside(self, excess: BrokenInterval) -> bool:
        ends = [ExactNumber(x) for x in self.band]
        return excess.band.low.omega not in ends and excess.band.high.omega not in ends


def _equal(x: RealNumber, end: ExactNumber) -> bool:
    return isinstance(x, ExactNumber) and sign_of_number(x.value - end.value) == 0


def _approached(value: RealNumber, sample: Rational, bits: int) -> Rational:
    """A rational number between a value and a sample, nearer the value by that many bits."""
    low, high = value.bounds(bits + 64)
    start = low if ExactNumber(sample).bounds(64)[0] < low else high
    at = Rational(start.numerator, start.denominator)
    return at + (sample - at) / 2**bits
