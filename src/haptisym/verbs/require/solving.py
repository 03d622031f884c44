"""The values of one parameter with which conditions hold on a whole band, by the way that fits the conditions.

**Cells.** The values are cut into cells. A cell is *broken* if at one frequency the condition is broken for all its values,
*kept* if it holds for all its values on all of the band. Floats with proven bounds show that of most (``floatcells``), balls of
what they leave. Around an end of the set neither can be; there the condition is shown to be decided by one place alone, an end of
the band or one maximum over frequency, and to change along the parameter one way only: then there is one end, a zero of a real
function, known to any number of digits; it is exact where it is rational. What shows neither way is cut in two, down to cells
that are 1e-13 of their values wide: values at which a ratio only touches its threshold stay undecided.

A condition that is kept at every phase of a delay, as its factors show, needs no cells. Nor does a delay that is long for the
band: whatever its length, it turns the wave to any phase somewhere in every piece of the band that is long enough. Where the
condition is broken at one phase, all over such a piece, it is broken for all of these values.

**Thresholds.** r <= c holds on the whole band for c at least as large as the supremum of r there. That is the value at an end of
the band or at one of its local maxima, which are certified zeros of the slope: no value of c needs to be tried.

**Signs alone.** Where omega is in no factor of a condition that changes its sign, roots of polynomials in the parameter and the
signs between them tell all: exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial, reduce
from itertools import pairwise
from math import sqrt
from typing import TypeAlias

import flint
from flint import arb
from sympy import Expr, Rational, S, Symbol, pi

from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.crossings import Criterion
from haptisym.judge.peaks import Largest, Top, tops
from haptisym.judge.regions import Sided
from haptisym.kernel.arrays import has_arrays
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.reals import (
    SURE_BITS,
    Ball,
    ExactNumber,
    RealNumber,
    Sliver,
    SquareRoot,
    at_rising_precision,
    bounds,
    dyadic,
    expression_ball,
    rational_between,
)
from haptisym.kernel.rings import Polynomial, monomials
from haptisym.kernel.roots import Signed, chart, each_once, ordered
from haptisym.kernel.sets import Domain
from haptisym.kernel.zeros import sign_of
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.model.valueranges import searched
from haptisym.verbs.require.feasible import End, Solved, Span, runs, together, without
from haptisym.verbs.require.freeparameter import (
    Conditions,
    allowed,
    conditions,
    each,
    is_kept_anyway,
    missing,
    pieces,
    real_roots,
    substituted,
)
from haptisym.verbs.require.limitingpoints import (
    CellVerdict,
    Corner,
    CriticalPlace,
    Edge,
    MaximumAt,
    Shape,
    Strips,
    Summit,
    Told,
    ZeroAt,
    places,
)

BITS = 128
_NARROW = 1e-13
"""Of a cell that is cut no further, relative to its values."""
_COARSE = Fraction(1, 32)
"""Relative width up to which cells are cut widest first; narrower ones in order."""
_MOST_CELLS = 800  # where floats tell nothing: what they leave is mostly hard for balls too
_STEP, _PIECES, _TANGENTS = Fraction(5, 4), 16, (0, 1, -1, 3, -3)
"""How many times a long delay is the one before it; pieces of the band; tangents of half of its phase."""
_VERDICTS = {True: CellVerdict.KEPT, False: CellVerdict.BROKEN}


@dataclass(frozen=True)
class Leaf:
    """Values of the parameter between two numbers, and what is known of them.

    ``value``: of a leaf in which the set ends, where; ``verdict`` is then that of the values below it, ``above`` that above.
    """

    low: Fraction
    high: Fraction
    verdict: CellVerdict
    above: CellVerdict | None = None
    value: RealNumber | None = None
    bindings: tuple[Binding, ...] = ()


Quick: TypeAlias = Callable[[float, float], Sequence[Told]]
"""What is known of the values from one to another, in order."""


def _nothing(low: float, high: float) -> Sequence[Told]:
    """What is known where nothing is: all of it open."""
    return (Told(low, high, None),)


@dataclass(frozen=True)
class ValueSearch:
    """Conditions in omega and one parameter, on a band; ``scale``: a usual size of the parameter."""

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]
    scale: Fraction
    quick: Quick = _nothing

    def leaves(self, low: Fraction, high: Fraction) -> list[Leaf]:
        """The values from ``low`` to ``high``, doubles, cut into leaves in order."""
        end = self._turning(low, high) if low > 0 else high
        found = [*self._told(self.quick(float(low), float(end)))]
        return found if end == high else [*found, Leaf(end, high, CellVerdict.BROKEN)]

    def _cut(self, low: Fraction, high: Fraction, most: int) -> list[Leaf]:
        """The leaves between two numbers, in order; wide cells are cut first, so that no easy one stays open for a hard one."""
        found = list[Leaf]()
        waiting = Waiting([(low, high)], self._rank, most=most, what="values in cells")
        with suppress(LimitError):  # what waits stays open
            for a, b in waiting:
                leaf = self._judged(a, b)
                if leaf.verdict is not CellVerdict.OPEN or self._width(a, b) < _NARROW:
                    found.append(leaf)
                else:
                    waiting.add((a, _middle(a, b)), (_middle(a, b), b))
        found += [Leaf(a, b, CellVerdict.OPEN) for a, b in waiting.rest]
        return sorted(found, key=lambda leaf: leaf.low)

    def _told(self, told: Sequence[Told]) -> Iterator[Leaf]:
        """What floats tell as leaves; what they leave open by cells."""
        for x in told:
            a, b = Fraction(x.low), Fraction(x.high)
            if x.kept is None:
                yield from self._cut(a, b, _MOST_CELLS if len(told) == 1 else _MOST_CELLS // 4)
            else:
                yield Leaf(a, b, _VERDICTS[x.kept])

    def _rank(self, cell: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
        return -max(self._width(*cell), _COARSE), cell[0]

    def _width(self, low: Fraction, high: Fraction) -> Fraction:
        """The width of a cell, relative to its values."""
        return (high - low) / max(-low, high, self.scale / 1000)

    def _judged(self, low: Fraction, high: Fraction) -> Leaf:
        """What balls tell of the values between two numbers."""
        with flint.ctx.workprec(BITS):
            a, b = dyadic(low), dyadic(high)
            strips = {x: Strips.of(shapes, a, b) for x, shapes in self._shapes.items()}
            return self._leaf(low, high, strips)

    @cached_property
    def _shapes(self) -> dict[Criterion, tuple[Shape, ...]]:
        return {x: tuple(Shape.of(f, self.free) for f in pieces(own)) for x, own in self.conditions.items()}

    def _leaf(self, low: Fraction, high: Fraction, strips: dict[Criterion, Strips]) -> Leaf:
        crossing: list[tuple[Criterion, CriticalPlace, int]] = []
        is_open = False  # of one criterion; another may be broken for all values
        for criterion, strip in strips.items():
            found = places(strip, self.band)
            if found is CellVerdict.BROKEN:
                return Leaf(low, high, CellVerdict.BROKEN)
            is_open |= isinstance(found, CellVerdict)
            for place in () if isinstance(found, CellVerdict) else found:
                signs = strip.signs(place)
                if signs == (1, 1):
                    return Leaf(low, high, CellVerdict.BROKEN)
                if signs is None:
                    is_open = True
                elif signs != (-1, -1):
                    crossing.append((criterion, place, signs[0]))
        if is_open or len({before for *_, before in crossing}) > 1:
            return Leaf(low, high, CellVerdict.OPEN)
        if not crossing:
            return Leaf(low, high, CellVerdict.KEPT)
        value, bindings = _first([(x, place, strips[x].crossing(place)) for x, place, _ in crossing], crossing[0][2])
        exact = self._exact(value, (low, high)) if not self._axis.functions else None
        verdicts = (
            (CellVerdict.BROKEN, CellVerdict.KEPT) if crossing[0][2] > 0 else (CellVerdict.KEPT, CellVerdict.BROKEN)
        )
        return Leaf(low, high, *verdicts, exact or value, bindings)

    @property
    def _axis(self) -> Axis:
        return next(iter(self._shapes.values()))[0].axis

    def _exact(self, value: Edge | Summit | Corner, between: tuple[Fraction, Fraction]) -> ExactNumber | None:
        """The one end between two values where it is rational, or rational in pi, if it shows to be that."""
        if isinstance(value, Edge):
            roots = _linear_roots(value.shape, value.place)
            with flint.ctx.workprec(BITS):
                cell = dyadic(between[0]).union(dyadic(between[1]))
                return next((x for x in roots if cell.contains(x.ball(BITS))), None)
        ends = [_rational(x) for x in value.bounds(2 * BITS)]
        near = ends[0] if ends[0] == ends[1] else rational_between(*map(ExactNumber, ends))
        if int(near.p).bit_length() + int(near.q).bit_length() > BITS:
            return None
        shapes = (value.shape,) if isinstance(value, Summit) else (value.rising, value.falling)
        return ExactNumber(near) if _touches(shapes, near, value.between) else None

    def _turning(self, low: Fraction, high: Fraction) -> Fraction:
        """From where on the parameter is a delay that breaks a condition by its phase, if anywhere; else the high end."""
        with suppress(LimitError), flint.ctx.workprec(BITS):
            while low < (less := Fraction(float(high / _STEP))):
                if not any(self._breaks_at_any_phase(less, high, x) for x in self._phases):
                    break
                high = less
        return high

    @cached_property
    def _phases(self) -> list[tuple[Ball, Shape]]:
        """Conditions at some phases of the one delay that the parameter is, and how fast that turns along it."""
        found = []
        for f in (x for own in map(pieces, self.conditions.values()) if len(own) == 1 for x in own):
            axis = f.axis
            turning = [i for i, a in enumerate(axis.angles) if a.rate.has(self.free) and not a.constant]
            if len(turning) != 1 or any(x.has(self.free) for x in axis.orders):
                continue
            rate = axis.angles[turning[0]].rate.diff(self.free)
            shape = Shape.of(f, self.free)
            for tangent in _TANGENTS:
                top = shape.polynomial.subs({f"x{axis.size + turning[0]}": tangent})
                degrees = tuple(0 if i == turning[0] else n for i, n in enumerate(shape.degrees))
                if not top.is_zero():
                    found.append((expression_ball(rate), Shape(top, axis, self.free, degrees)))
        return found

    def _breaks_at_any_phase(self, low: Fraction, high: Fraction, phase: tuple[Ball, Shape]) -> bool:
        """Whether a condition is broken at a phase for all values between two, on a piece of the band that holds all phases."""
        rate, shape = phase
        compiled = shape.over(dyadic(low).union(dyadic(high)))
        start, end = (expression_ball(x) for x in self.band)
        run = 0
        for i in reversed(range(_PIECES)):
            edges = (start + (end - start) * n / _PIECES for n in (i, i + 1))
            run = run + 1 if compiled.over(reduce(arb.union, edges))[0] > 0 else 0
            if run and rate * dyadic(low) * (end - start) * run > 2 * arb.pi() * _PIECES:
                return True
        return False


Crossing: TypeAlias = Edge | Summit | Corner


def _first(
    found: Sequence[tuple[Criterion, CriticalPlace, Crossing]], before: int
) -> tuple[Crossing, tuple[Binding, ...]]:
    """Of values at which conditions begin, or all cease, to be broken, the one at which the set ends, and what binds there."""
    value = found[0][2]
    for _, _, x in found[1:]:
        value = x if ordered(value, x) * before > 0 else value
    alike = [_binding(*x) for x in found if not ordered(x[2], value)]
    alike.sort(key=lambda x: (Kind.EDGE, Kind.START, Kind.TOUCH).index(x.kind))
    kept: list[Binding] = []
    for b in alike:  # of the terms of a region one
        if not any(b.criterion.name == other.criterion.name and _are_one(b.omega, other.omega) for other in kept):
            kept.append(b)
    return value, tuple(kept)


def _are_one(x: RealNumber | None, y: RealNumber | None) -> bool:
    return x is not None and y is not None and not ordered(x, y)


def _binding(criterion: Criterion, place: CriticalPlace, value: Edge | Summit | Corner) -> Binding:
    if place.kind is Kind.TOUCH:
        assert not isinstance(value, Edge)
        return Binding(criterion, ZeroAt(value) if isinstance(value, Corner) else MaximumAt(value), place.kind)
    assert isinstance(value, Edge)
    return Binding(criterion, ExactNumber(value.place), place.kind)


def _linear_roots(shape: Shape, place: Expr) -> Iterator[ExactNumber]:
    """Of what a polynomial condition is at a frequency, the zeros that are rational, or rational in pi."""
    top, axis = shape.polynomial, shape.axis
    if place == 0:  # as it begins there
        least = min(int(e[0]) for e in top.monoms())
        rows = {(0, *e[1:]): x for e, x in monomials(top) if int(e[0]) == least}
        top = top.context().from_dict(rows)
    else:
        top = substituted(top, 0, axis.convert(place))
    index = axis.meanings.index(shape.free)
    linear = (f for f, _ in (top.factor()[1] if top else ()) if f.degrees()[index] == 1)
    yield from (x for f in linear for x in real_roots(f, index, negative=True) if isinstance(x, ExactNumber))


def _touches(shapes: Sequence[Shape], value: Rational, between: tuple[Ball, Ball]) -> bool:
    """Whether functions that are not all positive between two frequencies have a zero in common there, at a rational value.

    In a cell in which all is decided there, and one way, that is the end.
    """
    axis, index = shapes[0].axis, shapes[0].axis.meanings.index(shapes[0].free)
    tops = [RealFunction(axis.function(substituted(x.polynomial, index, axis.convert(value)))) for x in shapes]
    low, high = (_rational(bounds(x)[0]) for x in between)
    table = chart(dict(enumerate(tops)), low, high)
    if table.undecided or table.where(lambda signs: min(signs.values()) > 0):
        return False
    return any(all(point.orders.get(i, 0) > 0 for i in range(len(tops))) for point in table.points)


def _middle(low: Fraction, high: Fraction) -> Fraction:
    """A dyadic number inside, between numbers of one sign nearer their geometric mean; never a simple one."""
    a, b = float(low), float(high)
    if a >= 0 and (a == 0 or b / a > 4):
        cut = sqrt(a * b) if a > 0 else b / 16
    elif b <= 0 and (b == 0 or a / b > 4):
        cut = -sqrt(a * b) if b < 0 else a / 16
    else:
        cut = a + (b - a) * 0.4970703125
    return Fraction(cut) if a < cut < b else (low + high) / 2


_SLIVER = Fraction(1, 10**9)
"""Relative width of values that may be given as an end by their enclosure alone."""


@dataclass(frozen=True)
class ValueLine:
    """The leaves of a search as points and gaps between them."""

    leaves: list[Leaf]
    domain: Domain
    exists: Callable[[Expr], bool] = field(repr=False)
    asked: Mapping[Expr, bool | None] = field(default_factory=dict, repr=False)
    """What was told of the ends of the domain by themselves."""

    @cached_property
    def _merged(self) -> list[Leaf]:
        """The leaves with neighbours of one verdict joined, and narrow open ones between two verdicts made ends."""
        joined: list[Leaf] = []
        for leaf in self.leaves:
            last = joined[-1] if joined else None
            if last and last.above is None and leaf.above is None and last.verdict is leaf.verdict:
                joined[-1] = replace(last, high=leaf.high)
            else:
                joined.append(leaf)
        return [self._as_end(i, joined) for i in range(len(joined))]

    def _as_end(self, i: int, leaves: list[Leaf]) -> Leaf:
        leaf = leaves[i]
        if leaf.verdict is not CellVerdict.OPEN or not 0 < i < len(leaves) - 1:
            return leaf
        before, after = leaves[i - 1].above or leaves[i - 1].verdict, leaves[i + 1].verdict
        if before is after or leaf.high - leaf.low > _SLIVER * max(-leaf.low, leaf.high):
            return leaf
        return replace(leaf, verdict=before, above=after, value=Sliver(leaf.low, leaf.high))

    def spans(self) -> tuple[Span, ...]:
        """The values for which the conditions are kept."""
        low, high = self.domain.low, self.domain.high
        points: list[End] = [End(_exact(low))]
        gaps: list[CellVerdict] = []
        for leaf in self._merged:
            if leaf.above is not None:
                gaps.append(leaf.verdict)
                points.append(End(leaf.value, bindings=leaf.bindings))
            gaps.append(leaf.above or leaf.verdict)
            points.append(End(ExactNumber(_rational(leaf.high))))
        points[-1] = End(_exact(high))
        kept = [gap is CellVerdict.KEPT for gap in gaps]
        at = [bool(near) for near in (any(kept[max(i - 1, 0) : i + 1]) for i in range(len(points)))]
        at[0] = low is not None and self.domain.holds_low and self._holds(low, gaps[0])
        at[-1] = high is not None and self.domain.holds_high and self._holds(high, gaps[-1])
        return tuple(Span(replace(points[i], closed=a), replace(points[j], closed=b)) for i, j, a, b in runs(at, kept))

    def _holds(self, end: Expr, beside: CellVerdict) -> bool:
        """Whether an end of the domain will do, by itself or as what is beside it; of an open stretch it is the end."""
        if beside is CellVerdict.OPEN:
            return False
        return bool(self.asked[end]) if end in self.asked else beside is CellVerdict.KEPT and self.exists(end)

    @property
    def undecided(self) -> tuple[tuple[RealNumber | None, RealNumber | None], ...]:
        """The values about which nothing is proven."""
        leaves, low, high = self._merged, self.domain.low, self.domain.high
        places = [_exact(low), *(ExactNumber(_rational(leaf.low)) for leaf in leaves[1:]), _exact(high)]
        pairs = zip(leaves, pairwise(places), strict=True)
        found = [pair for leaf, pair in pairs if leaf.verdict is CellVerdict.OPEN]
        return (
            *self._alone(low, leaves[0].verdict),
            *found,
            *self._alone(high, leaves[-1].above or leaves[-1].verdict),
        )

    def _alone(self, end: Expr | None, beside: CellVerdict) -> list[tuple[RealNumber | None, RealNumber | None]]:
        """An end of the domain that stays open though what is beside it does not."""
        is_open = end is not None and beside is not CellVerdict.OPEN and self.asked.get(end, True) is None
        return [(_exact(end), _exact(end))] if is_open else []


def _rational(x: Fraction) -> Rational:
    return Rational(x.numerator, x.denominator)


def _exact(x: Expr | None) -> RealNumber | None:
    return None if x is None else ExactNumber(x)


_TOLD_APART = (64, 256, 1024)
"""Bits with which the values of two local maxima are compared; what is alike to the last of them binds with the other."""


@dataclass(frozen=True)
class ThresholdProblem:
    """Squared ratios that one threshold judges on a band; ``kept``: what must not be positive besides, as it is."""

    squares: Mapping[Criterion, RealFunction]
    kept: Mapping[Criterion, Signed]
    band: tuple[Expr, Expr]
    domain: Domain

    def solve(self) -> tuple[Span, ...]:
        """All thresholds of the domain with which every ratio is kept on the whole band: one interval, or none."""
        low, high = self.domain.low, self.domain.high
        assert low is not None
        if self._exceeds(self.kept):
            return ()
        if high is not None and self._exceeds(self._excess(high)):
            return ()
        top = End(None if high is None else ExactNumber(high), self.domain.holds_high and high is not None)
        if not self._exceeds(self._excess(low)):
            return (Span(End(ExactNumber(low), self.domain.holds_low), top),)
        found = self._tops()
        if found is None:
            return ()
        bottom = End(SquareRoot(Largest(tuple(x.value for _, x in found))), closed=True, bindings=_bindings(found))
        if high is not None and self._touches(high):
            return (Span(bottom, bottom),) if self.domain.holds_high else ()
        return (Span(bottom, top),)

    def _excess(self, limit: Expr) -> dict[Criterion, Signed]:
        return {x: replace(x, threshold=limit).exceeded(square) for x, square in self.squares.items()}

    def _exceeds(self, conditions: Mapping[Criterion, Signed]) -> bool:
        table = chart(conditions, *self.band)
        exceeds = bool(table.where(lambda signs: any(sign > 0 for sign in signs.values())))
        if not exceeds and table.undecided:
            raise UndecidedError("whether a ratio that touches an end of the range goes beyond it")
        return exceeds

    def _touches(self, limit: Expr) -> bool:
        """Whether a ratio that does not exceed a limit meets it."""
        excess = self._excess(limit)
        if any(isinstance(x, RealFunction) and x.is_zero for x in excess.values()):
            return True  # at every frequency
        table = chart(excess, *self.band)
        return any(n > 0 for point in table.points for n in point.orders.values())

    def _tops(self) -> list[tuple[Criterion, Top]] | None:
        """The places at which the largest ratio is reached; None where one has no bound."""
        found: list[tuple[Criterion, Top]] = []
        for criterion, square in self.squares.items():
            own = tops(square, *self.band)
            if own is None:
                return None
            found += [(criterion, x) for x in own]
        for bits in _TOLD_APART:
            with flint.ctx.workprec(bits):
                balls = [x.value.ball(bits) for _, x in found]
                most = Largest(tuple(x.value for _, x in found)).ball(bits)
                found = [x for x, ball in zip(found, balls, strict=True) if not ball < most]
        return found


def _bindings(found: list[tuple[Criterion, Top]]) -> tuple[Binding, ...]:
    return tuple(Binding(criterion, x.omega, _KINDS[x.end]) for criterion, x in found)


_KINDS = {None: Kind.TOUCH, False: Kind.START, True: Kind.EDGE}


@dataclass(frozen=True)
class SignsAlone:
    """Conditions that are kept or broken at all frequencies at once: of each the polynomials that must not all be positive."""

    conditions: Mapping[Criterion, Sequence[Polynomial]]
    axis: Axis
    free: Symbol
    band: tuple[Expr, Expr]

    @classmethod
    def of(cls, found: Conditions, free: Symbol, band: tuple[Expr, Expr]) -> SignsAlone:
        """Those of some conditions in which omega stands in no factor that changes its sign."""
        own = {x: [_without_omega(f) for f in pieces(condition)] for x, condition in found.items()}
        kept = {x: [p for p in row if p is not None] for x, row in own.items() if None not in row}
        return cls(kept, pieces(next(iter(found.values())))[0].axis, free, band)

    def solve(self, asked: Domain, exists: Callable[[Expr], bool]) -> Solved:
        """All values of the domain with which none of them is broken."""
        low, high = (None if x is None else ExactNumber(x) for x in (asked.low, asked.high))
        inside = [x for x in self._turns if _between(low, x, high)]
        places = [low, *inside, high]
        cells = [self._kept(ExactNumber(rational_between(a, b))) for a, b in pairwise(places)]
        at = [x is not None and self._kept(x) for x in places]
        at[0] = at[0] and asked.holds_low and exists(asked.low)
        at[-1] = at[-1] and asked.holds_high and exists(asked.high)
        ends = [End(x, a, self._bindings(x)) for x, a in zip(places, at, strict=True)]
        found = runs(at, cells)
        return Solved(tuple(Span(replace(ends[i], closed=a), replace(ends[j], closed=b)) for i, j, a, b in found))

    @cached_property
    def _index(self) -> int:
        return self.axis.meanings.index(self.free)

    @cached_property
    def _turns(self) -> list[RealNumber]:
        """Where one of them may change its sign, in order."""
        factors = {str(f): f for row in self.conditions.values() for p in row for f, _ in p.factor()[1]}
        found = [x for f in factors.values() for x in real_roots(f, self._index, negative=True)]
        return each_once(found, lambda x: x)

    def _kept(self, value: RealNumber) -> bool:
        return all(min(self._sign(p, value) for p in row) <= 0 for row in self.conditions.values())

    def _sign(self, polynomial: Polynomial, value: RealNumber) -> int:
        if not polynomial:
            return 0
        factors = [f for f, _ in polynomial.factor()[1]]
        zeros = (x for f in factors for x in real_roots(f, self._index, negative=True))
        if any(not ordered(x, value) for x in zeros):
            return 0
        sign = at_rising_precision(
            lambda bits: sign_of(self.axis.ball(polynomial, {pi: arb.pi(), self.free: value.ball(bits)})) or None,
            most=SURE_BITS,
        )
        assert sign is not None
        return sign

    def _bindings(self, value: RealNumber | None) -> tuple[Binding, ...]:
        """What is 0 at a value is so at both ends of the band."""
        if value is None:
            return ()
        zero = [x for x, row in self.conditions.items() if all(row) and min(self._sign(p, value) for p in row) == 0]
        ends = (Kind.EDGE, self.band[1]), (Kind.START, self.band[0])
        return tuple(Binding(x, ExactNumber(end), kind) for x in zero for kind, end in ends)


def _between(low: RealNumber | None, x: RealNumber, high: RealNumber | None) -> bool:
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)


def _without_omega(piece: RealFunction) -> Polynomial | None:
    """A polynomial in the parameter that has its sign at all frequencies but those at which it is 0; None where there is none."""
    if piece.axis.functions:
        return None
    constant, factors = piece.function.numerator.factor()
    found = piece.axis.constant(constant)
    for f, n in factors:
        if not f.degrees()[0]:
            found *= f**n
        elif n % 2 and f != piece.axis.variable:
            return None
    return found


def solve(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> Solved:
    """All values of the domain that keep the conditions; those about which the time did not last are undecided."""
    has_floor = (
        isinstance(x.region, Sided) and x.region.floor is not None for x in criteria if x.depends_on(free.parts)
    )
    try:
        if free.parts and not any(has_floor):
            return Solved(_threshold_problem(scene, free, asked, criteria).solve())
        found, gone = conditions(scene, [free], criteria), missing(scene, free)
        found = {x: own for x, own in found.items() if not is_kept_anyway(scene, [free], x, own)}
        if not any(free.symbol in f.axis.meanings for own in found.values() for f in pieces(own)):
            solved = _all_alike(scene, free, asked, found)
        else:
            alone = SignsAlone.of(found, free.symbol, scene.band)
            sets = [alone.solve(asked, partial(allowed, scene, free))] if alone.conditions else []
            if rest := {x: own for x, own in found.items() if x not in alone.conditions}:
                left = [x for x in criteria if x.name in {y.name for y in rest}]
                sets.append(_by_cells(scene, free, asked, left, rest))
            solved = together(asked, sets)
        return replace(solved, feasible=without(solved.feasible, gone))
    except LimitError:
        return Solved((), ((_exact(asked.low), _exact(asked.high)),))


def _all_alike(scene: Scene, free: Knob, asked: Domain, found: Conditions) -> Solved:
    """Of a parameter that has left the conditions: all values at which the scene exists, or none."""
    exists = partial(allowed, scene, free)
    for own in found.values():
        tops = [RealFunction(f.axis.function(f.function.numerator)) for f in pieces(own)]
        if chart(dict(enumerate(tops)), *scene.band).where(lambda signs: min(signs.values()) > 0):
            return Solved(())
    line = ValueLine([Leaf(Fraction(0), Fraction(1), CellVerdict.KEPT)], asked, exists)
    return Solved(line.spans())


def _threshold_problem(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> ThresholdProblem:
    """The question for a threshold: the conditions that it is not part of stay as they are."""
    d = scene.distortion()
    own: dict[Criterion, RealFunction] = {}
    for x in criteria:
        if x.depends_on(free.parts):
            own |= _squares(x, d, free)
    return ThresholdProblem(
        own, {x: x.function(d) for x in criteria if not x.depends_on(free.parts)}, scene.band, asked
    )


def _squares(x: Criterion, d: Distortion, free: Knob) -> dict[Criterion, RealFunction]:
    """What a free threshold c judges, squares to be at most c^2: of a region about both parts where both limits are c."""
    if x.region is None:
        return {x: x.measure(d)}
    if x.joint and len(free.parts) < len(Part):
        raise SceneError(f"{free.path}: the {x.joint.kind} judges both parts at once: leave {THRESHOLD} free")
    squares = x.region.opened(dict.fromkeys(free.parts, S.One)).squares(d)
    return {each(x, i) if len(squares) > 1 else x: f for i, f in enumerate(squares, 1)}


def _by_cells(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion], found: Conditions) -> Solved:
    low, high = searched(free, asked)
    usual = (0.0 if free.value.free_symbols else abs(float(free.value))) or 1.0  # a limit may be a formula
    search = ValueSearch(found, free.symbol, scene.band, Fraction(usual), _quick(scene, free, criteria, usual))
    ends = [x for x, holds in ((asked.low, asked.holds_low), (asked.high, asked.holds_high)) if holds and x is not None]
    at = {x: _holds_at(scene, free, criteria, x) for x in ends}  # while there is time
    line = ValueLine(search.leaves(*_outward(low, high)), asked, partial(allowed, scene, free), at)
    return Solved(line.spans(), line.undecided)


def _quick(scene: Scene, free: Knob, criteria: Sequence[Criterion], usual: float) -> Quick:
    """What floats tell of values; nothing where there is no NumPy."""
    if not has_arrays():
        return _nothing
    from haptisym.verbs.require.floatcells import FloatCells  # which not every question needs

    return FloatCells(scene, free, criteria, usual).told


def _outward(low: Expr, high: Expr) -> tuple[Fraction, Fraction]:
    """Doubles that enclose the values that are asked about."""
    with flint.ctx.workprec(53):
        return Fraction(float(expression_ball(low).lower())), Fraction(float(expression_ball(high).upper()))


def _holds_at(scene: Scene, free: Knob, criteria: Sequence[Criterion], value: Expr) -> bool | None:
    """Whether the scene exists at a value and keeps the criteria there; None where that is undecided."""
    try:
        d = free.put(scene, value).distortion()
        table = chart({x: x.function(d) for x in criteria}, *scene.band)
    except SceneError:
        return False
    except UndecidedError:
        return None
    if table.where(lambda signs: max(signs.values()) > 0):
        return False
    return None if table.undecided else True
