"""The values of a number that put roots of a display in a hand on the imaginary axis: all of them,
but in what is named as open.

One equation in omega tells them, where there is one. Where there is none they are searched over
frequency and value: in windows about a value that grow, cells are left out where C(j omega; q) is
nowhere 0, proven in Taylor models, and in the others Newton's step in balls proves that there is
just one pair. What is neither is open.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cached_property

from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.judge.peaks import ValueAt
from haptisym.kernel.arrays import np
from haptisym.kernel.asymptoticsign import Sense, asymptotic_sign
from haptisym.kernel.budget import Waiting
from haptisym.kernel.dynamics import RealFunction
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber
from haptisym.kernel.sets import CriticalValue, CriticalValues, Domain, Open
from haptisym.kernel.where import Array, halves
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.taylormodels import TaylorModel
from haptisym.verbs.stability.held import need_roots
from haptisym.verbs.stability.loops import (
    ENDLESS,
    BesideChains,
    Characteristic,
    CrossingCurve,
    Loop,
    Meeting,
    Pair,
    Switches,
    clear_of_chains,
    curve_of,
    from_infinity,
    minus,
)

_WINDOWS = 7
_SMALLEST = Rational(1, 1024)  # as what a value of 0 counts for the first window
_MOST_CELLS, _DEEPEST = 80_000, 60  # of one strip of values, and how often one is cut
_THINNEST = 64  # part of the first window, for which a bound on the frequency must be known
_NEAR, _STRAIGHT, _WIDER = 1.6, 0.05, 3.0
"""In halves of a cell: how far a pair is off, C bends, and the proof's box goes."""
_ROUNDING = 1e-14  # in shares
_BITS = 96

_LEFT = "where roots meet the imaginary axis: the search was not fine enough"
_FAR = "where roots meet the imaginary axis: no bound on their frequencies is known"
_BEYOND = "values further out are not tested"


def searched(loop: Loop, value: Expr, asked: Domain, reason: str) -> Iterator[CriticalValues]:
    """All of them in windows about a value, but for those in what is open.

    UndecidedError, for a ``reason``, where they have no bound.
    """
    need_roots(loop.top, loop.ring)
    form, start = Characteristic(loop), Rational(f"{float(value):.3g}")
    found = [Meeting(x, omega=ExactNumber(Integer(0))) for x in form.at_0()]
    left: list[Open] = []
    ends = [_end(asked, start, side, 0) for side in (-1, 1)]
    if _Cells(form, *(start + (x - start) / _THINNEST for x in ends)).axis.reach is None:
        raise UndecidedError(reason)
    strips = [(ends[0], ends[1])]
    for j in range(1, _WINDOWS + 1):
        for strip in strips:
            cells = _Cells(form, *strip)
            left += [_open(*strip, _FAR)] if cells.axis.reach is None else _joined(cells.settle())
            found += cells.found
        yield CriticalValues(tuple(found), (*left, *_outside(ends, asked)))
        strips = []
        for i, side in enumerate((-1, 1)):
            further = _end(asked, start, side, j)
            if (
                j < _WINDOWS
                and further != ends[i]
                and not any(_ends(x)[i] == ends[i] for x in left)
            ):
                strips.append((further, ends[i]) if side < 0 else (ends[i], further))
                ends[i] = further


def _outside(ends: Sequence[Rational], asked: Domain) -> Iterator[Open]:
    """What is asked about beyond a window."""
    low, high = map(ExactNumber, ends)
    if asked.low != ends[0]:
        yield Open(None, low, _BEYOND)
    if asked.high != ends[1]:
        yield Open(high, None, _BEYOND)


def _end(asked: Domain, start: Rational, side: int, j: int) -> Rational:
    """Of the j-th window, on one side: four times as far as the one before it, or as near to what
    is asked about."""
    last = asked.low if side < 0 else asked.high
    far = start + side * (abs(start) * Rational(4) ** (j - 1) or _SMALLEST * Rational(64) ** j)
    if last is None or not last.is_Rational:
        return far
    if j + 1 >= _WINDOWS:
        return last
    near = last + (start - last) * Rational(3, 4) / 4**j
    return min(far, near) if side > 0 else max(far, near)


