"""Local maxima of a distortion's ratios on a band, and the largest values of real functions: where
they are and how large, both proven and to any number of digits.

Where is a ratio r(omega) of the distortion largest? What is charted is its square, a rational
function of omega (or one with sines and powers, for delays and s^alpha), whose maxima are at the
same frequencies. A JND region has several: a change of dynamics is outside of it at frequencies at
which all *conditions* g_ik of a *term* i are positive, as soon as all its squares q_ij exceed 1
(``WayOutside``). So the square of the factor by which the region must be enlarged is the *envelope*

    E(omega) = max over all i with g_ik(omega) > 0 for all k   of   min over j of q_ij(omega).

At each frequency it is that of one square, the *active* one. A local maximum of E is one of the
active square, or lies where another square becomes active, or where a term begins or ends to hold
and E is discontinuous. All of this follows from signs: of the slopes q_ij', of the differences of
any two squares, and of the conditions. A *chart* (``kernel.roots``) has all zeros of these
functions on the band, its *points*, and their signs in between, so no maximum is missed and none is
invented.

Begin with ``peaks``, the answer to the question above, and ``Envelope.local_maximum``, its proof.
``maximum_candidates``, ``largest_value`` and ``supremum`` answer the same for one real function on
a closed band, by its slope alone (Fermat: inside, a maximum is a zero of the slope).
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
from haptisym.judge.bindings import Kind
from haptisym.judge.crossings import Criterion, Judged, noticed
from haptisym.judge.regions import WayOutside
from haptisym.kernel.budget import SECONDS, limited
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.objects import Shown, counted, titled
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, SquareRoot
from haptisym.kernel.roots import Chart, Key, Point, Signs, chart
from haptisym.model.distortion import Distortion
from haptisym.model.scene import Scene
from haptisym.model.scenefile import as_scene

# The answer: the peaks of a scene.


@dataclass(frozen=True, repr=False)
class Peak(Judged, Shown):
    """A local maximum of a ratio: at ``omega``, rad/s, inside the band, with ``ratio`` as its
    value, dimensionless.

    Proven: the slope of ``square``, which is r^2, changes from + to - there, or another square or
    limit takes over. Both numbers are known to any number of digits.
    ``jump`` : whether the envelope is discontinuous there, as where the limit changes from one
    number to another: the ratio then comes arbitrarily near to this value on one side, and drops.
    Made by ``peaks``.
    """

    criterion: Criterion
    omega: RealNumber
    square: RealFunction = field(repr=False)
    jump: bool = False

    def _line(self) -> str:
        symbol = self.criterion.symbol
        what = f"{symbol} over its limit" if self.in_limits and self.part else symbol
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
        """Whether the ratio is the factor by which a limit, or a region, must be enlarged."""
        return self.criterion.region is not None

    @property
    def ratio(self) -> RealNumber:
        """The ratio at the peak, dimensionless."""
        return SquareRoot(ValueAt(self.square, self.omega))


class Peaks(Answer, tuple[Peak, ...]):
    """The local maxima of a scene's ratios inside its band, in ascending order.

    ``undecided`` : the frequencies at which it is undecided at the precision limit whether a slope
    changes its sign; empty for every rational scene.
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
        if not self.undecided:
            return {}
        return {"undecided": [list(x.enclosure()) for x in self.undecided]}


