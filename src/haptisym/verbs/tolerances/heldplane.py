"""Held in a hand, all over the plane of two numbers: rectangles in which a display is stable for all values, or for none.

A rectangle is clear where the characteristic function is nowhere 0 on the imaginary axis (with a clock, on the unit circle), for
any of its values and any of what else varies. Clear rectangles that touch have one number of unstable roots, which is counted
exactly at one set of values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property

import numpy as np
from sympy import Expr, Rational, Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import HaptisymError, LimitError, UndecidedError
from haptisym.kernel.rings import Polynomial
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.clocked import clocked_roots
from haptisym.verbs.stability.oncircle import OnCircle
from haptisym.verbs.tolerances.clockplane import ClockPlane
from haptisym.verbs.tolerances.heldbox import count_at, quotient
from haptisym.verbs.tolerances.onaxis import OnAxis
from haptisym.verbs.tolerances.search import together

_FIRST_RECTANGLES, _FIRST_PIECES = 8, 48
"""Of each range, and of the frequencies, to begin with."""
_BATCH = 4096
_MOST_PIECES = 48  # of one rectangle before it is cut rather than they
_AT_LAST = 5  # times that pieces of the smallest ones are cut
_MOST_COUNTS = 48
_DEARER, _FINEST_SAMPLED = 15, 2.0**-8  # a cell of a loop with a clock

Interval = tuple[Expr, Expr]
_NONE = np.empty((0, 2, 2))


@dataclass(frozen=True, eq=False)
class HeldPlane:
    """Rectangles that fill a plane, (rectangles, 2, 2), in shares of both ranges.

    ``stable`` : for all of their values; ``unstable`` : for none; ``left`` : neither was shown.
    """

    stable: Array
    unstable: Array
    left: Array


def held_plane(
    scene: Scene,
    hands: Sequence[Hand],
    plane: Mapping[Symbol, Interval],
    others: Mapping[Symbol, Interval] | None = None,
    *,
    finest: float = 2.0**-8,
    most: int = 60_000,
) -> HeldPlane:
    """The plane of two numbers of display or hands, whatever ``others`` are. UndecidedError where nothing is known of it.

    ``hands`` : stable is what is so in all of them. ``finest`` : the share of a range down to which rectangles are cut;
    ``most`` : cells that are looked at.
    """
    ranges = {**plane, **(others or {})}
    if clocks(scene):
        sampled = [_Sampled(scene, x, OnCircle.of(scene, x, ranges)) for x in hands]
        clear, left = ClockPlane([x.form for x in sampled], max(finest, _FINEST_SAMPLED), most // _DEARER).rectangles()
        return _told(sampled, clear, left)
    loops = [_Loop(*quotient(scene, x, set(ranges)), ranges) for x in hands]
    if any(x.form.reach is None for x in loops):
        raise UndecidedError("whether roots come from infinity for some of the values")
    search = _Search([x.form for x in loops], finest, most)
    search.go()
    return _told(loops, np.concatenate([_NONE, *search.clear]), np.concatenate([_NONE, *search.left]))


def _told(loops: Sequence[_Loop | _Sampled], clear: Array, left: Array) -> HeldPlane:
    """Clear rectangles by the counts of those that touch each other."""
    label = together(clear)
    stable, unstable = np.zeros((2, len(clear)), bool)
    parts = sorted(set(label.tolist()), key=lambda n: -float(_areas(clear[label == n]).sum()))
    for n in parts[:_MOST_COUNTS]:
        own = clear[label == n]
        verdicts = [x.is_stable(own[np.argmax(_areas(own))]) for x in loops]
        stable[label == n], unstable[label == n] = all(verdicts), False in verdicts
    return HeldPlane(clear[stable], clear[unstable], np.concatenate([left, clear[~stable & ~unstable]]))


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Pieces of the frequencies, and of what else varies, (pieces, 1 + others, 2); ``owner`` : in which rectangle."""

    owner: Array
    rest: Array

    @classmethod
    def all(cls, count: int, sides: int) -> _Pieces:
        """Of so many rectangles."""
        edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, _FIRST_PIECES)])
        first = np.zeros((_FIRST_PIECES, sides - 2, 2))
        first[:, :, 1] = 1.0
        first[:, 0, 0], first[:, 0, 1] = edges[:-1], edges[1:]
        return cls(np.repeat(np.arange(count), _FIRST_PIECES), np.tile(first, (count, 1, 1)))

    def where(self, which: Array) -> _Pieces:
        return _Pieces(self.owner[which], self.rest[which])

    def cells(self, plane: Array) -> Array:
        """Of frequency, plane and the rest."""
        return np.concatenate([self.rest[:, :1], plane[self.owner], self.rest[:, 1:]], 1)

    def cut(self, which: Array, side: Array) -> _Pieces:
        """Some in halves, each along its side."""
        lower, upper, rows = self.rest[which], self.rest[which].copy(), np.arange(int(which.sum()))
        middle = lower[rows, side[which]].mean(-1)
        lower[rows, side[which], 1], upper[rows, side[which], 0] = middle, middle
        owner = np.concatenate([self.owner[~which], *[self.owner[which]] * 2])
        return _Pieces(owner, np.concatenate([self.rest[~which], lower, upper]))


