"""From thresholds to bandwidths: how far a display is transparent as the JND grows, over all values
of a range; exact.

A region R(t) that grows with a number t (one threshold for both parts, one limit, a floor, a scale)
gives a bandwidth w(t) that grows with it. Let T(omega) be the least t for which nothing is noticed
at omega: the largest, over the ways to notice that hold there, of the least of what each needs
(``haptisym.judge.peaks.Envelope``). Then w(t) = inf {omega : T(omega) > t}, the generalised inverse
of the running maximum of T: nothing is sampled. Values of w are left out at exactly those local
maxima of T (also one-sided ones, where another limit takes over, and begins of plateaus) that are
higher than all before them, up to where T is above them again. What does not grow with t ends the
bandwidth where it alone is noticed.

Where T is as high again is enclosed by the bandwidths for rational numbers beside a height
(``Landing``), which needs no closed form. Peaks of the same height are not told apart so:
undecided. Of several numbers with ranges of their own the least and the most alone are told: the
bandwidths of the smallest and of the largest region.
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
from haptisym.judge.peaks import Envelope, Largest, Maximum, ValueAt
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
)
from haptisym.kernel.roots import Chart, Interval, Lattice, Point, chart
from haptisym.model.distortion import Distortion
from haptisym.model.jnd import Part, Shape, Threshold
from haptisym.model.parameters import ExactRange

_SURE = 400
"""Bits up to which two numbers are told apart before they are taken for one."""


@dataclass(frozen=True)
class Jump:
    """No threshold of the range gives a bandwidth from ``low`` to below ``high``, rad/s.

    ``threshold`` : the one that gives ``high``. ``includes_low`` : whether ``low`` itself is given:
    where a limit changes at once, the bandwidth stands there for a while.
    """

    low: RealNumber
    high: RealNumber
    threshold: RealNumber
    includes_low: bool = False

    def row(self, digits: int) -> dict[str, Any]:
        """As a document has it."""
        ends = {"from": self.low, "to": self.high, "threshold": self.threshold}
        found: dict[str, Any] = {name: _number(x, digits) for name, x in ends.items()}
        return found | ({"from_reached": True} if self.includes_low else {})


@dataclass(frozen=True)
class Bandwidths:
    """All bandwidths for thresholds of a range: from ``least`` to ``most``, both reached, less the
    ``jumps``.

    None where no threshold of the range gives a bandwidth, and, of ``least``, where none is known
    to be the least. ``blocked`` :
    by part, by the number of a region, or "jnd" for both parts, the least that gives one; empty
    where all do.
    ``undecided`` : what stayed open; there may then be further jumps, and blocked thresholds.
    ``ends_alone`` : whether only the least and the most are told, and not what lies between.
    ``one`` : whether they are those of one number for both parts, or of a scale.
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


def bandwidths(d: Distortion, threshold: Threshold, band: tuple[Expr, Expr]) -> Bandwidths | None:
    """The bandwidths for all thresholds of a range; None where the threshold is no range.

    Thresholds of both parts that are alike are one number, as everywhere; of several numbers with
    ranges the ends alone are told, exact in any case. Undecided may stay whether two peaks are
    equally high, and whether a ratio touches an end of the range.
    """
    if not threshold.ranges:
        return None
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
    table = chart({x: x.function(d) for x in noticed(threshold)}, *band)
    if table.undecided:
        raise UndecidedError("whether a ratio is tangent to an end of the range of thresholds")
    first = next(iter(kept(table)), None)
    return first.high.omega if first and first.low is table.points[0] else None


class _Moving(NamedTuple):
    """The one number of a JND that has a range: what grows with it, what does not, and its values
    relative to the nominal one."""

    name: str
    terms: tuple[WayOutside, ...]
    fixed: tuple[WayOutside, ...]
    range: ExactRange
    nominal: Expr


