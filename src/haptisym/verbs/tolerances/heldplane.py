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
from haptisym.kernel.errors import LimitError, UndecidedError
from haptisym.kernel.rings import Polynomial
from haptisym.model.caveats import clocks
from haptisym.model.hand import Hand
from haptisym.model.scene import Scene
from haptisym.programs.onaxis import OnAxis
from haptisym.programs.taylormodels import Array
from haptisym.verbs.stability.clocked import OnCircle
from haptisym.verbs.tolerances.clockplane import ClockPlane
from haptisym.verbs.tolerances.heldbox import count_at, quotient
from haptisym.verbs.tolerances.rectangles import Pieces, RectangleSearch
from haptisym.verbs.tolerances.search import together

_FIRST_PIECES = 48  # of the frequencies, to begin with
_BATCH = 4096
_MOST_PIECES = 48  # of one rectangle before it is cut rather than they
_AT_LAST = 5  # times that pieces of the smallest ones are cut
_MOST_COUNTS = 48
_DEARER, _FINEST_SAMPLED = 60, 2.0**-8  # a cell of a loop with a clock, by Taylor polynomials

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
        sampled = [_Sampled(OnCircle.of(scene, x, ranges)) for x in hands]
        clear, left = ClockPlane([x.form for x in sampled], max(finest, _FINEST_SAMPLED), most // _DEARER).rectangles()
        return _told(sampled, clear, left)
    loops = [_Loop(*quotient(scene, x, set(ranges)), ranges) for x in hands]
    if any(x.form.reach is None for x in loops):
        raise UndecidedError("whether roots come from infinity for some of the values")
    search = _Search(finest, most, [x.form for x in loops])
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


def _first(sides: int) -> Array:
    """Pieces of the frequencies, with all of what else varies."""
    edges = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, _FIRST_PIECES)])
    found = np.tile([0.0, 1.0], (_FIRST_PIECES, sides - 2, 1))
    found[:, 0, 0], found[:, 0, 1] = edges[:-1], edges[1:]
    return found


@dataclass
class _Search(RectangleSearch):
    """Rectangles that are clear of the zeros of all forms."""

    forms: Sequence[OnAxis]
    clear: list[Array] = field(default_factory=list)

    def go(self) -> None:
        """Tell all rectangles."""
        self._search([_first(x.sides) for x in self.forms])

    def _round(self, plane: Array, pieces: Sequence[Pieces]) -> tuple[Array, list[Pieces]]:
        small, doubtful, changes = self._small(plane), np.zeros(len(plane), bool), np.zeros((len(plane), 2))
        found = list[Pieces]()
        for form, waiting in zip(self.forms, pieces, strict=True):
            own, rates = self._judged(form, plane, waiting, small)
            doubtful[own.owner] = True
            np.maximum.at(changes, own.owner, rates[:, 1:3])
            found.append(own)
        self.clear.append(plane[~doubtful])
        return self._cut(plane, doubtful, changes, found)

    def _judged(self, form: OnAxis, plane: Array, pieces: Pieces, small: Array) -> tuple[Pieces, Array]:
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

    form: OnCircle

    def is_stable(self, rectangle: Array) -> bool | None:
        """As of ``_Loop``."""
        try:
            return self.form.is_stable(_middle(self.form.ranges, rectangle))
        except (UndecidedError, LimitError):
            return None


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