def peaks(scene: Scene | str | Path, *, limit: float | None = SECONDS) -> Peaks:
    """All local maxima of r_r and r_i inside the band, in ascending order: proven to be
    all.

    Of a JND region, or of a part with a floor or limits for each way, how many times it must be
    enlarged is the ratio.
    ``limit`` : seconds of processor time after which a LimitError is raised; None for none.

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
    for criterion in noticed(scene.threshold):
        envelopes[criterion] = Envelope(criterion, _terms(criterion, d))
        functions |= envelopes[criterion].functions()
    with limited(limit):
        table = chart(functions, *scene.band)
    maxima: list[Peak] = []
    # The ends of the band are no local maxima: what lies outside of it is not known.
    for point in table.points[1:-1]:
        for criterion, envelope in envelopes.items():
            if maximum := envelope.local_maximum(point):
                maxima.append(Peak(criterion, point.omega, maximum.square, maximum.jump))
    return Peaks(scene, maxima, (point.omega for point in table.undecided))


def _terms(criterion: Criterion, d: Distortion) -> tuple[WayOutside, ...]:
    """The terms of a criterion's envelope: those of its region, or for a plain limit the square
    r^2 alone, without conditions."""
    if criterion.region:
        return criterion.region.terms(d)
    return (WayOutside((), (criterion.measure(d),)),)


# The envelope of several squares.

_SquareIndex: TypeAlias = tuple[int, int]
"""Which square: (i, j) is the j-th one of term i."""


class EnvelopeMaximum(NamedTuple):
    """A local maximum of an envelope, or the begin of a plateau, at a point of its chart.

    ``square`` : the function whose value at the point it is. ``jump`` : whether the envelope is
    discontinuous there; it is then the limit from one side. ``after`` : whether that is the side
    above the frequency; False for the side below, and without a jump.
    """

    square: RealFunction
    jump: bool
    after: bool = False


@dataclass(frozen=True)
class Envelope:
    """The envelope of the squares of ``terms``: at each frequency the largest, over the terms that
    hold there, of the smallest square of each.

    ``name`` : what distinguishes its functions from those of other envelopes on one chart. Each
    method reads the signs of a chart of ``functions``. ``local_maximum`` is for ``peaks``;
    ``judge.bandwidths`` uses it, ``plateau`` and ``active`` to follow an envelope upwards.
    """

    name: Hashable
    terms: tuple[WayOutside, ...]

    def __hash__(self) -> int:
        # The hash of all terms would be taken at each of a chart's many look-ups.
        return hash(self.name)

    @cached_property
    def squares(self) -> dict[_SquareIndex, RealFunction]:
        """All squares by their index."""
        squares: dict[_SquareIndex, RealFunction] = {}
        for i, term in enumerate(self.terms):
            squares |= {(i, j): f for j, f in enumerate(term.squares)}
        return squares

    def functions(self) -> dict[Key, RealFunction]:
        """The functions whose signs show where the envelope has a maximum.

        Keys: (self, "slope", x) of the square x; (self, "over", x, y) of the difference x - y, for
        x < y alone; (self, "where", i, k) of the k-th condition of term i.
        """
        functions: dict[Key, RealFunction] = {}
        for x, f in self.squares.items():
            functions[self, "slope", x] = f.derivative()
        for (x, f), (y, g) in combinations(self.squares.items(), 2):
            functions[self, "over", x, y] = f - g
        for i, term in enumerate(self.terms):
            for k, f in enumerate(term.where):
                functions[self, "where", i, k] = f
        return functions

    def local_maximum(self, point: Point) -> EnvelopeMaximum | None:
        """The strict local maximum at a point inside of the band; None where there is none, also
        where the envelope has a pole.

        Let L and R be the limits of the envelope from below and above, minus infinity where no term
        holds on that side. There is a maximum with value L if L > R and the envelope rises before
        the point, with value R if L < R and it falls behind it, and if L = R where both are so.
        """
        before, after = self._active(point.before), self._active(point.after)
        rises = before is not None and self._slope(point, point.before, before) > 0
        falls = after is not None and self._slope(point, point.after, after) < 0
        drop = self._drop(point, before, after)
        if before is not None and rises and (drop > 0 or (drop == 0 and falls)):
            return EnvelopeMaximum(self.squares[before], jump=drop > 0)
        if after is not None and falls and drop < 0:
            return EnvelopeMaximum(self.squares[after], jump=True, after=True)
        return None

    def plateau(self, point: Point) -> EnvelopeMaximum | None:
        """The begin of a plateau at a point: the active square above it, where that is constant and
        larger than the envelope below the point. None otherwise."""
        before, after = self._active(point.before), self._active(point.after)
        if after is None or point.after[self, "slope", after]:
            return None
        drop = self._drop(point, before, after)
        if drop < 0:
            return EnvelopeMaximum(self.squares[after], jump=True, after=True)
        rises = before is not None and point.before[self, "slope", before] > 0
        if drop == 0 and rises:
            return EnvelopeMaximum(self.squares[after], jump=False)
        return None

    def condition_sign(self, i: int, signs: Signs) -> int:
        """The least sign of the conditions of term i: 1 where it holds, as all are positive, -1
        where one is negative, 0 where none is, but one vanishes."""
        conditions = range(len(self.terms[i].where))
        return min((signs[self, "where", i, k] for k in conditions), default=1)

    def active(self, signs: Signs) -> tuple[RealFunction, int]:
        """The active square between two points where some term holds, and the sign of its slope."""
        index = self._active(signs)
        assert index is not None
        return self.squares[index], signs[self, "slope", index]

    def _active(self, signs: Signs) -> _SquareIndex | None:
        """The index of the active square between two points; None where no term holds."""
        best: _SquareIndex | None = None
        for i, term in enumerate(self.terms):
            if self.condition_sign(i, signs) <= 0:
                continue
            smallest = (i, 0)
            for j in range(1, len(term.squares)):
                if self._difference(signs, smallest, (i, j)) > 0:
                    smallest = (i, j)
            if best is None or self._difference(signs, smallest, best) > 0:
                best = smallest
        return best

    def _slope(self, point: Point, signs: Signs, x: _SquareIndex) -> int:
        """The sign of a square's slope on one side of a point, by the signs there; 0 where it has a
        pole at the point: a square that rises to a pole has no maximum."""
        has_pole = point.orders.get((self, "slope", x), 0) < 0
        return 0 if has_pole else signs[self, "slope", x]

    def _drop(self, point: Point, before: _SquareIndex | None, after: _SquareIndex | None) -> int:
        """The sign of L - R at a point, of the envelope's limits from below and above, given the
        squares that are active there; one without an active square is minus infinity.

        Squares are not negative, so one with a pole goes to plus infinity on both sides of it. If
        the other has none, the sign of the difference at the point is that on both sides, and
        right. If both have one it may be 0, which has no consequence: their slopes count as 0.
        """
        if before is None or after is None:
            return (before is not None) - (after is not None)
        return self._difference(point.at, before, after)

    def _difference(self, signs: Signs, x: _SquareIndex, y: _SquareIndex) -> int:
        """The sign of the square x less the square y; a chart has each pair once, in order."""
        if x == y:
            return 0
        if x < y:
            return signs[self, "over", x, y]
        return -signs[self, "over", y, x]


# The largest value of one real function on a closed band.


@dataclass(frozen=True)
class MaximumCandidate:
    """A frequency, rad/s, at which a real function may be largest on a closed band, and its value
    there.

    ``kind`` : ``TOUCH`` for a local maximum inside of the band, ``START`` and ``EDGE`` for its low
    and its high end: how a limit at the largest value binds.
    """

    omega: RealNumber
    value: RealNumber
    kind: Kind


def maximum_candidates(
    f: RealFunction, low: Expr, high: Expr
) -> tuple[MaximumCandidate, ...] | None:
    """All places at which a real function can be largest on a closed band: its ends and strict
    local maxima, proven, in ascending order.

    None where f has a pole on the band. UndecidedError where it is undecided whether the slope
    changes its sign somewhere.
    """
    table = _chart_of_slope(f, low, high)
    if any(point.orders.get("value", 0) < 0 for point in table.points):
        return None
    _need_decided(table)
    first, last = table.points[0], table.points[-1]
    candidates: list[MaximumCandidate] = []
    for point in table.points:
        if point is last:
            kind = Kind.EDGE
        elif point is first:
            kind = Kind.START
        elif (point.before["slope"], point.after["slope"]) == (1, -1):
            kind = Kind.TOUCH
        else:
            continue
        candidates.append(MaximumCandidate(point.omega, _value_at(f, point), kind))
    return tuple(candidates)


def largest_value(f: RealFunction, low: Expr, high: Expr) -> RealNumber | None:
    """The largest value of a real function on a closed band, proven; None where f has a pole on
    the band, whatever the sign beside it. UndecidedError as ``maximum_candidates``.

    >>> from haptisym.kernel.dynamics import Ring
    >>> from haptisym.kernel.rings import omega
    >>> from sympy import Integer
    >>> largest_value(RealFunction(Ring().axis.convert(omega / (omega**2 + 4))), Integer(0), Integer(5)).digits(5)
    '0.25000'
    """
    candidates = maximum_candidates(f, low, high)
    if candidates is None:
        return None
    return LargestOf(tuple(x.value for x in candidates))


@dataclass(frozen=True)
class LargestValue:
    """The least upper bound of a real function on a set of frequencies, and a frequency where it is
    attained, rad/s. ``omega`` is None where there is none to name: on an unbounded set it may only
    be approached at high frequency (``passivity``). ``supremum``, on a closed band, always has
    one."""

    value: RealNumber
    omega: RealNumber | None


def supremum(f: RealFunction, low: Expr, high: Expr) -> LargestValue | None:
    """The largest value of a real function on a closed band, proven, and where it is; None where f
    is not bounded above. Unlike ``largest_value`` it exists beside poles to which f falls.

    The frequency is exact, and its value is the largest as far as floats distinguish values: if
    several are as good as equal it is one of theirs. UndecidedError as ``maximum_candidates``.
    """
    table = _chart_of_slope(f, low, high)
    _need_decided(table)
    first, last = table.points[0], table.points[-1]
    poles = [p for p in table.points if p.orders.get("value", 0) < 0]
    for pole in poles:
        # On the sides that lie within the band a positive sign means that f is unbounded above.
        if pole is not last and pole.after["value"] == 1:
            return None
        if pole is not first and pole.before["value"] == 1:
            return None
    # All zeros of the slope, minima included, and zeros of f: more than are needed, which cannot
    # make the largest of all values larger.
    candidates = [(_value_at(f, p), p.omega) for p in table.points if p not in poles]
    value = LargestOf(tuple(value for value, _ in candidates))
    # Floats choose among the candidates, each of which is exact.
    _, omega = max(candidates, key=lambda pair: float(pair[0]))
    return LargestValue(value, omega)


def _chart_of_slope(f: RealFunction, low: Expr, high: Expr) -> Chart:
    """The zeros and signs of f ("value") and of df/d omega ("slope") on a closed band."""
    return chart({"value": f, "slope": f.derivative()}, low, high)


def _need_decided(table: Chart) -> None:
    """UndecidedError where a chart has points at which it is not known whether a sign changes."""
    if table.undecided:
        raise UndecidedError(
            "whether a function has a local maximum where its slope nearly vanishes"
        )


def _value_at(f: RealFunction, point: Point) -> RealNumber:
    """The value of f at a point of its chart that is no pole."""
    # Where f vanishes its value is known exactly, which no ball shows.
    return ExactNumber(Integer(0)) if point.orders.get("value") else ValueAt(f, point.omega)


# Numbers that are made of functions and of other numbers.


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
class LargestOf(RealNumber):
    """The largest of some numbers."""

    numbers: tuple[RealNumber, ...]

    def ball(self, bits: int) -> Ball:
        with flint.ctx.workprec(bits):
            return reduce(arb.max, (number.ball(bits) for number in self.numbers))