def _moving(d: Distortion, threshold: Threshold) -> _Moving | None:
    """None where several numbers have ranges of their own, or one that does not enlarge a whole
    region of several parts."""
    ranges, region = threshold.ranges, threshold.region
    alike = threshold.real == threshold.imag and region.lower == (None, None)
    both = alike and len(set(ranges.values())) == 1 and ranges.keys() == {"real", "imag"}
    name = "jnd" if both else next(iter(ranges))
    if len(ranges) > 1 and not both:
        return None
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
        own = tuple(term for x in noticed(threshold) if x.region for term in x.region.terms(d))
        return _Moving(name, own, (), relative, nominal) if name in ("scale", "jnd") else None
    if any(
        x == threshold[part] and name.startswith(part.value)
        for part in Part
        if (x := threshold.lower(part)) is not None
    ):
        return None  # limits for each way that are the same number, of which one moves
    moved = (
        {"real", "imag", "real.lower", "imag.lower", "floor"} if name == "scale" else set(ranges)
    )
    listed = [_split(*x, moved) for part in Part for x in _limits(d, threshold, part)]
    return _Moving(
        name,
        tuple(x for x in listed if x.squares),
        tuple(x for x in listed if not x.squares),
        relative,
        nominal,
    )


def _limits(
    d: Distortion, threshold: Threshold, part: Part
) -> Iterator[tuple[WayOutside, tuple[str, ...]]]:
    """The ways to notice one part, with the names of the limits of their squares."""
    own, lower, floor = threshold[part], threshold.lower(part), threshold.region.floor
    sided = Sided(part, own, own if lower is None else lower, floor)
    names: list[tuple[str, ...]] = [(part.value,)]
    if sided.has_sides:
        names += [(f"{part.value}.lower",), (part.value, f"{part.value}.lower")]
    for term, own_names in zip(sided.terms(d), names, strict=True):
        if not any(
            f.is_zero for f in term.where
        ):  # it holds nowhere: the part is as large as it was, throughout
            yield term, (*own_names, *(() if floor is None else ("floor",)))


def _split(term: WayOutside, names: tuple[str, ...], moved: set[str]) -> WayOutside:
    """A term of which what does not move says where the rest counts."""
    squares = tuple(
        square for square, name in zip(term.squares, names, strict=True) if name in moved
    )
    fixed = (
        above_one(square)
        for square, name in zip(term.squares, names, strict=True)
        if name not in moved
    )
    return WayOutside((*term.where, *fixed), squares)


