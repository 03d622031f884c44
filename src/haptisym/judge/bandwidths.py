"""From thresholds to bandwidths: how far a display is transparent as a threshold or a region grows, and over a range of it.

Where the bandwidth lands behind a peak that it jumps over, and which of two numbers is the larger.

The bandwidth as one threshold for all criteria grows: where it jumps, exactly.

The bandwidth as a JND region grows with one number, whatever its shape: where it jumps, exactly.

All bandwidths of a scene whose threshold is only known as a range: an interval, less the jumps at peaks of the ratios.

The bandwidth as a function of c is the generalised inverse of the running maximum of the ratio r: it grows with c, and
jumps where c reaches a peak that is higher than all before it. So a range of c maps exactly onto a set of bandwidths, without
sampling.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from itertools import product
from typing import Any

import flint
from flint import arb, fmpq, fmpq_poly
from sympy import Expr, Integer, Rational, S, sqrt

from haptisym.judge.crossings import JOINT, Criterion, kept, level, noticed
from haptisym.judge.peaks import SCALE, Envelope, Largest, Maximum, Peak, ValueAt, moved, nominal_of, split
from haptisym.judge.regions import Term
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.factors import Level
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    Negative,
    RealNumber,
    SquareRoot,
    at_rising_precision,
    expression_ball,
)
from haptisym.kernel.roots import Chart, Interval, Key, Lattice, Point, chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Threshold
from haptisym.model.parameters import ExactRange

_SURE = 400
"""Bits up to which two numbers are told apart before they are taken for one."""


@dataclass(frozen=True, repr=False)
class Landing(RealNumber):
    """The bandwidth for the height of a peak, or of the band's low end: enclosed by those for rational heights beside it."""

    height: RealNumber

    @abstractmethod
    def at(self, height: Expr) -> RealNumber | None:
        """The bandwidth for a rational height."""

    @abstractmethod
    def behind(self, height: Rational) -> RealNumber | None:
        """That for one that is hardly too little, if the peak itself did not count."""

    def ball(self, bits: int) -> Ball:
        low, high = (Rational(x.numerator, x.denominator) for x in self.height.bounds(bits))
        upper = self.at(high)
        lower = upper if low == high else self.behind(low)
        with flint.ctx.workprec(bits):
            if lower is None or upper is None:
                return arb("nan")
            return lower.ball(bits).union(upper.ball(bits))


def settled(x: RealNumber) -> RealNumber:
    """A number whose enclosures become narrow; UndecidedError where they do not."""
    if at_rising_precision(lambda bits: x.ball(bits).rel_accuracy_bits() > 50 or None, 64, _SURE) is None:
        raise UndecidedError("whether two peaks of the ratios are equally high")
    return x


def above(a: RealNumber, b: RealNumber, most: int = _SURE) -> bool:
    """Whether a > b; UndecidedError where they are not told apart with ``most`` bits, unless both are known exactly."""

    if a is b or a == b:
        return False

    def sign(bits: int) -> bool | None:
        with flint.ctx.workprec(bits):
            left, right = a.ball(bits), b.ball(bits)
            if left.is_exact() and right.is_exact() and left == right:
                return False
            return True if left > right else False if left < right else None

    found = at_rising_precision(sign, 64, max(most, _SURE))
    if found is None:
        raise UndecidedError("which of two numbers is the larger")
    return found


@dataclass(frozen=True)
class Jump:
    """No threshold of the range gives a bandwidth from ``low`` to below ``high``, rad/s.

    ``threshold`` : the one that gives ``high``; None where several numbers have ranges apart. ``includes_low`` : whether ``low``
    itself is given: where a limit changes at once, the bandwidth stands there for a while.
    """

    low: RealNumber
    high: RealNumber
    threshold: RealNumber | None = None
    includes_low: bool = False

    def row(self, digits: int) -> dict[str, Any]:
        """As a document has it."""
        ends = {"from": self.low, "to": self.high, "threshold": self.threshold}
        found: dict[str, Any] = {name: _number(x, digits) for name, x in ends.items()}
        return found | ({"from_reached": True} if self.includes_low else {})