@dataclass
class _Search:
    """Rectangles, as they are told."""

    forms: Sequence[OnAxis]
    finest: float
    most: int
    clear: list[Array] = field(default_factory=list)
    left: list[Array] = field(default_factory=list)
    looked: int = 0

    def go(self) -> None:
        """Cut until all is told, is small, or too much was looked at."""
        steps = np.arange(_FIRST_RECTANGLES + 1) / _FIRST_RECTANGLES
        sides = np.stack([steps[:-1], steps[1:]], -1)
        plane = np.array([[a, b] for a in sides for b in sides])
        pieces = [_Pieces.all(len(plane), x.sides) for x in self.forms]
        while len(plane):
            try:
                plane, pieces = self._round(plane, pieces)
            except LimitError:
                self.left.append(plane)
                break

    def _round(self, plane: Array, pieces: Sequence[_Pieces]) -> tuple[Array, list[_Pieces]]:
        """What is left of some rectangles, cut."""
        widths = plane[..., 1] - plane[..., 0]
        small = (widths <= self.finest).all(-1)
        doubtful, changes, found = np.zeros(len(plane), bool), np.zeros((len(plane), 2)), list[_Pieces]()
        for form, waiting in zip(self.forms, pieces, strict=True):
            own, rates = self._judged(form, plane, waiting, small)
            doubtful[own.owner] = True
            np.maximum.at(changes, own.owner, rates[:, 1:3])
            found.append(own)
        done = small | (self.looked > self.most)
        self.clear.append(plane[~doubtful])
        self.left.append(plane[doubtful & done])
        changes = np.where(widths > self.finest, changes + 1e-300 * widths, -1.0)
        return _halved(plane, np.flatnonzero(doubtful & ~done), np.argmax(changes, -1), found)

    def _judged(self, form: OnAxis, plane: Array, pieces: _Pieces, small: Array) -> tuple[_Pieces, Array]:
        """The pieces that stay in doubt, and how much D varies there: cut where it varies more along them than the rectangle.

        Of rectangles that are cut no further, pieces are cut some times more, whatever it varies along.
        """
        for n in range(1 + _AT_LAST):
            clear, rates = self._bounded(form, pieces.cells(plane))
            pieces, rates = pieces.where(~clear), rates[~clear]
            last = small[pieces.owner]
            own, many = np.delete(rates, [1, 2], -1), np.bincount(pieces.owner, minlength=len(plane))[pieces.owner]
            wide = (
                ~last & (many <= _MOST_PIECES) & (own.max(-1) >= rates[:, 1:3].max(-1) / 2)
                if n == 0
                else np.zeros_like(last)
            )
            which = wide | (last & (many <= 2 * _MOST_PIECES))
            if n == _AT_LAST or not which.any():
                break
            pieces = pieces.cut(which, np.argmax(own, -1))
        return pieces, rates

    def _bounded(self, form: OnAxis, cells: Array) -> tuple[Array, Array]:
        found = [(np.zeros(0, bool), np.zeros((0, form.sides)))]
        for i in range(0, len(cells), _BATCH):
            tick()
            found.append(form.bounded(cells[i : i + _BATCH]))
        self.looked += len(cells)
        clear, rates = (np.concatenate(x) for x in zip(*found, strict=True))
        return clear, rates


