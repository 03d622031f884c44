"""All values of one parameter with which conditions hold on a whole band, by the way that fits the
conditions. Begin with ``solve``.

**Cells.** Floats with proven bounds cut the values into cells (``floatcells``): a cell is *broken*
if at one frequency the condition is broken for all its values, *kept* if it holds for all its
values on all of the band. In a cell that is left between a kept and a broken one there is one end
if what is broken stays broken along the values, which bounds on slopes show; then it is closed in
on by exact verdicts, to any number of digits, and what binds there is what is broken just beyond
it. It is exact where it is rational. Where that does not show, an end is known by its cell alone,
if that is narrow: ten digits.

**Balls** tell the same of cells where NumPy is missing (``ballcells``), as in a page in a browser:
ten times as slow.

**Thresholds.** r <= c holds on the whole band for c at least as large as the supremum of r there.
That is the value at an end of the band or at one of its local maxima, which are certified zeros of
the slope: no value of c needs to be tried.

**Signs alone.** Where omega is in no factor of a condition that changes its sign, roots of
polynomials in the parameter and the signs between them tell all: exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial, reduce
from itertools import pairwise

import flint
from flint import arb
from sympy import Expr, S, Symbol, pi

from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.peaks import Largest, Top, tops
from haptisym.judge.regions import Sided
from haptisym.kernel.arrays import has_arrays
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
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
    expression_ball,
    fraction_ball,
    rational,
    rational_between,
)
from haptisym.kernel.rings import Polynomial, monomials, omega
from haptisym.kernel.roots import Chart, Interval, Signed, chart, each_once, ordered
from haptisym.kernel.sets import (
    STOPPED,
    Bisected,
    Cell,
    Domain,
    Question,
    SingleValue,
    Stretch,
    ValueSet,
    combined,
)
from haptisym.kernel.sets import solve as solve_question
from haptisym.kernel.zeros import sign_of
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part
from haptisym.model.scene import THRESHOLD, Knob, Scene
from haptisym.model.valueranges import searched
from haptisym.verbs.require.ballcells import BallCells
from haptisym.verbs.require.freeparameter import (
    Conditions,
    JudgedValues,
    allowed,
    conditions,
    each,
    is_kept_anyway,
    missing,
    pieces,
    real_roots,
    substituted,
)

_BITS = 128
_UNSETTLED = (
    "bounds for all of these values show neither that a condition is kept nor that it is broken"
)
# Relative accuracy of an end, in bits, with which what binds there is looked for: more where
# several may, or one at an edge of the band.
_ROUGH, _CLOSE, _CLOSEST = 24, 64, 128
# Bits of numerator and denominator of the simplest rational number near an end up to which it is
# tried as the end itself; a longer one is found as a zero of the condition's own polynomial.
_SIMPLE = 40


@dataclass(frozen=True, eq=False)
class Kept:
    """The exact verdict on one value of a parameter: whether the scene exists there and keeps the
    criteria on all of the band.

    True, False, or None where a criterion that touches its limit is not told from one beyond it.
    """

    scene: Scene
    free: Knob
    criteria: tuple[Criterion, ...]
    _last: dict[Expr, Chart] = field(default_factory=dict, repr=False)

    def __call__(self, value: Expr) -> bool | None:
        try:
            table = self._chart(value)
        except SceneError:
            return False
        if table.where(lambda signs: max(signs.values()) > 0):
            return False
        return None if table.undecided else True

    def _chart(self, value: Expr) -> Chart:
        if value not in self._last:
            scene = self.free.put(self.scene, value)
            # Where the parameter is a part of the threshold, the criteria are those of the new
            # scene.
            judged, d = {x.name: x for x in noticed(scene.threshold)}, scene.distortion()
            own = {x: judged[x.name] if x.depends_on(self.free.parts) else x for x in self.criteria}
            # One chart, of the last value, as broken, excess and meets ask about the same one
            # again.
            self._last.clear()
            self._last[value] = chart({x: y.function(d) for x, y in own.items()}, *scene.band)
        return self._last[value]

    def broken(self, value: Expr) -> list[Place]:
        """Where on the band criteria are broken at a value."""
        table = self._chart(value)
        first, last = table.points[0], table.points[-1]
        return [
            Place(x, own, own.low is first, own.high is last)
            for x in self.criteria
            for own in table.where(lambda signs, x=x: signs[x] > 0)  # type: ignore[misc]
        ]

    def excess(self, value: Expr) -> Ball:
        """How much of the band is broken at a value: a function that bisection may interpolate.

        The width of a broken piece grows linearly beyond an end that binds at an end of the band;
        inside of the band, as a square root: there its square counts.
        """
        bits = int(flint.ctx.prec)
        widths = (
            (x, x.piece.high.omega.tight_ball(bits) - x.piece.low.omega.tight_ball(bits))
            for x in self.broken(value)
        )
        return sum((width**2 if x.kind is Kind.TOUCH else width for x, width in widths), arb(0))

    def meets(self, value: Expr) -> list[tuple[Criterion, RealNumber]]:
        """Where on the band criteria hold with equality at a value that keeps them all; nothing
        where it does not."""
        table = self._chart(value)
        if table.undecided or table.where(lambda signs: max(signs.values()) > 0):
            return []
        return [(x, p.omega) for x in self.criteria for p in table.points if p.orders.get(x, 0) > 0]


@dataclass(frozen=True, eq=False)
class Place:
    """A ``piece`` of the band on which a criterion is broken just beyond an end, and whether it
    begins where the band begins (``at_start``), or ends where it ends (``at_edge``)."""

    criterion: Criterion
    piece: Interval
    at_start: bool
    at_edge: bool

    @property
    def kind(self) -> Kind:
        """How it binds."""
        return Kind.EDGE if self.at_edge else Kind.START if self.at_start else Kind.TOUCH

    def holds(self, x: RealNumber) -> bool:
        """Whether a frequency lies on it."""
        return ordered(self.piece.low.omega, x) >= 0 and ordered(x, self.piece.high.omega) >= 0

    def ball(self, bits: int) -> Ball:
        """A ball around all of it."""
        return self.piece.low.omega.tight_ball(bits).union(self.piece.high.omega.tight_ball(bits))


@dataclass(frozen=True, eq=False, repr=False)
class TouchAt(RealNumber):
    """The frequency at which a criterion binds inside of the band, at the one end between two
    values.

    It lies where the criterion is broken beyond the end, as what is broken stays so, or moves by
    ``slant`` per unit of the value at most; that piece is as short as one likes. ``place`` : the
    piece at an end that was known to within ``width``.
    """

    end: Bisected
    kept: Kept
    place: Place
    slant: float
    width: Fraction

    def ball(self, bits: int) -> Ball:
        low, high = self.end.between(2 * bits)
        with flint.ctx.workprec(2 * bits + 32):
            moved = [
                arb(0, self.slant * fraction_ball(x).upper()) for x in (self.width, high - low)
            ]
            near = self.place.ball(2 * bits) + moved[0]
            balls = [
                x.ball(2 * bits)
                for x in self.kept.broken(rational(self.end.beyond))
                if x.criterion == self.place.criterion
            ]
            return reduce(arb.union, (x + moved[1] for x in balls if x.overlaps(near)))


@dataclass(frozen=True)
class Ends:
    """The cells of a range of values with their verdicts, and the exact ends in those left open.

    ``kept`` : the verdict on one value. ``found`` : the conditions with the parameter as a symbol.
    """

    kept: Kept
    found: Conditions
    range: tuple[Fraction, Fraction]

    @cached_property
    def told(self) -> list[JudgedValues]:
        """What is known of all values of a range, in order."""
        return _told(self.kept, self.found, *self.range)

    def cells(self, low: RealNumber | None, high: RealNumber | None) -> list[Cell]:
        """The verdicts on all values that are asked about: what is beyond the range is as next to
        it."""
        inner = [ExactNumber(rational(x.low)) for x in self.told[1:]]
        why = _why_open()
        pairs = zip(self.told, pairwise([low, *inner, high]), strict=True)
        return [Cell(a, b, x.kept, "" if x.kept is not None else why) for x, (a, b) in pairs]

    def end(self, low: RealNumber, _: RealNumber, low_holds: bool) -> SingleValue | None:  # noqa: FBT001
        """The end in what is open between two values: exact where there is one for certain; by its
        enclosure alone where there may be several in a narrow cell; else None."""
        [cell] = (x for x in self.told[1:] if not ordered(low, ExactNumber(rational(x.low))))
        if cell.slant is None:
            return SingleValue(Sliver(cell.low, cell.high)) if cell.is_narrow else None
        end = Bisected(self.kept, cell.low, cell.high, low_holds, self.kept.excess)
        places, width = self._places(end)
        if (exact := self._exact(end, places)) is not None:
            return exact
        band = self.kept.scene.band
        omegas = [
            TouchAt(end, self.kept, x, cell.slant, width)
            if x.kind is Kind.TOUCH
            else ExactNumber(band[x.kind is Kind.EDGE])
            for x in places
        ]
        return SingleValue(end, None, _listed([*zip(places, omegas, strict=True)]))

    def _places(self, end: Bisected) -> tuple[list[Place], Fraction]:
        """The places on the band that are broken just beyond an end, and within what width the end
        was then known: less where there are several, or one at an edge."""
        places, width = list[Place](), Fraction(0)
        for bits, settles in ((_ROUGH, {Kind.TOUCH}), (_CLOSE, {*Kind}), (_CLOSEST, {*Kind})):
            low, high = end.between(bits)
            width, places = high - low, self.kept.broken(rational(end.beyond))
            if len(places) == 1 and places[0].kind in settles:
                break
        return places, width

    def _exact(self, end: Bisected, places: Sequence[Place]) -> SingleValue | None:
        """The end as an exact number, rational or rational in pi, where one is proven to be it:
        there a criterion holds with equality at the place that is broken beyond. Else None."""
        low, high = (ExactNumber(rational(x)) for x in end.between(_CLOSE))
        # The value that holds last was asked for, and may be the very end.
        tried = [low if end.low_holds else high]
        near = rational_between(low, high)
        if max(int(near.p).bit_length(), int(near.q).bit_length()) <= _SIMPLE:
            tried.append(ExactNumber(near))
        for kind in {*(x.kind for x in places)} - {Kind.TOUCH}:
            tried += _linear_roots(
                self.found, self.kept.free.symbol, self.kept.scene.band[kind is Kind.EDGE]
            )
        for x in (x for x in tried if x in (low, high) or _between(low, x, high)):
            met = self.kept.meets(x.value)
            binding = [
                (place, omega)
                for place in places
                for criterion, omega in met
                if criterion == place.criterion and place.holds(omega)
            ]
            if binding:
                return SingleValue(x, None, _listed(binding))
        return None


def _why_open() -> str:
    """Why values are open: that bounds tell nothing of them, or that the time to look is over."""
    try:
        tick()
    except LimitError:
        return STOPPED
    return _UNSETTLED


def _listed(found: Sequence[tuple[Place, RealNumber]]) -> tuple[Binding, ...]:
    """What binds, at the high end of the band first, then at the low one, then inside."""
    listed = sorted(found, key=lambda x: (Kind.EDGE, Kind.START, Kind.TOUCH).index(x[0].kind))
    return tuple(Binding(place.criterion, omega, place.kind) for place, omega in listed)


def _linear_roots(found: Conditions, free: Symbol, place: Expr) -> Iterator[ExactNumber]:
    """The zeros, in the parameter, of rational conditions at one frequency that are rational, or
    rational in pi: those of linear factors."""
    for f in (f for own in found.values() for f in pieces(own) if not f.axis.functions):
        top, axis = f.function.numerator, f.axis
        # At 0 the numerator may vanish for all values: its lowest power tells the sign beside 0.
        if place == 0:
            least = min(int(e[0]) for e in top.monoms())
            top = top.context().from_dict(
                {(0, *e[1:]): x for e, x in monomials(top) if int(e[0]) == least}
            )
        else:
            top = substituted(top, 0, axis.convert(place))
        index = axis.meanings.index(free)
        linear = (own for own, _ in (top.factor()[1] if top else ()) if own.degrees()[index] == 1)
        yield from (
            x
            for own in linear
            for x in real_roots(own, index, negative=True)
            if isinstance(x, ExactNumber)
        )


# Bits with which the values of two local maxima are compared: what is alike to the last of them
# binds with the other.
_TOLD_APART = (64, 256, 1024)


@dataclass(frozen=True)
class ThresholdProblem:
    """The question for a threshold c: r^2 <= c^2 on all of the band, for the squared ratios
    ``squares``.

    ``kept``: what must not be positive besides, whatever c is.
    """

    squares: Mapping[Criterion, RealFunction]
    kept: Mapping[Criterion, Signed]
    band: tuple[Expr, Expr]
    domain: Domain

    def solve(self) -> ValueSet:
        """All thresholds of the domain with which every ratio is kept on the whole band: one
        interval, or none."""
        low, high = self.domain.low, self.domain.high
        assert low is not None
        none, every = (ValueSet.all_of(self.domain, holds=x) for x in (False, True))
        # If the largest threshold is exceeded all are, and if the smallest is not, none is: r <= c
        # holds from one value of c on.
        if self._exceeds(self.kept) or (high is not None and self._exceeds(self._excess(high))):
            return none
        if not self._exceeds(self._excess(low)):
            return every
        found = self._tops()
        if found is None:
            return none
        value = SquareRoot(Largest(tuple(x.value for _, x in found)))
        bottom = SingleValue(value, holds=True, bindings=_bindings(found))
        # The largest ratio is the upper end itself: one value at most is left, that end.
        if high is not None and self._touches(high):
            last = replace(bottom, holds=self.domain.holds_high)
            return ValueSet(
                (SingleValue(ExactNumber(low), holds=False), last),
                (None, Stretch(holds=False), None),
                self.domain,
            )
        return every & ValueSet((bottom,), (Stretch(holds=False), Stretch(holds=True)))

    def _excess(self, limit: Expr) -> dict[Criterion, Signed]:
        """What must not be positive with this threshold."""
        return {
            x: replace(x, threshold=limit).exceeded(square) for x, square in self.squares.items()
        }

    def _exceeds(self, conditions: Mapping[Criterion, Signed]) -> bool:
        """Whether a condition is broken somewhere on the band. UndecidedError where one only
        touches 0 and it is not proven that it does."""
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
    """Conditions whose sign is the same at all frequencies: for each the polynomials in the
    parameter that must not all be positive."""

    conditions: Mapping[Criterion, Sequence[Polynomial]]
    axis: Axis
    free: Symbol
    band: tuple[Expr, Expr]

    @classmethod
    def of(cls, found: Conditions, free: Symbol, band: tuple[Expr, Expr]) -> SignsAlone:
        """The conditions, of some, in which omega is in no factor that changes its sign."""
        own = {x: [_without_omega(f) for f in pieces(condition)] for x, condition in found.items()}
        kept = {x: [p for p in row if p is not None] for x, row in own.items() if None not in row}
        return cls(kept, pieces(next(iter(found.values())))[0].axis, free, band)

    def solve(self, asked: Domain, exists: Callable[[Expr], bool]) -> ValueSet:
        """All values of the domain with which no condition is broken, single ones among them: by
        the sign at each zero of a polynomial, and at one value between each two."""
        low, high = asked.ends
        inside = [x for x in self._turns if _between(low, x, high)]
        points = [SingleValue(x, self._kept(x), self._bindings(x)) for x in inside]
        gaps = pairwise([low, *inside, high])
        cells: list[Stretch | None] = [
            Stretch(self._kept(ExactNumber(rational_between(a, b)))) for a, b in gaps
        ]
        if low is not None:
            points, cells = [self._end(low, asked, exists), *points], [None, *cells]
        if high is not None:
            points, cells = [*points, self._end(high, asked, exists)], [*cells, None]
        return ValueSet(tuple(points), tuple(cells), asked)

    def _end(self, x: RealNumber, asked: Domain, exists: Callable[[Expr], bool]) -> SingleValue:
        """An end of what is asked about."""
        assert isinstance(x, ExactNumber)
        return SingleValue(
            x, asked.holds(x) and exists(x.value) and self._kept(x), self._bindings(x)
        )

    @cached_property
    def _index(self) -> int:
        return self.axis.meanings.index(self.free)

    @cached_property
    def _turns(self) -> list[RealNumber]:
        """The zeros of all polynomials, where a sign may change, in order."""
        factors = {
            str(f): f for row in self.conditions.values() for p in row for f, _ in p.factor()[1]
        }
        found = [x for f in factors.values() for x in real_roots(f, self._index, negative=True)]
        return each_once(found, lambda x: x)

    def _kept(self, value: RealNumber) -> bool:
        return all(min(self._sign(p, value) for p in row) <= 0 for row in self.conditions.values())

    def _sign(self, polynomial: Polynomial, value: RealNumber) -> int:
        """The sign of a polynomial at a value: 0 where that is one of its zeros, else by balls,
        which then come to tell it."""
        if not polynomial:
            return 0
        factors = [f for f, _ in polynomial.factor()[1]]
        zeros = (x for f in factors for x in real_roots(f, self._index, negative=True))
        if any(not ordered(x, value) for x in zeros):
            return 0
        sign = at_rising_precision(
            lambda bits: (
                sign_of(self.axis.ball(polynomial, {pi: arb.pi(), self.free: value.ball(bits)}))
                or None
            ),
            most=SURE_BITS,
        )
        assert sign is not None
        return sign

    def _bindings(self, value: RealNumber) -> tuple[Binding, ...]:
        """What is 0 at a value is so at both ends of the band."""
        zero = [
            x
            for x, row in self.conditions.items()
            if all(row) and min(self._sign(p, value) for p in row) == 0
        ]
        ends = (Kind.EDGE, self.band[1]), (Kind.START, self.band[0])
        return tuple(Binding(x, ExactNumber(end), kind) for x in zero for kind, end in ends)


def _between(low: RealNumber | None, x: RealNumber, high: RealNumber | None) -> bool:
    return (low is None or ordered(low, x) > 0) and (high is None or ordered(x, high) > 0)


def _without_omega(piece: RealFunction) -> Polynomial | None:
    """A polynomial in the parameter that has its sign at all frequencies but those at which it is
    0; None where there is none."""
    if piece.axis.functions:
        return None
    constant, factors = piece.function.numerator.factor()
    found = piece.axis.constant(constant)
    for f, n in factors:
        if not f.degrees()[0]:
            found *= f**n
        # omega itself is positive on the band; an even power changes no sign.
        elif n % 2 and f != piece.axis.variable:
            return None
    return found


def solve(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> ValueSet:
    """All values of the domain that keep the criteria on all of the band. Those for which the time
    did not last are undecided."""
    has_floor = (
        isinstance(x.region, Sided) and x.region.floor is not None
        for x in criteria
        if x.depends_on(free.parts)
    )
    try:
        # A threshold with a floor is no number that ratios can be held against: its values go by
        # cells.
        if free.parts and not any(has_floor):
            return _threshold_problem(scene, free, asked, criteria).solve()
        found, gone = conditions(scene, [free], criteria), missing(scene, free)
        found = {x: own for x, own in found.items() if not is_kept_anyway(scene, [free], x, own)}
        if not any(free.symbol in f.axis.meanings for own in found.values() for f in pieces(own)):
            return _all_alike(scene, free, asked, found).without(gone)
        # Conditions whose sign does not depend on omega are exact at once; cells only for the rest.
        alone = SignsAlone.of(found, free.symbol, scene.band)
        sets = [alone.solve(asked, partial(allowed, scene, free))] if alone.conditions else []
        if rest := {x: own for x, own in found.items() if x not in alone.conditions}:
            left = [x for x in criteria if x.name in {y.name for y in rest}]
            sets.append(_by_cells(scene, free, asked, left, rest))
        return combined(sets).without(gone)
    except LimitError:
        return ValueSet.all_of(asked, holds=None, reason=STOPPED)


def _all_alike(scene: Scene, free: Knob, asked: Domain, found: Conditions) -> ValueSet:
    """The answer where the parameter is in no condition: all values at which the scene exists, or
    none."""
    for own in found.values():
        tops = [RealFunction(f.axis.function(f.function.numerator)) for f in pieces(own)]
        if chart(dict(enumerate(tops)), *scene.band).where(lambda signs: min(signs.values()) > 0):
            return ValueSet.all_of(asked, holds=False)
    ends = (x for x in (asked.low, asked.high) if x is not None)
    return ValueSet.all_of(asked, holds=True).without(
        [ExactNumber(x) for x in ends if not allowed(scene, free, x)]
    )


def _threshold_problem(
    scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]
) -> ThresholdProblem:
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
    """What a free threshold c judges, squares to be at most c^2: of a region about both parts where
    both limits are c."""
    if x.region is None:
        return {x: x.measure(d)}
    if x.joint and len(free.parts) < len(Part):
        raise SceneError(
            f"{free.path}: the {x.joint.kind} judges both parts at once: leave {THRESHOLD} free"
        )
    squares = x.region.opened(dict.fromkeys(free.parts, S.One)).squares(d)
    return {each(x, i) if len(squares) > 1 else x: f for i, f in enumerate(squares, 1)}


def _by_cells(
    scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion], found: Conditions
) -> ValueSet:
    low, high = searched(free, asked)
    ends = Ends(Kept(scene, free, tuple(criteria)), found, _outward(low, high))
    own = None if free.value.free_symbols else free.value  # a limit may be a formula
    bounds = Domain(
        low if asked.low is None else asked.low, high if asked.high is None else asked.high
    )
    return solve_question(Question(ends.kept, own, cells=ends.cells, end=ends.end), asked, bounds)


def _told(kept: Kept, found: Conditions, low: Fraction, high: Fraction) -> list[JudgedValues]:
    """What is known of all values between two: by floats, or by balls where there is no NumPy."""
    if has_arrays():
        # NumPy is loaded only for a question that needs it.
        from haptisym.verbs.require.floatcells import FloatCells

        is_broken = partial(_is_broken, kept, found)
        cells = FloatCells(kept.scene, kept.free, kept.criteria, _usual(kept.free), is_broken)
        if cells.are_known:
            return cells.told(float(low), float(high))
    balls = BallCells(found, kept.free.symbol, kept.scene.band, Fraction(_usual(kept.free)), kept)
    return balls.told(low, high)


def _is_broken(kept: Kept, found: Conditions, told: JudgedValues) -> bool:
    """Whether balls show at a frequency that a condition is broken for all values between two."""
    with suppress(SceneError, UndecidedError), flint.ctx.workprec(_BITS):
        places = [x.ball(_BITS).mid() for x in kept.broken(rational(told.high))]
        # Twice as wide, upward, so that its middle is not 0: powers of balls about 0 are nan.
        value = fraction_ball(told.low).union(fraction_ball(2 * told.high - told.low))
        return any(
            all(_numerator(f, {omega: x, kept.free.symbol: value}) > 0 for f in pieces(own))
            for own in found.values()
            for x in places
        )
    return False


def _numerator(f: RealFunction, known: Mapping[Expr, Ball]) -> Ball:
    """The numerator of a condition, which has its sign, for balls of frequency and parameter."""
    ring = f.half_angled.ring
    return ring.ball(
        f.half_angled.numerator,
        {x: expression_ball(x, known) for x in ring.meanings if x.free_symbols <= known.keys()},
    )


def _usual(free: Knob) -> float:
    """A usual size of a parameter."""
    return (0.0 if free.value.free_symbols else abs(float(free.value))) or 1.0


def _outward(low: Expr, high: Expr) -> tuple[Fraction, Fraction]:
    """Doubles that enclose the values that are asked about."""
    with flint.ctx.workprec(53):
        return Fraction(float(expression_ball(low).lower())), Fraction(
            float(expression_ball(high).upper())
        )