def _open(low: Expr, high: Expr, reason: str) -> Open:
    return Open(ExactNumber(low), ExactNumber(high), reason)


def _ends(x: Open) -> tuple[Expr, Expr]:
    """Of one that is bounded by exact numbers, as all of these are."""
    assert isinstance(x.low, ExactNumber)
    assert isinstance(x.high, ExactNumber)
    return x.low.value, x.high.value


def _joined(parts: list[Open]) -> list[Open]:
    """Those that touch as one."""
    found: list[Open] = []
    for part in sorted(parts, key=_ends):
        low, high = _ends(part)
        if found and low <= (last := _ends(found[-1]))[1]:
            found[-1] = _open(last[0], max(last[1], high), found[-1].reason)
        else:
            found.append(part)
    return found


class _Cells:
    """Cells of frequency and value, as shares of what is looked at (cells, 2, 2)."""

    def __init__(self, form: Characteristic, low: Rational, high: Rational) -> None:
        self.form, self.low, self.high = form, low, high
        loop = form.loop
        polynomial = loop.top / loop.ring.variable**form.shared
        self.axis = OnAxis(loop.ring, polynomial, {loop.symbol: (low, high)})
        self.found: list[Meeting] = []
        self._known = np.zeros((2, 0, 2))
        """Middle and size of each box that holds one pair."""

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        """Where shares begin, and what one is."""
        return np.array([0.0, float(self.low)]), np.array(
            [self.axis.reach, float(self.high - self.low)]
        )

    @cached_property
    def _lost(self) -> Array:
        """More than any rounding of these."""
        start, size = self._scale
        return _ROUNDING * (abs(start) + size)

    def settle(self) -> list[Open]:
        """Find all pairs; values in cells that are left are open."""
        columns = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
        start = np.zeros((len(columns) - 1, 2, 2))
        start[:, 0, 0], start[:, 0, 1], start[:, 1, 1] = columns[:-1], columns[1:], 1.0
        looked, waiting = (
            0,
            Waiting([start], most=_DEEPEST, what="times that cells of frequency and value are cut"),
        )
        for part in waiting:
            looked += len(part)
            if looked > _MOST_CELLS:
                break
            with np.errstate(all="ignore"):
                parts = self.axis.parts(part)
            clear, rates = self.axis.bounded(part, parts)
            self._prove(part, self._likely(parts, ~clear))
            open_ones = ~clear
            open_ones[~clear] = ~self._is_settled(part[~clear])
            if open_ones.any():
                waiting.add(halves(part[open_ones], np.argmax(rates[open_ones], -1)))
        width = self.high - self.low
        left = {tuple(map(Fraction, cell[1])) for cells in waiting.rest for cell in cells}
        return [
            _open(self.low + width * Rational(a), self.low + width * Rational(b), _LEFT)
            for a, b in left
        ]

    def _box(self, cells: Array) -> tuple[Array, Array]:
        """Middles of cells in rad/s and as values, and halves of them with what was lost by
        rounding."""
        start, size = self._scale
        half = size * (cells[:, :, 1] - cells[:, :, 0]) / 2
        return start + size * cells.mean(-1), half + self._lost

    def _is_settled(self, cells: Array) -> Array:
        """Whether a cell lies in a box with a known pair, or beside omega = 0 and holds none."""
        middle, half = self._box(cells)
        found = np.zeros(len(cells), bool)
        for center, size in self._known.swapaxes(0, 1):
            found |= _inside(middle, half, center, size)
        for i in np.flatnonzero(~found & (cells[:, 0, 0] == 0)):
            found[i] = self.form.is_clear_at_0(*_balls(middle[i], half[i]))
        return found

    def _prove(self, cells: Array, likely: Iterable[tuple[int, Array]]) -> None:
        """Try Newton's step about where a cell may hold a pair."""
        middle, half = self._box(cells)
        for i, t in likely:
            if _inside(middle[i], half[i], *self._known).any():
                continue
            box = middle[i] + t * half[i], _WIDER * half[i]
            pair = self.form.only(*_balls(*box))
            if pair is not None and (value := self._value(pair)) is not None:
                place = np.array([float(x.mid()) for x in pair.at(_BITS)])
                if not _inside(place, self._lost, *self._known).any():
                    self.found.append(Meeting(value, omega=pair.frequency))
                self._known = np.concatenate([self._known, np.array(box)[:, None]], 1)

    def _value(self, pair: Pair) -> RealNumber | None:
        """Of the open number; where it looks like 0 only if it is proven to be."""
        omega, q = pair.at(_BITS)
        if not q.contains(0):
            return pair.value
        with suppress(UndecidedError):
            if any(
                omega.contains(x.ball(2 * _BITS)) for x in self.form.loop.at(Integer(0)).on_axis
            ):
                return ExactNumber(Integer(0))
        return None

    @staticmethod
    def _likely(
        parts: tuple[TaylorModel, TaylorModel], among: Array
    ) -> Iterator[tuple[int, Array]]:
        """Cells in which C is nearly straight, with the place, in halves of one from its middle,
        where C would then be 0."""
        slopes = np.stack([x.c1[:, 0] for x in parts], 1)
        values = np.stack([x.c0[:, 0] for x in parts], 1)
        bends = np.stack([abs(x.c2[:, 0]).sum((-1, -2)) + x.r[:, 0] for x in parts], 1)
        with np.errstate(all="ignore"):
            (a, b), (c, d) = slopes[:, 0].T, slopes[:, 1].T
            inverse = (
                np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], 1)
                / (a * d - b * c)[:, None, None]
            )
            t = -np.einsum("nij,nj->ni", inverse, values)
            bent = np.einsum("nij,nj->ni", abs(inverse), bends)
        for i in np.flatnonzero(among & (abs(t) < _NEAR).all(-1) & (bent < _STRAIGHT).all(-1)):
            yield int(i), t[i]


