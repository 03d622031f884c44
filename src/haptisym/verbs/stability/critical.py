"""The critical values of a parameter q: those that put roots of a display in a hand on the
imaginary axis, all of them but in intervals that are named as open.

*By elimination*, where C(j omega; q) = 0 can be solved for q: the critical values are then the
zeros of one function of omega (``loops`` has the forms of it), up to a frequency beyond which its
sign is proven. *By search*, where it cannot: over cells of frequency and value, in windows about
the present value that grow. A cell is left out where C is nowhere 0 on it, proven in Taylor models
in floats; in the others interval Newton in balls proves that there is just one pair. What is
neither, down to small cells, is open. Begin with ``meetings``.
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
# What a value of 0 counts as for the size of the first window, which is relative to the value.
_SMALLEST = Rational(1, 1024)
# Cells of one strip of values, and how often one is cut.
_MOST_CELLS, _DEEPEST = 80_000, 60
# Part of the first window for which a bound on the frequency must be known, or nothing is told.
_THINNEST = 64
# In halves of a cell: how far off its middle a pair may be guessed, how much C bends at most where
# one is guessed, and how far the proof's box goes. Beyond the cell, so that a pair on its edge
# lies well inside the box.
_NEAR, _STRAIGHT, _WIDER = 1.6, 0.05, 3.0
# More than the rounding of a float, 1.1e-16, in some operations on shares of a range.
_ROUNDING = 1e-14
_BITS = 96

_LEFT = "where roots meet the imaginary axis: the search was not fine enough"
_FAR = "where roots meet the imaginary axis: no bound on their frequencies is known"
_BEYOND = "values further out are not tested"


def searched(loop: Loop, value: Expr, asked: Domain, reason: str) -> Iterator[CriticalValues]:
    """The critical values by search, in windows about a value that grow; each yield holds those
    before it.

    UndecidedError, for a ``reason``, where the frequencies of roots have no bound even for values
    next to the present one.
    """
    need_roots(loop.top, loop.ring)
    form, start = Characteristic(loop), Rational(f"{float(value):.3g}")
    found = [Meeting(x, omega=ExactNumber(Integer(0))) for x in form.at_0()]
    left: list[Open] = []
    ends = [_end(asked, start, side, 0) for side in (-1, 1)]
    if _Cells(form, *(start + (x - start) / _THINNEST for x in ends)).axis.reach is None:
        raise UndecidedError(reason)
    # Of a larger window only the strips on both sides are new.
    strips = [(ends[0], ends[1])]
    for j in range(1, _WINDOWS + 1):
        for strip in strips:
            cells = _Cells(form, *strip)
            left += [_open(*strip, _FAR)] if cells.axis.reach is None else _joined(cells.settle())
            found += cells.found
        yield CriticalValues(tuple(found), (*left, *_outside(ends, asked)))
        strips = []
        for i, side in enumerate((-1, 1)):
            # Not on a side on which the last window stayed open at its very end.
            further = _end(asked, start, side, j)
            if (
                j < _WINDOWS
                and further != ends[i]
                and not any(_ends(x)[i] == ends[i] for x in left)
            ):
                strips.append((further, ends[i]) if side < 0 else (ends[i], further))
                ends[i] = further


def _outside(ends: Sequence[Rational], asked: Domain) -> Iterator[Open]:
    """The values that are asked about beyond a window, as open."""
    low, high = map(ExactNumber, ends)
    if asked.low != ends[0]:
        yield Open(None, low, _BEYOND)
    if asked.high != ends[1]:
        yield Open(high, None, _BEYOND)


def _end(asked: Domain, start: Rational, side: int, j: int) -> Rational:
    """The end of the j-th window on one side: four times as far off as that of the one before it;
    where the range asked about has an end, a quarter as far from that."""
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
    """The two ends of an open interval; both are exact in this module."""
    assert isinstance(x.low, ExactNumber)
    assert isinstance(x.high, ExactNumber)
    return x.low.value, x.high.value


def _joined(parts: list[Open]) -> list[Open]:
    """The open intervals, those that touch as one."""
    runs: list[Open] = []
    for part in sorted(parts, key=_ends):
        low, high = _ends(part)
        if runs and low <= (last := _ends(runs[-1]))[1]:
            runs[-1] = _open(last[0], max(last[1], high), runs[-1].reason)
        else:
            runs.append(part)
    return runs


class _Cells:
    """The search over frequency and value in one strip of values, ``low`` to ``high``.

    Cells are arrays (cells, 2, 2) of shares, of the frequencies up to the bound beyond which there
    are no roots, and of the strip. ``found`` : the critical values that are proven by now.
    """

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
        """Frequency and value at a share of 0, rad/s and as q, and how far the whole reaches."""
        return np.array([0.0, float(self.low)]), np.array(
            [self.axis.reach, float(self.high - self.low)]
        )

    @cached_property
    def _lost(self) -> Array:
        """A bound, in rad/s and as q, on what rounding takes from the ends of a cell."""
        start, size = self._scale
        return _ROUNDING * (abs(start) + size)

    def settle(self) -> list[Open]:
        """Find all pairs of the strip in ``found``; return as open the values of the cells that are
        left."""
        # By factors: roots may lie many decades below the bound on their frequencies.
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
            # A pair that is proven here settles cells at once, of this pass as well.
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
        """The middles of cells in rad/s and as q, and their half widths, with what was lost by
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
        # Beside omega = 0, where C may vanish to a high order, neither models nor Newton's step
        # decide.
        for i in np.flatnonzero(~found & (cells[:, 0, 0] == 0)):
            found[i] = self.form.is_clear_at_0(*_balls(middle[i], half[i]))
        return found

    def _prove(self, cells: Array, likely: Iterable[tuple[int, Array]]) -> None:
        """Try interval Newton on a box about each place where a cell is likely to hold a pair."""
        middle, half = self._box(cells)
        for i, t in likely:
            if _inside(middle[i], half[i], *self._known).any():
                continue
            box = middle[i] + t * half[i], _WIDER * half[i]
            pair = self.form.only(*_balls(*box))
            if pair is not None and (value := self._value(pair)) is not None:
                place = np.array([float(x.mid()) for x in pair.at(_BITS)])
                # Boxes overlap: a pair in one that is known was found before.
                if not _inside(place, self._lost, *self._known).any():
                    self.found.append(Meeting(value, omega=pair.frequency))
                self._known = np.concatenate([self._known, np.array(box)[:, None]], 1)

    def _value(self, pair: Pair) -> RealNumber | None:
        """The value q of a pair; None where a ball about it holds 0 and it is not proven to be
        0."""
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
        """The cells, of some, in which C is nearly linear and would be 0 near by, and where: in
        halves of the cell from its middle.

        A guess that costs little, one Newton step in floats on the models: C is values + slopes t,
        and the rest, ``bends``, changes t by ``shift`` at most.
        """
        values = np.stack([x.c0[:, 0] for x in parts], 1)
        curvatures = [abs(x.c2[:, 0]).sum((-1, -2)) for x in parts]
        bends = np.stack([c2 + x.r[:, 0] for c2, x in zip(curvatures, parts, strict=True)], 1)
        # Where the slopes are singular all is inf or nan, which is not near.
        with np.errstate(all="ignore"):
            (a, b), (c, d) = (x.c1[:, 0].T for x in parts)
            first, second = np.stack([d, -b], -1), np.stack([-c, a], -1)
            determinant = a * d - b * c
            inverse = np.stack([first, second], 1) / determinant[:, None, None]
            t = -np.einsum("nij,nj->ni", inverse, values)
            shift = np.einsum("nij,nj->ni", abs(inverse), bends)
        is_near = (abs(t) < _NEAR).all(-1)
        is_straight = (shift < _STRAIGHT).all(-1)
        for i in np.flatnonzero(among & is_near & is_straight):
            yield int(i), t[i]


