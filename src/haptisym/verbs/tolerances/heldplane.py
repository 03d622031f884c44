"""Held in a hand, all over the plane of two numbers: rectangles in which a display is stable for all values, or for none.

A rectangle is clear where the characteristic function is nowhere 0 on the imaginary axis, for any of its values nor any of what
else varies. Clear rectangles that touch have one number of unstable roots, which is counted exactly at one set of values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from sympy import Expr, Rational, Symbol

from haptisym.kernel.budget import tick
from haptisym.kernel.dynamics import Ring
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.rings import Polynomial
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.programs.taylormodels import Array
from haptisym.verbs.tolerances.heldbox import count_at, quotient
from haptisym.verbs.tolerances.onaxis import OnAxis
from haptisym.verbs.tolerances.search import together

_FIRST_RECTANGLES, _FIRST_PIECES = 8, 48
"""Of each range, and of the frequencies, to begin with."""
_BATCH = 4096
_MOST_PIECES = 48  # of one rectangle before it is cut rather than they
_MOST_COUNTS = 48

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
    hand: Hand,
    plane: Mapping[Symbol, Interval],
    others: Mapping[Symbol, Interval] | None = None,
    *,
    finest: float = 2.0**-8,
    most: int = 60_000,
) -> HeldPlane:
    """The plane of two numbers of display or hand, whatever ``others`` are. UndecidedError where nothing is known of it.

    ``finest`` : the share of a range down to which rectangles are cut; ``most`` : cells that are looked at.
    """
    ranges = {**plane, **(others or {})}
    ring, top, bottom = quotient(scene, hand, set(ranges))
    form = OnAxis(ring, top, ranges)
    if form.reach is None:
        raise UndecidedError("whether roots come from infinity for some of the values")
    search = _Search(form, finest, most)
    search.go()
    counted = _Counted(ring, top, bottom, ranges)
    return counted.told(np.concatenate([_NONE, *search.clear]), np.concatenate([_NONE, *search.left]))


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Pieces of the frequencies, and of what else varies, (pieces, 1 + others, 2); ``owner`` : in which rectangle."""

    owner: Array
    rest: Array

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

    form: OnAxis
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
        edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, _FIRST_PIECES)])
        first = np.zeros((_FIRST_PIECES, self.form.sides - 2, 2))
        first[:, :, 1] = 1.0
        first[:, 0, 0], first[:, 0, 1] = edges[:-1], edges[1:]
        pieces = _Pieces(np.repeat(np.arange(len(plane)), _FIRST_PIECES), np.tile(first, (len(plane), 1, 1)))
        while len(plane):
            try:
                plane, pieces = self._round(plane, pieces)
            except LimitError:
                self.left.append(plane)
                break

    def _round(self, plane: Array, pieces: _Pieces) -> tuple[Array, _Pieces]:
        """What is left of some rectangles, cut."""
        pieces, _ = self._judged(plane, pieces, again=True)
        pieces, rates = self._judged(plane, pieces, again=False)
        doubtful, changes = np.zeros(len(plane), bool), np.zeros((len(plane), 2))
        doubtful[pieces.owner] = True
        np.maximum.at(changes, pieces.owner, rates[:, 1:3])
        widths = plane[..., 1] - plane[..., 0]
        done = (widths <= self.finest).all(-1) | (self.looked > self.most)
        self.clear.append(plane[~doubtful])
        self.left.append(plane[doubtful & done])
        changes = np.where(widths > self.finest, changes + 1e-300 * widths, -1.0)
        return _halved(plane, np.flatnonzero(doubtful & ~done), np.argmax(changes, -1), pieces)

    def _judged(self, plane: Array, pieces: _Pieces, *, again: bool) -> tuple[_Pieces, Array]:
        """The pieces that stay in doubt, in halves those that vary along themselves more than the rectangle does."""
        clear, rates = self._bounded(pieces.cells(plane))
        pieces, rates = pieces.where(~clear), rates[~clear]
        if not again:
            return pieces, rates
        own = np.delete(rates, [1, 2], -1)
        few = np.bincount(pieces.owner, minlength=len(plane))[pieces.owner] <= _MOST_PIECES
        return pieces.cut(few & (own.max(-1) >= rates[:, 1:3].max(-1) / 2), np.argmax(own, -1)), rates

    def _bounded(self, cells: Array) -> tuple[Array, Array]:
        found = [(np.zeros(0, bool), np.zeros((0, self.form.sides)))]
        for i in range(0, len(cells), _BATCH):
            tick()
            found.append(self.form.bounded(cells[i : i + _BATCH]))
        self.looked += len(cells)
        clear, rates = (np.concatenate(x) for x in zip(*found, strict=True))
        return clear, rates


def _halved(plane: Array, which: Array, side: Array, pieces: _Pieces) -> tuple[Array, _Pieces]:
    """Some rectangles in halves, each along its side, with the pieces that are theirs."""
    lower, upper, rows = plane[which].copy(), plane[which].copy(), np.arange(len(which))
    middle = plane[which, side[which]].mean(-1)
    lower[rows, side[which], 1], upper[rows, side[which], 0] = middle, middle
    number = np.full(len(plane), -1)
    number[which] = rows
    owner = number[pieces.owner]
    owner, rest = owner[owner >= 0], pieces.rest[owner >= 0]
    found = _Pieces(np.concatenate([owner, owner + len(which)]), np.concatenate([rest, rest]))
    return np.concatenate([lower, upper]), found


@dataclass(frozen=True)
class _Counted:
    """Counts of roots in clear rectangles."""

    ring: Ring
    top: Polynomial
    bottom: Polynomial
    ranges: Mapping[Symbol, Interval]

    def told(self, clear: Array, left: Array) -> HeldPlane:
        """By the count of those that touch each other."""
        label = together(clear)
        numbers = np.full(len(clear), -1)
        parts = sorted(set(label.tolist()), key=lambda n: -_area(clear[label == n]))
        for n in parts[:_MOST_COUNTS]:
            own = clear[label == n]
            try:
                count = count_at(self.ring, self.top, self._values(own[np.argmax(_areas(own))]))
            except (UndecidedError, LimitError):
                continue
            numbers[label == n] = -1 if count is None else count
        least = self._shared() if (numbers > 0).any() else 0
        unstable = (numbers > 0) & (numbers > least if least is not None else False)
        return HeldPlane(
            clear[numbers == 0], clear[unstable], np.concatenate([left, clear[(numbers != 0) & ~unstable]])
        )

    def _values(self, rectangle: Array) -> dict[Symbol, Expr]:
        """In the middle of a rectangle, and of what else varies."""
        middles = [Fraction(float(x)) for x in rectangle.mean(-1)]
        shares = [*middles, *[Fraction(1, 2)] * (len(self.ranges) - 2)]
        return {
            symbol: low + Rational(x.numerator, x.denominator) * (high - low)
            for (symbol, (low, high)), x in zip(self.ranges.items(), shares, strict=True)
        }

    def _shared(self) -> int | None:
        """How many zeros in Re s >= 0 numerator and denominator may share: those of the latter; None where not known."""
        try:
            form = OnAxis(self.ring, self.bottom, self.ranges)
            if form.reach is None or len(form.left()):
                return None
            return count_at(self.ring, self.bottom, self._values(np.array([[0.0, 1.0], [0.0, 1.0]])))
        except (UndecidedError, LimitError):
            return None


def _areas(rectangles: Array) -> Array:
    return (rectangles[..., 1] - rectangles[..., 0]).prod(-1)


def _area(rectangles: Array) -> float:
    return float(_areas(rectangles).sum())