@dataclass(frozen=True)
class Bandwidths:
    """All bandwidths for thresholds of a range: from ``least`` to ``most``, both reached, less the ``jumps``.

    None where no threshold of the range gives a bandwidth, and, of ``least``, where none is known to be the least. ``blocked`` :
    by part, by the number of a region, or "jnd" for both parts, the least that gives one; empty where all do.
    ``undecided`` : what stayed open; there may then be further jumps, and blocked thresholds. ``ends_alone`` : whether only
    the least and the most are told, and not what lies between.
    """

    least: RealNumber | None
    most: RealNumber | None
    jumps: tuple[Jump, ...] = ()
    blocked: Mapping[str, RealNumber] = field(default_factory=dict)
    undecided: str = ""
    ends_alone: bool = False
    one: bool = False
    """Whether they are those of one number for both parts, or of a scale."""

    @property
    def certified(self) -> bool:
        """Whether nothing stayed open."""
        return not self.undecided

    @property
    def is_one_curve(self) -> bool:
        """Whether they can be drawn over one threshold."""
        return self.one and self.certified and self.least is not None and self.most is not None

    def row(self, digits: int) -> dict[str, Any]:
        """As a document has it."""
        jumps = [x.row(digits) for x in self.jumps]
        blocked = {name: _number(x, digits) for name, x in self.blocked.items()}
        ends = {"least": _number(self.least, digits), "most": _number(self.most, digits)}
        open_: dict[str, Any] = {"undecided": self.undecided} if self.undecided else {}
        open_ |= {"ends_alone": True} if self.ends_alone else {}
        return ends | {"jumps": jumps, "none_below": blocked, "certified": self.certified} | open_


def _number(x: RealNumber | None, digits: int) -> dict[str, Any] | None:
    if x is None:
        return None
    return {"value": float(x), "digits": x.digits(digits), "enclosure": list(x.enclosure(digits))}