def _inside(middle: Array, half: Array, center: Array, size: Array) -> Array:
    """Whether cells lie in a box; all by middles and half widths."""
    return (abs(middle - center) + half <= size).all(-1)


def _balls(middle: Array, half: Array) -> tuple[Ball, Ball]:
    omega, q = (arb(float(m), float(h)) for m, h in zip(middle, half, strict=True))
    return omega, q


_WINDOWS_OF_CURVE = 12
# Phase of a delay, rad, at the frequency up to which roots are looked for one by one.
_MOST_TURNING = 400
# The lower end of the first two windows, as shares of the value; then each is a quarter of that
# before it.
_LOWS = (Rational(15, 16), Rational(1, 2))
_SETTLED = (Sense.POSITIVE, Sense.NEGATIVE)


def meetings(loop: Loop, value: Expr, asked: Domain) -> Iterator[CriticalValues]:
    """The critical values of a loop's parameter: all of them at once, or again and again in windows
    about a value that grow.

    By one equation in omega where that decides, else by a search over frequency and value. Each
    yield replaces the one before. UndecidedError where nothing more is known.
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
        # What was told by elimination must not be replaced by less: the search comes in its place
        # only where it told nothing.
        if is_begun:
            raise
        yield from searched(loop, value, asked, str(error))


def _eliminated(loop: Loop, value: Expr) -> Iterator[CriticalValues]:
    """The critical values by one equation in omega. UndecidedError where there is none that
    decides."""
    # Passive parts in a hand that damps: only at 0 can a root lie, for any q > 0. Without delays
    # none comes from infinity into Re s >= 0 either.
    if loop.rests and not loop.ring.lags:
        yield CriticalValues(at_0(loop))
        return
    found = from_infinity(loop)
    if loop.turns:
        yield _of_a_delay(loop, value, found)
        return
    # With delays in the highest power of s a chain of roots may lie on the right for all values of
    # an interval: critical values are looked for in the others.
    clear: list[Open] | None = None
    if any(any(turns) for turns in loop.leading):
        ends = (ExactNumber(x) for x in (loop.low, loop.high) if x is not None)
        found += tuple(Meeting(x) for x in ends)  # at an end alone what is delayed may be lost
        clear = [Open(a, b, ENDLESS) for a, b in clear_of_chains(loop, found)]
    found += at_0(loop)
    if loop.rests or (curve := curve_of(loop)) is None:
        yield CriticalValues(found)
        return
    # A/B is real on all of the axis and does not change: one value alone puts roots there.
    if curve.condition.is_zero:
        alone = ValueAt(RealFunction(curve.value.reduced()), ExactNumber(Integer(1)))
        yield CriticalValues((*found, Meeting(alone)))
        return
    # Beyond the radius of a settled sign the condition is nowhere 0: all its zeros are found below
    # it.
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
    """The critical values in one interval after the other that no chain reaches, the one about a
    value first."""
    here = ExactNumber(value)
    # False sorts before True: the interval that covers the value comes first.
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
    """The critical values of a q that is a delay, or a power of s."""
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
    """The frequency up to which to look, at least 1 rad/s; UndecidedError where delays turn too
    often on the way."""
    if any(float(radius * lag) > _MOST_TURNING for lag in loop.ring.lags):
        raise UndecidedError("where roots meet the imaginary axis: its delays turn very often")
    return max(radius, Integer(1))


def _windows(
    loop: Loop, curve: CrossingCurve, value: Expr, found: Sequence[Meeting]
) -> Iterator[CriticalValues]:
    """The critical values where roots meet the axis at ever higher frequencies: in windows about a
    value that grow.

    Let the square of q on the axis be proven larger than end^2 beyond some frequency, or smaller.
    Then all critical values of less (or greater) size than end lie below that frequency, where they
    are found one by one.
    """
    reach, low, high = Integer(0), None, None
    for j in range(_WINDOWS_OF_CURVE):
        further = abs(value) + (1 + abs(value)) * Rational(4) ** (j - 2)
        nearer = value * _LOWS[min(j, 1)] / 4 ** max(j - 1, 0)
        for end, sense in ((further, Sense.POSITIVE), (nearer, Sense.NEGATIVE)):
            # The square, as its sign is settled far out where that of q itself swings with the
            # delay's phase.
            ahead = asymptotic_sign(minus(curve.square, end**2))
            if ahead.sense is sense and end > 0:
                reach = max(reach, _near(ahead.radius, loop))
                high, low = (end, low) if sense is Sense.POSITIVE else (high, end)
        if high is not None or low is not None:
            # A bound by size alone has both signs: values are known from -high to high, or from low
            # upward.
            least = low if high is None else -high
            left = [Open(None, ExactNumber(least), ENDLESS)]
            if low is None:
                left.append(Open(ExactNumber(high), None, ENDLESS))
            yield CriticalValues((*found, *curve.meetings(reach)), left)
    if high is None and low is None:
        raise UndecidedError(ENDLESS)


def _has_chain(loop: Loop, value: Expr) -> bool:
    """Whether infinitely many roots lie on the right, or come to the axis, at a delay > 0.

    The zeros of L(z), z = exp(-s tau), do not depend on tau: it is so at all of them, or at none,
    and any delay will do where the value is 0 or not rational. False also where it is undecided.
    """
    with suppress(UndecidedError):
        delay = Rational(value) if value.is_Rational and value else Integer(1)
        return loop.at(delay).chain is not None
    return False
