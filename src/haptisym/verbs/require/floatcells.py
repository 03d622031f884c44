"""What floats with proven bounds show for all values of a parameter q in an interval at once:
whether conditions hold on a band, and the sign of Im H_perc.

Both are decided over cells of frequency and value, in Taylor models: floats whose remainder
encloses all rounding. What they show is proven; what they do not show is cut, and at last left
open.

**Conditions** (``FloatCells``). The one search (``kernel.where``) with the values as its outer
side, the band as its inner one, and the excess of each criterion as a judge. Values are cut down to
a thousandth of themselves: what is still open then holds the ends of the set, which exact verdicts
close in on where slopes prove that there is just one (``_slant``).

**Energy** (``Energy``). H = N/D draws energy at omega where Im H < 0. Im H has the sign of Im(N
conj D) on the axis: a sum of powers of omega, omega^p c_p, each coefficient made of q and of cos
and sinc of delays. Divided by the lowest power it is G(omega, q), bounded down to omega = 0; beyond
a reach its highest power outweighs the others whatever the phases are.

A value *keeps* the conditions where all hold on the band, else it *breaks* them; a *run* is an
interval of values with one verdict, *open* where there is none. A *model* is a Taylor model
(``programs.taylormodels``), a *cell* a box of frequency and value. Begin with ``FloatCells.told``
and ``Energy.clear``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import groupby, product
from math import inf, nextafter, prod
from typing import Any, TypeAlias

import flint
from sympy import Expr, I, Integer, Poly, Rational, Symbol, pi

from haptisym.judge.bounds import ANY_ENVIRONMENT, is_series
from haptisym.judge.crossings import Criterion
from haptisym.judge.excess import Box, Excess, LargerExcess, Side, excess_of
from haptisym.kernel.arrays import np
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError, UndecidedError
from haptisym.kernel.reals import expression_ball
from haptisym.kernel.rings import Polynomial, RationalFunction, monomials, omega
from haptisym.kernel.where import Array, Batches, Cells, LineBound, Search, halves, joined, search
from haptisym.model.quantities import Dimension
from haptisym.model.scene import Knob, Scene
from haptisym.programs.taylormodels import TaylorModel, between, floated, valued, variable
from haptisym.verbs.require.freeparameter import ExactSign, JudgedValues, ladder, merged

# Where pieces of the band begin and end, as shares; for times also shorter ones near its low end,
# where long delays show themselves.
_FIRST_PIECES = tuple(n / 16 for n in range(17))
_SHORT_PIECES = tuple(2.0**-n for n in (14, 12, 10, 8, 6))
# After how many cells the larger excess is asked too.
_HARD = 2000
# Relative widths of values that are cut no further: of all, and of those around what stays open.
_COARSE = 1e-3
_FINE = 2e-10
# How often the pieces of the band are halved in cells whose values are cut no further.
_LAST = 3
# Pieces that are looked at to cut values more finely, each time.
_MOST_FINE = 20_000
# Relative width of values over which slopes are bounded at least: over less, rounding would be a
# large part of them.
_WIDENED = 1e-6
# How often pieces of the band are halved until their slopes show a sign, and how many there may be.
_HALVINGS = 6
_MOST_SLOPES = 1000

_THRESHOLDS = ("c", "c_real", "c_imag")


@dataclass(frozen=True)
class _OneFree(Box):
    """A box with one side, from 0 to 1, so that shares are the values of the parameter
    themselves."""

    name: str = ""

    @cached_property
    def sides(self) -> tuple[Side, ...]:
        return (Side(self.name, Integer(0), Integer(1)),)


@dataclass(frozen=True)
class FloatCells:
    """Criteria of a scene on its band in which one parameter is free.

    ``scale`` : a usual size of the parameter. ``is_broken`` : another way to show that values about
    0 are broken, where an excess may be infinite.
    """

    scene: Scene
    free: Knob
    criteria: Sequence[Criterion]
    scale: float
    is_broken: Callable[[JudgedValues], bool] = lambda _: False

    def told(self, low: float, high: float) -> list[JudgedValues]:
        """What is known of the values from one to another, in order."""
        # Around 0 widths relative to the value would never be reached: below this size they are
        # not.
        least = 0.0 if low * high > 0 else self.scale * _COARSE
        shares = {*_FIRST_PIECES}
        if self.free.dimension is Dimension.TIME:
            shares.update(_SHORT_PIECES)
        found = search(
            self._judges,
            _intervals(ladder(low, high, self.scale)),
            _intervals(sorted(shares)),
            wide=_wider(_COARSE, least),
            last=_LAST,
            what="cells of band and values",
        )
        return self._finer(_runs(found.kept, found.broken, found.left))

    @property
    def are_known(self) -> bool:
        """Whether all criteria can be bounded in floats, without which nothing is told here."""
        return self._excesses is not None

    @cached_property
    def _excesses(self) -> list[tuple[Excess, Callable[[], Excess] | None]] | None:
        """The excess of each criterion, and one that is never smaller, made when asked for; None
        where one criterion cannot be bounded in floats."""
        name = self.free.symbol.name
        if self.free.parts or name in _THRESHOLDS:
            return None
        for x in self.criteria:
            is_bounded = x.part or x.region or x.name == ANY_ENVIRONMENT.name
            if not is_bounded:
                return None
        excesses: list[tuple[Excess, Callable[[], Excess] | None]] = []
        try:
            box = _OneFree(self.scene, name)
            series = is_series(self.scene.chain)
            for x in self.criteria:
                excess = excess_of(box, x)
                larger = _larger(box, x) if series else None
                if not excess.is_zero:
                    excesses.append((excess, larger))
        except HaptisymError:
            return None
        return excesses

    @property
    def _judges(self) -> list[_Judge]:
        """A judge of each excess that is not zero everywhere, with its own count of cells."""
        return [_Judge(excess, larger) for excess, larger in self._excesses or ()]

    def _finer(self, runs: Sequence[JudgedValues]) -> list[JudgedValues]:
        """Runs of values with those that are open cut more finely, unless they are shown to hold
        just one end; first those between kept and broken ones."""
        places = [i for i, x in enumerate(runs) if x.open is not None]
        finer = {i: [x] for i, x in enumerate(runs)}
        for i in sorted(places, key=lambda i: not _is_between(runs, i)):
            own = runs[i]
            if own.low <= 0 <= own.high and self.is_broken(own):
                finer[i] = [replace(own, kept=False, open=None)]
                continue
            turned = self._turned(runs, i)
            finer[i] = self._cut(runs, i) if turned.slant is None else [turned]
        return merged(x for own in finer.values() for x in own)

    def _cut(self, runs: Sequence[JudgedValues], i: int) -> list[JudgedValues]:
        """The runs into which an open run falls where its values are cut more finely."""
        cells = runs[i].open
        assert cells is not None
        cut = Search(
            self._judges,
            cells,
            wide=_wider(_FINE, self.scale * _COARSE),
            last=_LAST,
            most=_MOST_FINE,
            what="ends of values",
        )
        settled = joined([cells[:0], *cut])
        # A cell is broken where an excess has a finite ceiling: the frequency at which it is
        # positive for all of its values was found.
        broken = settled.ceiling < np.inf
        inside = _runs(settled[~broken], settled[broken], cut.left)
        before, after = runs[max(i - 1, 0) : i], runs[i + 1 : i + 2]
        around = [*before, *inside, *after]
        return [self._turned(around, k) for k, x in enumerate(around) if x not in runs]

    def _turned(self, runs: Sequence[JudgedValues], i: int) -> JudgedValues:
        """A run that is open, with the slant that proves one end in it; unchanged where there may
        be none or more."""
        own = runs[i]
        if own.open is None or not _is_between(runs, i):
            return own
        sense = 1.0 if runs[i - 1].kept else -1.0
        return replace(own, slant=self._slant(own.open, sense))

    def _slant(self, cells: Cells, sense: float) -> float | None:
        """How steep the lines are along which each excess that may be 0 grows as the values grow
        (``sense`` > 0) or fall: rad/s for one unit of the parameter. None where that is not shown.

        Then what is broken for one value stays broken for all beyond it, at a frequency on such a
        line: so there is one end.
        """
        steepest = 0.0
        middle = cells.outer.mean(-1)
        radius = np.ptp(cells.outer, -1) / 2
        radius = np.maximum(radius, np.abs(middle) * _WIDENED / 2)
        outer = np.stack([middle - radius, middle + radius], -1)
        for (excess, _), pieces in zip(self._excesses or (), cells.pieces, strict=True):
            boxes = pieces.cells(outer)
            for _ in range(_HALVINGS):
                if not 0 < len(boxes) <= _MOST_SLOPES:
                    break
                grows, slant = _grows(excess, boxes, sense)
                steepest = max(steepest, slant)
                boxes = boxes[~grows]
                boxes = halves(boxes, np.zeros(len(boxes), int))
            if len(boxes):
                return None
        low, high = self.scene.band
        return steepest * floated(high - low)


def _grows(excess: Excess, boxes: Array, sense: float) -> tuple[Array, float]:
    """In which boxes what is positive stays so as the values grow, or fall (``sense`` < 0), as each
    function grows along one line through the box; and how steep the steepest of these lines is, as
    a share of the band for one unit.

    The line is straight up, omega constant, or slanted: q + t, omega + v t, where the box is inside
    of the band. Around the box nothing is positive, so that a line cannot leave it while what is
    positive stays so. Slanted lines are for two functions that must not both be positive and bind
    at a corner, one over the zero of the other: along the band one falls there as the other grows.
    """
    start, end = boxes[:, 0].T
    is_inside = (start > 0) & (end < 1)
    grows = np.ones(len(boxes), bool)
    steepest = 0.0
    for term in excess.terms(boxes):
        # Of each function where it is positive, and its slopes along the parameter and along omega,
        # the least and the largest.
        positive, by_value, by_omega = [], [], []
        negative = np.zeros(len(boxes), bool)
        for f in term:
            # Value, slope along omega, slope along the parameter.
            low, high = f.bounds()
            positive.append(low[:, 0] > 0)
            negative |= high[:, 0] < 0
            by_omega.append(np.stack([low[:, 1], high[:, 1]]))
            slopes = np.stack([low[:, 2], high[:, 2]])
            by_value.append(np.sort(sense * slopes, 0))
        v = _slant(by_value, by_omega, [~x for x in positive])
        straight = np.ones(len(boxes), bool)
        slanted = is_inside.copy()
        for stays, (least, _), w in zip(positive, by_value, by_omega, strict=True):
            straight &= stays | (least > 0)
            # A function that is positive all over the box does not matter: it stays so. Of others
            # the slope along the line is q + v w, at least by the worse end of w.
            with np.errstate(invalid="ignore"):
                worst = np.minimum(v * w[0], v * w[1])
                slanted &= stays | (least + worst > 0)
        grows &= negative | straight | slanted
        # Models are functions of both sides of a box from -1 to 1: v becomes a share of the band
        # for one unit of the parameter.
        steepness = np.abs(v) * np.ptp(boxes[:, 0], -1) / np.ptp(boxes[:, 1], -1)
        needed = slanted & ~negative & ~straight
        steepest = max(steepest, float(steepness[needed].max(initial=0.0)))
    return grows, steepest


def _slant(along: Sequence[Array], across: Sequence[Array], counts: Sequence[Array]) -> Array:
    """A guess at v, how far to go along omega for one unit of the parameter so that functions with
    these slopes all grow; 0 where any v will do, or none is bounded.

    ``counts`` : of each function the boxes in which it matters.
    """
    boxes = along[0].shape[1]
    low = np.full(boxes, -np.inf)
    high = np.full(boxes, np.inf)
    with np.errstate(all="ignore"):
        for q, w, matters in zip(along, across, counts, strict=True):
            # q + v w > 0 asks for v above this where w > 0, and below it where w < 0.
            bound = -q.mean(0) / w.mean(0)
            is_lower = matters & (w[0] > 0)
            is_upper = matters & (w[1] < 0)
            low = np.where(is_lower, np.maximum(low, bound), low)
            high = np.where(is_upper, np.minimum(high, bound), high)
        # Amid what all allow, so that the slopes' widths have most room on either side.
        middle = (low + high) / 2
        return np.nan_to_num(middle, nan=0.0, posinf=0.0, neginf=0.0)


def _is_between(runs: Sequence[JudgedValues], i: int) -> bool:
    """Whether the values below keep the conditions and those above do not, or the other way
    round."""
    if not 0 < i < len(runs) - 1:
        return False
    below, above = runs[i - 1].kept, runs[i + 1].kept
    return {below, above} == {True, False}


def _intervals(ends: Sequence[float]) -> Array:
    """The intervals between neighbouring numbers, as boxes of one side."""
    x = np.array(ends)
    return np.stack([x[:-1], x[1:]], -1)[:, None]


def _wider(share: float, least: float) -> Callable[[Array], Array]:
    """A function that tells which cells are at least as wide as a share of their values, or of
    ``least`` where these are smaller."""

    def wide(cells: Array) -> Array:
        sizes = np.maximum(np.abs(cells).max(-1), least)
        return cells[..., 1] - cells[..., 0] >= share * sizes

    return wide


def _runs(*parts: Cells) -> list[JudgedValues]:
    """Cells that are kept, broken and left, in this order of ``parts``, as runs of values: those
    that follow each other with one verdict as one."""
    # Both ends of each cell, the number of its part, and its own number in that.
    listed: list[tuple[float, float, int, int]] = []
    for n, cells in enumerate(parts):
        for i, (low, high) in enumerate(cells.outer[:, 0].tolist()):
            listed.append((low, high, n, i))
    runs = []
    for n, group in groupby(sorted(listed), key=lambda row: row[2]):
        rows = [*group]
        first, last = Fraction(rows[0][0]), Fraction(rows[-1][1])
        kept = (True, False, None)[n]
        left = parts[n][[row[3] for row in rows]] if kept is None else None
        runs.append(JudgedValues(first, last, kept, open=left))
    return runs


def _larger(box: Box, x: Criterion) -> Callable[[], Excess] | None:
    """What makes the larger excess r^2 - c^2 of a criterion of one part with a plain number as its
    threshold; None for others."""
    if x.part is None or x.region or x.threshold.has(omega):
        return None
    return cache(partial(LargerExcess, box, x))


@dataclass
class _Judge:
    """Bounds on an excess over cells, for the search.

    ``larger`` makes an excess that is never smaller: near a resonance of the environment it is
    shown to be negative on wider cells, which is asked for once ``_HARD`` cells were looked at.
    """

    excess: Excess
    larger: Callable[[], Excess] | None
    looked: int = 0

    def __call__(self, cells: Array) -> LineBound:
        self.looked += len(cells)
        found = self.excess.curve(cells)
        if self.larger and self.looked > _HARD:
            rest = np.flatnonzero(~found.negative)
            if len(rest):
                curve = self.larger().curve(cells[rest])
                return found.known_negative(rest[curve.negative])
        return found


Span: TypeAlias = tuple[float, float]
Parts: TypeAlias = dict[Expr, list[TaylorModel | None]]
"""A function of omega on the axis: by powers of omega, its real and imaginary part; None for 0."""
_BITS = 160
_ROUNDING = 1e-14
_QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


@dataclass(frozen=True)
class LagTerm:
    """A term of N or D: number(q) s^power exp(-s lag(q))."""

    power: Expr
    lag: Expr
    number: Expr

    @property
    def turned(self) -> tuple[float, float]:
        """Cosine and sine of a quarter turn for each power."""
        if isinstance(self.power, Integer):
            return _QUARTERS[int(self.power) % 4]
        # Near an odd power a cosine in floats loses digits, which ``TaylorModel.times`` takes for
        # known.
        with flint.ctx.workprec(_BITS):
            half = expression_ball(self.power) / 2
            return float(half.cos_pi()), float(half.sin_pi())


def terms_in(ring: Ring, polynomial: Polynomial) -> list[LagTerm]:
    """A polynomial as terms, of each power and delay one."""
    numbers: dict[tuple[Expr, Expr], Expr] = {}
    # The variables of a ring are s, pi, its symbols, unit delays, and broken powers of s.
    delays = ring.size
    orders = delays + len(ring.lags)
    for exponents, value in monomials(polynomial):
        degrees = [int(n) for n in exponents]
        rational = Rational(int(value.p), int(value.q))
        number = rational * pi ** degrees[1]
        for symbol, n in zip(ring.symbols, degrees[2:delays], strict=True):
            number *= symbol**n
        lag = _weighted(degrees[delays:orders], ring.lags)
        power = degrees[0] + _weighted(degrees[orders:], ring.orders)
        key = power, lag
        numbers[key] = numbers.get(key, Integer(0)) + number
    return [LagTerm(power, lag, number) for (power, lag), number in numbers.items()]


def _weighted(exponents: Sequence[int], numbers: Sequence[Expr]) -> Expr:
    """The sum of numbers, each as often as its exponent says."""
    total = Integer(0)
    for n, x in zip(exponents, numbers, strict=False):
        total += n * x
    return total


Turned: TypeAlias = tuple[Expr, Expr, Expr | None]
"""A power of omega, by how many quarters it is turned, and what stands before it; None: not
known."""


def beginnings(row: Sequence[LagTerm]) -> Iterator[Turned]:
    """The terms as s begins at 0, with delays as 1 - s lag."""
    for x in row:
        yield x.power, x.power, x.number
        if x.lag != 0:
            yield x.power + 1, x.power - 1, x.number * x.lag


def endings(row: Sequence[LagTerm]) -> Iterator[Turned]:
    """The terms as s goes to infinity: the phase of those with a delay turns on and on, so that
    their number is not known."""
    for x in row:
        yield x.power, x.power, x.number if x.lag == 0 else None


def paired(above: Iterable[Turned], below: Iterable[Turned]) -> tuple[dict[Expr, Expr], list[Expr]]:
    """Im(N conj D), for N and D with the terms ``above`` and ``below``: its coefficients by powers
    of omega, without those that cancel; and the powers of which they are not known."""
    numbers: dict[Expr, Expr] = {}
    unknown: list[Expr] = []
    for (p, a, x), (n, b, y) in product(above, below):
        power = p + n
        quarters = a - b
        if x is None or y is None or not isinstance(quarters, Integer):
            unknown.append(power)
            continue
        # j^a times the conjugate of j^b is j^(a - b).
        imaginary_part = (0, 1, 0, -1)[int(quarters) % 4]
        before = numbers.get(power, Integer(0))
        numbers[power] = before + imaginary_part * x * y
    expanded = {power: x.expand() for power, x in numbers.items()}
    nonzero = {power: form for power, form in expanded.items() if form != 0}
    return nonzero, unknown


def add_to(found: Parts, power: Expr, model: TaylorModel, C: float, S: float) -> None:
    """Add a model times C to the real part of what stands at a power of omega, and times S to the
    imaginary part."""
    pair = found.setdefault(power, [None, None])
    for i, factor in enumerate((C, S)):
        if factor:
            more = model.times(factor)
            known = pair[i]
            pair[i] = more if known is None else known + more


def imaginary(above: Parts, below: Parts) -> dict[Expr, TaylorModel]:
    """The imaginary part of ``above`` times the conjugate of ``below``, by powers of omega."""
    found: dict[Expr, TaylorModel] = {}

    def add(power: Expr, x: TaylorModel | None, y: TaylorModel | None, sign: float) -> None:
        if x is not None and y is not None:
            more = (x * y).times(sign)
            found[power] = found[power] + more if power in found else more

    for p, (a, b) in above.items():
        for n, (c, d) in below.items():
            add(p + n, b, c, 1.0)
            add(p + n, a, d, -1.0)
    return found


class ModelPowers:
    """The powers x^p of a model, p >= 0; whole ones are made once each: 1, x, x^2, ..."""

    def __init__(self, x: TaylorModel) -> None:
        self.x = x
        self._known = [x.number(1.0)]

    def __call__(self, p: Expr) -> TaylorModel:
        if not isinstance(p, Integer):
            return self.x.to_the(self.x.number(floated(p)))
        n = int(p)
        while len(self._known) <= n:
            self._known.append(self._known[-1] * self.x)
        return self._known[n]


def bent_sinc(angle: TaylorModel) -> TaylorModel:
    """(sinc x - 1)/x^2, which lies between -1/6 and -1/6 + x^2/120."""
    sizes = np.abs(np.stack(angle.bounds()))
    most = sizes[:, :, 0].max(0)
    low = np.full(len(most), -1 / 6 * (1 + 1e-12))
    high = -1 / 6 + most**2 / 120 + 1e-12
    return between(low, np.maximum(low, high), angle)


def variables(cells: Array) -> tuple[TaylorModel, TaylorModel]:
    """Models of frequency and parameter over cells of both, which are their values."""
    found = []
    for i in (0, 1):
        low, high = cells[:, i].T
        size = np.maximum(-low, high)
        with np.errstate(all="ignore"):  # what is not finite is unknown
            middle = (low + high) / 2
            radius = (high - low) / 2
            found.append(variable(middle, radius, size, i, 2, slopes=0))
    omega, value = found
    return omega, value


@dataclass(frozen=True)
class _Points:
    """Values at single points, with an estimate of their rounding: a model's stand-in where nothing
    is to be proven but only where to look.

    The estimate is not a bound; what is found so is proven by models after.
    """

    c0: Any
    r: Any

    def bounds(self) -> tuple[Array, Array]:
        """Each of them."""
        return np.asarray(self.c0 - self.r), np.asarray(self.c0 + self.r)

    def number(self, x: float) -> _Points:
        return _Points(x, abs(x) * _ROUNDING)

    def times(self, x: float) -> _Points:
        return self * self.number(x)

    def __add__(self, other: _Points) -> _Points:
        sizes = abs(self.c0) + abs(other.c0)
        r = self.r + other.r + _ROUNDING * sizes
        return _Points(self.c0 + other.c0, r)

    def __mul__(self, other: _Points) -> _Points:
        c0 = self.c0 * other.c0
        largest = abs(other.c0) + other.r
        r = abs(self.c0) * other.r + self.r * largest
        return _Points(c0, r + _ROUNDING * abs(c0))

    def __truediv__(self, other: _Points) -> _Points:
        c0 = np.divide(self.c0, other.c0)  # by 0 as well
        size = abs(c0)
        r = np.divide(self.r + size * other.r, abs(other.c0))
        return _Points(c0, r + _ROUNDING * size)

    def cosine_and_sine(self) -> tuple[_Points, _Points]:
        r = self.r + _ROUNDING
        return _Points(np.cos(self.c0), r), _Points(np.sin(self.c0), r)

    def sinc(self) -> _Points:
        return _Points(np.sinc(self.c0 / np.pi), self.r + _ROUNDING)

    def to_the(self, order: _Points) -> _Points:
        c0 = self.c0**order.c0
        return _Points(c0, c0 * (self.r / self.c0 + _ROUNDING))


def ends_of(model: TaylorModel) -> tuple[float, float]:
    """The least and the largest that a model is in any of its cells."""
    low, high = model.bounds()
    return float(low.min()), float(high.max())


def size_of(model: TaylorModel) -> float:
    """The largest size of a model in any of its cells."""
    low, high = ends_of(model)
    return max(abs(low), abs(high))


def span(low: Rational, high: Rational) -> Span:
    """The ends as floats, rounded outward."""
    a = float(low)
    if Rational(a) > low:
        a = nextafter(a, -inf)
    b = float(high)
    if Rational(b) < high:
        b = nextafter(b, inf)
    return a, b


class _Late:
    """A delay over cells, with cosine and sinc of its phase omega lag, each made once."""

    def __init__(self, omega: TaylorModel, lag: TaylorModel) -> None:
        self.lag = lag
        self.angle = omega * lag

    @cached_property
    def cosine(self) -> TaylorModel:
        return self.angle.cosine_and_sine()[0]

    @cached_property
    def sinc(self) -> TaylorModel:
        return self.angle.sinc()


# Up to which frequency, rad/s, one is looked for from which on Im H > 0.
_FARTHEST = 2.0**60
# Cells of frequency and parameter that are looked at for one range of values, and to begin with.
_MOST = 800
_FIRST = 48


class Energy:
    """Im(N conj D) on the axis, for a dynamics N/D with one symbol q: it has the sign of Im H.

    Verdicts are about a range of q as floats, which may be one number. True, or a frequency, is
    proven; False of ``clear`` and None prove nothing.
    """

    def __init__(self, rows: Sequence[Sequence[LagTerm]], symbol: Symbol) -> None:
        self._rows = rows
        self.symbol = symbol

    @classmethod
    def of(cls, H: RationalFunction, symbol: Symbol) -> Energy:
        """UndecidedError where it has friction, or powers of s that change."""
        ring = H.ring
        assert isinstance(ring, Ring)
        if I in ring.generators:
            raise UndecidedError("passivity, with friction and delays or powers of s")
        if any(x.free_symbols for x in ring.orders):
            raise UndecidedError("passivity, as a power of s changes")
        return cls([terms_in(ring, p) for p in (H.numerator, H.denominator)], symbol)

    def clear(self, q: Span, start: float = 0.0) -> bool:
        """Whether Im H > 0 at all frequencies from ``start`` on, 0 not included, for all values of
        a range, proven."""
        reach = self._reach(q)
        if reach is None:
            return False
        first, last = max(start, 1e-4 * reach), max(reach, 2 * start)
        edges = np.concatenate([[start], np.geomspace(first, last, _FIRST)])
        cells = np.empty((_FIRST, 2, 2))
        cells[:, 0, 0] = edges[:-1]
        cells[:, 0, 1] = edges[1:]
        cells[:, 1] = q
        waiting = Batches(cells, size=_MOST, most=_MOST, what="cells of frequency and value")
        for own in waiting:
            model = self._function(*variables(own))
            low, high = (x[:, 0] for x in model.bounds())
            # Negative all over one cell: no cutting can help.
            if (high < 0).any():
                return False
            left = ~(low > 0)
            # Cut where the function changes most: along frequency or along the parameter.
            bends = np.abs(model.c2[left, 0]).sum(-1)
            rates = np.abs(model.c1[left, 0]) + bends
            rates = np.nan_to_num(rates, nan=0.0, posinf=0.0)
            waiting.add(halves(own[left], np.argmax(rates, -1)))
        return not len(waiting.rest)

    def active_at(self, q: Span) -> float | None:
        """A frequency at which Im H < 0 for all values of a range, proven; None where none was
        found."""
        middle = (q[0] + q[1]) / 2
        value: Any = _Points(middle, abs(middle) * _ROUNDING)
        with np.errstate(all="ignore"):
            # Where the sign settles far out, up to there; else some turns of the delays show what
            # repeats.
            reach = self._reach((middle, middle), (value, value)) or self._turns(q)
        by_ratio = np.geomspace(1e-4 * reach, reach, 150)
        by_step = np.linspace(0, reach, 150)[1:]
        grid = np.unique(np.concatenate([by_ratio, by_step]))
        at: Any = _Points(grid, grid * _ROUNDING)
        _, upper = self._function(at, value).bounds()
        most = np.broadcast_to(upper, grid.shape)
        # Where the middle value is most negative, all values of the range are most likely so.
        for i in np.argsort(most)[:3]:
            if most[i] < 0:
                _, proven = self._bounds(grid[i : i + 1], q)
                if proven[0] < 0:
                    return float(grid[i])
        return None

    def rises(self, q: Span) -> float | None:
        """A frequency up to which G(omega, q) > G(0, q), for all values of a range; None where that
        is not shown.

        So where G(0, q) >= 0, and also where it comes to 0, Im H > 0 up to that frequency.
        """
        end = self._reach(q) or 0.0
        while end > 1e-6:
            omega, value = variables(np.array([[[0.0, end], q]]))
            coefficients = self._coefficients(omega, value, expanded=True)
            powers = sorted(coefficients)
            if len(powers) < 2:
                return None
            _, second, *later = powers
            low, high = (x[0, 0] for x in coefficients[second].bounds())
            # The power next to the lowest must outweigh all others, which lose against it as the
            # end shrinks.
            rest = 0.0
            for p in later:
                rest += size_of(coefficients[p]) * end ** floated(p - second)
            if low > rest * (1 + 1e-9):
                return end
            if high < 0:
                return None
            end /= 4
        return None

    def beyond(self, end: float, side: int) -> bool | None:
        """The verdict on all values beyond an end, above it (``side`` 1) or below it (-1): True,
        passive if the end is; False, active; None, not known."""
        if any(x.lag.has(self.symbol) for row in self._rows for x in row):
            return None
        if self._is_helped(side):
            return True
        if not end * side > 0:
            return None
        # As u = 1/q from 0 on: one range of floats holds all values beyond the end, and infinity.
        inverse = 0.0, nextafter(1 / abs(end), inf)
        if self._inverted(side).active_at(inverse) is None:
            return None
        return False

    def _is_helped(self, side: int) -> bool:
        """Whether more of the number is more stiffness, damping or mass, and nothing else."""
        above, below = self._rows
        if len(below) > 1:
            return False
        for x in below:
            if x.power != 0 or x.lag != 0 or not x.number.is_positive:
                return False
        for x in above:
            if x.number.has(self.symbol):
                grown = x.number.diff(self.symbol) * side
                is_passive = x.lag == 0 and x.power in (0, 1, 2)
                if not is_passive or not grown.is_positive:
                    return False
        return True

    def _inverted(self, side: int) -> Energy:
        """The energy with side/u in place of q, times a power of u > 0, which keeps its sign."""
        rows = []
        for row in self._rows:
            forms = [Poly(x.number, self.symbol) for x in row]
            most = max(form.degree() for form in forms)
            inverted = []
            for x, form in zip(row, forms, strict=True):
                number = Integer(0)
                for (n,), c in form.terms():
                    number += c * side**n * self.symbol ** (most - n)
                inverted.append(LagTerm(x.power, x.lag, number))
            rows.append(inverted)
        return Energy(rows, self.symbol)

    @cached_property
    def top(self) -> Expr | None:
        """The coefficient of the highest power of s in N; None where a delay is in it."""
        above, _ = self._rows
        top = max(x.power for x in above)
        total = Integer(0)
        for x in above:
            if x.power == top:
                if x.lag != 0:
                    return None
                total += x.number
        return total

    @cached_property
    def at_0(self) -> Expr:
        """G(0, q), exactly. UndecidedError where the terms 1 - s lag of delays do not tell it."""
        above, below = (list(beginnings(row)) for row in self._rows)
        coefficients, unknown = paired(above, below)
        lowest = min(coefficients, default=None)
        if lowest is None or bool(lowest > self._lowest):
            raise UndecidedError("passivity, near frequency 0")
        if any(bool(p <= lowest) for p in unknown):
            raise UndecidedError("passivity, near frequency 0")
        return coefficients[lowest]

    @cached_property
    def far(self) -> tuple[Expr, ExactSign] | None:
        """The highest power of omega in Im(N conj D), and the sign of its coefficient, as a
        function of q; None where a delay is in it."""
        above, below = (list(endings(row)) for row in self._rows)
        coefficients, unknown = paired(above, below)
        top = max(coefficients, default=None)
        if top is None or any(bool(p >= top) for p in unknown):
            return None
        coefficient = coefficients[top]
        if not coefficient.is_polynomial(self.symbol):
            return None
        return top, ExactSign(coefficient, self.symbol)

    @cached_property
    def turning(self) -> ExactSign | None:
        """A sign that is negative where Im H turns for ever at high frequencies, and so is negative
        again and again; 0 where what prevails there vanishes or has no delay.

        None where that is not known. H goes as N's highest power there, all of which is delayed,
        over one of D that is not: its phase turns through all angles.
        """
        of_highest_power = []
        for row in self._rows:
            highest = max((x.power for x in row), default=None)
            of_highest_power.append([x for x in row if x.power == highest])
        above, below = of_highest_power
        if len(below) > 1 or below[0].lag != 0:
            return None
        if any(x.lag == 0 for x in above):
            return None
        # Two of them may come to have one delay, and cancel.
        if len(above) > 1 and any(x.lag.has(self.symbol) for x in above):
            return None
        constants = [x.number for x in above if not x.number.has(self.symbol)]
        number = constants[0] if constants else above[0].number
        factor = prod((x.lag for x in above), start=number * below[0].number)
        return self._sign_of(-(factor**2).expand())

    def _sign_of(self, form: Expr) -> ExactSign | None:
        """The sign of a polynomial in q; None of any other form."""
        return ExactSign(form, self.symbol) if form.is_polynomial(self.symbol) else None

    @cached_property
    def far_right(self) -> ExactSign | None:
        """The sign of H(s)/s for large s > 0, where delayed terms have faded; 0 for values of q
        with which one has no delay. None where nothing is undelayed.

        A positive real H/s is positive for all s > 0: where this is negative H is not passive.
        """
        early = [[x for x in row if x.lag == 0] for row in self._rows]
        if not all(early):
            return None
        form = Integer(1)
        for row in self._rows:
            for x in row:
                if x.lag.has(self.symbol):
                    form *= x.lag**2
        for row in early:
            fastest = max(row, key=lambda x: x.power)
            form *= fastest.number
        return self._sign_of(form.expand())

    @cached_property
    def _lowest(self) -> Expr:
        """The lowest power of omega in Im(N conj D), by which it is divided to make G."""
        omega, q = variables(np.array([[[0.0, 1.0], [1.0, 1.0]]]))
        return min(self._coefficients(omega, q))

    def _bounds(self, omega: Array, q: Span) -> tuple[Array, Array]:
        """Bounds of G at single frequencies for all values of a range."""
        cells = np.empty((len(omega), 2, 2))
        cells[:, 0, 0] = cells[:, 0, 1] = omega
        cells[:, 1] = q
        model = self._function(*variables(cells))
        low, high = (x[:, 0] for x in model.bounds())
        return low, high

    def _function(self, omega: TaylorModel, q: TaylorModel) -> TaylorModel:
        """Models of G(omega, q) over cells."""
        with np.errstate(all="ignore"):
            total = omega.number(0.0)
            powers = ModelPowers(omega)
            for p, model in self._coefficients(omega, q).items():
                total = total + model * powers(p - self._lowest)
            return total

    def _coefficients(
        self, omega: TaylorModel, q: TaylorModel, *, expanded: bool = False
    ) -> dict[Expr, TaylorModel]:
        """Models of the coefficients of Im(N conj D) by powers of omega.

        ``expanded``: with cos and sinc as 1 and omega^2 times the rest, so that what their leading
        terms cancel is cancelled exactly.
        """
        with np.errstate(all="ignore"):
            above, below = (self._parts(row, omega, q, expanded=expanded) for row in self._rows)
            return imaginary(above, below)

    def _parts(
        self, row: Sequence[LagTerm], omega: TaylorModel, q: TaylorModel, *, expanded: bool
    ) -> Parts:
        """Models of the real and imaginary part of N or D on the axis, by powers of omega.

        exp(-j a), a = omega lag, is cos a - j omega lag sinc a: sinc has no division by omega.
        """
        parts = Parts()
        powers = ModelPowers(q)
        late_by: dict[Expr, _Late] = {}
        for x in row:
            C, S = x.turned
            number = self._valued(x.number, powers)
            if x.lag == 0:
                add_to(parts, x.power, number, C, S)
                continue
            if x.lag not in late_by:
                late_by[x.lag] = _Late(omega, self._valued(x.lag, powers))
            own = late_by[x.lag]
            late = number * own.lag
            if not expanded:
                add_to(parts, x.power, number * own.cosine, C, S)
                add_to(parts, x.power + 1, late * own.sinc, S, -C)
                continue
            # cos a = 1 - a^2/2 sinc(a/2)^2, and sinc a = 1 + a^2 (sinc a - 1)/a^2.
            half = own.angle.times(0.5).sinc()
            rest_of_cosine = late * own.lag * half * half
            rest_of_sine = late * own.lag * own.lag * bent_sinc(own.angle)
            add_to(parts, x.power, number, C, S)
            add_to(parts, x.power + 2, rest_of_cosine.times(-0.5), C, S)
            add_to(parts, x.power + 1, late, S, -C)
            add_to(parts, x.power + 3, rest_of_sine, S, -C)
        return parts

    def _valued(self, form: Expr, powers: ModelPowers) -> TaylorModel:
        """A number or a delay over cells of the parameter, of which the powers are known."""
        if form not in self._rows_of:
            self._rows_of[form] = self._row_of(form)
        row = self._rows_of[form]
        q = powers.x
        if row is None:
            return valued(form, {self.symbol: q}, q)
        terms = [powers(n).times(c) if n else q.number(c) for n, c in row]
        return sum(terms[1:], terms[0]) if terms else q.number(0.0)

    def _row_of(self, form: Expr) -> list[tuple[Integer, float]] | None:
        """The coefficients of a number or delay by powers of the parameter, those that are not 0;
        None where it is no polynomial."""
        if not form.is_polynomial(self.symbol):
            return None
        ascending = Poly(form, self.symbol).all_coeffs()[::-1]
        return [(Integer(n), floated(c)) for n, c in enumerate(ascending) if c != 0]

    @cached_property
    def _rows_of(self) -> dict[Expr, list[tuple[Integer, float]] | None]:
        """What ``_row_of`` gives, once for each number and delay, as they are asked for."""
        return {}

    def _reach(self, q: Span, place: tuple[TaylorModel, TaylorModel] | None = None) -> float | None:
        """A frequency from which on Im H > 0 for all values of a range; None where that is not
        shown. ``place`` : frequency and value, where they are made already.

        Terms without a delay are known, delayed ones by their size alone: beyond the frequency the
        known coefficient of the highest power outweighs all others together, whatever the phases.
        """
        omega, value = place or variables(np.array([[[0.0, 0.0], q]]))
        # For N and for D: the undelayed terms and their sizes, and the sizes of the delayed terms,
        # by powers of omega.
        undelayed: list[Parts] = []
        sizes: list[dict[Expr, float]] = []
        delayed: list[dict[Expr, float]] = []
        for row in self._rows:
            early = [x for x in row if x.lag == 0]
            parts = self._parts(early, omega, value, expanded=False)
            undelayed.append(parts)
            sizes.append({p: sum(size_of(y) for y in pair if y) for p, pair in parts.items()})
            late: dict[Expr, float] = {}
            for x in row:
                if x.lag != 0:
                    size = size_of(self._valued(x.number, ModelPowers(value)))
                    late[x.power] = late.get(x.power, 0.0) + size
            delayed.append(late)
        known = imaginary(*undelayed)
        # Every product that holds a delayed factor counts by its size: undelayed times delayed,
        # both ways, and delayed times delayed.
        doubt: dict[Expr, float] = {}
        of_above, of_below = sizes
        late_above, late_below = delayed
        pairs = (of_above, late_below), (late_above, of_below), (late_above, late_below)
        for one, other in pairs:
            for p, a in one.items():
                for n, b in other.items():
                    before = doubt.get(p + n, 0.0)
                    doubt[p + n] = before + a * b
        powers = sorted({*known, *doubt})
        low = {p: ends_of(model)[0] - doubt.get(p, 0.0) for p, model in known.items()}
        may_vanish = low.get(powers[-1], 1.0) <= 0
        if may_vanish and self._ends_upward(powers[-1], q):
            # It may vanish but is nowhere negative: the power below it must outweigh the rest.
            powers.pop()
        if not powers or powers[-1] not in known:
            return None
        *lower, top = powers
        least = low[top]
        # The sizes of all other powers, and by how much less they grow than the highest.
        rest = []
        for p in lower:
            size = doubt.get(p, 0.0)
            if p in known:
                size += size_of(known[p])
            rest.append((size, floated(p - top)))
        radius = 2.0**-20
        while radius < _FARTHEST and least > 0:
            # Relative to the highest power all others fall with omega: what holds at the radius
            # holds beyond it.
            others_there = sum(size * radius**power for size, power in rest)
            if least * (1 - 1e-9) > others_there * (1 + 1e-9):
                return radius
            radius *= 2
        return None

    def _ends_upward(self, top: Expr, q: Span) -> bool:
        """Whether the coefficient of the highest power is proven nowhere negative for values of a
        range, at the ends of which it may vanish."""
        if self.far is None:
            return False
        power, coefficient = self.far
        if power != top:
            return False
        low, high = map(Rational, q)
        sign = coefficient.at(low) if low == high else coefficient.between(low, high)
        return sign is not None and sign >= 0

    def _turns(self, q: Span) -> float:
        """A frequency, rad/s, at which the longest delay has made about three turns, where nothing
        settles the sign far out."""
        known = {self.symbol: Rational((q[0] + q[1]) / 2)}
        delays = [x.lag for row in self._rows for x in row if x.lag != 0]
        lags = [floated(lag.xreplace(known)) for lag in delays]
        longest = max([x for x in lags if x > 0], default=1.0)
        return 20 / longest
