"""The values of a parameter at which a polynomial condition changes: exact, and where a scene does not exist.

The polynomials in one parameter or two whose zeros bound a requirement, and their real roots.

Where on a band conditions are broken at one value of their parameter: a rational number, or an algebraic one near others.

Where a function of frequency and of one parameter has an extremum or a zero, for a value known to any precision.

For which values of one parameter a polynomial condition holds all over a band: exact.

A condition N(omega, t) <= 0, N a polynomial, holds on the whole band for a set of values t. The set can begin or end only
where a zero of N in omega enters over an end of the band, N(end, t) = 0, or where two zeros meet: where the discriminant of
a factor of N or the resultant of two factors vanishes. These *critical values* are roots of polynomials in t; between
neighbours the answer is the same for all t, and one exact test at a rational number tells it (a cylindrical
decomposition in one parameter). At a critical value itself the answer is that of a feasible neighbour, as what does not
exceed does not exceed in the limit; between two others it is tested in the number field of the value. Of several polynomials
that must not all be positive, as a region asks for, the factors are those of all.

The sign of a polynomial in one parameter, exactly: what Im H_perc has just above frequency 0, and far out.

Values of one parameter at which a scene does not exist: where its environment is zero everywhere, or it is divided by 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, pairwise, product
from math import prod
from typing import Any, TypeAlias

import flint
from flint import arb, fmpq
from sympy import Expr, Integer, Poly, Rational, Symbol, pi

from haptisym.judge.crossings import Criterion
from haptisym.kernel.axis import Axis
from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import RealFunction, Ring
from haptisym.kernel.errors import LimitError, SceneError, UndecidedError
from haptisym.kernel.factors import PolynomialFactor, Root
from haptisym.kernel.reals import (
    SURE_BITS,
    Ball,
    ExactNumber,
    Negative,
    RealNumber,
    at_rising_precision,
    expression_ball,
    rational_between,
)
from haptisym.kernel.rings import Polynomial, PolynomialRing, RationalFunction, monomials, omega
from haptisym.kernel.roots import Interval, chart, in_order, ordered, sign_of_number
from haptisym.kernel.zeros import rounded_up, sign_of, tightened
from haptisym.model.chain import Chain
from haptisym.model.parameters import values
from haptisym.model.scene import Knob, Scene
from haptisym.verbs.require.feasible import Binding, End, Kind, Solved, Span, runs
from haptisym.verbs.require.freeparameter import Conditions, Domain, pieces
from haptisym.verbs.stability.loops import zeros

Reason: TypeAlias = tuple[Criterion, Kind] | None
"""Which condition is critical, and how; None: the condition is nowhere defined."""


def critical(
    criterion: Criterion, pieces: Sequence[RealFunction], band: tuple[Expr, Expr]
) -> Iterator[tuple[Reason, Polynomial]]:
    """The polynomials in pi and the parameter whose roots are critical for a condition on a band, and why each is.

    ``pieces`` : the functions of the condition, which must not all be positive.
    """
    ring = pieces[0].axis
    factors: list[Polynomial] = []
    for piece in pieces:
        for factor, _ in irreducible(piece.function.denominator):
            if not factor.degrees()[0]:
                yield None, factor
        own = [f for f, n in irreducible(piece.function.numerator) if n % 2 or not f.degrees()[0]]
        factors += [f for f in own if f not in factors]
    for f in factors:
        for kind, end in zip((Kind.START, Kind.EDGE), band, strict=True):
            yield (criterion, kind), substituted(f, 0, ring.convert(end))
        if f.degrees()[0] > (2 if is_even(f) else 1):
            yield (criterion, Kind.TOUCH), in_square(f).discriminant(0)
    for f, g in combinations([f for f in factors if f.degrees()[0] and f != ring.variable], 2):
        if is_even(f) and is_even(g):
            f, g = in_square(f), in_square(g)
        yield (criterion, Kind.TOUCH), f.resultant(g, 0)


def real_roots(factor: Polynomial, index: int, *, negative: bool) -> Iterator[RealNumber]:
    """The positive roots, and negative ones if wanted, of an irreducible polynomial in pi and the parameter of that index."""
    own = [int(n) for n in factor.degrees()]
    if not own[index]:
        return
    rows = [[0] * (own[1] + 1) for _ in range(own[index] + 1)]
    for exponents, value in monomials(factor):
        rows[int(exponents[index])][int(exponents[1])] = int(value.p)
    if len(rows) == 2:
        value = -_in_pi(rows[0]) / _in_pi(rows[1])
        yield ExactNumber(value.cancel() if value.has(pi) else value)
        return
    yield from _positive_roots(rows)
    if negative:
        mirrored = [[-n for n in row] if i % 2 else row for i, row in enumerate(rows)]
        yield from map(Negative, _positive_roots(mirrored))


def irreducible(polynomial: Polynomial) -> list[tuple[Polynomial, int]]:
    """Irreducible factors, in omega^2 where the whole is even in omega."""
    if not is_even(polynomial):
        return [(f, int(n)) for f, n in polynomial.factor()[1]]
    steps = [2, *[1] * (len(polynomial.degrees()) - 1)]
    return [(f.inflate(steps), int(n)) for f, n in polynomial.deflate(steps).factor()[1]]


def is_even(polynomial: Polynomial) -> bool:
    """Whether it is even in its first variable."""
    return not any(int(e[0]) % 2 for e in polynomial.monoms())


def in_square(polynomial: Polynomial) -> Polynomial:
    """An even polynomial as one in omega^2."""
    return polynomial.deflate([2, *[1] * (len(polynomial.degrees()) - 1)]) if is_even(polynomial) else polynomial


def substituted(polynomial: Polynomial, index: int, value: RationalFunction) -> Polynomial:
    """A polynomial with a number for one of its variables, times a positive number."""
    if value.denominator.is_constant() and value.numerator.is_constant():
        number = _constant(value.numerator) / _constant(value.denominator)
        return polynomial.subs({f"x{index}": number})
    degree = int(polynomial.degrees()[index])
    degree += degree % 2  # an even power of the denominator keeps the sign
    context = polynomial.context()
    powers: dict[int, dict[tuple[int, ...], fmpq]] = {}
    for exponents, coefficient in monomials(polynomial):
        own = [int(n) for n in exponents]
        power, own[index] = own[index], 0
        powers.setdefault(power, {})[tuple(own)] = coefficient
    return sum(
        (
            context.from_dict(terms) * value.numerator**n * value.denominator ** (degree - n)
            for n, terms in powers.items()
        ),
        context.constant(0),
    )


def _constant(polynomial: Polynomial) -> fmpq:
    return next(iter(polynomial.to_dict().values()), fmpq(0))


def _in_pi(row: Sequence[int]) -> Expr:
    return sum((Integer(n) * pi**i for i, n in enumerate(row)), Integer(0))


def _positive_roots(rows: Sequence[Sequence[int]]) -> list[RealNumber]:
    return [*PolynomialFactor(tuple(_trimmed(row) for row in rows), step=1).positive_roots()]


def _trimmed(row: Sequence[int]) -> tuple[int, ...]:
    """A row without the zeros of high powers of pi, so that a rational one is seen to be so."""
    last = max((i for i, n in enumerate(row) if n), default=0)
    return tuple(row[: last + 1])


def of_factor(ring: PolynomialRing, index: int, factor: PolynomialFactor, *, mirrored: bool) -> Polynomial:
    """A factor in the parameter as a polynomial of the ring."""
    terms = {}
    for i, row in enumerate(factor.coefficients):
        for j, n in enumerate(row):
            exponents = [0] * len(ring.meanings)
            exponents[index], exponents[1] = i, j
            terms[tuple(exponents)] = fmpq(-n if mirrored and i % 2 else n)
    return ring.context.from_dict(terms)


def edge_polynomial(pieces: Sequence[RealFunction], end: Expr) -> Expr:
    """The polynomial in the parameters that vanishes where a rational condition binds at a frequency."""
    axis = _without_functions(pieces)
    tops = [substituted(piece.function.numerator, 0, axis.convert(end)) for piece in pieces]
    return axis.factored_expression(prod(tops[1:], start=tops[0]))


def touch_polynomial(pieces: Sequence[RealFunction]) -> Expr:
    """What vanishes where a rational condition binds inside the band: discriminants in omega^2, and of several resultants."""
    axis = _without_functions(pieces)
    own = [[f for f, n in irreducible(piece.function.numerator) if n % 2 and f.degrees()[0]] for piece in pieces]
    found = axis.constant(1)
    for f in (f for factors in own for f in factors):
        found *= in_square(f).discriminant(0) if f.degrees()[0] > (2 if is_even(f) else 1) else 1
    for f, g in (pair for one, other in combinations(own, 2) for pair in product(one, other) if pair[0] != pair[1]):
        found *= in_square(f).resultant(in_square(g), 0) if is_even(f) and is_even(g) else f.resultant(g, 0)
    return axis.factored_expression(found)


def _without_functions(pieces: Sequence[RealFunction]) -> Axis:
    if pieces[0].axis.functions:
        raise SceneError("with delays or powers of s the boundary is no polynomial's zero")
    return pieces[0].axis


_ROUNDS = (8, 32, 128, 512)
"""Bits by which a critical value is approached for a witness, before its number field is asked."""


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
        """Whether nothing is broken in it."""
        return not self.broken


@dataclass(frozen=True)
class Breaking:
    """Conditions in omega and one parameter on a band, at values of the parameter."""

    conditions: Conditions
    free: Symbol
    band: tuple[Expr, Expr]

    @cached_property
    def pieces(self) -> Mapping[Criterion, tuple[RealFunction, ...]]:
        """Of each condition the functions that must not all be positive."""
        return {x: pieces(condition) for x, condition in self.conditions.items()}

    @property
    def ring(self) -> Axis:
        """The one in which all pieces are written."""
        return next(iter(self.pieces.values()))[0].axis

    @cached_property
    def index(self) -> int:
        """The parameter's number among the variables of the ring."""
        return self.ring.meanings.index(self.free)

    def at(self, value: Expr) -> tuple[BrokenInterval, ...]:
        """Where the first of the broken conditions is, at a number that is rational, or rational in pi; () if none is."""
        return next((found for criterion in self.conditions if (found := self.of(criterion, value))), ())

    def of(self, criterion: Criterion, value: Expr) -> tuple[BrokenInterval, ...]:
        """Where a condition is broken at such a number; the points have the orders of its functions by their places."""
        table = chart(dict(enumerate(self._functions(criterion, value))), *self.band)
        return tuple(BrokenInterval(criterion, x) for x in table.where(lambda signs: min(signs.values()) > 0))

    def _functions(self, criterion: Criterion, value: Expr) -> list[RealFunction]:
        """What stands above the line of each; 1 where one is nowhere defined."""
        found = []
        for piece in self.pieces[criterion]:
            if self._put(piece.function.denominator, value).is_zero():
                return [RealFunction(self.ring.one)]
            found.append(RealFunction(self.ring.function(self._put(piece.function.numerator, value))))
        return found

    def _put(self, polynomial: Polynomial, value: Expr) -> Polynomial:
        return substituted(polynomial, self.index, self.ring.convert(value))

    def near(self, value: RealNumber, cells: Sequence[Cell]) -> bool:
        """Whether a condition is broken at an algebraic value between two cells that are not feasible.

        First at frequencies at which one is broken nearby; where none shows, in the number field of the value.
        """
        if any(self._positive_at(x, value) for cell in cells for x in cell.broken):
            return True
        beside = (self.at(approached(value, cell.sample, bits)) for bits in _ROUNDS for cell in cells)
        if any(self._positive_at(x, value) for broken in beside for x in broken):
            return True
        return any(self._exceeds_exactly(criterion, value) for criterion in self.conditions)

    def _positive_at(self, excess: BrokenInterval, value: RealNumber) -> bool:
        """Whether a condition that is broken at a near value shows to be so, at the same frequency, at this one."""
        place = rational_between(excess.band.low.omega, excess.band.high.omega)
        with flint.ctx.workprec(512):
            at = ExactNumber(place).ball(512), value.ball(512)
            return all(self._value(piece, *at) > 0 for piece in self.pieces[excess.criterion])

    def may_bind(self, criterion: Criterion, place: RealNumber, value: RealNumber) -> bool:
        """Whether none of several functions is negative at a frequency where one of them vanishes."""
        own = self.pieces[criterion]
        with flint.ctx.workprec(512):
            return len(own) == 1 or not any(self._value(f, place.ball(512), value.ball(512)) < 0 for f in own)

    def _value(self, piece: RealFunction, place: Ball, value: Ball) -> Ball:
        return self.ring.ball(piece.function.numerator, {omega: place, pi: arb.pi(), self.free: value})

    def _exceeds_exactly(self, criterion: Criterion, value: RealNumber) -> bool:
        """By the zeros of norms: between them every function has one sign, which any frequency in between tells."""
        root = value.number if isinstance(value, Negative) else value
        assert isinstance(root, Root)
        minimal = of_factor(self.ring, self.index, root.factor, mirrored=root is not value)
        own = self.pieces[criterion]
        tops = [f.function.cleared().numerator for f in own]
        norms = [p.resultant(minimal, self.index) if p.degrees()[self.index] else p for p in tops]
        if any(norm.is_zero() for norm in norms):
            return False
        table = chart({i: RealFunction(self.ring.function(norm)) for i, norm in enumerate(norms)}, *self.band)
        between = [rational_between(a.omega, b.omega) for a, b in pairwise(table.points)]
        return any(all(self._sign(f, place, value) > 0 for f in own) for place in between)

    def _sign(self, piece: RealFunction, place: Rational, value: RealNumber) -> int:
        """The sign of a function where it is not zero."""
        at = ExactNumber(place)
        sign = at_rising_precision(
            lambda bits: sign_of(self._value(piece, at.ball(bits), value.ball(bits))) or None, most=SURE_BITS
        )
        if sign is None:
            raise UndecidedError(f"the sign of a condition at omega = {place} rad/s")
        return sign