@dataclass(frozen=True)
class Climb:
    """Thresholds that grow together from the one end of a range to the other."""

    squares: Mapping[Criterion, RealFunction]
    range: ExactRange
    band: tuple[Expr, Expr]
    name: str

    @property
    def found(self) -> Bandwidths:
        """The bandwidths on the way."""
        low, high = self.range
        most, least = self.at(high), self.at(low)
        if most is None or (least is not None and low == high):
            return Bandwidths(least, most)
        if least is not None:
            return Bandwidths(least, most, tuple(self._jumps(least, most)))
        first = self._from_the_start()
        return Bandwidths(first, most, tuple(self._jumps(first, most)), {self.name: SquareRoot(self._start)})

    def _levels(self, c: Expr) -> dict[Key, RealFunction | Level]:
        return {x: replace(x, threshold=c).exceeded(square) for x, square in self.squares.items()}

    def chart(self, c: Expr) -> Chart:
        """Where each ratio is above c."""
        table = chart(self._levels(c), *self.band)
        if table.undecided:
            raise UndecidedError("whether a ratio touches a threshold of the range")
        return table

    def at(self, c: Expr) -> RealNumber | None:
        """The bandwidth for one threshold."""
        table = self.chart(c)
        first = next(iter(kept(table)), None)
        return first.high.omega if first and first.low is table.points[0] else None

    @cached_property
    def _rates(self) -> dict[Key, RealFunction | Level]:
        return {_slope(x): square.derivative() for x, square in self.squares.items()}

    @cached_property
    def _slopes(self) -> Chart:
        return chart(self._rates, *self.band)

    @cached_property
    def _start(self) -> RealNumber:
        """The largest r^2 at the low end of the band."""
        omega = self._slopes.points[0].omega
        return Largest(tuple(ValueAt(square, omega) for square in self.squares.values()))

    def _from_the_start(self) -> RealNumber:
        """The bandwidth for the least threshold that has one, which is the ratio at the low end of the band."""
        values = [_rational_value(square, self.band[0]) for square in self.squares.values()]
        known = [x for x in values if x is not None]
        found = self.at(sqrt(max(known))) if len(known) == len(values) else None
        if found is not None:
            return found
        point = self._slopes.points[0]
        rising = [x for x in self.squares if point.after[_slope(x)] > 0]
        if any(self._is_highest(x, point.omega) for x in rising):
            return point.omega
        return settled(_LandingOfAll(SquareRoot(self._start), self, point.omega))

    def _is_highest(self, x: Criterion, omega: RealNumber) -> bool:
        own = ValueAt(self.squares[x], omega)
        return all(y is x or not above(ValueAt(square, omega), own) for y, square in self.squares.items())

    def _jumps(self, least: RealNumber, most: RealNumber) -> Iterable[Jump]:
        """At each peak between that is higher than all before it, from the peak to where the ratio is as high again."""
        if self._slopes.undecided:
            raise UndecidedError("whether a ratio has a peak where its slope nearly vanishes")
        top: Peak | None = None
        end = least
        for peak in self._peaks(least, most):
            if not above(peak.omega, end):
                continue
            landing = self._landing(peak, top)
            if landing is not None:
                yield Jump(peak.omega, landing, peak.ratio)
                top, end = peak, landing

    def _peaks(self, least: RealNumber, most: RealNumber) -> list[Peak]:
        return [
            Peak(x, point.omega, square)
            for point in self._slopes.points[1:-1]
            for x, square in self.squares.items()
            if _is_top(point, x) and above(point.omega, least) and above(most, point.omega)
        ]

    def _landing(self, peak: Peak, top: Peak | None) -> RealNumber | None:
        """The bandwidth where the threshold is as high as a peak; None if another ratio, or an earlier peak, is higher there.

        By rational thresholds close to the peak; where that does not tell two heights apart, by its exact one.
        """
        others = [ValueAt(square, peak.omega) for x, square in self.squares.items() if x is not peak.criterion]
        others += [] if top is None else [ValueAt(top.square, top.omega)]
        own = ValueAt(peak.square, peak.omega)
        try:
            if not all(above(own, x) for x in others):
                return None
            return settled(_LandingOfAll(peak.ratio, self, peak.omega))
        except UndecidedError:
            return self._exact_landing(peak)

    def _exact_landing(self, peak: Peak) -> RealNumber | None:
        if peak.threshold is None:
            raise UndecidedError("whether two peaks of the ratios are equally high")
        table = chart(self._levels(peak.threshold) | self._rates, *self.band)
        # from the low end of the band on, as what is asked about is higher than all before the bandwidth
        first = table.where(lambda signs: all(signs[x] <= 0 for x in self.squares))[0]
        place = next(i for i, point in enumerate(table.points) if point is first.high)
        ahead = [point for point in table.points[place:-1] if _is_top(point, peak.criterion)]
        own = [
            point
            for point in self._slopes.points[1:-1]
            if _is_top(point, peak.criterion) and not above(peak.omega, point.omega)
        ]
        return first.high.omega if len(ahead) < len(own) else None


def _slope(x: Criterion) -> Key:
    return x, "slope"


def _is_top(point: Point, x: Criterion) -> bool:
    """Whether a ratio has a local maximum at a point of a chart of slopes; not where it has a pole."""
    key = _slope(x)
    return (point.before[key], point.after[key]) == (1, -1) and point.orders.get(key, 0) > 0