@dataclass(frozen=True)
class Growth:
    """Terms whose squares are those of a number relative to ``nominal``; ``range`` : that number's,
    relative as well.

    ``fixed`` : terms without squares. ``name`` : of the number.
    """

    name: str
    terms: tuple[WayOutside, ...]
    fixed: tuple[WayOutside, ...]
    range: ExactRange
    nominal: Expr
    band: tuple[Expr, Expr]

    def between(self, least: RealNumber | None, most: RealNumber) -> Bandwidths:
        """All bandwidths of the range, whose ends are known."""
        blocked = {} if least is not None else {self.name: Times(self._start, self.nominal)}
        first = self._first if least is None else least
        low, high = self.range
        jumps = () if low == high else tuple(self._jumps(first, most))
        return Bandwidths(first, most, jumps, blocked, one=self.name in ("jnd", "scale"))

    def kept(self, x: Expr) -> list[tuple[Point, Interval]]:
        """Where nothing is noticed if the number is that many times the nominal one, each with the
        first point of the band."""
        moved = ((*t.where, *(level(square, x**2) for square in t.squares)) for t in self.terms)
        table = chart({JOINT: Lattice((*moved, *(t.where for t in self.fixed)))}, *self.band)
        if table.undecided:
            raise UndecidedError("whether a ratio is tangent to a limit of the range")
        return [(table.points[0], y) for y in table.where(lambda signs: signs[JOINT] <= 0)]

    def at(self, x: Expr) -> RealNumber | None:
        """The bandwidth then."""
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
        needed: dict[int, list[RealNumber]] = {1: [], 0: [], -1: []}
        for i, term in enumerate(self.terms):
            least = Largest(tuple(Negative(ValueAt(x, omega)) for x in term.squares))
            needed[self._envelope.holds(i, signs)].append(Negative(least))
        found = Largest(tuple(needed[1]))
        if not needed[1] or any(above(x, found) for x in needed[0]):
            raise UndecidedError("which limit holds at the low end of the band")
        found.tight_ball(64)
        return SquareRoot(found)

    @property
    def _first(self) -> RealNumber:
        """The bandwidth for that."""
        first, (square, slope) = (
            self._table.points[0],
            self._envelope.counting(self._table.points[0].after),
        )
        if slope > 0:
            return first.omega
        return self._landing(self._start if slope else _height(square, first.omega))

    def _jumps(self, least: RealNumber, most: RealNumber) -> Iterator[Jump]:
        """At each peak, or begin of a plateau, of what is judged, that is higher than all before
        it."""
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

    def _peaks(self, least: RealNumber, most: RealNumber) -> Iterator[tuple[RealNumber, Maximum]]:
        for point in self._table.points[1:-1]:
            peak = self._envelope.top(point) or self._envelope.plateau(point)
            begins = peak and (
                self._is_passed(point, peak) if peak.after else above(point.omega, least)
            )
            if peak and begins and above(most, point.omega):
                yield point.omega, peak

    def _is_passed(self, point: Point, peak: Maximum) -> bool:
        """Whether a height that is only reached behind a step lies in the range; the bandwidth may
        stand at the step itself."""
        low, high = (ExactNumber(x) for x in self.range)
        height = _height(peak.square, point.omega)
        return above(height, low) and not above(height, high)

    def _landing(self, height: RealNumber) -> RealNumber:
        """The bandwidth for a height; UndecidedError where its enclosures do not become narrow."""
        found = self.at(height.value) if isinstance(height, ExactNumber) else None
        x = Landing(height, self) if found is None else found
        if (
            at_rising_precision(
                lambda bits: x.ball(bits).rel_accuracy_bits() > 50 or None, 64, _SURE
            )
            is None
        ):
            raise UndecidedError("whether two peaks of the ratios are equally high")
        return x


def _height(square: RealFunction, omega: RealNumber) -> RealNumber:
    """The root of a square at a frequency; in closed form where it is the same at all
    frequencies."""
    value = None if square.function.numerator.degrees()[0] else square.expression()
    return (
        SquareRoot(ValueAt(square, omega))
        if value is None or value.free_symbols
        else ExactNumber(sqrt(value))
    )


@dataclass(frozen=True, repr=False)
class Landing(RealNumber):
    """The bandwidth for the height of a peak, or of the band's low end: enclosed by those for
    rational heights beside it."""

    height: RealNumber
    growth: Growth

    def ball(self, bits: int) -> Ball:
        low, high = (Rational(x.numerator, x.denominator) for x in self.height.bounds(bits))
        upper = self.growth.at(high)
        lower = upper if low == high else self._behind(low)
        with flint.ctx.workprec(bits):
            if lower is None or upper is None:
                return arb("nan")
            return lower.ball(bits).union(upper.ball(bits))

    def _behind(self, height: Rational) -> RealNumber | None:
        """Where more is needed than that again; for numbers close to the height it was too little
        around the frequency alone."""
        later = [
            y for first, y in self.growth.kept(height) if y.low is not first and y.low is not y.high
        ]
        return later[0].high.omega if later else None


@dataclass(frozen=True, repr=False)
class Times(RealNumber):
    """A number that many times."""

    number: RealNumber
    times: Expr

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return self.number.ball(bits) * expression_ball(self.times)


def above(a: RealNumber, b: RealNumber) -> bool:
    """Whether a > b; UndecidedError where they are not told apart, unless both are known
    exactly."""
    if a is b or a == b:
        return False

    def sign(bits: int) -> bool | None:
        with flint.ctx.workprec(bits):
            left, right = a.ball(bits), b.ball(bits)
            if left.is_exact() and right.is_exact() and left == right:
                return False
            return True if left > right else False if left < right else None

    found = at_rising_precision(sign, 64, _SURE)
    if found is None:
        raise UndecidedError("which of two numbers is the larger")
    return found