def approached(value: RealNumber, sample: Rational, bits: int) -> Rational:
    """A rational number between a value and a sample, nearer the value by that many bits."""
    low, high = value.bounds(bits + 64)
    start = low if ExactNumber(sample).bounds(64)[0] < low else high
    at = Rational(start.numerator, start.denominator)
    return at + (sample - at) / 2**bits


@dataclass(frozen=True)
class Surface:
    """The slope and the curvature in omega of a function of omega and one parameter, in balls."""

    slope: RationalFunction
    bend: RationalFunction
    free: Symbol

    @classmethod
    def of(cls, function: RealFunction, free: Symbol) -> Surface:
        """Of a function: its first and second derivative to omega."""
        slope = function.derivative()
        return cls(slope.function, slope.derivative().function, free)

    def ball(self, function: RationalFunction, place: Ball, value: Ball) -> Ball:
        """A ball around the values at balls of frequencies and of the parameter, at the current working precision."""
        known: dict[Expr, Any] = {omega: place, self.free: value}
        ring: PolynomialRing = function.ring
        values = {g: expression_ball(g, known) for g in ring.meanings if not g.is_Symbol or g in known}
        return ring.ball(function.numerator, values) / ring.ball(function.denominator, values)


@dataclass(frozen=True, repr=False)
class Touch(RealNumber):
    """The one extremum of a function of omega between two frequencies, where the parameter has a given value."""

    surface: Surface
    value: RealNumber
    low: Ball
    high: Ball

    def ball(self, bits: int) -> Ball:
        bits = rounded_up(bits)
        with flint.ctx.workprec(bits):
            at, surface = self.value.ball(bits), self.surface
            return tightened(
                self.low,
                self.high,
                bits,
                lambda x, count: [surface.ball(f, x, at) for f in (surface.slope, surface.bend)[:count]],
            )