def _rational_value(f: RealFunction, at: Expr) -> Expr | None:
    """The value of a function with rational numbers at a rational frequency; None for any other, and at a pole."""
    axis, function = f.axis, f.function
    if f.is_zero:
        return Integer(0)
    if not isinstance(at, Rational):
        return None
    rows = [axis.univariate(p) for p in (function.numerator, function.denominator)]
    top, bottom = (None if row is None else fmpq_poly(row)(fmpq(int(at.p), int(at.q))) for row in rows)
    return None if top is None or not bottom else Rational(int((top / bottom).p), int((top / bottom).q))


@dataclass(frozen=True, repr=False)
class _LandingOfAll(Landing):
    """That of one threshold for all criteria, beside a peak at ``omega``."""

    climb: Climb
    omega: RealNumber

    def at(self, height: Expr) -> RealNumber | None:
        return self.climb.at(height)

    def behind(self, height: Rational) -> RealNumber | None:
        """Where a ratio is above it again, after it has come back below it behind the peak."""
        most = 4 * int(height.q).bit_length()  # the nearer the height is to the peak's, the nearer the frequencies are
        return next(
            (x.high.omega for x in kept(self.climb.chart(height)) if above(x.low.omega, self.omega, most)), None
        )


def bandwidth_of(lattice: Lattice, band: tuple[Expr, Expr]) -> RealNumber | None:
    """Up to where, from the low end of a band, a function of a lattice is nowhere positive."""
    first = next(iter(_kept(lattice, band)), None)
    return first[1].high.omega if first and first[1].low is first[0] else None


def _kept(lattice: Lattice, band: tuple[Expr, Expr]) -> list[tuple[Point, Interval]]:
    """Where it is not, each with the first point of the band."""
    table = chart({JOINT: lattice}, *band)
    if table.undecided:
        raise UndecidedError("whether a ratio touches a limit of the range")
    return [(table.points[0], x) for x in table.where(lambda signs: signs[JOINT] <= 0)]


@dataclass(frozen=True)
class Growth:
    """Terms whose squares are those of a number relative to ``nominal``; ``range`` : that number's, relative as well.

    ``criterion`` : any that they are of. ``name`` : of the number.
    """

    terms: tuple[Term, ...]
    range: ExactRange
    band: tuple[Expr, Expr]
    criterion: Criterion
    name: str
    nominal: Expr

    @property
    def found(self) -> Bandwidths:
        """All bandwidths of the range."""
        least, most = (self.at(x) for x in self.range)
        if most is None:
            return Bandwidths(None, None)
        if least is not None:
            return Bandwidths(least, most, tuple(self._jumps(least, most)))
        start = self._start
        first = self._first
        return Bandwidths(first, most, tuple(self._jumps(first, most)), {self.name: self._told(start)})

    def kept(self, x: Expr) -> list[tuple[Point, Interval]]:
        """Where nothing is noticed if the number is that many times the nominal one."""
        return _kept(self._noticed(x), self.band)

    def at(self, x: Expr) -> RealNumber | None:
        """The bandwidth then."""
        return bandwidth_of(self._noticed(x), self.band)

    def _noticed(self, x: Expr) -> Lattice:
        return Lattice(tuple((*t.where, *(level(square, x**2) for square in t.squares)) for t in self.terms))

    @cached_property
    def _envelope(self) -> Envelope:
        return Envelope(self.criterion, self.terms)

    @cached_property
    def _table(self) -> Chart:
        return chart(self._envelope.functions(), *self.band)

    @cached_property
    def _start(self) -> RealNumber:
        """The least multiple of the nominal value for which there is a bandwidth: what the low end of the band needs."""
        omega, signs = self._table.points[0].omega, self._table.points[0].at
        needed: dict[int, list[RealNumber]] = {1: [], 0: [], -1: []}
        for i, term in enumerate(self.terms):
            needed[self._envelope.holds(i, signs)].append(_least([ValueAt(x, omega) for x in term.squares]))
        found = Largest(tuple(needed[1]))
        if not needed[1] or any(above(x, found) for x in needed[0]):
            raise UndecidedError("which limit holds at the low end of the band")
        found.tight_ball(64)
        return SquareRoot(found)

    @property
    def _first(self) -> RealNumber:
        """The bandwidth for that."""
        first, (square, slope) = self._table.points[0], self._envelope.counting(self._table.points[0].after)
        if slope > 0:
            return first.omega
        return settled(self._landing(self._start if slope else _height(square, first.omega)))

    def _jumps(self, least: RealNumber, most: RealNumber) -> Iterator[Jump]:
        """At each peak, or begin of a plateau, of what is judged, that is higher than all before it."""
        if self._table.undecided:
            raise UndecidedError("whether a ratio has a peak where its slope nearly vanishes")
        top: RealNumber | None = None
        for omega, peak in self._peaks(least, most):
            height = _height(peak.square, omega)
            if top is None or above(height, top):
                top = height
                yield Jump(omega, settled(self._landing(height)), self._told(height), includes_low=peak.after)

    def _peaks(self, least: RealNumber, most: RealNumber) -> Iterator[tuple[RealNumber, Maximum]]:
        for point in self._table.points[1:-1]:
            peak = self._envelope.top(point) or self._envelope.plateau(point)
            begins = peak and (self._is_passed(point, peak) if peak.after else above(point.omega, least))
            if peak and begins and above(most, point.omega):
                yield point.omega, peak

    def _is_passed(self, point: Point, peak: Maximum) -> bool:
        """Whether a height that is only reached behind a step lies in the range; the bandwidth may stand at the step itself."""
        low, high = (ExactNumber(x) for x in self.range)
        height = _height(peak.square, point.omega)
        return above(height, low) and not above(height, high)

    def _landing(self, height: RealNumber) -> RealNumber:
        found = self.at(height.value) if isinstance(height, ExactNumber) else None
        return _LandingOfOne(height, self) if found is None else found

    def _told(self, height: RealNumber) -> RealNumber:
        return Times(height, self.nominal)


