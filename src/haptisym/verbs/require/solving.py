"""With which values of one parameter q do conditions hold on a whole band of frequencies omega? The
sets of values behind ``require``, each found in the way that fits the conditions.

A *criterion*, such as r <= c for a ratio r of the distortion and its threshold c, gives one or
several *conditions*: functions f_i(omega, q) of which at no frequency all may be positive. A
condition is *broken* at (omega, q) where all its f_i are positive, and *kept* for q where it is
broken at no omega of the band. ``solve`` takes the first of four ways that applies:

1. **Thresholds** (``ThresholdProblem``). Where q is the threshold c itself, r <= c holds on the
   whole band for c at least as large as the supremum of r there. That is the value at an end of the
   band or at one of its local maxima, which are certified zeros of the slope: no value of c needs
   to be tried.
2. **No parameter** (``_without_parameter``). Where q is in no condition, one verdict serves all.
3. **Signs alone** (``ConstantSigns``). Where omega is in no factor of a condition that changes its
   sign, the roots of polynomials in q, and the signs between them, are the whole answer: exact.
4. **Cells** (``CellSearch``), for all other conditions. The values are cut into intervals, the
   cells, and bounds over each decide where they can: a cell is kept if the conditions hold for all
   its values on all of the band, and broken if at one frequency a condition is broken for all its
   values. The bounds are floats with proven error (``floatcells``) or, where NumPy is missing, as
   in a browser, balls (``ballcells``), about ten times as slow. In an open cell between a kept and
   a broken one the set has just one end if what is broken for one value stays broken for all
   beyond it, which bounds on slopes show. That end is closed in on by exact verdicts
   (``ExactVerdict``), to any number of digits, and is exact where it is rational. Where the slopes
   do not show it, an end is known by its cell alone, if that is narrow: ten digits.

**Guaranteed**: the verdict on every point and interval of the set is proven, or it is undecided;
but for values between 0 and the least value searched (``valueranges.searched``), which are taken to
be like those next to them. An end that is known by its cell alone is a ``Sliver``: of the single
values in it nothing is claimed, as there may be more than one end in there. What *binds* at an end,
the criterion that holds with equality there and its frequency, is read off what is broken just
beyond it.

Begin reading at ``solve``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial, reduce
from itertools import pairwise

import flint
from flint import arb, fmpq
from sympy import Expr, S, Symbol, pi

from haptisym.judge.bindings import Binding, Kind
from haptisym.judge.crossings import Criterion, noticed
from haptisym.judge.peaks import LargestOf, MaximumCandidate, maximum_candidates
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
    ordered,
    rational,
    rational_between,
)
from haptisym.kernel.rings import Polynomial, monomials, omega
from haptisym.kernel.roots import Chart, Interval, Signed, chart, each_once
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

# Bits with which it is shown that a condition is broken at one frequency for a whole cell.
_BITS = 128
# Bits of relative accuracy of an end with which it is looked up what binds there: the first is
# enough where one condition touches 0 inside of the band; several, or one at an end of the band,
# may still differ from what binds at the end itself, and are looked up again, more closely.
_ROUGH, _CLOSE, _CLOSEST = 24, 64, 128
# Bits of numerator and denominator of the simplest rational number near an end up to which it is
# tried as the end itself; a longer one is found as a zero of the condition's own polynomial.
_SIMPLE = 40
# Bits with which the values of local maxima are compared, in turn: maxima that are still equal to
# the last of these bind together.
_MAXIMUM_BITS = (64, 256, 1024)
_UNSETTLED = (
    "bounds for all of these values show neither that a condition is kept nor that it is broken"
)
# The order in which bindings are listed: the high end of the band first.
_BINDING_ORDER = (Kind.EDGE, Kind.START, Kind.TOUCH)


def solve(scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]) -> ValueSet:
    """Return all values of a parameter with which the criteria are kept on all of the scene's band.

    ``free`` : the parameter. ``asked`` : the values that are asked about. Values for which the time
    did not last, or which no way settles, are undecided.
    """
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
        listed, gone = conditions(scene, [free], criteria), missing(scene, free)
        listed = {x: f for x, f in listed.items() if not is_kept_anyway(scene, [free], x, f)}
        functions = (f for condition in listed.values() for f in pieces(condition))
        if not any(free.symbol in f.axis.meanings for f in functions):
            return _without_parameter(scene, free, asked, listed).without(gone)
        # Conditions whose sign does not depend on omega are exact at once; cells only for the rest.
        constant = ConstantSigns.of(listed, free.symbol, scene.band)
        sets = list[ValueSet]()
        if constant.conditions:
            sets.append(constant.solve(asked, partial(allowed, scene, free)))
        if rest := {x: f for x, f in listed.items() if x not in constant.conditions}:
            names = {x.name for x in rest}
            left = [x for x in criteria if x.name in names]
            sets.append(_by_cells(scene, free, asked, left, rest))
        return combined(sets).without(gone)
    except LimitError:
        return ValueSet.all_of(asked, holds=None, reason=STOPPED)


def _without_parameter(scene: Scene, free: Knob, asked: Domain, listed: Conditions) -> ValueSet:
    """Return the answer where the parameter is in no condition: all values at which the scene
    exists, or none where a condition is broken."""
    for condition in listed.values():
        # Denominators are nowhere negative: |H_env|^2 is one (``squared_modulus``), and several
        # functions of one condition are made so (``freeparameter.conditions``).
        numerators = [
            RealFunction(f.axis.function(f.function.numerator)) for f in pieces(condition)
        ]
        table = chart(dict(enumerate(numerators)), *scene.band)
        if table.where(lambda signs: min(signs.values()) > 0):
            return ValueSet.all_of(asked, holds=False)
        if table.undecided:
            raise UndecidedError("whether a ratio that touches its threshold goes beyond it")
    ends = (x for x in (asked.low, asked.high) if x is not None)
    gone = [ExactNumber(x) for x in ends if not allowed(scene, free, x)]
    return ValueSet.all_of(asked, holds=True).without(gone)


# Thresholds


@dataclass(frozen=True)
class ThresholdProblem:
    """The question for a threshold c: is r^2 <= c^2 on all of the band, for each squared ratio r^2?

    ``squares`` : the squared ratios, by the criterion that c is the threshold of.
    ``fixed`` : the conditions that c is not part of, which must not be positive either.
    ``band`` : its ends, rad/s. ``domain`` : the thresholds that are asked about; it has a low end.
    """

    squares: Mapping[Criterion, RealFunction]
    fixed: Mapping[Criterion, Signed]
    band: tuple[Expr, Expr]
    domain: Domain

    def solve(self) -> ValueSet:
        """Return all thresholds of the domain with which every condition is kept on the whole band:
        those from the largest ratio on, or none."""
        low, high = self.domain.low, self.domain.high
        assert low is not None
        none, every = (ValueSet.all_of(self.domain, holds=x) for x in (False, True))
        # If the largest threshold is exceeded all are, and if the smallest is not, none is: r <= c
        # holds from one value of c on.
        if self._exceeds(self.fixed):
            return none
        if high is not None and self._exceeds(self._excess(high)):
            return none
        if not self._exceeds(self._excess(low)):
            return every
        maxima = self._maxima()
        if maxima is None:
            return none
        value = SquareRoot(LargestOf(tuple(x.value for _, x in maxima)))
        bottom = SingleValue(value, holds=True, bindings=_bindings(maxima))
        # The largest ratio is the upper end itself: one value at most is left, that end.
        if high is not None and self._touches(high):
            last = replace(bottom, holds=self.domain.holds_high)
            points = SingleValue(ExactNumber(low), holds=False), last
            return ValueSet(points, (None, Stretch(holds=False), None), self.domain)
        return every & ValueSet((bottom,), (Stretch(holds=False), Stretch(holds=True)))

    def _excess(self, limit: Expr) -> dict[Criterion, Signed]:
        """Return r^2 - c^2 for the threshold c = ``limit``: what must not be positive."""
        excess = dict[Criterion, Signed]()
        for x, square in self.squares.items():
            excess[x] = replace(x, threshold=limit).exceeded(square)
        return excess

    def _exceeds(self, conditions: Mapping[Criterion, Signed]) -> bool:
        """Return whether a condition is positive somewhere on the band. UndecidedError where one
        only touches 0 and it is not proven that it does."""
        table = chart(conditions, *self.band)
        exceeds = _exceeds_somewhere(table)
        if not exceeds and table.undecided:
            raise UndecidedError("whether a ratio that touches an end of the range goes beyond it")
        return exceeds

    def _touches(self, limit: Expr) -> bool:
        """Return whether a ratio that exceeds a threshold nowhere is equal to it somewhere."""
        excess = self._excess(limit)
        if any(isinstance(x, RealFunction) and x.is_zero for x in excess.values()):
            return True  # at every frequency
        table = chart(excess, *self.band)
        return any(n > 0 for point in table.points for n in point.orders.values())

    def _maxima(self) -> list[tuple[Criterion, MaximumCandidate]] | None:
        """Return the criteria and places at which the largest ratio is attained: several where
        ``_MAXIMUM_BITS`` do not distinguish their values. None where a ratio has no bound."""
        maxima = list[tuple[Criterion, MaximumCandidate]]()
        for criterion, square in self.squares.items():
            of_square = maximum_candidates(square, *self.band)
            if of_square is None:
                return None
            maxima += [(criterion, x) for x in of_square]
        for bits in _MAXIMUM_BITS:
            with flint.ctx.workprec(bits):
                balls = [x.value.ball(bits) for _, x in maxima]
                largest = LargestOf(tuple(x.value for _, x in maxima)).ball(bits)
                pairs = zip(maxima, balls, strict=True)
                maxima = [x for x, ball in pairs if not ball < largest]
        return maxima


def _bindings(maxima: list[tuple[Criterion, MaximumCandidate]]) -> tuple[Binding, ...]:
    """Return what binds where the largest ratio is attained."""
    return tuple(Binding(criterion, x.omega, x.kind) for criterion, x in maxima)


def _threshold_problem(
    scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion]
) -> ThresholdProblem:
    """Return the question for a threshold ``free``: the criteria that it is not part of stay as
    they are."""
    d = scene.distortion()
    squares = dict[Criterion, RealFunction]()
    fixed = dict[Criterion, Signed]()
    for x in criteria:
        if x.depends_on(free.parts):
            squares |= _squares(x, d, free)
        else:
            fixed[x] = x.function(d)
    return ThresholdProblem(squares, fixed, scene.band, asked)


def _squares(x: Criterion, d: Distortion, free: Knob) -> dict[Criterion, RealFunction]:
    """Return the squares that must not exceed c^2 for a free threshold c: one, or, for a region
    whose border has several pieces, one of each.

    A region is the one of threshold 1 times c. SceneError where it judges both parts and c is the
    threshold of one.
    """
    if x.region is None:
        return {x: x.measure(d)}
    if x.joint and len(free.parts) < len(Part):
        raise SceneError(
            f"{free.path}: the {x.joint.kind} judges both parts at once: leave {THRESHOLD} free"
        )
    squares = x.region.opened(dict.fromkeys(free.parts, S.One)).squares(d)
    if len(squares) == 1:
        return {x: squares[0]}
    return {each(x, i): f for i, f in enumerate(squares, 1)}


# Signs that do not depend on the frequency


@dataclass(frozen=True)
class ConstantSigns:
    """Conditions whose sign is the same at all frequencies.

    ``conditions`` : for each the polynomials in the parameter of which at least one must not be
    positive. ``axis`` : their ring. ``free`` : the parameter. ``band`` : its ends, rad/s.
    """

    conditions: Mapping[Criterion, Sequence[Polynomial]]
    axis: Axis
    free: Symbol
    band: tuple[Expr, Expr]

    @classmethod
    def of(cls, listed: Conditions, free: Symbol, band: tuple[Expr, Expr]) -> ConstantSigns:
        """Return those of some conditions in which omega is in no factor that changes its sign."""
        constant = dict[Criterion, list[Polynomial]]()
        for x, condition in listed.items():
            row = [_without_omega(f) for f in pieces(condition)]
            known = [p for p in row if p is not None]
            if len(known) == len(row):
                constant[x] = known
        # All conditions of a scene have one axis.
        first = next(iter(listed.values()))
        return cls(constant, pieces(first)[0].axis, free, band)

    def solve(self, asked: Domain, exists: Callable[[Expr], bool]) -> ValueSet:
        """Return all values of the domain with which no condition is broken, single ones among
        them: by the signs at each zero of a polynomial, and at one value between each two.

        ``exists`` : whether there is a scene at a value; it is asked at the ends of the domain.
        """
        low, high = asked.ends
        inside = [x for x in self._zeros if _between(low, x, high)]
        points = [SingleValue(x, self._kept(x), self._bindings(x)) for x in inside]
        stretches = list[Stretch | None]()
        for a, b in pairwise([low, *inside, high]):
            stretches.append(Stretch(self._kept(ExactNumber(rational_between(a, b)))))
        if low is not None:
            points = [self._end(low, asked, exists), *points]
            stretches = [None, *stretches]
        if high is not None:
            points = [*points, self._end(high, asked, exists)]
            stretches = [*stretches, None]
        return ValueSet(tuple(points), tuple(stretches), asked)

    def _end(self, x: RealNumber, asked: Domain, exists: Callable[[Expr], bool]) -> SingleValue:
        """Return an end of the domain with its verdict."""
        assert isinstance(x, ExactNumber)
        holds = asked.holds(x) and exists(x.value) and self._kept(x)
        return SingleValue(x, holds, self._bindings(x))

    @cached_property
    def _index(self) -> int:
        """The index of the parameter among the generators of the ring."""
        return self.axis.meanings.index(self.free)

    @cached_property
    def _zeros(self) -> list[RealNumber]:
        """The zeros of all polynomials in ascending order, each once: only there a sign may
        change."""
        factors = dict[str, Polynomial]()
        for row in self.conditions.values():
            for polynomial in row:
                factors |= {str(f): f for f, _ in polynomial.factor()[1]}
        zeros = [x for f in factors.values() for x in real_roots(f, self._index, negative=True)]
        return each_once(zeros, lambda x: x)

    def _kept(self, value: RealNumber) -> bool:
        """Return whether no condition is broken at a value."""
        return all(self._lowest_sign(row, value) <= 0 for row in self.conditions.values())

    def _lowest_sign(self, row: Sequence[Polynomial], value: RealNumber) -> int:
        """Return the lowest sign of some polynomials at a value: a condition is broken where that
        is 1, and holds with equality where it is 0."""
        return min(self._sign(p, value) for p in row)

    def _sign(self, polynomial: Polynomial, value: RealNumber) -> int:
        """Return the sign of a polynomial at a value: 0 at one of its zeros, and elsewhere by balls
        of rising precision, which prove it at last, as it is not 0."""
        if not polynomial:
            return 0
        factors = [f for f, _ in polynomial.factor()[1]]
        zeros = (x for f in factors for x in real_roots(f, self._index, negative=True))
        # A value that hundreds of bits do not distinguish from a zero counts as it, as everywhere.
        if any(not ordered(x, value) for x in zeros):
            return 0

        def sign_by(bits: int) -> int | None:
            known = {pi: arb.pi(), self.free: value.ball(bits)}
            return sign_of(self.axis.ball(polynomial, known)) or None

        sign = at_rising_precision(sign_by, most=SURE_BITS)
        assert sign is not None
        return sign

    def _bindings(self, value: RealNumber) -> tuple[Binding, ...]:
        """Return what binds at a value: a condition that is 0 at all frequencies is named at both
        ends of the band."""
        bindings, (low, high) = list[Binding](), self.band
        for x, row in self.conditions.items():
            # A polynomial that is 0 for all values limits none of them.
            if all(row) and self._lowest_sign(row, value) == 0:
                bindings.append(Binding(x, ExactNumber(high), Kind.EDGE))
                bindings.append(Binding(x, ExactNumber(low), Kind.START))
        return tuple(bindings)


def _between(low: RealNumber | None, x: RealNumber, high: RealNumber | None) -> bool:
    """Return whether a number lies strictly between two others; None: without end."""
    # ``ordered(x, y)`` is 1 where y is the larger number.
    is_above = low is None or ordered(low, x) > 0
    return is_above and (high is None or ordered(x, high) > 0)


def _without_omega(piece: RealFunction) -> Polynomial | None:
    """Return a polynomial in the parameter that has the sign of a function at all frequencies but
    those at which the function is 0; None where there is none."""
    if piece.axis.functions:
        return None
    constant, factors = piece.function.numerator.factor()
    product = piece.axis.constant(constant)
    for f, n in factors:
        if not f.degrees()[0]:
            product *= f**n
        # omega itself is positive on the band; an even power changes no sign.
        elif n % 2 and f != piece.axis.variable:
            return None
    return product


# Cells


def _by_cells(
    scene: Scene, free: Knob, asked: Domain, criteria: Sequence[Criterion], listed: Conditions
) -> ValueSet:
    """Return the answer by cells: ``solve_question`` asks ``CellSearch`` for cells and ends, and
    ``ExactVerdict`` for single values."""
    low, high = searched(free, asked)
    verdict = ExactVerdict(scene, free, tuple(criteria))
    search = CellSearch(verdict, listed, _outward(low, high))
    present = None if free.value.free_symbols else free.value  # a limit may be a formula
    bounds = Domain(
        low if asked.low is None else asked.low, high if asked.high is None else asked.high
    )
    question = Question(verdict, present, cells=search.cells, end=search.end)
    return solve_question(question, asked, bounds)


@dataclass(frozen=True)
class CellSearch:
    """The cells of a range of values with their verdicts, and the exact ends in those left open.

    ``verdict`` : the exact verdict on one value. ``listed`` : the conditions with the parameter as
    a symbol. ``range`` : the lowest and the highest value that is searched.
    """

    verdict: ExactVerdict
    listed: Conditions
    range: tuple[Fraction, Fraction]

    @cached_property
    def judged(self) -> list[JudgedValues]:
        """What is known of all values of the range: intervals in ascending order that cover it."""
        return _judged(self.verdict, self.listed, *self.range)

    def cells(self, low: RealNumber | None, high: RealNumber | None) -> list[Cell]:
        """Return the verdicts on all values from ``low`` to ``high``, which are the ends of what is
        asked about (None: without end). Values that were not searched get the verdict next to
        them: beyond the domain searched ``solve_question`` claims nothing of them, and next to 0
        that is an assumption (``valueranges.searched``)."""
        inner = [ExactNumber(rational(x.low)) for x in self.judged[1:]]
        why = _why_open()
        cells = list[Cell]()
        for x, (a, b) in zip(self.judged, pairwise([low, *inner, high]), strict=True):
            cells.append(Cell(a, b, x.kept, why if x.kept is None else ""))
        return cells

    def end(self, low: RealNumber, _: RealNumber, low_holds: bool) -> SingleValue | None:  # noqa: FBT001
        """Return the value at which the verdict changes in the open cell that begins at ``low``.
        ``low_holds`` : whether the values below it hold.

        Where it is proven that there is just one (``JudgedValues.slant``), it is a number to any
        number of digits, with what binds there. In a narrow cell without that proof it is known by
        the cell alone, and nothing binds: ``ValueSet`` claims nothing of single values in it.
        Elsewhere it is None.
        """
        [cell] = (x for x in self.judged[1:] if not ordered(low, ExactNumber(rational(x.low))))
        if cell.slant is None:
            return SingleValue(Sliver(cell.low, cell.high)) if cell.is_narrow else None
        end = Bisected(
            self.verdict.of_conditions, cell.low, cell.high, low_holds, self.verdict.excess
        )
        broken, width = self._broken_beyond(end)
        exact = self._exact(end, broken)
        if exact is not None:
            return exact
        band = self.verdict.scene.band
        located = list[tuple[BrokenPiece, RealNumber]]()
        for x in broken:
            if x.kind is Kind.TOUCH:
                located.append((x, TangencyFrequency(end, self.verdict, x, cell.slant, width)))
            else:
                located.append((x, ExactNumber(band[x.kind is Kind.EDGE])))
        return SingleValue(end, None, _as_bindings(located))

    def _broken_beyond(self, end: Bisected) -> tuple[list[BrokenPiece], Fraction]:
        """Return what is broken just beyond an end, and the width of the interval in which the end
        was then known to lie: narrower where several are broken, or one at an end of the band."""
        broken, width = list[BrokenPiece](), Fraction(0)
        for bits in (_ROUGH, _CLOSE, _CLOSEST):
            low, high = end.between(bits)
            width, broken = high - low, self.verdict.broken(rational(end.beyond))
            if len(broken) == 1 and (bits > _ROUGH or broken[0].kind is Kind.TOUCH):
                break
        return broken, width

    def _exact(self, end: Bisected, broken: Sequence[BrokenPiece]) -> SingleValue | None:
        """Return the end as an exact number, rational or rational in pi; None where none is proven
        to be it.

        The proof: the number lies where the one end does, and there all criteria are kept, and one
        of those broken beyond holds with equality, at a frequency at which it is broken beyond. As
        its function grows strictly there where it may be 0 (``JudgedValues.slant``), it is broken
        for the next values: they are no part of the set.
        """
        low, high = (ExactNumber(rational(x)) for x in end.between(_CLOSE))
        # The value that holds last was asked for, and may be the very end.
        tried = [low if end.low_holds else high]
        near = rational_between(low, high)
        if max(int(near.p).bit_length(), int(near.q).bit_length()) <= _SIMPLE:
            tried.append(ExactNumber(near))
        free, band = self.verdict.free.symbol, self.verdict.scene.band
        for kind in {x.kind for x in broken} - {Kind.TOUCH}:
            tried += _linear_roots(self.listed, free, band[kind is Kind.EDGE])
        for x in tried:
            if x not in (low, high) and not _between(low, x, high):
                continue
            binding = _both_in(broken, self.verdict.equalities(x.value))
            if binding:
                return SingleValue(x, None, _as_bindings(binding))
        return None


def _both_in(
    broken: Sequence[BrokenPiece], equalities: Sequence[tuple[Criterion, RealNumber]]
) -> list[tuple[BrokenPiece, RealNumber]]:
    """Return the frequencies at which a criterion holds with equality that lie on a piece of the
    band on which the same criterion is broken beyond, each with that piece."""
    binding = list[tuple[BrokenPiece, RealNumber]]()
    for piece in broken:
        for criterion, frequency in equalities:
            if criterion == piece.criterion and piece.holds(frequency):
                binding.append((piece, frequency))
    return binding


def _why_open() -> str:
    """Return why values are open: that bounds do not settle them, or that the time is over."""
    try:
        tick()
    except LimitError:
        return STOPPED
    return _UNSETTLED


def _as_bindings(located: Sequence[tuple[BrokenPiece, RealNumber]]) -> tuple[Binding, ...]:
    """Return what binds, from what is broken beyond an end and the frequency at which each holds
    with equality: at the high end of the band first, then at the low one, then inside."""
    in_order = sorted(located, key=lambda x: _BINDING_ORDER.index(x[0].kind))
    return tuple(Binding(piece.criterion, omega, piece.kind) for piece, omega in in_order)


def _linear_roots(listed: Conditions, free: Symbol, frequency: Expr) -> Iterator[ExactNumber]:
    """Yield, of rational conditions at one frequency, the zeros in the parameter that are rational,
    or rational in pi: those of linear factors."""
    for f in (f for condition in listed.values() for f in pieces(condition)):
        if f.axis.functions:
            continue
        polynomial = _at_frequency(f, frequency)
        index = f.axis.meanings.index(free)
        for factor, _ in polynomial.factor()[1] if polynomial else ():
            if factor.degrees()[index] == 1:
                zeros = real_roots(factor, index, negative=True)
                yield from (x for x in zeros if isinstance(x, ExactNumber))


def _at_frequency(f: RealFunction, frequency: Expr) -> Polynomial:
    """Return the numerator of a function at a frequency, times a positive number; at 0, where it
    may vanish for all values, the coefficient of its lowest power of omega, which has its sign
    beside 0."""
    numerator = f.function.numerator
    if frequency != 0:
        return substituted(numerator, 0, f.axis.convert(frequency))
    lowest = min(int(exponents[0]) for exponents in numerator.monoms())
    terms = dict[tuple[int, ...], fmpq]()
    for (power, *others), coefficient in monomials(numerator):
        if int(power) == lowest:
            terms[0, *others] = coefficient
    return numerator.context().from_dict(terms)


def _judged(
    verdict: ExactVerdict, listed: Conditions, low: Fraction, high: Fraction
) -> list[JudgedValues]:
    """Return what is known of all values between two: by floats, or by balls where there is no
    NumPy, or floats do not cover the criteria."""
    scale = _usual(verdict.free)
    if has_arrays():
        # NumPy is loaded only for a question that needs it.
        from haptisym.verbs.require.floatcells import FloatCells

        is_broken = partial(_is_broken, verdict, listed)
        cells = FloatCells(verdict.scene, verdict.free, verdict.criteria, scale, is_broken)
        if cells.are_known:
            return cells.told(float(low), float(high))
    band = verdict.scene.band
    of_values = verdict.of_conditions
    return BallCells(listed, verdict.free.symbol, band, Fraction(scale), of_values).told(low, high)


def _is_broken(verdict: ExactVerdict, listed: Conditions, cell: JudgedValues) -> bool:
    """Return whether balls show at a frequency that a condition is broken for all values of a
    cell. The frequencies tried are those in the middle of what is broken at its high end."""
    with suppress(SceneError, UndecidedError), flint.ctx.workprec(_BITS):
        frequencies = [x.ball(_BITS).mid() for x in verdict.broken(rational(cell.high))]
        # Twice as wide, upward, so that its middle is not 0: powers of balls about 0 are nan.
        beyond = 2 * cell.high - cell.low
        value = fraction_ball(cell.low).union(fraction_ball(beyond))
        for condition in listed.values():
            for x in frequencies:
                known = {omega: x, verdict.free.symbol: value}
                if all(_numerator(f, known) > 0 for f in pieces(condition)):
                    return True
    return False


def _numerator(f: RealFunction, known: Mapping[Expr, Ball]) -> Ball:
    """Return the numerator of a condition, which has its sign, for balls of frequency and
    parameter."""
    ring = f.half_angled.ring
    balls = {}
    for x in ring.meanings:
        if x.free_symbols <= known.keys():
            balls[x] = expression_ball(x, known)
    return ring.ball(f.half_angled.numerator, balls)


def _usual(free: Knob) -> float:
    """Return a usual size of a parameter: that of its present value, or 1 where that is 0 or a
    formula."""
    return (0.0 if free.value.free_symbols else abs(float(free.value))) or 1.0


def _outward(low: Expr, high: Expr) -> tuple[Fraction, Fraction]:
    """Return floats, exactly, that enclose the values from ``low`` to ``high``."""
    with flint.ctx.workprec(53):
        below = float(expression_ball(low).lower())
        above = float(expression_ball(high).upper())
    return Fraction(below), Fraction(above)


# One value


@dataclass(frozen=True, eq=False)
class ExactVerdict:
    """The exact verdict on one value of a parameter: whether the scene exists there and keeps the
    criteria on all of the band.

    A call gives True, False, or None where a criterion touches its limit so closely that it is not
    distinguished from one that exceeds it. The other methods need a scene that exists.
    """

    scene: Scene
    free: Knob
    criteria: tuple[Criterion, ...]
    # The chart of the last value alone: a verdict, and then what is broken there, ask for it again.
    _last: dict[Expr, Chart] = field(default_factory=dict, repr=False)

    def __call__(self, value: Expr) -> bool | None:
        try:
            table = self._chart(value)
        except SceneError:
            return False
        if _exceeds_somewhere(table):
            return False
        return None if table.undecided else True

    def of_conditions(self, value: Expr) -> bool | None:
        """Return the verdict of the criteria alone: False only where one is broken, and None where
        there is no scene, of which nothing follows for the values beside it."""
        try:
            self._chart(value)
        except SceneError:
            return None
        return self(value)

    def _chart(self, value: Expr) -> Chart:
        """Return the signs of all criteria, by criterion, along the band, at a value; SceneError
        where no scene exists there. A criterion is broken where its sign is 1."""
        if value not in self._last:
            scene = self.free.put(self.scene, value)
            # Where the parameter is a part of the threshold, the criteria are those of the new
            # scene.
            of_scene = {x.name: x for x in noticed(scene.threshold)}
            d = scene.distortion()
            functions = dict[Criterion, Signed]()
            for x in self.criteria:
                judged = of_scene[x.name] if x.depends_on(self.free.parts) else x
                functions[x] = judged.function(d)
            self._last.clear()
            self._last[value] = chart(functions, *scene.band)
        return self._last[value]

    def broken(self, value: Expr) -> list[BrokenPiece]:
        """Return the pieces of the band on which criteria are broken at a value."""
        table = self._chart(value)
        first, last = table.points[0], table.points[-1]
        broken = list[BrokenPiece]()
        for criterion in self.criteria:
            for piece in table.where(lambda signs, x=criterion: signs[x] > 0):  # type: ignore[misc]
                at_low, at_high = piece.low is first, piece.high is last
                broken.append(BrokenPiece(criterion, piece, at_low, at_high))
        return broken

    def excess(self, value: Expr) -> Ball:
        """Return how much of the band is broken at a value: 0 at an end, and nearly linear beyond
        it, so that the secant method finds the end.

        The width of a broken piece grows linearly beyond an end that binds at an end of the band;
        inside of the band, as a square root: there its square counts.
        """
        bits, total = int(flint.ctx.prec), arb(0)
        for x in self.broken(value):
            low, high = x.piece.low.omega, x.piece.high.omega
            width = high.tight_ball(bits) - low.tight_ball(bits)
            total += width**2 if x.kind is Kind.TOUCH else width
        return total

    def equalities(self, value: Expr) -> list[tuple[Criterion, RealNumber]]:
        """Return where on the band criteria hold with equality, each with its frequency, at a value
        that keeps them all; nothing where it does not, or that is undecided."""
        table = self._chart(value)
        if table.undecided or _exceeds_somewhere(table):
            return []
        equalities = list[tuple[Criterion, RealNumber]]()
        for x in self.criteria:
            equalities += [(x, p.omega) for p in table.points if p.orders.get(x, 0) > 0]
        return equalities


def _exceeds_somewhere(table: Chart) -> bool:
    """Return whether one of the functions of a chart is positive somewhere."""
    return bool(table.where(lambda signs: any(sign > 0 for sign in signs.values())))


@dataclass(frozen=True, eq=False)
class BrokenPiece:
    """A ``piece`` of the band on which a criterion is broken just beyond an end of the allowed
    values, and whether it begins where the band begins (``at_low``), or ends where it ends
    (``at_high``)."""

    criterion: Criterion
    piece: Interval
    at_low: bool
    at_high: bool

    @property
    def kind(self) -> Kind:
        """How the criterion binds at the end: at the band's high end, at its low one, or by a
        tangency inside."""
        return Kind.EDGE if self.at_high else Kind.START if self.at_low else Kind.TOUCH

    def holds(self, x: RealNumber) -> bool:
        """Return whether a frequency lies on the piece, its ends included."""
        low, high = self.piece.low.omega, self.piece.high.omega
        return ordered(low, x) >= 0 and ordered(x, high) >= 0

    def ball(self, bits: int) -> Ball:
        """Return a ball around all of the piece."""
        low, high = self.piece.low.omega, self.piece.high.omega
        return low.tight_ball(bits).union(high.tight_ball(bits))


@dataclass(frozen=True, eq=False, repr=False)
class TangencyFrequency(RealNumber):
    """The frequency omega at which a criterion binds inside of the band, at the one end e of the
    allowed values.

    ``end`` : e. ``verdict`` : on one value. ``slant`` : what is broken for a value is broken for
    all values beyond it, at a frequency that moves by no more than this, rad/s per unit of the
    value. ``near`` : the piece of the band on which the criterion was broken for a value beyond e
    that is no more than ``width`` away from e.

    The proof of ``ball``: for a value v beyond e some piece on which the criterion is broken comes
    within slant |v - e| of omega, and moves into ``near`` by slant width at most as v moves away
    from e. So omega lies in one of the pieces for v that overlap with ``near``, the one made wider
    by slant |v - e|, the other by slant width. As v tends to e the pieces become as short as one
    likes.
    """

    end: Bisected
    verdict: ExactVerdict
    near: BrokenPiece
    slant: float
    width: Fraction

    def ball(self, bits: int) -> Ball:
        low, high = self.end.between(2 * bits)
        with flint.ctx.workprec(2 * bits + 32):
            near = self.near.ball(2 * bits) + self._moved(self.width)
            pieces: list[Ball] = []
            for piece in self.verdict.broken(rational(self.end.beyond)):
                if piece.criterion == self.near.criterion:
                    ball = piece.ball(2 * bits)
                    if ball.overlaps(near):
                        pieces.append(ball + self._moved(high - low))
            return reduce(arb.union, pieces)

    def _moved(self, apart: Fraction) -> Ball:
        """A ball about 0 of all ways that a frequency can move while the value moves so far."""
        return arb(0, self.slant * fraction_ball(apart).upper())