def touch(surface: Surface, value: RealNumber, low: RealNumber, high: RealNumber, beyond: int = 0) -> Touch | None:
    """The extremum between two frequencies, proven to be there and to be the only one; None where that does not show.

    With ``beyond`` bits it is sought 2^-beyond rad/s outside as well.
    """
    with flint.ctx.workprec(256):
        outside = arb(2) ** -beyond if beyond else arb(0)
        start, end, at = low.ball(256).lower() - outside, high.ball(256).upper() + outside, value.ball(256)
        bend = surface.ball(surface.bend, start.union(end), at)
        left, right = (surface.ball(surface.slope, x, at) for x in (start, end))
        certain = (bend < 0 and left > 0 and right < 0) or (bend > 0 and left < 0 and right > 0)
    return Touch(surface, value, start, end) if certain else None


@dataclass(frozen=True)
class Surfaces:
    """One of the functions of a condition: where it has an extremum, and where a zero."""

    extremum: Surface
    zero: Surface

    @classmethod
    def of(cls, piece: RealFunction, free: Symbol) -> Surfaces:
        """Of what stands above the line."""
        ring = piece.axis
        top = RealFunction(ring.function(piece.function.numerator))
        return cls(Surface.of(top, free), Surface(top.function, top.derivative().function, free))


