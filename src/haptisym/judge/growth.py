"""The bandwidth as a JND region grows with one number, whatever its shape: where it jumps, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import flint
from sympy import Expr, Rational, sqrt

from haptisym.judge.climb import Bandwidths, Jump
from haptisym.judge.criteria import JOINT, Criterion, level
from haptisym.judge.envelopes import Envelope, Maximum
from haptisym.judge.landings import Landing, above, settled
from haptisym.judge.peaks import Largest, ValueAt
from haptisym.judge.regions import Term
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.lattices import Lattice
from haptisym.kernel.reals import Ball, ExactNumber, Negative, RealNumber, SquareRoot, expression_ball
from haptisym.kernel.response import RealFunction
from haptisym.kernel.roots import Chart, Interval, Point, chart
from haptisym.model.parameters import ExactRange


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
