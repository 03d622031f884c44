"""Where a loop meets the imaginary axis, whatever its open number stands in: branch and bound over frequency and value.

In windows about a value that grow, cells are left out where C(j omega; q) is nowhere 0, proven in Taylor models. In the others
Newton's step in balls proves that there is just one pair of frequency and value. What is neither is a gap.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from fractions import Fraction
from functools import cached_property

import numpy as np
from flint import arb
from sympy import Expr, Integer, Rational

from haptisym.kernel.errors import UndecidedError
from haptisym.kernel.reals import Ball, ExactNumber, RealNumber, expression_ball
from haptisym.kernel.subdivision import Waiting
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.taylormodels import Array, halves
from haptisym.verbs.stability.held import need_roots
from haptisym.verbs.stability.loops import Characteristic, Gap, Loop, Meeting, Meetings, Pair, reach_of_axis

_WINDOWS = 7
_SMALLEST = Rational(1, 1024)  # as what a value of 0 counts for the first window
_MOST_CELLS, _DEEPEST = 80_000, 60  # of one strip of values, and how often one is cut
_MOST_STRIPS, _THINNEST = 128, 64  # parts of a strip, where a bound on the frequency is not known
_COLUMNS = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 64)])
_NEAR, _STRAIGHT, _WIDER = (
    1.6,
    0.05,
    3.0,
)  # in halves of a cell: how far a pair is off, C bends, and the proof's box goes
_ROUNDING = 1e-14  # in shares
_MOST_TURNING = 2000  # radians
_BITS = 96

_LEFT = "where roots meet the imaginary axis, as a search left it open"
_FAR = "where roots meet the imaginary axis, as their frequencies have no known bound"
_BEYOND = "where roots meet the imaginary axis, as no search went there"


def searched(loop: Loop, value: Expr, reason: str) -> Iterator[Meetings]:
    """All of them in windows about a value, but for those in gaps. UndecidedError, for a ``reason``, where they have no bound."""
    need_roots(loop.top, loop.ring)
    form, start = Characteristic(loop), Rational(f"{float(value):.3g}")
    found = [Meeting(x, ExactNumber(Integer(0))) for x in form.at_0()]
    gaps: list[Gap] = []
    ends = [_end(loop, start, side, 0) for side in (-1, 1)]
    if _Cells(form, *(start + (x - start) / _THINNEST for x in ends)).axis.reach is None:
        raise UndecidedError(reason)
    strips = [(ends[0], ends[1])]
    for j in range(1, _WINDOWS + 1):
        for strip in strips:
            pairs, left = _in_strip(form, *strip)
            found, gaps = [*found, *pairs], [*gaps, *left]
        yield Meetings(tuple(found), ends[0], ends[1], tuple(gaps))
        strips = []
        for i, side in enumerate((-1, 1)):
            further = _end(loop, start, side, j)
            if j < _WINDOWS and further != ends[i] and not any(_ends(gap)[i] == ends[i] for gap in gaps):
                strips.append((further, ends[i]) if side < 0 else (ends[i], further))
                ends[i] = further
    low, high = (None if x is None else ExactNumber(x) for x in (loop.low, loop.high))
    gaps += [] if ends[0] == loop.low else [Gap(low, ExactNumber(ends[0]), _BEYOND)]
    gaps += [] if ends[1] == loop.high else [Gap(ExactNumber(ends[1]), high, _BEYOND)]
    yield Meetings(tuple(found), loop.low, loop.high, tuple(gaps))


def _end(loop: Loop, start: Rational, side: int, j: int) -> Rational:
    """Of the j-th window, on one side: four times as far as the one before it, or as near to what is allowed."""
    last = loop.low if side < 0 else loop.high
    if last is None:
        return start + side * (abs(start) * Rational(4) ** (j - 1) or _SMALLEST * Rational(64) ** j)
    return last if j + 1 >= _WINDOWS else last + (start - last) * Rational(3, 4) / 4**j


def _gap(low: Expr, high: Expr, reason: str) -> Gap:
    return Gap(ExactNumber(low), ExactNumber(high), reason)


def _ends(gap: Gap) -> tuple[Expr, Expr]:
    """Of one that is bounded by exact numbers, as all of these are."""
    assert isinstance(gap.low, ExactNumber)
    assert isinstance(gap.high, ExactNumber)
    return gap.low.value, gap.high.value


def _in_strip(form: Characteristic, low: Rational, high: Rational) -> tuple[list[Meeting], list[Gap]]:
    """Of values from one to another: cut where the highest power of s prevails for some of them alone."""
    found: list[Meeting] = []
    gaps: list[Gap] = []
    waiting = Waiting([(low, high)], most=_MOST_STRIPS, what="intervals of values")
    for a, b in waiting:
        cells = _Cells(form, a, b)
        if cells.axis.reach is not None:
            gaps += cells.settle()
            found += cells.found
        elif b - a > (high - low) / _THINNEST:
            waiting.add((a, (a + b) / 2), ((a + b) / 2, b))
        else:
            gaps.append(_gap(a, b, _FAR))
    return found, _joined([*gaps, *(_gap(a, b, _FAR) for a, b in waiting.rest)])


def _joined(gaps: list[Gap]) -> list[Gap]:
    """Those that touch as one."""
    found: list[Gap] = []
    for gap in sorted(gaps, key=_ends):
        low, high = _ends(gap)
        if found and low <= (last := _ends(found[-1]))[1]:
            found[-1] = _gap(last[0], max(last[1], high), found[-1].reason)
        else:
            found.append(gap)
    return found


class _Cells:
    """Cells of frequency and value, as shares of what is looked at (cells, 2, 2)."""

    def __init__(self, form: Characteristic, low: Rational, high: Rational) -> None:
        self.form, self.low, self.high = form, low, high
        loop = form.loop
        polynomial = loop.top / loop.ring.variable**form.shared
        self.axis = OnAxis(loop.ring, polynomial, {loop.symbol: (low, high)})
        if self.axis.reach is None and not loop.turns:  # it takes phases as if all of them could oppose
            radius = reach_of_axis(loop).radius(
                expression_ball(low).union(expression_ball(high)), _MOST_TURNING, inverse=False
            )
            self.axis.reach = None if radius is None else float(radius) * (1 + _ROUNDING)
        self.found: list[Meeting] = []
        self._known: list[tuple[Array, Array]] = []
        """Middle and size of each box that holds one pair."""

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        """Where shares begin, and what one is."""
        return np.array([0.0, float(self.low)]), np.array([self.axis.reach, float(self.high - self.low)])

    @cached_property
    def _lost(self) -> Array:
        """More than any rounding of these."""
        start, size = self._scale
        return _ROUNDING * (abs(start) + size)

    def settle(self) -> list[Gap]:
        """Find all pairs; values in cells that are left are in gaps."""
        start = np.zeros((len(_COLUMNS) - 1, 2, 2))
        start[:, 0, 0], start[:, 0, 1], start[:, 1, 1] = _COLUMNS[:-1], _COLUMNS[1:], 1.0
        looked, waiting = 0, Waiting([start], most=_DEEPEST, what="times that cells of frequency and value are cut")
        for cells in waiting:
            looked += len(cells)
            if looked > _MOST_CELLS:
                break
            clear, rates = self.axis.bounded(cells)
            cells, rates = cells[~clear], rates[~clear]
            self._prove(cells)
            open_ones = ~self._is_settled(cells)
            if open_ones.any():
                waiting.add(halves(cells[open_ones], np.argmax(rates[open_ones], -1)))
        width = self.high - self.low
        left = {tuple(map(Fraction, cell[1])) for cells in waiting.rest for cell in cells}
        return [_gap(self.low + width * Rational(a), self.low + width * Rational(b), _LEFT) for a, b in left]

    def _box(self, cells: Array) -> tuple[Array, Array]:
        """Middles of cells in rad/s and as values, and halves of them with what was lost by rounding."""
        start, size = self._scale
        half = size * (cells[:, :, 1] - cells[:, :, 0]) / 2
        return start + size * cells.mean(-1), half + self._lost

    def _is_settled(self, cells: Array) -> Array:
        """Whether a cell lies in a box with a known pair, or beside omega = 0 and holds none."""
        middle, half = self._box(cells)
        found = np.zeros(len(cells), bool)
        for box in self._known:
            found |= _inside(middle, half, *box)
        for i in np.flatnonzero(~found & (cells[:, 0, 0] == 0)):
            found[i] = self.form.is_clear_at_0(*_balls(middle[i], half[i]))
        return found

    def _prove(self, cells: Array) -> None:
        """Try Newton's step about where a cell, C being nearly straight in it, may hold a pair."""
        middle, half = self._box(cells)
        for i, t in self._likely(cells):
            if any(_inside(middle[i], half[i], *box) for box in self._known):
                continue
            box = middle[i] + t * half[i], _WIDER * half[i]
            pair = self.form.only(*_balls(*box))
            if pair is not None and (value := self._value(pair)) is not None:
                place = np.array([float(x.mid()) for x in pair.at(_BITS)])
                if not any(_inside(place, self._lost, *known) for known in self._known):
                    self.found.append(Meeting(value, pair.frequency))
                self._known.append(box)

    def _value(self, pair: Pair) -> RealNumber | None:
        """Of the open number; where it looks like 0 only if it is proven to be."""
        omega, q = pair.at(_BITS)
        if not q.contains(0):
            return pair.value
        with suppress(UndecidedError):
            if any(omega.contains(x.ball(2 * _BITS)) for x in self.form.loop.at(Integer(0)).on_axis):
                return ExactNumber(Integer(0))
        return None

    def _likely(self, cells: Array) -> Iterator[tuple[int, Array]]:
        """Cells with the place, in halves of it from its middle, where C would be 0 if it were straight."""
        parts = self.axis.parts(cells)
        slopes = np.stack([x.c1[:, 0] for x in parts], 1)
        values = np.stack([x.c0[:, 0] for x in parts], 1)
        bends = np.stack([abs(x.c2[:, 0]).sum((-1, -2)) + x.r[:, 0] for x in parts], 1)
        with np.errstate(all="ignore"):
            (a, b), (c, d) = slopes[:, 0].T, slopes[:, 1].T
            inverse = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], 1) / (a * d - b * c)[:, None, None]
            t = -np.einsum("nij,nj->ni", inverse, values)
            bent = np.einsum("nij,nj->ni", abs(inverse), bends)
        for i in np.flatnonzero((abs(t) < _NEAR).all(-1) & (bent < _STRAIGHT).all(-1)):
            yield int(i), t[i]


def _inside(middle: Array, half: Array, center: Array, size: Array) -> Array:
    """Whether cells lie in a box."""
    return (abs(middle - center) + half <= size).all(-1)


def _balls(middle: Array, half: Array) -> tuple[Ball, Ball]:
    omega, q = (arb(float(m), float(h)) for m, h in zip(middle, half, strict=True))
    return omega, q