def isolated_touch(surfaces: Sequence[Surfaces], value: RealNumber, near: Interval, beyond: int) -> Touch | None:
    """What an interval shrinks to on which a condition is broken at a value nearby: proven, or None where that does not show.

    Where one function vanishes at both ends that is its extremum; where two do, the zero of one at which the other has its.
    """
    places = range(len(surfaces))
    low, high = ({i for i in places if point.orders.get(i, 0) > 0} for point in (near.low, near.high))
    ends = near.low.omega, near.high.omega
    for i in sorted(low & high):
        return touch(surfaces[i].extremum, value, *ends, beyond)
    found = (touch(surfaces[i].zero, value, *ends, beyond or _AROUND) for i in sorted(low | high))
    return next((x for x in found if x), None)


_AROUND = 12
"""Bits of what is looked at outside of an interval for the zero that two functions share, which may lie beyond its ends."""


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


_BITS = 256


def zeros_of(form: Expr, symbol: Symbol) -> list[RealNumber]:
    """The real zeros of a polynomial that is not 0 everywhere, each once."""
    row = Poly(form, symbol).all_coeffs()[::-1]
    later = next(i for i, x in enumerate(row) if x != 0)
    row = row[later:]
    mirrored = (
        [-x if i % 2 else x for i, x in enumerate(row)] if len(row) > 2 else []
    )  # a linear one has its zero anyway
    below = (ExactNumber(-x.value) if isinstance(x, ExactNumber) else Negative(x) for x in zeros(mirrored))
    return [*[ExactNumber(Integer(0))] * (later > 0), *zeros(row), *below]


