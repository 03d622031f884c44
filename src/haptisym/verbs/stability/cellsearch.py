"""Critical values of a free parameter q by search over cells of frequency and q, for loops of any
form.

Sought are all pairs (omega, q) with C(j omega; q) = 0, C being the characteristic function of the
loop (``loops``). A *window* is an interval of q about the present value. In it omega goes from 0 to
a bound above which no q of the window has a root on the axis (``programs.onaxis``); without such a
bound nothing is searched. The rectangle is cut into cells, and each cell is settled in one of three
ways:

- C is nowhere 0 on it, proven by Taylor models, polynomials with an error bound, in floats;
- it lies in a box for which interval Newton, in balls, proves that there is just one pair
  (``characteristic``), which is then a result;
- it lies at omega = 0, and no pair is proven to be there.

A cell that is none of these is cut in two. Cells that are left when too many were examined, or when
they were cut too often, are returned as open intervals of q: all critical values of a window are
among those returned but for these. Windows grow, and of each only the strips are new that the one
before did not have.

Begin with ``search``. ``Strip`` is one interval of q and its cells; ``Strip.settle`` is the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from functools import cached_property

from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.arrays import np
from haptisym.kernel.budget import Waiting
from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber
from haptisym.kernel.sets import CriticalValues, Domain, Open
from haptisym.kernel.where import Array, halves
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.taylormodels import TaylorModel
from haptisym.verbs.stability.characteristic import Characteristic, Pair
from haptisym.verbs.stability.held import need_roots
from haptisym.verbs.stability.loops import CriticalRoot, Loop

# Windows at most. Each reaches four times as far as the one before: the last one 4^5 times the
# value, or, for a value of 0, 64^6/1024, about 7e7.
_WINDOWS = 7
# What a value of 0 counts as for the size of the first window, which is relative to the value.
_SIZE_OF_0 = Rational(1, 1024)
# The part of the first window, one over this, for which a bound on omega must be known; without it
# no window would have one, and nothing is returned.
_PART_TRIED_FIRST = 64
# Cells of one strip that are examined, and how often one is cut: more takes minutes.
_MOST_CELLS, _MOST_CUTS = 80_000, 60
# The first cells reach in omega from 0 to _FIRST of the bound, and from there to it by _COLUMNS - 1
# equal factors, as roots may lie many decades below the bound.
_FIRST, _COLUMNS = 1e-4, 64
# When a Newton step in floats suggests a pair, in half widths of the cell: how far from its middle,
# how much the curvature of C may change that at most, and how far the box of the proof reaches. It
# reaches beyond the cell, so that a pair on its edge lies well inside of the box.
_FARTHEST, _MOST_SHIFT, _BOX = 1.6, 0.05, 3.0
# More than the rounding of a float, 1.1e-16, in some operations on shares of a range.
_ROUNDING = 1e-14
# Precision, bits, of the numbers of a pair that are compared with boxes and with 0.
_BITS = 96

_NOT_FINE_ENOUGH = "where roots meet the imaginary axis: the search was not fine enough"
_NO_BOUND = "where roots meet the imaginary axis: no bound on their frequencies is known"
NOT_TESTED = "values further out are not tested"
"""The reason of an open interval beyond the values that were searched."""


def search(loop: Loop, value: Expr, domain: Domain, reason: str) -> Iterator[CriticalValues]:
    """The critical values in windows about ``value`` that grow within ``domain``; each yield
    replaces the one before.

    UndecidedError, with ``reason``, where no bound on omega is known even next to the value.
    """
    need_roots(loop.numerator, loop.ring)
    C, at_0 = Characteristic(loop), ExactNumber(Integer(0))
    roots = [CriticalRoot(q, omega=at_0) for q in C.at_0()]
    start = Rational(f"{float(value):.3g}")
    open_intervals: list[Open] = []
    low, high = (_end(domain, start, side, 0) for side in (-1, 1))
    near = (start + (end - start) / _PART_TRIED_FIRST for end in (low, high))
    if Strip(C, *near).on_axis.reach is None:
        raise UndecidedError(reason)
    strips = [(low, high)]
    for n in range(1, _WINDOWS + 1):
        for ends in strips:
            strip = Strip(C, *ends)
            if strip.on_axis.reach is None:
                open_intervals.append(_open(*ends, _NO_BOUND))
            else:
                open_intervals += _joined(strip.settle())
            roots += strip.roots
        outside = _outside(low, high, domain)
        yield CriticalValues(tuple(roots), (*open_intervals, *outside))
        if n == _WINDOWS:
            return
        # A window does not grow on a side on which it stayed open at its very end.
        strips = []
        lowest, highest = (_end(domain, start, side, n) for side in (-1, 1))
        open_lows = [_ends(x)[0] for x in open_intervals]
        open_highs = [_ends(x)[1] for x in open_intervals]
        if lowest != low and low not in open_lows:
            strips.append((lowest, low))
            low = lowest
        if highest != high and high not in open_highs:
            strips.append((high, highest))
            high = highest


def _end(domain: Domain, start: Rational, side: int, n: int) -> Rational:
    """The end on one side, -1 or 1, of the n-th window about ``start``, from 0 on: four times as
    far off as that of the one before; where the domain has an end, a quarter as far from that."""
    last = domain.low if side < 0 else domain.high
    distance = abs(start) * Rational(4) ** (n - 1)
    if not distance:
        distance = _SIZE_OF_0 * Rational(64) ** n
    end = start + side * distance
    if last is None or not last.is_Rational:
        return end
    if n + 1 >= _WINDOWS:
        return last
    near_last = last + (start - last) * Rational(3, 4) / 4**n
    return min(end, near_last) if side > 0 else max(end, near_last)


def _outside(low: Rational, high: Rational, domain: Domain) -> Iterator[Open]:
    """The values of the domain beyond a window, as open."""
    if domain.low != low:
        yield Open(None, ExactNumber(low), NOT_TESTED)
    if domain.high != high:
        yield Open(ExactNumber(high), None, NOT_TESTED)


def _open(low: Expr, high: Expr, reason: str) -> Open:
    return Open(ExactNumber(low), ExactNumber(high), reason)


def _ends(x: Open) -> tuple[Expr, Expr]:
    """The two ends of an open interval of a strip; both are exact there."""
    assert isinstance(x.low, ExactNumber)
    assert isinstance(x.high, ExactNumber)
    return x.low.value, x.high.value


def _joined(intervals: list[Open]) -> list[Open]:
    """Open intervals in ascending order, those that touch or overlap as one."""
    joined: list[Open] = []
    for interval in sorted(intervals, key=_ends):
        low, high = _ends(interval)
        if joined and low <= _ends(joined[-1])[1]:
            start, end = _ends(joined[-1])
            joined[-1] = _open(start, max(end, high), joined[-1].reason)
        else:
            joined.append(interval)
    return joined


class Strip:
    """The search over frequency and q in one interval of q, ``low`` to ``high``.

    Cells are arrays (cells, 2, 2): of each cell the two sides, omega and q, and of each side its
    low and its high end. Ends are shares, from 0 to 1, of the bound on omega and of the interval of
    q.

    ``on_axis`` : the Taylor models of C(j omega; q); its ``reach`` is the bound on omega, None
    where none is known. ``roots`` : the critical values that are proven by now.
    """

    def __init__(self, characteristic: Characteristic, low: Rational, high: Rational) -> None:
        self.characteristic, self.low, self.high = characteristic, low, high
        loop = characteristic.loop
        polynomial = loop.numerator / loop.ring.variable**characteristic.shared
        self.on_axis = OnAxis(loop.ring, polynomial, {loop.symbol: (low, high)})
        self.roots: list[CriticalRoot] = []
        # Middles (row 0) and half widths (row 1) of the boxes that hold exactly one pair, each in
        # rad/s and in q's unit.
        self._boxes = np.zeros((2, 0, 2))

    def settle(self) -> list[Open]:
        """Find all pairs, as ``roots``; return the values of q of the cells that are left."""
        edges = np.concatenate([[0.0], np.geomspace(_FIRST, 1.0, _COLUMNS)])
        columns = np.zeros((_COLUMNS, 2, 2))
        columns[:, 0, 0] = edges[:-1]
        columns[:, 0, 1] = edges[1:]
        columns[:, 1, 1] = 1.0
        examined = 0
        what = "times that cells of frequency and value are cut"
        waiting = Waiting([columns], most=_MOST_CUTS, what=what)
        for cells in waiting:
            examined += len(cells)
            if examined > _MOST_CELLS:
                break
            with np.errstate(all="ignore"):
                models = self.on_axis.parts(cells)
            is_nonzero, rates = self.on_axis.bounded(cells, models)
            # Pairs first: a box that is proven here settles cells of this pass as well.
            self._prove(cells, _suggested(models, ~is_nonzero))
            is_left = ~is_nonzero
            is_left[~is_nonzero] = ~self._is_settled(cells[~is_nonzero])
            if is_left.any():
                waiting.add(halves(cells[is_left], np.argmax(rates[is_left], -1)))
        width = self.high - self.low
        intervals = list[Open]()
        for first, last in _sides_in_q(waiting.rest):
            low = self.low + width * Rational(first)
            high = self.low + width * Rational(last)
            intervals.append(_open(low, high, _NOT_FINE_ENOUGH))
        return intervals

    # Cells in rad/s and in q's unit

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        """What a share of 0 stands for, as (omega, q), and how much a share of 1 stands for
        more."""
        start = np.array([0.0, float(self.low)])
        width = float(self.high - self.low)
        return start, np.array([self.on_axis.reach, width])

    @cached_property
    def _rounding(self) -> Array:
        """A bound on what rounding changes at the ends of a cell, as (omega, q)."""
        start, size = self._scale
        return _ROUNDING * (abs(start) + size)

    def _rectangles(self, cells: Array) -> tuple[Array, Array]:
        """The middles of cells and their half widths, widened by the rounding, each as (omega,
        q)."""
        start, size = self._scale
        low, high = cells[:, :, 0], cells[:, :, 1]
        half = size * (high - low) / 2
        return start + size * cells.mean(-1), half + self._rounding

    # Cells that are settled

    def _is_settled(self, cells: Array) -> Array:
        """Whether a cell lies in a box that holds one pair, or at omega = 0 and holds none."""
        middle, half = self._rectangles(cells)
        is_settled = np.zeros(len(cells), bool)
        for center, size in self._boxes.swapaxes(0, 1):
            is_settled |= _is_inside(middle, half, center, size)
        # At omega = 0, where C may have a zero of high order, neither models nor Newton decide.
        for i in np.flatnonzero(~is_settled & (cells[:, 0, 0] == 0)):
            box = _balls(middle[i], half[i])
            is_settled[i] = self.characteristic.has_no_pair_beside_0(*box)
        return is_settled

    def _prove(self, cells: Array, suggested: Iterable[tuple[int, Array]]) -> None:
        """Try interval Newton on a box about each suggested place: the number of a cell, and the
        place in half widths from its middle."""
        middle, half = self._rectangles(cells)
        for i, place in suggested:
            if _is_inside(middle[i], half[i], *self._boxes).any():
                continue
            center = middle[i] + place * half[i]
            size = _BOX * half[i]
            pair = self.characteristic.only_pair(*_balls(center, size))
            value = None if pair is None else self._value(pair)
            if pair is None or value is None:
                continue
            omega, q = pair.at(_BITS)
            numbers = np.array([float(omega.mid()), float(q.mid())])
            # Boxes overlap: a pair in one that is known was found before.
            if not _is_inside(numbers, self._rounding, *self._boxes).any():
                self.roots.append(CriticalRoot(value, omega=pair.frequency))
            box = np.array([center, size])[:, None]
            self._boxes = np.concatenate([self._boxes, box], 1)

    def _value(self, pair: Pair) -> RealNumber | None:
        """The value q of a pair, exactly 0 where that is proven; None where its ball holds 0 and it
        is not: its sign would not be known."""
        omega, q = pair.at(_BITS)
        if not q.contains(0):
            return pair.value
        with suppress(UndecidedError):
            at_q_0 = self.characteristic.loop.roots_at(Integer(0)).on_axis
            if any(omega.contains(x.ball(2 * _BITS)) for x in at_q_0):
                return ExactNumber(Integer(0))
        return None


def _sides_in_q(batches: Iterable[Array]) -> set[tuple[Fraction, ...]]:
    """The low and the high end, as shares, of the sides along q of cells, each once."""
    sides = set[tuple[Fraction, ...]]()
    for cells in batches:
        sides.update(tuple(map(Fraction, cell[1])) for cell in cells)
    return sides


def _suggested(
    models: tuple[TaylorModel, TaylorModel], among: Array
) -> Iterator[tuple[int, Array]]:
    """The numbers of the cells, of those ``among``, near which C seems to have a zero, and its
    place in half widths from the middle of the cell.

    A guess by one Newton step in floats, which proves nothing. On a cell, with t from -1 to 1 along
    each side, Re C and Im C are ``values`` + ``slopes`` t and a rest of at most ``bends``, which
    changes the step by ``shift`` at most.
    """
    values = np.stack([x.c0[:, 0] for x in models], 1)
    bends = np.stack([_bend(x) for x in models], 1)
    slopes_real, slopes_imag = (x.c1[:, 0].T for x in models)
    a, b = slopes_real
    c, d = slopes_imag
    # Where the slopes are singular all is inf or nan, which is not near.
    with np.errstate(all="ignore"):
        first = np.stack([d, -b], -1)
        second = np.stack([-c, a], -1)
        adjugate = np.stack([first, second], 1)
        determinant = a * d - b * c
        inverse = adjugate / determinant[:, None, None]
        step = -np.einsum("nij,nj->ni", inverse, values)
        shift = np.einsum("nij,nj->ni", abs(inverse), bends)
    is_near = (abs(step) < _FARTHEST).all(-1)
    is_straight = (shift < _MOST_SHIFT).all(-1)
    for i in np.flatnonzero(among & is_near & is_straight):
        yield int(i), step[i]


def _bend(model: TaylorModel) -> Array:
    """A bound, for each cell, on what a model of its value has beyond the linear terms."""
    curvature = abs(model.c2[:, 0]).sum((-1, -2))
    return curvature + model.r[:, 0]


def _is_inside(middle: Array, half: Array, center: Array, size: Array) -> Array:
    """Whether rectangles lie in a box; both by middles and half widths."""
    return (abs(middle - center) + half <= size).all(-1)


def _balls(middle: Array, half: Array) -> tuple[Ball, Ball]:
    """A rectangle as balls of omega and of q."""
    omega = arb(float(middle[0]), float(half[0]))
    q = arb(float(middle[1]), float(half[1]))
    return omega, q