def _halved(plane: Array, which: Array, side: Array, pieces: Sequence[_Pieces]) -> tuple[Array, list[_Pieces]]:
    """Some rectangles in halves, each along its side, with the pieces that are theirs."""
    lower, upper, rows = plane[which].copy(), plane[which].copy(), np.arange(len(which))
    middle = plane[which, side[which]].mean(-1)
    lower[rows, side[which], 1], upper[rows, side[which], 0] = middle, middle
    number = np.full(len(plane), -1)
    number[which] = rows
    found = list[_Pieces]()
    for own in pieces:
        owner = number[own.owner]
        owner, rest = owner[owner >= 0], own.rest[owner >= 0]
        found.append(_Pieces(np.concatenate([owner, owner + len(which)]), np.concatenate([rest, rest])))
    return np.concatenate([lower, upper]), found


@dataclass(frozen=True)
class _Loop:
    """H_perc + Z of one hand as a quotient, over what varies."""

    ring: Ring
    top: Polynomial
    bottom: Polynomial
    ranges: Mapping[Symbol, Interval]

    @cached_property
    def form(self) -> OnAxis:
        """What is to have no zero on the axis."""
        return OnAxis(self.ring, self.top, self.ranges)

    def is_stable(self, rectangle: Array) -> bool | None:
        """Whether it is for all values of a clear rectangle (and of those that touch it), or for none; None where not known."""
        try:
            count = count_at(self.ring, self.top, _middle(self.ranges, rectangle))
        except (UndecidedError, LimitError):
            return None
        if not count:
            return None if count is None else True
        return False if self._shared is not None and count > self._shared else None

    @cached_property
    def _shared(self) -> int | None:
        """How many zeros in Re s >= 0 numerator and denominator may share: those of the latter; None where not known."""
        try:
            form = OnAxis(self.ring, self.bottom, self.ranges)
            if form.reach is None or len(form.left()):
                return None
            return count_at(self.ring, self.bottom, _middle(self.ranges, np.array([[0.0, 1.0], [0.0, 1.0]])))
        except (UndecidedError, LimitError):
            return None


@dataclass(frozen=True)
class _Sampled:
    """A loop with a clock in one hand."""

    scene: Scene
    hand: Hand
    form: OnCircle

    def is_stable(self, rectangle: Array) -> bool | None:
        """As of ``_Loop``."""
        values = _middle(self.form.ranges, rectangle)
        display = {p.path: values[p.symbol] for p in self.scene.parameters if p.symbol in values}
        own = {p.symbol.name: values[p.symbol] for p in self.hand.parameters if p.symbol in values}
        try:
            count = clocked_roots(self.scene.with_values(display), self.hand.with_values(own)).number
        except (HaptisymError, LimitError):
            return None
        return True if count == 0 else False if self.form.hides_none else None


def _middle(ranges: Mapping[Symbol, Interval], rectangle: Array) -> dict[Symbol, Expr]:
    """The values in the middle of a rectangle, and of what else varies."""
    middles = [Fraction(float(x)) for x in rectangle.mean(-1)]
    shares = [*middles, *[Fraction(1, 2)] * (len(ranges) - 2)]
    return {
        symbol: low + Rational(x.numerator, x.denominator) * (high - low)
        for (symbol, (low, high)), x in zip(ranges.items(), shares, strict=True)
    }


def _areas(rectangles: Array) -> Array:
    return (rectangles[..., 1] - rectangles[..., 0]).prod(-1)