def keeps_sign(form: Expr, symbol: Symbol, low: Expr, high: Expr) -> bool:
    """Whether a polynomial has no zero between two values; at them it may have one."""
    if not form.is_polynomial(symbol) or form.expand() == 0:
        return False
    return not any(is_between(low, x, high) for x in zeros_of(form, symbol))


def is_between(low: Expr | None, x: RealNumber, high: Expr | None) -> bool:
    """Whether a number lies between two others (None: without bound), or so near to one that some hundred bits do not tell."""
    if isinstance(x, ExactNumber) and x.value.is_Rational:
        return (low is None or bool(low < x.value)) and (high is None or bool(x.value < high))
    with flint.ctx.workprec(_BITS):
        place = x.ball(_BITS)
        below = low is not None and bool(place <= expression_ball(low))
        return not below and not (high is not None and bool(place >= expression_ball(high)))


@dataclass(frozen=True)
class ExactSign:
    """The sign of a polynomial that is not 0 everywhere.

    >>> from sympy import symbols
    >>> q = symbols("q")
    >>> sign = ExactSign(q**2 - 4, q)
    >>> [sign.at(x) for x in map(Integer, (-3, 2, 0))], sign.between(Integer(2), None), sign.between(Integer(-3), Integer(3))
    ([1, 0, -1], 1, None)
    """

    form: Expr
    symbol: Symbol

    @cached_property
    def zeros(self) -> tuple[RealNumber, ...]:
        """Where it may change."""
        return tuple(zeros_of(self.form, self.symbol)) if self.form.has(self.symbol) else ()

    def at(self, value: Expr) -> int:
        """The sign for one value."""
        return sign_of_number(self.form.xreplace({self.symbol: value}))

    def between(self, low: Expr | None, high: Expr | None) -> int | None:
        """The sign for all values between two (None: without bound); None where it is not one."""
        if any(is_between(low, x, high) for x in self.zeros):
            return None
        if low is None:
            return self.at(Integer(0) if high is None else high - 1)
        return self.at(low + 1 if high is None else (low + high) / 2)