def _least(numbers: Iterable[RealNumber]) -> RealNumber:
    return Negative(Largest(tuple(Negative(x) for x in numbers)))


def _height(square: RealFunction, omega: RealNumber) -> RealNumber:
    """The root of a square at a frequency; in closed form where it is the same at all frequencies."""
    value = None if square.function.numerator.degrees()[0] else square.expression()
    return SquareRoot(ValueAt(square, omega)) if value is None or value.free_symbols else ExactNumber(sqrt(value))


@dataclass(frozen=True, repr=False)
class _LandingOfOne(Landing):
    """That of a multiple of a number."""

    growth: Growth

    def at(self, height: Expr) -> RealNumber | None:
        return self.growth.at(height)

    def behind(self, height: Rational) -> RealNumber | None:
        """Where more is needed than that again; for numbers close to the height it was too little around the frequency alone."""
        found = self.growth.kept(height)
        later = [y for first, y in found if y.low is not first and y.low is not y.high]
        return later[0].high.omega if later else None


@dataclass(frozen=True, repr=False)
class Times(RealNumber):
    """A number that many times."""

    number: RealNumber
    times: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.number.ball(bits) * expression_ball(self.times)


def bandwidths(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> Bandwidths | None:
    """The bandwidths for all thresholds of a range; None where the threshold is no range.

    Thresholds of both parts that are alike are one number, as everywhere; else each takes all values of its range. The ends are
    exact in any case. Undecided may stay whether two peaks are equally high, and whether a ratio touches an end of the range.
    """
    if not threshold.ranges:
        return None
    least: RealNumber | None = None
    most: RealNumber | None = None
    try:
        least, most = (_at(d, threshold.at_end(i), band) for i in (0, 1))
        if threshold.is_box:
            ranges = {part: threshold.interval(part) or (threshold[part], threshold[part]) for part in Part}
            found = _inside(_squares(d, threshold), ranges, band)
        else:
            found = _grown(d, threshold, band, Bandwidths(least, most, ends_alone=True))
        return replace(found, least=least or found.least, most=most)
    except LimitError:
        raise
    except UndecidedError as error:
        return Bandwidths(least, most, undecided=str(error))


def _at(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> RealNumber | None:
    """The bandwidth for one threshold."""
    table = chart({x: x.function(d) for x in noticed(threshold)}, *band)
    if table.undecided:
        raise UndecidedError("whether a ratio touches an end of the range of thresholds")
    first = next(iter(kept(table)), None)
    return first.high.omega if first and first.low is table.points[0] else None


def _squares(d: Distortion, threshold: Threshold) -> dict[Criterion, RealFunction]:
    """What must not exceed the square of a threshold; of a region, how many times one of half widths 1 must be enlarged."""
    criteria = noticed(threshold)
    if not any(x.joint for x in criteria):
        return {x: x.measure(d) for x in criteria}
    [x] = criteria
    assert x.joint
    squares = x.joint.opened(dict.fromkeys(Part, S.One)).squares(d)
    return {replace(x, name=f"{x.name} {i}", region=None): square for i, square in enumerate(squares)}


def _inside(
    squares: Mapping[Criterion, RealFunction], ranges: Mapping[Part, ExactRange], band: tuple[Expr, Expr]
) -> Bandwidths:
    if ranges[Part.REAL] == ranges[Part.IMAG]:
        return replace(Climb(squares, ranges[Part.REAL], band, "jnd").found, one=True)
    each = [Climb({x: square}, ranges[x.part], band, x.name).found for x, square in squares.items() if x.part]
    return reduce(_lower, each)


def _grown(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr], ends: Bandwidths) -> Bandwidths:
    """Those of a region that grows with several numbers: all of them where no way to be outside depends on two, else the ends."""
    groups = split(d, threshold)
    if groups is None or ends.most is None:
        return ends
    ranges, criterion = moved(threshold), noticed(threshold)[0]
    each = []
    for group, terms in groups.items():
        if group:
            name = min(group) if len(group) == 1 else "jnd"
            each.append(Growth(terms, ranges[group], band, criterion, name, nominal_of(threshold, min(group))).found)
        else:
            width = bandwidth_of(Lattice(tuple(x.where for x in terms)), band)
            each.append(Bandwidths(width, width))
    return replace(reduce(_lower, each), one=groups.keys() == {SCALE})


def _lower(a: Bandwidths, b: Bandwidths) -> Bandwidths:
    """All smaller ones of two bandwidths, each of a set of its own."""
    if a.most is None or b.most is None or a.least is None or b.least is None:
        return Bandwidths(None, None)
    least, most = _least_in_bandwidths(a.least, b.least), _least_in_bandwidths(a.most, b.most)
    pairs = product(_unreached(a, least), _unreached(b, least))
    jumps = [x for one, other in pairs if (x := _common(one, other, most)) is not None]
    return Bandwidths(least, most, tuple(jumps), {**a.blocked, **b.blocked})


def _unreached(x: Bandwidths, least: RealNumber) -> list[Jump]:
    """What a set leaves out between the least of both and its own most."""
    assert x.least is not None
    return [*([] if x.least is least else [Jump(least, x.least)]), *x.jumps]


def _common(a: Jump, b: Jump, most: RealNumber) -> Jump | None:
    low = b.low if a.low is not b.low and above(b.low, a.low) else a.low
    high = _least_in_bandwidths(_least_in_bandwidths(a.high, b.high), most)
    reached = any(x.includes_low for x in (a, b) if low is x.low)  # by one set: then by the smaller of both
    return Jump(low, high, includes_low=reached) if low is not high and above(high, low) else None


def _least_in_bandwidths(a: RealNumber, b: RealNumber) -> RealNumber:
    return a if a is b or above(b, a) else b
