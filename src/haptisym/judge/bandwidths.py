"""All bandwidths of a display for the thresholds of a range: how far it is transparent as the JND
grows; exact.

A region R(t) that grows with a number t (one threshold for both parts, one limit, a floor, a scale)
gives a bandwidth w(t) that grows with it. Let T(omega) be the least t for which nothing is noticed
at omega: the largest, over the ways to notice that hold there, of the least of what each needs
(``haptisym.judge.peaks.Envelope``). Then w(t) = inf {omega : T(omega) > t}, the generalised inverse
of the running maximum of T: nothing is sampled. Values of w are left out at exactly those local
maxima of T (also one-sided ones, where another limit takes over, and begins of plateaus) that are
higher than all before them, up to where T is above them again. What does not grow with t ends the
bandwidth where it alone is noticed.

Where T is as high again is enclosed by the bandwidths for rational numbers beside a height
(``Landing``), which needs no closed form. Whether two peaks are of the same height is undecided by
this. With several numbers that have ranges of their own, only the smallest and the largest
bandwidth are given: those of the smallest and of the largest region.

Begin with ``bandwidths``; ``Growth.between`` is the general case.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import flint
from flint import arb
from sympy import Expr, Rational, sqrt

from haptisym.judge.crossings import JOINT, kept, level, noticed
from haptisym.judge.peaks import Envelope, EnvelopeMaximum, LargestOf, ValueAt
from haptisym.judge.regions import Sided, WayOutside, above_one
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import (
    Ball,
    ExactNumber,
    Negative,
    RealNumber,
    SquareRoot,
    at_rising_precision,
    expression_ball,
    rational,
)
from haptisym.kernel.roots import Chart, Interval, Lattice, Point, chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import ExactRange

_SURE = 400
"""Bits up to which two numbers are compared before it is undecided which is larger."""


@dataclass(frozen=True)
class Jump:
    """A gap: no threshold of the range gives a bandwidth from ``low`` to below ``high``, rad/s.

    ``threshold`` : the one that gives ``high``. ``includes_low`` : whether ``low`` itself is a
    bandwidth: where the limit that holds changes, one frequency is it for several thresholds.
    """

    low: RealNumber
    high: RealNumber
    threshold: RealNumber
    includes_low: bool = False

    def row(self, digits: int) -> dict[str, Any]:
        """The gap as a row of a document."""
        numbers = {"from": self.low, "to": self.high, "threshold": self.threshold}
        keys: dict[str, Any] = {name: _number(x, digits) for name, x in numbers.items()}
        return keys | ({"from_reached": True} if self.includes_low else {})


@dataclass(frozen=True)
class Bandwidths:
    """All bandwidths for thresholds of a range: from ``least`` to ``most``, both reached, less the
    ``jumps``.

    Both are None where no threshold of the range gives a bandwidth; ``least`` also where none is
    known to be the least.
    ``blocked`` : where small thresholds give no bandwidth, the least that gives one, by the name of
    the number that varies ("jnd" for both parts); empty where all thresholds give one.
    ``undecided`` : a description of what is undecided; there may then be further jumps, and blocked
    thresholds; empty where all is proven. ``ends_alone`` : whether only the least and the most are
    known, and not what lies between. ``one`` : whether one number for both parts varies, or a
    scale.
    """

    least: RealNumber | None
    most: RealNumber | None
    jumps: tuple[Jump, ...] = ()
    blocked: Mapping[str, RealNumber] = field(default_factory=dict)
    undecided: str = ""
    ends_alone: bool = False
    one: bool = False

    @property
    def certified(self) -> bool:
        """Whether nothing is undecided."""
        return not self.undecided

    @property
    def is_one_curve(self) -> bool:
        """Whether they can be drawn over one threshold."""
        return self.one and self.certified and self.least is not None and self.most is not None

    def row(self, digits: int) -> dict[str, Any]:
        """The bandwidths as a part of a document."""
        keys: dict[str, Any] = {
            "least": _number(self.least, digits),
            "most": _number(self.most, digits),
            "jumps": [x.row(digits) for x in self.jumps],
            "none_below": {name: _number(x, digits) for name, x in self.blocked.items()},
            "certified": self.certified,
        }
        # These keys are present only where they say something.
        if self.undecided:
            keys["undecided"] = self.undecided
        if self.ends_alone:
            keys["ends_alone"] = True
        return keys


def _number(x: RealNumber | None, digits: int) -> dict[str, Any] | None:
    if x is None:
        return None
    return {"value": float(x), "digits": x.digits(digits), "enclosure": list(x.enclosure(digits))}


def bandwidths(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> Bandwidths | None:
    """The bandwidths for all thresholds of a range; None where the threshold has no range.

    Equal thresholds of both parts with equal ranges are one number. With several numbers that have
    ranges only the two ends are given, exact in any case. What may be undecided: whether two peaks
    are equally high, and whether a ratio is tangent to an end of the range.
    """
    if not threshold.ranges:
        return None
    # A bandwidth grows with its region, so the ends of the range give the least and the greatest.
    least: RealNumber | None = None
    most: RealNumber | None = None
    try:
        least, most = (_at(d, threshold.at_end(i), band) for i in (0, 1))
        moving = _moving(d, threshold)
        if most is None or moving is None:
            return Bandwidths(least, most, ends_alone=moving is None)
        return Growth(*moving, band).between(least, most)
    except LimitError:
        raise
    except UndecidedError as error:
        return Bandwidths(least, most, undecided=str(error))


def _at(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> RealNumber | None:
    """The bandwidth for one threshold."""
    # A tangency that is undecided may cut the band in two: then the bandwidth is, too.
    table = chart({x: x.function(d) for x in noticed(threshold)}, *band)
    if table.undecided:
        raise UndecidedError("whether a ratio is tangent to an end of the range of thresholds")
    return table.reach(kept(table))


class _Moving(NamedTuple):
    """The one number of a JND that has a range: the terms that grow with it, those that do not, and
    its range relative to the nominal value."""

    name: str
    terms: tuple[WayOutside, ...]
    fixed: tuple[WayOutside, ...]
    range: ExactRange
    nominal: Expr


def _moving(d: Distortion, threshold: Threshold) -> _Moving | None:
    """The number that varies; None where several numbers have ranges of their own, or where one of
    a joint region does not enlarge it as a whole."""
    ranges, region = threshold.ranges, threshold.region
    alike = threshold.real == threshold.imag and region.lower == (None, None)
    both = alike and len(set(ranges.values())) == 1 and ranges.keys() == {"real", "imag"}
    name = "jnd" if both else next(iter(ranges))
    if len(ranges) > 1 and not both:
        return None
    # The value that its range is relative to: squares are those of the nominal region.
    named = {
        "scale": region.size,
        "jnd": threshold.real,
        "real": threshold.real,
        "imag": threshold.imag,
        "floor": region.floor,
    }
    nominal = (named | dict(zip(("real.lower", "imag.lower"), region.lower, strict=True)))[name]
    assert nominal is not None
    low, high = next(iter(ranges.values()))
    relative = low / nominal, high / nominal
    if region.shape is not Shape.SQUARE:
        terms = tuple(term for x in noticed(threshold) if x.region for term in x.region.terms(d))
        return _Moving(name, terms, (), relative, nominal) if name in ("scale", "jnd") else None
    # Where both ways of a part have the same limit, ``Sided`` makes one term of them: of two equal
    # numbers of which one varies it has no term for each.
    for part in Part:
        lower = threshold.lower(part)
        if lower is not None and lower == threshold[part] and name.startswith(part.value):
            return None
    every_name = {"real", "imag", "real.lower", "imag.lower", "floor"}
    moved = every_name if name == "scale" else set(ranges)
    terms_by_part = [_split(*x, moved) for part in Part for x in _limits(d, threshold, part)]
    growing = tuple(x for x in terms_by_part if x.squares)
    fixed = tuple(x for x in terms_by_part if not x.squares)
    return _Moving(name, growing, fixed, relative, nominal)


def _limits(
    d: Distortion, threshold: Threshold, part: Part
) -> Iterator[tuple[WayOutside, tuple[str, ...]]]:
    """The ways to notice one part, with the names of the limits of their squares."""
    higher, lower, floor = threshold[part], threshold.lower(part), threshold.region.floor
    sided = Sided(part, higher, higher if lower is None else lower, floor)
    names: list[tuple[str, ...]] = [(part.value,)]
    if sided.has_sides:
        names += [(f"{part.value}.lower",), (part.value, f"{part.value}.lower")]
    floor_name = () if floor is None else ("floor",)
    for term, term_names in zip(sided.terms(d), names, strict=True):
        # With a condition that is 0 throughout the term holds nowhere: the part is as large as it
        # was at all frequencies, and neither higher nor lower.
        if not any(f.is_zero for f in term.where):
            yield term, (*term_names, *floor_name)


def _split(term: WayOutside, names: tuple[str, ...], moved: set[str]) -> WayOutside:
    """A term in which only the squares of limits that move remain squares; those of fixed limits
    become conditions, that they are above 1."""
    named = list(zip(term.squares, names, strict=True))
    squares = tuple(square for square, name in named if name in moved)
    fixed = (above_one(square) for square, name in named if name not in moved)
    return WayOutside((*term.where, *fixed), squares)


@dataclass(frozen=True)
class Growth:
    """A region that grows with one number, and the bandwidth as a function of it.

    ``terms`` : what is noticed where, with squares relative to the ``nominal`` value of the number;
    ``fixed`` : terms that do not depend on it, without squares. ``range`` : of the number, relative
    to ``nominal``. ``name`` : of the number. ``band`` : rad/s.
    """

    name: str
    terms: tuple[WayOutside, ...]
    fixed: tuple[WayOutside, ...]
    range: ExactRange
    nominal: Expr
    band: tuple[Expr, Expr]

    def between(self, least: RealNumber | None, most: RealNumber) -> Bandwidths:
        """All bandwidths of the range, from those at its two ends."""
        # Without a bandwidth at the low end, the range begins to have one where the low end of the
        # band is just not noticed.
        blocked = {} if least is not None else {self.name: Times(self._start, self.nominal)}
        first = self._first if least is None else least
        low, high = self.range
        jumps = () if low == high else tuple(self._jumps(first, most))
        return Bandwidths(first, most, jumps, blocked, one=self.name in ("jnd", "scale"))

    def kept(self, x: Expr) -> list[tuple[Point, Interval]]:
        """The intervals on which nothing is noticed if the number is ``x`` times the nominal one,
        each after the first point of the band."""
        # Enlarged x times the region is left where a square exceeds x^2.
        moved = ((*t.where, *(level(square, x**2) for square in t.squares)) for t in self.terms)
        table = chart({JOINT: Lattice((*moved, *(t.where for t in self.fixed)))}, *self.band)
        if table.undecided:
            raise UndecidedError("whether a ratio is tangent to a limit of the range")
        return [(table.points[0], y) for y in table.where(lambda signs: signs[JOINT] <= 0)]

    def at(self, x: Expr) -> RealNumber | None:
        """The bandwidth if the number is ``x`` times the nominal one; None where there is none."""
        first = next(iter(self.kept(x)), None)
        return first[1].high.omega if first and first[1].low is first[0] else None

    @cached_property
    def _envelope(self) -> Envelope:
        return Envelope(self.name, self.terms)

    @cached_property
    def _table(self) -> Chart:
        return chart(self._envelope.functions(), *self.band)

    @cached_property
    def _start(self) -> RealNumber:
        """The least multiple of the nominal value for which there is a bandwidth: what the low end
        of the band needs."""
        omega, signs = self._table.points[0].omega, self._table.points[0].at
        # By whether a term holds there: 1, or -1, or 0 where one of its conditions vanishes.
        needed: dict[int, list[RealNumber]] = {1: [], 0: [], -1: []}
        for i, term in enumerate(self.terms):
            # The least of the squares, as minus the largest of their negatives.
            negatives = tuple(Negative(ValueAt(x, omega)) for x in term.squares)
            needed[self._envelope.condition_sign(i, signs)].append(Negative(LargestOf(negatives)))
        square = LargestOf(tuple(needed[1]))
        # A term that is just about to hold does not matter where another asks for as much.
        if not needed[1] or any(above(x, square) for x in needed[0]):
            raise UndecidedError("which limit holds at the low end of the band")
        # Raises here, not in a page that prints it, if it cannot be enclosed.
        square.tight_ball(64)
        return SquareRoot(square)

    @property
    def _first(self) -> RealNumber:
        """The bandwidth for the least number that gives one."""
        first = self._table.points[0]
        square, slope = self._envelope.active(first.after)
        # Where more is needed right behind the low end, the band ends there; otherwise where as
        # much is needed again.
        if slope > 0:
            return first.omega
        return self._landing(self._start if slope else _height(square, first.omega))

    def _jumps(self, least: RealNumber, most: RealNumber) -> Iterator[Jump]:
        """One gap at each peak, or begin of a plateau, of the envelope that is higher than all
        before it."""
        if self._table.undecided:
            raise UndecidedError("whether a ratio has a peak where its slope nearly vanishes")
        top: RealNumber | None = None
        for omega, peak in self._peaks(least, most):
            height = _height(peak.square, omega)
            if top is None or above(height, top):
                top = height
                yield Jump(
                    omega,
                    self._landing(height),
                    Times(height, self.nominal),
                    includes_low=peak.after,
                )

    def _peaks(
        self, least: RealNumber, most: RealNumber
    ) -> Iterator[tuple[RealNumber, EnvelopeMaximum]]:
        """The peaks, and begins of plateaus, between the bandwidths at the ends of the range."""
        for point in self._table.points[1:-1]:
            peak = self._envelope.local_maximum(point) or self._envelope.plateau(point)
            if not peak:
                continue
            begins = self._is_passed(point, peak) if peak.after else above(point.omega, least)
            if begins and above(most, point.omega):
                yield point.omega, peak

    def _is_passed(self, point: Point, peak: EnvelopeMaximum) -> bool:
        """Whether a height that is reached only behind a step of the envelope lies in the range;
        the frequency of the step may itself be the least bandwidth."""
        low, high = (ExactNumber(x) for x in self.range)
        height = _height(peak.square, point.omega)
        return above(height, low) and not above(height, high)

    def _landing(self, height: RealNumber) -> RealNumber:
        """The bandwidth for a height; UndecidedError where its enclosures do not become narrow."""
        exact = self.at(height.value) if isinstance(height, ExactNumber) else None
        bandwidth = Landing(height, self) if exact is None else exact

        def is_narrow(bits: int) -> bool | None:
            return bool(bandwidth.ball(bits).rel_accuracy_bits() > 50) or None

        # With two peaks of one height, numbers just below it give a bandwidth before the second
        # peak, those just above it one behind it: the enclosure never gets narrow.
        if at_rising_precision(is_narrow, 64, _SURE) is None:
            raise UndecidedError("whether two peaks of the ratios are equally high")
        return bandwidth


def _height(square: RealFunction, omega: RealNumber) -> RealNumber:
    """The root of a square at a frequency; in closed form where it is the same at all
    frequencies."""
    value = None if square.function.numerator.degrees()[0] else square.expression()
    if value is None or value.free_symbols:
        return SquareRoot(ValueAt(square, omega))
    return ExactNumber(sqrt(value))


@dataclass(frozen=True, repr=False)
class Landing(RealNumber):
    """The bandwidth for the height of a peak, or of the band's low end: enclosed by those for
    rational heights beside it."""

    height: RealNumber
    growth: Growth

    def ball(self, bits: int) -> Ball:
        # The bandwidth grows with the number, so it lies between those for rational bounds of the
        # height: exact charts, for each precision two.
        low, high = (rational(x) for x in self.height.bounds(bits))
        upper = self.growth.at(high)
        lower = upper if low == high else self._behind(low)
        with flint.ctx.workprec(bits):
            if lower is None or upper is None:
                return arb("nan")
            return lower.ball(bits).union(upper.ball(bits))

    def _behind(self, height: Rational) -> RealNumber | None:
        """The end of the first interval behind the peak on which this height is enough; None if
        there is none. A number a little below the height is too small around the peak alone."""
        later = [
            y for first, y in self.growth.kept(height) if y.low is not first and y.low is not y.high
        ]
        return later[0].high.omega if later else None


@dataclass(frozen=True, repr=False)
class Times(RealNumber):
    """The product of a real number and an exact one."""

    number: RealNumber
    times: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.number.ball(bits) * expression_ball(self.times)


def above(a: RealNumber, b: RealNumber) -> bool:
    """Whether a > b; UndecidedError where enclosures do not separate them, unless both are known
    exactly."""
    if a is b or a == b:
        return False

    def sign(bits: int) -> bool | None:
        with flint.ctx.workprec(bits):
            left, right = a.ball(bits), b.ball(bits)
            if left.is_exact() and right.is_exact() and left == right:
                return False
            return True if left > right else False if left < right else None

    is_above = at_rising_precision(sign, 64, _SURE)
    if is_above is None:
        raise UndecidedError("which of two numbers is the larger")
    return is_above