def _inside(middle: Array, half: Array, center: Array, size: Array) -> Array:
    """Whether cells lie in a box."""
    return (abs(middle - center) + half <= size).all(-1)


def _balls(middle: Array, half: Array) -> tuple[Ball, Ball]:
    omega, q = (arb(float(m), float(h)) for m, h in zip(middle, half, strict=True))
    return omega, q


_WINDOWS_OF_CURVE = 12
_MOST_TURNING = 400  # radians that a delay turns up to where roots are looked for
_LOWS = (Rational(15, 16), Rational(1, 2))
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


def meetings(loop: Loop, value: Expr, asked: Domain) -> Iterator[CriticalValues]:
    """Where an open number puts roots on the axis: all, or in windows that grow. UndecidedError
    where that is open.

    By one equation in omega as far as that goes; else by a search over both.
    """
    if not loop.moves:
        yield CriticalValues()
        return
    is_begun = False
    try:
        for window in _eliminated(loop, value):
            yield window
            is_begun = True
    except LimitError:
        raise
    except UndecidedError as error:
        if is_begun:
            raise
        yield from searched(loop, value, asked, str(error))


def _eliminated(loop: Loop, value: Expr) -> Iterator[CriticalValues]:
    """By one equation in omega."""
    if loop.rests and not loop.ring.lags:  # nor does a root come from infinity, or a chain
        yield CriticalValues(at_0(loop))
        return
    found = from_infinity(loop)
    if loop.turns:
        yield _of_a_delay(loop, value, found)
        return
    clear: list[Open] | None = None
    if any(any(turns) for turns in loop.leading):
        ends = (ExactNumber(x) for x in (loop.low, loop.high) if x is not None)
        found += tuple(Meeting(x) for x in ends)  # at an end alone what is delayed may be lost
        clear = [Open(a, b, ENDLESS) for a, b in clear_of_chains(loop, found)]
    found += at_0(loop)
    if loop.rests or (curve := curve_of(loop)) is None:
        yield CriticalValues(found)
        return
    if curve.condition.is_zero:  # one value alone puts roots there, everywhere
        alone = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield CriticalValues((*found, Meeting(alone)))
        return
    settled = asymptotic_sign(curve.condition)
    if settled.sense in _SETTLED:
        yield CriticalValues((*found, *curve.meetings(_near(settled.radius, loop))))
    elif clear is not None:
        yield from _beside_chains(loop, curve, value, found, clear)
    else:
        yield from _windows(loop, curve, value, found)


