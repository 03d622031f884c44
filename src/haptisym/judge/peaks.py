"""Peaks of a distortion's ratios, and the largest values of real functions: where, and how large;
exact.

A criterion judges the envelope of several squares: a change is outside a region at frequencies at
which all ``where`` of a term are positive, as soon as all squares of the term exceed 1. So at each
frequency the square that counts is the largest, over the terms that hold there, of their least
ones. A local maximum of the envelope is one of the square that counts, or lies where another one
takes over. Signs of all squares' slopes, and of their differences, are read off one chart: begin
with ``Envelope.top``.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import combinations
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeAlias

import flint
from flint import arb
from sympy import Expr, Integer

from haptisym.judge.answers import Answer
from haptisym.judge.crossings import Criterion, Judged, noticed
from haptisym.judge.regions import WayOutside
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.roots import Key, Point, Signs, chart
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene

_Place: TypeAlias = tuple[int, int]
"""Which square: the index of its term, and its index there."""


class Maximum(NamedTuple):
    """A local maximum of an envelope, by the square that has it.

    ``jump`` : whether the envelope is discontinuous there, as on one side another limit holds.
    ``after`` : whether the square is approached from the side after the frequency, the other limit
    holding before it.
    """

    square: RealFunction
    jump: bool
    after: bool = False


@dataclass(frozen=True)
class Envelope:
    """The envelope of the squares of ``terms``: at each frequency the largest, over the terms that
    hold there, of their least squares. ``name`` : what its functions are known by on a chart."""

    name: Hashable
    terms: tuple[WayOutside, ...]

    @cached_property
    def squares(self) -> dict[_Place, RealFunction]:
        """All squares, by their places."""
        return {(i, j): f for i, term in enumerate(self.terms) for j, f in enumerate(term.squares)}

    def functions(self) -> dict[Key, RealFunction]:
        """All functions whose signs show where the envelope has a maximum: slopes and differences
        of squares, and the conditions of terms."""
        functions: dict[Key, RealFunction] = {
            (self, "slope", x): f.derivative() for x, f in self.squares.items()
        }
        for x, y in combinations(self.squares, 2):
            functions[self, "over", x, y] = self.squares[x] - self.squares[y]
        for i, term in enumerate(self.terms):
            functions |= {(self, "where", i, k): f for k, f in enumerate(term.where)}
        return functions

    def __hash__(self) -> int:
        return hash(self.name)

    def top(self, point: Point) -> Maximum | None:
        """The maximum at a point inside of the band; None where there is none, or no bound."""
        before, after = self._counts(point.before), self._counts(point.after)
        # A square that rises to a pole has no maximum there.
        rises, falls = False, False
        if before is not None:
            is_rising = point.before[self, "slope", before] > 0
            rises = is_rising and self._is_finite(point, before)
        if after is not None:
            is_falling = point.after[self, "slope", after] < 0
            falls = is_falling and self._is_finite(point, after)
        # Which side is higher at the point itself; a side on which no term holds is lower.
        if before is None or after is None:
            over = (before is not None) - (after is not None)
        else:
            over = self._over(point.at, before, after)
        # The envelope jumps down, or is continuous there: rising before and falling after.
        if before is not None and rises and (over > 0 or (not over and falls)):
            return Maximum(self.squares[before], jump=over > 0)
        if after is not None and falls and over < 0:
            return Maximum(self.squares[after], jump=True, after=True)
        return None

    def plateau(self, point: Point) -> Maximum | None:
        """The square that counts behind a point if it is constant there, and larger than the
        envelope before it: as ``top`` returns it, though it is no strict maximum. None
        otherwise."""
        before, after = self._counts(point.before), self._counts(point.after)
        if after is None or point.after[self, "slope", after]:
            return None
        over = -1 if before is None else self._over(point.at, before, after)
        if over < 0:
            return Maximum(self.squares[after], jump=True, after=True)
        rises = before is not None and point.before[self, "slope", before] > 0
        return Maximum(self.squares[after], jump=False) if not over and rises else None

    def holds(self, i: int, signs: Signs) -> int:
        """The sign of a term's least condition: it holds (1), does not (-1), or a condition
        vanishes at that point (0)."""
        return min((signs[self, "where", i, k] for k in range(len(self.terms[i].where))), default=1)

    def counting(self, signs: Signs) -> tuple[RealFunction, int]:
        """The square that counts between two points at which a term holds, and the sign of its
        slope."""
        place = self._counts(signs)
        assert place is not None
        return self.squares[place], signs[self, "slope", place]

    def _is_finite(self, point: Point, x: _Place) -> bool:
        return point.orders.get((self, "slope", x), 0) >= 0

    def _counts(self, signs: Signs) -> _Place | None:
        """The square that counts between two points; None where no term holds."""
        best: _Place | None = None
        for i, term in enumerate(self.terms):
            if self.holds(i, signs) <= 0:
                continue
            places = [(i, j) for j in range(len(term.squares))]
            least = next(x for x in places if all(self._over(signs, x, y) <= 0 for y in places))
            if best is None or self._over(signs, least, best) > 0:
                best = least
        return best

    def _over(self, signs: Signs, x: _Place, y: _Place) -> int:
        """The sign of the difference of two squares; a chart has each pair once, in order."""
        if x == y:
            return 0
        return signs[self, "over", x, y] if x < y else -signs[self, "over", y, x]


@dataclass(frozen=True, repr=False)
class ValueAt(RealNumber):
    """The value of a real function at a frequency; balls are kept by their number of bits."""

    function: RealFunction
    omega: RealNumber
    _known: dict[int, Ball] = field(default_factory=dict, init=False, compare=False)

    def ball(self, bits: int) -> Ball:
        if bits not in self._known:
            with flint.ctx.workprec(bits):
                self._known[bits] = self.function.ball(self.omega.ball(bits))
        return self._known[bits]


@dataclass(frozen=True, repr=False)
class Peak(Judged, Shown):
    """A local maximum of a ratio: at ``omega``, rad/s, inside the band, with ``ratio`` as its
    value, dimensionless.

    Proven: d(r^2)/d omega changes from + to - there, or another limit takes over; both numbers to
    any number of digits.
    ``jump`` : whether the limit changes there: the ratio then comes arbitrarily near to this on one
    side, and drops.
    ``threshold`` : the ratio as the exact number to which a ``Threshold`` is tangent here. Made by
    ``peaks``.
    """

    criterion: Criterion
    omega: RealNumber
    square: RealFunction = field(repr=False)
    jump: bool = False

    def _line(self) -> str:
        what = (
            f"{self.criterion.symbol} over its limit"
            if self.in_limits and self.part
            else self.criterion.symbol
        )
        return f"{what} = {self.ratio.digits(6)} at {self.omega.digits(6)} rad/s"

    def row(self) -> dict[str, Any]:
        """The peak as a row of a document."""
        shown = {
            "omega": float(self.omega),
            "digits": self.omega.digits(),
            "enclosure": list(self.omega.enclosure()),
        }
        jump = {"limit": "changes"} if self.jump else {}
        return {
            "part": self.criterion.name,
            **shown,
            "ratio": float(self.ratio),
            "ratio_digits": self.ratio.digits(),
            **jump,
        }

    @property
    def in_limits(self) -> bool:
        """Whether the ratio is how many times a limit, or a region, must be enlarged."""
        return self.criterion.region is not None

    @property
    def ratio(self) -> RealNumber:
        """The ratio at the peak."""
        return SquareRoot(ValueAt(self.square, self.omega))


class Peaks(Answer, tuple[Peak, ...]):
    """The local maxima of a scene's ratios inside its band, in ascending order.

    ``undecided`` : where it is undecided at the precision limit whether a slope changes its sign;
    empty for every rational scene.
    """

    _schema: ClassVar[str] = "haptisym.peaks/1"
    _page: ClassVar[str] = "haptisym.pages.evaluation:page_peaks"
    _figure: ClassVar[str] = "haptisym.figures.evaluation:PEAKS"

    scene: Scene
    undecided: tuple[RealNumber, ...]

    def __new__(
        cls, scene: Scene, found: Iterable[Peak], undecided: Iterable[RealNumber] = ()
    ) -> Peaks:
        self = super().__new__(cls, found)
        self.scene, self.undecided = scene, tuple(undecided)
        return self

    def _line(self) -> str:
        return f"{titled(self.scene.title)}: {counted(len(self), 'peak')}"

    @property
    def certified(self) -> bool:
        """Whether nothing was left undecided."""
        return not self.undecided

    def _body(self) -> dict[str, Any]:
        return {
            "band": [float(x) for x in self.scene.band],
            "peaks": [peak.row() for peak in self],
            "certified": self.certified,
        }

    def _left(self) -> dict[str, Any]:
        return (
            {"undecided": [list(x.enclosure()) for x in self.undecided]} if self.undecided else {}
        )


def peaks(scene: Scene | str | Path, *, limit: float | None = SECONDS) -> Peaks:
    """All local maxima of r_r and r_i inside the band, in ascending order: proven, none missed,
    none invented.

    Of a JND region, or of a part with a floor or limits for each way, how many times it must be
    enlarged is the ratio.
    ``limit`` : seconds of processor time after which a LimitError says that it is not decided; None
    for none.

    >>> from haptisym import effects, environments
    >>> spring = Scene(environments.mass_spring_damper(k=100), (effects.series("1 + 0.4*s/(s^2 + 2*s + 9)"),))
    >>> [(p.criterion.name, p.omega.digits(3), p.ratio.digits(3)) for p in peaks(spring)]
    [('imag', '2.16', '0.100'), ('real', '3.00', '0.200'), ('imag', '4.16', '0.100')]
    """
    scene = as_scene(scene)
    scene.knobs.need_numbers()
    d = scene.distortion()
    envelopes: dict[Criterion, Envelope] = {}
    functions: dict[Key, RealFunction] = {}
    for x in noticed(scene.threshold):
        # A plain limit is a region of one term, r^2 without conditions.
        terms = x.region.terms(d) if x.region else (WayOutside((), (x.measure(d),)),)
        envelopes[x] = Envelope(x, terms)
        functions |= envelopes[x].functions()
    with limited(limit):
        table = chart(functions, *scene.band)
    maxima: list[Peak] = []
    # The ends of the band are no local maxima: what lies outside of it is not known.
    for point in table.points[1:-1]:
        for x, envelope in envelopes.items():
            if top := envelope.top(point):
                maxima.append(Peak(x, point.omega, top.square, top.jump))
    return Peaks(scene, maxima, (point.omega for point in table.undecided))


@dataclass(frozen=True)
class Top:
    """A frequency at which a real function may be largest on a band, and its value there.

    ``end``: None for a local maximum inside, False for the low and True for the high end of the
    band.
    """

    omega: RealNumber
    value: RealNumber
    end: bool | None


def tops(f: RealFunction, low: Expr, high: Expr) -> tuple[Top, ...] | None:
    """All places at which a real function can be largest on a closed band: its ends and local
    maxima, proven.

    None where it is unbounded. UndecidedError where it is undecided whether the slope changes its
    sign somewhere.
    """
    table = chart({"value": f, "slope": f.derivative()}, low, high)
    if any(point.orders.get("value", 0) < 0 for point in table.points):
        return None
    if table.undecided:
        raise UndecidedError(
            "whether a function has a local maximum where its slope nearly vanishes"
        )
    first, last = table.points[0], table.points[-1]
    highest: list[Top] = []
    for x in table.points:
        is_end = x is first or x is last
        if is_end or (x.before["slope"], x.after["slope"]) == (1, -1):
            # Where the function vanishes its value is known exactly, which no ball shows.
            value = ExactNumber(Integer(0)) if x.orders.get("value") else ValueAt(f, x.omega)
            highest.append(Top(x.omega, value, x is last if is_end else None))
    return tuple(highest)


def largest(f: RealFunction, low: Expr, high: Expr) -> RealNumber | None:
    """The largest value of a real function on a closed band, proven; None where it is unbounded.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import omega
    >>> from sympy import Integer
    >>> largest(RealFunction(Ring().axis.convert(omega / (omega**2 + 4))), Integer(0), Integer(5)).digits(5)
    '0.25000'
    """
    highest = tops(f, low, high)
    return None if highest is None else Largest(tuple(x.value for x in highest))


@dataclass(frozen=True)
class Greatest:
    """The largest value of a real function, and a frequency where it has it; None where it only
    comes near it, at high frequency."""

    value: RealNumber
    omega: RealNumber | None


def greatest(f: RealFunction, low: Expr, high: Expr) -> Greatest | None:
    """The largest value of a real function on a closed band and where, proven; None where it
    grows without bound.

    Where it falls without bound it is not largest.
    """
    table = chart({"value": f, "slope": f.derivative()}, low, high)
    if table.undecided:
        raise UndecidedError(
            "whether a function has a local maximum where its slope nearly vanishes"
        )
    # Signs beside the poles, as far as they lie within the band: a positive one means that the
    # function is unbounded above.
    poles = [p for p in table.points if p.orders.get("value", 0) < 0]
    sides = {p.after["value"] for p in poles if p is not table.points[-1]}
    sides |= {p.before["value"] for p in poles if p is not table.points[0]}
    if 1 in sides:
        return None
    tried = [p for p in table.points if p not in poles]
    known = [
        (ExactNumber(Integer(0)) if p.orders.get("value") else ValueAt(f, p.omega), p.omega)
        for p in tried
    ]
    # Every zero of the slope is tried, minima included. Floats choose the frequency; the value is
    # the largest of all in any case.
    best = max(known, key=lambda pair: float(pair[0]))
    return Greatest(Largest(tuple(value for value, _ in known)), best[1])


@dataclass(frozen=True, repr=False)
class Largest(RealNumber):
    """The largest of some numbers."""

    numbers: tuple[RealNumber, ...]

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return reduce(arb.max, (number.ball(bits) for number in self.numbers))
