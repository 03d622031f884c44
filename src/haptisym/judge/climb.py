"""The bandwidth as one threshold for all criteria grows: where it jumps, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from flint import fmpq, fmpq_poly
from sympy import Expr, Integer, Rational, sqrt

from haptisym.judge.criteria import Criterion, kept
from haptisym.judge.landings import Landing, above, settled
from haptisym.judge.peaks import Largest, Peak, ValueAt
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.levels import Level
from haptisym.kernel.reals import RealNumber, SquareRoot
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Chart, Key, Point, chart
from haptisym.model.parameters import ExactRange


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