def _beside_chains(
    loop: Loop, curve: CrossingCurve, value: Expr, found: Sequence[Meeting], clear: Sequence[Open]
) -> Iterator[CriticalValues]:
    """In one interval after the other that no chain reaches, the one about a value first."""
    here = ExactNumber(value)
    left = sorted(clear, key=lambda x: not x.covers(here, here))
    values: Sequence[CriticalValue] = found
    yield CriticalValues(values, left)
    beside = BesideChains.of(loop)
    if beside is None or (left and left[0].low is None):
        if left and left[0].covers(here, here):
            yield from _windows(loop, curve, value, found)
        return
    for own in [x for x in left if x.low is not None]:
        assert own.low is not None
        others, known = [x for x in left if x is not own], CriticalValues()
        for known in beside.meetings(curve, own.low, own.high):
            yield CriticalValues((*values, *known.values), (*others, *known.open))
        values, left = (*values, *known.values), [*others, *known.open]


def _of_a_delay(loop: Loop, value: Expr, far_out: tuple[Meeting, ...]) -> CriticalValues:
    """Or of an order of s."""
    if _has_chain(loop, value):  # whatever the delay, as long as there is one
        return CriticalValues((*far_out, Meeting(ExactNumber(Integer(0)))))
    if loop.rests:
        return CriticalValues((*far_out, *at_0(loop)))
    found, last = Switches.of(loop).up_to(value)
    left = [] if last is None else [Open(ExactNumber(last), None, _BEYOND)]
    return CriticalValues((*far_out, *at_0(loop), *found), left)


def at_0(loop: Loop) -> tuple[Meeting, ...]:
    """The values that put a root at 0."""
    return tuple(Meeting(x, omega=ExactNumber(Integer(0))) for x in Characteristic(loop).at_0())


def _near(radius: Expr, loop: Loop) -> Expr:
    """How far to look; UndecidedError where delays turn too often on the way."""
    if any(float(radius * lag) > _MOST_TURNING for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _windows(
    loop: Loop, curve: CrossingCurve, value: Expr, found: Sequence[Meeting]
) -> Iterator[CriticalValues]:
    """Where frequencies never end: as far as values lie in a window, about the value that is asked
    about.

    Beyond some frequency all values on the axis are larger than one end of it, or all smaller than
    the other one.
    """
    reach, low, high = Integer(0), None, None
    for j in range(_WINDOWS_OF_CURVE):
        further = abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2)
        nearer = value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0)
        for end, sense in ((further, Sense.POSITIVE), (nearer, Sense.NEGATIVE)):
            ahead = asymptotic_sign(minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                reach = max(reach, _near(ahead.radius, loop))
                high, low = (end, low) if sense is Sense.POSITIVE else (high, end)
        if high is not None or low is not None:
            least = low if high is None else -high
            left = [Open(None, ExactNumber(least), ENDLESS)]
            if low is None:
                left.append(Open(ExactNumber(high), None, ENDLESS))
            yield CriticalValues((*found, *curve.meetings(reach)), left)
    if high is None and low is None:
        raise UndecidedError(ENDLESS)


# A delay that is open


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether infinitely many roots lie on the right, or come to the axis, at a delay > 0: at all
    of them, or at none."""
    with suppress(UndecidedError):
        return (
            loop.at(Rational(value) if value.is_Rational and value else Integer(1)).chain
            is not None
        )
    return False