def missing(scene: Scene, free: Knob) -> list[RealNumber]:
    """All such values, of either sign.

    >>> from haptisym import effects, environments
    >>> spring = environments.expression("k - 5", parameters={"k": "8 N/m"})
    >>> late = Scene(spring, (effects.delay("1 ms"),))
    >>> missing(late, late.knobs["k"])
    [5]
    """
    chain = scene.chain.at(values(x for x in scene.parameters if x.path != free.path))
    ring = Ring.of(chain.entries())
    if free.parts or free.symbol not in ring.symbols:
        return []
    index = ring.meanings.index(free.symbol)
    factors = list[Polynomial]()
    for p in _vanishing(chain, ring):
        factors += [f for f in _factors(p, index) if f not in factors]
    found = (x for f in factors for x in real_roots(f, index, negative=True))
    return [x for x in found if not (_is_rational(x) and allowed(scene, free, x.value))]  # type: ignore[attr-defined]


def allowed(scene: Scene, free: Knob, value: Expr) -> bool:
    """Whether the scene exists at a value of the parameter."""
    try:
        free.put(scene, value).distortion()
    except SceneError:
        return False
    return True


def without(spans: Sequence[Span], gone: Sequence[RealNumber]) -> tuple[Span, ...]:
    """Intervals of values without some."""
    found = tuple(spans)
    for x in gone:
        found = tuple(y for span in found for y in _cut(span, x))
    return found


def _cut(span: Span, x: RealNumber) -> Iterator[Span]:
    low, high = span.low, span.high
    after = 1 if low.value is None else ordered(low.value, x)
    before = 1 if high.value is None else ordered(x, high.value)
    if after > 0 and before > 0:
        yield from (Span(low, End(x)), Span(End(x), high))
    elif after < 0 or before < 0:
        yield span
    elif after or before:  # x is one of two ends
        yield Span(replace(low, closed=low.closed and after > 0), replace(high, closed=high.closed and before > 0))


def _vanishing(chain: Chain, ring: Ring) -> Iterator[Polynomial]:
    """What must not be zero everywhere: the environment, and all that is divided by."""
    yield ring.convert(chain.environment).reduced().numerator
    yield chain.perceived(range(len(chain.matrices)), ring).denominator
    for entry in chain.entries():
        yield ring.convert(entry).denominator


def _factors(polynomial: Polynomial, index: int) -> Iterator[Polynomial]:
    """Those in one variable, and pi, alone: where they are zero the polynomial is, whatever the other variables are."""
    rows: dict[tuple[int, ...], dict[tuple[int, ...], object]] = {}
    for exponents, value in monomials(polynomial):
        own = [int(n) for n in exponents]
        key = tuple(n if i in (1, index) else 0 for i, n in enumerate(own))
        rest = tuple(0 if i in (1, index) else n for i, n in enumerate(own))
        rows.setdefault(rest, {})[key] = value
    context = polynomial.context()
    common = context.constant(0)
    for row in rows.values():
        common = common.gcd(context.from_dict(row))
    yield from (f for f, _ in common.factor()[1]) if common else ()


def _is_rational(x: RealNumber) -> bool:
    return isinstance(x, ExactNumber) and bool(x.value.is_Rational)
